"""The numbers of bodies worked out alone, but for their boxes: those of primitives that several bodies share, once.

Cells of one universe meet at its surfaces, so that each surface bounds several bodies, and bodies that are one another
moved have some in common.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import Any, NamedTuple, Protocol, TypeAlias

import numpy as np

from .._util.arrays import unique_with_inverse
from ..geometry.cell import Cell
from ..geometry.instances import InstanceList, Ints, Shift, ShiftTable
from ..geometry.shape import Shape, Solid
from ..geometry.surface import ORIGIN, PlaneSurface, QuadricSurface
from ..geometry.transform import IDENTITY_MOTION, Motion, Step
from ..kernels.tables import MAP_SIZE, PLANE, PLANE_SIZE, SPHERE, Floats
from ..numerics.tracing import Tape, TracedFloat
from .assembly import CENTER_TOLERANCE, Assembly
from .batch_lowering import BatchLowering
from .csg_batch import placed_primitives
from .lower_shape import BodyFaces, LoweredShape, lower_shape, own_frame, surface_numbers, world_tree
from .motion_batch import POINT_SIZE, PointPlaneMover
from .pattern import SIZES, BodyPattern, FactoredRows, IndexedColumns, Offsets
from .pytree import flatten, unflatten
from .tape import recording_cache
from .tape.program import NO_INPUTS

_NumberLists: TypeAlias = tuple[list[float], list[float], tuple[int, ...]]
"""Numbers of surfaces and of uv, and the kinds of the surfaces."""


class PrimitiveCache:
    """Works out bodies, and remembers their primitives; those of many bodies together, from recordings."""

    def __init__(self) -> None:
        self._known: dict[Hashable, _NumberLists] = {}

    def prepare(self, shapes: Iterable[Shape]) -> None:
        """Work out the primitives of solids whose numbers will be asked for."""
        self.prepare_primitives(primitive for shape in shapes for primitive in placed_primitives(shape))

    def prepare_primitives(self, moved: Iterable[tuple[Shape, tuple[Step, ...]]]) -> None:
        """Work out primitives that steps move."""
        missing: dict[Hashable, dict[Hashable, tuple[Shape, tuple[Step, ...], Floats]]] = {}
        for leaf, steps in moved:
            told = _flatten_primitive(leaf, steps)
            if told is not None and told.key not in self._known:
                missing.setdefault(told.forms, {})[told.key] = leaf, steps, told.numbers
        for forms, alike in missing.items():
            if len(alike) >= recording_cache.FEWEST:
                self._play(forms, list(alike), list(alike.values()))

    def _play(self, forms: Hashable, keys: list[Hashable], alike: list[tuple[Shape, tuple[Step, ...], Floats]]) -> None:
        """Work out primitives of which the same was said but for its numbers; those that are left open are left."""

        def record(which: int, tape: Tape) -> tuple[int, int, tuple[int, ...]]:
            leaf, steps, _ = alike[which]
            traced = unflatten(leaf, tape)
            object.__setattr__(traced, "motion", Motion(tuple(unflatten(step, tape) for step in steps)))
            surfaces, uv, kinds = _primitive_numbers(traced)
            found = [float(x.value if isinstance(x, TracedFloat) else x) for x in (*surfaces, *uv)]
            alone = _compute_numbers(leaf, steps)
            if not _same_bits(found, [*alone[0], *alone[1]]) or kinds != alone[2]:
                raise TypeError("it is not the same where it is recorded")
            for number in (*surfaces, *uv):
                tape.write(number)
            return len(surfaces), len(found), kinds

        numbers = np.array([each for _, _, each in alike])
        rows = np.zeros(len(alike), np.int32)
        for (first_uv, count, kinds), which, played in recording_cache.RECORDINGS.play(
            ("alone", forms), record, numbers, NO_INPUTS, rows
        )[0]:
            assert played.floats.shape[1] == count
            for k, row in zip(which.tolist(), played.floats.tolist(), strict=True):
                self._known[keys[k]] = row[:first_uv], row[first_uv:], kinds

    def numbers(self, shape: Shape) -> Floats:
        """The row of a solid's numbers but for its boxes: its surfaces, the uv of its faces, the way to its frame."""
        surfaces: list[float] = []
        uv: list[float] = []
        for leaf, steps in placed_primitives(shape):
            own = self.of(leaf, steps)
            surfaces += own[0]
            uv += own[1]
        return np.array([*surfaces, *uv, *(number for line in own_frame(shape).inverse_rows for number in line)])

    def of(self, leaf: Shape, steps: tuple[Step, ...]) -> _NumberLists:
        """(numbers of surfaces, of uv, kinds of surfaces) of a primitive that steps move."""
        told = _flatten_primitive(leaf, steps)
        if told is None:
            return _compute_numbers(leaf, steps)
        if told.key not in self._known:
            self._known[told.key] = _compute_numbers(leaf, steps)
        return self._known[told.key]


