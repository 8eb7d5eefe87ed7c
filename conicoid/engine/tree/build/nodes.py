"""From branches to nodes of eight, as the tables hold them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ....compiler.jit import inline, kernel
from ...tables import Floats, Ints
from .branches import LEAF, NODE, ROW, WIDTH, Branches
from .records import restored
from .vectors import ITEM, SIZE, clear, join


def leaf_code(first: int, count: int) -> int:
    """A leaf of entries first, first + 1, ... of `tree_order`, as a number < 0; count is at most 15."""
    return -((first << 4) | count) - 1


_leaf_code = inline(leaf_code)


@kernel(root="0..branches-1", children="out n 8", sources="out n 8")
def take_nodes(branches: Branches, root: int, children: Ints, sources: Ints) -> tuple[int, int]:
    """Fill children (n, 8), and with the branch each comes from, sources (n, 8); returns (nodes, levels).

    (0, 0) where the branches are no tree.
    """
    stack = np.empty((len(children) + WIDTH, 3), np.int32)
    pending = np.empty((2 * WIDTH, 2), np.int64)
    stack[0, 0], stack[0, 1], stack[0, 2] = 0, root, 1
    top, used, levels = 1, 1, 1
    while top > 0:
        top -= 1
        node, branch, level = stack[top, 0], stack[top, 1], stack[top, 2]
        levels = max(levels, level)
        for k in range(WIDTH):
            children[node, k], sources[node, k] = 0, -1
        pending[0, 0], pending[0, 1] = branch, 1
        waiting, slot = 1, 0
        if branches.choice[ROW * branch + LEAF] == 0:
            waiting = _open(branches, branch, NODE, WIDTH, pending, 0)
        while waiting > 0:
            waiting -= 1
            branch, slots = pending[waiting, 0], pending[waiting, 1]
            at = ROW * branch
            while slots > 1 and branches.choice[at + slots] == 0:
                slots -= 1
            count = branches.choice[at + LEAF]
            if waiting + 2 > len(pending) or slot == WIDTH:
                return 0, 0
            if slots > 1 and branches.left[branch] >= 0:
                waiting = _open(branches, branch, slots, slots, pending, waiting)
                continue
            sources[node, slot] = branch
            if count > 0:
                children[node, slot] = _leaf_code(branches.first[branch], count)
            elif used == len(children):
                return 0, 0
            else:
                children[node, slot] = used
                stack[top, 0], stack[top, 1], stack[top, 2] = used, branch, level + 1
                used += 1
                top += 1
            slot += 1
    return used, levels


@inline
def _open(branches: Branches, branch: int, place: int, slots: int, pending: Any, waiting: int) -> int:
    """Give a branch's halves their slots. What is clipped is within its limits in a tree."""
    left = min(max(0, branches.left[branch]), len(branches.left) - 2)
    taken = min(max(1, branches.choice[ROW * branch + place]), slots - 1)
    pending[waiting, 0], pending[waiting, 1] = left + 1, slots - taken
    pending[waiting + 1, 0], pending[waiting + 1, 1] = left, taken
    return waiting + 2


@kernel(records="8*r", first="n 8", last="n 8", limits="6", begin="0..end", end="0..n", boxes="out b", at="0..b-48*end")
def box_nodes(
    records: Floats, first: Ints, last: Ints, limits: Floats, begin: int, end: int, boxes: Floats, at: int
) -> None:
    """Write the boxes of nodes begin..end, six sides of eight each, to boxes[at:].

    first, last: the records in each child of the nodes; none where there is no child.
    """
    box = np.empty(SIZE)
    for node in range(begin, end):
        for k in range(WIDTH):
            place, begins, ends = at + 6 * WIDTH * node + k, max(0, first[node, k]), last[node, k]
            if begins >= ends:
                for axis in range(3):
                    boxes[place + WIDTH * axis], boxes[place + WIDTH * (axis + 3)] = math.inf, -math.inf
                continue
            clear(box, 0)
            for i in range(begins, min(ends, len(records) // SIZE)):
                join(box, 0, records, SIZE * i)
            for axis in range(3):
                boxes[place + WIDTH * axis] = restored(limits, axis, -box[axis])
                boxes[place + WIDTH * (axis + 3)] = restored(limits, axis + 3, box[axis + 4])


@kernel(records="8*n", begin="0..end", end="0..n", items="out i", at="0..i-end")
def items_of(records: Floats, begin: int, end: int, items: Ints, at: int) -> None:
    """The items of records, in their order, to items[at + begin:]."""
    for i in range(begin, end):
        items[at + i] = np.int32(records[SIZE * i + ITEM])
