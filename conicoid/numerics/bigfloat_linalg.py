"""Linear algebra with `BigFloat`, for motions of surfaces; results are rounded to float64 once, at the end.

Sums are settled: terms that cancel to a possible zero are zero, and a result that may be a short binary number is that
number. So two chains of motions that are equal on paper give equal numbers, a rotation times its transpose is the
identity, and a turn by 90 degrees gives exact zeros and ones.

Between 1e-100 and 1e100 lie 665 binary places: sums of squares of such numbers, and sums of products of four, need
more than 1330 and 2660 bits for their possible remainder.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TypeAlias

from .bigfloat import (
    BITS,
    ONE,
    ZERO,
    BigFloat,
    Writable,
    cut,
    exact,
    fraction,
    is_nothing,
    is_rounded,
    power_of_two,
    rational,
    rounded,
    settled,
    simplest_ratio,
    sin_cos_degrees,
    sqrt,
    total,
)

__all__ = [
    "BITS", "CANCELLED", "IDENTITY", "ONE", "ZERO", "BigFloat", "Row", "Rows", "Writable", "apply", "cancelling_sum",
    "cross", "cut", "determinant", "dot", "exact", "exact_row", "fraction", "inverse", "is_rounded", "minus",
    "multiply", "plus", "power_of_two", "rational", "rounded", "settled", "simplest_ratio", "sin_cos_degrees",
    "sqrt", "total", "transpose", "unit",
]  # fmt: skip

Row: TypeAlias = tuple[BigFloat, BigFloat, BigFloat]
Rows: TypeAlias = tuple[Row, Row, Row]

CANCELLED = 2200
"""Components of eigenvectors below 2^-2200 of their length are noise."""

IDENTITY: Rows = ((ONE, ZERO, ZERO), (ZERO, ONE, ZERO), (ZERO, ZERO, ONE))


def exact_row(values: Iterable[Writable]) -> Row:
    """Return three numbers as a row."""
    x, y, z = values
    return exact(x), exact(y), exact(z)


def dot(a: Sequence[BigFloat], b: Sequence[BigFloat], *more: BigFloat) -> BigFloat:
    """Return a·b plus any further terms, settled."""
    # Zeros are frequent, and their products would only cost time.
    terms = [x * y for x, y in zip(a, b, strict=True) if not (is_nothing(x) or is_nothing(y))]
    terms.extend(more)
    return settled(total(terms))


def cancelling_sum(terms: Sequence[BigFloat]) -> BigFloat:
    """Return the sum, settled."""
    return settled(total(terms))


def plus(a: Row, b: Row) -> Row:
    """Return a + b, settled."""
    return cancelling_sum((a[0], b[0])), cancelling_sum((a[1], b[1])), cancelling_sum((a[2], b[2]))


def minus(a: Row, b: Row) -> Row:
    """Return a - b, settled."""
    return cancelling_sum((a[0], -b[0])), cancelling_sum((a[1], -b[1])), cancelling_sum((a[2], -b[2]))


def cross(a: Row, b: Row) -> Row:
    """Return the cross product, settled."""
    return (
        dot((a[1], -a[2]), (b[2], b[1])),
        dot((a[2], -a[0]), (b[0], b[2])),
        dot((a[0], -a[1]), (b[1], b[0])),
    )


def unit(a: Row) -> Row:
    """Return a row at unit length."""
    length = sqrt(dot(a, a))
    return a[0] / length, a[1] / length, a[2] / length


def apply(rows: Rows, point: Row) -> Row:
    """Return the product of a matrix and a point."""
    return dot(rows[0], point), dot(rows[1], point), dot(rows[2], point)


def transpose(rows: Rows) -> Rows:
    """Return the transpose."""
    return (
        (rows[0][0], rows[1][0], rows[2][0]),
        (rows[0][1], rows[1][1], rows[2][1]),
        (rows[0][2], rows[1][2], rows[2][2]),
    )


def multiply(a: Rows, b: Rows) -> Rows:
    """Return the product of two matrices."""
    columns = transpose(b)
    # Row i of the product is row i of a times b: each column of b is one dot product.
    return apply(columns, a[0]), apply(columns, a[1]), apply(columns, a[2])


def determinant(rows: Rows) -> BigFloat:
    """Return the determinant."""
    return dot(rows[0], cross(rows[1], rows[2]))


def inverse(rows: Rows) -> Rows:
    """Return the inverse by cofactors; the caller ensures that it exists."""
    d = determinant(rows)
    cofactors = (cross(rows[1], rows[2]), cross(rows[2], rows[0]), cross(rows[0], rows[1]))
    x, y, z = transpose(cofactors)
    return (
        (x[0] / d, x[1] / d, x[2] / d),
        (y[0] / d, y[1] / d, y[2] / d),
        (z[0] / d, z[1] / d, z[2] / d),
    )
