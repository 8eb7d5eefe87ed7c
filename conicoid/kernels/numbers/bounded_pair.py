"""Pairs of floats with an error bound, for decisions that single floats leave open.

A number is (high, low, error): the exact value lies within `error` of high + low. Every operation adds to
the bound what it may lose, so a result is certain whatever cancels; sums, and products of single floats, that lose
nothing add nothing, so that an exact zero is recognised. Bounds of the operations: Joldes,
Muller, Popescu (see double_double.py); ours are a few times larger.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..._jit.decorators import fma, inline
from .double_double import quick_sum, two_sum


class BoundedPair(NamedTuple):
    """The exact value lies within `error` of high + low."""

    high: float
    low: float
    error: float


_LOST = 2.0**-98  # relative error of a product, quotient or root


@inline
def bounded_pair(x: float, rest: float = 0.0) -> BoundedPair:
    """Return a float, or a rounded number plus its rounding rest, which is rounded itself."""
    high, low = quick_sum(x, rest)
    return BoundedPair(high, low, 0.0 if rest == 0.0 else abs(rest) * 2.0**-52)


@inline
def remainder(rest: float) -> BoundedPair:
    """Return a rounding rest, which is rounded itself."""
    return BoundedPair(rest, 0.0, abs(rest) * 2.0**-52)


@inline
def product(x: float, y: float) -> BoundedPair:
    """Return x y exactly."""
    p = x * y
    return BoundedPair(p, fma(x, y, -p), 0.0)


@inline
def plus(a: BoundedPair, b: BoundedPair) -> BoundedPair:
    """Return a + b."""
    s, e = two_sum(a.high, b.high)
    t, f = two_sum(a.low, b.low)
    e, r = two_sum(e, t)
    s, e = quick_sum(s, e)
    e, q = two_sum(e, f)
    s, e = quick_sum(s, e)
    # r and q are exact rounding errors. They are dropped, and so they are the error of the sum
    return BoundedPair(s, e, a.error + b.error + (abs(r) + abs(q)))


@inline
def opposite(a: BoundedPair) -> BoundedPair:
    """Return -a exactly."""
    return BoundedPair(-a.high, -a.low, a.error)


@inline
def minus(a: BoundedPair, b: BoundedPair) -> BoundedPair:
    """Return a - b."""
    return plus(a, opposite(b))


@inline
def times(a: BoundedPair, b: BoundedPair) -> BoundedPair:
    """Return a b."""
    p = a.high * b.high
    e = fma(a.high, b.high, -p) + fma(a.high, b.low, a.low * b.high)
    high, low = quick_sum(p, e)
    # Without low parts p + e is the exact product
    lost = 0.0 if (a.low == 0.0) & (b.low == 0.0) else _LOST * abs(p)
    return BoundedPair(high, low, (abs(a.high) + a.error) * b.error * 1.0001 + abs(b.high) * a.error * 1.0001 + lost)


@inline
def times_float(a: BoundedPair, x: float) -> BoundedPair:
    """Return a x for a float x."""
    p, q = a.high * x, a.low * x
    e, r = two_sum(fma(a.high, x, -p), q)
    high, low = quick_sum(p, e)
    return BoundedPair(high, low, a.error * abs(x) + (abs(r) + abs(fma(a.low, x, -q))))


@inline
def over(a: BoundedPair, b: BoundedPair) -> BoundedPair:
    """Return a / b; the error is infinite where b may be zero."""
    # A lower bound of |b|: 0.9999 covers the low part, which is at most half a unit in the last place of the high one
    least = abs(b.high) * 0.9999 - b.error
    if not least > 0.0:
        return BoundedPair(0.0, 0.0, math.inf)
    first = a.high / b.high
    rest = minus(BoundedPair(a.high, a.low, 0.0), times_float(BoundedPair(b.high, b.low, 0.0), first))
    high, low = quick_sum(first, rest.high / b.high)
    return BoundedPair(high, low, (a.error + abs(high) * b.error) / least * 1.0001 + _LOST * abs(high))


@inline
def root(a: BoundedPair) -> BoundedPair:
    """Return the square root; relies on `a` being certainly positive."""
    first = math.sqrt(a.high)
    rest = minus(BoundedPair(a.high, a.low, 0.0), product(first, first))
    high, low = quick_sum(first, rest.high / (2.0 * first))
    # |√x - √y| <= |x - y| / √x, and the least x is above a.high * 0.9999 - a.error
    return BoundedPair(high, low, a.error / math.sqrt(a.high * 0.9999 - a.error) * 1.0001 + _LOST * high)


@inline
def sign(a: BoundedPair) -> int:
    """Return the sign -1, 0 or 1, or 2 (OPEN) where it is not certain."""
    if abs(a.high) * 0.9999 > a.error:
        return 1 if a.high > 0.0 else -1
    return 0 if (a.high == 0.0) & (a.low == 0.0) & (a.error == 0.0) else 2


@inline
def dot3(x: float, y: float, z: float, a: BoundedPair, b: BoundedPair, c: BoundedPair) -> BoundedPair:
    """Return x a + y b + z c."""
    return plus(plus(times_float(a, x), times_float(b, y)), times_float(c, z))


@inline
def inner(
    a: BoundedPair, b: BoundedPair, c: BoundedPair, x: BoundedPair, y: BoundedPair, z: BoundedPair
) -> BoundedPair:
    """Return a x + b y + c z."""
    return plus(plus(times(a, x), times(b, y)), times(c, z))


@inline
def moment(a: BoundedPair, b: BoundedPair, c: BoundedPair, d: BoundedPair) -> BoundedPair:
    """Return a b - c d."""
    return minus(times(a, b), times(c, d))
