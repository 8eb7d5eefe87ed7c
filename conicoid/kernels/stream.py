"""The stream route: first hits of rays in no order, thousands at a time, sorted so that neighbours are coherent.

All rays traverse the tree together: at a node every ray of a list is tested against the eight children, and goes on the
lists of those that it meets. So a node is fetched once for many rays, and the arithmetic of one hides the memory
latency of another. The directions lie in one octant; the children are visited in its order, the nearest first. After
Barringer and Akenine-Möller, Dynamic ray stream traversal (ACM TOG 33, 2014).

User: rays in no order, after bounces say; factor over single rays: 2.4 on 1,000 balls, 2.3 on 1,000 Booleans, 1.7 on
100,000 balls (processor time, one thread, 2026-11-28).
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from .._jit.decorators import allocator, choose, helper, inline, kernel
from .._jit.machine_code import empty_array
from . import tables as table
from .body.cell import NO_PLACE
from .body.hit import DOUBTFUL, Hit, ball_event, cull_limit, intersect_item, is_doubtful, nearer_hit, try_entry, turn_of
from .body.scratch import Scratch
from .bvh.culling import (
    FROM_THE_START,
    hit_balls,
    load_eight,
    lowest_bit,
    put_on_lists,
    rays_in_balls,
    records_in_lanes,
    waiting_ray,
)
from .bvh.walk import (
    leaf_at,
    leaf_ball,
    leaf_entry,
    leaf_index,
    leaf_item,
    leaf_kind,
    leaf_range,
    prefetch_node,
    reciprocal,
    scene_tree,
)
from .packet.csg_gather import (
    EVERY,
    BodyQueue,
    body_hit,
    count_forms,
    empty_queue,
    form_of,
    meet_bodies,
    new_bodies,
    put_body,
    queue_body,
)
from .ray import Ray, RayLine
from .surface.interval import lengths_of_ball, limits_of_ray
from .surface.quadric import SphereRecord, sphere_roots
from .tables import BALL, REGION, Floats, Geometry, Ints, Longs, Signs, integer, is_halted, length, node_at, whole
from .threads import KernelRange, run_chunks, thread_count

# The order of rays, in which neighbours see the same part of a scene
#
# Rays in no order are sorted by the octant of their direction, then by the point where they begin in the scene's box
# (or enter it), then by direction within the octant: a key of a few bits for each, and a stable radix sort by two
# digits of eight bits. Sixteen in a row are then coherent. After Garanzha and Loop, Fast ray sorting and breadth-first
# packet traversal (Eurographics 2010).

_CHUNK = 1 << 14  # least rays of a block
_DIGITS, _LOW, _HIGH = 256, 32, 40  # values of a digit, and where the two of a key begin in `key << 32 | number`
_FEW_BITS, _MORE_BITS, _MANY = 2, 3, 1 << 18  # bits of a key for each coordinate; from _MANY rays on the larger number
LANES, _ROWS = 64, 7
ORIGIN_X, ORIGIN_Y, ORIGIN_Z, DIRECTION_X, DIRECTION_Y, DIRECTION_Z, KEY = (
    np.uint64(row) for row in range(0, _ROWS * LANES, LANES)
)


class Triple(NamedTuple):
    """Three numbers."""

    x: float
    y: float
    z: float


class SceneBox(NamedTuple):
    """A box by its lowest and highest corner."""

    lx: float
    ly: float
    lz: float
    hx: float
    hy: float
    hz: float


@inline
def _spread_bits(x: int) -> int:
    """Return the bits of x (up to 5) with two zeros between each."""
    # Morton order: cells near in space get near keys
    return (x & 1) | (x & 2) << 2 | (x & 4) << 4 | (x & 8) << 6 | (x & 16) << 8


@helper
def scene_box(geometry: Geometry) -> SceneBox:
    """Return the box around all bounded entries of the scene; all zeros if it is empty or not finite."""
    box = SceneBox(math.inf, math.inf, math.inf, -math.inf, -math.inf, -math.inf)
    tree = length(geometry, table.TREE_ROOT) - 2
    for k in range(integer(geometry, table.TREE_ROOT, tree), integer(geometry, table.TREE_ROOT, tree + 1)):
        root = integer(geometry, table.ROOTS, k)
        if root < 0:
            continue
        at = node_at(geometry, root)
        for child in range(8):
            if integer(geometry, table.NODE_CHILDREN, 8 * root + child) != 0:
                b = geometry.floats
                box = SceneBox(
                    min(box.lx, b[at + child]), min(box.ly, b[at + 8 + child]), min(box.lz, b[at + 16 + child]),
                    max(box.hx, b[at + 24 + child]), max(box.hy, b[at + 32 + child]), max(box.hz, b[at + 40 + child]),
                )  # fmt: skip
    if not (box.lx > -math.inf and box.ly > -math.inf and box.lz > -math.inf):
        return SceneBox(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    if not (box.hx < math.inf and box.hy < math.inf and box.hz < math.inf):
        return SceneBox(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    return box


@inline
def _cell(x: float, low: float, scale: float, most: float) -> int:
    """Return which of the cells from `low` on, 1 / scale wide, holds x or is nearest to it; 0 for NaN."""
    share = (x - low) * scale
    # Comparisons with NaN are false, so that NaN becomes 0 here and not an undefined integer below
    share = choose(share > 0.0, share, 0.0)
    return whole(choose(share < most, share, most))


@inline
def _entry(o: float, d: float, low: float, high: float) -> float:
    """Return the t at which a ray enters a slab, if it begins before the slab; else 0 or less."""
    return choose(d != 0.0, (choose(d > 0.0, low, high) - o) / d, 0.0)


@inline
def _scale(low: float, high: float, cells: int) -> float:
    """Return cells for each unit of length between two ends; 0 for an empty interval."""
    return cells / (high - low) if high > low else 0.0


@inline
def _key(lanes: Floats, i: Any, box: SceneBox, scale: Triple, most: float, bits: int) -> None:
    """Compute the key of the ray in lane i."""
    ox, oy, oz, dx, dy, dz = (
        lanes[ORIGIN_X + i],
        lanes[ORIGIN_Y + i],
        lanes[ORIGIN_Z + i],
        lanes[DIRECTION_X + i],
        lanes[DIRECTION_Y + i],
        lanes[DIRECTION_Z + i],
    )
    tx, ty, tz = _entry(ox, dx, box.lx, box.hx), _entry(oy, dy, box.ly, box.hy), _entry(oz, dz, box.lz, box.hz)
    # The latest entry of three slabs is that of the box; a ray that begins inside keeps t = 0
    t = choose(tx > 0.0, tx, 0.0)
    t = choose(ty > t, ty, t)
    t = choose(tz > t, tz, t)
    x = _spread_bits(_cell(ox + t * dx, box.lx, scale.x, most))
    y = _spread_bits(_cell(oy + t * dy, box.ly, scale.y, most))
    z = _spread_bits(_cell(oz + t * dz, box.lz, scale.z, most))
    # Two coordinates on the octahedron place a direction in its octant; the third follows
    quarter = 4.0 / (abs(dx) + abs(dy) + abs(dz))
    u, v = _cell(abs(dx), 0.0, quarter, 3.0), _cell(abs(dy), 0.0, quarter, 3.0)
    octant = whole(choose(dx < 0.0, 1.0, 0.0) + choose(dy < 0.0, 2.0, 0.0) + choose(dz < 0.0, 4.0, 0.0))
    # As a float, in a row of lanes like the others: keys of 16 bits are exact
    lanes[KEY + i] = float((octant << (3 * bits) | x | y << 1 | z << 2) << 4 | u << 2 | v)


@inline
def _block(count: int, blocks: int, k: int) -> int:
    """Return the first of `count` items in block k."""
    return count * k // blocks


@kernel(
    origins="n 3", directions="n 3", bits="2..3", begin="0..end", end="0..blocks", rays="out n",
    counts="out blocks 256",
)  # fmt: skip
def ray_keys(
    geometry: Geometry, origins: Floats, directions: Floats, bits: int, begin: int, end: int, rays: Longs, counts: Ints
) -> None:  # fmt: skip
    """Write the rays of blocks begin..end as `key << 32 | number`, and count the low digits of the keys of each."""
    box, lanes, cells, total = scene_box(geometry), np.ones(_ROWS * LANES), 1 << bits, len(origins)
    scale = Triple(_scale(box.lx, box.hx, cells), _scale(box.ly, box.hy, cells), _scale(box.lz, box.hz, cells))
    for block in range(begin, end):
        # A block counts in memory of its own: threads that write to one line of the cache wait for each other
        mine, last = np.zeros(_DIGITS, np.int32), _block(total, len(counts), block + 1)
        for first in range(_block(total, len(counts), block), last, LANES):
            count = min(LANES, last - first)
            for k in range(0, count & -8, 8):
                load_eight(origins, first + k, lanes, ORIGIN_X + np.uint64(k))
                load_eight(directions, first + k, lanes, DIRECTION_X + np.uint64(k))
            for k in range(count & -8, count):
                for axis in range(3):
                    at = np.uint64(LANES * axis + k)
                    lanes[ORIGIN_X + at], lanes[DIRECTION_X + at] = (
                        origins[first + k, axis],
                        directions[first + k, axis],
                    )
            for i in range(np.uint64(LANES)):
                _key(lanes, i, box, scale, cells - 1.0, bits)
            for k in range(count):
                key = whole(lanes[KEY + np.uint64(k)])
                rays[first + k] = key << 32 | first + k
                mine[key & _DIGITS - 1] += 1
        for digit in range(_DIGITS):
            counts[block, digit] = mine[digit]


@kernel(rays="n", begin="0..end", end="0..blocks", counts="out blocks 256")
def _count_digits(rays: Longs, begin: int, end: int, counts: Ints) -> None:
    """Count the high digits of the keys in blocks begin..end."""
    for block in range(begin, end):
        mine = np.zeros(_DIGITS, np.int32)
        for i in range(_block(len(rays), len(counts), block), _block(len(rays), len(counts), block + 1)):
            mine[rays[i] >> _HIGH & _DIGITS - 1] += 1
        for digit in range(_DIGITS):
            counts[block, digit] = mine[digit]


@kernel(rays="n", begin="0..end", end="0..blocks", places="blocks 256", ordered="out n|0", order="out n|0")
def _place(rays: Longs, begin: int, end: int, places: Ints, ordered: Longs, order: Ints) -> None:
    """Write the rays of blocks begin..end to their places by a digit of their keys; ties keep their order.

    By the low digit into `ordered`; if that is empty, by the high digit their numbers alone into `order`.
    """
    blocks, shift = len(places), _LOW if len(ordered) > 0 else _HIGH
    for block in range(begin, end):
        mine = places[block].copy()
        for i in range(_block(len(rays), blocks, block), _block(len(rays), blocks, block + 1)):
            digit = rays[i] >> shift & _DIGITS - 1
            place = mine[digit]
            mine[digit] = place + 1
            if not 0 <= place < len(rays):  # no counts of these rays
                continue
            if len(ordered) > 0:
                ordered[place] = rays[i]
            elif len(order) > 0:  # both may be empty where a caller is wrong
                order[place] = whole(rays[i] & 0xFFFFFFFF)


@kernel(counts="out * *")
def _begin_places(counts: Ints) -> None:
    """Replace the count of every digit in every block by the place of its first ray: by digit, then by block."""
    total = 0
    for digit in range(counts.shape[1]):
        for block in range(counts.shape[0]):
            count = counts[block, digit]
            counts[block, digit] = total
            total += count


def ray_order(geometry: Geometry, origins: Floats, directions: Floats) -> Ints:
    """Return the numbers of rays, int32, in an order in which neighbours are coherent; each number occurs once."""
    count = len(origins)
    # A finer key for many rays, since more of them share a cell
    bits = _MORE_BITS if count >= _MANY else _FEW_BITS
    # Four blocks for each thread, so that a slow thread holds up a quarter of its share only
    blocks = max(1, min(4 * thread_count(), count // _CHUNK))
    order, nothing = empty_array(count, np.int32), np.empty(0, np.int32)
    rays, ordered, none = empty_array(count, np.int64), empty_array(count, np.int64), np.empty(0, np.int64)
    # Each block counts on its own; prefix sums over digits, then blocks, keep the sort stable, whatever the threads
    counts = np.empty((blocks, _DIGITS), np.int32)

    run_chunks(KernelRange(ray_keys, (geometry, origins, directions, bits), (rays, counts)), blocks, 1)
    _begin_places(counts)
    run_chunks(KernelRange(_place, (rays,), (counts, ordered, nothing)), blocks, 1)
    run_chunks(KernelRange(_count_digits, (ordered,), (counts,)), blocks, 1)
    _begin_places(counts)
    run_chunks(KernelRange(_place, (ordered,), (counts, none, order)), blocks, 1)
    return order


# Pairs of a ray and a ball that it may meet: 64 are tested at once, in lanes
#
# A pair is a lane, whatever leaf the ball is from. It is tested by the formulas of `try_ball`, to the same bits. The
# nearer hit is chosen afterwards, one pair after the other, since two pairs may have the same ray.

MOST_PAIRS = 64

# Rows of 64 lanes: the two records of a ray (`Stream`), the ball, the result
(
    OX, OY, OZ, _IX, _IY, _IZ, PAIR_T_MIN, _LAST, DX, DY, DZ, PAIR_INVERSE, PAIR_START, PAIR_T_MAX, _BEST, _OFF,
    X, Y, Z, RADIUS, SURFACE, PAIR_BODY, PAIR_ENTRY, T, ERROR, ENTERS, UNSURE,
) = (np.uint64(row) for row in range(0, 27 * MOST_PAIRS, MOST_PAIRS))  # fmt: skip
_SECOND = 8 * MOST_PAIRS


class Pairs(NamedTuple):
    """Queued pairs."""

    lanes: Floats
    rays: Any  # (64,) int64: their rays


@allocator
def new_pairs() -> Pairs:
    """Return memory of pairs for one thread."""
    return Pairs(np.zeros(27 * MOST_PAIRS), np.zeros(MOST_PAIRS, np.int64))


@inline
def put_pair(pairs: Pairs, at: int, ray: int, geometry: Geometry, leaf: int, size: int, place: int) -> None:
    """Write pair number `at`: a ray of a stream, and the ball at a place of the leaf of `size` items at `leaf`."""
    lanes, i = pairs.lanes, np.uint64(at)
    pairs.rays[i] = ray
    ball, item = leaf_ball(geometry, leaf, size, place), leaf_item(geometry, leaf, size, place)
    lanes[X + i], lanes[Y + i], lanes[Z + i], lanes[RADIUS + i] = ball
    lanes[SURFACE + i], lanes[PAIR_BODY + i], lanes[PAIR_ENTRY + i] = (
        float(item.index),
        float(item.body),
        float(item.entry),
    )


@helper
def meet_pairs(pairs: Pairs, rays: Floats, more: Floats, count: int) -> None:
    """Intersect the rays of the first `count` pairs with their balls; `rays` and `more` hold eight numbers a ray."""
    lanes, numbers = pairs.lanes, pairs.rays
    # Lanes beyond the last pair repeat the first: they are computed, and nobody reads them
    for k in range(count, (count + 7) & -8):
        numbers[k] = numbers[0]
    for k in range(0, count, 8):
        records_in_lanes(rays, numbers, k, lanes, k)
        records_in_lanes(more, numbers, k, lanes, _SECOND + k)
    for i in range(np.uint64(count + 7) & np.uint64(120)):
        _test_lane(lanes, i)


@inline
def _test_lane(lanes: Floats, i: Any) -> None:
    """Intersect the ray of a pair with its ball, without branches."""
    line = RayLine(lanes[OX + i], lanes[OY + i], lanes[OZ + i], lanes[DX + i], lanes[DY + i], lanes[DZ + i])
    sphere, inverse = SphereRecord(lanes[X + i], lanes[Y + i], lanes[Z + i], lanes[RADIUS + i]), lanes[PAIR_INVERSE + i]
    t_min, t_max, start = lanes[PAIR_T_MIN + i], lanes[PAIR_T_MAX + i], lanes[PAIR_START + i]
    starts = start == lanes[SURFACE + i]
    nearness = limits_of_ray(
        Ray(line.ox, line.oy, line.oz, line.dx, line.dy, line.dz, t_min, t_max, start), inverse, lengths_of_ball(sphere)
    )
    roots = sphere_roots(sphere, line, inverse, starts)
    t, enters, unsure = ball_event(roots, starts, t_min, t_max, nearness)
    lanes[T + i], lanes[ERROR + i] = t, nearness.off
    lanes[ENTERS + i] = 1.0 if enters else 0.0
    lanes[UNSURE + i] = 1.0 if unsure else 0.0


@inline
def pair_hit(pairs: Pairs, at: int) -> Hit:
    """Return the crossing of pair number `at`; t = inf if the ray does not meet the ball."""
    lanes, i = pairs.lanes, np.uint64(at)
    return Hit(
        lanes[T + i], whole(lanes[PAIR_BODY + i]), whole(lanes[PAIR_ENTRY + i]), whole(NO_PLACE), whole(1),
        lanes[ENTERS + i] == 1.0, lanes[ERROR + i], lanes[UNSURE + i] == 1.0,
    )  # fmt: skip


# The stream

# Eight numbers of a ray for box tests, in the order of `put_on_lists`: one line of the cache
ORIGIN, SLOPES, T_MIN, LAST = 0, 3, 6, 7
# Eight more, for tests of balls, with t and error bound of its hit; in the order of the rows of `Pairs`
D, INVERSE, START, T_MAX, BEST, OFF = 0, 3, 4, 5, 6, 7
# The rest of its hit
BODY, ENTRY, PLACE, TURN = 0, 1, 2, 3
_SEVERAL = 3  # least number of rays that a leaf tests together


class Stream(NamedTuple):
    """Memory of a stream of rays."""

    rays: Floats  # 8 numbers each
    more: Floats  # 8 numbers each
    hits: Ints  # 4 numbers each
    lists: Any  # int64: rays that meet a node or leaf, list after list, each with its t of entry (`waiting_ray`)
    stack: Ints  # 4 each: code of a node or leaf, begin of its list, its number of rays, end of its siblings' lists
    keys: Floats  # (8,) distances of a node's children along the first ray
    counts: Ints  # (8,) rays that meet each child
    tests: Any  # (136,) int64: tests of a leaf that culling left: 16 ray + place of the item
    pairs: Pairs
    bodies: BodyQueue


@allocator
def new_stream(geometry: Geometry, most: int) -> Stream:
    """Return memory for streams of up to `most` rays, for one thread."""
    depth = integer(geometry, table.TREE_DEPTH, 0)
    room = (most + 8) * (depth + 16)  # a list takes a multiple of eight
    return Stream(
        np.empty(8 * most), np.empty(8 * most), np.empty(4 * most, np.int32), np.empty(room, np.int64),
        np.empty(4 * (depth + 16), np.int32), np.empty(8), np.empty(8, np.int32), np.empty(136, np.int64), new_pairs(),
        new_bodies(geometry, EVERY),
    )  # fmt: skip


@inline
def put_stream_ray(stream: Stream, k: int, ray: Ray) -> None:
    """Write ray k of a stream, without a hit."""
    ox, oy, oz, dx, dy, dz, t_min, t_max, start = ray
    rays, more, hits, at, what = stream.rays, stream.more, stream.hits, np.uint64(8 * k), np.uint64(4 * k)
    rays[at + ORIGIN], rays[at + ORIGIN + 1], rays[at + ORIGIN + 2] = ox, oy, oz
    rays[at + SLOPES], rays[at + SLOPES + 1], rays[at + SLOPES + 2] = reciprocal(dx), reciprocal(dy), reciprocal(dz)
    rays[at + T_MIN], rays[at + LAST] = t_min, t_max
    more[at + D], more[at + D + 1], more[at + D + 2] = dx, dy, dz
    more[at + INVERSE], more[at + START] = 1.0 / (dx * dx + dy * dy + dz * dz), start
    more[at + T_MAX], more[at + BEST], more[at + OFF] = t_max, math.inf, 0.0
    hits[what + BODY], hits[what + ENTRY], hits[what + PLACE], hits[what + TURN] = -1, -1, -1, 1


@inline
def _ray(stream: Stream, k: int) -> Ray:
    """Return ray k of a stream."""
    rays, more, at = stream.rays, stream.more, np.uint64(8 * k)
    return Ray(
        rays[at + ORIGIN], rays[at + ORIGIN + 1], rays[at + ORIGIN + 2],
        more[at + D], more[at + D + 1], more[at + D + 2], rays[at + T_MIN], more[at + T_MAX], whole(more[at + START]),
    )  # fmt: skip


@inline
def octant_of(x: float, y: float, z: float) -> int:
    """Return the octant of a direction: bit k is set where coordinate k is negative."""
    return (1 if x < 0.0 else 0) | (2 if y < 0.0 else 0) | (4 if z < 0.0 else 0)


@inline
def _octant(stream: Stream) -> int:
    """Return the octant of the directions of a stream."""
    return octant_of(stream.more[D], stream.more[D + 1], stream.more[D + 2])


@inline
def stream_hit(stream: Stream, k: int) -> Hit:
    """Return the hit of ray k so far."""
    more, hits, at, what = stream.more, stream.hits, np.uint64(8 * k), np.uint64(4 * k)
    unsure = is_doubtful(hits[what + TURN])
    turn = whole(hits[what + TURN] - (DOUBTFUL if unsure else 0))
    sense = whole(1 if turn > 0 else -1)
    body, entry, place = whole(hits[what + BODY]), whole(hits[what + ENTRY]), whole(hits[what + PLACE])
    return Hit(more[at + BEST], body, entry, place, sense, turn != sense, more[at + OFF], unsure)


@inline
def _keep(stream: Stream, k: int, hit: Hit, any_hit: bool) -> None:
    """Write a new hit of ray k, and shorten the ray to it; with `any_hit` a ray with a hit ends at once."""
    more, hits, at, what = stream.more, stream.hits, np.uint64(8 * k), np.uint64(4 * k)
    more[at + BEST], more[at + OFF] = hit.t, hit.off
    hits[what + BODY], hits[what + ENTRY], hits[what + PLACE], hits[what + TURN] = (
        hit.body,
        hit.entry,
        hit.place,
        turn_of(hit),
    )
    # An interval that ends at -inf meets no box, so that such a ray leaves all lists by itself
    done = any_hit and hit.entry >= 0
    stream.rays[at + LAST] = -math.inf if done else min(more[at + T_MAX], cull_limit(hit))


@inline
def _compare(geometry: Geometry, stream: Stream, k: int, new: Hit, any_hit: bool) -> None:
    """Keep the nearer of the hit of ray k and a new one, which may be a miss."""
    at = np.uint64(8 * k)
    # Most pairs are far behind the hit, and need no rule of ties; `not >` lets NaN of two misses through
    if new.unsure or not new.t - stream.more[at + BEST] > new.off + stream.more[at + OFF]:
        _keep(stream, k, nearer_hit(geometry, stream_hit(stream, k), new), any_hit)


@helper
def _settle_pairs(geometry: Geometry, stream: Stream, waiting_pairs: int, any_hit: bool) -> int:
    """Test the queued pairs, and keep the nearer hits in the order of the queue; return 0, the new length."""
    meet_pairs(stream.pairs, stream.rays, stream.more, waiting_pairs)
    for n in range(waiting_pairs):
        _compare(geometry, stream, stream.pairs.rays[n], pair_hit(stream.pairs, n), any_hit)
    return 0


@helper
def _settle_bodies(geometry: Geometry, scratch: Scratch, stream: Stream, form: int, any_hit: bool) -> None:
    """Test the queued bodies of a form, and keep the nearer hits in the order of the queue."""
    bodies, count = stream.bodies, empty_queue(stream.bodies, form)
    for n in range(meet_bodies(geometry, bodies, form, stream.rays, stream.more, count)):
        (k, entry), hit = queue_body(bodies, form, n), body_hit(geometry, bodies, form, n)
        if hit.unsure:  # single rays are in doubt less often
            _keep(stream, k, try_entry(geometry, scratch, entry, _ray(stream, k), stream_hit(stream, k)), any_hit)
        elif hit.t < math.inf:
            _compare(geometry, stream, k, hit, any_hit)


@inline
def _descend(
    geometry: Geometry, stream: Stream, octant: int, node: int, begin: int, count: int, room: int, top: int
) -> int:
    """Write the rays of a list to the lists of the node's children that they meet; return the height of the stack."""
    lists, counts, its = stream.lists, stream.counts, (count + 7) & -8
    at = node_at(geometry, node)
    put_on_lists(geometry.floats, at, octant, stream.rays, lists, begin, count, room, counts)
    # The nearest on top, along the first ray of the list
    first, base, boxes = 8 * waiting_ray(lists[begin])[0], top, geometry.floats
    dx, dy, dz = stream.more[first + D], stream.more[first + D + 1], stream.more[first + D + 2]
    stack, keys = stream.stack, stream.keys
    for child in range(8):
        code = integer(geometry, table.NODE_CHILDREN, 8 * node + child)
        if counts[child] == 0 or code == 0:
            continue
        prefetch_node(geometry, code)
        # Twice the center of the box along the direction
        key = (
            (boxes[at + child] + boxes[at + 24 + child]) * dx
            + (boxes[at + 8 + child] + boxes[at + 32 + child]) * dy
            + (boxes[at + 16 + child] + boxes[at + 40 + child]) * dz
        )
        slot = top
        while slot > base and keys[slot - base - 1] < key:
            keys[slot - base] = keys[slot - base - 1]
            for j in range(4):
                stack[4 * slot + j] = stack[4 * (slot - 1) + j]
            slot -= 1
        keys[slot - base] = key
        stack[4 * slot], stack[4 * slot + 1] = code, room + its * child
        stack[4 * slot + 2], stack[4 * slot + 3] = counts[child], room + 8 * its
        top += 1
    return top


