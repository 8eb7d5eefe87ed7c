"""The convex polyhedron, bounded or not."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

import numpy as np

from .._util.arrays import BoxEnds, Vector
from .._util.validation import check_numbers, check_vector, check_vectors
from ..numerics import bigfloat_linalg as ex
from .bounds.aabb import enclose_boxes
from .bounds.linear_program import Whole, integer_row, integer_support
from .bounds.support import half_space_bounds, plane_through, plane_uv
from .cell import Cell, Face
from .shape import PrimitiveSolid
from .surface import PlaneSurface
from .transform import Motion

_DIGITS, _OFFSET_SLACK, _EQUAL_BITS = 1000, Fraction(1, 1 << 900), Fraction(1, 1 << 700)
"""So many bits are kept of numbers of 3000. What agrees to 700 is equal: 665 lie between 1e-100 and 1e100."""
_ZERO = Fraction(0)
_DIRECTION_ROUNDING = 2.0**-52
"""A direction's own rounding, and that of the sums it is in."""


@dataclass(frozen=True)
class Polyhedron(PrimitiveSolid):
    """Every normals[i]·x <= offsets[i], as written. It may be unbounded, or empty.

    Face i belongs to normals[i]. uv: Cartesian coordinates on its plane about a point near the solid;
    u points to the coordinate axis that is least along the normal, v = normal × u.
    """

    normals: tuple[Vector, ...]
    offsets: tuple[float, ...]

    def __post_init__(self) -> None:
        normals = check_vectors("Polyhedron", "normals", self.normals, 1)
        for i, normal in enumerate(normals):
            check_vector("Polyhedron", f"normals[{i}]", normal, nonzero=True)
        object.__setattr__(self, "normals", normals)
        object.__setattr__(self, "offsets", check_numbers("Polyhedron", "offsets", self.offsets, len(normals)))

    @cached_property
    def _rows(self) -> list[list[int]]:
        """The half-spaces as whole numbers."""
        return [integer_row((*normal, offset)) for normal, offset in zip(self.normals, self.offsets, strict=True)]

    @cached_property
    def _own_bounds(self) -> BoxEnds:
        """Bounds in the own frame, before any motion."""
        return half_spaces_bounds([PlaneSurface(n, d) for n, d in zip(self.normals, self.offsets, strict=True)])

    @property
    def surfaces(self) -> list[PlaneSurface]:
        """The planes, anchored near the solid."""
        low, high = self._own_bounds
        if (low > high).any():
            low = high = np.zeros(3)
        near = [_middle(a, b) for a, b in zip(low.tolist(), high.tolist(), strict=True)]
        return [plane_through(n, d, near) for n, d in zip(self.normals, self.offsets, strict=True)]

    def tree(self) -> Cell:
        return Cell(tuple(Face(surface, i, plane_uv(surface)) for i, surface in enumerate(self.surfaces)))

    def support(self, direction: Vector) -> float:
        """Of one axis exactly; of several raised by what the rounding of the direction may have cost."""
        found = integer_support(self._rows, [Fraction(u) for u in direction])
        if sum(map(bool, direction)) < 2 or isinstance(found, float):
            return _round_up(found)
        reach = np.maximum(abs(self._own_bounds[0]), abs(self._own_bounds[1]))
        terms = [abs(u) * r for u, r in zip(direction, reach.tolist(), strict=True) if u]
        return _round_up(found) + _DIRECTION_ROUNDING * math.fsum(terms)

    def bounds_under(self, outer: Motion) -> BoxEnds:
        """Unbounded ones are carried exactly, so that finite sides are found where a face turns to an axis."""
        motion = self.under(outer)
        if motion.is_identity:
            return self._own_bounds[0].copy(), self._own_bounds[1].copy()
        if np.isfinite(self._own_bounds).all():
            return super().bounds_under(outer)
        return half_spaces_bounds([surface.moved(motion) for surface in self.surfaces])

    def outside_bounds_under(self, outer: Motion) -> BoxEnds:
        """Around the half-spaces beyond the faces."""
        motion = self.under(outer)
        return enclose_boxes([half_space_bounds(surface.moved(motion), below=False) for surface in self.surfaces])


def half_spaces_bounds(planes: Iterable[PlaneSurface]) -> BoxEnds:
    """(low, high) of the points with every normal·x <= offset: rounded outward, infinite exactly where they are.

    Normals and offsets that motions carried are rounded, to `_DIGITS` bits. So that what is but an edge on paper is not
    empty here, all offsets are then raised by more than that, and an end that is a float on paper is that float.
    """
    planes = list(planes)
    given = [_fractions((*plane.normal, plane.offset)) for plane in planes]
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
        high[i] = _round_up(integer_support(rows, up), reach)
        low[i] = -_round_up(integer_support(rows, down), reach)
    return low + 0.0, high


def _box(rows: Sequence[Whole]) -> BoxEnds:
    """The bounds where every normal lies along an axis: no need to search."""
    ends: list[tuple[Fraction | float, Fraction | float]] = []
    for i in range(3):
        sides = [(row[i], Fraction(row[3], row[i])) for row in rows if row[i]]
        below = max((end for factor, end in sides if factor < 0), default=-math.inf)
        ends.append((below, min((end for factor, end in sides if factor > 0), default=math.inf)))
    if any(below > above for below, above in ends):
        return np.full(3, np.inf), np.full(3, -np.inf)
    return np.array([-_round_up(-below) for below, _ in ends]) + 0.0, np.array([_round_up(above) for _, above in ends])


def _middle(low: float, high: float) -> float:
    """A finite number between two ends, any of which may be infinite."""
    ends = [end for end in (low, high) if math.isfinite(end)]
    return sum(end / len(ends) for end in ends)


def _fractions(row: Iterable[ex.Writable]) -> list[Fraction]:
    """Floats as they are; 3000-bit numbers rounded so that equal ones on paper are equal here."""
    result = []
    for value in row:
        if isinstance(value, (float, int, Fraction)):
            result.append(Fraction(value))
        else:
            result.append(ex.fraction(ex.cut(value, _DIGITS)))
    return result


def _round_up(value: Fraction | float, reach: Fraction = _ZERO) -> float:
    """The least float64 that is not below a fraction, which is known to `_SAME` of `reach`."""
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
