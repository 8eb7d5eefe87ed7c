"""Threads for kernels: chunks of rays or tiles, progress, and Ctrl-C that stops at once.

The threads of the extension (`native/pool.c`) take the chunks of one kernel (`KernelRange`), so that Python calls it
once. Plain threads take chunks of other work, and all where there is no extension: kernels release the interpreter
lock, and run side by side with other threads, Dask workers or notebooks (Numba's own pool is not safe to share).

Only the main thread receives Ctrl-C, and only while it runs Python code. So it waits for the other threads, except for
very short work. Work on a scene (`run_on`) gets a copy of the geometry's places, in which kernels read the halt flag:
a single ray may cross a hundred thousand leaves, too many to wait for.
"""

from __future__ import annotations

import contextlib
import os
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from .._jit.interruptible import PATIENCE, is_main_thread, join_threads, start_thread
from .._jit.machine_code import SHIPPED, is_shipped
from .._util.environment import MOST_THREADS, read_threads
from .._util.validation import as_integer, format_value
from .tables import HALT, STEPS, Geometry

if TYPE_CHECKING:
    from queue import SimpleQueue

Progress = Callable[[int, int], None]
"""Callback progress(done, count), called from time to time."""

_AT_ONCE = 1 << 24
"""Most steps of rays that the main thread takes itself, without watching for Ctrl-C: some tens of milliseconds."""
_BRIEF = 1 << 11
"""Most steps of rays for one thread: a millisecond of work, where starting threads takes some tenths of one."""
_SHORT, _LONG = 0.01, 0.04
"""Shortest and longest time in seconds that a chunk should take, if its number of rays does not predict the time."""
_WATCH = 50  # milliseconds after which the main thread sees Ctrl-C
_FIRST = 8  # the first chunk is smaller than the largest by this factor

_chosen: list[int] = []


class _Limit(threading.local):
    """Number of threads for work that starts in this thread; None for no limit."""

    count: int | None = None


_limit = _Limit()


def thread_count() -> int:
    """Return the number of threads that queries use.

    The first of these counts: `limit_threads`, `set_threads`, CONICOID_THREADS, the processors that the process may
    use.

    Raises
    ------
    ValueError
        If CONICOID_THREADS is not a number of threads.
    """
    if _limit.count is not None:
        return _limit.count
    if _chosen:
        return _chosen[-1]
    requested = read_threads()
    if requested is not None:
        return requested
    if hasattr(os, "sched_getaffinity"):
        return max(1, len(os.sched_getaffinity(0)))
    return max(1, os.cpu_count() or 1)


def set_threads(count: int | None) -> None:
    """Use `count` threads from now on.

    Parameters
    ----------
    count : int or None
        Number of threads; None returns to the default.

    Raises
    ------
    ValueError
        If `count` is not an integer from 1 to the largest allowed number.
    """
    requested = None if count is None else as_integer(count)
    if count is not None and (requested is None or not 1 <= requested <= MOST_THREADS):
        raise ValueError(
            f"set_threads: count must be an integer from 1 to {MOST_THREADS} or None, got {format_value(count)}"
        )
    _chosen[:] = [] if requested is None else [requested]


@contextlib.contextmanager
def limit_threads(count: int | None) -> Iterator[None]:
    """Limit the work that starts in this thread within a `with` block to `count` threads, None for no limit.

    Tasks of a worker process use it if other workers share the machine.
    """
    before = _limit.count
    _limit.count = count
    try:
        yield
    finally:
        _limit.count = before


