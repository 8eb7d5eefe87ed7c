"""A quadric or sphere on a ray: its two crossings, numerically stable at any distance and any scale.

The surface is  sum s_i y_i² + 2 b_i y_i - k = 0  with y = W (x - anchor). On the ray, with the
origin moved to the foot of the perpendicular from the anchor, it is  a t² + 2 b t + c, and the
discriminant b² - a c is taken in its moment form, m = y × e with e = W d:

    a k + (b·e)² - (s2 s3 m1² + s1 s3 m2² + s1 s2 m3²) + 2 m·((s∘e) × b)

which does not cancel far from the surface (derived in docs/theory.md).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..._jit.decorators import fma, helper, inline
from ..numbers.double_double import (
    Pair,
    difference_of_products,
    negate_pair,
    pair_dot,
    pair_product,
    pair_sum,
    scale_pair,
    two_difference,
)
from ..numbers.vectors import Vector, dot
from ..ray import RayLine
from .doubt import CANCELS, LEAST_OF_BALLS, POINT, STARTING


class QuadricRecord(NamedTuple):
    """The record of a quadric: anchor, rows W, squares s, linear terms b, constant k."""

    ax: float
    ay: float
    az: float
    w00: float
    w01: float
    w02: float
    w10: float
    w11: float
    w12: float
    w20: float
    w21: float
    w22: float
    s0: float
    s1: float
    s2: float
    b0: float
    b1: float
    b2: float
    k: float


class SphereRecord(NamedTuple):
    """A sphere, or a ball: center and radius."""

    x: float
    y: float
    z: float
    radius: float


class QuadricRoots(NamedTuple):
    """Crossings of a ray with a quadric: its inside is low < t < high, or the rest of the line if `outside`.

    Without crossings (a touch counts as none) the whole ray is inside if `outside`, else none of it. `unsure` is True
    if rounding might change that, or might change the roots by more than the limits of their surface.
    """

    low: float
    high: float
    outside: bool
    crosses: bool
    unsure: bool


class RayQuadratic(NamedTuple):
    """A quadric on a ray: a t² + 2 b t + c about o + foot d, its discriminant b² - a c, and three flags.

    `cancels` is True if terms of a or of the discriminant cancel, so that all terms must be evaluated again in pairs of
    floats; `straight` if every term of a is zero; `ruling` if the linear terms along the ray are zero as well, so that
    the ray runs parallel to the axis of a cylinder.
    """

    a: float
    b: float
    c: float
    discriminant: float
    foot: float
    cancels: bool
    straight: bool
    ruling: bool


class QuadricLimits(NamedTuple):
    """Least values from which on the fast formulas of a quadric are certain."""

    discriminant: float  # for |d| = 1
    value: float  # along rulings, infinite where these are never certain


@inline
def roots_of(a: float, b: float, c: float, discriminant: float, shift: float, unsure: bool) -> QuadricRoots:
    """Return the roots of a t² + 2 b t + c from its discriminant, each by the formula that does not cancel.

    q = -(b + sign(b) sqrt(b² - a c)); t = q / a and c / q, both plus `shift`. For a = 0 the first root is the infinity
    at the right end, so that a linear function needs no branch of its own. Keeps low <= high. `outside` is set where
    a < 0, and where a = 0, the ray crosses nothing and c < 0.
    """
    crosses = discriminant > 0.0
    # 1 in place of a discriminant without roots: the root stays real, and its value is not used
    q = -(b + math.copysign(math.sqrt(discriminant if crosses else 1.0), b))
    # The shift comes last: about the foot the roots are small, and keep their digits
    first, second = q / a + shift, c / q + shift
    outside = a < 0.0 or (a == 0.0 and not crosses and c < 0.0)
    # min and max, not a branch on the signs of a and b: lanes of packets run this code too
    return QuadricRoots(min(first, second), max(first, second), outside, crosses, unsure)


@inline
def sphere_on_ray(
    sphere: SphereRecord, line: RayLine, inverse: float, starts: bool
) -> tuple[float, float, float, float, float]:
    """Return (a, b, c, b² - a c, foot) of |x - center| = r on a ray, about the foot of the perpendicular.

    With `starts` the ray's origin lies on the sphere: foot and c are 0.
    """
    cx, cy, cz, r = sphere
    ox, oy, oz, dx, dy, dz = line
    px, ex = two_difference(ox, cx)
    py, ey = two_difference(oy, cy)
    pz, ez = two_difference(oz, cz)
    a = dot(dx, dy, dz, dx, dy, dz)
    # At a start c is set to 0, which holds about the origin alone
    foot = 0.0 if starts else -dot(px, py, pz, dx, dy, dz) * inverse
    # The errors of the differences are added last: o - center and the foot cancel first where the origin is far away
    px, py, pz = fma(foot, dx, px) + ex, fma(foot, dy, py) + ey, fma(foot, dz, pz) + ez
    b = dot(px, py, pz, dx, dy, dz)
    # b² - a c = a r² - |p × d|², in which nothing of the distance |p| cancels
    mx = difference_of_products(py, dz, pz, dy)
    my = difference_of_products(pz, dx, px, dz)
    mz = difference_of_products(px, dy, py, dx)
    c = 0.0 if starts else dot(px, py, pz, px, py, pz) - r * r
    discriminant = b * b if starts else a * (r * r) - dot(mx, my, mz, mx, my, mz)
    return a, b, c, discriminant, foot


@inline
def least_of_sphere(sphere: SphereRecord, starts: bool) -> float:
    """Return the least certain discriminant of a sphere, for |d| = 1."""
    return (LEAST_OF_BALLS * STARTING if starts else LEAST_OF_BALLS) * (sphere.radius * sphere.radius)


@inline
def sphere_roots(sphere: SphereRecord, line: RayLine, inverse: float, starts: bool) -> QuadricRoots:
    """Return the crossings of a ray with a sphere; `inverse` is 1 / d·d, `starts`: the origin lies on the sphere.

    This is the ray tracing notes' algebraic method about the foot of the perpendicular, which is their geometric one.
    """
    a, b, c, discriminant, foot = sphere_on_ray(sphere, line, inverse, starts)
    least = least_of_sphere(sphere, starts)
    return roots_of(a, b, c, discriminant, foot, not abs(discriminant) * inverse >= least)


@inline
def quadric_roots(
    quadric: QuadricRecord, limits: QuadricLimits, line: RayLine, inverse: float, starts: bool
) -> QuadricRoots:
    """Return the crossings of a ray with a quadric; `inverse` is 1 / d·d, `starts`: the origin lies on the quadric."""
    # Pairs of floats cost many times as much, so they are used only where the terms cancel
    terms = quadratic_on_ray(quadric, line, inverse, starts)
    if terms.cancels:
        terms = careful_quadratic(quadric, line, terms)
    return roots_of_terms(terms, starts, inverse, limits)


@inline
def roots_of_terms(terms: RayQuadratic, starts: bool, inverse: float, limits: QuadricLimits) -> QuadricRoots:
    """Return the roots from the terms of a quadric on a ray.

    For a ray that starts on the quadric c is set to 0, so that the roots are t = 0 exactly and -2 b / a; relies on
    foot = 0 there. `unsure` compares with the least discriminant of `limits`, for a ray along a ruling with the least
    value.
    """
    a, b, foot = terms.a, terms.b, terms.foot
    discriminant = b * b if starts else terms.discriminant
    c = 0.0 if starts else terms.c
    # The origin of such a ray was rounded, so it lies beside the surface on which the ray starts
    least = limits.discriminant * STARTING if starts else limits.discriminant
    certain = (abs(c) > limits.value) if terms.ruling else (abs(discriminant) * inverse >= least)
    # A root at infinity is certain only if every term of a is zero, despite the rounding of the record
    certain &= (terms.straight & (limits.value < math.inf)) | (a != 0.0)
    return roots_of(a, b, c, discriminant, foot, not certain)


@inline
def quadratic_on_ray(quadric: QuadricRecord, line: RayLine, inverse: float, starts: bool) -> RayQuadratic:
    """Return a quadric on a ray, in floats, without branches; `cancels` is set where `careful_quadratic` is needed."""
    ax, ay, az, w00, w01, w02, w10, w11, w12, w20, w21, w22, s0, s1, s2, b0, b1, b2, k = quadric
    ox, oy, oz, dx, dy, dz = line
    # Origin relative to the anchor in two floats, then the foot of the perpendicular
    px, ux = two_difference(ox, ax)
    py, uy = two_difference(oy, ay)
    pz, uz = two_difference(oz, az)
    foot = 0.0 if starts else -dot(px, py, pz, dx, dy, dz) * inverse
    px, py, pz = fma(foot, dx, px) + ux, fma(foot, dy, py) + uy, fma(foot, dz, pz) + uz
    # Coordinates y = W x of direction and foot
    e0, y0 = dot(w00, w01, w02, dx, dy, dz), dot(w00, w01, w02, px, py, pz)
    e1, y1 = dot(w10, w11, w12, dx, dy, dz), dot(w10, w11, w12, px, py, pz)
    e2, y2 = dot(w20, w21, w22, dx, dy, dz), dot(w20, w21, w22, px, py, pz)
    # Restriction to the ray
    f0, f1, f2 = s0 * e0, s1 * e1, s2 * e2
    g = dot(b0, b1, b2, e0, e1, e2)
    # + 0.0 turns -0.0 into 0.0, so that for a = 0 the sign of the infinite q / a depends on b alone
    a = dot(f0, f1, f2, e0, e1, e2) + 0.0
    b = dot(f0, f1, f2, y0, y1, y2) + g
    c = dot(fma(s0, y0, 2.0 * b0), fma(s1, y1, 2.0 * b1), fma(s2, y2, 2.0 * b2), y0, y1, y2) - k
    # Discriminant in moment form
    m0 = difference_of_products(y1, e2, y2, e1)
    m1 = difference_of_products(y2, e0, y0, e2)
    m2 = difference_of_products(y0, e1, y1, e0)
    t0, t1, t2 = s1 * s2 * (m0 * m0), s0 * s2 * (m1 * m1), s0 * s1 * (m2 * m2)
    # The mixed term vanishes for quadrics without linear terms, but a branch would cost more than the term
    h = dot(m0, m1, m2, f1 * b2 - f2 * b1, f2 * b0 - f0 * b2, f0 * b1 - f1 * b0)
    discriminant = (a * k - ((t0 + t1) + t2)) + fma(g, g, 2.0 * h)
    # Sizes of the terms, to detect cancellation
    size = abs(f0 * e0) + abs(f1 * e1) + abs(f2 * e2)
    terms = abs(size * k) + abs(t0) + abs(t1) + abs(t2) + g * g + 2.0 * abs(h)
    cancels = (abs(discriminant) < CANCELS * terms) | (abs(a) < CANCELS * size)
    straight = size == 0.0
    ruling = straight & (abs(b0 * e0) + abs(b1 * e1) + abs(b2 * e2) == 0.0)
    return RayQuadratic(a, b, c, discriminant, foot, cancels, straight, ruling)


@helper
def careful_quadratic(quadric: QuadricRecord, line: RayLine, terms: RayQuadratic) -> RayQuadratic:
    """Return `quadratic_on_ray` about the same foot, evaluated in pairs of floats and rounded once."""
    ax, ay, az, w00, w01, w02, w10, w11, w12, w20, w21, w22, s0, s1, s2, b0, b1, b2, k = quadric
    ox, oy, oz, dx, dy, dz = line
    foot = terms.foot
    # The foot is that of the fast terms: its own rounding only moves the point along the ray
    px = pair_sum(_difference(ox, ax), _product(foot, dx))
    py = pair_sum(_difference(oy, ay), _product(foot, dy))
    pz = pair_sum(_difference(oz, az), _product(foot, dz))
    d0, d1, d2 = Pair(dx, 0.0), Pair(dy, 0.0), Pair(dz, 0.0)
    e0, y0 = pair_dot(w00, w01, w02, d0, d1, d2), pair_dot(w00, w01, w02, px, py, pz)
    e1, y1 = pair_dot(w10, w11, w12, d0, d1, d2), pair_dot(w10, w11, w12, px, py, pz)
    e2, y2 = pair_dot(w20, w21, w22, d0, d1, d2), pair_dot(w20, w21, w22, px, py, pz)
    a = pair_dot(s0, s1, s2, pair_product(e0, e0), pair_product(e1, e1), pair_product(e2, e2))
    g = pair_dot(b0, b1, b2, e0, e1, e2)
    b = pair_sum(pair_dot(s0, s1, s2, pair_product(e0, y0), pair_product(e1, y1), pair_product(e2, y2)), g)
    c = pair_dot(s0, s1, s2, pair_product(y0, y0), pair_product(y1, y1), pair_product(y2, y2))
    c = pair_sum(c, pair_sum(pair_dot(2.0 * b0, 2.0 * b1, 2.0 * b2, y0, y1, y2), Pair(-k, 0.0)))
    m0 = _moment(y1, e2, y2, e1)
    m1 = _moment(y2, e0, y0, e2)
    m2 = _moment(y0, e1, y1, e0)
    f0, f1, f2 = scale_pair(e0, s0), scale_pair(e1, s1), scale_pair(e2, s2)
    t0 = pair_product(_product(s1, s2), pair_product(m0, m0))
    t1 = pair_product(_product(s0, s2), pair_product(m1, m1))
    t2 = pair_product(_product(s0, s1), pair_product(m2, m2))
    h0 = pair_product(m0, pair_sum(scale_pair(f1, b2), scale_pair(f2, -b1)))
    h1 = pair_product(m1, pair_sum(scale_pair(f2, b0), scale_pair(f0, -b2)))
    h2 = pair_product(m2, pair_sum(scale_pair(f0, b1), scale_pair(f1, -b0)))
    squares = pair_sum(pair_sum(t0, t1), t2)
    mixed = pair_dot(2.0, 2.0, 2.0, h0, h1, h2)
    discriminant = pair_sum(pair_sum(scale_pair(a, k), negate_pair(squares)), pair_sum(pair_product(g, g), mixed))
    return RayQuadratic(
        # Rounded once: the high part of a pair is its nearest float. + 0.0 is for the sign of q / a, as above
        a.high + 0.0, b.high, c.high, discriminant.high, foot, terms.cancels, terms.straight, terms.ruling
    )  # fmt: skip


@inline
def _difference(a: float, b: float) -> Pair:
    """Return a - b exactly, as a pair."""
    high, low = two_difference(a, b)
    return Pair(high, low)


@inline
def _product(a: float, b: float) -> Pair:
    """Return a b exactly, as a pair."""
    p = a * b
    return Pair(p, fma(a, b, -p))


@inline
def _moment(a: Pair, b: Pair, c: Pair, d: Pair) -> Pair:
    """Return a b - c d."""
    return pair_sum(pair_product(a, b), negate_pair(pair_product(c, d)))


@inline
def quadric_value(quadric: QuadricRecord, x: float, y: float, z: float) -> float:
    """Return the left side of the quadric's equation at a point: <= 0 inside."""
    y0, y1, y2 = own_coordinates(quadric, x, y, z)
    _, _, _, _, _, _, _, _, _, _, _, _, s0, s1, s2, b0, b1, b2, k = quadric
    return dot(fma(s0, y0, 2.0 * b0), fma(s1, y1, 2.0 * b1), fma(s2, y2, 2.0 * b2), y0, y1, y2) - k


