"""Doubtful rays, decided (see ranks.py): first hits, occlusion, spans and crossings of the few rays that need it."""

from __future__ import annotations

import numpy as np

from ...compiler.jit import inline, kernel
from ..arrays.found import Found, put_hit
from ..body.crossing_rows import CROSSING_COLUMNS, SPAN_COLUMNS
from ..body.entry import collect, entry_nearness
from ..body.hit import scaled_hit
from ..body.scratch import Scratch, new_scratch
from ..ray import Ray, RayArrays, load_ray, scaled_ray, span_inverse
from ..surface.decide import CROSSES
from ..tables import Floats, Geometry, Ints, halted
from .ranked import first_of_ranks, rows_of_ranks
from .ranks import SURFACES, Doubtful, Ranks, Room, forget, list_surfaces, rank_ray, tell_as_usual
from .stand_ins import put_stand_ins


@kernel(room="out", doubtful="out", begin="0..end", end="0..m", found="out")
def settle_first(
    geometry: Geometry, room: Room, rays: RayArrays, doubtful: Doubtful, begin: int, end: int, found: Found
) -> None:
    """First hits of doubtful rays begin to end. Those whose ranks stay open keep theirs, with still[k] = 1."""
    scratch = new_scratch(geometry)
    rest, stand, ranks = room
    which, still = doubtful
    for k in range(begin, end):
        if halted(geometry):
            break
        i = which[k]
        ray, scale = scaled_ray(load_ray(rays, i))
        count = rank_ray(geometry, rest, scratch, ranks, ray, span_inverse(ray))
        still[k] = 1 if count < 0 else 0
        if count >= 0:
            put_stand_ins(geometry, stand, scratch, ranks, ray.start, count)
            hit = first_of_ranks(geometry, stand, scratch, ranks, ray, count)
            hit = scaled_hit(hit, scale)
            put_hit(hit, i, found)
        forget(ranks)


@kernel(t="n", entry="n", limits="out n")
def limits_of_hits(geometry: Geometry, rays: RayArrays, t: Floats, entry: Ints, limits: Floats) -> None:
    """limits[k]: the t up to which ray k decides its hit: as far as another crossing may be the first, or its end.

    The rays are to start on surfaces, where the limits of what is certain are widest.
    """
    for k in range(len(limits)):
        given = load_ray(rays, k)
        ray, scale = scaled_ray(given)
        limits[k] = given.t_max
        if entry[k] >= 0:
            limits[k] = min(limits[k], t[k] + entry_nearness(geometry, entry[k], ray).off * scale)


@kernel(room="out", doubtful="out", counts="out m")
def settle_rows(
    geometry: Geometry, room: Room, rays: RayArrays, doubtful: Doubtful, spans: bool, counts: Ints
) -> Floats:
    """Spans or crossings of doubtful rays, counts[k] rows for number k of them; none, and still[k] = 1, if open."""
    scratch, used = new_scratch(geometry), 0
    rest, stand, ranks = room
    which, still = doubtful
    rows = np.empty((64, SPAN_COLUMNS if spans else CROSSING_COLUMNS))
    for k in range(len(which)):
        if halted(geometry):
            break
        given = load_ray(rays, which[k])
        ray, _ = scaled_ray(given)
        count, first = rank_ray(geometry, rest, scratch, ranks, ray, span_inverse(ray)), used
        still[k] = 1 if count < 0 else 0
        if count >= 0:
            put_stand_ins(geometry, stand, scratch, ranks, ray.start, count)
            rows, used = rows_of_ranks(geometry, room, scratch, given, count, spans, rows, used)
        counts[k] = used - first
        forget(ranks)
    return rows[:used].copy()


@kernel(ranks="out", i="0..n-1", entries="out entry_kind")
def surfaces_met(geometry: Geometry, ranks: Ranks, rays: RayArrays, i: int, entries: Ints) -> tuple[int, int]:
    """How many surfaces ray i may meet, into ranks.surfaces, and how many entries, into `entries`."""
    scratch = new_scratch(geometry)
    ray, _ = scaled_ray(load_ray(rays, i))
    count = collect(geometry, scratch, ray)
    list_surfaces(geometry, scratch, ranks, ray, count)
    found = ranks.size[SURFACES]
    for k in range(count):
        entries[k] = scratch.found[k]
    forget(ranks)
    return found, count


@inline
def again(geometry: Geometry, stand: Geometry, scratch: Scratch, ranks: Ranks, ray: Ray) -> int:
    """Prepare to trace a ray whose ranks were found in exact arithmetic; returns how many entries it may meet."""
    count, inverse = collect(geometry, scratch, ray), span_inverse(ray)
    list_surfaces(geometry, scratch, ranks, ray, count)
    for k in range(ranks.size[SURFACES]):
        if ranks.verdict[2 * ranks.surfaces[k]] == CROSSES:
            tell_as_usual(geometry, ranks, ranks.surfaces[k], ray, inverse)
    put_stand_ins(geometry, stand, scratch, ranks, ray.start, count)
    return count


@kernel(room="out", i="0..n-1", found="out")
def ranked_first(geometry: Geometry, room: Room, rays: RayArrays, i: int, found: Found) -> None:
    """The first hit of ray i, whose ranks are known."""
    scratch, stand, ranks = new_scratch(geometry), room.stand, room.ranks
    ray, scale = scaled_ray(load_ray(rays, i))
    count = again(geometry, stand, scratch, ranks, ray)
    hit = first_of_ranks(geometry, stand, scratch, ranks, ray, count)
    hit = scaled_hit(hit, scale)
    put_hit(hit, i, found)
    forget(ranks)


@kernel(room="out", i="0..n-1")
def ranked_rows(geometry: Geometry, room: Room, rays: RayArrays, i: int, spans: bool) -> Floats:
    """The spans or crossings of ray i, whose ranks are known."""
    scratch, stand, ranks = new_scratch(geometry), room.stand, room.ranks
    rows = np.empty((64, SPAN_COLUMNS if spans else CROSSING_COLUMNS))
    given = load_ray(rays, i)
    ray, _ = scaled_ray(given)
    count = again(geometry, stand, scratch, ranks, ray)
    rows, used = rows_of_ranks(geometry, room, scratch, given, count, spans, rows, 0)
    forget(ranks)
    return rows[:used].copy()
