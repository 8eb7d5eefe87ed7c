"""Is a ray inside a closed loop of points? Even-odd, as in geometry/polygon.py, in rational numbers."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from .forms import vector


def passes_within(vertices: Any, origin: Sequence[float], direction: Sequence[float]) -> bool:
    """vertices (n, 3)."""
    sizes = [abs(d) for d in direction]
    axis = 2 if sizes[2] >= max(sizes[0], sizes[1]) else (0 if sizes[0] >= sizes[1] else 1)
    first, second = ((1, 2), (2, 0), (0, 1))[axis]
    o, d = vector(origin), vector(direction)
    seen: list[tuple[Fraction, Fraction]] = []
    for vertex in vertices.tolist():
        p = [a - b for a, b in zip(vector(vertex), o, strict=True)]
        seen.append((d[axis] * p[first] - d[first] * p[axis], d[axis] * p[second] - d[second] * p[axis]))
    odd = False
    ua, va = seen[-1]
    for ub, vb in seen:
        if (va < 0) != (vb < 0):
            side = ua * vb - ub * va
            odd ^= side > 0 if vb > va else side < 0
        ua, va = ub, vb
    return odd
