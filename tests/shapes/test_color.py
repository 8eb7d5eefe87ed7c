"""Colours: sRGB by the standard's formula, names, and what is refused."""

from __future__ import annotations

import math

import numpy as np
import pytest

from conicoid.materials.color import amount_rgb, check_amount, check_color, linear_rgb, srgb_decode, srgb_encode


def encoded(linear: float) -> float:
    """IEC 61966-2-1, one number at a time."""
    return 12.92 * linear if linear <= 0.0031308 else 1.055 * math.pow(linear, 1 / 2.4) - 0.055


def test_encoding_follows_the_standard():
    values = np.linspace(0, 1, 1001)
    assert np.abs(srgb_encode(values) - [encoded(v) for v in values]).max() < 1e-15
    assert srgb_encode(0.0) == 0
    assert srgb_encode(1.0) == pytest.approx(1, abs=1e-15)


def test_middle_grey():
    """0.5 of sRGB is ((0.5 + 0.055) / 1.055)^2.4 = 0.21404114 of light."""
    assert srgb_decode(0.5) == pytest.approx(0.21404114048223255, rel=1e-15)


def test_every_byte_survives_decoding_and_encoding():
    byte = np.arange(256)
    assert (np.rint(255 * srgb_encode(srgb_decode(byte / 255))) == byte).all()


def test_texts_are_srgb():
    half = ((0x80 / 255 + 0.055) / 1.055) ** 2.4
    assert linear_rgb("#ff0080") == pytest.approx((1, 0, half), rel=1e-15)
    assert linear_rgb("#f08") == linear_rgb("#ff0088")
    assert linear_rgb("white") == (1, 1, 1)
    assert linear_rgb("SteelBlue") == linear_rgb("#4682b4")
    assert linear_rgb((0.1, 0.2, 0.3)) == (0.1, 0.2, 0.3)


def test_colours_stay_as_written():
    assert check_color("M", "c", "#ff0080") == "#ff0080"
    assert check_color("M", "c", [1, 0, 0.5]) == (1.0, 0.0, 0.5)
    assert check_amount("M", "c", np.float32(0.5)) == 0.5
    assert amount_rgb(0.25) == (0.25, 0.25, 0.25)


@pytest.mark.parametrize(
    "bad", ["reddish", "#12345", "#gggggg", "", "hsl(0, 0%, 0%)", (1, 0), (1, 0, 2), (0, math.nan, 0), None, 1]
)
def test_what_is_no_colour_is_refused_by_name(bad):
    with pytest.raises(ValueError, match="Material: color"):
        check_color("Material", "color", bad)
