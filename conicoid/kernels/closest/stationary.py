"""Points where the distance to a quadric, or to a conic in a plane of one, is stationary, tried as nearest walls."""

from __future__ import annotations

import math
from typing import NamedTuple

from ..._jit.decorators import helper, inline
from .. import tables as table
from ..numbers.vectors import dot
from ..surface.records import anchor_of, load_quadric, load_sphere
from ..tables import SPHERE, Geometry, integer
from .form import (
    ROUNDED,
    Axes,
    Directions,
    SurfaceForm,
    bend_between,
    form_at,
    jacobi_rotation,
    length_of,
    parts_along,
    perpendicular_axes,
    principal_axes,
    reverse_axes,
    sort_axes,
)
from .neighbourhood import LOWER, Neighbourhood, WallQuery, limit
from .projection import settle_point
from .secular import (
    NONE,
    OPEN,
    Secular,
    is_cone,
    least_bend,
    negate_secular,
    next_root,
    place_above,
    place_below,
    root_above,
)
from .walls import CERTAIN_WALL, SLANTED, UNSETTLED, WallCandidate, candidate, try_point

_ROOTS = 6  # most stationary points of a quadric
_NOWHERE = 2.0**-100  # least w of the search, as a share of the pole
_POINT_SHARE = 2.0**-44  # share of its terms below which a value counts as zero: of a circle's square, at a center
_APEX = 2.0**-27  # distance, as a share of that of the query point, within which a stationary point is the apex
_FLATTEST = 2.0**-50  # least bend, as a share of the pole, of a surface whose local minima are all found
_ACROSS = 2.0**-50  # largest cosine between rows of a record that are its principal axes
_NO_BEND = 2.0**-48
"""Size of a coefficient, as a share of its terms, below which it counts as zero where it was computed from others."""


class EquationFrame(NamedTuple):
    """The frame of an equation: (v0, v1, v2) is the point x + base + v0 e0 + v1 e1 + v2 e2, x being the query point."""

    base_x: float
    base_y: float
    base_z: float
    along: Directions
    known: float  # error of a conic's plane, as a share of the sizes of query point and displacement; infinite for none
    curved: int  # the near surface


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
    slack: float,
) -> int:
    """Try the point at displacement (x, y, z); `slack` is that of a `WallCandidate`."""
    known = conic_error(geometry, room, at, frame, x, y, z)
    found = try_point(geometry, room, at, count, WallCandidate(x, y, z, known, 0.0, slack))
    if found == SLANTED:
        x, y, z, slack = settle_point(geometry, room, at, count, x, y, z)
        found = try_point(geometry, room, at, count, WallCandidate(x, y, z, math.inf, 0.0, slack))
    return found


@inline
def conic_error(
    geometry: Geometry, room: Neighbourhood, at: WallQuery, frame: EquationFrame, x: float, y: float, z: float
) -> float:
    """Return an error bound of the point at a displacement, on the conic of a surface in a plane known so well."""
    if not frame.known < math.inf:
        return math.inf
    form = form_at(geometry, room.surface[frame.curved], at.x + x, at.y + y, at.z + z)
    e = frame.along
    u, v = dot(e.x0, e.y0, e.z0, form.gx, form.gy, form.gz), dot(e.x1, e.y1, e.z1, form.gx, form.gy, form.gz)
    inner = math.sqrt(u * u + v * v)
    if not inner > 0.0:
        return math.inf
    plane = rounding_share(at, frame.known, x, y, z) + ROUNDED * (form.steep / form.size)
    # The conic moves with its plane by the cotangent of the angle between plane and surface
    return plane * (1.0 + length_of(form.gx, form.gy, form.gz) / inner) + form.off / (2.0 * inner)


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
) -> int:
    """Try the nearest point of the whole surface."""
    w = root_above(e)
    if w == NONE:
        return 0
    v0, v1, v2 = place_above(e, w)
    x, y, z = _place(frame, v0, v1, v2)
    return _try(geometry, room, at, count, frame, x, y, z, UNSETTLED)


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
    # The roots of a flat surface may lie nearer to s = 0 than the error of the pole: their kind is left open
    flat = min(abs(e.a1) if e.a1 != 0.0 else pole, abs(e.a2) if e.a2 != 0.0 else pole)
    if flat < _FLATTEST * pole:
        room.best[LOWER] = min(room.best[LOWER], room.bound[frame.curved])
    # F vanishes at s = 0 as well, at the apex, which is tried itself. Any other stationary point is the foot on a
    # ruling: one at h from the apex and d from the query point is nearer than the apex by h² / 2d
    cone = is_cone(e)
    if room_left < math.inf and room_left > 0.0:
        start = max(start, abs(e.g0) / room_left * (1.0 - 2.0**-20))
    for _ in range(_ROOTS):
        if not start < pole - max(0.0, -e.a1):
            return
        w, start = next_root(e, start)
        if w == OPEN:
            room.best[LOWER] = min(room.best[LOWER], room.bound[frame.curved])
        elif w != NONE:
            v0, v1, v2 = place_below(e, w)
            x, y, z = _place(frame, v0, v1, v2)
            h = length_of(v0 - _center(e.g0, e.a0), v1 - _center(e.g1, e.a1), v2 - _center(e.g2, e.a2))
            if cone and h <= _APEX * length_of(v0, v1, v2):
                continue
            if length_of(x, y, z) * (1.0 - 2.0**-20) <= limit(room):
                _try(geometry, room, at, count, frame, x, y, z, UNSETTLED)


