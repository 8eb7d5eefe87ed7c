"""Merge the surfaces of a spliced scene: new ones are compared with all, those that stay only with new ones.

Exact names decide which surfaces are equal (`coincidence.py`), so classes of the old scene neither split nor join. A
class is recomputed where a new surface may belong to it, or where the surface with its record is gone.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np

from ..._util.arrays import is_member_sorted, unique_sorted
from ..._util.records import dataclass
from ...kernels.tables import PLANE, QUADRIC, SPHERE, Floats, Ints, Longs, Signs
from ..body_collector import ExactBodySurfaces
from ..coincidence import RawSurfaces, SurfaceSubset, merge_surfaces
from ..row_layout import BALLS, PLANES, QUADRICS, SPHERES, SURFACES, RowLayout
from ..surface_features import QuadricTable, Remainders
from .neighbour_index import Marks, NeighbourFrame, NeighbourPlaces, find_neighbours, surface_columns
from .scene_splice import SceneSplice


@dataclass
class MergedSurfaces:
    """The surface part of the new scene's `RowLayout`, over input surfaces and the bulk balls behind them."""

    kinds: Signs
    input_senses: Signs
    first: Ints | None
    senses: Signs | None
    frame: NeighbourFrame
    places: NeighbourPlaces
    balls: int

    @property
    def count(self) -> int:
        """How many surfaces there are."""
        return len(self.kinds) + self.balls


def with_ball_senses(senses: Signs, count: int) -> Signs:
    """Return the senses that surfaces came with, and those of bulk balls (+1), `count` in all."""
    return np.concatenate([senses, np.ones(count - len(senses), np.int8)])


