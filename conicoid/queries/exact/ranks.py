"""Ranks: the crossings of a doubtful ray, reduced to their order.

Which bodies a ray hits depends only on the order of its crossings with surfaces. So two steps decide a ray for which
rounding may have given a wrong result. The first computes every crossing with certainty and gives it a rank: 0, 1, 2
along the ray, equal ranks for coinciding crossings. The second replaces the surfaces by simple ones, canonical
surfaces, that a ray along the x axis crosses at x = rank, exactly, in floats: a sphere from rank 3 to 8 has its center
at 5.5. The functions of `kernels/body` trace these like any other ray, so every rule has one implementation.

Ranks come from numbers with error bounds (kernels/surface/exact_crossing.py) or, where these do not decide, from exact
arithmetic (conicoid.geometry.exact_crossings).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..._jit.decorators import helper, inline, record_shapes
from ...kernels import tables as table
from ...kernels.body.boolean import collect_leaves, put_crossing, read_crossing
from ...kernels.body.cell import (
    FIRST_GROUPS,
    groups_of,
    is_beside,
    margin_of,
    next_group,
    plane_of_group,
    slab_of_many,
)
from ...kernels.body.entry import collect_entries, crossing_face, entry_crossings
from ...kernels.body.scratch import LEAF_COUNT, TIME, Scratch
from ...kernels.numbers.double_double import BoundedPair, bounded_pair, minus, opposite, sign, times
from ...kernels.numbers.shell_sort import make_sort
from ...kernels.programs import cell_of_leaf
from ...kernels.ray import Ray, span_inverse
from ...kernels.surface.doubt import T_ERROR
from ...kernels.surface.exact_crossing import (
    CROSSES,
    MISSES,
    OPEN,
    TOUCHES,
    RoundingRest,
    curved_terms,
    decide_curved,
    decide_plane,
    plane_terms,
)
from ...kernels.surface.interval import is_too_far, nearness_of
from ...kernels.surface.polygon_loop import decide_loop
from ...kernels.surface.records import curved_roots, is_curved, plane_crossing
from ...kernels.tables import (
    ANCHOR_SIZE,
    BALL,
    CELL,
    FORM_SIZE,
    PLANE_SIZE,
    POLYGON,
    REGION,
    SPHERE,
    SPHERE_SIZE,
    Floats,
    Geometry,
    Ints,
    Longs,
    Signs,
    integer,
    length,
)

SURFACES, CROSSINGS = 0, 1
"""Indices of `Ranks.size`: the number of surfaces, the number of crossings."""
FREE = -1
"""The owner of the first crossing, which is the ray's origin."""


@record_shapes(
    surfaces="surface_kind", listed="surface_kind", verdict="2*surface_kind", first="surface_kind",
    high="2*surface_kind+8", low="2*surface_kind+8", error="2*surface_kind+8", owner="2*surface_kind+8",
    t="2*surface_kind+8", order="2*surface_kind+8", rank="2*surface_kind+8", tied="2*surface_kind+8",
    drift="4*surface_kind+16", sequence="2*surface_kind+8", loops="polygon_surface", size="2", absent="surface_kind",
)  # fmt: skip
class Ranks(NamedTuple):
    """Memory for the crossings of one ray. Pages of the arrays take memory only once they are written."""

    surfaces: Ints  # (surfaces,) list of the surfaces that the ray may cross
    listed: Ints  # (surfaces,) 1 for the surfaces in that list
    verdict: Ints  # (2 surfaces,) of each: CROSSES, TOUCHES or MISSES, and the sign of its `Decision`
    first: Ints  # (surfaces,) index of its first crossing in the arrays below
    high: Floats  # (2 surfaces + 8,) crossings: t = high + low to 30 digits, with a bound `error`
    low: Floats
    error: Floats
    owner: Ints  # the surface, or FREE
    t: Floats  # the reported t
    order: Ints  # crossings sorted by t
    rank: Floats
    tied: Floats  # ranks with ties, while `rank` has none (tie_orders.py)
    drift: Floats  # (4 surfaces + 16,) of each crossing: how far it moves as the ray moves along two axes
    sequence: Ints  # crossings sorted by place, and within a place in the order of a ray beside this one
    loops: Ints  # (polygons,) 1 if the ray passes within the polygon's outline; with EDGE on its edge
    size: Longs  # (2,) see `SURFACES`
    absent: Ints  # (surfaces,) terms that a quadric lacks, as bits (`is_straight`); 0 if none are known


