"""First hits of many rays as arrays, a row each."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ...compiler.jit import inline
from ...compiler.shapes import shaped
from ...shapes.vector import FloatArray
from ..body.hit import Hit, turn_of
from ..culling import prefetch_to_write, store_eight
from ..packets.lanes import BEST, BODY, ENTRY, PLACE, TURN
from ..tables import Floats

_PAGE = 4096


def _room(count: int, kind: Any, share: int) -> Any:
    """An array that begins some eighths of a page into a page.

    Rows of a picture may lie whole pages apart: if all arrays began alike, the hits of a packet would compete for
    the same few lines of the cache.
    """
    if count < _PAGE:
        return np.empty(count, kind)
    size = count * np.dtype(kind).itemsize
    room = np.empty(size + 2 * _PAGE, np.uint8)
    first = -room.ctypes.data % _PAGE + share * _PAGE // 8
    return room[first : first + size].view(kind)


@shaped(t="n", body="n", entry="n", place="n", turn="n")
class Found(NamedTuple):
    """First hits as the kernels write them, a row each."""

    t: FloatArray
    body: npt.NDArray[np.int32]
    entry: npt.NDArray[np.int32]
    place: npt.NDArray[np.int32]
    turn: npt.NDArray[np.int8]  # see `hit.turn_of`

    @classmethod
    def new(cls, count: int) -> Found:
        """Room for some hits."""
        body, entry, place = (_room(count, np.int32, share) for share in (2, 4, 6))
        return cls(_room(count, np.float64, 0), body, entry, place, _room(count, np.int8, 1))


@inline
def put_hit(hit: Hit, i: Any, found: Found) -> None:
    """Hit i, in arrays."""
    i = np.uint64(i)
    found.t[i], found.body[i], found.entry[i], found.place[i] = hit.t, hit.body, hit.entry, hit.place
    found.turn[i] = turn_of(hit)


@inline
def ask_for_hits(i: int, found: Found) -> None:
    """Prefetch, to be written, the memory of hit i and a few after it."""
    prefetch_to_write(found.t, i)
    prefetch_to_write(found.body, i)
    prefetch_to_write(found.entry, i)
    prefetch_to_write(found.place, i)


@inline
def put_eight_hits(lanes: Floats, lane: int, i: int, found: Found) -> None:
    """`put_hit` for the hits of eight lanes, which have their turns ready."""
    at = np.uint64(lane)
    store_eight(lanes, BEST + at, found.t, i)
    store_eight(lanes, BODY + at, found.body, i)
    store_eight(lanes, ENTRY + at, found.entry, i)
    store_eight(lanes, PLACE + at, found.place, i)
    store_eight(lanes, TURN + at, found.turn, i)
