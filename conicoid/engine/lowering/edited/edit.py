"""A lowered scene from another that it has most bodies in common with: only what is new is lowered.

All tables but those of the trees are those of the scene lowered from the beginning, to the bit.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ....shapes.body import Body
from ...tables import Floats, Geometry, Tables, put_sizes, room_for
from .. import ExactTables, Lowered, lower
from ..contents import Exact, ShapesOf
from ..laid import BODIES, CORNERS, ENTRIES, FRAMES, PLANES, POLYGONS, QUADRICS, SPHERES, SURFACES
from ..layout import balls_direct
from ..stages import Progress, Stages
from ..surfaces import Remainders
from .columns import Columns
from .exchange import Exchange
from .exchangeable import apart, completed, keeps_rows
from .joined import Joined
from .kept import Kept
from .limits import LimitsOfEdited
from .merging import Merging
from .pieces import Pieces, Runs
from .regrouped import Regrouped, as_before, near_slots, regrouped
from .stores import Claim


class Edit:
    """An edited scene whose tables are still to be filled in: those of `shapes` are as large, but for the trees."""

    keeps_items = False
    in_place = False

    def __init__(self, old: Lowered, new: Lowered, pieces: Pieces, bodies: Sequence[Body], kept: Kept) -> None:
        self.joined, self.pieces, self.kept = Joined((old, new), pieces), pieces, kept
        self._exact = _exact(bodies, self.joined)
        merged = Merging(self.joined, self._exact).merged(kept.frame, kept.places)
        self.columns = Columns(self.joined, merged)
        self.merged = merged
        self.boxes: Floats = self.joined.column(BODIES, lambda side: side.boxes, np.float64)
        self.kinds = self.columns.laid.patterns.entries[self.columns.laid.which, 2]  # of entries, for what they cost
        self.shapes: dict[str, Any] = {
            name: np.broadcast_to(np.zeros((), kind), shape) for name, (shape, kind) in self.columns.sizes().items()
        }

    def fill(self, geometry: Geometry, tables: Tables) -> tuple[Lowered, Kept]:
        """Write the tables to where there is room for them; trees are left as they are."""
        joined = self.joined
        self.columns.fill(tables)
        direct = balls_direct(tables)
        tables.entry_kind[:], tables.entry_index[:] = direct.entry_kind, direct.entry_index
        rest = Remainders(
            joined.column(PLANES, lambda side: side.rest.planes, np.float64),
            joined.column(SPHERES, lambda side: side.rest.spheres, np.float64),
            joined.column(QUADRICS, lambda side: side.rest.quadrics, np.float64),
            joined.column(CORNERS, lambda side: side.rest.vertices, np.float64),
        )
        size = LimitsOfEdited(self.columns, tables, self.boxes, rest).put(self.kept.size)
        put_sizes(geometry, tables)
        laid = self.columns.laid
        body_frame = np.empty(len(laid.which), np.int32)
        self.columns.framed(body_frame, FRAMES, [side.body_frame for side in joined.sides])
        counts = np.diff(laid.first_body)
        lowered = Lowered(
            tables,
            self.boxes,
            joined.column(FRAMES, lambda side: side.frames, np.float64),
            body_frame,
            np.repeat(np.arange(len(counts), dtype=np.int32), counts),
            joined.paint(),
            len(laid.which),
            rest,
            ExactTables(self._exact, self.columns.single),
            laid,
        )
        return lowered, Kept(self.merged.frame, self.merged.places, size)

    def close(self, kept: Kept) -> None:
        """All tables have been written; their memory is nobody's but this scene's."""

    def geometry(self, empty: Tables) -> Geometry:
        """Memory for tables of these shapes."""
        return room_for(empty)


def edit(
    old: Lowered, bodies: Sequence[Body], found: Runs, kept: Kept, claim: Claim, progress: Progress | None
) -> Edit | Exchange | None:
    """An edited scene that has runs of an old one; None where it is as well lowered from the beginning.

    claim: of the memory that the old one is in.
    """
    if old.laid is None or 2 * len(found.fresh) > len(bodies):
        return None
    there = len(bodies) - len(found.fresh)
    told = progress and (lambda done, _: progress(there + done, len(bodies)))
    new = lower([bodies[number] for number in found.fresh], Stages(told, len(found.fresh))).limited()
    if new.laid is None:
        return None
    pieces = Pieces.of(found.pieces, (old.laid, new.laid))
    if keeps_rows(old.laid, new.laid, found, len(bodies)):
        kept, own = completed(kept, old, new)
        joined = Joined((old, new), pieces)
        near = near_slots(kept.places, own, joined)
        if not len(near) and apart(old.laid, new.laid, pieces):
            classes: Regrouped | None = as_before(joined)
        else:
            classes = regrouped(joined, old.exact.bodies.of(ShapesOf(bodies)), near)
        if classes is not None:
            return Exchange(joined, bodies, found, kept, own, classes, claim)
    return Edit(old, new, pieces, bodies, kept)


def _exact(bodies: Sequence[Body], joined: Joined) -> Exact:
    """The exact surfaces of bodies, on demand."""
    pieces, firsts = joined.pieces, []
    for axis in (SURFACES, POLYGONS):
        first = np.zeros(int(pieces.total[BODIES]), np.int64)
        for source, rows, at, shift in pieces.moved(BODIES, axis):
            first[at] = joined.laid[source].starts(axis)[rows] + shift
        firsts.append(first)
    starts = np.zeros(len(bodies), np.int64)
    for source, rows, at, shift in pieces.moved(ENTRIES, BODIES):
        starts[at] = joined.laid[source].first_body[rows] + shift
    return Exact(ShapesOf(bodies), starts, firsts[0], firsts[1])
