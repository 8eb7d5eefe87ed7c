"""Motions of many shapes that are moved alike, step by step in columns, and checked all at once.

What a column leaves open is only marked: whoever makes the motion alone finds out, or tells what is wrong with it.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import repeat
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from .._util.arrays import FloatArray, Matrix4, Vector
from .._util.pickling import construct_many
from .._util.validation import is_outside_domain, looks_like_radians
from .transform import CLEAR_DETERMINANT, SAFE_REACH, Motion, Reach, Rotate, Scale, Step, Transform, Translate

Bools = npt.NDArray[np.bool_]


class ReachColumn(NamedTuple):
    """The bounds of `Reach`, arrays of them or numbers for all."""

    stretch: Any
    back: Any
    shift: Any


class StepColumn(NamedTuple):
    """A step of each of many motions."""

    steps: Iterable[Step]
    reach: Reach | ReachColumn
    good: Bools | bool
    """Which are well beyond doubt."""


def repeat_step(step: Step) -> StepColumn:
    """A step that all have, and that was checked when it was made."""
    return StepColumn(repeat(step), step.reach(), True)


def translate_column(offsets: Sequence[Vector]) -> StepColumn:
    """A translation of each, by tuples of three floats."""
    rows = np.array(offsets)
    return StepColumn(_make_steps(Translate, "offset", offsets), ReachColumn(1.0, 1.0, _sizes(rows)), _in_domain(rows))


def scale_column(factors: Sequence[Vector]) -> StepColumn:
    """A scaling of each, by tuples of three floats."""
    sizes = np.abs(np.array(factors))
    least = sizes.min(axis=1)
    good = _in_domain(sizes) & (least > 0)
    reach = ReachColumn(sizes.max(axis=1), 1 / np.where(good, least, 1.0), 0.0)
    return StepColumn(_make_steps(Scale, "factors", factors), reach, good)


def rotate_column(axes: Sequence[Vector], degrees: Sequence[float]) -> StepColumn:
    """A turn of each about an axis, a tuple of three floats. What may be in radians, which is warned of, is open."""
    rows, angles = np.array(axes), np.array(degrees)
    good = _in_domain(rows) & rows.any(axis=1) & ~is_outside_domain(angles)
    for place in np.flatnonzero(np.abs(angles) < _FEW_DEGREES).tolist():
        good[place] &= not looks_like_radians(degrees[place])
    steps = construct_many(Rotate, len(degrees), axis=axes, degrees=degrees)
    return StepColumn(steps, ReachColumn(1.0, 1.0, 0.0), good)


def transform_column(matrices: Sequence[Matrix4]) -> StepColumn:
    """An affine map of each, by tuples of four rows of four floats."""
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
"""Angles beyond this are none in radians, see `is_of_radians`."""


def compose_motions(count: int, chain: Sequence[StepColumn], before: Reach) -> tuple[list[Motion], Bools]:
    """The motions of many shapes, of one step of each column, and which are well beyond doubt.

    before: of what the shapes were moved by already.
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
    found: Bools = ~is_outside_domain(rows).any(axis=1)
    return found


def _sizes(rows: FloatArray) -> FloatArray:
    """What no length of a row exceeds, but for roundings."""
    found: FloatArray = np.abs(rows).sum(axis=1)
    return found
