"""The frontier of a tile: what part of the tree it sees, so that not each of its packets starts at the roots.

The beam that holds all rays of the tile goes down the tree first, the nearest first, to balls and to leaves of other
things, as far as the rays are expected to see. Of these items quarters of the tile keep what their beams meet, and of
those each packet, eight at a time.
(The entry points of multi-level ray tracing, taken down to the leaves: Reshetov, Soupikov, Hurley, SIGGRAPH 2005.)
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ...compiler.jit import allocator, helper, inline
from .. import tables as table
from ..culling import (
    BOX_OR_BALL,
    CODE,
    ENTERED,
    ITEM_ROW,
    ITEMS_SIZE,
    MOST_ITEMS,
    bit_count,
    items_met,
    keep_items,
    put_balls,
    put_children,
)
from ..tables import Floats, Geometry, box_at, integer, node_at, whole
from ..tree.leaf import is_round, leaf_at, leaf_range
from ..tree.walk import ask_for

_MOST_FOUND = MOST_ITEMS - 1024  # nodes and leaves: the rest is for the balls of the nearest leaves
_MOST_ROOTS = 64
_SORTED = 64  # so many are put in order exactly, more by buckets
_BUCKETS = 256
_AHEAD = 10


ITEM_COUNT = ITEMS_SIZE
"""Behind a frontier's items (see culling/items.py): how many there are, or -1: there is no frontier.

