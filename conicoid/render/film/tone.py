"""Tone curves: linear light to the range of a display, in place of cutting it off at white.

- srgb: nothing but the cut; the default.
- filmic: John Hable's curve (Filmic tonemapping operators, 2010; Uncharted 2), with its white point 11.2, for each
  channel: h(2x) / h(11.2), h(x) = (x (A x + C B) + D E) / (x (A x + B) + D F) - E / F.
- agx: Troy Sobotka's AgX as Benjamin Wrensch writes it (Minimal AgX implementation, 2023): the channels are mixed a
  little, so that bright colours go to white and not to another hue, log2 from 12.47 stops below 1 to 4.03 above, a
  polynomial of degree 6, and mixed back.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..._util.arrays import FloatArray, matmul_rows
from ..._util.hints import check_choice
from ..._util.validation import check_number
from ...materials.color import srgb_decode
from ...numerics.portable_math import portable_exp2, portable_log2
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
    return _filmic(light) if tone == "filmic" else _agx(light)


def _hable(x: FloatArray | float) -> Any:
    """Return h(x) of Hable's curve."""
    a, b, c, d, e, f = 0.15, 0.50, 0.10, 0.20, 0.02, 0.30
    return (x * (a * x + c * b) + d * e) / (x * (a * x + b) + d * f) - e / f


def _filmic(light: FloatArray) -> Any:
    return np.minimum(_hable(2.0 * np.minimum(light, 1e6)) / _hable(11.2), 1.0)


def _agx(light: FloatArray) -> Any:
    mixed = np.maximum(matmul_rows(light, _INSET.T), 1e-30)
    x = np.clip((portable_log2(mixed) - _LEAST_STOP) / (_LAST_STOP - _LEAST_STOP), 0.0, 1.0)
    y = np.zeros_like(x)
    for coefficient in _AGX:
        y = y * x + coefficient
    return srgb_decode(np.clip(matmul_rows(y, _OUTSET.T), 0.0, 1.0))
