"""Axis-aligned boxes (low, high), ±inf where unbounded, low > high where empty."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .vector import Box, FloatArray

EVERYWHERE: Box = (np.full(3, -np.inf), np.full(3, np.inf))


def around(boxes: Sequence[Box]) -> Box:
    """The box around boxes; empty ones (low > high) do not count."""
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for a, b in boxes:
        if (a <= b).all():
            low, high = np.minimum(low, a), np.maximum(high, b)
    return low, high


def around_rows(boxes: FloatArray) -> Box:
    """The same of boxes in an array (n, 6), low and high."""
    some = boxes[(boxes[:, :3] <= boxes[:, 3:]).all(axis=1)]
    return some[:, :3].min(axis=0, initial=np.inf), some[:, 3:].max(axis=0, initial=-np.inf)


def common(boxes: Sequence[Box]) -> Box:
    """The box common to boxes; (inf, -inf) where they have no point in common."""
    low = np.max([a for a, _ in boxes], axis=0)
    high = np.min([b for _, b in boxes], axis=0)
    if (low > high).any():
        return np.full(3, np.inf), np.full(3, -np.inf)
    return low, high


def is_empty(box: Box) -> bool:
    return bool((box[0] > box[1]).any())
