"""Bounds of Boolean bodies of one plan by the boxes of their primitives, where these say enough.

They are what `shapes.region.region_bounds` finds with more work: unions surround, and parts of an intersection narrow
one another. Where only one part of an intersection has a bound, and the others are complements of what has none
outside, the box is that part's. Where several have, and these are balls and boxes along the axes, it is that of
`shapes.ball_bounds`.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ...shapes.ball_bounds import bounds_nothing_outside, simple, within_balls
from ...shapes.base import Shape, Solid
from ...shapes.region import Complement, Difference, Intersection, Painted, Union
from ...shapes.sphere import Sphere
from ..tables import Floats
from .assembly import UNBOUNDED
from .pattern import BOX_NUMBERS, FRAME_NUMBERS
from .plan import folded
from .rows import Rows
from .trees import EMPTY

Mask = npt.NDArray[np.bool_]


def box_columns(rows: Rows) -> Floats:
    """The boxes in rows of primitives without polygons, which end with box and frame."""
    boxes: Floats = rows[:, -BOX_NUMBERS - FRAME_NUMBERS : -FRAME_NUMBERS]
    return boxes


@dataclass
class _Part:
    """A primitive of each body: its boxes, and what kind of shape it is."""

    boxes: Floats
    kind: type
    rows: Rows

    @property
    def is_ball(self) -> bool:
        """Is it a ball, where it is `simple`?"""
        return issubclass(self.kind, Sphere)

    def simple(self) -> Mask:
        """For which bodies is it a ball, or an upright box?"""
        return simple(self.kind, self.rows[:, -FRAME_NUMBERS:].reshape(-1, 3, 4)[:, :, :3])


@dataclass
class _Bounded:
    """A node of a plan: boxes, or None for all of space; for which bodies these are right.

    hole: is there nothing that would bound its outside? parts: the primitives that it is common to; None for a union.
    """

    boxes: Floats | None
    known: Mask
    hole: bool = False
    parts: tuple[_Part, ...] | None = ()


def boxes_of(key: Sequence[Hashable], leaves: Sequence[Shape], rows: Sequence[Rows]) -> tuple[Floats, Mask]:
    """Boxes (n, 6) of bodies with a row for each of their primitives, and for which of them they are known."""
    primitives = [_of_primitive(shape, of_part) for shape, of_part in zip(leaves, rows, strict=True)]
    whole: _Bounded = folded(key, primitives, _combined)
    found = whole.boxes
    if found is None:
        return np.tile(np.array(UNBOUNDED), (len(rows[0]), 1)), whole.known
    return np.where(np.asarray((found[:, :3] > found[:, 3:]).any(axis=1))[:, None], EMPTY, found), whole.known


def _of_primitive(shape: Shape, rows: Rows) -> _Bounded:
    boxes = box_columns(rows)
    part = _Part(boxes, type(shape), rows)
    return _Bounded(boxes, np.ones(len(rows), bool), _is_hole(shape), (part,))


def _is_hole(shape: Shape) -> bool:
    """Is there nothing that would bound the outside of a primitive? Kept with it, as copies of a body share theirs."""
    found: bool | None = shape.kept.get("hole")
    if found is None:
        found = shape.kept["hole"] = isinstance(shape, Solid) and bounds_nothing_outside(shape)
    return found


def _combined(kind: Hashable, parts: Sequence[_Bounded]) -> _Bounded:
    """A node from its operands."""
    known = np.asarray(np.logical_and.reduce([part.known for part in parts]))
    nowhere = _Bounded(None, np.zeros(len(known), bool), False, None)
    if kind is Complement:
        return _Bounded(None, known) if parts[0].hole else nowhere
    if kind is Painted or len(parts) == 1:
        return parts[0]
    if kind is Union:
        every = [part.boxes for part in parts]
        boxes = [each for each in every if each is not None]
        around = _around(boxes) if len(boxes) == len(every) else None
        return _Bounded(around, known, all(part.hole for part in parts), None)
    inside, outside = (parts[:1], parts[1:]) if kind is Difference else (parts, ())
    if not all(part.hole for part in outside) or kind not in (Difference, Intersection):
        return nowhere
    bounded = [part for part in inside if part.boxes is not None]
    if len(bounded) < 2:
        one = bounded[0] if bounded else _Bounded(None, known)
        return _Bounded(one.boxes, known, False, one.parts)
    if any(part.parts is None for part in bounded):  # planes would be handed on to the parts of a union
        return nowhere
    together = tuple(each for part in bounded for each in part.parts or ())
    boxes_in_common, good = _common(together)
    return _Bounded(boxes_in_common, known & good, False, together)


def _around(boxes: Sequence[Floats]) -> Floats:
    """Boxes around boxes, row by row; empty ones do not count."""
    low = np.full((len(boxes[0]), 3), np.inf)
    high = -low
    for box in boxes:
        held = np.asarray((box[:, :3] <= box[:, 3:]).all(axis=1))[:, None]
        low = np.where(held, np.minimum(low, box[:, :3]), low)
        high = np.where(held, np.maximum(high, box[:, 3:]), high)
    return np.concatenate([low, high], axis=1)


def _common(parts: Sequence[_Part]) -> tuple[Floats, Mask]:
    """(the boxes around what primitives have in common, are these known)."""
    boxes, good = within_balls([part.boxes for part in parts], [part.is_ball for part in parts])
    return boxes, np.asarray(np.logical_and.reduce([good, *(part.simple() for part in parts)]))
