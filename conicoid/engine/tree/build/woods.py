"""The trees of a scene as a whole: those of its bodies' leaves, then that of its entries; kept for edited scenes."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ....shapes.rounded import odd_root
from ....shapes.row_vectors import lengths
from ...programs import leaves_of_programs
from ...tables import BALL, CELL, POLYGON, REGION, SHEET, Floats, Ints, Tables
from ..walk import FEW
from .forest import Forest
from .records import Survey

COSTS = np.ones(5)
"""What testing an entry of each kind costs, where a node costs one."""
COSTS[[BALL, CELL, REGION, SHEET, POLYGON]] = 0.1, 0.8, 4.0, 1.0, 1.0


@dataclass(frozen=True)
class Woods:
    """Where trees end in the tables, and how the tree over the entries has been changed since it was built."""

    nodes: Ints  # (programs + 1,) first node of the tree of each body, last of that of the entries
    places: Ints  # the same of places in `tree_order`
    depth: int  # of the walk's stack in the tree of a body
    levels: int  # of the tree over the entries
    main: tuple[int, int, int]  # up to which node, place and root that goes; behind it is the tree of what is loose
    loose: Ints  # the entries in that
    left: int = 0  # how many entries have been taken from the tree since it was built

    @classmethod
    def of(cls, forest: Forest, depth: int, levels: int, all_of_them: bool = True) -> Woods:
        """Of a forest whose last tree is that of the entries; of the depth and levels see above.

        all_of_them: where trees of bodies end is kept, not of the last alone; only edits ask for it.
        """
        main = forest.nodes[-1], forest.places[-1], forest.ends[-1]
        first = 0 if all_of_them else -2
        nodes, places = (np.array(part[first:-1], np.int32) for part in (forest.nodes, forest.places))
        return cls(nodes, places, depth, levels, main, np.zeros(0, np.int32))


def programs_of(tables: Tables, edited: bool = True) -> Forest:
    """The trees over the leaves of each body: empty ones of those that have few, or none at all where all have.

    edited: might the scene be? Then each body has one.
    """
    forest, (first, count) = Forest(), leaves_of_programs(tables)
    large = np.flatnonzero(count > FEW).tolist()
    if not (large or edited):
        return forest
    for begin, end in zip([0, *(program + 1 for program in large)], [*large, len(first)], strict=True):
        if end > begin:
            forest.add_none(end - begin)
        if end < len(first):
            forest.add(tables.bounds_of_leaves(end), int(first[end]))
            forest.end_tree()
    return forest


def extent_of(survey: Survey) -> Floats:
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
