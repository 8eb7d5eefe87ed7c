"""Boolean bodies of a few leaves in the lanes of a packet.

It follows the rules of the sweep for single rays (body/boolean.py) with another algorithm, for all lanes at once: every
leaf gives its spans; then each lane steps from one span end to the next and evaluates the program there, all ends at
equal t together, until its value changes. It sorts nothing and branches on no lane, hence the second algorithm.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..._jit.decorators import choose, helper, inline
from .. import tables as table
from ..body.hit import Hit
from ..bvh.walk import LeafItem
from ..programs import cell_of_leaf, gates_of, leaves_of, root_of, rows_of_leaves
from ..surface.interval import Nearness, has_begun, has_not_ended, is_open, lengths_of
from ..tables import Floats, Geometry, Ints, integer, whole
from .cells import IN, LEAF, OUT, PLACE_OF_IN, PLACE_OF_OUT, SPAN, face_lanes, put_cell_spans
from .lanes import (
    DOUBT,
    ENDS,
    FOUND,
    INSIDE,
    LANES,
    LATEST,
    NARROW_IN,
    NARROW_OUT,
    NEW_ENTERS,
    NEW_PLACE,
    NEW_SENSE,
    NEXT,
    NOW,
    OFF,
    SEEKS,
    T_MAX,
    T_MIN,
    WITHIN,
    eights,
    keep_nearer,
    lane_nearness,
)

MOST = 16
"""Most leaves, and most gates, of a body that is traced in lanes."""

LEAVES_SIZE = MOST * LEAF
TRUTHS_SIZE = MOST * LANES


class BooleanLanes(NamedTuple):
    """The lanes, and the memory for a Boolean body in them."""

    lanes: Floats
    leaves: Floats  # spans of a body's leaves
    truths: Floats  # true inputs of its gates
    spans: Ints  # largest number of spans of each leaf in a lane


@inline
def fits_in_lanes(geometry: Geometry, program: int) -> bool:
    """True if a body is small enough to be traced in lanes (`MOST`)."""
    leaves, gates = leaves_of(geometry, program), gates_of(geometry, program)
    return leaves[1] - leaves[0] <= MOST and gates[1] - gates[0] <= MOST


@helper
def _leaf_spans(
    geometry: Geometry, lanes: Floats, leaves: Floats, at: int, cell: int, narrows: bool, first: int, last: int
) -> tuple[int, int]:
    """Write a leaf's spans to its rows from leaves[at]: (most spans of a lane, number of lanes that still seek).

    With `narrows` the body lies within the leaf: a lane then seeks within the leaf's spans only.
    """
    if face_lanes(geometry, lanes, cell, first, last) == 0:
        return 0, 0
    several = put_cell_spans(geometry, lanes, leaves, at, cell, True, first, last)
    near = narrow_lanes(lanes, leaves, at, narrows, first, last)
    return 0 if near == 0 else (2 if several > 0 else 1), near


@helper
def narrow_lanes(lanes: Floats, leaves: Floats, at: int, narrows: bool, first: int, last: int) -> int:
    """Return how many seeking lanes may be within a leaf, by its spans at leaves[at:].

    With `narrows` the body lies within the leaf: a lane then seeks within the leaf's spans only.
    """
    first, last = eights(first, last)
    row, second = np.uint64(at), np.uint64(at + SPAN)
    near = 0
    for i in range(first, last):
        begin = min(leaves[row + IN + i], leaves[second + IN + i])
        end = max(leaves[row + OUT + i], leaves[second + OUT + i])
        low, high = max(lanes[NARROW_IN + i], begin), min(lanes[NARROW_OUT + i], end)
        off = lanes[OFF + i]
        counts = (low <= high + off) & (lanes[SEEKS + i] == 1.0)
        near += 1 if counts else 0
        lanes[FOUND + i] = low
        lanes[NEXT + i] = high
        # Both are 0 if the ray leaves the leaf on the surface on which it starts; other ends there are doubtful already
        close = (abs(high - low) <= off) & ((low != 0.0) | (high != 0.0))
        lanes[DOUBT + i] = choose(narrows & close & counts, 1.0, lanes[DOUBT + i])
    if narrows:
        for i in range(first, last):
            lanes[SEEKS + i] = choose(is_open(lanes[FOUND + i], lanes[NEXT + i]), lanes[SEEKS + i], 0.0)
            lanes[NARROW_IN + i], lanes[NARROW_OUT + i] = lanes[FOUND + i], lanes[NEXT + i]
    return near


@helper
def _count_span(
    lanes: Floats, leaves: Floats, truths: Floats, at: int, gate: int, change: float, first: int, last: int
) -> None:
    """Add `change` to a gate where NOW is in a span; lower NEXT to the span's next end beyond NOW."""
    first, last = eights(first, last)
    row, counter = np.uint64(at), np.uint64(gate * LANES)
    for i in range(first, last):
        now, begin, end = lanes[NOW + i], leaves[row + IN + i], leaves[row + OUT + i]
        truths[counter + i] += choose((begin <= now) & (now < end), change, 0.0)
        later = choose(begin > now, begin, choose(end > now, end, math.inf))
        # Ends are not sorted: with at most `MOST` leaves, each step reads them all, without branches, for all lanes at
        # once
        lanes[NEXT + i] = min(lanes[NEXT + i], later)


