"""Reconstruction filters: the weight of a sample for a pixel by its place about the pixel's middle.

A filter f(x) f(y) is sampled: samples lie in proportion to |f| and count by its sign (Ernst, Stamminger and
Greiner, Filter importance sampling, 2006). So each pixel has samples of its own, whatever tiles or threads it is in.

- box: the square of the pixel.
- tent: 1 - |x| for |x| < 1.
- gaussian: exp(-2 x²) - exp(-2 · 1.5²) for |x| < 1.5, a standard deviation of about half a pixel.
- mitchell: the cubic with B = C = 1/3 for |x| < 2 (Mitchell and Netravali, Reconstruction filters in computer graphics,
  1988), which sharpens a little: it is negative beyond 8/7.
- blackman-harris: the four-term window (Harris, On the use of windows, 1978) for |x| < 1.5.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from typing import Any

import numpy as np

from ..._util.arrays import FloatArray
from ..._util.hints import check_choice
from ...numerics.portable_math import portable_cos, portable_exp, portable_interp
from .options import FILTERS, Filter

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
