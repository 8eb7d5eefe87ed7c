"""The exercises and programs of the source documents: rays at shapes, each with numbers by hand."""

import math
from fractions import Fraction

import numpy as np
import pytest

import conicoid as co

CLOSE = {"rel": 1e-14, "abs": 1e-14}
NEAR = {"rel": 1e-13, "abs": 1e-14}
ROOT2, ROOT3, ROOT7 = math.sqrt(2), math.sqrt(3), math.sqrt(7)

PLANE = co.Plane((1, 2, 2), 6)
CORNERS, POINT = ((-3, -3, 7), (3, -4, 3), (4, -5, 4)), (-2, -2, 4)
"""The polygon exercise. The printed plane is x + 2y + z - 2 = 0, but all its points satisfy + 2."""
MIDDLE = tuple(float(x) for x in np.mean(CORNERS, axis=0))
CONCAVE = co.Polygon(((0, 0, 1), (4, 0, 1), (4, 4, 1), (2, 1, 1), (0, 4, 1)))
STAR = co.Polygon([(math.cos(a), math.sin(a), 0.0) for a in (0.8 * math.pi * k for k in range(5))])
TRIANGLE = co.Triangle((1, 0, 2), (5, 0, 2), (1, 8, 2))
BOX = co.Box((-1, 2, 1), (3, 3, 3))
CENTER, RADIUS = (1, -2, 3), 3
NEAREST, DIRECTION = (2, -4, 3), (Fraction(2, 3), Fraction(1, 3), Fraction(2, 3))
"""The nearest point of a line to the center: (1, -2, 0)·(2, 1, 2) = 0, at √5, so half the chord is √(9 - 5) = 2."""
A, E, H = 4.0, 0.25, 1.0
MIXED = co.Quadric(coefficients=dict(xx=1, yy=1, zz=1, xy=1, constant=-3))
BOWL = co.Quadric(coefficients=dict(xx=1, yy=1, z=-1))
CYLINDER = co.Cylinder((0, 0, 0), (0, 1, 0), 1)
P1, P2, P3 = (1, 0, 0), (1, 4, 0), (1, 1, 2)
"""The cylinder by two axis points and a reference: R_Z = (0, 1, 0), R_X = (0, 0, 1), R_Y = (1, 0, 0). Equation 2 has R_X
perpendicular to R_Z only after projection (erratum)."""
BASIS = np.array([[0, 0, 1], [1, 0, 0], [0, 1, 0]], dtype=float)
BY_POINTS = co.Cylinder(P1, P2, 2, reference=P3)
INNER = 2 - 2.0**-20
BARREL, RIM = co.Ellipsoid((1, 1, 2), z_range=(-1, 1)), ROOT3 / 2 + 1e-9
SLOPE = 2e8 + 2e-8  # rounds to 2·10⁸: the small root is 4 / (slope + √(slope² - 16)) = 4 / (4·10⁸ - 8·10⁻⁸ …)
SMALL = 4 / (SLOPE / 2 + math.sqrt(SLOPE / 2 - 2) * math.sqrt(SLOPE / 2 + 2))
NA8FIR = co.Sphere() & co.EllipticCylinder(4, 4) & co.HalfSpace((0, 0, 1), 0.5)
TRICYLINDER = (
    co.EllipticCylinder(1, 1)
    & co.EllipticCylinder(1, 1).rotate((1, 0, 0), 90)
    & co.EllipticCylinder(1, 1).rotate((0, 1, 0), 90)
)
UNIT, FLAT = np.diag([1.0, 1, 1, -1]), np.diag([1.0, 0.25, 4.0, -1.0])
FIVE_ALONG = [[1, 0, 0, 5], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
SHEAR = [[1, 2, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]


def start(before):
    """Return the point so far before the nearest one."""
    return tuple(n - before * d for n, d in zip(NEAREST, DIRECTION, strict=True))


def world(local):
    """Apply equation 3: (x, y, z) = [R_X R_Y R_Z] (X, Y, Z) + p1."""
    return BASIS.T @ np.asarray(local, dtype=float) + P1


def first(shape, origin, direction, **limits):
    return co.Scene([shape]).first_hit([float(x) for x in origin], [float(x) for x in direction], **limits)


def spans(shape, origin, direction):
    """Return where the whole line is inside: entries and exits in turn."""
    found = co.Scene([shape]).spans([float(x) for x in origin], [float(x) for x in direction], t_min=-math.inf)
    return np.stack([found.t_enter, found.t_exit], axis=-1).ravel().tolist()


MISS = dict(t=math.inf)
HITS = [
    # (1 + 2 + 16 - 6) / 2; behind; parallel; one-sided surfaces are not seen where (P_n, R_d) > 0
    (PLANE, (1, 1, 8), (0, 0, -1), dict(t=6.5, point=[1, 1, 1.5], normal=[1 / 3, 2 / 3, 2 / 3], entering=True)),
    (PLANE, (1, 1, 8), (0, 0, 1), MISS), (co.Plane((0, 0, 1), 1), (0, 0, 0), (1, 0, 0), MISS),
    (co.Plane((0, 0, 1), 0), (0, 0, -2), (0, 0, 1), dict(t=2)),
    (co.Plane((0, 0, 1), 0, one_sided=True), (0, 0, 2), (0, 0, -1), dict(t=2)),
    (co.Plane((0, 0, 1), 0, one_sided=True), (0, 0, -2), (0, 0, 1), MISS),
    # The polygon exercise: two crossings, outside; the middle of the corners is inside
    *((shape, (-2 + s, -2 + 2 * s, 4 + s), (-s, -2 * s, -s), MISS) for shape in (co.Polygon(CORNERS), co.Triangle(*CORNERS)) for s in (1, -1)),
    (co.Polygon(CORNERS), (MIDDLE[0] + 1, MIDDLE[1] + 2, MIDDLE[2] + 1), (-1, -2, -1), dict(t=1)),
    # A notch at (2, 1), above which the edges run along y = 1 + 3 |x - 2| / 2, from both sides
    *((CONCAVE, (x, y, 1 + 2 * s), (0, 0, -s), dict(t=t)) for s in (1, -1) for x, y, t in (
        (1, 1, 2), (3, 1, 2), (2, 0.5, 2), (2, 2, math.inf), (0.5, 3.9, math.inf), (0.25, 3, 2), (5, 1, math.inf), (-1, 0, math.inf))),
    # The middle of a self-crossing star is crossed twice: outside. Its arms are inside
    (STAR, (0, 0, 1), (0, 0, -1), MISS), (STAR, (0.9, 0, 1), (0, 0, -1), dict(t=1)),
    # P = α A + β B + γ C with weights as ratios of areas; uv is (β, γ)
    *((TRIANGLE, (1 + 4 * b, 8 * c, 4), (0, 0, -1), dict(t=2, uv=[b, c], normal=[0, 0, 1])) for b, c in ((0.25, 0.25), (0.125, 0.75), (0.5, 0.25))),
    *((TRIANGLE, (1 + 4 * b, 8 * c, 4), (0, 0, -1), MISS) for b, c in ((0.75, 0.5), (-0.25, 0.5), (0.5, -0.25))),
    # t_near 2.2936 (y) > t_far 1.1455 (z)
    (BOX, (0, 4, 2), (0.213, -0.436, 0.873), MISS), (BOX, (0, 4, 2), (0, 1, 0), MISS),
    (BOX, (0, 4, 2), (1, -2, 0.5), dict(t=0.5, normal=[0, 1, 0], entering=True)),
    # Ray and sphere: t0, t1 > 0; middle of the chord; t0 < 0 < t1; past the middle; behind; B = -5, C = 32, D = 25 - 32 < 0
    *((co.Sphere(RADIUS, CENTER), start(before), DIRECTION, dict(t=t, entering=before == 6, normal=(np.array(start(before - t), float) - CENTER) / RADIUS))
      for before, t in ((6, 4), (0, 2), (1, 3), (-1, 1))),
    (co.Sphere(RADIUS, CENTER), start(-3), DIRECTION, dict(t=math.inf, body=-1, entering=False)),
    (co.Sphere(RADIUS, CENTER), (1, 2, -2), (0, 0, 1), MISS),
    *((co.Sphere(RADIUS, CENTER), start(6), (2 * s, s, 2 * s), dict(t=4 / (3 * s))) for s in (1, 0.5, 7)),
    # 3 t² = 3; the gradient is (2x + y, 2y + x, 2z) = (3, 3, 0). a = 0, b = -1, c = 5: the gradient is (2, 4, -1)
    (MIXED, (0, 0, 0), (1, 1, 0), dict(t=1, normal=[math.sqrt(0.5), math.sqrt(0.5), 0], entering=False)),
    (BOWL, (1, 2, 0), (0, 0, 1), dict(t=5, normal=np.array([2, 4, -1]) / math.sqrt(21), entering=True)),
    (co.Quadric(coefficients=dict(x=1, y=2, z=2, constant=-3)), (3, 1, 1), (-1, 0, 0), dict(t=4, normal=[1 / 3, 2 / 3, 2 / 3])),
    # Equations 4 to 12: D = 25 - 22 = 3; local points (1, ±√3, 1), angles of 60° and 300°, height 1 of 4
    (BY_POINTS, (6, 1, 1), (-1, 0, 0), dict(local_point=[1, ROOT3, 1], point=[1 + ROOT3, 1, 1], uv=[60 / 360, 0.25])),
    (BY_POINTS, (1, 1, 1), (-1, 0, 0), dict(local_point=[1, -ROOT3, 1], uv=[300 / 360, 0.25])),
    *((shape, (6, y, 0), (-1, 0, 0), dict(hit=hit)) for shape in (BY_POINTS, co.CylinderPatch(P1, P2, 2, 0, 360, P3))
      for y, hit in ((-0.1, False), (0.1, True), (3.9, True), (4.1, False))),
    # Gradients (x/2, 2y/9) and (3, 0, 1); caps; the ray hits the wall at x = -1 at z = 3, above the end; the apex, where it vanishes
    (co.Ellipsoid((2, 3, 1)), (-9, -9, 0), (1, 1, 0), dict(normal=np.array([-9, -4, 0]) / math.sqrt(97))),
    (co.Cone((0, 0, 0), (0, 0, 3), 2, 1), (9, 0, 1.5), (-1, 0, 0), dict(normal=np.array([3, 0, 1]) / math.sqrt(10))),
    (BARREL, (0.5, 0.5, 4), (0, 0, -1), dict(t=3, normal=[0, 0, 1])),
    (co.Cylinder((0, 0, 0), (4, 4, 2), 1), (-2, -2, -1), (2, 2, 1), dict(t=1, normal=[-2 / 3, -2 / 3, -1 / 3])),
    (co.Cylinder((0, 0, 0), (0, 0, 2), 1), (-2, 0, 4), (1, 0, -1), dict(t=2, face=2)),
    (co.Cone((0, 0, 0), (0, 0, 1), 1, 0), (0, 0, 5), (0, 0, -1), dict(t=4, normal=[0, 0, 1], entering=True)),
    (co.Sphere(1, (3, 0, 0)).scale((-1, 1, 1)), (-9, 0, 0), (1, 0, 0), dict(t=5, normal=[-1, 0, 0], entering=True)),
]  # fmt: skip


@pytest.mark.parametrize(("shape", "origin", "direction", "expected"), HITS)
def test_first_hits(shape, origin, direction, expected):
    hit = first(shape, origin, direction)
    for name, value in expected.items():
        assert getattr(hit, name) == pytest.approx(value, **CLOSE), name


SPANS = [
    # By slabs: x in [-1, 3], y from t = 0.5 to 1, z in [-2, 2]; parallel to the x and z planes, between them or not
    (BOX, (0, 4, 2), (0.213, -0.436, 0.873), []), (BOX, (0, 4, 2), (1, -2, 0.5), [0.5, 1]),
    (BOX, (0, 4, 2), (0, -1, 0), [1, 2]), (BOX, (-2, 4, 2), (0, -1, 0), []),
    # A = E = H = 1 and B = 1/2 in the source's letters is xy with coefficient one; a = b = 0 is all or nothing
    (MIXED, (0, 0, 0), (1, 1, 0), [-1, 1]),
    (co.Quadric(matrix=[[1, 0.5, 0, 0], [0.5, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, -3]]), (0, 0, 0), (1, 1, 0), [-1, 1]),
    (co.Quadric(coefficients=dict(xx=1, yy=1, constant=-1)), (0.5, 0, 0), (0, 0, 1), [-math.inf, math.inf]),
    (co.Quadric(coefficients=dict(xx=1, yy=1, constant=-1)), (2, 0, 0), (0, 0, 1), []),
    (co.Quadric(coefficients=dict(x=1, y=2, z=2, constant=-3)), (3, 1, 1), (-1, 0, 0), [4, math.inf]),
    # A x² + E y² + H z² = 1; bowls from c = 1/√H on; A x² - E y² = h inside |x| <= √(h/A), outside |y| < √(-h/E)
    (co.Ellipsoid.from_coefficients(A, E, H), (0, 0, -5), (0, 0, 1), [4, 6]),
    (co.TwoSheetHyperboloid(A, E, H), (0, 0, 0), (0, 0, 1), [-math.inf, -1, 1, math.inf]),
    (co.HyperbolicParaboloid(A, E), (0, 0, 1), (1, 0, 0), [-0.5, 0.5]), (co.HyperbolicParaboloid(A, E), (0, 0, -4), (1, 0, 0), []),
    (co.HyperbolicParaboloid(A, E), (0, 0, 1), (0, 1, 0), [-math.inf, math.inf]),
    (co.HyperbolicParaboloid(A, E), (0, 0, -4), (0, 1, 0), [-math.inf, -4, 4, math.inf]),
    (co.HyperbolicCylinder(A, E), (0, 0, 9), (1, 0, 0), [-0.5, 0.5]), (co.HyperbolicCylinder(A, E), (0, 0, 0), (0, 1, 0), [-math.inf, math.inf]),
    (co.HyperbolicCylinder(A, E), (0, 2, 0), (1, 0, 0), [-math.sqrt(0.5), math.sqrt(0.5)]),
    # x² = 2 G y: half the width at y = h is √(2 G h)
    (co.ParabolicCylinder(3), (0, 6, 0), (1, 0, 0), [-6, 6]), (co.ParabolicCylinder(3), (0, 0, 4), (0, 1, 0), [0, math.inf]),
    (co.ParabolicCylinder(3), (0, -1, 0), (1, 0, 0), []),
    # The special cases of caps: tangent, parallel, missing, along a ruling
    (CYLINDER, (-3, 0.5, 1), (1, 0, 0), []), (CYLINDER, (-3, -0.25, 1), (4, 1, 0), []), (CYLINDER, (-3, 0.5, 0), (1, 0, 0), [2, 4]),
    (CYLINDER, (-3, 0.25, 0.6), (1, 0, 0), [2.2, 3.8]), (CYLINDER, (-3, 1.5, 0), (1, 0, 0), []), (CYLINDER, (-3, 0.5, 2), (1, 0, 0), []),
    (CYLINDER, (-3, -1, 1.5), (1, 1, 0), []), (CYLINDER, (0.5, -2, 0.5), (0, 1, 0), [2, 3]), (CYLINDER, (1, -2, 1), (0, 1, 0), []),
    (CYLINDER, (1, -2, 0), (0, 1, 0), []),
    # Both caps of other quadrics: at x = 1.5 in by the body at z = 2.25, out by the cap; two bowls cut on one side only
    (co.EllipticParaboloid(1, 1, z_range=(1, 4)), (0, 0, -1), (0, 0, 1), [2, 5]),
    (co.EllipticParaboloid(1, 1, z_range=(1, 4)), (1.5, 0, 0), (0, 0, 1), [2.25, 4]),
    (co.TwoSheetHyperboloid(1, 1, 1, z_range=(0, 3)), (0, 0, -9), (0, 0, 1), [10, 12]),
    # Equation 13.4: x² + y² + z² = 1 from (0, 0.6, -2) along z: ±0.8; three times as large; M⁻ᵀ Q M⁻¹, and not M⁻¹ Q M⁻ᵀ as
    # printed: the shear takes (0, 2, 0), a point of x² + y²/4 + 4z² = 1, to (4, 2, 0)
    (co.Quadric(matrix=UNIT), (0, 0.6, -2), (0, 0, 1), [1.2, 2.8]), (co.Sphere(3), (-5, 0, 0), (1, 0, 0), [2, 8]),
    (co.Quadric(matrix=UNIT).scale(3), (-5, 0, 0), (1, 0, 0), [2, 8]),
    (co.Quadric(matrix=UNIT).transform(np.diag([3, 3, 3, 1])), (-5, 0, 0), (1, 0, 0), [2, 8]),
    (co.Quadric(matrix=np.diag([1 / 9, 1 / 9, 1 / 9, -1])), (-5, 0, 0), (1, 0, 0), [2, 8]),
    (co.Sphere().transform(FIVE_ALONG), (0, 0, 0), (1, 0, 0), [4, 6]), (co.Quadric(matrix=UNIT).transform(FIVE_ALONG), (0, 0, 0), (1, 0, 0), [4, 6]),
    (co.Quadric(matrix=FLAT).transform(SHEAR), (-4, -2, 0), (8, 4, 0), [0, 1]), (co.Ellipsoid((1, 2, 0.5)).transform(SHEAR), (-4, -2, 0), (8, 4, 0), [0, 1]),
    # Equation 8: t = 5 ∓ √3; at X = 2 the ray touches (D = 0), beyond it misses
    (BY_POINTS, (6, 1, 1), (-1, 0, 0), [5 - ROOT3, 5 + ROOT3]), (BY_POINTS, (6, 1, 2), (-1, 0, 0), []), (BY_POINTS, (6, 1, 2.5), (-1, 0, 0), []),
    (BY_POINTS, (6, 1, INNER), (-1, 0, 0), [5 - math.sqrt(4 - INNER**2), 5 + math.sqrt(4 - INNER**2)]),
    # 270° from 0: along Y = -1 in at -√3, out at the wall X = 0. Along Y = X - 1 from X = (1 + √7)/2 down to the wall Y = 0 at
    # X = 1, and from the wall X = 0 on to X = (1 - √7)/2
    (co.Cylinder(P1, P2, 2, 0, 270, P3), world((-3, -1, 1)), BASIS.T @ [1, 0, 0], [3 - ROOT3, 3]),
    (co.Cylinder(P1, P2, 2, 0, 270, P3), world((3, 2, 1)), BASIS.T @ [-1, -1, 0], [(5 - ROOT7) / 2, 2, 3, (5 + ROOT7) / 2]),
    # KVADR: t² - 3 t + 2; t² - 2 (10⁸ + 10⁻⁸) t + 4 has the roots 2·10⁸ and 2·10⁻⁸, where the textbook formula is wrong in every digit
    (co.ParabolicCylinder(0.5), (0, -2, 0), (1, 3, 0), [1, 2]), (co.ParabolicCylinder(0.5), (0, -4, 0), (1, SLOPE, 0), [SMALL, 4 / SMALL]),
    # ALLIPS: t² (1/4 + 1/9) = 1. ALLOID: end circles of radius √3/2, belly of radius 1
    (co.Ellipsoid((2, 3, 1)), (-9, -9, 0), (1, 1, 0), [9 - 6 / math.sqrt(13), 9 + 6 / math.sqrt(13)]),
    (BARREL, (0, 0, -5), (0, 0, 1), [4, 6]), (BARREL, (-5, 0, 0), (1, 0, 0), [4, 6]), (BARREL, (ROOT3 / 2 - 1e-9, 0, -5), (0, 0, 1), [4, 6]),
    (BARREL, (RIM, 0, -5), (0, 0, 1), [5 - 2 * math.sqrt(1 - RIM**2), 5 + 2 * math.sqrt(1 - RIM**2)]),
    # CILIND along its axis and across its middle (2, 2, 1). KONYS: r = 2 - z/3. PICA: x² + y² <= 4 z²
    (co.Cylinder((0, 0, 0), (4, 4, 2), 1), (-2, -2, -1), (2, 2, 1), [1, 3]),
    (co.Cylinder((0, 0, 0), (4, 4, 2), 1), (-1, 5, 1), (1, -1, 0), [3 - ROOT2 / 2, 3 + ROOT2 / 2]),
    (co.Cone((0, 0, 0), (0, 0, 3), 2, 1), (-9, 0, 1.5), (1, 0, 0), [7.5, 10.5]), (co.Cone((0, 0, 0), (0, 0, 3), 2, 1), (1.75, 0, -1), (0, 0, 1), [1, 1.75]),
    *((co.DoubleCone(2), (-50, 0, z), (1, 0, 0), [30, 70]) for z in (10, -10)), (co.DoubleCone(2), (6, 0, 0), (0, 0, 1), [-math.inf, -3, 3, math.inf]),
    # Planes 2 apart slide along the axis of x² + y² <= z²: two pieces while both nappes are cut at x = 1/2, then one
    *((co.DoubleCone(1, z_range=(m - 1, m + 1)), (0.5, 0, 0), (0, 0, 1), t) for m, t in (
        (0, [-1, -0.5, 0.5, 1]), (0.25, [-0.75, -0.5, 0.5, 1.25]), (0.5, [0.5, 1.5]), (1, [0.5, 2]), (2, [1, 3]))),
    *((co.DoubleCone(1, z_range=(m - 1, m + 1)), (-9, 0, m), (1, 0, 0), [9 - m, 9 + m] if m else []) for m in (0, 0.25, 0.5, 1, 2)),
    # NA8FIR: roots of a surface outside of the others are false. The cylinder's wall goes on above its end, the solid does not
    (NA8FIR, (0.3, 0, 5), (0, 0, -1), [4.5, 5 + math.sqrt(0.91)]), (NA8FIR, (5, 0, 0), (-1, 0, 0), [4.5, 5.5]), (NA8FIR, (5, 0, 0.95), (-1, 0, 0), []),
    (co.Cylinder((0, 0, 0), (0, 0, 2), 1), (-2, 0, 4), (1, 0, -1), [2, 3]),
    (TRICYLINDER, (0, 0, 0), (1, 1, 1), [-1 / ROOT2, 1 / ROOT2]), (TRICYLINDER, (0, 0, 0), (1, 0, 0), [-1, 1]),
    (TRICYLINDER, (0, 0, 0), (1, 1, 0), [-1 / ROOT2, 1 / ROOT2]),
]  # fmt: skip


@pytest.mark.parametrize(("shape", "origin", "direction", "expected"), SPANS)
def test_spans(shape, origin, direction, expected):
    assert spans(shape, origin, direction) == pytest.approx(expected, **NEAR)


SECTIONS = [
    *((co.Ellipsoid.from_coefficients(A, E, H), h, 1 - h * h, 1 - h * h) for h in (0, 0.6, 1.5)),
    *((co.EllipticParaboloid(A, E), h, h, h) for h in (1, 4, -1)), *((co.EllipticCylinder(A, E), h, 1, 1) for h in (0, 50)),
    *((co.OneSheetHyperboloid(A, E, H), h, 1 + h * h, 1 + h * h) for h in (0, 2, -3)),
    *((co.TwoSheetHyperboloid(A, E, H), h, h * h - 1, h * h - 1) for h in (0, 0.5, 2, -3)),
    *((co.EllipticCone(A, E, H), h, h * h, h * h) for h in (1, -2)),
]  # fmt: skip
"""Shapes, heights h, and A x² and E y² at the ends of the section's axes. Where they are negative there is no end."""


@pytest.mark.parametrize(("shape", "h", "x", "y"), SECTIONS)
def test_sections_of_canonical_quadrics(shape, h, x, y):
    for axis, square in (((1, 0, 0), x / A), ((0, 1, 0), y / E)):
        half = math.sqrt(max(square, 0))
        found = spans(shape, (-100 * axis[0], -100 * axis[1], h), axis)
        assert found == pytest.approx([100 - half, 100 + half] if half else [], rel=1e-13)


@pytest.mark.parametrize("point", [(1, 0), (1, 0.5), (1, 1), (0.3, 0.3), (0.5, 1)])
def test_an_edge_shared_by_two_polygons_belongs_to_one(point):
    """The squares are two right triangles of the unit square along x = y, and the squares on both sides of x = 1."""
    polygons = [
        [(0, 0, 0), (1, 0, 0), (1, 1, 0)], [(0, 0, 0), (1, 1, 0), (0, 1, 0)], [(1, 0, 0), (2, 0, 0), (2, 1, 0), (1, 1, 0)],
        [(0, 1, 0), (1, 1, 0), (2, 1, 0), (2, 2, 0), (0, 2, 0)], [(0, 0, 0), (0, -1, 0), (2, -1, 0), (2, 0, 0), (1, 0, 0)],
    ]  # fmt: skip
    for down in (1, -1):
        assert sum(bool(first(co.Polygon(p), (*point, down), (0, 0, -down)).hit) for p in polygons) == 1


BODY, LOW_CAP, HIGH_CAP = 0, 1, 2
NORMALS = {LOW_CAP: (0, -1, 0), HIGH_CAP: (0, 1, 0)}
GENERAL = {  # origin, direction, (c1, c2), (b1, b2), expected (enter, face), (exit, face)
    "1: c1 c2 b1 b2, miss": ((-4, -1), (1, 1), (1, 2), (3, 5), None),
    "2: c1 b1 c2 b2, body then cap": ((-2.5, -1), (1, 1), (1, 2), (1.5, 3.5), ((1.5, BODY), (2, HIGH_CAP))),
    "3: c1 b1 b2 c2, body then body": ((-3, -0.25), (4, 1), (0.25, 1.25), (0.5, 1), ((0.5, BODY), (1, BODY))),
    "4: b1 c1 b2 c2, cap then body": ((-2, -2.5), (1, 1), (2.5, 3.5), (1, 3), ((2.5, LOW_CAP), (3, BODY))),
    "5: b1 c1 c2 b2, cap then cap": ((-1.5, -1), (1, 1), (1, 2), (0.5, 2.5), ((1, LOW_CAP), (2, HIGH_CAP))),
    "6: b1 b2 c1 c2, miss": ((-2, -4), (1, 1), (4, 5), (1, 3), None),
}


@pytest.mark.parametrize("case", GENERAL)
def test_the_six_cases_of_caps(case):
    """Cases stand as they are, reversed and upside down."""
    (x, y), (u, v), _, _, expected = GENERAL[case]
    t = [] if expected is None else [expected[0][0], expected[1][0]]
    assert spans(CYLINDER, (x, y, 0), (u, v, 0)) == pytest.approx(t, **CLOSE)
    assert spans(CYLINDER, (x, y, 0), (-u, -v, 0)) == pytest.approx([-s for s in reversed(t)], **CLOSE)
    assert spans(CYLINDER, (x, 1 - y, 0), (u, -v, 0)) == pytest.approx(t, **CLOSE)
    for where, face, enters in zip((0, sum(t) / 2), [f for _, f in expected or ()], (True, False), strict=False):
        hit = first(CYLINDER, (x + u * where, y + v * where, 0), (u, v, 0))
        assert (hit.face, hit.entering) == (face, enters)
        assert hit.normal == pytest.approx(NORMALS.get(face, (-1 if enters else 1, 0, 0)), **CLOSE)


@pytest.mark.parametrize("degrees", [0, 30, 90, 200, 359])
def test_uv_of_the_sphere_and_the_cylinder(degrees):
    """Angle over a full turn, and the height scaled to [0, 1]."""
    x, y = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    for shape, height in ((co.Cylinder((0, 0, 1), (0, 0, 5), 1, reference=(1, 0, 0)), 1 / 4), (co.Sphere(2, (0, 0, 1)), 3 / 4)):  # fmt: skip
        hit = first(shape, (6 * x, 6 * y, 2), (-x, -y, 0))
        assert hit.uv[0] % 1 == pytest.approx(degrees / 360, abs=1e-15)
        assert hit.uv[1] == pytest.approx(height, abs=1e-15)


RANGES = [(0, 90), (30, 60), (-45, 45), (300, 420), (10, 300), (0, 180), (90, 270), (-170, 170), (200, 500)]


@pytest.mark.parametrize(("low", "high"), RANGES)
def test_angles_of_equation_12(low, high):
    """From the axis outwards at angle θ, the ray hits the patch where θ is in the range. atan2 gives -120° for 240°."""
    patch, wedge = co.CylinderPatch(P1, P2, 2, low, high, P3), co.Cylinder(P1, P2, 2, low, high, P3)
    for theta in range(-177, 540, 20):
        inside = any(low <= theta + 360 * k <= high for k in range(-3, 4))
        outward = BASIS.T @ [math.cos(math.radians(theta)), math.sin(math.radians(theta)), 0]
        hit = first(patch, world((0, 0, 1)), outward)
        assert hit.t == (pytest.approx(2, **CLOSE) if inside else math.inf), theta
        if inside:
            assert hit.uv[0] % 1 == pytest.approx(theta % 360 / 360, abs=1e-15)
        assert bool(co.Scene([wedge]).contains(world((0, 0, 1)) + outward)) == inside, theta


@pytest.mark.parametrize(("shape", "origin", "direction"), [
    (co.Sphere(2), (-5, 2, 0), (1, 0, 0)), (co.Sphere(5), (3 - 4 * 4, 4 + 4 * 3, 0), (4, -3, 0)), (co.Ellipsoid((1, 2, 4)), (-5, 0, 4), (1, 0, 0)),
    (co.Cylinder((0, 0, 0), (0, 0, 1), 1), (-5, 1, 0.5), (1, 0, 0)), (co.EllipticParaboloid(1, 1), (-5, 0, 0), (1, 0, 0)),
    (co.ParabolicCylinder(1), (-5, 0, 0), (1, 0, 3)),
])  # fmt: skip
def test_tangency_is_invisibility(shape, origin, direction):
    """D = 0: a touch at one point is no hit."""
    assert first(shape, origin, direction, t_min=-math.inf).t == math.inf
    assert spans(shape, origin, direction) == []
    assert not co.Scene([shape]).occluded(origin, direction, t_min=-math.inf)
