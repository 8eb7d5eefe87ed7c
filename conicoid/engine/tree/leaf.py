"""Leaves of the scene's tree: the items of one, side by side in one block of floats.

A leaf of n entries has six rows of n numbers: x, y, z and radii of balls around them, entries with their kinds (8 entry
+ kind), and indices, so that visiting a leaf waits for one place of memory only. The ball around an entry that is a
ball is that ball exactly; those around others are bounds, widened by their slack.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from ...compiler.jit import inline
from .. import tables as table
from ..surface.quadric import Sphere
from ..tables import Geometry, whole

ROWS = 6
WHO, INDEX = 4, 5
"""The rows behind those of the balls."""
ROUND = 0.5
"""Added to the first entry where each ball of a leaf has a smaller mean projection than its entry's box."""


class Item(NamedTuple):
    """An entry in a leaf, by numbers."""

    kind: Any
    index: Any  # surface, cell, program, sheet or polygon
    body: Any
    entry: Any  # the number of its body


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
    who = geometry.floats[at + WHO * count]
    return who != math.floor(who)


@inline
def leaf_item(geometry: Geometry, at: int, count: int, k: int) -> Item:
    """Item k of the leaf of `count` at floats[at:]."""
    who = whole(geometry.floats[at + WHO * count + k])
    return Item(who & 7, leaf_index(geometry, at, count, k), who >> 3, who >> 3)


@inline
def leaf_ball(geometry: Geometry, at: int, count: int, k: int) -> Sphere:
    """The ball around item k."""
    f, at = geometry.floats, at + k
    return Sphere(f[at], f[at + count], f[at + 2 * count], f[at + 3 * count])


@inline
def leaf_kind(geometry: Geometry, at: int, count: int, k: int) -> int:
    """The kind of item k."""
    return whole(geometry.floats[at + WHO * count + k]) & 7


@inline
def leaf_index(geometry: Geometry, at: int, count: int, k: int) -> int:
    """The surface, cell, program, sheet or polygon that item k is."""
    return whole(geometry.floats[at + INDEX * count + k])


@inline
def leaf_entry(geometry: Geometry, at: int, count: int, k: int) -> int:
    """The entry that item k is."""
    return whole(geometry.floats[at + WHO * count + k]) >> 3
