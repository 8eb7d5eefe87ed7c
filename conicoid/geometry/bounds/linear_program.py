"""Support and bounds of an intersection of half-spaces, by the simplex method, certified in integers.

sup d·x over normals x <= offsets is, by duality, the minimum of offsets·λ over λ >= 0 with Σ λ_i normals_i = d. The
dual simplex method looks for the three planes that bound: in floats first, then in integers from the planes of that
run, which nearly always are the result. Where three planes cannot serve as a start, as in an unbounded direction, a
small tableau with Bland's rule runs in fractions.
"""

from __future__ import annotations

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
"""A limit for runs of the dual method, which may cycle; then fractions and Bland's rule take over."""
_FAR, _SLACK = 2.0**20, 2.0**-44
"""How far the start of a run in floats is, in offsets, and the share by which a point of it may be beyond a plane."""


def half_spaces_support(normals: Sequence[Numbers], offsets: Numbers, direction: Numbers) -> Fraction | float:
    """Return sup direction·x over all normal·x <= offset: a fraction, inf if unbounded, -inf if empty.

    The direction and each of the normals are three fractions.
    """
    return integer_support(
        [integer_row((*normal, offset)) for normal, offset in zip(normals, offsets, strict=True)], direction
    )


def are_ratios(values: Iterable[Any]) -> bool:
    """Return whether all values are floats, integers or fractions, and so known as ratios of integers."""
    return all(isinstance(value, (float, int, Fraction)) for value in values)


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
        value = _solve_dual(_fractions(rows), [Fraction(u) for u in towards], basis)
        if value == math.inf and _is_empty(rows):  # a finite value proves by duality that the intersection is not empty
            return -math.inf
    return value / factor if isinstance(value, Fraction) else float(value)


def _is_empty(rows: Sequence[Whole]) -> bool:
    """Return True if no point is in all half-spaces: if a zero combination of the normals has offset < 0 (Farkas)."""
    return bool(_solve_dual(_fractions(rows), [Fraction(0)] * 3) == -math.inf)


def _fractions(rows: Sequence[Whole]) -> list[list[Fraction]]:
    return [[Fraction(value) for value in row] for row in rows]


def _float_basis(rows: Sequence[Whole], direction: Whole) -> list[int]:
    """Return the half-spaces that bound in a direction according to a run in floats; fewer than three if it fails."""
    try:
        planes: list[Sequence[float]] = []
        for row in rows:
            size = max(map(abs, row[:3])) or 1
            planes.append([value / size for value in row])
        size = max(map(abs, direction))
        towards = [u / size for u in direction]
    except (OverflowError, ZeroDivisionError):
        return []
    # Far sides of a box, towards the direction, are a start
    far = _FAR * max(1.0, max((abs(plane[3]) for plane in planes), default=1.0))
    planes += [[(-1.0 if towards[axis] < 0 else 1.0) * (k == axis) for k in range(3)] + [far] for axis in range(3)]
    _, basis = _descend(planes, towards, [len(rows), len(rows) + 1, len(rows) + 2], _SLACK)
    return [i for i in basis if i < len(rows)]


def _certify_basis(rows: Sequence[Whole], direction: Whole, basis: Sequence[int]) -> Fraction | float | None:
    """Return the support in integers, from three planes whose normals have the direction in their cone; else None."""
    value: Fraction | float | None = _descend(rows, direction, list(basis), 0)[0]
    return value


