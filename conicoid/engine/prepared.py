"""A prepared scene: its tables and trees, and what makes it known again."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from ..exact.forms import Form
from ..shapes.body import Body
from ..shapes.labels import NOBODY, Labels
from ..shapes.repeated_labels import labels_of
from .lowering import Lowered
from .surface.decide import Rest
from .tables import Geometry
from .tree.build import with_trees


@dataclass(frozen=True)
class Prepared:
    """A scene prepared for queries: lowered, with its trees. Immutable, except that `forms` is filled on demand."""

    lowered: Lowered
    geometry: Geometry
    rest: Rest
    forms: dict[int, Form] = field(default_factory=dict, repr=False, compare=False)  # surfaces in exact arithmetic

    labels: Labels = NOBODY

    @classmethod
    def of(cls, lowered: Lowered, bodies: Sequence[Body] = ()) -> Prepared:
        """Build the trees of a lowered scene; `bodies` give the names and materials."""
        geometry, rest = with_trees(lowered), lowered.rest
        flat = Rest(rest.planes.ravel(), rest.spheres.ravel(), rest.quadrics.ravel(), rest.vertices.ravel())
        return cls(lowered.sharing(geometry), geometry, flat, labels=labels_of(bodies))

    def labelled(self, bodies: Sequence[Body]) -> Prepared:
        """The same shapes with the names and materials of other bodies."""
        return replace(self, labels=labels_of(bodies))

    @cached_property
    def key(self) -> bytes:
        """Whose the numbers of surfaces are: scenes with one key have the same surfaces by the same numbers."""
        from hashlib import blake2b

        tables, rest = self.lowered.tables, self.lowered.rest
        surfaces = (tables.surface_kind, tables.surface_row, tables.planes, tables.spheres, tables.quadrics)
        digest = blake2b(digest_size=16)
        for array in (*surfaces, rest.planes, rest.spheres, rest.quadrics):
            digest.update(str(array.shape).encode())
            digest.update(np.ascontiguousarray(array).data.cast("B") if array.size else b"")
        return digest.digest()
