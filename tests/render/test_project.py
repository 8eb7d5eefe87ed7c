"""Where points are seen: the other way round from the rays of a picture."""

from __future__ import annotations

import numpy as np
import pytest

import conicoid as co

CAMERAS = [
    co.Camera((3, -7, 4), (0.5, 0, 1), field_of_view=35),
    co.Camera((0, 0, 9), (0, 0, 0)),
    co.Camera((1e6, 1e6, 3), (1e6, 1e6 + 1, 2.5), up=(1, 2, 3), field_of_view=120),
    co.OrthographicCamera((2, -3, 1), (0, 0, 0), height=5),
]


@pytest.mark.parametrize("camera", CAMERAS)
@pytest.mark.parametrize(("width", "height"), [(7, 5), (4, 9)])
def test_points_on_the_ray_of_a_pixel_are_seen_in_its_centre(camera, width, height):
    origins, directions = camera.rays(width, height)
    t = np.random.default_rng(0).uniform(0.5, 20, (height, width, 1))
    seen = camera.project(origins + t * directions, width, height)
    assert seen.shape == (height, width, 2)
    x, y = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    assert np.abs(seen - np.stack([x, y], axis=-1)).max() < 1e-7  # positions of 1e6 are rounded to 1e-10


@pytest.mark.parametrize("camera", CAMERAS)
def test_what_is_not_in_front_is_nowhere(camera):
    back = np.subtract(camera.position, camera.look_at)
    behind = camera.project(np.array([camera.position, camera.position + 0.1 * back, camera.look_at]), 5, 3)
    assert np.isnan(behind[:2]).all()
    assert behind[2] == pytest.approx((2.5, 1.5), abs=1e-6)


def test_what_lies_beside_the_picture_is_beyond_its_edges():
    """A view from above, 4 high: a unit is half of 100 pixels, y is up."""
    camera = co.OrthographicCamera((0, 0, 9), (0, 0, 0), height=4)
    assert camera.project((0, 0, 0), 200, 200).tolist() == [100, 100]
    assert camera.project([(4, 0, 0), (0, 4, 0)], 200, 200).tolist() == [[300, 100], [100, -100]]


def test_refusals():
    camera = CAMERAS[0]
    with pytest.raises(ValueError, match=r"project: points must have shape \(..., 3\), got \(2,\)"):
        camera.project((1, 2), 4, 4)
    with pytest.raises(ValueError, match="width must be a whole number"):
        camera.project((1, 2, 3), 0, 4)
