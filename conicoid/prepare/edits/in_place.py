"""Edit a scene in place: entries are exchanged for others with as many rows, nearly always because a body moved.

All other rows stay where they are, and as they are except for what concerns surfaces that coincide with new ones, or
did with removed ones (`surface_classes.py`). So the buffer of a scene that is gone is reused (`buffer_pool.py`), and
only the rows of some entries are written: of the new ones, and of those in which that scene differs from the one
before.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np

from ...geometry.body import Body
from ...kernels.tables import BALL, SPHERE, Floats, Geometry, Longs, Tables, put_sizes, unpack_tables
from ..body_collector import BodyShapes
from ..lowering import ExactTables, LoweredScene
from ..row_layout import (
    BODIES,
    CELL_PLANES,
    CELLS,
    FACES,
    FRAMES,
    KINDS,
    POLYGONS,
    SHEETS,
    SPHERES,
    SURFACES,
    RowLayout,
)
from ..surface_features import Remainders
from .buffer_pool import (
    EXTRA_ARRAYS,
    OF_FRAMES,
    BufferClaim,
    EditState,
    FullEditState,
    OpenBuffer,
    PoolMemory,
    extra_arrays,
    next_edit_number,
    raw_places,
    restamp_entries,
    stamp_entries,
)
from .column_splice import AXES, TREES, SurfaceNumbering, TableFiller, table_senses
from .limits_update import LimitChanges, LimitsUpdate
from .neighbour_index import NeighbourPlaces
from .scene_splice import SceneSplice, SplicePieces, SpliceRuns
from .surface_classes import SurfaceClasses, slot_entries

# Overwrite the rows in which the tables of an edited scene differ from its buffer, and update their limits.


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


_MOST = 128
"""So many pieces are written one by one; with more of them all rows are written at once."""
_OF_SURFACES = "surface_kind", "surface_row"
"""Tables with as many rows as there are surfaces."""


class InPlaceEdit:
    """A scene some of whose entries are exchanged, in the buffer of one that is gone, or in new memory.

    Valid only where `keeps_rows` allows it.
    """

    def __init__(
        self,
        splice: SceneSplice,
        bodies: Sequence[Body],
        runs: SpliceRuns,
        edit_state: FullEditState,
        own: NeighbourPlaces,
        classes: SurfaceClasses,
        claim: BufferClaim,
    ) -> None:
        """Start the edit.

        `own` are the places of new surfaces; `claim` is on the memory of the old scene.
        """
        self.in_place = claim.buffer is not None
        # Renumbering reads the old integers of all rows while the same memory is overwritten.
        if self.in_place and classes.renumbered:
            splice = _copy_integers(splice)
        old, new = splice.sides
        self._claim = claim  # while it is held, nobody overwrites the memory that is read
        self.splice, self.pieces, self.edit_state, self.classes = splice, splice.pieces, edit_state, classes
        self._bodies, self._fresh = bodies, runs.fresh
        sides = extra_arrays(old, edit_state.places), extra_arrays(new, own)
        opened, some = claim.buffer, self.pieces.of_source(1)
        if opened is None:
            opened, some = _claim_rows(edit_state.memory, old.layout, self.pieces, runs.fresh)
        if opened is not None:
            for name, column in sides[0].items():
                if name not in opened.extra_arrays or (opened.frame != edit_state.frame and name.startswith(OF_FRAMES)):
                    opened.put(name, column.copy())
        beside = opened.extra_arrays if opened else {name: column.copy() for name, column in sides[0].items()}
        for name, axis in EXTRA_ARRAYS.items():
            for source, rows, at in some.on(axis):
                beside[name][at] = sides[source][name][rows]
        self._buffer, self._some, self._extra_arrays = opened, some, beside
        self._all_numbers = classes.renumbered or bool(opened and opened.numbers != edit_state.memory.numbers)
        self._layout = _exchange_layout(splice, classes)
        self.boxes: Floats = beside["boxes"]
        self.kinds = self._layout.patterns.entries[self._layout.which, 2]
        self.shapes: dict[str, Any] = {k: v for k, v in old.tables._asdict().items() if k not in TREES}
        for name in _OF_SURFACES:
            self.shapes[name] = np.broadcast_to(self.shapes[name].dtype.type(), classes.count)

    @property
    def keeps_items(self) -> bool:
        """True if leaf items of unchanged entries can be kept: they name balls, and tell how large cells are."""
        if len(self.classes.bereft):
            return False
        return not (self.classes.renumbered and bool((self.splice.sides[0].tables.entry_kind == BALL).any()))

    def geometry(self, empty: Tables) -> Geometry:
        """Return memory for tables of these shapes, in which all rows are valid but those that differ."""
        found = self._buffer.geometry(empty) if self._buffer else None
        if found is not None:
            return found
        self._some, self.in_place = self.pieces.of_source(1), False
        others = self._buffer is not None  # the arrays beside belong to a later scene
        self._buffer = OpenBuffer.new(empty)
        for name, column in self._extra_arrays.items():
            self._extra_arrays[name] = self._buffer.put(name, column.copy() if others else column)
        self.boxes = self._extra_arrays["boxes"]
        laid_out = self._buffer.geometry(empty)
        assert laid_out is not None
        tables, old = unpack_tables(empty, laid_out), self.splice.sides[0].tables
        self._all_numbers = self.classes.renumbered
        for name in self.shapes:
            if not (self._all_numbers and name in _OF_SURFACES):
                getattr(tables, name)[...] = getattr(old, name)
        return laid_out

    def fill(self, geometry: Geometry, tables: Tables) -> tuple[LoweredScene, FullEditState]:
        """Write the tables where they differ; trees are left as they are."""
        splice, beside, kept, classes = self.splice, self._extra_arrays, self.edit_state, self.classes
        columns, (old, _) = RowOverwrite(splice, self._some, self._layout, classes, self._all_numbers), splice.sides
        columns.fill(tables)
        rest = Remainders(beside["planes"], beside["spheres"], beside["quadrics"], beside["vertices"])
        size = InPlaceLimits(columns, tables, self.boxes, rest).put(kept.size)
        put_sizes(geometry, tables)
        body_frame = old.body_frame.copy()
        columns.framed(body_frame, FRAMES, [side.body_frame for side in splice.sides])
        single = old.exact.single if classes.single is None else classes.single
        lowered = dataclasses.replace(
            old, tables=tables, bounds=self.boxes, frames=beside["frames"], body_frame=body_frame,
            face_paint=splice.paint(), rest=rest, layout=self._layout,
            exact=ExactTables(old.exact.bodies.of(BodyShapes(self._bodies)), single),
        )  # fmt: skip
        assert self._buffer is not None
        numbers = next_edit_number() if classes.renumbered else kept.memory.numbers
        memory = self._buffer.memory(kept.memory.stores, self._stamps(size == kept.size), numbers)
        return lowered, FullEditState(kept.frame, raw_places(self._buffer), size, memory=memory)

    def _stamps(self, same_size: bool) -> Longs:
        """Return stamps: those of new entries change, and of all that share a surface with these."""
        if not same_size:
            return stamp_entries(len(self.edit_state.memory.stamps))
        touched = slot_entries(self._layout, self.classes.renumbered_slots).tolist()
        return restamp_entries(self.edit_state.memory.stamps, [*self._fresh, *touched])

    def close(self, edit_state: EditState) -> None:
        """Finish: all tables are written, those of trees too; `edit_state` is the state that `fill` returned.

        Only from here on the buffer may go to others when the scene is gone. The buffer of an edit that is aborted
        before goes to nobody, because no stamps describe its rows.
        """
        assert isinstance(edit_state, FullEditState)
        assert self._buffer is not None
        self._buffer.close(edit_state.memory, edit_state.frame)


def _copy_integers(splice: SceneSplice) -> SceneSplice:
    """Return the splice with all integers of the old tables copied to memory of their own."""
    old, new = splice.sides
    columns = {name: column.copy() for name, column in old.tables._asdict().items() if column.dtype != np.float64}
    return SceneSplice((dataclasses.replace(old, tables=old.tables._replace(**columns)), new), splice.pieces)


def _claim_rows(
    memory: PoolMemory, layout: RowLayout, pieces: SplicePieces, fresh: list[int]
) -> tuple[OpenBuffer | None, SplicePieces]:
    """Take the buffer of a scene that is gone, if there is one; return also the pieces to be written there."""
    new, opened = pieces.of_source(1), memory.stores.take()
    if opened is None:
        return None, new
    other = memory.stamps != opened.stamps
    other[fresh] = False
    # Runs of entries whose stamps differ: (first, end) alternate.
    bounds = np.flatnonzero(np.diff(other, prepend=False, append=False))
    if len(bounds) > 2 * _MOST:
        bounds = np.array([0, len(other)])
    return opened, new.after_rows(layout.rows_up_to(bounds)) if len(bounds) else new


def _exchange_layout(splice: SceneSplice, classes: SurfaceClasses) -> RowLayout:
    """Return the layout: only patterns, and what surfaces are, differ from before."""
    (old, new), pieces = splice.layouts, splice.pieces.of_source(1)
    patterns, numbers = old.patterns.union(new.patterns)
    which, kinds, senses = old.which.copy(), old.kinds.copy(), old.input_senses.copy()
    for _, rows, at in pieces.on(BODIES):
        which[at] = numbers[new.which[rows]]
    for _, rows, at in pieces.on(SURFACES):
        kinds[at], senses[at] = new.kinds[rows], new.input_senses[rows]
    return dataclasses.replace(
        old, patterns=patterns, which=which, kinds=kinds, input_senses=senses, first=classes.first,
        senses=classes.senses, ids=classes.ids,
    )  # fmt: skip
