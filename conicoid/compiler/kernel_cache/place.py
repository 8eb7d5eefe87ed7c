"""Where kernels are kept, and whether what lies there can be ours."""

from __future__ import annotations

import functools
import logging
import os
import stat
import sys
from pathlib import Path

from ..sources import source_hash

PACKAGE = Path(__file__).resolve().parents[2]
_log = logging.getLogger("conicoid")


@functools.cache
def say_once(message: str) -> None:
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


def kernels() -> Path | None:
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
        say_once(f"{place} is not used for compiled kernels: {reason}. They are compiled in memory")
    return not reason


def trusted_parent(folder: Path) -> bool:
    """May ours be made beside a folder of kernels? False if there is nothing yet."""
    try:
        found = os.stat(folder.parent)
    except OSError:
        return False
    return _acceptable(found, folder.parent, _parent_objection(found))


def trusted(folder: Path) -> bool:
    """May kernels be read from a folder? That it is not there needs no warning, that others can write to it does."""
    try:
        found = os.lstat(folder)
    except OSError:
        return False
    return trusted_parent(folder) and _acceptable(found, folder, objection(found))


def opened(path: Path) -> int:
    """A file for reading, but not by way of a link, and without waiting for the other end of a pipe."""
    flags = os.O_RDONLY
    for name in ("O_BINARY", "O_CLOEXEC", "O_NOFOLLOW", "O_NONBLOCK"):
        flags |= getattr(os, name, 0)
    return os.open(path, flags)
