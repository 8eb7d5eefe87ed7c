"""Arithmetic for baking motions into surfaces: 3000 bits, rounded to float64 once, at the end.

All numbers a user writes are binary, so sums and products of a few of them are exact here; only square
roots, sines and quotients are not, by a relative 2^-3000. A sum whose terms cancel down towards that
level is zero in exact arithmetic and is made zero here (`dot`), so that two chains of motions
that are equal on paper give equal numbers, and a turn by 90 degrees gives exact zeros and ones.

Between 1e-100 and 1e100 lie 665 binary places: sums of squares of such numbers, and sums of products of four,
need more than 1330 and 2660 bits for what may be left of them. What cancels by 2^-2200 is nothing (`CANCELLED`).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction
from functools import lru_cache
from typing import Any, TypeAlias

from mpmath import MPContext

Exact: TypeAlias = Any
Number: TypeAlias = float | int | Fraction | Any
Row: TypeAlias = tuple[Exact, Exact, Exact]
Rows: TypeAlias = tuple[Row, Row, Row]

context = MPContext()
BITS, CANCELLED = 3000, 2200
context.prec = BITS

ZERO, ONE = context.mpf(0), context.mpf(1)
IDENTITY: Rows = ((ONE, ZERO, ZERO), (ZERO, ONE, ZERO), (ZERO, ZERO, ONE))


def exact(value: Number) -> Exact:
    """`value` as such a number; floats and integers exactly, fractions rounded there."""
    if isinstance(value, Fraction):
        return context.mpf(value.numerator) / value.denominator
    return context.mpf(value)


def exact_row(values: Iterable[Number]) -> Row:
    x, y, z = values
    return exact(x), exact(y), exact(z)


def dot(a: Sequence[Exact], b: Sequence[Exact], *more: Exact) -> Exact:
    """a·b plus any further terms; zero where the terms cancel to nothing."""
    terms = [x * y for x, y in zip(a, b, strict=True)]
    terms.extend(more)
    return cancelling_sum(terms)


def cancelling_sum(terms: Sequence[Exact]) -> Exact:
    """The sum; zero where it is less than 2^-2200 of a term."""
    total = context.fsum(terms)
    if total and max(_places(term) for term in terms) - _places(total) > CANCELLED:
        return ZERO
    return total


def _places(value: Exact) -> int:
    """n with 2^(n - 1) <= |value| < 2^n; of zero less than that of any number."""
    _, mantissa, exponent, bits = value._mpf_
    return int(exponent + bits) if mantissa else -(1 << 40)


def cross(a: Row, b: Row) -> Row:
    return (
        dot((a[1], -a[2]), (b[2], b[1])),
        dot((a[2], -a[0]), (b[0], b[2])),
        dot((a[0], -a[1]), (b[1], b[0])),
    )


def unit(a: Row) -> Row:
    length = context.sqrt(dot(a, a))
    return a[0] / length, a[1] / length, a[2] / length


def apply(rows: Rows, point: Row) -> Row:
    return dot(rows[0], point), dot(rows[1], point), dot(rows[2], point)


def transpose(rows: Rows) -> Rows:
    return (
        (rows[0][0], rows[1][0], rows[2][0]),
        (rows[0][1], rows[1][1], rows[2][1]),
        (rows[0][2], rows[1][2], rows[2][2]),
    )


def multiply(a: Rows, b: Rows) -> Rows:
    columns = transpose(b)
    return apply(columns, a[0]), apply(columns, a[1]), apply(columns, a[2])


def determinant(rows: Rows) -> Exact:
    return dot(rows[0], cross(rows[1], rows[2]))


def inverse(rows: Rows) -> Rows:
    """The inverse by cofactors; the caller has seen to it that it exists."""
    d = determinant(rows)
    cofactors = (cross(rows[1], rows[2]), cross(rows[2], rows[0]), cross(rows[0], rows[1]))
    x, y, z = transpose(cofactors)
    return (
        (x[0] / d, x[1] / d, x[2] / d),
        (y[0] / d, y[1] / d, y[2] / d),
        (z[0] / d, z[1] / d, z[2] / d),
    )


def rounded(value: Exact) -> float:
    """The nearest float64."""
    return float(value)


@lru_cache(maxsize=1024)
def sin_cos_degrees(degrees: float) -> tuple[Exact, Exact]:
    """Sine and cosine of an angle in degrees, exact at multiples of 90."""
    angle = exact(degrees) % 360
    rest = angle % 90
    quarter = int(context.nint((angle - rest) / 90))
    if rest:
        c, s = context.cos_sin(context.radians(rest))
    else:
        s, c = ZERO, ONE
    for _ in range(quarter):
        s, c = c, -s
    return s, c
