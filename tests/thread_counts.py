"""The same work on several numbers of threads."""

from collections.abc import Callable
from typing import TypeVar

import conicoid as co

Result = TypeVar("Result")


def on_threads(work: Callable[[], Result], *counts: int | None) -> list[Result]:
    """Return the result of `work` for each number of threads; afterwards the number is the usual one."""
    results = []
    try:
        for count in counts:
            co.set_threads(count)
            results.append(work())
    finally:
        co.set_threads(None)
    return results
