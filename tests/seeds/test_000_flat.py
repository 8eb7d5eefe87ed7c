"""Seed 000, planes, polygons by even-odd, triangles by barycentric coordinates, boxes by slabs."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest

import conicoid as co

from .along import CLOSE, first, flat, spans


def test_plane():
    """x + 2y + 2z = 6, that is D = -6/3 with a unit normal; from (1, 1, 8) along (0, 0, -1): t = (1 + 2 + 16 - 6) / 2."""
    hit = first(co.Plane((1, 2, 2), 6), (1, 1, 8), (0, 0, -1))
    assert hit.t == pytest.approx(6.5, **CLOSE)
    assert hit.point == pytest.approx([1, 1, 1.5], **CLOSE)
    assert hit.normal == pytest.approx([1 / 3, 2 / 3, 2 / 3], **CLOSE)
    assert hit.entering


def test_plane_behind_and_parallel():
    assert first(co.Plane((1, 2, 2), 6), (1, 1, 8), (0, 0, 1)).t == math.inf
    assert first(co.Plane((0, 0, 1), 1), (0, 0, 0), (1, 0, 0)).t == math.inf


@pytest.mark.parametrize(("one_sided", "from_behind"), [(False, 2.0), (True, math.inf)])
def test_one_sided_plane_is_seen_where_the_normal_faces_the_ray(one_sided, from_behind):
    """(P_n, R_d) > 0 is discarded for one-sided surfaces."""
    plane = co.Plane((0, 0, 1), 0, one_sided=one_sided)
    assert first(plane, (0, 0, 2), (0, 0, -1)).t == 2.0
    assert first(plane, (0, 0, -2), (0, 0, 1)).t == from_behind


# The polygon exercise. As printed the plane is x + 2y + z - 2 = 0; all its points satisfy + 2.
CORNERS = ((-3, -3, 7), (3, -4, 3), (4, -5, 4))
POINT = (-2, -2, 4)


def test_erratum_of_the_polygon_exercise():
    for x, y, z in (*CORNERS, POINT):
        assert x + 2 * y + z + 2 == 0
    # y is the largest component of the normal: drop it; move the point to the origin
    shifted = [(x - POINT[0], z - POINT[2]) for x, _, z in CORNERS]
    assert shifted == [(-1, 3), (5, -1), (6, 0)]
    # (6, 0) lies on the test axis and counts as v >= 0. Edge 1 crosses at u = -1 + 3·6/4 = 3.5 > 0;
    # edge 2 from v = -1 to 0 at u = 6 > 0; edge 3 has both ends at v >= 0: two crossings, outside.
    assert -1 + Fraction(3 * 6, 4) == Fraction(7, 2)


def test_polygon_exercise_is_outside():
    normal = np.array([1.0, 2.0, 1.0])
    for shape in (co.Polygon(CORNERS), co.Triangle(*CORNERS)):
        for side in (1, -1):
            origin = np.array(POINT) + side * normal
            assert first(shape, origin, -side * normal).t == math.inf
    # the middle of the triangle, (4, -12, 14)/3, is inside
    middle = np.mean(CORNERS, axis=0)
    assert first(co.Polygon(CORNERS), middle + normal, -normal).t == pytest.approx(1, **CLOSE)


CONCAVE = ((0, 0, 1), (4, 0, 1), (4, 4, 1), (2, 1, 1), (0, 4, 1))


@pytest.mark.parametrize(
    ("x", "y", "inside"),
    [
        (1, 1, True),
        (3, 1, True),
        (2, 0.5, True),
        (2, 2, False),
        (0.5, 3.9, False),
        (0.25, 3, True),
        (5, 1, False),
        (-1, 0, False),
    ],
)
def test_concave_polygon(x, y, inside):
    """The notch at (2, 1): above it the edges run along y = 1 + 3 |x - 2| / 2."""
    for z, down in ((3, -1), (-1, 1)):
        assert (first(co.Polygon(CONCAVE), (x, y, z), (0, 0, down)).t == 2.0) == inside


def test_even_odd_of_a_pentagram():
    """The middle of a self-crossing star is crossed twice: outside. Its arms are inside."""
    star = [(math.cos(a), math.sin(a), 0.0) for a in (0.8 * math.pi * k for k in range(5))]
    assert first(co.Polygon(star), (0, 0, 1), (0, 0, -1)).t == math.inf
    assert first(co.Polygon(star), (0.9, 0, 1), (0, 0, -1)).t == 1.0


@pytest.mark.parametrize("point", [(1, 0), (1, 0.5), (1, 1), (0.3, 0.3), (0.5, 1)])
def test_an_edge_shared_by_two_polygons_belongs_to_one(point):
    """Two right triangles of the unit square along x = y, and the squares on both sides of x = 1."""
    lower, upper = [(0, 0, 0), (1, 0, 0), (1, 1, 0)], [(0, 0, 0), (1, 1, 0), (0, 1, 0)]
    right = [(1, 0, 0), (2, 0, 0), (2, 1, 0), (1, 1, 0)]
    above = [(0, 1, 0), (1, 1, 0), (2, 1, 0), (2, 2, 0), (0, 2, 0)]
    below = [(0, 0, 0), (0, -1, 0), (2, -1, 0), (2, 0, 0), (1, 0, 0)]
    x, y = point
    for down in (1, -1):
        hits = [first(co.Polygon(p), (x, y, down), (0, 0, -down)).t == 1.0 for p in (lower, upper, right, above, below)]
        assert sum(hits) == 1


def test_triangle_barycentric():
    """P = α A + β B + γ C with weights as ratios of areas; uv is documented as (β, γ)."""
    a, b, c = np.array([1.0, 0, 2]), np.array([5.0, 0, 2]), np.array([1.0, 8, 2])
    for alpha, beta, gamma in ((0.5, 0.25, 0.25), (0.125, 0.125, 0.75), (0.25, 0.5, 0.25)):
        point = alpha * a + beta * b + gamma * c
        hit = first(co.Triangle(a, b, c), point + (0, 0, 2), (0, 0, -1))
        assert hit.t == 2.0
        assert hit.uv == pytest.approx([beta, gamma], **CLOSE)
        assert hit.normal == pytest.approx([0, 0, 1], **CLOSE)
    for alpha, beta, gamma in ((-0.25, 0.75, 0.5), (0.75, -0.25, 0.5), (0.75, 0.5, -0.25)):
        point = alpha * a + beta * b + gamma * c
        assert first(co.Triangle(a, b, c), point + (0, 0, 2), (0, 0, -1)).t == math.inf


def test_box_exercise_is_a_miss():
    """t_near 2.2936 (y) > t_far 1.1455 (z); the direction is 0.9988 long."""
    direction = (0.213, -0.436, 0.873)
    assert math.hypot(*direction) == pytest.approx(0.9988, abs=5e-5)
    near_y, far_z = (3 - 4) / -0.436, (3 - 2) / 0.873
    assert near_y == pytest.approx(2.2936, abs=5e-5)
    assert far_z == pytest.approx(1.1455, abs=5e-5)
    box = co.Box((-1, 2, 1), (3, 3, 3))
    assert first(box, (0, 4, 2), direction).t == math.inf
    assert spans(box, (0, 4, 2), direction) == []


def test_box_by_slabs():
    """From (0, 4, 2) along (1, -2, 0.5): x in [-1, 3], y from t = 0.5 to 1, z in [-2, 2]: inside from 0.5 to 1."""
    box = co.Box((-1, 2, 1), (3, 3, 3))
    assert flat(spans(box, (0, 4, 2), (1, -2, 0.5))) == [0.5, 1.0]
    hit = first(box, (0, 4, 2), (1, -2, 0.5))
    assert hit.normal == pytest.approx([0, 1, 0], **CLOSE)
    assert hit.entering
    # parallel to the x and z planes, between them or not; behind
    assert flat(spans(box, (0, 4, 2), (0, -1, 0))) == [1.0, 2.0]
    assert spans(box, (-2, 4, 2), (0, -1, 0)) == []
    assert first(box, (0, 4, 2), (0, 1, 0)).t == math.inf
