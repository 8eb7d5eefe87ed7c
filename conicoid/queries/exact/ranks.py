"""A doubtful ray as a problem of order alone.

Which bodies a ray meets depends on the order of its crossings with surfaces alone. So a ray that rounding may
have got wrong is decided in two steps. First every crossing is found with certainty and gets its rank: 0, 1, 2
along the ray, equal where crossings coincide. Then the surfaces are replaced by simple ones which a ray along the
x axis crosses at x = the rank, exactly, in floats: a sphere from rank 3 to 8 has its center at 5.5. The
functions of `engine/body` trace these as they trace any ray, so every rule is written in one place.

Ranks come from numbers with error bounds (kernels/surface/exact_crossing.py) or, where those leave it open, from exact
arithmetic (conicoid.geometry.exact_crossings).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..._jit.decorators import allocator, helper, inline, record_shapes
from ...kernels import tables as table
from ...kernels.body.boolean import collect_leaves, put_crossing, read_crossing
from ...kernels.body.crossing_rows import (
    ENTER,
    ENTER_CLIPPED,
    ENTER_OFF,
    EXIT,
    EXIT_CLIPPED,
    EXIT_OFF,
    OFF,
    BodyRows,
    T,
    grow_rows,
    put_rows,
    sort_rows,
)
from ...kernels.body.entry import collect_entries, crossing_face, entry_crossings, is_solid
from ...kernels.body.hit import Hit, comes_first, no_hit
from ...kernels.body.scratch import LEAF_COUNT, TIME, Scratch
from ...kernels.numbers.bounded_pair import BoundedPair
from ...kernels.numbers.shell_sort import make_sort
from ...kernels.programs import cell_of_leaf
from ...kernels.ray import Ray, scale_ray
from ...kernels.surface.doubt import ALIKE
from ...kernels.surface.exact_crossing import CROSSES, OPEN, RoundingRest, decide_curved, decide_plane
from ...kernels.surface.polygon_loop import decide_loop
from ...kernels.surface.records import curved_roots, is_curved, plane_crossing
from ...kernels.tables import BALL, CELL, POLYGON, REGION, Floats, Geometry, Ints, Longs, Signs, integer, whole

SURFACES, CROSSINGS = 0, 1
"""Of `Ranks.size`: how many of either there are."""
FREE = -1
"""In place of a surface: the ray's origin."""


