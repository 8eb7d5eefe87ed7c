"""First hits of coherent rays, 64 at a time: every inner loop runs over the lanes of a packet.

The lanes go through the same formulas as single rays, which the compiler turns into vector
instructions: functions are merged into the loop, a surface's record is a tuple read before it, and
selects take the place of branches. The few lanes whose terms cancel are done again one by one. So a
ray gives the same hit to the bit, whichever way it goes.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..geometry import tables as table
from ..geometry.cell import NO_SLOT, QUADRIC_SLOT, load_plane, load_quadric, load_sphere, slot_face
from ..geometry.plane import Plane, careful_plane, plain_plane
from ..geometry.quadric import (
    Quadric,
    Sphere,
    careful_quadratic,
    quadratic_on_ray,
    settled_roots,
    sphere_roots,
)
from ..geometry.tables import BALL, CELL, SPHERE, Floats, Geometry, Ray, integer
from ..jit import helper, inline
from .kernels import Hit, scene_tree, try_entry
from .scratch import Scratch
from .walk import leaf_range, push_roots, reciprocal

LANES = 64

# Where the rows of the lanes begin. One block of floats, numbers of things too, at places the compiler knows:
# so it sees that what a loop writes is not what it reads
(
    OX, OY, OZ, DX, DY, DZ, INVERSE, IX, IY, IZ, T_MIN, T_MAX, BEST, START, BODY, ENTRY, SLOT, ENTERS,
    A, B, C, DISCRIMINANT, FOOT, T_IN, T_OUT, LOW, HIGH, SLOT_IN, SLOT_OUT, FLAG, SURFACE, FACE, SIDE,
) = range(0, 33 * LANES, LANES)  # fmt: skip
SIZE = 33 * LANES

RESOLVED = -3
"""Slot of a hit whose surface, face and side stand in the marks already."""


@inline
def whole(x: float) -> Any:
    """A number of a thing, out of the block of floats."""
    return np.int64(x)


@inline
def put_ray(lanes: Floats, i: int, ray: Ray, idle: bool) -> None:
    """Ray `ray` into lane i; an idle lane has an empty interval."""
    ox, oy, oz, dx, dy, dz, t_min, t_max, start = ray
    lanes[OX + i], lanes[OY + i], lanes[OZ + i] = ox, oy, oz
    lanes[DX + i], lanes[DY + i], lanes[DZ + i] = dx, dy, dz
    lanes[INVERSE + i] = 1.0 / (dx * dx + dy * dy + dz * dz)
    lanes[IX + i], lanes[IY + i], lanes[IZ + i] = reciprocal(dx), reciprocal(dy), reciprocal(dz)
    lanes[T_MIN + i], lanes[T_MAX + i], lanes[BEST + i] = t_min, -math.inf if idle else t_max, math.inf
    lanes[START + i], lanes[BODY + i], lanes[ENTRY + i] = start, -1, -1


@inline
def lane_ray(lanes: Floats, i: int, t_max: float) -> Ray:
    return (
        lanes[OX + i], lanes[OY + i], lanes[OZ + i], lanes[DX + i], lanes[DY + i], lanes[DZ + i],
        lanes[T_MIN + i], t_max, whole(lanes[START + i]),
    )  # fmt: skip


@inline
def _take(lanes: Floats, i: int, t: float, entry: int, body: int, slot: int, enters: int) -> None:
    """Keep the nearer of a lane's hit and a new one; equal t goes to the body listed first."""
    best = lanes[BEST + i]
    closer = (t < best) | ((t == best) & (body < lanes[BODY + i]))
    lanes[BEST + i] = t if closer else best
    lanes[BODY + i] = body if closer else lanes[BODY + i]
    lanes[ENTRY + i] = entry if closer else lanes[ENTRY + i]
    lanes[SLOT + i] = slot if closer else lanes[SLOT + i]
    lanes[ENTERS + i] = enters if closer else lanes[ENTERS + i]