@helper
def _reset(geometry: Geometry, lanes: Floats, truths: Floats, program: int, first: int, last: int) -> None:
    """Start a step: every leaf is outside, and no end is next."""
    reset_gates(geometry, truths, program, first, last)
    first, last = eights(first, last)
    for i in range(first, last):
        lanes[NEXT + i] = math.inf


@helper
def reset_gates(geometry: Geometry, truths: Floats, program: int, first: int, last: int) -> None:
    """Set the true inputs of every gate to their values while all leaves are outside."""
    first, last = eights(first, last)
    begin, end = gates_of(geometry, program)
    for gate in range(begin, end):
        start, counter = float(integer(geometry, table.GATE_START, gate)), np.uint64((gate - begin) * LANES)
        for i in range(first, last):
            truths[counter + i] = start


@helper
def _pass_on(
    truths: Floats, gate: int, parent: int, need: float, start: float, sign: float, first: int, last: int
) -> None:
    """Count a change of a gate's value, if any, in its parent."""
    first, last = eights(first, last)
    counter, above = np.uint64(gate * LANES), np.uint64(parent * LANES)
    for i in range(first, last):
        changed = (truths[counter + i] >= need) != (start >= need)
        truths[above + i] += choose(changed, sign, 0.0)


@helper
def settle_gates(geometry: Geometry, truths: Floats, program: int, first: int, last: int) -> None:
    """Propagate changes from the leaves' gates up to the root; relies on parents standing before their children."""
    begin, end = gates_of(geometry, program)
    for gate in range(end - 1, begin, -1):
        need, start = integer(geometry, table.GATE_NEED, gate), integer(geometry, table.GATE_START, gate)
        # A gate that was true outside can only become false, which takes one true input from its parent
        falls = (start >= need) != (integer(geometry, table.GATE_NEGATED, gate) == 1)
        parent = integer(geometry, table.GATE_PARENT, gate) - begin
        _pass_on(truths, gate - begin, parent, float(need), float(start), -1.0 if falls else 1.0, first, last)


