"""Path lengths and line integrals of any number of rays: a kernel adds up the spans of rays as soon as it finds them.

The sum of a ray is that of its own spans in their order. The spans themselves are made for few rays: for those in
doubt, and for those in which bodies overlap, until that is reported.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from .._util.arrays import FloatArray
from ..kernels.crossings import DOUBTFUL, sum_rays
from ..kernels.packet.lanes import LANES
from ..kernels.ray import RayArrays
from ..kernels.threads import KernelRange, Progress, chunk_of_rays, run_on
from ..prepare.prepared_scene import PreparedScene
from .overlaps import COUNT_BOTH, check_overlaps, is_silent
from .ray_queries import _packets, arrays_of, as_rays, rays_after_values
from .rays import Rays
from .spans import Spans, refuse_large_lengths, trace_lists
from .weights import BODY, check_by, weights_of

_PACKETS = 64  # packets that a thread takes at a time, at most
_SOME = 1 << 10  # rays whose spans are made at a time


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
    if how is None and (weights.values < 0).any():
        how = COUNT_BOTH
    table = np.ascontiguousarray(weights.values.reshape(len(weights.values), math.prod(weights.shape)))
    arrays = arrays_of("line_integral", scene, rays, t_min, t_max)
    total = _sums(
        scene, rays, arrays, weights.by, table, how, lambda some: some._integral(weights, how), progress
    )  # fmt: skip
    return total.reshape((*rays.shape, *weights.shape))[()]


def lengths(
    scene: PreparedScene, rays: Rays, t_min: Any, t_max: Any, by: Any, progress: Progress | None, overlaps: Any = None
) -> FloatArray:
    """Return `spans(...).lengths(by)`, to the bit; beyond the result itself memory is bounded."""
    (count,) = trailing_axes(scene, "lengths", dict(by=by))
    how: Any = check_overlaps("lengths", overlaps)
    refuse_large_lengths(rays.size, count, by)
    how = COUNT_BOTH if how is None and by == BODY else how
    arrays = arrays_of("lengths", scene, rays, t_min, t_max)
    total = _sums(
        scene, rays, arrays, by, np.empty((0, count)), how, lambda some: some.lengths(by, overlaps=how), progress
    )  # fmt: skip
    return total.reshape((*rays.shape, count))


def trailing_axes(scene: PreparedScene, query: str, options: dict[str, Any]) -> tuple[int, ...]:
    """Return the axes of values, also of `occluded`, after those of the rays. Raise ValueError for wrong options."""
    if query == "occluded":
        return ()
    if query == "lengths":
        by = check_by("lengths", options["by"])
        return (scene.lowered.body_count if by == BODY else len(scene.labels.distinct),)
    return weights_of(options["values"], options["otherwise"], scene.lowered.body_count, scene.labels.distinct).shape


def _sums(
    scene: PreparedScene, rays: Rays, arrays: RayArrays, by: str, table: FloatArray, overlaps: str | None,
    sums: Callable[[Spans], FloatArray], progress: Progress | None,
) -> FloatArray:  # fmt: skip
    """Return the sums (rays, columns) of all rays; `sums` has those of spans, and reports overlaps."""
    count, (width, packets) = len(arrays.origins), _packets(rays)
    columns = np.zeros(0, np.int32) if by == BODY else scene.material_columns
    total, counts, marks = np.empty((count, table.shape[1])), np.empty(count, np.int32), np.zeros(count, np.int8)
    chunk = chunk_of_rays(scene.geometry, packets, _PACKETS, count)
    work = KernelRange(sum_rays, (arrays, width, columns, table), (total, counts, marks))
    run_on(scene.geometry, work, packets, chunk, count, progress and _in_rays(progress, count))
    pending = np.flatnonzero(marks)
    for begin in range(0, len(pending), _SOME):
        which = pending[begin : begin + _SOME]
        if is_silent(scene.labels, overlaps):
            which = which[marks[which] == DOUBTFUL]
        if len(which):
            some = arrays.some(which)
            own = Rays._spawned(some.origins, some.directions, some.starts, rays._home)
            found = Spans(scene, own, trace_lists(scene, some, 0, -(-len(which) // LANES), True))
            total[which] = sums(found).reshape(len(which), -1)
    return total


def _in_rays(progress: Progress, count: int) -> Progress:
    """Return a callback for packets that calls another with rays."""
    return lambda done, _: progress(min(LANES * done, count), count)
