"""The surfaces of an edited scene, each once: the new ones are compared with all, those that stay only with these.

What is one surface is told by the exact names (`surfaces`), so classes of the old scene neither part nor join. A class
is worked out anew where a new surface may belong to it, or where that is gone whose record stood for it.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..._util.arrays import is_member_sorted, unique_sorted
from ...geometry.surface import Key, Surface
from ...kernels.tables import PLANE, QUADRIC, SPHERE, Floats, Ints, Longs, Signs
from ..body_collector import ExactBodySurfaces
from ..coincidence import QuadricTable, RawSurfaces, Remainders, exact_names_at, merge_surfaces
from ..row_layout import BALLS, PLANES, QUADRICS, SPHERES, SURFACES, RowLayout
from .neighbour_index import Marks, NeighbourFrame, NeighbourPlaces, find_neighbours, surface_columns
from .scene_splice import SceneSplice


@dataclass
class MergedSurfaces:
    """For each surface that bodies came with, and each bulk ball behind them, what `Laid` says of it."""

    kinds: Signs
    given: Signs
    first: Ints | None
    senses: Signs | None
    frame: NeighbourFrame
    places: NeighbourPlaces
    balls: int

    @property
    def count(self) -> int:
        """How many there are."""
        return len(self.kinds) + self.balls


@dataclass(frozen=True)
class _SurfaceSubset:
    """Some of the exact surfaces, by numbers of their own."""

    exact: ExactBodySurfaces
    chosen: Longs

    def __getitem__(self, index: int) -> Surface:
        return self.exact[int(self.chosen[index])]

    def name(self, index: int) -> tuple[Key, int]:
        """The exact name of a surface, and its sense."""
        return self.exact.name(int(self.chosen[index]))

    def said(self, indices: Longs) -> dict[int, Hashable]:
        """What is equal for surfaces that are surely one."""
        return exact_names_at(self.exact, self.chosen, indices)


def input_senses(given: Signs, count: int) -> Signs:
    """The senses that surfaces came with, and those of bulk balls, up to so many."""
    return np.concatenate([given, np.ones(count - len(given), np.int8)])


class SurfaceMerge:
    """One run of `merged`."""

    def __init__(self, joined: SceneSplice, exact: ExactBodySurfaces) -> None:
        self.joined, self.exact, self.pieces = joined, exact, joined.pieces
        self.single, self.balls = int(self.pieces.total[SURFACES]), int(self.pieces.total[BALLS])
        self.laid: tuple[RowLayout, RowLayout] = joined.laid
        self.kinds = joined.column(SURFACES, lambda side: side.laid.kinds, np.int8)
        self.given = joined.column(SURFACES, lambda side: side.laid.given, np.int8)

    @cached_property
    def of_kind(self) -> dict[int, Longs]:
        """The surfaces of each kind."""
        return {kind: np.flatnonzero(self.kinds == kind) for kind in (PLANE, SPHERE, QUADRIC)}

    def merged(self, frame: NeighbourFrame | None, old: NeighbourPlaces | None) -> MergedSurfaces:
        """The classes of surfaces; frame and old places are those of the scene before, if they are known."""
        frame, places = self._places(frame, old)
        first, senses = self._kept()
        fresh = self._fresh()
        orphans = np.zeros(0, np.int64) if first is None else np.flatnonzero(first < 0)
        leads = self._beside(fresh, places, first)
        if len(orphans) or len(leads):
            if first is None:
                count = self.single + self.balls
                first, senses = np.arange(count, dtype=np.int32), input_senses(self.given, count)
            assert senses is not None
            self.merge(unique_sorted(fresh, orphans), leads, first, senses)
        if first is not None and (first == np.arange(len(first))).all():
            first = senses = None
        return MergedSurfaces(self.kinds, self.given, first, senses, frame, places, self.balls)

    def _places(
        self, frame: NeighbourFrame | None, old: NeighbourPlaces | None
    ) -> tuple[NeighbourFrame, NeighbourPlaces]:
        """Numbers by which near surfaces are found: new ones for what is new, if there are some for the rest."""
        before, records = (surface_columns(side.tables) for side in self.joined.sides)
        own = frame.places_within(*records) if frame is not None and old is not None else None
        if frame is None or old is None or own is None:
            frame, (old, own) = NeighbourFrame.around(before, records)
        both = old, own
        joined = self.joined
        return frame, NeighbourPlaces(
            joined.of_both(PLANES, both[0].planes, both[1].planes),
            joined.of_spheres(both[0].spheres, both[1].spheres),
            joined.of_both(QUADRICS, both[0].quadrics, both[1].quadrics),
        )

    def _kept(self) -> tuple[Ints | None, Signs | None]:
        """`first` and `senses` as they were in both scenes; -1 where that is gone whose record was taken."""
        if self.laid[0].first is None and self.laid[1].first is None:
            return None, None
        count = self.single + self.balls
        first, senses = np.empty(count, np.int32), np.ones(count, np.int8)
        for source, side in enumerate(self.joined.sides):
            laid, numbers = side.laid, self.joined.numbers_of_surfaces(source)
            taken = np.arange(len(numbers)) if laid.first is None else laid.first
            mine = np.flatnonzero(numbers >= 0)
            first[numbers[mine]] = numbers[taken[mine]]
            if laid.senses is not None:
                senses[numbers[mine]] = laid.senses[mine]
            else:
                own = mine[mine < len(laid.given)]
                senses[numbers[own]] = laid.given[own]
        return first, senses

    def _fresh(self) -> Longs:
        """The numbers of what is new, bulk balls too."""
        numbers = self.joined.numbers_of_surfaces(1)
        return np.sort(numbers[numbers >= 0]).astype(np.int64)

    def _beside(self, fresh: Longs, places: NeighbourPlaces, first: Ints | None) -> Longs:
        """Those of the old scene that a new surface may be one with: of each class the one whose record it takes."""
        mark = np.zeros(self.single + self.balls, bool)
        mark[fresh] = True
        curved = self._numbers(SPHERE), self._numbers(QUADRIC)
        groups: list[tuple[list[Floats], Sequence[Marks], list[Longs]]] = [
            ([places.planes], [places.marks[0]], [self._numbers(PLANE)]),
            ([places.spheres, places.quadrics], places.marks[1:], list(curved)),
        ]
        found = []
        for of_rows, marks, numbers in groups:
            new = np.concatenate([part[mark[which]] for part, which in zip(of_rows, numbers, strict=True)])
            found += [
                which[find_neighbours(part, own, new)] for part, own, which in zip(of_rows, marks, numbers, strict=True)
            ]
        beside: Any = np.concatenate(found)
        beside = beside[~mark[beside]]
        if first is not None:
            beside = first[beside]
            beside = beside[beside >= 0]
        return unique_sorted(beside).astype(np.int64)

    def _numbers(self, kind: int) -> Longs:
        """The numbers of the surfaces of a kind, by their rows."""
        found = self.of_kind[kind]
        if kind == SPHERE and self.balls:
            found = np.concatenate([found, self.single + np.arange(self.balls)])
        return found

    def merge(self, loose: Longs, leads: Longs, first: Ints, senses: Signs) -> None:
        """Work out the classes of some surfaces anew, together with those for which others stand: the leads."""
        chosen = unique_sorted(loose, leads)
        arrays = merge_surfaces(self._surfaces(chosen))
        taken = chosen if arrays.first is None else chosen[arrays.first]
        is_lead = is_member_sorted(chosen, leads)
        given = np.ones(len(chosen), np.int8)
        given[chosen < self.single] = self.given[chosen[chosen < self.single]]
        turn = arrays.senses * given
        changed = is_lead & ((taken != chosen) | (turn != 1))
        if changed.any():
            onto, turned = np.arange(len(first), dtype=np.int32), np.ones(len(first), np.int8)
            onto[chosen[changed]], turned[chosen[changed]] = taken[changed], turn[changed]
            there = np.flatnonzero(first >= 0)
            senses[there] *= turned[first[there]]
            first[there] = onto[first[there]]
        own = ~is_lead
        first[chosen[own]], senses[chosen[own]] = taken[own], arrays.senses[own]

    def _surfaces(self, chosen: Longs) -> RawSurfaces:
        """Some surfaces, in the order of their numbers."""
        single = chosen[chosen < self.single]
        kinds, joined = self.kinds[single], self.joined
        rows = {kind: self._rows(single[kinds == kind], kind) for kind in (PLANE, SPHERE, QUADRIC)}
        balls = chosen[chosen >= self.single] - self.single
        return RawSurfaces(
            kinds, self.given[single],
            joined.take(PLANES, rows[PLANE], lambda side: side.tables.planes),
            joined.take(SPHERES, rows[SPHERE], lambda side: side.tables.spheres),
            QuadricTable.of(
                joined.take(QUADRICS, rows[QUADRIC], lambda side: side.tables.quadrics),
                joined.take(QUADRICS, rows[QUADRIC], lambda side: side.tables.quadric_forms),
            ),
            Remainders(
                joined.take(PLANES, rows[PLANE], lambda side: side.rest.planes),
                joined.take(SPHERES, rows[SPHERE], lambda side: side.rest.spheres),
                joined.take(QUADRICS, rows[QUADRIC], lambda side: side.rest.quadrics),
            ),
            [joined.take_balls(balls)],
            _SurfaceSubset(self.exact, single),
        )  # fmt: skip

    def _rows(self, single: Longs, kind: int) -> Longs:
        """In the table of a kind, the rows of surfaces of that kind."""
        return np.searchsorted(self.of_kind[kind], single) if len(single) else single
