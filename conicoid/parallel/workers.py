"""`Workers` around any executor: the standard library's, Dask's, or this process itself.

Only Dask needs an executor of its own, since tasks that it has given up, or results that it lost, leave futures open
for ever. `tests/cluster/test_losses.py` has each of these cases.
"""

from __future__ import annotations

import copy
import os
import weakref
from collections.abc import Callable
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from typing import Any

from .._util.validation import check_callback, check_integer, check_path as checked_path, describe_kind
from ..kernels.threads import Progress


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