@helper
def _advance(
    geometry: Geometry, lanes: Floats, truths: Floats, program: int, starts: bool, first: int, last: int
) -> int:
    """Record where the value has changed, and step to the next end; return how many lanes still seek.

    Keeps INSIDE the value just after NOW. A lane stops seeking at its crossing, or beyond its interval or nearest hit.
    """
    first, last = eights(first, last)
    root = root_of(geometry, program)
    need, negated = float(integer(geometry, table.GATE_NEED, root)), integer(geometry, table.GATE_NEGATED, root) == 1
    seeking = 0
    for i in range(first, last):
        truth = 1.0 if (truths[i] >= need) != negated else 0.0
        turned = (truth != lanes[INSIDE + i]) & (lanes[SEEKS + i] == 1.0) & (not starts)
        lanes[FOUND + i] = choose(turned, lanes[NOW + i], lanes[FOUND + i])
        lanes[NEW_ENTERS + i] = choose(turned, truth, lanes[NEW_ENTERS + i])
        lanes[INSIDE + i] = truth
        t, off = lanes[NEXT + i], lanes[OFF + i]
        sought = lanes[SEEKS + i] == 1.0
        # The next end is so near that rounding may have swapped the two
        lanes[DOUBT + i] = choose(sought & (t - lanes[NOW + i] <= off), 1.0, lanes[DOUBT + i])
        lanes[LATEST + i] = choose(sought, lanes[NOW + i], lanes[LATEST + i])
        lanes[ENDS + i] += choose(sought & (not starts), 1.0, 0.0)
        lanes[NOW + i] = t
        on = sought & ~turned
        seeks = on & has_not_ended(t, lanes[T_MAX + i]) & (t <= lanes[WITHIN + i] + off)
        lanes[SEEKS + i] = 1.0 if seeks else 0.0
        seeking += 1 if seeks else 0
    return seeking


@helper
def _choose_face(lanes: Floats, leaves: Floats, at: int, sense: float, first: int, last: int) -> None:
    """Report a span end's face if the end is the crossing found and turns the way the body does; count it in NEXT.

    Callers go from the last leaf to the first, so that the face of the first is reported.
    """
    first, last = eights(first, last)
    row = np.uint64(at)
    for i in range(first, last):
        begin, end = leaves[row + IN + i], leaves[row + OUT + i]
        latest, t_min = lanes[LATEST + i], lanes[T_MIN + i]
        # Steps less ends: 0 unless two ends fell into one step, whose face rounding may then have decided
        lanes[ENDS + i] -= choose(has_begun(begin, t_min) & (begin <= latest), 1.0, 0.0)
        lanes[ENDS + i] -= choose(has_begun(end, t_min) & (end <= latest), 1.0, 0.0)
        t, rises = lanes[FOUND + i], (lanes[NEW_ENTERS + i] == 1.0) == (sense > 0.0)
        shown = choose(rises, begin, end)
        place = choose(rises, leaves[row + PLACE_OF_IN + i], leaves[row + PLACE_OF_OUT + i])
        shows = shown == t
        lanes[NEW_PLACE + i] = choose(shows, place, lanes[NEW_PLACE + i])
        lanes[NEW_SENSE + i] = choose(shows, sense, lanes[NEW_SENSE + i])
        lanes[NEXT + i] += choose(shows & (t < math.inf), 1.0, 0.0)


@helper
def _gate_values(geometry: Geometry, memory: BooleanLanes, program: int, lane: int, after: bool) -> int:
    """Return the values of the gates just before or after FOUND in a lane: bit k is that of gate k."""
    lanes, leaves, truths, spans = memory
    i, group, values = np.uint64(lane), lane & 56, whole(0)
    (begin, end), row = leaves_of(geometry, program), rows_of_leaves(geometry, program)
    first, last = gates_of(geometry, program)
    reset_gates(geometry, truths, program, group, group + 8)
    t = lanes[FOUND + i]
    for leaf in range(begin, end):
        change = -1.0 if integer(geometry, table.LEAF_NEGATED, leaf + row) == 1 else 1.0
        counter = np.uint64((integer(geometry, table.LEAF_GATE, leaf + row) - first) * LANES)
        for s in range(spans[leaf - begin]):
            at = np.uint64((leaf - begin) * LEAF + s * SPAN)
            low, high = leaves[at + IN + i], leaves[at + OUT + i]
            if (low <= t) & (t < high) if after else (low < t) & (t <= high):
                truths[counter + i] += change
    settle_gates(geometry, truths, program, group, group + 8)
    for gate in range(first, last):
        truth = truths[np.uint64((gate - first) * LANES) + i] >= float(integer(geometry, table.GATE_NEED, gate))
        values |= whole(1 if truth else 0) << (gate - first)
    return values


