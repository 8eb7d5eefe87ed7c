"""Kernels of earlier sources, removed when a folder for new ones is made: surely ours, and nothing else."""

from __future__ import annotations

import contextlib
import os
import re
import stat
import time
from pathlib import Path

from .place import objection, opened

MARK = "CACHEDIR.TAG"
"""A file in each folder of ours; many programs that make copies know its first line (bford.info/cachedir)."""
MARK_TEXT = (
    b"Signature: 8a477f597d28d172789f06886806bc55\n# Compiled kernels of Conicoid, which may be removed at any time.\n"
)
KEPT = 4
"""Folders that are kept, the last used ones; besides them, all that were used within a day."""

_NAME = re.compile(r"kernels-[0-9a-f]{20}")
_FILES = re.compile(r".+\.(nbc|lock|tmp)")
_DAY = 24 * 3600.0


def remove_old(current: Path) -> None:
    """Remove the folders beside one that are no longer used. Whoever does use one compiles some kernels once more."""
    with contextlib.suppress(OSError):
        others = [path for path in current.parent.iterdir() if path != current and _ours(path)]
        others.sort(key=_last_used, reverse=True)
        for path in others[KEPT:]:
            if _last_used(path) < time.time() - _DAY:
                _remove(path)


def _ours(path: Path) -> bool:
    """By its name, its owner and its mark."""
    try:
        found = os.lstat(path)
        if not _NAME.fullmatch(path.name) or not stat.S_ISDIR(found.st_mode) or objection(found):
            return False
        with open(opened(path / MARK), "rb") as file:
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
