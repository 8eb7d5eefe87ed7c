"""Seed 000: planes, polygons, triangles, boxes, spheres, general quadrics and the nine canonical ones."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest

import conicoid as co

from .along import CLOSE, first, flat, spans

# --- Seed 000, planes, polygons by even-odd, triangles by barycentric coordinates, boxes by slabs


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


# --- Seed 000, ray and sphere: the algebraic and the geometric method, entering and leaving


CENTER, RADIUS = (1, -2, 3), 3
# The point (2, -4, 3) is the nearest to the centre on every line through it along (2, 1, 2)/3 or
# (2, 1, -2)/3: (1, -2, 0)·(2, 1, ±2) = 0. Its squared distance is 5, so half the chord is √(9 - 5) = 2.
NEAREST = (2, -4, 3)
DIRECTION = (Fraction(2, 3), Fraction(1, 3), Fraction(2, 3))


def start(before):
    return tuple(n - before * d for n, d in zip(NEAREST, DIRECTION, strict=True))


def algebraic(origin, direction):
    """t² + 2 B t + C = 0 with B = (R_d, R_0 - S_c), C = (R_0 - S_c)² - r²; the smaller positive root."""
    out = [o - c for o, c in zip(origin, CENTER, strict=True)]
    b = sum(d * x for d, x in zip(direction, out, strict=True))
    c = sum(x * x for x in out) - RADIUS**2
    discriminant = b * b - c
    if discriminant < 0:
        return None
    for t in (-b - math.sqrt(discriminant), -b + math.sqrt(discriminant)):
        if t > 0:
            return t
    return None


def geometric(origin, direction):
    """OC, t_ca = (OC, R_d), t_hc² = r² - OC² + t_ca²; minus from outside, plus from inside."""
    oc = [c - o for o, c in zip(origin, CENTER, strict=True)]
    distance2 = sum(x * x for x in oc)
    outside = distance2 > RADIUS**2
    t_ca = sum(x * d for x, d in zip(oc, direction, strict=True))
    if t_ca < 0 and outside:
        return None
    t_hc2 = RADIUS**2 - distance2 + t_ca**2
    if t_hc2 < 0:
        return None
    return t_ca - math.sqrt(t_hc2) if outside else t_ca + math.sqrt(t_hc2)


@pytest.mark.parametrize(
    ("before", "t", "entering"),
    [(6, 4, True), (0, 2, False), (1, 3, False), (-1, 1, False), (-3, None, False)],
    ids=["t0, t1 > 0: enters", "middle of the chord", "t0 < 0 < t1: leaves", "past the middle", "t0, t1 < 0: behind"],
)
def test_both_methods_and_the_library(before, t, entering):
    import conicoid as co

    origin = start(before)
    assert algebraic(origin, DIRECTION) == t
    assert geometric(origin, DIRECTION) == t
    hit = first(co.Sphere(RADIUS, CENTER), [float(x) for x in origin], [float(x) for x in DIRECTION])
    assert hit.entering == entering
    if t is None:
        assert hit.t == math.inf
        assert hit.body == -1
        return
    assert hit.t == pytest.approx(t, **CLOSE)
    point = [float(o + t * d) for o, d in zip(origin, DIRECTION, strict=True)]
    assert hit.point == pytest.approx(point, **CLOSE)
    # N = (R_i - S_c) / r
    assert hit.normal == pytest.approx([(p - c) / RADIUS for p, c in zip(point, CENTER, strict=True)], **CLOSE)


def test_negative_discriminant_is_a_miss():
    import conicoid as co

    # 4 beside the centre: C = 16 + 25 - 9 = 32, B = -5, D = 25 - 32 < 0
    assert algebraic((1, 2, -2), (0, 0, 1)) is None
    assert geometric((1, 2, -2), (0, 0, 1)) is None
    assert first(co.Sphere(RADIUS, CENTER), (1, 2, -2), (0, 0, 1)).t == math.inf


@pytest.mark.parametrize("length", [1, 0.5, 7])
def test_direction_need_not_be_unit(length):
    import conicoid as co

    hit = first(co.Sphere(RADIUS, CENTER), [float(x) for x in start(6)], [2 * length, length, 2 * length])
    assert hit.t == pytest.approx(4 / (3 * length), **CLOSE)


# --- Seed 000, general quadrics with their gradient normal, and the nine canonical quadrics with their sections


A, E, H = 4.0, 0.25, 1.0


def test_general_quadric():
    """f = x² + y² + z² + xy - 3 along (1, 1, 0) from the origin: 3 t² = 3, t = 1.

    There the gradient is (2x + y, 2y + x, 2z) = (3, 3, 0).
    """
    shape = co.Quadric(coefficients=dict(xx=1, yy=1, zz=1, xy=1, constant=-3))
    assert flat(spans(shape, (0, 0, 0), (1, 1, 0))) == pytest.approx([-1, 1], **CLOSE)
    hit = first(shape, (0, 0, 0), (1, 1, 0))
    assert hit.t == pytest.approx(1, **CLOSE)
    assert hit.normal == pytest.approx([math.sqrt(0.5), math.sqrt(0.5), 0], **CLOSE)
    assert not hit.entering


def test_matrix_form_has_half_the_mixed_coefficients():
    """A = 1, E = 1, H = 1, B = 1/2 in the source's letters is xy with coefficient one."""
    matrix = np.diag([1.0, 1, 1, -3])
    matrix[0, 1] = matrix[1, 0] = 0.5
    assert flat(spans(co.Quadric(matrix=matrix), (0, 0, 0), (1, 1, 0))) == pytest.approx([-1, 1], **CLOSE)


