"""The closed cone and frustum."""

from __future__ import annotations

from dataclasses import dataclass
from operator import sub
from typing import Any

from . import exact as ex
from .axis import axis_frame, check_axis, exact_length
from .base import PrimitiveSolid
from .cells import PLAIN_UV, UV, Cell, Face, around_z, flat
from .motion import Motion
from .rounded import hypot, larger
from .support import sum_up
from .surface import PlaneSurface, QuadricSurface
from .validate import nonnegative, vector
from .vector import Vector, VectorLike


@dataclass(frozen=True)
class Cone(PrimitiveSolid):
    """Closed circular cone or frustum between two points of its axis; equal radii make a cylinder.

    Own frame: origin at `start`, z along the axis, x as for `Cylinder` without a reference:
    x² + y² <= (r0 + m z)², 0 <= z <= h, with r0 = start_radius, r1 = end_radius, m = (r1 - r0) / h.
    The surface is kept about the end with the smaller radius r, as x² + y² - m² z² - 2 m r z - r² <= 0:
    there all terms of the radius have one sign, so that neither the nearly cylindrical nor the nearly
    pointed cone loses digits.

    Faces: 0 side, 1 start cap, 2 end cap. A pointed end has no cap: its plane only selects the nappe.
    uv: (angle / 360, height in [0, 1]) on the side, (x, y) / radius on the caps.
    Source: the graphics textbook (KONYS).
    """

    start: VectorLike
    end: VectorLike
    start_radius: float
    end_radius: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "start", vector("Cone", "start", self.start))
        object.__setattr__(self, "end", vector("Cone", "end", self.end))
        object.__setattr__(self, "start_radius", nonnegative("Cone", "start_radius", self.start_radius))
        object.__setattr__(self, "end_radius", nonnegative("Cone", "end_radius", self.end_radius))
        check_axis("Cone", self.start, self.end)
        if self.start_radius == self.end_radius == 0:
            raise ValueError("Cone: start_radius and end_radius must not both be 0, got 0.0 and 0.0")

    @property
    def length(self) -> float:
        return hypot(*map(sub, self.end, self.start))

    @property
    def placement(self) -> Motion:
        return axis_frame(self.start, self.end, None)

    def tree(self) -> Cell:
        height = exact_length(self.start, self.end)
        bottom = PlaneSurface((0.0, 0.0, -1.0), 0.0)
        top = PlaneSurface((0.0, 0.0, 1.0), height, (0.0, 0.0, height))
        return Cell(
            (
                Face(self._side(height), 0, around_z(0.0, ex.rounded(height))),
                Face(bottom, 1, _cap_uv(self.start_radius)),
                Face(top, 2, _cap_uv(self.end_radius)),
            )
        )

    def _side(self, height: Any) -> QuadricSurface:
        """The cone about the center of its narrower end."""
        growth = ex.rational(self.end_radius) - ex.rational(self.start_radius)
        radius, z = (self.start_radius, 0.0) if growth >= 0 else (self.end_radius, height)
        square = ex.rational(radius) ** 2
        if growth == 0:
            return QuadricSurface((1.0, 1.0, 0.0), constant=square)
        slope = ex.exact(growth) / height
        return QuadricSurface((1.0, 1.0, -slope * slope), (0.0, 0.0, -slope * radius), square, anchor=(0.0, 0.0, z))

    def support(self, direction: Vector) -> float:
        across = hypot(direction[0], direction[1])
        start = across * self.start_radius
        return larger(start, sum_up((direction[2] * self.length, across * self.end_radius)))


def _cap_uv(radius: float) -> UV:
    return flat((radius, 0, 0), (0, radius, 0)) if radius > 0 else PLAIN_UV
