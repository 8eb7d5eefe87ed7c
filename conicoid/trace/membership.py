"""Is a point inside? Leaves are closed, Boolean combinations exact."""

from __future__ import annotations

import math

from ..geometry import tables as table
from ..geometry.cell import load_plane, load_quadric, load_sphere
from ..geometry.plane import plane_on_ray
from ..geometry.program import root_value, turn_leaf
from ..geometry.quadric import quadric_value
from ..geometry.tables import BALL, CELL, REGION, SPHERE, Floats, Geometry, Ints, integer
from ..jit import helper, inline, kernel
from .events import leaves_met
from .kernels import collect
from .scratch import Scratch, new_scratch


@inline
def ball_holds(geometry: Geometry, surface: int, x: float, y: float, z: float) -> bool:
    cx, cy, cz, r = load_sphere(geometry, integer(geometry, table.SURFACE_ROW, surface))
    px, py, pz = x - cx, y - cy, z - cz
    return px * px + py * py + pz * pz <= r * r


@helper
def cell_holds(geometry: Geometry, cell: int, x: float, y: float, z: float) -> bool:
    """Is the point on the inner side of every face, or on it?"""
    for slot in range(integer(geometry, table.CELL_FIRST, cell), integer(geometry, table.CELL_FIRST, cell + 1)):
        plane = load_plane(geometry, integer(geometry, table.SURFACE_ROW, integer(geometry, table.PLANE_SURFACE, slot)))
        height, _, _ = plane_on_ray(plane, x, y, z, plane[0], plane[1], plane[2])
        if height * integer(geometry, table.PLANE_SIDE, slot) > 0.0:
            return False
    quadric = integer(geometry, table.CELL_QUADRIC, cell)
    if quadric < 0:
        return True
    side = integer(geometry, table.CELL_SIDE, cell)
    if integer(geometry, table.SURFACE_KIND, quadric) == SPHERE:
        cx, cy, cz, r = load_sphere(geometry, integer(geometry, table.SURFACE_ROW, quadric))
        px, py, pz = x - cx, y - cy, z - cz
        return side * (px * px + py * py + pz * pz - r * r) <= 0.0
    return side * quadric_value(load_quadric(geometry, integer(geometry, table.SURFACE_ROW, quadric)), x, y, z) <= 0.0


@helper
def entry_holds(geometry: Geometry, scratch: Scratch, entry: int, x: float, y: float, z: float) -> bool:
    """Does an entry's body contain the point?"""
    kind, index = integer(geometry, table.ENTRY_KIND, entry), integer(geometry, table.ENTRY_INDEX, entry)
    if kind == BALL:
        return ball_holds(geometry, index, x, y, z)
    if kind == CELL:
        return cell_holds(geometry, index, x, y, z)
    if kind != REGION:
        return False
    held = 0
    for k in range(leaves_met(geometry, scratch, index, (x, y, z, 1.0, 1.0, 1.0, 0.0, 0.0, -1))):
        leaf = scratch.found_leaves[k]
        if cell_holds(geometry, integer(geometry, table.LEAF_CELL, leaf), x, y, z):
            turn_leaf(geometry, scratch.counts, leaf, True)
            scratch.event_leaf[held] = leaf
            held += 1
    inside = root_value(geometry, scratch.counts, index)
    for k in range(held):
        turn_leaf(geometry, scratch.counts, scratch.event_leaf[k], False)
    return inside


@kernel
def locate(geometry: Geometry, points: Floats, begin: int, end: int, bodies: Ints) -> None:
    """bodies[i] = the lowest-numbered body that contains points[i], or -1."""
    scratch = new_scratch(geometry)
    for i in range(begin, end):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        bodies[i] = -1
        if not (math.isfinite(x) and math.isfinite(y) and math.isfinite(z)):
            continue
        for k in range(collect(geometry, scratch, (x, y, z, 1.0, 1.0, 1.0, 0.0, 0.0, -1))):
            entry = scratch.found[k]
            if entry_holds(geometry, scratch, entry, x, y, z):
                bodies[i] = integer(geometry, table.ENTRY_BODY, entry)
                break
