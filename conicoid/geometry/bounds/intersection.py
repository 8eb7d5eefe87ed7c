"""Bounds of what balls have in common with one another and with boxes along the axes, by a formula.

Within a box, the part of a ball that reaches farthest along an axis is over the point nearest to its center across that
axis: at sqrt(r² - d²), d being the distance across the axis from the center to the box. Each ball narrows the box that
is common to all, one after the other. What is not known to the last bit is rounded outward by far more than it may be
off. The same few operations serve one body and arrays of them, so both get the same floats.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from ..._util.arrays import BoxEnds, FloatArray
from ..cell import All, Any_, Cell, Face, Not, Tree
from ..polyhedron import Polyhedron, half_spaces_bounds
from ..primitives import Box as BoxSolid
from ..primitives import HalfSpace, Sphere
from ..quadrics import Ellipsoid
from ..shape import PrimitiveSolid, Solid
from ..surface import PlaneSurface, QuadricSurface
from ..transform import Motion, Step
from .aabb import EVERYWHERE, intersect_boxes, is_empty
from .quadric_extent import cut_quadric_bounds
from .support import half_space_bounds

Mask: TypeAlias = npt.NDArray[np.bool_]
ROUND_KINDS = (Sphere, Ellipsoid)
"""Kinds whose outside no box bounds, if nothing cuts them."""
_SIMILARITY_ERROR = 2.0**-45
"""Rows of a motion that are orthogonal and of one length by this share are those of a similarity, or nearly."""
_BALL_ERROR = 2.0**-42
"""What centers and radii that are read off boxes may be off by, as a share of places and sizes: much less in truth."""
_REACH_MARGIN = 2.0**-20
"""Balls that are reached by less than this share of their radius, squared, are left to other formulas."""


def has_unbounded_outside(shape: Solid) -> bool:
    """Is the outside of a solid without a plane or a quadric that would bound it?"""
    if not isinstance(shape, PrimitiveSolid) or type(shape).outside_bounds_under is not Solid.outside_bounds_under:
        return False
    if isinstance(shape, (BoxSolid, *ROUND_KINDS)):
        return True
    tree = shape.tree()
    return isinstance(tree, Cell) and len(tree.faces) > 1


def are_balls_or_boxes(kind: type, back: FloatArray) -> Mask:
    """Are solids of one kind still balls, or boxes along the axes?

    back: the linear parts (n, 3, 3) of the ways back to their own frames.
    """
    if issubclass(kind, BoxSolid):
        return np.asarray(((back != 0).sum(axis=2) == 1).all(axis=1))
    if not issubclass(kind, Sphere):
        return np.zeros(len(back), bool)
    x, y, z = back[:, 0], back[:, 1], back[:, 2]
    xx, yy, zz, xy, xz, yz = (_dot(a, b) for a, b in ((x, x), (y, y), (z, z), (x, y), (x, z), (y, z)))
    off = np.abs(np.stack([xx - yy, xx - zz, xy, xz, yz])).max(axis=0)
    return np.asarray(off <= _SIMILARITY_ERROR * xx)


def _dot(a: FloatArray, b: FloatArray) -> FloatArray:
    result: FloatArray = (a[:, 0] * b[:, 0] + a[:, 1] * b[:, 1]) + a[:, 2] * b[:, 2]
    return result


def bound_ball_intersections(boxes: Sequence[FloatArray], balls: Sequence[bool]) -> tuple[FloatArray, Mask]:
    """(boxes (n, 6) around what parts have in common, for which bodies these are good), from boxes of the parts.

    balls: which of the parts are balls; the others are boxes.
    """
    low = np.max([box[:, :3] for box in boxes], axis=0)
    high = np.min([box[:, 3:] for box in boxes], axis=0)
    good = np.asarray(np.isfinite(low).all(axis=1) & np.isfinite(high).all(axis=1) & (low < high).all(axis=1))
    with np.errstate(all="ignore"):
        for box, is_ball in zip(boxes, balls, strict=True):
            if not is_ball:
                continue
            middle, half = (box[:, :3] + box[:, 3:]) / 2, ((box[:, 3:] - box[:, :3]) / 2).max(axis=1)
            off = _BALL_ERROR * (half + np.abs(middle).max(axis=1))
            away = np.maximum(np.maximum(low - middle, middle - high), 0.0) ** 2
            square = half * half
            for axis in range(3):
                left = square - (away[:, axis - 1] + away[:, axis - 2])
                good &= np.asarray(left > _REACH_MARGIN * square)
                reach = np.sqrt(left + 8 * off * half) + off
                low[:, axis] = np.maximum(low[:, axis], middle[:, axis] - reach)
                high[:, axis] = np.minimum(high[:, axis], middle[:, axis] + reach)
        good &= np.asarray((low < high).all(axis=1))
    return np.concatenate([low, high], axis=1), good


def bound_ball_intersection(
    parts: Sequence[tuple[Solid, Motion, bool]], boxes: Sequence[tuple[FloatArray, FloatArray]]
) -> FloatArray | None:
    """The six ends of the box around what some parts have in common, from their boxes; None where that needs more.

    parts: each with its motion, and whether it is its inside that counts.
    """
    inside = [(solid, motion, box) for (solid, motion, inner), box in zip(parts, boxes, strict=True) if inner]
    if len(inside) < 2 or not all(inner or has_unbounded_outside(solid) for solid, _, inner in parts):
        return None
    for solid, motion, _ in inside:
        if not isinstance(solid, (Sphere, BoxSolid)):
            return None
        back = np.array(solid.under(motion).inverse_rows)[None, :, :3]
        if not are_balls_or_boxes(type(solid), back)[0]:
            return None
    found, good = bound_ball_intersections(
        [np.concatenate(box)[None] for *_, box in inside], [isinstance(solid, Sphere) for solid, *_ in inside]
    )
    return found[0] if good[0] else None


# Bounds of primitives that cut one another: all of an intersection's planes, with one quadric at a time.
#
# The box common to the parts of an intersection is rarely tight: a prism of half-spaces has no finite part at all, and
# a cap of a ball is narrower than the ball. Here the plane faces of all parts make one polyhedron, whose bounds a
# linear
# program finds, and each quadric among the parts is cut by it (`cut_quadric`). Any subset of the faces gives valid
# bounds, so what is too much to ask is left out.

Part: TypeAlias = tuple[Solid, Motion, bool]
"""A primitive, the motion that it stands under, and whether its inside or its outside counts."""

KnownBoxes: TypeAlias = Mapping[tuple[int, tuple[Step, ...]], BoxEnds]
"""Bounds of primitives that have been worked out before, by the `id` of each and the steps that move it."""
NO_KNOWN_BOXES: KnownBoxes = {}

MAX_PLANES = 24
"""Candidates grow with the third power of the number of planes that cut one quadric."""
_MAX_COMPLEMENTS = 32
"""Of more complements than this only half-spaces are looked at: holes seldom narrow a body."""
_PLANE_MARGIN = 2.0**-40


@dataclass(frozen=True)
class Cuts:
    """Half-spaces normal·x <= offset that all of an intersection lies in."""

    planes: tuple[PlaneSurface, ...] = ()

    @cached_property
    def _floats(self) -> tuple[FloatArray, FloatArray]:
        normals = np.array([[float(c) for c in plane.normal] for plane in self.planes]).reshape(-1, 3)
        return normals, np.array([float(plane.offset) for plane in self.planes])

    @cached_property
    def box(self) -> BoxEnds:
        """What the planes across the axes alone bound."""
        return intersect_boxes(
            [EVERYWHERE, *(half_space_bounds(plane, above=False) for plane in self.planes if _is_axial(plane))]
        )

    def crossing(self, box: BoxEnds) -> tuple[PlaneSurface, ...]:
        """The planes that may cut a box: all but those that certainly hold all of it."""
        if not self.planes:
            return ()
        normals, offsets = self._floats
        ends = np.where(normals > 0, box[1], box[0])
        terms = np.where(normals == 0, 0.0, normals * np.where(normals == 0, 0.0, ends))
        clear = terms.sum(axis=1) + _PLANE_MARGIN * (np.abs(terms).sum(axis=1) + np.abs(offsets)) <= offsets
        return tuple(plane for plane, holds in zip(self.planes, clear, strict=True) if not holds)


NO_CUTS = Cuts()


def cut_bounds(
    parts: Sequence[Part], cuts: Cuts, share: bool, known: KnownBoxes = NO_KNOWN_BOXES
) -> tuple[BoxEnds, Cuts]:
    """Bounds of the intersection of `parts` within `cuts`, and the planes around it, to `share` with what it meets."""
    boxes = [_uncut_box(part, known) for part in parts]
    box = intersect_boxes([cuts.box, *boxes])
    if is_empty(box) or (len(parts) < 2 and not cuts.planes and not share):
        return box, cuts
    if not share and not cuts.planes and (found := bound_ball_intersection(parts, boxes)) is not None:
        return (found[:3], found[3:]), NO_CUTS
    faces = _part_surfaces(parts)
    own = [[s for s in surfaces if isinstance(s, PlaneSurface)] for surfaces in faces]
    everything = Cuts((*cuts.planes, *(plane for planes in own for plane in planes)))
    sources = [source for source in (cuts, *map(Cuts, map(tuple, own))) if source.crossing(box)]
    crossing = everything.crossing(box)
    if len(sources) > 1 and not all(map(_is_axial, crossing)):
        box = intersect_boxes([box, half_spaces_bounds([*crossing, *_sides(box, crossing)])])
    for k, surfaces in enumerate(faces):
        for quadric in surfaces:
            if isinstance(quadric, QuadricSurface) and not is_empty(box):
                box = intersect_boxes([box, _cut_box(quadric, boxes[k], own[k], everything, box)])
    if not share or is_empty(box):
        return box, NO_CUTS
    crossing = everything.crossing(box)
    return box, Cuts((*_sides(box, crossing), *crossing)[:MAX_PLANES])


def _uncut_box(part: Part, known: KnownBoxes) -> BoxEnds:
    solid, motion, inside = part
    if inside and known:
        found = known.get((id(solid), motion.steps))
        if found is not None:
            return found
    return solid.bounds_under(motion) if inside else solid.outside_bounds_under(motion)


def _cut_box(quadric: QuadricSurface, plain: BoxEnds, own: list[PlaneSurface], planes: Cuts, box: BoxEnds) -> BoxEnds:
    """Bounds of a part's quadric within its own planes and those of others that cut its `plain` box."""
    foreign = [plane for plane in planes.crossing(plain) if not any(plane is mine for mine in own)]
    narrower = (np.where(box[0] > plain[0], box[0], -np.inf), np.where(box[1] < plain[1], box[1], np.inf))
    sides = _sides(narrower, [*own, *foreign])
    if not foreign and not sides:
        return plain
    for chosen in ([*own, *foreign, *sides], [*own, *_sides(narrower, own)]):
        if len(chosen) <= MAX_PLANES:
            return cut_quadric_bounds(quadric, chosen)
    return plain


