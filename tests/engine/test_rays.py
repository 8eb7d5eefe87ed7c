"""Python's calls around the kernel for one ray, and the scene that the rays of an answer know."""

import gc
import sys
import weakref
from concurrent.futures import ThreadPoolExecutor
from fractions import Fraction

import numpy as np
import pytest

import conicoid as co
from benchmarks.same_answers import solids
from conicoid._jit.machine_code import SHIPPED
from conicoid._util.validation import real_array

# --- Python's calls around the kernel for one ray: a count, because seconds depend on the machine


CALLS = 16 if SHIPPED else 200
"""Calls by a kept call of machine code: 13; through arrays 163, and 357 with two checks of two tuples and two limits.
"""


def _calls_of(query) -> int:
    """Return how many functions are called, Python's and those in C, from the second time on."""
    query()
    count = 0

    def called(_frame, event: str, _argument) -> None:
        nonlocal count
        count += event in ("call", "c_call")

    before = sys.getprofile()
    sys.setprofile(called)
    try:
        query()
    finally:
        sys.setprofile(before)
    return count


@pytest.mark.parametrize("kind", [tuple, list, np.array])
def test_a_query_of_one_ray_calls_few_functions(kind) -> None:
    scene = co.Scene([co.Sphere(1.0, center=(x, 0.0, 0.0)) for x in (0.0, 3.0, 6.0)])
    origin, direction = kind((0.0, 0.0, 5.0)), kind((0.0, 0.0, -1.0))
    assert scene.first_hit(origin, direction).t == 4.0
    assert _calls_of(lambda: scene.first_hit(origin, direction)) <= CALLS
    assert _calls_of(lambda: scene.first_hit(origin, direction, 0.5, 10.0)) <= CALLS


@pytest.mark.parametrize(
    "number", [3, -0.0, 2**53 + 1, 2**63, -(2**64) - 1, 10**300 + 1, 5e-324, float("inf"), 2**1024 - 2**970 - 1]
)
def test_numbers_of_python_are_rounded_as_alone(number) -> None:
    expected = float(Fraction(number)) if isinstance(number, int) else number
    for values in ((number, 0.5, 1), [number, 0.5, 1], number):
        found = real_array("Rays", "origins", values)
        assert found.dtype == np.float64
        first = float(found.ravel()[0])
        assert first.hex() == float(expected).hex()


@pytest.mark.parametrize("values", [(10**400, 0.0, 0.0), [0, 0, -(10**310)], 10**400])
def test_integers_beyond_floats_are_refused(values) -> None:
    with pytest.raises(ValueError, match=r"^Rays: origins must be numbers, got "):
        real_array("Rays", "origins", values, "numbers")


# --- Spawned rays in another scene: the numbers of their surfaces mean nothing there, so they are plain rays


DOWN = (0.0, 0.0, -1.0)
FLOORS = [co.Plane((0, 0, 1), -3), co.Plane((0, 0, 1), -5)]
BALLS = [co.Sphere(1), co.Sphere(1, (3, 0, 0))]


def rays_up(scene):
    """Return rays from above onto both balls and one beside them, and the rays spawned downwards from their hits."""
    return scene.first_hit([(0, 0, 9), (3, 0, 9), (50, 0, 9)], DOWN).spawn(DOWN)


def test_surface_numbers_of_one_scene_are_not_applied_in_another():
    rays = rays_up(co.Scene(BALLS))
    # from z = 1 on the balls down to the floor at z = -3; the miss stays one
    assert co.Scene(FLOORS).first_hit(rays).t.tolist() == [4.0, 4.0, np.inf]
    assert co.Scene(FLOORS[::-1]).first_hit(rays).t.tolist() == [4.0, 4.0, np.inf]


def test_a_single_ray_and_a_row_of_rays_are_plain_too():
    rays, floors = rays_up(co.Scene(BALLS)), co.Scene(FLOORS)
    assert floors.first_hit(rays[0]).t == 4.0
    assert floors.first_hit(rays[2]).t == np.inf
    assert floors.first_hit(rays[np.array([False, True, True])]).t.tolist() == [4.0, np.inf]


def test_hits_of_foreign_rays_have_bounds_and_spawn_rays_of_their_own_scene():
    floors = co.Scene(FLOORS)
    hits = floors.first_hit(rays_up(co.Scene(BALLS)))
    assert (hits.t_error <= 4 * 2.0**-52).all()
    assert floors.first_hit(hits.spawn(DOWN)).t.tolist() == [2.0, 2.0, np.inf]


def test_the_scene_itself_and_equal_ones_know_the_surfaces(tmp_path):
    scene = co.Scene(BALLS)
    co.save(scene, tmp_path / "balls.yaml")
    rays = rays_up(scene)
    for again in (
        scene,
        co.Scene(BALLS),
        co.load(tmp_path / "balls.yaml"),
        co.Scene([co.Body(b, co.matte("red")) for b in BALLS]),
    ):
        assert again.first_hit(rays).t.tolist() == [2.0, 2.0, np.inf]


@pytest.mark.parametrize("index", [slice(1, None), [0, 2], np.array([True, True, False]), None, ...])
def test_chosen_rays_know_their_scene(index):
    scene = co.Scene(BALLS)
    rays = rays_up(scene)
    expected = np.array([2.0, 2.0, np.inf])[index]
    assert np.array_equal(scene.first_hit(rays[index]).t, expected)
    assert np.array_equal(co.Scene(FLOORS).first_hit(rays[index]).t, np.where(expected == 2, 4.0, np.inf))


def random_scene(random):
    radii, centers = random.uniform(0.3, 1, 4), random.uniform(-2, 2, (4, 3))
    box = co.Box(tuple(random.uniform(-2, 0, 3)), tuple(random.uniform(0.1, 2, 3)))
    return co.Scene([*(co.Sphere(r, tuple(c)) for r, c in zip(radii, centers, strict=True)), box])


def test_random_scenes_never_read_each_other():
    """A scene answers rays of another one as it answers the same origins and directions."""
    random = np.random.default_rng(14)
    for _ in range(12):
        one, other = random_scene(random), random_scene(random)
        hits = one.first_hit(random.uniform(-4, 4, (200, 3)), random.normal(size=(200, 3)))
        hits = hits[hits.body >= 0]
        spawned = hits.spawn(random.normal(size=hits.point.shape))
        plain = co.Rays(*spawned)
        found, expected = other.first_hit(spawned), other.first_hit(plain)
        assert np.array_equal(found.t, expected.t)
        assert np.array_equal(found.body, expected.body)
        assert np.array_equal(other.occluded(spawned), other.occluded(plain))
        assert np.array_equal(other.crossings(spawned).t, other.crossings(plain).t)
        assert np.array_equal(other.spans(spawned).t_exit, other.spans(plain).t_exit)


def test_rays_do_not_keep_their_scene_in_memory():
    scene = co.Scene(BALLS)
    prepared = weakref.ref(scene._prepared)
    rays = rays_up(scene)
    del scene
    gc.collect()
    assert prepared() is None
    assert len(rays) == 3


# --- Points in lanes: neither route nor order changes an answer


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
