"""Arrays of numbers in two floats with a bound on how wrong they are.

high + low differs from the number by at most `error`. The operations are those of double-word arithmetic (Joldes,
Muller, Popescu: Tight and rigorous error bounds for basic building blocks of double-word arithmetic, ACM TOMS 44,
2017; sums keep 2^-104 of the result, products 2^-103); what they add to the error is taken twice as large as
proven. Exact zeros have error 0, and products of numbers that are not zero never do, however small.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

Array = Any
_SPLIT = 2.0**27 + 1
_GROWN = 1 + 2.0**-40
"""For the roundings within the bounds themselves."""
_SUM, _PRODUCT, _QUOTIENT = 2.0**-103, 2.0**-102, 2.0**-98
_FLOOR = 1e-290
"""More than underflow can lose."""


@dataclass
class Wide:
    high: Array
    low: Array
    error: Array
    halves: tuple[Array, Array] | None = None

    def split(self) -> tuple[Array, Array]:
        """high in two parts of 26 bits (Veltkamp)."""
        if self.halves is None:
            c = _SPLIT * self.high
            top = c - (c - self.high)
            self.halves = top, self.high - top
        return self.halves

    def __add__(self, other: Wide) -> Wide:
        s, e = two_sum(self.high, other.high)
        t, f = two_sum(self.low, other.low)
        s, e = fast_two_sum(s, e + t)
        s, e = fast_two_sum(s, f + e)
        return Wide(s, e, (self.error + other.error + _SUM * abs(s)) * _GROWN)

    def __neg__(self) -> Wide:
        return Wide(-self.high, -self.low, self.error)

    def __sub__(self, other: Wide) -> Wide:
        return self + -other

    def __mul__(self, other: Wide) -> Wide:
        p, e = two_product(self, other)
        e = e + (self.high * other.low + self.low * other.high)
        h, e = fast_two_sum(p, e)
        mine, its = abs(self.high) + self.error, abs(other.high) + other.error
        error = mine * other.error + its * self.error + _PRODUCT * abs(h)
        return Wide(h, e, error * _GROWN + _FLOOR * ((mine > 0) & (its > 0)))

    def scaled(self, factor: Any) -> Wide:
        """Times a power of two."""
        return Wide(self.high * factor, self.low * factor, self.error * abs(factor))

    def __truediv__(self, other: Wide) -> Wide:
        q = self.high / other.high
        rest = self - other * exact(q)
        h, e = fast_two_sum(q, rest.high / other.high)
        below = abs(other.high) * (1 - 2.0**-50) - other.error
        error = (self.error + (abs(h) + self.error / below) * other.error) / below + _QUOTIENT * abs(h)
        return Wide(h, e, np.where(below > 0, error * _GROWN + _FLOOR * (h != 0), np.inf))

    def sqrt(self) -> Wide:
        """Of a number that is surely positive."""
        s = np.sqrt(self.high)
        p, e = two_product(exact(s), exact(s))
        h, low = fast_two_sum(s, (((self.high - p) - e) + self.low) / (2 * s))
        return Wide(h, low, (self.error / h + _QUOTIENT * h) * _GROWN + _FLOOR)

    @property
    def positive(self) -> Array:
        """Surely."""
        return self.high * (1 - 2.0**-50) > self.error

    @property
    def negative(self) -> Array:
        return self.high * (2.0**-50 - 1) > self.error

    @property
    def zero(self) -> Array:
        return (self.high == 0) & (self.error == 0)


def exact(values: Array) -> Wide:
    zeros = np.zeros(np.shape(values))
    return Wide(values, zeros, zeros)


def constant(high: float, low: float, error: float) -> Wide:
    return Wide(np.float64(high), np.float64(low), np.float64(error))


def two_sum(a: Array, b: Array) -> tuple[Array, Array]:
    s = a + b
    v = s - a
    return s, (a - (s - v)) + (b - v)


def fast_two_sum(a: Array, b: Array) -> tuple[Array, Array]:
    s = a + b
    return s, b - (s - a)


def two_product(a: Wide, b: Wide) -> tuple[Array, Array]:
    """high · high exactly, but for underflow (Dekker)"""
    (ah, al), (bh, bl) = a.split(), b.split()
    p = a.high * b.high
    return p, ((ah * bh - p) + ah * bl + al * bh) + al * bl


def dot(a: list[Wide], b: list[Wide]) -> Wide | None:
    """None where there is no term."""
    total: Wide | None = None
    for x, y in zip(a, b, strict=True):
        term = x * y
        total = term if total is None else total + term
    return total
