"""Seed 000: reflection, Phong's two highlights, refraction with the inner normal reversed, total reflection."""

from __future__ import annotations

import math

import numpy as np
import pytest

import conicoid as co

# --- Seed 000, reflection, Phong's two highlights, refraction with the inner normal reversed, total reflection


NORMAL = np.array([0.0, 0.0, 1.0])
CLOSE = {"rel": 4e-16, "abs": 4e-16}


def test_mirror_of_a_3_4_5_triangle():
    """R = 2 (N·L) N - L with L = (3, 0, 4)/5 towards the light: (-3, 0, 4)/5. Rays travel along -L."""
    assert co.reflect((-0.6, 0.0, -0.8), NORMAL) == pytest.approx([-0.6, 0.0, 0.8], **CLOSE)
    assert co.reflect((-0.6, 0.0, -0.8), -NORMAL) == pytest.approx([-0.6, 0.0, 0.8], **CLOSE)


def test_reflection_identities():
    """Coplanar, of equal length, at equal angles to the normal; twice is the identity."""
    random = np.random.default_rng(1)
    towards_light = random.normal(size=(1000, 3))
    normals = random.normal(size=(1000, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    mirrored = co.reflect(-towards_light, normals)
    expected = 2 * np.sum(normals * towards_light, axis=1, keepdims=True) * normals - towards_light
    size = np.linalg.norm(towards_light, axis=1)
    assert np.abs(mirrored - expected).max() <= 1e-14
    assert np.abs(np.linalg.norm(mirrored, axis=1) - size).max() <= 1e-14
    assert np.abs(np.sum((mirrored - towards_light) * normals, axis=1)).max() <= 1e-14
    assert np.abs(np.sum(np.cross(towards_light, normals) * mirrored, axis=1)).max() <= 1e-13
    assert np.abs(co.reflect(mirrored, normals) + towards_light).max() <= 1e-14


def test_highlights_of_the_mirror_direction():
    """Where E = R both formulas give 1; 60° from the mirrored ray Phong gives cos 60°, the half vector cos 30°."""
    towards_light = np.array([0.0, 0.0, 1.0])
    mirrored = co.reflect(-towards_light, NORMAL)
    assert mirrored @ towards_light == 1.0
    eye = np.array([math.sqrt(3) / 2, 0, 0.5])
    half = towards_light + eye
    half /= np.linalg.norm(half)
    assert mirrored @ eye == pytest.approx(math.cos(math.radians(60)), **CLOSE)
    assert half @ NORMAL == pytest.approx(math.cos(math.radians(30)), **CLOSE)


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


def test_snell_for_many():
    """η₁ sin θ₁ = η₂ sin θ₂, in the plane of incidence, at unit length, on the far side."""
    random = np.random.default_rng(2)
    directions, normals = (v / np.linalg.norm(v, axis=1, keepdims=True) for v in random.normal(size=(2, 2000, 3)))
    eta = random.uniform(0.4, 1.7, 2000)
    refracted, total = co.refract(directions, normals, eta)
    sine = np.linalg.norm(np.cross(directions, normals), axis=1)
    clear = np.abs(eta * sine - 1) > 1e-9
    assert ((eta * sine > 1) == total)[clear].all()
    assert total.any()
    assert not total.all()
    through = ~total & clear
    sine_after = np.linalg.norm(np.cross(refracted, normals), axis=1)
    assert np.abs(sine_after - eta * sine)[through].max() <= 1e-15 * 8
    assert np.abs(np.linalg.norm(refracted, axis=1) - 1).max() <= 1e-15 * 4
    assert (np.sum(refracted * normals, axis=1) * np.sum(directions * normals, axis=1) > 0)[through].all()
    out_of_plane = np.sum(np.cross(directions, normals) * refracted, axis=1)
    assert np.abs(out_of_plane).max() <= 1e-15 * 4
    assert np.abs(refracted - co.reflect(directions, normals))[total].max() <= 1e-15 * 4


def test_equal_media_change_nothing():
    refracted, total = co.refract((0.6, 0.0, -0.8), NORMAL, 1.0)
    assert not total
    assert refracted == pytest.approx([0.6, 0.0, -0.8], **CLOSE)


# --- Seed 000, the two highlights, in a picture of one pixel: (R·E)^n and (H·N)^n


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
