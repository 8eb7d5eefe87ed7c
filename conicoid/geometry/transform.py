"""Affine motions: the steps (translations, turns, scalings, matrices, frames) and `Motion`, their exact product.

A motion is a tuple of steps about the world's origin, applied first to last. Scene files show the steps. Lowering asks
once for the product in 3000-bit arithmetic (`numerics/bigfloat.py`) and for the inverse, which is that of the
steps from last to first.

Each step has its map and the inverse map in 3000 bits; the factor by which it changes all lengths, if there is one; and
bounds in floats, which are enough to show that numbers stay in their domain.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterable
from functools import cached_property, lru_cache
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from .._util.arrays import FloatArray, Matrix4, Vector
from .._util.records import dataclass, pickle_state
from .._util.validation import LARGEST, check_degrees as as_degrees, check_matrix4, check_vector, format_value
from ..numerics import bigfloat as ex
from ..numerics.portable_math import least_axis

Affine: TypeAlias = tuple[ex.Rows, ex.Row]
"""x ↦ rows x + shift"""

ZERO_SHIFT: ex.Row = (ex.ZERO, ex.ZERO, ex.ZERO)
"""The shift of a map that keeps the origin."""
CLEAR_DETERMINANT = 2.0**-40
"""A determinant above this share of the product of its rows is not zero, and floats give it to four digits."""


class Reach(NamedTuple):
    """Upper bounds of the entries of a motion and of its inverse, in floats that may be some ulps off."""

    stretch: float
    """A bound of the norm of the linear part."""
    back: float
    """A bound of the norm of its inverse; inf if floats cannot show that the inverse exists."""
    shift: float
    """A bound of the length of the shift."""

    def then(self, other: Reach) -> Reach:
        """Return the bounds of this motion followed by the other."""
        return Reach(self.stretch * other.stretch, self.back * other.back, self.shift * other.stretch + other.shift)


IDENTITY_REACH = Reach(1.0, 1.0, 0.0)


class _Step:
    """The base class of steps. Many motions share a step, so it caches its maps."""

    def similarity(self) -> ex.BigFloat | None:
        """Return the factor by which all lengths grow, 1 unless a subclass says more; None if there is none."""
        return ex.ONE

    def __getstate__(self) -> dict[str, Any]:
        return pickle_state(self)

    @cached_property
    def forth_and_back(self) -> tuple[Affine, Affine]:
        """(`affine`, `inverse`), computed once."""
        return self.affine(), self.inverse()

    def affine(self) -> Affine:
        """Return the map of points, in 3000 bits."""
        raise NotImplementedError

    def inverse(self) -> Affine:
        """Return the inverse map, in 3000 bits."""
        raise NotImplementedError


@dataclass(frozen=True)
class Translate(_Step):
    """x ↦ x + offset"""

    offset: Vector

    def affine(self) -> Affine:
        return ex.IDENTITY, ex.exact_row(self.offset)

    def inverse(self) -> Affine:
        x, y, z = ex.exact_row(self.offset)
        return ex.IDENTITY, (-x, -y, -z)

    def reach(self) -> Reach:
        return Reach(1.0, 1.0, _sum_magnitudes(self.offset))


@dataclass(frozen=True)
class Rotate(_Step):
    """A right-handed turn about `axis` through the origin, in degrees (Rodrigues' formula)."""

    axis: Vector
    degrees: float

    def affine(self) -> Affine:
        return self._rows(), ZERO_SHIFT

    def inverse(self) -> Affine:
        # The inverse of a rotation, without a division
        return ex.transpose(self._rows()), ZERO_SHIFT

    def reach(self) -> Reach:
        return IDENTITY_REACH

    def _rows(self) -> ex.Rows:
        s, c = ex.sin_cos_degrees(self.degrees)
        along = [i for i in range(3) if self.axis[i]]
        if len(along) == 1:  # exact zeros and ones, and no root
            return _rotation_about_axis(along[0], s if self.axis[along[0]] > 0 else -s, c)
        x, y, z = ex.unit(ex.exact_row(self.axis))
        k = 1 - c
        return (
            (ex.dot((x * x, c), (k, ex.ONE)), ex.dot((x * y, -z), (k, s)), ex.dot((x * z, y), (k, s))),
            (ex.dot((x * y, z), (k, s)), ex.dot((y * y, c), (k, ex.ONE)), ex.dot((y * z, -x), (k, s))),
            (ex.dot((x * z, -y), (k, s)), ex.dot((y * z, x), (k, s)), ex.dot((z * z, c), (k, ex.ONE))),
        )


@dataclass(frozen=True)
class Scale(_Step):
    """x ↦ (kx x, ky y, kz z); negative factors mirror."""

    factors: Vector

    def affine(self) -> Affine:
        return _diagonal(ex.exact_row(self.factors)), ZERO_SHIFT

    def inverse(self) -> Affine:
        x, y, z = ex.exact_row(self.factors)
        return _diagonal((1 / x, 1 / y, 1 / z)), ZERO_SHIFT

    def similarity(self) -> ex.BigFloat | None:
        x, y, z = map(abs, self.factors)
        return ex.exact(x) if x == y == z else None

    def reach(self) -> Reach:
        x, y, z = map(abs, self.factors)
        return Reach(max(x, y, z), 1 / min(x, y, z), 0.0)


@dataclass(frozen=True)
class Transform(_Step):
    """x ↦ M x in homogeneous coordinates; the last row of M is (0, 0, 0, 1)."""

    matrix: Matrix4

    def affine(self) -> Affine:
        rows = tuple(ex.exact_row(row[:3]) for row in self.matrix[:3])
        return (rows[0], rows[1], rows[2]), ex.exact_row(row[3] for row in self.matrix[:3])

    def inverse(self) -> Affine:
        rows, shift = self.affine()
        back = ex.inverse(rows)
        x, y, z = ex.apply(back, shift)
        return back, (-x, -y, -z)

    def similarity(self) -> ex.BigFloat | None:
        """Return sqrt(q) if the Gram matrix is q times the identity. It is |det| / q, so it is rational."""
        rows, _ = self.affine()
        square = ex.dot(rows[0], rows[0])
        # Rows across each other and of one length: only such a map keeps balls round
        if any(ex.dot(rows[i], rows[j]) for i, j in ((0, 1), (0, 2), (1, 2))):
            return None
        return ex.sqrt(square) if square == ex.dot(rows[1], rows[1]) == ex.dot(rows[2], rows[2]) else None

    def reach(self) -> Reach:
        a, b, c = (row[:3] for row in self.matrix[:3])
        across = (b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0])
        volume = abs(a[0] * across[0] + a[1] * across[1] + a[2] * across[2])
        x, y, z = _sum_magnitudes(a), _sum_magnitudes(b), _sum_magnitudes(c)
        # The columns of the adjugate are cross products of two rows, no longer than the product of their lengths
        back = 1.01 * (x * y + y * z + z * x) / volume if volume > CLEAR_DETERMINANT * (x * y * z) else math.inf
        return Reach(x + y + z, back, _sum_magnitudes(row[3] for row in self.matrix[:3]))


