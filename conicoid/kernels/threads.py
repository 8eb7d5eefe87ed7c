"""Threads for kernels: chunks of rays or tiles, progress, and Ctrl-C that stops at once.

The threads of the extension (`native/pool.c`) take the chunks of one kernel (`KernelRange`), or many calls of one
(`run_calls`), so that Python calls it once. Plain threads take chunks of Python functions, and all where there is no
extension: kernels release the interpreter lock, and run side by side with other threads, Dask workers or notebooks
(Numba's own pool is not safe to share).

Only the main thread receives Ctrl-C, and only while it runs Python code. So it waits for the other threads, except for
very short work. Work on a scene (`run_on`) gets a copy of the geometry's places, in which kernels read the halt flag:
a single ray may cross a hundred thousand leaves, too many to wait for.
"""

from __future__ import annotations

import contextlib
import os
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from .._jit.machine_code import SHIPPED, shipped_kernel
from .._util.environment import MOST_THREADS, read_threads
from .._util.process import PATIENCE, is_main_thread, join_threads, start_thread
from .._util.records import dataclass
from .._util.validation import as_integer, format_value
from .tables import HALT, STEPS, Geometry

if TYPE_CHECKING:
    from queue import SimpleQueue

Progress = Callable[[int, int], None]
"""Callback progress(done, count), called from time to time."""
Outcomes = list[tuple[int, int, Any]]
"""The (begin, end, result) of each chunk of a kernel, in no order; empty if it returns nothing."""
Marks = npt.NDArray[np.int8]
"""A 1 for each item that is done."""

_AT_ONCE = 1 << 24
"""Most steps of rays that the main thread takes itself, without watching for Ctrl-C: some tens of milliseconds."""
_BRIEF = 1 << 11
"""Most steps of rays for one thread: a millisecond of work, where starting threads takes some tenths of one."""
_SHORT, _LONG = 0.01, 0.04
"""Shortest and longest time in seconds that a chunk should take, if its number of rays does not predict the time."""
_WATCH = 50  # milliseconds after which the main thread sees Ctrl-C
_FIRST = 8  # the first chunk is smaller than the largest by this factor

_requests: list[int] = []


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
    if _requests:
        return _requests[-1]
    requested = read_threads()
    return _processor_count() if requested is None else requested


def _processor_count() -> int:
    """Return the number of processors that the process may use."""
    if hasattr(os, "sched_getaffinity"):
        return max(1, len(os.sched_getaffinity(0)))
    return max(1, os.cpu_count() or 1)


def set_threads(count: int | None) -> None:
    """Use `count` threads from now on. Threads beyond these that wait for work end.

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
    _requests[:] = [] if requested is None else [requested]
    if SHIPPED is not None:
        SHIPPED.keep_threads(requested or _processor_count())


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
    first: int = 0
    """The item of the kernel that is number 0 of the range."""

    def __call__(self, begin: int, end: int) -> Any:
        return self.kernel(*self.arguments(begin, end))

    def arguments(self, begin: int, end: int) -> tuple[Any, ...]:
        """Return the kernel's arguments for items begin..end."""
        return (*self.before, self.first + begin, self.first + end, *self.after)

    @property
    def takes_threads(self) -> bool:
        """Whether the threads of the extension can call the kernel."""
        return shipped_kernel(self.kernel) is not None


class _Work:
    """The remaining chunks of some work, shared by the threads that do it.

    The thread that waits for the others takes no lock of Python: Ctrl-C may come just after it has taken one, which
    then nobody gives back. It only reads `reports`, whose `get` is one call of C, and sets `stopped`.
    """

    def __init__(
        self, work: Callable[[int, int], Any], count: int, chunk: int, timed: bool, marks: Marks | None
    ) -> None:
        from queue import SimpleQueue  # here, since small queries start sooner without it

        self.work, self.count, self.chunk, self.timed, self.marks = work, count, chunk, timed, marks
        self.next = 0
        self.stopped = False
        self.lock = threading.Lock()
        self.reports: SimpleQueue[int | BaseException] = SimpleQueue()
        """The number of items of each chunk that is done, or the exception that ended it."""
        self.outcomes: Outcomes = []
        self.crew: list[threading.Thread] = []

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
                _do(self.work, *piece, self.outcomes, self.marks)
            except BaseException as error:  # the caller's thread raises it
                self.stopped = True
                self.reports.put(error)
                return
            if self.timed:
                size = next_size(size, time.perf_counter() - began, self.chunk)
            self.reports.put(piece[1] - piece[0])

    def wait(self, milliseconds: int) -> bool:
        """Wait for the threads. True if all have ended."""
        join_threads(self.crew, milliseconds / 1000)
        return not any(thread.is_alive() for thread in self.crew)


