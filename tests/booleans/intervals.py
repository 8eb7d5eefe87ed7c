"""Spans of rays as arrays, compared to the bit."""

from __future__ import annotations

import math
from typing import Any

import numpy as np


def table(spans: Any, body: int) -> tuple[Any, Any]:
    """Return arrays (enter, exit) of one body, each (rays, most), with inf behind the last span."""
    rays = len(spans.offsets) - 1
    ray = np.repeat(np.arange(rays), np.diff(spans.offsets))
    mine = spans.body == body
    ray, enter, leave = ray[mine], spans.t_enter[mine], spans.t_exit[mine]
    counts = np.bincount(ray, minlength=rays)
    place = np.arange(len(ray)) - np.repeat(np.cumsum(counts) - counts, counts)
    result = np.full((2, rays, max(1, counts.max(initial=0))), math.inf)
    result[0, ray, place], result[1, ray, place] = enter, leave
    return result[0], result[1]


def same(one: tuple[Any, Any], other: tuple[Any, Any]) -> Any:
    """Return, as (rays,) bool, whether spans are equal to the bit."""
    most = max(one[0].shape[1], other[0].shape[1])
    padded = [
        np.pad(end, ((0, 0), (0, most - end.shape[1])), constant_values=math.inf)
        for pair in (one, other)
        for end in pair
    ]
    return ((padded[0] == padded[2]) & (padded[1] == padded[3])).all(axis=1)
