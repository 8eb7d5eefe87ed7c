"""Boolean bodies of one form, another in each lane, for rays in no order, each queued with a body that it may meet.

Two bodies are of one form if they differ in the numbers of their surfaces only. So the steps of the lanes are read from
one of them, the model, and the records of planes and quadrics are gathered, row by row. From there on the lanes go
through the formulas of packets (cells.py, booleans.py), to the same bits.

User: streams (stream.py) of rays in no order; factor over one ray at a time in them: 1.5 to 1.7 on 1,000 and 10,000
bored blocks (processor time, one thread, 2026-11-28).
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..._jit.decorators import allocator, helper, inline
from .. import tables as table
from ..body.cell import NO_PLACE, quadric_place
from ..body.hit import Hit
from ..bvh.culling import bit_count, numbers_in_lanes, records_in_lanes
from ..bvh.culling_constants import END, END_LEAST
from ..faces import cell_side, plane_side
from ..programs import cell_of_leaf, gates_of, leaves_of, root_of, rows_of_leaves
from ..surface.doubt import STARTING
from ..surface.interval import Nearness, lengths_of, may_overlap, ray_size, ray_unit
from ..surface.plane import PlaneLimits, PlaneRecord
from ..surface.quadric import (
    QuadricLimits,
    QuadricRecord,
    SphereRecord,
    careful_quadratic,
    roots_of_terms,
    sphere_roots,
)
from ..tables import (
    ANCHOR_SIZE,
    FORM_SIZE,
    PLANE_SIZE,
    SPHERE,
    SPHERE_SIZE,
    Floats,
    Geometry,
    Ints,
    integer,
    length,
    real,
    whole,
)
from .booleans import (
    LEAVES_SIZE,
    MOST,
    TRUTHS_SIZE,
    BooleanLanes,
    begin_lane,
    fits_in_lanes,
    lies_within,
    narrow_lanes,
    sweep_lanes,
    unsure_of_sweep,
)
from .cells import (
    LEAF,
    SPAN,
    cut_lane,
    lane_terms,
    plane_of_lane,
    put_careful_plane,
    put_lane_spans,
    put_roots,
    put_terms,
    put_whole_lane,
    quadric_of_lane,
)
from .lanes import (
    DOUBT,
    DX,
    DY,
    DZ,
    FLAG,
    FOUND,
    INVERSE,
    LANES,
    NARROW_IN,
    NARROW_OUT,
    NEW_ENTERS,
    NEW_PLACE,
    NEW_SENSE,
    OFF,
    ORIGIN_SIZE,
    OWN,
    OX,
    OY,
    OZ,
    SEEKS,
    SIZE,
    START,
    START_SIZE,
    T_IN,
    T_MAX,
    T_MIN,
    T_OUT,
    UNIT,
    UNSURE,
    WITHIN,
    eights,
    lane_line,
    lane_nearness,
)

FORMS = 8
"""Most forms that a thread traces in lanes: the first that it meets."""
EVERY = 1 << 30
"""As `most` of `new_bodies`: cache the forms of all programs."""
FACES = 64
"""Stride of a body's face numbers: leaf k has its planes from 64 k on, and its quadric as the last, 64 k + 63."""

# Rows of lanes behind those of packets: 24 numbers of a record, its limits, its surface; limits of a cell and a body
_ROWS_AT = (SIZE + LANES - 1) // LANES * LANES
(
    R0, R1, R2, R3, R4, R5, R6, R7, R8, R9, R10, R11, R12, R13, R14, R15, R16, R17, R18,
    _R19, _R20, _R21, _R22, _R23, LIMIT, OTHER_LIMIT, SURFACE, CELL_OFF, CELL_FAR, BODY_OFF, BODY_FAR,
) = (np.uint64(row) for row in range(_ROWS_AT, _ROWS_AT + 31 * LANES, LANES))  # fmt: skip
_ALL_ROWS = _ROWS_AT + 31 * LANES


