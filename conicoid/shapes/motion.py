"""Affine motions, remembered as the steps a user asked for and composed exactly.

A `Motion` is a tuple of steps about the world's origin, applied first to last. Scene files show
the steps; lowering asks once for the product, in 3000-bit arithmetic (`exact.py`). A motion that goes
on from another goes on from its product too.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np

from . import exact as ex
from .carried import said
from .validate import LARGEST, matrix4, number, numbers, shown, vector
from .vector import FloatArray, Matrix4, Vector

Affine: TypeAlias = tuple[ex.Rows, ex.Row]
"""x ↦ rows x + shift"""


@dataclass(frozen=True)
class Translate:
    """x ↦ x + offset"""

    offset: Vector

    def affine(self) -> Affine:
        return ex.IDENTITY, ex.exact_row(self.offset)


@dataclass(frozen=True)
class Rotate:
    """Right-handed turn about `axis` through the origin, in degrees (Rodrigues' formula)."""

    axis: Vector
    degrees: float

    def affine(self) -> Affine:
        x, y, z = ex.unit(ex.exact_row(self.axis))
        s, c = ex.sin_cos_degrees(self.degrees)
        k = 1 - c
        rows = (
            (ex.dot((x * x, c), (k, ex.ONE)), ex.dot((x * y, -z), (k, s)), ex.dot((x * z, y), (k, s))),
            (ex.dot((x * y, z), (k, s)), ex.dot((y * y, c), (k, ex.ONE)), ex.dot((y * z, -x), (k, s))),
            (ex.dot((x * z, -y), (k, s)), ex.dot((y * z, x), (k, s)), ex.dot((z * z, c), (k, ex.ONE))),
        )
        return rows, (ex.ZERO, ex.ZERO, ex.ZERO)


@dataclass(frozen=True)
class Scale:
    """x ↦ (kx x, ky y, kz z); negative factors mirror."""

    factors: Vector

    def affine(self) -> Affine:
        x, y, z = ex.exact_row(self.factors)
        rows = ((x, ex.ZERO, ex.ZERO), (ex.ZERO, y, ex.ZERO), (ex.ZERO, ex.ZERO, z))
        return rows, (ex.ZERO, ex.ZERO, ex.ZERO)


@dataclass(frozen=True)
class Transform:
    """x ↦ M x in homogeneous coordinates; the last row of M is (0, 0, 0, 1)."""

    matrix: Matrix4

    def affine(self) -> Affine:
        rows = tuple(ex.exact_row(row[:3]) for row in self.matrix[:3])
        return (rows[0], rows[1], rows[2]), ex.exact_row(row[3] for row in self.matrix[:3])


@dataclass(frozen=True)
class Frame:
    """Own coordinates to a frame with its origin at `origin` and z along `axis`.

    x points to `reference`, projected across the axis (Sasaki 2021, equation 2, with the projection
    that the errata ask for); without one, to the coordinate axis that is least along `axis`.
    """

    origin: Vector
    axis: Vector | ex.Row
    reference: Vector | None = None

    def affine(self) -> Affine:
        z = ex.unit(ex.exact_row(self.axis))
        origin = ex.exact_row(self.origin)
        if self.reference is None:
            axis = ex.exact_row(self.axis)
            least = min(range(3), key=lambda i: abs(axis[i]))
            towards = ex.IDENTITY[least]
        else:
            towards = ex.minus(ex.exact_row(self.reference), origin)
        along = ex.dot(towards, z)
        x = ex.unit(ex.minus(towards, (along * z[0], along * z[1], along * z[2])))
        return ex.transpose((x, ex.cross(z, x), z)), origin


Step = Translate | Rotate | Scale | Transform | Frame


_MOST_SHOWN = 8


def _call(step: Step) -> str:
    """A step as a user asks for it."""
    if isinstance(step, Translate):
        return f".translate({step.offset})"
    if isinstance(step, Rotate):
        return f".rotate({step.axis}, {step.degrees})"
    if isinstance(step, Scale):
        return f".scale({step.factors})"
    return f".transform({step.matrix})" if isinstance(step, Transform) else f".{step}"


@dataclass(frozen=True)
class Motion:
    """A chain of steps, first to last. Immutable; `then` and the four verbs give new ones."""

    steps: tuple[Step, ...] = ()

    @property
    def calls(self) -> str:
        """The steps as the methods of a shape that take them, for its repr; the middle of a long chain is left out."""
        shown = [_call(step) for step in self.steps]
        if len(shown) > _MOST_SHOWN:
            half = _MOST_SHOWN // 2
            shown[half:-half] = [f" ... {len(shown) - 2 * half} more moves ... "]
        return "".join(shown)

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in said(self).items() if name != "_parts"}

    def then(self, other: Motion) -> Motion:
        """The motion followed by `other`."""
        if not other.steps:
            return self
        if not self.steps:
            return other
        both = Motion(self.steps + other.steps)
        both.__dict__["_parts"] = self, other
        return both

    def translate(self, offset: Any) -> Motion:
        return self.then(Motion((Translate(vector("translate", "offset", offset)),)))

    def rotate(self, axis: Any, degrees: Any) -> Motion:
        step = Rotate(named_axis("rotate", "axis", axis), number("rotate", "degrees", degrees))
        return self.then(Motion((step,)))

    def scale(self, factors: Any) -> Motion:
        if isinstance(factors, (int, float, np.number)):
            factors = (factors, factors, factors)
        if isinstance(factors, str):
            raise ValueError(f"scale: factors must be one number or 3 numbers, got {shown(factors)}")
        x, y, z = numbers("scale", "factors", factors, 3)
        if x == 0 or y == 0 or z == 0:
            raise ValueError(f"scale: factors must not be zero, got {(x, y, z)}")
        return self.then(Motion((Scale((x, y, z)),)))

    def transform(self, matrix: Any) -> Motion:
        rows = matrix4("transform", "matrix", matrix)
        if rows[3] != (0, 0, 0, 1):
            raise ValueError(f"transform: matrix must be affine, its last row (0, 0, 0, 1), got {rows[3]}")
        step = Transform(rows)
        if not ex.determinant(step.affine()[0]):
            raise ValueError("transform: matrix must be invertible, its determinant is 0")
        return self.then(Motion((step,)))

    @property
    def shift(self) -> Vector | None:
        """The offset, where the motion is one translation and needs no exact arithmetic."""
        first = self.steps[0] if len(self.steps) == 1 else None
        return first.offset if isinstance(first, Translate) else None

    @cached_property
    def affine(self) -> Affine:
        """The product of all steps as (3 rows, translation), in 3000 bits."""
        parts: tuple[Motion, Motion] | None = self.__dict__.pop("_parts", None)
        if parts is not None and "affine" in parts[0].__dict__:
            return _product(parts[0].affine, parts[1].affine)
        return functools.reduce(_product, (step.affine() for step in self.steps), _STILL)

    @cached_property
    def inverse(self) -> Affine:
        """The inverse map as (3 rows, translation), in 3000 bits."""
        rows, shift = self.affine
        if rows is ex.IDENTITY:
            return rows, (-shift[0], -shift[1], -shift[2])
        back = ex.inverse(rows)
        x, y, z = ex.apply(back, shift)
        return back, (-x, -y, -z)

    @cached_property
    def matrix(self) -> FloatArray:
        """(4, 4) float64, each entry rounded once."""
        return _as_matrix(*self.affine) if self.shift is None else _translation(self.shift, 1.0)

    @cached_property
    def inverse_matrix(self) -> FloatArray:
        """(4, 4) float64 of the inverse, each entry rounded once."""
        return _as_matrix(*self.inverse) if self.shift is None else _translation(self.shift, -1.0)

    @property
    def is_identity(self) -> bool:
        return not self.steps

    def check(self, owner: str) -> None:
        """Refuse a product that leaves the domain of numbers."""
        try:
            inverse = self.inverse_matrix[:3, :3]
        except ZeroDivisionError:
            raise ValueError(f"{owner}: motion must be invertible, its determinant vanishes in 3000 bits") from None
        for name, entries in (("motion", self.matrix), ("inverse of motion", inverse)):
            largest = float(np.abs(entries).max())
            if not largest <= LARGEST:
                raise ValueError(f"{owner}: {name} must have entries of magnitude up to {LARGEST:g}, got {largest}")