class _FlatPrimitive(NamedTuple):
    """What was said of a primitive and of the steps that move it."""

    forms: Hashable
    numbers: Floats
    key: Hashable
    """All of it to the last bit."""


def _flatten_primitive(leaf: Shape, steps: tuple[Step, ...]) -> _FlatPrimitive | None:
    """None where there is more to them than numbers."""
    forms: list[Hashable] = []
    numbers: list[float] = []
    for thing in (leaf, *steps):
        told = flatten(thing)
        if told is None:
            return None
        forms.append(told.form)
        numbers += told.numbers
    every, all_forms = np.array(numbers), tuple(forms)
    return _FlatPrimitive(all_forms, every, (all_forms, every.tobytes()))


def _compute_numbers(leaf: Shape, steps: tuple[Step, ...]) -> _NumberLists:
    """`Alone.of`, computed."""
    return _primitive_numbers(replace(leaf, motion=Motion(steps)))


def _primitive_numbers(leaf: Any) -> _NumberLists:
    """(numbers of surfaces, of uv, kinds of surfaces) of a primitive, which may be recorded."""
    assembly, faces = Assembly(), BodyFaces()
    tree = world_tree(leaf, IDENTITY_MOTION, faces)
    if isinstance(tree, Cell):
        assembly.cell(tree)
    else:
        assembly.program(tree, {})
    kinds = tuple(record.kind for record in assembly.surfaces)
    return surface_numbers(assembly), [number for numbers in faces.maps()[0] for number in numbers], kinds


def _same_bits(some: list[float], others: list[float]) -> bool:
    """Are numbers equal to the last bit?"""
    return np.array(some).tobytes() == np.array(others).tobytes()


# Bodies that are one another moved: the first is lowered as ever, of the others only what moving changes.
#
# A shift moves the anchors of surfaces, and with them uv and frames. Along each axis there are few different shifts, so
# what depends on one axis is lowered from one body for each of them, and gathered: the numbers are those that every
# body
# would have alone, to the bit. Boxes are the first body's, moved and a little wider.
#
# What a number depends on is not taken on trust: all bodies that were lowered for some axis are compared with what is
# told of them, and where one differs, every body is lowered alone.

FEWEST_INSTANCES = 24
"""Bodies of a kind that are worth it."""
SAME_SHIFT = 2.0**-40
"""Relative difference of uv and frames of slanted bodies, which are computed, from those worked out alone."""


class TranslatedBodies(Protocol):
    """What `moved_rows` asks of `Repeated`."""

    @property
    def shifts(self) -> ShiftTable: ...

    @property
    def alone(self) -> dict[tuple[int, ...], Floats]: ...

    def is_rigid(self, kind: int, /) -> bool: ...

    def made(self, kind: int, shift: Shift, /) -> Solid: ...

    def shape(self, number: int, /) -> Solid: ...


def translated_rows(
    bodies: TranslatedBodies, kind: int, numbers: Ints, alone: PrimitiveCache | None = None
) -> tuple[BodyPattern, FactoredRows] | None:
    """The pattern and the rows of the bodies of a kind; None where they have to be lowered one by one.

    alone: what is known of primitives that other kinds have in common with this one.
    """
    if len(numbers) < FEWEST_INSTANCES or not bodies.is_rigid(kind):
        return None
    first = bodies.shape(int(numbers[0]))
    part = lower_shape(first)
    if part.paints or part.outlines or not isinstance(first, Solid):
        return None
    try:
        return _TranslatedRows(bodies, kind, numbers, part, alone or PrimitiveCache()).rows()
    except _StructureDiffers:
        return None


class _StructureDiffers(Exception):
    """Of bodies that are one another moved one has more or fewer numbers, as rounding has made two of them one."""


@dataclass
class _AxisBodies:
    """What bodies with all the different shifts along an axis are, each alone."""

    leads: Ints  # among the bodies of the kind
    index: Ints  # of each body, which of them has its shift
    numbers: Floats  # (leads, columns up to the boxes, then the frame)


