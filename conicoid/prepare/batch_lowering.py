"""Many primitives lowered at once: what `parts` does for one is recorded, and worked out for all that are made alike.

Alike are shapes of one kind whose fields have the same forms (so many numbers, or none), moved or not. For each kind
there are a few recordings, as tests of numbers turn out one way or the other. What they cannot settle is left to
`parts`: numbers that 253 bits leave open, kinds that look at their numbers in other ways, and shapes of which there are
too few.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Hashable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from .._util.arrays import unique_first_with_inverse, unique_sorted, unique_with_inverse
from ..geometry.bulk import Bulk
from ..geometry.csg import Boolean, Painted, region_bounds
from ..geometry.shape import Primitive, Shape
from ..geometry.transform import IDENTITY_MOTION, Motion, Step
from ..kernels.tables import Floats, Ints, Longs, Signs
from ..materials.material import Material
from ..numerics.tracing import Tape, TracedFloat
from .csg_batch import (
    FORMS,
    CsgArray,
    CsgBatch,
    CsgComposition,
    CsgPlan,
    PrimitiveForm,
    box_columns,
    csg_boxes,
    csg_plan,
    exceeds_translation,
    is_subclass,
    placed_primitives,
)
from .lower_shape import LoweredShape, compute_shape
from .motion_batch import MotionBatch, MotionChains, count_translations, input_motion
from .pattern import BOX_NUMBERS, FRAME_NUMBERS, BodyPattern, RowTable, row_blocks
from .pytree import flatten, flatten_all, positions_by_key, unflatten
from .tape import recording_cache
from .tape.program import NO_INPUTS, WideInputs


class ShapeBatch(Protocol):
    """Shapes that are made alike, and what was said of each."""

    def __len__(self) -> int: ...

    def of(self, index: int) -> tuple[Shape, tuple[Step, ...]]:
        """One of the shapes, and the steps that move it."""
        ...

    def columns(self) -> tuple[Floats, Ints, Ints]:
        """(n, numbers) what was said, and of each shape its motion and its place."""
        ...


@dataclass
class _ShapeList:
    """Shapes of bodies that stand alone, or in Boolean ones, some at a time."""

    shapes: list[Shape] = field(default_factory=list)
    steps: list[tuple[Step, ...]] = field(default_factory=list)
    numbers: list[Floats] = field(default_factory=list)
    motions: list[Ints] = field(default_factory=list)
    places: list[Ints] = field(default_factory=list)

    def __len__(self) -> int:
        return len(self.shapes)

    def add(self, shapes: Sequence[Shape], steps: list[tuple[Step, ...]], which: Longs, places: Ints) -> None:
        """Take in some of these shapes, with the steps of each of them."""
        self.shapes += [shapes[k] for k in which.tolist()]
        self.steps += steps
        self.places.append(places[which])

    def of(self, index: int) -> tuple[Shape, tuple[Step, ...]]:
        """`Like.of`"""
        return self.shapes[index], self.steps[index]

    def columns(self) -> tuple[Floats, Ints, Ints]:
        """`Like.columns`"""
        return np.concatenate(self.numbers), np.concatenate(self.motions), np.concatenate(self.places)


@dataclass
class _ShapeArray:
    """One primitive of each of many bodies in one entry."""

    shape: Bulk
    leaf: int
    steps: tuple[Step, ...]
    numbers: Floats
    motion: int
    places: Ints

    def __len__(self) -> int:
        return len(self.places)

    def of(self, index: int) -> tuple[Shape, tuple[Step, ...]]:
        """`Like.of`"""
        return placed_primitives(self.shape.single(index))[self.leaf]

    def columns(self) -> tuple[Floats, Ints, Ints]:
        """`Like.columns`"""
        return self.numbers, np.full(len(self), self.motion, np.int32), self.places


@dataclass
class _BatchInputs:
    """Some shapes that are made alike: which, their numbers, the numbers of motions, and the motion of each."""

    like: ShapeBatch
    chosen: Longs
    numbers: Floats
    motions_given: WideInputs
    motions: Ints


class PrimitiveBatch:
    """Primitives to be lowered together, each for a place of its own."""

    def __init__(self) -> None:
        self._motions = MotionBatch()
        self.frames = np.zeros((0, FRAME_NUMBERS))
        """Of motions, by the numbers that `frame` gave, the way back; NaN where that is not known."""
        self._like: dict[Hashable, _ShapeList] = {}
        self._many: list[tuple[Hashable, _ShapeArray]] = []

    def add_many(self, shape: Bulk, places: Ints) -> None:
        """Take in the primitives of many bodies; places (bodies, primitives)."""
        for leaf, (primitive, steps) in enumerate(placed_primitives(shape.single(0))):
            told = flatten(primitive)
            assert told is not None
            numbers = shape.numbers(leaf)
            key, more, row = self._motion(told.form, steps, len(shape))
            if more:
                numbers = np.concatenate([numbers, np.tile(np.array(more), (len(numbers), 1))], axis=1)
            self._many.append(
                (key, _ShapeArray(shape, leaf, steps, numbers, row, np.ascontiguousarray(places[:, leaf])))
            )

    def _motion(self, form: Hashable, steps: tuple[Step, ...], uses: int = 1) -> tuple[Hashable, list[float], int]:
        """(what is alike in shapes of a form under such steps, the steps' numbers where these count, their motion)."""
        if count_translations(steps) >= 0:
            return (form, len(steps)), [x for step in steps for x in step.offset], 0  # type: ignore[union-attr]
        return (form, "moved"), [], self._motions.row(steps, uses)

    def add(self, shapes: Sequence[Shape], chains: MotionChains, places: Ints) -> Longs:
        """Take in shapes, each moved by steps and for a place; which are left, as they have to be lowered alone."""
        taken = np.zeros(len(shapes), bool)
        for alike in flatten_all(shapes):
            taken[alike.which] = True
            counts = chains.translations[alike.which]
            for count in sorted(set(counts.tolist())):
                some = np.flatnonzero(counts == count)
                which = alike.which[some]
                like = self._like.setdefault((alike.form, "moved" if count < 0 else count), _ShapeList())
                like.add(shapes, [chains.steps[k] for k in which.tolist()], which, places)
                numbers, motions = alike.numbers[some], np.zeros(len(which), np.int32)
                if count < 0:
                    motions = self._motions.rows(chains, which)
                elif count:
                    offsets = [step.offset for steps in like.steps[-len(which) :] for step in steps]  # type: ignore[union-attr]
                    numbers = np.concatenate([numbers, np.array(offsets).reshape(len(which), -1)], axis=1)
                like.numbers.append(numbers)
                like.motions.append(motions)
        return np.flatnonzero(~taken)

    def frames_of(self, chains: MotionChains) -> Ints:
        """`frame` of many; -1 for those of at most one translation."""
        more = np.flatnonzero((chains.translations < 0) | (chains.translations > 1))
        found = np.full(len(chains.steps), -1, np.int32)
        found[more] = self._motions.rows(chains, more)
        return found

    def frame(self, steps: tuple[Step, ...], uses: int = 1) -> int:
        """A number by which `frames` knows the motion of these steps; to be asked for before they are lowered."""
        return self._motions.row(steps, uses)

    @property
    def kinds(self) -> int:
        """How many kinds there are of what is made alike."""
        return len(self._like) + len(self._many)

    def lowered(
        self, told: Callable[[int], Any] = lambda _: None
    ) -> tuple[list[tuple[PrimitiveForm, Ints, RowTable]], list[tuple[Shape, int]]]:
        """(form, places, rows) of those that could be lowered together, and the shapes and places that are left."""
        motions_given, similar, self.frames = self._motions.work_out()
        results: list[tuple[PrimitiveForm, Ints, RowTable]] = []
        left: list[tuple[Shape, int]] = []
        every: list[tuple[Hashable, ShapeBatch]] = [*self._like.items(), *self._many]
        for done, (key, like) in enumerate(every):
            told(done)
            numbers, motions, places = like.columns()
            for kind, chosen in _split_by_motion(key, motions, similar):
                given = _BatchInputs(like, chosen, numbers[chosen], motions_given, motions[chosen])
                found, rest = self._of_a_kind(key, kind, given)
                results += [(form, places[chosen[which]], rows) for form, which, rows in found]
                left += [(like.of(i)[0], int(places[i])) for i in chosen[rest].tolist()]
        return results, left

    def _of_a_kind(
        self, key: Hashable, similar: bool | None, of: _BatchInputs
    ) -> tuple[list[tuple[PrimitiveForm, Longs, RowTable]], Longs]:
        """`lowered` for some shapes that are made alike, by their numbers among them; those that are left."""
        if similar is None:
            return [], np.arange(len(of.chosen))
        moved = isinstance(key, tuple) and key[1] == "moved"

        def record(which: int, tape: Tape) -> tuple[PrimitiveForm, Ints]:
            shape, steps = of.like.of(int(of.chosen[which]))
            part = _record_shape(shape, steps, tape, moved, similar)
            alone = compute_shape(dataclasses.replace(shape, motion=Motion(steps)))
            if part.pattern != alone.pattern or list(map(_float_key, part.row)) != list(map(_float_key, alone.row)):
                raise TypeError("it is not the same where it is recorded")
            return FORMS.of(part.pattern, part.tree), _write_row(part, tape)

        given = of.motions_given if moved else NO_INPUTS
        found, left = recording_cache.RECORDINGS.play((key, similar), record, of.numbers, given, of.motions)
        return [(form, which, RowTable.of(played.floats, columns)) for (form, columns), which, played in found], left


def _write_row(part: LoweredShape, tape: Tape) -> Ints:
    """Have a tape write each number of a row once; which of those that it writes is in each column."""
    places: dict[int, int] = {}
    columns = [places.setdefault(tape.plain_of(number).register, len(places)) for number in part.row]
    tape.written += places
    return np.array(columns, np.int32)


def _float_key(number: Any) -> str:
    """A float, recorded or not, to the last bit."""
    return float(number.value if isinstance(number, TracedFloat) else number).hex()


def _split_by_motion(key: Hashable, motions: Ints, similar: Signs) -> list[tuple[bool | None, Longs]]:
    """Those whose motions are similarities, those whose are none, and those of which it is not known."""
    if not (isinstance(key, tuple) and key[1] == "moved"):
        return [(True, np.arange(len(motions)))]
    kinds = similar[motions]
    chosen = ((kind, np.flatnonzero(kinds == number)) for kind, number in ((True, 1), (False, 0), (None, -1)))
    return [(kind, which) for kind, which in chosen if len(which)]


def _record_shape(shape: Shape, steps: tuple[Step, ...], tape: Tape, moved: bool, similar: bool) -> LoweredShape:
    """A shape worked out on a tape."""
    traced = unflatten(shape, tape)
    if not moved:
        motion = Motion(tuple(unflatten(step, tape) for step in steps)) if steps else IDENTITY_MOTION
    else:
        motion = input_motion(tape, similar, Motion(steps))
    object.__setattr__(traced, "motion", motion)
    return compute_shape(traced)


# Bodies lowered together: primitives as they are recorded, and Boolean bodies put together from theirs.

LoweredGroup = tuple[BodyPattern, Ints, RowTable]
ProgressCallback = Callable[[int, int], Any]
_AT_ONCE = 8192
"""Primitives, alone or in Boolean bodies, that are lowered together where there are many."""


@dataclass
class _RowLocations:
    """Where the rows of places are: in which rows, and which of these."""

    forms: list[PrimitiveForm]
    rows: list[RowTable]
    number: Ints  # -1 where there are none
    row: Ints

    def of(self, places: Ints) -> RowTable:
        """The rows of places whose forms are one."""
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
    """Collects bodies, and lowers those that can be."""

    def __init__(self) -> None:
        self._primitives = PrimitiveBatch()
        self._owners: list[Ints] = []  # of each place: the number of its body, -1 for a part of one
        self._places = 0
        self._single: tuple[list[Shape], list[int]] = [], []  # shapes and numbers
        self._templates: dict[Hashable, tuple[Sequence[Shape], CsgPlan | None]] = {}
        self._plans: dict[Hashable, CsgBatch] = {}
        self._many: list[CsgArray] = []
        self.paints: dict[int, dict[int, Material]] = {}

    def add(self, shape: Shape, number: int) -> bool:
        """Take in the body of a number; False where it has to be lowered alone."""
        kind = type(shape)
        if is_subclass(kind, Boolean):
            return self._add_planned(shape, number)  # type: ignore[arg-type]
        if not is_subclass(kind, Primitive):
            return False
        shapes, numbers = self._single
        shapes.append(shape)
        numbers.append(number)
        return True

    def _own(self, owners: Ints) -> Ints:
        """The next places, which belong to these bodies."""
        first = self._places
        self._places += len(owners)
        self._owners.append(owners)
        return np.arange(first, self._places, dtype=np.int32)

    def add_many(self, shape: Bulk, number: int) -> None:
        """Take in many bodies in one entry, from a number on."""
        if not len(shape):
            return
        leaves = len(shape.leaves)
        if leaves == 1:
            owners = np.arange(number, number + len(shape), dtype=np.int32)
        else:
            owners = np.full(len(shape) * leaves, -1, np.int32)
            self._many.append(CsgArray(shape, number, self._places, self._frame_of(shape.motion, len(shape))))
        self._primitives.add_many(shape, self._own(owners).reshape(-1, leaves))

    def _frame_of(self, motion: Motion, uses: int = 1) -> int:
        """The number by which the frames of primitives know a motion; -1 for one that is known at once."""
        return self._primitives.frame(motion.steps, uses) if exceeds_translation(motion) else -1

    def _add_planned(self, shape: Boolean, number: int) -> bool:
        # What a combination of the same objects is built like need not be found out again for each of its copies
        key = type(shape), *map(id, shape.operands), id(shape.material) if isinstance(shape, Painted) else None
        found = self._templates.get(key)
        if found is None:
            found = self._templates[key] = (shape,), csg_plan(shape, still=True)  # which keeps the operands
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
        """Hand on the bodies that are primitives; those that are left."""
        shapes, numbers = self._single
        if not shapes:
            return []
        places = self._own(np.array(numbers, np.int32))
        left = self._primitives.add(shapes, MotionChains([shape.motion.steps for shape in shapes]), places)
        return [(shapes[k], numbers[k]) for k in left.tolist()]

    def _take_planned(self) -> None:
        """Hand on the primitives of Boolean bodies; one that is left, its body is left for."""
        for like in self._plans.values():
            count, leaves = len(like.shapes), len(like.plans[0].leaves)
            places = self._own(np.full(count * leaves, -1, np.int32)).reshape(count, leaves)
            own = MotionChains([shape.motion.steps for shape in like.shapes])
            for leaf in range(leaves):
                listed = [plan.leaves[leaf] for plan in like.plans]
                chains = own
                if any(inner for _, inner in listed):
                    chains = MotionChains([inner + mine for (_, inner), mine in zip(listed, own.steps, strict=True)])
                self._primitives.add([shape for shape, _ in listed], chains, places[:, leaf])
            # A translation, or none, is known at once
            like.first, like.frames = places[:, 0].copy(), self._primitives.frames_of(own)

    def lowered(self, told: ProgressCallback = lambda *_: None) -> tuple[list[LoweredGroup], list[tuple[Shape, int]]]:
        """(pattern, numbers, rows) of bodies that could be lowered together; shapes and numbers of those left.

        Where there are many of a kind, so many at a time that what they are made of stays in the cache. Bodies that are
        left then may find enough of their like among those that others left. told(done, count) is called now and then.
        """
        results: list[LoweredGroup] = []
        pending = [*self._blocks_of_plans(), *self._blocks_of_single()]
        count = len(pending)
        for done in range(count):
            told(done, count + 1)
            block = pending.pop(0)  # then nobody holds it, nor what its bodies are made of
            found, left = block._all(lambda *_: None)
            results += found
            self.paints.update(block.paints)
            for shape, number in left:
                if not self.add(shape, number):
                    raise AssertionError("a shape was lowered with others once, and is not taken again")
        found, rest = self._all((lambda *_: None) if count else told)
        return results + found, rest

    def _blocks_of_plans(self) -> Iterator[BatchLowering]:
        """Boolean bodies of which there are many, no longer here."""
        for key, like in list(self._plans.items()):
            size = _AT_ONCE // len(like.plans[0].leaves) + 1
            if len(like.shapes) > 2 * size:
                del self._plans[key]
                for begin in range(0, len(like.shapes), size):
                    block = BatchLowering()
                    block._plans[key] = like.some(begin, begin + size)
                    yield block

    def _blocks_of_single(self) -> Iterator[BatchLowering]:
        """Primitives of which there are many, no longer here."""
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

    def _all(self, told: ProgressCallback) -> tuple[list[LoweredGroup], list[tuple[Shape, int]]]:
        """`lowered`, all at once."""
        rest = self._take_single()
        self._take_planned()
        kinds = self._primitives.kinds + len(self._plans) + len(self._many)
        found, left = self._primitives.lowered(lambda done: told(done, kinds))
        owners = np.concatenate([np.zeros(0, np.int32), *self._owners])
        results: list[LoweredGroup] = []
        for form, places, rows in found:
            alone = owners[places] >= 0
            if alone.all():
                results.append((form.pattern, owners[places], rows))
            elif alone.any():
                results.append((form.pattern, owners[places[alone]], rows[alone]))
        rest += [(shape, int(owners[place])) for shape, place in left if owners[place] >= 0]
        if self._plans or self._many:
            rows_of = _rows_by_place(found, len(owners))
            every: list[CsgBatch | CsgArray] = [*self._plans.values(), *self._many]
            for done, like in enumerate(every, start=self._primitives.kinds):
                told(done, kinds)
                composed, others = self._composed(like, rows_of)
                results += composed
                rest += others
        return results, rest

    def _composed(
        self, like: CsgBatch | CsgArray, rows: _RowLocations
    ) -> tuple[list[LoweredGroup], list[tuple[Shape, int]]]:
        """Bodies of one plan; those that are left."""
        _, plan = like.of(0)
        key, count = plan.key, len(plan.leaves)
        bodies, first, frame_rows = like.columns()
        places = first[:, None] + np.arange(count, dtype=np.int32)
        frames = like.frames_of(frame_rows, self._primitives.frames)
        known = (rows.number[places] >= 0).all(axis=1) & ~np.isnan(frames[:, 0])
        left: list[tuple[Shape, int]] = [(like.of(i)[0], int(bodies[i])) for i in np.flatnonzero(~known).tolist()]
        numbers = {id(form): number for number, form in enumerate(rows.forms)}
        form_of = np.array([numbers[id(form)] for form in rows.forms], np.int32)
        results: list[LoweredGroup] = []
        for forms, chosen in _group_by_forms(form_of, rows.number[places], np.flatnonzero(known)):
            made = CsgComposition.of(key, [rows.forms[form] for form in forms])
            some: Any = slice(None) if len(chosen) == len(bodies) else chosen
            parts = [rows.of(places[some, part]) for part in range(count)]
            leaves = [leaf for leaf, _ in like.of(int(chosen[0]))[1].leaves]  # those of the others have the same forms
            boxes, known_boxes = _csg_boxes_in_blocks(key, leaves, parts)
            others = np.flatnonzero(~known_boxes)
            if len(others):
                narrowed = [like.of(i) for i in chosen[others].tolist()]
                boxes[others] = _narrow_bounds(narrowed, [box_columns(part[others]) for part in parts])
            results.append((made.pattern, bodies[chosen], made.rows(parts, boxes, frames[some])))
            for i in chosen.tolist() if plan.painted else ():
                painted = like.plans[i].painted if isinstance(like, CsgBatch) else like.of(i)[1].painted
                self._paint(int(bodies[i]), painted, made)
        return results, left

    def _paint(self, number: int, painted: list[tuple[int, int, Material]], made: CsgComposition) -> None:
        """The materials of faces that have their own; paint further in stays."""
        ends = [*made.faces, len(made.pattern.angular)]
        paints = self.paints.setdefault(number, {})
        for first, last, material in painted:
            for face in range(ends[first], ends[last]):
                paints.setdefault(face, material)


def _csg_boxes_in_blocks(
    key: Sequence[Hashable], leaves: Sequence[Shape], parts: Sequence[RowTable]
) -> tuple[Floats, Any]:
    """`boxes_of`, some bodies at a time."""
    boxes, known = np.empty((len(parts[0]), BOX_NUMBERS)), np.empty(len(parts[0]), bool)
    for some in row_blocks(len(boxes)):
        boxes[some], known[some] = csg_boxes(key, leaves, [part[some] for part in parts])
    return boxes, known


def _narrow_bounds(bodies: Sequence[tuple[Boolean, CsgPlan]], parts: Sequence[Floats]) -> Floats:
    """Bounds of bodies whose parts may narrow one another, from the boxes of their parts."""
    found = np.empty((len(bodies), 6))
    for row, (shape, plan) in enumerate(bodies):
        known = {
            (id(leaf), steps): (boxes[row, :3], boxes[row, 3:])
            for (leaf, steps), boxes in zip(plan.leaves, parts, strict=True)
        }
        found[row] = np.concatenate(region_bounds(shape, IDENTITY_MOTION, known))
    return found


def _group_by_forms(form_of: Ints, tables: Ints, which: Any) -> Iterator[tuple[list[int], Any]]:
    """(the forms of their parts, bodies of these forms) of some bodies; tables (bodies, parts) has numbers of forms."""
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


def _rows_by_place(found: list[tuple[PrimitiveForm, Ints, RowTable]], count: int) -> _RowLocations:
    """Rows by places."""
    table, row = np.full(count, -1, np.int32), np.zeros(count, np.int32)
    for number, (_, places, rows) in enumerate(found):
        table[places] = number
        row[places] = np.arange(len(rows), dtype=np.int32)
    return _RowLocations([form for form, _, _ in found], [rows for _, _, rows in found], table, row)
