"""Scenes in which entries are exchanged for others with as many rows: a body that was moved, nearly always.

All other rows stay where they are and as they are, if no new surface is one with an old one. So the memory of a scene
that is gone is taken (`stores`), and only the rows of some entries are written: of those that are new, and of those in
which that scene differs from the one before.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np

from ....shapes.base import Shape
from ....shapes.body import Body
from ...tables import BALL, STEPS, Floats, Geometry, Ints, Longs, Tables, shared, steps
from .. import ExactTables, Lowered
from ..laid import (
    BODIES,
    CELL_PLANES,
    CELLS,
    CORNERS,
    FACES,
    FRAMES,
    KINDS,
    PLANES,
    POLYGONS,
    QUADRICS,
    SHEETS,
    SPHERES,
    SURFACES,
    Laid,
)  # fmt: skip
from ..limits import size_of
from ..surfaces import Remainders
from .columns import AXES, TREES, Columns, Numbers
from .joined import Joined
from .kept import Kept, Known
from .limits import Limits, Mask, Uses
from .near import Frame, Places, near
from .pieces import Pieces, Runs
from .stores import Opened, Stores, restamped, stamped

_MOST = 128
"""So many pieces are written one by one; more are as well written all at once."""
BESIDE = {
    "boxes": BODIES, "frames": FRAMES, "planes": PLANES, "spheres": SPHERES, "quadrics": QUADRICS, "vertices": CORNERS,
    "place_of_planes": PLANES, "place_of_spheres": SPHERES, "place_of_quadrics": QUADRICS,
    "mark_of_planes": PLANES, "mark_of_spheres": SPHERES, "mark_of_quadrics": QUADRICS,
}  # fmt: skip
"""What a store has beside the tables, and what its rows are of."""


def _beside(lowered: Lowered, places: Places) -> dict[str, Any]:
    """What a scene's store has beside the tables."""
    rest = lowered.rest
    columns = (
        lowered.boxes, lowered.frames, rest.planes, rest.spheres, rest.quadrics, rest.vertices,
        places.planes, places.spheres, places.quadrics, *places.marks,
    )  # fmt: skip
    return dict(zip(BESIDE, columns, strict=True))


def keeps_rows(old: Laid, new: Laid, found: Runs, entries: int) -> bool:
    """Has each new entry as many rows of every kind as that in whose place it comes? Bulk balls have none of these."""
    if entries != len(old.first_body) - 1 or not new.which.all():
        return False
    fresh = np.array(found.fresh, np.int64)
    counts = np.diff(old.first_body)[fresh]
    if not np.array_equal(counts, np.diff(new.first_body)):
        return False
    if np.diff(old.first_frame)[fresh].any() or new.first_frame.any():
        return False
    firsts = np.repeat(old.first_body[fresh] - new.first_body[:-1], counts)
    which = old.which[firsts + np.arange(len(new.which))]
    rows = old.patterns.counts[which], new.patterns.counts[new.which]
    return bool(which.all() and np.array_equal(*rows))


def apart(old: Laid, new: Laid, pieces: Pieces) -> bool:
    """Was no surface of what is gone one with others', and are new ones one with one another as those were?

    Whether new surfaces are one with others' is another question: see `none_near`.
    """
    if old.first is None and new.first is None:
        return True
    first = np.arange(len(new.kinds)) if old.first is None else old.first
    mine = np.arange(len(new.kinds)) if new.first is None else new.first
    if old.first is None:  # only where every surface stood for itself
        return bool((mine == first).all())
    fresh = np.zeros(len(first), bool)
    for source, rows, at, shift in pieces.moved(SURFACES, SURFACES):
        if source == 1:
            fresh[at] = True
            if not np.array_equal(first[at], mine[rows] + shift):
                return False
    return bool((fresh[first] == fresh).all())


def none_near(places: Places, own: Places, pieces: Pieces) -> bool:
    """Is no new surface so close to one of the others that they may be one?"""
    curved = np.concatenate([own.spheres, own.quadrics])
    groups = (PLANES, own.planes), (SPHERES, curved), (QUADRICS, curved)
    for (axis, numbers), column, marks in zip(
        groups, (places.planes, places.spheres, places.quadrics), places.marks, strict=True
    ):
        found, fresh = near(column, marks, numbers), np.zeros(len(column), bool)
        for source, _, at in pieces.on(axis):
            if source == 1:
                fresh[at] = True
        if not fresh[found].all():
            return False
    return True


class ShapesOf(Sequence[Shape]):
    """The shapes of bodies."""

    def __init__(self, bodies: Sequence[Body]) -> None:
        self._bodies = bodies

    def __getitem__(self, number: Any) -> Any:
        return self._bodies[number].shape

    def __len__(self) -> int:
        return len(self._bodies)


