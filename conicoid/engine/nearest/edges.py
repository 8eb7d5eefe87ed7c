"""Edges and corners of a body, tried as nearest walls: two or three surfaces that meet."""

from __future__ import annotations

import math

from ...compiler.jit import helper, inline
from .. import tables as table
from ..culling.leaf_bounds import leaf_bounds, leaf_high, leaf_low
from ..numbers.vectors import dot
from ..surface.records import anchor_of
from ..tables import Geometry, integer, whole
from .form import Form, bent, form_at, length_of
from .gather import is_flat
from .pencil import HARD, Planes, shared_planes
from .room import LEAF, LEAVES, LOWER, MOST_PAIRED, PROGRAM, SHEET_OF, SURFACES, Room, limit
from .stationary import known_off, try_conic
from .touch import touch
from .walls import SURE, Query, try_point

_PARALLEL = 2.0**-40
_ALONG = 2.0**-44
_MORE = 1.0 + 2.0**-30
_ENDED = 2.0**-36
"""Share of the size of a point on several surfaces by which it may be off where Newton's steps have ended."""
KNOWN = 2.0**-42
"""Share of the sizes of points by which a conic of two quadrics may be off, whatever their angle is."""


@inline
def plane_about(form: Form) -> tuple[float, float, float, float]:
    """A plane surface as n·v = h, of a unit vector n."""
    return 2.0 * form.gx, 2.0 * form.gy, 2.0 * form.gz, -form.value


@inline
def planes_of_pair(geometry: Geometry, room: Room, at: Query, i: int, j: int) -> Planes:
    """The planes that hold where two near surfaces meet, i < j: a plane itself, or those of two quadrics."""
    if is_flat(geometry, room, i):
        nx, ny, nz, h = plane_about(form_at(geometry, room.surface[i], at.x, at.y, at.z))
        return Planes(1, nx, ny, nz, h, 0.0, 0.0, 0.0, 0.0)
    if is_flat(geometry, room, j):  # a sheet's own quadric stands before planes
        nx, ny, nz, h = plane_about(form_at(geometry, room.surface[j], at.x, at.y, at.z))
        return Planes(1, nx, ny, nz, h, 0.0, 0.0, 0.0, 0.0)
    return shared_planes(geometry, room.surface[i], room.surface[j], at.x, at.y, at.z)


@inline
def plane_of(planes: Planes, k: int) -> tuple[float, float, float, float]:
    """One of the planes."""
    if k == 0:
        return planes.x0, planes.y0, planes.z0, planes.h0
    return planes.x1, planes.y1, planes.z1, planes.h1


@inline
def _chosen(room: Room, i: int, j: int, k: int) -> None:
    room.chosen[0], room.chosen[1], room.chosen[2] = i, j, k


@inline
def line_of_planes(
    ax: float, ay: float, az: float, g: float, bx: float, by: float, bz: float, h: float
) -> tuple[float, float, float, float, float, float]:
    """(foot, unit direction) of the line a·v = g, b·v = h; a direction of zeros where they are parallel."""
    dx, dy, dz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    square = dot(dx, dy, dz, dx, dy, dz)
    if square <= _PARALLEL * _PARALLEL:
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    # (g b - h a) × d / |d|², which is across d
    mx, my, mz = g * bx - h * ax, g * by - h * ay, g * bz - h * az
    x, y, z = my * dz - mz * dy, mz * dx - mx * dz, mx * dy - my * dx
    root = math.sqrt(square)
    return x / square, y / square, z / square, dx / root, dy / root, dz / root


@helper
def try_edge(geometry: Geometry, room: Room, at: Query, i: int, j: int) -> bool:
    """Try where two near surfaces meet, i < j; is their curve a hard one, which no plane holds?"""
    if is_flat(geometry, room, i) and is_flat(geometry, room, j):
        ax, ay, az, g = plane_about(form_at(geometry, room.surface[i], at.x, at.y, at.z))
        bx, by, bz, h = plane_about(form_at(geometry, room.surface[j], at.x, at.y, at.z))
        x, y, z, dx, dy, dz = line_of_planes(ax, ay, az, g, bx, by, bz, h)
        if (dx != 0.0) | (dy != 0.0) | (dz != 0.0):
            _chosen(room, i, j, j)
            try_point(geometry, room, at, 2, x, y, z, math.inf, 0.0)
        return False
    planes = planes_of_pair(geometry, room, at, i, j)
    if planes.number == HARD:
        return True
    curved = i if is_flat(geometry, room, j) else j
    form = form_at(geometry, room.surface[curved], at.x, at.y, at.z)
    known = math.inf if is_flat(geometry, room, i) or is_flat(geometry, room, j) else KNOWN
    for k in range(planes.number):
        nx, ny, nz, h = plane_of(planes, k)
        if abs(h) <= limit(room) * _MORE:
            _chosen(room, i, j, j)
            try_conic(geometry, room, at, 2, form, nx, ny, nz, h, known)
    if planes.number == 2:  # where the two conics cross
        _try_line(geometry, room, at, planes, planes, i, j, j, 2)
    return False


