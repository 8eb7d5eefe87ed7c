"""When two crossings are so near that rounding may have changed their order (docs/exactness.md)."""

from __future__ import annotations

import math
from typing import TypeAlias

from ..jit import choose, inline
from .tables import Geometry, Ray

Nearness: TypeAlias = tuple[float, float, float]
"""what t may be off by, as a share of t, and the size of t beyond which nothing is certain"""

STARTING = 1024.0
"""So many times less certain is a ray that starts on a surface, beside which its origin was rounded."""
BALL, BALL_FAR, RELATIVE = 2.0**-21, 2.0**45, 2.0**-44


@inline
def ray_size(ox: float, oy: float, oz: float, inverse: float) -> float:
    """|o| / |d|, or a little more."""
    return (abs(ox) + abs(oy) + abs(oz)) * math.sqrt(inverse)


@inline
def lengths_of(geometry: Geometry, table: int, row: int) -> Nearness:
    """The limits of a cell, program, sheet or polygon, for |d| = 1: row `row` of its table."""
    at = geometry.places[table, 0] + 3 * row
    f = geometry.floats
    return f[at], f[at + 1], f[at + 2]


@inline
def nearness_of(geometry: Geometry, table: int, row: int, ray: Ray, inverse: float) -> Nearness:
    """The same for the t of a ray."""
    off, share, far = lengths_of(geometry, table, row)
    return along(ray, inverse, off, share, far)


@inline
def ball_nearness(radius: float, ray: Ray, inverse: float) -> Nearness:
    return along(ray, inverse, BALL * radius, RELATIVE, BALL_FAR * radius)


@inline
def along(ray: Ray, inverse: float, off: float, share: float, far: float) -> Nearness:
    """Limits of lengths as limits of t."""
    size, unit = ray_size(ray[0], ray[1], ray[2], inverse), math.sqrt(inverse)
    beside = size * STARTING if ray[8] >= 0 else size
    return off * unit + share * beside, share, far * unit - size


@inline
def finite(t: float) -> float:
    """t, or 0 where it is infinite."""
    return choose(abs(t) < math.inf, t, 0.0)


@inline
def near(s: float, t: float, nearness: Nearness) -> bool:
    """Might rounding have changed the order of two crossings? False where one is infinite."""
    size = choose(abs(s) < abs(t), abs(s), abs(t))
    return (abs(s - t) <= nearness[0] + nearness[1] * size) & (size < math.inf)
