"""Polyhedra: `Polyhedron`, convex, bounded or not; `Mesh`, inside a closed surface; `Extrusion`, an outline along z."""

from __future__ import annotations

import itertools
import math
from abc import abstractmethod
from collections import Counter
from collections.abc import Callable, Sequence
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
import numpy.typing as npt

from .._util.arrays import BoxEnds, FloatArray, IndexArray, Interval, Vector, unique_sorted
from .._util.records import dataclass
from .._util.validation import (
    as_integer,
    check_interval,
    check_number,
    check_numbers,
    check_vector,
    check_vectors,
    format_value,
)
from ..numerics import bigfloat as ex
from ..numerics.portable_math import count_nonzero
from ..numerics.rational import dot3, minus
from .bounds.aabb import enclose_boxes
from .bounds.intersection import BoundingSurfaces
from .bounds.linear_program import farthest_point, half_spaces_bounds, integer_row, integer_support, round_fraction_up
from .bounds.support import half_space_bounds, plane_through, plane_uv, raised_sums
from .cell import UV, Any_, Cell, Face, Tree
from .convex_decomposition import convex_parts
from .facets import SIGN_MARGIN, Facet, FlatPlane, PlaneSide, fit_plane, newell_normal, side_of_plane
from .shape import PrimitiveSolid, Shape
from .sheets import check_outline, check_simple
from .surface import PlaneSurface
from .transform import Motion

_DIRECTION_ROUNDING = 2.0**-52
"""A bound of the rounding of a direction and of sums with it."""


