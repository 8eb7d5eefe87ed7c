"""What a turn about a line along an axis leaves as it is: planes across it, and what is round about it.

Such a part of a region is the same part of what is turned. Said of that, it needs no motion of its own, and fractions
show how it lies to other parts that are turned.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction

from ...shapes.motion import Motion
from ...shapes.number import fraction, is_rounded
from .narrowing import Part, Side
from .placement import Point
from .surfaces import ConeSurface, FlatSurface, RoundSurface, Surface


@dataclass(frozen=True)
class AboutAxis:
    """x ↦ A x + shift, where A keeps what is along an axis, and what is across it apart from that."""

    axis: int
    shift: Point
    rigid: bool
    """Are all distances kept?"""

    @classmethod
    def of(cls, motion: Motion) -> AboutAxis | None:
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

    def undone(self, part: Part) -> Part | None:
        """The part that the motion takes to a given one, if fractions say it."""
        if isinstance(part, Side):
            surface = self._surface(part.surface)
            return None if surface is None else Side(surface, part.positive)
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
