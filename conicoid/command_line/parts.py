"""What commands share: files that are read and written, threads, options that go together, the scene made ready."""

from __future__ import annotations

import contextlib
import itertools
import sys
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperCommand, TyperGroup

from .exit_codes import MISTAKE
from .terminal import PATIENCE, Bar, compile_notes, say

if TYPE_CHECKING:
    from ..formats.ray_file import RayTable
    from ..scene import Scene


class Commands(TyperGroup):
    """The commands; what they say of their arguments is never longer than a screen."""

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        if args and args[0] == "help":
            return super().resolve_command(ctx, [*args[1:2], "--help"]) if args[1:] else self._show_help(ctx)
        if args and args[0] in _NOT_COMMANDS:
            ctx.fail(f"No such command {args[0]!r}: {_NOT_COMMANDS[args[0]]}.")
        if args and args[0] in _COMMANDS:
            ctx.fail(f"No such command {args[0]!r}: conicoid {_COMMANDS[args[0]]} does that.")
        return super().resolve_command(ctx, args)

    def _show_help(self, ctx: Any) -> Any:
        typer.echo(ctx.get_help())
        ctx.exit()

    def invoke(self, ctx: Any) -> Any:
        try:
            return super().invoke(ctx)
        except Exception as error:
            message = getattr(error, "message", None)
            if isinstance(message, str) and len(message) > _LONGEST:
                error.message = f"{message[: _LONGEST // 2]} ... {message[-_LONGEST // 2 :]}"  # type: ignore[attr-defined]
            raise


_LONGEST = 600
_COMMANDS = {
    "check": "info SCENE --check", "volume": "measure", "volumes": "measure", "spans": "trace --spans",
    "section": "slice", "plot": "slice", "show": "view", "version": "--version",
    "validate": "info SCENE", "lint": "info SCENE", "hits": "trace", "first_hit": "trace",
    "line_integral": "lengths --property", "project": "lengths --property", "gif": "turntable",
    "movie": "turntable or animate", "film": "animate",
}  # fmt: skip
"""Commands that one may look for, and those that there are."""
_NOT_COMMANDS = {
    "convert": "conicoid import reads files of other programs, conicoid export writes them, and in Python "
    "scene.save(path) writes .yaml and .json",
    "gallery": "`make demo` in the repository renders the gallery",
    "crossings": "conicoid trace --spans has the ends of each stretch, in Python scene.crossings(rays) all crossings",
}
"""Commands that one may look for, and what there is instead."""
_NOT_OPTIONS = {
    "--crossings": "--spans has both ends of each stretch, and in Python scene.crossings(rays) all crossings",
    **dict.fromkeys(
        ("--origin", "--direction", "--ray"),
        "rays are read from a file, such as a .csv with a line x,y,z,dx,dy,dz for each",
    ),
}
"""Options that one may look for, and what there is instead."""
_OPTIONS = {
    "--fov": ("--field-of-view",), "--size": ("--width", "--height"), "--resolution": ("--width", "--height"),
    "--camera": ("--position", "--look-at"), "--eye": ("--position",), "--target": ("--look-at",),
    "--spp": ("--samples",), "--out": ("--output",),
}  # fmt: skip
"""Options as they are called elsewhere, and here."""


