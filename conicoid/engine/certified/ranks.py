"""A doubtful ray as a problem of order alone.

Which bodies a ray meets depends on the order of its crossings with surfaces alone. So a ray that rounding may
have got wrong is decided in two steps. First every crossing is found with certainty and gets its rank: 0, 1, 2
along the ray, equal where crossings coincide. Then the surfaces are replaced by simple ones which a ray along the
x axis crosses at x = the rank, exactly, in floats: a sphere from rank 3 to 8 has its center at 5.5. The
functions of `engine/body` trace these as they trace any ray, so every rule is written in one place.

Ranks come from numbers with error bounds (engine/surface/decide.py) or, where those leave it open, from exact
arithmetic (conicoid.exact).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ...compiler.jit import helper, inline
from ...compiler.shapes import shaped
from .. import tables as table
from ..body.boolean import leaves_met
from ..body.entry import collect
from ..body.scratch import Scratch
from ..numbers.sort import sorting_by
from ..numbers.sure import Sure
from ..programs import cell_of_leaf
from ..ray import Ray
from ..surface.decide import CROSSES, OPEN, Rest, decide_curved, decide_plane
from ..surface.decide_loop import decide_loop
from ..surface.doubt import ALIKE
from ..surface.records import curved_roots, is_curved, plane_crossing
from ..tables import BALL, CELL, POLYGON, REGION, Floats, Geometry, Ints, Longs, Signs, integer

SURFACES, CROSSINGS = 0, 1
"""Of `Ranks.size`: how many of either there are."""
FREE = -1
"""In place of a surface: the ray's origin."""


@shaped(
    surfaces="surface_kind", listed="surface_kind", verdict="2*surface_kind", first="surface_kind",
    high="2*surface_kind+8", low="2*surface_kind+8", error="2*surface_kind+8", owner="2*surface_kind+8",
    t="2*surface_kind+8", order="2*surface_kind+8", rank="2*surface_kind+8", loops="polygon_surface", size="2",
)  # fmt: skip
class Ranks(NamedTuple):
    """Memory for one ray's crossings. Large arrays are empty until used, and take no memory before."""

    surfaces: Ints  # (surfaces,) those that the ray may meet
    listed: Ints  # (surfaces,) 1 for those
    verdict: Ints  # (2 surfaces,) of each: CROSSES or MISSES, and the sign that goes with it
    first: Ints  # (surfaces,) where its crossings begin in the lists below
    high: Floats  # (2 surfaces + 8,) crossings: where, to 30 digits
    low: Floats
    error: Floats
    owner: Ints  # the surface
    t: Floats  # what is reported as its t
    order: Ints
    rank: Floats
    loops: Ints  # (polygons,) 1: the ray passes within the polygon's outline
    size: Longs  # (2,) see `SURFACES`


class Room(NamedTuple):
    """Memory of one thread that decides rays."""

    rest: Rest  # what rounding took from the records of surfaces
    stand: Geometry  # the scene with simple surfaces in place of its own, see stand_ins.py
    ranks: Ranks


@shaped(which="m", still="m")
class Doubtful(NamedTuple):
    """Rays to be decided."""

    which: Ints  # their numbers
    still: Signs  # set to 1 where it takes exact arithmetic


@inline
def _put(ranks: Ranks, place: Sure, owner: int) -> None:
    """Append a crossing; the reported t is the certain one until `tell_as_usual`."""
    k = ranks.size[CROSSINGS]
    ranks.high[k], ranks.low[k], ranks.error[k] = place.high, place.low, place.error
    ranks.owner[k], ranks.t[k] = owner, place.high
    ranks.size[CROSSINGS] = k + 1


@inline
def _list(ranks: Ranks, surface: int) -> None:
    """List a surface, once."""
    if surface >= 0 and ranks.listed[surface] == 0:
        ranks.listed[surface] = 1
        ranks.surfaces[ranks.size[SURFACES]] = surface
        ranks.size[SURFACES] += 1


