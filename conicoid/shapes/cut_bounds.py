"""Bounds of primitives that cut one another: all of an intersection's planes, with one quadric at a time.

The box common to the parts of an intersection is rarely tight: a prism of half-spaces has no finite part at all, and
a cap of a ball is narrower than the ball. Here the plane faces of all parts make one polyhedron, whose bounds a linear
program finds, and each quadric among the parts is cut by it (`cut_quadric`). Any subset of the faces gives valid
bounds, so what is too much to ask is left out.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np

from .ball_bounds import in_common
from .base import PrimitiveSolid, Solid
from .boxes import EVERYWHERE, common, is_empty
from .cells import All, Any_, Cell, Face, Not, Tree
from .cut_quadric import cut_quadric_bounds
from .half_space import HalfSpace
from .motion import Motion
from .planar import half_space_bounds
from .polyhedron import Polyhedron, half_spaces_bounds
from .steps import Step
from .surface import PlaneSurface, QuadricSurface
from .vector import Box, FloatArray

Part: TypeAlias = tuple[Solid, Motion, bool]
"""A primitive, the motion that it stands under, and whether its inside or its outside counts."""

KnownBoxes: TypeAlias = Mapping[tuple[int, tuple[Step, ...]], Box]
"""Bounds of primitives that have been worked out before, by the `id` of each and the steps that move it."""
NOTHING_KNOWN: KnownBoxes = {}

MOST_PLANES = 24
"""Candidates grow with the third power of the number of planes that cut one quadric."""
_MOST_OUTSIDES = 32
"""Of more complements than this only half-spaces are looked at: holes seldom narrow a body."""
_CLEAR = 2.0**-40


@dataclass(frozen=True)
class Cuts:
    """Half-spaces normal·x <= offset that all of an intersection lies in."""

    planes: tuple[PlaneSurface, ...] = ()

    @cached_property
    def _floats(self) -> tuple[FloatArray, FloatArray]:
        normals = np.array([[float(c) for c in plane.normal] for plane in self.planes]).reshape(-1, 3)
        return normals, np.array([float(plane.offset) for plane in self.planes])

    @cached_property
    def box(self) -> Box:
        """What the planes across the axes alone bound."""
        return common(
            [EVERYWHERE, *(half_space_bounds(plane, above=False) for plane in self.planes if _is_axial(plane))]
        )

    def crossing(self, box: Box) -> tuple[PlaneSurface, ...]:
        """The planes that may cut a box: all but those that certainly hold all of it."""
        if not self.planes:
            return ()
        normals, offsets = self._floats
        ends = np.where(normals > 0, box[1], box[0])
        terms = np.where(normals == 0, 0.0, normals * np.where(normals == 0, 0.0, ends))
        clear = terms.sum(axis=1) + _CLEAR * (np.abs(terms).sum(axis=1) + np.abs(offsets)) <= offsets
        return tuple(plane for plane, holds in zip(self.planes, clear, strict=True) if not holds)


NO_CUTS = Cuts()


def cut_bounds(parts: Sequence[Part], cuts: Cuts, share: bool, known: KnownBoxes = NOTHING_KNOWN) -> tuple[Box, Cuts]:
    """Bounds of the intersection of `parts` within `cuts`, and the planes around it, to `share` with what it meets."""
    boxes = [_plain(part, known) for part in parts]
    box = common([cuts.box, *boxes])
    if is_empty(box) or (len(parts) < 2 and not cuts.planes and not share):
        return box, cuts
    if not share and not cuts.planes and (found := in_common(parts, boxes)) is not None:
        return (found[:3], found[3:]), NO_CUTS
    faces = _faces(parts)
    own = [[s for s in surfaces if isinstance(s, PlaneSurface)] for surfaces in faces]
    everything = Cuts((*cuts.planes, *(plane for planes in own for plane in planes)))
    sources = [source for source in (cuts, *map(Cuts, map(tuple, own))) if source.crossing(box)]
    crossing = everything.crossing(box)
    if len(sources) > 1 and not all(map(_is_axial, crossing)):
        box = common([box, half_spaces_bounds([*crossing, *_sides(box, crossing)])])
    for k, surfaces in enumerate(faces):
        for quadric in surfaces:
            if isinstance(quadric, QuadricSurface) and not is_empty(box):
                box = common([box, _cut(quadric, boxes[k], own[k], everything, box)])
    if not share or is_empty(box):
        return box, NO_CUTS
    crossing = everything.crossing(box)
    return box, Cuts((*_sides(box, crossing), *crossing)[:MOST_PLANES])


def _plain(part: Part, known: KnownBoxes) -> Box:
    solid, motion, inside = part
    if inside and known:
        found = known.get((id(solid), motion.steps))
        if found is not None:
            return found
    return solid.bounds_under(motion) if inside else solid.outside_bounds_under(motion)


def _cut(quadric: QuadricSurface, plain: Box, own: list[PlaneSurface], planes: Cuts, box: Box) -> Box:
    """Bounds of a part's quadric within its own planes and those of others that cut its `plain` box."""
    foreign = [plane for plane in planes.crossing(plain) if not any(plane is mine for mine in own)]
    narrower = (np.where(box[0] > plain[0], box[0], -np.inf), np.where(box[1] < plain[1], box[1], np.inf))
    sides = _sides(narrower, [*own, *foreign])
    if not foreign and not sides:
        return plain
    for chosen in ([*own, *foreign, *sides], [*own, *_sides(narrower, own)]):
        if len(chosen) <= MOST_PLANES:
            return cut_quadric_bounds(quadric, chosen)
    return plain


