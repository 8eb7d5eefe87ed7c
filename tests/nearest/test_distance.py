"""How far points are from walls, where that is known on paper."""

from __future__ import annotations

import concurrent.futures
import math
import pickle
from decimal import Decimal, localcontext
from itertools import pairwise

import numpy as np
import pytest

import conicoid as co

ROOT3 = math.sqrt(3)


def exact(shape, point, **more):
    return co.Scene([shape]).distance(point, exact=True, **more)


def wedges(sides, angle):
    """A ring of sectors with conical walls, as a polyhedra of GDML is: all their flat walls meet on the z axis."""
    turns = np.radians(np.linspace(0, angle, sides + 1))
    parts = []
    for a, b in pairwise(turns):
        middle = ((np.cos(a) + np.cos(b)) / 2, (np.sin(a) + np.sin(b)) / 2)
        x, y = np.array(middle) / np.hypot(*middle)
        normals = [
            (0, 0, -1), (0, 0, 1), (np.sin(a), -np.cos(a), 0), (-np.sin(b), np.cos(b), 0), (x, y, -0.5), (-x, -y, 0.25)
        ]  # fmt: skip
        parts.append(co.Polyhedron(normals, (2, 0, 0, 0, 4, -1.5)))
    return co.Union(parts)


def sector(start, end):
    return co.Cylinder((0, 0, -1), (0, 0, 1), 1, start, end, (1, 0, 0))


WEDGES = wedges(12, 90)


def test_the_sign_is_negative_inside():
    scene = co.Scene([co.Sphere(2), co.Box((5, -1, -1), (7, 1, 1))])
    found = scene.distance([(0.5, 0, 0), (3, 0, 0), (6, 0, 0.75)], exact=True)
    assert found.distance == pytest.approx([-1.5, 1, -0.25], rel=1e-15)
    assert found.body.tolist() == [0, 0, 1]
    assert scene.distance([(0.5, 0, 0), (3, 0, 0), (6, 0, 0.75)]).distance == pytest.approx([-1.5, 1, -0.25], rel=1e-12)


def test_bounds_of_planes_balls_and_cylinders_are_the_distance():
    drum = co.Cylinder((0, 0, -9), (0, 0, 9), 1)
    for shape, point, away in (
        (co.HalfSpace((0, 3, 4), 5), (7, 3, 4), 4),
        (co.Sphere(1), (0, 3, 4), 4),
        (drum, (0.5, 0, 1), -0.5),
    ):
        found = co.Scene([shape]).distance(point)
        assert found.distance == pytest.approx(away, rel=1e-12)
        assert 0 < found.lower <= abs(away)
        assert found.error == math.inf
        assert found.body == -1
        assert np.isnan(found.point).all()
        assert np.isnan(found.normal).all()


def test_faces_edges_and_corners_of_a_box():
    box = co.Box((-1, -1, -1), (1, 1, 1))
    found = exact(box, [(3, 0, 0), (2, 2, 0), (2, 2, 2), (0.25, 0, 0)])
    assert found.distance == pytest.approx([2, math.sqrt(2), ROOT3, -0.75], rel=1e-15)
    assert found.point == pytest.approx(np.array([(1, 0, 0), (1, 1, 0), (1, 1, 1), (1, 0, 0)]), abs=1e-15)
    assert found.normal[[0, 3]] == pytest.approx(np.array([(1, 0, 0)] * 2))
    assert (found.error < 1e-14).all()


def test_medial_axes():
    # All around an axis, and all over a center, walls are as near; one of the points is told.
    tube = exact(co.Cylinder((0, 0, -9), (0, 0, 9), 2), (0, 0, 1))
    assert tube.distance == pytest.approx(-2, rel=1e-15)
    assert np.hypot(*tube.point[:2]) == pytest.approx(2, rel=1e-15)
    assert tube.point[2] == pytest.approx(1, abs=1e-14)
    ball = exact(co.Sphere(2, (1, 2, 3)), (1, 2, 3))
    assert ball.distance == pytest.approx(-2, rel=1e-15)
    # An ellipse inside of its evolute: (3, 0) with the half axes 5 and 3 has x = a² 3 / (a² - b²), |y| < b.
    egg = exact(co.Ellipsoid((5, 3, 3)), (1, 0, 0))
    x = 25 * 1 / (25 - 9)
    assert egg.distance == pytest.approx(-math.hypot(x - 1, 3 * math.sqrt(1 - x * x / 25)), rel=1e-14)


