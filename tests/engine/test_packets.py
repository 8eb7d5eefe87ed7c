"""Packets: lists of nodes and items, frontiers of tiles, squares of samples, crowds of small bodies, scan lines."""

from __future__ import annotations

import math

import numba
import numpy as np
import pytest

import conicoid as co
from conicoid.kernels.bvh.culling import (
    BOX_OR_BALL,
    CODE,
    ENTERED,
    FROM_THE_START,
    ITEM_ROW,
    ITEMS_SIZE,
    MOST_ITEMS,
    group_in_ball,
    lanes_entering,
    put_balls,
    put_children,
    put_entries,
    put_groups,
    put_numbers,
    put_on_lists,
    put_reaches,
    rays_in_balls,
    waiting_ray,
)
from conicoid.kernels.bvh.walk import reciprocal, scene_tree
from conicoid.kernels.packet.frontier import (
    ITEM_COUNT,
    _put_in_buckets,
    find_frontier,
    narrow_frontier,
    new_frontier,
    new_level,
    new_tile,
    open_tile,
)
from conicoid.kernels.packet.lanes import (
    BEST,
    EARLIEST,
    GROUPS_AT,
    SIZE,
    close_lanes,
    put_group_beams,
    put_ray,
    put_slopes,
)
from conicoid.kernels.ray import Ray
from conicoid.queries.ray_queries import arrays_of

# --- Lists of rays against eight boxes: all that meet a box are on its list, whatever is left in the last eight


@numba.njit
def put(boxes, octant, rays, lists, begin, count, room, counts):
    put_on_lists(boxes, 0, octant, rays, lists, begin, count, room, counts)


@numba.njit
def unpacked(packed):
    return waiting_ray(packed)


def case(rays, seed, octant):
    """Boxes (8, 6), origins, directions and (first, last) t of some rays, which look into one octant."""
    rng = np.random.default_rng(seed)
    low = rng.uniform(-1, 0.5, (8, 3))
    boxes = np.concatenate([low, low + rng.uniform(0.1, 1, (8, 3))], axis=1)
    # Towards the middle of one of them, or along a side
    falls = [axis for axis in range(3) if octant >> axis & 1]
    targets = boxes[np.arange(rays) % 8].reshape(rays, 2, 3).mean(axis=1)
    directions = np.abs(targets - rng.uniform(-2, 2, (rays, 3)))
    directions[:, falls] *= -1
    origins = targets - directions
    if octant != 7:
        directions[1::3, rng.choice([axis for axis in range(3) if axis not in falls])] = 0.0
    limits = np.stack([rng.uniform(-1, 0.2, rays), rng.uniform(0.9, 2, rays)], axis=1)
    return boxes, origins, directions, limits


def stretch(box, origin, direction, limits):
    """(first, last) t in a box, by the planes of its sides one after the other; no stretch where first > last."""
    first, last = limits
    for k in range(3):
        if direction[k] == 0.0:
            if not box[k] <= origin[k] <= box[k + 3]:
                return math.inf, -math.inf
            continue
        ends = sorted(((box[k] - origin[k]) / direction[k], (box[k + 3] - origin[k]) / direction[k]))
        first, last = max(first, ends[0]), min(last, ends[1])
    return first, last


