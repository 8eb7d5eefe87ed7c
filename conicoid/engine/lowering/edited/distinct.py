"""Numbers in rising order, each once: what NumPy's `unique` gives, which takes 8 ms when it is first called.

It imports masked arrays then, more than a whole edit takes.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ...tables import Longs


def distinct(*parts: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """The different numbers of some arrays, in rising order."""
    ordered = np.sort(parts[0] if len(parts) == 1 else np.concatenate(parts))
    other = np.ones(len(ordered), bool)
    np.not_equal(ordered[1:], ordered[:-1], out=other[1:])
    found: npt.NDArray[Any] = ordered[other]
    return found


def distinct_places(numbers: npt.NDArray[Any]) -> tuple[npt.NDArray[Any], Longs]:
    """The different numbers, in rising order, and the place of each given among them."""
    values = distinct(numbers)
    return values, np.searchsorted(values, numbers)


def among(numbers: npt.NDArray[Any], ordered: npt.NDArray[Any]) -> npt.NDArray[np.bool_]:
    """Which of some numbers are there in an array of distinct numbers in rising order."""
    if not len(ordered):
        return np.zeros(numbers.shape, bool)
    place = np.searchsorted(ordered, numbers)
    found: npt.NDArray[np.bool_] = ordered[np.minimum(place, len(ordered) - 1)] == numbers
    return found
