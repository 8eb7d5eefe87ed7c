"""The course of some work on an executor: tasks sent, awaited in order, and sent again where they were lost."""

from __future__ import annotations

import contextlib
import pydoc
import time
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, CancelledError, Future
from dataclasses import dataclass
from typing import Any

from ..engine.answers.notes import tell_once
from .dask_client import DaskExecutor, Lost
from .edition import edition
from .recipe import Recipe
from .task import Done, Missing, run
from .workers import Workers

_PATIENCE = 0.2  # seconds between two looks at Ctrl-C and at the progress
_IN_FLIGHT = 3  # tasks for each worker
_COUNTED = 2.0  # seconds between two counts of the workers
_LOST = {"KilledWorker", "CommClosedError", "FutureCancelledError", "FuturesCancelledError", "FutureLostError"}
"""What Dask raises for tasks whose worker, or connection, was lost. Without Dask these classes cannot be imported."""


@dataclass
class Piece:
    """A task: its share of the work, and what it is called with; `told` is for whoever made it."""

    begin: int
    end: int
    arguments: tuple[Any, ...]
    told: Any = None
    future: Future[Any] | None = None
    sent_to: Any = None
    lost: int = 0
    has_all: bool = False


class Course:
    """One piece of work, `call(*shared, *arguments)` for each piece, on some workers.

    Invariant: at most `window` pieces are sent and not handed out, so the memory does not depend on their number.
    """

    def __init__(self, owner: str, workers: Workers, call: Callable[..., Any], shared: tuple[Recipe, ...]) -> None:
        self.owner, self.workers, self.call, self.shared = owner, workers, call, shared
        self.sent: deque[Piece] = deque()
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
        self, pieces: Iterator[Piece], saw: Callable[[int, float], Any], total: int, done: int = 0
    ) -> Iterator[tuple[Piece, Any]]:
        """Every piece with its value, in order. What is still queued when this ends, however it ends, is cancelled."""
        self._ask_version()
        if not self.workers.are_here:
            for recipe in self.shared:
                recipe.share_tables(edition(), self.workers.store)
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
            tell_once(self.shared[0].labels, lambda: note)  # noqa: B023 - called at once

    def _tell(self, done: int, total: int) -> None:
        if self.workers.progress is not None:
            self.workers.progress(done, total)

    def _ask_version(self) -> None:
        """Refuse workers without Conicoid, or with another version, in words: nothing of Conicoid is needed to ask."""
        from .. import __version__

        probe = Piece(0, 0, ())
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

    def _send(self, piece: Piece) -> None:
        """Hand a piece to the executor."""
        references = tuple(recipe.reference(piece.has_all) for recipe in self.shared)
        while True:
            piece.sent_to = self.workers.executor
            try:
                piece.future = self._submit(
                    run, edition(), references, self.workers.threads, self.call, *piece.arguments
                )
                return
            except BrokenExecutor as error:
                self._again(piece, error)

    def _awaited(self, piece: Piece, done: int, total: int) -> Done:
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
            if isinstance(answer, Done):
                return answer
            if not isinstance(answer, Missing) or piece.has_all:
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

    def _again(self, piece: Piece, error: Exception) -> None:
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
                "co.cluster.Processes(n), or co.cluster.Workers(make) with a function that makes a new one"
            ) from error


def _is_loss(error: BaseException) -> bool:
    """Did a task end with its worker, and not by itself?"""
    return isinstance(error, BrokenExecutor | CancelledError | Lost) or type(error).__name__ in _LOST


@contextlib.contextmanager
def closing(results: Iterator[Any]) -> Iterator[Iterator[Any]]:
    """Results that are given up when the block ends, whoever still holds them."""
    try:
        yield results
    finally:
        results.close()  # type: ignore[attr-defined]
