"""The crossings of a ray with one entry of the scene's tree (ball, cell, region, sheet or polygon), and their faces."""

from __future__ import annotations

import math

from ..._jit.decorators import helper, inline
from .. import tables as table
from ..bvh.walk import scene_tree, walk
from ..numbers.shell_sort import make_sort
from ..ray import Ray, span_inverse
from ..surface.interval import (
    Nearness,
    counts_in,
    is_start_crossing,
    is_too_far,
    lengths_of_ball,
    limits_of_ray,
    may_pass_start,
    nearness_of,
)
from ..surface.polygon_loop import inside_loop
from ..surface.records import curved_roots, is_curved, load_sphere, plane_crossing
from ..tables import BALL, CELL, POLYGON, REGION, SHEET, Geometry, integer, whole
from .boolean import inside_program_at, put_crossing, region_crossings, region_sides, surface_of
from .cell import NO_PLACE, CellSpans, cell_spans, end_of, place_face
from .scratch import Scratch


@helper
def sheet_crossings(geometry: Geometry, scratch: Scratch, sheet: int, ray: Ray) -> tuple[int, bool]:
    """Return (number of crossings of a clipped surface in (t_min, t_max), doubtful).

    "Entered" means against the sheet's normal. Crossings go into scratch in order of t, which follows from low < high.
    The clipping program leaves `scratch.counts` unchanged.
    """
    surface, program = integer(geometry, table.SHEET_SURFACE, sheet), integer(geometry, table.SHEET_PROGRAM, sheet)
    side, one_sided = integer(geometry, table.SHEET_SIDE, sheet), integer(geometry, table.SHEET_ONE_SIDED, sheet) == 1
    low, high, falls, count, inverse = math.inf, math.inf, False, 0, span_inverse(ray)
    starts = surface == ray.start
    # Limits belong to the sheet, not to its surface: they know how far the clipped part reaches
    nearness = nearness_of(geometry, table.SHEET_LIMITS, sheet, ray, inverse)
    if is_curved(geometry, surface):
        low, high, outside, crosses, unsure = curved_roots(geometry, surface, ray, inverse)
        if not crosses:
            return 0, unsure
        falls = not outside
    else:
        low, rate, unsure = plane_crossing(geometry, surface, ray, inverse)
        if rate == 0.0:
            return 0, unsure
        falls = rate < 0.0
    unsure |= nearness.far < 0.0
    for root in range(2):  # a plane has no second root: high stays infinite
        t = low if root == 0 else high
        against = (falls != (root == 1)) == (side > 0)  # the value changes the other way at the second root
        # Before the interval is tested: a root that does not count may count exactly
        unsure |= may_pass_start(t, starts, ray.t_min, nearness.off)
        # The far side of a one-sided sheet is skipped before the clip is tested, which is the costly part
        if not counts_in(t, starts, ray.t_min, ray.t_max) or (one_sided and not against):
            continue
        unsure |= is_too_far(t, nearness)
        if program >= 0:
            holds, doubtful = inside_program_at(geometry, scratch, program, ray, t)
            unsure |= doubtful
            if not holds:
                continue
        put_crossing(scratch, count, t, NO_PLACE, 1, 1 if against else 0)
        count += 1
    return count, unsure


@helper
def polygon_crossings(geometry: Geometry, scratch: Scratch, polygon: int, ray: Ray) -> tuple[int, bool]:
    """Return (number of crossings of a polygon in (t_min, t_max), 0 or 1; doubtful)."""
    surface, program = (
        integer(geometry, table.POLYGON_SURFACE, polygon),
        integer(geometry, table.POLYGON_PROGRAM, polygon),
    )
    inverse, starts = span_inverse(ray), surface == ray.start
    nearness = nearness_of(geometry, table.POLYGON_LIMITS, polygon, ray, inverse)
    t, rate, unsure = plane_crossing(geometry, surface, ray, inverse)
    unsure |= may_pass_start(t, starts, ray.t_min, nearness.off)
    if rate == 0.0 or not counts_in(t, starts, ray.t_min, ray.t_max):
        return 0, unsure
    first, last = (
        integer(geometry, table.POLYGON_FIRST, polygon),
        integer(geometry, table.POLYGON_FIRST, polygon + 1),
    )
    # The loop after the plane, whose test is cheaper
    inside, doubtful = inside_loop(geometry, first, last, ray)
    unsure |= doubtful | is_too_far(t, nearness)
    if inside and program >= 0:
        inside, doubtful = inside_program_at(geometry, scratch, program, ray, t)
        unsure |= doubtful
    if not inside:
        return 0, unsure
    side = integer(geometry, table.POLYGON_SIDE, polygon)
    put_crossing(scratch, 0, t, NO_PLACE, 1, 1 if (rate < 0.0) == (side > 0) else 0)
    return 1, unsure


