"""A scene prepared for queries, from scratch or from the scene before an edit; its memory, its exact surfaces."""

from __future__ import annotations

import weakref
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np
import numpy.typing as npt

from .._jit.machine_code import SHIPPED, single_call
from ..geometry.body import Body
from ..geometry.exact_crossings import IntegerForm, ball_form, surface_form
from ..geometry.instance_edits import have_same_shapes
from ..geometry.instances import InstanceList
from ..geometry.labels import Labels, body_labels
from ..kernels.surface.exact_crossing import RoundingRest
from ..kernels.tables import (
    ENTRY_KIND,
    LEAF_CELL,
    LEAF_ITEMS,
    LENGTHS,
    LINE,
    NODE_BOXES,
    NODE_CHILDREN,
    PLANE,
    PROGRAM_ROW,
    PROGRAM_SHIFTS,
    QUADRIC,
    REGION,
    ROOTS,
    SHIFT_SIZE,
    SPARE,
    SPHERE,
    TREE_DEPTH,
    TREE_ORDER,
    TREE_ROOT,
    Geometry,
    Tables,
    length,
    unpack_tables,
)
from ..kernels.threads import is_brief
from . import lowering
from .bvh.leaf_items import put_items
from .bvh.tree_patch import patch_trees, put_new_groups
from .bvh.trees import SceneTrees, build_scene_trees
from .coincidence import row_hashes
from .edits.buffer_pool import BufferClaim, EditState, OpenBuffer
from .edits.in_place import InPlaceEdit, adopt_buffer, release_memory
from .edits.lattice_edit import (
    LatticeState,
    edit_lattice,
    exchanged_entries,
    first_state,
    room_for_edits,
    without_memory,
)
from .edits.scene_edit import SpliceEdit, edit_scene
from .edits.scene_splice import find_runs
from .lowering import LazyBounds, LoweredScene
from .progress import AFTER_TREES, Progress, ProgressStages


