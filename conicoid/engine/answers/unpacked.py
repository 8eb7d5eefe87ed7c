"""Rays unpack to two arrays, so `zip(rays, hits)` would pair the origins with the first hit: it is refused."""

from __future__ import annotations

import threading
import weakref
from collections.abc import Iterator

from ...shapes.vector import FloatArray

_UNDER_WAY = threading.local()
"""Which iterator of this thread has given origins and not yet directions, as in no unpacking when others go on."""


class Unpacked(Iterator[FloatArray]):
    """Origins and directions, one after the other."""

    __slots__ = ("__weakref__", "_left")

    def __init__(self, origins: FloatArray, directions: FloatArray) -> None:
        self._left = [directions, origins]

    def __next__(self) -> FloatArray:
        _UNDER_WAY.iterator = None
        if not self._left:
            raise StopIteration
        array = self._left.pop()
        if self._left:
            _UNDER_WAY.iterator = weakref.ref(self)
        return array


def refuse_pairs(kind: str) -> None:
    """TypeError where the loop that goes on to the next answer goes over rays at the same time."""
    begun = getattr(_UNDER_WAY, "iterator", None)
    if begun is None or begun() is None:
        return
    _UNDER_WAY.iterator = None
    it = kind.lower()
    raise TypeError(
        f"{kind}: a loop over rays and {it} at once pairs the array of origins with the first of the {it}: "
        f"`for one in {it}` has the ray of each as one.rays"
    )
