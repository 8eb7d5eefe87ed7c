"""Names and materials by body number. An entry of a scene has one number, or one for each of its many bodies.

`Labels` hold tables. `InstanceLabels` hold none: they read an `InstanceList`, and names are built on demand.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from .._util.arrays import unique_sorted
from .._util.records import dataclass, pickle_state
from ..materials.color import amount_rgb
from .body import Body
from .bulk import Bulk
from .instances import InstanceList


def count_bodies(body: Body) -> int:
    """Return how many body numbers an entry takes."""
    return len(body.shape) if isinstance(body.shape, Bulk) else 1


def material_of(body: Body, index: int) -> Any:
    """Return the material of body number `index` of an entry."""
    return body.material if body.materials is None else body.materials[body.material_index[index]]


def distinct_materials(bodies: Iterable[Body]) -> tuple[Any, ...]:
    """Return the different materials in the order of the first body of each; None for bodies without one."""
    materials: dict[Any, None] = {}
    for body in bodies:
        if body.materials is None:
            materials[body.material] = None
        else:
            used, first = np.unique(body.material_index, return_index=True)
            materials.update((body.materials[place], None) for place in used[np.argsort(first)].tolist())
    return tuple(materials)


def material_table(bodies: Sequence[Body], item_of: Any) -> tuple[list[Any], list[bool], Any]:
    """Return (materials, True for each of a sheet, the index of each body's material).

    `item_of` holds the entry of each body.
    """
    materials, sheets, place_of = [body.material for body in bodies], [body.shape.is_sheet for body in bodies], item_of
    for entry, body in enumerate(bodies):
        if body.materials is not None:
            if place_of is item_of:
                place_of = item_of.copy()
            place_of[item_of == entry] = len(materials) + body.material_index
            materials += body.materials
            sheets += [body.shape.is_sheet] * len(body.materials)
    return materials, sheets, place_of


def is_clear(material: Any) -> bool:
    """Return True if light passes through bodies of a material; None stands for bodies without one."""
    return material is not None and max(amount_rgb(material.transparency)) > 0


def first_numbers(bodies: Sequence[Body]) -> npt.NDArray[np.int64]:
    """Return the first body number of each entry, followed by the number of bodies, (entries + 1,)."""
    if not any(issubclass(kind, Bulk) for kind in {type(body.shape) for body in bodies}):
        return np.arange(len(bodies) + 1, dtype=np.int64)
    return np.cumsum([0, *map(count_bodies, bodies)], dtype=np.int64)


def single_body(body: Body, index: int) -> Body:
    """Return body `index` of an entry of many, with its material and the entry's name; any other entry itself."""
    shape = body.shape
    if not isinstance(shape, Bulk):
        return body
    return Body(shape.single(index), material_of(body, index), body.name)


@dataclass(frozen=True)
class Labels:
    """The names and materials of bodies. Entry k has the numbers from firsts[k] up to the first of the next entry.

    Of many bodies in one entry of a scene, each run with one material is an entry here.
    """

    firsts: npt.NDArray[np.int64]
    names: tuple[str | None, ...]
    materials: tuple[Any, ...]
    solid: tuple[bool, ...]

    def __getstate__(self) -> dict[str, Any]:
        return pickle_state(self)

    @classmethod
    def of(cls, bodies: Sequence[Body]) -> Labels:
        """Return the labels of all entries of a scene."""
        firsts = first_numbers(bodies)[:-1]
        names, materials = tuple(body.name for body in bodies), tuple(body.material for body in bodies)
        solid = tuple(not body.shape.is_sheet for body in bodies)
        if all(body.materials is None for body in bodies):
            return cls(firsts, names, materials, solid)
        runs = [_material_runs(body) for body in bodies]
        counts = [len(begins) for begins, _ in runs]
        every = np.concatenate([first + begins for first, (begins, _) in zip(firsts, runs, strict=True)])
        return cls(
            every,
            tuple(name for name, count in zip(names, counts, strict=True) for _ in range(count)),
            tuple(each for _, made_of in runs for each in made_of),
            tuple(each for each, count in zip(solid, counts, strict=True) for _ in range(count)),
        )

    def select(self, numbers: Any) -> Labels:
        """Return the labels of the entries that some numbers belong to."""
        rows = unique_sorted(self._rows(unique_sorted(np.ravel(numbers))))
        rows = rows[rows >= 0].tolist()
        names, materials = tuple(self.names[row] for row in rows), tuple(self.materials[row] for row in rows)
        return Labels(self.firsts[rows], names, materials, tuple(self.solid[row] for row in rows))

    def _rows(self, numbers: Any) -> Any:
        """Return the entry of each number, -1 for -1."""
        return np.where(numbers < 0, -1, np.searchsorted(self.firsts, numbers, side="right") - 1)

    def names_of(self, numbers: Any) -> Any:
        """Return the names of body numbers in an object array of the same shape: None without a name and for -1."""
        return self._names[self._rows(numbers)]

    def materials_of(self, numbers: Any) -> Any:
        """Return the materials of body numbers in an object array of the same shape: None without one and for -1."""
        return self._materials[self._rows(numbers)]

    def kinds(self, count: int) -> npt.NDArray[np.int8]:
        """Return for each of `count` bodies 0 if it is opaque, 1 for a transparent solid, 2 for a transparent sheet."""
        kinds: dict[int, bool] = {}
        for material in self.materials:
            if id(material) not in kinds:  # quicker than to compare materials
                kinds[id(material)] = is_clear(material)
        rows = [kinds[id(m)] * (1 if solid else 2) for m, solid in zip(self.materials, self.solid, strict=True)]
        return np.repeat(np.array(rows, np.int8), np.diff([*self.firsts, count]))

    @cached_property
    def distinct(self) -> tuple[tuple[Any, bool], ...]:
        """The different materials in the order of their first bodies, each with True if any solid has it."""
        solids = {id(material): material for material, solid in zip(self.materials, self.solid, strict=True) if solid}
        of_solids = set(solids.values())
        different = dict.fromkeys({id(material): material for material in self.materials}.values())
        return tuple((material, material in of_solids) for material in different)

    def columns_of(self, numbers: Any, materials: Sequence[Any]) -> Any:
        """Return for each body number the index of its material in `materials`, which holds all of them."""
        places = {material: place for place, material in enumerate(materials)}
        by_identity: dict[int, int] = {}
        for material in self.materials:
            if id(material) not in by_identity:  # quicker than to compare materials
                by_identity[id(material)] = places[material]
        table = np.array([by_identity[id(material)] for material in self.materials], np.int64)
        return table[self._rows(numbers)]

    @cached_property
    def _names(self) -> Any:
        return _object_table(self.names)

    @cached_property
    def _materials(self) -> Any:
        return _object_table(self.materials)


def _material_runs(body: Body) -> tuple[npt.NDArray[np.int64], Sequence[Any]]:
    """Return (where each run of bodies with one material begins in an entry, the materials of the runs)."""
    index = body.material_index
    if body.materials is None or not len(index):
        return np.zeros(1, np.int64), [body.material]
    begins = np.flatnonzero(np.concatenate([[True], index[1:] != index[:-1]]))
    return begins, [body.materials[place] for place in index[begins].tolist()]


def _object_table(values: Sequence[Any]) -> Any:
    """Return an object array of the values and None in its last row, which index -1 reads."""
    table = np.empty(len(values) + 1, object)
    for row, value in enumerate(values):
        table[row] = value
    return table


# --- Labels of an `InstanceList`


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

    def select(self, numbers: Any) -> Labels:
        """Return the labels of the entries that some numbers belong to."""
        rows = unique_sorted(np.ravel(numbers))
        rows = rows[rows >= 0].astype(np.int64)
        names = tuple(self.bodies.name(number) for number in rows.tolist())
        solid = tuple(self.bodies.solid[look] for look in self.bodies.looks[rows].tolist())
        return Labels(rows, names, tuple(self.materials_of(rows)), solid)

    def kinds(self, count: int) -> npt.NDArray[np.int8]:
        """Return for each body 0 if it is opaque, 1 for a transparent solid, 2 for a transparent sheet."""
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