@dataclass(frozen=True)
class AxisFrame(_Step):
    """The motion from own coordinates to a frame with its origin at `origin` and z along `axis`.

    x points to `reference`, projected across the axis (Sasaki 2021, equation 2, with the projection of its errata).
    Without a reference, x points to the coordinate axis that is least along `axis`.
    """

    origin: Vector
    axis: Vector | ex.Row
    reference: Vector | None = None

    def affine(self) -> Affine:
        return ex.transpose(self._axes), ex.exact_row(self.origin)

    def inverse(self) -> Affine:
        rows, origin = self._axes, ex.exact_row(self.origin)
        x, y, z = ex.apply(rows, origin)
        if not any(ex.cross(ex.exact_row(self.axis), origin)):
            # An axis through zero: products with its unit vectors could not show it
            x = y = ex.ZERO
        return rows, (-x, -y, -z)

    def reach(self) -> Reach:
        return Reach(1.0, 1.0, _sum_magnitudes(self.origin))

    @cached_property
    def _axes(self) -> ex.Rows:
        """The directions of x, y and z."""
        axis = ex.exact_row(self.axis)
        if self.reference is None and not any(isinstance(entry, ex.Symbol) for entry in axis):
            leads = [k for k, entry in enumerate(axis) if not ex.is_nothing(entry)]
            if len(leads) == 1:  # a coordinate axis needs no roots
                x, z = ex.IDENTITY[leads == [0]], ex.IDENTITY[leads[0]]
                z = z if axis[leads[0]] > ex.ZERO else (-z[0], -z[1], -z[2])
                return x, ex.cross(z, x), z
        z = ex.unit(axis)
        if self.reference is None:
            towards = ex.exact_row(least_axis(axis))
        else:
            towards = ex.minus(ex.exact_row(self.reference), ex.exact_row(self.origin))
        along = ex.dot(towards, z)
        aside = ex.minus(towards, (along * z[0], along * z[1], along * z[2]))
        across, size = ex.cross(z, towards), ex.sqrt(ex.dot(aside, aside))  # z × aside is z × towards, and as long
        x, y = ((row[0] / size, row[1] / size, row[2] / size) for row in (aside, across))
        return x, y, z


