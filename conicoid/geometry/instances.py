"""`InstanceList`: a scene's bodies as kinds and translations, whose shapes and names are built on demand.

A body is the shape of its kind, carried by an exact shift and then by the motion of the kind, if it has one (a lattice
that is turned has). Along each axis there are few different shifts, in a lattice as many as it has rows, so numbers
that depend on one axis are computed for these only.
"""

from __future__ import annotations

import operator
from abc import ABC, abstractmethod
from collections import OrderedDict
from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, TypeAlias, overload

import numpy as np
import numpy.typing as npt

from .._util.arrays import BoxEnds, FloatArray
from .._util.records import dataclass
from .._util.validation import format_value
from .body import Body, bodies_table
from .shape import Solid
from .transform import IDENTITY_MOTION, Motion

Ints: TypeAlias = npt.NDArray[np.int32]
Shift: TypeAlias = tuple[Fraction, Fraction, Fraction]
Coordinates: TypeAlias = tuple[set[Fraction], set[Fraction], set[Fraction]]

_FEWEST_BOUNDS = 24
"""Of fewer bodies of a kind each has its bounds computed."""
_SHAPE_CACHE_SIZE = 4096
"""The number of shapes that stay in memory, with the results cached on them; more where a list has many kinds."""


def round_sums(values: Iterable[Fraction], number: Fraction) -> FloatArray:
    """Return each value plus a number, rounded once, as quotients of integers are."""
    p, q = number.as_integer_ratio()
    return np.array([(a * q + p * b) / (b * q) for a, b in map(Fraction.as_integer_ratio, values)], np.float64)


@dataclass(frozen=True)
class ShiftTable:
    """Shifts of many items: the different values along each axis, and the index of each item's value."""

    values: tuple[tuple[Fraction, ...], tuple[Fraction, ...], tuple[Fraction, ...]]
    index: Ints  # (3, n)

    def of(self, number: int) -> Shift:
        """Return the shift of one item."""
        x, y, z = (values[at] for values, at in zip(self.values, self.index[:, number].tolist(), strict=True))
        return x, y, z

    def offsets_from(self, number: int) -> FloatArray:
        """Return the offsets (n, 3) of all items from one of them, each rounded once."""
        base, offsets = self.of(number), np.empty((self.index.shape[1], 3))
        for axis, values in enumerate(self.values):
            offsets[:, axis] = round_sums(values, -base[axis])[self.index[axis]]
        return offsets

    def select(self, numbers: Any) -> ShiftTable:
        """Return the shifts of some of the items, and only their values: a kind of few bodies costs as few."""
        values, index = [], self.index.take(numbers, axis=1)
        for axis, row in enumerate(index):
            if len(row) < len(self.values[axis]):
                used, index[axis] = np.unique(row, return_inverse=True)
            else:
                has = np.bincount(row, minlength=len(self.values[axis])) > 0
                used, index[axis] = np.flatnonzero(has), (np.cumsum(has) - 1)[row]
            values.append(tuple(self.values[axis][k] for k in used.tolist()))
        return ShiftTable((values[0], values[1], values[2]), index)


class InstanceBlock(NamedTuple):
    """A run of bodies; those of equal forms are translated copies of each other, body by body."""

    first: int
    size: int
    form: int


