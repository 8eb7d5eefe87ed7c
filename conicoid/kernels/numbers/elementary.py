"""Elementary functions by arithmetic alone: hypot, acos, atan2, exp, power, and cos and sin of parts of a turn.

They call no function of the C library, so the bits are the same on every processor and system.
"""

from __future__ import annotations

import math

import numpy as np

from ..._jit.decorators import float_bits, float_from_bits, fma, helper, inline
from .double_double import (
    Pair,
    exponent_of,
    pair_product,
    quick_sum,
    round_pair,
    scale_by_power,
    scale_pair,
    two_difference,
    two_sum,
)


@helper
def hypot(x: float, y: float, z: float) -> float:
    """Return sqrt(x² + y² + z²) within 0.501 units of the last place, for squares of any size; special values as C's.

    The squares are added with an error of 2^-104 of them; one step of Newton's method then corrects the root.
    """
    x, y, z = abs(x), abs(y), abs(z)
    if (x == math.inf) | (y == math.inf) | (z == math.inf):
        return math.inf
    if not (x == x) & (y == y) & (z == z):
        return math.nan
    largest = max(x, max(y, z))
    if largest == 0.0:
        return 0.0
    k = exponent_of(largest)
    x, y, z = scale_by_power(x, -k), scale_by_power(y, -k), scale_by_power(z, -k)
    p, q, r = x * x, y * y, z * z
    s, e = two_sum(p, q)
    s, f = two_sum(s, r)
    rest = (e + f) + ((fma(x, x, -p) + fma(y, y, -q)) + fma(z, z, -r))
    root = math.sqrt(s)
    return round_pair(quick_sum(root, (fma(-root, root, s) + rest) / (2.0 * root)), k)


# Polynomials


@inline
def polynomial(x: float, coefficients: tuple[float, ...]) -> float:
    """Return a polynomial at x by Horner's rule, for odd and even powers side by side.

    `coefficients` has an even length, the highest power first.
    """
    square, odd, even = x * x, 0.0, 0.0
    for k in range(0, len(coefficients), 2):
        odd = fma(odd, square, coefficients[k])
        even = fma(even, square, coefficients[k + 1])
    return fma(odd, x, even)


# acos and atan2
#
# The leading terms are taken in two floats, the rest by polynomials whose coefficients come from
# `tests/numbers/coefficients.py`. The last operation rounds by at most half a unit of the last place. Its operand is
# off by the error of the polynomial, with u = 2^-53: 6 u of x³ / 6 + ... <= 0.0236 where a unit of acos is 2 u and
# |x| <= 1/2 (beyond, that term is taken in two floats too); 7.2 u of t³ / 3 <= 0.0052, and the polynomial's own
# 2^-59.6 t, where a unit of the arc tangent is at least u / 4. Measured: 0.54 and 0.57 units at most.

ASIN = (
    0.027072149944273302, -0.017764251137523158, 0.017771033255193115, 0.002528669035232747, 0.008165934640582937,
    0.008261951665512903, 0.009775076110986592, 0.011550823577337352, 0.013964891636551516, 0.01735276290932625,
    0.02237215911947595, 0.030381944444163943, 0.044642857142858226, 0.075,
)  # fmt: skip
"""(asin s - s - s³/6) / s⁵ in z = s² <= 1/4; error 2^-62 of asin s."""

ATAN = (
    0.03602305043853311, -0.05117354078010482, 0.05871917647375624, -0.06666210203297757, 0.07692295263634524,
    -0.0909090888420049, 0.11111111109132153, -0.14285714285704648, 0.19999999999999982, -0.3333333333333333,
)  # fmt: skip
"""(atan t - t) / t³ in z = t² <= 1/16; error 2^-59 of atan t."""

ZERO = Pair(0.0, 0.0)
SIXTH = Pair(0.16666666666666666, 9.25185853854297e-18)
ATAN_HALF = Pair(0.4636476090008061, 2.2698777452961687e-17)
QUARTER_PI = Pair(0.7853981633974483, 3.061616997868383e-17)
HALF_PI = Pair(1.5707963267948966, 6.123233995736766e-17)
PI = Pair(3.141592653589793, 1.2246467991473532e-16)


