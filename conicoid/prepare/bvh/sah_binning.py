"""Split groups of boxes by the binned surface area heuristic.

I. Wald: On fast construction of SAH-based bounding volume hierarchies, RT 2007.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..._jit.decorators import allocator, inline, instructions, kernel, record_shapes
from ..._jit.machine_code import SHIPPED
from ..._util.dataclass import dataclass
from ...kernels.tables import Floats
from ...kernels.threads import run_calls

if TYPE_CHECKING or SHIPPED is None:
    from .vector_code import clear as clear, copy, exchange, join as join
else:
    clear, copy, exchange, join = map(instructions(__package__, "vector_code"), ("clear", "copy", "exchange", "join"))

# A box is eight floats in one vector, -low xyz, a cost, high xyz, an item: one maximum then joins two boxes.
SIZE = 8
NEGATED_LOW, COST, HIGH, ITEM = 0, 3, 4, 7

BINS = 16
FEW_BINS = 8
MANY = 16  # groups of more records get all bins
_LAST = 3 * BINS * SIZE  # behind the bins of three axes: a box for each axis, and areas on both sides of borders
_BEFORE, _BEYOND = _LAST + 3 * SIZE, _LAST + 3 * SIZE + 3 * BINS
BOXES = _BEYOND + 3 * BINS
Counts = npt.NDArray[np.int64]
Cut = tuple[int, int, float, float]
"""(axis, bin) that split a group (axis -1: no split), and half the areas of both parts"""


@inline
def half_area(boxes: Floats, at: int) -> float:
    """Return half the surface of the box at boxes[at:]."""
    x, y, z = boxes[at + 4] + boxes[at], boxes[at + 5] + boxes[at + 1], boxes[at + 6] + boxes[at + 2]
    return x * y + y * z + z * x


@inline
def _center(records: Floats, i: int, k: int) -> float:
    """Return twice the middle of a box along axis k."""
    return records[SIZE * i + 4 + k] - records[SIZE * i + k]


@kernel(records="8*n", begin="0..end", end="0..n")
def centers(records: Floats, begin: int, end: int) -> tuple[float, float, float, float, float, float]:
    """Return the least and largest middles of boxes on each axis, doubled."""
    ax = ay = az = math.inf
    bx = by = bz = -math.inf
    for i in range(begin, end):
        x, y, z = _center(records, i, 0), _center(records, i, 1), _center(records, i, 2)
        ax, ay, az = x if x < ax else ax, y if y < ay else ay, z if z < az else az
        bx, by, bz = x if x > bx else bx, y if y > by else by, z if z > bz else bz
    return ax, ay, az, bx, by, bz


@inline
def bin_scale(low: float, high: float, bins: int) -> float:
    """Return bins per length; 0 where all middles are equal."""
    width = high - low
    # A little less than all bins, so that the largest middle falls into the last one.
    scale = bins * (1.0 - 1e-9) / width if width > 0.0 else 0.0
    return scale if scale < math.inf else 0.0


@inline
def _bin(center: float, low: float, scale: float, bins: int) -> Any:
    """Return the bin of the middle of a box; clipped, so that it exists for any numbers."""
    return max(0, min(np.int64((center - low) * scale), bins - 1))


@kernel(records="8*n", begin="0..end", end="0..n", bins="1..16", boxes="out 504", counts="out 48")
def fill_bins(
    records: Floats, begin: int, end: int, lows: tuple[float, float, float], scales: tuple[float, float, float],
    bins: int, boxes: Floats, counts: Counts,
) -> None:  # fmt: skip
    """Fill the boxes and counts of the bins of three axes; those of axis k begin at bin k * BINS."""
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


@kernel(bins="1..16", boxes="out 504", counts="48")
def best_cut(scales: tuple[float, float, float], bins: int, boxes: Floats, counts: Counts) -> Cut:
    """Return the cut with the least sum of area times count; overwrite the room behind the bins."""
    # The axes side by side, so that no sum of boxes waits for the one before, and without branches to guess wrongly
    for k in range(3):
        clear(boxes, _LAST + SIZE * k)
    for step in range(1, bins):
        for k in range(3):
            _join_next(boxes, k, bins - step, _BEYOND)
    for k in range(3):
        clear(boxes, _LAST + SIZE * k)
    total = 0
    for b in range(bins):
        total += counts[b]
    x = y = z = (math.inf, 0)
    i = j = k = 0
    for b in range(bins - 1):
        i, j, k = i + counts[b], j + counts[b + BINS], k + counts[b + 2 * BINS]
        x = _lesser(boxes, 0, b, i, total - i, x)
        y = _lesser(boxes, 1, b, j, total - j, y)
        z = _lesser(boxes, 2, b, k, total - k, z)
    axis, best = -1, (math.inf, 0)
    if scales[0] != 0.0 and x[0] < best[0]:
        axis, best = 0, x
    if scales[1] != 0.0 and y[0] < best[0]:
        axis, best = 1, y
    if scales[2] != 0.0 and z[0] < best[0]:
        axis, best = 2, z
    if axis < 0:
        return -1, 0, 0.0, 0.0
    at = axis * BINS + best[1]
    return axis, best[1], boxes[_BEFORE + at - 1], boxes[_BEYOND + at]


@inline
def _join_next(boxes: Floats, k: int, b: int, areas: int) -> float:
    """Join bin b of axis k to the box of that axis; write and return the area of both together."""
    join(boxes, _LAST + SIZE * k, boxes, SIZE * (k * BINS + b))
    area = half_area(boxes, _LAST + SIZE * k)
    boxes[areas + k * BINS + b] = area
    return area


@inline
def _lesser(boxes: Floats, k: int, b: int, left: int, right: int, best: tuple[float, int]) -> tuple[float, int]:
    """Return the lesser of the best (cost, border) of an axis and that behind bin b."""
    cost = _join_next(boxes, k, b, _BEFORE) * left + boxes[_BEYOND + k * BINS + b + 1] * right
    # Not a number, and so not less, where there is nothing on one side
    is_less = cost < best[0]
    return (cost if is_less else best[0]), (b + 1 if is_less else best[1])


@record_shapes(axis="0..2", bin="0..16")
class Border(NamedTuple):
    """A border between the bins along an axis."""

    axis: int
    low: float  # where the bins begin
    scale: float  # bins per length
    bin: int


@inline
def _lies_before(records: Floats, i: int, border: Border, bins: int) -> bool:
    """Return whether a record lies before a border."""
    return _bin(_center(records, i, border.axis), border.low, border.scale, bins) < border.bin


@inline
def partition_records(records: Floats, begin: int, end: int, border: Border, bins: int) -> int:
    """Move the records before a border to the front, in place; return where they end."""
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
    """Copy the records before a border of BINS to `target` from `left` on, the others from `right` on, within it."""
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
    """Return half the area of the box around records; boxes[at:] is overwritten."""
    clear(boxes, at)
    for i in range(begin, end):
        join(boxes, at, records, SIZE * i)
    return half_area(boxes, at)


@allocator
def cut_group(records: Floats, begin: int, end: int, boxes: Floats, counts: Counts) -> tuple[int, float, float]:
    """Split a group of at least two in place: (first of the second part, half the areas of both)."""
    if end - begin > 2:
        bins = BINS if end - begin > MANY else FEW_BINS
        ax, ay, az, bx, by, bz = centers(records, begin, end)
        scales = bin_scale(ax, bx, bins), bin_scale(ay, by, bins), bin_scale(az, bz, bins)
        fill_bins(records, begin, end, (ax, ay, az), scales, bins, boxes, counts)
        axis, border, left, right = best_cut(scales, bins, boxes, counts)
        if axis >= 0:
            low = ax if axis == 0 else (ay if axis == 1 else az)
            middle = partition_records(records, begin, end, Border(axis, low, scales[axis], border), bins)
            return middle, left, right
    # Equal middles, or two records: split in the middle.
    middle = (begin + end) // 2
    left = area_of(records, begin, middle, boxes, _LAST)
    return middle, left, area_of(records, middle, end, boxes, _LAST)


# The first branches of a large tree: all threads split its groups together, until each is one thread's work
#
# Chunks and groups depend on the boxes alone, so the tree does not depend on the threads.

ONE_THREAD = 1 << 13  # groups of no more records are built by one thread
_CHUNK = 1 << 15


@dataclass
class RecordGroup:
    """Records first..last, and the two groups that they were split into."""

    first: int
    last: int
    area: float = 0.0
    moved: bool = False  # its records are in the second copy
    halves: tuple[RecordGroup, RecordGroup] | None = None


def partition_large(records: Floats) -> list[RecordGroup]:
    """Sort records into groups of at most `ONE_THREAD`; return all groups, each before its halves, the root first."""
    groups = [RecordGroup(0, len(records) // SIZE)]
    wave = [group for group in groups if group.last - group.first > ONE_THREAD]
    if not wave:
        return groups
    copies = records, np.empty_like(records)
    while wave:
        _split_all(wave, copies)
        halves = [half for group in wave for half in group.halves or ()]
        groups += halves
        wave = [group for group in halves if group.last - group.first > ONE_THREAD]
    pieces = _pieces([group for group in groups if group.halves is None and group.moved])
    every = Border(0, 0.0, 0.0, BINS)  # all records lie before it
    run_calls(distribute, [(copies[1], begin, end, every, copies[0], begin, begin) for _, begin, end in pieces])
    return groups


def box_area(box: Floats) -> float:
    """Return half the surface of a box (8,) in the form of records."""
    x, y, z = (box[4:7] + box[:3]).tolist()
    return float(x * y + y * z + z * x)


RecordPiece = tuple[RecordGroup, int, int]


def _pieces(groups: list[RecordGroup]) -> list[RecordPiece]:
    """Cut groups into chunks of records."""
    return [
        (group, begin, min(begin + _CHUNK, group.last))
        for group in groups
        for begin in range(group.first, group.last, _CHUNK)
    ]


def _split_all(groups: list[RecordGroup], copies: tuple[Floats, Floats]) -> None:
    """Split every group in two, into the other copy of the records."""
    pieces = _pieces(groups)
    places: dict[int, list[int]] = {}
    for k, (group, _, _) in enumerate(pieces):
        places.setdefault(id(group), []).append(k)
    limits = np.array(run_calls(centers, [(copies[group.moved], begin, end) for group, begin, end in pieces]))
    frames = {id(group): _frame(limits[places[id(group)]]) for group in groups}
    boxes, counts = np.empty((len(pieces), BOXES)), np.empty((len(pieces), 3 * BINS), np.int64)
    run_calls(
        fill_bins,
        [
            (copies[group.moved], begin, end, *frames[id(group)], BINS, boxes[k], counts[k])
            for k, (group, begin, end) in enumerate(pieces)
        ],
    )
    plan: dict[int, tuple[Any, ...]] = {}
    for group in groups:
        mine = places[id(group)]
        _plan(group, frames[id(group)], mine, boxes[mine], counts[mine], plan)
    calls = []
    for k, (border, left, right) in plan.items():
        group, begin, end = pieces[k]
        calls.append((copies[group.moved], begin, end, border, copies[not group.moved], left, right))
    run_calls(distribute, calls)


def _frame(limits: Floats) -> tuple[Any, Any]:
    """Return where the bins begin, and bins per length, on each axis."""
    low, high = limits[:, :3].min(axis=0).tolist(), limits[:, 3:].max(axis=0).tolist()
    return tuple(low), tuple(bin_scale(a, b, BINS) for a, b in zip(low, high, strict=True))


def _plan(
    group: RecordGroup, frame: tuple[Any, Any], pieces: list[int], boxes: Floats, counts: Any, plan: dict[int, Any]
) -> None:
    """Choose the cut of a group, and where each of its chunks writes the records before and behind it."""
    lows, scales = frame
    joined = np.append(boxes[:, :_LAST].max(axis=0), np.empty(BOXES - _LAST))
    axis, border, left_area, right_area = best_cut(scales, BINS, joined, counts.sum(axis=0))
    if axis < 0:
        # All middles are equal: any half will do.
        middle, area = (
            (group.first + group.last) // 2,
            box_area(joined[:_LAST].reshape(-1, SIZE).max(axis=0)),
        )
        group.halves = (
            RecordGroup(group.first, middle, area, group.moved),
            RecordGroup(middle, group.last, area, group.moved),
        )
        return
    before = counts[:, axis * BINS : axis * BINS + border].sum(axis=1)
    middle = group.first + int(before.sum())
    lefts = group.first + np.cumsum(before) - before
    after = counts[:, :BINS].sum(axis=1) - before
    rights = middle + np.cumsum(after) - after
    for k, left, right in zip(pieces, lefts, rights, strict=True):
        plan[k] = Border(int(axis), lows[axis], scales[axis], int(border)), int(left), int(right)
    group.halves = (
        RecordGroup(group.first, middle, left_area, not group.moved),
        RecordGroup(middle, group.last, right_area, not group.moved),
    )