def test_the_apex_of_a_cone():
    cone = co.Cone((0, 0, 0), (0, 0, 2), 1, 0)
    found = exact(cone, [(0, 0, 5), (0.5, 0.25, 5)])
    assert found.distance == pytest.approx([3, math.sqrt(0.25 + 0.0625 + 9)], rel=1e-15)
    assert (found.error < 1e-13).all()


def test_an_edge_where_two_pipes_of_different_width_meet():
    # y² + z² = r², x² + z² = s². Seen from (0, 4, 2) the wall would be nearest at z = 2 / sqrt(20) r < s, in the hole;
    # so it is the hole's edge, at x = 0, z = s.
    r, s = 1.0, 0.5
    crossing = co.Cylinder((-3, 0, 0), (3, 0, 0), r) - co.Cylinder((0, -3, 0), (0, 3, 0), s)
    found = exact(crossing, (0, 4, 2))
    edge = math.hypot(4 - math.sqrt(r * r - s * s), 2 - s)
    assert found.distance == pytest.approx(edge, rel=1e-14)
    inside = exact(crossing, (0, 1.5, 0))
    # From the axis of the hole its edge is nearest where y is largest: at z = 0, x = s, y = r.
    assert inside.distance == pytest.approx(math.hypot(s, 1.5 - r), rel=1e-14)
    assert inside.error < 1e-12


def test_flush_walls_are_no_walls_within():
    # Two boxes with a wall in common are one body; so is what fills a bite to the wall.
    joined = co.Box((-1, -1, -1), (0, 1, 1)) | co.Box((0, -1, -1), (1, 1, 1))
    assert exact(joined, (0.125, 0, 0)).distance == pytest.approx(-0.875, rel=1e-15)
    apart = co.Scene([co.Box((-1, -1, -1), (0, 1, 1)), co.Box((0, -1, -1), (1, 1, 1))])  # two bodies have two walls
    assert apart.distance((0.125, 0, 0), exact=True).distance == pytest.approx(-0.125, rel=1e-15)
    nothing = co.Box((0, 0, 0), (1, 1, 1)) - co.Box((0, 0, 0), (1, 1, 1))
    assert exact(nothing, (0.5, 0.5, 0.5)).distance == math.inf


def test_sheets_have_no_inside():
    ring = co.Disc((0, 0, 0), (0, 0, 1), 2) - co.Cylinder((0, 0, -1), (0, 0, 1), 1)
    found = exact(ring, [(0, 0, 1), (1.5, 0, 1), (3, 0, 1), (0.5, 0, 0)])
    assert found.distance == pytest.approx([math.sqrt(2), 1, math.sqrt(2), 0.5], rel=1e-14)
    patch = co.CylinderPatch((0, 0, 0), (0, 0, 2), 1, 0, 90, (1, 0, 0))
    assert exact(patch, (-1, 0, 1)).distance == pytest.approx(math.sqrt(2), rel=1e-14)
    triangle = co.Triangle((0, 0, 0), (1, 0, 0), (0, 1, 0))
    assert exact(triangle, [(0.25, 0.25, -2), (1, 1, 0), (-3, -4, 0)]).distance == pytest.approx([2, math.sqrt(0.5), 5])
    window = co.Polygon([(0, 0, 0), (4, 0, 0), (4, 4, 0), (0, 4, 0)]) - co.Sphere(1, (2, 2, 0))
    assert exact(window, [(2, 2, 0), (2, 2.5, 1), (5, 5, 0)]).distance == pytest.approx(
        [1, math.hypot(0.5, 1), math.sqrt(2)]
    )


def test_many_bodies():
    rng = np.random.default_rng(3)
    centers, radii = rng.uniform(-9, 9, (500, 3)), rng.uniform(0.1, 0.5, 500)
    x = rng.uniform(-12, 12, (200, 3))
    away = np.abs(np.linalg.norm(x[:, None] - centers[None], axis=2) - radii)
    for entries in ([co.Spheres(centers, radii)], [co.Sphere(r, c) for r, c in zip(radii, centers, strict=True)]):
        found = co.Scene(entries).distance(x, exact=True)
        assert np.abs(found.distance) == pytest.approx(away.min(axis=1), rel=1e-13)
        assert np.array_equal(found.body, away.argmin(axis=1))
    assert np.abs(co.Scene(entries).distance(x).distance) == pytest.approx(away.min(axis=1), rel=1e-11)