def test_a_zero_gives_minus_c_over_b():
    """Along the axis of x² + y² - z = 0 from (1, 2, 0): a = 0, b = -1, c = 5, t = 5."""
    hit = first(co.Quadric(coefficients=dict(xx=1, yy=1, z=-1)), (1, 2, 0), (0, 0, 1))
    assert hit.t == pytest.approx(5, **CLOSE)
    # gradient (2, 4, -1)
    assert hit.normal == pytest.approx(np.array([2, 4, -1]) / math.sqrt(21), **CLOSE)
    assert hit.entering


@pytest.mark.parametrize(("x", "inside"), [(0.5, True), (2.0, False)])
def test_a_and_b_zero_is_all_or_nothing(x, inside):
    """The case that the source leaves out: along the axis of x² + y² = 1 nothing changes."""
    found = spans(co.Quadric(coefficients=dict(xx=1, yy=1, constant=-1)), (x, 0, 0), (0, 0, 1))
    assert found == ([(-math.inf, math.inf)] if inside else [])


def test_a_plane_in_disguise():
    """All second-order terms zero: x + 2y + 2z <= 3 is a half-space."""
    shape = co.Quadric(coefficients=dict(x=1, y=2, z=2, constant=-3))
    assert flat(spans(shape, (3, 1, 1), (-1, 0, 0))) == [4.0, math.inf]
    assert first(shape, (3, 1, 1), (-1, 0, 0)).normal == pytest.approx([1 / 3, 2 / 3, 2 / 3], **CLOSE)


def sections(shape, h, reach=100.0):
    """Half of each chord through (0, 0, h) along x and y, and its middle; None where there is none."""
    halves = []
    for axis in ((1, 0, 0), (0, 1, 0)):
        origin = tuple(-reach * a + (h if i == 2 else 0) for i, a in enumerate(axis))
        found = spans(shape, origin, axis)
        if len(found) != 1 or math.isinf(found[0][0]):
            halves.append(None)
            continue
        low, high = found[0]
        assert (low + high) / 2 == pytest.approx(reach, rel=1e-13)
        halves.append((high - low) / 2)
    return halves


def expect(shape, h, *squares):
    """Half axes of the section at z = h are the roots of `squares`; a negative one says that there is no section."""
    found = sections(shape, h)
    expected = [math.sqrt(s) if s > 0 else None for s in squares]
    assert found == [None if e is None else pytest.approx(e, rel=1e-12) for e in expected]


