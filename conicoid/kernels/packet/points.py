"""Points in lanes: on which side of a surface 64 points are, whether a cell holds them, and which body holds each.

A surface is first tested against the box around all points, which often decides all of them; else the formulas of
single points (body/membership.py) run over the lanes. Points that floats leave open are marked, and tested one by one.

User: slices, voxels and all other points in order; factor over single points on 1,000 bodies: 11 to 18 on slices, 4 to
8 on grids (processor time, one thread, 2026-11-28).
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..._jit.decorators import allocator, choose, helper, inline
from .. import tables as table
from ..body.membership import INSIDE, cell_holds, entry_holds, plane_value, sphere_value
from ..body.scratch import Scratch
from ..bvh.walk import (
    OWN_BEAM,
    leaf_at,
    leaf_ball,
    leaf_item,
    leaf_range,
    next_leaf,
    push_roots,
    put_box,
    scene_tree,
    walk_leaves_box,
)
from ..faces import cell_side, plane_side
from ..numbers.shell_sort import make_sort
from ..programs import cell_of_leaf, gates_of, rows_of_leaves
from ..surface.exact_crossing import OPEN, RoundingRest, rest_number, rest_of_quadric
from ..surface.quadric import QuadricRecord, own_coordinates, quadric_rounding, quadric_value
from ..surface.records import load_plane, load_quadric, load_sphere, plane_limits
from ..tables import BALL, CELL, PLANE, REGION, SPHERE, Floats, Geometry, Ints, Signs, integer, whole
from .booleans import MOST, TRUTHS_SIZE, reset_gates, settle_gates
from .lanes import LANES, packet_row

X, Y, Z, SOUGHT, OUT, UNSURE, LOST, AFTER = (np.uint64(row) for row in range(0, 8 * LANES, LANES))
"""Rows: the points; 1 while a body is sought; 1 where a cell does not hold the point; 1 where that is not certain; 1
where the body is not certain; the body after which others are sought."""
BOX = 8 * LANES
"""Place behind the rows: the middle of the box around the points, and half its sides."""
SIZE = BOX + 6
EVERY = np.uint64(LANES)

NONE, SOME, ALL = 0, 1, 2
"""How many points of a packet are on the inner side."""
_LOOSE = 4.0
"""Factor from the rounding at a point to a bound for a whole box."""


@inline
def _sided(value: float, off: float) -> int:
    """Return ALL if value < -off, NONE if value > off, else SOME."""
    return NONE if value > off else (ALL if value < -off else SOME)


@inline
def _plane_of_box(geometry: Geometry, row: int, inner: float, room: Floats) -> int:
    """Return how much of the box is on the inner side of a plane: ALL, SOME or NONE."""
    plane = load_plane(geometry, row)
    value, off = plane_value(plane, plane_limits(geometry, row), room[BOX], room[BOX + 1], room[BOX + 2])
    reach = abs(plane.nx) * room[BOX + 3] + abs(plane.ny) * room[BOX + 4] + abs(plane.nz) * room[BOX + 5]
    # Rounding grows with the distance from the anchor: the farthest corner bounds that of all points of the box
    far, widest = _corner(plane.ax, plane.ay, plane.az, room), plane_limits(geometry, row)
    _, off = plane_value(plane, widest, far[0], far[1], far[2])
    return _sided(value * inner, reach * (1.0 + 1e-9) + _LOOSE * off)


@inline
def _corner(ax: float, ay: float, az: float, room: Floats) -> tuple[float, float, float]:
    """Return a point at least as far from an anchor, along each axis, as every point of the box."""
    return (
        ax + (abs(room[BOX] - ax) + room[BOX + 3]),
        ay + (abs(room[BOX + 1] - ay) + room[BOX + 4]),
        az + (abs(room[BOX + 2] - az) + room[BOX + 5]),
    )


@inline
def _sphere_of_box(geometry: Geometry, row: int, inner: float, room: Floats) -> int:
    """Return how much of the box is on the inner side of a sphere, by f(c + d) - f(c) = 2 (c - center)·d + d·d."""
    sphere = load_sphere(geometry, row)
    hx, hy, hz = room[BOX + 3], room[BOX + 4], room[BOX + 5]
    value, _ = sphere_value(sphere, room[BOX], room[BOX + 1], room[BOX + 2])
    px, py, pz = abs(room[BOX] - sphere.x), abs(room[BOX + 1] - sphere.y), abs(room[BOX + 2] - sphere.z)
    reach = 2.0 * (px * hx + py * hy + pz * hz) + (hx * hx + hy * hy + hz * hz)
    far = _corner(sphere.x, sphere.y, sphere.z, room)
    return _sided(value * inner, reach * (1.0 + 1e-9) + _LOOSE * sphere_value(sphere, far[0], far[1], far[2])[1])


@inline
def _spread(w0: float, w1: float, w2: float, room: Floats) -> float:
    """Return by how much w·x varies over the box, to either side."""
    return abs(w0) * room[BOX + 3] + abs(w1) * room[BOX + 4] + abs(w2) * room[BOX + 5]


@inline
def _rounding(
    geometry: Geometry, rest: RoundingRest, quadric: QuadricRecord, row: int, x: float, y: float, z: float
) -> float:
    """`quadric_rounding` of a quadric of the table."""
    at = rest_of_quadric(geometry, row)
    return quadric_rounding(
        quadric, x, y, z, rest_number(rest, at), rest_number(rest, at + 1), rest_number(rest, at + 2)
    )


@inline
def _quadric_of_box(geometry: Geometry, rest: RoundingRest, row: int, inner: float, room: Floats) -> int:
    """Return how much of the box is on the inner side of a quadric.

    From y to y + e the quadric changes by 2 (s y + b)·e + s e²; |e| is at most the spread.
    """
    quadric = load_quadric(geometry, row)
    _, _, _, w00, w01, w02, w10, w11, w12, w20, w21, w22, s0, s1, s2, b0, b1, b2, _ = quadric
    x, y, z = room[BOX], room[BOX + 1], room[BOX + 2]
    y0, y1, y2 = own_coordinates(quadric, x, y, z)
    e0, e1, e2 = _spread(w00, w01, w02, room), _spread(w10, w11, w12, room), _spread(w20, w21, w22, room)
    reach = (2.0 * abs(s0 * y0 + b0) + abs(s0) * e0) * e0
    reach += (2.0 * abs(s1 * y1 + b1) + abs(s1) * e1) * e1
    reach += (2.0 * abs(s2 * y2 + b2) + abs(s2) * e2) * e2
    far = _corner(quadric.ax, quadric.ay, quadric.az, room)
    off = _rounding(geometry, rest, quadric, row, far[0], far[1], far[2])
    return _sided(quadric_value(quadric, x, y, z) * inner, reach * (1.0 + 1e-9) + _LOOSE * off)


@helper
def side_of_box(geometry: Geometry, rest: RoundingRest, surface: int, side: int, room: Floats) -> int:
    """Return how much of the box is on the inner side of a surface: ALL, SOME or NONE."""
    row, kind, inner = (
        integer(geometry, table.SURFACE_ROW, surface),
        integer(geometry, table.SURFACE_KIND, surface),
        1.0,
    )
    inner = 1.0 if side > 0 else -1.0
    if kind == PLANE:
        return _plane_of_box(geometry, row, inner, room)
    if kind == SPHERE:
        return _sphere_of_box(geometry, row, inner, room)
    return _quadric_of_box(geometry, rest, row, inner, room)


@inline
def _put_sides(room: Floats, i: int, value: float, off: float) -> bool:
    """Mark the side of lane i by a value that is positive outside; True if the lane may still be inside."""
    room[OUT + i] = choose(value > off, 1.0, room[OUT + i])
    room[UNSURE + i] = choose(abs(value) > off, room[UNSURE + i], 1.0)
    return (room[OUT + i] == 0.0) & (room[SOUGHT + i] == 1.0)


@helper
def sides_of_lanes(geometry: Geometry, rest: RoundingRest, surface: int, side: int, room: Floats) -> int:
    """Mark OUT and UNSURE by a surface; return how many lanes may still be inside."""
    row, kind = integer(geometry, table.SURFACE_ROW, surface), integer(geometry, table.SURFACE_KIND, surface)
    inner, left = 1.0 if side > 0 else -1.0, 0
    if kind == PLANE:
        plane, limits = load_plane(geometry, row), plane_limits(geometry, row)
        for i in range(EVERY):
            value, off = plane_value(plane, limits, room[X + i], room[Y + i], room[Z + i])
            left += 1 if _put_sides(room, i, value * inner, off) else 0
    elif kind == SPHERE:
        sphere = load_sphere(geometry, row)
        for i in range(EVERY):
            value, off = sphere_value(sphere, room[X + i], room[Y + i], room[Z + i])
            left += 1 if _put_sides(room, i, value * inner, off) else 0
    else:
        quadric, at = load_quadric(geometry, row), rest_of_quadric(geometry, row)
        r0, r1, r2 = rest_number(rest, at), rest_number(rest, at + 1), rest_number(rest, at + 2)
        for i in range(EVERY):
            x, y, z = room[X + i], room[Y + i], room[Z + i]
            off = quadric_rounding(quadric, x, y, z, r0, r1, r2)
            left += 1 if _put_sides(room, i, quadric_value(quadric, x, y, z) * inner, off) else 0
    return left


@inline
def clear_sides(room: Floats) -> None:
    """Reset OUT and UNSURE of all lanes."""
    for i in range(EVERY):
        room[OUT + i], room[UNSURE + i] = 0.0, 0.0


@inline
def _face(geometry: Geometry, cell: int, slot: int, last: int) -> tuple[int, int]:
    """Return (surface, inner side) of a face of a cell; the quadric's face is the last."""
    if slot == last:
        return integer(geometry, table.CELL_QUADRIC, cell), cell_side(geometry, cell)
    return integer(geometry, table.PLANE_SURFACE, slot), plane_side(geometry, slot)


