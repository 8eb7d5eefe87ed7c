"""Kernels for all crossings or spans of many rays: rays to sorted rows, rows to columns, and the ray of each row.

They choose the route of each ray, as those for first hits do (first_hits.py).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from .._jit.decorators import allocator, helper, inline, kernel, record_shapes
from .._util.arrays import FloatArray
from .._util.records import dataclass
from . import tables as table
from .body.boolean import put_event, sort_events, sweep_events
from .body.cell import CellSpans
from .body.crossing_rows import (
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
    BodyRows,
    T,
    grow_rows,
    put_rows,
    ray_rows,
    scale_rows,
    sort_rows,
)
from .body.entry import collect_entries, crossings_of_roots, crossings_of_spans, entry_crossings, entry_nearness
from .body.scratch import Scratch, new_scratch
from .bvh.culling import balls_in_beam, highest_bit, lowest_bit
from .bvh.walk import LeafItem, is_round, leaf_at, leaf_item, leaf_range, next_leaf, push_roots, scene_tree
from .packet.booleans import MOST, fits_in_lanes, leaves_of_lanes
from .packet.cells import IN, LEAF, OUT, PLACE_OF_IN, PLACE_OF_OUT, SPAN, spans_of_ball, spans_of_cell
from .packet.lanes import (
    BEAM_AT,
    DOUBT,
    LANES,
    SEEKS,
    T_MAX,
    fill_lanes,
    is_coherent,
    is_searching,
    lane_nearness,
    lane_ray,
    packet_row,
)
from .packet.packet import Packet, boolean_memory, lanes_at_ball, lanes_in_child, new_packet
from .programs import leaves_of
from .ray import DEAD, Ray, RayArrays, load_ray, scale_ray
from .surface.interval import is_open, lengths_of, lengths_of_ball
from .surface.records import load_sphere
from .tables import BALL, CELL, REGION, Flags, Floats, Geometry, Ints, Longs, Signs, box_at, integer, is_halted, whole
from .threads import run_calls

# --- Coherent rays, 64 at a time
#
# A packet goes down the tree once, as for first hits, and finds the spans of balls, cells and leaves in lanes. From
# there on every lane that has a span continues alone, with the code of a single ray.

_MOST_ROWS = LANES * (4 * MOST + 1)
"""Most rows of an entry that is traced in lanes."""


class RowChains(NamedTuple):
    """The rows of each lane: a chain from the last to the first, linked by the last column of a row; -1 ends it."""

    last: Ints
    rows: Ints  # number of rows


class Lane(NamedTuple):
    """A lane and its ray."""

    i: Any
    ray: Ray


class PacketListing(NamedTuple):
    """A packet, the chains of its rows so far, and the kind of row."""

    packet: Packet
    chains: RowChains
    spans: bool  # spans, else crossings


@allocator
def new_chains() -> RowChains:
    """Return memory of chains for one thread."""
    return RowChains(np.empty(LANES, np.int32), np.empty(LANES, np.int32))


@inline
def _in_ball(geometry: Geometry, scratch: Scratch, packet: Packet, surface: int, i: Any, ray: Ray) -> BodyRows:
    """Write the crossings of lane i with a ball into scratch, from the spans in `packet.leaves`."""
    low, high = packet.leaves[IN + i], packet.leaves[OUT + i]
    if not low < high:
        return BodyRows(0, False, 0.0, False)
    sphere = load_sphere(geometry, integer(geometry, table.SURFACE_ROW, surface))
    nearness = lane_nearness(packet.lanes, i, lengths_of_ball(sphere))
    if not (low < ray.t_max + nearness.off and high > ray.t_min - nearness.off):
        return BodyRows(0, False, 0.0, False)
    count, inside, unsure = crossings_of_roots(scratch, surface, ray, nearness, low, high)
    return BodyRows(count, inside, nearness.off, unsure)


@inline
def _in_cell(geometry: Geometry, scratch: Scratch, packet: Packet, cell: int, i: Any, ray: Ray) -> BodyRows:
    """Write the crossings of lane i with a cell into scratch, from the spans in `packet.leaves`."""
    first, second = _span(packet.leaves, 0, i), _span(packet.leaves, SPAN, i)
    spans = (1 if first[0] < first[1] else 0) + (1 if second[0] < second[1] else 0)
    if spans == 0:
        return BodyRows(0, False, 0.0, False)
    if not first[0] < first[1]:
        first = second
    nearness = lane_nearness(packet.lanes, i, lengths_of(geometry, table.CELL_LIMITS, cell))
    in1, out1, a1, b1 = first
    in2, out2, a2, b2 = second
    found = CellSpans(spans, in1, out1, a1, b1, in2, out2, a2, b2, False)
    count, inside, unsure = crossings_of_spans(geometry, scratch, ray, nearness, found)
    return BodyRows(count, inside, nearness.off, unsure)


@inline
def _span(leaves: Floats, at: int, i: Any) -> tuple[float, float, int, int]:
    """Return (t in, t out, place in, place out) of lane i in the rows at leaves[at:]."""
    row = np.uint64(at) + i
    return leaves[row + IN], leaves[row + OUT], whole(leaves[row + PLACE_OF_IN]), whole(leaves[row + PLACE_OF_OUT])


@inline
def _in_region(geometry: Geometry, scratch: Scratch, packet: Packet, program: int, i: Any, ray: Ray) -> BodyRows:
    """Write the crossings of lane i with a Boolean body into scratch, from its leaves' spans in `packet.leaves`."""
    if packet.lanes[SEEKS + i] == 0.0:
        return BodyRows(0, False, 0.0, False)
    events = 0
    begin, end = leaves_of(geometry, program)
    for leaf in range(begin, end):
        for s in range(packet.spans[leaf - begin]):
            t_in, t_out, a, b = _span(packet.leaves, (leaf - begin) * LEAF + s * SPAN, i)
            if t_in < t_out:
                events = put_event(scratch, events, t_in, leaf, a, 1)
                events = put_event(scratch, events, t_out, leaf, b, 0)
    sort_events(scratch, events)
    nearness = lane_nearness(packet.lanes, i, lengths_of(geometry, table.PROGRAM_LIMITS, program))
    count, inside, unsure = sweep_events(geometry, scratch, program, ray, nearness, events, 1 << 30)
    return BodyRows(count, inside, nearness.off, unsure)


