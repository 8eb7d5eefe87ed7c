"""Sheets: plane, disc, polygon, triangle, side of a cylinder, a face of any solid; and closed outlines in a plane."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np

from .._util.arrays import BoxEnds, Vector, VectorLike
from .._util.records import dataclass
from .._util.validation import (
    check_direction,
    check_fields,
    check_flag,
    check_integer,
    check_number,
    check_numbers,
    check_positive,
    check_vector,
    check_vectors,
    describe_kind,
    format_value,
)
from ..numerics import bigfloat as ex
from ..numerics.portable_math import count_nonzero, hypot, portable_max
from ..numerics.rational import minus
from .bounds.aabb import intersect_boxes
from .bounds.support import along_normal, half_space_bounds, plane_through, plane_uv, points_support, sum_up
from .cell import (
    NO_ROW,
    UV,
    All,
    Any_,
    Cell,
    Face,
    Not,
    PolygonSheet,
    SurfaceSheet,
    Tree,
    cartesian_uv,
    faces_of_tree,
    map_faces,
    negate_tree,
    transform_uv,
)
from .primitives import AxialShape, arc_support, side_and_caps, union_of_walls, wedge_walls
from .shape import PrimitiveSheet, PrimitiveSolid, Solid
from .surface import PlaneSurface, QuadricSurface, Surface
from .transform import IDENTITY_MOTION, AxisFrame, Motion


@dataclass(frozen=True)
class Plane(PrimitiveSheet):
    """normal·x = offset. With `one_sided` it is seen only by rays with normal·direction < 0.

    Face 0. uv: Cartesian coordinates on the plane about the foot of the perpendicular from the origin;
    u points to the coordinate axis that is least along the normal, v = normal × u.
    Source: the ray tracing notes, "ray and plane" (their D is -offset).
    """

    normal: VectorLike
    offset: float
    one_sided: bool = False

    def __post_init__(self) -> None:
        check_fields(self, normal=check_direction, offset=check_number, one_sided=check_flag)

    @property
    def surface(self) -> PlaneSurface:
        return plane_through(self.normal, self.offset)

    def sheet(self, motion: Motion) -> SurfaceSheet:
        surface = self.surface
        uv = transform_uv(plane_uv(surface), motion)
        return SurfaceSheet(surface.moved(motion), one_sided=self.one_sided, uv=uv)

    def support(self, direction: Vector) -> float:
        # Bounded only across itself
        multiple = along_normal(self.normal, direction)
        return math.inf if multiple is None else float(multiple * self.offset)

    def bounds_under(self, outer: Motion) -> BoxEnds:
        """Return the bounds: flat along the normal if the motion turns it to an axis, infinite otherwise."""
        return half_space_bounds(self.surface.moved(self.under(outer)))


@dataclass(frozen=True)
class Disc(PrimitiveSheet):
    """The part of the plane through `center` across `normal` within `radius` of the center.

    Own frame: origin at the center, z along the normal, x towards the coordinate axis least along it:
    z = 0, x² + y² <= radius². Face 0. uv: (x, y) / radius.
    """

    center: VectorLike
    normal: VectorLike
    radius: float

    def __post_init__(self) -> None:
        check_fields(self, center=check_vector, normal=check_direction, radius=check_positive)

    @property
    def placement(self) -> Motion:
        return Motion((AxisFrame(self.center, self.normal),))

    def sheet(self, motion: Motion) -> SurfaceSheet:
        # A ball cuts the same circle from the plane as a cylinder, and bounds the disc on all sides
        ball = QuadricSurface((1.0, 1.0, 1.0), constant=ex.rational(self.radius) ** 2)
        uv = cartesian_uv((self.radius, 0.0, 0.0), (0.0, self.radius, 0.0))
        return SurfaceSheet(
            PlaneSurface((0.0, 0.0, 1.0), 0.0).moved(motion),
            clip=Cell((Face(ball.moved(motion), 0),)),
            uv=transform_uv(uv, motion),
        )

    def support(self, direction: Vector) -> float:
        return self.radius * hypot(direction[0], direction[1])


_FLATNESS = 64
"""Vertices may lie off their plane by so many units in the last place of the largest coordinate."""


@dataclass(frozen=True)
class Polygon(PrimitiveSheet):
    """A closed loop of `vertices` in a plane; inside by even-odd, so it may be concave or cross itself.

    The plane is Newell's; its normal sees the loop counter-clockwise. A vertex may lie off it by 64 units
    in the last place of the largest coordinate, more is refused. Face 0. uv: coordinates along the first edge
    and across it (normal × edge), from the first vertex, in units of that edge.
    Source: the ray tracing notes, "ray and polygon" (even-odd).
    """

    vertices: tuple[Vector, ...]

    def __post_init__(self) -> None:
        points = check_vectors("Polygon", "vertices", self.vertices, 3)
        object.__setattr__(self, "vertices", points)
        check_flat("Polygon", points)

    def sheet(self, motion: Motion) -> PolygonSheet:
        return polygon_sheet(self.vertices, motion, self._uv())

    def _uv(self) -> UV:
        points = [ex.exact_row(point) for point in self.vertices]
        edges = (minus(point, points[0]) for point in points[1:])
        # The first corners may coincide
        edge = next(e for e in edges if any(e))
        across = ex.cross(ex.unit(newell_sum(points)), edge)
        return cartesian_uv(ex.rounded_row(edge), ex.rounded_row(across), self.vertices[0])

    def support(self, direction: Vector) -> float:
        return points_support(self.vertices, direction)


def newell_sum(points: Sequence[ex.Row]) -> ex.Row:
    """Return twice the area vector of a closed loop, the sum of p_i × p_(i+1) (Newell), exact."""
    # From one corner, so that loops far from the origin have short numbers
    spokes = [minus(point, points[0]) for point in points]
    terms = [ex.cross(a, b) for a, b in itertools.pairwise(spokes[1:])]
    x, y, z = (ex.cancelling_sum([term[i] for term in terms]) for i in range(3))
    return x, y, z


def check_flat(owner: str, vertices: Sequence[Vector]) -> None:
    """Raise ValueError for a loop without area and for a loop that leaves its plane."""
    points = [ex.exact_row(vertex) for vertex in vertices]
    normal = newell_sum(points)
    if not any(normal):
        raise ValueError(
            f"{owner}: vertices must enclose an area, got {len(points)} points with none (Newell's sum is 0)"
        )
    unit, middle = ex.unit(normal), _middle(points)
    allowed = _FLATNESS * math.ulp(max(abs(c) for vertex in vertices for c in vertex))
    deviations = [abs(float(ex.dot(unit, minus(point, middle)))) for point in points]
    worst = max(range(len(points)), key=deviations.__getitem__)
    if deviations[worst] > allowed:
        raise ValueError(
            f"{owner}: vertices must lie in a plane to {_FLATNESS} ulp of the largest coordinate ({allowed:.3g}), "
            f"got vertices[{worst}] = {vertices[worst]} at {deviations[worst]:.3g} from Newell's plane"
        )


def polygon_sheet(vertices: Sequence[Vector], motion: Motion, uv: UV) -> PolygonSheet:
    """Return a loop after a motion. Its normal stays on the same physical side, also after a mirror image."""
    own = [ex.exact_row(vertex) for vertex in vertices]
    normal = newell_sum(own)
    # A triangle has the offset of any corner. Other loops have n·middle, divided last: so the offset is exact if its
    # exact value is a binary fraction
    offset = ex.dot(normal, own[0]) if len(own) == 3 else ex.dot(normal, _sum(own)) / len(own)
    is_oblique = count_nonzero(ex.rounded_row(normal)) > 1  # else corners and middle have one coordinate along it
    (rows, shift), factor = motion.affine, motion.similarity
    # Newell's sum after the motion: by the inverse transpose of a similarity, else without a division.
    # A mirror turns the sense of the loop round, and with it the vector that Newell's sum gives
    if factor is None:
        across = ex.cross(rows[1], rows[2]), ex.cross(rows[2], rows[0]), ex.cross(rows[0], rows[1])
        size = ex.determinant(rows)
        sense = 1 if size > 0 else -1
        x, y, z = (sense * each for each in ex.apply(across, normal))
        normal, end = (x, y, z), ex.dot((x, y, z), shift, sense * size * offset)
    else:
        turned, size = PlaneSurface(normal, offset).moved(motion), abs(factor * factor * factor)
        x, y, z, end = (size * each for each in (*turned.normal, turned.offset))
        normal = x, y, z
    plane = PlaneSurface(normal, end, motion.carried(_middle(own)), 0.0, is_offset_better=bool(is_oblique))
    points = tuple(_transform_points(rows, shift, point) for point in own)
    return PolygonSheet(plane, points, transform_uv(uv, motion))


def _transform_points(rows: ex.Rows, shift: ex.Row, point: ex.Row) -> ex.Row:
    x, y, z = (ex.dot(row, point, t) for row, t in zip(rows, shift, strict=True))
    return x, y, z


def _sum(points: Sequence[ex.Row]) -> ex.Row:
    x, y, z = (ex.total(point[i] for point in points) for i in range(3))
    return x, y, z


def _middle(points: Sequence[ex.Row]) -> ex.Row:
    x, y, z = (total / len(points) for total in _sum(points))
    return x, y, z


CLEAR_AREA = 2.0**-45
"""A difference of products above this share of both is surely not zero in floats."""


@dataclass(frozen=True)
class Triangle(PrimitiveSheet):
    """The triangle a, b, c; its normal (b - a) × (c - a) sees them counter-clockwise.

    Face 0. uv: (β, γ), the barycentric weights of b and c in p = α a + β b + γ c, α + β + γ = 1.
    Source: the ray tracing notes, "barycentric coordinates".
    """

    a: VectorLike
    b: VectorLike
    c: VectorLike

    def __post_init__(self) -> None:
        check_fields(self, a=check_vector, b=check_vector, c=check_vector)
        # Meshes have millions of triangles, so floats decide nearly all of them
        if not self._is_clear() and not any(ex.cross(*self._edges())):
            raise ValueError(f"Triangle: a, b, c must not lie on a line, got {self.a}, {self.b}, {self.c}")

    def _is_clear(self) -> bool:
        """Return True if floats show that the corners are not on a line.

        Products of rounded differences have relative errors below 2^-51, and nothing underflows in the domain.
        """
        (ax, ay, az), (bx, by, bz), (cx, cy, cz) = self.a, self.b, self.c
        x, y, z, u, v, w = bx - ax, by - ay, bz - az, cx - ax, cy - ay, cz - az
        return any(
            abs(p - q) > CLEAR_AREA * (abs(p) + abs(q)) for p, q in ((y * w, z * v), (z * u, x * w), (x * v, y * u))
        )

    def _edges(self) -> tuple[ex.Row, ex.Row]:
        a, b, c = (ex.exact_row(point) for point in (self.a, self.b, self.c))
        return (b[0] - a[0], b[1] - a[1], b[2] - a[2]), (c[0] - a[0], c[1] - a[1], c[2] - a[2])

    def sheet(self, motion: Motion) -> PolygonSheet:
        return polygon_sheet((self.a, self.b, self.c), motion, self._uv())

    def _uv(self) -> UV:
        """Return the map β = (c - a) × n · (p - a) / n², γ = n × (b - a) · (p - a) / n², n = (b - a) × (c - a)."""
        to_b, to_c = self._edges()
        normal = ex.cross(to_b, to_c)
        square, start = ex.dot(normal, normal), ex.exact_row(self.a)
        rows = []
        for gradient in (ex.cross(to_c, normal), ex.cross(normal, to_b)):
            x, y, z = (component / square for component in gradient)
            rows.append((ex.rounded(x), ex.rounded(y), ex.rounded(z), -ex.rounded(ex.dot((x, y, z), start))))
        return UV(False, (rows[0], rows[1], NO_ROW))

    def support(self, direction: Vector) -> float:
        return points_support((self.a, self.b, self.c), direction)


@dataclass(frozen=True)
class CylinderPatch(AxialShape, PrimitiveSheet):
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
        check_fields(self, start=check_vector, end=check_vector, radius=check_positive)
        self.check_axis_and_angles()

    def sheet(self, motion: Motion) -> SurfaceSheet:
        side, *ends = side_and_caps(self.radius, self.start, self.end)
        walls = wedge_walls(self.start_angle, self.end_angle, self.radius, self.length)
        between, wedge = (
            tuple(dataclasses.replace(face, surface=face.surface.moved(motion)) for face in faces)
            for faces in (ends, walls)
        )
        clip: Tree = Cell(between + wedge)
        # More than half a turn is not convex: it is on the inner side of at least one wall
        if self.end_angle - self.start_angle > 180 and wedge:
            clip = All((Cell(between), union_of_walls(wedge)))
        return SurfaceSheet(side.surface.moved(motion), clip, uv=transform_uv(side.uv, motion))

    def support(self, direction: Vector) -> float:
        across = arc_support(self.radius, self.start_angle, self.end_angle, direction)
        return sum_up((portable_max(0.0, direction[2] * self.length), across))


@dataclass(frozen=True)
class Wall(PrimitiveSheet):
    """One face of a primitive `solid` as an open surface: thin mirrors, screens and shells of any quadric.

    It is the part of the face's surface that bounds the solid. `face` is its number, as in ``hits.face``. Other solids
    cut it: ``Wall(solid, 0) & a - b``. So it can be a face of a Boolean solid too: the face of the primitive, inside
    (``&``) or outside (``-``) of the others.
    The normal is the solid's, outward. Own frame and uv: those of the solid. Face 0.
    """

    solid: Solid
    face: int = 0

    def __post_init__(self) -> None:
        if not isinstance(self.solid, Solid) or not getattr(self.solid, "combines", True):
            raise TypeError(f"Wall: solid must be a solid, got {describe_kind(self.solid)}")
        if not isinstance(self.solid, PrimitiveSolid):
            hint = "Wall(part, face) & others, or - others, is a face of a combination"
            raise TypeError(f"Wall: solid must be a primitive, got {describe_kind(self.solid)}; {hint}")
        object.__setattr__(self, "face", check_integer("Wall", "face", self.face, 0))
        face_numbers = sorted({face.number for face in faces_of_tree(self.solid.tree())})
        if self.face not in face_numbers:
            numbers = ", ".join(map(str, face_numbers))
            raise ValueError(
                f"Wall: face must be one of {type(self.solid).__name__}'s, {numbers}, got {format_value(self.face)}"
            )
        # Several cells may share a face; on two surfaces it would have no one equation
        (first, *_), *others = self._cuts()
        if not all(_is_same(first.surface, other.surface) for other, *_ in others):
            raise ValueError(f"Wall: face {self.face} of {type(self.solid).__name__} is on more than one surface")

    @property
    def placement(self) -> Motion:
        return self.solid.under(IDENTITY_MOTION)

    def _cuts(self) -> list[tuple[Face, bool, tuple[Tree, ...]]]:
        """Return where the face bounds the solid (`_find_bounding`)."""
        assert isinstance(self.solid, PrimitiveSolid)
        return _find_bounding(self.solid.tree(), self.face, True, ())

    def sheet(self, motion: Motion) -> SurfaceSheet:
        cuts = self._cuts()
        first, counts, _ = cuts[0]
        held = [All(rest) for _, _, rest in cuts]
        clip = map_faces(
            held[0] if len(held) == 1 else Any_(tuple(held)),
            lambda face: replace(face, surface=face.surface.moved(motion), number=0),
        )
        # The outside of a hole is the inside of the solid
        side = first.inside if counts else -first.inside
        none = isinstance(clip, All) and not clip.parts
        return SurfaceSheet(
            first.surface.moved(motion), None if none else clip, side, uv=transform_uv(first.uv, motion)
        )

    def support(self, direction: Vector) -> float:
        assert isinstance(self.solid, PrimitiveSolid)
        return self.solid.support(direction)

    def bounds_under(self, outer: Motion) -> BoxEnds:
        """Return the bounds of the solid, cut by those of the face's plane if it is flat."""
        motion = self.under(outer)
        box = self.solid.bounds_under(self.motion.then(outer))
        surface = self._cuts()[0][0].surface
        return (
            intersect_boxes([box, half_space_bounds(surface.moved(motion))])
            if isinstance(surface, PlaneSurface)
            else box
        )


