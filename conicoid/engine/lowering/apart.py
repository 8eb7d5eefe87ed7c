"""Arrays in memory of their own, which the system has back as soon as nobody holds them.

C libraries keep smaller parts of what was freed, so that the columns of a large scene, once copied to where kernels
read them, would be in memory twice.
"""

from __future__ import annotations

import math
import mmap
from typing import Any

import numpy as np
import numpy.typing as npt

_LEAST = 1 << 20
"""Bytes that are worth it."""


def empty(shape: int | tuple[int, ...], dtype: Any) -> npt.NDArray[Any]:
    """An array of zeros, like `np.zeros`."""
    sizes = shape if isinstance(shape, tuple) else (shape,)
    count = math.prod(sizes)
    if count * np.dtype(dtype).itemsize < _LEAST:
        return np.zeros(sizes, dtype)
    flags = {"flags": mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS} if hasattr(mmap, "MAP_ANONYMOUS") else {}
    memory = mmap.mmap(-1, count * np.dtype(dtype).itemsize, **flags)
    return np.frombuffer(memory, dtype, count).reshape(sizes)


def apart(array: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """A copy of an array in memory of its own; itself, if it is small and no view of something larger."""
    if array.nbytes < _LEAST and array.base is None:
        return array
    copy = empty(array.shape, array.dtype)
    copy[...] = array
    return copy
