"""Boolean bodies from the rows of their primitives: bodies that are built alike are put together at once.

How a body is built is a `Plan`: its tree of Boolean nodes with places for the primitives. What primitives have become
(`Form`: pattern and tree of cells) and the plan give the body's pattern, and where each of its columns comes from.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from ...shapes.base import PrimitiveSolid, Shape, Solid
from ...shapes.cells import Cell, Not, Tree
from ...shapes.ellipsoid import Ellipsoid
from ...shapes.material import Material
from ...shapes.region import Boolean, Complement, Difference, Painted, Union
from ...shapes.sphere import Sphere
from ...shapes.steps import Step
from ..tables import CELL, REGION, Floats
from .assembly import UNBOUNDED, Assembly, Slot
from .pattern import BOX_NUMBERS, FRAME_NUMBERS, UV_NUMBERS, Pattern
from .trees import EMPTY, cells, combined, widened

_ROUND = (Sphere, Ellipsoid)
"""Kinds whose outside no box bounds, if nothing cuts them."""


@dataclass(frozen=True, eq=False)
class Form:
    """What primitives of one kind have become. There is one of each (`Forms`)."""

    pattern: Pattern
    tree: Tree | None


class Forms:
    """The forms that there are."""

    def __init__(self) -> None:
        self._known: dict[Hashable, Form] = {}

    def of(self, pattern: Pattern, tree: Tree | None) -> Form:
        """The one of a pattern and a tree."""
        return self._known.setdefault((pattern, tree), Form(pattern, tree))


FORMS = Forms()


@dataclass(slots=True)
class Plan:
    """How a Boolean body is built, and its primitives from left to right with the steps that move each."""

    key: tuple[Hashable, ...]
    leaves: list[tuple[Shape, tuple[Step, ...]]]
    painted: list[tuple[int, int, Material]]  # first and last leaf, from the innermost paint outward


def plan_of(solid: Boolean) -> Plan | None:
    """The plan of a solid; None where there is more in it than primitives and Boolean nodes."""
    key: list[Hashable] = []
    leaves: list[tuple[Shape, tuple[Step, ...]]] = []
    painted: list[tuple[int, int, Material]] = []
    pending: list[tuple[Any, tuple[Step, ...], int]] = [(solid, (), -1)]
    while pending:
        node, steps, first = pending.pop()
        if first >= 0:
            painted.append((first, len(leaves), node.material))
            continue
        mine = node.motion.steps
        inner = mine + steps if mine else steps
        if isinstance(node, Boolean):
            operands = node.operands
            key.append((type(node), len(operands)))
            if isinstance(node, Painted):
                pending.append((node, steps, len(leaves)))
            pending.extend((part, inner, -1) for part in reversed(operands))
        elif isinstance(node, PrimitiveSolid):
            key.append(type(node))
            leaves.append((node, inner))
        else:
            return None
    return Plan(tuple(key), leaves, painted)


@dataclass
class Composition:
    """The pattern of bodies of one plan and these forms, and where the columns of their rows come from."""

    pattern: Pattern
    sources: list[tuple[int, int, int]] = field(default_factory=list)
    """Up to the boxes of leaves: (part, first column, last column)."""
    boxes: list[int] = field(default_factory=list)
    """For each leaf of the program the part whose box holds it; -1 for none."""
    faces: list[int] = field(default_factory=list)
    """The first face of each part."""

    @classmethod
    def of(cls, key: Sequence[Hashable], forms: Sequence[Form]) -> Composition:
        """Put the trees of the forms together as the plan says."""
        trees, faces, count = [], [], 0
        for part, form in enumerate(forms):
            assert form.tree is not None
            trees.append(_placed(form.tree, part, count, form.pattern))
            faces.append(count)
            count += len(form.pattern.angular)
        tree = _folded(key, trees)
        held = {id(cell): part for part, of in enumerate(trees) for cell in cells(of)}
        assembly = Assembly()
        if isinstance(tree, Cell):
            kind, index = CELL, assembly.cell(tree)
        else:
            kind, index = REGION, assembly.program(tree, held)
        angular = [bool(turns) for form in forms for turns in form.pattern.angular]
        sources = []
        for slot in assembly.surfaces:
            assert isinstance(slot, Slot)
            _, column, sense = forms[slot.part].pattern.records[slot.number]
            sources.append((slot.part, column, sense + 1))
        for part, form in enumerate(forms):
            sources.append((part, form.pattern.uv_at, form.pattern.uv_at + UV_NUMBERS * len(form.pattern.angular)))
        boxes = [-1 if box is UNBOUNDED else box for box in assembly.leaf_bounds]
        return cls(Pattern.of(assembly, kind, index, angular), sources, boxes, faces)

    def rows(self, parts: Sequence[Floats], boxes: Floats, frames: Floats) -> Floats:
        """Rows of bodies from those of their parts, (n, columns) each, their boxes and their frames."""
        count, at = len(boxes), 0
        rows = np.empty((count, self.pattern.width))
        for part, first, last in self.sources:
            rows[:, at : at + last - first] = parts[part][:, first:last]
            at += last - first
        grown = {part: widened(box_columns(parts[part])) for part in set(self.boxes) if part >= 0}
        for part in self.boxes:
            rows[:, at : at + BOX_NUMBERS] = grown[part] if part >= 0 else UNBOUNDED
            at += BOX_NUMBERS
        rows[:, at : at + BOX_NUMBERS] = boxes
        rows[:, at + BOX_NUMBERS :] = frames
        return rows


def box_columns(rows: Floats) -> Floats:
    """The boxes in rows of primitives without polygons, which end with box and frame."""
    return rows[:, -BOX_NUMBERS - FRAME_NUMBERS : -FRAME_NUMBERS]


def _placed(tree: Tree, part: int, first_face: int, pattern: Pattern) -> Tree:
    """The tree of a form as one part of a body."""
    if isinstance(tree, Cell):
        return Cell(
            tuple(
                dataclasses.replace(
                    face,
                    surface=Slot(int(pattern.kinds[face.surface]), part, face.surface),  # type: ignore[arg-type, call-overload]
                    number=first_face + face.number,
                )
                for face in tree.faces
            )
        )
    if isinstance(tree, Not):
        return Not(_placed(tree.part, part, first_face, pattern))
    return type(tree)(tuple(_placed(each, part, first_face, pattern) for each in tree.parts))


def _folded(key: Sequence[Hashable], leaves: Sequence[Any]) -> Tree:
    """The tree of a plan, whose nodes come before their operands, from those of its leaves."""
    results: list[Any] = []
    rest = list(leaves)
    for entry in reversed(key):
        if not isinstance(entry, tuple):
            results.append(rest.pop())
            continue
        kind, count = entry
        parts = results[-count:][::-1]
        del results[-count:]
        results.append(combined(kind, parts))
    return results[0]


class _Bounded(NamedTuple):
    """A part of a plan: boxes, or None for all of space; is there nothing that would bound its outside?"""

    boxes: Floats | None
    hole: bool


def plain_boxes(key: Sequence[Hashable], leaves: Sequence[Shape], boxes: Sequence[Floats]) -> Floats | None:
    """Boxes of bodies by those of their parts, (n, 6) each; None where planes of one part may narrow another.

    The same as `shapes.region.region_bounds`: unions surround, and of an intersection only one part has a bound, all
    others being complements of what has none outside.
    """
    results: list[_Bounded] = []
    rest = [
        _Bounded(box, _bounds_nothing_outside(shape)) for shape, box in zip(leaves, boxes, strict=True)  # type: ignore[arg-type]
    ]  # fmt: skip
    for entry in reversed(key):
        if not isinstance(entry, tuple):
            results.append(rest.pop())
            continue
        kind, count = entry
        parts = results[-count:][::-1]
        del results[-count:]
        made = _bounded(kind, parts)
        if made is None:
            return None
        results.append(made)
    found = results[0].boxes
    if found is None:
        return np.tile(np.array(UNBOUNDED), (len(boxes[0]), 1))
    return np.where(np.asarray((found[:, :3] > found[:, 3:]).any(axis=1))[:, None], EMPTY, found)


def _bounded(kind: Hashable, parts: Sequence[_Bounded]) -> _Bounded | None:
    """`plain_boxes` of one node."""
    if kind is Complement:
        return _Bounded(None, False) if parts[0].hole else None
    if kind is Painted or len(parts) == 1:
        return parts[0]
    if kind is Union:
        every = [part.boxes for part in parts]
        known = [boxes for boxes in every if boxes is not None]
        return _Bounded(_around(known) if len(known) == len(every) else None, all(part.hole for part in parts))
    if kind is Difference:
        return _Bounded(parts[0].boxes, False) if all(part.hole for part in parts[1:]) else None
    bounded = [part for part in parts if part.boxes is not None]
    return _Bounded(bounded[0].boxes if bounded else None, False) if len(bounded) < 2 else None


def _bounds_nothing_outside(solid: PrimitiveSolid) -> bool:
    """Is the outside of a solid without a plane or a quadric that would bound it?"""
    if type(solid).outside_bounds_under is not Solid.outside_bounds_under:
        return False
    tree = solid.tree()
    return isinstance(tree, Cell) and (len(tree.faces) > 1 or isinstance(solid, _ROUND))


def _around(boxes: Sequence[Floats]) -> Floats:
    """Boxes around boxes, row by row; empty ones do not count."""
    low = np.full((len(boxes[0]), 3), np.inf)
    high = -low
    for box in boxes:
        held = np.asarray((box[:, :3] <= box[:, 3:]).all(axis=1))[:, None]
        low = np.where(held, np.minimum(low, box[:, :3]), low)
        high = np.where(held, np.maximum(high, box[:, 3:]), high)
    return np.concatenate([low, high], axis=1)
