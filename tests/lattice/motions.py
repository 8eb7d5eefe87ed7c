"""Affine maps over the field, and what they do to polynomials."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from .field import Number, cosine, number, root, sine

Row = tuple[Number, ...]
ZERO, ONE = number(0), number(1)
PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2), (0, 3), (1, 3), (2, 3), (3, 3))
"""The order of the ten coefficients: those of X_i X_j with X = (x, y, z, 1)."""


def row(values: Sequence[Any]) -> Row:
    return tuple(number(v) for v in values)


def total(values: Any) -> Number:
    return sum(values, ZERO)


def dot(a: Sequence[Any], b: Sequence[Any]) -> Number:
    return total(number(x) * y for x, y in zip(a, b, strict=True))


def cross(a: Sequence[Any], b: Sequence[Any]) -> Row:
    return tuple(number(a[i]) * b[j] - number(a[j]) * b[i] for i, j in ((1, 2), (2, 0), (0, 1)))


@dataclass(frozen=True)
class Affine:
    """x ↦ rows x + shift"""

    rows: tuple[Row, ...]
    shift: Row = (ZERO, ZERO, ZERO)

    def point(self, x: Sequence[Any]) -> Row:
        return tuple(dot(r, x) + s for r, s in zip(self.rows, self.shift, strict=True))

    def after(self, first: Affine) -> Affine:
        columns = tuple(zip(*first.rows, strict=True))
        rows = tuple(tuple(dot(r, c) for c in columns) for r in self.rows)
        return Affine(rows, tuple(dot(r, first.shift) + s for r, s in zip(self.rows, self.shift, strict=True)))

    def backwards(self) -> tuple[tuple[Row, ...], int]:
        """(four rows of the inverse times the determinant's magnitude, the determinant's sign)"""
        a, b, c = zip(*self.rows, strict=True)
        volume = dot(a, cross(b, c))
        sign = volume.sign
        assert sign, "a motion must have an inverse"
        rows = [tuple(x * sign for x in cross(p, q)) for p, q in ((b, c), (c, a), (a, b))]
        full = tuple((*r, -dot(r, self.shift)) for r in rows)
        return (*full, (ZERO, ZERO, ZERO, volume * sign)), sign


IDENTITY = Affine(tuple(row(r) for r in ((1, 0, 0), (0, 1, 0), (0, 0, 1))))


def step(verb: str, *arguments: Any) -> Affine:
    """The map of one step, as the user wrote it."""
    if verb == "translate":
        return Affine(IDENTITY.rows, row(arguments[0]))
    if verb == "scale":
        k = row(arguments[0] if hasattr(arguments[0], "__len__") else (arguments[0],) * 3)
        return Affine(tuple(tuple(k[i] if i == j else ZERO for j in range(3)) for i in range(3)))
    if verb == "transform":
        rows = [row(r) for r in arguments[0]]
        return Affine(tuple(r[:3] for r in rows[:3]), tuple(r[3] for r in rows[:3]))
    assert verb == "rotate", verb
    return rotation(row(arguments[0]), arguments[1])


def rotation(axis: Row, degrees: Any) -> Affine:
    """cos 1 + (1 - cos) k kᵀ / k² + sin [k]× / |k|, of an axis of rational components"""
    square = dot(axis, axis).k[1]
    s, c = sine(degrees) * root(1 / square), cosine(degrees)
    x, y, z = axis
    wedge = ((ZERO, -z, y), (z, ZERO, -x), (-y, x, ZERO))
    return Affine(
        tuple(
            tuple(
                (c if i == j else ZERO) + (1 - c) * axis[i] * axis[j] * (1 / square) + s * wedge[i][j] for j in range(3)
            )
            for i in range(3)
        )
    )


def chain(steps: Sequence[Sequence[Any]]) -> Affine:
    """Steps composed first to last."""
    result = IDENTITY
    for one in steps:
        result = step(*one).after(result)
    return result
