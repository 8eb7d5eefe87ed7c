"""Common solids: ball, box, half-space, cylinder, cone and tube, the last three with angles if they are part of a turn.

Their helpers for axes, wedges and caps serve other shapes too.
"""

from __future__ import annotations

import functools
import math
from dataclasses import replace
from operator import sub
from typing import Any, ClassVar

from .._util.arrays import BoxEnds, Vector, VectorLike
from .._util.records import dataclass
from .._util.validation import (
    check_angle_range,
    check_direction,
    check_fields,
    check_nonnegative,
    check_number,
    check_positive,
    check_vector,
)
from ..numerics import bigfloat as ex
from ..numerics.portable_math import hypot, negative_indicator, portable_max, select_if_several, sin_cos_degrees
from ..numerics.rational import cross, dot3
from .bounds.intersection import BoundingSurfaces, BoundsKind, orient_surface
from .bounds.linear_program import integer_row
from .bounds.support import along_normal, half_space_bounds, plane_through, plane_uv, sum_up
from .cell import NO_ROW, PLAIN_UV, UV, All, Any_, Cell, Face, Tree, cartesian_uv, component_row, cylindrical_uv
from .shape import Primitive, PrimitiveSolid
from .surface import PlaneSurface, QuadricSurface
from .transform import AxisFrame, Motion, Translate


@dataclass(frozen=True)
class Sphere(PrimitiveSolid):
    """|x - center|² <= radius², `radius` > 0. Own frame: axes of the world about the center.

    uv: (angle about z / 360, height from south to north pole in [0, 1]).  Face 0.
    Source: the ray tracing notes, "ray and sphere".
    """

    radius: float = 1.0
    center: VectorLike = (0.0, 0.0, 0.0)
    bounds_kind: ClassVar[BoundsKind] = "ball"

    def __post_init__(self) -> None:
        check_fields(self, radius=check_positive, center=check_vector)

    @property
    def placement(self) -> Motion:
        return Motion((Translate(self.center),))

    def tree(self) -> Cell:
        r = self.radius
        # Squared exactly: two balls of one radius and place are one surface, however they were made
        surface = QuadricSurface(squares=(1.0, 1.0, 1.0), constant=ex.rational(r) ** 2)
        return Cell((Face(surface, 0, cylindrical_uv(-r, r)),))

    def support(self, direction: Vector) -> float:
        return self.radius * hypot(*direction)


def _refuse_lone_corner(kind: type[Box]) -> type[Box]:
    """Let `Box(corner)` raise: a size may be meant, and the box would end at the default of the other corner."""
    initialize = kind.__init__

    @functools.wraps(initialize)
    def checked(self: Box, *args: Any, **fields: Any) -> None:
        if len(args) == 1 and "high" not in fields:
            size = "a box of size (x, y, z) about the origin is Box((-x/2, -y/2, -z/2), (x/2, y/2, z/2))"
            raise TypeError(f"Box: a box is given by two corners, Box(low, high), got one; {size}")
        initialize(self, *args, **fields)

    setattr(kind, "__init__", checked)  # noqa: B010 (for types, a method is not to be set)
    return kind


@_refuse_lone_corner
@dataclass(frozen=True)
class Box(PrimitiveSolid):
    """low <= (x, y, z) <= high, its edges along the axes.

    Faces: 0 low x, 1 high x, 2 low y, 3 high y, 4 low z, 5 high z.
    uv: the other two coordinates, in the order x, y, z, each scaled over the box to [0, 1].
    Source: the ray tracing notes, "ray and box".
    """

    low: VectorLike = (-1.0, -1.0, -1.0)
    high: VectorLike = (1.0, 1.0, 1.0)
    bounds_kind: ClassVar[BoundsKind] = "box"

    def __post_init__(self) -> None:
        check_fields(self, low=check_vector, high=check_vector)
        low, high = self.low, self.high
        for i in range(3):
            if not low[i] < high[i]:
                raise ValueError(f"Box: high[{i}] must be > low[{i}] = {low[i]}, got {high[i]}")

    def tree(self) -> Cell:
        faces, edges = [], [b - a for a, b in zip(self.low, self.high, strict=True)]
        rows = [component_row(axis_row(i, edge), self.low) for i, edge in enumerate(edges)]
        for i in range(3):
            first, second = (row for k, row in enumerate(rows) if k != i)
            up, uv = axis_row(i, 1.0), UV(False, (first, second, NO_ROW))
            faces.append(Face(PlaneSurface(axis_row(i, -1.0), -self.low[i], self.low), 2 * i, uv))
            faces.append(Face(PlaneSurface(up, self.high[i], self.high), 2 * i + 1, uv))
        return Cell(tuple(faces))

    def support(self, direction: Vector) -> float:
        return sum_up(portable_max(u * a, u * b) for u, a, b in zip(direction, self.low, self.high, strict=True) if u)


