"""Exact decisions for doubtful rays and points: first hits, occlusion, spans, crossings and containing bodies.

The method is that of ranks.py: numbers with error bounds first, in kernels, then exact arithmetic where these do not
decide.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from ..._jit.decorators import allocator, helper, inline, kernel
from ..._util.arrays import FloatArray
from ...geometry.exact_crossings import RayPlace, decide_crossing, exact_ranks, integer_line, side_of_loop
from ...kernels import tables as table
from ...kernels.body.crossing_rows import (
    CROSSING_COLUMNS,
    ENTER,
    ENTER_CLIPPED,
    ENTER_OFF,
    ENTER_SURFACE,
    ENTERS,
    EXIT,
    EXIT_CLIPPED,
    EXIT_OFF,
    EXIT_SURFACE,
    FACE,
    OFF,
    SIDE,
    SPAN_COLUMNS,
    SURFACE,
    BodyRows,
    T,
    grow_rows,
    put_rows,
    sort_rows,
)
from ...kernels.body.entry import collect_entries, crossing_face, entry_nearness, is_solid
from ...kernels.body.hit import scale_hit
from ...kernels.body.scratch import TIME, Scratch, new_scratch
from ...kernels.first_hits import HitBuffers, put_hit
from ...kernels.ray import Ray, RayArrays, load_ray, scale_ray, span_inverse
from ...kernels.surface.exact_crossing import CROSSES, MISSES, TOUCHES, RoundingRest
from ...kernels.surface.polygon_loop import EDGE
from ...kernels.tables import POLYGON, Floats, Geometry, Ints, is_halted, length, whole
from ...kernels.threads import run_on
from ...numerics.rational import ZERO, sign
from ...prepare.mmap_arrays import mapped_zeros
from ...prepare.prepared_scene import PreparedScene, exact_form
from .membership import located_by_ranks, surfaces_near
from .ranks import (
    CROSSINGS,
    FREE,
    SURFACES,
    Doubtful,
    RankedRay,
    Ranks,
    RankScratch,
    clear_ranks,
    clear_stand,
    count_form_floats,
    find_leaves,
    forget_leaves,
    list_surfaces,
    put_canonical_surfaces,
    rank_ray,
    ranked_crossings,
    ray_of_ranks,
    report_fast_t,
    t_of,
)
from .tie_orders import find_ties, first_of_ranks, hangs_on_tie, wall_of_tie

TIED = 2
"""`Doubtful.undecided` of a ray that is decided and hangs on a tie."""


# Rows of a ray with known ranks


@helper
def _put_places(scratch: Scratch, crossings: int, inside: bool, spans: bool, rows: Floats, used: int) -> int:
    """Write the reported t of an entry's crossings to the last columns of its rows, and return the number of rows."""
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
    """Return (is a crossing, rank, reported t) of the first end of row i, or of the last end of a span."""
    if not spans:
        return not last, rows[i, T], rows[i, OFF]
    if last:
        return rows[i, EXIT_CLIPPED] == 0.0, rows[i, EXIT], rows[i, EXIT_OFF]
    return rows[i, ENTER_CLIPPED] == 0.0, rows[i, ENTER], rows[i, ENTER_OFF]


