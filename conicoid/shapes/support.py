"""Support functions in closed form: sup of u·p over a solid, from which tight bounds follow.

Values are never below the true one by more than the direction's own rounding: a product is rounded
up where that matters, a sum of several terms is raised by the rounding it may have suffered.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterable, Iterator
from fractions import Fraction
from typing import Any

from .number import Symbol
from .rounded import count_of, hypot, if_several, larger, root, sum_of
from .vector import Vector

_SLACK = 8 * 2.0**-53
"""More than the relative rounding of the few operations behind one term."""


def elliptic_support(
    width_x: float, width_y: float, profile: tuple[Any, Any, Any], low: float, high: float, direction: Vector
) -> float:
    """sup of u·p over (x / width_x)² + (y / width_y)² <= g(z), low <= z <= high.

    `profile` = (g0, g1, g2) of g(z) = g0 + g1 z + g2 z², floats or fractions. At height z the section
    is an ellipse with support w sqrt(g), w = |(u_x width_x, u_y width_y)|, so the sup of u_z z + w sqrt(g(z))
    over one variable remains: at an end, a root of g, a stationary point, or at infinity.
    """
    w, uz = hypot(direction[0] * width_x, direction[1] * width_y), float(direction[2])
    g0, g1, g2 = (float(g) for g in profile)
    best = -math.inf
    for z in real_roots(g2, g1, g0):
        if low <= z <= high:
            best = max(best, uz * z)
    for z in (low, high, *real_roots(*_stationary(w, uz, g0, g1, g2))):
        if math.isfinite(z) and low <= z <= high:
            g = _value(profile, z)
            if g >= 0:
                best = max(best, sum_up((uz * z, product_with_root(w, g))))
    for end, sign in ((low, -1.0), (high, 1.0)):
        if math.isinf(end):
            best = max(best, _far(w, sign * uz, g0, sign * g1, g2))
    return best


def _stationary(w: Any, uz: Any, g0: Any, g1: Any, g2: Any) -> tuple[float, float, float]:
    """Coefficients, highest power first, of w² g'² = 4 u_z² g; divided by the largest where they are beyond float64."""
    steep = w * w * g2 - uz * uz
    a, b, c = 4 * g2 * steep, 4 * g1 * steep, w * w * g1 * g1 - 4 * uz * uz * g0
    if isinstance(a, Fraction):
        largest = max(abs(a), abs(b), abs(c), Fraction(1))
        return float(a / largest), float(b / largest), float(c / largest)
    if math.isfinite(a) and math.isfinite(b) and math.isfinite(c):
        return a, b, c
    return _stationary(*map(Fraction, (w, uz, g0, g1, g2)))


def sum_up(terms: Iterable[float]) -> float:
    """The sum of terms, raised by what the rounding of its terms may have cost if there are several."""
    items = list(terms)
    count = count_of(items)
    total = sum_of(items) + 0.0
    return if_several(count, total + _SLACK * sum_of(abs(term) for term in items), total)


def product_with_root(w: float, g: Any) -> float:
    """w sqrt(g), not below the exact value."""
    if w == 0 or g == 0:
        return 0.0
    value = w * math.sqrt(g)
    if Fraction(value) ** 2 < Fraction(w) ** 2 * Fraction(g):
        return math.nextafter(value, math.inf)
    return value


def inverse_root(a: Any) -> float:
    """1 / sqrt(a), a > 0 a float or fraction: the half-axis of a x² = 1, not below the exact value."""
    if isinstance(a, Symbol):
        return 1 / root(a)
    value = 1 / math.sqrt(a)
    return value if Fraction(a) * Fraction(value) ** 2 >= 1 else math.nextafter(value, math.inf)


def points_support(points: Iterable[Vector], direction: Vector) -> float:
    """sup of u·p over points, and so over their convex hull."""
    return functools.reduce(larger, (sum_up(u * c for u, c in zip(direction, point, strict=True)) for point in points))


def _value(profile: tuple[Any, Any, Any], z: float) -> Any:
    """g(z), in rational arithmetic: near the end of a solid its terms cancel."""
    g0, g1, g2 = (Fraction(g) for g in profile)
    height = Fraction(z)
    return g0 + height * (g1 + height * g2)


def _far(w: float, uz: float, g0: float, g1: float, g2: float) -> float:
    """The limit of u_z z + w sqrt(g(z)) as z grows, -inf where g turns negative; inf where rounding leaves it open."""
    if g2 < 0 or (g2 == 0 and (g1 < 0 or (g1 == 0 and g0 < 0))):
        return -math.inf
    spread = w * math.sqrt(g2)
    slope = uz + spread
    if slope > 0 or (slope == 0 and g2 == 0 and w * g1 > 0):
        return math.inf
    if spread > 0 and -slope <= _SLACK * spread:
        return math.inf
    return -math.inf if slope < 0 else w * math.sqrt(max(g0, 0.0))


def real_roots(a: float, b: float, c: float) -> Iterator[float]:
    """Real roots of a z² + b z + c, by the stable formula; none where all of it vanishes."""
    scale = -math.frexp(max(abs(a), abs(b), abs(c)))[1]
    a, b, c = math.ldexp(a, scale), math.ldexp(b, scale), math.ldexp(c, scale)
    d = b * b - 4 * a * c
    if d < 0:
        return
    q = -(b + math.copysign(math.sqrt(d), b)) / 2
    if a != 0:
        yield q / a
    if q != 0:
        yield c / q


def along_normal(normal: Vector, direction: Vector) -> float | None:
    """k where direction = k normal, exactly; None where they are not parallel."""
    n, u = tuple(Fraction(c) for c in normal), tuple(Fraction(c) for c in direction)
    largest = max(range(3), key=lambda i: abs(n[i]))
    multiple = u[largest] / n[largest]
    return float(multiple) if all(c == multiple * d for c, d in zip(u, n, strict=True)) else None
