"""stdout and stderr of the command `conicoid`, whatever they are: a pipe that nobody reads, a full disk, or closed.

Results that cannot be written are an error. Messages that cannot are not: what was asked for is done.
"""

from __future__ import annotations

import errno
import io
import os
import sys
from typing import Any

from .exit_codes import CLOSED


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


class Results(_Stream):
    """Raises SystemExit where nobody reads on, else OSError."""

    def tell_of(self, error: OSError) -> None:
        if error.errno == errno.EPIPE:
            raise SystemExit(CLOSED) from None
        raise OSError(error.errno, error.strerror, "standard output") from None


class Messages(_Stream):
    """Raises nothing."""


def open_streams() -> None:
    """Put them in place of Python's own, which are None where a stream is closed."""
    for number, mode in ((0, os.O_RDONLY), (1, os.O_RDONLY), (2, os.O_WRONLY)):
        try:
            os.fstat(number)
        except OSError:  # else the next file would get its number, and what is said would be written there
            os.open(os.devnull, mode)  # what is closed cannot be written: of stdout that is to be noticed
    sys.stdout = _in_place_of(sys.stdout, 1, Results)
    sys.stderr = _in_place_of(sys.stderr, 2, Messages)


def _in_place_of(stream: Any, number: int, kind: type[_Stream]) -> _Stream:
    """A terminal that knows ASCII only is no mistake."""
    bytes_ = io.BufferedWriter(io.FileIO(number, "w", closefd=False)) if stream is None else stream.buffer
    encoding = "utf-8" if stream is None else stream.encoding
    lines = number == 2 or os.isatty(number)
    return kind(bytes_, encoding=encoding, errors="backslashreplace", line_buffering=lines)
