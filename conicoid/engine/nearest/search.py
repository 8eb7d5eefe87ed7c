"""Through the tree of boxes, the nearest first."""

from __future__ import annotations

import math

from ...compiler.jit import helper, inline
from .. import tables as table
from ..tables import Floats, Geometry, integer, node_at
from ..tree.walk import ITS_CODE, ITS_T, on_stack, push_roots, put_on_stack, scene_tree
from .bounds import box_length, outside_box


@inline
def begin_search(geometry: Geometry, way: Floats) -> int:
    """Start at the roots, and at what no box holds; returns the height of the stack."""
    return push_roots(geometry, way, scene_tree(geometry))


@helper
def next_near(geometry: Geometry, way: Floats, top: int, x: float, y: float, z: float, limit: float) -> tuple[int, int]:
    """(code of the next leaf, height of the stack) of what is not farther away than a limit; code 0 for none.

    Relies on the stack holding all that was met and not visited, with a lower bound of its distance; keeps that. Of the
    children of a node the nearest is on top.
    """
    while top > 0:
        top -= 1
        here = on_stack(top)
        if way[here + ITS_T] > limit:
            continue
        code = int(way[here + ITS_CODE])
        if code < 0:
            return code, top
        base, at = top, node_at(geometry, code)
        for i in range(8):
            child, f = integer(geometry, table.NODE_CHILDREN, 8 * code + i), geometry.floats
            if child == 0:
                continue
            distance = box_length(
                outside_box(f[at + i], f[at + 24 + i], x), outside_box(f[at + 8 + i], f[at + 32 + i], y),
                outside_box(f[at + 16 + i], f[at + 40 + i], z),
            )  # fmt: skip
            if distance > limit or distance == math.inf:
                continue
            slot = top
            while slot > base and way[on_stack(slot - 1) + ITS_T] < distance:
                before = on_stack(slot - 1)
                put_on_stack(way, slot, way[before], way[before + 1], way[before + 2])
                slot -= 1
            put_on_stack(way, slot, float(child), float(8 * code + i), distance)
            top += 1
    return 0, 0
