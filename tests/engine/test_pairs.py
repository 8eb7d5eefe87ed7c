"""A ray of a stream meets a ball in lanes as it does by itself, to the bit."""

import numba
import numpy as np
import pytest

import conicoid as co
from conicoid.kernels import tables as table
from conicoid.kernels.body.hit import no_hit, try_ball
from conicoid.kernels.bvh.walk import ROWS, leaf_ball, leaf_item
from conicoid.kernels.ray import Ray
from conicoid.kernels.stream import meet_pairs, new_pairs, pair_hit, put_pair

from .nodes import Nodes


@numba.njit(error_model="numpy")
def keep(hits, n, hit):
    hits[n, 0], hits[n, 1], hits[n, 2], hits[n, 3], hits[n, 4] = hit[0], hit[1], hit[2], hit[3], hit[4]
    hits[n, 5], hits[n, 6], hits[n, 7] = hit[5], hit[6], hit[7]


@numba.njit(error_model="numpy")
def one_by_one(geometry, rays, more, places, hits):
    """The hit of each ray with each of the balls, at `places` (leaf, its size, place in it), by the code of single rays."""
    for n in range(len(hits)):
        r, m = rays[n // len(places) * 8 :], more[n // len(places) * 8 :]
        ray = Ray(r[0], r[1], r[2], m[0], m[1], m[2], r[6], m[5], np.int64(m[4]))
        at, size, place = places[n % len(places)]
        item, ball = leaf_item(geometry, at, size, place), leaf_ball(geometry, at, size, place)
        keep(hits, n, try_ball(geometry, item, ball, ray, m[3], no_hit()))


@numba.njit(error_model="numpy")
def in_pairs(geometry, rays, more, places, most, hits):
    """The same in pairs, up to `most` at a time."""
    pairs = new_pairs()
    for first in range(0, len(hits), most):
        count = min(most, len(hits) - first)
        for k in range(count):
            at, size, place = places[(first + k) % len(places)]
            put_pair(pairs, k, (first + k) // len(places), geometry, at, size, place)
        meet_pairs(pairs, rays, more, count)
        for k in range(count):
            keep(hits, first + k, pair_hit(pairs, k))


def places_of_balls(scene):
    """Where the balls of a scene stand: (leaf, its size, place in it) each."""
    nodes, found = Nodes(scene), []
    for code in [*nodes.roots, *nodes.children.ravel().tolist()]:
        first, count = (-code - 1) >> 4, (-code - 1) & 15
        if code < 0:
            at = int(scene._prepared.geometry.places[table.ITEMS]) + ROWS * first
            found += [(at, count, place) for place in range(count)]
    return found


@pytest.mark.parametrize("most", [1, 7, 64])
@pytest.mark.parametrize("start", [-1, 2])
def test_pairs_are_met_as_single_rays_meet_balls(most, start):
    """Rays that hit, miss, touch, begin inside of a ball or on it; short ones, and long directions."""
    rng = np.random.default_rng(most)
    size, count = 5, 400
    centers, radii = rng.uniform(-1, 1, (size, 3)), rng.uniform(0.2, 0.9, size)
    scene = co.Scene([co.Sphere(r).translate(c) for c, r in zip(centers, radii, strict=True)])
    geometry, places = scene._prepared.geometry, tuple(places_of_balls(scene))
    assert len(places) == size
    which, origins = np.arange(count) % size, rng.uniform(-2, 2, (count, 3))
    directions = (centers[which] + rng.normal(scale=0.3, size=(count, 3)) - origins) * 10 ** rng.uniform(
        -3, 3, (count, 1)
    )
    across = np.cross(directions, rng.normal(size=(count, 3)))
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    # Every fourth is a tangent of a ball, as nearly as it can be told; every fifth begins on one
    touches = centers[which] + across * radii[which, None] - directions
    origins[::4] = touches[::4]
    origins[::5] = (centers[which] + across * radii[which, None])[::5]
    limits = np.stack([np.zeros(count), np.where(np.arange(count) % 3, np.inf, 1e3)], axis=1)
    squares = np.array([x * x + y * y + z * z for x, y, z in directions.tolist()])
    rays = np.concatenate([origins, np.full((count, 3), np.nan), limits], axis=1).ravel()
    rest = np.stack([1 / squares, np.full(count, start), limits[:, 1], np.full(count, np.inf), np.zeros(count)], axis=1)
    more = np.concatenate([directions, rest], axis=1).ravel()
    single, paired = np.empty((size * count, 8)), np.empty((size * count, 8))
    one_by_one(geometry, rays, more, places, single)
    in_pairs(geometry, rays, more, places, most, paired)
    hit = single[:, 0] < np.inf
    assert 0.1 < hit.mean() < 0.9
    assert np.array_equal(single[hit], paired[hit])
    assert np.array_equal(single[:, 0], paired[:, 0])
    assert np.array_equal(single[:, 7], paired[:, 7]), "doubt"
    assert 0 < single[:, 7].sum() < len(single)
