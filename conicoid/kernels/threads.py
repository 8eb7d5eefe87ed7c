"""Our own thread pool: chunks of rays or tiles, progress, and Ctrl-C that stops at once.

Kernels release the interpreter lock, so plain threads run them in parallel, side by side with
other threads, Dask workers or notebooks (Numba's own pool is not safe to share).

Only the main thread receives Ctrl-C, and only while it is in Python. So it waits for the others, except for work of
a moment. Work on a scene (`run_on`) gets a copy of the geometry's places, in which kernels read
whether they are to end: one ray may cross a hundred thousand leaves.
"""

from __future__ import annotations

import contextlib
import os
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

from .._jit.interruptible import PATIENCE, is_main_thread, join_threads, start_thread
from .._util.environment import MOST_THREADS, read_threads
from .._util.hints import with_call_hints
from .._util.validation import as_integer, format_value
from .tables import HALT, STEPS, Geometry

Progress = Callable[[int, int], None]
"""Called now and then as progress(done, count)."""

_AT_ONCE = 1 << 24
"""So many steps of rays the main thread takes itself: some tens of milliseconds."""
_BRIEF = 1 << 11
"""So many steps of rays are too few for several threads: a millisecond of work, and starting them takes some tenths."""
_SHORT, _LONG = 0.01, 0.04
"""Seconds that a chunk should take, at least and at most, where its number of rays does not predict it."""
_FIRST = 8  # the first chunk is so many times smaller than the largest

_chosen: list[int] = []


class _Limit(threading.local):
    """Threads that work begun in this thread may use; None for no limit."""

    count: int | None = None


_limit = _Limit()


def thread_count() -> int:
    """Threads in use: `limited_to`, `set_threads`, CONICOID_THREADS, or the processors that the process may use.

    Raises ValueError where CONICOID_THREADS says something else than a number.
    """
    if _limit.count is not None:
        return _limit.count
    if _chosen:
        return _chosen[-1]
    wanted = read_threads()
    if wanted is not None:
        return wanted
    if hasattr(os, "sched_getaffinity"):
        return max(1, len(os.sched_getaffinity(0)))
    return max(1, os.cpu_count() or 1)


@with_call_hints
def set_threads(count: int | None) -> None:
    """Use `count` threads from now on; None returns to the default."""
    wanted = None if count is None else as_integer(count)
    if count is not None and (wanted is None or not 1 <= wanted <= MOST_THREADS):
        raise ValueError(
            f"set_threads: count must be an integer from 1 to {MOST_THREADS} or None, got {format_value(count)}"
        )
    _chosen[:] = [] if wanted is None else [wanted]


@contextlib.contextmanager
def limit_threads(count: int | None) -> Iterator[None]:
    """A block of this thread whose work takes `count` threads: a task of a worker that has others beside it."""
    before = _limit.count
    _limit.count = count
    try:
        yield
    finally:
        _limit.count = before


