"""Python's calls around the kernel for one ray, and the scene that the rays of an answer know."""

import gc
import sys
import weakref
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

import conicoid as co
from conicoid._jit.machine_code import SHIPPED
from conicoid._util.validation import real_array

# --- Python's calls around the kernel for one ray: a count, because seconds depend on the machine


CALLS = 16 if SHIPPED else 200
"""Calls by a kept call of machine code: 13; through arrays 163, and 357 with two checks of two tuples and two limits.
"""


def _calls_of(query: Any) -> int:
    """Return how many functions are called, Python's and those in C, from the second time on."""
    query()
    count = 0

    def called(_frame: Any, event: str, _argument: Any) -> None:
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
def test_a_query_of_one_ray_calls_few_functions(kind: Any) -> None:
    scene = co.Scene([co.Sphere(1.0, center=(x, 0.0, 0.0)) for x in (0.0, 3.0, 6.0)])
    origin, direction = kind((0.0, 0.0, 5.0)), kind((0.0, 0.0, -1.0))
    assert scene.first_hit(origin, direction).t == 4.0
    assert _calls_of(lambda: scene.first_hit(origin, direction)) <= CALLS
    assert _calls_of(lambda: scene.first_hit(origin, direction, 0.5, 10.0)) <= CALLS


@pytest.mark.parametrize(
    "number", [3, -0.0, 2**53 + 1, 2**63, -(2**64) - 1, 10**300 + 1, 5e-324, float("inf"), 2**1024 - 2**970 - 1]
)
def test_numbers_of_python_are_rounded_as_alone(number: Any) -> None:
    expected = float(Fraction(number)) if isinstance(number, int) else number
    for values in ((number, 0.5, 1), [number, 0.5, 1], number):
        found = real_array("Rays", "origins", values)
        assert found.dtype == np.float64
        first = float(found.ravel()[0])
        assert first.hex() == float(expected).hex()


@pytest.mark.parametrize("values", [(10**400, 0.0, 0.0), [0, 0, -(10**310)], 10**400])
def test_integers_beyond_floats_are_refused(values: Any) -> None:
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


def test_no_query_takes_the_numbers_of_another_scene():
    rays, floors = rays_up(co.Scene(BALLS)), co.Scene([*FLOORS, co.Box((-9, -9, -8), (9, 9, -7))])
    assert floors.occluded(rays).tolist() == [True, True, False]
    crossings, spans = floors.crossings(rays), floors.spans(rays)
    assert crossings.offsets.tolist() == [0, 4, 8, 8]
    assert crossings.t.tolist() == [4.0, 6.0, 8.0, 9.0] * 2
    assert (crossings.t_error < 1e-15).all()
    assert spans.lengths().tolist() == [[0.0, 0.0, 1.0]] * 2 + [[0.0, 0.0, 0.0]]


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


def test_the_same_bodies_in_another_order_are_another_scene():
    rays, turned = rays_up(co.Scene(BALLS)), co.Scene(BALLS[::-1])
    assert turned.first_hit(rays).t.tolist() == turned.first_hit(co.Rays(*rays[:2])).t.tolist() + [np.inf]


@pytest.mark.parametrize("index", [slice(1, None), [0, 2], np.array([True, True, False]), None, ...])
def test_chosen_rays_know_their_scene(index):
    scene = co.Scene(BALLS)
    rays = rays_up(scene)
    expected = np.array([2.0, 2.0, np.inf])[index]
    assert np.array_equal(scene.first_hit(rays[index]).t, expected)
    assert np.array_equal(co.Scene(FLOORS).first_hit(rays[index]).t, np.where(expected == 2, 4.0, np.inf))


def test_unpacked_rays_are_plain_in_their_own_scene():
    scene = co.Scene(BALLS)
    origins, directions = rays_up(scene)[:1]
    assert scene.first_hit(co.Rays(origins, directions), t_min=-1).t.tolist() == [0.0]


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
