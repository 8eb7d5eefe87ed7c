"""A single ray against one entry of the scene's tree: its first crossing, by the cheapest route for its kind.

Every function takes the best hit so far and returns the better one, so that it keeps `best` the first crossing, by
`hit.nearer`, of all entries tested.
"""

from __future__ import annotations

import math

from ...compiler.jit import helper, inline
from .. import tables as table
from ..culling.slack import END, END_LEAST
from ..ray import Ray, line_of, with_limits
from ..surface.interval import at_start, counts_in
from ..surface.nearness import along, beyond, lengths_of_ball, nearness_of
from ..surface.quadric import Sphere, sphere_roots
from ..tables import BALL, CELL, Geometry, whole
from ..tree.leaf import Item
from .ball import ball_event
from .boolean import crossing, surface_of
from .cell import NO_PLACE, cell_spans, end_of
from .entry import entry_crossings, entry_nearness
from .hit import Hit, doubted, nearer, within
from .scratch import Scratch


@inline
def try_ball(geometry: Geometry, item: Item, sphere: Sphere, ray: Ray, inverse: float, best: Hit) -> Hit:
    """`try_entry` for a ball."""
    starts = item.index == ray.start
    nearness = along(ray, inverse, lengths_of_ball(sphere))
    roots = sphere_roots(sphere, line_of(ray), inverse, starts)
    t, enters, unsure = ball_event(roots, starts, ray.t_min, ray.t_max, nearness)
    if not t < math.inf:
        return doubted(best, unsure)
    return nearer(
        geometry, best, Hit(t, item.body, item.entry, whole(NO_PLACE), whole(1), enters, nearness.off, unsure)
    )


@inline
def try_cell(geometry: Geometry, item: Item, ray: Ray, inverse: float, best: Hit) -> Hit:
    """`try_entry` for a cell."""
    found = cell_spans(geometry, item.index, ray, inverse)
    unsure = found.unsure
    if found.number == 0:
        return doubted(best, unsure)
    nearness = nearness_of(geometry, table.CELL_LIMITS, item.index, ray, inverse)
    for end in range(2 * found.number):
        t, place = end_of(found, end)
        starts = surface_of(geometry, place, t) == ray.start
        unsure |= at_start(t, starts, ray.t_min, nearness.off)
        if counts_in(t, starts, ray.t_min, ray.t_max):
            unsure |= beyond(t, nearness)
            enters = end == 0 or end == 2
            hit = Hit(t, item.body, item.entry, place, whole(1), enters, nearness.off, unsure)
            return nearer(geometry, best, hit)
    return doubted(best, unsure)


@helper
def try_entry(geometry: Geometry, scratch: Scratch, entry: int, ray: Ray, best: Hit) -> Hit:
    """The better of `best` and the first crossing of an entry; equal t goes to the body listed first.

    The interval is cut off a little beyond `within(best)`: a crossing farther away cannot be nearer, one up to there
    may still make the order doubtful.
    """
    limit = min(ray.t_max, within(best) + abs(best.t) * END + END_LEAST)
    ray = with_limits(ray, ray.t_min, limit)
    nearness = entry_nearness(geometry, entry, ray)
    count, _, unsure = entry_crossings(geometry, scratch, entry, ray, 1)
    if count == 0:
        return doubted(best, unsure)
    t, place, sense, enters = crossing(scratch, 0)
    body = whole(entry)
    return nearer(geometry, best, Hit(t, body, entry, place, sense, enters, nearness.off, unsure))


@inline
def meet(geometry: Geometry, scratch: Scratch, item: Item, sphere: Sphere, ray: Ray, inverse: float, best: Hit) -> Hit:
    """`try_entry` for an item of a leaf with a ball around it, by the cheapest route for its kind.

    For an item that is a ball, `sphere` is the exact one, not a bound.
    """
    if item.kind == BALL:
        return try_ball(geometry, item, sphere, ray, inverse, best)
    if item.kind == CELL:
        return try_cell(geometry, item, ray, inverse, best)
    return try_entry(geometry, scratch, item.entry, ray, best)
