"""How much of some work a task should take: about a second's, by what the tasks before it took."""

from __future__ import annotations

import contextlib
import os
import platform
import pydoc
import time
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, CancelledError, Future
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from .._util.pickling import align_array
from .._util.version import __version__
from ..kernels.threads import limit_threads
from ..queries.spans import collect_notes, log_once
from .shared_state import SharedObject, SharedReference, find_shared, source_version
from .workers import DaskExecutor, LostTaskError, Workers

TASK_SECONDS = 1.0
"""That a task should take: long beside what a scheduler takes for it (a millisecond), short beside the whole."""
_MOST_GROWTH = 8  # a size is at most so many times the one before


class ChunkSize:
    """Sizes of tasks between two limits: fixed, or by the measured rate, and smaller towards the end."""

    def __init__(self, fixed: int | None, least: int, most: int, workers: int) -> None:
        self.fixed, self.most, self.workers = fixed, max(1, most), max(1, workers)
        self.least = min(max(1, least), self.most)
        self.size = self.least

    def saw(self, count: int, seconds: float) -> None:
        """A task of `count` took some seconds."""
        wanted = count * TASK_SECONDS / max(seconds, 1e-6)
        self.size = int(min(self.most, max(self.least, min(wanted, _MOST_GROWTH * max(count, self.size)))))

    def pieces(self, begin: int, end: int, step: int = 1) -> Iterator[tuple[int, int]]:
        """(begin, end) of one piece after the other, by the rate known by then; multiples of `step` where they may.

        Towards the end pieces become smaller, so that all workers end at about the same time.
        """
        while begin < end:
            if self.fixed is not None:
                size = self.fixed
            else:
                size = max(self.least, min(self.size, -(-(end - begin) // (2 * self.workers))))
                size = size // step * step if size >= step else size
            yield begin, min(end, begin + size)
            begin += size


# What runs on a worker: a function of what tasks share and of its own arguments, on as many threads as it may use.


class TaskResult(NamedTuple):
    """What a task brings back; `seconds` are those of the work itself, without what is made ready for it.

    notes: what would have been logged here, for the one who asked.
    """

    value: Any
    seconds: float
    notes: tuple[str, ...] = ()


class MissingState(NamedTuple):
    """The answer of a worker that lacks a recipe."""

    worker: str


def run_task(
    asked: str, references: tuple[SharedReference, ...], threads: int | None, call: Callable[..., Any], *arguments: Any
) -> TaskResult | MissingState:
    """call(*shared, *arguments) with what the references stand for.

    Raises ValueError where this process has another edition than the one who asked.
    """
    if source_version() != asked:
        raise ValueError(
            f"executor: the worker {worker_name()} has conicoid {source_version()}, and this process has {asked}"
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
        value = call(*shared, *map(align_array, arguments))
        return TaskResult(value, time.perf_counter() - began, tuple(notes))


def worker_name() -> str:
    """Machine and number of the process, for messages."""
    return f"{platform.node()}:{os.getpid()}"


def prepare_first(call: Callable[..., Any]) -> Callable[..., Any]:
    """A call whose first argument is a scene that is to be prepared, which is not part of its time."""
    call.ready = lambda scene, *_: scene.prepared  # type: ignore[attr-defined]
    return call


# The course of some work on an executor: tasks sent, awaited in order, and sent again where they were lost.

_PATIENCE = 0.2  # seconds between two looks at Ctrl-C and at the progress
_IN_FLIGHT = 3  # tasks for each worker
_COUNTED = 2.0  # seconds between two counts of the workers
_LOST = {"KilledWorker", "CommClosedError", "FutureCancelledError", "FuturesCancelledError", "FutureLostError"}
"""What Dask raises for tasks whose worker, or connection, was lost. Without Dask these classes cannot be imported."""


@dataclass
class ScheduledTask:
    """A task: its share of the work, and what it is called with; `told` is for whoever made it."""

    begin: int
    end: int
    arguments: tuple[Any, ...]
    told: Any = None
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
        self.sent: deque[ScheduledTask] = deque()
        self._looked, self._window = 0.0, 0

    @property
    def window(self) -> int:
        """How many pieces may be on their way; workers may come and go, so they are counted now and then."""
        if self.workers.window:
            return self.workers.window
        now = time.monotonic()
        if not self._window or now - self._looked > _COUNTED:
            self._looked, self._window = now, _IN_FLIGHT * self.workers.count
        return self._window

    def results(
        self, pieces: Iterator[ScheduledTask], saw: Callable[[int, float], Any], total: int, done: int = 0
    ) -> Iterator[tuple[ScheduledTask, Any]]:
        """Every piece with its value, in order. What is still queued when this ends, however it ends, is cancelled."""
        self._ask_version()
        if not self.workers.are_here:
            for recipe in self.shared:
                recipe.share_tables(source_version(), self.workers.store)
        try:
            more = True
            while more or self.sent:
                while more and len(self.sent) < self.window:
                    piece = next(pieces, None)
                    more = piece is not None
                    if piece is not None:
                        self._send(piece)
                        self.sent.append(piece)
                if self.sent:
                    answer = self._awaited(self.sent[0], done, total)
                    self._pass_on(answer.notes)
                    piece = self.sent.popleft()
                    saw(piece.end - piece.begin, answer.seconds)
                    done += piece.end - piece.begin
                    self._tell(done, total)
                    piece.future = None
                    yield piece, answer.value
        finally:
            for piece in self.sent:
                if piece.future is not None:
                    piece.future.cancel()

    def _pass_on(self, notes: tuple[str, ...]) -> None:
        """Log what workers have to say of a scene, once, though each of them says it."""
        for note in notes:
            log_once(self.shared[0].labels, lambda: note)  # noqa: B023 - called at once

    def _tell(self, done: int, total: int) -> None:
        if self.workers.progress is not None:
            self.workers.progress(done, total)

    def _ask_version(self) -> None:
        """Refuse workers without Conicoid, or with another version, in words: nothing of Conicoid is needed to ask."""
        probe = ScheduledTask(0, 0, ())
        while True:
            probe.sent_to = self.workers.executor
            try:
                theirs = self._result(self._submit(pydoc.locate, "conicoid.__version__"), lambda: None)
                break
            except Exception as error:
                self._again(probe, error)
        if theirs is None:
            raise ValueError(f"{self.owner}: executor: its workers have no conicoid; this process has {__version__}")
        if theirs != __version__:
            raise ValueError(
                f"{self.owner}: executor: its workers have conicoid {theirs}, and this process has {__version__}"
            )

    def _submit(self, call: Callable[..., Any], *arguments: Any) -> Future[Any]:
        try:
            future: Future[Any] = self.workers.executor.submit(call, *arguments)
        except BrokenExecutor:
            raise
        except Exception as error:
            if getattr(self.workers.executor, "is_here", False):
                raise  # of the task, which is done at once
            told = f"{self.owner}: executor takes no more tasks, it was shut down ({error})"
            raise ValueError(told) from error
        return future

    def _send(self, piece: ScheduledTask) -> None:
        """Hand a piece to the executor."""
        references = tuple(recipe.reference(piece.has_all) for recipe in self.shared)
        while True:
            piece.sent_to = self.workers.executor
            try:
                piece.future = self._submit(
                    run_task, source_version(), references, self.workers.threads, self.call, *piece.arguments
                )
                return
            except BrokenExecutor as error:
                self._again(piece, error)

    def _awaited(self, piece: ScheduledTask, done: int, total: int) -> TaskResult:
        """The value of a piece, which is sent again where it was lost."""
        while True:
            try:
                if piece.future is None:
                    self._send(piece)
                answer = self._result(piece.future, lambda: self._tell(done, total))
            except Exception as error:
                self._again(piece, error)
                piece.future = None
                continue
            if isinstance(answer, TaskResult):
                return answer
            if not isinstance(answer, MissingState) or piece.has_all:
                raise ValueError(f"{self.owner}: executor: a task came back as {type(answer).__name__}")
            piece.has_all, piece.future = True, None

    def _result(self, future: Any, tell: Callable[[], Any]) -> Any:
        """What a future brings, waiting in short steps in which Ctrl-C is heard on every system."""
        while True:
            try:
                return future.result(timeout=_PATIENCE)
            except TimeoutError:
                if future.done() and not future.cancelled() and future.exception() is not None:
                    raise
                self._check_open(future)
                tell()

    def _check_open(self, future: Any) -> None:
        """Raise ValueError where a client was closed while its tasks are awaited: they are not done any more."""
        executor = self.workers.executor
        if isinstance(executor, DaskExecutor) and not executor.is_open and not future.done():
            raise ValueError(f"{self.owner}: executor was shut down, or lost its scheduler, before all was done")

    def _again(self, piece: ScheduledTask, error: Exception) -> None:
        """Whether a piece may be sent again after an error; raises it where that is not the worker's end."""
        if not _is_loss(error):
            raise error
        piece.lost += 1
        if piece.lost > self.workers.retries:
            told = f"{self.owner}: executor: a task was lost {piece.lost} times with its worker ({error})"
            raise ValueError(told) from error
        if isinstance(error, BrokenExecutor) and not self.workers.renew(piece.sent_to):
            raise ValueError(
                f"{self.owner}: executor is broken, a process of it died ({error}); one that goes on after that is "
                "co.parallel.Processes(n), or co.parallel.Workers(make) with a function that makes a new one"
            ) from error


def _is_loss(error: BaseException) -> bool:
    """Did a task end with its worker, and not by itself?"""
    return isinstance(error, BrokenExecutor | CancelledError | LostTaskError) or type(error).__name__ in _LOST


@contextlib.contextmanager
def cancel_on_exit(results: Iterator[Any]) -> Iterator[Iterator[Any]]:
    """Results that are given up when the block ends, whoever still holds them."""
    try:
        yield results
    finally:
        results.close()  # type: ignore[attr-defined]
