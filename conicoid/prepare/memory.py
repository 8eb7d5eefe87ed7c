"""The memory of a scene, as `conicoid info` prints it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..kernels.tables import (
    ENTRY_KIND,
    LEAF_CELL,
    LEAF_ITEMS,
    NODE_BOXES,
    NODE_CHILDREN,
    PROGRAM_ROW,
    PROGRAM_SHIFTS,
    REGION,
    ROOTS,
    SHIFT_SIZE,
    TREE_DEPTH,
    TREE_ORDER,
    TREE_ROOT,
    Geometry,
    length,
)

_HINTS = {
    **dict.fromkeys(("total", "bytes", "nbytes", "size", "all"), "memory.tables + memory.tree are all bytes"),
    "cells": "it is called primitives",
}
_TREE = (NODE_CHILDREN, TREE_ORDER, TREE_ROOT, ROOTS, TREE_DEPTH)


class _Sizes(NamedTuple):
    primitives: int
    tables: int
    tree: int


class Memory(_Sizes):
    """Bytes of the arrays that hold a prepared scene.

    Attributes
    ----------
    primitives : int
        Number of balls, sheets, and primitives that are bodies or parts of Boolean bodies.
    tables : int
        Bytes of the tables of these.
    tree : int
        Bytes of the tree of boxes over them.
    """

    __slots__ = ()

    if not TYPE_CHECKING:  # type checkers would accept any name otherwise

        def __getattr__(self, name: str) -> Any:
            hint = f": {_HINTS[name]}" if name in _HINTS else ""
            raise AttributeError(f"'Memory' object has no attribute {name[:80]!r}{hint}", name=name, obj=self)


def measure_memory(geometry: Geometry) -> Memory:
    """Measure the memory of a geometry."""
    every = geometry.integers.nbytes + geometry.floats.nbytes
    boxes = int(length(geometry, NODE_BOXES) + length(geometry, LEAF_ITEMS)) * geometry.floats.itemsize
    tree = boxes + sum(int(length(geometry, k)) for k in _TREE) * geometry.integers.itemsize
    first, count = int(geometry.places[ENTRY_KIND]), int(length(geometry, ENTRY_KIND))
    regions = int(np.count_nonzero(geometry.integers[first : first + count] == REGION))
    return Memory(count - regions + _leaves(geometry), every - tree, tree)


def _leaves(geometry: Geometry) -> int:
    """Count the leaves of all programs."""
    rows, row = (
        geometry.integers[int(geometry.places[k]) :][: int(length(geometry, k))] for k in (PROGRAM_SHIFTS, PROGRAM_ROW)
    )
    if not len(rows):
        return int(length(geometry, LEAF_CELL))
    return int(np.diff(row)[rows.reshape(-1, SHIFT_SIZE)[:, -1]].sum())
