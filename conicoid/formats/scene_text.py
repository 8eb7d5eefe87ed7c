"""From a path to the text of a scene file, or one clear reason why there is none."""

from __future__ import annotations

import os
import stat
from pathlib import Path

from .errors import Problem, SceneFileError, cannot_be_read
from .regular import open_regular

MAX_BYTES = 64 << 20


def read_text(path: str | os.PathLike[str]) -> str:
    """The text of a scene file. Raises SceneFileError for anything that is no text of bearable size."""
    try:
        raw = _read_bytes(Path(path))
        return _decoded(raw)
    except OSError as error:
        raise cannot_be_read(path, error) from None
    except _NoText as error:
        raise SceneFileError(path, [Problem(error.line, error.column, "", str(error))]) from None


class _NoText(Exception):
    def __init__(self, message: str, line: int = 0, column: int = 0) -> None:
        super().__init__(message)
        self.line, self.column = line, column


def _read_bytes(path: Path) -> bytes:
    if "\0" in str(path):
        raise _NoText("cannot be read: a path cannot hold a zero character")
    status = path.stat()
    if stat.S_ISDIR(status.st_mode):
        raise _NoText("is a directory, not a scene file")
    if not stat.S_ISREG(status.st_mode):
        raise _NoText("is not a regular file")
    with open_regular(path) as file:
        raw = file.read(min(status.st_size, MAX_BYTES) + 1)
    if len(raw) > MAX_BYTES:
        size, most = max(status.st_size, len(raw)) >> 20, MAX_BYTES >> 20
        raise _NoText(f"is too large: {size} MB, a scene file has at most {most} MB (bulk data belongs in a .npy file)")
    return raw


def _decoded(raw: bytes) -> str:
    if raw.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise _NoText("is in UTF-16 or UTF-32, a scene file must be in UTF-8")
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line, column = raw.count(b"\n", 0, error.start) + 1, error.start - raw.rfind(b"\n", 0, error.start)
        message = f"is not a text in UTF-8: byte 0x{raw[error.start]:02x}"
        raise _NoText(
            "looks like a binary file: " + message if b"\0" in raw[:4096] else message, line, column
        ) from None
    if "\0" in text:
        position = text.index("\0")
        line, column = text.count("\n", 0, position) + 1, position - text.rfind("\n", 0, position)
        raise _NoText("looks like a binary file: it holds a zero byte", line, column)
    return text
