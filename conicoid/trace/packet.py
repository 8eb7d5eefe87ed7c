"""First hits of coherent rays, 64 at a time.

A packet goes down the tree as one beam, which is tested against all eight children of a node at
once; only what it reaches is asked by the lanes.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..geometry import tables as table
from ..geometry.tables import BALL, CELL, REGION, Floats, Geometry, Ints, Signs, whole
from ..jit import allocator, choose, helper, inline
from .frontier import Frontier, new_frontier
from .kernels import scene_tree, try_entry, within
from .lane_cells import ball_lanes, cell_lanes
from .lane_regions import LEAVES_SIZE, MOST, TRUTHS_SIZE, in_lanes, region_lanes
from .lanes import (
    BEAM_AT,
    BEST,
    BODY,
    DOUBT,
    ENTERS,
    ENTRY,
    GROUP_BEAMS,
    GROUPS_AT,
    PLACE,
    SENSE,
    SIZE,
    T_MAX,
    T_MIN,
    WITHIN,
    eights,
    lane_hit,
    lane_ray,
    put_group_beams,
    put_slopes,
    shorten_beam,
)  # fmt: skip
from .leaf import is_round, leaf_at, leaf_ball, leaf_item, leaf_range
from .scratch import Scratch
from .simd import (
    BOX,
    CODE,
    ENTERED,
    FIRST,
    LAST,
    balls_in_beam,
    bit_count,
    boxes_met,
    group_in_ball,
    highest_bit,
    items_met,
    lanes_in_ball,
    lanes_in_box,
    put_groups,
    put_numbers,
    lowest_bit,
)
from .walk import push_met, push_roots


_CHOSEN = 32
_MANY = 100  # items that a quarter of a tile sees: balls are small then, and met by few groups


class Packet(NamedTuple):
    """Memory of a packet."""

    lanes: Floats
    leaves: Floats  # spans of a body's leaves
    truths: Floats  # true inputs of its gates
    spans: Ints  # how many spans each leaf has, at most
    frontier: Frontier  # what of the scene's tree may be met, if that is known
    chosen: Any  # (_CHOSEN + 8,) int64: items that its beam meets
    pairs: Any  # (8 * _CHOSEN + 64,) int64: items and groups that may meet them


@allocator
def _aligned(count: int) -> Floats:
    """Room for some floats that begins where a line of the cache does: vectors of eight lie in one line each."""
    room = np.empty(count + 7)
    first = -(room.ctypes.data >> 3) & 7
    return room[first : first + count]


@allocator
def new_packet() -> Packet:
    """Memory for one thread."""
    lanes, leaves, truths = _aligned(SIZE), _aligned(LEAVES_SIZE), _aligned(TRUTHS_SIZE)
    return Packet(lanes, leaves, truths, np.zeros(MOST, np.int32), new_frontier(),
        np.empty(_CHOSEN + 16, np.int64), np.empty(8 * _CHOSEN + 128, np.int64))


@helper
def _one_by_one(geometry: Geometry, scratch: Scratch, lanes: Floats, entry: int, met: int) -> None:
    """Large bodies and sheets: each lane that meets the box by itself."""
    while met != 0:
        i = np.uint64(lowest_bit(met))
        met &= met - 1
        if not lanes[T_MIN + i] < lanes[T_MAX + i]:
            continue
        hit = try_entry(geometry, scratch, entry, lane_ray(lanes, i, lanes[T_MAX + i]), lane_hit(lanes, i))
        lanes[BEST + i], lanes[BODY + i], lanes[ENTRY + i] = hit[0], hit[1], hit[2]
        lanes[PLACE + i], lanes[SENSE + i], lanes[ENTERS + i] = hit[3], hit[4], 1.0 if hit[5] else 0.0
        lanes[WITHIN + i], lanes[DOUBT + i] = within(hit), 1.0 if hit[7] else 0.0


@inline
def _retire(lanes: Floats, groups: int) -> None:
    """Make the lanes idle that have met something."""
    first, last = eights(0, 8 * groups)
    for i in range(first, last):
        lanes[T_MAX + i] = choose(lanes[BEST + i] < math.inf, -math.inf, lanes[T_MAX + i])


@inline
def lanes_in_child(geometry: Geometry, lanes: Floats, groups: int, at: int) -> int:
    """The lanes that meet the box with its six sides at floats[at::8]."""
    put_slopes(lanes, groups)
    f = geometry.floats
    return lanes_in_box(lanes, (f[at], f[at + 8], f[at + 16]), (f[at + 24], f[at + 32], f[at + 40]), groups)


@inline
def lanes_at_ball(geometry: Geometry, lanes: Floats, groups: int, at: int, stride: int) -> int:
    """The lanes that may meet a ball with its numbers at floats[at::stride]."""
    f = geometry.floats
    return lanes_in_ball(lanes, f[at], f[at + stride], f[at + 2 * stride], f[at + 3 * stride], groups)


@inline
def _children_met(geometry: Geometry, lanes: Floats, groups: int, node: int, bits: int) -> int:
    """Those of a node's children that a lane meets, of those that are told by bits."""
    met = 0
    at = geometry.places[table.NODE_BOXES, 0] + 48 * node
    while bits != 0:
        child = lowest_bit(bits)
        bits &= bits - 1
        if lanes_in_child(geometry, lanes, groups, at + child) != 0:
            met |= 1 << child
    return met


