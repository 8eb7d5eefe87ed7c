"""Measures that are taken on workers: a body a task, or pieces of the rays through one."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

from ...parallel.scheduler import ScheduledTask, Scheduler, cancel_on_exit
from ...parallel.shared_state import SharedObject, shared_scene
from ...parallel.workers import as_workers

if TYPE_CHECKING:
    from ...kernels.threads import Progress
    from ...parallel.workers import Workers

_ITEMS_A_TASK = 8
"""Pieces of a task, each of some ten milliseconds; fewer where they are few."""


def run_on_workers(
    call: Callable[..., Any], asked: Sequence[tuple[Any, ...]], executor: Any, progress: Progress | None
) -> list[Any]:
    """call(*arguments) for each, in order."""
    workers = as_workers("measure", executor, progress)
    pieces = (ScheduledTask(i, i + 1, arguments) for i, arguments in enumerate(asked))
    course = Scheduler("measure", workers, call, ())
    with cancel_on_exit(course.results(pieces, lambda *_: None, len(asked))) as results:
        return [value for _, value in results]


def follow_on_workers(
    workers: Workers, scene: Any, view: Any, call: Callable[..., Any], items: Iterator[tuple[int, Any]]
) -> Iterator[tuple[int, Any]]:
    """(rays, call(scene, view, item)) of each (rays, item), in order."""
    course = Scheduler("measure", workers, _run_items, (shared_scene(scene), SharedObject((call, view))))
    with cancel_on_exit(course.results(_pieces(items, 2 * workers.count), lambda *_: None, 0)) as results:
        for piece, values in results:
            yield from zip(piece.told, values, strict=True)


def _pieces(items: Iterator[tuple[int, Any]], workers: int) -> Iterator[ScheduledTask]:
    """The first items one by one, that all workers have something to do, and then some at a time."""
    for place in itertools.count():
        some = list(itertools.islice(items, 1 if place < workers else _ITEMS_A_TASK))
        if not some:
            return
        yield ScheduledTask(place, place + 1, ([item for _, item in some],), told=[rays for rays, _ in some])


def _run_items(scene: Any, asked: tuple[Callable[..., Any], Any], items: list[Any]) -> list[Any]:
    call, view = asked
    return [call(scene, view, item) for item in items]
