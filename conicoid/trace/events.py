"""The crossings of a ray with one body, in order.

Every leaf of a body's program gives the ends of its spans as events. They are sorted and taken in
groups of equal t: all leaves of a group turn at once, and only if the body's truth differs before
and after the group is there a crossing. Coincident faces settle themselves so, without a tolerance.
"""

from __future__ import annotations

import math

from ..geometry import tables as table
from ..geometry.cell import NO_PLACE, cell_spans, curved_roots, is_curved, place_face, plane_crossing
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
    return walk(geometry, scratch.inner_stack, scratch.near, scratch.inner_beam, program, ray, scratch.found_leaves)


@helper
def gather(geometry: Geometry, scratch: Scratch, program: int, ray: Ray) -> int:
    """Put the span ends of all leaves that the ray can meet into scratch, sorted; their number."""
    count = 0
    inverse = span_inverse(ray)
    for k in range(leaves_met(geometry, scratch, program, ray)):
        leaf = scratch.found_leaves[k]
        spans, in1, out1, a1, b1, in2, out2, a2, b2 = cell_spans(
            geometry, integer(geometry, table.LEAF_CELL, leaf), ray, inverse
        )
        if spans > 0:
            count = _put(scratch, count, in1, leaf, a1, 1)
            count = _put(scratch, count, out1, leaf, b1, 0)
        if spans > 1:
            count = _put(scratch, count, in2, leaf, a2, 1)
            count = _put(scratch, count, out2, leaf, b2, 0)
    _sort(scratch, count)
    return count


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


@helper
def region_crossings(geometry: Geometry, scratch: Scratch, program: int, ray: Ray, limit: int) -> tuple[int, bool]:
    """(number of crossings in ]t_min, t_max[, inside just after t_min) of a region; stops after `limit`."""
    t_min, t_max = ray[6], ray[7]
    events = gather(geometry, scratch, program, ray)
    gates = scratch.counts
    done, found = 0, 0
    while done < events and scratch.event_t[done] <= t_min:
        turn_leaf(geometry, gates, scratch.event_leaf[done], scratch.event_on[done] == 1)
        done += 1
    inside = root_value(geometry, gates, program)
    started_inside = inside
    while done < events and found < limit:
        t = scratch.event_t[done]
        if not t < t_max:
            break
        first = done
        while done < events and scratch.event_t[done] == t:
            turn_leaf(geometry, gates, scratch.event_leaf[done], scratch.event_on[done] == 1)
            done += 1
        after = root_value(geometry, gates, program)
        if after != inside:
            inside = after
            found += _report(geometry, scratch, first, done, ray[8], after, found)
    turn_back(geometry, scratch, done)
    return found, started_inside


@helper
def turn_back(geometry: Geometry, scratch: Scratch, done: int) -> None:
    """Undo the first `done` events, last to first: every leaf is outside again."""
    for i in range(done - 1, -1, -1):
        turn_leaf(geometry, scratch.counts, scratch.event_leaf[i], scratch.event_on[i] == 0)


@helper
def region_sides(geometry: Geometry, scratch: Scratch, program: int, ray: Ray, t: float) -> tuple[bool, bool]:
    """(inside just before t, inside just after t) of a region."""
    events = gather(geometry, scratch, program, ray)
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
def inside_program_at(geometry: Geometry, scratch: Scratch, program: int, ray: Ray, t: float) -> bool:
    """Is the point at t in a region, its leaves taken as closed?"""
    ox, oy, oz, dx, dy, dz, _, _, start = ray
    events = gather(geometry, scratch, program, (ox, oy, oz, dx, dy, dz, t, t, start))
    for sweep in range(2):
        for i in range(events):
            enters = scratch.event_on[i] == 1
            if scratch.event_t[i] < t or (enters and scratch.event_t[i] == t):
                turn_leaf(geometry, scratch.counts, scratch.event_leaf[i], enters == (sweep == 0))
        if sweep == 0:
            inside = root_value(geometry, scratch.counts, program)
    return inside


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


@helper
def sheet_crossings(geometry: Geometry, scratch: Scratch, sheet: int, ray: Ray) -> int:
    """Crossings of a clipped surface in ]t_min, t_max[. "Entered" is against the sheet's normal."""
    surface, program = integer(geometry, table.SHEET_SURFACE, sheet), integer(geometry, table.SHEET_PROGRAM, sheet)
    side, one_sided = integer(geometry, table.SHEET_SIDE, sheet), integer(geometry, table.SHEET_ONE_SIDED, sheet) == 1
    low, high, falls, count = math.inf, math.inf, False, 0
    if is_curved(geometry, surface):
        low, high, outside, crosses = curved_roots(geometry, surface, ray, span_inverse(ray))
        if not crosses:
            return 0
        falls = not outside
    else:
        low, _, rate = plane_crossing(geometry, surface, ray)
        if rate == 0.0:
            return 0
        falls = rate < 0.0
    for root in range(2):
        t = low if root == 0 else high
        against = (falls != (root == 1)) == (side > 0)
        if not counts_in(t, surface, ray) or (one_sided and not against):
            continue
        if program >= 0 and not inside_program_at(geometry, scratch, program, ray, t):
            continue
        _write(scratch, count, t, NO_PLACE, 1, 1 if against else 0)
        count += 1
    return count


