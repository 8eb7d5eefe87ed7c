"""What rays see that hit nothing."""

from __future__ import annotations

import math
from typing import TypeAlias

from ..compiler.jit import inline
from ..shapes.background import DEFAULT_BACKGROUND, Background, Environment, Sky
from ..shapes.color import Color, linear_rgb
from ..shapes.vector import Vector

Colors: TypeAlias = tuple[tuple[float, float, float], tuple[float, float, float], tuple[float, float, float]]


def lower_background(background: Background | None) -> Colors:
    """Colours straight up, at the horizon and straight down."""
    sky = DEFAULT_BACKGROUND if background is None else background
    if isinstance(sky, Sky):
        zenith, horizon = _times(sky.intensity, sky.zenith), _times(sky.intensity, sky.horizon)
        return zenith, horizon, horizon if sky.ground is None else _times(sky.intensity, sky.ground)
    if isinstance(sky, Environment):
        return _means(sky)
    color = linear_rgb(sky)
    return color, color, color


def _means(image: Environment) -> Colors:
    """Mean colours of the uppermost, the middle and the lowest tenth of an image."""
    pixels = image.radiance
    height = len(pixels)
    part = max(1, height // 10)
    middle = (height - part) // 2
    strips = pixels[:part], pixels[middle : middle + part], pixels[-part:]
    zenith, horizon, ground = (strip.mean(axis=(0, 1)).tolist() for strip in strips)
    return tuple(zenith), tuple(horizon), tuple(ground)


def _times(intensity: float, color: Color) -> Vector:
    r, g, b = linear_rgb(color)
    return intensity * r, intensity * g, intensity * b


@inline
def background_color(colors: Colors, dz: float) -> tuple[float, float, float]:
    """Colour along a unit direction: from the horizon linear in sqrt|dz|."""
    zenith, horizon, ground = colors
    s = math.sqrt(min(1.0, abs(dz)))
    if dz > 0.0:
        return between(horizon[0], zenith[0], s), between(horizon[1], zenith[1], s), between(horizon[2], zenith[2], s)
    return between(horizon[0], ground[0], s), between(horizon[1], ground[1], s), between(horizon[2], ground[2], s)


@inline
def between(a: float, b: float, s: float) -> float:
    """a at s = 0, b at s = 1."""
    return a + s * (b - a)
