"""The light of the source documents: reflection, Phong's two highlights, refraction with the inner normal reversed, total reflection."""

import math

import numpy as np
import pytest

import conicoid as co

# --- Directions


NORMAL = np.array([0.0, 0.0, 1.0])
CLOSE = {"rel": 4e-16, "abs": 4e-16}


BEYOND = math.asin(0.6) + 1e-6
"""An angle beyond the critical one of a medium of index 5/3, whose sine is 3/5."""


@pytest.mark.parametrize("normal", [NORMAL, -NORMAL])
@pytest.mark.parametrize(("ray", "eta", "refracted"), [
    # sin θ₁ = 3/5, η = 5/6 (the denser is 6/5): sin θ₂ = 1/2, so T is 30° from -N; and back out, where the reversed normal counts
    ((0.6, 0.0, -0.8), 5 / 6, (0.5, 0.0, -math.sqrt(3) / 2)), ((0.5, 0.0, math.sqrt(3) / 2), 6 / 5, (0.6, 0.0, 0.8)),
    ((math.sin(BEYOND), 0.0, math.cos(BEYOND)), 5 / 3, None),
])  # fmt: skip
def test_reflection_and_refraction(ray, eta, refracted, normal):
    """R = 2 (N·L) N - L with L towards the light: here z changes its sign. Rays go along -L."""
    mirrored = [ray[0], 0.0, -ray[2]]
    assert co.reflect(ray, normal) == pytest.approx(mirrored, **CLOSE)
    found, total = co.refract(ray, normal, eta)
    assert total == (refracted is None)
    assert found == pytest.approx(mirrored if refracted is None else refracted, **CLOSE)


# --- The two highlights, in a picture of one pixel: (R·E)^n and (H·N)^n


def pixel(material, theta, offset=0.0):
    light = co.DirectionalLight((-math.sin(math.radians(theta)), 0, -math.cos(math.radians(theta))))
    camera = co.Camera((offset, 0, 5), (offset, 0, 0), up=(0, 1, 0), field_of_view=10)
    scene = co.Scene([co.Body(co.Plane((0, 0, 1), 0), material)], lights=[light], camera=camera, background=(0, 0, 0))
    return np.asarray(scene.render(width=1, height=1, samples=1).pixels)[0, 0]


@pytest.mark.parametrize("theta", [0, 20, 45, 60, 80])
@pytest.mark.parametrize("n", [1, 8, 50])
@pytest.mark.parametrize(("make", "share"), [(co.phong, 1), (co.blinn_phong, 1 / 2)])
def test_highlights(make, share, theta, n):
    black = make(color=(0, 0, 0), specular=(0.75, 0.5, 0), shininess=n)
    expected = np.array((0.75, 0.5, 0)) * math.cos(math.radians(share * theta)) ** n
    assert pixel(black, theta) == pytest.approx(expected, rel=1e-6)
