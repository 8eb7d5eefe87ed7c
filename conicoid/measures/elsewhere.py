"""Measures that are taken on workers: a body a task."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from ..cluster.course import Course, Piece, closing
from ..cluster.workers import as_workers

if TYPE_CHECKING:
    from ..engine.threads import Progress


def on_workers(
    call: Callable[..., Any], asked: Sequence[tuple[Any, ...]], executor: Any, progress: Progress | None
) -> list[Any]:
    """call(*arguments) for each, in order."""
    workers = as_workers("measure", executor, progress)
    pieces = (Piece(i, i + 1, arguments) for i, arguments in enumerate(asked))
    course = Course("measure", workers, call, ())
    with closing(course.results(pieces, lambda *_: None, len(asked))) as results:
        return [value for _, value in results]
