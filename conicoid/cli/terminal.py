"""Output and end of the command line: exit codes, messages, progress, and safe standard streams.

Results go to stdout, everything else to stderr, progress only to a terminal.
"""

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
    from rich.text import Text


EXIT_OK = 0
EXIT_FAILURE = 1
"""A fault of the machine, not of the input: a full disk, too little memory, a missing package; or a bug."""
EXIT_USAGE = 2
"""A mistake in the input or on the command line: a message describes it, and nothing is written."""
EXIT_FINDINGS = 3
"""A check has findings: the work is done, and a person should look at them."""
EXIT_INTERRUPT = 130
"""Ctrl-C: 128 plus the number of the signal, as in shells."""
EXIT_PIPE = 141
"""Nobody reads the results any more (`| head`): the code of a program that SIGPIPE ends."""

_NAME_ERRORS = frozenset(
    getattr(errno, name)
    for name in (
        "EACCES", "EADDRINUSE", "EADDRNOTAVAIL", "EEXIST", "EINVAL", "EISDIR", "ELOOP", "ENAMETOOLONG", "ENODEV",
        "ENOENT", "ENOTDIR", "ENXIO", "EPERM", "EROFS", "ETXTBSY",
    )
    if hasattr(errno, name)
)  # fmt: skip
"""Errors that another name would avoid: a missing file, a path through a file, a port in use."""


def exit_code(error: OSError) -> int:
    """Return EXIT_USAGE where another file name or address would avoid the error, else EXIT_FAILURE."""
    return EXIT_USAGE if error.errno in _NAME_ERRORS else EXIT_FAILURE


# --- Messages and progress

PATIENCE = 1.0
"""Seconds before a progress bar appears."""
SCREEN = 1800
"""The largest number of characters of a message."""


def console() -> Console:
    """Return a console on stderr; plain text without a terminal."""
    from rich.console import Console

    return Console(stderr=True, highlight=False, soft_wrap=True)


def show_message(message: str) -> None:
    """Print a line on stderr, without markup."""
    sys.stderr.write(f"{message}\n")
    sys.stderr.flush()


def shorten_message(message: str) -> str:
    """Return a message without its middle if it is longer than a screen: names may be of any length."""
    half = SCREEN // 2
    return message if len(message) <= SCREEN else f"{message[:half]} ... {message[-half:]}"


def first_cause(error: BaseException) -> str:
    """Return the first line of the first error: packages wrap errors of their libraries in pages of advice."""
    while isinstance(
        before := error.__cause__ or (None if error.__suppress_context__ else error.__context__), ImportError
    ):
        error = before
    return str(error).strip().partition("\n")[0]


@contextlib.contextmanager
def user_mistakes() -> Iterator[None]:
    """Turn errors into messages and exit codes; bugs keep their traceback."""
    try:
        yield
    except KeyboardInterrupt:
        show_message("interrupted")
        raise SystemExit(EXIT_INTERRUPT) from None
    except BrokenPipeError:  # an OSError too, so before these
        raise SystemExit(EXIT_PIPE) from None
    except OSError as error:  # before ValueError, since errors of unreadable files are both
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


class Bar:
    """A progress bar with rate and time left, on stderr; silent for a second, and without a terminal."""

    def __init__(self, what: str, unit: str, scale: float = 1.0) -> None:
        self.what, self.unit, self.scale = what, unit, scale
        self.started = time.perf_counter()
        self.note = ""
        """More text at the end of the line."""
        self.picture: Text | None = None
        """A picture above the line."""
        self.progress: Progress | None = None

    @cached_property
    def console(self) -> Console:
        """The console, made on first use: work of less than a second does not import the library of bars."""
        return console()

    def __enter__(self) -> Bar:
        return self

    def __exit__(self, *_: object) -> None:
        if self.progress is not None:
            self.progress.stop()

    def __call__(self, done: int, count: int) -> None:
        """Show that `done` of `count` steps are finished; each is `scale` units of work."""
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
    """Return the bar of a library, with the picture of a `Bar` above it."""
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

    class UnderPicture(Progress):
        """The bar, under the picture."""

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
    """Return a number with three digits and a prefix: 1.23 M."""
    for size, prefix in ((1e9, "G"), (1e6, "M"), (1e3, "k")):
        if value >= size:
            return f"{value / size:.3g} {prefix}"
    return f"{value:.3g} "


# --- Standard streams, which may be a pipe that nobody reads, a full disk, or closed


class _Stream(io.TextIOWrapper):
    """A text stream that reports the first error of writing, and drops all later text."""

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
        """Let further text go nowhere, and report the error."""
        # The descriptor is replaced, so that flushes at exit succeed as well
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, self.fileno())
        os.close(nowhere)
        self.report(error)

    def report(self, error: OSError) -> None:
        """Report an error of writing; the default ignores it."""


class ResultStream(_Stream):
    """Standard output: ends the process if nobody reads on, raises OSError for other errors."""

    def report(self, error: OSError) -> None:
        if error.errno == errno.EPIPE:
            raise SystemExit(EXIT_PIPE) from None
        raise OSError(error.errno, error.strerror, "standard output") from None


class MessageStream(_Stream):
    """Standard error: ignores errors."""


def open_streams() -> None:
    """Replace the standard streams of Python, which are None if a stream is closed.

    Results that cannot be written are an error; messages that cannot be written are not: the work is done.
    """
    for number, mode in ((0, os.O_RDONLY), (1, os.O_RDONLY), (2, os.O_WRONLY)):
        try:
            os.fstat(number)
        except OSError:  # the next file to be opened would get the number, and messages would go there
            os.open(os.devnull, mode)  # stdout opens for reading, so that a write of results fails
    sys.stdout = _in_place_of(sys.stdout, 1, ResultStream)
    sys.stderr = _in_place_of(sys.stderr, 2, MessageStream)


def _in_place_of(stream: Any, number: int, kind: type[_Stream]) -> _Stream:
    """Return a stream for a descriptor; characters that its encoding lacks are escaped."""
    bytes_ = io.BufferedWriter(io.FileIO(number, "w", closefd=False)) if stream is None else stream.buffer
    encoding = "utf-8" if stream is None else stream.encoding
    lines = number == 2 or os.isatty(number)  # messages appear at once
    return kind(bytes_, encoding=encoding, errors="backslashreplace", line_buffering=lines)