def axis_row(index: int, length: float) -> Vector:
    """Return a vector along a coordinate axis."""
    x, y, z = (length if i == index else 0.0 for i in range(3))
    return x, y, z


@dataclass(frozen=True)
class HalfSpace(PrimitiveSolid):
    """normal·x <= offset, as written: the normal is not rescaled.

    Face 0. uv: Cartesian coordinates on the plane about the foot of the perpendicular from the origin;
    u points to the coordinate axis that is least along the normal, v = normal × u.
    Source: the ray tracing notes, "ray and plane".
    """

    normal: VectorLike
    offset: float
    bounds_kind: ClassVar[BoundsKind] = "half_space"

    def __post_init__(self) -> None:
        check_fields(self, normal=check_direction, offset=check_number)

    @property
    def surface(self) -> PlaneSurface:
        return plane_through(self.normal, self.offset)

    def tree(self) -> Cell:
        surface = self.surface
        return Cell((Face(surface, 0, plane_uv(surface)),))

    def support(self, direction: Vector) -> float:
        multiple = along_normal(self.normal, direction)
        # Bounded along its outward normal alone
        return math.inf if multiple is None or multiple < 0 else float(multiple * self.offset)

    def bounds_under(self, outer: Motion) -> BoxEnds:
        """Return the bounds, which are finite along the normal if the motion turns it to an axis."""
        return half_space_bounds(self.surface.moved(self.under(outer)), above=False)

    def outside_bounds_under(self, outer: Motion) -> BoxEnds:
        """Return the bounds of the other side of the plane."""
        return half_space_bounds(self.surface.moved(self.under(outer)), below=False)

    def bounding_surfaces(self, outer: Motion, inside: bool) -> BoundingSurfaces:
        return [orient_surface(self.surface.moved(self.under(outer)), 1 if inside else -1)]


# The axis of cylinders and cones, from start to end


def axis_vector(start: Vector, end: Vector) -> ex.Row:
    """Return end - start, exact."""
    x, y, z = (ex.exact(b) - ex.exact(a) for a, b in zip(start, end, strict=True))
    return x, y, z


def axis_frame(start: Vector, end: Vector, reference: Vector | None) -> Motion:
    """Return the motion from own frame to world: origin at start, z to end, x to the reference (Sasaki 2021)."""
    return Motion((AxisFrame(start, axis_vector(start, end), reference),))


def axis_length(start: Vector, end: Vector) -> ex.BigFloat:
    """Return |end - start| in 3000 bits."""
    axis = axis_vector(start, end)
    along = [] if any(isinstance(entry, ex.Symbol) for entry in axis) else [x for x in axis if not ex.is_nothing(x)]
    if len(along) == 1:  # a coordinate axis needs no roots
        return abs(along[0])
    return ex.sqrt(ex.dot(axis, axis))


