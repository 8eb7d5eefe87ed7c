"""Numbers of the reference: 90 decimal digits, in a context of our own."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction
from typing import Any

from mpmath import MPContext

mp = MPContext()
mp.dps = 90
ZERO, ONE = mp.mpf(0), mp.mpf(1)
NEGLIGIBLE = mp.mpf(10) ** -70
"""A sum this much smaller than its largest term is zero on paper."""


def number(value: Any) -> Any:
    """A float or an integer exactly, a fraction to 90 digits."""
    if isinstance(value, Fraction):
        return mp.mpf(value.numerator) / value.denominator
    return mp.mpf(value) if isinstance(value, (int, mp.mpf)) else mp.mpf(float(value))


def vector(values: Iterable[Any]) -> tuple[Any, ...]:
    return tuple(number(v) for v in values)


def total(terms: Sequence[Any]) -> Any:
    """The sum, zero where the terms cancel to within 70 digits."""
    result = sum(terms, ZERO)
    if result and abs(result) < NEGLIGIBLE * max(abs(t) for t in terms):
        return ZERO
    return result


def dot(a: Sequence[Any], b: Sequence[Any]) -> Any:
    return total([x * y for x, y in zip(a, b, strict=True)])


def cross(a: Sequence[Any], b: Sequence[Any]) -> tuple[Any, ...]:
    return (
        total([a[1] * b[2], -a[2] * b[1]]),
        total([a[2] * b[0], -a[0] * b[2]]),
        total([a[0] * b[1], -a[1] * b[0]]),
    )


def length(a: Sequence[Any]) -> Any:
    return mp.sqrt(dot(a, a))


def unit(a: Sequence[Any]) -> tuple[Any, ...]:
    size = length(a)
    return tuple(x / size for x in a)


def minus(a: Sequence[Any], b: Sequence[Any]) -> tuple[Any, ...]:
    return tuple(x - y for x, y in zip(a, b, strict=True))


def plus(a: Sequence[Any], b: Sequence[Any], times: Any = 1) -> tuple[Any, ...]:
    """a + times b"""
    return tuple(x + times * y for x, y in zip(a, b, strict=True))


def sine_cosine(degrees: Any) -> tuple[Any, Any]:
    """Exact at multiples of 90 degrees."""
    angle = number(degrees)
    quarters = angle / 90
    if quarters == mp.floor(quarters):
        return ((ZERO, ONE), (ONE, ZERO), (ZERO, -ONE), (-ONE, ZERO))[int(quarters) % 4]
    return mp.sin(angle * mp.pi / 180), mp.cos(angle * mp.pi / 180)
