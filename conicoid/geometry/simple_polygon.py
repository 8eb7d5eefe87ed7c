"""Closed outlines in a plane: their points as written, and whether they cross themselves, decided in fractions."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import numpy as np

from .._util.validation import check_numbers

MAX_CORNERS = 20_000


def check_outline(owner: str, field: str, outline: Any) -> tuple[tuple[float, float], ...]:
    """Three or more different points, none twice in a row. ValueError otherwise."""
    try:
        rows = list(outline)
    except TypeError:
        raise ValueError(f"{owner}: {field} must be three or more points of two numbers") from None
    if not 3 <= len(rows) <= MAX_CORNERS:
        told = f"from 3 to {MAX_CORNERS:,} points of two numbers"
        raise ValueError(f"{owner}: {field} must have {told}, got {len(rows):,}")
    found = [check_numbers(owner, f"{field}[{k}]", row, 2) for k, row in enumerate(rows)]
    kept = [(p[0], p[1]) for k, p in enumerate(found) if p != found[k - 1]]
    if len(kept) < 3 or not twice_area([(Fraction(x), Fraction(y)) for x, y in kept]):
        raise ValueError(f"{owner}: {field} must enclose an area")
    return tuple(kept)


def twice_area(points: Sequence[Any]) -> Any:
    """Twice the signed area, positive where the points are counter-clockwise."""
    following = [*points[1:], points[0]]
    return sum((a[0] * b[1] - a[1] * b[0] for a, b in zip(points, following, strict=True)), Fraction(0))


def check_simple(owner: str, field: str, outline: Sequence[tuple[float, float]]) -> None:
    """Edges that are no neighbours must not meet, and neighbours only in their corner."""
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
    """Do two edges have a point in common, but for the corner of neighbours?"""
    (a, b), (c, d) = one, other
    sides = [_orientation(a, b, c), _orientation(a, b, d), _orientation(c, d, a), _orientation(c, d, b)]
    if neighbours:  # they meet elsewhere only where one goes back along the other
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
