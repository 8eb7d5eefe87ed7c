"""A crossing and the interval of its ray, which is open at both ends.

`starts` says everywhere: the crossing is one with the surface on which the ray starts. At t = 0 that is the start
itself, which never counts.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..._jit.decorators import inline
from .. import tables as table
from ..faces import row_of_cell
from ..programs import row_of_program
from ..ray import Ray
from ..tables import Geometry, length, real
from .doubt import BALL_FAR, BALL_OFF, RELATIVE, STARTING
from .quadric import SphereRecord


@inline
def is_open(t_min: float, t_max: float) -> bool:
    """Is there anything between the ends of an interval? Not where one is NaN, or they are out of order."""
    return t_min < t_max


@inline
def has_begun(t: float, t_min: float) -> bool:
    """Does a crossing lie beyond the beginning of its interval? What lies there was passed before."""
    return t_min < t


@inline
def has_not_ended(t: float, t_max: float) -> bool:
    """Does a crossing lie before the end of its interval?"""
    return t < t_max


@inline
def is_within(t: float, t_min: float, t_max: float) -> bool:
    """Is t within (t_min, t_max)?"""
    return has_begun(t, t_min) & has_not_ended(t, t_max)


@inline
def may_overlap(t_in: float, t_out: float, t_min: float, t_max: float, off: float) -> bool:
    """Might a span have any of an interval, where rounding may have moved each of its ends by `off`?"""
    t_out += off
    return (t_in <= t_out) & (t_min <= t_out) & (t_in <= t_max + off)


@inline
def counts_in(t: float, starts: bool, t_min: float, t_max: float) -> bool:
    """Is a crossing within (t_min, t_max), and not the one that the ray starts on?

    The lanes of a packet may say that none is: one that starts on a surface begins at t = 0 or later (`load.ordinary`).
    """
    return is_within(t, t_min, t_max) & ((t != 0.0) | (not starts))


@inline
def is_start_crossing(t: float, starts: bool, t_min: float, t_max: float) -> bool:
    """Is a crossing the one that the ray starts on, and within an interval that begins before it?

    Then a body counts before it as it does beyond, so that crossings and spans go together.
    """
    return is_within(t, t_min, t_max) & (t == 0.0) & starts


@inline
def may_pass_start(t: float, starts: bool, t_min: float, off: float) -> bool:
    """Might rounding have taken a crossing to the other side of the ray's origin? Not the one that it starts on.

    Other ends of the interval are compared with t as it is reported, so that what is reported lies within them; there
    is nothing to doubt about those.
    """
    return (abs(t) <= off) & (t_min <= off) & ((t != 0.0) | (not starts))


# When two crossings are so near that rounding may have changed their order (docs/exactness.md).


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
def lengths_of_ball(ball: SphereRecord) -> Nearness:
    """The limits of a ball, for |d| = 1."""
    x, y, z, radius = ball
    return Nearness(BALL_OFF * radius + RELATIVE * (abs(x) + abs(y) + abs(z) + radius), BALL_FAR * radius)


@inline
def nearness_of(geometry: Geometry, limits: int, row: int, ray: Ray, inverse: float) -> Nearness:
    """The limits of a cell, program, sheet or polygon for the t of a ray."""
    return limits_of_ray(ray, inverse, lengths_of(geometry, limits, row))


@inline
def limits_along(lengths: Nearness, unit: float, size: float, beside: float) -> Nearness:
    """Limits of lengths as limits of t, by `ray_unit`, `ray_size` and how far beside its origin the ray may start.

    Never narrower than the exact ones: `off` is rounded up by `unit` >= 1 / |d|, `far` down by half of it.
    """
    return Nearness(lengths.off * unit + RELATIVE * beside, lengths.far * (0.5 * unit) - size)


@inline
def limits_of_ray(ray: Ray, inverse: float, lengths: Nearness) -> Nearness:
    """Limits of lengths as limits of t."""
    unit = ray_unit(ray.dx, ray.dy, ray.dz, inverse)
    size = ray_size(ray.ox, ray.oy, ray.oz, unit)
    beside = size * STARTING if ray.start >= 0 else size
    return limits_along(lengths, unit, size, beside)


@inline
def may_swap(s: float, t: float, nearness: Nearness) -> bool:
    """Might rounding have changed the order of two crossings? False where one is infinite."""
    return abs(s - t) <= nearness.off


@inline
def is_too_far(t: float, nearness: Nearness) -> bool:
    """Is a crossing so far away that nothing is certain of it?"""
    return (abs(t) > nearness.far) & (abs(t) < math.inf)
