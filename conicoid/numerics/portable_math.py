"""Lengths, roots, sines and tangents for preparing a scene, equal on every system; most are the nearest floats.

Those of Python and NumPy depend on the C library or the processor and differ in their last bits. These are slower,
and a scene needs them a few times; kernels have their own (kernels/numbers).
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterable, Sequence
from fractions import Fraction
from functools import lru_cache
from typing import Any

import numpy as np

from .._util.records import FloatArray
from .bigfloat import BigFloat, Symbol, exact, rounded, sin_cos_degrees as exact_sin_cos, sqrt, total
from .tracing import TracedBig, TracedFloat

_BITS = 256
"""Places of the fixed-point numbers here, besides the leading zeros of a small number."""
_SPLIT = 2.0**27 + 1.0
"""Dekker's factor, which splits a float into halves of 26 bits."""


def hypot(*values: float) -> float:
    """Return sqrt(Σ values²), even if squares overflow or vanish; rounded from 100 bits and more."""
    if _is_recorded(values):
        return rounded(sqrt(total(exact(value) * value for value in values)))
    largest = max(map(abs, values))
    if not 0.0 < largest < math.inf:
        return largest
    # Scale by a power of two, which rounds nothing; then one Newton step with the exact residual.
    exponent = math.frexp(largest)[1]
    parts = [part for value in values for part in _square(math.ldexp(value, -exponent))]
    root = math.sqrt(math.fsum(parts))
    square, rest = _square(root)
    return math.ldexp(root + math.fsum((*parts, -square, -rest)) / (2.0 * root), exponent)


def _square(x: float) -> tuple[float, float]:
    """Return x² as a float and its rounding error (Dekker; for x of order one, or so small that it does not matter)."""
    square, raised = x * x, _SPLIT * x
    high = raised - (raised - x)
    low = x - high
    return square, ((high * high - square) + 2.0 * high * low) + low * low


