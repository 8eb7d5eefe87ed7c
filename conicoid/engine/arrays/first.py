"""The compiled loops behind the queries: chunks of rays in, arrays out."""

from __future__ import annotations

import math

import numpy as np

from ...compiler.jit import kernel
from ..body.hit import DOUBTFUL, no_hit
from ..body.scratch import new_scratch
from ..culling import prefetch
from ..packets.first import trace_packet
from ..packets.lanes import BEST, DOUBT, LANES, SIZE, lane_hit, put_turns
from ..packets.load import coherent, fill_lanes, packet_row
from ..packets.packet import new_packet
from ..packets.tile import PACKETS, ask_for_packet, new_tile, note_sight, open_quarter, open_tile, tile_packet
from ..ray import DEAD, RayArrays, load_ray, scaled_ray
from ..single.first import first_crossing
from ..streams.stream import new_stream, octant_of, put_stream_ray, stream_hit, trace_stream
from ..tables import Geometry, Ints, Signs, halted, whole
from .found import Found, ask_for_hits, put_eight_hits, put_hit

_AHEAD = 24  # rays are prefetched so many ahead


@kernel(width="picture n", begin="0..end", end="0..n", found="out")
def trace_first(geometry: Geometry, rays: RayArrays, width: int, begin: int, end: int, found: Found) -> None:
    """First hits of tiles begin..end; what is doubtful is marked in found.turn.

    Packets where rays are coherent, else one ray at a time; a lane in doubt is traced again alone, because single rays
    doubt less. Each ray of the tiles gets exactly one hit or miss.
    """
    scratch, bundle, memory = new_scratch(geometry), new_packet(geometry), new_tile()
    lanes, count, several = bundle.lanes, len(rays.origins), len(rays.origins) > LANES
    for tile in range(begin, end):
        shared = several and open_tile(geometry, memory, lanes, rays, tile, width)
        for number in range(PACKETS):
            if several and number & 3 == 0:
                open_quarter(memory, number >> 2, bundle.items)
            ask_for_packet(rays, tile_packet(tile + 1, number, width, count), width)
            packet = tile_packet(tile, number, width, count)
            if packet < 0 or halted(geometry):
                continue
            for row in range(8):
                ask_for_hits(packet_row(packet, row, width, count)[0], found)
            fill_lanes(lanes, rays, packet, width, shared)
            together, doubtful = coherent(geometry, lanes), 0
            if together:
                trace_packet(geometry, scratch, bundle, scratch.nothing, False)
                note_sight(memory, lanes)
                doubtful = put_turns(lanes)
            for row in range(8):
                first, n = packet_row(packet, row, width, count)
                if together and n == 8 and doubtful == 0:
                    put_eight_hits(lanes, 8 * row, first, found)
                    continue
                for k in range(n):
                    i = first + k
                    if together and lanes[DOUBT + np.uint64(8 * row + k)] == 0.0:
                        put_hit(lane_hit(lanes, 8 * row + k), i, found)
                        continue
                    hit = no_hit()
                    ray = load_ray(rays, i)
                    if ray.start != DEAD and not halted(geometry):
                        hit = first_crossing(geometry, scratch, ray, scratch.nothing, False)
                    put_hit(hit, i, found)


@kernel(begin="0..end", end="0..n", found="out")
def trace_first_alone(geometry: Geometry, rays: RayArrays, begin: int, end: int, found: Found) -> None:
    """First hits of rays begin..end, each by itself: what `trace_first` does with those that are not coherent.

    Doubtful rays are asked so once more (`certified.settle`), and exported pages, which trace one at a time, carry it:
    it is a third of the code.
    """
    scratch = new_scratch(geometry)
    for i in range(begin, end):
        hit = no_hit()
        ray = load_ray(rays, i)
        if ray.start != DEAD and not halted(geometry):
            hit = first_crossing(geometry, scratch, ray, scratch.nothing, False)
        put_hit(hit, i, found)


@kernel(width="picture n", begin="0..end", end="0..n", result="out n")
def trace_occluded(geometry: Geometry, rays: RayArrays, width: int, begin: int, end: int, result: Signs) -> None:
    """Is there any crossing (1) or not (0), raised if doubtful? Of tiles begin..end."""
    scratch, bundle, memory = new_scratch(geometry), new_packet(geometry), new_tile()
    lanes, count, several = bundle.lanes, len(rays.origins), len(rays.origins) > LANES
    for tile in range(begin, end):
        shared = several and open_tile(geometry, memory, lanes, rays, tile, width)
        for number in range(PACKETS):
            if several and number & 3 == 0:
                open_quarter(memory, number >> 2, bundle.items)
            ask_for_packet(rays, tile_packet(tile + 1, number, width, count), width)
            packet = tile_packet(tile, number, width, count)
            if packet < 0 or halted(geometry):
                continue
            fill_lanes(lanes, rays, packet, width, shared)
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
                    ray = load_ray(rays, i)
                    if ray.start != DEAD and not halted(geometry):
                        hit = first_crossing(geometry, scratch, ray, scratch.nothing, True)
                    result[i] = (1 if hit.body >= 0 else 0) + (DOUBTFUL if hit.unsure else 0)


@kernel(order="n", size="1..65536", begin="0..end", end="0..n", found="out")
def trace_ordered(
    geometry: Geometry, rays: RayArrays, order: Ints, size: int, any_hit: bool, begin: int, end: int, found: Found
) -> None:
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
                    prefetch(rays.origins, ahead)
                    prefetch(rays.origins, ahead + 2)
                    prefetch(rays.directions, ahead)
                    prefetch(rays.directions, ahead + 2)
                ray = load_ray(rays, i)
                if ray.start != DEAD and scaled_ray(ray)[1] == 1.0:
                    its = octant_of(ray.dx, ray.dy, ray.dz)
                    if count > 0 and its != octant:
                        break
                    octant = its
                    put_stream_ray(stream, count, ray)
                    mine[count] = i
                    count += 1
                elif ray.start == DEAD:
                    put_hit(no_hit(), i, found)
                else:
                    hit = first_crossing(geometry, scratch, ray, scratch.nothing, any_hit)
                    put_hit(hit, i, found)
                k += 1
            trace_stream(geometry, scratch, stream, count, scratch.nothing, any_hit)
            for j in range(count):
                ask_for_hits(mine[min(j + 8, count - 1)], found)
                put_hit(stream_hit(stream, j), mine[j], found)


@kernel(width="picture n", packets="1..n", asked="1..1048576")
def coherent_packets(geometry: Geometry, rays: RayArrays, width: int, packets: int, asked: int) -> int:
    """How many of some packets, spread over all, are coherent."""
    lanes, together = np.empty(SIZE), 0
    for k in range(asked):
        fill_lanes(lanes, rays, k * packets // asked, width, False)
        together += 1 if coherent(geometry, lanes) else 0
    return together
