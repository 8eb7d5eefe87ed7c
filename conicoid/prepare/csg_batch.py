"""Boolean bodies in batches, and their composition from the rows of their primitives."""

from __future__ import annotations

import dataclasses
from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np

from ..geometry.bulk import Bulk
from ..geometry.cell import Cell, Not, Tree
from ..geometry.shape import Boolean
from ..geometry.transform import Motion
from ..kernels.tables import CELL, REGION, Floats, Ints
from .assembly import UNBOUNDED, Assembly, SurfaceSlot
from .csg_plan import CsgPlan, PrimitiveForm, box_columns, csg_plan, fold_plan
from .lower_shape import combine_trees, cullable_cells, widen_boxes
from .pattern import BOX_NUMBERS, FRAME_NUMBERS, BodyPattern, RowTable, row_blocks

# Boolean bodies of one plan: listed one by one, or many in one entry

_IN_PLACE = np.array([1.0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0])


@dataclass
class CsgBatch:
    """Boolean bodies of one plan.

    Their shapes, their plans without their own motions, their numbers, the places of their first leaves, and the rows
    of their frames.
    """

    shapes: list[Boolean] = field(default_factory=list)
    plans: list[CsgPlan] = field(default_factory=list)
    numbers: list[int] = field(default_factory=list)
    first: Ints = field(default_factory=lambda: np.zeros(0, np.int32))
    frames: Ints = field(default_factory=lambda: np.zeros(0, np.int32))

    def some(self, begin: int, end: int) -> CsgBatch:
        """Select some of the bodies, before they have places."""
        return CsgBatch(self.shapes[begin:end], self.plans[begin:end], self.numbers[begin:end])

    def of(self, index: int) -> tuple[Boolean, CsgPlan]:
        """Return one of the bodies, and its plan."""
        plan = csg_plan(self.shapes[index])
        assert plan is not None
        return self.shapes[index], plan

    def frames_of(self, rows: Ints, known: Floats) -> Floats:
        """Return maps from world to local coordinates of the bodies (n, 12).

        `rows` are rows of `known`; a negative row stands for a body with a translation or no motion. Nothing is rounded
        in a translation, so its inverse is the negated offset, as in `Motion.inverse_rows`.
        """
        if len(known):
            found = known[rows]
        else:
            found = np.empty((len(rows), FRAME_NUMBERS))
        plain = np.flatnonzero(rows < 0)
        found[plain] = _IN_PLACE
        shifted = [place for place in plain.tolist() if self.shapes[place].motion.steps]
        found[shifted, 3::4] = -np.array([self.shapes[place].motion.shift for place in shifted]).reshape(-1, 3)
        return found

    def columns(self) -> tuple[Ints, Ints, Ints]:
        """Return body numbers, places and rows of frames as arrays."""
        return np.array(self.numbers, np.int32), self.first, self.frames


@dataclass
class CsgArray:
    """Many Boolean bodies in one entry: number of the first body, place of its first leaf, and the frame of all."""

    shape: Bulk
    number: int
    first: int
    frame: int

    def of(self, index: int) -> tuple[Boolean, CsgPlan]:
        """`CsgBatch.of`"""
        shape = self.shape.single(index)
        assert isinstance(shape, Boolean)
        plan = csg_plan(shape)
        assert plan is not None
        return shape, plan

    def frames_of(self, rows: Ints, known: Floats) -> Floats:
        """`CsgBatch.frames_of`"""
        own = known[self.frame] if self.frame >= 0 else translation_frame(self.shape.motion)
        return np.broadcast_to(own, (len(rows), FRAME_NUMBERS))

    def columns(self) -> tuple[Ints, Ints, Ints]:
        """`CsgBatch.columns`"""
        count, leaves = len(self.shape), len(self.shape.leaves)
        every = np.arange(count, dtype=np.int32)
        return self.number + every, self.first + leaves * every, np.full(count, self.frame, np.int32)


def exceeds_translation(motion: Motion) -> bool:
    """Return whether a motion is more than a translation."""
    steps = motion.steps
    return len(steps) > 1 or (len(steps) == 1 and motion.shift is None)


def translation_frame(motion: Motion) -> Any:
    """Return the map from world to local coordinates of a body with a translation, or no motion."""
    return np.array(Motion(motion.steps).inverse_rows).ravel() if motion.steps else _IN_PLACE


# Composition: the pattern and rows of Boolean bodies from those of their primitives
#
# A `CsgPlan` gives the tree of Boolean nodes with places for the primitives. The form of each primitive
# (`PrimitiveForm`: pattern and tree of cells) and the plan give the body's pattern, and the source of each of its
# columns.