def _descend(planes: Sequence[Any], direction: Any, basis: list[int], slack: float) -> tuple[Any, list[int]]:
    """Return (support, the planes that bound it) of integers; of floats only the planes count.

    The dual simplex method: the direction stays in the cone of the normals of three planes, and their common point
    descends until it lies in all half-spaces, or until three normals show that no point does. The support is then -inf.
    It is None where `basis` is no start, and after too many steps.

    Parameters
    ----------
    planes : sequence
        Rows of normals and offsets.
    direction : sequence
        Its three numbers.
    basis : list
        Three planes to start from.
    slack : float
        The share of its terms by which a point may be beyond a plane: 0 for integers.
    """
    for _ in range(_PIVOTS):
        first, second, third = (planes[i] for i in basis)
        crosses = [_cross(second, third), _cross(third, first), _cross(first, second)]
        determinant = _dot(first, crosses[0])
        if not determinant:
            break
        if determinant < 0:
            determinant, crosses = -determinant, [(-x, -y, -z) for x, y, z in crosses]
        # Cramer's rule: the point times the determinant is Σ offset_i cross_i, and so is the direction times it
        # Σ (cross_i·direction) normal_i
        shares = [_dot(cross, direction) for cross in crosses]
        if not slack and min(shares) < 0:
            break
        a, b, c = crosses
        p, q, r = first[3], second[3], third[3]
        x, y, z = p * a[0] + q * b[0] + r * c[0], p * a[1] + q * b[1] + r * c[1], p * a[2] + q * b[2] + r * c[2]
        room = slack * (abs(x) + abs(y) + abs(z) + determinant)
        beyond = [row[0] * x + row[1] * y + row[2] * z - row[3] * determinant for row in planes]
        most = max(beyond)
        if most <= room:
            value = None if slack else Fraction(direction[0] * x + direction[1] * y + direction[2] * z, determinant)
            return value, basis
        entering = beyond.index(most)
        rates = [_dot(cross, planes[entering]) for cross in crosses]
        leaving = -1
        for k in range(3):
            # The least of share / rate, compared without division
            if rates[k] > 0 and (leaving < 0 or shares[k] * rates[leaving] < shares[leaving] * rates[k]):
                leaving = k
        if leaving < 0:
            return -math.inf, basis  # minus the entering normal is in the cone of the others (Farkas)
        basis[leaving] = entering
    return None, basis


def _dot(a: Whole, b: Whole) -> int:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a: Whole, b: Whole) -> tuple[int, int, int]:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def _solve_dual(planes: list[list[Fraction]], direction: list[Fraction], basis: Sequence[int] = ()) -> Any:
    """Return min offsets·λ over λ >= 0 with Σ λ_i normals_i = direction.

    The minimum is inf if there is no such λ, -inf if there is no minimum. `planes` holds rows of normals and offsets.
    `basis` is a guess of the result's basis.
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
    _minimise(rows, penalty, columns, count)
    if penalty[-1] != 0:
        return math.inf
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
    return -cost[-1] if _minimise(rows, cost, columns, count) else -math.inf


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


def _minimise(rows: list[list[Any]], cost: list[Any], basis: list[int], count: int) -> bool:
    """Pivot to the minimum by Bland's rule, which cannot cycle in fractions; return False if there is none."""
    while True:
        column = next((j for j in range(count) if cost[j] < 0), None)
        if column is None:
            return True
        ratios = [(row[-1] / row[column], basis[i], i) for i, row in enumerate(rows) if row[column] > 0]
        if not ratios:
            return False
        _pivot(rows, cost, basis, min(ratios)[2], column)


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
    if not are_ratios(value for plane in planes for value in (*plane.normal, plane.offset)):
        reach = max(abs(row[3]) / max(map(abs, row[:3])) for row in given)
        for row in given:
            row[3] += _OFFSET_SLACK * reach * max(map(abs, row[:3]))
    rows = [integer_row(row) for row in given]
    low, high = np.empty(3), np.empty(3)
    if all(sum(map(bool, row[:3])) == 1 for row in rows):
        return _box(rows)
    # A prism without ends reaches as far across as its section does
    endless = [i for i in range(3) if not any(row[i] for row in rows)]
    rows += [[*(sign * (k == i) for k in range(3)), 0] for i in endless for sign in (1, -1)]
    for i in range(3):
        up, down = ([Fraction(sign * int(i == j)) for j in range(3)] for sign in (1, -1))
        high[i] = round_fraction_up(integer_support(rows, up), reach)
        low[i] = -round_fraction_up(integer_support(rows, down), reach)
    for i in endless if (low <= high).all() else ():
        low[i], high[i] = -np.inf, np.inf
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
