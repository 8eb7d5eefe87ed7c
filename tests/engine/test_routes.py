"""A ray has the same answer to the bit in a packet and by itself, in any order and on any number of threads."""

import functools
from fractions import Fraction

import numpy as np
import pytest

import conicoid as co

from ..reference.routes import in_doubt

FIELDS = ("t", "body", "face", "surface", "entering")


@functools.cache
def crowded_scene(count=300):
    """Prepared once. Every kind of entry: balls, cells with one or two spans, Booleans, sheets, something unbounded."""
    rng = np.random.default_rng(7)
    centers, size = rng.uniform(-1, 1, (count, 3)), 0.5 / count ** (1 / 3)
    items = []
    for i, center in enumerate(centers):
        turn = (rng.normal(size=3), rng.uniform(0, 360))
        kinds = (
            lambda: co.Ellipsoid((size, size / 2, size), z_range=(-size / 2, size)),
            lambda: co.Box((-size, -size, -size), (size, size, size)),
            lambda: co.DoubleCone(1.0, z_range=(-size, size)),
            lambda: co.OneSheetHyperboloid(9 / size**2, 9 / size**2, 4 / size**2, z_range=(-size, size)),
            lambda: co.Sphere(size) - co.Cylinder((0, 0, -size), (0, 0, size), size / 2),
            lambda: co.Cylinder((0, 0, -size), (0, 0, size), size, 0, 250, (1, 0, 0)),
        )
        items.append(kinds[i % len(kinds)]().rotate(*turn).translate(center))
    flat = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0.5, 0.5, 0), (0, 1, 0)]) * 0.3
    return co.Scene(
        [
            co.Spheres(rng.uniform(-1, 1, (50, 3)), 0.05),
            *items,
            co.Disc((0.5, 0.5, -1.1), (0, 0.2, 1), 0.3),
            co.Polygon([tuple(p) for p in flat]).translate((-1, 0, -1.2)),
            co.Plane((0, 1, 0), -1.2),
        ]
    )


def camera(width):
    return co.Camera((0.1, -0.2, -4), (0, 0, 0), up=(0, 1, 0), field_of_view=42).rays(width, width)


def reordered(rays, order):
    """The same rays in another order, as a flat list: those that start on a surface still do."""
    return rays[np.unravel_index(order, rays.shape)]


def assert_same(one, other, order):
    for field in FIELDS:
        assert np.array_equal(getattr(one, field).ravel()[order], getattr(other, field)), field


@pytest.mark.parametrize("width", [96, pytest.param(1024, marks=pytest.mark.deep)])
def test_packets_tiles_rows_and_single_rays_agree_to_the_bit(width):
    scene, rays = crowded_scene(), camera(width)
    shuffled = np.random.default_rng(1).permutation(width * width)
    hits = scene.first_hit(rays)
    assert 0.3 < (hits.body >= 0).mean() < 1
    assert_same(hits, scene.first_hit(reordered(rays, np.arange(width * width))), np.arange(width * width))
    assert_same(hits, scene.first_hit(reordered(rays, shuffled)), shuffled)
    assert np.array_equal(scene.occluded(rays), hits.t < np.inf)
    assert np.array_equal(scene.occluded(reordered(rays, shuffled)), (hits.t < np.inf).ravel()[shuffled])


@pytest.mark.parametrize("width", [96, pytest.param(1024, marks=pytest.mark.deep)])
def test_rays_that_start_on_surfaces_agree_too(width):
    scene = crowded_scene()
    hits = scene.first_hit(camera(width))
    towards = np.where((hits.body >= 0)[..., None], np.array([3.0, 5.0, -6.0]) - hits.point, 1.0)
    shadow = hits.spawn(towards)
    order = np.random.default_rng(2).permutation(width * width)
    lit = scene.first_hit(shadow, t_max=1)
    assert_same(lit, scene.first_hit(reordered(shadow, order), t_max=1), order)
    assert np.array_equal(scene.occluded(shadow, t_max=1), lit.t < np.inf)
    assert np.array_equal(scene.occluded(reordered(shadow, order), t_max=1), (lit.t < np.inf).ravel()[order])


def test_crossings_begin_with_the_packets_first_hit():
    scene, rays = crowded_scene(), camera(48)
    hits, crossings = scene.first_hit(rays), scene.crossings(rays)
    first = crossings.offsets[:-1]
    some = np.diff(crossings.offsets) > 0
    assert np.array_equal(some, hits.body.ravel() >= 0)
    assert np.array_equal(crossings.t[first[some]], hits.t.ravel()[some])
    assert np.array_equal(crossings.face[first[some]], hits.face.ravel()[some])


@pytest.mark.parametrize("threads", [1, 2, 5])
def test_any_number_of_threads_gives_the_same(threads):
    scene, rays = crowded_scene(), camera(64)
    expected = scene.first_hit(rays)
    co.set_threads(threads)
    try:
        hits = scene.first_hit(rays)
        for field in FIELDS:
            assert np.array_equal(getattr(hits, field), getattr(expected, field))
    finally:
        co.set_threads(None)


@pytest.mark.parametrize("shape", [(1, 1), (7, 3), (8, 8), (9, 17), (1, 200), (200, 1)])
def test_pictures_of_any_size(shape):
    """Tiles that stick out over the edge of the picture hold idle lanes."""
    scene = co.Scene([co.Sphere(1)])
    y, x = np.meshgrid(*(np.linspace(-1.2, 1.2, n) for n in shape), indexing="ij")
    origins = np.stack([x, y, np.full_like(x, 5.0)], axis=-1)
    hits = scene.first_hit(origins, (0, 0, -1))
    inside = x * x + y * y < 1
    assert np.array_equal(hits.body >= 0, inside)
    expected = 5 - np.sqrt(1 - x[inside] ** 2 - y[inside] ** 2)
    assert np.allclose(hits.t[inside], expected, rtol=1e-14, atol=0)


def test_streams_without_any_ray():
    """Directions of no ordinary length go one by one, which leaves nothing for the streams."""
    r = np.random.default_rng(4)
    origins, directions = r.uniform(-2, 2, (4096, 3)), r.normal(size=(4096, 3))
    scene, small = crowded_scene(), 2.0**-170
    hits, same = scene.first_hit(origins, directions), scene.first_hit(origins, directions * small)
    assert np.array_equal(hits.t, same.t * small)
    assert np.array_equal(hits.body, same.body)


def test_grazing_rays_in_no_order_are_settled():
    """Lines along axes whose distance from the center is the ball's radius, but for rounding: Pythagoras decides."""
    r = np.random.default_rng(5)
    count, angle = 8192, r.uniform(0, 2 * np.pi, 8192)
    axis, sign = r.integers(0, 3, count), r.choice([-1.0, 1.0], count)
    a, b = np.cos(angle), np.sin(angle)
    origins = np.stack([np.choose(axis, (-2.0 * sign, b, a)), np.choose(axis, (a, -2.0 * sign, b)),
                        np.choose(axis, (b, a, -2.0 * sign))], axis=-1)  # fmt: skip
    directions = np.eye(3)[axis] * sign[:, None]
    inside = np.array([Fraction(x) ** 2 + Fraction(y) ** 2 < 1 for x, y in zip(a.tolist(), b.tolist(), strict=True)])
    assert 0.2 < inside.mean() < 0.8
    scene = co.Scene([co.Sphere(1)])
    hits = scene.first_hit(origins, directions)
    assert in_doubt(scene, hits.rays).mean() > 0.9
    assert np.array_equal(hits.body >= 0, inside)
    assert np.array_equal(scene.occluded(origins, directions), inside)
