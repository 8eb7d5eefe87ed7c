"""Packets of one square share what they see of a scene, and a point that all rays start from saves work: no hit is lost."""

from __future__ import annotations

from fractions import Fraction

import numba
import numpy as np
import pytest

import conicoid as co
from conicoid.kernels.body.scratch import new_scratch
from conicoid.kernels.bvh.culling import lanes_in_ball, lanes_in_ball_from_one
from conicoid.kernels.packet.lanes import BEST, BODY, SIZE, close_lanes, put_ray
from conicoid.kernels.packet.packet import new_packet
from conicoid.kernels.packet.traversal import _FOUND, _MOST, new_square, trace_square
from conicoid.kernels.ray import Ray
from conicoid.render import sampling

from ..compiled import compiled
from ..samples import many

sample_in_pixel = compiled(sampling.sample_in_pixel)


@numba.njit
def put_rays(lanes, origins, directions):
    for i in range(64):
        o, d = origins[i], directions[i]
        put_ray(lanes, i, Ray(o[0], o[1], o[2], d[0], d[1], d[2], 0.0, np.inf, np.int64(-1)))
    close_lanes(lanes, 64)


@numba.njit
def lanes_at(lanes, origins, directions, ball):
    put_rays(lanes, origins, directions)
    one = lanes_in_ball_from_one(lanes, ball[0], ball[1], ball[2], ball[3])
    return one, lanes_in_ball(lanes, ball[0], ball[1], ball[2], ball[3])


def is_met(origin, direction, ball):
    """In fractions: has |o + t d - c|² = r² a root t >= 0, or does the ray start inside?"""
    o, d, c = ([Fraction(x) for x in row] for row in (origin, direction, ball[:3]))
    r, p = Fraction(ball[3]), [a - b for a, b in zip(o, c, strict=True)]
    a, b, k = sum(x * x for x in d), sum(x * y for x, y in zip(p, d, strict=True)), sum(x * x for x in p) - r * r
    return k <= 0 or (b < 0 and b * b >= a * k)


@pytest.mark.parametrize("far", [1.0, 1e3, 1e7])
def test_balls_that_rays_of_one_origin_graze_are_met(far):
    """Balls whose radius is the distance of one of the rays, but for some last digits."""
    rng, met, left_out, count = np.random.default_rng(8), 0, 0, many(40, 150)
    for _ in range(count):
        origin = rng.uniform(-1, 1, 3) * far
        way = rng.normal(size=3)
        directions = (way / np.linalg.norm(way) + rng.uniform(-0.05, 0.05, (64, 3))) * rng.uniform(0.5, 2, (64, 1))
        middle = origin + directions[5] * rng.uniform(0.5, 2) * far + rng.normal(size=3) * 0.02 * far
        apart = np.linalg.norm(np.cross(middle - origin, directions[5])) / np.linalg.norm(directions[5])
        ball = [*middle.tolist(), float(apart * (1 + rng.choice([0, 1e-15, -1e-15, 1e-9])))]
        one, other = lanes_at(np.empty(SIZE), np.broadcast_to(origin, (64, 3)), directions, np.array(ball))
        lanes = [is_met(origin.tolist(), d, ball) for d in directions.tolist()]
        assert all(one >> i & 1 for i in range(64) if lanes[i])
        met += sum(lanes)
        left_out += sum(1 for i in range(64) if not one >> i & 1)
        assert abs((one & (2**64 - 1)).bit_count() - (other & (2**64 - 1)).bit_count()) <= 2
    assert met > 3 * count
    assert left_out > 6 * count


@numba.njit
def traced(geometry, origins, directions, numbers, any_hit, best, bodies):
    """Where the rays of packets end, and how often a frontier was looked for."""
    scratch, packet, square, found = new_scratch(geometry), new_packet(geometry), new_square(), 0
    for k in range(len(numbers)):
        put_rays(packet.lanes, origins[k], directions[k])
        trace_square(geometry, scratch, packet, square, numbers[k], scratch.nothing, any_hit)
        found = max(found, int(square.known[_FOUND]))
        best[k], bodies[k] = packet.lanes[BEST : BEST + 64], packet.lanes[BODY : BODY + 64]
    return found