# Sections of `BodyQueue.numbers`, 64 each; behind them the forms' counts, their models, and the number of forms
PROGRAM, CELL, AT, WAITING = 0, LANES, 2 * LANES, 3 * LANES
ENTRIES = WAITING + FORMS * LANES
COUNTS = ENTRIES + FORMS * LANES
MODELS = COUNTS + FORMS
FORM_COUNT = MODELS + FORMS


class BodyQueue(NamedTuple):
    """Queues of rays with a Boolean body each, one for each form, and the lanes in which they are intersected."""

    lanes: Floats
    leaves: Floats
    truths: Floats
    spans: Ints
    numbers: Any  # int64: see `PROGRAM`
    forms: Ints  # cache of `form_of`: 256 tag + 2 + form, with form -1 for none; or 0


@allocator
def new_bodies(geometry: Geometry, most: int) -> BodyQueue:
    """Return memory for one thread, with a cache for the forms of `most` programs, or of all if these are fewer."""
    programs, size = length(geometry, table.PROGRAM_LEAF), 1
    while size < min(programs, most):
        size *= 2
    room = np.zeros(_ALL_ROWS + 8)
    first = -(room.ctypes.data >> 3) & 7
    return BodyQueue(
        room[first : first + _ALL_ROWS], np.empty(LEAVES_SIZE), np.empty(TRUTHS_SIZE), np.zeros(MOST, np.int32),
        np.zeros(FORM_COUNT + 1, np.int64), np.zeros(size, np.int32),
    )  # fmt: skip


@inline
def _same(geometry: Geometry, numbers: int, a: int, b: int) -> bool:
    """True if elements a and b of a table of integers are equal."""
    return integer(geometry, numbers, a) == integer(geometry, numbers, b)


@inline
def _same_faces(geometry: Geometry, a: int, b: int) -> bool:
    """True if two cells have equally many planes, on the same sides, and the same kind of quadric."""
    first, other = integer(geometry, table.CELL_FIRST, a), integer(geometry, table.CELL_FIRST, b)
    count = integer(geometry, table.CELL_FIRST, a + 1) - first
    same = count < FACES and integer(geometry, table.CELL_FIRST, b + 1) - other == count
    for k in range(count if same else 0):
        same = same and plane_side(geometry, first + k) == plane_side(geometry, other + k)
    p, q = integer(geometry, table.CELL_QUADRIC, a), integer(geometry, table.CELL_QUADRIC, b)
    if p < 0 or q < 0:
        return same and p < 0 and q < 0
    return same and _same(geometry, table.SURFACE_KIND, p, q) and cell_side(geometry, a) == cell_side(geometry, b)


@inline
def _same_cells(geometry: Geometry, leaf: int, other: int, leaves: int) -> bool:
    """True if the cells of `leaves` leaves, from `leaf` and from `other` on, differ in their surfaces' numbers only."""
    for k in range(leaves):
        if not _same_faces(geometry, cell_of_leaf(geometry, leaf + k), cell_of_leaf(geometry, other + k)):
            return False
    return True


@helper
def _of_one_form(geometry: Geometry, p: int, q: int) -> bool:
    """True if two programs differ in the numbers of their surfaces only."""
    (leaf, end), (other, its_end) = leaves_of(geometry, p), leaves_of(geometry, q)
    leaves, gates = end - leaf, gates_of(geometry, p)
    gate, its = gates[0], root_of(geometry, q)
    if p != q and gate == its:  # translated copies: they share the rows of gates and leaves
        return _same_cells(geometry, leaf, other, leaves)
    if its_end - other != leaves or gates_of(geometry, q)[1] - its != gates[1] - gate:
        return False
    row, its_row = rows_of_leaves(geometry, p), rows_of_leaves(geometry, q)
    for k in range(gates[1] - gate):
        a, b = gate + k, its + k
        same = _same(geometry, table.GATE_NEED, a, b) and _same(geometry, table.GATE_NEGATED, a, b)
        same = same and _same(geometry, table.GATE_START, a, b)
        above, below = integer(geometry, table.GATE_PARENT, a), integer(geometry, table.GATE_PARENT, b)
        if not same or (above < 0) != (below < 0) or (above >= 0 and above - gate != below - its):
            return False
    for k in range(leaves):
        a, b = leaf + k + row, other + k + its_row
        same = _same(geometry, table.LEAF_NEGATED, a, b) and _same(geometry, table.LEAF_SENSE, a, b)
        same = same and integer(geometry, table.LEAF_GATE, a) - gate == integer(geometry, table.LEAF_GATE, b) - its
        if not same:
            return False
    return _same_cells(geometry, leaf, other, leaves)


