"""Sums of samples: passes of a progressive picture, errors of its pixels, and the squares that need more samples.

A square of pixels is done when its error (the root mean square of the errors of its pixels) is not above the limit.
Only its own sums decide that, and only at the numbers of samples at which passes end; while a shutter is open, at the
ends of whole rounds of its moments. So neither tiles nor threads nor interruptions change the decision.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from ..._util.arrays import FloatArray

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
