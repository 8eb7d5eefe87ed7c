"""Cameras: angles, orientation, refusals, the one that fits a scene; lenses by formulas; and the inverse `project`."""

import dataclasses
import math

import numpy as np
import pytest

import conicoid as co
from conicoid.render.camera import camera_basis, fit_camera, fit_extent
from conicoid.render.camera_rays import lower_view, pixel_lines

# --- Cameras: angles, orientation, refusals; and the camera that fits a scene


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
        (
            lambda: co.Camera((0, 0, 0), (0, 1, 0)).project((1, 2), 4, 4),
            r"project: points must have shape \(..., 3\), got \(2,\)",
        ),
        (lambda: co.Camera((0, 0, 0), (0, 1, 0)).project((1, 2, 3), 0, 4), "width must be a whole number"),
        (lambda: co.Camera((0, 0, 0), (0, 1, 0), aperture=-1), "Camera: aperture must be >= 0"),
        (lambda: co.Camera((0, 0, 0), (0, 1, 0), focus_distance=0), "Camera: focus_distance must be > 0"),
        (lambda: co.Camera((0, 0, 0), (0, 1, 0), blades=2), "Camera: blades must be 0, or a whole number from 3"),
        (lambda: co.FisheyeCamera((0, 0, 0), (0, 1, 0), field_of_view=361), r"field_of_view must be in \(0, 360\]"),
        (lambda: co.FisheyeCamera((0, 0, 0), (0, 1, 0), projection="flat"), "projection must be one of equidistant"),
        (
            lambda: co.FisheyeCamera((0, 0, 0), (0, 1, 0), field_of_view=360, projection="stereographic"),
            r"field_of_view must be in \(0, 360\) degrees",
        ),
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


# --- Cameras beyond the pinhole, by their formulas: circles of confusion, panoramas, fisheyes; and the inverse
# `project`


WIDTH, HEIGHT = 81, 61


def lens_rays(camera, x, y, count=2000):
    """Return origins and directions of rays through the middle of a pixel, (x, y), and many points of the lens."""
    pixel, view = int(y) * WIDTH + int(x), lower_view(camera, "box")
    (origins, directions), bad = np.empty((2, count, 3)), np.zeros(1, np.int8)
    for k, (a, b) in enumerate(np.random.default_rng(1).random((count, 2))):
        pixel_lines(view, pixel, a, b, WIDTH, HEIGHT, 0, 1, origins[k : k + 1], directions[k : k + 1], bad)
    return origins, directions


@pytest.mark.parametrize(("focus", "depth"), [(5.0, 5.0), (5.0, 2.0), (5.0, 9.0), (2.0, 30.0)])
def test_the_circle_of_confusion(focus, depth):
    """A point at depth z covers a disc of diameter A |1/F - 1/z| where the depth is 1."""
    aperture = 0.4
    camera = co.Camera((0, 0, 0), (0, 1, 0), aperture=aperture, focus_distance=focus)
    at = (50.5, 20.5)
    target = depth * through_the_middle(camera, at)
    origins, directions = lens_rays(camera, *at)
    at_depth = origins + directions * ((depth - origins[:, 1]) / directions[:, 1])[:, None]
    spread = np.linalg.norm(at_depth - target, axis=1)  # on the plane of that depth
    expected = aperture / 2 * abs(1 / focus - 1 / depth) * depth
    assert spread.max() <= expected + 1e-12
    assert spread.max() == pytest.approx(expected, rel=1e-2, abs=1e-12)
    if expected:  # uniform: the mean square of the radius of a disc is R² / 2
        assert (spread**2).mean() == pytest.approx(expected**2 / 2, rel=0.05)


def through_the_middle(camera, at):
    """Return where the ray through the middle of the lens has the depth 1, by the film's coordinates."""
    half = math.tan(math.radians(camera.field_of_view / 2))
    return np.array([(2 * at[0] - WIDTH) / HEIGHT * half, 1.0, (HEIGHT - 2 * at[1]) / HEIGHT * half])


def test_rays_of_a_lens_are_those_through_its_middle():
    sharp, soft = co.Camera((1, 2, 3), (0, 0, 0)), co.Camera((1, 2, 3), (0, 0, 0), aperture=0.3)
    assert (np.asarray(sharp.rays(7, 5).directions) == np.asarray(soft.rays(7, 5).directions)).all()
    assert soft.optics[1][1] == pytest.approx(math.sqrt(14), rel=1e-15)  # in focus at the target


