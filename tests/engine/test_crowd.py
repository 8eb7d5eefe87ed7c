"""Packets before which many small bodies lie meet them in pairs, others side by side: to the same bits."""

from __future__ import annotations

import functools
import math

import numba
import numpy as np
import pytest

import conicoid as co
from conicoid.kernels.body.hit import is_doubtful
from conicoid.kernels.body.scratch import new_scratch
from conicoid.kernels.first_hits import HitBuffers, trace_first_alone
from conicoid.kernels.packet.crowd import is_crowded
from conicoid.kernels.packet.frontier import new_tile, open_quarter, open_tile, tile_packet
from conicoid.kernels.packet.lanes import BEST, BODY, DOUBT, fill_lanes
from conicoid.kernels.packet.packet import new_packet
from conicoid.kernels.packet.traversal import trace_packet
from conicoid.queries.ray_queries import arrays_of

from .test_routes import assert_same, reordered

deep = pytest.mark.deep  # what looks into packets is compiled; that answers are the same is fast
WIDTH = 128
ACROSS = WIDTH // 8


@numba.njit(error_model="numpy")
def trace_tiles(geometry, rays, width, blocks, any_hit, crowded, best, bodies, doubts):
    """What the packets of a picture meet, as `trace_first` traces them, and which are taken for crowds."""
    scratch, packet, memory = new_scratch(geometry), new_packet(geometry), new_tile()
    lanes, count = packet.lanes, len(rays.origins)
    for tile in range((width // 32) ** 2):
        shared = open_tile(geometry, memory, lanes, rays, tile, width)
        for number in range(16):
            if number & 3 == 0:
                open_quarter(memory, number >> 2, packet.items)
            k = tile_packet(tile, number, width, count)
            fill_lanes(lanes, rays, k, width, shared)
            trace_packet(geometry, scratch, packet, blocks, any_hit)
            crowded[k] = is_crowded(packet.crowd)
            for i in range(64):
                lane, at = np.uint64(i), (8 * (k // (width // 8)) + i // 8) * width + 8 * (k % (width // 8)) + i % 8
                best[at], bodies[at], doubts[at] = lanes[BEST + lane], lanes[BODY + lane], lanes[DOUBT + lane]


@functools.cache
def field():
    """Pipes that stand on a square, one of a hundred shut by a ball, and a slab below all; prepared once."""
    solids = []
    for i in range(56):
        for j in range(56):
            foot, head = (i, j, 0.0), (i, j, 1.0 + 0.1 * ((3 * i + 5 * j) % 7))
            solid = co.Cylinder(foot, head, 0.4) - co.Cylinder((i, j, -0.1), (i, j, 2.0), 0.3)
            solids.append(solid | co.Sphere(0.35, (i, j, 1.2)) if (i + 56 * j) % 100 == 7 else solid)
    return co.Scene([*solids, co.Box((-1, -1, -1), (56, 56, -0.5)) - co.Sphere(2, (28, 28, -0.5))])


VIEWS = {
    "near": ((20, 20, 4.5), (20.2, 20.1, 0), 60),
    "far": ((27.5, 27.5, 125), (27.7, 27.6, 0), 24),
    "both": ((20.3, -1.5, 2.2), (20, 9, 0), 70),
}


def rays_of(view):
    origin, target, angle = VIEWS[view]
    up = (0, 1, 0) if view != "both" else (0, 0, 1)
    return co.Camera(origin, target, up=up, field_of_view=angle).rays(WIDTH, WIDTH)


@functools.cache
def traced(view, any_hit=False, without=()):
    """(which packets are crowds, t, body, doubt of each ray of a picture)."""
    scene, rays = field()._prepared, rays_of(view)
    arrays = arrays_of("first_hit", scene, rays, 0.0, math.inf)
    blocks = np.ones(len(field().bodies) if without else 0, np.int8)
    blocks[list(without)] = 0
    best, bodies, doubts = (np.empty(WIDTH * WIDTH) for _ in range(3))
    crowded = np.zeros(ACROSS**2, np.bool_)
    trace_tiles(scene.geometry, arrays, WIDTH, blocks, any_hit, crowded, best, bodies, doubts)
    return crowded.reshape(ACROSS, ACROSS), best, bodies, doubts != 0


@functools.cache
def alone(view):
    """The same of single rays: (t, body, doubt)."""
    scene, rays = field()._prepared, rays_of(view)
    arrays, found = arrays_of("first_hit", scene, rays, 0.0, math.inf), HitBuffers.new(WIDTH * WIDTH)
    trace_first_alone(scene.geometry, arrays, 0, WIDTH * WIDTH, found)
    return found.t, found.body, is_doubtful(found.turn)


@deep
def test_what_is_a_crowd_is_decided_packet_by_packet():
    # Of the near view a pipe's pitch takes up WIDTH / (2 * 4.5 tan 30°) = 25 pixels, three packets; of the far one
    # WIDTH / (2 * 125 tan 12°) = 2.4, so that a packet sees (8 / 2.4)² = 11 whole ones, and twenty in all.
    assert not traced("near")[0].any()
    assert traced("far")[0].mean() > 0.5  # most: those that begin a row of packets go by the end of the one before
    crowded = traced("both")[0]
    below, above = crowded[ACROSS // 2 + 4 :], crowded[ACROSS // 4 : ACROSS // 2]
    assert below.mean() < 0.2
    assert above.any()


@deep
@pytest.mark.parametrize("view", VIEWS)
def test_packets_meet_what_single_rays_do(view):
    _, best, bodies, doubts = traced(view)
    t, body, unsure = alone(view)
    sure = ~doubts & ~unsure
    assert sure.mean() > 0.9
    assert best[sure].tobytes() == t[sure].tobytes()
    assert np.array_equal(bodies[sure], body[sure])


@deep
@pytest.mark.parametrize("view", VIEWS)
def test_any_hit_says_whether_there_is_one(view):
    best, doubts = traced(view, True)[1], traced(view, True)[3]
    t, _, unsure = alone(view)
    sure = ~doubts & ~unsure
    assert sure.mean() > 0.9
    assert np.array_equal(best[sure] < np.inf, t[sure] < np.inf)


@deep
def test_bodies_left_out_are_not_met():
    body = alone("far")[1]
    without = tuple(range(0, len(field().bodies), 10))
    crowded, best, bodies, doubts = traced("far", False, without)
    assert crowded.mean() > 0.5
    assert not np.isin(bodies[bodies >= 0], without).any()
    same = ~doubts & ~alone("far")[2] & (body % 10 != 0)
    assert best[same].tobytes() == alone("far")[0][same].tobytes()


@pytest.mark.parametrize("view", VIEWS)
def test_queries_agree_to_the_bit_in_any_order(view):
    scene, rays = field(), rays_of(view)
    hits, order = scene.first_hit(rays), np.random.default_rng(1).permutation(WIDTH * WIDTH)
    assert_same(hits, scene.first_hit(reordered(rays, order)), order)
    some = order[:60]
    assert_same(hits, scene.first_hit(reordered(rays, some)), some)
    assert np.array_equal(scene.occluded(rays), hits.hit)
