"""Numbers in two floats with a bound on their error, for deciding what one float cannot.

A number is (high, low, error): the exact value lies within `error` of high + low. Every operation adds to
the bound what it may lose, so what comes out is certain whatever cancels; sums, and products of single floats,
that lose nothing add nothing, so that an exact zero is known for one. Bounds of the operations: Joldes,
Muller, Popescu (see doubled.py); ours are a few times larger.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ...compiler.jit import fma, inline
from .doubled import quick_sum
from .errorfree import two_sum


class Sure(NamedTuple):
    """The exact value lies within `error` of high + low."""

    high: float
    low: float
    error: float


_LOST = 2.0**-98


@inline
def sure(x: float, rest: float = 0.0) -> Sure:
    """A float, or a rounded number with what rounding took from it."""
    high, low = quick_sum(x, rest)
    return Sure(high, low, 0.0 if rest == 0.0 else abs(rest) * 2.0**-52)


@inline
def remainder(rest: float) -> Sure:
    """What rounding took from a number, which is rounded itself."""
    return Sure(rest, 0.0, abs(rest) * 2.0**-52)


@inline
def product(x: float, y: float) -> Sure:
    """x y exactly."""
    p = x * y
    return Sure(p, fma(x, y, -p), 0.0)


@inline
def plus(a: Sure, b: Sure) -> Sure:
    """a + b."""
    s, e = two_sum(a.high, b.high)
    t, f = two_sum(a.low, b.low)
    e, r = two_sum(e, t)
    s, e = quick_sum(s, e)
    e, q = two_sum(e, f)
    s, e = quick_sum(s, e)
    return Sure(s, e, a.error + b.error + (abs(r) + abs(q)))


@inline
def opposite(a: Sure) -> Sure:
    """-a, exactly."""
    return Sure(-a.high, -a.low, a.error)


@inline
def minus(a: Sure, b: Sure) -> Sure:
    """a - b."""
    return plus(a, opposite(b))


@inline
def times(a: Sure, b: Sure) -> Sure:
    """a b."""
    p = a.high * b.high
    e = fma(a.high, b.high, -p) + fma(a.high, b.low, a.low * b.high)
    high, low = quick_sum(p, e)
    lost = 0.0 if (a.low == 0.0) & (b.low == 0.0) else _LOST * abs(p)
    return Sure(high, low, (abs(a.high) + a.error) * b.error * 1.0001 + abs(b.high) * a.error * 1.0001 + lost)


@inline
def scaled(a: Sure, x: float) -> Sure:
    """a x for one float x."""
    p, q = a.high * x, a.low * x
    e, r = two_sum(fma(a.high, x, -p), q)
    high, low = quick_sum(p, e)
    return Sure(high, low, a.error * abs(x) + (abs(r) + abs(fma(a.low, x, -q))))


@inline
def over(a: Sure, b: Sure) -> Sure:
    """a / b; unbounded error where b may be zero."""
    least = abs(b.high) * 0.9999 - b.error
    if not least > 0.0:
        return Sure(0.0, 0.0, math.inf)
    first = a.high / b.high
    rest = minus(Sure(a.high, a.low, 0.0), scaled(Sure(b.high, b.low, 0.0), first))
    high, low = quick_sum(first, rest.high / b.high)
    return Sure(high, low, (a.error + abs(high) * b.error) / least * 1.0001 + _LOST * abs(high))


@inline
def root(a: Sure) -> Sure:
    """The square root of what is certainly positive."""
    first = math.sqrt(a.high)
    rest = minus(Sure(a.high, a.low, 0.0), product(first, first))
    high, low = quick_sum(first, rest.high / (2.0 * first))
    return Sure(high, low, a.error / math.sqrt(a.high * 0.9999 - a.error) * 1.0001 + _LOST * high)


@inline
def sign(a: Sure) -> int:
    """-1, 0 or 1, or 2 where it is not certain."""
    if abs(a.high) * 0.9999 > a.error:
        return 1 if a.high > 0.0 else -1
    return 0 if (a.high == 0.0) & (a.low == 0.0) & (a.error == 0.0) else 2


@inline
def dot3(x: float, y: float, z: float, a: Sure, b: Sure, c: Sure) -> Sure:
    """x a + y b + z c"""
    return plus(plus(scaled(a, x), scaled(b, y)), scaled(c, z))


@inline
def inner(a: Sure, b: Sure, c: Sure, x: Sure, y: Sure, z: Sure) -> Sure:
    """a x + b y + c z"""
    return plus(plus(times(a, x), times(b, y)), times(c, z))


@inline
def moment(a: Sure, b: Sure, c: Sure, d: Sure) -> Sure:
    """a b - c d"""
    return minus(times(a, b), times(c, d))
