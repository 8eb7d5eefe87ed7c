"""Rays that start on a surface and run along it."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

import conicoid as co


@pytest.mark.parametrize("far", [1.0, 1e2, 1e4])
@pytest.mark.parametrize("route", ["alone", "flat", "square", "shuffled"])
def test_along_the_outermost_plane_of_many(route, far):
    """The rounded start lies above or below the boxes' common lid, whose plane holds the ray: it runs through them all."""
    random = np.random.default_rng(5)
    ends = [(k + 0.25, k + 0.75) for k in range(20)]
    scene = co.Scene([co.Box((a, -1, -1), (b, 0.2, 1)) for a, b in ends])
    count = 4096
    target = np.stack([random.uniform(0.3, 0.7, count), np.full(count, 0.2), random.uniform(-0.5, 0.5, count)], axis=1)
    to = np.stack([random.uniform(-1, 1, count), -random.uniform(0.3, 1, count), random.uniform(-1, 1, count)], axis=1)
    hits = scene.first_hit(target - far * to, to)
    assert (hits.face == hits.face[0]).all()
    assert (hits.body == 0).all()
    height = hits.point[:, 1] - 0.2
    assert height.min() < 0 < height.max()
    along = np.stack([random.uniform(0.5, 2, count), np.zeros(count), random.uniform(-0.01, 0.01, count)], axis=1)
    if route == "alone":
        chosen = np.concatenate([np.argsort(height)[:30], np.argsort(height)[-30:]])
        answers = [(scene.first_hit(ray), scene.crossings(ray)) for ray in (hits.spawn(along)[i] for i in chosen)]
    else:
        order = random.permutation(count) if route == "shuffled" else np.arange(count)
        rays = hits.spawn(along)[order.reshape(64, 64) if route == "square" else order]
        answers, chosen = [(scene.first_hit(rays), scene.crossings(rays))], order
    wall = np.array([x for interval in ends for x in interval][1:])
    expected = (wall - hits.point[chosen, :1]) / along[chosen, :1]
    first = np.concatenate([np.ravel(hit.t) for hit, _ in answers])
    every = np.concatenate([np.ravel(crossing.t) for _, crossing in answers])
    assert np.allclose(first, expected[:, 0], rtol=1e-12)
    assert np.allclose(every.reshape(-1, len(wall)), expected, rtol=1e-12)


def exact(x: float) -> Fraction:
    return Fraction(float(x))


@pytest.mark.parametrize("distance", [1e7, 1.5e11, 1e16])
def test_points_of_a_far_source(distance):
    """A point lies on its surface by fractions, to the rounding of its own coordinates, and spawned rays run in walls."""
    random = np.random.default_rng(7)
    count = 300
    target = np.stack([random.uniform(-0.6, 0.6, count), random.uniform(-0.6, 0.6, count), np.ones(count)], axis=1)
    to = np.stack([*random.uniform(-0.4, 0.4, (2, count)), -random.uniform(0.5, 1, count)], axis=1)
    scenes = {
        "wall": (co.Box((-1, -1, 0), (1, 1, 1)), lambda p: p[2] - 1, 1),
        "ball": (co.Sphere(1.25), lambda p: sum(x * x for x in p) - Fraction(25, 16), 3),
        "cone": (
            co.Cone((0, 0, -2), (0, 0, 3), 2, 0),
            lambda p: p[0] ** 2 + p[1] ** 2 - (exact(0.4) * (3 - p[2])) ** 2,
            6,
        ),
    }
    for name, (shape, value, steepness) in scenes.items():
        scene = co.Scene([shape])
        hits = scene.first_hit(target - distance * to, to)
        met = hits.hit & (hits.face == hits.face[hits.hit][0])
        assert met.sum() > count / 2 or distance > 1e15
        for point in hits.point[met].tolist():
            assert abs(value([exact(x) for x in point])) <= steepness * 2.0**-50, (name, point)
        if name == "wall":
            assert (hits.point_error[met] < 1e-15).all()
            assert scene.first_hit(hits[met].spawn((1, 0, 0))).hit.all()
