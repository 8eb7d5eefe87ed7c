"""Kernels for all crossings or spans of many rays: rays to sorted rows, rows to columns, and the ray of each row."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..._jit.decorators import allocator, kernel, record_shapes
from ..._util.arrays import FloatArray
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
    grow_rows,
    ray_rows,
    scale_rows,
    sort_rows,
)
from ..body.entry import collect_entries
from ..body.scratch import Scratch, new_scratch
from ..packet.crossing_chains import list_packet, new_chains, put_chain
from ..packet.lanes import DOUBT, fill_lanes, is_coherent, packet_row
from ..packet.packet import new_packet
from ..ray import DEAD, Ray, RayArrays, load_ray, scale_ray
from ..surface.interval import is_open
from ..tables import Flags, Floats, Geometry, Ints, Longs, Signs, is_halted
from ..threads import run_chunks


@allocator
def rows_of_ray(
    geometry: Geometry, scratch: Scratch, ray: Ray, spans: bool, rows: Floats, used: int
) -> tuple[Floats, int, bool]:
    """Append the rows of a single ray at rows[used]: (rows, number of rows now, doubtful)."""
    if ray.start == DEAD or not is_open(ray.t_min, ray.t_max) or is_halted(geometry):
        return rows, used, False
    unscaled = ray
    ray, scale = scale_ray(unscaled)
    count, first = collect_entries(geometry, scratch, ray), used
    rows, used, unsure = ray_rows(geometry, scratch, ray, count, spans, rows, used)
    scale_rows(rows, first, used, scale, unscaled, spans)
    return rows, used, unsure


@kernel(width="picture n", begin="0..end", end="0..n", counts="out n", doubts="out n")
def trace_rows(
    geometry: Geometry, rays: RayArrays, width: int, spans: bool, begin: int, end: int, counts: Ints, doubts: Signs
) -> Floats:
    """Return rows (body/crossing_rows.py) of spans or crossings of packets begin..end of 64 rays, in order of lanes.

    Ray i has counts[i] rows, sorted. A doubtful ray has doubts[i] = 1 and no rows.
    """
    scratch, bundle, chains = new_scratch(geometry), new_packet(geometry), new_chains()
    columns = SPAN_COLUMNS if spans else CROSSING_COLUMNS
    rows, found, used = np.empty((64 * (end - begin), columns)), np.empty((256, columns + 1)), 0
    lanes = bundle.lanes
    for packet in range(begin, end):
        if is_halted(geometry):
            break
        fill_lanes(lanes, rays, packet, width, False)
        together, more = is_coherent(geometry, lanes), 0
        if together:  # the rows of all lanes come first, chained by lane, and are then copied lane by lane
            found, more = list_packet(geometry, scratch, bundle, chains, spans, found)
            rows = grow_rows(rows, used, more)
        for row in range(8):
            first, n = packet_row(packet, row, width, len(rays.origins))
            for k in range(n):
                before, lane, unsure = used, 8 * row + k, True
                if together and lanes[DOUBT + np.uint64(lane)] == 0.0:
                    used = put_chain(chains, lane, found, rows, used)
                    unsure = sort_rows(rows, before, used, spans)
                if unsure:
                    ray = load_ray(rays, first + k)
                    rows, used, unsure = rows_of_ray(geometry, scratch, ray, spans, rows, before)
                    rows = grow_rows(rows, used, more)  # room for the lanes that follow
                used = before if unsure else used  # a doubtful ray gives its rows up
                counts[first + k], doubts[first + k] = used - before, 1 if unsure else 0
    return rows[:used].copy()


@kernel(begin="0..end", end="0..n", counts="out n", doubts="out n")
def trace_rows_alone(
    geometry: Geometry, rays: RayArrays, spans: bool, begin: int, end: int, counts: Ints, doubts: Signs
) -> Floats:
    """`trace_rows` of rays begin..end, one at a time: a third of the code, for exported pages that carry it."""
    scratch, used = new_scratch(geometry), 0
    rows = np.empty((64, SPAN_COLUMNS if spans else CROSSING_COLUMNS))
    for i in range(begin, end):
        before = used
        rows, used, unsure = rows_of_ray(geometry, scratch, load_ray(rays, i), spans, rows, before)
        used = before if unsure else used
        counts[i], doubts[i] = used - before, 1 if unsure else 0
    return rows[:used].copy()


@record_shapes(t_enter="s", t_exit="s", body="s", clipped="2 s", surfaces="2 s")
class SpanColumns(NamedTuple):
    """Spans of many rays, a column each; `clipped` and `surfaces` have a row for the entry and one for the exit."""

    t_enter: Floats
    t_exit: Floats
    body: Ints
    clipped: Flags
    surfaces: Ints


@record_shapes(t="s", body="s", face="s", surface="s", entering="s")
class CrossingColumns(NamedTuple):
    """Crossings of many rays, a column each."""

    t: Floats
    body: Ints
    face: Ints
    surface: Ints
    entering: Flags


@allocator
def _places(count: int, counts: Ints, offsets: Longs, width: int, begin: int, end: int) -> Longs:
    """Return the place in the columns of each of `count` rows of packets begin..end, in the order of tracing.

    Packets of a picture are tiles, so the rows of a packet are not consecutive in the columns.
    """
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
    """Write rows of spans of packets begin..end into columns; ray i has the places from offsets[i] on."""
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
    """Write rows of crossings of packets begin..end into columns; ray i has the places from offsets[i] on."""
    t, body, face, surface, entering = columns
    places = _places(len(rows), counts, offsets, width, begin, end)
    for k in range(len(places)):
        at = places[k]
        t[at], body[at], face[at] = rows[k, T], rows[k, BODY], rows[k, FACE]
        surface[at], entering[at] = rows[k, SURFACE], rows[k, ENTERS] != 0.0


# Rows of many rays, in pieces as the threads traced them


@dataclass(frozen=True)
class _Piece:
    """Rows (body/crossing_rows.py) of packets begin..end; ray i has counts[i] of them, at places from offsets[i] on."""

    rows: FloatArray
    counts: Any
    offsets: Any
    width: int
    begin: int
    end: int


@dataclass(frozen=True)
class CrossingLists:
    """The rows of all rays, in pieces; the columns hold those of ray i at offsets[i]:offsets[i + 1]."""

    offsets: Any
    pieces: list[_Piece]

    def put(self, kernel: Callable[..., None], columns: Any) -> None:
        """Write all rows into columns, by `put_spans` or `put_crossings`, and make the columns read-only."""

        def work(begin: int, end: int) -> None:
            """Write the pieces begin..end."""
            for p in self.pieces[begin:end]:
                kernel(p.rows, p.counts, p.offsets, p.width, p.begin, p.end, columns)

        run_chunks(work, len(self.pieces), 1)
        for column in (self.offsets, *columns):
            column.flags.writeable = False


IntArray = npt.NDArray[np.int64]


def row_owners(offsets: IntArray) -> IntArray:
    """Return the ray of each row, int64: rows offsets[k]:offsets[k + 1] belong to ray k."""
    # NumPy counts by `intp`, which has 32 bits in WebAssembly
    return np.repeat(np.arange(len(offsets) - 1, dtype=np.int64), np.diff(offsets).astype(np.intp, copy=False))