@inline
def _ball_lanes(lanes: Floats, sphere: Sphere, surface: int, entry: int, body: int) -> None:
    for i in range(LANES):
        low, high, _, crosses = sphere_roots(
            sphere, lanes[OX + i], lanes[OY + i], lanes[OZ + i], lanes[DX + i], lanes[DY + i], lanes[DZ + i],
            lanes[INVERSE + i], lanes[START + i] == surface,
        )  # fmt: skip
        first = crosses & (low > lanes[T_MIN + i]) & (low < lanes[T_MAX + i])
        second = crosses & (high > lanes[T_MIN + i]) & (high < lanes[T_MAX + i])
        t = low if first else (high if second else math.inf)
        _take(lanes, i, t, entry, body, QUADRIC_SLOT, 1 if first else 0)


@inline
def _plane_lanes(lanes: Floats, plane: Plane, surface: int, side: int, slot: int) -> None:
    """Cut the lanes' spans [T_IN, T_OUT] by a plane of a cell."""
    again = 0
    for i in range(LANES):
        height, rate, cancels = plain_plane(
            plane, lanes[OX + i], lanes[OY + i], lanes[OZ + i], lanes[DX + i], lanes[DY + i], lanes[DZ + i]
        )
        lanes[A + i], lanes[B + i] = height, rate
        lanes[FLAG + i] = 1.0 if cancels else 0.0
        again += 1 if cancels else 0
    if again > 0:
        for i in range(LANES):
            if lanes[FLAG + i] == 1.0:
                lanes[A + i], lanes[B + i] = careful_plane(
                    plane, lanes[OX + i], lanes[OY + i], lanes[OZ + i], lanes[DX + i], lanes[DY + i], lanes[DZ + i]
                )
    for i in range(LANES):
        rate = lanes[B + i]
        height = 0.0 if lanes[START + i] == surface else lanes[A + i]
        t = -height / rate
        parallel = rate == 0.0
        outside = parallel & ((height <= 0.0) != (side > 0))
        falls = ((rate < 0.0) == (side > 0)) & ~parallel
        rises = ((rate < 0.0) != (side > 0)) & ~parallel
        later = falls & (t > lanes[T_IN + i])
        sooner = rises & (t < lanes[T_OUT + i])
        t_in = t if later else lanes[T_IN + i]
        lanes[T_IN + i] = math.inf if outside else t_in
        lanes[T_OUT + i] = t if sooner else lanes[T_OUT + i]
        lanes[SLOT_IN + i] = slot if later else lanes[SLOT_IN + i]
        lanes[SLOT_OUT + i] = slot if sooner else lanes[SLOT_OUT + i]


@inline
def _quadric_lanes(lanes: Floats, quadric: Quadric, surface: int) -> None:
    """The lanes' roots into LOW and HIGH; FLAG: 1 outside is inside, 2 it crosses."""
    again = 0
    for i in range(LANES):
        a, b, c, discriminant, foot, cancels = quadratic_on_ray(
            quadric, lanes[OX + i], lanes[OY + i], lanes[OZ + i], lanes[DX + i], lanes[DY + i], lanes[DZ + i],
            lanes[INVERSE + i], lanes[START + i] == surface,
        )  # fmt: skip
        lanes[A + i], lanes[B + i], lanes[C + i], lanes[DISCRIMINANT + i], lanes[FOOT + i] = a, b, c, discriminant, foot
        lanes[FLAG + i] = 1.0 if cancels else 0.0
        again += 1 if cancels else 0
    if again > 0:
        for i in range(LANES):
            if lanes[FLAG + i] == 1.0:
                lanes[A + i], lanes[B + i], lanes[C + i], lanes[DISCRIMINANT + i] = careful_quadratic(
                    quadric, lanes[OX + i], lanes[OY + i], lanes[OZ + i], lanes[DX + i], lanes[DY + i], lanes[DZ + i],
                    lanes[FOOT + i],
                )  # fmt: skip
    for i in range(LANES):
        low, high, outside, crosses = settled_roots(
            lanes[A + i],
            lanes[B + i],
            lanes[C + i],
            lanes[DISCRIMINANT + i],
            lanes[FOOT + i],
            lanes[START + i] == surface,
        )
        lanes[LOW + i], lanes[HIGH + i] = low, high
        lanes[FLAG + i] = (1.0 if outside else 0.0) + (2.0 if crosses else 0.0)


