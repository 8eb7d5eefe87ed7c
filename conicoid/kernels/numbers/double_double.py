"""Error-free operations on floats, exponents and neighbours of floats, and pairs of floats (about 106 bits).

Sources: Knuth's TwoSum; Kahan's difference of products (error at most 1.5 ulp: Jeannerod, Louvet, Muller, Math. Comp.
82, 2013); Dot2 (Ogita, Rump, Oishi, SIAM J. Sci. Comput. 26, 2005); for pairs Joldes, Muller, Popescu: Tight and
rigorous error bounds for basic building blocks of double-word arithmetic, ACM TOMS 44, 2017.
"""

from __future__ import annotations

from typing import NamedTuple

from ..._jit.decorators import float_bits, float_from_bits, fma, helper, inline


@inline
def two_sum(a: float, b: float) -> tuple[float, float]:
    """Return (s, e) with s = fl(a + b) and s + e = a + b exactly."""
    s = a + b
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
    if abs(x) < _FIRST_NORMAL:
        return (float_bits(abs(x) * 2.0**54) >> _FRACTION) - (_BIAS + 54)
    return (float_bits(abs(x)) >> _FRACTION) - _BIAS


@inline
def scale_by_power(x: float, k: int) -> float:
    """Return x 2^k, for k from -2044 to 2046; in two steps, as 2^k itself may be beyond the floats."""
    half = k >> 1
    return x * power_of_two(half) * power_of_two(k - half)


@inline
def next_float_up(x: float) -> float:
    """Return the least float greater than x; infinity and NaN stay."""
    if x == 0.0:
        return 2.0**-1074
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
    s, e = quick_sum(s, e + t)
    return quick_sum(s, e + f)


@inline
def pair_product(a: Pair, b: Pair) -> Pair:
    """Return a b with a relative error of 5 u² (algorithm 12)."""
    p = a.high * b.high
    e = fma(a.high, b.high, -p)
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
    if k > 0 or a.high >= power_of_two(-1022 - k):
        return scale_by_power(a.high, k)
    lifted = power_of_two(-1022 - k)  # floats from here to its double have the last place that the result keeps
    s = lifted + a.high
    s += (a.high - (s - lifted)) + a.low
    return (s - lifted) * power_of_two(k + 1000) * 2.0**-1000
