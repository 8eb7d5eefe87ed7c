"""Axis-aligned boxes: `Bounds`, which users get for shapes and scenes, and operations on boxes (low, high)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..._util.arrays import BoxEnds, FloatArray
from ..._util.records import equal_values
from ..._util.text import unknown_attribute


class _BoundsEnds(NamedTuple):
    low: FloatArray
    high: FloatArray


class Bounds(_BoundsEnds):
    """The box around a shape or a scene, a pair (low, high).

    low, high   (3,), its ends along x, y and z: ±inf where it is unbounded, low > high where it is empty
    """

    __slots__ = ()
    __hash__ = None  # type: ignore[assignment]

    def __eq__(self, other: object) -> bool:
        return isinstance(other, tuple) and equal_values(tuple(self), other if type(other) is tuple else tuple(other))

    def __ne__(self, other: object) -> bool:
        return not self == other

    if not TYPE_CHECKING:  # type checkers would otherwise accept any name

        def __getattr__(self, name: str) -> Any:
            raise unknown_attribute(self, name)

    def __repr__(self) -> str:
        return repr(tuple(self))


# Operations on boxes (low, high): ±inf where unbounded, low > high where empty

EVERYWHERE: BoxEnds = (np.full(3, -np.inf), np.full(3, np.inf))


def enclose_boxes(boxes: Sequence[BoxEnds]) -> BoxEnds:
    """Return the box around boxes. Empty ones (low > high) do not count."""
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for a, b in boxes:
        if (a <= b).all():
            low, high = np.minimum(low, a), np.maximum(high, b)
    return low, high


def enclose_rows(boxes: FloatArray) -> BoxEnds:
    """Return the box around the rows of an array (n, 6), low and high. Empty rows do not count."""
    nonempty = boxes[(boxes[:, :3] <= boxes[:, 3:]).all(axis=1)]
    return nonempty[:, :3].min(axis=0, initial=np.inf), nonempty[:, 3:].max(axis=0, initial=-np.inf)


def intersect_boxes(boxes: Sequence[BoxEnds]) -> BoxEnds:
    """Return the box common to boxes, (inf, -inf) if they have no point in common."""
    low = np.max([a for a, _ in boxes], axis=0)
    high = np.min([b for _, b in boxes], axis=0)
    if (low > high).any():
        return np.full(3, np.inf), np.full(3, -np.inf)
    return low, high


def is_empty(box: BoxEnds) -> bool:
    """Return True if low > high along any axis."""
    return bool((box[0] > box[1]).any())
