"""A surface on a ray with certainty: on which side the ray begins, whether it crosses, and where, to 30 digits.

The formulas are those of quadric.py and plane.py, in pairs of floats that carry an error bound (`BoundedPair`). A
surface is its record plus its rounding rest: the difference between the exact numbers and the rounded ones of the
record. Every answer that is not OPEN is proved.
"""

from __future__ import annotations

import math
from typing import NamedTuple, TypeAlias

from ..._jit.decorators import helper, inline, record_shapes
from .. import tables as table
from ..numbers.double_double import (
    BoundedPair,
    bounded_pair,
    dot3,
    inner,
    minus,
    moment,
    opposite,
    over,
    plus,
    product,
    remainder,
    root,
    sign,
    times,
    times_float,
    two_difference,
)
from ..ray import Ray
from ..tables import PLANE, PLANE_SIZE, QUADRIC_SIZE, SPHERE, SPHERE_SIZE, Floats, Geometry, integer
from .records import anchor_of, form_row, load_plane, load_quadric, load_sphere

CROSSES, MISSES, OPEN, TOUCHES = 1, 0, 2, 3

Decision: TypeAlias = tuple[int, int, BoundedPair, BoundedPair]
"""For a plane (CROSSES, sign of its rate, t, t) or (MISSES, sign of its height, ...); for a curved surface (CROSSES,
sign of a, low, high) or (MISSES, sign of its value along the whole ray, ...); OPEN first where that is not certain.
A touch is (TOUCHES, sign of a, its t, its t): no crossing, but one under the least change of the ray."""

_NOTHING = BoundedPair(0.0, 0.0, 0.0)
Terms: TypeAlias = tuple[BoundedPair, BoundedPair, BoundedPair, BoundedPair]
"""a, b, c and b² - a c of a t² + 2 b t + c."""


@record_shapes(planes="planes", spheres="*", quadrics="*", vertices="vertices")
class RoundingRest(NamedTuple):
    """Rounding rests: exact minus rounded numbers of records and of polygon corners, flat.

    The arrays of spheres and quadrics may be short: the rests of rows beyond their end are 0. Quadrics with equal rests
    may share a row (`rest_of_quadric`).
    """

    planes: Floats
    spheres: Floats
    quadrics: Floats
    vertices: Floats


@inline
def rest_of_quadric(geometry: Geometry, row: int) -> int:
    """Return the place in `RoundingRest.quadrics` where the rest of a quadric begins."""
    return QUADRIC_SIZE * form_row(geometry, row)


@inline
def rest_number(rest: RoundingRest, k: int) -> float:
    """Return number k of `RoundingRest.quadrics`; 0 beyond the end."""
    return rest.quadrics[k] if k < len(rest.quadrics) else 0.0


@inline
def _difference(x: float, y: float) -> BoundedPair:
    """Return x - y exactly."""
    high, low = two_difference(x, y)
    return BoundedPair(high, low, 0.0)


@inline
def point_offset(x: float, y: float, rest: float, t: float, d: float) -> BoundedPair:
    """Return x + t d - (y + rest), where y was rounded and `rest` is its rounding rest."""
    # The difference first, which is exact; only the sum with t d is rounded
    place = plus(_difference(x, y), product(t, d))
    # Most numbers are floats on paper, and a sum with an exact zero would only add work
    return place if rest == 0.0 else minus(place, remainder(rest))


@helper
def plane_terms(
    geometry: Geometry, rest: RoundingRest, surface: int, ray: Ray, t: float
) -> tuple[BoundedPair, BoundedPair]:
    """Return (height, rate) of a plane on a ray, with the ray's origin moved to its point at t."""
    ox, oy, oz, dx, dy, dz, _, _, _ = ray
    row = integer(geometry, table.SURFACE_ROW, surface)
    nx, ny, nz, above, ax, ay, az = load_plane(geometry, row)
    at = PLANE_SIZE * row
    n0, n1, n2 = (
        bounded_pair(nx, rest.planes[at]),
        bounded_pair(ny, rest.planes[at + 1]),
        bounded_pair(nz, rest.planes[at + 2]),
    )
    p0, p1, p2 = point_offset(ox, ax, 0.0, t, dx), point_offset(oy, ay, 0.0, t, dy), point_offset(oz, az, 0.0, t, dz)
    height = plus(inner(n0, n1, n2, p0, p1, p2), bounded_pair(above, rest.planes[at + 3]))
    return height, dot3(dx, dy, dz, n0, n1, n2)


@helper
def decide_plane(geometry: Geometry, rest: RoundingRest, surface: int, ray: Ray, starts: bool) -> Decision:
    """Decide a plane on a ray; t = 0 if the ray starts on it."""
    height, rate = plane_terms(geometry, rest, surface, ray, 0.0)
    rises = sign(rate)
    if rises == OPEN:
        return OPEN, 0, _NOTHING, _NOTHING
    # Exactly parallel: the plane is crossed nowhere, and the side of the origin is that of the whole ray
    if rises == 0:
        side = 0 if starts else sign(height)
        return (OPEN if side == OPEN else MISSES), side, _NOTHING, _NOTHING
    t = _NOTHING if starts else opposite(over(height, rate))
    return CROSSES, rises, t, t


