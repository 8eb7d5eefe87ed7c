"""Is a ray inside a closed loop of points? Even-odd, as in engine/surface/loop.py, in exact arithmetic."""

from __future__ import annotations

from collections.abc import Sequence

from ..shapes import exact as ex


def passes_within(corners: Sequence[ex.Row], origin: Sequence[float], direction: Sequence[float]) -> bool:
    """`corners` of three exact numbers each. What cannot be told from zero is zero."""
    sizes = [abs(d) for d in direction]
    axis = 2 if sizes[2] >= max(sizes[0], sizes[1]) else (0 if sizes[0] >= sizes[1] else 1)
    first, second = ((1, 2), (2, 0), (0, 1))[axis]
    o, d = ex.exact_row(origin), ex.exact_row(direction)
    seen = [
        tuple(
            ex.dot((d[axis], -d[axis], -d[k], d[k]), (p[k], o[k], p[axis], o[axis]))
            for k in (first, second)
        )
        for p in map(ex.exact_row, corners)
    ]  # fmt: skip
    odd = False
    ua, va = seen[-1]
    for ub, vb in seen:
        if (va < 0) != (vb < 0):
            side = ex.dot((ua, -ub), (vb, va))
            odd ^= side > 0 if vb > va else side < 0
        ua, va = ub, vb
    return odd
