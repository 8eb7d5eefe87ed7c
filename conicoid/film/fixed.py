"""Exponentials, logarithms and cosines of arrays by sums and products alone.

Those of the C library differ in their last bits between systems; additions, products and quotients of arrays do not.
They are within some 10⁻¹³ of themselves, which is more than tables of filters and tone curves need.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..shapes.vector import FloatArray

_HALVINGS = 10
_LN2 = 0.6931471805599453


def exponential(x: Any) -> FloatArray:
    """e to the x, for |x| up to some hundreds: Taylor's series of x / 1024, squared ten times."""
    small = np.asarray(x, np.float64) / (1 << _HALVINGS)
    value = np.ones_like(small)
    for k in range(9, 0, -1):
        value = 1.0 + value * small / k
    for _ in range(_HALVINGS):
        value = value * value
    return np.asarray(value)


def binary_logarithm(x: Any) -> FloatArray:
    """log2 of positive numbers: their exponents, and 2 artanh z / ln 2 with z = (m - 1) / (m + 1) of the rest m."""
    m, exponent = np.frexp(np.asarray(x, np.float64))
    low = m < math.sqrt(0.5)
    m, exponent = np.where(low, 2.0 * m, m), exponent - low
    z = (m - 1.0) / (m + 1.0)
    square, total = z * z, np.zeros_like(z)
    for k in range(23, 0, -2):
        total = total * square + 1.0 / k
    return np.asarray(exponent + (2.0 / _LN2) * (z * total))


def cosine(t: Any) -> FloatArray:
    """cos t for 0 <= t <= 2π: of (t - π) / 8 by Taylor's series, doubled three times."""
    s = (np.asarray(t, np.float64) - math.pi) / 8.0
    square, value = s * s, np.ones_like(s)
    for k in range(16, 0, -2):
        value = 1.0 - value * square / (k * (k - 1))
    for _ in range(3):
        value = 2.0 * value * value - 1.0
    return np.asarray(-value)


def power_of_two(stops: float) -> float:
    """2 to a number, exactly for whole ones."""
    whole = math.floor(stops)
    return math.ldexp(float(exponential((stops - whole) * _LN2)), whole)


def interpolated(x: FloatArray, places: FloatArray, values: FloatArray) -> FloatArray:
    """Between values at growing places, as `numpy.interp`, whose compiler may fuse a product with a sum."""
    k = np.clip(np.searchsorted(places, x, side="right") - 1, 0, len(places) - 2)
    low, high = places[k], places[k + 1]
    share = (x - low) / np.where(high > low, high - low, 1.0)
    return np.asarray(values[k] + np.clip(share, 0.0, 1.0) * (values[k + 1] - values[k]))
