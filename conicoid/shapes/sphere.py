"""The ball."""

from __future__ import annotations

from dataclasses import dataclass

from . import exact as ex
from .base import PrimitiveSolid
from .cells import Cell, Face, around_z
from .motion import Motion, Translate
from .rounded import hypot
from .surface import QuadricSurface
from .validate import positive, vector
from .vector import Vector, VectorLike


@dataclass(frozen=True)
class Sphere(PrimitiveSolid):
    """|x - center|² <= radius², `radius` > 0. Own frame: axes of the world about the center.

    uv: (angle about z / 360, height from south to north pole in [0, 1]).  Face 0.
    Source: the ray tracing notes, "ray and sphere".
    """

    radius: float = 1.0
    center: VectorLike = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        object.__setattr__(self, "radius", positive("Sphere", "radius", self.radius))
        object.__setattr__(self, "center", vector("Sphere", "center", self.center))

    @property
    def placement(self) -> Motion:
        return Motion((Translate(self.center),))

    def tree(self) -> Cell:
        r = self.radius
        surface = QuadricSurface(squares=(1.0, 1.0, 1.0), constant=_square(r))
        return Cell((Face(surface, 0, around_z(-r, r)),))

    def support(self, direction: Vector) -> float:
        return self.radius * hypot(*direction)


def _square(x: float) -> object:
    """x² without rounding."""
    return ex.rational(x) ** 2
