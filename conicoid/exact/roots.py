"""Roots of quadratics with integer coefficients, compared without rounding.

Two roots are equal only if their quadratics share one, which their resultant tells; roots that are not equal part
at some precision, so a comparison always ends. (Basu, Pollack, Roy: Algorithms in Real Algebraic Geometry, 2006.)

What is irrational on paper comes with 400 bits. There a difference below 2^-300 is taken for none, as it is
wherever such numbers are compared (shapes/exact.py).
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from math import isqrt


def sign(x: int | Fraction) -> int:
    return (x > 0) - (x < 0)


CANCELLED = 300


def quiet(value: int, size: int) -> int:
    """A sum, zero where its terms, which add up to `size` without their signs, cancel to the last of 400 bits."""
    return 0 if abs(value) << CANCELLED < size else value


@dataclass(frozen=True)
class Quadratic:
    """a t² + 2 b t + c; `rounded` if its coefficients are, to 400 bits."""

    a: int
    b: int
    c: int
    rounded: bool = False

    @property
    def discriminant(self) -> int:
        square, product = self.b * self.b, self.a * self.c
        return quiet(square - product, square + abs(product)) if self.rounded else square - product


@dataclass(frozen=True)
class Root:
    """The lower (side -1) or higher (+1) root of a quadratic with a > 0 and two roots, or a line's (a = 0, b > 0)."""

    of: Quadratic
    side: int

    def between(self, bits: int) -> tuple[int, int, int]:
        """(low, high, d): it lies in [low / d, high / d], narrow by so many bits."""
        q = self.of
        if q.a == 0:
            return -q.c, -q.c, 2 * q.b
        root = isqrt(q.discriminant << (2 * bits))
        ends = (root, root + 1) if self.side > 0 else (-root - 1, -root)
        return ends[0] - (q.b << bits), ends[1] - (q.b << bits), q.a << bits

    def __float__(self) -> float:
        """The nearest float64."""
        bits = 64
        while True:
            low, high, d = self.between(bits)
            if float(Fraction(low, d)) == float(Fraction(high, d)) or bits > 1 << 16:
                return float(Fraction(low + high, 2 * d))
            bits *= 2


def number(x: Fraction) -> Root:
    """A rational number as the root of a line."""
    return Root(Quadratic(0, x.denominator, -2 * x.numerator), 0)


def roots(q: Quadratic) -> tuple[Root, Root] | tuple[Root] | tuple[()]:
    """The real roots, in order; none where the quadratic only touches zero, or is constant."""
    if q.a < 0 or (q.a == 0 and q.b < 0):
        q = Quadratic(-q.a, -q.b, -q.c, q.rounded)
    if q.a == 0:
        return (Root(q, 0),) if q.b else ()
    return (Root(q, -1), Root(q, 1)) if q.discriminant > 0 else ()


def equal(x: Root, y: Root) -> bool:
    p, q = x.of, y.of
    ab, ac, bc = p.a * q.b - q.a * p.b, p.a * q.c - q.a * p.c, p.b * q.c - q.b * p.c
    if ac * ac != 4 * ab * bc:
        return False
    if ab == 0 and ac == 0 and bc == 0:
        return x.side == y.side
    if ab == 0:
        return False
    # The one root that they share is rational
    common = Fraction(-ac, 2 * ab)
    return all(r.side == sign(r.of.a * common + r.of.b) for r in (x, y) if r.of.a)


def compare(x: Root, y: Root, size: Fraction) -> int:
    """-1, 0 or 1 as x lies before y, at y or after it; `size` is what their differences are small against."""
    bits, rounded = 64, x.of.rounded or y.of.rounded
    while True:
        (low, high, d), (least, most, e) = x.between(bits), y.between(bits)
        left, right = low * e, least * d
        ends, finish = high * e, most * d
        largest = max(abs(left), abs(right), int(size * d * e))
        order = -1 if ends < right else 1 if left > finish else 0
        gap = right - ends if order < 0 else left - finish
        if order and (not rounded or gap << CANCELLED >= largest):
            return order
        if rounded and (max(ends, finish) - min(left, right)) << CANCELLED <= largest:
            return 0
        if (bits == 64 and equal(x, y)) or (rounded and bits > 1 << 12):
            return 0
        bits *= 2
