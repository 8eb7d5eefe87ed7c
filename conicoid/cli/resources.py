"""What commands do alike, whatever their options are: files that are read and written, the scene made ready."""

from __future__ import annotations

import contextlib
import sys
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .terminal import EXIT_USAGE, PATIENCE, Bar, compile_notes, show_message

if TYPE_CHECKING:
    from ..io.ray_file import RayTable
    from ..scene.scene import Scene


_READ = 0.5
"""Bytes of a file for each step of reading it: its letters are gone through, and then its bodies."""
STDOUT = Path("-")
"""As the name of an output: standard output."""


@contextlib.contextmanager
def report_refused_files() -> Iterator[None]:
    """List the mistakes in a file, and end with exit code 2."""
    from .._util.file_errors import SceneFileError

    try:
        yield
    except SceneFileError as error:
        show_message(f"error: {error}" if len(error.problems) == 1 else f"{len(error.problems)} errors:\n{error}")
        raise SystemExit(EXIT_USAGE) from None


def load(path: Path, threads: int | None, outside: bool = False) -> Scene:
    """The scene in a file; so many threads from now on. outside: may textures lie outside of its folder?"""
    from ..scene.files import load as read

    refuse_stdin(path, "scenes")
    with report_refused_files(), show_warnings(), Bar("reading", "B", _READ) as bar:
        scene = read(path, progress=_progress(bar, lambda _: f"reading {path} ..."), outside=outside)
    if not scene.bodies:
        show_message(f"{path}: holds no bodies")
    if threads is not None:
        from ..kernels.threads import set_threads

        set_threads(threads)
    return scene


def prepare(scene: Scene) -> None:
    """Make a scene ready, with progress where that takes long."""
    from .._util.text import format_count

    with compile_notes(), Bar("preparing", "entry") as bar:
        scene.prepare(_progress(bar, lambda count: f"preparing {format_count(count, 'entry', 'entries')} ..."))


def _progress(bar: Bar, said: Callable[[int], str]) -> Callable[[int, int], None]:
    """Progress for a bar; where nobody watches that, one line after a second."""
    began, told = time.perf_counter(), False

    def progress(done: int, count: int) -> None:
        nonlocal told
        bar(done, count)
        if not told and time.perf_counter() - began > PATIENCE and not bar.console.is_terminal:
            show_message(said(count))
            told = True

    return progress


def check_folder(output: Path) -> None:
    """Refuse an output that cannot be written before the work, not after it."""
    if output == STDOUT:
        return
    if output.is_dir():
        raise IsADirectoryError(21, "is a directory", str(output))
    if output.exists() and not output.is_file():
        raise OSError(22, "is not a regular file", str(output))
    if not output.parent.is_dir():
        raise FileNotFoundError(2, "no such folder", str(output.parent))


def check_stdout(what: str) -> None:
    """Refuse to write bytes to a terminal."""
    if sys.stdout.isatty():
        raise ValueError(f"-: {what} is not for a terminal; send it to a file or to another program")


def refuse_stdin(path: Path, what: str) -> None:
    """ValueError for - in place of a file to read."""
    if path == STDOUT:
        raise ValueError(f"-: {what} are read from files, not from standard input; name a file")


def refuse_overwriting(output: Path, *read: Path) -> None:
    """ValueError where an output is one of the files that are read for it, which would be lost."""
    for path in read:
        if output != STDOUT and output.exists() and path.exists() and output.samefile(path):
            raise ValueError(f"{output}: is read for this and would be lost: choose another file for the results")


def rays_for(rays: Path, scene: Path, output: Path, suffixes: tuple[str, ...] = (".npz", ".csv")) -> RayTable:
    """The rays in a file, with what there is to say of them; an output that cannot be written is refused before.

    suffixes: those of results that the command writes, whatever the file of rays.
    """
    from ..io.ray_file import check_output, ray_notes, read_rays

    refuse_stdin(rays, "rays")
    if output != STDOUT:
        check_output(output, suffixes)
    check_folder(output)
    refuse_overwriting(output, scene, rays)
    table = read_rays(rays)
    for note in ray_notes(table):
        show_message(note)
    return table


def name_of(output: Path) -> str:
    """What messages call an output."""
    return "standard output" if output == STDOUT else str(output)


@contextlib.contextmanager
def write_output(output: Path, suffix: str) -> Iterator[Path]:
    """The file to write; what is for standard output goes there in the end, all of it."""
    if output != STDOUT:
        yield output
        return
    with tempfile.TemporaryDirectory(prefix="conicoid-") as folder:
        file = Path(folder) / f"output{suffix}"
        yield file
        _write_bytes(file.read_bytes())


def _write_bytes(content: bytes) -> None:
    """Bytes to standard output. Raises OSError that names it."""
    sys.stdout.flush()
    try:
        sys.stdout.buffer.write(content)
        sys.stdout.buffer.flush()
    except BrokenPipeError:
        raise
    except OSError as error:
        raise OSError(error.errno, error.strerror, "standard output") from None


@contextlib.contextmanager
def show_warnings() -> Iterator[None]:
    """Warnings as notes on stderr, a line each."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", UserWarning)
        yield
    for warning in caught:
        show_message(f"note: {warning.message}")


def count_rays(bar: Bar, count: int) -> Any:
    """Progress that is counted in tiles, shown in rays."""

    def progress(done: int, tiles: int) -> None:
        bar.scale = count / tiles
        bar(done, tiles)

    return progress


# Where commands do their work: here, on processes of this machine, or on a cluster of Dask.

_PATIENCE = "30s"


@contextlib.contextmanager
def executor_of(command: str, workers: int | None, cluster: str | None, slurm: int | None) -> Iterator[Any]:
    """The executor that the options ask for; None for this process."""
    given = [name for name, x in (("--workers", workers), ("--cluster", cluster), ("--slurm", slurm)) if x is not None]
    if len(given) > 1:
        raise ValueError(f"{command}: give either {' or '.join(given)}")
    if workers is not None:
        from ..parallel import Processes

        with Processes(workers) as pool:
            try:
                yield pool
            except BaseException:
                pool.shutdown(wait=False, cancel_futures=True)
                raise
    elif cluster is not None:
        with _client(command, cluster) as client:
            yield client
    elif slurm is not None:
        with _jobs(command, slurm) as client:
            yield client
    else:
        yield None


def _client(command: str, address: str) -> Any:
    try:
        from distributed import Client
    except ImportError:
        raise ImportError("--cluster needs Dask: pip install 'conicoid[cluster]'") from None
    try:
        return Client(address, timeout=_PATIENCE)
    except (OSError, ValueError, RuntimeError) as error:
        first = (str(error).splitlines() or [type(error).__name__])[0]
        raise ValueError(f"{command}: --cluster: no scheduler answers at {address[:80]!r} ({first})") from None


@contextlib.contextmanager
def _jobs(command: str, count: int) -> Iterator[Any]:
    """A client of a scheduler here whose workers are jobs of Slurm; they are cancelled in the end."""
    try:
        from dask_jobqueue import SLURMCluster
        from distributed import Client
    except ImportError:
        raise ImportError("--slurm needs dask-jobqueue: pip install dask-jobqueue 'conicoid[cluster]'") from None
    try:
        made = SLURMCluster(scheduler_options={"dashboard_address": ":0"})
    except (ValueError, TypeError) as error:
        told = " ".join(str(error).split())[:200]
        raise ValueError(f"{command}: --slurm: what a job takes is said in Dask's jobqueue.yaml ({told})") from None
    with made as jobs, Client(jobs, timeout=_PATIENCE) as client:
        jobs.scale(jobs=count)
        yield client
