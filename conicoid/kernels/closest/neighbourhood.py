"""Memory of one thread that looks for nearest points: what is near of one body, and the best that was found."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..._jit.decorators import allocator, helper, inline
from .. import tables as table
from ..body.scratch import Scratch, new_scratch
from ..faces import cell_side, plane_side
from ..programs import cell_of_leaf, leaf_bounds, leaves_of
from ..tables import PLANE, Floats, Geometry, Ints, integer, length
from .bounds import leaf_box, surface_bound

MOST_BOXES = 4096
"""Boxes of space that wait to be looked through."""
MOST_PAIRED = 32
"""So many near surfaces have a note about each pair; pairs of others count as hard."""
BOX = 5
"""Numbers of a box: its middle, half of its side, a lower bound of the distance to it."""

UPPER, LOWER, AT_X, AT_Y, AT_Z, REACH, NEAREST, OF_BODY = 0, 1, 2, 3, 4, 5, 6, 7
"""Of `Room.best`: no more than the nearest wall's distance is; no less; the point of the best wall that is proved; how
far walls are looked for; the distance of that point; beyond which the body that is looked at has no walls."""
BODY, ENTRY, PLACE, SENSE = 0, 1, 2, 3
"""Of `Room.who`: whose wall the best is."""
SURFACES, LEAVES, LINKS, PROGRAM, SHEET_OF, WITHIN = 0, 1, 2, 3, 4, 5
"""Of `Room.sizes`: near surfaces, near leaves, their links, the program or -1, 1 for a sheet, 1 + a polygon
that its points are to be in."""
LEAF, CELL_OF, FIRST_LINK, LINK_COUNT = 0, 1, 2, 3
"""Of `Room.leaves`, four numbers a leaf; its number is -1 where a body is one cell alone."""


class Neighbourhood(NamedTuple):
    """Where `gather` puts what of a body is near, for `walls` to try candidates on."""

    scratch: Scratch
    gates: Floats
    surface: Ints  # near surfaces by number, planes first; of a sheet its own is the first of all
    bound: Floats  # a lower bound of the distance to each
    sign: Ints  # at a candidate: -1, 1, or 0 where it is on the surface or may be
    leaves: Ints  # near leaves
    links: Ints  # (near surface, its inner side), of the leaves one after the other
    chosen: Ints  # of a candidate: the surfaces that it lies on, by their places in `surface`
    sizes: Ints
    hard: Ints  # (MOST_PAIRED²,) 1 where the curve of two near surfaces is in no plane
    best: Floats
    who: Ints
    boxes: Floats


@allocator
def new_room(geometry: Geometry) -> Neighbourhood:
    """Room for one thread."""
    gates, leaves, links = geometry.places[table.GATES], 1, 8
    for program in range(length(geometry, table.PROGRAM_LEAF) - 1):
        first, last = leaves_of(geometry, program)
        leaves = max(leaves, last - first)
        here = 0
        for leaf in range(first, last):
            cell = cell_of_leaf(geometry, leaf)
            here += 2 + integer(geometry, table.CELL_FIRST, cell + 1) - integer(geometry, table.CELL_FIRST, cell)
        links = max(links, here)
    for cell in range(length(geometry, table.CELL_QUADRIC)):
        links = max(
            links, 2 + integer(geometry, table.CELL_FIRST, cell + 1) - integer(geometry, table.CELL_FIRST, cell)
        )
    return Neighbourhood(
        new_scratch(geometry),
        np.empty(gates),
        np.empty(links + 1, np.int32),
        np.empty(links + 1),
        np.empty(links + 1, np.int32),
        np.empty(4 * leaves, np.int32),
        np.empty(2 * links, np.int32),
        np.empty(links + 1, np.int32),
        np.zeros(8, np.int32),
        np.zeros(MOST_PAIRED * MOST_PAIRED, np.int32),
        np.empty(8),
        np.empty(4, np.int32),
        np.empty(BOX * MOST_BOXES),
    )


@inline
def reset_nearest(room: Neighbourhood, reach: float) -> None:
    """Nothing has been found yet; walls are looked for up to a distance."""
    room.best[UPPER], room.best[LOWER], room.best[REACH], room.best[NEAREST] = math.inf, math.inf, reach, math.inf
    room.best[OF_BODY] = math.inf
    room.best[AT_X], room.best[AT_Y], room.best[AT_Z] = math.nan, math.nan, math.nan
    room.who[BODY], room.who[ENTRY], room.who[PLACE], room.who[SENSE] = -1, -1, -1, 1


@inline
def limit(room: Neighbourhood) -> float:
    """Walls beyond this do not matter."""
    return min(min(room.best[UPPER], room.best[REACH]), room.best[OF_BODY])


# What of a body may matter within a ball: its surfaces that come near, and the leaves that they bound.


@inline
def _near(room: Neighbourhood, surface: int, bound: float) -> int:
    """The place of a surface among the near ones, where it is put if it is not there."""
    count = room.sizes[SURFACES]
    for k in range(count):
        if room.surface[k] == surface:
            return k
    room.surface[count], room.bound[count] = surface, bound
    room.sizes[SURFACES] = count + 1
    return count


@inline
def _link(geometry: Geometry, room: Neighbourhood, surface: int, inner: int, x: float, y: float, z: float) -> bool:
    """Link a leaf to one of its surfaces if that is near; False where the whole ball is on its outer side."""
    bound = surface_bound(geometry, surface, x, y, z, limit(room)) * inner
    if abs(bound) > limit(room):
        return bound < 0.0
    k = room.sizes[LINKS]
    room.links[2 * k], room.links[2 * k + 1] = _near(room, surface, abs(bound)), inner
    room.sizes[LINKS] = k + 1
    return True


@helper
def gather_cell(geometry: Geometry, room: Neighbourhood, leaf: int, cell: int, x: float, y: float, z: float) -> None:
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
def gather_program(geometry: Geometry, room: Neighbourhood, program: int, x: float, y: float, z: float) -> None:
    """The near leaves of a region, or of what clips a sheet."""
    bounds, (first, end) = leaf_bounds(geometry, program), leaves_of(geometry, program)
    for leaf in range(first, end):
        if not leaf_box(geometry, bounds, leaf - first, x, y, z) > limit(room):
            gather_cell(geometry, room, leaf, cell_of_leaf(geometry, leaf), x, y, z)


@inline
def begin_body(room: Neighbourhood, program: int, sheet: int) -> None:
    """Nothing of a body is near yet; a sheet's own surface becomes the first."""
    room.sizes[SURFACES], room.sizes[LEAVES], room.sizes[LINKS], room.best[OF_BODY] = 0, 0, 0, math.inf
    room.sizes[PROGRAM], room.sizes[SHEET_OF], room.sizes[WITHIN] = program, (1 if sheet >= 0 else 0), 0
    if sheet >= 0:
        _near(room, sheet, 0.0)


