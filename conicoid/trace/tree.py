"""Trees over a scene's entries and over a body's leaves: eight boxes to a node, built by binned surface area heuristic.

Each node is filled by splitting its costliest group of entries until there are eight groups
(Wald, Benthin, Boulos: Getting rid of packets, RT 2008; binning after Wald, RT 2007). Boxes are widened
by some ulps, so that the rounding of a slab test never loses what they hold.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from ..geometry.tables import Floats, Geometry, Ints, Tables, pack
from ..jit import allocator, helper, inline, kernel
from ..lowering import Lowered

WIDTH = 8
_LEAF = 1  # entries in a leaf of a tree: testing one costs more than its box
_MOST = 15
_FEW = 12
_BINS = 16
_MANY = 4096
_WIDEN = 16 * 2.0**-53


def with_trees(lowered: Lowered) -> Geometry:
    """The geometry of a lowered scene, with the trees over its entries and over the leaves of its bodies."""
    tables, forest = lowered.tables, _Forest()
    for program in range(len(tables.program_leaf) - 1):
        first, last = int(tables.program_leaf[program]), int(tables.program_leaf[program + 1])
        leaves = np.arange(first, last, dtype=np.int32)
        if last - first <= _FEW:
            forest.add_unordered(leaves)
        else:
            forest.add(tables.leaf_bounds[first:last], leaves)
    forest.add(lowered.boxes, np.arange(len(lowered.boxes), dtype=np.int32))
    return pack(forest.in_tables(tables._replace(extent=_extent(lowered.boxes))))


def _extent(boxes: Floats) -> Floats:
    """(diagonal, an entry's share of it, middle) of the finite boxes."""
    finite = boxes[np.isfinite(boxes).all(axis=1)]
    if not len(finite):
        return np.array([0.0, math.inf, 0.0, 0.0, 0.0])
    low, high = finite[:, :3].min(axis=0), finite[:, 3:].max(axis=0)
    diagonal = float(np.linalg.norm(high - low))
    return np.array([diagonal, diagonal / len(finite) ** (1 / 3), *(0.5 * (low + high))])


@dataclass
class _Forest:
    """Trees one after the other in common arrays."""

    nodes: list[Floats] = field(default_factory=list)
    children: list[Ints] = field(default_factory=list)
    order: list[Ints] = field(default_factory=list)
    roots: list[int] = field(default_factory=list)
    tree_root: list[int] = field(default_factory=lambda: [0])
    node_count: int = 0
    placed: int = 0
    depth: int = 1

    def add_unordered(self, items: Ints) -> None:
        """A handful of items without boxes; the roots of a tree end with it."""
        for first in range(0, len(items), _MOST):
            self.roots.append(leaf_code(self.placed + first, min(_MOST, len(items) - first)))
        self.order.append(items)
        self.placed += len(items)
        self.depth = max(self.depth, len(self.roots) - self.tree_root[-1] + 1)
        self.tree_root.append(len(self.roots))

    def add(self, boxes: Floats, items: Ints) -> None:
        """A tree over the items with finite boxes; those without an end go beside it, empty ones nowhere."""
        empty = (boxes[:, :3] > boxes[:, 3:]).any(axis=1)
        endless = ~np.isfinite(boxes).all(axis=1) & ~empty
        bounded = np.flatnonzero(~endless & ~empty)
        nodes, children, order, levels = build(widened(boxes[bounded]))
        if len(nodes):
            self.roots.append(self.node_count)
            self.depth = max(self.depth, WIDTH * (levels + 1) + int(endless.sum()) // _MOST + 1)
            inner, outer = children > 0, children < 0
            children[inner] += self.node_count
            children[outer] -= self.placed << 4
        self.nodes.append(nodes)
        self.children.append(children)
        self.order.append(items[bounded[order]])
        self.node_count += len(nodes)
        self.placed += len(bounded)
        self.add_unordered(items[endless])

    def in_tables(self, tables: Tables) -> Tables:
        return tables._replace(
            node_boxes=np.concatenate(self.nodes),
            node_children=np.concatenate(self.children),
            tree_order=np.concatenate(self.order),
            tree_root=np.array(self.tree_root, dtype=np.int32),
            roots=np.array(self.roots, dtype=np.int32),
            tree_depth=np.array([self.depth + WIDTH], dtype=np.int32),
        )


@inline
def leaf_code(first: int, count: int) -> int:
    """A leaf of entries first, first + 1, ... of `tree_order`, as a number < 0; count is at most 15."""
    return -((first << 4) | count) - 1


def widened(boxes: Floats) -> Floats:
    """Boxes (n, 6) grown by 16 units of roundoff of their place and size."""
    low, high = boxes[:, :3], boxes[:, 3:]
    margin = _WIDEN * (np.abs(low) + np.abs(high) + (high - low)) + 1e-300
    return np.concatenate([low - margin, high + margin], axis=1)


def build(boxes: Floats) -> tuple[Floats, Ints, Ints, int]:
    """(node boxes (n, 6, 8), children (n, 8), order of the entries in the leaves, levels)."""
    count = len(boxes)
    order = np.arange(count, dtype=np.int32)
    if count == 0:
        return np.zeros((0, 6, WIDTH)), np.zeros((0, WIDTH), np.int32), order, 0
    capacity = max(1, count)
    nodes = np.empty((capacity, 6, WIDTH))
    children = np.zeros((capacity, WIDTH), np.int32)
    used, levels = _build(np.ascontiguousarray(boxes), order, nodes, children)
    return nodes[:used].copy(), children[:used].copy(), order, levels


@kernel
def _build(boxes: Floats, order: Ints, nodes: Floats, children: Ints) -> tuple[int, int]:
    """Fill nodes depth first; returns how many nodes and how many levels there are."""
    first = np.empty(WIDTH, np.int64)
    last = np.empty(WIDTH, np.int64)
    cost = np.empty(WIDTH)
    box = np.empty(6)
    scratch = np.empty(len(order), np.int32)
    stack = np.empty((len(order) + 1, 4), np.int64)
    stack[0, 0], stack[0, 1], stack[0, 2], stack[0, 3] = 0, 0, len(order), 1
    top, used, levels = 1, 1, 1
    while top > 0:
        top -= 1
        node = stack[top, 0]
        first[0], last[0], level = stack[top, 1], stack[top, 2], stack[top, 3]
        levels = max(levels, level)
        cost[0] = np.inf
        groups = 1
        while groups < WIDTH:
            # The costliest group that is still too large for a leaf
            worst, worst_cost = -1, -1.0
            for g in range(groups):
                if last[g] - first[g] > _LEAF and cost[g] > worst_cost:
                    worst, worst_cost = g, cost[g]
            if worst < 0:
                break
            middle = _split(boxes, order, scratch, first[worst], last[worst])
            first[groups], last[groups] = middle, last[worst]
            last[worst] = middle
            for g in (worst, groups):
                _enclose(boxes, order, first[g], last[g], box)
                cost[g] = _half_area(box) * (last[g] - first[g])
            groups += 1
        for g in range(WIDTH):
            if g >= groups:
                nodes[node, 0:3, g] = np.inf
                nodes[node, 3:6, g] = -np.inf
                continue
            _enclose(boxes, order, first[g], last[g], box)
            for k in range(6):
                nodes[node, k, g] = box[k]
            size = last[g] - first[g]
            if size <= _LEAF:
                children[node, g] = leaf_code(first[g], size)
            else:
                children[node, g] = used
                stack[top, 0], stack[top, 1], stack[top, 2], stack[top, 3] = used, first[g], last[g], level + 1
                used += 1
                top += 1
    return used, levels


@helper
def _enclose(boxes: Floats, order: Ints, first: int, last: int, box: Floats) -> None:
    for k in range(3):
        box[k], box[k + 3] = np.inf, -np.inf
    for i in range(first, last):
        for k in range(3):
            box[k] = min(box[k], boxes[order[i], k])
            box[k + 3] = max(box[k + 3], boxes[order[i], k + 3])


@helper
def _half_area(box: Floats) -> float:
    x, y, z = box[3] - box[0], box[4] - box[1], box[5] - box[2]
    return x * y + y * z + z * x


@allocator
def _split(boxes: Floats, order: Ints, scratch: Ints, first: int, last: int) -> int:
    """Part order[first:last] in two by the best of the bins along each axis; returns the border."""
    low = np.full(3, np.inf)
    high = np.full(3, -np.inf)
    for i in range(first, last):
        for k in range(3):
            c = 0.5 * boxes[order[i], k] + 0.5 * boxes[order[i], k + 3]
            low[k], high[k] = min(low[k], c), max(high[k], c)
    bins = np.empty((3, _BINS, 6))
    counts = np.zeros((3, _BINS), np.int64)
    bins[:, :, 0:3] = np.inf
    bins[:, :, 3:6] = -np.inf
    scale = np.zeros(3)
    for k in range(3):
        scale[k] = _BINS * (1.0 - 1e-9) / (high[k] - low[k]) if high[k] > low[k] else 0.0
    if last - first > _MANY:
        # So many that one axis will do: the longest
        longest = 0 if scale[0] > 0.0 and (scale[1] == 0.0 or scale[0] <= scale[1]) else 1
        longest = longest if scale[longest] > 0.0 and (scale[2] == 0.0 or scale[longest] <= scale[2]) else 2
        for k in range(3):
            scale[k] = scale[k] if k == longest else 0.0
    for i in range(first, last):
        e = order[i]
        for k in range(3):
            if scale[k] == 0.0:
                continue
            b = int(scale[k] * (0.5 * boxes[e, k] + 0.5 * boxes[e, k + 3] - low[k]))
            counts[k, b] += 1
            for j in range(3):
                bins[k, b, j] = min(bins[k, b, j], boxes[e, j])
                bins[k, b, j + 3] = max(bins[k, b, j + 3], boxes[e, j + 3])
    axis, border = _best_border(bins, counts, scale)
    if axis < 0:
        return (first + last) // 2
    # Stable partition
    kept, moved = first, 0
    for i in range(first, last):
        e = order[i]
        if int(scale[axis] * (0.5 * boxes[e, axis] + 0.5 * boxes[e, axis + 3] - low[axis])) < border:
            order[kept] = e
            kept += 1
        else:
            scratch[moved] = e
            moved += 1
    for i in range(moved):
        order[kept + i] = scratch[i]
    return kept


@allocator
def _best_border(bins: Floats, counts: npt.NDArray[np.int64], scale: Floats) -> tuple[int, int]:
    """(axis, bin) with the least sum of area times count on both sides; axis -1 if nothing can be split."""
    best, best_axis, best_border = np.inf, -1, 0
    right_cost = np.empty(_BINS)
    box = np.empty(6)
    for k in range(3):
        if scale[k] == 0.0:
            continue
        for sweep in range(2):
            box[0:3], box[3:6] = np.inf, -np.inf
            total = 0
            for step in range(_BINS - 1):
                b = _BINS - 1 - step if sweep == 0 else step
                total += counts[k, b]
                for j in range(3):
                    box[j], box[j + 3] = min(box[j], bins[k, b, j]), max(box[j + 3], bins[k, b, j + 3])
                cost = _half_area(box) * total if total > 0 else 0.0
                if sweep == 0:
                    right_cost[b] = cost
                elif cost + right_cost[b + 1] < best and total > 0:
                    best, best_axis, best_border = cost + right_cost[b + 1], k, b + 1
    return best_axis, best_border
