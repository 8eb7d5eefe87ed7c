"""Support and bounds of an intersection of half-spaces, by the simplex method, certified in integers.

sup d·x over normals x <= offsets is, by duality, the minimum of offsets·λ over λ >= 0 with Σ λ_i normals_i = d: three
equations and few variables, so a small tableau with Bland's rule. It runs in floats first. If the three planes of that
run meet in a point that integer arithmetic certifies, the value there is the result. Otherwise the tableau runs again
in fractions, from these three planes if they can serve as a start.
"""

from __future__ import annotations

import itertools
import math
import sys
from collections.abc import Iterable, Sequence
from fractions import Fraction
from typing import Any, TypeAlias

import numpy as np

from ..._util.arrays import BoxEnds
from ...numerics import bigfloat as ex
from ..surface import PlaneSurface

Numbers: TypeAlias = Sequence[Fraction]
Whole: TypeAlias = Sequence[int]

_PIVOTS = 200
"""A limit for runs in floats, where Bland's rule may cycle; then fractions take over."""


def half_spaces_support(normals: Sequence[Numbers], offsets: Numbers, direction: Numbers) -> Fraction | float:
    """Return sup direction·x over all normal·x <= offset: a fraction, inf if unbounded, -inf if empty.

    The direction and each of the normals are three fractions.
    """
    return integer_support(
        [integer_row((*normal, offset)) for normal, offset in zip(normals, offsets, strict=True)], direction
    )


