"""Leaves of the scene's tree: the items of one, side by side in one block of floats.

A leaf of n entries has six rows of n numbers: x, y, z and radii of balls around them, entries with their kinds (8 entry
+ kind), and indices, so that visiting a leaf waits for one place of memory only. The ball around an entry that is a
ball is that ball exactly; those around others are bounds, widened by their slack.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from ..._jit.decorators import helper, inline
from .. import tables as table
from ..programs import leaves_of
from ..ray import Ray
from ..surface.quadric import SphereRecord
from ..tables import Floats, Geometry, Ints, integer, length, node_at, whole
from .culling import BEAM, FIRST, HIGH_I, HIGH_O, LAST, LOW_I, LOW_O, boxes_met, lowest_bit, prefetch_soon
from .culling_constants import ENTRY_SLACK, STEEPEST

ROWS = 6
WHO, INDEX = 4, 5
"""The rows behind those of the balls."""
ROUND = 0.5
"""Added to the first entry where each ball of a leaf has a smaller mean projection than its entry's box."""


class LeafItem(NamedTuple):
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
def leaf_item(geometry: Geometry, at: int, count: int, k: int) -> LeafItem:
    """Item k of the leaf of `count` at floats[at:]."""
    who = whole(geometry.floats[at + WHO * count + k])
    return LeafItem(who & 7, leaf_index(geometry, at, count, k), who >> 3, who >> 3)


@inline
def leaf_ball(geometry: Geometry, at: int, count: int, k: int) -> SphereRecord:
    """The ball around item k."""
    f, at = geometry.floats, at + k
    return SphereRecord(f[at], f[at + count], f[at + 2 * count], f[at + 3 * count])


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


# Traversing a tree of boxes along a ray: the scene's own over its entries, a large body's over its leaves.
#
# The memory of a walk, its `way`, is one block of floats: where a beam enters the eight boxes that were tested last,
# the beam that is the ray, and a stack of what is still to be visited.

FEW = 12
"""Leaves of a body that are tested one by one, without a tree."""
OWN_BEAM = 8
"""Where the beam begins, behind the eight places."""
_STACK, _ROW = 24, 3
ITS_CODE, ITS_BOX, ITS_T = 0, 1, 2
"""Of what is on the stack: a node, or a leaf; its box, -1 for none; where the ray enters it."""
assert _STACK >= OWN_BEAM + BEAM


@inline
def way_size(depth: int) -> int:
    """How long the block of a walk is whose stack holds up to `depth`."""
    return _STACK + _ROW * depth


@inline
def on_stack(k: int) -> int:
    """Where number k of the stack begins."""
    return _STACK + _ROW * k


@inline
def put_on_stack(way: Floats, k: int, code: float, box: float, t: float) -> None:
    """Number k of the stack."""
    at = on_stack(k)
    way[at + ITS_CODE], way[at + ITS_BOX], way[at + ITS_T] = code, box, t


@inline
def reciprocal(d: float) -> float:
    """1 / d, finite, so that a ray along a wall of a box lies on one side of it and no 0 · inf arises."""
    return 1.0 / d if abs(d) > 1.0 / STEEPEST else math.copysign(STEEPEST, d)


@inline
def put_beam(beam: Floats, at: int, ray: Ray) -> None:
    """The beam that is one ray, at beam[at:]."""
    for axis in range(3):
        o, d = (ray.ox, ray.dx) if axis == 0 else ((ray.oy, ray.dy) if axis == 1 else (ray.oz, ray.dz))
        beam[at + LOW_O + axis], beam[at + HIGH_O + axis] = o, o
        beam[at + LOW_I + axis], beam[at + HIGH_I + axis] = reciprocal(d), reciprocal(d)
    beam[at + FIRST], beam[at + LAST] = ray.t_min, ray.t_max


@inline
def prefetch_node(geometry: Geometry, code: int) -> None:
    """Prefetch a node or leaf that is soon to be visited."""
    if code >= 0:
        at = node_at(geometry, code)
        for line in range(6):
            prefetch_soon(geometry.floats, at + 8 * line)
        prefetch_soon(geometry.integers, geometry.places[table.NODE_CHILDREN] + 8 * code)
    else:
        first, last = leaf_range(code)
        at = leaf_at(geometry, first)
        for k in range(0, 4 * (last - first), 8):  # the balls
            prefetch_soon(geometry.floats, at + k)


@inline
def push_children(geometry: Geometry, way: Floats, node: int, bits: int, top: int) -> int:
    """Push the children of a node that a mask selects on the stack, the nearest on top; returns its height.

    Relies on way[:8] holding the t at which each child is entered.
    """
    base = top
    while bits != 0:
        i = lowest_bit(bits)
        bits &= bits - 1
        t, child = way[i], integer(geometry, table.NODE_CHILDREN, 8 * node + i)
        if child == 0:
            continue
        prefetch_node(geometry, child)
        slot = top
        while slot > base and way[on_stack(slot - 1) + ITS_T] < t:
            before = on_stack(slot - 1)
            put_on_stack(way, slot, way[before + ITS_CODE], way[before + ITS_BOX], way[before + ITS_T])
            slot -= 1
        put_on_stack(way, slot, float(child), float(8 * node + i), t)
        top += 1
    return top