@dataclass(frozen=True)
class PreparedScene:
    """A scene prepared for queries: lowered, with its trees. Immutable, except that `forms` is filled on demand.

    Parameters
    ----------
    lowered : LoweredScene
        The tables, boxes and frames.
    geometry : Geometry
        The tables packed for kernels.
    rest : RoundingRest
        What rounding removed from the surface records, flat, as kernels take it.
    woods : SceneTrees
        Where the trees end in the tables, for edits.
    forms : dict
        Row of a surface -> its polynomial in integers, for exact crossings.
    entries : Sequence[Body]
        The entries of the scene, which give names and materials.
    edit_state : EditState
        What the next edit needs to know about this scene.
    """

    lowered: LoweredScene
    geometry: Geometry
    rest: RoundingRest
    woods: SceneTrees = field(repr=False, compare=False)
    forms: dict[int, IntegerForm] = field(default_factory=dict, repr=False, compare=False)  # surface -> its exact form

    entries: Sequence[Body] = ()  # names and materials come from these
    edit_state: EditState = field(default_factory=EditState, repr=False, compare=False)
    can_be_edited: ClassVar[bool] = True

    @classmethod
    def of(cls, lowered: LoweredScene, bodies: Sequence[Body] = ()) -> PreparedScene:
        """Build the trees of a lowered scene and take over its tables; `bodies` give the names and materials."""
        # A list, since the trees decide when the buffer is made, and how large
        buffers: list[OpenBuffer] = []
        if isinstance(lowered.bounds, LazyBounds):
            geometry, woods, maxima = build_scene_trees(lowered, partial(room_for_edits, buffers))
            lowered = lowered.with_geometry(geometry)
            kept: EditState = first_state(buffers[0], maxima, lowered.tables)
        elif lowered.layout is None:
            geometry, woods, _ = build_scene_trees(lowered)
            lowered, kept = lowered.with_geometry(geometry), EditState()
        else:
            geometry, woods, _ = build_scene_trees(lowered, lambda tables: _reserve(buffers, tables))
            lowered, kept = adopt_buffer(lowered.with_geometry(geometry), buffers[0])
        return cls(lowered, geometry, _flat_rest(lowered), woods, entries=bodies, edit_state=kept)

    def edited(self, bodies: Sequence[Body], progress: Progress | None = None) -> PreparedScene | None:
        """Return a scene of other bodies that shares most with this one; None where a fresh preparation is as quick."""
        return prepare_edit([self], bodies, progress)

    def labelled(self, bodies: Sequence[Body]) -> PreparedScene:
        """Return this scene with the names and materials of other bodies, which have the same shapes."""
        return replace(self, entries=bodies)

    @cached_property
    def labels(self) -> Labels:
        """Return names and materials by body number."""
        return body_labels(self.entries)

    @cached_property
    def sources(self) -> dict[int, Any]:
        """Surfaces that `scene.surface` and `scene.explain` have computed."""
        return {}

    @cached_property
    def single_calls(self) -> dict[str, Callable[..., Any]]:
        """Functions (scene, *numbers) that answer queries of few rays or points, by names of queries."""
        return {}

    @property
    def has_gaps(self) -> bool:
        """Return whether edits have left rows in the tables that nobody reads."""
        return isinstance(self.edit_state, LatticeState) and bool(self.edit_state.loose)

    def keep_single_calls(self, query: str, answer: Callable[..., Any], *kernels: tuple[Any, ...]) -> None:
        """Let `answer(calls, scene, *numbers)` answer a query of few rays or points, by calls of kernels."""
        self.single_calls[query] = partial(answer, [single_call(*kernel) for kernel in kernels])

    def lacks_single_calls(self, query: str) -> bool:
        """Return whether there could be such an answer.

        There is none without machine code, or where one ray may take so long that Ctrl-C must stop it.
        """
        return query not in self.single_calls and SHIPPED is not None and is_brief(self.geometry)

    @cached_property
    def kinds(self) -> npt.NDArray[np.int8]:
        """(bodies,) what each body is to light, as `Labels.kinds` defines it."""
        return self.labels.kinds(self.lowered.body_count)

    @cached_property
    def material_columns(self) -> npt.NDArray[np.int32]:
        """(bodies,) the place of each body's material in `labels.distinct`."""
        materials = [material for material, _ in self.labels.distinct]
        return self.labels.columns_of(np.arange(self.lowered.body_count), materials).astype(np.int32)

    @cached_property
    def key(self) -> bytes:
        """A digest of all surfaces: scenes with equal keys have the same surfaces under the same numbers."""
        from hashlib import blake2b

        tables, rest = self.lowered.tables, self.lowered.rest
        flat, round_, curved = (
            tables.surface_row[tables.surface_kind == kind] for kind in (PLANE, SPHERE, QUADRIC)
        )  # fmt: skip
        # Copies share forms, and edits leave rows that no surface has: a digest of each form, by surfaces
        forms = row_hashes(np.concatenate([tables.quadric_forms, rest.quadrics], axis=1))
        surfaces = tables.surface_kind, tables.planes[flat], tables.spheres[round_], tables.quadrics[curved, :3]
        rests = rest.planes[flat], rest.spheres[round_[round_ < len(rest.spheres)]]
        digest = blake2b(digest_size=16)
        for array in (*surfaces, forms[tables.quadrics[curved, 3].astype(np.intp)], *rests):
            # The shapes too: two tables of other lengths may have the same bytes in a row
            digest.update(str(array.shape).encode())
            digest.update(np.ascontiguousarray(array).data.cast("B") if array.size else b"")
        return digest.digest()


def prepare(
    bodies: Sequence[Body], before: list[PreparedScene] | None = None, progress: Progress | None = None
) -> PreparedScene:
    """Prepare a scene, from the scene before an edit where both have enough in common.

    Parameters
    ----------
    bodies : Sequence[Body]
        The entries of the scene.
    before : list[PreparedScene], optional
        At most one scene. It is removed from the list: where nobody else holds it, its memory is overwritten.
    progress : Progress, optional
        Called with (entries done, entries in all).
    """
    scene = prepare_edit(before, bodies, progress) if before else None
    if scene is None:
        stages = ProgressStages(progress, len(bodies))
        lowered = lowering.lower(bodies) if progress is None else lowering.lower(bodies, stages)
        scene = PreparedScene.of(lowered, bodies)
        stages.advance(AFTER_TREES)
    return scene


