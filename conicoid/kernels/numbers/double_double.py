"""Error-free operations on floats, pairs of floats (about 106 bits), and pairs with an error bound.

Sources: Knuth's TwoSum; Kahan's difference of products (error at most 1.5 ulp: Jeannerod, Louvet, Muller, Math. Comp.
82, 2013); Dot2 (Ogita, Rump, Oishi, SIAM J. Sci. Comput. 26, 2005); for pairs Joldes, Muller, Popescu: Tight and
rigorous error bounds for basic building blocks of double-word arithmetic, ACM TOMS 44, 2017.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..._jit.decorators import float_bits, float_from_bits, fma, helper, inline


@inline
def two_sum(a: float, b: float) -> tuple[float, float]:
    """Return (s, e) with s = fl(a + b) and s + e = a + b exactly."""
    s = a + b
    # v is the part of b that s holds; both brackets are exact (Knuth)
    v = s - a
    return s, (a - (s - v)) + (b - v)


@inline
def two_difference(a: float, b: float) -> tuple[float, float]:
    """Return (d, e) with d = fl(a - b) and d + e = a - b exactly."""
    d = a - b
    v = d - a
    return d, (a - (d - v)) - (b + v)


@inline
def difference_of_products(a: float, b: float, c: float, d: float) -> float:
    """Return a b - c d, to 1.5 ulp of the result."""
    # The rounding of c d is added back exactly by the second fma
    w = c * d
    return fma(a, b, -w) + fma(-c, d, w)


@helper
def accurate_dot(ax: float, ay: float, az: float, bx: float, by: float, bz: float, more: float, tiny: float) -> float:
    """Return a·b + more + tiny as if in twice the precision, then rounded; `tiny` is small against the rest."""
    p = ax * bx
    q = ay * by
    r = az * bz
    s, e = two_sum(p, q)
    s, f = two_sum(s, r)
    s, g = two_sum(s, more)
    # Rounding errors of the products, each exact as an fma; their sum may round, as it is 2^-53 of the whole
    lost = (fma(ax, bx, -p) + fma(ay, by, -q)) + fma(az, bz, -r)
    return s + (((e + f) + g) + (lost + tiny))


# Exponents and neighbours of floats, by their bits: without the C library, so that all systems give the same result

_FRACTION = 52
_BIAS = 1023
_FIRST_NORMAL = 2.0**-1022


@inline
def power_of_two(k: int) -> float:
    """Return 2^k, for k from -1022 to 1023."""
    return float_from_bits((k + _BIAS) << _FRACTION)


@inline
def exponent_of(x: float) -> int:
    """Return the k with 2^k <= |x| < 2^(k+1), also for subnormal numbers; x is finite and not zero."""
    # Subnormal numbers have no exponent of their own: 2^54 makes them normal
    if abs(x) < _FIRST_NORMAL:
        return (float_bits(abs(x) * 2.0**54) >> _FRACTION) - (_BIAS + 54)
    return (float_bits(abs(x)) >> _FRACTION) - _BIAS


@inline
def scale_by_power(x: float, k: int) -> float:
    """Return x 2^k, for k from -2044 to 2046; in two steps, as 2^k itself may be beyond the floats."""
    # Two normal powers, whose product with x rounds once
    half = k >> 1
    return x * power_of_two(half) * power_of_two(k - half)


@inline
def next_float_up(x: float) -> float:
    """Return the least float greater than x; infinity and NaN stay."""
    # The bits of 0 are no neighbours of those of the least negative number
    if x == 0.0:
        return 2.0**-1074
    # The right side is infinity; `not <` holds for NaN as well
    if not x < 2.0**1023 * 2.0:
        return x
    # As integers, the bits of positive floats rise with the float, those of negative floats fall
    return float_from_bits(float_bits(x) + (1 if x > 0.0 else -1))


@inline
def next_float_down(x: float) -> float:
    """Return the greatest float less than x; minus infinity and NaN stay."""
    return -next_float_up(-x)


# Pairs of floats, for the few rays whose fast formulas cancel
#
# A number is a pair (high, low) with high = fl(high + low). u is 2^-53; algorithms are numbered as by Joldes, Muller
# and Popescu.


class Pair(NamedTuple):
    """The number high + low, where |low| is at most half a unit of high's last place."""

    high: float
    low: float


@inline
def quick_sum(a: float, b: float) -> Pair:
    """Return a + b exactly; relies on |a| >= |b| or a = 0."""
    s = a + b
    return Pair(s, b - (s - a))


@inline
def pair_sum(a: Pair, b: Pair) -> Pair:
    """Return a + b with a relative error of 3 u² (algorithm 6)."""
    s, e = two_sum(a.high, b.high)
    t, f = two_sum(a.low, b.low)
    # s is larger than e + t, unless it is 0 and both are exact
    s, e = quick_sum(s, e + t)
    return quick_sum(s, e + f)


@inline
def pair_product(a: Pair, b: Pair) -> Pair:
    """Return a b with a relative error of 5 u² (algorithm 12)."""
    p = a.high * b.high
    e = fma(a.high, b.high, -p)
    # low × low is 2^-106 of the product, below the error bound
    e += fma(a.high, b.low, a.low * b.high)
    return quick_sum(p, e)


@inline
def scale_pair(a: Pair, b: float) -> Pair:
    """Return a b for a float b."""
    p = a.high * b
    return quick_sum(p, fma(a.low, b, fma(a.high, b, -p)))


