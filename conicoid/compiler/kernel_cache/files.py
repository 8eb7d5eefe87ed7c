"""Files of compiled kernels: read if they are whole and ours, written whole or not at all."""

from __future__ import annotations

import contextlib
import functools
import hashlib
import os
import stat
import tempfile
from pathlib import Path

from .. import sources
from . import place
from .old import MARK, MARK_TEXT, remove_old

_HEAD = b"Conicoid kernel 1\n"
_DIGEST = hashlib.sha256().digest_size
_LARGEST = 1 << 28


def _digest(name: str, data: bytes) -> bytes:
    """The checksum of a file's name and contents."""
    return hashlib.sha256(name.encode() + b"\n" + data).digest()


def read(name: str) -> bytes | None:
    """What was written under a name, to the bit. A file that holds anything else is dropped."""
    folder = place.kernels()
    if folder is None or not place.trusted(folder):
        return None
    try:
        with open(place.opened(folder / name), "rb") as file:
            found = os.fstat(file.fileno())
            ours = stat.S_ISREG(found.st_mode) and found.st_size <= _LARGEST and not place.objection(found)
            head, digest, data = (file.read(len(_HEAD)), file.read(_DIGEST), file.read()) if ours else (b"", b"", b"")
    except OSError:
        return None
    if head != _HEAD or digest != _digest(name, data):
        drop(name)
        return None
    _note_use(folder)
    return data


def drop(name: str) -> None:
    """Remove a file that is of no use. Where that cannot be done it is passed over each time."""
    folder = place.kernels()
    if folder is not None:
        with contextlib.suppress(OSError):
            os.unlink(folder / name)


@functools.cache
def _note_use(folder: Path) -> None:
    """The age of the mark is the time since a process last began to use the folder."""
    with contextlib.suppress(OSError):
        os.utime(folder / MARK)


def prepare() -> Path | None:
    """The folder, there and writable, for what is about to be compiled; None, and a warning, if it cannot be."""
    folder = place.kernels()
    if folder is None:
        place.say_once("There is no folder for compiled kernels (see CONICOID_CACHE_DIR). They are compiled in memory")
        return None
    try:
        folder.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        new = _made(folder)
        if not place.trusted(folder):
            return None
        if not (folder / MARK).exists():
            _replace(folder / MARK, MARK_TEXT)
        tempfile.TemporaryFile(dir=folder).close()
    except OSError as error:
        _say_unwritable(folder, error)
        return None
    if new:
        remove_old(folder)
    return folder


def _made(folder: Path) -> bool:
    """Make a folder of kernels, unless it is there, or its parent is not ours."""
    if os.path.lexists(folder) or not place.trusted_parent(folder):
        return False
    try:
        folder.mkdir(mode=0o700)
    except FileExistsError:
        return False
    return True


def write(name: str, data: bytes) -> bool:
    """Keep data under a name. False if that cannot be done, or the sources have been edited since they were read."""
    if sources.hash_of_sources() != sources.source_hash():
        return False
    folder = prepare()
    if folder is None:
        return False
    try:
        _replace(folder / name, _HEAD + _digest(name, data) + data)
    except OSError as error:
        _say_unwritable(folder, error)
        return False
    return True


def _say_unwritable(folder: Path, error: OSError) -> None:
    """Say once that kernels cannot be kept, and why."""
    reason = (error.strerror or str(error)).lower()
    place.say_once(f"{folder} cannot keep compiled kernels: {reason}. They are compiled in memory")


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
