"""First hits of coherent rays, 64 at a time: the traversal of a packet, and of the packets of one square of pixels.

A packet tests the items of its frontier, the nearest first. Without a frontier, and below items that are nodes, it
traverses the tree as one beam, which is tested against all eight children of a node at once; only boxes that the beam
meets are tested with the lanes. The beam ends where the last of its lanes does (`shorten_beam`), so no lane meets what
it culls.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..._jit.decorators import allocator, helper, inline
from ..body.scratch import Scratch
from ..bvh.culling import (
    BEAM,
    BOX_OR_BALL,
    CODE,
    ENTERED,
    FIRST,
    HIGH_I,
    HIGH_O,
    LAST,
    LOW_I,
    LOW_O,
    balls_in_beam,
    bit_count,
    group_in_ball,
    hit_items,
    lowest_bit,
    put_groups,
    put_numbers,
)
from ..bvh.walk import (
    is_round,
    leaf_at,
    leaf_ball,
    leaf_range,
    next_leaf,
    push_roots,
    put_on_stack,
    reciprocal,
    scene_tree,
)
from ..tables import Floats, Geometry, Signs, box_at, whole
from .frontier import ITEM_COUNT, FrontierLevel, find_frontier, new_frontier, new_level
from .lanes import (
    BEAM_AT,
    GROUP_BEAMS,
    GROUPS_AT,
    LANES,
    START_MARGIN,
    WAYS_AT,
    lane_sight,
    put_group_beams,
    shorten_beam,
)
from .packet import PAIRS, Packet, lanes_at_ball, lanes_in_child, meet_in_lanes, retire_lanes, with_items

# The traversal of one packet

_LOT = 32  # most items that a packet takes at a time
_MANY = 100  # from this many items of a quarter of a tile on they are small, and few groups of lanes meet each


@inline
def _choose(packet: Packet, item: int, items: int, most: int) -> tuple[int, int]:
    """Choose `most` items, or a few more, from number `item` on that the beam meets.

    Returns how many it has chosen, and the number with which to continue.
    """
    seen, lanes, count = packet.items, packet.lanes, 0
    # Eight items at a time, so that `most` may be exceeded by seven
    while count < most and item < items and seen[ENTERED + item] <= lanes[BEAM_AT + LAST]:
        bits = hit_items(seen, item, lanes, BEAM_AT) & ((1 << min(8, items - item)) - 1)
        put_numbers(item, bits, packet.pending, count)
        count += bit_count(bits)
        item += 8
    return count, item


@inline
def _ball_of(geometry: Geometry, items: Floats, k: int) -> tuple[int, int, int]:
    """Return (begin of its leaf, number of items in the leaf, place in the leaf) of an item that is a ball."""
    first, last = leaf_range(whole(items[CODE + k]))
    return leaf_at(geometry, first), last - first, -2 - whole(items[BOX_OR_BALL + k])


@inline
def _group_at_ball(geometry: Geometry, packet: Packet, pair: int) -> int:
    """Return the mask of the lanes of a group that may meet the ball of a pair (`PAIRS`)."""
    at, size, place = _ball_of(geometry, packet.items, pair >> 3)
    x, y, z, r = leaf_ball(geometry, at, size, place)
    return group_in_ball(packet.lanes, pair & 7, x, y, z, r + packet.lanes[START_MARGIN])


@inline
def _put_pairs(geometry: Geometry, packet: Packet, chosen: int) -> int:
    """Pair the balls among the chosen items with the groups of lanes that may meet them; return the number of pairs.

    Each step handles all balls, without branches, so that no test waits for the result of the one before.
    """
    items, pending, count, rest = packet.items, packet.pending, 0, 0
    split = packet.lanes[GROUP_BEAMS] != 0.0
    for j in range(chosen):
        k = packet.pending[j]
        if items[BOX_OR_BALL + k] >= -1.0:
            continue
        if split:
            count += put_groups(items, k, k, packet.lanes, GROUPS_AT, pending, PAIRS + count)
        else:
            pending[PAIRS + count] = 8 * k
            count += 1
    if not split:
        return count
    for j in range(count):
        pending[PAIRS + rest] = pending[PAIRS + j]
        rest += 1 if _group_at_ball(geometry, packet, pending[PAIRS + j]) != 0 else 0
    return rest


@inline
def _meet_chosen(
    geometry: Geometry, scratch: Scratch, packet: Packet, blocks: Signs, any_hit: bool, chosen: int
) -> int:
    """Intersect the balls among the chosen items, and push the others on the stack; return its height."""
    way, lanes, items, top = scratch.way, packet.lanes, packet.items, 0
    # From the last to the first, so that the nearest lies on top of the stack
    for j in range(chosen - 1, -1, -1):
        k = packet.pending[j]
        if items[BOX_OR_BALL + k] >= -1.0:
            put_on_stack(way, top, items[CODE + k], items[BOX_OR_BALL + k], items[ENTERED + k])
            top += 1
    count = _put_pairs(geometry, packet, chosen)
    for j in range(count):
        pair = packet.pending[PAIRS + j]
        at, size, place = _ball_of(geometry, items, pair >> 3)
        if lanes[GROUP_BEAMS] != 0.0:
            bits = _group_at_ball(geometry, packet, pair) << 8 * (pair & 7)  # again: hits may have shortened lanes
        else:
            bits = lanes_at_ball(geometry, lanes, at + place, size)
        if bits != 0:
            meet_in_lanes(geometry, scratch, packet, blocks, at, size, place, bits)
            if any_hit:
                retire_lanes(lanes)
    if count > 0:
        shorten_beam(lanes)
    return top


@inline
def _meet_balls(
    geometry: Geometry, scratch: Scratch, packet: Packet, blocks: Signs, any_hit: bool, at: int, count: int
) -> None:
    """Intersect a leaf of balls: the beam culls those that it misses, the lanes test the others, nearest first."""
    lanes, near = packet.lanes, scratch.way
    bits, near[0] = 1, -math.inf
    if count > 1:
        bits = balls_in_beam(geometry.floats, at, count, count, lanes, BEAM_AT, near)
    while bits != 0:
        k, others = lowest_bit(bits), bits & (bits - 1)
        # A search for the least, since up to fifteen balls do not repay a sort
        while others != 0:
            other = lowest_bit(others)
            others &= others - 1
            k = other if near[other] < near[k] else k
        bits &= ~(1 << k)
        # It is the nearest of those left, so that all others are behind the hits too
        if near[k] > lanes[BEAM_AT + LAST]:
            break
        hits = lanes_at_ball(geometry, lanes, at + k, count)
        if hits != 0:
            meet_in_lanes(geometry, scratch, packet, blocks, at, count, k, hits)
            if any_hit:
                retire_lanes(lanes)
            shorten_beam(lanes)


@helper
def trace_packet(geometry: Geometry, scratch: Scratch, packet: Packet, blocks: Signs, any_hit: bool) -> None:
    """Find the first hits, or any hits, of the rays in the lanes, which are `is_ordinary`; `lane_hit` reads them.

    Only bodies with blocks[body] != 0 count, or all, if `blocks` is empty. Relies on `prepare_lanes` and
    `put_lane_beam` having been called. A frontier must hold everything that the rays can meet at t >= 0.
    """
    way, lanes = scratch.way, packet.lanes
    items, item, top, most = whole(packet.items[ITEM_COUNT]), 0, 0, 2
    if items < 0 or lanes[BEAM_AT + FIRST] < 0.0:  # a frontier holds for t >= 0 only
        items, top = 0, push_roots(geometry, way, scene_tree(geometry))
    if items > _MANY:  # small items: groups of eight lanes have beams of their own
        put_group_beams(lanes)
    while True:
        if top == 0:
            # Few at first: items hidden behind their hits need no test
            chosen, item = _choose(packet, item, items, most)
            most = min(2 * most, _LOT)
            if chosen == 0:
                break
            top = _meet_chosen(geometry, scratch, packet, blocks, any_hit, chosen)
            continue
        code, box, top = next_leaf(geometry, way, lanes, BEAM_AT, top)
        if code == 0:  # nothing is left on the stack: choose the next items
            continue
        begin, end = leaf_range(code)
        at, count = leaf_at(geometry, begin), end - begin
        if box >= 0 and is_round(geometry, at, count):
            _meet_balls(geometry, scratch, packet, blocks, any_hit, at, count)
            continue
        bits = -1  # all lanes, for a leaf without a box
        if box >= 0:
            bits = lanes_in_child(geometry, lanes, box_at(geometry, box))
            if bits == 0:
                continue
        for k in range(count):
            meet_in_lanes(geometry, scratch, packet, blocks, at, count, k, bits)
        if any_hit:
            retire_lanes(lanes)
        shorten_beam(lanes)


# A square of pixels: packets of many samples, which see about the same, share a frontier
#
# The first packet goes down the tree from its roots. For the second a frontier (frontier.py) is found, of a beam a
# little wider than its own. Later packets use it as long as their beams lie within that beam, and widen it otherwise.
# Rays from their hits to a light may do the same, with a square of their own: their beam begins at the light.

_MARGIN = 0.25
"""Share of a packet's extent by which the beam is widened on each side: samples lie anywhere in their pixels."""
_MOST = 4
"""Most frontiers of a square: packets whose beams differ even more go down the tree one by one."""

