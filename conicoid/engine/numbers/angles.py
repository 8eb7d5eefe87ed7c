"""acos and atan2 by arithmetic alone: no function of the C library, so the same bits on every processor and system.

The leading terms are taken in two floats, the rest by polynomials whose coefficients `tests/numbers/coefficients.py`
finds. The last operation rounds by at most half a unit of the last place, and what it rounds is off by the polynomial's
part, u = 2^-53: 6 u of x³ / 6 + ... <= 0.0236 where a unit of acos is 2 u and |x| <= 1/2 (else that is taken in two
floats too); 7.2 u of t³ / 3 <= 0.0052, and the polynomial's own 2^-59.6 t, where a unit of the arc tangent is at least
u / 4. Measured: 0.54 and 0.57 at most.
"""

from __future__ import annotations

import math

from ...compiler.jit import bits_of, fma, helper, inline
from .bits import exponent_of, scaled_by_power
from .doubled import Pair, pair_scaled, quick_sum
from .errorfree import two_difference, two_sum
from .polynomial import polynomial

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
    """The angle in [0, pi] whose cosine is x, within 0.58 units of the last place; NaN outside of [-1, 1]."""
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
    """asin s = s (1 + z (1/6 + z P(z))) of s = sqrt z, for z <= 1/4."""
    s = math.sqrt(z)
    rest = fma(-s, s, z) / (2.0 * s) if z > 0.0 else 0.0
    high, low = quick_sum(SIXTH.high, z * polynomial(z, ASIN))
    share = pair_scaled(Pair(high, low + SIXTH.low), z)
    more = pair_scaled(share, s)
    high, low = quick_sum(s, more.high)
    return Pair(high, low + (more.low + fma(rest, share.high, rest)))


@helper
def atan2(y: float, x: float) -> float:
    """The angle of (x, y) in [-pi, pi], within 0.67 units of the last place; zeros, infinities and NaN as C's."""
    if not (x == x) & (y == y):
        return math.nan
    wide, tall = abs(x), abs(y)
    if max(wide, tall) == math.inf:
        wide, tall = 1.0 if wide == math.inf else 0.0, 1.0 if tall == math.inf else 0.0
    backwards = bits_of(x) < 0
    if max(wide, tall) == 0.0:
        return math.copysign(PI.high if backwards else 0.0, y)
    if not backwards and tall <= 2.0**-30 * wide:
        return math.copysign(tall / wide, y)  # the angle is less by a third of its cube
    return math.copysign(_angle(wide, tall, backwards), y)


@inline
def _angle(wide: float, tall: float, backwards: bool) -> float:
    """The angle of (wide, tall), or of (-wide, tall): neither is negative, not both are zero."""
    steep = tall > wide
    more, less = (tall, wide) if steep else (wide, tall)
    k = exponent_of(more)
    slope, t, rest = _reduced(scaled_by_power(more, -k), scaled_by_power(less, -k))
    rest += t * (t * t) * polynomial(t * t, ATAN)
    start = HALF_PI if steep else (PI if backwards else ZERO)
    turn = -1.0 if steep != backwards else 1.0
    high, low = two_sum(start.high, turn * slope.high)
    low += start.low + turn * slope.low
    high, lower = quick_sum(high, turn * t)
    return high + (lower + (low + turn * rest))


@inline
def _reduced(more: float, less: float) -> tuple[Pair, float, float]:
    """(a, t, rest) with atan(less / more) = a + atan(t + rest): a is that of 0, 1/2 or 1, and |t| <= 1/4.

    tan(b - a) is (less - more tan a) / (more + less tan a).
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
