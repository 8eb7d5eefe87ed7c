"""Memory of one thread that looks for nearest points: what is near of one body, and the best that was found."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...compiler.jit import allocator, inline
from .. import tables as table
from ..body.scratch import Scratch, new_scratch
from ..programs import cell_of_leaf, leaves_of
from ..tables import Floats, Geometry, Ints, integer, length

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


class Room(NamedTuple):
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
def new_room(geometry: Geometry) -> Room:
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
    return Room(
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
def start(room: Room, reach: float) -> None:
    """Nothing has been found yet; walls are looked for up to a distance."""
    room.best[UPPER], room.best[LOWER], room.best[REACH], room.best[NEAREST] = math.inf, math.inf, reach, math.inf
    room.best[OF_BODY] = math.inf
    room.best[AT_X], room.best[AT_Y], room.best[AT_Z] = math.nan, math.nan, math.nan
    room.who[BODY], room.who[ENTRY], room.who[PLACE], room.who[SENSE] = -1, -1, -1, 1


@inline
def limit(room: Room) -> float:
    """Walls beyond this do not matter."""
    return min(min(room.best[UPPER], room.best[REACH]), room.best[OF_BODY])
