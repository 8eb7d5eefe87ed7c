"""Colour mapping: linear light to the range of a display by tone curves, and numbers to colours by colour maps.

Tone curves, in place of cutting light off at white:

- srgb: nothing but the cut; the default.
- filmic: John Hable's curve (Filmic tonemapping operators, 2010; Uncharted 2), with its white point 11.2, for each
  channel: h(2x) / h(11.2), h(x) = (x (A x + C B) + D E) / (x (A x + B) + D F) - E / F.
- agx: Troy Sobotka's AgX as Benjamin Wrensch writes it (Minimal AgX implementation, 2023): the channels are mixed a
  little, so that bright colours go to white and not to another hue, log2 from 12.47 stops below 1 to 4.03 above, a
  polynomial of degree 6, and mixed back.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from .._util.records import FloatArray, matmul_rows
from .._util.text import check_choice
from .._util.validation import check_number
from ..materials.color import srgb_decode
from ..numerics.portable_math import portable_exp2, portable_log2
from .options import TONES, Tone

_MOST_STOPS = 64.0

_INSET = np.array([
    (0.842479062253094, 0.0784335999999992, 0.0792237451477643),
    (0.0423282422610123, 0.878468636469772, 0.0791661274605434),
    (0.0423756549057051, 0.0784336, 0.879142973793104),
])  # fmt: skip
_OUTSET = np.array([
    (1.19687900512017, -0.0980208811401368, -0.0990297440797205),
    (-0.0528968517574562, 1.15190312990417, -0.0989611768448433),
    (-0.0529716355144438, -0.0980434501171241, 1.15107367264116),
])  # fmt: skip
_LEAST_STOP, _LAST_STOP = -12.47393, 4.026069
_AGX = (15.5, -40.14, 31.96, -6.868, 0.4298, 0.1191, -0.00232)


def check_tone(owner: str, value: Any) -> Tone:
    """Return the name of a tone curve; raise ValueError for any other value, in the name of `owner`."""
    return check_choice(owner, "tone", value, TONES)


def check_exposure(owner: str, value: Any) -> float:
    """Return stops; raise ValueError for a number beyond ±64, in the name of `owner`."""
    stops = check_number(owner, "exposure", value)
    if not abs(stops) <= _MOST_STOPS:
        raise ValueError(f"{owner}: exposure must be from -{_MOST_STOPS:g} to {_MOST_STOPS:g} stops, got {stops:g}")
    return stops


def apply_tone(pixels: Any, exposure: float, tone: Tone) -> Any:
    """Return displayed light of linear light (..., 3), linear too; values over 1 are cut at white.

    `exposure`: stops, each twice as bright.
    """
    if exposure == 0 and tone == "srgb":
        return pixels
    light = np.nan_to_num(np.asarray(pixels, np.float64), nan=0.0, posinf=1e30, neginf=0.0) * portable_exp2(exposure)
    light = np.maximum(light, 0.0)
    if tone == "srgb":
        return light
    if tone == "agx":
        return _agx(light)
    return np.minimum(_hable(2.0 * np.minimum(light, 1e6)) / _hable(11.2), 1.0)


def _hable(x: FloatArray | float) -> Any:
    """Return h(x) of Hable's curve."""
    a, b, c, d, e, f = 0.15, 0.50, 0.10, 0.20, 0.02, 0.30
    return (x * (a * x + c * b) + d * e) / (x * (a * x + b) + d * f) - e / f


def _agx(light: FloatArray) -> Any:
    mixed = np.maximum(matmul_rows(light, _INSET.T), 1e-30)
    x = np.clip((portable_log2(mixed) - _LEAST_STOP) / (_LAST_STOP - _LEAST_STOP), 0.0, 1.0)
    y = np.zeros_like(x)
    for coefficient in _AGX:
        y = y * x + coefficient
    return srgb_decode(np.clip(matmul_rows(y, _OUTSET.T), 0.0, 1.0))


# --- Colour maps, of evenly rising lightness

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
