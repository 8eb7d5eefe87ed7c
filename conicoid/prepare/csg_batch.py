"""Boolean bodies in batches: plans of how they are built, bounds, and composition from the rows of their primitives."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, field
from functools import cache, lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from ..geometry.bounds.intersection import BoundsKind, are_balls_or_boxes, bound_ball_intersections
from ..geometry.bulk import Bulk
from ..geometry.cell import Cell, Not, Tree
from ..geometry.shape import Boolean, Complement, Difference, Intersection, Painted, PrimitiveSolid, Shape, Solid, Union
from ..geometry.transform import Motion, Step
from ..kernels.tables import CELL, REGION, Floats, Ints
from ..materials.material import Material
from .assembly import UNBOUNDED, Assembly, SurfaceSlot
from .lower_shape import EMPTY_BOX, combine_trees, cullable_cells, widen_boxes
from .pattern import BOX_NUMBERS, FRAME_NUMBERS, BodyPattern, RowTable, row_blocks


@dataclass(slots=True)
class CsgPlan:
    """The structure of a Boolean body, and its primitives from left to right with the steps that move each."""

    key: tuple[Hashable, ...]
    leaves: list[tuple[Shape, tuple[Step, ...]]]
    painted: list[tuple[int, int, Material]]  # (first leaf, last leaf, material), from the innermost paint outward


@cache
def is_subclass(kind: Any, of: Any) -> bool:
    """Cached `issubclass`: it is called for every node."""
    return issubclass(kind, of)


def csg_plan(solid: Boolean, still: bool = False) -> CsgPlan | None:
    """Build the plan of a solid; None where it holds more than primitives and Boolean nodes.

    With `still` the solid's own motion, which comes last among the steps of every leaf, is left out.
    """
    key: list[Hashable] = []
    leaves: list[tuple[Shape, tuple[Step, ...]]] = []
    painted: list[tuple[int, int, Material]] = []
    pending: list[tuple[Any, tuple[Step, ...], int]] = [(solid, (), -1)]
    while pending:
        node, steps, first = pending.pop()
        if first >= 0:
            painted.append((first, len(leaves), node.material))
            continue
        mine = () if still and node is solid else node.motion.steps
        inner = mine + steps if mine else steps
        kind: Any = type(node)
        if is_subclass(kind, Boolean):
            operands = node.operands
            key.append((kind, len(operands)))
            if kind is Painted:
                pending.append((node, steps, len(leaves)))
            pending.extend((part, inner, -1) for part in reversed(operands))
        elif is_subclass(kind, PrimitiveSolid):
            key.append(kind)
            leaves.append((node, inner))
        else:
            return None
    return CsgPlan(tuple(key), leaves, painted)


def placed_primitives(shape: Shape) -> list[tuple[Shape, tuple[Step, ...]]]:
    """List the primitives of a shape with the steps that move each; the shape itself where it has no plan."""
    plan = csg_plan(shape) if isinstance(shape, Boolean) else None
    return [(shape, shape.motion.steps)] if plan is None else plan.leaves


def fold_plan(key: Sequence[Hashable], leaves: Sequence[Any], combined: Callable[[Any, list[Any]], Any]) -> Any:
    """Fold a plan over one value for each leaf, from the leaves up: `combined(node type, operands)`."""
    results: list[Any] = []
    rest = list(leaves)
    for entry in reversed(key):  # nodes come before their operands
        if not isinstance(entry, tuple):
            results.append(rest.pop())
            continue
        kind, count = entry
        parts = results[-count:][::-1]
        del results[-count:]
        results.append(combined(kind, parts))
    return results[0]


# Boolean bodies of one plan: listed one by one, or many in one entry

_IN_PLACE = np.array([1.0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0])


@dataclass
class CsgBatch:
    """Boolean bodies of one plan: shapes, plans without their own motions, body numbers.

    Then the places of their first leaves, and the rows of their frames.
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


# Bounds of Boolean bodies of one plan from the boxes of their primitives, where these suffice
#
# They are the bounds that `region_bounds` computes with more work: a union surrounds its parts, and the
# parts of an intersection narrow one another. Where only one part of an intersection has a bound, and the others are
# complements of shapes with an unbounded outside, the box is that part's. Where several parts have bounds, and these
# are balls and axis-aligned boxes, it is that of `geometry.bounds.intersection`.

Mask = npt.NDArray[np.bool_]


def box_columns(rows: RowTable) -> Floats:
    """Return the boxes in rows of primitives without polygons: these rows end with box and frame."""
    boxes: Floats = rows[:, -BOX_NUMBERS - FRAME_NUMBERS : -FRAME_NUMBERS]
    return boxes


@dataclass
class _BoundPart:
    """One primitive of each body: its boxes, its type, and its rows."""

    boxes: Floats
    kind: BoundsKind
    rows: RowTable

    @property
    def is_ball(self) -> bool:
        """Is it a ball, where `simple` holds?"""
        return self.kind == "ball"

    def simple(self) -> Mask:
        """Return for which bodies it is a ball, or an axis-aligned box."""
        return are_balls_or_boxes(self.kind, self.rows[:, -FRAME_NUMBERS:].reshape(-1, 3, 4)[:, :, :3])


