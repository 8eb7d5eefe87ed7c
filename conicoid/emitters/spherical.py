"""Triangles and polygons by the solid angle that they fill, for lamps that are near.

Arvo, Stratified sampling of spherical triangles, SIGGRAPH 1995. The angle of a triangle is that of Van Oosterom and
Strackee, The solid angle of a plane triangle, 1983: tan(Ω / 2) = |a·(b×c)| / (1 + a·b + b·c + c·a) for unit vectors to
its corners. The triangles of a polygon do not overlap, so their angles add up, and each is drawn by its own.
"""

from __future__ import annotations

import math
from typing import Any

from ..compiler.jit import helper, inline
from ..engine.body.uv import turns
from ..engine.numbers.turns import cos_sin_turns
from ..engine.numbers.vectors import dot, normalized
from ..engine.tables import Floats
from ..scattering.warps import Direction

MOST = 6
"""Polygons of more triangles are drawn by area."""
LEAST = 1.0 / 64.0
"""What fills less than this is drawn by area: from far away the two are the same."""
_STRIDE = 10  # as `sources.TRIANGLE`


@inline
def _cross(a: Direction, b: Direction) -> Direction:
    return normalized(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


@inline
def _dot(a: Direction, b: Direction) -> float:
    return dot(a[0], a[1], a[2], b[0], b[1], b[2])


@inline
def _corners(f: Floats, k: int, x: float, y: float, z: float) -> tuple[Direction, Direction, Direction]:
    """Unit vectors from a point to the corners of triangle k."""
    at = _STRIDE * k
    px, py, pz = f[at] - x, f[at + 1] - y, f[at + 2] - z
    return (
        normalized(px, py, pz), normalized(px + f[at + 3], py + f[at + 4], pz + f[at + 5]),
        normalized(px + f[at + 6], py + f[at + 7], pz + f[at + 8]),
    )  # fmt: skip


@helper
def triangle_angle(f: Floats, k: int, x: float, y: float, z: float) -> float:
    """The solid angle of triangle k from a point, in steradians."""
    a, b, c = _corners(f, k, x, y, z)
    volume = (
        a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])
    )  # fmt: skip
    return 4.0 * math.pi * turns(1.0 + _dot(a, b) + _dot(b, c) + _dot(c, a), abs(volume))


@helper
def polygon_angle(f: Floats, source: Any, x: float, y: float, z: float) -> float:
    """The solid angle of a lamp that is a polygon, if it is to be drawn by that; else 0."""
    if source.count > MOST:
        return 0.0
    total = 0.0
    for k in range(source.index, source.index + source.count):
        total += triangle_angle(f, k, x, y, z)
    return total if total >= LEAST else 0.0


@inline
def _towards(a: Direction, b: Direction, cosine: float) -> Direction:
    """The unit vector in the plane of a and b at an angle of that cosine to a, on the side of b."""
    along = _dot(a, b)
    x, y, z = normalized(b[0] - along * a[0], b[1] - along * a[1], b[2] - along * a[2])
    s = math.sqrt(max(0.0, (1.0 - cosine) * (1.0 + cosine)))
    return cosine * a[0] + s * x, cosine * a[1] + s * y, cosine * a[2] + s * z


@helper
def in_triangle(f: Floats, k: int, x: float, y: float, z: float, u: float, v: float) -> Direction:
    """A unit direction from a point into triangle k, of even density."""
    a, b, c = _corners(f, k, x, y, z)
    ab, ac = _cross(a, b), _cross(a, c)
    cos_a = min(1.0, max(-1.0, _dot(ab, ac)))
    sin_a = math.sqrt((1.0 - cos_a) * (1.0 + cos_a))
    share = u * triangle_angle(f, k, x, y, z) / (2.0 * math.pi) - turns(cos_a, sin_a)
    t, s = cos_sin_turns(share)
    p, q = t - cos_a, s + sin_a * _dot(a, b)
    below = (q * s + p * t) * sin_a
    cosine = ((q * t - p * s) * cos_a - q) / below if below != 0.0 else 1.0
    far = _towards(a, c, min(1.0, max(-1.0, cosine)))
    return normalized3(_towards(b, far, 1.0 - v * (1.0 - _dot(far, b))))


@inline
def normalized3(d: Direction) -> Direction:
    return normalized(d[0], d[1], d[2])


@helper
def in_polygon(f: Floats, source: Any, total: float, x: float, y: float, z: float, u: float, v: float) -> Direction:
    """The same for a polygon whose solid angle is `total`: u chooses the triangle, and goes on in it."""
    left = u * total
    for k in range(source.index, source.index + source.count):
        angle = triangle_angle(f, k, x, y, z)
        if left < angle or k == source.index + source.count - 1:
            return in_triangle(f, k, x, y, z, min(1.0 - 2.0**-53, left / angle) if angle > 0.0 else 0.5, v)
        left -= angle
    return 0.0, 0.0, 1.0
