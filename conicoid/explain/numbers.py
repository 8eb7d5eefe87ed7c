"""Numbers as they are told, and square roots of fractions."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from decimal import Context, Decimal
from fractions import Fraction

_DIGITS = Context(prec=80, Emin=-(10**9), Emax=10**9)
MINUS = "−"


def told(value: float) -> str:
    """A float in the shortest decimals that name it."""
    if math.isinf(value):
        return "∞" if value > 0 else f"{MINUS}∞"
    text = repr(float(value) + 0.0).removesuffix(".0")
    return text.replace("-", MINUS, 1) if text.startswith("-") else text


def rounded(value: Fraction) -> str:
    """A fraction, rounded to a float once."""
    return told(as_float(value))


def vector(values: Iterable[float | Fraction]) -> str:
    """(x, y, z)"""
    return f"({', '.join(told(as_float(value)) for value in values)})"


def as_float(value: float | Fraction) -> float:
    """The nearest float; infinite beyond the largest."""
    try:
        return float(value)
    except OverflowError:
        return math.copysign(math.inf, value)


def root(value: Fraction) -> Fraction:
    """√value to 80 digits; exact where it is a fraction of small integers."""
    up, down = math.isqrt(value.numerator), math.isqrt(value.denominator)
    if up * up == value.numerator and down * down == value.denominator:
        return Fraction(up, down)
    quotient = _DIGITS.divide(Decimal(value.numerator), Decimal(value.denominator))
    return Fraction(_DIGITS.sqrt(quotient))


def dot(a: Sequence[Fraction], b: Sequence[Fraction]) -> Fraction:
    """a·b"""
    return sum((x * y for x, y in zip(a, b, strict=True)), Fraction(0))


def along(origin: Sequence[Fraction], t: Fraction, direction: Sequence[Fraction]) -> list[Fraction]:
    """o + t d"""
    return [o + t * d for o, d in zip(origin, direction, strict=True)]


def short(value: float) -> str:
    """At most six digits, for equations that are to be read."""
    text = told(value)
    return text if len(text) <= 9 else f"{value:.6g}".replace("-", MINUS, 1)
