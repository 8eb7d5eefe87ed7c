"""The checker pattern."""

from __future__ import annotations

import math

from ..compiler.jit import inline


@inline
def is_even(a: float, b: float, c: float) -> bool:
    """True where floor(a) + floor(b) + floor(c) is even."""
    half = 0.5 * (math.floor(a) + math.floor(b) + math.floor(c))
    return half == math.floor(half)