def next_size(size: int, seconds: float, most: int) -> int:
    """Return the size of the next chunk after one of `size` items that took `seconds`."""
    if seconds < _SHORT:
        return min(most, 2 * size)
    return max(1, int(size * _SHORT / seconds)) if seconds > _LONG else size


def _do(work: Callable[[int, int], Any], begin: int, end: int, outcomes: Outcomes, marks: Marks | None) -> None:
    """Do the chunk begin..end."""
    result = work(begin, end)
    if result is not None:
        outcomes.append((begin, end, result))
    if marks is not None:
        marks[begin:end] = 1


def run_chunks(work: Callable[[int, int], Any], count: int, chunk: int) -> Outcomes:
    """Call work(begin, end) for every chunk of range(count) on all threads; return when all are done.

    Raises the first exception of any chunk. KeyboardInterrupt stops after the chunks in progress, so a chunk should
    take milliseconds.
    """
    if count <= 0:
        return []
    if count <= chunk or thread_count() == 1:
        return _run_serially(work, count, chunk, None)
    if isinstance(work, KernelRange) and work.takes_threads:
        return _run_in_pool(_pieces_of(work, count, chunk, None), count, chunk)
    return _run_on_threads(_Work(work, count, chunk, False, None))


_ROWS = 16384  # rows that a thread takes at a time


def run_rows(
    kernel: Callable[..., Any], before: tuple[Any, ...], count: int, *fields: Any, most: int = _ROWS
) -> None:  # fmt: skip
    """Let kernel(*before, begin, end, *fields) write `count` rows of fields, `most` at a time; at once if no more."""
    if count <= most:
        kernel(*before, 0, count, *fields)
    else:
        run_chunks(KernelRange(kernel, before, fields), count, most)


def run_calls(kernel: Callable[..., Any], calls: Sequence[tuple[Any, ...]]) -> list[Any]:
    """Return the results of a kernel for tuples of arguments, on all threads: for calls of a millisecond or more."""
    shipped = shipped_kernel(kernel)
    if shipped is None or len(calls) < 2 or thread_count() == 1:
        outcomes = run_chunks(lambda k, _: kernel(*calls[k]), len(calls), 1)
    else:
        outcomes = _run_in_pool(SHIPPED.calls(shipped, tuple(calls)), len(calls), 1)
    return [result for _, _, result in sorted(outcomes, key=_begin)]


def _begin(outcome: tuple[int, int, Any]) -> int:
    """Return where a chunk begins."""
    return outcome[0]


def run_on(
    geometry: Geometry, work: Callable[[Geometry, int, int], Any] | KernelRange, count: int, chunk: int, rays: int,
    progress: Progress | None = None, marks: Marks | None = None,
) -> Outcomes:  # fmt: skip
    """`run_chunks` for work(geometry, begin, end) whose kernels end early at Ctrl-C; `rays` is the number of all rays.

    Chunks of Python functions grow up to `chunk` or shrink down to 1, so that each takes some tens of milliseconds.
    """
    if count <= 0:
        return []
    if (
        progress is None
        and (count <= chunk or thread_count() == 1)
        and (is_brief(geometry, rays) or not is_main_thread())
    ):
        return _run_serially(_with_geometry(work, geometry), count, chunk, marks)
    mine = geometry._replace(places=geometry.places.copy())

    def halt() -> None:
        """Make the kernels end early."""
        mine.places[HALT] = 1

    ours = _with_geometry(work, mine)
    if isinstance(ours, KernelRange) and ours.takes_threads:
        return _run_in_pool(_pieces_of(ours, count, chunk, marks), count, chunk, progress, halt)
    return _run_on_threads(_Work(ours, count, chunk, True, marks), progress, halt)


def _with_geometry(work: Any, geometry: Geometry) -> Callable[[int, int], Any]:
    """Return the work of `run_on` with its first argument."""
    if isinstance(work, KernelRange):
        return replace(work, before=(geometry, *work.before))
    return lambda begin, end: work(geometry, begin, end)