@inline
def _center(g: float, a: float) -> float:
    """Return the place of the extremum of a parabola; 0 for a line."""
    return -g / a if a != 0.0 else 0.0


@inline
def _has_apex(e: Secular) -> bool:
    """Return whether f vanishes, but for rounding, where its gradient does."""
    f0, f1, f2 = e.b0 * _center(e.b0, e.a0), e.b1 * _center(e.b1, e.a1), e.b2 * _center(e.b2, e.a2)
    return abs(e.constant + (f0 + f1 + f2)) <= _POINT_SHARE * (abs(e.constant) + abs(f0) + abs(f1) + abs(f2))


@helper
def _axes_about(geometry: Geometry, surface: int, about: SurfaceForm) -> Axes:
    """Return the principal axes of a quadric; `about` is its form about any point.

    The rows of most records are the axes, which keep the digits of eigenvalues far smaller than the others.
    """
    _, _, _, x0, y0, z0, x1, y1, z1, x2, y2, z2, s0, s1, s2, _, _, _, _ = load_quadric(
        geometry, integer(geometry, table.SURFACE_ROW, surface)
    )
    n0, n1, n2 = length_of(x0, y0, z0), length_of(x1, y1, z1), length_of(x2, y2, z2)
    d0, d1, d2 = dot(x0, y0, z0, x1, y1, z1), dot(x0, y0, z0, x2, y2, z2), dot(x1, y1, z1, x2, y2, z2)
    across = (abs(d0) <= _ACROSS * (n0 * n1)) & (abs(d1) <= _ACROSS * (n0 * n2)) & (abs(d2) <= _ACROSS * (n1 * n2))
    if across & (n0 > 0.0) & (n1 > 0.0) & (n2 > 0.0):
        along = Directions(x0 / n0, y0 / n0, z0 / n0, x1 / n1, y1 / n1, z1 / n1, x2 / n2, y2 / n2, z2 / n2)
        return sort_axes(s0 * (n0 * n0), s1 * (n1 * n1), s2 * (n2 * n2), along)
    a0, a1, a2, along = principal_axes(about.xx, about.yy, about.zz, about.xy, about.xz, about.yz)
    return Axes(_bend(a0, about.size), _bend(a1, about.size), _bend(a2, about.size), along)


@inline
def _bend(a: float, size: float) -> float:
    """Return an eigenvalue; 0 for one that is rounding alone."""
    return a if abs(a) > _NO_BEND * size else 0.0


@inline
def _tilt(b: float, a: float, steep: float) -> float:
    """Return a linear coefficient; 0 for one along an axis that does not bend that is rounding alone."""
    return b if (a != 0.0) | (abs(b) > _NO_BEND * steep) else 0.0