Step: TypeAlias = Translate | Rotate | Scale | Transform | AxisFrame


def _sum_magnitudes(values: Iterable[float]) -> float:
    """Return the sum of magnitudes, an upper bound of the length."""
    return sum(map(abs, values))


def _diagonal(factors: ex.Row) -> ex.Rows:
    x, y, z = factors
    return (x, ex.ZERO, ex.ZERO), (ex.ZERO, y, ex.ZERO), (ex.ZERO, ex.ZERO, z)


def _rotation_about_axis(axis: int, s: ex.BigFloat, c: ex.BigFloat) -> ex.Rows:
    """Return the turn about a coordinate axis with this sine and cosine."""
    o, i = ex.ZERO, ex.ONE
    if axis == 0:
        return (i, o, o), (o, c, -s), (o, s, c)
    return ((c, o, s), (o, i, o), (-s, o, c)) if axis == 1 else ((c, -s, o), (s, c, o), (o, o, i))


# Motions
#
# A motion that extends another one takes over the products that are known of it, so that a chain of n calls costs n
# products, not n² / 2.

FloatRows: TypeAlias = tuple[tuple[float, float, float, float], ...]

SAFE_REACH = LARGEST * (1 - 1e-6)
"""Bounds below this are certain: the rounding error of a million steps is far smaller."""

_REPR_STEPS = 8
"""Reprs leave out the middle of chains that are longer."""


def _format_step(step: Step) -> str:
    """Return the method call that adds the step."""
    if isinstance(step, Translate):
        return f".translate({step.offset})"
    if isinstance(step, Rotate):
        return f".rotate({step.axis}, {step.degrees})"
    if isinstance(step, Scale):
        return f".scale({step.factors})"
    return f".transform({step.matrix})" if isinstance(step, Transform) else f".{step}"


