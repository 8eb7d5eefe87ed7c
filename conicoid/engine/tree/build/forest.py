"""Trees one after the other in common tables, each with the roots that a walk begins at."""

from __future__ import annotations

from array import array
from typing import Any

import numpy as np

from ...lowering.apart import joined_apart
from ...lowering.surfaces import end_to_end
from ...tables import Floats, Ints
from ..leaf import ROWS
from .branches import WIDTH
from .build import Tree, build
from .nodes import leaf_code
from .records import ENDLESS, Survey, records_of, stand_ins, survey

MOST = 8  # entries in a leaf of a tree
_BESIDE = 15  # in a leaf beside it
_NONE = np.zeros(0, np.int32)


class Forest:
    """Collects trees; `put_boxes` fills in the boxes of their nodes, once there is a place for them."""

    def __init__(self, nodes: int = 0, places: int = 0) -> None:
        """To be put behind so many nodes and places of other trees."""
        self.trees: list[Tree] = []
        self.children: list[Ints] = [np.zeros((0, WIDTH), np.int32)]
        self.order: list[Ints] = [_NONE]
        self.roots = array("i")
        self.ends = array("i", [0])
        self.nodes = array("i", [nodes])  # up to the end of each tree
        self.places = array("i", [places])
        self.node_count = nodes
        self.placed = places
        self.depth = 1
        self.levels = 0

    def add(self, boxes: Floats, first_item: int, costs: Floats | None = None) -> Survey:
        """A tree over items first_item, ... with boxes (n, 6); `costs` (n,) of testing each. Empty boxes go nowhere.

        The boxes are let go before the tree is built.
        """
        boxes = np.ascontiguousarray(boxes)
        found = survey(boxes)
        limits = stand_ins(found.ends)
        records = []
        for pattern in np.flatnonzero(found.counts[:ENDLESS]).tolist():
            every = found.counts[pattern] == len(boxes)
            rows = _NONE if every else np.flatnonzero(found.patterns == pattern).astype(np.int32)
            records.append(records_of(boxes, rows, first_item, np.zeros(0) if costs is None else costs, limits))
        del boxes
        for some in records:
            self._plant(build(some, limits, MOST))
        self.add_beside(np.flatnonzero(found.patterns == ENDLESS).astype(np.int32) + np.int32(first_item))
        return found

    def _plant(self, tree: Tree) -> None:
        """Append a tree whose numbers begin at 0 to those that there are."""
        items, inner, leaf = tree.items(), tree.children > 0, tree.children < 0
        tree.children[inner] += self.node_count
        tree.children[leaf] -= self.placed << 4
        self.roots.append(self.node_count)
        self.trees.append(tree)
        self.children.append(tree.children)
        self.order.append(items)
        self.node_count += len(tree.children)
        self.placed += len(items)
        self.levels = max(self.levels, tree.levels)

    def add_beside(self, items: Ints) -> None:
        """Items that no box holds."""
        for first in range(0, len(items), _BESIDE):
            self.roots.append(leaf_code(self.placed + first, min(_BESIDE, len(items) - first)))
        self.order.append(items)
        self.placed += len(items)

    def end_tree(self) -> None:
        """What is added from now on belongs to the next tree."""
        # A node taken from the stack puts at most eight in its place, at every level
        self.depth = max(self.depth, len(self.roots) - self.ends[-1] + WIDTH * (self.levels + 1))
        self.levels = 0
        self.ends.append(len(self.roots))
        self.nodes.append(self.node_count)
        self.places.append(self.placed)

    def add_none(self, count: int) -> None:
        """So many empty trees."""
        for numbers, number in (
            (self.ends, len(self.roots)),
            (self.nodes, self.node_count),
            (self.places, self.placed),
        ):
            numbers.extend(array("i", [number]) * count)

    def columns(self) -> dict[str, Any]:
        """The columns of the trees; of boxes and items the shapes alone. The last tree alone has items."""
        return dict(
            node_boxes=np.broadcast_to(0.0, (self.node_count, 6, WIDTH)),
            node_children=end_to_end(self.children),
            tree_order=joined_apart(self.order),
            tree_root=np.frombuffer(self.ends, np.int32),
            roots=np.frombuffer(self.roots, np.int32) if self.roots else _NONE,
            tree_depth=np.array([self.depth], dtype=np.int32),
            leaf_items=np.broadcast_to(0.0, ROWS * (self.placed - self.places[-2])),
        )

    def put_boxes(self, floats: Floats, at: int) -> None:
        """Write the boxes of all nodes to floats[at:]."""
        for tree in self.trees:
            tree.put_boxes(floats, at)
            at += 6 * WIDTH * len(tree.children)