def _is_same(a: Surface, b: Surface) -> bool:
    """Return True if two surfaces are equal, whatever their sense."""
    if isinstance(a, PlaneSurface) and isinstance(b, PlaneSurface):
        (x, y, z), (u, v, w) = a.normal, b.normal
        return any((sign * u, sign * v, sign * w, sign * b.offset) == (x, y, z, a.offset) for sign in (1, -1))
    return a == b


def _find_bounding(
    tree: Tree, face: int, counts: bool, enclosing: tuple[Tree, ...]
) -> list[tuple[Face, bool, tuple[Tree, ...]]]:
    """Return (face, True if its cell counts as inside, trees that hold there) for each place where it bounds the tree.

    There the other faces of its cell hold, all other parts of every `All` above it, and no other part of any `Any_`.
    `enclosing` are the trees that hold so far.
    """
    if isinstance(tree, Not):
        return _find_bounding(tree.part, face, not counts, enclosing)
    if isinstance(tree, Cell):
        mine = [one for one in tree.faces if one.number == face]
        return [(one, counts, (*enclosing, _other_faces(tree, one))) for one in mine]
    found = []
    for part in tree.parts:
        others = [other for other in tree.parts if other is not part]
        # A wall of one part of a union bounds it only where no other part is
        decided: list[Tree] = [other if isinstance(tree, All) else negate_tree(other) for other in others]
        found += _find_bounding(part, face, counts, (*enclosing, *decided))
    return found