# Crossings of solids, then of an entry of any kind


@inline
def _put_end(scratch: Scratch, count: int, t: float, starts: bool, ray: Ray, place: int, enters: int) -> int:
    """Write one end of a span as a crossing, if it counts in the interval; return the number of crossings now."""
    if not counts_in(t, starts, ray.t_min, ray.t_max):
        return count
    put_crossing(scratch, count, t, place, 1, enters)
    return count + 1


@inline
def _put_span(
    scratch: Scratch, count: int, ends: tuple[float, float], places: tuple[int, int], starts: tuple[bool, bool],
    ray: Ray, off: float,
) -> tuple[int, bool, bool]:  # fmt: skip
    """Write the ends of one span into scratch: (crossings in scratch now, inside just after t_min, doubtful)."""
    t_in, t_out = ends
    # Both ends, whichever counts: rounding may have moved either over the origin
    unsure = may_pass_start(t_in, starts[0], ray.t_min, off) | may_pass_start(t_out, starts[1], ray.t_min, off)
    inside = t_in <= ray.t_min < t_out
    # The crossing on which the ray starts is not reported: inside is then as it is beyond that crossing
    inside ^= is_start_crossing(t_in, starts[0], ray.t_min, ray.t_max) ^ is_start_crossing(
        t_out, starts[1], ray.t_min, ray.t_max
    )
    count = _put_end(scratch, count, t_in, starts[0], ray, places[0], 1)
    return _put_end(scratch, count, t_out, starts[1], ray, places[1], 0), inside, unsure


@inline
def cell_crossings(geometry: Geometry, scratch: Scratch, cell: int, ray: Ray) -> tuple[int, bool, bool]:
    """Return (number of crossings in (t_min, t_max), inside just after t_min, doubtful) of a cell."""
    inverse = span_inverse(ray)
    nearness = nearness_of(geometry, table.CELL_LIMITS, cell, ray, inverse)
    return crossings_of_spans(geometry, scratch, ray, nearness, cell_spans(geometry, cell, ray, inverse))


@inline
def crossings_of_spans(
    geometry: Geometry, scratch: Scratch, ray: Ray, nearness: Nearness, found: CellSpans
) -> tuple[int, bool, bool]:
    """`cell_crossings`, from the spans of the cell."""
    # Spans of a cell do not overlap, so that at most one of them holds t_min, and xor joins them
    count, inside, unsure = 0, False, found.unsure
    for k in range(found.number):
        t_in, place_in = end_of(found, 2 * k)
        t_out, place_out = end_of(found, 2 * k + 1)
        # By the surface, not the face: both ends of a span may lie on the quadric on which the ray starts
        starts = (
            surface_of(geometry, place_in, t_in) == ray.start,
            surface_of(geometry, place_out, t_out) == ray.start,
        )
        unsure |= is_too_far(t_in, nearness) | is_too_far(t_out, nearness)
        count, within, doubtful = _put_span(
            scratch, count, (t_in, t_out), (place_in, place_out), starts, ray, nearness.off
        )
        inside ^= within
        unsure |= doubtful
    return count, inside, unsure


@inline
def ball_crossings(geometry: Geometry, scratch: Scratch, surface: int, ray: Ray) -> tuple[int, bool, bool]:
    """Return (number of crossings in (t_min, t_max), inside just after t_min, doubtful) of a ball."""
    inverse = span_inverse(ray)
    low, high, _, crosses, unsure = curved_roots(geometry, surface, ray, inverse)
    nearness = surface_nearness(geometry, surface, ray, inverse)
    unsure |= nearness.far < 0.0
    if not crosses:
        return 0, False, unsure
    count, inside, doubtful = crossings_of_roots(scratch, surface, ray, nearness, low, high)
    return count, inside, unsure | doubtful


@inline
def crossings_of_roots(
    scratch: Scratch, surface: int, ray: Ray, nearness: Nearness, low: float, high: float
) -> tuple[int, bool, bool]:
    """`ball_crossings`, from the roots of the ball."""
    starts, place = surface == ray.start, whole(NO_PLACE)
    return _put_span(scratch, 0, (low, high), (place, place), (starts, starts), ray, nearness.off)


@inline
def surface_nearness(geometry: Geometry, surface: int, ray: Ray, inverse: float) -> Nearness:
    """Return the nearness, in t of the ray, of a ball."""
    ball = load_sphere(geometry, integer(geometry, table.SURFACE_ROW, surface))
    return limits_of_ray(ray, inverse, lengths_of_ball(ball))


