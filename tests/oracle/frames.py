"""Affine maps: the steps a user moves a shape by, composed and inverted in 90 digits.

A step is a tuple: ("translate", offset), ("rotate", axis, degrees), ("scale", factors) or
("transform", matrix): the same tuples drive the library's verbs (`cases.moved`).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from .precision import ONE, ZERO, cross, dot, minus, number, plus, sine_cosine, unit, vector

Rows = tuple[tuple[Any, ...], ...]
UNIT_ROWS: Rows = ((ONE, ZERO, ZERO), (ZERO, ONE, ZERO), (ZERO, ZERO, ONE))


@dataclass(frozen=True, eq=False)
class Affine:
    """x ↦ rows x + shift"""

    rows: Rows = UNIT_ROWS
    shift: tuple[Any, ...] = (ZERO, ZERO, ZERO)

    def point(self, x: Sequence[Any]) -> tuple[Any, ...]:
        return plus(self.vector(x), self.shift)

    def vector(self, x: Sequence[Any]) -> tuple[Any, ...]:
        if self.rows is UNIT_ROWS:
            return tuple(x)
        return tuple(row[0] * x[0] + row[1] * x[1] + row[2] * x[2] for row in self.rows)

    def after(self, first: Affine) -> Affine:
        """This map applied to the result of `first`."""
        columns = transposed(first.rows)
        rows = tuple(tuple(dot(row, column) for column in columns) for row in self.rows)
        if self.rows is UNIT_ROWS and first.rows is UNIT_ROWS:
            rows = UNIT_ROWS
        return Affine(rows, self.point(first.shift))

    def inverse(self) -> Affine:
        """Cramer's rule."""
        if self.rows is UNIT_ROWS:
            return Affine(UNIT_ROWS, tuple(-s for s in self.shift))
        a, b, c = transposed(self.rows)
        volume = dot(a, cross(b, c))
        rows = tuple(tuple(x / volume for x in cross(p, q)) for p, q in ((b, c), (c, a), (a, b)))
        return Affine(rows, tuple(-dot(row, self.shift) for row in rows))


def transposed(rows: Rows) -> Rows:
    return tuple(zip(*rows, strict=True))


def step(kind: str, *arguments: Any) -> Affine:
    """The map of one motion step."""
    if kind == "translate":
        return Affine(UNIT_ROWS, vector(arguments[0]))
    if kind == "scale":
        factors = arguments[0] if hasattr(arguments[0], "__len__") else (arguments[0],) * 3
        kx, ky, kz = vector(factors)
        return Affine(((kx, ZERO, ZERO), (ZERO, ky, ZERO), (ZERO, ZERO, kz)))
    if kind == "transform":
        rows = [vector(row) for row in arguments[0]]
        return Affine(tuple(row[:3] for row in rows[:3]), tuple(row[3] for row in rows[:3]))
    assert kind == "rotate"
    return rotation(unit(vector(arguments[0])), arguments[1])


def rotation(axis: Sequence[Any], degrees: Any) -> Affine:
    """Each basis vector e turns to  (e·k) k + cos (e - (e·k) k) + sin (k × e)."""
    sine, cosine = sine_cosine(degrees)
    columns = []
    for e in UNIT_ROWS:
        along = tuple(dot(e, axis) * k for k in axis)
        columns.append(plus(plus(along, minus(e, along), cosine), cross(axis, e), sine))
    return Affine(transposed(tuple(columns)))


def chain(steps: Iterable[Sequence[Any]]) -> Affine:
    """Steps composed first to last."""
    result = Affine()
    for one in steps:
        result = step(*one).after(result)
    return result


def axis_frame(start: Sequence[Any], end: Sequence[Any], reference: Sequence[Any] | None) -> Affine:
    """Own frame of a body on an axis: origin at start, z along it, x towards the reference, projected.

    Without a reference, x is the coordinate axis that is least along the axis, projected.
    """
    origin = vector(start)
    z = unit(minus(vector(end), origin))
    if reference is None:
        least = min(range(3), key=lambda i: abs(z[i]))
        towards = UNIT_ROWS[least]
    else:
        towards = minus(vector(reference), origin)
    x = unit(minus(towards, tuple(dot(towards, z) * c for c in z)))
    return Affine(transposed((x, cross(z, x), z)), origin)


def translation(offset: Sequence[Any]) -> Affine:
    return Affine(UNIT_ROWS, tuple(number(c) for c in offset))
