"""Pictures: reproducible to the bit, true to the geometry, and errors that say what exists."""

from __future__ import annotations

import numpy as np
import pytest

import conicoid as co
from conicoid.render.integrators import INTEGRATORS
from conicoid.render.tiles import SIDE

SCENE = co.Scene(
    [
        co.Body(co.Sphere(1, (0, 0, 1)), co.glass()),
        co.Body(co.Cylinder((1, 1, 0), (2, 1.5, 1), 0.5), co.lacquer("crimson")),
        co.Body(co.Box((-4, -4, -0.2), (4, 4, 0)), co.matte(co.Checker(scale=0.5, space=True))),
    ],
)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_the_same_picture_for_any_number_of_threads(integrator):
    pictures = []
    try:
        for threads in (1, 2, 5):
            co.set_threads(threads)
            pictures.append(SCENE.render(50, 37, 3, integrator=integrator).pixels)
    finally:
        co.set_threads(None)
    assert (pictures[0] == pictures[1]).all()
    assert (pictures[0] == pictures[2]).all()


def test_seeds_move_the_samples():
    one, two = (SCENE.render(50, 37, 3, seed=seed).pixels for seed in (1, 2))
    assert (one == SCENE.render(50, 37, 3, seed=1).pixels).all()
    assert (one != two).any()
    assert np.abs(one.mean() - two.mean()) < 0.01


def test_one_sample_goes_through_the_pixel_centre():
    camera = co.Camera((4, -6, 4), (0, 0, 0.5))
    scene = co.Scene(SCENE.bodies, camera=camera)
    pixels = scene.render(40, 30, 1, integrator="normals").pixels
    normal = np.asarray(scene.first_hit(camera.rays(40, 30)).normal)
    expected = np.where(np.isnan(normal), 0, 0.5 + 0.5 * normal)
    assert np.abs(pixels - expected).max() < 1e-6


def test_a_camera_and_lights_come_by_themselves():
    pixels = SCENE.render(60, 40, 1).pixels
    assert pixels.dtype == np.float32
    assert pixels.shape == (40, 60, 3)
    assert np.ptp(pixels) > 0.5
    assert co.Scene([]).render(8, 8).pixels.min() > 0.5


def test_progress_ends_with_the_count():
    calls = []
    SCENE.render(50, 37, 1, progress=lambda done, count: calls.append((done, count)))
    tiles = -(-50 // SIDE) * -(-37 // SIDE)
    assert calls[-1] == (tiles, tiles)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (dict(integrator="photons"), f"render: integrator must be one of {', '.join(INTEGRATORS)}, got 'photons'"),
        (dict(width=0), "render: width must be a whole number of pixels >= 1, got 0"),
        (dict(samples=0), "render: samples must be a whole number from 1 to 1048576, got 0"),
        (dict(samples=2.5), "render: samples must be a whole number"),
        (dict(seed=-1), "render: seed must be a whole number"),
        (dict(depth=-1), "render: depth must be a whole number"),
    ],
)
def test_bad_arguments_are_named(arguments, message):
    with pytest.raises(ValueError, match=message):
        SCENE.render(**{"width": 8, "height": 8, **arguments})


def test_what_is_no_material_or_camera_is_a_type_error():
    """At the door, before anything is rendered."""
    with pytest.raises(TypeError, match="Body: material must be a Material"):
        co.Body(co.Sphere(), 3)
    with pytest.raises(
        TypeError,
        match="Scene: camera must be a Camera, OrthographicCamera, EquirectangularCamera, FisheyeCamera or None, got str",
    ):
        co.Scene([co.Sphere()], camera="front")


def test_many_bodies_of_one_entry_share_a_material():
    centers = np.array([(x, 0.0, 0.0) for x in (-2, 0, 2)])
    camera = co.OrthographicCamera((0, -5, 0), (0, 0, 0), height=2)
    balls = co.Body(co.Spheres(centers, np.full(3, 0.5)), co.matte((1, 0, 0)))
    pixels = (
        co.Scene([balls], lights=[co.AmbientLight(1)], camera=camera, background=(0, 0, 1)).render(60, 20, 1).pixels
    )
    assert (pixels[10, [10, 30, 50]] == (1, 0, 0)).all()
    assert (pixels[10, [0, 20, 40]] == (0, 0, 1)).all()
