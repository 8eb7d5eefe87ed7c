"""Bounds of solids: they hold them under every motion, and touch them; closed forms, and random cuts."""

import itertools
import math
import time
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from mpmath import mp

import conicoid as co
from conicoid.geometry import shape as shape_module
from conicoid.geometry.bounds.support import inverse_root, inverse_roots
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
from conicoid.geometry.shape import PrimitiveSolid, Solid
from conicoid.geometry.transform import IDENTITY_MOTION

from ..reference.forms import PAIRS, chain
from ..reference.items import Item, combined
from ..reference.numbers import number
from ..reference.quadratics import Table
from ..reference.random_items import SOLIDS, motion, plain, whole_motion
from ..reference.random_shapes import Random, generator, pick
from ..reference.solids import bodies
from ..reference.trace import body_at, truth
from ..samples import in_turn, many, sampled
from .samples import SAMPLES, Sample, carried, climb, contains, random_motion

# --- Bounds of solids that cut one another: closed forms, and random cuts against points that are inside


INF = math.inf
R2, R3, H3 = math.sqrt(2), math.sqrt(3), math.sqrt(3) / 2
C30, S30 = H3, 0.5


def below(z: float) -> co.HalfSpace:
    return co.HalfSpace((0, 0, 1), z)


def above(z: float) -> co.HalfSpace:
    return co.HalfSpace((0, 0, -1), -z)


def intersection(*parts: Solid) -> Solid:
    result = parts[0]
    for part in parts[1:]:
        result = result & part
    return result


CUBE = intersection(*(co.HalfSpace(tuple(s * (i == k) for k in range(3)), 1) for i in range(3) for s in (1, -1)))
PRISM = intersection(
    above(0), below(2), *(co.HalfSpace((math.cos(math.pi * k / 3), math.sin(math.pi * k / 3), 0), 1) for k in range(6))
)
SADDLE = HyperbolicParaboloid(1, 1)

