"""What a tree is built from: boxes as records that are moved about, without empty ones and without infinities.

An axis along which a box has no end gets an end a little beyond everything finite, which is `restored` in the nodes.
Boxes are widened, so that neither the rounding of a slab test nor that of the origin of a ray that starts on a surface
ever loses what they hold (`culling/slack.py`).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ....compiler.jit import inline, kernel
from ....shapes.row_vectors import lengths
from ...culling.slack import BESIDE, WALL
from ...tables import Floats, Ints, Longs, Signs
from ...threads import run_chunks
from .vectors import COST, HIGH, ITEM, NEGATED_LOW, SIZE

EMPTY, ENDLESS = 8, 7
CHUNK = 1 << 16


class Survey(NamedTuple):
    """What is known of boxes (n, 6) before a tree is built over them."""

    patterns: Signs  # (n,) bit k: no end along axis k; EMPTY: nothing in it
    counts: Ints  # (9,) boxes of each pattern
    bounded: Floats  # (6,) around those with all ends
    ends: Floats  # (6,) around all ends there are


def survey(boxes: Floats) -> Survey:
    """Sort boxes by the axes along which they have no end."""
    chunks = max(1, -(-len(boxes) // CHUNK))
    patterns = np.empty(len(boxes), np.int8)
    counts, around = np.zeros((chunks, 9), np.int64), np.full((chunks, 2, 6), np.inf)
    around[:, :, 3:] = -np.inf

    def work(begin: int, end: int) -> None:
        for k in range(begin, end):
            _survey(boxes, k * CHUNK, min(len(boxes), (k + 1) * CHUNK), patterns, counts[k], around[k])

    run_chunks(work, -(-len(boxes) // CHUNK), 1)
    low, high = around[:, :, :3].min(axis=0), around[:, :, 3:].max(axis=0)
    bounded, ends = np.concatenate([low, high], axis=1)
    return Survey(patterns, counts.sum(axis=0).astype(np.int32), bounded, ends)


@kernel(boxes="n 6", begin="0..end", end="0..n", patterns="out n", counts="out 9", around="out 2 6")
def _survey(boxes: Floats, begin: int, end: int, patterns: Signs, counts: Longs, around: Floats) -> None:
    """Patterns of boxes begin..end, how many there are of each, and the boxes around them."""
    for i in range(begin, end):
        pattern, empty = 0, False
        for k in range(3):
            low, high = boxes[i, k], boxes[i, k + 3]
            empty = empty or not low <= high
            if not (low > -math.inf and high < math.inf):
                pattern |= 1 << k
        if empty:
            pattern = EMPTY
        patterns[i] = pattern
        counts[pattern] += 1
        if empty:
            continue
        for part in range(2):
            if part == 0 and pattern != 0:
                continue
            for k in range(3):
                low, high = boxes[i, k], boxes[i, k + 3]
                if low > -math.inf:
                    around[part, k] = low if low < around[part, k] else around[part, k]
                    around[part, k + 3] = low if low > around[part, k + 3] else around[part, k + 3]
                if high < math.inf:
                    around[part, k] = high if high < around[part, k] else around[part, k]
                    around[part, k + 3] = high if high > around[part, k + 3] else around[part, k + 3]


def stand_ins(ends: Floats) -> Floats:
    """(6,) finite numbers beyond all finite ends, in place of -inf and inf."""
    low, high = np.where(ends[:3] <= ends[3:], ends[:3], 0.0), np.where(ends[:3] <= ends[3:], ends[3:], 0.0)
    beyond = max(float(lengths(high - low)), 1e-3 * float(np.abs([low, high]).max())) or 1.0
    return np.concatenate([low - beyond, high + beyond])


def records_of(boxes: Floats, rows: Ints, first_item: int, costs: Floats, limits: Floats) -> Floats:
    """(8 n,) a vector for each of rows (of all boxes, if `rows` is empty), of item first_item + row and costs[row]."""
    count = len(rows) or len(boxes)
    records = np.empty(SIZE * count)
    run_chunks(lambda a, b: _load(boxes, rows, a, b, first_item, costs, limits, records), count, CHUNK)
    return records


@kernel(boxes="b 6", rows="n|0", begin="0..end", end="0..n", costs="b|0", limits="6", records="out 8*n")
def _load(
    boxes: Floats, rows: Ints, begin: int, end: int, first_item: int, costs: Floats, limits: Floats, records: Floats
) -> None:
    """Records begin..end, widened by their slack."""
    for i in range(begin, end if len(rows) > 0 else min(end, len(boxes))):
        row = rows[i] if len(rows) > 0 else i
        margin = BESIDE * _size(boxes, row, limits) + WALL
        for k in range(3):
            low, high = boxes[row, k], boxes[row, k + 3]
            records[SIZE * i + NEGATED_LOW + k] = margin - low if low > -math.inf else -limits[k]
            records[SIZE * i + HIGH + k] = high + margin if high < math.inf else limits[k + 3]
        records[SIZE * i + COST] = costs[row] if len(costs) > 0 else 1.0
        records[SIZE * i + ITEM] = first_item + row


@inline
def _size(boxes: Floats, row: int, limits: Floats) -> float:
    """At least |x| of every point of a box; where it has no end, of every point within the limits."""
    size = 0.0
    for k in range(3):
        low, high = boxes[row, k], boxes[row, k + 3]
        size += max(abs(low if low > -math.inf else limits[k]), abs(high if high < math.inf else limits[k + 3]))
    return size


@inline
def restored(limits: Floats, k: int, value: float) -> float:
    """An end of a box, infinite where it stood in for that: k in 0..2 low, 3..5 high."""
    if k < 3:
        return -math.inf if value <= limits[k] else value
    return math.inf if value >= limits[k] else value
