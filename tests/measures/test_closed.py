"""Closed forms against rays and against formulas, under motions; refusals; what an answer looks like."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

import conicoid as co

from ..samples import in_turn, size
from .solids import askew

PI = math.pi

PRIMITIVES = {
    "sphere": co.Sphere(1.5, (1, 2, 3)),
    "ellipsoid": co.Ellipsoid((1, 2, 3), (0, 1, 0)),
    "barrel": co.Ellipsoid((1, 1.5, 2), (0.5, 0, 1), (-1.2, 0.3)),
    "box": co.Box((0, 1, 2), (1, 3, 5)),
    "cylinder": co.Cylinder((0, 0, 0), (1, 2, 2), 0.5),
    "wedge": co.Cylinder((0, 0, 0), (1, 2, 2), 0.5, 30, 100, (1, 0, 0)),
    "open pie": co.Cylinder((0, 0, 0), (0, 0, 2), 0.5, -40, 230, (1, 0, 0)),
    "cone": co.Cone((0, 0, 0), (1, 2, 2), 1, 0),
    "frustum": co.Cone((0, 0, 0), (1, 2, 2), 0.25, 1),
    "bow tie": co.DoubleCone(2, (-1, 0.5)),
    "dish": co.EllipticParaboloid(1, 3, (0.5, 2)),
    "cup": co.EllipticParaboloid(1, 3, (-math.inf, 2)),
    "cooling tower": co.OneSheetHyperboloid(1, 2, 3, (-0.2, 1)),
    "two bowls": co.TwoSheetHyperboloid(1, 2, 3, (-1, 2)),
    "elliptic cone": co.EllipticCone(1, 2, 3, (-1, 0.5)),
    "elliptic cylinder": co.EllipticCylinder(1, 4, (-1, 2)),
}
SHEAR = [[1, 0.4, 0, 1], [-0.3, 1, 0.2, 0], [0, 0.5, 0.8, -2], [0, 0, 0, 1]]
MOTIONS = {
    "still": lambda shape: shape,
    "askew": askew,
    "mirrored": lambda shape: shape.scale((-1, 1, 1)).scale(2),
    "sheared": lambda shape: shape.transform(SHEAR),
}


@pytest.mark.parametrize(("name", "motion"), in_turn(PRIMITIVES, MOTIONS))
def test_closed_forms_agree_with_rays(name: str, motion: str):
    shape = MOTIONS[motion](PRIMITIVES[name])
    closed, sampled = co.measure(shape, rays=600), co.measure(shape | shape, rays=size(8000, 20_000))
    assert closed.volume_error == 0
    assert not closed.centroid_error.any()
    assert not closed.inertia_error.any()
    assert closed.volume == pytest.approx(sampled.volume, abs=5 * sampled.volume_error)
    assert closed.area == pytest.approx(sampled.area, abs=5 * math.hypot(sampled.area_error, closed.area_error))
    assert (np.abs(closed.centroid - sampled.centroid) <= 5 * sampled.centroid_error).all()
    assert (np.abs(closed.inertia - sampled.inertia) <= 5 * sampled.inertia_error).all()


def test_areas_have_closed_forms_under_similarities():
    for name in ("sphere", "box", "cylinder", "wedge", "cone", "frustum"):
        for motion in ("still", "askew", "mirrored"):
            found = co.measure(MOTIONS[motion](PRIMITIVES[name]))
            assert (found.area_error, found.rays) == (0, 0)
    assert co.measure(co.Box().transform(SHEAR)).rays == 0
    assert co.measure(co.Sphere().scale((1, 2, 3)), rays=600).area_error > 0


def test_formulas():
    ball = co.measure(co.Sphere(2, (1, 0, 0)).scale(3).rotate((0, 0, 1), 90))
    assert ball.volume == pytest.approx(4 / 3 * PI * 216, rel=1e-15)
    assert ball.area == pytest.approx(4 * PI * 36, rel=1e-15)
    assert ball.centroid == pytest.approx((0, 3, 0), abs=1e-15)
    assert ball.inertia == pytest.approx(np.eye(3) * ball.volume * 2 / 5 * 36, rel=1e-14, abs=1e-11)
    box = co.measure(co.Box((0, 0, 0), (1, 2, 3)))
    assert (box.volume, box.area) == (6, 22)
    assert box.inertia == pytest.approx(np.diag([6 / 12 * 13, 6 / 12 * 10, 6 / 12 * 5]))
    tilted = co.measure(co.Cylinder((0, 0, 0), (0, 0, 2), 0.5).rotate((1, 0, 0), 90))
    mass = PI / 2
    assert tilted.centroid == pytest.approx((0, -1, 0))
    assert np.diag(tilted.inertia) == pytest.approx((mass * (3 / 4 + 4) / 12, mass / 8, mass * (3 / 4 + 4) / 12))
    ellipsoid = co.measure(co.Ellipsoid((1, 2, 3)), rays=600)
    assert ellipsoid.volume == pytest.approx(8 * PI, rel=1e-14)
    assert np.diag(ellipsoid.inertia) == pytest.approx(8 * PI / 5 * np.array([13, 10, 5]))


def test_what_is_alone_in_a_combination_keeps_its_closed_form():
    box = co.Box().translate((1, 0, 0))
    for shape in (co.Union((box,)), co.Intersection((co.Union((box,)),)), box.painted(co.mirror())):
        found = co.measure(shape.rotate((0, 0, 1), 90))
        assert (found.volume, found.rays) == (8, 0)
        assert found.centroid == pytest.approx((0, 1, 0))


def test_sheets():
    assert co.measure(co.Disc((1, 2, 3), (1, 1, 1), 2)).area == pytest.approx(4 * PI)
    assert co.measure(co.Disc((0, 0, 0), (0, 0, 1), 1).scale((2, 3, 5))).area == pytest.approx(6 * PI)
    assert co.measure(co.Triangle((0, 0, 0), (2, 0, 0), (0, 3, 0)).rotate((1, 2, 3), 20)).area == pytest.approx(3)
    patch = co.measure(co.CylinderPatch((0, 0, 0), (0, 0, 2), 1.5, 0, 90, (1, 0, 0)))
    assert (patch.area, patch.area_error, patch.volume) == (pytest.approx(1.5 * PI), 0, 0)


@pytest.mark.parametrize(
    "shape",
    [
        co.Sphere() - co.Sphere(),
        co.Sphere() & co.Sphere(1, (5, 0, 0)),
        co.TwoSheetHyperboloid(1, 1, 1) & co.Box((-9, -9, -0.5), (9, 9, 0.5)),
        co.Polyhedron([(1, 0, 0), (-1, 0, 0)], [0, -1]),
        co.Sphere(1) - co.Box((-2, -2, -2), (2, 2, 2)),
        co.Spheres([], 1),
    ],
    ids=lambda shape: type(shape).__name__,
)
def test_empty_solids_measure_nothing(shape: co.Shape):
    found = co.measure(shape, rays=6000)
    assert found.volume == found.area == found.volume_error == found.area_error == 0
    assert not found.inertia.any()
    assert np.isnan(found.centroid).all()


def test_unbounded_shapes_are_refused_by_axis():
    with pytest.raises(ValueError, match=r"measure: EllipticCylinder must be bounded, .* infinite along z"):
        co.measure(co.EllipticCylinder(1, 1))
    with pytest.raises(ValueError, match="infinite along x, y, z"):
        co.measure(~co.Sphere())
    with pytest.raises(ValueError, match="infinite along x, y"):
        co.measure(co.Plane((0, 0, 1), 0))


@pytest.mark.parametrize("rays", [0, -5, 59, 1e6 + 0.5, True, "many"])
def test_rays_are_a_number(rays: object):
    with pytest.raises(ValueError, match="measure: rays must be an integer >= 60"):
        co.measure(co.Sphere(), rays=rays)


def test_rays_are_not_without_end():
    with pytest.raises(ValueError, match="measure: rays must be an integer <= 1,000,000,000,000, got 1000000000001"):
        co.measure(co.Sphere(), rays=10**12 + 1)


def test_other_refusals():
    with pytest.raises(ValueError, match="measure: seed must be an integer >= 0, got -1"):
        co.measure(co.Sphere(), seed=-1)
    with pytest.raises(TypeError, match="measure: shape must be a shape or a Body, got list"):
        co.measure([co.Sphere()])


def test_answers():
    shape = co.Sphere() - co.Box((0, 0, 0), (2, 2, 2))
    calls: list[tuple[int, int]] = []
    found = co.measure(
        co.Body(shape, name="seven eighths"), rays=30_000, progress=lambda done, total: calls.append((done, total))
    )
    assert "volume" in str(found)
    assert "±" in str(found)
    assert calls[-1] == (30_000, 30_000)
    assert all(a[0] <= b[0] for a, b in itertools.pairwise(calls))
    assert not found.centroid.flags.writeable
    with pytest.raises(AttributeError):
        found.volume = 1.0
    assert replace(found, volume=2.0).volume == 2
