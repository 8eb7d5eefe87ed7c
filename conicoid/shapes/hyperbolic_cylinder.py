"""The hyperbolic cylinder."""

from __future__ import annotations

import math
from dataclasses import dataclass

from .box import Box
from .surface import QuadricSurface
from .validate import positive
from .vector import Vector
from .within import WithinBox


@dataclass(frozen=True)
class HyperbolicCylinder(WithinBox):
    """A x² - E y² <= 1, cut by the box `within`: what lies between the two walls x = ±sqrt((1 + E y²) / A).

    Faces: 0 both walls, 1 to 6 the faces of the box. uv on the walls: (y, z), scaled over the box to [0, 1];
    on the others as on the box.
    Source: the ray tracing notes, canonical quadric 5b.
    """

    A: float
    E: float
    within: Box | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "A", positive("HyperbolicCylinder", "A", self.A))
        object.__setattr__(self, "E", positive("HyperbolicCylinder", "E", self.E))
        self.check_within()

    @property
    def surface(self) -> QuadricSurface:
        return QuadricSurface((self.A, -self.E, 0.0), constant=1.0)

    @property
    def uv_axes(self) -> tuple[int, int]:
        return 1, 2

    def unbounded_support(self, direction: Vector) -> float:
        """Its convex hull is all of space."""
        return math.inf if any(direction) else 0.0
