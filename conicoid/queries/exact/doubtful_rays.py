"""Doubtful rays, decided (see ranks.py): first hits, occlusion, spans and crossings of the few rays that need it."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from ..._jit.decorators import inline, kernel
from ..._util.arrays import FloatArray
from ...geometry.exact_crossings import RayPlace, decide_crossing, exact_ranks, integer_line, is_inside_loop
from ...kernels import tables as table
from ...kernels.body.crossing_rows import CROSSING_COLUMNS, SPAN_COLUMNS
from ...kernels.body.entry import collect_entries, entry_nearness
from ...kernels.body.hit import is_doubtful, scale_hit
from ...kernels.body.scratch import Scratch, new_scratch
from ...kernels.entry.first_hits import HitBuffers, put_hit, trace_first_alone
from ...kernels.ray import Ray, RayArrays, load_ray, scale_ray, span_inverse
from ...kernels.surface.exact_crossing import CROSSES, MISSES, RoundingRest
from ...kernels.tables import POLYGON, Floats, Geometry, Ints, is_halted, length
from ...kernels.threads import chunk_size, run_on
from ...numerics.quadratic_roots import ZERO, sign
from ...prepare.mmap_arrays import mapped_zeros
from .canonical_surfaces import count_form_floats, put_canonical_surfaces
from .membership import located_by_ranks, surfaces_near
from .ranks import (
    CROSSINGS,
    SURFACES,
    Doubtful,
    Ranks,
    RankScratch,
    clear_ranks,
    first_of_ranks,
    list_surfaces,
    rank_ray,
    report_fast_t,
    rows_of_ranks,
)
from .surface_forms import exact_form

if TYPE_CHECKING:
    from ...prepare.prepared_scene import PreparedScene


@kernel(room="out", doubtful="out", begin="0..end", end="0..m", found="out")
def settle_first(
    geometry: Geometry, room: RankScratch, rays: RayArrays, doubtful: Doubtful, begin: int, end: int, found: HitBuffers
) -> None:
    """First hits of doubtful rays begin to end. Those whose ranks stay open keep theirs, with still[k] = 1."""
    scratch = new_scratch(geometry)
    rest, stand, ranks = room
    which, still = doubtful
    for k in range(begin, end):
        if is_halted(geometry):
            break
        i = which[k]
        ray, scale = scale_ray(load_ray(rays, i))
        count = rank_ray(geometry, rest, scratch, ranks, ray, span_inverse(ray))
        still[k] = 1 if count < 0 else 0
        if count >= 0:
            put_canonical_surfaces(geometry, stand, scratch, ranks, ray.start, count)
            hit = first_of_ranks(geometry, stand, scratch, ranks, ray, count)
            hit = scale_hit(hit, scale)
            put_hit(hit, i, found)
        clear_ranks(ranks)


@kernel(t="n", entry="n", limits="out n")
def limits_of_hits(geometry: Geometry, rays: RayArrays, t: Floats, entry: Ints, limits: Floats) -> None:
    """limits[k]: the t up to which ray k decides its hit: as far as another crossing may be the first, or its end.

    The rays are to start on surfaces, where the limits of what is certain are widest.
    """
    for k in range(len(limits)):
        given = load_ray(rays, k)
        ray, scale = scale_ray(given)
        limits[k] = given.t_max
        if entry[k] >= 0:
            limits[k] = min(limits[k], t[k] + entry_nearness(geometry, entry[k], ray).off * scale)


@kernel(room="out", doubtful="out", counts="out m")
def settle_rows(
    geometry: Geometry, room: RankScratch, rays: RayArrays, doubtful: Doubtful, spans: bool, counts: Ints
) -> Floats:
    """Spans or crossings of doubtful rays, counts[k] rows for number k of them; none, and still[k] = 1, if open."""
    scratch, used = new_scratch(geometry), 0
    rest, stand, ranks = room
    which, still = doubtful
    rows = np.empty((64, SPAN_COLUMNS if spans else CROSSING_COLUMNS))
    for k in range(len(which)):
        if is_halted(geometry):
            break
        given = load_ray(rays, which[k])
        ray, _ = scale_ray(given)
        count, first = rank_ray(geometry, rest, scratch, ranks, ray, span_inverse(ray)), used
        still[k] = 1 if count < 0 else 0
        if count >= 0:
            put_canonical_surfaces(geometry, stand, scratch, ranks, ray.start, count)
            rows, used = rows_of_ranks(geometry, room, scratch, given, count, spans, rows, used)
        counts[k] = used - first
        clear_ranks(ranks)
    return rows[:used].copy()


@kernel(ranks="out", i="0..n-1", entries="out entry_kind")
def surfaces_met(geometry: Geometry, ranks: Ranks, rays: RayArrays, i: int, entries: Ints) -> tuple[int, int]:
    """How many surfaces ray i may meet, into ranks.surfaces, and how many entries, into `entries`."""
    scratch = new_scratch(geometry)
    ray, _ = scale_ray(load_ray(rays, i))
    count = collect_entries(geometry, scratch, ray)
    list_surfaces(geometry, scratch, ranks, ray, count)
    found = ranks.size[SURFACES]
    for k in range(count):
        entries[k] = scratch.found[k]
    clear_ranks(ranks)
    return found, count


@inline
def prepare_ranked_ray(geometry: Geometry, stand: Geometry, scratch: Scratch, ranks: Ranks, ray: Ray) -> int:
    """Prepare to trace a ray whose ranks were found in exact arithmetic; returns how many entries it may meet."""
    count, inverse = collect_entries(geometry, scratch, ray), span_inverse(ray)
    list_surfaces(geometry, scratch, ranks, ray, count)
    for k in range(ranks.size[SURFACES]):
        if ranks.verdict[2 * ranks.surfaces[k]] == CROSSES:
            report_fast_t(geometry, ranks, ranks.surfaces[k], ray, inverse)
    put_canonical_surfaces(geometry, stand, scratch, ranks, ray.start, count)
    return count


@kernel(room="out", i="0..n-1", found="out")
def ranked_first(geometry: Geometry, room: RankScratch, rays: RayArrays, i: int, found: HitBuffers) -> None:
    """The first hit of ray i, whose ranks are known."""
    scratch, stand, ranks = new_scratch(geometry), room.stand, room.ranks
    ray, scale = scale_ray(load_ray(rays, i))
    count = prepare_ranked_ray(geometry, stand, scratch, ranks, ray)
    hit = first_of_ranks(geometry, stand, scratch, ranks, ray, count)
    hit = scale_hit(hit, scale)
    put_hit(hit, i, found)
    clear_ranks(ranks)


@kernel(room="out", i="0..n-1")
def ranked_rows(geometry: Geometry, room: RankScratch, rays: RayArrays, i: int, spans: bool) -> Floats:
    """The spans or crossings of ray i, whose ranks are known."""
    scratch, stand, ranks = new_scratch(geometry), room.stand, room.ranks
    rows = np.empty((64, SPAN_COLUMNS if spans else CROSSING_COLUMNS))
    given = load_ray(rays, i)
    ray, _ = scale_ray(given)
    count = prepare_ranked_ray(geometry, stand, scratch, ranks, ray)
    rows, used = rows_of_ranks(geometry, room, scratch, given, count, spans, rows, 0)
    clear_ranks(ranks)
    return rows[:used].copy()


# Doubtful rays and points, decided: by numbers with bounds first, by exact arithmetic where those leave it open.

_DOUBTFUL_CHUNK = 256


def new_rank_scratch(scene: PreparedScene) -> RankScratch:
    """Room for one thread, as large as the scene. Memory is taken only where it is written to."""
    geometry = scene.geometry
    surfaces, polygons = int(length(geometry, table.SURFACE_KIND)), int(length(geometry, table.POLYGON_SURFACE))
    most = 2 * surfaces + 8

    def whole(count: int) -> Any:
        return mapped_zeros(count, np.int32, sparse=True)

    def real(count: int) -> Any:
        return mapped_zeros(count, np.float64, sparse=True)

    ranks = Ranks(
        whole(surfaces), whole(surfaces), whole(2 * surfaces), whole(surfaces),
        real(most), real(most), real(most), whole(most), real(most), whole(most), real(most),
        whole(polygons), np.zeros(2, np.int64),
    )  # fmt: skip
    floats = real(len(geometry.floats) + count_form_floats(geometry))
    return RankScratch(scene.rest, Geometry(geometry.places, geometry.integers, floats), ranks)


def share_halt_flag(geometry: Geometry, room: RankScratch) -> RankScratch:
    """The room, whose stand-ins share the flag of `geometry` that ends kernels early."""
    return room._replace(stand=room.stand._replace(places=geometry.places))


def run_one(scene: PreparedScene, kernel: Callable[..., Any], room: RankScratch, *arguments: Any) -> Any:
    """Run a kernel for one ray or point, so that it ends early at Ctrl-C; returns its result."""
    found: list[Any] = []

    def work(geometry: Geometry, begin: int, end: int) -> None:
        found.append(kernel(geometry, share_halt_flag(geometry, room), *arguments))

    run_on(scene.geometry, work, 1, 1, 1)
    return found[0]


def resolve_hits(scene: PreparedScene, rays: RayArrays, doubtful: Any, found: HitBuffers) -> None:
    """Decide the first hits of rays that may be doubtful, in place."""
    asked = Doubtful(doubtful.astype(np.int32), np.zeros(len(doubtful), np.int8))
    rooms: list[RankScratch] = []  # as large as the scene, so one for each thread, which its chunks use in turn

    def work(geometry: Geometry, begin: int, end: int) -> None:
        try:
            room = rooms.pop()
        except IndexError:
            room = new_rank_scratch(scene)
        settle_first(geometry, share_halt_flag(geometry, room), rays, asked, begin, end, found)
        rooms.append(room)

    count = len(doubtful)
    run_on(scene.geometry, work, count, max(_DOUBTFUL_CHUNK, count // 64), count)
    left = asked.which[asked.still == 1].tolist()
    if left:
        room = rooms.pop() if rooms else new_rank_scratch(scene)
        for i in left:
            rank_exactly(scene, room.ranks, rays, i)
            run_one(scene, ranked_first, room, rays, i, found)


def ranks_of(scene: PreparedScene, rays: RayArrays, i: int) -> tuple[Ranks, bool]:
    """The ranks of all that ray i may cross, as a doubtful ray has them, and whether it took exact arithmetic.

    Of each surface `verdict`, `first` and from there on `rank`, `high`, `low`, `error` and `t` are filled in.
    """
    room, asked = new_rank_scratch(scene), Doubtful(np.full(1, i, np.int32), np.zeros(1, np.int8))
    run_one(scene, settle_first, room, rays, asked, 0, 1, HitBuffers.new(len(rays.origins)))
    if asked.still[0]:
        rank_exactly(scene, room.ranks, rays, i)
    return room.ranks, bool(asked.still[0])


def filter_doubtful(scene: PreparedScene, rays: RayArrays, which: Any, found: HitBuffers) -> Any:
    """Those of some settled rays that the fast formulas leave open up to their hits, each asked alone.

    Different routes test different bodies beyond the hit, which may be doubtful too; the answer must not depend on it.
    """
    some = rays.some(which)
    t, entry, limits = found.t[which], found.entry[which], np.empty(len(which))
    limits_of_hits(scene.geometry, some._replace(starts=entry), t, entry, limits)
    again, count = HitBuffers.new(len(which)), len(which)

    def work(geometry: Geometry, begin: int, end: int) -> None:
        trace_first_alone(geometry, some._replace(t_max=limits), begin, end, again)

    run_on(scene.geometry, work, count, chunk_size(count, 16 * _DOUBTFUL_CHUNK), count)
    return which[is_doubtful(again.turn)]


def resolve_rows(scene: PreparedScene, rays: RayArrays, doubtful: Any, spans: bool) -> list[FloatArray]:
    """The rows of doubtful rays' spans or crossings, an array for each."""
    asked = Doubtful(doubtful.astype(np.int32), np.zeros(len(doubtful), np.int8))
    counts, room = np.zeros(len(doubtful), np.int32), new_rank_scratch(scene)
    found: list[FloatArray] = []

    def work(geometry: Geometry, begin: int, end: int) -> None:
        found.append(settle_rows(geometry, share_halt_flag(geometry, room), rays, asked, spans, counts))

    run_on(scene.geometry, work, 1, 1, len(doubtful))
    parts = np.split(found[0], np.cumsum(counts)[:-1])
    for k in np.flatnonzero(asked.still).tolist():
        i = int(asked.which[k])
        rank_exactly(scene, room.ranks, rays, i)
        parts[k] = run_one(scene, ranked_rows, room, rays, i, spans)
    return parts


