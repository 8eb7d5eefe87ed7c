"""Locks that are open in every child of `os.fork`.

A child has only the thread that forked. A lock that another thread held would stay shut in it for ever. Locks made here
are opened in the child, so they must guard data for which a half-finished change is as good as none.
"""

from __future__ import annotations

import os
import threading
import weakref
from typing import Any

_locks: weakref.WeakSet[Any] = weakref.WeakSet()  # a lock lives as long as its owner


def fork_safe_lock() -> threading.Lock:
    """Return a lock that is open in a fork of this process."""
    lock = threading.Lock()
    _locks.add(lock)
    return lock


def fork_safe_rlock() -> Any:
    """Return such a lock that its owner may take again."""
    lock = threading.RLock()
    _locks.add(lock)
    return lock


def _open_all() -> None:
    """Open all locks, in the child."""
    for lock in list(_locks):
        lock._at_fork_reinit()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_open_all)
