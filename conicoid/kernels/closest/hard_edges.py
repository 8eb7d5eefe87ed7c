"""Hard edges, where two quadrics meet in a curve that no plane contains: a search by bisection of boxes of space.

A box is discarded if it is farther away than the best wall, if no two quadrics with such a curve can both vanish in it,
or if just two can and the distance is nowhere stationary on their curve; at a stationary point the vector from the
query point lies in the plane of both gradients, det(v, g, h) = 0. All other points in the box have been tried before. A
remaining box is halved until the curve in it is nearly straight; then its middle, projected onto the curve, is as near
as the stationary point to second order.
"""

from __future__ import annotations

import math

from ..._jit.decorators import helper, inline
from .. import tables as table
from ..numbers.vectors import dot
from ..programs import leaf_bounds, leaf_high, leaf_low
from ..surface.records import anchor_of
from ..tables import Geometry, integer, poll_halt, whole
from .edges import is_hard
from .form import ROUNDED, SurfaceForm, bend_times, form_at, length_of
from .neighbourhood import (
    BOX,
    LEAF,
    LEAVES,
    LOWER,
    MOST_BOXES,
    PROGRAM,
    SHEET_OF,
    SURFACES,
    UPPER,
    Neighbourhood,
    is_flat,
    limit,
)
from .walls import TANGENT, WallQuery, project_point, sheet_around, sides_around, try_point

_SMALL, _LEAST = 2.0**-25, 2.0**-44
"""Sides of a box at which it is tried: as a share of the distance and of the radius of curvature, and at the latest as
a share of its coordinates."""
_MOST_STEPS, _MOST_SIDES = 40000, 5
"""Most boxes of a search; most surfaces of a box whose sides are tried in all combinations."""
_LESS = 1.0 - 2.0**-40
_AS_NEAR = 1.0 - 2.0**-46
"""Share of the best wall's distance from which on a box is discarded, and its distance becomes the lower bound: the
difference is within the error."""


@inline
def _nearest_in(at: WallQuery, x: float, y: float, z: float, half: float) -> float:
    """Return a lower bound of the distance to a box."""
    dx, dy, dz = (
        max(0.0, abs(x - at.x) - half), max(0.0, abs(y - at.y) - half), max(0.0, abs(z - at.z) - half),
    )  # fmt: skip
    return length_of(dx, dy, dz) * _LESS


@helper
def _push(room: Neighbourhood, top: int, at: WallQuery, x: float, y: float, z: float, half: float) -> int:
    """Push a box on the stack, unless it is too far; return the height. A full stack lowers the lower bound instead."""
    near = _nearest_in(at, x, y, z, half)
    if near > limit(room):
        return top
    if top >= MOST_BOXES:
        room.best[LOWER] = min(room.best[LOWER], near)
        return top
    k = BOX * top
    room.boxes[k], room.boxes[k + 1], room.boxes[k + 2] = x, y, z
    room.boxes[k + 3], room.boxes[k + 4] = half, near
    return top + 1


@inline
def _may_vanish(form: SurfaceForm, half: float) -> bool:
    """True if f may be zero in the box of this half side about the form's point."""
    change = 2.0 * (abs(form.gx) + abs(form.gy) + abs(form.gz)) * half
    bend = abs(form.xx) + abs(form.yy) + abs(form.zz) + 2.0 * (abs(form.xy) + abs(form.xz) + abs(form.yz))
    return abs(form.value) <= form.off + (change + bend * half * half) * (1.0 + ROUNDED)


@inline
def _cross(ax: float, ay: float, az: float, bx: float, by: float, bz: float) -> tuple[float, float, float]:
    """Return a × b."""
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