@inline
def _beside_anchor(
    geometry: Geometry, room: Room, at: Query, k: int, x: float, y: float, z: float, dx: float, dy: float, dz: float
) -> float:
    """How far along a line a near surface's anchor is: about there a quadric's terms are no larger than need be."""
    if is_flat(geometry, room, k):
        return 0.0
    ax, ay, az = anchor_of(geometry, room.surface[k])
    return dot(dx, dy, dz, (ax - at.x) - x, (ay - at.y) - y, (az - at.z) - z)


@helper
def _try_line(
    geometry: Geometry, room: Room, at: Query, one: Planes, other: Planes, i: int, j: int, k: int, count: int
) -> None:
    """Try where the lines of two planes meet the last of i, j, k, or a sheet's own surface i where that is curved."""
    curved = i if is_flat(geometry, room, k) and not is_flat(geometry, room, i) else k
    same = count == 2
    for p in range(one.number):
        ax, ay, az, g = plane_of(one, p)
        for q in range(p + 1 if same else 0, other.number):
            bx, by, bz, h = plane_of(other, q)
            x, y, z, dx, dy, dz = line_of_planes(ax, ay, az, g, bx, by, bz, h)
            if not length_of(x, y, z) <= limit(room) * _MORE or not (dx != 0.0) | (dy != 0.0) | (dz != 0.0):
                continue
            along = _beside_anchor(geometry, room, at, curved, x, y, z, dx, dy, dz)
            sx, sy, sz = x + along * dx, y + along * dy, z + along * dz
            form = form_at(geometry, room.surface[curved], at.x + sx, at.y + sy, at.z + sz)
            ux, uy, uz = bent(form, dx, dy, dz)
            a, b, c = dot(ux, uy, uz, dx, dy, dz), dot(form.gx, form.gy, form.gz, dx, dy, dz), form.value
            root = math.sqrt(max(b * b - a * c, 0.0))
            if b * b - a * c < -(2.0**-30) * (b * b + abs(a * c)):
                continue
            # What is as small as rounding makes it would be met beyond all that floats tell apart
            a = a if abs(a) > _ALONG * form.size else 0.0
            b = b if abs(b) > _ALONG * form.steep else 0.0
            far = -(b + math.copysign(root, b))
            for which in range(2):
                over, under = (far, a) if which == 0 else (c, far)
                t = along + over / under if under != 0.0 else math.inf
                if not abs(t) <= limit(room) * _MORE:
                    continue
                _chosen(room, i, j, k)
                px, py, pz = x + t * dx, y + t * dy, z + t * dz
                known = known_off(at, KNOWN, px, py, pz) if count == 2 else math.inf
                least = length_of(x, y, z) - known_off(at, KNOWN, x, y, z)
                try_point(geometry, room, at, count, px, py, pz, known, least)


@helper
def try_corners(geometry: Geometry, room: Room, at: Query, i: int, j: int) -> None:
    """Try where two near surfaces meet a third one behind them, i < j < k. Curves that no plane holds are left out."""
    one = planes_of_pair(geometry, room, at, i, j)
    if one.number <= 0:
        return
    flat = is_flat(geometry, room, i) and is_flat(geometry, room, j)
    for k in range(j + 1, room.sizes[SURFACES]):
        if not room.bound[k] <= limit(room):
            continue
        if flat:
            nx, ny, nz, h = plane_about(form_at(geometry, room.surface[j], at.x, at.y, at.z))
            _try_line(geometry, room, at, one, Planes(1, nx, ny, nz, h, 0.0, 0.0, 0.0, 0.0), i, j, k, 3)
            continue
        # i, j and k: one of the curves is on planes with j, or with i, as the other is
        curved_first = not is_flat(geometry, room, i)
        other = planes_of_pair(geometry, room, at, i, k) if curved_first else planes_of_pair(geometry, room, at, j, k)
        if other.number > 0:
            _try_line(geometry, room, at, one, other, i, j, k, 3)


