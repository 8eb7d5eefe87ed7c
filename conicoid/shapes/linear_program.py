"""The support of an intersection of half-spaces, by the simplex method in rational arithmetic.

sup of d·x over normals x <= offsets is, by duality, the least offsets·λ over λ >= 0 with
Σ λ_i normals_i = d. Three equations and few variables: a small exact tableau with Bland's rule.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import TypeAlias

Numbers: TypeAlias = Sequence[Fraction]


def half_spaces_support(normals: Sequence[Numbers], offsets: Numbers, direction: Numbers) -> Fraction | float:
    """sup of direction·x over all normal·x <= offset: a fraction, inf where unbounded, -inf where empty."""
    if any(direction):
        bound = _least(normals, offsets, direction)
        if bound == -math.inf:
            return bound
    else:
        bound = Fraction(0)
    # Farkas: empty where a vanishing combination of the normals has a negative offset
    return -math.inf if _least(normals, offsets, [Fraction(0)] * 3) == -math.inf else bound


def _least(normals: Sequence[Numbers], offsets: Numbers, direction: Numbers) -> Fraction | float:
    """min offsets·λ over λ >= 0, Σ λ_i normals_i = direction; inf where there is no such λ, -inf where no minimum."""
    count = len(normals)
    rows = [_equation(i, normals, direction) for i in range(3)]
    basis = [count + i for i in range(3)]
    # Phase 1: drive the three artificial variables out
    penalty = [-sum((row[j] for row in rows), Fraction(0)) for j in range(count)]
    penalty += [Fraction(0)] * 3 + [-sum((row[-1] for row in rows), Fraction(0))]
    _minimise(rows, penalty, basis, count)
    if penalty[-1] != 0:
        return math.inf
    for i in range(3):
        if basis[i] >= count:
            column = next((j for j in range(count) if rows[i][j]), None)
            if column is not None:
                _pivot(rows, penalty, basis, i, column)
    # Phase 2: the costs, less those of the basis
    kept = [i for i in range(3) if basis[i] < count]
    rows, basis = [rows[i] for i in kept], [basis[i] for i in kept]
    cost = [*offsets, Fraction(0), Fraction(0), Fraction(0), Fraction(0)]
    for row, column in zip(rows, basis, strict=True):
        factor = cost[column]
        cost = [c - factor * r for c, r in zip(cost, row, strict=True)]
    return -cost[-1] if _minimise(rows, cost, basis, count) else -math.inf


def _equation(axis: int, normals: Sequence[Numbers], direction: Numbers) -> list[Fraction]:
    """One row: coefficients, three artificial ones, right side >= 0."""
    sign = -1 if direction[axis] < 0 else 1
    artificial = [Fraction(int(i == axis)) for i in range(3)]
    return [*(sign * normal[axis] for normal in normals), *artificial, sign * direction[axis]]


def _minimise(rows: list[list[Fraction]], cost: list[Fraction], basis: list[int], count: int) -> bool:
    """Pivot to the minimum by Bland's rule, which cannot cycle; False where there is none."""
    while True:
        column = next((j for j in range(count) if cost[j] < 0), None)
        if column is None:
            return True
        ratios = [(row[-1] / row[column], basis[i], i) for i, row in enumerate(rows) if row[column] > 0]
        if not ratios:
            return False
        _pivot(rows, cost, basis, min(ratios)[2], column)


def _pivot(rows: list[list[Fraction]], cost: list[Fraction], basis: list[int], pivot: int, column: int) -> None:
    divisor = rows[pivot][column]
    rows[pivot] = [value / divisor for value in rows[pivot]]
    basis[pivot] = column
    for line in (*(row for i, row in enumerate(rows) if i != pivot), cost):
        factor = line[column]
        if factor:
            line[:] = [value - factor * p for value, p in zip(line, rows[pivot], strict=True)]
