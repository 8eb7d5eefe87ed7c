"""The crossings of a ray with one body, in order.

Every leaf of a body's program gives the ends of its spans as events. They are sorted and taken in
groups of equal t: all leaves of a group turn at once, and only if the body's truth differs before
and after the group is there a crossing. Coincident faces settle themselves so, without a tolerance.
"""

from __future__ import annotations

import math

from ..geometry import tables as table
from ..geometry.cell import NO_PLACE, cell_spans, curved_roots, is_curved, load_sphere, place_face, plane_crossing
from ..geometry.nearness import Nearness, along, beyond, lengths_of_ball, near, nearness_of
from ..geometry.polygon import inside_loop
from ..geometry.program import root_value, turn_leaf
from ..geometry.tables import BALL, CELL, POLYGON, REGION, SHEET, Geometry, Ray, integer, whole
from ..jit import helper, inline
from .scratch import Scratch
from .walk import walk


@inline
def span_inverse(ray: Ray) -> float:
    """1 / d·d"""
    return 1.0 / (ray[3] * ray[3] + ray[4] * ray[4] + ray[5] * ray[5])


@inline
def _put(scratch: Scratch, count: int, t: float, leaf: int, place: int, on: int) -> int:
    scratch.event_t[count] = t
    scratch.event_leaf[count] = leaf
    scratch.event_place[count] = place
    scratch.event_on[count] = on
    return count + 1


@inline
def leaves_met(geometry: Geometry, scratch: Scratch, program: int, ray: Ray) -> int:
    """Put the leaves of a program that the ray can meet into scratch.found_leaves; returns how many."""
    if scratch.known[0] >= 0:
        return scratch.known[0]
    return walk(geometry, scratch.inner_stack, scratch.near, scratch.inner_beam, program, ray, scratch.found_leaves)


@helper
def gather(geometry: Geometry, scratch: Scratch, program: int, ray: Ray) -> tuple[int, bool]:
    """Put the span ends of all leaves that the ray can meet into scratch, sorted: (their number, are they doubtful)."""
    count, doubtful = 0, False
    inverse = span_inverse(ray)
    for k in range(leaves_met(geometry, scratch, program, ray)):
        leaf = scratch.found_leaves[k]
        spans, in1, out1, a1, b1, in2, out2, a2, b2, unsure = cell_spans(
            geometry, integer(geometry, table.LEAF_CELL, leaf), ray, inverse
        )
        doubtful |= unsure
        if spans > 0:
            count = _put(scratch, count, in1, leaf, a1, 1)
            count = _put(scratch, count, out1, leaf, b1, 0)
        if spans > 1:
            count = _put(scratch, count, in2, leaf, a2, 1)
            count = _put(scratch, count, out2, leaf, b2, 0)
    _sort(scratch, count)
    return count, doubtful


@inline
def _later(scratch: Scratch, i: int, t: float, leaf: int) -> bool:
    return scratch.event_t[i] > t or (scratch.event_t[i] == t and scratch.event_leaf[i] > leaf)


@helper
def _sort(scratch: Scratch, count: int) -> None:
    """By t, then by leaf (Shell's sort, gaps after Ciura 2001 and growing by 9/4)."""
    gap = 1
    while gap < count // 2:
        gap = gap * 9 // 4 + 1
    while gap > 0:
        for i in range(gap, count):
            t, leaf, place, on = scratch.event_t[i], scratch.event_leaf[i], scratch.event_place[i], scratch.event_on[i]
            j = i
            while j >= gap and _later(scratch, j - gap, t, leaf):
                scratch.event_t[j], scratch.event_leaf[j] = scratch.event_t[j - gap], scratch.event_leaf[j - gap]
                scratch.event_place[j], scratch.event_on[j] = scratch.event_place[j - gap], scratch.event_on[j - gap]
                j -= gap
            scratch.event_t[j], scratch.event_leaf[j], scratch.event_place[j], scratch.event_on[j] = t, leaf, place, on
        gap = gap * 4 // 9


@inline
def _unsettled(geometry: Geometry, scratch: Scratch, k: int, nearness: Nearness) -> bool:
    """Might rounding have put event k after the one before it, or together with it? Not on the same surface."""
    t, before = scratch.event_t[k], scratch.event_t[k - 1]
    if not near(t, before, nearness):
        return False
    here, there = scratch.event_place[k], scratch.event_place[k - 1]
    return t != before or place_face(geometry, here)[0] != place_face(geometry, there)[0]