def _sides(box: BoxEnds, planes: Sequence[PlaneSurface]) -> list[PlaneSurface]:
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


def _part_surfaces(parts: Sequence[Part]) -> list[list[PlaneSurface | QuadricSurface]]:
    """For each part the surfaces that all of it lies inside of, in the world."""
    many = sum(not inside for _, _, inside in parts) > _MAX_COMPLEMENTS
    return [
        [] if many and not inside and not isinstance(solid, HalfSpace) else _bounding_surfaces(solid, motion, inside)
        for solid, motion, inside in parts
    ]


def _bounding_surfaces(solid: Solid, outer: Motion, inside: bool) -> list[PlaneSurface | QuadricSurface]:
    if not isinstance(solid, PrimitiveSolid):
        return []
    motion = solid.under(outer)
    if isinstance(solid, HalfSpace):
        return [_orient_surface(solid.surface.moved(motion), 1 if inside else -1)]
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
                    _orient_surface(_transform_surface(f.surface, motion), sense * f.inside)
                    for f in tree.faces
                    if _can_bound(f, sense)
                )
        elif isinstance(tree, All if inner else Any_) or len(tree.parts) == 1:
            pending.extend((part, inner) for part in tree.parts)
    return found


def _transform_surface(surface: PlaneSurface | QuadricSurface, motion: Motion) -> PlaneSurface | QuadricSurface:
    return surface.moved_rows(motion) if isinstance(surface, QuadricSurface) else surface.moved(motion)


def _can_bound(face: Face, sense: int) -> bool:
    """Whether a face can bound anything: outside of a convex quadric is nearly everywhere."""
    surface = face.surface
    return isinstance(surface, PlaneSurface) or any(sense * face.inside * s > 0 for s in surface.squares)


def _orient_surface(surface: PlaneSurface | QuadricSurface, sense: int) -> PlaneSurface | QuadricSurface:
    """The surface with its inside where sense · surface <= 0."""
    if sense > 0:
        return surface
    if isinstance(surface, PlaneSurface):
        x, y, z = surface.normal
        return PlaneSurface((-x, -y, -z), -surface.offset, surface.anchor)
    (a, b, c), (x, y, z) = surface.squares, surface.linear
    return dataclasses.replace(surface, squares=(-a, -b, -c), linear=(-x, -y, -z), constant=-surface.constant)
