"""A client of Dask as an executor none of whose tasks is left without an outcome.

That of Dask itself, `client.get_executor()`, names tasks by what they do, so that one that Dask has given up, as its
workers died, fails again at once however often it is sent. And a result that is lost while it is fetched, with a worker
or with the scheduler, leaves its future open for ever if the task then fails: whoever waits for it hangs.
"""

from __future__ import annotations

import weakref
from collections.abc import Callable
from concurrent.futures import Executor, Future
from typing import Any


class Lost(RuntimeError):
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
        self.client.loop.add_callback(_brought, self.client, task, future)
        return future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Take no more tasks; the client stays open."""
        self._open = False
        if cancel_futures:
            self.client.cancel(list(self._sent))


async def _brought(client: Any, task: Any, future: Future[Any]) -> None:
    """Wait for a task of Dask, and give its future what it brought, whatever happens meanwhile."""
    try:
        value = await client.gather(task, asynchronous=True)
    except BaseException as error:  # the loop ends as well: nobody may wait for ever
        outcome = error if task.status == "error" else Lost(f"{type(error).__name__}: {error}")
        _settle(future, outcome, False)
        if not isinstance(error, Exception):
            raise
    else:
        _settle(future, value, True)


def _settle(future: Future[Any], outcome: Any, is_value: bool) -> None:
    """The outcome of a future, unless nobody waits for it."""
    if future.set_running_or_notify_cancel():
        (future.set_result if is_value else future.set_exception)(outcome)