@helper
def equation_about(
    geometry: Geometry, surface: int, form: SurfaceForm, x: float, y: float, z: float
) -> tuple[Secular, Directions]:
    """Return the secular equation of a quadric, scaled to terms of about 1, and the axes of its v.

    `form` is that of the surface about the query point (x, y, z). The equation is about the anchor.
    """
    cx, cy, cz = anchor_of(geometry, surface)
    about, scale = form_at(geometry, surface, cx, cy, cz), 1.0 / form.size if form.size > 0.0 else 1.0
    a0, a1, a2, along = _axes_about(geometry, surface, about)
    x0, x1, x2 = parts_along(along, x - cx, y - cy, z - cz)
    b0, b1, b2 = parts_along(along, about.gx, about.gy, about.gz)
    b0, b1, b2 = _tilt(b0, a0, about.steep), _tilt(b1, a1, about.steep), _tilt(b2, a2, about.steep)
    a0, a1, a2, b0, b1, b2 = a0 * scale, a1 * scale, a2 * scale, b0 * scale, b1 * scale, b2 * scale
    e = Secular(
        form.value * scale, a0 * x0 + b0, a1 * x1 + b1, a2 * x2 + b2, a0, a1, a2, about.value * scale,
        x0, x1, x2, b0, b1, b2,
    )  # fmt: skip
    return e, along


@helper
def try_stationary(
    geometry: Geometry,
    room: Neighbourhood,
    at: WallQuery,
    count: int,
    k: int,
    e: Secular,
    frame: EquationFrame,
    over: Secular,
    back: EquationFrame,
) -> None:
    """Try all local minima of the distance on f = 0, whose points lie on the first `count` surfaces of room.chosen.

    f is that of near surface k. `over` and `back` are the equation of -f, and its
    frame. Besides the roots it tries the point where the gradient vanishes: the apex of a cone, or the crossing of a
    conic that is two lines.
    """
    # About the distance, for `least_bend`
    length = abs(e.value) / (length_of(e.g0, e.g1, e.g2) + math.sqrt(abs(e.value)) + 1e-300)
    plain, other, found = least_bend(e, length), least_bend(over, length), 0
    if e.value > 0.0:
        found = _try_above(geometry, room, at, count, plain, frame)
    elif e.value < 0.0:
        found = _try_above(geometry, room, at, count, other, back)
    else:
        found = _try(geometry, room, at, count, frame, frame.base_x, frame.base_y, frame.base_z, UNSETTLED)
    if found == CERTAIN_WALL:
        return
    _try_below(geometry, room, at, count, plain, frame)
    _try_below(geometry, room, at, count, other, back)
    if count == 1 and not _has_apex(e):
        return
    x, y, z = _place(frame, _center(e.g0, e.a0), _center(e.g1, e.a1), _center(e.g2, e.a2))
    # Values about the query point are rounded by more than the surface is wide where it is far
    about, moved = (
        form_at(geometry, room.surface[k], at.x + x, at.y + y, at.z + z),
        rounding_share(at, 2.0**-50, x, y, z),
    )
    moved *= 2.0 * length_of(about.gx, about.gy, about.gz) + about.size * moved
    if abs(about.value) <= 64.0 * (about.off + moved):
        _try(geometry, room, at, count, frame, x, y, z, 0.0)


@inline
def unit_along(x: float, y: float, z: float, ex: float, ey: float, ez: float) -> tuple[float, float, float]:
    """Return the unit vector along a vector, (ex, ey, ez) for no length."""
    length = length_of(x, y, z)
    return (x / length, y / length, z / length) if length > 0.0 else (ex, ey, ez)


@helper
def try_face(geometry: Geometry, room: Neighbourhood, at: WallQuery, k: int, flat: bool) -> None:
    """Try the local minima of the distance to a near surface."""
    form = form_at(geometry, room.surface[k], at.x, at.y, at.z)
    room.chosen[0] = k
    if flat:
        h = -2.0 * form.value
        try_point(geometry, room, at, 1, candidate(h * form.gx, h * form.gy, h * form.gz))
        return
    if integer(geometry, table.SURFACE_KIND, room.surface[k]) == SPHERE:
        # About its center all directions are as near
        radius = load_sphere(geometry, integer(geometry, table.SURFACE_ROW, room.surface[k])).radius
        ux, uy, uz = unit_along(form.gx, form.gy, form.gz, 1.0, 0.0, 0.0)
        x, y, z = radius * ux - form.gx, radius * uy - form.gy, radius * uz - form.gz
        try_point(geometry, room, at, 1, candidate(x, y, z))
        return
    e, along = equation_about(geometry, room.surface[k], form, at.x, at.y, at.z)
    frame, back = (
        EquationFrame(0.0, 0.0, 0.0, along, math.inf, k),
        EquationFrame(0.0, 0.0, 0.0, reverse_axes(along), math.inf, k),
    )
    try_stationary(geometry, room, at, 1, k, e, frame, negate_secular(e), back)


