"""The film: sums of samples and their errors, reconstruction filters, and layers beside the light.

A square of pixels is done when its error (the root mean square of the errors of its pixels) is not above the limit.
Only its own sums decide that, and only at the numbers of samples at which passes end; while a shutter is open, at the
ends of whole rounds of its moments. So neither tiles nor threads nor interruptions change the decision.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from typing import Any, NoReturn

import numpy as np
import numpy.typing as npt

from .._util.records import FloatArray
from .._util.text import check_choice, near_name
from .._util.validation import format_value
from ..numerics.portable_math import portable_cos, portable_exp, portable_interp
from .options import FILTERS, LAYERS, Filter

# Passes of a progressive picture, errors of its pixels, and the squares that need more samples

LEAST_SAMPLES = 32
"""Samples before an error is taken into account: from fewer it is too uncertain."""
STEP = 64
"""Samples of a pass, at most: a tile takes some seconds even if a ray takes tens of microseconds."""
_FIRST = (1, 2, 4, 8, 16, 24, 32, 48, 64, 96, 128)


def is_end(samples: int) -> bool:
    """Return whether a pass ends with so many samples."""
    return samples in _FIRST or (samples > _FIRST[-1] and samples % STEP == 0)


def next_end(samples: int) -> int:
    """Return the number of samples at the end of the pass that begins with so many."""
    for end in _FIRST:
        if samples < end:
            return end
    return samples // STEP * STEP + STEP


def square_means(values: FloatArray, side: int) -> FloatArray:
    """Return means (rows, columns) over squares of so many pixels a side; at the edges over the pixels inside."""
    height, width = values.shape
    rows, columns = np.arange(0, height, side), np.arange(0, width, side)
    total = np.add.reduceat(np.add.reduceat(values, rows, axis=0), columns, axis=1)
    sizes = np.diff(np.append(rows, height))[:, None] * np.diff(np.append(columns, width))
    return np.asarray(total / sizes)


def square_errors(sums: FloatArray, side: int) -> FloatArray:
    """Return the error of each square (rows, columns)."""
    return np.asarray(np.sqrt(square_means(pixel_errors(sums) ** 2, side)))


def image_error(sums: FloatArray) -> float:
    """Return the error of a whole picture: the root of the mean square of its pixels' errors."""
    return float(np.sqrt((pixel_errors(sums) ** 2).mean()))


def select_squares(
    sums: FloatArray, last: int, noise: float | None, side: int, is_judged: Callable[[int], bool] = is_end
) -> npt.NDArray[np.int8]:
    """Return (rows, columns) with 1 for each square that gets samples in a pass that ends with `last`.

    Parameters
    ----------
    sums
        The sums of all pixels (height, width, SUMS).
    last
        The number of samples at the end of the pass.
    noise
        The error at which a square is done; None if samples alone decide.
    side
        Pixels along a square.
    is_judged
        Return whether the error of a square with so many samples may end it.

    """
    count = sums[::side, ::side, COUNT]
    more = count < last
    if noise is not None and last > LEAST_SAMPLES and more.any():
        ends = np.isin(count, [n for n in np.unique(count) if n >= LEAST_SAMPLES and is_judged(int(n))])
        more &= ~(ends & (square_errors(sums, side) <= noise))
    return more.astype(np.int8)


# Sums of a pixel's samples: red, green, blue, the squares of the luminance, and how many samples there are.
#
# The error of a pixel is the standard error s of the mean of its luminance L, as a step of brightness on the scale on
# which pictures are displayed: √(L + s) - √L, with the square root for the curve of the display, and 1 for white. It
# assumes independent samples; those of Sobol's points are better, so the true error is at most about this one.

SQUARES, COUNT, SUMS = 3, 4, 5
"""The column of the squares, the column of the number of samples, and the number of columns."""
RED, GREEN, BLUE = 0.2126, 0.7152, 0.0722
"""Shares of the luminance (ITU-R BT.709)."""


def mean_pixels(sums: FloatArray) -> Any:
    """Return the means (..., 3) float32, as the tile loop computes them; 0 without samples."""
    count = np.maximum(sums[..., COUNT], 1.0)
    return (sums[..., :3] / count[..., None]).astype(np.float32)


def pixel_errors(sums: FloatArray) -> FloatArray:
    """Return the error of each pixel (...); inf for fewer than two samples."""
    count = sums[..., COUNT]
    enough = np.maximum(count, 2.0)
    mean = (RED * sums[..., 0] + GREEN * sums[..., 1] + BLUE * sums[..., 2]) / enough
    variance = np.maximum(sums[..., SQUARES] / enough - mean * mean, 0.0) / (enough - 1.0)
    light = np.maximum(mean, 0.0)
    error = np.sqrt(light + np.sqrt(variance)) - np.sqrt(light)
    return np.where(count >= 2.0, error, np.inf)


