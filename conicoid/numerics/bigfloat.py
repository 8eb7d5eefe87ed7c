"""`BigFloat`: numbers of 3000 bits with an error bound, and their linear algebra, for motions and surfaces.

A `BigFloat` is mantissa · 2^exponent, and the true number lies within off · 2^exponent of it. Floats, their sums and
their products are exact (off = 0) and as long as necessary. Quotients, square roots and sines are cut to 3000 bits,
and every operation adds up its possible error. So comparisons are proved: a number is positive if its whole interval
is. (Intervals of midpoint and radius: Johansson, Arb: efficient arbitrary-precision midpoint-radius interval
arithmetic, IEEE Transactions on Computers 66, 2017.)

One rule, `settled`, decides open cases: an interval that holds zero, or a binary number of at most 512 bits although
its own first thousand are known, is that number. By chance that happens once in 2^500 times; for numbers that are
equal on paper it always does.
"""

from __future__ import annotations

import functools
import math
import operator
import sys
from collections.abc import Iterable, Sequence
from fractions import Fraction
from functools import lru_cache
from typing import Any, TypeAlias

BITS = 3000
"""Bits of irrational numbers."""
_LONGEST = 16384
"""Exact numbers of more bits are cut as well."""
_SHORT, _INTERVAL_BITS = 512, 1024  # `settled`: bits of a short number, and bits that must be known of the interval
_RADIUS = 32
"""Bits of an error."""


Writable: TypeAlias = "float | int | Fraction | BigFloat"
"""A value that `exact` converts."""


class Symbol:
    """A float or a `BigFloat` of a recorded formula; `tracing` has the methods."""

    __slots__ = ()

    def exact(self) -> BigFloat:
        """Return the same number as a `BigFloat`."""
        raise NotImplementedError

    def rounded(self) -> Any:
        """Return the nearest float64."""
        raise NotImplementedError

    def root(self) -> Any:
        """Return the square root."""
        raise NotImplementedError

    def ball(self, radius: BigFloat) -> BigFloat:
        """Return a number within a radius of this one."""
        raise NotImplementedError

    def sine_cosine(self) -> tuple[BigFloat, BigFloat]:
        """Return sine and cosine of an angle in degrees."""
        raise NotImplementedError

    def larger(self, other: Any, first: bool = True) -> Any:
        """Return `max(self, other)`, or `max(other, self)` if not `first`."""
        raise NotImplementedError

    def constant(self) -> Any:
        """Return the same number without derivatives."""
        return self


