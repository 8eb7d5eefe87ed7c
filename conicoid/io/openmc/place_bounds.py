"""Bounds of a place in the hierarchy of universes: the regions of all cells around it, and lattice elements.

`PlaceBounds` groups the parts of these regions by the motion that takes them to the world. `AxialMotion` recognises
rotations about a line along an axis: planes across this line and surfaces of revolution about it are the same before
and after such a rotation. A part of this kind can be moved to the group of the rotated content, where it needs no
motion of its own and where fractions show how it lies to the other parts.
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
from .region import Conjunction, RegionPart, SurfaceSide, pair_cost
from .surfaces import ConeSurface, FlatSurface, RoundSurface, Surface


@dataclass(frozen=True)
class AxialMotion:
    """A motion x ↦ A x + shift where A leaves the coordinate along `axis` as it is and mixes the other two only."""

    axis: int
    shift: Point
    rigid: bool
    """Whether the motion preserves distances."""

    @classmethod
    def of(cls, motion: Motion) -> AxialMotion | None:
        """Return a motion as an `AxialMotion`, or None if it is none or its shift is no exact fraction."""
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
        """Return the part that the motion takes to `part`; None if it is not exact in fractions."""
        if isinstance(part, SurfaceSide):
            surface = self._surface(part.surface)
            return None if surface is None else SurfaceSide(surface, part.positive)
        parts = [self.undone(piece) for piece in part.parts]
        exact = tuple(piece for piece in parts if piece is not None)
        return type(part)(exact) if len(exact) == len(parts) else None

    def _surface(self, surface: Surface) -> Surface | None:
        """Return the surface that the motion takes to `surface`: a plane across the axis, or round about it."""
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
        """Return the point that the motion takes to `point` if that lies on the axis of rotation, else None."""
        across = (point[i] == self.shift[i] for i in range(3) if i != self.axis)
        if not (self.rigid and all(across)):
            return None
        x, y, z = (point[i] - self.shift[i] if i == self.axis else Fraction(0) for i in range(3))
        return x, y, z


# Bounds of a place


@dataclass(frozen=True, slots=True)
class PlaceBounds:
    """The intersection of groups of parts; each group stands before one motion to the world."""

    groups: tuple[tuple[Motion, Conjunction], ...] = ()

    def and_(self, motion: Motion, parts: Iterable[RegionPart], extent: Extent = UNBOUNDED) -> PlaceBounds | None:
        """Return the bounds with further parts before `motion`, the innermost motion; None if nothing is left.

        Parts of other groups that contain the whole box around the new group are left out. This stays correct: nothing
        is left out of the new group because of them, and nothing is added to them once another motion is innermost.
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
        """Return the bounds within a cell that applies `entry` to its content; `after` is `entry`, then `before`.

        Parts that the rotation leaves as they are move from the group of `before`, so far the innermost motion, to the
        group of `after`, which the parts of the content will join.
        """
        about = AxialMotion.of(entry)
        groups = dict(self.groups)
        outside = groups.pop(before, None)
        if about is None or outside is None:
            return self
        pairs = [(part, about.undone(part)) for part in outside.parts]
        inside = Conjunction().and_(turned for _, turned in pairs if turned is not None)
        stay = Conjunction().and_(part for part, turned in pairs if turned is None)
        if inside is None or stay is None:  # only now fractions show that nothing is left
            return self
        if stay.parts:
            groups[before] = stay
        return PlaceBounds(tuple((groups | {after: inside}).items()))

    def moved(self, shift: Point) -> PlaceBounds:
        """Return the bounds translated by `shift` before their motions."""
        return PlaceBounds(tuple((motion, conjunction.moved(shift)) for motion, conjunction in self.groups))

    def is_before(self, motion: Motion) -> bool:
        """Return True if all parts stand before this motion."""
        return all(other == motion for other, _ in self.groups)

    def cost(self, motion: Motion, parts: Iterable[RegionPart]) -> int:
        """Return a bound on the sides and pairs of sides that `and_` compares."""
        others = sum(conjunction.size for other, conjunction in self.groups if other != motion)
        return others + pair_cost(dict(self.groups).get(motion, Conjunction()), parts)

    def extent_before(self, motion: Motion) -> Extent:
        """Return a box around the bounds, in the coordinates before a motion."""
        whole = UNBOUNDED
        for other, conjunction in self.groups:
            extent = conjunction.extent
            whole = whole.common(extent if other == motion else _carry_extent(extent, other, motion, 1e-12))
        return whole


def _carry_extent(extent: Extent, motion: Motion, back: Motion, nothing: float = 0.0) -> Extent:
    """Return a box around an extent after `motion` and the inverse of `back`, widened by a bound on rounding.

    Entries of the matrix below `nothing` in size are taken as zeros that rounding has changed.
    """
    matrix = matmul_rows(back.inverse_matrix, motion.matrix)
    far = np.abs(back.inverse_matrix[:3, :3]) @ np.abs(motion.matrix[:3, 3]) + np.abs(back.inverse_matrix[:3, 3])
    linear = np.where(np.abs(matrix[:3, :3]) < nothing, 0.0, matrix[:3, :3])
    low = np.array([-math.inf if end is None else float(end) for end in extent.low])
    high = np.array([math.inf if end is None else float(end) for end in extent.high])
    lows: list[ExtentEnd] = []
    highs: list[ExtentEnd] = []
    # `lost` bounds the rounding of large shifts that cancel in the product.
    for row, shift, lost in zip(linear, matrix[:3, 3], 2.0**-48 * far, strict=True):
        used = row != 0
        ends = np.stack([row[used] * low[used], row[used] * high[used]])
        size = 1e-9 * (np.abs(ends).max(initial=0.0) + abs(shift)) + lost
        lows.append(_end(ends.min(axis=0).sum() + shift - size))
        highs.append(_end(ends.max(axis=0).sum() + shift + size))
    return Extent((lows[0], lows[1], lows[2]), (highs[0], highs[1], highs[2]))


def _end(value: float) -> ExtentEnd:
    return Fraction(value) if math.isfinite(value) else None
