"""Lists of rays against eight boxes: all that meet a box are on its list, whatever is left in the last eight."""

from __future__ import annotations

import math

import numba
import numpy as np
import pytest

from conicoid.kernels.bvh.culling import FROM_THE_START, put_on_lists, rays_in_balls, waiting_ray
from conicoid.kernels.bvh.walk import reciprocal


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
