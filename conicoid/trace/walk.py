"""Walking a tree of boxes along a ray: the scene's own over its entries, a large body's over its leaves."""

from __future__ import annotations

import math

from ..geometry import tables as table
from ..geometry.tables import Floats, Geometry, Ints, Ray, integer
from ..jit import helper, inline


@inline
def reciprocal(d: float) -> float:
    """1 / d, finite: a direction along a wall of a box lies on one side of it."""
    return 1.0 / d if abs(d) > 1e-290 else math.copysign(1e290, d)


@inline
def boxes_met(
    geometry: Geometry, near: Floats, node: int, ray: Ray, ix: float, iy: float, iz: float, t_max: float
) -> None:
    """Where the ray enters each child's box, into `near`; inf where it passes by."""
    boxes, at = geometry.floats, geometry.places[table.NODE_BOXES, 0] + 48 * node
    ox, oy, oz, t_min = ray[0], ray[1], ray[2], ray[6]
    for i in range(8):
        a, b = (boxes[at + i] - ox) * ix, (boxes[at + 24 + i] - ox) * ix
        first, last = max(min(a, b), t_min), min(max(a, b), t_max)
        a, b = (boxes[at + 8 + i] - oy) * iy, (boxes[at + 32 + i] - oy) * iy
        first, last = max(min(a, b), first), min(max(a, b), last)
        a, b = (boxes[at + 16 + i] - oz) * iz, (boxes[at + 40 + i] - oz) * iz
        first, last = max(min(a, b), first), min(max(a, b), last)
        slack = (abs(first) + abs(last)) * 4e-16
        near[i] = first if first <= last + slack else math.inf


@inline
def push_children(geometry: Geometry, near: Floats, stack: Ints, stack_t: Floats, node: int, top: int) -> int:
    """Put the children that the ray meets on the stack, the nearest on top; returns its height."""
    base = top
    for i in range(8):
        t = near[i]
        child = integer(geometry, table.NODE_CHILDREN, 8 * node + i)
        if child == 0 or not t < math.inf:
            continue
        slot = top
        while slot > base and stack_t[slot - 1] < t:
            stack_t[slot] = stack_t[slot - 1]
            stack[slot] = stack[slot - 1]
            slot -= 1
        stack_t[slot] = t
        stack[slot] = child
        top += 1
    return top


@inline
def push_roots(geometry: Geometry, stack: Ints, stack_t: Floats, tree: int) -> int:
    """Start a walk: what no box holds is on top. Returns the height of the stack."""
    first, last = integer(geometry, table.TREE_ROOT, tree), integer(geometry, table.TREE_ROOT, tree + 1)
    for k in range(first, last):
        stack[k - first] = integer(geometry, table.ROOTS, k)
        stack_t[k - first] = -math.inf
    return last - first


@inline
def leaf_range(code: int) -> tuple[int, int]:
    """(first, last) places in `tree_order` of a leaf."""
    first, count = (-code - 1) >> 4, (-code - 1) & 15
    return first, first + count


@helper
def walk(geometry: Geometry, near: Floats, stack: Ints, stack_t: Floats, tree: int, ray: Ray, found: Ints) -> int:
    """Put everything whose box the ray meets within its interval into `found`; returns how many."""
    count = 0
    ix, iy, iz = reciprocal(ray[3]), reciprocal(ray[4]), reciprocal(ray[5])
    top = push_roots(geometry, stack, stack_t, tree)
    while top > 0:
        top -= 1
        code = stack[top]
        if code >= 0:
            boxes_met(geometry, near, code, ray, ix, iy, iz, ray[7])
            top = push_children(geometry, near, stack, stack_t, code, top)
            continue
        first, last = leaf_range(code)
        for k in range(first, last):
            found[count] = integer(geometry, table.TREE_ORDER, k)
            count += 1
    return count