def _other_faces(cell: Cell, face: Face) -> Tree:
    """Return a cell without one of its faces; all of space without any."""
    rest = tuple(one for one in cell.faces if one is not face)
    return Cell(rest) if rest else All(())


# Closed outlines in a plane: checks of their points, and of crossings in exact fractions.

MAX_CORNERS = 20_000
_ORIENTATION_ERROR, _UNDERFLOW = 4 * 2.0**-53, 2.0**-1060
"""Bounds of the rounding of a difference of two products: a share of their sizes, and what underflow may add."""


def check_outline(owner: str, field: str, outline: Any) -> tuple[tuple[float, float], ...]:
    """Return the points of an outline, without points that repeat the one before. Raise ValueError if invalid."""
    try:
        rows = list(outline)
    except TypeError:
        raise ValueError(f"{owner}: {field} must be three or more points of two numbers") from None
    if not 3 <= len(rows) <= MAX_CORNERS:
        expected = f"from 3 to {MAX_CORNERS:,} points of two numbers"
        raise ValueError(f"{owner}: {field} must have {expected}, got {len(rows):,}")
    points = [check_numbers(owner, f"{field}[{k}]", row, 2) for k, row in enumerate(rows)]
    distinct = [(p[0], p[1]) for k, p in enumerate(points) if p != points[k - 1]]
    if len(distinct) < 3 or not _has_area(distinct):
        raise ValueError(f"{owner}: {field} must enclose an area")
    return tuple(distinct)


