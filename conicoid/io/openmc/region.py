"""Simplification of regions: intersections of half-spaces and unions without redundant parts, and their solids.

A pin in a lattice is the intersection of its cell, the lattice element, and the cells around the lattice: a dozen
half-spaces or more, but only two or three matter. A part is left out only if fractions show that the others imply it;
an intersection that fractions show to have no volume is None. Leaving parts out never changes the cell of a point,
except on the surface of such a part.

Parts may be tested one after another, because every end of `extent` is the end of a part that stays, or lies beyond
it: the extent is always a box around the remaining parts. A round part whose bounds are an end of the box cannot
contain the box, so it is not dropped because of its own bounds, nor is a union that ends before the box. A round part
strictly within another one, or beyond a plane, ends before it, and so does the box; if this round part is dropped in
turn, because the box or a third part lies within it, then these lie within the others too.

`SolidBuilder` at the end turns simplified intersections into shapes.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping
from dataclasses import field, replace
from fractions import Fraction
from functools import cached_property, reduce
from typing import Any, NamedTuple, TypeAlias

from ..._util.records import dataclass
from ...geometry.general_quadric import Quadric
from ...geometry.polyhedron import Polyhedron
from ...geometry.primitives import Box, HalfSpace
from ...geometry.shape import Complement, Difference, Intersection, Solid, Union
from ...geometry.transform import Motion
from .placement import UNBOUNDED, Extent, Point, UniversePlacement
from .region_expression import HalfSpaceNode, IntersectionNode, Region
from .surfaces import CurvedSurface, FlatSurface, GeneralSurface, RoundSurface, Surface

MAX_PAIRS = 20_000
"""Most pairs of parts that are compared; beyond this number redundant parts stay, which is slower but correct."""


class SurfaceSide(NamedTuple):
    """One closed side of a plane, the solid side of a curved surface, or the open outer one."""

    surface: Surface
    positive: bool

    def of(self, extent: Extent) -> int:
        """Return -1 if all of the extent is on this side, +1 if none is (except its surface), else 0 (not known)."""
        side = self.surface.side_of(extent)
        return -side if self.positive else side


@dataclasses.dataclass(frozen=True, slots=True)
class PartIntersection:
    """The points that are in every part."""

    parts: tuple[RegionPart, ...]


@dataclasses.dataclass(frozen=True, slots=True)
class PartUnion:
    """The points that are in at least one part."""

    parts: tuple[RegionPart, ...]


RegionPart: TypeAlias = SurfaceSide | PartIntersection | PartUnion


def bind_surfaces(
    region: Region, surfaces: Mapping[int, Surface], known: dict[int, tuple[Region, RegionPart]] | None = None
) -> RegionPart:
    """Return a region with surfaces in place of their numbers.

    `known` holds the results by the identity of their regions, which it keeps: one part in many places stays one.
    """
    found = None if known is None else known.get(id(region))
    if found is not None:
        return found[1]
    if isinstance(region, HalfSpaceNode):
        result: RegionPart = SurfaceSide(surfaces[region.surface], region.positive)
    else:
        kind = PartIntersection if isinstance(region, IntersectionNode) else PartUnion
        result = kind(tuple(bind_surfaces(part, surfaces, known) for part in region.parts))
    if known is not None:
        known[id(region)] = region, result
    return result


class PlacedSurfaces(dict[Any, Surface]):
    """Surfaces, or those of these numbers, after the turn and the shift of a placement: each moved at its first use."""

    def __init__(self, place: UniversePlacement, numbered: Mapping[int, Surface] | None = None) -> None:
        super().__init__()
        self.place, self.numbered = place, numbered

    def __missing__(self, surface: Any) -> Surface:
        unmoved = surface if self.numbered is None else self.numbered[surface]
        self[surface] = unmoved.placed(self.place)
        return self[surface]

    def move(self, part: RegionPart) -> RegionPart:
        """Return a part after the placement."""
        if isinstance(part, SurfaceSide):
            surface = self[part.surface]
            return part if surface is part.surface else SurfaceSide(surface, part.positive)
        return type(part)(tuple(map(self.move, part.parts)))


@dataclass(frozen=True)
class Conjunction:
    """The intersection of parts; `extent` is a box around it."""

    parts: tuple[RegionPart, ...] = ()
    extent: Extent = field(default=UNBOUNDED, hash=False)

    def and_(self, parts: Iterable[RegionPart], extent: Extent = UNBOUNDED) -> Conjunction | None:
        """Return the intersection with further parts, without redundant parts; None if nothing is left.

        The caller may know an extent that contains the further parts.
        """
        sides, unions = _split_parts((*self.parts, *parts))
        box = self.extent.common(extent)
        # The sides of this intersection come first, and its extent is within theirs
        for side in sides[sum(isinstance(part, SurfaceSide) for part in self.parts) :]:
            box = box.common(side.surface.extent(side.positive))
        # Cheap tests first: most places of a cut lattice are empty, or keep all of the pin
        if box.is_empty or _are_disjoint(sides):
            return None
        unpaired = _drop_paired_sides(sides)
        needed = None if unpaired is None else _drop_implied_curved(_drop_idle_planes(unpaired, unions, box), box)
        if needed is None:
            return None
        known: dict[int, RegionPart | bool] = {}
        restricted = [restrict_part(union, box, known) for union in unions]
        if False in restricted:
            return None
        branches = [part for part in restricted if not isinstance(part, bool)]
        still_unions = tuple(part for part in branches if isinstance(part, PartUnion))
        result = Conjunction((*needed, *still_unions), box)
        # A union with one branch left is a part of the intersection, which it may narrow further.
        opened = [part for part in branches if not isinstance(part, PartUnion)]
        return result.and_(opened) if opened else result

    def inside(self, box: Extent) -> Conjunction | None:
        """Return the parts that decide whether a point of the box is inside; None if no point of it is."""
        restricted = [restrict_part(part, box) for part in self.parts]
        if False in restricted:
            return None
        # The same object, so that equal places are found by identity and share a block
        if len(restricted) and all(part is own for part, own in zip(restricted, self.parts, strict=True)):
            return self
        return Conjunction().and_(part for part in restricted if not isinstance(part, bool))

    @cached_property
    def tight_extent(self) -> Extent:
        """The extent, with the ends that slanted planes and round walls set where it has none."""
        if None not in (*self.extent.low, *self.extent.high):
            return self.extent
        planes = []
        for part in self.parts:
            if isinstance(part, SurfaceSide) and isinstance(part.surface, FlatSurface):
                (x, y, z), offset = part.surface.normal, part.surface.offset
                planes.append(((-x, -y, -z), -offset) if part.positive else ((x, y, z), offset))
            elif isinstance(part, SurfaceSide) and isinstance(part.surface, GeneralSurface) and not part.positive:
                planes += part.surface.planes_around
        return self.extent.within(planes)

    def moved(self, shift: Point) -> Conjunction:
        """Return the intersection translated by `shift`."""
        place = UniversePlacement(shift=shift)
        return Conjunction(tuple(map(PlacedSurfaces(place).move, self.parts)), self.extent.placed(place))

    @cached_property
    def size(self) -> int:
        """The number of sides."""
        return sum(map(count_sides, self.parts))

    @cached_property
    def rounds(self) -> int:
        """The number of parts that are insides of round solids, with which other parts are compared."""
        return sum(map(_is_round, self.parts))


def count_sides(part: RegionPart) -> int:
    """Return the number of sides of a part."""
    return 1 if isinstance(part, SurfaceSide) else sum(map(count_sides, part.parts))


def _is_round(part: RegionPart) -> bool:
    return isinstance(part, SurfaceSide) and isinstance(part.surface, RoundSurface) and not part.positive


def pair_cost(before: Conjunction, parts: Iterable[RegionPart]) -> int:
    """Return a bound on the sides and pairs of sides that `before.and_(parts)` compares."""
    size, rounds = before.size, before.rounds
    for part in parts:
        size += count_sides(part)
        rounds += sum(map(_is_round, part.parts)) if isinstance(part, PartIntersection) else _is_round(part)
    return size + min(size * rounds, MAX_PAIRS)


def _are_disjoint(sides: list[SurfaceSide]) -> bool:
    """Return True if two sides have no volume in common: both sides of a surface, or parallel slanted planes."""
    # Each side is there once
    if len({side.surface for side in sides}) < len(sides):
        return True
    ends: dict[tuple[tuple[tuple[int, int], ...], bool], Fraction] = {}
    for side in sides:
        plane = side.surface
        # Planes across an axis are in the box already
        if isinstance(plane, FlatSurface) and plane.axis is None:
            normal, offset, upward = plane.direction
            above = side.positive == upward
            end = ends.setdefault((normal, above), offset)
            ends[normal, above] = max(end, offset) if above else min(end, offset)
    return any(above and low >= ends.get((normal, False), low + 1) for (normal, above), low in ends.items())


def _split_parts(parts: Iterable[RegionPart]) -> tuple[list[SurfaceSide], list[PartUnion]]:
    """Return the sides, each once, and the unions of an intersection, with nested intersections opened."""
    sides: dict[SurfaceSide, SurfaceSide] = {}
    unions: dict[int, PartUnion] = {}
    # A stack with reversed parts gives the sides in the order of the file.
    pending = list(reversed(tuple(parts)))
    while pending:
        part = pending.pop()
        if isinstance(part, SurfaceSide):
            sides.setdefault(part, part)
        elif isinstance(part, PartIntersection):
            pending.extend(reversed(part.parts))
        else:
            # By identity, as comparing two regions of a file may take long
            unions[id(part)] = part
    return list(sides.values()), list(unions.values())


def _drop_implied_curved(sides: list[SurfaceSide], box: Extent) -> list[SurfaceSide] | None:
    """Return the sides without curved ones that contain the whole box; None if the box is all beyond some side."""
    needed = []
    for side in sides:
        surface = side.surface
        # Planes that are ends of the box stay, as they make it; the others have been left out before
        relation = 0 if isinstance(surface, FlatSurface) and surface.axis is not None else side.of(box)
        if relation > 0:
            return None
        if relation == 0 or isinstance(surface, FlatSurface):
            needed.append(side)
    return needed


def _drop_idle_planes(sides: list[SurfaceSide], unions: list[PartUnion], box: Extent) -> list[SurfaceSide]:
    """Return the sides without planes across an axis that are no end of the box or lie beyond a union.

    Each end of the box stays once.
    """
    needed: list[SurfaceSide] = []
    ends: set[tuple[int, bool]] = set()
    known: dict[int, Extent] = {}
    extents = [_part_extent(union, known) for union in unions]
    for side in sides:
        plane = side.surface
        axis = plane.axis if isinstance(plane, FlatSurface) else None
        if axis is None or not isinstance(plane, FlatSurface):
            needed.append(side)
            continue
        above = side.positive == (plane.normal[axis] > 0)
        end = plane.end
        if any(_lies_beyond(end, axis, above, extent) for extent in extents) or (axis, above) in ends:
            continue
        # Of several equal ends the first stays
        if end == box.end(axis, above):
            ends.add((axis, above))
            needed.append(side)
    return needed


def _lies_beyond(end: Fraction, axis: int, above: bool, extent: Extent) -> bool:
    """Return True if the end lies strictly beyond the extent, so that it cuts nothing of it."""
    own = extent.end(axis, above)
    return own is not None and (own > end if above else own < end)


def _part_extent(part: RegionPart, known: dict[int, Extent]) -> Extent:
    """Return a box around a part; `known` holds those of parts by their identity."""
    if isinstance(part, SurfaceSide):
        return part.surface.extent(part.positive)
    if id(part) not in known:
        join = Extent.common if isinstance(part, PartIntersection) else Extent.union
        known[id(part)] = reduce(join, (_part_extent(inner, known) for inner in part.parts))
    return known[id(part)]


def _drop_paired_sides(sides: list[SurfaceSide]) -> list[SurfaceSide] | None:
    """Return the sides without those that a single round solid implies; None if two sides exclude each other."""
    rounds = [side for side in sides if isinstance(side.surface, RoundSurface) and not side.positive]
    # All pairs of a cell with thousands of holes would take longer than tracing it
    if len(rounds) * len(sides) > MAX_PAIRS:
        return sides
    implied: set[int] = set()
    # The last first: the newest solids are the smallest ones, and imply those around them
    for solid in reversed(rounds):
        if id(solid) in implied:  # what it implies, the part that implies it implies too
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
    """Return -1 if all of a round solid is on a side, +1 if none of it is, else 0 (also for planes across axes)."""
    other = side.surface
    if isinstance(other, FlatSurface):
        # A plane across an axis that lies beyond the solid is no end of the box around all sides
        relation = solid.side_of_plane(other) if other.axis is None else 0
    elif isinstance(other, RoundSurface):
        relation = solid.side_of_round(other)
    else:
        relation = 0
    return -relation if side.positive else relation


def restrict_part(
    part: RegionPart, box: Extent, known: dict[int, RegionPart | bool] | None = None
) -> RegionPart | bool:
    """Return the part that decides for points of the box: True if it has them all, False if it has none.

    `known` holds the results for this box by the identity of parts: a region that others are cut by is in many places.
    """
    known = {} if known is None else known
    if id(part) not in known:
        known[id(part)] = _restrict(part, box, known)
    return known[id(part)]


def _restrict(part: RegionPart, box: Extent, known: dict[int, RegionPart | bool]) -> RegionPart | bool:
    """Return the part that decides for points of the box, from those of its own parts."""
    if isinstance(part, SurfaceSide):
        relation = part.of(box)
        return part if relation == 0 else relation < 0
    # One piece with all points decides a union (True), one piece with none an intersection (False).
    decisive = isinstance(part, PartUnion)
    open_pieces = []
    for piece in (restrict_part(inner, box, known) for inner in part.parts):
        if piece is decisive:
            return decisive
        if not isinstance(piece, bool):
            open_pieces.append(piece)
    if not open_pieces:
        return not decisive
    return open_pieces[0] if len(open_pieces) == 1 else type(part)(tuple(open_pieces))


# Shapes of intersections of sides: planes become one box or polyhedron, outer sides are subtracted.

WHOLE_SPACE = Quadric(coefficients={"xx": -1.0, "constant": -1.0})
"""The solid -x² - 1 <= 0, which has all points."""


@dataclass
class SolidBuilder:
    """Builds solids; equal curved surfaces and equal sets of planes share one shape."""

    curved: dict[CurvedSurface, Solid] = field(default_factory=dict)
    convex: dict[tuple[HalfSpace, ...], Solid] = field(default_factory=dict)
    checked: set[Motion] = field(default_factory=set)

    def solid(self, groups: Iterable[tuple[Motion, tuple[RegionPart, ...]]]) -> Solid:
        """Return the intersection of all parts of all groups, each group moved by its motion.

        Raise ValueError for numbers out of range.
        """
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
        if both not in self.checked:  # each motion is checked once
            both.check("rotation and translation")
            self.checked.add(both)
        return replace(whole, motion=both)

    def intersection(self, parts: tuple[RegionPart, ...]) -> Solid:
        """Return the intersection of parts."""
        planes: list[HalfSpace] = []
        inside: list[Solid] = []
        outside: list[Solid] = []
        for part in parts:
            if not isinstance(part, SurfaceSide):
                beyond, others = _planes_beyond(part)
                if not others or len(beyond) > 1:
                    # Outside of a polyhedron, or inside of others: all but the polyhedron without the others
                    convex, less = self.polyhedron(beyond), map(self.union, others)
                    outside.append(Difference((convex, *less)) if others else convex)
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
        """Return the solid of a part."""
        if isinstance(part, (SurfaceSide, PartIntersection)):
            return self.intersection((part,) if isinstance(part, SurfaceSide) else part.parts)
        return Union(tuple(self.union(piece) for piece in part.parts))

    def polyhedron(self, planes: tuple[HalfSpace, ...]) -> Solid:
        """Return the intersection of half-spaces."""
        if planes not in self.convex:
            self.convex[planes] = _convex_solid(planes)
        return self.convex[planes]

    def _curved(self, surface: CurvedSurface) -> Solid:
        if surface not in self.curved:
            outside = self.curved.get(surface.reversed) if isinstance(surface, GeneralSurface) else None
            self.curved[surface] = surface.solid() if outside is None else ~outside
        return self.curved[surface]


def _planes_beyond(union: RegionPart) -> tuple[tuple[HalfSpace, ...], tuple[RegionPart, ...]]:
    """Return the planes of the polyhedron whose outside is in a union, and its other parts; a part is its only one."""
    planes, others = [], []
    for piece in union.parts if isinstance(union, PartUnion) else (union,):
        if isinstance(piece, SurfaceSide) and isinstance(piece.surface, FlatSurface):
            planes.append(piece.surface.solid(not piece.positive))
        else:
            others.append(piece)
    return tuple(planes), tuple(others)


def _convex_solid(planes: tuple[HalfSpace, ...]) -> Solid:
    """Return one plane as a half-space, six planes across the axes as a box, other planes as a polyhedron."""
    if len(planes) == 1:
        return planes[0]
    ends = {plane.normal: plane.offset for plane in planes}
    if len(planes) == len(ends) == 6 and set(ends) == set(_UP + _DOWN):
        x, y, z = (-ends[normal] + 0.0 for normal in _DOWN)  # + 0.0 turns -0.0 into 0.0
        a, b, c = (ends[normal] for normal in _UP)
        if x < a and y < b and z < c:
            return Box((x, y, z), (a, b, c))
    return Polyhedron(tuple(plane.normal for plane in planes), tuple(plane.offset for plane in planes))


_UP = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
_DOWN = ((-1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, -1.0))
