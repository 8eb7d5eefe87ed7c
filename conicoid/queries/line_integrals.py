"""Path lengths and line integrals of any number of rays in bounded memory: spans are traced and summed in chunks.

The sum of a ray is that of its own spans in their order, so it does not depend on the chunks. Chunks are whole rows of
pictures where possible, since packets of neighbouring rays are faster.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from .._util.arrays import FloatArray
from ..kernels.threads import Progress
from ..prepare.prepared_scene import PreparedScene
from .device import Device, SpanSums, device_of
from .overlaps import COUNT_BOTH, REFUSE_OVERLAPS, check_overlaps, has_note
from .ray_queries import _are_few, arrays_of, as_rays, limits_of, rays_after_values, row_length, spans
from .rays import Rays, lines_of
from .spans import Spans, refuse_large_lengths
from .weights import BODY, check_by, weights_of

MOST_SPANS = 1 << 20
"""Spans in memory at a time, of the order of 100 MB. A single row of a picture may have more."""
_FIRST, _MOST, _TIMES = 256, 1 << 17, 4  # rays of the first chunk and of the largest; growth from one to the next
_SIDE = 8  # side of the squares in which pictures are traced
_ON_CARD = 1 << 22  # rays between two calls of `progress` where a GPU sums up


class _Plan(NamedTuple):
    """How spans are summed up: by this processor, and by a GPU."""

    sums: Callable[[Spans], FloatArray]  # of the spans of some rays, (rays, *axes)
    axes: tuple[int, ...]
    by: str
    weights: FloatArray  # (rows, width), or none for lengths
    groups: bool  # whether only spans of one place overlap
    checks: bool  # whether spans that overlap are reported, unless a note was taken
    overlaps: Any


def answer(
    scene: PreparedScene, query: str, origins: Any, directions: Any, t_min: Any, t_max: Any,
    progress: Progress | None, options: dict[str, Any], device: str | None = None,
) -> Any:  # fmt: skip
    """Return `lengths` or `line_integral` of rays; `options` are the arguments beyond rays and interval."""
    if query == "lengths":
        rays = as_rays(query, origins, directions)
        return lengths(scene, rays, t_min, t_max, progress=progress, device=device, **options)
    rays = rays_after_values(options["values"], origins, directions)
    return line_integral(scene, rays, t_min, t_max, progress=progress, device=device, **options)


def line_integral(
    scene: PreparedScene, rays: Rays, t_min: Any, t_max: Any, values: Any, otherwise: Any, progress: Progress | None,
    overlaps: Any = None, device: str | None = None,
) -> Any:  # fmt: skip
    """Return `spans(...).line_integral(values)`, to the bit, in bounded memory."""
    weights = weights_of(values, otherwise, scene.lowered.body_count, scene.labels.distinct)
    how = check_overlaps("line_integral", overlaps)
    table = weights.values.reshape(len(weights.values), math.prod(weights.shape))
    checks = how == REFUSE_OVERLAPS or not (table < 0).any()
    plan = _Plan(lambda some: some._integral(weights, how), weights.shape, weights.by, table, False, checks, how)
    return _sum_in_chunks("line_integral", scene, rays, t_min, t_max, progress, device, plan)[()]


def lengths(
    scene: PreparedScene, rays: Rays, t_min: Any, t_max: Any, by: Any, progress: Progress | None, overlaps: Any = None,
    device: str | None = None,
) -> FloatArray:  # fmt: skip
    """Return `spans(...).lengths(by)`, to the bit; beyond the result itself memory is bounded."""
    (count,) = trailing_axes(scene, "lengths", dict(by=by))
    how: Any = check_overlaps("lengths", overlaps)
    refuse_large_lengths(rays.origins.size // 3, count, by)

    def sums(some: Spans) -> FloatArray:
        return some.lengths(by, overlaps=how).reshape(len(some), count)

    plan = _Plan(sums, (count,), by, np.zeros((0, 0)), by != BODY, how is not None or by != BODY, how)
    return _sum_in_chunks("lengths", scene, rays, t_min, t_max, progress, device, plan)


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
    device: str | None, plan: _Plan,
) -> FloatArray:  # fmt: skip
    """Return the sums of all rays, (..., *axes)."""
    ends = limits_of(query, rays, "t_min", t_min), limits_of(query, rays, "t_max", t_max)
    gpu, count = device_of(query, device, _are_few(rays)), rays.origins.size // 3
    result = np.empty((count, *plan.axes))
    width = rays.shape[-1] if len(rays.shape) > 1 else row_length(rays)
    done, some = 0, _FIRST
    while done < count:
        end = min(count, done + (_ON_CARD if gpu else _whole_rows(some, width)))
        part = _slice_rays(rays, done, end, width)
        low, high = (_slice_limits(each, done, end, width) for each in ends)
        if gpu:
            if not _sum_on_card(gpu, query, scene, part, low, high, plan, result[done:end]):
                gpu = None  # it has too little memory
                continue
        else:
            found = spans(scene, part, low, high, "cpu")
            result[done:end] = plan.sums(found)
            most = MOST_SPANS * (end - done) // max(1, len(found.body))  # rays, at the spans per ray of this chunk
            some = max(1, min(_TIMES * some, most, _MOST))
            del found  # frees this chunk's spans before the next chunk needs memory
        done = end
        if progress is not None:
            progress(done, count)
    return result.reshape((*rays.shape, *plan.axes))


def _sum_on_card(
    gpu: Device, query: str, scene: PreparedScene, rays: Rays, low: Any, high: Any, plan: _Plan, result: FloatArray
) -> bool:
    """Write the sums of rays, by a GPU; return False if it has too little memory.

    Rays in doubt, and those whose spans overlap in a way to be reported, are summed up here.
    """
    arrays, bodies = arrays_of(query, scene, rays, low, high), np.arange(scene.lowered.body_count, dtype=np.int32)
    if plan.by != BODY:
        columns = scene.labels.columns_of(bodies, [material for material, _ in scene.labels.distinct])
        bodies = columns.astype(np.int32)
    counts, (doubts, crossed) = np.zeros(len(result), np.int32), np.zeros((2, len(result)), np.int8)
    total = result.reshape(len(result), math.prod(plan.axes))
    sums = SpanSums(bodies, np.ascontiguousarray(plan.weights), plan.groups, total, crossed)
    if gpu.list_rows(scene, arrays, True, counts, doubts, sums) is None:
        return False
    checks = plan.checks and plan.overlaps != COUNT_BOTH and not (plan.overlaps is None and has_note(scene.labels))
    which = np.flatnonzero(doubts | crossed if checks else doubts)
    if len(which):
        few = arrays.some(which)
        some = Rays._spawned(
            few.origins, few.directions, rays._starts[which] if len(rays._starts) > 1 else rays._starts, rays._home
        )
        low, high = (each if len(each) > 1 else float(each[0]) for each in (few.t_min, few.t_max))
        result[which] = plan.sums(spans(scene, some, low, high, "cpu"))
    return True


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
