"""Nearest points of a quadric from its secular equation, in its principal axes about the query point.

With f(x + v) = value + sum 2 g_i v_i + a_i v_i², the points v where the distance to f = 0 is stationary have
v_i = -g_i / (s + a_i) for the s (one over Lagrange's multiplier) where

    F(s) = f(x + v(s)) = value - sum g_i² (2 s + a_i) / (s + a_i)²

vanishes: f at the displaced point. Far from the surface its terms cancel, so F is evaluated about an origin near the
quadric (`Secular`). It has six roots at most, less where some a_i or g_i are zero. Local minima have at most one
s + a_i of another sign than s. So, s taken positive (else all signs turn), they are above the largest pole, where F
rises and the only root is the nearest point of all, or between the two largest poles, where F falls in s. (Moré,
Sorensen: Computing a trust region step, SIAM J. Sci. Stat. Comput. 4, 1983; Martínez: Local minimizers of quadratic
functions on Euclidean balls and spheres, SIAM J. Optim. 4, 1994; Eberly: Distance from a point to an ellipse, an
ellipsoid, or a hyperellipsoid.)

Where g_i is zero the root may be the pole itself, and v_i is free: a center, an axis, a plane of symmetry. There g_i is
set to 2^-50 of the value that moving the point by its distance would give it, and the general formulas apply. The
distance changes by no more than that displacement of the point.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..._jit.decorators import choose, helper, inline
from ..numbers.vectors import dot
from .form import Axes, SurfaceForm, parts_along

NEAR_POLE = 2.0**-50
"""Least g_i at the largest pole, as a share of the value that moving the point by its distance would give it."""
_STEPS = 200
_CLOSE = 1.0 + 2.0**-50
NONE, OPEN = -1.0, -2.0  # in place of a root w: no root; a search that ended too early


class Secular(NamedTuple):
    """The terms of a secular equation, a0 <= a1 <= a2, of about 1.

    About an origin near the quadric f(p) = constant + sum 2 b_i p_i + a_i p_i², x is the query point there, and
    value = f(x), g_i = a_i x_i + b_i.
    """

    value: float
    g0: float
    g1: float
    g2: float
    a0: float
    a1: float
    a2: float
    constant: float
    x0: float
    x1: float
    x2: float
    b0: float
    b1: float
    b2: float


@inline
def least_bend(equation: Secular, length: float) -> Secular:
    """Return the equation with g0 raised to its least value (`NEAR_POLE`), for a point at `length` from its surface."""
    value, g0, g1, g2, a0, a1, a2, constant, x0, x1, x2, b0, b1, b2 = equation
    least = abs(a0) * length * NEAR_POLE
    if abs(g0) < least:
        g0 = math.copysign(least, g0)
        x0 = (g0 - b0) / a0
    return Secular(value, g0, g1, g2, a0, a1, a2, constant, x0, x1, x2, b0, b1, b2)


@inline
def negate_secular(equation: Secular) -> Secular:
    """Return the equation of -f."""
    value, g0, g1, g2, a0, a1, a2, constant, x0, x1, x2, b0, b1, b2 = equation
    return Secular(-value, -g2, -g1, -g0, -a2, -a1, -a0, -constant, x2, x1, x0, -b2, -b1, -b0)


@inline
def _part(g: float, a: float, b: float, x: float, beyond: float, s: float) -> tuple[float, float]:
    """Return (the part of f along an axis at p = x + v(s), its derivative by s), for beyond = s + a.

    p = x - g / (s + a) = (s x - b) / (s + a), without the cancellation for a point far from the surface.
    """
    r = 1.0 / beyond
    p, q, share = (s * r) * x - b * r, g * r, s * r
    return p * (a * p + 2.0 * b), 2.0 * (q * q) * share


@inline
def _above(e: Secular, pole: float, w: float) -> tuple[float, float]:
    """Return (F, its slope) at s = pole + w."""
    s = pole + w
    f0, d0 = _part(e.g0, e.a0, e.b0, e.x0, w + (e.a0 + pole), s)
    f1, d1 = _part(e.g1, e.a1, e.b1, e.x1, w + (e.a1 + pole), s)
    f2, d2 = _part(e.g2, e.a2, e.b2, e.x2, w + (e.a2 + pole), s)
    return e.constant + ((f0 + f1) + f2), (d0 + d1) + d2


@helper
def nearest_root(e: Secular) -> float:
    """Return w of the root s = pole + w, pole = max(0, -a0), rounded so that F >= 0 holds; NONE for no root.

    Relies on value > 0. |v| at that w is a lower bound of the distance: points with f < F(s) are farther away.
    """
    pole = max(0.0, -e.a0)
    slope = math.sqrt(e.g0 * e.g0 + e.g1 * e.g1 + e.g2 * e.g2)
    if slope == 0.0:
        return NONE
    high = max(slope * (slope + math.sqrt(slope * slope + e.value)) / e.value, pole)
    # Bracket the root: F >= 0 at high, F < 0 at low
    steps = 0
    while _above(e, pole, high)[0] < 0.0 and steps < _STEPS:
        high, steps = 8.0 * high, steps + 1
    # The factor is squared each time: a root near the pole may be many orders of magnitude below
    low, factor = high, 0.5
    while _above(e, pole, low)[0] >= 0.0 and steps < _STEPS:
        high, low, factor, steps = low, low * factor, factor * factor, steps + 1
        if low < 1e-200:
            return NONE
    # Newton's steps, or geometric bisection every fourth time and where a step leaves the bracket
    w = high
    for k in range(_STEPS):
        if high <= low * _CLOSE:
            break
        value, slope = _above(e, pole, w)
        if value >= 0.0:
            high = w
        else:
            low = w
        step = w - value / slope if slope > 0.0 else 0.0
        inside = (step > low) & (step < high)
        if inside & (abs(step - w) <= 2.0**-51 * w):
            w = step * (1.0 + 2.0**-50)
            if w < high and _above(e, pole, w)[0] >= 0.0:
                high = w
                break
            w = math.sqrt(low) * math.sqrt(high)
            continue
        w = step if inside and (k & 3) != 3 else math.sqrt(low) * math.sqrt(high)
    return high


@inline
def place_above(e: Secular, w: float) -> tuple[float, float, float]:
    """Return v at s = pole + w."""
    pole = max(0.0, -e.a0)
    v1 = -e.g1 / (w + (e.a1 + pole)) if e.g1 != 0.0 else 0.0
    v2 = -e.g2 / (w + (e.a2 + pole)) if e.g2 != 0.0 else 0.0
    return (-e.g0 / (w + (e.a0 + pole)) if e.g0 != 0.0 else 0.0), v1, v2


@inline
def place_below(e: Secular, w: float) -> tuple[float, float, float]:
    """Return v at s = -a0 - w."""
    v1 = -e.g1 / ((e.a1 - e.a0) - w) if e.g1 != 0.0 else 0.0
    v2 = -e.g2 / ((e.a2 - e.a0) - w) if e.g2 != 0.0 else 0.0
    return e.g0 / w, v1, v2


@inline
def _sums(e: Secular, w: float) -> tuple[float, float, float, float]:
    """Return, at s = -a0 - w, minus the part of the pole, minus the sum of the others, and the absolute slopes."""
    s = -e.a0 - w
    f0, d0 = _part(e.g0, e.a0, e.b0, e.x0, -w, s)
    f1, d1 = _part(e.g1, e.a1, e.b1, e.x1, (e.a1 - e.a0) - w, s)
    f2, d2 = _part(e.g2, e.a2, e.b2, e.x2, (e.a2 - e.a0) - w, s)
    return -f0, -(f1 + f2), -d0, d1 + d2


@helper
def next_root(e: Secular, start: float) -> tuple[float, float]:
    """Return (w of the next root s = -a0 - w beyond `start` where F rises with w, NONE or OPEN; next `start`).

    Between the poles F is the difference of two rising functions, so its range over an interval follows from both ends:
    intervals grow while F is certainly not zero or certainly monotonic, and shrink where neither is certain.
    """
    end = -e.a0 - max(0.0, -e.a1)
    # The second pole itself, where F has no value, is left out
    last = end * (1.0 - 2.0**-40)
    a, more = start, 2.0
    if is_cone(e) and e.a1 > 0.0:
        # F has the sign of F / s², which falls in s; its own slope vanishes with s, at the apex
        t0, u0, _, _ = _sums(e, a)
        t1, u1, _, _ = _sums(e, last)
        found = (a < last) & (e.constant - t0 - u0 < 0.0) & (e.constant - t1 - u1 >= 0.0)
        return (_between(e, a, last), end) if found else (NONE, end)
    for _ in range(40 * _STEPS):
        if a >= last:
            return NONE, end
        b = max(min(a * more, end - 0.25 * (end - a)), a * (1.0 + 2.0**-45))
        t0, u0, _, _ = _sums(e, a)
        t1, u1, _, _ = _sums(e, b)
        low, high, rises = e.constant - t0 - u0, e.constant - t1 - u1, _least_rise(e, a, b) > 0.0
        none = (e.constant - t0 - u1 > 0.0) | (e.constant - t1 - u0 < 0.0) | (_most_rise(e, a, b) < 0.0)
        if none or (rises and (low >= 0.0) == (high >= 0.0)):
            a, more = b, min(more * more, 16.0)
        elif rises:
            return (_between(e, a, b), b) if low < 0.0 else (NONE, b)
        elif b <= a * (1.0 + 2.0**-40):
            return a, b  # a double root, or nearly one
        else:
            more = 1.0 + 0.25 * (b / a - 1.0)
    return OPEN, end


@inline
def is_cone(e: Secular) -> bool:
    """Return whether f is a cone with its apex at the origin, or two planes through it."""
    return (e.constant == 0.0) & (e.b0 == 0.0) & (e.b1 == 0.0) & (e.b2 == 0.0)


@inline
def _least_rise(e: Secular, a: float, b: float) -> float:
    """Return a lower bound of dF/dw on [a, b]."""
    # Each factor at the end where it is largest or least: a bound over the interval, not a value in it
    s, most = -e.a0 - b, -e.a0 - a
    q = e.g0 / b
    first = 2.0 * (q * q) * (max(s, 0.0) / b)
    return first - _rate(e.g1, (e.a1 - e.a0) - b, most) - _rate(e.g2, (e.a2 - e.a0) - b, most)


@inline
def _most_rise(e: Secular, a: float, b: float) -> float:
    """Return an upper bound of dF/dw on [a, b]."""
    s, least = -e.a0 - a, max(-e.a0 - b, 0.0)
    q = e.g0 / a
    first = 2.0 * (q * q) * (s / a)
    return first - _rate(e.g1, (e.a1 - e.a0) - a, least) - _rate(e.g2, (e.a2 - e.a0) - a, least)


@inline
def _rate(g: float, gap: float, s: float) -> float:
    """Return g² 2 s / gap³."""
    q = g / gap if g != 0.0 else 0.0
    return 2.0 * (q * q) * (s / gap)


@helper
def _between(e: Secular, low: float, high: float) -> float:
    """Return the root between `low`, where F < 0, and `high`, where F >= 0; F rises there."""
    for _ in range(_STEPS):
        if high <= low * _CLOSE:
            break
        w = math.sqrt(low) * math.sqrt(high)
        t, u, p, r = _sums(e, w)
        value, slope = e.constant - t - u, p - r
        step = w - value / slope if slope > 0.0 else 0.0
        if value >= 0.0:
            high = w
        else:
            low = w
        if (step > low) & (step < high):
            t, u, p, r = _sums(e, step)
            value = e.constant - t - u
            if value >= 0.0:
                high = step
            else:
                low = step
            if abs(step - w) <= 2.0**-50 * w:
                return step
    return high


# The nearest point of a quadric in a few steps, for one point or for lanes of points
#
# With f > 0 at the point, the root of the secular equation above the largest pole is the s at which
#
#     T(s) = sum g_i² (2 s + a_i) / (s + a_i)²
#
# has fallen to f. All terms are positive and fall there, like 1 / (s - pole)² at first and like 1 / s later, so
# 1 / sqrt(T) is nearly linear in s, and Newton's method is applied to it (the device of Moré and Sorensen). It begins
# at the larger of two guesses, the end of the line along the gradient and the s at which the term of the largest pole
# alone has fallen to f, and converges in three to ten steps except for rare cases, which `nearest_root` decides.
#
# The result does not depend on convergence: T(s) <= f is tested at the end, and any such s is a proof.

STEPS = 14
_LAST_STEP = 2.0**-26
"""Largest change of the last step, which doubles the digits, as a share of w."""
_LAST_STEPS = 4


class PositiveSecular(NamedTuple):
    """A secular equation of f or -f, whichever is positive at the point, scaled to terms of about 1, in no order."""

    value: float
    g0: float
    g1: float
    g2: float
    a0: float
    a1: float
    a2: float
    pole: float


class RootSearch(NamedTuple):
    """State of the search for s = pole + w; the root lies between low and high."""

    w: float
    low: float
    high: float
    done: float  # 1.0 once w has converged


@inline
def positive_secular(form: SurfaceForm, axes: Axes, scale: float, plain: float) -> PositiveSecular:
    """Return the equation about the form's point, which is at least `plain` from the surface, as `least_bend`."""
    side = math.copysign(scale, form.value)
    g0, g1, g2 = parts_along(axes.along, form.gx * side, form.gy * side, form.gz * side)
    a0, a1, a2 = axes.a0 * side, axes.a1 * side, axes.a2 * side
    first = a0 <= a2
    least = abs(min(a0, a2)) * plain * NEAR_POLE
    g0 = choose(first & (abs(g0) < least), math.copysign(least, g0), g0)
    g2 = choose((a2 < a0) & (abs(g2) < least), math.copysign(least, g2), g2)
    return PositiveSecular(form.value * side, g0, g1, g2, a0, a1, a2, max(0.0, -min(a0, a2)))


