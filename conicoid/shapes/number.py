"""Numbers of 3000 bits that know how far off they may be: what motions and surfaces are composed in.

A `Number` is mantissa · 2^exponent, and the true one lies within off · 2^exponent of it. Floats, their sums and
their products are exact (off = 0) and as long as they need to be; quotients, square roots and sines are cut to
3000 bits, and every operation adds up what that may have cost. So what is known is proved: a number is positive if
its whole interval is. (The intervals are those of midpoint and radius: Johansson, Arb: efficient arbitrary-precision
midpoint-radius interval arithmetic, IEEE Transactions on Computers 66, 2017.)

What an interval leaves open is decided by one rule, `settled`: an interval that holds zero, or a binary number of at
most 512 bits although its own first thousand are known, is that number. By chance that happens once in 2^500
times; where numbers are equal on paper it always does.
"""

from __future__ import annotations

import functools
import math
import operator
import sys
from collections.abc import Iterable
from fractions import Fraction
from typing import Any, TypeAlias

BITS = 3000
"""Digits that irrational numbers are taken to."""
_LONGEST = 16384
"""Exact numbers beyond so many bits are cut as well."""
_SHORT, _KNOWN = 512, 1024
_RADIUS = 32
"""Bits that are kept of an error."""


Writable: TypeAlias = "float | int | Fraction | Number"


class Symbol:
    """A float in a formula that is being recorded, or a number of more digits: see `traced`, which has the methods."""

    __slots__ = ()

    def exact(self) -> Number:
        """The same as a number of many digits."""
        raise NotImplementedError

    def rounded(self) -> Any:
        """The nearest float64."""
        raise NotImplementedError

    def root(self) -> Any:
        """The square root."""
        raise NotImplementedError

    def sine_cosine(self) -> tuple[Number, Number]:
        """Of an angle in degrees."""
        raise NotImplementedError

    def larger(self, other: Any, first: bool = True) -> Any:
        """`max(self, other)`, or `max(other, self)`."""
        raise NotImplementedError


class Number:
    """mantissa · 2^exponent ± off · 2^exponent, immutable. Its truth is whether it is certainly not zero."""

    __slots__ = ("exponent", "mantissa", "off")

    mantissa: int
    exponent: int
    off: int

    def __init__(self, mantissa: int, exponent: int, off: int = 0) -> None:
        if off:
            more = max(off.bit_length() - _RADIUS, mantissa.bit_length() - BITS)
            if more > 0:
                mantissa, off, exponent = mantissa >> more, (off >> more) + 2, exponent + more
        elif mantissa:
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

    def __add__(self, other: Writable) -> Number:
        if not isinstance(other, Number):
            other = exact(other)
        if not other.mantissa and not other.off:
            return self
        if not self.mantissa and not self.off:
            return other
        least = self.exponent if self.exponent < other.exponent else other.exponent
        mine, its = self.exponent - least, other.exponent - least
        return Number((self.mantissa << mine) + (other.mantissa << its), least, (self.off << mine) + (other.off << its))

    __radd__ = __add__

    def __neg__(self) -> Number:
        return Number(-self.mantissa, self.exponent, self.off)

    def __pos__(self) -> Number:
        return self

    def __abs__(self) -> Number:
        return -self if self.mantissa < 0 else self

    def __sub__(self, other: Writable) -> Number:
        return self + -other

    def __rsub__(self, other: Writable) -> Number:
        return -self + other

    def __mul__(self, other: Writable) -> Number:
        if not isinstance(other, Number):
            other = exact(other)
        off = 0
        if self.off or other.off:
            off = abs(self.mantissa) * other.off + (abs(other.mantissa) + other.off) * self.off
        return Number(self.mantissa * other.mantissa, self.exponent + other.exponent, off)

    __rmul__ = __mul__

    def __truediv__(self, other: Writable) -> Number:
        """Raises ZeroDivisionError where the divisor may be zero."""
        if not isinstance(other, Number):
            other = exact(other)
        if not other:
            raise ZeroDivisionError("division by what may be zero")
        if not self.mantissa and not self.off:
            return self
        shift = max(0, BITS + 64 + other.mantissa.bit_length() - self.mantissa.bit_length())
        divisor = abs(other.mantissa)
        high = (self.mantissa if other.mantissa > 0 else -self.mantissa) << shift
        quotient, rest = divmod(high, divisor)
        off = 0
        if rest or self.off or other.off:
            off = ((self.off << shift) + (abs(quotient) + 1) * other.off) // (divisor - other.off) + 2
        return Number(quotient, self.exponent - other.exponent - shift, off)

    def __rtruediv__(self, other: Writable) -> Number:
        return exact(other) / self

    # Order, by the midpoints where intervals do not overlap; those that do are equal to it

    def __bool__(self) -> bool:
        return abs(self.mantissa) > self.off

    def _sign_beside(self, other: Writable) -> int:
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

    # Identity: the same interval, as dictionaries need it

    def __eq__(self, other: object) -> bool:
        if isinstance(other, Number):
            return (self.mantissa, self.exponent, self.off) == (other.mantissa, other.exponent, other.off)
        if isinstance(other, (int, float, Fraction)):
            return not self.off and fraction(self) == other
        return NotImplemented

    def __hash__(self) -> int:
        """That of the equal int, float or Fraction, where there is one (Python's "Hashing of numeric types")."""
        modulus = sys.hash_info.modulus
        remainder = abs(self.mantissa) * pow(2, self.exponent, modulus) % modulus
        return -remainder if self.mantissa < 0 else remainder

    def __float__(self) -> float:
        """The float64 nearest to the midpoint."""
        try:
            if self.exponent >= 0:
                return float(self.mantissa << self.exponent)
            return self.mantissa / (1 << -self.exponent)
        except OverflowError:
            return math.inf if self.mantissa > 0 else -math.inf

    def __repr__(self) -> str:
        return f"Number({float(self)!r}{' ±' if self.off else ''})"


