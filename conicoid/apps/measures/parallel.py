"""`measure` on workers: each body of a scene is a task, or each few pieces of the rays through one shape."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

from ...parallel.scheduler import ScheduledTask, run_tasks
from ...parallel.shared_state import SharedObject, shared_scene
from ...parallel.workers import as_workers

if TYPE_CHECKING:
    from ...kernels.threads import Progress
    from ...parallel.workers import Workers

_ITEMS_A_TASK = 8
"""Pieces of a task, each of some ten milliseconds; the first tasks have one."""


def run_on_workers(
    call: Callable[..., Any], calls: Sequence[tuple[Any, ...]], executor: Any, progress: Progress | None
) -> list[Any]:
    """Return call(*arguments) for each tuple of arguments, in order."""
    workers = as_workers("measure", executor, progress)
    pieces = (ScheduledTask(i, i + 1, arguments) for i, arguments in enumerate(calls))
    with run_tasks("measure", workers, call, (), pieces, total=len(calls)) as results:
        return [value for _, value in results]


def follow_on_workers(
    workers: Workers, scene: Any, view: Any, call: Callable[..., Any], items: Iterator[tuple[int, Any]]
) -> Iterator[tuple[int, Any]]:
    """Yield (rays, call(scene, view, item)) for each (rays, item), in order."""
    # The scene, the call and the view go to each worker once, the items with each task
    shared = shared_scene(scene), SharedObject((call, view))
    with run_tasks("measure", workers, _run_items, shared, _pieces(items, 2 * workers.count)) as results:
        for piece, values in results:
            yield from zip(piece.note, values, strict=True)


def _pieces(items: Iterator[tuple[int, Any]], workers: int) -> Iterator[ScheduledTask]:
    """Yield tasks of one item for the first, so that all workers have one, and of several items for the others."""
    for place in itertools.count():
        chunk = list(itertools.islice(items, 1 if place < workers else _ITEMS_A_TASK))
        if not chunk:
            return
        yield ScheduledTask(place, place + 1, ([item for _, item in chunk],), note=[rays for rays, _ in chunk])


def _run_items(scene: Any, call_and_view: tuple[Callable[..., Any], Any], items: list[Any]) -> list[Any]:
    """Return call(scene, view, item) for each item of a task."""
    call, view = call_and_view
    return [call(scene, view, item) for item in items]
