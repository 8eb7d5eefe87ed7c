"""Distances from walls, by formulas and against force in extended precision; lower bounds; walks on spheres."""

import concurrent.futures
import importlib.util
import math
import pickle
from decimal import Decimal, localcontext
from itertools import combinations, pairwise
from pathlib import Path

import numpy as np
import pytest

import conicoid as co
from conicoid.queries import points as queries

from ..samples import deeper, sampled
from .bodies import BODIES, random_body
from .force import Walls
from .judge import faults

# --- Distances from walls that have a formula


def exact(shape, point, **more):
    return co.Scene([shape]).distance(point, exact=True, **more)


def wedges(sides, angle):
    """Return a ring of sectors with conical walls, as a polyhedra of GDML: all their flat walls meet on the z axis."""
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


HEIGHTS = np.array([0, 0.5, 1, 2, -3, 1e6])
BORED = co.Sphere(1.25) - co.Cylinder((0, 0, -2), (0, 0, 2), 0.75)
RIMS = np.hypot(0.75, np.maximum(np.abs(HEIGHTS) - 1, 0))
"""Distances of a ball of radius 5/4 with a bore of 3/4, from its axis: to the bore's wall, and beyond z = 1 and -1 to
its rims.
"""
EVOLUTE = 25 / (25 - 9)
"""Inside of the evolute of an ellipse with half axes a and b, (k, 0) has the nearest point x = a² k / (a² - b²), |y| <
b.
"""
BESIDE_APEX = (-4.378540478046168, -2.8881243932372227, 13.859126283743793)
"""The displacement to the apex, added to it, is the apex but for rounding."""
FAR_ABOVE = (57.2, 20.3, 946)