@inline
def entry_nearness(geometry: Geometry, entry: int, ray: Ray) -> Nearness:
    """Return the nearness, in t of the ray, of an entry of any kind."""
    kind, index = integer(geometry, table.ENTRY_KIND, entry), integer(geometry, table.ENTRY_INDEX, entry)
    inverse = span_inverse(ray)
    if kind == BALL:
        return surface_nearness(geometry, index, ray, inverse)
    if kind == CELL:
        return nearness_of(geometry, table.CELL_LIMITS, index, ray, inverse)
    if kind == REGION:
        return nearness_of(geometry, table.PROGRAM_LIMITS, index, ray, inverse)
    if kind == SHEET:
        return nearness_of(geometry, table.SHEET_LIMITS, index, ray, inverse)
    return nearness_of(geometry, table.POLYGON_LIMITS, index, ray, inverse)


@inline
def crossing_face(geometry: Geometry, entry: int, place: int, sense: int) -> tuple[int, int, int]:
    """Return (surface, face number, side) of a crossing; side +1 where the gradient points out of the body."""
    kind, index = integer(geometry, table.ENTRY_KIND, entry), integer(geometry, table.ENTRY_INDEX, entry)
    none, one = whole(0), whole(1)
    if kind == BALL:
        return index, none, one
    if kind == SHEET:
        return integer(geometry, table.SHEET_SURFACE, index), none, integer(geometry, table.SHEET_SIDE, index)
    if kind == POLYGON:
        return integer(geometry, table.POLYGON_SURFACE, index), none, integer(geometry, table.POLYGON_SIDE, index)
    surface, face, side = place_face(geometry, place)
    return surface, face, side * sense


@inline
def entry_crossings(geometry: Geometry, scratch: Scratch, entry: int, ray: Ray, limit: int) -> tuple[int, bool, bool]:
    """Write the crossings of an entry into scratch, in order of t: (number, inside just after t_min, doubtful).

    Crossings of a solid alternate between in and out, starting from `inside`. A region stops after `limit` crossings.
    """
    kind, index = integer(geometry, table.ENTRY_KIND, entry), integer(geometry, table.ENTRY_INDEX, entry)
    if kind == BALL:
        return ball_crossings(geometry, scratch, index, ray)
    if kind == CELL:
        return cell_crossings(geometry, scratch, index, ray)
    if kind == REGION:
        return region_crossings(geometry, scratch, index, ray, limit)
    if kind == SHEET:
        count, unsure = sheet_crossings(geometry, scratch, index, ray)
    else:
        count, unsure = polygon_crossings(geometry, scratch, index, ray)
    return count, False, unsure


@inline
def is_solid(geometry: Geometry, entry: int) -> bool:
    """True if an entry has an inside; sheets and polygons have none."""
    return integer(geometry, table.ENTRY_KIND, entry) <= REGION


@helper
def entry_sides(geometry: Geometry, scratch: Scratch, entry: int, ray: Ray, t: float) -> tuple[bool, bool]:
    """Return (inside just before t, inside just after t) of an entry; False for sheets, which have no inside."""
    kind, index = integer(geometry, table.ENTRY_KIND, entry), integer(geometry, table.ENTRY_INDEX, entry)
    if kind == BALL:
        low, high, _, crosses, _ = curved_roots(geometry, index, ray, span_inverse(ray))
        return crosses and low < t <= high, crosses and low <= t < high
    if kind == CELL:
        found, before, after = cell_spans(geometry, index, ray, span_inverse(ray)), False, False
        for k in range(found.number):
            t_in, t_out = end_of(found, 2 * k)[0], end_of(found, 2 * k + 1)[0]
            before |= t_in < t <= t_out
            after |= t_in <= t < t_out
        return before, after
    if kind == REGION:
        return region_sides(geometry, scratch, index, ray, t)
    return False, False


@inline
def _larger(data: None, a: int, b: int) -> bool:
    """The order of numbers, for `make_sort`."""
    return a > b


# A shell sort needs no memory, and lists are a few entries long
_sort = make_sort(_larger)


@helper
def collect_entries(geometry: Geometry, scratch: Scratch, ray: Ray) -> int:
    """Write the entries whose boxes the ray meets within its interval into scratch.found, sorted; return the number.

    Entries are numbered in the order of their bodies, so the body listed first comes first.
    """
    count = walk(geometry, scratch.way, scene_tree(geometry), ray, scratch.found)
    # The walk finds entries by nearness; the rule of ties needs the order of the list
    _sort(scratch.found, count, None)
    return count
