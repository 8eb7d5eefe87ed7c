"""With which code the command `conicoid` ends, and why."""

from __future__ import annotations

import contextlib
import errno
import io
import os
import sys
import time
from collections.abc import Iterator
from functools import cached_property
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.console import Console, RenderableType
    from rich.progress import Progress
    from rich.table import Table
    from rich.text import Text


EXIT_OK = 0
EXIT_FAILURE = 1
"""The machine's fault, not the input's: a full disk, too little memory, a package that is missing; or a bug."""
EXIT_USAGE = 2
"""The input's, or the command line's: a message says what is wrong, and nothing is written."""
EXIT_FINDINGS = 3
"""A check has found something: what was asked for is done, and says that a person should look."""
EXIT_INTERRUPT = 130
"""By Ctrl-C: 128 and the number of the signal, as shells have it."""
EXIT_PIPE = 141
"""Nobody reads the results any more (`| head`): what a program has that SIGPIPE ends."""

_OF_PATHS = frozenset(
    getattr(errno, name)
    for name in (
        "EACCES", "EADDRINUSE", "EADDRNOTAVAIL", "EEXIST", "EINVAL", "EISDIR", "ELOOP", "ENAMETOOLONG", "ENODEV",
        "ENOENT", "ENOTDIR", "ENXIO", "EPERM", "EROFS", "ETXTBSY",
    )
    if hasattr(errno, name)
)  # fmt: skip
"""What is wrong with a name that was given: there is no such file, a folder is none, a port is taken."""


def exit_code(error: OSError) -> int:
    """MISTAKE where another name would do, else FAILED."""
    return EXIT_USAGE if error.errno in _OF_PATHS else EXIT_FAILURE


# How the command line speaks: results on stdout, everything else on stderr, progress only to a person.

PATIENCE = 1.0
"""Seconds before a progress bar appears."""
SCREEN = 1800
"""Letters of a message, at most."""


def console() -> Console:
    """stderr; plain text where it is not a terminal."""
    from rich.console import Console

    return Console(stderr=True, highlight=False, soft_wrap=True)


def show_message(message: str) -> None:
    """A line on stderr, as it is: no markup."""
    sys.stderr.write(f"{message}\n")
    sys.stderr.flush()


def shorten_message(message: str) -> str:
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
        show_message("interrupted")
        raise SystemExit(EXIT_INTERRUPT) from None
    except BrokenPipeError:
        raise SystemExit(EXIT_PIPE) from None
    except OSError as error:
        name = f"{error.filename}: " if error.filename else ""
        show_message(f"error: {shorten_message(name + (error.strerror or str(error)).lower())}")
        raise SystemExit(exit_code(error)) from None
    except ValueError as error:
        show_message(f"error: {shorten_message(str(error))}")
        raise SystemExit(EXIT_USAGE) from None
    except MemoryError as error:
        show_message(": ".join(filter(None, ("error: not enough memory for this", str(error)))))
        raise SystemExit(EXIT_FAILURE) from None
    except ImportError as error:
        show_message(f"error: {first_cause(error)}")
        raise SystemExit(EXIT_FAILURE) from None


@contextlib.contextmanager
def compile_notes() -> Iterator[None]:
    """Say once, while it happens, that kernels are being compiled."""
    from .._jit.decorators import on_compile

    told: list[float] = []

    def note(name: str) -> None:
        if not told:
            told.append(time.perf_counter())
            show_message("compiling kernels, which later runs find in the cache: up to a minute ...")

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
        self.progress.update(task, completed=done, total=count, rate=f"{format_si(rate)}{self.unit}/s{self.note}")


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


def format_si(value: float) -> str:
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


# stdout and stderr of the command `conicoid`, whatever they are: a pipe that nobody reads, a full disk, or closed.
#
# Results that cannot be written are an error. Messages that cannot are not: what was asked for is done.


class _Stream(io.TextIOWrapper):
    """A text stream that loses what it cannot write, once it has been told of."""

    def write(self, text: str) -> int:
        try:
            return super().write(text)
        except OSError as error:
            self._give_up(error)
            return len(text)

    def flush(self) -> None:
        try:
            super().flush()
        except OSError as error:
            self._give_up(error)

    def _give_up(self, error: OSError) -> None:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, self.fileno())
        os.close(nowhere)
        self.tell_of(error)

    def tell_of(self, error: OSError) -> None:
        """Say what went wrong."""


class ResultStream(_Stream):
    """Raises SystemExit where nobody reads on, else OSError."""

    def tell_of(self, error: OSError) -> None:
        if error.errno == errno.EPIPE:
            raise SystemExit(EXIT_PIPE) from None
        raise OSError(error.errno, error.strerror, "standard output") from None


class MessageStream(_Stream):
    """Raises nothing."""


def open_streams() -> None:
    """Put them in place of Python's own, which are None where a stream is closed."""
    for number, mode in ((0, os.O_RDONLY), (1, os.O_RDONLY), (2, os.O_WRONLY)):
        try:
            os.fstat(number)
        except OSError:  # else the next file would get its number, and what is said would be written there
            os.open(os.devnull, mode)  # what is closed cannot be written: of stdout that is to be noticed
    sys.stdout = _in_place_of(sys.stdout, 1, ResultStream)
    sys.stderr = _in_place_of(sys.stderr, 2, MessageStream)


def _in_place_of(stream: Any, number: int, kind: type[_Stream]) -> _Stream:
    """A terminal that knows ASCII only is no mistake."""
    bytes_ = io.BufferedWriter(io.FileIO(number, "w", closefd=False)) if stream is None else stream.buffer
    encoding = "utf-8" if stream is None else stream.encoding
    lines = number == 2 or os.isatty(number)
    return kind(bytes_, encoding=encoding, errors="backslashreplace", line_buffering=lines)
