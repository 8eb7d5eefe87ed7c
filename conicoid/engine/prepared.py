"""A prepared scene: its tables and trees, and what makes it known again."""

from __future__ import annotations

import weakref
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from ..exact.forms import Form
from ..shapes.body import Body
from ..shapes.labels import Labels
from ..shapes.repeated import Repeated
from ..shapes.repeated_edited import same_shapes
from ..shapes.repeated_labels import labels_of
from . import lowering
from .lowering import Lowered
from .lowering.edited.edit import Edit, edit
from .lowering.edited.exchange import Exchange, in_store, let_go
from .lowering.edited.kept import Kept
from .lowering.edited.pieces import runs
from .lowering.edited.stores import Claim, Opened
from .lowering.stages import PLANTED, Progress, Stages
from .surface.decide import Rest
from .tables import LEAF_ITEMS, LINE, Geometry, Tables, shared
from .tree.build import Woods, with_trees
from .tree.build.leaf_items import put_items
from .tree.build.patched import patched


@dataclass(frozen=True)
class Prepared:
    """A scene prepared for queries: lowered, with its trees. Immutable, except that `forms` is filled on demand."""

    lowered: Lowered
    geometry: Geometry
    rest: Rest
    woods: Woods = field(repr=False, compare=False)
    forms: dict[int, Form] = field(default_factory=dict, repr=False, compare=False)  # surfaces in exact arithmetic

    entries: Sequence[Body] = ()  # they give the names and materials
    kept: Kept = field(default_factory=Kept, repr=False, compare=False)
    can_be_edited: ClassVar[bool] = True

    @classmethod
    def of(cls, lowered: Lowered, bodies: Sequence[Body] = ()) -> Prepared:
        """Build the trees of a lowered scene, whose tables it takes; `bodies` give the names and materials."""
        if lowered.laid is None:  # which is not edited
            geometry, woods = with_trees(lowered)
            return cls(lowered.sharing(geometry), geometry, _flat(lowered), woods, entries=bodies)
        found: list[Opened] = []
        geometry, woods = with_trees(lowered, lambda tables: _room(found, tables))
        lowered, kept = in_store(lowered.sharing(geometry), found[0])
        return cls(lowered, geometry, _flat(lowered), woods, entries=bodies, kept=kept)

    def edited(self, bodies: Sequence[Body], progress: Progress | None = None) -> Prepared | None:
        """A scene of other bodies, many of them the same; None where it is as well prepared from the beginning."""
        return edited_from([self], bodies, progress)

    def labelled(self, bodies: Sequence[Body]) -> Prepared:
        """The same shapes with the names and materials of other bodies."""
        return replace(self, entries=bodies)

    @cached_property
    def labels(self) -> Labels:
        """Names and materials by body number."""
        return labels_of(self.entries)

    @cached_property
    def sources(self) -> dict[int, Any]:
        """Surfaces as `scene.surface` and `scene.explain` have worked them out."""
        return {}

    @cached_property
    def kinds(self) -> npt.NDArray[np.int8]:
        """What each body is to light: see `body/sides.py`."""
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


def prepare(bodies: Sequence[Body], before: list[Prepared] | None = None, progress: Progress | None = None) -> Prepared:
    """Prepare a scene; from the one that it was made from, if that is known and has enough in common.

    before: that one, or none. It is taken out of the list: where nobody else has it, it is written over.
    """
    made = edited_from(before, bodies, progress) if before else None
    if made is None:
        stages = Stages(progress, len(bodies))
        lowered = lowering.lower(bodies) if progress is None else lowering.lower(bodies, stages)
        made = Prepared.of(lowered, bodies)
        stages.reached(PLANTED)
    return made


def edited_from(before: list[Prepared], bodies: Sequence[Body], progress: Progress | None = None) -> Prepared | None:
    """`Prepared.edited`, of the one that is taken out of a list."""
    old = before.pop()
    if not old.can_be_edited or isinstance(old.entries, Repeated) or isinstance(bodies, Repeated):
        return old.labelled(bodies) if same_shapes(old.entries, bodies) else None
    found = runs(old.entries, bodies)
    if not found.fresh and len(bodies) == len(old.entries):
        return old.labelled(bodies)
    kept, woods, known = old.kept, old.woods, weakref.ref(old)
    lowered = let_go(old.lowered, old.geometry, kept.memory) if kept.memory else old.lowered
    del old
    claim = kept.memory.claim() if kept.memory else Claim()
    made = edit(lowered, bodies, found, kept, claim, progress) if claim else None
    if made is None:
        return None
    there = known()
    if there is not None:
        vars(there)["kept"] = made.kept
    return _finished(made, lowered.tables, woods, bodies)


def _finished(made: Edit | Exchange, old: Tables, woods: Woods, bodies: Sequence[Body]) -> Prepared:
    """An edited scene with its trees; tables and woods of the old one."""
    trees = patched(old, woods, made)
    if made.in_place:
        trees.apart()
    empty = Tables(**made.shapes, **trees.tables)
    geometry = made.geometry(empty)
    tables = shared(empty, geometry)
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
    return Prepared(lowered, geometry, _flat(lowered), trees.woods, entries=bodies, kept=kept)


def _room(found: list[Opened], tables: Tables) -> Geometry:
    """Memory for tables of these shapes that edited scenes may take."""
    found.append(Opened.new(tables))
    made = found[0].geometry(tables)
    assert made is not None
    return made


def _flat(lowered: Lowered) -> Rest:
    """What rounding took, as kernels take it."""
    rest = lowered.rest
    return Rest(rest.planes.ravel(), rest.spheres.ravel(), rest.quadrics.ravel(), rest.vertices.ravel())
