"""Sines and cosines of degrees to as many bits as are asked for, in whole numbers; exact where they are rational."""

from __future__ import annotations

import math
from fractions import Fraction
from functools import lru_cache

from .number import BITS, ONE, ZERO, Number, Symbol, settled

_GUARD = 64
"""Bits that are worked out beyond those that are asked for: far more than is lost on the way."""
_TOGETHER = 4
"""Terms of a series that are multiplied by one power of an angle's square."""


def sin_cos_degrees(degrees: float) -> tuple[Number, Number]:
    """Sine and cosine of an angle in degrees. Of rational angles they are rational only at multiples of 30 (Niven)."""
    if isinstance(degrees, Symbol):
        return degrees.sine_cosine()
    return _sin_cos_degrees(degrees)


@lru_cache(maxsize=1024)
def _sin_cos_degrees(degrees: float) -> tuple[Number, Number]:
    """`sin_cos_degrees` of a float."""
    angle = Fraction(degrees) % 360
    quarter, rest = divmod(angle, 90)
    half = Number(1, -1)
    if rest == 0:
        s, c = ZERO, ONE
    elif rest <= 45:
        s, c = _up_to_45_degrees(rest)
    else:
        c, s = _up_to_45_degrees(90 - rest)
    s, c = (half if rest == 30 else s), (half if rest == 60 else c)
    for _ in range(int(quarter)):
        s, c = c, -s
    return s, c


def _up_to_45_degrees(angle: Fraction) -> tuple[Number, Number]:
    """Sine and cosine, each to 3000 bits of its own, however small."""
    small = max(0, angle.denominator.bit_length() - angle.numerator.bit_length() + 6)  # angle > 2^-small in radians
    places = BITS + _GUARD + 2 * small
    found = []
    for value in sine_cosine(angle, places):
        more = value.bit_length() - BITS - 32
        found.append(settled(Number(nearest(value, more), more - places, 2)))
    return found[0], found[1]


def nearest(value: int, less: int) -> int:
    """value / 2^less, rounded."""
    return ((value >> (less - 1)) + 1) >> 1


def sine_cosine(angle: Fraction, places: int) -> tuple[int, int]:
    """Sine and cosine, times 2^places, of an angle up to 45 degrees.

    The cosine is off by a few units at most. So is the square of the sine, which for small angles wants more places.

    By the series of 1 - cos of a 2^-halved of the angle, which is then doubled so often, as
    1 - cos 2t = 4 (1 - cos t) - 2 (1 - cos t)²: nothing cancels.
    """
    halved = math.isqrt(places) // 4
    p = places + 2 * halved + 16  # each time an error grows to four times itself
    x = pi(p) * angle.numerator // (180 * angle.denominator) >> halved
    versine = _versine(x * x >> p, p)
    for _ in range(halved):
        versine = (versine << 2) - (versine * versine >> (p - 1))
    less = p - places
    return nearest(math.isqrt(versine * ((2 << p) - versine)), less), nearest((1 << p) - versine, less)


def _versine(square: int, p: int) -> int:
    """1 - cos of an angle whose square is given, all times 2^p: square / 2! - square² / 4! + ...

    Terms that are _TOGETHER apart are summed first, without the power of the square that they lack: most multiply by
    small numbers alone (Smith: Efficient multiple-precision evaluation of elementary functions, Mathematics of
    Computation 52, 1989).
    """
    powers = [1 << p, square]
    for _ in range(_TOGETHER - 1):
        powers.append(powers[-1] * square >> p)
    sums = [0] * _TOGETHER
    term, k = 1 << p, 0
    while term:
        for place in range(_TOGETHER):
            k += 2
            term //= k * (k - 1)
            sums[place] += -term if k & 2 == 0 else term
        term = term * powers[_TOGETHER] >> p
    return sum(power * total for power, total in zip(powers[1:], sums, strict=True)) >> p


@lru_cache(maxsize=4)
def pi(places: int) -> int:
    """pi times 2^places, off by a unit at most: by the series of D. and G. Chudnovsky (1988), 47 bits a term."""
    p = places + 32
    term = total = 13591409 << p
    factor, k = 1 << p, 0
    while term:
        k += 1
        factor = -factor * (6 * k - 5) * (2 * k - 1) * (6 * k - 1) // (k**3 * (640320**3 // 24))
        term = factor * (13591409 + 545140134 * k)
        total += term
    return nearest((426880 * math.isqrt(10005 << 2 * p) << p) // total, 32)
