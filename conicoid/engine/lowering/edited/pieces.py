"""What an edited scene has in common with the one it comes from: pieces of two scenes, one after the other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ....shapes.body import Body
from ..laid import BODIES, Laid
from ...tables import Longs

_KEPT, _NEW = 0, 1
Run = tuple[int, int, int]
"""Which of two scenes, and from which of its entries up to which."""


def runs(old: Sequence[Body], new: Sequence[Body]) -> tuple[list[Run], list[int]]:
    """Pieces of an old scene and of one of what is new that make up the new scene; which of its entries are new.

    What has the same shape, and comes in the same order, is kept.
    """
    kept = _kept(old, new)
    found: list[Run] = []
    fresh: list[int] = []
    for number, before in enumerate(kept):
        source, entry = (_KEPT, before) if before >= 0 else (_NEW, len(fresh))
        if before < 0:
            fresh.append(number)
        if found and found[-1][0] == source and found[-1][2] == entry:
            found[-1] = (source, found[-1][1], entry + 1)
        else:
            found.append((source, entry, entry + 1))
    return found, fresh


def _kept(old: Sequence[Body], new: Sequence[Body]) -> list[int]:
    """For each new entry the old one that it is, in rising order, or -1."""
    least = min(len(old), len(new))
    front = 0
    while front < least and old[front].shape is new[front].shape:
        front += 1
    back = 0
    while back < least - front and old[-1 - back].shape is new[-1 - back].shape:
        back += 1
    kept, last = list(range(front)), front - 1
    middle = new[front : len(new) - back]
    if len(old) == len(new):
        kept += [
            front + k if before.shape is after.shape else -1
            for k, (before, after) in enumerate(zip(old[front : len(old) - back], middle, strict=True))
        ]
    else:
        places: dict[int, list[int]] = {}
        for number in range(len(old) - back - 1, front - 1, -1):
            places.setdefault(id(old[number].shape), []).append(number)
        for body in middle:
            numbers = places.get(id(body.shape), [])
            while numbers and numbers[-1] <= last:
                numbers.pop()
            kept.append(numbers.pop() if numbers else -1)
            last = max(last, kept[-1])
    return kept + list(range(len(old) - back, len(old)))


@dataclass(frozen=True)
class Pieces:
    """Pieces of an old scene (0) and of one of what is new (1). Columns are the kinds of rows of `Laid`."""

    sources: list[int]
    begin: Longs  # (pieces, 18) their first rows
    end: Longs
    at: Longs  # where these come to
    total: Longs  # (18,)

    @classmethod
    def of(cls, found: Sequence[Run], laid: tuple[Laid, Laid]) -> Pieces:
        """The pieces that runs of entries are."""
        begin, end = (np.zeros((len(found), 18), np.int64) for _ in range(2))
        for source in (_KEPT, _NEW):
            mine = [k for k, run in enumerate(found) if run[0] == source]
            bounds = np.array([found[k][1:] for k in mine], np.int64).reshape(-1)
            rows = laid[source].rows_up_to(bounds)
            begin[mine], end[mine] = rows[0::2], rows[1::2]
        ends = np.cumsum(end - begin, axis=0)
        total = ends[-1] if len(found) else np.zeros(18, np.int64)
        return cls([run[0] for run in found], begin, end, ends - (end - begin), total)

    def on(self, axis: int) -> list[tuple[int, slice, slice]]:
        """(source, its rows, where they come to) of all pieces that have rows of a kind."""
        parts = zip(
            self.sources, self.begin[:, axis].tolist(), self.end[:, axis].tolist(), self.at[:, axis].tolist(),
            strict=True,
        )  # fmt: skip
        return [(source, slice(a, b), slice(at, at + b - a)) for source, a, b, at in parts if b > a]

    def moved(self, axis: int, beside: int) -> list[tuple[int, slice, slice, int]]:
        """`on`, and by how much numbers of rows of another kind grow there."""
        shifts = (self.at - self.begin)[:, beside].tolist()
        chosen = (self.end > self.begin)[:, axis].tolist()
        of_pieces = [shift for shift, there in zip(shifts, chosen, strict=True) if there]
        return [(*part, shift) for part, shift in zip(self.on(axis), of_pieces, strict=True)]

    @property
    def bodies(self) -> int:
        """How many bodies come from what is new."""
        mine = np.array(self.sources) == _NEW
        return int((self.end - self.begin)[mine, BODIES].sum())
