"""Doubtful rays, decided (see ranks.py): first hits, occlusion, spans and crossings of the few rays that need it."""

from __future__ import annotations

import numpy as np

from ..geometry import tables as table
from ..geometry.decide import CROSSES, Rest
from ..geometry.tables import Floats, Geometry, Ints, Ray, Signs, halted, integer, whole
from ..jit import helper, inline, kernel
from .array_kernels import put_hit
from .bundle import load_ray
from .entries import crossed_face, entry_crossings
from .events import crossing, span_inverse
from .kernels import Hit, collect, no_hit, scaled_ray
from .lists import CROSSING_COLUMNS, SPAN_COLUMNS, ray_rows
from .ranks import (
    Ranks,
    find_leaves,
    forget,
    forget_leaves,
    list_surfaces,
    rank_ray,
    ray_of_ranks,
    t_of,
    tell,
    tell_as_usual,
)  # fmt: skip
from .scratch import Scratch, new_scratch
from .stand_ins import put_stand_ins


@helper
def _first(geometry: Geometry, stand: Geometry, scratch: Scratch, ranks: Ranks, ray: Ray, count: int) -> Hit:
    """The first crossing of a ray whose ranks are known."""
    best, along = no_hit(), ray_of_ranks(ranks, ray[8])
    for k in range(count):
        entry = scratch.found[k]
        find_leaves(geometry, scratch, entry, ray)
        crossings, _, _ = entry_crossings(stand, scratch, entry, along, 1)
        t, place, sense, enters = crossing(scratch, 0)
        body = integer(geometry, table.ENTRY_BODY, entry)
        if crossings > 0 and (t < best[0] or (t == best[0] and body < best[1])):
            best = t, body, whole(entry), place, sense, enters, 0.0, False
    forget_leaves(scratch)
    if best[2] < 0:
        return best
    surface = crossed_face(geometry, best[2], best[3], best[4])[0]
    return t_of(ranks, surface, best[0]), best[1], best[2], best[3], best[4], best[5], 0.0, False


@inline
def _told(ranks: Ranks, surface: float, rank: float, end: float, scale: float) -> float:
    """Where a row's rank is; of a clipped end, the end."""
    return end if surface < 0.0 else t_of(ranks, int(surface), rank) * scale


@helper
def _in_t(ranks: Ranks, rows: Floats, first: int, last: int, given: Ray, scale: float, spans: bool) -> None:
    """From ranks to t, of the length that the ray's direction had."""
    for i in range(first, last):
        rows[i, 0] = _told(ranks, rows[i, 5 if spans else 3], rows[i, 0], given[6], scale)
        if spans:
            rows[i, 2] = _told(ranks, rows[i, 6], rows[i, 2], given[7], scale)


@kernel
def settle_first(
    geometry: Geometry, rest: Rest, stand: Geometry, ranks: Ranks, origins: Floats, directions: Floats,
    t_min: Floats, t_max: Floats, starts: Ints, which: Ints, begin: int, end: int,
    t: Floats, body: Ints, entry: Ints, place: Ints, turn: Signs, still: Signs,
) -> None:  # fmt: skip
    """First hits of rays which[begin:end]; still[k] = 1 where it takes exact arithmetic to decide one."""
    scratch = new_scratch(geometry)
    for k in range(begin, end):
        if halted(geometry):
            break
        i = which[k]
        ray, scale = scaled_ray(load_ray(origins, directions, t_min, t_max, starts, i))
        count = rank_ray(geometry, rest, scratch, ranks, ray, span_inverse(ray))
        still[k] = 1 if count < 0 else 0
        if count >= 0:
            put_stand_ins(geometry, stand, scratch, ranks, ray[8], count)
            hit = _first(geometry, stand, scratch, ranks, ray, count)
            hit = hit[0] * scale, hit[1], hit[2], hit[3], hit[4], hit[5], hit[6], hit[7]
            put_hit(hit, i, t, body, entry, place, turn)
        forget(ranks)