def _has_area(points: list[tuple[float, float]]) -> bool:
    terms = [
        part for a, b in zip(points, [*points[1:], points[0]], strict=True) for part in (a[0] * b[1], -a[1] * b[0])
    ]
    # Far above the rounding of the products and of their sum, in whatever order
    if abs(sum(terms)) > 2 * len(terms) * (2.0**-53 * sum(map(abs, terms)) + _UNDERFLOW):
        return True
    return bool(twice_area([(Fraction(x), Fraction(y)) for x, y in points]))


def twice_area(points: Sequence[Any]) -> Any:
    """Return twice the signed area, positive for counter-clockwise points."""
    following = [*points[1:], points[0]]
    return sum((a[0] * b[1] - a[1] * b[0] for a, b in zip(points, following, strict=True)), Fraction(0))


_FEW_EDGES = 16


def check_simple(owner: str, field: str, outline: Sequence[tuple[float, float]]) -> None:
    """Raise ValueError if edges have a common point, other than the corner of neighbours."""
    count = len(outline)
    edges = list(zip(outline, [*outline[1:], *outline[:1]], strict=True))
    lows, highs = ([(end(a[0], b[0]), end(a[1], b[1])) for a, b in edges] for end in (min, max))
    table = (np.array(lows), np.array(highs)) if count > _FEW_EDGES else None
    for k, ((x0, y0), (x1, y1)) in enumerate(zip(lows, highs, strict=True)):
        # Boxes first: the pairs of 20,000 edges are many, and of few edges NumPy's calls take most of the time
        if table is not None:
            near = (table[0][k + 1 :] <= highs[k]).all(axis=1) & (table[1][k + 1 :] >= lows[k]).all(axis=1)
            others = (np.flatnonzero(near) + k + 1).tolist()
        else:
            others = [
                j for j in range(k + 1, count)
                if lows[j][0] <= x1 and lows[j][1] <= y1 and highs[j][0] >= x0 and highs[j][1] >= y0
            ]  # fmt: skip
        for other in others:
            if other - k == 1:
                crosses = _goes_back(*edges[k], edges[other][1])
            elif (k - other) % count == 1:
                crosses = _goes_back(*edges[other], edges[k][1])
            else:
                crosses = _edges_cross(edges[k], edges[other])
            if crosses:
                raise ValueError(f"{owner}: {field} must not cross or touch itself, edges {k} and {other} do")


