"""A plane on a ray: its value along the ray is height + rate t."""

from __future__ import annotations

from typing import NamedTuple

from ..._jit.decorators import helper, inline
from ..numbers.double_double import accurate_dot, two_difference
from ..numbers.vectors import dot
from ..ray import RayLine
from .doubt import OBLIQUE


class PlaneRecord(NamedTuple):
    """The record of a plane: its normal n, the value n·x - offset at the anchor, and the anchor.

    n and the offset are scaled by a power of two that brings the largest component of n to [1/2, 1).
    """

    nx: float
    ny: float
    nz: float
    above: float
    ax: float
    ay: float
    az: float


class PlaneLimits(NamedTuple):
    """Least values from which on the fast formulas of a plane are certain."""

    rate_squared: float  # for |d| = 1
    height: float  # of a parallel ray


@inline
def plane_on_ray(plane: PlaneRecord, line: RayLine) -> tuple[float, float, bool]:
    """Return (height, rate, parallel): the plane's value n·x - offset along the ray is height + rate t.

    Where the terms of a dot product cancel, both are evaluated again in twice the precision, so that t = -height / rate
    keeps its digits for grazing rays. `parallel` is True if every term of the rate is zero.
    """
    # Both are computed again if one cancels: t is their quotient, and needs the digits of both
    height, rate, cancels, parallel = plain_plane(plane, line)
    if cancels:
        height, rate = careful_plane(plane, line)
    return height, rate, parallel


@inline
def runs_along(plane: PlaneRecord, line: RayLine) -> bool:
    """True if every term of the rate is zero."""
    return abs(plane.nx * line.dx) + abs(plane.ny * line.dy) + abs(plane.nz * line.dz) == 0.0


@inline
def unsure_of_plane(height: float, rate: float, parallel: bool, inverse: float, limits: PlaneLimits) -> bool:
    """True if rounding might change the side of a parallel ray, or the sign of the rate of any other."""
    # For |d| = 1, but by a product with 1 / d·d, without a square root
    certain = (abs(height) >= limits.height) if parallel else (rate * rate * inverse >= limits.rate_squared)
    return not certain


@inline
def plain_plane(plane: PlaneRecord, line: RayLine) -> tuple[float, float, bool, bool]:
    """Return (height, rate, cancels, parallel), without branches.

    Lanes of packets call it, and evaluate the few that cancel again. The origin is taken relative to the anchor in two
    floats.
    """
    nx, ny, nz, over, ax, ay, az = plane
    ox, oy, oz, dx, dy, dz = line
    px, ex = two_difference(ox, ax)
    py, ey = two_difference(oy, ay)
    pz, ez = two_difference(oz, az)
    rate = dot(nx, ny, nz, dx, dy, dz)
    height = dot(nx, ny, nz, px, py, pz) + (dot(nx, ny, nz, ex, ey, ez) + over)
    # Sizes of the terms of rate and height, to detect cancellation
    size = abs(nx * dx) + abs(ny * dy) + abs(nz * dz)
    reach = abs(nx * px) + abs(ny * py) + abs(nz * pz) + abs(over)
    return height, rate, (abs(rate) < OBLIQUE * size) | (abs(height) < OBLIQUE * reach), size == 0.0


@helper
def careful_plane(plane: PlaneRecord, line: RayLine) -> tuple[float, float]:
    """Return (height, rate) computed in twice the precision and rounded once."""
    nx, ny, nz, over, ax, ay, az = plane
    ox, oy, oz, dx, dy, dz = line
    px, ex = two_difference(ox, ax)
    py, ey = two_difference(oy, ay)
    pz, ez = two_difference(oz, az)
    # The direction is exact, so that its dot product has no further parts
    rate = accurate_dot(nx, ny, nz, dx, dy, dz, 0.0, 0.0)
    return accurate_dot(nx, ny, nz, px, py, pz, over, dot(nx, ny, nz, ex, ey, ez)), rate