AXES: dict[str, Vector] = {
    f"{sign}{letter}": (ends[0], ends[1], ends[2])
    for sign, size in (("", 1.0), ("+", 1.0), ("-", -1.0))
    for letter, ends in zip("xyz", ((size, 0.0, 0.0), (0.0, size, 0.0), (0.0, 0.0, size)), strict=True)
}
"""The axes that have names."""


def named_axis(owner: str, field: str, axis: Any) -> Vector:
    """The vector of "x", "y" or "z", with or without a sign, or three numbers that are not all 0."""
    if isinstance(axis, str) and axis not in AXES:
        raise ValueError(f"{owner}: {field} must be 3 numbers, or 'x', 'y', 'z', '-x', '-y', '-z', got {shown(axis)}")
    return AXES[axis] if isinstance(axis, str) else vector(owner, field, axis, nonzero=True)


STILL = Motion()
_STILL: Affine = (ex.IDENTITY, (ex.ZERO, ex.ZERO, ex.ZERO))


def _product(first: Affine, then: Affine) -> Affine:
    """One map after the other."""
    rows, shift = first
    linear, offset = then
    if linear is not ex.IDENTITY:
        rows = ex.multiply(linear, rows) if rows is not ex.IDENTITY else linear
        shift = ex.apply(linear, shift)
    return rows, ex.plus(shift, offset)


def _translation(offset: Vector, sign: float) -> FloatArray:
    result = np.eye(4)
    result[:3, 3] = offset
    result[:3, 3] *= sign
    return result


def _as_matrix(rows: ex.Rows, shift: ex.Row) -> FloatArray:
    result = np.eye(4)
    for i in range(3):
        result[i, :3] = [ex.rounded(x) for x in rows[i]]
        result[i, 3] = ex.rounded(shift[i])
    return result
