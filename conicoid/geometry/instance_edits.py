"""Edited instance lists: some bodies of another `InstanceList`, and bodies of their own among them.

The base list keeps its caches, so an edit costs one number for each body and the new bodies.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from .._util.arrays import unique_sorted
from .._util.records import dataclass
from .body import Body
from .bulk import Bulk
from .instances import (
    Coordinates,
    InstanceBlock,
    InstanceList,
    Ints,
    Shift,
    ShiftTable,
    group_by_kind,
    has_instances,
    instance_origin,
)
from .transform import IDENTITY_MOTION, Motion

MIN_INSTANCES = 24
"""With fewer bodies from a base list, a plain tuple is as good."""
MAX_EXPANDED_BODIES = 50_000
"""Longer lists are not expanded to single bodies, at some milliseconds each, for an entry of many bodies."""
MOST_EXCHANGED = 64
"""More bodies at a time are prepared afresh with all others."""


@dataclass(frozen=True)
class InstanceOrigins:
    """The origin of each body of a list: a body of the base, or one of its own."""

    base: InstanceList
    numbers: Ints  # (bodies,) the number in the base; -1 - k: number k of its own
    own: tuple[Body, ...]
    relabelled_bodies: Mapping[int, Body]
    """Number in the base -> the body with the same shape and another name or material."""

    @classmethod
    def of(cls, bodies: InstanceList) -> InstanceOrigins:
        """Return the origins of the bodies of any `InstanceList`."""
        if isinstance(bodies, EditedInstances):
            return bodies.origins
        return cls(bodies, np.arange(len(bodies), dtype=np.int32), (), {})

    def shape(self, number: int) -> Any:
        """Return the shape of a number of `numbers`."""
        return self.base.shape(number) if number >= 0 else self.own[-1 - number].shape

    def with_body(self, entry: int, old: Body, new: Body) -> InstanceOrigins:
        """Return the origins with `new` in place of the body `old` at `entry`."""
        number = int(self.numbers[entry])
        if number < 0:
            own = list(self.own)
            own[-1 - number] = new
            return replace(self, own=tuple(own))
        if new.shape is not old.shape:
            numbers = self.numbers.copy()
            numbers[entry] = -1 - len(self.own)
            stay = {key: body for key, body in self.relabelled_bodies.items() if key != number}
            return InstanceOrigins(self.base, numbers, (*self.own, new), stay)
        labelled = {**self.relabelled_bodies, number: new}
        was = self.base[number]
        if (new.name, new.material) == (was.name, was.material):
            del labelled[number]
        return replace(self, relabelled_bodies=labelled)

    def with_more(self, place: int, bodies: Sequence[Body]) -> InstanceOrigins:
        """Return the origins with more bodies before a place in the list."""
        first = -1 - len(self.own)
        more = np.arange(first, first - len(bodies), -1, dtype=np.int32)
        numbers = np.concatenate([self.numbers[:place], more, self.numbers[place:]])
        return replace(self, numbers=numbers, own=(*self.own, *bodies))

    def without(self, entries: Iterable[int]) -> InstanceOrigins:
        """Return the origins without the bodies at some entries."""
        places = list(entries)
        removed, numbers = self.numbers[places], np.delete(self.numbers, places)
        labelled = {
            number: self.relabelled_bodies[number] for number in self.relabelled_bodies.keys() - set(removed.tolist())
        }
        stay = np.ones(len(self.own), bool)
        stay[-1 - removed[removed < 0]] = False
        # The bodies of its own that stay are numbered anew
        place = np.cumsum(stay, dtype=np.int32) - np.int32(1)
        mine = numbers < 0
        numbers[mine] = -1 - place[-1 - numbers[mine]]
        own = tuple(body for body, stays in zip(self.own, stay.tolist(), strict=True) if stays)
        return InstanceOrigins(self.base, numbers, own, labelled)

    def bodies(self) -> InstanceList | None:
        """Return the list, or None if an entry of its own holds many bodies: entries of the list have one number each.

        Raise ValueError if there is such an entry and expanding the list instead would take too long.
        """
        many = next((body.shape for body in self.own if isinstance(body.shape, Bulk)), None)
        if many is not None:
            imported = int((self.numbers >= 0).sum())
            if imported > MAX_EXPANDED_BODIES:
                kind = type(many).__name__
                raise ValueError(
                    f"Scene: a {kind} cannot come to {imported:,} bodies of an imported model, as they would "
                    f"all be written out for it, over {MAX_EXPANDED_BODIES:,}; add its bodies as single ones: "
                    f"scene.added([many.single(k) for k in range(len(many))]), many being the {kind}"
                )
            return None
        if not (self.own or self.relabelled_bodies) and np.array_equal(
            self.numbers, np.arange(len(self.base), dtype=np.int32)
        ):
            return self.base
        return EditedInstances(self)


class EditedInstances(InstanceList):
    """The bodies of an edited scene.

    Its kinds are those of the base, followed by one for each body of its own. Its looks are the same, followed by one
    for each body with another name or material.
    """

    def __init__(self, origins: InstanceOrigins) -> None:
        base = origins.base
        others = (body.material for body in (*origins.own, *origins.relabelled_bodies.values()))
        super().__init__(origins.numbers, base.shifts, [*base.materials, *others])
        # An edit of many bodies needs none of these: they are computed when somebody reads them
        del self.kinds, self.shifts, self.looks
        self.origins, self._first_own, self.single_columns = origins, len(base.materials), base.single_columns

    def __len__(self) -> int:
        return len(self.origins.numbers)

    if not TYPE_CHECKING:  # in place of attributes of an `InstanceList`

        @cached_property
        def kinds(self) -> Ints:
            """The kind of each body."""
            return self._of_bodies(self.origins.base.kinds)

        @cached_property
        def shifts(self) -> ShiftTable:
            """The shifts of the bodies; none for one of its own."""
            numbers, base = self.origins.numbers, self.origins.base.shifts
            index, of_base = np.zeros((3, len(numbers)), np.int32), numbers >= 0
            index[:, of_base] = base.index[:, numbers[of_base]]
            return ShiftTable(base.values, index)

        @cached_property
        def looks(self) -> Ints:
            """The index of each body's material."""
            origins, looks = self.origins, self.origins.base.looks
            if origins.relabelled_bodies:
                looks = looks.copy()
                looks[list(origins.relabelled_bodies)] = (
                    np.arange(len(origins.relabelled_bodies)) + self._first_own + len(origins.own)
                )
            return self._of_bodies(looks)

    def _of_bodies(self, of_base: Ints) -> Ints:
        """Return numbers of bodies from those of the base; bodies of its own are numbered behind its materials."""
        numbers = self.origins.numbers
        found, places = np.int32(self._first_own - 1) - numbers, numbers >= 0
        found[places] = of_base[numbers[places]]
        return found

    @cached_property
    def bodies_by_material(self) -> list[Ints]:
        """For each material the numbers of its bodies, ascending."""
        return group_by_kind(self.looks)

    def shape_at(self, kind: int, shift: Shift) -> Any:
        """Return the shape of a kind at a place; a body of its own has no shift."""
        if kind < self._first_own:
            return self.origins.base.shape_at(kind, shift)
        return self.origins.own[kind - self._first_own].shape

    def motion(self, kind: int) -> Motion:
        """Return the motion of a kind (`InstanceList.motion`)."""
        return self.origins.base.motion(kind) if kind < self._first_own else IDENTITY_MOTION

    def unrotated_shape(self, kind: int, shift: Shift) -> Any:
        """Return the shape of a kind before its motion (`InstanceList.unrotated_shape`)."""
        return self.origins.base.unrotated_shape(kind, shift) if kind < self._first_own else self.shape_at(kind, shift)

    def shape(self, number: int) -> Any:
        """Return the shape of a body, the same object as in the base."""
        return self.origins.shape(int(self.origins.numbers[number]))

    def name(self, number: int) -> Any:
        """Return the name of a body; None for one of its own without a name."""
        source = int(self.origins.numbers[number])
        if source < 0:
            return self.origins.own[-1 - source].name
        labelled = self.origins.relabelled_bodies.get(source)
        return self.origins.base.name(source) if labelled is None else labelled.name

    def number(self, name: str) -> int | None:
        """Return the number of the body with a name, None if there is none."""
        return next(self._numbers_of(name), None)

    def _numbers_of(self, name: str) -> Iterator[int]:
        """Yield the numbers of all bodies with a name."""
        for source in self._sources_of(name):
            yield from np.flatnonzero(self.origins.numbers == source).tolist()

    @cached_property
    def _sources(self) -> dict[str | None, list[int]]:
        """Name -> the origins of bodies of its own and of relabelled ones that have it."""
        sources: dict[str | None, list[int]] = {}
        own = ((-1 - k, body) for k, body in enumerate(self.origins.own))
        for source, body in (*own, *self.origins.relabelled_bodies.items()):
            sources.setdefault(body.name, []).append(source)
        return sources

    def _sources_of(self, name: str) -> list[int]:
        """Return all origins with a name, also of bodies that were removed."""
        known = self.origins.base.number(name)
        of_base = [] if known is None or known in self.origins.relabelled_bodies else [known]
        return [*self._sources.get(name, ()), *of_base]

    def repeated_name(self) -> tuple[str, int, int] | None:
        """Return a name that two bodies have and their numbers, None if all names differ."""
        # The names of the base differ, so one of the two has a new name or is a body of its own
        numbers = self.origins.numbers
        present = np.zeros(len(self.origins.base), bool)
        present[numbers[numbers >= 0]] = True
        for name in self._sources:
            if name is not None and sum(source < 0 or bool(present[source]) for source in self._sources_of(name)) > 1:
                first, second, *_ = sorted(self._numbers_of(name))
                return name, first, second
        return None

    def index(self, value: Any, start: int = 0, stop: int = 2**62) -> int:
        """Return the number of a body, as `InstanceList.index` does; the body may have no name."""
        if isinstance(value, Body) and value.name is None:
            sources = [source for source in self._sources.get(None, ()) if self._body_of(source) == value]
            places = np.flatnonzero(np.isin(self.origins.numbers, sources))
            places = places[(places >= start) & (places < stop)]
            if len(places):
                return int(places[0])
        return super().index(value, start, stop)

    def _body_of(self, source: int) -> Body:
        """Return the body of a number of `InstanceOrigins.numbers`."""
        if source < 0:
            return self.origins.own[-1 - source]
        return self.origins.relabelled_bodies.get(source) or self.origins.base[source]

    def is_rigid(self, kind: int) -> bool:
        """Return True if all shapes of a kind have the same structure."""
        return kind < self._first_own and self.origins.base.is_rigid(kind)

    def coordinates(self, kind: int) -> Coordinates | None:
        """Return the coordinates that shifts change (`InstanceList.coordinates`); None for a body of its own."""
        return self.origins.base.coordinates(kind) if kind < self._first_own else None

    def blocks(self) -> list[InstanceBlock]:
        """Return the blocks of the base (`InstanceList.blocks`); one that was edited is the only one of its form."""
        numbers = self.origins.numbers
        places = np.full(len(self.origins.base), -1, np.int32)
        of_base = np.flatnonzero(numbers >= 0)
        places[numbers[of_base]] = of_base
        found: list[InstanceBlock] = []
        for first, count, form in self.origins.base.blocks():
            own = places[first : first + count]
            # The place of a removed body is -1, which a block at 0 would continue
            if own[0] >= 0 and np.array_equal(own, np.arange(own[0], own[0] + count)):
                found.append(InstanceBlock(int(own[0]), count, form))
                continue
            own = own[own >= 0]
            if len(own) > 1 and np.ptp(own) < 2 * count:  # new bodies may stand between
                found.append(InstanceBlock(int(own.min()), int(np.ptp(own)) + 1, -1 - len(found)))
        # In another order, blocks may have come apart and into each other
        found.sort()
        ends = [block.first + block.size for block in found]
        return found if all(end <= block.first for end, block in zip(ends, found[1:], strict=False)) else []

    @cached_property
    def solid(self) -> tuple[bool, ...]:
        """For each material, True if solids have it."""
        own = (not body.shape.is_sheet for body in self.origins.own)
        return (*self.origins.base.solid, *own, *(True for _ in self.origins.relabelled_bodies))

    def has_shapes_of(self, other: Sequence[Body]) -> bool:
        """Return True if another list has the same shapes in the same places."""
        if not isinstance(other, InstanceList):
            return False
        mine, its = self.origins, InstanceOrigins.of(other)
        return (
            mine.base is its.base
            and np.array_equal(mine.numbers, its.numbers)
            and all(a.shape is b.shape for a, b in zip(mine.own, its.own, strict=True))
        )

    def _body(self, number: int) -> Body:
        return self._body_of(int(self.origins.numbers[number]))


