"""`Workers` around any executor, the standard library's, Dask's, or this process itself; and their scheduler.

Only Dask needs an executor of its own, since tasks that it has given up, or results that it lost, leave futures open
for ever. `tests/cluster/test_losses.py` has each of these cases.
"""

from __future__ import annotations

import contextlib
import copy
import os
import platform
import pydoc
import time
import weakref
from collections import deque
from collections.abc import Callable, Generator, Iterator
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future, ThreadPoolExecutor
from typing import Any, NamedTuple

import numpy as np

from .._util.records import align_array, dataclass
from .._util.validation import check_callback, check_integer, check_path as checked_path, describe_kind
from .._util.version import __version__
from ..kernels.threads import Progress, limit_threads
from ..queries.overlaps import collect_notes, log_once
from .shared_state import SharedObject, SharedReference, find_shared, source_version


class LostTaskError(RuntimeError):
    """A task lost its worker, result or connection: it may be sent again."""


class DaskExecutor(Executor):
    """A client of Dask as an executor whose tasks always have an outcome.

    Dask's own executor, `client.get_executor()`, names tasks by their content. So a task that Dask has given up, as
    its workers died, fails again at once however often it is sent. And if a result is lost while it is fetched, with
    a worker or with the scheduler, its future stays open for ever if the task then fails.

    `source` is the client's own executor, if the user passed that.
    """

    def __init__(self, client: Any, source: Any = None) -> None:
        self.client, self._source = client, source
        # pure=False gives each task a key of its own, so that a lost one can be sent again.
        self._options: dict[str, Any] = dict(getattr(source, "_kwargs", {})) | dict(pure=False)
        self._futures: weakref.WeakSet[Any] = weakref.WeakSet()
        self._is_open = True

    @property
    def is_open(self) -> bool:
        """Whether it takes tasks, and returns those already sent."""
        return self._is_open and not getattr(self._source, "_shutdown", False) and self.client.status != "closed"

    @property
    def count(self) -> int:
        """Threads of all workers; 1 if none has come yet, or the scheduler does not answer."""
        try:
            return max(1, sum(map(int, self.client.ncores().values())))
        except Exception:  # such as a closed client: `submit` reports it
            return 1

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        if not self.is_open:
            raise RuntimeError("cannot schedule new futures after shutdown")
        task = self.client.submit(fn, *args, **kwargs, **self._options)
        self._futures.add(task)
        future: Future[Any] = Future()
        # Cancelling the future cancels the task of Dask.
        future.add_done_callback(lambda done: task.cancel() if done.cancelled() else None)
        self.client.loop.add_callback(_relay, self.client, task, future)
        return future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Take no more tasks; the client stays open."""
        self._is_open = False
        if cancel_futures:
            self.client.cancel(list(self._futures))


async def _relay(client: Any, task: Any, future: Future[Any]) -> None:
    """Wait for a task of Dask, and set the outcome of its future in every case."""
    try:
        value = await client.gather(task, asynchronous=True)
    except BaseException as error:  # also if the loop ends: the future must not stay open
        outcome = error if task.status == "error" else LostTaskError(f"{type(error).__name__}: {error}")
        _resolve(future, outcome, False)
        if not isinstance(error, Exception):
            raise
    else:
        _resolve(future, value, True)


def _resolve(future: Future[Any], outcome: Any, is_value: bool) -> None:
    """Set the outcome of a future, unless it is cancelled."""
    if future.set_running_or_notify_cancel():
        (future.set_result if is_value else future.set_exception)(outcome)


# Executors of all kinds as one: `Workers`.

_BYTES, _BYTES_OF_DASK = 32 << 20, 8 << 20
"""The most bytes to send with a task. (Dask warns from 10 MB on.)"""


class Workers:
    """An executor with options beyond its interface.

    As a context manager it shuts the executor down at the end.

    Parameters
    ----------
    executor : Executor, Client or callable
        A `concurrent.futures.Executor` or another object with its `submit`: the standard library's, loky's, mpi4py's,
        `client.get_executor()` of Dask; a Dask `Client`; or a function without arguments that makes one. The function
        is called again if a pool breaks because a process of it died.
    chunk : int, optional
        Rays, points or tiles of a task. None: about a second's work, by the measured rate.
    window : int, optional
        The most tasks that are sent and not yet back; it bounds the memory. None: three for each worker.
    retries : int
        How often a task is sent again after its worker was lost.
    threads : int, optional
        Threads of a task on its worker: 1 if the executor has a worker for each processor.
    progress : callable, optional
        progress(done, count) is called now and then.
    store : path, optional
        A folder that workers share, with files of prepared tables. Workers map them instead of preparing a large scene
        each. The folder keeps them for later runs. None: a folder of this machine, as long as the scene is in use. Only
        you should be able to write to it.

    Raises
    ------
    TypeError
        If `executor` is no executor.
    ValueError
        If a number is out of range.
    """

    def __init__(
        self, executor: Any, *, chunk: int | None = None, window: int | None = None, retries: int = 3,
        threads: int | None = 1, progress: Progress | None = None, store: str | os.PathLike[str] | None = None,
    ) -> None:  # fmt: skip
        check_callback("Workers", "progress", progress)
        self.chunk, self.window, self.threads = (
            None if number is None else check_integer("Workers", name, number, 1)
            for name, number in (("chunk", chunk), ("window", window), ("threads", threads))
        )
        self.retries = check_integer("Workers", "retries", retries, 0)
        self.progress = progress
        self.store = None if store is None else _folder(store)
        self._make: Callable[[], Any] | None = None if _submits(executor) or not callable(executor) else executor
        self.executor: Any = _as_executor("Workers", self._make() if self._make else executor)

    @property
    def count(self) -> int:
        """Workers that run at the same time, if the executor knows; else the processors of this machine."""
        if isinstance(self.executor, DaskExecutor):
            return self.executor.count
        for name in ("_max_workers", "num_workers"):
            found = getattr(self.executor, name, None)
            if isinstance(found, int) and found > 0:
                return found
        return os.cpu_count() or 1

    @property
    def is_dask(self) -> bool:
        """Whether the executor is one of Dask."""
        return isinstance(self.executor, DaskExecutor)

    @property
    def are_threads(self) -> bool:
        """Whether the workers are threads of this process, with all its objects."""
        return isinstance(self.executor, ThreadPoolExecutor) or getattr(self.executor, "is_here", False)

    @property
    def most_bytes(self) -> int:
        """The most bytes to send with one task."""
        return _BYTES_OF_DASK if self.is_dask else _BYTES

    def changed(self, **options: Any) -> Workers:
        """Return workers on the same executor with other options."""
        other = copy.copy(self)
        vars(other).update(options)
        return other

    def renew(self, broken: Any) -> bool:
        """Replace a broken executor by a new one. Return False if there is no function that makes one."""
        # Another task of the same pool has already replaced it.
        if self.executor is not broken:
            return True
        if self._make is None:
            return False
        # Do not wait for processes that may never answer.
        broken.shutdown(wait=False)
        self.executor = _as_executor("Workers", self._make())
        return True

    def __enter__(self) -> Workers:
        return self

    def __exit__(self, *_: object) -> None:
        self.executor.shutdown()


def as_workers(owner: str, executor: Any, progress: Progress | None = None) -> Workers:
    """Return the `Workers` of an argument `executor=`."""
    workers = executor if isinstance(executor, Workers) else Workers(_as_executor(owner, executor))
    if progress is None:
        return workers
    return workers.changed(progress=progress)


def _submits(executor: Any) -> bool:
    """Return whether an object has `submit`, and is no class."""
    return callable(getattr(executor, "submit", None)) and not isinstance(executor, type)


def _as_executor(owner: str, executor: Any) -> Any:
    """Return an executor; a Dask client, or its own executor, becomes a `DaskExecutor`."""
    if not _submits(executor):
        raise TypeError(
            f"{owner}: executor must be a concurrent.futures.Executor or a Workers, got {describe_kind(executor)}"
        )
    if callable(getattr(executor, "get_executor", None)):
        return DaskExecutor(executor)
    if type(executor).__module__.startswith("distributed."):
        return DaskExecutor(executor._client, executor)
    return executor


def _folder(path: Any) -> str:
    """Return the absolute path of an existing folder."""
    folder = os.path.abspath(checked_path("Workers", path, "store"))
    if not os.path.isdir(folder):
        raise FileNotFoundError(2, "no such folder", folder)
    return folder


# The executor of this process.


class _InlineExecutor(Executor):
    """Run each task at once in the caller's thread, with all threads of the kernels."""

    _max_workers = 1
    is_here = True

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        future: Future[Any] = Future()
        future.set_result(fn(*args, **kwargs))
        return future