class RankScratch(NamedTuple):
    """Memory of one thread that decides rays."""

    rest: RoundingRest  # rounding errors of the surfaces' records
    stand: Geometry  # the scene with canonical surfaces in place of its own
    ranks: Ranks


class RankedRay(NamedTuple):
    """A ray whose crossings have ranks, the scene and its canonical surfaces, and the entries that it may cross."""

    geometry: Geometry
    stand: Geometry  # the scene with canonical surfaces
    scratch: Scratch
    ranks: Ranks
    ray: Ray
    entry_count: int  # the entries are scratch.found[:entry_count]; -1 where the ranks are undecided


@record_shapes(which="m", undecided="m")
class Doubtful(NamedTuple):
    """Rays to decide."""

    which: Ints  # numbers of the rays
    undecided: Signs  # kernels set 1 where only exact arithmetic can decide


@inline
def _put(ranks: Ranks, place: BoundedPair, owner: int) -> None:
    """Append a crossing. Its reported t is the certain one unless `report_fast_t` replaces it."""
    k = ranks.size[CROSSINGS]
    ranks.high[k], ranks.low[k], ranks.error[k] = place.high, place.low, place.error
    ranks.owner[k], ranks.t[k] = owner, place.high
    ranks.size[CROSSINGS] = k + 1


@inline
def _list(ranks: Ranks, surface: int) -> None:
    """Append a surface to the list, once."""
    # A wall that several bodies share is one surface, and is decided once
    if surface >= 0 and ranks.listed[surface] == 0:
        ranks.listed[surface] = 1
        ranks.surfaces[ranks.size[SURFACES]] = surface
        ranks.size[SURFACES] += 1


@helper
def _list_cell(geometry: Geometry, ranks: Ranks, cell: int, ray: Ray, every: bool) -> None:
    """Append the surfaces of a cell to the list; unless `every`, of many planes those that may end spans of the ray."""
    _list(ranks, integer(geometry, table.CELL_QUADRIC, cell))
    begin, (group, end) = integer(geometry, table.CELL_FIRST, cell), groups_of(geometry, cell)
    if group < end and not every and _list_near(geometry, ranks, cell, ray):
        return
    for slot in range(begin, integer(geometry, table.CELL_FIRST, cell + 1)):
        _list(ranks, integer(geometry, table.PLANE_SURFACE, slot))


@inline
def _list_near(geometry: Geometry, ranks: Ranks, cell: int, ray: Ray) -> bool:
    """Append the planes of a cell of many that may end the spans of a ray. False if these are not known.

    The slab has errors of `nearness.off`, and so have the crossings of its planes; what `is_beside` excludes is inside
    all of them. If the slab is surely empty its two planes decide, unless a plane along the ray left nothing of it.
    """
    inverse = span_inverse(ray)
    nearness = nearness_of(geometry, table.CELL_LIMITS, cell, ray, inverse)
    slab, _, lost = slab_of_many(geometry, cell, ray, inverse, nearness)
    t_in, t_out, place_in, place_out = slab
    known = (place_in >= 0) & (place_out >= 0) & (t_in < math.inf) & (not lost) & (nearness.far >= 0.0)
    if not known or is_too_far(t_in, nearness) or is_too_far(t_out, nearness):
        return False
    _list(ranks, integer(geometry, table.PLANE_SURFACE, place_in))
    _list(ranks, integer(geometry, table.PLANE_SURFACE, place_out))
    if t_in > t_out + 2.0 * nearness.off:
        return True
    begin, (group, end) = integer(geometry, table.CELL_FIRST, cell), groups_of(geometry, cell)
    margin = 2.0 * margin_of(slab, ray, nearness)
    group = next_group(geometry, group + FIRST_GROUPS, end, slab, ray, margin)
    while group < end:
        for k in range(4):
            place = begin + plane_of_group(geometry, group, k)
            if place >= begin and not is_beside(geometry, slab, place, ray, margin):
                _list(ranks, integer(geometry, table.PLANE_SURFACE, place))
        group = next_group(geometry, group + 1, end, slab, ray, margin)
    return True


@inline
def entry_program(geometry: Geometry, entry: int) -> int:
    """Return the Boolean program of an entry, that of a region or of the clip of a sheet; -1 for none."""
    kind, index = integer(geometry, table.ENTRY_KIND, entry), integer(geometry, table.ENTRY_INDEX, entry)
    if kind == REGION:
        return index
    if kind <= CELL:
        return -1
    return integer(geometry, table.POLYGON_PROGRAM if kind == POLYGON else table.SHEET_PROGRAM, index)