@helper
def _find_form(geometry: Geometry, bodies: BodyQueue, program: int) -> int:
    """Return the form of a program that is not in the cache, or -1; a new form gets the program as its model."""
    numbers, cached = bodies.numbers, bodies.numbers[FORM_COUNT]
    if fits_in_lanes(geometry, program):
        for form in range(cached):
            if _of_one_form(geometry, numbers[MODELS + form], program):
                return form
        if cached < FORMS and _of_one_form(geometry, program, program):
            numbers[MODELS + cached] = program
            numbers[FORM_COUNT] += 1
            return cached
    return -1


@inline
def form_of(geometry: Geometry, bodies: BodyQueue, program: int) -> int:
    """Return the form of a program, or -1 if it is not traced in lanes.

    The last bits of its number give the form's place in the cache, the others are the tag. A program with the same
    place and another tag replaces it.
    """
    last = len(bodies.forms) - 1
    place, tag = program & last, program >> bit_count(last)
    cached = whole(bodies.forms[place])
    if cached >> 8 == tag and cached & 255 != 0:
        return (cached & 255) - 2
    form = _find_form(geometry, bodies, program)
    bodies.forms[place] = tag << 8 | form + 2
    return form


@inline
def put_body(bodies: BodyQueue, form: int, ray: int, entry: int) -> bool:
    """Queue a ray that may meet a body of a form; True if the queue of the form is full now."""
    numbers, count = bodies.numbers, bodies.numbers[COUNTS + form]
    numbers[WAITING + LANES * form + count], numbers[ENTRIES + LANES * form + count] = ray, entry
    numbers[COUNTS + form] = count + 1
    return count + 1 == LANES


@inline
def count_forms(bodies: BodyQueue) -> int:
    """Return the number of forms."""
    return bodies.numbers[FORM_COUNT]


@inline
def empty_queue(bodies: BodyQueue, form: int) -> int:
    """Empty the queue of a form; return the number of rays that it held."""
    count = bodies.numbers[COUNTS + form]
    bodies.numbers[COUNTS + form] = 0
    return count


@inline
def queue_body(bodies: BodyQueue, form: int, k: int) -> tuple[int, int]:
    """Return (ray, entry) of element k of the queue of a form."""
    return bodies.numbers[WAITING + LANES * form + k], bodies.numbers[ENTRIES + LANES * form + k]


# Planes and quadrics of cells, another in each lane: their records are gathered, row by row


@inline
def cell_limits(lanes: Floats, i: Any) -> Nearness:
    """Return the limits, as lengths, of the cell in a lane."""
    return Nearness(lanes[CELL_OFF + i], lanes[CELL_FAR + i])


@helper
def cut_planes(geometry: Geometry, bodies: BodyQueue, number: int, side: int, place: int, count: int) -> None:
    """Cut the lanes by plane `number` of their cells; `place` is its number among the body's faces (`FACES`)."""
    lanes, numbers = bodies.lanes, bodies.numbers
    planes = geometry.places[table.PLANES]
    for k in range(count):
        lane = np.uint64(k)
        first = integer(geometry, table.CELL_FIRST, numbers[CELL + k])
        surface = integer(geometry, table.PLANE_SURFACE, first + number)
        row = integer(geometry, table.SURFACE_ROW, surface)
        numbers[AT + k], lanes[SURFACE + lane] = planes + PLANE_SIZE * row, surface
        lanes[LIMIT + lane] = real(geometry, table.PLANE_LIMITS, 2 * row)
        lanes[OTHER_LIMIT + lane] = real(geometry, table.PLANE_LIMITS, 2 * row + 1)
    for k in range(0, count, 8):
        numbers_in_lanes(geometry.floats, numbers, AT + k, lanes, R0 + np.uint64(k))
    first, last = eights(0, count)
    again = 0
    for i in range(first, last):
        again += plane_of_lane(lanes, i, lane_line(lanes, i), _plane(lanes, i), _plane_limits(lanes, i))
    if again > 0:
        for i in range(first, last):
            if lanes[FLAG + i] == 1.0:
                put_careful_plane(lanes, i, _plane(lanes, i), _plane_limits(lanes, i))
    for i in range(first, last):
        cut_lane(lanes, i, cell_limits(lanes, i), lanes[SURFACE + i], side > 0, place, False)
        lanes[OWN + i] = float(place) if lanes[START + i] == lanes[SURFACE + i] else lanes[OWN + i]


