"""Unit cells of crystals from their lengths and angles."""

from __future__ import annotations

import math

import numpy as np

from ...shapes.rounded import sin_cos_degrees
from ...shapes.vector import FloatArray


def cell_of(a: float, b: float, c: float, alpha: float, beta: float, gamma: float) -> FloatArray | None:
    """(3, 3): the edges of a cell as rows, the first along x, the second in the plane of x and y; None for none.

    Lengths in Å, angles in degrees: alpha between b and c, beta between a and c, gamma between a and b (IUCr,
    International Tables for Crystallography B, 3.3.1).
    """
    if not all(math.isfinite(v) and v > 0 for v in (a, b, c)) or not all(0 < v < 180 for v in (alpha, beta, gamma)):
        return None
    cosines = [sin_cos_degrees(angle)[1] for angle in (alpha, beta, gamma)]
    sine = sin_cos_degrees(gamma)[0]
    across = (cosines[0] - cosines[1] * cosines[2]) / sine
    rest = 1 - cosines[1] ** 2 - across**2
    if not rest > 0:
        return None
    return np.array(
        [(a, 0, 0), (b * cosines[2], b * sine, 0), (c * cosines[1], c * across, c * math.sqrt(rest))], np.float64
    )
