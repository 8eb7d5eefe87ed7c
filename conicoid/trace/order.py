"""Putting rays in an order in which neighbours see the same part of a scene.

Rays in no order are sorted by the octant of their direction, then by where they begin in the
scene's box (or enter it), then by direction within the octant: a key of a few bits for each, a stable
counting sort. Sixteen in a row then go well together. After Garanzha and Loop, Fast ray sorting and breadth-first
packet traversal (Eurographics 2010).
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from ..geometry import tables as table
from ..geometry.tables import Floats, Geometry, Ints, integer
from ..jit import helper, inline, kernel
from .threads import run_chunks, thread_count

_CHUNK = 1 << 16


@inline
def _spread_bits(x: int) -> int:
    """The bits of x (up to 5), two zeros between each."""
    return (x & 1) | (x & 2) << 2 | (x & 4) << 4 | (x & 8) << 6 | (x & 16) << 8


@helper
def scene_box(geometry: Geometry) -> tuple[float, float, float, float, float, float]:
    """The box of all that the scene's tree holds: low, high; (0, 0, 0) to (0, 0, 0) for none."""
    box = (math.inf, math.inf, math.inf, -math.inf, -math.inf, -math.inf)
    tree = geometry.places[table.TREE_ROOT, 1] - 2
    for k in range(integer(geometry, table.TREE_ROOT, tree), integer(geometry, table.TREE_ROOT, tree + 1)):
        root = integer(geometry, table.ROOTS, k)
        if root < 0:
            continue
        at = geometry.places[table.NODE_BOXES, 0] + 48 * root
        for child in range(8):
            if integer(geometry, table.NODE_CHILDREN, 8 * root + child) != 0:
                b = geometry.floats
                box = (
                    min(box[0], b[at + child]), min(box[1], b[at + 8 + child]), min(box[2], b[at + 16 + child]),
                    max(box[3], b[at + 24 + child]), max(box[4], b[at + 32 + child]), max(box[5], b[at + 40 + child]),
                )  # fmt: skip
    if not (box[0] > -math.inf and box[1] > -math.inf and box[2] > -math.inf):
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    if not (box[3] < math.inf and box[4] < math.inf and box[5] < math.inf):
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    return box


@inline
def _cell(x: float, low: float, high: float, count: int) -> int:
    """Which of some equal parts of [low, high] holds x, or is next to it."""
    share = (x - low) / (high - low) if high > low else 0.0
    return int(count * min(max(share, 0.0), 0.999))


@inline
def _entry(o: float, d: float, low: float, high: float) -> float:
    """From which t on a ray is beyond the nearer side of a slab."""
    if d == 0.0 or low <= o <= high:
        return 0.0
    return max(0.0, ((low if d > 0.0 else high) - o) / d)


@kernel
def ray_keys(
    geometry: Geometry, origins: Floats, directions: Floats, bits: int, begin: int, end: int,
    keys: Ints, counts: Ints,
) -> None:  # fmt: skip
    """The keys of rays begin..end, and how often each occurs among them."""
    lx, ly, lz, hx, hy, hz = scene_box(geometry)
    cells = 1 << bits
    for i in range(begin, end):
        ox, oy, oz = origins[i, 0], origins[i, 1], origins[i, 2]
        dx, dy, dz = directions[i, 0], directions[i, 1], directions[i, 2]
        t = max(_entry(ox, dx, lx, hx), max(_entry(oy, dy, ly, hy), _entry(oz, dz, lz, hz)))
        x = _spread_bits(_cell(ox + t * dx, lx, hx, cells))
        y = _spread_bits(_cell(oy + t * dy, ly, hy, cells))
        z = _spread_bits(_cell(oz + t * dz, lz, hz, cells))
        size = abs(dx) + abs(dy) + abs(dz)
        u, v = _cell(abs(dx), 0.0, size, 8), _cell(abs(dy), 0.0, size, 8)
        octant = (1 if dx < 0.0 else 0) | (2 if dy < 0.0 else 0) | (4 if dz < 0.0 else 0)
        key = (octant << (3 * bits) | x | y << 1 | z << 2) << 6 | u << 3 | v
        keys[i] = key
        counts[key] += 1


@kernel
def _place(keys: Ints, begin: int, end: int, places: Ints, order: Ints) -> None:
    for i in range(begin, end):
        key = keys[i]
        order[places[key]] = i
        places[key] += 1


@kernel
def _begin_places(counts: npt.NDArray[np.int32]) -> None:
    """Counts of every key in every block, to where its first goes: by key, then by block."""
    total = 0
    for key in range(counts.shape[1]):
        for block in range(counts.shape[0]):
            count = counts[block, key]
            counts[block, key] = total
            total += count


def ray_order(geometry: Geometry, origins: Floats, directions: Floats) -> Ints:
    """Numbers of rays in an order in which neighbours go well together."""
    count = len(origins)
    bits = 3 if count >= 1 << 18 else 2
    blocks = max(1, min(thread_count(), 16, count // _CHUNK))
    edges = np.linspace(0, count, blocks + 1).astype(np.int64)
    keys, order = np.empty(count, np.int32), np.empty(count, np.int32)
    counts = np.zeros((blocks, 1 << (3 * bits + 9)), np.int32)

    def number(first: int, last: int) -> None:
        for block in range(first, last):
            ray_keys(geometry, origins, directions, bits, edges[block], edges[block + 1], keys, counts[block])

    def place(first: int, last: int) -> None:
        for block in range(first, last):
            _place(keys, edges[block], edges[block + 1], counts[block], order)

    run_chunks(number, blocks, 1)
    _begin_places(counts)
    run_chunks(place, blocks, 1)
    return order