class _TranslatedRows:
    """One run of `moved_rows`."""

    def __init__(
        self, bodies: TranslatedBodies, kind: int, numbers: Ints, part: LoweredShape, alone: PrimitiveCache
    ) -> None:
        self.bodies, self.kind, self.part, self.alone = bodies, kind, part, alone
        self.shifts: ShiftTable = bodies.shifts.chosen(numbers)
        self.known: dict[int, Floats] = {}
        self.taken: list[int] = []  # columns that are those of another body with the same plane
        p = part.pattern
        self.ends = p.bounds_at, p.frame_at

    def rows(self) -> tuple[BodyPattern, FactoredRows] | None:
        """`moved_rows`"""
        pattern, base = self.part.pattern, np.array(self.part.row)
        moved = FactoredRows(base, Offsets.of(self.shifts), boxes=(pattern.bounds_at, pattern.frame_at))
        axes = [self._along(axis) for axis in range(3)]
        for slot, (kind, column, sense) in enumerate(pattern.records):
            normal = np.flatnonzero(base[column : column + 3])
            if kind == PLANE and len(normal) > 1:
                found = self._slanted(slot)
                if found is None:
                    return None
                moved.gathered.append(self._gathered(found, column, sense + 1))
                moved.leads[column] = found.leads.astype(np.int32)[found.index]
                self.taken += range(column, sense + 1)
                continue
            anchor = column + SIZES[kind] - 3 if kind == PLANE else column
            for axis, along in enumerate(axes):
                for at in (anchor + axis, anchor + SIZES[kind] + axis):
                    moved.gathered.append(self._gathered(along, at, at + 1))
            if kind != PLANE:
                moved.forms[column] = self._form(slot, kind, column, moved)
            else:
                moved.leads[column] = _first_records(axes[normal[0]].index, moved[:, column : column + PLANE_SIZE])
        for begin, end in ((pattern.uv_at, pattern.bounds_at), (pattern.frame_at, pattern.corners_at)):
            for at in range(begin, end, 4):
                used = np.flatnonzero(base[at : at + 3])
                if len(used) == 1:
                    moved.gathered.append(self._gathered(axes[used[0]], at, at + 4))
                elif len(used) > 1 and self._moves(at):
                    moved.slanted.append(at)
        return (pattern, moved) if self._holds(moved) else None

    def _form(self, slot: int, kind: int, column: int, moved: FactoredRows) -> Hashable:
        """What says that surfaces are one whose anchors are; None where anchors are rounded."""
        surface, size = self.part.exact[slot], SIZES[kind]
        if moved[:, column + size : column + size + 3].any() or not isinstance(surface, QuadricSurface):
            return None
        numbers = np.delete(moved.base[column : column + 2 * size + 1], [0, 1, 2])
        return replace(surface, anchor=ORIGIN).key(), numbers.tobytes()

    def _made(self, which: int) -> Solid:
        """The shape of one of the bodies."""
        return self.bodies.made(self.kind, self.shifts.of(which))

    def _numbers(self, shape: Solid) -> Floats:
        """The columns of a body but for its boxes, worked out alone."""
        numbers = self.alone.numbers(shape)
        if len(numbers) != self._column(self.part.pattern.corners_at):
            raise _StructureDiffers
        return numbers

    def _alone(self, which: int) -> Floats:
        """Those of one of the bodies."""
        if which not in self.known and not self._is_kept(which):
            self._keep(which, self._numbers(self._made(which)))
        return self.known[which]

    def _work_out(self, leads: list[int]) -> None:
        """Make sure that bodies are known: those of several parts together, which is to the bit the same."""
        missing = [lead for lead in leads if lead not in self.known and not self._is_kept(lead)]
        if len(missing) < FEWEST_INSTANCES or len(self.part.pattern.cells) < FEWEST_INSTANCES:
            shapes = list(map(self._made, missing))
            self.alone.prepare(shapes)
            for lead, shape in zip(missing, shapes, strict=True):
                self._keep(lead, self._numbers(shape))
            return
        together = BatchLowering()
        for lead in missing:
            if not together.add(self.bodies.made(self.kind, self.shifts.of(lead)), lead):
                return
        before_boxes, after_boxes = self.ends
        found, _ = together.lowered()
        for pattern, numbers, rows in found:
            if pattern != self.part.pattern:
                raise _StructureDiffers
            some = np.concatenate([rows[:, :before_boxes], rows[:, after_boxes : pattern.corners_at]], axis=1)
            for lead, row in zip(numbers.tolist(), some, strict=True):
                self._keep(lead, row)

    def _keep(self, lead: int, numbers: Floats) -> None:
        """Know a body, for edited lists as well."""
        self.known[lead] = self.bodies.alone[self._place(lead)] = numbers

    def _is_kept(self, lead: int) -> bool:
        """Is a body known to the list? Then it is known here."""
        found = self.bodies.alone.get(self._place(lead))
        if found is None or len(found) != self._column(self.part.pattern.corners_at):
            return False
        self.known[lead] = found
        return True

    def _place(self, lead: int) -> tuple[int, ...]:
        """The kind of a body, and the places of its shift."""
        x, y, z = self.shifts.index[:, lead].tolist()
        return self.kind, x, y, z

    @cached_property
    def _aside(self) -> Floats:
        """How far the bodies are from the diagonal of their shifts."""
        index = self.shifts.index
        share = index / (1.0 + index.max(axis=1, keepdims=True))
        some = index.max(axis=1) > 0
        return np.ptp(share[some], axis=0) if some.any() else np.zeros(index.shape[1])

    def _leads(self, key: Any) -> _AxisBodies:
        """One body for each value of a key; those on the diagonal, if there are some, as they serve several axes."""
        key = np.asarray(key)
        least = np.full(int(key.max()) + 1, np.inf)
        np.minimum.at(least, key, self._aside)
        there = np.isfinite(least)
        which = (np.cumsum(there, dtype=np.int32) - np.int32(1))[key]
        nearest = np.flatnonzero(self._aside == least[key])[::-1]
        leads = np.empty(int(there.sum()), np.int64)
        leads[which[nearest]] = nearest  # of equal ones the first
        self._work_out(leads.tolist())
        alone = np.array([self._alone(lead) for lead in leads.tolist()])
        return _AxisBodies(leads.astype(np.int32), which, alone)

    def _along(self, axis: int) -> _AxisBodies:
        """By the shift along an axis."""
        return self._leads(self.shifts.index[axis])

    def _slanted(self, slot: int) -> _AxisBodies | None:
        """By what a plane depends on: how far the shift is along its normal. None where it differs too often."""
        surface = self.part.exact[slot]
        if not isinstance(surface, PlaneSurface):
            return None
        try:
            exact = [Fraction(n) for n in surface.normal]
        except TypeError:
            return None
        distances: dict[Fraction, int] = {}
        parts = [[n * value for value in values] for n, values in zip(exact, self.shifts.values, strict=True)]
        keys = [
            distances.setdefault(parts[0][x] + parts[1][y] + parts[2][z], len(distances))
            for x, y, z in self.shifts.index.T.tolist()
        ]
        return self._leads(np.array(keys)) if len(distances) <= max(FEWEST_INSTANCES, len(keys) // 8) else None

    def _gathered(self, alone: _AxisBodies, first: int, last: int) -> IndexedColumns:
        """Columns by what they depend on."""
        begin = self._column(first)
        return IndexedColumns(first, last, alone.numbers[:, begin : begin + last - first], alone.index)

    def _column(self, column: int) -> int:
        """A column of rows among those without boxes."""
        before_boxes, after_boxes = self.ends
        return column if column < before_boxes else column - (after_boxes - before_boxes)

    def _moves(self, at: int) -> bool:
        """Does an affine map, of which the row begins at a column, move with the bodies?"""
        column = self._column(at)
        return any(numbers[column + 3] != self.part.row[at + 3] for numbers in self.known.values())

    def _holds(self, moved: FactoredRows) -> bool:
        """Are all bodies that were worked out alone as the rows say?"""
        which = np.array(sorted(self.known))
        before_boxes, after_boxes = self.ends
        told = np.concatenate(
            [moved.of(which, 0, before_boxes), moved.of(which, after_boxes, self.part.pattern.corners_at)], axis=1
        )
        found = np.array([self.known[int(each)] for each in which])
        if told.shape != found.shape:
            return False
        exact, own = np.ones(told.shape[1], bool), np.ones(told.shape[1], bool)
        exact[[self._column(at) + 3 for at in moved.slanted]] = False
        own[self.taken] = False
        near = np.abs(told - found) <= SAME_SHIFT * (
            1.0 + np.abs(found) + np.abs(moved.away[which]).max(axis=1)[:, None]
        )
        return bool((told.view(np.int64) == found.view(np.int64))[:, exact & own].all() and near[:, own].all())


def _first_records(groups: Ints, records: Floats) -> Ints:
    """For each row the one of its group whose record comes first in order, as `surfaces` chooses among equals."""
    differing = [column for column in records.T[::-1] if (column != column[0]).any()]
    order = np.lexsort((*differing, groups))
    begins = np.concatenate([[True], np.diff(groups[order]) != 0])
    found = np.empty(len(groups), np.int32)
    found[order] = order[np.maximum.accumulate(np.where(begins, np.arange(len(order)), 0))]
    return found


# Bodies of a lattice that is turned: one another moved before a motion that all of them have.
#
# Before the motion they are lowered as all that are one another moved (`moved`), and few of their numbers differ. The
# motion then carries anchors of curved surfaces, each once, and planes, each once; squares, rows and normals are
# those of
# the first body. In the world, too, the bodies are one another moved, so they share what such bodies share.
#
# Which of their surfaces are one is said by what they are before the motion, where it is seen without rounding.

_SAMPLES = 3
"""Bodies of a kind that are worked out alone, to be compared."""


def instance_rows(
    bodies: InstanceList, kind: int, numbers: Ints, alone: PrimitiveCache, carried: PointPlaneMover
) -> tuple[BodyPattern, FactoredRows] | None:
    """The pattern and the rows of the bodies of a kind; None where they have to be lowered one by one."""
    motion = bodies.motion(kind)
    if motion.is_identity:
        return translated_rows(bodies, kind, numbers, alone)
    still = translated_rows(UnrotatedBodies(bodies), kind, numbers, alone)
    if still is None:
        return None
    part = lower_shape(bodies.shape(int(numbers[0])))
    if part.pattern.kinds.tolist() != still[0].kinds.tolist() or part.paints:
        return None
    return _RotatedRows(bodies, kind, numbers, part, still[0], still[1], alone, carried).rows()


@dataclass(frozen=True)
class UnrotatedBodies:
    """Bodies before the motions of their kinds, as `moved_rows` asks for them."""

    bodies: InstanceList

    @property
    def shifts(self) -> ShiftTable:
        """Those of the bodies."""
        return self.bodies.shifts

    @property
    def alone(self) -> dict[tuple[int, ...], Floats]:
        """What was worked out alone before."""
        return self.bodies.alone

    def is_rigid(self, kind: int) -> bool:
        """`Repeated.is_rigid`"""
        return self.bodies.is_rigid(kind)

    def made(self, kind: int, shift: Shift) -> Solid:
        """`Repeated.made`"""
        return self.bodies.before(kind, shift)

    def shape(self, number: int) -> Solid:
        """`Repeated.shape`"""
        return self.made(int(self.bodies.kinds[number]), self.shifts.of(number))


@dataclass
class _RotatedRows:
    """One run of `rows_of_kind`."""

    bodies: InstanceList
    kind: int
    numbers: Ints
    part: LoweredShape
    before: BodyPattern
    still: FactoredRows
    alone: PrimitiveCache
    carried: PointPlaneMover

    def rows(self) -> tuple[BodyPattern, FactoredRows] | None:
        """`rows_of_kind`"""
        pattern, away = self.part.pattern, Offsets.among(self.bodies, self.numbers)
        moved = FactoredRows(np.array(self.part.row), away, boxes=(pattern.bounds_at, pattern.frame_at))
        for kind, column, sense in pattern.records:
            if not (self._plane(moved, column, sense) if kind == PLANE else self._curved(moved, kind, column)):
                return None
        ends = (pattern.uv_at, pattern.bounds_at, self.before.uv_at), (
            pattern.frame_at, pattern.corners_at, self.before.frame_at,
        )  # fmt: skip
        for begin, end, own in ends:
            for at in range(0, end - begin, MAP_SIZE):
                self._map(moved, begin + at, own + at)
        return (pattern, moved) if self._holds(moved) else None

    @property
    def motion(self) -> Motion:
        """That of the kind."""
        return self.bodies.motion(self.kind)

    def _curved(self, moved: FactoredRows, kind: int, column: int) -> bool:
        """Carry the anchors of a surface of all bodies; False where rounding was in the way before."""
        form, size = self.still.forms.get(column), SIZES[kind]
        if form is None:
            return False
        coordinates = [self.still.distinct(column + axis) for axis in range(POINT_SIZE)]
        first, index = _distinct_points(coordinates)
        points = np.stack([values[which[first]] for values, which in coordinates], axis=1) + 0.0
        found = self.carried.points(self.motion, points)
        if kind == SPHERE and (
            np.abs(found[:, POINT_SIZE:]).max() > CENTER_TOLERANCE * moved.base[column + POINT_SIZE]
        ):
            return False
        moved.gathered.append(IndexedColumns(column, column + POINT_SIZE, found[:, :POINT_SIZE], index))
        moved.gathered.append(IndexedColumns(column + size, column + size + POINT_SIZE, found[:, POINT_SIZE:], index))
        moved.names[column] = (self.motion, form), coordinates
        return True

    def _plane(self, moved: FactoredRows, column: int, sense: int) -> bool:
        """Carry a plane of all bodies, each different one once: that of the first of those that have it."""
        leads, index = unique_with_inverse(self.still.leads[column])
        records, which = self.still.of(leads, column, sense + 1), index.astype(np.int32)
        rests = records[:, PLANE_SIZE:-1]
        if rests.any():
            found = np.array([self._alone(lead)[column : sense + 1] for lead in leads.tolist()])
        else:
            found = self.carried.planes(self.motion, records[:, :PLANE_SIZE])
            found[:, -1] *= records[:, -1]
            normal = records[0, :POINT_SIZE]
            along = np.flatnonzero(normal)
            if (
                len(along) == 1
                and not records[:, POINT_SIZE].any()
                and (records[:, [0, 1, 2, -1]] == [*normal, records[0, -1]]).all()
            ):
                once = np.zeros(1), np.zeros(len(which), np.int32)
                place = records[:, POINT_SIZE + 1 + along[0]], which
                moved.names[column] = ("plane", int(along[0]), self.motion), [place, once, once]
        moved.gathered.append(IndexedColumns(column, sense + 1, found, which))
        if column not in moved.names:
            moved.leads[column] = leads[index].astype(np.int32)
        return True

    def _map(self, moved: FactoredRows, at: int, own: int) -> None:
        """A row of an affine map: what is before it, the motion, is alike; its height moves as it did before."""
        values, index = self.still.maps(own)
        if len(values) > 1:
            first = self.still.of(np.zeros(1, np.int64), own, own + MAP_SIZE)[0]
            rows = np.tile(moved.base[at : at + MAP_SIZE], (len(values), 1))
            rows[:, -1] += values[:, -1] - first[-1]
            moved.gathered.append(IndexedColumns(at, at + MAP_SIZE, rows, index))

    def _alone(self, which: int) -> Floats:
        """The numbers of one of the bodies but for its boxes, worked out alone; edited lists know them too."""
        number = int(self.numbers[which])
        x, y, z = self.bodies.shifts.index[:, number].tolist()
        known, place = self.bodies.alone, (-1 - self.kind, x, y, z)  # not those before the turn
        if place not in known:
            known[place] = self.alone.numbers(self.bodies.shape(number))
        return known[place]

    def _holds(self, moved: FactoredRows) -> bool:
        """Are some bodies that are worked out alone as the rows say? Planes need not be, of which others have one."""
        pattern, count = self.part.pattern, len(moved)
        for which in {count - 1 - k * (count - 1) // _SAMPLES for k in range(_SAMPLES)}:
            some, found = np.array([which]), self._alone(which)
            told = np.concatenate(
                [moved.of(some, 0, pattern.bounds_at)[0], moved.of(some, pattern.frame_at, pattern.corners_at)[0]]
            )
            if told.shape != found.shape:
                return False
            for kind, column, sense in pattern.records:
                same: Any = told[column : sense + 1].view(np.int64) == found[column : sense + 1].view(np.int64)
                if not same[[0, 1, 2, -1] if kind == PLANE else slice(None)].all():
                    return False
            far = 1.0 + np.abs(found) + np.abs(moved.away[some]).max()
            if not (np.abs(told - found)[pattern.uv_at :] <= SAME_SHIFT * far[pattern.uv_at :]).all():
                return False
        return True


def _distinct_points(coordinates: list[tuple[Floats, Ints]]) -> tuple[Any, Ints]:
    """(the first thing of each different place, of each thing the number of its place)."""
    code = np.zeros(len(coordinates[0][1]), np.int64)
    for values, which in coordinates:
        code = code * len(values) + which
    _, first, index = np.unique(code, return_index=True, return_inverse=True)
    return first, index.astype(np.int32)
