"""What bounds a place in the hierarchy: the regions of all cells around it, and lattice elements."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from ...shapes.motion import Motion
from ...shapes.row_vectors import product
from .about_axis import AboutAxis
from .extent import EVERYWHERE, End, Extent
from .narrowing import Conjunction, Part, cost
from .placement import Point


@dataclass(frozen=True, slots=True)
class Context:
    """Intersections of sides, each before one motion to the world."""

    groups: tuple[tuple[Motion, Conjunction], ...] = ()

    def and_(self, motion: Motion, parts: Iterable[Part], extent: Extent = EVERYWHERE) -> Context | None:
        """With further parts before `motion`, the innermost there is; None where nothing is left.

        What other groups say of all of a box around these parts is left out. It stays true, as nothing is left out of
        this group on their account, and nothing more comes to them once another motion is the innermost.
        """
        before = dict(self.groups)
        narrowed = before.get(motion, Conjunction()).and_(parts, extent)
        if narrowed is None:
            return None
        if not before.keys() - {motion}:
            return Context(((motion, narrowed),))
        groups: list[tuple[Motion, Conjunction]] = []
        for other, conjunction in (before | {motion: narrowed}).items():
            left = conjunction if other == motion else conjunction.inside(_carried(narrowed.extent, motion, other))
            if left is None:
                return None
            if left.parts or other == motion:
                groups.append((other, left))
        return Context(tuple(groups))

    def entering(self, entry: Motion, before: Motion, after: Motion) -> Context:
        """The same where `entry` comes before the innermost motion so far, both together being `after`.

        Parts that lie about the axis of a turn, or across it, are said of what is turned, so that they are before the
        same motion as what comes to them.
        """
        about = AboutAxis.of(entry)
        groups = dict(self.groups)
        outside = groups.pop(before, None)
        if about is None or outside is None:
            return self
        told = [(part, about.undone(part)) for part in outside.parts]
        inside = Conjunction().and_(turned for _, turned in told if turned is not None)
        stay = Conjunction().and_(part for part, turned in told if turned is None)
        if inside is None or stay is None:  # fractions show only now what was there
            return self
        if stay.parts:
            groups[before] = stay
        return Context(tuple((groups | {after: inside}).items()))

    def moved(self, shift: Point) -> Context:
        """The same elsewhere, before its motions."""
        return Context(tuple((motion, conjunction.moved(shift)) for motion, conjunction in self.groups))

    def is_before(self, motion: Motion) -> bool:
        """Are all its parts before one motion?"""
        return all(other == motion for other, _ in self.groups)

    def cost(self, motion: Motion, parts: Iterable[Part]) -> int:
        """How many sides and pairs of sides `and_` looks at, at most."""
        others = sum(conjunction.size for other, conjunction in self.groups if other != motion)
        return others + cost(dict(self.groups).get(motion, Conjunction()), parts)

    def extent_before(self, motion: Motion) -> Extent:
        """A box around everything, in the coordinates before a motion."""
        whole = EVERYWHERE
        for other, conjunction in self.groups:
            extent = conjunction.extent
            whole = whole.common(extent if other == motion else _carried(extent, other, motion, 1e-12))
        return whole


def _carried(extent: Extent, motion: Motion, back: Motion, nothing: float = 0.0) -> Extent:
    """A box around an extent after a motion and back through another, widened by the rounding of floats.

    nothing: entries of the motion up to here are taken for what rounding left of none.
    """
    matrix = product(back.inverse_matrix, motion.matrix)
    far = np.abs(back.inverse_matrix[:3, :3]) @ np.abs(motion.matrix[:3, 3]) + np.abs(back.inverse_matrix[:3, 3])
    linear = np.where(np.abs(matrix[:3, :3]) < nothing, 0.0, matrix[:3, :3])
    low = np.array([-math.inf if end is None else float(end) for end in extent.low])
    high = np.array([math.inf if end is None else float(end) for end in extent.high])
    lows: list[End] = []
    highs: list[End] = []
    for row, shift, lost in zip(linear, matrix[:3, 3], 2.0**-48 * far, strict=True):  # of shifts that cancel
        used = row != 0
        ends = np.stack([row[used] * low[used], row[used] * high[used]])
        size = 1e-9 * (np.abs(ends).max(initial=0.0) + abs(shift)) + lost
        lows.append(_end(ends.min(axis=0).sum() + shift - size))
        highs.append(_end(ends.max(axis=0).sum() + shift + size))
    return Extent((lows[0], lows[1], lows[2]), (highs[0], highs[1], highs[2]))


def _end(value: float) -> End:
    return Fraction(value) if math.isfinite(value) else None
