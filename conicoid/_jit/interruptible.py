"""Work beside the main thread, which alone hears of Ctrl-C, and only while it is in Python.

What may stay in compiled code for seconds, the compiler too, runs in other threads while the main one waits. After
Ctrl-C it waits a little for them to end, and no longer: they are left to end by themselves.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterable
from typing import Any, TypeVar

Result = TypeVar("Result")

PATIENCE = 0.5
"""Seconds that threads are waited for after Ctrl-C."""


def is_main_thread() -> bool:
    """Is this the thread that hears of Ctrl-C?"""
    return threading.current_thread() is threading.main_thread()


def start_thread(work: Callable[[], Any], name: str) -> threading.Thread | None:
    """A thread at work, which does not keep the process from ending; None if the system gives no more."""
    thread = threading.Thread(target=work, name=name, daemon=True)
    try:
        thread.start()
    except RuntimeError:
        return None
    return thread


def join_threads(threads: Iterable[threading.Thread], seconds: float | None = None) -> None:
    """Until all have ended, or for some seconds in all."""
    last = None if seconds is None else time.monotonic() + seconds
    for thread in threads:
        thread.join(None if last is None else max(0.0, last - time.monotonic()))


def run_interruptible(work: Callable[[], Result], name: str) -> Result:
    """The result of a call, or what it raises. Ctrl-C is heard meanwhile, and the call then goes on unheeded."""
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
    try:
        ended.wait()
    except KeyboardInterrupt:
        from . import compile_lock

        compile_lock.stop_polling()
        raise
    if raised:
        raise raised[0]
    return done[0]