@dataclass(frozen=True)
class Polyhedron(PrimitiveSolid):
    """The points with every normals[i]·x <= offsets[i], as written. It may be unbounded or empty.

    Face i belongs to normals[i]. uv: Cartesian coordinates on its plane about a point near the solid;
    u points to the coordinate axis that is least along the normal, v = normal × u.
    """

    normals: tuple[Vector, ...]
    offsets: tuple[float, ...]

    def __post_init__(self) -> None:
        normals = check_vectors("Polyhedron", "normals", self.normals, 1)
        for i, normal in enumerate(normals):
            check_vector("Polyhedron", f"normals[{i}]", normal, nonzero=True)
        vars(self).update(normals=normals, offsets=check_numbers("Polyhedron", "offsets", self.offsets, len(normals)))

    @cached_property
    def _rows(self) -> list[list[int]]:
        """The half-spaces as rows of four integers."""
        return [integer_row((*normal, offset)) for normal, offset in zip(self.normals, self.offsets, strict=True)]

    @property
    def _face_count(self) -> int:
        return len(self.normals)

    @property
    def _has_many_faces(self) -> bool:
        return len(self.normals) >= MANY_FACES

    @cached_property
    def _own_bounds(self) -> BoxEnds:
        """The bounds in the solid's own frame, before any motion."""
        extreme = [self._faces_towards(axis) for axis in (*_AXES, *(-_AXES))]
        every = None in extreme
        rows = range(len(self.normals)) if every else sorted({i for faces in extreme for i in faces or ()})
        return half_spaces_bounds([PlaneSurface(self.normals[i], self.offsets[i]) for i in rows])

    @cached_property
    def _unit_rows(self) -> FloatArray:
        """The half-spaces as rows of a unit normal and its offset, (n, 4)."""
        rows = np.column_stack([np.array(self.normals), np.array(self.offsets)])
        with np.errstate(all="ignore"):
            unit: FloatArray = rows / np.linalg.norm(rows[:, :3], axis=1, keepdims=True)
        return unit

    def _faces_towards(self, direction: Any) -> list[int] | None:
        """Return the faces that decide the support in a direction; None if floats do not find them, or all are few.

        The other half-spaces contain the farthest point by far more than floats are wrong.
        """
        if not self._has_many_faces:
            return None
        rows = self._unit_rows
        point = farthest_point(rows, np.array(direction, np.float64))
        if point is None:
            return None
        slack = rows[:, 3] - rows[:, :3] @ point
        size = float(np.abs(point).max() + np.abs(rows[:, 3]).max())
        return np.flatnonzero(slack <= _SURELY_INSIDE * size).tolist()

    @property
    def near(self) -> Vector:
        """A point near the solid and its planes, by which these are anchored."""
        bounds, planes = np.array(self._own_bounds), np.column_stack([self.normals, self.offsets])
        x, y, z = points_near(bounds[None], planes[None])[0].tolist()
        return x, y, z

    def _face(self, index: int) -> PolyhedronFace:
        """Return the half-space of a face as a solid."""
        return PolyhedronFace(self.normals[index], self.offsets[index], self.near)

    @cached_property
    def surfaces(self) -> list[PlaneSurface]:
        """The planes, anchored near the solid."""
        return [plane_through(*side, self.near) for side in self._sides]

    @cached_property
    def _sides(self) -> list[tuple[Any, Any]]:
        """The normal and the offset of each of the `surfaces`."""
        return list(zip(self.normals, self.offsets, strict=True))

    def tree(self) -> Cell:
        return self._cell

    @cached_property
    def _cell(self) -> Cell:
        return Cell(tuple(Face(surface, i, plane_uv(surface)) for i, surface in enumerate(self.surfaces)))

    def support(self, direction: Vector) -> float:
        """Return the support: exact along an axis, otherwise raised by the effect of the direction's rounding."""
        if sorted(map(abs, direction)) == [0.0, 0.0, 1.0]:
            axis = max(range(3), key=lambda k: abs(direction[k]))
            low, high = self._own_bounds
            return float(high[axis] if direction[axis] > 0 else -low[axis])
        faces = self._faces_towards(direction)
        rows = self._rows if faces is None else [integer_row((*self.normals[i], self.offsets[i])) for i in faces]
        support = integer_support(rows, [Fraction(u) for u in direction])
        if sum(map(bool, direction)) < 2 or isinstance(support, float):
            return round_fraction_up(support)
        reach = np.maximum(abs(self._own_bounds[0]), abs(self._own_bounds[1]))
        terms = [abs(u) * r for u, r in zip(direction, reach.tolist(), strict=True) if u]
        return round_fraction_up(support) + _DIRECTION_ROUNDING * math.fsum(terms)

    def bounds_under(self, outer: Motion) -> BoxEnds:
        """Return the bounds after `outer`.

        The planes of an unbounded solid are moved exactly, so that an end is finite if a face turns to an axis.
        """
        motion = self.under(outer)
        if motion.is_identity:
            return self._own_bounds[0].copy(), self._own_bounds[1].copy()
        if np.isfinite(self._own_bounds).all():
            return super().bounds_under(outer)
        return half_spaces_bounds([surface.moved(motion) for surface in self.surfaces])

    def outside_bounds_under(self, outer: Motion) -> BoxEnds:
        """Return the box around the half-spaces beyond the faces."""
        motion = self.under(outer)
        found: BoxEnds | None = None
        for normal, offset in zip(self.normals, self.offsets, strict=True):
            box = half_space_bounds(plane_through(normal, offset).moved(motion), below=False)
            found = box if found is None else enclose_boxes([found, box])
            if np.isinf(found).all():
                break  # nothing bounds it, whatever the other faces are
        assert found is not None
        return found

    def bounding_surfaces(self, outer: Motion, inside: bool) -> BoundingSurfaces:
        if not inside:  # the outside of several faces is a union: none of them bounds it
            return super().bounding_surfaces(outer, inside) if len(self.normals) == 1 else []
        motion = self.under(outer)
        return [surface.moved(motion) for surface in self.surfaces]


class HalfOfSpace(PrimitiveSolid, abstract=True):
    """A half-space whose bounds nobody needs."""

    def support(self, direction: Vector) -> float:
        return math.inf

    def bounds_under(self, outer: Motion) -> BoxEnds:
        return np.full(3, -np.inf), np.full(3, np.inf)


@dataclass(frozen=True)
class PolyhedronFace(HalfOfSpace, abstract=True):
    """The half-space of one face of a polyhedron, without bounds: the numbers of many faces are computed together."""

    normal: Vector
    offset: float
    near: Vector
    """The point near the solid by which the face is anchored."""

    def tree(self) -> Cell:
        surface = plane_through(self.normal, self.offset, self.near)
        return Cell((Face(surface, 0, plane_uv(surface)),))


