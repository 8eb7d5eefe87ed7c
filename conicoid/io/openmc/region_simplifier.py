"""Intersections of half-spaces and unions, without the parts that say nothing new.

A pin in a lattice is the intersection of its cell, the lattice element, and the cells around the lattice: a
dozen half-spaces or more, of which two or three matter. A part is left out only where the others
imply it, as fractions show; an intersection of which fractions show that it has no volume is None.
Which parts are left never changes a point's cell, except on the surface of a part left out.

Why it is right to test one part after another: every end of `extent` is that of a part that is kept, or beyond it, so
that it is a box around these parts. A round part whose bounds are an end of the box cannot contain the box, so it does
not vanish by its own help, nor does a union that ends before the box. A round part that lies strictly within another
or beyond a plane ends before it, and the box with it; and if the first vanishes in turn, because the box or a third
part lies within it, these lie within the others too.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property, reduce
from typing import TypeAlias

from ...geometry.csg import Complement, Difference, Intersection, Union
from ...geometry.general_quadric import Quadric
from ...geometry.polyhedron import Polyhedron
from ...geometry.primitives import Box, HalfSpace
from ...geometry.shape import Solid
from ...geometry.transform import Motion
from .placement import UNBOUNDED, Extent, Point, UniversePlacement
from .region import HalfSpaceNode, IntersectionNode, Region
from .surfaces import CurvedSurface, FlatSurface, RoundSurface, Surface

MAX_PAIRS = 20_000
"""Pairs of parts that are compared with each other; beyond, superfluous ones just stay."""


@dataclass(frozen=True, slots=True)
class SurfaceSide:
    """One closed side of a plane, the solid side of a curved surface, or the open outer one."""

    surface: Surface
    positive: bool

    def of(self, extent: Extent) -> int:
        """-1 where all of the extent is on this side, +1 where none of it is (but for its surface), else 0."""
        side = self.surface.side_of(extent)
        return -side if self.positive else side


@dataclass(frozen=True, slots=True)
class PartIntersection:
    """In every part."""

    parts: tuple[RegionPart, ...]


@dataclass(frozen=True, slots=True)
class PartUnion:
    """In at least one part."""

    parts: tuple[RegionPart, ...]


RegionPart: TypeAlias = SurfaceSide | PartIntersection | PartUnion


def bind_surfaces(region: Region, surfaces: Mapping[int, Surface]) -> RegionPart:
    """The region with surfaces in the place of their numbers."""
    if isinstance(region, HalfSpaceNode):
        return SurfaceSide(surfaces[region.surface], region.positive)
    kind = PartIntersection if isinstance(region, IntersectionNode) else PartUnion
    return kind(tuple(bind_surfaces(part, surfaces) for part in region.parts))


def move_part(part: RegionPart, place: UniversePlacement) -> RegionPart:
    """A part elsewhere."""
    if isinstance(part, SurfaceSide):
        return SurfaceSide(part.surface.placed(place), part.positive)
    return type(part)(tuple(move_part(piece, place) for piece in part.parts))


@dataclass(frozen=True)
class Conjunction:
    """In every part; `extent` is a box around that."""

    parts: tuple[RegionPart, ...] = ()
    extent: Extent = UNBOUNDED

    def and_(self, parts: Iterable[RegionPart], extent: Extent = UNBOUNDED) -> Conjunction | None:
        """With further parts, which may be known to lie in an extent; None where nothing is left."""
        sides, unions = _split_parts((*self.parts, *parts))
        box = self.extent.common(extent)
        box = reduce(Extent.common, (side.surface.extent(side.positive) for side in sides), box)
        if box.is_empty or _are_disjoint(sides):
            return None
        apart = _drop_paired_sides(sides)
        kept = None if apart is None else _drop_implied_curved(_drop_idle_planes(apart, unions, box), box)
        if kept is None:
            return None
        left = [restrict_part(union, box) for union in unions]
        if False in left:
            return None
        branches = [part for part in left if not isinstance(part, bool)]
        still = tuple(part for part in branches if isinstance(part, PartUnion))
        result = Conjunction((*kept, *still), box)
        opened = [part for part in branches if not isinstance(part, PartUnion)]
        return result.and_(opened) if opened else result

    def inside(self, box: Extent) -> Conjunction | None:
        """What is left to ask of points in a box; None where none of them is in."""
        left = [restrict_part(part, box) for part in self.parts]
        if False in left:
            return None
        if len(left) and all(part is own for part, own in zip(left, self.parts, strict=True)):
            return self
        return Conjunction().and_(part for part in left if not isinstance(part, bool))

    def moved(self, shift: Point) -> Conjunction:
        """The same elsewhere."""
        place = UniversePlacement(shift=shift)
        return Conjunction(tuple(move_part(part, place) for part in self.parts), self.extent.placed(place))

    @cached_property
    def size(self) -> int:
        """How many sides it has."""
        return sum(map(count_sides, self.parts))

    @cached_property
    def rounds(self) -> int:
        """How many of its parts are the insides of round solids, with which others are compared."""
        return sum(map(_is_round, self.parts))


def count_sides(part: RegionPart) -> int:
    """How many sides a part has."""
    return 1 if isinstance(part, SurfaceSide) else sum(map(count_sides, part.parts))


def _is_round(part: RegionPart) -> bool:
    return isinstance(part, SurfaceSide) and isinstance(part.surface, RoundSurface) and not part.positive


def pair_cost(before: Conjunction, parts: Iterable[RegionPart]) -> int:
    """How many sides and pairs of sides `before.and_(parts)` looks at, at most."""
    size, rounds = before.size, before.rounds
    for part in parts:
        size += count_sides(part)
        rounds += sum(map(_is_round, part.parts)) if isinstance(part, PartIntersection) else _is_round(part)
    return size + min(size * rounds, MAX_PAIRS)


def _are_disjoint(sides: list[SurfaceSide]) -> bool:
    """Whether two sides have no volume in common: the two of one surface, or those of parallel slanted planes."""
    found: dict[Surface, bool] = {}
    ends: dict[tuple[Point, bool], Fraction] = {}
    for side in sides:
        plane = side.surface
        if found.setdefault(plane, side.positive) != side.positive:
            return True
        if isinstance(plane, FlatSurface) and plane.axis is None:
            first = next(n for n in plane.normal if n)
            x, y, z = (n / first for n in plane.normal)
            normal, offset, above = (x, y, z), plane.offset / first, side.positive == (first > 0)
            end = ends.setdefault((normal, above), offset)
            ends[normal, above] = max(end, offset) if above else min(end, offset)
    return any(above and low >= ends.get((normal, False), low + 1) for (normal, above), low in ends.items())


def _split_parts(parts: Iterable[RegionPart]) -> tuple[list[SurfaceSide], list[PartUnion]]:
    """Sides, each once, and unions."""
    sides: dict[tuple[Surface, bool], SurfaceSide] = {}
    unions: dict[int, PartUnion] = {}
    pending = list(reversed(tuple(parts)))
    while pending:
        part = pending.pop()
        if isinstance(part, SurfaceSide):
            sides.setdefault((part.surface, part.positive), part)
        elif isinstance(part, PartIntersection):
            pending.extend(reversed(part.parts))
        else:
            unions[id(part)] = part
    return list(sides.values()), list(unions.values())


def _drop_implied_curved(sides: list[SurfaceSide], box: Extent) -> list[SurfaceSide] | None:
    """Without the curved sides that all of the box is on; None where it is all beyond some side."""
    kept = []
    for side in sides:
        relation = side.of(box)
        if relation > 0:
            return None
        if relation == 0 or isinstance(side.surface, FlatSurface):
            kept.append(side)
    return kept


def _drop_idle_planes(sides: list[SurfaceSide], unions: list[PartUnion], box: Extent) -> list[SurfaceSide]:
    """Without the planes across an axis that are no end of the box, or lie beyond a union; each end is kept once."""
    kept: list[SurfaceSide] = []
    ends: set[tuple[int, bool]] = set()
    around = [_part_extent(union) for union in unions]
    for side in sides:
        plane = side.surface
        axis = plane.axis if isinstance(plane, FlatSurface) else None
        if axis is None or not isinstance(plane, FlatSurface):
            kept.append(side)
            continue
        above = side.positive == (plane.normal[axis] > 0)
        end = plane.offset / plane.normal[axis]
        if any(_lies_beyond(end, axis, above, extent) for extent in around) or (axis, above) in ends:
            continue
        if end == box.end(axis, above):
            ends.add((axis, above))
            kept.append(side)
    return kept


def _lies_beyond(end: Fraction, axis: int, above: bool, extent: Extent) -> bool:
    """Whether all of an extent is strictly on the inner side of an end."""
    own = extent.end(axis, above)
    return own is not None and (own > end if above else own < end)


def _part_extent(part: RegionPart) -> Extent:
    """A box around a part."""
    if isinstance(part, SurfaceSide):
        return part.surface.extent(part.positive)
    return reduce(Extent.common if isinstance(part, PartIntersection) else Extent.around, map(_part_extent, part.parts))


def _drop_paired_sides(sides: list[SurfaceSide]) -> list[SurfaceSide] | None:
    """Without the sides that a single round solid implies; None where two exclude each other."""
    rounds = [side for side in sides if isinstance(side.surface, RoundSurface) and not side.positive]
    if len(rounds) * len(sides) > MAX_PAIRS:
        return sides
    implied: set[int] = set()
    for solid in rounds:
        if id(solid) in implied:
            continue
        for side in sides:
            if side is solid or id(side) in implied:
                continue
            relation = _relation(solid.surface, side)  # type: ignore[arg-type]
            if relation > 0:
                return None
            if relation < 0:
                implied.add(id(side))
    return [side for side in sides if id(side) not in implied]


def _relation(solid: RoundSurface, side: SurfaceSide) -> int:
    """-1 where all of a round solid is on a side, +1 where none of it is, else 0."""
    other = side.surface
    if isinstance(other, FlatSurface):
        relation = solid.side_of_plane(other)
    elif isinstance(other, RoundSurface):
        relation = -1 if solid.is_within(other) else int(solid.is_apart(other))
    else:
        relation = 0
    return -relation if side.positive else relation


def restrict_part(part: RegionPart, box: Extent) -> RegionPart | bool:
    """What is left to ask of a part for points in the box: nothing (True), or it has none of them (False)."""
    if isinstance(part, SurfaceSide):
        relation = part.of(box)
        return part if relation == 0 else relation < 0
    decisive = isinstance(part, PartUnion)
    left = []
    for piece in (restrict_part(inner, box) for inner in part.parts):
        if piece is decisive:
            return decisive
        if not isinstance(piece, bool):
            left.append(piece)
    if not left:
        return not decisive
    return left[0] if len(left) == 1 else type(part)(tuple(left))


# From intersections of sides to shapes: planes become one box or polyhedron, outer sides are subtracted.

WHOLE_SPACE = Quadric(coefficients={"xx": -1.0, "constant": -1.0})


@dataclass
class SolidBuilder:
    """Makes solids; equal curved surfaces and equal sets of planes share one shape."""

    curved: dict[CurvedSurface, Solid] = field(default_factory=dict)
    convex: dict[tuple[HalfSpace, ...], Solid] = field(default_factory=dict)
    checked: set[Motion] = field(default_factory=set)

    def solid(self, groups: Iterable[tuple[Motion, tuple[RegionPart, ...]]]) -> Solid:
        """In every part of every group, each group moved as a whole. Raises ValueError for numbers out of range."""
        moved = []
        for motion, parts in groups:
            if parts:
                whole = self.intersection(parts)
                moved.append(whole if motion.is_identity else self._moved(whole, motion))
        if not moved:
            return WHOLE_SPACE
        return moved[0] if len(moved) == 1 else Intersection(tuple(moved))

    def _moved(self, whole: Solid, motion: Motion) -> Solid:
        both = whole.motion.then(motion)
        if both not in self.checked:
            both.check("rotation and translation")
            self.checked.add(both)
        return replace(whole, motion=both)

    def intersection(self, parts: tuple[RegionPart, ...]) -> Solid:
        planes: list[HalfSpace] = []
        inside: list[Solid] = []
        outside: list[Solid] = []
        for part in parts:
            if not isinstance(part, SurfaceSide):
                beyond = _planes_beyond(part)
                if beyond:
                    outside.append(self.polyhedron(beyond))
                else:
                    inside.append(self.union(part))
            elif isinstance(part.surface, FlatSurface):
                planes.append(part.surface.solid(part.positive))
            else:
                (outside if part.positive else inside).append(self._curved(part.surface))
        if planes:
            inside.append(self.polyhedron(tuple(planes)))
        if not inside:
            return Complement(outside[0] if len(outside) == 1 else Union(tuple(outside)))
        whole = inside[0] if len(inside) == 1 else Intersection(tuple(inside))
        return Difference((whole, *outside)) if outside else whole

    def union(self, part: RegionPart) -> Solid:
        if isinstance(part, (SurfaceSide, PartIntersection)):
            return self.intersection((part,) if isinstance(part, SurfaceSide) else part.parts)
        return Union(tuple(self.union(piece) for piece in part.parts))

    def polyhedron(self, planes: tuple[HalfSpace, ...]) -> Solid:
        """The common part of half-spaces."""
        if planes not in self.convex:
            self.convex[planes] = _convex_solid(planes)
        return self.convex[planes]

    def _curved(self, surface: CurvedSurface) -> Solid:
        if surface not in self.curved:
            self.curved[surface] = surface.solid()
        return self.curved[surface]


def _planes_beyond(union: RegionPart) -> tuple[HalfSpace, ...]:
    """The planes of a polyhedron whose outside the union is, empty where it is none."""
    planes = []
    for piece in () if isinstance(union, SurfaceSide) else union.parts:
        if not isinstance(piece, SurfaceSide) or not isinstance(piece.surface, FlatSurface):
            return ()
        planes.append(piece.surface.solid(not piece.positive))
    return tuple(planes)


def _convex_solid(planes: tuple[HalfSpace, ...]) -> Solid:
    """One plane as it is; six across the axes as a box; else a polyhedron."""
    if len(planes) == 1:
        return planes[0]
    ends = {plane.normal: plane.offset for plane in planes}
    if len(planes) == len(ends) == 6 and set(ends) == set(_UP + _DOWN):
        x, y, z = (-ends[normal] + 0.0 for normal in _DOWN)
        a, b, c = (ends[normal] for normal in _UP)
        if x < a and y < b and z < c:
            return Box((x, y, z), (a, b, c))
    return Polyhedron(tuple(plane.normal for plane in planes), tuple(plane.offset for plane in planes))


_UP = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
_DOWN = ((-1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, -1.0))