def integer_row(row: Sequence[Fraction | float]) -> list[int]:
    """Return a half-space (normal, offset) or a direction times a positive factor that makes it integers.

    Products of integers are quicker than products of fractions.
    """
    ratios = [value.as_integer_ratio() for value in row]
    factor = math.lcm(*(denominator for _, denominator in ratios))
    return [numerator * (factor // denominator) for numerator, denominator in ratios]


def integer_support(rows: Sequence[Whole], direction: Numbers) -> Fraction | float:
    """Return `half_spaces_support` of half-spaces given as rows of four integers, normal and offset (`integer_row`)."""
    if not any(direction):
        return -math.inf if _is_empty(rows) else Fraction(0)
    scaled = integer_row((*direction, Fraction(1)))
    towards, factor = scaled[:3], scaled[3]
    basis = _float_basis(rows, towards)
    value = _certify_basis(rows, towards, basis) if len(basis) == 3 else None
    if value is None:
        value, _ = _solve_dual(_fractions(rows), [Fraction(u) for u in towards], basis=basis)
        if value == math.inf and _is_empty(rows):  # a finite value proves by duality that the intersection is not empty
            return -math.inf
    return value / factor if isinstance(value, Fraction) else float(value)


def _is_empty(rows: Sequence[Whole]) -> bool:
    """Return True if no point is in all half-spaces: if a zero combination of the normals has offset < 0 (Farkas)."""
    bound, _ = _solve_dual(_fractions(rows), [Fraction(0)] * 3)
    return bool(bound == -math.inf)


def _fractions(rows: Sequence[Whole]) -> list[list[Fraction]]:
    return [[Fraction(value) for value in row] for row in rows]


def _float_basis(rows: Sequence[Whole], direction: Whole) -> list[int]:
    """Return the half-spaces that bound in a direction according to a run in floats; empty if floats fail."""
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
    """Return the support at the common point of three planes; None unless that point is the maximum.

    It is if it lies in all half-spaces (it is a vertex) and the direction is in the cone of the three normals.
    """
    # Cramer's rule: the point times the determinant is Σ offset_i cross_i, and so is the direction times it
    # Σ (cross_i·direction) normal_i
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
    """Return (min offsets·λ over λ >= 0 with Σ λ_i normals_i = direction, the i of the basis).

    The minimum is inf if there is no such λ, -inf if there is no minimum. `planes` holds rows of normals and offsets,
    fractions or floats. `basis` is a guess of the result's basis.
    """
    count = len(planes)
    rows, penalty, columns = _start_tableau(planes, direction)
    if basis:
        for slot, column in enumerate(basis):
            if rows[slot][column]:
                _pivot(rows, penalty, columns, slot, column)
        if any(row[-1] < 0 for row in rows):  # the guess is no feasible start
            rows, penalty, columns = _start_tableau(planes, direction)
    # Phase 1: drive the three artificial variables out
    _minimise(rows, penalty, columns, count, pivots)
    if pivots is None and penalty[-1] != 0:
        return math.inf, []
    for i in range(3):
        if columns[i] >= count:
            entering = next((j for j in range(count) if rows[i][j]), None)
            if entering is not None:
                _pivot(rows, penalty, columns, i, entering)
    # Phase 2: the costs, minus those of the basis
    real = [i for i in range(3) if columns[i] < count]
    rows, columns = [rows[i] for i in real], [columns[i] for i in real]
    cost = [*(plane[3] for plane in planes), 0, 0, 0, 0]
    for row, column in zip(rows, columns, strict=True):
        factor = cost[column]
        cost = [c - factor * r for c, r in zip(cost, row, strict=True)]
    return (-cost[-1] if _minimise(rows, cost, columns, count, pivots) else -math.inf), columns


def _start_tableau(planes: Any, direction: Any) -> tuple[list[list[Any]], list[Any], list[int]]:
    """Return the tableau of phase 1: rows, the cost of the artificial variables, and these three as the basis."""
    count = len(planes)
    rows = [_equation(i, planes, direction) for i in range(3)]
    penalty = [-sum(row[j] for row in rows) for j in range(count)]
    return rows, [*penalty, 0, 0, 0, -sum(row[-1] for row in rows)], [count + i for i in range(3)]


def _equation(axis: int, planes: Any, direction: Any) -> list[Any]:
    """Return one row: coefficients, those of the three artificial variables, a right side >= 0."""
    sign = -1 if direction[axis] < 0 else 1
    return [*(sign * plane[axis] for plane in planes), *(int(i == axis) for i in range(3)), sign * direction[axis]]


def _minimise(rows: list[list[Any]], cost: list[Any], basis: list[int], count: int, pivots: int | None) -> bool:
    """Pivot to the minimum by Bland's rule, which cannot cycle in fractions; return False if there is none."""
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


# Bounds of an intersection of half-spaces

_DIGITS, _OFFSET_SLACK, _EQUAL_BITS = 1000, Fraction(1, 1 << 900), Fraction(1, 1 << 700)
"""3000-bit numbers are cut to 1000 bits. Numbers that agree to 700 bits are equal: 665 lie between 1e-100 and 1e100."""
_ZERO = Fraction(0)


def half_spaces_bounds(planes: Iterable[PlaneSurface]) -> BoxEnds:
    """Return (low, high) of the points with every normal·x <= offset, rounded outward.

    An end is infinite exactly if the intersection is. Normals and offsets after a motion are rounded to `_DIGITS` bits;
    then all offsets are raised by more than that rounding, so that an intersection that is only an edge is not empty
    here. An end that is a float in exact arithmetic is that float.
    """
    planes = list(planes)
    given = [_exact_fractions((*plane.normal, plane.offset)) for plane in planes]
    reach = _ZERO
    if not all(
        isinstance(value, (float, int, Fraction)) for plane in planes for value in (*plane.normal, plane.offset)
    ):
        reach = max(abs(row[3]) / max(map(abs, row[:3])) for row in given)
        for row in given:
            row[3] += _OFFSET_SLACK * reach * max(map(abs, row[:3]))
    rows = [integer_row(row) for row in given]
    low, high = np.empty(3), np.empty(3)
    if all(sum(map(bool, row[:3])) == 1 for row in rows):
        return _box(rows)
    for i in range(3):
        up, down = ([Fraction(sign * int(i == j)) for j in range(3)] for sign in (1, -1))
        high[i] = round_fraction_up(integer_support(rows, up), reach)
        low[i] = -round_fraction_up(integer_support(rows, down), reach)
    return low + 0.0, high


def _box(rows: Sequence[Whole]) -> BoxEnds:
    """Return the bounds if every normal lies along an axis: no search is needed."""
    ends: list[tuple[Fraction | float, Fraction | float]] = []
    for i in range(3):
        sides = [(row[i], Fraction(row[3], row[i])) for row in rows if row[i]]
        below = max((end for factor, end in sides if factor < 0), default=-math.inf)
        ends.append((below, min((end for factor, end in sides if factor > 0), default=math.inf)))
    if any(below > above for below, above in ends):
        return np.full(3, np.inf), np.full(3, -np.inf)
    low = np.array([-round_fraction_up(-below) for below, _ in ends]) + 0.0
    return low, np.array([round_fraction_up(above) for _, above in ends])


def _exact_fractions(row: Iterable[ex.Writable]) -> list[Fraction]:
    """Return floats as they are, and 3000-bit numbers rounded so that numbers that are equal on paper are equal."""
    result = []
    for value in row:
        if isinstance(value, (float, int, Fraction)):
            result.append(Fraction(value))
        else:
            result.append(ex.fraction(ex.cut(value, _DIGITS)))
    return result


def round_fraction_up(value: Fraction | float, reach: Fraction = _ZERO) -> float:
    """Return the least float64 that is not below a fraction, whose error is at most `_EQUAL_BITS` times `reach`."""
    if isinstance(value, float):
        return value
    try:
        result = float(value)
    except OverflowError:
        return math.inf if value > 0 else -sys.float_info.max
    if abs(value - Fraction(result)) <= _EQUAL_BITS * reach:
        return result
    if abs(value) <= _EQUAL_BITS * reach:
        return 0.0
    return math.nextafter(result, math.inf) if Fraction(result) < value else result
