"""Random bodies to measure on, with what a generator of rays must know about each.

Lengths that systems combine before they trace (ends of an axis, sides of a box) are drawn from a coarse grid, so
that sums and differences of them are exact in the measured precision too.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from .bodies import Ball, Block, Body, Floats, General, Turned

Random = np.random.Generator
Points = Callable[[Random, int], tuple[Floats, Floats]]


@dataclass(frozen=True)
class Precision:
    """What the inputs are rounded to: all of them are such floats, for every system the same."""

    name: str
    dtype: npt.DTypeLike
    bits: int
    grid: int

    def rounded(self, array: Any) -> Floats:
        return np.asarray(array, float).astype(self.dtype).astype(float)

    def coarse(self, array: Any) -> Any:
        return np.round(np.asarray(array, float) * 2.0**self.grid) / 2.0**self.grid


SINGLE = Precision("float32", np.float32, 24, 10)
DOUBLE = Precision("float64", np.float64, 53, 26)


@dataclass(frozen=True)
class Subject:
    """A body about `center`, hardly wider than `size`.

    `rim(random, n)` gives points (n, 3) where rays may graze it, and normals there; `parallels(random, n)`
    directions (n, 3) along its axis, rulings, asymptotes or faces.
    """

    body: Body
    center: Floats
    size: float
    rim: Points
    parallels: Callable[[Random, int], Floats]


def ball(random: Random, precision: Precision, scale: float) -> Subject:
    center = precision.rounded(random.uniform(-4, 4, 3) * scale)
    radius = float(precision.rounded(random.uniform(0.5, 2) * scale))

    def rim(random: Random, n: int) -> tuple[Floats, Floats]:
        normals = unit(random.normal(size=(n, 3)))
        return center + radius * normals, normals

    return Subject(Ball(vector(center), radius), center, radius, rim, _axes)


def block(random: Random, precision: Precision, scale: float) -> Subject:
    low = precision.coarse(random.uniform(-4, 4, 3)) * scale
    sides = precision.coarse(random.uniform(0.5, 2, 3)) * scale
    center = low + sides / 2

    def rim(random: Random, n: int) -> tuple[Floats, Floats]:
        """Points of edges, and normals between those of the two sides."""
        signs = random.choice([-1.0, 1.0], (n, 3))
        signs[np.arange(n), random.integers(0, 3, n)] = 0
        places = np.where(signs == 0, random.uniform(-1, 1, (n, 3)), signs)
        return center + places * sides / 2, unit(signs * random.uniform(0.1, 1, (n, 3)))

    def parallels(random: Random, n: int) -> Floats:
        directions = unit(random.normal(size=(n, 3)))
        directions[np.arange(n), random.integers(0, 3, n)] = 0
        return directions

    size = float(np.linalg.norm(sides)) / 2
    return Subject(Block(vector(low), vector(low + sides)), center, size, rim, parallels)


def cylinder(random: Random, precision: Precision, scale: float) -> Subject:
    radius = float(precision.coarse(random.uniform(0.5, 2))) * scale
    return turned(*_upright(random, precision, scale), radius, radius)


def cone(random: Random, precision: Precision, scale: float) -> Subject:
    radius = float(precision.coarse(random.uniform(0.5, 2))) * scale
    return turned(*_upright(random, precision, scale), radius, 0.0)


def oblique(random: Random, precision: Precision, scale: float) -> Subject:
    """A cylinder or a frustum about any axis."""
    start, end = (precision.rounded(random.uniform(-3, 3, 3) * scale) for _ in range(2))
    radii = precision.rounded(random.uniform(0.3, 2, 2) * scale).tolist()
    return turned(start, end, radii[0], radii[random.integers(0, 2)])


def _upright(random: Random, precision: Precision, scale: float) -> tuple[Floats, Floats]:
    """Ends of an axis along a coordinate axis, either way."""
    start = precision.coarse(random.uniform(-4, 4, 3)) * scale
    step = np.zeros(3)
    step[random.integers(0, 3)] = random.choice([-1, 1]) * precision.coarse(random.uniform(0.5, 3)) * scale
    return start, start + step


def turned(start: Floats, end: Floats, r0: float, r1: float) -> Subject:
    axis = end - start
    length = float(np.linalg.norm(axis))

    def circle(random: Random, n: int) -> Floats:
        across = random.normal(size=(n, 3))
        across -= np.outer(across @ axis, axis) / length**2
        return unit(across)

    def rim(random: Random, n: int) -> tuple[Floats, Floats]:
        """Points of the side."""
        outward, height = circle(random, n), random.uniform(0.02, 0.98, (n, 1))
        radius = r0 + (r1 - r0) * height
        return start + height * axis + radius * outward, unit(outward * length + (r0 - r1) * axis / length)

    def parallels(random: Random, n: int) -> Floats:
        """Along rulings of the side, both ways."""
        return unit((axis + (r1 - r0) * circle(random, n)) * random.choice([-1, 1], (n, 1)))

    size = float(np.hypot(length / 2, max(r0, r1)))
    return Subject(Turned(vector(start), vector(end), r0, r1), (start + end) / 2, size, rim, parallels)


def quadric(random: Random, precision: Precision, scale: float) -> Subject:
    """An ellipsoid or a hyperboloid of one or two sheets, turned and moved, by ten coefficients.

    In its own frame x²/a² + y²/b² + s z²/c² <= k with s and k of ±1. The coefficients are rounded, and the surface that
    is meant is that of the rounded ones.
    """
    sign, level = ((1, 1), (-1, 1), (-1, -1))[random.integers(0, 3)]
    center, radii = random.uniform(-4, 4, 3) * scale, random.uniform(0.5, 2, 3) * scale
    turn = np.linalg.qr(random.normal(size=(3, 3)))[0]
    square = turn @ np.diag(np.array([1, 1, sign]) * (scale / radii) ** 2) @ turn.T
    linear = -square @ center
    constant = center @ square @ center - level * scale**2
    values = np.array([*np.diag(square), *(2 * square[[0, 1, 0], [1, 2, 2]]), *(2 * linear), constant])
    names = ("xx", "yy", "zz", "xy", "yz", "xz", "x", "y", "z", "constant")
    body = General(dict(zip(names, precision.rounded(values).tolist(), strict=True)))

    def place(own: Floats) -> Floats:
        return np.asarray((own * radii) @ turn.T)

    def rim(random: Random, n: int) -> tuple[Floats, Floats]:
        own = _canonical(random, n, sign, level)
        return center + place(own), unit((own * (1, 1, sign) / radii) @ turn.T)

    def parallels(random: Random, n: int) -> Floats:
        """Along asymptotes; the ellipsoid has none."""
        if sign > 0:
            return _axes(random, n)
        angle = random.uniform(0, 2 * np.pi, n)
        return unit(place(np.column_stack([np.cos(angle), np.sin(angle), np.ones(n)])))

    return Subject(body, center, float(radii.max()) * (1 if sign > 0 else 1.5), rim, parallels)


def _canonical(random: Random, n: int, sign: int, level: int) -> Floats:
    """Points (n, 3) of x² + y² + sign z² = level."""
    if sign > 0:
        return unit(random.normal(size=(n, 3)))
    angle, reach = random.uniform(0, 2 * np.pi, n), random.uniform(-1.2, 1.2, n)
    other = np.sqrt(1 + reach**2)
    across, z = (other, reach) if level > 0 else (reach, other * random.choice([-1, 1], n))
    return np.column_stack([across * np.cos(angle), across * np.sin(angle), z])


def unit(vectors: Floats) -> Floats:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=-1, keepdims=True))


def vector(point: Floats) -> tuple[float, float, float]:
    x, y, z = point.tolist()
    return x, y, z


def _axes(random: Random, n: int) -> Floats:
    """Along the axes of coordinates, both ways."""
    directions = np.zeros((n, 3))
    directions[np.arange(n), random.integers(0, 3, n)] = random.choice([-1, 1], n)
    return directions
