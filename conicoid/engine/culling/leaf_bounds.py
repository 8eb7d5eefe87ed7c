"""Boxes around the leaves of a program: programs that are one another moved have those of the first."""

from __future__ import annotations

from typing import Any, NamedTuple

from ...compiler.jit import inline
from .. import tables as table
from ..programs import first_leaf
from ..tables import BOUNDS_SIZE, SHIFT_SIZE, Geometry, integer, length


class LeafBounds(NamedTuple):
    """Where in the floats the boxes of a program's leaves begin, and what is to be added to them."""

    at: Any
    x: float
    y: float
    z: float


@inline
def leaf_bounds(geometry: Geometry, program: int) -> LeafBounds:
    """The boxes of the leaves of a program."""
    f, places, first = geometry.floats, geometry.places, first_leaf(geometry, program)
    x, y, z = 0.0, 0.0, 0.0
    if length(geometry, table.PROGRAM_SHIFTS) > 0:
        shifts, at = places[table.SHIFTS], SHIFT_SIZE * program
        x = f[shifts + integer(geometry, table.PROGRAM_SHIFTS, at)]
        y = f[shifts + integer(geometry, table.PROGRAM_SHIFTS, at + 1)]
        z = f[shifts + integer(geometry, table.PROGRAM_SHIFTS, at + 2)]
    return LeafBounds(places[table.LEAF_BOUNDS] + BOUNDS_SIZE * first, x, y, z)


@inline
def leaf_low(geometry: Geometry, bounds: LeafBounds, number: int, axis: int) -> float:
    """Where along an axis the box of one of the leaves begins; numbers count from 0."""
    shift = bounds.x if axis == 0 else (bounds.y if axis == 1 else bounds.z)
    return geometry.floats[bounds.at + BOUNDS_SIZE * number + axis] + shift


@inline
def leaf_high(geometry: Geometry, bounds: LeafBounds, number: int, axis: int) -> float:
    """Where it ends."""
    shift = bounds.x if axis == 0 else (bounds.y if axis == 1 else bounds.z)
    return geometry.floats[bounds.at + BOUNDS_SIZE * number + axis + 3] + shift
