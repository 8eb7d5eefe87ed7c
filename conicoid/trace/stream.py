"""First hits of rays in no order, thousands at a time.

All go down the tree together: at a node every ray of a list is tested against the eight children, and
is put on the lists of those that it meets. So a node is fetched once for many rays, and one
ray's arithmetic fills the waiting times of another's. The rays look into one octant; the
children wait in its order, the nearest first. After Barringer and Akenine-Möller,
Dynamic ray stream traversal (ACM TOG 33, 2014).
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..geometry import tables as table
from ..geometry.tables import Floats, Geometry, Ints, Ray, Signs, integer, whole
from ..jit import allocator, helper, inline
from .kernels import Hit, meet, scene_tree, within
from .leaf import leaf_at, leaf_ball, leaf_item, leaf_range
from .scratch import Scratch
from .simd import FROM_THE_START, balls_met, lowest_bit, put_on_lists, rays_in_balls, waiting
from .walk import ask_for, reciprocal

# Numbers of a ray that boxes are tested with, in the order of `put_on_lists`: one line of memory
ORIGIN, SLOPES, T_MIN, LAST = 0, 3, 6, 7
RAY = 8
# The others, and what it has met
D, INVERSE, START, T_MAX, BEST, BODY, ENTRY, PLACE, SENSE, ENTERS, OFF, DOUBT = 0, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13
MORE = 14
_SEVERAL = 3  # so many rays go to a leaf together


class Stream(NamedTuple):
    """Memory of a stream of rays."""

    rays: Floats  # RAY numbers each
    more: Floats  # MORE numbers each
    lists: Any  # int64: rays that meet something, list after list, each with where, as `waiting` tells
    stack: Ints  # 4 each: what is met, where its list begins, how many rays it has, where its siblings' memory ends
    keys: Floats  # (8,) how far a node's children are
    counts: Ints  # (8,) how many rays they have
    met: Ints  # (16,) which of eight rays meet each ball of a leaf, as bits
    asked: Any  # (128,) int64: 16 times a ray, and the place in its leaf of what it may meet


@allocator
def new_stream(geometry: Geometry, most: int) -> Stream:
    """Memory for streams of up to `most` rays."""
    depth = integer(geometry, table.TREE_DEPTH, 0)
    room = (most + 8) * (depth + 16)  # a list takes up a multiple of eight
    return Stream(
        np.empty(RAY * most), np.empty(MORE * most), np.empty(room, np.int64),
        np.empty(4 * (depth + 16), np.int32), np.empty(8), np.empty(8, np.int32), np.empty(16, np.int32),
        np.empty(128, np.int64),
    )  # fmt: skip


@inline
def put_stream_ray(stream: Stream, k: int, ray: Ray) -> None:
    """Ray k of a stream; nothing is hit yet."""
    ox, oy, oz, dx, dy, dz, t_min, t_max, start = ray
    rays, more, at, far = stream.rays, stream.more, RAY * k, MORE * k
    rays[at + ORIGIN], rays[at + ORIGIN + 1], rays[at + ORIGIN + 2] = ox, oy, oz
    rays[at + SLOPES], rays[at + SLOPES + 1], rays[at + SLOPES + 2] = reciprocal(dx), reciprocal(dy), reciprocal(dz)
    rays[at + T_MIN], rays[at + LAST] = t_min, t_max
    more[far + D], more[far + D + 1], more[far + D + 2] = dx, dy, dz
    more[far + INVERSE], more[far + START] = 1.0 / (dx * dx + dy * dy + dz * dz), start
    more[far + T_MAX], more[far + BEST] = t_max, math.inf
    more[far + BODY], more[far + ENTRY], more[far + PLACE] = -1.0, -1.0, -1.0
    more[far + SENSE], more[far + ENTERS], more[far + OFF], more[far + DOUBT] = 1.0, 0.0, 0.0, 0.0


@inline
def _ray(stream: Stream, k: int) -> Ray:
    rays, more, at, far = stream.rays, stream.more, RAY * k, MORE * k
    return (
        rays[at + ORIGIN], rays[at + ORIGIN + 1], rays[at + ORIGIN + 2],
        more[far + D], more[far + D + 1], more[far + D + 2],
        rays[at + T_MIN], more[far + T_MAX], whole(more[far + START]),
    )  # fmt: skip


@inline
def stream_hit(stream: Stream, k: int) -> Hit:
    """What ray k has met."""
    more, far = stream.more, MORE * k
    return (
        more[far + BEST], whole(more[far + BODY]), whole(more[far + ENTRY]), whole(more[far + PLACE]),
        whole(more[far + SENSE]), more[far + ENTERS] == 1.0, more[far + OFF], more[far + DOUBT] == 1.0,
    )  # fmt: skip


@inline
def _keep(stream: Stream, k: int, hit: Hit, any_hit: bool) -> None:
    more, far = stream.more, MORE * k
    more[far + BEST], more[far + BODY], more[far + ENTRY], more[far + PLACE] = hit[0], hit[1], hit[2], hit[3]
    more[far + SENSE], more[far + ENTERS] = hit[4], 1.0 if hit[5] else 0.0
    more[far + OFF], more[far + DOUBT] = hit[6], 1.0 if hit[7] else 0.0
    done = any_hit and hit[2] >= 0
    stream.rays[RAY * k + LAST] = -math.inf if done else min(more[far + T_MAX], within(hit))


@helper
def _descend(geometry: Geometry, stream: Stream, node: int, begin: int, count: int, room: int, top: int) -> int:
    """Put the rays of a list on the lists of the node's children that they meet; returns the stack's height."""
    lists, counts, its = stream.lists, stream.counts, (count + 7) & -8
    at = geometry.places[table.NODE_BOXES, 0] + 48 * node
    put_on_lists(geometry.floats, at, stream.rays, lists, begin, count, room, counts)
    # The nearest on top, as the first ray of the list sees it
    first, base, boxes = MORE * waiting(lists[begin])[0], top, geometry.floats
    dx, dy, dz = stream.more[first + D], stream.more[first + D + 1], stream.more[first + D + 2]
    stack, keys = stream.stack, stream.keys
    for child in range(8):
        code = integer(geometry, table.NODE_CHILDREN, 8 * node + child)
        if counts[child] == 0 or code == 0:
            continue
        ask_for(geometry, code)
        key = (
            (boxes[at + child] + boxes[at + 24 + child]) * dx
            + (boxes[at + 8 + child] + boxes[at + 32 + child]) * dy
            + (boxes[at + 16 + child] + boxes[at + 40 + child]) * dz
        )
        slot = top
        while slot > base and keys[slot - base - 1] < key:
            keys[slot - base] = keys[slot - base - 1]
            for j in range(4):
                stack[4 * slot + j] = stack[4 * (slot - 1) + j]
            slot -= 1
        keys[slot - base] = key
        stack[4 * slot], stack[4 * slot + 1] = code, room + its * child
        stack[4 * slot + 2], stack[4 * slot + 3] = counts[child], room + 8 * its
        top += 1
    return top


@inline
def _sift(geometry: Geometry, stream: Stream, at: int, size: int, begin: int, left: int) -> int:
    """Find the items of a leaf that the first eight rays of a list may meet; returns how many, put into `asked`."""
    lists, asked, met, count = stream.lists, stream.asked, stream.met, 0
    if left >= _SEVERAL:
        rays_in_balls(geometry.floats, at, size, stream.rays, stream.more, MORE, lists, begin, left, met)
        for place in range(size):
            bits = whole(met[place])
            while bits != 0:
                asked[count] = waiting(lists[begin + lowest_bit(bits)])[0] << 4 | place
                bits &= bits - 1
                count += 1
        return count
    for j in range(begin, begin + left):
        k, t = waiting(lists[j])
        reach = stream.rays[RAY * k + LAST]
        if t > reach:
            continue
        ray, inverse = _ray(stream, k), stream.more[MORE * k + INVERSE]
        for eight in range(0, size, 8):
            bits = balls_met(geometry.floats, at + eight, size, size - eight, ray, inverse, reach)
            while bits != 0:
                asked[count] = k << 4 | eight + lowest_bit(bits)
                bits &= bits - 1
                count += 1
    return count


@helper
def _meet(
    geometry: Geometry,
    scratch: Scratch,
    stream: Stream,
    code: int,
    begin: int,
    count: int,
    blocks: Signs,
    any_hit: bool,
) -> None:
    """The entries of a leaf, for all rays of a list."""
    first, last = leaf_range(code)
    at, size = leaf_at(geometry, first), last - first
    for j in range(begin, begin + count, 8):
        for n in range(_sift(geometry, stream, at, size, j, begin + count - j)):
            k, place = stream.asked[n] >> 4, stream.asked[n] & 15
            item = leaf_item(geometry, at, size, place)
            if len(blocks) > 0 and blocks[item[2]] == 0:
                continue
            best, ray, inverse = stream_hit(stream, k), _ray(stream, k), stream.more[MORE * k + INVERSE]
            hit = meet(geometry, scratch, item, leaf_ball(geometry, at, size, place), ray, inverse, best)
            if hit[0] != best[0] or hit[1] != best[1] or hit[7] != best[7]:
                _keep(stream, k, hit, any_hit)


@helper
def trace_stream(
    geometry: Geometry, scratch: Scratch, stream: Stream, count: int, blocks: Signs, any_hit: bool
) -> None:
    """First hits, or any, of the first `count` rays of a stream; `stream_hit` tells what each has met.

    Only bodies with blocks[body] != 0 count, or all, if `blocks` is empty.
    """
    if count == 0:
        return
    stack, tree = stream.stack, scene_tree(geometry)
    for k in range(count):
        stream.lists[k] = k + FROM_THE_START
    first, top = integer(geometry, table.TREE_ROOT, tree), 0
    for k in range(first, integer(geometry, table.TREE_ROOT, tree + 1)):
        stack[4 * top], stack[4 * top + 1] = integer(geometry, table.ROOTS, k), 0
        stack[4 * top + 2], stack[4 * top + 3] = count, (count + 7) & -8
        top += 1
    while top > 0:
        top -= 1
        code, begin, its, room = stack[4 * top], stack[4 * top + 1], stack[4 * top + 2], stack[4 * top + 3]
        if code >= 0:
            top = _descend(geometry, stream, code, begin, its, room, top)
        else:
            _meet(geometry, scratch, stream, code, begin, its, blocks, any_hit)