def test_ellipsoid_has_half_axes_one_over_root():
    """A x² + E y² + H z² = 1: a = 1/√A = 1/2, b = 1/√E = 2, c = 1/√H = 1."""
    shape = co.Ellipsoid.from_coefficients(A, E, H)
    expect(shape, 0.0, 1 / A, 1 / E)
    assert flat(spans(shape, (0, 0, -5), (0, 0, 1))) == pytest.approx([4, 6], **CLOSE)
    expect(shape, 0.6, (1 - 0.36) / A, (1 - 0.36) / E)
    expect(shape, 1.5, -1, -1)


@pytest.mark.parametrize("h", [1.0, 4.0, -1.0])
def test_elliptic_paraboloid(h):
    """At z = h: √(h/A), √(h/E)."""
    expect(co.EllipticParaboloid(A, E), h, h / A, h / E)


@pytest.mark.parametrize("h", [1.0, -4.0])
def test_hyperbolic_paraboloid(h):
    """A x² - E y² = h: for h > 0 inside |x| <= √(h/A); for h < 0 outside |y| < √(-h/E)."""
    shape = co.HyperbolicParaboloid(A, E)
    along_x, along_y = spans(shape, (0, 0, h), (1, 0, 0)), spans(shape, (0, 0, h), (0, 1, 0))
    if h > 0:
        assert flat(along_x) == pytest.approx([-math.sqrt(h / A), math.sqrt(h / A)], **CLOSE)
        assert along_y == [(-math.inf, math.inf)]
    else:
        assert along_x == []
        edge = math.sqrt(-h / E)
        assert flat(along_y) == pytest.approx([-math.inf, -edge, edge, math.inf], **CLOSE)


@pytest.mark.parametrize("h", [0.0, 2.0, -3.0])
def test_one_sheet_hyperboloid(h):
    """A x² + E y² = 1 + H h²; the waist has a = 1/√A, b = 1/√E."""
    expect(co.OneSheetHyperboloid(A, E, H), h, (1 + H * h * h) / A, (1 + H * h * h) / E)


@pytest.mark.parametrize("h", [0.0, 0.5, 2.0, -3.0])
def test_two_sheet_hyperboloid(h):
    """A x² + E y² = H h² - 1: nothing for |h| < c = 1/√H."""
    expect(co.TwoSheetHyperboloid(A, E, H), h, (H * h * h - 1) / A, (H * h * h - 1) / E)


def test_two_bowls_start_at_c():
    c = 1 / math.sqrt(H)
    found = spans(co.TwoSheetHyperboloid(A, E, H), (0, 0, 0), (0, 0, 1))
    assert flat(found) == pytest.approx([-math.inf, -c, c, math.inf], **CLOSE)


@pytest.mark.parametrize("h", [1.0, -2.0])
def test_cone(h):
    """A x² + E y² = H h²"""
    expect(co.EllipticCone(A, E, H), h, H * h * h / A, H * h * h / E)


@pytest.mark.parametrize("h", [0.0, 50.0])
def test_elliptic_cylinder(h):
    expect(co.EllipticCylinder(A, E), h, 1 / A, 1 / E)


def test_hyperbolic_cylinder():
    """A x² - E y² = 1 has a = 1/√A; the inside is between the branches."""
    shape = co.HyperbolicCylinder(A, E)
    assert flat(spans(shape, (0, 0, 9), (1, 0, 0))) == pytest.approx([-0.5, 0.5], **CLOSE)
    # at y = 2: A x² = 1 + 4 E = 2
    assert flat(spans(shape, (0, 2, 0), (1, 0, 0))) == pytest.approx([-math.sqrt(0.5), math.sqrt(0.5)], **CLOSE)
    assert spans(shape, (0, 0, 0), (0, 1, 0)) == [(-math.inf, math.inf)]


def test_parabolic_cylinder():
    """x² = 2 G y: at y = h the half width is √(2 G h); focus at G/2."""
    shape = co.ParabolicCylinder(3.0)
    assert flat(spans(shape, (0, 6, 0), (1, 0, 0))) == pytest.approx([-6, 6], **CLOSE)
    assert flat(spans(shape, (0, 0, 4), (0, 1, 0))) == [0, math.inf]
    assert spans(shape, (0, -1, 0), (1, 0, 0)) == []
