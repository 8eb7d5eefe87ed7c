"""Linear algebra over the rational numbers: nothing is rounded."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from fractions import Fraction
from typing import TypeAlias

FractionRow: TypeAlias = Sequence[Fraction]
FractionMatrix: TypeAlias = Sequence[FractionRow]


def dot(a: FractionRow, b: FractionRow) -> Fraction:
    """Return the dot product."""
    return sum((x * y for x, y in zip(a, b, strict=True)), Fraction(0))


def matmul(a: FractionMatrix, b: FractionMatrix) -> list[list[Fraction]]:
    """Return the product of two matrices."""
    columns = list(zip(*b, strict=True))
    return [[dot(row, column) for column in columns] for row in a]


def row_echelon(matrix: FractionMatrix, columns: int) -> tuple[list[list[Fraction]], list[int]]:
    """Return (the reduced row echelon form over the first `columns` columns, the pivots' columns)."""
    rows, pivots = [list(row) for row in matrix], list[int]()
    for column in range(columns):
        rank = len(pivots)
        pivot = next((i for i in range(rank, len(rows)) if rows[i][column]), None)
        if pivot is None:
            continue
        rows[rank], rows[pivot] = rows[pivot], rows[rank]
        rows[rank] = [x / rows[rank][column] for x in rows[rank]]
        for i in range(len(rows)):
            if i != rank and rows[i][column]:
                factor = rows[i][column]
                rows[i] = [x - factor * y for x, y in zip(rows[i], rows[rank], strict=True)]
        pivots.append(column)
    return rows, pivots


def solve(matrix: FractionMatrix, right: FractionRow) -> list[Fraction]:
    """Return x with matrix x = right. Raise ZeroDivisionError for a singular matrix."""
    size = len(matrix)
    rows, pivots = row_echelon([[*row, value] for row, value in zip(matrix, right, strict=True)], size)
    if len(pivots) < size:
        raise ZeroDivisionError("the matrix is singular")
    return [row[size] for row in rows]


def null_space(matrix: FractionMatrix) -> list[list[Fraction]]:
    """Return a basis of all x with matrix x = 0."""
    size = len(matrix[0])
    rows, pivots = row_echelon(matrix, size)
    # One vector for each free column: 1 there, and the pivots solve for the rest.
    basis = []
    for free in sorted(set(range(size)) - set(pivots)):
        vector = [Fraction(int(i == free)) for i in range(size)]
        for row, pivot in zip(rows, pivots, strict=False):
            vector[pivot] = -row[free]
        basis.append(vector)
    return basis


def characteristic_polynomial(matrix: FractionMatrix) -> list[Fraction]:
    """Return the coefficients of det(λ - matrix), that of the highest power (1) first (Faddeev and Le Verrier)."""
    size = len(matrix)
    result, power = [Fraction(1)], [[Fraction(0)] * size for _ in range(size)]
    for k in range(1, size + 1):
        power = matmul(matrix, power)
        for i in range(size):
            power[i][i] += result[-1]
        product = matmul(matrix, power)
        result.append(-sum((product[i][i] for i in range(size)), Fraction(0)) / k)
    return result


def inertia(matrix: FractionMatrix) -> tuple[int, int]:
    """Return the numbers of (positive, negative) eigenvalues of a symmetric matrix.

    No congruence changes them (Sylvester). All roots of the characteristic polynomial are real, so Descartes' rule of
    signs counts them exactly.
    """
    coefficients = characteristic_polynomial(matrix)
    # Trailing zeros are roots at 0, which count as neither.
    while not coefficients[-1]:
        coefficients.pop()
    signs = [value > 0 for value in coefficients if value]
    positive = sum(a != b for a, b in itertools.pairwise(signs))
    return positive, len(coefficients) - 1 - positive


def has_equal_eigenvalues(matrix: FractionMatrix) -> bool:
    """Return whether the discriminant of the characteristic polynomial of a 3 × 3 matrix is zero."""
    _, b, c, d = characteristic_polynomial(matrix)
    return b * b * c * c - 4 * c**3 - 4 * b**3 * d - 27 * d * d + 18 * b * c * d == 0