@inline
def quadric_rounding(
    quadric: QuadricRecord, x: float, y: float, z: float, rest_x: float, rest_y: float, rest_z: float
) -> float:
    """Return the error bound of `quadric_value`; it includes the anchor's rounding, whose rest is (rest_x, ...)."""
    ax, ay, az, w00, w01, w02, w10, w11, w12, w20, w21, w22, s0, s1, s2, b0, b1, b2, k = quadric
    px, py, pz = abs(x - ax), abs(y - ay), abs(z - az)
    ex, ey, ez = abs(rest_x), abs(rest_y), abs(rest_z)
    size0, beside0 = _terms((w00, w01, w02), s0, b0, (px, py, pz), (ex, ey, ez))
    size1, beside1 = _terms((w10, w11, w12), s1, b1, (px, py, pz), (ex, ey, ez))
    size2, beside2 = _terms((w20, w21, w22), s2, b2, (px, py, pz), (ex, ey, ez))
    # Twice the change by the anchor's rest, which covers the rounding of this bound
    return POINT * (size0 + size1 + size2 + abs(k)) + 2.0 * (beside0 + beside1 + beside2)


@inline
def _terms(w: Vector, s: float, b: float, p: Vector, e: Vector) -> tuple[float, float]:
    """Return bounds along one axis of |s y² + 2 b y|, y = w·p, and of its change from p to p + e."""
    (w0, w1, w2), (px, py, pz), (ex, ey, ez) = w, p, e
    y, beside = dot(abs(w0), abs(w1), abs(w2), px, py, pz), dot(abs(w0), abs(w1), abs(w2), ex, ey, ez)
    return (abs(s) * y + 2.0 * abs(b)) * y, (abs(s) * (2.0 * y + beside) + 2.0 * abs(b)) * beside