@kernel
def settle_rows(
    geometry: Geometry, rest: Rest, stand: Geometry, ranks: Ranks, origins: Floats, directions: Floats,
    t_min: Floats, t_max: Floats, starts: Ints, which: Ints, spans: bool, counts: Ints, still: Signs,
) -> Floats:  # fmt: skip
    """Spans or crossings of some rays, counts[k] rows for ray which[k]; still[k] = 1 as in `settle_first`."""
    scratch, used = new_scratch(geometry), 0
    rows = np.empty((64, SPAN_COLUMNS if spans else CROSSING_COLUMNS))
    for k in range(len(which)):
        if halted(geometry):
            break
        given = load_ray(origins, directions, t_min, t_max, starts, which[k])
        ray, scale = scaled_ray(given)
        count, first = rank_ray(geometry, rest, scratch, ranks, ray, span_inverse(ray)), used
        still[k] = 1 if count < 0 else 0
        if count >= 0:
            put_stand_ins(geometry, stand, scratch, ranks, ray[8], count)
            rows, used = _rows(geometry, stand, scratch, ranks, ray, given, scale, count, spans, rows, used)
        counts[k] = used - first
        forget(ranks)
    return rows[:used].copy()


@inline
def _rows(
    geometry: Geometry, stand: Geometry, scratch: Scratch, ranks: Ranks, ray: Ray, given: Ray, scale: float,
    count: int, spans: bool, rows: Floats, used: int,
) -> tuple[Floats, int]:  # fmt: skip
    first, along = used, ray_of_ranks(ranks, ray[8])
    rows, used, _ = ray_rows(geometry, stand, scratch, ray, along, count, spans, rows, used)
    _in_t(ranks, rows, first, used, given, scale, spans)
    return rows, used


@kernel
def surfaces_met(
    geometry: Geometry, ranks: Ranks, origins: Floats, directions: Floats, t_min: Floats, t_max: Floats,
    starts: Ints, i: int, entries: Ints,
) -> tuple[int, int]:  # fmt: skip
    """How many surfaces ray i may meet, into ranks.surfaces, and how many entries, into `entries`."""
    scratch = new_scratch(geometry)
    ray, _ = scaled_ray(load_ray(origins, directions, t_min, t_max, starts, i))
    count = collect(geometry, scratch, ray)
    list_surfaces(geometry, scratch, ranks, ray, count)
    found = ranks.size[0]
    entries[:count] = scratch.found[:count]
    forget(ranks)
    return found, count


@inline
def _again(geometry: Geometry, stand: Geometry, scratch: Scratch, ranks: Ranks, ray: Ray) -> int:
    """Go on with a ray whose ranks have come from elsewhere; returns how many entries it may meet."""
    count, inverse = collect(geometry, scratch, ray), span_inverse(ray)
    list_surfaces(geometry, scratch, ranks, ray, count)
    for k in range(ranks.size[0]):
        if ranks.verdict[2 * ranks.surfaces[k]] == CROSSES:
            tell_as_usual(geometry, ranks, ranks.surfaces[k], ray, inverse)
    tell(ranks, ray[6], ray[7])
    put_stand_ins(geometry, stand, scratch, ranks, ray[8], count)
    return count


@kernel
def ranked_first(
    geometry: Geometry, stand: Geometry, ranks: Ranks, origins: Floats, directions: Floats,
    t_min: Floats, t_max: Floats, starts: Ints, i: int, t: Floats, body: Ints, entry: Ints, place: Ints, turn: Signs,
) -> None:  # fmt: skip
    """The first hit of ray i, whose ranks are known."""
    scratch = new_scratch(geometry)
    ray, scale = scaled_ray(load_ray(origins, directions, t_min, t_max, starts, i))
    count = _again(geometry, stand, scratch, ranks, ray)
    hit = _first(geometry, stand, scratch, ranks, ray, count)
    hit = hit[0] * scale, hit[1], hit[2], hit[3], hit[4], hit[5], hit[6], hit[7]
    put_hit(hit, i, t, body, entry, place, turn)
    forget(ranks)


@kernel
def ranked_rows(
    geometry: Geometry, stand: Geometry, ranks: Ranks, origins: Floats, directions: Floats,
    t_min: Floats, t_max: Floats, starts: Ints, i: int, spans: bool,
) -> Floats:  # fmt: skip
    """The spans or crossings of ray i, whose ranks are known."""
    scratch = new_scratch(geometry)
    rows = np.empty((64, SPAN_COLUMNS if spans else CROSSING_COLUMNS))
    given = load_ray(origins, directions, t_min, t_max, starts, i)
    ray, scale = scaled_ray(given)
    count = _again(geometry, stand, scratch, ranks, ray)
    rows, used = _rows(geometry, stand, scratch, ranks, ray, given, scale, count, spans, rows, 0)
    forget(ranks)
    return rows[:used].copy()
