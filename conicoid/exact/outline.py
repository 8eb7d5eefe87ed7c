"""Is a ray inside a closed loop of points? Even-odd, as in geometry/polygon.py, in rational numbers."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from .forms import is_rounded, total, vector


def passes_within(corners: Sequence[Sequence[Any]], origin: Sequence[float], direction: Sequence[float]) -> bool:
    """`corners` of three exact numbers each."""
    sizes = [abs(d) for d in direction]
    axis = 2 if sizes[2] >= max(sizes[0], sizes[1]) else (0 if sizes[0] >= sizes[1] else 1)
    first, second = ((1, 2), (2, 0), (0, 1))[axis]
    o, d, rounded = vector(origin), vector(direction), is_rounded(x for corner in corners for x in corner)
    seen: list[tuple[Fraction, Fraction]] = []
    for corner in corners:
        p = vector(corner)
        u, v = (
            total([d[axis] * p[k], -d[axis] * o[k], -d[k] * p[axis], d[k] * o[axis]], rounded) for k in (first, second)
        )
        seen.append((u, v))
    odd = False
    ua, va = seen[-1]
    for ub, vb in seen:
        if (va < 0) != (vb < 0):
            side = total([ua * vb, -ub * va], rounded)
            odd ^= side > 0 if vb > va else side < 0
        ua, va = ub, vb
    return odd
