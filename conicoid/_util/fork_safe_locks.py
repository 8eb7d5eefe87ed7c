"""Locks that a fork does not leave shut.

A child of `os.fork` has only the thread that forked. A lock that another thread held would stay shut in it for ever,
so locks made here are open in every child; what they guard must be such that half of it is as good as nothing.
"""

from __future__ import annotations

import os
import threading
import weakref
from typing import Any

_locks: weakref.WeakSet[Any] = weakref.WeakSet()


def fork_safe_lock() -> threading.Lock:
    """A lock that is open in a fork of this process."""
    made = threading.Lock()
    _locks.add(made)
    return made


def fork_safe_rlock() -> Any:
    """The same that its owner may take again."""
    made = threading.RLock()
    _locks.add(made)
    return made


def _open_all() -> None:
    for lock in list(_locks):
        lock._at_fork_reinit()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_open_all)
