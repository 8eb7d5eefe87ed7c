"""Faces of cells: their numbers, and the side of its surface on which a cell lies.

One number of `cell_face` or `plane_face` holds both: 1 + the number of the face, negated where the inside of the cell
is where its quadric, or the height over its plane, is at least 0.

Cells that are translated copies of each other share a row of faces: `cell_likes` is twice the row, plus 1 if the side
is -1. In a scene with such cells `plane_face` holds four numbers in an integer, if each fits in a byte.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from .._jit.decorators import inline
from . import tables as table
from .tables import Geometry, Ints, Tables, integer, length, whole

_MOST = 127  # largest int8


@inline
def row_of_cell(geometry: Geometry, cell: int) -> int:
    """Return the row of a cell in `cell_face` and `cell_limits`."""
    if length(geometry, table.CELL_LIKES) == 0:
        return whole(cell)
    return integer(geometry, table.CELL_LIKES, cell) >> 1


@inline
def _cell_face(geometry: Geometry, cell: int) -> int:
    """Return 1 + the number of the face of a cell's quadric, negated where the side is -1."""
    if length(geometry, table.CELL_LIKES) == 0:
        return integer(geometry, table.CELL_FACE, cell)
    like = integer(geometry, table.CELL_LIKES, cell)
    face = integer(geometry, table.CELL_FACE, row_of_cell(geometry, cell))
    return face if like & 1 == 0 else -face


@inline
def _plane_face(geometry: Geometry, place: int) -> int:
    """Return 1 + the number of a plane's face, negated where the side is -1."""
    if length(geometry, table.PLANE_FACE) == length(geometry, table.PLANE_SURFACE):
        return integer(geometry, table.PLANE_FACE, place)
    # Byte `place & 3` of the integer, then its sign extended
    byte = (integer(geometry, table.PLANE_FACE, place >> 2) >> 8 * (place & 3)) & 255
    return byte - 2 * (byte & 128)


@inline
def cell_side(geometry: Geometry, cell: int) -> int:
    """Return +1 if the inside of a cell is where its quadric is <= 0, -1 if where it is >= 0; 1 without a quadric."""
    if length(geometry, table.CELL_LIKES) == 0:
        return whole(1) if integer(geometry, table.CELL_FACE, cell) > 0 else whole(-1)
    return 1 - 2 * (integer(geometry, table.CELL_LIKES, cell) & 1)


@inline
def plane_side(geometry: Geometry, place: int) -> int:
    """Return +1 if the inside of a cell is where n·x <= offset of this plane, -1 if where it is >= offset."""
    return whole(1) if _plane_face(geometry, place) > 0 else whole(-1)


@inline
def cell_face_and_side(geometry: Geometry, cell: int) -> tuple[int, int]:
    """Return (number of the face, side) of a cell's quadric."""
    return _face_and_side(_cell_face(geometry, cell))


@inline
def plane_face_and_side(geometry: Geometry, place: int) -> tuple[int, int]:
    """Return (number of the face, side) of a plane of a cell."""
    return _face_and_side(_plane_face(geometry, place))


@inline
def _face_and_side(both: int) -> tuple[int, int]:
    """Split a number of `cell_face` or `plane_face` into (number of the face, side)."""
    return (both - 1, whole(1)) if both > 0 else (-1 - both, whole(-1))


def rows_of_cells(tables: Tables, cells: Any) -> Any:
    """Return the rows of some cells in `cell_face` and `cell_limits`."""
    return tables.cell_likes[cells] >> 1 if len(tables.cell_likes) else cells


def cell_faces(tables: Tables, cells: Any) -> Any:
    """Return 1 + the numbers of the faces of some cells' quadrics, negated where the side is -1."""
    if not len(tables.cell_likes):
        return tables.cell_face[cells]
    return tables.cell_face[rows_of_cells(tables, cells)] * (1 - 2 * (tables.cell_likes[cells] & 1))


def plane_faces(tables: Tables, places: Any) -> Any:
    """Return 1 + the numbers of the faces of some planes of cells, negated where the side is -1."""
    if len(tables.plane_face) == len(tables.plane_surface):
        return tables.plane_face[places]
    return np.ascontiguousarray(tables.plane_face, "<i4").view(np.int8)[places].astype(np.int32)


def numbers_of(faces: Any) -> Any:
    """Return the numbers of faces from the numbers of `cell_faces` or `plane_faces`."""
    return abs(faces) - 1


def sides_of(faces: Any) -> Any:
    """Return the sides, +1 or -1, from the numbers of `cell_faces` or `plane_faces`."""
    return 2 * (faces > 0) - 1


def as_bytes(faces: Ints) -> Ints:
    """Return numbers of `plane_face` four to an integer; unchanged if one does not fit in a byte or there are < 2."""
    if len(faces) < 2 or np.abs(faces).max() > _MOST:
        return faces
    # Little-endian on every processor, as `_plane_face` shifts the bytes out
    packed = np.zeros(-(-len(faces) // 4) * 4, np.int8)
    packed[: len(faces)] = faces
    return packed.view("<i4").astype(np.int32, copy=False)