MANY_FACES = 32
"""From so many faces on, of one polyhedron, floats choose those that matter. The numbers of so many, of one polyhedron
or of several, are computed together."""
_SURELY_INSIDE = 1e-9
"""A point deeper in a half-space than this share of its coordinates is inside whatever floats round."""
_AXES = np.eye(3)
_FAR_CORNER = 1024
"""Planes are not anchored at corners so many times farther from the origin than every plane."""


def points_near(bounds: FloatArray, planes: FloatArray) -> FloatArray:
    """Return points (n, 3) near polyhedra and their planes: about the middles of bounds; zeros for empty ones.

    `bounds` (n, 2, 3) are lower and upper ends, `planes` (n, p, 4) normals and offsets. Ends that are infinite, or much
    farther than every plane, do not count: planes that are parallel but for a last digit meet there, and an anchor
    there would lose as many digits of all planes.
    """
    with np.errstate(over="ignore"):
        far = _FAR_CORNER * (np.abs(planes[..., 3]) / np.abs(planes[..., :3]).max(axis=2)).max(axis=1)
    counts = np.isfinite(bounds) & (np.abs(bounds) <= far[:, None, None])
    shares = np.where(counts, bounds, 0.0) / np.maximum(counts.sum(axis=1, keepdims=True), 1)
    is_empty = (bounds[:, 0] > bounds[:, 1]).any(axis=1, keepdims=True)
    return np.where(is_empty, 0.0, shares[:, 0] + shares[:, 1] + 0.0)


# --- Solids that may be concave, cut into convex parts
#
# User: extruded and tessellated solids of GDML and OpenSCAD. Walls of many are lowered together, 10 to 30 times as fast
# as one solid after the other.

MAX_MESH_PARTS = 20_000
"""A mesh may have at most so many convex parts."""
MAX_MESH_FACES = 20_000
_CORNERS_TOGETHER = 65_536
"""Supports of many solids take some kilobytes a corner."""
_LARGEST = 1e60
"""Solids with larger corners are lowered one by one: products of floats of them might overflow."""


