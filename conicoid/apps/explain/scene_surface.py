"""`scene.surface`: the equation and the kind of a surface of a scene, and the faces of bodies that lie on it."""

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
    """A face that lies on a surface, and the side of the surface on which its body is.

    Attributes
    ----------
    body : int
        Number of the body.
    name : str or None
        Name of the body.
    face : int
        Number of the face.
    side : int
        1 if the left side of the surface's equation is negative on the body's side, else -1.
    """

    body: int
    name: str | None
    face: int
    side: int


@dataclass(frozen=True)
class SceneSurface:
    """One of the distinct surfaces of a scene; bodies that share a wall share its surface.

    Attributes
    ----------
    number : int
        Number in the scene, as in `hits.surface`.
    equation : str
        Readable equation in the world, numbers to six digits.
    coefficients : dict of str to float
        Coefficients of the equation with all digits, each rounded once, as `Quadric(coefficients=)` takes them.
    classification : Classification
        The kind of quadric or plane, as in `Quadric.classification`, for the side on which the left side of the
        equation is negative.
    owners : tuple of Owner
        The faces that lie on the surface.
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
    """Return the surface of a number.

    Parameters
    ----------
    scene : Scene
    number : int
        From 0 to the number of surfaces - 1.

    Returns
    -------
    SceneSurface
    """
    source = SurfaceSource.of(scene._prepared, number)
    polynomial = source.polynomial
    return SceneSurface(
        number, polynomial.equation, polynomial.coefficients, source.classification, owners_of(scene._prepared, number)
    )


def owners_of(scene: PreparedScene, number: int) -> tuple[Owner, ...]:
    """Return the faces on a surface, in the order of bodies."""
    tables = scene.lowered.tables
    is_plane = tables.surface_kind[number] == PLANE
    found: set[tuple[int, int, int]] = set()  # (body, face, side)
    if is_plane:
        places = np.flatnonzero(tables.plane_surface == number)
        cells = np.searchsorted(tables.cell_first, places, side="right") - 1
        both = plane_faces(tables, places)
    else:
        cells = np.flatnonzero(tables.cell_quadric == number)
        both = cell_faces(tables, cells)
        # A ball is the inside of its sphere, with one face 0
        balls = np.flatnonzero((tables.entry_kind == BALL) & (tables.entry_index == number))
        found |= {(body, 0, 1) for body in balls.tolist()}
    faces, sides = numbers_of(both), sides_of(both)
    which, bodies, senses = _bodies_of(tables, cells)
    # The side of a face turns if the body has the complement of the cell
    found |= set(zip(bodies.tolist(), faces[which].tolist(), (sides[which] * senses).tolist(), strict=True))
    for kind, surfaces, normals in (
        (SHEET, tables.sheet_surface, tables.sheet_side),
        (POLYGON, tables.polygon_surface, tables.polygon_side),
    ):
        rows = np.flatnonzero(surfaces == number)
        # A sheet has one face 0, on the side of its normal
        entries = np.flatnonzero((tables.entry_kind == kind) & np.isin(tables.entry_index, rows))
        found |= {(entry, 0, int(normals[tables.entry_index[entry]])) for entry in entries.tolist()}
    names = scene.labels.names_of(np.array([body for body, _, _ in sorted(found)], np.int64))
    return tuple(Owner(body, name, face, side) for (body, face, side), name in zip(sorted(found), names, strict=True))


def _bodies_of(tables: Tables, cells: Any) -> tuple[Any, Any, Any]:
    """Return (which of some cells, its body, sense) of each use: -1 where the complement of the cell counts, else 1."""
    # Bodies that are one cell, then cells in the leaves of Boolean bodies
    which, entries = _entries_among(tables, CELL, cells)
    order = np.argsort(cells, kind="stable")
    leaves = _leaves_of(tables, cells)
    cells_of = cells_of_leaves(tables, leaves)
    first, last = (np.searchsorted(cells[order], cells_of, side=end) for end in ("left", "right"))
    leaf, at = _ranges(first, last)
    # The program of each leaf: leaves of a program follow each other
    programs = np.searchsorted(tables.program_leaf, leaves, side="right") - 1
    part, regions = _entries_among(tables, REGION, programs[leaf])
    senses = tables.leaf_sense[row_of_leaf(tables, programs, leaves)]
    return (
        np.concatenate([which, order[at][part]]),
        np.concatenate([entries, regions]),
        np.concatenate([np.ones(len(which), np.int64), senses[leaf][part]]),
    )


def _leaves_of(tables: Tables, cells: Any) -> Any:
    """Return the leaves that use some cells, in rising order."""
    # Without shifted programs each leaf has its own row; with them a leaf has the number of its cell
    if not len(tables.program_shifts):
        return np.flatnonzero(np.isin(tables.leaf_cell, cells))
    leaves, (first, count) = np.unique(cells), leaves_of_programs(tables)
    programs = np.searchsorted(first, leaves, side="right") - 1
    return leaves[(programs >= 0) & (leaves < (first + count)[programs])]


def _entries_among(tables: Tables, kind: int, rows: Any) -> tuple[Any, Any]:
    """Return (which of some rows, entry) for each entry of a kind that uses one of these cells or programs."""
    entries = np.flatnonzero(tables.entry_kind == kind)
    entries = entries[np.argsort(tables.entry_index[entries], kind="stable")]
    index = tables.entry_index[entries]
    which, at = _ranges(*(np.searchsorted(index, rows, side=end) for end in ("left", "right")))
    return which, entries[at]


def _ranges(first: Any, last: Any) -> tuple[Any, Any]:
    """Return (number of the range, place) of every place of some ranges from `first` to `last`."""
    counts = last - first
    which = np.repeat(np.arange(len(counts)), counts)
    return which, np.arange(len(which)) - np.repeat(np.cumsum(counts) - counts - first, counts)
