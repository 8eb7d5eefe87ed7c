"""Which quadric ten numbers stand for: its kind, exactly, and its center, axes and semi-axes.

xᵀA x + 2 b·x + c <= 0. The kind follows from how many eigenvalues of A and of the 4 × 4 matrix are positive and
negative; both are counted over the rational numbers, so a cone is told from a hyperboloid by the last bit of its
coefficients. Center and vertex are rational as well; axes and semi-axes come from 3000 bits, and all are rounded once.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any

from . import classification as kinds
from . import exact as ex
from . import rational
from .classification import Classification
from .coefficients import Symmetric
from .motion import STILL, Motion
from .principal_axes import eigen
from .surface import UPRIGHT, QuadricSurface
from .vector import Vector

_SAME = ex.power_of_two(-200)
"""Eigenvalues of a moved quadric whose relative difference is below this are one."""
_NOISE = ex.power_of_two(-ex.CANCELLED)


def classify(matrix: Symmetric, motion: Motion = STILL) -> Classification:
    """What (x, 1) matrix (x, 1)ᵀ <= 0, no constant, is after a motion; the kind is found before it, so it is exact."""
    kind, sense = _kind_and_sense(matrix)
    null = rational.null_space([row[:3] for row in matrix[:3]])
    still = motion.shift is not None or motion.is_identity
    if not motion.is_identity:
        linear, _ = motion.affine
        turned = [[ex.fraction(entry) for entry in row] for row in linear]
        null = [[rational.dot(row, vector) for row in turned] for vector in null]
        matrix = _moved(matrix, motion)
    if sense < 0:
        matrix = tuple(tuple(-entry for entry in row) for row in matrix)
    return _Placed(kind, sense, matrix, null, still).classification()


def classify_surface(surface: QuadricSurface) -> Classification:
    """What a quadric in the world is; its kind is found in its own coordinates, where its numbers are as written."""
    own = [[Fraction(0)] * 4 for _ in range(4)]
    for k, (square, linear) in enumerate(zip(surface.squares, surface.linear, strict=True)):
        own[k][k], own[k][3], own[3][k] = ex.fraction(square), ex.fraction(linear), ex.fraction(linear)
    own[3][3] = -ex.fraction(surface.constant)
    kind, sense = _kind_and_sense(tuple(map(tuple, own)))
    rows = tuple(ex.exact_row(row) for row in surface.rows)
    shift = ex.apply((rows[0], rows[1], rows[2]), ex.exact_row(surface.anchor))
    matrix = _carried(tuple(map(tuple, own)), rows, [-value for value in shift])
    null = rational.null_space([row[:3] for row in own[:3]])
    still = surface.rows is UPRIGHT and not any(map(ex.is_rounded, surface.anchor))
    if not still:
        turned = [[ex.fraction(entry) for entry in row] for row in ex.inverse((rows[0], rows[1], rows[2]))]
        null = [[rational.dot(row, vector) for row in turned] for vector in null]
    if sense < 0:
        matrix = tuple(tuple(-entry for entry in row) for row in matrix)
    return _Placed(kind, sense, matrix, null, still).classification()


def _kind_and_sense(matrix: Symmetric) -> tuple[str, int]:
    """The kind, and -1 where the polynomial has to be turned over to have the signs of the table."""
    (p, n), (q, m) = rational.inertia([row[:3] for row in matrix[:3]]), rational.inertia(matrix)
    kind = kinds.BY_SIGNS[((n, p), (m, q)) if n > p else ((p, n), (q, m))]
    return kinds.SPHERE if kind == kinds.ELLIPSOID and _is_scalar(matrix) else kind, -1 if n > p else 1


def _is_scalar(matrix: Symmetric) -> bool:
    a = matrix
    return not (a[0][1] or a[0][2] or a[1][2]) and a[0][0] == a[1][1] == a[2][2]


def _moved(matrix: Symmetric, motion: Motion) -> Symmetric:
    """M⁻ᵀ matrix M⁻¹, with the inverse motion as its 3000 bits say."""
    return _carried(matrix, *motion.inverse)


def _carried(matrix: Symmetric, rows: Iterable[ex.Row], shift: Iterable[ex.Exact]) -> Symmetric:
    """The quadric of points x for which rows x + shift are on one."""
    back = [[*(ex.fraction(c) for c in row), ex.fraction(t)] for row, t in zip(rows, shift, strict=True)]
    back.append([Fraction(0), Fraction(0), Fraction(0), Fraction(1)])
    columns = list(zip(*back, strict=True))
    return tuple(tuple(row) for row in rational.times(rational.times(columns, matrix), back))


@dataclass(frozen=True)
class _Placed:
    """A quadric in the world, turned over to the signs of `kinds.BY_SIGNS`; `null` spans the kernel of A."""

    kind: str
    sense: int
    matrix: Symmetric
    null: list[list[Fraction]]
    still: bool

    def classification(self) -> Classification:
        inside = kinds.SIDES[self.kind][self.sense < 0]
        if self.kind == kinds.TROUGHS:
            inside = kinds.SIDES[kinds.TROUGHS][(self._constant > 0) == (self.sense > 0)]
        if self.kind == kinds.EMPTY:
            return Classification(kinds.EMPTY, inside)
        values, rows = eigen(self.matrix, 3 - len(self.null))
        squares = [ex.exact(value) for value in values]
        same = self._equal(squares)
        kind = self.kind
        if kind in (kinds.SPHERE, kinds.ELLIPSOID):
            kind = kinds.SPHERE if (_is_scalar(self.matrix) if self.still else _all_equal(squares)) else kinds.ELLIPSOID
        order = self._order(squares, same)
        axes = self._axes([rows[k] for k in order])
        measures = self._measures([abs(squares[k]) for k in order])
        if kind == kinds.SPHERE:
            measures = measures[:1]
        center = ex.exact_row(self._center) if self.still else _quiet(self._center, max([ex.ZERO, *measures]))
        return Classification(
            kind,
            inside,
            _rounded(center),
            (_rounded(axes[0]), _rounded(axes[1]), _rounded(axes[2])),
            tuple(float(m) for m in measures),
            same or kind == kinds.SPHERE,
        )

    @cached_property
    def _solution(self) -> tuple[list[Fraction], list[Fraction]]:
        """(x nearest to the origin where A x + b lies in the kernel of A, that A x + b)."""
        a, b = [list(row[:3]) for row in self.matrix[:3]], [row[3] for row in self.matrix[:3]]
        size = len(self.null)
        bordered = [[*a[i], *(vector[i] for vector in self.null)] for i in range(3)]
        bordered += [[*vector, *([Fraction(0)] * size)] for vector in self.null]
        found = rational.solved(bordered, [*(-entry for entry in b), *([Fraction(0)] * size)])
        gradient = [-sum((found[3 + k] * self.null[k][i] for k in range(size)), Fraction(0)) for i in range(3)]
        return found[:3], gradient

    def _value(self, x: list[Fraction]) -> Fraction:
        point = [*x, Fraction(1)]
        return rational.dot(point, [rational.dot(row, point) for row in self.matrix])

    @cached_property
    def _constant(self) -> Fraction:
        """The polynomial at the center."""
        return self._value(self._solution[0])

    @property
    def _opens(self) -> bool:
        return self.kind in (kinds.BOWL, kinds.SADDLE, kinds.TROUGH, kinds.PLANE)

    @property
    def _center(self) -> list[Fraction]:
        x, gradient = self._solution
        if not self._opens:
            return x
        t = -self._value(x) / (2 * rational.dot(gradient, gradient))
        return [c + t * g for c, g in zip(x, gradient, strict=True)]

    def _equal(self, squares: list[ex.Exact]) -> bool:
        """Are two eigenvalues other than zero equal?"""
        if len(self.null) > 1 or self.kind in kinds.DEGENERATE:
            return False
        if self.still:
            return rational.has_equal_eigenvalues([row[:3] for row in self.matrix[:3]])
        found = [s for s in squares if s]
        largest = max(abs(s) for s in found)
        gaps = [abs(a - b) for i, a in enumerate(found) for b in found[:i]]
        return bool(min(gaps) <= _SAME * largest)

    def _order(self, squares: list[ex.Exact], same: bool) -> list[int]:
        """Which eigenvalue stands first, second and last."""
        if self.kind in (kinds.TROUGHS, kinds.CROSSING, kinds.SADDLE):
            first_is_positive = self.kind == kinds.SADDLE or (self.kind == kinds.TROUGHS and self._constant < 0)
            return sorted(range(3), key=lambda k: (not squares[k], (squares[k] > 0) != first_is_positive))
        order = sorted(range(3), key=lambda k: (not squares[k], squares[k] < 0, squares[k]))
        if self.kind in (kinds.ELLIPSOID, kinds.SPHERE) and same:
            a, b, c = (squares[k] for k in order)
            if b - a > c - b:  # the odd one stands first
                order = [order[1], order[2], order[0]]
        return order

    def _axes(self, rows: list[Any]) -> tuple[ex.Row, ex.Row, ex.Row]:
        first = _leading(ex.exact_row(rows[0]))
        if not self._opens:
            last = _leading(ex.exact_row(rows[2]))
            return first, ex.cross(last, first), last
        gradient = self._solution[1]
        x, y, z = (ex.exact(-g) for g in gradient)
        opening = ex.unit((x, y, z))
        if self.kind == kinds.TROUGH:
            return first, opening, ex.cross(first, opening)
        if self.kind == kinds.PLANE:
            least = min(range(3), key=lambda i: abs(opening[i]))
            first = ex.unit(ex.cross(opening, ex.IDENTITY[least]))
        return first, ex.cross(opening, first), opening

    def _measures(self, sizes: list[ex.Exact]) -> list[ex.Exact]:
        root, kind = ex.sqrt, self.kind
        sizes = [s for s in sizes if s]
        if kind in (kinds.BOWL, kinds.SADDLE, kinds.TROUGH):
            gradient = self._solution[1]
            slope = root(ex.exact(rational.dot(gradient, gradient)))
            return [slope / s for s in sizes]
        if kind == kinds.CONE:
            return [root(sizes[2] / s) for s in sizes[:2]]
        if kind == kinds.CROSSING:
            return [root(sizes[0] / sizes[1])]
        if kind in (kinds.PLANE, kinds.LINE, kinds.POINT, kinds.DOUBLE):
            return []
        constant = abs(ex.exact(self._constant))
        return [root(constant / s) for s in sizes]


def _all_equal(squares: list[ex.Exact]) -> bool:
    return bool(max(squares) - min(squares) <= _SAME * max(abs(s) for s in squares))


def _leading(row: ex.Row) -> ex.Row:
    """The same or the opposite vector: its first component that is not zero is positive."""
    sign = next((c for c in row if c), ex.ONE)
    return row if sign > 0 else (-row[0], -row[1], -row[2])


def _quiet(point: list[Fraction], size: ex.Exact) -> ex.Row:
    """3000 bits of a point, with zeros for what is only their rounding."""
    x, y, z = (ex.exact(c) for c in point)
    noise = _NOISE * max(size, abs(x), abs(y), abs(z))
    x, y, z = (ex.ZERO if abs(c) < noise else c for c in (x, y, z))
    return x, y, z


def _rounded(row: ex.Row) -> Vector:
    x, y, z = (float(c) + 0.0 for c in row)
    return x, y, z