@inline
def _sift(geometry: Geometry, stream: Stream, at: int, size: int, begin: int, left: int) -> int:
    """Write the tests of a leaf's items with the first eight rays of a list that culling leaves; return how many."""
    lists, tests, count = stream.lists, stream.tests, 0
    if left >= _SEVERAL:
        return rays_in_balls(geometry.floats, at, size, stream.rays, stream.more, lists, begin, left, tests)
    for j in range(begin, begin + left):
        k, t = waiting_ray(lists[j])
        reach = stream.rays[8 * k + LAST]
        if t > reach:
            continue
        ray, inverse = _ray(stream, k), stream.more[8 * k + INVERSE]
        for eight in range(0, size, 8):
            bits = hit_balls(geometry.floats, at + eight, size, size - eight, ray, inverse, reach)
            while bits != 0:
                tests[count] = k << 4 | eight + lowest_bit(bits)
                bits &= bits - 1
                count += 1
    return count


@inline
def _meet(
    geometry: Geometry, scratch: Scratch, stream: Stream, code: int, rays: tuple[int, int], paired: int,
    blocks: Signs, any_hit: bool,
) -> int:  # fmt: skip
    """Intersect a leaf with the list of rays (begin, count); return the number of queued pairs with balls."""
    (first, last), (begin, count) = leaf_range(code), rays
    at, size = leaf_at(geometry, first), last - first
    for j in range(begin, begin + count, 8):
        for n in range(_sift(geometry, stream, at, size, j, begin + count - j)):
            k, place = stream.tests[n] >> 4, stream.tests[n] & 15
            if len(blocks) > 0 and blocks[leaf_entry(geometry, at, size, place)] == 0:
                continue
            kind = leaf_kind(geometry, at, size, place)
            if kind == BALL:
                put_pair(stream.pairs, paired, k, geometry, at, size, place)
                paired += 1
                if paired == MOST_PAIRS:
                    paired = _settle_pairs(geometry, stream, paired, any_hit)
                continue
            if kind == REGION and stream.rays[8 * k + T_MIN] >= 0.0:  # lanes rely on t >= 0
                form = form_of(geometry, stream.bodies, leaf_index(geometry, at, size, place))
                if form >= 0:
                    if put_body(stream.bodies, form, k, leaf_entry(geometry, at, size, place)):
                        _settle_bodies(geometry, scratch, stream, form, any_hit)
                    continue
            item, ball = leaf_item(geometry, at, size, place), leaf_ball(geometry, at, size, place)
            best, ray, inverse = stream_hit(stream, k), _ray(stream, k), stream.more[8 * k + INVERSE]
            hit = intersect_item(geometry, scratch, item, ball, ray, inverse, best)
            if hit.t != best.t or hit.body != best.body or hit.unsure != best.unsure:
                _keep(stream, k, hit, any_hit)
    return paired


