"""The nearest walls of points: search through the tree, nearest boxes first, and the walls of each near entry."""

from __future__ import annotations

import math
from typing import NamedTuple

from ..._jit.decorators import helper, inline, kernel
from .. import tables as table
from ..bvh.walk import (
    ITS_BOX,
    ITS_CODE,
    ITS_T,
    leaf_at,
    leaf_ball,
    leaf_item,
    leaf_range,
    on_stack,
    push_roots,
    put_on_stack,
    scene_tree,
)
from ..surface.quadric import SphereRecord
from ..tables import (
    BALL,
    CELL,
    POLYGON,
    REGION,
    SHEET,
    Floats,
    Geometry,
    Ints,
    Signs,
    box_at,
    integer,
    is_halted,
    node_at,
)
from .edges import reach_of_leaves, try_edges, try_hard_edges
from .form import ROUNDED, form_at, length_of
from .neighbourhood import (
    AT_X,
    BODY,
    ENTRY,
    LOWER,
    MOST_IN_DOUBT,
    NEAREST,
    OF_BODY,
    PLACE,
    SENSE,
    SHEET_OF,
    SURFACES,
    UPPER,
    WITHIN,
    Neighbourhood,
    WallQuery,
    begin_body,
    box_length,
    distance_outside,
    entry_bound,
    gather_cell,
    gather_program,
    is_flat,
    limit,
    new_room,
    planes_first,
    reset_nearest,
)
from .projection import nearest_of_polygon
from .stationary import try_face
from .walls import keep_wall, try_sides


class PointBox(NamedTuple):
    """A box around the query points; for a single point it is that point."""

    low_x: float
    low_y: float
    low_z: float
    high_x: float
    high_y: float
    high_z: float


class NearLeaf(NamedTuple):
    """The next leaf of a search: its code, 0 for none; its box, -1 for none; a lower bound of its distance."""

    code: int
    box: int
    distance: float
    top: int  # the height of the stack


@inline
def begin_search(geometry: Geometry, way: Floats) -> int:
    """Start a search at the roots, and at leaves without a box; return the height of the stack."""
    return push_roots(geometry, way, scene_tree(geometry))


@inline
def distance_to_box(floats: Floats, at: int, around: PointBox) -> float:
    """Return a lower bound of the distance from `around` to a box, whose six sides are 8 apart from floats[at] on."""
    return box_length(
        distance_outside(floats[at], floats[at + 24], around.low_x, around.high_x),
        distance_outside(floats[at + 8], floats[at + 32], around.low_y, around.high_y),
        distance_outside(floats[at + 16], floats[at + 40], around.low_z, around.high_z),
    )


@inline
def distance_to_node(geometry: Geometry, box: int, x: float, y: float, z: float) -> float:
    """Return a lower bound of the distance from a point to a box of the tree; 0 for no box (-1)."""
    if box < 0:
        return 0.0
    return distance_to_box(geometry.floats, box_at(geometry, box), PointBox(x, y, z, x, y, z))


@inline
def distance_to_ball(ball: SphereRecord, x: float, y: float, z: float) -> float:
    """Return a lower bound of the distance to a ball around an entry; 0 within."""
    distance = length_of(x - ball.x, y - ball.y, z - ball.z)
    # Differences of coordinates round by shares of these, not of the distance
    off = ROUNDED * (abs(ball.x) + abs(ball.y) + abs(ball.z) + distance)
    beyond = distance - ball.radius - off
    return beyond if beyond > 0.0 else 0.0


@helper
def next_near_leaf(geometry: Geometry, way: Floats, top: int, around: PointBox, limit: float) -> NearLeaf:
    """Return the next leaf that is not farther away than a limit.

    Invariant: the stack holds every node and leaf that was found near and not visited, with a lower bound of its
    distance. The nearest child of a node is on top. Boxes contain those of their children, and rounding keeps order: so
    the distance of a leaf is the largest over all boxes that contain it.
    """
    while top > 0:
        top -= 1
        here = on_stack(top)
        if way[here + ITS_T] > limit:
            continue
        code = int(way[here + ITS_CODE])
        if code < 0:
            return NearLeaf(code, int(way[here + ITS_BOX]), max(0.0, way[here + ITS_T]), top)
        base, at = top, node_at(geometry, code)
        for i in range(8):
            child = integer(geometry, table.NODE_CHILDREN, 8 * code + i)
            if child == 0:
                continue
            distance = distance_to_box(geometry.floats, at + i, around)
            # An empty box is infinitely far away, and an infinite limit would admit it
            if distance > limit or distance == math.inf:
                continue
            slot = top
            while slot > base and way[on_stack(slot - 1) + ITS_T] < distance:
                before = on_stack(slot - 1)
                put_on_stack(way, slot, way[before], way[before + 1], way[before + 2])
                slot -= 1
            put_on_stack(way, slot, float(child), float(8 * code + i), distance)
            top += 1
    return NearLeaf(0, -1, 0.0, 0)


# The walls of an entry


@helper
def polygon_distance(
    geometry: Geometry, polygon: int, x: float, y: float, z: float
) -> tuple[float, float, float, float, float]:
    """Return (distance, its error bound, nearest point x, y, z) of a whole polygon."""
    vx, vy, vz = nearest_of_polygon(geometry, polygon, x, y, z)
    distance = length_of(vx, vy, vz)
    px, py, pz = x + vx, y + vy, z + vz
    # Its plane and its corners are as well known as each other
    off = form_at(geometry, integer(geometry, table.POLYGON_SURFACE, polygon), x, y, z).off
    off += ROUNDED * (abs(px) + abs(py) + abs(pz) + abs(x) + abs(y) + abs(z) + distance)
    return distance, off, px, py, pz


