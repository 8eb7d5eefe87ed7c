"""Whose turn it is to compile a kernel: processes that need the same one compile it once."""

from __future__ import annotations

import contextlib
import os
import sys
from pathlib import Path


class Turn:
    """A lock on a file beside the kernel's. The system holds it, so that it ends with the process that has it.

    Where there are no such locks it is everybody's turn: kernels are written in one step, and one more does no harm.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._descriptor = -1

    def taken(self) -> bool:
        """Take it, unless another process has it."""
        try:
            if self._descriptor < 0:
                self._descriptor = os.open(self._path, os.O_RDWR | os.O_CREAT | getattr(os, "O_CLOEXEC", 0), 0o600)
            _lock(self._descriptor)
        except (BlockingIOError, PermissionError):
            return self._descriptor < 0
        except OSError:
            pass
        return True

    def end(self) -> None:
        """Give it up, also for forks of this process."""
        if self._descriptor >= 0:
            with contextlib.suppress(OSError):
                _unlock(self._descriptor)
            os.close(self._descriptor)
        self._descriptor = -1


if sys.platform == "win32":
    import msvcrt

    def _lock(descriptor: int) -> None:
        msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)

    def _unlock(descriptor: int) -> None:
        msvcrt.locking(descriptor, msvcrt.LK_UNLCK, 1)

else:
    import fcntl

    def _lock(descriptor: int) -> None:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)

    def _unlock(descriptor: int) -> None:
        fcntl.flock(descriptor, fcntl.LOCK_UN)
