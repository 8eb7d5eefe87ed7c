"""The two kinds of surface that bound all shapes, planes and quadrics, with exact parameters.

A surface is data: numbers about an anchor near the part in use. The numbers may be floats, fractions or 3000-bit
numbers. `moved` carries a surface by a motion without rounding, and lowering rounds each number once. `key` is equal
for equal surfaces, whatever their anchor, sign and scale.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

from ..numerics import bigfloat as ex
from ..numerics.portable_math import count_nonzero, portable_sqrt
from .transform import Motion

Triple: TypeAlias = tuple[Any, Any, Any]
Triples: TypeAlias = tuple[Triple, Triple, Triple]
Key: TypeAlias = tuple[Any, ...]

ORIGIN: Triple = (0.0, 0.0, 0.0)
_KEY_BITS = 1500
"""Keys compare coefficients to so many bits."""
CENTER_TOLERANCE = 2.0**-46
"""A sphere whose center is rounded by more than this share of its radius becomes a quadric with its own bounds."""
UPRIGHT: Triples = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


@dataclass(frozen=True, slots=True)
class PlaneSurface:
    """normal·x - offset = 0; `anchor` is any point near the part in use, best on the plane."""

    normal: Triple
    offset: Any
    anchor: Triple = ORIGIN
    over: Any = field(default=None, compare=False)
    """normal·anchor - offset if it is known: no motion changes it."""
    is_offset_better: bool = field(default=False, compare=False)
    """True if heights are better computed from the offset. Turns keep it: most are by quarters, which round nothing."""

    @property
    def height(self) -> ex.BigFloat:
        """normal·anchor - offset"""
        if self.over is not None:
            return ex.exact(self.over)
        return ex.dot(ex.exact_row(self.normal), ex.exact_row(self.anchor), -ex.exact(self.offset))

    def moved(self, motion: Motion) -> PlaneSurface:
        """Return the image. The inverse transpose of the motion carries normals."""
        if motion.is_identity:
            return self
        back, back_shift = motion.inverse
        normal, anchor = ex.exact_row(self.normal), ex.exact_row(self.anchor)
        offset = ex.cancelling_sum((ex.exact(self.offset), -ex.dot(normal, back_shift)))
        turned = self.normal if motion.shift is not None else ex.apply(ex.transpose(back), normal)
        return PlaneSurface(turned, offset, motion.carried(anchor), self.height, self.is_offset_better)

    def reversed(self) -> PlaneSurface:
        """Return the plane with its other side inside."""
        x, y, z = self.normal
        over = None if self.over is None else -self.over
        return PlaneSurface((-x, -y, -z), -self.offset, self.anchor, over, self.is_offset_better)

    moved_rows = moved
    """The image, as of `QuadricSurface.moved_rows`."""

    def key(self) -> tuple[Key, int]:
        """Return (a key of the plane, +1 or -1 for the sense of its normal)."""
        return _normalize_key("plane", (*ex.exact_row(self.normal), ex.exact(self.offset)))


@dataclass(frozen=True, slots=True)
class QuadricSurface:
    """sum of squares[i] y_i² + 2 linear[i] y_i - constant = 0, where y = rows (x - anchor).

    Inside is where the left side is negative. `rows` is invertible, seldom anything but the
    identity before a motion; a motion changes `rows` and `anchor` only.
    """

    squares: Triple
    linear: Triple = ORIGIN
    constant: Any = 1.0
    rows: Triples = UPRIGHT
    anchor: Triple = ORIGIN

    def moved(self, motion: Motion) -> QuadricSurface:
        """Return the image. A ball that stays a ball keeps its rows."""
        ball = None if motion.is_identity or motion.shift is not None else self._moved_ball(motion)
        return ball or self.moved_rows(motion)

    def moved_rows(self, motion: Motion) -> QuadricSurface:
        """Return the image: the inverse motion leads to own coordinates, in which the equation stays the same."""
        if motion.is_identity:
            return self
        if motion.shift is not None and self.anchor is ORIGIN:
            return QuadricSurface(self.squares, self.linear, self.constant, self.rows, motion.shift)
        back, _ = motion.inverse
        own = tuple(ex.exact_row(row) for row in self.rows)
        rows = ex.multiply((own[0], own[1], own[2]), back) if back is not ex.IDENTITY else self.rows
        return QuadricSurface(self.squares, self.linear, self.constant, rows, motion.carried(ex.exact_row(self.anchor)))

    def _moved_ball(self, motion: Motion) -> QuadricSurface | None:
        """Return the image of a ball under a similarity, with the square of its radius.

        Return None for any other surface or motion, and for a ball so small that the rounding of its center matters:
        its record then uses the rows.
        """
        if self.rows is not UPRIGHT or any(self.linear) or not self.constant > 0:
            return None
        if count_nonzero([ex.rounded(square - 1) for square in self.squares]):  # a single test of three numbers
            return None
        factor = motion.similarity
        if factor is None:
            return None
        anchor, square = motion.carried(ex.exact_row(self.anchor)), ex.exact(self.constant) * factor * factor
        square = ex.cancelling_sum((square,))
        radius = portable_sqrt(ex.rounded(square))
        rests = (ex.cancelling_sum((value, -ex.exact(ex.rounded(value)))) for value in anchor)
        if any(abs(ex.rounded(rest)) > CENTER_TOLERANCE * radius for rest in rests):
            return None
        return QuadricSurface(self.squares, self.linear, square, self.rows, anchor)

    def reversed(self) -> QuadricSurface:
        """Return the quadric with its other side inside."""
        (a, b, c), (x, y, z) = self.squares, self.linear
        return QuadricSurface((-a, -b, -c), (-x, -y, -z), -self.constant, self.rows, self.anchor)

    def coefficients(self) -> tuple[ex.BigFloat, ...]:
        """Return the coefficients (xx, yy, zz, xy, xz, yz, x, y, z, 1) of the polynomial about the world's origin.

        The mixed and linear entries are half the coefficients, as in a symmetric matrix.
        """
        return tuple(ex.cancelling_sum(terms) for terms in self.terms())

    def terms(self) -> list[list[ex.BigFloat]]:
        """Return for each of `coefficients` the terms of its sum."""
        w = tuple(ex.exact_row(row) for row in self.rows)
        s, b = ex.exact_row(self.squares), ex.exact_row(self.linear)
        anchor = ex.exact_row(self.anchor)
        # y = W x + shift
        shift = tuple(-ex.dot(row, anchor) for row in w)
        # Most rows are along the axes: products of zeros would take most of the time
        second = [
            [t for k in range(3) for t in _product(s[k], w[k][i], w[k][j])]
            for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
        ]
        first = [
            [t for k in range(3) for t in (*_product(s[k], shift[k], w[k][i]), *_product(b[k], w[k][i]))]
            for i in range(3)
        ]
        constant = [t for k in range(3) for t in (*_product(s[k], shift[k], shift[k]), *_product(2 * b[k], shift[k]))]
        return [*second, *first, [*constant, -ex.exact(self.constant)]]

    def key(self) -> tuple[Key, int]:
        """Return (a key of the quadric, +1 or -1 for the sense of its inside)."""
        return _normalize_key("quadric", self.coefficients())


def expand_quadric(
    squares: Sequence[Any], linear: Sequence[Any], constant: Any, rows: Any, shift: Sequence[Any], zero: Any
) -> list[Any]:
    """Return ten coefficients of the sum of squares[i] y_i² + 2 linear[i] y_i - constant, y = rows r + shift, in r.

    They are (xx, yy, zz, xy, xz, yz, x, y, z, 1), mixed and linear ones halved; `zero` is that of the type of number.
    """
    second = [
        sum((squares[k] * rows[k][i] * rows[k][j] for k in range(3)), zero)
        for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
    ]
    first = [sum(((squares[k] * shift[k] + linear[k]) * rows[k][i] for k in range(3)), zero) for i in range(3)]
    return [*second, *first, sum((shift[k] * (squares[k] * shift[k] + 2 * linear[k]) for k in range(3)), -constant)]


def _product(*factors: ex.BigFloat) -> list[ex.BigFloat]:
    """Return a list of the product; an empty one where a factor is exactly zero."""
    return [] if any(map(ex.is_nothing, factors)) else [math.prod(factors[1:], start=factors[0])]


Surface: TypeAlias = PlaneSurface | QuadricSurface


def _normalize_key(kind: str, coefficients: Sequence[ex.BigFloat]) -> tuple[Key, int]:
    """Return the coefficients divided by the first nonzero one and rounded to `_KEY_BITS`, and the sign of that one."""
    lead = next((c for c in coefficients if c), ex.ONE)
    ratios = tuple(ex.cut(c / lead, _KEY_BITS) for c in coefficients)
    return (kind, *ratios), 1 if lead > 0 else -1
