"""Patterns: the structure that bodies of one kind share, as arrays, so that thousands are laid out at once.

A body is its pattern (how its cells, gates, faces and sheets hang together) and a row of numbers: for each surface its
record, the remainders that rounding removed, and its sense; 4 numbers for each row of its uv maps; a box for each leaf
of its programs; its own box; the frame of its local points; the corners of its polygons, and their remainders. Rows
come as an array, as a `RowTable`, or, for translated copies, as `FactoredRows`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Iterator, Sequence
from dataclasses import field
from functools import cached_property
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from .._jit.decorators import kernel
from .._util.arrays import unique_with_inverse
from .._util.records import dataclass
from ..geometry.instances import InstanceList, Ints as InstancesInts, ShiftTable, round_sums, transform_offsets
from ..geometry.shape import Shape
from ..geometry.transform import Step
from ..kernels.tables import (
    MAP_SIZE,
    PLANE,
    PLANE_SIZE,
    QUADRIC,
    QUADRIC_SIZE,
    SPHERE,
    SPHERE_SIZE,
    Floats,
    Ints,
    Longs,
)
from .assembly import Assembly

SIZES = {PLANE: PLANE_SIZE, SPHERE: SPHERE_SIZE, QUADRIC: QUADRIC_SIZE}
BOX_NUMBERS, FRAME_NUMBERS = 6, 12


@dataclass(frozen=True, eq=False)
class BodyPattern:
    """The structure that bodies of one kind share. The columns of the lists are those of `Assembly`."""

    kind: int
    index: int
    angular: Ints
    maps: Ints  # (faces, 3) the rows of the uv map of each face; faces may share rows
    kinds: Ints
    cells: Ints  # (cells, 3)
    cell_planes: Ints
    planes: Ints  # (planes, 3)
    programs: Ints  # (programs, 2)
    leaves: Ints  # (leaves, 4)
    gates: Ints  # (gates, 4)
    sheets: Ints  # (sheets, 4)
    polygons: Ints  # (polygons, 2)
    corners: Ints  # (polygons,) count of each polygon's corners
    framed: bool = True
    """Has the body faces and a frame of its own? The balls of a bulk entry share one frame."""

    # Where the parts of a row begin
    records: list[tuple[int, int, int]] = field(init=False)  # kind, first column, column of the sense
    uv_at: int = field(init=False)
    bounds_at: int = field(init=False)
    box_at: int = field(init=False)
    frame_at: int = field(init=False)
    corners_at: int = field(init=False)
    width: int = field(init=False)

    def __post_init__(self) -> None:
        at, records = 0, []
        for kind in self.kinds.tolist():
            records.append((kind, at, at + 2 * SIZES[kind]))
            at += 2 * SIZES[kind] + 1
        columns: dict[str, Any] = dict(records=records, uv_at=at)
        columns["bounds_at"] = at = at + MAP_SIZE * self.map_rows
        columns["box_at"] = at = at + BOX_NUMBERS * len(self.leaves)
        columns["frame_at"] = at = at + BOX_NUMBERS
        columns["corners_at"] = at = at + FRAME_NUMBERS * self.framed
        columns["width"] = at + 6 * int(self.corners.sum())
        for name, value in columns.items():
            object.__setattr__(self, name, value)

    @classmethod
    def of(
        cls,
        assembly: Assembly,
        kind: int,
        index: int,
        angular: Sequence[bool],
        maps: Sequence[tuple[int, int, int]],
        framed: bool = True,
    ) -> BodyPattern:
        """Build the pattern of an assembled body.

        `kind` and `index` name its entry in the tree; `angular` and `maps` have an item for each face.
        """
        return cls(
            kind,
            index,
            np.array(angular, np.int32),
            _table(maps, 3),
            np.array([record.kind for record in assembly.surfaces], np.int32),
            _table(assembly.cells, 3),
            np.array(assembly.cell_planes, np.int32),
            _table(assembly.planes, 3),
            _table(assembly.programs, 2),
            _table(assembly.leaves, 4),
            _table(assembly.gates, 4),
            _table(assembly.sheets, 4),
            _table(assembly.polygons, 2),
            np.array([len(outline) for outline in assembly.outlines], np.int32),
            framed,
        )

    def __eq__(self, other: object) -> bool:
        return isinstance(other, BodyPattern) and self.key == other.key

    def __hash__(self) -> int:
        return hash(self.key)

    @property
    def map_rows(self) -> int:
        """How many rows the uv maps of its faces have."""
        return int(self.maps.max(initial=-1)) + 1

    @cached_property
    def key(self) -> tuple[Any, ...]:
        """A key that is equal for equal patterns."""
        arrays = (
            self.angular, self.maps, self.kinds, self.cells, self.cell_planes, self.planes, self.programs, self.leaves,
            self.gates, self.sheets, self.polygons, self.corners,
        )  # fmt: skip
        return self.kind, self.index, self.framed, *((len(array), array.tobytes()) for array in arrays)


def _table(rows: Sequence[tuple[int, ...]], width: int) -> Ints:
    return np.array(rows, np.int32).reshape(-1, width)


PlacedPrimitive: TypeAlias = tuple[Shape, tuple[Step, ...]]
"""A primitive and the steps that move it."""


@dataclass
class BodyGroup:
    """Bodies of one pattern: their numbers in the scene, rising, and their rows."""

    pattern: BodyPattern
    bodies: Ints
    rows: Floats | FactoredRows | RowTable
    ball_frame: int = 0
    """-1 - k for balls that share frame k; 0 for bodies with faces."""
    leaves: list[PlacedPrimitive] = field(default_factory=list)
    """The primitives of each body, body by body; none where nobody lists them."""
    slots: Sequence[tuple[int, int]] = ()
    """For each surface of a body the number of its leaf, and its number there."""
    list_leaves: Callable[[Longs], list[PlacedPrimitive]] = lambda _: []
    """Lists the primitives of some of the bodies, by their positions, where `leaves` does not."""


class Primitives(NamedTuple):
    """Different primitives, and for each surface of a scene its primitive, -1 for an unknown one, and number there."""

    leaves: list[PlacedPrimitive]
    leaf: Ints
    number: Ints


# Rows of bodies that were lowered one by one or in batches
#
# Most numbers of a row stand in it several times, or are equal in every row: of the 180 numbers of a box, 34 differ.

# So many bodies at a time stay in the cache.
_AT_ONCE = 1 << 13


@dataclass(frozen=True)
class RowTable:
    """Rows as tables of distinct numbers (one row for each body), and for each column its place in them.

    `rows[:, a:b]`, `rows[:, a]`, `rows[which, a:b]` and `rows[:, columns]` are arrays;
    `rows[which]` is a `RowTable` of some bodies.
    """

    tables: tuple[Floats, ...]  # (bodies, any width) each
    table: Ints  # (columns,)
    column: Ints  # (columns,)

    @classmethod
    def of(cls, values: Floats, columns: Ints) -> RowTable:
        """Build rows whose columns are these columns of one table."""
        return cls((values,), np.zeros(len(columns), np.int32), columns)

    @classmethod
    def joined(cls, parts: Sequence[tuple[RowTable, int, int]]) -> RowTable:
        """Concatenate rows side by side: from each part its columns first to last."""
        first: dict[int, int] = {}
        tables: list[Floats] = []
        for rows, _, _ in parts:
            if id(rows) not in first:
                first[id(rows)] = len(tables)
                tables += rows.tables
        table = [rows.table[a:b] + np.int32(first[id(rows)]) for rows, a, b in parts]
        return cls(tuple(tables), np.concatenate(table), np.concatenate([rows.column[a:b] for rows, a, b in parts]))

    def __len__(self) -> int:
        return len(self.tables[0])

    def __getitem__(self, where: Any) -> Any:
        if not isinstance(where, tuple):
            return RowTable(tuple(table[where] for table in self.tables), self.table, self.column)
        some, columns = where
        if not isinstance(columns, (slice, np.ndarray)):
            return self.tables[self.table[columns]][some, self.column[columns]]
        table, column = self.table[columns], self.column[columns]
        ends = [len(table)]
        if len(self.tables) > 1:
            ends = [*(np.flatnonzero(table[1:] != table[:-1]) + 1).tolist(), len(table)]
        if len(ends) == 1 and ends[0] > 0:
            return _take_columns(self.tables[table[0]], some, column)
        found, begin = np.empty((len(self.tables[0][some]), len(column))), 0
        for end in ends if len(table) else ():
            found[:, begin:end] = _take_columns(self.tables[table[begin]], some, column[begin:end])
            begin = end
        return found


def _take_columns(table: Floats, some: Any, columns: Ints) -> Floats:
    """Take some columns of some rows; columns that follow each other are a slice."""
    first, count = int(columns[0]), len(columns)
    if int(columns[-1]) == first + count - 1 and (columns[1:] > columns[:-1]).all():
        return table[some, first : first + count]
    return table[some].take(columns, axis=1)


def row_blocks(count: int, width: int = 8) -> Iterator[slice]:
    """Yield blocks of bodies, so small that intermediate arrays with `width` numbers a body stay in the cache."""
    step = max(1, 8 * _AT_ONCE // max(8, width))
    for begin in range(0, count, step):
        yield slice(begin, min(count, begin + step))


# Offsets of translated copies from the first


@dataclass(frozen=True)
class Offsets:
    """The distinct distances along each axis, rounded once, and which of them each body has.

    `offsets[which]`: (n, 3).
    """

    values: tuple[Floats, Floats, Floats]
    index: Ints  # (3, bodies)

    @classmethod
    def of(cls, shifts: ShiftTable) -> Offsets:
        """Compute the offsets of bodies with these shifts; there is at least one."""
        base, index = shifts.of(0), np.empty_like(shifts.index)
        values = []
        for axis, known in enumerate(shifts.values):
            used = np.bincount(shifts.index[axis], minlength=len(known)) > 0
            index[axis] = (np.cumsum(used, dtype=np.int32) - np.int32(1))[shifts.index[axis]]
            values.append(round_sums((known[k] for k in np.flatnonzero(used).tolist()), -base[axis]))
        return cls((values[0], values[1], values[2]), index)

    @classmethod
    def among(cls, bodies: InstanceList, numbers: Ints) -> Offsets:
        """Compute the offsets of some bodies of one kind, after the motion of the kind."""
        found, motion = cls.of(bodies.shifts.select(numbers)), bodies.motion(int(bodies.kinds[numbers[0]]))
        if motion.is_identity:
            return found
        columns = [unique_with_inverse(np.ascontiguousarray(c)) for c in transform_offsets(found[:], motion).T]
        x, y, z = (values for values, _ in columns)
        return cls((x, y, z), np.array([index for _, index in columns], np.int32))

    def __len__(self) -> int:
        return self.index.shape[1]

    def __getitem__(self, which: Any) -> Floats:
        return np.stack([values[index[which]] for values, index in zip(self.values, self.index, strict=True)], axis=-1)

    @property
    def most(self) -> float:
        """The largest distance along any axis."""
        return max(float(np.abs(values).max()) for values in self.values)


# Rows of translated copies, computed on demand: along each axis few numbers differ

_WIDER = 2.0**-20
"""Boxes are widened by this share of their size and of their offset (geometric mean).

