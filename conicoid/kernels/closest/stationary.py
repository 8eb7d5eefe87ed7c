"""Points where the distance to a quadric, or to a conic in a plane of one, is stationary, tried as nearest walls."""

from __future__ import annotations

import math
from typing import NamedTuple

from ..._jit.decorators import helper, inline
from ..numbers.vectors import dot
from ..tables import Geometry
from .form import (
    ROUNDED,
    Directions,
    SurfaceForm,
    bend_times,
    form_at,
    jacobi_rotation,
    length_of,
    perpendicular_axes,
    reverse_axes,
    rounding_within,
    value_along,
)
from .neighbourhood import Neighbourhood, equation_of, limit
from .secular import (
    FLAT,
    NONE,
    Secular,
    flatten_secular,
    least_bend,
    nearest_root,
    negate_secular,
    next_root,
    place_above,
    place_below,
    root_above,
)
from .walls import CERTAIN_WALL, WallQuery, try_point

_ROOTS = 6  # most stationary points of a quadric
_FAR = 2.0**-30  # the value at the center, as a share of that at the query point, below which the point is far away
_NOWHERE = 2.0**-100  # least w of the search, as a share of the pole


class EquationFrame(NamedTuple):
    """The frame of an equation: (v0, v1, v2) is the point x + base + v0 e0 + v1 e1 + v2 e2, x being the query point."""

    base_x: float
    base_y: float
    base_z: float
    along: Directions
    known: float  # error of a found point, as a share of the sizes of query point and displacement (`try_point`)


@inline
def _place(frame: EquationFrame, v0: float, v1: float, v2: float) -> tuple[float, float, float]:
    """Return the displacement from the query point."""
    e = frame.along
    return (
        frame.base_x + dot(e.x0, e.x1, e.x2, v0, v1, v2),
        frame.base_y + dot(e.y0, e.y1, e.y2, v0, v1, v2),
        frame.base_z + dot(e.z0, e.z1, e.z2, v0, v1, v2),
    )


@inline
def _try(
    geometry: Geometry,
    room: Neighbourhood,
    at: WallQuery,
    count: int,
    frame: EquationFrame,
    x: float,
    y: float,
    z: float,
) -> int:
    """Try the point at displacement (x, y, z)."""
    return try_point(geometry, room, at, count, x, y, z, rounding_share(at, frame.known, x, y, z), 0.0)


@inline
def rounding_share(at: WallQuery, share: float, x: float, y: float, z: float) -> float:
    """Return a share of the sizes of the query point and of a displacement; infinite for an infinite share."""
    return share * ((abs(at.x) + abs(at.y) + abs(at.z)) + (abs(x) + abs(y) + abs(z))) if share < math.inf else share


@helper
def _try_above(
    geometry: Geometry,
    room: Neighbourhood,
    at: WallQuery,
    count: int,
    e: Secular,
    frame: EquationFrame,
    center: float,
) -> int:
    """Try the nearest point of the whole surface; `center` is that of `nearest_root`."""
    w = nearest_root(e, center) if center == center else root_above(e)
    if w == NONE:
        return 0
    v0, v1, v2 = place_above(e, w)
    x, y, z = _place(frame, v0, v1, v2)
    return _try(geometry, room, at, count, frame, x, y, z)


@helper
def _try_below(
    geometry: Geometry, room: Neighbourhood, at: WallQuery, count: int, e: Secular, frame: EquationFrame
) -> None:
    """Try the other local minima on one side of zero."""
    pole = -e.a0
    if not pole > 0.0 or not pole > -e.a1:
        return
    # A root at w moves the point by at least |g0| / w, so one within the limit has w >= |g0| / limit
    start, room_left = pole * _NOWHERE, limit(room)
    if room_left < math.inf and room_left > 0.0:
        start = max(start, abs(e.g0) / room_left * (1.0 - 2.0**-20))
    for _ in range(_ROOTS):
        if not start < pole - max(0.0, -e.a1):
            return
        w, start = next_root(e, start)
        if w != NONE:
            v0, v1, v2 = place_below(e, w)
            x, y, z = _place(frame, v0, v1, v2)
            if length_of(x, y, z) * (1.0 - 2.0**-20) <= limit(room):
                _try(geometry, room, at, count, frame, x, y, z)


@inline
def _center(g: float, a: float) -> float:
    """Return the place of the extremum of a parabola; 0 for a line."""
    return -g / a if abs(a) > FLAT else 0.0


@inline
def _lies_far(e: Secular) -> bool:
    """Return whether the value at the center seems to be tiny beside that at the query point, and the axes are clear.

    Each coefficient of these terms of about 1 is rounding alone, or far larger than what counts as zero.
    """
    b0, b1, b2 = abs(e.a0), abs(e.a1), abs(e.a2)
    clear = ((b0 <= 2.0**-48) | (b0 >= 2.0**-20)) & ((b1 <= 2.0**-48) | (b1 >= 2.0**-20))
    clear &= (b2 <= 2.0**-48) | (b2 >= 2.0**-20)
    there = e.value + (_center(e.g0, e.a0) * e.g0 + _center(e.g1, e.a1) * e.g1 + _center(e.g2, e.a2) * e.g2)
    return clear & (abs(there) < 2.0 * _FAR * abs(e.value))


