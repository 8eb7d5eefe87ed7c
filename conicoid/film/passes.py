"""In which steps a progressive picture gets its samples, and which of its squares are done.

A square of pixels is done when its error (the root of the mean square of its pixels' errors, see `sums`) is not above
what is wanted. That is decided from its own sums alone, and only where it has one of the numbers of samples at which
passes end; while a shutter is open, where whole rounds of its moments do. So neither tiles nor threads nor
interruptions change what is decided.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from ..shapes.vector import FloatArray

FEWEST = 32
"""Samples before any error is believed."""
STEP = 64
"""Samples of a pass, at most: so a tile takes some seconds even where a ray takes tens of microseconds."""
_FIRST = (1, 2, 4, 8, 16, 24, 32, 48, 64, 96, 128)


def is_end(samples: int) -> bool:
    """Does a pass end with so many samples?"""
    return samples in _FIRST or (samples > _FIRST[-1] and samples % STEP == 0)


def next_end(samples: int) -> int:
    """With how many samples the pass ends that begins with so many."""
    for end in _FIRST:
        if samples < end:
            return end
    return samples // STEP * STEP + STEP


def in_squares(values: FloatArray, side: int) -> FloatArray:
    """(rows, columns): means over squares of so many pixels a side, those at the edges over what there is of them."""
    height, width = values.shape
    rows, columns = np.arange(0, height, side), np.arange(0, width, side)
    total = np.add.reduceat(np.add.reduceat(values, rows, axis=0), columns, axis=1)
    sizes = np.diff(np.append(rows, height))[:, None] * np.diff(np.append(columns, width))
    return np.asarray(total / sizes)


def errors_in_squares(sums: FloatArray, side: int) -> FloatArray:
    """(rows, columns): the error of each square."""
    from .sums import errors_of

    return np.asarray(np.sqrt(in_squares(errors_of(sums) ** 2, side)))


def error_of_all(sums: FloatArray) -> float:
    """The error of a whole picture: the root of the mean square of its pixels'."""
    from .sums import errors_of

    return float(np.sqrt((errors_of(sums) ** 2).mean()))


def wanted(
    sums: FloatArray, last: int, noise: float | None, side: int, is_judged: Callable[[int], bool] = is_end
) -> npt.NDArray[np.int8]:
    """(rows, columns): 1 for each square that is to get samples in a pass that ends with `last`.

    is_judged: may the noise of a square with so many samples end it?
    """
    from .sums import COUNT

    count = sums[::side, ::side, COUNT]
    more = count < last
    if noise is not None and last > FEWEST and more.any():
        ends = np.isin(count, [n for n in np.unique(count) if n >= FEWEST and is_judged(int(n))])
        more &= ~(ends & (errors_in_squares(sums, side) <= noise))
    return more.astype(np.int8)
