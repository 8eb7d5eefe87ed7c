"""What commands share: files that are read and written, threads, options that go together, the scene made ready."""

from __future__ import annotations

import contextlib
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperGroup

from .exit_codes import MISTAKE
from .terminal import PATIENCE, Bar, compile_notes, say

if TYPE_CHECKING:
    from ..scene import Scene


class Commands(TyperGroup):
    """The commands; what they say of their arguments is never longer than a screen."""

    def invoke(self, ctx: Any) -> Any:
        try:
            return super().invoke(ctx)
        except Exception as error:
            message = getattr(error, "message", None)
            if isinstance(message, str) and len(message) > _LONGEST:
                error.message = f"{message[: _LONGEST // 2]} ... {message[-_LONGEST // 2 :]}"  # type: ignore[attr-defined]
            raise


_LONGEST = 600
_READ = 0.5
"""Bytes of a file for each step of reading it: its letters are gone through, and then its bodies."""
SceneFile = Annotated[Path, typer.Argument(metavar="SCENE", help="A scene file, YAML or JSON.", show_default=False)]
Threads = Annotated[int | None, typer.Option(min=1, help="Threads to use.", show_default="all cores")]
STDOUT = Path("-")
"""As the name of an output: standard output."""


@contextlib.contextmanager
def refused_files() -> Iterator[None]:
    """List the mistakes in a file, and end with exit code 2."""
    from ..formats.errors import SceneFileError

    try:
        yield
    except SceneFileError as error:
        say(f"error: {error}" if len(error.problems) == 1 else f"{len(error.problems)} errors:\n{error}")
        raise SystemExit(MISTAKE) from None


def load(path: Path, threads: int | None) -> Scene:
    """The scene in a file; so many threads from now on."""
    from ..files import load as read

    refuse_stdin(path, "scenes")
    with refused_files(), Bar("reading", "B", _READ) as bar:
        scene = read(path, progress=_told(bar, lambda _: f"reading {path} ..."))
    if not scene.bodies:
        say(f"{path}: holds no bodies")
    if threads is not None:
        from ..engine.threads import set_threads

        set_threads(threads)
    return scene


def prepare(scene: Scene, *jobs: str) -> None:
    """Make a scene ready, with progress where that takes long; `jobs` are kernels to compile meanwhile."""
    from ..compiler.ahead import expect
    from ..shapes.labels import counted

    if jobs:
        expect(*jobs)
    with compile_notes(), Bar("preparing", "entry") as bar:
        scene.prepare(_told(bar, lambda count: f"preparing {counted(count, 'entry', 'entries')} ..."))


def _told(bar: Bar, said: Callable[[int], str]) -> Callable[[int, int], None]:
    """Progress for a bar; where nobody watches that, one line after a second."""
    began, told = time.perf_counter(), False

    def progress(done: int, count: int) -> None:
        nonlocal told
        bar(done, count)
        if not told and not bar.console.is_terminal and time.perf_counter() - began > PATIENCE:
            say(said(count))
            told = True

    return progress


def only_with(context: typer.Context, other: str, given: bool, *names: str) -> None:
    """Refuse options that would be ignored: those named go with another alone."""
    for name in names:
        source = context.get_parameter_source(name)
        if not given and source is not None and source.name != "DEFAULT":
            option = "--" + name.replace("_", "-")
            raise ValueError(f"{context.info_name}: {option} goes with {other}; it would be ignored")


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


def name_of(output: Path) -> str:
    """What messages call an output."""
    return "standard output" if output == STDOUT else str(output)


@contextlib.contextmanager
def written(output: Path, suffix: str) -> Iterator[Path]:
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


def in_rays(bar: Bar, count: int) -> Any:
    """Progress that is counted in tiles, shown in rays."""

    def progress(done: int, tiles: int) -> None:
        bar.scale = count / tiles
        bar(done, tiles)

    return progress
