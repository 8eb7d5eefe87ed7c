"""Closed forms: moments of primitive solids, and areas, in their own frames and carried to the world.

`own_moments` and `own_area` answer for one class each and None for all others: a new closed form is
one registered function.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from functools import singledispatch
from typing import Any

import numpy as np

from ..shapes.base import Shape
from ..shapes.box import Box
from ..shapes.cylinder import Cylinder
from ..shapes.cylinder_patch import CylinderPatch
from ..shapes.disc import Disc
from ..shapes.elliptic import EllipticSolid
from ..shapes.sphere import Sphere
from ..shapes.support import real_roots
from ..shapes.triangle import Triangle
from ..shapes.vector import FloatArray

_NODES, _WEIGHTS = (np.array(a) for a in np.polynomial.legendre.leggauss(3))  # exact up to degree 5
_SIMILAR = 1e-14


@dataclass(frozen=True)
class Moments:
    """Volume, centroid (3,), and the mean of (x - c)(x - c)ᵀ over it, (3, 3): squares of lengths stay in float64."""

    volume: float
    centroid: FloatArray
    spread: FloatArray

    @property
    def second(self) -> FloatArray:
        """The second moments about the centroid: ∫ (x - c)(x - c)ᵀ dV."""
        return self.volume * self.spread

    def moved(self, matrix: FloatArray) -> Moments:
        """Carried by an affine (4, 4) matrix."""
        linear, factor = matrix[:3, :3], abs(float(np.linalg.det(matrix[:3, :3])))
        spread: FloatArray = linear @ self.spread @ linear.T
        return Moments(self.volume * factor, linear @ self.centroid + matrix[:3, 3], (spread + spread.T) / 2)


def closed_moments(shape: Shape) -> Moments | None:
    """Moments in the world, where a closed form is known."""
    try:
        own = own_moments(shape)
    except OverflowError:  # squares of a needle's widths
        return None
    return None if own is None else own.moved(shape.under().matrix)


def closed_area(shape: Shape) -> float | None:
    """Area in the world, where a closed form is known."""
    linear = shape.under().matrix[:3, :3]
    if isinstance(shape, Box):
        x, y, z = (linear * np.subtract(shape.high, shape.low)).T
        return 2 * (_parallelogram(x, y) + _parallelogram(y, z) + _parallelogram(z, x))
    if isinstance(shape, Triangle):
        a, b, c = (np.array(p) for p in (shape.a, shape.b, shape.c))
        return _parallelogram(linear @ (b - a), linear @ (c - a)) / 2
    if isinstance(shape, Disc):
        return math.pi * _parallelogram(shape.radius * linear[:, 0], shape.radius * linear[:, 1])
    own, factor = own_area(shape), _similarity(linear)
    return None if own is None or factor is None else own * factor * factor


def _parallelogram(a: FloatArray, b: FloatArray) -> float:
    return float(np.linalg.norm(np.cross(a, b)))


def _similarity(linear: FloatArray) -> float | None:
    """The factor of a linear map that keeps angles, up to the rounding of its matrix; None for others."""
    gram = linear @ linear.T
    square = float(np.trace(gram)) / 3
    return math.sqrt(square) if abs(gram - square * np.eye(3)).max() <= _SIMILAR * square else None


@singledispatch
def own_moments(shape: Any) -> Moments | None:
    """Moments in the shape's own frame, where a closed form is known."""
    del shape
    return None


@singledispatch
def own_area(shape: Any) -> float | None:
    """Area in the shape's own frame, where a closed form is known that holds for similarities only."""
    del shape
    return None


@own_moments.register
def _(box: Box) -> Moments:
    edges, middle = np.subtract(box.high, box.low), np.array(box.low) / 2 + np.array(box.high) / 2
    volume = float(np.prod(edges))
    return Moments(volume, middle, np.diag(edges**2 / 12))


@own_moments.register
def _(sphere: Sphere) -> Moments:
    volume = 4 / 3 * math.pi * sphere.radius**3
    return Moments(volume, np.zeros(3), sphere.radius**2 / 5 * np.eye(3))