KNOWN = {
    # Half-spaces alone
    "prism": (PRISM, (-1, -2 / R3, 0), (1, 2 / R3, 2)),
    "turned cube": (CUBE.rotate((0, 0, 1), 30), (-C30 - S30, -C30 - S30, -1), (C30 + S30, C30 + S30, 1)),
    "complement of their union": (~(~co.HalfSpace((1, 1, 0), 1) | co.HalfSpace((1, 0, 0), 0) | co.HalfSpace((0, 1, 0), 0)
                                    | below(-1) | above(2)), (0, 0, -1), (1, 1, 2)),
    "corner cut off": (co.Box((0, 0, 0), (1, 1, 1)) & co.HalfSpace((1, 1, 1), 0.5), (0, 0, 0), (0.5, 0.5, 0.5)),
    "wedge of two planes": (co.HalfSpace((1, 1, 0), 1) & co.HalfSpace((-1, 1, 0), 1), (-INF, -INF, -INF), (INF, 1, INF)),
    "two polyhedra": (co.Polyhedron(((1, 1, 0), (-1, -1, 0)), (1, 1)) & co.Polyhedron(((1, -1, 0), (-1, 1, 0)), (1, 1)),
                      (-1, -1, -INF), (1, 1, INF)),
    # A ball
    "cap": (co.Sphere() & above(0.5), (-H3, -H3, 0.5), (H3, H3, 1)),
    "ball without its cap": (co.Sphere() - below(0.5), (-H3, -H3, 0.5), (H3, H3, 1)),
    "ball with a flat": (co.Sphere() - above(0.5), (-1, -1, -1), (1, 1, 0.5)),
    "far cap": (co.Sphere(1, (1e6, 0, 0)) & above(0.5), (1e6 - H3, -H3, 0.5), (1e6 + H3, H3, 1)),
    "oblique half": (co.Sphere() & co.HalfSpace((1, 0, 1), 0), (-1, -1, -1), (1 / R2, 1, 1 / R2)),
    "oblique halves": (co.Sphere() & co.HalfSpace((1, 0, 1), 0) & co.HalfSpace((-1, 0, 1), 0), (-1 / R2, -1, -1), (1 / R2, 1, 0)),
    "needle eye": (co.Sphere() & co.HalfSpace((1, 0, 0), 0) & co.HalfSpace((-1, 0, 0), 0), (0, -1, -1), (0, 1, 1)),
    "lens": (co.Sphere() & co.Sphere(1, (1, 0, 0)), (0, -1, -1), (1, 1, 1)),
    "thin lens": (co.Sphere() & co.Sphere(1, (1.6, 0, 0)), (0.6, -0.8, -0.8), (1, 0.8, 0.8)),
    "ball beyond a plane": (co.Sphere() & above(1.5), (INF,) * 3, (-INF,) * 3),
    "ball outside of a corner": (co.Sphere() & intersection(*(co.HalfSpace(tuple(-1.0 * (i == k) for k in range(3)), -0.6)
                                                            for i in range(3))), (INF,) * 3, (-INF,) * 3),
    # x² + y² <= 1 and x + z <= 0 ...: the ellipse of the cut
    "slanted cylinder": (EllipticCylinder(1, 1) & co.HalfSpace((-1, 0, 1), 0) & co.HalfSpace((-1, 0, -1), 0),
                         (0, -1, -1), (1, 1, 1)),
    "quadric outside": (~co.Quadric(coefficients=dict(xx=-1, yy=-1, zz=1, constant=-1)) & above(0) & below(2),
                        (-R3, -R3, 1), (R3, R3, 2)),
    # The other quadrics between planes
    "paraboloid": (EllipticParaboloid(1, 2) & below(1.5), (-math.sqrt(1.5), -H3, 0), (math.sqrt(1.5), H3, 1.5)),
    # x² <= z <= x + 2 for -1 <= x <= 2; y² <= x + 2 - x² is largest at x = 1/2
    "slanted paraboloid": (EllipticParaboloid(1, 1) & co.HalfSpace((-1, 0, 1), 2), (-1, -1.5, 0), (2, 1.5, 4)),
    "quarter paraboloid": (EllipticParaboloid(1, 1) & co.HalfSpace((-1, 0, 0), 0), (0, -INF, 0), (INF, INF, INF)),
    "tower": (OneSheetHyperboloid(1, 4, 1) & above(-1) & below(R3), (-2, -1, -1), (2, 1, R3)),
    "bow tie": (DoubleCone(2) & above(-1) & below(3), (-6, -6, -1), (6, 6, 3)),
    "one nappe": (DoubleCone(2) & above(0), (-INF, -INF, 0), (INF, INF, INF)),
    # x² <= z², 2 z <= x + 3: the ellipse from x = -1, z = 1 to x = z = 3; its half-axis across is sqrt(3)
    "slanted cone": (DoubleCone(1) & above(0) & co.HalfSpace((-1, 0, 2), 3), (-1, -R3, 0), (3, R3, 3)),
    "bowls": (TwoSheetHyperboloid(1, 1, 4) & above(-2) & below(1),
              (-math.sqrt(15), -math.sqrt(15), -2), (math.sqrt(15), math.sqrt(15), 1)),
    "no bowl": (TwoSheetHyperboloid(1, 1, 4) & above(-0.4) & below(0.4), (INF,) * 3, (-INF,) * 3),
    # x² <= z + y² <= 1 + 4 and z >= -4
    "saddle": (SADDLE & below(1) & co.HalfSpace((0, 1, 0), 2) & co.HalfSpace((0, -1, 0), 2),
               (-math.sqrt(5), -2, -4), (math.sqrt(5), 2, 1)),
    "open saddle": (SADDLE & below(1), (-INF, -INF, -INF), (INF, INF, 1)),
    "half cylinder": (EllipticCylinder(1, 1) & co.HalfSpace((1, 0, 0), -0.5), (-1, -H3, -INF), (-0.5, H3, INF)),
    "half cylinder with an end": (EllipticCylinder(1, 1) & co.HalfSpace((1, 0, 0), -0.5) & above(3),
                                  (-1, -H3, 3), (-0.5, H3, INF)),
    "waist": (HyperbolicCylinder(1, 1) & co.HalfSpace((0, 1, 0), 1) & co.HalfSpace((0, -1, 0), 2),
              (-math.sqrt(5), -2, -INF), (math.sqrt(5), 1, INF)),
    "trough": (ParabolicCylinder(2) & co.HalfSpace((0, 1, 0), 4), (-4, 0, -INF), (4, 4, INF)),
    # Complements, differences and unions
    "POV-Ray 128": (EllipticParaboloid(1, 1) & co.Cylinder((0, 0, -1), (0, 0, 2), 5), (-R2, -R2, 0), (R2, R2, 2)),
    "POV-Ray 128, narrow": (EllipticParaboloid(1, 1) & co.Cylinder((0, 0, -1), (0, 0, 4), 1), (-1, -1, 0), (1, 1, 4)),
    "POV-Ray 315": (co.Sphere() - EllipticCylinder(4, 4), (-1, -1, -1), (1, 1, 1)),
    "De Morgan": (~(~co.Sphere() | below(0.5)), (-H3, -H3, 0.5), (H3, H3, 1)),
    "union cut": ((co.Sphere() | co.Sphere(1, (3, 0, 0))) & above(0.5), (-H3, -H3, 0.5), (3 + H3, H3, 1)),
    "cut union": ((co.Sphere() | co.Sphere(1, (3, 0, 0)) | co.Box((9, 9, -9), (10, 10, -8))) - below(0.5),
                  (-H3, -H3, 0.5), (3 + H3, H3, 1)),
    "nested": ((co.Sphere() & (above(0.5) | above(0.8))) - (co.HalfSpace((1, 0, 0), 0) & above(-2)), (0, -1, 0.5), (1, 1, 1)),
    "cone in a ball": (DoubleCone(0.5) & co.Sphere(), (-0.5, -0.5, -1), (0.5, 0.5, 1)),
    "box without a box": (co.Box() - co.Box((0, -2, -2), (2, 2, 2)), (-1, -1, -1), (1, 1, 1)),
    "wedge over a half turn": (co.Cylinder((0, 0, 0), (0, 0, 1), 2, 0, 270, (1, 0, 0)) & co.HalfSpace((-1, 0, 0), -1),
                               (1, -R3, 0), (2, R3, 1)),
    "cut cone": (co.Cone((0, 0, 0), (0, 0, 4), 2, 0) & above(1), (-1.5, -1.5, 1), (1.5, 1.5, 4)),
}  # fmt: skip


