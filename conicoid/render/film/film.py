"""In which steps a progressive picture gets its samples, and which of its squares are done.

A square of pixels is done when its error (the root of the mean square of its pixels' errors, see `sums`) is not above
what is wanted. That is decided from its own sums alone, and only where it has one of the numbers of samples at which
passes end; while a shutter is open, where whole rounds of its moments do. So neither tiles nor threads nor
interruptions change what is decided.

`sums` holds kernels, and is imported where it is asked for: a scene file is read, and its schema printed, without them.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from ..._jit.decorators import inline
from ..._util.arrays import FloatArray

LEAST_SAMPLES = 32
"""Samples before any error is believed."""
STEP = 64
"""Samples of a pass, at most: so a tile takes some seconds even where a ray takes tens of microseconds."""
_FIRST = (1, 2, 4, 8, 16, 24, 32, 48, 64, 96, 128)


def is_end(samples: int) -> bool:
    """Does a pass end with so many samples?"""
    return samples in _FIRST or (samples > _FIRST[-1] and samples % STEP == 0)


def next_end(samples: int) -> int:
    """With how many samples the pass ends that begins with so many."""
    for end in _FIRST:
        if samples < end:
            return end
    return samples // STEP * STEP + STEP


def square_means(values: FloatArray, side: int) -> FloatArray:
    """(rows, columns): means over squares of so many pixels a side, those at the edges over what there is of them."""
    height, width = values.shape
    rows, columns = np.arange(0, height, side), np.arange(0, width, side)
    total = np.add.reduceat(np.add.reduceat(values, rows, axis=0), columns, axis=1)
    sizes = np.diff(np.append(rows, height))[:, None] * np.diff(np.append(columns, width))
    return np.asarray(total / sizes)


def square_errors(sums: FloatArray, side: int) -> FloatArray:
    """(rows, columns): the error of each square."""
    return np.asarray(np.sqrt(square_means(pixel_errors(sums) ** 2, side)))


def image_error(sums: FloatArray) -> float:
    """The error of a whole picture: the root of the mean square of its pixels'."""
    return float(np.sqrt((pixel_errors(sums) ** 2).mean()))


def select_squares(
    sums: FloatArray, last: int, noise: float | None, side: int, is_judged: Callable[[int], bool] = is_end
) -> npt.NDArray[np.int8]:
    """(rows, columns): 1 for each square that is to get samples in a pass that ends with `last`.

    is_judged: may the noise of a square with so many samples end it?
    """
    count = sums[::side, ::side, COUNT]
    more = count < last
    if noise is not None and last > LEAST_SAMPLES and more.any():
        ends = np.isin(count, [n for n in np.unique(count) if n >= LEAST_SAMPLES and is_judged(int(n))])
        more &= ~(ends & (square_errors(sums, side) <= noise))
    return more.astype(np.int8)


# Sums of a pixel's samples: red, green, blue, the squares of the luminance, and how many samples there are.
#
# The error of a pixel is the standard error s of the mean of its luminance L, told as a step of brightness on the scale
# on which pictures are displayed: √(L + s) - √L, with the square root for the display's curve, and 1 for white. It
# takes
# samples for independent; those of Sobol's points are better than that, so the true error is at most about this one.

SQUARES, COUNT, SUMS = 3, 4, 5
"""The column of the squares, that of the number of samples, and how many columns there are."""
RED, GREEN, BLUE = 0.2126, 0.7152, 0.0722
"""Shares of the luminance (ITU-R BT.709)."""


@inline
def luminance(r: float, g: float, b: float) -> float:
    """Luminance of linear light."""
    return RED * r + GREEN * g + BLUE * b


def mean_pixels(sums: FloatArray) -> Any:
    """(..., 3) float32: the means, as the tile loop works them out; 0 where there are no samples."""
    count = np.maximum(sums[..., COUNT], 1.0)
    return (sums[..., :3] / count[..., None]).astype(np.float32)


def pixel_errors(sums: FloatArray) -> FloatArray:
    """(...): the error of each pixel; inf of fewer than two samples."""
    count = sums[..., COUNT]
    enough = np.maximum(count, 2.0)
    mean = (RED * sums[..., 0] + GREEN * sums[..., 1] + BLUE * sums[..., 2]) / enough
    variance = np.maximum(sums[..., SQUARES] / enough - mean * mean, 0.0) / (enough - 1.0)
    light = np.maximum(mean, 0.0)
    error = np.sqrt(light + np.sqrt(variance)) - np.sqrt(light)
    return np.where(count >= 2.0, error, np.inf)
