"""The frontier of a tile: the part of the tree that it sees, so that its packets do not each start at the roots.

The beam that holds all rays of the tile goes down the tree, the nearest nodes first, to balls and to leaves of other
entries, as far as the rays are expected to see. Quarters of the tile keep the items that their beams meet, and packets
test these eight at a time. (The entry points of multi-level ray tracing, taken down to the leaves: Reshetov, Soupikov,
Hurley, SIGGRAPH 2005.)
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..._jit.decorators import allocator, helper, inline
from .. import tables as table
from ..bvh.culling import (
    BEAM,
    BOX_OR_BALL,
    CODE,
    ENTERED,
    FIRST,
    HIGH_I,
    HIGH_O,
    ITEM_ROW,
    ITEMS_SIZE,
    LAST,
    LOW_I,
    LOW_O,
    MOST_ITEMS,
    bit_count,
    hit_items,
    keep_items,
    prefetch,
    put_balls,
    put_children,
    widen,
)
from ..bvh.walk import is_round, leaf_at, leaf_range, prefetch_node, reciprocal, scene_tree
from ..ray import RayArrays
from ..tables import Floats, Geometry, box_at, integer, node_at, whole
from .lanes import LANES, copy_run, lane_sight, packet_row, packets_across, put_origin

_MOST_FOUND = MOST_ITEMS - 1024  # nodes and leaves: the rest is for the balls of the nearest leaves
_MOST_ROOTS = 64
_SORTED = 64  # most items that are sorted exactly, more go into buckets
_BUCKETS = 256
_PREFETCH_DISTANCE = 10  # nodes


ITEM_COUNT = ITEMS_SIZE
"""Place behind a frontier's items (bvh/culling_tests.py): the number of items, or -1 for no frontier.

