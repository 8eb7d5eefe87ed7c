"""From intersections of sides to shapes: planes become one box or polyhedron, outer sides are subtracted."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace

from ...shapes.base import Solid
from ...shapes.box import Box
from ...shapes.half_space import HalfSpace
from ...shapes.motion import Motion
from ...shapes.polyhedron import Polyhedron
from ...shapes.quadric import Quadric
from ...shapes.region import Complement, Difference, Intersection, Union
from .narrowing import AllOf, Part, Side
from .surfaces import CurvedSurface, FlatSurface

ALL_OF_SPACE = Quadric(coefficients={"xx": -1.0, "constant": -1.0})


@dataclass
class SolidMaker:
    """Makes solids; equal curved surfaces and equal sets of planes share one shape."""

    curved: dict[CurvedSurface, Solid] = field(default_factory=dict)
    convex: dict[tuple[HalfSpace, ...], Solid] = field(default_factory=dict)
    checked: set[Motion] = field(default_factory=set)

    def solid(self, groups: Iterable[tuple[Motion, tuple[Part, ...]]]) -> Solid:
        """In every part of every group, each group moved as a whole. Raises ValueError for numbers out of range."""
        moved = []
        for motion, parts in groups:
            if parts:
                whole = self.intersection(parts)
                moved.append(whole if motion.is_identity else self._moved(whole, motion))
        if not moved:
            return ALL_OF_SPACE
        return moved[0] if len(moved) == 1 else Intersection(tuple(moved))

    def _moved(self, whole: Solid, motion: Motion) -> Solid:
        both = whole.motion.then(motion)
        if both not in self.checked:
            both.check("rotation and translation")
            self.checked.add(both)
        return replace(whole, motion=both)

    def intersection(self, parts: tuple[Part, ...]) -> Solid:
        planes: list[HalfSpace] = []
        inside: list[Solid] = []
        outside: list[Solid] = []
        for part in parts:
            if not isinstance(part, Side):
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

    def union(self, part: Part) -> Solid:
        if isinstance(part, (Side, AllOf)):
            return self.intersection((part,) if isinstance(part, Side) else part.parts)
        return Union(tuple(self.union(piece) for piece in part.parts))

    def polyhedron(self, planes: tuple[HalfSpace, ...]) -> Solid:
        """The common part of half-spaces."""
        if planes not in self.convex:
            self.convex[planes] = _convex(planes)
        return self.convex[planes]

    def _curved(self, surface: CurvedSurface) -> Solid:
        if surface not in self.curved:
            self.curved[surface] = surface.solid()
        return self.curved[surface]


def _planes_beyond(union: Part) -> tuple[HalfSpace, ...]:
    """The planes of a polyhedron whose outside the union is, empty where it is none."""
    planes = []
    for piece in () if isinstance(union, Side) else union.parts:
        if not isinstance(piece, Side) or not isinstance(piece.surface, FlatSurface):
            return ()
        planes.append(piece.surface.solid(not piece.positive))
    return tuple(planes)


def _convex(planes: tuple[HalfSpace, ...]) -> Solid:
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
