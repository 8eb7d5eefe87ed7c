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
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, reduce
from typing import TypeAlias

from .extent import EVERYWHERE, Extent
from .placement import Placement, Point
from .region import Both, Half, Region
from .surfaces import FlatSurface, RoundSurface, Surface

MOST_PAIRS = 20_000
"""Pairs of parts that are compared with each other; beyond, superfluous ones just stay."""


@dataclass(frozen=True, slots=True)
class Side:
    """One closed side of a plane, the solid side of a curved surface, or the open outer one."""

    surface: Surface
    positive: bool

    def of(self, extent: Extent) -> int:
        """-1 where all of the extent is on this side, +1 where none of it is (but for its surface), else 0."""
        side = self.surface.side_of(extent)
        return -side if self.positive else side


@dataclass(frozen=True, slots=True)
class AllOf:
    """In every part."""

    parts: tuple[Part, ...]


@dataclass(frozen=True, slots=True)
class AnyOf:
    """In at least one part."""

    parts: tuple[Part, ...]


Part: TypeAlias = Side | AllOf | AnyOf


def bound(region: Region, surfaces: Mapping[int, Surface]) -> Part:
    """The region with surfaces in the place of their numbers."""
    if isinstance(region, Half):
        return Side(surfaces[region.surface], region.positive)
    kind = AllOf if isinstance(region, Both) else AnyOf
    return kind(tuple(bound(part, surfaces) for part in region.parts))


def moved(part: Part, place: Placement) -> Part:
    """A part elsewhere."""
    if isinstance(part, Side):
        return Side(part.surface.placed(place), part.positive)
    return type(part)(tuple(moved(piece, place) for piece in part.parts))


@dataclass(frozen=True)
class Conjunction:
    """In every part; `extent` is a box around that."""

    parts: tuple[Part, ...] = ()
    extent: Extent = EVERYWHERE

    def and_(self, parts: Iterable[Part], extent: Extent = EVERYWHERE) -> Conjunction | None:
        """With further parts, which may be known to lie in an extent; None where nothing is left."""
        sides, unions = _sorted((*self.parts, *parts))
        box = self.extent.common(extent)
        box = reduce(Extent.common, (side.surface.extent(side.positive) for side in sides), box)
        if box.is_empty or _excluded(sides):
            return None
        apart = _without_pairs(sides)
        kept = None if apart is None else _without_shown(_without_idle_planes(apart, unions, box), box)
        if kept is None:
            return None
        left = [within(union, box) for union in unions]
        if False in left:
            return None
        branches = [part for part in left if not isinstance(part, bool)]
        still = tuple(part for part in branches if isinstance(part, AnyOf))
        result = Conjunction((*kept, *still), box)
        opened = [part for part in branches if not isinstance(part, AnyOf)]
        return result.and_(opened) if opened else result

    def inside(self, box: Extent) -> Conjunction | None:
        """What is left to ask of points in a box; None where none of them is in."""
        left = [within(part, box) for part in self.parts]
        if False in left:
            return None
        if len(left) and all(part is own for part, own in zip(left, self.parts, strict=True)):
            return self
        return Conjunction().and_(part for part in left if not isinstance(part, bool))

    def moved(self, shift: Point) -> Conjunction:
        """The same elsewhere."""
        place = Placement(shift=shift)
        return Conjunction(tuple(moved(part, place) for part in self.parts), self.extent.placed(place))

    @cached_property
    def size(self) -> int:
        """How many sides it has."""
        return sum(map(size_of, self.parts))

    @cached_property
    def rounds(self) -> int:
        """How many of its parts are the insides of round solids, with which others are compared."""
        return sum(map(_is_round, self.parts))


def size_of(part: Part) -> int:
    """How many sides a part has."""
    return 1 if isinstance(part, Side) else sum(map(size_of, part.parts))


def _is_round(part: Part) -> bool:
    return isinstance(part, Side) and isinstance(part.surface, RoundSurface) and not part.positive


def cost(before: Conjunction, parts: Iterable[Part]) -> int:
    """How many sides and pairs of sides `before.and_(parts)` looks at, at most."""
    size, rounds = before.size, before.rounds
    for part in parts:
        size += size_of(part)
        rounds += sum(map(_is_round, part.parts)) if isinstance(part, AllOf) else _is_round(part)
    return size + min(size * rounds, MOST_PAIRS)


def _excluded(sides: list[Side]) -> bool:
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


def _sorted(parts: Iterable[Part]) -> tuple[list[Side], list[AnyOf]]:
    """Sides, each once, and unions."""
    sides: dict[tuple[Surface, bool], Side] = {}
    unions: dict[int, AnyOf] = {}
    pending = list(reversed(tuple(parts)))
    while pending:
        part = pending.pop()
        if isinstance(part, Side):
            sides.setdefault((part.surface, part.positive), part)
        elif isinstance(part, AllOf):
            pending.extend(reversed(part.parts))
        else:
            unions[id(part)] = part
    return list(sides.values()), list(unions.values())


def _without_shown(sides: list[Side], box: Extent) -> list[Side] | None:
    """Without the curved sides that all of the box is on; None where it is all beyond some side."""
    kept = []
    for side in sides:
        relation = side.of(box)
        if relation > 0:
            return None
        if relation == 0 or isinstance(side.surface, FlatSurface):
            kept.append(side)
    return kept


def _without_idle_planes(sides: list[Side], unions: list[AnyOf], box: Extent) -> list[Side]:
    """Without the planes across an axis that are no end of the box, or lie beyond a union; each end is kept once."""
    kept: list[Side] = []
    ends: set[tuple[int, bool]] = set()
    around = [_extent(union) for union in unions]
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


def _extent(part: Part) -> Extent:
    """A box around a part."""
    if isinstance(part, Side):
        return part.surface.extent(part.positive)
    return reduce(Extent.common if isinstance(part, AllOf) else Extent.around, map(_extent, part.parts))


def _without_pairs(sides: list[Side]) -> list[Side] | None:
    """Without the sides that a single round solid implies; None where two exclude each other."""
    rounds = [side for side in sides if isinstance(side.surface, RoundSurface) and not side.positive]
    if len(rounds) * len(sides) > MOST_PAIRS:
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


def _relation(solid: RoundSurface, side: Side) -> int:
    """-1 where all of a round solid is on a side, +1 where none of it is, else 0."""
    other = side.surface
    if isinstance(other, FlatSurface):
        relation = solid.side_of_plane(other)
    elif isinstance(other, RoundSurface):
        relation = -1 if solid.is_within(other) else int(solid.is_apart(other))
    else:
        relation = 0
    return -relation if side.positive else relation


def within(part: Part, box: Extent) -> Part | bool:
    """What is left to ask of a part for points in the box: nothing (True), or it has none of them (False)."""
    if isinstance(part, Side):
        relation = part.of(box)
        return part if relation == 0 else relation < 0
    decisive = isinstance(part, AnyOf)
    left = []
    for piece in (within(inner, box) for inner in part.parts):
        if piece is decisive:
            return decisive
        if not isinstance(piece, bool):
            left.append(piece)
    if not left:
        return not decisive
    return left[0] if len(left) == 1 else type(part)(tuple(left))