@inline
def _list_cell(geometry: Geometry, ranks: Ranks, cell: int) -> None:
    """List the surfaces of a cell."""
    _list(ranks, integer(geometry, table.CELL_QUADRIC, cell))
    for slot in range(integer(geometry, table.CELL_FIRST, cell), integer(geometry, table.CELL_FIRST, cell + 1)):
        _list(ranks, integer(geometry, table.PLANE_SURFACE, slot))


@inline
def entry_program(geometry: Geometry, entry: int) -> int:
    """The program of an entry: of a region, or what clips a sheet; -1 for none."""
    kind, index = integer(geometry, table.ENTRY_KIND, entry), integer(geometry, table.ENTRY_INDEX, entry)
    if kind == REGION:
        return index
    if kind <= CELL:
        return -1
    return integer(geometry, table.POLYGON_PROGRAM if kind == POLYGON else table.SHEET_PROGRAM, index)


@helper
def list_surfaces(geometry: Geometry, scratch: Scratch, ranks: Ranks, ray: Ray, count: int) -> None:
    """Every surface of the entries scratch.found[:count] that matters along the ray."""
    ranks.size[SURFACES] = 0
    for k in range(count):
        entry = scratch.found[k]
        kind, index = integer(geometry, table.ENTRY_KIND, entry), integer(geometry, table.ENTRY_INDEX, entry)
        if kind == BALL:
            _list(ranks, index)
        elif kind == CELL:
            _list_cell(geometry, ranks, index)
        elif kind != REGION:
            of = table.POLYGON_SURFACE if kind == POLYGON else table.SHEET_SURFACE
            _list(ranks, integer(geometry, of, index))
        program = entry_program(geometry, entry)
        if program >= 0:
            for j in range(leaves_met(geometry, scratch, program, ray)):
                _list_cell(geometry, ranks, cell_of_leaf(geometry, scratch.found_leaves[j]))


@inline
def forget(ranks: Ranks) -> None:
    """Clear `listed` for another ray; the other lists are overwritten."""
    for k in range(ranks.size[SURFACES]):
        ranks.listed[ranks.surfaces[k]] = 0
    ranks.size[SURFACES] = 0


@helper
def _decide_surface(geometry: Geometry, rest: Rest, ranks: Ranks, surface: int, ray: Ray, inverse: float) -> bool:
    """The crossings of a surface into the list; False if they are open."""
    starts = surface == ray.start
    if is_curved(geometry, surface):
        verdict, sense, low, high = decide_curved(geometry, rest, surface, ray, starts)
    else:
        verdict, sense, low, high = decide_plane(geometry, rest, surface, ray, starts)
    ranks.verdict[2 * surface], ranks.verdict[2 * surface + 1] = verdict, sense
    if verdict == OPEN:
        return False
    if verdict == CROSSES:
        ranks.first[surface] = ranks.size[CROSSINGS]
        _put(ranks, low, surface)
        _put(ranks, high, surface)
        tell_as_usual(geometry, ranks, surface, ray, inverse)
    return True


@inline
def tell_as_usual(geometry: Geometry, ranks: Ranks, surface: int, ray: Ray, inverse: float) -> None:
    """Report the t of the fast formulas where it is not doubtful: t must not depend on other crossings nearby."""
    if is_curved(geometry, surface):
        low, high, _, crosses, unsure = curved_roots(geometry, surface, ray, inverse)
        known = crosses and not unsure
    else:
        low, _, unsure = plane_crossing(geometry, surface, ray, inverse)
        known, high = not unsure, low
    if known:
        _tell_one(ranks, ranks.first[surface], low)
        _tell_one(ranks, ranks.first[surface] + 1, high)


@inline
def _tell_one(ranks: Ranks, k: int, t: float) -> None:
    """Report t, unless it is far from the certain place: across the origin, or of a root near infinity."""
    if abs(t - ranks.t[k]) <= abs(t) * ALIKE:
        ranks.t[k] = t


