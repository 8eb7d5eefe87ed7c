"""Principal axes of symmetric 3 × 3 matrices, by Jacobi's rotations (Golub, Van Loan: Matrix Computations, 8.5).

Rotations take sums, products and roots alone, so their bits are the same everywhere.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ...compiler.jit import helper, inline
from ..numbers.vectors import dot

_SWEEPS = 12
_NONE = 2.0**-58


class Directions(NamedTuple):
    """Three unit vectors e0, e1, e2 at right angles."""

    x0: float
    y0: float
    z0: float
    x1: float
    y1: float
    z1: float
    x2: float
    y2: float
    z2: float


class Axes(NamedTuple):
    """Eigenvalues a0 <= a1 <= a2, and their eigenvectors."""

    a0: float
    a1: float
    a2: float
    along: Directions


@inline
def parts_along(e: Directions, x: float, y: float, z: float) -> tuple[float, float, float]:
    """(e0·v, e1·v, e2·v)"""
    return dot(e.x0, e.y0, e.z0, x, y, z), dot(e.x1, e.y1, e.z1, x, y, z), dot(e.x2, e.y2, e.z2, x, y, z)


@inline
def turned_around(e: Directions) -> Directions:
    """e2, e1, e0"""
    return Directions(e.x2, e.y2, e.z2, e.x1, e.y1, e.z1, e.x0, e.y0, e.z0)


@inline
def turn(p: float, q: float, mixed: float) -> tuple[float, float, float]:
    """(cosine, sine, t) of the rotation that takes the mixed term from ((p, mixed), (mixed, q))."""
    if abs(mixed) <= _NONE * (abs(p) + abs(q)):
        return 1.0, 0.0, 0.0
    theta = (q - p) / (2.0 * mixed)
    t = math.copysign(1.0, theta) / (abs(theta) + math.sqrt(theta * theta + 1.0))
    c = 1.0 / math.sqrt(t * t + 1.0)
    return c, t * c, t


@helper
def principal_axes(xx: float, yy: float, zz: float, xy: float, xz: float, yz: float) -> Axes:
    """The principal axes of a symmetric matrix."""
    x0, y0, z0, x1, y1, z1, x2, y2, z2 = 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0
    for _ in range(_SWEEPS):
        turned = 0.0
        c, s, t = turn(xx, yy, xy)
        xx, yy, xy = xx - t * xy, yy + t * xy, (0.0 if s != 0.0 else xy)
        xz, yz = c * xz - s * yz, s * xz + c * yz
        x0, y0, z0, x1, y1, z1 = (
            c * x0 - s * x1, c * y0 - s * y1, c * z0 - s * z1, s * x0 + c * x1, s * y0 + c * y1, s * z0 + c * z1,
        )  # fmt: skip
        turned += abs(s)
        c, s, t = turn(xx, zz, xz)
        xx, zz, xz = xx - t * xz, zz + t * xz, (0.0 if s != 0.0 else xz)
        xy, yz = c * xy - s * yz, s * xy + c * yz
        x0, y0, z0, x2, y2, z2 = (
            c * x0 - s * x2, c * y0 - s * y2, c * z0 - s * z2, s * x0 + c * x2, s * y0 + c * y2, s * z0 + c * z2,
        )  # fmt: skip
        turned += abs(s)
        c, s, t = turn(yy, zz, yz)
        yy, zz, yz = yy - t * yz, zz + t * yz, (0.0 if s != 0.0 else yz)
        xy, xz = c * xy - s * xz, s * xy + c * xz
        x1, y1, z1, x2, y2, z2 = (
            c * x1 - s * x2, c * y1 - s * y2, c * z1 - s * z2, s * x1 + c * x2, s * y1 + c * y2, s * z1 + c * z2,
        )  # fmt: skip
        turned += abs(s)
        if turned == 0.0:
            break
    if yy < xx:
        xx, yy, x0, y0, z0, x1, y1, z1 = yy, xx, x1, y1, z1, x0, y0, z0
    if zz < yy:
        yy, zz, x1, y1, z1, x2, y2, z2 = zz, yy, x2, y2, z2, x1, y1, z1
    if yy < xx:
        xx, yy, x0, y0, z0, x1, y1, z1 = yy, xx, x1, y1, z1, x0, y0, z0
    return Axes(xx, yy, zz, Directions(x0, y0, z0, x1, y1, z1, x2, y2, z2))


@inline
def across(x: float, y: float, z: float) -> tuple[float, float, float, float, float, float]:
    """Two unit vectors across a unit vector and across each other (Duff and others, JCGT 6(1), 2017)."""
    sign = math.copysign(1.0, z)
    a = -1.0 / (sign + z)
    b = x * y * a
    return 1.0 + sign * x * x * a, sign * b, -sign * x, b, sign + y * y * a, -y