@allocator
def _ranks_to_t(rows: Floats, first: int, last: int, user_ray: Ray, scale: float, spans: bool) -> None:
    """Replace ranks by t in units of the original direction, and clipped ends by the ends of the interval.

    Each rank has one t for all bodies, and t rises with the ranks: it is the largest t reported up to that rank.
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
            rows[i, EXIT] = latest[int(rank - low)] if crosses else user_ray.t_max
        crosses, rank, _ = _end(rows, i, spans, False)
        rows[i, T] = latest[int(rank - low)] if crosses else user_ray.t_min


@helper
def _put_walls(of: RankedRay, entry: int, spans: bool, rows: Floats, first: int, last: int) -> None:
    """Write walls to the rows of an entry whose tied places have the surface of none."""
    for i in range(first, last):
        for end in range(2):
            crosses, rank, _ = _end(rows, i, spans, end == 1)
            if not crosses:
                continue
            column, enters, face = SURFACE, rows[i, ENTERS] == 1.0, whole(rows[i, FACE])
            if spans:
                column, enters, face = EXIT_SURFACE if end == 1 else ENTER_SURFACE, end == 0, whole(-1)
            differs, place, sense = wall_of_tie(of, entry, rank, enters, (whole(rows[i, column]), face))
            if differs:
                surface, number, side = crossing_face(of.geometry, entry, place, sense)
                rows[i, column] = surface
                if not spans:
                    rows[i, FACE], rows[i, SIDE] = number, side
                rows[i, OFF if not spans else EXIT_OFF if end == 1 else ENTER_OFF] = t_of(of.ranks, surface, rank)


@allocator
def rows_of_ranks(
    geometry: Geometry, room: RankScratch, scratch: Scratch, user_ray: Ray, count: int, spans: bool, rows: Floats,
    used: int,
) -> tuple[Floats, int]:  # fmt: skip
    """Append rows (kernels/body/crossing_rows.py) of a ray with ranks. Return (rows, number)."""
    ray, scale = scale_ray(user_ray)
    of = RankedRay(geometry, room.stand, scratch, room.ranks, ray, count)
    first, along, tied = used, ray_of_ranks(ray.start), find_ties(geometry, room.ranks, ray)
    for k in range(count):
        entry = scratch.found[k]
        if spans and not is_solid(geometry, entry):
            continue
        find_leaves(geometry, scratch, entry, ray)
        crossings, inside = ranked_crossings(of, entry)
        if crossings > 0 or inside:
            rows = grow_rows(rows, used, crossings + 1)
            put_rows(geometry, scratch, entry, BodyRows(crossings, inside, 0.0, False), along, spans, rows, used)
            before, used = used, _put_places(scratch, crossings, inside, spans, rows, used)
            if tied:
                _put_walls(of, entry, spans, rows, before, used)
    forget_leaves(scratch)
    sort_rows(rows, first, used, spans)
    _ranks_to_t(rows, first, used, user_ray, scale, spans)
    return rows, used


@helper
def _put_first(
    geometry: Geometry, room: RankScratch, scratch: Scratch, ray: Ray, count: int, scale: float, i: int,
    found: HitBuffers,
) -> int:  # fmt: skip
    """Write the first hit of ray i. Return `TIED`, or 0 if it hangs on no tie."""
    of = RankedRay(geometry, room.stand, scratch, room.ranks, ray, count)
    hit = first_of_ranks(of, find_ties(of.geometry, of.ranks, of.ray))
    put_hit(scale_hit(hit, scale), i, found)
    return whole(TIED if hangs_on_tie(of, hit) else 0)


# Kernels


@kernel(room="out", doubtful="out", begin="0..end", end="0..m", found="out")
def settle_first(
    geometry: Geometry, room: RankScratch, rays: RayArrays, doubtful: Doubtful, begin: int, end: int, found: HitBuffers
) -> None:
    """Write the first hits of doubtful rays begin to end, and `TIED` in undecided[k] where they hang on a tie.

    Undecided rays keep theirs and get undecided[k] = 1.
    """
    scratch = new_scratch(geometry)
    which, undecided = doubtful
    for k in range(begin, end):
        if is_halted(geometry):
            break
        ray, scale = scale_ray(load_ray(rays, which[k]))
        count = rank_ray(geometry, room, scratch, ray)
        undecided[k] = 1
        if count >= 0:
            undecided[k] = _put_first(geometry, room, scratch, ray, count, scale, which[k], found)
        clear_stand(room.stand, room.ranks)


@kernel(t="n", entry="n", limits="out n")
def limits_of_hits(geometry: Geometry, rays: RayArrays, t: Floats, entry: Ints, limits: Floats) -> None:
    """Write limits[k], the `cull_limit` of ray k's hit, or the end of its interval: every route goes as far as that."""
    for k in range(len(limits)):
        whole_ray = load_ray(rays, k)
        ray, scale = scale_ray(whole_ray)
        limits[k] = whole_ray.t_max
        if entry[k] >= 0:
            limits[k] = min(limits[k], t[k] + entry_nearness(geometry, entry[k], ray).off * scale)


