"""What a turn about a line along an axis leaves as it is: planes across it, and what is round about it.

Such a part of a region is the same part of what is turned. Said of that, it needs no motion of its own, and fractions
show how it lies to other parts that are turned.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from ..._util.arrays import matmul_rows
from ...geometry.transform import Motion
from ...numerics.bigfloat import fraction, is_rounded
from .placement import UNBOUNDED, Extent, ExtentEnd, Point
from .region_simplifier import Conjunction, RegionPart, SurfaceSide, pair_cost
from .surfaces import ConeSurface, FlatSurface, RoundSurface, Surface


@dataclass(frozen=True)
class AxialMotion:
    """x ↦ A x + shift, where A keeps what is along an axis, and what is across it apart from that."""

    axis: int
    shift: Point
    rigid: bool
    """Are all distances kept?"""

    @classmethod
    def of(cls, motion: Motion) -> AxialMotion | None:
        """A motion as one of these, if it is one."""
        rows, shift = motion.affine
        if any(map(is_rounded, shift)):
            return None
        for axis in range(3):
            others = [i for i in range(3) if i != axis]
            if rows[axis][axis] == 1 and not any(rows[axis][i] or rows[i][axis] for i in others):
                x, y, z = (fraction(value) for value in shift)
                factor = motion.similarity
                return cls(axis, (x, y, z), factor is not None and factor == 1)
        return None

    def undone(self, part: RegionPart) -> RegionPart | None:
        """The part that the motion takes to a given one, if fractions say it."""
        if isinstance(part, SurfaceSide):
            surface = self._surface(part.surface)
            return None if surface is None else SurfaceSide(surface, part.positive)
        parts = [self.undone(piece) for piece in part.parts]
        kept = tuple(piece for piece in parts if piece is not None)
        return type(part)(kept) if len(kept) == len(parts) else None

    def _surface(self, surface: Surface) -> Surface | None:
        if isinstance(surface, FlatSurface):
            if surface.axis != self.axis:
                return None
            return replace(surface, offset=surface.offset - surface.normal[self.axis] * self.shift[self.axis])
        if isinstance(surface, RoundSurface) and surface.axis in (self.axis, None):
            center = self._on_axis(surface.center)
            if center is None:
                return None
            return replace(surface, center=(Fraction(0),) * 3 if surface.axis is not None else center)
        if isinstance(surface, ConeSurface) and surface.axis == self.axis:
            apex = self._on_axis(surface.apex)
            return None if apex is None else replace(surface, apex=apex)
        return None

    def _on_axis(self, point: Point) -> Point | None:
        """What is taken to a point on the axis that everything turns about; None for other points."""
        across = (point[i] == self.shift[i] for i in range(3) if i != self.axis)
        if not (self.rigid and all(across)):
            return None
        x, y, z = (point[i] - self.shift[i] if i == self.axis else Fraction(0) for i in range(3))
        return x, y, z


# What bounds a place in the hierarchy: the regions of all cells around it, and lattice elements.


@dataclass(frozen=True, slots=True)
class PlaceBounds:
    """Intersections of sides, each before one motion to the world."""

    groups: tuple[tuple[Motion, Conjunction], ...] = ()

    def and_(self, motion: Motion, parts: Iterable[RegionPart], extent: Extent = UNBOUNDED) -> PlaceBounds | None:
        """With further parts before `motion`, the innermost there is; None where nothing is left.

        What other groups say of all of a box around these parts is left out. It stays true, as nothing is left out of
        this group on their account, and nothing more comes to them once another motion is the innermost.
        """
        before = dict(self.groups)
        narrowed = before.get(motion, Conjunction()).and_(parts, extent)
        if narrowed is None:
            return None
        if not before.keys() - {motion}:
            return PlaceBounds(((motion, narrowed),))
        groups: list[tuple[Motion, Conjunction]] = []
        for other, conjunction in (before | {motion: narrowed}).items():
            left = conjunction if other == motion else conjunction.inside(_carry_extent(narrowed.extent, motion, other))
            if left is None:
                return None
            if left.parts or other == motion:
                groups.append((other, left))
        return PlaceBounds(tuple(groups))

    def entering(self, entry: Motion, before: Motion, after: Motion) -> PlaceBounds:
        """The same where `entry` comes before the innermost motion so far, both together being `after`.

        Parts that lie about the axis of a turn, or across it, are said of what is turned, so that they are before the
        same motion as what comes to them.
        """
        about = AxialMotion.of(entry)
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
        return PlaceBounds(tuple((groups | {after: inside}).items()))

    def moved(self, shift: Point) -> PlaceBounds:
        """The same elsewhere, before its motions."""
        return PlaceBounds(tuple((motion, conjunction.moved(shift)) for motion, conjunction in self.groups))

    def is_before(self, motion: Motion) -> bool:
        """Are all its parts before one motion?"""
        return all(other == motion for other, _ in self.groups)

    def cost(self, motion: Motion, parts: Iterable[RegionPart]) -> int:
        """How many sides and pairs of sides `and_` looks at, at most."""
        others = sum(conjunction.size for other, conjunction in self.groups if other != motion)
        return others + pair_cost(dict(self.groups).get(motion, Conjunction()), parts)

    def extent_before(self, motion: Motion) -> Extent:
        """A box around everything, in the coordinates before a motion."""
        whole = UNBOUNDED
        for other, conjunction in self.groups:
            extent = conjunction.extent
            whole = whole.common(extent if other == motion else _carry_extent(extent, other, motion, 1e-12))
        return whole


def _carry_extent(extent: Extent, motion: Motion, back: Motion, nothing: float = 0.0) -> Extent:
    """A box around an extent after a motion and back through another, widened by the rounding of floats.

    nothing: entries of the motion up to here are taken for what rounding left of none.
    """
    matrix = matmul_rows(back.inverse_matrix, motion.matrix)
    far = np.abs(back.inverse_matrix[:3, :3]) @ np.abs(motion.matrix[:3, 3]) + np.abs(back.inverse_matrix[:3, 3])
    linear = np.where(np.abs(matrix[:3, :3]) < nothing, 0.0, matrix[:3, :3])
    low = np.array([-math.inf if end is None else float(end) for end in extent.low])
    high = np.array([math.inf if end is None else float(end) for end in extent.high])
    lows: list[ExtentEnd] = []
    highs: list[ExtentEnd] = []
    for row, shift, lost in zip(linear, matrix[:3, 3], 2.0**-48 * far, strict=True):  # of shifts that cancel
        used = row != 0
        ends = np.stack([row[used] * low[used], row[used] * high[used]])
        size = 1e-9 * (np.abs(ends).max(initial=0.0) + abs(shift)) + lost
        lows.append(_end(ends.min(axis=0).sum() + shift - size))
        highs.append(_end(ends.max(axis=0).sum() + shift + size))
    return Extent((lows[0], lows[1], lows[2]), (highs[0], highs[1], highs[2]))


def _end(value: float) -> ExtentEnd:
    return Fraction(value) if math.isfinite(value) else None
