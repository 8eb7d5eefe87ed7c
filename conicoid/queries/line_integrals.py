"""Path lengths and line integrals of any number of rays in bounded memory: spans are traced and summed in chunks.

The sum of a ray is that of its own spans in their order, so it does not depend on the chunks. Chunks are whole rows of
pictures where possible, since packets of neighbouring rays are faster.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from .._util.arrays import FloatArray
from ..kernels.threads import Progress
from ..prepare.prepared_scene import PreparedScene
from .overlaps import check_overlaps
from .ray_queries import as_rays, limits_of, rays_after_values, row_length, spans
from .rays import Rays, lines_of
from .spans import Spans, refuse_large_lengths
from .weights import BODY, check_by, weights_of

MOST_SPANS = 1 << 20
"""Spans in memory at a time, of the order of 100 MB. A single row of a picture may have more."""
_FIRST, _MOST, _TIMES = 256, 1 << 17, 4  # rays of the first chunk and of the largest; growth from one to the next
_SIDE = 8  # side of the squares in which pictures are traced


def answer(
    scene: PreparedScene, query: str, origins: Any, directions: Any, t_min: Any, t_max: Any,
    progress: Progress | None, options: dict[str, Any],
) -> Any:  # fmt: skip
    """Return `lengths` or `line_integral` of rays; `options` are the arguments beyond rays and interval."""
    if query == "lengths":
        return lengths(scene, as_rays(query, origins, directions), t_min, t_max, progress=progress, **options)
    rays = rays_after_values(options["values"], origins, directions)
    return line_integral(scene, rays, t_min, t_max, progress=progress, **options)


def line_integral(
    scene: PreparedScene, rays: Rays, t_min: Any, t_max: Any, values: Any, otherwise: Any, progress: Progress | None,
    overlaps: Any = None,
) -> Any:  # fmt: skip
    """Return `spans(...).line_integral(values)`, to the bit, in bounded memory."""
    weights = weights_of(values, otherwise, scene.lowered.body_count, scene.labels.distinct)
    how = check_overlaps("line_integral", overlaps)
    total = _sum_in_chunks(
        "line_integral", scene, rays, t_min, t_max, progress, lambda some: some._integral(weights, how), weights.shape
    )
    return total[()]


def lengths(
    scene: PreparedScene, rays: Rays, t_min: Any, t_max: Any, by: Any, progress: Progress | None, overlaps: Any = None
) -> FloatArray:
    """Return `spans(...).lengths(by)`, to the bit; beyond the result itself memory is bounded."""
    (count,) = trailing_axes(scene, "lengths", dict(by=by))
    how: Any = check_overlaps("lengths", overlaps)
    refuse_large_lengths(rays.origins.size // 3, count, by)
    return _sum_in_chunks(
        "lengths",
        scene,
        rays,
        t_min,
        t_max,
        progress,
        lambda some: some.lengths(by, overlaps=how).reshape(len(some), count),
        (count,),
    )


def trailing_axes(scene: PreparedScene, query: str, options: dict[str, Any]) -> tuple[int, ...]:
    """Return the axes of values, also of `occluded`, after those of the rays. Raise ValueError for wrong options."""
    if query == "occluded":
        return ()
    if query == "lengths":
        by = check_by("lengths", options["by"])
        return (scene.lowered.body_count if by == BODY else len(scene.labels.distinct),)
    return weights_of(options["values"], options["otherwise"], scene.lowered.body_count, scene.labels.distinct).shape


def _sum_in_chunks(
    query: str, scene: PreparedScene, rays: Rays, t_min: Any, t_max: Any, progress: Progress | None,
    sums: Callable[[Spans], FloatArray], last: tuple[int, ...],
) -> FloatArray:  # fmt: skip
    """Return sums(spans) for all rays, (..., *last), where sums(spans) of a chunk is (rays, *last)."""
    ends = limits_of(query, rays, "t_min", t_min), limits_of(query, rays, "t_max", t_max)
    count = rays.origins.size // 3
    result = np.empty((count, *last))
    width = rays.shape[-1] if len(rays.shape) > 1 else row_length(rays)
    done, some = 0, _FIRST
    while done < count:
        end = min(count, done + _whole_rows(some, width))
        found = spans(
            scene, _slice_rays(rays, done, end, width), *(_slice_limits(limits, done, end, width) for limits in ends)
        )
        result[done:end] = sums(found)
        most = MOST_SPANS * (end - done) // max(1, len(found.body))  # rays, at the spans per ray of this chunk
        done, some = end, max(1, min(_TIMES * some, most, _MOST))
        del found  # frees this chunk's spans before the next chunk needs memory
        if progress is not None:
            progress(done, count)
    return result.reshape((*rays.shape, *last))


def _whole_rows(some: int, width: int) -> int:
    """Return `some`, rounded down to whole rows of squares if the rays make a picture and one such row fits."""
    rows = _SIDE * width
    return some // rows * rows if 0 < rows <= some else some


def _slice_rays(rays: Rays, begin: int, end: int, width: int) -> Rays:
    """Return rays begin to end of the flat list, in the shape of a picture if they are whole rows."""
    shape = _slice_shape(begin, end, width)
    origins, directions = (lines[begin:end].reshape((*shape, 3)) for lines in lines_of(rays))
    starts = rays._starts[begin:end] if len(rays._starts) > 1 else rays._starts
    return Rays._spawned(origins, directions, starts, rays._home)


def _slice_limits(limits: FloatArray, begin: int, end: int, width: int) -> Any:
    """Return the limits of rays begin to end."""
    return limits[begin:end].reshape(_slice_shape(begin, end, width)) if len(limits) > 1 else float(limits[0])


def _slice_shape(begin: int, end: int, width: int) -> tuple[int, ...]:
    """Return the shape of rays begin to end: (rows, width) for whole rows of a picture, else a list."""
    count = end - begin
    return (count // width, width) if width and begin % width == 0 == count % width else (count,)
