"""e^x and x^y by arithmetic alone: no function of the C library, so the same bits on every processor and system.

Arguments are cut down as usual (Tang, ACM TOMS 15, 1989, but without a table): e^x = 2^k e^r with |r| <= ln 2 / 2, and
log x = k ln 2 + 2 atanh s with s = (m - 1) / (m + 1). Leading terms are taken in two floats, the rest by
polynomials whose coefficients `tests/numbers/coefficients.py` finds.

Bounds: the last operation rounds high + low, by at most half a unit of the last place. For e^x low is off by less than
0.05 units: r³ q(r), of at most 0.0064 where e^r is near 0.7 and 0.0075 above 1, has a relative error of 6.5 u,
u = 2^-53, and the polynomial one of 2^-60. For x^y log x is known to 2^-69 of itself, and times y, below 746, to
2^-59.4.
Measured: 0.512 and 0.516 at most.
"""

from __future__ import annotations

import math

from ...compiler.jit import bits_of, fma, helper, inline, of_bits
from .doubled import Pair, pair_product, pair_scaled, quick_sum, rounded
from .errorfree import two_difference, two_sum
from .polynomial import polynomial

EXP = (
    2.091123100592285e-09, 2.5100377619606372e-08, 2.75572829813734e-07, 2.7557268476553695e-06, 2.4801587317136892e-05,
    0.00019841269863042963, 0.0013888888888886554, 0.008333333333330063, 0.041666666666666664, 0.16666666666666669,
)  # fmt: skip
"""(e^r - 1 - r - r²/2) / r³, |r| <= 0.34658; error 2^-60 of e^r."""

LOG = (
    0.05308568303207154, 0.052364480770138624, 0.058830251286501566, 0.0666665733654096,
    0.0769230776247181, 0.09090909090650344, 0.11111111111111474, 0.14285714285714285,
)  # fmt: skip
"""(atanh s - s - s³/3 - s⁵/5) / s⁷ in z = s² <= 0.02944; error 2^-72 of atanh s."""

LN2 = (0.6931471805598903, 5.497923018708371e-14)
"""ln 2 to 2^-101: its first 42 bits, so that products with a whole number below 2^11 are exact, and the rest."""
PER_LN2 = 1.4426950408889634
THIRD = Pair(0.3333333333333333, 1.850371707708594e-17)
FIFTH = Pair(0.2, -1.1102230246251566e-17)

_OVERFLOW, _UNDERFLOW = 710.0, -746.0
_ROUND = 1.5 * 2.0**52
_FRACTION, _ONE = 2**52 - 1, 1023 << 52


@helper
def exp_of_pair(x: Pair) -> float:
    """e^(high + low), from -746 to 710."""
    whole = (x.high * PER_LN2 + _ROUND) - _ROUND
    p = whole * LN2[1]
    r, rest = two_difference(fma(-whole, LN2[0], x.high), p)
    r, rest = two_sum(r, rest + (x.low - fma(whole, LN2[1], -p)))
    half = 0.5 * r * r
    more = fma(0.5 * r, r, -half) + fma(rest, r + half, rest)
    high, low = quick_sum(1.0, r)
    high, lower = quick_sum(high, half)
    result = quick_sum(high, (low + lower) + (more + r * (r * r) * polynomial(r, EXP)))
    return rounded(result, int(whole))


@inline
def log_of(x: float) -> Pair:
    """log x to 2^-69 of itself, of a positive finite number."""
    small = x < 2.0**-1022
    bits = bits_of(x * 2.0**54 if small else x)
    k = (bits >> 52) - (1023 + 54 if small else 1023)
    m = of_bits((bits & _FRACTION) | _ONE)
    if m > 1.4142135623730951:
        m *= 0.5
        k += 1
    f, (g, rest) = m - 1.0, quick_sum(m, 1.0) if m > 1.0 else quick_sum(1.0, m)
    s = f / g
    s = Pair(s, (fma(-s, g, f) - s * rest) / g)
    z = pair_product(s, s)
    tail = quick_sum(FIFTH.high, z.high * polynomial(z.high, LOG))
    tail = pair_product(z, Pair(tail.high, tail.low + FIFTH.low))
    high, low = quick_sum(THIRD.high, tail.high)
    tail = pair_product(pair_product(s, z), Pair(high, low + (THIRD.low + tail.low)))
    high, low = quick_sum(s.high, tail.high)
    low += s.low + tail.low
    high, lower = quick_sum(k * LN2[0], 2.0 * high)
    return quick_sum(high, lower + (2.0 * low + k * LN2[1]))


@helper
def exp(x: float) -> float:
    """e^x within 0.55 units of the last place; of infinities and NaN as C's."""
    if x > _OVERFLOW:
        return math.inf
    if x < _UNDERFLOW:
        return 0.0
    return exp_of_pair(Pair(x, 0.0)) if x == x else x


@helper
def power(x: float, y: float) -> float:
    """x^y within 0.57 units of the last place, for x >= 0; special values as C's pow. NaN for x < 0 and y not 0."""
    if (y == 0.0) | (x == 1.0):
        return 1.0
    if not (x >= 0.0) & (y == y):
        return math.nan
    if (x == 0.0) | (x == math.inf):
        return math.inf if (x > 1.0) == (y > 0.0) else 0.0
    if abs(y) == math.inf:
        return math.inf if (x > 1.0) == (y > 0.0) else 0.0
    log = log_of(x)
    if not y * log.high <= _OVERFLOW:
        return math.inf
    if not y * log.high >= _UNDERFLOW:
        return 0.0
    return exp_of_pair(pair_scaled(log, y))