class FlatSolid(PrimitiveSolid, abstract=True):
    """A solid inside flat faces, cut into convex parts. Walls of many are computed together, as `FlatWall`."""

    @abstractmethod
    def _boundary(self) -> tuple[str, str, Sequence[Any], Sequence[tuple[int, ...]]]:
        """Return the arguments of `_decompose_faces`."""

    @property
    @abstractmethod
    def _corners(self) -> FloatArray:
        """(n, 4) the corners x, y and z, each with a factor that x and y are still to be multiplied by."""

    @property
    def parts(self) -> FlatParts:
        """The planes and convex parts, which the constructor stores."""
        found: FlatParts | None = vars(self).get("_parts")
        return found or _decompose_faces(*self._boundary())

    @cached_property
    def _facets(self) -> list[tuple[int, tuple[int, ...]]]:
        """The plane and the corners of each flat piece of a face."""
        numbers = {_name(plane): k for k, plane in enumerate(self.parts.planes)}
        _, _, corners, faces = self._boundary()
        pieces = (piece for face in faces for piece in _flat_pieces(corners, face))
        return [(numbers[_name(plane)], piece) for piece, plane in pieces if plane is not None]

    def moved_planes(self, other: FlatSolid) -> dict[int, FlatPlane] | None:
        """Return the planes, by number, with a corner that `other` has moved; None if a piece then leaves its plane.

        `other` is the same solid with other numbers; its parts are not needed.
        """
        old, new = self._boundary()[2], other._boundary()[2]
        moved = {k for k, (a, b) in enumerate(zip(old, new, strict=True)) if a != b}
        touched = {number for number, piece in self._facets if not moved.isdisjoint(piece)}
        planes: dict[int, FlatPlane] = {}
        for number, piece in self._facets:
            if number in touched:
                plane = planes.get(number) or fit_plane([new[k] for k in piece])
                if plane is None or any(side_of_plane(plane, new[k]) for k in piece):
                    return None
                planes[number] = plane
        return planes

    @property
    def _near(self) -> Vector:
        """The point by which all planes are anchored: the first corner."""
        x, y, z, factor = self._corners[0].tolist()
        return factor * x, factor * y, z

    def planes(self) -> list[tuple[int, tuple[int, ...]]]:
        """Return for every plane (its face number, the faces that lie in it)."""
        return list(zip(self.parts.numbers, self.parts.members, strict=True))

    def tree(self) -> Tree:
        planes = [plane_through(plane.normal, plane.offset, self._near) for plane in self.parts.planes]
        uvs = list(map(plane_uv, planes))
        return self.parts.tree(lambda k: (planes[k], uvs[k]))

    def has_unbounded_outside(self, tree: Tree | None = None) -> bool:
        return len(self.parts.parts) == 1

    def support(self, direction: Vector) -> float:
        return CornerHull.of(self).support(direction)

    @cached_property
    def _corner_ranges(self) -> tuple[FloatArray, FloatArray]:
        """(n, 3) twice: the greatest floats not above the coordinates of the corners, and the least not below."""
        x, y, z, factor = self._corners.T
        if ((factor == 0.0) | (factor == 1.0)).all():
            exact = np.column_stack([x * factor, y * factor, z])
            return exact, exact
        corners = [(Fraction(s) * Fraction(x), Fraction(s) * Fraction(y), Fraction(z)) for x, y, z, s in self._corners]
        high = np.array([[_float_above(c) for c in corner] for corner in corners])
        return -np.array([[_float_above(-c) for c in corner] for corner in corners]), high

    @property
    def _face_count(self) -> int:
        return sum(map(len, self.parts.parts))

    @property
    def _hull(self) -> Shape:
        return self if self.walls is None else CornerHull.of(self)

    def wall(self, index: int) -> FlatWall:
        """Return the half-space on the lower side of the plane with this index, as a solid."""
        assert self.walls is not None
        row = self.walls[index].tolist()
        corners = tuple((row[k], row[k + 1], row[k + 2], row[k + 3]) for k in (0, 4, 8))
        return FlatWall(corners, (row[12], row[13], row[14]), (row[15], row[16], row[17]))

    @property
    def surfaces(self) -> list[PlaneSurface]:
        """The planes of all parts, one part after the other."""
        near, parts = self._near, self.parts
        planes = [plane_through(plane.normal, plane.offset, near) for plane in parts.planes]
        return [planes[k] for part in parts.parts for k, _ in part]

    @cached_property
    def _sides(self) -> list[tuple[Any, Any]]:
        """The normal and the offset of each of the `surfaces`."""
        return [self.parts.planes[k][:2] for part in self.parts.parts for k, _ in part]

    @cached_property
    def walls(self) -> FloatArray | None:
        """(planes, 18) the numbers of a `FlatWall` for each plane; None where floats do not find three corners."""
        return _walls_of([self])[0]


def learn_walls(solids: Sequence[FlatSolid]) -> None:
    """Let flat solids know their walls."""
    fresh = [solid for solid in solids if "walls" not in vars(solid)]
    if fresh:
        for solid, walls in zip(fresh, _walls_of(fresh), strict=True):
            vars(solid)["walls"] = walls


