"""A client of Dask as an executor none of whose tasks is left without an outcome.

That of Dask itself, `client.get_executor()`, names tasks by what they do, so that one that Dask has given up, as its
workers died, fails again at once however often it is sent. And a result that is lost while it is fetched, with a worker
or with the scheduler, leaves its future open for ever if the task then fails: whoever waits for it hangs.
"""

from __future__ import annotations

import os
import weakref
from collections.abc import Callable
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from typing import TYPE_CHECKING, Any

from .._util.hints import with_call_hints
from .._util.validation import as_integer, check_callback, describe_kind, format_value
from .._util.validation import check_path as checked_path

if TYPE_CHECKING:
    from ..kernels.threads import Progress


class LostTaskError(RuntimeError):
    """A task whose worker, result or connection was lost: it may be sent again."""


class DaskExecutor(Executor):
    """The workers of a client. `given` is the client's own executor, if it was that which a user gave."""

    def __init__(self, client: Any, given: Any = None) -> None:
        self.client, self._given = client, given
        self._options: dict[str, Any] = dict(getattr(given, "_kwargs", {})) | dict(pure=False)
        self._sent: weakref.WeakSet[Any] = weakref.WeakSet()
        self._open = True

    @property
    def is_open(self) -> bool:
        """Does it take tasks, and bring back what was sent?"""
        return self._open and not getattr(self._given, "_shutdown", False) and self.client.status != "closed"

    @property
    def count(self) -> int:
        """Threads of all workers; 1 where none has come yet, or the scheduler does not answer."""
        try:
            return max(1, sum(map(int, self.client.ncores().values())))
        except Exception:  # as of a client that is closed, which submitting tells of
            return 1

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        if not self.is_open:
            raise RuntimeError("cannot schedule new futures after shutdown")
        task = self.client.submit(fn, *args, **kwargs, **self._options)
        self._sent.add(task)
        future: Future[Any] = Future()
        future.add_done_callback(lambda done: task.cancel() if done.cancelled() else None)
        self.client.loop.add_callback(_relay, self.client, task, future)
        return future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Take no more tasks; the client stays open."""
        self._open = False
        if cancel_futures:
            self.client.cancel(list(self._sent))


async def _relay(client: Any, task: Any, future: Future[Any]) -> None:
    """Wait for a task of Dask, and give its future what it brought, whatever happens meanwhile."""
    try:
        value = await client.gather(task, asynchronous=True)
    except BaseException as error:  # the loop ends as well: nobody may wait for ever
        outcome = error if task.status == "error" else LostTaskError(f"{type(error).__name__}: {error}")
        _resolve(future, outcome, False)
        if not isinstance(error, Exception):
            raise
    else:
        _resolve(future, value, True)


def _resolve(future: Future[Any], outcome: Any, is_value: bool) -> None:
    """The outcome of a future, unless nobody waits for it."""
    if future.set_running_or_notify_cancel():
        (future.set_result if is_value else future.set_exception)(outcome)


# Executors of all kinds as one: `Workers`.

_BYTES, _BYTES_OF_DASK = 32 << 20, 8 << 20
"""Sent with a task at most. (Dask warns from 10 MB on.)"""


class Workers:
    """An executor, with what is to be known beyond its interface.

    executor: a `concurrent.futures.Executor` or what has its `submit`: the standard library's, loky's, mpi4py's,
        `client.get_executor()` of Dask; a Dask `Client`; or a function without arguments that makes one. This is called
        again where a pool breaks because a process of it died.
    chunk: rays, points or tiles of a task. None: about a second's, by the rate that is measured.
    window: tasks that are sent and not yet back, at most; they bound the memory. None: three for each worker.
    retries: how often a task is sent again that was lost with its worker.
    threads: of a task, on its worker: 1 where the executor has a worker for each processor.
    progress: progress(done, count) is called now and then.
    store: a folder that workers share, of files of prepared tables, which they map instead of preparing a large scene
        each; it keeps them for later runs. None: a folder of this machine, for as long as the scene is in use. Only you
        should be able to write to it.

    As a context manager it shuts the executor down in the end.
    Raises TypeError for what is no executor, ValueError for senseless numbers.
    """

    @with_call_hints
    def __init__(
        self, executor: Any, *, chunk: int | None = None, window: int | None = None, retries: int = 3,
        threads: int | None = 1, progress: Progress | None = None, store: str | os.PathLike[str] | None = None,
    ) -> None:  # fmt: skip
        check_callback("Workers", "progress", progress)
        self.chunk, self.window = _number("chunk", chunk, 1), _number("window", window, 1)
        self.retries, self.threads = _number("retries", retries, 0) or 0, _number("threads", threads, 1)
        self.progress = progress
        self.store = None if store is None else _folder(store)
        self._make: Callable[[], Any] | None = None if _submits(executor) or not callable(executor) else executor
        self.executor: Any = _as_executor("Workers", self._make() if self._make else executor)

    @property
    def count(self) -> int:
        """Workers at work at the same time, as far as the executor tells; else the processors of this machine."""
        if isinstance(self.executor, DaskExecutor):
            return self.executor.count
        for name in ("_max_workers", "num_workers"):
            found = getattr(self.executor, name, None)
            if isinstance(found, int) and found > 0:
                return found
        return os.cpu_count() or 1

    @property
    def is_dask(self) -> bool:
        """Is it an executor of Dask?"""
        return isinstance(self.executor, DaskExecutor)

    @property
    def are_here(self) -> bool:
        """Are they threads of this process, which have all that it has?"""
        return isinstance(self.executor, ThreadPoolExecutor) or getattr(self.executor, "is_here", False)

    @property
    def most_bytes(self) -> int:
        """That are to be sent with one task."""
        return _BYTES_OF_DASK if self.is_dask else _BYTES

    def renew(self, broken: Any) -> bool:
        """Have a new executor in place of one that broke; False where there is no way to make one."""
        if self.executor is not broken:
            return True
        if self._make is None:
            return False
        broken.shutdown(wait=False)
        self.executor = _as_executor("Workers", self._make())
        return True

    def __enter__(self) -> Workers:
        return self

    def __exit__(self, *_: object) -> None:
        self.executor.shutdown()


def as_workers(owner: str, executor: Any, progress: Progress | None = None) -> Workers:
    """The `Workers` of an argument `executor=`."""
    made = executor if isinstance(executor, Workers) else Workers(_as_executor(owner, executor))
    if progress is None:
        return made
    again = object.__new__(Workers)
    vars(again).update(vars(made), progress=progress)
    return again


def _submits(executor: Any) -> bool:
    return callable(getattr(executor, "submit", None)) and not isinstance(executor, type)


def _as_executor(owner: str, executor: Any) -> Any:
    """What has the interface of executors; of a Dask client, and of its own executor, one that loses nothing."""
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
    found = os.path.abspath(checked_path("Workers", path, "store"))
    if not os.path.isdir(found):
        raise FileNotFoundError(2, "no such folder", found)
    return found


def _number(name: str, value: Any, least: int) -> int | None:
    found = None if value is None else as_integer(value)
    if value is not None and (found is None or found < least):
        raise ValueError(f"Workers: {name} must be a whole number >= {least} or None, got {format_value(value)}")
    return found


# An executor of the process that asks: what is submitted is done at once, with all threads.


class _InlineExecutor(Executor):
    """One task at a time, in the caller's thread."""

    _max_workers = 1
    is_here = True

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        future: Future[Any] = Future()
        future.set_result(fn(*args, **kwargs))
        return future


def inline_workers() -> Workers:
    """The process that asks, as `Workers`."""
    return Workers(_InlineExecutor(), window=1, threads=None)