def _sides(box: Box, planes: Sequence[PlaneSurface]) -> list[PlaneSurface]:
    """The finite sides of a box as planes, but for those that are parallel to one of `planes`."""
    taken = {_signs(plane) for plane in planes if _is_axial(plane)}
    sides = []
    for i in range(3):
        for sign, end in ((1.0, float(box[1][i])), (-1.0, -float(box[0][i]))):
            x, y, z = (sign if k == i else 0.0 for k in range(3))
            if np.isfinite(end) and (x, y, z) not in taken:
                sides.append(PlaneSurface((x, y, z), end))
    return sides


def _is_axial(plane: PlaneSurface) -> bool:
    return sum(1 for c in plane.normal if c) == 1


def _signs(plane: PlaneSurface) -> tuple[float, ...]:
    return tuple(float((c > 0) - (c < 0)) for c in plane.normal)


def _faces(parts: Sequence[Part]) -> list[list[PlaneSurface | QuadricSurface]]:
    """For each part the surfaces that all of it lies inside of, in the world."""
    many = sum(not inside for _, _, inside in parts) > _MOST_OUTSIDES
    return [
        [] if many and not inside and not isinstance(solid, HalfSpace) else _inside_of(solid, motion, inside)
        for solid, motion, inside in parts
    ]


def _inside_of(solid: Solid, outer: Motion, inside: bool) -> list[PlaneSurface | QuadricSurface]:
    if not isinstance(solid, PrimitiveSolid):
        return []
    motion = solid.under(outer)
    if isinstance(solid, HalfSpace):
        return [_turned(solid.surface.moved(motion), 1 if inside else -1)]
    if isinstance(solid, Polyhedron) and inside:
        return [surface.moved(motion) for surface in solid.surfaces]
    found: list[PlaneSurface | QuadricSurface] = []
    pending: list[tuple[Tree, bool]] = [(solid.tree(), inside)]
    while pending:
        tree, inner = pending.pop()
        if isinstance(tree, Not):
            pending.append((tree.part, not inner))
        elif isinstance(tree, Cell):
            if inner or len(tree.faces) == 1:
                sense = 1 if inner else -1
                found.extend(
                    _turned(_moved(f.surface, motion), sense * f.inside) for f in tree.faces if _narrows(f, sense)
                )
        elif isinstance(tree, All if inner else Any_) or len(tree.parts) == 1:
            pending.extend((part, inner) for part in tree.parts)
    return found


def _moved(surface: PlaneSurface | QuadricSurface, motion: Motion) -> PlaneSurface | QuadricSurface:
    return surface.moved_rows(motion) if isinstance(surface, QuadricSurface) else surface.moved(motion)


def _narrows(face: Face, sense: int) -> bool:
    """Whether a face can bound anything: outside of a convex quadric is nearly everywhere."""
    surface = face.surface
    return isinstance(surface, PlaneSurface) or any(sense * face.inside * s > 0 for s in surface.squares)


def _turned(surface: PlaneSurface | QuadricSurface, sense: int) -> PlaneSurface | QuadricSurface:
    """The surface with its inside where sense · surface <= 0."""
    if sense > 0:
        return surface
    if isinstance(surface, PlaneSurface):
        x, y, z = surface.normal
        return PlaneSurface((-x, -y, -z), -surface.offset, surface.anchor)
    (a, b, c), (x, y, z) = surface.squares, surface.linear
    return dataclasses.replace(surface, squares=(-a, -b, -c), linear=(-x, -y, -z), constant=-surface.constant)