@dataclass(frozen=True)
class Motion:
    """A chain of steps, first to last, immutable.

    `then`, `translate`, `rotate`, `scale` and `transform` return longer chains.
    """

    steps: tuple[Step, ...] = ()

    @property
    def calls(self) -> str:
        """The steps as method calls, for the repr of a shape, without the middle of a long chain."""
        calls = [_format_step(step) for step in self.steps]
        if len(calls) > _REPR_STEPS:
            half = _REPR_STEPS // 2
            calls[half:-half] = [f" ... {len(calls) - 2 * half} more moves ... "]
        return "".join(calls)

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in pickle_state(self).items() if name != "_parts"}

    def then(self, other: Motion) -> Motion:
        """Return this motion followed by `other`."""
        if not other.steps:
            return self
        if not self.steps:
            return other
        both = Motion(self.steps + other.steps)
        known = {name: self.__dict__[name] for name in _INHERITED_PARTS if name in self.__dict__}
        if known:  # a reference to the motion itself would keep the whole chain before it alive
            both.__dict__["_parts"] = known, other
        return both

    def placed(self, placement: Motion) -> Motion:
        """Return the shape's `placement` followed by this motion; `carried` applies one and then the other."""
        both = placement.then(self)
        if placement.steps and self.steps:
            both.__dict__["_placement"] = placement, self
        return both

    def carried(self, point: ex.Row) -> ex.Row:
        """Return the image of a point.

        The placement and the motion after it are applied in turn. So the end of an axis is exact: the placement takes
        it to the point of the shape's field.
        """
        placement, then = self.__dict__.get("_placement", (None, self))
        if placement is not None:
            return then.carried(placement.carried(point))
        rows, shift = self.affine
        return ex.plus(ex.apply(rows, point) if rows is not ex.IDENTITY else point, shift)

    def translate(self, offset: Any) -> Motion:
        return self.then(Motion((Translate(check_vector("translate", "offset", offset)),)))

    def rotate(self, axis: Any, degrees: Any) -> Motion:
        step = Rotate(parse_axis("rotate", "axis", axis), as_degrees("rotate", "degrees", degrees))
        return self.then(Motion((step,)))

    def scale(self, factors: Any) -> Motion:
        if isinstance(factors, (int, float, np.number)):
            factors = (factors, factors, factors)
        if isinstance(factors, str):
            raise ValueError(f"scale: factors must be one number or 3 numbers, got {format_value(factors)}")
        x, y, z = check_vector("scale", "factors", factors)
        # A flattened body has no inside
        if x == 0 or y == 0 or z == 0:
            raise ValueError(f"scale: factors must not be zero, got {(x, y, z)}")
        return self.then(Motion((Scale((x, y, z)),)))

    def transform(self, matrix: Any) -> Motion:
        rows = check_matrix4("transform", "matrix", matrix)
        if rows[3] != (0, 0, 0, 1):
            raise ValueError(f"transform: matrix must be affine, its last row (0, 0, 0, 1), got {rows[3]}")
        step = Transform(rows)
        # Floats show for nearly all matrices that the determinant is not zero
        if math.isinf(step.reach().back) and not ex.determinant(step.affine()[0]):
            raise ValueError("transform: matrix must be invertible, its determinant is 0")
        return self.then(Motion((step,)))

    @property
    def shift(self) -> Vector | None:
        """The offset if the motion is a single translation, which needs no exact arithmetic; else None."""
        first = self.steps[0] if len(self.steps) == 1 else None
        return first.offset if isinstance(first, Translate) else None

    def _last_factor(self, name: str) -> tuple[Any, Any]:
        """Return (a product of the motion that this one extends, or None if unknown; the motion that follows)."""
        known, other = self.__dict__.get("_parts", ({}, None))
        return known.get(name), other

    @cached_property
    def affine(self) -> Affine:
        """The product of all steps as (3 rows, translation), in 3000 bits."""
        before, other = self._last_factor("affine")
        if before is not None:
            return _compose_affine(before, other.affine)
        return functools.reduce(_compose_affine, (step.forth_and_back[0] for step in self.steps), _IDENTITY_AFFINE)

    @cached_property
    def inverse(self) -> Affine:
        """The inverse map as (3 rows, translation), in 3000 bits."""
        before, other = self._last_factor("inverse")
        if before is not None:
            return _compose_affine(other.inverse, before)
        return functools.reduce(
            _compose_affine, (step.forth_and_back[1] for step in reversed(self.steps)), _IDENTITY_AFFINE
        )

    @cached_property
    def axis_images(self) -> AxisImages:
        """For each axis the axis to which the linear part takes it, and the sign; None where it goes to no axis."""
        return _axis_images(tuple(step for step in self.steps if not isinstance(step, Translate)))

    @cached_property
    def similarity(self) -> ex.BigFloat | None:
        """The factor by which all lengths change if each step is a similarity by itself; else None."""
        before, other = self._last_factor("similarity")
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
        before, other = self._last_factor("reach")
        if before is not None:
            return Reach.then(before, other.reach)
        return functools.reduce(Reach.then, (step.reach() for step in self.steps), IDENTITY_REACH)

    @property
    def rows(self) -> FloatRows:
        """The first three rows of `matrix`."""
        return _translation_rows(self.shift) if self.shift is not None else _round_rows(*self.affine)

    @property
    def inverse_rows(self) -> FloatRows:
        """The first three rows of `inverse_matrix`."""
        if self.shift is not None:
            x, y, z = self.shift
            return _translation_rows((-x, -y, -z))
        return _round_rows(*self.inverse)

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
        """Raise ValueError if the product leaves the domain of numbers: by bounds, or exactly if they leave it open."""
        stretch, back, shift = self.reach
        if stretch <= SAFE_REACH and back <= SAFE_REACH and shift <= SAFE_REACH:
            return
        try:
            # The shift of the inverse may be large where the scene is far away, which does no harm
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
"""Name -> direction, for axes that have names."""


