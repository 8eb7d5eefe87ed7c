"""Input surfaces: the surfaces of all bodies, grouped where equality is known without comparing records."""

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
from .coincidence import ExactSurfaces, SurfaceTable, names_at
from .pattern import SIZES, BodyGroup, FactoredRows, RowPlaces

_Anchors: TypeAlias = list[tuple[Floats, Ints]]
"""For each axis the distinct coordinates of anchors, and which of them each anchor has."""


@dataclass
class InputSurfaces:
    """The surfaces of all bodies in input order; each has a lead, a surface that it certainly equals."""

    kinds: Signs
    lead: Ints
    leads: Ints  # the surfaces that are their own lead, rising
    is_lead: npt.NDArray[np.bool_]
    rank: Ints  # of a lead, its number among the leads
    row: Ints  # of a lead, its number among the leads of its kind
    turned: Signs | None  # -1 where its record is its lead's negated; None where no record is

    @classmethod
    def of(cls, groups: Sequence[BodyGroup], places: RowPlaces) -> InputSurfaces:
        """Collect the surfaces of the bodies of all groups."""
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
        """Count the leads of a kind."""
        return int((self.kinds[self.leads] == kind).sum())

    def places_of(
        self, groups: Sequence[BodyGroup], places: RowPlaces
    ) -> Iterator[tuple[BodyGroup, int, Ints, Ints | None]]:
        """Yield (group, which surface, its leads, their bodies) for each surface of groups of translated copies.

        The bodies are None for all. In other groups every surface is a lead, and has a form of its own.
        """
        for group in groups:
            if not isinstance(group.rows, FactoredRows):
                continue
            first = places.first[group.bodies]
            for number in range(len(group.pattern.kinds)):
                mine = first + number
                lead = self.is_lead[mine]
                which = None if lead.all() else np.flatnonzero(lead).astype(np.int32)
                yield group, number, mine if which is None else mine[which], which

    def rows_of_forms(self, groups: Sequence[BodyGroup], places: RowPlaces) -> tuple[Ints, int]:
        """Return (for each quadric the row of its form and of its remainders, how many have rows of their own).

        Own rows come first, in order; then one for each form that a whole group shares.
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

    def expand(self, surfaces: SurfaceTable) -> SurfaceTable:
        """Expand a table of the leads to all input surfaces."""
        if len(self.leads) == len(self.lead):
            return surfaces
        rank, count = self.rank[self.lead], len(self.leads)
        ids = np.concatenate([surfaces.ids[:count][rank], surfaces.ids[count:]])
        own = surfaces.senses[:count][rank] if self.turned is None else surfaces.senses[:count][rank] * self.turned
        senses = np.concatenate([own, surfaces.senses[count:]])
        return dataclasses.replace(surfaces, ids=ids, senses=senses, single=self.leads[surfaces.single])


def _group_by_form(groups: Sequence[BodyGroup], places: RowPlaces) -> list[list[tuple[Ints, _Anchors, int]]]:
    """List (numbers, anchors, senses) of surfaces that are equal exactly where their anchors are."""
    by_form: dict[Hashable, list[tuple[Ints, _Anchors, int]]] = {}
    for group in groups:
        if isinstance(group.rows, FactoredRows):
            first = places.first[group.bodies]
            for number, (_, column, sense) in enumerate(group.pattern.records):
                named = group.rows.name(column)
                if named is not None:
                    form, anchors = named
                    by_form.setdefault(form, []).append((first + number, anchors, int(group.rows.base[sense])))
    return list(by_form.values())


def _number_anchors(parts: Sequence[_Anchors]) -> tuple[int, npt.NDArray[np.int64]]:
    """Number the anchors so that equal anchors have equal numbers; return (count of numbers, number of each anchor)."""
    total = sum(len(part[0][1]) for part in parts)
    count, number = 1, np.zeros(total, np.int64)
    for axis in range(3):
        columns = [part[axis] for part in parts]
        values, place = unique_with_inverse(np.concatenate([values for values, _ in columns]))
        ends = np.cumsum([len(values) for values, _ in columns])
        places = np.split(place, ends[:-1])
        index = np.concatenate([mine[which] for mine, (_, which) in zip(places, columns, strict=True)])
        count, number = count * len(values), number * len(values) + index
        # Compact the numbers so that the products above stay within int64.
        if count > 2 * total:
            values, number = unique_with_inverse(number)
            count = len(values)
    return count, number


def shares_form(group: BodyGroup, column: int) -> bool:
    """Return whether the surfaces at a column are equal but for their anchors, and no anchor was rounded."""
    return isinstance(group.rows, FactoredRows) and group.rows.forms.get(column) is not None


@dataclass
class LeadSurfaces:
    """Exact surfaces by their numbers among the leads."""

    exact: ExactSurfaces
    leads: Ints

    def __getitem__(self, index: int) -> Surface:
        return self.exact[int(self.leads[index])]

    def name(self, index: int) -> tuple[Key, int]:
        """Return the exact name of a surface, and its sense."""
        return self.exact.name(int(self.leads[index]))

    def known_names(self, indices: Longs) -> dict[int, Hashable]:
        """`ExactSurfaces.known_names`"""
        return names_at(self.exact.known_names, self.leads, indices)

    def leaf_names(self, indices: Longs) -> dict[int, Hashable]:
        """`ExactSurfaces.leaf_names`"""
        return names_at(self.exact.leaf_names, self.leads, indices)


def group_columns(group: BodyGroup, which: Ints | None, some: slice, first: int, last: int) -> Floats:
    """Return some columns of a block of bodies; `which` lists the bodies of the group to choose from, None: all."""
    if which is None:
        return group.rows[some, first:last]
    if isinstance(group.rows, FactoredRows):
        return group.rows.of(which[some], first, last)
    return group.rows[which[some], first:last]
