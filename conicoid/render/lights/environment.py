"""Backgrounds: the colour of rays that hit nothing, and images of all directions as sources of light."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from ..._jit.decorators import helper, inline, record_shapes
from ..._util.arrays import Vector
from ...kernels.body.uv import turns
from ...kernels.numbers.elementary import acos, cos_sin_turns
from ...kernels.tables import Floats
from ...materials.color import Color, linear_rgb
from ...materials.light import DEFAULT_BACKGROUND, Background, Environment, Sky
from ...numerics.portable_math import sin_cos_degrees
from ..sampling import Direction

Colors: TypeAlias = tuple[tuple[float, float, float], tuple[float, float, float], tuple[float, float, float]]


def lower_background(background: Background | None) -> Colors:
    """Return the colours straight up, at the horizon and straight down; of an image the means of three strips."""
    sky = DEFAULT_BACKGROUND if background is None else background
    if isinstance(sky, Sky):
        zenith, horizon = _times(sky.intensity, sky.zenith), _times(sky.intensity, sky.horizon)
        return zenith, horizon, horizon if sky.ground is None else _times(sky.intensity, sky.ground)
    if isinstance(sky, Environment):
        return _means(sky)
    color = linear_rgb(sky)
    return color, color, color


def _means(image: Environment) -> Colors:
    """Return the mean colours of the uppermost, the middle and the lowest tenth of an image."""
    pixels = image.radiance
    height = len(pixels)
    part = max(1, height // 10)
    middle = (height - part) // 2
    strips = pixels[:part], pixels[middle : middle + part], pixels[-part:]
    zenith, horizon, ground = (strip.mean(axis=(0, 1)).tolist() for strip in strips)
    return tuple(zenith), tuple(horizon), tuple(ground)


def _times(intensity: float, color: Color) -> Vector:
    """Return a colour times a number, linear rgb."""
    r, g, b = linear_rgb(color)
    return intensity * r, intensity * g, intensity * b


@inline
def background_color(colors: Colors, dz: float) -> tuple[float, float, float]:
    """Return the colour along a unit direction: from the horizon on it is linear in sqrt|dz|."""
    zenith, horizon, ground = colors
    s = math.sqrt(min(1.0, abs(dz)))
    if dz > 0.0:
        return (
            blend_colors(horizon[0], zenith[0], s),
            blend_colors(horizon[1], zenith[1], s),
            blend_colors(horizon[2], zenith[2], s),
        )
    return (
        blend_colors(horizon[0], ground[0], s),
        blend_colors(horizon[1], ground[1], s),
        blend_colors(horizon[2], ground[2], s),
    )


@inline
def blend_colors(a: float, b: float, s: float) -> float:
    """Return a at s = 0, b at s = 1, linear between them."""
    return a + s * (b - a)


# An image of all directions as a source of light, sampled by its brightness
#
# Longitude is the angle about z from the x axis, counter-clockwise, along rows of the image from left to right; the
# first row is straight up. Between the middles of pixels radiance is bilinear. Directions are drawn by rows and then by
# columns of a table of the pixels' brightness times their solid angle (Pharr, Jakob and Humphreys, Physically Based
# Rendering, 4th edition, section 12.5).


@record_shapes(pixels="image", rows="*", columns="*", width="0..image", height="0..image")
class EnvironmentTable(NamedTuple):
    """An image around a scene; its width is 0 if there is none."""

    pixels: Floats  # (height width 3)
    rows: Floats  # (height + 1) the share of light above a row
    columns: Floats  # (height (width + 1)) in each row the share of light to the left of a column
    width: int
    height: int


NO_ENVIRONMENT = EnvironmentTable(np.zeros(0), np.zeros(0), np.zeros(0), 0, 0)


def lower_environment(pixels: npt.NDArray[Any] | None) -> EnvironmentTable:
    """Return the tables of an image of the surroundings (height, width, 3); `NO_ENVIRONMENT` for None."""
    if pixels is None:
        return NO_ENVIRONMENT
    image = np.ascontiguousarray(pixels, np.float64)
    height, width, _ = image.shape
    light = _spread(image.mean(axis=2))
    edges = _heights(height)
    weights = light * (edges[:-1] - edges[1:])[:, None]
    columns = np.zeros((height, width + 1))
    np.cumsum(weights, axis=1, out=columns[:, 1:])
    sums = columns[:, -1].copy()
    columns /= np.where(sums > 0, sums, 1.0)[:, None]
    columns[:, -1] = 1.0
    rows = np.concatenate([[0.0], np.cumsum(sums)])
    rows = rows / rows[-1] if rows[-1] > 0 else rows
    rows[-1] = 1.0
    return EnvironmentTable(image.ravel(), rows, columns.ravel(), width, height)


def _heights(rows: int) -> npt.NDArray[np.float64]:
    """Return z of the edges of rows, from 1 to -1, rounded once."""
    return np.array([sin_cos_degrees(Fraction(180 * k, rows))[1] for k in range(rows + 1)])


def mean_radiance(pixels: npt.NDArray[Any]) -> float:
    """Return the mean radiance of all directions."""
    edges = _heights(len(pixels))
    weights: Any = (edges[:-1] - edges[1:])[:, None]
    return float((np.asarray(pixels, np.float64).mean(axis=2) * weights).sum() / (2 * pixels.shape[1]))


def _spread(light: Any) -> Any:
    """Return the brightness of pixels, blended with an eighth of each neighbour, as bilinear values reach over."""
    along = (np.roll(light, 1, axis=1) + 6 * light + np.roll(light, -1, axis=1)) / 8
    above, below = np.concatenate([along[:1], along[:-1]]), np.concatenate([along[1:], along[-1:]])
    return (above + 6 * along + below) / 8


@inline
def _pixel(around_all: EnvironmentTable, row: int, column: int, c: int) -> float:
    """Return a channel of a pixel; rows end at the poles, columns go around."""
    row = min(around_all.height - 1, max(0, row))
    column = column - around_all.width if column >= around_all.width else column
    column = column + around_all.width if column < 0 else column
    return float(around_all.pixels[3 * (row * around_all.width + column) + c])


@inline
def _blend(around_all: EnvironmentTable, row: int, column: int, s: float, t: float, c: int) -> float:
    """Return a channel between four pixels."""
    above = (1.0 - t) * _pixel(around_all, row, column, c) + t * _pixel(around_all, row, column + 1, c)
    below = (1.0 - t) * _pixel(around_all, row + 1, column, c) + t * _pixel(around_all, row + 1, column + 1, c)
    return (1.0 - s) * above + s * below


@inline
def _place(around_all: EnvironmentTable, dx: float, dy: float, dz: float) -> tuple[float, float]:
    """Return (row, column) of a unit direction, in pixels from the corner."""
    row = acos(min(1.0, max(-1.0, dz))) / math.pi * around_all.height
    return row, turns(dx, dy) * around_all.width


@helper
def environment_radiance(around_all: EnvironmentTable, dx: float, dy: float, dz: float) -> tuple[float, float, float]:
    """Return the radiance, rgb, from a unit direction."""
    row, column = _place(around_all, dx, dy, dz)
    above, left = int(np.floor(row - 0.5)), int(np.floor(column - 0.5))
    s, t = row - 0.5 - above, column - 0.5 - left
    return (
        _blend(around_all, above, left, s, t, 0),
        _blend(around_all, above, left, s, t, 1),
        _blend(around_all, above, left, s, t, 2),
    )


@inline
def _cell_density(around_all: EnvironmentTable, row: int, column: int) -> float:
    """Return the density of the directions of a pixel: its share of light over its solid angle."""
    w = around_all.width
    share = around_all.rows[row + 1] - around_all.rows[row]
    at = row * (w + 1) + column
    share *= around_all.columns[at + 1] - around_all.columns[at]
    top, _ = cos_sin_turns(0.5 * row / around_all.height)
    bottom, _ = cos_sin_turns(0.5 * (row + 1) / around_all.height)
    return float(share * w / (2.0 * math.pi * (top - bottom)))


@helper
def environment_density(around_all: EnvironmentTable, dx: float, dy: float, dz: float) -> float:
    """Return the density by which `environment_direction` takes a unit direction, per solid angle."""
    row, column = _place(around_all, dx, dy, dz)
    h, w = around_all.height, around_all.width
    return _cell_density(around_all, min(h - 1, int(row)), min(w - 1, int(column)))


@inline
def _last_below(values: Floats, first: int, count: int, u: float) -> int:
    """Return the k with values[first + k] <= u < values[first + k + 1], of `count` intervals."""
    low, high = 0, count - 1
    while low < high:
        middle = (low + high + 1) >> 1
        if values[first + middle] <= u:
            low = middle
        else:
            high = middle - 1
    return low


@helper
def environment_direction(around_all: EnvironmentTable, u: float, v: float) -> tuple[Direction, float]:
    """Return (a unit direction, its density) for two numbers in [0, 1)."""
    h, w = around_all.height, around_all.width
    row = _last_below(around_all.rows, 0, h, u)
    low, high = around_all.rows[row], around_all.rows[row + 1]
    s = (u - low) / (high - low) if high > low else 0.5
    first = row * (w + 1)
    column = _last_below(around_all.columns, first, w, v)
    low, high = around_all.columns[first + column], around_all.columns[first + column + 1]
    t = (v - low) / (high - low) if high > low else 0.5
    top, _ = cos_sin_turns(0.5 * row / h)
    bottom, _ = cos_sin_turns(0.5 * (row + 1) / h)
    z = top + s * (bottom - top)  # uniform in solid angle within the pixel
    c, q = cos_sin_turns(min(1.0, (column + t) / w))
    r = math.sqrt(max(0.0, (1.0 - z) * (1.0 + z)))
    return (r * c, r * q, z), _cell_density(around_all, row, column)