# Reconstruction filters: the weight of a sample for a pixel by its place about the pixel's middle
#
# A filter f(x) f(y) is sampled: samples lie in proportion to |f| and count by its sign (Ernst, Stamminger and
# Greiner, Filter importance sampling, 2006). So each pixel has samples of its own, whatever tiles or threads it is in.
#
# - box: the square of the pixel.
# - tent: 1 - |x| for |x| < 1.
# - gaussian: exp(-2 x²) - exp(-2 · 1.5²) for |x| < 1.5, a standard deviation of about half a pixel.
# - mitchell: the cubic with B = C = 1/3 for |x| < 2 (Mitchell and Netravali, Reconstruction filters in computer
#   graphics, 1988), which sharpens a little: it is negative beyond 8/7.
# - blackman-harris: the four-term window (Harris, On the use of windows, 1978) for |x| < 1.5.

QUANTILES = 1025
"""Number of quantiles, from 0 to 1 in even steps, of the absolute value of a filter."""
_FINE = 1 << 16
_HARRIS = (0.35875, 0.48829, 0.14128, 0.01168)
ZERO_OF_MITCHELL = 8 / 7
RADII = {"box": 0.5, "tent": 1.0, "gaussian": 1.5, "mitchell": 2.0, "blackman-harris": 1.5}
"""Pixels from a pixel's middle to the end of a filter."""


def gaussian(x: FloatArray) -> FloatArray:
    """Return exp(-2 x²), lowered so that it ends at 0."""
    return np.asarray(np.maximum(portable_exp(-2.0 * x * x) - portable_exp(-2.0 * 1.5 * 1.5), 0.0))


def mitchell(x: FloatArray) -> FloatArray:
    """Return the cubic of Mitchell and Netravali with B = C = 1/3."""
    x = np.abs(x)
    inner = (7.0 * x * x * x - 12.0 * x * x + 16.0 / 3.0) / 6.0
    outer = (-7.0 / 3.0 * x * x * x + 12.0 * x * x - 20.0 * x + 32.0 / 3.0) / 6.0
    return np.where(x < 1.0, inner, np.where(x < 2.0, outer, 0.0))


def blackman_harris(x: FloatArray) -> FloatArray:
    """Return a₀ - a₁ cos t + a₂ cos 2t - a₃ cos 3t with t from 0 to 2π across the window."""
    t = (x / RADII["blackman-harris"] + 1.0) * math.pi
    c, (a0, a1, a2, a3) = portable_cos(t), _HARRIS
    return np.asarray(a0 - a1 * c + a2 * (2.0 * c * c - 1.0) - a3 * (4.0 * c * c * c - 3.0 * c))


_CURVES: dict[str, Callable[[FloatArray], FloatArray]] = {
    "box": np.ones_like,
    "tent": lambda x: 1.0 - np.abs(x),
    "gaussian": gaussian,
    "mitchell": mitchell,
    "blackman-harris": blackman_harris,
}


def check_filter(owner: str, value: Any) -> Filter:
    """Return the name of a filter; raise ValueError for any other value, in the name of `owner`."""
    return check_choice(owner, "filter", value, FILTERS)


@functools.cache
def lower_filter(name: Filter) -> tuple[FloatArray, float, float]:
    """Return (quantiles of |f|, the |x| from which f is negative, the weight of a sample along both axes together)."""
    radius = RADII[name]
    edges = np.linspace(-radius, radius, _FINE + 1)
    middles = 0.5 * (edges[1:] + edges[:-1])
    values = _CURVES[name](middles)
    sums = np.concatenate([[0.0], np.cumsum(np.abs(values))])
    quantiles = portable_interp(np.linspace(0.0, sums[-1], QUANTILES), sums, edges)
    quantiles = 0.5 * (quantiles - quantiles[::-1])  # symmetric to the bit
    quantiles.setflags(write=False)
    share = float(sums[-1] / np.cumsum(values)[-1])
    return quantiles, ZERO_OF_MITCHELL if name == "mitchell" else math.inf, share * share


# Layers of a picture beside its light: their names, checked, and their mapping

SUM_LAYERS = ("samples", "error")


class Layers(dict[str, Any]):
    """The layers of a picture by name. A missing one raises an error that names the argument of `render` for it."""

    def __missing__(self, name: object) -> NoReturn:
        if name not in LAYERS:
            raise KeyError(f"no layer is called {format_value(name)}: those are {', '.join(LAYERS)}")
        raise KeyError(
            f"the picture was rendered without {format_value(name)}: scene.render(layers=[{format_value(name)}]) has it"
        )


def check_layers(value: Any) -> tuple[str, ...]:
    """Return the names of layers in their order, all of them for True, none for None or False.

    Raise TypeError or ValueError for anything else.
    """
    if value is True:
        return tuple(LAYERS)
    if value is None or value is False:
        return ()
    names = [value] if isinstance(value, str) else value
    if not isinstance(names, list | tuple | set | frozenset):
        raise TypeError(f"render: layers must be names of layers, or True for all, got {format_value(value)}")
    for name in names:
        if not isinstance(name, str) or name not in LAYERS:
            found = f"{format_value(name)}{near_name(name, LAYERS)}"
            raise ValueError(f"render: layers must be of {', '.join(LAYERS)}, got {found}")
    return tuple(name for name in LAYERS if name in names)
