"""The bodies of a scene of which many are others moved: what they have in common is said once, and each made on demand.

A body is of a kind, and carried from where the kind is worked out by a shift that is known exactly, and then by the
motion of the kind, if it has one: that of a lattice that is turned. Along each axis there are few different shifts, in
a lattice as many as rows, so what depends on one axis is worked out for those.
"""

from __future__ import annotations

import operator
from abc import ABC, abstractmethod
from collections import OrderedDict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, TypeAlias, overload

import numpy as np
import numpy.typing as npt

from .._util.arrays import BoxEnds, FloatArray
from .._util.validation import format_value
from .body import Body
from .shape import Solid
from .transform import IDENTITY_MOTION, Motion

Ints: TypeAlias = npt.NDArray[np.int32]
Shift: TypeAlias = tuple[Fraction, Fraction, Fraction]

_SHAPE_CACHE_SIZE = 4096
"""Shapes that are kept, once they are made, since what is worked out of them is kept with them."""


@dataclass(frozen=True)
class ShiftTable:
    """Shifts of many things: along each axis the different ones, and which of these each has."""

    values: tuple[tuple[Fraction, ...], tuple[Fraction, ...], tuple[Fraction, ...]]
    index: Ints  # (3, n)

    def of(self, number: int) -> Shift:
        """The shift of one."""
        x, y, z = (values[at] for values, at in zip(self.values, self.index[:, number].tolist(), strict=True))
        return x, y, z

    def away(self, number: int) -> FloatArray:
        """(n, 3): how far all are from one, rounded once."""
        base, away = self.of(number), np.empty((self.index.shape[1], 3))
        for axis, values in enumerate(self.values):
            away[:, axis] = np.array([float(value - base[axis]) for value in values])[self.index[axis]]
        return away

    def chosen(self, numbers: Any) -> ShiftTable:
        """Those of some of the things."""
        return ShiftTable(self.values, self.index[:, numbers])