def test_points_of_a_disc_and_of_a_polygon_are_even():
    camera = co.Camera((0, 0, 0), (0, 1, 0), aperture=2)  # right is x, up is z
    radius = np.hypot(*lens_rays(camera, 40.5, 30.5, 4000)[0][:, [0, 2]].T)
    assert radius.max() < 1 + 1e-12
    assert (radius < math.sqrt(0.5)).mean() == pytest.approx(0.5, abs=0.03)
    six = lens_rays(dataclasses.replace(camera, blades=6), 40.5, 30.5, 4000)[0][:, [0, 2]]
    # a hexagon of circumradius 1: every normal at 30 + 60 k degrees has n·p <= cos 30°
    angles = np.radians(30 + 60 * np.arange(6))
    reach = six @ np.array([np.cos(angles), np.sin(angles)])
    assert reach.max() <= math.cos(math.radians(30)) + 1e-12
    assert (reach.max(axis=1) < math.cos(math.radians(30)) * math.sqrt(0.5)).mean() == pytest.approx(0.5, abs=0.03)
    assert np.abs(six.mean(axis=0)).max() < 0.03


def test_points_out_of_focus_alone_are_blurred():
    def edge(depth, aperture):
        wall = co.Body(co.Polygon([(0, depth, -50), (50, depth, -50), (50, depth, 50), (0, depth, 50)]), "white")
        camera = co.Camera((0, 0, 0), (0, 4, 0), aperture=aperture)
        scene = co.Scene([wall], camera=camera, background="black", lights=[co.AmbientLight(1)])
        return scene.render(64, 48, 64).pixels[24, :, 0]

    assert np.abs(edge(4, 0.5) - edge(4, 0)).max() < 1e-6
    blurred = edge(8, 0.5)
    grey = np.flatnonzero((blurred > 0.02) & (blurred < 0.98))
    # the circle of confusion, 0.5 (1/4 - 1/8), in pixels of 2 tan(20°) / height
    expected = 0.5 * (1 / 4 - 1 / 8) / (2 * math.tan(math.radians(20)) / 48)
    assert len(grey) == pytest.approx(expected, abs=1.5)


def test_a_panorama_is_longitude_and_latitude():
    camera = co.EquirectangularCamera((1, 2, 3), (1, 9, 3))
    rays = camera.rays(36, 18)
    assert (np.asarray(rays.origins) == (1, 2, 3)).all()
    x, y = np.meshgrid(np.arange(36) + 0.5, np.arange(18) + 0.5)
    longitude, latitude = np.radians(x * 10 - 180), np.radians(90 - y * 10)
    expected = np.stack(
        [np.sin(longitude) * np.cos(latitude), np.cos(longitude) * np.cos(latitude), np.sin(latitude)], axis=-1
    )
    assert np.abs(np.asarray(rays.directions) - expected).max() < 1e-15


@pytest.mark.parametrize(
    ("projection", "distance"),
    [
        ("equidistant", lambda angle, rim: angle / rim),
        ("equisolid", lambda angle, rim: np.sin(angle / 2) / math.sin(rim / 2)),
        ("stereographic", lambda angle, rim: np.tan(angle / 2) / math.tan(rim / 2)),
    ],
)
@pytest.mark.parametrize("field", [90, 180, 300])
def test_a_fisheye_is_its_formula(projection, distance, field):
    camera = co.FisheyeCamera((0, 0, 0), (0, 1, 0), field_of_view=field, projection=projection)
    directions = np.asarray(camera.rays(50, 50).directions)
    x, y = np.meshgrid(np.arange(50) + 0.5, np.arange(50) + 0.5)
    u, v = (x - 25) / 25, (25 - y) / 25
    far = np.hypot(u, v)
    angle = np.arctan2(np.hypot(directions[..., 0], directions[..., 2]), directions[..., 1])
    visible = far <= 1
    assert np.abs(distance(angle, math.radians(field / 2)) - far)[visible].max() < 1e-12
    along = np.arctan2(directions[..., 2], directions[..., 0]) - np.arctan2(v, u)
    assert np.abs(np.sin(along))[visible].max() < 1e-12


