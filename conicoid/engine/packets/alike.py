"""Boolean bodies of one form, another in each lane: of rays in no order, each with a body that it may meet.

Two bodies are of one form if they differ in the numbers of their surfaces only. So what the lanes have to do is read
from one of them, the model, and the records of planes and quadrics are gathered, row by row. From there on the lanes
go through the formulas of packets (cells.py, planes.py, booleans.py), to the same bits.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ...compiler.jit import helper, inline
from .. import tables as table
from ..body.cell import NO_PLACE, quadric_place
from ..body.hit import Hit
from ..culling import records_in_lanes
from ..culling.slack import END, END_LEAST
from ..faces import cell_side, plane_side
from ..programs import cell_of_leaf, leaves_of, root_of, rows_of_leaves
from ..surface.doubt import STARTING
from ..surface.interval import may_overlap
from ..surface.nearness import Nearness, lengths_of, ray_size, ray_unit
from ..tables import SPHERE, Floats, Geometry, integer, whole
from .booleans import (
    Memory,
    begin_lane,
    lies_within,
    narrow_lanes,
    sweep_lanes,
    unsure_of_sweep,
)
from .cells import put_whole_lane
from .forms import (
    AT,
    BODY_FAR,
    BODY_OFF,
    CELL,
    CELL_FAR,
    CELL_OFF,
    ENTRIES,
    FACES,
    MODELS,
    PROGRAM,
    R0,
    R1,
    R2,
    R3,
    R4,
    R5,
    R6,
    R7,
    SURFACE,
    WAITING,
    Bodies,
)
from .gathered import cell_limits, cut_planes, meet_quadrics, meet_spheres
from .lanes import (
    AWAY,
    BESIDE,
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
    OX,
    OY,
    OZ,
    SEEKS,
    START,
    T_IN,
    T_MAX,
    T_MIN,
    T_OUT,
    UNIT,
    UNSURE,
    WITHIN,
    eights,
    lane_nearness,
)
from .spans import LEAF, SPAN, put_lane_spans

_MOVED = (
    OX, OY, OZ, DX, DY, DZ, T_MIN, T_MAX, WITHIN, INVERSE, UNIT, START, AWAY, BESIDE, NARROW_IN, NARROW_OUT, SEEKS,
    DOUBT, OFF, BODY_OFF, BODY_FAR,
)  # fmt: skip
"""Rows of a lane that are known before its leaves are met."""


@helper
def _load_rays(geometry: Geometry, bodies: Bodies, form: int, rays: Floats, more: Floats, count: int) -> None:
    """The rays into their lanes, and the limits of their bodies; `rays` and `more` hold eight numbers of each ray."""
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
        away = ray_size(lanes[OX + i], lanes[OY + i], lanes[OZ + i], unit)
        lanes[DX + i], lanes[DY + i], lanes[DZ + i] = dx, dy, dz
        lanes[INVERSE + i], lanes[START + i], lanes[UNIT + i], lanes[AWAY + i] = inverse, start, unit, away
        lanes[BESIDE + i] = away * STARTING if start >= 0.0 else away
        nearness = lane_nearness(lanes, i, Nearness(lanes[BODY_OFF + i], lanes[BODY_FAR + i]))
        # A body entered where the best is must not seem to be left there: `begin_lane` looks as far as a tie
        limit = within + 2.0 * nearness.off + abs(best) * END + END_LEAST
        lanes[WITHIN + i], lanes[T_MAX + i], lanes[DOUBT + i] = within, min(lanes[R5 + i], limit), 0.0
        begin_lane(lanes, i, nearness)


@helper
def _meet_leaf(geometry: Geometry, bodies: Bodies, model: int, leaf: int, narrows: bool, count: int) -> int:
    """The spans of a leaf of all bodies; returns how many lanes still seek."""
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
    """Rows of lanes close up: lane j gets what is in lane numbers[AT + j], which is not before it."""
    for j in range(count):
        floats[at + np.uint64(j)] = floats[at + np.uint64(numbers[AT + j])]


@helper
def _close_up(geometry: Geometry, bodies: Bodies, form: int, count: int) -> int:
    """Take lanes off that seek no more, for certain; the others come to be the first. Returns how many are left."""
    lanes, leaves, numbers, left = bodies.lanes, bodies.leaves, bodies.numbers, 0
    for k in range(count):
        lane = np.uint64(k)
        numbers[AT + left] = k
        left += 1 if lanes[SEEKS + lane] == 1.0 or lanes[DOUBT + lane] != 0.0 else 0
    if (left + 7) >> 3 == (count + 7) >> 3:
        return count
    for k in range(left, (left + 7) & -8):
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
        met = integer(geometry, table.LEAF_GATE, leaf + more) == root
        met = met and integer(geometry, table.LEAF_NEGATED, leaf + more) == 0
        for k in range(4 * bodies.spans[leaf - first] if met else 0):
            _move(leaves, np.uint64(LEAF * (leaf - first) + LANES * k), numbers, padded)
    return left


@helper
def meet_bodies(geometry: Geometry, bodies: Bodies, form: int, rays: Floats, more: Floats, count: int) -> int:
    """Where the first `count` rays that wait of a form meet their bodies first; `body_hit` reads it.

    Those that certainly miss are taken off the list; returns how many are left. `rays` and `more` hold eight numbers
    of each ray of a stream, none of which begins before its origin.
    """
    numbers, model = bodies.numbers, bodies.numbers[MODELS + form]
    for k in range(count, (count + 7) & -8):
        numbers[WAITING + LANES * form + k] = numbers[WAITING + LANES * form]
        numbers[ENTRIES + LANES * form + k] = numbers[ENTRIES + LANES * form]
    its, count = count, (count + 7) & -8
    _load_rays(geometry, bodies, form, rays, more, count)
    within, root = lies_within(geometry, model), root_of(geometry, model)
    (begin, end), row = leaves_of(geometry, model), rows_of_leaves(geometry, model)
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
    sweep_lanes(geometry, Memory(bodies.lanes, bodies.leaves, bodies.truths, bodies.spans), model, 0, count)
    lanes = bodies.lanes
    first, last = eights(0, count)
    for i in range(first, last):
        nearness = lane_nearness(lanes, i, Nearness(lanes[BODY_OFF + i], lanes[BODY_FAR + i]))
        lanes[DOUBT + i] = 1.0 if unsure_of_sweep(lanes, i, nearness) else lanes[DOUBT + i]
    return its


@inline
def body_hit(geometry: Geometry, bodies: Bodies, form: int, k: int) -> Hit:
    """The crossing of number k of those that waited of a form; t = inf if the ray does not meet the body."""
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
