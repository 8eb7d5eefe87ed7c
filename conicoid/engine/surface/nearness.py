"""When two crossings are so near that rounding may have changed their order (docs/exactness.md)."""

from __future__ import annotations

import math
from typing import TypeAlias

from ...compiler.jit import inline
from ..ray import Ray
from ..tables import Geometry

Nearness: TypeAlias = tuple[float, float]
"""what t may be off by, and the size of t beyond which nothing is certain"""

STARTING = 1024.0
"""So many times less certain is a ray that starts on a surface, beside which its origin was rounded."""
RELATIVE = 2.0**-44
"""Share of |o| and of |x| by which t may be off, whatever it is crossed."""
BESIDE = STARTING * RELATIVE
"""Share of |x| by which whatever culls is widened, as far as the origin of a ray may lie beside the surface on which it
starts: a ray within the outermost plane of a body would miss the body's own box."""
BALL, BALL_FAR = 2.0**-21, 2.0**45


@inline
def ray_unit(dx: float, dy: float, dz: float, inverse: float) -> float:
    """1 / |d|, or up to 1.74 times that: it takes no root."""
    return (abs(dx) + abs(dy) + abs(dz)) * inverse


@inline
def ray_size(ox: float, oy: float, oz: float, unit: float) -> float:
    """|o| / |d|, or a little more."""
    return (abs(ox) + abs(oy) + abs(oz)) * unit


@inline
def lengths_of(geometry: Geometry, table: int, row: int) -> Nearness:
    """The limits of a cell, program, sheet or polygon, for |d| = 1: row `row` of its table."""
    at = geometry.places[table] + 2 * row
    return geometry.floats[at], geometry.floats[at + 1]


@inline
def lengths_of_ball(x: float, y: float, z: float, radius: float) -> Nearness:
    return BALL * radius + RELATIVE * (abs(x) + abs(y) + abs(z) + radius), BALL_FAR * radius


@inline
def nearness_of(geometry: Geometry, table: int, row: int, ray: Ray, inverse: float) -> Nearness:
    """The limits of a cell, program, sheet or polygon for the t of a ray."""
    return along(ray, inverse, lengths_of(geometry, table, row))


@inline
def along(ray: Ray, inverse: float, lengths: Nearness) -> Nearness:
    """Limits of lengths as limits of t."""
    unit = ray_unit(ray[3], ray[4], ray[5], inverse)
    size = ray_size(ray[0], ray[1], ray[2], unit)
    beside = size * STARTING if ray[8] >= 0 else size
    return lengths[0] * unit + RELATIVE * beside, lengths[1] * (0.5 * unit) - size


@inline
def near(s: float, t: float, nearness: Nearness) -> bool:
    """Might rounding have changed the order of two crossings? False where one is infinite."""
    return abs(s - t) <= nearness[0]


@inline
def at_start(t: float, starts: bool, t_min: float, off: float) -> bool:
    """Might rounding have taken a crossing to the other side of the ray's origin? Not the one that it `starts` on.

    Other ends of the interval are compared with t as it is reported, so what is reported lies within them.
    """
    return (abs(t) <= off) & (t_min <= off) & ((t != 0.0) | (not starts))


@inline
def beyond(t: float, nearness: Nearness) -> bool:
    """Is a crossing so far away that nothing is certain of it?"""
    return (abs(t) > nearness[1]) & (abs(t) < math.inf)
