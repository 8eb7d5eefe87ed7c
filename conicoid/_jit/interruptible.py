"""Work in threads beside the main thread, which alone receives Ctrl-C, and only while it runs Python code.

Work that may stay in compiled code for seconds, such as the compiler, runs in other threads while the main one waits.
After Ctrl-C the main thread waits for them for a short time only, and leaves them to end by themselves.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterable
from typing import Any, TypeVar

Result = TypeVar("Result")

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