@helper
def acos(x: float) -> float:
    """Return the angle in [0, pi] whose cosine is x, within 0.58 units of the last place; NaN outside of [-1, 1]."""
    if not abs(x) <= 1.0:
        return math.nan
    if abs(x) <= 0.5:
        z = x * x
        high, low = quick_sum(HALF_PI.high, -x)
        return high + (low + (HALF_PI.low - x * z * fma(z, polynomial(z, ASIN), SIXTH.high)))
    high, low = _asin_of_root(0.5 * (1.0 - abs(x)))  # exactly
    if x > 0.0:
        return 2.0 * (high + low)
    high, lower = quick_sum(PI.high, -2.0 * high)
    return high + (lower + (PI.low - 2.0 * low))


@inline
def _asin_of_root(z: float) -> Pair:
    """Return asin s = s (1 + z (1/6 + z P(z))) for s = sqrt z, z <= 1/4."""
    s = math.sqrt(z)
    rest = fma(-s, s, z) / (2.0 * s) if z > 0.0 else 0.0
    high, low = quick_sum(SIXTH.high, z * polynomial(z, ASIN))
    share = scale_pair(Pair(high, low + SIXTH.low), z)
    more = scale_pair(share, s)
    high, low = quick_sum(s, more.high)
    return Pair(high, low + (more.low + fma(rest, share.high, rest)))


@helper
def atan2(y: float, x: float) -> float:
    """Return the angle of (x, y) in [-pi, pi], within 0.67 units of the last place; zeros, infinities, NaN as C's."""
    if not (x == x) & (y == y):
        return math.nan
    wide, tall = abs(x), abs(y)
    if max(wide, tall) == math.inf:
        wide, tall = 1.0 if wide == math.inf else 0.0, 1.0 if tall == math.inf else 0.0
    backwards = float_bits(x) < 0
    if max(wide, tall) == 0.0:
        return math.copysign(PI.high if backwards else 0.0, y)
    if not backwards and tall <= 2.0**-30 * wide:
        return math.copysign(tall / wide, y)  # the exact angle is less by a third of its cube
    return math.copysign(_angle(wide, tall, backwards), y)


@inline
def _angle(wide: float, tall: float, backwards: bool) -> float:
    """Return the angle of (wide, tall), or of (-wide, tall) if `backwards`; neither is negative, not both are zero."""
    steep = tall > wide
    more, less = (tall, wide) if steep else (wide, tall)
    k = exponent_of(more)
    slope, t, rest = _reduced(scale_by_power(more, -k), scale_by_power(less, -k))
    rest += t * (t * t) * polynomial(t * t, ATAN)
    start = HALF_PI if steep else (PI if backwards else ZERO)
    turn = -1.0 if steep != backwards else 1.0
    high, low = two_sum(start.high, turn * slope.high)
    low += start.low + turn * slope.low
    high, lower = quick_sum(high, turn * t)
    return high + (lower + (low + turn * rest))


@inline
def _reduced(more: float, less: float) -> tuple[Pair, float, float]:
    """Return (a, t, rest) with atan(less / more) = a + atan(t + rest), where a is atan of 0, 1/2 or 1, and |t| <= 1/4.

    By tan(b - a) = (less - more tan a) / (more + less tan a) for tan b = less / more.
    """
    a, share = ZERO, 0.0
    if less > 0.75 * more:
        a, share = QUARTER_PI, 1.0
    elif less >= 0.25 * more:
        a, share = ATAN_HALF, 0.5
    above, above_rest = two_difference(less, share * more)
    below, below_rest = quick_sum(more, share * less)
    t = above / below
    return a, t, (fma(-t, below, above) + (above_rest - t * below_rest)) / below


# e^x and x^y
#
# Arguments are reduced as by Tang (ACM TOMS 15, 1989), but without a table: e^x = 2^k e^r with |r| <= ln 2 / 2, and
# log x = k ln 2 + 2 atanh s with s = (m - 1) / (m + 1). Leading terms are taken in two floats, the rest by polynomials
# whose coefficients come from `tests/numbers/coefficients.py`.
#
# Bounds: the last operation rounds high + low, by at most half a unit of the last place. For e^x low is off by less
# than 0.05 units: r³ q(r), of at most 0.0064 where e^r is near 0.7 and 0.0075 above 1, has a relative error of 6.5 u,
# u = 2^-53, and the polynomial one of 2^-60. For x^y the relative error of log x is 2^-69; y log x, which is below 746,
# has an error of 2^-59.4. Measured: 0.512 and 0.516 units at most.

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
"""ln 2 to 2^-101: its first 42 bits, so that products with an integer below 2^11 are exact, and the rest."""
PER_LN2 = 1.4426950408889634
THIRD = Pair(0.3333333333333333, 1.850371707708594e-17)
FIFTH = Pair(0.2, -1.1102230246251566e-17)

