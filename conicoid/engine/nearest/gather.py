"""What of a body may matter within a ball: its surfaces that come near, and the leaves that they bound."""

from __future__ import annotations

import math

from ...compiler.jit import helper, inline
from .. import tables as table
from ..culling.leaf_bounds import leaf_bounds
from ..faces import cell_side, plane_side
from ..programs import cell_of_leaf, leaves_of
from ..tables import PLANE, Geometry, integer
from .bounds import leaf_box, surface_bound
from .room import (
    CELL_OF,
    FIRST_LINK,
    LEAF,
    LEAVES,
    LINK_COUNT,
    LINKS,
    OF_BODY,
    PROGRAM,
    SHEET_OF,
    SURFACES,
    WITHIN,
    Room,
    limit,
)


@inline
def _near(room: Room, surface: int, bound: float) -> int:
    """The place of a surface among the near ones, where it is put if it is not there."""
    count = room.sizes[SURFACES]
    for k in range(count):
        if room.surface[k] == surface:
            return k
    room.surface[count], room.bound[count] = surface, bound
    room.sizes[SURFACES] = count + 1
    return count


@inline
def _link(geometry: Geometry, room: Room, surface: int, inner: int, x: float, y: float, z: float) -> bool:
    """Link a leaf to one of its surfaces if that is near; False where the whole ball is on its outer side."""
    bound = surface_bound(geometry, surface, x, y, z, limit(room)) * inner
    if abs(bound) > limit(room):
        return bound < 0.0
    k = room.sizes[LINKS]
    room.links[2 * k], room.links[2 * k + 1] = _near(room, surface, abs(bound)), inner
    room.sizes[LINKS] = k + 1
    return True


@helper
def gather_cell(geometry: Geometry, room: Room, leaf: int, cell: int, x: float, y: float, z: float) -> None:
    """Put a leaf among the near ones, unless the whole ball is outside of it."""
    before, first, quadric = room.sizes[SURFACES], room.sizes[LINKS], integer(geometry, table.CELL_QUADRIC, cell)
    alive = True
    for slot in range(integer(geometry, table.CELL_FIRST, cell), integer(geometry, table.CELL_FIRST, cell + 1)):
        surface, side = integer(geometry, table.PLANE_SURFACE, slot), plane_side(geometry, slot)
        alive = alive and _link(geometry, room, surface, side, x, y, z)
    if alive and quadric >= 0:
        alive = _link(geometry, room, quadric, cell_side(geometry, cell), x, y, z)
    if not alive:
        room.sizes[SURFACES], room.sizes[LINKS] = before, first
        return
    at = 4 * room.sizes[LEAVES]
    room.leaves[at + LEAF], room.leaves[at + CELL_OF] = leaf, cell
    room.leaves[at + FIRST_LINK], room.leaves[at + LINK_COUNT] = first, room.sizes[LINKS] - first
    room.sizes[LEAVES] += 1


@helper
def gather_program(geometry: Geometry, room: Room, program: int, x: float, y: float, z: float) -> None:
    """The near leaves of a region, or of what clips a sheet."""
    bounds, (first, end) = leaf_bounds(geometry, program), leaves_of(geometry, program)
    for leaf in range(first, end):
        if not leaf_box(geometry, bounds, leaf - first, x, y, z) > limit(room):
            gather_cell(geometry, room, leaf, cell_of_leaf(geometry, leaf), x, y, z)


@inline
def begin_body(room: Room, program: int, sheet: int) -> None:
    """Nothing of a body is near yet; a sheet's own surface becomes the first."""
    room.sizes[SURFACES], room.sizes[LEAVES], room.sizes[LINKS], room.best[OF_BODY] = 0, 0, 0, math.inf
    room.sizes[PROGRAM], room.sizes[SHEET_OF], room.sizes[WITHIN] = program, (1 if sheet >= 0 else 0), 0
    if sheet >= 0:
        _near(room, sheet, 0.0)


@helper
def planes_first(geometry: Geometry, room: Room) -> None:
    """Sort the near surfaces: that of a sheet, planes, others; among these the nearest first."""
    first = room.sizes[SHEET_OF]
    for i in range(first + 1, room.sizes[SURFACES]):
        j = i
        while j > first and _comes_before(geometry, room, j, j - 1):
            _swap(room, j, j - 1)
            j -= 1


@inline
def is_flat(geometry: Geometry, room: Room, k: int) -> bool:
    """Is a near surface a plane?"""
    return integer(geometry, table.SURFACE_KIND, room.surface[k]) == PLANE


@inline
def _comes_before(geometry: Geometry, room: Room, i: int, j: int) -> bool:
    flat, other = is_flat(geometry, room, i), is_flat(geometry, room, j)
    return (flat and not other) or (flat == other and room.bound[i] < room.bound[j])


@helper
def _swap(room: Room, i: int, j: int) -> None:
    """Exchange two near surfaces, and what links to them."""
    room.surface[i], room.surface[j] = room.surface[j], room.surface[i]
    room.bound[i], room.bound[j] = room.bound[j], room.bound[i]
    for k in range(room.sizes[LINKS]):
        if room.links[2 * k] == i:
            room.links[2 * k] = j
        elif room.links[2 * k] == j:
            room.links[2 * k] = i