@helper
def try_stationary(
    geometry: Geometry,
    room: Neighbourhood,
    at: WallQuery,
    count: int,
    k: int,
    form: SurfaceForm,
    e: Secular,
    frame: EquationFrame,
    over: Secular,
    back: EquationFrame,
) -> None:
    """Try all local minima of the distance on f = 0, whose points lie on the first `count` surfaces of room.chosen.

    f is that of near surface k, and `form` it about the query point. `over` and `back` are the equation of -f, and its
    frame. Besides the roots it tries the point where the gradient vanishes: the apex of a cone, or the crossing of a
    conic that is two lines.
    """
    # About the distance, for `least_bend`
    length = abs(e.value) / (length_of(e.g0, e.g1, e.g2) + math.sqrt(abs(e.value)) + 1e-300)
    plain, other, found = least_bend(e, length), least_bend(over, length), 0
    value = error = center = math.nan
    if _lies_far(e):
        # Values about the query point are rounded by more than the surface is wide
        x, y, z = _place(frame, _center(e.g0, e.a0), _center(e.g1, e.a1), _center(e.g2, e.a2))
        about, scale = form_at(geometry, room.surface[k], at.x + x, at.y + y, at.z + z), 1.0 / form.size
        moved = rounding_share(at, 2.0**-50, x, y, z)
        # A cone's value is 0 there, and a slender one would count as a rod of no width
        wide = abs(about.value) > max(64.0 * about.off, 16.0 * form.size * moved * moved)
        if wide & (abs(about.value) * scale < _FAR * abs(e.value)):
            steep = length_of(about.gx, about.gy, about.gz)
            value, error = about.value, about.off + (2.0 * steep + form.size * moved) * moved
            center, least = value * scale, ROUNDED * form.steep * scale
            plain, other = flatten_secular(plain, least), flatten_secular(other, least)
    if e.value > 0.0:
        found = _try_above(geometry, room, at, count, plain, frame, center)
    elif e.value < 0.0:
        found = _try_above(geometry, room, at, count, other, back, -center)
    else:
        found = _try(geometry, room, at, count, frame, frame.base_x, frame.base_y, frame.base_z)
    if found == CERTAIN_WALL:
        return
    # Far outside of an ellipse there is one local minimum
    elliptic = (e.a0 >= -FLAT) if e.value > 0.0 else (e.a2 <= FLAT)
    if not (elliptic and center == center):
        _try_below(geometry, room, at, count, plain, frame)
        _try_below(geometry, room, at, count, other, back)
    x, y, z = _place(frame, _center(e.g0, e.a0), _center(e.g1, e.a1), _center(e.g2, e.a2))
    if center != center:
        value, error = value_along(form, x, y, z), rounding_within(form, length_of(x, y, z))
    if abs(value) <= 64.0 * error:
        _try(geometry, room, at, count, frame, x, y, z)


@helper
def try_face(geometry: Geometry, room: Neighbourhood, at: WallQuery, k: int, flat: bool) -> None:
    """Try the local minima of the distance to a near surface."""
    form = form_at(geometry, room.surface[k], at.x, at.y, at.z)
    room.chosen[0] = k
    if flat:
        h = -2.0 * form.value
        try_point(geometry, room, at, 1, h * form.gx, h * form.gy, h * form.gz, math.inf, 0.0)
        return
    e, along = equation_of(form)
    frame, back = (
        EquationFrame(0.0, 0.0, 0.0, along, math.inf),
        EquationFrame(0.0, 0.0, 0.0, reverse_axes(along), math.inf),
    )
    try_stationary(geometry, room, at, 1, k, form, e, frame, negate_secular(e), back)


@helper
def try_conic(
    geometry: Geometry,
    room: Neighbourhood,
    at: WallQuery,
    count: int,
    k: int,
    form: SurfaceForm,
    nx: float,
    ny: float,
    nz: float,
    h: float,
    known: float,
) -> None:
    """Try the local minima of the distance to the conic of near surface k, f = 0, n·v = h; n is a unit vector."""
    bx, by, bz = h * nx, h * ny, h * nz
    cx, cy, cz = bend_times(form, bx, by, bz)
    gx, gy, gz = form.gx + cx, form.gy + cy, form.gz + cz
    ux, uy, uz, vx, vy, vz = perpendicular_axes(nx, ny, nz)
    au, bu, cu = bend_times(form, ux, uy, uz)
    av, bv, cv = bend_times(form, vx, vy, vz)
    p, q, mixed = dot(au, bu, cu, ux, uy, uz), dot(av, bv, cv, vx, vy, vz), dot(au, bu, cu, vx, vy, vz)
    c, s, t = jacobi_rotation(p, q, mixed)
    # One Jacobi rotation makes the quadratic form of the plane diagonal
    p, q = p - t * mixed, q + t * mixed
    ux, uy, uz, vx, vy, vz = (
        c * ux - s * vx, c * uy - s * vy, c * uz - s * vz, s * ux + c * vx, s * uy + c * vy, s * uz + c * vz,
    )  # fmt: skip
    if q < p:
        p, q, ux, uy, uz, vx, vy, vz = q, p, vx, vy, vz, ux, uy, uz
    scale = 1.0 / form.size if form.size > 0.0 else 1.0
    value, gu, gv = value_along(form, bx, by, bz) * scale, dot(ux, uy, uz, gx, gy, gz), dot(vx, vy, vz, gx, gy, gz)
    gu, gv, p, q = gu * scale, gv * scale, p * scale, q * scale
    # Two terms: the third axis repeats the second one's pole, with no share in the gradient
    e = Secular(value, gu, gv, 0.0, p, q, q)
    over = Secular(-value, -gv, -gu, 0.0, -q, -p, -p)
    frame = EquationFrame(bx, by, bz, Directions(ux, uy, uz, vx, vy, vz, 0.0, 0.0, 0.0), known)
    back = EquationFrame(bx, by, bz, Directions(vx, vy, vz, ux, uy, uz, 0.0, 0.0, 0.0), known)
    try_stationary(geometry, room, at, count, k, form, e, frame, over, back)