@kernel(room="out", doubtful="out", counts="out m")
def settle_rows(
    geometry: Geometry, room: RankScratch, rays: RayArrays, doubtful: Doubtful, spans: bool, counts: Ints
) -> Floats:
    """Return rows of spans or crossings of doubtful rays, counts[k] for ray k; undecided: 0 and undecided[k] = 1."""
    scratch, used = new_scratch(geometry), 0
    which, undecided = doubtful
    rows = np.empty((64, SPAN_COLUMNS if spans else CROSSING_COLUMNS))
    for k in range(len(which)):
        if is_halted(geometry):
            break
        own_ray = load_ray(rays, which[k])
        count, first = rank_ray(geometry, room, scratch, scale_ray(own_ray)[0]), used
        undecided[k] = 1 if count < 0 else 0
        if count >= 0:
            rows, used = rows_of_ranks(geometry, room, scratch, own_ray, count, spans, rows, used)
        counts[k] = used - first
        clear_stand(room.stand, room.ranks)
    return rows[:used].copy()


@kernel(ranks="out", i="0..n-1", entries="out entry_kind")
def crossed_surfaces(geometry: Geometry, ranks: Ranks, rays: RayArrays, i: int, entries: Ints) -> tuple[int, int]:
    """Write the surfaces that ray i may cross to ranks.surfaces, the entries to `entries`; return both counts."""
    scratch = new_scratch(geometry)
    ray, _ = scale_ray(load_ray(rays, i))
    count = collect_entries(geometry, scratch, ray)
    list_surfaces(geometry, scratch, ranks, ray, count, False)
    found = ranks.size[SURFACES]
    for k in range(count):
        # The walk's memory is this call's; the caller needs the entries after it
        entries[k] = scratch.found[k]
    clear_ranks(ranks)
    return found, count


@helper
def prepare_ranked_ray(geometry: Geometry, room: RankScratch, scratch: Scratch, ray: Ray) -> int:
    """Prepare to trace a ray with ranks from exact arithmetic. Return `RankedRay.entry_count`."""
    ranks, count, inverse = room.ranks, collect_entries(geometry, scratch, ray), span_inverse(ray)
    list_surfaces(geometry, scratch, ranks, ray, count, False)
    # Exact arithmetic rounds its own t; where the fast t is certain, it is the one that all routes report
    for k in range(ranks.size[SURFACES]):
        if ranks.verdict[2 * ranks.surfaces[k]] == CROSSES:
            report_fast_t(geometry, ranks, ranks.surfaces[k], ray, inverse)
    put_canonical_surfaces(RankedRay(geometry, room.stand, scratch, ranks, ray, count))
    return count


@kernel(room="out", i="0..n-1", found="out")
def ranked_first(geometry: Geometry, room: RankScratch, rays: RayArrays, i: int, found: HitBuffers) -> int:
    """Write the first hit of ray i, whose ranks are known. Return `TIED`, or 0 if it hangs on no tie."""
    scratch, (ray, scale) = new_scratch(geometry), scale_ray(load_ray(rays, i))
    count = prepare_ranked_ray(geometry, room, scratch, ray)
    tied = _put_first(geometry, room, scratch, ray, count, scale, i, found)
    clear_stand(room.stand, room.ranks)
    return tied


@kernel(room="out", i="0..n-1")
def ranked_rows(geometry: Geometry, room: RankScratch, rays: RayArrays, i: int, spans: bool) -> Floats:
    """Return rows of the spans or crossings of ray i, whose ranks are known."""
    scratch, own_ray = new_scratch(geometry), load_ray(rays, i)
    rows = np.empty((64, SPAN_COLUMNS if spans else CROSSING_COLUMNS))
    count = prepare_ranked_ray(geometry, room, scratch, scale_ray(own_ray)[0])
    rows, used = rows_of_ranks(geometry, room, scratch, own_ray, count, spans, rows, 0)
    clear_stand(room.stand, room.ranks)
    return rows[:used].copy()


# Drivers: numbers with bounds on several threads, then exact arithmetic for each ray that stays undecided

_DOUBTFUL_CHUNK = 256  # rays that a thread takes at a time, at least


