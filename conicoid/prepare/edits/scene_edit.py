"""Lower an edited scene from the scene before: only new entries are lowered, the rest is spliced or overwritten.

All tables but those of the trees equal, to the bit, those of the scene lowered from scratch.
"""

from __future__ import annotations

import weakref
from collections.abc import Sequence
from typing import Any

import numpy as np

from ...geometry.body import Body
from ...geometry.instance_edits import exchanged_entries, have_same_shapes
from ...geometry.instances import InstanceList
from ...kernels.tables import LEAF_ITEMS, LINE, Floats, Geometry, Tables, put_sizes, room_for, unpack_tables
from ..body_collector import BodyShapes, ExactBodySurfaces
from ..bvh.leaf_items import put_items
from ..bvh.tree_patch import patch_trees, put_new_groups
from ..bvh.trees import SceneTrees
from ..lowering import ExactTables, LoweredScene, lower
from ..prepared_scene import PreparedScene, flat_rest
from ..progress import Progress, ProgressStages
from ..row_layout import BODIES, CORNERS, ENTRIES, FRAMES, PLANES, POLYGONS, QUADRICS, SPHERES, SURFACES
from ..surface_features import Remainders
from ..tables_builder import replace_ball_cells
from .buffer_pool import BufferClaim, EditState, complete_state, keeps_classes, keeps_rows, release_memory
from .column_splice import ColumnSplice
from .in_place import InPlaceEdit
from .lattice_edit import LatticeState, edit_lattice, without_memory
from .limits_update import SpliceLimits
from .scene_splice import SceneSplice, SplicePieces, SpliceRuns, find_runs
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


# From a prepared scene to a prepared scene


def prepare_edit(
    before: list[PreparedScene], bodies: Sequence[Body], progress: Progress | None = None
) -> PreparedScene | None:
    """Prepare a scene from the scene before an edit, which shares most with it.

    Parameters
    ----------
    before : list[PreparedScene]
        One scene. It is removed from the list: where nobody else holds it, its memory is overwritten.
    bodies : Sequence[Body]
        The entries of the edited scene.
    progress : Progress, optional
        Called with (entries done, entries in all).

    Returns
    -------
    PreparedScene or None
        None where a fresh preparation is as quick.
    """
    # The list held the last reference of the caller: only then may memory be overwritten
    old = before.pop()
    # Instances have shared tables, which cannot be spliced: only their labels can change.
    if not old.can_be_edited or isinstance(old.entries, InstanceList) or isinstance(bodies, InstanceList):
        if have_same_shapes(old.entries, bodies):
            return old.labelled(bodies)
        state, entries = old.edit_state, old.entries
        if not (isinstance(state, LatticeState) and isinstance(entries, InstanceList)):
            return None
        found = exchanged_entries(entries, bodies) if isinstance(bodies, InstanceList) else None
        if found is None or not isinstance(bodies, InstanceList):
            return None
        lowered, places, woods = without_memory(old.lowered), old.geometry.places, old.woods
        del old  # nothing here reads its memory any more
        edited = edit_lattice(lowered, places, woods, state, entries, bodies, found)
        if edited is None:
            return None
        lowered, geometry, woods, state = edited
        return PreparedScene(lowered, geometry, flat_rest(lowered), woods, entries=bodies, edit_state=state)
    runs = find_runs(old.entries, bodies)
    # Other names or materials alone: all tables stay
    if not runs.fresh and len(bodies) == len(old.entries):
        return old.labelled(bodies)
    kept, woods, reference = old.edit_state, old.woods, weakref.ref(old)
    lowered = release_memory(old.lowered, old.geometry, kept.memory) if kept.memory else old.lowered
    # The last strong reference here: afterwards `reference` tells whether somebody else holds the scene.
    del old
    claim = kept.memory.claim() if kept.memory else BufferClaim()
    edit = edit_scene(lowered, bodies, runs, kept, claim, progress) if claim else None
    if edit is None:
        return None
    holder = reference()
    if holder is not None:
        # Somebody holds the old scene, whose next edit must not reuse memory that this one has taken
        vars(holder)["edit_state"] = edit.edit_state
    return _finish_edit(edit, lowered.tables, woods, bodies)


def _finish_edit(
    edit: SpliceEdit | InPlaceEdit, old: Tables, woods: SceneTrees, bodies: Sequence[Body]
) -> PreparedScene:
    """Complete an edited scene with its trees; `old` and `woods` are the tables and trees of the scene before."""
    trees = patch_trees(old, woods, edit)
    # The boxes of nodes are views of the memory that is about to be overwritten.
    if edit.in_place:
        trees.copy_boxes()
    empty = Tables(**edit.shapes, **trees.tables)
    geometry = edit.geometry(empty)
    tables = unpack_tables(empty, geometry)
    for name, column in trees.tables.items():
        if name not in ("node_boxes", "leaf_items"):
            getattr(tables, name)[...] = column
    trees.put_boxes(tables.node_boxes)
    lowered, kept = edit.fill(geometry, tables)
    trees.keep_items(tables, None if edit.in_place else old)
    end = int(geometry.places[LEAF_ITEMS]) + tables.leaf_items.size
    geometry.floats[end : end + -end % LINE] = 0.0  # zero the padding up to the next table
    put_items(geometry, lowered.boxes, int(trees.woods.places[-1]), trees.parts)
    put_new_groups(geometry, edit)
    edit.close(kept)
    return PreparedScene(lowered, geometry, flat_rest(lowered), trees.woods, entries=bodies, edit_state=kept)