# Elements of `known`: the corners of origins and of directions, the number of the square, the numbers of packets and of
# frontiers so far, and the furthest t that the first packet saw
_LOW_O, _HIGH_O, _LOW_D, _HIGH_D = 0, 3, 6, 9
_NUMBER, _PACKETS, _FOUND, _HORIZON = 12, 13, 14, 15


class PixelSquare(NamedTuple):
    """Memory of a square."""

    items: Floats  # a frontier
    known: Floats  # see `_LOW_O`
    beam: Floats
    level: FrontierLevel


@allocator
def new_square() -> PixelSquare:
    """Return memory of squares for one thread."""
    ranges = np.zeros(16)
    ranges[_NUMBER] = -1.0
    return PixelSquare(new_frontier(), ranges, np.empty(BEAM), new_level())


@inline
def _holds(ranges: Floats, lanes: Floats) -> bool:
    """True if the beam of a packet lies within the beam of the frontier."""
    inside = True
    for axis in range(3):
        inside &= ranges[_LOW_O + axis] <= lanes[BEAM_AT + LOW_O + axis]
        inside &= ranges[_HIGH_O + axis] >= lanes[BEAM_AT + HIGH_O + axis]
        inside &= ranges[_LOW_D + axis] <= lanes[WAYS_AT + axis]
        inside &= ranges[_HIGH_D + axis] >= lanes[WAYS_AT + 3 + axis]
    return inside


