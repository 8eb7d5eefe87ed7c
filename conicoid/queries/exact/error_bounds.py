"""Bounds on the errors of reported crossings, computed a posteriori from the reported t.

With f(t + s) = A + 2 B s + a s² about the reported t, the root near it lies at most |A| / (|B| + sqrt(B² - |a A|))
away. A, B and a are computed about the hit point in numbers with error bounds (kernels/numbers/double_double.py), from
the surface as the user gave it, so that the bound is about as large as the error. Where such a bound is too large, the
exact roots replace it.
"""

from __future__ import annotations

import math
from math import inf, nextafter
from typing import Any

import numpy as np

from ..._jit.decorators import helper, inline, kernel
from ..._util.arrays import FloatArray
from ...geometry.exact_crossings import integer_line
from ...kernels.numbers.double_double import BoundedPair, minus, opposite, over, plus, root, times_float
from ...kernels.numbers.elementary import hypot
from ...kernels.ray import Ray, scale_ray
from ...kernels.surface.exact_crossing import RoundingRest, curved_terms, is_plane, plane_terms, point_offset
from ...kernels.tables import Floats, Geometry, Ints, Longs, Signs, whole
from ...kernels.threads import run_rows
from ...numerics.rational import Root, exact_real_roots
from ...prepare.prepared_scene import PreparedScene, exact_form
from ..hit_fields import is_far

_MORE = 1.0 + 2.0**-40
"""A factor that covers the rounding errors of the bound's own computation."""
_ROUNDING_BOUND = 2.0**-53  # relative error of one rounding
_TINY = 2.0**-1000  # covers roundings near the smallest numbers, where errors are not relative


@inline
def _most(x: BoundedPair) -> float:
    """Return an upper bound of |x|."""
    return (abs(x.high) + abs(x.low) + x.error) * _MORE


@inline
def _least(x: BoundedPair) -> float:
    """Return a lower bound of |x|, which may be negative."""
    return (abs(x.high) - abs(x.low) - x.error) * (2.0 - _MORE)


@helper
def error_of_t(geometry: Geometry, rest: RoundingRest, surface: int, ray: Ray, t: float) -> float:
    """Return a bound on |t - t*| for the crossing t* of a surface reported at t; inf if no bound can be proved."""
    if is_plane(geometry, surface):
        height, rate = plane_terms(geometry, rest, surface, ray, t)
        slope = _least(rate)
        return _most(height) / slope * _MORE if slope > 0.0 else math.inf
    a, b, c, discriminant = curved_terms(geometry, rest, surface, ray, t)
    value, slope, bend = _most(c), _least(b), _most(a)
    square = slope * slope - bend * value
    if slope > 0.0 and square > 0.0:
        bound = value / (slope + math.sqrt(square)) * _MORE
        # The other root must be farther away than the bound and the rounding of t, so that t* is the reported root
        if max(bound, abs(t) * 2.0**-50) * bend < 0.25 * math.sqrt(max(_least(discriminant), 0.0)):
            return bound
    if not _most(discriminant) < math.inf or not slope * slope < math.inf:
        return _error_of_large(_most(c), slope, _most(a), t)
    bend = _least(a)
    both = _most(b) + math.sqrt(max(discriminant.high, 0.0) + abs(discriminant.low) + discriminant.error)
    return both / bend * _MORE if bend > 0.0 else math.inf


@inline
def _error_of_large(value: float, slope: float, bend: float, t: float) -> float:
    """Return the bound from quotients of the coefficients, whose squares overflow float64."""
    if not (value < math.inf and bend < math.inf and slope > 0.0):
        return math.inf
    discriminant = 1.0 - bend / slope * (value / slope) * _MORE
    if not discriminant > 0.0:
        return math.inf
    bound = value / slope / (1.0 + math.sqrt(discriminant)) * _MORE
    near = max(bound, abs(t) * 2.0**-50) * (bend / slope) < 0.25 * math.sqrt(discriminant)
    return bound if near else math.inf