@helper
def _sphere_terms(geometry: Geometry, rest: RoundingRest, row: int, ray: Ray, t: float) -> Terms:
    """`curved_terms` of a sphere."""
    ox, oy, oz, dx, dy, dz, _, _, _ = ray
    cx, cy, cz, radius = load_sphere(geometry, row)
    r0, r1, r2, r3 = 0.0, 0.0, 0.0, 0.0
    if SPHERE_SIZE * row < len(rest.spheres):
        at = SPHERE_SIZE * row
        r0, r1, r2, r3 = rest.spheres[at], rest.spheres[at + 1], rest.spheres[at + 2], rest.spheres[at + 3]
    p0, p1, p2 = point_offset(ox, cx, r0, t, dx), point_offset(oy, cy, r1, t, dy), point_offset(oz, cz, r2, t, dz)
    r = bounded_pair(radius, r3)
    a = plus(plus(product(dx, dx), product(dy, dy)), product(dz, dz))
    b = dot3(dx, dy, dz, p0, p1, p2)
    square = times(r, r)
    c = minus(inner(p0, p1, p2, p0, p1, p2), square)
    # The moment form, as in quadric.py: a r² - |p × d|² does not cancel far from the sphere
    m0 = minus(times_float(p1, dz), times_float(p2, dy))
    m1 = minus(times_float(p2, dx), times_float(p0, dz))
    m2 = minus(times_float(p0, dy), times_float(p1, dx))
    return a, b, c, minus(times(a, square), inner(m0, m1, m2, m0, m1, m2))


@helper
def _quadric_terms(geometry: Geometry, rest: RoundingRest, row: int, ray: Ray, t: float) -> Terms:
    """`curved_terms` of a quadric."""
    ox, oy, oz, dx, dy, dz, _, _, _ = ray
    ax, ay, az, w00, w01, w02, w10, w11, w12, w20, w21, w22, q0, q1, q2, l0, l1, l2, constant = load_quadric(
        geometry, row
    )
    at = rest_of_quadric(geometry, row)
    p0, p1, p2 = (
        point_offset(ox, ax, rest_number(rest, at), t, dx),
        point_offset(oy, ay, rest_number(rest, at + 1), t, dy),
        point_offset(oz, az, rest_number(rest, at + 2), t, dz),
    )
    u0, u1, u2 = (
        bounded_pair(w00, rest_number(rest, at + 3)),
        bounded_pair(w01, rest_number(rest, at + 4)),
        bounded_pair(w02, rest_number(rest, at + 5)),
    )
    v0, v1, v2 = (
        bounded_pair(w10, rest_number(rest, at + 6)),
        bounded_pair(w11, rest_number(rest, at + 7)),
        bounded_pair(w12, rest_number(rest, at + 8)),
    )
    z0, z1, z2 = (
        bounded_pair(w20, rest_number(rest, at + 9)),
        bounded_pair(w21, rest_number(rest, at + 10)),
        bounded_pair(w22, rest_number(rest, at + 11)),
    )
    s0, s1, s2 = (
        bounded_pair(q0, rest_number(rest, at + 12)),
        bounded_pair(q1, rest_number(rest, at + 13)),
        bounded_pair(q2, rest_number(rest, at + 14)),
    )
    b0, b1, b2 = (
        bounded_pair(l0, rest_number(rest, at + 15)),
        bounded_pair(l1, rest_number(rest, at + 16)),
        bounded_pair(l2, rest_number(rest, at + 17)),
    )
    k = bounded_pair(constant, rest_number(rest, at + 18))
    e0, e1, e2 = dot3(dx, dy, dz, u0, u1, u2), dot3(dx, dy, dz, v0, v1, v2), dot3(dx, dy, dz, z0, z1, z2)
    y0, y1, y2 = inner(u0, u1, u2, p0, p1, p2), inner(v0, v1, v2, p0, p1, p2), inner(z0, z1, z2, p0, p1, p2)
    f0, f1, f2 = times(s0, e0), times(s1, e1), times(s2, e2)
    g0, g1, g2 = times(s0, y0), times(s1, y1), times(s2, y2)
    g = inner(b0, b1, b2, e0, e1, e2)
    a = inner(f0, f1, f2, e0, e1, e2)
    b = plus(inner(f0, f1, f2, y0, y1, y2), g)
    c = minus(plus(inner(g0, g1, g2, y0, y1, y2), times_float(inner(b0, b1, b2, y0, y1, y2), 2.0)), k)
    m0, m1, m2 = moment(y1, e2, y2, e1), moment(y2, e0, y0, e2), moment(y0, e1, y1, e0)
    squares = inner(times(s1, s2), times(s0, s2), times(s0, s1), times(m0, m0), times(m1, m1), times(m2, m2))
    mixed = inner(m0, m1, m2, moment(f1, b2, f2, b1), moment(f2, b0, f0, b2), moment(f0, b1, f1, b0))
    discriminant = plus(minus(times(a, k), squares), plus(times(g, g), times_float(mixed, 2.0)))
    return a, b, c, discriminant


