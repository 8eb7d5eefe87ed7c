"""The coordinates uv of a point of a face, and a point in the own frame of a ball."""

from __future__ import annotations

import math

from ...compiler.jit import inline
from .. import tables as table
from ..numbers.angles import atan2
from ..numbers.vectors import dot
from ..surface.records import anchor_of
from ..tables import FRAME_SIZE, MAP_SIZE, Geometry, integer
from .maps import map_row


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