def odd_root(values: FloatArray | float, n: int) -> FloatArray:
    """Return the third or fifth root of positive numbers: a first guess from the bits, then five Newton steps."""
    x = np.asarray(values, dtype=np.float64)
    # The bits of 1.0: a division of the bits beyond it divides the exponent.
    one = np.int64(1023 << 52)
    root: FloatArray = np.asarray((x.view(np.int64) - one) // n + one).view(np.float64)
    for _ in range(5):
        square = root * root
        root = root - (root - x / (square if n == 3 else square * square)) / n
    return root


def sin_cos(angle: float) -> tuple[float, float]:
    """Return sine and cosine of an angle in radians, of not much more than a turn."""
    return _rounded(Fraction(angle))


# Functions of floats that also take recorded numbers (tracing.py). Without a test they give one tape for all bodies.


def portable_sqrt(x: Any) -> float:
    """Return the square root."""
    return x.root() if isinstance(x, Symbol) else math.sqrt(x)


def is_float(x: Any) -> bool:
    """Return whether a value is a float or an integer, or a recorded float."""
    return isinstance(x, (float, int)) or (isinstance(x, Symbol) and not isinstance(x, BigFloat))


def is_finite(x: Any) -> bool:
    """Return `math.isfinite`; recorded numbers are finite, as they are made of numbers below 1e100."""
    return isinstance(x, Symbol) or math.isfinite(x)


def power_of_two_scale(x: Any) -> float:
    """Return 2^n that brings a positive number between 1/2 and 1; 1 for zero."""
    if not x:
        return 1.0
    return x.power() if isinstance(x, TracedFloat) else math.ldexp(1.0, -math.frexp(x)[1])


def next_float(x: Any) -> float:
    """Return the next float above."""
    return x.above() if isinstance(x, TracedFloat) else math.nextafter(x, math.inf)


def next_float_if(x: Any, lost: Any) -> float:
    """Return the next float above if something positive was lost, else x."""
    if isinstance(x, TracedFloat):
        return x.above_if(lost)
    return math.nextafter(x, math.inf) if lost > 0 else float(x)


def portable_max(a: Any, b: Any) -> float:
    """Return `max(a, b)`: no test in a recorded formula, and without a derivative where both are equal."""
    result: float
    if isinstance(a, Symbol):
        result = a.larger(b)
    else:
        result = b.larger(a, first=False) if isinstance(b, Symbol) else max(a, b)
    return result


def portable_scale(values: Iterable[Any]) -> float:
    """Return the largest value, as a unit for the others: it has no derivatives, on which nothing may depend."""
    largest = functools.reduce(portable_max, values)
    return largest.constant() if isinstance(largest, Symbol) else largest


def rounded_sum(terms: Iterable[Any]) -> float:
    """Return the float nearest to a sum."""
    items = list(terms)
    if _is_recorded(items):
        return rounded(total(map(exact, items)))
    return math.fsum(items)


def leading_sign(values: Sequence[Any]) -> float:
    """Return -1 if the first nonzero value is negative, else 1."""
    zero = _zero(values)
    if zero is not None:
        return functools.reduce(lambda value, other: value.leading(other), values, zero).unit_sign()
    return -1.0 if next((value for value in values if value), 0.0) < 0 else 1.0


def negative_indicator(value: Any) -> Any:
    """Return 1.0 for a negative float or `BigFloat`, else 0.0; no test in a recorded formula.

    A number times these is itself, or an exact zero (`kernels.numbers.quad_double`): so they select one of two numbers.
    """
    if isinstance(value, (TracedFloat, TracedBig)):
        return 0.5 - 0.5 * value.rounded().unit_sign()
    return 1.0 if value < 0 else 0.0


def least_axis(values: Sequence[Any]) -> tuple[Any, Any, Any]:
    """Return the coordinate axis along which a vector is least, the first of several: two zeros and a one; no test."""
    a, b, c = map(abs, values)
    second = negative_indicator(b - a)
    x, y = (1.0 - second) * (1.0 - negative_indicator(c - a)), second * (1.0 - negative_indicator(c - b))
    return x, y, 1.0 - x - y


def count_nonzero(values: Sequence[Any]) -> Any:
    """Return the number of nonzero values."""
    zero = _zero(values)
    if zero is not None:
        return functools.reduce(lambda count, value: count.counted(value), values, zero)
    return sum(1 for value in values if value)


def select_if_several(count: Any, then: Any, otherwise: Any) -> float:
    """Return the first of two numbers for a count of 2 or more, else the second; no test in a recorded formula."""
    return count.choose(then, otherwise) if isinstance(count, TracedFloat) else then if count >= 2 else otherwise


def _is_recorded(values: Iterable[Any]) -> bool:
    """Return whether any value belongs to a recorded formula."""
    return any(isinstance(value, Symbol) for value in values)


def _zero(values: Iterable[Any]) -> TracedFloat | None:
    """Return zero on the tape of some floats; None if none of them is recorded."""
    return next((value.tape.zero for value in values if isinstance(value, TracedFloat)), None)


# Sines, cosines and tangents in fixed point.


def sin_cos_degrees(angle: Any) -> tuple[float, float]:
    """Return sine and cosine of an angle in degrees."""
    if isinstance(angle, Symbol):
        s, c = exact_sin_cos(angle)  # type: ignore[arg-type]
        return rounded(s), rounded(c)
    return _sin_cos_degrees(angle)


@lru_cache(maxsize=1024)
def _sin_cos_degrees(angle: float | Fraction) -> tuple[float, float]:
    """Return `sin_cos_degrees` of a number: exact at multiples of 90."""
    quarters, rest = divmod(Fraction(angle) % 360, 90)
    s, c = _rounded(rest / 180, times_pi=True) if rest else (0.0, 1.0)
    for _ in range(int(quarters)):
        s, c = c, -s
    return s + 0.0, c + 0.0  # -0 becomes 0


def tan_degrees(angle: float) -> float:
    """Return the tangent of an angle in degrees between 0 and 90."""
    s, c, _ = _sin_cos_fixed_point(Fraction(angle) / 180, times_pi=True)
    return float(Fraction(s, c))


def _rounded(angle: Fraction, times_pi: bool = False) -> tuple[float, float]:
    """Return sine and cosine as floats."""
    s, c, places = _sin_cos_fixed_point(angle, times_pi)
    return float(Fraction(s, 1 << places)), float(Fraction(c, 1 << places))


def _sin_cos_fixed_point(angle: Fraction, times_pi: bool) -> tuple[int, int, int]:
    """Return (sine, cosine, places) of an angle in radians, or in half turns: both times 2^places, by their series."""
    # A small angle gets more places, so that its sine has as many significant bits.
    places = _BITS + max(0, angle.denominator.bit_length() - abs(angle.numerator).bit_length())
    unit = _pi(places) if times_pi else 1 << places
    x = angle.numerator * unit // angle.denominator
    sums, term, n = [1 << places, 0], 1 << places, 0
    # Floor division of a negative term ends at -1, not at 0.
    while term not in (0, -1):
        n += 1
        term = (term * x >> places) // n
        sums[n & 1] += term if n & 2 == 0 else -term
    return sums[1], sums[0], places


@lru_cache(maxsize=16)
def _pi(places: int) -> int:
    """Return pi 2^places, by Machin's formula: 16 arctan 1/5 - 4 arctan 1/239."""
    return (16 * _arctan_of_inverse(5, places + 16) - 4 * _arctan_of_inverse(239, places + 16)) >> 16


def _arctan_of_inverse(n: int, places: int) -> int:
    """Return arctan 1/n times 2^places, by its series."""
    power = total = (1 << places) // n
    k = 1
    while power:
        power //= -n * n
        k += 2
        total += power // k
    return total


# Exponentials, logarithms and cosines of arrays, by sums, products and quotients alone.
#
# Those of the C library differ in their last bits between systems; these do not. Their relative error is some 10⁻¹³,
# less than tables of filters and tone curves need.

_HALVINGS = 10
_LN2 = 0.6931471805599453


def portable_exp(x: Any) -> FloatArray:
    """Return e to the x, for |x| up to some hundreds: Taylor's series of x / 1024, squared ten times."""
    small = np.asarray(x, np.float64) / (1 << _HALVINGS)
    value = np.ones_like(small)
    for k in range(9, 0, -1):
        value = 1.0 + value * small / k
    for _ in range(_HALVINGS):
        value = value * value
    return np.asarray(value)


def portable_log2(x: Any) -> FloatArray:
    """Return log2 of positive numbers: exponent + 2 artanh z / ln 2, z = (m - 1) / (m + 1) of the mantissa m."""
    m, exponent = np.frexp(np.asarray(x, np.float64))
    low = m < math.sqrt(0.5)
    # Move m to [√½, √2), where z is small and the series short.
    m, exponent = np.where(low, 2.0 * m, m), exponent - low
    z = (m - 1.0) / (m + 1.0)
    square, total = z * z, np.zeros_like(z)
    for k in range(23, 0, -2):
        total = total * square + 1.0 / k
    return np.asarray(exponent + (2.0 / _LN2) * (z * total))


def portable_cos(t: Any) -> FloatArray:
    """Return cos t for 0 <= t <= 2π: of (t - π) / 8 by Taylor's series, doubled three times."""
    s = (np.asarray(t, np.float64) - math.pi) / 8.0
    square, value = s * s, np.ones_like(s)
    for k in range(16, 0, -2):
        value = 1.0 - value * square / (k * (k - 1))
    for _ in range(3):
        value = 2.0 * value * value - 1.0
    return np.asarray(-value)


def portable_exp2(stops: float) -> float:
    """Return 2 to a number, exactly for whole ones."""
    whole = math.floor(stops)
    return math.ldexp(float(portable_exp((stops - whole) * _LN2)), whole)


def portable_interp(x: FloatArray, places: FloatArray, values: FloatArray) -> FloatArray:
    """Interpolate between values at rising places, as `numpy.interp`, whose compiler may fuse a product with a sum."""
    k = np.clip(np.searchsorted(places, x, side="right") - 1, 0, len(places) - 2)
    low, high = places[k], places[k + 1]
    share = (x - low) / np.where(high > low, high - low, 1.0)
    return np.asarray(values[k] + np.clip(share, 0.0, 1.0) * (values[k + 1] - values[k]))
