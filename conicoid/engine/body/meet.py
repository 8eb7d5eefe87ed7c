"""What a single ray meets of one entry of the scene's tree first, by the shortest way for its kind."""

from __future__ import annotations

from ...compiler.jit import helper, inline
from .. import tables as table
from ..ray import Ray
from ..surface.nearness import along, at_start, beyond, lengths_of_ball, nearness_of
from ..surface.quadric import Sphere, sphere_roots
from ..tables import BALL, CELL, Geometry, integer, whole
from ..tree.leaf import Item
from .boolean import counts_in, crossing, surface_of
from .cell import NO_PLACE, cell_spans
from .entry import entry_crossings, entry_nearness
from .hit import Hit, certain, nearer, within
from .scratch import Scratch


@inline
def try_ball(geometry: Geometry, item: Item, sphere: Sphere, ray: Ray, inverse: float, best: Hit) -> Hit:
    """`try_entry` for a ball."""
    ox, oy, oz, dx, dy, dz, _, _, start = ray
    _, surface, body, entry = item
    low, high, _, crosses, unsure = sphere_roots(sphere, ox, oy, oz, dx, dy, dz, inverse, surface == start)
    nearness = along(ray, inverse, lengths_of_ball(sphere[0], sphere[1], sphere[2], sphere[3]))
    unsure |= nearness[1] < 0.0
    if not crosses:
        return certain(best, best[6], best[7] | unsure)
    unsure |= at_start(low, surface == ray[8], ray[6], nearness[0]) | at_start(
        high, surface == ray[8], ray[6], nearness[0]
    )
    enters = counts_in(low, surface, ray)
    t = low if enters else high
    if enters or counts_in(high, surface, ray):
        return nearer(geometry, best, (t, body, entry, whole(NO_PLACE), whole(1), enters, nearness[0], unsure))
    return certain(best, best[6], best[7] | unsure)


@inline
def try_cell(geometry: Geometry, item: Item, ray: Ray, inverse: float, best: Hit) -> Hit:
    """`try_entry` for a cell."""
    _, cell, body, entry = item
    spans, in1, out1, a1, b1, in2, out2, a2, b2, unsure = cell_spans(geometry, cell, ray, inverse)
    if spans == 0:
        return certain(best, best[6], best[7] | unsure)
    nearness = nearness_of(geometry, table.CELL_LIMITS, cell, ray, inverse)
    for end in range(2 * spans):
        t, place = (in1, a1) if end == 0 else ((out1, b1) if end == 1 else ((in2, a2) if end == 2 else (out2, b2)))
        surface = surface_of(geometry, place, t)
        unsure |= at_start(t, surface == ray[8], ray[6], nearness[0])
        if counts_in(t, surface, ray):
            unsure |= beyond(t, nearness)
            hit = (t, body, entry, place, whole(1), end == 0 or end == 2, nearness[0], unsure)
            return nearer(geometry, best, hit)
    return certain(best, best[6], best[7] | unsure)


@helper
def try_entry(geometry: Geometry, scratch: Scratch, entry: int, ray: Ray, best: Hit) -> Hit:
    """The better of `best` and the first crossing of an entry; equal t goes to the body listed first."""
    ox, oy, oz, dx, dy, dz, t_min, t_max, start = ray
    limit = min(t_max, within(best) + abs(best[0]) * 1e-15 + 1e-300)
    ray = (ox, oy, oz, dx, dy, dz, t_min, limit, start)
    nearness = entry_nearness(geometry, entry, ray)
    count, _, unsure = entry_crossings(geometry, scratch, entry, ray, 1)
    if count == 0:
        return certain(best, best[6], best[7] | unsure)
    t, place, sense, enters = crossing(scratch, 0)
    body = integer(geometry, table.ENTRY_BODY, entry)
    hit = (t, body, entry, place, sense, enters, nearness[0], unsure)
    return nearer(geometry, best, hit)


@inline
def meet(geometry: Geometry, scratch: Scratch, item: Item, sphere: Sphere, ray: Ray, inverse: float, best: Hit) -> Hit:
    """`try_entry` for an item of a leaf with a ball around it, by the shortest way for its kind."""
    if item[0] == BALL:
        return try_ball(geometry, item, sphere, ray, inverse, best)
    if item[0] == CELL:
        return try_cell(geometry, item, ray, inverse, best)
    return try_entry(geometry, scratch, item[3], ray, best)
