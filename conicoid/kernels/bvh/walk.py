"""Traversal of trees of boxes along a ray, and the items of a leaf.

There is one tree over the entries of the scene, and one over the leaves of each large body.

A leaf of the scene's tree with n entries is one block of six rows of n floats: x, y, z and radii of balls around the
entries, 8 entry + kind, and indices. So visiting a leaf waits for one place of memory only. The ball around an entry
that is a ball is that ball exactly; balls around other entries are bounds, widened by their slack.
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
from .culling import BEAM, FIRST, HIGH_I, HIGH_O, LAST, LOW_I, LOW_O, hit_boxes, lowest_bit, prefetch_soon
from .culling_constants import ENTRY_SLACK, STEEPEST

ROWS = 6
WHO, INDEX = 4, 5
"""Rows of a leaf behind those of the balls: 8 entry + kind, index."""
ROUND = 0.5
"""Added to the first element of row `WHO` if each ball of a leaf has a smaller mean projection than its entry's box."""


class LeafItem(NamedTuple):
    """An entry in a leaf; all fields are int64."""

    kind: Any
    index: Any  # surface, cell, program, sheet or polygon
    body: Any
    entry: Any  # the number of its body


@inline
def leaf_range(code: int) -> tuple[int, int]:
    """Return (first, end) places in `tree_order` of the leaf with this code."""
    # Codes of leaves are negative, so that one number tells a node from a leaf; four bits hold the number of items
    first, count = (-code - 1) >> 4, (-code - 1) & 15
    return first, first + count


@inline
def leaf_at(geometry: Geometry, first: int) -> int:
    """Return the place in the floats of the leaf of the scene's tree whose first place in `tree_order` is `first`."""
    return geometry.places[table.ITEMS] + ROWS * first


@inline
def is_round(geometry: Geometry, at: int, count: int) -> bool:
    """True if the balls around the items of a leaf are tighter than their boxes (`ROUND`)."""
    # A half in the first number: a flag that costs no memory of its own
    who = geometry.floats[at + WHO * count]
    return who != math.floor(who)


@inline
def leaf_item(geometry: Geometry, at: int, count: int, k: int) -> LeafItem:
    """Return item k of the leaf of `count` items at floats[at:]."""
    who = whole(geometry.floats[at + WHO * count + k])
    return LeafItem(who & 7, leaf_index(geometry, at, count, k), who >> 3, who >> 3)


@inline
def leaf_ball(geometry: Geometry, at: int, count: int, k: int) -> SphereRecord:
    """Return the ball around item k."""
    f, at = geometry.floats, at + k
    return SphereRecord(f[at], f[at + count], f[at + 2 * count], f[at + 3 * count])


@inline
def leaf_kind(geometry: Geometry, at: int, count: int, k: int) -> int:
    """Return the kind of item k."""
    return whole(geometry.floats[at + WHO * count + k]) & 7


@inline
def leaf_index(geometry: Geometry, at: int, count: int, k: int) -> int:
    """Return the number of the surface, cell, program, sheet or polygon of item k."""
    return whole(geometry.floats[at + INDEX * count + k])


@inline
def leaf_entry(geometry: Geometry, at: int, count: int, k: int) -> int:
    """Return the entry of item k."""
    return whole(geometry.floats[at + WHO * count + k]) >> 3


# Traversal
#
# The memory of a walk, its `way`, is one block of floats: the t at which a beam enters the eight boxes tested last, the
# ray as a beam, and a stack of nodes and leaves to visit.

FEW = 12
"""Most leaves of a body without a tree; a ray tests all of them."""
OWN_BEAM = 8
"""Begin of the ray's beam in `way`, behind the eight t."""
_STACK, _ROW = 24, 3
ITS_CODE, ITS_BOX, ITS_T = 0, 1, 2
"""Fields of an element of the stack: code of a node or leaf; its box, -1 for none; t at which the ray enters it."""
assert _STACK >= OWN_BEAM + BEAM


@inline
def way_size(depth: int) -> int:
    """Return the length of the block of a walk whose stack holds up to `depth` elements."""
    return _STACK + _ROW * depth


@inline
def on_stack(k: int) -> int:
    """Return the place in `way` of element k of the stack."""
    return _STACK + _ROW * k


@inline
def put_on_stack(way: Floats, k: int, code: float, box: float, t: float) -> None:
    """Write element k of the stack."""
    at = on_stack(k)
    way[at + ITS_CODE], way[at + ITS_BOX], way[at + ITS_T] = code, box, t


@inline
def reciprocal(d: float) -> float:
    """Return 1 / d, limited to `STEEPEST`: a ray along a wall of a box then lies on one side, and no 0 · inf arises."""
    # copysign keeps the side for d = -0.0 and 0.0 alike
    return 1.0 / d if abs(d) > 1.0 / STEEPEST else math.copysign(STEEPEST, d)


