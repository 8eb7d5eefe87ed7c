"""A plane on a ray."""

from __future__ import annotations

from typing import TypeAlias

from ...compiler.jit import helper, inline
from ..numbers.errorfree import accurate_dot, two_difference
from ..numbers.vectors import dot

Plane: TypeAlias = tuple[float, float, float, float, float, float, float]

Limits: TypeAlias = tuple[float, float]
"""square of the least rate that is certain, for |d| = 1; the least height of a parallel ray"""

_OBLIQUE = 1.0 / 32.0


@inline
def plane_on_ray(
    plane: Plane, ox: float, oy: float, oz: float, dx: float, dy: float, dz: float
) -> tuple[float, float, bool]:
    """(height, rate, parallel): the plane's value n·x - offset along the ray is height + rate t.

    Where the terms of one of the dot products cancel, it is done again in twice the precision, so
    that t = -height / rate keeps its digits for grazing rays. `parallel`: every term of the rate is zero.
    """
    height, rate, cancels, parallel = plain_plane(plane, ox, oy, oz, dx, dy, dz)
    if cancels:
        height, rate = careful_plane(plane, ox, oy, oz, dx, dy, dz)
    return height, rate, parallel


@inline
def runs_along(plane: Plane, dx: float, dy: float, dz: float) -> bool:
    """Is every term of the rate zero?"""
    return abs(plane[0] * dx) + abs(plane[1] * dy) + abs(plane[2] * dz) == 0.0


@inline
def unsure_of_plane(height: float, rate: float, parallel: bool, inverse: float, limits: Limits) -> bool:
    """Might rounding change the side that a parallel ray is on, or whether a ray rises over the plane?"""
    certain = (abs(height) >= limits[1]) if parallel else (rate * rate * inverse >= limits[0])
    return not certain


@inline
def plain_plane(
    plane: Plane, ox: float, oy: float, oz: float, dx: float, dy: float, dz: float
) -> tuple[float, float, bool, bool]:
    """(height, rate, cancels, parallel). `plane` = (normal, height of the anchor over the plane, anchor).

    The origin is taken relative to the anchor in two floats.
    """
    nx, ny, nz, over, ax, ay, az = plane
    px, ex = two_difference(ox, ax)
    py, ey = two_difference(oy, ay)
    pz, ez = two_difference(oz, az)
    rate = dot(nx, ny, nz, dx, dy, dz)
    height = dot(nx, ny, nz, px, py, pz) + (dot(nx, ny, nz, ex, ey, ez) + over)
    size = abs(nx * dx) + abs(ny * dy) + abs(nz * dz)
    reach = abs(nx * px) + abs(ny * py) + abs(nz * pz) + abs(over)
    return height, rate, (abs(rate) < _OBLIQUE * size) | (abs(height) < _OBLIQUE * reach), size == 0.0


@helper
def careful_plane(
    plane: Plane, ox: float, oy: float, oz: float, dx: float, dy: float, dz: float
) -> tuple[float, float]:
    """(height, rate) in twice the precision, rounded once."""
    nx, ny, nz, over, ax, ay, az = plane
    px, ex = two_difference(ox, ax)
    py, ey = two_difference(oy, ay)
    pz, ez = two_difference(oz, az)
    rate = accurate_dot(nx, ny, nz, dx, dy, dz, 0.0, 0.0)
    return accurate_dot(nx, ny, nz, px, py, pz, over, dot(nx, ny, nz, ex, ey, ez)), rate
