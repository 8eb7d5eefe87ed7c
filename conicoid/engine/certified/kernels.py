"""Doubtful rays, decided (see ranks.py): first hits, occlusion, spans and crossings of the few rays that need it."""

from __future__ import annotations

import numpy as np

from ...compiler.jit import inline, kernel
from ..arrays.first import put_hit
from ..body.entry import collect, entry_nearness
from ..body.hit import scaled_hit
from ..body.rows import CROSSING_COLUMNS, SPAN_COLUMNS
from ..body.scratch import Scratch, new_scratch
from ..ray import Ray, load_ray, scaled_ray, span_inverse
from ..surface.decide import CROSSES, Rest
from ..tables import Floats, Geometry, Ints, Signs, halted
from .ranked import first_of_ranks, rows_of_ranks
from .ranks import Ranks, forget, list_surfaces, rank_ray, tell_as_usual
from .stand_ins import put_stand_ins


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
            put_stand_ins(geometry, stand, scratch, ranks, ray.start, count)
            hit = first_of_ranks(geometry, stand, scratch, ranks, ray, count)
            hit = scaled_hit(hit, scale)
            put_hit(hit, i, t, body, entry, place, turn)
        forget(ranks)


@kernel
def limits_of_hits(
    geometry: Geometry, origins: Floats, directions: Floats, t_max: Floats, t: Floats, entry: Ints, limits: Floats
) -> None:
    """limits[k]: how far ray k has to be looked at for its hit: as far as another may be the first, or to its end."""
    for k in range(len(limits)):
        ray, scale = scaled_ray(load_ray(origins, directions, t_max, t_max, entry, k))
        limits[k] = t_max[k if len(t_max) > 1 else 0]
        if entry[k] >= 0:
            limits[k] = min(limits[k], t[k] + entry_nearness(geometry, entry[k], ray).off * scale)


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
            put_stand_ins(geometry, stand, scratch, ranks, ray.start, count)
            rows, used = rows_of_ranks(geometry, stand, scratch, ranks, ray, given, scale, count, spans, rows, used)
        counts[k] = used - first
        forget(ranks)
    return rows[:used].copy()


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
    put_stand_ins(geometry, stand, scratch, ranks, ray.start, count)
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
    hit = first_of_ranks(geometry, stand, scratch, ranks, ray, count)
    hit = scaled_hit(hit, scale)
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
    rows, used = rows_of_ranks(geometry, stand, scratch, ranks, ray, given, scale, count, spans, rows, 0)
    forget(ranks)
    return rows[:used].copy()