@inline
def curved_terms(geometry: Geometry, rest: RoundingRest, surface: int, ray: Ray, t: float) -> Terms:
    """Return the terms of a sphere or quadric on a ray, with the ray's origin moved to its point at t."""
    row = integer(geometry, table.SURFACE_ROW, surface)
    if integer(geometry, table.SURFACE_KIND, surface) == SPHERE:
        return _sphere_terms(geometry, rest, row, ray, t)
    return _quadric_terms(geometry, rest, row, ray, t)


@inline
def _foot(geometry: Geometry, surface: int, ray: Ray, starts: bool) -> float:
    """Return about the t where a ray is nearest to the anchor of a sphere or quadric; 0 if it starts on the surface."""
    x, y, z = anchor_of(geometry, surface)
    along = (x - ray.ox) * ray.dx + (y - ray.oy) * ray.dy + (z - ray.oz) * ray.dz
    # In floats: any t near the foot serves, since the terms have bounds about every t
    foot = along / (ray.dx * ray.dx + ray.dy * ray.dy + ray.dz * ray.dz)
    # 0 at a start, where c = 0 is known of the origin alone
    return 0.0 if starts or not abs(foot) < math.inf else foot


@helper
def decide_curved(
    geometry: Geometry, rest: RoundingRest, surface: int, ray: Ray, starts: bool, absent: int
) -> Decision:
    """Decide a sphere or quadric on a ray; if the ray starts on it, the root nearest to t = 0 is returned as 0.

    `absent` has the bits of `is_straight`.
    """
    foot = _foot(geometry, surface, ray, starts)  # about the foot the terms are smallest, and cancel least
    a, b, c, discriminant = curved_terms(geometry, rest, surface, ray, foot)
    if is_straight(absent, ray):
        a, discriminant = _NOTHING, times(b, b)
    bends, crosses, value = sign(a), sign(discriminant), sign(c)
    if bends == OPEN or crosses == OPEN:
        return OPEN, 0, _NOTHING, _NOTHING
    # A touch, discriminant 0, is no crossing
    if crosses <= 0:
        # Without roots the value has one sign along the ray: that of a, or of c where a = 0
        all_along = bends if bends != 0 else value
        if crosses == 0 and bends != 0 and not starts:
            place = plus(opposite(over(b, a)), bounded_pair(foot))
            return TOUCHES, bends, place, place
        return (OPEN if all_along == OPEN else MISSES), all_along, _NOTHING, _NOTHING
    # The formulas of `roots_of`: t = q / a and c / q, from the origin again
    q, from_origin = root(discriminant), bounded_pair(foot)
    q = opposite(plus(b, q)) if b.high >= 0.0 else minus(q, b)
    second = plus(over(c, q), from_origin)
    if bends == 0:
        if sign(b) == OPEN:
            return OPEN, 0, _NOTHING, _NOTHING
        # One root; the other lies at the infinity to which it moves as a goes to 0
        falls = b.high < 0.0
        nowhere = BoundedPair(math.inf if falls else -math.inf, 0.0, 0.0)
        second = _NOTHING if starts else second
        return CROSSES, 0, (second if falls else nowhere), (nowhere if falls else second)
    first = plus(over(q, a), from_origin)
    low, high = (first, second) if (b.high >= 0.0) == (bends > 0) else (second, first)
    if starts:
        balance = sign(plus(low, high))  # positive: low is nearer to 0 than high
        if balance == OPEN or balance == 0:
            return OPEN, 0, _NOTHING, _NOTHING
        low, high = (_NOTHING, high) if balance > 0 else (low, _NOTHING)
    return CROSSES, bends, low, high


@inline
def is_straight(absent: int, ray: Ray) -> bool:
    """Return True if a = 0 exactly, since every product of two components of the direction is absent or 0.

    Bits 0 to 5 of `absent` are set where a quadric has no term xx, yy, zz, xy, xz, yz. Its record has squares along
    other axes, whose rounded numbers do not show that they cancel.
    """
    x, y, z = ray.dx != 0.0, ray.dy != 0.0, ray.dz != 0.0
    present = (1 if x else 0) | (2 if y else 0) | (4 if z else 0)
    present |= (8 if x and y else 0) | (16 if x and z else 0) | (32 if y and z else 0)
    return present & ~absent == 0


@inline
def is_plane(geometry: Geometry, surface: int) -> bool:
    """True if a surface is a plane."""
    return integer(geometry, table.SURFACE_KIND, surface) == PLANE
