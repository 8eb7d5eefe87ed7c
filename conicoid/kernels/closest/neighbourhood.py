"""The neighbourhood of a point: one body's surfaces and leaves within the search radius, and the best wall so far.

`gather_cell` and `gather_program` collect the surfaces that come near and the leaves that they bound; these are all
that may matter within the radius.
"""

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
"""Most boxes of space on the stack of a search."""
MOST_PAIRED = 32
"""Near surfaces with a flag for each pair in `hard`; pairs of further surfaces count as hard."""
BOX = 5
"""Numbers of a box: its middle, half of its side, a lower bound of the distance to it."""

UPPER, LOWER, AT_X, AT_Y, AT_Z, REACH, NEAREST, OF_BODY = 0, 1, 2, 3, 4, 5, 6, 7
"""Elements of `Neighbourhood.best`: upper and lower bound of the nearest wall's distance; the point of the best proved
wall; the search radius; the distance of that point; the distance beyond which the current body has no walls."""
BODY, ENTRY, PLACE, SENSE = 0, 1, 2, 3
"""Elements of `Neighbourhood.who`: the body, entry, place and sense of the best wall."""
SURFACES, LEAVES, LINKS, PROGRAM, SHEET_OF, WITHIN = 0, 1, 2, 3, 4, 5
"""Elements of `Neighbourhood.sizes`: numbers of near surfaces, of near leaves and of their links; the program or -1; 1
for a sheet; 1 + the polygon in which points must lie, or 0."""
LEAF, CELL_OF, FIRST_LINK, LINK_COUNT = 0, 1, 2, 3
"""Elements of `Neighbourhood.leaves`, four a leaf; the leaf is -1 if the body is a single cell."""


class Neighbourhood(NamedTuple):
    """The near surfaces and leaves of a body, against which walls.py tests candidate points; memory of one thread."""

    scratch: Scratch
    gates: Floats
    surface: Ints  # near surfaces by number, planes first; of a sheet its own surface is the first
    bound: Floats  # a lower bound of the distance to each
    sign: Ints  # at a candidate: -1, 1, or 0 where it lies on the surface or may do so
    leaves: Ints  # near leaves, see `LEAF`
    links: Ints  # (near surface, its inner side), of the leaves one after the other
    chosen: Ints  # of a candidate: the surfaces on which it lies, by their places in `surface`
    sizes: Ints  # see `SURFACES`
    hard: Ints  # (MOST_PAIRED²,) 1 where the curve of two near surfaces is in no plane
    best: Floats  # see `UPPER`
    who: Ints  # see `BODY`
    boxes: Floats  # a stack of boxes, see `BOX`


@allocator
def new_room(geometry: Geometry) -> Neighbourhood:
    """Return memory for one thread, sized for the largest body of the scene."""
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
    """Start a search for walls up to the distance `reach`."""
    room.best[UPPER], room.best[LOWER], room.best[REACH], room.best[NEAREST] = math.inf, math.inf, reach, math.inf
    room.best[OF_BODY] = math.inf
    room.best[AT_X], room.best[AT_Y], room.best[AT_Z] = math.nan, math.nan, math.nan
    room.who[BODY], room.who[ENTRY], room.who[PLACE], room.who[SENSE] = -1, -1, -1, 1


@inline
def limit(room: Neighbourhood) -> float:
    """Return the distance beyond which walls do not matter."""
    return min(min(room.best[UPPER], room.best[REACH]), room.best[OF_BODY])


# Gathering the surfaces of a body that come near, and the leaves that they bound


@inline
def _near(room: Neighbourhood, surface: int, bound: float) -> int:
    """Return the place of a surface among the near ones; append it if it is not there."""
    count = room.sizes[SURFACES]
    for k in range(count):
        if room.surface[k] == surface:
            return k
    room.surface[count], room.bound[count] = surface, bound
    room.sizes[SURFACES] = count + 1
    return count


@inline
def _link(geometry: Geometry, room: Neighbourhood, surface: int, inner: int, x: float, y: float, z: float) -> bool:
    """Link a leaf to one of its surfaces if that is near; False if the whole search ball is on its outer side."""
    bound = surface_bound(geometry, surface, x, y, z, limit(room)) * inner
    if abs(bound) > limit(room):
        return bound < 0.0
    k = room.sizes[LINKS]
    room.links[2 * k], room.links[2 * k + 1] = _near(room, surface, abs(bound)), inner
    room.sizes[LINKS] = k + 1
    return True


@helper
def gather_cell(geometry: Geometry, room: Neighbourhood, leaf: int, cell: int, x: float, y: float, z: float) -> None:
    """Append a leaf to the near ones, unless the whole search ball is outside of it."""
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
    """Gather the near leaves of a region, or of the program that clips a sheet."""
    bounds, (first, end) = leaf_bounds(geometry, program), leaves_of(geometry, program)
    for leaf in range(first, end):
        if not leaf_box(geometry, bounds, leaf - first, x, y, z) > limit(room):
            gather_cell(geometry, room, leaf, cell_of_leaf(geometry, leaf), x, y, z)


@inline
def begin_body(room: Neighbourhood, program: int, sheet: int) -> None:
    """Start a body without near surfaces; the own surface of a sheet, if any, becomes the first."""
    room.sizes[SURFACES], room.sizes[LEAVES], room.sizes[LINKS], room.best[OF_BODY] = 0, 0, 0, math.inf
    room.sizes[PROGRAM], room.sizes[SHEET_OF], room.sizes[WITHIN] = program, (1 if sheet >= 0 else 0), 0
    if sheet >= 0:
        _near(room, sheet, 0.0)


@helper
def planes_first(geometry: Geometry, room: Neighbourhood) -> None:
    """Sort the near surfaces: the own one of a sheet, planes, others; within these groups the nearest first."""
    first = room.sizes[SHEET_OF]
    for i in range(first + 1, room.sizes[SURFACES]):
        j = i
        while j > first and _comes_before(geometry, room, j, j - 1):
            _swap(room, j, j - 1)
            j -= 1


@inline
def is_flat(geometry: Geometry, room: Neighbourhood, k: int) -> bool:
    """True if a near surface is a plane."""
    return integer(geometry, table.SURFACE_KIND, room.surface[k]) == PLANE


@inline
def _comes_before(geometry: Geometry, room: Neighbourhood, i: int, j: int) -> bool:
    flat, other = is_flat(geometry, room, i), is_flat(geometry, room, j)
    return (flat and not other) or (flat == other and room.bound[i] < room.bound[j])


@helper
def _swap(room: Neighbourhood, i: int, j: int) -> None:
    """Exchange two near surfaces, and update the links to them."""
    room.surface[i], room.surface[j] = room.surface[j], room.surface[i]
    room.bound[i], room.bound[j] = room.bound[j], room.bound[i]
    for k in range(room.sizes[LINKS]):
        if room.links[2 * k] == i:
            room.links[2 * k] = j
        elif room.links[2 * k] == j:
            room.links[2 * k] = i