def completed(kept: Kept, old: Lowered, new: Lowered) -> tuple[Known, Places]:
    """What is known of the old scene, with what exchanges of its entries for new ones need; places of the new ones."""
    frame, places, records = kept.frame, kept.places, (new.tables.planes, new.tables.spheres, new.tables.quadrics)
    own = frame.places_within(*records) if frame is not None and places is not None else None
    if isinstance(kept, Known) and own is not None:
        return kept, own
    if frame is None or places is None or own is None:
        tables = old.tables
        frame, places, own = Frame.around((tables.planes, tables.spheres, tables.quadrics), records)
    size = kept.size
    if size is None and not np.isfinite(old.boxes).all():
        size = size_of(old.tables, old.boxes)
    assert old.laid is not None
    return Known(frame, places, size, stores=Stores(), stamps=stamped(len(old.laid.first_body) - 1)), own


class Exchange:
    """A scene some of whose entries are exchanged, in the memory of one that is gone, or in new memory."""

    keeps_items = True

    def __init__(
        self,
        old: Lowered,
        new: Lowered,
        pieces: Pieces,
        bodies: Sequence[Body],
        found: Runs,
        kept: Known,
        own: Places,
    ) -> None:
        assert old.laid is not None
        self.joined, self.pieces, self.kept = Joined((old, new), pieces), pieces, kept
        self._bodies, self._fresh = bodies, found.fresh
        sides = _beside(old, kept.places), _beside(new, own)
        opened, some = _taken(kept, old.laid, pieces, found.fresh)
        beside = opened.beside if opened else {name: column.copy() for name, column in sides[0].items()}
        for name, axis in BESIDE.items():
            for source, rows, at in some.on(axis):
                beside[name][at] = sides[source][name][rows]
        self._opened, self._some, self._beside = opened, some, beside
        self._laid = _exchanged(self.joined)
        self.boxes: Floats = beside["boxes"]
        self.kinds = self._laid.patterns.entries[self._laid.which, 2]
        self.shapes: dict[str, Any] = {k: v for k, v in old.tables._asdict().items() if k not in TREES}

    def geometry(self, empty: Tables) -> Geometry:
        """Memory for tables of these shapes, in which all rows are but those that differ."""
        found = self._opened.geometry(empty) if self._opened else None
        if found is not None:
            return found
        self._some = self._some.only(1)
        self._opened = Opened.new(empty)
        self._beside = {name: self._opened.put(name, column.copy()) for name, column in self._beside.items()}
        self.boxes = self._beside["boxes"]
        made = self._opened.geometry(empty)
        assert made is not None
        tables, old = shared(empty, made), self.joined.sides[0].tables
        for name in self.shapes:
            getattr(tables, name)[...] = getattr(old, name)
        return made

    def fill(self, geometry: Geometry, tables: Tables) -> tuple[Lowered, Known]:
        """Write the tables where they differ; trees are left as they are."""
        joined, beside, kept = self.joined, self._beside, self.kept
        columns, (old, _) = _Columns(joined, self._some, self._laid), joined.sides
        columns.fill(tables)
        rest = Remainders(beside["planes"], beside["spheres"], beside["quadrics"], beside["vertices"])
        size = _Limits(columns, tables, self.boxes, rest).put(kept.size)
        geometry.places[STEPS] = steps(tables)
        body_frame = old.body_frame.copy()
        columns.framed(body_frame, FRAMES, [side.body_frame for side in joined.sides])
        lowered = dataclasses.replace(
            old, tables=tables, boxes=self.boxes, frames=beside["frames"], body_frame=body_frame,
            face_paint=joined.paint(), rest=rest, laid=self._laid,
            exact=ExactTables(old.exact.bodies.of(ShapesOf(self._bodies)), old.exact.single),
        )  # fmt: skip
        assert self._opened is not None
        same = size == kept.size
        stamps = restamped(kept.stamps, self._fresh) if same else stamped(len(kept.stamps))
        self._opened.close(kept.stores, stamps)
        places = Places.marked(*(column for name, column in beside.items() if name.startswith(("place", "mark"))))
        return lowered, Known(kept.frame, places, size, stores=kept.stores, stamps=stamps)


def _taken(kept: Known, laid: Laid, pieces: Pieces, fresh: list[int]) -> tuple[Opened | None, Pieces]:
    """The memory of a scene that is gone, if there is any, and what is to be written there; else what is new."""
    new, opened = pieces.only(1), kept.stores.take()
    if opened is None:
        return None, new
    other = kept.stamps != opened.stamps
    other[fresh] = False
    bounds = np.flatnonzero(np.diff(other, prepend=False, append=False))
    if len(bounds) > 2 * _MOST:
        bounds = np.array([0, len(other)])
    return opened, new.after_rows(laid.rows_up_to(bounds)) if len(bounds) else new


