"""Support functions in closed form, sup u·p over a solid, and the tight bounds of moved shapes that follow from them.

Values are below the true one by no more than the direction's own rounding: products are rounded up where that matters,
and a sum of several terms is raised by a bound on its rounding error.
"""

from __future__ import annotations

import functools
import itertools
import math
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from fractions import Fraction
from typing import Any, TypeAlias

import numpy as np

from ..._util.records import BoxEnds, FloatArray, Vector, dot_rows, ignore_fp_errors, two_product, two_sum
from ...numerics import bigfloat as ex
from ...numerics.bigfloat import Symbol
from ...numerics.portable_math import (
    count_nonzero,
    hypot,
    is_finite,
    leading_sign,
    least_axis,
    negative_indicator,
    next_float,
    next_float_if,
    portable_max,
    portable_sqrt,
    rounded_sum,
    select_if_several,
)
from ...numerics.rational import dot3
from ...numerics.tracing import TracedBig, TracedFloat
from ..cell import UV, cartesian_uv
from ..surface import PlaneSurface, Triple
from ..transform import Motion
from .linear_program import are_ratios, integer_row

_SLACK = 8 * 2.0**-53
"""More than the relative rounding error of the few operations behind one term."""


def elliptic_support(
    width_x: float, width_y: float, profile: tuple[Any, Any, Any], low: float, high: float, direction: Vector
) -> float:
    """Return sup u·p over (x / width_x)² + (y / width_y)² <= g(z), low <= z <= high, in the direction u.

    `profile` = (g0, g1, g2) of g(z) = g0 + g1 z + g2 z², floats or fractions. At height z the section is an ellipse
    with support w sqrt(g), w = |(u_x width_x, u_y width_y)|. So the sup of u_z z + w sqrt(g(z)) over one variable
    remains: at an end, a root of g, a stationary point, or at infinity.
    """
    w, uz = hypot(direction[0] * width_x, direction[1] * width_y), float(direction[2])
    g0, g1, g2 = (float(g) for g in profile)
    best = -math.inf
    for z in real_roots(g2, g1, g0):
        if low <= z <= high:
            best = max(best, uz * z)
    for z in (low, high, *real_roots(*_stationary_heights(w, uz, g0, g1, g2))):
        if math.isfinite(z) and low <= z <= high:
            g = _evaluate_profile(profile, z)
            if g >= 0:
                best = max(best, sum_up((uz * z, product_with_root(w, g))))
    for end, sign in ((low, -1.0), (high, 1.0)):
        if math.isinf(end):
            best = max(best, _limit_at_infinity(w, sign * uz, g0, sign * g1, g2))
    return best


def _stationary_heights(w: Any, uz: Any, g0: Any, g1: Any, g2: Any) -> tuple[float, float, float]:
    """Return the coefficients, highest power first, of w² g'² = 4 u_z² g, scaled if floats may not hold them."""
    steep = w * w * g2 - uz * uz
    a, b, c = 4 * g2 * steep, 4 * g1 * steep, w * w * g1 * g1 - 4 * uz * uz * g0
    if isinstance(a, Fraction):
        largest = max(abs(a), abs(b), abs(c)) or Fraction(1)
        return float(a / largest), float(b / largest), float(c / largest)
    if all(factor == 0 or 1 / _LARGE < abs(factor) < _LARGE for factor in (w, uz, g0, g1, g2)):
        return a, b, c
    return _stationary_heights(*map(Fraction, (w, uz, g0, g1, g2)))


def sum_up(terms: Iterable[float]) -> float:
    """Return the sum of terms, raised by a bound on the rounding error if several terms are not 0."""
    items = list(terms)
    count = count_nonzero(items)
    total = rounded_sum(items) + 0.0
    return select_if_several(count, total + _SLACK * rounded_sum(abs(term) for term in items), total)


def product_with_root(w: float, g: Any) -> float:
    """Return w sqrt(g), not below the exact value."""
    if w == 0 or g == 0:
        return 0.0
    value = w * math.sqrt(g)
    if Fraction(value) ** 2 < Fraction(w) ** 2 * Fraction(g):
        return math.nextafter(value, math.inf)
    return value


