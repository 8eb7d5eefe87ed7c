"""Leaves of the scene's tree: the items of one, side by side in one block of floats.

A leaf of n entries has eight rows of n numbers: x, y, z and radii of balls around them, kinds, indices, bodies and
entries, so that visiting a leaf waits for one place of memory only. The ball around an entry that is a ball is that
ball exactly; those around others are bounds, widened by their slack.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from ...compiler.jit import inline
from .. import tables as table
from ..surface.quadric import Sphere
from ..tables import Geometry, whole

ROWS = 8
ROUND = 0.5
"""Added to the kind of the first entry where each ball of a leaf has a smaller mean projection than its entry's box."""


class Item(NamedTuple):
    """An entry in a leaf, by numbers."""

    kind: Any
    index: Any  # surface, cell, program, sheet or polygon
    body: Any
    entry: Any


@inline
def leaf_range(code: int) -> tuple[int, int]:
    """(first, last) places in `tree_order` of a leaf."""
    first, count = (-code - 1) >> 4, (-code - 1) & 15
    return first, first + count


@inline
def leaf_at(geometry: Geometry, first: int) -> int:
    """Where in the floats the leaf of the scene's tree with this first place begins."""
    return geometry.places[table.ITEMS] + ROWS * first


@inline
def is_round(geometry: Geometry, at: int, count: int) -> bool:
    """Are the balls around the items of a leaf tighter than their boxes (`ROUND`)?"""
    kind = geometry.floats[at + 4 * count]
    return kind != math.floor(kind)


@inline
def leaf_item(geometry: Geometry, at: int, count: int, k: int) -> Item:
    """Item k of the leaf of `count` at floats[at:]."""
    f, at = geometry.floats, at + k
    return Item(
        whole(f[at + 4 * count]), whole(f[at + 5 * count]), whole(f[at + 6 * count]), whole(f[at + 7 * count])
    )  # fmt: skip


@inline
def leaf_ball(geometry: Geometry, at: int, count: int, k: int) -> Sphere:
    """The ball around item k."""
    f, at = geometry.floats, at + k
    return Sphere(f[at], f[at + count], f[at + 2 * count], f[at + 3 * count])


@inline
def leaf_number(geometry: Geometry, at: int, count: int, k: int, row: int) -> float:
    """Number `row` of the eight of item k: its ball, kind, index, body and entry, unconverted."""
    return geometry.floats[at + row * count + k]