class BigFloat:
    """mantissa · 2^exponent ± off · 2^exponent, immutable. It is true if it is certainly not zero."""

    __slots__ = ("exponent", "mantissa", "off")

    mantissa: int
    exponent: int
    off: int

    def __init__(self, mantissa: int, exponent: int, off: int = 0) -> None:
        if off:
            # Cut bits below the error. The shifts round down, so 2 is added to the error: one for each of its parts.
            more = max(off.bit_length() - _RADIUS, mantissa.bit_length() - BITS)
            if more > 0:
                mantissa, off, exponent = mantissa >> more, (off >> more) + 2, exponent + more
        elif mantissa:
            # An exact number has an odd mantissa, so that equal numbers have equal fields.
            zeros = (mantissa & -mantissa).bit_length() - 1
            if zeros:
                mantissa, exponent = mantissa >> zeros, exponent + zeros
            longer = mantissa.bit_length() - _LONGEST
            if longer > 0:
                more = longer + _LONGEST - BITS
                mantissa, off, exponent = mantissa >> more, 1, exponent + more
        else:
            exponent = 0
        self.mantissa, self.exponent, self.off = mantissa, exponent, off

    # Arithmetic

    def __add__(self, other: Writable) -> BigFloat:
        if not isinstance(other, BigFloat):
            other = exact(other)
        if not other.mantissa and not other.off:
            return self
        if not self.mantissa and not self.off:
            return other
        # Align both mantissas to the lower exponent: sums are exact.
        least = self.exponent if self.exponent < other.exponent else other.exponent
        mine, its = self.exponent - least, other.exponent - least
        return BigFloat(
            (self.mantissa << mine) + (other.mantissa << its), least, (self.off << mine) + (other.off << its)
        )

    __radd__ = __add__

    def __neg__(self) -> BigFloat:
        return BigFloat(-self.mantissa, self.exponent, self.off)

    def __pos__(self) -> BigFloat:
        return self

    def __abs__(self) -> BigFloat:
        return -self if self.mantissa < 0 else self

    def __sub__(self, other: Writable) -> BigFloat:
        return self + -other

    def __rsub__(self, other: Writable) -> BigFloat:
        return -self + other

    def __mul__(self, other: Writable) -> BigFloat:
        if not isinstance(other, BigFloat):
            other = exact(other)
        off = 0
        if self.off or other.off:
            # |ab - a'b'| <= |a| db + (|b| + db) da, in integers without rounding
            off = abs(self.mantissa) * other.off + (abs(other.mantissa) + other.off) * self.off
        return BigFloat(self.mantissa * other.mantissa, self.exponent + other.exponent, off)

    __rmul__ = __mul__

    def __truediv__(self, other: Writable) -> BigFloat:
        """Return the quotient. Raise ZeroDivisionError if the divisor may be zero."""
        if not isinstance(other, BigFloat):
            other = exact(other)
        if not other:
            raise ZeroDivisionError("division by a number that may be zero")
        if not self.mantissa and not self.off:
            return self
        # 64 guard bits beyond the 3000.
        shift = max(0, BITS + 64 + other.mantissa.bit_length() - self.mantissa.bit_length())
        divisor = abs(other.mantissa)
        high = (self.mantissa if other.mantissa > 0 else -self.mantissa) << shift
        quotient, rest = divmod(high, divisor)
        off = 0
        if rest or self.off or other.off:
            # The least divisor makes the bound largest; 2 for the cut quotient and the cut bound
            off = ((self.off << shift) + (abs(quotient) + 1) * other.off) // (divisor - other.off) + 2
        return BigFloat(quotient, self.exponent - other.exponent - shift, off)

    def __rtruediv__(self, other: Writable) -> BigFloat:
        return exact(other) / self

    # Order: by the midpoints of intervals that do not overlap; overlapping ones are equal in order

    def __bool__(self) -> bool:
        return abs(self.mantissa) > self.off

    def _sign_beside(self, other: Writable) -> int:
        """Return the sign of the difference, 0 if it may be zero."""
        # Not settled: an order is proved by intervals, never by likelihood
        difference = self - other
        return 0 if not difference else 1 if difference.mantissa > 0 else -1

    def __lt__(self, other: Writable) -> bool:
        return self._sign_beside(other) < 0

    def __le__(self, other: Writable) -> bool:
        return self._sign_beside(other) <= 0

    def __gt__(self, other: Writable) -> bool:
        return self._sign_beside(other) > 0

    def __ge__(self, other: Writable) -> bool:
        return self._sign_beside(other) >= 0

    # Identity: the same interval, for dictionaries

    def __eq__(self, other: object) -> bool:
        if isinstance(other, BigFloat):
            return (self.mantissa, self.exponent, self.off) == (other.mantissa, other.exponent, other.off)
        if isinstance(other, (int, float, Fraction)):
            return not self.off and fraction(self) == other
        return NotImplemented

    def __hash__(self) -> int:
        """Return the hash of the equal int, float or Fraction, if any (Python's "Hashing of numeric types")."""
        # Equal numbers of different types must have one hash, as in Python's own types
        modulus = sys.hash_info.modulus
        remainder = abs(self.mantissa) * pow(2, self.exponent, modulus) % modulus
        return -remainder if self.mantissa < 0 else remainder

    def __float__(self) -> float:
        """Return the float64 nearest to the midpoint."""
        try:
            if self.exponent >= 0:
                return float(self.mantissa << self.exponent)
            return self.mantissa / (1 << -self.exponent)
        except OverflowError:
            return math.inf if self.mantissa > 0 else -math.inf

    def __repr__(self) -> str:
        return f"BigFloat({float(self)!r}{' ±' if self.off else ''})"


