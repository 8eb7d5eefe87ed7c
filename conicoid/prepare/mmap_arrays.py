"""Arrays in anonymous memory maps, which return to the system as soon as nobody holds them.

C libraries keep small parts of freed memory for themselves. With ordinary arrays the columns of a large scene, once
copied to where kernels read them, would occupy memory twice.
"""

from __future__ import annotations

import math
import mmap
from collections.abc import Sequence
from contextlib import suppress
from typing import Any

import numpy as np
import numpy.typing as npt

from ..kernels.threads import run_chunks

_LEAST = 1 << 20
"""Arrays of fewer bytes are ordinary ones."""
_PART = 1 << 22
"""Bytes that a thread copies at a time: whole large pages, so that no two threads touch one first."""
_MANY = 1 << 16
"""Temporary arrays of fewer bodies are not worth a call of the C library."""


def mapped_zeros(shape: int | tuple[int, ...], dtype: Any, sparse: bool = False) -> npt.NDArray[Any]:
    """Allocate an array of zeros, like `np.zeros`; raise MemoryError where the system refuses.

    With `sparse` little of it will be written, and only those pages take memory.
    """
    sizes = shape if isinstance(shape, tuple) else (shape,)
    count = math.prod(sizes)
    if count * np.dtype(dtype).itemsize < _LEAST:
        return np.zeros(sizes, dtype)
    flags = {"flags": mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS} if hasattr(mmap, "MAP_ANONYMOUS") else {}
    try:
        memory = mmap.mmap(-1, count * np.dtype(dtype).itemsize, **flags)
    except OSError:
        raise MemoryError(f"the system refuses {count * np.dtype(dtype).itemsize:,} more bytes") from None
    if hasattr(mmap, "MADV_HUGEPAGE") and not sparse:
        with suppress(OSError):  # as NumPy does, where the system has large pages
            memory.madvise(mmap.MADV_HUGEPAGE)
    return np.frombuffer(memory, dtype, count).reshape(sizes)


def own_memory(array: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Copy an array to a map of its own; return it as it is if it is small and no view, or has one."""
    if (array.nbytes < _LEAST and array.base is None) or has_own_memory(array):
        return array
    copy = mapped_zeros(array.shape, array.dtype)
    copy_rows(copy, array)
    return copy


def copy_rows(target: npt.NDArray[Any], source: npt.NDArray[Any]) -> None:
    """Copy the rows of an array, on all threads if there are many."""

    def put(begin: int, end: int) -> None:
        """Copy rows begin..end."""
        target[begin:end] = source[begin:end]

    run_chunks(put, len(source), max(1, _PART // max(1, source[:1].nbytes)))


def concatenate_mapped(parts: Sequence[npt.NDArray[Any]]) -> npt.NDArray[Any]:
    """Concatenate one-dimensional arrays of one type, at least one, into a map of their own; no copy of such a one."""
    non_empty = [part for part in parts if len(part)]
    if len(non_empty) == 1 and has_own_memory(non_empty[0]):
        return non_empty[0]
    joined, end = mapped_zeros(sum(map(len, parts)), parts[0].dtype), 0
    for part in parts:
        joined[end : end + len(part)] = part
        end += len(part)
    return joined


def trim_heap(count: int) -> None:
    """Make the C library return freed memory to the system, where it can (glibc).

    `count` is the number of bodies whose arrays were freed: for few it does nothing.
    """
    if count < _MANY:
        return
    with suppress(Exception):  # other C libraries and systems; Python without ctypes
        import ctypes

        ctypes.CDLL(None).malloc_trim(ctypes.c_size_t(0))


def has_own_memory(array: npt.NDArray[Any]) -> bool:
    """Return whether an array covers all of a memory map of its own."""
    owner: Any = array
    while isinstance(owner, np.ndarray) and owner.base is not None:
        owner = owner.base
    memory = owner.obj if isinstance(owner, memoryview) else owner
    return isinstance(memory, mmap.mmap) and len(memory) == array.nbytes
