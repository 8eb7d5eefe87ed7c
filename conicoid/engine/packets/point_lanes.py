"""Points in lanes: on which side of a surface 64 of them are, and whether a cell holds them.

A surface is first asked about the box around all points, which often says the same of all of them; else the formulas
of single points (body/contains.py) go over the lanes. What floats leave open is marked, and asked point by point.
"""

from __future__ import annotations

import numpy as np

from ...compiler.jit import choose, helper, inline
from .. import tables as table
from ..body.contains import plane_value, sphere_value
from ..faces import cell_side, plane_side
from ..surface.decide import Rest, rest_number, rest_of_quadric
from ..surface.quadric import Quadric, own_coordinates, quadric_rounding, quadric_value
from ..surface.records import load_plane, load_quadric, load_sphere, plane_limits
from ..tables import PLANE, SPHERE, Floats, Geometry, integer
from .lanes import LANES

X, Y, Z, SOUGHT, OUT, UNSURE, LOST, AFTER = (np.uint64(row) for row in range(0, 8 * LANES, LANES))
"""Rows: the points; 1 where a body is sought; where a cell does not hold the point; where that is not certain; where
the body is not certain; the body after which others are sought."""
BOX = 8 * LANES
"""Behind the rows: the middle of the box around the points, and half its sides."""
SIZE = BOX + 6
EVERY = np.uint64(LANES)

NONE, SOME, ALL = 0, 1, 2
"""Of the points of a block, on the inner side."""
_LOOSE = 4.0
"""By so much is the rounding of a whole box taken larger than that of a point."""


@inline
def _sided(value: float, off: float) -> int:
    """ALL where value < -off for certain, NONE where value > off, else SOME."""
    return NONE if value > off else (ALL if value < -off else SOME)


@inline
def _plane_of_box(geometry: Geometry, row: int, inner: float, room: Floats) -> int:
    """On the inner side of a plane, of the box."""
    plane = load_plane(geometry, row)
    value, off = plane_value(plane, plane_limits(geometry, row), room[BOX], room[BOX + 1], room[BOX + 2])
    reach = abs(plane.nx) * room[BOX + 3] + abs(plane.ny) * room[BOX + 4] + abs(plane.nz) * room[BOX + 5]
    far, widest = _corner(plane.ax, plane.ay, plane.az, room), plane_limits(geometry, row)
    _, off = plane_value(plane, widest, far[0], far[1], far[2])
    return _sided(value * inner, reach * (1.0 + 1e-9) + _LOOSE * off)


@inline
def _corner(ax: float, ay: float, az: float, room: Floats) -> tuple[float, float, float]:
    """A point at least as far from an anchor, along each axis, as any of the box."""
    return (
        ax + (abs(room[BOX] - ax) + room[BOX + 3]),
        ay + (abs(room[BOX + 1] - ay) + room[BOX + 4]),
        az + (abs(room[BOX + 2] - az) + room[BOX + 5]),
    )


@inline
def _sphere_of_box(geometry: Geometry, row: int, inner: float, room: Floats) -> int:
    """On the inner side of a sphere, of the box: f(c + d) - f(c) = 2 (c - centre)·d + d·d."""
    sphere = load_sphere(geometry, row)
    hx, hy, hz = room[BOX + 3], room[BOX + 4], room[BOX + 5]
    value, _ = sphere_value(sphere, room[BOX], room[BOX + 1], room[BOX + 2])
    px, py, pz = abs(room[BOX] - sphere.x), abs(room[BOX + 1] - sphere.y), abs(room[BOX + 2] - sphere.z)
    reach = 2.0 * (px * hx + py * hy + pz * hz) + (hx * hx + hy * hy + hz * hz)
    far = _corner(sphere.x, sphere.y, sphere.z, room)
    return _sided(value * inner, reach * (1.0 + 1e-9) + _LOOSE * sphere_value(sphere, far[0], far[1], far[2])[1])


@inline
def _spread(w0: float, w1: float, w2: float, room: Floats) -> float:
    """By how much w·x varies over the box, to either side."""
    return abs(w0) * room[BOX + 3] + abs(w1) * room[BOX + 4] + abs(w2) * room[BOX + 5]


@inline
def _rounding(geometry: Geometry, rest: Rest, quadric: Quadric, row: int, x: float, y: float, z: float) -> float:
    """`quadric_rounding` of a quadric of the table."""
    at = rest_of_quadric(geometry, row)
    return quadric_rounding(
        quadric, x, y, z, rest_number(rest, at), rest_number(rest, at + 1), rest_number(rest, at + 2)
    )


@inline
def _quadric_of_box(geometry: Geometry, rest: Rest, row: int, inner: float, room: Floats) -> int:
    """On the inner side of a quadric, of the box: f changes by 2 (s y + b)·e + s e² for y + e, |e| up to the spread."""
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
def side_of_box(geometry: Geometry, rest: Rest, surface: int, side: int, room: Floats) -> int:
    """ALL, SOME or NONE of the box is on the inner side of a surface."""
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
    """The side of lane i, its value being positive outside; returns whether it is still in, as far as is known."""
    room[OUT + i] = choose(value > off, 1.0, room[OUT + i])
    room[UNSURE + i] = choose(abs(value) > off, room[UNSURE + i], 1.0)
    return (room[OUT + i] == 0.0) & (room[SOUGHT + i] == 1.0)


@helper
def sides_of_lanes(geometry: Geometry, rest: Rest, surface: int, side: int, room: Floats) -> int:
    """Mark OUT and UNSURE by a surface; returns how many lanes may still be in."""
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
    """No lane is out, or unsure."""
    for i in range(EVERY):
        room[OUT + i], room[UNSURE + i] = 0.0, 0.0


@inline
def _face(geometry: Geometry, cell: int, slot: int, last: int) -> tuple[int, int]:
    """(surface, inner side) of a face of a cell, the quadric's being the last."""
    if slot == last:
        return integer(geometry, table.CELL_QUADRIC, cell), cell_side(geometry, cell)
    return integer(geometry, table.PLANE_SURFACE, slot), plane_side(geometry, slot)


@helper
def cell_of_lanes(geometry: Geometry, rest: Rest, cell: int, room: Floats) -> int:
    """Which lanes a cell holds: NONE, ALL, or SOME, and then OUT and UNSURE say it of each.

    NONE and ALL are certain. Where OUT is 0 and UNSURE is 1, the point is to be asked by itself.
    """
    first, last = integer(geometry, table.CELL_FIRST, cell), integer(geometry, table.CELL_FIRST, cell + 1)
    end = last + 1 if integer(geometry, table.CELL_QUADRIC, cell) >= 0 else last
    for slot in range(end - 1, first - 1, -1):  # the quadric says most
        surface, side = _face(geometry, cell, slot, last)
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
def ball_of_lanes(geometry: Geometry, rest: Rest, surface: int, room: Floats) -> int:
    """`cell_of_lanes` of a ball."""
    of_box = side_of_box(geometry, rest, surface, 1, room)
    if of_box != SOME:
        return of_box
    clear_sides(room)
    return NONE if sides_of_lanes(geometry, rest, surface, 1, room) == 0 else SOME