def test_around_the_circle_of_a_fisheye_it_is_black():
    scene = co.Scene([], camera=co.FisheyeCamera((0, 0, 0), (0, 1, 0)), background=(1, 1, 1))
    pixels = scene.render(40, 40, 1).pixels[..., 0]
    x, y = np.meshgrid(np.arange(40) + 0.5, np.arange(40) + 0.5)
    assert ((pixels == 1) == (np.hypot(x - 20, y - 20) <= 20)).all()
    assert ((pixels == 0) | (pixels == 1)).all()


FLAT_CAMERAS = [
    co.Camera((3, -7, 4), (0.5, 0, 1), field_of_view=35),
    co.Camera((0, 0, 9), (0, 0, 0)),
    co.Camera((1e6, 1e6, 3), (1e6, 1e6 + 1, 2.5), up=(1, 2, 3), field_of_view=120),
    co.OrthographicCamera((2, -3, 1), (0, 0, 0), height=5),
]
CAMERAS = [
    co.Camera((1, 2, 3), (4, 0, 1), field_of_view=70, aperture=0.2, blades=5),
    co.EquirectangularCamera((1, 2, 3), (4, 0, 1)),
    co.FisheyeCamera((1, 2, 3), (4, 0, 1), field_of_view=200),
    co.FisheyeCamera((1, 2, 3), (4, 0, 1), projection="equisolid"),
    co.FisheyeCamera((1, 2, 3), (4, 0, 1), field_of_view=270, projection="stereographic"),
]


@pytest.mark.parametrize("camera", [*CAMERAS, *FLAT_CAMERAS], ids=repr)
@pytest.mark.parametrize(("width", "height"), [(31, 23), (4, 9)])
def test_project_is_the_way_back(camera, width, height):
    """Points on the rays of pixels come back to the middles of these. Positions of 1e6 are rounded to 1e-10."""
    origins, directions = map(np.asarray, camera.rays(width, height))
    t = np.random.default_rng(0).uniform(0.5, 20, (height, width, 1))
    x, y = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    found = camera.project(origins + t * directions, width, height)
    far = np.hypot(2 * x - width, height - 2 * y) / min(width, height)
    visible = far <= 1 if isinstance(camera, co.FisheyeCamera) else far > -1
    assert np.abs(found - np.stack([x, y], axis=-1))[visible].max() < (1e-7 if camera in FLAT_CAMERAS else 1e-10)


@pytest.mark.parametrize("camera", CAMERAS, ids=repr)
def test_pictures_show_the_hits_of_camera_rays(camera):
    scene = co.Scene([co.Sphere(1.0), co.Sphere(0.5, (3, 3, 3)), co.Box((-9, -9, -2), (9, 9, -1))], camera=camera)
    pinhole = camera if not isinstance(camera, co.Camera) else co.Camera((1, 2, 3), (4, 0, 1), field_of_view=70)
    pixels = scene.render(24, 16, 1, integrator="normals", camera=pinhole).pixels
    normal = np.asarray(scene.first_hit(pinhole.rays(24, 16)).normal)
    expected = np.where(np.isnan(normal), 0, 0.5 + 0.5 * normal)
    if isinstance(camera, co.FisheyeCamera):
        x, y = np.meshgrid(np.arange(24) + 0.5, np.arange(16) + 0.5)
        expected[np.hypot(x - 12, y - 8) > 8] = 0
    assert np.abs(pixels - expected).max() < 1e-6


# --- Places of points in a picture: the inverse of its rays


@pytest.mark.parametrize("camera", FLAT_CAMERAS)
def test_points_behind_the_camera_have_no_pixel(camera):
    back = np.subtract(camera.position, camera.look_at)
    behind = camera.project(np.array([camera.position, camera.position + 0.1 * back, camera.look_at]), 5, 3)
    assert np.isnan(behind[:2]).all()
    assert behind[2] == pytest.approx((2.5, 1.5), abs=1e-6)


def test_points_beside_the_picture_are_beyond_its_edges():
    """The camera looks down from a height of 4: a unit is half of 100 pixels, y is up."""
    camera = co.OrthographicCamera((0, 0, 9), (0, 0, 0), height=4)
    assert camera.project((0, 0, 0), 200, 200).tolist() == [100, 100]
    assert camera.project([(4, 0, 0), (0, 4, 0)], 200, 200).tolist() == [[300, 100], [100, -100]]
