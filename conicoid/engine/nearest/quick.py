"""The nearest point of all on a quadric in a few steps, for one point or for lanes of points.

With f > 0 at the point, the root of the secular equation (`secular`) above the largest pole is where

    T(s) = sum g_i² (2 s + a_i) / (s + a_i)²

has come down to f. All terms are positive and fall there, like 1 / (s - pole)² at first and like 1 / s later, so
1 / sqrt(T) is nearly straight in s and Newton's steps are taken for that (the device of Moré and Sorensen). They begin
at the larger of two guesses, the place where the line along the gradient ends and that where the largest pole alone has
come down, and converge in three to ten steps for all but odd cases, which `nearest_root` decides.

What is told does not rest on that: T(s) <= f is tested where it ends, and any such s is a proof.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ...compiler.jit import choose, helper, inline
from ..numbers.vectors import dot
from .axes import Axes, parts_along
from .form import Form
from .secular import NEAR_POLE, NONE, Secular, nearest_root

STEPS = 14
_DONE = 2.0**-26
"""Share of w by which the last of its steps, which double its digits, changes it at most."""


class Turned(NamedTuple):
    """A secular equation of f or -f, whichever is positive at the point, in terms of about 1, in no order."""

    value: float
    g0: float
    g1: float
    g2: float
    a0: float
    a1: float
    a2: float
    pole: float


class Search(NamedTuple):
    """s = pole + w; the root is between low and high."""

    w: float
    low: float
    high: float
    done: float  # 1.0 once w is found


@inline
def turned(form: Form, axes: Axes, scale: float, plain: float) -> Turned:
    """The equation about the form's point, which is at least `plain` from the surface (`secular.least_bend`)."""
    side = math.copysign(scale, form.value)
    g0, g1, g2 = parts_along(axes.along, form.gx * side, form.gy * side, form.gz * side)
    a0, a1, a2 = axes.a0 * side, axes.a1 * side, axes.a2 * side
    first = a0 <= a2
    least = abs(min(a0, a2)) * plain * NEAR_POLE
    g0 = choose(first & (abs(g0) < least), math.copysign(least, g0), g0)
    g2 = choose((a2 < a0) & (abs(g2) < least), math.copysign(least, g2), g2)
    return Turned(form.value * side, g0, g1, g2, a0, a1, a2, max(0.0, -min(a0, a2)))


@inline
def first_guess(e: Turned) -> Search:
    """Where steps begin."""
    square = dot(e.g0, e.g1, e.g2, e.g0, e.g1, e.g2)
    bent = dot(e.a0 * e.g0, e.a1 * e.g1, e.a2 * e.g2, e.g0, e.g1, e.g2)
    along = (square + math.sqrt(max(square * square - e.value * bent, 0.0))) / e.value - bent / square
    steep = choose(e.a0 <= e.a2, e.g0 * e.g0, e.g2 * e.g2)
    alone = (steep + math.sqrt(steep * (steep + e.value * e.pole))) / e.value
    most = (square + math.sqrt(square * (square + e.value * e.pole))) / e.value
    w = min(max(along - e.pole, choose(e.pole > 0.0, alone, 0.0)), most)
    return Search(choose(w > 0.0, w, 0.25 * most), 0.0, math.inf, 0.0)


@inline
def _falling(e: Turned, w: float) -> tuple[float, float]:
    """(T, -T' / 2) at s = pole + w."""
    s, u0, u1, u2 = e.pole + w, w + (e.a0 + e.pole), w + (e.a1 + e.pole), w + (e.a2 + e.pole)
    r0, r1, r2 = 1.0 / u0, 1.0 / u1, 1.0 / u2
    q0, q1, q2 = e.g0 * r0, e.g1 * r1, e.g2 * r2
    q0, q1, q2 = q0 * q0, q1 * q1, q2 * q2
    return q0 * (s + u0) + q1 * (s + u1) + q2 * (s + u2), s * (q0 * r0 + q1 * r1 + q2 * r2)


@inline
def next_step(e: Turned, at: Search) -> Search:
    """One step; none where the search is done."""
    t, fall = _falling(e, at.w)
    beyond = t > e.value
    low, high = choose(beyond, at.w, at.low), choose(beyond, at.high, at.w)
    w = at.w + (math.sqrt(t / e.value) - 1.0) * t / fall
    w = choose(w < low, choose(low > 0.0, math.sqrt(low) * math.sqrt(at.w), 0.125 * at.w), w)
    w = choose(w > high, math.sqrt(high) * math.sqrt(at.w), w)
    near = abs(w - at.w) <= _DONE * w
    over = at.done == 1.0
    return Search(
        choose(over, at.w, w), choose(over, at.low, low), choose(over, at.high, high), choose(over | near, 1.0, 0.0)
    )


@inline
def proved(e: Turned, w: float) -> float:
    """w or a little more, where T <= f certainly has been seen; NaN where none has."""
    found = math.nan
    for k in range(3):
        more = w * (1.0 + (2.0**-41 if k == 0 else (2.0**-45 if k == 1 else 2.0**-49)))
        found = choose(_falling(e, more)[0] <= e.value, more, found)
    return found


@inline
def reached(e: Turned, w: float) -> float:
    """|v| at s = pole + w."""
    v0, v1, v2 = e.g0 / (w + (e.a0 + e.pole)), e.g1 / (w + (e.a1 + e.pole)), e.g2 / (w + (e.a2 + e.pole))
    return math.sqrt(dot(v0, v1, v2, v0, v1, v2))


@inline
def with_value(e: Turned, value: float) -> Turned:
    """The same of an f that is nearer to zero."""
    return Turned(value, e.g0, e.g1, e.g2, e.a0, e.a1, e.a2, e.pole)


@helper
def root_above(e: Secular) -> float:
    """`nearest_root` in a few steps where they lead there; NONE where there is none. Relies on value > 0."""
    if (e.g0 == 0.0) & (e.g1 == 0.0) & (e.g2 == 0.0):
        return NONE
    equation = Turned(e.value, e.g0, e.g1, e.g2, e.a0, e.a1, e.a2, max(0.0, -e.a0))
    at = first_guess(equation)
    for _ in range(STEPS):
        at = next_step(equation, at)
        if at.done == 1.0:
            w = proved(equation, at.w)
            return w if w < math.inf else nearest_root(e)
    return nearest_root(e)