class Command(TyperCommand):
    """A command that takes each option once: of two values the first would be lost without a word."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        args = self._with_whole_numbers(ctx, self._with_output_last(args))
        try:
            _, _, given = self.make_parser(ctx).parse_args(args=list(args))
        except Exception as error:
            name = getattr(error, "option_name", None)
            if name in _OPTIONS and set(_OPTIONS[name]) <= set(self._names):
                error.possibilities = list(_OPTIONS[name])  # type: ignore[attr-defined]
            if name in _NOT_OPTIONS and name not in self._names:
                ctx.fail(f"No such option: {name}: {_NOT_OPTIONS[name]}")
            raise
        for option in given:
            if option.param_type_name == "option" and not option.multiple and given.count(option) > 1:
                name = max(option.opts, key=len)
                ctx.fail(f"{name} is given {_times(given.count(option))}: only the last would count")
        try:
            return super().parse_args(ctx, list(args))  # which it empties
        except Exception as error:
            if hint := self._meant(error, args):
                ctx.fail(f"{getattr(error, 'format_message', error.__str__)().rstrip('.')}: {hint}")
            raise

    def _with_output_last(self, args: list[str]) -> list[str]:
        """Of a command whose output is an argument: -o and --output may be written as in all others."""
        named = next((name for name in ("-o", "--output") if name in args[:-1] and name not in self._names), None)
        if named is None or not any(one.name == "output" and one.param_type_name == "argument" for one in self.params):
            return args
        at = args.index(named)
        return [*args[:at], *args[at + 2 :], args[at + 1]]

    def _with_whole_numbers(self, ctx: Any, args: list[str]) -> list[str]:
        """1e6 as 1000000 for options that take integers; what is no whole number is refused by its name."""
        whole = {
            name
            for one in self.params
            if getattr(getattr(one, "type_descriptor", None), "annotation", None) is int
            for name in one.opts
        }
        written = list(args)
        for place, (name, text) in enumerate(itertools.pairwise(args)):
            if name not in whole or text.lstrip("+-").isdigit() or text.startswith("--"):
                continue
            try:
                number = float(text)
            except ValueError:
                number = 0.5
            if not number.is_integer() or abs(number) > 2**63:
                ctx.fail(f"Invalid value for {name!r}: must be a whole number, got {text[:40]!r}")
            written[place + 1] = str(int(number))
        return written

    def _meant(self, error: Exception, args: list[str]) -> str:
        """What to tell where a command does not fit."""
        text = getattr(error, "message", "") or ""
        vectors = [name for name in ("--position", "--look-at", "--up") if name in args]
        if text.startswith("Got unexpected extra argument") and vectors:
            return f"three numbers are written with commas, {vectors[0]} 1,2,3"
        missing = getattr(getattr(error, "param", None), "name", "")
        if missing == "output" and args and Path(args[-1]).suffix and len(args) > 1 and "-o" in self._names:
            return f"write -o {args[-1]}"
        return ""

    @property
    def _names(self) -> list[str]:
        return [name for option in self.params for name in option.opts]


def _times(count: int) -> str:
    return "twice" if count == 2 else f"{count} times"


_READ = 0.5
"""Bytes of a file for each step of reading it: its letters are gone through, and then its bodies."""
SceneFile = Annotated[Path, typer.Argument(metavar="SCENE", help="A scene file, YAML or JSON.", show_default=False)]
Threads = Annotated[int | None, typer.Option(min=1, help="Threads to use.", show_default="all cores")]
RayFile = Annotated[
    Path,
    typer.Argument(
        metavar="RAYS", help="Rays: .npy, .npz or .csv; for trace also .parquet, .zarr.", show_default=False
    ),
]
TMin = Annotated[float | None, typer.Option("--t-min", help="Where rays begin, in units of the direction's length.",
                                            show_default="0")]  # fmt: skip
TMax = Annotated[float | None, typer.Option("--t-max", help="Where rays end.", show_default="inf")]
Results = Annotated[
    Path,
    typer.Option("--output", "-o", help="The results, .npz or .csv; - is .csv on standard output.", show_default=False),
]
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


def load(path: Path, threads: int | None, outside: bool = False) -> Scene:
    """The scene in a file; so many threads from now on. outside: may textures lie outside of its folder?"""
    from ..files import load as read

    refuse_stdin(path, "scenes")
    with refused_files(), said_warnings(), Bar("reading", "B", _READ) as bar:
        scene = read(path, progress=_told(bar, lambda _: f"reading {path} ..."), outside=outside)
    if not scene.bodies:
        say(f"{path}: holds no bodies")
    if threads is not None:
        from ..engine.threads import set_threads

        set_threads(threads)
    return scene


def prepare(scene: Scene) -> None:
    """Make a scene ready, with progress where that takes long."""
    from ..shapes.labels import counted

    with compile_notes(), Bar("preparing", "entry") as bar:
        scene.prepare(_told(bar, lambda count: f"preparing {counted(count, 'entry', 'entries')} ..."))


def _told(bar: Bar, said: Callable[[int], str]) -> Callable[[int, int], None]:
    """Progress for a bar; where nobody watches that, one line after a second."""
    began, told = time.perf_counter(), False

    def progress(done: int, count: int) -> None:
        nonlocal told
        bar(done, count)
        if not told and time.perf_counter() - began > PATIENCE and not bar.console.is_terminal:
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


def rays_for(rays: Path, scene: Path, output: Path, suffixes: tuple[str, ...] = (".npz", ".csv")) -> RayTable:
    """The rays in a file, with what there is to say of them; an output that cannot be written is refused before.

    suffixes: those of results that the command writes, whatever the file of rays.
    """
    from ..formats.ray_file import check_output, ray_notes, read_rays

    refuse_stdin(rays, "rays")
    if output != STDOUT:
        check_output(output, suffixes)
    check_folder(output)
    refuse_overwriting(output, scene, rays)
    table = read_rays(rays)
    for note in ray_notes(table):
        say(note)
    return table


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


@contextlib.contextmanager
def said_warnings() -> Iterator[None]:
    """Warnings as notes on stderr, a line each."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", UserWarning)
        yield
    for warning in caught:
        say(f"note: {warning.message}")


def in_rays(bar: Bar, count: int) -> Any:
    """Progress that is counted in tiles, shown in rays."""

    def progress(done: int, tiles: int) -> None:
        bar.scale = count / tiles
        bar(done, tiles)

    return progress
