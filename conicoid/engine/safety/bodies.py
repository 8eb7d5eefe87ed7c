"""Bounds of the distances from 64 points to the walls of an entry: cells, Boolean bodies, sheets, balls."""

from __future__ import annotations

import math

import numpy as np

from ...compiler.jit import helper, inline
from .. import tables as table
from ..culling.leaf_bounds import LeafBounds, leaf_bounds
from ..faces import cell_side, plane_side
from ..nearest.bounds import leaf_box
from ..packets.booleans import MOST
from ..packets.lanes import LANES
from ..programs import cell_of_leaf, gates_of, leaves_of, root_of, rows_of_leaves
from ..tables import CELL as CELLS
from ..tables import REGION, SHEET, Floats, Geometry, integer
from .rows import BEST, BOUND, CELL, EVERY, FACE, GATES, LEAF, X, Y, Z
from .surfaces import surface_of_lanes


@inline
def _largest(room: Floats, side: float) -> None:
    """Each lane's FACE into its CELL, if that is larger."""
    for i in range(EVERY):
        room[CELL + i] = max(room[CELL + i], side * room[FACE + i])


@helper
def cell_of_lanes(geometry: Geometry, cell: int, room: Floats) -> None:
    """CELL: signed bounds of the distances to the walls of a cell, negative inside."""
    quadric = integer(geometry, table.CELL_QUADRIC, cell)
    for i in range(EVERY):
        room[CELL + i] = -math.inf
    for slot in range(integer(geometry, table.CELL_FIRST, cell), integer(geometry, table.CELL_FIRST, cell + 1)):
        surface_of_lanes(geometry, integer(geometry, table.PLANE_SURFACE, slot), room)
        _largest(room, float(plane_side(geometry, slot)))
    if quadric >= 0:
        surface_of_lanes(geometry, quadric, room)
        _largest(room, float(cell_side(geometry, cell)))


@inline
def _feed(room: Floats, row: int, gate: int, sign: float, least: bool) -> None:
    """The inputs from a row into those of a gate: unions keep the least, intersections the largest."""
    source, target = np.uint64(row), np.uint64(GATES + gate * LANES)
    if least:
        for i in range(EVERY):
            room[target + i] = min(room[target + i], sign * room[source + i])
    else:
        for i in range(EVERY):
            room[target + i] = max(room[target + i], sign * room[source + i])


@helper
def _leaf_of_lanes(geometry: Geometry, bounds: LeafBounds, first: int, leaf: int, room: Floats) -> None:
    """CELL: signed bounds of a leaf of a program, whose first it tells, within its box by its cell."""
    near = 0
    for i in range(EVERY):
        away = leaf_box(geometry, bounds, leaf - first, room[X + i], room[Y + i], room[Z + i])
        room[LEAF + i] = away
        near += 1 if away < room[BEST + i] else 0
    if near > 0:
        cell_of_lanes(geometry, cell_of_leaf(geometry, leaf), room)
        for i in range(EVERY):
            inner, away = room[CELL + i], room[LEAF + i]
            room[CELL + i] = max(away, inner) if away > 0.0 else inner
    else:
        for i in range(EVERY):
            room[CELL + i] = room[LEAF + i]


@helper
def program_of_lanes(geometry: Geometry, program: int, room: Floats) -> None:
    """The root's row of GATES: signed bounds of the distances to the walls of a region, as `program_bound` says."""
    first, last = gates_of(geometry, program)
    for gate in range(first, last):
        none = math.inf if integer(geometry, table.GATE_NEED, gate) == 1 else -math.inf
        target = np.uint64(GATES + (gate - first) * LANES)
        for i in range(EVERY):
            room[target + i] = none
    bounds, row = leaf_bounds(geometry, program), rows_of_leaves(geometry, program)
    begin, end = leaves_of(geometry, program)
    for leaf in range(begin, end):
        _leaf_of_lanes(geometry, bounds, begin, leaf, room)
        gate = integer(geometry, table.LEAF_GATE, leaf + row)
        negated = integer(geometry, table.LEAF_NEGATED, leaf + row) == 1
        least = integer(geometry, table.GATE_NEED, gate) == 1
        _feed(room, int(CELL), gate - first, -1.0 if negated else 1.0, least)
    for gate in range(last - 1, first, -1):
        parent, negated = integer(geometry, table.GATE_PARENT, gate), integer(geometry, table.GATE_NEGATED, gate) == 1
        least = integer(geometry, table.GATE_NEED, parent) == 1
        _feed(room, GATES + (gate - first) * LANES, parent - first, -1.0 if negated else 1.0, least)


@inline
def fits_lanes(geometry: Geometry, kind: int, index: int) -> bool:
    """May an entry be asked about in lanes? Not a polygon, nor a body of very many parts."""
    program = index if kind == REGION else -1
    if kind == SHEET:
        program = integer(geometry, table.SHEET_PROGRAM, index)
    if program < 0:
        return kind != table.POLYGON
    gates, leaves = gates_of(geometry, program), leaves_of(geometry, program)
    return gates[1] - gates[0] <= MOST and leaves[1] - leaves[0] <= MOST


@helper
def entry_of_lanes(geometry: Geometry, kind: int, index: int, room: Floats) -> None:
    """BOUND: lower bounds of the distances to the walls of an entry that `fits_lanes`, as `entry_bound` says."""
    if kind == CELLS:
        cell_of_lanes(geometry, index, room)
        for i in range(EVERY):
            room[BOUND + i] = abs(room[CELL + i])
    elif kind == REGION:
        program_of_lanes(geometry, index, room)
        for i in range(EVERY):
            room[BOUND + i] = abs(room[GATES + i])
    elif kind == SHEET:
        _sheet_of_lanes(geometry, index, room)
    else:  # a ball
        surface_of_lanes(geometry, index, room)
        for i in range(EVERY):
            room[BOUND + i] = abs(room[FACE + i])


@helper
def _sheet_of_lanes(geometry: Geometry, sheet: int, room: Floats) -> None:
    """BOUND of a sheet: it is on its surface, and where what clips it allows."""
    program = integer(geometry, table.SHEET_PROGRAM, sheet)
    for i in range(EVERY):
        room[GATES + i] = -math.inf
    if program >= 0:
        program_of_lanes(geometry, program, room)
        turned = integer(geometry, table.GATE_NEGATED, root_of(geometry, program)) == 1
        for i in range(EVERY):
            room[GATES + i] = -room[GATES + i] if turned else room[GATES + i]
    surface_of_lanes(geometry, integer(geometry, table.SHEET_SURFACE, sheet), room)
    for i in range(EVERY):
        room[BOUND + i] = max(abs(room[FACE + i]), room[GATES + i])