def parse_axis(owner: str, field: str, axis: Any) -> Vector:
    """Return the vector of "x", "y" or "z", with or without a sign, or of three numbers that are not all 0.

    Raise ValueError for anything else.
    """
    if isinstance(axis, str) and axis not in AXES:
        raise ValueError(
            f"{owner}: {field} must be 3 numbers, or 'x', 'y', 'z', '-x', '-y', '-z', got {format_value(axis)}"
        )
    return AXES[axis] if isinstance(axis, str) else check_vector(owner, field, axis, nonzero=True)


AxisImages: TypeAlias = tuple[tuple[int, int] | None, ...]


@lru_cache(maxsize=1 << 12)
def _axis_images(turns: tuple[Step, ...]) -> AxisImages:
    """`Motion.axis_images` of steps."""
    # Cached, since many bodies are turned alike, and to compose a motion exactly takes a millisecond
    rows = Motion(turns).affine[0]
    images: list[tuple[int, int] | None] = []
    for column in zip(*rows, strict=True):
        i = next((i for i in range(3) if column[i]), 0)
        is_axis = abs(column[i]) == ex.ONE and sum(map(bool, (*rows[i], *column))) == 2
        images.append((i, 1 if column[i] > ex.ZERO else -1) if is_axis else None)
    return tuple(images)


IDENTITY_MOTION = Motion()
_IDENTITY_AFFINE: Affine = (ex.IDENTITY, ZERO_SHIFT)
_INHERITED_PARTS = ("affine", "inverse", "similarity", "reach")
"""The cached products that a motion passes on to motions that extend it."""


def _compose_affine(first: Affine, then: Affine) -> Affine:
    """Return the map `first` followed by the map `then`."""
    rows, shift = first
    linear, offset = then
    if linear is not ex.IDENTITY:
        rows = ex.multiply(linear, rows) if rows is not ex.IDENTITY else linear
        shift = ex.apply(linear, shift)
    return rows, ex.plus(shift, offset)


def _translation_rows(offset: Vector) -> FloatRows:
    x, y, z = offset
    return (1.0, 0.0, 0.0, x), (0.0, 1.0, 0.0, y), (0.0, 0.0, 1.0, z)


def _round_rows(rows: ex.Rows, shift: ex.Row) -> FloatRows:
    first, second, third = (
        (ex.rounded(x), ex.rounded(y), ex.rounded(z), ex.rounded(end))
        for (x, y, z), end in zip(rows, shift, strict=True)
    )
    return first, second, third


def apply_about(owner: str, motion: Motion, point: Any, step: Callable[[Motion], Motion]) -> Motion:
    """Return a motion followed by a step about a point, or about the origin if `point` is None.

    These are three exact steps: from the point to the origin, `step`, and back.
    """
    if point is None:
        return step(motion)
    x, y, z = check_vector(owner, "about", point)
    return step(motion.translate((0.0 - x, 0.0 - y, 0.0 - z))).translate((x, y, z))