def new_rank_scratch(scene: PreparedScene) -> RankScratch:
    """Return scratch memory for one thread, as large as the scene; pages take memory only once they are written."""
    geometry = scene.geometry
    surfaces, polygons = int(length(geometry, table.SURFACE_KIND)), int(length(geometry, table.POLYGON_SURFACE))
    most = 2 * surfaces + 8

    def ints(count: int) -> Any:
        return mapped_zeros(count, np.int32, sparse=True)

    def real(count: int) -> Any:
        return mapped_zeros(count, np.float64, sparse=True)

    ranks = Ranks(
        ints(surfaces), ints(surfaces), ints(2 * surfaces), ints(surfaces),
        real(most), real(most), real(most), ints(most), real(most), ints(most), real(most),
        real(most), real(2 * most), ints(most), ints(polygons), np.zeros(2, np.int64), scene.absent_terms,
    )  # fmt: skip
    floats = real(len(geometry.floats) + count_form_floats(geometry))
    return RankScratch(scene.rest, Geometry(geometry.places, geometry.integers, floats), ranks)


def share_halt_flag(geometry: Geometry, room: RankScratch) -> RankScratch:
    """Return scratch memory whose canonical scene shares the flag of `geometry` that halts kernels."""
    return room._replace(stand=room.stand._replace(places=geometry.places))


def run_one(scene: PreparedScene, kernel: Callable[..., Any], room: RankScratch, *arguments: Any) -> Any:
    """Run a kernel for one ray or point such that Ctrl-C halts it, and return its result."""
    found: list[Any] = []

    def work(geometry: Geometry, begin: int, end: int) -> None:
        found.append(kernel(geometry, share_halt_flag(geometry, room), *arguments))

    run_on(scene.geometry, work, 1, 1, 1)
    return found[0]


