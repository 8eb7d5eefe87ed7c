"""Outputs that appear whole or not at all."""

from __future__ import annotations

import contextlib
import errno
import os
from collections.abc import Iterator
from pathlib import Path

_NO_SYNC = {errno.EINVAL, errno.ENOTSUP, errno.ENOSYS, errno.EBADF, errno.EACCES, errno.EPERM}


@contextlib.contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[Path]:
    """A new empty file beside `path`, with the same suffix; it takes the place of `path` if the block succeeds.

    Its content is on the disk before its name is, so that neither a full disk nor a power cut leaves half of it.
    Raises OSError, naming `path`, where that cannot be a file, its folder cannot be written to, or the disk is full.
    """
    final = checked_place(path)
    partial = final.with_name(f".{final.stem[:40]}-{os.urandom(4).hex()}{final.suffix}")
    with _named(path, partial):
        descriptor = os.open(partial, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666)
        try:
            os.close(descriptor)
            yield partial
            _sync(partial, os.O_RDWR)
            if final.exists():
                partial.chmod(final.stat().st_mode & 0o777)
            os.replace(partial, final)
        finally:
            partial.unlink(missing_ok=True)
        if os.name == "posix":
            _sync(final.parent, os.O_RDONLY)


def checked_place(path: str | os.PathLike[str]) -> Path:
    """Where a file that is to be written leads to; OSError, naming it, for a folder, a device, or no folder above."""
    final = real_path(path)
    if final.is_dir():
        raise IsADirectoryError(errno.EISDIR, "is a directory", str(path))
    if final.exists() and not final.is_file():
        raise OSError(errno.EINVAL, "is not a regular file", str(path))
    if not final.parent.is_dir():
        raise FileNotFoundError(errno.ENOENT, "no such folder", str(final.parent))
    return final


def real_path(path: str | os.PathLike[str]) -> Path:
    """Where a path leads to, links followed; OSError where they go in a circle."""
    try:
        return Path(path).resolve()
    except RuntimeError:
        raise OSError(errno.ELOOP, os.strerror(errno.ELOOP), os.fspath(path)) from None


@contextlib.contextmanager
def _named(path: str | os.PathLike[str], partial: Path) -> Iterator[None]:
    """Errors of a file that is being written speak of the file that it was to be."""
    try:
        yield
    except OSError as error:
        if error.errno is None or error.filename not in (None, str(partial), partial):
            raise
        raise OSError(error.errno, error.strerror, os.fspath(path)) from None


def _sync(path: Path, flags: int) -> None:
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
    with replacing(path) as partial:
        partial.write_text(text, encoding="utf-8", newline="\n")