@helper
def list_surfaces(geometry: Geometry, scratch: Scratch, ranks: Ranks, ray: Ray, count: int, every: bool) -> None:
    """List the surfaces of the entries scratch.found[:count] at which spans of the ray may end, or every surface."""
    ranks.size[SURFACES] = 0
    for k in range(count):
        entry = scratch.found[k]
        kind, index = integer(geometry, table.ENTRY_KIND, entry), integer(geometry, table.ENTRY_INDEX, entry)
        if kind == BALL:
            _list(ranks, index)
        elif kind == CELL:
            _list_cell(geometry, ranks, index, ray, every)
        elif kind != REGION:
            of = table.POLYGON_SURFACE if kind == POLYGON else table.SHEET_SURFACE
            _list(ranks, integer(geometry, of, index))
        program = entry_program(geometry, entry)
        if program >= 0:
            for j in range(collect_leaves(geometry, scratch, program, ray)):
                _list_cell(geometry, ranks, cell_of_leaf(geometry, scratch.found_leaves[j]), ray, every)


@inline
def clear_ranks(ranks: Ranks) -> None:
    """Clear `listed` for another ray; the other lists are overwritten."""
    for k in range(ranks.size[SURFACES]):
        ranks.listed[ranks.surfaces[k]] = 0
    ranks.size[SURFACES] = 0


@inline
def clear_stand(stand: Geometry, ranks: Ranks) -> None:
    """Clear the canonical planes of a ray, then its ranks, so that the next ray finds none."""
    for k in range(ranks.size[SURFACES]):
        if not is_curved(stand, ranks.surfaces[k]):
            at = stand.places[table.PLANES] + PLANE_SIZE * integer(stand, table.SURFACE_ROW, ranks.surfaces[k])
            for j in range(PLANE_SIZE):
                stand.floats[at + j] = 0.0
    clear_ranks(ranks)


@helper
def _decide_surface(
    geometry: Geometry, rest: RoundingRest, ranks: Ranks, surface: int, ray: Ray, inverse: float
) -> bool:
    """Append the crossings of a surface. Return False if they stay undecided."""
    starts = surface == ray.start
    if is_curved(geometry, surface):
        verdict, sense, low, high = decide_curved(geometry, rest, surface, ray, starts, ranks.absent[surface])
    else:
        verdict, sense, low, high = decide_plane(geometry, rest, surface, ray, starts)
    ranks.verdict[2 * surface], ranks.verdict[2 * surface + 1] = verdict, sense
    if verdict == OPEN:
        return False
    if verdict != MISSES:
        ranks.first[surface] = ranks.size[CROSSINGS]
        _put(ranks, low, surface)
        _put(ranks, high, surface)
    if verdict == CROSSES:
        report_fast_t(geometry, ranks, surface, ray, inverse)
    return True


@inline
def report_fast_t(geometry: Geometry, ranks: Ranks, surface: int, ray: Ray, inverse: float) -> None:
    """Report the t of the fast formulas where it is not in doubt: t must not depend on other crossings nearby."""
    if is_curved(geometry, surface):
        low, high, _, crosses, unsure = curved_roots(geometry, surface, ray, inverse)
        is_sure = crosses and not unsure
    else:
        low, _, unsure = plane_crossing(geometry, surface, ray, inverse)
        is_sure, high = not unsure, low
    if is_sure:
        _report_t(ranks, ranks.first[surface], low)
        _report_t(ranks, ranks.first[surface] + 1, high)


@inline
def _report_t(ranks: Ranks, k: int, t: float) -> None:
    """Report t, unless it is far from the certain one: across the origin, or for a root near infinity."""
    # The fast formulas may have found the other root of a pair, or none; then the certain t stays
    if abs(t - ranks.t[k]) <= abs(t) * T_ERROR:
        ranks.t[k] = t


@inline
def _is_later(ranks: Ranks, i: int, j: int) -> bool:
    """Return True if crossing i comes after crossing j by their midpoints."""
    return ranks.high[i] > ranks.high[j] or (ranks.high[i] == ranks.high[j] and ranks.low[i] > ranks.low[j])


_sort_places = make_sort(_is_later)


@helper
def _sort(ranks: Ranks) -> None:
    """Write the crossings sorted by t to ranks.order."""
    count, order = ranks.size[CROSSINGS], ranks.order
    for i in range(count):
        order[i] = i
    _sort_places(order, count, ranks)


