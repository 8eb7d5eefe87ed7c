"""Shading and refraction by their formulas."""

import math

import mpmath
import numpy as np
import pytest

import conicoid as co
from conicoid.render.bsdf import (
    material_table as checker,
    microfacet as fresnel,
    microfacet as lenses,
    microfacet as mirrors,
    phong as highlights,
)

from ..compiled import compiled

# --- The compiled formulas of light against closed forms

is_even = compiled(checker.is_even)
dielectric, schlick = compiled(fresnel.dielectric_fresnel), compiled(fresnel.schlick)
half_vector, phong = compiled(highlights.half_vector), compiled(highlights.phong)
reflect, refract = compiled(mirrors.reflect), compiled(lenses.refract)

UP = (0.0, 0.0, 1.0)


@pytest.mark.parametrize("eta", [1 / 1.52, 1.33, 1.52 / 1.33, 0.4])
def test_fresnel_against_sines_and_tangents(eta):
    """r_s = -sin(a - b) / sin(a + b), r_p = tan(a - b) / tan(a + b), at 40 digits."""
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


def test_grazing_and_total_reflection_are_complete():
    assert dielectric(0.0, 0.7, 0.8) == 1
    assert dielectric(0.3, -1.0, 1.5) == 1
    assert dielectric(0.0, 0.0, 1.0) == 1


def test_schlick_at_its_ends():
    assert schlick(0.04, 1.0) == 0.04
    assert schlick(0.04, 0.0) == 1
    assert schlick(0.5, 0.5) == 0.5 + 0.5 / 32


def test_critical_angle_of_glass():
    """The sine of the critical angle is 1 / n. Just below it refraction grazes, and above it there is none."""
    n = 1.52
    critical = math.asin(1 / n)
    for step, total in ((-1e-9, False), (1e-9, True)):
        angle = critical + step
        cosine = refract(math.sin(angle), 0.0, -math.cos(angle), *UP, n)[3]
        assert (cosine < 0) == total
        assert cosine < 1e-3


# --- reflect and refract on arrays: shapes, lengths, misses, and Snell's law to 50 digits


def snell(direction, normal, eta):
    """Return the refracted unit direction from the angles, at 50 digits, or None where reflection is total."""
    with mpmath.workdps(50):
        d = mpmath.matrix([mpmath.mpf(float(x)) for x in direction])
        n = mpmath.matrix([mpmath.mpf(float(x)) for x in normal])
        d, n = d / mpmath.norm(d), n / mpmath.norm(n)
        cosine = mpmath.fdot(d, n)
        if cosine > 0:
            n, cosine = -n, -cosine
        tangent = d - cosine * n
        sine = mpmath.norm(tangent)
        beyond = mpmath.mpf(float(eta)) * sine
        if beyond > 1:
            return None
        angle = mpmath.asin(beyond)
        side = tangent / sine if sine else tangent
        return np.array([float(x) for x in mpmath.sin(angle) * side - mpmath.cos(angle) * n])


def test_random_refractions_against_mpmath():
    random = np.random.default_rng(5)
    d, n = random.normal(size=(2, 300, 3))
    eta = random.uniform(0.4, 2.5, 300)
    refracted, total = co.refract(d, n, eta)
    length = np.linalg.norm(d, axis=1)
    for i in range(300):
        expected = snell(d[i], n[i], eta[i])
        assert total[i] == (expected is None)
        if expected is not None:
            # near the critical angle sqrt(1 - sin²) magnifies the rounding of sin²
            steepness = 1 / max(1e-6, abs(float(expected @ n[i]) / np.linalg.norm(n[i])))
            assert np.abs(refracted[i] / length[i] - expected).max() < 2e-15 * (1 + steepness)
        else:
            assert refracted[i] == pytest.approx(co.reflect(d[i], n[i]), abs=1e-14)


def test_equal_indices_change_nothing():
    d = np.random.default_rng(6).normal(size=(50, 3))
    straight, total = co.refract(d, (0, 0, 1), 1.0)
    assert np.abs(straight - d).max() < 4e-15
    assert not total.any()


def test_leading_shapes_broadcast():
    d = np.ones((4, 1, 3))
    n = np.ones((5, 3)) * (0, 0, 2)
    assert co.reflect(d, n).shape == (4, 5, 3)
    refracted, total = co.refract(d, n, np.full((2, 4, 1), 0.5))
    assert refracted.shape == (2, 4, 5, 3)
    assert total.shape == (2, 4, 5)
    assert co.reflect(np.zeros((0, 3)), (0, 0, 1)).shape == (0, 3)
    refracted, total = co.refract((0, 0, -1), (0, 0, 1), 1.5)
    assert refracted.shape == (3,)
    assert not total


def test_lengths_are_kept_and_normals_may_have_any():
    reflected = co.reflect((3e200, 0, -4e200), (0, 0, 1e-200))
    assert reflected == pytest.approx([3e200, 0, 4e200], rel=1e-15)
    refracted, _ = co.refract((3, 0, -4), (0, 0, -7), 5 / 6)
    assert refracted == pytest.approx([2.5, 0, -2.5 * math.sqrt(3)], rel=1e-15)


def test_misses_stay_misses():
    nan = np.full(3, np.nan)
    assert np.isnan(co.reflect((0, 0, 1), nan)).all()
    refracted, total = co.refract((0, 0, 1), nan, 1.5)
    assert np.isnan(refracted).all()
    assert not total


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (((0, 0), (0, 0, 1), 1), r"directions must have shape \(\.\.\., 3\), got \(2,\)"),
        (([(1, 0, 0), (0, 0, 0)], (0, 0, 1), 1), r"directions\[1\] must be finite and not zero"),
        (((1, 0, 0), [[(0, 0, 1), (0, math.inf, 0)]], 1), r"normals\[0, 1\] must be finite and not zero"),
        (((1, 0, 0), (0, 0, 1), 0), "eta must be finite and > 0, got 0"),
        (((1, 0, 0), (0, 0, 1), [1, math.nan]), "eta must be finite and > 0, got nan"),
    ],
)
def test_bad_arguments_are_named(arguments, message):
    with pytest.raises(ValueError, match=message):
        co.refract(*arguments)
