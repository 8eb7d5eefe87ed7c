"""A lowered scene from another that it has most bodies in common with: only what is new is lowered.

All tables but those of the trees are those of the scene lowered from the beginning, to the bit.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...geometry.body import Body
from ...kernels.tables import Floats, Geometry, Tables, put_sizes, room_for
from ..body_collector import BodyShapes, ExactBodySurfaces
from ..coincidence import Remainders
from ..lowering import ExactTables, LoweredScene, lower
from ..progress import Progress, ProgressStages
from ..row_layout import BODIES, CORNERS, ENTRIES, FRAMES, PLANES, POLYGONS, QUADRICS, SPHERES, SURFACES
from ..tables_builder import replace_ball_cells
from .buffer_pool import BufferClaim
from .column_splice import ColumnSplice
from .edit_state import EditState
from .in_place import InPlaceEdit
from .in_place_check import complete_state, keeps_classes, keeps_rows
from .limits_update import SpliceLimits
from .pieces import SplicePieces, SpliceRuns
from .scene_splice import SceneSplice
from .surface_classes import SurfaceClasses, neighbour_slots, unchanged_classes, update_classes
from .surface_merge import SurfaceMerge


class SpliceEdit:
    """An edited scene whose tables are still to be filled in: those of `shapes` are as large, but for the trees."""

    keeps_items = False
    in_place = False

    def __init__(
        self, old: LoweredScene, new: LoweredScene, pieces: SplicePieces, bodies: Sequence[Body], kept: EditState
    ) -> None:
        self.joined, self.pieces, self.kept = SceneSplice((old, new), pieces), pieces, kept
        self._exact = _exact(bodies, self.joined)
        merged = SurfaceMerge(self.joined, self._exact).merged(kept.frame, kept.places)
        self.columns = ColumnSplice(self.joined, merged)
        self.merged = merged
        self.boxes: Floats = self.joined.column(BODIES, lambda side: side.boxes, np.float64)
        self.kinds = self.columns.laid.patterns.entries[self.columns.laid.which, 2]  # of entries, for what they cost
        self.shapes: dict[str, Any] = {
            name: np.broadcast_to(np.zeros((), kind), shape) for name, (shape, kind) in self.columns.sizes().items()
        }

    def fill(self, geometry: Geometry, tables: Tables) -> tuple[LoweredScene, EditState]:
        """Write the tables to where there is room for them; trees are left as they are."""
        joined = self.joined
        self.columns.fill(tables)
        direct = replace_ball_cells(tables)
        tables.entry_kind[:], tables.entry_index[:] = direct.entry_kind, direct.entry_index
        rest = Remainders(
            joined.column(PLANES, lambda side: side.rest.planes, np.float64),
            joined.column(SPHERES, lambda side: side.rest.spheres, np.float64),
            joined.column(QUADRICS, lambda side: side.rest.quadrics, np.float64),
            joined.column(CORNERS, lambda side: side.rest.vertices, np.float64),
        )
        size = SpliceLimits(self.columns, tables, self.boxes, rest).put(self.kept.size)
        put_sizes(geometry, tables)
        laid = self.columns.laid
        body_frame = np.empty(len(laid.which), np.int32)
        self.columns.framed(body_frame, FRAMES, [side.body_frame for side in joined.sides])
        counts = np.diff(laid.first_body)
        lowered = LoweredScene(
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
        return lowered, EditState(self.merged.frame, self.merged.places, size)

    def close(self, kept: EditState) -> None:
        """All tables have been written; their memory is nobody's but this scene's."""

    def geometry(self, empty: Tables) -> Geometry:
        """Memory for tables of these shapes."""
        return room_for(empty)


def edit_scene(
    old: LoweredScene,
    bodies: Sequence[Body],
    found: SpliceRuns,
    kept: EditState,
    claim: BufferClaim,
    progress: Progress | None,
) -> SpliceEdit | InPlaceEdit | None:
    """An edited scene that has runs of an old one; None where it is as well lowered from the beginning.

    claim: of the memory that the old one is in.
    """
    if old.laid is None or 2 * len(found.fresh) > len(bodies):
        return None
    there = len(bodies) - len(found.fresh)
    told = progress and (lambda done, _: progress(there + done, len(bodies)))
    new = lower([bodies[number] for number in found.fresh], ProgressStages(told, len(found.fresh))).limited()
    if new.laid is None:
        return None
    pieces = SplicePieces.of(found.pieces, (old.laid, new.laid))
    if keeps_rows(old.laid, new.laid, found, len(bodies)):
        kept, own = complete_state(kept, old, new)
        joined = SceneSplice((old, new), pieces)
        near = neighbour_slots(kept.places, own, joined)
        if not len(near) and keeps_classes(old.laid, new.laid, pieces):
            classes: SurfaceClasses | None = unchanged_classes(joined)
        else:
            classes = update_classes(joined, old.exact.bodies.of(BodyShapes(bodies)), near)
        if classes is not None:
            return InPlaceEdit(joined, bodies, found, kept, own, classes, claim)
    return SpliceEdit(old, new, pieces, bodies, kept)


def _exact(bodies: Sequence[Body], joined: SceneSplice) -> ExactBodySurfaces:
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
    return ExactBodySurfaces(BodyShapes(bodies), starts, firsts[0], firsts[1])
