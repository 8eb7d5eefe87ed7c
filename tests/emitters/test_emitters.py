"""Lamps: polygons cut into triangles, surroundings, spherical geometry."""

import math

import numba
import numpy as np
import pytest

import conicoid as co
from conicoid.render.lights.environment import (
    environment_density,
    environment_direction,
    lower_environment,
    mean_radiance,
)
from conicoid.render.lights.light_sampling import sample_triangle, triangle_angle
from conicoid.render.lights.light_tables import triangulate

# --- Polygons cut into triangles: all of the area and no more; polygons that cross themselves stay as they are

ARROW = [(0, 0), (4, -3), (1, 0), (4, 3)]
COMB = [(0, 0), (6, 0), (6, 3), (5, 3), (5, 1), (4, 1), (4, 3), (3, 3), (3, 1), (2, 1), (2, 3), (0, 3)]
ROUND = [(math.cos(a), math.sin(a)) for a in np.linspace(0, 6, 20)]


def area(loop):
    """Return the area by the shoelace formula."""
    x, y = np.array(loop, float).T
    return 0.5 * abs(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1)))


@pytest.mark.parametrize("loop", [ARROW, COMB, ROUND, ARROW[::-1]], ids=["arrow", "comb", "round", "clockwise"])
@pytest.mark.parametrize("axes", [(0, 1, 2), (1, 2, 0), (2, 0, 1)])
def test_origins_cover_all_of_the_area(loop, axes):
    points = np.zeros((len(loop), 3))
    points[:, axes[0]], points[:, axes[1]], points[:, axes[2]] = *np.array(loop, float).T, 7
    cut = triangulate(points)
    assert cut.shape == (len(loop) - 2, 3)
    a, b, c = (points[cut[:, k]] for k in range(3))
    sizes = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    assert sizes.sum() == pytest.approx(area(loop), rel=1e-12)


def test_a_loop_that_crosses_itself_is_left_alone():
    assert triangulate(np.array([(0, 0, 0), (1, 1, 0), (1, 0, 0), (0, 2, 0)], float)) is None


# --- Images of surroundings: directions have the stated density, and follow the light

HEIGHT, WIDTH = 6, 10
IMAGE = np.random.default_rng(4).random((HEIGHT, WIDTH, 3)) ** 3


@numba.njit
def _drawn(image, numbers, out):
    for k in range(len(numbers)):
        d, density = environment_direction(image, numbers[k, 0], numbers[k, 1])
        out[k, 0], out[k, 1], out[k, 2], out[k, 3] = d[0], d[1], d[2], density
        out[k, 4] = environment_density(image, d[0], d[1], d[2])


def test_directions_have_the_stated_density():
    """The density is even within each pixel, so a pixel's share is density times solid angle.

    χ² compares shares over all pixels.
    """
    count = 40_000
    numbers, out = np.random.default_rng(1).random((count, 2)), np.empty((count, 5))
    _drawn(lower_environment(IMAGE), numbers, out)
    assert out[:, 4] == pytest.approx(out[:, 3], rel=1e-6)
    assert np.linalg.norm(out[:, :3], axis=1) == pytest.approx(np.ones(count), rel=1e-12)
    row = (np.arccos(out[:, 2]) / np.pi * HEIGHT).astype(int)
    column = (np.arctan2(out[:, 1], out[:, 0]) / (2 * np.pi) % 1 * WIDTH).astype(int)
    edges = np.cos(np.linspace(0, np.pi, HEIGHT + 1))
    angle = (edges[:-1] - edges[1:])[row] * 2 * np.pi / WIDTH
    pixel = row * WIDTH + column
    counts = np.bincount(pixel, minlength=HEIGHT * WIDTH)
    share = np.zeros(HEIGHT * WIDTH)
    share[pixel] = out[:, 3] * angle
    assert share.sum() == pytest.approx(1, rel=1e-9)
    square = ((counts - count * share) ** 2 / (count * share)).sum()
    assert square < HEIGHT * WIDTH + 5 * np.sqrt(2 * HEIGHT * WIDTH)


def test_the_mean_of_all_directions():
    assert mean_radiance(np.full((5, 9, 3), 0.7)) == pytest.approx(0.7, rel=1e-12)


