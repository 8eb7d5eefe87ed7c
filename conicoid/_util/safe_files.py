"""Outputs that appear whole or not at all."""

from __future__ import annotations

import contextlib
import errno
import os
import stat
from collections.abc import Iterator
from io import BufferedReader
from pathlib import Path

_NO_SYNC = {errno.EINVAL, errno.ENOTSUP, errno.ENOSYS, errno.EBADF, errno.EACCES, errno.EPERM}


@contextlib.contextmanager
def replace_file(path: str | os.PathLike[str]) -> Iterator[Path]:
    """A new empty file beside `path`, with the same suffix; it takes the place of `path` if the block succeeds.

    Its content is on the disk before its name is, so that neither a full disk nor a power cut leaves half of it.
    Raises OSError, naming `path`, where that cannot be a file, its folder cannot be written to, or the disk is full.
    """
    final = resolve_output(path)
    partial = final.with_name(f".{final.stem[:40]}-{os.urandom(4).hex()}{final.suffix}")
    with _name_output_in_errors(path, partial):
        descriptor = os.open(partial, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666)
        try:
            os.close(descriptor)
            yield partial
            _sync_to_disk(partial, os.O_RDWR)
            if final.exists():
                partial.chmod(final.stat().st_mode & 0o777)
            os.replace(partial, final)
        finally:
            partial.unlink(missing_ok=True)
        if os.name == "posix":
            _sync_to_disk(final.parent, os.O_RDONLY)


def resolve_output(path: str | os.PathLike[str]) -> Path:
    """Where a file that is to be written leads to; OSError, naming it, for a folder, a device, or no folder above."""
    final = resolve_links(path)
    if final.is_dir():
        raise IsADirectoryError(errno.EISDIR, "is a directory", str(path))
    if final.exists() and not final.is_file():
        raise OSError(errno.EINVAL, "is not a regular file", str(path))
    if not final.parent.is_dir():
        raise FileNotFoundError(errno.ENOENT, "no such folder", str(final.parent))
    return final


def resolve_links(path: str | os.PathLike[str]) -> Path:
    """Where a path leads to, links followed; OSError where they go in a circle."""
    try:
        return Path(path).resolve()
    except RuntimeError:
        raise OSError(errno.ELOOP, os.strerror(errno.ELOOP), os.fspath(path)) from None


@contextlib.contextmanager
def _name_output_in_errors(path: str | os.PathLike[str], partial: Path) -> Iterator[None]:
    """Errors of a file that is being written speak of the file that it was to be."""
    try:
        yield
    except OSError as error:
        if error.errno is None or error.filename not in (None, str(partial), partial):
            raise
        raise OSError(error.errno, error.strerror, os.fspath(path)) from None


def _sync_to_disk(path: Path, flags: int) -> None:
    """Wait until the file or folder is on the disk, where there is a way to."""
    try:
        descriptor = os.open(path, flags)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
    except OSError as error:
        if error.errno not in _NO_SYNC:
            raise


def write_text(path: str | os.PathLike[str], text: str) -> None:
    """Write a text in UTF-8, whole or not at all."""
    with replace_file(path) as partial:
        partial.write_text(text, encoding="utf-8", newline="\n")


# Files that can be read to their end: no pipe is waited for, no device is read, no memory taken that is not there.

MAX_FILE_BYTES = 64 << 30
_READ_ONLY = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_CLOEXEC", 0) | getattr(os, "O_BINARY", 0)


def open_regular(path: str | os.PathLike[str]) -> BufferedReader:
    """A regular file, or a link to one, opened for reading. Raises OSError for anything else, at once."""
    _check_regular(os.stat(path).st_mode, path)  # before it is opened, which some devices notice
    descriptor = os.open(path, _READ_ONLY)
    try:
        _check_regular(os.fstat(descriptor).st_mode, path)
    except OSError:
        os.close(descriptor)
        raise
    return open(descriptor, "rb")


def _check_regular(mode: int, path: str | os.PathLike[str]) -> None:
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, "is a directory", os.fspath(path))
    if not stat.S_ISREG(mode):
        raise OSError(errno.EINVAL, "is not a regular file", os.fspath(path))


def check_memory(size: int) -> None:
    """ValueError where `size` bytes are more than any machine should take for a file, or than this one has."""
    most = min(MAX_FILE_BYTES, _machine_memory())
    if size > most:
        raise ValueError(f"takes {size / 2**30:,.1f} GiB of memory, at most {most / 2**30:,.1f} GiB can be had")


def _machine_memory() -> int:
    """Bytes of this machine, where it says so."""
    try:
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, ValueError, OSError):
        return MAX_FILE_BYTES