@inline
def _is_same_crossing(geometry: Geometry, ranks: Ranks, i: int, j: int) -> bool:
    """Return True if two crossings coincide: equal exact numbers, or the place of one plane or touch."""
    if ranks.high[i] != ranks.high[j] or ranks.low[i] != ranks.low[j]:
        return False
    surface = ranks.owner[i]
    if ranks.error[i] + ranks.error[j] == 0.0 or surface != ranks.owner[j]:
        return ranks.error[i] + ranks.error[j] == 0.0
    # The two roots of a ball that is tiny beside its distance may have equal numbers
    return not is_curved(geometry, surface) or ranks.verdict[2 * surface] == TOUCHES


@inline
def _is_certainly_before(ranks: Ranks, i: int, j: int) -> bool:
    """Return True if crossing i certainly comes before crossing j."""
    # Infinite roots have no difference; they lie before and behind everything finite
    if ranks.high[i] == -math.inf or ranks.high[j] == math.inf:
        return ranks.high[i] != ranks.high[j]
    return (ranks.high[j] - ranks.high[i]) + (ranks.low[j] - ranks.low[i]) > (ranks.error[i] + ranks.error[j]) * 1.0001


@helper
def _ratio(
    geometry: Geometry, rest: RoundingRest, ranks: Ranks, i: int, ray: Ray
) -> tuple[BoundedPair, BoundedPair, bool]:
    """Return (n, d, True) with t = n / d of crossing i if that is the origin, a plane or a touch; else False."""
    surface, zero = ranks.owner[i], bounded_pair(0.0)
    if surface == FREE:
        return zero, bounded_pair(1.0), True
    if not is_curved(geometry, surface):
        height, rate = plane_terms(geometry, rest, surface, ray, 0.0)
        return (zero if surface == ray.start else opposite(height)), rate, True
    a, b, _, _ = curved_terms(geometry, rest, surface, ray, 0.0)
    return opposite(b), a, ranks.verdict[2 * surface] == TOUCHES


@helper
def _is_same_ratio(geometry: Geometry, rest: RoundingRest, ranks: Ranks, i: int, j: int, ray: Ray) -> bool:
    """Return True if two crossings certainly coincide as ratios: n d' = n' d. False is no answer.

    A quotient such as 1/3 has an error, its numerator and denominator may have none: edges and corners, and touches in
    one place, need no exact arithmetic then.
    """
    n, d, is_known = _ratio(geometry, rest, ranks, i, ray)
    other_n, other_d, other_is_known = _ratio(geometry, rest, ranks, j, ray)
    return is_known and other_is_known and sign(minus(times(n, other_d), times(other_n, d))) == 0


@helper
def _number(geometry: Geometry, rest: RoundingRest, ranks: Ranks, ray: Ray) -> bool:
    """Write ranks in sorted order, with 0 for the ray's origin, the first crossing. Return False for an open order."""
    order, rank, last = ranks.order, 0.0, 0
    for k in range(ranks.size[CROSSINGS]):
        this = order[k]
        if k > 0 and not _is_same_crossing(geometry, ranks, order[k - 1], this):
            if _is_certainly_before(ranks, last, this):
                rank += 1.0
            elif not _is_same_ratio(geometry, rest, ranks, order[k - 1], this, ray):
                return False
        # `last` is the crossing with the largest upper bound so far, with which the next one is compared
        furthest = ranks.high[last] + ranks.error[last]
        last = this if k == 0 or ranks.high[this] + ranks.error[this] >= furthest else last
        ranks.rank[this] = rank
    # Ranks count from the origin, so that its crossing is 0 and those behind are negative
    zero = ranks.rank[0]
    for k in range(ranks.size[CROSSINGS]):
        ranks.rank[k] -= zero
    return True


@helper
def _put_ranks(geometry: Geometry, rest: RoundingRest, scratch: Scratch, ranks: Ranks, ray: Ray, inverse: float) -> int:
    """Compute the ranks of all crossings of a ray. Return the number of entries in scratch.found, or -1 if undecided.

    The ray's origin is crossing 0.
    """
    count = collect_entries(geometry, scratch, ray)
    list_surfaces(geometry, scratch, ranks, ray, count, False)
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
    return count if _number(geometry, rest, ranks, ray) else -1


