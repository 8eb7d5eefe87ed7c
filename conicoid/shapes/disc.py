"""The disc, a round sheet."""

from __future__ import annotations

from dataclasses import dataclass

from . import exact as ex
from .base import PrimitiveSheet
from .cells import Cell, Face, SurfaceSheet, flat, moved_uv
from .motion import Frame, Motion
from .rounded import hypot
from .surface import PlaneSurface, QuadricSurface
from .validate import positive, vector
from .vector import Vector, VectorLike


@dataclass(frozen=True)
class Disc(PrimitiveSheet):
    """The part of the plane through `center` across `normal` within `radius` of the center.

    Own frame: origin at the center, z along the normal, x towards the coordinate axis least along it:
    z = 0, x² + y² <= radius². Face 0. uv: (x, y) / radius.
    """

    center: VectorLike
    normal: VectorLike
    radius: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "center", vector("Disc", "center", self.center))
        object.__setattr__(self, "normal", vector("Disc", "normal", self.normal, nonzero=True))
        object.__setattr__(self, "radius", positive("Disc", "radius", self.radius))

    @property
    def placement(self) -> Motion:
        return Motion((Frame(self.center, self.normal),))

    def sheet(self, motion: Motion) -> SurfaceSheet:
        ball = QuadricSurface((1.0, 1.0, 1.0), constant=ex.rational(self.radius) ** 2)
        uv = flat((self.radius, 0.0, 0.0), (0.0, self.radius, 0.0))
        return SurfaceSheet(
            PlaneSurface((0.0, 0.0, 1.0), 0.0).moved(motion),
            clip=Cell((Face(ball.moved(motion), 0),)),
            uv=moved_uv(uv, motion),
        )

    def support(self, direction: Vector) -> float:
        return self.radius * hypot(direction[0], direction[1])