@inline
def put_beam(beam: Floats, at: int, ray: Ray) -> None:
    """Write the beam of a single ray to beam[at:]."""
    for axis in range(3):
        o, d = (ray.ox, ray.dx) if axis == 0 else ((ray.oy, ray.dy) if axis == 1 else (ray.oz, ray.dz))
        beam[at + LOW_O + axis], beam[at + HIGH_O + axis] = o, o
        beam[at + LOW_I + axis], beam[at + HIGH_I + axis] = reciprocal(d), reciprocal(d)
    beam[at + FIRST], beam[at + LAST] = ray.t_min, ray.t_max


@inline
def prefetch_node(geometry: Geometry, code: int) -> None:
    """Prefetch a node or leaf that the walk visits soon."""
    if code >= 0:
        # Six rows of eight floats: a line of the cache for each side of the eight boxes
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
    """Push the children of a node that a mask selects on the stack, the nearest on top; return the stack's height.

    Relies on way[:8] holding the t at which the ray enters each child.
    """
    # Only the children are sorted; older elements keep their places below
    base = top
    while bits != 0:
        i = lowest_bit(bits)
        bits &= bits - 1
        t, child = way[i], integer(geometry, table.NODE_CHILDREN, 8 * node + i)
        if child == 0:
            continue
        prefetch_node(geometry, child)
        # Insertion by t, the farthest at the bottom
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
    """Start a walk with the roots of a tree; return the height of the stack.

    Leaves of items without a box come last, so they are on top.
    """
    first, last = integer(geometry, table.TREE_ROOT, tree), integer(geometry, table.TREE_ROOT, tree + 1)
    for k in range(first, last):
        put_on_stack(way, k - first, float(integer(geometry, table.ROOTS, k)), -1.0, -math.inf)
    return last - first


@inline
def push_node(geometry: Geometry, way: Floats, node: int, beam: Floats, at: int, top: int) -> int:
    """Push the children of a node that a beam (beam[at:]) meets on the stack; return the stack's height."""
    # All eight children in one test: a node is as wide as a vector of the processor
    bits = hit_boxes(geometry.floats, node_at(geometry, node), beam, at, way)
    return push_children(geometry, way, node, bits, top)


@inline
def next_leaf(geometry: Geometry, way: Floats, beam: Floats, at: int, top: int) -> tuple[int, int, int]:
    """Continue a walk to the next leaf that a beam (beam[at:]) meets: (its code, its box or -1, height of the stack).

    Code 0 means that no leaf is left. Invariant: the stack holds every node and leaf that the beam meets and that was
    not visited, with a lower bound of the t of entry. Elements entered beyond the beam's LAST, which may have been
    shortened after they were pushed, are culled. Single rays and packets traverse this way; streams (many rays at each
    node) and frontiers (level by level) have other algorithms.
    """
    while top > 0:
        top -= 1
        here = on_stack(top)
        t = way[here + ITS_T]
        # The slack covers the rounding of t: an item at the very end of the beam must not be lost
        if t - ENTRY_SLACK * abs(t) > beam[at + LAST]:
            continue
        code = whole(way[here + ITS_CODE])
        if code < 0:
            return code, whole(way[here + ITS_BOX]), top
        top = push_node(geometry, way, code, beam, at, top)
    return whole(0), whole(-1), 0


@helper
def walk(geometry: Geometry, way: Floats, tree: int, ray: Ray, found: Ints) -> int:
    """Write the items whose boxes the ray meets within its interval to `found`, in no order; return their number.

    Conservative: the box test has slack, so it may report too many items, never too few.
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
    """`walk` for the points of a box, whose beam is at way[OWN_BEAM:] (`put_box`); return -1 for more than `most`."""
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
    """`walk` over the leaves of a program; up to `FEW` leaves are all found, as they have no tree."""
    first, end = leaves_of(geometry, program)
    if end - first > FEW:
        return walk(geometry, way, program, ray, found)
    for leaf in range(first, end):
        found[leaf - first] = leaf
    return end - first


@helper
def walk_leaves_box(geometry: Geometry, way: Floats, program: int, found: Ints, most: int) -> int:
    """`walk_box` over the leaves of a program; up to `FEW` leaves are all found."""
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
    """Write the points of a box as a beam to way[OWN_BEAM:]."""
    for axis in range(3):
        way[OWN_BEAM + LOW_O + axis] = low[0] if axis == 0 else (low[1] if axis == 1 else low[2])
        way[OWN_BEAM + HIGH_O + axis] = high[0] if axis == 0 else (high[1] if axis == 1 else high[2])
        # Directions and lengths do not matter at t = 0: the beam is the box itself
        way[OWN_BEAM + LOW_I + axis], way[OWN_BEAM + HIGH_I + axis] = 1.0, 1.0
    way[OWN_BEAM + FIRST], way[OWN_BEAM + LAST] = 0.0, 0.0


@inline
def scene_tree(geometry: Geometry) -> int:
    """Return the number of the tree over all entries."""
    return length(geometry, table.TREE_ROOT) - 2