def listed(boxes, octant, origins, directions, limits, entries, begin):
    """What `put_on_lists` puts on the lists of eight boxes: dictionaries from rays to packed numbers."""
    slopes = np.array([[reciprocal(d) for d in row] for row in directions.tolist()])
    rays = np.concatenate([origins, slopes, limits], axis=1).ravel()
    count, room = len(entries), begin + len(entries) + 3
    lists, counts = np.full(room + 8 * (count + 8) + 8, -1, np.int64), np.zeros(8, np.int32)
    lists[begin : begin + count] = entries
    put(np.ascontiguousarray(boxes.T).ravel(), octant, rays, lists, begin, count, room, counts)
    stride = -(-count // 8) * 8
    assert lists[begin : begin + count].tolist() == list(entries), "the list itself is kept"
    parts = [lists[room + k * stride : room + k * stride + counts[k]].tolist() for k in range(8)]
    return [{unpacked(packed)[0]: unpacked(packed)[1] for packed in part} for part in parts], counts


@pytest.mark.parametrize("count", [1, 2, 7, 8, 9, 16, 37])
@pytest.mark.parametrize("octant", range(8))
def test_every_ray_that_meets_a_box_is_on_its_list(count, octant):
    boxes, origins, directions, limits = case(count, 8 * count + octant, octant)
    entries = np.arange(count) + FROM_THE_START
    found, counts = listed(boxes, octant, origins, directions, limits, entries, begin=5)
    met = 0
    for k in range(8):
        assert len(found[k]) == counts[k], "no ray is on a list twice"
        for i in range(count):
            first, last = stretch(boxes[k], origins[i], directions[i], limits[i])
            assert abs(first - last) > 1e-9, "no ray of this case touches a box"
            assert (i in found[k]) == (first < last)
            if i in found[k]:
                met += 1
                # Never later than it enters; the lower half of the bits of t is missing, where t > 0
                assert found[k][i] <= first + 1e-14
                assert first <= 0.0 or found[k][i] >= first * (1 - 2e-6)
    assert met > 0


def test_rays_that_have_met_something_nearer_are_left_out():
    """The box lies at t in [1, 2] on every ray; rays wait to enter what is around it since t = 0.75, and end at 0.5 or 3."""
    boxes = np.tile([[1.0, -1, -1, 2, 1, 1]], (8, 1))
    origins, directions = np.zeros((20, 3)), np.tile([[1.0, 0, 0]], (20, 1))
    limits = np.array([(0.0, 0.5 if i % 3 == 0 else 3.0) for i in range(20)])
    entries = (np.full(20, 0.75).view(np.int64) & ~0xFFFFFFFF) + np.arange(20)
    found, _ = listed(boxes, 0, origins, directions, limits, entries, begin=0)
    expected = [i for i in range(20) if i % 3 != 0]
    assert [sorted(part) for part in found] == [expected] * 8
    assert set(found[0].values()) == {1.0}


def test_a_ray_that_waits_from_the_start_waits_since_ever():
    assert unpacked(np.int64(12345 + FROM_THE_START)) == (12345, -math.inf)
    below = (np.array([-2.5]).view(np.int64)[0] & ~0xFFFFFFFF) + 7
    assert unpacked(np.int64(below)) == (7, -math.inf)


@numba.njit
def sift(balls, size, rays, more, lists, begin, left, pairs):
    return rays_in_balls(balls, 0, size, rays, more, lists, begin, left, pairs)


@pytest.mark.parametrize("left", [1, 3, 8, 11])
def test_every_ray_that_meets_a_ball_is_told(left):
    """By the distance from the center to the stretch of the ray, in coordinates of the foot of the perpendicular."""
    rng = np.random.default_rng(left)
    size, count = 5, 12
    centers, radii = rng.uniform(-1, 1, (size, 3)), rng.uniform(0.2, 0.9, size)
    origins, limits = rng.uniform(-2, 2, (count, 3)), np.stack([np.zeros(count), rng.uniform(0.5, 3, count)], axis=1)
    directions = centers[np.arange(count) % size] + rng.normal(scale=0.5, size=(count, 3)) - origins
    rays = np.concatenate([origins, np.ones((count, 3)), limits], axis=1).ravel()
    squares = (directions**2).sum(axis=1)
    more = np.concatenate([directions, 1 / squares[:, None], np.full((count, 4), np.nan)], axis=1).ravel()
    order = rng.permutation(count)[:left]
    lists, pairs = np.full(20, 1 << 40), np.zeros(8 * size + 8, np.int64)
    lists[2 : 2 + left] = order + FROM_THE_START
    found = sift(np.concatenate([centers.T.ravel(), radii]), size, rays, more, lists, 2, left, pairs)
    told = [(pair & 15, pair >> 4) for pair in pairs[:found].tolist()]
    assert told == sorted(set(told), key=lambda pair: (pair[0], order[:8].tolist().index(pair[1]))), (
        "by ball, each once"
    )
    for k in range(size):
        for lane in range(8):
            if lane >= left:
                continue
            i = order[lane]
            foot = (centers[k] - origins[i]) @ directions[i] / squares[i]
            off = np.linalg.norm(origins[i] + foot * directions[i] - centers[k])
            half = math.sqrt(max(0.0, radii[k] ** 2 - off**2) / squares[i])
            meets = off < radii[k] and foot - half < limits[i, 1] and foot + half > limits[i, 0]
            assert ((k, i) in told) == meets


# --- What a tile sees: no box or ball that one of its rays meets is ever left out, and nothing is counted twice


def beam_of(origins, directions):
    """The block of numbers of the beam that holds some rays, from t = 0 on."""
    slopes = [
        [reciprocal(d) for d in row] for row in (directions.min(axis=0).tolist(), directions.max(axis=0).tolist())
    ]
    return np.concatenate([origins.min(axis=0), origins.max(axis=0), *slopes, [0.0, math.inf]])


def some_rays(rng, count, spread):
    origin = rng.uniform(-2, 2, 3)
    direction = rng.uniform(-0.5, 0.5, 3) - origin
    return origin + rng.uniform(-spread, spread, (count, 3)), direction + rng.uniform(-spread, spread, (count, 3))


@numba.njit
def children(boxes, codes, beam, found, t, end):
    return put_children(boxes, 0, codes, 0, 16, beam, 0, found, t, end)


@pytest.mark.parametrize("spread", [0.0, 0.05, 0.4])
def test_children_that_a_ray_of_the_beam_meets_are_found(spread):
    rng, met = np.random.default_rng(int(100 * spread)), 0
    for _ in range(100):
        low = rng.uniform(-1, 0.5, (8, 3))
        boxes = np.concatenate([low, low + rng.uniform(0.1, 1, (8, 3))], axis=1)
        codes = np.array([3, -20, 0, 7, -5, 9, 0, 2], np.int32)
        origins, directions = some_rays(rng, 20, spread)
        found, t = np.full(20, 99, np.int64), np.full(20, -7.0)
        count = children(boxes.T.ravel().copy(), codes, beam_of(origins, directions), found, t, 2)
        items = {
            int(number >> 32): (int(np.int32(number & 0xFFFFFFFF)), t[2 + j])
            for j, number in enumerate(found[2 : 2 + count])
        }
        assert found[:2].tolist() == [99, 99]
        assert len(items) == count
        for k in range(8):
            rays = [stretch(boxes[k], o, d, (0.0, math.inf)) for o, d in zip(origins, directions, strict=True)]
            meets = codes[k] != 0 and any(first < last for first, last in rays)
            met += meets
            if meets:
                code, entered = items[16 + k]
                assert code == codes[k]
                assert entered <= min(first for first, last in rays if first < last) + 1e-12
            elif spread == 0.0 or codes[k] == 0:
                assert 16 + k not in items
    assert met > 50


@numba.njit
def leaf(balls, count, beam, items, end):
    return put_balls(balls, 0, count, -77, beam, 0, items, end)


@numba.njit
def numbers(first, bits, found, end):
    put_numbers(first, bits, found, end)


@pytest.mark.parametrize("count", [1, 3, 8])
def test_balls_of_a_leaf_become_items_in_boxes_that_hold_them(count):
    rng, met = np.random.default_rng(count), 0
    for _ in range(60):
        centers, radii = rng.uniform(-1, 1, (count, 3)), rng.uniform(0.1, 0.6, count)
        origins, directions = some_rays(rng, 10, 0.1)
        items = np.full(ITEMS_SIZE, np.nan)
        floats = np.concatenate([centers.T.ravel(), radii, np.zeros(8)])
        end = 5 + leaf(floats, count, beam_of(origins, directions), items, 5)
        balls = {int(-2 - items[BOX_OR_BALL + k]): k for k in range(5, end)}
        assert len(balls) == end - 5
        for j in range(count):
            apart = np.linalg.norm(np.cross(centers[j] - origins, directions), axis=1) / np.linalg.norm(
                directions, axis=1
            )
            ahead = ((centers[j] - origins) * directions).sum(axis=1) > 0
            if (ahead & (apart < radii[j])).any():
                met += 1
                k = balls[j]
                sides = items[k : 6 * ITEM_ROW : ITEM_ROW]
                assert (sides[:3] <= centers[j] - radii[j]).all()
                assert (sides[3:] >= centers[j] + radii[j]).all()
                assert items[CODE + k] == -77
                assert 0.0 <= items[ENTERED + k] < math.inf
    assert met >= 10


def test_numbers_told_by_bits_are_put_one_after_the_other():
    found = np.full(12, -1, np.int64)
    numbers(40, 0b10100110, found, 2)
    assert found[:6].tolist() == [-1, -1, 41, 42, 45, 47]


def test_what_a_quarter_meets_is_kept_in_order():
    """Items in slabs along x, of which beams along y meet some: told by their places alone."""
    count = 1000
    rng = np.random.default_rng(3)
    x = rng.uniform(0, 1, count)
    everything, some = new_frontier(), new_frontier()
    everything[ITEM_COUNT] = count
    for row, values in enumerate((x, -1.0, -1.0, x + 0.01, 1.0, 1.0, np.arange(count), np.arange(count), -2.0)):
        everything[row * ITEM_ROW : row * ITEM_ROW + count] = values
    beam = np.concatenate([[0.4, -9, 0], [0.5, -9, 0], [reciprocal(0.0), 1, reciprocal(0.0)] * 2, [0.0, math.inf]])
    numba.njit(lambda a, b, c: narrow_frontier(a, b, 0, c))(everything, beam, some)
    expected = np.flatnonzero((x <= 0.5) & (x + 0.01 >= 0.4))
    assert some[ITEM_COUNT] == len(expected)
    assert some[CODE : CODE + len(expected)].tolist() == expected.tolist()
    assert np.array_equal(some[: len(expected)], x[expected])


@numba.njit
def groups_at_ball(lanes, rays, item, ball, pairs):
    """Pairs of a packet of 64 rays and a ball, and the lanes of each group that may meet it."""
    for i in range(64):
        ray = rays[i]
        put_ray(lanes, i, Ray(ray[0], ray[1], ray[2], ray[3], ray[4], ray[5], 0.0, np.inf, np.int64(-1)))
    close_lanes(lanes, 64)
    put_group_beams(lanes)
    bits = np.empty(8, np.int64)
    for group in range(8):
        bits[group] = group_in_ball(lanes, group, ball[0], ball[1], ball[2], ball[3])
    return put_groups(item, 0, 0, lanes, GROUPS_AT, pairs, 0), bits


@pytest.mark.parametrize("spread", [0.05, 0.3])
def test_groups_of_lanes_that_meet_a_ball_are_asked(spread):
    rng, met, left_out = np.random.default_rng(5), 0, 0
    for _ in range(200):
        origins, directions = some_rays(rng, 64, spread)
        origins, directions = origins[np.lexsort(origins.T)], directions[np.lexsort(directions.T)]
        middle, r = origins[rng.integers(64)] + 3 * directions[rng.integers(64)], rng.uniform(0.01, 0.3)
        item = np.zeros(ITEMS_SIZE)
        item[0 : 6 * ITEM_ROW : ITEM_ROW] = np.concatenate([middle - r, middle + r]) + np.repeat([-1e-12, 1e-12], 3)
        pairs, ball = np.full(16, -1, np.int64), np.append(middle, r)
        count, bits = groups_at_ball(np.empty(SIZE), np.concatenate([origins, directions], axis=1), item, ball, pairs)
        apart = np.linalg.norm(np.cross(middle - origins, directions), axis=1) / np.linalg.norm(directions, axis=1)
        lanes = (apart < r) & (((middle - origins) * directions).sum(axis=1) > 0)
        assert set(np.flatnonzero(lanes) // 8) <= set(pairs[:count].tolist()) <= set(range(8))
        for i in np.flatnonzero(lanes):
            assert bits[i // 8] >> (i % 8) & 1
        met += lanes.sum()
        left_out += 8 - count
    assert met > 100
    assert left_out > 100


@numba.njit
def entering(lanes, rays, ends, item, row):
    """(where the groups of a packet of 64 rays enter the box of an item, EARLIEST then, who enters by a row, reaches)."""
    for i in range(64):
        ray = rays[i]
        put_ray(lanes, i, Ray(ray[0], ray[1], ray[2], ray[3], ray[4], ray[5], 0.0, ends[i], np.int64(-1)))
    close_lanes(lanes, 64)
    put_slopes(lanes)
    entries, reaches, met = np.empty(64), np.empty(8), np.int64(0)
    for i in range(64):
        lanes[EARLIEST + np.uint64(i)] = 3.0
    for group in range(8):
        put_entries(lanes, EARLIEST, item, 0, entries, 8 * group, group)
    for i in range(64):
        lanes[BEST + np.uint64(i)] = row[i]
    for group in range(8):
        met |= lanes_entering(lanes, BEST, entries, 8 * group, group)
    put_reaches(lanes, EARLIEST, GROUPS_AT)
    for group in range(8):
        reaches[group] = lanes[np.uint64(GROUPS_AT + group)]
    return entries, lanes[EARLIEST : EARLIEST + np.uint64(64)].copy(), met, reaches


def test_lanes_enter_a_box_where_their_rays_do():
    """Against the slabs of a box, each ray by itself; what is nearly a tie is not asked."""
    rng, met, missed, later = np.random.default_rng(8), 0, 0, 0
    for _ in range(100):
        origins, directions = some_rays(rng, 64, 0.3)
        low = origins.mean(axis=0) + 3 * directions.mean(axis=0) - rng.uniform(0.1, 0.6, 3)
        high = low + rng.uniform(0.1, 0.9, 3)
        item, ends, row = np.zeros(ITEMS_SIZE), rng.uniform(0, 8, 64), rng.uniform(0, 8, 64)
        item[0 : 6 * ITEM_ROW : ITEM_ROW] = np.concatenate([low, high])
        rays = np.concatenate([origins, directions], axis=1)
        entries, earliest, bits, reaches = entering(np.empty(SIZE), rays, ends, item, row)
        a, b = (low - origins) / directions, (high - origins) / directions
        first, last = np.maximum(np.minimum(a, b).max(axis=1), 0.0), np.minimum(np.maximum(a, b).min(axis=1), ends)
        clear = np.abs(first - last) > 1e-9
        enters = first <= last
        assert (np.isnan(entries) == ~enters)[clear].all()
        assert (entries <= first)[enters & clear].all()
        assert np.allclose(entries[enters & clear], first[enters & clear], rtol=1e-9, atol=0)
        assert np.array_equal(earliest, np.fmin(entries, 3.0))
        assert np.array_equal(reaches, earliest.reshape(8, 8).max(axis=1))
        by_then = np.minimum(ends, row)
        clear &= np.abs(first - by_then) > 1e-9
        told = np.array([bits >> i & 1 for i in range(64)], bool)
        assert (told == (enters & (first <= by_then)))[clear].all()
        met, missed, later = met + told.sum(), missed + (~enters).sum(), later + (enters & ~told).sum()
    assert min(met, missed, later) > 100


def deep_scene():
    """20,000 balls in a long corridor, and parallel rays along it: one tile sees all of them, more than it can hold."""
    rng = np.random.default_rng(1)
    scene = co.Scene([co.Spheres(rng.uniform(0, 1, (20_000, 3)) * (1, 1, 100), np.full(20_000, 0.006))])
    x, y = np.meshgrid((np.arange(32) + 0.5) / 32, (np.arange(32) + 0.5) / 32)
    origins = np.stack([x, y, np.full_like(x, -1.0)], axis=-1)
    return scene, co.Rays(origins, np.broadcast_to((0.0, 0.0, 1.0), origins.shape).copy())


@pytest.mark.deep
def test_a_tile_that_sees_more_than_it_can_hold_keeps_nodes():
    scene, rays = deep_scene()
    arrays = arrays_of("first_hit", scene._prepared, rays, 0.0, math.inf)

    @numba.njit
    def seen(geometry, arrays):
        tile = new_tile()
        open_tile(geometry, tile, np.empty(SIZE), arrays, 0, 32)
        return tile[2]  # Numba takes `.view` that is not called for a mistake with the method of arrays

    found = seen(scene._prepared.geometry, arrays)
    count = int(found[ITEM_COUNT])
    codes, boxes = found[CODE : CODE + count], found[BOX_OR_BALL : BOX_OR_BALL + count]
    assert MOST_ITEMS - 64 < count <= MOST_ITEMS
    assert (codes >= 0).any()
    assert (boxes < -1).any()
    entered = found[ENTERED : ENTERED + count]
    assert (np.diff(entered) >= 0).all(), "of this one and all that follow"


def test_hits_are_the_same_where_a_tile_holds_nodes():
    scene, rays = deep_scene()
    order = np.random.default_rng(2).permutation(1024)
    together = scene.first_hit(rays)
    apart = scene.first_hit(rays.origins.reshape(-1, 3)[order], rays.directions.reshape(-1, 3)[order])
    assert np.array_equal(together.t.ravel()[order], apart.t)
    assert 0.3 < np.isfinite(apart.t).mean() < 1.0


@pytest.mark.deep
def test_many_nodes_are_put_nearly_in_order_and_none_is_lost():
    rng, count, other = np.random.default_rng(6), 3000, ITEM_ROW

    @numba.njit
    def put(found, t):
        level = new_level()
        level.found[7 : 7 + count], level.t[7 : 7 + count] = found, t
        _put_in_buckets(level, 7, count, other)
        return level.found[other : other + count].copy(), level.t[other : other + count].copy()

    for t in (rng.uniform(2, 900, count), np.full(count, 3.0), np.where(rng.uniform(size=count) < 0.9, 0.0, 1e300)):
        found, times = put(np.arange(count), t)
        assert np.array_equal(np.sort(found), np.arange(count))
        assert np.array_equal(times, t[found])
        assert (np.maximum.accumulate(times) - times <= (t.max() - t.min()) / 200).all()


def test_nodes_beyond_the_horizon_stay_closed():
    """What begins before it is as without one; behind it are fewer items, and all of the scene is below some item."""
    scene, rays = deep_scene()
    beam = beam_of(rays.origins.reshape(-1, 3), rays.directions.reshape(-1, 3))

    @numba.njit
    def seen(geometry, horizon):
        items = new_frontier()
        find_frontier(geometry, items, new_level(), beam, 0, scene_tree(geometry), horizon)
        return items

    near, far = seen(scene._prepared.geometry, 4.0), seen(scene._prepared.geometry, math.inf)
    codes = near[CODE : CODE + int(near[ITEM_COUNT])]
    entered = near[ENTERED : ENTERED + len(codes)]
    assert near[ITEM_COUNT] < 0.5 * far[ITEM_COUNT]
    assert (codes[entered > 8.0] >= 0).mean() > 0.9, "nodes"
    assert (codes[entered < 2.0] >= 0).mean() < 0.1, "balls and leaves"


def test_hits_are_the_same_where_a_tile_sees_further_than_the_one_before():
    """A wall with slots before a deep lattice: beside tiles that end at the wall lie others that see through it."""
    x, y, z = (part.ravel() for part in np.meshgrid(np.arange(40.0), np.arange(20.0), np.arange(40.0)))
    slots = [co.Box((a, -9, -3), (a + 1.0, 9, -2)) for a in (-7.3, 0.4, 6.8)]
    wall = co.Box((-40, -20, -3), (40, 20, -2)) - slots[0] - slots[1] - slots[2]
    scene = co.Scene([co.Spheres(np.stack([x - 19.5, y - 9.5, z + 4.0], axis=1), np.full(len(x), 0.35)), wall])
    rays = co.Camera((0.3, 0.2, -30), (0, 0, 0), up=(0, 1, 0), field_of_view=34).rays(288, 96)
    order = np.random.default_rng(3).permutation(288 * 96)
    together, apart = scene.first_hit(rays), scene.first_hit(rays[np.unravel_index(order, rays.shape)])
    for field in ("t", "body", "face", "surface", "entering"):
        assert np.array_equal(getattr(together, field).ravel()[order], getattr(apart, field)), field
    seen = np.isin(np.arange(32_001), together.body)
    assert seen[:-1].sum() > 300, "balls through the slots"
    assert 0.5 < (together.body == 32_000).mean() < 0.95
