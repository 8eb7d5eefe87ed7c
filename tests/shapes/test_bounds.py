"""Bounds hold the solid under every motion, and touch it."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from mpmath import mp

from conicoid.geometry.general_quadric import Quadric
from conicoid.geometry.polyhedron import Polyhedron
from conicoid.geometry.primitives import Box, Cone, Cylinder, HalfSpace
from conicoid.geometry.quadrics import (
    BoxedQuadric,
    DoubleCone,
    Ellipsoid,
    EllipticCone,
    EllipticCylinder,
    EllipticParaboloid,
    EllipticSolid,
    HyperbolicCylinder,
    HyperbolicParaboloid,
    OneSheetHyperboloid,
    ParabolicCylinder,
    TwoSheetHyperboloid,
)

from ..samples import sampled
from .catalogue import SAMPLES, Sample
from .motions import carried, climb, random_motion

INF = math.inf
R2, R3 = math.sqrt(2), math.sqrt(3)


@pytest.mark.parametrize("sample", sampled([s for s in SAMPLES if s.bounded], 4), ids=lambda sample: sample.name)
def test_bounds_hold_and_touch_the_solid(sample: Sample) -> None:
    """Each side is reached, by an evolution of points that the inequality calls inside."""
    rng = np.random.default_rng(11)
    start = rng.uniform(-sample.reach, sample.reach, (50000, 3))
    start = start[sample.inside(*start.T)]
    for motion in (random_motion(rng) for _ in range(2)):
        low, high = sample.shape.bounds_under(motion)
        world = carried(motion, start)
        assert (world >= low).all()
        assert (world <= high).all()
        for axis in range(3):
            for sign, side in ((1, high[axis]), (-1, -low[axis])):
                direction = sign * motion.matrix[axis, :3]
                reached = climb(lambda p: sample.inside(*p.T), direction, start, rng, 250, 100) @ direction
                reached += sign * motion.matrix[axis, 3]
                assert reached <= side + 1e-14 * (high - low).max()
                assert side - reached <= 1e-4 * (high - low).max()


@pytest.mark.parametrize("sample", [s for s in SAMPLES if not s.bounded], ids=lambda sample: sample.name)
def test_bounds_of_unbounded_solids_hold_them(sample: Sample) -> None:
    rng = np.random.default_rng(13)
    points = rng.uniform(-1, 1, (20000, 3)) * 10 ** rng.uniform(-2, 4, (20000, 1))
    points = points[sample.inside(*points.T)]
    for motion in (random_motion(rng) for _ in range(3)):
        low, high = sample.shape.bounds_under(motion)
        world = carried(motion, points)
        assert (world >= low).all()
        assert (world <= high).all()


# Of radius R3 about the z-axis, endless along it
HEXAGON = Polyhedron(tuple((x, y * R3, 0) for s in (1, -1) for x, y in ((2 * s, 0), (s, s), (s, -s))), (2 * R3,) * 6)
KNOWN = [
    (Ellipsoid((1, 2, 3), (5, 0, 0)), (4, -2, -3), (6, 2, 3)),
    # The widest section in the range is at z = 1: sqrt(1 - 1/9)
    (Ellipsoid((1, 2, 3), z_range=(1, 2)), (-2 * R2 / 3, -4 * R2 / 3, 1), (2 * R2 / 3, 4 * R2 / 3, 2)),
    (Ellipsoid((1, 2, 3), z_range=(-1, 9)), (-1, -2, -1), (1, 2, 3)),
    (Ellipsoid((1, 2, 3)) & HalfSpace((0, 0, -1), -4), (INF, INF, INF), (-INF, -INF, -INF)),
    # A ball of radius 1 turned by any angle
    (Ellipsoid((1, 1, 1)).rotate((1, 2, 3), 77), (-1, -1, -1), (1, 1, 1)),
    # An ellipse turned by 45°: sqrt((a² + b²) / 2)
    (Ellipsoid((3, 1, 1)).rotate((0, 0, 1), 45), (-math.sqrt(5), -math.sqrt(5), -1), (math.sqrt(5), math.sqrt(5), 1)),
    (Ellipsoid.from_coefficients(4, 0.25, 1 / 9), (-0.5, -2, -3), (0.5, 2, 3)),
    (Box((0, 0, 0), (1, 2, 3)).rotate((0, 0, 1), 90), (-2, 0, 0), (0, 1, 3)),
    (Box().rotate((0, 0, 1), 45), (-R2, -R2, -1), (R2, R2, 1)),
    # An upright disc of radius r across (1, 1, 0): r / sqrt(2)
    (Cylinder((0, 0, 0), (1, 1, 0), 1), (-1 / R2, -1 / R2, -1), (1 + 1 / R2, 1 + 1 / R2, 1)),
    (Cylinder((0, 0, 0), (0, 0, 1), 2, 0, 90, (1, 0, 0)), (0, 0, 0), (2, 2, 1)),
    (Cylinder((0, 0, 0), (0, 0, 1), 2, 45, 135, (1, 0, 0)), (-R2, 0, 0), (R2, 2, 1)),
    (Cylinder((0, 0, 0), (0, 0, 1), 2, 0, 270, (1, 0, 0)), (-2, -2, 0), (2, 2, 1)),
    (Cylinder((0, 0, 0), (0, 0, 1), 2, 30, 60, (1, 0, 0)), (0, 0, 0), (R3, R3, 1)),
    (Cone((0, 0, 0), (0, 0, 4), 1, 3), (-3, -3, 0), (3, 3, 4)),
    (Cone((0, 0, 0), (4, 0, 0), 1, 0), (0, -1, -1), (4, 1, 1)),
    (DoubleCone(2), (-INF, -INF, -INF), (INF, INF, INF)),
    (DoubleCone(2, (-1, 3)), (-6, -6, -1), (6, 6, 3)),
    (DoubleCone(2, (0, INF)), (-INF, -INF, 0), (INF, INF, INF)),
    (EllipticParaboloid(1, 4), (-INF, -INF, 0), (INF, INF, INF)),
    (EllipticParaboloid(1, 4, (1, 4)), (-2, -1, 1), (2, 1, 4)),
    (EllipticParaboloid(1, 4, (-3, 4)), (-2, -1, 0), (2, 1, 4)),
    (EllipticParaboloid(1, 4).rotate((1, 0, 0), 90), (-INF, -INF, -INF), (INF, 0, INF)),
    (EllipticParaboloid(1, 4) & HalfSpace((0, 0, 1), -1), (INF, INF, INF), (-INF, -INF, -INF)),
    (OneSheetHyperboloid(1, 4, 1), (-INF, -INF, -INF), (INF, INF, INF)),
    (OneSheetHyperboloid(1, 4, 1, (-1, R3)), (-2, -1, -1), (2, 1, R3)),
    (TwoSheetHyperboloid(1, 1, 4), (-INF, -INF, -INF), (INF, INF, INF)),
    (TwoSheetHyperboloid(1, 1, 4, (0, INF)), (-INF, -INF, 0.5), (INF, INF, INF)),
    (TwoSheetHyperboloid(1, 1, 4, (-2, 1)), (-math.sqrt(15), -math.sqrt(15), -2), (math.sqrt(15), math.sqrt(15), 1)),
    (TwoSheetHyperboloid(1, 1, 4) & Box((-9, -9, -0.4), (9, 9, 0.4)), (INF, INF, INF), (-INF, -INF, -INF)),
    (EllipticCone(1, 4, 1, (-1, 2)), (-2, -1, -1), (2, 1, 2)),
    (EllipticCylinder(1, 4), (-1, -0.5, -INF), (1, 0.5, INF)),
    (EllipticCylinder(1, 4, (2, 3)).translate((0, 0, 1)), (-1, -0.5, 3), (1, 0.5, 4)),
    (EllipticCylinder(1, 4).rotate((0, 1, 0), 90), (-INF, -0.5, -1), (INF, 0.5, 1)),
    (HyperbolicParaboloid(1, 1), (-INF, -INF, -INF), (INF, INF, INF)),
    # z >= x² - y² reaches down to -1 in the box, where y = ±1
    (HyperbolicParaboloid(1, 1, Box((-1, -1, -2), (1, 1, 2))), (-1, -1, -1), (1, 1, 2)),
    (HyperbolicParaboloid(1, 1, Box((-2, 0, -9), (2, 0.5, 0))), (-0.5, 0, -0.25), (0.5, 0.5, 0)),
    (HyperbolicCylinder(1, 1), (-INF, -INF, -INF), (INF, INF, INF)),
    (HyperbolicCylinder(1, 1, Box((-9, -1, 0), (9, 1, 2))), (-R2, -1, 0), (R2, 1, 2)),
    (HyperbolicCylinder(1, 1) & Box((2, -1, 0), (9, 1, 2)), (INF, INF, INF), (-INF, -INF, -INF)),
    (HyperbolicCylinder(1, 1, Box((2, -2, 0), (9, 1, 2))), (2, -2, 0), (math.sqrt(5), -R3, 2)),
    (ParabolicCylinder(2), (-INF, 0, -INF), (INF, INF, INF)),
    (ParabolicCylinder(2).rotate((0, 0, 1), 90), (-INF, -INF, -INF), (0, INF, INF)),
    (ParabolicCylinder(2, Box((-9, -1, 0), (1, 4, 2))), (-4, 0, 0), (1, 4, 2)),
    # Turned by 45°: y - x over x² <= 4 y is least at x = 2, y = 1
    (ParabolicCylinder(2, Box((0, -1, 0), (9, 4, 2))).rotate((0, 0, 1), -45), (0, -1 / R2, 0), (8 / R2, 2 * R2, 2)),
    (HalfSpace((0, 0, -2), 3), (-INF, -INF, -1.5), (INF, INF, INF)),
    (HalfSpace((0, 1, 1), 0).rotate((1, 0, 0), 45), (-INF, -INF, -INF), (INF, INF, 0)),
    (HalfSpace((0, 1, 2), 0), (-INF, -INF, -INF), (INF, INF, INF)),
    (~HalfSpace((0, 0, -2), 3), (-INF, -INF, -INF), (INF, INF, -1.5)),
    (Polyhedron(((1, 1, 1), (-1, 0, 0), (0, -1, 0), (0, 0, -1)), (3, 0, 0, 0)), (0, 0, 0), (3, 3, 3)),
    (Polyhedron(((1, 0, 0), (-1, 0, 0)), (1, 1)), (-1, -INF, -INF), (1, INF, INF)),
    (Polyhedron(((1, 1, 0), (-1, -1, 0)), (1, 1)).rotate((0, 0, 1), 45), (-INF, -1 / R2, -INF), (INF, 1 / R2, INF)),
    (HEXAGON.rotate((0, 0, 1), 30), (-2, -R3, -INF), (2, R3, INF)),
    (HEXAGON.rotate((0, 0, 1), 170).rotate((0, 1, 0), -6).rotate((1, 0, 0), 119), (-INF, -INF, -INF), (INF, INF, INF)),
    (Polyhedron(((1, 0, 0), (-1, 0, 0)), (1, -2)), (INF, INF, INF), (-INF, -INF, -INF)),
    (Polyhedron(((1, 0, 0), (1, 1, 0), (1, -1, 0)), (5, 1, 1)), (-INF, -INF, -INF), (1, INF, INF)),
    (~Polyhedron(((1, 0, 0),), (1,)), (1, -INF, -INF), (INF, INF, INF)),
    (Quadric(coefficients=dict(xx=1, yy=0.25, zz=4, x=-2)), (0, -2, -0.5), (2, 2, 0.5)),
    # x² + x y + y² + z² <= 1: inverse of [[1, ½], [½, 1]] has 4/3 on the diagonal
    (Quadric(coefficients=dict(xx=1, yy=1, zz=1, xy=1, constant=-1)), (-2 / R3, -2 / R3, -1), (2 / R3, 2 / R3, 1)),
    (Quadric(coefficients=dict(xx=1, yy=1, z=-1, constant=2)), (-INF, -INF, 2), (INF, INF, INF)),
    (Quadric(coefficients=dict(xx=1, yy=1, z=1, constant=2)), (-INF, -INF, -INF), (INF, INF, -2)),
    (Quadric(coefficients=dict(xx=1, z=-1)), (-INF, -INF, 0), (INF, INF, INF)),
    (Quadric(coefficients=dict(xx=1, constant=-4)), (-2, -INF, -INF), (2, INF, INF)),
    # (x + y)² <= 2 is |x + y| <= sqrt(2), a slab of |x'| <= 1 across the diagonal
    (Quadric(coefficients=dict(xx=1, yy=1, xy=2, constant=-2)).rotate((0, 0, 1), 45), (-INF, -1, -INF), (INF, 1, INF)),
    (Quadric(coefficients=dict(xx=1, yy=1, zz=1, constant=1)), (INF, INF, INF), (-INF, -INF, -INF)),
    (Quadric(coefficients=dict(xx=1, yy=1, zz=1)), (0, 0, 0), (0, 0, 0)),
    (Quadric(coefficients=dict(xx=1, yy=1, x=-2, constant=1)), (1, 0, -INF), (1, 0, INF)),
    (Quadric(coefficients=dict(xx=-1)), (-INF, -INF, -INF), (INF, INF, INF)),
    (Quadric(coefficients=dict(xx=1, yy=-1)), (-INF, -INF, -INF), (INF, INF, INF)),
    (~Quadric(coefficients=dict(xx=-1, yy=-1, zz=-1, constant=4)), (-2, -2, -2), (2, 2, 2)),
    (Quadric(coefficients=dict(y=-2, constant=3)), (-INF, 1.5, -INF), (INF, INF, INF)),
    (~Quadric(coefficients=dict(y=-2, constant=3)), (-INF, -INF, -INF), (INF, 1.5, INF)),
]  # fmt: skip


@pytest.mark.parametrize(("shape", "low", "high"), KNOWN, ids=[repr(shape)[:70] for shape, _, _ in KNOWN])
def test_bounds_are_the_known_ones(shape, low, high) -> None:
    """Cuts by a box err outward on purpose, by the roundings of 64 terms and what a nearly flat quadric makes of them."""
    outward = 4e-12 if isinstance(shape, BoxedQuadric) else 1e-13
    for found, known, sign in zip(shape.bounds, (low, high), (-1.0, 1.0), strict=True):
        endless = np.isinf(known)
        assert (found[endless] == np.asarray(known)[endless]).all()
        known, found = np.asarray(known, float)[~endless], found[~endless]
        further = sign * (found - known)
        assert (further >= -1e-13 * np.abs(known) - 2e-14).all()
        assert (further <= outward * (np.abs(known) + 0.2)).all()


EXACT = [
    (Box((-3, 0, 0.1), (1, 2, 0.3)), (-3, 0, 0.1), (1, 2, 0.3)),
    (EllipticParaboloid(1, 4, (1, 4)), (-2, -1, 1), (2, 1, 4)),
    (EllipticCylinder(1, 4, (-1, 2)), (-1, -0.5, -1), (1, 0.5, 2)),
    (DoubleCone(2, (-1, 3)), (-6, -6, -1), (6, 6, 3)),
    (HyperbolicParaboloid(1, 1, Box()), (-1, -1, -1), (1, 1, 1)),
    (Quadric(coefficients=dict(xx=1, yy=0.25, zz=4, x=-2)), (0, -2, -0.5), (2, 2, 0.5)),
    (Polyhedron(((1, 1, 1), (-1, 0, 0), (0, -1, 0), (0, 0, -1)), (3, 0, 0, 0)), (0, 0, 0), (3, 3, 3)),
]


@pytest.mark.parametrize(("shape", "low", "high"), EXACT, ids=[type(shape).__name__ for shape, _, _ in EXACT])
def test_unmoved_bounds_are_exact_where_they_are_floats(shape, low, high) -> None:
    found_low, found_high = shape.bounds
    assert found_low.tolist() == list(low)
    assert found_high.tolist() == list(high)


@pytest.mark.parametrize("slope", [1e-90, 1e-60, 1.0, 1e80, 1e90])
def test_bounds_at_the_edge_of_the_domain(slope: float) -> None:
    """A double cone |(x, y)| <= slope |z| reaches as far as its wider end; slopes² are within float64, slopes⁴ are not."""
    low, high = DoubleCone(slope, z_range=(-1, 2)).bounds
    assert high.tolist() == pytest.approx([2 * slope, 2 * slope, 2], rel=1e-14)
    assert low.tolist() == pytest.approx([-2 * slope, -2 * slope, -1], rel=1e-14)
    assert np.isinf(DoubleCone(slope).bounds).all()


@pytest.mark.parametrize(
    ("degrees", "scale"), [(1e-75, 1e-90), (1e-90, 1.0), (1e-98, 1e-90), (1e-60, 1e60), (30, 1e-90)]
)
def test_bounds_of_paraboloids_that_hardly_lean(degrees: float, scale: float) -> None:
    """y cos a - z sin a over z = y² is most at y = cos a / (2 sin a); squares of the sine are below the least float."""
    angle = math.radians(degrees)
    bowl = EllipticParaboloid(1, 1).rotate((1, 0, 0), degrees).scale(scale)
    assert bowl.bounds.high[1] == pytest.approx(scale * math.cos(angle) ** 2 / (4 * math.sin(angle)), rel=1e-13)


def elliptic_solids(rng: np.random.Generator) -> list[EllipticSolid]:
    """One of each kind, some thin, and some whose lower end is where the surface begins."""
    a, e, h, c = (float(x) for x in rng.uniform(0.1, 2, 4))
    low = float(rng.uniform(-1, 1))
    high = low + float(rng.choice([2.0, 0.1, 1e-5, 1e-9]))
    return [
        EllipticCone(a, e, h, (low, high)),
        OneSheetHyperboloid(a, e, h, (low, high)),
        EllipticParaboloid(a, e, (min(low, 0.0), abs(high))),
        TwoSheetHyperboloid(a, e, h, (1 / math.sqrt(h) - 0.1 * abs(low), 1 / math.sqrt(h) + 1 + high)),
        DoubleCone(a, (low, high)),
        Ellipsoid((a, e, c), z_range=(0.9 * c * low, 0.9 * c * low + 0.05 * c * (high - low))),
        Ellipsoid((a, e, c), z_range=(c * (1 - 1e-3), 2 * c)),
        Ellipsoid((a, 1e57 * e, 1e-58 * c), z_range=(-0.9e-58 * c, 0.9e-58 * c)),  # products overflow
    ]


@pytest.mark.parametrize("seed", sampled(range(400), 20))
def test_supports_of_elliptic_solids_are_those_of_50_digits(seed: int) -> None:
    """Less by the rounding of a direction at most, which boxes add, and more by 1e-12 of the solid's size at most.

    They are u_z z + w sqrt(g) at ends and stationary heights.
    """
    rng = np.random.default_rng(seed)
    for solid in elliptic_solids(rng):
        direction = [
            float(x) for x in rng.normal(size=3) * rng.choice([1.0, 1e-3, 1e-160, 0.0], 3, p=[0.5, 0.2, 0.1, 0.2])
        ]
        with mp.workdps(50):
            sx, sy = (mp.mpf(Fraction(s).numerator) / Fraction(s).denominator for s in solid.squares)
            g0, g1, g2 = (mp.mpf(Fraction(g).numerator) / Fraction(g).denominator for g in solid.profile)
            ux, uy, uz = map(mp.mpf, direction)
            w = mp.sqrt(ux**2 / sx + uy**2 / sy)
            low, high = map(mp.mpf, solid.z_range)
            places = [low, high]
            # (w g')² = 4 u_z² g, and g = 0
            for p, q, r in (
                (4 * g2 * (w**2 * g2 - uz**2), 4 * g1 * (w**2 * g2 - uz**2), w**2 * g1**2 - 4 * uz**2 * g0),
                (g2, g1, g0),
            ):
                if p and q**2 >= 4 * p * r:
                    places += [(-q + sign * mp.sqrt(q**2 - 4 * p * r)) / (2 * p) for sign in (1, -1)]
                elif not p and q:
                    places.append(-r / q)
            heights = [(z, g0 + z * (g1 + z * g2)) for z in places if low <= z <= high]
            exact = max(uz * z + w * mp.sqrt(abs(g)) for z, g in heights if g > -(mp.mpf(10) ** -40))
            found = mp.mpf(solid.support(tuple(direction)))
            reach = max(abs(uz * z) + w * mp.sqrt(abs(g)) for z, g in heights)
            assert exact - mp.mpf(2) ** -52 * reach <= found <= exact + mp.mpf(10) ** -12 * reach