@inline
def first_guess(e: PositiveSecular) -> RootSearch:
    """Return the start of the search."""
    square = dot(e.g0, e.g1, e.g2, e.g0, e.g1, e.g2)
    bent = dot(e.a0 * e.g0, e.a1 * e.g1, e.a2 * e.g2, e.g0, e.g1, e.g2)
    along = (square + math.sqrt(max(square * square - e.value * bent, 0.0))) / e.value - bent / square
    steep = choose(e.a0 <= e.a2, e.g0 * e.g0, e.g2 * e.g2)
    alone = (steep + math.sqrt(steep * (steep + e.value * e.pole))) / e.value
    most = (square + math.sqrt(square * (square + e.value * e.pole))) / e.value
    w = min(max(along - e.pole, choose(e.pole > 0.0, alone, 0.0)), most)
    return RootSearch(choose(w > 0.0, w, 0.25 * most), 0.0, math.inf, 0.0)


@inline
def _search_value(e: PositiveSecular, w: float) -> tuple[float, float]:
    """Return (T, -T' / 2) at s = pole + w."""
    s, u0, u1, u2 = e.pole + w, w + (e.a0 + e.pole), w + (e.a1 + e.pole), w + (e.a2 + e.pole)
    r0, r1, r2 = 1.0 / u0, 1.0 / u1, 1.0 / u2
    q0, q1, q2 = e.g0 * r0, e.g1 * r1, e.g2 * r2
    q0, q1, q2 = q0 * q0, q1 * q1, q2 * q2
    return q0 * (s + u0) + q1 * (s + u1) + q2 * (s + u2), s * (q0 * r0 + q1 * r1 + q2 * r2)


