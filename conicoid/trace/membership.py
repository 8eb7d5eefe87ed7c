"""Is a point inside? Leaves are closed, Boolean combinations exact."""

from __future__ import annotations

import math

from ..geometry.cell import load_plane, load_quadric, load_sphere
from ..geometry.plane import plane_on_ray
from ..geometry.program import root_value, turn_leaf
from ..geometry.quadric import quadric_value
from ..geometry.tables import BALL, CELL, REGION, SPHERE, Floats, Geometry, Ints
from ..jit import helper, inline, kernel
from .events import Scratch, new_scratch
from .kernels import collect


@inline
def ball_holds(geometry: Geometry, surface: int, x: float, y: float, z: float) -> bool:
    cx, cy, cz, r = load_sphere(geometry, geometry.surface_row[surface])
    px, py, pz = x - cx, y - cy, z - cz
    return px * px + py * py + pz * pz <= r * r


@helper
def cell_holds(geometry: Geometry, cell: int, x: float, y: float, z: float) -> bool:
    """Is the point on the inner side of every face, or on it?"""
    for slot in range(geometry.cell_first[cell], geometry.cell_first[cell + 1]):
        plane = load_plane(geometry, geometry.surface_row[geometry.plane_surface[slot]])
        height, _ = plane_on_ray(plane, x, y, z, plane[0], plane[1], plane[2])
        if height * geometry.plane_side[slot] > 0.0:
            return False
    quadric = geometry.cell_quadric[cell]
    if quadric < 0:
        return True
    side = geometry.cell_side[cell]
    if geometry.surface_kind[quadric] == SPHERE:
        cx, cy, cz, r = load_sphere(geometry, geometry.surface_row[quadric])
        px, py, pz = x - cx, y - cy, z - cz
        return side * (px * px + py * py + pz * pz - r * r) <= 0.0
    return side * quadric_value(load_quadric(geometry, geometry.surface_row[quadric]), x, y, z) <= 0.0


@helper
def entry_holds(geometry: Geometry, scratch: Scratch, entry: int, x: float, y: float, z: float) -> bool:
    """Does an entry's body contain the point?"""
    kind, index = geometry.entry_kind[entry], geometry.entry_index[entry]
    if kind == BALL:
        return ball_holds(geometry, index, x, y, z)
    if kind == CELL:
        return cell_holds(geometry, index, x, y, z)
    if kind != REGION:
        return False
    held = 0
    for leaf in range(geometry.program_leaf[index], geometry.program_leaf[index + 1]):
        if cell_holds(geometry, geometry.leaf_cell[leaf], x, y, z):
            turn_leaf(geometry, scratch.counts, leaf, True)
            scratch.leaf[held] = leaf
            held += 1
    inside = root_value(geometry, scratch.counts, index)
    for k in range(held):
        turn_leaf(geometry, scratch.counts, scratch.leaf[k], False)
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
                bodies[i] = geometry.entry_body[entry]
                break
