"""Lengths, roots, sines and tangents for preparing a scene, the same on every system: most are the nearest floats.

Those of Python and NumPy are the C library's or made for a processor, and differ in their last bits. These are slower,
and needed a few times for a scene; kernels have their own (engine/numbers).
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterable, Sequence
from fractions import Fraction
from functools import lru_cache
from typing import Any

import numpy as np

from .number import Number, Symbol, exact, rounded, sqrt, total
from .sines import sin_cos_degrees as exact_sin_cos
from .traced import Plain, Wide
from .vector import FloatArray

_BITS = 256
"""Places of the fixed-point numbers here, besides the zeros that a small number begins with."""
_SPLIT = 2.0**27 + 1.0


def hypot(*values: float) -> float:
    """sqrt(Σ values²), whatever the squares are; rounded from 100 bits and more."""
    if _is_recorded(values):
        return rounded(sqrt(total(exact(value) * value for value in values)))
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


def root(x: Any) -> float:
    """The square root."""
    result: float = x.root() if isinstance(x, Symbol) else math.sqrt(x)
    return result


def is_float(x: Any) -> bool:
    """Is it a float or an integer, or one of them in a formula that is being recorded?"""
    return isinstance(x, (float, int)) or (isinstance(x, Symbol) and not isinstance(x, Number))


def is_finite(x: Any) -> bool:
    """`math.isfinite`; what is recorded is finite, as the numbers that it is made of are below 1e100."""
    return isinstance(x, Symbol) or math.isfinite(x)


def scale_of(x: Any) -> float:
    """2^n that brings a positive number between 1/2 and 1; 1 for zero."""
    if not x:
        return 1.0
    result: float = x.power() if isinstance(x, Plain) else math.ldexp(1.0, -math.frexp(x)[1])
    return result


def above(x: Any) -> float:
    """The next float above."""
    result: float = x.above() if isinstance(x, Plain) else math.nextafter(x, math.inf)
    return result


def above_if(x: Any, lost: Any) -> float:
    """The next float above where something positive was lost, else x."""
    if isinstance(x, Plain):
        result: float = x.above_if(lost)
        return result
    return math.nextafter(x, math.inf) if lost > 0 else float(x)


def larger(a: Any, b: Any) -> float:
    """`max(a, b)`, which is no test where a formula is recorded, and has no derivative where they are equal."""
    result: float
    if isinstance(a, Symbol):
        result = a.larger(b)
    else:
        result = b.larger(a, first=False) if isinstance(b, Symbol) else max(a, b)
    return result


def sum_of(terms: Iterable[Any]) -> float:
    """The float nearest to a sum."""
    items = list(terms)
    if _is_recorded(items):
        return rounded(total(map(exact, items)))
    return math.fsum(items)


def sign_of_first(values: Sequence[Any]) -> float:
    """-1 where the first of them that is not zero is negative, else 1."""
    zero = _zero(values)
    if zero is not None:
        result: float = functools.reduce(lambda value, other: value.leading(other), values, zero).unit_sign()
        return result
    return -1.0 if next((value for value in values if value), 0.0) < 0 else 1.0


def is_negative(value: Any) -> Any:
    """1.0 where a float or a number of many digits is negative, else 0.0; no test where a formula is recorded.

    Times these a number is itself, or an exact zero (`engine.numbers.fourfold`): so they choose one of two numbers.
    """
    if isinstance(value, (Plain, Wide)):
        return 0.5 - 0.5 * value.rounded().unit_sign()
    return 1.0 if value < 0 else 0.0


def along_least(values: Sequence[Any]) -> tuple[Any, Any, Any]:
    """The coordinate axis along which a vector is least, the first of several: two zeros and a one; no test."""
    a, b, c = map(abs, values)
    second = is_negative(b - a)
    x, y = (1.0 - second) * (1.0 - is_negative(c - a)), second * (1.0 - is_negative(c - b))
    return x, y, 1.0 - x - y


def count_of(values: Sequence[Any]) -> Any:
    """How many of them are not zero."""
    zero = _zero(values)
    if zero is not None:
        return functools.reduce(lambda count, value: count.counted(value), values, zero)
    return sum(1 for value in values if value)


def if_several(count: Any, then: Any, otherwise: Any) -> float:
    """The first of two numbers where a count is 2 or more, else the second; no test where a formula is recorded."""
    result: float = count.choose(then, otherwise) if isinstance(count, Plain) else then if count >= 2 else otherwise
    return result


def _is_recorded(values: Iterable[Any]) -> bool:
    return any(isinstance(value, Symbol) for value in values)


def _zero(values: Iterable[Any]) -> Plain | None:
    """Zero on the tape of some floats; None where none of them is recorded."""
    return next((value.tape.zero for value in values if isinstance(value, Plain)), None)


def sin_cos_degrees(angle: Any) -> tuple[float, float]:
    """Sine and cosine of an angle in degrees."""
    if isinstance(angle, Symbol):
        s, c = exact_sin_cos(angle)  # type: ignore[arg-type]
        return rounded(s), rounded(c)
    return _sin_cos_degrees(angle)


@lru_cache(maxsize=1024)
def _sin_cos_degrees(angle: float | Fraction) -> tuple[float, float]:
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
