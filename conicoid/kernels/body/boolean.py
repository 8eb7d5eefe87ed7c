"""The crossings of a ray with one Boolean body, in order.

Every leaf of a body's program contributes the ends of its spans as events. They are sorted and taken in groups of equal
t: all leaves of a group change at once, and the body has a crossing only if its value differs before and after the
group. So coincident faces cancel or count once, without a tolerance.

Every function finds all leaves outside in `scratch.counts` (`hold_program`), and leaves them outside (`undo_events`).
"""

from __future__ import annotations

from ..._jit.decorators import helper, inline
from .. import tables as table
from ..bvh.walk import walk_leaves
from ..numbers.shell_sort import first_gap, next_gap
from ..programs import (
    cell_of_leaf,
    gates_of,
    hold_program,
    leaf_decides,
    put_outside,
    root_value,
    sense_of,
    turn_leaf,
)
from ..ray import Ray, span_inverse, with_limits
from ..surface.interval import Nearness, has_not_ended, is_too_far, may_pass_start, may_swap, nearness_of
from ..tables import Geometry, is_halted, poll_halt, whole
from .cell import cell_spans, place_face
from .scratch import CROSS_ENTERS, CROSS_PLACE, CROSS_SENSE, CROSS_T, EVENT, LEAF, LEAF_COUNT, ON, PLACE, TIME, Scratch

_DECIDES = 2
"""Added to ON of an event while the face of its group is looked for: after the group, the leaf decides."""


@inline
def put_event(scratch: Scratch, count: int, t: float, leaf: int, place: int, on: int) -> int:
    """Write event number `count`: the ray enters (on = 1) or leaves (0) a leaf; return the number of events now."""
    scratch.time[TIME * count] = t
    at = EVENT * count
    scratch.event[at + LEAF], scratch.event[at + PLACE], scratch.event[at + ON] = leaf, place, on
    return count + 1


@inline
def collect_leaves(geometry: Geometry, scratch: Scratch, program: int, ray: Ray) -> int:
    """Write the leaves of a program that the ray can meet into scratch.found_leaves; return the number.

    Conservative: every leaf whose box meets the ray within its interval is among them. If scratch.found_leaves holds
    leaves already (`LEAF_COUNT`), these are the result.
    """
    if scratch.found_leaves[LEAF_COUNT] >= 0:
        return scratch.found_leaves[LEAF_COUNT]
    return walk_leaves(geometry, scratch.inner_way, program, ray, scratch.found_leaves)


@helper
def gather_events(geometry: Geometry, scratch: Scratch, program: int, ray: Ray) -> tuple[int, bool]:
    """Write the span ends of all leaves that the ray can meet into scratch, sorted: (number of events, doubtful)."""
    count, doubtful = 0, False
    if is_halted(geometry):
        return count, doubtful
    inverse = span_inverse(ray)
    for k in range(collect_leaves(geometry, scratch, program, ray)):
        leaf = scratch.found_leaves[k]
        found = cell_spans(geometry, cell_of_leaf(geometry, leaf), ray, inverse)
        doubtful |= found.unsure
        if found.number > 0:
            count = put_event(scratch, count, found.in1, leaf, found.place_in1, 1)
            count = put_event(scratch, count, found.out1, leaf, found.place_out1, 0)
        if found.number > 1:
            count = put_event(scratch, count, found.in2, leaf, found.place_in2, 1)
            count = put_event(scratch, count, found.out2, leaf, found.place_out2, 0)
    sort_events(scratch, count)
    return count, doubtful


@inline
def _later(scratch: Scratch, i: int, t: float, leaf: int) -> bool:
    """True if event i comes after an event of a leaf at t; at equal t the number of the leaf decides."""
    before = scratch.time[TIME * i]
    return before > t or (before == t and scratch.event[EVENT * i + LEAF] > leaf)


@helper
def sort_events(scratch: Scratch, count: int) -> None:
    """Sort events by t, then by leaf: as kernels/numbers/shell_sort.py, but it moves the events themselves."""
    time, event, gap = scratch.time, scratch.event, first_gap(count)
    while gap > 0:
        # Shell sort needs neither memory nor recursion, and a body has few events
        for i in range(gap, count):
            t, j = time[TIME * i], i
            leaf, place, on = event[EVENT * i + LEAF], event[EVENT * i + PLACE], event[EVENT * i + ON]
            while j >= gap and _later(scratch, j - gap, t, leaf):
                k = j - gap
                put_event(
                    scratch, j, time[TIME * k], event[EVENT * k + LEAF], event[EVENT * k + PLACE], event[EVENT * k + ON]
                )
                j = k
            put_event(scratch, j, t, leaf, place, on)
        gap = next_gap(gap)