def inline_workers() -> Workers:
    """Return this process as `Workers`."""
    return Workers(_InlineExecutor(), window=1, threads=None)


# The scheduler of parallel work: sizes of tasks, the function that runs on a worker, and lost tasks sent again.
#
# An executor takes calls. These things are added: tasks of about a second at any rate of the scene (`ChunkSize`), so
# that neither the scheduler nor the last worker is waited for; a bounded number on their way, and results in order
# (`Scheduler.results`); the scene only once to each worker (`run_task`, `MissingState`); another try for a task that
# its worker took along (`_count_loss`), for executors that have none; and a refusal of workers with other sources,
# whose answers could differ.

TASK_SECONDS = 1.0
"""Duration of a task to aim at: long beside a scheduler's time for it (a millisecond), short beside the whole work."""
_MOST_GROWTH = 8  # the greatest ratio of a size to the one before


class ChunkSize:
    """Sizes of tasks between two limits: fixed, or by the measured rate, and smaller towards the end."""

    def __init__(self, fixed: int | None, least: int, most: int, workers: int) -> None:
        self.fixed, self.most, self.workers = fixed, max(1, most), max(1, workers)
        self.least = min(max(1, least), self.most)
        self.size = self.least

    def saw(self, count: int, seconds: float) -> None:
        """Record that a task of `count` took `seconds`."""
        ideal = count * TASK_SECONDS / max(seconds, 1e-6)
        self.size = int(min(self.most, max(self.least, min(ideal, _MOST_GROWTH * max(count, self.size)))))

    def pieces(self, begin: int, end: int, step: int = 1) -> Iterator[tuple[int, int]]:
        """Yield (begin, end) of one piece after the other, by the current rate; multiples of `step` where possible.

        Towards the end pieces become smaller, so that all workers end at about the same time.
        """
        while begin < end:
            if self.fixed is not None:
                size = self.fixed
            else:
                # Half of a fair share of the rest: the last pieces are small
                size = max(self.least, min(self.size, -(-(end - begin) // (2 * self.workers))))
                size = size // step * step if size >= step else size
            yield begin, min(end, begin + size)
            begin += size


# The function that runs on a worker: a call with shared objects and its own arguments, on some threads.


class TaskResult(NamedTuple):
    """The answer of a task; `seconds` are those of the work itself, without its preparation.

    notes: messages for the log of the process that sent the task.
    """

    value: Any
    seconds: float
    notes: tuple[str, ...] = ()


class MissingState(NamedTuple):
    """The answer of a worker that lacks a recipe."""

    worker: str


def run_task(
    edition: str,
    references: tuple[SharedReference, ...],
    threads: int | None,
    call: Callable[..., Any],
    *arguments: Any,
) -> TaskResult | MissingState:
    """Return call(*shared, *arguments) with the objects of the references.

    Raise ValueError if this process has another edition than the sender.
    """
    if source_version() != edition:
        raise ValueError(
            f"executor: the worker {worker_name()} has conicoid {source_version()}, and this process has {edition}"
        )
    shared: list[Any] = []
    for reference in references:
        thing = find_shared(reference)
        if not thing:
            return MissingState(worker_name())
        shared += thing
    with limit_threads(threads), np.errstate(all="ignore"), collect_notes() as notes:
        ready = getattr(call, "ready", None)
        if ready is not None:
            ready(*shared)
        began = time.perf_counter()
        # Buffers that travelled may lie at any address, and kernels load whole vectors
        value = call(*shared, *map(align_array, arguments))
        return TaskResult(value, time.perf_counter() - began, tuple(notes))


def worker_name() -> str:
    """Return machine and process number, for messages."""
    return f"{platform.node()}:{os.getpid()}"


def prepare_first(call: Callable[..., Any]) -> Callable[..., Any]:
    """Mark a call whose first argument is a scene: it is prepared before the call's time is taken."""
    call.ready = lambda scene, *_: scene._prepared  # type: ignore[attr-defined]
    return call


# Some work on an executor: tasks are sent, awaited in order, and sent again if they are lost.

_PATIENCE = 0.2  # seconds between two checks of Ctrl-C and of the progress
_IN_FLIGHT = 3  # tasks for each worker
_COUNTED = 2.0  # seconds between two counts of the workers
_LOST = {"KilledWorker", "CommClosedError", "FutureCancelledError", "FuturesCancelledError", "FutureLostError"}
"""Dask's exceptions for tasks whose worker, or connection, was lost. Without Dask these classes cannot be imported."""


@dataclass
class ScheduledTask:
    """A task: its share of the work, the arguments of the call, and a note for its maker."""

    begin: int
    end: int
    arguments: tuple[Any, ...]
    note: Any = None
    future: Future[Any] | None = None
    sent_to: Any = None
    lost: int = 0
    has_all: bool = False


class Scheduler:
    """One piece of work, `call(*shared, *arguments)` for each piece, on some workers.

    Invariant: at most `window` pieces are sent and not handed out, so the memory does not depend on their number.
    """

    def __init__(
        self, owner: str, workers: Workers, call: Callable[..., Any], shared: tuple[SharedObject, ...]
    ) -> None:
        self.owner, self.workers, self.call, self.shared = owner, workers, call, shared
        self.queue: deque[ScheduledTask] = deque()
        self._looked, self._window = 0.0, 0

    @property
    def window(self) -> int:
        """The most pieces on their way. Workers may come and go, so they are counted now and then."""
        if self.workers.window:
            return self.workers.window
        now = time.monotonic()
        if not self._window or now - self._looked > _COUNTED:
            self._looked, self._window = now, _IN_FLIGHT * self.workers.count
        return self._window

    def results(
        self, pieces: Iterator[ScheduledTask], saw: Callable[[int, float], Any], total: int, done: int = 0
    ) -> Generator[tuple[ScheduledTask, Any]]:
        """Yield every piece with its value, in order. At the end, however it ends, queued pieces are cancelled."""
        self._check_version()
        # Threads of this process have the scene itself; all other workers may map a file of its tables.
        if not self.workers.are_threads:
            for recipe in self.shared:
                recipe.share_tables(source_version(), self.workers.store)
        try:
            more = True
            while more or self.queue:
                while more and len(self.queue) < self.window:
                    piece = next(pieces, None)
                    more = piece is not None
                    if piece is not None:
                        self._send(piece)
                        self.queue.append(piece)
                if self.queue:
                    # The oldest piece first: results leave in order, and later ones wait in their futures
                    answer = self._await_result(self.queue[0], done, total)
                    self._log_notes(answer.notes)
                    piece = self.queue.popleft()
                    saw(piece.end - piece.begin, answer.seconds)
                    done += piece.end - piece.begin
                    self._report_progress(done, total)
                    piece.future = None
                    yield piece, answer.value
        finally:
            # Also after an error or Ctrl-C: nobody wants these results any more
            for piece in self.queue:
                if piece.future is not None:
                    piece.future.cancel()

    def _log_notes(self, notes: tuple[str, ...]) -> None:
        """Log the workers' notes on a scene, each once, though every worker sends it."""
        for note in notes:
            log_once(self.shared[0].labels, lambda: note)  # noqa: B023 - called at once

    def _report_progress(self, done: int, total: int) -> None:
        """Call the progress function, if there is one."""
        if self.workers.progress is not None:
            self.workers.progress(done, total)

    def _check_version(self) -> None:
        """Raise ValueError for workers without Conicoid or with another version; the probe itself needs no Conicoid."""
        probe = ScheduledTask(0, 0, ())
        while True:
            probe.sent_to = self.workers.executor
            try:
                # A function of the standard library: workers without Conicoid can run it.
                theirs = self._result(self._submit(pydoc.locate, "conicoid.__version__"), lambda: None)
                break
            except Exception as error:
                self._count_loss(probe, error)
        if theirs is None:
            raise ValueError(f"{self.owner}: executor: its workers have no conicoid; this process has {__version__}")
        if theirs != __version__:
            raise ValueError(
                f"{self.owner}: executor: its workers have conicoid {theirs}, and this process has {__version__}"
            )

    def _submit(self, call: Callable[..., Any], *arguments: Any) -> Future[Any]:
        """Submit a call. Raise ValueError if the executor takes no more."""
        try:
            future: Future[Any] = self.workers.executor.submit(call, *arguments)
        except BrokenExecutor:
            raise
        except Exception as error:
            if getattr(self.workers.executor, "is_here", False):
                raise  # an error of the task, which runs at once
            message = f"{self.owner}: executor takes no more tasks, it was shut down ({error})"
            raise ValueError(message) from error
        return future

    def _send(self, piece: ScheduledTask) -> None:
        """Submit a piece; renew a broken executor."""
        references = tuple(recipe.reference(piece.has_all) for recipe in self.shared)
        while True:
            piece.sent_to = self.workers.executor
            try:
                piece.future = self._submit(
                    run_task, source_version(), references, self.workers.threads, self.call, *piece.arguments
                )
                return
            except BrokenExecutor as error:
                self._count_loss(piece, error)

    def _await_result(self, piece: ScheduledTask, done: int, total: int) -> TaskResult:
        """Return the result of a piece; send it again if it was lost."""
        while True:
            try:
                if piece.future is None:
                    self._send(piece)
                answer = self._result(piece.future, lambda: self._report_progress(done, total))
            except Exception as error:
                self._count_loss(piece, error)
                piece.future = None
                continue
            if isinstance(answer, TaskResult):
                return answer
            if not isinstance(answer, MissingState) or piece.has_all:
                raise ValueError(f"{self.owner}: executor: a task came back as {type(answer).__name__}")
            # The worker lacks a recipe: send the piece once more, with all bytes.
            piece.has_all, piece.future = True, None

    def _result(self, future: Any, report: Callable[[], Any]) -> Any:
        """Wait for a future in short steps, between which Ctrl-C works on every system."""
        while True:
            try:
                return future.result(timeout=_PATIENCE)
            except TimeoutError:
                # The task itself may have raised TimeoutError, which is not the timeout of this wait
                if future.done() and not future.cancelled() and future.exception() is not None:
                    raise
                self._check_open(future)
                report()

    def _check_open(self, future: Any) -> None:
        """Raise ValueError if a client was closed before its tasks were done: they will never be."""
        executor = self.workers.executor
        if isinstance(executor, DaskExecutor) and not executor.is_open and not future.done():
            raise ValueError(f"{self.owner}: executor was shut down, or lost its scheduler, before all was done")

    def _count_loss(self, piece: ScheduledTask, error: Exception) -> None:
        """Count a loss, so that the piece may be sent again. Raise an error that is not the worker's end."""
        if not _is_loss(error):
            raise error
        piece.lost += 1
        if piece.lost > self.workers.retries:
            message = f"{self.owner}: executor: a task was lost {piece.lost} times with its worker ({error})"
            raise ValueError(message) from error
        if isinstance(error, BrokenExecutor) and not self.workers.renew(piece.sent_to):
            raise ValueError(
                f"{self.owner}: executor is broken, one of its processes died ({error}); co.parallel.Processes(n) "
                "survives that, and so does co.parallel.Workers(make) with a function that makes an executor"
            ) from error


def _is_loss(error: BaseException) -> bool:
    """Return whether a task ended with its worker, and not by itself."""
    return isinstance(error, BrokenExecutor | CancelledError | LostTaskError) or type(error).__name__ in _LOST


@contextlib.contextmanager
def run_tasks(
    owner: str, workers: Workers, call: Callable[..., Any], shared: tuple[SharedObject, ...],
    tasks: Iterator[ScheduledTask], saw: Callable[[int, float], Any] = lambda *_: None, total: int = 0, done: int = 0,
) -> Iterator[Iterator[tuple[ScheduledTask, Any]]]:  # fmt: skip
    """Yield the results of a `Scheduler`; the end of the block cancels the rest, whoever holds the results."""
    results = Scheduler(owner, workers, call, shared).results(tasks, saw, total, done)
    try:
        yield results
    finally:
        results.close()
