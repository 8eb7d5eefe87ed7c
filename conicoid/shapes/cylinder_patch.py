"""The open side wall of a cylinder, a curved sheet."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from operator import sub

from .axis import axis_frame, check_axis
from .base import PrimitiveSheet
from .cells import All, Cell, Face, SurfaceSheet, Tree, moved_uv
from .cylinder import arc_support, check_angles, either, side_and_caps, wedge_walls
from .motion import Motion
from .rounded import hypot, larger
from .support import sum_up
from .validate import positive, vector
from .vector import Vector, VectorLike


@dataclass(frozen=True)
class CylinderPatch(PrimitiveSheet):
    """Part of the side of a cylinder of a `radius` about the axis from `start` to `end`, open at its ends and edges.

    Own frame as for `Cylinder`: x² + y² = radius², 0 <= z <= length, the angle of (x, y) from `start_angle`
    to `end_angle` (degrees, their difference in (0, 360]), zero towards `reference`, growing counter-clockwise
    about start → end. The normal points away from the axis.
    Face 0. uv: (angle / 360, height in [0, 1]).
    Source: Sasaki 2021.
    """

    start: VectorLike
    end: VectorLike
    radius: float
    start_angle: float = 0.0
    end_angle: float = 360.0
    reference: VectorLike | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "start", vector("CylinderPatch", "start", self.start))
        object.__setattr__(self, "end", vector("CylinderPatch", "end", self.end))
        object.__setattr__(self, "radius", positive("CylinderPatch", "radius", self.radius))
        check_axis("CylinderPatch", self.start, self.end)
        check_angles(self, "CylinderPatch")

    @property
    def length(self) -> float:
        return hypot(*map(sub, self.end, self.start))

    @property
    def placement(self) -> Motion:
        return axis_frame(self.start, self.end, self.reference)

    def sheet(self, motion: Motion) -> SurfaceSheet:
        side, *ends = side_and_caps(self.radius, self.start, self.end)
        walls = wedge_walls(self.start_angle, self.end_angle, self.radius, self.length)
        between, wedge = (tuple(_moved(face, motion) for face in faces) for faces in (ends, walls))
        clip: Tree = Cell(between + wedge)
        if self.end_angle - self.start_angle > 180 and wedge:
            clip = All((Cell(between), either(wedge)))
        return SurfaceSheet(side.surface.moved(motion), clip, uv=moved_uv(side.uv, motion))

    def support(self, direction: Vector) -> float:
        across = arc_support(self.radius, self.start_angle, self.end_angle, direction)
        return sum_up((larger(0.0, direction[2] * self.length), across))


def _moved(face: Face, motion: Motion) -> Face:
    return dataclasses.replace(face, surface=face.surface.moved(motion))
