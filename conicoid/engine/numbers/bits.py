"""Exponents and neighbours of floats, by their bits: no function of the C library, so the same everywhere."""

from __future__ import annotations

from ...compiler.jit import bits_of, inline, of_bits

_FRACTION = 52
_BIAS = 1023
_FIRST_NORMAL = 2.0**-1022


@inline
def power_of_two(k: int) -> float:
    """2^k, for k from -1022 to 1023."""
    return of_bits((k + _BIAS) << _FRACTION)


@inline
def exponent_of(x: float) -> int:
    """The k with 2^k <= |x| < 2^(k+1), also of subnormal numbers; x is finite and not zero."""
    if abs(x) < _FIRST_NORMAL:
        return (bits_of(abs(x) * 2.0**54) >> _FRACTION) - (_BIAS + 54)
    return (bits_of(abs(x)) >> _FRACTION) - _BIAS


@inline
def scaled_by_power(x: float, k: int) -> float:
    """x 2^k, for k from -2044 to 2046; in two steps, as 2^k itself may be beyond the floats."""
    half = k >> 1
    return x * power_of_two(half) * power_of_two(k - half)


@inline
def next_above(x: float) -> float:
    """The least float greater than x; infinity and NaN stay."""
    if x == 0.0:
        return 2.0**-1074
    if not x < 2.0**1023 * 2.0:
        return x
    return of_bits(bits_of(x) + (1 if x > 0.0 else -1))


@inline
def next_below(x: float) -> float:
    """The greatest float less than x; minus infinity and NaN stay."""
    return -next_above(-x)