@inline
def _plane(lanes: Floats, i: Any) -> PlaneRecord:
    """Return the plane in a lane."""
    return PlaneRecord(
        lanes[R0 + i], lanes[R1 + i], lanes[R2 + i], lanes[R3 + i], lanes[R4 + i], lanes[R5 + i], lanes[R6 + i]
    )  # fmt: skip


@inline
def _plane_limits(lanes: Floats, i: Any) -> PlaneLimits:
    """Return the limits of the plane in a lane."""
    return PlaneLimits(lanes[LIMIT + i], lanes[OTHER_LIMIT + i])


@helper
def meet_spheres(geometry: Geometry, bodies: BodyQueue, count: int) -> None:
    """Write the roots of the lanes' spheres to their rows (`put_roots`)."""
    lanes, numbers, spheres = bodies.lanes, bodies.numbers, geometry.places[table.SPHERES]
    for k in range(count):
        surface = integer(geometry, table.CELL_QUADRIC, numbers[CELL + k])
        numbers[AT + k] = spheres + SPHERE_SIZE * integer(geometry, table.SURFACE_ROW, surface)
        lanes[SURFACE + np.uint64(k)] = surface
    for k in range(0, count, 8):
        numbers_in_lanes(geometry.floats, numbers, AT + k, lanes, R0 + np.uint64(k))
    first, last = eights(0, count)
    for i in range(first, last):
        sphere, starts = SphereRecord(lanes[R0 + i], lanes[R1 + i], lanes[R2 + i], lanes[R3 + i]), _starts(lanes, i)
        put_roots(lanes, i, sphere_roots(sphere, lane_line(lanes, i), lanes[INVERSE + i], starts))


@inline
def _starts(lanes: Floats, i: Any) -> bool:
    """True if the ray of a lane starts on the surface in the lane."""
    return lanes[START + i] == lanes[SURFACE + i]


@helper
def meet_quadrics(geometry: Geometry, bodies: BodyQueue, count: int) -> None:
    """Write the roots of the lanes' quadrics to their rows (`put_roots`)."""
    lanes, numbers = bodies.lanes, bodies.numbers
    quadrics = geometry.places[table.QUADRICS]
    forms = geometry.places[table.QUADRIC_FORMS]
    for k in range(count):
        lane, surface = np.uint64(k), integer(geometry, table.CELL_QUADRIC, numbers[CELL + k])
        row = integer(geometry, table.SURFACE_ROW, surface)
        numbers[AT + k], lanes[SURFACE + lane] = quadrics + ANCHOR_SIZE * row, surface
    for k in range(0, count, 8):
        numbers_in_lanes(geometry.floats, numbers, AT + k, lanes, R0 + np.uint64(k))
    for k in range(count):  # the row of the form stands behind the anchor, where the form itself is loaded next
        lane = np.uint64(k)
        form = whole(lanes[R3 + lane])
        numbers[AT + k] = forms + FORM_SIZE * form
        lanes[LIMIT + lane] = real(geometry, table.QUADRIC_LIMITS, 2 * form)
        lanes[OTHER_LIMIT + lane] = real(geometry, table.QUADRIC_LIMITS, 2 * form + 1)
    for part in range(2):
        for k in range(0, count, 8):
            numbers_in_lanes(geometry.floats, numbers, AT + k, lanes, R3 + np.uint64(8 * LANES * part + k))
        for k in range(count):
            numbers[AT + k] += 8
    first, last = eights(0, count)
    again = 0
    for i in range(first, last):
        again += quadric_of_lane(lanes, i, lane_line(lanes, i), _quadric(lanes, i), lanes[SURFACE + i])
    if again > 0:
        for i in range(first, last):
            terms = lane_terms(lanes, i)
            if terms.cancels:
                put_terms(lanes, i, careful_quadratic(_quadric(lanes, i), lane_line(lanes, i), terms))
    for i in range(first, last):
        its = QuadricLimits(lanes[LIMIT + i], lanes[OTHER_LIMIT + i])
        put_roots(lanes, i, roots_of_terms(lane_terms(lanes, i), _starts(lanes, i), lanes[INVERSE + i], its))


