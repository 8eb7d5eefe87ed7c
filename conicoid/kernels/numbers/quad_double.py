"""Four floats (about 210 bits) with an error bound, for formulas of many steps in lanes.

A number is (a, b, c, d, error): the exact value lies within `error` of a + b + c + d. Every part that a sum or product
cannot hold is added to the bound, so that its proof needs only the error-free operations of double_double.py. An error
of zero means that the number is exact; zero times any number is an exact zero. The bound is rigorous as long as no part
of a product underflows; where one might, LEAST is added, which is far more.

Floats are in order: |b| <= 2^-50 |a|, |c| <= 2^-50 |b|, |d| <= 2^-52 |c|; where they are not, the error is infinite.
Infinities and NaN give numbers whose error is infinite or NaN, and no test is true for these.

Sums and products are those of QD (Hida, Li, Bailey: Algorithms for quad-double precision floating point arithmetic,
2001), with their losses.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..._jit.decorators import choose, fma, inline
from .double_double import two_sum


class QuadDouble(NamedTuple):
    """The exact value lies within `error` of a + b + c + d."""

    a: float
    b: float
    c: float
    d: float
    error: float


LEAST = 2.0**-900
"""Products below this may lose bits; it is added to the error of every product and quotient that is not zero."""
UNKNOWN = math.inf
_GROWN = 1.0 + 2.0**-40
"""Factor greater than the rounding of a sum of a few errors."""


@inline
def four(x: float) -> QuadDouble:
    """Return a float exactly."""
    # x * 0 is NaN for infinite x and for NaN: no comparison with such an error holds, so nothing is certain of it
    return QuadDouble(x, 0.0, 0.0, 0.0, x * 0.0)


@inline
def _in_order(a: float, b: float, c: float, d: float, error: float) -> QuadDouble:
    """Return a + b + c + d as four floats in order; relies on the larger arguments coming first."""
    c, d = two_sum(c, d)
    b, c = two_sum(b, c)
    a, b = two_sum(a, b)
    b, c = two_sum(b, c)
    c, d = two_sum(c, d)
    # Where the largest cancelled, the first pass leaves zeros, and the second moves floats up that still overlap
    a, b = two_sum(a, b)
    b, c = two_sum(b, c)
    c, d = two_sum(c, d)
    # The bounds of products rely on floats in order of size
    error = choose(abs(b) <= abs(a) * 2.0**-50, error, UNKNOWN)
    return QuadDouble(a, b, c, d, choose(abs(c) <= abs(b) * 2.0**-50, error, UNKNOWN))


@inline
def opposite(x: QuadDouble) -> QuadDouble:
    """Return -x."""
    return QuadDouble(-x.a, -x.b, -x.c, -x.d, x.error)


@inline
def _plus(x: QuadDouble, y: QuadDouble) -> tuple[float, float, float, float, float]:
    """Return x + y as four floats in no order, and its error."""
    a, e = two_sum(x.a, y.a)
    b, f = two_sum(x.b, y.b)
    c, g = two_sum(x.c, y.c)
    d, h = two_sum(x.d, y.d)
    b, e = two_sum(b, e)
    c, f = two_sum(c, f)
    c, e = two_sum(c, e)
    d, g = two_sum(d, g)
    d, f = two_sum(d, f)
    d, e = two_sum(d, e)
    # e, f, g, h are what a fifth float would hold
    lost = (abs(e) + abs(f)) + (abs(g) + abs(h))
    return a, b, c, d, (x.error + y.error + lost) * _GROWN


@inline
def plus(x: QuadDouble, y: QuadDouble) -> QuadDouble:
    """Return x + y."""
    a, b, c, d, error = _plus(x, y)
    return _in_order(a, b, c, d, error)


@inline
def minus(x: QuadDouble, y: QuadDouble) -> QuadDouble:
    """Return x - y."""
    return plus(x, opposite(y))


@inline
def _last(x: QuadDouble) -> float:
    """Return the smallest float of x that is not zero."""
    return choose(x.d != 0.0, x.d, choose(x.c != 0.0, x.c, choose(x.b != 0.0, x.b, x.a)))


@inline
def times(x: QuadDouble, y: QuadDouble) -> QuadDouble:
    """Return x y.

    Of the sixteen products of floats the first six count with their rounding errors. The next four are added in floats,
    together with these errors and those of the sums before: 13 terms, with an error below 2^-49 of their sizes. The
    last six only count in the error bound. Where a factor is certainly zero, so is the product.
    """
    p = x.a * y.a
    q, r = x.a * y.b, x.b * y.a
    s, t, u = x.a * y.c, x.b * y.b, x.c * y.a
    e, f, g = fma(x.a, y.a, -p), fma(x.a, y.b, -q), fma(x.b, y.a, -r)
    h, i, j = fma(x.a, y.c, -s), fma(x.b, y.b, -t), fma(x.c, y.a, -u)
    q, r = two_sum(q, r)
    q, e = two_sum(q, e)
    s, k = two_sum(s, u)
    s, t = two_sum(s, t)
    s, u = two_sum(s, r)
    s, e = two_sum(s, e)
    f, g = two_sum(f, g)
    s, f = two_sum(s, f)
    l, m, n, o = x.a * y.d, x.b * y.c, x.c * y.b, x.d * y.a  # noqa: E741
    rest = (((h + i) + (j + k)) + ((t + u) + (e + f))) + (((l + o) + (m + n)) + g)
    sizes = ((abs(h) + abs(i)) + (abs(j) + abs(k))) + ((abs(t) + abs(u)) + abs(e))
    sizes += ((abs(l) + abs(o)) + (abs(m) + abs(n))) + abs(g)
    sizes = choose(sizes == 0.0, 0.0, sizes + abs(f))  # one term alone is added exactly
    b, c, d = abs(x.b), abs(x.c), abs(x.d)
    left_out = b * abs(y.d) + c * (abs(y.c) + abs(y.d)) + d * ((abs(y.b) + abs(y.c)) + abs(y.d))
    carried = abs(x.a) * y.error + (abs(y.a) + y.error) * x.error
    error = (sizes * 2.0**-49 + left_out + carried) * 1.0001
    below = choose(abs(_last(x) * _last(y)) >= LEAST, 0.0, LEAST)
    inexact = choose((error + x.error) + (y.error + below) == 0.0, 0.0, LEAST)
    nothing = choose(abs(x.a) + x.error == 0.0, 0.0, choose(abs(y.a) + y.error == 0.0, 0.0, 1.0))
    return _in_order(p, q, s, rest, choose(nothing == 0.0, 0.0, error + inexact))


@inline
def _rest(x: QuadDouble, y: QuadDouble) -> QuadDouble:
    """Return x - y for nearly equal x and y: the floats may be out of order, so the result must not be multiplied."""
    a, b, c, d, error = _plus(x, opposite(y))
    for _ in range(2):  # what two floats that cancel uncover, the second pass brings to the first
        c, d = two_sum(c, d)
        b, c = two_sum(b, c)
        a, b = two_sum(a, b)
    return QuadDouble(a, b, c, d, error)


@inline
def over(x: QuadDouble, y: QuadDouble) -> QuadDouble:
    """Return x / y; the error is infinite where y may be zero.

    Long division in four steps. The remainder of x then, with its error, is y times the error of the quotient.
    """
    a = x.a / y.a
    rest = _rest(x, times(four(a), y))
    b = rest.a / y.a
    rest = _rest(rest, times(four(b), y))
    c = rest.a / y.a
    rest = _rest(rest, times(four(c), y))
    d = rest.a / y.a
    # What long division leaves, over the least |y|, bounds the quotient's error. No analysis of the steps is needed
    left = _size(_rest(rest, times(four(d), y)))
    least = abs(y.a) * 0.9999 - y.error
    error = left / least * 1.0001 + choose(left == 0.0, 0.0, LEAST)
    return _in_order(a, b, c, d, choose(least > 0.0, error, UNKNOWN))


@inline
def _size(x: QuadDouble) -> float:
    """Return an upper bound of |x|."""
    return ((abs(x.a) + abs(x.b)) + (abs(x.c) + abs(x.d)) + x.error) * 1.000001


@inline
def root(x: QuadDouble) -> QuadDouble:
    """Return the square root of a number that is certainly positive, or zero; else the error is infinite.

    To an approximation s, (x - s²) / (2 s) is added three times. With r = x - s² then, |sqrt(x) - s| is
    |r| / (sqrt(x) + s) <= |r| / s. A root that two floats hold is found exactly: 1.5 x from 2.25 x², say.
    """
    # 1 in place of other numbers keeps NaN out of the lanes; the error of the result is infinite then
    first = math.sqrt(choose(x.a > 0.0, x.a, 1.0))
    half = 0.5 / first
    s = four(first)
    s = _in_order(s.a, _rest(x, times(s, s)).a * half, 0.0, 0.0, 0.0)
    s = _in_order(s.a, s.b, _rest(x, times(s, s)).a * half, 0.0, s.error)
    s = _in_order(s.a, s.b, s.c, _rest(x, times(s, s)).a * half, s.error)
    short = QuadDouble(s.a, s.b, 0.0, 0.0, 0.0)
    more = choose(is_zero(_rest(x, times(short, short))), 0.0, 1.0)
    s = QuadDouble(s.a, s.b, s.c * more, s.d * more, s.error)
    left = _size(_rest(x, times(s, s)))
    error = left / first * 1.0001 + choose(left == 0.0, 0.0, LEAST)
    error = choose(x.a * 0.9999 > x.error, error + s.error, UNKNOWN)
    some = choose(is_zero(x), 0.0, 1.0)
    return QuadDouble(s.a * some, s.b * some, s.c * some, s.d * some, choose(some == 0.0, 0.0, error))


@inline
def is_zero(x: QuadDouble) -> bool:
    """True if x is certainly zero."""
    return (abs(x.a) + abs(x.b)) + (abs(x.c) + abs(x.d)) + x.error == 0.0


@inline
def by_sign(x: QuadDouble, negative: float, zero: float, positive: float, unsure: float) -> float:
    """Return one of four floats by the sign of x."""
    certain = choose(abs(x.a) * 0.9999 > x.error, choose(x.a > 0.0, positive, negative), unsure)
    return choose(is_zero(x), zero, certain)


@inline
def size_of(x: QuadDouble) -> QuadDouble:
    """Return |x|; the error is infinite where the sign is not certain."""
    turn = choose(x.a < 0.0, -1.0, 1.0)
    return QuadDouble(x.a * turn, x.b * turn, x.c * turn, x.d * turn, by_sign(x, x.error, 0.0, x.error, UNKNOWN))


@inline
def nearest(x: QuadDouble) -> tuple[float, float]:
    """Return (the float nearest to x, flag): flag 1 if that is not certain, or not in the middle of the range, else 0.

    Ziv's test: both ends of the interval round to the same float. The part below the first two floats is enlarged by
    more than its addition to the second may lose. Where the sum of the first two is halfway between two floats, its
    sign decides.
    """
    below = (abs(x.c) + abs(x.d)) + x.error
    below = choose(below == 0.0, 0.0, (below + abs(x.b) * 2.0**-52) * 1.0001)
    up, down = x.a + (x.b + below), x.a + (x.b - below)
    # Halfway: a + 2 b is the float beyond, and a + b rounds to it or to a
    middle, beyond = x.a + x.b, x.a + (x.b + x.b)
    gap = choose(middle == x.a, beyond - x.a, choose(middle == beyond, beyond - x.a, 0.0))
    side = choose(gap == x.b + x.b, x.c + x.d, 0.0)
    other = choose((side > 0.0) == (x.b > 0.0), beyond, x.a)
    is_clear = abs(side) * 0.9999 > x.error
    up, down = choose(is_clear, other, up), choose(is_clear, other, down)
    size = abs(up)
    inside = choose(size < 2.0**900, choose(size > 2.0**-800, 0.0, choose(size == 0.0, 0.0, 1.0)), 1.0)
    return up + 0.0, choose(up == down, inside, 1.0)
