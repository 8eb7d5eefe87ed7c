"""Split groups of boxes by the binned surface area heuristic; large ones by way of the cells of a grid.

I. Wald: On fast construction of SAH-based bounding volume hierarchies, RT 2007. The cells are what Morton codes are in
J. Pantaleoni, D. Luebke: HLBVH: hierarchical LBVH construction for real-time ray tracing, HPG 2010.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..._jit.decorators import helper, inline, instructions, kernel, record_shapes
from ..._jit.machine_code import SHIPPED
from ..._util.records import dataclass
from ...kernels.tables import Floats, Ints
from ...kernels.threads import KernelRange, run_calls, run_chunks

if TYPE_CHECKING or SHIPPED is None:
    from ...kernels.bvh.vector_code import (
        clear_box as clear_box,
        copy_box as copy_box,
        exchange_boxes,
        join_box as join_box,
    )
else:
    _boxes = instructions("conicoid.kernels.bvh", "vector_code")
    clear_box, copy_box, exchange_boxes, join_box = map(_boxes, ("clear_box", "copy_box", "exchange_boxes", "join_box"))

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


@inline
def _weight(cells: Floats, i: int) -> Any:
    """Return the number of boxes in a cell."""
    return np.int64(cells[SIZE * i + COST])


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
def _bin_scale(low: float, high: float, bins: int) -> float:
    """Return bins per length; 0 where all middles are equal."""
    width = high - low
    # A little less than all bins, so that the largest middle falls into the last one.
    scale = bins * (1.0 - 1e-9) / width if width > 0.0 else 0.0
    return scale if scale < math.inf else 0.0


@inline
def _bin(center: float, low: float, scale: float, bins: int) -> Any:
    """Return the bin of the middle of a box; clipped, so that it exists for any numbers."""
    return max(0, min(np.int64((center - low) * scale), bins - 1))


@helper
def _fill_bins(
    records: Floats, begin: int, end: int, lows: tuple[float, float, float], scales: tuple[float, float, float],
    bins: int, weighted: bool, boxes: Floats, counts: Counts,
) -> None:  # fmt: skip
    """Fill the boxes and counts of the bins of three axes; those of axis k begin at bin k * BINS.

    With `weighted` the records are cells, and each counts for its boxes.
    """
    for k in range(3):
        for b in range(k * BINS, k * BINS + bins):
            counts[b] = 0
            clear_box(boxes, SIZE * b)
    for i in range(begin, end):
        a = _bin(_center(records, i, 0), lows[0], scales[0], bins)
        b = _bin(_center(records, i, 1), lows[1], scales[1], bins) + BINS
        c = _bin(_center(records, i, 2), lows[2], scales[2], bins) + 2 * BINS
        join_box(boxes, SIZE * a, records, SIZE * i)
        join_box(boxes, SIZE * b, records, SIZE * i)
        join_box(boxes, SIZE * c, records, SIZE * i)
        weight = _weight(records, i) if weighted else 1
        counts[a] += weight
        counts[b] += weight
        counts[c] += weight


@helper
def _best_cut(scales: tuple[float, float, float], bins: int, boxes: Floats, counts: Counts) -> Cut:
    """Return the cut with the least sum of area times count; overwrite the room behind the bins."""
    # The axes side by side, so that no sum of boxes waits for the one before, and without branches to guess wrongly
    for k in range(3):
        clear_box(boxes, _LAST + SIZE * k)
    for step in range(1, bins):
        for k in range(3):
            _join_next(boxes, k, bins - step, _BEYOND)
    for k in range(3):
        clear_box(boxes, _LAST + SIZE * k)
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
    join_box(boxes, _LAST + SIZE * k, boxes, SIZE * (k * BINS + b))
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
def _partition(records: Floats, begin: int, end: int, border: Border, bins: int) -> int:
    """Move the records before a border to the front, in place; return where they end."""
    middle = begin
    for i in range(begin, end):
        # Exchanged in any case, since a processor guesses such a branch wrongly each second time
        before = _lies_before(records, i, border, bins)
        exchange_boxes(records, SIZE * i, records, SIZE * middle)
        middle += 1 if before else 0
    return middle


@inline
def _area_around(records: Floats, i: int, j: int, k: int) -> float:
    """Return half the area of the box around three records."""
    x = _most(records, i, j, k, 4) + _most(records, i, j, k, 0)
    y = _most(records, i, j, k, 5) + _most(records, i, j, k, 1)
    z = _most(records, i, j, k, 6) + _most(records, i, j, k, 2)
    return x * y + y * z + z * x


@inline
def _most(records: Floats, i: int, j: int, k: int, at: int) -> float:
    """Return the greatest of the numbers at a place of three records."""
    a, b, c = records[SIZE * i + at], records[SIZE * j + at], records[SIZE * k + at]
    a = b if b > a else a
    return c if c > a else a


@helper
def _cut_few(records: Floats, begin: int, count: int) -> tuple[int, float, float]:
    """Split two to four records in place, in the best of all ways: `cut_group`."""
    if count == 2:
        return begin + 1, half_area(records, SIZE * begin), half_area(records, SIZE * (begin + 1))
    last, chosen = begin + count - 1, begin
    best, left, right = math.inf, math.inf, math.inf
    for k in range(begin, begin + count):
        # One record before the others
        i, j = begin + (1 if k == begin else 0), last - (1 if k == last else 0)
        between = i if count == 3 else 2 * (begin + last) - k - i - j
        one, others = half_area(records, SIZE * k), _area_around(records, i, between, j)
        cost = one + others * (count - 1)
        if cost < best:
            best, chosen, left, right = cost, k, one, others
    if count == 4:
        for k in range(begin + 1, begin + 4):
            # The first and one more before the other two
            i, j = begin + (2 if k == begin + 1 else 1), last - (1 if k == last else 0)
            two, others = _area_around(records, begin, begin, k), _area_around(records, i, i, j)
            if 2.0 * (two + others) < best:
                best, chosen, left, right = 2.0 * (two + others), k + 4, two, others
    pair = 1 if chosen > last else 0
    exchange_boxes(records, SIZE * (begin + pair), records, SIZE * (chosen - 4 * pair))
    return begin + 1 + pair, left, right


@inline
def _area_of(records: Floats, begin: int, end: int, boxes: Floats, at: int) -> float:
    """Return half the area of the box around records; boxes[at:] is overwritten."""
    clear_box(boxes, at)
    for i in range(begin, end):
        join_box(boxes, at, records, SIZE * i)
    return half_area(boxes, at)


@helper
def cut_group(
    records: Floats, begin: int, end: int, weighted: bool, boxes: Floats, counts: Counts
) -> tuple[int, float, float]:
    """Split a group of at least two in place: (first of the second part, half the areas of both)."""
    if end - begin <= 4 and not weighted:
        return _cut_few(records, begin, end - begin)
    bins = BINS if end - begin > MANY else FEW_BINS
    ax, ay, az, bx, by, bz = centers(records, begin, end)
    scales = _bin_scale(ax, bx, bins), _bin_scale(ay, by, bins), _bin_scale(az, bz, bins)
    _fill_bins(records, begin, end, (ax, ay, az), scales, bins, weighted, boxes, counts)
    axis, border, left, right = _best_cut(scales, bins, boxes, counts)
    if axis >= 0:
        low = ax if axis == 0 else (ay if axis == 1 else az)
        return _partition(records, begin, end, Border(axis, low, scales[axis], border), bins), left, right
    # Equal middles: split in the middle.
    middle = (begin + end) // 2
    left = _area_of(records, begin, middle, boxes, _LAST)
    return middle, left, _area_of(records, middle, end, boxes, _LAST)


# The first branches of a large tree: boxes are sorted into the cells of a grid, and groups of cells are split
#
# A cell is a record itself, the box around its boxes, with their number as cost and the place of the first as item. A
# box that is wide for the grid is a cell of its own. Cells and groups depend on the boxes alone, so the tree does not
# depend on the threads. The users are scenes of 10,000 bodies and more: over a million balls the upper branches take a
# fourth of the time, with the sorting, that they take without cells; the tree's cost is half a hundredth more.

ONE_THREAD = 1 << 13  # groups of no more records are built by one thread
_IN_CELL = 64  # most records in a cell, in the mean; with 8 of them the cost of the tree is two hundredths more
_WIDE = 2.0  # times the width of a cell: wider boxes are cells of their own
_PARTS = 16  # parts of the records that threads sort side by side


@record_shapes()
class Grid(NamedTuple):
    """The cells of a grid over the middles of boxes, and one more for wide boxes."""

    lows: tuple[float, float, float]  # where it begins; doubled, as are middles
    scales: tuple[float, float, float]  # cells per length, doubled too
    sizes: tuple[int, int, int]
    width: float  # the greatest width of a box


@inline
def _cell(records: Floats, i: int, grid: Grid) -> Any:
    """Return the cell of a box."""
    at, lows, scales, sizes = SIZE * i, grid.lows, grid.scales, grid.sizes
    wide = max(records[at + 4] + records[at], records[at + 5] + records[at + 1], records[at + 6] + records[at + 2])
    x = _bin(_center(records, i, 0), lows[0], scales[0], sizes[0])
    y = _bin(_center(records, i, 1), lows[1], scales[1], sizes[1])
    z = _bin(_center(records, i, 2), lows[2], scales[2], sizes[2])
    return sizes[0] * sizes[1] * sizes[2] if wide > grid.width else (x * sizes[1] + y) * sizes[2] + z


@kernel(records="8*n", begin="0..end", end="0..n", counts="out c")
def count_in_cells(records: Floats, begin: int, end: int, grid: Grid, counts: Ints) -> None:
    """Add the number of records begin..end in each cell to its count."""
    for i in range(begin, end):
        cell = _cell(records, i, grid)
        if 0 <= cell < len(counts):
            counts[cell] += 1


@kernel(records="8*n", begin="0..end", end="0..n", places="out c", target="out 8*n")
def sort_into_cells(records: Floats, begin: int, end: int, grid: Grid, places: Ints, target: Floats) -> None:
    """Copy records begin..end to the places of their cells, which move on."""
    for i in range(begin, end):
        cell = _cell(records, i, grid)
        if 0 <= cell < len(places) and 0 <= places[cell] < len(target) // SIZE:
            copy_box(target, SIZE * places[cell], records, SIZE * i)
            places[cell] += 1


@kernel(records="8*n", firsts="c", sizes="c", begin="0..end", end="0..c", cells="out 8*c")
def box_cells(records: Floats, firsts: Ints, sizes: Ints, begin: int, end: int, cells: Floats) -> None:
    """Write cells begin..end, each of so many records from a first one on."""
    for k in range(begin, end):
        clear_box(cells, SIZE * k)
        for i in range(max(0, firsts[k]), min(firsts[k] + sizes[k], len(records) // SIZE)):
            join_box(cells, SIZE * k, records, SIZE * i)
        cells[SIZE * k + COST], cells[SIZE * k + ITEM] = sizes[k], firsts[k]


@inline
def boxes_in(cells: Floats, begin: int, end: int) -> Any:
    """Return the number of boxes in cells begin..end."""
    count = 0
    for k in range(begin, end):
        count += _weight(cells, k)
    return count


@kernel(cells="out 8*c")
def cut_cells(cells: Floats) -> tuple[int, int, float, float]:
    """Split cells in place: (cells and boxes in the first part, half the areas of both)."""
    boxes, counts = np.empty(BOXES), np.empty(3 * BINS, np.int64)
    border, left, right = cut_group(cells, 0, len(cells) // SIZE, True, boxes, counts)
    return border, boxes_in(cells, 0, border), left, right


@dataclass
class RecordGroup:
    """Records first..last, their cells, if there are more than one thread takes, and the groups it was split into."""

    first: int
    last: int
    cells: Floats
    area: float = 0.0
    halves: tuple[RecordGroup, ...] = ()


def partition_large(records: Floats) -> tuple[list[RecordGroup], Floats]:
    """Split cells of records into groups of at most `ONE_THREAD` records.

    Returns
    -------
    tuple[list[RecordGroup], Floats]
        All groups, each before its halves, the root first; and the records by cells. `records` is overwritten, with
        anything, where there are cells.
    """
    groups = wave = [RecordGroup(0, len(records) // SIZE, np.zeros(0))]
    if groups[0].last <= ONE_THREAD:
        return groups, np.zeros(0)
    source = np.empty_like(records)
    groups[0].cells = _cells(records, source, 0)
    while wave:
        for group in wave:
            if len(group.cells) == SIZE:
                # One cell of too many records has a finer grid
                place, own = int(group.cells[ITEM]), records[SIZE * group.first : SIZE * group.last]
                own[:] = source[SIZE * place :][: len(own)]
                group.cells = _cells(own, source[SIZE * place :][: len(own)], place)
        for group, cut in zip(wave, run_calls(cut_cells, [(group.cells,) for group in wave]), strict=True):
            border, middle = SIZE * cut[0], group.first + cut[1]
            group.halves = (
                RecordGroup(group.first, middle, group.cells[:border], cut[2]),
                RecordGroup(middle, group.last, group.cells[border:], cut[3]),
            )
        halves = [half for group in wave for half in group.halves]
        groups = groups + halves
        wave = [group for group in halves if group.last - group.first > ONE_THREAD]
    return groups, source


def _cells(records: Floats, target: Floats, first: int) -> Floats:
    """Copy records to `target` by the cells of a grid; return the cells. The place of the first record is `first`."""
    count = len(records) // SIZE
    parts = [(k * count // _PARTS, (k + 1) * count // _PARTS) for k in range(_PARTS)]
    limits = np.array(run_calls(centers, [(records, *part) for part in parts]))
    grid = _grid(limits[:, :3].min(axis=0).tolist(), limits[:, 3:].max(axis=0).tolist(), count)
    counts = np.zeros((_PARTS, math.prod(grid.sizes) + 1), np.int32)
    run_calls(count_in_cells, [(records, *part, grid, own) for part, own in zip(parts, counts, strict=True)])
    sizes = counts.sum(axis=0, dtype=np.int32)
    firsts = np.cumsum(sizes, dtype=np.int32) - sizes
    places = np.cumsum(counts, axis=0, dtype=np.int32) - counts + firsts
    run_calls(sort_into_cells, [(records, *part, grid, own, target) for part, own in zip(parts, places, strict=True)])
    inner, wide = np.flatnonzero(sizes[:-1]), np.arange(firsts[-1], count, dtype=np.int32)
    firsts, sizes = np.append(firsts[inner], wide), np.append(sizes[inner], np.ones_like(wide))
    if len(firsts) == 1:
        # All middles are equal: any cells will do
        firsts = np.arange(0, count, _IN_CELL, dtype=np.int32)
        sizes = np.minimum(count - firsts, np.int32(_IN_CELL))
    cells = np.empty(SIZE * len(firsts))
    run_chunks(KernelRange(box_cells, (target, firsts, sizes), (cells,)), len(firsts), ONE_THREAD)
    cells[ITEM::SIZE] += first
    return cells


def _grid(lows: list[float], highs: list[float], count: int) -> Grid:
    """Return a grid for so many boxes, whose cells are about as wide along each axis.

    It has powers of two of cells, so that halves of groups are made of whole cells.
    """
    sizes, widths = [1, 1, 1], [high - low for low, high in zip(lows, highs, strict=True)]
    while _IN_CELL * math.prod(sizes) < count:
        k = max(range(3), key=lambda k: widths[k] / sizes[k])
        sizes[k] *= 2
    scales = [_bin_scale(low, high, size) for low, high, size in zip(lows, highs, sizes, strict=True)]
    # Middles are doubled
    side = max(width / size for width, size in zip(widths, sizes, strict=True)) / 2.0
    return Grid(tuple(lows), tuple(scales), tuple(sizes), _WIDE * side)  # type: ignore[arg-type]
