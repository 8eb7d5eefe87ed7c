"""Edit a scene in place: entries are exchanged for others with as many rows, nearly always because a body moved.

All other rows stay where they are, and as they are except for what concerns surfaces that coincide with new ones, or
did with removed ones (`surface_classes.py`). So the buffer of a scene that is gone is reused (`buffer_pool.py`), and
only the rows of some entries are written: of the new ones, and of those in which that scene differs from the one
before.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...geometry.body import Body
from ...kernels.tables import BALL, Floats, Geometry, Longs, Tables, put_sizes, unpack_tables
from ..body_collector import BodyShapes
from ..coincidence import Remainders
from ..lowering import ExactTables, LoweredScene
from ..row_layout import BODIES, CORNERS, FRAMES, PLANES, QUADRICS, SPHERES, SURFACES, RowLayout
from .buffer_pool import BufferClaim, OpenBuffer, PoolMemory, next_edit_number, restamp_entries, stamp_entries
from .column_splice import TREES
from .edit_state import EditState, FullEditState
from .neighbour_index import NeighbourFrame, NeighbourPlaces, surface_columns
from .pieces import SplicePieces, SpliceRuns
from .row_overwrite import InPlaceLimits, RowOverwrite
from .scene_splice import SceneSplice
from .surface_classes import SurfaceClasses, slot_entries

_MOST = 128
"""So many pieces are written one by one; with more of them all rows are written at once."""
EXTRA_ARRAYS = {
    "boxes": BODIES, "frames": FRAMES, "planes": PLANES, "spheres": SPHERES, "quadrics": QUADRICS, "vertices": CORNERS,
    "place_of_planes": PLANES, "place_of_spheres": SPHERES, "place_of_quadrics": QUADRICS,
    "mark_of_planes": PLANES, "mark_of_spheres": SPHERES, "mark_of_quadrics": QUADRICS,
}  # fmt: skip
"""Arrays of a buffer beside the tables, and the kind of their rows."""
_PLACED = 1 << 18
"""Up to so many surfaces have places from the beginning: ten bytes each, and a hundredth of the time surfaces take."""
_OF_SURFACES = "surface_kind", "surface_row"
"""Tables with as many rows as there are surfaces."""
_OF_FRAMES = "place", "mark"
"""Prefixes of the names of arrays that are relative to a frame (`neighbour_index.py`)."""


def _extra_arrays(lowered: LoweredScene, places: NeighbourPlaces) -> dict[str, Any]:
    """Return the arrays of a scene beside the tables."""
    return dict(zip(EXTRA_ARRAYS, (*_first_extra_arrays(lowered), *_place_arrays(places)), strict=True))


def _place_arrays(places: NeighbourPlaces) -> tuple[Any, ...]:
    """Return the arrays that are relative to a frame."""
    return places.planes, places.spheres, places.quadrics, *places.marks


def _raw_places(opened: OpenBuffer) -> NeighbourPlaces:
    """Return the places in a buffer, in arrays that do not hold its scene."""
    return NeighbourPlaces.of_buckets(*(opened.raw(name) for name in EXTRA_ARRAYS if name.startswith(_OF_FRAMES)))


def _first_extra_arrays(lowered: LoweredScene) -> tuple[Any, ...]:
    """Return the arrays that exist even if nothing was edited."""
    rest = lowered.rest
    return lowered.boxes, lowered.frames, rest.planes, rest.spheres, rest.quadrics, rest.vertices


def _with_extra_arrays(lowered: LoweredScene, tables: Tables, beside: Mapping[str, Any]) -> LoweredScene:
    rest = Remainders(beside["planes"], beside["spheres"], beside["quadrics"], beside["vertices"])
    return dataclasses.replace(lowered, tables=tables, bounds=beside["boxes"], frames=beside["frames"], rest=rest)


def adopt_buffer(lowered: LoweredScene, opened: OpenBuffer) -> tuple[LoweredScene, EditState]:
    """Move a freshly prepared scene, whose tables are in a buffer, there with all its arrays.

    Places of surfaces are computed, so that the first edit need not process all of them, unless there are so many that
    their memory matters more.
    """
    records, frame, places = surface_columns(lowered.tables), None, None
    beside: tuple[Any, ...] = _first_extra_arrays(lowered)
    if sum(len(table) for table in records) <= _PLACED:
        frame, (found,) = NeighbourFrame.of_scenes(records)
        beside = *beside, *_place_arrays(found)
    # An array that is writable and no view belongs to this scene alone; others are copied.
    for name, column in zip(EXTRA_ARRAYS, beside, strict=False):
        whole = column.flags.writeable and not isinstance(column.base, np.ndarray)
        opened.put(name, column if whole else column.copy())
    if frame is not None:
        places = _raw_places(opened)
    assert lowered.layout is not None
    memory = PoolMemory.new(len(lowered.layout.first_body) - 1)
    memory = opened.memory(memory.stores, memory.stamps, memory.numbers)
    opened.close(memory, frame)
    return _with_extra_arrays(lowered, lowered.tables, opened.extra_arrays), EditState(frame, places, memory=memory)


def release_memory(lowered: LoweredScene, geometry: Geometry, memory: PoolMemory) -> LoweredScene:
    """Return the scene in arrays that do not hold its buffer: who reads them claims it (`PoolMemory.claim`)."""
    store = memory.store
    if store is None:
        return lowered
    raw = unpack_tables(lowered.tables, geometry._replace(integers=store.integers, floats=store.floats))
    return _with_extra_arrays(lowered, raw, store.extra_arrays)


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
        sides = _extra_arrays(old, edit_state.places), _extra_arrays(new, own)
        opened, some = claim.buffer, self.pieces.of_source(1)
        if opened is None:
            opened, some = _claim_rows(edit_state.memory, old.layout, self.pieces, runs.fresh)
        if opened is not None:
            for name, column in sides[0].items():
                if name not in opened.extra_arrays or (
                    opened.frame != edit_state.frame and name.startswith(_OF_FRAMES)
                ):
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
        return lowered, FullEditState(kept.frame, _raw_places(self._buffer), size, memory=memory)

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