@inline
def _quadric(lanes: Floats, i: Any) -> QuadricRecord:
    """Return the quadric in a lane."""
    return QuadricRecord(
        lanes[R0 + i], lanes[R1 + i], lanes[R2 + i], lanes[R3 + i], lanes[R4 + i], lanes[R5 + i], lanes[R6 + i],
        lanes[R7 + i], lanes[R8 + i], lanes[R9 + i], lanes[R10 + i], lanes[R11 + i], lanes[R12 + i], lanes[R13 + i],
        lanes[R14 + i], lanes[R15 + i], lanes[R16 + i], lanes[R17 + i], lanes[R18 + i],
    )  # fmt: skip


# Bodies of one form

_MOVED = (
    OX, OY, OZ, DX, DY, DZ, T_MIN, T_MAX, WITHIN, INVERSE, UNIT, START, ORIGIN_SIZE, START_SIZE, NARROW_IN, NARROW_OUT,
    SEEKS, DOUBT, OFF, BODY_OFF, BODY_FAR,
)  # fmt: skip
"""Rows of a lane that are set before it meets its leaves; `_close_up` moves them."""


@helper
def _load_rays(geometry: Geometry, bodies: BodyQueue, form: int, rays: Floats, more: Floats, count: int) -> None:
    """Load queued rays into lanes, with the limits of their bodies; `rays` and `more` hold eight numbers a ray each."""
    lanes, numbers, begin = bodies.lanes, bodies.numbers, WAITING + LANES * form
    for k in range(count):
        numbers[PROGRAM + k] = integer(geometry, table.ENTRY_INDEX, numbers[ENTRIES + LANES * form + k])
        lengths, lane = lengths_of(geometry, table.PROGRAM_LIMITS, numbers[PROGRAM + k]), np.uint64(k)
        lanes[BODY_OFF + lane], lanes[BODY_FAR + lane] = lengths.off, lengths.far
    for k in range(0, count, 8):
        records_in_lanes(rays, numbers, begin + k, lanes, OX + np.uint64(k))
        records_in_lanes(more, numbers, begin + k, lanes, R0 + np.uint64(k))
    first, last = eights(0, count)
    for i in range(first, last):
        dx, dy, dz, inverse, start = lanes[R0 + i], lanes[R1 + i], lanes[R2 + i], lanes[R3 + i], lanes[R4 + i]
        best, off = lanes[R6 + i], lanes[R7 + i]
        within, unit = best + off, ray_unit(dx, dy, dz, inverse)
        size = ray_size(lanes[OX + i], lanes[OY + i], lanes[OZ + i], unit)
        lanes[DX + i], lanes[DY + i], lanes[DZ + i] = dx, dy, dz
        lanes[INVERSE + i], lanes[START + i], lanes[UNIT + i], lanes[ORIGIN_SIZE + i] = inverse, start, unit, size
        lanes[START_SIZE + i] = size * STARTING if start >= 0.0 else size
        nearness = lane_nearness(lanes, i, Nearness(lanes[BODY_OFF + i], lanes[BODY_FAR + i]))
        # A body entered at the best hit must not seem to be left there: `begin_lane` searches as far as a tie
        limit = within + 2.0 * nearness.off + abs(best) * END + END_LEAST
        lanes[WITHIN + i], lanes[T_MAX + i], lanes[DOUBT + i] = within, min(lanes[R5 + i], limit), 0.0
        begin_lane(lanes, i, nearness)