@helper
def _prepare(geometry: Geometry, packet: Packet, kind: int, index: int, hits: int) -> bool:
    """Find the spans of a ball, cell or small body in the groups of lanes of a mask; False if no lane has one."""
    lanes, leaves, first, last = packet.lanes, packet.leaves, lowest_bit(hits) & -8, (highest_bit(hits) | 7) + 1
    if kind == BALL:
        spans_of_ball(geometry, lanes, leaves, 0, index, first, last)
        return True
    if kind == CELL:
        return spans_of_cell(geometry, lanes, leaves, 0, index, first, last)
    return leaves_of_lanes(geometry, boolean_memory(packet), index, first, last) > 0


@helper
def _lane_rows(
    geometry: Geometry, scratch: Scratch, listing: PacketListing, item: LeafItem, bits: int, rows: Floats, used: int
) -> int:
    """Append the rows of a ball, cell or small body in the lanes of a mask; return the number of rows now."""
    packet, (kind, index, _, entry) = listing.packet, item
    lanes = packet.lanes
    while bits != 0:
        i = np.uint64(lowest_bit(bits))
        bits &= bits - 1
        if lanes[DOUBT + i] != 0.0 or not is_searching(lanes, i):
            continue
        ray = lane_ray(lanes, i, lanes[T_MAX + i])
        if kind == BALL:
            found = _in_ball(geometry, scratch, packet, index, i, ray)
        elif kind == CELL:
            found = _in_cell(geometry, scratch, packet, index, i, ray)
        else:
            found = _in_region(geometry, scratch, packet, index, i, ray)
        used = _keep(geometry, scratch, listing, entry, found, Lane(i, ray), rows, used)
    return used