@inline
def _sphere_lanes(lanes: Floats, sphere: Sphere, surface: int) -> None:
    """As `_quadric_lanes`, for the sphere of a cut ball."""
    for i in range(LANES):
        low, high, outside, crosses = sphere_roots(
            sphere, lanes[OX + i], lanes[OY + i], lanes[OZ + i], lanes[DX + i], lanes[DY + i], lanes[DZ + i],
            lanes[INVERSE + i], lanes[START + i] == surface,
        )  # fmt: skip
        lanes[LOW + i], lanes[HIGH + i] = low, high
        lanes[FLAG + i] = (1.0 if outside else 0.0) + (2.0 if crosses else 0.0)


@inline
def _cell_hits(lanes: Floats, side: int, entry: int, body: int) -> None:
    """The first end of the spans of a cell within each lane's interval: `cell_spans`, with selects."""
    for i in range(LANES):
        t_in, t_out, t_min, t_max = lanes[T_IN + i], lanes[T_OUT + i], lanes[T_MIN + i], lanes[T_MAX + i]
        low, high, flag = lanes[LOW + i], lanes[HIGH + i], lanes[FLAG + i]
        crosses = flag >= 2.0
        outside = ((flag == 1.0) | (flag == 3.0)) != (side < 0)
        # The span between the roots, or the one before them, or all of it
        between = crosses & ~outside
        beyond = crosses & outside
        in1 = low if between & (low >= t_in) else t_in
        out1 = high if between & (high <= t_out) else (low if beyond & (low <= t_out) else t_out)
        slot_in1 = QUADRIC_SLOT if between & (low >= t_in) else lanes[SLOT_IN + i]
        by_root = (between & (high <= t_out)) | (beyond & (low <= t_out))
        slot_out1 = QUADRIC_SLOT if by_root else lanes[SLOT_OUT + i]
        some = (in1 < out1) & (crosses | outside)
        # The span after the roots
        in2 = high if high >= t_in else t_in
        slot_in2 = QUADRIC_SLOT if high >= t_in else lanes[SLOT_IN + i]
        more = beyond & (in2 < t_out) & (t_in < t_out)
        # The first of up to four ends that counts
        c1 = some & (in1 > t_min) & (in1 < t_max)
        c2 = some & (out1 > t_min) & (out1 < t_max)
        c3 = more & (in2 > t_min) & (in2 < t_max)
        c4 = more & (t_out > t_min) & (t_out < t_max)
        t = in1 if c1 else (out1 if c2 else (in2 if c3 else (t_out if c4 else math.inf)))
        slot = slot_in1 if c1 else (slot_out1 if c2 else (slot_in2 if c3 else lanes[SLOT_OUT + i]))
        _take(lanes, i, t, entry, body, slot, 1 if c1 | (~c2 & c3) else 0)


@inline
def _cell_lanes(geometry: Geometry, lanes: Floats, cell: int, entry: int, body: int) -> None:
    for i in range(LANES):
        lanes[T_IN + i], lanes[T_OUT + i] = -math.inf, math.inf
        lanes[SLOT_IN + i], lanes[SLOT_OUT + i] = NO_SLOT, NO_SLOT
    for slot in range(integer(geometry, table.CELL_FIRST, cell), integer(geometry, table.CELL_FIRST, cell + 1)):
        surface = integer(geometry, table.PLANE_SURFACE, slot)
        plane = load_plane(geometry, integer(geometry, table.SURFACE_ROW, surface))
        _plane_lanes(lanes, plane, surface, integer(geometry, table.PLANE_SIDE, slot), slot)
    surface, side = integer(geometry, table.CELL_QUADRIC, cell), integer(geometry, table.CELL_SIDE, cell)
    if surface < 0:
        side = 1
        for i in range(LANES):
            lanes[FLAG + i] = 1.0
    elif integer(geometry, table.SURFACE_KIND, surface) == SPHERE:
        sphere = load_sphere(geometry, integer(geometry, table.SURFACE_ROW, surface))
        _sphere_lanes(lanes, sphere, surface)
    else:
        quadric = load_quadric(geometry, integer(geometry, table.SURFACE_ROW, surface))
        _quadric_lanes(lanes, quadric, surface)
    _cell_hits(lanes, side, entry, body)


