"""What a scene takes in memory, as `conicoid info` says it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .tables import (
    ENTRY_KIND,
    LEAF_CELL,
    LEAF_ITEMS,
    NODE_BOXES,
    NODE_CHILDREN,
    REGION,
    ROOTS,
    TREE_DEPTH,
    TREE_ORDER,
    TREE_ROOT,
    Geometry,
    length,
)

_TREE = (NODE_CHILDREN, TREE_ORDER, TREE_ROOT, ROOTS, TREE_DEPTH)


class Memory(NamedTuple):
    """Bytes that kernels read, and for how many cells: balls, primitives, sheets, each leaf of a Boolean body."""

    cells: int
    tables: int  # surfaces, cells, programs, entries
    tree: int


def memory(geometry: Geometry) -> Memory:
    """Count the bytes of a geometry."""
    every = geometry.integers.nbytes + geometry.floats.nbytes
    boxes = int(length(geometry, NODE_BOXES) + length(geometry, LEAF_ITEMS)) * geometry.floats.itemsize
    tree = boxes + sum(int(length(geometry, k)) for k in _TREE) * geometry.integers.itemsize
    first, count = int(geometry.places[ENTRY_KIND]), int(length(geometry, ENTRY_KIND))
    regions = int(np.count_nonzero(geometry.integers[first : first + count] == REGION))
    return Memory(count - regions + int(length(geometry, LEAF_CELL)), every - tree, tree)
