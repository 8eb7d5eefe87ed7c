"""Where to split a group of boxes, by the binned surface area heuristic.

I. Wald: On fast construction of SAH-based bounding volume hierarchies, RT 2007.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ....compiler.jit import allocator, inline, kernel
from ....compiler.shapes import shaped
from ...tables import Floats
from .vectors import SIZE, clear, copy, exchange, half_area, join

BINS = 16
FEW_BINS = 8
MANY = 16  # a group of more gets all bins
BOXES = 3 * BINS * SIZE + SIZE + BINS  # floats of the bins of three axes, a box and areas
Counts = npt.NDArray[np.int64]
Cut = tuple[int, int, float, float]
"""axis (-1: none) and bin that part a group, and half the areas of both parts"""


@inline
def _center(records: Floats, i: int, k: int) -> float:
    """Twice the middle of a box along axis k."""
    return records[SIZE * i + 4 + k] - records[SIZE * i + k]


@kernel(records="8*n", begin="0..end", end="0..n")
def centers(records: Floats, begin: int, end: int) -> tuple[float, float, float, float, float, float]:
    """(low, high) of the middles of boxes, doubled."""
    ax = ay = az = math.inf
    bx = by = bz = -math.inf
    for i in range(begin, end):
        x, y, z = _center(records, i, 0), _center(records, i, 1), _center(records, i, 2)
        ax, ay, az = x if x < ax else ax, y if y < ay else ay, z if z < az else az
        bx, by, bz = x if x > bx else bx, y if y > by else by, z if z > bz else bz
    return ax, ay, az, bx, by, bz


@inline
def bin_scale(low: float, high: float, bins: int) -> float:
    """Bins per length; 0 where the middles are equal."""
    width = high - low
    scale = bins * (1.0 - 1e-9) / width if width > 0.0 else 0.0
    return scale if scale < math.inf else 0.0


@inline
def _bin(center: float, low: float, scale: float, bins: int) -> Any:
    """Which bin the middle of a box is in: one there is, whatever the numbers are."""
    return max(0, min(np.int64((center - low) * scale), bins - 1))


@kernel(records="8*n", begin="0..end", end="0..n", bins="1..16", boxes="out 408", counts="out 48")
def fill_bins(
    records: Floats, begin: int, end: int, lows: tuple[float, float, float], scales: tuple[float, float, float],
    bins: int, boxes: Floats, counts: Counts,
) -> None:  # fmt: skip
    """Boxes and counts of the bins of three axes: those of axis k from bin k * BINS."""
    for k in range(3):
        for b in range(k * BINS, k * BINS + bins):
            counts[b] = 0
            clear(boxes, SIZE * b)
    for i in range(begin, end):
        a = _bin(_center(records, i, 0), lows[0], scales[0], bins)
        b = _bin(_center(records, i, 1), lows[1], scales[1], bins) + BINS
        c = _bin(_center(records, i, 2), lows[2], scales[2], bins) + 2 * BINS
        join(boxes, SIZE * a, records, SIZE * i)
        join(boxes, SIZE * b, records, SIZE * i)
        join(boxes, SIZE * c, records, SIZE * i)
        counts[a] += 1
        counts[b] += 1
        counts[c] += 1


@kernel(bins="1..16", boxes="out 408", counts="48")
def best_cut(scales: tuple[float, float, float], bins: int, boxes: Floats, counts: Counts) -> Cut:
    """The cut with the least sum of area times count; boxes has room for a vector behind the bins."""
    best, axis, border, left_area, right_area = math.inf, -1, 0, 0.0, 0.0
    last, areas = SIZE * 3 * BINS, SIZE * 3 * BINS + SIZE
    for k in range(3):
        if scales[k] == 0.0:
            continue
        first = k * BINS
        clear(boxes, last)
        total = 0
        for b in range(first, first + bins):
            total += counts[b]
        right = 0
        for step in range(bins - 1):
            b = first + bins - 1 - step
            if counts[b] > 0:
                join(boxes, last, boxes, SIZE * b)
            right += counts[b]
            boxes[areas + b - first] = half_area(boxes, last) if right > 0 else 0.0
        clear(boxes, last)
        left = 0
        for b in range(first, first + bins - 1):
            if counts[b] == 0:
                continue
            join(boxes, last, boxes, SIZE * b)
            left += counts[b]
            if left == total:
                break
            area, beyond = half_area(boxes, last), boxes[areas + b + 1 - first]
            cost = area * left + beyond * (total - left)
            if cost < best:
                best, axis, border, left_area, right_area = cost, k, b + 1 - first, area, beyond
    return axis, border, left_area, right_area


@shaped(axis="0..2", bin="0..16")
class Border(NamedTuple):
    """A border between the bins along an axis."""

    axis: int
    low: float  # where the bins begin
    scale: float  # bins per length
    bin: int


@inline
def _lies_before(records: Floats, i: int, border: Border, bins: int) -> bool:
    """Does a record lie before a border?"""
    return _bin(_center(records, i, border.axis), border.low, border.scale, bins) < border.bin


@inline
def part(records: Floats, begin: int, end: int, border: Border, bins: int) -> int:
    """Bring what lies before a border to the front, in place; returns how far it reaches."""
    i, j = begin, end - 1
    while True:
        while i <= j and _lies_before(records, i, border, bins):
            i += 1
        while i <= j and not _lies_before(records, j, border, bins):
            j -= 1
        if i >= j:
            return i
        exchange(records, SIZE * i, records, SIZE * j)
        i += 1
        j -= 1


@kernel(records="8*n", begin="0..end", end="0..n", target="out 8*n", left="0..n", right="0..n")
def distribute(records: Floats, begin: int, end: int, border: Border, target: Floats, left: int, right: int) -> None:
    """Copy what lies before a border of BINS to target from `left` on, the rest from `right` on, within it."""
    room = len(target) // SIZE
    for i in range(begin, end):
        if _lies_before(records, i, border, BINS):
            if left < room:
                copy(target, SIZE * left, records, SIZE * i)
            left += 1
        elif right < room:
            copy(target, SIZE * right, records, SIZE * i)
            right += 1


@inline
def area_of(records: Floats, begin: int, end: int, boxes: Floats, at: int) -> float:
    """Half the area of the box around records; boxes[at:] is overwritten."""
    clear(boxes, at)
    for i in range(begin, end):
        join(boxes, at, records, SIZE * i)
    return half_area(boxes, at)


@allocator
def cut_group(records: Floats, begin: int, end: int, boxes: Floats, counts: Counts) -> tuple[int, float, float]:
    """Part a group of at least two in place: (first of the second part, half the areas of both)."""
    last = SIZE * 3 * BINS
    if end - begin > 2:
        bins = BINS if end - begin > MANY else FEW_BINS
        ax, ay, az, bx, by, bz = centers(records, begin, end)
        scales = bin_scale(ax, bx, bins), bin_scale(ay, by, bins), bin_scale(az, bz, bins)
        fill_bins(records, begin, end, (ax, ay, az), scales, bins, boxes, counts)
        axis, border, left, right = best_cut(scales, bins, boxes, counts)
        if axis >= 0:
            low = ax if axis == 0 else (ay if axis == 1 else az)
            middle = part(records, begin, end, Border(axis, low, scales[axis], border), bins)
            return middle, left, right
    middle = (begin + end) // 2
    left = area_of(records, begin, middle, boxes, last)
    return middle, left, area_of(records, middle, end, boxes, last)