@inline
def next_step(e: PositiveSecular, at: RootSearch) -> RootSearch:
    """Return the search after one step; unchanged where it is done."""
    t, fall = _search_value(e, at.w)
    beyond = t > e.value
    low, high = choose(beyond, at.w, at.low), choose(beyond, at.high, at.w)
    # Newton's step for 1 / sqrt(T)
    w = at.w + (math.sqrt(t / e.value) - 1.0) * t / fall
    w = choose(w < low, choose(low > 0.0, math.sqrt(low) * math.sqrt(at.w), 0.125 * at.w), w)
    w = choose(w > high, math.sqrt(high) * math.sqrt(at.w), w)
    # Convergence is quadratic: a step of 2^-26 leaves an error of about 2^-52
    near = abs(w - at.w) <= _LAST_STEP * w
    over = at.done == 1.0
    return RootSearch(
        choose(over, at.w, w), choose(over, at.low, low), choose(over, at.high, high), choose(over | near, 1.0, 0.0)
    )


@inline
def safe_root(e: PositiveSecular, w: float) -> float:
    """Return the least of three w, a little above the given one, at which T <= f holds; NaN if none does."""
    safe = math.nan
    for k in range(3):
        # A little above: the distance falls by as little, and T <= f then holds despite rounding
        more = w * (1.0 + (2.0**-41 if k == 0 else (2.0**-45 if k == 1 else 2.0**-49)))
        safe = choose(_search_value(e, more)[0] <= e.value, more, safe)
    return safe


