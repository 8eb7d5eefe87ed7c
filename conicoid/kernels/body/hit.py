"""The first hit of a ray: its fields, the rule for the nearer of two hits, and the test of a single ray with an entry.

`nearer_hit` is the one place that decides ties and their doubt; every route calls it, or its parts.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..._jit.decorators import helper, inline
from .. import tables as table
from ..bvh.culling_constants import END, END_LEAST
from ..bvh.walk import LeafItem
from ..ray import Ray, line_of, with_limits
from ..surface.interval import (
    Nearness,
    counts_in,
    is_too_far,
    lengths_of_ball,
    limits_of_ray,
    may_pass_start,
    nearness_of,
)
from ..surface.quadric import QuadricRoots, SphereRecord, sphere_roots
from ..tables import BALL, CELL, Geometry, whole
from .boolean import read_crossing, surface_of
from .cell import NO_PLACE, cell_spans, end_of
from .entry import crossing_face, entry_crossings, entry_nearness
from .scratch import Scratch

DOUBTFUL = 32
"""Added to the turn (`turn_of`) of a hit or miss that rounding might have changed."""


class Hit(NamedTuple):
    """A crossing with a body, or a miss: t = inf and ids -1. `crossing_face` computes its surface, face and side."""

    t: float
    body: Any  # int64, as the next three
    entry: Any
    place: Any  # of the face, see body/cell.py
    sense: Any  # of the leaf to which the face belongs: -1 where its complement counts
    enters: Any  # bool: against the body's outward normal
    off: float  # error bound of t
    unsure: Any  # bool: rounding might have changed the answer


class ResolvedHit(NamedTuple):
    """A crossing as queries report it; t = inf and ids -1 for a miss."""

    t: float
    body: Any  # int64, as the others
    surface: Any
    face: Any
    side: Any  # -1 where the surface's own normal points into the body, else 1


@inline
def no_hit() -> Hit:
    """Return a miss."""
    # One type for all ids: Numba would compile a second version of every caller for other integers
    nothing = np.int64(-1)
    return Hit(math.inf, nothing, nothing, nothing, np.int64(1), False, 0.0, False)


@inline
def doubt_hit(hit: Hit, unsure: bool) -> Hit:
    """Return the hit, doubtful also where `unsure`; a hit never becomes certain again."""
    return Hit(hit.t, hit.body, hit.entry, hit.place, hit.sense, hit.enters, hit.off, hit.unsure | unsure)


@inline
def scale_hit(hit: Hit, scale: float) -> Hit:
    """Return the hit for a direction that is shorter by the factor `scale`: t and its error bound times `scale`."""
    return Hit(hit.t * scale, hit.body, hit.entry, hit.place, hit.sense, hit.enters, hit.off * scale, hit.unsure)


@inline
def cull_limit(hit: Hit) -> float:
    """Return the t beyond which no crossing can be nearer, despite rounding: culling may cut the ray off there."""
    return hit.t + hit.off


@inline
def comes_first(t: float, body: int, other_t: float, other_body: int) -> bool:
    """True if the first of two crossings is the nearer one; at equal t the crossing of the body listed first counts.

    A miss has t = inf with any body: it never comes before another miss, whose body is -1.
    """
    return (t < other_t) | ((t == other_t) & (body < other_body))


@inline
def may_tie(t: float, off: float, other_t: float, other_off: float) -> bool:
    """True if rounding might have changed which of two crossings is the nearer."""
    return abs(t - other_t) <= off + other_off


@inline
def nearer_hit(geometry: Geometry, best: Hit, new: Hit) -> Hit:
    """Return the nearer of two hits, by `comes_first`.

    The result is doubtful where rounding might have changed which hit is nearer, except where both have the same t and
    lie on the same surface: their exact t are then equal as well. The result does not depend on the order of
    comparisons, so that routes that traverse differently agree.
    """
    unsure = best.unsure | new.unsure
    if may_tie(new.t, new.off, best.t, best.off):
        # The surfaces are looked up only for near ties, since that reads tables
        unsure |= new.t != best.t or hit_surface(geometry, new) != hit_surface(geometry, best)
    if comes_first(new.t, new.body, best.t, best.body):
        return doubt_hit(new, unsure)
    # A miss may be in doubt as well: an exact ray might hit here, nearer than `best`
    return doubt_hit(best, unsure)


@inline
def hit_surface(geometry: Geometry, hit: Hit) -> int:
    """Return the surface of a hit."""
    return crossing_face(geometry, hit.entry, hit.place, hit.sense)[0]


@inline
def resolve_hit(geometry: Geometry, hit: Hit) -> ResolvedHit:
    """Return a hit with its surface, face and side."""
    if hit.entry < 0:
        return ResolvedHit(hit.t, hit.body, hit.entry, hit.entry, hit.sense)
    surface, face, side = crossing_face(geometry, hit.entry, hit.place, hit.sense)
    return ResolvedHit(hit.t, hit.body, surface, face, side)


@inline
def is_doubtful(turn: Any) -> Any:
    """True if rounding might have changed the hit with this turn; also for arrays of turns."""
    # Without doubt |turn| <= 2, with doubt turn >= DOUBTFUL - 2
    return turn > DOUBTFUL // 2


@inline
def turn_of(hit: Hit) -> Any:
    """Return sense, entering and doubt of a hit in one small integer: the sense, doubled if entered, + DOUBTFUL."""
    return (2 * hit.sense if hit.enters else hit.sense) + (DOUBTFUL if hit.unsure else 0)


# A ball on a ray


@inline
def ball_event(
    roots: QuadricRoots, starts: bool, t_min: float, t_max: float, nearness: Nearness
) -> tuple[float, bool, bool]:
    """Return (t of the first crossing of a ball within the interval, entered there, doubtful); t = inf for none.

    It has no branches, so that single rays, the lanes of packets and the pairs of streams all call it. Relies on
    roots.low < roots.high where the ray crosses. `doubtful` is set wherever rounding, within `nearness`, might change t
    from one root to the other or to inf.
    """
    low, high, _, crosses, unsure = roots
    enters = crosses & counts_in(low, starts, t_min, t_max)
    leaves = crosses & counts_in(high, starts, t_min, t_max)
    near = may_pass_start(low, starts, t_min, nearness.off) | may_pass_start(high, starts, t_min, nearness.off)
    t = low if enters else (high if leaves else math.inf)
    return t, enters, unsure | (crosses & near) | (nearness.far < 0.0)


# A single ray against one entry, by the cheapest route for its kind
#
# Every function takes the best hit so far and returns the better one, so that `best` stays the first crossing, by
# `nearer_hit`, of all entries tested.


@inline
def try_ball(geometry: Geometry, item: LeafItem, sphere: SphereRecord, ray: Ray, inverse: float, best: Hit) -> Hit:
    """`try_entry` for a ball."""
    # The index of a ball is its surface
    starts = item.index == ray.start
    nearness = limits_of_ray(ray, inverse, lengths_of_ball(sphere))
    roots = sphere_roots(sphere, line_of(ray), inverse, starts)
    t, enters, unsure = ball_event(roots, starts, ray.t_min, ray.t_max, nearness)
    if not t < math.inf:
        return doubt_hit(best, unsure)
    return nearer_hit(
        geometry, best, Hit(t, item.body, item.entry, whole(NO_PLACE), whole(1), enters, nearness.off, unsure)
    )


@inline
def try_cell(geometry: Geometry, item: LeafItem, ray: Ray, inverse: float, best: Hit) -> Hit:
    """`try_entry` for a cell."""
    found = cell_spans(geometry, item.index, ray, inverse)
    unsure = found.unsure
    if found.number == 0:
        return doubt_hit(best, unsure)
    nearness = nearness_of(geometry, table.CELL_LIMITS, item.index, ray, inverse)
    for end in range(2 * found.number):
        t, place = end_of(found, end)
        starts = surface_of(geometry, place, t) == ray.start
        unsure |= may_pass_start(t, starts, ray.t_min, nearness.off)
        if counts_in(t, starts, ray.t_min, ray.t_max):
            unsure |= is_too_far(t, nearness)
            enters = end == 0 or end == 2
            hit = Hit(t, item.body, item.entry, place, whole(1), enters, nearness.off, unsure)
            return nearer_hit(geometry, best, hit)
    return doubt_hit(best, unsure)


@helper
def try_entry(geometry: Geometry, scratch: Scratch, entry: int, ray: Ray, best: Hit) -> Hit:
    """Return the better of `best` and the first crossing of an entry; at equal t the body listed first counts.

    The interval is cut off a little beyond `cull_limit(best)`: a crossing farther away cannot be nearer, one up to
    there may still make the order doubtful.
    """
    # `END` makes up for the rounding of the sum
    limit = min(ray.t_max, cull_limit(best) + abs(best.t) * END + END_LEAST)
    ray = with_limits(ray, ray.t_min, limit)
    nearness = entry_nearness(geometry, entry, ray)
    count, _, unsure = entry_crossings(geometry, scratch, entry, ray, 1)
    if count == 0:
        return doubt_hit(best, unsure)
    t, place, sense, enters = read_crossing(scratch, 0)
    body = whole(entry)
    return nearer_hit(geometry, best, Hit(t, body, entry, place, sense, enters, nearness.off, unsure))


@inline
def intersect_item(
    geometry: Geometry, scratch: Scratch, item: LeafItem, sphere: SphereRecord, ray: Ray, inverse: float, best: Hit
) -> Hit:
    """`try_entry` for an item of a leaf, by the cheapest route for its kind.

    `sphere` is the ball around the item in the leaf; for an item that is a ball it is the exact one, not a bound.
    """
    if item.kind == BALL:
        return try_ball(geometry, item, sphere, ray, inverse, best)
    if item.kind == CELL:
        return try_cell(geometry, item, ray, inverse, best)
    return try_entry(geometry, scratch, item.entry, ray, best)
