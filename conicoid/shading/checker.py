"""The checker pattern."""

from __future__ import annotations

import numpy as np

from ..compiler.jit import inline


@inline
def is_even(a: float, b: float, c: float) -> bool:
    """True where floor(a) + floor(b) + floor(c) is even."""
    return _is_even(a) == (_is_even(b) == _is_even(c))


@inline
def _is_even(x: float) -> bool:
    """Whether floor(x), as a float whatever its size, is even."""
    half = 0.5 * np.floor(x)
    return half == np.floor(half)