@helper
def region_crossings(
    geometry: Geometry, scratch: Scratch, program: int, ray: Ray, limit: int
) -> tuple[int, bool, bool]:
    """(number of crossings in ]t_min, t_max[, inside just after t_min, doubtful) of a region; stops after `limit`."""
    t_min, t_max = ray[6], ray[7]
    nearness = nearness_of(geometry, table.PROGRAM_LIMITS, program, ray, span_inverse(ray))
    events, unsure = gather(geometry, scratch, program, ray)
    gates = scratch.counts
    done, found = 0, 0
    while done < events and scratch.event_t[done] <= t_min:
        turn_leaf(geometry, gates, scratch.event_leaf[done], scratch.event_on[done] == 1)
        done += 1
    inside = root_value(geometry, gates, program)
    started_inside = inside
    if done > 0:
        unsure |= _at_start(geometry, scratch, done - 1, ray, nearness)
    while done < events and found < limit:
        t = scratch.event_t[done]
        unsure |= _at_start(geometry, scratch, done, ray, nearness) | beyond(t, nearness)
        if not t < t_max:
            break
        first = done
        while done < events and scratch.event_t[done] == t:
            turn_leaf(geometry, gates, scratch.event_leaf[done], scratch.event_on[done] == 1)
            done += 1
            unsure |= done < events and _unsettled(geometry, scratch, done, nearness)
        after = root_value(geometry, gates, program)
        if after != inside:
            inside = after
            found += _report(geometry, scratch, first, done, ray[8], after, found)
    turn_back(geometry, scratch, done)
    return found, started_inside, unsure


@inline
def _at_start(geometry: Geometry, scratch: Scratch, k: int, ray: Ray, nearness: Nearness) -> bool:
    t = scratch.event_t[k]
    return at_start(t, surface_of(geometry, scratch.event_place[k], t), ray, nearness)


@helper
def turn_back(geometry: Geometry, scratch: Scratch, done: int) -> None:
    """Undo the first `done` events, last to first: every leaf is outside again."""
    for i in range(done - 1, -1, -1):
        turn_leaf(geometry, scratch.counts, scratch.event_leaf[i], scratch.event_on[i] == 0)


@helper
def region_sides(geometry: Geometry, scratch: Scratch, program: int, ray: Ray, t: float) -> tuple[bool, bool]:
    """(inside just before t, inside just after t) of a region."""
    events, _ = gather(geometry, scratch, program, ray)
    done = 0
    while done < events and scratch.event_t[done] < t:
        turn_leaf(geometry, scratch.counts, scratch.event_leaf[done], scratch.event_on[done] == 1)
        done += 1
    before = root_value(geometry, scratch.counts, program)
    while done < events and scratch.event_t[done] <= t:
        turn_leaf(geometry, scratch.counts, scratch.event_leaf[done], scratch.event_on[done] == 1)
        done += 1
    after = root_value(geometry, scratch.counts, program)
    turn_back(geometry, scratch, done)
    return before, after


@inline
def _report(geometry: Geometry, scratch: Scratch, first: int, last: int, start: int, entered: bool, n: int) -> int:
    """The crossing shows the first leaf of the group that turned the way the body did. 0: it is the ray's start."""
    chosen = first
    for i in range(first, last):
        if (scratch.event_on[i] == 1) == (entered == (integer(geometry, table.LEAF_SENSE, scratch.event_leaf[i]) > 0)):
            chosen = i
            break
    t, place = scratch.event_t[chosen], scratch.event_place[chosen]
    _write(scratch, n, t, place, integer(geometry, table.LEAF_SENSE, scratch.event_leaf[chosen]), 1 if entered else 0)
    return 0 if t == 0.0 and place_face(geometry, place)[0] == start else 1


@helper
def inside_program_at(geometry: Geometry, scratch: Scratch, program: int, ray: Ray, t: float) -> tuple[bool, bool]:
    """(is the point at t in a region, its leaves taken as closed, is that doubtful)"""
    ox, oy, oz, dx, dy, dz, _, _, start = ray
    ray = (ox, oy, oz, dx, dy, dz, t, t, start)
    nearness = nearness_of(geometry, table.PROGRAM_LIMITS, program, ray, span_inverse(ray))
    events, unsure = gather(geometry, scratch, program, ray)
    for sweep in range(2):
        for i in range(events):
            enters = scratch.event_on[i] == 1
            unsure |= near(scratch.event_t[i], t, nearness)
            if scratch.event_t[i] < t or (enters and scratch.event_t[i] == t):
                turn_leaf(geometry, scratch.counts, scratch.event_leaf[i], enters == (sweep == 0))
        if sweep == 0:
            inside = root_value(geometry, scratch.counts, program)
    return inside, unsure


