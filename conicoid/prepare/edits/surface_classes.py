"""Update the classes of equal surfaces when entries are exchanged for others with as many rows, so that all slots stay.

A slot is the number of a surface among those that bodies came with, bulk balls behind. For each slot `RowLayout.first`
names the slot whose record it takes, the lead of its class; `RowLayout.ids` is the number in the table of surfaces,
which is the count of leads before that lead. So:

- a slot is a lead where it is its own first, and first[first] is first;
- ids[slot] is ids[first[slot]], and rises over the leads from 0 by 1: when a slot becomes a lead, or ceases to be one,
  all numbers behind it change, though nothing else of them does;
- the lead of a class follows from the records of its members alone (`coincidence.py`): so it changes only where a
  member comes or goes.

The effect of an exchange on a class follows from its fresh slots, those of new entries: some leave it, some join it,
and both happen where a body slides along a wall. Classes without fresh slots stay what they are, but for the number. Of
the others

- the record has another reach, over all its uses (`error_limits.py`);
- if the lead was or is a fresh slot, the record itself is another, with its anchor and remainders: then all members
  that stay are weighed again as well. They are called `bereft`.
"""

from __future__ import annotations

from dataclasses import field
from typing import Any

import numpy as np

from ..._util.arrays import unique_sorted
from ..._util.records import dataclass
from ...kernels.tables import SPHERE, Ints, Longs, Signs
from ..body_collector import ExactBodySurfaces
from ..row_layout import PLANES, QUADRICS, SPHERES, SURFACES, RowLayout
from .neighbour_index import NeighbourPlaces, find_neighbours
from .scene_splice import SceneSplice
from .surface_merge import SurfaceMerge, with_ball_senses


def _no_slots() -> Longs:
    return np.zeros(0, np.int64)


@dataclass(frozen=True)
class SurfaceClasses:
    """The surface part of the new scene's `RowLayout`, and what differs from the scene before."""

    first: Ints | None
    senses: Signs | None
    ids: Ints | None
    count: int
    """How many surfaces the table has."""
    single: Longs | None = None
    """See `ExactTables.single`; None where it is as before."""
    onto: Ints | None = None
    """For each surface of the old table its new number, -1 for a removed one, and -1 at the end.

    None: all as before.
    """
    changed_surfaces: Longs = field(default_factory=_no_slots)
    """Surfaces of the table with other uses than before, or another record."""
    bereft: Longs = field(default_factory=_no_slots)
    """Slots that stay, in classes with another record."""
    follow: Longs = field(default_factory=_no_slots)
    """Fresh or bereft slots that are no leads."""
    renumbered_slots: Longs = field(default_factory=_no_slots)
    """Slots whose bodies, beside the new ones, have other numbers in their rows than before."""

    @property
    def renumbered(self) -> bool:
        """Do surfaces have other numbers than before?"""
        return self.onto is not None


def unchanged_classes(splice: SceneSplice) -> SurfaceClasses:
    """Return the classes where no surface that stays coincides with a new one, or did with a removed one.

    The new surfaces coincide with each other where those that they replace did: see `edit_state.keeps_classes`.
    """
    (old, new), count = splice.layouts, len(splice.sides[0].tables.surface_kind)
    if old.senses is None:
        return SurfaceClasses(old.first, None, old.ids, count)
    senses = old.senses.copy()
    for source, rows, at in splice.pieces.on(SURFACES):
        if source == 1:
            senses[at] = (new.input_senses if new.senses is None else new.senses)[rows]
    return SurfaceClasses(old.first, senses, old.ids, count)


def neighbour_slots(places: NeighbourPlaces, own: NeighbourPlaces, splice: SceneSplice) -> Longs:
    """Return the slots that stay, of surfaces so close to a new one that they may be equal to it."""
    curved, old, found = np.concatenate([own.spheres, own.quadrics]), splice.layouts[0], []
    groups = (PLANES, own.planes), (SPHERES, curved), (QUADRICS, curved)
    columns = places.planes, places.spheres, places.quadrics
    for kind, ((axis, numbers), column, marks) in enumerate(zip(groups, columns, places.marks, strict=True)):
        rows = find_neighbours(column, marks, numbers)
        for source, _, at in splice.pieces.on(axis):
            # Rows of the entries that are replaced are no neighbours.
            if source == 1 and len(rows):
                rows = rows[(rows < at.start) | (rows >= at.stop)]
        if len(rows):
            of_kind = np.flatnonzero(old.kinds == kind)
            balls = rows >= len(of_kind)
            slots = np.empty(len(rows), np.int64)
            slots[~balls], slots[balls] = of_kind[rows[~balls]], rows[balls] - len(of_kind) + len(old.kinds)
            found.append(slots)
    return np.concatenate(found) if found else _no_slots()


def update_classes(splice: SceneSplice, exact: ExactBodySurfaces, near_ones: Longs) -> SurfaceClasses | None:
    """Compute the classes of a scene in which entries are exchanged; `near_ones` come from `neighbour_slots`.

    None where a fresh preparation is as quick: where surfaces of bodies that stay change their kind, or are negated.
    """
    return _ClassUpdate(splice, exact).run(near_ones)