@inline
def quadric_gradient(quadric: QuadricRecord, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Return Wᵀ (s∘y + b), half the gradient at a point (the ray tracing notes' normal of a quadric)."""
    _, _, _, w00, w01, w02, w10, w11, w12, w20, w21, w22, s0, s1, s2, b0, b1, b2, _ = quadric
    y0, y1, y2 = own_coordinates(quadric, x, y, z)
    g0, g1, g2 = fma(s0, y0, b0), fma(s1, y1, b1), fma(s2, y2, b2)
    return dot(w00, w10, w20, g0, g1, g2), dot(w01, w11, w21, g0, g1, g2), dot(w02, w12, w22, g0, g1, g2)


@inline
def sign_everywhere(quadric: QuadricRecord) -> float:
    """Return the sign of a quadric of one sign, which is a point, a line or a double plane; 0 for any other."""
    _, _, _, _, _, _, _, _, _, _, _, _, s0, s1, s2, b0, b1, b2, k = quadric
    if (b0 != 0.0) | (b1 != 0.0) | (b2 != 0.0) | (k != 0.0):
        return 0.0
    return 1.0 if min(s0, min(s1, s2)) >= 0.0 else (-1.0 if max(s0, max(s1, s2)) <= 0.0 else 0.0)


@inline
def own_coordinates(quadric: QuadricRecord, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Return y = W (x - anchor)."""
    ax, ay, az, w00, w01, w02, w10, w11, w12, w20, w21, w22, _, _, _, _, _, _, _ = quadric
    px, py, pz = x - ax, y - ay, z - az
    return dot(w00, w01, w02, px, py, pz), dot(w10, w11, w12, px, py, pz), dot(w20, w21, w22, px, py, pz)
