"""The crossings of a ray with one sheet: a clipped surface, or a polygon."""

from __future__ import annotations

import math

from ...compiler.jit import helper
from .. import tables as table
from ..ray import Ray, span_inverse
from ..surface.interval import at_start, counts_in
from ..surface.loop import inside_loop
from ..surface.nearness import beyond, nearness_of
from ..surface.records import curved_roots, is_curved, plane_crossing
from ..tables import Geometry, integer
from .boolean import inside_program_at, put_crossing
from .cell import NO_PLACE
from .scratch import Scratch


@helper
def sheet_crossings(geometry: Geometry, scratch: Scratch, sheet: int, ray: Ray) -> tuple[int, bool]:
    """(crossings of a clipped surface in (t_min, t_max), doubtful). "Entered" is against the sheet's normal.

    Crossings go into scratch in order of t, by low < high; the clipping program leaves `scratch.counts` as they were.
    """
    surface, program = integer(geometry, table.SHEET_SURFACE, sheet), integer(geometry, table.SHEET_PROGRAM, sheet)
    side, one_sided = integer(geometry, table.SHEET_SIDE, sheet), integer(geometry, table.SHEET_ONE_SIDED, sheet) == 1
    low, high, falls, count, inverse = math.inf, math.inf, False, 0, span_inverse(ray)
    starts = surface == ray.start
    nearness = nearness_of(geometry, table.SHEET_LIMITS, sheet, ray, inverse)
    if is_curved(geometry, surface):
        low, high, outside, crosses, unsure = curved_roots(geometry, surface, ray, inverse)
        if not crosses:
            return 0, unsure
        falls = not outside
    else:
        low, rate, unsure = plane_crossing(geometry, surface, ray, inverse)
        if rate == 0.0:
            return 0, unsure
        falls = rate < 0.0
    unsure |= nearness.far < 0.0
    for root in range(2):
        t = low if root == 0 else high
        against = (falls != (root == 1)) == (side > 0)
        unsure |= at_start(t, starts, ray.t_min, nearness.off)
        if not counts_in(t, starts, ray.t_min, ray.t_max) or (one_sided and not against):
            continue
        unsure |= beyond(t, nearness)
        if program >= 0:
            holds, doubtful = inside_program_at(geometry, scratch, program, ray, t)
            unsure |= doubtful
            if not holds:
                continue
        put_crossing(scratch, count, t, NO_PLACE, 1, 1 if against else 0)
        count += 1
    return count, unsure


@helper
def polygon_crossings(geometry: Geometry, scratch: Scratch, polygon: int, ray: Ray) -> tuple[int, bool]:
    """(crossings of a polygon in (t_min, t_max): 0 or 1, doubtful)"""
    surface, program = (
        integer(geometry, table.POLYGON_SURFACE, polygon),
        integer(geometry, table.POLYGON_PROGRAM, polygon),
    )
    inverse, starts = span_inverse(ray), surface == ray.start
    nearness = nearness_of(geometry, table.POLYGON_LIMITS, polygon, ray, inverse)
    t, rate, unsure = plane_crossing(geometry, surface, ray, inverse)
    unsure |= at_start(t, starts, ray.t_min, nearness.off)
    if rate == 0.0 or not counts_in(t, starts, ray.t_min, ray.t_max):
        return 0, unsure
    first, last = (
        integer(geometry, table.POLYGON_FIRST, polygon),
        integer(geometry, table.POLYGON_FIRST, polygon + 1),
    )
    inside, doubtful = inside_loop(geometry, first, last, ray)
    unsure |= doubtful | beyond(t, nearness)
    if inside and program >= 0:
        inside, doubtful = inside_program_at(geometry, scratch, program, ray, t)
        unsure |= doubtful
    if not inside:
        return 0, unsure
    side = integer(geometry, table.POLYGON_SIDE, polygon)
    put_crossing(scratch, 0, t, NO_PLACE, 1, 1 if (rate < 0.0) == (side > 0) else 0)
    return 1, unsure
