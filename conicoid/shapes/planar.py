"""What everything flat shares: a plane with its anchor, uv coordinates on it, and its bounds."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from . import exact as ex
from .cells import UV, flat
from .rounded import above_if, along_least, is_finite, larger
from .support import sum_up
from .surface import PlaneSurface, Triple
from .vector import Box, Vector


def plane_through(normal: Triple, offset: Any, near: Sequence[Any] = (0.0, 0.0, 0.0)) -> PlaneSurface:
    """normal·x = offset as written, anchored at the foot of the perpendicular from `near`."""
    n = [ex.rational(c) for c in normal]
    point = [ex.rational(c) for c in near]
    over = (ex.rational(offset) - sum(a * b for a, b in zip(n, point, strict=True))) / sum(c * c for c in n)
    x, y, z = (p + over * c for p, c in zip(point, n, strict=True))
    return PlaneSurface(normal, offset, (x, y, z))


def plane_uv(surface: PlaneSurface) -> UV:
    """Cartesian coordinates on a plane, about its anchor.

    u points to the coordinate axis that is least along the normal, v = normal × u, both of unit length.
    """
    normal, anchor = ex.unit(ex.exact_row(surface.normal)), ex.exact_row(surface.anchor)
    towards = ex.exact_row(along_least(ex.exact_row(surface.normal)))
    along = ex.dot(towards, normal)
    x, y, z = (ex.dot((t, along), (ex.ONE, -n)) for t, n in zip(towards, normal, strict=True))
    first = ex.unit((x, y, z))
    return flat(_floats(first), _floats(ex.cross(normal, first)), _floats(anchor))


def half_space_bounds(surface: PlaneSurface, below: bool = True, above: bool = True) -> Box:
    """Bounds of normal·x <= offset (`below`), >= offset (`above`), or of the plane itself (both).

    Finite only where the normal lies along an axis.
    """
    low, high = np.full(3, -np.inf), np.full(3, np.inf)
    normal = ex.exact_row(surface.normal)
    across = [i for i in range(3) if normal[i]]
    if len(across) == 1:
        i = across[0]
        height = ex.exact(surface.offset) / normal[i]
        if below if normal[i] > 0 else above:
            high[i] = rounded_up(height)
        if above if normal[i] > 0 else below:
            low[i] = -rounded_up(-height)
    return low + 0.0, high


def rounded_up(value: ex.Exact) -> float:
    """The least float64 that is not below a 3000-bit number."""
    result = ex.rounded(value)
    if not is_finite(result):
        return result if result > 0 else -sys.float_info.max
    return above_if(result, ex.rounded(value - ex.exact(result)))


def corners_support(corners: Iterable[ex.Row], direction: Vector) -> float:
    """sup of u·p over points known to thousands of bits, and so over their convex hull."""
    best = -float("inf")
    for corner in corners:
        terms = [u * (rounded_up(c) if u > 0 else -rounded_up(-c)) for u, c in zip(direction, corner, strict=True)]
        best = larger(best, sum_up(term for term, u in zip(terms, direction, strict=True) if u))
    return best


def _floats(row: ex.Row) -> Vector:
    return ex.rounded(row[0]), ex.rounded(row[1]), ex.rounded(row[2])
