"""Error bounds of reported crossings, computed from the answer itself.

With f(t + s) = A + 2 B s + a s² about the reported t, the root near it lies at most
|A| / (|B| + sqrt(B² - |a A|)) away. A, B and a are taken about the hit point in numbers with error bounds
(engine/numbers/sure.py), of the surface as the user gave it, so that the bound is about as large as the error.
"""

from __future__ import annotations

import math

from ...compiler.jit import helper, inline, kernel
from ..numbers.hypot import hypot
from ..numbers.sure import Sure
from ..ray import Ray, scaled_ray
from ..surface.decide import Rest, curved_terms, is_plane, plane_terms
from ..tables import Floats, Geometry, Ints, Longs, whole

_MORE = 1.0 + 2.0**-40
"""For the roundings of a bound itself."""
_ROUNDED = 2.0**-53
_TINY = 2.0**-1000


@inline
def _most(x: Sure) -> float:
    """An upper bound of |x|."""
    return (abs(x.high) + abs(x.low) + x.error) * _MORE


@inline
def _least(x: Sure) -> float:
    """A lower bound of |x|; it may be negative."""
    return (abs(x.high) - abs(x.low) - x.error) * (2.0 - _MORE)


@helper
def error_of_t(geometry: Geometry, rest: Rest, surface: int, ray: Ray, t: float) -> float:
    """A bound on |t - t*| for a crossing t* of a surface that was found at t; infinite where none is proved."""
    if is_plane(geometry, surface):
        height, rate = plane_terms(geometry, rest, surface, ray, t)
        slope = _least(rate)
        return _most(height) / slope * _MORE if slope > 0.0 else math.inf
    a, b, c, discriminant = curved_terms(geometry, rest, surface, ray, t)
    value, slope, bend = _most(c), _least(b), _most(a)
    apart = slope * slope - bend * value
    if slope > 0.0 and apart > 0.0:
        bound = value / (slope + math.sqrt(apart)) * _MORE
        # The other root must be far enough, of t's rounding too, that the one near t is the one that was meant
        if max(bound, abs(t) * 2.0**-50) * bend < 0.25 * math.sqrt(max(_least(discriminant), 0.0)):
            return bound
    if not _most(discriminant) < math.inf or not slope * slope < math.inf:
        return _error_of_large(_most(c), _least(b), _most(a), t)
    bend = _least(a)
    both = _most(b) + math.sqrt(max(discriminant.high, 0.0) + abs(discriminant.low) + discriminant.error)
    return both / bend * _MORE if bend > 0.0 else math.inf


@inline
def _error_of_large(value: float, slope: float, bend: float, t: float) -> float:
    """The bound where squares of the coefficients are beyond float64: from their quotients."""
    if not (value < math.inf and bend < math.inf and slope > 0.0):
        return math.inf
    apart = 1.0 - bend / slope * (value / slope) * _MORE
    if not apart > 0.0:
        return math.inf
    bound = value / slope / (1.0 + math.sqrt(apart)) * _MORE
    near = max(bound, abs(t) * 2.0**-50) * (bend / slope) < 0.25 * math.sqrt(apart)
    return bound if near else math.inf


@kernel(origins="r 3", directions="r 3", which="n|0", t="n", surfaces="n", begin="0..end", end="0..n", errors="out n")
def errors_of_t(
    geometry: Geometry, rest: Rest, origins: Floats, directions: Floats, which: Longs, t: Floats, surfaces: Ints,
    begin: int, end: int, errors: Floats,
) -> None:  # fmt: skip
    """errors[k]: the bound for crossing k, of ray which[k] (k, if empty) with surfaces[k] at t[k]; 0 for none (-1)."""
    last = end if len(which) > 0 else min(end, len(origins))
    for k in range(begin, last):
        errors[k] = 0.0
        if surfaces[k] >= 0:
            i = which[k] if len(which) > 0 else k
            ox, oy, oz = origins[i, 0], origins[i, 1], origins[i, 2]
            dx, dy, dz = directions[i, 0], directions[i, 1], directions[i, 2]
            ray, scale = scaled_ray(Ray(ox, oy, oz, dx, dy, dz, 0.0, 1.0, whole(-1)))
            errors[k] = error_of_t(geometry, rest, surfaces[k], ray, t[k] / scale) * scale


@kernel(directions="n 3", points="n 3", t_errors="n", begin="0..end", end="0..n", errors="out n")
def errors_of_points(
    directions: Floats, points: Floats, t_errors: Floats, begin: int, end: int, errors: Floats
) -> None:
    """errors[i]: a bound on |points[i] - (o + t* d)|; NaN for misses."""
    for i in range(begin, end):
        speed = hypot(directions[i, 0], directions[i, 1], directions[i, 2])
        size = hypot(points[i, 0], points[i, 1], points[i, 2])
        errors[i] = (t_errors[i] * speed + _ROUNDED * size) * _MORE + _TINY
