"""Roots of quadratics with integer coefficients, compared without rounding.

A root is rational where the discriminant is a square, and then its name is the reduced fraction; else it is the
quadratic in lowest terms, which is irreducible and so the only one that has the root. Equal roots have one name, and
roots that are not equal part at some precision, so a comparison always ends.

What is irrational on paper is known to thousands of bits (bigfloat_linalg.py), and its coefficients come with how far
they may be off. There what cannot be told from zero is zero, and roots that cannot be told apart are one.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from math import gcd, inf, isqrt, nextafter

_FIRST_BITS = 64
"""Bits of the first comparison."""


def sign(x: int | Fraction) -> int:
    return (x > 0) - (x < 0)


def is_certain(value: int, off: int) -> bool:
    """Is a number, which may be off by so much, surely not zero, and known to 64 bits?

    Between that and zero lies a gap that no number of the domain falls into. So whatever is not taken for zero is all
    but exact, and so are the roots that are told.
    """
    return abs(value) > off << 64


@dataclass(frozen=True)
class IntegerQuadratic:
    """a t² + 2 b t + c; each coefficient is 0 exactly, or off by at most the one in `off` (see `known`)."""

    a: int
    b: int
    c: int
    off: tuple[int, int, int] = (0, 0, 0)

    @cached_property
    def discriminant(self) -> int:
        """b² - a c; 0 where it cannot be told from that."""
        a, b, c, (off_a, off_b, off_c) = abs(self.a), abs(self.b), abs(self.c), self.off
        value = self.b * self.b - self.a * self.c
        off = (2 * b + off_b) * off_b + a * off_c + c * off_a + off_a * off_c
        return value if is_certain(value, off) else 0

    @property
    def rounded(self) -> bool:
        return any(self.off)

    def __neg__(self) -> IntegerQuadratic:
        return IntegerQuadratic(-self.a, -self.b, -self.c, self.off)


@dataclass(frozen=True)
class RootInterval:
    """[low / unit, high / unit]; all of it but `resolution` / unit is there for what coefficients are off by."""

    low: int
    high: int
    unit: int
    resolution: int

    @cached_property
    def ends(self) -> tuple[float, float]:
        """Floats below and above."""
        try:
            return nextafter(self.low / self.unit, -inf), nextafter(self.high / self.unit, inf)
        except OverflowError:
            return -inf, inf


@dataclass(frozen=True)
class Root:
    """The lower (side -1) or higher (+1) root of a quadratic with a > 0 and two roots, or a line's (a = 0, b > 0)."""

    of: IntegerQuadratic
    side: int
    known: dict[int, RootInterval] = field(default_factory=dict, compare=False, repr=False)

    def within(self, bits: int) -> RootInterval:
        """Where the root surely is; of so many bits, or as narrow as coefficients tell."""
        found = self.known.get(bits)
        if found is None:
            found = self._as_written(bits)
            if self.of.rounded:
                off = self._off(found, bits)
                found = RootInterval(found.low - off, found.high + off, found.unit, found.resolution + 1)
            self.known[bits] = found
        return found

    def _as_written(self, bits: int) -> RootInterval:
        """Of the coefficients as they are."""
        q = self.of
        if q.a == 0:
            return RootInterval(-q.c << bits, -q.c << bits, 2 * q.b << bits, 0)
        root = isqrt(q.discriminant << (2 * bits))
        low, high = (root, root + 1) if self.side > 0 else (-root - 1, -root)
        return RootInterval(low - (q.b << bits), high - (q.b << bits), q.a << bits, 1)

    def _off(self, at: RootInterval, bits: int) -> int:
        """By how many units what coefficients are off by may move the root: |f| / |f'|, twice."""
        (off_a, off_b, off_c), b = self.of.off, self.of.b << bits
        # A hundred bits of t are enough
        less = max(at.unit.bit_length() - 100, 0)
        t, unit = (max(abs(at.low), abs(at.high)) >> less) + 1, at.unit >> less
        value = (off_a * t * t) // unit + 2 * off_b * t + off_c * (unit + 1)
        slope = b if self.of.a == 0 else max(abs(at.low + b), 1)
        return (value << (bits + less)) // slope + 1

    @cached_property
    def ends(self) -> tuple[float, float]:
        """Floats below and above."""
        if self.name is not None and len(self.name) == 2:
            nearest = float(self)
            return nextafter(nearest, -inf), nextafter(nearest, inf)
        return self.within(_FIRST_BITS).ends

    @cached_property
    def name(self) -> tuple[int, ...] | None:
        """The same for equal roots of exact quadratics, and for no others; None where coefficients are rounded."""
        q = self.of
        if q.rounded:
            return None
        above, below = -q.c, 2 * q.b
        if q.a:
            root = isqrt(q.discriminant)
            if root * root != q.discriminant:
                common = gcd(q.a, 2 * q.b, q.c)
                return q.a // common, 2 * q.b // common, q.c // common, self.side
            above, below = self.side * root - q.b, q.a
        common = gcd(above, below)
        return above // common, below // common

    def __float__(self) -> float:
        """The nearest float64."""
        if self.name is not None and len(self.name) == 2:
            return _quotient(*self.name)
        bits = 64
        while True:
            at = self._as_written(bits)
            low, high = _quotient(at.low, at.unit), _quotient(at.high, at.unit)
            if low == high or bits > 1 << 16:
                return low
            bits *= 2


def _quotient(above: int, below: int) -> float:
    """The float64 nearest to a quotient."""
    try:
        return above / below
    except OverflowError:
        return inf if above > 0 else -inf


def rational_root(x: Fraction) -> Root:
    """A rational number as the root of a line."""
    return Root(IntegerQuadratic(0, x.denominator, -2 * x.numerator), 0)


ZERO = rational_root(Fraction(0))


def exact_real_roots(q: IntegerQuadratic) -> tuple[Root, Root] | tuple[Root] | tuple[()]:
    """The real roots, in order; none where the quadratic only touches zero, or is constant."""
    if q.a < 0 or (q.a == 0 and q.b < 0):
        q = -q
    if q.a == 0:
        return (Root(q, 0) if q.c else ZERO,) if q.b else ()
    if q.c == 0:
        # 0 and -2 b / a
        other = Root(IntegerQuadratic(0, q.a, 4 * q.b, (0, q.off[0], 4 * q.off[1])), 0)
        return () if q.b == 0 else (other, ZERO) if q.b > 0 else (ZERO, other)
    return (Root(q, -1), Root(q, 1)) if q.discriminant > 0 else ()


def compare_roots(x: Root, y: Root) -> int:
    """-1, 0 or 1 as x lies before y, at y or after it."""
    if x is y or (x.name is not None and x.name == y.name):
        return 0
    (low, high), (least, most) = x.ends, y.ends
    if high < least or low > most:
        return -1 if high < least else 1
    bits, exact = _FIRST_BITS, x.name is not None and y.name is not None
    while True:
        p, q = x.within(bits), y.within(bits)
        if p.high * q.unit < q.low * p.unit:
            return -1
        if p.low * q.unit > q.high * p.unit:
            return 1
        # More bits would not tell either
        width = (p.high - p.low) * q.unit + (q.high - q.low) * p.unit
        if not exact and 4 * (p.resolution * q.unit + q.resolution * p.unit) <= width:
            return 0
        bits *= 4