Their ends are roots of quadratic equations in numbers that the shift rounds, so their error is of the order of the
square root of that rounding.
"""


@dataclass(frozen=True)
class IndexedColumns:
    """Columns of rows that depend on one thing: a table of its values, and which value each body has."""

    first: int
    last: int
    values: Floats  # (distinct, last - first)
    index: InstancesInts  # (bodies,)


ColumnNames: TypeAlias = tuple[Hashable, list[tuple[Floats, InstancesInts]]]
"""A form; for each axis the distinct coordinates, and which of them each body has."""


@dataclass
class FactoredRows:
    """The rows of translated copies, computed for the columns that are read: `rows[:, a:b]` and `rows[:, a]`."""

    base: Floats
    offsets: Offsets  # of the bodies from the first
    indexed_columns: list[IndexedColumns] = field(default_factory=list)
    slanted: list[int] = field(default_factory=list)
    """First columns of affine map rows (four numbers) that depend on several axes."""
    boxes: tuple[int, int] = (0, 0)
    """First and last column of the boxes."""
    leads: dict[int, InstancesInts] = field(default_factory=dict)
    """First column of a plane -> for each body the one whose record stands for all bodies with the same plane."""
    forms: dict[int, Hashable] = field(default_factory=dict)
    """First column of a curved surface with an exact anchor -> a key of the surface apart from its anchor."""
    names: dict[int, ColumnNames] = field(default_factory=dict)
    """First column of another surface -> a name that is equal for equal surfaces."""

    def __len__(self) -> int:
        return len(self.offsets)

    def __getitem__(self, where: tuple[slice, Any]) -> Floats:
        every, columns = where
        if not isinstance(columns, slice):
            return self[every, columns : columns + 1][:, 0]
        return self.of(every, columns.start, columns.stop)

    def of(self, bodies: Any, first: int, last: int) -> Floats:
        """Compute some columns of some bodies: a slice, or their numbers."""
        rows = np.empty((len(self.offsets.index[0, bodies]), last - first))
        rows[:] = self.base[first:last]
        for each in self.indexed_columns:
            a, b = max(first, each.first), min(last, each.last)
            if a < b:
                values = each.values[:, a - each.first : b - each.first]
                rows[:, a - first : b - first] = values.take(each.index[bodies], axis=0)
        for at in self.slanted:
            if first <= at + 3 < last:
                # The constant of an affine map after a shift: its linear part times the offset is subtracted.
                rows[:, at + 3 - first] -= (self.base[at : at + 3] * self.offsets[bodies]).sum(axis=1)
        for at in range(*self.boxes, BOX_NUMBERS):
            a, b = max(first, at), min(last, at + BOX_NUMBERS)
            if a < b:
                rows[:, a - first : b - first] = shift_boxes(self.base[at : at + BOX_NUMBERS], self.offsets[bodies])[
                    :, a - at : b - at
                ]
        return rows

    def distinct(self, column: int) -> tuple[Floats, InstancesInts]:
        """For a column that depends on at most one thing, return (its distinct values, which of them each body has)."""
        for each in self.indexed_columns:
            if each.first <= column < each.last:
                return each.values[:, column - each.first], each.index
        return self.base[column : column + 1], np.zeros(len(self), np.int32)

    def name(self, column: int) -> ColumnNames | None:
        """Return the name of the surfaces at a column: equal form and coordinates mean equal surfaces.

        None without a form.
        """
        form = self.forms.get(column)
        if form is None:
            return self.names.get(column)
        return form, [self.distinct(column + axis) for axis in range(3)]

    def maps(self, at: int) -> tuple[Floats, InstancesInts]:
        """For the affine map row at a column, return (the distinct rows (n, 4), which of them each body has)."""
        for each in self.indexed_columns:
            if (each.first, each.last) == (at, at + 4) and (each.values != each.values[0]).any():
                return each.values, each.index
        if at in self.slanted:
            return self[:, at : at + 4], np.arange(len(self), dtype=np.int32)
        return self.base[None, at : at + 4], np.zeros(len(self), np.int32)

    def around_all(self, at: int, count: int) -> Floats:
        """Return `count` boxes of the first body, widened so that each holds the boxes of all bodies shifted back."""
        boxes, far = self.base[at : at + BOX_NUMBERS * count].reshape(-1, BOX_NUMBERS).copy(), self.offsets.most
        for box in boxes:
            size, reach = _box_sizes(box)
            wider = _WIDER * np.sqrt(size * (reach + far))
            box[:3] -= wider
            box[3:] += wider
        return boxes


def shift_boxes(box: Floats, offsets: Floats) -> Floats:
    """Shift a box (6,) low and high by each of (n, 3), and widen it."""
    every, found = np.arange(len(offsets), dtype=np.int32), np.empty((len(offsets), BOX_NUMBERS))
    x, y, z = np.ascontiguousarray(offsets.T)
    put_shifted_boxes(box, every, Offsets((x, y, z), np.stack([every] * 3)), found)
    return found


def put_shifted_boxes(box: Floats, bodies: Ints, offsets: Offsets, boxes: Floats) -> None:
    """Write `shift_boxes` to the rows of some bodies."""
    (size, far), (x, y, z), along = _box_sizes(box), offsets.index, offsets.values
    put_boxes(np.ascontiguousarray(box), float(size), float(far), bodies, x, y, z, *along, boxes)


@kernel(box="6", bodies="n", x="n", y="n", z="n", along_x="a", along_y="b", along_z="c", boxes="out m 6")
def put_boxes(
    box: Floats, size: float, far: float, bodies: Ints, x: Ints, y: Ints, z: Ints, along_x: Floats, along_y: Floats,
    along_z: Floats, boxes: Floats,
) -> None:  # fmt: skip
    """Write a box, shifted along the axes and widened, to the rows of some bodies.

    x, y, z: which of the shifts along each axis each body has. size, far: `_box_sizes`.
    """
    for i in range(len(bodies)):
        row = bodies[i]
        known = 0 <= x[i] < len(along_x) and 0 <= y[i] < len(along_y) and 0 <= z[i] < len(along_z)
        if not (known and 0 <= row < len(boxes)):
            continue
        p, q, r = along_x[x[i]], along_y[y[i]], along_z[z[i]]
        wider = _WIDER * math.sqrt(size * (far + max(abs(p), abs(q), abs(r))))
        boxes[row, 0], boxes[row, 1], boxes[row, 2] = box[0] + (p - wider), box[1] + (q - wider), box[2] + (r - wider)
        boxes[row, 3], boxes[row, 4], boxes[row, 5] = box[3] + (p + wider), box[4] + (q + wider), box[5] + (r + wider)


def _box_sizes(box: Floats) -> tuple[Any, Any]:
    """Return the size of a box, and that with the distance of its farthest end from the origin."""
    ends = np.where(np.isfinite(box), box, 0.0)
    size = np.abs(ends[3:] - ends[:3]).max()
    return size, size + np.abs(ends).max()


# Groups of a scene, and the places of their rows in the tables


@dataclass
class BulkBalls:
    """Bulk balls: consecutive body numbers, (n, 4) centers and radii, boxes (n, 6), and -1 - k for their frame k."""

    bodies: Ints
    spheres: Floats
    boxes: Floats
    frame: int

    def part(self, begin: int, end: int) -> slice:
        """Return the numbers of balls begin..end as a slice, which is faster to write by than numbers."""
        first = int(self.bodies[0]) if len(self.bodies) else 0
        return slice(first + begin, first + end)


@dataclass
class BodyGroups:
    """The lowered bodies of a scene: groups of one pattern each, bulk balls, and the frames of balls."""

    body_count: int
    groups: list[BodyGroup] = field(default_factory=list)
    balls: list[BulkBalls] = field(default_factory=list)
    ball_frames: list[Floats] = field(default_factory=list)

    @cached_property
    def group_numbers(self) -> Ints:
        """(bodies,) the number of the group of each body, once all groups are known; -1 for bulk balls."""
        numbers = np.full(self.body_count, -1, np.int32)
        for number, group in enumerate(self.groups):
            numbers[group.bodies] = number
        return numbers


@kernel(first="n", shifts="m", numbers="k", values="out v")
def put_numbers(first: Ints, shifts: Ints, numbers: Ints, values: Ints) -> None:
    """Write some numbers for each body, from its first row on; those >= 0 count from its shift, or the only shift."""
    if len(shifts) != 1 and len(shifts) < len(first):
        return
    for i in range(len(first)):
        shift = shifts[i] if len(shifts) > 1 else shifts[0]
        for k in range(len(numbers)):
            if 0 <= first[i] + k < len(values):
                values[first[i] + k] = numbers[k] + shift if numbers[k] >= 0 else numbers[k]


@kernel(groups="n", each="g", first="out n")
def place_rows(groups: Ints, each: Ints, first: Ints) -> int:
    """Write where the rows of each body begin; `each` says how many a body of each group has. Return their number."""
    count = 0
    for i in range(len(groups)):
        first[i] = count
        if 0 <= groups[i] < len(each):
            count += each[groups[i]]
    return count


@dataclass
class RowPlaces:
    """Where the rows of each body begin in a column of the tables, and how many rows there are."""

    first: Ints
    count: int
    copies: dict[int, int] = field(default_factory=dict)
    """id of a group of translated copies that have one set of rows -> where it begins."""

    @classmethod
    def of(cls, contents: BodyGroups, each: Sequence[int]) -> RowPlaces:
        """Place the rows in body order; `each` says how many rows a body of each group has."""
        if not any(each):
            return cls(np.broadcast_to(np.int32(0), contents.body_count), 0)
        first = np.empty(contents.body_count, np.int32)
        return cls(first, place_rows(contents.group_numbers, np.array(each, np.int32), first))

    @classmethod
    def of_copies(cls, contents: BodyGroups, each: Sequence[int]) -> RowPlaces:
        """Place the rows where a group of translated copies (`FactoredRows`) has one set of rows, behind all others."""
        shares = [isinstance(group.rows, FactoredRows) for group in contents.groups]
        own = cls.of(contents, [0 if one else number for one, number in zip(shares, each, strict=True)])
        for group, one, number in zip(contents.groups, shares, each, strict=True):
            if one:
                own.copies[id(group)] = own.count
                own.count += number
        return own

    def of_group(self, group: BodyGroup) -> Ints:
        """Return where the rows of a group's bodies begin: one number for copies that share them."""
        shared = self.copies.get(id(group))
        return self.first[group.bodies] if shared is None else np.array([shared], np.int32)

    def rows(self, group: BodyGroup, each: int) -> Ints:
        """Return the row numbers (bodies, each) of a group's bodies."""
        rows: Any = self.first[group.bodies][:, None] + np.arange(each, dtype=np.int32)
        return rows
