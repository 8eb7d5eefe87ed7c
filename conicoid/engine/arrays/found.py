"""First hits of many rays as arrays, a row each."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ...shapes.vector import FloatArray

if TYPE_CHECKING:
    pass


_PAGE = 4096


def _room(count: int, kind: Any, share: int) -> Any:
    """An array that begins some eighths of a page into a page.

    Rows of a picture may lie whole pages apart: if all arrays began alike, the hits of a packet would want
    the same few lines of the cache.
    """
    if count < _PAGE:
        return np.empty(count, kind)
    size = count * np.dtype(kind).itemsize
    room = np.empty(size + 2 * _PAGE, np.uint8)
    first = -room.ctypes.data % _PAGE + share * _PAGE // 8
    return room[first : first + size].view(kind)


class Found(NamedTuple):
    """First hits as the kernels write them, a row each."""

    t: FloatArray
    body: npt.NDArray[np.int32]
    entry: npt.NDArray[np.int32]
    place: npt.NDArray[np.int32]
    turn: npt.NDArray[np.int8]

    @classmethod
    def new(cls, count: int) -> Found:
        """Room for some hits."""
        body, entry, place = (_room(count, np.int32, share) for share in (2, 4, 6))
        return cls(_room(count, np.float64, 0), body, entry, place, _room(count, np.int8, 1))
