"""Is a ray inside a closed loop of points? Even-odd, as in geometry/polygon.py, in rational numbers."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from .forms import SURE, is_rounded, vector

Seen = tuple[Fraction, Fraction]  # a coordinate as the ray sees it, and by how much it may be off


def passes_within(corners: Sequence[Sequence[Any]], origin: Sequence[float], direction: Sequence[float]) -> bool:
    """`corners` of three exact numbers each."""
    sizes = [abs(d) for d in direction]
    axis = 2 if sizes[2] >= max(sizes[0], sizes[1]) else (0 if sizes[0] >= sizes[1] else 1)
    first, second = ((1, 2), (2, 0), (0, 1))[axis]
    o, d, rounded = vector(origin), vector(direction), is_rounded(x for corner in corners for x in corner)
    seen: list[tuple[Seen, Seen]] = []
    for corner in corners:
        p = vector(corner)
        u, v = (
            _sum([d[axis] * p[k], -d[axis] * o[k], -d[k] * p[axis], d[k] * o[axis]], rounded) for k in (first, second)
        )
        seen.append((u, v))
    odd = False
    ua, va = seen[-1]
    for ub, vb in seen:
        if (va[0] < 0) != (vb[0] < 0):
            side = _cross(ua, vb) - _cross(ub, va)
            off = _cross_off(ua, vb) + _cross_off(ub, va)
            odd ^= side > off if vb[0] > va[0] else side < -off
        ua, va = ub, vb
    return odd


def _sum(terms: Sequence[Fraction], rounded: bool) -> Seen:
    """A sum; 0 where it cannot be told from that."""
    value, off = sum(terms, Fraction(0)), sum(map(abs, terms), Fraction(0)) / 2**SURE if rounded else Fraction(0)
    return (value, off) if abs(value) > off else (Fraction(0), Fraction(0))


def _cross(a: Seen, b: Seen) -> Fraction:
    return a[0] * b[0]


def _cross_off(a: Seen, b: Seen) -> Fraction:
    return abs(a[0]) * b[1] + abs(b[0]) * a[1] + a[1] * b[1]
