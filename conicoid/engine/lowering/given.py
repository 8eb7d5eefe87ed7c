"""The surfaces that bodies come with, and which of them are surely the same before any is compared."""

from __future__ import annotations

import dataclasses
from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from ...shapes.surface import Key, Surface
from ..tables import Floats, Longs, Signs
from .moved import MovedRows
from .pattern import SIZES, Group
from .surfaces import ExactSurfaces, SurfaceArrays

if TYPE_CHECKING:
    from .layout import Places


@dataclass
class Given:
    """The surfaces of all bodies as they came, and of each one that it is surely the same as: its lead."""

    kinds: Signs
    lead: Longs
    leads: Longs  # those that lead, rising
    is_lead: npt.NDArray[np.bool_]
    rank: Longs  # of one that leads, its number among these
    row: Longs  # its number among those of its kind

    @classmethod
    def of(cls, groups: Sequence[Group], places: Places) -> Given:
        """Those of the bodies of all groups."""
        kinds, lead = np.empty(places.count, np.int8), np.arange(places.count)
        for group in groups:
            at = places.rows(group, len(group.pattern.kinds))
            kinds[at] = group.pattern.kinds
            if isinstance(group.rows, MovedRows):
                for number, (_, column, _) in enumerate(group.pattern.records):
                    if column in group.rows.leads:
                        lead[at[:, number]] = at[group.rows.leads[column], number]
        for same in _of_one_form(groups, places):
            numbers, anchors = (np.concatenate(part) for part in zip(*same, strict=True))
            _, first, index = np.unique(anchors.view("V24").ravel(), return_index=True, return_inverse=True)
            least = np.full(len(first), places.count)
            np.minimum.at(least, index, numbers)
            lead[numbers] = least[index]
        is_lead = lead == np.arange(places.count)
        row = np.empty(places.count, np.int64)
        for kind in SIZES:
            own = is_lead & (kinds == kind)
            row[own] = np.arange(own.sum())
        return cls(kinds, lead, np.flatnonzero(is_lead), is_lead, np.cumsum(is_lead) - 1, row)

    def count(self, kind: int) -> int:
        """How many of a kind lead."""
        return int((self.kinds[self.leads] == kind).sum())

    def all_of(self, surfaces: SurfaceArrays) -> SurfaceArrays:
        """What is known of those that lead, for all."""
        if len(self.leads) == len(self.lead):
            return surfaces
        rank, count = self.rank[self.lead], len(self.leads)
        ids = np.concatenate([surfaces.ids[:count][rank], surfaces.ids[count:]])
        senses = np.concatenate([surfaces.senses[:count][rank], surfaces.senses[count:]])
        return dataclasses.replace(surfaces, ids=ids, senses=senses, single=self.leads[surfaces.single])


def _of_one_form(groups: Sequence[Group], places: Places) -> list[list[tuple[Longs, Floats]]]:
    """Numbers and anchors of curved surfaces that are one if their anchors are."""
    found: dict[Hashable, list[tuple[Longs, Floats]]] = {}
    for group in groups:
        if isinstance(group.rows, MovedRows):
            first = places.first[group.bodies]
            for number, (_, column, _) in enumerate(group.pattern.records):
                form = group.rows.forms.get(column)
                if form is not None:
                    anchors = np.ascontiguousarray(group.rows[:, column : column + 3]) + 0.0
                    found.setdefault(form, []).append((first + number, anchors))
    return list(found.values())


@dataclass
class Leading:
    """Exact surfaces by their numbers among those that lead."""

    exact: ExactSurfaces
    leads: Longs

    def __getitem__(self, index: int) -> Surface:
        return self.exact[int(self.leads[index])]

    def name(self, index: int) -> tuple[Key, int]:
        """The exact name of a surface, and its sense."""
        return self.exact.name(int(self.leads[index]))


def columns_of(group: Group, which: Longs | None, first: int, last: int) -> Floats:
    """Some columns of some of a group's bodies; of all, for None."""
    if which is None:
        return group.rows[:, first:last]
    return group.rows.of(which, first, last) if isinstance(group.rows, MovedRows) else group.rows[which, first:last]
