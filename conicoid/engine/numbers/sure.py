"""Numbers in two floats with a bound on their error, for deciding what one float cannot.

A number is (high, low, error): the exact value lies within `error` of high + low. Every operation adds to
the bound what it may lose, so what comes out is certain whatever cancels; sums, and products of single floats,
that lose nothing add nothing, so that an exact zero is known for one. Bounds of the operations: Joldes,
Muller, Popescu (see doubled.py); ours are a few times larger.
"""

from __future__ import annotations

import math
from typing import TypeAlias

from ...compiler.jit import fma, inline
from .doubled import quick_sum
from .errorfree import two_sum

Sure: TypeAlias = tuple[float, float, float]

_LOST = 2.0**-98


@inline
def sure(x: float, rest: float = 0.0) -> Sure:
    """A float, or a rounded number with what rounding took from it."""
    high, low = quick_sum(x, rest)
    return high, low, 0.0 if rest == 0.0 else abs(rest) * 2.0**-52


@inline
def remainder(rest: float) -> Sure:
    """What rounding took from a number, which is rounded itself."""
    return rest, 0.0, abs(rest) * 2.0**-52


@inline
def product(x: float, y: float) -> Sure:
    """x y exactly."""
    p = x * y
    return p, fma(x, y, -p), 0.0


@inline
def plus(a: Sure, b: Sure) -> Sure:
    s, e = two_sum(a[0], b[0])
    t, f = two_sum(a[1], b[1])
    e, r = two_sum(e, t)
    s, e = quick_sum(s, e)
    e, q = two_sum(e, f)
    s, e = quick_sum(s, e)
    return s, e, a[2] + b[2] + (abs(r) + abs(q))


@inline
def opposite(a: Sure) -> Sure:
    return -a[0], -a[1], a[2]


@inline
def minus(a: Sure, b: Sure) -> Sure:
    return plus(a, opposite(b))


@inline
def times(a: Sure, b: Sure) -> Sure:
    p = a[0] * b[0]
    e = fma(a[0], b[0], -p) + fma(a[0], b[1], a[1] * b[0])
    high, low = quick_sum(p, e)
    lost = 0.0 if (a[1] == 0.0) & (b[1] == 0.0) else _LOST * abs(p)
    return high, low, (abs(a[0]) + a[2]) * b[2] * 1.0001 + abs(b[0]) * a[2] * 1.0001 + lost


@inline
def scaled(a: Sure, x: float) -> Sure:
    """a x for one float x."""
    p, q = a[0] * x, a[1] * x
    e, r = two_sum(fma(a[0], x, -p), q)
    high, low = quick_sum(p, e)
    return high, low, a[2] * abs(x) + (abs(r) + abs(fma(a[1], x, -q)))


@inline
def over(a: Sure, b: Sure) -> Sure:
    """a / b; unbounded error where b may be zero."""
    least = abs(b[0]) * 0.9999 - b[2]
    if not least > 0.0:
        return 0.0, 0.0, math.inf
    first = a[0] / b[0]
    rest = minus((a[0], a[1], 0.0), scaled((b[0], b[1], 0.0), first))
    high, low = quick_sum(first, rest[0] / b[0])
    return high, low, (a[2] + abs(high) * b[2]) / least * 1.0001 + _LOST * abs(high)


@inline
def root(a: Sure) -> Sure:
    """The square root of what is certainly positive."""
    first = math.sqrt(a[0])
    rest = minus((a[0], a[1], 0.0), product(first, first))
    high, low = quick_sum(first, rest[0] / (2.0 * first))
    return high, low, a[2] / math.sqrt(a[0] * 0.9999 - a[2]) * 1.0001 + _LOST * high


@inline
def sign(a: Sure) -> int:
    """-1, 0 or 1, or 2 where it is not certain."""
    if abs(a[0]) * 0.9999 > a[2]:
        return 1 if a[0] > 0.0 else -1
    return 0 if (a[0] == 0.0) & (a[1] == 0.0) & (a[2] == 0.0) else 2


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