@helper
def try_conic(
    geometry: Geometry,
    room: Neighbourhood,
    at: WallQuery,
    k: int,
    nx: float,
    ny: float,
    nz: float,
    h: float,
    known: float,
) -> None:
    """Try the local minima of the distance to the conic of near surface k and a plane, n·p = h about its anchor."""
    # n is a unit vector; the equation is about the foot of the anchor in the plane
    cx, cy, cz = anchor_of(geometry, room.surface[k])
    dx, dy, dz = cx - at.x, cy - at.y, cz - at.z
    above, down = -h, dot(nx, ny, nz, dx, dy, dz) + h
    bx, by, bz = down * nx, down * ny, down * nz
    ux, uy, uz, vx, vy, vz = perpendicular_axes(nx, ny, nz)
    if integer(geometry, table.SURFACE_KIND, room.surface[k]) == SPHERE:
        # A circle about (ox, oy, oz), which lies in the plane within rounding
        ox, oy, oz = dx - above * nx, dy - above * ny, dz - above * nz
        radius = load_sphere(geometry, integer(geometry, table.SURFACE_ROW, room.surface[k])).radius
        square = (radius - above) * (radius + above)
        frame = EquationFrame(bx, by, bz, Directions(ux, uy, uz, vx, vy, vz, 0.0, 0.0, 0.0), known, k)
        ex, ey, ez = unit_along(bx - ox, by - oy, bz - oz, ux, uy, uz)
        if square >= -_POINT_SHARE * radius * radius:
            radius = math.sqrt(max(square, 0.0))
            x, y, z = ox + radius * ex, oy + radius * ey, oz + radius * ez
            _try(geometry, room, at, 2, frame, x, y, z, 0.0)
        return
    about = form_at(geometry, room.surface[k], cx - above * nx, cy - above * ny, cz - above * nz)
    quadric = load_quadric(geometry, integer(geometry, table.SURFACE_ROW, room.surface[k]))
    p, q = bend_between(quadric, ux, uy, uz, ux, uy, uz)[0], bend_between(quadric, vx, vy, vz, vx, vy, vz)[0]
    c, s, _ = jacobi_rotation(p, q, bend_between(quadric, ux, uy, uz, vx, vy, vz)[0])
    # One Jacobi rotation makes the quadratic form of the plane diagonal
    ux, uy, uz, vx, vy, vz = (
        c * ux - s * vx, c * uy - s * vy, c * uz - s * vz, s * ux + c * vx, s * uy + c * vy, s * uz + c * vz,
    )  # fmt: skip
    p, p_off = bend_between(quadric, ux, uy, uz, ux, uy, uz)
    q, q_off = bend_between(quadric, vx, vy, vz, vx, vy, vz)
    p, q = (p if abs(p) > p_off else 0.0), (q if abs(q) > q_off else 0.0)
    if q < p:
        p, q, ux, uy, uz, vx, vy, vz = q, p, vx, vy, vz, ux, uy, uz
    scale = 1.0 / about.size if about.size > 0.0 else 1.0
    xu, xv = -dot(ux, uy, uz, dx, dy, dz), -dot(vx, vy, vz, dx, dy, dz)
    bu = _tilt(dot(ux, uy, uz, about.gx, about.gy, about.gz), p, about.steep) * scale
    bv = _tilt(dot(vx, vy, vz, about.gx, about.gy, about.gz), q, about.steep) * scale
    p, q, constant = p * scale, q * scale, about.value * scale
    value = constant + (xu * (p * xu + 2.0 * bu) + xv * (q * xv + 2.0 * bv))
    # Two terms: the third axis repeats the second one's pole, with no share in the gradient
    e = Secular(value, p * xu + bu, q * xv + bv, 0.0, p, q, q, constant, xu, xv, 0.0, bu, bv, 0.0)
    over = Secular(-value, -(q * xv + bv), -(p * xu + bu), 0.0, -q, -p, -p, -constant, xv, xu, 0.0, -bv, -bu, 0.0)
    frame = EquationFrame(bx, by, bz, Directions(ux, uy, uz, vx, vy, vz, 0.0, 0.0, 0.0), known, k)
    back = EquationFrame(bx, by, bz, Directions(vx, vy, vz, ux, uy, uz, 0.0, 0.0, 0.0), known, k)
    try_stationary(geometry, room, at, 2, k, e, frame, over, back)