def inverse_root(a: Any) -> float:
    """Return 1 / sqrt(a), the half-axis of a x² = 1, not below the exact value; a > 0 is a float or fraction."""
    if isinstance(a, (TracedFloat, TracedBig)):
        root: Any = 1 / portable_sqrt(ex.rounded(a))
        for _ in range(2):  # a root and a quotient, each rounded down, may lose two units in the last place
            root = next_float_if(root, ex.rounded(ex.ONE - a.exact() * root.exact() ** 2))
        return root
    if isinstance(a, Symbol):
        return 1 / portable_sqrt(a)
    value = 1 / math.sqrt(a)
    while Fraction(a) * Fraction(value) ** 2 < 1:
        value = math.nextafter(value, math.inf)
    return value


@ignore_fp_errors
def inverse_roots(numbers: FloatArray) -> FloatArray:
    """Return `inverse_root` of many floats."""
    roots = 1 / np.sqrt(numbers)
    square, lost = two_product(roots, roots)
    product, off = two_product(numbers, square)
    rest, gone = two_product(numbers, lost)
    over = (product - 1) + off + rest + gone
    is_exact = (product == 1) & (off == 0) & (lost == 0)
    raised = np.nextafter(roots, np.inf)
    is_enough = over + 2 * (raised - roots) / roots > _PAIR_ROUNDING
    is_sure = ((over > _PAIR_ROUNDING) | (over < -_PAIR_ROUNDING) & is_enough) & (numbers > 1 / _LARGE)
    is_sure &= numbers < _LARGE
    roots = np.where(is_sure & (over < 0), raised, roots)
    for place in np.argwhere(~(is_sure | is_exact)).tolist():
        roots[tuple(place)] = inverse_root(float(numbers[tuple(place)]))
    return roots


def points_support(points: Iterable[Vector], direction: Vector) -> float:
    """Return sup u·p over points, and so over their convex hull."""
    return functools.reduce(
        portable_max, (sum_up(u * c for u, c in zip(direction, point, strict=True)) for point in points)
    )


def _evaluate_profile(profile: tuple[Any, Any, Any], z: float) -> Any:
    """Return g(z) in rational arithmetic: near the end of a solid its terms cancel."""
    g0, g1, g2 = (Fraction(g) for g in profile)
    height = Fraction(z)
    return g0 + height * (g1 + height * g2)


