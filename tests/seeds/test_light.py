"""The light of the source documents: reflection, Phong's two highlights, refraction with the inner normal reversed, total reflection."""

import math

import numpy as np
import pytest

import conicoid as co

# --- Directions


NORMAL = np.array([0.0, 0.0, 1.0])
CLOSE = {"rel": 4e-16, "abs": 4e-16}


def test_mirror_of_a_3_4_5_triangle():
    """R = 2 (N·L) N - L with L = (3, 0, 4)/5 towards the light: (-3, 0, 4)/5. Rays travel along -L."""
    assert co.reflect((-0.6, 0.0, -0.8), NORMAL) == pytest.approx([-0.6, 0.0, 0.8], **CLOSE)
    assert co.reflect((-0.6, 0.0, -0.8), -NORMAL) == pytest.approx([-0.6, 0.0, 0.8], **CLOSE)


def source_formula(towards_light, normal, eta):
    """T = -η L + (η cos θ - √(1 + η² (cos² θ - 1))) N, η = η₁/η₂"""
    cosine = float(np.dot(towards_light, normal))
    return -eta * towards_light + (eta * cosine - math.sqrt(1 + eta**2 * (cosine**2 - 1))) * normal


def test_refraction_into_a_denser_medium():
    """sin θ₁ = 3/5, η = 5/6 (the denser is 6/5): sin θ₂ = 1/2, so T is 30° from -N."""
    refracted, total = co.refract((0.6, 0.0, -0.8), NORMAL, 5 / 6)
    assert not total
    assert refracted == pytest.approx([0.5, 0.0, -math.sqrt(3) / 2], **CLOSE)
    assert source_formula(np.array([-0.6, 0.0, 0.8]), NORMAL, 5 / 6) == pytest.approx(refracted, **CLOSE)


def test_leaving_takes_the_reversed_normal():
    """Back out: θ₁ = 30°, η = 6/5, sin θ₂ = 3/5. The outward normal lies along the ray; -N counts."""
    inside_going_up = (0.5, 0.0, math.sqrt(3) / 2)
    for normal in (NORMAL, -NORMAL):
        refracted, total = co.refract(inside_going_up, normal, 6 / 5)
        assert not total
        assert refracted == pytest.approx([0.6, 0.0, 0.8], **CLOSE)


def test_total_reflection_beyond_the_critical_angle():
    """From index 5/3: sin of the critical angle is 3/5."""
    below, above = math.asin(0.6) - 1e-6, math.asin(0.6) + 1e-6
    _, total = co.refract((math.sin(below), 0.0, math.cos(below)), NORMAL, 5 / 3)
    assert not total
    mirrored, total = co.refract((math.sin(above), 0.0, math.cos(above)), NORMAL, 5 / 3)
    assert total
    assert mirrored == pytest.approx([math.sin(above), 0.0, -math.cos(above)], **CLOSE)


# --- The two highlights, in a picture of one pixel: (R·E)^n and (H·N)^n


def pixel(material, theta, offset=0.0):
    light = co.DirectionalLight((-math.sin(math.radians(theta)), 0, -math.cos(math.radians(theta))))
    camera = co.Camera((offset, 0, 5), (offset, 0, 0), up=(0, 1, 0), field_of_view=10)
    scene = co.Scene([co.Body(co.Plane((0, 0, 1), 0), material)], lights=[light], camera=camera, background=(0, 0, 0))
    return np.asarray(scene.render(width=1, height=1, samples=1).pixels)[0, 0]


@pytest.mark.parametrize("theta", [0, 20, 45, 60, 80])
@pytest.mark.parametrize("n", [1, 8, 50])
def test_phong(theta, n):
    black = co.phong(color=(0, 0, 0), specular=0.75, shininess=n)
    assert pixel(black, theta) == pytest.approx([0.75 * math.cos(math.radians(theta)) ** n] * 3, rel=1e-6)


@pytest.mark.parametrize("theta", [0, 20, 45, 60, 80])
@pytest.mark.parametrize("n", [1, 8, 50])
def test_half_vector(theta, n):
    black = co.blinn_phong(color=(0, 0, 0), specular=0.75, shininess=n)
    assert pixel(black, theta) == pytest.approx([0.75 * math.cos(math.radians(theta / 2)) ** n] * 3, rel=1e-6)


@pytest.mark.parametrize("theta", [0, 30, 60])
def test_matte_falls_with_the_cosine(theta):
    grey = co.matte((0.5, 0.25, 0.125), ambient=0.0)
    assert pixel(grey, theta) == pytest.approx(np.array([0.5, 0.25, 0.125]) * math.cos(math.radians(theta)), rel=1e-6)


def test_light_from_behind_gives_nothing():
    for material in (co.phong(specular=1, ambient=0.0), co.blinn_phong(specular=1, ambient=0.0)):
        assert pixel(material, 120) == pytest.approx([0, 0, 0])
