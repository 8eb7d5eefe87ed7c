"""The process: locks for forks, the garbage collector paused, and threads beside the main one.

Locks made here are open in every child of `os.fork`. A child has only the thread that forked; a lock that another
thread held would stay shut in it for ever. So they must guard data for which a half-finished change is as good as none.
The same holds for the cached properties of Python 3.11, which has a lock for each. An import leaves half a module, so
a fork waits for those of other threads.
"""

from __future__ import annotations

import contextlib
import gc
import os
import sys
import threading
import time
import weakref
from functools import cached_property
from importlib import _bootstrap

TYPE_CHECKING = False  # every start imports this module, `typing` would take as long as all the rest
if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator
    from typing import Any, TypeVar

    Result = TypeVar("Result")

_locks: weakref.WeakSet[Any] = weakref.WeakSet()  # a lock lives as long as its owner
_LONGEST_IMPORT = 10.0
"""Seconds that a fork waits for the imports of other threads."""
_WAITED_FOR = ("conicoid", "numpy", "numba", "llvmlite")
"""Packages whose imports a fork waits for."""


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
    for lock in (*_locks, *_property_locks()):
        lock._at_fork_reinit()


def _property_locks() -> list[Any]:
    """Return the locks of the package's cached properties that this thread does not hold: Python 3.11 has them."""
    if sys.version_info >= (3, 12):
        return []
    modules = [module for name, module in sys.modules.items() if name.partition(".")[0] == "conicoid"]
    kinds = {kind for module in modules for kind in vars(module).values() if isinstance(kind, type)}
    members = [member for kind in kinds for member in vars(kind).values() if isinstance(member, cached_property)]
    locks = [getattr(member, "lock", None) for member in members]
    return [lock for lock in locks if lock is not None and not lock._is_owned()]


def wait_for_imports() -> None:
    """Wait until no other thread imports a module of the package or of its compiler: a child would wait for ever.

    Modules of others may take as long as they like, such as one that runs a server. The thread may wait for a lock of
    this one, so a fork goes on after `_LONGEST_IMPORT`.
    """
    end, here = time.monotonic() + _LONGEST_IMPORT, threading.get_ident()
    while time.monotonic() < end:
        locks = list(vars(_bootstrap)["_module_locks"].items())
        ours = [reference() for name, reference in locks if name.partition(".")[0] in _WAITED_FOR]
        if {getattr(lock, "owner", None) for lock in ours} <= {None, here}:
            return
        time.sleep(0.001)


if hasattr(os, "register_at_fork"):
    os.register_at_fork(before=wait_for_imports, after_in_child=_open_all)


# The garbage collector, paused during work that makes millions of objects and no cycle.


_MANY_OBJECTS = 1 << 20
"""Fewer stay young, so that garbage among them goes soon."""


@contextlib.contextmanager
def pause_gc() -> Iterator[None]:
    """Pause the collector: it would go through all objects over and over, and find nothing.

    Many objects made meanwhile are old at once, or the next collection would go through them. Without this, reading
    and preparing 20,000 bodies takes a tenth longer or more.
    """
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if gc.get_count()[0] > _MANY_OBJECTS and not gc.get_freeze_count():
            gc.freeze()
            gc.unfreeze()
        if was_on:
            gc.enable()


# Work in threads beside the main thread, which alone receives Ctrl-C, and only while it runs Python code.
#
# Work that may stay in compiled code for seconds, such as the compiler, runs in other threads while the main one waits.
# After Ctrl-C the main thread waits for them for a short time only, and leaves them to end by themselves.

PATIENCE = 0.5
"""Seconds that the main thread waits for other threads after Ctrl-C."""


def is_main_thread() -> bool:
    """True in the main thread, which receives Ctrl-C."""
    return threading.current_thread() is threading.main_thread()


def start_thread(work: Callable[[], Any], name: str) -> threading.Thread | None:
    """Start a daemon thread and return it; None if the system starts no more threads."""
    thread = threading.Thread(target=work, name=name, daemon=True)
    try:
        thread.start()
    except RuntimeError as error:
        if "new thread" not in str(error):  # a second Ctrl-C while `start` handles the first
            raise
        return None
    return thread


def join_threads(threads: Iterable[threading.Thread], seconds: float | None = None) -> None:
    """Wait until all threads have ended, or for `seconds` in all."""
    last = None if seconds is None else time.monotonic() + seconds
    for thread in threads:
        thread.join(None if last is None else max(0.0, last - time.monotonic()))


def run_interruptible(work: Callable[[], Result], name: str) -> Result:
    """Return the result of a call, or raise its exception; Ctrl-C interrupts the wait, and the call runs on."""
    if not is_main_thread():
        return work()
    done: list[Result] = []
    raised: list[BaseException] = []
    ended = threading.Event()

    def run() -> None:
        try:
            done.append(work())
        except BaseException as error:  # raised again below
            raised.append(error)
        finally:
            ended.set()

    if start_thread(run, name) is None:
        return work()
    ended.wait()
    if raised:
        raise raised[0]
    return done[0]