@helper
def cell_of_lanes(geometry: Geometry, rest: RoundingRest, cell: int, room: Floats) -> int:
    """Return which lanes a cell holds: NONE, ALL, or SOME, and then OUT and UNSURE hold the answer of each.

    NONE and ALL are certain. Where OUT is 0 and UNSURE is 1, the point needs a test of its own.
    """
    first, last = integer(geometry, table.CELL_FIRST, cell), integer(geometry, table.CELL_FIRST, cell + 1)
    end = last + 1 if integer(geometry, table.CELL_QUADRIC, cell) >= 0 else last
    for slot in range(end - 1, first - 1, -1):  # the quadric first: it excludes most
        surface, side = _face(geometry, cell, slot, last)
        # First all faces against the box: one that excludes it saves the lanes altogether
        if side_of_box(geometry, rest, surface, side, room) == NONE:
            return NONE
    cuts = False
    for slot in range(first, end):
        surface, side = _face(geometry, cell, slot, last)
        if side_of_box(geometry, rest, surface, side, room) == ALL:
            continue
        if not cuts:
            clear_sides(room)
        cuts = True
        if sides_of_lanes(geometry, rest, surface, side, room) == 0:
            return NONE
    return SOME if cuts else ALL


@inline
def ball_of_lanes(geometry: Geometry, rest: RoundingRest, surface: int, room: Floats) -> int:
    """`cell_of_lanes` for a ball."""
    of_box = side_of_box(geometry, rest, surface, 1, room)
    if of_box != SOME:
        return of_box
    clear_sides(room)
    return NONE if sides_of_lanes(geometry, rest, surface, 1, room) == 0 else SOME