@inline
def _widen(ranges: Floats, at: int, low: float, high: float, is_first: bool) -> None:
    """Extend two corners along one axis by an interval and its margin; `is_first` replaces them."""
    # A wider beam finds some items too many, but a new frontier costs more than these
    margin = _MARGIN * (high - low)
    low, high = low - margin, high + margin
    ranges[at] = low if is_first else min(low, ranges[at])
    ranges[at + 3] = high if is_first else max(high, ranges[at + 3])


@helper
def _find(geometry: Geometry, square: PixelSquare, lanes: Floats) -> None:
    """Find a frontier that holds for a packet and for those before it."""
    ranges, beam = square.known, square.beam
    is_first = ranges[_FOUND] == 0.0
    ranges[_FOUND] += 1.0
    for axis in range(3):
        low, high = lanes[BEAM_AT + LOW_O + axis], lanes[BEAM_AT + HIGH_O + axis]
        _widen(ranges, _LOW_O + axis, low, high, is_first)
        _widen(ranges, _LOW_D + axis, lanes[WAYS_AT + axis], lanes[WAYS_AT + 3 + axis], is_first)
        beam[LOW_O + axis], beam[HIGH_O + axis] = ranges[_LOW_O + axis], ranges[_HIGH_O + axis]
        beam[LOW_I + axis], beam[HIGH_I + axis] = reciprocal(ranges[_LOW_D + axis]), reciprocal(ranges[_HIGH_D + axis])
    # Later packets may see farther than this one
    beam[FIRST], beam[LAST] = 0.0, math.inf
    find_frontier(geometry, square.items, square.level, beam, 0, scene_tree(geometry), ranges[_HORIZON])


@inline
def _follow(geometry: Geometry, square: PixelSquare, lanes: Floats, number: int) -> bool:
    """True if the square `number` has a frontier for a packet; finds one where that may pay."""
    ranges = square.known
    # The memory is the thread's, which takes one square after the other
    if ranges[_NUMBER] != number:
        ranges[_NUMBER], ranges[_PACKETS], ranges[_FOUND] = number, 0.0, 0.0
    ranges[_PACKETS] += 1.0
    # A square of one packet would not repay a frontier
    if ranges[_PACKETS] == 1.0 or lanes[BEAM_AT + FIRST] < 0.0:
        return False
    if ranges[_FOUND] == 0.0 or not _holds(ranges, lanes):
        # Rays that scatter so much, behind a rough mirror say, share too little
        if ranges[_FOUND] >= _MOST:
            return False
        _find(geometry, square, lanes)
    return True


@inline
def trace_square(
    geometry: Geometry, scratch: Scratch, packet: Packet, square: PixelSquare, number: int, blocks: Signs, any_hit: bool
) -> None:
    """`trace_packet` of one packet of the square `number`; another number starts a new square.

    Relies on the packet's beam having corners of directions (`put_lane_beam`, `put_beam_from`).
    """
    items = square.items if _follow(geometry, square, packet.lanes, number) else packet.items
    trace_packet(geometry, scratch, with_items(packet, items), blocks, any_hit)
    if square.known[_PACKETS] == 1.0:
        # The first packet shows how far the others will see, if most of its rays hit something
        furthest, hits = lane_sight(packet.lanes)
        square.known[_HORIZON] = furthest if 2.0 * hits > LANES and not any_hit else math.inf
