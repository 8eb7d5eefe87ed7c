"""Rational numbers, and what is irrational on paper as a rational beside it by less than one part in 2^3000."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction
from typing import Any

from flint import arb, ctx, fmpq, fmpz

BITS = 3000
VANISHED = fmpq(1, fmpz(1) << 2500)
"""A sum of inexact terms this much smaller than its largest is zero on paper."""
ZERO, ONE = fmpq(0), fmpq(1)


def exactly(value: Any) -> fmpq:
    """A float, integer or fraction as it is."""
    if isinstance(value, fmpq):
        return value
    if isinstance(value, (int, fmpz)):
        return fmpq(value)
    fraction = value if isinstance(value, Fraction) else Fraction(float(value))
    return fmpq(fraction.numerator, fraction.denominator)


def vector(values: Iterable[Any]) -> tuple[fmpq, ...]:
    return tuple(exactly(v) for v in values)


def total(terms: Iterable[fmpq], exact: bool = True) -> fmpq:
    """The sum; of inexact terms rounded to BITS bits, and zero where they cancel."""
    terms = list(terms)
    result = sum(terms, ZERO)
    if exact or not result:
        return result
    if abs(result) < VANISHED * max(abs(t) for t in terms):
        return ZERO
    return rounded(result)


def rounded(value: fmpq) -> fmpq:
    """To BITS bits; what is shorter stays."""
    top, bottom = value.p, value.q
    if top.height_bits() + bottom.height_bits() <= BITS:
        return value
    shift = BITS - top.height_bits() + bottom.height_bits()
    if shift >= 0:
        return fmpq((2 * (top << shift) + bottom) // (2 * bottom), fmpz(1) << shift)
    scaled = bottom << -shift
    return fmpq((2 * top + scaled) // (2 * scaled) << -shift)


def dot(a: Sequence[fmpq], b: Sequence[fmpq], exact: bool = True) -> fmpq:
    return total((x * y for x, y in zip(a, b, strict=True)), exact)


def cross(a: Sequence[fmpq], b: Sequence[fmpq], exact: bool = True) -> tuple[fmpq, ...]:
    pairs = ((1, 2), (2, 0), (0, 1))
    return tuple(total((a[i] * b[j], -a[j] * b[i]), exact) for i, j in pairs)


def minus(a: Sequence[fmpq], b: Sequence[fmpq]) -> tuple[fmpq, ...]:
    return tuple(x - y for x, y in zip(a, b, strict=True))


def root(value: fmpq) -> tuple[fmpq, bool]:
    """(square root, whether it is rational)"""
    if value.p.is_square() and value.q.is_square():
        return fmpq(value.p.isqrt(), value.q.isqrt()), True
    with ctx.workprec(BITS + 20):
        return of_ball(arb(value).sqrt()), False


def sine_cosine(degrees: Any) -> tuple[fmpq, fmpq, bool]:
    """(sine, cosine, whether they are exact: at multiples of 90 degrees)"""
    half_turns = exactly(degrees) / 180
    quarters = 2 * half_turns
    if quarters.q == 1:
        s, c = ((0, 1), (1, 0), (0, -1), (-1, 0))[int(quarters.p) % 4]
        return fmpq(s), fmpq(c), True
    with ctx.workprec(BITS + 20):
        return of_ball(arb.sin_pi_fmpq(half_turns)), of_ball(arb.cos_pi_fmpq(half_turns)), False


def of_ball(ball: arb) -> fmpq:
    """Its middle."""
    mantissa, exponent = ball.mid().man_exp()
    exponent = int(exponent)
    return fmpq(mantissa << exponent) if exponent >= 0 else fmpq(mantissa, fmpz(1) << -exponent)