def test_a_body_of_many_parts():
    rng = np.random.default_rng(4)
    centers = rng.uniform(-5, 5, (60, 3))
    cheese = co.Box((-5, -5, -5), (5, 5, 5)) - co.Union([co.Sphere(0.75, c) for c in centers])
    x = rng.uniform(-4, 4, (60, 3))
    found = exact(cheese, x)
    # A wall is on a ball, at its distance or farther, where others have cut it
    balls = np.abs(np.linalg.norm(x[:, None] - centers[None], axis=2) - 0.75).min(axis=1)
    assert (np.abs(found.distance) >= np.minimum(balls, (5 - np.abs(x)).min(axis=1)) - 1e-13).all()
    on_ball = np.abs(np.linalg.norm(found.point[:, None] - centers[None], axis=2) - 0.75).min(axis=1) < 1e-12
    assert (on_ball | (np.abs(np.abs(found.point).max(axis=1) - 5) < 1e-12)).all()
    assert (np.linalg.norm(found.point[:, None] - centers[None], axis=2).min(axis=1) > 0.75 - 1e-12).all()


def test_no_wall_and_none_within_reach():
    empty = co.Scene([]).distance([(0, 0, 0), (1, 2, 3)], exact=True)
    assert empty.distance.tolist() == [math.inf] * 2
    assert empty.error.tolist() == [0, 0]
    assert empty.body.tolist() == [-1] * 2
    scene = co.Scene([co.Sphere(1)])
    for more in ({}, {"exact": True}):
        found = scene.distance([(5, 0, 0), (1.5, 0, 0), (0, 0, 0)], max_distance=0.75, **more)
        assert found.distance == pytest.approx([math.inf, 0.5, -math.inf])
        assert found.lower == pytest.approx([0.75, 0.5, 0.75])
    assert np.isnan(found.point[0]).all()
    assert scene.distance([(3, 0, 0)] * 2, max_distance=[1, 4]).distance == pytest.approx([math.inf, 2])


def test_ties_go_to_the_body_listed_first():
    for order in (1, -1):
        scene = co.Scene([co.Sphere(1, (2, 0, 0)), co.Sphere(1, (-2, 0, 0)), co.Sphere(1, (0, 2, 0))][::order])
        assert scene.distance((0, 0, 0), exact=True).body == 0


def test_far_points():
    for away in (1e3, 1e6, 1e9):
        found = exact(co.Ellipsoid((1, 2, 3)), (0, 0, away))
        assert abs(found.distance - (away - 3)) <= found.error <= 1e-12 * away


def test_shapes_of_arrays_and_refusals():
    scene = co.Scene([co.Sphere(1)])
    assert scene.distance((2, 0, 0)).distance == pytest.approx(1)
    found = scene.distance(np.ones((2, 3, 3)), exact=True)
    assert found.shape == (2, 3)
    assert found.normal.shape == (2, 3, 3)
    assert found[1].shape == (3,)
    assert found.size == 6
    assert found[0, 0].distance == found.distance[0, 0]
    assert len(found) == 2
    assert [one.shape for one in found] == [(3,), (3,)]
    with pytest.raises(ValueError, match=r"distance: points\[1\] must be finite"):
        scene.distance([(0, 0, 0), (math.nan, 0, 0)])
    with pytest.raises(ValueError, match="max_distance must be positive, got -1.0"):
        scene.distance((0, 0, 0), max_distance=-1)
    with pytest.raises(ValueError, match="max_distance must be a positive number"):
        scene.distance((0, 0, 0), max_distance="far")
    with pytest.raises(AttributeError, match="read-only"):
        found.distance = 1