def marked_items(marks: Marks) -> npt.NDArray[np.int64]:
    """Return the items with a mark; this thread sees from now on the results that others wrote for them."""
    items = np.flatnonzero(marks)
    if SHIPPED is not None:
        SHIPPED.acquire()
    return items


def chunk_of_rays(geometry: Geometry, count: int, most: int, rays: int) -> int:
    """Return `chunk_size` for `count` packets of `rays` rays in all; `count` if the work is too brief for threads."""
    # A line through many bodies takes about the square root of the steps that it could take at most: squares of both
    brief = rays * rays * int(geometry.places[STEPS]) <= _BRIEF * _BRIEF
    return count if brief else chunk_size(count, most)


def is_brief(geometry: Geometry, rays: int = 1) -> bool:
    """True if some rays take so few steps that no thread needs to watch for Ctrl-C."""
    return rays * int(geometry.places[STEPS]) <= _AT_ONCE


def _run_serially(work: Callable[[int, int], Any], count: int, chunk: int, marks: Marks | None) -> Outcomes:
    """Do all work on this thread."""
    outcomes: Outcomes = []
    for begin in range(0, count, chunk):
        _do(work, begin, min(count, begin + chunk), outcomes, marks)
    return outcomes


_stragglers: list[Any] = []
"""Work that was interrupted: its memory is kept until all threads have ended theirs."""


def has_ended(seconds: float) -> bool:
    """Wait for so many seconds until threads have ended all work that was interrupted. True if they have."""
    last = time.monotonic() + seconds
    while _stragglers and time.monotonic() < last:
        _drop_ended(_WATCH)
    return not _stragglers


def _drop_ended(milliseconds: int) -> None:
    """Drop interrupted work that has ended, or that ends in so many milliseconds each."""
    _stragglers[:] = [work for work in _stragglers if not work.wait(milliseconds)]


def _pieces_of(work: KernelRange, count: int, chunk: int, marks: Marks | None) -> Any:
    """Return the chunks of a kernel for the threads of the extension."""
    return SHIPPED.pieces(shipped_kernel(work.kernel), work.arguments(0, count), chunk, marks)


def _no_halt() -> None:
    """Halt nothing: the chunks are short."""


def _run_in_pool(
    pieces: Any, count: int, chunk: int, progress: Progress | None = None, halt: Callable[[], None] = _no_halt
) -> Outcomes:
    """Do the work on threads of the extension; the main thread waits for Ctrl-C, others help or report progress."""
    _drop_ended(0)
    try:
        threads, helps = min(thread_count(), -(-count // chunk)), progress is None and not is_main_thread()
        if (threads > helps and pieces.start(threads - helps) == 0) or helps:
            pieces.help()
        while not pieces.wait(_WATCH):
            if progress is not None:
                progress(pieces.done, count)
        done = pieces.done  # raises MemoryError where a kernel had too little
        if progress is not None:
            progress(done, count)
    except BaseException:
        _stragglers.append(pieces)
        pieces.stop()
        halt()
        last = time.monotonic() + PATIENCE
        while not pieces.wait(_WATCH) and time.monotonic() < last:
            pass
        _drop_ended(0)
        raise
    assert done == count
    return pieces.results()


def _run_on_threads(state: _Work, progress: Progress | None = None, halt: Callable[[], None] = _no_halt) -> Outcomes:
    """Do the work on as many threads as the system starts; this thread waits, and reports the progress."""
    _drop_ended(0)
    done = 0
    try:
        for i in range(min(thread_count(), -(-state.count // state.chunk))):
            thread = start_thread(state.run, f"conicoid-{i}")
            if thread is None:
                break
            state.crew.append(thread)
        if not state.crew:  # the system refused even one thread
            state.run()
        while done < state.count:
            done += _next_report(state.reports)
            if progress is not None:
                progress(done, state.count)
    finally:
        state.stopped = True
        if done < state.count:  # an error, or Ctrl-C: kernels shall end early
            _stragglers.append(state)
            halt()
        # Kernels read the halt flag and end soon; other chunks run to their end
        patience = PATIENCE if halt is not _no_halt else _WATCH / 1000
        join_threads(state.crew, None if done == state.count else patience)
    return state.outcomes


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
