"""Path lengths and line integrals of any number of rays: a kernel adds up the spans of rays as soon as it finds them.

The sum of a ray is that of its own spans in their order. The spans themselves are made for few rays: for those in
doubt, and for those in which bodies overlap, until that is reported.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from .._util.arrays import FloatArray
from ..kernels.crossings import DOUBTFUL, OVERLAPPING, sum_rays
from ..kernels.packet.lanes import LANES
from ..kernels.ray import RayArrays
from ..kernels.threads import KernelRange, Progress, chunk_of_rays, run_on
from ..prepare.prepared_scene import PreparedScene
from .device_choice import device_of
from .overlaps import COUNT_BOTH, check_overlaps, is_silent
from .ray_queries import _are_few, _packets, arrays_of, as_rays, rays_after_values
from .rays import Rays, packet_progress
from .spans import Spans, refuse_large_lengths, trace_lists
from .weights import BODY, check_by, weights_of

if TYPE_CHECKING:
    from .device import Device

_PACKETS = 64  # packets that a thread takes at a time, at most
_SOME = 1 << 10  # rays whose spans are made at a time
_ON_CARD = 1 << 22  # rays between two calls of `progress` where a GPU sums up


class SumPlan(NamedTuple):
    """The values that are summed up along rays, and the form of the sums."""

    query: str
    by: str
    table: FloatArray  # weights (rows, width), or (0, width) for lengths
    axes: tuple[int, ...]  # of the sums, after those of the rays
    overlaps: str | None
    of_spans: Callable[[Spans], FloatArray]  # the sums of spans, which reports overlaps

    def places(self, scene: PreparedScene) -> Any:
        """Return the place of each body among the sums, or its row of weights."""
        return np.arange(scene.lowered.body_count, dtype=np.int32) if self.by == BODY else scene.material_columns

    @property
    def is_grouped(self) -> bool:
        """Whether only spans of one material overlap."""
        return not len(self.table) and self.by != BODY

    def exact_sums(
        self, scene: PreparedScene, marks: Any, some: Callable[[Any], RayArrays], home: bytes | None
    ) -> Iterator[tuple[Any, FloatArray]]:
        """Yield the numbers of some rays with marks, and their sums, which are those of their spans.

        some: returns the rays of such numbers; home: the key of the scene of the surfaces on which they start.
        """
        # NumPy finds places in a mask ten times as fast as in bytes
        pending = np.flatnonzero(marks == DOUBTFUL if is_silent(scene.labels, self.overlaps) else marks != 0)
        for begin in range(0, len(pending), _SOME):
            which = pending[begin : begin + _SOME]
            if is_silent(scene.labels, self.overlaps):
                which = which[marks[which] == DOUBTFUL]
            if len(which):
                arrays = some(which)
                own = Rays._spawned(arrays.origins, arrays.directions, arrays.starts, home)
                found = Spans(scene, own, trace_lists(scene, arrays, 0, -(-len(which) // LANES), True))
                yield which, self.of_spans(found).reshape(len(which), -1)


def answer(
    scene: PreparedScene, query: str, origins: Any, directions: Any, t_min: Any, t_max: Any,
    progress: Progress | None, options: dict[str, Any], device: str | None = None,
) -> Any:  # fmt: skip
    """Return `lengths` or `line_integral` of rays, equal to those of their spans to the bit, in bounded memory.

    options: the arguments beyond rays and interval.
    """
    if query == "lengths":
        rays = as_rays(query, origins, directions, keep=False)
    else:
        rays = rays_after_values(options["values"], origins, directions)
    plan = plan_of(scene, query, rays.size, **options)
    return sum_along(scene, rays, t_min, t_max, plan, progress, device).reshape((*rays.shape, *plan.axes))[()]


def plan_of(scene: PreparedScene, query: str, count: int, overlaps: Any = None, **options: Any) -> SumPlan:
    """Return the plan of `lengths` or `line_integral` of so many rays. Raise ValueError for wrong options."""
    how: Any
    if query == "lengths":
        by, axes = options["by"], trailing_axes(scene, query, options)
        how = check_overlaps(query, overlaps)
        refuse_large_lengths(count, axes[0], by)
        how = COUNT_BOTH if how is None and by == BODY else how
        return SumPlan(query, by, np.empty((0, *axes)), axes, how, lambda some: some.lengths(by, overlaps=how))
    weights = weights_of(options["values"], options["otherwise"], scene.lowered.body_count, scene.labels.distinct)
    how = check_overlaps(query, overlaps)
    if how is None and (weights.values < 0).any():
        how = COUNT_BOTH
    table = np.ascontiguousarray(weights.values.reshape(len(weights.values), math.prod(weights.shape)))
    return SumPlan(query, weights.by, table, weights.shape, how, lambda some: some._integral(weights, how))


def trailing_axes(scene: PreparedScene, query: str, options: dict[str, Any]) -> tuple[int, ...]:
    """Return the axes of values, also of `occluded`, after those of the rays. Raise ValueError for wrong options."""
    if query == "occluded":
        return ()
    if query == "lengths":
        by = check_by("lengths", options["by"])
        return (scene.lowered.body_count if by == BODY else len(scene.labels.distinct),)
    return weights_of(options["values"], options["otherwise"], scene.lowered.body_count, scene.labels.distinct).shape


def sum_along(
    scene: PreparedScene, rays: Rays, t_min: Any, t_max: Any, plan: SumPlan, progress: Progress | None,
    device: str | None,
) -> FloatArray:  # fmt: skip
    """Return the sums (rays, columns) of all rays."""
    gpu = device_of(plan.query, device, _are_few(rays))
    arrays = arrays_of(plan.query, scene, rays, t_min, t_max)
    count, (width, packets) = len(arrays.origins), _packets(rays)
    columns = np.zeros(0, np.int32) if plan.by == BODY else scene.material_columns
    total, counts, marks = np.empty((count, plan.table.shape[1])), np.empty(count, np.int32), np.zeros(count, np.int8)
    if gpu is None or not _sum_on_card(gpu, scene, arrays, plan, total, marks, progress):
        chunk = chunk_of_rays(scene.geometry, packets, _PACKETS, count)
        work = KernelRange(sum_rays, (arrays, width, columns, plan.table), (total, counts, marks))
        run_on(scene.geometry, work, packets, chunk, count, progress and packet_progress(progress, packets, count))
    for which, sums in plan.exact_sums(scene, marks, arrays.some, rays._home):
        total[which] = sums
    return total


def _sum_on_card(
    gpu: Device, scene: PreparedScene, arrays: RayArrays, plan: SumPlan, total: FloatArray, marks: Any,
    progress: Progress | None,
) -> bool:  # fmt: skip
    """Write the sums and marks of rays by a GPU; return False if it has too little memory."""
    from .device import SpanSums

    places = plan.places(scene)
    for begin in range(0, len(total), _ON_CARD):
        part = slice(begin, min(begin + _ON_CARD, len(total)))
        counts, (doubts, crossed) = np.zeros(part.stop - begin, np.int32), np.zeros((2, part.stop - begin), np.int8)
        sums = SpanSums(places, plan.table, plan.is_grouped, total[part], crossed)
        if gpu.list_rows(scene, arrays.some(part), True, counts, doubts, sums) is None:
            return False
        marks[part] = marks_of(doubts, crossed)
        if progress is not None:
            progress(part.stop, len(total))
    return True


def marks_of(doubts: Any, crossed: Any) -> Any:
    """Return the marks of rays whose spans are in doubt, or overlap."""
    return np.where(doubts, np.int8(DOUBTFUL), np.where(crossed, np.int8(OVERLAPPING), np.int8(0)))