@inline
def push_roots(geometry: Geometry, way: Floats, tree: int) -> int:
    """Start a walk: what no box holds is on top. Returns the height of the stack."""
    first, last = integer(geometry, table.TREE_ROOT, tree), integer(geometry, table.TREE_ROOT, tree + 1)
    for k in range(first, last):
        put_on_stack(way, k - first, float(integer(geometry, table.ROOTS, k)), -1.0, -math.inf)
    return last - first


@inline
def push_node(geometry: Geometry, way: Floats, node: int, beam: Floats, at: int, top: int) -> int:
    """Put the children of a node that a beam (beam[at:]) meets on the stack; returns its height."""
    bits = boxes_met(geometry.floats, node_at(geometry, node), beam, at, way)
    return push_children(geometry, way, node, bits, top)


@inline
def next_leaf(geometry: Geometry, way: Floats, beam: Floats, at: int, top: int) -> tuple[int, int, int]:
    """Continue a traversal to the next leaf that a beam (beam[at:]) meets: (its code, its box or -1, stack height).

    Code 0: none is left. Relies on the stack holding all that was met and not visited, with a lower bound of the t at
    which it is entered; keeps that. What is entered beyond the beam's LAST, which may have been shortened since it was
    pushed, is culled. Single rays and packets traverse this way; streams (many rays at each node) and frontiers (level
    by level) are other algorithms.
    """
    while top > 0:
        top -= 1
        here = on_stack(top)
        t = way[here + ITS_T]
        if t - ENTRY_SLACK * abs(t) > beam[at + LAST]:
            continue
        code = whole(way[here + ITS_CODE])
        if code < 0:
            return code, whole(way[here + ITS_BOX]), top
        top = push_node(geometry, way, code, beam, at, top)
    return whole(0), whole(-1), 0


@helper
def walk(geometry: Geometry, way: Floats, tree: int, ray: Ray, found: Ints) -> int:
    """Put everything whose box the ray meets within its interval into `found`, in no order; returns how many.

    Conservative: the box test has slack, so it may report too much, never too little.
    """
    count = 0
    put_beam(way, OWN_BEAM, ray)
    code, _, top = next_leaf(geometry, way, way, OWN_BEAM, push_roots(geometry, way, tree))
    while code != 0:
        first, last = leaf_range(code)
        for k in range(first, last):
            found[count] = integer(geometry, table.TREE_ORDER, k)
            count += 1
        code, _, top = next_leaf(geometry, way, way, OWN_BEAM, top)
    return count


@helper
def walk_box(geometry: Geometry, way: Floats, tree: int, found: Ints, most: int) -> int:
    """`walk` for the points of a box, whose beam is at way[OWN_BEAM:] already; -1 where more than `most` are found."""
    count = 0
    code, _, top = next_leaf(geometry, way, way, OWN_BEAM, push_roots(geometry, way, tree))
    while code != 0:
        first, last = leaf_range(code)
        if count + last - first > most:
            return -1
        for k in range(first, last):
            found[count] = integer(geometry, table.TREE_ORDER, k)
            count += 1
        code, _, top = next_leaf(geometry, way, way, OWN_BEAM, top)
    return count


@helper
def walk_leaves(geometry: Geometry, way: Floats, program: int, ray: Ray, found: Ints) -> int:
    """`walk` over the leaves of a program; a few of them are all found, as they have no tree."""
    first, end = leaves_of(geometry, program)
    if end - first > FEW:
        return walk(geometry, way, program, ray, found)
    for leaf in range(first, end):
        found[leaf - first] = leaf
    return end - first


@helper
def walk_leaves_box(geometry: Geometry, way: Floats, program: int, found: Ints, most: int) -> int:
    """`walk_box` over the leaves of a program; a few of them are all found."""
    first, end = leaves_of(geometry, program)
    if end - first > FEW:
        return walk_box(geometry, way, program, found, most)
    if end - first > most:
        return -1
    for leaf in range(first, end):
        found[leaf - first] = leaf
    return end - first


@inline
def put_box(way: Floats, low: tuple[float, float, float], high: tuple[float, float, float]) -> None:
    """The beam that is the points of a box, at way[OWN_BEAM:]."""
    for axis in range(3):
        way[OWN_BEAM + LOW_O + axis] = low[0] if axis == 0 else (low[1] if axis == 1 else low[2])
        way[OWN_BEAM + HIGH_O + axis] = high[0] if axis == 0 else (high[1] if axis == 1 else high[2])
        way[OWN_BEAM + LOW_I + axis], way[OWN_BEAM + HIGH_I + axis] = 1.0, 1.0
    way[OWN_BEAM + FIRST], way[OWN_BEAM + LAST] = 0.0, 0.0


@inline
def scene_tree(geometry: Geometry) -> int:
    """The number of the tree over all entries."""
    return length(geometry, table.TREE_ROOT) - 2