@inline
def _write(scratch: Scratch, n: int, t: float, place: int, sense: int, enters: int) -> None:
    scratch.cross_t[n] = t
    scratch.crossing[3 * n] = place
    scratch.crossing[3 * n + 1] = sense
    scratch.crossing[3 * n + 2] = enters


@inline
def counts_in(t: float, surface: int, ray: Ray) -> bool:
    """Is a crossing within ]t_min, t_max[, and not the one that the ray starts on?"""
    return ray[6] < t < ray[7] and not (t == 0.0 and surface == ray[8])


@inline
def at_start(t: float, surface: int, ray: Ray, nearness: Nearness) -> bool:
    """Might rounding have taken a crossing to the other side of the ray's origin? Not the one that it starts on.

    Other ends of the interval are compared with t as it is told, so what is told lies within them.
    """
    starts = (t == 0.0) & (surface == ray[8])
    return (abs(t) <= nearness[0]) & (ray[6] <= nearness[0]) & (not starts)


@helper
def sheet_crossings(geometry: Geometry, scratch: Scratch, sheet: int, ray: Ray) -> tuple[int, bool]:
    """(crossings of a clipped surface in ]t_min, t_max[, doubtful). "Entered" is against the sheet's normal."""
    surface, program = integer(geometry, table.SHEET_SURFACE, sheet), integer(geometry, table.SHEET_PROGRAM, sheet)
    side, one_sided = integer(geometry, table.SHEET_SIDE, sheet), integer(geometry, table.SHEET_ONE_SIDED, sheet) == 1
    low, high, falls, count, inverse = math.inf, math.inf, False, 0, span_inverse(ray)
    nearness = nearness_of(geometry, table.SHEET_LIMITS, sheet, ray, inverse)
    if is_curved(geometry, surface):
        low, high, outside, crosses, unsure = curved_roots(geometry, surface, ray, inverse)
        if not crosses:
            return 0, unsure
        falls = not outside
    else:
        low, _, rate, unsure = plane_crossing(geometry, surface, ray, inverse)
        if rate == 0.0:
            return 0, unsure
        falls = rate < 0.0
    unsure |= nearness[1] < 0.0
    for root in range(2):
        t = low if root == 0 else high
        against = (falls != (root == 1)) == (side > 0)
        unsure |= at_start(t, surface, ray, nearness)
        if not counts_in(t, surface, ray) or (one_sided and not against):
            continue
        unsure |= beyond(t, nearness)
        if program >= 0:
            holds, doubtful = inside_program_at(geometry, scratch, program, ray, t)
            unsure |= doubtful
            if not holds:
                continue
        _write(scratch, count, t, NO_PLACE, 1, 1 if against else 0)
        count += 1
    return count, unsure


@helper
def polygon_crossings(geometry: Geometry, scratch: Scratch, polygon: int, ray: Ray) -> tuple[int, bool]:
    """(crossings of a polygon in ]t_min, t_max[: 0 or 1, doubtful)"""
    surface, program = (
        integer(geometry, table.POLYGON_SURFACE, polygon),
        integer(geometry, table.POLYGON_PROGRAM, polygon),
    )
    inverse = span_inverse(ray)
    nearness = nearness_of(geometry, table.POLYGON_LIMITS, polygon, ray, inverse)
    t, _, rate, unsure = plane_crossing(geometry, surface, ray, inverse)
    unsure |= at_start(t, surface, ray, nearness)
    if rate == 0.0 or not counts_in(t, surface, ray):
        return 0, unsure
    first, last = (
        integer(geometry, table.POLYGON_FIRST, polygon),
        integer(geometry, table.POLYGON_FIRST, polygon + 1),
    )
    inside, doubtful = inside_loop(geometry, first, last, ray)
    unsure |= doubtful | beyond(t, nearness)
    if inside and program >= 0:
        inside, doubtful = inside_program_at(geometry, scratch, program, ray, t)
        unsure |= doubtful
    if not inside:
        return 0, unsure
    side = integer(geometry, table.POLYGON_SIDE, polygon)
    _write(scratch, 0, t, NO_PLACE, 1, 1 if (rate < 0.0) == (side > 0) else 0)
    return 1, unsure


