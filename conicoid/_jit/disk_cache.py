"""Compiled kernels on disk: their folder, the trust in it, their files, and the removal of old ones.

The folder's name has a hash of all sources of the package, so an edited package finds no old code. A file holds one
kernel for one signature and processor, after a checksum. It is a pickle, hence a program: it is read only if no other
user can have written it. Damaged files are deleted. Where nothing can be written, kernels are compiled in memory, and
the log has one line about it.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import logging
import os
import re
import stat
import sys
import tempfile
import time
from pathlib import Path

from . import sources
from .sources import source_hash

# The folder, and whether another user may have written to it

PACKAGE = Path(__file__).resolve().parents[1]
_log = logging.getLogger("conicoid")


@functools.cache
def warn_once(message: str) -> None:
    """Log a warning once: a line on stderr, unless the program configures logging."""
    _log.warning("%s", "".join(letter if letter.isprintable() else "?" for letter in message))


@functools.cache
def _absolute(chosen: str) -> Path:
    """Return the absolute path of a folder as of the first use: later changes of the working directory do not count."""
    return Path(chosen).absolute()


def cache_directory() -> Path | None:
    """Return CONICOID_CACHE_DIR, or the user's cache folder; None for a user without a home."""
    import platformdirs

    chosen = os.environ.get("CONICOID_CACHE_DIR")
    try:
        path = _absolute(chosen) if chosen else Path(platformdirs.user_cache_dir("conicoid", appauthor=False))
    except (OSError, RuntimeError):
        return None
    return path if path.is_absolute() else None


def kernel_directory() -> Path | None:
    """Return the folder for kernels of these sources, which may not exist; None if there can be none."""
    parent = cache_directory()
    return parent / f"kernels-{source_hash()}" if parent and source_hash() else None


def objection(found: os.stat_result) -> str:
    """Return why another user might have written a file; "" if only this user and the administrator could."""
    if sys.platform == "win32":
        return ""
    # The administrator can do anything anyway, so files of root are no risk of their own.
    if found.st_uid not in (os.geteuid(), 0):
        return "it belongs to another user"
    if found.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
        return "others can write to it (chmod go-w mends that)"
    return ""


def _parent_objection(found: os.stat_result) -> str:
    """Return `objection`, but accept a sticky folder of the administrator: other users cannot rename ours there."""
    sticky = found.st_mode & stat.S_ISVTX
    return "" if sticky and found.st_uid == 0 else objection(found)


def _acceptable(found: os.stat_result, place: Path, reason: str) -> bool:
    """True if a folder may be used; warn once if not."""
    reason = reason if stat.S_ISDIR(found.st_mode) else "it is no folder"
    if reason:
        warn_once(f"{place} is not used for compiled kernels: {reason}. They are compiled in memory")
    return not reason


def is_parent_trusted(folder: Path) -> bool:
    """True if kernels' folders may be made in the parent of a folder; False if the parent does not exist."""
    try:
        found = os.stat(folder.parent)
    except OSError:
        return False
    return _acceptable(found, folder.parent, _parent_objection(found))


def is_trusted(folder: Path) -> bool:
    """True if kernels may be read from a folder; warn if others can write to it, not if it does not exist."""
    try:
        found = os.lstat(folder)
    except OSError:
        return False
    return is_parent_trusted(folder) and _acceptable(found, folder, objection(found))


def open_regular(path: Path) -> int:
    """Open a file for reading, without following a link or waiting for the other end of a pipe."""
    flags = os.O_RDONLY
    for name in ("O_BINARY", "O_CLOEXEC", "O_NOFOLLOW", "O_NONBLOCK"):
        flags |= getattr(os, name, 0)
    return os.open(path, flags)


# Removal of kernels of earlier sources when a folder for new ones is made: only files that are certainly ours

MARK = "CACHEDIR.TAG"
"""A file in each folder of kernels; many backup programs know its first line (bford.info/cachedir)."""
MARK_TEXT = (
    b"Signature: 8a477f597d28d172789f06886806bc55\n# Compiled kernels of Conicoid, which may be removed at any time.\n"
)
MOST_FOLDERS = 4
"""Number of other folders that stay, the last used ones; all that were used within a day stay as well."""

_NAME = re.compile(r"kernels-[0-9a-f]{20}")
_FILES = re.compile(r".+\.(nbc|lock|tmp)")
_DAY = 24 * 3600.0


def remove_old(current: Path) -> None:
    """Remove folders beside the current one that are no longer used; a process that still uses one compiles again."""
    with contextlib.suppress(OSError):
        others = [path for path in current.parent.iterdir() if path != current and _is_ours(path)]
        # The last used folders are first, so that the oldest are removed.
        others.sort(key=_last_used, reverse=True)
        for path in others[MOST_FOLDERS:]:
            if _last_used(path) < time.time() - _DAY:
                _remove(path)


