"""Projection of a point onto one to three surfaces, with an error bound, or onto a polygon; Newton steps to minima.

A point is projected by steps of least length, each to where all surfaces would be if they were planes. The result is
at most about `surface_distance` from each surface; the angles between them tell how far it is from their common points.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..._jit.decorators import helper, inline
from .. import tables as table
from ..numbers.vectors import dot
from ..surface.records import load_quadric
from ..tables import QUADRIC, Geometry, integer, real
from .form import ROUNDED, SurfaceForm, bend_times, form_at, length_of, perpendicular_axes
from .neighbourhood import Neighbourhood, WallQuery

TANGENT = 2.0**-22
"""Sine below which surfaces count as tangent to each other."""
_LEVEL, _ROUNDS = 2.0**-50, 12
"""Sine below which the direction in which surfaces slant to each other is rounding; most steps of Newton's method."""
_POOR = 2.0**-40
"""Error, as a share of its size, from which on a projected point may be replaced by the apex of a cone."""
_SETTLED = 2.0**-52
"""Gain of a further step, as a share of the distance, at which a point counts as a local minimum of it."""


class _Frame(NamedTuple):
    """A unit vector along the part of a unit gradient that is perpendicular to those before it; `sine`: its length."""

    x: float
    y: float
    z: float
    sine: float


class Touch(NamedTuple):
    """A point on surfaces, its error bound, the sine of the least angle between them there, and their two frames."""

    x: float
    y: float
    z: float
    off: float
    sine: float
    one: _Frame
    two: _Frame  # of no length for a single surface


@inline
def _beyond(form: SurfaceForm, ux: float, uy: float, uz: float, vx: float, vy: float, vz: float) -> _Frame:
    """Return the part of a unit gradient perpendicular to two unit vectors, or to zeros in place of one."""
    g = length_of(form.gx, form.gy, form.gz)
    if g == 0.0:
        return _Frame(0.0, 0.0, 0.0, 0.0)
    x, y, z = form.gx / g, form.gy / g, form.gz / g
    along = dot(x, y, z, ux, uy, uz)
    x, y, z = x - along * ux, y - along * uy, z - along * uz
    along = dot(x, y, z, vx, vy, vz)
    x, y, z = x - along * vx, y - along * vy, z - along * vz
    sine = length_of(x, y, z)
    if sine == 0.0:
        return _Frame(0.0, 0.0, 0.0, 0.0)
    return _Frame(x / sine, y / sine, z / sine, sine)


@inline
def surface_distance(form: SurfaceForm) -> float:
    """Return about an upper bound of the distance to f = 0, from value and gradient, or from A for small gradients."""
    value, g = abs(form.value) + form.off, length_of(form.gx, form.gy, form.gz)
    # Newton's |f| / 2|g|, a quarter more for the curvature, where the gradient is large enough
    if g * g > 4.0 * form.size * value:
        return value / (2.0 * g) * 1.25
    return _distance_along(form, value, g)


@helper
def _distance_along(form: SurfaceForm, value: float, g: float) -> float:
    """Return about the distance to f = 0 along the gradient, for |f| = `value` and |g| = `g`; infinite for no root."""
    sure = g - ROUNDED * form.steep
    if sure > 0.0:
        ax, ay, az = bend_times(form, form.gx, form.gy, form.gz)
        bend = math.copysign(1.0, form.value) * dot(ax, ay, az, form.gx, form.gy, form.gz) / (g * g)
        square = sure * sure - bend * value
        if square >= 0.0:
            return value / (sure + math.sqrt(square)) * 1.25
    # Where f is rounding alone, at an apex, it grows as |A| d²
    return math.sqrt(value / form.size) if (form.size > 0.0) & (abs(form.value) <= 4.0 * form.off) else math.inf


@inline
def _step(form: SurfaceForm, frame: _Frame) -> float:
    """Return the step along a frame at which the linear f vanishes."""
    g = length_of(form.gx, form.gy, form.gz)
    if frame.sine < TANGENT or g == 0.0:
        return 0.0
    return -form.value / (2.0 * g) / frame.sine


