"""Overwrite the rows in which the tables of an edited scene differ from its buffer, and update their limits."""

from __future__ import annotations

import numpy as np

from ...kernels.tables import BALL, SPHERE, Longs, Tables
from ..row_layout import BODIES, CELL_PLANES, CELLS, FACES, KINDS, POLYGONS, SHEETS, SPHERES, SURFACES, RowLayout
from .column_splice import AXES, SurfaceNumbering, TableFiller, table_senses
from .limits_update import LimitChanges, LimitsUpdate
from .pieces import SplicePieces
from .scene_splice import SceneSplice
from .surface_classes import SurfaceClasses


class RowOverwrite(TableFiller):
    """Fills the tables where they differ from the buffer: the rows of some pieces.

    Where surfaces have other numbers in the buffer, all columns of such numbers are rewritten, and the table of
    surfaces.
    """

    def __init__(
        self, splice: SceneSplice, some: SplicePieces, layout: RowLayout, classes: SurfaceClasses, all_numbers: bool
    ) -> None:
        """Prepare to fill the pieces `some`; `all_numbers` rewrites every number of a surface."""
        super().__init__(
            splice, some, layout, (SurfaceNumbering(classes.onto, None), _new_surface_numbers(splice, layout))
        )
        self.classes, self.all_numbers = classes, all_numbers
        if all_numbers:
            self.numbered_pieces = splice.pieces

    def _put_surfaces(self, tables: Tables) -> None:
        """Write kinds and rows of the surfaces, and the spheres."""
        self._copy(tables.spheres, SPHERES, [side.tables.spheres for side in self.splice.sides])
        first, ids, pieces = self.layout.first, self.ids, self.numbered_pieces
        of_kinds = [pieces.begins(SURFACES, AXES[kind]) for kind in sorted(AXES)]
        for (_, _, at), *begins in zip(pieces.on(SURFACES), *of_kinds, strict=True):
            kinds, rows = self.layout.kinds[at], np.empty(at.stop - at.start, np.int32)
            for kind, begin in zip(sorted(AXES), begins, strict=True):
                mine = np.flatnonzero(kinds == kind)
                rows[mine] = np.arange(begin, begin + len(mine), dtype=np.int32)
            if first is None or ids is None:
                tables.surface_kind[at], tables.surface_row[at] = kinds, rows
            else:
                leads = np.flatnonzero(first[at] == np.arange(at.start, at.stop, dtype=np.int32))
                there = ids[at][leads]
                tables.surface_kind[there], tables.surface_row[there] = kinds[leads], rows[leads]
        if self.all_numbers:
            self._put_bulk_balls(tables)

    def _put_bulk_balls(self, tables: Tables) -> None:
        """Write kinds and rows of the surfaces that are bulk balls, behind all others."""
        single, spheres = len(self.layout.kinds), int(self.pieces.total[SPHERES])
        rows = np.arange(spheres, len(tables.spheres), dtype=np.int32)
        there = np.arange(single, single + len(rows))
        if self.layout.first is not None and self.ids is not None:
            leads = self.layout.first[there] == there
            rows, there = rows[leads], self.ids[there[leads]]
        tables.surface_kind[there], tables.surface_row[there] = SPHERE, rows

    def _put_entries(self, tables: Tables) -> None:
        """Write the entries of the tree. The numbers of bodies stay."""
        sides = self.splice.sides
        axes = {BALL: SURFACES, **KINDS}
        of_kinds = [self.pieces.moved(BODIES, axes[kind]) for kind in sorted(axes)]
        for (source, rows, at, _), *others in zip(of_kinds[0], *of_kinds, strict=True):
            side, shifts = sides[source].tables, np.array([shift for *_, shift in others], np.int32)
            kinds, index = side.entry_kind[rows], side.entry_index[rows]
            tables.entry_kind[at], tables.entry_index[at] = kinds, index + shifts[kinds]
            self._put_balls(tables, source, rows, at)
        if self.all_numbers:
            for source, rows, at in self.numbered_pieces.on(BODIES):
                self._put_balls(tables, source, rows, at)
        self.framed(tables.body_face, FACES, [side.tables.body_face for side in sides])

    def _put_balls(self, tables: Tables, source: int, rows: slice, at: slice) -> None:
        """Write the entries that are balls, by the numbers of their surfaces."""
        side, ids = self.splice.sides[source].tables, self.numbers[source].ids
        balls = np.flatnonzero(side.entry_kind[rows] == BALL)
        if len(balls) and (ids is not None or source == 0):
            index = side.entry_index[rows][balls]
            tables.entry_index[at][balls] = index if ids is None else ids[index]


