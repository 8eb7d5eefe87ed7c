"""Memory of which each scene has a copy of its own that costs nothing until it is written to.

Where every scene of a chain of edits is held none gives its memory back, and each would need a whole copy for the few
rows in which it differs. So what one of them has goes into a file without a name, in memory, that is never written to
again; each of the next maps it for itself, and the system copies a page where one is written to. There are such files
on Linux alone; elsewhere scenes are copied.
"""

from __future__ import annotations

import os
import weakref
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]
_PAGE = 4096
_AT_ONCE = 1 << 24


class Base:
    """Arrays that are copied as they are written to."""

    def __init__(self, arrays: dict[str, Array]) -> None:
        """Raises OSError where the system has no such files, or no room."""
        if not hasattr(os, "memfd_create"):
            raise OSError("files without a name are Linux's")
        self._file = os.memfd_create("conicoid")
        weakref.finalize(self, os.close, self._file)
        self._places: dict[str, tuple[int, Any, tuple[int, ...]]] = {}
        self._end = 0
        for name, array in arrays.items():
            self._places[name] = self._end, array.dtype, array.shape
            flat: memoryview[Any] = np.ascontiguousarray(array).data.cast("B") if array.size else memoryview(b"")
            for begin in range(0, len(flat), _AT_ONCE):
                part, at = flat[begin : begin + _AT_ONCE], self._end + begin
                while part:
                    written = os.pwrite(self._file, part, at)
                    part, at = part[written:], at + written
            self._end += -(-len(flat) // _PAGE) * _PAGE
        os.truncate(self._file, max(self._end, _PAGE))

    def copies(self) -> dict[str, Array]:
        """The arrays, for somebody who may write to them."""
        import mmap

        room = mmap.mmap(self._file, max(self._end, _PAGE), mmap.MAP_PRIVATE, mmap.PROT_READ | mmap.PROT_WRITE)
        return {
            name: np.frombuffer(room, kind, int(np.prod(shape)), at).reshape(shape)
            for name, (at, kind, shape) in self._places.items()
        }
