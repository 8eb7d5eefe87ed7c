"""An executor of the process that asks: what is submitted is done at once, with all threads."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor, Future
from typing import Any

from .workers import Workers


class _Here(Executor):
    """One task at a time, in the caller's thread."""

    _max_workers = 1
    is_here = True

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        future: Future[Any] = Future()
        future.set_result(fn(*args, **kwargs))
        return future


def here() -> Workers:
    """The process that asks, as `Workers`."""
    return Workers(_Here(), window=1, threads=None)