def _new_surface_numbers(splice: SceneSplice, layout: RowLayout) -> SurfaceNumbering:
    """Return the numbers of new surfaces, and which are negated, after classes of equal surfaces are known."""
    new, own = splice.layouts[1], layout.ids
    if own is None and new.ids is None:
        return SurfaceNumbering(None, None)
    count = len(splice.sides[1].tables.surface_kind)
    ids, turned = np.full(count + 1, -1, np.int32), np.ones(count + 1, np.int8)
    for source, rows, at in splice.pieces.on(SURFACES):
        if source == 1:
            there = np.arange(rows.start, rows.stop) if new.ids is None else new.ids[rows]
            ids[there] = np.arange(at.start, at.stop) if own is None else own[at]
            turned[there] = table_senses(new.senses, new.input_senses, np.arange(rows.start, rows.stop))
            turned[there] *= table_senses(layout.senses, layout.input_senses, np.arange(at.start, at.stop))
    return SurfaceNumbering(ids, None if (turned == 1).all() else turned)


class InPlaceLimits(LimitsUpdate):
    """Limits that change with new bodies: those of these, and of surfaces that they coincide with, or did."""

    columns: RowOverwrite

    def put(self, before: float | None) -> float | None:
        """`LimitsUpdate.put`; nothing to do for bounded scenes whose new bodies share no surface with others.

        The limits of a bounded body with surfaces of its own depend on it alone.
        """
        bounded, classes = bool(np.isfinite(self.boxes).all()), self.columns.classes
        return None if bounded and not len(classes.changed_surfaces) else super().put(before)

    def _find_changes(self) -> LimitChanges:
        classes, ids = self.columns.classes, self.columns.ids
        surfaces, owners = np.zeros(len(self.tables.surface_kind), bool), np.zeros(int(self.owners[-1]), bool)
        mine = self._rows(SURFACES)
        surfaces[mine if ids is None else ids[mine]] = True
        for kind, axis in enumerate((CELLS, SHEETS, POLYGONS)):
            owners[self.owners[kind] + self._rows(axis)] = True
        if not len(classes.changed_surfaces):
            return LimitChanges(
                surfaces, owners, self._of_rows(*map(self._rows, (CELLS, CELL_PLANES, SHEETS, POLYGONS)))
            )
        surfaces[classes.changed_surfaces] = True
        if len(classes.bereft):
            other = np.zeros(len(surfaces), bool)
            other[classes.bereft if ids is None else ids[classes.bereft]] = True
            self._mark_owners(other, owners)
        return LimitChanges(surfaces, owners, self._uses(surfaces, owners))

    def _rows(self, axis: int) -> Longs:
        """Return the rows of a kind that are new."""
        parts = [np.arange(at.start, at.stop) for source, _, at in self.columns.splice.pieces.on(axis) if source == 1]
        return np.concatenate(parts) if parts else np.zeros(0, np.int64)

    def _unread(self, kind: int) -> Longs:
        """Return the rows of records that others represent now but did not before.

        New records came with limits of their own.
        """
        kinds, slots = self.layout.kinds, self.columns.classes.follow
        slots = slots[slots < len(kinds)]
        slots = slots[kinds[slots] == kind]
        return np.searchsorted(np.flatnonzero(kinds == kind), slots) if len(slots) else slots
