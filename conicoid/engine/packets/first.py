"""First hits of coherent rays, 64 at a time.

A packet tests the items of its frontier, the nearest first. Where there is none, and below items that are nodes, it
traverses the tree as one beam, which is tested against all eight children of a node at once; only what the beam meets
is tested by the lanes. The beam ends where the last of its lanes does (`shorten_beam`), so what it culls no lane meets.
"""

from __future__ import annotations

import math

from ...compiler.jit import helper, inline
from ..body.scratch import Scratch
from ..culling import (
    BOX_OR_BALL,
    CODE,
    ENTERED,
    FIRST,
    LAST,
    balls_in_beam,
    bit_count,
    group_in_ball,
    items_met,
    lowest_bit,
    put_groups,
    put_numbers,
)
from ..culling.layout import MOST_CHOSEN
from ..tables import Floats, Geometry, Signs, box_at, whole
from ..tree.leaf import is_round, leaf_at, leaf_ball, leaf_range
from ..tree.walk import next_leaf, push_roots, put_on_stack, scene_tree
from .crowd import open_crowd
from .frontier import ITEM_COUNT
from .lanes import (
    BEAM_AT,
    GROUP_BEAMS,
    GROUPS_AT,
    put_group_beams,
    shorten_beam,
)
from .packet import PAIRS, Packet, lanes_at_ball, lanes_in_child, meet_in_lanes, retire
from .rounds import meet_round

_LOT = 32  # so many items are taken at a time, at most, where they are no crowd
_MANY = 100  # items that a quarter of a tile sees: they are small then, and met by few groups of lanes


@inline
def _choose(packet: Packet, item: int, items: int, most: int) -> tuple[int, int]:
    """Find `most` of the items from number `item` on that the beam meets, or a few more.

    Returns how many there are, and with which number to go on.
    """
    seen, lanes, count = packet.items, packet.lanes, 0
    while count < most and item < items and seen[ENTERED + item] <= lanes[BEAM_AT + LAST]:
        bits = items_met(seen, item, lanes, BEAM_AT) & ((1 << min(8, items - item)) - 1)
        put_numbers(item, bits, packet.asked, count)
        count += bit_count(bits)
        item += 8
    return count, item


@inline
def _ball_of(geometry: Geometry, items: Floats, k: int) -> tuple[int, int, int]:
    """(where its leaf begins, the leaf's length, its place there) of an item that is a ball."""
    first, last = leaf_range(whole(items[CODE + k]))
    return leaf_at(geometry, first), last - first, -2 - whole(items[BOX_OR_BALL + k])


@inline
def _group_at_ball(geometry: Geometry, packet: Packet, pair: int) -> int:
    """A mask of the lanes of a group that may meet a ball; see `PAIRS`."""
    at, size, place = _ball_of(geometry, packet.items, pair >> 3)
    x, y, z, r = leaf_ball(geometry, at, size, place)
    return group_in_ball(packet.lanes, pair & 7, x, y, z, r)


@inline
def _put_pairs(geometry: Geometry, packet: Packet, chosen: int) -> int:
    """Pair the balls among the chosen items with the groups of lanes that may meet them; returns how many pairs.

    Step by step for all of them, without branches, so that no test waits for the outcome of the one before.
    """
    items, asked, count, kept = packet.items, packet.asked, 0, 0
    split = packet.lanes[GROUP_BEAMS] != 0.0
    for j in range(chosen):
        k = packet.asked[j]
        if items[BOX_OR_BALL + k] >= -1.0:
            continue
        if split:
            count += put_groups(items, k, k, packet.lanes, GROUPS_AT, asked, PAIRS + count)
        else:
            asked[PAIRS + count] = 8 * k
            count += 1
    if not split:
        return count
    for j in range(count):
        asked[PAIRS + kept] = asked[PAIRS + j]
        kept += 1 if _group_at_ball(geometry, packet, asked[PAIRS + j]) != 0 else 0
    return kept


