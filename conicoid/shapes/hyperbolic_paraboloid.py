"""The hyperbolic paraboloid, the saddle."""

from __future__ import annotations

import math
from dataclasses import dataclass

from .box import Box
from .surface import QuadricSurface
from .validate import positive
from .vector import Vector
from .within import WithinBox


@dataclass(frozen=True)
class HyperbolicParaboloid(WithinBox):
    """A x² - E y² - z <= 0, cut by the box `within`: what lies above the saddle z = A x² - E y².

    Faces: 0 the saddle, 1 to 6 the faces of the box. uv on the saddle: (x, y), scaled over the box to [0, 1];
    on the others as on the box.
    Source: the ray tracing notes, canonical quadric 2b.
    """

    A: float
    E: float
    within: Box | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "A", positive("HyperbolicParaboloid", "A", self.A))
        object.__setattr__(self, "E", positive("HyperbolicParaboloid", "E", self.E))
        self.check_within()

    @property
    def surface(self) -> QuadricSurface:
        return QuadricSurface((self.A, -self.E, 0.0), (0.0, 0.0, -0.5), 0.0)

    @property
    def uv_axes(self) -> tuple[int, int]:
        return 0, 1

    def unbounded_support(self, direction: Vector) -> float:
        """Its convex hull is all of space."""
        return math.inf if any(direction) else 0.0
