"""Planes of cells met by the lanes of a packet (see cells.py)."""

from __future__ import annotations

from typing import Any

from ...compiler.jit import choose, helper, inline
from .. import tables as table
from ..body.spans import clip_slab
from ..faces import plane_side
from ..ray import Line
from ..surface.nearness import Nearness
from ..surface.plane import Plane, PlaneLimits, careful_plane, plain_plane, runs_along, unsure_of_plane
from ..surface.records import load_plane, plane_limits
from ..tables import Floats, Geometry, integer
from .lanes import (
    FLAG,
    INVERSE,
    OWN,
    OX,
    OY,
    OZ,
    SHARED,
    SOME_START,
    START,
    UNSURE,
    A,
    B,
    eights,
    lane_line,
    lane_line_from,
    lane_nearness,
    lane_slab,
    put_slab,
)  # fmt: skip


@helper
def _cut_lanes(lanes: Floats, lengths: Nearness, surface: int, inner: bool, place: int, first: int, last: int) -> None:
    """Cut the slabs by a plane whose height and rate are in A and B; FLAG 2: rounding may have changed them too much.

    UNSURE becomes 1 where it may have changed the order of two planes, 2 where it may have changed more.
    """
    first, last = eights(first, last)
    for i in range(first, last):
        cut_lane(lanes, i, lengths, surface, inner, place)


@inline
def cut_lane(lanes: Floats, i: Any, lengths: Nearness, surface: Any, inner: bool, place: int) -> None:
    """`_cut_lanes` for a lane."""
    height = 0.0 if lanes[START + i] == surface else lanes[A + i]
    off = lane_nearness(lanes, i, lengths).off
    slab, close = clip_slab(lane_slab(lanes, i), height, lanes[B + i], inner, float(place), off)
    put_slab(lanes, i, slab)
    unsure = max(lanes[UNSURE + i], choose(close, 1.0, 0.0))
    lanes[UNSURE + i] = choose(lanes[FLAG + i] == 2.0, 2.0, unsure)


@inline
def plane_of_lane(lanes: Floats, i: int, line: Line, plane: Plane, limits: PlaneLimits) -> int:
    """A lane's height and rate into A and B; returns 1, as FLAG, where they are to be done again with care."""
    height, rate, cancels, parallel = plain_plane(plane, line)
    cancels |= unsure_of_plane(height, rate, parallel, lanes[INVERSE + i], limits)
    lanes[A + i], lanes[B + i] = height, rate
    lanes[FLAG + i] = 1.0 if cancels else 0.0
    return 1 if cancels else 0


@inline
def put_careful_plane(lanes: Floats, i: Any, plane: Plane, limits: PlaneLimits) -> None:
    """A lane's height and rate again, with care; FLAG 2 where rounding may still have changed them too much."""
    line = lane_line(lanes, i)
    height, rate = careful_plane(plane, line)
    unsure = unsure_of_plane(height, rate, runs_along(plane, line), lanes[INVERSE + i], limits)
    lanes[A + i], lanes[B + i], lanes[FLAG + i] = height, rate, 2.0 if unsure else 1.0


@inline
def plane_lanes(geometry: Geometry, lanes: Floats, lengths: Nearness, place: int, first: int, last: int) -> None:
    """Cut the lanes' slabs by the plane of a place; `lengths` are the limits of its cell."""
    surface = integer(geometry, table.PLANE_SURFACE, place)
    row, inner = integer(geometry, table.SURFACE_ROW, surface), plane_side(geometry, place) > 0
    plane, limits = load_plane(geometry, row), plane_limits(geometry, row)
    again, x, y, z = 0, lanes[OX], lanes[OY], lanes[OZ]
    if lanes[SHARED] != 0.0:
        for i in range(first, last):
            again += plane_of_lane(lanes, i, lane_line_from(lanes, i, x, y, z), plane, limits)
    else:
        for i in range(first, last):
            again += plane_of_lane(lanes, i, lane_line(lanes, i), plane, limits)
    if again > 0:
        for i in range(first, last):
            if lanes[FLAG + i] == 1.0:
                put_careful_plane(lanes, i, plane, limits)
    _cut_lanes(lanes, lengths, surface, inner, place, first, last)
    if lanes[SOME_START] != 0.0:
        for i in range(first, last):
            lanes[OWN + i] = choose(lanes[START + i] == surface, 1.0, lanes[OWN + i])
