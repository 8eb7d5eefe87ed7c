"""Points of the unit square to directions: discs, hemispheres, spheres, cones. No function of the C library."""

from __future__ import annotations

import math
from typing import TypeAlias

from ..compiler.jit import helper, inline
from ..engine.numbers.exponential import log_of
from ..engine.numbers.turns import cos_sin_turns
from ..engine.numbers.vectors import dot

Direction: TypeAlias = tuple[float, float, float]


@inline
def around(u: float, z: float) -> Direction:
    """The unit vector of height z at the angle 2 pi u."""
    c, s = cos_sin_turns(u)
    r = math.sqrt(max(0.0, (1.0 - z) * (1.0 + z)))
    return r * c, r * s, z


@inline
def cosine_direction(u: float, v: float) -> Direction:
    """A direction of the upper hemisphere, of density cos / pi (Malley): a point of the disc, raised."""
    c, s = cos_sin_turns(v)
    r = math.sqrt(u)
    return r * c, r * s, math.sqrt(1.0 - u)


@inline
def sphere_direction(u: float, v: float) -> Direction:
    """A direction of density 1 / (4 pi)."""
    return around(v, 1.0 - 2.0 * u)


@inline
def basis(x: float, y: float, z: float) -> tuple[Direction, Direction]:
    """Two unit vectors that make a right-handed frame with a unit vector as the third.

    Duff and others, Building an orthonormal basis, revisited, JCGT 6(1), 2017.
    """
    sign = 1.0 if z >= 0.0 else -1.0
    a = -1.0 / (sign + z)
    b = x * y * a
    return (1.0 + sign * x * x * a, sign * b, -sign * x), (b, sign + y * y * a, -y)


@inline
def to_world(d: Direction, n: Direction) -> Direction:
    """A direction of the frame about a unit normal (`basis`), in the world."""
    (sx, sy, sz), (tx, ty, tz) = basis(n[0], n[1], n[2])
    return (
        dot(d[0], d[1], d[2], sx, tx, n[0]),
        dot(d[0], d[1], d[2], sy, ty, n[1]),
        dot(d[0], d[1], d[2], sz, tz, n[2]),
    )


@inline
def to_frame(d: Direction, n: Direction) -> Direction:
    """A direction of the world, in the frame about a unit normal."""
    (sx, sy, sz), (tx, ty, tz) = basis(n[0], n[1], n[2])
    return (
        dot(d[0], d[1], d[2], sx, sy, sz),
        dot(d[0], d[1], d[2], tx, ty, tz),
        dot(d[0], d[1], d[2], n[0], n[1], n[2]),
    )


@helper
def logarithm(x: float) -> float:
    """The natural logarithm of a positive number."""
    high, low = log_of(x)
    return high + low
