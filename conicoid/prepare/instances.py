"""Lower instances: bodies that are copies of each other, shifted, or shifted before a common motion.

`translated_rows` lowers shifted copies; `instance_rows` lowers those that a motion, a rotation say, carries as a whole.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterable
from dataclasses import replace
from fractions import Fraction
from functools import cached_property
from typing import Any, NamedTuple, Protocol

import numpy as np

from .._jit.decorators import kernel
from .._util.arrays import unique_sorted, unique_with_inverse
from .._util.records import dataclass
from ..geometry.instances import Coordinates, InstanceList, Ints, Shift, ShiftTable, round_sums
from ..geometry.shape import Solid
from ..geometry.surface import CENTER_TOLERANCE, ORIGIN, PlaneSurface, QuadricSurface
from ..geometry.transform import Motion
from ..kernels.tables import MAP_SIZE, PLANE, PLANE_SIZE, SPHERE, Floats, Longs
from .csg_plan import placed_primitives
from .lower_shape import LoweredShape, lower_shape, own_frame
from .motion_batch import POINT_SIZE, PointPlaneMover
from .pattern import SIZES, BodyPattern, FactoredRows, IndexedColumns, Offsets
from .primitive_cache import PrimitiveCache, flatten_primitive

# Translated copies: the first body is lowered in full, and of the others only the numbers that a shift changes
#
# A shift moves the anchors of surfaces, and with them uv maps and frames. Along each axis few different shifts occur,
# so the numbers that depend on one axis are lowered from one body for each shift and gathered: to the bit the numbers
# that every body would have by itself. Boxes are the first body's, shifted and a little wider.
#
# The dependence of numbers on axes is verified, not assumed: every body that was lowered for some axis is compared with
# what the gathered rows give for it. Where one differs, all bodies are lowered one by one.

FEWEST_INSTANCES = 24
"""Fewer bodies of a kind are lowered one by one."""
SAME_SHIFT = 2.0**-40
"""Largest relative difference of the computed uv maps and frames of slanted bodies from those lowered singly."""


class TranslatedBodies(Protocol):
    """The part of `InstanceList` that `translated_rows` needs."""

    @property
    def shifts(self) -> ShiftTable: ...

    @property
    def single_columns(self) -> dict[tuple[int, ...], Floats]: ...

    def is_rigid(self, kind: int, /) -> bool: ...

    def coordinates(self, kind: int, /) -> Coordinates | None: ...

    def shape_at(self, kind: int, shift: Shift, /) -> Solid: ...

    def shape(self, number: int, /) -> Solid: ...


def translated_rows(
    bodies: TranslatedBodies, kind: int, numbers: Ints, cache: PrimitiveCache | None = None
) -> tuple[BodyPattern, FactoredRows] | None:
    """Lower the translated bodies of a kind.

    Parameters
    ----------
    bodies : TranslatedBodies
        The instances of a scene.
    kind : int
        The kind of the bodies to lower.
    numbers : Ints
        (n,) the numbers of these bodies, rising.
    cache : PrimitiveCache, optional
        Primitives that other kinds share with this one.

    Returns
    -------
    tuple[BodyPattern, FactoredRows] or None
        Pattern and rows; None where the bodies must be lowered one by one.
    """
    if len(numbers) < FEWEST_INSTANCES or not bodies.is_rigid(kind):
        return None
    first = bodies.shape(int(numbers[0]))
    part = lower_shape(first)
    if part.paints or part.outlines or not isinstance(first, Solid):
        return None
    try:
        return _TranslatedRows(bodies, kind, numbers, part, cache or PrimitiveCache()).rows()
    except _StructureDiffers:
        return None


class _StructureDiffers(Exception):
    """A translated copy has more or fewer numbers than the first, because rounding made two of them equal."""


_PROBES = tuple(
    (Fraction(a, 1000003), Fraction(b, 1000003), Fraction(c, 1000003))
    for a, b, c in ((314159, -271828, 141421), (-577215, 161803, 693147))
)
"""Two places at which no file has a body, and each number of a shape that depends on its place has another value."""


class _Template(NamedTuple):
    """A primitive of a kind, flattened, with the numbers that depend on the place of a body."""

    forms: tuple[Any, ...]
    numbers: Floats
    sizes: tuple[int, int]
    """How many numbers its surfaces and its uv maps have."""
    moving: list[tuple[int, float, int, Fraction]]
    """(number, sign, axis, coordinate): the number is the coordinate plus the shift along the axis, rounded."""


@dataclass
class _AxisBodies:
    """The numbers of one body for each different shift along an axis, each lowered by itself."""

    leads: Ints  # positions among the bodies of the kind
    index: Ints  # for each body the lead with its shift
    numbers: Floats  # (leads, columns up to the boxes, then the frame)


class _TranslatedRows:
    """One run of `translated_rows`."""

    def __init__(
        self, bodies: TranslatedBodies, kind: int, numbers: Ints, part: LoweredShape, cache: PrimitiveCache
    ) -> None:
        self.bodies, self.kind, self.part, self.cache = bodies, kind, part, cache
        self.shifts: ShiftTable = bodies.shifts.select(numbers)
        self.columns_of_kinds: dict[int, Floats] = {}
        self.taken: list[int] = []  # columns that stand for another body's equal plane
        p = part.pattern
        self.ends = p.bounds_at, p.frame_at

    def rows(self) -> tuple[BodyPattern, FactoredRows] | None:
        """Build the rows, and verify them."""
        pattern, base = self.part.pattern, np.array(self.part.row)
        leads = unique_sorted(*(self._leads(key)[0] for key in self.shifts.index))
        # Of bodies that have no shift in common each would be lowered by itself, and a batch lowers many at once
        if len(leads) == self.shifts.index.shape[1] and self.bodies.coordinates(self.kind) is None:
            return None
        factored = FactoredRows(base, Offsets.of(self.shifts), boxes=(pattern.bounds_at, pattern.frame_at))
        axes = self._along(self.shifts.index)
        for slot, (kind, column, sense) in enumerate(pattern.records):
            normal = np.flatnonzero(base[column : column + 3])
            if kind == PLANE and len(normal) > 1:
                planes = self._slanted(slot)
                if planes is None:
                    return None
                factored.indexed_columns.append(self._gather(planes, column, sense + 1))
                factored.leads[column] = planes.leads.astype(np.int32)[planes.index]
                self.taken += range(column, sense + 1)
                continue
            anchor = column + SIZES[kind] - 3 if kind == PLANE else column
            for axis, along in enumerate(axes):
                for at in (anchor + axis, anchor + SIZES[kind] + axis):
                    factored.indexed_columns.append(self._gather(along, at, at + 1))
            if kind != PLANE:
                factored.forms[column] = self._form(slot, kind, column, factored)
            else:
                numbers = [factored.distinct(at) for at in range(column, column + PLANE_SIZE)]
                factored.leads[column] = _first_records(axes[normal[0]].index, numbers)
        for begin, end in ((pattern.uv_at, pattern.bounds_at), (pattern.frame_at, pattern.corners_at)):
            for at in range(begin, end, 4):
                used = np.flatnonzero(base[at : at + 3])
                if len(used) == 1:
                    factored.indexed_columns.append(self._gather(axes[used[0]], at, at + 4))
                elif len(used) > 1 and self._moves(at):
                    factored.slanted.append(at)
        return (pattern, factored) if self._is_verified(factored) else None

    def _form(self, slot: int, kind: int, column: int, moved: FactoredRows) -> Hashable:
        """Return a key of a curved surface apart from its anchor; None where anchors are rounded."""
        surface, size = self.part.exact[slot], SIZES[kind]
        rests = [moved.distinct(at)[0] for at in range(column + size, column + size + 3)]
        if any(map(np.any, rests)) or not isinstance(surface, QuadricSurface):
            return None
        numbers = np.delete(moved.base[column : column + 2 * size + 1], [0, 1, 2])
        return replace(surface, anchor=ORIGIN).key(), numbers.tobytes()

    def _shape_of(self, which: int) -> Solid:
        """Return the shape of one of the bodies."""
        return self.bodies.shape_at(self.kind, self.shifts.of(which))

    def _numbers(self, shape: Solid) -> Floats:
        """Compute the columns of a body without its boxes; raise `_StructureDiffers` where their count differs."""
        numbers = self.cache.numbers(shape)
        if len(numbers) != self._column(self.part.pattern.corners_at):
            raise _StructureDiffers
        return numbers

    def _single_columns(self, which: int) -> Floats:
        """Return the columns of one of the bodies."""
        if which not in self.columns_of_kinds and not self._look_up(which):
            self._record(which, self._numbers(self._shape_of(which)))
        return self.columns_of_kinds[which]

    def _compute(self, leads: list[int]) -> None:
        """Compute the columns of bodies that are not known yet."""
        missing = [
            lead for lead in dict.fromkeys(leads) if lead not in self.columns_of_kinds and not self._look_up(lead)
        ]
        if len(missing) >= FEWEST_INSTANCES and self._templates is not None:
            self._fill_templates(np.array(missing), self._templates)
            missing = [lead for lead in missing if lead not in self.columns_of_kinds]
        shapes = list(map(self._shape_of, missing))
        self.cache.prepare(shapes)
        for lead, shape in zip(missing, shapes, strict=True):
            self._record(lead, self._numbers(shape))

    @cached_property
    def _templates(self) -> list[_Template] | None:
        """The primitives of the kind with the numbers that a shift changes; None where these are not all known.

        Two shapes at places that no file has show which numbers change.
        """
        places, coordinates = _PROBES, self.bodies.coordinates(self.kind)
        one, other = (self.bodies.shape_at(self.kind, place) for place in places)
        if coordinates is None or own_frame(one).inverse_rows != own_frame(other).inverse_rows:
            return None
        sources: dict[tuple[float, ...], set[tuple[int, Fraction]]] = {}
        for axis, some in enumerate(coordinates):
            for value in some:
                sources.setdefault(tuple(float(value + place[axis]) for place in places), set()).add((axis, value))
        found = []
        for leaves in zip(placed_primitives(one), placed_primitives(other), strict=True):
            flat, moved = (flatten_primitive(*leaf) for leaf in leaves)
            if flat is None or moved is None or flat.forms != moved.forms:
                return None
            surfaces, uv, _ = self.cache.of(*leaves[0])
            columns = np.flatnonzero(flat.numbers != moved.numbers).tolist()
            moving = [
                (column, sign, axis, value)
                for column in columns
                for sign in (1.0, -1.0)
                for axis, value in sources.get((sign * flat.numbers[column], sign * moved.numbers[column]), ())
            ]
            if [column for column, *_ in moving] != columns:
                return None
            found.append(_Template(flat.forms, flat.numbers, (len(surfaces), len(uv)), moving))
        return found

    def _fill_templates(self, leads: Ints, templates: list[_Template]) -> None:
        """Record the columns of bodies that the templates give: their primitives at their places, without shapes."""
        pattern, index = self.part.pattern, self.shifts.index[:, leads]
        rows = np.zeros((len(leads), self._column(pattern.corners_at)))
        rows[:, self._column(pattern.frame_at) :] = self.part.row[pattern.frame_at : pattern.corners_at]
        decided, ends = np.zeros(len(leads), np.int32), [0, pattern.uv_at]
        for number, each in enumerate(templates):
            numbers = np.tile(each.numbers, (len(leads), 1))
            for column, sign, axis, value in each.moving:
                sums = round_sums(self.shifts.values[axis], value)
                numbers[:, column] = sign * sums[index[axis]] + 0.0

            def primitive(which: int, number: int = number) -> tuple[Any, ...]:
                return placed_primitives(self._shape_of(leads[which]))[number]

            columns = np.concatenate([at + np.arange(size) for at, size in zip(ends, each.sizes, strict=True)])
            for (first_uv, _), which, found in self.cache.rows(each.forms, numbers, primitive):
                if (first_uv, found.shape[1] - first_uv) == each.sizes:
                    rows[which[:, None], columns] = found
                    decided[which] += 1
            ends = [at + size for at, size in zip(ends, each.sizes, strict=True)]
        known = decided == len(templates)
        # At first, the bodies nearest to the origin and farthest from it must have the numbers of their shapes
        if not self.columns_of_kinds:
            shifts = zip(self.shifts.values, index, strict=True)
            far = np.max([np.abs(np.array(values, np.float64))[row] for values, row in shifts], axis=0)
            for k in {int(far.argmin()), int(far.argmax())}:
                if known[k] and self._numbers(self._shape_of(leads[k])).tobytes() != rows[k].tobytes():
                    self.__dict__["_templates"] = None
                    return
        for k in np.flatnonzero(known).tolist():
            self._record(int(leads[k]), rows[k])

    def _record(self, lead: int, numbers: Floats) -> None:
        """Record the columns of a body, here and in the list of instances, where edited lists find them."""
        self.columns_of_kinds[lead] = self.bodies.single_columns[self._place(lead)] = numbers

    def _look_up(self, lead: int) -> bool:
        """Look a body up in the list of instances; where it is there, record it here."""
        found = self.bodies.single_columns.get(self._place(lead))
        if found is None or len(found) != self._column(self.part.pattern.corners_at):
            return False
        self.columns_of_kinds[lead] = found
        return True

    def _place(self, lead: int) -> tuple[int, ...]:
        """Return the key of a body in the list: its kind, and the indices of its shift."""
        x, y, z = self.shifts.index[:, lead].tolist()
        return self.kind, x, y, z

    @cached_property
    def _diagonal_distances(self) -> Floats:
        """(bodies,) how far each body is from the diagonal of the shifts."""
        index = self.shifts.index
        found = np.empty(index.shape[1])
        put_diagonal_distances(index, 1.0 + index.max(axis=1), found)
        return found

    def _leads(self, key: Any) -> tuple[Longs, Ints]:
        """Choose one body for each value of a key, near the diagonal of the shifts: such a body serves several axes.

        Return these bodies, and which of them each body has the value of.
        """
        least = _first_least(self._diagonal_distances, key)
        there = least >= 0
        which = key if there.all() else (np.cumsum(there, dtype=np.int32) - np.int32(1))[key]
        return least[there].astype(np.int64), which

    def _along(self, keys: Iterable[Any]) -> list[_AxisBodies]:
        """Choose bodies by each key, and compute the columns of all of them together."""
        chosen = [self._leads(key) for key in keys]
        self._compute([lead for leads, _ in chosen for lead in leads.tolist()])
        return [
            _AxisBodies(
                leads.astype(np.int32), which, np.array([self._single_columns(lead) for lead in leads.tolist()])
            )
            for leads, which in chosen
        ]

    def _slanted(self, slot: int) -> _AxisBodies | None:
        """Choose bodies by the shift along a plane's normal, which the plane depends on.

        None for too many different shifts.
        """
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
        many = len(distances) > max(FEWEST_INSTANCES, len(keys) // 8)
        return None if many else self._along([np.array(keys, np.int32)])[0]

    def _gather(self, alone: _AxisBodies, first: int, last: int) -> IndexedColumns:
        """Gather columns by the bodies that they depend on."""
        begin = self._column(first)
        return IndexedColumns(first, last, alone.numbers[:, begin : begin + last - first], alone.index)

    def _column(self, column: int) -> int:
        """Return the place of a column among the columns without boxes."""
        before_boxes, after_boxes = self.ends
        return column if column < before_boxes else column - (after_boxes - before_boxes)

    def _moves(self, at: int) -> bool:
        """Return whether the affine map row at a column changes with the bodies."""
        column = self._column(at)
        return any(numbers[column + 3] != self.part.row[at + 3] for numbers in self.columns_of_kinds.values())

    def _is_verified(self, moved: FactoredRows) -> bool:
        """Return whether the rows reproduce every body that was lowered by itself.

        Maps of slanted bodies may differ by rounding; columns that stand for another body's plane are not compared.
        """
        which = np.array(sorted(self.columns_of_kinds))
        before_boxes, after_boxes = self.ends
        computed = np.concatenate(
            [moved.of(which, 0, before_boxes), moved.of(which, after_boxes, self.part.pattern.corners_at)], axis=1
        )
        expected = np.array([self.columns_of_kinds[int(each)] for each in which])
        if computed.shape != expected.shape:
            return False
        exact, own = np.ones(computed.shape[1], bool), np.ones(computed.shape[1], bool)
        exact[[self._column(at) + 3 for at in moved.slanted]] = False
        own[self.taken] = False
        near = np.abs(computed - expected) <= SAME_SHIFT * (
            1.0 + np.abs(expected) + np.abs(moved.offsets[which]).max(axis=1)[:, None]
        )
        return bool((computed.view(np.int64) == expected.view(np.int64))[:, exact & own].all() and near[:, own].all())


_EXACT = 1 << 53
"""All integers up to this are floats."""


def _first_records(groups: Ints, records: list[tuple[Floats, Ints]]) -> Ints:
    """Return for each row the row of its group whose record comes first, as `coincidence.py` chooses among equals.

    `records` has for each number of the records its distinct values, and which of them each row has.
    """
    keys, count = np.zeros(len(groups)), 1
    for values, index in records:
        if index is not groups and (values != values[0]).any():
            distinct, rank = unique_with_inverse(values)
            if count * len(distinct) > _EXACT:
                known, order = unique_with_inverse(keys)
                keys, count = order.astype(np.float64), len(known)
            keys *= len(distinct)
            keys += rank.astype(np.float64)[index]
            count *= len(distinct)
    return _first_least(keys, groups)[groups]


def _first_least(keys: Floats, groups: Ints) -> Ints:
    """Return for each group the first row with the least key; -1 for a group without rows."""
    least = np.full(int(groups.max()) + 1, np.inf)
    first = np.full(len(least), -1, np.int32)
    put_first_least(keys, groups, least, first)
    return first


@kernel(index="3 n", counts="3", distances="out n")
def put_diagonal_distances(index: Ints, counts: Floats, distances: Floats) -> None:
    """Write how far each body is from the diagonal of its shifts along the axes with several."""
    for i in range(len(distances)):
        low, high = math.inf, -math.inf
        for axis in range(3):
            share = index[axis, i] / counts[axis]
            if counts[axis] > 1.0:
                low, high = share if share < low else low, share if share > high else high
        distances[i] = high - low if high >= low else 0.0


@kernel(keys="n", groups="n", least="out g", first="out g")
def put_first_least(keys: Floats, groups: Ints, least: Floats, first: Ints) -> None:
    """Write for each group the least of its keys below `least`, and the first row that has it."""
    for i in range(len(keys)):
        group = groups[i]
        if 0 <= group < len(least) and keys[i] < least[group]:
            least[group], first[group] = keys[i], i


# Rotated copies: bodies of a lattice that one motion carries as a whole
#
# Before the motion they are lowered as translated copies, in which few numbers differ. The motion then carries the
# anchors of curved surfaces, each once, and planes, each once; squares, rows and normals are those of the first body.
# In the world the bodies are translated copies as well, so they share what such bodies share.
#
# Which of their surfaces coincide follows from the surfaces before the motion, which are compared there without
# rounding.

_SAMPLES = 3
"""Bodies of a kind that are lowered by themselves for comparison."""


def instance_rows(
    bodies: InstanceList, kind: int, numbers: Ints, primitives: PrimitiveCache, mover: PointPlaneMover
) -> tuple[BodyPattern, FactoredRows] | None:
    """Lower the bodies of a kind: translated, or translated before the motion of the kind.

    None: lower them one by one.
    """
    motion = bodies.motion(kind)
    if motion.is_identity:
        return translated_rows(bodies, kind, numbers, primitives)
    translated = translated_rows(UnrotatedBodies(bodies), kind, numbers, primitives)
    if translated is None:
        return None
    part = lower_shape(bodies.shape(int(numbers[0])))
    if part.pattern.kinds.tolist() != translated[0].kinds.tolist() or part.paints:
        return None
    return _RotatedRows(bodies, kind, numbers, part, translated[0], translated[1], primitives, mover).rows()


@dataclass(frozen=True)
class UnrotatedBodies:
    """Instances before the motions of their kinds, as `translated_rows` needs them."""

    bodies: InstanceList

    @property
    def shifts(self) -> ShiftTable:
        """The shifts of the bodies."""
        return self.bodies.shifts

    @property
    def single_columns(self) -> dict[tuple[int, ...], Floats]:
        """The columns of bodies that were lowered by themselves before."""
        return self.bodies.single_columns

    def is_rigid(self, kind: int) -> bool:
        """`InstanceList.is_rigid`"""
        return self.bodies.is_rigid(kind)

    def coordinates(self, kind: int) -> Coordinates | None:
        """`InstanceList.coordinates`"""
        return self.bodies.coordinates(kind)

    def shape_at(self, kind: int, shift: Shift) -> Solid:
        """`InstanceList.shape_at` before the motion of the kind."""
        return self.bodies.unrotated_shape(kind, shift)

    def shape(self, number: int) -> Solid:
        """`InstanceList.shape` before the motion of the kind."""
        return self.shape_at(int(self.bodies.kinds[number]), self.shifts.of(number))


@dataclass
class _RotatedRows:
    """One run of `instance_rows` for a kind with a motion."""

    bodies: InstanceList
    kind: int
    numbers: Ints
    part: LoweredShape
    unrotated: BodyPattern
    translated: FactoredRows
    cache: PrimitiveCache
    mover: PointPlaneMover

    def rows(self) -> tuple[BodyPattern, FactoredRows] | None:
        """Build the rows, and verify some."""
        pattern, away = self.part.pattern, Offsets.among(self.bodies, self.numbers)
        moved = FactoredRows(np.array(self.part.row), away, boxes=(pattern.bounds_at, pattern.frame_at))
        for kind, column, sense in pattern.records:
            if not (self._plane(moved, column, sense) if kind == PLANE else self._curved(moved, kind, column)):
                return None
        ends = (pattern.uv_at, pattern.bounds_at, self.unrotated.uv_at), (
            pattern.frame_at, pattern.corners_at, self.unrotated.frame_at,
        )  # fmt: skip
        for begin, end, own in ends:
            for at in range(0, end - begin, MAP_SIZE):
                self._map(moved, begin + at, own + at)
        return (pattern, moved) if self._is_verified(moved) else None

    @property
    def motion(self) -> Motion:
        """The motion of the kind."""
        return self.bodies.motion(self.kind)

    def _curved(self, moved: FactoredRows, kind: int, column: int) -> bool:
        """Carry the anchors of a curved surface of all bodies; False where they were rounded before the motion.

        False also for a sphere whose carried center is rounded by more than `CENTER_TOLERANCE` of its radius.
        """
        form, size = self.translated.forms.get(column), SIZES[kind]
        if form is None:
            return False
        coordinates = [self.translated.distinct(column + axis) for axis in range(POINT_SIZE)]
        first, index = _distinct_points(coordinates)
        points = np.stack([values[which[first]] for values, which in coordinates], axis=1) + 0.0
        found = self.mover.points(self.motion, points)
        if kind == SPHERE and (
            np.abs(found[:, POINT_SIZE:]).max() > CENTER_TOLERANCE * moved.base[column + POINT_SIZE]
        ):
            return False
        moved.indexed_columns.append(IndexedColumns(column, column + POINT_SIZE, found[:, :POINT_SIZE], index))
        moved.indexed_columns.append(
            IndexedColumns(column + size, column + size + POINT_SIZE, found[:, POINT_SIZE:], index)
        )
        moved.names[column] = (self.motion, form), coordinates
        return True

    def _plane(self, moved: FactoredRows, column: int, sense: int) -> bool:
        """Carry a plane of all bodies: each distinct plane once, as that of the first body that has it."""
        leads, index = unique_with_inverse(self.translated.leads[column])
        records, which = self.translated.of(leads, column, sense + 1), index.astype(np.int32)
        rests = records[:, PLANE_SIZE:-1]
        if rests.any():
            found = np.array([self._single_columns(lead)[column : sense + 1] for lead in leads.tolist()])
        else:
            found = self.mover.planes(self.motion, records[:, :PLANE_SIZE])
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
        moved.indexed_columns.append(IndexedColumns(column, sense + 1, found, which))
        if column not in moved.names:
            moved.leads[column] = leads[index].astype(np.int32)
        return True

    def _map(self, moved: FactoredRows, at: int, own: int) -> None:
        """Carry a row of an affine map: the motion leaves its linear part equal for all.

        Its constant moves as before.
        """
        values, index = self.translated.maps(own)
        if len(values) > 1:
            first = self.translated.of(np.zeros(1, np.int64), own, own + MAP_SIZE)[0]
            rows = np.tile(moved.base[at : at + MAP_SIZE], (len(values), 1))
            rows[:, -1] += values[:, -1] - first[-1]
            moved.indexed_columns.append(IndexedColumns(at, at + MAP_SIZE, rows, index))

    def _single_columns(self, which: int) -> Floats:
        """Return the columns of one of the bodies without boxes, lowered by itself; edited lists find them, too."""
        number = int(self.numbers[which])
        x, y, z = self.bodies.shifts.index[:, number].tolist()
        # A negative kind: not the columns before the motion
        known, place = self.bodies.single_columns, (-1 - self.kind, x, y, z)
        if place not in known:
            known[place] = self.cache.numbers(self.bodies.shape(number))
        return known[place]

    def _is_verified(self, moved: FactoredRows) -> bool:
        """Return whether the rows reproduce some bodies that are lowered by themselves.

        Of planes only normal and sense are compared: another body's equal plane may stand for them.
        """
        pattern, count = self.part.pattern, len(moved)
        for which in {count - 1 - k * (count - 1) // _SAMPLES for k in range(_SAMPLES)}:
            some, expected = np.array([which]), self._single_columns(which)
            computed = np.concatenate(
                [moved.of(some, 0, pattern.bounds_at)[0], moved.of(some, pattern.frame_at, pattern.corners_at)[0]]
            )
            if computed.shape != expected.shape:
                return False
            for kind, column, sense in pattern.records:
                same: Any = computed[column : sense + 1].view(np.int64) == expected[column : sense + 1].view(np.int64)
                if not same[[0, 1, 2, -1] if kind == PLANE else slice(None)].all():
                    return False
            far = 1.0 + np.abs(expected) + np.abs(moved.offsets[some]).max()
            if not (np.abs(computed - expected)[pattern.uv_at :] <= SAME_SHIFT * far[pattern.uv_at :]).all():
                return False
        return True


def _distinct_points(coordinates: list[tuple[Floats, Ints]]) -> tuple[Any, Ints]:
    """Return (the first item at each distinct point, for each item the number of its point)."""
    code = np.zeros(len(coordinates[0][1]), np.int64)
    for values, which in coordinates:
        code = code * len(values) + which
    _, first, index = np.unique(code, return_index=True, return_inverse=True)
    return first, index.astype(np.int32)