@helper
def _is_stationary(f: SurfaceForm, h: SurfaceForm, vx: float, vy: float, vz: float, half: float) -> bool:
    """True if D = det(v, g, h) may vanish on the curve in the box about the forms' point, v from the query point.

    On the curve D equals D + m f + n h. With m and n that leave only the gradient along the curve, the range of this
    sum over the box is as narrow as the change of D along the curve, however steep D is across it.
    """
    nx, ny, nz = _cross(f.gx, f.gy, f.gz, h.gx, h.gy, h.gz)
    px, py, pz = _cross(h.gx, h.gy, h.gz, vx, vy, vz)
    qx, qy, qz = _cross(vx, vy, vz, f.gx, f.gy, f.gz)
    ax, ay, az = bend_times(f, px, py, pz)
    bx, by, bz = bend_times(h, qx, qy, qz)
    dx, dy, dz = nx + ax + bx, ny + ay + by, nz + az + bz
    ff, fh = dot(f.gx, f.gy, f.gz, f.gx, f.gy, f.gz), dot(f.gx, f.gy, f.gz, h.gx, h.gy, h.gz)
    hh, square = dot(h.gx, h.gy, h.gz, h.gx, h.gy, h.gz), dot(nx, ny, nz, nx, ny, nz)
    if not square > 1e-12 * (ff * hh):
        return True
    df, dh = dot(dx, dy, dz, f.gx, f.gy, f.gz), dot(dx, dy, dz, h.gx, h.gy, h.gz)
    m, n = (dh * fh - df * hh) / square, (df * fh - dh * ff) / square
    ex, ey, ez = dx + m * f.gx + n * h.gx, dy + m * f.gy + n * h.gy, dz + m * f.gz + n * h.gz
    # A bound of the sum's change over the box: by its gradient, by terms of second and third order, by rounding
    r, g, k = half * 1.7321, math.sqrt(ff), math.sqrt(hh)
    size = length_of(vx, vy, vz)
    most = (abs(ex) + abs(ey) + abs(ez)) * half
    most += (f.size * k + h.size * g + size * f.size * h.size + abs(m) * f.size + abs(n) * h.size) * (r * r)
    most += f.size * h.size * (r * r * r)
    most += 16.0 * ROUNDED * (f.steep * h.steep) * size + abs(m) * f.off + abs(n) * h.off
    return abs(dot(nx, ny, nz, vx, vy, vz) + 0.5 * (m * f.value + n * h.value)) <= most


@inline
def _any_hard(geometry: Geometry, room: Neighbourhood, count: int) -> bool:
    """True if two of the first `count` of room.chosen, which are in rising order, have a hard curve."""
    for i in range(count):
        for j in range(i + 1, count):
            one, other = room.chosen[i], room.chosen[j]
            curved = not is_flat(geometry, room, one) and not is_flat(geometry, room, other)
            if curved and is_hard(room, one, other):
                return True
    return False


@helper
def _around(geometry: Geometry, room: Neighbourhood, x: float, y: float, z: float, half: float) -> int:
    """Write the near surfaces that may meet a box to room.chosen; return how many, 0 if the own one of a sheet may not.

    room.sign gets the side of the others on which the whole box lies.
    """
    count = 0
    for k in range(room.sizes[SURFACES]):
        form = form_at(geometry, room.surface[k], x, y, z)
        room.sign[k] = 1 if form.value > 0.0 else -1
        if _may_vanish(form, half):
            room.sign[k] = 0
            room.chosen[count] = k
            count += 1
        elif k == 0 and room.sizes[SHEET_OF] == 1:
            return 0
    return count


@inline
def _may_have_walls(geometry: Geometry, room: Neighbourhood, count: int) -> bool:
    """True if the body is there for some sides of the chosen surfaces, and not for others; relies on `_around`."""
    if count > _MOST_SIDES:
        return True
    if room.sizes[SHEET_OF] == 1:
        return sheet_around(geometry, room, count)
    values = sides_around(geometry, room, count)
    return values != 0 and values != (whole(1) << (1 << count)) - 1


@inline
def _radius(form: SurfaceForm) -> float:
    """Return about a lower bound of the radii of curvature of a surface."""
    return length_of(form.gx, form.gy, form.gz) / form.size


@helper
def _try_box(
    geometry: Geometry, room: Neighbourhood, at: WallQuery, count: int, x: float, y: float, z: float, half: float
) -> bool:
    """Try the middle of a small box; True if that decides the box."""
    if not 2 <= count <= 3:
        return False
    touch = project_point(geometry, room, count, x, y, z)
    if touch.sine < TANGENT or length_of(touch.x - x, touch.y - y, touch.z - z) > 16.0 * half / touch.sine:
        return False
    size, before = length_of(touch.x - at.x, touch.y - at.y, touch.z - at.z), room.best[LOWER]
    radius = size
    for i in range(count):
        form = form_at(geometry, room.surface[room.chosen[i]], touch.x, touch.y, touch.z)
        if form.size > 0.0:
            radius = min(radius, _radius(form) * touch.sine)
    if half > _SMALL * radius * touch.sine:
        return False
    try_point(geometry, room, at, count, touch.x - at.x, touch.y - at.y, touch.z - at.z, math.inf, 0.0)
    if count == 2 and room.best[LOWER] < before:  # the stationary point lies beside this one
        beside = 8.0 * half / touch.sine
        room.best[LOWER] -= 2.0 * beside * beside / radius
    return True


