"""Boolean algebra on the spans of leaves, ray by ray: what the spans of a tree must be, to the bit."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from .trees import Node, combined


def table(spans: Any, body: int) -> tuple[Any, Any]:
    """(enter, exit) of one body, (rays, most) each, filled up with inf."""
    rays = len(spans.offsets) - 1
    ray = np.repeat(np.arange(rays), np.diff(spans.offsets))
    mine = spans.body == body
    ray, enter, leave = ray[mine], spans.t_enter[mine], spans.t_exit[mine]
    counts = np.bincount(ray, minlength=rays)
    place = np.arange(len(ray)) - np.repeat(np.cumsum(counts) - counts, counts)
    result = np.full((2, rays, max(1, counts.max(initial=0))), math.inf)
    result[0, ray, place], result[1, ray, place] = enter, leave
    return result[0], result[1]


def expected(node: Node, spans: Any, first: int) -> tuple[Any, Any]:
    """(enter, exit) of a tree whose leaves are bodies first, first + 1, ... of the scene; filled up with inf."""
    count = sum(1 for _ in node.leaves())
    leaves = [table(spans, first + k) for k in range(count)]
    ends = np.sort(
        np.concatenate([np.full((len(leaves[0][0]), 1), -math.inf), *(end for leaf in leaves for end in leaf)], axis=1),
        axis=1,
    )
    # Between an end and the next, every leaf is in or out; equal ends leave nothing between them
    low, high = ends, np.concatenate([ends[:, 1:], np.full((len(ends), 1), math.inf)], axis=1)
    truth = iter(
        [
            ((enter[:, None] <= low[..., None]) & (low[..., None] < leave[:, None])).any(axis=2)
            for enter, leave in leaves
        ]
    )
    inside = _truth(node, truth) & (low < high)
    # Join pieces that follow each other
    full = low < high
    result = []
    for row in range(len(ends)):
        kept = full[row]
        state = np.concatenate([[False], inside[row][kept], [False]])
        turns = np.flatnonzero(state[1:] != state[:-1])
        places = np.concatenate([low[row][kept], [math.inf]])
        result.append(places[turns])
    most = max(2, *(len(row) for row in result))
    filled = np.array([np.concatenate([row, np.full(most + most % 2 - len(row), math.inf)]) for row in result])
    return filled[:, ::2], filled[:, 1::2]


def _truth(node: Node, truth: Any) -> Any:
    return (
        next(truth) if node.leaf is not None else combined(node.operation, [_truth(part, truth) for part in node.parts])
    )


def without_hairs(spans: tuple[Any, Any]) -> tuple[Any, Any]:
    """Spans whose ends round to the same float left out, and those joined with nothing but such a gap between them.

    The algebra above knows ends by their floats. Crossings that are told apart exactly may share one.
    """
    rows = []
    for enter, leave in zip(*spans, strict=True):
        kept: list[list[float]] = []
        for a, b in zip(enter.tolist(), leave.tolist(), strict=True):
            if kept and kept[-1][1] == a:
                kept[-1][1] = b
            elif a < b:
                kept.append([a, b])
        rows.append([span for span in kept if span[0] < math.inf])
    most = max(1, *(len(row) for row in rows))
    filled = np.array([row + [[math.inf, math.inf]] * (most - len(row)) for row in rows])
    return filled[..., 0], filled[..., 1]


def same(one: tuple[Any, Any], other: tuple[Any, Any]) -> Any:
    """(rays,) bool: equal spans to the bit."""
    most = max(one[0].shape[1], other[0].shape[1])
    padded = [
        np.pad(end, ((0, 0), (0, most - end.shape[1])), constant_values=math.inf)
        for pair in (one, other)
        for end in pair
    ]
    return ((padded[0] == padded[2]) & (padded[1] == padded[3])).all(axis=1)
