"""Linear light as bytes of sRGB, as pictures hold them.

A byte is what `srgb_encode` gives, rounded. That takes two roots for each number; but it only rises, so the byte is the
number of thresholds that a value has reached: of the two that the first eight bits of its fraction leave open, one
comparison decides.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np

from ..engine.tables import Floats
from ..shapes.color import srgb_encode

_SHIFT = 44  # what follows the first eight bits of the fraction of a float64
_FIRST = (1023 - 13) << 8  # the beginning of 2^-13; what is less is black
_AT_ONCE = 1 << 14  # numbers: they stay in the cache


def srgb_bytes(pixels: Any) -> Any:
    """Linear pixels as uint8 of sRGB: cut to [0, 1], NaN is black."""
    given = np.ascontiguousarray(pixels)
    values, codes = given.reshape(-1), np.empty(given.size, np.uint8)
    below, next_above = _table()
    for begin in range(0, len(values), _AT_ONCE):
        part = values[begin : begin + _AT_ONCE].astype(np.float64)
        with np.errstate(invalid="ignore"):
            np.copyto(part, 0.0, where=~(part > 0.0))
        np.minimum(part, 1.0, out=part)
        first = below[np.maximum((part.view(np.int64) >> _SHIFT) - _FIRST, 0)]
        np.add(first, part >= next_above[first], out=codes[begin : begin + _AT_ONCE])
    return codes.reshape(given.shape)


def srgb_words(pixels: Any) -> Any:
    """The same as uint16, 65,535 being white: by the formula, as a table of so many thresholds takes as long."""
    cut = np.clip(np.nan_to_num(np.asarray(pixels, dtype=np.float64), nan=0.0, posinf=1.0), 0.0, 1.0)
    return np.rint(65535 * srgb_encode(cut)).astype(np.uint16)


def _codes(values: Floats) -> Any:
    """Bytes of linear values in [0, 1], by the formula."""
    return np.rint(255 * srgb_encode(values)).astype(np.uint8)


@lru_cache(maxsize=1)
def _table() -> tuple[Any, Floats]:
    """The byte of the least number with each beginning, and the least number of the byte that follows each."""
    beginnings = np.arange(_FIRST, (1023 << 52 >> _SHIFT) + 1)
    low, high = np.zeros(255, np.int64), np.full(255, 1023 << 52, np.int64)  # bits of 0 and of 1, in the same order
    wanted = np.arange(1, 256)
    while (high - low > 1).any():
        middle = (low + high) >> 1
        reached = _codes(middle.view(np.float64)) >= wanted
        low, high = np.where(reached, low, middle), np.where(reached, middle, high)
    return _codes((beginnings << _SHIFT).view(np.float64)), np.append(high.view(np.float64), np.inf)