def _walls_of(solids: Sequence[FlatSolid]) -> list[FloatArray | None]:
    """Return `FlatSolid.walls` of each."""
    parts = [solid.parts for solid in solids]
    planes = [plane for each in parts for plane in each.planes]
    pieces = [piece for each in parts for piece in each.pieces]
    ends = np.cumsum([len(each.planes) for each in parts])[:-1]
    owners = np.repeat(np.arange(len(parts)), [len(each.planes) for each in parts])
    corners = np.concatenate([solid._corners for solid in solids])
    first = np.cumsum([0, *(len(solid._corners) for solid in solids)])[:-1]
    about, lengths = np.array([plane.about[:3] for plane in planes]), np.array(list(map(len, pieces)))
    three, is_sure = np.empty((len(planes), 3), np.int64), np.empty(len(planes), bool)
    # Solids with larger corners are not sure, whatever overflows
    with np.errstate(all="ignore"):
        points = np.column_stack([corners[:, 3:] * corners[:, :2], corners[:, 2]])
        near = points[first[owners]]
        for length in unique_sorted(lengths).tolist():
            some = np.flatnonzero(lengths == length)
            loops = np.array([pieces[k] for k in some.tolist()]) + first[owners[some], None]
            three[some], is_sure[some] = _corners_of_planes(loops, near[some], about[some], points)
    leads = np.abs(about) == 1.0
    for k in np.flatnonzero(leads.sum(axis=1) > 1).tolist():
        leads[k] = [abs(c) == 1 for c in planes[k].normal]  # others may be rounded to 1
    lead = np.where(np.arange(3) == leads.argmax(axis=1)[:, None], about, 0.0)
    rows = np.split(np.concatenate([corners[three].reshape(-1, 12), lead, near], axis=1), ends)
    is_large = ~(np.maximum.reduceat(np.abs(corners).max(axis=1), first) < _LARGEST)
    unsure = is_large | (np.bincount(owners[~is_sure], minlength=len(parts)) > 0)
    return [None if none else own.copy() for own, none in zip(rows, unsure.tolist(), strict=True)]


def _corners_of_planes(
    pieces: IndexArray, near: FloatArray, normals: FloatArray, points: FloatArray
) -> tuple[IndexArray, npt.NDArray[np.bool_]]:
    """Return three corners of flat polygons, counter-clockwise about their normals, and whether floats are sure.

    `pieces` (n, m) are the numbers of the corners among `points`. The first of the three is `near` if the polygon has
    that corner, else its own first.
    """
    every, count = np.arange(len(pieces)), pieces.shape[1]
    first = (points[pieces] == near[:, None]).all(axis=2).argmax(axis=1)
    pieces = pieces[every[:, None], (first[:, None] + np.arange(count)) % count]
    if count == 3:
        return pieces, np.ones(len(pieces), bool)
    start = points[pieces[:, 0]]
    spokes = points[pieces[:, 1:]] - start[:, None]
    (x, y, z), (u, v, w) = np.moveaxis(spokes[:, :-1], 2, 0), np.moveaxis(spokes[:, 1:], 2, 0)
    n, m, p = normals.T[:, :, None]
    areas = n * (y * w - z * v) + m * (z * u - x * w) + p * (x * v - y * u)
    best = np.abs(areas).argmax(axis=1)
    area, size = areas[every, best], np.abs(spokes).max(axis=(1, 2))
    is_sure = np.abs(area) > SIGN_MARGIN * size * np.maximum(size, np.abs(start).max(axis=1))
    second, third = pieces[every, 1 + best], pieces[every, 2 + best]
    is_left = area > 0
    return np.column_stack([pieces[:, 0], np.where(is_left, second, third), np.where(is_left, third, second)]), is_sure


@dataclass(frozen=True)
class FlatWall(HalfOfSpace, abstract=True):
    """The half-space behind three corners, without bounds: the walls of many flat solids are computed together.

    `corners` are as of `FlatSolid`. The normal is divided by its size along `lead`, the axis along which it is largest.
    """

    corners: tuple[tuple[float, float, float, float], ...]
    lead: Vector
    near: Vector
    """The point by which the wall is anchored. If it is in the plane it is the first corner."""

    def tree(self) -> Cell:
        corners = [
            (ex.rational(s) * ex.rational(x), ex.rational(s) * ex.rational(y), ex.rational(z))
            for x, y, z, s in self.corners
        ]
        across, near = newell_normal(corners), tuple(map(ex.rational, self.near))
        lead, others = (tuple(map(ex.rational, row)) for row in (self.lead, [1.0 - c * c for c in self.lead]))
        size = dot3(across, lead)
        # The largest entry is 1 or -1, exactly: the quotient counts for the other two
        n: Any = tuple(own + rest * (c / size) for own, rest, c in zip(lead, others, across, strict=True))
        above = dot3(n, minus(corners[0], near)) / dot3(n, n)
        anchor: Any = tuple(p + above * c for p, c in zip(near, n, strict=True))
        # Nothing is rounded in the anchor of a wall across an axis, or where it is `near`, as the first corner
        x, y, z, s = self.corners[0]
        aside = count_nonzero([s * x - self.near[0], s * y - self.near[1], z - self.near[2]])
        is_rounded = bool(aside) and count_nonzero([ex.rounded(c) for c in n]) > 1
        surface = PlaneSurface(n, dot3(n, corners[0]), anchor, 0.0, is_offset_better=bool(is_rounded))
        return Cell((Face(surface, 0, plane_uv(surface)),))


