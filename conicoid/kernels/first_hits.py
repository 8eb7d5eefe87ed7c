"""Kernels for first hits and occlusion: of one ray (`first_crossing`), and of arrays of rays into `HitBuffers`.

They choose the route of each ray. Coherent rays go in packets of 64, others in streams or one by one. Single rays are
those in doubt, those beside others that see something else, and those of integrators. The only ray of a query goes as
a packet whose other lanes are idle.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from .._jit.decorators import helper, inline, kernel, record_shapes
from .._jit.machine_code import empty_array
from .._util.records import FloatArray
from .body.hit import DOUBTFUL, Hit, ResolvedHit, cull_limit, intersect_item, no_hit, resolve_hit, scale_hit, turn_of
from .body.scratch import Scratch, new_scratch
from .bvh.culling import LAST, finish_streams, hit_balls, lowest_bit, prefetch, prefetch_to_write, store_eight
from .bvh.walk import OWN_BEAM, leaf_at, leaf_ball, leaf_item, leaf_range, next_leaf, push_roots, put_beam, scene_tree
from .packet.frontier import (
    PACKETS,
    Tile,
    copy_tile,
    new_tile,
    note_sight,
    open_quarter,
    open_tile,
    prefetch_packet,
    tile_packet,
)
from .packet.lanes import (
    BEST,
    BODY,
    DOUBT,
    ENTRY,
    LANES,
    PLACE,
    SIZE,
    TURN,
    fill_lanes,
    is_coherent,
    lane_hit,
    packet_row,
    put_turns,
)
from .packet.packet import Packet, new_packet
from .packet.traversal import trace_packet
from .ray import DEAD, Ray, RayArrays, load_ray, scale_ray, span_inverse
from .stream import new_stream, octant_of, put_stream_ray, stream_hit, trace_stream
from .surface.interval import is_open
from .tables import Floats, Geometry, Ints, Signs, is_halted, whole


@helper
def first_crossing(geometry: Geometry, scratch: Scratch, ray: Ray, blocks: Signs, any_hit: bool) -> Hit:
    """Return the nearest crossing of bodies with blocks[body] != 0 (of all bodies, if `blocks` is empty).

    Traverses the tree, the nearest box first. The beam ends at `cull_limit(best)`, so that a culled crossing can
    neither be nearer nor make the order doubtful. With `any_hit` it returns the first crossing that it finds.
    """
    best = no_hit()
    if not is_open(ray.t_min, ray.t_max):
        return best
    # Squares of very long or very short directions would overflow, or underflow to 0
    ray, scale = scale_ray(ray)
    some = len(blocks) > 0
    way = scratch.way
    put_beam(way, OWN_BEAM, ray)
    # One division for the whole ray; kernels multiply
    inverse = span_inverse(ray)
    code, _, top = next_leaf(geometry, way, way, OWN_BEAM, push_roots(geometry, way, scene_tree(geometry)))
    while code != 0:
        first, last = leaf_range(code)
        at, count = leaf_at(geometry, first), last - first
        for eight in range(0, count, 8):  # the balls around eight items are tested at once
            # Anew for each eight, since a hit among the first shortens the ray for the others
            end = min(ray.t_max, cull_limit(best))
            bits = hit_balls(geometry.floats, at + eight, count, count - eight, ray, inverse, end)
            while bits != 0:
                k = eight + lowest_bit(bits)
                bits &= bits - 1
                item = leaf_item(geometry, at, count, k)
                if some and blocks[item.body] == 0:
                    continue
                best = intersect_item(geometry, scratch, item, leaf_ball(geometry, at, count, k), ray, inverse, best)
                # Also where the hit is in doubt: exact methods trace such a ray again
                if any_hit and best.body >= 0:
                    return scale_hit(best, scale)
        way[OWN_BEAM + LAST] = min(ray.t_max, cull_limit(best))  # boxes beyond the hit are culled from now on
        code, _, top = next_leaf(geometry, way, way, OWN_BEAM, top)
    return scale_hit(best, scale)


@inline
def resolve_first_crossing(geometry: Geometry, scratch: Scratch, ray: Ray) -> ResolvedHit:
    """Return the first crossing of all bodies in (t_min, t_max), with surface, face and side."""
    return resolve_hit(geometry, first_crossing(geometry, scratch, ray, scratch.nothing, False))


@inline
def is_blocked(geometry: Geometry, scratch: Scratch, ray: Ray, blocks: Signs) -> bool:
    """True if the ray crosses a body with blocks[body] != 0 (int8 over bodies) in (t_min, t_max)."""
    return first_crossing(geometry, scratch, ray, blocks, True).body >= 0


@inline
def _single_hit(geometry: Geometry, scratch: Scratch, rays: RayArrays, i: int, any_hit: bool) -> Hit:
    """Return the first crossing of ray i, traced by itself; a miss for a dead ray, and after a halt."""
    ray = load_ray(rays, i)
    if ray.start == DEAD or is_halted(geometry):
        return no_hit()
    return first_crossing(geometry, scratch, ray, scratch.nothing, any_hit)


# First hits of many rays, in one array for each field

_PAGE = 4096  # bytes of a page of memory


def _room(count: int, kind: Any, share: int) -> Any:
    """Return an array that begins `share` eighths of a page into a page.

    Rows of a picture may lie whole pages apart: if all arrays began at the same place of a page, the hits of a packet
    would compete for the same few lines of the cache.
    """
    # Few hits: their rows do not compete for lines of the cache
    if count < _PAGE:
        return np.empty(count, kind)
    size = count * np.dtype(kind).itemsize
    room = empty_array(size + 2 * _PAGE, np.uint8)
    first = -room.ctypes.data % _PAGE + share * _PAGE // 8
    return room[first : first + size].view(kind)


@record_shapes(t="n", body="n", entry="n", place="n", turn="n")
class HitBuffers(NamedTuple):
    """First hits as kernels write them, in one array for each field."""

    t: FloatArray
    body: npt.NDArray[np.int32]
    entry: npt.NDArray[np.int32]
    place: npt.NDArray[np.int32]
    turn: npt.NDArray[np.int8]  # see `hit.turn_of`

    @classmethod
    def new(cls, count: int) -> HitBuffers:
        """Return buffers for `count` hits, not initialised."""
        body, entry, place = (_room(count, np.int32, share) for share in (2, 4, 6))
        return cls(_room(count, np.float64, 0), body, entry, place, _room(count, np.int8, 1))


@inline
def put_hit(hit: Hit, i: Any, found: HitBuffers) -> None:
    """Write hit i."""
    i = np.uint64(i)
    # + 0.0 turns -0.0 into 0.0: no answer is -0.0
    found.t[i], found.body[i], found.entry[i], found.place[i] = hit.t + 0.0, hit.body, hit.entry, hit.place
    found.turn[i] = turn_of(hit)


@inline
def prefetch_hits(i: int, found: HitBuffers) -> None:
    """Prefetch for writing the memory of hit i and of a few after it."""
    prefetch_to_write(found.t, i)
    prefetch_to_write(found.body, i)
    prefetch_to_write(found.entry, i)
    prefetch_to_write(found.place, i)


@inline
def put_eight_hits(lanes: Floats, lane: int, i: int, found: HitBuffers) -> None:
    """`put_hit` for the hits of eight lanes, whose turns `put_turns` has written."""
    at = np.uint64(lane)
    store_eight(lanes, BEST + at, found.t, i)
    store_eight(lanes, BODY + at, found.body, i)
    store_eight(lanes, ENTRY + at, found.entry, i)
    store_eight(lanes, PLACE + at, found.place, i)
    store_eight(lanes, TURN + at, found.turn, i)


# Kernels over chunks of rays

_PREFETCH_DISTANCE = 24  # rays


@kernel(width="picture n", begin="0..end", end="0..n", found="out")
def trace_first(geometry: Geometry, rays: RayArrays, width: int, begin: int, end: int, found: HitBuffers) -> None:
    """Write the first hits of the rays of tiles begin..end; found.turn marks the doubtful ones.

    Coherent rays are traced in packets, others one at a time. A lane in doubt is traced again as a single ray, because
    single rays are in doubt less often. Each ray of the tiles gets exactly one hit or miss.
    """
    # Once for each chunk of tiles, not for each packet
    scratch, bundle, memory = new_scratch(geometry), new_packet(geometry), new_tile()
    for tile in range(begin, end):
        _trace_tile(geometry, scratch, bundle, memory, rays, width, tile, found)


@kernel(
    width="picture n", begin="0..end", end="0..n", own_origins="out c 3", own_directions="out c 3", bad="out 1",
    found="out",
)  # fmt: skip
def trace_first_and_copy(
    geometry: Geometry, rays: RayArrays, width: int, begin: int, end: int, own_origins: Floats, own_directions: Floats,
    bad: Signs, found: HitBuffers,
) -> None:  # fmt: skip
    """`trace_first` of a user's arrays, copied while they are in the cache; bad[0] = 1 if a ray cannot be traced.

    Arrays that stay as they are, whose copies are empty, are only checked.
    """
    scratch, bundle, memory, room = new_scratch(geometry), new_packet(geometry), new_tile(), np.empty((8, 3))
    for tile in range(begin, end):
        if copy_tile(rays, tile, width, own_origins, own_directions, room):
            _trace_tile(geometry, scratch, bundle, memory, rays, width, tile, found)
        else:
            bad[0] = 1
    finish_streams()


@helper
def _trace_tile(
    geometry: Geometry, scratch: Scratch, bundle: Packet, memory: Tile, rays: RayArrays, width: int, tile: int,
    found: HitBuffers,
) -> None:  # fmt: skip
    """Write the first hits of the rays of a tile."""
    lanes, count, several = bundle.lanes, len(rays.origins), len(rays.origins) > LANES
    shared = several and open_tile(geometry, memory, lanes, rays, tile, width)
    for number in range(PACKETS):
        if several and number & 3 == 0:
            open_quarter(memory, number >> 2, bundle.items)
        prefetch_packet(rays, tile_packet(tile + 1, number, width, count), width)
        packet = tile_packet(tile, number, width, count)
        if packet < 0 or is_halted(geometry):
            continue
        for row in range(8):
            prefetch_hits(packet_row(packet, row, width, count)[0], found)
        fill_lanes(lanes, rays, packet, width, shared)
        together, doubtful = is_coherent(geometry, lanes), 0
        if together:
            trace_packet(geometry, scratch, bundle, scratch.nothing, False)
            note_sight(memory, lanes)
            doubtful = put_turns(lanes)
        for row in range(8):
            first, n = packet_row(packet, row, width, count)
            if together and n == 8 and doubtful == 0:  # a whole row of certain hits is stored at once
                put_eight_hits(lanes, 8 * row, first, found)
                continue
            for k in range(n):
                i = first + k
                if together and lanes[DOUBT + np.uint64(8 * row + k)] == 0.0:
                    put_hit(lane_hit(lanes, 8 * row + k), i, found)
                    continue
                put_hit(_single_hit(geometry, scratch, rays, i, False), i, found)


@kernel(begin="0..end", end="0..n", found="out")
def trace_first_alone(geometry: Geometry, rays: RayArrays, begin: int, end: int, found: HitBuffers) -> None:
    """Write the first hits of rays begin..end, one at a time, as `trace_first` does for rays that are not coherent.

    Exported pages, which trace single rays, carry this kernel instead of `trace_first`: it is a third of the code.
    """
    scratch = new_scratch(geometry)
    for i in range(begin, end):
        put_hit(_single_hit(geometry, scratch, rays, i, False), i, found)


@kernel(width="picture n", begin="0..end", end="0..n", result="out n")
def trace_occluded(geometry: Geometry, rays: RayArrays, width: int, begin: int, end: int, result: Signs) -> None:
    """Write for each ray of tiles begin..end 1 if it has a crossing, else 0; plus DOUBTFUL if it is in doubt."""
    scratch, bundle, memory = new_scratch(geometry), new_packet(geometry), new_tile()
    lanes, count, several = bundle.lanes, len(rays.origins), len(rays.origins) > LANES
    for tile in range(begin, end):
        shared = several and open_tile(geometry, memory, lanes, rays, tile, width)
        for number in range(PACKETS):
            if several and number & 3 == 0:
                open_quarter(memory, number >> 2, bundle.items)
            prefetch_packet(rays, tile_packet(tile + 1, number, width, count), width)
            packet = tile_packet(tile, number, width, count)
            if packet < 0 or is_halted(geometry):
                continue
            fill_lanes(lanes, rays, packet, width, shared)
            together = is_coherent(geometry, lanes)
            if together:
                trace_packet(geometry, scratch, bundle, scratch.nothing, True)
            for row in range(8):
                first, n = packet_row(packet, row, width, count)
                for k in range(n):
                    i, lane = first + k, np.uint64(8 * row + k)
                    if together and lanes[DOUBT + lane] == 0.0:
                        result[i] = 1 if lanes[BEST + lane] < math.inf else 0
                        continue
                    hit = _single_hit(geometry, scratch, rays, i, True)
                    result[i] = (1 if hit.body >= 0 else 0) + (DOUBTFUL if hit.unsure else 0)


@kernel(order="n", size="1..65536", begin="0..end", end="0..n", found="out")
def trace_ordered(
    geometry: Geometry, rays: RayArrays, order: Ints, size: int, any_hit: bool, begin: int, end: int, found: HitBuffers
) -> None:
    """Write the first hits, or any hits, of rays order[size * begin : size * end], in streams of up to `size` rays.

    A stream ends where the octant of the directions changes. Rays whose direction needs scaling are traced singly.
    """
    scratch, stream, mine = new_scratch(geometry), new_stream(geometry, size), np.empty(size, np.int32)
    for number in range(begin, end):
        k, last = size * number, min(size * number + size, len(order))
        while k < last and not is_halted(geometry):
            count, octant = 0, -1
            while k < last:
                i = order[k]
                if k + _PREFETCH_DISTANCE < len(order):
                    ahead = 3 * whole(order[k + _PREFETCH_DISTANCE])
                    prefetch(rays.origins, ahead)
                    prefetch(rays.origins, ahead + 2)
                    prefetch(rays.directions, ahead)
                    prefetch(rays.directions, ahead + 2)
                ray = load_ray(rays, i)
                # A stream holds rays of one octant that need no scaling
                if ray.start != DEAD and scale_ray(ray)[1] == 1.0:
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
                prefetch_hits(mine[min(j + 8, count - 1)], found)
                put_hit(stream_hit(stream, j), mine[j], found)


@kernel(width="picture n", packets="1..n", samples="1..1048576")
def coherent_packets(geometry: Geometry, rays: RayArrays, width: int, packets: int, samples: int) -> int:
    """Return how many of a sample of packets, spread evenly over all, are coherent."""
    lanes, together = np.empty(SIZE), 0
    for k in range(samples):
        fill_lanes(lanes, rays, k * packets // samples, width, False)
        together += 1 if is_coherent(geometry, lanes) else 0
    return together
