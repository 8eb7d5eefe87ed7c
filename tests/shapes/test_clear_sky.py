"""The clear sky: blue away from the sun, brightest at it, and lit ground below."""

from __future__ import annotations

import numpy as np
import pytest

import conicoid as co


def at(image, direction):
    """The pixel of a direction."""
    height, width, _ = image.pixels.shape
    x, y, z = np.array(direction) / np.linalg.norm(direction)
    row = min(height - 1, int(np.arccos(z) / np.pi * height))
    return image.pixels[row, int(np.arctan2(y, x) / (2 * np.pi) % 1 * width) % width]


def test_the_zenith_has_the_luminance_and_chromaticity_of_the_formula():
    """Its luminance in kcd/m² at the zenith is that of the formula; r, g and b make it up by Rec. 709."""
    sky = co.materials.clear_sky((1, 0, 1), 3.0, intensity=1.0, height=512)
    r, g, b = at(sky, (1e-6, 0, 1))
    chi = (4 / 9 - 3 / 120) * (np.pi - 2 * np.pi / 4)
    luminance = (4.0453 * 3 - 4.9710) * np.tan(chi) - 0.2155 * 3 + 2.4192
    assert 0.2126 * r + 0.7152 * g + 0.0722 * b == pytest.approx(luminance, rel=0.02)
    assert b > g > r


def test_it_is_brightest_at_the_sun():
    sky = co.materials.clear_sky((1, 1, 1), 3.0, height=64)
    light = sky.pixels[:32].mean(axis=2)
    row, column = np.unravel_index(light.argmax(), light.shape)
    theta, phi = (row + 0.5) / 64 * 180, (column + 0.5) / 128 * 360
    assert phi == pytest.approx(45, abs=4)
    assert theta >= 50  # near the sun, on the side of the horizon


def test_the_ground_sends_back_its_share():
    """Radiance ρ E / π below the horizon, E = ∫ L cos; linear in the reflectance."""
    dark, bright = (co.materials.clear_sky(ground=(k, k, k), height=32).pixels[-1, 0] for k in (0.1, 0.4))
    assert bright == pytest.approx(4 * dark, rel=1e-6)
    assert (co.materials.clear_sky(ground="black", height=32).pixels[16:] == 0).all()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (dict(sun=(0, 0, -1)), "clear_sky: sun must not be below the horizon"),
        (dict(turbidity=1), r"clear_sky: turbidity must be in \[2, 10\], got 1.0"),
        (dict(height=2), "clear_sky: height must be a whole number from 4 to 4096, got 2"),
    ],
)
def test_what_is_no_sky_is_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        co.materials.clear_sky(**arguments)


@pytest.mark.parametrize(
    ("pixels", "message"),
    [
        (np.ones((4, 8)), r"Environment: pixels must have shape \(height, width, 3\), got \(4, 8\)"),
        (-np.ones((4, 8, 3)), r"Environment: pixels\[0, 0, 0\] must be finite and >= 0, got -1.0"),
    ],
)
def test_what_is_no_image_of_surroundings_is_refused(pixels, message):
    with pytest.raises(ValueError, match=message):
        co.Environment(pixels)
