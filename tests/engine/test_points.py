"""Points in lanes: neither route nor order changes an answer."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import conicoid as co
from benchmarks.same_answers import solids


def grid(low: float, high: float, *counts: int):
    """Return (*counts, 3) points at dyadic places. Many lie on walls."""
    axes = [np.linspace(low, high, count) for count in counts]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)


FAR = co.Spheres(100 + np.mgrid[0:6, 0:6, 0:6].reshape(3, -1).T, 0.1)


def one_by_one(scene: co.Scene, points):
    """Return the answers by the other route.

    Every second point lies in FAR, so that boxes around points are full of its bodies.
    """
    flat = points.reshape(-1, 3)
    mixed = np.stack([flat, np.resize(FAR.centers, flat.shape)], axis=1)
    found = scene.body_at(mixed.reshape(-1, 3)).reshape(-1, 2)
    assert (found[:, 1] >= 0).all()
    return found[:, 0].reshape(points.shape[:-1])


def by_hand(items, points):
    """Return the first of some balls and boxes that holds each point, by their inequalities in exact whole numbers."""
    found = np.full(points.shape[:-1], -1)
    for number in range(len(items) - 1, -1, -1):
        item = items[number]
        if isinstance(item, co.Sphere):
            inside = ((points - item.center) ** 2).sum(axis=-1) <= item.radius**2
        else:
            inside = ((points >= item.low) & (points <= item.high)).all(axis=-1)
        found[inside] = number
    return found


ITEMS = [
    co.Sphere(5, (0, 0, 0)), co.Box((-2, -6, -6), (6, 2, 6)), co.Sphere(3, (6, 6, 6)), co.Sphere(3, (-6, 6, 0)),
    co.Box((-8, -8, -8), (-4, -4, -4)), co.Sphere(13, (0, 0, 12)),
]  # fmt: skip


def test_whole_numbers_on_walls_are_decided_as_they_are_written():
    points = grid(-8, 8, 17, 17, 17)  # whole numbers: many lie on spheres and on all walls
    expected = by_hand(ITEMS, points)
    scene = co.Scene(ITEMS)
    assert (scene.body_at(points) == expected).all()
    assert (scene.body_at(points.reshape(-1, 3)) == expected.ravel()).all()
    assert (scene.contains(points) == (expected >= 0)).all()
    order = np.random.default_rng(3).permutation(expected.size)
    assert (scene.body_at(points.reshape(-1, 3)[order]) == expected.ravel()[order]).all()


@pytest.mark.parametrize("name", list(solids()))
def test_every_solid_in_lanes_as_one_by_one(name: str):
    shape = solids()[name]
    scene = co.Scene([shape, co.Sphere(0.5, (0.25, 0, 0)), FAR])
    for points in (grid(-1.5, 1.5, 7, 8, 9), grid(0, 0.5, 20, 20, 1)[:, :, 0], grid(-0.125, 0.125, 65, 1, 1)):
        assert (scene.body_at(points) == one_by_one(scene, points)).all()


def test_many_bodies_in_every_order():
    rng = np.random.default_rng(5)
    places = rng.uniform(-8, 8, (300, 3))
    cut = [co.Sphere(0.75, tuple(p)) - co.Box(tuple(p), tuple(p + 1)) for p in places[:100]]
    drums = [co.Cylinder(tuple(p), tuple(p + rng.normal(size=3)), 0.5) for p in places[100:200]]
    balls = co.Spheres(places[200:], 0.75)
    solid = co.Sphere(9) - co.Box((-9, -9, -9), (0, 0, 0))
    scene = co.Scene([*cut, *drums, balls, solid])
    points = grid(-9, 9, 24, 30, 36)
    found, flat = scene.body_at(points), points.reshape(-1, 3)
    order = rng.permutation(len(flat))
    assert (scene.body_at(flat[order]) == found.ravel()[order]).all()
    assert len(np.unique(found)) > 150


def test_all_bodies_at_points():
    points = grid(-8, 8, 17, 17, 9)
    scene = co.Scene([co.Body(item, name=f"item {k}") for k, item in enumerate(ITEMS)])
    at = scene.bodies_at(points)
    assert at.shape == points.shape[:-1]
    assert len(at) == points.size // 3
    expected = np.stack([by_hand([item], points) == 0 for item in ITEMS], axis=-1)
    assert (at.counts == expected.sum(axis=-1)).all()
    assert at.counts.max() >= 3
    for i, inside in enumerate(expected.reshape(-1, len(ITEMS))):
        assert at[i].tolist() == np.flatnonzero(inside).tolist()
    assert [*at.name[:5]] == [f"item {k}" for k in at.body[:5]]
    assert scene.bodies_at((0, 0, 0)).body.tolist() == [0, 1, 5]
    assert co.Scene([]).bodies_at(points).offsets.tolist() == [0] * (points.size // 3 + 1)


def test_bodies_at_in_parts():
    points = np.random.default_rng(1).uniform(-9, 9, (5000, 3))
    scene = co.Scene(ITEMS)
    here = scene.bodies_at(points)
    with ThreadPoolExecutor(2) as executor:
        there = scene.bodies_at(points, executor=executor)
    assert there == here
    assert there != scene.bodies_at(points[::-1])


def test_doubtful_points_are_in_all_bodies_that_touch_there():
    # (3, 4, 0) is on both balls, by 3² + 4² = 5² and the equal ball beyond; (1, 1, 1)/... lies on no float's wall.
    scene = co.Scene([co.Sphere(5), co.Sphere(5, (6, 8, 0)), ~co.Sphere(5)])
    assert scene.bodies_at((3, 4, 0)).body.tolist() == [0, 1]
    assert scene.bodies_at([(3, 4, 0), (6, 8, 0), (30, 0, 0)]).offsets.tolist() == [0, 2, 4, 5]


def test_points_beyond_the_domain_are_refused():
    with pytest.raises(ValueError, match=r"^bodies_at: points\[1\] must be finite"):
        co.Scene([co.Sphere()]).bodies_at([(0, 0, 0), (np.inf, 0, 0)])
