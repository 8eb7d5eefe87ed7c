"""The closed cylinder and its wedge."""

from __future__ import annotations

from dataclasses import dataclass
from operator import sub
from typing import Any

from . import exact as ex
from .axis import axis_frame, check_axis, difference, exact_length
from .base import PrimitiveSolid
from .cells import All, Any_, Cell, Face, Tree, around_z, flat
from .degrees import turn
from .motion import Motion
from .rounded import hypot, larger, sin_cos_degrees
from .support import sum_up
from .surface import PlaneSurface, QuadricSurface
from .validate import positive, vector
from .vector import Vector, VectorLike


@dataclass(frozen=True)
class Cylinder(PrimitiveSolid):
    """Closed circular cylinder between two points of its axis, any direction; a wedge with angles.

    Own frame (Sasaki 2021): origin at `start`, z along the axis, x towards `reference` projected
    across the axis: x² + y² <= radius², 0 <= z <= length, and the angle of (x, y), counter-clockwise
    about start → end, from `start_angle` to `end_angle` (degrees, their difference, as float64, in (0, 360]).
    Given angles need a reference; without angles x is the coordinate axis least along the axis.

    Faces: 0 side, 1 start cap, 2 end cap, 3 wall at start_angle, 4 wall at end_angle (half a turn
    has one plane for both walls: face 3). uv: (angle / 360, height in [0, 1]) on the side,
    (x, y) / radius on the caps, (distance from the axis / radius, height in [0, 1]) on the walls.
    Sources: Sasaki 2021 and the graphics textbook (CILIND).
    """

    start: VectorLike
    end: VectorLike
    radius: float
    start_angle: float = 0.0
    end_angle: float = 360.0
    reference: VectorLike | None = None

    def __post_init__(self) -> None:
        owner = type(self).__name__
        object.__setattr__(self, "start", vector(owner, "start", self.start))
        object.__setattr__(self, "end", vector(owner, "end", self.end))
        object.__setattr__(self, "radius", positive(owner, "radius", self.radius))
        check_axis(owner, self.start, self.end)
        check_angles(self, owner)

    @property
    def length(self) -> float:
        return hypot(*map(sub, self.end, self.start))

    @property
    def placement(self) -> Motion:
        return axis_frame(self.start, self.end, self.reference)

    def tree(self) -> Tree:
        faces = side_and_caps(self.radius, self.start, self.end)
        walls = wedge_walls(self.start_angle, self.end_angle, self.radius, self.length)
        return cut_open(faces, walls, self.end_angle - self.start_angle)

    def support(self, direction: Vector) -> float:
        across = arc_support(self.radius, self.start_angle, self.end_angle, direction)
        if self.end_angle - self.start_angle < 360:
            across = larger(0.0, across)
        return sum_up((larger(0.0, direction[2] * self.length), across))


def check_angles(shape: Any, owner: str) -> None:
    """Check and normalise start_angle, end_angle and reference of a frozen shape."""
    first, last = turn(owner, shape.start_angle, shape.end_angle)
    reference = shape.reference
    if reference is not None:
        reference = vector(owner, "reference", reference)
        axis, towards = difference(shape.start, shape.end), difference(shape.start, reference)
        if not any(ex.cross(axis, towards)):
            raise ValueError(f"{owner}: reference must lie off the axis, got {reference}")
    elif last - first < 360:
        two = first != 0 and last == 360 and hasattr(shape, "radius")
        hint = "; of two radii it is a Cone(start, end, start_radius, end_radius)" if two else ""
        raise ValueError(f"{owner}: reference must be given with angles: it is where angle 0 points{hint}")
    object.__setattr__(shape, "start_angle", first)
    object.__setattr__(shape, "end_angle", last)
    object.__setattr__(shape, "reference", reference)


def side_and_caps(radius: float, start: Vector, end: Vector) -> tuple[Face, Face, Face]:
    length = exact_length(start, end)
    side = QuadricSurface(squares=(1.0, 1.0, 0.0), constant=ex.rational(radius) ** 2)
    cap_uv = flat((radius, 0, 0), (0, radius, 0))
    bottom = PlaneSurface((0.0, 0.0, -1.0), 0.0)
    top = PlaneSurface((0.0, 0.0, 1.0), length, (0.0, 0.0, length))
    return (
        Face(side, 0, around_z(0.0, ex.rounded(length))),
        Face(bottom, 1, cap_uv),
        Face(top, 2, cap_uv),
    )


def wedge_walls(start_angle: float, end_angle: float, radius: float, length: float) -> tuple[Face, ...]:
    """The half-spaces of a wedge, faces 3 and 4; none for a full turn, one for half a turn."""
    turn = end_angle - start_angle
    if turn >= 360:
        return ()
    walls = []
    for number_, angle, sense in ((3, start_angle, 1), (4, end_angle, -1)):
        s, c = ex.sin_cos_degrees(angle)
        uv = flat((radius * ex.rounded(c), radius * ex.rounded(s), 0), (0, 0, length))
        walls.append(Face(PlaneSurface((sense * s, -sense * c, ex.ZERO), ex.ZERO), number_, uv))
    return tuple(walls[:1] if 180 <= turn <= 180 else walls)  # by its value, which may be one that moves


def cut_open(faces: tuple[Face, ...], walls: tuple[Face, ...], turn: float, *more: Tree) -> Tree:
    """A cell less what the walls of a wedge leave out, and in everything else that is given."""
    parts = (Cell(faces + walls), *more) if turn <= 180 or not walls else (Cell(faces), either(walls), *more)
    return parts[0] if len(parts) == 1 else All(parts)


def either(walls: tuple[Face, ...]) -> Any_:
    """Inside at least one of the walls: a wedge over 180°."""
    return Any_(tuple(Cell((wall,)) for wall in walls))


def arc_support(radius: float, start_angle: float, end_angle: float, direction: Vector) -> float:
    """sup of u·p over a circular arc about the origin of the xy plane."""
    x, y, _ = direction
    if end_angle - start_angle == 360:
        return radius * hypot(x, y)
    (s, c), (t, d) = sin_cos_degrees(start_angle), sin_cos_degrees(end_angle)
    after_start, before_end = c * y >= s * x, t * x >= d * y
    if (after_start and before_end) if end_angle - start_angle <= 180 else (after_start or before_end):
        return radius * hypot(x, y)
    return larger(sum_up((radius * x * c, radius * y * s)), sum_up((radius * x * d, radius * y * t)))