@kernel(origins="r 3", directions="r 3", which="n|0", t="n", surfaces="n", begin="0..end", end="0..n", errors="out n")
def errors_of_t(
    geometry: Geometry,
    rest: RoundingRest,
    origins: Floats,
    directions: Floats,
    which: Longs,
    t: Floats,
    surfaces: Ints,
    begin: int,
    end: int,
    errors: Floats,
) -> None:
    """Write errors[k], the bound for the crossing of ray which[k] with surfaces[k] at t[k]; 0 for surface -1.

    An empty `which` stands for 0, 1, 2, ...
    """
    last = end if len(which) > 0 else min(end, len(origins))
    for k in range(begin, last):
        errors[k] = 0.0
        if surfaces[k] >= 0:
            i = which[k] if len(which) > 0 else k
            ox, oy, oz = origins[i, 0], origins[i, 1], origins[i, 2]
            dx, dy, dz = directions[i, 0], directions[i, 1], directions[i, 2]
            ray, scale = scale_ray(Ray(ox, oy, oz, dx, dy, dz, 0.0, 1.0, whole(-1)))
            errors[k] = error_of_t(geometry, rest, surfaces[k], ray, t[k] / scale) * scale


@kernel(directions="n 3", points="n 3", t_errors="n", begin="0..end", end="0..n", errors="out n")
def errors_of_points(
    directions: Floats, points: Floats, t_errors: Floats, begin: int, end: int, errors: Floats
) -> None:
    """Write errors[i], a bound on |points[i] - (o + t* d)|; NaN for misses."""
    for i in range(begin, end):
        speed = hypot(directions[i, 0], directions[i, 1], directions[i, 2])
        size = hypot(points[i, 0], points[i, 1], points[i, 2])
        errors[i] = (t_errors[i] * speed + _ROUNDING_BOUND * size) * _MORE + _TINY


# Hits far from the origins of their rays
#
# origin + t direction is off by the rounding of t, which may be more than the whole body. The rest of the way from
# there to the surface is known to 30 digits, so the point is as near to the surface as its own rounding allows.


@helper
def _rest_of_way(
    geometry: Geometry, rest: RoundingRest, surface: int, ray: Ray, t: float, rises: bool
) -> BoundedPair:  # fmt: skip
    """Return t* - t for the crossing t* of a surface that is reported at t; its error is inf if it is not certain.

    Of the two roots of a curved surface, t* is the one where its value rises along the ray, or the other one.
    """
    if is_plane(geometry, surface):
        height, rate = plane_terms(geometry, rest, surface, ray, t)
        return opposite(over(height, rate)) if _least(rate) > 0.0 else BoundedPair(0.0, 0.0, math.inf)
    a, b, c, discriminant = curved_terms(geometry, rest, surface, ray, t)
    if not (discriminant.high > 0.0 and _least(discriminant) > 0.0):
        return BoundedPair(0.0, 0.0, math.inf)
    q = root(discriminant)
    q = q if rises else opposite(q)
    # Of the two forms of a root, the one that does not cancel
    return opposite(over(c, plus(b, q))) if (b.high >= 0.0) == rises else over(minus(q, b), a)


