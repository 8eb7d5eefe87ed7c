"""Bounds of Boolean bodies of one plan by the boxes of their primitives, where these say enough.

They are what `shapes.region.region_bounds` finds with more work: unions surround, and parts of an intersection narrow
one another. Where only one part of an intersection has a bound, and the others are complements of what has none
outside, the box is that part's. Where several have, it is the box that is common to them if every side of it is
reached: by the middle of a face of a box, or a pole of an ellipsoid, that lies within all other parts.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ...shapes.base import PrimitiveSolid, Shape, Solid
from ...shapes.box import Box
from ...shapes.cells import Cell
from ...shapes.ellipsoid import Ellipsoid
from ...shapes.region import Complement, Difference, Intersection, Painted, Union
from ...shapes.sphere import Sphere
from ..tables import Floats
from .assembly import UNBOUNDED
from .pattern import BOX_NUMBERS, FRAME_NUMBERS
from .plan import folded
from .trees import EMPTY

Mask = npt.NDArray[np.bool_]
_ROUND = (Sphere, Ellipsoid)
"""Kinds whose outside no box bounds, if nothing cuts them."""
_WITHIN = 1e-6
"""What is within an ellipsoid or a box by this share of its size is within it in spite of rounding."""


def box_columns(rows: Floats) -> Floats:
    """The boxes in rows of primitives without polygons, which end with box and frame."""
    return rows[:, -BOX_NUMBERS - FRAME_NUMBERS : -FRAME_NUMBERS]


@dataclass
class _Part:
    """A primitive of each body: its boxes, whether it is a ball, a box, or else; where its axes are the world's."""

    boxes: Floats
    kind: str
    aligned: Mask


@dataclass
class _Bounded:
    """A node of a plan: boxes, or None for all of space; for which bodies these are right.

    hole: is there nothing that would bound its outside? parts: the primitives that it is common to; None for a union.
    """

    boxes: Floats | None
    known: Mask
    hole: bool = False
    parts: tuple[_Part, ...] | None = ()


def boxes_of(key: Sequence[Hashable], leaves: Sequence[Shape], rows: Sequence[Floats]) -> tuple[Floats, Mask]:
    """Boxes (n, 6) of bodies with a row for each of their primitives, and for which of them they are known."""
    primitives = [_of_primitive(shape, of_part) for shape, of_part in zip(leaves, rows, strict=True)]
    whole: _Bounded = folded(key, primitives, _combined)
    found = whole.boxes
    if found is None:
        return np.tile(np.array(UNBOUNDED), (len(rows[0]), 1)), whole.known
    return np.where(np.asarray((found[:, :3] > found[:, 3:]).any(axis=1))[:, None], EMPTY, found), whole.known


def _of_primitive(shape: Shape, rows: Floats) -> _Bounded:
    boxes = box_columns(rows)
    entries = (rows[:, -FRAME_NUMBERS:].reshape(-1, 3, 4)[:, :, :3] != 0).sum(axis=2)
    kind = "round" if isinstance(shape, Sphere) else "box" if isinstance(shape, Box) else ""
    part = _Part(boxes, kind, np.asarray((entries == 1).all(axis=1)))
    return _Bounded(boxes, np.ones(len(rows), bool), _bounds_nothing_outside(shape), (part,))


def _bounds_nothing_outside(shape: Shape) -> bool:
    """Is the outside of a solid without a plane or a quadric that would bound it?"""
    if not isinstance(shape, PrimitiveSolid) or type(shape).outside_bounds_under is not Solid.outside_bounds_under:
        return False
    tree = shape.tree()
    return isinstance(tree, Cell) and (len(tree.faces) > 1 or isinstance(shape, _ROUND))


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
    boxes_in_common, reached = _common(together)
    return _Bounded(boxes_in_common, known & reached, False, together)


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
    """(the boxes common to primitives, is every side of them reached by a point of all).

    Ends of parts whose axes are the world's are the least floats that hold them. So where the part that makes a side
    has a point there that is well within the others, nothing that holds their common points ends before.
    """
    low = np.max([part.boxes[:, :3] for part in parts], axis=0)
    high = np.min([part.boxes[:, 3:] for part in parts], axis=0)
    sure = np.asarray(np.logical_and.reduce([part.aligned & bool(part.kind) for part in parts]))
    sure &= np.asarray((low < high).all(axis=1)) & np.isfinite(low).all(axis=1) & np.isfinite(high).all(axis=1)
    with np.errstate(all="ignore"):
        for axis in range(3):
            for end in (low, high):
                reached = np.zeros(len(low), bool)
                for part in parts:
                    reached |= _reaches(part, parts, axis, end, low, high)
                sure &= reached
    return np.concatenate([low, high], axis=1), sure


def _reaches(part: _Part, parts: Sequence[_Part], axis: int, end: Floats, low: Floats, high: Floats) -> Mask:
    """Has a part a point on the end of the common box along an axis that is well within the others?"""
    own = part.boxes[:, :3] if end is low else part.boxes[:, 3:]
    middle = (low + high) / 2 if part.kind == "box" else (part.boxes[:, :3] + part.boxes[:, 3:]) / 2
    point = middle.copy()
    point[:, axis] = end[:, axis]
    reached = own[:, axis] == end[:, axis]
    across = [k for k in range(3) if k != axis]
    size = high - low
    reached &= np.asarray(
        ((point - low)[:, across] > _WITHIN * size[:, across]).all(axis=1)
        & ((high - point)[:, across] > _WITHIN * size[:, across]).all(axis=1)
    )
    for other in parts:
        if other is part:
            continue
        if other.kind == "round":
            center, half = (other.boxes[:, :3] + other.boxes[:, 3:]) / 2, (other.boxes[:, 3:] - other.boxes[:, :3]) / 2
            reached &= np.asarray((((point - center) / half) ** 2).sum(axis=1) < 1 - _WITHIN)
        elif part.kind == "round":
            its = other.boxes[:, :3] if end is low else other.boxes[:, 3:]
            reached &= its[:, axis] != end[:, axis]
    return reached
