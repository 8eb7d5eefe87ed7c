"""`Polyhedron`, the convex polyhedron, bounded or not."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

import numpy as np

from .._util.arrays import BoxEnds, Vector
from .._util.validation import check_numbers, check_vector, check_vectors
from .bounds.aabb import enclose_boxes
from .bounds.intersection import BoundingSurfaces
from .bounds.linear_program import half_spaces_bounds, integer_row, integer_support, round_fraction_up
from .bounds.support import half_space_bounds, plane_through, plane_uv
from .cell import Cell, Face
from .shape import PrimitiveSolid
from .surface import PlaneSurface
from .transform import Motion

_DIRECTION_ROUNDING = 2.0**-52
"""A bound of the rounding of a direction and of sums with it."""


@dataclass(frozen=True)
class Polyhedron(PrimitiveSolid):
    """The points with every normals[i]·x <= offsets[i], as written. It may be unbounded or empty.

    Face i belongs to normals[i]. uv: Cartesian coordinates on its plane about a point near the solid;
    u points to the coordinate axis that is least along the normal, v = normal × u.
    """

    normals: tuple[Vector, ...]
    offsets: tuple[float, ...]

    def __post_init__(self) -> None:
        normals = check_vectors("Polyhedron", "normals", self.normals, 1)
        for i, normal in enumerate(normals):
            check_vector("Polyhedron", f"normals[{i}]", normal, nonzero=True)
        object.__setattr__(self, "normals", normals)
        object.__setattr__(self, "offsets", check_numbers("Polyhedron", "offsets", self.offsets, len(normals)))

    @cached_property
    def _rows(self) -> list[list[int]]:
        """The half-spaces as rows of four integers."""
        return [integer_row((*normal, offset)) for normal, offset in zip(self.normals, self.offsets, strict=True)]

    @cached_property
    def _own_bounds(self) -> BoxEnds:
        """The bounds in the solid's own frame, before any motion."""
        return half_spaces_bounds([PlaneSurface(n, d) for n, d in zip(self.normals, self.offsets, strict=True)])

    @property
    def surfaces(self) -> list[PlaneSurface]:
        """The planes, anchored near the solid."""
        low, high = self._own_bounds
        if (low > high).any():
            low = high = np.zeros(3)
        near = [_middle(a, b) for a, b in zip(low.tolist(), high.tolist(), strict=True)]
        return [plane_through(n, d, near) for n, d in zip(self.normals, self.offsets, strict=True)]

    def tree(self) -> Cell:
        return Cell(tuple(Face(surface, i, plane_uv(surface)) for i, surface in enumerate(self.surfaces)))

    def support(self, direction: Vector) -> float:
        """Return the support: exact along an axis, otherwise raised by the effect of the direction's rounding."""
        support = integer_support(self._rows, [Fraction(u) for u in direction])
        if sum(map(bool, direction)) < 2 or isinstance(support, float):
            return round_fraction_up(support)
        reach = np.maximum(abs(self._own_bounds[0]), abs(self._own_bounds[1]))
        terms = [abs(u) * r for u, r in zip(direction, reach.tolist(), strict=True) if u]
        return round_fraction_up(support) + _DIRECTION_ROUNDING * math.fsum(terms)

    def bounds_under(self, outer: Motion) -> BoxEnds:
        """Return the bounds after `outer`.

        The planes of an unbounded solid are moved exactly, so that an end is finite if a face turns to an axis.
        """
        motion = self.under(outer)
        if motion.is_identity:
            return self._own_bounds[0].copy(), self._own_bounds[1].copy()
        if np.isfinite(self._own_bounds).all():
            return super().bounds_under(outer)
        return half_spaces_bounds([surface.moved(motion) for surface in self.surfaces])

    def outside_bounds_under(self, outer: Motion) -> BoxEnds:
        """Return the box around the half-spaces beyond the faces."""
        motion = self.under(outer)
        return enclose_boxes([half_space_bounds(surface.moved(motion), below=False) for surface in self.surfaces])

    def bounding_surfaces(self, outer: Motion, inside: bool) -> BoundingSurfaces:
        if not inside:
            return super().bounding_surfaces(outer, inside)
        motion = self.under(outer)
        return [surface.moved(motion) for surface in self.surfaces]


def _middle(low: float, high: float) -> float:
    """Return a finite number between two ends; each of them may be infinite."""
    ends = [end for end in (low, high) if math.isfinite(end)]
    return sum(end / len(ends) for end in ends)