# --- Triangles by their solid angle: known angles, known means of directions, and little noise near a lamp


@numba.njit(error_model="numpy")
def _drawn_directions(f, x, y, z, numbers, out):
    for k in range(len(numbers)):
        out[k, 0], out[k, 1], out[k, 2] = sample_triangle(f, 0, x, y, z, numbers[k, 0], numbers[k, 1])


@numba.njit(error_model="numpy")
def _angle(f, x, y, z):
    return triangle_angle(f, 0, x, y, z)


def row(a, b, c):
    a, b, c = np.array(a, float), np.array(b, float), np.array(c, float)
    return np.concatenate([a, b - a, c - a, [1.0]])


@pytest.mark.parametrize(
    ("corners", "angle"),
    [
        (((1, 0, 0), (0, 1, 0), (0, 0, 1)), math.pi / 2),
        (((-1, 0, 1), (1, 0, 1), (0, 1e9, 1)), 2 * math.pi / 4 / 1),  # half of the strip between two planes at 45°
        (((0, 0, 1), (1e-3, 0, 1), (0, 1e-3, 1)), 0.5e-6),
    ],
)
def test_solid_angles(corners, angle):
    assert _angle(row(*corners), 0.0, 0.0, 0.0) == pytest.approx(angle, rel=2e-6)


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize(
    "corners",
    [
        ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
        ((0.2, -3, 1), (2, 0.1, 0.7), (-4, 0.5, 2)),
        ((5, 0, 1), (5, 1, 1), (-9, 0, 1)),
    ],
)
def test_directions_have_the_mean_of_stokes_theorem(corners, turned):
    """∫ ω dω over a spherical polygon is Σ θ n / 2 over its edges, of angle θ and inward unit normal n (Lambert)."""
    corners = corners[::-1] if turned else corners
    f = row(*corners)
    count = 50_000
    numbers, out = np.random.default_rng(1).random((count, 2)), np.empty((count, 3))
    _drawn_directions(f, 0.0, 0.0, 0.0, numbers, out)
    unit = np.array(corners, float) / np.linalg.norm(corners, axis=1)[:, None]
    vector = np.zeros(3)
    for p, q in zip(unit, np.roll(unit, -1, axis=0), strict=True):
        across = np.cross(p, q)
        vector += math.acos(np.dot(p, q)) / 2 * across / np.linalg.norm(across)
    vector *= np.sign(np.dot(vector, unit.sum(axis=0)))
    mean = vector / _angle(f, 0.0, 0.0, 0.0)
    assert out.mean(axis=0) == pytest.approx(mean, abs=5 * out.std(axis=0).max() / math.sqrt(len(out)))
    assert np.linalg.norm(out, axis=1) == pytest.approx(1)
    sides = np.array([np.cross(p, q) for p, q in zip(unit, np.roll(unit, -1, axis=0), strict=True)])
    assert ((out @ sides.T * np.sign(np.dot(sides[0], unit[2]))) > -1e-9).all()


def test_little_noise_close_to_a_lamp():
    """A square lamp is a tenth above the floor.

    The irradiance has a closed form, and 64 samples are within a percent of it.
    """
    half, height = 1.0, 0.1
    x = half / height
    corner = x / math.sqrt(1 + x * x)
    expected = 4 / math.pi * corner * math.atan(corner)
    lamp = co.Polygon([(-1, -1, height), (1, -1, height), (1, 1, height), (-1, 1, height)])
    view = co.OrthographicCamera((0, -1e-3, 1e-4), (0, 0, 0), up=(0, 0, 1), height=1e-9)
    floor = co.Body(co.Plane((0, 0, 1), 0), co.matte((1.0, 1.0, 1.0)))
    scene = co.Scene([floor, co.Body(lamp, co.glow(1))], [co.AmbientLight(0)], view, (0, 0, 0))
    assert scene.render(1, 1, 64).pixels[0, 0] == pytest.approx([expected] * 3, rel=0.01)
    assert scene.render(1, 1, 64, "direct").pixels[0, 0] == pytest.approx([expected] * 3, rel=0.01)
