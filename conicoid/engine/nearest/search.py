"""Through the tree of boxes, the nearest first."""

from __future__ import annotations

import math
from typing import NamedTuple

from ...compiler.jit import helper, inline
from .. import tables as table
from ..surface.quadric import Sphere
from ..tables import Floats, Geometry, box_at, integer, node_at
from ..tree.walk import ITS_BOX, ITS_CODE, ITS_T, on_stack, push_roots, put_on_stack, scene_tree
from .bounds import box_length, outside_box
from .form import ROUNDED, length_of


class Around(NamedTuple):
    """A box around the points that are asked for; for a single one it is that point."""

    low_x: float
    low_y: float
    low_z: float
    high_x: float
    high_y: float
    high_z: float


class Found(NamedTuple):
    """The next leaf of a search: its code, 0 for none; its box, -1 for none; a lower bound of its distance."""

    code: int
    box: int
    away: float
    top: int  # the height of the stack


@inline
def begin_search(geometry: Geometry, way: Floats) -> int:
    """Start at the roots, and at what no box holds; returns the height of the stack."""
    return push_roots(geometry, way, scene_tree(geometry))


@inline
def beyond_box(floats: Floats, at: int, around: Around) -> float:
    """A lower bound of the distance from `around` to a box, whose six sides are 8 apart from floats[at]."""
    return box_length(
        outside_box(floats[at], floats[at + 24], around.low_x, around.high_x),
        outside_box(floats[at + 8], floats[at + 32], around.low_y, around.high_y),
        outside_box(floats[at + 16], floats[at + 40], around.low_z, around.high_z),
    )


@inline
def beyond_box_of(geometry: Geometry, box: int, x: float, y: float, z: float) -> float:
    """A lower bound of the distance from a point to a box of the tree; 0 for no box."""
    if box < 0:
        return 0.0
    return beyond_box(geometry.floats, box_at(geometry, box), Around(x, y, z, x, y, z))


@inline
def beyond_ball(ball: Sphere, x: float, y: float, z: float) -> float:
    """A lower bound of the distance to a ball around an entry; 0 within."""
    distance = length_of(x - ball.x, y - ball.y, z - ball.z)
    off = ROUNDED * (abs(ball.x) + abs(ball.y) + abs(ball.z) + distance)
    beyond = distance - ball.radius - off
    return beyond if beyond > 0.0 else 0.0


@helper
def next_near(geometry: Geometry, way: Floats, top: int, around: Around, limit: float) -> Found:
    """The next leaf that is not farther away than a limit.

    Relies on the stack holding all that was met and not visited, with a lower bound of its distance; keeps that. Of the
    children of a node the nearest is on top. Boxes hold those of their children, and rounding keeps order: so the
    distance that is told is the largest of all boxes that hold the leaf.
    """
    while top > 0:
        top -= 1
        here = on_stack(top)
        if way[here + ITS_T] > limit:
            continue
        code = int(way[here + ITS_CODE])
        if code < 0:
            return Found(code, int(way[here + ITS_BOX]), max(0.0, way[here + ITS_T]), top)
        base, at = top, node_at(geometry, code)
        for i in range(8):
            child = integer(geometry, table.NODE_CHILDREN, 8 * code + i)
            if child == 0:
                continue
            distance = beyond_box(geometry.floats, at + i, around)
            if distance > limit or distance == math.inf:
                continue
            slot = top
            while slot > base and way[on_stack(slot - 1) + ITS_T] < distance:
                before = on_stack(slot - 1)
                put_on_stack(way, slot, way[before], way[before + 1], way[before + 2])
                slot -= 1
            put_on_stack(way, slot, float(child), float(8 * code + i), distance)
            top += 1
    return Found(0, -1, 0.0, 0)
