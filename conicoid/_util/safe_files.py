"""Output files that appear whole or not at all, and input files that can be read to their end."""

from __future__ import annotations

import contextlib
import errno
import os
import stat
from collections.abc import Iterator
from io import BufferedReader
from pathlib import Path

_NO_SYNC = {errno.EINVAL, errno.ENOTSUP, errno.ENOSYS, errno.EBADF, errno.EACCES, errno.EPERM}
"""Errors of systems and files that cannot be synchronised."""


@contextlib.contextmanager
def replace_file(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield a new empty file beside `path`, with the same suffix; it replaces `path` if the block succeeds.

    Its content is on the disk before its name is, so that neither a full disk nor a power cut leaves half of it. Raises
    OSError with the name `path` if that cannot be a file, its folder cannot be written to, or the disk is full.
    """
    final = resolve_output(path)
    partial = final.with_name(f".{final.stem[:40]}-{os.urandom(4).hex()}{final.suffix}")
    with _name_output_in_errors(path, partial):
        # Exclusive: a file of that name, or a link planted there, is never written to
        descriptor = os.open(partial, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666)
        try:
            os.close(descriptor)
            yield partial
            _sync_to_disk(partial, os.O_RDWR)
            if final.exists():  # the new file keeps the permissions of the old one
                partial.chmod(final.stat().st_mode & 0o777)
            os.replace(partial, final)
        finally:
            partial.unlink(missing_ok=True)
        if os.name == "posix":  # the folder holds the name; other systems cannot open one
            _sync_to_disk(final.parent, os.O_RDONLY)


def resolve_output(path: str | os.PathLike[str]) -> Path:
    """Return the path of a file to write, with links followed.

    Raises OSError with the path for a folder, a device, or a missing parent folder.
    """
    final = resolve_links(path)
    if final.is_dir():
        raise IsADirectoryError(errno.EISDIR, "is a directory", str(path))
    if final.exists() and not final.is_file():
        raise OSError(errno.EINVAL, "is not a regular file", str(path))
    if not final.parent.is_dir():
        raise FileNotFoundError(errno.ENOENT, "no such folder", str(final.parent))
    return final


def resolve_links(path: str | os.PathLike[str]) -> Path:
    """Return a path with links followed; raise OSError for links in a circle."""
    try:
        return Path(path).resolve()
    except RuntimeError:
        raise OSError(errno.ELOOP, os.strerror(errno.ELOOP), os.fspath(path)) from None


@contextlib.contextmanager
def _name_output_in_errors(path: str | os.PathLike[str], partial: Path) -> Iterator[None]:
    """Let errors of the partial file name the file that it was to become."""
    try:
        yield
    except OSError as error:
        if error.errno is None or error.filename not in (None, str(partial), partial):
            raise
        raise OSError(error.errno, error.strerror, os.fspath(path)) from None


def _sync_to_disk(path: Path, flags: int) -> None:
    """Wait until a file or folder is on the disk, on systems that support it."""
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


# --- Input: no wait for a pipe, no read of a device, no more memory than the machine has

MAX_FILE_BYTES = 64 << 30
"""The largest content of a file in memory."""
_READ_ONLY = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_CLOEXEC", 0) | getattr(os, "O_BINARY", 0)


def open_regular(path: str | os.PathLike[str]) -> BufferedReader:
    """Open a regular file, or a link to one, for reading; raise OSError at once for anything else."""
    _check_regular(os.stat(path).st_mode, path)  # before `open`, which some devices react to
    descriptor = os.open(path, _READ_ONLY)
    try:  # again, since the file may have been replaced meanwhile
        _check_regular(os.fstat(descriptor).st_mode, path)
    except OSError:
        os.close(descriptor)
        raise
    return open(descriptor, "rb")


def _check_regular(mode: int, path: str | os.PathLike[str]) -> None:
    """Raise OSError unless a mode is that of a regular file."""
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, "is a directory", os.fspath(path))
    if not stat.S_ISREG(mode):
        raise OSError(errno.EINVAL, "is not a regular file", os.fspath(path))


def check_memory(size: int) -> None:
    """Raise ValueError for more bytes than any machine should take for a file, or than this one has."""
    most = min(MAX_FILE_BYTES, _machine_memory())
    if size > most:
        raise ValueError(f"takes {size / 2**30:,.1f} GiB of memory, at most {most / 2**30:,.1f} GiB can be had")


def _machine_memory() -> int:
    """Return the bytes of memory of this machine, or the limit of a file if the system does not report them."""
    try:
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, ValueError, OSError):
        return MAX_FILE_BYTES
