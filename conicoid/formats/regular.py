"""Files that can be read to their end: no pipe is waited for, no device is read, no memory taken that is not there."""

from __future__ import annotations

import errno
import os
import stat
from io import BufferedReader

MOST_BYTES = 64 << 30
_READ_ONLY = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_CLOEXEC", 0) | getattr(os, "O_BINARY", 0)


def open_regular(path: str | os.PathLike[str]) -> BufferedReader:
    """A regular file, or a link to one, opened for reading. Raises OSError for anything else, at once."""
    _check(os.stat(path).st_mode, path)  # before it is opened, which some devices notice
    descriptor = os.open(path, _READ_ONLY)
    try:
        _check(os.fstat(descriptor).st_mode, path)
    except OSError:
        os.close(descriptor)
        raise
    return open(descriptor, "rb")


def _check(mode: int, path: str | os.PathLike[str]) -> None:
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, "is a directory", os.fspath(path))
    if not stat.S_ISREG(mode):
        raise OSError(errno.EINVAL, "is not a regular file", os.fspath(path))


def check_memory(size: int) -> None:
    """ValueError where `size` bytes are more than any machine should take for a file, or than this one has."""
    most = min(MOST_BYTES, _memory())
    if size > most:
        raise ValueError(f"takes {size / 2**30:,.1f} GiB of memory, at most {most / 2**30:,.1f} GiB can be had")


def _memory() -> int:
    """Bytes of this machine, where it says so."""
    try:
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, ValueError, OSError):
        return MOST_BYTES
