"""The points of a packet in lanes, and what is known of each: rows of 64 floats in one block."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ...compiler.jit import allocator, choose, helper, inline
from ..culling import extent
from ..nearest.form import Form
from ..nearest.quick import Search, Turned
from ..nearest.room import Room, new_room
from ..nearest.search import Around
from ..packets.booleans import MOST
from ..packets.lanes import LANES
from ..packets.load import packet_row
from ..tables import Floats, Geometry, Ints

# Where the rows begin
(
    X, Y, Z, BEST, FOUND, AWAY, NEAR, BOUND, CELL, FACE, PLAIN, LEAF, VALUE, OFF, GX, GY, GZ, STEEP, W, LOW, HIGH, DONE,
    F, G0, G1, G2, A0, A1, A2, POLE,
) = (np.uint64(row) for row in range(0, 30 * LANES, LANES))  # fmt: skip
"""The points; walls beyond BEST do not matter; FOUND is 1 where a wall is as near as that. Of an entry: how far its
boxes and its ball are at least (AWAY, NEAR), its bound, that of a cell, of a face, of a quadric by its value alone, of
the box of a leaf. Of a quadric: its form, the search for its nearest point, its equation."""
GATES = 30 * LANES
SIZE = GATES + MOST * LANES
EVERY = np.uint64(LANES)


class Memory(NamedTuple):
    """What a thread needs."""

    room: Floats  # see above
    which: Ints  # the number of each lane's point, -1 for none
    single: Room  # for points that are asked alone


@allocator
def new_memory(geometry: Geometry) -> Memory:
    """Memory for one thread."""
    return Memory(np.zeros(SIZE), np.empty(LANES, np.int32), new_room(geometry))


@helper
def put_points(memory: Memory, points: Floats, reach: Floats, packet: int, width: int) -> int:
    """The points of a packet into lanes; returns how many. Lanes without one repeat the first, and seek nothing."""
    room, which, count, lanes = memory.room, memory.which, len(points), 0
    some, _ = packet_row(packet, 0, width, count)
    if some >= count:
        return 0
    for row in range(8):
        first, n = packet_row(packet, row, width, count)
        for k in range(8):
            lane, i = np.uint64(8 * row + k), first + k if k < n else some
            room[X + lane], room[Y + lane], room[Z + lane] = points[i, 0], points[i, 1], points[i, 2]
            room[BEST + lane], room[FOUND + lane] = reach[i] if k < n else -1.0, 0.0
            which[8 * row + k] = i if k < n else -1
        lanes += n
    return lanes


@inline
def around_lanes(room: Floats) -> Around:
    """The box around the points."""
    low_x, high_x = extent(room, X)
    low_y, high_y = extent(room, Y)
    low_z, high_z = extent(room, Z)
    return Around(low_x, low_y, low_z, high_x, high_y, high_z)


@inline
def farthest(room: Floats) -> float:
    """Beyond this nothing matters to any lane."""
    _, most = extent(room, BEST)
    return most


@inline
def put_form(room: Floats, i: Any, form: Form) -> None:
    """What differs from point to point of a quadric's form."""
    room[VALUE + i], room[OFF + i], room[STEEP + i] = form.value, form.off, form.steep
    room[GX + i], room[GY + i], room[GZ + i] = form.gx, form.gy, form.gz


@inline
def form_of_lane(room: Floats, i: Any, same: Form) -> Form:
    """The form in a lane, of a quadric whose form at any point is at hand."""
    return Form(
        room[VALUE + i], room[OFF + i], room[GX + i], room[GY + i], room[GZ + i],
        same.xx, same.yy, same.zz, same.xy, same.xz, same.yz, same.size, room[STEEP + i],
    )  # fmt: skip


@inline
def put_equation(room: Floats, i: Any, e: Turned) -> None:
    """The secular equation of a lane."""
    room[F + i], room[G0 + i], room[G1 + i], room[G2 + i] = e.value, e.g0, e.g1, e.g2
    room[A0 + i], room[A1 + i], room[A2 + i], room[POLE + i] = e.a0, e.a1, e.a2, e.pole


@inline
def equation_of_lane(room: Floats, i: Any) -> Turned:
    """The same, read."""
    return Turned(
        room[F + i], room[G0 + i], room[G1 + i], room[G2 + i], room[A0 + i], room[A1 + i], room[A2 + i], room[POLE + i]
    )


@inline
def put_search(room: Floats, i: Any, at: Search) -> None:
    """Where the search of a lane is."""
    room[W + i], room[LOW + i], room[HIGH + i], room[DONE + i] = at.w, at.low, at.high, at.done


@inline
def search_of_lane(room: Floats, i: Any) -> Search:
    """The same, read."""
    return Search(room[W + i], room[LOW + i], room[HIGH + i], room[DONE + i])


@inline
def take_bounds(room: Floats) -> None:
    """Keep the bounds of an entry where they are as near as the best, or nearer."""
    for i in range(EVERY):
        bound = max(room[BOUND + i], room[NEAR + i])
        nearer = bound <= room[BEST + i]
        room[BEST + i] = choose(nearer, bound, room[BEST + i])
        room[FOUND + i] = choose(nearer, 1.0, room[FOUND + i])


@inline
def take_bound(room: Floats, i: Any, bound: float) -> None:
    """The same of one lane."""
    bound = max(bound, room[NEAR + i])
    if bound <= room[BEST + i]:
        room[BEST + i], room[FOUND + i] = bound, 1.0


@inline
def told(room: Floats, i: Any) -> float:
    """The bound of a lane; infinite where no wall is within reach."""
    return room[BEST + i] if room[FOUND + i] == 1.0 else math.inf