def _limit_at_infinity(w: float, uz: float, g0: float, g1: float, g2: float) -> float:
    """Return the limit of u_z z + w sqrt(g(z)) as z grows: -inf if g turns negative, inf if rounding leaves it open."""
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
    """Yield the real roots of a z² + b z + c, by the formula without cancellation; none if all of it vanishes."""
    # z in a unit in which a and c are of one size: the discriminant does not underflow
    unit = (math.frexp(c)[1] - math.frexp(a)[1]) // 2 if a != 0 and c != 0 else 0
    sizes = zip((a, b, c), (2 * unit, unit, 0), strict=True)
    scale = -max((math.frexp(x)[1] + more for x, more in sizes if x != 0), default=0)
    a, b, c = math.ldexp(a, scale + 2 * unit), math.ldexp(b, scale + unit), math.ldexp(c, scale)
    d = b * b - 4 * a * c
    if d < 0:
        return
    q = -(b + math.copysign(math.sqrt(d) if a * c != 0 else abs(b), b)) / 2
    half, rest = math.ldexp(1.0, unit // 2), math.ldexp(1.0, unit - unit // 2)
    if a != 0:
        yield q / a * half * rest
    if q != 0:
        yield c / q * half * rest


# Supports of many shapes at once, each in several directions


def raised_sums(terms: FloatArray) -> FloatArray:
    """Return sums along the last axis, as `sum_up` of many: raised by a bound on their rounding error."""
    return _raised_sum([terms[..., k] for k in range(terms.shape[-1])])


def _raised_sum(terms: Sequence[FloatArray]) -> FloatArray:
    """Return the sums of two arrays or more, as `raised_sums`."""
    first, *rest = terms
    total = functools.reduce(np.add, terms)
    size = np.abs(first) + functools.reduce(np.add, map(np.abs, rest))
    several = functools.reduce(np.add, [(term != 0).view(np.int8) for term in terms]) > 1
    return np.where(several, total + 2 * _SLACK * size, total)


def plane_lengths(x: FloatArray, y: FloatArray) -> FloatArray:
    """Return sqrt(x² + y²) of many, even if squares overflow or vanish."""
    most = np.maximum(np.abs(x), np.abs(y))
    unit = np.where(most > 0, most, 1.0)
    return np.asarray(most * np.sqrt((x / unit) ** 2 + (y / unit) ** 2))


def _roots(a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
    """Return `real_roots` of many equations along a last axis of two; NaN for none."""
    scale = np.ldexp(1.0, -np.frexp(np.maximum(np.maximum(np.abs(a), np.abs(b)), np.abs(c)))[1])
    a, b, c = a * scale, b * scale, c * scale
    # A discriminant that underflows: one of its terms alone would not, as a root of it
    root = np.where(a * c == 0, np.abs(b), np.sqrt(b * b - 4 * a * c))
    q = -(b + np.copysign(root, b)) / 2
    return np.stack([np.where(a != 0, q / a, np.nan), np.where(q != 0, c / q, np.nan)], axis=-1)


_THIN = 2.0**-20
"""A solid whose height is less than this share of its distance has its support from fractions."""
_LARGE = 1e70
"""Products of four numbers below this, and above its inverse, neither overflow nor underflow."""


Pair: TypeAlias = tuple[FloatArray, FloatArray]
"""Sums of two floats each, the second below an ulp of the first."""
_PAIR_ROUNDING = 2.0**-90
"""More than the relative error of a few operations with pairs."""


def pair_polynomial(z: FloatArray, coefficients: Sequence[Pair]) -> Pair:
    """Return c0 + c1 z + c2 z² of many."""
    constant, *higher = coefficients
    total, rest = higher[1]
    for more, lost in (higher[0], constant):
        product, off = two_product(total, z)
        total, off_sum = two_sum(product, more)
        rest = rest * z + off + off_sum + lost
    return two_sum(total, rest)


def pair_above(high: FloatArray, low: FloatArray) -> FloatArray:
    """Return the least floats that are not below pairs, but for `_PAIR_ROUNDING`."""
    return np.where(low > _PAIR_ROUNDING * np.abs(high), np.nextafter(high, np.inf), high)


def _roots_above(w: FloatArray, g: Pair) -> FloatArray:
    """Return `product_with_root` of many."""
    value = w * np.sqrt(g[0])
    for _ in range(2):  # its error is above an ulp
        square, lost = two_product(w, w)
        bound, off = two_product(square, g[0])
        own, own_off = two_product(value, value)
        over = (own - bound) + (own_off - off - square * g[1] - lost * g[0])
        value = np.where(over < -_PAIR_ROUNDING * bound, np.nextafter(value, np.inf), value)
    return value


@ignore_fp_errors
def elliptic_supports(solids: FloatArray, rests: FloatArray, directions: FloatArray) -> FloatArray:
    """Return `elliptic_support` of n solids in m directions each; NaN where it takes fractions.

    It does so for thin, endless or extreme solids, and along their axis where they end in a point. Along other axes the
    support is computed with pairs of floats. In all other directions a bound on the rounding error of g raises it.

    Parameters
    ----------
    solids : array (n, 7)
        The two widths, g0, g1, g2, the lower and the upper end.
    rests : array (n, 3)
        What g0, g1, g2 are above these floats.
    directions : array (n, m, 3)
        The directions.
    """
    width_x, width_y, g0, g1, g2, low, high = (column[:, None] for column in solids.T)
    w, uz = plane_lengths(directions[..., 0] * width_x, directions[..., 1] * width_y), directions[..., 2]
    steep = w * w * g2 - uz * uz
    still = _roots(4 * g2 * steep, 4 * g1 * steep, w * w * g1 * g1 - 4 * uz * uz * g0)
    ends = np.broadcast_to(np.concatenate([low, high, _roots(g2, g1, g0)[:, 0]], axis=1)[:, None], (*w.shape, 4))
    z = np.concatenate([ends, still], axis=-1)
    terms = np.stack([g0[..., None] + 0 * z, g1[..., None] * z, g2[..., None] * z * z])
    error = 2 * _SLACK * np.abs(terms).sum(axis=0)
    g = terms.sum(axis=0)
    there = (z >= low[..., None]) & (z <= high[..., None]) & (g >= -error)
    reach = raised_sums(np.stack([uz[..., None] * z, w[..., None] * np.sqrt(np.maximum(g, 0) + error)], axis=-1))
    best = np.where(there, reach, -np.inf).max(axis=-1)
    # Along an axis: the widest section, or the end of the solid if it is no point
    pairs = [(solids[:, 2 + k, None], rests[:, k, None]) for k in range(3)]
    middle = np.clip(np.where(g2 < 0, -0.5 * g1 / g2, low), low, high)
    sections = np.stack([np.stack(pair_polynomial(at, pairs)) for at in (low, high, middle)])
    widest = np.take_along_axis(sections, sections[:, :1].argmax(axis=0)[None], axis=0)[0]
    end = uz * np.where(uz > 0, high, low)
    best = np.where((w == 0) & (best != end), np.nan, best)
    is_sideways = (uz == 0) & ((directions[..., 0] == 0) | (directions[..., 1] == 0))
    best = np.where(is_sideways, _roots_above(w, (widest[0], widest[1])), best)
    size = np.maximum(np.abs(low), np.abs(high))
    known = (high - low > _THIN * size) & np.isfinite(size) & np.isfinite(best)
    for factor in map(np.abs, (w, uz, g0, g1, g2)):
        # A stationary height is lost where a product of four factors overflows or underflows
        known &= (factor == 0) | ((factor > 1 / _LARGE) & (factor < _LARGE))
    return np.where(known, best, np.nan)


_BOUNDARY, _BOX_GROWTH = 1e-13, 64 * 2.0**-53
"""The box grows by the first share, the quadric by the second share of its terms: bounds err outward."""


def boxed_supports(quadrics: FloatArray, frames: FloatArray, ends: FloatArray, directions: FloatArray) -> FloatArray:
    """Return the supports (n, m) of n quadrics f <= 0 that boxes cut, in m directions each; -inf for nothing.

    They are the largest values at corners, at ends of edges on the quadric and at stationary points in faces. No
    stationary point inside the box is missed. Saddles and hyperbolic cylinders are nowhere locally convex, and on a
    parabolic cylinder a linear function is stationary along whole rulings, which reach the box.

    Parameters
    ----------
    quadrics : array (n, 7)
        Squares, linear coefficients and constant of f = Σ squares x² + 2 linear·x - constant.
    frames : array (n, 3, 4)
        The maps from the frames of the boxes.
    ends : array (n, 2, 3)
        Low and high corners of the boxes in their frames.
    directions : array (n, m, 3)
        The directions.
    """
    squares, linear, constant = quadrics[:, :3], quadrics[:, 3:6], quadrics[:, 6]
    turn, shift = frames[:, :, :3], frames[:, :, 3]
    corner = dot_rows(turn, ends[:, :1]) + shift
    edges = turn * (ends[:, 1] - ends[:, 0])[:, None]
    across = np.swapaxes(edges, 1, 2)
    # f = tᵀ second t + 2 first·t + zeroth of the point corner + edges t, 0 <= t <= 1
    second = dot_rows(across[:, :, None], (squares[:, None] * across)[:, None])
    first = dot_rows((squares * corner + linear)[:, None], across)
    reach = np.abs(corner) + np.abs(edges).sum(axis=2)
    terms = dot_rows(np.abs(squares), reach**2) + 2 * dot_rows(np.abs(linear), reach) + np.abs(constant)
    # Much more than the rounding error of f, and of its roots where f is nearly flat
    zeroth = dot_rows(corner, squares * corner + 2 * linear) - constant - _BOX_GROWTH * terms
    slope = dot_rows(directions[:, :, None], across[:, None])

    def value(t: FloatArray) -> FloatArray:
        """f at points (n, m, p, 3)."""
        t_second = dot_rows(t[..., None, :], second[:, None, None])
        return dot_rows(t_second, t) + 2 * dot_rows(first[:, None, None], t) + zeroth[:, None, None]

    def on_lines(start: FloatArray, line: FloatArray) -> FloatArray:
        """The points of lines (n, m, p, 3) with f = 0, (n, m, 2 p, 3)."""
        a = dot_rows(dot_rows(line[..., None, :], second[:, None, None]), line)
        b = 2 * dot_rows(line, dot_rows(start[..., None, :], second[:, None, None]) + first[:, None, None])
        roots = _roots(a, b, value(start))
        points = start[..., None, :] + roots[..., None] * line[..., None, :]
        return points.reshape(*points.shape[:2], -1, 3)

    corners = np.array(list(itertools.product((0.0, 1.0), repeat=3)))[None, None]
    own = np.where(corners > 0, ends[:, None, None, 1], ends[:, None, None, 0])
    places = dot_rows(turn[:, None, None], own[..., None, :]) + shift[:, None, None]
    at_corners = raised_sums(directions[:, :, None] * places)
    best = np.where(value(corners) <= 0, at_corners, -np.inf).max(axis=-1)
    starts = np.array(
        [np.insert(np.array(t), i, 0.0) for i in range(3) for t in itertools.product((0.0, 1.0), repeat=2)]
    )
    found = [on_lines(starts[None, None], np.repeat(np.eye(3), 4, axis=0)[None, None])]
    from_faces, in_faces = np.zeros((2, *slope.shape[:2], 6, 3))
    for i in range(3):
        j, k = (m for m in range(3) if m != i)
        along = np.zeros(slope.shape)
        along[..., j], along[..., k] = -slope[..., k], slope[..., j]
        along /= np.maximum(np.abs(along).max(axis=-1, keepdims=True), np.finfo(float).tiny)
        # ∇f·along = 0 is a line across `normal` in the face
        normal = dot_rows(along[..., None, :], second[:, None])[..., [j, k]]
        size = np.abs(normal).max(axis=-1)
        normal = normal / size[..., None]
        for end in (0, 1):
            start, line = from_faces[:, :, 2 * i + end], in_faces[:, :, 2 * i + end]
            start[..., i], line[..., j], line[..., k] = end, -normal[..., 1], normal[..., 0]
            gradient = dot_rows(start[..., None, :], second[:, None]) + first[:, None]
            start[..., [j, k]] = (-dot_rows(gradient, along) / size / dot_rows(normal, normal))[..., None] * normal
    found.append(on_lines(from_faces, in_faces))
    own = np.moveaxis(directions * corner[:, None], 2, 0)[..., None]
    for t in found:
        inside = ((t >= -_BOUNDARY) & (t <= 1 + _BOUNDARY)).all(axis=-1)
        sums = _raised_sum([*own, *(slope[:, :, None, k] * t[..., k] for k in range(3))])
        best = np.maximum(best, np.where(inside, sums, -np.inf).max(axis=-1))
    return np.minimum(best, at_corners.max(axis=-1))


def along_normal(normal: Vector, direction: Vector) -> float | None:
    """Return k with direction = k normal, decided exactly; None if they are not parallel."""
    n, u = tuple(Fraction(c) for c in normal), tuple(Fraction(c) for c in direction)
    largest = max(range(3), key=lambda i: abs(n[i]))
    multiple = u[largest] / n[largest]
    return float(multiple) if all(c == multiple * d for c, d in zip(u, n, strict=True)) else None


# Planes: their anchor, uv coordinates and bounds


def plane_through(normal: Triple, offset: Any, near: Sequence[Any] = (0.0, 0.0, 0.0)) -> PlaneSurface:
    """Return the plane normal·x = offset, not rescaled, anchored at the foot of the perpendicular from `near`."""
    anchor: list[Any]
    if are_ratios((*normal, offset, *near)):
        (a, b, c, end), (*point, unit) = integer_row((*normal, offset)), integer_row((*near, 1.0))
        square = a * a + b * b + c * c
        rise, below = end * unit - dot3((a, b, c), point), unit * square
        anchor = [Fraction(p * square + rise * k, below) for p, k in zip(point, (a, b, c), strict=True)]
        is_rounded = not all(map(_fits_a_float, anchor))
    else:
        n, anchor = [ex.rational(c) for c in normal], [ex.rational(c) for c in near]
        along = [k for k in range(3) if n[k]]
        if len(along) == 1:  # nothing is rounded if the quotient is a float
            foot = anchor[along[0]] = ex.rational(offset) / n[along[0]]
            is_rounded = bool(ex.exact(foot) - ex.exact(ex.rounded(foot)))
        else:
            over = (ex.rational(offset) - dot3(n, anchor)) / dot3(n, n)
            anchor, is_rounded = [p + over * c for p, c in zip(anchor, n, strict=True)], bool(over)
    return PlaneSurface(normal, offset, (anchor[0], anchor[1], anchor[2]), 0.0, is_offset_better=is_rounded)


def _fits_a_float(ratio: Fraction) -> bool:
    """Return whether a float within the range of exponents certainly holds a ratio."""
    return ratio.numerator.bit_length() <= 53 and ratio.denominator & (ratio.denominator - 1) == 0


def plane_uv(surface: PlaneSurface) -> UV:
    """Return Cartesian coordinates on a plane about its anchor.

    u points to the coordinate axis along which the normal is least, v = normal × u, both of unit length.
    """
    if are_ratios((*surface.normal, *surface.anchor)):
        return cartesian_uv(*_integer_directions(integer_row(surface.normal)), tuple(map(float, surface.anchor)))  # type: ignore[arg-type]
    normal, anchor = ex.unit(ex.exact_row(surface.normal)), ex.exact_row(surface.anchor)
    # In this order no terms cancel: components that are 0 on paper are 0 here too, also in the numbers of a recording
    second = ex.unit(ex.cross(normal, ex.exact_row(least_axis(ex.exact_row(surface.normal)))))
    return cartesian_uv(ex.rounded_row(ex.cross(second, normal)), ex.rounded_row(second), ex.rounded_row(anchor))


def _integer_directions(normal: Sequence[int]) -> tuple[Vector, Vector]:
    """Return u and v of `plane_uv` for a normal of integers: the same floats in a fiftieth of the time.

    With e the axis of least n·e, u is along n² e - (n·e) n and v along n × e. Both have integers over a root.
    """
    square = sum(c * c for c in normal)
    k = min(range(3), key=lambda i: abs(normal[i]))
    across = square - normal[k] ** 2
    u = [_over_root((square if i == k else 0) - normal[k] * normal[i], square * across) for i in range(3)]
    v = [0.0, 0.0, 0.0]
    v[k - 2], v[k - 1] = _over_root(normal[k - 1], across), _over_root(-normal[k - 2], across)
    return (u[0], u[1], u[2]), (v[0], v[1], v[2])


_ROOT_BITS = 140
"""Twice the bits of a root before it is rounded, and more than a few."""


def _over_root(top: int, square: int) -> float:
    """Return top / sqrt(square), the nearest float; |top| <= sqrt(square)."""
    if not top:
        return 0.0
    shift = _ROOT_BITS + square.bit_length() - 2 * top.bit_length()
    shift += shift % 2
    found, rest = divmod(top * top << shift, square)
    root = math.isqrt(found)
    # The last bit stands for all that follow
    root = 2 * root + (rest != 0 or root * root != found)
    return math.copysign(root / (1 << (shift // 2 + 1)), top)


def half_space_bounds(surface: PlaneSurface, below: bool = True, above: bool = True) -> BoxEnds:
    """Return the bounds of normal·x <= offset (`below`), of >= offset (`above`), or of the plane itself (both).

    An end is finite only if the normal lies along an axis.
    """
    low: list[Any] = [-math.inf] * 3
    high: list[Any] = [math.inf] * 3
    normal = ex.exact_row(surface.normal)
    across = [i for i in range(3) if normal[i]]
    if len(across) == 1:
        i = across[0]
        if surface.over is None:
            height = ex.exact(surface.offset) / normal[i]
        else:  # the quotient is 0 where the anchor is on the plane
            height = ex.cancelling_sum((ex.exact(surface.anchor[i]), -surface.height / normal[i]))
        if below if normal[i] > 0 else above:
            high[i] = round_up(height)
        if above if normal[i] > 0 else below:
            low[i] = -round_up(-height)
    # Of numbers of a recording, too
    return np.array(low) + 0.0, np.array(high)


def round_up(value: ex.BigFloat) -> float:
    """Return the least float64 that is not below a 3000-bit number."""
    result = ex.rounded(value)
    if not is_finite(result):
        return result if result > 0 else -sys.float_info.max
    return next_float_if(result, ex.rounded(value - ex.exact(result)))


def corners_support(corners: Iterable[ex.Row], direction: Vector) -> float:
    """Return sup u·p over points known to thousands of bits, and so over their convex hull."""
    best = -float("inf")
    for corner in corners:
        best = portable_max(best, sum_up(u * _end_towards(u, c) for u, c in zip(direction, corner, strict=True)))
    return best


def _end_towards(u: float, c: ex.BigFloat) -> float:
    """Return the float at or above a number for u >= 0, else the one at or below it; no test in a recorded formula."""
    if isinstance(u, Symbol):
        return select_if_several(2.0 * negative_indicator(u), -round_up(-c), round_up(c))
    return -round_up(-c) if u < 0 else round_up(c)


# Bounds of a moved shape from its support, rounded outward

_NO_UNDERFLOW = 1e-150
"""Products of numbers above this with numbers of the domain do not underflow."""


def bound_by_support(support: Callable[[Vector], float], motion: Motion) -> list[float]:
    """Return (low x, y, z, high x, y, z) of a shape if `motion` carries its own frame to the world.

    `support` is h, the support in that frame. The moved shape has h(Lᵀ e) + t·e along each axis e, rounded outward. If
    row e of L has a single entry k, then h(Lᵀ e) = |k| h(±e'): only h itself and the end are rounded, and an end that
    is 0 in exact arithmetic is 0. The same holds in other rows if h is 0 in floats, since `support` raises every sum of
    several terms.
    """
    simple = motion.is_identity or motion.shift is not None
    low: list[float] = []
    high: list[float] = []
    for i, (*row, shift) in enumerate(motion.rows):
        single = not (simple or count_nonzero(row) >= 2)
        towards = [count_nonzero((entry,)) * leading_sign((entry,)) for entry in row] if single else row
        for sign, ends in ((1.0, high), (-1.0, low)):
            x, y, z = towards if sign > 0 else (0.0 - entry for entry in towards)
            reach = support((x, y, z))
            if single:
                ends.append(_scale_end(reach, motion, i, sign))
            elif not shift and reach == 0 and _is_nothing(motion, i):
                ends.append(0.0)
            else:
                ends.append(_round_outward(reach, shift if sign > 0 else -shift, simple))
    return [*(0.0 - end for end in low), *high]


def _is_nothing(motion: Motion, row: int) -> bool:
    """Return True if a row's exact shift is 0 and no product of its entries underflows to 0."""
    if motion.shift is not None:
        return True
    rows, shift = motion.affine
    return not shift[row] and all(abs(entry) > _NO_UNDERFLOW for entry in rows[row] if entry)


def _scale_end(reach: float, motion: Motion, row: int, sign: float) -> float:
    """Return the least float64 not below |k| reach + sign·shift, where k is the one entry of the row that is not 0."""
    if not is_finite(reach):
        return reach
    rows, shift = motion.affine
    size = ex.total(map(abs, rows[row]))
    return round_up(ex.cancelling_sum((size * ex.exact(reach), sign * shift[row])))


def _round_outward(reach: float, shift: float, exact: bool) -> float:
    """Return an upper bound of reach + shift; the nearest one for a translation alone, whose floats are exact."""
    total = reach + shift
    if not is_finite(total):
        return total
    if not exact:
        return next_float(total + 4 * 2.0**-53 * (abs(reach) + abs(shift)))
    # Knuth's TwoSum: the rounding error of the sum
    part = total - reach
    lost = (reach - (total - part)) + (shift - part)
    return next_float_if(total, lost)