@kernel(
    origins="n 3", directions="n 3", t="n", turn="n", faces="3 n", begin="0..end", end="0..n", points="out n 3",
    errors="out n",
)  # fmt: skip
def refine_points(
    geometry: Geometry, rest: RoundingRest, origins: Floats, directions: Floats, t: Floats, turn: Signs, faces: Ints,
    begin: int, end: int, points: Floats, errors: Floats,
) -> None:  # fmt: skip
    """Move far points to their exact crossings, and write bounds on their errors; NaN for points that stay.

    `turn` is that of hits, `faces` as `faces_of` writes them. Where `turn` is 0, the crossing is the nearer of
    two: either t is rounded by less than half their distance, or they are as near to each other as t can show.
    """
    for i in range(begin, end):
        errors[i] = math.nan
        if faces[0, i] < 0 or not is_far(directions, t, points, i):
            continue
        ox, oy, oz = origins[i, 0], origins[i, 1], origins[i, 2]
        dx, dy, dz = directions[i, 0], directions[i, 1], directions[i, 2]
        ray, scale = scale_ray(Ray(ox, oy, oz, dx, dy, dz, 0.0, 1.0, whole(-1)))
        at = t[i] / scale
        # A ray enters against the outward normal, which is the gradient on side 1
        rises = ((turn[i] == 2) | (turn[i] == -2)) != (faces[2, i] > 0)
        onward = _rest_of_way(geometry, rest, faces[0, i], ray, at, rises)
        if turn[i] == 0:
            other = _rest_of_way(geometry, rest, faces[0, i], ray, at, not rises)
            onward = other if abs(other.high) < abs(onward.high) else onward
        x = plus(point_offset(ray.ox, 0.0, 0.0, at, ray.dx), times_float(onward, ray.dx))
        y = plus(point_offset(ray.oy, 0.0, 0.0, at, ray.dy), times_float(onward, ray.dy))
        z = plus(point_offset(ray.oz, 0.0, 0.0, at, ray.dz), times_float(onward, ray.dz))
        error = hypot(_most_lost(x), _most_lost(y), _most_lost(z)) * _MORE + _TINY
        if error < math.inf:
            points[i, 0], points[i, 1], points[i, 2], errors[i] = x.high + x.low, y.high + y.low, z.high + z.low, error


@inline
def _most_lost(x: BoundedPair) -> float:
    """Return a bound on the error of x rounded to a float."""
    return x.error + _ROUNDING_BOUND * abs(x.high + x.low)


# Bounds on t: from numbers in two floats, and from exact roots where these bounds are too large
#
# They are too large for roots along asymptotes of irrational forms. There the bound is the distance of the reported t
# from the nearest exact root (conicoid.geometry.exact_crossings).

_MUCH = 2.0**-24
"""The largest bound, as a share of |t| and of |o| / |d|, that an exact one does not replace."""
_BITS = 128  # precision of exact roots


def bounds_of_t(
    scene: PreparedScene, lines: tuple[FloatArray, FloatArray], starts: Any, which: Any, t: FloatArray, surfaces: Any
) -> FloatArray:
    """Return a bound on the error of each t[k], the crossing of ray which[k] with surfaces[k]; 0 for surface -1.

    lines: origins and directions (rays, 3); starts: surfaces on which rays start, one for all or one for each; which:
    empty for 0, 1, 2, ...
    """
    errors, arguments = np.empty(len(t)), (scene.geometry, scene.rest, *lines, which, t, surfaces)
    run_rows(errors_of_t, arguments, len(t), errors)
    large = np.flatnonzero(~(errors <= _MUCH * np.abs(t)) & (surfaces >= 0))
    ray = which[large] if len(which) else large
    origins, directions = lines[0][ray], lines[1][ray]
    with np.errstate(over="ignore"):
        size = np.abs(origins).max(axis=1, initial=0.0) / np.abs(directions).max(axis=1, initial=0.0)
    some = ~(errors[large] <= _MUCH * (np.abs(t[large]) + size))
    for k, origin, direction in zip(
        large[some].tolist(), origins[some].tolist(), directions[some].tolist(), strict=True
    ):
        found = list(exact_real_roots(exact_form(scene, int(surfaces[k])).along(integer_line(origin, direction))))
        i = int(which[k]) if len(which) else k
        if found and starts.size and starts[i if len(starts) > 1 else 0] == surfaces[k]:
            found.remove(min(found, key=lambda root: abs(float(root))))  # the crossing at the ray's origin
        errors[k] = min((_distance(root, float(t[k])) for root in found), default=errors[k])
    return errors


def _distance(root: Root, t: float) -> float:
    """Return the distance of a root from t, rounded up."""
    at, (above, below) = root.interval(_BITS), t.as_integer_ratio()
    gap = max(abs(end * below - above * at.unit) for end in (at.low, at.high))
    try:
        return nextafter(gap / (at.unit * below), inf)
    except OverflowError:
        return inf
