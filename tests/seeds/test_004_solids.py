"""Seed 004: convex solids of several quadric inequalities, and its programs, each with a number worked out by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

import conicoid as co

from .along import CLOSE, first, flat, spans

ROOT2, ROOT3 = math.sqrt(2), math.sqrt(3)


def test_kvadr_the_quadratic():
    """t² - 3 t + 2: the parabolic cylinder x² <= 2 G y, G = 1/2, along (1, 3, 0) from (0, -2): t² = 3 t - 2."""
    assert flat(spans(co.ParabolicCylinder(0.5), (0, -2, 0), (1, 3, 0))) == pytest.approx([1, 2], **CLOSE)


def test_kvadr_does_not_cancel():
    """t² - 2 (10⁸ + 10⁻⁸) t + 4 = 0 has the roots 2·10⁸ and 2·10⁻⁸: x² = y from y = -4 with slope 2 (10⁸ + 10⁻⁸).

    Near t = 2·10⁻⁸ the textbook formula is wrong in every digit.
    """
    slope = 2e8 + 2e-8  # rounds to 2·10⁸: the small root is 4 / (slope + √(slope² - 16)) = 4 / (4·10⁸ - 8·10⁻⁸ …)
    small = 4 / (slope / 2 + math.sqrt(slope / 2 - 2) * math.sqrt(slope / 2 + 2))
    found = flat(spans(co.ParabolicCylinder(0.5), (0, -4, 0), (1, slope, 0)))
    assert found == pytest.approx([small, 4 / small], rel=4e-16)


def test_allips_the_ellipsoid():
    """x² / 4 + y² / 9 + z² = 1 along the diagonal of the first quadrant at z = 0: t² (1/4 + 1/9) = 1."""
    shape = co.Ellipsoid((2, 3, 1))
    reach = 6 / math.sqrt(13)
    assert flat(spans(shape, (-9, -9, 0), (1, 1, 0))) == pytest.approx([9 - reach, 9 + reach], **CLOSE)
    hit = first(shape, (-9, -9, 0), (1, 1, 0))
    # gradient (x/2, 2y/9) at x = y < 0: (9, 4) / √97
    assert hit.normal == pytest.approx(np.array([-9, -4, 0]) / math.sqrt(97), **CLOSE)


def test_alloid_the_truncated_ellipsoid():
    """The barrel x² + y² + z²/4 <= 1, |z| <= 1: end circles of radius √3/2, belly of radius 1."""
    barrel = co.Ellipsoid((1, 1, 2), z_range=(-1, 1))
    assert flat(spans(barrel, (0, 0, -5), (0, 0, 1))) == [4, 6]
    assert flat(spans(barrel, (-5, 0, 0), (1, 0, 0))) == pytest.approx([4, 6], **CLOSE)
    inner, outer = ROOT3 / 2 - 1e-9, ROOT3 / 2 + 1e-9
    assert flat(spans(barrel, (inner, 0, -5), (0, 0, 1))) == pytest.approx([4, 6], **CLOSE)
    edge = 2 * math.sqrt(1 - outer**2)
    assert flat(spans(barrel, (outer, 0, -5), (0, 0, 1))) == pytest.approx([5 - edge, 5 + edge], rel=1e-13)
    cap = first(barrel, (0.5, 0.5, 4), (0, 0, -1))
    assert cap.t == 3
    assert cap.normal == pytest.approx([0, 0, 1], **CLOSE)


def test_cilind_with_a_free_axis():
    """Axis from the origin along (2, 2, 1)/3, length 6, radius 1: along the axis from -3, and across its middle (2, 2, 1)."""
    cylinder = co.Cylinder((0, 0, 0), (4, 4, 2), 1)
    assert flat(spans(cylinder, (-2, -2, -1), (2, 2, 1))) == pytest.approx([1, 3], **CLOSE)
    # (1, -1, 0) is across the axis
    assert flat(spans(cylinder, (-1, 5, 1), (1, -1, 0))) == pytest.approx([3 - ROOT2 / 2, 3 + ROOT2 / 2], **CLOSE)
    cap = first(cylinder, (-2, -2, -1), (2, 2, 1))
    assert cap.normal == pytest.approx([-2 / 3, -2 / 3, -1 / 3], **CLOSE)


def test_konys_between_two_planes():
    """Radius 2 at z = 0 to 1 at z = 3, so r = 2 - z/3: at z = 1.5 it is 1.5; straight up at x = 1.75 it is left at z = 0.75."""
    cone = co.Cone((0, 0, 0), (0, 0, 3), 2, 1)
    assert flat(spans(cone, (-9, 0, 1.5), (1, 0, 0))) == pytest.approx([7.5, 10.5], **CLOSE)
    assert flat(spans(cone, (1.75, 0, -1), (0, 0, 1))) == pytest.approx([1, 1.75], **CLOSE)
    # outward normal of the side: (3, 0, 1) / √10
    hit = first(cone, (9, 0, 1.5), (-1, 0, 0))
    assert hit.normal == pytest.approx([3 / math.sqrt(10), 0, 1 / math.sqrt(10)], **CLOSE)


def test_pica_the_unbounded_cone():
    """x² + y² <= 4 z²: across at z = 10 it is 40 wide, at z = -10 as well; along z at x = 6 it is open from |z| = 3 on."""
    cone = co.DoubleCone(slope=2)
    for z in (10, -10):
        assert flat(spans(cone, (-50, 0, z), (1, 0, 0))) == pytest.approx([30, 70], **CLOSE)
    assert flat(spans(cone, (6, 0, 0), (0, 0, 1))) == pytest.approx([-math.inf, -3, 3, math.inf], **CLOSE)


def test_bow_tie_becomes_a_truncated_cone():
    """Planes 2 apart slide along the axis of x² + y² <= z². Along x at height z = middle the chord is 2 |middle|.

    Parallel to the axis at x = 1/2: two pieces while both nappes are cut there, then one.
    """
    for middle, expected in (
        (0.0, [-1, -0.5, 0.5, 1]),
        (0.25, [-0.75, -0.5, 0.5, 1.25]),
        (0.5, [0.5, 1.5]),
        (1.0, [0.5, 2]),
        (2.0, [1, 3]),
    ):
        shape = co.DoubleCone(1, z_range=(middle - 1, middle + 1))
        found = flat(spans(shape, (0.5, 0, 0), (0, 0, 1)))
        assert found == pytest.approx(expected, **CLOSE), middle
        across = flat(spans(shape, (-9, 0, middle), (1, 0, 0)))
        assert across == pytest.approx([9 - middle, 9 + middle] if middle else [], **CLOSE)


def test_na8fir_drops_false_intersections():
    """Roots of a surface outside of the others are false: the nearest true one counts.

    A unit ball within the cylinder x² + y² <= 1/4 and the half-space z <= 1/2, seen from z = 5 at
    (0.3, 0): ball at z = √0.91 (false, above 1/2), plane at z = 1/2 (true). From x = 5 at z = 0: ball
    at x = 1 (false), cylinder at x = 1/2 (true). At z = 0.95: everything is false.
    """
    solid = co.Sphere() & co.EllipticCylinder(4, 4) & co.HalfSpace((0, 0, 1), 0.5)
    assert flat(spans(solid, (0.3, 0, 5), (0, 0, -1))) == pytest.approx([4.5, 5 + math.sqrt(0.91)], **CLOSE)
    assert flat(spans(solid, (5, 0, 0), (-1, 0, 0))) == pytest.approx([4.5, 5.5], **CLOSE)
    assert spans(solid, (5, 0, 0.95), (-1, 0, 0)) == []


def test_false_intersection_on_the_prolongation_of_a_cylinder():
    """Figure 3.4.8: above the end of the cylinder its wall goes on, but not the solid."""
    cylinder = co.Cylinder((0, 0, 0), (0, 0, 2), 1)
    # towards the top cap from the side: wall at x = -1 is met at z = 3 (false), the cap at x = 0
    assert flat(spans(cylinder, (-2, 0, 4), (1, 0, -1))) == pytest.approx([2, 3], **CLOSE)
    assert first(cylinder, (-2, 0, 4), (1, 0, -1)).face == 2


def test_a_convex_solid_of_three_quadrics():
    """Three unit cylinders about the axes: the tricylinder; along (1, 1, 1): x² + y² = 1 at t = 1/√2; along x: t = 1."""
    solid = co.EllipticCylinder(1, 1)
    solid = solid & co.EllipticCylinder(1, 1).rotate((1, 0, 0), 90) & co.EllipticCylinder(1, 1).rotate((0, 1, 0), 90)
    assert flat(spans(solid, (0, 0, 0), (1, 1, 1))) == pytest.approx([-1 / ROOT2, 1 / ROOT2], **CLOSE)
    assert flat(spans(solid, (0, 0, 0), (1, 0, 0))) == pytest.approx([-1, 1], **CLOSE)
    assert flat(spans(solid, (0, 0, 0), (1, 1, 0))) == pytest.approx([-1 / ROOT2, 1 / ROOT2], **CLOSE)


@pytest.mark.parametrize(
    ("shape", "origin", "direction"),
    [
        (co.Sphere(2), (-5, 2, 0), (1, 0, 0)),
        (co.Sphere(5), (3 - 4 * 4, 4 + 4 * 3, 0), (4, -3, 0)),
        (co.Ellipsoid((1, 2, 4)), (-5, 0, 4), (1, 0, 0)),
        (co.Cylinder((0, 0, 0), (0, 0, 1), 1), (-5, 1, 0.5), (1, 0, 0)),
        (co.EllipticParaboloid(1, 1), (-5, 0, 0), (1, 0, 0)),
        (co.ParabolicCylinder(1), (-5, 0, 0), (1, 0, 3)),
    ],
)
def test_tangency_is_invisibility(shape, origin, direction):
    """D = 0: touching at one point is to be read as not seen."""
    assert first(shape, origin, direction, t_min=-math.inf).t == math.inf
    assert spans(shape, origin, direction) == []
    assert not co.Scene([shape]).occluded(origin, direction, t_min=-math.inf)


MOTIONS = {
    "turned": lambda s: s.rotate((1, 2, 3), 40),
    "moved and turned": lambda s: s.translate((3, 0, 1)).rotate((0, 1, 0), 90),
    "mirrored": lambda s: s.scale((-1, 1, 1)),
    "mirrored three times and stretched": lambda s: s.scale((-2, -1, -0.5)),
    "sheared": lambda s: s.transform([[1, 0.5, 0, 0], [0, 1, 0.25, 0], [0, 0, 1, 0], [0, 0, 0, 1]]),
}


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize(
    "shape",
    [
        co.Ellipsoid((1, 2, 3), z_range=(-1, 2)),
        co.Cylinder((0, 0, -1), (0, 0, 1), 1),
        co.Box(),
        co.Cone((0, 0, -1), (0, 0, 1), 1, 0.5),
    ],
    ids=lambda shape: type(shape).__name__,
)
def test_inside_and_outward_normal_survive_motions(shape, motion):
    """From inside every ray leaves, along the outward normal's side, whatever the motion."""
    moved = MOTIONS[motion](shape)
    random = np.random.default_rng(3)
    scene = co.Scene([moved])
    middle = np.mean(moved.bounds, axis=0)
    assert scene.contains(middle)
    directions = random.normal(size=(200, 3))
    hits = scene.first_hit(np.broadcast_to(middle, directions.shape), directions)
    assert np.isfinite(hits.t).all()
    assert not hits.entering.any()
    assert (np.sum(hits.normal * directions, axis=1) > 0).all()


def test_mirrored_sphere_has_outward_normals_by_hand():
    hit = first(co.Sphere(1, (3, 0, 0)).scale((-1, 1, 1)), (-9, 0, 0), (1, 0, 0))
    assert hit.t == pytest.approx(5, **CLOSE)
    assert hit.normal == pytest.approx([-1, 0, 0], **CLOSE)
    assert hit.entering


def test_gradient_vanishes_at_the_apex():
    """The source says that the gradient never vanishes; at a cone's apex it does: the normal there is the axis."""
    hit = first(co.Cone((0, 0, 0), (0, 0, 1), 1, 0), (0, 0, 5), (0, 0, -1))
    assert hit.t == pytest.approx(4, **CLOSE)
    assert np.abs(hit.normal) == pytest.approx([0, 0, 1], **CLOSE)
    assert hit.entering
