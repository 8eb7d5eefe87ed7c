"""Lower bounds: in lanes as alone to the bit, whatever else is asked for; never above the truth, and near to it."""

from __future__ import annotations

import math

import numpy as np
import pytest

import conicoid as co

from .bodies import BODIES, random_body


def scene_of(names, seed=0, count=40):
    """Copies of bodies, turned and moved."""
    rng = np.random.default_rng(seed)
    return co.Scene([
        BODIES[names[k % len(names)]][0].rotate(tuple(rng.normal(size=3)), float(rng.uniform(0, 360)))
        .translate(tuple(rng.uniform(-8, 8, 3)))
        for k in range(count)
    ])  # fmt: skip


EVERY = scene_of(list(BODIES))
SHEETS = co.Scene([
    co.Disc((0, 0, 0), (0, 0, 1), 2) - co.Cylinder((0, 0, -1), (0, 0, 1), 1),
    co.CylinderPatch((3, 0, 0), (3, 0, 2), 1, 0, 90, (1, 0, 0)), co.Triangle((5, 0, 0), (6, 0, 0), (5, 1, 0)),
    co.Polygon([(0, 5, 0), (4, 5, 0), (4, 9, 0), (0, 9, 0)]) - co.Sphere(1, (2, 7, 0)),
    co.HalfSpace((0, 0, 1), -9), co.Spheres(np.random.default_rng(2).uniform(-5, 5, (30, 3)), np.full(30, 0.3)),
])  # fmt: skip


def points_of(count, size=10.0, seed=1):
    return np.random.default_rng(seed).uniform(-size, size, (count, 3))


@pytest.mark.parametrize("scene", [EVERY, SHEETS], ids=["solids", "sheets"])
@pytest.mark.parametrize("size", [0.05, 1.0, 10.0, 1e3])
def test_neighbours_change_nothing(scene, size):
    x = points_of(200, size)
    together = scene.distance(x).lower
    assert [scene.distance(p).lower for p in x] == together.tolist()
    assert (scene.distance(x[::-1]).lower[::-1] == together).all()


def test_pictures_are_as_lists():
    x, y = np.meshgrid(np.linspace(-9, 9, 37), np.linspace(-9, 9, 29))
    points = np.stack([x, y, np.full_like(x, 0.25)], axis=-1)
    assert (EVERY.distance(points).lower.ravel() == EVERY.distance(points.reshape(-1, 3)).lower).all()


def test_all_at_one_point_and_too_many_entries():
    rng = np.random.default_rng(4)
    balls = co.Scene([co.Spheres(rng.uniform(-20, 20, (4000, 3)), rng.uniform(0.1, 0.3, 4000))])
    x = points_of(640, 20)  # no two in the same part of the scene
    assert [balls.distance(p).lower for p in x] == balls.distance(x).lower.tolist()
    same = np.repeat(x[:1], 100, axis=0)
    assert len(np.unique(balls.distance(same).lower)) == 1


@pytest.mark.parametrize("scene", [EVERY, SHEETS], ids=["solids", "sheets"])
def test_reach_is_each_points_own(scene):
    x = points_of(150)
    free = scene.distance(x).lower
    reach = np.random.default_rng(5).uniform(0.05, 4, 150)
    found = scene.distance(x, max_distance=reach)
    within = free <= reach
    assert within.any()
    assert not within.all()
    assert (found.lower == np.where(within, free, reach)).all()
    assert (np.isfinite(found.distance) == within).all()


@pytest.mark.parametrize("name", [name for name, (_, field) in BODIES.items() if len(field.surfaces()) == 1])
def test_of_one_face_it_is_the_distance(name):
    # As far as the exact distance is told to be right
    scene, x = co.Scene([BODIES[name][0]]), points_of(300, 3)
    exact, lower = scene.distance(x, exact=True), scene.distance(x).lower
    assert (lower <= np.abs(exact.distance) + exact.error).all()
    assert lower == pytest.approx(np.abs(exact.distance), rel=1e-10, abs=1e-13)


def test_special_points_of_quadrics():
    # On axes and in centers a root is a pole; beside the wall hardly anything is left of f
    cases = [
        (co.Ellipsoid((5, 3, 1)), (0, 0, 0), 1.0),
        (co.Ellipsoid((5, 3, 3)), (1, 0, 0), math.hypot(25 / 16 - 1, 3 * math.sqrt(1 - (25 / 16) ** 2 / 25))),
        (co.Cylinder((0, 0, -9), (0, 0, 9), 2), (0, 0, 1), 2.0),
        (co.Cylinder((0, 0, -9), (0, 0, 9), 2), (2 + 1e-9, 0, 1), 1e-9),
        (co.Ellipsoid((1, 2, 3)), (0, 0, 3 + 1e-12), 1e-12),
        (co.Ellipsoid((1, 2, 3)), (0, 0, 1e9), 1e9 - 3),
        (co.OneSheetHyperboloid(1, 1, 1, (-50, 50)), (0, 0, 0), 1.0),
    ]
    for shape, point, away in cases:
        for x in (point, np.tile(point, (64, 1))):  # alone and in lanes
            lower = np.max(co.Scene([shape]).distance(x).lower)
            slack = 2e-14 * (1 + np.abs(point).max())
            assert away - 1e-9 * away - slack <= lower <= away + 4e-16 * np.abs(point).max()


@pytest.mark.deep
@pytest.mark.parametrize("seed", range(40))
def test_many_bounds_in_lanes_and_alone(seed):
    rng = np.random.default_rng(seed)
    scene = co.Scene([random_body(rng)[0].translate(tuple(rng.uniform(-6, 6, 3))) for _ in range(30)])
    for size in (0.1, 2.0, 9.0, 100.0):
        x = points_of(2000, size, seed)
        lower, exact = scene.distance(x).lower, scene.distance(x[:300], exact=True)
        assert [scene.distance(p).lower for p in x[:300]] == lower[:300].tolist()
        assert (lower[:300] <= np.abs(exact.distance) + exact.error).all()
