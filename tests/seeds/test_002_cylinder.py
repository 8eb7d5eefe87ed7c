"""Seed 002: the cylinder by two axis points, a reference point and angles; equations 2 to 12.

The reference point is not across the axis here: equation 2 gives R_X perpendicular to R_Z only
after projection (erratum). Everything below is in a hand-made frame:
p1 = (1, 0, 0), p2 = (1, 4, 0), p3 = (1, 1, 2): R_Z = (0, 1, 0), R_X = (0, 0, 1), R_Y = R_Z × R_X = (1, 0, 0).
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import conicoid as co

from .along import CLOSE, first, flat, spans

P1, P2, P3, RADIUS = (1, 0, 0), (1, 4, 0), (1, 1, 2), 2
BASIS = np.array([[0, 0, 1], [1, 0, 0], [0, 1, 0]], dtype=float)  # rows R_X, R_Y, R_Z
ROOT3 = math.sqrt(3)


def world(local):
    """Equation 3: (x, y, z) = [R_X R_Y R_Z] (X, Y, Z) + p1."""
    return BASIS.T @ np.asarray(local, dtype=float) + P1


def test_local_basis_of_equation_2():
    p1, p2, p3 = map(np.array, (P1, P2, P3))
    axis = (p2 - p1) / np.linalg.norm(p2 - p1)
    towards = p3 - p1
    assert towards @ axis == 1  # not perpendicular as the source has it
    across = towards - (towards @ axis) * axis
    across = across / np.linalg.norm(across)
    assert np.array_equal([across, np.cross(axis, across), axis], BASIS)


def test_intersections_in_both_frames():
    """Equations 4 to 10: from (6, 1, 1) along (-1, 0, 0); locally (1, 5, 1) along (0, -1, 0).

    X² + Y² = 4: a = 1, half b = -5, c = 1 + 25 - 4 = 22, D = 25 - 22 = 3, t = 5 ∓ √3,
    local points (1, ±√3, 1).
    """
    cylinder = co.Cylinder(P1, P2, RADIUS, reference=P3)
    origin, direction = (6, 1, 1), (-1, 0, 0)
    assert np.array_equal(BASIS @ (np.array(origin) - P1), [1, 5, 1])
    assert flat(spans(cylinder, origin, direction)) == pytest.approx([5 - ROOT3, 5 + ROOT3], **CLOSE)
    hit = first(cylinder, origin, direction)
    assert hit.local_point == pytest.approx([1, ROOT3, 1], **CLOSE)
    assert hit.point == pytest.approx([1 + ROOT3, 1, 1], **CLOSE)
    assert hit.point == pytest.approx(world(hit.local_point), **CLOSE)
    # equation 12: atan2(√3, 1) = 60 degrees; equation 11: height 1 of 4
    assert hit.uv == pytest.approx([60 / 360, 0.25], **CLOSE)
    far = first(cylinder, (1, 1, 1), direction)
    assert far.local_point == pytest.approx([1, -ROOT3, 1], **CLOSE)
    assert far.uv[0] == pytest.approx(300 / 360, **CLOSE)


def test_discriminant_of_equation_8_decides():
    """At X = 2 the ray touches (D = 0) and does not hit; beyond it misses."""
    cylinder = co.Cylinder(P1, P2, RADIUS, reference=P3)
    assert spans(cylinder, (6, 1, 2), (-1, 0, 0)) == []
    assert spans(cylinder, (6, 1, 2.5), (-1, 0, 0)) == []
    inner = 2 - 2.0**-20
    half = math.sqrt(4 - inner**2)
    assert flat(spans(cylinder, (6, 1, inner), (-1, 0, 0))) == pytest.approx([5 - half, 5 + half], rel=1e-13)


@pytest.mark.parametrize(("height", "inside"), [(-0.1, False), (0.1, True), (3.9, True), (4.1, False)])
def test_length_of_equation_11(height, inside):
    for shape in (co.Cylinder(P1, P2, RADIUS, reference=P3), co.CylinderPatch(P1, P2, RADIUS, 0, 360, P3)):
        assert (first(shape, (6, height, 0), (-1, 0, 0)).t < math.inf) == inside


RANGES = [(0, 90), (30, 60), (-45, 45), (300, 420), (10, 300), (0, 180), (90, 270), (-170, 170), (200, 500)]


@pytest.mark.parametrize(("start", "end"), RANGES)
def test_angles_of_equation_12(start, end):
    """From the axis outwards at angle θ: the patch is met where θ is in the range, whatever atan2 says."""
    patch = co.CylinderPatch(P1, P2, RADIUS, start, end, P3)
    wedge = co.Cylinder(P1, P2, RADIUS, start, end, P3)
    for theta in range(-177, 540, 20):
        inside = any(start <= theta + 360 * k <= end for k in range(-3, 4))
        outward = BASIS.T @ [math.cos(math.radians(theta)), math.sin(math.radians(theta)), 0]
        hit = first(patch, world((0, 0, 1)), outward)
        assert (hit.t < math.inf) == inside, theta
        if inside:
            assert hit.t == pytest.approx(2, **CLOSE)
            assert hit.uv[0] % 1 == pytest.approx(theta % 360 / 360, abs=1e-15)
        assert bool(co.Scene([wedge]).contains(world((0, 0, 1)) + outward)) == inside, theta


def test_atan2_alone_would_fail_over_180_degrees():
    """θ = 240° is in [10°, 300°], but atan2 gives -120°."""
    theta = math.radians(240)
    assert math.degrees(math.atan2(math.sin(theta), math.cos(theta))) == pytest.approx(-120)
    patch = co.CylinderPatch(P1, P2, RADIUS, 10, 300, P3)
    assert first(patch, world((0, 0, 1)), BASIS.T @ [math.cos(theta), math.sin(theta), 0]).t == pytest.approx(
        2, **CLOSE
    )


def test_wedge_over_180_is_not_convex():
    """270° from 0: along Y = -1 from X = -3: in at -√3, out at the wall X = 0 (angle 270°)."""
    wedge = co.Cylinder(P1, P2, RADIUS, 0, 270, P3)
    origin, direction = world((-3, -1, 1)), BASIS.T @ [1, 0, 0]
    assert flat(spans(wedge, origin, direction)) == pytest.approx([3 - ROOT3, 3], **CLOSE)
    # a chord across the missing quarter: from (2.5, 0.5) along (-1, -1): Y = X - 2 meets the circle at
    # (2, 0) and (0, -2): it runs in the missing quarter alone. Along Y = X - 1: from X = (1 + √7)/2 down
    # to the wall Y = 0 at X = 1, and from the wall X = 0 on to X = (1 - √7)/2.
    origin, direction = world((3, 2, 1)), BASIS.T @ [-1, -1, 0]
    upper, lower = (1 + math.sqrt(7)) / 2, (1 - math.sqrt(7)) / 2
    assert flat(spans(wedge, origin, direction)) == pytest.approx([3 - upper, 2, 3, 3 - lower], **CLOSE)


def test_tilted_cylinder_against_equations_5_to_10():
    """The same equations evaluated for a free axis in the test, against the library's roots and local points."""
    p1, p2, p3, radius = np.array([1.0, -2, 0.5]), np.array([3.0, 1, 2.5]), np.array([0.0, 0, 4]), 1.5
    z = (p2 - p1) / np.linalg.norm(p2 - p1)
    x = (p3 - p1) - ((p3 - p1) @ z) * z
    x /= np.linalg.norm(x)
    basis = np.array([x, np.cross(z, x), z])
    cylinder = co.Cylinder(p1, p2, radius, reference=p3)
    random = np.random.default_rng(5)
    middle, tried = (p1 + p2) / 2, 0
    for _ in range(200):
        direction = random.normal(size=3)
        origin = middle + random.normal(size=3) * 0.3 - 6 * direction
        o, d = basis @ (origin - p1), basis @ direction
        b, a = o[0] * d[0] + o[1] * d[1], d[0] ** 2 + d[1] ** 2
        discriminant = b * b - a * (o[0] ** 2 + o[1] ** 2 - radius**2)
        if discriminant <= 0.01 or a <= 0.01:
            continue
        t = (-b - math.sqrt(discriminant)) / a
        local = o + t * d
        if t < 0:
            continue
        if not 0.01 < local[2] < np.linalg.norm(p2 - p1) - 0.01:
            continue
        tried += 1
        hit = first(cylinder, origin, direction)
        assert hit.t == pytest.approx(t, rel=1e-12)
        assert hit.local_point == pytest.approx(local, abs=1e-12)
        assert hit.uv[0] == pytest.approx(math.atan2(local[1], local[0]) / (2 * math.pi) % 1, abs=1e-12)
    assert tried > 50