def frustum_side(r0: Any, z0: Any, r1: Any, z1: Any, length_square: Any = None) -> QuadricSurface:
    """Return the cylinder or cone x² + y² = r² through two circles about z, r = r0 at z0 and r = r1 at z1.

    The inside is towards the axis; radii and heights are fractions or 3000-bit numbers, and `length_square` is
    (z1 - z0)² where it is known without a root. The equation of a cone, x² + y² - m² z² - 2 m r z - r² = 0, has its
    origin at the end with the smaller radius r: there all terms of the radius have one sign, so that neither nearly
    cylindrical nor nearly pointed cones lose digits.
    """
    growth = r1 - r0
    if not growth:
        return QuadricSurface((1.0, 1.0, 0.0), constant=r0 * r0)
    slope = growth / (z1 - z0)
    steepness = slope * slope if length_square is None else growth * growth / length_square
    # A factor of 0 or 1 and no test chooses the end, so that one recording of the formula serves both
    shrinks = ex.rational(negative_indicator(growth))
    r, z = ((1 - shrinks) * first + shrinks * second for first, second in ((r0, r1), (z0, z1)))
    return QuadricSurface((1.0, 1.0, -steepness), (0.0, 0.0, -slope * r), r * r, anchor=(0.0, 0.0, z))


# Cylinders, cones and tubes, and their wedges


