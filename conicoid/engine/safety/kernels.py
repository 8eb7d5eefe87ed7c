"""Lower bounds of the distance to the nearest wall: packets of points through the tree, the nearest boxes first.

What is told of a point is the least, over all entries, of the largest of what is proved of one: by the boxes that hold
it, by the ball around it, by its walls. Nothing is left out but what is proved to be farther away than that, so neither
the order in which entries are met nor the other points of a packet change a bit of it.
"""

from __future__ import annotations

import math

from ...compiler.jit import helper, inline, kernel
from .. import tables as table
from ..nearest.bounds import entry_bound
from ..nearest.kernels import polygon_near
from ..nearest.room import Room
from ..nearest.search import Around, begin_search, beyond_ball, beyond_box_of, next_near
from ..packets.load import packet_row
from ..surface.quadric import Sphere
from ..tables import POLYGON, Floats, Geometry, halted, length, real
from ..tree.leaf import Item, leaf_at, leaf_ball, leaf_item, leaf_range
from .bodies import entry_of_lanes, fits_lanes
from .rows import (
    AWAY,
    BEST,
    EVERY,
    NEAR,
    Memory,
    X,
    Y,
    Z,
    around_lanes,
    farthest,
    new_memory,
    put_points,
    take_bound,
    take_bounds,
    told,
)
from .surfaces import lane

_FEW, _MANY = 6, 16
"""Up to so many points of a packet, and of those that an entry is near to, are asked alone."""
_BODIES, _SEVERAL = 8, 4.0
"""In scenes of more bodies, points are asked together if their box has sides of no more, in all, than several times the
size that a body has when the scene's box is shared out among all."""
_LOOKED, _SHARE = 1024, 8
"""A packet is given up where, of so many looks at a ball and more, less than one of 8 found it near."""


@inline
def _walls_of(geometry: Geometry, single: Room, item: Item, x: float, y: float, z: float, enough: float) -> float:
    """A lower bound of the distance from one point to the walls of an entry."""
    if item.kind == POLYGON:
        distance, off, _, _, _ = polygon_near(geometry, item.index, x, y, z)
        return max(0.0, distance - off)
    return entry_bound(geometry, single.gates, item.entry, x, y, z, enough)


@helper
def bound_of_point(geometry: Geometry, single: Room, x: float, y: float, z: float, reach: float) -> float:
    """No wall is nearer to a point than this; infinite where none is within reach."""
    way, best, bound = single.scratch.way, reach, math.inf
    around = Around(x, y, z, x, y, z)
    found = next_near(geometry, way, begin_search(geometry, way), around, best)
    while found.code != 0:
        first, last = leaf_range(found.code)
        at, count = leaf_at(geometry, first), last - first
        for k in range(count):
            near = max(found.away, beyond_ball(leaf_ball(geometry, at, count, k), x, y, z))
            if near <= best:
                near = max(near, _walls_of(geometry, single, leaf_item(geometry, at, count, k), x, y, z, best))
                if near <= best:
                    best, bound = near, near
        found = next_near(geometry, way, found.top, around, best)
    return bound


@inline
def _put_boxes(geometry: Geometry, room: Floats, box: int) -> None:
    """AWAY: how far each point is at least from the boxes that hold a leaf."""
    for i in range(EVERY):
        room[AWAY + i] = beyond_box_of(geometry, box, room[X + i], room[Y + i], room[Z + i])


@inline
def _put_balls(room: Floats, ball: Sphere) -> int:
    """NEAR: how far each is from an entry at least; returns to how many that is not too far."""
    near = 0
    for i in range(EVERY):
        beyond = max(room[AWAY + i], beyond_ball(ball, room[X + i], room[Y + i], room[Z + i]))
        room[NEAR + i] = beyond
        near += 1 if beyond <= room[BEST + i] else 0
    return near


@helper
def _meet(geometry: Geometry, memory: Memory, item: Item, near: int) -> None:
    """Take the bounds of an entry, which is near to so many."""
    room = memory.room
    if near > _MANY and fits_lanes(geometry, item.kind, item.index):
        entry_of_lanes(geometry, item.kind, item.index, room)
        take_bounds(room)
        return
    for k in range(64):
        i = lane(k)
        if room[NEAR + i] <= room[BEST + i]:
            x, y, z = room[X + i], room[Y + i], room[Z + i]
            take_bound(room, i, _walls_of(geometry, memory.single, item, x, y, z, room[BEST + i]))


@inline
def _belong_together(geometry: Geometry, around: Around) -> bool:
    """Do the points in a box see about the same part of the scene?"""
    cell = real(geometry, table.EXTENT, 1)
    sides = (around.high_x - around.low_x) + (around.high_y - around.low_y) + (around.high_z - around.low_z)
    return length(geometry, table.ENTRY_KIND) <= _BODIES or sides <= _SEVERAL * cell


@helper
def bound_packet(geometry: Geometry, memory: Memory) -> bool:
    """BEST and FOUND of all lanes; False, and nothing certain, where the points have too little in common."""
    room, way, looks, hits = memory.room, memory.single.scratch.way, 0, 0
    around = around_lanes(room)
    if not _belong_together(geometry, around):
        return False
    found = next_near(geometry, way, begin_search(geometry, way), around, farthest(room))
    while found.code != 0:
        first, last = leaf_range(found.code)
        at, count = leaf_at(geometry, first), last - first
        _put_boxes(geometry, room, found.box)
        for k in range(count):
            near = _put_balls(room, leaf_ball(geometry, at, count, k))
            looks, hits = looks + 64, hits + near
            if near > 0:
                _meet(geometry, memory, leaf_item(geometry, at, count, k), near)
        if looks > _LOOKED and hits * _SHARE < looks:
            return False
        found = next_near(geometry, way, found.top, around, farthest(room))
    return True


@kernel(points="n 3", reach="n", width="picture n", begin="0..end", end="0..n", bounds="out n")
def bounds_of_points(
    geometry: Geometry, points: Floats, reach: Floats, width: int, begin: int, end: int, bounds: Floats
) -> None:
    """bounds[i]: no wall of any body is nearer to points[i]; infinite where none is within reach[i]."""
    memory = new_memory(geometry)
    room, count = memory.room, len(points)
    for packet in range(begin, end):
        if halted(geometry):
            return
        together = put_points(memory, points, reach, packet, width) > _FEW and bound_packet(geometry, memory)
        for row in range(8):
            first, n = packet_row(packet, row, width, count)
            for k in range(n):
                i = first + k
                if together:
                    bounds[i] = told(room, lane(8 * row + k))
                elif not halted(geometry):
                    bounds[i] = bound_of_point(
                        geometry, memory.single, points[i, 0], points[i, 1], points[i, 2], reach[i]
                    )


__all__ = ["bounds_of_points"]
