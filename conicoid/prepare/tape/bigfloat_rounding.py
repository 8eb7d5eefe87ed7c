"""Round a number of `bigfloat_kernel` to the nearest float, where its interval leaves no doubt (Ziv's test)."""

from __future__ import annotations

from ..._jit.decorators import helper, inline
from ...kernels.numbers.double_double import scale_by_power
from ...kernels.tables import Longs
from .bigfloat_kernel import BITS, COUNT, EXACT, EXPONENT, LIMBS, OFF, SIGN, add, copy, is_sure, magnitude, set_float


@helper
def _nearest(w: Longs, a: int) -> tuple[float, int]:
    """Return (m, k), where m 2^k is the number of 53 bits nearest to |a| (not zero); of two the even one."""
    last = magnitude(w, a) - 53
    first = last // BITS
    down = last - first * BITS
    whole = 0
    for k in range(3):  # 53 bits from place `last` on
        at = first + k - w[a, EXPONENT]
        limb = w[a, at] if 0 <= at < w[a, COUNT] else 0
        shift = BITS * k - down
        whole |= limb << shift if shift >= 0 else limb >> -shift
    half = (last - 1) // BITS - w[a, EXPONENT]  # the limb with the first bit that is left out
    if 0 <= half < w[a, COUNT]:
        place = last - 1 - (half + w[a, EXPONENT]) * BITS
        if (w[a, half] >> place) & 1:
            rest = (whole & 1) | (w[a, half] & ((1 << place) - 1))
            for k in range(half):
                rest |= w[a, k]
            whole += 1 if rest != 0 else 0
    return float(whole), last


@inline
def _is_clear(w: Longs, a: int) -> bool:
    """Return whether the interval of a number of five limbs or more holds no float, and no midpoint of two floats.

    That is certain where the 40 bits after its first 54 are not all equal, and its error is smaller than these.
    """
    last = magnitude(w, a) - 54
    if w[a, OFF] > last - 40:
        return False
    k = last // BITS - w[a, EXPONENT]
    up = last - (k + w[a, EXPONENT]) * BITS
    rest = ((w[a, k] & ((1 << up) - 1)) << BITS) | w[a, k - 1]  # the up + 28 bits that follow
    rest = ((rest << 16) | (w[a, k - 2] >> 12)) >> (up + 4) if up < 12 else rest >> (up - 12)
    return 1 < rest < (1 << 40) - 2


@helper
def round_bigfloat(w: Longs, a: int, free: int, t: Longs) -> tuple[float, bool]:
    """Return (the float nearest to a, is it certain); never certain for subnormal results, or beyond the floats.

    It is certain where both ends of the interval round alike. Uses three numbers from `free` on.
    """
    if w[a, COUNT] == 0:
        return 0.0, w[a, OFF] == EXACT
    if w[a, OFF] == EXACT or (w[a, COUNT] > 4 and _is_clear(w, a)):
        value, power = _nearest(w, a)
    else:
        if not is_sure(w, a):
            return 0.0, False
        set_float(w, free, 1.0, max(w[a, OFF], BITS * (w[a, EXPONENT] + w[a, COUNT] - LIMBS + 1)))
        copy(w, free + 1, a)
        w[free + 1, OFF], w[free + 1, SIGN] = EXACT, 1
        add(w, free + 2, free + 1, free, -1, t)
        add(w, free + 1, free + 1, free, 1, t)
        if w[free + 1, OFF] != EXACT or w[free + 2, OFF] != EXACT or w[free + 2, COUNT] == 0:
            return 0.0, False
        value, power = _nearest(w, free + 2)
        other, its_power = _nearest(w, free + 1)
        if (value != other or power != its_power) and not (its_power == power + 1 and value == 2.0 * other):
            return 0.0, False
    if power < -1022 or power > 970:
        return 0.0, False
    return float(w[a, SIGN]) * scale_by_power(value, power), True
