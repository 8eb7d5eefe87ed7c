"""Colours for materials: by their number alone, far apart for neighbouring numbers.

Hue and lightness follow the two-dimensional sequence of Roberts ("The unreasonable effectiveness of
quasirandom sequences", 2018), whose points keep apart however many are taken, in the perceptual
space OKLCh (Björn Ottosson, "A perceptual color space for image processing", 2020).
"""

from __future__ import annotations

import math

from ...shapes.color import srgb_encode
from ...shapes.rounded import sin_cos

_PLASTIC = 1.324717957244746  # the real root of x³ = x + 1
_CHROMA = 0.15


def color_of(number: int) -> str:
    """The colour of the material with this number, as #rrggbb."""
    hue = 2 * math.pi * ((0.385 + number / _PLASTIC) % 1)
    lightness = 0.55 + 0.32 * ((0.5 + number / (_PLASTIC * _PLASTIC)) % 1)
    chroma = _CHROMA
    while not all(-1e-9 <= channel <= 1 + 1e-9 for channel in linear_of_oklch(lightness, chroma, hue)):
        chroma *= 0.95
    channels = srgb_encode([min(max(c, 0.0), 1.0) for c in linear_of_oklch(lightness, chroma, hue)])
    return "#" + "".join(f"{round(255 * channel):02x}" for channel in channels.tolist())


def linear_of_oklch(lightness: float, chroma: float, hue: float) -> tuple[float, float, float]:
    """Linear light (Rec. 709 primaries) of OKLCh, hue in radians; outside of [0, 1] where no screen can show it."""
    s, c = sin_cos(hue)
    a, b = chroma * c, chroma * s
    long = _cubed(lightness + 0.3963377774 * a + 0.2158037573 * b)
    medium = _cubed(lightness - 0.1055613458 * a - 0.0638541728 * b)
    short = _cubed(lightness - 0.0894841775 * a - 1.2914855480 * b)
    return (
        4.0767416621 * long - 3.3077115913 * medium + 0.2309699292 * short,
        -1.2684380046 * long + 2.6097574011 * medium - 0.3413193965 * short,
        -0.0041960863 * long - 0.7034186147 * medium + 1.7076147010 * short,
    )


def _cubed(x: float) -> float:
    return x * x * x
