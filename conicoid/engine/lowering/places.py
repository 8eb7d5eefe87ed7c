"""What the bodies of a scene have become, and where the rows of each are in the tables."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..tables import Floats, Ints
from .moved_rows import MovedRows
from .pattern import Group


@dataclass
class Balls:
    """Bulk balls: the numbers of their bodies, (n, 4) centers and radii, boxes (n, 6) and -1 - k for their frame k."""

    bodies: Ints
    spheres: Floats
    boxes: Floats
    frame: int


@dataclass
class Contents:
    """What a scene's bodies have become: groups of one pattern each, bulk balls, and the frames of balls."""

    body_count: int
    groups: list[Group] = field(default_factory=list)
    balls: list[Balls] = field(default_factory=list)
    ball_frames: list[Floats] = field(default_factory=list)


@dataclass
class Places:
    """Where the rows of each body begin in a column of the tables, and how many there are in all."""

    first: Ints
    count: int

    @classmethod
    def of(cls, contents: Contents, each: Sequence[int]) -> Places:
        """`each`: how many the bodies of each group have."""
        if not any(each):
            return cls(np.broadcast_to(np.int32(0), contents.body_count), 0)
        counts = np.zeros(contents.body_count, np.int32)
        for group, number in zip(contents.groups, each, strict=True):
            counts[group.bodies] = number
        ends = np.cumsum(counts, dtype=np.int32)
        return cls(ends - counts, int(ends[-1]) if len(ends) else 0)

    @classmethod
    def alike(cls, contents: Contents, each: Sequence[int]) -> Places:
        """The same, where those of a group that are one another moved (`MovedRows`) have one: behind all others'."""
        shares = [isinstance(group.rows, MovedRows) for group in contents.groups]
        if not any(shares):
            return cls.of(contents, each)
        own = cls.of(contents, [0 if one else number for one, number in zip(shares, each, strict=True)])
        first, count = np.array(own.first), own.count
        for group, one, number in zip(contents.groups, shares, each, strict=True):
            if one:
                first[group.bodies] = count
                count += number
        return cls(first, count)

    def rows(self, group: Group, each: int) -> Ints:
        """(bodies, each) rows of a group's bodies."""
        rows: Any = self.first[group.bodies][:, None] + np.arange(each, dtype=np.int32)
        return rows