@inline
def _unsettled(geometry: Geometry, scratch: Scratch, k: int, nearness: Nearness) -> bool:
    """True if rounding might have changed the order of event k and the one before; not at equal t on one surface."""
    t, before = scratch.time[TIME * k], scratch.time[TIME * (k - 1)]
    if not may_swap(t, before, nearness):
        return False
    here, there = scratch.event[EVENT * k + PLACE], scratch.event[EVENT * (k - 1) + PLACE]
    # Crossings with one surface that leaves share are at one t and make one group, whatever their order
    return t != before or place_face(geometry, here)[0] != place_face(geometry, there)[0]


@helper
def region_crossings(
    geometry: Geometry, scratch: Scratch, program: int, ray: Ray, limit: int
) -> tuple[int, bool, bool]:
    """Write the crossings of a region: (number in (t_min, t_max), inside just after t_min, doubtful).

    It stops after `limit` crossings.
    """
    events, unsure = gather_events(geometry, scratch, program, ray)
    nearness = nearness_of(geometry, table.PROGRAM_LIMITS, program, ray, span_inverse(ray))
    found, inside, doubtful = sweep_events(geometry, scratch, program, ray, nearness, events, limit)
    return found, inside, unsure | doubtful


@inline
def _turned_until(
    geometry: Geometry, scratch: Scratch, program: int, done: int, events: int, t: float, through: bool
) -> int:
    """Turn the leaves of the events from number `done` on that lie before t, or at t if `through`.

    Returns the number of the first event that it did not turn.
    """
    event = scratch.event
    while done < events and not poll_halt(geometry, done):
        end = scratch.time[TIME * done]
        if not (end < t or (through and end == t)):
            break
        turn_leaf(geometry, scratch.counts, program, event[EVENT * done + LEAF], event[EVENT * done + ON] == 1)
        done += 1
    return done


@helper
def sweep_events(
    geometry: Geometry, scratch: Scratch, program: int, ray: Ray, nearness: Nearness, events: int, limit: int
) -> tuple[int, bool, bool]:
    """`region_crossings`, from sorted events; it ends early after `limit` crossings or at t_max.

    Invariant of the loop: `inside` is the value of the program just before event `done`, and all events before it have
    turned their leaves. Doubtful if two events of different surfaces are too near and one lies within the interval.
    """
    t_min, t_max = ray.t_min, ray.t_max
    gates, event, unsure, found = scratch.counts, scratch.event, False, 0
    hold_program(geometry, gates, program)
    # Events up to t_min give the value just after it
    done = _turned_until(geometry, scratch, program, 0, events, t_min, True)
    unsure |= (done > 0) & (done < events) and _unsettled(geometry, scratch, done, nearness)
    inside = root_value(geometry, gates, program)
    started_inside = inside
    # Rounding may have put events at the origin behind the start
    last = done - 1
    while last >= 0 and abs(scratch.time[TIME * last]) <= nearness.off:
        unsure |= _at_start(geometry, scratch, last, ray, nearness)
        last -= 1
    while done < events and found < limit and not poll_halt(geometry, done):
        t = scratch.time[TIME * done]
        unsure |= _at_start(geometry, scratch, done, ray, nearness) | is_too_far(t, nearness)
        if not has_not_ended(t, t_max):
            break
        # All leaves of the group turn before the value is read
        first = done
        while done < events and scratch.time[TIME * done] == t and not poll_halt(geometry, done):
            turn_leaf(geometry, gates, program, event[EVENT * done + LEAF], event[EVENT * done + ON] == 1)
            done += 1
            unsure |= done < events and _unsettled(geometry, scratch, done, nearness)
        after = root_value(geometry, gates, program)
        if after != inside:
            inside = after
            reported = _report(geometry, scratch, program, first, done, ray.start, after, found)
            found += reported
            started_inside ^= reported == 0  # the start is not reported: the ray begins beyond it
    undo_events(geometry, scratch, program, done)
    return found, started_inside, unsure


@inline
def _at_start(geometry: Geometry, scratch: Scratch, k: int, ray: Ray, nearness: Nearness) -> bool:
    """True if rounding might have moved event k past the origin."""
    t = scratch.time[TIME * k]
    surface = surface_of(geometry, scratch.event[EVENT * k + PLACE], t)
    return may_pass_start(t, surface == ray.start, ray.t_min, nearness.off)


@helper
def undo_events(geometry: Geometry, scratch: Scratch, program: int, done: int) -> None:
    """Undo the first `done` events: every leaf is outside again."""
    first, last = gates_of(geometry, program)
    # Whichever touches fewer: all gates at once, or the path of each event's leaf
    if last - first <= done:
        put_outside(geometry, scratch.counts, program)
        return
    for i in range(done - 1, -1, -1):
        if poll_halt(geometry, i):
            return
        at = EVENT * i
        turn_leaf(geometry, scratch.counts, program, scratch.event[at + LEAF], scratch.event[at + ON] == 0)