@helper
def _decide_face(geometry: Geometry, memory: BooleanLanes, program: int, lane: int) -> None:
    """Report in a lane the face of the first leaf that turns the body there, as `leaf_decides` for single rays."""
    lanes, leaves, _, spans = memory
    before = _gate_values(geometry, memory, program, lane, False)
    after = _gate_values(geometry, memory, program, lane, True)
    i, enters = np.uint64(lane), lanes[NEW_ENTERS + np.uint64(lane)] == 1.0
    (begin, end), row, root = (
        leaves_of(geometry, program),
        rows_of_leaves(geometry, program),
        root_of(geometry, program),
    )
    for leaf in range(end - 1, begin - 1, -1):
        sense = integer(geometry, table.LEAF_SENSE, leaf + row)
        rises = enters == (sense > 0)
        gate, decides = integer(geometry, table.LEAF_GATE, leaf + row), True
        truth = rises != (integer(geometry, table.LEAF_NEGATED, leaf + row) == 1)
        while gate >= 0:
            bit, value = gate - root, whole(1 if truth else 0)
            decides &= (((after >> bit) & 1) == value) & (((before >> bit) & 1) != value)
            truth = truth != (integer(geometry, table.GATE_NEGATED, gate) == 1)
            gate = integer(geometry, table.GATE_PARENT, gate)
        for s in range(spans[leaf - begin] if decides else 0):
            at = np.uint64((leaf - begin) * LEAF + s * SPAN)
            end_at, place_at = (IN, PLACE_OF_IN) if rises else (OUT, PLACE_OF_OUT)
            if leaves[at + end_at + i] == lanes[FOUND + i]:
                lanes[NEW_PLACE + i], lanes[NEW_SENSE + i] = leaves[at + place_at + i], float(sense)


@helper
def _begin(lanes: Floats, lengths: Nearness, first: int, last: int) -> None:
    """`begin_lane` for all lanes."""
    first, last = eights(first, last)
    for i in range(first, last):
        begin_lane(lanes, i, lane_nearness(lanes, i, lengths))


@inline
def begin_lane(lanes: Floats, i: Any, nearness: Nearness) -> None:
    """Set a lane's error bound and the interval to search, before it meets the leaves of a body."""
    off, far = nearness
    lanes[OFF + i] = off
    lanes[DOUBT + i] = choose(far < 0.0, 1.0, lanes[DOUBT + i])
    lanes[NARROW_IN + i] = lanes[T_MIN + i]
    lanes[NARROW_OUT + i] = min(lanes[T_MAX + i], lanes[WITHIN + i] + off)  # as far as a tie with the nearest hit
    lanes[SEEKS + i] = 1.0 if is_open(lanes[NARROW_IN + i], lanes[NARROW_OUT + i]) else 0.0


@inline
def lies_within(geometry: Geometry, program: int) -> bool:
    """True if a body is true only where all inputs of its root are: the root is an intersection."""
    root = root_of(geometry, program)
    return integer(geometry, table.GATE_NEED, root) > 1 and integer(geometry, table.GATE_NEGATED, root) == 0


@helper
def leaves_of_lanes(geometry: Geometry, memory: BooleanLanes, program: int, first: int, last: int) -> int:
    """Compute the spans of all leaves, first of those within which the body lies; return how many lanes still seek."""
    lanes, leaves, _, spans = memory
    _begin(lanes, lengths_of(geometry, table.PROGRAM_LIMITS, program), first, last)
    root = root_of(geometry, program)
    within = lies_within(geometry, program)
    (begin, end), row = leaves_of(geometry, program), rows_of_leaves(geometry, program)
    seeking = 1
    for sweep in range(2):  # the first over leaves that narrow the search, the second over the others
        for leaf in range(begin, end):
            narrows = within and integer(geometry, table.LEAF_GATE, leaf + row) == root
            narrows &= integer(geometry, table.LEAF_NEGATED, leaf + row) == 0
            if narrows != (sweep == 0):
                continue
            k, cell = leaf - begin, cell_of_leaf(geometry, leaf)
            spans[k], near = _leaf_spans(geometry, lanes, leaves, k * LEAF, cell, narrows, first, last)
            seeking = near if narrows else seeking
            if seeking == 0:
                return 0
    return seeking


