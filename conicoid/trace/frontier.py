"""What part of the tree a tile of packets sees, so that not each of its packets starts at the roots.

The beam that holds all rays of the tile goes down the tree first, breadth first, until so many nodes, leaves and
balls are left as a packet may ask about at once, eight at a time as it asks about the children of a node.
(The entry points of multi-level ray tracing: Reshetov, Soupikov, Hurley, SIGGRAPH 2005.)
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..geometry import tables as table
from ..geometry.tables import BALL, Floats, Geometry, Ints, integer
from ..jit import allocator, helper, inline
from .leaf import leaf_at, leaf_ball, leaf_kind, leaf_range
from .simd import balls_in_beam, bit_count, boxes_met, lowest_bit
from .walk import Stack

MOST = 64
_ROOM = 4 * MOST
_ALMOST_ONE = 1.0 + 1e-14


class Frontier(NamedTuple):
    """Items from the furthest to the nearest: nodes, leaves, and balls of leaves."""

    code: Ints
    box: Ints  # of the item, -1 for none; -2 - k: it is ball k of the leaf
    t: Floats  # where the tile's beam enters
    sides: Floats  # six of each, laid out as those of nodes
    items: Ints  # (1,) how many there are, or -1: nothing is known


@allocator
def new_frontier() -> Frontier:
    """Memory for one thread; nothing is known."""
    return Frontier(
        np.empty(_ROOM, np.int32),
        np.empty(_ROOM, np.int32),
        np.empty(_ROOM),
        np.empty(6 * MOST),
        np.full(1, -1, np.int32),
    )


@inline
def _put(frontier: Frontier, k: int, code: Any, box: Any, t: float) -> None:
    frontier.code[k], frontier.box[k], frontier.t[k] = code, box, t


@inline
def _expand(geometry: Geometry, frontier: Frontier, near: Floats, beam: Floats, k: int, last: int, room: int) -> int:
    """Put the parts of item k that the beam meets behind the last; returns the new last, or -1 if they are too many."""
    code, box = frontier.code[k], frontier.box[k]
    if box < -1:
        return -1
    first, n = leaf_range(code)
    n -= first
    at = leaf_at(geometry, first)
    if code >= 0:
        bits = boxes_met(geometry.floats, geometry.places[table.NODE_BOXES, 0] + 48 * code, beam, 0, near)
    elif box >= 0 and leaf_kind(geometry, at, n) == BALL:
        bits = balls_in_beam(geometry.floats, at, n, n, beam, 0, near)
    else:
        return -1
    if bit_count(bits) > room:
        return -1
    while bits != 0:
        i = lowest_bit(bits)
        bits &= bits - 1
        if code < 0:
            _put(frontier, last, code, -2 - i, near[i])
            last += 1
            continue
        child = integer(geometry, table.NODE_CHILDREN, 8 * code + i)
        if child != 0:
            _put(frontier, last, child, 8 * code + i, near[i])
            last += 1
    return last


@inline
def _sort(frontier: Frontier, count: int) -> None:
    for k in range(1, count):
        code, box, t, slot = frontier.code[k], frontier.box[k], frontier.t[k], k
        while slot > 0 and frontier.t[slot - 1] < t:
            _put(frontier, slot, frontier.code[slot - 1], frontier.box[slot - 1], frontier.t[slot - 1])
            slot -= 1
        _put(frontier, slot, code, box, t)


@inline
def _put_sides(geometry: Geometry, frontier: Frontier, k: int) -> None:
    code, box, floats = frontier.code[k], frontier.box[k], geometry.floats
    place = 48 * (k >> 3) + (k & 7)
    if box < -1:
        first, last = leaf_range(code)
        x, y, z, radius = leaf_ball(geometry, leaf_at(geometry, first), last - first, -2 - box)
        r = radius * _ALMOST_ONE
        frontier.sides[place], frontier.sides[place + 8], frontier.sides[place + 16] = x - r, y - r, z - r
        frontier.sides[place + 24], frontier.sides[place + 32], frontier.sides[place + 40] = x + r, y + r, z + r
        return
    at = geometry.places[table.NODE_BOXES, 0] + 48 * (box >> 3) + (box & 7)
    for side in range(6):
        open_end = -math.inf if side < 3 else math.inf
        frontier.sides[place + 8 * side] = floats[at + 8 * side] if box >= 0 else open_end


@helper
def find_frontier(geometry: Geometry, frontier: Frontier, near: Floats, beam: Floats, tree: int) -> None:
    """What of a tree the beam (beam[0:]) meets."""
    begin, end = integer(geometry, table.TREE_ROOT, tree), integer(geometry, table.TREE_ROOT, tree + 1)
    frontier.items[0] = -1
    if end - begin > MOST:
        return
    done, last = 0, end - begin
    for k in range(begin, end):
        _put(frontier, k - begin, integer(geometry, table.ROOTS, k), -1, -math.inf)
    k = 0
    while k < last:
        others = done + last - k - 1
        longer = _expand(geometry, frontier, near, beam, k, last, min(MOST - others, _ROOM - last))
        if longer < 0:
            _put(frontier, done, frontier.code[k], frontier.box[k], frontier.t[k])
            done += 1
        else:
            last = longer
        k += 1
    _sort(frontier, done)
    for k in range(done):
        _put_sides(geometry, frontier, k)
    frontier.items[0] = done


@inline
def push_frontier(frontier: Frontier, stack: Stack, near: Floats, beam: Floats, start: int) -> int:
    """Walk from the items that a beam (from beam[start:]) of the tile meets; returns the height of the stack."""
    top, count = 0, frontier.items[0]
    for first in range(0, count, 8):
        bits = boxes_met(frontier.sides, 6 * first, beam, start, near) & ((1 << min(8, count - first)) - 1)
        while bits != 0:
            i = lowest_bit(bits)
            bits &= bits - 1
            stack.code[top], stack.box[top], stack.t[top] = frontier.code[first + i], frontier.box[first + i], near[i]
            top += 1
    return top
