"""A prepared scene: its tables and trees, and what makes it known again."""

from __future__ import annotations

import weakref
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from ..geometry.body import Body
from ..geometry.exact_crossings import IntegerForm
from ..geometry.instance_labels import body_labels
from ..geometry.instances import InstanceList
from ..geometry.instances_edited import have_same_shapes
from ..geometry.labels import Labels
from ..kernels.surface.exact_crossing import RoundingRest
from ..kernels.tables import LEAF_ITEMS, LINE, Geometry, Tables, unpack_tables
from . import lowering
from .bvh.leaf_items import put_items
from .bvh.tree_patch import patch_trees
from .bvh.trees import SceneTrees, build_scene_trees
from .edits.buffer_pool import BufferClaim, OpenBuffer
from .edits.edit_state import EditState
from .edits.in_place import InPlaceEdit, adopt_buffer, release_memory
from .edits.pieces import find_runs
from .edits.scene_edit import SpliceEdit, edit_scene
from .lowering import LoweredScene
from .progress import AFTER_TREES, Progress, ProgressStages


@dataclass(frozen=True)
class PreparedScene:
    """A scene prepared for queries: lowered, with its trees. Immutable, except that `forms` is filled on demand."""

    lowered: LoweredScene
    geometry: Geometry
    rest: RoundingRest
    woods: SceneTrees = field(repr=False, compare=False)
    forms: dict[int, IntegerForm] = field(
        default_factory=dict, repr=False, compare=False
    )  # surfaces in exact arithmetic

    entries: Sequence[Body] = ()  # they give the names and materials
    kept: EditState = field(default_factory=EditState, repr=False, compare=False)
    can_be_edited: ClassVar[bool] = True

    @classmethod
    def of(cls, lowered: LoweredScene, bodies: Sequence[Body] = ()) -> PreparedScene:
        """Build the trees of a lowered scene, whose tables it takes; `bodies` give the names and materials."""
        if lowered.laid is None:  # which is not edited
            geometry, woods = build_scene_trees(lowered)
            return cls(lowered.sharing(geometry), geometry, _flat_rest(lowered), woods, entries=bodies)
        found: list[OpenBuffer] = []
        geometry, woods = build_scene_trees(lowered, lambda tables: _reserve(found, tables))
        lowered, kept = adopt_buffer(lowered.sharing(geometry), found[0])
        return cls(lowered, geometry, _flat_rest(lowered), woods, entries=bodies, kept=kept)

    def edited(self, bodies: Sequence[Body], progress: Progress | None = None) -> PreparedScene | None:
        """A scene of other bodies, many of them the same; None where it is as well prepared from the beginning."""
        return prepare_edit([self], bodies, progress)

    def labelled(self, bodies: Sequence[Body]) -> PreparedScene:
        """The same shapes with the names and materials of other bodies."""
        return replace(self, entries=bodies)

    @cached_property
    def labels(self) -> Labels:
        """Names and materials by body number."""
        return body_labels(self.entries)

    @cached_property
    def sources(self) -> dict[int, Any]:
        """Surfaces as `scene.surface` and `scene.explain` have worked them out."""
        return {}

    @cached_property
    def kinds(self) -> npt.NDArray[np.int8]:
        """What each body is to light: see `kernels/body/media.py`."""
        return self.labels.kinds(self.lowered.body_count)

    @cached_property
    def key(self) -> bytes:
        """Whose the numbers of surfaces are: scenes with one key have the same surfaces by the same numbers."""
        from hashlib import blake2b

        tables, rest = self.lowered.tables, self.lowered.rest
        surfaces = (tables.surface_kind, tables.surface_row, tables.planes, tables.spheres, tables.quadrics)
        digest = blake2b(digest_size=16)
        for array in (*surfaces, tables.quadric_forms, rest.planes, rest.spheres, rest.quadrics):
            digest.update(str(array.shape).encode())
            digest.update(np.ascontiguousarray(array).data.cast("B") if array.size else b"")
        return digest.digest()


def prepare(
    bodies: Sequence[Body], before: list[PreparedScene] | None = None, progress: Progress | None = None
) -> PreparedScene:
    """Prepare a scene; from the one that it was made from, if that is known and has enough in common.

    before: that one, or none. It is taken out of the list: where nobody else has it, it is written over.
    """
    made = prepare_edit(before, bodies, progress) if before else None
    if made is None:
        stages = ProgressStages(progress, len(bodies))
        lowered = lowering.lower(bodies) if progress is None else lowering.lower(bodies, stages)
        made = PreparedScene.of(lowered, bodies)
        stages.reached(AFTER_TREES)
    return made


def prepare_edit(
    before: list[PreparedScene], bodies: Sequence[Body], progress: Progress | None = None
) -> PreparedScene | None:
    """`Prepared.edited`, of the one that is taken out of a list."""
    old = before.pop()
    if not old.can_be_edited or isinstance(old.entries, InstanceList) or isinstance(bodies, InstanceList):
        return old.labelled(bodies) if have_same_shapes(old.entries, bodies) else None
    found = find_runs(old.entries, bodies)
    if not found.fresh and len(bodies) == len(old.entries):
        return old.labelled(bodies)
    kept, woods, known = old.kept, old.woods, weakref.ref(old)
    lowered = release_memory(old.lowered, old.geometry, kept.memory) if kept.memory else old.lowered
    del old
    claim = kept.memory.claim() if kept.memory else BufferClaim()
    made = edit_scene(lowered, bodies, found, kept, claim, progress) if claim else None
    if made is None:
        return None
    there = known()
    if there is not None:
        vars(there)["kept"] = made.kept
    return _finish_edit(made, lowered.tables, woods, bodies)


def _finish_edit(
    made: SpliceEdit | InPlaceEdit, old: Tables, woods: SceneTrees, bodies: Sequence[Body]
) -> PreparedScene:
    """An edited scene with its trees; tables and woods of the old one."""
    trees = patch_trees(old, woods, made)
    if made.in_place:
        trees.apart()
    empty = Tables(**made.shapes, **trees.tables)
    geometry = made.geometry(empty)
    tables = unpack_tables(empty, geometry)
    for name, column in trees.tables.items():
        if name not in ("node_boxes", "leaf_items"):
            getattr(tables, name)[...] = column
    trees.put_boxes(tables.node_boxes)
    lowered, kept = made.fill(geometry, tables)
    trees.keep_items(tables, None if made.in_place else old)
    end = int(geometry.places[LEAF_ITEMS]) + tables.leaf_items.size
    geometry.floats[end : end + -end % LINE] = 0.0  # up to the next table, whatever was there
    put_items(geometry, lowered.boxes, int(trees.woods.places[-1]), trees.parts)
    made.close(kept)
    return PreparedScene(lowered, geometry, _flat_rest(lowered), trees.woods, entries=bodies, kept=kept)


def _reserve(found: list[OpenBuffer], tables: Tables) -> Geometry:
    """Memory for tables of these shapes that edited scenes may take."""
    found.append(OpenBuffer.new(tables))
    made = found[0].geometry(tables)
    assert made is not None
    return made


def _flat_rest(lowered: LoweredScene) -> RoundingRest:
    """What rounding took, as kernels take it."""
    rest = lowered.rest
    return RoundingRest(rest.planes.ravel(), rest.spheres.ravel(), rest.quadrics.ravel(), rest.vertices.ravel())