@dataclass
class _BoundNode:
    """A node of a plan: its boxes (None for all of space), and for which bodies they are right.

    `hole`: nothing bounds the outside of the node. `parts`: the primitives whose intersection holds the node; None for
    a union.
    """

    boxes: Floats | None
    known: Mask
    hole: bool = False
    parts: tuple[_BoundPart, ...] | None = ()


def csg_boxes(key: Sequence[Hashable], leaves: Sequence[Shape], rows: Sequence[RowTable]) -> tuple[Floats, Mask]:
    """Compute the boxes (n, 6) of bodies from rows of their primitives.

    Return also for which of them they are known.
    """
    primitives = [_primitive_bounds(shape, of_part) for shape, of_part in zip(leaves, rows, strict=True)]
    whole: _BoundNode = fold_plan(key, primitives, _combine_bounds)
    found = whole.boxes
    if found is None:
        return np.tile(np.array(UNBOUNDED), (len(rows[0]), 1)), whole.known
    return np.where(np.asarray((found[:, :3] > found[:, 3:]).any(axis=1))[:, None], EMPTY_BOX, found), whole.known


def _primitive_bounds(shape: Shape, rows: RowTable) -> _BoundNode:
    boxes = box_columns(rows)
    part = _BoundPart(boxes, shape.bounds_kind, rows)
    return _BoundNode(boxes, np.ones(len(rows), bool), _is_hole(shape), (part,))


def _is_hole(shape: Shape) -> bool:
    """Return whether the outside of a primitive is unbounded; cached with the shape, which copies of a body share."""
    found: bool | None = shape.kept.get("hole")
    if found is None:
        found = shape.kept["hole"] = isinstance(shape, Solid) and shape.has_unbounded_outside()
    return found


def _combine_bounds(kind: Hashable, parts: Sequence[_BoundNode]) -> _BoundNode:
    """Combine operands to a node of a type."""
    known = np.asarray(np.logical_and.reduce([part.known for part in parts]))
    nowhere = _BoundNode(None, np.zeros(len(known), bool), False, None)
    if kind is Complement:
        return _BoundNode(None, known) if parts[0].hole else nowhere
    if kind is Painted or len(parts) == 1:
        return parts[0]
    if kind is Union:
        every = [part.boxes for part in parts]
        boxes = [each for each in every if each is not None]
        around = _union_boxes(boxes) if len(boxes) == len(every) else None
        return _BoundNode(around, known, all(part.hole for part in parts), None)
    inside, outside = (parts[:1], parts[1:]) if kind is Difference else (parts, ())
    if not all(part.hole for part in outside) or kind not in (Difference, Intersection):
        return nowhere
    bounded = [part for part in inside if part.boxes is not None]
    if len(bounded) < 2:
        one = bounded[0] if bounded else _BoundNode(None, known)
        return _BoundNode(one.boxes, known, False, one.parts)
    if any(part.parts is None for part in bounded):  # `region_bounds` would pass planes on to the parts of a union
        return nowhere
    common = tuple(each for part in bounded for each in part.parts or ())
    boxes_in_common, good = _intersect_boxes(common)
    return _BoundNode(boxes_in_common, known & good, False, common)


def _union_boxes(boxes: Sequence[Floats]) -> Floats:
    """Compute boxes around boxes, row by row; empty ones do not count."""
    low = np.full((len(boxes[0]), 3), np.inf)
    high = -low
    for box in boxes:
        held = np.asarray((box[:, :3] <= box[:, 3:]).all(axis=1))[:, None]
        low = np.where(held, np.minimum(low, box[:, :3]), low)
        high = np.where(held, np.maximum(high, box[:, 3:]), high)
    return np.concatenate([low, high], axis=1)


def _intersect_boxes(parts: Sequence[_BoundPart]) -> tuple[Floats, Mask]:
    """Return (boxes around the intersection of primitives, for which bodies these are known)."""
    boxes, good = bound_ball_intersections([part.boxes for part in parts], [part.is_ball for part in parts])
    return boxes, np.asarray(np.logical_and.reduce([good, *(part.simple() for part in parts)]))


# Composition: the pattern and rows of Boolean bodies from those of their primitives
#
# A `CsgPlan` gives the tree of Boolean nodes with places for the primitives. The form of each primitive
# (`PrimitiveForm`: pattern and tree of cells) and the plan give the body's pattern, and the source of each of its
# columns.


@dataclass(frozen=True, eq=False)
class PrimitiveForm:
    """The lowered structure of primitives of one kind. There is one object of each (`PrimitiveForms`)."""

    pattern: BodyPattern
    tree: Tree | None


class PrimitiveForms:
    """A registry of forms: equal pattern and tree give the same object."""

    def __init__(self) -> None:
        self._known: dict[Hashable, PrimitiveForm] = {}

    def of(self, pattern: BodyPattern, tree: Tree | None) -> PrimitiveForm:
        """Return the form of a pattern and a tree."""
        return self._known.setdefault((pattern, tree), PrimitiveForm(pattern, tree))


FORMS = PrimitiveForms()


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
        held = {id(cell): part for part, of in enumerate(trees) for cell in cullable_cells(of)}
        assembly = Assembly()
        if isinstance(tree, Cell):
            kind, index = CELL, assembly.cell(tree)
        else:
            kind, index = REGION, assembly.program(tree, held)
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