@helper
def _try_near(geometry: Geometry, room: Neighbourhood, at: WallQuery) -> None:
    """Try the gathered faces of a body, then its edges and corners."""
    planes_first(geometry, room)
    if room.sizes[SHEET_OF] == 1:
        try_face(geometry, room, at, 0, is_flat(geometry, room, 0))
    else:
        while True:  # the nearest first; a tried surface gets a negative bound until all are tried
            nearest = -1
            for k in range(room.sizes[SURFACES]):
                open_ = room.bound[k] >= 0.0 and room.bound[k] <= limit(room)
                if open_ and (nearest < 0 or room.bound[k] < room.bound[nearest]):
                    nearest = k
            if nearest < 0:
                break
            try_face(geometry, room, at, nearest, is_flat(geometry, room, nearest))
            # A mark that keeps the bound: -1 - b is negative, and gives b back
            room.bound[nearest] = -1.0 - room.bound[nearest]
        for k in range(room.sizes[SURFACES]):
            if room.bound[k] < 0.0:
                room.bound[k] = -1.0 - room.bound[k]
    if try_edges(geometry, room, at):
        try_hard_edges(geometry, room, at)


@helper
def _try_polygon(geometry: Geometry, room: Neighbourhood, at: WallQuery, polygon: int) -> float:
    """Try a polygon, which may be clipped; return a lower bound of its distance."""
    program = integer(geometry, table.POLYGON_PROGRAM, polygon)
    distance, off, x, y, z = polygon_distance(geometry, polygon, at.x, at.y, at.z)
    # `not <=`, so that NaN counts as too far
    if not distance - off <= limit(room):
        return distance - off
    # Only now: most polygons are out of reach by their outline alone
    begin_body(room, program, integer(geometry, table.POLYGON_SURFACE, polygon))
    if program < 0:
        room.best[LOWER] = min(room.best[LOWER], distance - off)
        room.best[UPPER] = min(room.best[UPPER], distance + off)
        keep_wall(geometry, room, at, 0, x, y, z, distance)
        return distance - off
    gather_program(geometry, room, program, at.x, at.y, at.z)
    room.sizes[WITHIN] = polygon + 1
    _try_near(geometry, room, at)
    try_sides(geometry, room, at, polygon)
    return distance - off


@helper
def try_entry_walls(geometry: Geometry, room: Neighbourhood, at: WallQuery, near: float) -> None:
    """Try the walls of an entry, which are at least `near` away.

    Its certified bound, which is that of `bound_of_point`, is not given up for a candidate's: so the lower bound of an
    exact distance is never below the bound of a query without one.
    """
    before, least = room.best[LOWER], 0.0
    kind, index = integer(geometry, table.ENTRY_KIND, at.entry), integer(geometry, table.ENTRY_INDEX, at.entry)
    if kind == POLYGON:
        least = max(near, _try_polygon(geometry, room, at, index))
    else:
        least = max(near, entry_bound(geometry, room.gates, at.entry, at.x, at.y, at.z, limit(room)))
        if not least <= limit(room) or least == math.inf:
            return
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
        if kind == BALL:
            begin_body(room, -1, index)
            try_face(geometry, room, at, 0, False)
        else:
            _try_near(geometry, room, at)
    room.best[OF_BODY] = math.inf
    room.best[LOWER] = min(before, max(room.best[LOWER], least))


@kernel(
    points="n 3", reach="n", known="k", begin="0..end", end="0..n", body="out n", entry="out n", place="out n",
    turn="out n", distance="out n", lower="out n", upper="out n", nearest="out n 3", doubts="out n 9",
)  # fmt: skip
def nearest_walls(
    geometry: Geometry, points: Floats, reach: Floats, known: Ints, begin: int, end: int, body: Ints, entry: Ints,
    place: Ints, turn: Signs, distance: Floats, lower: Floats, upper: Floats, nearest: Floats, doubts: Ints,
) -> None:  # fmt: skip
    """Find the nearest wall of each of points begin..end within its reach: body and face, distance, bounds and point.

    The exact distance lies between `lower` and `upper`. Without a wall the body is -1 and distances are infinite.
    `known` and `doubts` are those of a `Neighbourhood`.
    """
    room = new_room(geometry, known)
    way = room.scratch.way
    for i in range(begin, end):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        reset_nearest(room, reach[i])
        if not is_halted(geometry):
            around = PointBox(x, y, z, x, y, z)
            found = next_near_leaf(geometry, way, begin_search(geometry, way), around, limit(room))
            while found.code != 0:
                first, last = leaf_range(found.code)
                at, count = leaf_at(geometry, first), last - first
                for k in range(count):
                    near = max(found.distance, distance_to_ball(leaf_ball(geometry, at, count, k), x, y, z))
                    if near <= limit(room):
                        item = leaf_item(geometry, at, count, k)
                        try_entry_walls(geometry, room, WallQuery(x, y, z, item.body, item.entry), near)
                found = next_near_leaf(geometry, way, found.top, around, limit(room))
        best, who = room.best, room.who
        body[i], entry[i], place[i], turn[i] = who[BODY], who[ENTRY], who[PLACE], who[SENSE]
        distance[i], lower[i], upper[i] = best[NEAREST], best[LOWER], best[UPPER]
        for k in range(3):
            nearest[i, k] = best[AT_X + k]
        for k in range(1 + MOST_IN_DOUBT):
            doubts[i, k] = room.doubt[k]