@record_shapes(
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


class RankScratch(NamedTuple):
    """Memory of one thread that decides rays."""

    rest: RoundingRest  # what rounding took from the records of surfaces
    stand: Geometry  # the scene with simple surfaces in place of its own, see canonical_surfaces.py
    ranks: Ranks


@record_shapes(which="m", still="m")
class Doubtful(NamedTuple):
    """Rays to be decided."""

    which: Ints  # their numbers
    still: Signs  # set to 1 where it takes exact arithmetic


@inline
def _put(ranks: Ranks, place: BoundedPair, owner: int) -> None:
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
            for j in range(collect_leaves(geometry, scratch, program, ray)):
                _list_cell(geometry, ranks, cell_of_leaf(geometry, scratch.found_leaves[j]))


@inline
def clear_ranks(ranks: Ranks) -> None:
    """Clear `listed` for another ray; the other lists are overwritten."""
    for k in range(ranks.size[SURFACES]):
        ranks.listed[ranks.surfaces[k]] = 0
    ranks.size[SURFACES] = 0


@helper
def _decide_surface(
    geometry: Geometry, rest: RoundingRest, ranks: Ranks, surface: int, ray: Ray, inverse: float
) -> bool:
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
        report_fast_t(geometry, ranks, surface, ray, inverse)
    return True


@inline
def report_fast_t(geometry: Geometry, ranks: Ranks, surface: int, ray: Ray, inverse: float) -> None:
    """Report the t of the fast formulas where it is not doubtful: t must not depend on other crossings nearby."""
    if is_curved(geometry, surface):
        low, high, _, crosses, unsure = curved_roots(geometry, surface, ray, inverse)
        known = crosses and not unsure
    else:
        low, _, unsure = plane_crossing(geometry, surface, ray, inverse)
        known, high = not unsure, low
    if known:
        _report_t(ranks, ranks.first[surface], low)
        _report_t(ranks, ranks.first[surface] + 1, high)


@inline
def _report_t(ranks: Ranks, k: int, t: float) -> None:
    """Report t, unless it is far from the certain place: across the origin, or of a root near infinity."""
    if abs(t - ranks.t[k]) <= abs(t) * ALIKE:
        ranks.t[k] = t


@inline
def _is_later(ranks: Ranks, i: int, j: int) -> bool:
    """Does crossing i come after crossing j, by their midpoints?"""
    return ranks.high[i] > ranks.high[j] or (ranks.high[i] == ranks.high[j] and ranks.low[i] > ranks.low[j])


_sort_places = make_sort(_is_later)


@helper
def _sort(ranks: Ranks) -> None:
    """The crossings in order."""
    count, order = ranks.size[CROSSINGS], ranks.order
    for i in range(count):
        order[i] = i
    _sort_places(order, count, ranks)


@inline
def _is_same_crossing(ranks: Ranks, i: int, j: int) -> bool:
    """Are two crossings one: of one plane, the same number, or both infinite?"""
    if ranks.high[i] != ranks.high[j] or ranks.low[i] != ranks.low[j]:
        return False
    return ranks.error[i] + ranks.error[j] == 0.0 or (
        ranks.owner[i] == ranks.owner[j] and ranks.error[i] == ranks.error[j]
    )


@inline
def _is_certainly_before(ranks: Ranks, i: int, j: int) -> bool:
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
        if k > 0 and not _is_same_crossing(ranks, order[k - 1], this):
            if not _is_certainly_before(ranks, last, this):
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
def rank_ray(geometry: Geometry, rest: RoundingRest, scratch: Scratch, ranks: Ranks, ray: Ray, inverse: float) -> int:
    """Ranks of all that the ray may cross; returns how many entries are in scratch.found, or -1 if an order is open.

    The ray's origin is number 0 in the list of crossings.
    """
    count = collect_entries(geometry, scratch, ray)
    list_surfaces(geometry, scratch, ranks, ray, count)
    ranks.size[CROSSINGS] = 0
    _put(ranks, BoundedPair(0.0, 0.0, 0.0), FREE)
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
def _decide_outline(geometry: Geometry, rest: RoundingRest, ranks: Ranks, entry: int, ray: Ray) -> bool:
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


# A ray whose ranks are known (see ranks.py): which of a body's crossings lie within its interval, and where.
#
# The origin is the rank 0. Other ends of an interval are compared with the reported t of a crossing, each body
# separately, as the fast formulas do: so first hits, occlusion, spans and crossings agree on what an interval holds,
# whichever of them took the fast formulas. Where reported t are not in the order of the ranks, a later crossing
# is within the interval if the one before it is.


@inline
def find_leaves(geometry: Geometry, scratch: Scratch, entry: int, ray: Ray) -> None:
    """Find the leaves of an entry that the true ray may meet: a ray of ranks cannot be tested against their boxes."""
    program = entry_program(geometry, entry)
    forget_leaves(scratch)
    if program >= 0:
        scratch.found_leaves[LEAF_COUNT] = collect_leaves(geometry, scratch, program, ray)


@inline
def forget_leaves(scratch: Scratch) -> None:
    """Undo `find_leaves`."""
    scratch.found_leaves[LEAF_COUNT] = -1


@inline
def _rank_and_t(geometry: Geometry, scratch: Scratch, ranks: Ranks, entry: int, n: int) -> tuple[float, float]:
    """(rank, t) of crossing n of an entry."""
    rank, place, sense, _ = read_crossing(scratch, n)
    return rank, t_of(ranks, crossing_face(geometry, entry, place, sense)[0], rank)


@helper
def ranked_crossings(
    geometry: Geometry, stand: Geometry, scratch: Scratch, ranks: Ranks, entry: int, ray: Ray
) -> tuple[int, bool]:
    """(number of an entry's crossings in (t_min, t_max), inside just after t_min); they are in scratch, t is a rank.

    The reported t of each is in scratch.time[TIME * n].
    """
    count, inside, _ = entry_crossings(stand, scratch, entry, ray_of_ranks(ray.start), 1 << 30)
    first = 0
    while first < count:
        rank, t = _rank_and_t(geometry, scratch, ranks, entry, first)
        if rank > 0.0 if ray.t_min == 0.0 else t > ray.t_min:
            break
        inside = not inside
        first += 1
    for k in range(first, count):
        rank, t = _rank_and_t(geometry, scratch, ranks, entry, k)
        if rank >= 0.0 if ray.t_max == 0.0 else t >= ray.t_max:
            return k - first, inside
        _, place, sense, enters = read_crossing(scratch, k)
        put_crossing(scratch, k - first, rank, place, sense, 1 if enters else 0)
        scratch.time[TIME * (k - first)] = t
    return count - first, inside


@helper
def first_of_ranks(geometry: Geometry, stand: Geometry, scratch: Scratch, ranks: Ranks, ray: Ray, count: int) -> Hit:
    """The first crossing of the entries scratch.found[:count]; its t is the largest reported for any at its rank."""
    best, latest = no_hit(), -math.inf
    for k in range(count):
        entry = scratch.found[k]
        find_leaves(geometry, scratch, entry, ray)
        crossings, _ = ranked_crossings(geometry, stand, scratch, ranks, entry, ray)
        rank, place, sense, enters = read_crossing(scratch, 0)
        body = whole(entry)
        if crossings > 0 and rank <= best.t:
            latest = max(latest if rank == best.t else -math.inf, scratch.time[0])
            if comes_first(rank, body, best.t, best.body):
                best = Hit(rank, body, whole(entry), place, sense, enters, 0.0, False)
    forget_leaves(scratch)
    if best.entry < 0:
        return best
    return Hit(latest, best.body, best.entry, best.place, best.sense, best.enters, 0.0, False)


@helper
def _put_places(scratch: Scratch, crossings: int, inside: bool, spans: bool, rows: Floats, used: int) -> int:
    """Where an entry's crossings are reported, into the last columns of its rows; returns how many rows there are."""
    for c in range(crossings):
        t = scratch.time[TIME * c]
        if not spans:
            rows[used + c, OFF] = t
        else:
            rows[used, EXIT_OFF if inside else ENTER_OFF] = t
            used += 1 if inside else 0
            inside = not inside
    return used + (crossings if not spans else (1 if inside else 0))


@inline
def _end(rows: Floats, i: int, spans: bool, last: bool) -> tuple[bool, float, float]:
    """(is it a crossing, its rank, its reported t) of row i's first end, or of a span's last."""
    if not spans:
        return not last, rows[i, T], rows[i, OFF]
    if last:
        return rows[i, EXIT_CLIPPED] == 0.0, rows[i, EXIT], rows[i, EXIT_OFF]
    return rows[i, ENTER_CLIPPED] == 0.0, rows[i, ENTER], rows[i, ENTER_OFF]


@allocator
def _ranks_to_t(rows: Floats, first: int, last: int, given: Ray, scale: float, spans: bool) -> None:
    """From ranks to t, of the length that the ray's direction had; clipped ends to those of the interval.

    Keeps one t for each rank, whatever body it belongs to, and t rising with the ranks: the largest reported so far.
    """
    low, high = math.inf, -math.inf
    for i in range(first, last):
        for end in range(2):
            crosses, rank, _ = _end(rows, i, spans, end == 1)
            if crosses:
                low, high = min(low, rank), max(high, rank)
    latest = np.full(int(high - low) + 1 if low <= high else 0, -math.inf)
    for i in range(first, last):
        for end in range(2):
            crosses, rank, t = _end(rows, i, spans, end == 1)
            if crosses:
                latest[int(rank - low)] = max(latest[int(rank - low)], t * scale)
    for k in range(1, len(latest)):
        latest[k] = max(latest[k], latest[k - 1])
    for i in range(first, last):
        crosses, rank, _ = _end(rows, i, spans, True)
        if spans:
            rows[i, EXIT] = latest[int(rank - low)] if crosses else given.t_max
        crosses, rank, _ = _end(rows, i, spans, False)
        rows[i, T] = latest[int(rank - low)] if crosses else given.t_min


@allocator
def rows_of_ranks(
    geometry: Geometry,
    room: RankScratch,
    scratch: Scratch,
    given: Ray,
    count: int,
    spans: bool,
    rows: Floats,
    used: int,
) -> tuple[Floats, int]:
    """Rows (crossing_rows) of the entries scratch.found[:count] from rows[used] on: (rows, how many now)."""
    (ray, scale), stand, ranks = scale_ray(given), room.stand, room.ranks
    first, along = used, ray_of_ranks(ray.start)
    for k in range(count):
        entry = scratch.found[k]
        if spans and not is_solid(geometry, entry):
            continue
        find_leaves(geometry, scratch, entry, ray)
        crossings, inside = ranked_crossings(geometry, stand, scratch, ranks, entry, ray)
        if crossings > 0 or inside:
            rows = grow_rows(rows, used, crossings + 1)
            put_rows(geometry, scratch, entry, BodyRows(crossings, inside, 0.0, False), along, spans, rows, used)
            used = _put_places(scratch, crossings, inside, spans, rows, used)
    forget_leaves(scratch)
    sort_rows(rows, first, used, spans)
    _ranks_to_t(rows, first, used, given, scale, spans)
    return rows, used
