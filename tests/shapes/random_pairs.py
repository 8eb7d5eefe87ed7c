"""Random pairs of quadrics under motions, after their formulas alone: no code of the package but its classes.

A leaf is a list of polynomials of degree two, symmetric 4 × 4 matrices of fractions, all <= 0 inside. Both leaves stand
in one frame, which a chain of motions carries to the world; that is worked out in 100 digits.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import mpmath
import numpy as np

import conicoid as co

NICE = (0.25, 0.5, 1.0, 1.5, 2.0, 3.0)
DIGITS = mpmath.MPContext()
DIGITS.dps = 120


def form(
    xx: Any = 0, yy: Any = 0, zz: Any = 0, x: Any = 0, y: Any = 0, z: Any = 0, one: Any = 0
) -> list[list[Fraction]]:
    """xx x² + yy y² + zz z² + x x + y y + z z + one as a symmetric matrix."""
    m = [[Fraction(0)] * 4 for _ in range(4)]
    for k, value in enumerate((xx, yy, zz, one)):
        m[k][k] = Fraction(value)
    for k, value in enumerate((x, y, z)):
        m[k][3] = m[3][k] = Fraction(value) / 2
    return m


def moved(matrix: list[list[Fraction]], factors: Sequence[float], shift: Sequence[float]) -> list[list[Fraction]]:
    """The image of p ↦ factors p + shift, by substitution of its inverse."""
    back = [[Fraction(0)] * 4 for _ in range(4)]
    for i in range(3):
        back[i][i] = 1 / Fraction(factors[i])
        back[i][3] = -Fraction(shift[i]) / Fraction(factors[i])
    back[3][3] = Fraction(1)
    half = [[sum(matrix[i][k] * back[k][j] for k in range(4)) for j in range(4)] for i in range(4)]
    return [[sum(back[k][i] * half[k][j] for k in range(4)) for j in range(4)] for i in range(4)]


@dataclass
class Leaf:
    """A solid, and the polynomials that are <= 0 in it."""

    solid: Any
    forms: list[list[list[Fraction]]]

    def holds(self, point: Sequence[float]) -> bool:
        """In rational arithmetic."""
        p = [*map(Fraction, point), Fraction(1)]
        return all(
            sum(p[i] * m[i][j] * p[j] for i, j in itertools.product(range(4), repeat=2)) <= 0 for m in self.forms
        )

    def seems(self, points: np.ndarray) -> np.ndarray:
        """In floats, for many points."""
        whole = np.concatenate([points, np.ones((len(points), 1))], axis=1)
        values = [((whole @ np.array(m, dtype=float)) * whole).sum(axis=1) for m in self.forms]
        return np.all(np.array(values) <= 0, axis=0)


def value(rng: np.random.Generator) -> float:
    return float(rng.choice(NICE)) if rng.random() < 0.8 else float(rng.uniform(0.1, 4))


def z_range(rng: np.random.Generator) -> tuple[Any, list[Any]]:
    if rng.random() < 0.5:
        return None, []
    low, high = sorted(rng.choice([-2.0, -1.0, -0.5, 0.0, 0.5, 1.0, 2.0, math.inf], 2, replace=False).tolist())
    low = -math.inf if rng.random() < 0.2 and math.isfinite(high) else low
    forms = [form(z=-1, one=low)] if math.isfinite(low) else []
    return (low, high), forms + ([form(z=1, one=-Fraction(high))] if math.isfinite(high) else [])


def within(rng: np.random.Generator) -> tuple[Any, list[Any]]:
    if rng.random() < 0.5:
        return None, []
    low = rng.choice([-2.0, -1.0, -0.5, 0.0], 3).tolist()
    high = rng.choice([0.5, 1.0, 2.0], 3).tolist()
    box = co.Box(tuple(low), tuple(high))
    return box, box_forms(low, high)


def box_forms(low: Sequence[float], high: Sequence[float]) -> list[Any]:
    return [form(**{a: -1}, one=e) for a, e in zip("xyz", low, strict=True)] + [
        form(**{a: 1}, one=-Fraction(e)) for a, e in zip("xyz", high, strict=True)
    ]


def something_left(make: Any, rng: np.random.Generator) -> Leaf:
    """Drawn again where a range leaves nothing of the solid, which is refused."""
    while True:
        try:
            return make(rng)
        except ValueError as error:
            if "a part of the solid" not in str(error):
                raise


def quadric(rng: np.random.Generator) -> Leaf:
    """One of the quadrics of the interface, in its own frame."""
    a, e, h = value(rng), value(rng), value(rng)
    between, ends = z_range(rng)
    inside, sides = within(rng)
    square = Fraction(a) ** 2
    kind = int(rng.integers(13))
    if kind == 0:
        c = rng.choice([0.0, 0.0, 1.0, -0.5], 3).tolist()
        one = sum(Fraction(v) ** 2 for v in c) - square
        return Leaf(co.Sphere(a, tuple(c)), [form(1, 1, 1, *(-2 * Fraction(v) for v in c), one)])
    if kind == 1:
        inverses = [1 / Fraction(r) ** 2 for r in (a, e, h)]
        return Leaf(co.Ellipsoid((a, e, h), z_range=between), [form(*inverses, one=-1), *ends])
    if kind == 2:
        return Leaf(co.DoubleCone(a, between), [form(1, 1, -square), *ends])
    if kind == 3:
        return Leaf(co.EllipticParaboloid(a, e, between), [form(a, e, z=-1), *ends])
    if kind == 4:
        return Leaf(co.HyperbolicParaboloid(a, e, inside), [form(a, -Fraction(e), z=-1), *sides])
    if kind == 5:
        return Leaf(co.OneSheetHyperboloid(a, e, h, between), [form(a, e, -Fraction(h), one=-1), *ends])
    if kind == 6:
        return Leaf(co.TwoSheetHyperboloid(a, e, h, between), [form(a, e, -Fraction(h), one=1), *ends])
    if kind == 7:
        return Leaf(co.EllipticCone(a, e, h, between), [form(a, e, -Fraction(h)), *ends])
    if kind == 8:
        return Leaf(co.EllipticCylinder(a, e, between), [form(a, e, one=-1), *ends])
    if kind == 9:
        return Leaf(co.HyperbolicCylinder(a, e, inside), [form(a, -Fraction(e), one=-1), *sides])
    if kind == 10:
        return Leaf(co.ParabolicCylinder(a, inside), [form(1, y=-2 * Fraction(a)), *sides])
    if kind == 11:
        low, high = float(rng.choice([-1.0, 0.0])), float(rng.choice([1.0, 2.0]))
        solid = co.Cylinder((0, 0, low), (0, 0, high), a)
        return Leaf(solid, [form(1, 1, one=-square), form(z=-1, one=low), form(z=1, one=-Fraction(high))])
    whole = rng.integers(-1, 2, (4, 4))
    whole[0, 0] = rng.choice([-1, 1])
    matrix = [[Fraction(int(whole[i, j] + whole[j, i]), 2) for j in range(4)] for i in range(4)]
    return Leaf(co.Quadric(matrix=tuple(map(tuple, whole.astype(float).tolist()))), [matrix])


def flat(rng: np.random.Generator) -> Leaf:
    """A box, a half-space or a tetrahedron."""
    kind = int(rng.integers(3))
    if kind == 0:
        low, high = rng.choice([-2.0, -1.0, 0.0], 3).tolist(), rng.choice([0.5, 1.0, 2.0], 3).tolist()
        return Leaf(co.Box(tuple(low), tuple(high)), box_forms(low, high))
    if kind == 1:
        normal, offset = rng.integers(-2, 3, 3).astype(float), float(rng.choice([0.0, 0.5, 1.0, -1.0]))
        normal[2] = normal[2] or 1.0
        x, y, z = normal.tolist()
        return Leaf(co.HalfSpace((x, y, z), offset), [form(x=x, y=y, z=z, one=-Fraction(offset))])
    normals = ((-1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, -1.0), (1.0, 1.0, 1.0))
    return Leaf(
        co.Polyhedron(normals, (0.0, 0.0, 0.0, 1.0)),
        [form(x=-1), form(y=-1), form(z=-1), form(x=1, y=1, z=1, one=-1)],
    )


@dataclass
class Pair:
    """Two leaves, what is made of them, and the map to the world in 100 digits."""

    solid: Any
    first: Leaf
    second: Leaf
    minus: bool
    rows: Any

    def seems(self, points: np.ndarray) -> np.ndarray:
        return self.first.seems(points) & (self.second.seems(points) != self.minus)

    def holds(self, point: Sequence[float]) -> bool:
        return self.first.holds(point) and self.second.holds(point) != self.minus

    def world(self, point: Sequence[float]) -> list[Any]:
        p = DIGITS.matrix([*map(DIGITS.mpf, point), 1])
        return list((self.rows * p)[:3])


def random_pair(rng: np.random.Generator) -> Pair:
    """The second leaf may be moved against the first by halves; the whole is moved by up to three steps."""
    first, second = (something_left(quadric, rng) if rng.random() < 0.85 else flat(rng) for _ in range(2))
    if rng.random() < 0.5:
        factors, shift = rng.choice([0.5, 1.0, 1.0, -2.0], 3).tolist(), rng.choice([0.0, 0.0, 1.0, -0.5], 3).tolist()
        second = Leaf(second.solid.scale(tuple(factors)).translate(tuple(shift)),
                      [moved(m, factors, shift) for m in second.forms])  # fmt: skip
    minus = bool(rng.random() < 0.3)
    solid, rows = (first.solid - second.solid) if minus else (first.solid & second.solid), DIGITS.eye(4)
    for _ in range(int(rng.integers(4))):
        solid, step = random_step(rng, solid)
        rows = step * rows
    return Pair(solid, first, second, minus, rows)


def random_step(rng: np.random.Generator, solid: Any) -> tuple[Any, Any]:
    """A motion, and its matrix from the formulas."""
    step, kind = DIGITS.eye(4), int(rng.integers(4))
    if kind == 0:
        shift = rng.choice([0.0, 1.0, -3.0, 0.3, 1e6], 3).tolist()
        for i in range(3):
            step[i, 3] = DIGITS.mpf(shift[i])
        return solid.translate(tuple(shift)), step
    if kind == 1:
        factors = rng.choice([1.0, 2.0, 0.5, -1.0, 0.3], 3).tolist()
        factors = [f * float(rng.choice([1.0, 1.0, 1.0, 1e-9, 1e9, 1e40, 1e-40])) for f in factors[:1] * 3] \
            if rng.random() < 0.2 else factors  # fmt: skip
        for i in range(3):
            step[i, i] = DIGITS.mpf(factors[i])
        return solid.scale(tuple(factors)), step
    if kind == 2:
        matrix = np.eye(4)
        matrix[:3, :3] += np.triu(rng.choice([0.0, 0.0, 0.5, -1.0, 0.1], (3, 3)), 1)
        return solid.transform(matrix.tolist()), DIGITS.matrix(matrix.tolist())
    axes = [(1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 2, 3), (1, 1, 0), (1, 1, 1)]
    axis = axes[int(rng.integers(len(axes)))]
    angle = float(rng.choice([15, 30, 45, 60, 75, 90, 105, 180])) if rng.random() < 0.7 else float(rng.uniform(0, 360))
    length = DIGITS.sqrt(sum(c * c for c in axis))
    x, y, z = (c / length for c in axis)
    c, s = DIGITS.cospi(DIGITS.mpf(angle) / 180), DIGITS.sinpi(DIGITS.mpf(angle) / 180)
    k = 1 - c
    turn = [[x * x * k + c, x * y * k - z * s, x * z * k + y * s],
            [x * y * k + z * s, y * y * k + c, y * z * k - x * s],
            [x * z * k - y * s, y * z * k + x * s, z * z * k + c]]  # fmt: skip
    for i, j in itertools.product(range(3), repeat=2):
        step[i, j] = turn[i][j]
    return solid.rotate(axis, angle), step