@inline
def _keep(
    geometry: Geometry,
    scratch: Scratch,
    listing: PacketListing,
    entry: int,
    found: BodyRows,
    lane: Lane,
    rows: Floats,
    used: int,
) -> int:
    """Append a lane's rows of an entry to its chain, or mark the lane doubtful; return the number of rows now."""
    chains, i = listing.chains, lane.i
    # A doubtful lane keeps the rows of its other entries: `trace_rows` drops the whole chain
    if found.unsure:
        listing.packet.lanes[DOUBT + i] = 1.0
    if found.unsure or (found.crossings == 0 and not found.inside):
        return used
    now = put_rows(geometry, scratch, entry, found, lane.ray, listing.spans, rows, used)
    for k in range(used, now):
        rows[k, rows.shape[1] - 1] = chains.last[i]
        chains.last[i] = k
    chains.rows[i] += now - used
    return now


@allocator
def _one_by_one(
    geometry: Geometry, scratch: Scratch, listing: PacketListing, entry: int, bits: int, rows: Floats, used: int
) -> tuple[Floats, int]:
    """Append the rows of a large body or a sheet in the lanes of a mask: (rows, number of rows now)."""
    lanes = listing.packet.lanes
    while bits != 0:
        i = np.uint64(lowest_bit(bits))
        bits &= bits - 1
        if lanes[DOUBT + i] != 0.0 or not is_searching(lanes, i):
            continue
        ray = lane_ray(lanes, i, lanes[T_MAX + i])
        count, inside, unsure = entry_crossings(geometry, scratch, entry, ray, 1 << 30)
        body_rows = BodyRows(count, inside, entry_nearness(geometry, entry, ray).off, unsure)
        rows = grow_rows(rows, used, count + 1)
        used = _keep(geometry, scratch, listing, entry, body_rows, Lane(i, ray), rows, used)
    return rows, used


@allocator
def _meet(
    geometry: Geometry, scratch: Scratch, listing: PacketListing, item: LeafItem, bits: int, rows: Floats, used: int
) -> tuple[Floats, int]:
    """Append the rows of an entry in the lanes of a mask: (rows, number of rows now)."""
    kind, index = item.kind, item.index
    # Sheets and polygons hold no points, so they have crossings but no spans
    if listing.spans and kind > REGION:
        return rows, used
    if kind > REGION or (kind == REGION and not fits_in_lanes(geometry, index)):
        return _one_by_one(geometry, scratch, listing, item.entry, bits, rows, used)
    if _prepare(geometry, listing.packet, kind, index, bits):
        # Before the kernels that cannot allocate: lanes append without a test of the room
        rows = grow_rows(rows, used, _MOST_ROWS)
        used = _lane_rows(geometry, scratch, listing, item, bits, rows, used)
    return rows, used


@allocator
def list_packet(
    geometry: Geometry, scratch: Scratch, packet: Packet, chains: RowChains, spans: bool, rows: Floats
) -> tuple[Floats, int]:
    """List the spans or crossings of the rays of an `is_ordinary` packet, in chains through rows: (rows, their number).

    Lanes whose DOUBT is set lack some rows; the caller traces them again as single rays.
    """
    way, lanes, used, listing = scratch.way, packet.lanes, 0, PacketListing(packet, chains, spans)
    for i in range(LANES):
        chains.last[i], chains.rows[i] = -1, 0
    code, box, top = next_leaf(geometry, way, lanes, BEAM_AT, push_roots(geometry, way, scene_tree(geometry)))
    while code != 0:
        begin, end = leaf_range(code)
        at, count = leaf_at(geometry, begin), end - begin
        balls = box >= 0 and is_round(geometry, at, count)
        # Without a test all items count, and all lanes
        bits, hit_lanes = (1 << count) - 1, -1
        if balls and count > 1:
            bits = balls_in_beam(geometry.floats, at, count, count, lanes, BEAM_AT, way)
        elif box >= 0 and not balls:
            hit_lanes = lanes_in_child(geometry, lanes, box_at(geometry, box))
        while bits != 0:
            k = lowest_bit(bits)
            bits &= bits - 1
            if balls:
                hit_lanes = lanes_at_ball(geometry, lanes, at + k, count)
            if hit_lanes != 0:
                item = leaf_item(geometry, at, count, k)
                rows, used = _meet(geometry, scratch, listing, item, hit_lanes, rows, used)
        code, box, top = next_leaf(geometry, way, lanes, BEAM_AT, top)
    return rows, used


