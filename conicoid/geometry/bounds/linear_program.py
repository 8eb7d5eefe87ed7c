"""The support of an intersection of half-spaces, by the simplex method, certified in whole numbers.

sup of d·x over normals x <= offsets is, by duality, the least offsets·λ over λ >= 0 with
Σ λ_i normals_i = d. Three equations and few variables: a small tableau with Bland's rule. It runs in
floats first; if the three planes found there meet in a point that exact arithmetic certifies, that is
the answer, else the tableau runs again in fractions, from these three planes if they will do for a beginning.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from fractions import Fraction
from typing import Any, TypeAlias

Numbers: TypeAlias = Sequence[Fraction]
Whole: TypeAlias = Sequence[int]

_PIVOTS = 200
"""In floats Bland's rule may cycle; then fractions take over."""


def half_spaces_support(normals: Sequence[Numbers], offsets: Numbers, direction: Numbers) -> Fraction | float:
    """sup of direction·x over all normal·x <= offset: a fraction, inf where unbounded, -inf where empty."""
    return integer_support(
        [integer_row((*normal, offset)) for normal, offset in zip(normals, offsets, strict=True)], direction
    )


def integer_row(row: Sequence[Fraction | float]) -> list[int]:
    """The same half-space (normal, offset) or direction by whole numbers, which are quicker to multiply."""
    ratios = [value.as_integer_ratio() for value in row]
    factor = math.lcm(*(denominator for _, denominator in ratios))
    return [numerator * (factor // denominator) for numerator, denominator in ratios]


def integer_support(rows: Sequence[Whole], direction: Numbers) -> Fraction | float:
    """sup of direction·x over all normal·x <= offset, each half-space being a row of four whole numbers."""
    if not any(direction):
        return -math.inf if _is_empty(rows) else Fraction(0)
    scaled = integer_row((*direction, Fraction(1)))
    towards, factor = scaled[:3], scaled[3]
    basis = _float_basis(rows, towards)
    value = _certify_basis(rows, towards, basis) if len(basis) == 3 else None
    if value is None:
        value, _ = _solve_dual(_fractions(rows), [Fraction(u) for u in towards], basis=basis)
        if value == math.inf and _is_empty(rows):  # if it is finite, duality says that there is a point
            return -math.inf
    return value / factor if isinstance(value, Fraction) else float(value)


def _is_empty(rows: Sequence[Whole]) -> bool:
    """Farkas: empty where a vanishing combination of the normals has a negative offset."""
    bound, _ = _solve_dual(_fractions(rows), [Fraction(0)] * 3)
    return bool(bound == -math.inf)


def _fractions(rows: Sequence[Whole]) -> list[list[Fraction]]:
    return [[Fraction(value) for value in row] for row in rows]


def _float_basis(rows: Sequence[Whole], direction: Whole) -> list[int]:
    """The half-spaces that bound in a direction, as a run in floats finds them."""
    try:
        planes = []
        for row in rows:
            size = max(map(abs, row[:3])) or 1
            planes.append([value / size for value in row])
        size = max(map(abs, direction))
        return _solve_dual(planes, [u / size for u in direction], _PIVOTS)[1]
    except (OverflowError, ZeroDivisionError):
        return []


def _certify_basis(rows: Sequence[Whole], direction: Whole, basis: Sequence[int]) -> Fraction | None:
    """The support at the point where three planes meet, if it is a vertex and the direction lies in its cone."""
    first, second, third = (rows[i] for i in basis)
    crosses = _cross(second, third), _cross(third, first), _cross(first, second)
    determinant = _dot(first, crosses[0])
    if not determinant:
        return None
    if determinant < 0:
        determinant, crosses = -determinant, tuple((-x, -y, -z) for x, y, z in crosses)  # type: ignore[assignment]
    if min(_dot(cross, direction) for cross in crosses) < 0:
        return None
    a, b, c = crosses
    p, q, r = first[3], second[3], third[3]
    x, y, z = p * a[0] + q * b[0] + r * c[0], p * a[1] + q * b[1] + r * c[1], p * a[2] + q * b[2] + r * c[2]
    if any(row[0] * x + row[1] * y + row[2] * z > row[3] * determinant for row in rows):
        return None
    return Fraction(direction[0] * x + direction[1] * y + direction[2] * z, determinant)


def _dot(a: Whole, b: Whole) -> int:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a: Whole, b: Whole) -> tuple[int, int, int]:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def _solve_dual(
    planes: Any, direction: Any, pivots: int | None = None, basis: Sequence[int] = ()
) -> tuple[Any, list[int]]:
    """min offsets·λ over λ >= 0, Σ λ_i normals_i = direction, and the i that count.

    planes: rows of normals and offsets, fractions or floats; basis: the i that count, if there is a guess.
    inf where there is no such λ, -inf where there is no minimum.
    """
    count = len(planes)
    rows, penalty, found = _start_tableau(planes, direction)
    if basis:
        for slot, column in enumerate(basis):
            if rows[slot][column]:
                _pivot(rows, penalty, found, slot, column)
        if any(row[-1] < 0 for row in rows):
            rows, penalty, found = _start_tableau(planes, direction)
    # Phase 1: drive the three artificial variables out
    _minimise(rows, penalty, found, count, pivots)
    if pivots is None and penalty[-1] != 0:
        return math.inf, []
    for i in range(3):
        if found[i] >= count:
            entering = next((j for j in range(count) if rows[i][j]), None)
            if entering is not None:
                _pivot(rows, penalty, found, i, entering)
    # Phase 2: the costs, less those of the basis
    kept = [i for i in range(3) if found[i] < count]
    rows, found = [rows[i] for i in kept], [found[i] for i in kept]
    cost = [*(plane[3] for plane in planes), 0, 0, 0, 0]
    for row, column in zip(rows, found, strict=True):
        factor = cost[column]
        cost = [c - factor * r for c, r in zip(cost, row, strict=True)]
    return (-cost[-1] if _minimise(rows, cost, found, count, pivots) else -math.inf), found


def _start_tableau(planes: Any, direction: Any) -> tuple[list[list[Any]], list[Any], list[int]]:
    """The tableau of phase 1: rows, the cost of what they lack, and three artificial variables as a basis."""
    count = len(planes)
    rows = [_equation(i, planes, direction) for i in range(3)]
    penalty = [-sum(row[j] for row in rows) for j in range(count)]
    return rows, [*penalty, 0, 0, 0, -sum(row[-1] for row in rows)], [count + i for i in range(3)]


def _equation(axis: int, planes: Any, direction: Any) -> list[Any]:
    """One row: coefficients, three artificial ones, right side >= 0."""
    sign = -1 if direction[axis] < 0 else 1
    return [*(sign * plane[axis] for plane in planes), *(int(i == axis) for i in range(3)), sign * direction[axis]]


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
