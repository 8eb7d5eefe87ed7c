"""Seed 000, general quadrics with their gradient normal, and the nine canonical quadrics with their sections."""

from __future__ import annotations

import math

import numpy as np
import pytest

import conicoid as co

from .along import CLOSE, first, flat, spans

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
