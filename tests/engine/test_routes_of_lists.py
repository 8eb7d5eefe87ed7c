"""Spans and crossings are the same to the bit, whether rays go in packets or by themselves."""

import math

import numpy as np
import pytest

import conicoid as co
from conicoid.kernels.first_hits import coherent_packets
from conicoid.queries.ray_queries import _packets, arrays_of

from .test_routes import crowded_scene, reordered
from .test_routes_of_bodies import KINDS, scene_of

SPANS = ("t_enter", "t_exit", "body", "enter_clipped", "exit_clipped", "t_enter_error", "t_exit_error")
CROSSINGS = ("t", "body", "face", "surface", "entering", "t_error")
QUERIES = (("spans", SPANS), ("crossings", CROSSINGS))


def rays_of(width):
    """A camera's that looks at a part of a scene; parallel ones in rows that meet faces, edges and corners."""
    camera = co.Camera((0.1, -0.2, -4), (0, 0, 0), up=(0, 1, 0), field_of_view=16).rays(width, width)
    x, y = np.meshgrid(np.arange(width) / 64 - 0.5, np.arange(width) / 64)
    grid = np.stack([x, y, np.full_like(x, -4.0)], axis=-1)
    return camera, co.Rays(grid, (0.0, 0.0, 1.0))


def share_of_packets(scene, rays, t_min=0.0):
    """Which part of packets is coherent, and so traced as such."""
    width, packets = _packets(rays)
    found = coherent_packets(
        scene._prepared.geometry, arrays_of("spans", scene._prepared, rays, t_min, math.inf), width, packets, packets
    )
    return found / packets


def rows_of(found, name, order):
    """A column, ray by ray in an order."""
    column, offsets = getattr(found, name), found.offsets
    return np.concatenate([column[offsets[i] : offsets[i + 1]] for i in order])


def assert_same(query, names, scene, rays, t_min=0.0, t_max=math.inf):
    """What packets find is what single rays find: those are the same in no order. Returns the former."""
    count = len(rays.origins.reshape(-1, 3))
    order = np.random.default_rng(1).permutation(count)
    flat = (np.broadcast_to(t, rays.shape).ravel()[order] for t in (t_min, t_max))
    packets, single = getattr(scene, query)(rays, None, t_min, t_max), reordered(rays, order)
    alone = getattr(scene, query)(single, None, *flat)
    assert np.array_equal(np.diff(packets.offsets)[order], np.diff(alone.offsets))
    for name in names:
        assert np.array_equal(rows_of(packets, name, order), getattr(alone, name)), name
    return packets


