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

from ....shapes.body import Body
from ...tables import Floats, Geometry, Tables, put_sizes, shared
from .. import ExactTables, Lowered
from ..contents import ShapesOf
from ..laid import BODIES, CORNERS, FRAMES, PLANES, QUADRICS, SPHERES, SURFACES, Laid
from ..surfaces import Remainders
from .columns import TREES
from .differing import Differing, LimitsOfNew
from .joined import Joined
from .kept import Kept, Known
from .near import Places
from .pieces import Pieces, Runs
from .stores import Opened, restamped, stamped

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


class Exchange:
    """A scene some of whose entries are exchanged, in the memory of one that is gone, or in new memory.

    Only where `exchangeable` says that this may be.
    """

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
        columns, (old, _) = Differing(joined, self._some, self._laid), joined.sides
        columns.fill(tables)
        rest = Remainders(beside["planes"], beside["spheres"], beside["quadrics"], beside["vertices"])
        size = LimitsOfNew(columns, tables, self.boxes, rest).put(kept.size)
        put_sizes(geometry, tables)
        body_frame = old.body_frame.copy()
        columns.framed(body_frame, FRAMES, [side.body_frame for side in joined.sides])
        lowered = dataclasses.replace(
            old, tables=tables, boxes=self.boxes, frames=beside["frames"], body_frame=body_frame,
            face_paint=joined.paint(), rest=rest, laid=self._laid,
            exact=ExactTables(old.exact.bodies.of(ShapesOf(self._bodies)), old.exact.single),
        )  # fmt: skip
        same = size == kept.size
        stamps = restamped(kept.stamps, self._fresh) if same else stamped(len(kept.stamps))
        places = Places.marked(*(column for name, column in beside.items() if name.startswith(("place", "mark"))))
        return lowered, Known(kept.frame, places, size, stores=kept.stores, stamps=stamps)

    def close(self, kept: Kept) -> None:
        """All tables have been written, those of trees too; `kept` is what `fill` returned.

        Only from here on does the memory go to others when the scene is gone. That of one that is broken off before
        goes to nobody: what is in its rows is told by no stamps.
        """
        assert isinstance(kept, Known)
        assert self._opened is not None
        self._opened.close(kept.stores, kept.stamps)


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