# Of radius R3 about the z-axis, endless along it
HEXAGON = co.Polyhedron(tuple((x, y * R3, 0) for s in (1, -1) for x, y in ((2 * s, 0), (s, s), (s, -s))), (2 * R3,) * 6)
PRIMITIVES = [
    (Ellipsoid((1, 2, 3), (5, 0, 0)), (4, -2, -3), (6, 2, 3)),
    # The widest section in the range is at z = 1: sqrt(1 - 1/9)
    (Ellipsoid((1, 2, 3), z_range=(1, 2)), (-2 * R2 / 3, -4 * R2 / 3, 1), (2 * R2 / 3, 4 * R2 / 3, 2)),
    (Ellipsoid((1, 2, 3), z_range=(-1, 9)), (-1, -2, -1), (1, 2, 3)),
    (Ellipsoid((1, 2, 3)) & co.HalfSpace((0, 0, -1), -4), (INF, INF, INF), (-INF, -INF, -INF)),
    # A ball of radius 1 turned by any angle
    (Ellipsoid((1, 1, 1)).rotate((1, 2, 3), 77), (-1, -1, -1), (1, 1, 1)),
    # An ellipse turned by 45°: sqrt((a² + b²) / 2)
    (Ellipsoid((3, 1, 1)).rotate((0, 0, 1), 45), (-math.sqrt(5), -math.sqrt(5), -1), (math.sqrt(5), math.sqrt(5), 1)),
    (Ellipsoid.from_coefficients(4, 0.25, 1 / 9), (-0.5, -2, -3), (0.5, 2, 3)),
    (co.Box((0, 0, 0), (1, 2, 3)).rotate((0, 0, 1), 90), (-2, 0, 0), (0, 1, 3)),
    (co.Box().rotate((0, 0, 1), 45), (-R2, -R2, -1), (R2, R2, 1)),
    # An upright disc of radius r across (1, 1, 0): r / sqrt(2)
    (co.Cylinder((0, 0, 0), (1, 1, 0), 1), (-1 / R2, -1 / R2, -1), (1 + 1 / R2, 1 + 1 / R2, 1)),
    (co.Cylinder((0, 0, 0), (0, 0, 1), 2, 0, 90, (1, 0, 0)), (0, 0, 0), (2, 2, 1)),
    (co.Cylinder((0, 0, 0), (0, 0, 1), 2, 45, 135, (1, 0, 0)), (-R2, 0, 0), (R2, 2, 1)),
    (co.Cylinder((0, 0, 0), (0, 0, 1), 2, 0, 270, (1, 0, 0)), (-2, -2, 0), (2, 2, 1)),
    (co.Cylinder((0, 0, 0), (0, 0, 1), 2, 30, 60, (1, 0, 0)), (0, 0, 0), (R3, R3, 1)),
    (co.Cone((0, 0, 0), (0, 0, 4), 1, 3), (-3, -3, 0), (3, 3, 4)),
    (co.Cone((0, 0, 0), (4, 0, 0), 1, 0), (0, -1, -1), (4, 1, 1)),
    (DoubleCone(2), (-INF, -INF, -INF), (INF, INF, INF)),
    (DoubleCone(2, (-1, 3)), (-6, -6, -1), (6, 6, 3)),
    (DoubleCone(2, (0, INF)), (-INF, -INF, 0), (INF, INF, INF)),
    (EllipticParaboloid(1, 4), (-INF, -INF, 0), (INF, INF, INF)),
    (EllipticParaboloid(1, 4, (1, 4)), (-2, -1, 1), (2, 1, 4)),
    (EllipticParaboloid(1, 4, (-3, 4)), (-2, -1, 0), (2, 1, 4)),
    (EllipticParaboloid(1, 4).rotate((1, 0, 0), 90), (-INF, -INF, -INF), (INF, 0, INF)),
    (EllipticParaboloid(1, 4) & co.HalfSpace((0, 0, 1), -1), (INF, INF, INF), (-INF, -INF, -INF)),
    (OneSheetHyperboloid(1, 4, 1), (-INF, -INF, -INF), (INF, INF, INF)),
    (OneSheetHyperboloid(1, 4, 1, (-1, R3)), (-2, -1, -1), (2, 1, R3)),
    (TwoSheetHyperboloid(1, 1, 4), (-INF, -INF, -INF), (INF, INF, INF)),
    (TwoSheetHyperboloid(1, 1, 4, (0, INF)), (-INF, -INF, 0.5), (INF, INF, INF)),
    (TwoSheetHyperboloid(1, 1, 4, (-2, 1)), (-math.sqrt(15), -math.sqrt(15), -2), (math.sqrt(15), math.sqrt(15), 1)),
    (TwoSheetHyperboloid(1, 1, 4) & co.Box((-9, -9, -0.4), (9, 9, 0.4)), (INF, INF, INF), (-INF, -INF, -INF)),
    (EllipticCone(1, 4, 1, (-1, 2)), (-2, -1, -1), (2, 1, 2)),
    (EllipticCylinder(1, 4), (-1, -0.5, -INF), (1, 0.5, INF)),
    (EllipticCylinder(1, 4, (2, 3)).translate((0, 0, 1)), (-1, -0.5, 3), (1, 0.5, 4)),
    (EllipticCylinder(1, 4).rotate((0, 1, 0), 90), (-INF, -0.5, -1), (INF, 0.5, 1)),
    (HyperbolicParaboloid(1, 1), (-INF, -INF, -INF), (INF, INF, INF)),
    # z >= x² - y² reaches down to -1 in the box, where y = ±1
    (HyperbolicParaboloid(1, 1, co.Box((-1, -1, -2), (1, 1, 2))), (-1, -1, -1), (1, 1, 2)),
    (HyperbolicParaboloid(1, 1, co.Box((-2, 0, -9), (2, 0.5, 0))), (-0.5, 0, -0.25), (0.5, 0.5, 0)),
    (HyperbolicCylinder(1, 1), (-INF, -INF, -INF), (INF, INF, INF)),
    (HyperbolicCylinder(1, 1, co.Box((-9, -1, 0), (9, 1, 2))), (-R2, -1, 0), (R2, 1, 2)),
    (HyperbolicCylinder(1, 1) & co.Box((2, -1, 0), (9, 1, 2)), (INF, INF, INF), (-INF, -INF, -INF)),
    (HyperbolicCylinder(1, 1, co.Box((2, -2, 0), (9, 1, 2))), (2, -2, 0), (math.sqrt(5), -R3, 2)),
    (ParabolicCylinder(2), (-INF, 0, -INF), (INF, INF, INF)),
    (ParabolicCylinder(2).rotate((0, 0, 1), 90), (-INF, -INF, -INF), (0, INF, INF)),
    (ParabolicCylinder(2, co.Box((-9, -1, 0), (1, 4, 2))), (-4, 0, 0), (1, 4, 2)),
    # Turned by 45°: y - x over x² <= 4 y is least at x = 2, y = 1
    (ParabolicCylinder(2, co.Box((0, -1, 0), (9, 4, 2))).rotate((0, 0, 1), -45), (0, -1 / R2, 0), (8 / R2, 2 * R2, 2)),
    (co.HalfSpace((0, 0, -2), 3), (-INF, -INF, -1.5), (INF, INF, INF)),
    (co.HalfSpace((0, 1, 1), 0).rotate((1, 0, 0), 45), (-INF, -INF, -INF), (INF, INF, 0)),
    (co.HalfSpace((0, 1, 2), 0), (-INF, -INF, -INF), (INF, INF, INF)),
    (~co.HalfSpace((0, 0, -2), 3), (-INF, -INF, -INF), (INF, INF, -1.5)),
    (co.Polyhedron(((1, 1, 1), (-1, 0, 0), (0, -1, 0), (0, 0, -1)), (3, 0, 0, 0)), (0, 0, 0), (3, 3, 3)),
    (co.Polyhedron(((1, 0, 0), (-1, 0, 0)), (1, 1)), (-1, -INF, -INF), (1, INF, INF)),
    (co.Polyhedron(((1, 1, 0), (-1, -1, 0)), (1, 1)).rotate((0, 0, 1), 45), (-INF, -1 / R2, -INF), (INF, 1 / R2, INF)),
    (HEXAGON.rotate((0, 0, 1), 30), (-2, -R3, -INF), (2, R3, INF)),
    (HEXAGON.rotate((0, 0, 1), 170).rotate((0, 1, 0), -6).rotate((1, 0, 0), 119), (-INF, -INF, -INF), (INF, INF, INF)),
    (co.Polyhedron(((1, 0, 0), (-1, 0, 0)), (1, -2)), (INF, INF, INF), (-INF, -INF, -INF)),
    (co.Polyhedron(((1, 0, 0), (1, 1, 0), (1, -1, 0)), (5, 1, 1)), (-INF, -INF, -INF), (1, INF, INF)),
    (~co.Polyhedron(((1, 0, 0),), (1,)), (1, -INF, -INF), (INF, INF, INF)),
    (co.Quadric(coefficients=dict(xx=1, yy=0.25, zz=4, x=-2)), (0, -2, -0.5), (2, 2, 0.5)),
    # x² + x y + y² + z² <= 1: inverse of [[1, ½], [½, 1]] has 4/3 on the diagonal
    (co.Quadric(coefficients=dict(xx=1, yy=1, zz=1, xy=1, constant=-1)), (-2 / R3, -2 / R3, -1), (2 / R3, 2 / R3, 1)),
    (co.Quadric(coefficients=dict(xx=1, yy=1, z=-1, constant=2)), (-INF, -INF, 2), (INF, INF, INF)),
    (co.Quadric(coefficients=dict(xx=1, yy=1, z=1, constant=2)), (-INF, -INF, -INF), (INF, INF, -2)),
    (co.Quadric(coefficients=dict(xx=1, z=-1)), (-INF, -INF, 0), (INF, INF, INF)),
    (co.Quadric(coefficients=dict(xx=1, constant=-4)), (-2, -INF, -INF), (2, INF, INF)),
    # (x + y)² <= 2 is |x + y| <= sqrt(2), a slab of |x'| <= 1 across the diagonal
    (co.Quadric(coefficients=dict(xx=1, yy=1, xy=2, constant=-2)).rotate((0, 0, 1), 45), (-INF, -1, -INF), (INF, 1, INF)),
    (co.Quadric(coefficients=dict(xx=1, yy=1, zz=1, constant=1)), (INF, INF, INF), (-INF, -INF, -INF)),
    (co.Quadric(coefficients=dict(xx=1, yy=1, zz=1)), (0, 0, 0), (0, 0, 0)),
    (co.Quadric(coefficients=dict(xx=1, yy=1, x=-2, constant=1)), (1, 0, -INF), (1, 0, INF)),
    (co.Quadric(coefficients=dict(xx=-1)), (-INF, -INF, -INF), (INF, INF, INF)),
    (co.Quadric(coefficients=dict(xx=1, yy=-1)), (-INF, -INF, -INF), (INF, INF, INF)),
    (~co.Quadric(coefficients=dict(xx=-1, yy=-1, zz=-1, constant=4)), (-2, -2, -2), (2, 2, 2)),
    (co.Quadric(coefficients=dict(y=-2, constant=3)), (-INF, 1.5, -INF), (INF, INF, INF)),
    (~co.Quadric(coefficients=dict(y=-2, constant=3)), (-INF, -INF, -INF), (INF, 1.5, INF)),
]  # fmt: skip


