"""Surfaces as polynomials with integer coefficients, and what is left of them on a ray or at a point."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from ..shapes import exact as ex
from ..shapes.rational import dot, fraction
from ..shapes.surface import PlaneSurface, QuadricSurface, Surface
from .roots import Quadratic

Vector = tuple[Fraction, Fraction, Fraction]
Numbers = tuple[int, int, int, int, int, int, int, int, int, int]

SURE = ex.CANCELLED
"""A sum of what is irrational on paper is off by less than 2^-SURE of its terms."""
_EXACT = ex.BITS - 100


def vector(values: Iterable[Any]) -> Vector:
    x, y, z = values
    return fraction(x), fraction(y), fraction(z)


def is_rounded(values: Iterable[Any]) -> bool:
    """Are some of the numbers irrational on paper? They fill all bits, those that are exact do not."""
    return any(hasattr(v, "_mpf_") and int(v._mpf_[3]) > _EXACT for v in values)


def integers(values: Sequence[Fraction]) -> list[int]:
    """Numbers in the same ratios, by a positive factor."""
    common = math.lcm(*(v.denominator for v in values))
    return [v.numerator * (common // v.denominator) for v in values]


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


@dataclass(frozen=True)
class Form:
    """xx X² + yy Y² + zz Z² + 2 xy XY + 2 xz XZ + 2 yz YZ + 2 x X + 2 y Y + 2 z Z + one: <= 0 inside.

    `sizes` of what is irrational on paper: each coefficient is a sum of terms that add up to so much without signs.
    """

    coefficients: Numbers
    sizes: Numbers | None = None

    @property
    def is_flat(self) -> bool:
        return not any(self.coefficients[:6])

    def along(self, line: Line) -> Quadratic:
        """On a ray, times a positive number."""
        return _settled(_along(self.coefficients, line), self._off(line))

    def at(self, line: Line) -> int:
        """At the origin of a ray, times a positive number."""
        return self.along(line).c

    def _off(self, line: Line) -> tuple[int, int, int]:
        """How far its coefficients on a ray may be off."""
        if self.sizes is None:
            return 0, 0, 0
        beside = Line(tuple(map(abs, line.origin)), tuple(map(abs, line.direction)), line.unit)
        a, b, c = _along(self.sizes, beside)
        return (a >> SURE) + 1, (b >> SURE) + 1, (c >> SURE) + 1


def _along(form: Numbers, line: Line) -> tuple[int, int, int]:
    """a, b, c of a t² + 2 b t + c"""
    xx, yy, zz, xy, xz, yz, x, y, z, one = form
    (ox, oy, oz), (dx, dy, dz), unit = line.origin, line.direction, line.unit
    # Half the gradient, without its constant part, along the direction and at the origin
    ux, uy, uz = xx * dx + xy * dy + xz * dz, xy * dx + yy * dy + yz * dz, xz * dx + yz * dy + zz * dz
    px, py, pz = xx * ox + xy * oy + xz * oz, xy * ox + yy * oy + yz * oz, xz * ox + yz * oy + zz * oz
    a = ux * dx + uy * dy + uz * dz
    b = ux * ox + uy * oy + uz * oz + (x * dx + y * dy + z * dz) * unit
    c = px * ox + py * oy + pz * oz + (2 * (x * ox + y * oy + z * oz) + one * unit) * unit
    return a, b, c


def _settled(values: tuple[int, int, int], off: tuple[int, int, int]) -> Quadratic:
    """A quadratic whose coefficients are 0 where they cannot be told from that."""
    known = [abs(value) > 2 * error for value, error in zip(values, off, strict=True)]
    a, b, c = (value if sure else 0 for value, sure in zip(values, known, strict=True))
    off_a, off_b, off_c = (error if sure else 0 for error, sure in zip(off, known, strict=True))
    return Quadratic(a, b, c, (off_a, off_b, off_c))


def form_of(surface: Surface) -> Form:
    """A surface as its record in the table of surfaces has it: a plane's normal leads with a positive number."""
    if isinstance(surface, PlaneSurface):
        return _plane(surface)
    linear = (*surface.squares, *surface.linear, surface.constant, *surface.anchor)
    if is_rounded((*linear, *(w for row in surface.rows for w in row))):
        terms = surface.terms()
        return _rounded([ex.cancelling_sum(each) for each in terms], [sum(map(abs, each)) for each in terms])
    return _exact(surface)


def ball_form(center: Sequence[float], radius: float) -> Form:
    """A ball of floats."""
    c, r = vector(center), Fraction(radius)
    unit, x, y, z, one = integers([Fraction(1), -c[0], -c[1], -c[2], dot(c, c) - r * r])
    return Form((unit, unit, unit, 0, 0, 0, x, y, z, one))


def _plane(surface: PlaneSurface) -> Form:
    turned = -1 if next(float(n) for n in surface.normal if float(n)) < 0 else 1
    numbers = [0] * 6 + [turned * n for n in surface.normal] + [-2 * turned * surface.offset]
    if is_rounded((*surface.normal, surface.offset)):
        return _rounded(numbers, [abs(n) for n in numbers])
    return Form(_ten(integers([fraction(n) for n in numbers])))


def _rounded(numbers: Sequence[Any], sizes: Sequence[Any]) -> Form:
    both = integers([fraction(n) for n in (*numbers, *sizes)])
    return Form(_ten(both[:10]), _ten(both[10:]))


def _exact(surface: QuadricSurface) -> Form:
    rows = [vector(row) for row in surface.rows]
    squares, linear, anchor = vector(surface.squares), vector(surface.linear), vector(surface.anchor)
    shift = [-dot(row, anchor) for row in rows]
    second = [
        sum((squares[k] * rows[k][i] * rows[k][j] for k in range(3)), Fraction(0))
        for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
    ]
    first = [sum(((squares[k] * shift[k] + linear[k]) * rows[k][i] for k in range(3)), Fraction(0)) for i in range(3)]
    one = sum(((squares[k] * shift[k] + 2 * linear[k]) * shift[k] for k in range(3)), -fraction(surface.constant))
    return Form(_ten(integers([*second, *first, one])))


def _ten(values: Sequence[int]) -> Numbers:
    a, b, c, d, e, f, x, y, z, w = values
    return a, b, c, d, e, f, x, y, z, w
