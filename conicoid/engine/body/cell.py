"""A cell on a ray: at most two spans, each end with the face it lies on.

A face is told by its place: a row in the table of the cells' planes, or `quadric_place` of a cell, or
`NO_PLACE` for an end at infinity.
"""

from __future__ import annotations

import math
from typing import TypeAlias

from ...compiler.jit import helper, inline
from .. import tables as table
from ..ray import Ray
from ..surface.nearness import Nearness, beyond, near, nearness_of
from ..surface.records import curved_roots, plane_crossing
from ..tables import Geometry, integer

NO_PLACE = -1

Spans: TypeAlias = tuple[int, float, float, int, int, float, float, int, int, bool]
"""count, then t_in, t_out, place_in, place_out of each; might rounding change any of that within the interval?"""


@inline
def quadric_place(cell: int) -> int:
    """The place of a cell's curved face."""
    return -2 - cell


@inline
def slab_span(
    geometry: Geometry, cell: int, ray: Ray, inverse: float, nearness: Nearness
) -> tuple[float, float, int, int, bool, bool]:
    """The span inside all planes of a cell; t_in >= t_out where there is none.

    Then: might rounding change it, and is it unknown where, as the ray runs along a plane?

    A ray within a plane counts as if the plane stood an infinitesimal further along its normal.
    """
    t_in, t_out, place_in, place_out, unsure, lost = -math.inf, math.inf, NO_PLACE, NO_PLACE, False, False
    for slot in range(integer(geometry, table.CELL_FIRST, cell), integer(geometry, table.CELL_FIRST, cell + 1)):
        t, height, rate, doubtful = plane_crossing(geometry, integer(geometry, table.PLANE_SURFACE, slot), ray, inverse)
        side = integer(geometry, table.PLANE_SIDE, slot)
        lost |= doubtful
        if rate == 0.0:
            if (height <= 0.0) != (side > 0):
                return math.inf, -math.inf, NO_PLACE, NO_PLACE, unsure, lost
        elif (rate < 0.0) == (side > 0):
            unsure |= near(t, t_in, nearness)
            if t > t_in:
                t_in, place_in = t, slot
        else:
            unsure |= near(t, t_out, nearness)
            if t < t_out:
                t_out, place_out = t, slot
    return t_in, t_out, place_in, place_out, unsure | near(t_in, t_out, nearness), lost


@inline
def _matters(t_in: float, t_out: float, ray: Ray, nearness: Nearness) -> bool:
    """May a stretch that rounding might change lie within the ray's interval?"""
    begins = (t_in < ray[7]) | near(t_in, ray[7], nearness)
    ends = (t_out > ray[6]) | near(t_out, ray[6], nearness)
    return begins & ends & ((t_in < t_out) | near(t_in, t_out, nearness))


@helper
def cell_spans(geometry: Geometry, cell: int, ray: Ray, inverse: float) -> Spans:
    """The spans of a ray inside a cell, in order; contacts of zero length are none."""
    nearness = nearness_of(geometry, table.CELL_LIMITS, cell, ray, inverse)
    t_in, t_out, place_in, place_out, unsure, lost = slab_span(geometry, cell, ray, inverse, nearness)
    second = (math.inf, -math.inf, NO_PLACE, NO_PLACE)
    matters = _matters(t_in, t_out, ray, nearness)
    unsure = (unsure & matters) | lost | (nearness[1] < 0.0)
    if not t_in < t_out:
        return 0, t_in, t_out, place_in, place_out, *second, unsure
    quadric, curved = integer(geometry, table.CELL_QUADRIC, cell), quadric_place(cell)
    if quadric < 0:
        return 1, t_in, t_out, place_in, place_out, *second, unsure
    low, high, outside, crosses, doubtful = curved_roots(geometry, quadric, ray, inverse)
    outside = outside != (integer(geometry, table.CELL_SIDE, cell) < 0)
    if not crosses:
        return (1 if outside else 0), t_in, t_out, place_in, place_out, *second, unsure | (doubtful & matters)
    close = near(low, t_in, nearness) | near(low, t_out, nearness)
    close |= near(high, t_in, nearness) | near(high, t_out, nearness)
    close |= beyond(low, nearness) | beyond(high, nearness)  # on which side, then, is not certain either
    unsure |= (doubtful | close) & matters
    if not outside:
        in_slot = curved if low >= t_in else place_in
        out_slot = curved if high <= t_out else place_out
        t_in, t_out = max(low, t_in), min(high, t_out)
        return (1 if t_in < t_out else 0), t_in, t_out, in_slot, out_slot, *second, unsure
    # Outside of ]low, high[: what is left of it and what is right of it
    out_slot = curved if low <= t_out else place_out
    in_slot = curved if high >= t_in else place_in
    first_out, second_in = min(low, t_out), max(high, t_in)
    if second_in < t_out:
        if t_in < first_out:
            return 2, t_in, first_out, place_in, out_slot, second_in, t_out, in_slot, place_out, unsure
        return 1, second_in, t_out, in_slot, place_out, *second, unsure
    return (1 if t_in < first_out else 0), t_in, first_out, place_in, out_slot, *second, unsure


@inline
def place_face(geometry: Geometry, place: int) -> tuple[int, int, int]:
    """(surface, face number, side) of a place; side +1 where the surface's gradient points out of the cell."""
    if place < 0:
        cell = -2 - place
        return (
            integer(geometry, table.CELL_QUADRIC, cell),
            integer(geometry, table.CELL_FACE, cell),
            integer(geometry, table.CELL_SIDE, cell),
        )
    return (
        integer(geometry, table.PLANE_SURFACE, place),
        integer(geometry, table.PLANE_FACE, place),
        integer(geometry, table.PLANE_SIDE, place),
    )