@helper
def put_chain(chains: RowChains, i: int, found: Floats, rows: Floats, used: int) -> int:
    """Copy the rows of a lane to rows[used:], which have room; return the number of rows now."""
    # Rows of all lanes are mixed in one table, since a packet meets a body with all lanes at once
    row, after = chains.last[i], used + chains.rows[i]
    for k in range(after - 1, used - 1, -1):  # a chain leads from the last row to the first
        for column in range(rows.shape[1]):
            rows[k, column] = found[row, column]
        row = int(found[row, rows.shape[1]])
    return after


# --- Rows of all rays, and their columns


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


@allocator
def _list_rays(
    geometry: Geometry, scratch: Scratch, bundle: Packet, chains: RowChains, rays: RayArrays, begin: int, end: int,
    width: int, spans: bool, rows: Floats, found: Floats, counts: Ints, doubts: Signs,
) -> tuple[Floats, Floats, int]:  # fmt: skip
    """Write the rows of packets begin..end, in order of lanes: (rows, room for those of lanes, number of rows).

    Ray i has counts[i] rows, sorted. A doubtful ray has doubts[i] = 1 and no rows.
    """
    lanes, used = bundle.lanes, 0
    for packet in range(begin, end):  # in here: a call counts the references of all arrays
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
    return rows, found, used


@kernel(width="picture n", begin="0..end", end="0..n", counts="out n", doubts="out n")
def trace_rows(
    geometry: Geometry, rays: RayArrays, width: int, spans: bool, begin: int, end: int, counts: Ints, doubts: Signs
) -> Floats:
    """Return rows (body/crossing_rows.py) of spans or crossings of packets begin..end of 64 rays, as `_list_rays`."""
    scratch, bundle, chains = new_scratch(geometry), new_packet(geometry), new_chains()
    columns = SPAN_COLUMNS if spans else CROSSING_COLUMNS
    rows, found = np.empty((64 * (end - begin), columns)), np.empty((256, columns + 1))
    rows, _, used = _list_rays(
        geometry, scratch, bundle, chains, rays, begin, end, width, spans, rows, found, counts, doubts
    )  # fmt: skip
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
                # No more places than rows are written, whatever the counts are
                for k in range(min(counts[i], count - done)):
                    places[done] = offsets[i] + k
                    done += 1
    return places[:done]


@kernel(counts="n", offsets="out n")
def put_offsets(counts: Ints, offsets: Longs) -> None:
    """Write where the rows of each ray end; NumPy takes seven times as long, since it first makes the counts longer."""
    end = 0
    for i in range(len(counts)):
        end += counts[i]
        offsets[i] = end


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
        # + 0.0 turns -0.0 into 0.0: no answer is -0.0
        t_enter[at], body[at], t_exit[at] = rows[k, ENTER] + 0.0, rows[k, BODY], rows[k, EXIT] + 0.0
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
        t[at], body[at], face[at] = rows[k, T] + 0.0, rows[k, BODY], rows[k, FACE]
        surface[at], entering[at] = rows[k, SURFACE], rows[k, ENTERS] != 0.0


# Sums over the spans of each ray


ROUNDING_OVERLAP = 1e-9
"""Two spans that have less in common are neighbours, whose walls were given with few digits: a share of t."""


@inline
def length_of(x: float, y: float, z: float) -> float:
    """Return the length of a direction; dividing by the largest component keeps the squares finite."""
    scale = max(abs(x), abs(y), abs(z))
    scale = scale if scale > 0.0 else 1.0
    x, y, z = x / scale, y / scale, z / scale
    return scale * math.sqrt(x * x + y * y + z * z)


@inline
def _add_chord(chord: float, place: int, weights: Floats, i: int, total: Floats) -> bool:
    """Add weights[place] times a length to total[i], and return whether any is not 0; without weights the length."""
    if len(weights) == 0:
        if 0 <= place < total.shape[1]:
            total[i, place] += chord
        return True
    counts = False
    for k in range(total.shape[1] if 0 <= place < len(weights) else 0):
        weight = weights[place, k]
        if weight != 0.0:  # 0 adds nothing, even on an infinite span
            total[i, k] += weight * chord
            counts = True
    return counts