@helper
def _meet_leaf(geometry: Geometry, bodies: BodyQueue, model: int, leaf: int, narrows: bool, count: int) -> int:
    """Compute the spans of leaf number `leaf` of all bodies; return how many lanes still seek."""
    lanes, numbers = bodies.lanes, bodies.numbers
    for k in range(count):
        lane = np.uint64(k)
        cell = cell_of_leaf(geometry, integer(geometry, table.PROGRAM_LEAF, numbers[PROGRAM + k]) + leaf)
        numbers[CELL + k] = cell
        lengths = lengths_of(geometry, table.CELL_LIMITS, cell)
        lanes[CELL_OFF + lane], lanes[CELL_FAR + lane] = lengths.off, lengths.far
    first, last = eights(0, count)
    for i in range(first, last):
        put_whole_lane(lanes, i)
    like = cell_of_leaf(geometry, integer(geometry, table.PROGRAM_LEAF, model) + leaf)
    begin, end = integer(geometry, table.CELL_FIRST, like), integer(geometry, table.CELL_FIRST, like + 1)
    for place in range(begin, end):
        side = plane_side(geometry, place)
        cut_planes(geometry, bodies, place - begin, side, FACES * leaf + place - begin, count)
    some = 0
    for i in range(first, last):
        off, far = lane_nearness(lanes, i, cell_limits(lanes, i))
        inside = may_overlap(lanes[T_IN + i], lanes[T_OUT + i], lanes[T_MIN + i], lanes[T_MAX + i], off)
        some += 1 if inside | (lanes[UNSURE + i] == 2.0) | (far < 0.0) else 0
        lanes[FLAG + i] = 1.0
    if some == 0:
        bodies.spans[leaf] = 0
        return 0
    surface, side = integer(geometry, table.CELL_QUADRIC, like), 1
    if surface >= 0:
        side = cell_side(geometry, like)
        if integer(geometry, table.SURFACE_KIND, surface) == SPHERE:
            meet_spheres(geometry, bodies, count)
        else:
            meet_quadrics(geometry, bodies, count)
    row, second, several = np.uint64(LEAF * leaf), np.uint64(LEAF * leaf + SPAN), 0
    curved = FACES * leaf + FACES - 1
    for i in range(first, last):
        nearness = lane_nearness(lanes, i, cell_limits(lanes, i))
        quadric = lanes[SURFACE + i] if surface >= 0 else NO_PLACE - 9.0
        several += put_lane_spans(lanes, bodies.leaves, i, row, second, side, curved, quadric, nearness, True)
    near = narrow_lanes(lanes, bodies.leaves, LEAF * leaf, narrows, 0, count)
    bodies.spans[leaf] = 0 if near == 0 else (2 if several > 0 else 1)
    return near


@inline
def _move(floats: Floats, at: Any, numbers: Any, count: int) -> None:
    """Compact a row of lanes: lane j gets the content of lane numbers[AT + j], which is not before it."""
    for j in range(count):
        floats[at + np.uint64(j)] = floats[at + np.uint64(numbers[AT + j])]


