"""Motions of many shapes with the same kinds of steps, built from columns of numbers and checked all at once.

Columns only mark rows in doubt. The caller builds these motions one by one, which decides or raises the error.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import repeat
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from .._util.arrays import FloatArray, Matrix4, Vector
from .._util.validation import is_outside_domain, looks_like_radians
from .._util.value_objects import construct_many
from .transform import CLEAR_DETERMINANT, SAFE_REACH, Motion, Reach, Rotate, Scale, Step, Transform, Translate

Bools = npt.NDArray[np.bool_]


class ReachColumn(NamedTuple):
    """The bounds of `Reach` for many motions: arrays (n,), or one number for all."""

    stretch: Any
    back: Any
    shift: Any


class StepColumn(NamedTuple):
    """One step of each of many motions."""

    steps: Iterable[Step]
    reach: Reach | ReachColumn
    good: Bools | bool
    """Which rows are valid beyond doubt."""


def repeat_step(step: Step) -> StepColumn:
    """Return the column of one step, checked before, that all motions have."""
    return StepColumn(repeat(step), step.reach(), True)


def translate_column(offsets: Sequence[Vector]) -> StepColumn:
    """Return a column of translations, by tuples of three floats."""
    rows = np.array(offsets)
    return StepColumn(_make_steps(Translate, "offset", offsets), ReachColumn(1.0, 1.0, _sizes(rows)), _in_domain(rows))


def scale_column(factors: Sequence[Vector]) -> StepColumn:
    """Return a column of scalings, by tuples of three floats."""
    sizes = np.abs(np.array(factors))
    least = sizes.min(axis=1)
    good = _in_domain(sizes) & (least > 0)
    reach = ReachColumn(sizes.max(axis=1), 1 / np.where(good, least, 1.0), 0.0)
    return StepColumn(_make_steps(Scale, "factors", factors), reach, good)


def rotate_column(axes: Sequence[Vector], degrees: Sequence[float]) -> StepColumn:
    """Return a column of turns about axes, tuples of three floats. Angles that may be in radians are in doubt."""
    rows, angles = np.array(axes), np.array(degrees)
    good = _in_domain(rows) & rows.any(axis=1) & ~is_outside_domain(angles)
    # Such an angle makes the step alone warn
    for place in np.flatnonzero(np.abs(angles) < _FEW_DEGREES).tolist():
        good[place] &= not looks_like_radians(degrees[place])
    steps = construct_many(Rotate, len(degrees), axis=axes, degrees=degrees)
    return StepColumn(steps, ReachColumn(1.0, 1.0, 0.0), good)


def transform_column(matrices: Sequence[Matrix4]) -> StepColumn:
    """Return a column of affine maps, by tuples of four rows of four floats."""
    rows = np.array(matrices)
    good = _in_domain(rows.reshape(len(rows), 16)) & (rows[:, 3] == (0.0, 0.0, 0.0, 1.0)).all(axis=1)
    linear = np.where(good[:, None, None], rows[:, :3, :3], 1.0)
    across = np.cross(linear[:, 1], linear[:, 2])
    volume = np.abs((linear[:, 0] * across).sum(axis=1))
    x, y, z = (_sizes(linear[:, k]) for k in range(3))
    good &= volume > CLEAR_DETERMINANT * (x * y * z)
    back = 1.01 * (x * y + y * z + z * x) / np.where(good, volume, 1.0)
    shift = _sizes(np.where(good[:, None], rows[:, :3, 3], 0.0))
    return StepColumn(_make_steps(Transform, "matrix", matrices), ReachColumn(x + y + z, back, shift), good)


_FEW_DEGREES = 13.0
"""Angles beyond this are surely in degrees, see `looks_like_radians`."""


def compose_motions(count: int, chain: Sequence[StepColumn], before: Reach) -> tuple[list[Motion], Bools]:
    """Return (the motions of many shapes, which of them are valid beyond doubt), with one step of each column.

    `before` bounds the motions that the shapes have already.
    """
    reach: Any = before
    good = np.ones(count, bool)
    with np.errstate(over="ignore", invalid="ignore"):
        for each in chain:
            reach = Reach.then(reach, each.reach)  # type: ignore[arg-type]
            good &= each.good
        for bound in reach:
            good &= bound <= SAFE_REACH
    rows = zip(*(each.steps for each in chain), strict=False) if chain else repeat((), count)
    return construct_many(Motion, count, steps=rows), good


def _make_steps(kind: type[Any], field: str, values: Sequence[Any]) -> list[Any]:
    return construct_many(kind, len(values), **{field: values})


def _in_domain(rows: FloatArray) -> Bools:
    return ~is_outside_domain(rows).any(axis=1)


def _sizes(rows: FloatArray) -> FloatArray:
    """Return upper bounds of the lengths of rows, up to rounding."""
    return np.abs(rows).sum(axis=1)