@helper
def planes_first(geometry: Geometry, room: Neighbourhood) -> None:
    """Sort the near surfaces: that of a sheet, planes, others; among these the nearest first."""
    first = room.sizes[SHEET_OF]
    for i in range(first + 1, room.sizes[SURFACES]):
        j = i
        while j > first and _comes_before(geometry, room, j, j - 1):
            _swap(room, j, j - 1)
            j -= 1


@inline
def is_flat(geometry: Geometry, room: Neighbourhood, k: int) -> bool:
    """Is a near surface a plane?"""
    return integer(geometry, table.SURFACE_KIND, room.surface[k]) == PLANE


@inline
def _comes_before(geometry: Geometry, room: Neighbourhood, i: int, j: int) -> bool:
    flat, other = is_flat(geometry, room, i), is_flat(geometry, room, j)
    return (flat and not other) or (flat == other and room.bound[i] < room.bound[j])


@helper
def _swap(room: Neighbourhood, i: int, j: int) -> None:
    """Exchange two near surfaces, and what links to them."""
    room.surface[i], room.surface[j] = room.surface[j], room.surface[i]
    room.bound[i], room.bound[j] = room.bound[j], room.bound[i]
    for k in range(room.sizes[LINKS]):
        if room.links[2 * k] == i:
            room.links[2 * k] = j
        elif room.links[2 * k] == j:
            room.links[2 * k] = i
