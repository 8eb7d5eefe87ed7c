"""The parabolic cylinder."""

from __future__ import annotations

import math
from dataclasses import dataclass

from .box import Box
from .surface import QuadricSurface
from .validate import positive
from .vector import Vector
from .within import WithinBox


@dataclass(frozen=True)
class ParabolicCylinder(WithinBox):
    """x² - 2 G y <= 0, cut by the box `within`: a trough along z, open towards y, its bottom the z axis.

    Faces: 0 the trough, 1 to 6 the faces of the box. uv on the trough: (x, z), scaled over the box to [0, 1];
    on the others as on the box.
    Source: the ray tracing notes, canonical quadric 5c.
    """

    G: float
    within: Box | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "G", positive("ParabolicCylinder", "G", self.G))
        self.check_within()

    @property
    def surface(self) -> QuadricSurface:
        return QuadricSurface((1.0, 0.0, 0.0), (0.0, -self.G, 0.0), 0.0)

    @property
    def uv_axes(self) -> tuple[int, int]:
        return 0, 2

    def unbounded_support(self, direction: Vector) -> float:
        """u_x x + u_y y is largest at x = -G u_x / u_y: -G u_x² / (2 u_y), finite only for u_y < 0, u_z = 0."""
        x, y, z = direction
        if z != 0 or y > 0 or (y == 0 and x != 0):
            return math.inf
        return -self.G * x * x / (2 * y) if y else 0.0
