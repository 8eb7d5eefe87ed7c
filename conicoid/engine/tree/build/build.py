"""A tree over boxes: branches on all threads, then nodes of eight from them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...lowering.apart import empty
from ...tables import Floats, Ints
from ...threads import run_chunks
from .branches import ROW, WIDTH, grow, new_branches, weigh_first
from .large import part_large
from .nodes import box_nodes, items_of, take_nodes
from .vectors import SIZE

_NODES = 1024
_ITEMS = 1 << 16


@dataclass(frozen=True)
class Tree:
    """Nodes of eight over records; `children` are numbered from 0 and its leaves' entries too."""

    records: Floats  # (8 n,) in the order of the leaves
    children: Ints  # (nodes, 8)
    first: Ints  # (nodes, 8) the records in a child, from this one on
    last: Ints  # (nodes, 8) up to here; 0 where there is no child
    limits: Floats  # (6,) used in place of infinity in the records
    levels: int

    def put_boxes(self, floats: Floats, at: int) -> None:
        """Write the boxes of the nodes, (nodes, 6, 8) flat, to floats[at:]."""
        run_chunks(
            lambda a, b: box_nodes(self.records, self.first, self.last, self.limits, a, b, floats, at),
            len(self.children),
            _NODES,
        )

    def items(self) -> Ints:
        """The items in the order of the leaves."""
        items = empty(len(self.records) // SIZE, np.int32)
        run_chunks(lambda a, b: items_of(self.records, a, b, items, 0), len(items), _ITEMS)
        return items


def build(records: Floats, limits: Floats, most: int) -> Tree:
    """A tree over at least one record, which are put in order; a leaf holds at most `most` of them."""
    count = len(records) // SIZE
    groups = part_large(records)
    # The branches of the groups have the numbers from 2 n on: the first group's, then two for each that was parted
    branches, costs = new_branches(2 * count + len(groups)), np.zeros(ROW * len(groups))
    areas = np.array([group.area for group in groups])
    number = 1
    for k, group in enumerate(groups):
        branches.first[2 * count + k], branches.last[2 * count + k] = group.first, group.last
        if group.halves is not None:
            branches.left[2 * count + k] = 2 * count + number
            number += 2
    alone = [k for k, group in enumerate(groups) if group.halves is None]

    def work(begin: int, end: int) -> None:
        for k in alone[begin:end]:
            area = groups[k].area if len(groups) > 1 else math.inf
            grow(records, branches, 2 * count + k, area, most, costs, ROW * k)

    run_chunks(work, len(alone), 1)
    areas[0] = 0.0
    weigh_first(branches, 2 * count, areas, costs)
    children, sources = np.empty((count, WIDTH), np.int32), np.empty((count, WIDTH), np.int32)
    used, levels = take_nodes(branches, 2 * count, children, sources)
    children, sources = children[:used].copy(), sources[:used]
    first, last = (np.where(sources < 0, np.int32(0), each[sources]) for each in (branches.first, branches.last))
    return Tree(records, children, first, last, limits, levels)
