"""Sort rays into an order in which neighbours see the same part of a scene.

Rays in no order are sorted by the octant of their direction, then by the point where they begin in the scene's box (or
enter it), then by direction within the octant: a key of a few bits for each, and a stable counting sort. Sixteen in a
row are then coherent. After Garanzha and Loop, Fast ray sorting and breadth-first packet traversal (Eurographics 2010).
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..._jit.decorators import choose, helper, inline, kernel
from .. import tables as table
from ..bvh.culling import load_eight
from ..tables import Floats, Geometry, Ints, integer, length, node_at, whole
from ..threads import run_chunks, thread_count

_CHUNK = 1 << 16  # least rays of a block, the share of a thread
_FEW_BITS, _MORE_BITS, _MANY = 2, 3, 1 << 18  # bits of a key for each coordinate; from _MANY rays on the larger number
LANES, _ROWS = 64, 7
OX, OY, OZ, DX, DY, DZ, KEY = (np.uint64(row) for row in range(0, _ROWS * LANES, LANES))


class Triple(NamedTuple):
    """Three numbers."""

    x: float
    y: float
    z: float


class SceneBox(NamedTuple):
    """A box by its lowest and highest corner."""

    lx: float
    ly: float
    lz: float
    hx: float
    hy: float
    hz: float


@inline
def _spread_bits(x: int) -> int:
    """Return the bits of x (up to 5) with two zeros between each."""
    return (x & 1) | (x & 2) << 2 | (x & 4) << 4 | (x & 8) << 6 | (x & 16) << 8


@helper
def scene_box(geometry: Geometry) -> SceneBox:
    """Return the box around all bounded entries of the scene; all zeros if it is empty or not finite."""
    box = SceneBox(math.inf, math.inf, math.inf, -math.inf, -math.inf, -math.inf)
    tree = length(geometry, table.TREE_ROOT) - 2
    for k in range(integer(geometry, table.TREE_ROOT, tree), integer(geometry, table.TREE_ROOT, tree + 1)):
        root = integer(geometry, table.ROOTS, k)
        if root < 0:
            continue
        at = node_at(geometry, root)
        for child in range(8):
            if integer(geometry, table.NODE_CHILDREN, 8 * root + child) != 0:
                b = geometry.floats
                box = SceneBox(
                    min(box.lx, b[at + child]), min(box.ly, b[at + 8 + child]), min(box.lz, b[at + 16 + child]),
                    max(box.hx, b[at + 24 + child]), max(box.hy, b[at + 32 + child]), max(box.hz, b[at + 40 + child]),
                )  # fmt: skip
    if not (box.lx > -math.inf and box.ly > -math.inf and box.lz > -math.inf):
        return SceneBox(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    if not (box.hx < math.inf and box.hy < math.inf and box.hz < math.inf):
        return SceneBox(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    return box


@inline
def _cell(x: float, low: float, scale: float, most: float) -> int:
    """Return which of the cells from `low` on, 1 / scale wide, holds x or is nearest to it; 0 for NaN."""
    share = (x - low) * scale
    share = choose(share > 0.0, share, 0.0)
    return whole(choose(share < most, share, most))


@inline
def _entry(o: float, d: float, low: float, high: float) -> float:
    """Return the t at which a ray enters a slab, if it begins before the slab; else 0 or less."""
    return choose(d != 0.0, (choose(d > 0.0, low, high) - o) / d, 0.0)


@inline
def _scale(low: float, high: float, cells: int) -> float:
    """Return cells for each unit of length between two ends; 0 for an empty interval."""
    return cells / (high - low) if high > low else 0.0


@inline
def _key(lanes: Floats, i: Any, box: SceneBox, scale: Triple, most: float, bits: int) -> None:
    """Compute the key of the ray in lane i."""
    ox, oy, oz, dx, dy, dz = lanes[OX + i], lanes[OY + i], lanes[OZ + i], lanes[DX + i], lanes[DY + i], lanes[DZ + i]
    tx, ty, tz = _entry(ox, dx, box.lx, box.hx), _entry(oy, dy, box.ly, box.hy), _entry(oz, dz, box.lz, box.hz)
    t = choose(tx > 0.0, tx, 0.0)
    t = choose(ty > t, ty, t)
    t = choose(tz > t, tz, t)
    x = _spread_bits(_cell(ox + t * dx, box.lx, scale.x, most))
    y = _spread_bits(_cell(oy + t * dy, box.ly, scale.y, most))
    z = _spread_bits(_cell(oz + t * dz, box.lz, scale.z, most))
    quarter = 4.0 / (abs(dx) + abs(dy) + abs(dz))
    u, v = _cell(abs(dx), 0.0, quarter, 3.0), _cell(abs(dy), 0.0, quarter, 3.0)
    octant = whole(choose(dx < 0.0, 1.0, 0.0) + choose(dy < 0.0, 2.0, 0.0) + choose(dz < 0.0, 4.0, 0.0))
    lanes[KEY + i] = float((octant << (3 * bits) | x | y << 1 | z << 2) << 4 | u << 2 | v)


@inline
def _keys(bits: int) -> int:
    """Return the number of keys with `bits` for each coordinate, three for the octant and four for the direction."""
    return 1 << (3 * bits + 7)


@kernel(origins="n 3", directions="n 3", begin="0..end", end="0..n", keys="out n", counts="out 65536|8192")
def ray_keys(
    geometry: Geometry, origins: Floats, directions: Floats, begin: int, end: int, keys: Ints, counts: Ints
) -> None:
    """Compute the keys of rays begin..end, and count how often each occurs; `counts` has an element for each key."""
    bits = _MORE_BITS if len(counts) == _keys(_MORE_BITS) else _FEW_BITS
    box, lanes, cells = scene_box(geometry), np.ones(_ROWS * LANES), 1 << bits
    scale = Triple(_scale(box.lx, box.hx, cells), _scale(box.ly, box.hy, cells), _scale(box.lz, box.hz, cells))
    for first in range(begin, end, LANES):
        count = min(LANES, end - first)
        for k in range(0, count & -8, 8):
            load_eight(origins, first + k, lanes, OX + np.uint64(k))
            load_eight(directions, first + k, lanes, DX + np.uint64(k))
        for k in range(count & -8, count):
            for axis in range(3):
                at = np.uint64(LANES * axis + k)
                lanes[OX + at], lanes[DX + at] = origins[first + k, axis], directions[first + k, axis]
        for i in range(np.uint64(LANES)):
            _key(lanes, i, box, scale, cells - 1.0, bits)
        for k in range(count):
            key = whole(lanes[KEY + np.uint64(k)])
            keys[first + k] = key
            counts[key] += 1


@kernel(keys="n", begin="0..end", end="0..n", places="out 65536|8192", order="out n")
def _place(keys: Ints, begin: int, end: int, places: Ints, order: Ints) -> None:
    """Write the rays of a block to their places, in order of their keys; ties keep their order."""
    for i in range(begin, end):
        key = keys[i]
        order[places[key]] = i
        places[key] += 1


@kernel(counts="out * *")
def _begin_places(counts: Ints) -> None:
    """Replace the count of every key in every block by the place of its first ray: by key, then by block."""
    total = 0
    for key in range(counts.shape[1]):
        for block in range(counts.shape[0]):
            count = counts[block, key]
            counts[block, key] = total
            total += count


def ray_order(geometry: Geometry, origins: Floats, directions: Floats) -> Ints:
    """Return the numbers of rays, int32, in an order in which neighbours are coherent; each number occurs once."""
    count = len(origins)
    bits = _MORE_BITS if count >= _MANY else _FEW_BITS
    blocks = max(1, min(thread_count(), 16, count // _CHUNK))
    edges = np.linspace(0, count, blocks + 1).astype(np.int64)
    keys, order = np.empty(count, np.int32), np.empty(count, np.int32)
    # Each block counts on its own; prefix sums over keys, then blocks, keep the sort stable and independent of threads
    counts = np.zeros((blocks, _keys(bits)), np.int32)

    def number(first: int, last: int) -> None:
        """Compute the keys of blocks first..last."""
        for block in range(first, last):
            ray_keys(geometry, origins, directions, edges[block], edges[block + 1], keys, counts[block])

    def place(first: int, last: int) -> None:
        """Write the rays of blocks first..last to their places."""
        for block in range(first, last):
            _place(keys, edges[block], edges[block + 1], counts[block], order)

    run_chunks(number, blocks, 1)
    _begin_places(counts)
    run_chunks(place, blocks, 1)
    return order
