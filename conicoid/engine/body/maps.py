"""The rows of faces' maps from world coordinates to uv; bodies that are one another moved share what says which.

A scene without such bodies has no `body_maps`: `face_maps` have a row for each face, in order. One with such bodies has
the four numbers of `body_maps` for each body: where the rows of its faces begin in `face_maps`, and then, which of the
different places along an axis it has, or which of its kind it is. A number 8 row + k of `face_maps` says there that a
body has the row that lies behind this one by its number k of the four; for k = 0 this one.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ...compiler.jit import inline
from ...shapes.distinct import distinct
from .. import tables as table
from ..tables import PLACE_SIZE, Geometry, Ints, Tables, integer, length


@inline
def map_row(geometry: Geometry, body: int, first: int, face: int, k: int) -> int:
    """Row k of the map of a face of a body whose first face this is; -1 - row where k = 0 and the map is angular."""
    if length(geometry, table.BODY_MAPS) == 0:
        return integer(geometry, table.FACE_MAPS, 3 * (first + face) + k)
    place = PLACE_SIZE * body
    found = integer(geometry, table.FACE_MAPS, 3 * (integer(geometry, table.BODY_MAPS, place) + face) + k)
    number = -1 - found if found < 0 else found
    row, which = number >> 3, number & 7
    if which > 0:
        row += integer(geometry, table.BODY_MAPS, place + which)
    return -1 - row if found < 0 else row


def rows_of_maps(tables: Tables, body: Any, face: Any) -> Ints:
    """(n, 3) the same for faces of bodies, none of them balls of many."""
    if not len(tables.body_maps):
        return tables.face_maps[tables.body_face[body] + face]
    places = tables.body_maps[body]
    found = tables.face_maps[places[:, 0] + face]
    number = np.where(found < 0, -1 - found, found)
    which = number & 7
    behind = np.where(which > 0, np.take_along_axis(places, which.astype(np.intp), axis=1), 0)
    row = (number >> 3) + behind
    return np.where(found < 0, -1 - row, row).astype(np.int32)


def maps_of_faces(tables: Tables) -> Ints:
    """(faces, 3) the same for all faces, in order."""
    if not len(tables.body_maps):
        return tables.face_maps
    body, count = framed_bodies(tables)
    ends = np.cumsum(count)
    face = np.arange(int(ends[-1]) if len(ends) else 0) - np.repeat(ends - count, count)
    return rows_of_maps(tables, np.repeat(body, count), face)


def framed_bodies(tables: Tables) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]:
    """(bodies with faces of their own, how many), where the rows of each kind are behind those of another."""
    body = np.flatnonzero(tables.body_face >= 0)
    first = tables.body_maps[body, 0]
    firsts = np.append(distinct(first), len(tables.face_maps))
    return body, firsts[np.searchsorted(firsts, first) + 1] - first