@pytest.mark.parametrize(("shape", "low", "high"), [*PRIMITIVES, *KNOWN.values()], ids=lambda value: repr(value)[:70])
def test_bounds_are_the_known_ones(shape, low, high) -> None:
    """Cuts err outward on purpose, by the roundings of many terms and of nearly flat quadrics."""
    outward = 1e-11 if not isinstance(shape, PrimitiveSolid) else 4e-12 if isinstance(shape, BoxedQuadric) else 1e-13
    for found, known, sign in zip(shape.bounds, (low, high), (-1.0, 1.0), strict=True):
        endless = np.isinf(known)
        assert (found[endless] == np.asarray(known)[endless]).all()
        known, found = np.asarray(known, float)[~endless], found[~endless]
        further = sign * (found - known)
        assert (further >= -1e-13 * np.abs(known) - 2e-14).all()
        assert (further <= outward * (np.abs(known) + 0.2)).all()


@pytest.mark.parametrize("scale", [1e-90, 1e-9, 1e9, 1e90])
def test_bounds_scale_with_the_solid(scale: float) -> None:
    cap = co.Sphere(scale) & co.HalfSpace((0, 0, -1), -scale / 2)
    cup = EllipticParaboloid(1 / scale, 2 / scale) & co.HalfSpace((0, 0, 1), 1.5 * scale)
    for shape, name in ((cap, "cap"), (cup, "paraboloid")):
        for found, expected in zip(shape.bounds, KNOWN[name][1:], strict=True):
            np.testing.assert_allclose(found / scale, expected, rtol=1e-11, atol=1e-12)


