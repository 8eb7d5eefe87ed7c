"""Lower an edited scene from the scene before: only new entries are lowered, the rest is spliced or overwritten.

All tables but those of the trees equal, to the bit, those of the scene lowered from scratch.
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
from .buffer_pool import BufferClaim, EditState, complete_state, keeps_classes, keeps_rows
from .column_splice import ColumnSplice
from .in_place import InPlaceEdit
from .limits_update import SpliceLimits
from .scene_splice import SceneSplice, SplicePieces, SpliceRuns
from .surface_classes import SurfaceClasses, neighbour_slots, unchanged_classes, update_classes
from .surface_merge import SurfaceMerge


class SpliceEdit:
    """An edited scene in new memory; `shapes` are those of its tables, without trees, until `fill` writes them."""

    keeps_items = False
    in_place = False

    def __init__(
        self, old: LoweredScene, new: LoweredScene, pieces: SplicePieces, bodies: Sequence[Body], edit_state: EditState
    ) -> None:
        self.splice, self.pieces, self.edit_state = SceneSplice((old, new), pieces), pieces, edit_state
        self._exact = _exact(bodies, self.splice)
        merged = SurfaceMerge(self.splice, self._exact).merge_all(edit_state.frame, edit_state.places)
        self.columns = ColumnSplice(self.splice, merged)
        self.merge_result = merged
        self.boxes: Floats = self.splice.column(BODIES, lambda side: side.boxes, np.float64)
        # Of entries, for the costs of the tree
        self.kinds = self.columns.layout.patterns.entries[self.columns.layout.which, 2]
        self.shapes: dict[str, Any] = {
            name: np.broadcast_to(np.zeros((), kind), shape) for name, (shape, kind) in self.columns.sizes().items()
        }

    def fill(self, geometry: Geometry, tables: Tables) -> tuple[LoweredScene, EditState]:
        """Write the tables into allocated memory; trees are left as they are."""
        splice = self.splice
        self.columns.fill(tables)
        # Cells that are a single sphere become balls, as in a fresh preparation.
        direct = replace_ball_cells(tables)
        tables.entry_kind[:], tables.entry_index[:] = direct.entry_kind, direct.entry_index
        rest = Remainders(
            splice.column(PLANES, lambda side: side.rest.planes, np.float64),
            splice.column(SPHERES, lambda side: side.rest.spheres, np.float64),
            splice.column(QUADRICS, lambda side: side.rest.quadrics, np.float64),
            splice.column(CORNERS, lambda side: side.rest.vertices, np.float64),
        )
        size = SpliceLimits(self.columns, tables, self.boxes, rest).put(self.edit_state.size)
        put_sizes(geometry, tables)
        laid = self.columns.layout
        body_frame = np.empty(len(laid.which), np.int32)
        self.columns.framed(body_frame, FRAMES, [side.body_frame for side in splice.sides])
        counts = np.diff(laid.first_body)
        lowered = LoweredScene(
            tables,
            self.boxes,
            splice.column(FRAMES, lambda side: side.frames, np.float64),
            body_frame,
            np.repeat(np.arange(len(counts), dtype=np.int32), counts),
            splice.paint(),
            len(laid.which),
            rest,
            ExactTables(self._exact, self.columns.single),
            laid,
        )
        return lowered, EditState(self.merge_result.frame, self.merge_result.places, size)

    def close(self, edit_state: EditState) -> None:
        """All tables are written; nothing to do, because their memory belongs to this scene alone."""

    def geometry(self, empty: Tables) -> Geometry:
        """Allocate memory for tables of these shapes."""
        return room_for(empty)


def edit_scene(
    old: LoweredScene,
    bodies: Sequence[Body],
    runs: SpliceRuns,
    edit_state: EditState,
    claim: BufferClaim,
    progress: Progress | None,
) -> SpliceEdit | InPlaceEdit | None:
    """Start an edit of a scene.

    Parameters
    ----------
    old : LoweredScene
        The scene before.
    bodies : Sequence[Body]
        All entries of the new scene.
    runs : SpliceRuns
        Which of them come from the old scene.
    edit_state : EditState
        The edit state of the old scene.
    claim : BufferClaim
        On the memory of the old scene.
    progress : Progress, optional
        Called with (entries done, entries in all).

    Returns
    -------
    SpliceEdit, InPlaceEdit or None
        An edit whose tables are still to be written; None where a fresh preparation is as quick.
    """
    # With more new entries than old ones a splice gains nothing.
    if old.layout is None or 2 * len(runs.fresh) > len(bodies):
        return None
    there = len(bodies) - len(runs.fresh)
    report = progress and (lambda done, _: progress(there + done, len(bodies)))
    new = lower([bodies[number] for number in runs.fresh], ProgressStages(report, len(runs.fresh))).limited()
    if new.layout is None:
        return None
    pieces = SplicePieces.of(runs.pieces, (old.layout, new.layout))
    if keeps_rows(old.layout, new.layout, runs, len(bodies)):
        edit_state, own = complete_state(edit_state, old, new)
        splice = SceneSplice((old, new), pieces)
        near = neighbour_slots(edit_state.places, own, splice)
        # No surface coincides with others, before or after: all classes stay.
        if not len(near) and keeps_classes(old.layout, new.layout, pieces):
            classes: SurfaceClasses | None = unchanged_classes(splice)
        else:
            classes = update_classes(splice, old.exact.bodies.of(BodyShapes(bodies)), near)
        if classes is not None:
            return InPlaceEdit(splice, bodies, runs, edit_state, own, classes, claim)
    return SpliceEdit(old, new, pieces, bodies, edit_state)


def _exact(bodies: Sequence[Body], splice: SceneSplice) -> ExactBodySurfaces:
    """Return the exact surfaces of the new scene's bodies, on demand."""
    pieces, firsts = splice.pieces, []
    for axis in (SURFACES, POLYGONS):
        first = np.zeros(int(pieces.total[BODIES]), np.int64)
        for source, rows, at, shift in pieces.moved(BODIES, axis):
            first[at] = splice.layouts[source].starts(axis)[rows] + shift
        firsts.append(first)
    starts = np.zeros(len(bodies), np.int64)
    for source, rows, at, shift in pieces.moved(ENTRIES, BODIES):
        starts[at] = splice.layouts[source].first_body[rows] + shift
    return ExactBodySurfaces(BodyShapes(bodies), starts, firsts[0], firsts[1])
