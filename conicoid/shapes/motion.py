"""Affine motions, remembered as the steps a user asked for and composed exactly.

A `Motion` is a tuple of steps about the world's origin, applied first to last. Scene files show
the steps; lowering asks once for the product, in 3000-bit arithmetic (`exact.py`), and for the inverse, which is
that of the steps from last to first. A motion that goes on from another goes on from what is known of it.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np

from . import exact as ex
from .carried import said
from .degrees import degrees as as_degrees
from .steps import NOWHERE, STAYS, Affine, Frame, Reach, Rotate, Scale, Step, Transform, Translate
from .validate import LARGEST, matrix4, shown, vector
from .vector import FloatArray, Vector

FloatRows: TypeAlias = tuple[tuple[float, float, float, float], ...]

__all__ = [
    "AXES", "STILL", "Affine", "Frame", "Motion", "Rotate", "Scale", "Step", "Transform", "Translate", "named_axis",
]  # fmt: skip

CERTAIN = LARGEST * (1 - 1e-6)
"""Bounds below this leave nothing open: what floats lose in them is far less, for a million steps."""

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
        known = {name: self.__dict__[name] for name in _LASTING if name in self.__dict__}
        if known:  # not the motion itself, which would keep all that came before it
            both.__dict__["_parts"] = known, other
        return both

    def placed(self, placement: Motion) -> Motion:
        """The motion after a shape's own placement: points are carried by one and then the other."""
        both = placement.then(self)
        if placement.steps and self.steps:
            both.__dict__["_placement"] = placement, self
        return both

    def carried(self, point: ex.Row) -> ex.Row:
        """Where it takes a point. The end of an axis is exact so: its placement takes it to where it was said to be."""
        placement, then = self.__dict__.get("_placement", (None, self))
        if placement is not None:
            return then.carried(placement.carried(point))  # type: ignore[no-any-return]
        rows, shift = self.affine
        return ex.plus(ex.apply(rows, point) if rows is not ex.IDENTITY else point, shift)

    def translate(self, offset: Any) -> Motion:
        return self.then(Motion((Translate(vector("translate", "offset", offset)),)))

    def rotate(self, axis: Any, degrees: Any) -> Motion:
        step = Rotate(named_axis("rotate", "axis", axis), as_degrees("rotate", "degrees", degrees))
        return self.then(Motion((step,)))

    def scale(self, factors: Any) -> Motion:
        if isinstance(factors, (int, float, np.number)):
            factors = (factors, factors, factors)
        if isinstance(factors, str):
            raise ValueError(f"scale: factors must be one number or 3 numbers, got {shown(factors)}")
        x, y, z = vector("scale", "factors", factors)
        if x == 0 or y == 0 or z == 0:
            raise ValueError(f"scale: factors must not be zero, got {(x, y, z)}")
        return self.then(Motion((Scale((x, y, z)),)))

    def transform(self, matrix: Any) -> Motion:
        rows = matrix4("transform", "matrix", matrix)
        if rows[3] != (0, 0, 0, 1):
            raise ValueError(f"transform: matrix must be affine, its last row (0, 0, 0, 1), got {rows[3]}")
        step = Transform(rows)
        if math.isinf(step.reach().back) and not ex.determinant(step.affine()[0]):
            raise ValueError("transform: matrix must be invertible, its determinant is 0")
        return self.then(Motion((step,)))

    @property
    def shift(self) -> Vector | None:
        """The offset, where the motion is one translation and needs no exact arithmetic."""
        first = self.steps[0] if len(self.steps) == 1 else None
        return first.offset if isinstance(first, Translate) else None

    def _before(self, name: str) -> tuple[Any, Any]:
        """What is known by a name of the motion that this one goes on from, or None, and the motion that follows."""
        known, other = self.__dict__.get("_parts", ({}, None))
        return known.get(name), other

    @cached_property
    def affine(self) -> Affine:
        """The product of all steps as (3 rows, translation), in 3000 bits."""
        before, other = self._before("affine")
        if before is not None:
            return _product(before, other.affine)
        return functools.reduce(_product, (step.forth_and_back[0] for step in self.steps), _STILL)

    @cached_property
    def inverse(self) -> Affine:
        """The inverse map as (3 rows, translation), in 3000 bits."""
        before, other = self._before("inverse")
        if before is not None:
            return _product(other.inverse, before)
        return functools.reduce(_product, (step.forth_and_back[1] for step in reversed(self.steps)), _STILL)

    @cached_property
    def similarity(self) -> ex.Exact | None:
        """The factor by which all lengths change, where each step is a similarity by itself; else None."""
        before, other = self._before("similarity")
        factors = [before, other.similarity] if before is not None else [step.similarity() for step in self.steps]
        result = ex.ONE
        for factor in factors:
            if factor is None:
                return None
            result = ex.cancelling_sum((result * factor,)) if factor is not ex.ONE else result
        return result

    @cached_property
    def reach(self) -> Reach:
        """Bounds in floats, for `check`."""
        before, other = self._before("reach")
        if before is not None:
            return Reach.then(before, other.reach)
        return functools.reduce(Reach.then, (step.reach() for step in self.steps), STAYS)

    @property
    def rows(self) -> FloatRows:
        """The first three rows of `matrix`."""
        return _translated(self.shift) if self.shift is not None else _rounded(*self.affine)

    @property
    def inverse_rows(self) -> FloatRows:
        """The first three rows of `inverse_matrix`."""
        if self.shift is not None:
            x, y, z = self.shift
            return _translated((-x, -y, -z))
        return _rounded(*self.inverse)

    @cached_property
    def matrix(self) -> FloatArray:
        """(4, 4) float64, each entry rounded once."""
        return np.array([*self.rows, (0.0, 0.0, 0.0, 1.0)])

    @cached_property
    def inverse_matrix(self) -> FloatArray:
        """(4, 4) float64 of the inverse, each entry rounded once."""
        return np.array([*self.inverse_rows, (0.0, 0.0, 0.0, 1.0)])

    @property
    def is_identity(self) -> bool:
        return not self.steps

    def check(self, owner: str) -> None:
        """Refuse a product that leaves the domain of numbers: by bounds, and exactly where they leave it open."""
        stretch, back, shift = self.reach
        if stretch <= CERTAIN and back <= CERTAIN and shift <= CERTAIN:
            return
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
_STILL: Affine = (ex.IDENTITY, NOWHERE)
_LASTING = ("affine", "inverse", "similarity", "reach")
"""What a motion that goes on from another takes along, once it is known."""


def _product(first: Affine, then: Affine) -> Affine:
    """One map after the other."""
    rows, shift = first
    linear, offset = then
    if linear is not ex.IDENTITY:
        rows = ex.multiply(linear, rows) if rows is not ex.IDENTITY else linear
        shift = ex.apply(linear, shift)
    return rows, ex.plus(shift, offset)


def _translated(offset: Vector) -> FloatRows:
    x, y, z = offset
    return (1.0, 0.0, 0.0, x), (0.0, 1.0, 0.0, y), (0.0, 0.0, 1.0, z)


def _rounded(rows: ex.Rows, shift: ex.Row) -> FloatRows:
    first, second, third = (
        (ex.rounded(x), ex.rounded(y), ex.rounded(z), ex.rounded(end))
        for (x, y, z), end in zip(rows, shift, strict=True)
    )
    return first, second, third