def collect_instances(bodies: Sequence[Body]) -> InstanceList | None:
    """Return a list as an `EditedInstances` if at least half of it comes from one base, each body once; else None.

    So `co.Scene([body for body in scene.bodies if ...])` costs as much as `scene.without`.
    """
    if not has_instances(bodies):
        return None
    origins = [instance_origin(body) for body in bodies]
    counts: dict[int, tuple[int, InstanceList]] = {}
    for each in origins:
        if each is not None:
            counts[id(each[0])] = counts.get(id(each[0]), (0, None))[0] + 1, each[0]
    count, base = max(counts.values(), key=lambda each: each[0], default=(0, None))
    if base is None or count < MIN_INSTANCES or 2 * count < len(bodies):
        return None
    own: list[Body] = []
    numbers = np.empty(len(bodies), np.int32)
    for place, (body, each) in enumerate(zip(bodies, origins, strict=True)):
        if each is not None and each[0] is base:
            numbers[place] = each[1]
        else:
            own.append(body)
            numbers[place] = -len(own)
    sources = numbers[numbers >= 0]
    if len(unique_sorted(sources)) < len(sources):
        return None
    return InstanceOrigins(base, numbers, tuple(own), {}).bodies()


def have_same_shapes(old: Sequence[Body], new: Sequence[Body]) -> bool:
    """Return True if two lists, one of them an `EditedInstances`, have the same shapes in the same places."""
    if old is new:
        return True
    if isinstance(new, EditedInstances):
        return new.has_shapes_of(old)
    return isinstance(old, EditedInstances) and old.has_shapes_of(new)


def exchanged_entries(old: InstanceList, new: InstanceList) -> list[int] | None:
    """Return the entries in which two lists differ; None where these are too many, or lengths or base lists differ."""
    if len(old) != len(new):
        return None
    its, mine = InstanceOrigins.of(old), InstanceOrigins.of(new)
    if its.base is not mine.base:
        return None
    places = np.flatnonzero((its.numbers != mine.numbers) | (mine.numbers < 0))
    some = places[: len(its.own) + len(mine.own) + MOST_EXCHANGED].tolist()
    found = [k for k in some if its.shape(int(its.numbers[k])) is not mine.shape(int(mine.numbers[k]))]
    return found if len(places) == len(some) and 0 < len(found) <= MOST_EXCHANGED else None
