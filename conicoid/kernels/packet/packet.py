"""A packet of 64 rays: its memory, and the intersection of its lanes with the items of a leaf."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..._jit.decorators import allocator, choose, helper, inline
from ..body.hit import cull_limit, try_entry
from ..body.scratch import Scratch
from ..bvh.culling import highest_bit, lanes_in_ball, lanes_in_ball_from_one, lanes_in_box, lowest_bit
from ..bvh.culling_constants import MOST_CHOSEN
from ..bvh.walk import leaf_ball, leaf_item
from ..tables import BALL, CELL, REGION, Floats, Geometry, Ints, Signs
from .booleans import LEAVES_SIZE, MOST, TRUTHS_SIZE, BooleanLanes, fits_in_lanes, region_lanes
from .cells import ball_lanes, cell_lanes
from .frontier import new_frontier
from .lanes import (
    ALL,
    BEST,
    BODY,
    DOUBT,
    ENTERS,
    ENTRY,
    PLACE,
    SENSE,
    SHARED,
    SIZE,
    START_MARGIN,
    T_MAX,
    WITHIN,
    is_searching,
    lane_hit,
    lane_ray,
    put_slopes,
)

PAIRS = MOST_CHOSEN + 8
"""Begin of the pairs behind the chosen items of a packet: 8 item + group of lanes that may meet the item."""


class Packet(NamedTuple):
    """Memory of a packet."""

    lanes: Floats
    leaves: Floats  # spans of a body's leaves
    truths: Floats  # true inputs of the body's gates
    spans: Ints  # largest number of spans of each leaf
    items: Floats  # a frontier: the part of the scene's tree that the packet may meet, or none
    pending: Any  # int64: the next items that its beam meets; from `PAIRS` on pairs of an item and a group of lanes


@allocator
def new_rows(count: int) -> Floats:
    """Return `count` floats that begin at a cache line, so that each vector of eight lies in one line."""
    room = np.empty(count + 7)
    first = -(room.ctypes.data >> 3) & 7
    return room[first : first + count]


@allocator
def new_packet(geometry: Geometry) -> Packet:
    """Return memory of packets for one thread."""
    lanes, leaves, truths = new_rows(SIZE), new_rows(LEAVES_SIZE), new_rows(TRUTHS_SIZE)
    pending = np.empty(PAIRS + 8 * MOST_CHOSEN + 8, np.int64)
    return Packet(lanes, leaves, truths, np.zeros(MOST, np.int32), new_frontier(), pending)


@inline
def with_lanes(packet: Packet, lanes: Floats) -> Packet:
    """Return a packet of other lanes in the same memory; the frontier must hold for them as well."""
    return Packet(lanes, packet.leaves, packet.truths, packet.spans, packet.items, packet.pending)


@inline
def with_items(packet: Packet, items: Floats) -> Packet:
    """Return the packet with another frontier, which must hold for its rays."""
    return Packet(packet.lanes, packet.leaves, packet.truths, packet.spans, items, packet.pending)


@inline
def boolean_memory(packet: Packet) -> BooleanLanes:
    """Return the part of a packet's memory that its Boolean bodies need."""
    return BooleanLanes(packet.lanes, packet.leaves, packet.truths, packet.spans)


@allocator
def new_lanes() -> Floats:
    """Return memory for the lanes of another packet (`with_lanes`)."""
    return new_rows(SIZE)


@helper
def _one_by_one(geometry: Geometry, scratch: Scratch, lanes: Floats, entry: int, bits: int) -> None:
    """Intersect a large body or sheet with each lane that meets its box, as a single ray (`try_entry`)."""
    while bits != 0:
        i = np.uint64(lowest_bit(bits))
        bits &= bits - 1
        if not is_searching(lanes, i):
            continue
        # The interval of the ray, not the nearest hit: `try_entry` cuts it off itself, with room for ties
        hit = try_entry(geometry, scratch, entry, lane_ray(lanes, i, lanes[T_MAX + i]), lane_hit(lanes, i))
        lanes[BEST + i], lanes[BODY + i], lanes[ENTRY + i] = hit.t, hit.body, hit.entry
        lanes[PLACE + i], lanes[SENSE + i], lanes[ENTERS + i] = hit.place, hit.sense, 1.0 if hit.enters else 0.0
        lanes[WITHIN + i], lanes[DOUBT + i] = cull_limit(hit), 1.0 if hit.unsure else 0.0


@inline
def retire_lanes(lanes: Floats) -> None:
    """Make the lanes with a hit idle: the early out of any-hit queries."""
    for i in range(ALL):
        # An empty interval instead of a mask: every test reads the interval anyway
        lanes[T_MAX + i] = choose(lanes[BEST + i] < math.inf, -math.inf, lanes[T_MAX + i])


@inline
def lanes_in_child(geometry: Geometry, lanes: Floats, at: int) -> int:
    """Return the lanes that meet the box whose six sides are at floats[at::8], as bits."""
    # The inverse directions wait for the first box test, since rays at balls alone need none
    put_slopes(lanes)
    f = geometry.floats
    return lanes_in_box(lanes, f[at], f[at + 8], f[at + 16], f[at + 24], f[at + 32], f[at + 40])


@inline
def lanes_at_ball(geometry: Geometry, lanes: Floats, at: int, stride: int) -> int:
    """Return the lanes that may meet the ball whose four numbers are at floats[at::stride], as bits."""
    f = geometry.floats
    x, y, z, r = f[at], f[at + stride], f[at + 2 * stride], f[at + 3 * stride] + lanes[START_MARGIN]
    if lanes[SHARED] != 0.0:
        return lanes_in_ball_from_one(lanes, x, y, z, r)
    return lanes_in_ball(lanes, x, y, z, r)


@inline
def meet_in_lanes(
    geometry: Geometry, scratch: Scratch, packet: Packet, blocks: Signs, at: int, count: int, k: int, bits: int
) -> None:
    """Intersect item k of the leaf of `count` items at floats[at:] with at least the lanes of a mask.

    Whole groups of eight are tested, from the first to the last lane of the mask. Lanes outside the mask cost time, but
    their hits stay the same, because culled lanes do not meet the item. Keeps every lane's hit the first of all items
    tested.
    """
    # Eight lanes are a vector: a part of one costs as much as the whole
    lanes, first, last = packet.lanes, lowest_bit(bits) & -8, (highest_bit(bits) | 7) + 1
    item = leaf_item(geometry, at, count, k)
    kind, index, body, entry = item
    if len(blocks) > 0 and blocks[body] == 0:
        return
    if kind == BALL:
        ball_lanes(lanes, leaf_ball(geometry, at, count, k), index, entry, body, first, last)
    elif kind == CELL:
        cell_lanes(geometry, lanes, index, entry, body, first, last)
    elif kind == REGION and fits_in_lanes(geometry, index):
        region_lanes(geometry, boolean_memory(packet), item, first, last)
    else:
        _one_by_one(geometry, scratch, lanes, entry, bits)