class InstanceList(Sequence[Body], ABC):
    """A list of bodies that cannot be changed, by their numbers; each is made anew whenever it is asked for."""

    def __init__(self, kinds: Ints, shifts: ShiftTable, materials: Sequence[Any]) -> None:
        self.kinds, self.shifts, self.materials = kinds, shifts, tuple(materials)
        self.looks = kinds
        """Which of the materials each body has: those of kinds, but for what an edit brings."""
        self.alone: dict[tuple[int, ...], FloatArray] = {}
        """Numbers of bodies that were worked out alone, by kind and places of the shift: edited lists have them too."""
        self._firsts: dict[int, Solid] = {}
        self._shapes: OrderedDict[int, Solid] = OrderedDict()

    @abstractmethod
    def made(self, kind: int, shift: Shift) -> Solid:
        """The shape of a kind at a place. It must be the kind's with every surface moved, and then rounded."""

    def motion(self, kind: int) -> Motion:
        """What carries a kind to the world after the shift; the shapes that `made` makes have it."""
        del kind
        return IDENTITY_MOTION

    def before(self, kind: int, shift: Shift) -> Solid:
        """The shape of a kind at a place, before its motion."""
        return self.made(kind, shift)

    @abstractmethod
    def name(self, number: int) -> str:
        """What a body is called; no two have one name."""

    @abstractmethod
    def number(self, name: str) -> int | None:
        """The body of a name."""

    @abstractmethod
    def is_rigid(self, kind: int) -> bool:
        """Do all shapes of a kind have the same structure, however far rounding moves their surfaces?"""

    @property
    def solid(self) -> tuple[bool, ...]:
        """Of each material: do solids have it? All do, but for what an edit brings."""
        return (True,) * len(self.materials)

    def shape(self, number: int) -> Solid:
        """The shape of a body; that of the first of a kind, or of one asked for lately, is the same object again."""
        kind = int(self.kinds[number])
        if number == self.members[kind][0]:
            if kind not in self._firsts:
                self._firsts[kind] = self.made(kind, self.shifts.of(number))
            return self._firsts[kind]
        found = self._shapes.get(number)
        if found is None:
            found = self._shapes[number] = self.made(kind, self.shifts.of(number))
            if len(self._shapes) > _SHAPE_CACHE_SIZE:
                self._shapes.popitem(last=False)
        return found

    @cached_property
    def members(self) -> list[Ints]:
        """The numbers of the bodies of each kind, rising."""
        return group_by_kind(self.kinds)

    @property
    def seen(self) -> list[Ints]:
        """The numbers of the bodies of each material, rising."""
        return self.members

    @cached_property
    def distinct_materials(self) -> tuple[Any, ...]:
        """The different materials, in the order of the first body of each."""
        firsts = sorted((int(numbers[0]), look) for look, numbers in enumerate(self.seen) if len(numbers))
        return tuple(dict.fromkeys(self.materials[look] for _, look in firsts))

    @cached_property
    def boxes(self) -> list[BoxEnds]:
        """(low, high) around all bodies of each kind."""
        found: list[BoxEnds] = []
        for numbers in self.members:
            if len(numbers):
                low, high = self.shape(int(numbers[0])).bounds
                away = transform_offsets(self.shifts.chosen(numbers).away(0), self.motion(int(self.kinds[numbers[0]])))
                slack = 2.0**-50 * (np.abs(away).max() + _finite_sizes(low) + _finite_sizes(high))
                found.append((low + (away.min(axis=0) - slack), high + (away.max(axis=0) + slack)))
        return found

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
            told = "-1 stands for a miss" if number == -1 else f"there are {len(self):,} bodies"
            raise IndexError(f"Scene: bodies[...] takes a number from 0 on, got {number}; {told}")
        return self._body(number)

    def index(self, value: Any, start: int = 0, stop: int = 2**62) -> int:
        """The number of a body, or of the one of a name; KeyError for a name, ValueError for a body that is none."""
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
        """Whether they are equal bodies in the same order, in whatever way they are listed."""
        if not isinstance(other, InstanceList | tuple):
            return NotImplemented
        return self is other or (len(self) == len(other) and all(a == b for a, b in zip(self, other, strict=True)))

    def __hash__(self) -> int:
        return hash(len(self))

    def __repr__(self) -> str:
        return f"<{len(self):,} bodies>"

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "alone": {}, "_firsts": {}, "_shapes": OrderedDict()}


def group_by_kind(kinds: Ints) -> list[Ints]:
    """The numbers of each kind, rising."""
    order = np.argsort(kinds, kind="stable").astype(np.int32)
    ends = np.cumsum(np.bincount(kinds))
    return np.split(order, ends[:-1]) if len(ends) else []


def transform_offsets(away: FloatArray, motion: Motion) -> FloatArray:
    """(n, 3) how far things are from one in the world that are so far before a motion."""
    return away if motion.is_identity else away @ motion.matrix[:3, :3].T


def _finite_sizes(ends: FloatArray) -> FloatArray:
    """The sizes of the finite ones of some numbers."""
    return np.where(np.isfinite(ends), np.abs(ends), 0.0)


class _LazyBody(Body):
    """A body whose shape and name are made when they are asked for."""

    of: ClassVar[InstanceList]  # set in each object; no fields, so that bodies are told and compared by those of Body
    number: ClassVar[int]

    if not TYPE_CHECKING:  # which stand in for fields until these are set

        @cached_property
        def shape(self) -> Solid:
            """Its shape."""
            return self.of.shape(self.number)

        @cached_property
        def name(self) -> str:
            """What it is called."""
            return self.of.name(self.number)

    def __reduce__(self) -> Any:
        return Body, (self.shape, self.material, self.name)


def has_instances(bodies: Sequence[Body]) -> bool:
    """Is any of some bodies one that is made when it is asked for?"""
    return _LazyBody in set(map(type, bodies))


def instance_origin(body: Body) -> tuple[InstanceList, int] | None:
    """(the list that a body comes from, its number there), if it is one that is made when it is asked for."""
    return (
        (body.of, body.number) if isinstance(body, _LazyBody) and "of" in vars(body) else None
    )  # not if it was changed


_LazyBody.__name__ = _LazyBody.__qualname__ = "Body"
