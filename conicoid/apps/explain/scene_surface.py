"""What a surface of a scene is: its equation, its kind, and whose faces it makes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..._util.validation import format_value
from ...geometry.quadric_classification import Classification
from ...kernels.faces import cell_faces, numbers_of, plane_faces, sides_of
from ...kernels.programs import cells_of_leaves, leaves_of_programs, row_of_leaf
from ...kernels.tables import BALL, CELL, PLANE, POLYGON, REGION, SHEET, Tables
from .polynomial import SurfaceSource

if TYPE_CHECKING:
    from ...prepare.prepared_scene import PreparedScene
    from ...queries.scene_protocol import SceneLike


@dataclass(frozen=True)
class Owner:
    """A face that lies on a surface: of which body, and on which side of the surface that body is there.

    body     its number
    name     what it is called, or None
    face     the number of the face
    side     1 where the body has the side on which the equation's left side is negative, -1 where it has the other
    """

    body: int
    name: str | None
    face: int
    side: int


@dataclass(frozen=True)
class SceneSurface:
    """One of the distinct surfaces of a scene, which bodies that share a wall have in common.

    number           its number in the scene, as `hits.surface` tells it
    equation         its equation in the world, to be read: numbers to six digits
    coefficients     of the equation with all digits, each rounded once, as `Quadric(coefficients=)` takes them
    classification   which quadric or plane it is, as `Quadric.classification` tells it, for the side where the left
                     side of the equation is negative
    owners           the faces that lie on it
    """

    number: int
    equation: str
    coefficients: dict[str, float]
    classification: Classification
    owners: tuple[Owner, ...]

    @property
    def kind(self) -> str:
        """The kind in a word or two, as "ellipsoid" or "plane"."""
        return self.classification.kind

    def __str__(self) -> str:
        faces = [
            f"face {one.face} of body {one.body}" + (f" {format_value(one.name)}" if one.name else "")
            for one in self.owners
        ]
        lines = [f"surface {self.number}: {self.equation}", str(self.classification)]
        return "\n".join([*lines, f"shared by {', '.join(faces)}" if len(faces) > 1 else "".join(faces)])


def surface_of(scene: SceneLike, number: int) -> SceneSurface:
    """The surface of a number. Raises TypeError and IndexError for numbers that there are not."""
    source = SurfaceSource.of(scene.prepared, number)
    polynomial = source.polynomial
    return SceneSurface(
        number, polynomial.equation, polynomial.coefficients, source.classification, owners_of(scene.prepared, number)
    )


def owners_of(scene: PreparedScene, number: int) -> tuple[Owner, ...]:
    """The faces on a surface, in the order of bodies."""
    tables = scene.lowered.tables
    is_plane = tables.surface_kind[number] == PLANE
    found: set[tuple[int, int, int]] = set()
    if is_plane:
        places = np.flatnonzero(tables.plane_surface == number)
        cells = np.searchsorted(tables.cell_first, places, side="right") - 1
        both = plane_faces(tables, places)
    else:
        cells = np.flatnonzero(tables.cell_quadric == number)
        both = cell_faces(tables, cells)
        balls = np.flatnonzero((tables.entry_kind == BALL) & (tables.entry_index == number))
        found |= {(body, 0, 1) for body in balls.tolist()}
    faces, sides = numbers_of(both), sides_of(both)
    which, bodies, senses = _bodies_of(tables, cells)
    found |= set(zip(bodies.tolist(), faces[which].tolist(), (sides[which] * senses).tolist(), strict=True))
    for kind, surfaces, normals in (
        (SHEET, tables.sheet_surface, tables.sheet_side),
        (POLYGON, tables.polygon_surface, tables.polygon_side),
    ):
        rows = np.flatnonzero(surfaces == number)
        entries = np.flatnonzero((tables.entry_kind == kind) & np.isin(tables.entry_index, rows))
        found |= {(entry, 0, int(normals[tables.entry_index[entry]])) for entry in entries.tolist()}
    names = scene.labels.names_of(np.array([body for body, _, _ in sorted(found)], np.int64))
    return tuple(Owner(body, name, face, side) for (body, face, side), name in zip(sorted(found), names, strict=True))


def _bodies_of(tables: Tables, cells: Any) -> tuple[Any, Any, Any]:
    """Whose some cells are: (which of the cells, body, -1 where it stands for its complement there, else 1)."""
    which, entries = _entries_among(tables, CELL, cells)
    order = np.argsort(cells, kind="stable")
    leaves = _leaves_of(tables, cells)
    cells_of = cells_of_leaves(tables, leaves)
    first, last = (np.searchsorted(cells[order], cells_of, side=end) for end in ("left", "right"))
    leaf, at = _ranges(first, last)
    programs = np.searchsorted(tables.program_leaf, leaves, side="right") - 1
    part, regions = _entries_among(tables, REGION, programs[leaf])
    senses = tables.leaf_sense[row_of_leaf(tables, programs, leaves)]
    return (
        np.concatenate([which, order[at][part]]),
        np.concatenate([entries, regions]),
        np.concatenate([np.ones(len(which), np.int64), senses[leaf][part]]),
    )


def _leaves_of(tables: Tables, cells: Any) -> Any:
    """The leaves that are some cells, in rising order."""
    if not len(tables.program_shifts):
        return np.flatnonzero(np.isin(tables.leaf_cell, cells))
    leaves, (first, count) = np.unique(cells), leaves_of_programs(tables)
    programs = np.searchsorted(first, leaves, side="right") - 1
    return leaves[(programs >= 0) & (leaves < (first + count)[programs])]


def _entries_among(tables: Tables, kind: int, rows: Any) -> tuple[Any, Any]:
    """(which of some cells or programs, entry) for each entry of a kind that is one of these."""
    entries = np.flatnonzero(tables.entry_kind == kind)
    entries = entries[np.argsort(tables.entry_index[entries], kind="stable")]
    index = tables.entry_index[entries]
    which, at = _ranges(*(np.searchsorted(index, rows, side=end) for end in ("left", "right")))
    return which, entries[at]


def _ranges(first: Any, last: Any) -> tuple[Any, Any]:
    """(which range, place in it) of every place of some ranges."""
    counts = last - first
    which = np.repeat(np.arange(len(counts)), counts)
    return which, np.arange(len(which)) - np.repeat(np.cumsum(counts) - counts - first, counts)