def prepare_edit(
    before: list[PreparedScene], bodies: Sequence[Body], progress: Progress | None = None
) -> PreparedScene | None:
    """Take the one scene out of a list and return `PreparedScene.edited` of it, or None as that does."""
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
        return PreparedScene(lowered, geometry, _flat_rest(lowered), woods, entries=bodies, edit_state=state)
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
    return PreparedScene(lowered, geometry, _flat_rest(lowered), trees.woods, entries=bodies, edit_state=kept)


def _reserve(buffers: list[OpenBuffer], tables: Tables) -> Geometry:
    """Reserve a buffer for tables of these shapes, which edited scenes may reuse; append it to a list."""
    buffers.append(OpenBuffer.new(tables))
    geometry = buffers[0].geometry(tables)
    assert geometry is not None
    return geometry


def _flat_rest(lowered: LoweredScene) -> RoundingRest:
    """Flatten the remainders of a lowered scene, as kernels take them."""
    rest = lowered.rest
    return RoundingRest(rest.planes.ravel(), rest.spheres.ravel(), rest.quadrics.ravel(), rest.vertices.ravel())


# --- The memory of a scene, as `conicoid info` prints it

_HINTS = {
    **dict.fromkeys(("total", "bytes", "nbytes", "size", "all"), "memory.tables + memory.tree are all bytes"),
    "cells": "it is called primitives",
}
_TREE = (NODE_CHILDREN, TREE_ORDER, TREE_ROOT, ROOTS, TREE_DEPTH)


class _Sizes(NamedTuple):
    primitives: int
    tables: int
    tree: int


class Memory(_Sizes):
    """Bytes of the arrays that hold a prepared scene.

    Attributes
    ----------
    primitives : int
        Number of balls, sheets, and primitives that are bodies or parts of Boolean bodies.
    tables : int
        Bytes of the tables of these.
    tree : int
        Bytes of the tree of boxes over them.
    """

    __slots__ = ()

    if not TYPE_CHECKING:  # type checkers would accept any name otherwise

        def __getattr__(self, name: str) -> Any:
            hint = f": {_HINTS[name]}" if name in _HINTS else ""
            raise AttributeError(f"'Memory' object has no attribute {name[:80]!r}{hint}", name=name, obj=self)


def measure_memory(scene: PreparedScene) -> Memory:
    """Measure the memory of a scene."""
    geometry = scene.geometry
    # All tables are parts of two arrays, some with room behind each
    sizes, real = (
        geometry.places[LENGTHS : 2 * LENGTHS],
        np.array([column.dtype == np.float64 for column in scene.lowered.tables]),
    )
    floats = int((-(-sizes[real] // LINE) * LINE).sum()) + SPARE
    every = int(sizes[~real].sum()) * geometry.integers.itemsize + floats * geometry.floats.itemsize
    boxes = int(length(geometry, NODE_BOXES) + length(geometry, LEAF_ITEMS)) * geometry.floats.itemsize
    tree = boxes + sum(int(length(geometry, k)) for k in _TREE) * geometry.integers.itemsize
    first, count = int(geometry.places[ENTRY_KIND]), int(length(geometry, ENTRY_KIND))
    regions = int(np.count_nonzero(geometry.integers[first : first + count] == REGION))
    return Memory(count - regions + _leaves(geometry), every - tree, tree)


def _leaves(geometry: Geometry) -> int:
    """Count the leaves of all programs."""
    rows, row = (
        geometry.integers[int(geometry.places[k]) :][: int(length(geometry, k))] for k in (PROGRAM_SHIFTS, PROGRAM_ROW)
    )
    if not len(rows):
        return int(length(geometry, LEAF_CELL))
    return int(np.diff(row)[rows.reshape(-1, SHIFT_SIZE)[:, -1]].sum())


# --- Exact forms of surfaces, each computed on first use


def exact_form(scene: PreparedScene, surface: int) -> IntegerForm:
    """Return the exact form of a surface, which `scene.forms` caches."""
    form = scene.forms.get(surface)
    if form is None:
        exact = scene.lowered.exact
        if surface < len(exact):
            form = surface_form(exact[surface])
        else:  # a ball, whose form follows from its record in the tables
            x, y, z, r = scene.lowered.tables.spheres[scene.lowered.tables.surface_row[surface]].tolist()
            form = ball_form((x, y, z), r)
        scene.forms[surface] = form
    return form