@kernel(
    directions="n 3", offsets="n+1", t_enter="s", t_exit="s", places="s", weights="* e", begin="0..end", end="0..n",
    total="out n e"
)  # fmt: skip
def integrate_spans(
    directions: Floats, offsets: Longs, t_enter: Floats, t_exit: Floats, places: Ints, weights: Floats,
    begin: int, end: int, total: Floats,
) -> None:  # fmt: skip
    """Write the sums over the spans of rays begin..end of weights[place] times length, or of lengths by their place."""
    for i in range(begin, end):
        for k in range(total.shape[1]):
            total[i, k] = 0.0
        length = length_of(directions[i, 0], directions[i, 1], directions[i, 2])
        for row in range(max(0, offsets[i]), min(offsets[i + 1], len(places))):
            _add_chord((t_exit[row] - t_enter[row]) * length, places[row], weights, i, total)


DOUBTFUL, OVERLAPPING = 1, 2
"""Marks of rays: exact methods must find its spans; some span that counts begins before the one before it ends."""


@kernel(
    width="picture n", columns="b", weights="* e", begin="0..end", end="0..n", total="out n e", counts="out n",
    marks="out n",
)  # fmt: skip
def sum_rays(
    geometry: Geometry, rays: RayArrays, width: int, columns: Ints, weights: Floats, begin: int, end: int,
    total: Floats, counts: Ints, marks: Signs,
) -> None:  # fmt: skip
    """Write the line integrals of `integrate_spans` for packets begin..end, whose spans are not kept, and their marks.

    The place of body k is columns[k], or k where there are no columns.
    """
    scratch, bundle, chains = new_scratch(geometry), new_packet(geometry), new_chains()
    rows, found = np.empty((256, SPAN_COLUMNS)), np.empty((256, SPAN_COLUMNS + 1))
    for packet in range(begin, end):
        rows, found, _ = _list_rays(
            geometry, scratch, bundle, chains, rays, packet, packet + 1, width, True, rows, found, counts, marks
        )  # fmt: skip
        if is_halted(geometry):  # then counts may be missing
            break
        row = 0
        for line in range(8):
            first, n = packet_row(packet, line, width, len(rays.origins))
            for i in range(first, first + n):
                for k in range(total.shape[1]):
                    total[i, k] = 0.0
                length, last = length_of(rays.directions[i, 0], rays.directions[i, 1], rays.directions[i, 2]), -math.inf
                for _ in range(counts[i]):
                    t_enter, t_exit, place = rows[row, ENTER], rows[row, EXIT], whole(rows[row, BODY])
                    if len(columns) > 0:
                        place = whole(columns[place]) if place < len(columns) else whole(-1)
                    if _add_chord((t_exit - t_enter) * length, place, weights, i, total):
                        if min(last, t_exit) > t_enter:
                            marks[i] = OVERLAPPING
                        last = max(last, t_exit)
                    row += 1


@kernel(first="n", after="n", t_enter="s", t_exit="s", counts="s|0", begin="0..end", end="0..n")
def count_overlaps(
    first: Longs, after: Longs, t_enter: Floats, t_exit: Floats, counts: Signs, begin: int, end: int
) -> int:  # fmt: skip
    """Return how many spans of rays begin..end begin before the one before them ends; of those that count.

    Those of ray i are first[i]..after[i].
    """
    found = 0
    for i in range(begin, end):
        last = -math.inf
        for row in range(max(0, first[i]), min(after[i], len(t_enter))):
            if len(counts) > 0 and counts[row] == 0:
                continue
            found += 1 if min(last, t_exit[row]) > t_enter[row] else 0
            last = max(last, t_exit[row])
    return found


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
        run_calls(kernel, [(p.rows, p.counts, p.offsets, p.width, p.begin, p.end, columns) for p in self.pieces])
        for column in (self.offsets, *columns):
            column.flags.writeable = False


IntArray = npt.NDArray[np.int64]


def row_owners(offsets: IntArray) -> IntArray:
    """Return the ray of each row, int64: rows offsets[k]:offsets[k + 1] belong to ray k."""
    # NumPy counts by `intp`, which has 32 bits in WebAssembly
    return np.repeat(np.arange(len(offsets) - 1, dtype=np.int64), np.diff(offsets).astype(np.intp, copy=False))
