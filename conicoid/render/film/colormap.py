"""Colour maps: numbers to colours of evenly rising lightness."""

from __future__ import annotations

import math

import numpy as np

from ..._util.arrays import FloatArray, matmul_rows

_MISSING = 0.8  # linear grey for numbers that are not finite

# Control colours at even steps: Oklab lightness, chroma, and hue in degrees.
_DUSK = (
    (0.16, 0.05, 275),
    (0.32, 0.12, 285),
    (0.47, 0.16, 325),
    (0.62, 0.17, 375),
    (0.76, 0.14, 415),
    (0.96, 0.08, 460),
)
_GREY = ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0))
COLORMAPS = {"dusk": _DUSK, "grey": _GREY}
"""Name -> control colours."""

# Oklab to the cube roots of cone responses, and those responses to linear Rec. 709 (Ottosson 2020).
_CONES = ((1.0, 0.3963377774, 0.2158037573), (1.0, -0.1055613458, -0.0638541728), (1.0, -0.0894841775, -1.2914855480))
_RGB = (
    (4.0767416621, -3.3077115913, 0.2309699292),
    (-1.2684380046, 2.6097574011, -0.3413193965),
    (-0.0041960863, -0.7034186147, 1.7076147010),
)


def apply_colormap(values: FloatArray, name: str, low: float | None = None, high: float | None = None) -> FloatArray:
    """Return linear colours (..., 3) of numbers (...), from `low` to `high`; beyond them the end colours.

    Parameters
    ----------
    values
        Numbers; those that are not finite become grey.
    name
        A name of `COLORMAPS`.
    low, high
        The numbers of the end colours; by default the least and the greatest finite number.

    Raises
    ------
    ValueError
        If low > high or either is NaN.

    """
    numbers = np.asarray(values, dtype=np.float64)
    finite = np.isfinite(numbers)
    low = low if low is not None else float(numbers[finite].min(initial=np.inf)) if finite.any() else 0.0
    high = high if high is not None else float(numbers[finite].max(initial=-np.inf)) if finite.any() else 1.0
    if not low <= high:
        raise ValueError(f"Image: vmin must be <= vmax, got {low:g} and {high:g}")
    # Halves, as the difference of two numbers may be beyond float64
    share = np.where(finite, numbers / 2 - low / 2, 0.0) / (high / 2 - low / 2 or 0.5)
    colors = _interpolate_color(np.array(COLORMAPS[name]), np.clip(share, 0.0, 1.0))
    return np.where(finite[..., None], colors, _MISSING)


def _interpolate_color(controls: FloatArray, share: FloatArray) -> FloatArray:
    """Return linear rgb at shares of the way along control colours, interpolated in Oklab's polar form."""
    place = share * (len(controls) - 1)
    k = np.minimum(place.astype(np.int64), len(controls) - 2)
    lightness, chroma, hue = (column[k] + (place - k) * (column[k + 1] - column[k]) for column in controls.T)
    s, c = _sin_cos_degrees(hue)
    roots = matmul_rows(np.stack([lightness, chroma * c, chroma * s], axis=-1), np.array(_CONES).T)
    return np.clip(matmul_rows(roots * roots * roots, np.array(_RGB).T), 0.0, 1.0)


def _sin_cos_degrees(angles: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return (sines, cosines) by their series: NumPy's differ between processors."""
    quarters = np.rint(angles / 90.0)
    x = np.radians(angles - 90.0 * quarters)
    sine, cosine = np.zeros_like(x), np.zeros_like(x)
    for n in range(16, -1, -2):
        cosine = 1.0 / math.factorial(n) - x * x * cosine
        sine = 1.0 / math.factorial(n + 1) - x * x * sine
    sine = x * sine
    turn = quarters.astype(np.int64) & 3
    return np.choose(turn, [sine, cosine, -sine, -cosine]), np.choose(turn, [cosine, -sine, -cosine, sine])