@helper
def polygon_crossings(geometry: Geometry, scratch: Scratch, polygon: int, ray: Ray) -> int:
    """The crossing of a polygon in ]t_min, t_max[, if any."""
    surface, program = (
        integer(geometry, table.POLYGON_SURFACE, polygon),
        integer(geometry, table.POLYGON_PROGRAM, polygon),
    )
    t, _, rate = plane_crossing(geometry, surface, ray)
    if rate == 0.0 or not counts_in(t, surface, ray):
        return 0
    if not inside_loop(
        geometry,
        integer(geometry, table.POLYGON_FIRST, polygon),
        integer(geometry, table.POLYGON_FIRST, polygon + 1),
        ray,
    ):
        return 0
    if program >= 0 and not inside_program_at(geometry, scratch, program, ray, t):
        return 0
    side = integer(geometry, table.POLYGON_SIDE, polygon)
    _write(scratch, 0, t, NO_PLACE, 1, 1 if (rate < 0.0) == (side > 0) else 0)
    return 1


@inline
def _end(scratch: Scratch, count: int, t: float, ray: Ray, surface: int, place: int, enters: int) -> int:
    if not counts_in(t, surface, ray):
        return count
    _write(scratch, count, t, place, 1, enters)
    return count + 1


@inline
def cell_crossings(geometry: Geometry, scratch: Scratch, cell: int, ray: Ray) -> tuple[int, bool]:
    """(number of crossings in ]t_min, t_max[, inside just after t_min) of a single cell."""
    spans, in1, out1, a1, b1, in2, out2, a2, b2 = cell_spans(geometry, cell, ray, span_inverse(ray))
    count, inside = 0, False
    for k in range(spans):
        t_in, t_out, a, b = (in1, out1, a1, b1) if k == 0 else (in2, out2, a2, b2)
        inside |= t_in <= ray[6] < t_out
        count = _end(scratch, count, t_in, ray, surface_of(geometry, a, t_in), a, 1)
        count = _end(scratch, count, t_out, ray, surface_of(geometry, b, t_out), b, 0)
    return count, inside


@inline
def surface_of(geometry: Geometry, place: int, t: float) -> int:
    """The surface of a place where it matters: at t = 0, where it may be the one that the ray starts on."""
    return place_face(geometry, place)[0] if t == 0.0 else whole(-1)


@inline
def ball_crossings(geometry: Geometry, scratch: Scratch, surface: int, ray: Ray) -> tuple[int, bool]:
    """(number of crossings in ]t_min, t_max[, inside just after t_min) of a ball."""
    low, high, _, crosses = curved_roots(geometry, surface, ray, span_inverse(ray))
    if not crosses:
        return 0, False
    count = _end(scratch, 0, low, ray, surface, NO_PLACE, 1)
    return _end(scratch, count, high, ray, surface, NO_PLACE, 0), low <= ray[6] < high


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
def entry_crossings(geometry: Geometry, scratch: Scratch, entry: int, ray: Ray, limit: int) -> tuple[int, bool]:
    """Crossings of an entry's body into scratch, in order of t: (number, inside just after t_min)."""
    kind, index = integer(geometry, table.ENTRY_KIND, entry), integer(geometry, table.ENTRY_INDEX, entry)
    if kind == BALL:
        return ball_crossings(geometry, scratch, index, ray)
    if kind == CELL:
        return cell_crossings(geometry, scratch, index, ray)
    if kind == REGION:
        return region_crossings(geometry, scratch, index, ray, limit)
    if kind == SHEET:
        return sheet_crossings(geometry, scratch, index, ray), False
    return polygon_crossings(geometry, scratch, index, ray), False


@inline
def is_solid(geometry: Geometry, entry: int) -> bool:
    return integer(geometry, table.ENTRY_KIND, entry) <= REGION


@helper
def entry_sides(geometry: Geometry, scratch: Scratch, entry: int, ray: Ray, t: float) -> tuple[bool, bool]:
    """(inside just before t, inside just after t) of an entry's body; a sheet has no inside."""
    kind, index = integer(geometry, table.ENTRY_KIND, entry), integer(geometry, table.ENTRY_INDEX, entry)
    if kind == BALL:
        low, high, _, crosses = curved_roots(geometry, index, ray, span_inverse(ray))
        return crosses and low < t <= high, crosses and low <= t < high
    if kind == CELL:
        spans, in1, out1, _, _, in2, out2, _, _ = cell_spans(geometry, index, ray, span_inverse(ray))
        before = (spans > 0 and in1 < t <= out1) or (spans > 1 and in2 < t <= out2)
        return before, (spans > 0 and in1 <= t < out1) or (spans > 1 and in2 <= t < out2)
    if kind == REGION:
        return region_sides(geometry, scratch, index, ray, t)
    return False, False
