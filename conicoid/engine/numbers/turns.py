"""Sine and cosine of parts of a turn, by arithmetic alone: the same bits on every processor and system."""

from __future__ import annotations

import math

import numpy as np

from ...compiler.jit import inline
from .polynomial import polynomial

_SIN = (
    2.8114572543455206e-15, -7.647163731819816e-13, 1.6059043836821613e-10, -2.505210838544172e-08,
    2.7557319223985893e-06, -0.0001984126984126984, 0.008333333333333333, -0.16666666666666666,
)  # fmt: skip
_COS = (
    4.779477332387385e-14, -1.1470745597729725e-11, 2.08767569878681e-09, -2.755731922398589e-07,
    2.48015873015873e-05, -0.001388888888888889, 0.041666666666666664, -0.5,
)  # fmt: skip
"""Taylor's series of (sin x - x) / x³ and (cos x - 1) / x² in x², |x| <= pi / 4: 2^-54 of the results."""


@inline
def cos_sin_turns(turns: float) -> tuple[float, float]:
    """(cos, sin) of 2π turns.

    A multiple of a quarter turn is taken off, exactly, and what is left is within an eighth.
    """
    quarters = np.floor(4.0 * turns + 0.5)
    x = 2.0 * math.pi * (turns - 0.25 * quarters)
    z = x * x
    s, c = x + x * z * polynomial(z, _SIN), 1.0 + z * polynomial(z, _COS)
    quarter = quarters - 4.0 * np.floor(0.25 * quarters)
    if quarter == 1.0:
        return -s, c
    if quarter == 2.0:
        return -c, -s
    if quarter == 3.0:
        return s, -c
    return c, s