CONVEX = [
    co.Sphere(1.2),
    Ellipsoid((1, 2, 0.5)),
    EllipticParaboloid(1, 3),
    EllipticCylinder(1, 4),
    ParabolicCylinder(0.5),
]
OTHERS = [
    OneSheetHyperboloid(1, 2, 3),
    TwoSheetHyperboloid(1, 2, 3),
    DoubleCone(0.7),
    SADDLE,
    HyperbolicCylinder(1, 4),
    co.Quadric(coefficients=dict(xx=1, yy=-1, xy=0.5, z=1, x=0.3, constant=0.1)),
]


@pytest.mark.parametrize(
    ("quadric", "seed"),
    in_turn(CONVEX + OTHERS, range(3)),
    ids=lambda value: value if isinstance(value, int) else type(value).__name__,
)
def test_random_cuts_hold_the_solid_and_touch_it(quadric, seed: int) -> None:
    """Points that climb along each axis stay within the bounds, and reach them on convex solids."""
    rng = np.random.default_rng([seed, 7])
    normals = rng.normal(size=(rng.integers(1, 7), 3))
    offsets = rng.uniform(0.2, 1.5, len(normals))
    planes = [co.HalfSpace(tuple(n), d) for n, d in zip(normals.tolist(), offsets.tolist(), strict=True)]
    motion = random_motion(rng)
    low, high = intersection(quadric, *planes).bounds_under(motion)
    parts = [quadric.tree(), *(plane.tree() for plane in planes)]

    def inside(points):
        return np.all([contains(part, points, IDENTITY_MOTION) for part in parts], axis=0)

    points = rng.normal(size=(20000, 3)) * 10 ** rng.uniform(-1, 1, (20000, 1))
    points = points[inside(points)]
    assert len(points) > 100
    for axis in range(3):
        for sign, end in ((1, high[axis]), (-1, -low[axis])):
            direction, shift = sign * motion.matrix[axis, :3], sign * motion.matrix[axis, 3]
            reached = climb(inside, direction, points, rng, 250 if math.isfinite(end) else 60) @ direction + shift
            assert reached <= end + 1e-13 * (abs(reached) + 1)
            if quadric in CONVEX and math.isfinite(end):
                assert end - reached <= 1e-6 * (1 + abs(end))
            if quadric in CONVEX and math.isinf(end):
                assert reached > 30