ZERO, ONE = Number(0, 0), Number(1, 0)


def exact(value: Writable) -> Number:
    """Floats and integers as they are; fractions cut to 3000 bits if they are not binary."""
    if isinstance(value, Number):
        return value
    if isinstance(value, Symbol):
        return value.exact()
    if type(value) is not float:
        if isinstance(value, Fraction):
            return _ratio(value.numerator, value.denominator)
        if isinstance(value, int):
            return Number(value, 0)
    if value == 0:
        return ZERO
    mantissa, unit = float(value).as_integer_ratio()
    return Number(mantissa, 1 - unit.bit_length())


def _ratio(numerator: int, denominator: int) -> Number:
    if denominator & (denominator - 1):
        return Number(numerator, 0) / Number(denominator, 0)
    return Number(numerator, 1 - denominator.bit_length())


def fraction(value: Writable) -> Fraction:
    """The midpoint as a fraction."""
    if not isinstance(value, Number):
        return Fraction(value)
    if value.exponent >= 0:
        return Fraction(value.mantissa << value.exponent)
    return Fraction(value.mantissa, 1 << -value.exponent)


def rational(value: Any) -> Any:
    """A float as a fraction, to be divided without rounding; in a formula that is being recorded, as it is there."""
    if isinstance(value, Symbol):
        return value.exact()
    return value if isinstance(value, Fraction) else Fraction(value)


def rounded(value: Any) -> float:
    """The nearest float64."""
    return value.rounded() if isinstance(value, Symbol) else float(value)


def is_rounded(value: Any) -> bool:
    """Was something cut of it?"""
    return isinstance(value, Number) and value.off != 0


def is_nothing(value: Number) -> bool:
    """Is it zero, and known to be: as a term it can be left out."""
    return type(value) is Number and not value.mantissa and not value.off


def total(terms: Iterable[Number]) -> Number:
    """The sum, not settled."""
    terms = list(terms)
    if any(type(term) is not Number for term in terms):
        return functools.reduce(operator.add, terms)
    least = min((term.exponent for term in terms), default=0)
    mantissa = off = 0
    for term in terms:
        mantissa += term.mantissa << (term.exponent - least)
        off += term.off << (term.exponent - least)
    return Number(mantissa, least, off)


def settled(value: Number) -> Number:
    """Zero, or a short binary number, where the interval holds one (see the top of the file)."""
    if type(value) is not Number:
        return value.settled()  # type: ignore[attr-defined, no-any-return]
    if not value.off:
        return value
    size = abs(value.mantissa)
    if size <= value.off:
        return ZERO
    length = size.bit_length()
    if length - value.off.bit_length() < _KNOWN:
        return value
    more = length - _SHORT
    short = ((size >> (more - 1)) + 1) >> 1
    if abs((short << more) - size) > value.off:
        return value
    return Number(short if value.mantissa > 0 else -short, value.exponent + more)


def cut(value: Number, bits: int) -> Number:
    """The midpoint rounded to so many bits, as an exact number."""
    size = abs(value.mantissa)
    less = size.bit_length() - bits
    if less <= 0:
        return Number(value.mantissa, value.exponent)
    size = ((size >> (less - 1)) + 1) >> 1
    return Number(size if value.mantissa > 0 else -size, value.exponent + less)


def power_of_two(exponent: int) -> Number:
    return Number(1, exponent)


def sqrt(value: Writable) -> Number:
    """Raises ValueError where the number is certainly negative."""
    value = exact(value)
    if type(value) is not Number:
        return value.root()  # type: ignore[attr-defined, no-any-return]
    size = value.mantissa
    if not size and not value.off:
        return ZERO
    if size <= value.off:
        if size < -value.off:
            raise ValueError("square root of a negative number")
        return Number(0, (value.exponent - 1) // 2, math.isqrt(4 * (max(size, 0) + value.off)) + 1)
    shift = max(0, 2 * (BITS + 64) - size.bit_length())
    shift += (value.exponent - shift) & 1
    root = math.isqrt(size << shift)
    off = 0
    if value.off or root * root != size << shift:
        off = (value.off << shift) // root + 2
    return Number(root, (value.exponent - shift) // 2, off)


def simplest_ratio(value: Number, most: int) -> Fraction | None:
    """The fraction in an interval whose parts, but for a power of two, have at most `most` bits; None if there is none.

    By the continued fraction of the midpoint: a fraction nearer to it than 1 / 2q² is one of its convergents
    (Legendre), and the quotient that follows is huge. The interval must be known to more than 2 `most` bits, or
    its being there would say nothing.
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
        if whole >> 48 and q:
            break
        p, before_p, q, before_q = whole * p + before_p, p, whole * q + before_q, q
        if p.bit_length() > most or q.bit_length() > most:
            return None
        above, below = below, rest
    if abs(size * q - (p << length)) > value.off * q:  # |size / 2^length - p / q| <= off / 2^length
        return None
    return Fraction(p if value.mantissa > 0 else -p, q) * Fraction(2) ** (value.exponent + length)
