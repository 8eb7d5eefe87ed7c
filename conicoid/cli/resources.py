"""Files that commands read and write, the scene with its preparation, warnings, and executors."""

from __future__ import annotations

import contextlib
import sys
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .._util.lazy_names import import_extra
from .terminal import EXIT_USAGE, PATIENCE, Bar, show_message

if TYPE_CHECKING:
    from ..io.ray_file import RayFile
    from ..scene.scene import Scene


_READ = 0.5
"""Bytes of a file for each step of progress: a file is read twice, its text and then its bodies."""
STDOUT = Path("-")
"""The name of an output that stands for standard output."""


@contextlib.contextmanager
def report_refused_files() -> Iterator[None]:
    """Print the mistakes in a file, and end with exit code 2."""
    from .._util.files import SceneFileError

    try:
        yield
    except SceneFileError as error:
        show_message(f"error: {error}" if len(error.problems) == 1 else f"{len(error.problems)} errors:\n{error}")
        raise SystemExit(EXIT_USAGE) from None


def load(path: Path, threads: int | None, outside: bool = False, glasses: Path | None = None) -> Scene:
    """Return the scene in a file, and set the number of threads.

    outside: textures may lie outside of the folder of the file. glasses: a catalogue for a lens file.
    """
    from ..io.importers import detect_format
    from ..scene.files import load as read

    refuse_stdin(path, "scenes")
    with report_refused_files(), show_warnings(), Bar("reading", "B", _READ) as bar:
        options = {} if glasses is None else {"glasses": glasses}
        if options and detect_format(path) is None:
            raise ValueError(f"{path}: --glasses goes with a lens file; it would be ignored")
        scene = read(path, progress=_progress(bar, lambda _: f"reading {path} ..."), outside=outside, **options)
    if not scene.bodies:
        show_message(f"{path}: holds no bodies")
    if threads is not None:
        from ..kernels.threads import set_threads

        set_threads(threads)
    return scene


def prepare(scene: Scene) -> None:
    """Prepare a scene, with progress if that takes long."""
    from .._util.text import format_count

    with Bar("preparing", "entry") as bar:
        scene.prepare(_progress(bar, lambda count: f"preparing {format_count(count, 'entry', 'entries')} ..."))


def _progress(bar: Bar, message: Callable[[int], str]) -> Callable[[int, int], None]:
    """Return progress for a bar; without a terminal, one line after a second in its place."""
    began, shown = time.perf_counter(), False

    def progress(done: int, count: int) -> None:
        nonlocal shown
        bar(done, count)
        if not shown and time.perf_counter() - began > PATIENCE and not bar.console.is_terminal:
            show_message(message(count))
            shown = True

    return progress


def check_folder(output: Path, *read: Path) -> None:
    """Raise OSError for an output that cannot be written, ValueError for one of the files `read`; before the work."""
    if output == STDOUT:
        return
    if output.is_dir():
        raise IsADirectoryError(21, "is a directory", str(output))
    if output.exists() and not output.is_file():
        raise OSError(22, "is not a regular file", str(output))
    if not output.parent.is_dir():
        raise FileNotFoundError(2, "no such folder", str(output.parent))
    refuse_overwriting(output, *read)


def check_stdout(what: str) -> None:
    """Raise ValueError for bytes to a terminal."""
    if sys.stdout.isatty():
        raise ValueError(f"-: {what} is not for a terminal; send it to a file or to another program")


def refuse_stdin(path: Path, what: str) -> None:
    """Raise ValueError for - in place of a file to read."""
    if path == STDOUT:
        raise ValueError(f"-: {what} are read from files, not from standard input; name a file")


def refuse_overwriting(output: Path, *read: Path) -> None:
    """Raise ValueError for an output that is one of the input files, which would be lost."""
    for path in read:
        if output != STDOUT and output.exists() and path.exists() and output.samefile(path):
            raise ValueError(f"{output}: is read for this and would be lost: choose another file for the results")


