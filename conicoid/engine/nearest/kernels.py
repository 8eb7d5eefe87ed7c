"""How far points are from the walls of a scene, exactly."""

from __future__ import annotations

import math

from ...compiler.jit import helper, kernel
from .. import tables as table
from ..tables import BALL, CELL, POLYGON, REGION, SHEET, Floats, Geometry, Ints, Signs, halted, integer
from ..tree.leaf import leaf_at, leaf_ball, leaf_item, leaf_range
from .bounds import entry_bound
from .boxes import reach_of_leaves, try_hard_edges
from .edges import try_edges
from .form import ROUNDED, length_of
from .gather import begin_body, gather_cell, gather_program, is_flat, planes_first
from .outline import nearest_of_polygon
from .room import (
    AT_X,
    BODY,
    ENTRY,
    LOWER,
    NEAREST,
    OF_BODY,
    PLACE,
    SENSE,
    SHEET_OF,
    SURFACES,
    UPPER,
    WITHIN,
    Room,
    limit,
    new_room,
    start,
)  # fmt: skip
from .search import Around, begin_search, beyond_ball, next_near
from .sides import try_sides
from .stationary import try_face
from .walls import Query, keep


@helper
def polygon_near(
    geometry: Geometry, polygon: int, x: float, y: float, z: float
) -> tuple[float, float, float, float, float]:
    """(distance, by how much it may be off, the nearest point) of a whole polygon."""
    vx, vy, vz = nearest_of_polygon(geometry, polygon, x, y, z)
    distance = length_of(vx, vy, vz)
    px, py, pz = x + vx, y + vy, z + vz
    off = ROUNDED * (abs(px) + abs(py) + abs(pz) + abs(x) + abs(y) + abs(z) + distance)
    return distance, off, px, py, pz


@helper
def _try_near(geometry: Geometry, room: Room, at: Query) -> None:
    """Try what was gathered of a body: faces, edges, corners."""
    planes_first(geometry, room)
    if room.sizes[SHEET_OF] == 1:
        try_face(geometry, room, at, 0, is_flat(geometry, room, 0))
    else:
        while True:  # the nearest first
            nearest = -1
            for k in range(room.sizes[SURFACES]):
                open_ = room.bound[k] >= 0.0 and room.bound[k] <= limit(room)
                if open_ and (nearest < 0 or room.bound[k] < room.bound[nearest]):
                    nearest = k
            if nearest < 0:
                break
            try_face(geometry, room, at, nearest, is_flat(geometry, room, nearest))
            room.bound[nearest] = -1.0 - room.bound[nearest]
        for k in range(room.sizes[SURFACES]):
            if room.bound[k] < 0.0:
                room.bound[k] = -1.0 - room.bound[k]
    if try_edges(geometry, room, at):
        try_hard_edges(geometry, room, at)


@helper
def _try_polygon(geometry: Geometry, room: Room, at: Query, polygon: int) -> None:
    """Try a polygon, which may be clipped."""
    program = integer(geometry, table.POLYGON_PROGRAM, polygon)
    distance, off, x, y, z = polygon_near(geometry, polygon, at.x, at.y, at.z)
    if not distance - off <= limit(room):
        return
    begin_body(room, program, integer(geometry, table.POLYGON_SURFACE, polygon))
    if program < 0:
        room.best[LOWER] = min(room.best[LOWER], distance - off)
        room.best[UPPER] = min(room.best[UPPER], distance + off)
        keep(geometry, room, at, 0, x, y, z, distance)
        return
    gather_program(geometry, room, program, at.x, at.y, at.z)
    room.sizes[WITHIN] = polygon + 1
    _try_near(geometry, room, at)
    try_sides(geometry, room, at, polygon)


@helper
def _try_ball(geometry: Geometry, room: Room, at: Query, surface: int) -> None:
    """Try a ball, as a leaf whose one surface is curved."""
    begin_body(room, -1, surface)
    try_face(geometry, room, at, 0, False)


@helper
def try_entry_near(geometry: Geometry, room: Room, at: Query) -> None:
    """Try the walls of an entry."""
    kind, index = integer(geometry, table.ENTRY_KIND, at.entry), integer(geometry, table.ENTRY_INDEX, at.entry)
    if kind == BALL:
        _try_ball(geometry, room, at, index)
    elif kind == POLYGON:
        _try_polygon(geometry, room, at, index)
    elif entry_bound(geometry, room.gates, at.entry, at.x, at.y, at.z, limit(room)) <= limit(room):
        if kind == CELL:
            begin_body(room, -1, -1)
            gather_cell(geometry, room, -1, index, at.x, at.y, at.z)
        elif kind == REGION:
            begin_body(room, index, -1)
            gather_program(geometry, room, index, at.x, at.y, at.z)
            room.best[OF_BODY] = 1.7321 * reach_of_leaves(geometry, room, at)  # the diagonal
        elif kind == SHEET:
            program = integer(geometry, table.SHEET_PROGRAM, index)
            begin_body(room, program, integer(geometry, table.SHEET_SURFACE, index))
            if program >= 0:
                gather_program(geometry, room, program, at.x, at.y, at.z)
        _try_near(geometry, room, at)
    room.best[OF_BODY] = math.inf


@kernel(
    points="n 3", reach="n", begin="0..end", end="0..n", body="out n", entry="out n", place="out n", turn="out n",
    distance="out n", lower="out n", upper="out n", nearest="out n 3",
)  # fmt: skip
def nearest_walls(
    geometry: Geometry, points: Floats, reach: Floats, begin: int, end: int, body: Ints, entry: Ints, place: Ints,
    turn: Signs, distance: Floats, lower: Floats, upper: Floats, nearest: Floats,
) -> None:  # fmt: skip
    """Of each point the nearest wall: whose it is, how far (between lower and upper), and where; none: infinite."""
    room = new_room(geometry)
    way = room.scratch.way
    for i in range(begin, end):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        start(room, reach[i])
        if not halted(geometry):
            around = Around(x, y, z, x, y, z)
            found = next_near(geometry, way, begin_search(geometry, way), around, limit(room))
            while found.code != 0:
                first, last = leaf_range(found.code)
                at, count = leaf_at(geometry, first), last - first
                for k in range(count):
                    if beyond_ball(leaf_ball(geometry, at, count, k), x, y, z) <= limit(room):
                        item = leaf_item(geometry, at, count, k)
                        try_entry_near(geometry, room, Query(x, y, z, item.body, item.entry))
                found = next_near(geometry, way, found.top, around, limit(room))
        best, who = room.best, room.who
        body[i], entry[i], place[i], turn[i] = who[BODY], who[ENTRY], who[PLACE], who[SENSE]
        distance[i], lower[i], upper[i] = best[NEAREST], best[LOWER], best[UPPER]
        for k in range(3):
            nearest[i, k] = best[AT_X + k]


__all__ = ["nearest_walls"]
