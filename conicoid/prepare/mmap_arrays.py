"""Arrays in memory of their own, which the system has back as soon as nobody holds them.

C libraries keep smaller parts of what was freed, so that the columns of a large scene, once copied to where kernels
read them, would be in memory twice.
"""

from __future__ import annotations

import math
import mmap
from collections.abc import Sequence
from contextlib import suppress
from typing import Any

import numpy as np
import numpy.typing as npt

_LEAST = 1 << 20
"""Bytes that are worth it."""
_MANY = 1 << 16
"""Bodies of which temporary arrays are worth giving back at once."""


def mapped_zeros(shape: int | tuple[int, ...], dtype: Any, sparse: bool = False) -> npt.NDArray[Any]:
    """An array of zeros, like `np.zeros`. `sparse`: little of it will be written to, and only that takes memory."""
    sizes = shape if isinstance(shape, tuple) else (shape,)
    count = math.prod(sizes)
    if count * np.dtype(dtype).itemsize < _LEAST:
        return np.zeros(sizes, dtype)
    flags = {"flags": mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS} if hasattr(mmap, "MAP_ANONYMOUS") else {}
    try:
        memory = mmap.mmap(-1, count * np.dtype(dtype).itemsize, **flags)
    except OSError:
        raise MemoryError(f"the system gives no {count * np.dtype(dtype).itemsize:,} bytes more") from None
    if hasattr(mmap, "MADV_HUGEPAGE") and not sparse:
        with suppress(OSError):  # as NumPy asks for, where the system has large pages
            memory.madvise(mmap.MADV_HUGEPAGE)
    return np.frombuffer(memory, dtype, count).reshape(sizes)


def own_memory(array: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """A copy of an array in memory of its own; itself, if it is small and no view of something larger, or has it."""
    if (array.nbytes < _LEAST and array.base is None) or _has_own_memory(array):
        return array
    copy = mapped_zeros(array.shape, array.dtype)
    copy[...] = array
    return copy


def concatenate_mapped(parts: Sequence[npt.NDArray[Any]]) -> npt.NDArray[Any]:
    """Arrays of one dimension and one type, at least one, end to end in memory of their own."""
    joined, end = mapped_zeros(sum(map(len, parts)), parts[0].dtype), 0
    for part in parts:
        joined[end : end + len(part)] = part
        end += len(part)
    return joined


def trim_heap(count: int) -> None:
    """Let the C library return what it keeps of freed memory to the system, where it is one that can: glibc.

    count: of bodies whose arrays were freed; of a few they are not worth it.
    """
    if count < _MANY:
        return
    with suppress(Exception):  # other libraries and systems, a Python without ctypes, one that may not use it
        import ctypes

        ctypes.CDLL(None).malloc_trim(ctypes.c_size_t(0))


def _has_own_memory(array: npt.NDArray[Any]) -> bool:
    """Is it all of what `empty` has given?"""
    owner: Any = array
    while isinstance(owner, np.ndarray) and owner.base is not None:
        owner = owner.base
    memory = owner.obj if isinstance(owner, memoryview) else owner
    return isinstance(memory, mmap.mmap) and len(memory) == array.nbytes