class AxialShape(Primitive, abstract=True):
    """A shape about an axis from `start` to `end`; with angles, from the direction of `reference` on."""

    start: Any
    end: Any
    start_angle: float
    end_angle: float
    reference: Any

    def check_axis_and_angles(self) -> None:
        """Check that the axis has a length; check start_angle, end_angle and reference, and set the checked values.

        Raise ValueError if angles have no reference, or if the reference is on the axis.
        """
        owner = type(self).__name__
        if self.start == self.end:
            raise ValueError(f"{owner}: end must differ from start, got {self.end} for both")
        check_angle_range(self)
        if self.reference is not None:
            check_fields(self, reference=check_vector)
            axis, towards = axis_vector(self.start, self.end), axis_vector(self.start, self.reference)
            # Exactly: a reference that is only nearly on the axis still has a direction
            if not any(ex.cross(axis, towards)):
                raise ValueError(f"{owner}: reference must lie off the axis, got {self.reference}")
        # Where angle 0 points would otherwise depend on the axis, and jump when that turns
        elif self.end_angle - self.start_angle < 360:
            raise ValueError(f"{owner}: reference must be given with angles: it is where angle 0 points")

    @property
    def length(self) -> float:
        """The distance from start to end."""
        return hypot(*map(sub, self.end, self.start))

    @functools.cached_property
    def placement(self) -> Motion:  # one for bounds, tables and exports: its frame takes roots in 3000 bits
        return axis_frame(self.start, self.end, self.reference)

    def _outer_radius(self, number: int) -> float | None:
        """Return the radius of the outer side of a cylinder or tube; None for other surfaces of `tree`."""
        return None

    def _axial_name(self, number: int) -> tuple[float, ...] | None:
        # In lowest terms: normal and offset of a cap, or Plücker's coordinates of the axis and the radius of a side
        radius = self._outer_radius(number)
        if number not in (1, 2) and radius is None:
            return None
        *ends, unit = integer_row((*self.start, *self.end, 1.0))
        start, end = ends[:3], ends[3:]
        axis = list(map(sub, end, start))
        row = [unit * x for x in axis]
        row += cross(start, axis) if radius else [dot3(axis, end if number == 2 else start)]
        factor = math.gcd(*row) * (1 if next(filter(None, axis)) > 0 else -1)
        name = tuple(x // factor for x in row)
        return (*name, radius) if radius else name


@dataclass(frozen=True)
class Cylinder(AxialShape, PrimitiveSolid):
    """Closed circular cylinder between two points of its axis, any direction; a wedge with angles.

    Own frame (Sasaki 2021): origin at `start`, z along the axis, x towards `reference` projected
    across the axis: x² + y² <= radius², 0 <= z <= length, and the angle of (x, y), counter-clockwise
    about start → end, from `start_angle` to `end_angle` (degrees, their difference, as float64, in (0, 360]).
    Given angles need a reference; without angles x is the coordinate axis least along the axis.

    Faces: 0 side, 1 start cap, 2 end cap, 3 wall at start_angle, 4 wall at end_angle (half a turn
    has one plane for both walls: face 3). uv: (angle / 360, height in [0, 1]) on the side,
    (x, y) / radius on the caps, (distance from the axis / radius, height in [0, 1]) on the walls; where both walls are
    one plane the distance is below 0 on the side of end_angle.
    Sources: Sasaki 2021 and the graphics textbook (CILIND).
    """

    start: VectorLike
    end: VectorLike
    radius: float
    start_angle: float = 0.0
    end_angle: float = 360.0
    reference: VectorLike | None = None

    def __post_init__(self) -> None:
        check_fields(self, start=check_vector, end=check_vector, radius=check_positive)
        self.check_axis_and_angles()

    def tree(self) -> Tree:
        faces = side_and_caps(self.radius, self.start, self.end)
        walls = wedge_walls(self.start_angle, self.end_angle, self.radius, self.length)
        return cut_wedge(faces, walls, self.end_angle - self.start_angle)

    def support(self, direction: Vector) -> float:
        across = arc_support(self.radius, self.start_angle, self.end_angle, direction)
        if self.end_angle - self.start_angle < 360:
            across = portable_max(0.0, across)
        return sum_up((portable_max(0.0, direction[2] * self.length), across))

    def _outer_radius(self, number: int) -> float | None:
        return self.radius if number == 0 else None


def side_and_caps(radius: float, start: Vector, end: Vector) -> tuple[Face, Face, Face]:
    """Return the faces 0 (side), 1 (start cap) and 2 (end cap) of a cylinder in its own frame."""
    length = axis_length(start, end)
    side = QuadricSurface(squares=(1.0, 1.0, 0.0), constant=ex.rational(radius) ** 2)
    cap_uv = cartesian_uv((radius, 0, 0), (0, radius, 0))
    bottom = PlaneSurface((0.0, 0.0, -1.0), 0.0)
    top = PlaneSurface((0.0, 0.0, 1.0), length, (0.0, 0.0, length))
    return (
        Face(side, 0, cylindrical_uv(0.0, ex.rounded(length))),
        Face(bottom, 1, cap_uv),
        Face(top, 2, cap_uv),
    )


def wedge_walls(start_angle: float, end_angle: float, radius: float, length: float) -> tuple[Face, ...]:
    """Return the half-spaces of a wedge, faces 3 and 4: none for a full turn, one for half a turn."""
    turn = end_angle - start_angle
    if turn >= 360:
        return ()
    walls = []
    # Sine and cosine in 3000 bits: walls of neighbouring wedges at one angle are one plane
    for number_, angle, sense in ((3, start_angle, 1), (4, end_angle, -1)):
        s, c = ex.sin_cos_degrees(angle)
        uv = cartesian_uv((radius * ex.rounded(c), radius * ex.rounded(s), 0), (0, 0, length))
        walls.append(Face(PlaneSurface((sense * s, -sense * c, ex.ZERO), ex.ZERO), number_, uv))
    # Inequalities compare the value alone, also of a number that carries derivatives
    return tuple(walls[:1] if 180 <= turn <= 180 else walls)


def cut_wedge(faces: tuple[Face, ...], walls: tuple[Face, ...], turn: float, *more: Tree) -> Tree:
    """Return the tree of a cell within the wedge of `walls` and within the trees `more`."""
    # Up to half a turn the walls are planes of one cell, which is quicker to trace than a union
    parts = (Cell(faces + walls), *more) if turn <= 180 or not walls else (Cell(faces), union_of_walls(walls), *more)
    return parts[0] if len(parts) == 1 else All(parts)


def union_of_walls(walls: tuple[Face, ...]) -> Any_:
    """Return the tree of points inside at least one of the walls: a wedge over 180°."""
    return Any_(tuple(Cell((wall,)) for wall in walls))


def arc_support(radius: float, start_angle: float, end_angle: float, direction: Vector) -> float:
    """Return sup u·p over a circular arc about the origin of the xy plane, angles in degrees."""
    x, y, _ = direction
    if end_angle - start_angle == 360:
        return radius * hypot(x, y)
    # Either the arc has the point that is farthest along the direction, or one of its ends is farthest
    (s, c), (t, d) = sin_cos_degrees(start_angle), sin_cos_degrees(end_angle)
    # No test, so that one recording serves all directions
    outside = negative_indicator(c * y - s * x) + negative_indicator(t * x - d * y)
    ends = portable_max(sum_up((radius * x * c, radius * y * s)), sum_up((radius * x * d, radius * y * t)))
    count = 2.0 * outside if end_angle - start_angle <= 180 else outside
    return select_if_several(count, ends, radius * hypot(x, y))


@dataclass(frozen=True)
class Cone(AxialShape, PrimitiveSolid):
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
        check_fields(
            self, start=check_vector, end=check_vector, start_radius=check_nonnegative, end_radius=check_nonnegative
        )
        if self.start_radius == self.end_radius == 0:
            raise ValueError("Cone: start_radius and end_radius must not both be 0, got 0.0 and 0.0")
        self.check_axis_and_angles()

    def tree(self) -> Tree:
        height = axis_length(self.start, self.end)
        axis, radii = axis_vector(self.start, self.end), (ex.rational(self.start_radius), ex.rational(self.end_radius))
        side = frustum_side(radii[0], ex.ZERO, radii[1], height, ex.dot(axis, axis))
        bottom = PlaneSurface((0.0, 0.0, -1.0), 0.0)
        top = PlaneSurface((0.0, 0.0, 1.0), height, (0.0, 0.0, height))
        faces = (
            Face(side, 0, cylindrical_uv(0.0, ex.rounded(height))),
            Face(bottom, 1, _cap_uv(self.start_radius)),
            Face(top, 2, _cap_uv(self.end_radius)),
        )
        widest = portable_max(self.start_radius, self.end_radius)
        walls = wedge_walls(self.start_angle, self.end_angle, widest, self.length)
        return cut_wedge(faces, walls, self.end_angle - self.start_angle)

    def support(self, direction: Vector) -> float:
        start, end = (
            arc_support(radius, self.start_angle, self.end_angle, direction)
            for radius in (self.start_radius, self.end_radius)
        )
        if self.end_angle - self.start_angle < 360:
            # A wedge reaches to the axis
            start, end = portable_max(0.0, start), portable_max(0.0, end)
        return portable_max(start, sum_up((direction[2] * self.length, end)))


def _cap_uv(radius: float) -> UV:
    return cartesian_uv((radius, 0, 0), (0, radius, 0)) if radius > 0 else PLAIN_UV


@dataclass(frozen=True)
class Tube(AxialShape, PrimitiveSolid):
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
        check_fields(
            self, start=check_vector, end=check_vector, inner_radius=check_nonnegative, outer_radius=check_positive
        )
        check_inner_radius("Tube", "outer_radius", self.inner_radius, self.outer_radius)
        self.check_axis_and_angles()

    def tree(self) -> Tree:
        side, *caps = side_and_caps(self.outer_radius, self.start, self.end)
        walls = wedge_walls(self.start_angle, self.end_angle, self.outer_radius, self.length)
        bore: tuple[Cell, ...] = ()
        if self.inner_radius > 0:
            surface = QuadricSurface((1.0, 1.0, 0.0), constant=ex.rational(self.inner_radius) ** 2)
            bore = (Cell((replace(side, surface=surface, number=5, inside=-1),)),)
        return cut_wedge((side, *caps), walls, self.end_angle - self.start_angle, *bore)

    def support(self, direction: Vector) -> float:
        outer, inner = (
            arc_support(radius, self.start_angle, self.end_angle, direction)
            for radius in (self.outer_radius, self.inner_radius)
        )
        return sum_up((portable_max(0.0, direction[2] * self.length), portable_max(outer, inner)))

    def _outer_radius(self, number: int) -> float | None:
        return self.outer_radius if number == 0 else None


def check_inner_radius(owner: str, outer_field: str, inner: float, outer: float) -> None:
    """Raise ValueError unless inner < outer."""
    if not inner < outer:
        raise ValueError(f"{owner}: inner_radius must be < {outer_field} = {outer:g}, got {inner:g}")
