"""Rational numbers, without rounding: vectors, linear algebra, and roots of quadratics with integer coefficients."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import field
from fractions import Fraction
from functools import cached_property
from math import gcd, inf, isqrt, nextafter
from typing import Any, TypeAlias

from .._util.records import dataclass

FractionRow: TypeAlias = Sequence[Fraction]
FractionMatrix: TypeAlias = Sequence[FractionRow]


def dot(a: FractionRow, b: FractionRow) -> Fraction:
    """Return the dot product."""
    return sum((x * y for x, y in zip(a, b, strict=True)), Fraction(0))


def dot3(a: Sequence[Any], b: Sequence[Any]) -> Any:
    """Return the dot product of three numbers, which keep their type."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Sequence[Any], b: Sequence[Any]) -> tuple[Any, Any, Any]:
    """Return the cross product of three numbers, which keep their type."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def minus(a: Sequence[Any], b: Sequence[Any]) -> tuple[Any, Any, Any]:
    """Return the difference of three numbers, which keep their type."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def matmul(a: FractionMatrix, b: FractionMatrix) -> list[list[Fraction]]:
    """Return the product of two matrices."""
    columns = list(zip(*b, strict=True))
    return [[dot(row, column) for column in columns] for row in a]


def row_echelon(matrix: FractionMatrix, columns: int) -> tuple[list[list[Fraction]], list[int]]:
    """Return (the reduced row echelon form over the first `columns` columns, the pivots' columns)."""
    rows, pivots = [list(row) for row in matrix], list[int]()
    for column in range(columns):
        rank = len(pivots)
        # Any pivot but 0 serves: fractions do not round
        pivot = next((i for i in range(rank, len(rows)) if rows[i][column]), None)
        if pivot is None:
            continue
        rows[rank], rows[pivot] = rows[pivot], rows[rank]
        rows[rank] = [x / rows[rank][column] for x in rows[rank]]
        for i in range(len(rows)):
            if i != rank and rows[i][column]:
                factor = rows[i][column]
                rows[i] = [x - factor * y for x, y in zip(rows[i], rows[rank], strict=True)]
        pivots.append(column)
    return rows, pivots


def solve(matrix: FractionMatrix, right: FractionRow) -> list[Fraction]:
    """Return x with matrix x = right. Raise ZeroDivisionError for a singular matrix."""
    size = len(matrix)
    rows, pivots = row_echelon([[*row, value] for row, value in zip(matrix, right, strict=True)], size)
    if len(pivots) < size:
        raise ZeroDivisionError("the matrix is singular")
    return [row[size] for row in rows]


def null_space(matrix: FractionMatrix) -> list[list[Fraction]]:
    """Return a basis of all x with matrix x = 0."""
    size = len(matrix[0])
    rows, pivots = row_echelon(matrix, size)
    # One vector for each free column: 1 there, and the pivots solve for the rest.
    basis = []
    for free in sorted(set(range(size)) - set(pivots)):
        vector = [Fraction(int(i == free)) for i in range(size)]
        for row, pivot in zip(rows, pivots, strict=False):
            vector[pivot] = -row[free]
        basis.append(vector)
    return basis


def characteristic_polynomial(matrix: FractionMatrix) -> list[Fraction]:
    """Return the coefficients of det(λ - matrix), that of the highest power (1) first (Faddeev and Le Verrier)."""
    size = len(matrix)
    result, power = [Fraction(1)], [[Fraction(0)] * size for _ in range(size)]
    for k in range(1, size + 1):
        power = matmul(matrix, power)
        for i in range(size):
            power[i][i] += result[-1]
        product = matmul(matrix, power)
        result.append(-sum((product[i][i] for i in range(size)), Fraction(0)) / k)
    return result