def scene_of(kind):
    rng = np.random.default_rng(3)
    if kind == "balls":
        return co.Scene([co.Spheres(rng.uniform(-1, 1, (2000, 3)), rng.uniform(0.01, 0.06, 2000))])
    shapes = [
        co.Box(low, low + 0.08) if k % 2 else co.Cylinder(low, low + (0.1, 0.05, 0.02), 0.03)
        for k, low in enumerate(rng.uniform(-1, 1, (300, 3)))
    ]
    return co.Scene([*shapes, co.Box((-2, -2, 1), (2, 2, 1.1)) - co.Sphere(0.5, (0, 0, 1))])


def packets_of(rng, kind, count):
    """Rays of some samples of a square of 8 x 8 pixels, by a camera that looks along z."""
    x, y = np.meshgrid(np.arange(8.0), np.arange(8.0))
    corner, size = rng.uniform(-0.4, 0.3, 2), 0.01
    places = np.stack([x.ravel(), y.ravel()], axis=1) + rng.uniform(0, 1, (count, 64, 2))
    ends = np.concatenate([corner + size * places, np.ones((count, 64, 1))], axis=2)
    origins = np.broadcast_to([0.1, 0.2, -3.0], ends.shape)
    if kind == "lens":
        origins = origins + rng.uniform(-0.05, 0.05, ends.shape) * (1, 1, 0)
    elif kind == "straying":
        ends = ends + rng.uniform(-0.2, 0.2, (count, 1, 3)) * (1, 1, 0)
    return np.ascontiguousarray(origins), ends / np.linalg.norm(ends, axis=2, keepdims=True)


@pytest.mark.parametrize("bodies", ["balls", "others"])
def test_samples_of_a_picture_meet_what_each_meets_alone(bodies):
    """Normals in a picture by a pinhole are the means of those that first hits of the same rays have."""
    width, height, count, seed, eye, scene = 64, 48, 9, 3, (0.1, 0.2, -3.0), scene_of(bodies)
    camera = co.Camera(eye, (0.1, 0.2, 1), up=(0, 1, 0), field_of_view=40)
    pixels = scene.render(width, height, count, integrator="normals", seed=seed, camera=camera).pixels
    x, y = (part.ravel() for part in np.meshgrid(np.arange(width), np.arange(height)))
    places = np.array([[sample_in_pixel(seed, pixel, k, count) for k in range(count)] for pixel in range(len(x))])
    middles = camera.rays(width, height).directions
    middles = middles / middles[..., 2:]  # on a plane across the view, where pixels are equally wide
    right, down = middles[0, 1] - middles[0, 0], middles[1, 0] - middles[0, 0]
    steps = [axis[:, None] + places[..., k] - 0.5 for k, axis in enumerate((x, y))]
    hits = scene.first_hit(eye, middles[0, 0] + steps[0][..., None] * right + steps[1][..., None] * down)
    expected = np.where(np.isnan(hits.normal), 0, 0.5 + 0.5 * hits.normal).mean(axis=1)
    assert np.abs(pixels.reshape(-1, 3) - expected).max() < 1e-6
    assert 0.5 < np.isfinite(hits.t).mean() < 1


@pytest.mark.deep
@pytest.mark.parametrize("any_hit", [False, True])
@pytest.mark.parametrize("kind", ["pinhole", "lens", "straying"])
@pytest.mark.parametrize("bodies", ["balls", "others"])
def test_packets_of_a_square_meet_what_each_meets_alone(bodies, kind, any_hit):
    rng, scene = np.random.default_rng(4), scene_of(bodies)
    count, hits, most = 9, 0, []
    for _ in range(12):
        one, other = packets_of(rng, kind, count), packets_of(rng, kind, count)
        origins, directions = (np.concatenate(pair) for pair in zip(one, other, strict=True))
        numbers, best, met = np.repeat([7, 70], count), np.empty((2 * count, 64)), np.empty((2 * count, 64))
        most.append(traced(scene._prepared.geometry, origins, directions, numbers, any_hit, best, met))
        first = scene.first_hit(origins, directions)
        alone = first.t
        assert np.array_equal(best < np.inf, alone < np.inf)
        if not any_hit:
            assert best.tobytes() == alone.tobytes()
            assert np.array_equal(met, first.body)
        hits += int((best < np.inf).sum())
    assert 12 * 18 * 64 > hits > 500
    assert max(most) == _MOST if kind == "straying" else 1 <= max(most) < _MOST
