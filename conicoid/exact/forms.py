"""Surfaces as polynomials with integer coefficients, and what is left of them on a ray or at a point."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from ..shapes.surface import PlaneSurface, QuadricSurface, Surface
from .roots import CANCELLED, Quadratic, quiet

Vector = tuple[Fraction, Fraction, Fraction]
_EXACT = 300


def fraction(value: Any) -> Fraction:
    """A float, an integer, a fraction or a 400-bit number, exactly."""
    if hasattr(value, "_mpf_"):
        negative, mantissa, exponent, _ = value._mpf_
        return Fraction(-int(mantissa) if negative else int(mantissa)) * Fraction(2) ** int(exponent)
    return Fraction(value)


def vector(values: Iterable[Any]) -> Vector:
    x, y, z = values
    return fraction(x), fraction(y), fraction(z)


def dot(a: Sequence[Fraction], b: Sequence[Fraction]) -> Fraction:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def is_rounded(values: Iterable[Any]) -> bool:
    """Are some of the numbers irrational on paper? They fill the 400 bits, those that are exact do not."""
    return any(hasattr(v, "_mpf_") and int(v._mpf_[3]) > _EXACT for v in values)


def integers(values: Sequence[Fraction]) -> list[int]:
    """Numbers in the same ratios, by a positive factor."""
    common = math.lcm(*(v.denominator for v in values))
    return [v.numerator * (common // v.denominator) for v in values]


@dataclass(frozen=True)
class Form:
    """xx X² + yy Y² + zz Z² + 2 xy XY + 2 xz XZ + 2 yz YZ + 2 x X + 2 y Y + 2 z Z + one: <= 0 inside."""

    second: tuple[int, int, int, int, int, int]
    first: tuple[int, int, int]
    one: int
    rounded: bool = False
    """Are some of its numbers irrational on paper?"""

    def _terms(self, p: Sequence[int], q: Sequence[int]) -> list[int]:
        xx, yy, zz, xy, xz, yz = self.second
        return [
            xx * p[0] * q[0], yy * p[1] * q[1], zz * p[2] * q[2],
            xy * (p[0] * q[1] + p[1] * q[0]), xz * (p[0] * q[2] + p[2] * q[0]), yz * (p[1] * q[2] + p[2] * q[1]),
        ]  # fmt: skip

    def _sum(self, terms: Sequence[int]) -> int:
        total = sum(terms)
        return quiet(total, sum(abs(term) for term in terms)) if self.rounded else total

    def along(self, line: Line) -> Quadratic:
        """On a ray, times a positive number."""
        o, d, unit = line.origin, line.direction, line.unit
        slopes = [f * x * unit for f, x in zip(self.first, d, strict=True)]
        return Quadratic(
            self._sum(self._terms(d, d)), self._sum([*self._terms(o, d), *slopes]), self.at(line), self.rounded
        )

    def at(self, line: Line) -> int:
        """At the origin of a ray, times a positive number."""
        o, unit = line.origin, line.unit
        levels = [2 * f * x * unit for f, x in zip(self.first, o, strict=True)]
        return self._sum([*self._terms(o, o), *levels, self.one * unit * unit])


@dataclass(frozen=True)
class Line:
    """(origin + t direction) / unit, in integers."""

    origin: tuple[int, ...]
    direction: tuple[int, ...]
    unit: int


def line(origin: Sequence[float], direction: Sequence[float]) -> Line:
    """A ray of floats."""
    numbers = [Fraction(float(x)) for x in (*origin, *direction)]
    common = math.lcm(*(n.denominator for n in numbers))
    whole = [n.numerator * (common // n.denominator) for n in numbers]
    return Line(tuple(whole[:3]), tuple(whole[3:]), common)


def form_of(surface: Surface) -> Form:
    """A surface as its record in the table of surfaces has it: a plane's normal leads with a positive number."""
    if isinstance(surface, PlaneSurface):
        normal, offset = vector(surface.normal), fraction(surface.offset)
        turned = -1 if next(float(n) for n in surface.normal if float(n)) < 0 else 1
        x, y, z, one = integers([turned * n for n in normal] + [-2 * turned * offset])
        return Form((0, 0, 0, 0, 0, 0), (x, y, z), one, is_rounded((*surface.normal, surface.offset)))
    return _quadric(surface)


def ball_form(center: Sequence[float], radius: float) -> Form:
    """A ball of floats."""
    c, r = vector(center), Fraction(radius)
    unit, x, y, z, one = integers([Fraction(1), -c[0], -c[1], -c[2], dot(c, c) - r * r])
    return Form((unit, unit, unit, 0, 0, 0), (x, y, z), one)


def total(terms: Sequence[Fraction], rounded: bool) -> Fraction:
    """A sum, zero where it cancels to the last of 400 bits."""
    value = sum(terms, Fraction(0))
    return Fraction(0) if rounded and abs(value) * 2**CANCELLED < sum(abs(t) for t in terms) else value


def _quadric(surface: QuadricSurface) -> Form:
    every = (
        *surface.squares,
        *surface.linear,
        surface.constant,
        *surface.anchor,
        *(w for r in surface.rows for w in r),
    )
    rounded = is_rounded(every)
    rows = [vector(row) for row in surface.rows]
    squares, linear, anchor = vector(surface.squares), vector(surface.linear), vector(surface.anchor)
    shift = [-total([w * x for w, x in zip(row, anchor, strict=True)], rounded) for row in rows]
    second = [
        total([squares[k] * rows[k][i] * rows[k][j] for k in range(3)], rounded)
        for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
    ]
    first = [
        total([t * rows[k][i] for k in range(3) for t in (squares[k] * shift[k], linear[k])], rounded) for i in range(3)
    ]
    ones = [t for k in range(3) for t in (squares[k] * shift[k] ** 2, 2 * linear[k] * shift[k])]
    a, b, c, d, e, f, x, y, z, w = integers([*second, *first, total([*ones, -fraction(surface.constant)], rounded)])
    return Form((a, b, c, d, e, f), (x, y, z), w, rounded)
