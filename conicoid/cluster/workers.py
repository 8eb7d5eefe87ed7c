"""Executors of all kinds as one: `Workers`."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Any

from ..shapes.calls import explained
from ..shapes.validate import callback, shown, what, whole
from ..shapes.validate import path as checked_path
from .dask_client import DaskExecutor

if TYPE_CHECKING:
    from ..engine.threads import Progress

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

    @explained
    def __init__(
        self, executor: Any, *, chunk: int | None = None, window: int | None = None, retries: int = 3,
        threads: int | None = 1, progress: Progress | None = None, store: str | os.PathLike[str] | None = None,
    ) -> None:  # fmt: skip
        callback("Workers", "progress", progress)
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
        raise TypeError(f"{owner}: executor must be a concurrent.futures.Executor or a Workers, got {what(executor)}")
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
    found = None if value is None else whole(value)
    if value is not None and (found is None or found < least):
        raise ValueError(f"Workers: {name} must be a whole number >= {least} or None, got {shown(value)}")
    return found
