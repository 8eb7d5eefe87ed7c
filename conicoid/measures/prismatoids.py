"""Closed forms of trapezoids, wedges, regular prisms, pyramids and parallelepipeds."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..shapes.parallelepiped import Parallelepiped
from ..shapes.regular_prism import Pyramid, Regular, RegularPrism
from ..shapes.trapezoid import BetweenRectangles, Trapezoid, Wedge
from ..shapes.vector import FloatArray
from .closed import Moments, own_area, own_moments

_NODES, _WEIGHTS = (np.array(a) for a in np.polynomial.legendre.leggauss(3))  # exact up to degree 5


@own_moments.register(Trapezoid)
@own_moments.register(Wedge)
def _(solid: BetweenRectangles) -> Moments:
    """At each height a rectangle whose ends are linear in z."""
    share = (1 + _NODES) / 2
    ends = _ends(solid)
    low, high = (float(z) for z in solid.heights)
    (x, wide), (y, deep) = (_middle_and_size(*(a + (b - a) * share for a, b in ends[i])) for i in (0, 1))
    z, weight = low + (high - low) * share, (high - low) / 2 * _WEIGHTS * wide * deep
    return _stacked(weight, x, y, z, wide**2 / 12, deep**2 / 12)


def _ends(solid: BetweenRectangles) -> list[list[tuple[float, float]]]:
    """For x and for y: (at the lower end, at the upper) of the low side, and of the high one."""
    one, other = solid.rectangles()
    return [
        [(float(a), float(b)) for a, b in zip(low, high, strict=True)]
        for low, high in ((one.x, other.x), (one.y, other.y))
    ]


def _middle_and_size(low: FloatArray, high: FloatArray) -> tuple[FloatArray, FloatArray]:
    return (low + high) / 2, high - low


def _stacked(weight: FloatArray, x: Any, y: Any, z: FloatArray, across_x: FloatArray, across_y: FloatArray) -> Moments:
    """Of sections about (x, y) at heights z, with means of the squares about there, and none of the product."""
    volume = float(weight.sum())
    share = weight / volume
    middles = np.array([x + 0 * z, y + 0 * z, z])
    mean = middles @ share
    from_mean = middles - mean[:, None]
    spread = (from_mean * share) @ from_mean.T + np.diag([share @ across_x, share @ across_y, 0.0])
    return Moments(volume, mean, spread)


@own_area.register(Trapezoid)
@own_area.register(Wedge)
def _(solid: BetweenRectangles) -> float:
    (x0, x1), (y0, y1) = _ends(solid)
    rise = float(solid.heights[1]) - float(solid.heights[0])
    wide, deep = ([b - a for a, b in zip(low, high, strict=True)] for low, high in ((x0, x1), (y0, y1)))
    area = wide[0] * deep[0] + wide[1] * deep[1]
    area += sum((deep[0] + deep[1]) / 2 * math.hypot(rise, end[1] - end[0]) for end in (x0, x1))
    return area + sum((wide[0] + wide[1]) / 2 * math.hypot(rise, end[1] - end[0]) for end in (y0, y1))


@own_moments.register(RegularPrism)
@own_moments.register(Pyramid)
def _(solid: Regular) -> Moments:
    """Of a regular polygon with its corners at R the area is n R² sin(2π/n) / 2, the mean of x² R² (2 + cos) / 12."""
    angle = 2 * math.pi / solid.sides
    low, high = solid.z_range
    z, radius = low + (high - low) * (1 + _NODES) / 2, _at_corners(solid) @ [(1 - _NODES) / 2, (1 + _NODES) / 2]
    weight = (high - low) / 2 * _WEIGHTS * solid.sides / 2 * radius**2 * math.sin(angle)
    across = radius**2 * (2 + math.cos(angle)) / 12
    return _stacked(weight, 0.0, 0.0, z, across, across)


@own_area.register(RegularPrism)
@own_area.register(Pyramid)
def _(solid: Regular) -> float:
    below, above = _at_corners(solid).tolist()
    half = math.pi / solid.sides
    slant = math.hypot(solid.z_range[1] - solid.z_range[0], (above - below) * math.cos(half))
    ends = (below**2 + above**2) * math.sin(2 * half) / 2
    return float(solid.sides * ((below + above) * math.sin(half) * slant + ends))


def _at_corners(solid: Regular) -> FloatArray:
    """The radii of the circles through the corners of both ends."""
    factor = 1.0 if solid.radius_to == "corners" else 1 / math.cos(math.pi / solid.sides)
    return factor * np.array(solid.radii)


@own_moments.register
def _(solid: Parallelepiped) -> Moments:
    """The unit cube, carried: edges are the columns."""
    edges = np.array([solid.a, solid.b, solid.c]).T
    middle = np.array(solid.corner) + edges.sum(axis=1) / 2
    return Moments(abs(float(np.linalg.det(edges))), middle, edges @ edges.T / 12)


@own_area.register
def _(solid: Parallelepiped) -> float:
    a, b, c = (np.array(edge) for edge in (solid.a, solid.b, solid.c))
    return 2 * sum(float(np.linalg.norm(np.cross(u, v))) for u, v in ((a, b), (b, c), (c, a)))
