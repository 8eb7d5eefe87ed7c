"""Which bodies a ray is in on both sides of a wall, in whole numbers: boxes and balls of integers, rays of integers.

Nothing here is rounded. A wall of a box is at t = p / q, a wall of a ball at t = (p + s √D) / q, s = -1, 0 or 1; so any
of them is (p + r √D) / q with integers, and the sign of a linear form of it is the sign of u + v √D, by squares. On a
ball the form of another ball is linear: their difference. Where a form is 0 at the wall, its slope says what it is on
either side; a ball that is touched is not entered.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

Ints = Any


@dataclass(frozen=True)
class Place:
    """t = (p + r √D) / q for each of n rays, q > 0; `ball`: which ball (c, R²) it is on, or None."""

    p: Ints
    r: Ints
    D: Ints
    q: Ints
    ball: tuple[Ints, int] | None


def sign_of_root(u: Ints, v: Ints, D: Ints) -> Ints:
    """The sign of u + v √D."""
    one, other = np.sign(u), np.sign(v) * np.sign(D)
    size = np.sign(u * u - v * v * D)
    return np.where(one == other, one, np.where(one == 0, other, np.where(other == 0, one, one * size)))


def linear(alpha: Ints, beta: Ints, t: Place) -> Ints:
    """The sign of alpha + beta t."""
    return sign_of_root(alpha * t.q + beta * t.p, beta * t.r, t.D)


def wall_of_box(box: Any, axis: Ints, high: Ints, o: Ints, d: Ints) -> Place:
    """Where rays cross planes of a box."""
    rows = np.arange(len(o))
    plane = np.where(high, np.array(box[1])[axis], np.array(box[0])[axis])
    along = d[rows, axis]
    p, nothing = (plane - o[rows, axis]) * np.sign(along), np.zeros(len(o), np.int64)
    return Place(p, nothing, nothing, abs(along), None)


def wall_of_ball(ball: Any, low: Ints, o: Ints, d: Ints) -> Place:
    """Where rays cross a ball: the first root, or the second one."""
    c, square = np.array(ball[0]), ball[1]
    a, b = (d * d).sum(1), (d * (o - c)).sum(1)
    D = b * b - a * (((o - c) ** 2).sum(1) - square)
    return Place(-b, np.where(low, -1, 1), D, a, (c, square))


def half_space(height: Ints, rate: Ints, t: Place) -> tuple[Ints, Ints]:
    """(is height + rate t negative just before t, and just after)"""
    at = linear(height, rate, t)
    return np.where(at == 0, rate > 0, at < 0), np.where(at == 0, rate < 0, at < 0)


def in_box(box: Any, o: Ints, d: Ints, t: Place) -> tuple[Ints, Ints]:
    before, after = np.ones(len(o), bool), np.ones(len(o), bool)
    for k in range(3):
        for sense, plane in ((1, box[1][k]), (-1, box[0][k])):
            was, now = half_space(sense * (o[:, k] - plane), sense * d[:, k], t)
            before, after = before & was, after & now
    return before, after


def in_ball(ball: Any, o: Ints, d: Ints, t: Place) -> tuple[Ints, Ints]:
    c, square = np.array(ball[0]), ball[1]
    if t.ball is None:  # at a rational t: |q (o - c) + p d|² - q² R²
        x = t.q[:, None] * (o - c) + t.p[:, None] * d
        at, slope = np.sign((x * x).sum(1) - t.q * t.q * square), np.sign((x * d).sum(1))
    else:
        other, its = t.ball
        alpha = 2 * (o * (other - c)).sum(1) + (c * c).sum() - (other * other).sum() - square + its
        at = linear(alpha, 2 * (d * (other - c)).sum(1), t)
        slope = linear((d * (o - c)).sum(1), (d * d).sum(1), t)
    return np.where(at == 0, slope > 0, at < 0), np.where(at == 0, slope < 0, at < 0)


def in_leaf(leaf: Any, o: Ints, d: Ints, t: Place) -> tuple[Ints, Ints]:
    return in_box(leaf[1:], o, d, t) if leaf[0] == "box" else in_ball(leaf[1:], o, d, t)


def in_body(body: Any, o: Ints, d: Ints, t: Place) -> tuple[Ints, Ints]:
    """A body is a leaf, or ("or" | "and" | "less", leaf, leaf)."""
    if body[0] in ("box", "ball"):
        return in_leaf(body, o, d, t)
    (a, b), (x, y) = in_leaf(body[1], o, d, t), in_leaf(body[2], o, d, t)
    if body[0] == "or":
        return a | x, b | y
    return (a & x, b & y) if body[0] == "and" else (a & ~x, b & ~y)


def sides(bodies: Any, clear: Any, o: Ints, d: Ints, t: Place) -> tuple[Ints, Ints]:
    """(before, after): the first transparent body, where there is none the first opaque one, else -1."""
    found = []
    every = [in_body(body, o, d, t) for body in bodies]
    for side in (0, 1):
        result = np.full(len(o), -1)
        for number in [n for n, is_clear in enumerate(clear) if is_clear] + [n for n, c in enumerate(clear) if not c]:
            result = np.where((result < 0) & every[number][side], number, result)
        found.append(result)
    return found[0], found[1]
