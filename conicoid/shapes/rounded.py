"""Lengths, roots, sines and tangents for preparing a scene, the same on every system: most are the nearest floats.

Those of Python and NumPy are the C library's or made for a processor, and differ in their last bits. These are slower,
and needed a few times for a scene; kernels have their own (engine/numbers).
"""

from __future__ import annotations

import math
from fractions import Fraction
from functools import lru_cache

import numpy as np

from .vector import FloatArray

_BITS = 256
"""Places of the fixed-point numbers here, besides the zeros that a small number begins with."""
_SPLIT = 2.0**27 + 1.0


def hypot(*values: float) -> float:
    """sqrt(Σ values²), whatever the squares are; rounded from 100 bits and more."""
    largest = max(map(abs, values))
    if not 0.0 < largest < math.inf:
        return largest
    exponent = math.frexp(largest)[1]
    parts = [part for value in values for part in _square(math.ldexp(value, -exponent))]
    root = math.sqrt(math.fsum(parts))
    square, rest = _square(root)
    return math.ldexp(root + math.fsum((*parts, -square, -rest)) / (2.0 * root), exponent)


def _square(x: float) -> tuple[float, float]:
    """x² as a float and what rounding took from it (Dekker; x of order one, or so small that it does not matter)."""
    square, raised = x * x, _SPLIT * x
    high = raised - (raised - x)
    low = x - high
    return square, ((high * high - square) + 2.0 * high * low) + low * low


def odd_root(values: FloatArray | float, n: int) -> FloatArray:
    """The third or fifth root of positive numbers: roughly by a share of the bits, then by five steps of Newton's."""
    x = np.asarray(values, dtype=np.float64)
    one = np.int64(1023 << 52)
    root: FloatArray = np.asarray((x.view(np.int64) - one) // n + one).view(np.float64)
    for _ in range(5):
        square = root * root
        root = root - (root - x / (square if n == 3 else square * square)) / n
    return root


def sin_cos(angle: float) -> tuple[float, float]:
    """Sine and cosine of an angle in radians, of not much more than a turn."""
    return _rounded(Fraction(angle))


@lru_cache(maxsize=1024)
def sin_cos_degrees(angle: float | Fraction) -> tuple[float, float]:
    """Sine and cosine of an angle in degrees."""
    quarters, rest = divmod(Fraction(angle) % 360, 90)
    s, c = _rounded(rest / 180, times_pi=True) if rest else (0.0, 1.0)
    for _ in range(int(quarters)):
        s, c = c, -s
    return s + 0.0, c + 0.0


def tan_degrees(angle: float) -> float:
    """Tangent of an angle in degrees between 0 and 90."""
    s, c, _ = _scaled(Fraction(angle) / 180, times_pi=True)
    return float(Fraction(s, c))


def _rounded(angle: Fraction, times_pi: bool = False) -> tuple[float, float]:
    s, c, places = _scaled(angle, times_pi)
    return float(Fraction(s, 1 << places)), float(Fraction(c, 1 << places))


def _scaled(angle: Fraction, times_pi: bool) -> tuple[int, int, int]:
    """(sine, cosine, places) of an angle in radians, or in half turns: both times 2^places, by their series."""
    places = _BITS + max(0, angle.denominator.bit_length() - abs(angle.numerator).bit_length())
    unit = _pi(places) if times_pi else 1 << places
    x = angle.numerator * unit // angle.denominator
    sums, term, n = [1 << places, 0], 1 << places, 0
    while term not in (0, -1):
        n += 1
        term = (term * x >> places) // n
        sums[n & 1] += term if n & 2 == 0 else -term
    return sums[1], sums[0], places


@lru_cache(maxsize=16)
def _pi(places: int) -> int:
    """pi 2^places, by Machin's formula: 16 arctan 1/5 - 4 arctan 1/239."""
    return (16 * _arctan_of_inverse(5, places + 16) - 4 * _arctan_of_inverse(239, places + 16)) >> 16


def _arctan_of_inverse(n: int, places: int) -> int:
    power = total = (1 << places) // n
    k = 1
    while power:
        power //= -n * n
        k += 2
        total += power // k
    return total
