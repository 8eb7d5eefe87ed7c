"""A ray whose ranks are known (see ranks.py): which of a body's crossings lie within its interval, and where.

The origin is the rank 0. Other ends of an interval are compared with the reported t of a crossing, each body
separately, as the fast formulas do: so first hits, occlusion, spans and crossings agree on what an interval holds,
whichever of them took the fast formulas. Where reported t are not in the order of the ranks, a later crossing
is within the interval if the one before it is.
"""

from __future__ import annotations

import math

import numpy as np

from ...compiler.jit import allocator, helper, inline
from ..body.boolean import crossing, leaves_met, put_crossing
from ..body.crossing_rows import (
    ENTER,
    ENTER_CLIPPED,
    ENTER_OFF,
    EXIT,
    EXIT_CLIPPED,
    EXIT_OFF,
    OFF,
    Met,
    T,
    put_in_order,
    put_rows,
    with_room,
)
from ..body.entry import crossed_face, entry_crossings, is_solid
from ..body.hit import Hit, comes_first, no_hit
from ..body.scratch import KNOWN, TIME, Scratch
from ..ray import Ray, scaled_ray
from ..tables import Floats, Geometry, whole
from .ranks import Ranks, Room, entry_program, ray_of_ranks, t_of


@inline
def find_leaves(geometry: Geometry, scratch: Scratch, entry: int, ray: Ray) -> None:
    """Find the leaves of an entry that the true ray may meet: a ray of ranks cannot be tested against their boxes."""
    program = entry_program(geometry, entry)
    forget_leaves(scratch)
    if program >= 0:
        scratch.found_leaves[KNOWN] = leaves_met(geometry, scratch, program, ray)


@inline
def forget_leaves(scratch: Scratch) -> None:
    """Undo `find_leaves`."""
    scratch.found_leaves[KNOWN] = -1


@inline
def _told(geometry: Geometry, scratch: Scratch, ranks: Ranks, entry: int, n: int) -> tuple[float, float]:
    """(rank, t) of crossing n of an entry."""
    rank, place, sense, _ = crossing(scratch, n)
    return rank, t_of(ranks, crossed_face(geometry, entry, place, sense)[0], rank)


@helper
def told_crossings(
    geometry: Geometry, stand: Geometry, scratch: Scratch, ranks: Ranks, entry: int, ray: Ray
) -> tuple[int, bool]:
    """(number of an entry's crossings in (t_min, t_max), inside just after t_min); they are in scratch, t is a rank.

    The reported t of each is in scratch.time[TIME * n].
    """
    count, inside, _ = entry_crossings(stand, scratch, entry, ray_of_ranks(ray.start), 1 << 30)
    first = 0
    while first < count:
        rank, t = _told(geometry, scratch, ranks, entry, first)
        if rank > 0.0 if ray.t_min == 0.0 else t > ray.t_min:
            break
        inside = not inside
        first += 1
    for k in range(first, count):
        rank, t = _told(geometry, scratch, ranks, entry, k)
        if rank >= 0.0 if ray.t_max == 0.0 else t >= ray.t_max:
            return k - first, inside
        _, place, sense, enters = crossing(scratch, k)
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
        crossings, _ = told_crossings(geometry, stand, scratch, ranks, entry, ray)
        rank, place, sense, enters = crossing(scratch, 0)
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
def _in_t(rows: Floats, first: int, last: int, given: Ray, scale: float, spans: bool) -> None:
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
    geometry: Geometry, room: Room, scratch: Scratch, given: Ray, count: int, spans: bool, rows: Floats, used: int
) -> tuple[Floats, int]:
    """Rows (body/crossing_rows.py) of the entries scratch.found[:count] from rows[used] on: (rows, how many now)."""
    (ray, scale), stand, ranks = scaled_ray(given), room.stand, room.ranks
    first, along = used, ray_of_ranks(ray.start)
    for k in range(count):
        entry = scratch.found[k]
        if spans and not is_solid(geometry, entry):
            continue
        find_leaves(geometry, scratch, entry, ray)
        crossings, inside = told_crossings(geometry, stand, scratch, ranks, entry, ray)
        if crossings > 0 or inside:
            rows = with_room(rows, used, crossings + 1)
            put_rows(geometry, scratch, entry, Met(crossings, inside, 0.0, False), along, spans, rows, used)
            used = _put_places(scratch, crossings, inside, spans, rows, used)
    forget_leaves(scratch)
    put_in_order(rows, first, used, spans)
    _in_t(rows, first, used, given, scale, spans)
    return rows, used