def _goes_back(a: Any, b: Any, c: Any) -> bool:
    """Return True if the edge from b to c goes back along the edge from a to b."""
    if _orientation(a, b, c):
        return False
    (ax, ay), (bx, by), (cx, cy) = ((Fraction(x), Fraction(y)) for x, y in (a, b, c))
    return (bx - ax) * (cx - bx) + (by - ay) * (cy - by) < 0


def _edges_cross(one: Any, other: Any) -> bool:
    """Return True if two edges have a common point."""
    (a, b), (c, d) = one, other
    sides = [_orientation(a, b, c), _orientation(a, b, d), _orientation(c, d, a), _orientation(c, d, b)]
    if sides[0] * sides[1] < 0 and sides[2] * sides[3] < 0:
        return True
    ends = ((sides[0], c, a, b), (sides[1], d, a, b), (sides[2], a, c, d), (sides[3], b, c, d))
    return any(side == 0 and all(min(q[i], r[i]) <= p[i] <= max(q[i], r[i]) for i in (0, 1)) for side, p, q, r in ends)


def _orientation(a: Any, b: Any, c: Any) -> int:
    """Return 1 if a, b, c turn to the left, -1 to the right, 0 if they lie on a line.

    Source of the bound: Shewchuk, "Adaptive Precision Floating-Point Arithmetic" (1997), ORIENT2D.
    """
    left, right = (b[0] - a[0]) * (c[1] - a[1]), (b[1] - a[1]) * (c[0] - a[0])
    value = left - right
    # Fractions take a hundred times as long, and a file of wires has an outline for each
    if not abs(value) > _ORIENTATION_ERROR * (abs(left) + abs(right)) + _UNDERFLOW:
        (ax, ay), (bx, by), (cx, cy) = ((Fraction(x), Fraction(y)) for x, y in (a, b, c))
        value = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
    return int(value > 0) - int(value < 0)