class _ClassUpdate:
    """One run of `update_classes`."""

    def __init__(self, splice: SceneSplice, exact: ExactBodySurfaces) -> None:
        self.splice, (self.old, self.new) = splice, splice.layouts
        self.merging = SurfaceMerge(splice, exact)
        self.single, self.count = self.merging.single, self.merging.single + self.merging.balls
        self.is_fresh = np.zeros(self.count, bool)
        for source, _, at in splice.pieces.on(SURFACES):
            self.is_fresh[at] |= source == 1
        self.fresh = np.flatnonzero(self.is_fresh)

    def run(self, near_ones: Longs) -> SurfaceClasses | None:
        """Run the update."""
        own = np.arange(self.count, dtype=np.int32)
        before = own if self.old.first is None else self.old.first
        before_senses = self._senses_before()
        first, senses = before.copy(), before_senses.copy()
        self._put_new(first, senses)
        # Orphans stay, but their lead is among the exchanged slots: their class is recomputed with the fresh ones.
        orphans: Longs = np.flatnonzero(self.is_fresh[before] & ~self.is_fresh)
        first[orphans] = -1
        beside = first[near_ones]
        leads: Longs = unique_sorted(beside[beside >= 0]).astype(np.int64)
        if len(orphans) or len(leads):
            loose = unique_sorted(self.fresh, orphans)
            self.merging.merge(loose, leads, first, senses)
        other = first != before
        moved = np.flatnonzero(other)
        other[orphans] = True  # even if the same slot leads them again
        bereft = np.flatnonzero(other & ~self.is_fresh)
        # Rows that stay are not rewritten, so their records must keep kind and sense.
        if not self._keeps_kinds(before, first, before_senses, senses, bereft):
            return None
        left = before[self.fresh]
        left = left[~self.is_fresh[left]]
        some = unique_sorted(self.fresh, bereft, left)
        # The same slots lead as before, and no slot that stays has another lead.
        if self.is_fresh[moved].all() and np.array_equal(before[moved] == moved, first[moved] == moved):
            single = onto = None
            ids, count = self.old.ids, self.count
            if ids is not None:
                ids, count = ids.copy(), int(ids.max(initial=-1)) + 1
                ids[moved] = ids[first[moved]]
        else:
            ids, count, onto = self._renumber(own, first, np.concatenate([bereft, left]))
            single = np.flatnonzero(first[: self.single] == own[: self.single])
        changed = some if ids is None else unique_sorted(ids[some]).astype(np.int64)
        follow = unique_sorted(self.fresh, bereft)
        follow, touched = follow[first[follow] != follow], unique_sorted(some, first[some])
        common_fields = count, single, onto, changed, bereft, follow, touched
        return (
            SurfaceClasses(None, None, None, *common_fields)
            if count == self.count
            else SurfaceClasses(first, senses, ids, *common_fields)
        )

    def _senses_before(self) -> Signs:
        if self.old.senses is not None:
            return self.old.senses
        return with_ball_senses(self.old.input_senses, self.count)

    def _put_new(self, first: Ints, senses: Signs) -> None:
        """Write the classes of the new entries by themselves."""
        slots = self._slots_of_new()
        for source, rows, at in self.splice.pieces.on(SURFACES):
            if source == 1:
                first[at] = slots[rows] if self.new.first is None else slots[self.new.first[rows]]
                senses[at] = (self.new.input_senses if self.new.senses is None else self.new.senses)[rows]

    def _slots_of_new(self) -> Ints:
        """Return the slot of each surface of the new entries."""
        slots = np.empty(len(self.new.kinds), np.int32)
        for source, rows, at in self.splice.pieces.on(SURFACES):
            if source == 1:
                slots[rows] = np.arange(at.start, at.stop, dtype=np.int32)
        return slots

    def _keeps_kinds(self, before: Ints, first: Ints, before_senses: Signs, senses: Signs, bereft: Longs) -> bool:
        """Return whether each surface keeps the kind and the sense of the record in the tables that it comes from.

        So cells that are balls, which are traced without their cell, stay balls, and others do not become balls. A new
        surface may be negated, but no record of a ball ever is.
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
        own_kinds = self.new.kinds if self.new.first is None else self.new.kinds[self.new.first[: len(slots)]]
        return np.array_equal(own_kinds, kinds_of(first[slots], kinds))

    def _renumber(self, own: Ints, first: Ints, left: Longs) -> tuple[Ints, int, Ints]:
        """Return (the number of each slot where the leads changed, the count of leads, `SurfaceClasses.onto`).

        `left` holds slots that stay, of each class that fresh slots left.
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


def slot_entries(layout: RowLayout, slots: Longs) -> Longs:
    """Return the entries of the bodies of some slots; bulk balls, which have no rows of their own, belong to none."""
    slots = slots[slots < len(layout.kinds)]
    bodies = np.searchsorted(layout.starts(SURFACES), slots, side="right") - 1
    return unique_sorted(np.searchsorted(layout.first_body, bodies, side="right") - 1)