@helper
def project_point(geometry: Geometry, room: Neighbourhood, count: int, x: float, y: float, z: float) -> Touch:
    """Project a point onto the first `count` of room.chosen, 1 to 3 surfaces, by Newton steps of least length."""
    off, sine, mx, my, mz = 0.0, 1.0, 0.0, 0.0, 0.0
    a, b = _Frame(0.0, 0.0, 0.0, 0.0), _Frame(0.0, 0.0, 0.0, 0.0)
    for k in range(_ROUNDS):
        one = form_at(geometry, room.surface[room.chosen[0]], x, y, z)
        a, b = _beyond(one, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0), _Frame(0.0, 0.0, 0.0, 0.0)
        off, sine, step = surface_distance(one), 1.0, _step(one, a)
        mx, my, mz = step * a.x, step * a.y, step * a.z
        for i in range(1, count):
            # Where the step to those before ends: a flat cone may have another slope there
            form = form_at(geometry, room.surface[room.chosen[i]], x + mx, y + my, z + mz)
            frame = _beyond(form, a.x, a.y, a.z, b.x, b.y, b.z)
            step = _step(form, frame)
            mx, my, mz = mx + step * frame.x, my + step * frame.y, mz + step * frame.z
            off, sine = _joint_error(off + surface_distance(form), one, form, frame), min(sine, frame.sine)
            b = frame if i == 1 else b
        if k + 1 == _ROUNDS or (k > 1 and abs(mx) + abs(my) + abs(mz) <= 2.0**-53 * (abs(x) + abs(y) + abs(z))):
            break
        x, y, z = x + mx, y + my, z + mz
    # The coordinates of the point are rounded, too; the surfaces were seen within the last step
    off += 2.0**-51 * (abs(x) + abs(y) + abs(z)) + (abs(mx) + abs(my) + abs(mz))
    for k in range(count):
        if off > _POOR * (abs(x) + abs(y) + abs(z)):
            x, y, z, off = _at_apex(geometry, room, count, k, x, y, z, off)
    return Touch(x, y, z, off, sine, a, b)


@helper
def _at_apex(
    geometry: Geometry, room: Neighbourhood, count: int, k: int, x: float, y: float, z: float, off: float
) -> tuple[float, float, float, float]:
    """Return the apex of chosen cone k, if the point may be it and all others are planes; else the point itself.

    Near its apex the gradient of a cone is too small to bound the distance. A plane that passes the apex within
    rounding cuts the cone about as near to it, unless it runs along the cone; a flat or slender one so many times as
    far away as that is flat.
    """
    surface = room.surface[room.chosen[k]]
    if integer(geometry, table.SURFACE_KIND, surface) != QUADRIC:
        return x, y, z, off
    ax, ay, az, w00, w01, w02, w10, w11, w12, w20, w21, w22, s0, s1, s2, b0, b1, b2, constant = load_quadric(
        geometry, integer(geometry, table.SURFACE_ROW, surface)
    )
    if (b0 != 0.0) | (b1 != 0.0) | (b2 != 0.0) | (constant != 0.0) or length_of(ax - x, ay - y, az - z) > 8.0 * off:
        return x, y, z, off
    n0, n1, n2 = (
        abs(s0) * dot(w00, w01, w02, w00, w01, w02), abs(s1) * dot(w10, w11, w12, w10, w11, w12),
        abs(s2) * dot(w20, w21, w22, w20, w21, w22),
    )  # fmt: skip
    most, least = max(n0, max(n1, n2)), min(n0, min(n1, n2))
    flat = math.sqrt(most / least) if least > 0.0 else math.inf
    apex = 2.0**-51 * (abs(ax) + abs(ay) + abs(az))
    for i in range(count):
        if i != k:
            form = form_at(geometry, room.surface[room.chosen[i]], ax, ay, az)
            if form.size > 0.0:
                return x, y, z, off
            apex += 64.0 * flat * surface_distance(form)
    return (ax, ay, az, apex) if apex < off else (x, y, z, off)


