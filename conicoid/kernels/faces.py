"""Faces of cells: their numbers, and on which side of its surface a cell is.

Both are in one number of `cell_face` and `plane_face`: 1 + the number of the face, negative where a cell is inside
where its quadric, or the height over its plane, is at least 0.

Cells that are one another moved have their face in the tables once: `cell_likes` is twice its row, and 1 more if the
side is -1. Of a scene with such cells, numbers of `plane_face` that fit in a byte have no more than that: four are in
an integer.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from .._jit.decorators import inline
from . import tables as table
from .tables import Geometry, Ints, Tables, integer, length, whole

_MOST = 127


@inline
def row_of_cell(geometry: Geometry, cell: int) -> int:
    """The row of a cell in `cell_face` and `cell_limits`."""
    if length(geometry, table.CELL_LIKES) == 0:
        return whole(cell)
    return integer(geometry, table.CELL_LIKES, cell) >> 1


@inline
def _cell_face(geometry: Geometry, cell: int) -> int:
    """1 + the number of a cell's face, with its side."""
    if length(geometry, table.CELL_LIKES) == 0:
        return integer(geometry, table.CELL_FACE, cell)
    like = integer(geometry, table.CELL_LIKES, cell)
    face = integer(geometry, table.CELL_FACE, row_of_cell(geometry, cell))
    return face if like & 1 == 0 else -face


@inline
def _plane_face(geometry: Geometry, place: int) -> int:
    """1 + the number of a plane's face, with its side."""
    if length(geometry, table.PLANE_FACE) == length(geometry, table.PLANE_SURFACE):
        return integer(geometry, table.PLANE_FACE, place)
    byte = (integer(geometry, table.PLANE_FACE, place >> 2) >> 8 * (place & 3)) & 255
    return byte - 2 * (byte & 128)


@inline
def cell_side(geometry: Geometry, cell: int) -> int:
    """+1: a cell is inside where its quadric is <= 0; -1: where >= 0. 1 where it has none."""
    if length(geometry, table.CELL_LIKES) == 0:
        return whole(1) if integer(geometry, table.CELL_FACE, cell) > 0 else whole(-1)
    return 1 - 2 * (integer(geometry, table.CELL_LIKES, cell) & 1)


@inline
def plane_side(geometry: Geometry, place: int) -> int:
    """+1: a cell is inside where n·x <= offset; -1: where >=."""
    return whole(1) if _plane_face(geometry, place) > 0 else whole(-1)


@inline
def cell_face_and_side(geometry: Geometry, cell: int) -> tuple[int, int]:
    """(number of the face, side) of a cell's quadric."""
    return _face_and_side(_cell_face(geometry, cell))


@inline
def plane_face_and_side(geometry: Geometry, place: int) -> tuple[int, int]:
    """(number of the face, side) of a plane of a cell."""
    return _face_and_side(_plane_face(geometry, place))


@inline
def _face_and_side(both: int) -> tuple[int, int]:
    """A number of these columns taken apart."""
    return (both - 1, whole(1)) if both > 0 else (-1 - both, whole(-1))


def rows_of_cells(tables: Tables, cells: Any) -> Any:
    """The rows of some cells in `cell_face` and `cell_limits`."""
    return tables.cell_likes[cells] >> 1 if len(tables.cell_likes) else cells


def cell_faces(tables: Tables, cells: Any) -> Any:
    """1 + the numbers of the faces of some cells, with their sides."""
    if not len(tables.cell_likes):
        return tables.cell_face[cells]
    return tables.cell_face[rows_of_cells(tables, cells)] * (1 - 2 * (tables.cell_likes[cells] & 1))


def plane_faces(tables: Tables, places: Any) -> Any:
    """The same of some planes of cells."""
    if len(tables.plane_face) == len(tables.plane_surface):
        return tables.plane_face[places]
    return np.ascontiguousarray(tables.plane_face, "<i4").view(np.int8)[places].astype(np.int32)


def numbers_of(faces: Any) -> Any:
    """The numbers of faces, from 1 + numbers with sides."""
    return abs(faces) - 1


def sides_of(faces: Any) -> Any:
    """The sides, +1 or -1, from the same."""
    return 2 * (faces > 0) - 1


def deduplicate_rows(likes: Ints, faces: Ints, rows: int) -> tuple[Ints, Ints]:
    """(`cell_likes`, `cell_face`) of cells by the rows that they have in common, of which there are so many."""
    column = np.zeros(rows, np.int32)
    column[likes] = np.abs(faces)
    return 2 * likes + (faces < 0), column


def as_bytes(faces: Ints) -> Ints:
    """Numbers of `plane_face`, four in an integer; as they are where one has no room, or there are few."""
    if len(faces) < 2 or np.abs(faces).max() > _MOST:
        return faces
    packed = np.zeros(-(-len(faces) // 4) * 4, np.int8)
    packed[: len(faces)] = faces
    return packed.view("<i4").astype(np.int32, copy=False)
