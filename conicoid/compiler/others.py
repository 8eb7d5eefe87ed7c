"""Other processes that compile: waiting for what one of them makes, and telling of it."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Iterator

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


def stop() -> None:
    """Interrupt whoever polls, in whatever thread."""
    global _stopped
    _stopped += 1


def begun(kernel: str) -> None:
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