def resolve_bodies(scene: PreparedScene, points: FloatArray, after: Any, doubtful: Any, bodies: Any) -> None:
    """Decide in which bodies doubtful points are, the first after a number, in place, by exact arithmetic."""
    if not len(doubtful):
        return
    geometry, room = scene.geometry, new_rank_scratch(scene)
    ranks, nothing = room.ranks, RoundingRest(*(np.zeros(len(part)) for part in scene.rest))
    for i in doubtful.tolist():
        x, y, z = points[i].tolist()
        here = integer_line((x, y, z), (0.0, 0.0, 0.0))
        for surface in ranks.surfaces[: surfaces_near(geometry, ranks, x, y, z)].tolist():
            ranks.verdict[surface] = sign(exact_form(scene, surface).at(here))
        bodies[i] = run_one(scene, located_by_ranks, room._replace(rest=nothing), x, y, z, int(_pick(after, i)))


def _pick(values: Any, i: int) -> float:
    """Value i of an array of one value for all, or of one for each."""
    return float(values[i if len(values) > 1 else 0])


def rank_exactly(scene: PreparedScene, ranks: Ranks, rays: RayArrays, i: int) -> None:
    """Find the ranks of all that ray i may cross in exact arithmetic, and write them where kernels read them."""
    geometry, tables = scene.geometry, scene.lowered.tables
    entries = np.zeros(len(tables.entry_kind), np.int32)
    surfaces, count = surfaces_met(geometry, ranks, rays, i, entries)
    origins, directions, _, _, starts = rays
    ox, oy, oz = origins[i].tolist()
    dx, dy, dz = directions[i].tolist()
    scaled, _ = scale_ray(Ray(ox, oy, oz, dx, dy, dz, 0.0, 0.0, -1))
    origin, direction = (scaled.ox, scaled.oy, scaled.oz), (scaled.dx, scaled.dy, scaled.dz)
    ray, start = integer_line(origin, direction), int(_pick(starts, i))
    places: list[RayPlace] = [ZERO]
    for surface in ranks.surfaces[:surfaces].tolist():
        found = decide_crossing(exact_form(scene, surface), ray, surface == start)
        ranks.verdict[2 * surface : 2 * surface + 2] = CROSSES if found.crosses else MISSES, found.sense
        if found.crosses:
            ranks.first[surface] = len(places)
            places += [found.low, found.high]
    ranks.rank[: len(places)] = exact_ranks(places)
    told = [float(t) for t in places]
    ranks.high[: len(places)], ranks.t[: len(places)] = told, told
    ranks.size[CROSSINGS] = len(places)
    for entry in entries[:count].tolist():
        if tables.entry_kind[entry] == POLYGON:
            polygon = int(tables.entry_index[entry])
            ranks.loops[polygon] = is_inside_loop(scene.lowered.exact.outline(polygon), origin, direction)