Items are nodes, leaves, and balls of leaves, in order from the nearest to the furthest, or nearly so.
"""


class FrontierLevel(NamedTuple):
    """Two levels of a tree, as far as a beam meets them."""

    found: Any  # int64: nodes and leaves; the upper half is the number of the box, -1 for none
    t: Floats  # t at which the beam enters
    places: Any  # int64: begins of buckets


@allocator
def new_frontier() -> Floats:
    """Return memory of a frontier for one thread, without a frontier in it."""
    items = np.empty(ITEMS_SIZE + 1)
    items[ITEM_COUNT] = -1.0
    return items


@allocator
def new_level() -> FrontierLevel:
    """Return memory of two levels for one thread."""
    return FrontierLevel(np.empty(2 * ITEM_ROW, np.int64), np.empty(2 * ITEM_ROW), np.empty(_BUCKETS + 1, np.int64))


@inline
def _code(found: Any) -> Any:
    """Return the code of a node or leaf, the lower half of an element of `found`."""
    return np.int64(np.int32(found))


@inline
def _sort(level: FrontierLevel, begin: int, end: int) -> None:
    """Sort a level by the t of entry: insertion sort."""
    # Nodes of a level come from their parents in order, so that they are nearly sorted
    for k in range(begin + 1, end):
        found, t, slot = level.found[k], level.t[k], k
        while slot > begin and level.t[slot - 1] > t:
            level.found[slot], level.t[slot] = level.found[slot - 1], level.t[slot - 1]
            slot -= 1
        level.found[slot], level.t[slot] = found, t


@inline
def _put_in_buckets(level: FrontierLevel, begin: int, count: int, other: int) -> None:
    """Copy a level to level.found[other:], nearly in order of the t of entry: by buckets of equal width.

    It takes two passes, however many elements there are; a comparison sort of thousands took longer than tracing their
    tile.
    """
    t, places, low, high = level.t, level.places, level.t[begin], level.t[begin]
    for k in range(begin, begin + count):
        low, high = min(low, t[k]), max(high, t[k])
    # 255 widths for 256 buckets, so that the farthest element falls into the last
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
    geometry: Geometry,
    level: FrontierLevel,
    beam: Floats,
    start: int,
    begin: int,
    count: int,
    other: int,
    horizon: float,
) -> tuple[int, int]:
    """Write a level with its nodes replaced by those of their children that the beam meets to level.found[other:].

    The order is kept, and nodes that the beam enters beyond the horizon stay. Returns the new number of elements, and
    the number of nodes replaced.
    """
    found, end, nodes = level.found, other, 0
    for k in range(begin, begin + count):
        code = _code(found[k])
        if k + _PREFETCH_DISTANCE < begin + count:
            prefetch_node(geometry, _code(found[k + _PREFETCH_DISTANCE]))
        # Room for eight children and for all that follow: a node that does not fit stays closed
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
    """Write item k: a node or leaf in a box, -1 for none."""
    items[CODE + k], items[BOX_OR_BALL + k], items[ENTERED + k] = code, box, t
    at = box_at(geometry, box)
    for side in range(6):
        # Every beam meets an item without a box
        open_end = -math.inf if side < 3 else math.inf
        items[k + side * ITEM_ROW] = geometry.floats[at + 8 * side] if box >= 0 else open_end


@helper
def find_frontier(
    geometry: Geometry, items: Floats, level: FrontierLevel, beam: Floats, start: int, tree: int, horizon: float
) -> None:
    """Find the nodes, leaves and balls of a tree that a beam (beam[start:]) meets, roughly from near to far.

    Everything that a ray within the beam can meet at t >= 0 is one of the items or below one. ENTERED never decreases
    along the items, so that a packet may stop at the first one entered beyond its reach. Nodes beyond the horizon are
    not opened: rays are expected to end before it, and packets whose rays do not open these nodes themselves.
    """
    roots, nodes = integer(geometry, table.TREE_ROOT, tree), 1
    count, here, other = integer(geometry, table.TREE_ROOT, tree + 1) - roots, 0, ITEM_ROW
    items[ITEM_COUNT] = -1.0
    # Many bodies without an end: a frontier of them all would help no packet
    if count > _MOST_ROOTS:
        return
    for k in range(count):
        level.found[k], level.t[k] = np.int64(-1) << 32 | integer(geometry, table.ROOTS, roots + k) & 0xFFFFFFFF, 0.0
    while nodes > 0:  # level by level, between the two halves of the arrays
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
        if k + _PREFETCH_DISTANCE < here + count:
            prefetch_node(geometry, _code(level.found[k + _PREFETCH_DISTANCE]))
        first, n = leaf_range(code)
        n -= first
        at = leaf_at(geometry, first)
        if code < 0 and box >= 0 and is_round(geometry, at, n) and end + here + count - k + 8 <= MOST_ITEMS:
            end += put_balls(geometry.floats, at, n, code, beam, start, items, end)
        else:
            _put(geometry, items, end, code, box, level.t[k])
            end += 1
    # The t at which the beam enters this item or one that follows
    for k in range(end - 2, -1, -1):
        items[ENTERED + k] = min(items[ENTERED + k], items[ENTERED + k + 1])
    items[ITEM_COUNT] = end


@helper
def narrow_frontier(items: Floats, beam: Floats, start: int, narrowed: Floats) -> None:
    """Copy the items of a frontier that a narrower beam (beam[start:]) meets to `narrowed`, in the same order."""
    end, count = 0, whole(items[ITEM_COUNT])
    for first in range(0, count, 8):
        bits = hit_items(items, first, beam, start) & ((1 << min(8, count - first)) - 1)
        keep_items(items, first, bits, narrowed, end)
        end += bit_count(bits)
    narrowed[ITEM_COUNT] = end if count >= 0 else -1


# Tiles: sixteen packets side by side, 32 x 32 pixels of a picture or 1024 rays of a list
#
# A tile finds once what its packets share: the beam that holds all of their rays, the part of the scene that it sees,
# and whether all rays have one origin, as with most cameras.

_SIDE = 4
PACKETS = _SIDE * _SIDE
_ORIGINS, _DIRECTIONS = 0, 48
_QUARTERS = 4
_WHOLE = _QUARTERS * BEAM

_HORIZON, _FURTHEST, _HITS, _RAYS = 0, 1, 2, 3
"""Elements of `sight`: the t up to which a tile is expected to see, its furthest hit, its numbers of hits and rays."""


class Tile(NamedTuple):
    """Memory of a tile."""

    extremes: Floats  # of origins and of directions, for each quarter (`widen`)
    beams: Floats  # of the quarters, then of the whole tile
    view: Floats  # a frontier
    level: FrontierLevel
    sight: Floats  # see `_HORIZON`


@allocator
def new_tile() -> Tile:
    """Return memory of tiles for one thread."""
    return Tile(
        np.empty(_QUARTERS * 96),
        np.empty((_QUARTERS + 1) * BEAM),
        new_frontier(),
        new_level(),
        np.array([math.inf, 0.0, 0.0, 0.0]),
    )


@inline
def tile_count(width: int, count: int) -> int:
    """Return the number of tiles of `count` rays of a picture with some width, or of a list (width 0)."""
    if width == 0:
        return -(-count // (PACKETS * LANES))
    across, down = packets_across(width), -(-count // (8 * width))
    return -(-across // _SIDE) * -(-down // _SIDE)


@inline
def tile_packet(tile: int, k: int, width: int, count: int) -> int:
    """Return the number of packet k of a tile, counted quarter by quarter; -1 outside the picture or list."""
    if width == 0:
        packet = PACKETS * tile + k
        return packet if packet * LANES < count else -1
    across = packets_across(width)
    tiles = -(-across // _SIDE)
    # Bits 0 and 1 of k are the place in a quarter, bits 2 and 3 the quarter
    x = _SIDE * (tile % tiles) + (k & 1) + 2 * (k >> 2 & 1)
    y = _SIDE * (tile // tiles) + (k >> 1 & 1) + 2 * (k >> 3)
    return y * across + x if x < across and 8 * y * width < count else -1


@inline
def copy_tile(
    rays: RayArrays, tile: int, width: int, own_origins: Floats, own_directions: Floats, room: Floats
) -> bool:
    """Copy the rays of a tile to other arrays, or if these are empty to room for eight; True if all can be traced."""
    count, wrong, copied = len(rays.origins), 0, len(own_origins) >= len(rays.origins)
    side = 8 * _SIDE  # the tile of a list is as many runs of as many rays
    across = -(-packets_across(width) // _SIDE) if width > 0 else 1
    for row in range(side):
        x, y = side * (tile % across), side * (tile // across) + row
        i, n = (y * width + x, min(side, width - x)) if width > 0 else (side * y, side)
        n = max(0, min(n, count - i))
        if copied:
            wrong |= copy_run(rays.origins, rays.directions, i, own_origins, own_directions, i, n)
        else:
            for k in range(0, n, 8):
                wrong |= copy_run(rays.origins, rays.directions, i + k, room, room, 0, min(8, n - k))
    return wrong == 0


@inline
def _extend(points: Floats, i: int, extremes: Floats, at: int) -> None:
    """Include point i in the extremes."""
    for axis in range(3):
        value = points[i, axis]
        if value < extremes[at + axis]:
            extremes[at + axis] = value
        if value > extremes[at + 24 + axis]:
            extremes[at + 24 + axis] = value


@inline
def _extent(extremes: Floats, at: int, axis: int) -> tuple[float, float]:
    """Return (least, greatest) along an axis, from 24 extremes each."""
    low, high = math.inf, -math.inf
    for k in range(axis, 24, 3):
        low, high = min(low, extremes[at + k]), max(high, extremes[at + 24 + k])
    return low, high


@inline
def _put_extremes(extremes: Floats, at: int, rays: RayArrays, tile: int, quarter: int, width: int) -> None:
    """Write the extremes of origins and directions of the rays in a quarter of a tile."""
    origins, directions = rays.origins, rays.directions
    for k in range(24):
        for begin in (at + _ORIGINS, at + _DIRECTIONS):
            extremes[begin + k], extremes[begin + 24 + k] = math.inf, -math.inf
    for k in range(4 * quarter, 4 * quarter + 4):
        packet = tile_packet(tile, k, width, len(origins))
        if packet < 0:
            continue
        for row in range(8):
            i, n = packet_row(packet, row, width, len(origins))
            if n == 8:
                widen(origins, i, extremes, at + _ORIGINS)
                widen(directions, i, extremes, at + _DIRECTIONS)
            else:
                for j in range(i, i + n):
                    _extend(origins, j, extremes, at + _ORIGINS)
                    _extend(directions, j, extremes, at + _DIRECTIONS)


@inline
def _put_beam(beams: Floats, at: int, extremes: Floats, first: int, last: int) -> bool:
    """Write the beam of the rays whose extremes are at extremes[first:last:96]; True if they share an origin."""
    shared = True
    for axis in range(3):
        low, high, least, most = math.inf, -math.inf, math.inf, -math.inf
        for begin in range(first, last, 96):
            a, b = _extent(extremes, begin + _ORIGINS, axis)
            c, d = _extent(extremes, begin + _DIRECTIONS, axis)
            low, high, least, most = min(low, a), max(high, b), min(least, c), max(most, d)
        beams[at + LOW_O + axis], beams[at + HIGH_O + axis] = low, high
        beams[at + LOW_I + axis], beams[at + HIGH_I + axis] = reciprocal(least), reciprocal(most)
        # To the bit, since lanes then take one origin for all
        shared &= low == high
    beams[at + FIRST], beams[at + LAST] = 0.0, math.inf
    return shared


@helper
def open_tile(geometry: Geometry, tile: Tile, lanes: Floats, rays: RayArrays, number: int, width: int) -> bool:
    """Find the frontier of a tile (t >= 0); True if all rays share an origin, which it then writes to all lanes."""
    beams, sight = tile.beams, tile.sight
    # The tile before predicts the horizon, if most of its rays hit something
    sight[_HORIZON] = sight[_FURTHEST] if 2.0 * sight[_HITS] > sight[_RAYS] else math.inf
    sight[_FURTHEST] = sight[_HITS] = sight[_RAYS] = 0.0
    for quarter in range(_QUARTERS):
        _put_extremes(tile.extremes, 96 * quarter, rays, number, quarter, width)
    shared = _put_beam(beams, _WHOLE, tile.extremes, 0, 96 * _QUARTERS)
    find_frontier(geometry, tile.view, tile.level, beams, _WHOLE, scene_tree(geometry), sight[_HORIZON])
    if shared:
        put_origin(lanes, beams[_WHOLE + LOW_O] + 0.0, beams[_WHOLE + LOW_O + 1] + 0.0, beams[_WHOLE + LOW_O + 2] + 0.0)
    return shared


@inline
def note_sight(tile: Tile, lanes: Floats) -> None:
    """Record how far a traced packet of the tile has seen: a tile is expected to see as far as the one before."""
    furthest, hits = lane_sight(lanes)
    sight = tile.sight
    sight[_FURTHEST] = max(sight[_FURTHEST], furthest)
    sight[_HITS] += hits
    sight[_RAYS] += LANES


@helper
def open_quarter(tile: Tile, quarter: int, seen: Floats) -> None:
    """Narrow the frontier of an open tile to one of its quarters."""
    _put_beam(tile.beams, BEAM * quarter, tile.extremes, 96 * quarter, 96 * quarter + 96)
    narrow_frontier(tile.view, tile.beams, BEAM * quarter, seen)


@inline
def prefetch_packet(rays: RayArrays, packet: int, width: int) -> None:
    """Prefetch the rays of a packet, unless its number is -1."""
    origins, directions = rays.origins, rays.directions
    for row in range(8 if packet >= 0 else 0):
        i, n = packet_row(packet, row, width, len(origins))
        if n > 0:
            for k in (0, 8, 16):
                prefetch(origins, 3 * i + k)
                prefetch(directions, 3 * i + k)