class InstanceList(Sequence[Body], ABC):
    """An immutable list of bodies by number. Indexing builds the body."""

    def __init__(self, kinds: Ints, shifts: ShiftTable, materials: Sequence[Any]) -> None:
        self.kinds, self.shifts, self.materials = kinds, shifts, tuple(materials)
        self.looks = kinds
        """The index of each body's material: that of its kind, unless an edit changes it."""
        self.single_columns: dict[tuple[int, ...], FloatArray] = {}
        """(kind, indices of the shift) -> numbers of a body lowered by itself; edited lists share the cache."""
        self._firsts: dict[int, Solid] = {}
        self._shapes: OrderedDict[int, Solid] = OrderedDict()

    def _repr_html_(self) -> str:
        """Return the table that a notebook shows."""
        return bodies_table(self)

    @abstractmethod
    def shape_at(self, kind: int, shift: Shift) -> Solid:
        """Return the shape of a kind at a place: the kind's shape with every surface moved and then rounded."""

    def motion(self, kind: int) -> Motion:
        """Return the motion of a kind after the shift, which the shapes of `shape_at` have."""
        return IDENTITY_MOTION

    def unrotated_shape(self, kind: int, shift: Shift) -> Solid:
        """Return the shape of a kind at a place, before its motion."""
        return self.shape_at(kind, shift)

    @abstractmethod
    def name(self, number: int) -> str:
        """Return the name of a body. No two have the same."""

    @abstractmethod
    def number(self, name: str) -> int | None:
        """Return the number of the body with a name, None if there is none."""

    @abstractmethod
    def is_rigid(self, kind: int) -> bool:
        """Return True if all shapes of a kind have the same structure, however far rounding moves their surfaces."""

    def coordinates(self, kind: int) -> Coordinates | None:
        """Return the exact coordinates along each axis that a shift of a kind changes; None where they are not known.

        Each number in the shapes of the kind before its motion depends on no shift, or is one of these coordinates plus
        the shift along its axis, with either sign, rounded once.
        """
        return None

    def blocks(self) -> list[InstanceBlock]:
        """Return runs of bodies that are placed as a whole, such as the assemblies of a core; none for few bodies."""
        return []

    @property
    def solid(self) -> tuple[bool, ...]:
        """For each material, True if solids have it: all do, except for bodies that an edit adds."""
        return (True,) * len(self.materials)

    def shape(self, number: int) -> Solid:
        """Return the shape of a body.

        The shapes of the first body of each kind and of recent bodies are cached: they are the same object again.
        """
        kind = int(self.kinds[number])
        if number == self.members[kind][0]:
            if kind not in self._firsts:
                self._firsts[kind] = self.shape_at(kind, self.shifts.of(number))
            return self._firsts[kind]
        shape = self._shapes.get(number)
        if shape is None:
            shape = self._shapes[number] = self.shape_at(kind, self.shifts.of(number))
            # Bodies of rare kinds are lowered one by one, and their shapes are needed again to compare surfaces
            if len(self._shapes) > max(_SHAPE_CACHE_SIZE, _FEWEST_BOUNDS * len(self.members)):
                self._shapes.popitem(last=False)
        return shape

    @cached_property
    def members(self) -> list[Ints]:
        """For each kind the numbers of its bodies, ascending."""
        return group_by_kind(self.kinds)

    @property
    def bodies_by_material(self) -> list[Ints]:
        """For each material the numbers of its bodies, ascending."""
        return self.members

    @cached_property
    def distinct_materials(self) -> tuple[Any, ...]:
        """The different materials, in the order of the first body of each."""
        firsts = sorted((int(numbers[0]), look) for look, numbers in enumerate(self.bodies_by_material) if len(numbers))
        return tuple(dict.fromkeys(self.materials[look] for _, look in firsts))

    @cached_property
    def boxes(self) -> list[BoxEnds]:
        """For each kind with bodies, (low, high) around all of them."""
        return [self._box(numbers) for numbers in self.members if len(numbers)]

    def deciding_boxes(self, rows: FloatArray) -> list[BoxEnds]:
        """Return boxes that decide each end of the box around all bodies: `boxes` without those that others enclose.

        Of a kind with a single body the box takes its shape. It is computed only where its row reaches beyond the boxes
        before, or to infinity; for each end the farthest rows come first.

        Parameters
        ----------
        rows : array (bodies, 6)
            The low and high ends of a box that holds each body.
        """
        boxes = [self._box(numbers) for numbers in self.members if len(numbers) > 1]
        reach = np.max([np.full(6, -np.inf), *map(_outward_ends, boxes)], axis=0)
        singles = [numbers for numbers in self.members if len(numbers) == 1]
        outer = _row_reaches(rows[np.array(singles, np.int32).reshape(-1)])
        computed = np.logical_not(np.isfinite(outer).all(axis=1))
        boxes += [self._box(singles[k]) for k in np.flatnonzero(computed)]
        for end in range(6):
            for k in np.argsort(-outer[:, end], kind="stable"):
                if outer[k, end] <= reach[end]:
                    break
                if not computed[k]:
                    computed[k] = True
                    boxes.append(self._box(singles[k]))
                    reach = np.maximum(reach, _outward_ends(boxes[-1]))
        return boxes

    def _box(self, numbers: Ints) -> BoxEnds:
        """Return (low, high) around bodies of one kind."""
        low, high = self.shape(int(numbers[0])).bounds
        offsets = self.shifts.select(numbers).offsets_from(0)
        offsets = transform_offsets(offsets, self.motion(int(self.kinds[numbers[0]])))
        # More than the rounding error of offsets and sums
        slack = 2.0**-50 * (np.abs(offsets).max() + _finite_sizes(low) + _finite_sizes(high))
        return low + (offsets.min(axis=0) - slack), high + (offsets.max(axis=0) + slack)

    def put_bounds(self, shapes: Sequence[Solid]) -> None:
        """Give the shapes of all bodies their bounds, computed for one body of a kind at each place along an axis.

        The ends of a box along an axis depend on the shift along it. Where one of the computed bodies has other ends,
        the bounds of all bodies of the kind are left to be computed, each when it is needed.
        """
        for kind, numbers in enumerate(self.members):
            index = self.shifts.index[:, numbers]
            if len(numbers) < _FEWEST_BOUNDS or not self.motion(kind).is_identity or not self.is_rigid(kind):
                continue
            ends, known = np.empty((len(numbers), 2, 3)), {}
            for axis in range(3):
                _, first, which = np.unique(index[axis], return_index=True, return_inverse=True)
                known.update({k: np.array(shapes[numbers[k]].bounds) for k in first.tolist() if k not in known})
                ends[:, :, axis] = np.array([known[k][:, axis] for k in first.tolist()])[which]
            if all(np.array_equal(ends[k], own) for k, own in known.items()):
                for number, (low, high) in zip(numbers.tolist(), ends, strict=True):
                    vars(shapes[number])["_bounds"] = low, high

    def _body(self, number: int) -> Body:
        body = object.__new__(_LazyBody)
        body.__dict__.update(of=self, number=number, material=self.materials[self.looks[number]])
        return body

    def __len__(self) -> int:
        return len(self.kinds)

    @overload
    def __getitem__(self, index: int) -> Body: ...

    @overload
    def __getitem__(self, index: slice) -> tuple[Body, ...]: ...

    def __getitem__(self, index: Any) -> Any:
        if isinstance(index, slice):
            return tuple(self._body(number) for number in range(*index.indices(len(self))))
        number = operator.index(index)
        if not 0 <= number < len(self):
            raise IndexError(f"Scene: bodies[...] takes a number from 0 to {len(self) - 1}, got {number}")
        return self._body(number)

    def index(self, value: Any, start: int = 0, stop: int = 2**62) -> int:
        """Return the number of a body, or of the body with a name.

        Raise KeyError for an unknown name, ValueError for a body that is not in the list.
        """
        name = value if isinstance(value, str) else getattr(value, "name", None)
        number = self.number(name) if isinstance(name, str) else None
        if number is None or not (isinstance(value, str) or self[number] == value) or not start <= number < stop:
            if isinstance(value, str):
                raise KeyError(f"no body named {format_value(value)}")
            raise ValueError(f"Scene: bodies: {format_value(name or value)} is none of them")
        return number

    def __iter__(self) -> Iterator[Body]:
        return map(self._body, range(len(self)))

    def __eq__(self, other: object) -> bool:
        """Return True for equal bodies in the same order, also for a tuple of them."""
        if not isinstance(other, InstanceList | tuple):
            return NotImplemented
        return self is other or (len(self) == len(other) and all(a == b for a, b in zip(self, other, strict=True)))

    def __hash__(self) -> int:
        return hash(len(self))

    def __repr__(self) -> str:
        return f"<{len(self):,} bodies>"

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "single_columns": {}, "_firsts": {}, "_shapes": OrderedDict()}


