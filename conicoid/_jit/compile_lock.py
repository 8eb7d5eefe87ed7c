"""Whose turn it is to compile a kernel: processes that need the same one compile it once."""

from __future__ import annotations

import contextlib
import os
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path


class CompileLock:
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


# Other processes that compile: waiting for what one of them makes, and telling of it.

Listener = Callable[[str], None]

_STEP = 0.05  # seconds

_listeners: list[Listener] = []
_stopped = 0  # how often `stop` was called


def poll(done: Callable[[], bool], limit: float) -> None:
    """Poll until `done()` is true, for some seconds at most.

    Raises KeyboardInterrupt if `stop` is called meanwhile.
    """
    before, deadline = _stopped, time.monotonic() + limit
    while not done() and time.monotonic() < deadline:
        time.sleep(_STEP)
        if _stopped != before:
            raise KeyboardInterrupt


def stop_polling() -> None:
    """Interrupt whoever polls, in whatever thread."""
    global _stopped
    _stopped += 1


def notify_compile(kernel: str) -> None:
    """Notify listeners that another process is compiling a kernel, which is waited for."""
    for listener in list(_listeners):
        listener(kernel)


@contextlib.contextmanager
def on_begin(callback: Listener) -> Iterator[None]:
    """Within the block, call `callback(name)` when a kernel of another process is waited for."""
    _listeners.append(callback)
    try:
        yield
    finally:
        _listeners.remove(callback)
