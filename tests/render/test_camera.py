"""Cameras: angles, orientation, refusals; and the camera that fits a scene."""

from __future__ import annotations

import math

import numpy as np
import pytest

import conicoid as co
from conicoid.render.camera import camera_basis, fit_camera, fit_extent


def test_the_middle_ray_looks_at_the_target():
    camera = co.Camera((1, 2, 3), (4, 6, 3))
    origins, directions = camera.rays(5, 3)
    assert origins.shape == directions.shape == (3, 5, 3)
    assert directions[1, 2] == pytest.approx((0.6, 0.8, 0), abs=1e-15)
    assert (origins == (1, 2, 3)).all()
    assert np.linalg.norm(directions, axis=-1) == pytest.approx(np.ones((3, 5)), abs=1e-15)


def test_the_vertical_angle_is_the_field_of_view():
    """The centre of row i of h lies at v = (h - 1 - 2i) / h of tan(angle / 2)."""
    camera = co.Camera((0, 0, 0), (0, 1, 0), field_of_view=60)
    directions = np.asarray(camera.rays(3, 101).directions)
    top = directions[0, 1]
    assert math.atan2(top[2], top[1]) == pytest.approx(math.atan(100 / 101 * math.tan(math.radians(30))), rel=1e-14)


def test_rows_run_from_the_top_and_columns_to_the_right():
    directions = np.asarray(co.Camera((0, 0, 0), (0, 1, 0)).rays(4, 4).directions)
    assert directions[0, 0][2] > 0 > directions[3, 0][2]
    assert directions[0, 0][0] < 0 < directions[0, 3][0]


def test_pixels_are_square():
    directions = np.asarray(co.Camera((0, 0, 0), (0, 1, 0)).rays(30, 10).directions)
    film = directions / directions[..., 1:2]
    step = film[0, 1, 0] - film[0, 0, 0]
    assert film[0, 0, 2] - film[1, 0, 2] == pytest.approx(step, rel=1e-12)


def test_parallel_rays():
    camera = co.OrthographicCamera((0, -5, 0), (0, 0, 0), height=4)
    origins, directions = map(np.asarray, camera.rays(8, 4))
    assert (directions == (0, 1, 0)).all()
    assert origins[0, 0] == pytest.approx((-3.5, -5, 1.5), abs=1e-15)
    assert origins[3, 7] == pytest.approx((3.5, -5, -1.5), abs=1e-15)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: co.Camera((1, 2, 3), (1, 2, 3)), "Camera: look_at must differ from position"),
        (lambda: co.Camera((0, 0, 0), (0, 1, 0), up=(0, 0, 0)), "Camera: up must not be zero"),
        (lambda: co.Camera((0, 0, 0), (0, 1, 0), field_of_view=180), r"Camera: field_of_view must be in \(0, 180\)"),
        (lambda: co.Camera((0, 0, math.nan), (0, 1, 0)), r"Camera: position\[2\] must be finite"),
        (lambda: co.OrthographicCamera((0, 0, 0), (0, 1, 0), height=0), "OrthographicCamera: height must be > 0"),
        (lambda: co.Camera((0, 0, 0), (0, 1, 0)).rays(0, 10), "rays: width must be a whole number"),
        (lambda: co.Camera((0, 0, 0), (0, 1, 0)).rays(10, 2.5), "rays: height must be a whole number"),
    ],
)
def test_bad_cameras_name_the_field(make, message):
    with pytest.raises(ValueError, match=message):
        make()


@pytest.mark.parametrize("aspect", [0.5, 1, 4 / 3, 3])
def test_the_default_camera_has_all_corners_in_view_and_not_far_off(aspect):
    low, high = np.array([-1.0, 3, 0]), np.array([5.0, 4, 0.5])
    camera = fit_camera(low, high, aspect)
    right, up, forward = camera_basis(camera.position, camera.look_at, camera.up)
    half = math.tan(math.radians(camera.field_of_view) / 2)
    reach = 0.0
    for corner in np.array(np.meshgrid(*zip(low, high, strict=True))).reshape(3, -1).T - camera.position:
        reach = max(
            reach,
            abs(corner @ right) / (corner @ forward) / half / aspect,
            abs(corner @ up) / (corner @ forward) / half,
        )
    assert 0.8 < reach < 1


def test_the_extent_of_unbounded_scenes_is_finite():
    inf = math.inf
    low, high = fit_extent(np.array([[-1.0, -1, 0, 1, 1, 1], [-inf, -inf, -inf, inf, inf, 0.0]]))
    assert (low == (-1, -1, 0)).all()
    assert (high == (1, 1, 1)).all()
    low, high = fit_extent(np.array([[-inf] * 3 + [inf] * 3]))
    assert (low == -1).all()
    assert (high == 1).all()
    low, high = fit_extent(np.zeros((0, 6)))
    assert (low < high).all()
