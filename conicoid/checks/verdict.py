"""What is said about a body that loses digits: how many are left, where, by which number, and why."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..shapes import exact as ex
from ..shapes.motion import Motion
from ..shapes.vector import FloatArray
from .changes import HALF_ULP
from .local import Frame
from .movement import Movement

ALL_DIGITS = 53 * math.log10(2)
"""What float64 has: 15.95."""
_NOTABLE = 1e3


@dataclass(frozen=True, eq=False)
class Conditioning:
    """What is left of a body's digits where that is least.

    body      its id
    part      the kind of the primitive
    digits    decimal digits that remain, 0 to 15.95: -log10 of `movement`
    movement  how far the surface moves, in units of the part's extent in that direction, when each number that was
              written changes by a relative 2^-53
    number    the number that most of it comes from
    point     (3,) where that is
    reason    why, in words
    """

    body: int
    part: str
    digits: float
    movement: float
    number: str
    point: FloatArray
    reason: str


def digits_of(relative: float) -> float:
    """-log10, between none and all that float64 has."""
    return ALL_DIGITS if relative <= 0 else min(max(-math.log10(relative), 0.0), ALL_DIGITS)


def verdict(leaf: Any, motion: Motion, body: int, moved: Movement, frame: Frame) -> Conditioning:
    """The worst place of a part: `frame` takes its local coordinates to its own, `motion` those to the world."""
    linear, shift = motion.affine
    z = ex.exact_row(moved.local.tolist())
    own = ex.exact_row(ex.dot(row, z, start) for row, start in zip(frame.columns, frame.origin, strict=True))
    point = np.array([float(ex.dot(row, own, t)) for row, t in zip(linear, shift, strict=True)])
    return Conditioning(
        body,
        type(leaf).__name__,
        digits_of(moved.relative),
        moved.relative,
        _number(moved.number, motion),
        point,
        _reason(moved, point, linear, ex.multiply(linear, frame.columns)),
    )


def _number(name: str, motion: Motion) -> str:
    """As scene files have it: steps[0].degrees of a rotation is move[0].rotate.degrees."""
    found = re.match(r"steps\[(\d+)\]\.(.*)", name)
    if found is None:
        return name
    step, field = int(found[1]), found[2]
    verb = type(motion.steps[step]).__name__.lower()
    field = re.sub(r"^(offset|factors|matrix)", "", field)
    return f"move[{step}].{verb}{field if not field or field.startswith('[') else f'.{field}'}"


def _sine(normals: FloatArray) -> float:
    """The volume that one, two or three vectors of length 1 along others span: 0 where they are parallel."""
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    if len(normals) == 1 or not lengths.all():
        return 1.0
    units = normals / lengths
    across = np.cross(units[0], units[1])
    return float(np.linalg.norm(across) if len(units) == 2 else abs(across @ units[2]))


def _reason(moved: Movement, point: FloatArray, linear: ex.Rows, to_world: ex.Rows) -> str:
    """What has been measured there and is large, the largest first."""
    if moved.relative < _NOTABLE * HALF_ULP:
        return "no digits are lost"
    back, forth = _floats(ex.inverse(to_world)), _floats(to_world)
    with np.errstate(all="ignore"):  # sizes may be beyond float64
        slope = np.linalg.norm(moved.gradient @ back)
        width = moved.width / slope if 0 < slope < math.inf else np.linalg.norm(forth, -2)
        far, long = float(np.linalg.norm(point) / width), float(np.linalg.norm(forth, 2) / width)
        stretch = float(np.linalg.cond(_floats(linear)))
        sine = 1.0 if moved.normals is None else _sine(moved.normals @ back)
    causes = [
        (far, f"it lies {far:.1e} times its extent from the origin"),
        (long, f"it is {long:.1e} times as long as thick"),
        (stretch, f"its motion is nearly singular, of condition number {stretch:.1e}"),
        (1 / sine if sine else 0.0, f"surfaces meet there at {sine:.1e} rad"),
        (math.inf if moved.singular else 0.0, "its surfaces touch, or one has a double point, there"),
    ]
    words = [words for size, words in sorted(causes, reverse=True) if size > _NOTABLE]
    return ", ".join(words[:2]) or "its numbers cancel"


def _floats(rows: ex.Rows) -> FloatArray:
    return np.array([[float(c) for c in row] for row in rows])