def inertia(matrix: FractionMatrix) -> tuple[int, int]:
    """Return the numbers of (positive, negative) eigenvalues of a symmetric matrix.

    No congruence changes them (Sylvester). All roots of the characteristic polynomial are real, so Descartes' rule of
    signs counts them exactly.
    """
    coefficients = characteristic_polynomial(matrix)
    # Trailing zeros are roots at 0, which count as neither.
    while not coefficients[-1]:
        coefficients.pop()
    signs = [value > 0 for value in coefficients if value]
    positive = sum(a != b for a, b in itertools.pairwise(signs))
    return positive, len(coefficients) - 1 - positive


def has_equal_eigenvalues(matrix: FractionMatrix) -> bool:
    """Return whether the discriminant of the characteristic polynomial of a 3 × 3 matrix is zero."""
    _, b, c, d = characteristic_polynomial(matrix)
    return b * b * c * c - 4 * c**3 - 4 * b**3 * d - 27 * d * d + 18 * b * c * d == 0


# Roots of quadratics with integer coefficients, compared without rounding
#
# A rational root (the discriminant is a square) is named by its reduced fraction. Any other root is named by its
# quadratic in lowest terms, which is irreducible and so the only one with this root. Equal roots have one name. Unequal
# roots differ at some precision, so a comparison always ends.
#
# Irrational coefficients are known to thousands of bits (bigfloat.py), with an error bound. Then numbers that may be
# zero are zero, and roots that may be equal are equal.

_FIRST_BITS = 64
"""Bits of the first comparison."""


def sign(x: int | Fraction) -> int:
    """Return -1, 0 or 1."""
    return (x > 0) - (x < 0)


def is_certain(value: int, off: int) -> bool:
    """Return whether a number with the error bound `off` is certainly not zero, and known to 64 bits.

    Between such numbers and zero lies a gap that no number of the domain falls into. So every number that is not taken
    for zero is nearly exact, and so are its roots.
    """
    return abs(value) > off << 64


@dataclass(frozen=True)
class IntegerQuadratic:
    """a t² + 2 b t + c; each coefficient is 0 exactly, or has the error bound in `off` (see `is_certain`)."""

    a: int
    b: int
    c: int
    off: tuple[int, int, int] = (0, 0, 0)

    @cached_property
    def discriminant(self) -> int:
        """b² - a c; 0 if it may be zero."""
        a, b, c, (off_a, off_b, off_c) = abs(self.a), abs(self.b), abs(self.c), self.off
        value = self.b * self.b - self.a * self.c
        # The largest change of b² - a c within the errors of a, b and c
        off = (2 * b + off_b) * off_b + a * off_c + c * off_a + off_a * off_c
        return value if is_certain(value, off) else 0

    @property
    def rounded(self) -> bool:
        """Whether a coefficient has an error."""
        return any(self.off)

    def __neg__(self) -> IntegerQuadratic:
        return IntegerQuadratic(-self.a, -self.b, -self.c, self.off)


@dataclass(frozen=True)
class RootInterval:
    """[low / unit, high / unit]; all of its width but `resolution` / unit comes from the error of coefficients."""

    low: int
    high: int
    unit: int
    resolution: int

    @cached_property
    def ends(self) -> tuple[float, float]:
        """Floats below and above the interval."""
        try:
            return nextafter(self.low / self.unit, -inf), nextafter(self.high / self.unit, inf)
        except OverflowError:
            return -inf, inf


