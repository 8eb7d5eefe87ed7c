"""Surfaces as polynomials with integer coefficients, and what is left of them on a ray or at a point."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from ..shapes import exact as ex
from ..shapes.rational import dot
from ..shapes.surface import PlaneSurface, QuadricSurface, Surface
from .roots import Quadratic, known

Numbers = tuple[int, int, int, int, int, int, int, int, int, int]

_RATIO = 1024
"""Bits of the fractions that are looked for in what was cut (`simplest_ratio`)."""


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

    Of what is irrational on paper each coefficient is known but for the one in `off`.
    """

    coefficients: Numbers
    off: Numbers | None = None

    @property
    def is_flat(self) -> bool:
        return not any(self.coefficients[:6])

    def along(self, line: Line) -> Quadratic:
        """On a ray, times a positive number; each coefficient is 0 unless it is surely not."""
        values = _along(self.coefficients, line)
        if self.off is None:
            return Quadratic(*values)
        off = _along(self.off, Line(_sizes(line.origin), _sizes(line.direction), line.unit))
        kept = [(v, o) if known(v, o) else (0, 0) for v, o in zip(values, off, strict=True)]
        (a, off_a), (b, off_b), (c, off_c) = kept
        return Quadratic(a, b, c, (off_a, off_b, off_c))

    def at(self, line: Line) -> int:
        """At the origin of a ray, times a positive number."""
        return self.along(line).c


def _sizes(values: Sequence[int]) -> tuple[int, ...]:
    return tuple(map(abs, values))


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


def form_of(surface: Surface) -> Form:
    """A surface as its record in the table of surfaces has it: a plane's normal leads with a positive number."""
    if isinstance(surface, PlaneSurface):
        turned = -1 if next(float(n) for n in surface.normal if float(n)) < 0 else 1
        numbers = [0] * 6 + [turned * n for n in surface.normal] + [-2 * turned * surface.offset]
        return _form(numbers)
    if any(map(ex.is_rounded, _written(surface))):
        return _form([ex.cancelling_sum(terms) for terms in surface.terms()])
    return _exact(surface)


def ball_form(center: Sequence[float], radius: float) -> Form:
    """A ball of floats."""
    x, y, z = map(Fraction, center)
    return _whole([1, 1, 1, 0, 0, 0, -x, -y, -z, x * x + y * y + z * z - Fraction(radius) ** 2])


def _written(surface: QuadricSurface) -> list[Any]:
    rows = [w for row in surface.rows for w in row]
    return [*surface.squares, *surface.linear, surface.constant, *surface.anchor, *rows]


def _whole(coefficients: Sequence[int | Fraction]) -> Form:
    return Form(_ten(integers([Fraction(c) for c in coefficients])))


def _form(coefficients: Sequence[Any]) -> Form:
    """From ten numbers: exact where they are fractions, or in the ratios of fractions, else with what was cut."""
    if not any(map(ex.is_rounded, coefficients)):
        return _whole([ex.fraction(c) for c in coefficients])
    numbers = [ex.exact(c) for c in coefficients]
    largest = max(numbers, key=abs)
    ratios = [Fraction(1) if n is largest else _ratio(n, largest) for n in numbers]
    if None not in ratios:
        sign = 1 if largest > 0 else -1
        return _whole([sign * ratio for ratio in ratios if ratio is not None])
    least = min(n.exponent for n in numbers)
    return Form(
        _ten([n.mantissa << (n.exponent - least) for n in numbers]),
        _ten([n.off << (n.exponent - least) for n in numbers]),
    )


def _ratio(number: ex.Exact, other: ex.Exact) -> Fraction | None:
    """number / other where that is a fraction; None where it is none, or a long one."""
    if not number.mantissa and not number.off:
        return Fraction(0)
    return ex.simplest_ratio(number / other, _RATIO)


def _exact(surface: QuadricSurface) -> Form:
    rows = [[ex.fraction(w) for w in row] for row in surface.rows]
    squares, linear = [ex.fraction(s) for s in surface.squares], [ex.fraction(b) for b in surface.linear]
    anchor = [ex.fraction(q) for q in surface.anchor]
    shift = [-dot(row, anchor) for row in rows]
    second = [
        sum((squares[k] * rows[k][i] * rows[k][j] for k in range(3)), Fraction(0))
        for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
    ]
    first = [sum(((squares[k] * shift[k] + linear[k]) * rows[k][i] for k in range(3)), Fraction(0)) for i in range(3)]
    one = sum(((squares[k] * shift[k] + 2 * linear[k]) * shift[k] for k in range(3)), -ex.fraction(surface.constant))
    return _whole([*second, *first, one])


def _ten(values: Sequence[int]) -> Numbers:
    a, b, c, d, e, f, x, y, z, w = values
    return a, b, c, d, e, f, x, y, z, w