class SurfaceMerge:
    """The surfaces of two scenes joined, and operations that merge them."""

    def __init__(self, splice: SceneSplice, exact: ExactBodySurfaces) -> None:
        self.splice, self.exact, self.pieces = splice, exact, splice.pieces
        self.single, self.balls = int(self.pieces.total[SURFACES]), int(self.pieces.total[BALLS])
        self.layouts: tuple[RowLayout, RowLayout] = splice.layouts
        self.kinds = splice.column(SURFACES, lambda side: side.layout.kinds, np.int8)
        self.input_senses = splice.column(SURFACES, lambda side: side.layout.input_senses, np.int8)

    @cached_property
    def of_kind(self) -> dict[int, Longs]:
        """The surfaces of each kind."""
        return {kind: np.flatnonzero(self.kinds == kind) for kind in (PLANE, SPHERE, QUADRIC)}

    def merge_all(self, frame: NeighbourFrame | None, old: NeighbourPlaces | None) -> MergedSurfaces:
        """Compute the classes of surfaces; `frame` and `old` are the frame and places of the scene before, if known."""
        frame, places = self._places(frame, old)
        first, senses = self._old_classes()
        fresh = self._fresh()
        orphans = np.zeros(0, np.int64) if first is None else np.flatnonzero(first < 0)
        leads = self._near_leads(fresh, places, first)
        if len(orphans) or len(leads):
            if first is None:
                count = self.single + self.balls
                first, senses = np.arange(count, dtype=np.int32), with_ball_senses(self.input_senses, count)
            assert senses is not None
            self.merge(unique_sorted(fresh, orphans), leads, first, senses)
        # None stands for the common case that every surface represents itself.
        if first is not None and (first == np.arange(len(first))).all():
            first = senses = None
        return MergedSurfaces(self.kinds, self.input_senses, first, senses, frame, places, self.balls)

    def _places(
        self, frame: NeighbourFrame | None, old: NeighbourPlaces | None
    ) -> tuple[NeighbourFrame, NeighbourPlaces]:
        """Return places by which near surfaces are found: those before, if known, and new ones for new surfaces."""
        before, records = (surface_columns(side.tables) for side in self.splice.sides)
        own = frame.places_within(*records) if frame is not None and old is not None else None
        if frame is None or old is None or own is None:
            frame, (old, own) = NeighbourFrame.of_scenes(before, records)
        both = old, own
        splice = self.splice
        return frame, NeighbourPlaces(
            splice.of_both(PLANES, both[0].planes, both[1].planes),
            splice.of_spheres(both[0].spheres, both[1].spheres),
            splice.of_both(QUADRICS, both[0].quadrics, both[1].quadrics),
        )

    def _old_classes(self) -> tuple[Ints | None, Signs | None]:
        """Return `first` and `senses` as they were in both scenes; -1 where the surface with the record is gone."""
        if self.layouts[0].first is None and self.layouts[1].first is None:
            return None, None
        count = self.single + self.balls
        first, senses = np.empty(count, np.int32), np.ones(count, np.int8)
        for source, side in enumerate(self.splice.sides):
            laid, numbers = side.layout, self.splice.numbers_of_surfaces(source)
            taken = np.arange(len(numbers)) if laid.first is None else laid.first
            mine = np.flatnonzero(numbers >= 0)
            first[numbers[mine]] = numbers[taken[mine]]
            if laid.senses is not None:
                senses[numbers[mine]] = laid.senses[mine]
            else:
                own = mine[mine < len(laid.input_senses)]
                senses[numbers[own]] = laid.input_senses[own]
        return first, senses

    def _fresh(self) -> Longs:
        """Return the numbers of new surfaces and bulk balls."""
        numbers = self.splice.numbers_of_surfaces(1)
        return np.sort(numbers[numbers >= 0]).astype(np.int64)

    def _near_leads(self, fresh: Longs, places: NeighbourPlaces, first: Ints | None) -> Longs:
        """Return the leads of the classes of the old scene that a new surface may belong to."""
        mark = np.zeros(self.single + self.balls, bool)
        mark[fresh] = True
        # Spheres and quadrics share one kind of features: a quadric may equal a sphere.
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
        # New surfaces are compared with one another anyway: they are all in `merge`
        beside = beside[~mark[beside]]
        if first is not None:
            # One comparison for each class: all its members have the record of its lead
            beside = first[beside]
            beside = beside[beside >= 0]
        return unique_sorted(beside).astype(np.int64)

    def _numbers(self, kind: int) -> Longs:
        """Return the numbers of the surfaces of a kind, by their rows."""
        found = self.of_kind[kind]
        if kind == SPHERE and self.balls:
            found = np.concatenate([found, self.single + np.arange(self.balls)])
        return found

    def merge(self, loose: Longs, leads: Longs, first: Ints, senses: Signs) -> None:
        """Recompute the classes of the surfaces `loose`, together with `leads`, which represent others.

        `first` and `senses` are updated in place.
        """
        chosen = unique_sorted(loose, leads)
        arrays = merge_surfaces(self._surfaces(chosen))
        taken = chosen if arrays.first is None else chosen[arrays.first]
        is_lead = is_member_sorted(chosen, leads)
        own_senses = np.ones(len(chosen), np.int8)
        own_senses[chosen < self.single] = self.input_senses[chosen[chosen < self.single]]
        turn = arrays.senses * own_senses
        changed = is_lead & ((taken != chosen) | (turn != 1))
        if changed.any():
            # A lead of an old class may now follow another record, or be negated: its whole class follows.
            onto, turned = np.arange(len(first), dtype=np.int32), np.ones(len(first), np.int8)
            onto[chosen[changed]], turned[chosen[changed]] = taken[changed], turn[changed]
            there = np.flatnonzero(first >= 0)
            senses[there] *= turned[first[there]]
            first[there] = onto[first[there]]
        own = ~is_lead
        first[chosen[own]], senses[chosen[own]] = taken[own], arrays.senses[own]

    def _surfaces(self, chosen: Longs) -> RawSurfaces:
        """Collect some surfaces, in the order of their numbers."""
        single = chosen[chosen < self.single]
        kinds, splice = self.kinds[single], self.splice
        rows = {kind: self._rows(single[kinds == kind], kind) for kind in (PLANE, SPHERE, QUADRIC)}
        balls = chosen[chosen >= self.single] - self.single
        return RawSurfaces(
            kinds, self.input_senses[single],
            splice.take(PLANES, rows[PLANE], lambda side: side.tables.planes),
            splice.take(SPHERES, rows[SPHERE], lambda side: side.tables.spheres),
            QuadricTable.of(
                splice.take(QUADRICS, rows[QUADRIC], lambda side: side.tables.quadrics),
                splice.take(QUADRICS, rows[QUADRIC], lambda side: side.tables.quadric_forms),
            ),
            Remainders(
                splice.take(PLANES, rows[PLANE], lambda side: side.rest.planes),
                splice.take(SPHERES, rows[SPHERE], lambda side: side.rest.spheres),
                splice.take(QUADRICS, rows[QUADRIC], lambda side: side.rest.quadrics),
            ),
            [splice.take_balls(balls)],
            SurfaceSubset(self.exact, single),
        )  # fmt: skip

    def _rows(self, single: Longs, kind: int) -> Longs:
        """Return the rows of surfaces of a kind in the table of that kind."""
        return np.searchsorted(self.of_kind[kind], single) if len(single) else single
