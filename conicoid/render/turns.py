"""Sine and cosine of parts of a turn, by arithmetic alone: the same bits on every processor and system."""

from __future__ import annotations

import math

import numpy as np

from ..compiler.jit import inline

_SINE = tuple((-1) ** k / math.factorial(2 * k + 1) for k in range(8))
_COSINE = tuple((-1) ** k / math.factorial(2 * k) for k in range(9))
"""Taylor's series: the first term that is left out is below 2^-54 at an eighth of a turn."""


@inline
def cos_sin_turns(turns: float) -> tuple[float, float]:
    """(cos, sin) of 2π turns.

    A multiple of a quarter turn is taken off, exactly, and what is left is within an eighth.
    """
    quarters = np.rint(4.0 * turns)
    angle = (turns - 0.25 * quarters) * (2.0 * math.pi)
    z = angle * angle
    s, c = _SINE[7], _COSINE[8]
    for k in range(7):
        s = s * z + _SINE[6 - k]
    for k in range(8):
        c = c * z + _COSINE[7 - k]
    s *= angle
    quarter = quarters - 4.0 * np.floor(0.25 * quarters)
    if quarter == 1.0:
        return -s, c
    if quarter == 2.0:
        return -c, -s
    if quarter == 3.0:
        return s, -c
    return c, s
