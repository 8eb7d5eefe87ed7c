"""Trees over a scene's entries and over a body's leaves, eight boxes to a node.

Boxes are split in two by the surface area heuristic, recursively, on all threads; nodes of eight are formed from
the binary branches so that the expected cost of a traversal is least. What is unbounded along some axes has a tree of
its own with all that is unbounded along the same; only what is unbounded along all three is kept outside of the trees.
"""

from __future__ import annotations

import math

import numpy as np

from ....shapes.rounded import odd_root
from ....shapes.row_vectors import lengths
from ...lowering import Lowered
from ...tables import BALL, CELL, LEAF_ITEMS, NODE_BOXES, POLYGON, REGION, SHEET, Floats, Geometry, pack
from .forest import Forest
from .leaf_items import put_items
from .records import Survey

_FEW = 12
"""Leaves of a body that are tested one by one, without a tree."""

_COSTS = np.ones(5)
"""What testing an entry of each kind costs, where a node costs one."""
_COSTS[[BALL, CELL, REGION, SHEET, POLYGON]] = 0.1, 0.8, 4.0, 1.0, 1.0


def with_trees(lowered: Lowered) -> Geometry:
    """The geometry of a lowered scene, with the trees over its entries and over the leaves of its bodies."""
    tables, forest = lowered.tables, Forest()
    for program in range(len(tables.program_leaf) - 1):
        first, last = int(tables.program_leaf[program]), int(tables.program_leaf[program + 1])
        if last - first <= _FEW:
            forest.add_beside(np.arange(first, last, dtype=np.int32))
        else:
            forest.add(tables.leaf_bounds[first:last], first)
        forest.end_tree()
    survey = forest.add(lowered.boxes, 0, _COSTS[tables.entry_kind])
    forest.end_tree()
    geometry = pack(forest.in_tables(tables._replace(extent=_extent(survey))), later=(NODE_BOXES, LEAF_ITEMS))
    forest.put_boxes(geometry.floats, int(geometry.places[NODE_BOXES]))
    put_items(geometry, lowered.boxes)
    return geometry


def _extent(survey: Survey) -> Floats:
    """(diagonal, an entry's share of it, middle) of what is bounded; of all ends, where nothing is."""
    bounded = int(survey.counts[0])
    around = survey.bounded if bounded else survey.ends
    count = bounded or int(survey.counts[1:7].sum())
    known = around[:3] <= around[3:]
    if count == 0 or not known.any():
        return np.array([0.0, math.inf, 0.0, 0.0, 0.0])
    low, high = np.where(known, around[:3], 0.0), np.where(known, around[3:], 0.0)
    diagonal = float(lengths(high - low))
    along_an_axis = (float(count), math.sqrt(count), float(odd_root(count, 3)))[int(known.sum()) - 1]
    return np.array([diagonal, diagonal / along_an_axis, *(0.5 * low + 0.5 * high)])


__all__ = ["with_trees"]