@inline
def _meet_chosen(
    geometry: Geometry, scratch: Scratch, packet: Packet, blocks: Signs, any_hit: bool, chosen: int
) -> int:
    """Intersect the balls among the chosen items. The others are pushed on the stack, whose height is returned."""
    way, lanes, items, top = scratch.way, packet.lanes, packet.items, 0
    for j in range(chosen - 1, -1, -1):
        k = packet.asked[j]
        if items[BOX_OR_BALL + k] >= -1.0:
            put_on_stack(way, top, items[CODE + k], items[BOX_OR_BALL + k], items[ENTERED + k])
            top += 1
    count = _put_pairs(geometry, packet, chosen)
    for j in range(count):
        pair = packet.asked[PAIRS + j]
        at, size, place = _ball_of(geometry, items, pair >> 3)
        if lanes[GROUP_BEAMS] != 0.0:
            met = _group_at_ball(geometry, packet, pair) << 8 * (pair & 7)  # again: a lane may have met something
        else:
            met = lanes_at_ball(geometry, lanes, at + place, size)
        if met != 0:
            meet_in_lanes(geometry, scratch, packet, blocks, at, size, place, met)
            if any_hit:
                retire(lanes)
    if count > 0:
        shorten_beam(lanes)
    return top


@inline
def _meet_balls(
    geometry: Geometry, scratch: Scratch, packet: Packet, blocks: Signs, any_hit: bool, at: int, count: int
) -> None:
    """A leaf of balls: the beam culls those that it misses, the lanes test the others, the nearest first."""
    lanes, near = packet.lanes, scratch.way
    bits, near[0] = 1, -math.inf
    if count > 1:
        bits = balls_in_beam(geometry.floats, at, count, count, lanes, BEAM_AT, near)
    while bits != 0:
        k, others = lowest_bit(bits), bits & (bits - 1)
        while others != 0:
            other = lowest_bit(others)
            others &= others - 1
            k = other if near[other] < near[k] else k
        bits &= ~(1 << k)
        if near[k] > lanes[BEAM_AT + LAST]:
            break
        met = lanes_at_ball(geometry, lanes, at + k, count)
        if met != 0:
            meet_in_lanes(geometry, scratch, packet, blocks, at, count, k, met)
            if any_hit:
                retire(lanes)
            shorten_beam(lanes)


@helper
def trace_packet(geometry: Geometry, scratch: Scratch, packet: Packet, blocks: Signs, any_hit: bool) -> None:
    """First hits, or any, of the rays in the lanes, which are `ordinary`; see `lane_hit`.

    Only bodies with blocks[body] != 0 count, or all, if `blocks` is empty. Relies on `prepare_lanes` and
    `put_lane_beam` having been called and, where there is a frontier, on its holding all that they can meet at t >= 0.
    """
    way, lanes = scratch.way, packet.lanes
    items, item, top, most = whole(packet.items[ITEM_COUNT]), 0, 0, 2
    if items < 0 or lanes[BEAM_AT + FIRST] < 0.0:  # a tile sees what lies before it
        items, top = 0, push_roots(geometry, way, scene_tree(geometry))
    crowded = open_crowd(packet.crowd, lanes, items)
    if items > _MANY or crowded:
        put_group_beams(lanes)
    if crowded:
        most = MOST_CHOSEN - 8
    while True:
        if top == 0:
            # Few at first: what they hide need not be tested
            chosen, item = _choose(packet, item, items, most)
            most = most if crowded else min(2 * most, _LOT)
            if chosen == 0:
                break
            if crowded:
                chosen = meet_round(geometry, scratch, packet, blocks, any_hit, chosen, False)
                chosen = meet_round(geometry, scratch, packet, blocks, any_hit, chosen, True)
            top = _meet_chosen(geometry, scratch, packet, blocks, any_hit, chosen)
            continue
        code, box, top = next_leaf(geometry, way, lanes, BEAM_AT, top)
        if code == 0:
            continue
        begin, end = leaf_range(code)
        at, count = leaf_at(geometry, begin), end - begin
        if box >= 0 and is_round(geometry, at, count):
            _meet_balls(geometry, scratch, packet, blocks, any_hit, at, count)
            continue
        met = -1
        if box >= 0:
            met = lanes_in_child(geometry, lanes, box_at(geometry, box))
            if met == 0:
                continue
        for k in range(count):
            meet_in_lanes(geometry, scratch, packet, blocks, at, count, k, met)
        if any_hit:
            retire(lanes)
        shorten_beam(lanes)
