"""The tables of a scene some of whose entries were exchanged: only the rows in which its memory differs are written."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...tables import BALL, Ints, Longs, Tables
from ..laid import BODIES, CELL_PLANES, CELLS, FACES, KINDS, POLYGONS, SHEETS, SPHERES, SURFACES, Laid
from .columns import AXES, Filling, Numbers
from .joined import Joined
from .limits import Changed, Limits
from .pieces import Pieces


class Differing(Filling):
    """Fills the tables where they differ, of a scene in which surfaces are one with the same others as before.

    Every surface takes a record of its own piece, so that the row of this grows as others of the piece do: see
    `exchangeable.apart`.
    """

    def __init__(self, joined: Joined, some: Pieces, laid: Laid) -> None:
        super().__init__(joined, some, laid, (Numbers(None, None), _numbers_of_new(joined, some, laid.ids)))

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


def _numbers_of_new(joined: Joined, pieces: Pieces, own: Ints | None) -> Numbers:
    """The numbers of new surfaces. None is turned over, as they are not one with others."""
    new = joined.laid[1]
    if own is None and new.ids is None:
        return Numbers(None, None)
    ids = np.full(len(joined.sides[1].tables.surface_kind) + 1, -1, np.int32)
    for source, rows, at in pieces.on(SURFACES):
        if source == 1:
            ids[_some(new.ids, rows)] = _some(own, at)
    return Numbers(ids, None)


def _some(ids: Ints | None, rows: slice) -> Any:
    """Some surfaces by the numbers they have in the table."""
    return rows if ids is None else ids[rows]


class LimitsOfNew(Limits):
    """Limits that are others only with new bodies, whose surfaces are nobody else's."""

    def put(self, before: float | None) -> float | None:
        """Those of a body that has an end are what they are for it alone, where all have one."""
        return None if np.isfinite(self.boxes).all() else super().put(before)

    def _changed(self) -> Changed:
        ids = self.columns.ids
        surfaces, owners = np.zeros(len(self.tables.surface_kind), bool), np.zeros(int(self.owners[-1]), bool)
        mine = self._rows(SURFACES)
        surfaces[mine if ids is None else ids[mine]] = True
        for kind, axis in enumerate((CELLS, SHEETS, POLYGONS)):
            owners[self.owners[kind] + self._rows(axis)] = True
        return Changed(surfaces, owners, self._of_rows(*map(self._rows, (CELLS, CELL_PLANES, SHEETS, POLYGONS))))

    def _rows(self, axis: int) -> Longs:
        """The rows of some kind that are new."""
        parts = [np.arange(at.start, at.stop) for source, _, at in self.columns.pieces.on(axis) if source == 1]
        return np.concatenate(parts) if parts else np.zeros(0, np.int64)

    def _unread(self, kind: int) -> Longs:
        """None, as the same records are read as before; those of new ones came without limits."""
        return np.zeros(0, np.int64)