@inline
def root_distance(e: PositiveSecular, w: float) -> float:
    """Return |v| at s = pole + w."""
    v0, v1, v2 = e.g0 / (w + (e.a0 + e.pole)), e.g1 / (w + (e.a1 + e.pole)), e.g2 / (w + (e.a2 + e.pole))
    return math.sqrt(dot(v0, v1, v2, v0, v1, v2))


@inline
def with_value(e: PositiveSecular, value: float) -> PositiveSecular:
    """Return the equation with another value of f, nearer to zero."""
    return PositiveSecular(value, e.g0, e.g1, e.g2, e.a0, e.a1, e.a2, e.pole)


@helper
def root_above(e: Secular) -> float:
    """`nearest_root`, in a few steps where they converge; NONE for no root. Relies on value > 0."""
    if (e.g0 == 0.0) & (e.g1 == 0.0) & (e.g2 == 0.0):
        return NONE
    equation = PositiveSecular(e.value, e.g0, e.g1, e.g2, e.a0, e.a1, e.a2, max(0.0, -e.a0))
    at = first_guess(equation)
    for _ in range(STEPS):
        at = next_step(equation, at)
        if at.done == 1.0:
            w = at.w
            # T cancels with f where the surface is much nearer to its center than to the point
            for _ in range(_LAST_STEPS):
                f, slope = _above(e, equation.pole, w)
                step = f / slope
                if not abs(step) < 0.5 * w:
                    break
                w -= step
                if abs(step) <= _LAST_STEP * w:
                    return w
            break
    return nearest_root(e)
