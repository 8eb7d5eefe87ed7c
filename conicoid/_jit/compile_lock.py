"""Locks so that processes that need the same kernel compile it once, and the waiting for another process."""

from __future__ import annotations

import contextlib
import os
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path


class CompileLock:
    """A lock on a file beside the kernel's file; the system releases it when the process ends.

    On file systems without locks every process gets the lock: kernels are written in one step, so compiling one twice
    does no harm.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._descriptor = -1

    def taken(self) -> bool:
        """Take the lock unless another process has it; return False if another has."""
        try:
            if self._descriptor < 0:
                self._descriptor = os.open(self._path, os.O_RDWR | os.O_CREAT | getattr(os, "O_CLOEXEC", 0), 0o600)
            _lock(self._descriptor)
        except (BlockingIOError, PermissionError):
            return self._descriptor < 0  # a file that cannot be opened is no lock: compile
        except OSError:
            pass
        return True

    def end(self) -> None:
        """Release the lock, also for forks of this process."""
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


# Waiting for a kernel that another process compiles

Listener = Callable[[str], None]

_STEP = 0.05  # seconds

_listeners: list[Listener] = []
_stopped = 0  # number of calls of `stop_polling`


def poll(done: Callable[[], bool], limit: float) -> None:
    """Poll until `done()` is true, for at most `limit` seconds.

    Raises
    ------
    KeyboardInterrupt
        If `stop_polling` is called meanwhile.
    """
    before, deadline = _stopped, time.monotonic() + limit
    while not done() and time.monotonic() < deadline:
        time.sleep(_STEP)
        if _stopped != before:
            raise KeyboardInterrupt


def stop_polling() -> None:
    """Interrupt every thread that polls."""
    global _stopped
    _stopped += 1


def notify_compile(kernel: str) -> None:
    """Notify listeners that this process waits for a kernel that another one compiles."""
    for listener in list(_listeners):
        listener(kernel)


@contextlib.contextmanager
def on_begin(callback: Listener) -> Iterator[None]:
    """Within the block, call `callback(name)` when this process waits for a kernel that another one compiles."""
    _listeners.append(callback)
    try:
        yield
    finally:
        _listeners.remove(callback)