@inline
def _decide_outline(geometry: Geometry, rest: RoundingRest, ranks: Ranks, entry: int, ray: Ray) -> bool:
    """Decide whether the ray passes within the outline of a polygon. Return False if it stays undecided."""
    if integer(geometry, table.ENTRY_KIND, entry) != POLYGON:
        return True
    polygon = integer(geometry, table.ENTRY_INDEX, entry)
    inside = decide_loop(geometry, rest, polygon, ray)
    ranks.loops[polygon] = inside
    return inside != OPEN


@inline
def ray_of_ranks(start: int) -> Ray:
    """Return the whole line along the x axis, whose crossings with canonical surfaces are ranks."""
    return Ray(0.0, 0.0, 0.0, 1.0, 0.0, 0.0, -math.inf, math.inf, start)


@inline
def t_of(ranks: Ranks, surface: int, rank: float) -> float:
    """Return the reported t of the crossing of a surface at a rank."""
    first = ranks.first[surface]
    return ranks.t[first] if ranks.rank[first] == rank else ranks.t[first + 1]


# Crossings of a ray with known ranks within its interval
#
# The origin has rank 0. Other ends of an interval are compared with the reported t of a crossing, for each body
# separately, as the fast formulas do. So first hits, occlusion, spans and crossings agree on the crossings in an
# interval, whichever of them used the fast formulas. Where reported t are not in the order of the ranks, a later
# crossing lies within the interval if the crossing before it does.


@inline
def find_leaves(geometry: Geometry, scratch: Scratch, entry: int, ray: Ray) -> None:
    """Find the leaves of an entry that the true ray may cross. The ray of ranks cannot be tested against boxes."""
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
    """Return the rank and the reported t of crossing n of an entry."""
    rank, place, sense, _ = read_crossing(scratch, n)
    return rank, t_of(ranks, crossing_face(geometry, entry, place, sense)[0], rank)


@helper
def ranked_crossings(of: RankedRay, entry: int) -> tuple[int, bool]:
    """Return the number of an entry's crossings in (t_min, t_max), and whether the ray is inside just after t_min.

    The crossings are in scratch with ranks as t; scratch.time[TIME * n] holds the reported t of crossing n.
    """
    geometry, scratch, ranks, ray, first = of.geometry, of.scratch, of.ranks, of.ray, 0
    count, inside, _ = entry_crossings(of.stand, scratch, entry, ray_of_ranks(ray.start), 1 << 30)
    while first < count:
        rank, t = _rank_and_t(geometry, scratch, ranks, entry, first)
        # The origin is exact, so that its rank decides; other ends are compared with the reported t
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


# Canonical surfaces: simple ones in place of those of a ray whose ranks are known
#
# A ray along the x axis crosses them at x = rank, exactly. They overwrite the records of `stand`, a copy of the scene's
# tables.


@helper
def rank_ray(geometry: Geometry, room: RankScratch, scratch: Scratch, ray: Ray) -> int:
    """Compute the ranks of a ray, and put its canonical surfaces. Return `RankedRay.entry_count`."""
    count = _put_ranks(geometry, room.rest, scratch, room.ranks, ray, span_inverse(ray))
    if count >= 0:
        put_canonical_surfaces(RankedRay(geometry, room.stand, scratch, room.ranks, ray, count))
    return count


@helper
def put_canonical_surfaces(of: RankedRay) -> None:
    """Write canonical surfaces for ranks.surfaces, and outlines of polygons, into the records of `stand`."""
    geometry, stand, ranks = of.geometry, of.stand, of.ranks
    for k in range(ranks.size[SURFACES]):
        surface = ranks.surfaces[k]
        row = integer(geometry, table.SURFACE_ROW, surface)
        crosses, sense = ranks.verdict[2 * surface] == CROSSES, float(ranks.verdict[2 * surface + 1])
        low, high = 0.0, 0.0
        if crosses:
            low, high = ranks.rank[ranks.first[surface]], ranks.rank[ranks.first[surface] + 1]
        kind = integer(geometry, table.SURFACE_KIND, surface)
        if not is_curved(geometry, surface):
            _put_plane(stand, row, crosses, sense, low)
        elif kind == SPHERE:
            _put_sphere(stand, row, crosses, low, high)
        else:
            first = ranks.first[surface]
            ends = crosses and ranks.high[first] > -math.inf, crosses and ranks.high[first + 1] < math.inf
            _put_quadric(stand, row, crosses, sense, low, high, ends, surface == of.ray.start)
    for k in range(of.entry_count):
        entry = of.scratch.found[k]
        if integer(geometry, table.ENTRY_KIND, entry) == POLYGON:
            _put_outline(geometry, stand, ranks, integer(geometry, table.ENTRY_INDEX, entry))