def _exchanged(joined: Joined) -> Laid:
    """Which rows are whose: nothing but patterns, and kinds and senses of surfaces, are others."""
    (old, new), pieces = joined.laid, joined.pieces.only(1)
    patterns, numbers = old.patterns.joined(new.patterns)
    which, kinds, given = old.which.copy(), old.kinds.copy(), old.given.copy()
    senses = None if old.senses is None else old.senses.copy()
    for _, rows, at in pieces.on(BODIES):
        which[at] = numbers[new.which[rows]]
    for _, rows, at in pieces.on(SURFACES):
        kinds[at], given[at] = new.kinds[rows], new.given[rows]
        if senses is not None:
            senses[at] = (new.given if new.senses is None else new.senses)[rows]
    return dataclasses.replace(old, patterns=patterns, which=which, kinds=kinds, given=given, senses=senses)


class _Columns(Columns):
    """Fills the tables where they differ."""

    def __init__(self, joined: Joined, some: Pieces, laid: Laid) -> None:
        self.joined, self.pieces, self.laid, self.ids = joined, some, laid, laid.ids
        self.numbers = Numbers(None, None), self._numbers_of_new()

    def _numbers_of_new(self) -> Numbers:
        """The numbers of new surfaces. None is turned over, as they are not one with others."""
        new = self.joined.laid[1]
        if self.ids is None and new.ids is None:
            return Numbers(None, None)
        ids = np.full(len(self.joined.sides[1].tables.surface_kind) + 1, -1, np.int32)
        for source, rows, at in self.pieces.on(SURFACES):
            if source == 1:
                ids[_some(new.ids, rows)] = _some(self.ids, at)
        return Numbers(ids, None)

    def _put_surfaces(self, tables: Tables) -> None:
        """Kinds and rows of the surfaces, and the spheres."""
        sides = self.joined.sides
        self._copy(tables.spheres, SPHERES, [side.tables.spheres for side in sides])
        of_kinds = [self.pieces.moved(SURFACES, AXES[kind]) for kind in sorted(AXES)]
        for (source, rows, at, _), *others in zip(of_kinds[0], *of_kinds, strict=True):
            side, shifts = sides[source], np.array([shift for *_, shift in others], np.int32)
            here, there = _some(self.ids, at), _some(side.laid.ids, rows)
            kinds = side.tables.surface_kind[there]
            tables.surface_kind[here], tables.surface_row[here] = kinds, side.tables.surface_row[there] + shifts[kinds]

    def _put_entries(self, tables: Tables) -> None:
        """What the tree holds. The numbers of bodies stay."""
        sides, ids = self.joined.sides, self.numbers[1].ids
        axes = {BALL: SURFACES, **KINDS}
        of_kinds = [self.pieces.moved(BODIES, axes[kind]) for kind in sorted(axes)]
        for (source, rows, at, _), *others in zip(of_kinds[0], *of_kinds, strict=True):
            side, shifts = sides[source].tables, np.array([shift for *_, shift in others], np.int32)
            kinds, index = side.entry_kind[rows], side.entry_index[rows]
            tables.entry_kind[at], tables.entry_index[at] = kinds, index + shifts[kinds]
            if source == 1 and ids is not None:
                balls = np.flatnonzero(kinds == BALL)
                tables.entry_index[at.start + balls] = ids[index[balls]]
        self.framed(tables.body_face, FACES, [side.tables.body_face for side in sides])


def _some(ids: Ints | None, rows: slice) -> Any:
    """Some surfaces by the numbers they have in the table."""
    return rows if ids is None else ids[rows]


class _Limits(Limits):
    """Limits that are others only with new bodies, whose surfaces are nobody else's."""

    def put(self, before: float | None) -> float | None:
        """Those of a body that has an end are what they are for it alone, where all have one."""
        return None if np.isfinite(self.boxes).all() else super().put(before)

    def _rows(self, axis: int) -> Longs:
        parts = [np.arange(at.start, at.stop) for source, _, at in self.columns.pieces.on(axis) if source == 1]
        return np.concatenate(parts) if parts else np.zeros(0, np.int64)

    def _changed(self) -> tuple[Mask, Mask]:
        ids = self.columns.ids
        surfaces, owners = np.zeros(len(self.tables.surface_kind), bool), np.zeros(int(self.owners[-1]), bool)
        mine = self._rows(SURFACES)
        surfaces[mine if ids is None else ids[mine]] = True
        for kind, axis in enumerate((CELLS, SHEETS, POLYGONS)):
            owners[self.owners[kind] + self._rows(axis)] = True
        return surfaces, owners

    def _uses(self, surfaces: Mask, owners: Mask) -> Uses:
        return self._of_rows(*map(self._rows, (CELLS, CELL_PLANES, SHEETS, POLYGONS)))

    def _unread(self, kind: int) -> Longs:
        return np.zeros(0, np.int64)