@inline
def negate_pair(a: Pair) -> Pair:
    """Return -a exactly."""
    return Pair(-a.high, -a.low)


@inline
def pair_dot(x: float, y: float, z: float, a: Pair, b: Pair, c: Pair) -> Pair:
    """Return x a + y b + z c."""
    return pair_sum(pair_sum(scale_pair(a, x), scale_pair(b, y)), scale_pair(c, z))


@inline
def round_pair(a: Pair, k: int) -> float:
    """Return (high + low) 2^k rounded once, also to a subnormal number; high from 0.5 to 4, k from -1080 to 1024."""
    # A normal result: the power of two is exact, and high is the rounded number already
    if k > 0 or a.high >= power_of_two(-1022 - k):
        return scale_by_power(a.high, k)
    lifted = power_of_two(-1022 - k)  # floats from here to its double have the last place that the result keeps
    s = lifted + a.high
    s += (a.high - (s - lifted)) + a.low
    return (s - lifted) * power_of_two(k + 1000) * 2.0**-1000


# Pairs of floats with an error bound, for decisions that single floats leave open.
#
# A number is (high, low, error): the exact value lies within `error` of high + low. Every operation adds to
# the bound what it may lose, so a result is certain whatever cancels; sums, and products of single floats, that lose
# nothing add nothing, so that an exact zero is recognised. Bounds of the operations: Joldes,
# Muller, Popescu (see the top); ours are a few times larger.


class BoundedPair(NamedTuple):
    """The exact value lies within `error` of high + low."""

    high: float
    low: float
    error: float


_LOST = 2.0**-98  # relative error of a product, quotient or root
_SMALL, _UNDERFLOW = 2.0**-900, 2.0**-1060
"""Below the first, low parts of a product, quotient or root may underflow; the second is more than that takes away."""


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
def _is_zero(a: BoundedPair) -> bool:
    """Return whether a number is exactly 0."""
    return (a.high == 0.0) & (a.error == 0.0)


@inline
def product(x: float, y: float) -> BoundedPair:
    """Return x y exactly, unless it underflows."""
    p = x * y
    return BoundedPair(p, fma(x, y, -p), 0.0 if (abs(p) >= _SMALL) | (x == 0.0) | (y == 0.0) else _UNDERFLOW)


@inline
def plus(a: BoundedPair, b: BoundedPair) -> BoundedPair:
    """Return a + b."""
    s, e = two_sum(a.high, b.high)
    t, f = two_sum(a.low, b.low)
    # All rounding errors are kept, so that the bound can be 0 where nothing is lost
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
    lost += 0.0 if (abs(p) >= _SMALL) | _is_zero(a) | _is_zero(b) else _UNDERFLOW
    # 1.0001 covers the low parts, and the rounding of the bound itself
    return BoundedPair(high, low, (abs(a.high) + a.error) * b.error * 1.0001 + abs(b.high) * a.error * 1.0001 + lost)


@inline
def times_float(a: BoundedPair, x: float) -> BoundedPair:
    """Return a x for a float x."""
    p, q = a.high * x, a.low * x
    e, r = two_sum(fma(a.high, x, -p), q)
    high, low = quick_sum(p, e)
    lost = 0.0 if (abs(p) >= _SMALL) | _is_zero(a) | (x == 0.0) else _UNDERFLOW
    return BoundedPair(high, low, a.error * abs(x) + (abs(r) + abs(fma(a.low, x, -q))) + lost)


@inline
def over(a: BoundedPair, b: BoundedPair) -> BoundedPair:
    """Return a / b; the error is infinite where b may be zero."""
    # A lower bound of |b|: 0.9999 covers the low part, which is at most half a unit in the last place of the high one
    least = abs(b.high) * 0.9999 - b.error
    if not least > 0.0:
        return BoundedPair(0.0, 0.0, math.inf)
    # One step of long division: the remainder is exact but for its own bound
    first = a.high / b.high
    rest = minus(BoundedPair(a.high, a.low, 0.0), times_float(BoundedPair(b.high, b.low, 0.0), first))
    high, low = quick_sum(first, rest.high / b.high)
    lost = 0.0 if (abs(a.high) >= _SMALL) | _is_zero(a) else _UNDERFLOW
    under = 0.0 if (abs(high) >= _SMALL) | _is_zero(a) else _UNDERFLOW
    error = (a.error + abs(high) * b.error + lost) / least * 1.0001 + _LOST * abs(high) + under
    return BoundedPair(high, low, error)


@inline
def root(a: BoundedPair) -> BoundedPair:
    """Return the square root; relies on `a` being certainly positive."""
    # One step of Newton's method doubles the digits
    first = math.sqrt(a.high)
    rest = minus(BoundedPair(a.high, a.low, 0.0), product(first, first))
    high, low = quick_sum(first, rest.high / (2.0 * first))
    # |√x - √y| <= |x - y| / √x, and the least x is above a.high * 0.9999 - a.error
    lost = 0.0 if a.high >= _SMALL else _UNDERFLOW
    return BoundedPair(high, low, (a.error + lost) / math.sqrt(a.high * 0.9999 - a.error) * 1.0001 + _LOST * high)


@inline
def sign(a: BoundedPair) -> int:
    """Return the sign -1, 0 or 1, or 2 (OPEN) where it is not certain."""
    # 0.9999 covers the low part, which may have the other sign
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