def chunk_size(count: int, most: int) -> int:
    """How much of some work a thread should take at a time: `most`, or so little that each has several turns."""
    return max(1, min(most, count // (8 * thread_count()))) if count >= 8 else 1


class _Work:
    """Chunks still to be done, shared by a few threads."""

    def __init__(self, work: Callable[[int, int], Any], count: int, chunk: int, timed: bool) -> None:
        self.work, self.count, self.chunk, self.timed = work, count, chunk, timed
        self.next = 0
        self.done = 0
        self.error: BaseException | None = None
        self.lock = threading.Lock()
        self.changed = threading.Condition(self.lock)

    def take(self, size: int) -> tuple[int, int] | None:
        """The next chunk of about a size; None if there is none, or after an error."""
        with self.lock:
            if self.next >= self.count or self.error is not None:
                return None
            begin = self.next
            self.next = min(self.count, begin + size)
            return begin, self.next

    def run(self) -> None:
        """Work on chunks until there are none: what each thread does."""
        size = max(1, self.chunk // _FIRST) if self.timed else self.chunk
        while (piece := self.take(size)) is not None:
            began = time.perf_counter()
            try:
                self.work(*piece)
            except BaseException as error:  # handed to the caller's thread
                with self.changed:
                    self.error = self.error or error
                    self.changed.notify_all()
                return
            if self.timed:
                size = next_size(size, time.perf_counter() - began, self.chunk)
            with self.changed:
                self.done += piece[1] - piece[0]
                self.changed.notify_all()

    def stop(self) -> None:
        """Give out no more chunks."""
        with self.changed:
            self.next = self.count


def next_size(size: int, seconds: float, most: int) -> int:
    """How large the next chunk should be after one that took some seconds."""
    if seconds < _SHORT:
        return min(most, 2 * size)
    return max(1, int(size * _SHORT / seconds)) if seconds > _LONG else size


def run_chunks(work: Callable[[int, int], Any], count: int, chunk: int, progress: Progress | None = None) -> None:
    """Call work(begin, end) for every chunk of range(count) on all threads; return when all are done.

    The first exception of any chunk is raised here. KeyboardInterrupt stops after the chunks in
    hand, so chunks should take milliseconds.
    """
    if count <= 0:
        return
    if progress is None and (count <= chunk or thread_count() == 1):
        _run_serially(work, count, chunk)
    else:
        _run_on_threads(_Work(work, count, chunk, False), progress, lambda: None)


def run_on(
    geometry: Geometry, work: Callable[[Geometry, int, int], Any], count: int, chunk: int, rays: int,
    progress: Progress | None = None,
) -> None:  # fmt: skip
    """`run_chunks` for work(geometry, begin, end) on `rays` rays in all, by kernels that end early at Ctrl-C.

    Chunks grow up to the given size, or shrink to one, so that each takes some tens of milliseconds.
    """
    if count <= 0:
        return
    if progress is None and (count <= chunk or thread_count() == 1) and not _keeps_waiting(geometry, rays):
        _run_serially(lambda begin, end: work(geometry, begin, end), count, chunk)
        return
    mine = geometry._replace(places=geometry.places.copy())

    def halt() -> None:
        """Have the kernels end early."""
        mine.places[HALT] = 1

    _run_on_threads(_Work(lambda begin, end: work(mine, begin, end), count, chunk, True), progress, halt)


def chunk_of_rays(geometry: Geometry, count: int, most: int, rays: int) -> int:
    """`chunk_size` of `count` packets of `rays` rays in all; the whole where it is too brief for several threads.

    Of the steps that a ray may take at most, a line through many bodies takes about the square root.
    """
    brief = rays * rays * int(geometry.places[STEPS]) <= _BRIEF * _BRIEF
    return count if brief else chunk_size(count, most)


def _keeps_waiting(geometry: Geometry, rays: int) -> bool:
    """Might this thread react late to Ctrl-C, if it did the work itself?"""
    return is_main_thread() and rays * int(geometry.places[STEPS]) > _AT_ONCE


def _run_serially(work: Callable[[int, int], Any], count: int, chunk: int) -> None:
    """Do all of the work on this thread."""
    for begin in range(0, count, chunk):
        work(begin, min(count, begin + chunk))


def _run_on_threads(state: _Work, progress: Progress | None, halt: Callable[[], None]) -> None:
    """Do the work on several threads, as many as the system gives; this one waits, and reports the progress."""
    crew: list[threading.Thread] = []
    finished = False
    try:
        for i in range(min(thread_count(), -(-state.count // state.chunk))):
            thread = start_thread(state.run, f"conicoid-{i}")
            if thread is None:
                break
            crew.append(thread)
        if not crew:
            state.run()
        while not finished:
            with state.changed:
                if state.done < state.count and state.error is None:
                    state.changed.wait(0.1)
                done = state.done
                finished = done == state.count or state.error is not None
            if progress is not None:
                progress(done, state.count)
    finally:
        state.stop()
        whole = state.done == state.count
        if not whole:
            halt()
        join_threads(crew, None if whole else PATIENCE)
    if state.error is not None:
        raise state.error