@inline
def _meets(geometry: Geometry, lanes: Floats, i: int, box: int) -> bool:
    """Does lane i meet a box, or might it?"""
    at = geometry.places[table.NODE_BOXES, 0] + 48 * (box >> 3) + (box & 7)
    boxes = geometry.floats
    a, b = (boxes[at] - lanes[OX + i]) * lanes[IX + i], (boxes[at + 24] - lanes[OX + i]) * lanes[IX + i]
    first, last = max(min(a, b), lanes[T_MIN + i]), min(max(a, b), min(lanes[T_MAX + i], lanes[BEST + i]))
    a, b = (boxes[at + 8] - lanes[OY + i]) * lanes[IY + i], (boxes[at + 32] - lanes[OY + i]) * lanes[IY + i]
    first, last = max(min(a, b), first), min(max(a, b), last)
    a, b = (boxes[at + 16] - lanes[OZ + i]) * lanes[IZ + i], (boxes[at + 40] - lanes[OZ + i]) * lanes[IZ + i]
    first, last = max(min(a, b), first), min(max(a, b), last)
    return first <= last + (abs(first) + abs(last)) * 4e-16


@helper
def _one_by_one(geometry: Geometry, scratch: Scratch, lanes: Floats, entry: int, body: int, box: int) -> None:
    """Bodies of several cells, and sheets: each lane that meets the box by itself."""
    for i in range(LANES):
        if not lanes[T_MIN + i] < lanes[T_MAX + i] or (box >= 0 and not _meets(geometry, lanes, i, box)):
            continue
        nearest: Hit = (lanes[BEST + i], whole(lanes[BODY + i]), np.int64(-1), np.int64(-1), np.int64(0), False)
        hit = try_entry(geometry, scratch, entry, lane_ray(lanes, i, lanes[T_MAX + i]), nearest)
        if hit[0] < nearest[0] or hit[1] != nearest[1]:
            lanes[BEST + i], lanes[BODY + i], lanes[ENTRY + i], lanes[SLOT + i] = hit[0], body, entry, RESOLVED
            lanes[SURFACE + i], lanes[FACE + i], lanes[SIDE + i] = hit[2], hit[3], hit[4]
            lanes[ENTERS + i] = 1.0 if hit[5] else 0.0


@inline
def _child_lanes(geometry: Geometry, lanes: Floats, box: int) -> int:
    """How many lanes meet a child's box."""
    at = geometry.places[table.NODE_BOXES, 0] + 48 * (box >> 3) + (box & 7)
    boxes = geometry.floats
    lx, ly, lz = boxes[at], boxes[at + 8], boxes[at + 16]
    hx, hy, hz = boxes[at + 24], boxes[at + 32], boxes[at + 40]
    met = 0
    for i in range(LANES):
        a, b = (lx - lanes[OX + i]) * lanes[IX + i], (hx - lanes[OX + i]) * lanes[IX + i]
        first, last = max(min(a, b), lanes[T_MIN + i]), min(max(a, b), min(lanes[T_MAX + i], lanes[BEST + i]))
        a, b = (ly - lanes[OY + i]) * lanes[IY + i], (hy - lanes[OY + i]) * lanes[IY + i]
        first, last = max(min(a, b), first), min(max(a, b), last)
        a, b = (lz - lanes[OZ + i]) * lanes[IZ + i], (hz - lanes[OZ + i]) * lanes[IZ + i]
        first, last = max(min(a, b), first), min(max(a, b), last)
        met += 1 if first <= last + (abs(first) + abs(last)) * 4e-16 else 0
    return met