@helper
def region_lanes(geometry: Geometry, memory: BooleanLanes, region: LeafItem, first: int, last: int) -> None:
    """Find the first crossing of a Boolean body; each lane keeps it if it is the nearer.

    The result is that of single rays, or in doubt. Relies on `fits_in_lanes`: at most `MOST` leaves and gates.
    """
    program = region.index
    if leaves_of_lanes(geometry, memory, program, first, last) == 0:
        return
    sweep_lanes(geometry, memory, program, first, last)
    first, last = eights(first, last)
    lanes, lengths = memory.lanes, lengths_of(geometry, table.PROGRAM_LIMITS, program)
    for i in range(first, last):
        t, unsure = lanes[FOUND + i], unsure_of_sweep(lanes, i, lane_nearness(lanes, i, lengths))
        place, enters = lanes[NEW_PLACE + i], lanes[NEW_ENTERS + i] == 1.0
        keep_nearer(
            lanes, i, Hit(t, region.body, region.entry, place, lanes[NEW_SENSE + i], enters, lanes[OFF + i], unsure)
        )


@inline
def unsure_of_sweep(lanes: Floats, i: Any, nearness: Nearness) -> bool:
    """True if rounding might change the crossing that `sweep_lanes` found in a lane, besides the lane's DOUBT.

    Ends at equal t are one step: the crossing is doubtful if the lane passed more ends than it made steps.
    """
    t = lanes[FOUND + i]
    return ((abs(t) > nearness.far) & (abs(t) < math.inf)) | (lanes[ENDS + i] != 0.0)


@helper
def sweep_lanes(geometry: Geometry, memory: BooleanLanes, program: int, first: int, last: int) -> None:
    """Find the first crossing of a body from its leaves' spans: t in FOUND, inf for none; the rest in the NEW_ rows."""
    lanes, leaves, truths, spans = memory
    first, last = eights(first, last)
    for i in range(first, last):
        lanes[FOUND + i], lanes[NOW + i] = math.inf, lanes[T_MIN + i]
        lanes[LATEST + i], lanes[ENDS + i] = lanes[T_MIN + i], 0.0
    (begin, end), row = leaves_of(geometry, program), rows_of_leaves(geometry, program)
    root = root_of(geometry, program)
    starts, seeking = True, 1  # the first step finds the value at t_min only
    while seeking > 0:
        _reset(geometry, lanes, truths, program, first, last)
        for leaf in range(begin, end):
            k = leaf - begin
            change = -1.0 if integer(geometry, table.LEAF_NEGATED, leaf + row) == 1 else 1.0
            gate = integer(geometry, table.LEAF_GATE, leaf + row) - root
            for s in range(spans[k]):
                _count_span(lanes, leaves, truths, k * LEAF + s * SPAN, gate, change, first, last)
        settle_gates(geometry, truths, program, first, last)
        seeking = _advance(geometry, lanes, truths, program, starts, first, last)
        starts = False
    for i in range(first, last):
        lanes[NEXT + i] = 0.0
    for leaf in range(end - 1, begin - 1, -1):
        k, sense = leaf - begin, float(integer(geometry, table.LEAF_SENSE, leaf + row))
        for s in range(spans[k]):
            _choose_face(lanes, leaves, k * LEAF + s * SPAN, sense, first, last)
    for i in range(first, last):
        if lanes[NEXT + i] > 1.0:  # several leaves have an end there
            _decide_face(geometry, memory, program, whole(i))