def ray_file(
    rays: Path, scene: Path, output: Path, t_min: float | None, t_max: float | None, suffixes: tuple[str, ...],
    whole: bool = True, resumed: bool = False,
) -> RayFile:  # fmt: skip
    """Open a file of rays, and print notes on it; refuse an output that cannot be written before.

    suffixes: those of results that the command writes, whatever the file of rays. whole: all rays must fit into memory.
    resumed: whether the output may be the folder of an earlier run, which `result_writer` knows.
    """
    from ..io.array_file import check_output
    from ..io.ray_file import RayFile

    refuse_stdin(rays, "rays")
    if output != STDOUT:
        check_output(output, suffixes)
    if not resumed:
        check_folder(output)
    refuse_overwriting(output, scene, rays)
    file = RayFile(rays, whole)
    file.check_limits(t_min, t_max)
    for note in file.notes():
        show_message(note)
    return file


def name_of(output: Path) -> str:
    """Return the name of an output in messages."""
    return "standard output" if output == STDOUT else str(output)


@contextlib.contextmanager
def write_output(output: Path, suffix: str) -> Iterator[Path]:
    """Yield the file to write; for standard output, write its whole content there at the end."""
    if output != STDOUT:
        yield output
        return
    with tempfile.TemporaryDirectory(prefix="conicoid-") as folder:
        file = Path(folder) / f"output{suffix}"
        yield file
        # All at once, after success: a reader gets no part of a failed result
        _write_bytes(file.read_bytes())


def _write_bytes(content: bytes) -> None:
    """Write bytes to standard output; an OSError names it."""
    sys.stdout.flush()  # text that is still in its buffer goes first
    try:
        sys.stdout.buffer.write(content)
        sys.stdout.buffer.flush()
    except BrokenPipeError:
        raise  # it has an exit code of its own
    except OSError as error:
        raise OSError(error.errno, error.strerror, "standard output") from None


@contextlib.contextmanager
def show_warnings() -> Iterator[None]:
    """Print warnings as notes on stderr, a line each."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", UserWarning)
        yield
    for warning in caught:
        show_message(f"note: {warning.message}")


def count_rays(bar: Bar, count: int) -> Any:
    """Return progress for a bar that counts rays, from progress in tiles."""

    def progress(done: int, tiles: int) -> None:
        bar.scale = count / tiles
        bar(done, tiles)

    return progress


# --- Executors

_PATIENCE = "30s"
"""The longest wait for a scheduler."""


@contextlib.contextmanager
def executor_of(command: str, workers: int | None, cluster: str | None, slurm: int | None) -> Iterator[Any]:
    """Yield the executor of the options: processes of this machine, Dask or Slurm; None for this process."""
    flags = [name for name, x in (("--workers", workers), ("--cluster", cluster), ("--slurm", slurm)) if x is not None]
    if len(flags) > 1:
        raise ValueError(f"{command}: give either {' or '.join(flags)}")
    if workers is not None:
        from ..parallel import Processes

        with Processes(workers) as pool:
            try:
                yield pool
            except BaseException:  # Ctrl-C too: do not wait for tasks that are under way
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
    """Return a client of a Dask scheduler."""
    distributed = import_extra("distributed", "--cluster needs Dask", "cluster")
    try:
        return distributed.Client(address, timeout=_PATIENCE)
    except (OSError, ValueError, RuntimeError) as error:
        first = (str(error).splitlines() or [type(error).__name__])[0]
        raise ValueError(f"{command}: --cluster: no scheduler answers at {address[:80]!r} ({first})") from None


@contextlib.contextmanager
def _jobs(command: str, count: int) -> Iterator[Any]:
    """Yield a client of a scheduler here whose workers are Slurm jobs; the jobs are cancelled at the end."""
    try:
        from dask_jobqueue import SLURMCluster
        from distributed import Client
    except ImportError:
        raise ImportError("--slurm needs dask-jobqueue: pip install dask-jobqueue 'conicoid[cluster]'") from None
    try:
        # The dashboard takes any free port: another scheduler may run on this machine
        slurm_cluster = SLURMCluster(scheduler_options={"dashboard_address": ":0"})
    except (ValueError, TypeError) as error:
        cause = " ".join(str(error).split())[:200]
        raise ValueError(
            f"{command}: --slurm: Dask's jobqueue.yaml must state the resources of a job ({cause})"
        ) from None
    with slurm_cluster as jobs, Client(jobs, timeout=_PATIENCE) as client:
        jobs.scale(jobs=count)
        yield client