def group_by_kind(kinds: Ints) -> list[Ints]:
    """Return for each kind the numbers of its items, ascending."""
    order = np.argsort(kinds, kind="stable").astype(np.int32)
    ends = np.cumsum(np.bincount(kinds))
    return np.split(order, ends[:-1]) if len(ends) else []


def transform_offsets(offsets: FloatArray, motion: Motion) -> FloatArray:
    """Return the offsets (n, 3) in the world of items with some `offsets` before a motion."""
    return offsets if motion.is_identity else offsets @ motion.matrix[:3, :3].T


def _outward_ends(box: BoxEnds) -> FloatArray:
    """Return how far a box reaches along -x, -y, -z, x, y, z; -inf for an empty one."""
    low, high = box
    return np.array([*-low, *high]) if (low <= high).all() else np.full(6, -np.inf)


def _row_reaches(rows: FloatArray) -> FloatArray:
    """Return how far boxes (n, 6) reach along -x, -y, -z, x, y, z, by more than rounding."""
    outer = rows * ([-1.0] * 3 + [1.0] * 3)
    slack = 2.0**-50 * _finite_sizes(outer)
    return outer + np.tile(slack[:, :3] + slack[:, 3:], 2)


def _finite_sizes(ends: FloatArray) -> FloatArray:
    """Return the absolute values of finite numbers, 0 for others."""
    return np.where(np.isfinite(ends), np.abs(ends), 0.0)


class _LazyBody(Body):
    """A body whose shape and name are built on first use."""

    # Set in each object, but no dataclass fields: repr and equality use the fields of `Body` alone
    of: ClassVar[InstanceList]
    number: ClassVar[int]

    if not TYPE_CHECKING:  # these stand in for the fields of `Body` until they are set

        @cached_property
        def shape(self) -> Solid:
            """Its shape."""
            return self.of.shape(self.number)

        @cached_property
        def name(self) -> str:
            """Its name."""
            return self.of.name(self.number)

    def __reduce__(self) -> Any:
        return Body, (self.shape, self.material, self.name)


def has_instances(bodies: Sequence[Body]) -> bool:
    """Return True if any of some bodies comes from an `InstanceList`."""
    return _LazyBody in set(map(type, bodies))


def instance_origin(body: Body) -> tuple[InstanceList, int] | None:
    """Return (the `InstanceList` that a body comes from, its number there), None for any other body."""
    # A copy that `dataclasses.replace` changed has no list
    return (body.of, body.number) if isinstance(body, _LazyBody) and "of" in vars(body) else None


# Users see a `Body`
_LazyBody.__name__ = _LazyBody.__qualname__ = "Body"