def chunk_size(count: int, most: int) -> int:
    """Return the number of items that a thread takes at a time: at most `most`, and about 8 chunks for each thread."""
    return max(1, min(most, count // (8 * thread_count()))) if count >= 8 else 1


@dataclass(frozen=True)
class KernelRange:
    """A kernel for each part of a range, kernel(*before, begin, end, *after); with `run_on` a geometry comes first."""

    kernel: Callable[..., Any]
    before: tuple[Any, ...]
    after: tuple[Any, ...]

    def __call__(self, begin: int, end: int) -> None:
        self.kernel(*self.before, begin, end, *self.after)


class _Work:
    """The remaining chunks of some work, shared by the threads that do it.

    The thread that waits for the others takes no lock of Python: Ctrl-C may come just after it has taken one, which
    then nobody gives back. It only reads `reports`, whose `get` is one call of C, and sets `stopped`.
    """

    def __init__(self, work: Callable[[int, int], Any], count: int, chunk: int, timed: bool) -> None:
        from queue import SimpleQueue  # here, since small queries start sooner without it

        self.work, self.count, self.chunk, self.timed = work, count, chunk, timed
        self.next = 0
        self.stopped = False
        self.lock = threading.Lock()
        self.reports: SimpleQueue[int | BaseException] = SimpleQueue()
        """The number of items of each chunk that is done, or the exception that ended it."""

    def take(self, size: int) -> tuple[int, int] | None:
        """Return (begin, end) of the next chunk of at most `size` items; None if none is left, or after a stop."""
        with self.lock:
            if self.next >= self.count or self.stopped:
                return None
            begin = self.next
            self.next = min(self.count, begin + size)
            return begin, self.next

    def run(self) -> None:
        """Work on chunks until none is left: the body of each thread."""
        size = max(1, self.chunk // _FIRST) if self.timed else self.chunk
        while (piece := self.take(size)) is not None:
            began = time.perf_counter()
            try:
                self.work(*piece)
            except BaseException as error:  # the caller's thread raises it
                self.stopped = True
                self.reports.put(error)
                return
            if self.timed:
                size = next_size(size, time.perf_counter() - began, self.chunk)
            self.reports.put(piece[1] - piece[0])


def next_size(size: int, seconds: float, most: int) -> int:
    """Return the size of the next chunk after one of `size` items that took `seconds`."""
    if seconds < _SHORT:
        return min(most, 2 * size)
    return max(1, int(size * _SHORT / seconds)) if seconds > _LONG else size


def run_chunks(work: Callable[[int, int], Any], count: int, chunk: int, progress: Progress | None = None) -> None:
    """Call work(begin, end) for every chunk of range(count) on all threads; return when all are done.

    Raises the first exception of any chunk. KeyboardInterrupt stops after the chunks in progress, so a chunk should
    take milliseconds.
    """
    if count <= 0:
        return
    if progress is None and (count <= chunk or thread_count() == 1):
        _run_serially(work, count, chunk)
    elif progress is None and isinstance(work, KernelRange) and is_shipped(work.kernel):
        _run_in_pool(work, count, chunk, lambda: None)
    else:
        _run_on_threads(_Work(work, count, chunk, False), progress, lambda: None)


def run_on(
    geometry: Geometry, work: Callable[[Geometry, int, int], Any] | KernelRange, count: int, chunk: int, rays: int,
    progress: Progress | None = None,
) -> None:  # fmt: skip
    """`run_chunks` for work(geometry, begin, end) whose kernels end early at Ctrl-C; `rays` is the number of all rays.

    Chunks grow up to `chunk` or shrink down to 1, so that each takes some tens of milliseconds.
    """
    if count <= 0:
        return
    if (
        progress is None
        and (count <= chunk or thread_count() == 1)
        and (is_brief(geometry, rays) or not is_main_thread())
    ):
        _run_serially(_with_geometry(work, geometry), count, chunk)
        return
    mine = geometry._replace(places=geometry.places.copy())

    def halt() -> None:
        """Make the kernels end early."""
        mine.places[HALT] = 1

    ours = _with_geometry(work, mine)
    if progress is None and isinstance(ours, KernelRange) and is_shipped(ours.kernel):
        _run_in_pool(ours, count, chunk, halt)
    else:
        _run_on_threads(_Work(ours, count, chunk, True), progress, halt)


def _with_geometry(work: Any, geometry: Geometry) -> Callable[[int, int], Any]:
    """Return the work of `run_on` with its first argument."""
    if isinstance(work, KernelRange):
        return KernelRange(work.kernel, (geometry, *work.before), work.after)
    return lambda begin, end: work(geometry, begin, end)


def chunk_of_rays(geometry: Geometry, count: int, most: int, rays: int) -> int:
    """Return `chunk_size` for `count` packets of `rays` rays in all; `count` if the work is too brief for threads."""
    # A line through many bodies takes about the square root of the steps that it could take at most: squares of both
    brief = rays * rays * int(geometry.places[STEPS]) <= _BRIEF * _BRIEF
    return count if brief else chunk_size(count, most)


def is_brief(geometry: Geometry, rays: int = 1) -> bool:
    """True if some rays take so few steps that no thread needs to watch for Ctrl-C."""
    return rays * int(geometry.places[STEPS]) <= _AT_ONCE


def _run_serially(work: Callable[[int, int], Any], count: int, chunk: int) -> None:
    """Do all work on this thread."""
    for begin in range(0, count, chunk):
        work(begin, min(count, begin + chunk))


_left: list[Any] = []
"""Work of kernels that was interrupted: its memory is kept until all threads have ended theirs."""


def _run_in_pool(work: KernelRange, count: int, chunk: int, halt: Callable[[], None]) -> None:
    """Do the work on threads of the extension; the main thread waits for Ctrl-C, others take part."""
    _left[:] = [pieces for pieces in _left if not pieces.wait(0)]
    pieces = SHIPPED.pieces(work.kernel, (*work.before, 0, count, *work.after), chunk)
    try:
        threads, helps = min(thread_count(), -(-count // chunk)), not is_main_thread()
        if (threads > helps and pieces.start(threads - helps) == 0) or helps:
            pieces.help()
        while not pieces.wait(_WATCH):
            pass
    except BaseException:
        _left.append(pieces)
        pieces.stop()
        halt()
        last = time.monotonic() + PATIENCE
        while not pieces.wait(_WATCH) and time.monotonic() < last:
            pass
        raise
    done = pieces.done  # raises MemoryError where a kernel had too little
    assert done == count


def _run_on_threads(state: _Work, progress: Progress | None, halt: Callable[[], None]) -> None:
    """Do the work on as many threads as the system starts; this thread waits, and reports the progress."""
    crew: list[threading.Thread] = []
    done = 0
    try:
        for i in range(min(thread_count(), -(-state.count // state.chunk))):
            thread = start_thread(state.run, f"conicoid-{i}")
            if thread is None:
                break
            crew.append(thread)
        if not crew:  # the system refused even one thread
            state.run()
        while done < state.count:
            done += _next_report(state.reports)
            if progress is not None:
                progress(done, state.count)
    finally:
        state.stopped = True
        if done < state.count:  # an error, or Ctrl-C: kernels shall end early
            halt()
        join_threads(crew, None if done == state.count else PATIENCE)


def _next_report(reports: SimpleQueue[int | BaseException]) -> int:
    """Return the number of items that are newly done, 0 after a tenth of a second without any; raise a chunk's error.

    All reports that have come are taken at once, so that many short chunks do not wake this thread each.
    """
    from queue import Empty

    done = 0
    with contextlib.suppress(Empty):
        report = reports.get(timeout=0.1)
        while True:
            if isinstance(report, BaseException):
                raise report
            done += report
            report = reports.get_nowait()
    return done
