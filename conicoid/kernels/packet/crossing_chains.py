"""All crossings or spans of coherent rays, 64 at a time.

A packet goes down the tree once, as for first hits, and finds the spans of balls, cells and leaves in lanes. From there
on every lane that has a span continues alone, with the code of a single ray.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..._jit.decorators import allocator, helper, inline
from .. import tables as table
from ..body.boolean import put_event, sort_events, sweep_events
from ..body.cell import CellSpans
from ..body.crossing_rows import BodyRows, grow_rows, put_rows
from ..body.entry import crossings_of_roots, crossings_of_spans, entry_crossings, entry_nearness
from ..body.scratch import Scratch
from ..bvh.culling import balls_in_beam, highest_bit, lowest_bit
from ..bvh.walk import LeafItem, is_round, leaf_at, leaf_item, leaf_range, next_leaf, push_roots, scene_tree
from ..programs import leaves_of
from ..ray import Ray
from ..surface.interval import lengths_of, lengths_of_ball
from ..surface.records import load_sphere
from ..tables import BALL, CELL, REGION, Floats, Geometry, Ints, box_at, integer, whole
from .booleans import MOST, fits_in_lanes, leaves_of_lanes
from .cells import IN, LEAF, OUT, PLACE_OF_IN, PLACE_OF_OUT, SPAN, spans_of_ball, spans_of_cell
from .lanes import BEAM_AT, DOUBT, LANES, SEEKS, T_MAX, is_searching, lane_nearness, lane_ray
from .packet import Packet, boolean_memory, lanes_at_ball, lanes_in_child

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
def _prepare(geometry: Geometry, packet: Packet, kind: int, index: int, met: int) -> bool:
    """Find the spans of a ball, cell or small body in the groups of lanes of a mask; False if no lane has one."""
    lanes, leaves, first, last = packet.lanes, packet.leaves, lowest_bit(met) & -8, (highest_bit(met) | 7) + 1
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
            met = _in_ball(geometry, scratch, packet, index, i, ray)
        elif kind == CELL:
            met = _in_cell(geometry, scratch, packet, index, i, ray)
        else:
            met = _in_region(geometry, scratch, packet, index, i, ray)
        used = _keep(geometry, scratch, listing, entry, met, Lane(i, ray), rows, used)
    return used


@inline
def _keep(
    geometry: Geometry,
    scratch: Scratch,
    listing: PacketListing,
    entry: int,
    met: BodyRows,
    lane: Lane,
    rows: Floats,
    used: int,
) -> int:
    """Append a lane's rows of an entry to its chain, or mark the lane doubtful; return the number of rows now."""
    chains, i = listing.chains, lane.i
    if met.unsure:
        listing.packet.lanes[DOUBT + i] = 1.0
    if met.unsure or (met.crossings == 0 and not met.inside):
        return used
    now = put_rows(geometry, scratch, entry, met, lane.ray, listing.spans, rows, used)
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
        met = BodyRows(count, inside, entry_nearness(geometry, entry, ray).off, unsure)
        rows = grow_rows(rows, used, count + 1)
        used = _keep(geometry, scratch, listing, entry, met, Lane(i, ray), rows, used)
    return rows, used


@allocator
def _meet(
    geometry: Geometry, scratch: Scratch, listing: PacketListing, item: LeafItem, bits: int, rows: Floats, used: int
) -> tuple[Floats, int]:
    """Append the rows of an entry in the lanes of a mask: (rows, number of rows now)."""
    kind, index = item.kind, item.index
    if listing.spans and kind > REGION:
        return rows, used
    if kind > REGION or (kind == REGION and not fits_in_lanes(geometry, index)):
        return _one_by_one(geometry, scratch, listing, item.entry, bits, rows, used)
    if _prepare(geometry, listing.packet, kind, index, bits):
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
        bits, met = (1 << count) - 1, -1
        if balls and count > 1:
            bits = balls_in_beam(geometry.floats, at, count, count, lanes, BEAM_AT, way)
        elif box >= 0 and not balls:
            met = lanes_in_child(geometry, lanes, box_at(geometry, box))
        while bits != 0:
            k = lowest_bit(bits)
            bits &= bits - 1
            if balls:
                met = lanes_at_ball(geometry, lanes, at + k, count)
            if met != 0:
                item = leaf_item(geometry, at, count, k)
                rows, used = _meet(geometry, scratch, listing, item, met, rows, used)
        code, box, top = next_leaf(geometry, way, lanes, BEAM_AT, top)
    return rows, used


@helper
def put_chain(chains: RowChains, i: int, found: Floats, rows: Floats, used: int) -> int:
    """Copy the rows of a lane to rows[used:], which have room; return the number of rows now."""
    row, after = chains.last[i], used + chains.rows[i]
    for k in range(after - 1, used - 1, -1):  # a chain leads from the last row to the first
        for column in range(rows.shape[1]):
            rows[k, column] = found[row, column]
        row = int(found[row, rows.shape[1]])
    return after