def resolve_hits(scene: PreparedScene, rays: RayArrays, doubtful: Any, found: HitBuffers) -> Any:
    """Decide the first hits of the rays `doubtful`, and write them to `found`. Return which rays hang on a tie."""
    undecided = Doubtful(doubtful.astype(np.int32), np.zeros(len(doubtful), np.int8))
    # Scratch memory is as large as the scene, so chunks reuse it: there is at most one for each thread
    rooms: list[RankScratch] = []

    def work(geometry: Geometry, begin: int, end: int) -> None:
        try:
            room = rooms.pop()
        except IndexError:
            room = new_rank_scratch(scene)
        settle_first(geometry, share_halt_flag(geometry, room), rays, undecided, begin, end, found)
        # list.append and list.pop are atomic, so that no lock is needed
        rooms.append(room)

    count = len(doubtful)
    run_on(scene.geometry, work, count, max(_DOUBTFUL_CHUNK, count // 64), count)
    left = np.flatnonzero(undecided.undecided == 1).tolist()
    if left:
        room = rooms.pop() if rooms else new_rank_scratch(scene)
        for k in left:
            i = int(undecided.which[k])
            put_exact_ranks(scene, room.ranks, rays, i)
            undecided.undecided[k] = run_one(scene, ranked_first, room, rays, i, found)
    return doubtful[undecided.undecided == TIED]


def ranks_of(scene: PreparedScene, rays: RayArrays, i: int) -> tuple[Ranks, bool]:
    """Return the ranks of all crossings of ray i, and whether they needed exact arithmetic.

    For each surface `verdict` and `first` are valid, and from index `first` on `rank`, `high`, `low`, `error` and `t`.
    """
    room, undecided = new_rank_scratch(scene), Doubtful(np.full(1, i, np.int32), np.zeros(1, np.int8))
    # Not `settle_first`: it breaks the ties
    run_one(scene, settle_rows, room, rays, undecided, False, np.zeros(1, np.int32))
    ranks = room.ranks
    if undecided.undecided[0]:
        put_exact_ranks(scene, ranks, rays, i)
    first = ranks.first[ranks.verdict[::2] == CROSSES]
    every = np.concatenate([[0], first, first + 1])
    # Touches have ranks as well: without them crossings count from the origin
    distinct = np.unique(ranks.rank[every])
    ranks.rank[every] = np.searchsorted(distinct, ranks.rank[every]) - np.searchsorted(distinct, 0.0)
    return ranks, bool(undecided.undecided[0])


def resolve_rows(scene: PreparedScene, rays: RayArrays, doubtful: Any, spans: bool) -> list[FloatArray]:
    """Return the rows of the spans or crossings of doubtful rays, an array for each ray."""
    undecided = Doubtful(doubtful.astype(np.int32), np.zeros(len(doubtful), np.int8))
    counts, room = np.zeros(len(doubtful), np.int32), new_rank_scratch(scene)
    found: list[FloatArray] = []

    def work(geometry: Geometry, begin: int, end: int) -> None:
        found.append(settle_rows(geometry, share_halt_flag(geometry, room), rays, undecided, spans, counts))

    run_on(scene.geometry, work, 1, 1, len(doubtful))
    # An undecided ray has no rows yet, and so an empty part
    parts = np.split(found[0], np.cumsum(counts)[:-1])
    for k in np.flatnonzero(undecided.undecided).tolist():
        i = int(undecided.which[k])
        put_exact_ranks(scene, room.ranks, rays, i)
        parts[k] = run_one(scene, ranked_rows, room, rays, i, spans)
    return parts


def resolve_bodies(scene: PreparedScene, points: FloatArray, after: Any, doubtful: Any, bodies: Any) -> None:
    """Decide by exact arithmetic the first body after a number that contains each doubtful point, in place."""
    if not len(doubtful):
        return
    geometry, room = scene.geometry, new_rank_scratch(scene)
    # Canonical surfaces are exact, so that they have no rests
    ranks, no_rest = room.ranks, RoundingRest(*(np.zeros(len(part)) for part in scene.rest))
    for i in doubtful.tolist():
        x, y, z = points[i].tolist()
        here = integer_line((x, y, z), (0.0, 0.0, 0.0))
        for surface in ranks.surfaces[: surfaces_near(geometry, ranks, x, y, z)].tolist():
            ranks.verdict[surface] = sign(exact_form(scene, surface).at(here))
        bodies[i] = run_one(scene, located_by_ranks, room._replace(rest=no_rest), x, y, z, int(_pick(after, i)))


def _pick(values: Any, i: int) -> float:
    """Return item i of an array that has an item for each ray or one for all."""
    return float(values[i if len(values) > 1 else 0])


def put_exact_ranks(scene: PreparedScene, ranks: Ranks, rays: RayArrays, i: int) -> None:
    """Compute the ranks of all crossings of ray i in exact arithmetic, and write them where kernels read them."""
    geometry, tables = scene.geometry, scene.lowered.tables
    entries = np.zeros(len(tables.entry_kind), np.int32)
    surfaces, count = crossed_surfaces(geometry, ranks, rays, i, entries)
    origins, directions, _, _, starts = rays
    ox, oy, oz = origins[i].tolist()
    dx, dy, dz = directions[i].tolist()
    # The scale is a power of two: the ray stays exactly the same
    scaled, _ = scale_ray(Ray(ox, oy, oz, dx, dy, dz, 0.0, 0.0, -1))
    origin, direction = (scaled.ox, scaled.oy, scaled.oz), (scaled.dx, scaled.dy, scaled.dz)
    ray, start = integer_line(origin, direction), int(_pick(starts, i))
    places: list[RayPlace] = [ZERO]  # the origin is the first of the crossings, as in `rank_ray`
    owners, rounded = [FREE], [0.0]
    for surface in ranks.surfaces[:surfaces].tolist():
        found = decide_crossing(exact_form(scene, surface), ray, surface == start)
        ranks.verdict[2 * surface] = CROSSES if found.crosses else TOUCHES if found.touches else MISSES
        ranks.verdict[2 * surface + 1] = found.sense
        if found.crosses or found.touches:
            ranks.first[surface] = len(places)
            owners += [surface, surface]
            places += [found.low, found.high]
            low = float(found.low)
            rounded += [low, low if found.high is found.low else float(found.high)]
    ranks.owner[: len(owners)] = owners
    ranks.rank[: len(places)] = exact_ranks(places)
    ranks.high[: len(places)], ranks.t[: len(places)] = rounded, rounded
    ranks.size[CROSSINGS] = len(places)
    for entry in entries[:count].tolist():
        if tables.entry_kind[entry] == POLYGON:
            polygon = int(tables.entry_index[entry])
            inside, edge = side_of_loop(scene.lowered.exact.outline(polygon), origin, direction)
            ranks.loops[polygon] = inside + (EDGE if edge else 0)
