"""Measured by rays against formulas: values within their errors, errors small and honest."""

from __future__ import annotations

import math

import numpy as np
import pytest

import conicoid as co

from ..samples import sampled
from .solids import KNOWN, Known

SIGMAS = 4


def assert_known(known: Known, found: co.measures.Measures) -> None:
    assert found.volume == pytest.approx(known.volume, abs=SIGMAS * found.volume_error)
    if known.area is not None:
        assert found.area == pytest.approx(known.area, abs=SIGMAS * found.area_error)
    if known.centroid is not None:
        assert (np.abs(found.centroid - known.centroid) <= SIGMAS * found.centroid_error).all()
    if known.inertia is not None:
        assert (np.abs(found.inertia - np.diag(known.inertia)) <= SIGMAS * found.inertia_error).all()


@pytest.mark.parametrize("known", sampled(KNOWN, 3), ids=lambda known: known.name)
def test_against_formulas(known: Known):
    found = co.measure(known.shape, rays=60_000, seed=1)
    assert found.rays <= 70_000
    assert 0 < found.volume_error < 0.01 * known.volume
    assert_known(known, found)


@pytest.mark.deep
@pytest.mark.parametrize("known", KNOWN, ids=lambda known: known.name)
def test_a_million_rays_give_a_tenth_of_a_percent(known: Known):
    found = co.measure(known.shape, rays=1_000_000, seed=2)
    assert found.rays <= 1_010_000
    assert found.volume_error < 1e-3 * known.volume
    assert found.area_error < 1e-3 * found.area
    assert_known(known, found)


@pytest.mark.parametrize(
    "name", sampled(["thin shell", "lens of two spheres", "two thin rods askew", "half a ball", "box with a hole"], 5)
)
def test_errors_are_honest(name: str):
    """Over many seeds the deviations have the size that their errors say: χ² of 60 is within 4.5 sigma of 60."""
    known = next(known for known in KNOWN if known.name == name)
    found = [co.measure(known.shape, rays=3_000, seed=seed) for seed in range(60)]
    rows = [
        [((m.volume - known.volume) / m.volume_error) for m in found],
        [((m.area - known.area) / m.area_error) for m in found],
    ]
    rows += [[((m.centroid - known.centroid) / m.centroid_error)[k] for m in found] for k in range(3) if known.centroid]
    for deviations in np.array(rows):
        assert abs((deviations**2).sum() - 60) < 4.5 * math.sqrt(2 * 60)


@pytest.mark.parametrize(("shape", "area"), [(co.Sphere(1.5), 9 * math.pi), (co.Box((0, 0, 0), (1, 2, 3)), 22.0)])
def test_crofton_by_counting(shape: co.Shape, area: float):
    """The area by isotropic lines through a ball of radius R, 2 π R² E[crossings], agrees with that by three families."""
    n, radius = 100_000, 2.5
    random = np.random.default_rng(3)
    low, high = shape.bounds
    direction = random.normal(size=(n, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    u = np.cross(direction, np.eye(3)[np.argmin(np.abs(direction), axis=1)])
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    angle, distance = random.uniform(0, 2 * math.pi, (n, 1)), radius * np.sqrt(random.random((n, 1)))
    origin = (low + high) / 2 + distance * (np.cos(angle) * u + np.sin(angle) * np.cross(direction, u))
    counts = np.diff(co.Scene([shape]).crossings(origin, direction, t_min=-math.inf).offsets)
    factor = 2 * math.pi * radius**2
    error = factor * counts.std() / math.sqrt(n)
    assert factor * counts.mean() == pytest.approx(area, abs=SIGMAS * error)
    found = co.measure(shape & shape, rays=20_000)
    assert found.area == pytest.approx(area, abs=SIGMAS * found.area_error)


def test_sheets_have_an_area_only():
    sheet = co.Plane((1, 2, 2), 1) & co.Sphere(1.5)
    found = co.measure(sheet, rays=20_000)
    assert found.area == pytest.approx(math.pi * (1.5**2 - 1 / 9), abs=SIGMAS * found.area_error)
    assert found.volume == found.volume_error == 0
    polygon = co.Polygon([(0, 0, 1), (4, 0, 1), (4, 4, 1), (2, 1, 1), (0, 4, 1)])
    found = co.measure(polygon, rays=20_000)
    assert found.area == pytest.approx(4 * 4 - 4 * 3 / 2, abs=SIGMAS * found.area_error)
    assert np.isnan(found.centroid).all()


def test_the_same_seed_gives_the_same_numbers_on_any_number_of_threads():
    shape = co.Sphere(1) - co.Cylinder((0, 0, -2), (1, 0, 2), 0.5)
    runs = []
    try:
        for threads in (1, 3, None):
            co.set_threads(threads)
            runs.append(co.measure(shape, rays=30_000, seed=5))
    finally:
        co.set_threads(None)
    for run in runs[1:]:
        assert (run.volume, run.area, run.volume_error) == (runs[0].volume, runs[0].area, runs[0].volume_error)
        assert np.array_equal(run.inertia, runs[0].inertia)
    assert co.measure(shape, rays=30_000, seed=6).volume != runs[0].volume


@pytest.mark.parametrize("scale", [1e-9, 1e9])
def test_scale(scale: float):
    shape = co.Sphere(1) - co.Box((0, 0, 0), (2, 2, 2))
    one, other = co.measure(shape, rays=10_000), co.measure(shape.scale(scale), rays=10_000)
    assert other.volume == pytest.approx(one.volume * scale**3, abs=6 * one.volume_error * scale**3)
    assert other.area == pytest.approx(one.area * scale**2, abs=6 * one.area_error * scale**2)
    assert np.allclose(other.inertia_error, one.inertia_error * scale**5, rtol=0.3, atol=0)


def test_many_parts_and_great_depth():
    random = np.random.default_rng(4)
    centers = [(x, y, z) for x in range(7) for y in range(7) for z in range(7)]
    radii = random.uniform(0.2, 0.45, len(centers))
    found = co.measure(co.Spheres(centers, radii), rays=60_000)
    assert found.volume == pytest.approx(4 / 3 * math.pi * (radii**3).sum(), abs=SIGMAS * found.volume_error)
    assert found.volume_error < 0.01 * found.volume
    shape: co.Solid = co.Box((0, 0, 0), (40, 1, 1))
    for k in range(40):
        shape = (shape - co.Box((k + 0.25, 0, 0), (k + 0.75, 1, 1))) | co.Sphere(0.125, (k + 0.5, 0.5, 0.5))
    found = co.measure(shape, rays=20_000)
    assert found.volume == pytest.approx(20 + 40 * 4 / 3 * math.pi / 512, abs=SIGMAS * found.volume_error)
