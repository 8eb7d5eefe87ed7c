"""Numbers in rising order, each once: what NumPy's `unique` gives, which takes 8 ms when it is first called.

It imports masked arrays then, which costs more than preparing a small scene, or than a whole edit. NaN may not be among
the numbers.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

Places = npt.NDArray[np.int64]


def distinct(*parts: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """The different numbers of some arrays (n,), in rising order."""
    ordered = np.sort(parts[0] if len(parts) == 1 else np.concatenate(parts))
    found: npt.NDArray[Any] = ordered[_begins(ordered)]
    return found


def distinct_places(numbers: npt.NDArray[Any]) -> tuple[npt.NDArray[Any], Places]:
    """The different numbers of an array (n,), in rising order, and (n,) the place of each given among them."""
    order = np.argsort(numbers)
    ordered = numbers[order]
    begins = _begins(ordered)
    return ordered[begins], _places(order, begins)


def first_places(numbers: npt.NDArray[Any]) -> tuple[Places, Places]:
    """Where each different number of an array (n,) stands first, by rising numbers; and (n,) as `distinct_places`."""
    order = np.argsort(numbers, kind="stable")
    begins = _begins(numbers[order])
    return order[begins], _places(order, begins)


def among(numbers: npt.NDArray[Any], ordered: npt.NDArray[Any]) -> npt.NDArray[np.bool_]:
    """Which of some numbers are there in an array of distinct numbers in rising order."""
    if not len(ordered):
        return np.zeros(numbers.shape, bool)
    place = np.searchsorted(ordered, numbers)
    found: npt.NDArray[np.bool_] = ordered[np.minimum(place, len(ordered) - 1)] == numbers
    return found


def _begins(ordered: npt.NDArray[Any]) -> npt.NDArray[np.bool_]:
    """Which numbers are others than the one before."""
    other = np.ones(len(ordered), bool)
    np.not_equal(ordered[1:], ordered[:-1], out=other[1:])
    return other


def _places(order: Places, begins: npt.NDArray[np.bool_]) -> Places:
    """The places among different numbers, of numbers that were ordered so."""
    found = np.empty(len(order), np.int64)
    found[order] = np.cumsum(begins) - 1
    return found
