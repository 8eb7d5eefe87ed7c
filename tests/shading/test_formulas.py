"""The compiled formulas of light against closed forms."""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest

from conicoid.render.bsdf import (
    material_table as checker,
    microfacet as fresnel,
    microfacet as lenses,
    microfacet as mirrors,
    phong as highlights,
)

from ..compiled import compiled

is_even = compiled(checker.is_even)
dielectric, schlick = compiled(fresnel.dielectric_fresnel), compiled(fresnel.schlick)
half_vector, phong = compiled(highlights.half_vector), compiled(highlights.phong)
reflect, refract = compiled(mirrors.reflect), compiled(lenses.refract)

UP = (0.0, 0.0, 1.0)
ROOT = math.sqrt(0.5)


def test_normal_incidence():
    """((n - 1) / (n + 1))²: glass of 1.5 reflects 4 %."""
    assert dielectric(1.0, 1.0, 1 / 1.5) == pytest.approx(0.04, rel=1e-15)
    assert dielectric(1.0, 1.0, 1.5) == pytest.approx(0.04, rel=1e-15)


def test_fresnel_against_sines_and_tangents():
    """r_s = -sin(a - b) / sin(a + b), r_p = tan(a - b) / tan(a + b), at 40 digits."""
    for eta in (1 / 1.52, 1.33, 1.52 / 1.33, 0.4):
        for angle in np.linspace(0.01, 1.5, 60):
            if eta * math.sin(angle) >= 1:
                continue
            with mpmath.workdps(40):
                a = mpmath.mpf(float(angle))
                b = mpmath.asin(mpmath.mpf(eta) * mpmath.sin(a))
                s, p = mpmath.sin(a - b) / mpmath.sin(a + b), mpmath.tan(a - b) / mpmath.tan(a + b)
                expected = float((s * s + p * p) / 2)
                cos1, cos2 = float(mpmath.cos(a)), float(mpmath.cos(b))
            assert dielectric(cos1, cos2, eta) == pytest.approx(expected, rel=1e-10, abs=1e-16)


def test_brewsters_angle_reflects_one_polarisation_only():
    """tan θ = n: r_p = 0, so R = r_s² / 2 with r_s = (1 - n²) / (1 + n²)."""
    n = 1.52
    angle = math.atan(n)
    r_s = (1 - n * n) / (1 + n * n)
    assert dielectric(math.cos(angle), math.sin(angle), 1 / n) == pytest.approx(r_s**2 / 2, rel=1e-14)


def test_what_is_not_reflected_is_transmitted():
    """T = (η₂ cos₂ / η₁ cos₁) (t_s² + t_p²) / 2 with t_s = 2 η₁ cos₁ / (η₁ cos₁ + η₂ cos₂); R + T = 1."""
    for eta in (1 / 1.52, 1.52):
        for sine in np.linspace(0, min(1, 1 / eta), 40)[:-1]:
            a, b = math.sqrt(1 - sine**2), math.sqrt(1 - (eta * sine) ** 2)
            t_s, t_p = 2 * eta * a / (eta * a + b), 2 * eta * a / (a + eta * b)
            transmitted = b / (eta * a) * (t_s**2 + t_p**2) / 2
            assert dielectric(a, b, eta) + transmitted == pytest.approx(1, abs=1e-14)


def test_grazing_and_total_reflection_are_complete():
    assert dielectric(0.0, 0.7, 0.8) == 1
    assert dielectric(0.3, -1.0, 1.5) == 1
    assert dielectric(0.0, 0.0, 1.0) == 1


def test_reflectance_is_the_same_both_ways():
    for sine in np.linspace(0, 0.6, 20):
        a, b = math.sqrt(1 - sine**2), math.sqrt(1 - (1.5 * sine) ** 2)
        assert dielectric(a, b, 1.5) == pytest.approx(dielectric(b, a, 1 / 1.5), rel=1e-12)


def test_schlick_at_its_ends():
    assert schlick(0.04, 1.0) == 0.04
    assert schlick(0.04, 0.0) == 1
    assert schlick(0.5, 0.5) == 0.5 + 0.5 / 32


def test_critical_angle_of_glass():
    """sin of the critical angle is 1 / n; just below it refraction grazes, above it there is none."""
    n = 1.52
    critical = math.asin(1 / n)
    for step, total in ((-1e-9, False), (1e-9, True)):
        angle = critical + step
        cosine = refract(math.sin(angle), 0.0, -math.cos(angle), *UP, n)[3]
        assert (cosine < 0) == total
        assert cosine < 1e-3


def test_refraction_and_reflection_of_the_source():
    """sin θ₁ = 3/5, η = 5/6: sin θ₂ = 1/2."""
    assert refract(0.6, 0.0, -0.8, *UP, 5 / 6) == pytest.approx((0.5, 0, -math.sqrt(0.75), math.sqrt(0.75)), rel=1e-15)
    assert reflect(0.6, 0.0, -0.8, *UP) == pytest.approx((0.6, 0, 0.8), rel=1e-15)


def test_highlights_by_hand():
    """L at 45° to N, E along N: R·E = cos 45°, so (R·E)^10 = 1/32; H·N = cos 22.5°."""
    towards_light = (ROOT, 0.0, ROOT)
    assert phong(towards_light, UP, UP, 10.0) == pytest.approx(1 / 32, rel=1e-14)
    assert half_vector(towards_light, UP, UP, 10.0) == pytest.approx(math.cos(math.pi / 8) ** 10, rel=1e-14)


def test_highlights_are_full_along_the_mirror_direction_and_none_behind():
    eye = (-ROOT, 0.0, ROOT)
    assert phong((ROOT, 0.0, ROOT), eye, UP, 100.0) == pytest.approx(1, rel=1e-13)
    assert half_vector((ROOT, 0.0, ROOT), eye, UP, 100.0) == pytest.approx(1, rel=1e-13)
    assert phong((0.8, 0.0, 0.6), (0.8, 0.0, -0.6), UP, 3.0) == 0
    assert half_vector((0.8, 0.0, -0.6), (0.0, 0.6, -0.8), UP, 3.0) == 0


@pytest.mark.parametrize(
    ("point", "even"),
    [
        ((0.5, 0.5, 0.5), True),
        ((1.5, 0.5, 0.5), False),
        ((-0.5, 0.5, 0.5), False),
        ((-0.5, -0.5, 0.5), True),
        ((2, 3, 0), False),
    ],
)
def test_checker_parity(point, even):
    assert is_even(*map(float, point)) == even