@inline
def _meet(
    geometry: Geometry, scratch: Scratch, packet: Packet, blocks: Signs, at: int, count: int, k: int, met: int
) -> None:
    """Item k of the leaf of `count` at floats[at:], asked by the lanes that are told by bits, or more."""
    lanes, first, last = packet.lanes, lowest_bit(met) & -8, (highest_bit(met) | 7) + 1
    kind, index, body, entry = leaf_item(geometry, at, count, k)
    if len(blocks) > 0 and blocks[body] == 0:
        return
    if kind == BALL:
        ball_lanes(lanes, leaf_ball(geometry, at, count, k), index, entry, body, first, last)
    elif kind == CELL:
        cell_lanes(geometry, lanes, index, entry, body, first, last)
    elif kind == REGION and in_lanes(geometry, index):
        region_lanes(geometry, lanes, packet.leaves, packet.truths, packet.spans, index, entry, body, first, last)
    else:
        _one_by_one(geometry, scratch, lanes, entry, met)


@inline
def _choose(packet: Packet, item: int, items: int, most: int) -> tuple[int, int]:
    """Put the next items that the beam meets into `chosen`; returns how many, and how many items are behind."""
    seen, lanes, count = packet.frontier, packet.lanes, 0
    while count < most and item < items and seen.items[ENTERED + item] <= lanes[BEAM_AT + LAST]:
        bits = items_met(seen.items, item, lanes, BEAM_AT, seen.near) & ((1 << min(8, items - item)) - 1)
        put_numbers(item, bits, packet.chosen, count)
        count += bit_count(bits)
        item += 8
    return count, item


@inline
def _ball_of(geometry: Geometry, items: Floats, k: int) -> tuple[int, int, int]:
    """(where its leaf begins, the leaf's length, its place there) of an item that is a ball."""
    first, last = leaf_range(whole(items[CODE + k]))
    return leaf_at(geometry, first), last - first, -2 - whole(items[BOX + k])


@inline
def _meet_items(
    geometry: Geometry, scratch: Scratch, packet: Packet, groups: int, blocks: Signs, any_hit: bool, count: int
) -> int:
    """The first `count` chosen items: balls are met, others put on the stack, whose height is returned.

    Step by step for all of them, so that what is found out about one does not hold up the next.
    """
    stack, lanes, items, pairs, top, end = scratch.stack, packet.lanes, packet.frontier.items, packet.pairs, 0, 0
    split = lanes[GROUP_BEAMS] != 0.0
    for j in range(count):
        k = packet.chosen[j]
        if items[BOX + k] < -1.0:
            if split:
                end += put_groups(items, k, lanes, GROUPS_AT, pairs, end)
            else:
                pairs[end] = 8 * k
                end += 1
    for j in range(count - 1, -1, -1):
        k = packet.chosen[j]
        if items[BOX + k] >= -1.0:
            stack.code[top], stack.box[top], stack.t[top] = whole(items[CODE + k]), whole(items[BOX + k]), items[ENTERED + k]
            top += 1
    if split:
        kept = 0
        for j in range(end):
            pair = pairs[j]
            at, size, place = _ball_of(geometry, items, pair >> 3)
            x, y, z, r = leaf_ball(geometry, at, size, place)
            pairs[kept] = pair
            kept += 1 if group_in_ball(lanes, pair & 7, x, y, z, r) != 0 else 0
        end = kept
    for j in range(end):
        at, size, place = _ball_of(geometry, items, pairs[j] >> 3)
        if split:
            x, y, z, r = leaf_ball(geometry, at, size, place)
            met = group_in_ball(lanes, pairs[j] & 7, x, y, z, r) << 8 * (pairs[j] & 7)
        else:
            met = lanes_at_ball(geometry, lanes, groups, at + place, size)
        if met != 0:
            _meet(geometry, scratch, packet, blocks, at, size, place, met)
            if any_hit:
                _retire(lanes, groups)
    if end > 0:
        shorten_beam(lanes, groups)
    return top


