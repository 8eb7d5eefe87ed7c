"""Sums of a pixel's samples: red, green, blue, the squares of the luminance, and how many samples there are.

The error of a pixel is the standard error s of the mean of its luminance L, told as a step of brightness on the scale
on which pictures are displayed: √(L + s) - √L, with the square root for the display's curve, and 1 for white. It takes
samples for independent; those of Sobol's points are better than that, so the true error is at most about this one.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..compiler.jit import inline
from ..shapes.vector import FloatArray

SQUARES, COUNT, SUMS = 3, 4, 5
"""The column of the squares, that of the number of samples, and how many columns there are."""
RED, GREEN, BLUE = 0.2126, 0.7152, 0.0722
"""Shares of the luminance (ITU-R BT.709)."""


@inline
def luminance(r: float, g: float, b: float) -> float:
    """Luminance of linear light."""
    return RED * r + GREEN * g + BLUE * b


def pixels_of(sums: FloatArray) -> Any:
    """(..., 3) float32: the means, as the tile loop works them out; 0 where there are no samples."""
    count = np.maximum(sums[..., COUNT], 1.0)
    return (sums[..., :3] / count[..., None]).astype(np.float32)


def errors_of(sums: FloatArray) -> FloatArray:
    """(...): the error of each pixel; inf of fewer than two samples."""
    count = sums[..., COUNT]
    enough = np.maximum(count, 2.0)
    mean = (RED * sums[..., 0] + GREEN * sums[..., 1] + BLUE * sums[..., 2]) / enough
    variance = np.maximum(sums[..., SQUARES] / enough - mean * mean, 0.0) / (enough - 1.0)
    light = np.maximum(mean, 0.0)
    error = np.sqrt(light + np.sqrt(variance)) - np.sqrt(light)
    return np.where(count >= 2.0, error, np.inf)
