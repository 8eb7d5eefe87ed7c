"""The surfaces that bodies come with, and which of them are surely the same before any is compared."""

from __future__ import annotations

import dataclasses
from collections.abc import Hashable, Iterator, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from .._util.arrays import unique_with_inverse
from ..geometry.surface import Key, Surface
from ..kernels.tables import QUADRIC, Floats, Ints, Longs, Signs
from .coincidence import ExactSurfaces, SurfaceTable, exact_names_at
from .pattern import SIZES, BodyGroup, FactoredRows, RowPlaces

_Anchors: TypeAlias = list[tuple[Floats, Ints]]
"""Of each axis the different coordinates of anchors, and which of them each anchor has."""


@dataclass
class InputSurfaces:
    """The surfaces of all bodies as they came, and of each one that it is surely the same as: its lead."""

    kinds: Signs
    lead: Ints
    leads: Ints  # those that lead, rising
    is_lead: npt.NDArray[np.bool_]
    rank: Ints  # of one that leads, its number among these
    row: Ints  # its number among those of its kind
    turned: Signs | None  # -1 where its record is that of its lead turned over; None where none is

    @classmethod
    def of(cls, groups: Sequence[BodyGroup], places: RowPlaces) -> InputSurfaces:
        """Those of the bodies of all groups."""
        kinds, lead = np.empty(places.count, np.int8), np.arange(places.count, dtype=np.int32)
        for group in groups:
            at = places.rows(group, len(group.pattern.kinds))
            kinds[at] = group.pattern.kinds
            if isinstance(group.rows, FactoredRows):
                for number, (_, column, _) in enumerate(group.pattern.records):
                    if column in group.rows.leads:
                        lead[at[:, number]] = at[group.rows.leads[column], number]
        senses: Signs | None = None
        for same in _group_by_form(groups, places):
            numbers = np.concatenate([part for part, _, _ in same])
            count, place = _number_anchors([anchors for _, anchors, _ in same])
            least = np.full(count, places.count, np.int32)
            np.minimum.at(least, place, numbers)
            lead[numbers] = least[place]
            if len({sense for _, _, sense in same}) > 1:
                senses = np.ones(places.count, np.int8) if senses is None else senses
                for part, _, sense in same:
                    senses[part] = sense
        is_lead = lead == np.arange(places.count, dtype=np.int32)
        row = np.empty(places.count, np.int32)
        for kind in SIZES:
            own = is_lead & (kinds == kind)
            row[own] = np.arange(own.sum())
        rank = np.cumsum(is_lead, dtype=np.int32) - np.int32(1)
        turned = None if senses is None else senses * senses[lead]
        return cls(kinds, lead, np.flatnonzero(is_lead).astype(np.int32), is_lead, rank, row, turned)

    def count(self, kind: int) -> int:
        """How many of a kind lead."""
        return int((self.kinds[self.leads] == kind).sum())

    def places_of(
        self, groups: Sequence[BodyGroup], places: RowPlaces
    ) -> Iterator[tuple[BodyGroup, int, Ints, Ints | None]]:
        """Of each group each surface of its pattern: (group, which, those that lead, of which bodies; None: of all)."""
        for group in groups:
            first = places.first[group.bodies]
            for number in range(len(group.pattern.kinds)):
                mine = first + number
                lead = self.is_lead[mine]
                which = None if lead.all() else np.flatnonzero(lead).astype(np.int32)
                yield group, number, mine if which is None else mine[which], which

    def rows_of_forms(self, groups: Sequence[BodyGroup], places: RowPlaces) -> tuple[Ints, int]:
        """(of each quadric the row of its form and of what was rounded, how many have rows of their own).

        These come first, in order; then there is one for all of a group that have one form.
        """
        form = np.full(self.count(QUADRIC), -1, np.int32)
        count = 0
        for group, number, mine, _ in self.places_of(groups, places):
            kind, column, _ = group.pattern.records[number]
            if len(mine) and kind == QUADRIC and shares_form(group, column):
                form[self.row[mine]] = count
                count += 1
        own = form < 0
        rows = np.cumsum(own, dtype=np.int32) - np.int32(1)
        rows[~own] = form[~own] + np.int32(own.sum())
        return rows, int(own.sum())

    def all_of(self, surfaces: SurfaceTable) -> SurfaceTable:
        """What is known of those that lead, for all."""
        if len(self.leads) == len(self.lead):
            return surfaces
        rank, count = self.rank[self.lead], len(self.leads)
        ids = np.concatenate([surfaces.ids[:count][rank], surfaces.ids[count:]])
        own = surfaces.senses[:count][rank] if self.turned is None else surfaces.senses[:count][rank] * self.turned
        senses = np.concatenate([own, surfaces.senses[count:]])
        return dataclasses.replace(surfaces, ids=ids, senses=senses, single=self.leads[surfaces.single])


def _group_by_form(groups: Sequence[BodyGroup], places: RowPlaces) -> list[list[tuple[Ints, _Anchors, int]]]:
    """Numbers, anchors and senses of surfaces that are one if their anchors are."""
    found: dict[Hashable, list[tuple[Ints, _Anchors, int]]] = {}
    for group in groups:
        if isinstance(group.rows, FactoredRows):
            first = places.first[group.bodies]
            for number, (_, column, sense) in enumerate(group.pattern.records):
                named = group.rows.name(column)
                if named is not None:
                    form, anchors = named
                    found.setdefault(form, []).append((first + number, anchors, int(group.rows.base[sense])))
    return list(found.values())


def _number_anchors(parts: Sequence[_Anchors]) -> tuple[int, npt.NDArray[np.int64]]:
    """(how many numbers there are, one for each anchor), the same for anchors that are equal."""
    total = sum(len(part[0][1]) for part in parts)
    count, number = 1, np.zeros(total, np.int64)
    for axis in range(3):
        columns = [part[axis] for part in parts]
        values, place = unique_with_inverse(np.concatenate([values for values, _ in columns]))
        ends = np.cumsum([len(values) for values, _ in columns])
        places = np.split(place, ends[:-1])
        index = np.concatenate([mine[which] for mine, (_, which) in zip(places, columns, strict=True)])
        count, number = count * len(values), number * len(values) + index
        if count > 2 * total:
            values, number = unique_with_inverse(number)
            count = len(values)
    return count, number


def shares_form(group: BodyGroup, column: int) -> bool:
    """Are surfaces whose records begin at a column alike in all but their anchors, of which nothing was rounded?"""
    return isinstance(group.rows, FactoredRows) and group.rows.forms.get(column) is not None


@dataclass
class LeadSurfaces:
    """Exact surfaces by their numbers among those that lead."""

    exact: ExactSurfaces
    leads: Ints

    def __getitem__(self, index: int) -> Surface:
        return self.exact[int(self.leads[index])]

    def name(self, index: int) -> tuple[Key, int]:
        """The exact name of a surface, and its sense."""
        return self.exact.name(int(self.leads[index]))

    def said(self, indices: Longs) -> dict[int, Hashable]:
        """What is equal for surfaces that are surely one."""
        return exact_names_at(self.exact, self.leads, indices)


def group_columns(group: BodyGroup, which: Ints | None, some: slice, first: int, last: int) -> Floats:
    """Some columns of some of a group's bodies, which are a part of these; None: of all."""
    if which is None:
        return group.rows[some, first:last]
    if isinstance(group.rows, FactoredRows):
        return group.rows.of(which[some], first, last)
    return group.rows[which[some], first:last]
