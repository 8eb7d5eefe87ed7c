"""Which ray each row belongs to, in lists of rows that stand ray by ray."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

IntArray = npt.NDArray[np.int64]


def owners(offsets: IntArray) -> IntArray:
    """The ray of each row: rows offsets[k] to offsets[k + 1] are ray k's."""
    # NumPy counts by `intp`, which has 32 bits in WebAssembly
    return np.repeat(np.arange(len(offsets) - 1, dtype=np.int64), np.diff(offsets).astype(np.intp, copy=False))
