"""When two crossings are so near that rounding may have changed their order (docs/exactness.md)."""

from __future__ import annotations

import math
from typing import NamedTuple

from ...compiler.jit import inline
from .. import tables as table
from ..faces import row_of_cell
from ..programs import row_of_program
from ..ray import Ray
from ..tables import Geometry, length, real
from .doubt import BALL_FAR, BALL_OFF, RELATIVE, STARTING
from .quadric import Sphere


class Nearness(NamedTuple):
    """The error bound of t, and the size of t beyond which nothing is certain; or both as lengths, for |d| = 1.

    far < 0 means that nothing is certain of the whole ray.
    """

    off: float
    far: float


@inline
def ray_unit(dx: float, dy: float, dz: float, inverse: float) -> float:
    """1 / |d|, or up to 1.74 times that: it takes no root."""
    return (abs(dx) + abs(dy) + abs(dz)) * inverse


@inline
def ray_size(ox: float, oy: float, oz: float, unit: float) -> float:
    """|o| / |d|, or a little more."""
    return (abs(ox) + abs(oy) + abs(oz)) * unit


@inline
def row_of_limits(geometry: Geometry, limits: int, row: int) -> int:
    """The row of the limits of a cell, program, sheet or polygon: those that are one another moved share one."""
    if limits == table.CELL_LIMITS:
        return row_of_cell(geometry, row)
    if limits == table.PROGRAM_LIMITS and length(geometry, table.PROGRAM_SHIFTS) > 0:
        return row_of_program(geometry, row)
    return row


@inline
def lengths_of(geometry: Geometry, limits: int, row: int) -> Nearness:
    """The limits of a cell, program, sheet or polygon, for |d| = 1: by its number, from one of their tables."""
    at = 2 * row_of_limits(geometry, limits, row)
    return Nearness(real(geometry, limits, at), real(geometry, limits, at + 1))


@inline
def lengths_of_ball(ball: Sphere) -> Nearness:
    """The limits of a ball, for |d| = 1."""
    x, y, z, radius = ball
    return Nearness(BALL_OFF * radius + RELATIVE * (abs(x) + abs(y) + abs(z) + radius), BALL_FAR * radius)


@inline
def nearness_of(geometry: Geometry, limits: int, row: int, ray: Ray, inverse: float) -> Nearness:
    """The limits of a cell, program, sheet or polygon for the t of a ray."""
    return along(ray, inverse, lengths_of(geometry, limits, row))


@inline
def limits_along(lengths: Nearness, unit: float, size: float, beside: float) -> Nearness:
    """Limits of lengths as limits of t, by `ray_unit`, `ray_size` and how far beside its origin the ray may start.

    Never narrower than the exact ones: `off` is rounded up by `unit` >= 1 / |d|, `far` down by half of it.
    """
    return Nearness(lengths.off * unit + RELATIVE * beside, lengths.far * (0.5 * unit) - size)


@inline
def along(ray: Ray, inverse: float, lengths: Nearness) -> Nearness:
    """Limits of lengths as limits of t."""
    unit = ray_unit(ray.dx, ray.dy, ray.dz, inverse)
    size = ray_size(ray.ox, ray.oy, ray.oz, unit)
    beside = size * STARTING if ray.start >= 0 else size
    return limits_along(lengths, unit, size, beside)


@inline
def near(s: float, t: float, nearness: Nearness) -> bool:
    """Might rounding have changed the order of two crossings? False where one is infinite."""
    return abs(s - t) <= nearness.off


@inline
def beyond(t: float, nearness: Nearness) -> bool:
    """Is a crossing so far away that nothing is certain of it?"""
    return (abs(t) > nearness.far) & (abs(t) < math.inf)
