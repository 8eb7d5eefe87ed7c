"""Batches of bodies: primitives as `primitive_batch.py` lowers them, and Boolean bodies composed of theirs.

A Boolean body passes through these files, in this order:

1. `body_collector.py` hands each body to `BatchLowering` here.
2. `csg_plan.py` splits it into its primitives and the plan by which they are combined.
3. `motion_batch.py` computes the motions of the primitives, each once.
4. `primitive_batch.py` finds or records the formulas of their kind (`tape/recordings.py`), and plays them for all at
   once. Supports that no tape can hold are computed by the shapes, in between.
5. `CsgComposition` here composes the rows of the primitives to the row of the body.
6. `csg_plan.py` finds its box, by `region_extent.py` where the boxes of the parts are not enough. Polyhedra have
   theirs from `polyhedron_extent.py`.
7. `tables_builder.py` lays out the rows (`pattern.py`) as columns; `coincidence.py` merges equal surfaces.

`lower_shape.py` does 2 to 6 for a single body, in 3000 bits.

User and factor: those of `tape/`.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Container, Hashable, Iterator, Sequence
from dataclasses import field
from functools import lru_cache, partial
from typing import Any

import numpy as np

from .._util.arrays import unique_first_with_inverse, unique_sorted, unique_with_inverse
from .._util.records import dataclass
from ..geometry.bulk import Bulk
from ..geometry.cell import Cell, Face, map_faces
from ..geometry.shape import Boolean, Painted, Primitive, Shape
from ..geometry.transform import Motion
from ..kernels.tables import CELL, REGION, Floats, Ints
from ..materials.material import Material
from .assembly import UNBOUNDED, Assembly, SurfaceSlot
from .csg_plan import (
    FORMS,
    CsgPlan,
    PrimitiveForm,
    bound_bodies,
    box_columns,
    csg_plan,
    fold_plan,
    is_subclass,
)
from .lower_shape import LoweredShape, combine_trees, cullable_cells, lower_shape, widen_boxes
from .motion_batch import MotionChains
from .pattern import BOX_NUMBERS, FRAME_NUMBERS, BodyGroup, BodyPattern, PlacedPrimitive, RowTable, row_blocks
from .primitive_batch import LeftPrimitive, PrimitiveBatch, PrimitiveRows
from .pytree import positions_by_key

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

    def leaves_of(self, chosen: Any, some: Any = slice(None)) -> list[PlacedPrimitive]:
        """List the leaves of the chosen bodies, or some of these, with the steps that move each."""
        found: list[PlacedPrimitive] = []
        for index in chosen[some].tolist():
            own = self.shapes[index].motion.steps
            found += [(leaf, inner + own) for leaf, inner in self.plans[index].leaves]
        return found

    def needs_names(self, which: Any) -> bool:
        """Return whether surfaces of some of the bodies may need names: most planes of translated ones are upright."""
        motions = [self.shapes[index].motion for index in which.tolist()]
        return any(map(exceeds_translation, motions)) or not any(motion.steps for motion in motions)

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
    slots: list[tuple[int, int]] = field(default_factory=list)
    """For each surface its part, and its number there."""

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
            trees.append(map_faces(form.tree, partial(_place_face, part, count, form.pattern)))
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
        slots = [(slot.part, slot.number) for slot in assembly.surfaces]  # type: ignore[union-attr]
        return cls(BodyPattern.of(assembly, kind, index, angular, maps), sources, boxes, faces, slots)

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


def _place_face(part: int, first_face: int, pattern: BodyPattern, face: Face) -> Face:
    """Renumber a face of a form as one of a part of a body."""
    number: Any = face.surface
    slot: Any = SurfaceSlot(int(pattern.kinds[number]), part, number)
    return dataclasses.replace(face, surface=slot, number=first_face + face.number)


ProgressCallback = Callable[[int, int], Any]
_AT_ONCE = 8192
"""Where there are many primitives, single or in Boolean bodies, so many are lowered at a time."""
_FEWEST_OF_PLAN = 4
"""Fewer bodies of a plan are lowered one by one where a recording cannot lower all of their primitives."""
_FEWEST_BY_LEAF = 64
"""The primitives of plans of fewer bodies are added all at once; leaf by leaf, bodies look up their motions once."""
_MANY_LEAVES = 16
"""A plan with so many primitives, in all of its bodies, is composed however few the bodies are."""


@dataclass
class _RowLocations:
    """Where the row of each place is: in which table of rows, and at which row of it."""

    forms: list[PrimitiveForm]
    rows: list[RowTable]
    number: Ints  # the table of each place; -1 for none
    row: Ints

    def of(self, places: Ints) -> RowTable:
        """Return the rows of places that have one form."""
        numbers, row = self.number[places], self.row[places]
        rows = self.rows[numbers[0]]
        if (numbers == numbers[0]).all():
            every = len(row) == len(rows) and (row == np.arange(len(row), dtype=np.int32)).all()
            return rows if every else rows[row]
        width = self.forms[numbers[0]].pattern.width
        found = np.empty((len(places), width))
        for number in unique_sorted(numbers).tolist():
            mine = numbers == number
            found[mine] = self.rows[number][row[mine], :]
        return RowTable.of(found, np.arange(width, dtype=np.int32))


class BatchLowering:
    """Collects bodies, and lowers those that can be lowered together."""

    def __init__(self) -> None:
        self._primitives = PrimitiveBatch()
        self._owners: list[Ints] = []  # for each place the number of its body, -1 for a part of one
        self._places = 0
        self._single: tuple[list[Shape], list[int]] = [], []  # shapes and numbers
        self._templates: dict[Hashable, tuple[Sequence[Shape], CsgPlan | None]] = {}
        self._plans: dict[Hashable, CsgBatch] = {}
        self._many: list[CsgArray] = []
        self._left: list[LeftPrimitive] = []  # primitives of Boolean bodies that have more than numbers
        self.paints: dict[int, dict[int, Material]] = {}

    def add(self, shape: Shape, number: int) -> bool:
        """Add a body under a number; return False where it must be lowered singly."""
        kind = type(shape)
        if is_subclass(kind, Boolean):
            return self._add_planned(shape, number)  # type: ignore[arg-type]
        if not is_subclass(kind, Primitive):
            return False
        shapes, numbers = self._single
        shapes.append(shape)
        numbers.append(number)
        return True

    def _reserve(self, owners: Ints) -> Ints:
        """Reserve the next places for these bodies."""
        first = self._places
        self._places += len(owners)
        self._owners.append(owners)
        return np.arange(first, self._places, dtype=np.int32)

    def add_many(self, shape: Bulk, number: int) -> None:
        """Add the bodies of a bulk entry, numbered from `number` on."""
        if not len(shape):
            return
        leaves = len(shape.leaves)
        if leaves == 1:
            owners = np.arange(number, number + len(shape), dtype=np.int32)
        else:
            owners = np.full(len(shape) * leaves, -1, np.int32)
            self._many.append(CsgArray(shape, number, self._places, self._frame_of(shape.motion, len(shape))))
        self._primitives.add_many(shape, self._reserve(owners).reshape(-1, leaves))

    def _frame_of(self, motion: Motion, uses: int = 1) -> int:
        """Return the number by which `PrimitiveBatch.frames` knows a motion.

        -1 for a translation, which needs no lookup.
        """
        return self._primitives.frame(motion.steps, uses) if exceeds_translation(motion) else -1

    def _add_planned(self, shape: Boolean, number: int) -> bool:
        # Copies of a Boolean shape share their operands: the plan is built once for each combination of these.
        key = (
            type(shape),
            *map(id, shape.operands),
            (id(shape.material), shape.faces) if isinstance(shape, Painted) else None,
        )
        found = self._templates.get(key)
        if found is None:
            # The tuple keeps the operands alive, and with them their ids
            found = self._templates[key] = (shape,), csg_plan(shape, still=True)
        plan = found[1]
        if plan is None:
            return False
        like = self._plans.get(plan.key)
        if like is None:
            like = self._plans[plan.key] = CsgBatch()
        like.shapes.append(shape)
        like.plans.append(plan)
        like.numbers.append(number)
        return True

    def _take_single(self) -> list[tuple[Shape, int]]:
        """Pass the bodies that are primitives to the batch; return those that are left."""
        shapes, numbers = self._single
        if not shapes:
            return []
        places = self._reserve(np.array(numbers, np.int32))
        left = self._primitives.add(shapes, MotionChains([shape.motion.steps for shape in shapes]), places)
        return [(shapes[k], numbers[k]) for k in left.tolist()]

    def _take_planned(self) -> None:
        """Pass the primitives of Boolean bodies to the batch.

        A body with a primitive that is left is left as a whole.
        """
        few: list[LeftPrimitive] = []  # of plans of few bodies, all at once
        for like in self._plans.values():
            count, leaves = len(like.shapes), len(like.plans[0].leaves)
            places = self._reserve(np.full(count * leaves, -1, np.int32)).reshape(count, leaves)
            own = MotionChains([shape.motion.steps for shape in like.shapes])
            # Frames of at most one translation need no lookup.
            like.first, like.frames = places[:, 0].copy(), self._primitives.frames_of(own)
            if count < _FEWEST_BY_LEAF:
                for plan, steps, row in zip(like.plans, own.steps, places.tolist(), strict=True):
                    few += [(leaf, inner + steps, at) for (leaf, inner), at in zip(plan.leaves, row, strict=True)]
                continue
            for leaf in range(leaves):
                listed = [plan.leaves[leaf] for plan in like.plans]
                chains = own
                if any(inner for _, inner in listed):
                    chains = MotionChains([inner + mine for (_, inner), mine in zip(listed, own.steps, strict=True)])
                rest = self._primitives.add([shape for shape, _ in listed], chains, places[:, leaf])
                self._left += [(listed[k][0], chains.steps[k], int(places[k, leaf])) for k in rest.tolist()]
        if few:
            shapes, chain, at = map(list, zip(*few, strict=True))
            rest = self._primitives.add(shapes, MotionChains(chain), np.array(at, np.int32))
            self._left += [few[k] for k in rest.tolist()]

    def lower(self, report: ProgressCallback = lambda *_: None) -> tuple[list[BodyGroup], list[tuple[Shape, int]]]:
        """Lower all bodies.

        Many bodies of a kind are lowered in blocks, so that intermediate results stay in the cache. Bodies that a block
        leaves may find enough of their kind among those that other blocks left.

        Parameters
        ----------
        report : ProgressCallback, optional
            Called now and then with (parts done, parts in all).

        Returns
        -------
        tuple[list[BodyGroup], list[tuple[Shape, int]]]
            Bodies lowered together; shapes and numbers of those that are left.
        """
        results: list[BodyGroup] = []
        pending = [*self._blocks_of_plans(), *self._blocks_of_single()]
        count = len(pending)
        for done in range(count):
            report(done, count + 1)
            block = pending.pop(0)  # the last reference: frees the inputs after the block
            found, left = block._lower_block(lambda *_: None)
            results += found
            self.paints.update(block.paints)
            for shape, number in left:
                if not self.add(shape, number):
                    raise AssertionError("a shape that was in a batch cannot be added to one again")
        found, rest = self._lower_block((lambda *_: None) if count else report)
        return results + found, rest

    def _blocks_of_plans(self) -> Iterator[BatchLowering]:
        """Move the Boolean bodies of large kinds to blocks."""
        for key, like in list(self._plans.items()):
            size = _AT_ONCE // len(like.plans[0].leaves) + 1
            if len(like.shapes) > 2 * size:
                del self._plans[key]
                for begin in range(0, len(like.shapes), size):
                    block = BatchLowering()
                    block._plans[key] = like.some(begin, begin + size)
                    yield block

    def _blocks_of_single(self) -> Iterator[BatchLowering]:
        """Move the primitives of large kinds to blocks."""
        shapes, numbers = self._single
        if len(shapes) <= 2 * _AT_ONCE:
            return
        left: list[int] = []
        for places in positions_by_key(list(map(type, shapes))).values():
            if len(places) <= 2 * _AT_ONCE:
                left += places
                continue
            for begin in range(0, len(places), _AT_ONCE):
                block, some = BatchLowering(), places[begin : begin + _AT_ONCE]
                block._single = [shapes[k] for k in some], [numbers[k] for k in some]
                yield block
        self._single = [shapes[k] for k in left], [numbers[k] for k in left]

    def _lower_block(self, report: ProgressCallback) -> tuple[list[BodyGroup], list[tuple[Shape, int]]]:
        """`lower`, in one block."""
        begin, (shapes, _) = self._places, self._single
        rest = self._take_single()
        self._take_planned()
        kinds = self._primitives.kinds + len(self._plans) + len(self._many)
        found, left = self._primitives.lower(lambda done: report(done, kinds))
        owners = np.concatenate([np.zeros(0, np.int32), *self._owners])
        results: list[BodyGroup] = []
        for form, places, rows in found:
            single = owners[places] >= 0
            if single.any():
                mine, rows = (places, rows) if single.all() else (places[single], rows[single])
                own = [shapes[k] for k in (mine - begin).tolist()] if mine[0] >= begin else []  # not of a bulk entry
                leaves = [(shape, shape.motion.steps) for shape in own]
                slots = [(0, number) for number in range(len(form.pattern.records))]
                results.append(BodyGroup(form.pattern, owners[mine], rows, 0, leaves, slots))
        rest += [(shape, int(owners[place])) for shape, _, place in left if owners[place] >= 0]
        found += _lower_parts([*left, *self._left], self._places_of_plans())
        if self._plans or self._many:
            rows_of = _rows_by_place(found, len(owners))
            every: list[CsgBatch | CsgArray] = [*self._plans.values(), *self._many]
            for done, like in enumerate(every, start=self._primitives.kinds):
                report(done, kinds)
                composed, others = self._compose(like, rows_of)
                results += composed
                rest += others
        return results, rest

    def _places_of_plans(self) -> set[int]:
        """Return the places of primitives of listed bodies with the plan of several others, or with a polyhedron.

        A body that is left as a whole would be left with all faces of a polyhedron, or with all the volumes that are
        cut from it, most of them lowered already.
        """
        found: set[int] = set()
        polyhedra = self._primitives.places_of_polyhedra
        for like in self._plans.values():
            begin, count = int(like.first[0]), len(like.shapes) * len(like.plans[0].leaves)
            places = range(begin, begin + count)
            many = len(like.shapes) >= _FEWEST_OF_PLAN or count >= _MANY_LEAVES
            if many or not polyhedra.isdisjoint(places):
                found.update(places)
        return found

    def _compose(
        self, like: CsgBatch | CsgArray, rows: _RowLocations
    ) -> tuple[list[BodyGroup], list[tuple[Shape, int]]]:
        """Compose the bodies of one plan; return also those that are left."""
        _, plan = like.of(0)
        key, count = plan.key, len(plan.leaves)
        bodies, first, frame_rows = like.columns()
        places = first[:, None] + np.arange(count, dtype=np.int32)
        frames = like.frames_of(frame_rows, self._primitives.frames)
        known = (rows.number[places] >= 0).all(axis=1) & ~np.isnan(frames[:, 0])
        left: list[tuple[Shape, int]] = [(like.of(i)[0], int(bodies[i])) for i in np.flatnonzero(~known).tolist()]
        numbers = {id(form): number for number, form in enumerate(rows.forms)}
        form_of = np.array([numbers[id(form)] for form in rows.forms], np.int32)
        results: list[BodyGroup] = []
        for forms, chosen in _group_by_forms(form_of, rows.number[places], np.flatnonzero(known)):
            composition = CsgComposition.of(key, [rows.forms[form] for form in forms])
            some: Any = slice(None) if len(chosen) == len(bodies) else chosen
            parts = [rows.of(places[some, part]) for part in range(count)]
            # The leaves of the others have the same forms
            examples = [leaf for leaf, _ in like.of(int(chosen[0]))[1].leaves]
            boxes, certain = bound_bodies(key, examples, [rows.forms[form] for form in forms], parts)
            others = np.flatnonzero(~certain)
            if len(others):
                # In numbers of 3000 bits
                boxes[others] = [np.concatenate(like.of(i)[0].bounds) for i in chosen[others].tolist()]
            # Shapes of a bulk entry are made on demand: no other bodies have their primitives
            leaves = like.leaves_of(chosen) if isinstance(like, CsgBatch) and like.needs_names(chosen) else []
            composed = composition.rows(parts, boxes, frames[some])
            group = BodyGroup(composition.pattern, bodies[chosen], composed, 0, leaves, composition.slots)
            if isinstance(like, CsgBatch):
                group.list_leaves = partial(like.leaves_of, chosen)
            results.append(group)
            for i in chosen.tolist() if plan.painted else ():
                painted = like.plans[i].painted if isinstance(like, CsgBatch) else like.of(i)[1].painted
                self._paint(int(bodies[i]), painted, composition)
        return results, left

    def _paint(self, number: int, painted: list[tuple[int, int, Painted]], composition: CsgComposition) -> None:
        """Record the materials of faces that have their own; paint further in takes precedence."""
        ends = [*composition.faces, len(composition.pattern.angular)]
        paints = self.paints.setdefault(number, {})
        for first, last, node in painted:
            for face in node.painted_faces(ends[first], ends[last]):
                paints.setdefault(face, node.material)


def _lower_parts(left: Sequence[LeftPrimitive], places: Container[int]) -> list[PrimitiveRows]:
    """Lower primitives at these places one by one, each once for all bodies that it is part of.

    Bodies of one plan are composed together even if a recording cannot lower all of their primitives.
    """
    known: dict[Hashable, LoweredShape] = {}
    rows: dict[PrimitiveForm, tuple[list[int], list[list[float]]]] = {}
    for shape, steps, place in left:
        if place not in places:
            continue
        key = id(shape), steps
        if key not in known:
            try:
                known[key] = lower_shape(shape._under_steps(steps))  # cached: it may be a body as well
            except (OverflowError, ValueError):  # its body is left, and `lower_shape` names what is wrong
                continue
        part = known[key]
        numbers, values = rows.setdefault(FORMS.of(part.pattern, part.tree), ([], []))
        numbers.append(place)
        values.append(part.row)
    return [
        (
            form,
            np.array(numbers, np.int32),
            RowTable.of(np.array(values), np.arange(form.pattern.width, dtype=np.int32)),
        )
        for form, (numbers, values) in rows.items()
    ]


def _group_by_forms(form_of: Ints, tables: Ints, which: Any) -> Iterator[tuple[list[int], Any]]:
    """Yield (forms of the parts, bodies with these forms); `tables` (bodies, parts) holds numbers of forms."""
    if not len(which):
        return
    forms = form_of[tables[which]].astype(np.int64)
    if (forms == forms[0]).all():
        yield forms[0].tolist(), which
        return
    code = forms[:, 0]
    for part in range(1, forms.shape[1]):
        code = unique_with_inverse(code)[1] * len(form_of) + forms[:, part]
    first, group = unique_first_with_inverse(code)
    for number, example in enumerate(first.tolist()):
        yield forms[example].tolist(), which[group == number]


def _rows_by_place(found: list[PrimitiveRows], count: int) -> _RowLocations:
    """Index rows by places."""
    table, row = np.full(count, -1, np.int32), np.zeros(count, np.int32)
    for number, (_, places, rows) in enumerate(found):
        table[places] = number
        row[places] = np.arange(len(rows), dtype=np.int32)
    return _RowLocations([form for form, _, _ in found], [rows for _, _, rows in found], table, row)