def _is_ours(path: Path) -> bool:
    """True if a folder is one of kernels, by its name, its owner and its mark."""
    try:
        found = os.lstat(path)
        if not _NAME.fullmatch(path.name) or not stat.S_ISDIR(found.st_mode) or objection(found):
            return False
        with open(open_regular(path / MARK), "rb") as file:
            return stat.S_ISREG(os.fstat(file.fileno()).st_mode) and file.read(len(MARK_TEXT) + 1) == MARK_TEXT
    except OSError:
        return False


def _last_used(path: Path) -> float:
    """Return the time of the last use of a folder of kernels; 0 if unknown."""
    try:
        return os.stat(path / MARK).st_mtime
    except OSError:
        return 0.0


def _remove(folder: Path) -> None:
    """Remove the files of kernels, then the mark, then the folder; other files in it stay, and the folder with them."""
    with contextlib.suppress(OSError):
        for entry in list(os.scandir(folder)):
            if _FILES.fullmatch(entry.name) and entry.is_file(follow_symlinks=False):
                os.unlink(entry.path)
        # The mark goes last: a folder without it is not recognised as ours any more.
        if os.listdir(folder) == [MARK]:
            os.unlink(folder / MARK)
            os.rmdir(folder)


# Files of kernels: read only if they are complete and trusted, written completely or not at all

_HEAD = b"Conicoid kernel 1\n"
_DIGEST = hashlib.sha256().digest_size
_LARGEST = 1 << 28


def _digest(name: str, data: bytes) -> bytes:
    """Return the checksum of a file's name and contents."""
    return hashlib.sha256(name.encode() + b"\n" + data).digest()


def read_kernel(name: str) -> bytes | None:
    """Return the data written under a name; None, and the file is deleted, if it holds anything else."""
    folder = kernel_directory()
    if folder is None or not is_trusted(folder):
        return None
    try:
        with open(open_regular(folder / name), "rb") as file:
            found = os.fstat(file.fileno())
            ours = stat.S_ISREG(found.st_mode) and found.st_size <= _LARGEST and not objection(found)
            head, digest, data = (file.read(len(_HEAD)), file.read(_DIGEST), file.read()) if ours else (b"", b"", b"")
    except OSError:
        return None
    if head != _HEAD or digest != _digest(name, data):
        drop_kernel(name)
        return None
    _note_use(folder)
    return data


def drop_kernel(name: str) -> None:
    """Remove an unusable file; if that fails, the next reader rejects it again."""
    folder = kernel_directory()
    if folder is not None:
        with contextlib.suppress(OSError):
            os.unlink(folder / name)


@functools.cache
def _note_use(folder: Path) -> None:
    """Touch the mark: its age is the time since a process last began to use the folder."""
    with contextlib.suppress(OSError):
        os.utime(folder / MARK)


def prepare_directory() -> Path | None:
    """Make the folder for kernels and check that it is writable; return None, with a warning, if it is not."""
    folder = kernel_directory()
    if folder is None:
        warn_once("There is no folder for compiled kernels (see CONICOID_CACHE_DIR). They are compiled in memory")
        return None
    try:
        folder.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        new = _make_directory(folder)
        if not is_trusted(folder):
            return None
        if not (folder / MARK).exists():
            _replace(folder / MARK, MARK_TEXT)
        tempfile.TemporaryFile(dir=folder).close()  # a test that the folder is writable
    except OSError as error:
        _warn_unwritable(folder, error)
        return None
    if new:
        remove_old(folder)
    return folder


def _make_directory(folder: Path) -> bool:
    """Make a folder of kernels, unless it exists or its parent is not trusted; return True if it is new."""
    if os.path.lexists(folder) or not is_parent_trusted(folder):
        return False
    try:
        folder.mkdir(mode=0o700)
    except FileExistsError:
        return False
    return True


def write_kernel(name: str, data: bytes) -> bool:
    """Write data under a name; return False if that fails, or if the sources were edited since the start."""
    if sources.hash_of_sources() != sources.source_hash():  # edited code might be saved under the hash of the old
        return False
    folder = prepare_directory()
    if folder is None:
        return False
    try:
        _replace(folder / name, _HEAD + _digest(name, data) + data)
    except OSError as error:
        _warn_unwritable(folder, error)
        return False
    return True


def _warn_unwritable(folder: Path, error: OSError) -> None:
    """Warn once that kernels cannot be saved, and why."""
    reason = (error.strerror or str(error)).lower()
    warn_once(f"{folder} cannot keep compiled kernels: {reason}. They are compiled in memory")


def _replace(path: Path, data: bytes) -> None:
    """Write a file under a temporary name, and rename it in one step."""
    descriptor, temporary = tempfile.mkstemp(prefix=f"{path.stem}.", suffix=".tmp", dir=path.parent)
    try:
        with open(descriptor, "wb") as file:
            file.write(data)
        # In one step: other processes see the old file or the whole new one.
        os.replace(temporary, path)
    except BaseException:
        with contextlib.suppress(OSError):
            os.unlink(temporary)
        raise