@helper
def region_sides(geometry: Geometry, scratch: Scratch, program: int, ray: Ray, t: float) -> tuple[bool, bool]:
    """Return (inside just before t, inside just after t) of a region."""
    events, _ = gather_events(geometry, scratch, program, ray)
    hold_program(geometry, scratch.counts, program)
    done = _turned_until(geometry, scratch, program, 0, events, t, False)
    before = root_value(geometry, scratch.counts, program)
    done = _turned_until(geometry, scratch, program, done, events, t, True)
    after = root_value(geometry, scratch.counts, program)
    undo_events(geometry, scratch, program, done)
    return before, after


@helper
def deciding_event(geometry: Geometry, scratch: Scratch, program: int, first: int, last: int, entered: bool) -> int:
    """Return the event of a group whose face the crossing has: of the first leaf that turns the body.

    A wall that several leaves share has the face of one that is not cut away there. Relies on the group's leaves having
    turned, and leaves them so.
    """
    event, gates, best = scratch.event, scratch.counts, -1
    for i in range(first, last):
        leaf, on = event[EVENT * i + LEAF], event[EVENT * i + ON] == 1
        fits = on == (entered == (sense_of(geometry, program, leaf) > 0))
        if fits and leaf_decides(geometry, gates, program, leaf, on):
            event[EVENT * i + ON] += _DECIDES
    for i in range(first, last):
        turn_leaf(geometry, gates, program, event[EVENT * i + LEAF], event[EVENT * i + ON] & 1 == 0)
    for i in range(first, last):
        leaf, on = event[EVENT * i + LEAF], event[EVENT * i + ON] & 1 == 1
        if best < 0 and event[EVENT * i + ON] >= _DECIDES and leaf_decides(geometry, gates, program, leaf, not on):
            best = i
    for i in range(first, last):
        event[EVENT * i + ON] &= 1
        turn_leaf(geometry, gates, program, event[EVENT * i + LEAF], event[EVENT * i + ON] == 1)
    return max(best, first)


@inline
def _report(
    geometry: Geometry, scratch: Scratch, program: int, first: int, last: int, start: int, entered: bool, n: int
) -> int:
    """Write crossing n for the group of events first..last; return 1, or 0 for the crossing on which the ray starts."""
    event, best = scratch.event, first
    if last - first > 1:
        best = deciding_event(geometry, scratch, program, first, last, entered)
    t, place = scratch.time[TIME * best], event[EVENT * best + PLACE]
    sense = sense_of(geometry, program, event[EVENT * best + LEAF])
    put_crossing(scratch, n, t, place, sense, 1 if entered else 0)
    return 0 if t == 0.0 and place_face(geometry, place)[0] == start else 1


@helper
def inside_program_at(geometry: Geometry, scratch: Scratch, program: int, ray: Ray, t: float) -> tuple[bool, bool]:
    """Return (point at t is in a region whose leaves are closed, doubtful)."""
    # Only leaves whose box holds the point matter
    ray = with_limits(ray, t, t)
    nearness = nearness_of(geometry, table.PROGRAM_LIMITS, program, ray, span_inverse(ray))
    events, unsure = gather_events(geometry, scratch, program, ray)
    hold_program(geometry, scratch.counts, program)
    for sweep in range(2):  # the first turns the leaves, the second undoes it
        for i in range(events):
            if poll_halt(geometry, i):
                break
            enters, end = scratch.event[EVENT * i + ON] == 1, scratch.time[TIME * i]
            unsure |= may_swap(end, t, nearness)
            # Leaves are closed: one that is entered at t holds the point, and so does one that is left there
            if end < t or (enters and end == t):
                turn_leaf(geometry, scratch.counts, program, scratch.event[EVENT * i + LEAF], enters == (sweep == 0))
        if sweep == 0:
            inside = root_value(geometry, scratch.counts, program)
    return inside, unsure


@inline
def put_crossing(scratch: Scratch, n: int, t: float, place: int, sense: int, enters: int) -> None:
    """Write crossing n of a body into scratch."""
    at = EVENT * n
    scratch.time[TIME * n + CROSS_T] = t
    scratch.event[at + CROSS_PLACE], scratch.event[at + CROSS_SENSE], scratch.event[at + CROSS_ENTERS] = (
        place, sense, enters,
    )  # fmt: skip


@inline
def read_crossing(scratch: Scratch, n: int) -> tuple[float, int, int, bool]:
    """Return (t, place, sense of its leaf, the ray enters the body) of crossing n."""
    t, event, at = scratch.time[TIME * n + CROSS_T], scratch.event, EVENT * n
    place, sense = whole(event[at + CROSS_PLACE]), whole(event[at + CROSS_SENSE])
    return t, place, sense, event[at + CROSS_ENTERS] == 1


@inline
def surface_of(geometry: Geometry, place: int, t: float) -> int:
    """Return the surface of a place if t = 0, else -1: only at t = 0 can it be the surface on which the ray starts."""
    return place_face(geometry, place)[0] if t == 0.0 else whole(-1)