@own_area.register
def _(sphere: Sphere) -> float:
    return 4 * math.pi * sphere.radius**2


@own_moments.register
def _(solid: EllipticSolid) -> Moments:
    (sx, sy), (g0, g1, g2) = solid.squares, (float(g) for g in solid.profile)
    return _sections(float(sx), float(sy), (g0, g1, g2), solid.heights)


@own_moments.register
def _(cylinder: Cylinder) -> Moments:
    """A wedge between the angles a and b; sines and cosines of a full turn cancel to the last bit."""
    r, height = cylinder.radius, cylinder.length
    a, b = math.radians(cylinder.start_angle), math.radians(cylinder.end_angle)
    turn = math.radians(cylinder.end_angle - cylinder.start_angle)
    full = cylinder.end_angle - cylinder.start_angle == 360
    volume = r * r * turn / 2 * height
    x, y = (0.0, 0.0) if full else (math.sin(b) - math.sin(a), math.cos(a) - math.cos(b))
    centroid = np.array([2 * r / 3 * x / turn, 2 * r / 3 * y / turn, height / 2])
    # The means of x², y², x y about the axis, in units of r² / (4 turn)
    double, mixed = (
        (0.0, 0.0) if full else ((math.sin(2 * b) - math.sin(2 * a)) / 2, math.sin(b) ** 2 - math.sin(a) ** 2)
    )
    spread = np.zeros((3, 3))
    spread[:2, :2] = r * r / (4 * turn) * np.array([[turn + double, mixed], [mixed, turn - double]])
    spread[:2, :2] -= np.outer(centroid[:2], centroid[:2])
    spread[2, 2] = height**2 / 12
    return Moments(volume, centroid, spread)


@own_area.register
def _(cylinder: Cylinder) -> float:
    turn = math.radians(cylinder.end_angle - cylinder.start_angle)
    r, walls = cylinder.radius, 0.0 if cylinder.end_angle - cylinder.start_angle == 360 else 2.0
    return r * turn * cylinder.length + r * r * turn + walls * r * cylinder.length


@own_area.register
def _(patch: CylinderPatch) -> float:
    return math.radians(patch.end_angle - patch.start_angle) * patch.radius * patch.length


def _sections(sx: float, sy: float, profile: tuple[float, float, float], heights: tuple[float, float]) -> Moments:
    """Moments of sx x² + sy y² <= g(z) = g0 + g1 z + g2 z², low <= z <= high, by Gauss's rule (exact here).

    The section at z is an ellipse with area π g / √(sx sy), ∫ x² = area g / (4 sx), ∫ y² = area g / (4 sy).
    """
    z, weight = _quadrature(profile, heights)
    g = np.maximum(np.polynomial.polynomial.polyval(z, profile), 0.0)
    area = math.pi / math.sqrt(sx * sy) * g * weight
    volume = float(area.sum())
    if volume == 0:
        return Moments(0.0, np.full(3, np.nan), np.zeros((3, 3)))
    share = area / volume
    height = float(share @ z)
    across = float(share @ g) / 4
    spread = np.diag([across / sx, across / sy, float(share @ (z - height) ** 2)])
    return Moments(volume, np.array([0.0, 0.0, height]), spread)


def _quadrature(profile: tuple[float, float, float], heights: tuple[float, float]) -> tuple[FloatArray, FloatArray]:
    """Nodes and weights over the parts of [low, high] where g > 0."""
    g0, g1, g2 = profile
    low, high = heights
    cuts = sorted({low, high, *(root for root in real_roots(g2, g1, g0) if low < root < high)}) if low < high else []
    nodes, weights = [np.zeros(0)], [np.zeros(0)]
    for a, b in itertools.pairwise(cuts):
        middle, half = a / 2 + b / 2, b / 2 - a / 2
        if g0 + middle * (g1 + middle * g2) > 0:
            nodes.append(middle + half * _NODES)
            weights.append(half * _WEIGHTS)
    return np.concatenate(nodes), np.concatenate(weights)
