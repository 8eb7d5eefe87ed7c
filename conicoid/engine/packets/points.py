"""Which body holds each of 64 points: the tree is asked once for the box around them, and bodies are met in lanes.

The rules are those of single points (`certified/membership.py`), which also settle each lane that is left open.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ...compiler.jit import allocator, choose, helper, inline
from .. import tables as table
from ..body.contains import INSIDE, cell_holds, entry_holds
from ..body.scratch import Scratch
from ..numbers.sort import sorting_by
from ..programs import cell_of_leaf, gates_of, rows_of_leaves
from ..surface.decide import OPEN, Rest
from ..tables import BALL, CELL, REGION, Floats, Geometry, Ints, Signs, integer, whole
from ..tree.leaf import leaf_at, leaf_ball, leaf_item, leaf_range
from ..tree.walk import OWN_BEAM, next_leaf, push_roots, put_box, scene_tree, walk_leaves_box
from .booleans import MOST, TRUTHS_SIZE, reset_gates, settle_gates
from .lanes import LANES
from .load import packet_row
from .point_lanes import (
    AFTER,
    ALL,
    BOX,
    EVERY,
    LOST,
    NONE,
    OUT,
    SIZE,
    SOME,
    SOUGHT,
    UNSURE,
    X,
    Y,
    Z,
    ball_of_lanes,
    cell_of_lanes,
)

_FEW = 24
"""Bodies, and parts of bodies, that are met in lanes; where a box has more the points are asked one by one."""
_WIDER = 1.0 + 1e-6


class PointMemory(NamedTuple):
    """The lanes and what their bodies need, of one thread."""

    room: Floats  # see `point_lanes`
    truths: Floats  # true inputs of a body's gates
    which: Ints  # the number of each lane's point, -1 for none


@allocator
def new_point_memory() -> PointMemory:
    """Memory for one thread."""
    return PointMemory(np.zeros(SIZE), np.zeros(TRUTHS_SIZE), np.empty(LANES, np.int32))


@inline
def _larger(data: None, a: int, b: int) -> bool:
    """The order of numbers."""
    return a > b


_sort = sorting_by(_larger)


@helper
def put_points(memory: PointMemory, points: Floats, after: Ints, packet: int, width: int) -> bool:
    """The points of a packet into lanes, with the box around them; False if there is none, or one is not finite.

    Lanes without a point repeat the first one, and seek nothing.
    """
    room, which, count = memory.room, memory.which, len(points)
    some, _ = packet_row(packet, 0, width, count)
    if some >= count:
        return False
    low, high = (math.inf, math.inf, math.inf), (-math.inf, -math.inf, -math.inf)
    for row in range(8):
        first, n = packet_row(packet, row, width, count)
        for k in range(8):
            lane, i = np.uint64(8 * row + k), first + k if k < n else some
            x, y, z = points[i, 0], points[i, 1], points[i, 2]
            room[X + lane], room[Y + lane], room[Z + lane] = x, y, z
            room[SOUGHT + lane], room[LOST + lane] = 1.0 if k < n else 0.0, 0.0
            room[AFTER + lane] = float(after[i if len(after) > 1 else 0])
            which[8 * row + k] = i if k < n else -1
            low = min(low[0], x), min(low[1], y), min(low[2], z)
            high = max(high[0], x), max(high[1], y), max(high[2], z)
    for axis in range(3):
        a = low[0] if axis == 0 else (low[1] if axis == 1 else low[2])
        b = high[0] if axis == 0 else (high[1] if axis == 1 else high[2])
        middle = 0.5 * a + 0.5 * b
        room[BOX + axis], room[BOX + 3 + axis] = middle, max(b - middle, middle - a) * _WIDER
    return math.isfinite(room[BOX] + room[BOX + 1] + room[BOX + 2])


@inline
def _outside_ball(room: Floats, x: float, y: float, z: float, r: float) -> bool:
    """Is all of the box certainly outside of a ball around a body?"""
    dx = max(abs(room[BOX] - x) - room[BOX + 3], 0.0)
    dy = max(abs(room[BOX + 1] - y) - room[BOX + 4], 0.0)
    dz = max(abs(room[BOX + 2] - z) - room[BOX + 5], 0.0)
    return dx * dx + dy * dy + dz * dz > r * r * _WIDER


@helper
def entries_of_box(geometry: Geometry, scratch: Scratch, room: Floats) -> int:
    """Put the entries that the box may meet into scratch.found, in order; -1 where they are many."""
    way, count, parts = scratch.way, 0, 0
    low = room[BOX] - room[BOX + 3], room[BOX + 1] - room[BOX + 4], room[BOX + 2] - room[BOX + 5]
    high = room[BOX] + room[BOX + 3], room[BOX + 1] + room[BOX + 4], room[BOX + 2] + room[BOX + 5]
    put_box(way, low, high)
    code, _, top = next_leaf(geometry, way, way, OWN_BEAM, push_roots(geometry, way, scene_tree(geometry)))
    while code != 0:
        first, last = leaf_range(code)
        at, n = leaf_at(geometry, first), last - first
        for k in range(n):
            ball = leaf_ball(geometry, at, n, k)
            if _outside_ball(room, ball.x, ball.y, ball.z, ball.radius):
                continue
            item = leaf_item(geometry, at, n, k)
            scratch.found[count] = item.entry
            count += 1
            parts += 1
            if parts > _FEW:
                return -1
        code, _, top = next_leaf(geometry, way, way, OWN_BEAM, top)
    _sort(scratch.found, count, None)
    return count


@helper
def _region_of_lanes(geometry: Geometry, rest: Rest, scratch: Scratch, memory: PointMemory, program: int) -> int:
    """`cell_of_lanes` of a Boolean body; -1 where it has too many parts here."""
    room, truths = memory.room, memory.truths
    (begin, end), row = gates_of(geometry, program), rows_of_leaves(geometry, program)
    if end - begin > MOST:
        return -1
    way = scratch.inner_way
    for k in range(14):
        way[OWN_BEAM + k] = scratch.way[OWN_BEAM + k]
    leaves = walk_leaves_box(geometry, way, program, scratch.found_leaves, _FEW)
    if leaves < 0:
        return -1
    reset_gates(geometry, truths, program, 0, LANES)
    for i in range(EVERY):
        room[LOST + i] = 0.0
    for k in range(leaves):
        leaf = whole(scratch.found_leaves[k])
        held = cell_of_lanes(geometry, rest, cell_of_leaf(geometry, leaf), room)
        if held == NONE:
            continue
        change = -1.0 if integer(geometry, table.LEAF_NEGATED, leaf + row) == 1 else 1.0
        counter = np.uint64((integer(geometry, table.LEAF_GATE, leaf + row) - begin) * LANES)
        if held == ALL:
            for i in range(EVERY):
                truths[counter + i] += change
        else:
            for i in range(EVERY):
                truths[counter + i] += choose(room[OUT + i] == 0.0, change, 0.0)
                room[LOST + i] = choose((room[OUT + i] == 0.0) & (room[UNSURE + i] == 1.0), 1.0, room[LOST + i])
    settle_gates(geometry, truths, program, 0, LANES)
    need = float(integer(geometry, table.GATE_NEED, begin))
    negated = integer(geometry, table.GATE_NEGATED, begin) == 1
    for i in range(EVERY):
        inside = (truths[i] >= need) != negated
        room[UNSURE + i] = room[LOST + i]
        room[OUT + i] = choose(inside | (room[LOST + i] == 1.0), 0.0, 1.0)
    return SOME


@inline
def _asked_alone(geometry: Geometry, rest: Rest, scratch: Scratch, entry: int, x: float, y: float, z: float) -> int:
    """INSIDE, 0 or OPEN, of one point."""
    if integer(geometry, table.ENTRY_KIND, entry) == CELL:
        return cell_holds(geometry, rest, integer(geometry, table.ENTRY_INDEX, entry), x, y, z)
    return entry_holds(geometry, rest, scratch, entry, x, y, z)


@helper
def locate_packet(
    geometry: Geometry, rest: Rest, scratch: Scratch, memory: PointMemory, bodies: Ints, still: Signs
) -> bool:
    """The first body after AFTER that holds each lane's point; False, and nothing done, where the box has many bodies.

    Relies on bodies being -1 and still 0 for all of them.
    """
    room, which, left = memory.room, memory.which, 0
    count = entries_of_box(geometry, scratch, room)
    if count < 0:
        return False
    for i in range(LANES):
        left += 1 if which[i] >= 0 else 0
    for k in range(count):
        entry: Any = scratch.found[k]
        kind, index = integer(geometry, table.ENTRY_KIND, entry), integer(geometry, table.ENTRY_INDEX, entry)
        body = whole(entry)
        if kind > REGION:
            continue
        if kind == BALL:
            held = ball_of_lanes(geometry, rest, index, room)
        elif kind == CELL:
            held = cell_of_lanes(geometry, rest, index, room)
        else:
            held = _region_of_lanes(geometry, rest, scratch, memory, index)
        if held == NONE:
            continue
        for i in range(EVERY):
            if room[SOUGHT + i] == 0.0 or float(body) <= room[AFTER + i] or (held == SOME and room[OUT + i] == 1.0):
                continue
            found = INSIDE
            if held == -1 or (held == SOME and room[UNSURE + i] == 1.0):
                found = _asked_alone(geometry, rest, scratch, entry, room[X + i], room[Y + i], room[Z + i])
            if found == OPEN:
                still[which[i]] = 1
            elif found == INSIDE:
                bodies[which[i]] = body
            if found != 0:
                room[SOUGHT + i] = 0.0
                left -= 1
        if left == 0:
            break
    return True
