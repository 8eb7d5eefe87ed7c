"""Coordinates uv of points of faces, and the rows of the maps from world coordinates to uv.

In a scene without translated copies of bodies `body_maps` is empty, and `face_maps` has a row for each face, in order.
Otherwise copies share rows of `face_maps`. `body_maps` then has four numbers for each body: the first row of its faces
in `face_maps`, and three offsets (which of the distinct positions along an axis the body has, or its number among the
bodies of its kind). A number 8 row + k of `face_maps` then stands for the row of `map_rows` at `row` plus the body's
number k of the four; for k = 0 for `row` itself.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from ..._jit.decorators import inline
from ..._util.records import unique_sorted
from .. import tables as table
from ..numbers.elementary import atan2
from ..numbers.vectors import dot
from ..surface.records import anchor_of
from ..tables import FRAME_SIZE, MAP_SIZE, PLACE_SIZE, Geometry, Ints, Tables, integer, length


@inline
def map_row(geometry: Geometry, body: int, first: int, face: int, k: int) -> int:
    """Return row k of the map of a face of a body; -1 - row where k = 0 and the map is angular.

    `first` is the row of the body's first face (`body_face`), `face` counts from it.
    """
    if length(geometry, table.BODY_MAPS) == 0:
        return integer(geometry, table.FACE_MAPS, 3 * (first + face) + k)
    place = PLACE_SIZE * body
    found = integer(geometry, table.FACE_MAPS, 3 * (integer(geometry, table.BODY_MAPS, place) + face) + k)
    number = -1 - found if found < 0 else found
    row, which = number >> 3, number & 7
    if which > 0:  # the body's own offset behind a shared row
        row += integer(geometry, table.BODY_MAPS, place + which)
    return -1 - row if found < 0 else row


def rows_of_maps(tables: Tables, body: Any, face: Any) -> Ints:
    """Return (n, 3) the three map rows of a face of each of n bodies, none of them bulk balls; as `map_row`."""
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
    """Return (faces, 3) the three map rows of all faces, in order; as `map_row`."""
    if not len(tables.body_maps):
        return tables.face_maps
    body, count = bodies_with_frames(tables)
    ends = np.cumsum(count)
    face = np.arange(int(ends[-1]) if len(ends) else 0) - np.repeat(ends - count, count)
    return rows_of_maps(tables, np.repeat(body, count), face)


def bodies_with_frames(tables: Tables) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]:
    """Return (bodies that have faces of their own, number of faces of each).

    Relies on the rows of `face_maps` of one kind of body following those of another without a gap.
    """
    body = np.flatnonzero(tables.body_face >= 0)
    first = tables.body_maps[body, 0]
    firsts = np.append(unique_sorted(first), len(tables.face_maps))
    return body, firsts[np.searchsorted(firsts, first) + 1] - first


# Coordinates uv of a point of a face, and a point in the frame of a ball


@inline
def _mapped(geometry: Geometry, row: int, x: float, y: float, z: float) -> float:
    """Return one coordinate of a point: a x + b y + c z + d with a row of `map_rows`."""
    at = geometry.places[table.MAP_ROWS] + MAP_SIZE * row
    f = geometry.floats
    return dot(f[at], f[at + 1], f[at + 2], x, y, z) + f[at + 3]


@inline
def turns(x: float, y: float) -> float:
    """Return the angle of (x, y) as a fraction of a full turn, in [0, 1)."""
    angle = atan2(y, x) / (2.0 * math.pi)
    angle = angle + 1.0 if angle < 0.0 else angle
    # A tiny negative angle rounds to 1; adding 0.0 turns -0.0 into 0.0
    return 0.0 if angle >= 1.0 else angle + 0.0


@inline
def uv_at(geometry: Geometry, body: int, face: int, surface: int, x: float, y: float, z: float) -> tuple[float, float]:
    """Return (u, v) of a point of a face, by the map that the shape documents."""
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
    """Return a point relative to the center of a bulk ball, along the ball's own axes."""
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
    """Return (longitude / 360 degrees, height in [0, 1]) of a point on a bulk ball."""
    x, y, z = from_center(geometry, frame, surface, x, y, z)
    return turns(x, y), 0.5 * z / math.sqrt(dot(x, y, z, x, y, z)) + 0.5
