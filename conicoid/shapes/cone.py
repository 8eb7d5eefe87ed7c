"""The closed cone and frustum."""

from __future__ import annotations

from dataclasses import dataclass
from operator import sub

from . import exact as ex
from .axis import axis_frame, check_axis, exact_length
from .base import PrimitiveSolid
from .cells import PLAIN_UV, UV, Face, Tree, around_z, flat
from .cylinder import arc_support, check_angles, cut_open, wedge_walls
from .frustum import frustum_side
from .motion import Motion
from .rounded import hypot, larger
from .support import sum_up
from .surface import PlaneSurface
from .validate import nonnegative, vector
from .vector import Vector, VectorLike


@dataclass(frozen=True)
class Cone(PrimitiveSolid):
    """Closed circular cone or frustum between two points of its axis; equal radii make a cylinder; a wedge with angles.

    Own frame: origin at `start`, z along the axis, x towards `reference` as for `Cylinder`:
    x² + y² <= (r0 + m z)², 0 <= z <= h, with r0 = start_radius, r1 = end_radius, m = (r1 - r0) / h, and the
    angle of (x, y) from `start_angle` to `end_angle`, in degrees, as for `Cylinder`: given angles need a reference.
    Hollow ones are `Polycone`, or ``Cone - Cone``.

    Faces: 0 side, 1 start cap, 2 end cap, 3 wall at start_angle, 4 wall at end_angle (half a turn has one plane for
    both walls: face 3). A pointed end has no cap: its plane only selects the nappe.
    uv: (angle / 360, height in [0, 1]) on the side, (x, y) / radius on the caps, (distance from the axis / the larger
    radius, height in [0, 1]) on the walls.
    Source: the graphics textbook (KONYS); Sasaki 2021 for the angles.
    """

    start: VectorLike
    end: VectorLike
    start_radius: float
    end_radius: float
    start_angle: float = 0.0
    end_angle: float = 360.0
    reference: VectorLike | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "start", vector("Cone", "start", self.start))
        object.__setattr__(self, "end", vector("Cone", "end", self.end))
        object.__setattr__(self, "start_radius", nonnegative("Cone", "start_radius", self.start_radius))
        object.__setattr__(self, "end_radius", nonnegative("Cone", "end_radius", self.end_radius))
        check_axis("Cone", self.start, self.end)
        if self.start_radius == self.end_radius == 0:
            raise ValueError("Cone: start_radius and end_radius must not both be 0, got 0.0 and 0.0")
        check_angles(self, "Cone")

    @property
    def length(self) -> float:
        return hypot(*map(sub, self.end, self.start))

    @property
    def placement(self) -> Motion:
        return axis_frame(self.start, self.end, self.reference)

    def tree(self) -> Tree:
        height = exact_length(self.start, self.end)
        side = frustum_side(ex.rational(self.start_radius), ex.ZERO, ex.rational(self.end_radius), height)
        bottom = PlaneSurface((0.0, 0.0, -1.0), 0.0)
        top = PlaneSurface((0.0, 0.0, 1.0), height, (0.0, 0.0, height))
        faces = (
            Face(side, 0, around_z(0.0, ex.rounded(height))),
            Face(bottom, 1, _cap_uv(self.start_radius)),
            Face(top, 2, _cap_uv(self.end_radius)),
        )
        widest = larger(self.start_radius, self.end_radius)
        walls = wedge_walls(self.start_angle, self.end_angle, widest, self.length)
        return cut_open(faces, walls, self.end_angle - self.start_angle)

    def support(self, direction: Vector) -> float:
        start, end = (
            arc_support(radius, self.start_angle, self.end_angle, direction)
            for radius in (self.start_radius, self.end_radius)
        )
        if self.end_angle - self.start_angle < 360:
            start, end = larger(0.0, start), larger(0.0, end)
        return larger(start, sum_up((direction[2] * self.length, end)))


def _cap_uv(radius: float) -> UV:
    return flat((radius, 0, 0), (0, radius, 0)) if radius > 0 else PLAIN_UV