def test_thousands_of_holes_and_deep_trees_stay_quick() -> None:
    """The limit bounds the work, not the time. Both would take minutes if they tried every candidate."""
    started = time.process_time()
    plate = co.Box((0, 0, 0), (100, 100, 1))
    for k in range(1000):
        plate = plate - co.Cylinder((k % 50, k // 50, -1), (k % 50, k // 50, 2), 0.3)
    assert [end.tolist() for end in plate.bounds] == [[0, 0, 0], [100, 100, 1]]
    body: Solid = co.Sphere()
    for k in range(300):
        body = co.Sphere(1 + k / 300) - (body & co.HalfSpace((1, k, 0), k))
    low, high = body.bounds
    assert (low >= -2).all()
    assert (high <= 2).all()
    facets = [co.HalfSpace((math.cos(k), math.sin(k), math.cos(7 * k)), 1.5) for k in range(60)]
    low, high = intersection(co.Sphere(), *facets).bounds
    assert (low >= -1).all()
    assert (high <= 1).all()
    assert time.process_time() - started < 30


# --- Boxes around intersections of balls and boxes: against the closed form of a lens, and the same alone and together


@pytest.mark.parametrize("reach", [0.25, 1.0, 1.5])
def test_a_turned_lens(reach: float) -> None:
    """A ball of radius 2 is about the origin, and one of radius 3 beside it along x, turned about z and x.

    The second ends at x = reach. The box of both cuts the first there: across x it reaches sqrt(4 - reach²), where the
    second ball is wide enough.
    """
    lens = (co.Sphere(2) & co.Sphere(3, (reach - 3, 0, 0))).rotate("x", 40)
    low, high = lens.bounds
    assert (low[0], high[0]) == pytest.approx((-2, reach), abs=1e-11)
    assert high[0] >= reach
    second = math.sqrt(9 - max(0.0, -2 - (reach - 3)) ** 2)
    assert high[1] == pytest.approx(min(2.0, second), rel=1e-11)


# --- Bounds of pairs of quadrics under motions: they exist, and hold points that are certainly inside


FAST, DEEP = 30, 120


def test_a_residue_is_no_height() -> None:
    # Above the bowl z >= 0, by formula and in floats
    low, high = (co.EllipticParaboloid(2, 0.5) & co.DoubleCone(1.5)).scale((1, 2, 0.5)).bounds
    assert low.tolist() == [-math.inf, -math.inf, 0]
    assert (high == math.inf).all()
    bow = co.HyperbolicParaboloid(2, 0.5) & co.DoubleCone(0.5, (0, 2))
    low, high = bow.rotate((1, 2, 3), 15).bounds
    # The apex, where all of it ends
    assert low[2] == 0
    assert np.isfinite([low, high]).all()
    # The same without a turn: z <= 2 and x² + y² <= z² / 4
    np.testing.assert_allclose(bow.bounds, [(-1, -1, 0), (1, 1, 2)], rtol=1e-9)


@pytest.mark.parametrize("residue", [5e-324, 1e-300, 1e-100, 1e-17])
def test_a_plane_beside_the_vertex_costs_no_digits(residue: float) -> None:
    """A box's side may stand there. The bowl x² + y² <= z, z <= 4 is 2 wide."""
    from conicoid.geometry.bounds.quadric_extent import cut_quadric_bounds
    from conicoid.geometry.surface import PlaneSurface, QuadricSurface

    bowl = QuadricSurface((1.0, 1.0, 0.0), (0.0, 0.0, -0.5), 0.0)
    for end in (residue, -residue):
        planes = [PlaneSurface((0.0, 0.0, -1.0), end), PlaneSurface((0.0, 0.0, 1.0), 4.0)]
        low, high = cut_quadric_bounds(bowl, planes)
        np.testing.assert_allclose([*low, *high], [-2, -2, 0, 2, 2, 4], rtol=1e-12, atol=1e-12)


def exact_bounds(solid: Any) -> Any:
    """Return the box of `geometry.bounds`, in numbers of 3000 bits."""
    return solid.bounds


def prepared_bounds(solid: Any) -> Any:
    """Return the box of `prepare.csg_plan`, in floats."""
    box = co.Scene([solid])._prepared.lowered.boxes[0]
    return box[:3], box[3:]


def random_pair(r: Random) -> Item:
    """Return two shapes, the second moved against the first, and the part of the first inside or outside of the second."""
    parts = [plain(r, str(pick(r, SOLIDS))) for _ in range(2)]
    return combined(
        str(pick(r, ("Intersection", "Intersection", "Difference"))), parts[0], parts[1].moved(*whole_motion(r))
    )


def check_pairs(seed: int, count: int, bounds: Callable[[Any], Any] = exact_bounds) -> int:
    """Compare points with bounds; return how many."""
    checked = 0
    for k in range(count):
        r = generator(f"pairs {seed}", k)
        pair = random_pair(r)
        moved = pair.moved(*motion(r))
        low, high = bounds(moved.shape(co))
        assert not np.isnan([low, high]).any(), moved
        there = chain(moved.exact_steps)
        for point in extreme_points(pair, there, r):
            for x, least, most in zip(there.point(point), low.tolist(), high.tolist(), strict=True):
                assert least == -math.inf or (x - number(least)).sign >= 0, (moved, point)
                assert most == math.inf or (number(most) - x).sign >= 0, (moved, point)
            checked += 1
    return checked


def extreme_points(pair: Item, there: Any, r: Random) -> list[list[float]]:
    """Return points that are inside in exact arithmetic, far out along the world's axes."""
    table = Table(bodies([pair]))

    def seems(points: np.ndarray) -> np.ndarray:
        """Return which points are inside in floats."""
        whole = np.concatenate([points, np.ones((len(points), 1))], axis=1).T
        products = np.array([whole[i] * whole[j] for i, j in PAIRS])
        return truth(
            table.bodies[0].formula,
            lambda forms: np.all([np.array([*map(float, form.k)]) @ products <= 0 for form in forms], axis=0),
        )

    grid = r.integers(-8, 9, (300, 3)) / 4
    points = np.concatenate([np.zeros((1, 3)), grid, r.normal(size=(500, 3)) * 10 ** r.uniform(-1, 1, (500, 1))])
    points = points[seems(points)]
    found = points[:3].tolist()
    for row in there.rows if len(points) > 3 else ():
        for direction in np.array([*map(float, row)]) * [[1], [-1]]:
            found.append(climb(seems, direction, points, r, 12, 20).tolist())
    inside = body_at(table, np.array(found)) if found else ()
    return [point for point, body in zip(found, inside, strict=True) if body == 0]


@pytest.mark.parametrize("bounds", [exact_bounds, prepared_bounds])
@pytest.mark.parametrize("seed", sampled(range(11), 11))
def test_bounds_contain_all_points_inside(seed: int, bounds: Callable[[Any], Any]) -> None:
    count = many(FAST, DEEP)
    assert check_pairs(seed, count, bounds) > count


def test_prepared_bounds_are_as_tight_as_exact_ones() -> None:
    drawn = [generator("pairs 12", k) for k in range(FAST)]
    solids = [random_pair(r).moved(*motion(r)).shape(co) for r in drawn]
    boxes = co.Scene(solids)._prepared.lowered.boxes
    finite = np.isfinite(boxes).all(axis=1)
    assert finite.sum() > FAST // 2
    for k, solid in enumerate(solids):
        exact, box = np.concatenate(solid.bounds), boxes[k]
        if finite[k]:
            # Infinite exact ends would be as if the box were tighter
            wider, size = np.maximum(exact[:3] - box[:3], box[3:] - exact[3:]), (exact[3:] - exact[:3]).max()
            assert (wider <= 1e-6 * size).all(), k
        # In a scene of many the same as alone, to the bit
        np.testing.assert_array_equal(box, np.concatenate(prepared_bounds(solid)))


UP, DOWN = co.HalfSpace((0, 0, -1), -1), co.HalfSpace((0, 0, 1), 4)
SQUARE = [co.HalfSpace(n, 2) for n in ((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0))]
WIDE = math.sqrt(2.0**60 + 16 * 2.0**30)
BESIDE_CONE = co.Intersection((*SQUARE, UP, co.Complement(co.DoubleCone(0.5)) | co.HalfSpace((0, 0, 1), 0)))
ENDLESS = {
    "a cone between planes": (co.DoubleCone(0.5) & UP & DOWN, (-2, -2, 1), (2, 2, 4)),
    "a bowl below a plane": (co.EllipticParaboloid(1, 1) & DOWN, (-2, -2, 0), (2, 2, 4)),
    "a cone between planes below its apex": (
        co.DoubleCone(0.5) & co.HalfSpace((0, 0, -1), 4) & co.HalfSpace((0, 0, 1), -1), (-2, -2, -4), (2, 2, -1)
    ),
    "what the outside of a hyperboloid leaves": (
        co.Complement(co.Quadric(coefficients=dict(xx=-1, yy=-1, zz=1, constant=1))) & UP & DOWN,
        (-math.sqrt(17), -math.sqrt(17), 1), (math.sqrt(17), math.sqrt(17), 4),
    ),
    "a sector of a cone, to its apex": (
        co.DoubleCone(0.5) & DOWN & co.HalfSpace((0, 0, -1), 0) & co.HalfSpace((1, 1, 0), 0) & co.HalfSpace((1, -1, 0), 0),
        (-2, -math.sqrt(2), 0), (0, math.sqrt(2), 4),
    ),
    "a square bar beside a cone": (BESIDE_CONE, (-2, -2, 1), (2, 2, math.sqrt(32))),
    "and in a union without an end": (
        co.Intersection((co.HalfSpace((0, 0, -1), -2) | co.Sphere(1.5), BESIDE_CONE)), (-2, -2, 1), (2, 2, math.sqrt(32))
    ),
    # x² + y² - 2^31 x <= 2^30 z²: so flat that the surface is written about the origin
    "a hyperboloid far from its center": (
        co.Quadric(coefficients=dict(xx=2.0**-30, yy=2.0**-30, zz=-1, x=-2)) & UP & DOWN,
        (2.0**30 - WIDE, -WIDE, 1), (2.0**30 + WIDE, WIDE, 4),
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", ENDLESS)
def test_floats_bound_planes_quadrics_and_unions_together(name: str, monkeypatch: Any) -> None:
    """The solids are z <= 4, or z <= 2 r where |x|, |y| <= 2. Exact bounds of such nodes of decks took 80 ms a body."""
    monkeypatch.setattr(shape_module, "region_bounds", None)
    solid, low, high = ENDLESS[name]
    shifts = np.arange(8.0)[:, None] * (1, 2, 3)
    boxes = co.Scene([solid.translate(tuple(to)) for to in shifts.tolist()])._prepared.lowered.boxes
    found, expected = boxes - np.tile(shifts, 2), np.array([*low, *high])
    outward = (found - expected) * [-1, -1, -1, 1, 1, 1] / max(25, np.abs(expected).max())
    assert (outward >= -1e-14).all()
    assert (outward <= 1.6e-7).all()


OBLIQUE = co.HalfSpace((1, 2, 3), 0.5)
UNBOUNDED = {
    "a half-space less an intersection": (below(0.5) - (co.Box() & co.Sphere(0.7)), (-INF,) * 3, (INF, INF, 0.5)),
    "an oblique half-space, and a difference": (OBLIQUE | (co.Sphere(1) - (co.Sphere(1) | co.Box())), (-INF,) * 3, (INF,) * 3),
    "a half-space less a lens, and a difference of them": (
        (OBLIQUE - co.Lens(7, -7, thickness=1, diameter=2)) | (co.Sphere(1) - (co.Sphere(2) - co.Box())), (-INF,) * 3, (INF,) * 3
    ),
    "an oblique slab": (OBLIQUE - co.HalfSpace((1, 2, 3), -0.5), (-INF,) * 3, (INF,) * 3),
    "an oblique wedge": (OBLIQUE & co.HalfSpace((3, -1, 0.5), 1), (-INF,) * 3, (INF,) * 3),
    "an oblique pyramid without an end": (
        co.Intersection((OBLIQUE, co.HalfSpace((1.5, 2, 3), 1), co.HalfSpace((1, 2.5, 3), 1))), (-INF,) * 3, (INF,) * 3
    ),
    "an upright slab below an oblique plane": (
        below(1) & co.HalfSpace((0, 0, -1), 0) & OBLIQUE, (-INF, -INF, 0), (INF, INF, 1)
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", UNBOUNDED)
def test_floats_show_that_a_body_has_no_end(name: str, monkeypatch: Any) -> None:
    """Exact bounds of such bodies took 4 to 13 ms each."""
    monkeypatch.setattr(shape_module, "region_bounds", None)
    solid, low, high = UNBOUNDED[name]
    shifts = np.arange(8.0)[:, None] * (1, 2, 4)
    boxes = co.Scene([solid.translate(tuple(to)) for to in shifts.tolist()])._prepared.lowered.boxes
    np.testing.assert_array_equal(boxes - np.tile(shifts, 2), np.tile([*low, *high], (8, 1)))


def test_planes_along_one_axis_bound_bodies_that_floats_do_not() -> None:
    """x + y <= 1 and x - y <= 1 give x <= 1 for all z."""
    bars = [co.HalfSpace((1, 1, 0), 1) & co.HalfSpace((1, -1, 0), 1 + k) for k in range(8)]
    boxes = co.Scene(bars)._prepared.lowered.boxes
    np.testing.assert_array_equal(boxes[:, :3], -INF)
    np.testing.assert_array_equal(boxes[:, 3:], [(1 + 0.5 * k, INF, INF) for k in range(8)])


def test_floats_show_that_a_body_is_empty(monkeypatch: Any) -> None:
    """x + y + z of a unit ball is at most sqrt(3), and of its box 3."""
    monkeypatch.setattr(shape_module, "region_bounds", None)
    caps = [co.Sphere(1) & co.HalfSpace((-1, -1, -1), -1.8 - 0.1 * k) for k in range(8)]
    boxes = co.Scene(caps)._prepared.lowered.boxes
    assert (boxes == [math.inf] * 3 + [-math.inf] * 3).all()


@pytest.mark.parametrize("degrees", [0, 20])
def test_a_body_as_thin_as_rounding_is_not_empty(degrees: float) -> None:
    """Caps of a ball of radius 5, and corners of a box of 6 x 8 x 2, by 3 x + 4 y >= 25 less a depth, hold (3, 4, 0)."""
    depths = [0.0, *(10.0**-k for k in range(1, 17))]
    planes = [co.HalfSpace((-3, -4, 0), depth - 25) for depth in depths]
    solids = [solid & plane for solid in (co.Sphere(5), co.Box((-3, -4, -1), (3, 4, 1))) for plane in planes]
    boxes = co.Scene([solid.rotate("z", degrees) for solid in solids])._prepared.lowered.boxes
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    place = np.array((3 * c - 4 * s, 3 * s + 4 * c, 0.0))
    assert (boxes[:, :3] <= place + 2e-15).all()
    assert (boxes[:, 3:] >= place - 2e-15).all()


def test_prepared_bounds_of_a_body_as_thin_as_the_rounding_of_its_place():
    """The body is sixteen steps of a float thick, far from the origin. The point is inside by exact fractions."""
    center = 1024.0
    thick = 8 * math.ulp(center)
    flat, round_, plane = (
        co.Ellipsoid((1, 1, thick), (0, 0, center)), co.Ellipsoid((1.5, 0.5, 2.0), (0, 0.6, center)),
        co.HalfSpace((-20 * thick, 0, 1), center),
    )  # fmt: skip
    for parts in itertools.permutations((flat, round_, plane)):
        low, high = prepared_bounds(co.Intersection(parts))
        assert (low <= (0.9, 0.25, center)).all()
        assert (high >= (0.9, 0.25, center)).all()


# --- Bounds of primitives under motions, and the supports that make them


@pytest.mark.parametrize("sample", sampled([s for s in SAMPLES if s.bounded], 4), ids=lambda sample: sample.name)
def test_bounds_hold_and_touch_the_solid(sample: Sample) -> None:
    """A population of points inside the inequality reaches each side."""
    rng = np.random.default_rng(11)
    start = rng.uniform(-sample.reach, sample.reach, (50000, 3))
    start = start[sample.inside(*start.T)]
    for turn in (random_motion(rng) for _ in range(2)):
        low, high = sample.shape.bounds_under(turn)
        world = carried(turn, start)
        assert (world >= low).all()
        assert (world <= high).all()
        for axis in range(3):
            for sign, side in ((1, high[axis]), (-1, -low[axis])):
                direction = sign * turn.matrix[axis, :3]
                reached = climb(lambda p: sample.inside(*p.T), direction, start, rng, 250, 100) @ direction
                reached += sign * turn.matrix[axis, 3]
                assert reached <= side + 1e-14 * (high - low).max()
                assert side - reached <= 1e-4 * (high - low).max()


@pytest.mark.parametrize("sample", [s for s in SAMPLES if not s.bounded], ids=lambda sample: sample.name)
def test_bounds_of_unbounded_solids_hold_them(sample: Sample) -> None:
    rng = np.random.default_rng(13)
    points = rng.uniform(-1, 1, (20000, 3)) * 10 ** rng.uniform(-2, 4, (20000, 1))
    points = points[sample.inside(*points.T)]
    for turn in (random_motion(rng) for _ in range(3)):
        low, high = sample.shape.bounds_under(turn)
        world = carried(turn, points)
        assert (world >= low).all()
        assert (world <= high).all()


EXACT = [
    (co.Box((-3, 0, 0.1), (1, 2, 0.3)), (-3, 0, 0.1), (1, 2, 0.3)),
    (EllipticParaboloid(1, 4, (1, 4)), (-2, -1, 1), (2, 1, 4)),
    (EllipticCylinder(1, 4, (-1, 2)), (-1, -0.5, -1), (1, 0.5, 2)),
    (DoubleCone(2, (-1, 3)), (-6, -6, -1), (6, 6, 3)),
    (HyperbolicParaboloid(1, 1, co.Box()), (-1, -1, -1), (1, 1, 1)),
    (co.Quadric(coefficients=dict(xx=1, yy=0.25, zz=4, x=-2)), (0, -2, -0.5), (2, 2, 0.5)),
    (co.Polyhedron(((1, 1, 1), (-1, 0, 0), (0, -1, 0), (0, 0, -1)), (3, 0, 0, 0)), (0, 0, 0), (3, 3, 3)),
]


@pytest.mark.parametrize(("shape", "low", "high"), EXACT, ids=[type(shape).__name__ for shape, _, _ in EXACT])
def test_unmoved_bounds_are_exact_where_they_are_floats(shape, low, high) -> None:
    found_low, found_high = shape.bounds
    assert found_low.tolist() == list(low)
    assert found_high.tolist() == list(high)


@pytest.mark.parametrize("slope", [1e-90, 1e-60, 1.0, 1e80, 1e90])
def test_bounds_at_the_edge_of_the_domain(slope: float) -> None:
    """A double cone |(x, y)| <= slope |z| reaches as far as its wider end. slopes² are within float64, slopes⁴ are not."""
    low, high = DoubleCone(slope, z_range=(-1, 2)).bounds
    assert high.tolist() == pytest.approx([2 * slope, 2 * slope, 2], rel=1e-14)
    assert low.tolist() == pytest.approx([-2 * slope, -2 * slope, -1], rel=1e-14)
    assert np.isinf(DoubleCone(slope).bounds).all()


@pytest.mark.parametrize(
    ("degrees", "scale"), [(1e-75, 1e-90), (1e-90, 1.0), (1e-98, 1e-90), (1e-60, 1e60), (30, 1e-90)]
)
def test_bounds_of_paraboloids_that_hardly_lean(degrees: float, scale: float) -> None:
    """y cos a - z sin a over z = y² is at most y = cos a / (2 sin a). Squares of the sine are below the least float."""
    angle = math.radians(degrees)
    bowl = EllipticParaboloid(1, 1).rotate((1, 0, 0), degrees).scale(scale)
    assert bowl.bounds.high[1] == pytest.approx(scale * math.cos(angle) ** 2 / (4 * math.sin(angle)), rel=1e-13)


def test_inverse_roots_are_not_below_the_exact_ones() -> None:
    """The test uses fractions, squares of floats, and numbers far from 1. 1 / math.sqrt may be two floats below."""
    rng, low = np.random.default_rng(5), 1.0201057368024755
    numbers = np.concatenate(
        [[low], rng.uniform(0.1, 3, 5000), np.arange(1.0, 40) ** 2, 2.0 ** np.arange(-300, 300, 7)]
    )
    assert Fraction(low) * Fraction(math.nextafter(1 / math.sqrt(low), 2)) ** 2 < 1
    for square, root in zip(numbers.tolist(), inverse_roots(numbers).tolist(), strict=True):
        assert root == inverse_root(square)
        assert Fraction(square) * Fraction(root) ** 2 >= 1
        assert Fraction(square) * Fraction(math.nextafter(math.nextafter(root, 0), 0)) ** 2 < 1


def elliptic_solids(rng: np.random.Generator) -> list[EllipticSolid]:
    """Return one of each kind, some thin, and some whose lower end is where the surface begins."""
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
    """Supports are less by at most the rounding of a direction, and more by at most 1e-12 of the solid's size.

    Boxes add that rounding. Supports are u_z z + w sqrt(g) at ends and stationary heights.
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
