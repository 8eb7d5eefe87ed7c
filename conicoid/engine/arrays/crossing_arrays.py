"""The compiled loops behind spans and crossings: chunks of rays in, rows out, and from rows into columns."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...compiler.jit import allocator, kernel
from ...compiler.shapes import shaped
from ..body.crossing_rows import (
    BODY,
    CROSSING_COLUMNS,
    ENTER,
    ENTER_CLIPPED,
    ENTER_SURFACE,
    ENTERS,
    EXIT,
    EXIT_CLIPPED,
    EXIT_SURFACE,
    FACE,
    SPAN_COLUMNS,
    SURFACE,
    T,
    put_in_order,
    ray_rows,
    scale_rows,
    with_room,
)
from ..body.entry import collect
from ..body.scratch import Scratch, new_scratch
from ..packets.crossing_chains import list_packet, new_chains, put_chain
from ..packets.lanes import DOUBT
from ..packets.load import coherent, fill_lanes, packet_row
from ..packets.packet import new_packet
from ..ray import DEAD, Ray, RayArrays, load_ray, scaled_ray
from ..surface.interval import is_open
from ..tables import Flags, Floats, Geometry, Ints, Longs, Signs, halted


@allocator
def rows_of_ray(
    geometry: Geometry, scratch: Scratch, ray: Ray, spans: bool, rows: Floats, used: int
) -> tuple[Floats, int, bool]:
    """The rows of a ray by itself, from rows[used] on: (rows, how many now, doubtful)."""
    if ray.start == DEAD or not is_open(ray.t_min, ray.t_max) or halted(geometry):
        return rows, used, False
    given = ray
    ray, scale = scaled_ray(given)
    count, first = collect(geometry, scratch, ray), used
    rows, used, unsure = ray_rows(geometry, scratch, ray, count, spans, rows, used)
    scale_rows(rows, first, used, scale, given, spans)
    return rows, used, unsure


@kernel(width="picture n", begin="0..end", end="0..n", counts="out n", doubts="out n")
def trace_rows(
    geometry: Geometry, rays: RayArrays, width: int, spans: bool, begin: int, end: int, counts: Ints, doubts: Signs
) -> Floats:
    """Rows (body/crossing_rows.py) of spans or crossings of packets begin..end of 64 rays, in the order of their lanes.

    counts[i] rows for ray i, sorted; a doubtful ray has doubts[i] = 1, and no rows.
    """
    scratch, bundle, chains = new_scratch(geometry), new_packet(geometry), new_chains()
    columns = SPAN_COLUMNS if spans else CROSSING_COLUMNS
    rows, found, used = np.empty((64 * (end - begin), columns)), np.empty((256, columns + 1)), 0
    lanes = bundle.lanes
    for packet in range(begin, end):
        if halted(geometry):
            break
        fill_lanes(lanes, rays, packet, width, False)
        together, more = coherent(geometry, lanes), 0
        if together:
            found, more = list_packet(geometry, scratch, bundle, chains, spans, found)
            rows = with_room(rows, used, more)
        for row in range(8):
            first, n = packet_row(packet, row, width, len(rays.origins))
            for k in range(n):
                before, lane, unsure = used, 8 * row + k, True
                if together and lanes[DOUBT + np.uint64(lane)] == 0.0:
                    used = put_chain(chains, lane, found, rows, used)
                    unsure = put_in_order(rows, before, used, spans)
                if unsure:
                    ray = load_ray(rays, first + k)
                    rows, used, unsure = rows_of_ray(geometry, scratch, ray, spans, rows, before)
                    rows = with_room(rows, used, more)  # the other lanes' may still be to come
                used = before if unsure else used
                counts[first + k], doubts[first + k] = used - before, 1 if unsure else 0
    return rows[:used].copy()


@kernel(begin="0..end", end="0..n", counts="out n", doubts="out n")
def trace_rows_alone(
    geometry: Geometry, rays: RayArrays, spans: bool, begin: int, end: int, counts: Ints, doubts: Signs
) -> Floats:
    """`trace_rows` of rays begin..end, each by itself: a third of the code, for pages that carry it."""
    scratch, used = new_scratch(geometry), 0
    rows = np.empty((64, SPAN_COLUMNS if spans else CROSSING_COLUMNS))
    for i in range(begin, end):
        before = used
        rows, used, unsure = rows_of_ray(geometry, scratch, load_ray(rays, i), spans, rows, before)
        used = before if unsure else used
        counts[i], doubts[i] = used - before, 1 if unsure else 0
    return rows[:used].copy()


@shaped(t_enter="s", t_exit="s", body="s", clipped="2 s", surfaces="2 s")
class SpanColumns(NamedTuple):
    """Spans of many rays; clipped and surfaces of both ends."""

    t_enter: Floats
    t_exit: Floats
    body: Ints
    clipped: Flags
    surfaces: Ints


@shaped(t="s", body="s", face="s", surface="s", entering="s")
class CrossingColumns(NamedTuple):
    """Crossings of many rays."""

    t: Floats
    body: Ints
    face: Ints
    surface: Ints
    entering: Flags


@allocator
def _places(count: int, counts: Ints, offsets: Longs, width: int, begin: int, end: int) -> Longs:
    """Where `count` rows of packets begin..end belong in columns, in the order in which they were traced."""
    places, done = np.empty(count, np.int64), 0
    for packet in range(begin, end):
        for line in range(8):
            first, n = packet_row(packet, line, width, len(counts))
            for i in range(first, first + n):
                for k in range(min(counts[i], count - done)):
                    places[done] = offsets[i] + k
                    done += 1
    return places[:done]


@kernel(
    rows="* 9", counts="n", offsets="n", width="picture n", begin="0..end", end="0..n", columns="out"
)  # fmt: skip
def put_spans(
    rows: Floats, counts: Ints, offsets: Longs, width: int, begin: int, end: int, columns: SpanColumns
) -> None:
    """Rows of packets begin..end into columns."""
    t_enter, t_exit, body, clipped, surfaces = columns
    places = _places(len(rows), counts, offsets, width, begin, end)
    for k in range(len(places)):
        at = places[k]
        t_enter[at], body[at], t_exit[at] = rows[k, ENTER], rows[k, BODY], rows[k, EXIT]
        clipped[0, at], clipped[1, at] = rows[k, ENTER_CLIPPED] != 0.0, rows[k, EXIT_CLIPPED] != 0.0
        surfaces[0, at], surfaces[1, at] = rows[k, ENTER_SURFACE], rows[k, EXIT_SURFACE]


@kernel(
    rows="* 7", counts="n", offsets="n", width="picture n", begin="0..end", end="0..n", columns="out"
)  # fmt: skip
def put_crossings(
    rows: Floats, counts: Ints, offsets: Longs, width: int, begin: int, end: int, columns: CrossingColumns
) -> None:
    """Rows of packets begin..end into columns."""
    t, body, face, surface, entering = columns
    places = _places(len(rows), counts, offsets, width, begin, end)
    for k in range(len(places)):
        at = places[k]
        t[at], body[at], face[at] = rows[k, T], rows[k, BODY], rows[k, FACE]
        surface[at], entering[at] = rows[k, SURFACE], rows[k, ENTERS] != 0.0
