"""The length of a vector by arithmetic alone: no function of the C library."""

from __future__ import annotations

import math

from ...compiler.jit import fma, helper
from .bits import exponent_of, scaled_by_power
from .doubled import quick_sum, rounded
from .errorfree import two_sum


@helper
def hypot(x: float, y: float, z: float) -> float:
    """sqrt(x² + y² + z²) within 0.501 units of the last place, whatever the squares are; special values as C's.

    The squares are added up without error but for 2^-104 of them; a step of Newton's adds to the root what it lacks.
    """
    x, y, z = abs(x), abs(y), abs(z)
    if (x == math.inf) | (y == math.inf) | (z == math.inf):
        return math.inf
    if not (x == x) & (y == y) & (z == z):
        return math.nan
    largest = max(x, max(y, z))
    if largest == 0.0:
        return 0.0
    k = exponent_of(largest)
    x, y, z = scaled_by_power(x, -k), scaled_by_power(y, -k), scaled_by_power(z, -k)
    p, q, r = x * x, y * y, z * z
    s, e = two_sum(p, q)
    s, f = two_sum(s, r)
    rest = (e + f) + ((fma(x, x, -p) + fma(y, y, -q)) + fma(z, z, -r))
    root = math.sqrt(s)
    return rounded(quick_sum(root, (fma(-root, root, s) + rest) / (2.0 * root)), k)