KNOWN = {  # a shape, points, and their distances from its walls
    "all around an axis": (co.Cylinder((0, 0, -9), (0, 0, 9), 2), (0, 0, 1), -2),
    "all over a center": (co.Sphere(2, (1, 2, 3)), (1, 2, 3), -2),
    "rims": (BORED, np.outer(HEIGHTS, (0, 0, 1)), RIMS),
    "rims at an angle": (BORED.rotate("x", 30), np.outer(HEIGHTS, (0, -0.5, math.sqrt(0.75))), RIMS),
    "within an evolute": (co.Ellipsoid((5, 3, 3)), (1, 0, 0), -math.hypot(EVOLUTE - 1, 3 * math.sqrt(1 - EVOLUTE**2 / 25))),
    "apex": (
        co.Cone((0, 0, 0), (0, 0, 2), 1, 0), [(0, 0, 5), (0.5, 0.25, 5), BESIDE_APEX],
        [3, math.sqrt(0.25 + 0.0625 + 9), math.dist(BESIDE_APEX, (0, 0, 2))],
    ),
    "flat apex": (
        co.Cone((0, 0, -0.19), (0, 0, 0), 2.9, 0).translate((1.41, 1.51, 1.27)), FAR_ABOVE,
        math.dist(FAR_ABOVE, (1.41, 1.51, 1.27)),
    ),
    "needle": (co.Cone((0, 0, -10), (0, 0, 0), 0.1, 0), [(0, 0, 1e-4), (0, 0, 2.5)], [1e-4, 2.5]),
    "pyramid": (co.Pyramid(9, 3), [(0.25, 0.5, 4), (-0.25, 0, 3)], [math.sqrt(0.3125 + 9), math.sqrt(0.0625 + 4)]),
    "flush parts have no wall within": (co.Box((-1, -1, -1), (0, 1, 1)) | co.Box((0, -1, -1), (1, 1, 1)), (0.125, 0, 0), -0.875),
    "nothing": (co.Box((0, 0, 0), (1, 1, 1)) - co.Box((0, 0, 0), (1, 1, 1)), (0.5, 0.5, 0.5), math.inf),
    "ring": (
        co.Disc((0, 0, 0), (0, 0, 1), 2) - co.Cylinder((0, 0, -1), (0, 0, 1), 1),
        [(0, 0, 1), (1.5, 0, 1), (3, 0, 1), (0.5, 0, 0)], [math.sqrt(2), 1, math.sqrt(2), 0.5],
    ),
    "patch": (co.CylinderPatch((0, 0, 0), (0, 0, 2), 1, 0, 90, (1, 0, 0)), (-1, 0, 1), math.sqrt(2)),
    "triangle": (
        co.Triangle((0, 0, 0), (1, 0, 0), (0, 1, 0)), [(0.25, 0.25, -2), (1, 1, 0), (-3, -4, 0)], [2, math.sqrt(0.5), 5],
    ),
    "window": (
        co.Polygon([(0, 0, 0), (4, 0, 0), (4, 4, 0), (0, 4, 0)]) - co.Sphere(1, (2, 2, 0)),
        [(2, 2, 0), (2, 2.5, 1), (5, 5, 0), (0, 0, 0)], [1, math.hypot(0.5, 1), math.sqrt(2), 0],
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", KNOWN)
def test_distances_on_paper(name):
    shape, points, away = KNOWN[name]
    found = exact(shape, points)
    assert found.distance == pytest.approx(away, rel=1e-15, abs=0)
    assert np.all(found.error <= 8e-13 * np.abs(found.distance) + 1e-14)


def test_the_edges_of_equal_pipes_that_cross():
    """The edges are ellipses in the planes between the axes, with half axes of 1 and 1 / sin(half the angle)."""
    axes, point, around = (
        np.array([(4, 0, 3), (2, 2, 3)]),
        np.array((2.0, 2, 3)),
        np.linspace(0, 2 * np.pi, 200_001)[:, None],
    )
    one, other = axes / np.linalg.norm(axes, axis=1)[:, None]
    across = np.cross(one, other)
    edges = [
        np.cos(around) * across / np.linalg.norm(across) + np.sin(around) * 2 * along / np.linalg.norm(away) / np.linalg.norm(along)
        for along, away in ((one + other, one - other), (one - other, one + other))
    ]  # fmt: skip
    found = exact(co.Cylinder(-2 * axes[0], 2 * axes[0], 1) & co.Cylinder(-2 * axes[1], 2 * axes[1], 1), point)
    assert found.distance == pytest.approx(np.linalg.norm(np.concatenate(edges) - point, axis=1).min(), abs=1e-8)
    assert found.error < 1e-11


def test_one_of_several_nearest_points_is_reported():
    tube = exact(co.Cylinder((0, 0, -9), (0, 0, 9), 2), (0, 0, 1))
    assert np.hypot(*tube.point[:2]) == pytest.approx(2, rel=1e-15)
    assert tube.point[2] == pytest.approx(1, abs=1e-14)


def test_bodies_that_touch_have_two_walls():
    apart = co.Scene([co.Box((-1, -1, -1), (0, 1, 1)), co.Box((0, -1, -1), (1, 1, 1))])
    assert apart.distance((0.125, 0, 0), exact=True).distance == -0.125


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


@pytest.mark.parametrize("order", [1, -1])
def test_ties_go_to_the_body_listed_first(order):
    scene = co.Scene([co.Sphere(1, (2, 0, 0)), co.Sphere(1, (-2, 0, 0)), co.Sphere(1, (0, 2, 0))][::order])
    assert scene.distance((0, 0, 0), exact=True).body == 0


def test_a_corner_of_many_surfaces_has_the_face_of_a_wall():
    """Near (0, 0, 1) the body is x <= 0, y >= 0, z <= 1, x - y - z <= -1. A part that only touches it adds x >= 0."""
    beside = co.Box((0, -2, -1), (3, 1, 0))
    body = (beside | co.HalfSpace((1, -1, -1), -1)) & co.Box((-1, 0, -1), (0, 3, 1))
    found = co.Scene([body]).distance((0, -2.75, 1), exact=True)
    assert (found.distance, found.point.tolist()) == (2.75, [0, 0, 1])
    walls = np.array([(1, 0, 0), (0, -1, 0), (0, 0, 1), np.array((1, -1, -1)) / 3**0.5])
    assert np.isclose(walls, found.normal).all(axis=1).any(), found.normal


def half(*normal, offset=0.0):
    return co.HalfSpace(normal, offset)


NOTHING = {  # each has no point inside: of some surfaces' sides none occurs that would hold the body
    "planes along a line": half(1, 0, 0) & half(0, 1, 0) & half(-1, -1, 0),
    "planes at a corner": half(1, 0, 0) & half(0, 1, 0) & half(0, 0, 1) & half(-1, -2, -3),
    "a plane that touches a ball": co.Sphere(1) & half(-3, -4, 0, offset=-5),
    "a plane along a rod": co.Cylinder((0, 0, -1), (0, 0, 1), 1) & half(-3, -4, 0, offset=-5),
    "planes past an apex": co.DoubleCone(1) & half(0, 0, 1) & half(-1, 0, -3),
}


@pytest.mark.parametrize("name", NOTHING)
@pytest.mark.parametrize("angle", [0, 30, 40])
def test_sides_that_no_point_has_make_no_wall(name, angle):
    """All surfaces pass through one point or line. Rounding alone would make walls there."""
    points, box = np.array([(0.1, 0.2, 0.3), (-1, 0.5, 0.25), (1, 3, 1)]), co.Box((2, 2, 2), (4, 4, 4))
    away = np.linalg.norm(np.maximum(np.maximum(2 - points, points - 4), 0), axis=1)
    cosine, sine = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    turned = points @ np.array([(cosine, sine, 0), (-sine, cosine, 0), (0, 0, 1)])
    for body, true in ((NOTHING[name], np.inf), (NOTHING[name] | box, away)):
        found = exact(body.rotate("z", angle) if angle else body, turned)
        assert found.distance == pytest.approx(true, rel=1e-14)
        assert (found.error < 1e-13).all()


def test_a_corner_is_found_on_the_line_in_which_two_planes_of_one_quadric_cross() -> None:
    """(y + z + 1/2) (y + z - 1/2 - x) <= 0 is a wedge for x <= -1, and a ball cuts its edge at (-1, -1, 1/2)."""
    rows = ((0, -0.5, -0.5, -0.25), (-0.5, 1, 1, 0), (-0.5, 1, 1, 0), (-0.25, 0, 0, -0.25))
    wedge = co.Quadric(rows) & co.HalfSpace((1, 0, 0), -1)
    found = co.Scene([wedge - co.Sphere(1, (-1, 0, 0.5))]).distance((-0.75, 0, 1.25), exact=True)
    assert found.distance == pytest.approx(math.sqrt(1.625), abs=1e-9)
    assert found.lower <= math.sqrt(1.625) <= found.distance + found.error


def test_an_edge_is_found_behind_a_wall_where_four_surfaces_touch():
    """The search looked only on the surfaces of the touch for walls of the curve's other points."""
    cone = co.Quadric(((-1, 0, 0, 0.5), (0, 1, 0, -0.5), (0, 0, 1, 0.5), (0.5, -0.5, 0.5, 0.25)))
    planes = co.Quadric(((0, 0, 0.5, 0.25), (0, 0, -0.5, -0.25), (0.5, -0.5, 0, 0), (0.25, -0.25, 0, 0)))
    body = co.Union((cone, co.HalfSpace((0, -2, 2), -2), planes, co.HalfSpace((0, 3, 4), -0.5)))
    found = exact(body, [(0, 0.5, -0.75)])
    # About (0.5, 0.5, -0.5) the outside is the cone x >= y, z >= y, 3 y + 4 z >= 0, and (-0.5, 0, -0.25) is the point:
    # the edge along (-4, -4, 3) is nearest, where its foot is 1.25 / sqrt(41) from the tip
    assert found.distance[0] == pytest.approx(-np.sqrt(0.3125 - 1.25**2 / 41), rel=1e-14)
    assert found.error[0] < 1e-13


@pytest.mark.parametrize("squares", [(2, 1, 2), (2**-21, 2, 2**23), (1, 1, 0), (1, 0, 0), (-2, -1, -2), (-1, 0, 0)])
@pytest.mark.parametrize("center", [(0, 0, 0), (1, 3, -2)])
def test_quadrics_that_are_a_point_a_line_or_a_plane_have_no_wall(squares, center):
    """No ray crosses these quadrics: the body is only these points, or lacks only these."""
    w, c = np.diag(squares).astype(float), np.array(center, float)
    thin = co.Quadric(np.block([[w, -(w @ c)[:, None]], [-(w @ c), c @ w @ c]]))
    points, box = np.array([(0.1, 0.2, 0.3), (1, 3, -2), (0, 0, 0), (-1, 2, 7)]), co.Box((2, 2, 2), (4, 4, 4))
    away = np.linalg.norm(np.maximum(np.maximum(2 - points, points - 4), 0), axis=1)
    is_all = max(squares) <= 0
    for shape, true in (
        (thin, np.inf),
        (box & thin, away if is_all else np.inf),
        (box - thin, np.inf if is_all else away),
    ):
        found = exact(shape, points)
        assert np.abs(found.distance) == pytest.approx(true, rel=1e-14)
        assert (found.error < 1e-13).all()
        assert (co.Scene([shape]).distance(points).lower <= found.lower).all()


@pytest.mark.parametrize("sides", [(-1, 1, -1, 1), (1, 1, 1, -1), (1, -1, 1, -1), (1, 1, -1, -1)])
@pytest.mark.parametrize("tip", [(0, 0, 0), (0.25, -0.25, 0.25)])
def test_slender_tips_of_four_planes_are_proved(sides, tip):
    """Straight ahead of the tip nothing is nearer. Between the four planes no point a step away is inside."""
    normals = np.array(sides)[:, None] * np.array([(1, 0, -2), (2, 1, 1), (0, 0, 1), (1, 1, 0)])
    rays = [
        d for a, b in combinations(normals, 2) for d in (np.cross(a, b), np.cross(b, a)) if (normals @ d <= 0).all()
    ]
    ahead = np.sum([d / np.linalg.norm(d) for d in rays], axis=0)
    assert all(ahead @ d > 0 for d in rays)
    body = co.Box(np.add(tip, -5), np.add(tip, 5))
    for n in normals:
        body &= half(*n, offset=n @ tip)
    found = exact(body, tip - np.outer((0.5, 1, 3), ahead))
    assert found.distance == pytest.approx(np.linalg.norm(ahead) * np.array((0.5, 1, 3)), rel=1e-14)
    assert (found.error < 1e-13).all()
    walls = [n / np.linalg.norm(n) for n in normals if sum(n @ d == 0 for d in rays) > 1]
    assert all(np.isclose(walls, n).all(axis=1).any() for n in found.normal)


@pytest.mark.parametrize("away", [1e3, 1e6, 1e9])
def test_far_points(away):
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
    for call, message in (
        (lambda: scene.distance([(0, 0, 0), (math.nan, 0, 0)]), r"distance: points\[1\] must be finite"),
        (lambda: scene.distance((0, 0, 0), max_distance=-1), "max_distance must be positive, got -1.0"),
        (lambda: scene.distance((0, 0, 0), max_distance="far"), "max_distance must be a positive number"),
    ):
        with pytest.raises(ValueError, match=message):
            call()
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
    calls = []
    found = scene.distance(x, exact=True, progress=lambda done, count: calls.append((done, count)))
    assert calls[-1] == (1000, 1000)
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
    """A third plane along the line of two meets it nowhere, and a point of many planes need not be a wall."""
    scene = co.Scene([shape])
    points = np.random.default_rng(4).uniform(-6, 6, (60, 3))
    found, bound = scene.distance(points, exact=True), scene.distance(points)
    assert (found.error < 1e-10).all()
    assert (found.lower >= bound.lower).all()
    assert (found.lower >= np.abs(found.distance) - 1e-10).all()


def test_a_tip_of_many_planes_is_proved_once():
    """The tip is the corner of each three of 73 planes. A proof for each of them took some ten seconds a point."""
    parts = []
    for a, b in pairwise(np.radians(np.linspace(0, 120, 25))):
        x, y = np.cos((a + b) / 2), np.sin((a + b) / 2)
        normals = [(0, 0, 1), (np.sin(a), -np.cos(a), 0), (-np.sin(b), np.cos(b), 0), (x, y, -1), (-x, -y, 0)]
        parts.append(co.Polyhedron(normals, (2, 0, 0, 0, 0)))
    points = np.array([(0.3, 0.4, -1.2), (-1, 0.5, -3), (0, 0, -1e-3)])  # the tip is nearest to all below 45 degrees
    found = exact(co.Union(parts), points)
    assert found.distance == pytest.approx(np.linalg.norm(points, axis=1), abs=1e-10)
    assert (found.error < 1e-9).all()


def rim_distance(x: np.ndarray, start: tuple, end: tuple, radius: float) -> float:
    """Return the distance of a point outside to a round rod, in sixty digits."""
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
    """A far point's distance is exact to the last digits, though f and its terms are far larger than the radius."""
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


def slender_cone_distance(x: float | Decimal, z: float, slope: float) -> Decimal:
    """Return the distance of (x, 0, z) to the generator x = -slope z, -10 <= z <= 0, of a cone."""
    with localcontext() as context:
        context.prec = 60
        u, v, m = Decimal(x), Decimal(z), Decimal(10 * slope) / 10
        foot = min(max((v - u * m) / (1 + m * m), Decimal(-10)), Decimal(0))
        return ((u + m * foot) ** 2 + (v - foot) ** 2).sqrt()


def assert_certified(solid: co.Shape, points: list, true: list[Decimal], within: float) -> None:
    """Assert that intervals and lower bounds are right to the last bit, and errors small."""
    found, bound = co.Scene([solid]).distance(points, exact=True), co.Scene([solid]).distance(points)
    for i in range(len(points)):
        distance, error = Decimal(abs(float(found.distance[i]))), Decimal(float(found.error[i]))
        assert distance - error <= true[i] <= distance + error
        assert bound.lower[i] <= found.lower[i] <= true[i]
        assert error <= Decimal(within) * true[i] + Decimal(1e-14 * max(map(abs, points[i]))), points[i]


@pytest.mark.parametrize("slope", [1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7])
@pytest.mark.parametrize("x", [1e-3, 1.0, 10.0])
def test_points_beside_slender_cones(slope: float, x: float) -> None:
    """About the height of the apex f hardly changes along the secular equation. Rounding of its terms moved the root."""
    heights = [0.0, slope / 2, -slope / 2, 2 * slope, -2 * slope, 1e-9, -1e-9, -5.0]
    solid, points = co.Cone((0, 0, -10), (0, 0, 0), 10 * slope, 0), [(x, 0.0, z) for z in heights]
    assert_certified(solid, points, [slender_cone_distance(x, z, slope) for z in heights], 1e-12)


@pytest.mark.parametrize(
    ("slope", "within"), [(1e3, 1e-12), (1e5, 1e-12), (1e6, 1e-12), (1e7, 1e-12), (1e8, math.inf), (1e9, math.inf)]
)
def test_points_near_and_far_from_flat_cones(slope: float, within: float) -> None:
    """The plane of the base is less exact near a far point than the cone is high."""
    size = 10.0 ** np.arange(19).repeat(10)[:, None]
    points = (np.abs(np.random.default_rng(5).normal(size=(190, 3))) * size).tolist()
    with localcontext() as context:
        context.prec = 60
        true = [slender_cone_distance((Decimal(x) ** 2 + Decimal(y) ** 2).sqrt(), z, slope) for x, y, z in points]
    assert_certified(co.Cone((0, 0, -10), (0, 0, 0), 10 * slope, 0), points, true, within)


@pytest.mark.parametrize("thin", [1e-7, 1e-8, 1e-9])
def test_points_beyond_rims_of_flat_sheared_ellipsoids(thin: float) -> None:
    """The rim is an ellipse in the plane x = 3 y.

    A vertex is nearest to points on its axes, of 1.25 √10 and of 1 along z.
    """
    disc = co.Ellipsoid((thin, 1.25, 1)).transform([[1, 3, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
    points = [(0, 0, 3), (0, 0, -1.5), (6, 2, 0), (9, 3, 0), (-9, -3, 0)]
    true = np.array([2, 0.5, 0.75 * 10**0.5, 1.75 * 10**0.5, 1.75 * 10**0.5])
    found, bound = co.Scene([disc]).distance(points, exact=True), co.Scene([disc]).distance(points)
    assert (bound.lower > true - 1e-9).all()
    assert (bound.lower <= found.lower).all()
    assert (found.lower <= true).all()
    assert (found.distance + found.error >= true * (1 - 1e-12)).all()


@pytest.mark.parametrize("radius", [1e2, 1e4, 1e6, 1e7, 1e8])
def test_corners_of_cut_flat_cones(radius: float) -> None:
    """The body is convex. A corner in the plane z = -1 is nearest to points along a sum of the normals there."""
    solid = co.Cone((0, 0, -1), (0, 0, 0), radius, 0) & co.HalfSpace((1, 0, 0), radius / 4)
    points = [(radius / 4 + 2 * t, 3 * t + radius, -1 - t) for t in (radius * 10.0**k for k in range(-1, 9))]
    with localcontext() as context:
        context.prec, r = 60, Decimal(radius)
        corner = (r / 4, r * Decimal(15).sqrt() / 4, Decimal(-1))
        squares = [sum((Decimal(u) - v) ** 2 for u, v in zip(x, corner, strict=True)) for x in points]
        assert_certified(solid, points, [square.sqrt() for square in squares], 1e-10 if radius < 1e6 else math.inf)


@pytest.mark.parametrize("away", [1e-3, 1.0, 1e3, 1e5, 1e8])
@pytest.mark.parametrize(
    ("solid", "squares", "line"),
    [
        (co.Ellipsoid((1000, 1, 0.01)), (1e3, 1.0, 0.01), 0), (co.Ellipsoid((1, 1, 1e-3)), (1.0, 1.0, 1e-3), 0),
        (co.Ellipsoid((1e-3, 1e-3, 1)), (1e-3, 1e-3, 1.0), 0), (co.Ellipsoid((1, 2, 0.5)), (1.0, 2.0, 0.5), 0),
        (co.EllipticParaboloid(1, 2), (1, 2, 0), -1), (co.EllipticParaboloid(1e4, 1e-2), (1e4, 1e-2, 0), -1),
    ],
)  # fmt: skip
def test_points_above_a_point_of_a_convex_quadric(solid: co.Shape, squares: tuple, line: int, away: float) -> None:
    """The point is up the normal of a point of sum a p² + line z = 1 or 0.

    Its distance is exact but for the point's rounding.
    """
    rng, points, true = np.random.default_rng(9), [], []
    with localcontext() as context:
        context.prec = 60
        for _ in range(40):
            if line:
                a = [Decimal(s) for s in squares]
                p = [Decimal(float(u)) for u in rng.normal(size=2)]
                p.append(a[0] * p[0] ** 2 + a[1] * p[1] ** 2)
            else:
                u = [Decimal(float(k)) for k in rng.normal(size=3)]
                length, a = sum(k * k for k in u).sqrt(), [1 / Decimal(s) ** 2 for s in squares]
                p = [Decimal(s) * k / length for s, k in zip(squares, u, strict=True)]
            normal = [2 * k * v for k, v in zip(a, p, strict=True)]
            normal[2] += line
            length = sum(k * k for k in normal).sqrt()
            normal = [k / length for k in normal]
            exactly = [k + Decimal(away) * n for k, n in zip(p, normal, strict=True)]
            points.append(tuple(map(float, exactly)))
            moved = [Decimal(k) - e for k, e in zip(points[-1], exactly, strict=True)]
            true.append(Decimal(away) + sum(m * n for m, n in zip(moved, normal, strict=True)))
    assert_certified(solid, points, true, 1e-11)


# --- Lower bounds: in lanes as alone to the bit, whatever other results a call returns; never above the truth, and near
# it


def scene_of(names, seed=0, count=40):
    """Return a scene of copies of bodies, turned and moved."""
    rng = np.random.default_rng(seed)
    return co.Scene([
        BODIES[names[k % len(names)]][0].rotate(tuple(rng.normal(size=3)), float(rng.uniform(0, 360)))
        .translate(tuple(rng.uniform(-8, 8, 3)))
        for k in range(count)
    ])  # fmt: skip


EVERY = scene_of(list(BODIES))
SHEETS = co.Scene([
    co.Disc((0, 0, 0), (0, 0, 1), 2) - co.Cylinder((0, 0, -1), (0, 0, 1), 1),
    co.CylinderPatch((3, 0, 0), (3, 0, 2), 1, 0, 90, (1, 0, 0)), co.Triangle((5, 0, 0), (6, 0, 0), (5, 1, 0)),
    co.Polygon([(0, 5, 0), (4, 5, 0), (4, 9, 0), (0, 9, 0)]) - co.Sphere(1, (2, 7, 0)),
    co.HalfSpace((0, 0, 1), -9), co.Spheres(np.random.default_rng(2).uniform(-5, 5, (30, 3)), np.full(30, 0.3)),
])  # fmt: skip


def points_of(count, size=10.0, seed=1):
    return np.random.default_rng(seed).uniform(-size, size, (count, 3))


@pytest.mark.parametrize("scene", [EVERY, SHEETS], ids=["solids", "sheets"])
@pytest.mark.parametrize("size", [0.05, 1.0, 10.0, 1e3])
def test_neighbours_change_nothing(scene, size):
    x = points_of(200, size)
    together = scene.distance(x).lower
    assert [scene.distance(p).lower for p in x] == together.tolist()
    assert (scene.distance(x[::-1]).lower[::-1] == together).all()


def test_pictures_are_as_lists():
    x, y = np.meshgrid(np.linspace(-9, 9, 37), np.linspace(-9, 9, 29))
    points = np.stack([x, y, np.full_like(x, 0.25)], axis=-1)
    assert (EVERY.distance(points).lower.ravel() == EVERY.distance(points.reshape(-1, 3)).lower).all()


def test_many_entries_at_one_point():
    rng = np.random.default_rng(4)
    balls = co.Scene([co.Spheres(rng.uniform(-20, 20, (4000, 3)), rng.uniform(0.1, 0.3, 4000))])
    x = points_of(640, 20)  # no two in the same part of the scene
    assert [balls.distance(p).lower for p in x] == balls.distance(x).lower.tolist()
    same = np.repeat(x[:1], 100, axis=0)
    assert len(np.unique(balls.distance(same).lower)) == 1


@pytest.mark.parametrize("scene", [EVERY, SHEETS], ids=["solids", "sheets"])
def test_reach_is_each_points_own(scene):
    x = points_of(150)
    free = scene.distance(x).lower
    reach = np.random.default_rng(5).uniform(0.05, 4, 150)
    found = scene.distance(x, max_distance=reach)
    within = free <= reach
    assert within.any()
    assert not within.all()
    assert (found.lower == np.where(within, free, reach)).all()
    assert (np.isfinite(found.distance) == within).all()


@pytest.mark.parametrize("name", [name for name, (_, field) in BODIES.items() if len(field.surfaces()) == 1])
def test_of_one_face_it_is_the_distance(name):
    # As far as the exact distance is certain
    scene, x = co.Scene([BODIES[name][0]]), points_of(300, 3)
    exact, lower = scene.distance(x, exact=True), scene.distance(x).lower
    assert (lower <= np.abs(exact.distance) + exact.error).all()
    assert lower == pytest.approx(np.abs(exact.distance), rel=1e-10, abs=1e-13)


def test_special_points_of_quadrics():
    # On axes and in centers a root is a pole; beside the wall hardly anything is left of f
    cases = [
        (co.Ellipsoid((5, 3, 1)), (0, 0, 0), 1.0),
        (co.Ellipsoid((5, 3, 3)), (1, 0, 0), math.hypot(25 / 16 - 1, 3 * math.sqrt(1 - (25 / 16) ** 2 / 25))),
        (co.Cylinder((0, 0, -9), (0, 0, 9), 2), (0, 0, 1), 2.0),
        (co.Cylinder((0, 0, -9), (0, 0, 9), 2), (2 + 1e-9, 0, 1), 1e-9),
        (co.Ellipsoid((1, 2, 3)), (0, 0, 3 + 1e-12), 1e-12),
        (co.Ellipsoid((1, 2, 3)), (0, 0, 1e9), 1e9 - 3),
        (co.OneSheetHyperboloid(1, 1, 1, (-50, 50)), (0, 0, 0), 1.0),
    ]
    for shape, point, away in cases:
        for x in (point, np.tile(point, (64, 1))):  # alone and in lanes
            lower = np.max(co.Scene([shape]).distance(x).lower)
            slack = 2e-14 * (1 + np.abs(point).max())
            assert away - 1e-9 * away - slack <= lower <= away + 4e-16 * np.abs(point).max()


@pytest.mark.deep
@pytest.mark.parametrize("seed", range(40))
def test_many_bounds_in_lanes_and_alone(seed):
    rng = np.random.default_rng(seed)
    scene = co.Scene([random_body(rng)[0].translate(tuple(rng.uniform(-6, 6, 3))) for _ in range(30)])
    for size in (0.1, 2.0, 9.0, 100.0):
        x = points_of(2000, size, seed)
        lower, exact = scene.distance(x).lower, scene.distance(x[:300], exact=True)
        assert [scene.distance(p).lower for p in x[:300]] == lower[:300].tolist()
        assert (lower[:300] <= np.abs(exact.distance) + exact.error).all()


# --- Distances against force in extended precision, without common code


def test_force_finds_known_distances():
    # From the middle of an ellipsoid with the radii 1, 2 and 1/2 its wall is 1/2 away.
    least, point, sure = Walls(BODIES["ellipsoid"][1], np.random.default_rng(5)).nearest((0.0, 0.25, 0.125))
    assert sure
    assert BODIES["ellipsoid"][1](point) == pytest.approx(0, abs=1e-16)
    # A box: the nearest point of a corner's neighbourhood is the corner.
    least, point, _ = Walls(BODIES["box"][1], np.random.default_rng(5)).nearest((2.0, 1.5, 2.75))
    assert float(least) == pytest.approx(np.sqrt(1 + 1 + 4), rel=1e-15)
    assert point.astype(float) == pytest.approx((1, 0.5, 0.75), abs=1e-15)


def test_a_wrong_distance_is_found(monkeypatch):
    monkeypatch.setitem(BODIES, "ball", (BODIES["ball"][0].scale(1.0 + 2.0**-40), BODIES["ball"][1]))
    assert list(faults("ball", np.random.default_rng(0), 60, 10))


@pytest.mark.parametrize(
    ("name", "seed", "count", "forced"),
    [
        *((name, 11, 25, 1) for name in sampled(BODIES, 5) if isinstance(name, str)),
        *deeper((name, seed, 200, 8) for name in BODIES for seed in range(4)),
    ],
)
def test_distances_are_within_their_bounds(name, seed, count, forced):
    assert list(faults(name, np.random.default_rng(seed), count, forced)) == []


def random_faults(seed, count, forced):
    """Return the faults of a random body that is not empty."""
    rng = np.random.default_rng(seed)
    while True:
        try:
            return list(faults(f"random {seed}", rng, count, forced, random_body(rng), 0.5))
        except ValueError as error:
            if "empty" not in str(error):
                raise


@pytest.mark.parametrize(
    ("seed", "count", "forced"),
    [(1, 40, 1), *deeper([(2, 40, 2), (5, 40, 2)]), *deeper((seed, 100, 4) for seed in range(100, 300))],
)
def test_random_bodies(seed, count, forced):
    assert random_faults(seed, count, forced) == []


# --- Walks on spheres, the example of distances, against the closed form between two spheres


EXAMPLE = Path(__file__).parents[2] / "examples" / "walk_on_spheres.py"


@pytest.fixture
def example():
    spec = importlib.util.spec_from_file_location("walk_on_spheres", EXAMPLE)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_heat_between_two_spheres(example):
    hollow = co.Scene([co.Sphere(2) - co.Sphere(1)])
    points = np.array([(1.25, 0, 0), (0, 1.5, 0), (0, 0, -1.75), (1, 1, 0.5)])
    value, error = example.heat(hollow, points, lambda nearest: nearest.face == 1, 600)
    exactly = example.shell(1, 2, np.linalg.norm(points, axis=1))
    assert exactly[1] == pytest.approx((1 / 1.5 - 1 / 2) / (1 - 1 / 2))
    assert (error < 0.03).all()
    assert np.abs(value - exactly) == pytest.approx(np.zeros(4), abs=4 * error.max())


def test_neighbours_that_are_there_are_averaged(example):
    values = np.array([[1.0, 2.0, np.nan], [3.0, np.nan, np.nan]])
    expected = [[2.0, 2.0, np.nan], [2.0, np.nan, np.nan]]
    np.testing.assert_array_equal(example.smoothed(values), expected)


def test_sides_that_another_thread_learned_count(monkeypatch):
    """Another thread may learn sides between the search and its end. No error stays wide for that."""
    scene = co.Scene([NOTHING["planes along a line"] | co.Box((2, 2, 2), (4, 4, 4))])
    points = np.array([(0.1, 0.2, 0.3), (-1, 0.5, 0.25)])
    expected, known, first = scene.distance(points, exact=True), queries.known_sides, [np.zeros(1, np.int32)]
    monkeypatch.setattr(queries, "known_sides", lambda scene: first.pop() if first else known(scene))
    assert scene.distance(points, exact=True) == expected
    assert not first


def _to_segment(points, start, end):
    """Return the distances of points (n, 2) to a segment."""
    along = end - start
    share = np.clip((points - start) @ along / (along @ along), 0, 1)
    return np.linalg.norm(points - start - share[:, None] * along, axis=1)


@pytest.mark.parametrize("seed", [1, 7, 14, 20, 33, 37, 54])
def test_about_tips_of_moved_cones(seed):
    """Where the foot on a ruling is near the tip, the nearest point was the tip.

    The plane that touches the tip left it open.
    """
    rng = np.random.default_rng(seed)
    radius, height, axis = rng.uniform(0.1, 2), rng.uniform(0.3, 3), rng.normal(size=3)
    shift, degrees = rng.normal(size=3) * 10 ** rng.uniform(-1, 2), rng.uniform(0, 180)
    cone = co.Cone((0, 0, 0), (0, 0, height), radius, 0).rotate(tuple(axis), degrees).translate(tuple(shift))
    own = rng.normal(size=(400, 3)) * height
    own[:200] = (0, 0, height) + rng.normal(size=(200, 3)) * 10 ** rng.uniform(-3, 0, (200, 1))
    # Rodrigues' rotation
    x, y, z = axis / np.linalg.norm(axis)
    cross, angle = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]), np.radians(degrees)
    turn = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    flat = np.column_stack([np.hypot(own[:, 0], own[:, 1]), own[:, 2]])
    rim, tip = np.array([radius, 0]), np.array([0, height])
    expected = np.minimum(_to_segment(flat, np.zeros(2), rim), _to_segment(flat, rim, tip))
    expected[(own[:, 2] > 0) & (flat[:, 0] < radius * (1 - own[:, 2] / height))] *= -1
    found = co.Scene([cone]).distance(own @ turn.T + shift, exact=True)
    size = 1 + np.abs(shift).max()
    np.testing.assert_allclose(found.distance, expected, rtol=0, atol=1e-14 * size)
    assert found.error.max() < 1e-12 * size