@dataclass(frozen=True)
class Root:
    """The lower (side -1) or higher (+1) root of a quadratic with a > 0 and two roots, or a line's (a = 0, b > 0)."""

    of: IntegerQuadratic
    side: int
    intervals: dict[int, RootInterval] = field(default_factory=dict, compare=False, repr=False)

    def interval(self, bits: int) -> RootInterval:
        """Return an interval that surely holds the root, of `bits` bits, or as narrow as the coefficients allow."""
        interval = self.intervals.get(bits)
        if interval is None:
            interval = self._of_midpoints(bits)
            if self.of.rounded:
                off = self._off(interval, bits)
                interval = RootInterval(interval.low - off, interval.high + off, interval.unit, interval.resolution + 1)
            self.intervals[bits] = interval
        return interval

    def _of_midpoints(self, bits: int) -> RootInterval:
        """Return the interval of the root for the coefficients without their errors."""
        q = self.of
        if q.a == 0:
            return RootInterval(-q.c << bits, -q.c << bits, 2 * q.b << bits, 0)
        root = isqrt(q.discriminant << (2 * bits))
        # isqrt rounds down, so that the true root lies within one unit above
        low, high = (root, root + 1) if self.side > 0 else (-root - 1, -root)
        return RootInterval(low - (q.b << bits), high - (q.b << bits), q.a << bits, 1)

    def _off(self, at: RootInterval, bits: int) -> int:
        """Return the number of units by which errors of coefficients may move the root: twice |f| / |f'|."""
        (off_a, off_b, off_c), b = self.of.off, self.of.b << bits
        # A hundred bits of t are enough
        less = max(at.unit.bit_length() - 100, 0)
        t, unit = (max(abs(at.low), abs(at.high)) >> less) + 1, at.unit >> less
        value = (off_a * t * t) // unit + 2 * off_b * t + off_c * (unit + 1)
        slope = b if self.of.a == 0 else max(abs(at.low + b), 1)
        return (value << (bits + less)) // slope + 1

    @cached_property
    def ends(self) -> tuple[float, float]:
        """Floats below and above the root."""
        if self.name is not None and len(self.name) == 2:
            nearest = float(self)
            return nextafter(nearest, -inf), nextafter(nearest, inf)
        return self.interval(_FIRST_BITS).ends

    @cached_property
    def name(self) -> tuple[int, ...] | None:
        """The same for equal roots of exact quadratics, and for no others; None for rounded coefficients."""
        q = self.of
        if q.rounded:
            return None
        above, below = -q.c, 2 * q.b
        if q.a:
            root = isqrt(q.discriminant)
            if root * root != q.discriminant:
                # Lowest terms, so that equal roots have equal names.
                common = gcd(q.a, 2 * q.b, q.c)
                return q.a // common, 2 * q.b // common, q.c // common, self.side
            above, below = self.side * root - q.b, q.a
        common = gcd(above, below)
        return above // common, below // common

    def __float__(self) -> float:
        """Return the nearest float64."""
        if self.name is not None and len(self.name) == 2:
            return _quotient(*self.name)
        bits = 64
        while True:
            at = self._of_midpoints(bits)
            # Both ends round to the same float: that is the nearest.
            low, high = _quotient(at.low, at.unit), _quotient(at.high, at.unit)
            if low == high or bits > 1 << 16:
                return low
            bits *= 2


def _quotient(above: int, below: int) -> float:
    """Return the float64 nearest to a quotient."""
    try:
        return above / below
    except OverflowError:
        return inf if above > 0 else -inf


def rational_root(x: Fraction) -> Root:
    """Return a rational number as the root of a line."""
    return Root(IntegerQuadratic(0, x.denominator, -2 * x.numerator), 0)


ZERO = rational_root(Fraction(0))
"""The root 0."""


def exact_real_roots(q: IntegerQuadratic) -> tuple[Root, Root] | tuple[Root] | tuple[()]:
    """Return the real roots, in order; none for a quadratic that only touches zero, or is constant."""
    # A positive leading coefficient, so that the sides of roots have their meaning.
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
    """Return -1, 0 or 1 as x lies before y, at y or after it."""
    if x is y or (x.name is not None and x.name == y.name):
        return 0
    (low, high), (least, most) = x.ends, y.ends
    if high < least or low > most:
        return -1 if high < least else 1
    # Exact roots without a common name differ, so more bits always separate them.
    bits, exact = _FIRST_BITS, x.name is not None and y.name is not None
    while True:
        p, q = x.interval(bits), y.interval(bits)
        if p.high * q.unit < q.low * p.unit:
            return -1
        if p.low * q.unit > q.high * p.unit:
            return 1
        # The errors of coefficients dominate the width: more bits would not separate the roots.
        width = (p.high - p.low) * q.unit + (q.high - q.low) * p.unit
        if not exact and 4 * (p.resolution * q.unit + q.resolution * p.unit) <= width:
            return 0
        bits *= 4
