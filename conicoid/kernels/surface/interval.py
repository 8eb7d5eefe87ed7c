"""A crossing and the interval of its ray, and the error bounds of t.

Intervals are open at both ends. `starts` is True everywhere for a crossing with the surface on which the ray starts; at
t = 0 such a crossing is the start itself, which never counts. Bounds and doubt: docs/dev/exactness.md.
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
    """True if an interval is not empty; False where an end is NaN or the ends are out of order."""
    return t_min < t_max


@inline
def has_begun(t: float, t_min: float) -> bool:
    """True if a crossing lies beyond the beginning of its interval; the ray has passed one at the beginning."""
    return t_min < t


@inline
def has_not_ended(t: float, t_max: float) -> bool:
    """True if a crossing lies before the end of its interval."""
    return t < t_max


@inline
def is_within(t: float, t_min: float, t_max: float) -> bool:
    """True if t lies within (t_min, t_max)."""
    return has_begun(t, t_min) & has_not_ended(t, t_max)


@inline
def may_overlap(t_in: float, t_out: float, t_min: float, t_max: float, off: float) -> bool:
    """True if a span might overlap an interval, where rounding may have moved two places by `off` past each other."""
    t_out += off
    return (t_in <= t_out) & (t_min <= t_out) & (t_in <= t_max + off)


@inline
def counts_in(t: float, starts: bool, t_min: float, t_max: float) -> bool:
    """True if a crossing lies within (t_min, t_max) and is not the one on which the ray starts.

    Lanes of a packet may pass starts = False: one that starts on a surface begins at t = 0 or later (`is_ordinary`).
    """
    # The comparison with 0 is exact: a ray that starts on the surface has foot = 0 and c = 0 there, so that root is 0.0
    return is_within(t, t_min, t_max) & ((t != 0.0) | (not starts))


@inline
def is_start_crossing(t: float, starts: bool, t_min: float, t_max: float) -> bool:
    """True if a crossing is the one on which the ray starts and lies within an interval that begins before it.

    Then a body counts before the crossing as it does beyond it, so that crossings and spans agree.
    """
    return is_within(t, t_min, t_max) & (t == 0.0) & starts


@inline
def may_pass_start(t: float, starts: bool, t_min: float, off: float) -> bool:
    """True if rounding might have moved a crossing past the ray's origin; False for the one on which it starts.

    Other ends of the interval are compared with the reported t, so that every reported crossing lies within them; these
    comparisons are never doubtful.
    """
    # For t_min > off the crossing does not count, on whichever side of the origin it lies
    return (abs(t) <= off) & (t_min <= off) & ((t != 0.0) | (not starts))


# Error bounds of t: crossings nearer to each other may have changed their order


class Nearness(NamedTuple):
    """The error bound of t, and the size of t beyond which nothing is certain; or both as lengths, for |d| = 1.

    far < 0 means that nothing is certain on the whole ray.
    """

    off: float
    far: float


@inline
def ray_unit(dx: float, dy: float, dz: float, inverse: float) -> float:
    """Return a number from 1 / |d| to 1.74 / |d|, without a square root; `inverse` is 1 / d·d."""
    # The sum of sizes is at least |d| and at most √3 |d|; 1.74 leaves room for rounding
    return (abs(dx) + abs(dy) + abs(dz)) * inverse


@inline
def ray_size(ox: float, oy: float, oz: float, unit: float) -> float:
    """Return |o| / |d| or a little more; `unit` is `ray_unit`."""
    return (abs(ox) + abs(oy) + abs(oz)) * unit


@inline
def row_of_limits(geometry: Geometry, limits: int, row: int) -> int:
    """Return the row of the limits of a cell, program, sheet or polygon; translated copies share a row."""
    if limits == table.CELL_LIMITS:
        return row_of_cell(geometry, row)
    if limits == table.PROGRAM_LIMITS and length(geometry, table.PROGRAM_SHIFTS) > 0:
        return row_of_program(geometry, row)
    return row


@inline
def lengths_of(geometry: Geometry, limits: int, row: int) -> Nearness:
    """Return the limits, as lengths, of a cell, program, sheet or polygon; `limits` is the number of their table."""
    at = 2 * row_of_limits(geometry, limits, row)
    return Nearness(real(geometry, limits, at), real(geometry, limits, at + 1))


@inline
def lengths_of_ball(ball: SphereRecord) -> Nearness:
    """Return the limits, as lengths, of a ball."""
    x, y, z, radius = ball
    return Nearness(BALL_OFF * radius + RELATIVE * (abs(x) + abs(y) + abs(z) + radius), BALL_FAR * radius)


@inline
def nearness_of(geometry: Geometry, limits: int, row: int, ray: Ray, inverse: float) -> Nearness:
    """Return the limits, in t of a ray, of a cell, program, sheet or polygon."""
    return limits_of_ray(ray, inverse, lengths_of(geometry, limits, row))


@inline
def limits_along(lengths: Nearness, unit: float, size: float, beside: float) -> Nearness:
    """Convert limits from lengths to t.

    `unit` is `ray_unit`, `size` is `ray_size`, and `beside` bounds the distance of the ray's start from its origin. The
    result is never narrower than the exact limits: `off` is rounded up by `unit` >= 1 / |d|, `far` down by half of it.
    """
    # unit / 2 is at most 0.87 / |d|, so that `far` errs to the near side
    return Nearness(lengths.off * unit + RELATIVE * beside, lengths.far * (0.5 * unit) - size)


@inline
def limits_of_ray(ray: Ray, inverse: float, lengths: Nearness) -> Nearness:
    """Convert limits from lengths to t of a ray."""
    unit = ray_unit(ray.dx, ray.dy, ray.dz, inverse)
    size = ray_size(ray.ox, ray.oy, ray.oz, unit)
    beside = size * STARTING if ray.start >= 0 else size
    return limits_along(lengths, unit, size, beside)


@inline
def may_swap(s: float, t: float, nearness: Nearness) -> bool:
    """True if rounding might have changed the order of two crossings; False where one is infinite."""
    return abs(s - t) <= nearness.off


@inline
def is_too_far(t: float, nearness: Nearness) -> bool:
    """True if a crossing is so far away that nothing is certain of it; False for infinite t."""
    return (abs(t) > nearness.far) & (abs(t) < math.inf)
