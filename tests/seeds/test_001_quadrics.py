"""Seed 001: caps by sorting hits; the symmetric form, the root of equation 13.4, quadrics carried by affine maps, uv."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest

import conicoid as co

from .along import CLOSE, first, flat, spans

# --- Seed 001: caps by sorting the hits on body (b1 < b2) and cap planes (c1 < c2): six cases and the special ones


CYLINDER = co.Cylinder((0, 0, 0), (0, 1, 0), 1)
BODY, LOW_CAP, HIGH_CAP = 0, 1, 2
NORMALS = {LOW_CAP: (0, -1, 0), HIGH_CAP: (0, 1, 0)}

# origin, direction, (c1, c2), (b1, b2), expected (enter, face), (exit, face)
GENERAL = {
    "1: c1 c2 b1 b2, miss": ((-4, -1), (1, 1), (1, 2), (3, 5), None),
    "2: c1 b1 c2 b2, body then cap": ((-2.5, -1), (1, 1), (1, 2), (1.5, 3.5), ((1.5, BODY), (2, HIGH_CAP))),
    "3: c1 b1 b2 c2, body then body": ((-3, -0.25), (4, 1), (0.25, 1.25), (0.5, 1), ((0.5, BODY), (1, BODY))),
    "4: b1 c1 b2 c2, cap then body": ((-2, -2.5), (1, 1), (2.5, 3.5), (1, 3), ((2.5, LOW_CAP), (3, BODY))),
    "5: b1 c1 c2 b2, cap then cap": ((-1.5, -1), (1, 1), (1, 2), (0.5, 2.5), ((1, LOW_CAP), (2, HIGH_CAP))),
    "6: b1 b2 c1 c2, miss": ((-2, -4), (1, 1), (4, 5), (1, 3), None),
}


@pytest.mark.parametrize("case", GENERAL)
def test_general_cases(case):
    (x, y), (u, v), caps, body, expected = GENERAL[case]
    assert (-y / v, (1 - y) / v) == caps
    assert ((-1 - x) / u, (1 - x) / u) == body
    found = spans(CYLINDER, (x, y, 0), (u, v, 0))
    if expected is None:
        assert found == []
        return
    (enter, enter_face), (leave, leave_face) = expected
    assert flat(found) == pytest.approx([enter, leave], **CLOSE)
    hit = first(CYLINDER, (x, y, 0), (u, v, 0))
    assert (hit.t, hit.face, hit.entering) == (pytest.approx(enter, **CLOSE), enter_face, True)
    assert hit.normal == pytest.approx(NORMALS.get(enter_face, (-1, 0, 0)), **CLOSE)
    middle = (enter + leave) / 2
    hit = first(CYLINDER, (x + u * middle, y + v * middle, 0), (u, v, 0))
    assert (hit.face, hit.entering) == (leave_face, False)
    assert hit.normal == pytest.approx(NORMALS.get(leave_face, (1, 0, 0)), **CLOSE)


@pytest.mark.parametrize("case", GENERAL)
def test_the_same_reversed_and_upside_down(case):
    (x, y), (u, v), _, _, expected = GENERAL[case]
    t = [] if expected is None else [expected[0][0], expected[1][0]]
    assert flat(spans(CYLINDER, (x, y, 0), (-u, -v, 0))) == pytest.approx([-s for s in reversed(t)], **CLOSE)
    assert flat(spans(CYLINDER, (x, 1 - y, 0), (u, -v, 0))) == pytest.approx(t, **CLOSE)


SPECIAL = {
    "tangent to the body": ((-3, 0.5, 1), (1, 0, 0), []),
    "tangent to the body, oblique": ((-3, -0.25, 1), (4, 1, 0), []),
    "parallel to the caps, between them": ((-3, 0.5, 0), (1, 0, 0), [2, 4]),
    "parallel to the caps, chord at z = 0.6": ((-3, 0.25, 0.6), (1, 0, 0), [2.2, 3.8]),
    "parallel to the caps, above": ((-3, 1.5, 0), (1, 0, 0), []),
    "missing the body": ((-3, 0.5, 2), (1, 0, 0), []),
    "missing, oblique": ((-3, -1, 1.5), (1, 1, 0), []),
    "parallel to the axis, inside": ((0.5, -2, 0.5), (0, 1, 0), [2, 3]),
    "parallel to the axis, outside": ((1, -2, 1), (0, 1, 0), []),
    "along a ruling: no crossing": ((1, -2, 0), (0, 1, 0), []),
}


@pytest.mark.parametrize("case", SPECIAL)
def test_special_cases(case):
    origin, direction, expected = SPECIAL[case]
    assert flat(spans(CYLINDER, origin, direction)) == pytest.approx(expected, **CLOSE)


def test_in_the_plane_of_a_cap_crossings_stay_even():
    for y in (0.0, 1.0):
        for direction in ((1, 0, 0), (0.6, 0, 0.8), (-3, 0, 1)):
            found = co.Scene([CYLINDER]).crossings((-3 * direction[0], y, -3 * direction[2]), direction)
            assert len(found.t) % 2 == 0


def test_both_caps_of_other_quadrics():
    """A paraboloid z >= x² + y² cut at z = 1 and 4, and two bowls cut on one side only."""
    bowl = co.EllipticParaboloid(1, 1, z_range=(1, 4))
    assert flat(spans(bowl, (0, 0, -1), (0, 0, 1))) == [2, 5]
    # x = 1.5: in by the body at z = 2.25, out by the cap
    assert flat(spans(bowl, (1.5, 0, 0), (0, 0, 1))) == pytest.approx([2.25, 4], **CLOSE)
    one = co.TwoSheetHyperboloid(1, 1, 1, z_range=(0, 3))
    assert flat(spans(one, (0, 0, -9), (0, 0, 1))) == pytest.approx([10, 12], **CLOSE)


# --- Seed 001: the symmetric form, the root of equation 13.4, quadrics carried by affine maps, uv


UNIT_SPHERE = np.diag([1.0, 1.0, 1.0, -1.0])


def exact_inverse(matrix):
    """Gauss-Jordan in fractions."""
    n = len(matrix)
    rows = [[Fraction(x) for x in row] + [Fraction(int(i == j)) for j in range(n)] for i, row in enumerate(matrix)]
    for i in range(n):
        pivot = next(k for k in range(i, n) if rows[k][i])
        rows[i], rows[pivot] = rows[pivot], rows[i]
        rows[i] = [x / rows[i][i] for x in rows[i]]
        for k in range(n):
            if k != i:
                rows[k] = [x - rows[k][i] * y for x, y in zip(rows[k], rows[i], strict=True)]
    return [row[n:] for row in rows]


def times(a, b):
    return [[sum(x * y for x, y in zip(row, column, strict=True)) for column in zip(*b, strict=True)] for row in a]


def transpose(a):
    return [list(column) for column in zip(*a, strict=True)]


def moved(q, m):
    """M⁻ᵀ Q M⁻¹: if xᵗ Q x = 0 then (M x)ᵗ M⁻ᵀ Q M⁻¹ (M x) = 0."""
    back = exact_inverse(m)
    return times(times(transpose(back), q), back)


def printed(q, m):
    """M⁻¹ Q (M⁻¹)ᵗ, as the source prints it."""
    back = exact_inverse(m)
    return times(times(back, q), transpose(back))


def roots(q, origin, direction):
    """Equation 13.4: t = (-uᵗQp ± √((uᵗQp)² - (uᵗQu)(pᵗQp))) / uᵗQu"""
    p, u = [*map(Fraction, origin), 1], [*map(Fraction, direction), 0]

    def form(a, b):
        return sum(a[i] * q[i][j] * b[j] for i in range(4) for j in range(4))

    root = math.sqrt(form(u, p) ** 2 - form(u, u) * form(p, p))
    return sorted(float((-float(form(u, p)) + s * root) / float(form(u, u))) for s in (1, -1))


def test_equation_13_4():
    """x² + y² + z² = 1 from (0, 0.6, -2) along z: ±0.8."""
    q = UNIT_SPHERE.tolist()
    assert roots(q, (0, 0.6, -2), (0, 0, 1)) == pytest.approx([1.2, 2.8], **CLOSE)
    assert flat(spans(co.Quadric(matrix=q), (0, 0.6, -2), (0, 0, 1))) == pytest.approx([1.2, 2.8], **CLOSE)


def test_sphere_of_radius_3():
    """Scaling the unit sphere by 3 gives diag(1/9, 1/9, 1/9, -1)."""
    q, m = np.diag([1, 1, 1, -1]).tolist(), np.diag([3, 3, 3, 1]).tolist()
    ninth = Fraction(1, 9)
    expected = [[ninth if i == j < 3 else Fraction(-1) if i == j else 0 for j in range(4)] for i in range(4)]
    assert moved(q, m) == expected
    assert printed(q, m) == expected  # a diagonal M cannot tell
    shapes = (
        co.Sphere(3),
        co.Quadric(matrix=q).scale(3),
        co.Quadric(matrix=q).transform(m),
        co.Quadric(matrix=np.diag([1 / 9, 1 / 9, 1 / 9, -1.0])),
    )
    for shape in shapes:
        assert flat(spans(shape, (-5, 0, 0), (1, 0, 0))) == pytest.approx([2, 8], **CLOSE)


def test_the_printed_formula_fails_for_a_translation():
    """The unit sphere moved by 5 along x is met at 4 and 6; the printed matrix has xᵗQx = -24 x² + 10 x + … - 1."""
    m = np.eye(4)
    m[0, 3] = 5
    wrong = printed(UNIT_SPHERE.tolist(), m.tolist())
    assert wrong[0][0] == -24
    right = moved(UNIT_SPHERE.tolist(), m.tolist())
    assert roots(right, (0, 0, 0), (1, 0, 0)) == [4, 6]
    assert flat(spans(co.Sphere().transform(m), (0, 0, 0), (1, 0, 0))) == pytest.approx([4, 6], **CLOSE)
    assert flat(spans(co.Quadric(matrix=UNIT_SPHERE).transform(m), (0, 0, 0), (1, 0, 0))) == pytest.approx(
        [4, 6], **CLOSE
    )


MATRICES = {
    "shear": [[1, 2, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]],
    "general": [[2, 1, 0, 3], [0, 1, -1, 1], [1, 0, 4, -2], [0, 0, 0, 1]],
    "mirrored": [[-1, 0.5, 0, 0], [0, 2, 0, 1], [0, 0.25, 1, 0], [0, 0, 0, 1]],
}


@pytest.mark.parametrize("name", MATRICES)
def test_affine_maps_of_an_ellipsoid(name):
    """The roots of M⁻ᵀ Q M⁻¹ in exact arithmetic, against the moved shape and the quadric of that matrix."""
    m = MATRICES[name]
    q = np.diag([1.0, 0.25, 4.0, -1.0]).tolist()
    exact = moved(q, m)
    middle = [row[3] for row in m[:3]]
    for direction in ((1, 2, 3), (0, 1, 0), (-3, 1, 1)):
        origin = [c - 7 * d for c, d in zip(middle, direction, strict=True)]
        expected = roots(exact, origin, direction)
        for shape in (
            co.Quadric(matrix=q).transform(m),
            co.Ellipsoid((1, 2, 0.5)).transform(m),
            co.Quadric(matrix=[[float(x) for x in row] for row in exact]),
        ):
            assert flat(spans(shape, origin, direction)) == pytest.approx(expected, rel=1e-13)


def test_non_symmetric_motion_tells_the_formulas_apart():
    q, m = np.diag([1.0, 0.25, 4.0, -1.0]).tolist(), MATRICES["shear"]
    assert moved(q, m) != printed(q, m)
    # the shear takes (0, 2, 0), a point of the ellipsoid x² + y²/4 + 4z² = 1, to (4, 2, 0)
    point = [4, 2, 0, 1]
    for matrix, on_surface in ((moved(q, m), True), (printed(q, m), False)):
        assert (sum(point[i] * matrix[i][j] * point[j] for i in range(4) for j in range(4)) == 0) == on_surface
    found = spans(co.Quadric(matrix=q).transform(m), (-4, -2, 0), (8, 4, 0))
    assert flat(found) == pytest.approx([0, 1], abs=1e-15)


@pytest.mark.parametrize("degrees", [0, 30, 90, 200, 359])
def test_uv_of_the_sphere_and_the_cylinder(degrees):
    """Angle over a full turn, and the height scaled to [0, 1]."""
    x, y = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    cylinder = co.Cylinder((0, 0, 1), (0, 0, 5), 1, reference=(1, 0, 0))
    hit = first(cylinder, (3 * x, 3 * y, 2), (-x, -y, 0))
    assert hit.uv[0] % 1 == pytest.approx(degrees / 360, abs=1e-15)
    assert hit.uv[1] == pytest.approx((2 - 1) / 4, abs=1e-15)
    hit = first(co.Sphere(2, (0, 0, 1)), (6 * x, 6 * y, 2), (-x, -y, 0))
    assert hit.uv[0] % 1 == pytest.approx(degrees / 360, abs=1e-15)
    assert hit.uv[1] == pytest.approx((2 - (1 - 2)) / 4, abs=1e-15)