@inline
def _end(scratch: Scratch, count: int, t: float, ray: Ray, surface: int, place: int, enters: int) -> int:
    if not counts_in(t, surface, ray):
        return count
    _write(scratch, count, t, place, 1, enters)
    return count + 1


@inline
def cell_crossings(geometry: Geometry, scratch: Scratch, cell: int, ray: Ray) -> tuple[int, bool, bool]:
    """(number of crossings in ]t_min, t_max[, inside just after t_min, doubtful) of a single cell."""
    inverse = span_inverse(ray)
    nearness = nearness_of(geometry, table.CELL_LIMITS, cell, ray, inverse)
    spans, in1, out1, a1, b1, in2, out2, a2, b2, unsure = cell_spans(geometry, cell, ray, inverse)
    count, inside = 0, False
    for k in range(spans):
        t_in, t_out, a, b = (in1, out1, a1, b1) if k == 0 else (in2, out2, a2, b2)
        inside |= t_in <= ray[6] < t_out
        first, second = surface_of(geometry, a, t_in), surface_of(geometry, b, t_out)
        unsure |= at_start(t_in, first, ray, nearness) | at_start(t_out, second, ray, nearness)
        unsure |= beyond(t_in, nearness) | beyond(t_out, nearness)
        count = _end(scratch, count, t_in, ray, first, a, 1)
        count = _end(scratch, count, t_out, ray, second, b, 0)
    return count, inside, unsure


@inline
def surface_of(geometry: Geometry, place: int, t: float) -> int:
    """The surface of a place where it matters: at t = 0, where it may be the one that the ray starts on."""
    return place_face(geometry, place)[0] if t == 0.0 else whole(-1)


@inline
def ball_crossings(geometry: Geometry, scratch: Scratch, surface: int, ray: Ray) -> tuple[int, bool, bool]:
    """(number of crossings in ]t_min, t_max[, inside just after t_min, doubtful) of a ball."""
    inverse = span_inverse(ray)
    low, high, _, crosses, unsure = curved_roots(geometry, surface, ray, inverse)
    nearness = surface_nearness(geometry, surface, ray, inverse)
    unsure |= nearness[1] < 0.0
    if not crosses:
        return 0, False, unsure
    unsure |= at_start(low, surface, ray, nearness) | at_start(high, surface, ray, nearness)
    count = _end(scratch, 0, low, ray, surface, NO_PLACE, 1)
    return _end(scratch, count, high, ray, surface, NO_PLACE, 0), low <= ray[6] < high, unsure


@inline
def surface_nearness(geometry: Geometry, surface: int, ray: Ray, inverse: float) -> Nearness:
    """The nearness of a ball."""
    x, y, z, radius = load_sphere(geometry, integer(geometry, table.SURFACE_ROW, surface))
    return along(ray, inverse, lengths_of_ball(x, y, z, radius))


@inline
def entry_nearness(geometry: Geometry, entry: int, ray: Ray) -> Nearness:
    """The nearness of an entry of any kind."""
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
def crossed_face(geometry: Geometry, entry: int, place: int, sense: int) -> tuple[int, int, int]:
    """(surface, face number, side) of a crossing of an entry; side +1 where the gradient points out of the body."""
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
    """Crossings of an entry's body into scratch, in order of t: (number, inside just after t_min, doubtful)."""
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
    return integer(geometry, table.ENTRY_KIND, entry) <= REGION


@helper
def entry_sides(geometry: Geometry, scratch: Scratch, entry: int, ray: Ray, t: float) -> tuple[bool, bool]:
    """(inside just before t, inside just after t) of an entry's body; a sheet has no inside."""
    kind, index = integer(geometry, table.ENTRY_KIND, entry), integer(geometry, table.ENTRY_INDEX, entry)
    if kind == BALL:
        low, high, _, crosses, _ = curved_roots(geometry, index, ray, span_inverse(ray))
        return crosses and low < t <= high, crosses and low <= t < high
    if kind == CELL:
        spans, in1, out1, _, _, in2, out2, _, _, _ = cell_spans(geometry, index, ray, span_inverse(ray))
        before = (spans > 0 and in1 < t <= out1) or (spans > 1 and in2 < t <= out2)
        return before, (spans > 0 and in1 <= t < out1) or (spans > 1 and in2 <= t < out2)
    if kind == REGION:
        return region_sides(geometry, scratch, index, ray, t)
    return False, False