# The body of each of 64 points
#
# The tree is searched once for the box around the points, and bodies are tested in lanes. The rules are those of single
# points (queries/exact/membership.py), whose tests also decide each lane that is left open.

_FEW = 24
"""Most bodies, and most leaves of a body, that are tested in lanes; if a box has more, points are tested one by one."""
_WIDER = 1.0 + 1e-6


class PointMemory(NamedTuple):
    """The lanes of points of one thread, and the memory for bodies in them."""

    room: Floats  # the points and their marks, see `X`
    truths: Floats  # true inputs of a body's gates
    which: Ints  # the number of each lane's point, -1 for none


@allocator
def new_point_memory() -> PointMemory:
    """Return memory of points for one thread."""
    return PointMemory(np.zeros(SIZE), np.zeros(TRUTHS_SIZE), np.empty(LANES, np.int32))


@inline
def _larger(data: None, a: int, b: int) -> bool:
    """The order of numbers, for `make_sort`."""
    return a > b


_sort = make_sort(_larger)


@helper
def put_points(memory: PointMemory, points: Floats, after: Ints, packet: int, width: int) -> bool:
    """Load the points of a packet into lanes, and the box around them; False for no point or one that is not finite.

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
        middle = 0.5 * a + 0.5 * b  # a + b might overflow
        room[BOX + axis], room[BOX + 3 + axis] = middle, max(b - middle, middle - a) * _WIDER
    return math.isfinite(room[BOX] + room[BOX + 1] + room[BOX + 2])


@inline
def _outside_ball(room: Floats, x: float, y: float, z: float, r: float) -> bool:
    """True if the whole box is certainly outside of a ball around a body."""
    dx = max(abs(room[BOX] - x) - room[BOX + 3], 0.0)
    dy = max(abs(room[BOX + 1] - y) - room[BOX + 4], 0.0)
    dz = max(abs(room[BOX + 2] - z) - room[BOX + 5], 0.0)
    return dx * dx + dy * dy + dz * dz > r * r * _WIDER


@helper
def entries_of_box(geometry: Geometry, scratch: Scratch, room: Floats) -> int:
    """Write the entries that the box may meet to scratch.found, sorted; return their number, or -1 for many."""
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
def _region_of_lanes(
    geometry: Geometry, rest: RoundingRest, scratch: Scratch, memory: PointMemory, program: int
) -> int:
    """`cell_of_lanes` for a Boolean body; -1 if it has too many gates, or too many leaves near the box."""
    room, truths = memory.room, memory.truths
    (begin, end), row = gates_of(geometry, program), rows_of_leaves(geometry, program)
    if end - begin > MOST:
        return -1
    way = scratch.inner_way
    for k in range(14):  # the beam of the box, for the walk over the body's leaves
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
def _test_point(
    geometry: Geometry, rest: RoundingRest, scratch: Scratch, entry: int, x: float, y: float, z: float
) -> int:
    """Return INSIDE, 0 or OPEN for one point."""
    if integer(geometry, table.ENTRY_KIND, entry) == CELL:
        return cell_holds(geometry, rest, integer(geometry, table.ENTRY_INDEX, entry), x, y, z)
    return entry_holds(geometry, rest, scratch, entry, x, y, z)


@helper
def locate_packet(
    geometry: Geometry, rest: RoundingRest, scratch: Scratch, memory: PointMemory, bodies: Ints, undecided: Signs
) -> bool:
    """Find the first body after AFTER that holds each lane's point; False, and nothing written, for many bodies.

    Writes the body to `bodies`, or 1 to `undecided` if it is not certain; relies on these being -1 and 0 everywhere.
    """
    room, which, open_lanes = memory.room, memory.which, 0
    count = entries_of_box(geometry, scratch, room)
    if count < 0:
        return False
    for i in range(LANES):
        open_lanes += 1 if which[i] >= 0 else 0
    for k in range(count):
        entry: Any = scratch.found[k]
        kind, index = integer(geometry, table.ENTRY_KIND, entry), integer(geometry, table.ENTRY_INDEX, entry)
        body = whole(entry)
        if kind > REGION:
            continue
        if kind == BALL:
            sides = ball_of_lanes(geometry, rest, index, room)
        elif kind == CELL:
            sides = cell_of_lanes(geometry, rest, index, room)
        else:
            sides = _region_of_lanes(geometry, rest, scratch, memory, index)
        if sides == NONE:
            continue
        for i in range(EVERY):
            if room[SOUGHT + i] == 0.0 or float(body) <= room[AFTER + i] or (sides == SOME and room[OUT + i] == 1.0):
                continue
            side = INSIDE
            if sides == -1 or (sides == SOME and room[UNSURE + i] == 1.0):
                side = _test_point(geometry, rest, scratch, entry, room[X + i], room[Y + i], room[Z + i])
            if side == OPEN:
                undecided[which[i]] = 1
            elif side == INSIDE:
                bodies[which[i]] = body
            if side != 0:
                room[SOUGHT + i] = 0.0
                open_lanes -= 1
        if open_lanes == 0:
            break
    return True
