"""The solids whose distances are measured: exact numbers for the reference, a shape for Conicoid.

A body is, in exact numbers, (x, y, z, 1) Q (x, y, z, 1)ᵀ <= 0 between slabs low <= n·x <= high. All lengths are
floats that the measured precision can hold, so that every system is told the same solid to the bit.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from ...shapes.base import Shape
from ...shapes.box import Box
from ...shapes.cone import Cone
from ...shapes.cylinder import Cylinder
from ...shapes.quadric import Quadric
from ...shapes.sphere import Sphere

Floats = npt.NDArray[np.float64]
Row = tuple[Fraction, ...]
Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Slab:
    """low <= normal·x <= high."""

    normal: Row
    low: Fraction
    high: Fraction


@dataclass(frozen=True)
class Ball:
    """|x - center|² <= radius²."""

    center: Vector
    radius: float

    def quadric(self) -> list[Row]:
        c, r = _exact(self.center), Fraction(self.radius)
        return _about(c, [[Fraction(i == j) for j in range(3)] for i in range(3)], (Fraction(),) * 3, -r * r)

    def slabs(self) -> list[Slab]:
        return []

    def shape(self) -> Shape:
        return Sphere(self.radius, self.center)


@dataclass(frozen=True)
class Block:
    """low <= x <= high on every axis."""

    low: Vector
    high: Vector

    def quadric(self) -> None:
        """It has none."""

    def slabs(self) -> list[Slab]:
        axes = ([Fraction(i == j) for j in range(3)] for i in range(3))
        return [Slab(tuple(n), *_exact((a, b))) for n, a, b in zip(axes, self.low, self.high, strict=True)]

    def shape(self) -> Shape:
        return Box(self.low, self.high)


@dataclass(frozen=True)
class Turned:
    """A closed cylinder (r0 = r1), cone (r1 = 0) or frustum about the axis from start to end.

    With q = x - start and a = end - start: 0 <= q·a <= a·a and a·a |q × a|² <= (r0 a·a + (r1 - r0) q·a)².
    """

    start: Vector
    end: Vector
    start_radius: float
    end_radius: float

    def _axis(self) -> tuple[Row, Row, Fraction]:
        start, end = _exact(self.start), _exact(self.end)
        a = tuple(q - p for p, q in zip(start, end, strict=True))
        return start, a, _dot(a, a)

    def quadric(self) -> list[Row]:
        start, a, n = self._axis()
        r, growth = Fraction(self.start_radius), Fraction(self.end_radius) - Fraction(self.start_radius)
        # |q × a|² = a·a q·q - (q·a)²
        factor = n + growth * growth
        square = [[n * n * (i == j) - factor * a[i] * a[j] for j in range(3)] for i in range(3)]
        return _about(start, square, tuple(-r * n * growth * x for x in a), -((r * n) ** 2))

    def slabs(self) -> list[Slab]:
        start, a, n = self._axis()
        foot = _dot(start, a)
        return [Slab(a, foot, foot + n)]

    def shape(self) -> Shape:
        if self.start_radius == self.end_radius:
            return Cylinder(self.start, self.end, self.start_radius)
        return Cone(self.start, self.end, self.start_radius, self.end_radius)


@dataclass(frozen=True)
class General:
    """The quadric of ten coefficients: xx x² + ... + xy x y + ... + x x + ... + constant <= 0."""

    coefficients: dict[str, float]

    def quadric(self) -> list[Row]:
        c = {name: Fraction(value) for name, value in self.coefficients.items()}
        half = Fraction(1, 2)
        xy, yz, xz, x, y, z = (half * c[name] for name in ("xy", "yz", "xz", "x", "y", "z"))
        return [(c["xx"], xy, xz, x), (xy, c["yy"], yz, y), (xz, yz, c["zz"], z), (x, y, z, c["constant"])]

    def slabs(self) -> list[Slab]:
        return []

    def shape(self) -> Shape:
        return Quadric(coefficients=self.coefficients)


Body = Ball | Block | Turned | General


def inside(body: Body, points: Floats) -> npt.NDArray[np.bool_]:
    """Which of points (n, 3) lie in the body, in floats: good enough to choose rays by."""
    result = np.ones(len(points), bool)
    for slab in body.slabs():
        h = points @ np.array(slab.normal, float)
        result &= (float(slab.low) <= h) & (h <= float(slab.high))
    quadric: Any = body.quadric()
    if quadric is not None:
        whole = np.column_stack([points, np.ones(len(points))])
        result &= np.einsum("ni,ij,nj->n", whole, np.array(quadric, float), whole) <= 0
    return result


def _exact(numbers: Any) -> Row:
    return tuple(map(Fraction, numbers))


def _dot(a: Row, b: Row) -> Fraction:
    return sum((x * y for x, y in zip(a, b, strict=True)), Fraction())


def _about(center: Row, square: list[list[Fraction]], linear: Row, constant: Fraction) -> list[Row]:
    """Q of qᵀ square q + 2 linear·q + constant, q = x - center."""
    moved = tuple(linear[i] - _dot(tuple(square[i]), center) for i in range(3))
    rest = constant - _dot(linear, center) - _dot(moved, center)
    return [*((*square[i], moved[i]) for i in range(3)), (*moved, rest)]