ZERO, ONE = BigFloat(0, 0), BigFloat(1, 0)


def exact(value: Writable) -> BigFloat:
    """Return a value as a `BigFloat`: floats and integers exactly; fractions that are not binary, cut to 3000 bits."""
    if isinstance(value, BigFloat):
        return value
    if isinstance(value, Symbol):
        return value.exact()
    if type(value) is not float:
        if isinstance(value, Fraction):
            return _ratio(value.numerator, value.denominator)
        if isinstance(value, int):
            return BigFloat(value, 0)
    if value == 0:
        return ZERO
    mantissa, unit = float(value).as_integer_ratio()
    return BigFloat(mantissa, 1 - unit.bit_length())


def _ratio(numerator: int, denominator: int) -> BigFloat:
    """Return a quotient of integers: exact for powers of two, else cut to 3000 bits."""
    if denominator & (denominator - 1):
        return BigFloat(numerator, 0) / BigFloat(denominator, 0)
    return BigFloat(numerator, 1 - denominator.bit_length())


def fraction(value: Writable) -> Fraction:
    """Return the midpoint as a fraction."""
    if not isinstance(value, BigFloat):
        return Fraction(value)
    if value.exponent >= 0:
        return Fraction(value.mantissa << value.exponent)
    return Fraction(value.mantissa, 1 << -value.exponent)


def rational(value: Any) -> Any:
    """Return a float as a fraction, for division without rounding; a recorded number as its `BigFloat`."""
    if isinstance(value, Symbol):
        return value.exact()
    return value if isinstance(value, Fraction) else Fraction(value)


def rounded(value: Any) -> float:
    """Return the nearest float64."""
    return value.rounded() if isinstance(value, Symbol) else float(value)


def is_rounded(value: Any) -> bool:
    """Return whether a number was cut."""
    return isinstance(value, BigFloat) and value.off != 0


def is_nothing(value: BigFloat) -> bool:
    """Return whether a number is zero for certain: as a term it can be left out."""
    return type(value) is BigFloat and not value.mantissa and not value.off


def total(terms: Iterable[BigFloat]) -> BigFloat:
    """Return the sum, not settled."""
    terms = list(terms)
    # Recorded terms must be added one by one; plain ones need only one alignment.
    if any(type(term) is not BigFloat for term in terms):
        return functools.reduce(operator.add, terms)
    least = min((term.exponent for term in terms), default=0)
    mantissa = off = 0
    for term in terms:
        mantissa += term.mantissa << (term.exponent - least)
        off += term.off << (term.exponent - least)
    return BigFloat(mantissa, least, off)


def settled(value: BigFloat) -> BigFloat:
    """Return zero, or a short binary number, if the interval holds one (see the top of the file)."""
    if type(value) is not BigFloat:
        return value.settled()  # type: ignore[attr-defined]
    if not value.off:
        return value
    size = abs(value.mantissa)
    if size <= value.off:
        return ZERO
    length = size.bit_length()
    # Fewer known bits could agree with a short number by chance
    if length - value.off.bit_length() < _INTERVAL_BITS:
        return value
    more = length - _SHORT
    # The nearest number of `_SHORT` bits: half a unit is added before the cut
    short = ((size >> (more - 1)) + 1) >> 1
    if abs((short << more) - size) > value.off:
        return value
    return BigFloat(short if value.mantissa > 0 else -short, value.exponent + more)


def cut(value: BigFloat, bits: int) -> BigFloat:
    """Return the midpoint rounded to `bits` bits, as an exact number."""
    size = abs(value.mantissa)
    less = size.bit_length() - bits
    if less <= 0:
        return BigFloat(value.mantissa, value.exponent)
    size = ((size >> (less - 1)) + 1) >> 1
    return BigFloat(size if value.mantissa > 0 else -size, value.exponent + less)


