"""Names and materials of the bodies of an `InstanceList`, by body number; names are built on demand."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from .body import Body
from .instances import InstanceList
from .labels import Labels, is_clear, material_table


def body_labels(bodies: Sequence[Body]) -> Labels:
    """Return the names and materials of the bodies of a scene."""
    return InstanceLabels(bodies) if isinstance(bodies, InstanceList) else Labels.of(bodies)


def body_material_table(bodies: Sequence[Body], item_of: Any) -> tuple[list[Any], list[bool], Any]:
    """Return `material_table` for any bodies of a scene."""
    if not isinstance(bodies, InstanceList):
        return material_table(bodies, item_of)
    return list(bodies.materials), [not solid for solid in bodies.solid], bodies.looks


class InstanceLabels(Labels):
    """`Labels` that read the list of bodies and hold no tables of their own."""

    bodies: InstanceList

    def __init__(self, bodies: InstanceList) -> None:
        object.__setattr__(self, "bodies", bodies)

    if not TYPE_CHECKING:  # in place of the fields of `Labels`, for callers that need all bodies

        @cached_property
        def firsts(self) -> npt.NDArray[np.int64]:
            """The first body number of each entry: every body is an entry."""
            return np.arange(len(self.bodies))

        @cached_property
        def names(self) -> tuple[str | None, ...]:
            """The names of all bodies."""
            return tuple(self.bodies.name(number) for number in range(len(self.bodies)))

        @cached_property
        def materials(self) -> tuple[Any, ...]:
            """The materials of all bodies."""
            return tuple(self._materials[self.bodies.looks])

        @cached_property
        def solid(self) -> tuple[bool, ...]:
            """For each body, True if it is a solid."""
            return tuple(np.array(self.bodies.solid)[self.bodies.looks].tolist())

    def of_only(self, numbers: Any) -> Labels:
        """Return the labels of the entries that some numbers belong to."""
        rows = np.unique(numbers)
        rows = rows[rows >= 0].astype(np.int64)
        names = tuple(self.bodies.name(number) for number in rows.tolist())
        solid = tuple(self.bodies.solid[look] for look in self.bodies.looks[rows].tolist())
        return Labels(rows, names, tuple(self.materials_of(rows)), solid)

    def kinds(self, count: int) -> npt.NDArray[np.int8]:
        """Return for each body 0 if it is opaque, 1 for a transparent solid, 2 for a transparent sheet."""
        del count
        materials = zip(self.bodies.materials, self.bodies.solid, strict=True)
        kinds = np.array([is_clear(material) * (1 if solid else 2) for material, solid in materials], np.int8)
        return kinds[self.bodies.looks]

    def names_of(self, numbers: Any) -> Any:
        """Return the names of body numbers, None for -1, in an object array of the same shape."""
        rows, index = np.unique(numbers, return_inverse=True)
        names: Any = np.empty(len(rows), object)
        for place, number in enumerate(rows.tolist()):
            names[place] = self.bodies.name(number) if number >= 0 else None
        return names[index.reshape(np.shape(numbers))]

    def materials_of(self, numbers: Any) -> Any:
        """Return the materials of body numbers, None for -1, in an object array of the same shape."""
        return self._materials[np.where(np.asarray(numbers) < 0, -1, self.bodies.looks[numbers])]

    @cached_property
    def distinct(self) -> tuple[tuple[Any, bool], ...]:
        """The different materials in the order of their first bodies, each with True if any solid has it."""
        bodies = self.bodies
        used = np.bincount(bodies.looks, minlength=len(bodies.materials)) > 0
        of_solids = {m for m, solid, any_ in zip(bodies.materials, bodies.solid, used, strict=True) if solid and any_}
        return tuple((material, material in of_solids) for material in bodies.distinct_materials)

    def columns_of(self, numbers: Any, materials: Sequence[Any]) -> Any:
        """Return for each body number the index of its material in `materials`, which holds all of them."""
        places = {material: place for place, material in enumerate(materials)}
        columns = [places.get(material, -1) for material in self.bodies.materials]  # -1: an edit removed its bodies
        return np.array(columns, np.int64)[self.bodies.looks[numbers]]

    @cached_property
    def _materials(self) -> Any:
        """The materials, and None in the last row, which index -1 reads."""
        table: Any = np.empty(len(self.bodies.materials) + 1, object)
        table[:-1] = self.bodies.materials
        return table
