"""The X-ray projection of the Shepp-Logan head against its closed form in extended precision.

A parallel beam through ellipsoids of densities ρ that add up: the pixel is Σ ρ · chord, and the
chord of |R (x - c) / radii| = 1 is 2 √(b² - a c) |d| / a with the quadratic of the ray in the ball's frame.
"""

from __future__ import annotations

import mpmath
import numpy as np
import pytest

import conicoid as co

# density; semi-axes a, b, c; centre; Euler angles φ, θ, ψ (z-x-z), in degrees. Shepp and Logan 1974, after
# Kak and Slaney 1988 in three dimensions, with the contrast of Toft 1996.
HEAD = np.array([
    [1.0, 0.69, 0.92, 0.81, 0, 0, 0, 0, 0, 0],
    [-0.8, 0.6624, 0.874, 0.78, 0, -0.0184, 0, 0, 0, 0],
    [-0.2, 0.11, 0.31, 0.22, 0.22, 0, 0, -18, 0, 10],
    [-0.2, 0.16, 0.41, 0.28, -0.22, 0, 0, 18, 0, 10],
    [0.1, 0.21, 0.25, 0.41, 0, 0.35, -0.15, 0, 0, 0],
    [0.1, 0.046, 0.046, 0.05, 0, 0.1, 0.25, 0, 0, 0],
    [0.1, 0.046, 0.046, 0.05, 0, -0.1, 0.25, 0, 0, 0],
    [0.1, 0.046, 0.023, 0.05, -0.08, -0.605, 0, 0, 0, 0],
    [0.1, 0.023, 0.023, 0.02, 0, -0.606, 0, 0, 0, 0],
    [0.1, 0.023, 0.046, 0.02, 0.06, -0.605, 0, 0, 0, 0],
])  # fmt: skip
# A point in the ellipsoid's own frame is Rz(ψ) Rx(θ) Rz(φ) (x - centre), Rz(φ) = [[cos, sin, 0], [-sin, cos, 0], [0, 0,
# 1]].

VIEWS = {
    "from the side": ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
    "from above": ((0.0, 0.0, -1.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
    "oblique": ((0.6, 0.64, 0.48), (-0.8, 0.48, 0.36), (0.0, -0.6, 0.8)),
}
"""Direction of the beam, and the axes of the picture: an orthonormal triple in 3-4-5 fractions."""


def head():
    shapes = []
    for _, a, b, c, *rest in HEAD.tolist():
        center, (phi, theta, psi) = rest[:3], rest[3:]
        shape = co.Ellipsoid((a, b, c)).rotate((0, 0, 1), psi).rotate((1, 0, 0), theta).rotate((0, 0, 1), phi)
        shapes.append(shape.translate(center))
    return co.Scene(shapes)


def beam(view, pixels):
    """Origins 3 units out, at the middles of pixels over [-1, 1]²."""
    d, u, v = (np.array(x) for x in VIEWS[view])
    s = (2 * np.arange(pixels) + 1) / pixels - 1
    return -3 * d + s[None, :, None] * u + s[:, None, None] * v, d


def turned(phi, theta, psi):
    """Rz(ψ) Rx(θ) Rz(φ) by mpmath, to 40 digits."""
    with mpmath.workdps(40):

        def rotation(degrees, i, j):
            r, angle = mpmath.eye(3), mpmath.mpf(degrees) * mpmath.pi / 180
            r[i, i] = r[j, j] = mpmath.cos(angle)
            r[i, j], r[j, i] = mpmath.sin(angle), -mpmath.sin(angle)
            return r

        return rotation(psi, 0, 1) * rotation(theta, 1, 2) * rotation(phi, 0, 1)


def extended(matrix):
    return np.array([[np.longdouble(mpmath.nstr(matrix[i, j], 30)) for j in range(3)] for i in range(3)])


def closed_form(origins, direction):
    """Σ ρ chord in 80-bit floats."""
    assert np.finfo(np.longdouble).eps < 2e-19
    o, d = origins.astype(np.longdouble), np.asarray(direction, dtype=np.longdouble)
    total = np.zeros(o.shape[:-1], dtype=np.longdouble)
    for row in HEAD:
        rho, radii, center = np.longdouble(row[0]), row[1:4].astype(np.longdouble), row[4:7].astype(np.longdouble)
        r = extended(turned(*row[7:]))
        p, e = (o - center) @ r.T / radii, r @ d / radii
        a, b = e @ e, p @ e
        p = p - (b / a)[..., None] * e  # foot of the perpendicular: b becomes 0
        discriminant = 1 - np.sum(p * p, axis=-1)
        chord = 2 * np.sqrt(np.where(discriminant > 0, discriminant, 0) / a) * np.sqrt(d @ d)
        total += rho * chord
    return total


def exact_pixel(origin, direction):
    """The same with mpmath, 40 digits."""
    with mpmath.workdps(40):
        total = mpmath.mpf(0)
        for row in HEAD.tolist():
            r = turned(*row[7:])
            p = r * mpmath.matrix([mpmath.mpf(float(o)) - mpmath.mpf(c) for o, c in zip(origin, row[4:7], strict=True)])
            e = r * mpmath.matrix([mpmath.mpf(float(x)) for x in direction])
            p, e = ([x / mpmath.mpf(k) for x, k in zip(v, row[1:4], strict=True)] for v in (p, e))
            a, b, c = (sum(x * y for x, y in zip(*pair, strict=True)) for pair in ((e, e), (p, e), (p, p)))
            if b * b > a * (c - 1):
                total += mpmath.mpf(row[0]) * 2 * mpmath.sqrt(b * b - a * (c - 1)) / a
        return total * mpmath.sqrt(sum(mpmath.mpf(float(x)) ** 2 for x in direction))


def check(view, pixels):
    origins, direction = beam(view, pixels)
    picture = head().spans(origins, direction).line_integral(HEAD[:, 0])
    expected = closed_form(origins, direction)
    assert picture.shape == (pixels, pixels)
    assert picture.max() > 0.3
    off = np.abs(picture.astype(np.longdouble) - expected)
    assert off.max() <= 1e-12, f"{float(off.max())} off at pixel {np.unravel_index(off.argmax(), off.shape)}"
    return picture


@pytest.mark.parametrize("view", VIEWS)
def test_projection(view):
    picture = check(view, 128)
    origins, direction = beam(view, 128)
    for row, column in ((64, 64), (20, 64), (64, 100), (90, 30), (40, 70), (1, 1)):
        exact = exact_pixel(origins[row, column], direction)
        assert abs(mpmath.mpf(float(picture[row, column])) - exact) <= 1e-12


@pytest.mark.deep
@pytest.mark.parametrize("view", VIEWS)
def test_projection_at_full_size(view):
    check(view, 512)


def test_middle_pixel_by_hand():
    """Down the z axis through (0, 0): skull 2·0.81·1 - 0.8·2·0.78·√(1 - (0.0184/0.874)²); no other figure is met but the
    fifth: at y = 0, 0.1 · 2 · 0.41 · √(1 - (0.35/0.25)²) is not real, so nothing."""
    value = head().spans((0, 0, 3), (0, 0, -1)).line_integral(HEAD[:, 0])
    expected = 2 * 0.81 - 0.8 * 2 * 0.78 * np.sqrt(1 - (0.0184 / 0.874) ** 2)
    assert value == pytest.approx(expected, abs=1e-14)