@inline
def _meet_ball(
    geometry: Geometry, scratch: Scratch, packet: Packet, groups: int, blocks: Signs, any_hit: bool,
    at: int, count: int, k: int,
) -> None:  # fmt: skip
    """Ball k of a leaf of `count`."""
    met = lanes_at_ball(geometry, packet.lanes, groups, at + k, count)
    if met != 0:
        _meet(geometry, scratch, packet, blocks, at, count, k, met)
        if any_hit:
            _retire(packet.lanes, groups)
        shorten_beam(packet.lanes, groups)


@inline
def _meet_balls(
    geometry: Geometry, scratch: Scratch, packet: Packet, groups: int, blocks: Signs, any_hit: bool,
    at: int, count: int,
) -> None:  # fmt: skip
    """A leaf of balls: the beam sorts out those that it misses, the lanes ask about the others."""
    lanes, near = packet.lanes, scratch.near
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
        _meet_ball(geometry, scratch, packet, groups, blocks, any_hit, at, count, k)


@helper
def trace_packet(
    geometry: Geometry, scratch: Scratch, packet: Packet, groups: int, narrow: bool, blocks: Signs, any_hit: bool
) -> None:
    """First hits, or any, of the rays in the first groups of eight lanes, which are `ordinary`; see `lane_hit`.

    Only bodies with blocks[body] != 0 count, or all, if `blocks` is empty. Where the beam is not
    narrow, the children of nodes are asked for by the lanes too.
    """
    stack, lanes = scratch.stack, packet.lanes
    items, item, top, most = packet.frontier.count[0], 0, 0, 2
    if items < 0 or lanes[BEAM_AT + FIRST] < 0.0:  # a tile sees what lies before it
        items, top = 0, push_roots(geometry, stack, scene_tree(geometry))
    if items > _MANY:
        put_group_beams(lanes)
    boxes = geometry.places[table.NODE_BOXES, 0]
    while True:
        if top == 0:
            chosen, item = _choose(packet, item, items, most)
            most = min(2 * most, _CHOSEN)
            if chosen == 0:
                break
            top = _meet_items(geometry, scratch, packet, groups, blocks, any_hit, chosen)
            continue
        top -= 1
        if stack.t[top] > lanes[BEAM_AT + LAST]:
            continue
        code, box = stack.code[top], stack.box[top]
        if code >= 0:
            its = boxes_met(geometry.floats, boxes + 48 * code, lanes, BEAM_AT, scratch.near)
            if not narrow:
                its = _children_met(geometry, lanes, groups, code, its)
            top = push_met(geometry, stack, scratch.near, code, its, top)
            continue
        begin, end = leaf_range(code)
        at, count = leaf_at(geometry, begin), end - begin
        if box >= 0 and is_round(geometry, at, count):
            _meet_balls(geometry, scratch, packet, groups, blocks, any_hit, at, count)
            continue
        met = (1 << (8 * groups)) - 1 if groups < 8 else -1
        if box >= 0:
            met = lanes_in_child(geometry, lanes, groups, boxes + 48 * (box >> 3) + (box & 7))
            if met == 0:
                continue
        for k in range(count):
            _meet(geometry, scratch, packet, blocks, at, count, k, met)
        if any_hit:
            _retire(lanes, groups)
        shorten_beam(lanes, groups)
