"""Which bodies may have points in common: pairs whose boxes do."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ...shapes.vector import Box


def near_pairs(boxes: Sequence[Box]) -> Iterator[tuple[int, int]]:
    """Pairs (i, j), i < j, of boxes that overlap by more than a face, for each j in the order of i."""
    if len(boxes) < 2:
        return
    lows, highs = (np.array([box[end] for box in boxes]) for end in (0, 1))
    order = np.argsort(lows[:, 0], kind="stable")
    starts = lows[order, 0]
    found: dict[int, list[int]] = {}
    for place, i in enumerate(order.tolist()):
        last = int(np.searchsorted(starts, highs[i, 0], side="left"))
        others = order[place + 1 : last]
        meets = ((lows[others] < highs[i]) & (lows[i] < highs[others])).all(axis=1)
        for k in others[meets].tolist():
            found.setdefault(max(i, k), []).append(min(i, k))
    for later in sorted(found):
        yield from ((before, later) for before in sorted(found[later]))