@helper
def _close_up(geometry: Geometry, bodies: BodyQueue, form: int, count: int) -> int:
    """Remove lanes that certainly seek no more, and compact the others; return how many remain.

    Nothing moves unless a whole group of eight becomes free.
    """
    lanes, leaves, numbers, left = bodies.lanes, bodies.leaves, bodies.numbers, 0
    for k in range(count):
        lane = np.uint64(k)
        numbers[AT + left] = k
        left += 1 if lanes[SEEKS + lane] == 1.0 or lanes[DOUBT + lane] != 0.0 else 0
    if (left + 7) >> 3 == (count + 7) >> 3:
        return count
    for k in range(left, (left + 7) & -8):  # fill the last group of eight by repetition
        numbers[AT + k] = numbers[AT + left - 1]
    padded, begin = (left + 7) & -8, LANES * form
    for j in range(padded):
        k = numbers[AT + j]
        numbers[PROGRAM + j] = numbers[PROGRAM + k]
        numbers[WAITING + begin + j] = numbers[WAITING + begin + k]
        numbers[ENTRIES + begin + j] = numbers[ENTRIES + begin + k]
    for row in _MOVED:
        _move(lanes, row, numbers, padded)
    model = numbers[MODELS + form]
    root = root_of(geometry, model)
    (first, last), more = leaves_of(geometry, model), rows_of_leaves(geometry, model)
    for leaf in range(first, last):
        matches = integer(geometry, table.LEAF_GATE, leaf + more) == root
        matches = matches and integer(geometry, table.LEAF_NEGATED, leaf + more) == 0
        for k in range(4 * bodies.spans[leaf - first] if matches else 0):
            _move(leaves, np.uint64(LEAF * (leaf - first) + LANES * k), numbers, padded)
    return left


@helper
def meet_bodies(geometry: Geometry, bodies: BodyQueue, form: int, rays: Floats, more: Floats, count: int) -> int:
    """Find the first crossing of each of the first `count` queued rays of a form with its body; `body_hit` reads it.

    Rays that certainly miss are removed from the queue; returns how many remain. `rays` and `more` hold eight numbers
    of each ray of a stream; no ray begins before its origin.
    """
    numbers, model = bodies.numbers, bodies.numbers[MODELS + form]
    for k in range(count, (count + 7) & -8):
        numbers[WAITING + LANES * form + k] = numbers[WAITING + LANES * form]
        numbers[ENTRIES + LANES * form + k] = numbers[ENTRIES + LANES * form]
    its, count = count, (count + 7) & -8
    _load_rays(geometry, bodies, form, rays, more, count)
    within, root = lies_within(geometry, model), root_of(geometry, model)
    (begin, end), row = leaves_of(geometry, model), rows_of_leaves(geometry, model)
    # Leaves within which the bodies lie come first: lanes outside of one are done, and are removed before the others
    for turn in range(2 if within else 1):
        for leaf in range(begin, end):
            narrows = within and integer(geometry, table.LEAF_GATE, leaf + row) == root
            narrows &= integer(geometry, table.LEAF_NEGATED, leaf + row) == 0
            if narrows == (within and turn == 0):
                _meet_leaf(geometry, bodies, model, leaf - begin, narrows, count)
        if within and turn == 0:
            its = _close_up(geometry, bodies, form, its)
            count = (its + 7) & -8
            if its == 0:
                return 0
    sweep_lanes(geometry, BooleanLanes(bodies.lanes, bodies.leaves, bodies.truths, bodies.spans), model, 0, count)
    lanes = bodies.lanes
    first, last = eights(0, count)
    for i in range(first, last):
        nearness = lane_nearness(lanes, i, Nearness(lanes[BODY_OFF + i], lanes[BODY_FAR + i]))
        lanes[DOUBT + i] = 1.0 if unsure_of_sweep(lanes, i, nearness) else lanes[DOUBT + i]
    return its


@inline
def body_hit(geometry: Geometry, bodies: BodyQueue, form: int, k: int) -> Hit:
    """Return the crossing of element k of the queue of a form; t = inf if the ray does not meet the body."""
    lanes, i, entry = bodies.lanes, np.uint64(k), bodies.numbers[ENTRIES + LANES * form + k]
    face, program = whole(lanes[NEW_PLACE + i]), bodies.numbers[PROGRAM + k]
    t, place = lanes[FOUND + i], whole(NO_PLACE)
    if t < math.inf:
        leaf = integer(geometry, table.PROGRAM_LEAF, program) + face // FACES
        cell, number = cell_of_leaf(geometry, leaf), face % FACES
        place = quadric_place(cell) if number == FACES - 1 else integer(geometry, table.CELL_FIRST, cell) + number
    return Hit(
        t, whole(entry), whole(entry), place, whole(lanes[NEW_SENSE + i]),
        lanes[NEW_ENTERS + i] == 1.0, lanes[OFF + i], lanes[DOUBT + i] != 0.0,
    )  # fmt: skip
