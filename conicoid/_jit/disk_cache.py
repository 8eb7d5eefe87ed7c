"""Compiled kernels on disk: where they are, whether they are trusted, their files, and the removal of old ones.

The folder's name has a hash over all sources of the package, so an edited package finds no old code. A file holds one
kernel for one signature and processor, after a checksum. It is a pickle, that is, a program: it is read only where
nobody else can have written it. What is damaged is dropped. Where nothing can be written kernels are compiled in
memory, and the log says so in one line.
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

# Where kernels are kept, and whether what lies there can be ours.

PACKAGE = Path(__file__).resolve().parents[1]
_log = logging.getLogger("conicoid")


@functools.cache
def warn_once(message: str) -> None:
    """A line on stderr, unless the program has a log of its own."""
    _log.warning("%s", "".join(letter if letter.isprintable() else "?" for letter in message))


@functools.cache
def _absolute(chosen: str) -> Path:
    """A folder as it is meant at first use, whatever the working directory becomes."""
    return Path(chosen).absolute()


def cache_directory() -> Path | None:
    """CONICOID_CACHE_DIR, or the user's cache folder; None for a user without a home."""
    import platformdirs

    chosen = os.environ.get("CONICOID_CACHE_DIR")
    try:
        path = _absolute(chosen) if chosen else Path(platformdirs.user_cache_dir("conicoid", appauthor=False))
    except (OSError, RuntimeError):
        return None
    return path if path.is_absolute() else None


def kernel_directory() -> Path | None:
    """The folder of these sources' kernels, which need not be there; None where it cannot be."""
    parent = cache_directory()
    return parent / f"kernels-{source_hash()}" if parent and source_hash() else None


def objection(found: os.stat_result) -> str:
    """Why another user might have written what was found; "" if only this user and the administrator could."""
    if sys.platform == "win32":
        return ""
    if found.st_uid not in (os.geteuid(), 0):
        return "it belongs to another user"
    if found.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
        return "others can write to it (chmod go-w mends that)"
    return ""


def _parent_objection(found: os.stat_result) -> str:
    """Where everybody may make folders, but not rename other people's, ours are safe."""
    sticky = found.st_mode & stat.S_ISVTX
    return "" if sticky and found.st_uid == 0 else objection(found)


def _acceptable(found: os.stat_result, place: Path, reason: str) -> bool:
    """May a folder be used? Says once why not."""
    reason = reason if stat.S_ISDIR(found.st_mode) else "it is no folder"
    if reason:
        warn_once(f"{place} is not used for compiled kernels: {reason}. They are compiled in memory")
    return not reason


def is_parent_trusted(folder: Path) -> bool:
    """May ours be made beside a folder of kernels? False if there is nothing yet."""
    try:
        found = os.stat(folder.parent)
    except OSError:
        return False
    return _acceptable(found, folder.parent, _parent_objection(found))


def is_trusted(folder: Path) -> bool:
    """May kernels be read from a folder? That it is not there needs no warning, that others can write to it does."""
    try:
        found = os.lstat(folder)
    except OSError:
        return False
    return is_parent_trusted(folder) and _acceptable(found, folder, objection(found))


def open_regular(path: Path) -> int:
    """A file for reading, but not by way of a link, and without waiting for the other end of a pipe."""
    flags = os.O_RDONLY
    for name in ("O_BINARY", "O_CLOEXEC", "O_NOFOLLOW", "O_NONBLOCK"):
        flags |= getattr(os, name, 0)
    return os.open(path, flags)


# Kernels of earlier sources, removed when a folder for new ones is made: surely ours, and nothing else.

MARK = "CACHEDIR.TAG"
"""A file in each folder of ours; many programs that make copies know its first line (bford.info/cachedir)."""
MARK_TEXT = (
    b"Signature: 8a477f597d28d172789f06886806bc55\n# Compiled kernels of Conicoid, which may be removed at any time.\n"
)
MOST_FOLDERS = 4
"""Folders that are kept, the last used ones; besides them, all that were used within a day."""