@dataclass
class CsgComposition:
    """The pattern of bodies of one plan with primitives of these forms, and the sources of their columns."""

    pattern: BodyPattern
    sources: list[tuple[int, int, int]] = field(default_factory=list)
    """(part, first column, last column) of each piece of a row up to the boxes of leaves."""
    boxes: list[int] = field(default_factory=list)
    """For each leaf of the program the part whose box holds it; -1 for none."""
    faces: list[int] = field(default_factory=list)
    """The first face of each part."""

    @classmethod
    def of(cls, key: Sequence[Hashable], forms: Sequence[PrimitiveForm]) -> CsgComposition:
        """Compose the trees of the forms as the plan says; recent compositions are cached."""
        return _cached_composition(tuple(key), tuple(forms))

    @classmethod
    def compose(cls, key: Sequence[Hashable], forms: Sequence[PrimitiveForm]) -> CsgComposition:
        """`of`, without the cache."""
        trees, faces, count = [], [], 0
        for part, form in enumerate(forms):
            assert form.tree is not None
            trees.append(_place_tree(form.tree, part, count, form.pattern))
            faces.append(count)
            count += len(form.pattern.angular)
        tree = fold_plan(key, trees, combine_trees)
        part_of_cell = {id(cell): part for part, of in enumerate(trees) for cell in cullable_cells(of)}
        assembly = Assembly()
        if isinstance(tree, Cell):
            kind, index = CELL, assembly.cell(tree)
        else:
            kind, index = REGION, assembly.program(tree, part_of_cell)
        angular = [bool(turns) for form in forms for turns in form.pattern.angular]
        maps, rows, sources = [], 0, []
        for form in forms:
            maps += (form.pattern.maps + rows).tolist()
            rows += form.pattern.map_rows
        for slot in assembly.surfaces:
            assert isinstance(slot, SurfaceSlot)
            _, column, sense = forms[slot.part].pattern.records[slot.number]
            sources.append((slot.part, column, sense + 1))
        for part, form in enumerate(forms):
            sources.append((part, form.pattern.uv_at, form.pattern.bounds_at))
        boxes = [-1 if box is UNBOUNDED else box for box in assembly.leaf_bounds]
        return cls(BodyPattern.of(assembly, kind, index, angular, maps), sources, boxes, faces)

    def rows(self, parts: Sequence[RowTable], boxes: Floats, frames: Floats) -> RowTable:
        """Compose rows of bodies from the rows of their parts, their boxes and their frames."""
        grown = {part: _column_table(_widen_part_boxes(parts[part])) for part in set(self.boxes) if part >= 0}
        if -1 in self.boxes:
            grown[-1] = _column_table(np.broadcast_to(np.array(UNBOUNDED), (len(boxes), BOX_NUMBERS)))
        sources = [(parts[part], first, last) for part, first, last in self.sources]
        sources += [(grown[part], 0, BOX_NUMBERS) for part in self.boxes]
        return RowTable.joined(
            [*sources, (_column_table(boxes), 0, BOX_NUMBERS), (_column_table(frames), 0, FRAME_NUMBERS)]
        )


def _widen_part_boxes(rows: RowTable) -> Floats:
    """Widen the boxes of parts to boxes of leaves."""
    found = np.empty((len(rows), BOX_NUMBERS))
    for some in row_blocks(len(rows)):
        found[some] = widen_boxes(box_columns(rows[some]))
    return found


def _column_table(values: Floats) -> RowTable:
    """Wrap an array as rows with all its columns in order."""
    return RowTable.of(values, np.arange(values.shape[1], dtype=np.int32))


@lru_cache(maxsize=64)
def _cached_composition(key: tuple[Hashable, ...], forms: tuple[PrimitiveForm, ...]) -> CsgComposition:
    """`CsgComposition.compose`, cached: forms are unique objects, and nobody changes a composition."""
    return CsgComposition.compose(key, forms)


def _place_tree(tree: Tree, part: int, first_face: int, pattern: BodyPattern) -> Tree:
    """Renumber the tree of a form as one part of a body."""
    if isinstance(tree, Cell):
        return Cell(
            tuple(
                dataclasses.replace(
                    face,
                    surface=SurfaceSlot(int(pattern.kinds[face.surface]), part, face.surface),  # type: ignore[arg-type, call-overload]
                    number=first_face + face.number,
                )
                for face in tree.faces
            )
        )
    if isinstance(tree, Not):
        return Not(_place_tree(tree.part, part, first_face, pattern))
    return type(tree)(tuple(_place_tree(each, part, first_face, pattern) for each in tree.parts))
