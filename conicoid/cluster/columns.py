"""Shares of voxels in parts, on workers: columns of voxels are the pieces."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..engine.queries.columns import Grid
from ..engine.queries.columns import columns as columns_here
from ..shapes.vector import FloatArray
from .course import Course, Piece, closing
from .pace import Pace
from .queries import workers_of
from .recipe import Recipe, recipe_of
from .task import prepared_first

if TYPE_CHECKING:
    from ..engine.threads import Progress
    from ..scene import Scene

_LEAST, _MOST = 16, 1 << 16  # columns of a task


@prepared_first
def _part(scene: Scene, options: tuple[Any, ...], begin: int, end: int) -> Any:
    frame, axis, samples, groups, count, voxels = options
    return columns_here(scene.prepared, Grid(frame, axis, samples), groups, count, voxels, begin, end)


def columns(
    scene: Scene, grid: Grid, groups: Any, count: int, voxels: int, which: tuple[int, int], executor: Any,
    progress: Progress | None,
) -> tuple[FloatArray, FloatArray]:  # fmt: skip
    """`engine.queries.columns.columns` of the columns from which[0] to which[1], in parts."""
    first, total = which[0], which[1] - which[0]
    workers = workers_of("voxels", executor, progress)
    pace = Pace(workers.chunk, _LEAST, min(_MOST, max(1, workers.most_bytes // (16 * count * voxels))), workers.count)
    shared = Recipe((*grid, groups, count, voxels))
    pieces = (Piece(a, b, (first + a, first + b)) for a, b in pace.pieces(0, total))
    shares, bounds = np.empty((2, total, count, voxels))
    course = Course("voxels", workers, _part, (recipe_of(scene), shared))
    with closing(course.results(pieces, pace.saw, total)) as results:
        for piece, (share, bound) in results:
            shares[piece.begin : piece.end], bounds[piece.begin : piece.end] = share, bound
    return shares, bounds
