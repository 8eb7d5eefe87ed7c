"""The first branches of a large tree: all threads part its groups together, until each group is one thread's work.

Chunks and groups depend on the boxes alone, so the tree does not depend on the threads.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...tables import Floats
from ...threads import run_chunks
from .bins import BINS, BOXES, Border, best_cut, bin_scale, centers, distribute, fill_bins
from .vectors import SIZE

ALONE = 1 << 13  # a group of no more records is built by one thread
_CHUNK = 1 << 15


@dataclass
class Group:
    """Records first..last, and the two groups they were parted into."""

    first: int
    last: int
    area: float = 0.0
    moved: bool = False  # is in the second copy of the records
    halves: tuple[Group, Group] | None = None


def part_large(records: Floats) -> list[Group]:
    """Order records by groups of at most `ALONE`; all groups, each before its halves, the first of all first."""
    groups = [Group(0, len(records) // SIZE)]
    wave = [group for group in groups if group.last - group.first > ALONE]
    if not wave:
        return groups
    copies = records, np.empty_like(records)
    while wave:
        _part_all(wave, copies)
        halves = [half for group in wave for half in group.halves or ()]
        groups += halves
        wave = [group for group in halves if group.last - group.first > ALONE]
    pieces = _pieces([group for group in groups if group.halves is None and group.moved])
    _on_all(pieces, lambda _, group, a, b: _copy(copies[1], copies[0], a, b))
    return groups


def _copy(source: Floats, target: Floats, begin: int, end: int) -> None:
    """Copy records begin..end."""
    target[SIZE * begin : SIZE * end] = source[SIZE * begin : SIZE * end]


def box_area(box: Floats) -> float:
    """Half the surface of a box (8,) as records hold it."""
    x, y, z = (box[4:7] + box[:3]).tolist()
    return float(x * y + y * z + z * x)


Piece = tuple[Group, int, int]


def _pieces(groups: list[Group]) -> list[Piece]:
    """Chunks of groups, each some records of one group."""
    return [
        (group, begin, min(begin + _CHUNK, group.last))
        for group in groups
        for begin in range(group.first, group.last, _CHUNK)
    ]


def _on_all(pieces: list[Piece], work: Callable[[int, Group, int, int], None]) -> None:
    """Call work(k, *pieces[k]) for every piece, on all threads."""

    def some(begin: int, end: int) -> None:
        for k in range(begin, end):
            work(k, *pieces[k])

    run_chunks(some, len(pieces), 1)


def _part_all(groups: list[Group], copies: tuple[Floats, Floats]) -> None:
    """Part every group in two, into the other copy of the records."""
    pieces = _pieces(groups)
    places: dict[int, list[int]] = {}
    for k, (group, _, _) in enumerate(pieces):
        places.setdefault(id(group), []).append(k)
    limits = np.empty((len(pieces), 6))

    def measure(k: int, group: Group, begin: int, end: int) -> None:
        """The limits of a piece's middles."""
        limits[k] = centers(copies[group.moved], begin, end)

    _on_all(pieces, measure)
    frames = {id(group): _frame(limits[places[id(group)]]) for group in groups}
    boxes, counts = np.empty((len(pieces), BOXES)), np.empty((len(pieces), 3 * BINS), np.int64)

    def count(k: int, group: Group, begin: int, end: int) -> None:
        """The bins of a piece."""
        fill_bins(copies[group.moved], begin, end, *frames[id(group)], BINS, boxes[k], counts[k])

    _on_all(pieces, count)
    plan: dict[int, tuple[Any, ...]] = {}
    for group in groups:
        mine = places[id(group)]
        _plan(group, frames[id(group)], mine, boxes[mine], counts[mine], plan)

    def move(k: int, group: Group, begin: int, end: int) -> None:
        """The records of a piece into their halves."""
        if k in plan:
            border, left, right = plan[k]
            distribute(copies[group.moved], begin, end, border, copies[not group.moved], left, right)

    _on_all(pieces, move)


def _frame(limits: Floats) -> tuple[Any, Any]:
    """Where bins begin, and bins per length, on each axis."""
    low, high = limits[:, :3].min(axis=0).tolist(), limits[:, 3:].max(axis=0).tolist()
    return tuple(low), tuple(bin_scale(a, b, BINS) for a, b in zip(low, high, strict=True))


def _plan(
    group: Group, frame: tuple[Any, Any], pieces: list[int], boxes: Floats, counts: Any, plan: dict[int, Any]
) -> None:
    """Choose the cut of a group, and where each of its pieces puts what lies before and behind it."""
    lows, scales = frame
    joined = np.append(boxes[:, : 3 * BINS * SIZE].max(axis=0), np.empty(SIZE + BINS))
    axis, border, left_area, right_area = best_cut(scales, BINS, joined, counts.sum(axis=0))
    if axis < 0:
        # All middles are equal: any half will do
        middle, area = (
            (group.first + group.last) // 2,
            box_area(joined[: 3 * BINS * SIZE].reshape(-1, SIZE).max(axis=0)),
        )
        group.halves = Group(group.first, middle, area, group.moved), Group(middle, group.last, area, group.moved)
        return
    before = counts[:, axis * BINS : axis * BINS + border].sum(axis=1)
    middle = group.first + int(before.sum())
    lefts = group.first + np.cumsum(before) - before
    behind = counts[:, :BINS].sum(axis=1) - before
    rights = middle + np.cumsum(behind) - behind
    for k, left, right in zip(pieces, lefts, rights, strict=True):
        plan[k] = Border(int(axis), lows[axis], scales[axis], int(border)), int(left), int(right)
    group.halves = (
        Group(group.first, middle, left_area, not group.moved),
        Group(middle, group.last, right_area, not group.moved),
    )
