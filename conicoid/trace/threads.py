"""Our own thread pool: chunks of rays or tiles, progress, and Ctrl-C that stops at once.

Kernels release the interpreter lock, so plain threads run them in parallel, side by side with
other threads, Dask workers or notebooks (Numba's own pool is not safe to share).
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable
from typing import Any

from .. import ahead

Progress = Callable[[int, int], None]
"""Called now and then as progress(done, count)."""

_chosen: list[int] = []


def thread_count() -> int:
    """Threads in use: `set_threads`, CONICOID_THREADS, or the processors this process may use."""
    if _chosen:
        return _chosen[-1]
    wanted = os.environ.get("CONICOID_THREADS", "")
    if wanted.isdigit() and int(wanted) > 0:
        return int(wanted)
    if hasattr(os, "sched_getaffinity"):
        return max(1, len(os.sched_getaffinity(0)))
    return max(1, os.cpu_count() or 1)


def set_threads(count: int | None) -> None:
    """Use `count` threads from now on; None returns to the default."""
    if count is not None and (not isinstance(count, int) or count < 1):
        raise ValueError(f"set_threads: count must be an integer >= 1 or None, got {count!r}")
    _chosen[:] = [] if count is None else [count]


def chunk_size(count: int, most: int) -> int:
    """How much of some work a thread should take at a time: `most`, or so little that each has several turns."""
    return max(1, min(most, count // (8 * thread_count()))) if count >= 8 else 1


class _Work:
    """Chunks still to be done, shared by a few threads."""

    def __init__(self, work: Callable[[int, int], Any], count: int, chunk: int) -> None:
        self.work, self.count, self.chunk = work, count, chunk
        self.next = 0
        self.done = 0
        self.error: BaseException | None = None
        self.lock = threading.Lock()
        self.changed = threading.Condition(self.lock)

    def take(self) -> tuple[int, int] | None:
        with self.lock:
            if self.next >= self.count or self.error is not None:
                return None
            begin = self.next
            self.next = min(self.count, begin + self.chunk)
            return begin, self.next

    def run(self) -> None:
        while (piece := self.take()) is not None:
            try:
                self.work(*piece)
            except BaseException as error:  # handed to the caller's thread
                with self.changed:
                    self.error = self.error or error
                    self.changed.notify_all()
                return
            with self.changed:
                self.done += piece[1] - piece[0]
                self.changed.notify_all()

    def stop(self) -> None:
        with self.changed:
            self.next = self.count


def run_chunks(work: Callable[[int, int], Any], count: int, chunk: int, progress: Progress | None = None) -> None:
    """Call work(begin, end) for every chunk of range(count) on all threads; return when all are done.

    The first exception of any chunk is raised here. KeyboardInterrupt stops after the chunks in
    hand, so chunks should take milliseconds.
    """
    if count <= 0:
        return
    if count <= chunk and progress is None:
        work(0, count)
        return
    threads = min(thread_count(), -(-count // chunk))
    state = _Work(work, count, chunk)
    if threads == 1 and progress is None:
        while (piece := state.take()) is not None:
            work(*piece)
        return
    crew = [threading.Thread(target=state.run, name=f"conicoid-{i}", daemon=True) for i in range(threads)]
    for thread in crew:
        thread.start()
    try:
        finished = False
        while not finished:
            with state.changed:
                if state.done < count and state.error is None:
                    state.changed.wait(0.1)
                done = state.done
                finished = done == count or state.error is not None
            if progress is not None:
                progress(done, count)
    except KeyboardInterrupt:
        ahead.stop()
        raise
    finally:
        state.stop()
        for thread in crew:
            thread.join()
    if state.error is not None:
        raise state.error