@inline
def _on_two(room: Neighbourhood, count: int) -> float:
    """Return a lower bound of the distance to points on two of the chosen surfaces: the second smallest of theirs."""
    least, second = math.inf, math.inf
    for i in range(count):
        bound = room.bound[room.chosen[i]]
        least, second = min(least, bound), min(second, max(least, bound))
    return second


@helper
def _search(geometry: Geometry, room: Neighbourhood, at: WallQuery, x: float, y: float, z: float, half: float) -> None:
    """Search a cube."""
    top, steps, whole_cube = _push(room, 0, at, x, y, z, half), 0, half
    while top > 0 and not poll_halt(geometry, steps):
        top, steps = top - 1, steps + 1
        k = BOX * top
        x, y, z, half, near = (
            room.boxes[k], room.boxes[k + 1], room.boxes[k + 2], room.boxes[k + 3], room.boxes[k + 4],
        )  # fmt: skip
        if near > limit(room):
            continue
        count = _around(geometry, room, x, y, z, half)
        if count < 2 or not _any_hard(geometry, room, count) or not _may_have_walls(geometry, room, count):
            continue
        near = max(near, _on_two(room, count))
        if near >= limit(room) * _AS_NEAR:  # a whole curve may be equally near, as from the center of a ball
            room.best[LOWER] = min(room.best[LOWER], near)
            continue
        if count == 2:
            one = form_at(geometry, room.surface[room.chosen[0]], x, y, z)
            other = form_at(geometry, room.surface[room.chosen[1]], x, y, z)
            if not _is_stationary(one, other, x - at.x, y - at.y, z - at.z, half):
                continue
        if half <= _SMALL * near and _try_box(geometry, room, at, count, x, y, z, half):
            continue
        if half <= _LEAST * (abs(x) + abs(y) + abs(z) + whole_cube) or steps > _MOST_STEPS:
            try_point(geometry, room, at, min(count, 3), x - at.x, y - at.y, z - at.z, math.inf, 0.0)
            room.best[LOWER] = min(room.best[LOWER], near)
            continue
        half *= 0.5
        # `away`: the corner of the box that is farthest from the query point, a bit for each axis
        away = 7
        for i in range(3):
            mine, middle = (at.x, x) if i == 0 else ((at.y, y) if i == 1 else (at.z, z))
            if mine < middle:
                away ^= 1 << i
        away ^= 7
        for i in range(8):  # from the corner opposite to `away` to `away` itself, which lies on top
            side = (i ^ away) ^ 7
            dx = half if side & 1 else -half
            dy = half if side & 2 else -half
            dz = half if side & 4 else -half
            top = _push(room, top, at, x + dx, y + dy, z + dz, half)


@helper
def reach_of_leaves(geometry: Geometry, room: Neighbourhood, at: WallQuery) -> float:
    """Return the largest distance along an axis to which the boxes of the near leaves reach; inf without a program."""
    most, program = 0.0, whole(room.sizes[PROGRAM])
    if program < 0:
        return math.inf
    bounds, first = leaf_bounds(geometry, program), integer(geometry, table.PROGRAM_LEAF, program)
    for k in range(room.sizes[LEAVES]):
        number = whole(room.leaves[4 * k + LEAF]) - first
        for axis in range(3):
            low, high = leaf_low(geometry, bounds, number, axis), leaf_high(geometry, bounds, number, axis)
            mine = at.x if axis == 0 else (at.y if axis == 1 else at.z)
            most = max(most, max(mine - low, high - mine))
    return most


@helper
def try_hard_edges(geometry: Geometry, room: Neighbourhood, at: WallQuery) -> None:
    """Try all hard edges, and the corners on them; without a bound of the distance, in growing cubes."""
    half = min(limit(room), reach_of_leaves(geometry, room, at))
    if half < math.inf:
        _search(geometry, room, at, at.x, at.y, at.z, half * (1.0 + 2.0**-20))
        return
    half = 1.0
    for k in range(room.sizes[SURFACES]):
        if integer(geometry, table.SURFACE_KIND, room.surface[k]) != table.PLANE:
            cx, cy, cz = anchor_of(geometry, room.surface[k])
            half = max(half, 4.0 * length_of(cx - at.x, cy - at.y, cz - at.z))
        if room.bound[k] < math.inf:
            half = max(half, 4.0 * room.bound[k])
    for _ in range(12):
        _search(geometry, room, at, at.x, at.y, at.z, half)
        if room.best[UPPER] <= half:  # the nearest wall lies within the cube
            return
        half *= 16.0
    room.best[LOWER] = min(room.best[LOWER], half)
