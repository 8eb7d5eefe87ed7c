"""The compiled loops behind the queries: chunks of rays in, arrays out."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ...compiler.jit import inline, kernel
from ..body.hit import DOUBTFUL, Hit, no_hit, turn_of
from ..body.scratch import new_scratch
from ..culling import prefetch, prefetch_to_write, store_eight
from ..packets.first import trace_packet
from ..packets.lanes import BEST, BODY, DOUBT, ENTRY, LANES, PLACE, SIZE, TURN, lane_hit, put_turns
from ..packets.load import ALONE, coherent, fill_lanes, packet_row
from ..packets.packet import new_packet
from ..packets.tile import PACKETS, ask_for_packet, new_tile, open_quarter, open_tile, tile_packet
from ..ray import DEAD, load_ray, scaled_ray
from ..single.first import first_crossing
from ..streams.stream import new_stream, octant_of, put_stream_ray, stream_hit, trace_stream
from ..tables import Floats, Geometry, Ints, Signs, halted, whole

_AHEAD = 24  # rays whose memory is asked for before it is needed


@inline
def put_hit(hit: Hit, i: Any, t: Floats, body: Ints, entry: Ints, place: Ints, turn: Signs) -> None:
    """Hit i, in arrays; `turn` holds the sense of its leaf, doubled where the body is entered, raised if doubtful."""
    i = np.uint64(i)
    t[i], body[i], entry[i], place[i] = hit.t, hit.body, hit.entry, hit.place
    turn[i] = turn_of(hit)


@inline
def ask_for_hits(i: int, t: Floats, body: Ints, entry: Ints, place: Ints) -> None:
    """Ask for the memory that hit i and a few after it are to be written to."""
    prefetch_to_write(t, i)
    prefetch_to_write(body, i)
    prefetch_to_write(entry, i)
    prefetch_to_write(place, i)


@inline
def put_eight_hits(
    lanes: Floats, lane: int, i: int, t: Floats, body: Ints, entry: Ints, place: Ints, turn: Signs
) -> None:
    """`put_hit` for the hits of eight lanes, which have their turns ready."""
    at = np.uint64(lane)
    store_eight(lanes, BEST + at, t, i)
    store_eight(lanes, BODY + at, body, i)
    store_eight(lanes, ENTRY + at, entry, i)
    store_eight(lanes, PLACE + at, place, i)
    store_eight(lanes, TURN + at, turn, i)


@kernel
def trace_first(
    geometry: Geometry, origins: Floats, directions: Floats, t_min: Floats, t_max: Floats, starts: Ints,
    width: int, begin: int, end: int, t: Floats, body: Ints, entry: Ints, place: Ints, turn: Signs,
) -> None:  # fmt: skip
    """First hits of tiles begin..end. What is doubtful in a packet is asked again by itself."""
    scratch, bundle, memory = new_scratch(geometry), new_packet(), new_tile()
    lanes, count, several = bundle.lanes, len(origins), len(origins) > LANES and width != ALONE
    for tile in range(begin, end):
        shared = several and open_tile(geometry, memory, lanes, origins, directions, tile, width)
        for number in range(PACKETS):
            if several and number & 3 == 0:
                open_quarter(memory, number >> 2, bundle.items)
            ask_for_packet(origins, directions, tile_packet(tile + 1, number, width, count), width)
            packet = tile_packet(tile, number, width, count)
            if packet < 0 or halted(geometry):
                continue
            for row in range(8):
                ask_for_hits(packet_row(packet, row, width, count)[0], t, body, entry, place)
            fill_lanes(lanes, origins, directions, t_min, t_max, starts, packet, width, shared)
            together, doubtful = coherent(geometry, lanes), 0
            if together:
                trace_packet(geometry, scratch, bundle, scratch.nothing, False)
                doubtful = put_turns(lanes)
            for row in range(8):
                first, n = packet_row(packet, row, width, count)
                if together and n == 8 and doubtful == 0:
                    put_eight_hits(lanes, 8 * row, first, t, body, entry, place, turn)
                    continue
                for k in range(n):
                    i = first + k
                    if together and lanes[DOUBT + np.uint64(8 * row + k)] == 0.0:
                        put_hit(lane_hit(lanes, 8 * row + k), i, t, body, entry, place, turn)
                        continue
                    hit = no_hit()
                    ray = load_ray(origins, directions, t_min, t_max, starts, i)
                    if ray.start != DEAD and not halted(geometry):
                        hit = first_crossing(geometry, scratch, ray, scratch.nothing, False)
                    put_hit(hit, i, t, body, entry, place, turn)


@kernel
def trace_occluded(
    geometry: Geometry, origins: Floats, directions: Floats, t_min: Floats, t_max: Floats, starts: Ints,
    width: int, begin: int, end: int, result: Signs,
) -> None:  # fmt: skip
    """Is there any crossing (1) or not (0), raised if doubtful? Of tiles begin..end."""
    scratch, bundle, memory = new_scratch(geometry), new_packet(), new_tile()
    lanes, count, several = bundle.lanes, len(origins), len(origins) > LANES
    for tile in range(begin, end):
        shared = several and open_tile(geometry, memory, lanes, origins, directions, tile, width)
        for number in range(PACKETS):
            if several and number & 3 == 0:
                open_quarter(memory, number >> 2, bundle.items)
            ask_for_packet(origins, directions, tile_packet(tile + 1, number, width, count), width)
            packet = tile_packet(tile, number, width, count)
            if packet < 0 or halted(geometry):
                continue
            fill_lanes(lanes, origins, directions, t_min, t_max, starts, packet, width, shared)
            together = coherent(geometry, lanes)
            if together:
                trace_packet(geometry, scratch, bundle, scratch.nothing, True)
            for row in range(8):
                first, n = packet_row(packet, row, width, count)
                for k in range(n):
                    i, lane = first + k, np.uint64(8 * row + k)
                    if together and lanes[DOUBT + lane] == 0.0:
                        result[i] = 1 if lanes[BEST + lane] < math.inf else 0
                        continue
                    hit = no_hit()
                    ray = load_ray(origins, directions, t_min, t_max, starts, i)
                    if ray.start != DEAD and not halted(geometry):
                        hit = first_crossing(geometry, scratch, ray, scratch.nothing, True)
                    result[i] = (1 if hit.body >= 0 else 0) + (DOUBTFUL if hit.unsure else 0)


@kernel
def trace_ordered(
    geometry: Geometry, origins: Floats, directions: Floats, t_min: Floats, t_max: Floats, starts: Ints,
    order: Ints, size: int, any_hit: bool, begin: int, end: int,
    t: Floats, body: Ints, entry: Ints, place: Ints, turn: Signs,
) -> None:  # fmt: skip
    """First hits, or any, of rays in an order; those from `size` begin to `size` end make streams begin..end."""
    scratch, stream, mine = new_scratch(geometry), new_stream(geometry, size), np.empty(size, np.int32)
    for number in range(begin, end):
        k, last = size * number, min(size * number + size, len(order))
        while k < last and not halted(geometry):
            count, octant = 0, -1
            while k < last:
                i = order[k]
                if k + _AHEAD < len(order):
                    ahead = 3 * whole(order[k + _AHEAD])
                    prefetch(origins, ahead)
                    prefetch(origins, ahead + 2)
                    prefetch(directions, ahead)
                    prefetch(directions, ahead + 2)
                ray = load_ray(origins, directions, t_min, t_max, starts, i)
                if ray.start != DEAD and scaled_ray(ray)[1] == 1.0:
                    its = octant_of(ray.dx, ray.dy, ray.dz)
                    if count > 0 and its != octant:
                        break
                    octant = its
                    put_stream_ray(stream, count, ray)
                    mine[count] = i
                    count += 1
                elif ray.start == DEAD:
                    put_hit(no_hit(), i, t, body, entry, place, turn)
                else:
                    hit = first_crossing(geometry, scratch, ray, scratch.nothing, any_hit)
                    put_hit(hit, i, t, body, entry, place, turn)
                k += 1
            trace_stream(geometry, scratch, stream, count, scratch.nothing, any_hit)
            for j in range(count):
                ask_for_hits(mine[min(j + 8, count - 1)], t, body, entry, place)
                put_hit(stream_hit(stream, j), mine[j], t, body, entry, place, turn)


@kernel
def coherent_packets(
    geometry: Geometry, origins: Floats, directions: Floats, t_min: Floats, t_max: Floats, starts: Ints,
    width: int, packets: int, asked: int,
) -> int:  # fmt: skip
    """How many of some packets, spread over all, are coherent."""
    lanes, found = np.empty(SIZE), 0
    for k in range(asked):
        fill_lanes(lanes, origins, directions, t_min, t_max, starts, k * packets // asked, width, False)
        found += 1 if coherent(geometry, lanes) else 0
    return found