@dataclass(frozen=True)
class CornerHull(PrimitiveSolid, abstract=True):
    """The corners of a flat solid without its faces: boxes and frames of many are computed together."""

    if TYPE_CHECKING:
        solid: ClassVar[FlatSolid]

    @classmethod
    def of(cls, solid: FlatSolid) -> CornerHull:
        """Return the hull of a solid; the solid is no field, so that hulls of all solids are alike."""
        hull = cls()
        object.__setattr__(hull, "solid", solid)
        return hull

    def tree(self) -> Cell:
        return Cell(())

    @property
    def _has_batch_support(self) -> bool:
        return True

    def support(self, direction: Vector) -> float:
        return float(self._supports([self], np.array([[direction]]))[0, 0])

    @classmethod
    def _supports(cls, shapes: Sequence[Any], directions: FloatArray) -> FloatArray:
        ranges = [hull.solid._corner_ranges for hull in shapes]
        counts = np.array([len(low) for low, _ in ranges])
        supports = np.empty(directions.shape[:2])
        for count in unique_sorted(counts).tolist():
            like = np.flatnonzero(counts == count)
            for some in np.array_split(like, 1 + len(like) * count // _CORNERS_TOGETHER):
                low, high = (np.array([ranges[k][side] for k in some.tolist()])[:, None] for side in (0, 1))
                u = directions[some, :, None]
                supports[some] = raised_sums(np.where(u > 0, u * high, u * low)).max(axis=2)
        return supports


@dataclass(frozen=True)
class Mesh(FlatSolid):
    """The solid inside a closed surface of flat faces; it may be concave, have holes, or be in several pieces.

    faces[i] are the indices of its corners among `vertices`, three or more, in the same sense for all, so that each
    edge belongs to two faces that run along it in opposite senses. A face of more than three corners that is not flat
    in the numbers as written is cut into triangles and stays one face. Exact fractions split the solid into convex
    parts. The solid is where the winding number is above 0: pieces that overlap are united, and a piece turned inside
    out is a hole. Walls within the union are none.
    Faces: i is face i; faces in one plane have the number of the first. uv: Cartesian coordinates on the plane as of
    `HalfSpace`.

    Raises ValueError if the faces do not close or enclose nothing.
    """

    vertices: tuple[Vector, ...]
    faces: tuple[tuple[int, ...], ...]

    def __post_init__(self) -> None:
        vertices = check_vectors("Mesh", "vertices", self.vertices, 4)
        vars(self).update(vertices=vertices, faces=_check_faces(self.faces, len(vertices)))
        _check_closed(vertices, self.faces)
        object.__setattr__(self, "_parts", _decompose_faces(*self._boundary()))

    @property
    def _pieces_overlap(self) -> bool:
        """Whether the winding number is neither 0 nor 1 somewhere."""
        return self.parts.overlap

    def _boundary(self) -> tuple[str, str, Sequence[Any], Sequence[tuple[int, ...]]]:
        """Return the arguments of `_decompose_faces`."""
        corners = [tuple(map(ex.rational, vertex)) for vertex in self.vertices]
        return "Mesh", "vertices and faces", corners, self.faces

    @cached_property
    def _corners(self) -> FloatArray:
        return np.column_stack([np.array(self.vertices), np.ones(len(self.vertices))])


@dataclass(frozen=True)
class Extrusion(FlatSolid):
    """A polygon in the plane of x and y, drawn along z from low to high; it may be concave.

    `outline` are its corners (x, y), in either sense; it must not cross itself. `z_range` is (low, high), both finite.
    `scale_at_top` is how much larger it is at the high end, about the z axis: 0 makes a pyramid's tip.
    Faces: i is the side from corner i to the next, then bottom and top; sides in one plane have the first one's
    number. uv: Cartesian coordinates on the plane as of `HalfSpace`. Holes are cut by others:
    ``Extrusion(outer, ...) - Extrusion(inner, ...)``.

    Raises ValueError for an outline that crosses or touches itself or has no area.
    """

    outline: tuple[tuple[float, float], ...]
    z_range: Interval = (0.0, 1.0)
    scale_at_top: float = 1.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "outline", check_outline("Extrusion", "outline", self.outline))
        z_range = check_interval("Extrusion", "z_range", self.z_range)
        if z_range is None or not all(map(math.isfinite, z_range)):
            raise ValueError(f"Extrusion: z_range must be two finite numbers, got {format_value(self.z_range)}")
        object.__setattr__(self, "z_range", z_range)
        top = check_number("Extrusion", "scale_at_top", self.scale_at_top)
        if top < 0:
            raise ValueError(f"Extrusion: scale_at_top must be >= 0, got {top:g}")
        object.__setattr__(self, "scale_at_top", top)
        check_simple("Extrusion", "outline", self.outline)
        object.__setattr__(self, "_parts", _decompose_faces(*self._boundary()))

    def _boundary(self) -> tuple[str, str, Sequence[Any], Sequence[tuple[int, ...]]]:
        """Return the arguments of `_decompose_faces`: corners in fractions, and the sides, bottom and top as faces."""
        flat = [(ex.rational(x), ex.rational(y)) for x, y in self.outline]
        low, high = map(ex.rational, self.z_range)
        count, s = len(flat), ex.rational(self.scale_at_top)
        corners = [(x, y, low) for x, y in flat] + [(s * x, s * y, high) for x, y in flat]
        loop = list(range(count))
        sides = [(k, (k + 1) % count, count + (k + 1) % count, count + k) for k in loop]
        faces = [*sides, tuple(reversed(loop)), tuple(count + k for k in loop)]
        return "Extrusion", "outline", corners, faces

    @cached_property
    def _corners(self) -> FloatArray:
        ends = zip(self.z_range, (1.0, self.scale_at_top), strict=True)
        return np.array([(x, y, *end) for end in ends for x, y in self.outline])


