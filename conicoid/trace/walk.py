"""Walking a tree of boxes along a ray: the scene's own over its entries, a large body's over its leaves."""

from __future__ import annotations

import math
from typing import NamedTuple

from ..geometry import tables as table
from ..geometry.tables import Floats, Geometry, Ints, Ray, integer
from ..jit import helper, inline
from .leaf import leaf_at, leaf_range
from .simd import FIRST, HIGH_I, HIGH_O, LAST, LOW_I, LOW_O, boxes_met, lowest_bit, prefetch_soon


class Stack(NamedTuple):
    """What of a tree is still to be visited."""

    code: Ints  # a node, or a leaf
    box: Ints  # its box, -1 for none
    t: Floats  # where the ray enters it


@inline
def reciprocal(d: float) -> float:
    """1 / d, finite: a direction along a wall of a box lies on one side of it."""
    return 1.0 / d if abs(d) > 1e-290 else math.copysign(1e290, d)


@inline
def put_beam(beam: Floats, ray: Ray) -> None:
    """The beam that is one ray."""
    for axis in range(3):
        o, d = (ray[0], ray[3]) if axis == 0 else ((ray[1], ray[4]) if axis == 1 else (ray[2], ray[5]))
        beam[LOW_O + axis], beam[HIGH_O + axis] = o, o
        beam[LOW_I + axis], beam[HIGH_I + axis] = reciprocal(d), reciprocal(d)
    beam[FIRST], beam[LAST] = ray[6], ray[7]


@inline
def ask_for(geometry: Geometry, code: int) -> None:
    """Ask for the memory of a node or leaf that is soon to be visited."""
    if code >= 0:
        at = geometry.places[table.NODE_BOXES, 0] + 48 * code
        for line in range(6):
            prefetch_soon(geometry.floats, at + 8 * line)
        prefetch_soon(geometry.integers, geometry.places[table.NODE_CHILDREN, 0] + 8 * code)
    else:
        first, last = leaf_range(code)
        at = leaf_at(geometry, first)
        for k in range(0, 4 * (last - first), 8):  # the balls
            prefetch_soon(geometry.floats, at + k)


@inline
def push_met(geometry: Geometry, stack: Stack, near: Floats, node: int, bits: int, top: int) -> int:
    """Put the children of a node that are told by bits on the stack, the nearest on top; returns its height."""
    base = top
    while bits != 0:
        i = lowest_bit(bits)
        bits &= bits - 1
        t, child = near[i], integer(geometry, table.NODE_CHILDREN, 8 * node + i)
        if child == 0:
            continue
        ask_for(geometry, child)
        slot = top
        while slot > base and stack.t[slot - 1] < t:
            stack.t[slot], stack.code[slot], stack.box[slot] = (
                stack.t[slot - 1],
                stack.code[slot - 1],
                stack.box[slot - 1],
            )
            slot -= 1
        stack.t[slot], stack.code[slot], stack.box[slot] = t, child, 8 * node + i
        top += 1
    return top


@inline
def push_node(geometry: Geometry, stack: Stack, near: Floats, beam: Floats, start: int, node: int, top: int) -> int:
    """Put the children of a node that a beam (from beam[start:]) meets on the stack; returns its height."""
    bits = boxes_met(geometry.floats, geometry.places[table.NODE_BOXES, 0] + 48 * node, beam, start, near)
    return push_met(geometry, stack, near, node, bits, top)


@inline
def push_roots(geometry: Geometry, stack: Stack, tree: int) -> int:
    """Start a walk: what no box holds is on top. Returns the height of the stack."""
    first, last = integer(geometry, table.TREE_ROOT, tree), integer(geometry, table.TREE_ROOT, tree + 1)
    for k in range(first, last):
        stack.code[k - first] = integer(geometry, table.ROOTS, k)
        stack.t[k - first], stack.box[k - first] = -math.inf, -1
    return last - first


@helper
def walk(geometry: Geometry, stack: Stack, near: Floats, beam: Floats, tree: int, ray: Ray, found: Ints) -> int:
    """Put everything whose box the ray meets within its interval into `found`; returns how many."""
    count = 0
    put_beam(beam, ray)
    top = push_roots(geometry, stack, tree)
    while top > 0:
        top -= 1
        code = stack.code[top]
        if code >= 0:
            top = push_node(geometry, stack, near, beam, 0, code, top)
            continue
        first, last = leaf_range(code)
        for k in range(first, last):
            found[count] = integer(geometry, table.TREE_ORDER, k)
            count += 1
    return count
