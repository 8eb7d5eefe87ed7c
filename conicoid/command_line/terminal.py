"""How the command line speaks: results on stdout, everything else on stderr, progress only to a person."""

from __future__ import annotations

import contextlib
import sys
import time
from collections.abc import Iterator
from functools import cached_property
from typing import TYPE_CHECKING

from .exit_codes import CLOSED, FAILED, INTERRUPTED, MISTAKE, code_of

if TYPE_CHECKING:
    from rich.console import Console, RenderableType
    from rich.progress import Progress
    from rich.table import Table
    from rich.text import Text

PATIENCE = 1.0
"""Seconds before a progress bar appears."""
SCREEN = 1800
"""Letters of a message, at most."""


def console() -> Console:
    """stderr; plain text where it is not a terminal."""
    from rich.console import Console

    return Console(stderr=True, highlight=False, soft_wrap=True)


def say(message: str) -> None:
    """A line on stderr, as it is: no markup."""
    sys.stderr.write(f"{message}\n")
    sys.stderr.flush()


def fitted(message: str) -> str:
    """A message without its middle, where that would be longer than a screen: names may be as long as one likes."""
    half = SCREEN // 2
    return message if len(message) <= SCREEN else f"{message[:half]} ... {message[-half:]}"


def first_cause(error: BaseException) -> str:
    """The first line of what went wrong first: packages wrap what their own libraries say in pages of advice."""
    while isinstance(
        before := error.__cause__ or (None if error.__suppress_context__ else error.__context__), ImportError
    ):
        error = before
    return str(error).strip().partition("\n")[0]


@contextlib.contextmanager
def user_mistakes() -> Iterator[None]:
    """Turn what goes wrong into its message and one of `exit_codes`; bugs keep their traceback."""
    try:
        yield
    except KeyboardInterrupt:
        say("interrupted")
        raise SystemExit(INTERRUPTED) from None
    except BrokenPipeError:
        raise SystemExit(CLOSED) from None
    except OSError as error:
        name = f"{error.filename}: " if error.filename else ""
        say(f"error: {fitted(name + (error.strerror or str(error)).lower())}")
        raise SystemExit(code_of(error)) from None
    except ValueError as error:
        say(f"error: {fitted(str(error))}")
        raise SystemExit(MISTAKE) from None
    except MemoryError as error:
        say(": ".join(filter(None, ("error: not enough memory for this", str(error)))))
        raise SystemExit(FAILED) from None
    except ImportError as error:
        say(f"error: {first_cause(error)}")
        raise SystemExit(FAILED) from None


@contextlib.contextmanager
def compile_notes() -> Iterator[None]:
    """Say once, while it happens, that kernels are being compiled."""
    from ..compiler.jit import on_compile

    told: list[float] = []

    def note(name: str) -> None:
        if not told:
            told.append(time.perf_counter())
            say("compiling kernels, which later runs find in the cache: up to a minute ...")

    with on_compile(note):
        yield


class Bar:
    """A progress bar with rate and time left, on stderr; silent for a second, and where stderr is not a terminal."""

    def __init__(self, what: str, unit: str, scale: float = 1.0) -> None:
        self.what, self.unit, self.scale = what, unit, scale
        self.started = time.perf_counter()
        self.note = ""
        """What else the line says."""
        self.picture: Text | None = None
        """What is drawn above the line."""
        self.progress: Progress | None = None

    @cached_property
    def console(self) -> Console:
        """Made when it is needed: what ends within a second does not import what draws bars."""
        return console()

    def __enter__(self) -> Bar:
        return self

    def __exit__(self, *_: object) -> None:
        if self.progress is not None:
            self.progress.stop()

    def __call__(self, done: int, count: int) -> None:
        """`done` of `count` steps are finished; each is `scale` units of work."""
        if time.perf_counter() - self.started < PATIENCE or not self.console.is_terminal:
            return
        if self.progress is None:
            self.progress = _bar(self)
            self.progress.add_task(self.what, total=count, unit=self.unit, scale=self.scale, rate="")
            self.progress.start()
        rate = done * self.scale / (time.perf_counter() - self.started)
        task = self.progress.task_ids[0]
        self.progress.update(task, completed=done, total=count, rate=f"{with_prefix(rate)}{self.unit}/s{self.note}")


def _bar(bar: Bar) -> Progress:
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

    class UnderPicture(Progress):
        """The line, and above it what the bar has to show."""

        def get_renderables(self) -> Iterator[RenderableType]:
            if bar.picture is not None:
                yield bar.picture
            yield from super().get_renderables()

    return UnderPicture(
        TextColumn("{task.description}"),
        BarColumn(),
        TaskProgressColumn(),
        TextColumn("{task.fields[rate]}"),
        TimeRemainingColumn(),
        console=bar.console,
        transient=True,
    )


def with_prefix(value: float) -> str:
    """A number with three digits and a prefix: 1.23 M."""
    for size, prefix in ((1e9, "G"), (1e6, "M"), (1e3, "k")):
        if value >= size:
            return f"{value / size:.3g} {prefix}"
    return f"{value:.3g} "


def show_table(table: Table, about: list[str]) -> None:
    """A table and lines below it, on stdout, as wide as they need to be."""
    from rich.console import Console

    wide = Console(highlight=False, soft_wrap=True, width=None if sys.stdout.isatty() else 200)
    wide.print(table)
    for line in about:
        wide.print(line, markup=False)