@helper
def trace_stream(
    geometry: Geometry, scratch: Scratch, stream: Stream, count: int, blocks: Signs, any_hit: bool
) -> None:
    """Find the first hits, or any hits, of the first `count` rays of a stream; `stream_hit` reads them.

    Only bodies with blocks[body] != 0 count, or all, if `blocks` is empty. Relies on all directions being of one
    octant. A ray's LAST bounds the t of crossings that can still be nearer than its hit; any-hit rays leave the stream
    by LAST = -inf.
    """
    if count == 0:
        return
    stack, tree, octant = stream.stack, scene_tree(geometry), _octant(stream)
    for k in range(count):
        stream.lists[k] = k + FROM_THE_START
    first, top, paired = integer(geometry, table.TREE_ROOT, tree), 0, 0
    for k in range(first, integer(geometry, table.TREE_ROOT, tree + 1)):
        stack[4 * top], stack[4 * top + 1] = integer(geometry, table.ROOTS, k), 0
        stack[4 * top + 2], stack[4 * top + 3] = count, (count + 7) & -8
        top += 1
    while top > 0 and not is_halted(geometry):
        top -= 1
        # `room`: where lists end that are still needed; new ones begin there
        code, begin, its, room = stack[4 * top], stack[4 * top + 1], stack[4 * top + 2], stack[4 * top + 3]
        if code >= 0:
            top = _descend(geometry, stream, octant, code, begin, its, room, top)
        else:
            paired = _meet(geometry, scratch, stream, code, (begin, its), paired, blocks, any_hit)
    _settle_pairs(geometry, stream, paired, any_hit)
    for form in range(count_forms(stream.bodies)):
        _settle_bodies(geometry, scratch, stream, form, any_hit)