@pytest.mark.parametrize(("query", "names"), QUERIES)
@pytest.mark.parametrize("kind", [*KINDS, "trees"])
@pytest.mark.parametrize("width", [48, pytest.param(512, marks=pytest.mark.deep)])
def test_every_kind_of_body(kind, query, names, width):
    scene = scene_of(kind, 4 if width < 100 else 6)
    for rays in rays_of(width // 2 if "trees" in kind else width):
        assert share_of_packets(scene, rays) > 0.8
        found = assert_same(query, names, scene, rays)
        assert len(found.body) > 0 or scene.bodies[0].shape.is_sheet


@pytest.mark.parametrize("kind", [*KINDS, "trees"])
@pytest.mark.parametrize("width", [48, pytest.param(512, marks=pytest.mark.deep)])
def test_parallel_lines(kind, width):
    """Lines, which begin before their origins, are packets where they are parallel: first hits too."""
    scene, rays = scene_of(kind, 4 if width < 100 else 6), rays_of(width)[1]
    middle = co.Rays(rays.origins + [0, 0, 4], rays.directions)
    for t_min in (-math.inf, -0.7):
        assert share_of_packets(scene, middle, t_min) > 0.9
        found = assert_same("crossings", CROSSINGS[:-1], scene, middle, t_min)
        assert_same("spans", SPANS[:-2], scene, middle, t_min)
        hits = scene.first_hit(middle, None, t_min)
        some = np.diff(found.offsets) > 0
        assert np.array_equal(some, hits.body.ravel() >= 0)
        for name in ("t", "body", "face", "surface", "entering"):
            assert np.array_equal(getattr(found, name)[found.offsets[:-1][some]], getattr(hits, name).ravel()[some])
        assert np.array_equal(scene.occluded(middle, None, t_min), hits.body >= 0)
    assert share_of_packets(scene, rays_of(width)[0], -0.7) == 0


@pytest.mark.parametrize(("query", "names"), QUERIES)
def test_intervals(query, names):
    """Ends of an interval cut spans; some intervals are empty."""
    scene, rays = crowded_scene(), rays_of(96)[0]
    assert share_of_packets(scene, rays) > 0.9
    random = np.random.default_rng(5)
    whole = assert_same(query, names, scene, rays)
    low, high = random.uniform(0, 6, (2, *rays.shape))
    part = assert_same(query, names, scene, rays, low, high)
    assert 0 < len(part.body) < len(whole.body)
    assert assert_same(query, names, scene, rays, 3.5, 4.5).offsets[-1] < len(whole.body)
    if query == "spans":
        assert part.enter_clipped.any()
        assert part.exit_clipped.any()


@pytest.mark.parametrize(("query", "names"), QUERIES)
def test_rays_that_start_on_surfaces(query, names):
    scene = co.Scene(
        [co.Sphere(2), co.Box((-1, -1, 3), (1, 1, 4)), co.Sphere(1, (0, 0, 6)) - co.Sphere(0.9, (0, 0, 6))]
    )
    x, y = np.meshgrid(np.linspace(-0.9, 0.9, 64), np.linspace(-0.9, 0.9, 64))
    hits = scene.first_hit(np.stack([x, y, np.full_like(x, -4.0)], axis=-1), (0, 0, 1))
    assert share_of_packets(scene, hits.spawn((0.0, 0.1, 1.0))) > 0.9
    for direction in ((0.0, 0.1, 1.0), (0.0, 0.1, -1.0)):
        assert_same(query, names, scene, hits.spawn(direction))


@pytest.mark.parametrize("shape", [(1, 1), (7, 3), (8, 8), (9, 17), (1, 200), (200, 1), (33, 70)])
def test_pictures_of_any_size(shape):
    """Concentric balls of radius 1, 2, .., 40: a ray at distance b from the center is in each for 2 sqrt(r² - b²)."""
    scene = co.Scene([co.Sphere(float(r)) for r in range(1, 41)])
    y, x = np.meshgrid(*(np.linspace(-5.6, 8.3, n) for n in shape), indexing="ij")
    origins = np.stack([x, y, np.full_like(x, 64.0)], axis=-1)
    spans = scene.spans(origins, (0, 0, -1))
    height = np.sqrt(np.maximum(np.arange(1, 41) ** 2 - (x * x + y * y)[..., None], 0))
    assert np.allclose(spans.lengths(), 2 * height, rtol=1e-12, atol=1e-6)
    assert np.array_equal(np.diff(spans.offsets), (height > 0).sum(axis=-1).ravel())
    for first, last in zip(spans.offsets[:-1], spans.offsets[1:], strict=True):
        assert (np.diff(spans.t_enter[first:last]) > 0).all()
        assert (np.diff(spans.body[first:last]) < 0).all()


@pytest.mark.parametrize("threads", [1, 2, 5])
def test_any_number_of_threads(threads):
    scene, rays = crowded_scene(), rays_of(64)[0]
    expected = scene.spans(rays)
    co.set_threads(threads)
    try:
        spans = scene.spans(rays)
        for name in ("offsets", *SPANS):
            assert np.array_equal(getattr(spans, name), getattr(expected, name))
    finally:
        co.set_threads(None)
