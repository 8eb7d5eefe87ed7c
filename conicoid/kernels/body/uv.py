"""The rows of faces' maps from world coordinates to uv; bodies that are one another moved share what says which.

A scene without such bodies has no `body_maps`: `face_maps` have a row for each face, in order. One with such bodies has
the four numbers of `body_maps` for each body: where the rows of its faces begin in `face_maps`, and then, which of the
different places along an axis it has, or which of its kind it is. A number 8 row + k of `face_maps` says there that a
body has the row that lies behind this one by its number k of the four; for k = 0 this one.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from ..._jit.decorators import inline
from ..._util.arrays import unique_sorted
from .. import tables as table
from ..numbers.elementary import atan2
from ..numbers.vectors import dot
from ..surface.records import anchor_of
from ..tables import FRAME_SIZE, MAP_SIZE, PLACE_SIZE, Geometry, Ints, Tables, integer, length


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
    body, count = bodies_with_frames(tables)
    ends = np.cumsum(count)
    face = np.arange(int(ends[-1]) if len(ends) else 0) - np.repeat(ends - count, count)
    return rows_of_maps(tables, np.repeat(body, count), face)


def bodies_with_frames(tables: Tables) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]:
    """(bodies with faces of their own, how many), where the rows of each kind are behind those of another."""
    body = np.flatnonzero(tables.body_face >= 0)
    first = tables.body_maps[body, 0]
    firsts = np.append(unique_sorted(first), len(tables.face_maps))
    return body, firsts[np.searchsorted(firsts, first) + 1] - first


# The coordinates uv of a point of a face, and a point in the own frame of a ball.


@inline
def _mapped(geometry: Geometry, row: int, x: float, y: float, z: float) -> float:
    """One coordinate of a point by an affine map, of which it is a row."""
    at = geometry.places[table.MAP_ROWS] + MAP_SIZE * row
    f = geometry.floats
    return dot(f[at], f[at + 1], f[at + 2], x, y, z) + f[at + 3]


@inline
def turns(x: float, y: float) -> float:
    """The angle of (x, y) as a fraction of a full turn, in [0, 1)."""
    angle = atan2(y, x) / (2.0 * math.pi)
    angle = angle + 1.0 if angle < 0.0 else angle
    return 0.0 if angle >= 1.0 else angle + 0.0


@inline
def uv_at(geometry: Geometry, body: int, face: int, surface: int, x: float, y: float, z: float) -> tuple[float, float]:
    """uv of a point of a face, by the map its shape documents."""
    first = integer(geometry, table.BODY_FACE, body)
    if first < 0:
        return ball_uv(geometry, -1 - first, surface, x, y, z)
    row = map_row(geometry, body, first, face, 0)
    b = _mapped(geometry, map_row(geometry, body, first, face, 1), x, y, z)
    if row >= 0:
        return _mapped(geometry, row, x, y, z), b
    angle = turns(_mapped(geometry, -1 - row, x, y, z), b)
    return angle, _mapped(geometry, map_row(geometry, body, first, face, 2), x, y, z)


@inline
def from_center(
    geometry: Geometry, frame: int, surface: int, x: float, y: float, z: float
) -> tuple[float, float, float]:
    """A point relative to the center of one of many balls, along the ball's own axes."""
    cx, cy, cz = anchor_of(geometry, surface)
    x, y, z = x - cx, y - cy, z - cz
    at = geometry.places[table.BALL_FRAMES] + FRAME_SIZE * frame
    f = geometry.floats
    return (
        dot(f[at], f[at + 1], f[at + 2], x, y, z),
        dot(f[at + 3], f[at + 4], f[at + 5], x, y, z),
        dot(f[at + 6], f[at + 7], f[at + 8], x, y, z),
    )


@inline
def ball_uv(geometry: Geometry, frame: int, surface: int, x: float, y: float, z: float) -> tuple[float, float]:
    """(longitude / 360, height in [0, 1]) on one of many balls."""
    x, y, z = from_center(geometry, frame, surface, x, y, z)
    return turns(x, y), 0.5 * z / math.sqrt(dot(x, y, z, x, y, z)) + 0.5