@inline
def is_hard(room: Room, i: int, j: int) -> bool:
    """Is the curve of two near surfaces, i < j, in no plane? `try_edges` has noted it."""
    return j >= MOST_PAIRED or room.hard[MOST_PAIRED * i + j] == 1


@inline
def _note(room: Room, i: int, j: int, hard: bool) -> bool:
    """Note whether the curve of two near surfaces is in no plane."""
    if j < MOST_PAIRED:
        room.hard[MOST_PAIRED * i + j] = 1 if hard else 0
    return hard


@helper
def _try_from(
    geometry: Geometry, room: Room, at: Query, i: int, j: int, k: int, vx: float, vy: float, vz: float
) -> None:
    """Try where Newton's steps lead to from x + v: if that is a wall, others are nearer than it.

    What is not sure to be one says nothing; nor does where they have not ended, as surfaces need not meet at all.
    """
    before, count = room.best[LOWER], 2 if j == k else 3
    _chosen(room, i, j, k)
    found = touch(geometry, room, count, at.x + vx, at.y + vy, at.z + vz)
    if found.off > _ENDED * (abs(found.x) + abs(found.y) + abs(found.z)):
        return
    vx, vy, vz = found.x - at.x, found.y - at.y, found.z - at.z
    if try_point(geometry, room, at, count, vx, vy, vz, math.inf, 0.0) != SURE:
        room.best[LOWER] = before


@helper
def _into_leaves(geometry: Geometry, room: Room, x: float, axis: int) -> float:
    """How far x is from the nearest place along an axis that the boxes of the near leaves reach."""
    low, high, program = math.inf, -math.inf, whole(room.sizes[PROGRAM])
    if program >= 0:
        bounds, first = leaf_bounds(geometry, program), integer(geometry, table.PROGRAM_LEAF, program)
        for k in range(room.sizes[LEAVES]):
            number = whole(room.leaves[4 * k + LEAF]) - first
            low = min(low, leaf_low(geometry, bounds, number, axis))
            high = max(high, leaf_high(geometry, bounds, number, axis))
    return (low - x if x < low else min(high - x, 0.0)) if low <= high else 0.0


@helper
def _try_hard_from_beside(geometry: Geometry, room: Room, at: Query) -> None:
    """Try curves that no plane holds, and corners on them: the better the first guess, the fewer boxes.

    From the nearest place of a box around the body, as from afar Newton's steps halve the way and no more.
    """
    vx, vy, vz = (
        _into_leaves(geometry, room, at.x, 0), _into_leaves(geometry, room, at.y, 1),
        _into_leaves(geometry, room, at.z, 2),
    )  # fmt: skip
    count = min(room.sizes[SURFACES], MOST_PAIRED)
    for i in range(count):
        for j in range(i + 1, count):
            if not is_hard(room, i, j):
                continue
            if i == 0 or room.sizes[SHEET_OF] == 0:
                _try_from(geometry, room, at, i, j, j, vx, vy, vz)
            for k in range(count):
                if k != i and k != j and (room.sizes[SHEET_OF] == 0 or i == 0 or k == 0):
                    first, last = min(i, k), max(j, k)
                    _try_from(geometry, room, at, first, max(min(i, j), min(max(i, j), k)), last, vx, vy, vz)


@helper
def try_edges(geometry: Geometry, room: Room, at: Query) -> bool:
    """Try all edges, then all corners, of what is near; are there curves of two quadrics that no plane holds?"""
    sheet, hard = room.sizes[SHEET_OF] == 1, False
    count = room.sizes[SURFACES]
    last = 1 if sheet else count
    for i in range(count):
        for j in range(i + 1, count):
            _note(room, i, j, False)
            if max(room.bound[i], room.bound[j]) <= limit(room):
                if i < last:
                    hard = _note(room, i, j, try_edge(geometry, room, at, i, j)) or hard
                else:
                    hard = _note(room, i, j, planes_of_pair(geometry, room, at, i, j).number == HARD) or hard
    for i in range(last):
        for j in range(i + 1, count):
            if max(room.bound[i], room.bound[j]) <= limit(room):
                try_corners(geometry, room, at, i, j)
    if hard:
        _try_hard_from_beside(geometry, room, at)
    return hard
