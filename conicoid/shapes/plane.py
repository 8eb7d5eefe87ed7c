"""The plane, an unbounded sheet."""

from __future__ import annotations

import math
from dataclasses import dataclass

from .base import PrimitiveSheet
from .cells import SurfaceSheet, moved_uv
from .motion import Motion
from .planar import half_space_bounds, plane_through, plane_uv
from .support import along_normal
from .surface import PlaneSurface
from .validate import flag, number, vector
from .vector import Box, Vector, VectorLike


@dataclass(frozen=True)
class Plane(PrimitiveSheet):
    """normal·x = offset. With `one_sided` it is seen only by rays with normal·direction < 0.

    Face 0. uv: Cartesian coordinates on the plane about the foot of the perpendicular from the origin;
    u points to the coordinate axis that is least along the normal, v = normal × u.
    Source: the ray tracing notes, "ray and plane" (their D is -offset).
    """

    normal: VectorLike
    offset: float
    one_sided: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "normal", vector("Plane", "normal", self.normal, nonzero=True))
        object.__setattr__(self, "offset", number("Plane", "offset", self.offset))
        object.__setattr__(self, "one_sided", flag("Plane", "one_sided", self.one_sided))

    @property
    def surface(self) -> PlaneSurface:
        return plane_through(self.normal, self.offset)

    def sheet(self, motion: Motion) -> SurfaceSheet:
        surface = self.surface
        uv = moved_uv(plane_uv(surface), motion)
        return SurfaceSheet(surface.moved(motion), one_sided=self.one_sided, uv=uv)

    def support(self, direction: Vector) -> float:
        multiple = along_normal(self.normal, direction)
        return math.inf if multiple is None else float(multiple * self.offset)

    def bounds_under(self, outer: Motion) -> Box:
        """Flat along the normal if that is an axis after the motion, infinite otherwise."""
        return half_space_bounds(self.surface.moved(self.under(outer)))
