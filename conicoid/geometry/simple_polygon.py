"""Closed outlines in a plane: checks of their points, and of crossings in exact fractions."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import numpy as np

from .._util.validation import check_numbers

MAX_CORNERS = 20_000


def check_outline(owner: str, field: str, outline: Any) -> tuple[tuple[float, float], ...]:
    """Return the points of an outline, without points that repeat the one before. Raise ValueError if invalid."""
    try:
        rows = list(outline)
    except TypeError:
        raise ValueError(f"{owner}: {field} must be three or more points of two numbers") from None
    if not 3 <= len(rows) <= MAX_CORNERS:
        expected = f"from 3 to {MAX_CORNERS:,} points of two numbers"
        raise ValueError(f"{owner}: {field} must have {expected}, got {len(rows):,}")
    points = [check_numbers(owner, f"{field}[{k}]", row, 2) for k, row in enumerate(rows)]
    distinct = [(p[0], p[1]) for k, p in enumerate(points) if p != points[k - 1]]
    if len(distinct) < 3 or not twice_area([(Fraction(x), Fraction(y)) for x, y in distinct]):
        raise ValueError(f"{owner}: {field} must enclose an area")
    return tuple(distinct)


def twice_area(points: Sequence[Any]) -> Any:
    """Return twice the signed area, positive for counter-clockwise points."""
    following = [*points[1:], points[0]]
    return sum((a[0] * b[1] - a[1] * b[0] for a, b in zip(points, following, strict=True)), Fraction(0))


def check_simple(owner: str, field: str, outline: Sequence[tuple[float, float]]) -> None:
    """Raise ValueError if edges have a common point, other than the corner of neighbours."""
    points = [(Fraction(x), Fraction(y)) for x, y in outline]
    count = len(points)
    edges = [(points[k], points[(k + 1) % count]) for k in range(count)]
    ends = np.array(outline), np.roll(np.array(outline), -1, axis=0)
    lows, highs = np.minimum(*ends), np.maximum(*ends)
    for k in range(count):
        near = (lows[k + 1 :] <= highs[k]).all(axis=1) & (highs[k + 1 :] >= lows[k]).all(axis=1)
        for other in (np.flatnonzero(near) + k + 1).tolist():
            if _edges_cross(edges[k], edges[other], (other - k) % count == 1 or (k - other) % count == 1):
                raise ValueError(f"{owner}: {field} must not cross or touch itself, edges {k} and {other} do")


def _edges_cross(one: Any, other: Any, neighbours: bool) -> bool:
    """Return True if two edges have a common point, other than the corner of neighbours."""
    (a, b), (c, d) = one, other
    sides = [_orientation(a, b, c), _orientation(a, b, d), _orientation(c, d, a), _orientation(c, d, b)]
    if neighbours:  # they have another common point only if one goes back along the other
        back = (b[0] - a[0]) * (d[0] - c[0]) + (b[1] - a[1]) * (d[1] - c[1])
        return sides == [0, 0, 0, 0] and back < 0
    if sides[0] * sides[1] < 0 and sides[2] * sides[3] < 0:
        return True
    ends = ((sides[0], c, a, b), (sides[1], d, a, b), (sides[2], a, c, d), (sides[3], b, c, d))
    return any(side == 0 and _in_box(p, q, r) for side, p, q, r in ends)


def _orientation(a: Any, b: Any, c: Any) -> int:
    value = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    return int(value > 0) - int(value < 0)


def _in_box(p: Any, a: Any, b: Any) -> bool:
    return all(min(a[i], b[i]) <= p[i] <= max(a[i], b[i]) for i in (0, 1))
