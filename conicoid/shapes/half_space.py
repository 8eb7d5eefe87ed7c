"""The half-space."""

from __future__ import annotations

import math
from dataclasses import dataclass

from .base import PrimitiveSolid
from .cells import Cell, Face
from .motion import Motion
from .planar import half_space_bounds, plane_through, plane_uv
from .support import along_normal
from .surface import PlaneSurface
from .validate import number, vector
from .vector import Box, Vector, VectorLike


@dataclass(frozen=True)
class HalfSpace(PrimitiveSolid):
    """normal·x <= offset, as written: the normal is not rescaled.

    Face 0. uv: Cartesian coordinates on the plane about the foot of the perpendicular from the origin;
    u points to the coordinate axis that is least along the normal, v = normal × u.
    Source: the ray tracing notes, "ray and plane".
    """

    normal: VectorLike
    offset: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "normal", vector("HalfSpace", "normal", self.normal, nonzero=True))
        object.__setattr__(self, "offset", number("HalfSpace", "offset", self.offset))

    @property
    def surface(self) -> PlaneSurface:
        return plane_through(self.normal, self.offset)

    def tree(self) -> Cell:
        surface = self.surface
        return Cell((Face(surface, 0, plane_uv(surface)),))

    def support(self, direction: Vector) -> float:
        multiple = along_normal(self.normal, direction)
        return math.inf if multiple is None or multiple < 0 else float(multiple * self.offset)

    def bounds_under(self, outer: Motion) -> Box:
        """Finite along the normal, if that is an axis after the motion."""
        return half_space_bounds(self.surface.moved(self.under(outer)), above=False)

    def outside_bounds_under(self, outer: Motion) -> Box:
        """The other side of the plane."""
        return half_space_bounds(self.surface.moved(self.under(outer)), below=False)