@inline
def _push_met(geometry: Geometry, scratch: Scratch, lanes: Floats, node: int, top: int) -> int:
    """Put the children that any lane meets on the stack, the nearest along the first lane on top."""
    base = top
    at = geometry.places[table.NODE_BOXES, 0] + 48 * node
    boxes, keys = geometry.floats, scratch.near
    for child in range(8):
        code = integer(geometry, table.NODE_CHILDREN, 8 * node + child)
        if code == 0 or _child_lanes(geometry, lanes, 8 * node + child) == 0:
            continue
        key = (
            (boxes[at + child] + boxes[at + 24 + child]) * lanes[DX + 0]
            + (boxes[at + 8 + child] + boxes[at + 32 + child]) * lanes[DY + 0]
            + (boxes[at + 16 + child] + boxes[at + 40 + child]) * lanes[DZ + 0]
        )
        slot = top
        while slot > base and keys[slot - base - 1] < key:
            keys[slot - base] = keys[slot - base - 1]
            scratch.stack[slot], scratch.stack_t[slot] = scratch.stack[slot - 1], scratch.stack_t[slot - 1]
            slot -= 1
        keys[slot - base] = key
        scratch.stack[slot], scratch.stack_t[slot] = code, float(8 * node + child)
        top += 1
    return top


@inline
def _retire(lanes: Floats) -> int:
    """Make the lanes idle that have met something; returns how many are not."""
    seeking = 0
    for i in range(LANES):
        met = lanes[BEST + i] < math.inf
        lanes[T_MAX + i] = -math.inf if met else lanes[T_MAX + i]
        seeking += 1 if lanes[T_MIN + i] < lanes[T_MAX + i] else 0
    return seeking


@helper
def trace_packet(geometry: Geometry, scratch: Scratch, lanes: Floats, any_hit: bool) -> None:
    """First hits, or any, of the rays put into the lanes (t_min >= 0, or no start); see `packet_hit`."""
    top = push_roots(geometry, scratch.stack, scratch.stack_t, scene_tree(geometry))
    while top > 0:
        top -= 1
        code, place = scratch.stack[top], scratch.stack_t[top]
        if code >= 0:
            top = _push_met(geometry, scratch, lanes, code, top)
            continue
        first, last = leaf_range(code)
        box = int(place) if place >= 0.0 else -1
        for k in range(first, last):
            entry = integer(geometry, table.TREE_ORDER, k)
            kind, index = integer(geometry, table.ENTRY_KIND, entry), integer(geometry, table.ENTRY_INDEX, entry)
            body = integer(geometry, table.ENTRY_BODY, entry)
            if kind == BALL:
                sphere = load_sphere(geometry, integer(geometry, table.SURFACE_ROW, index))
                _ball_lanes(lanes, sphere, index, entry, body)
            elif kind == CELL:
                _cell_lanes(geometry, lanes, index, entry, body)
            else:
                _one_by_one(geometry, scratch, lanes, entry, body, box)
        if any_hit and _retire(lanes) == 0:
            return


@inline
def is_hit(lanes: Floats, i: int) -> bool:
    """Has lane i met anything?"""
    return lanes[BEST + i] < math.inf


@inline
def packet_hit(geometry: Geometry, lanes: Floats, i: int) -> Hit:
    """(t, body, surface, face, side, entered) of lane i."""
    entry, slot, body = whole(lanes[ENTRY + i]), whole(lanes[SLOT + i]), whole(lanes[BODY + i])
    nothing = np.int64(-1)
    if entry < 0:
        return math.inf, nothing, nothing, nothing, np.int64(0), False
    enters = lanes[ENTERS + i] == 1.0
    if slot == RESOLVED:
        surface, face, side = whole(lanes[SURFACE + i]), whole(lanes[FACE + i]), whole(lanes[SIDE + i])
        return lanes[BEST + i], body, surface, face, side, enters
    index = integer(geometry, table.ENTRY_INDEX, entry)
    if integer(geometry, table.ENTRY_KIND, entry) == BALL:
        return lanes[BEST + i], body, index, np.int64(0), np.int64(1), enters
    surface, face, side = slot_face(geometry, index, slot)
    return lanes[BEST + i], body, surface, face, side, enters
