"""Which surfaces are one where entries are exchanged for others with as many rows, so that all slots stay.

A slot is the number of a surface among those that bodies came with, bulk balls behind: what `Laid` calls a surface. For
each, `Laid.first` says whose record it takes, the lead of its class; `Laid.ids` is the number in the table of surfaces,
which is how many leads there are before that lead. So:

- a slot is a lead where it is its own first, and first[first] is first;
- ids[slot] is ids[first[slot]], and rises over the leads from 0 by 1: when a slot begins or ceases to lead the numbers
  of all behind it are others, though nothing else of them is;
- which slot leads a class is told by the records of its members alone (`surfaces`): so it is another only where a
  member comes or goes.

What an exchange does to a class is told by the slots of what is new, its fresh slots: those that leave it, those that
come to it, and both together where a body slides along a wall. Classes without any stay what they are, but for the
number. Of the others
 - the record has another reach, of all its uses (`limits`);
 - if the lead was or is a fresh slot the record itself is another, with its anchor and what rounding took from it: then
   all members that stay are weighed anew as well. They are called `bereft`.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..._util.arrays import unique_sorted
from ...kernels.tables import SPHERE, Ints, Longs, Signs
from ..body_collector import ExactBodySurfaces
from ..row_layout import PLANES, QUADRICS, SPHERES, SURFACES, RowLayout
from .neighbour_index import NeighbourPlaces, find_neighbours
from .scene_splice import SceneSplice
from .surface_merge import SurfaceMerge, input_senses


def _no_slots() -> Longs:
    return np.zeros(0, np.int64)


@dataclass(frozen=True)
class SurfaceClasses:
    """What `Laid` says of the surfaces of the new scene, and what is other than it was."""

    first: Ints | None
    senses: Signs | None
    ids: Ints | None
    count: int
    """How many surfaces the table has."""
    single: Longs | None = None
    """See `ExactTables.single`; None where it is as before."""
    onto: Ints | None = None
    """Of each surface of the old table its number, -1 for one that is gone, and -1 at the end; None: all the same."""
    changed: Longs = field(default_factory=_no_slots)
    """Surfaces of the table with other uses than before, or another record."""
    bereft: Longs = field(default_factory=_no_slots)
    """Slots that stay, the record of whose class is another."""
    follow: Longs = field(default_factory=_no_slots)
    """Of the slots that are fresh or bereft those that do not lead."""
    touched: Longs = field(default_factory=_no_slots)
    """Slots whose bodies, beside those that are new, have other numbers in their rows than before."""

    @property
    def renumbered(self) -> bool:
        """Do surfaces have other numbers than before?"""
        return self.onto is not None


def unchanged_classes(joined: SceneSplice) -> SurfaceClasses:
    """The classes of a scene in which no surface that stays is one with a new one, or with one that is gone.

    The new ones are one with each other where those were in whose place they come: see `exchangeable.apart`.
    """
    (old, new), count = joined.laid, len(joined.sides[0].tables.surface_kind)
    if old.senses is None:
        return SurfaceClasses(old.first, None, old.ids, count)
    senses = old.senses.copy()
    for source, rows, at in joined.pieces.on(SURFACES):
        if source == 1:
            senses[at] = (new.given if new.senses is None else new.senses)[rows]
    return SurfaceClasses(old.first, senses, old.ids, count)


def neighbour_slots(places: NeighbourPlaces, own: NeighbourPlaces, joined: SceneSplice) -> Longs:
    """The slots that stay of surfaces so close to a new one that they may be one with it."""
    curved, old, found = np.concatenate([own.spheres, own.quadrics]), joined.laid[0], []
    groups = (PLANES, own.planes), (SPHERES, curved), (QUADRICS, curved)
    columns = places.planes, places.spheres, places.quadrics
    for kind, ((axis, numbers), column, marks) in enumerate(zip(groups, columns, places.marks, strict=True)):
        rows = find_neighbours(column, marks, numbers)
        for source, _, at in joined.pieces.on(axis):
            if source == 1 and len(rows):
                rows = rows[(rows < at.start) | (rows >= at.stop)]
        if len(rows):
            of_kind = np.flatnonzero(old.kinds == kind)
            balls = rows >= len(of_kind)
            slots = np.empty(len(rows), np.int64)
            slots[~balls], slots[balls] = of_kind[rows[~balls]], rows[balls] - len(of_kind) + len(old.kinds)
            found.append(slots)
    return np.concatenate(found) if found else _no_slots()


def update_classes(joined: SceneSplice, exact: ExactBodySurfaces, near_ones: Longs) -> SurfaceClasses | None:
    """The classes of a scene in which entries are exchanged; near_ones: `near_slots`.

    None where it is as well worked out from the beginning: where the surfaces of bodies that stay become other kinds of
    surface, or are turned over.
    """
    return _ClassUpdate(joined, exact).regrouped(near_ones)


class _ClassUpdate:
    """One run of `regrouped`."""

    def __init__(self, joined: SceneSplice, exact: ExactBodySurfaces) -> None:
        self.joined, (self.old, self.new) = joined, joined.laid
        self.merging = SurfaceMerge(joined, exact)
        self.single, self.count = self.merging.single, self.merging.single + self.merging.balls
        self.is_fresh = np.zeros(self.count, bool)
        for source, _, at in joined.pieces.on(SURFACES):
            self.is_fresh[at] |= source == 1
        self.fresh = np.flatnonzero(self.is_fresh)

    def regrouped(self, near_ones: Longs) -> SurfaceClasses | None:
        """`regrouped`"""
        own = np.arange(self.count, dtype=np.int32)
        before = own if self.old.first is None else self.old.first
        before_senses = self._senses_before()
        first, senses = before.copy(), before_senses.copy()
        self._put_new(first, senses)
        orphans: Longs = np.flatnonzero(self.is_fresh[before] & ~self.is_fresh)
        first[orphans] = -1
        beside = first[near_ones]
        leads: Longs = unique_sorted(beside[beside >= 0]).astype(np.int64)
        if len(orphans) or len(leads):
            loose = unique_sorted(self.fresh, orphans)
            self.merging.merge(loose, leads, first, senses)
        other = first != before
        moved = np.flatnonzero(other)
        other[orphans] = True  # though the same slot lead them again
        bereft = np.flatnonzero(other & ~self.is_fresh)
        if not self._alike(before, first, before_senses, senses, bereft):
            return None
        left = before[self.fresh]
        left = left[~self.is_fresh[left]]
        some = unique_sorted(self.fresh, bereft, left)
        # The same slots lead as before, and nothing that stays has another of them
        if self.is_fresh[moved].all() and np.array_equal(before[moved] == moved, first[moved] == moved):
            single = onto = None
            ids, count = self.old.ids, self.count
            if ids is not None:
                ids, count = ids.copy(), int(ids.max(initial=-1)) + 1
                ids[moved] = ids[first[moved]]
        else:
            ids, count, onto = self._renumbered(own, first, np.concatenate([bereft, left]))
            single = np.flatnonzero(first[: self.single] == own[: self.single])
        changed = some if ids is None else unique_sorted(ids[some]).astype(np.int64)
        follow = unique_sorted(self.fresh, bereft)
        follow, touched = follow[first[follow] != follow], unique_sorted(some, first[some])
        told = count, single, onto, changed, bereft, follow, touched
        return (
            SurfaceClasses(None, None, None, *told)
            if count == self.count
            else SurfaceClasses(first, senses, ids, *told)
        )

    def _senses_before(self) -> Signs:
        if self.old.senses is not None:
            return self.old.senses
        return input_senses(self.old.given, self.count)

    def _put_new(self, first: Ints, senses: Signs) -> None:
        """The classes of what is new, for itself."""
        slots = self._slots_of_new()
        for source, rows, at in self.joined.pieces.on(SURFACES):
            if source == 1:
                first[at] = slots[rows] if self.new.first is None else slots[self.new.first[rows]]
                senses[at] = (self.new.given if self.new.senses is None else self.new.senses)[rows]

    def _slots_of_new(self) -> Ints:
        """Where each surface of what is new comes to."""
        slots = np.empty(len(self.new.kinds), np.int32)
        for source, rows, at in self.joined.pieces.on(SURFACES):
            if source == 1:
                slots[rows] = np.arange(at.start, at.stop, dtype=np.int32)
        return slots

    def _alike(self, before: Ints, first: Ints, before_senses: Signs, senses: Signs, bereft: Longs) -> bool:
        """Does each surface have a record of the kind, and with the sense, that it has in the tables it comes from?

        So cells that are balls, which are traced without their cell, stay that, and others do not become it. What is
        new may be turned over: no record of a ball ever is.
        """
        kinds = self.merging.kinds

        def kinds_of(leads: Any, of: Signs) -> Any:
            found = np.full(len(leads), SPHERE, np.int8)
            single = leads < len(of)
            found[single] = of[leads[single]]
            return found

        if not np.array_equal(kinds_of(first[bereft], kinds), kinds_of(before[bereft], self.old.kinds)):
            return False
        if not np.array_equal(before_senses[bereft], senses[bereft]):
            return False
        slots = self._slots_of_new()
        alone = self.new.kinds if self.new.first is None else self.new.kinds[self.new.first[: len(slots)]]
        return np.array_equal(alone, kinds_of(first[slots], kinds))

    def _renumbered(self, own: Ints, first: Ints, left: Longs) -> tuple[Ints, int, Ints]:
        """The number of each slot where others lead than before, how many lead, and `Regrouped.onto`.

        left: slots that stay of each class that fresh ones left.
        """
        number = np.cumsum(first == own, dtype=np.int32)
        number -= 1
        ids: Ints = number[first]
        before = own if self.old.ids is None else self.old.ids
        onto = np.full(int(before.max(initial=-1)) + 2, -1, np.int32)
        onto[before] = ids
        onto[before[self.fresh]] = -1
        onto[before[left]] = ids[left]
        return ids, int(number[-1]) + 1, onto


def slot_entries(laid: RowLayout, slots: Longs) -> Longs:
    """The entries whose bodies some slots belong to; bulk balls, which have no rows of their own, to none."""
    slots = slots[slots < len(laid.kinds)]
    bodies = np.searchsorted(laid.starts(SURFACES), slots, side="right") - 1
    return unique_sorted(np.searchsorted(laid.first_body, bodies, side="right") - 1)
