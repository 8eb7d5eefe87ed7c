"""Seed 000, the two highlights, in a picture of one pixel: (R·E)^n and (H·N)^n.

A black plane z = 0 seen straight from above, so E = N; the light comes from θ beside the normal:
R·E = cos θ and H·N = cos(θ/2), and the pixel is `specular` times their n-th power.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import conicoid as co


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
