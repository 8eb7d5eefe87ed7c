"""What bounds a place in the hierarchy: the regions of all cells around it, and lattice elements."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from ...shapes.motion import Motion
from ...shapes.row_vectors import product
from .extent import EVERYWHERE, End, Extent
from .narrowing import Conjunction, Part, cost
from .placement import Point


@dataclass(frozen=True, slots=True)
class Context:
    """Intersections of sides, each before one motion to the world."""

    groups: tuple[tuple[Motion, Conjunction], ...] = ()

    def and_(self, motion: Motion, parts: Iterable[Part], extent: Extent = EVERYWHERE) -> Context | None:
        """With further parts before `motion`; None where nothing is left."""
        before = dict(self.groups)
        narrowed = before.get(motion, Conjunction()).and_(parts, extent)
        return None if narrowed is None else Context(tuple((before | {motion: narrowed}).items()))

    def moved(self, shift: Point) -> Context:
        """The same elsewhere; for one without motions."""
        return Context(tuple((motion, conjunction.moved(shift)) for motion, conjunction in self.groups))

    @property
    def is_unmoved(self) -> bool:
        """Are all its parts where they are in the world?"""
        return all(motion.is_identity for motion, _ in self.groups)

    def cost(self, motion: Motion, parts: Iterable[Part]) -> int:
        """How many sides and pairs of sides `and_` looks at, at most."""
        return cost(dict(self.groups).get(motion, Conjunction()), parts)

    def extent_before(self, motion: Motion) -> Extent:
        """A box around everything, in the coordinates before a motion."""
        whole = EVERYWHERE
        for other, conjunction in self.groups:
            extent = conjunction.extent
            whole = whole.common(extent if other == motion else _carried(extent, other, motion))
        return whole


def _carried(extent: Extent, motion: Motion, back: Motion) -> Extent:
    """A box around an extent after a motion and back through another, widened by the rounding of floats."""
    matrix = product(back.inverse_matrix, motion.matrix)
    linear = np.where(np.abs(matrix[:3, :3]) < 1e-12, 0.0, matrix[:3, :3])
    low = np.array([-math.inf if end is None else float(end) for end in extent.low])
    high = np.array([math.inf if end is None else float(end) for end in extent.high])
    lows: list[End] = []
    highs: list[End] = []
    for row, shift in zip(linear, matrix[:3, 3], strict=True):
        used = row != 0
        ends = np.stack([row[used] * low[used], row[used] * high[used]])
        size = 1e-9 * (np.abs(ends).max(initial=0.0) + abs(shift))
        lows.append(_end(ends.min(axis=0).sum() + shift - size))
        highs.append(_end(ends.max(axis=0).sum() + shift + size))
    return Extent((lows[0], lows[1], lows[2]), (highs[0], highs[1], highs[2]))


def _end(value: float) -> End:
    return Fraction(value) if math.isfinite(value) else None
