"""The tube: a cylinder with a bore about the same axis."""

from __future__ import annotations

from dataclasses import dataclass, replace
from operator import sub

from . import exact as ex
from .axis import axis_frame, check_axis
from .base import PrimitiveSolid
from .cells import Cell, Tree
from .cylinder import arc_support, check_angles, cut_open, side_and_caps, wedge_walls
from .motion import Motion
from .rounded import hypot, larger
from .support import sum_up
from .surface import QuadricSurface
from .validate import nonnegative, positive, vector
from .vector import Vector, VectorLike


@dataclass(frozen=True)
class Tube(PrimitiveSolid):
    """Closed circular tube between two points of its axis, any direction; a part of a turn with angles.

    Own frame: origin at `start`, z along the axis, x towards `reference`, all as for `Cylinder`:
    inner_radius² <= x² + y² <= outer_radius², 0 <= z <= length, and the angle of (x, y) from `start_angle` to
    `end_angle`, in degrees. `inner_radius` may be 0; `outer_radius` is larger. Given angles need a reference.

    Faces: 0 outer side, 1 start cap, 2 end cap, 3 wall at start_angle, 4 wall at end_angle (half a turn has one plane
    for both: face 3), 5 inner side. uv: (angle / 360, height in [0, 1]) on the sides, (x, y) / outer_radius on the
    caps, (distance from the axis / outer_radius, height in [0, 1]) on the walls.
    Source: the tubes of detector simulation (Geant4, "Book for Application Developers", solids).
    """

    start: VectorLike
    end: VectorLike
    inner_radius: float
    outer_radius: float
    start_angle: float = 0.0
    end_angle: float = 360.0
    reference: VectorLike | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "start", vector("Tube", "start", self.start))
        object.__setattr__(self, "end", vector("Tube", "end", self.end))
        object.__setattr__(self, "inner_radius", nonnegative("Tube", "inner_radius", self.inner_radius))
        object.__setattr__(self, "outer_radius", positive("Tube", "outer_radius", self.outer_radius))
        check_inner("Tube", "outer_radius", self.inner_radius, self.outer_radius)
        check_axis("Tube", self.start, self.end)
        check_angles(self, "Tube")

    @property
    def length(self) -> float:
        """From start to end."""
        return hypot(*map(sub, self.end, self.start))

    @property
    def placement(self) -> Motion:
        return axis_frame(self.start, self.end, self.reference)

    def tree(self) -> Tree:
        side, *caps = side_and_caps(self.outer_radius, self.start, self.end)
        walls = wedge_walls(self.start_angle, self.end_angle, self.outer_radius, self.length)
        bore: tuple[Cell, ...] = ()
        if self.inner_radius > 0:
            surface = QuadricSurface((1.0, 1.0, 0.0), constant=ex.rational(self.inner_radius) ** 2)
            bore = (Cell((replace(side, surface=surface, number=5, inside=-1),)),)
        return cut_open((side, *caps), walls, self.end_angle - self.start_angle, *bore)

    def support(self, direction: Vector) -> float:
        outer, inner = (
            arc_support(radius, self.start_angle, self.end_angle, direction)
            for radius in (self.outer_radius, self.inner_radius)
        )
        return sum_up((larger(0.0, direction[2] * self.length), larger(outer, inner)))


def check_inner(owner: str, outer_field: str, inner: float, outer: float) -> None:
    """Refuse a hollow that leaves nothing."""
    if not inner < outer:
        raise ValueError(f"{owner}: inner_radius must be < {outer_field} = {outer:g}, got {inner:g}")