@inline
def _joint_error(off: float, one: SurfaceForm, form: SurfaceForm, frame: _Frame) -> float:
    """Return the error of a point on several surfaces: larger for smaller angles, at most as for tangent surfaces.

    Tangent surfaces meet where they have bent together: along the frame, on surface `one`, f has a bend of its own.
    """
    g, first, bend = length_of(form.gx, form.gy, form.gz), length_of(one.gx, one.gy, one.gz), form.size
    if (frame.sine > _LEVEL) & (first > 0.0):
        ux, uy, uz = bend_times(form, frame.x, frame.y, frame.z)
        vx, vy, vz = bend_times(one, frame.x, frame.y, frame.z)
        share = dot(form.gx, form.gy, form.gz, one.gx, one.gy, one.gz) / (first * first)
        bend = abs(dot(ux - share * vx, uy - share * vy, uz - share * vz, frame.x, frame.y, frame.z))
        bend -= ROUNDED * (form.size + abs(share) * one.size)
    most = math.sqrt(off * (g / bend)) if bend > 0.0 else math.inf
    return min(off / frame.sine, max(off, 4.0 * most)) if frame.sine > 0.0 else max(off, 4.0 * most)


@inline
def slant(one: _Frame, two: _Frame, x: float, y: float, z: float) -> float:
    """Return the length of a vector's part along the surfaces of two frames; 0 where they touch or have no gradient."""
    along, across = dot(one.x, one.y, one.z, x, y, z), dot(two.x, two.y, two.z, x, y, z)
    x, y, z = x - along * one.x - across * two.x, y - along * one.y - across * two.y, z - along * one.z - across * two.z
    return length_of(x, y, z) if (one.sine > 0.0) & ((two.sine == 0.0) | (two.sine >= TANGENT)) else 0.0


@helper
def settle_point(
    geometry: Geometry, room: Neighbourhood, at: WallQuery, count: int, x: float, y: float, z: float
) -> tuple[float, float, float, float]:
    """Return (a displacement near another where the distance is stationary, the gain of a further step).

    Newton's method on the first `count` of room.chosen, 1 or 2: with Lagrange's function |v|² / 2 + sum m_i f_i / 2 its
    gradient along the surfaces is r, its second derivative H = 1 + sum m_i A_i, a step H^-1 r gains r·H^-1 r / 2. The
    gain is infinite where the method finds no local minimum.
    """
    gain = math.inf
    for _ in range(_ROUNDS):
        px, py, pz, _, _, one, two = project_point(geometry, room, count, at.x + x, at.y + y, at.z + z)
        x, y, z = px - at.x, py - at.y, pz - at.z
        f = form_at(geometry, room.surface[room.chosen[0]], px, py, pz)
        g, distance = length_of(f.gx, f.gy, f.gz), length_of(x, y, z)
        along, across, gain = dot(x, y, z, one.x, one.y, one.z), 0.0, math.inf
        ux, uy, uz, vx, vy, vz = perpendicular_axes(one.x, one.y, one.z)
        if not (g > 0.0 and distance > 0.0 and (count == 1 or two.sine >= TANGENT)):
            break
        m11, m12, m22 = 1.0, 0.0, 1.0
        if count > 1:
            # v becomes the tangent, u the second frame, along which no step is free
            ux, uy, uz = two.x, two.y, two.z
            vx, vy, vz = one.y * uz - one.z * uy, one.z * ux - one.x * uz, one.x * uy - one.y * ux
            h = form_at(geometry, room.surface[room.chosen[1]], px, py, pz)
            across = -dot(x, y, z, ux, uy, uz) / (length_of(h.gx, h.gy, h.gz) * two.sine)
            along += across * dot(h.gx, h.gy, h.gz, one.x, one.y, one.z)
            bx, by, bz = bend_times(h, vx, vy, vz)
            m22 += across * dot(bx, by, bz, vx, vy, vz)
        m = -along / g
        ax, ay, az = bend_times(f, ux, uy, uz)
        bx, by, bz = bend_times(f, vx, vy, vz)
        m22 += m * dot(bx, by, bz, vx, vy, vz)
        r1, r2 = 0.0, dot(x, y, z, vx, vy, vz)
        if count == 1:
            r1, m11, m12 = (
                dot(x, y, z, ux, uy, uz),
                m11 + m * dot(ax, ay, az, ux, uy, uz),
                m * dot(ax, ay, az, vx, vy, vz),
            )
        square = m11 * m22 - m12 * m12
        if not (square > 0.0 and m22 > 0.0):
            break
        d1, d2 = (m22 * r1 - m12 * r2) / square, (m11 * r2 - m12 * r1) / square
        gain = (r1 * d1 + r2 * d2) / (2.0 * distance)
        if gain <= _SETTLED * distance:
            break
        x, y, z = x - d1 * ux - d2 * vx, y - d1 * uy - d2 * vy, z - d1 * uz - d2 * vz
    return x, y, z, gain