_NAME = re.compile(r"kernels-[0-9a-f]{20}")
_FILES = re.compile(r".+\.(nbc|lock|tmp)")
_DAY = 24 * 3600.0


def remove_old(current: Path) -> None:
    """Remove the folders beside one that are no longer used. Whoever does use one compiles some kernels once more."""
    with contextlib.suppress(OSError):
        others = [path for path in current.parent.iterdir() if path != current and _is_ours(path)]
        others.sort(key=_last_used, reverse=True)
        for path in others[MOST_FOLDERS:]:
            if _last_used(path) < time.time() - _DAY:
                _remove(path)


def _is_ours(path: Path) -> bool:
    """By its name, its owner and its mark."""
    try:
        found = os.lstat(path)
        if not _NAME.fullmatch(path.name) or not stat.S_ISDIR(found.st_mode) or objection(found):
            return False
        with open(open_regular(path / MARK), "rb") as file:
            return stat.S_ISREG(os.fstat(file.fileno()).st_mode) and file.read(len(MARK_TEXT) + 1) == MARK_TEXT
    except OSError:
        return False


def _last_used(path: Path) -> float:
    """When a folder of kernels was last used; 0 where that is unknown."""
    try:
        return os.stat(path / MARK).st_mtime
    except OSError:
        return 0.0


def _remove(folder: Path) -> None:
    """Files of ours, then the mark, then the folder. Anything else in it stays, and the folder with it."""
    with contextlib.suppress(OSError):
        for entry in list(os.scandir(folder)):
            if _FILES.fullmatch(entry.name) and entry.is_file(follow_symlinks=False):
                os.unlink(entry.path)
        if os.listdir(folder) == [MARK]:
            os.unlink(folder / MARK)
            os.rmdir(folder)


# Files of compiled kernels: read if they are whole and ours, written whole or not at all.

_HEAD = b"Conicoid kernel 1\n"
_DIGEST = hashlib.sha256().digest_size
_LARGEST = 1 << 28


def _digest(name: str, data: bytes) -> bytes:
    """The checksum of a file's name and contents."""
    return hashlib.sha256(name.encode() + b"\n" + data).digest()


def read_kernel(name: str) -> bytes | None:
    """What was written under a name, to the bit. A file that holds anything else is dropped."""
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
    """Remove a file that is of no use. Where that cannot be done it is passed over each time."""
    folder = kernel_directory()
    if folder is not None:
        with contextlib.suppress(OSError):
            os.unlink(folder / name)


@functools.cache
def _note_use(folder: Path) -> None:
    """The age of the mark is the time since a process last began to use the folder."""
    with contextlib.suppress(OSError):
        os.utime(folder / MARK)


def prepare_directory() -> Path | None:
    """The folder, there and writable, for what is about to be compiled; None, and a warning, if it cannot be."""
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
        tempfile.TemporaryFile(dir=folder).close()
    except OSError as error:
        _warn_unwritable(folder, error)
        return None
    if new:
        remove_old(folder)
    return folder


def _make_directory(folder: Path) -> bool:
    """Make a folder of kernels, unless it is there, or its parent is not ours."""
    if os.path.lexists(folder) or not is_parent_trusted(folder):
        return False
    try:
        folder.mkdir(mode=0o700)
    except FileExistsError:
        return False
    return True


def write_kernel(name: str, data: bytes) -> bool:
    """Keep data under a name. False if that cannot be done, or the sources have been edited since they were read."""
    if sources.hash_of_sources() != sources.source_hash():
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
    """Say once that kernels cannot be kept, and why."""
    reason = (error.strerror or str(error)).lower()
    warn_once(f"{folder} cannot keep compiled kernels: {reason}. They are compiled in memory")


def _replace(path: Path, data: bytes) -> None:
    """Write a file under another name, and give it its own in one step."""
    descriptor, temporary = tempfile.mkstemp(prefix=f"{path.stem}.", suffix=".tmp", dir=path.parent)
    try:
        with open(descriptor, "wb") as file:
            file.write(data)
        os.replace(temporary, path)
    except BaseException:
        with contextlib.suppress(OSError):
            os.unlink(temporary)
        raise