def _float_above(value: Fraction) -> float:
    """Return the least float that is not below a fraction."""
    near = float(value)
    return near if Fraction(near) >= value else math.nextafter(near, math.inf)


@dataclass(frozen=True)
class FlatParts:
    """The planes of a solid: each with its face number, the faces in it, and the corners of a piece of one of them.

    And the convex parts between the planes, each by its sides in the order of their face numbers.
    """

    planes: tuple[FlatPlane, ...]
    numbers: tuple[int, ...]
    members: tuple[tuple[int, ...], ...]
    pieces: tuple[tuple[int, ...], ...]
    parts: tuple[tuple[PlaneSide, ...], ...]
    overlap: bool

    def tree(self, of: Callable[[int], tuple[Any, UV]]) -> Tree:
        """Return the convex part, or the union of several; `of` gives the surface and uv map of a plane."""
        cells = []
        for part in self.parts:
            faces = []
            for k, sense in part:
                surface, uv = of(k)
                faces.append(Face(surface, self.numbers[k], uv, sense))
            cells.append(Cell(tuple(faces)))
        return cells[0] if len(cells) == 1 else Any_(tuple(cells))


def _decompose_faces(owner: str, what: str, corners: Sequence[Any], faces: Sequence[tuple[int, ...]]) -> FlatParts:
    """Return the planes and convex parts of the solid inside faces; `owner` and `what` are for messages."""
    planes: list[FlatPlane] = []
    numbers: list[int] = []
    members: list[list[int]] = []
    pieces: list[tuple[int, ...]] = []
    named: dict[Any, int] = {}
    facets = []
    for index, face in enumerate(faces):
        for piece, plane in _flat_pieces(corners, face):
            if plane is None:
                continue  # a sliver without area bounds nothing
            key = _name(plane)
            if key not in named:
                named[key] = len(planes)
                planes.append(plane)
                numbers.append(index)
                members.append([])
                pieces.append(piece)
            members[named[key]].append(index)
            facets.append(Facet(named[key], tuple(corners[k] for k in piece)))
    volume = _six_volumes([facet.corners for facet in facets])
    if not volume:
        raise ValueError(f"{owner}: {what} must enclose a volume, got none")
    if volume < 0:
        facets = [Facet(facet.plane, tuple(reversed(facet.corners))) for facet in facets]
    try:
        parts, overlap = convex_parts(planes, facets, MAX_MESH_PARTS)
    except ValueError as error:
        raise ValueError(f"{owner}: {error}") from None
    ordered = (tuple(sorted(part, key=lambda side: numbers[side[0]])) for part in parts)
    named_faces = tuple(map(tuple, members))
    return FlatParts(tuple(planes), tuple(numbers), named_faces, tuple(pieces), tuple(ordered), overlap)


