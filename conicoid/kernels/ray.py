"""Rays in kernels: one ray, many as arrays, and the scaling that keeps squares of a direction finite."""

from __future__ import annotations

import math
import sys
from typing import Any, NamedTuple

import numpy as np

from .._jit.decorators import choose, helper, inline, record_shapes
from .._util.validation import LARGEST, SMALLEST
from .surface.doubt import RELATIVE, STARTING
from .tables import Floats, Ints


class Ray(NamedTuple):
    """One ray and its interval, open at both ends."""

    ox: float
    oy: float
    oz: float
    dx: float
    dy: float
    dz: float
    t_min: float
    t_max: float
    start: Any  # int64: the surface on which it starts, -1 for none, or DEAD


class RayLine(NamedTuple):
    """Origin and direction of a ray, without its interval."""

    ox: float
    oy: float
    oz: float
    dx: float
    dy: float
    dz: float


@inline
def line_of(ray: Ray) -> RayLine:
    """Return the line of a ray."""
    return RayLine(ray.ox, ray.oy, ray.oz, ray.dx, ray.dy, ray.dz)


@inline
def with_limits(ray: Ray, t_min: float, t_max: float) -> Ray:
    """Return the ray with the interval (t_min, t_max)."""
    return Ray(ray.ox, ray.oy, ray.oz, ray.dx, ray.dy, ray.dz, t_min, t_max, ray.start)


@record_shapes(origins="n 3", directions="n 3", t_min="n|1", t_max="n|1", starts="n|1")
class RayArrays(NamedTuple):
    """Many rays. `t_min`, `t_max` and `starts` have one value for all rays, or one for each ray."""

    origins: Floats  # (n, 3)
    directions: Floats  # (n, 3)
    t_min: Floats
    t_max: Floats
    starts: Ints  # as `Ray.start`

    def some(self, which: Any) -> RayArrays:
        """Return the rays that an index array, mask or slice selects."""
        # One value for all rays stays one, whichever rays are selected
        parts: tuple[Any, ...] = self
        return RayArrays(*(part if len(part) == 1 else part[which] for part in parts))


@inline
def is_traceable(x: float) -> bool:
    """Return True if a number is 0 or within the domain of magnitudes, without branches."""
    return (x == 0.0) | ((abs(x) >= SMALLEST) & (abs(x) <= LARGEST))


@inline
def are_traceable(ox: float, oy: float, oz: float, dx: float, dy: float, dz: float) -> bool:
    """Return True if all numbers of a ray are 0 or within the domain of magnitudes."""
    origin = is_traceable(ox) & is_traceable(oy) & is_traceable(oz)
    return origin & is_traceable(dx) & is_traceable(dy) & is_traceable(dz)


DEAD = -2
"""`Ray.start` of a ray that does not exist: the continuation of a miss."""


@inline
def load_ray(rays: RayArrays, i: int) -> Ray:
    """Return ray i."""
    # x + 0.0 turns -0.0 into +0.0, so that equal origins are equal to the bit
    origins, directions, t_min, t_max, starts = rays
    start = np.int64(starts[i if len(starts) > 1 else 0])
    first, last = t_min[i if len(t_min) > 1 else 0], t_max[i if len(t_max) > 1 else 0]
    ox, oy, oz = origins[i, 0] + 0.0, origins[i, 1] + 0.0, origins[i, 2] + 0.0
    dx, dy, dz = directions[i, 0] + 0.0, directions[i, 1] + 0.0, directions[i, 2] + 0.0
    return Ray(ox, oy, oz, dx, dy, dz, first, last, start)


_FAR = 2.0**100  # `scale_ray` leaves a direction alone whose largest component lies between 1 / _FAR and _FAR
_LARGEST, _LEAST = sys.float_info.max, math.ulp(0.0)


@inline
def _scale_limit(t: float, scale: float) -> float:
    """Return t / scale; the largest or the least float where the quotient of a finite t is infinite or 0."""
    scaled = t / scale
    if scaled == 0.0 and t != 0.0:  # (-1e-323, 1e-323) holds a crossing at t = 0, and so must the scaled interval
        return math.copysign(_LEAST, t)
    return scaled if abs(scaled) < math.inf or abs(t) == math.inf else math.copysign(_LARGEST, t)


_POWERS = (2.0**512, 2.0**256, 2.0**128, 2.0**64, 2.0**32, 2.0**16, 2.0**8, 2.0**4, 2.0**2, 2.0)


@helper
def _scale(x: float) -> float:
    """Return the power of two that brings a number above 1e-300 to [1/2, 1)."""
    # By comparisons, not by reading the exponent's bits: plain Python calls this as well
    scale = 1.0
    for power in _POWERS:
        if x >= power:
            x /= power
            scale /= power
        elif x < 1.0 / power:
            x *= power
            scale *= power
    return scale if x < 1.0 else 0.5 * scale


@inline
def scale_ray(ray: Ray) -> tuple[Ray, float]:
    """Return the ray with its direction scaled by a power of two, and that power.

    Squares of the scaled direction neither overflow nor underflow. The interval is divided by the power, so that a t of
    the scaled ray times the power is the t of the given one.
    """
    ox, oy, oz, dx, dy, dz, t_min, t_max, start = ray
    largest = max(abs(dx), max(abs(dy), abs(dz)))
    if 1.0 / _FAR < largest < _FAR:  # nearly every ray
        return ray, 1.0
    scale = _scale(largest) if largest > 1e-300 else 2.0**1000
    low, high = _scale_limit(t_min, scale), _scale_limit(t_max, scale)
    return Ray(ox, oy, oz, dx * scale, dy * scale, dz * scale, low, high, start), scale


@inline
def start_margin(start: float, ox: float, oy: float, oz: float) -> float:
    """Return by how much balls are larger for a ray that starts on a surface, and may begin beside it; else 0."""
    return choose(start >= 0.0, (abs(ox) + abs(oy) + abs(oz)) * (STARTING * RELATIVE), 0.0)


@inline
def span_inverse(ray: Ray) -> float:
    """Return 1 / d·d."""
    return 1.0 / (ray.dx * ray.dx + ray.dy * ray.dy + ray.dz * ray.dz)