_OVERFLOW, _UNDERFLOW = 710.0, -746.0
_ROUND = 1.5 * 2.0**52
_FRACTION, _ONE = 2**52 - 1, 1023 << 52


@helper
def exp_pair(x: Pair) -> float:
    """Return e^(high + low), for high + low from -746 to 710."""
    # Adding 1.5 · 2^52 rounds to an integer. x - whole ln 2 follows in pairs
    whole = (x.high * PER_LN2 + _ROUND) - _ROUND
    p = whole * LN2[1]
    r, rest = two_difference(fma(-whole, LN2[0], x.high), p)
    r, rest = two_sum(r, rest + (x.low - fma(whole, LN2[1], -p)))
    half = 0.5 * r * r
    more = fma(0.5 * r, r, -half) + fma(rest, r + half, rest)
    high, low = quick_sum(1.0, r)
    high, lower = quick_sum(high, half)
    result = quick_sum(high, (low + lower) + (more + r * (r * r) * polynomial(r, EXP)))
    return round_pair(result, int(whole))


@inline
def log_pair(x: float) -> Pair:
    """Return log x, with a relative error of 2^-69, for positive finite x."""
    small = x < 2.0**-1022  # subnormal: scaled by 2^54
    bits = float_bits(x * 2.0**54 if small else x)
    k = (bits >> 52) - (1023 + 54 if small else 1023)
    m = float_from_bits((bits & _FRACTION) | _ONE)
    if m > 1.4142135623730951:  # m from sqrt(1/2) to sqrt 2, so that |log m| is small
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
    """Return e^x within 0.55 units of the last place; infinities and NaN as C's."""
    if x > _OVERFLOW:
        return math.inf
    if x < _UNDERFLOW:
        return 0.0
    return exp_pair(Pair(x, 0.0)) if x == x else x


@helper
def power(x: float, y: float) -> float:
    """Return x^y within 0.57 units of the last place, for x >= 0; NaN for x < 0 and y not 0; special values as C's."""
    if (y == 0.0) | (x == 1.0):
        return 1.0
    if not (x >= 0.0) & (y == y):
        return math.nan
    if (x == 0.0) | (x == math.inf):
        return math.inf if (x > 1.0) == (y > 0.0) else 0.0
    if abs(y) == math.inf:
        return math.inf if (x > 1.0) == (y > 0.0) else 0.0
    log = log_pair(x)
    if not y * log.high <= _OVERFLOW:
        return math.inf
    if not y * log.high >= _UNDERFLOW:
        return 0.0
    return exp_pair(scale_pair(log, y))


# Sine and cosine of parts of a turn

_SIN = (
    2.8114572543455206e-15, -7.647163731819816e-13, 1.6059043836821613e-10, -2.505210838544172e-08,
    2.7557319223985893e-06, -0.0001984126984126984, 0.008333333333333333, -0.16666666666666666,
)  # fmt: skip
_COS = (
    4.779477332387385e-14, -1.1470745597729725e-11, 2.08767569878681e-09, -2.755731922398589e-07,
    2.48015873015873e-05, -0.001388888888888889, 0.041666666666666664, -0.5,
)  # fmt: skip
"""Taylor series of (sin x - x) / x³ and (cos x - 1) / x² in x², |x| <= pi / 4; error 2^-54 of the results."""


@inline
def cos_sin_turns(turns: float) -> tuple[float, float]:
    """Return (cos, sin) of 2π turns.

    A multiple of a quarter turn is subtracted exactly; the rest lies within an eighth of a turn.
    """
    quarters = np.floor(4.0 * turns + 0.5)
    x = 2.0 * math.pi * (turns - 0.25 * quarters)
    z = x * x
    s, c = x + x * z * polynomial(z, _SIN), 1.0 + z * polynomial(z, _COS)
    quarter = quarters - 4.0 * np.floor(0.25 * quarters)
    if quarter == 1.0:
        return -s, c
    if quarter == 2.0:
        return -c, -s
    if quarter == 3.0:
        return s, -c
    return c, s