@inline
def _later(ranks: Ranks, i: int, j: int) -> bool:
    """Does crossing i come after crossing j, by their midpoints?"""
    return ranks.high[i] > ranks.high[j] or (ranks.high[i] == ranks.high[j] and ranks.low[i] > ranks.low[j])


_sort_places = sorting_by(_later)


@helper
def _sort(ranks: Ranks) -> None:
    """The crossings in order."""
    count, order = ranks.size[CROSSINGS], ranks.order
    for i in range(count):
        order[i] = i
    _sort_places(order, count, ranks)


@inline
def _together(ranks: Ranks, i: int, j: int) -> bool:
    """Are two crossings one: of one plane, the same number, or both infinite?"""
    if ranks.high[i] != ranks.high[j] or ranks.low[i] != ranks.low[j]:
        return False
    return ranks.error[i] + ranks.error[j] == 0.0 or (
        ranks.owner[i] == ranks.owner[j] and ranks.error[i] == ranks.error[j]
    )


@inline
def _apart(ranks: Ranks, i: int, j: int) -> bool:
    """Does crossing i certainly come before j?"""
    if ranks.high[i] == -math.inf or ranks.high[j] == math.inf:
        return ranks.high[i] != ranks.high[j]
    return (ranks.high[j] - ranks.high[i]) + (ranks.low[j] - ranks.low[i]) > (ranks.error[i] + ranks.error[j]) * 1.0001


@helper
def _number(ranks: Ranks) -> bool:
    """Ranks in order, 0 at the ray's origin, which is the first in the list; False where an order is open."""
    order, rank, last = ranks.order, 0.0, 0
    for k in range(ranks.size[CROSSINGS]):
        this = order[k]
        if k > 0 and not _together(ranks, order[k - 1], this):
            if not _apart(ranks, last, this):
                return False
            rank += 1.0
        furthest = ranks.high[last] + ranks.error[last]
        last = this if k == 0 or ranks.high[this] + ranks.error[this] >= furthest else last
        ranks.rank[this] = rank
    zero = ranks.rank[0]
    for k in range(ranks.size[CROSSINGS]):
        ranks.rank[k] -= zero
    return True


@helper
def rank_ray(geometry: Geometry, rest: Rest, scratch: Scratch, ranks: Ranks, ray: Ray, inverse: float) -> int:
    """Ranks of all that the ray may cross; returns how many entries are in scratch.found, or -1 if an order is open.

    The ray's origin is number 0 in the list of crossings.
    """
    count = collect(geometry, scratch, ray)
    list_surfaces(geometry, scratch, ranks, ray, count)
    ranks.size[CROSSINGS] = 0
    _put(ranks, Sure(0.0, 0.0, 0.0), FREE)
    certain = True
    for k in range(ranks.size[SURFACES]):
        certain &= _decide_surface(geometry, rest, ranks, ranks.surfaces[k], ray, inverse)
    for k in range(count):
        certain &= _decide_outline(geometry, rest, ranks, scratch.found[k], ray)
    if not certain:
        return -1
    _sort(ranks)
    return count if _number(ranks) else -1


@inline
def _decide_outline(geometry: Geometry, rest: Rest, ranks: Ranks, entry: int, ray: Ray) -> bool:
    """Decide whether the ray passes within a polygon; False if that is open."""
    if integer(geometry, table.ENTRY_KIND, entry) != POLYGON:
        return True
    polygon = integer(geometry, table.ENTRY_INDEX, entry)
    inside = decide_loop(geometry, rest, polygon, ray)
    ranks.loops[polygon] = inside
    return inside < 2


@inline
def ray_of_ranks(start: int) -> Ray:
    """The ray that crosses at ranks, all of it."""
    return Ray(0.0, 0.0, 0.0, 1.0, 0.0, 0.0, -math.inf, math.inf, start)


@inline
def t_of(ranks: Ranks, surface: int, rank: float) -> float:
    """Where the crossing of a surface at a rank is."""
    first = ranks.first[surface]
    return ranks.t[first] if ranks.rank[first] == rank else ranks.t[first + 1]
