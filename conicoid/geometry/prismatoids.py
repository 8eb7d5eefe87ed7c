"""Prismatoids, convex solids whose corners lie in two planes z = low and z = high, and the parallelepiped."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from fractions import Fraction
from itertools import product
from typing import Any, Literal, NamedTuple

from .._util.arrays import Interval, Vector, VectorLike
from .._util.records import dataclass
from .._util.validation import (
    check_degrees,
    check_fields,
    check_integer,
    check_interval,
    check_nonnegative,
    check_number,
    check_numbers,
    check_positive,
    check_vector,
    format_value,
    optional,
)
from ..numerics import bigfloat as ex
from ..numerics.rational import cross, dot3
from .bounds.support import corners_support
from .cell import NO_ROW, UV, Cell, Face
from .shape import PrimitiveSolid
from .surface import PlaneSurface


class PrismatoidSide(NamedTuple):
    """A side: (a, b)·(x, y) <= low at the lower plane, <= high at the upper, and linear between them."""

    a: Any
    b: Any
    low: Any
    high: Any
    uv: UV


class PrismatoidEnd(NamedTuple):
    """The outline in one of the two planes: its corners (x, y), the map of its face, False for an edge or a corner."""

    corners: Sequence[tuple[Any, Any]]
    uv: UV
    is_face: bool


@dataclass(frozen=True)
class Prismatoid(PrimitiveSolid, abstract=True):
    """Sides of fixed directions whose distances are linear in z, and the two ends across z.

    Faces: i is side i, then the lower end and the upper, if they are more than an edge or a corner.
    """

    @property
    def heights(self) -> tuple[Any, Any]:
        """z of the lower and of the upper plane, exact: by default the ends of `z_range`."""
        return ex.rational(self.z_range[0]), ex.rational(self.z_range[1])  # type: ignore[attr-defined]

    @abstractmethod
    def flanks(self) -> list[PrismatoidSide]:
        """Return the sides in the order of their numbers."""

    @abstractmethod
    def levels(self) -> tuple[PrismatoidEnd, PrismatoidEnd]:
        """Return the lower end and the upper."""

    @property
    def _sides_at_corner(self) -> tuple[int, ...]:
        """The sides that hold the first corner on paper, where arithmetic would not show it."""
        return ()

    def tree(self) -> Cell:
        low, high = self.heights
        ends, sides = self.levels(), self.flanks()
        corners = self._corners()
        faces = []
        for number, side in enumerate(sides):
            # A side of fixed direction whose distance is linear in z is a plane, tilted by this
            slope = (side.high - side.low) / (high - low)
            over = ex.ZERO if number in self._sides_at_corner else None
            surface = PlaneSurface((side.a, side.b, -slope), side.low - slope * low, corners[0], over)
            faces.append(Face(surface, number, side.uv))
        for k, (end, z, sense) in enumerate(zip(ends, (low, high), (-1.0, 1.0), strict=True)):
            # A tip or an edge has no plane of its own
            if end.is_face:
                faces.append(Face(PlaneSurface((0.0, 0.0, sense), sense * z, (0.0, 0.0, z)), len(sides) + k, end.uv))
        return Cell(tuple(faces))

    def _corners(self) -> list[ex.Row]:
        corners = []
        for end, z in zip(self.levels(), self.heights, strict=True):
            corners += [ex.exact_row((x, y, z)) for x, y in end.corners]
        return corners

    def support(self, direction: Vector) -> float:
        return corners_support(self._corners(), direction)


def affine_uv(u: tuple[Any, ...], v: tuple[Any, ...]) -> UV:
    """Return the planar map with the two rows (a, b, c, d) of a x + b y + c z + d."""
    return UV(False, (round_row(u), round_row(v), NO_ROW))


def round_row(row: tuple[Any, ...]) -> tuple[float, float, float, float]:
    """Return a row of exact numbers as floats."""
    a, b, c, d = (ex.rounded(ex.exact(number)) for number in row)
    return a, b, c, d


def check_finite_range(owner: str, field: str, value: Any) -> Interval:
    """Return a range of two finite numbers. Raise ValueError for anything else."""
    interval = check_interval(owner, field, value)
    if interval is None or any(abs(end) == float("inf") for end in interval):
        raise ValueError(f"{owner}: {field} must be two finite numbers, got {format_value(value)}")
    return interval


def _check_pair(owner: str, field: str, value: Any) -> tuple[float, ...]:
    return check_numbers(owner, field, value, 2)


def _check_sizes(owner: str, field: str, value: Any) -> tuple[float, ...]:
    return tuple(check_nonnegative(owner, field, size) for size in check_numbers(owner, field, value, 2))


# Regular prisms and pyramids

MAX_SIDES = 1000
RadiusTo = Literal["corners", "sides"]


class RegularSides(Prismatoid, abstract=True):
    """Equal sides around z, which may lean: corner k, from 0, is at the angle start_angle + 360 k / sides."""

    sides: int
    radius: float
    z_range: Interval
    start_angle: float
    radius_to: RadiusTo

    def _check(self) -> None:
        owner = type(self).__name__
        object.__setattr__(self, "sides", check_integer(owner, "sides", self.sides, 3, MAX_SIDES))
        check_fields(self, radius=check_positive, z_range=check_finite_range, start_angle=check_degrees)
        if not isinstance(self.radius_to, str) or self.radius_to not in ("corners", "sides"):
            raise ValueError(f"{owner}: radius_to must be 'corners' or 'sides', got {format_value(self.radius_to)}")

    @property
    def _sides_at_corner(self) -> tuple[int, ...]:
        return 0, self.sides - 1

    @property
    @abstractmethod
    def radii(self) -> tuple[float, float]:
        """The radii at the lower end and at the upper, to corners or sides by `radius_to`."""

    def _directions(self, first: Fraction) -> list[tuple[ex.BigFloat, ex.BigFloat]]:
        """Return for each side k (cosine, sine) of start_angle + 360 (k + first) / sides."""
        s, c = ex.sin_cos_degrees(self.start_angle)
        directions = []
        for k in range(self.sides):
            t, d = ex.sin_cos_degrees(360 * (k + first) / self.sides)  # type: ignore[arg-type]
            directions.append((ex.dot((c, -s), (d, t)), ex.dot((s, c), (d, t))))
        return directions

    def _reach(self, radius: float, to: RadiusTo) -> ex.BigFloat:
        """Return the distance of sides, or of corners, from the axis."""
        _, c = ex.sin_cos_degrees(Fraction(180, self.sides))  # type: ignore[arg-type]
        given = ex.exact(radius)
        if to == self.radius_to:
            return given
        # The number that was given is kept exact, and the other one is rounded from it
        return given * c if to == "sides" else given / c

    def flanks(self) -> list[PrismatoidSide]:
        low, high = (self._reach(radius, "sides") for radius in self.radii)
        s, _ = ex.sin_cos_degrees(Fraction(180, self.sides))  # type: ignore[arg-type]
        edge = self._reach(self.radius, "corners") * s * ex.exact(2)
        z, height = self.heights[0], ex.exact(self.heights[1]) - ex.exact(self.heights[0])
        up = (ex.ZERO, ex.ZERO, ex.ONE / height, -ex.exact(z) / height)
        return [
            PrismatoidSide(x, y, low, high, affine_uv((-y / edge, x / edge, ex.ZERO, 0.5), up))
            for x, y in self._directions(Fraction(1, 2))
        ]

    def levels(self) -> tuple[PrismatoidEnd, PrismatoidEnd]:
        bottom, top = (self._level(radius) for radius in self.radii)
        return bottom, top

    def _level(self, radius: float) -> PrismatoidEnd:
        if not radius > 0:
            return PrismatoidEnd([(ex.ZERO, ex.ZERO)], affine_uv((0, 0, 0, 0), (0, 0, 0, 0)), False)
        reach = self._reach(radius, "corners")
        corners = [(reach * x, reach * y) for x, y in self._directions(Fraction(0))]
        size = ex.ONE / reach
        return PrismatoidEnd(corners, affine_uv((size, 0, 0, 0), (0, size, 0, 0)), True)


@dataclass(frozen=True)
class RegularPrism(RegularSides):
    """A prism of equal sides about the z axis, from one end of `z_range` to the other: a hexagonal bar or pin.

    `sides`: 3 to 1000. `radius` is that of the circle through the corners, or with radius_to="sides" of the one that
    touches the sides, half the width across flats: these are then exact, so that hexagons at such a pitch share their
    walls. Corner k, from 0, is at the angle start_angle + 360 k / sides, in degrees, counter-clockwise from +x.

    Faces: i is the side from corner i to the next, then the lower end and the upper. uv: along the edge from corner to
    corner and along z, each in [0, 1], on the sides; (x, y) in units of the circle through the corners on the ends.
    A triangular prism of glass is `Prism`.
    """

    sides: int
    radius: float
    z_range: Interval = (-1.0, 1.0)
    start_angle: float = 0.0
    radius_to: RadiusTo = "corners"

    def __post_init__(self) -> None:
        self._check()

    @property
    def radii(self) -> tuple[float, float]:
        return self.radius, self.radius


@dataclass(frozen=True)
class Pyramid(RegularSides):
    """A pyramid of equal sides about the z axis, its base at the lower end of `z_range`; with a `top_radius` cut off.

    `sides`: 3 to 1000. `radius`, of the base, and `top_radius`, of the upper end, 0 for a tip, are those of circles
    through the corners, or with radius_to="sides" of those that touch the sides. Corner k, from 0, is at the angle
    start_angle + 360 k / sides, in degrees, counter-clockwise from +x. On a rectangle it is a `Trapezoid`.

    Faces: i is the side from corner i to the next, then the base and, if there is one, the upper end. uv: along the
    edge of the base from corner to corner and along z, each in [0, 1], on the sides; (x, y) in units of the circle
    through the corners on the ends.
    """

    sides: int
    radius: float
    z_range: Interval = (0.0, 1.0)
    top_radius: float = 0.0
    start_angle: float = 0.0
    radius_to: RadiusTo = "corners"

    def __post_init__(self) -> None:
        self._check()
        object.__setattr__(self, "top_radius", check_nonnegative("Pyramid", "top_radius", self.top_radius))

    @property
    def radii(self) -> tuple[float, float]:
        return self.radius, self.top_radius


# Trapezoids and wedges

_HALF = 0.5


class Rectangle(NamedTuple):
    """A rectangle by its ends in x and in y, exact."""

    x: tuple[Any, Any]
    y: tuple[Any, Any]

    @property
    def is_face(self) -> bool:
        """True if it has an area."""
        return bool(self.x[0] < self.x[1] and self.y[0] < self.y[1])


@dataclass(frozen=True)
class BetweenRectangles(Prismatoid, abstract=True):
    """The solid between two rectangles along x and y, one above the other."""

    @abstractmethod
    def rectangles(self) -> tuple[Rectangle, Rectangle]:
        """Return the lower and the upper rectangle."""

    def flanks(self) -> list[PrismatoidSide]:
        low, high = self.rectangles()
        x, y, z = self._scales()
        return [
            PrismatoidSide(-1.0, 0.0, -low.x[0], -high.x[0], affine_uv(y, z)),
            PrismatoidSide(1.0, 0.0, low.x[1], high.x[1], affine_uv(y, z)),
            PrismatoidSide(0.0, -1.0, -low.y[0], -high.y[0], affine_uv(x, z)),
            PrismatoidSide(0.0, 1.0, low.y[1], high.y[1], affine_uv(x, z)),
        ]

    def levels(self) -> tuple[PrismatoidEnd, PrismatoidEnd]:
        x, y, _ = self._scales()
        low, high = (
            PrismatoidEnd([(a, b) for a in one.x for b in one.y], affine_uv(x, y), one.is_face)
            for one in self.rectangles()
        )
        return low, high

    def _scales(self) -> tuple[tuple[Any, ...], ...]:
        """Return rows of x, y and z, each scaled over the solid to [0, 1]."""
        one, other = self.rectangles()
        rows = []
        for i, (low, high) in enumerate(
            (
                (min(one.x[0], other.x[0]), max(one.x[1], other.x[1])),
                (min(one.y[0], other.y[0]), max(one.y[1], other.y[1])),
                self.heights,
            )
        ):
            size = ex.exact(high) - ex.exact(low)
            rows.append((*(ex.ONE / size if i == k else ex.ZERO for k in range(3)), -ex.exact(low) / size))
        return tuple(rows)


def _centered_ends(middle: Any, size: Any) -> tuple[Any, Any]:
    """Return the two ends of a size about its middle."""
    half = ex.rational(size) * ex.rational(_HALF)
    return ex.rational(middle) - half, ex.rational(middle) + half


@dataclass(frozen=True)
class Trapezoid(BetweenRectangles):
    """The solid between a rectangle at the lower end of `z_range` and another at the upper, all edges straight.

    `bottom` and `top` are their sizes (x, y), the lower one about the z axis, the upper one about `shift`, (x, y).
    Sizes may be 0, but not at both ends: with a top of (0, 0) it is a pyramid, of (3, 0) it has an edge there.

    Faces: 0 low x, 1 high x, 2 low y, 3 high y, 4 low z, 5 high z; an end without an area is no face. uv: the other two
    coordinates, in the order x, y, z, each scaled over the solid to [0, 1], as for `Box`.
    Source: the trapezoid of detector simulation (Trd in Geant4, "Book for Application Developers", solids).
    """

    bottom: tuple[float, float]
    top: tuple[float, float]
    z_range: Interval = (-1.0, 1.0)
    shift: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        check_fields(self, bottom=_check_sizes, top=_check_sizes)
        for k, axis in enumerate("xy"):
            if self.bottom[k] == self.top[k] == 0:
                raise ValueError(f"Trapezoid: bottom[{k}] and top[{k}], its sizes in {axis}, must not both be 0")
        check_fields(self, z_range=check_finite_range, shift=_check_pair)

    def rectangles(self) -> tuple[Rectangle, Rectangle]:
        (x, y), (a, b) = self.bottom, self.top
        above = Rectangle(_centered_ends(self.shift[0], a), _centered_ends(self.shift[1], b))
        return Rectangle(_centered_ends(0.0, x), _centered_ends(0.0, y)), above


@dataclass(frozen=True)
class Wedge(BetweenRectangles):
    """A rectangle with an edge above it: a roof, a ramp, a chisel.

    The rectangle is |x| <= length / 2, |y| <= width / 2 at z = 0. The edge is along x at z = height, y = `edge_shift`,
    `edge_length` long, about x = 0; without one as long as the rectangle, so that the wedge is a triangular prism. With
    edge_shift = width / 2 one side is upright: a right-angled wedge. Volume: width height (2 length + edge_length) / 6.

    Faces: 0 low x, 1 high x, 2 low y, 3 high y, 4 the rectangle. uv: the other two coordinates, in the order x, y, z,
    each scaled over the solid to [0, 1], as for `Box`.
    """

    length: float
    width: float
    height: float
    edge_length: float | None = None
    edge_shift: float = 0.0

    def __post_init__(self) -> None:
        check_fields(
            self,
            length=check_positive,
            width=check_positive,
            height=check_positive,
            edge_length=optional(check_nonnegative),
            edge_shift=check_number,
        )

    @property
    def heights(self) -> tuple[Any, Any]:
        return ex.rational(0.0), ex.rational(self.height)

    def rectangles(self) -> tuple[Rectangle, Rectangle]:
        edge = self.length if self.edge_length is None else self.edge_length
        shift = ex.rational(self.edge_shift)
        base = Rectangle(_centered_ends(0.0, self.length), _centered_ends(0.0, self.width))
        return base, Rectangle(_centered_ends(0.0, edge), (shift, shift))


@dataclass(frozen=True)
class Parallelepiped(PrimitiveSolid):
    """corner + i a + j b + k c with i, j, k from 0 to 1: a box with slanted edges, its volume |a·(b × c)|.

    a, b, c: the three edges that leave the corner, in any order and sense, not in one plane. Decided exactly.

    Faces: 0 i = 0, 1 i = 1, 2 j = 0, 3 j = 1, 4 k = 0, 5 k = 1. uv: the other two of i, j, k, in this order.
    Source: MCNP's macrobody BOX, Geant4's Para.
    """

    corner: VectorLike
    a: VectorLike
    b: VectorLike
    c: VectorLike

    def __post_init__(self) -> None:
        check_fields(self, corner=check_vector, a=check_vector, b=check_vector, c=check_vector)
        # In fractions, as any share of the volume would refuse thin plates
        if not dot3(cross(*self._edges[:2]), self._edges[2]):
            raise ValueError("Parallelepiped: a, b and c must not lie in one plane")

    @property
    def _edges(self) -> list[tuple[Any, ...]]:
        return [tuple(ex.rational(x) for x in edge) for edge in (self.a, self.b, self.c)]

    def tree(self) -> Cell:
        a, b, c = self._edges
        volume = dot3(cross(a, b), c)
        corner = tuple(ex.rational(x) for x in self.corner)
        opposite = ex.exact_row(x + i + j + k for x, i, j, k in zip(corner, a, b, c, strict=True))
        rows = []
        for normal in (cross(b, c), cross(c, a), cross(a, b)):
            own = tuple(x / volume for x in normal)
            rows.append((*own, -dot3(own, corner)))
        faces, maps = [], [round_row(row) for row in rows]
        for i, (x, y, z, shift) in enumerate(rows):
            first, second = (row for k, row in enumerate(maps) if k != i)
            uv = UV(False, (first, second, NO_ROW))
            faces.append(Face(PlaneSurface((-x, -y, -z), shift, ex.exact_row(corner), ex.ZERO), 2 * i, uv))
            faces.append(Face(PlaneSurface((x, y, z), 1 - shift, opposite, ex.ZERO), 2 * i + 1, uv))
        return Cell(tuple(faces))

    def support(self, direction: Vector) -> float:
        a, b, c = self._edges
        corners = []
        for i, j, k in product((0, 1), repeat=3):
            point = (ex.rational(x) + i * p + j * q + k * r for x, p, q, r in zip(self.corner, a, b, c, strict=True))
            corners.append(ex.exact_row(point))
        return corners_support(corners, direction)