def _flat_pieces(points: Sequence[Any], face: tuple[int, ...]) -> list[tuple[tuple[int, ...], FlatPlane | None]]:
    """Return a flat face as it is, any other as triangles about its first corner; each with its plane."""
    corners = [points[k] for k in face]
    plane = fit_plane(corners)
    if len(face) == 3 or plane is None or all(side_of_plane(plane, corner) == 0 for corner in corners):
        return [(face, plane)]
    triangles = [(face[0], a, b) for a, b in itertools.pairwise(face[1:])]
    return [(triangle, fit_plane([points[k] for k in triangle])) for triangle in triangles]


def _name(plane: FlatPlane) -> Any:
    """Return a key that is the same for equal planes, whatever their sense."""
    lead = next(c for c in plane.normal if c)
    return tuple(c / lead for c in (*plane.normal, plane.offset))


def _six_volumes(polygons: Sequence[Sequence[Any]]) -> int:
    """Return a positive multiple of the signed volume that polygons in fractions enclose."""
    whole = iter(integer_row([c for corners in polygons for corner in corners for c in corner]))
    total = 0
    for corners in polygons:
        (x, y, z), *others = [(next(whole), next(whole), next(whole)) for _ in corners]
        for b, c in itertools.pairwise(others):
            total += x * (b[1] * c[2] - b[2] * c[1]) + y * (b[2] * c[0] - b[0] * c[2]) + z * (b[0] * c[1] - b[1] * c[0])
    return total


def _check_faces(faces: Any, count: int) -> tuple[tuple[int, ...], ...]:
    checked = []
    try:
        rows = [list(face) for face in faces]
    except TypeError:
        raise ValueError("Mesh: faces must be lists of numbers of vertices") from None
    if not 4 <= len(rows) <= MAX_MESH_FACES:
        raise ValueError(f"Mesh: faces must be from 4 to {MAX_MESH_FACES:,}, got {len(rows):,}")
    for i, row in enumerate(rows):
        corners = [as_integer(k) for k in row]
        if len(corners) < 3 or not all(k is not None and 0 <= k < count for k in corners):
            expected = f"three or more numbers of vertices from 0 to {count - 1}"
            raise ValueError(f"Mesh: faces[{i}] must be {expected}, got {row!s:.60}")
        checked.append(tuple(int(k) for k in corners if k is not None))
    return tuple(checked)


def _check_closed(vertices: Sequence[Vector], faces: Sequence[tuple[int, ...]]) -> None:
    """Raise ValueError unless every edge occurs equally often in both senses; vertices in one place count as one."""
    place: dict[Vector, int] = {}
    same = [place.setdefault(vertex, k) for k, vertex in enumerate(vertices)]
    edges: Counter[tuple[int, int]] = Counter()
    for face in faces:
        corners = [same[k] for k in face]
        edges.update((a, b) for a, b in zip(corners, [*corners[1:], corners[0]], strict=True) if a != b)
    for (a, b), count in edges.items():
        if edges[b, a] != count:
            expected = f"with each edge in two faces of opposite sense: vertices {a} and {b} are no such edge"
            raise ValueError(f"Mesh: faces must close, {expected}")
