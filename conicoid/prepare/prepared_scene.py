"""A scene prepared for queries, from scratch or from the scene before an edit; its memory, its exact surfaces."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import field, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np
import numpy.typing as npt

from .._jit.machine_code import SHIPPED, single_call
from .._util.records import dataclass
from ..geometry.body import Body
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
)
from ..kernels.threads import is_brief
from . import lowering
from .bvh.trees import SceneTrees, build_scene_trees
from .coincidence import row_hashes
from .edits.buffer_pool import EditState, OpenBuffer, adopt_buffer
from .lowering import LazyBounds, LoweredScene
from .mmap_arrays import mapped_zeros
from .progress import AFTER_TREES, Progress, ProgressStages

if TYPE_CHECKING:
    from ..geometry.exact_crossings import IntegerForm


@dataclass(frozen=True)
class PreparedScene:
    """A scene prepared for queries: lowered, with its trees. Immutable, but for the dicts `forms` and `sides`.

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
    sides : dict
        Surfaces, rising, through a point that may be a wall -> (`common_rank`, `occurring_sides`) of them.
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
    sides: dict[tuple[int, ...], tuple[int, list[int]]] = field(default_factory=dict, repr=False, compare=False)

    entries: Sequence[Body] = ()  # names and materials come from these
    edit_state: EditState = field(default_factory=EditState, repr=False, compare=False)
    can_be_edited: ClassVar[bool] = True

    @classmethod
    def of(cls, lowered: LoweredScene, bodies: Sequence[Body] = ()) -> PreparedScene:
        """Build the trees of a lowered scene and take over its tables; `bodies` give the names and materials."""
        # A list, since the trees decide when the buffer is made, and how large
        buffers: list[OpenBuffer] = []
        if isinstance(lowered.bounds, LazyBounds):
            from .edits.lattice_edit import first_state, room_for_edits

            geometry, woods, maxima = build_scene_trees(lowered, partial(room_for_edits, buffers))
            lowered = lowered.with_geometry(geometry)
            kept: EditState = first_state(buffers[0], maxima, lowered.tables)
        elif lowered.layout is None:
            geometry, woods, _ = build_scene_trees(lowered)
            lowered, kept = lowered.with_geometry(geometry), EditState()
        else:
            geometry, woods, _ = build_scene_trees(lowered, lambda tables: _reserve(buffers, tables))
            lowered, kept = adopt_buffer(lowered.with_geometry(geometry), buffers[0])
        return cls(lowered, geometry, flat_rest(lowered), woods, entries=bodies, edit_state=kept)

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
        return self.edit_state.has_gaps

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
    def absent_terms(self) -> npt.NDArray[np.int32]:
        """(surfaces,) bits for the terms xx, yy, zz, xy, xz, yz that a quadric lacks, where its record hides that.

        A record has squares along the quadric's own axes: those of x z are (x + z)² - (x - z)². User: rays along the
        axes of sides of GDML's arb8 and twistedtubs, which exact arithmetic decided one by one.
        """
        tables = self.lowered.tables
        found = mapped_zeros(len(tables.surface_kind), np.int32, sparse=True)
        w, s = tables.quadric_forms[:, :9].reshape(-1, 3, 3), tables.quadric_forms[:, 9:12, None]
        terms = np.abs((s * w * w).sum(axis=1)), np.abs(s * w * w).sum(axis=1)
        hides = (terms[0] <= _HIDDEN * terms[1]) & (terms[1] > 0)
        curved = np.flatnonzero(tables.surface_kind == QUADRIC)
        forms = tables.quadrics[tables.surface_row[curved], 3].astype(np.intp)
        chosen = hides.any(axis=1)[forms]
        known: dict[int, int] = {}  # copies share forms
        for surface, form in zip(curved[chosen].tolist(), forms[chosen].tolist(), strict=True):
            if form not in known:
                known[form] = exact_form(self, surface).absent_terms
            found[surface] = known[form]
        return found

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


def prepare(bodies: Sequence[Body], progress: Progress | None = None) -> PreparedScene:
    """Prepare a scene.

    Parameters
    ----------
    bodies : Sequence[Body]
        The entries of the scene.
    progress : Progress, optional
        Called with (entries done, entries in all).
    """
    stages = ProgressStages(progress, len(bodies))
    lowered = lowering.lower(bodies) if progress is None else lowering.lower(bodies, stages)
    scene = PreparedScene.of(lowered, bodies)
    stages.advance(AFTER_TREES)
    return scene


def _reserve(buffers: list[OpenBuffer], tables: Tables) -> Geometry:
    """Reserve a buffer for tables of these shapes, which edited scenes may reuse; append it to a list."""
    buffers.append(OpenBuffer.new(tables))
    geometry = buffers[0].geometry(tables)
    assert geometry is not None
    return geometry


_HIDDEN = 2.0**-40
"""A sum below this share of the sizes of its terms may be 0."""


def flat_rest(lowered: LoweredScene) -> RoundingRest:
    """Flatten the remainders of a lowered scene, as kernels take them."""
    rest = lowered.rest
    return RoundingRest(rest.planes.ravel(), rest.spheres.ravel(), rest.quadrics.ravel(), rest.vertices.ravel())


# --- The memory of a scene, as `conicoid info` prints it

_TREE = (NODE_CHILDREN, TREE_ORDER, TREE_ROOT, ROOTS, TREE_DEPTH)


class Memory(NamedTuple):
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

    primitives: int
    tables: int
    tree: int


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
        from ..geometry.exact_crossings import ball_form, surface_form

        exact = scene.lowered.exact
        if surface < len(exact):
            form = surface_form(exact[surface])
        else:  # a ball, whose form follows from its record in the tables
            x, y, z, r = scene.lowered.tables.spheres[scene.lowered.tables.surface_row[surface]].tolist()
            form = ball_form((x, y, z), r)
        scene.forms[surface] = form
    return form
