"""The binary tree from which the nodes of eight are taken, and what each of its subtrees costs.

A subtree may become one node, or several slots of the node above it; what is cheapest follows from the cheapest
for its halves (Ylitie, Karras, Laine: Efficient incoherent ray traversal on GPUs through compressed wide
BVHs, HPG 2017). The cost of a tree is the sum over its nodes of their area, plus for each leaf its area times what
visiting it and testing its entries costs, where visiting a node costs one.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ....compiler.jit import helper, inline, kernel
from ....compiler.shapes import shaped
from ...tables import Floats, Ints, Signs
from .bins import BINS, BOXES, cut_group
from .vectors import COST, SIZE, half_area

WIDTH = 8
ROW = 8  # numbers for each branch: at j = 1..7 the cost of j slots and which of them the left half takes
LEAF_COST = 0.3  # of visiting a leaf, without what its entries cost
# In `choice`: how many entries, if a leaf is best, else 0; slots of the left half in a node of its own
LEAF, NODE = 1, 0


@shaped(left="branches", first="branches", last="branches", choice="8*branches")
class Branches(NamedTuple):
    """A binary tree; the branches within records [begin, end) have numbers from 2 begin, the first ones from 2 n."""

    left: Ints  # its left half, the right one is next to it; -1: one entry
    first: Ints  # its records
    last: Ints
    choice: Signs  # (8 branches,)


def new_branches(count: int) -> Branches:
    """Room for `count` branches."""
    return Branches(
        np.empty(count, np.int32), np.empty(count, np.int32), np.empty(count, np.int32), np.zeros(ROW * count, np.int8)
    )


@inline
def _put(branches: Branches, branch: int, left: int, first: int, last: int) -> None:
    """Write a branch over records first..last."""
    branches.left[branch], branches.first[branch], branches.last[branch] = left, first, last


@inline
def _cost_of_one(records: Floats, branches: Branches, branch: int, costs: Floats, at: int) -> None:
    """A single entry: it takes one slot, however many there are."""
    first = SIZE * branches.first[branch]
    cost = half_area(records, first) * (LEAF_COST + records[first + COST])
    for j in range(1, ROW):
        costs[at + j] = cost
    branches.choice[ROW * branch + LEAF] = 1


@helper
def weigh(branches: Branches, branch: int, area: float, as_leaf: float, costs: Floats, at: int, half: int) -> None:
    """The costs of a branch from those of its halves, costs[half:] and costs[half + 8:]."""
    choice, size = branches.choice, branches.last[branch] - branches.first[branch]
    other = half + ROW
    for slots in range(2, WIDTH + 1):
        best, taken = math.inf, 1
        for k in range(max(1, slots - 7), min(slots, WIDTH)):
            cost = costs[half + k] + costs[other + slots - k]
            if cost < best:
                best, taken = cost, k
        if slots == WIDTH:
            choice[ROW * branch + NODE] = taken
            as_node = best + area
        else:
            choice[ROW * branch + slots] = taken
            costs[at + slots] = best
    costs[at + 1] = min(as_node, as_leaf)
    choice[ROW * branch + LEAF] = size if as_leaf < as_node else 0
    for slots in range(2, WIDTH):
        # Fewer slots may be better
        if costs[at + slots - 1] <= costs[at + slots]:
            costs[at + slots] = costs[at + slots - 1]
            choice[ROW * branch + slots] = 0


@inline
def _cost_as_leaf(records: Floats, first: int, last: int, area: float, most: int) -> float:
    """What a branch costs as one leaf; infinite where it has too many entries."""
    if last - first > most:
        return math.inf
    cost = 0.0
    for i in range(first, last):
        cost += records[SIZE * i + COST]
    return area * (LEAF_COST + cost)


@kernel(records="8*n", branches="out", root="0..branches-1", root_costs="out c", row="0..c-8")
def grow(records: Floats, branches: Branches, root: int, area: float, most: int, root_costs: Floats, row: int) -> None:
    """Build a branch down to its entries, and weigh it: its costs go to root_costs[row:]. Leaves hold `most`."""
    begin, end = branches.first[root], branches.last[root]
    if not (0 <= begin < end <= len(records) // SIZE and 2 * end <= len(branches.first)):
        return
    base, used = 2 * begin, 2 * begin
    boxes, counts = np.empty(BOXES), np.empty(3 * BINS, np.int64)
    areas, costs = np.empty(2 * (end - begin)), np.empty(ROW * 2 * (end - begin))
    stack, top = np.empty(64, np.int64), 1
    stack[0] = root
    while top > 0:
        top -= 1
        branch = stack[top]
        first, last = branches.first[branch], branches.last[branch]
        if last - first == 1:
            branches.left[branch] = -1
            continue
        middle, left_area, right_area = cut_group(records, first, last, boxes, counts)
        branches.left[branch] = used
        _put(branches, used, -1, first, middle)
        _put(branches, used + 1, -1, middle, last)
        areas[used - base], areas[used + 1 - base] = left_area, right_area
        # The smaller half first: so the stack stays below the logarithm of the size
        larger = used if middle - first > last - middle else used + 1
        stack[top], stack[top + 1] = larger, 2 * used + 1 - larger
        used += 2
        top += 2
    for branch in range(used - 1, base - 1, -1):
        at, left = ROW * (branch - base), branches.left[branch]
        if left < 0:
            _cost_of_one(records, branches, branch, costs, at)
        else:
            here = areas[branch - base]
            as_leaf = _cost_as_leaf(records, branches.first[branch], branches.last[branch], here, most)
            weigh(branches, branch, here, as_leaf, costs, at, ROW * (left - base))
    # Its halves are the first two rows of costs; the last is free
    at = len(costs) - ROW
    if branches.left[root] < 0:
        _cost_of_one(records, branches, root, costs, at)
    else:
        weigh(branches, root, area, _cost_as_leaf(records, begin, end, area, most), costs, at, 0)
    for j in range(1, ROW):
        root_costs[row + j] = costs[at + j]


@kernel(branches="out", first="0..branches-groups", areas="groups", costs="out 8*groups")
def weigh_first(branches: Branches, first: int, areas: Floats, costs: Floats) -> None:
    """Weigh the branches from number `first` on whose halves are known: those that have no entries of their own yet."""
    for k in range(len(areas) - 1, -1, -1):
        left = branches.left[first + k]
        if first <= left < first + len(areas) - 1:
            weigh(branches, first + k, areas[k], math.inf, costs, ROW * k, ROW * (left - first))