def ball(middle: BigFloat, radius: BigFloat) -> BigFloat:
    """Return a number that lies within a radius, of either sign, of a middle."""
    if isinstance(middle, Symbol):
        return middle.ball(radius)
    least = min(middle.exponent, radius.exponent)
    reach = (abs(radius.mantissa) + radius.off) << (radius.exponent - least)
    return BigFloat(
        middle.mantissa << (middle.exponent - least), least, (middle.off << (middle.exponent - least)) + reach
    )


def power_of_two(exponent: int) -> BigFloat:
    """Return 2^exponent."""
    return BigFloat(1, exponent)


def sqrt(value: Writable) -> BigFloat:
    """Return the square root. Raise ValueError for a number that is certainly negative."""
    value = exact(value)
    if type(value) is not BigFloat:
        return value.root()  # type: ignore[attr-defined]
    size = value.mantissa
    if not size and not value.off:
        return ZERO
    if size <= value.off:
        if size < -value.off:
            raise ValueError("square root of a negative number")
        # An interval that holds zero: the root lies between 0 and that of its upper end.
        return BigFloat(0, (value.exponent - 1) // 2, math.isqrt(4 * (max(size, 0) + value.off)) + 1)
    # The root has half as many bits as its square
    shift = max(0, 2 * (BITS + 64) - size.bit_length())
    # The exponent must be even to be halved.
    shift += (value.exponent - shift) & 1
    root = math.isqrt(size << shift)
    off = 0
    if value.off or root * root != size << shift:
        # |√x - √y| <= |x - y| / √x
        off = (value.off << shift) // root + 2
    return BigFloat(root, (value.exponent - shift) // 2, off)


def simplest_ratio(value: BigFloat, most: int) -> Fraction | None:
    """Return the fraction in an interval whose parts, but for a power of two, have at most `most` bits, or None.

    The continued fraction of the midpoint gives it: a fraction nearer to it than 1 / 2q² is one of its convergents
    (Legendre), and the next quotient is huge. The interval must be known to more than 2 `most` bits, or a fraction in
    it would prove nothing.
    """
    size = abs(value.mantissa)
    if size.bit_length() - value.off.bit_length() < 2 * most + 128:
        return None
    length = size.bit_length()
    more = max(0, length - 2 * most - 64)
    above, below = size >> more, 1 << (length - more)
    p, before_p, q, before_q = 1, 0, 0, 1
    while below:
        whole, rest = divmod(above, below)
        # The huge quotient: the convergent before it is the fraction.
        if whole >> 48 and q:
            break
        p, before_p, q, before_q = whole * p + before_p, p, whole * q + before_q, q
        if p.bit_length() > most or q.bit_length() > most:
            return None
        above, below = below, rest
    if abs(size * q - (p << length)) > value.off * q:  # |size / 2^length - p / q| <= off / 2^length
        return None
    return Fraction(p if value.mantissa > 0 else -p, q) * Fraction(2) ** (value.exponent + length)


# Sines and cosines of degrees to any number of bits, in integers; rational ones are exact.

_GUARD_BITS = 64
"""Bits beyond the result's: far more than the rounding errors take."""
_SERIES_STRIDE = 4
"""Terms of a series that share one power of an angle's square."""


def sin_cos_degrees(degrees: float) -> tuple[BigFloat, BigFloat]:
    """Return sine and cosine of an angle in degrees; for rational ones only multiples of 30 are rational (Niven)."""
    if isinstance(degrees, Symbol):
        return degrees.sine_cosine()
    return _sin_cos_degrees(degrees)


@lru_cache(maxsize=1024)
def _sin_cos_degrees(degrees: float) -> tuple[BigFloat, BigFloat]:
    """Return `sin_cos_degrees` of a float."""
    # A float is a binary fraction, so that the angle is reduced exactly
    angle = Fraction(degrees) % 360
    quarter, rest = divmod(angle, 90)
    # sin 30 and cos 60 are the only rational values besides 0 and 1
    half = BigFloat(1, -1)
    if rest == 0:
        s, c = ZERO, ONE
    elif rest <= 45:
        s, c = _up_to_45_degrees(rest)
    else:
        c, s = _up_to_45_degrees(90 - rest)
    s, c = (half if rest == 30 else s), (half if rest == 60 else c)
    for _ in range(int(quarter)):
        s, c = c, -s
    return s, c


def _up_to_45_degrees(angle: Fraction) -> tuple[BigFloat, BigFloat]:
    """Return sine and cosine, each to 3000 bits of its own, however small."""
    small = max(0, angle.denominator.bit_length() - angle.numerator.bit_length() + 6)  # angle > 2^-small in radians
    places = BITS + _GUARD_BITS + 2 * small
    results = []
    for value in sin_cos_fixed_point(angle, places):
        more = value.bit_length() - BITS - 32
        results.append(settled(BigFloat(round_shift(value, more), more - places, 2)))
    return results[0], results[1]


def round_shift(value: int, less: int) -> int:
    """Return value / 2^less, rounded."""
    return ((value >> (less - 1)) + 1) >> 1


def sin_cos_fixed_point(angle: Fraction, places: int) -> tuple[int, int]:
    """Return sine and cosine, times 2^places, of an angle up to 45 degrees.

    The cosine is off by a few units at most. So is the square of the sine, which for small angles needs more places.

    The series gives 1 - cos of the angle / 2^halved. That is then doubled as often, by
    1 - cos 2t = 4 (1 - cos t) - 2 (1 - cos t)²: nothing cancels.
    """
    halved = math.isqrt(places) // 4
    p = places + 2 * halved + 16  # each time an error grows to four times itself
    x = pi_fixed_point(p) * angle.numerator // (180 * angle.denominator) >> halved
    versine = _versine_fixed_point(x * x >> p, p)
    for _ in range(halved):
        versine = (versine << 2) - (versine * versine >> (p - 1))
    less = p - places
    return round_shift(math.isqrt(versine * ((2 << p) - versine)), less), round_shift((1 << p) - versine, less)


def _versine_fixed_point(square: int, p: int) -> int:
    """Return 1 - cos of an angle with this square, all times 2^p: square / 2! - square² / 4! + ...

    Terms that are _SERIES_STRIDE apart are summed first, without the power of the square that they lack: most products
    are with small numbers alone (Smith: Efficient multiple-precision evaluation of elementary functions, Mathematics of
    Computation 52, 1989).
    """
    powers = [1 << p, square]
    for _ in range(_SERIES_STRIDE - 1):
        powers.append(powers[-1] * square >> p)
    sums = [0] * _SERIES_STRIDE
    term, k = 1 << p, 0
    while term:
        for place in range(_SERIES_STRIDE):
            k += 2
            term //= k * (k - 1)
            sums[place] += -term if k & 2 == 0 else term
        term = term * powers[_SERIES_STRIDE] >> p
    return sum(power * total for power, total in zip(powers[1:], sums, strict=True)) >> p


@lru_cache(maxsize=4)
def pi_fixed_point(places: int) -> int:
    """Return pi times 2^places, off by a unit at most: by the series of D. and G. Chudnovsky (1988), 47 bits a term."""
    p = places + 32
    term = total = 13591409 << p
    factor, k = 1 << p, 0
    while term:
        k += 1
        factor = -factor * (6 * k - 5) * (2 * k - 1) * (6 * k - 1) // (k**3 * (640320**3 // 24))
        term = factor * (13591409 + 545140134 * k)
        total += term
    return round_shift((426880 * math.isqrt(10005 << 2 * p) << p) // total, 32)


# Linear algebra: rows of three numbers and matrices of three rows; results are rounded to float64 once, at the end
#
# Sums are settled: terms that cancel to a possible zero are zero, and a result that may be a short binary number is
# that number. So two chains of motions that are equal on paper give equal numbers, a rotation times its transpose is
# the identity, and a turn by 90 degrees gives exact zeros and ones.
#
# Between 1e-100 and 1e100 lie 665 binary places: sums of squares of such numbers, and sums of products of four, need
# more than 1330 and 2660 bits for their possible remainder.

Row: TypeAlias = tuple[BigFloat, BigFloat, BigFloat]
Rows: TypeAlias = tuple[Row, Row, Row]

CANCELLED = 2200
"""Components of eigenvectors below 2^-2200 of their length are noise."""

IDENTITY: Rows = ((ONE, ZERO, ZERO), (ZERO, ONE, ZERO), (ZERO, ZERO, ONE))


def rounded_row(row: Row) -> tuple[float, float, float]:
    """Return the floats nearest to three numbers."""
    return rounded(row[0]), rounded(row[1]), rounded(row[2])


def exact_row(values: Iterable[Writable]) -> Row:
    """Return three numbers as a row."""
    x, y, z = values
    return exact(x), exact(y), exact(z)


def dot(a: Sequence[BigFloat], b: Sequence[BigFloat], *more: BigFloat) -> BigFloat:
    """Return a·b plus any further terms, settled."""
    # Zeros are frequent, and their products would only cost time.
    terms = [x * y for x, y in zip(a, b, strict=True) if not (is_nothing(x) or is_nothing(y))]
    terms.extend(more)
    return settled(total(terms))


def cancelling_sum(terms: Sequence[BigFloat]) -> BigFloat:
    """Return the sum, settled."""
    return settled(total(terms))


def plus(a: Row, b: Row) -> Row:
    """Return a + b, settled."""
    return cancelling_sum((a[0], b[0])), cancelling_sum((a[1], b[1])), cancelling_sum((a[2], b[2]))


def minus(a: Row, b: Row) -> Row:
    """Return a - b, settled."""
    return cancelling_sum((a[0], -b[0])), cancelling_sum((a[1], -b[1])), cancelling_sum((a[2], -b[2]))


def cross(a: Row, b: Row) -> Row:
    """Return the cross product, settled."""
    return (
        dot((a[1], -a[2]), (b[2], b[1])),
        dot((a[2], -a[0]), (b[0], b[2])),
        dot((a[0], -a[1]), (b[1], b[0])),
    )


def unit(a: Row) -> Row:
    """Return a row at unit length."""
    length = sqrt(dot(a, a))
    return a[0] / length, a[1] / length, a[2] / length


def apply(rows: Rows, point: Row) -> Row:
    """Return the product of a matrix and a point."""
    return dot(rows[0], point), dot(rows[1], point), dot(rows[2], point)


def transpose(rows: Rows) -> Rows:
    """Return the transpose."""
    return (
        (rows[0][0], rows[1][0], rows[2][0]),
        (rows[0][1], rows[1][1], rows[2][1]),
        (rows[0][2], rows[1][2], rows[2][2]),
    )


def multiply(a: Rows, b: Rows) -> Rows:
    """Return the product of two matrices."""
    columns = transpose(b)
    # Row i of the product is row i of a times b: each column of b is one dot product.
    return apply(columns, a[0]), apply(columns, a[1]), apply(columns, a[2])


def determinant(rows: Rows) -> BigFloat:
    """Return the determinant."""
    return dot(rows[0], cross(rows[1], rows[2]))


def inverse(rows: Rows) -> Rows:
    """Return the inverse by cofactors; the caller ensures that it exists."""
    d = determinant(rows)
    cofactors = (cross(rows[1], rows[2]), cross(rows[2], rows[0]), cross(rows[0], rows[1]))
    x, y, z = transpose(cofactors)
    return (
        (x[0] / d, x[1] / d, x[2] / d),
        (y[0] / d, y[1] / d, y[2] / d),
        (z[0] / d, z[1] / d, z[2] / d),
    )