They are in order from the nearest to the furthest, or nearly so: nodes, leaves, and balls of leaves.
"""


class Level(NamedTuple):
    """Two levels of a tree, as far as a beam meets them."""

    found: Any  # int64: nodes and leaves; the upper half is the number of the box, -1 for none
    t: Floats  # where the beam enters
    places: Any  # int64: of buckets


@allocator
def new_frontier() -> Floats:
    """Memory for one thread, without a frontier."""
    items = np.empty(ITEMS_SIZE + 1)
    items[ITEM_COUNT] = -1.0
    return items


@allocator
def new_level() -> Level:
    """Memory for one thread."""
    return Level(np.empty(2 * ITEM_ROW, np.int64), np.empty(2 * ITEM_ROW), np.empty(_BUCKETS + 1, np.int64))


@inline
def _code(found: Any) -> Any:
    """The code of a node or leaf, the lower half of what was found."""
    return np.int64(np.int32(found))


@inline
def _sort(level: Level, begin: int, end: int) -> None:
    """Order a level by where the beam enters: insertion sort."""
    for k in range(begin + 1, end):
        found, t, slot = level.found[k], level.t[k], k
        while slot > begin and level.t[slot - 1] > t:
            level.found[slot], level.t[slot] = level.found[slot - 1], level.t[slot - 1]
            slot -= 1
        level.found[slot], level.t[slot] = found, t


@inline
def _put_in_buckets(level: Level, begin: int, count: int, other: int) -> None:
    """Put a level at level.found[other:], nearly in order of where the beam enters: by stretches of equal length.

    Two passes, however many there are; a comparing sort of thousands took longer than tracing their tile.
    """
    t, places, low, high = level.t, level.places, level.t[begin], level.t[begin]
    for k in range(begin, begin + count):
        low, high = min(low, t[k]), max(high, t[k])
    scale = (_BUCKETS - 1) / (high - low) if high > low else 0.0
    for bucket in range(_BUCKETS + 1):
        places[bucket] = 0
    for k in range(begin, begin + count):
        places[1 + whole((t[k] - low) * scale)] += 1
    for bucket in range(_BUCKETS):
        places[bucket + 1] += places[bucket]
    for k in range(begin, begin + count):
        bucket = whole((t[k] - low) * scale)
        slot = other + places[bucket]
        places[bucket] += 1
        level.found[slot], t[slot] = level.found[k], t[k]


@inline
def _descend(
    geometry: Geometry, level: Level, beam: Floats, start: int, begin: int, count: int, other: int, horizon: float
) -> tuple[int, int]:
    """Replace the nodes of a level by their children that the beam meets, at level.found[other:], in order.

    Those that the beam enters beyond the horizon stay. Returns how many there are then, and how many were replaced.
    """
    found, end, nodes = level.found, other, 0
    for k in range(begin, begin + count):
        code = _code(found[k])
        if k + _AHEAD < begin + count:
            ask_for(geometry, _code(found[k + _AHEAD]))
        if code >= 0 and level.t[k] <= horizon and end - other + begin + count - k + 8 <= _MOST_FOUND:
            end += put_children(
                geometry.floats, node_at(geometry, code),
                geometry.integers, geometry.places[table.NODE_CHILDREN] + 8 * code, 8 * code,
                beam, start, found, level.t, end,
            )  # fmt: skip
            nodes += 1
        else:
            found[end], level.t[end] = found[k], level.t[k]
            end += 1
    return end - other, nodes


@inline
def _put(geometry: Geometry, items: Floats, k: int, code: Any, box: Any, t: float) -> None:
    """Item k: a node or leaf in a box, -1 if in none."""
    items[CODE + k], items[BOX_OR_BALL + k], items[ENTERED + k] = code, box, t
    at = box_at(geometry, box)
    for side in range(6):
        open_end = -math.inf if side < 3 else math.inf
        items[k + side * ITEM_ROW] = geometry.floats[at + 8 * side] if box >= 0 else open_end


@helper
def find_frontier(
    geometry: Geometry, items: Floats, level: Level, beam: Floats, start: int, tree: int, horizon: float
) -> None:
    """The nodes, leaves and balls of a tree that a beam (beam[start:]) meets, roughly from the nearest to the farthest.

    Whatever a ray within the beam can meet at t >= 0 is one of the items or below one; ENTERED never decreases along
    them, so that a packet may stop at the first that is entered beyond its reach. Beyond the horizon nodes are not
    opened: where the rays are expected to end before it that would be waste, and where they do not, packets open them.
    """
    roots, nodes = integer(geometry, table.TREE_ROOT, tree), 1
    count, here, other = integer(geometry, table.TREE_ROOT, tree + 1) - roots, 0, ITEM_ROW
    items[ITEM_COUNT] = -1.0
    if count > _MOST_ROOTS:
        return
    for k in range(count):
        level.found[k], level.t[k] = np.int64(-1) << 32 | integer(geometry, table.ROOTS, roots + k) & 0xFFFFFFFF, 0.0
    while nodes > 0:
        if count <= _SORTED:
            _sort(level, here, here + count)
        else:
            _put_in_buckets(level, here, count, other)
            here, other = other, here
        count, nodes = _descend(geometry, level, beam, start, here, count, other, horizon)
        here, other = other, here
    end = 0
    for k in range(here, here + count):
        code, box = _code(level.found[k]), level.found[k] >> 32
        if k + _AHEAD < here + count:
            ask_for(geometry, _code(level.found[k + _AHEAD]))
        first, n = leaf_range(code)
        n -= first
        at = leaf_at(geometry, first)
        if code < 0 and box >= 0 and is_round(geometry, at, n) and end + here + count - k + 8 <= MOST_ITEMS:
            end += put_balls(geometry.floats, at, n, code, beam, start, items, end)
        else:
            _put(geometry, items, end, code, box, level.t[k])
            end += 1
    # Where this one or one that follows is entered
    for k in range(end - 2, -1, -1):
        items[ENTERED + k] = min(items[ENTERED + k], items[ENTERED + k + 1])
    items[ITEM_COUNT] = end


@helper
def narrow_frontier(items: Floats, beam: Floats, start: int, narrowed: Floats) -> None:
    """The items of a frontier that a narrower beam (beam[start:]) meets, in the same order."""
    end, count = 0, whole(items[ITEM_COUNT])
    for first in range(0, count, 8):
        bits = items_met(items, first, beam, start) & ((1 << min(8, count - first)) - 1)
        keep_items(items, first, bits, narrowed, end)
        end += bit_count(bits)
    narrowed[ITEM_COUNT] = end if count >= 0 else -1
