"""The support of an intersection of half-spaces, by the simplex method in rational arithmetic.

sup of d·x over normals x <= offsets is, by duality, the least offsets·λ over λ >= 0 with
Σ λ_i normals_i = d. Three equations and few variables: a small tableau with Bland's rule. It runs in
floats first; if the three planes found there meet in a point that exact arithmetic certifies, that is
the answer, else the tableau runs again in fractions.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from fractions import Fraction
from typing import Any, TypeAlias

Numbers: TypeAlias = Sequence[Fraction]

_PIVOTS = 200
"""In floats Bland's rule may cycle; then fractions take over."""


def half_spaces_support(normals: Sequence[Numbers], offsets: Numbers, direction: Numbers) -> Fraction | float:
    """sup of direction·x over all normal·x <= offset: a fraction, inf where unbounded, -inf where empty."""
    if not any(direction):
        return -math.inf if _is_empty(normals, offsets) else Fraction(0)
    found = _certified(normals, offsets, direction)
    if found is not None:
        return found
    bound, _ = _least(normals, offsets, direction)
    return -math.inf if _is_empty(normals, offsets) else bound


def _is_empty(normals: Sequence[Numbers], offsets: Numbers) -> bool:
    """Farkas: empty where a vanishing combination of the normals has a negative offset."""
    bound, _ = _least(normals, offsets, [Fraction(0)] * 3)
    return bool(bound == -math.inf)


def _certified(normals: Sequence[Numbers], offsets: Numbers, direction: Numbers) -> Fraction | None:
    """The support at the vertex where a run in floats ends, if it is one and the direction lies in its cone."""
    try:
        planes = [[float(c) for c in normal] for normal in normals]
        _, basis = _least(planes, [float(d) for d in offsets], [float(u) for u in direction], _PIVOTS)
    except (OverflowError, ZeroDivisionError):
        return None
    if len(basis) != 3:
        return None
    chosen = [normals[i] for i in basis]
    weights = _solution([list(column) for column in zip(*chosen, strict=True)], direction)
    vertex = _solution(chosen, [offsets[i] for i in basis])
    if weights is None or vertex is None or min(weights) < 0:
        return None
    if any(_dot(normal, vertex) > offset for normal, offset in zip(normals, offsets, strict=True)):
        return None
    return _dot(direction, vertex)


def _solution(rows: Sequence[Numbers], right: Numbers) -> list[Fraction] | None:
    """Cramer's rule for three equations."""
    (a, b, c), (d, e, f), (g, h, i) = rows
    cofactors = (
        (e * i - f * h, c * h - b * i, b * f - c * e),
        (f * g - d * i, a * i - c * g, c * d - a * f),
        (d * h - e * g, b * g - a * h, a * e - b * d),
    )
    determinant = a * cofactors[0][0] + b * cofactors[1][0] + c * cofactors[2][0]
    return [_dot(row, right) / determinant for row in cofactors] if determinant else None


def _dot(a: Numbers, b: Numbers) -> Fraction:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _least(normals: Any, offsets: Any, direction: Any, pivots: int | None = None) -> tuple[Any, list[int]]:
    """min offsets·λ over λ >= 0, Σ λ_i normals_i = direction, and the i that count.

    inf where there is no such λ, -inf where there is no minimum. Fractions or floats.
    """
    count = len(normals)
    rows = [_equation(i, normals, direction) for i in range(3)]
    basis = [count + i for i in range(3)]
    # Phase 1: drive the three artificial variables out
    penalty = [-sum(row[j] for row in rows) for j in range(count)]
    penalty += [0, 0, 0, -sum(row[-1] for row in rows)]
    _minimise(rows, penalty, basis, count, pivots)
    if pivots is None and penalty[-1] != 0:
        return math.inf, []
    for i in range(3):
        if basis[i] >= count:
            column = next((j for j in range(count) if rows[i][j]), None)
            if column is not None:
                _pivot(rows, penalty, basis, i, column)
    # Phase 2: the costs, less those of the basis
    kept = [i for i in range(3) if basis[i] < count]
    rows, basis = [rows[i] for i in kept], [basis[i] for i in kept]
    cost = [*offsets, 0, 0, 0, 0]
    for row, column in zip(rows, basis, strict=True):
        factor = cost[column]
        cost = [c - factor * r for c, r in zip(cost, row, strict=True)]
    return (-cost[-1] if _minimise(rows, cost, basis, count, pivots) else -math.inf), basis


def _equation(axis: int, normals: Any, direction: Any) -> list[Any]:
    """One row: coefficients, three artificial ones, right side >= 0."""
    sign = -1 if direction[axis] < 0 else 1
    return [*(sign * normal[axis] for normal in normals), *(int(i == axis) for i in range(3)), sign * direction[axis]]


def _minimise(rows: list[list[Any]], cost: list[Any], basis: list[int], count: int, pivots: int | None) -> bool:
    """Pivot to the minimum by Bland's rule, which cannot cycle in fractions; False where there is none."""
    for _ in itertools.count() if pivots is None else range(pivots):
        column = next((j for j in range(count) if cost[j] < 0), None)
        if column is None:
            return True
        ratios = [(row[-1] / row[column], basis[i], i) for i, row in enumerate(rows) if row[column] > 0]
        if not ratios:
            return False
        _pivot(rows, cost, basis, min(ratios)[2], column)
    return True


def _pivot(rows: list[list[Any]], cost: list[Any], basis: list[int], pivot: int, column: int) -> None:
    divisor = rows[pivot][column]
    rows[pivot] = [value / divisor for value in rows[pivot]]
    basis[pivot] = column
    for line in (*(row for i, row in enumerate(rows) if i != pivot), cost):
        factor = line[column]
        if factor:
            line[:] = [value - factor * p for value, p in zip(line, rows[pivot], strict=True)]
