"""Support and bounds of an intersection of half-spaces, by the simplex method, exact in integers.

sup d·x over normals x <= offsets is, by duality, the minimum of offsets·λ over λ >= 0 with Σ λ_i normals_i = d. The
dual simplex method keeps three planes with such λ, and lets their common point descend until it lies in all
half-spaces. It starts from the sides of a box that surrounds all corners, and runs in floats first. Then integers
certify the planes of that run, or go on from there; floats with a bound of their error tell which half-spaces surely
hold a point, so that only the others need integers. λ > 0 of a side shows that nothing bounds the direction.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable, Sequence
from fractions import Fraction
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from ..._util.records import BoxEnds, FloatArray
from ...numerics import bigfloat as ex
from ...numerics.rational import cross, dot3
from ..surface import PlaneSurface

Numbers: TypeAlias = Sequence[Fraction]
Whole: TypeAlias = Sequence[int]

_STEPS = 100
"""After so many steps the method takes the first plane that cuts, not the deepest: so it cannot cycle (Bland)."""
_FAR, _SLACK = 2.0**20, 2.0**-44
"""How far sides are in floats, in offsets; the share of its terms by which a point may be beyond a plane there."""
_ROUNDING, _UNDERFLOW = 2.0**-48, 2.0**-1000
"""More than the error of normal·x - offset in floats, as a share of its terms; what terms grow by for underflow."""
_LONG = 1 << 1000
"""Far sides in floats, where the true ones are farther: what these hold, those hold."""


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
    """Return sup direction·x over all normal·x <= offset: a fraction, inf if unbounded, -inf if empty.

    rows: half-spaces as four integers, normal and offset (`integer_row`). The direction is of three fractions.
    """
    if not any(direction):
        return -math.inf if _Program(rows).support((1, 0, 0)) == -math.inf else Fraction(0)
    scaled = integer_row((*direction, 1))
    found = _Program(rows).support(scaled[:3])
    return found / scaled[3] if isinstance(found, Fraction) else found


class _Program:
    """Half-spaces as rows of four integers, and the start of the search that all directions share."""

    def __init__(self, rows: Sequence[Whole]) -> None:
        self.rows = rows
        bits = max((abs(value).bit_length() for row in rows for value in row), default=1)
        # By Cramer's rule a region that is not empty has a point below 6 · 8^bits
        self.far = 1 << (3 * bits + 8)
        self.planes: list[list[float]] | None
        try:
            sizes = [max(map(abs, row[:3])) or 1 for row in rows]
            self.planes = [[value / size for value in row] for row, size in zip(rows, sizes, strict=True)]
        except OverflowError:
            self.planes = None

    def support(self, towards: Whole) -> Fraction | float:
        """Return the support in a direction of integers, not all 0."""
        rows, floats = [*self.rows, *_far_sides(towards, self.far)], None
        # Short integers are quicker than the test in floats
        if self.planes is not None and self.far > _LONG:
            floats = np.array([*self.planes, *_far_sides(towards, float(_LONG))])
        found = _descend(rows, towards, self._float_basis(towards), floats)
        if found is None:
            return -math.inf
        if any(share and plane >= len(self.rows) for share, plane in zip(found.shares, found.planes, strict=True)):
            return math.inf
        return Fraction(dot3(towards, found.point), found.unit)

    def _float_basis(self, direction: Whole) -> list[int]:
        """Return the planes that bound in a direction according to a run in floats; the far sides if floats fail."""
        start = list(range(len(self.rows), len(self.rows) + 3))
        if self.planes is None:
            return start
        try:
            size = max(map(abs, direction))
            towards = [u / size for u in direction]
            far = _FAR * max(1.0, max((abs(plane[3]) for plane in self.planes), default=1.0))
            found = _descend([*self.planes, *_far_sides(towards, far)], towards, start, None, _SLACK)
        except (OverflowError, ZeroDivisionError):
            return start
        return start if found is None else found.planes


def _far_sides(direction: Sequence[Any], far: Any) -> list[Sequence[Any]]:
    """Return the three sides of a box around the origin that a direction points to."""
    one = far // far
    return [[*((-one if direction[axis] < 0 else one) * (k == axis) for k in range(3)), far] for axis in range(3)]


class _Corner(NamedTuple):
    """The common point of three planes, times `unit`, and the shares of their normals in the direction, times it."""

    planes: list[int]
    shares: list[Any]
    point: tuple[Any, Any, Any]
    unit: Any


def _doubtful(floats: FloatArray, x: int, y: int, z: int, unit: int) -> Iterable[int]:
    """Return the half-spaces, rows of normal and offset in floats, that may not hold the point (x, y, z) / unit."""
    try:
        point = np.array([x / unit, y / unit, z / unit, -1.0])
    except OverflowError:
        return range(len(floats))
    with np.errstate(all="ignore"):
        terms = (np.abs(floats) + _UNDERFLOW) @ np.abs(point)
        return np.flatnonzero(~(floats @ point < -_ROUNDING * terms)).tolist()


def _descend(
    planes: Sequence[Any], direction: Any, start: list[int], floats: FloatArray | None, slack: float = 0
) -> _Corner | None:
    """Return the point of the intersection of half-spaces that is farthest in a direction; None if that is empty.

    Parameters
    ----------
    planes : sequence
        Rows of normals and offsets, integers or floats; the last three are far sides.
    direction : sequence
        Its three numbers.
    start : list of int
        Three planes to start from; the far sides instead if they are no start.
    floats : array (n, 4), optional
        The planes in floats, if `planes` are integers.
    slack : float
        The share of its terms by which a point may be beyond a plane: 0 for integers.
    """
    basis, done = list(start), 0
    while True:
        first, second, third = (planes[i] for i in basis)
        crosses = [cross(second, third), cross(third, first), cross(first, second)]
        unit = dot3(first, crosses[0])
        if unit < 0:
            unit, crosses = -unit, [(-x, -y, -z) for x, y, z in crosses]
        # Cramer's rule: the point times the determinant is Σ offset_i cross_i, and so is the direction times it
        # Σ (cross_i·direction) normal_i
        shares = [dot3(row, direction) for row in crosses]
        if not unit or (not slack and min(shares) < 0):
            basis = [len(planes) - 3, len(planes) - 2, len(planes) - 1]
            continue
        a, b, c = crosses
        p, q, r = first[3], second[3], third[3]
        x, y, z = p * a[0] + q * b[0] + r * c[0], p * a[1] + q * b[1] + r * c[1], p * a[2] + q * b[2] + r * c[2]
        room = slack * (abs(x) + abs(y) + abs(z) + unit)
        doubtful = range(len(planes)) if floats is None else _doubtful(floats, x, y, z, unit)
        beyond = {
            i: planes[i][0] * x + planes[i][1] * y + planes[i][2] * z - planes[i][3] * unit
            for i in doubtful
            if i not in basis
        }
        most = max(beyond.values(), default=0)
        if most <= room or (slack and done > _STEPS):
            return _Corner(basis, shares, (x, y, z), unit)
        entering = max(beyond, key=beyond.__getitem__) if done < _STEPS else next(i for i in beyond if beyond[i] > 0)
        rates = [dot3(row, planes[entering]) for row in crosses]
        leaving = -1
        for k in range(3):
            if rates[k] > 0:
                # The least of share / rate, compared without division
                less = shares[k] * rates[leaving] - shares[leaving] * rates[k]
                if leaving < 0 or less < 0 or (less == 0 and basis[k] < basis[leaving]):
                    leaving = k
        if leaving < 0:
            return None  # minus the entering normal is in the cone of the others (Farkas)
        basis[leaving] = entering
        done += 1


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
    program = _Program(rows)
    for i in range(3):
        up, down = (program.support([sign * int(i == j) for j in range(3)]) for sign in (1, -1))
        # Normals that are all across one line are so up to their rounding: they meet 2^1000 away, if at all
        high[i], low[i] = (
            math.inf if reach and end * _EQUAL_BITS > reach else round_fraction_up(end, reach) for end in (up, down)
        )
    return 0.0 - low, high


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


# The farthest point in floats alone, where nobody needs a certificate

_MOST_STEPS, _FAR_BOX = 1000, 1e6
"""Most planes that are exchanged, and how far away the sides are at first, in offsets."""


def farthest_point(rows: FloatArray, direction: FloatArray) -> FloatArray | None:
    """Return about the farthest point in a direction that is in all half-spaces; None if floats find none.

    Three planes meet in a point, and the direction is a positive sum of their normals: the dual simplex method. The
    plane that the point violates most replaces one of the three, from the sides of a large box on.
    Source: Lemke, "The dual method of solving the linear programming problem", 1954.

    Parameters
    ----------
    rows : array (n, 4)
        Unit normals and offsets.
    direction : array (3,)
        Any length but 0.
    """
    far = _FAR_BOX * float(np.abs(rows[:, 3]).max())
    sides = np.where(direction < 0, -1.0, 1.0)
    basis = np.column_stack([np.diag(sides), np.full(3, far)])
    own, shares = [False] * 3, np.abs(direction)
    for _ in range(_MOST_STEPS):
        try:
            point: FloatArray = np.linalg.solve(basis[:, :3], basis[:, 3])
        except np.linalg.LinAlgError:
            return None
        above = rows[:, :3] @ point - rows[:, 3]
        worst = int(above.argmax())
        if not above[worst] > 2.0**-48 * (float(np.abs(point).max()) + abs(rows[worst, 3])):
            return point if all(own) else None
        weights = np.linalg.solve(basis[:, :3].T, rows[worst, :3])
        with np.errstate(all="ignore"):
            ratios = np.where(weights > 2.0**-40, shares / weights, np.inf)
        out = int(ratios.argmin())
        if not np.isfinite(ratios[out]):
            return None  # the half-spaces have nothing in common
        shares = np.maximum(shares - ratios[out] * weights, 0.0)
        basis[out], own[out], shares[out] = rows[worst], True, ratios[out]
    return None