# The nearest point of a polygon: of its inside, or of one of its sides


@inline
def corner(geometry: Geometry, vertex: int, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Return a vertex of the table relative to a point."""
    at = 3 * vertex
    return (
        real(geometry, table.VERTICES, at) - x,
        real(geometry, table.VERTICES, at + 1) - y,
        real(geometry, table.VERTICES, at + 2) - z,
    )


@helper
def is_within(geometry: Geometry, polygon: int, x: float, y: float, z: float) -> bool:
    """True if a point of a polygon's plane is within its outline, by the even-odd rule."""
    plane = form_at(geometry, integer(geometry, table.POLYGON_SURFACE, polygon), x, y, z)
    nx, ny, nz = abs(plane.gx), abs(plane.gy), abs(plane.gz)
    # Without the coordinate along which the normal is largest, the outline keeps most of its area
    drop = 0 if (nx >= ny) & (nx >= nz) else (1 if ny >= nz else 2)
    first, last = integer(geometry, table.POLYGON_FIRST, polygon), integer(geometry, table.POLYGON_FIRST, polygon + 1)
    ax, ay, az = corner(geometry, last - 1, x, y, z)
    au, av = (ay, az) if drop == 0 else ((az, ax) if drop == 1 else (ax, ay))
    odd = False
    for vertex in range(first, last):
        bx, by, bz = corner(geometry, vertex, x, y, z)
        bu, bv = (by, bz) if drop == 0 else ((bz, bx) if drop == 1 else (bx, by))
        # Half-open in v: a corner on the line counts for one of its two sides
        if (av < 0.0) != (bv < 0.0):
            side = au * bv - bu * av
            odd ^= (side > 0.0) if bv > av else (side < 0.0)
        au, av = bu, bv
    return odd


@inline
def nearest_of_side(ax: float, ay: float, az: float, bx: float, by: float, bz: float) -> tuple[float, float, float]:
    """Return the point of a side, from a to b, that is nearest to the origin."""
    dx, dy, dz = bx - ax, by - ay, bz - az
    square = dot(dx, dy, dz, dx, dy, dz)
    t = -dot(ax, ay, az, dx, dy, dz) / square if square > 0.0 else 0.0
    if t <= 0.0:
        return ax, ay, az
    if t >= 1.0:
        return bx, by, bz
    return ax + t * dx, ay + t * dy, az + t * dz


@helper
def nearest_of_polygon(geometry: Geometry, polygon: int, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Return the point of a whole polygon that is nearest to a query point, relative to it."""
    plane = form_at(geometry, integer(geometry, table.POLYGON_SURFACE, polygon), x, y, z)
    # f = value + 2 g·v with |g| = 1/2 for a plane: the foot is at v = -2 value g
    h = -2.0 * plane.value
    vx, vy, vz = h * plane.gx, h * plane.gy, h * plane.gz
    if is_within(geometry, polygon, x + vx, y + vy, z + vz):
        return vx, vy, vz
    first, last = integer(geometry, table.POLYGON_FIRST, polygon), integer(geometry, table.POLYGON_FIRST, polygon + 1)
    ax, ay, az = corner(geometry, last - 1, x, y, z)
    best = math.inf
    for vertex in range(first, last):
        bx, by, bz = corner(geometry, vertex, x, y, z)
        px, py, pz = nearest_of_side(ax, ay, az, bx, by, bz)
        distance = length_of(px, py, pz)
        if distance < best:
            best, vx, vy, vz = distance, px, py, pz
        ax, ay, az = bx, by, bz
    return vx, vy, vz