@inline
def _put_plane(stand: Geometry, row: int, crosses: bool, sense: float, rank: float) -> None:
    """Write the plane x = rank, or for a miss a plane parallel to the x axis with the ray on its side `sense`."""
    f, at = stand.floats, stand.places[table.PLANES] + PLANE_SIZE * row
    f[at], f[at + 1], f[at + 2] = (sense, 0.0, 0.0) if crosses else (0.0, 1.0, 0.0)
    f[at + 3] = -sense * rank if crosses else sense
    f[at + 4], f[at + 5], f[at + 6] = 0.0, 0.0, 0.0


@inline
def _put_sphere(stand: Geometry, row: int, crosses: bool, low: float, high: float) -> None:
    """Write a sphere from x = low to x = high, or for a miss one beside the x axis."""
    f, at = stand.floats, stand.places[table.SPHERES] + SPHERE_SIZE * row
    f[at], f[at + 1], f[at + 2] = 0.5 * (low + high), 0.0 if crosses else 5.0, 0.0
    f[at + 3] = 0.5 * (high - low) if crosses else 1.0


def count_form_floats(geometry: Geometry) -> int:
    """Return the number of floats that `stand` has after the scene's: a form for each quadric, and their limits.

    A form's number is that of its limits too. Nobody uses limits of `stand`, but kernels load them, so that those of
    the last form must lie within its memory.
    """
    first, limits = int(geometry.places[table.QUADRIC_FORMS]), int(geometry.places[table.QUADRIC_LIMITS])
    # The last form of n floats is number (n - first) // 16 - 1, and its limits end at `limits` + (n - first) / 8 <= n
    least = (FORM_SIZE * limits - 2 * first) // (FORM_SIZE - 2) + 1 - len(geometry.floats)
    return max(FORM_SIZE * (int(length(geometry, table.QUADRICS)) // ANCHOR_SIZE + 1), least)


@inline
def blank_quadric(stand: Geometry, row: int) -> tuple[int, int]:
    """Clear a quadric's record and form, and return where they begin in the floats of `stand`.

    In the scene several quadrics may share a form. In `stand` each has its own, after all tables
    (`count_form_floats`).
    """
    f, at, first = stand.floats, stand.places[table.QUADRICS] + ANCHOR_SIZE * row, stand.places[table.QUADRIC_FORMS]
    quadrics = length(stand, table.QUADRICS) // ANCHOR_SIZE
    own = (len(f) - first) // FORM_SIZE - quadrics + row
    form = first + FORM_SIZE * own
    f[at], f[at + 1], f[at + 2], f[at + 3] = 0.0, 0.0, 0.0, float(own)
    for k in range(FORM_SIZE):
        f[form + k] = 0.0
    return at, form


@inline
def _put_quadric(
    stand: Geometry, row: int, crosses: bool, sense: float, low: float, high: float, ends: tuple[bool, bool],
    starts: bool,
) -> None:  # fmt: skip
    """Write ± ((x - middle)² - half²), or a plane if one root is infinite, or for a miss a constant."""
    f, (at, form) = stand.floats, blank_quadric(stand, row)
    f[form], f[form + 4], f[form + 8] = 1.0, 1.0, 1.0
    if crosses and ends[0] and ends[1]:
        half = 0.5 * (high - low)
        f[at], f[form + 9], f[form + 15] = 0.5 * (low + high), sense, sense * half * half
    elif crosses:
        f[at], f[form + 12] = (high, 0.5) if ends[1] else (low, -0.5)
    elif starts:
        f[form + 9] = sense
    else:
        f[form + 15] = -sense


@inline
def _put_outline(geometry: Geometry, stand: Geometry, ranks: Ranks, polygon: int) -> None:
    """Write a triangle around the x axis, or for a miss a point beside it; the vertex count stays the same."""
    first, last = (
        integer(geometry, table.POLYGON_FIRST, polygon),
        integer(geometry, table.POLYGON_FIRST, polygon + 1),
    )
    for vertex in range(first, last):
        y, z = 0.0, 4.0
        # Further vertices repeat the third corner
        if vertex == first:
            y, z = -3.0, -2.0
        elif vertex == first + 1:
            y, z = 3.0, -2.0
        if ranks.loops[polygon] & 1 == 0:
            y, z = 5.0, 5.0
        at = stand.places[table.VERTICES] + 3 * vertex
        stand.floats[at], stand.floats[at + 1], stand.floats[at + 2] = 0.0, y, z