def test_answers_live_without_the_scene():
    scene = co.Scene([co.Body(co.Sphere(1), name="ball"), co.Box((3, -1, -1), (4, 1, 1))])
    found = scene.distance([(2, 0, 0), (2.5, 0, 0)], exact=True)
    again = pickle.loads(pickle.dumps(found))
    assert again == found
    assert again.name.tolist() == ["ball", None]
    assert np.array_equal(again[1].normal, found.normal[1])
    assert co.Distances.concatenate([found, found[0]]).distance.tolist() == [*found.distance, found.distance[0]]
    assert co.Distances.concatenate([again, found]) == co.Distances.concatenate([found, found]).detached()
    with pytest.raises(ValueError, match="parts must be of one scene"):
        co.Distances.concatenate([again, co.Scene([co.Sphere(3)]).distance((0, 0, 0), exact=True)])
    assert repr(found[0]).startswith("Distances(body 0 'ball', distance=1.0, error=")


def test_workers_and_progress():
    scene = co.Scene([co.Sphere(1) - co.Cylinder((0, 0, -2), (0, 0, 2), 0.5)])
    x = np.random.default_rng(0).uniform(-2, 2, (1000, 3))
    told = []
    found = scene.distance(x, exact=True, progress=lambda done, count: told.append((done, count)))
    assert told[-1] == (1000, 1000)
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        assert scene.distance(x, exact=True, executor=pool) == found
        assert scene.distance(x, executor=pool) == scene.distance(x)


@pytest.mark.parametrize(
    "shape",
    [
        co.Box().rotate("z", 45), co.RegularPrism(6, 3, (-2, 2)).rotate("x", 20), co.RegularPrism(12, 3, (-2, 2)),
        co.Box().rotate((1, 2, 3), 40) - co.Box().scale(0.7).rotate("z", 20),
        co.Cone((0, 0, -1), (0, 0, 2), 2, 0.5) & co.HalfSpace((1, 0, 0.3), 0.4), WEDGES,
        sector(0, 30) | sector(90, 120), sector(0, 3) | sector(90, 97),
    ],
)  # fmt: skip
def test_corners_and_lines_of_many_planes_have_small_errors(shape):
    """A third plane along the line of two meets it nowhere, and a point of many planes need be no wall."""
    scene = co.Scene([shape])
    points = np.random.default_rng(4).uniform(-6, 6, (60, 3))
    found, bound = scene.distance(points, exact=True), scene.distance(points)
    assert (found.error < 1e-10).all()
    assert (found.lower >= bound.lower).all()
    assert (found.lower >= np.abs(found.distance) - 1e-10).all()


def rim_distance(x: np.ndarray, start: tuple, end: tuple, radius: float) -> float:
    """From a point outside to a round rod, in sixty digits."""
    with localcontext() as context:
        context.prec = 60
        p, a, b = ([Decimal(float(number)) for number in point] for point in (x, start, end))
        axis, away = [v - u for u, v in zip(a, b, strict=True)], [u - v for u, v in zip(p, a, strict=True)]
        length = sum(u * u for u in axis).sqrt()
        along = sum(u * v for u, v in zip(axis, away, strict=True)) / length
        beside = max(Decimal(0), sum(u * u for u in away) - along**2).sqrt() - Decimal(radius)
        beyond = max(-along, along - length)
        return float((max(beside, Decimal(0)) ** 2 + max(beyond, Decimal(0)) ** 2).sqrt())


@pytest.mark.parametrize("far", [1e6, 1e8, 1e12])
def test_points_far_from_rods_and_balls(far: float) -> None:
    """A far point's distance is known to the last digits: f and its terms are far larger than the radius there."""
    x = np.random.default_rng(3).normal(size=(60, 3)) * far
    rods = [((0, 0, 0), (0, 0, 1), 1.0), ((0, 0, 0), (1, 1, 0), 1.0), ((1, 2, 0), (2, 4, -2), 0.5)]
    known = [(co.Cylinder(*rod), [rim_distance(point, *rod) for point in x]) for rod in rods]
    known.append((co.Sphere(2.5, (0, -1.5, -2)), [math.dist(point, (0, -1.5, -2)) - 2.5 for point in x]))
    for solid, true in known:
        found, bound = co.Scene([solid]).distance(x, exact=True), co.Scene([solid]).distance(x)
        assert (found.error <= 1e-13 * far).mean() >= 0.9
        assert (np.abs(found.distance - true) <= found.error).all()
        assert (found.lower >= bound.lower).all()
        assert (found.error <= 1e-6 * far).all()
