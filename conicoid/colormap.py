"""Colour maps: numbers to colours of evenly rising lightness."""

from __future__ import annotations

import numpy as np

from .shapes.vector import FloatArray

_MISSING = 0.8  # linear grey of numbers that are not finite

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


def mapped(values: FloatArray, name: str, low: float | None = None, high: float | None = None) -> FloatArray:
    """Linear colours (..., 3) of numbers (...), from `low` to `high`; beyond them the end colours.

    The ends default to the least and the greatest finite number. Raises ValueError if low > high or either is NaN.
    """
    numbers = np.asarray(values, dtype=np.float64)
    finite = np.isfinite(numbers)
    low = low if low is not None else float(numbers[finite].min(initial=np.inf)) if finite.any() else 0.0
    high = high if high is not None else float(numbers[finite].max(initial=-np.inf)) if finite.any() else 1.0
    if not low <= high:
        raise ValueError(f"Image: vmin must be <= vmax, got {low:g} and {high:g}")
    # Halves, as the difference of two numbers may be beyond float64
    share = np.where(finite, numbers / 2 - low / 2, 0.0) / (high / 2 - low / 2 or 0.5)
    colors = _along(np.array(COLORMAPS[name]), np.clip(share, 0.0, 1.0))
    return np.where(finite[..., None], colors, _MISSING)


def _along(controls: FloatArray, share: FloatArray) -> FloatArray:
    """Linear rgb at shares of the way along control colours, interpolated in Oklab's polar form."""
    steps = np.linspace(0.0, 1.0, len(controls))
    lightness, chroma, hue = (np.interp(share, steps, column) for column in controls.T)
    angle = np.radians(hue)
    lab = np.stack([lightness, chroma * np.cos(angle), chroma * np.sin(angle)], axis=-1)
    linear: FloatArray = (lab @ np.array(_CONES).T) ** 3 @ np.array(_RGB).T
    return np.clip(linear, 0.0, 1.0)
