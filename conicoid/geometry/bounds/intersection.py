"""Bounds of intersections: balls and upright boxes by a formula, primitives whose planes cut one another, and trees.

The functions know no class of shapes: they take any `BoundedSolid`.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any, ClassVar, Literal, Protocol, TypeAlias

import numpy as np
import numpy.typing as npt

from ..._util.arrays import BoxEnds, FloatArray, dot_rows
from ..._util.records import dataclass
from ..cell import Tree, bounding_faces
from ..surface import PlaneSurface, QuadricSurface, Surface
from ..transform import Motion
from .aabb import EVERYWHERE, enclose_boxes, intersect_boxes, is_empty
from .linear_program import half_spaces_bounds
from .quadric_extent import cut_quadric_bounds
from .support import half_space_bounds

Mask: TypeAlias = npt.NDArray[np.bool_]
BoundingSurfaces: TypeAlias = list[Surface]
BoundsKind: TypeAlias = Literal["", "ball", "box", "half_space", "round"]
"""How bounds treat a kind of solid. "round": other solids without a plane, whose outside no box bounds; "": no rule."""


class BoundedSolid(Protocol):
    """The members of `Solid` that bounds use; see there."""

    bounds_kind: ClassVar[BoundsKind]

    def under(self, outer: Motion) -> Motion: ...

    def bounds_under(self, outer: Motion) -> BoxEnds: ...

    def outside_bounds_under(self, outer: Motion) -> BoxEnds: ...

    def has_unbounded_outside(self) -> bool: ...

    def bounding_surfaces(self, outer: Motion, inside: bool) -> BoundingSurfaces: ...


# Intersections of balls and upright boxes
#
# Within a box, the part of a ball that reaches farthest along an axis is over the point nearest to its center across
# that axis: at sqrt(r² - d²), where d is the distance across the axis from the center to the box. Each ball narrows the
# common box, one after the other. Numbers that are not exact to the last bit are rounded outward by far more than their
# error. The same few operations serve one body and arrays of bodies, so that both get the same floats.

_SIMILARITY_ERROR = 2.0**-45
"""Rows of a motion that are orthogonal and of one length up to this share are those of a similarity, or nearly."""
_BALL_ERROR = 2.0**-42
"""A bound on the error of centers and radii read off boxes, as a share of places and sizes, well above the true one."""
_REACH_MARGIN = 2.0**-20
"""The formula needs r² - d² above this share of r²; otherwise other formulas bound the intersection."""


def are_balls_or_boxes(kind: BoundsKind, back: FloatArray) -> Mask:
    """Return for solids of one kind whether their motions leave them balls, or boxes along the axes, (n,).

    `back` holds the linear parts (n, 3, 3) of the motions from the world to their own frames.
    """
    if kind == "box":
        return np.asarray(((back != 0).sum(axis=2) == 1).all(axis=1))
    if kind != "ball":
        return np.zeros(len(back), bool)
    x, y, z = back[:, 0], back[:, 1], back[:, 2]
    xx, yy, zz, xy, xz, yz = (dot_rows(a, b) for a, b in ((x, x), (y, y), (z, z), (x, y), (x, z), (y, z)))
    error = np.abs(np.stack([xx - yy, xx - zz, xy, xz, yz])).max(axis=0)
    return np.asarray(error <= _SIMILARITY_ERROR * xx)


def bound_ball_intersections(boxes: Sequence[FloatArray], balls: Sequence[bool]) -> tuple[FloatArray, Mask]:
    """Return (boxes (n, 6) around the intersections of parts, whether each box holds (n,)), from boxes of the parts.

    Parameters
    ----------
    boxes : sequence of arrays (n, 6)
        One array for each part: its boxes in n bodies, low and high.
    balls : sequence of bool
        Which parts are balls; the others are boxes.
    """
    low = np.max([box[:, :3] for box in boxes], axis=0)
    high = np.min([box[:, 3:] for box in boxes], axis=0)
    good = np.asarray(np.isfinite(low).all(axis=1) & np.isfinite(high).all(axis=1) & (low < high).all(axis=1))
    with np.errstate(all="ignore"):
        for box, is_ball in zip(boxes, balls, strict=True):
            if not is_ball:
                continue
            middle, half = (box[:, :3] + box[:, 3:]) / 2, ((box[:, 3:] - box[:, :3]) / 2).max(axis=1)
            error = _BALL_ERROR * (half + np.abs(middle).max(axis=1))
            distance2 = np.maximum(np.maximum(low - middle, middle - high), 0.0) ** 2
            square = half * half
            for axis in range(3):
                left = square - (distance2[:, axis - 1] + distance2[:, axis - 2])
                good &= np.asarray(left > _REACH_MARGIN * square)
                reach = np.sqrt(left + 8 * error * half) + error
                low[:, axis] = np.maximum(low[:, axis], middle[:, axis] - reach)
                high[:, axis] = np.minimum(high[:, axis], middle[:, axis] + reach)
        good &= np.asarray((low < high).all(axis=1))
    return np.concatenate([low, high], axis=1), good


def bound_ball_intersection(
    parts: Sequence[tuple[BoundedSolid, Motion, bool]], boxes: Sequence[tuple[FloatArray, FloatArray]]
) -> FloatArray | None:
    """Return the six ends of the box around an intersection of balls and upright boxes; None for other parts.

    Parameters
    ----------
    parts : sequence of (solid, motion, inside)
        Outsides may be among them if nothing bounds them: they do not narrow the box.
    boxes : sequence of (low, high)
        The bounds of each part.
    """
    inside = [(solid, motion, box) for (solid, motion, inner), box in zip(parts, boxes, strict=True) if inner]
    if len(inside) < 2 or not all(inner or solid.has_unbounded_outside() for solid, _, inner in parts):
        return None
    for solid, motion, _ in inside:
        if solid.bounds_kind not in ("ball", "box"):
            return None
        back = np.array(solid.under(motion).inverse_rows)[None, :, :3]
        if not are_balls_or_boxes(solid.bounds_kind, back)[0]:
            return None
    found, good = bound_ball_intersections(
        [np.concatenate(box)[None] for *_, box in inside], [solid.bounds_kind == "ball" for solid, *_ in inside]
    )
    return found[0] if good[0] else None


# Primitives that cut one another: all planes of an intersection, with one quadric at a time
#
# The box common to the parts of an intersection is rarely tight: a prism of half-spaces has no finite part at all, and
# a cap of a ball is narrower than the ball. Here the plane faces of all parts make one polyhedron, whose bounds a
# linear program finds, and it cuts each quadric among the parts (`cut_quadric_bounds`). Any subset of the faces gives
# valid bounds, so that expensive ones can be left out.

Part: TypeAlias = tuple[BoundedSolid, Motion, bool]
"""A primitive, its motion, and True for its inside or False for its outside."""

MAX_PLANES = 24
"""Candidates grow with the third power of the number of planes that cut one quadric."""
_MAX_COMPLEMENTS = 32
"""With more complements than this, only half-spaces among them count: holes seldom narrow a body."""
_PLANE_MARGIN = 2.0**-40
"""A plane counts as clear of a box only by this share of the terms of normal·x - offset."""


@dataclass(frozen=True)
class Cuts:
    """Half-spaces normal·x <= offset that contain all of an intersection."""

    planes: tuple[PlaneSurface, ...] = ()

    @cached_property
    def _floats(self) -> tuple[FloatArray, FloatArray]:
        normals = np.array([[float(c) for c in plane.normal] for plane in self.planes]).reshape(-1, 3)
        return normals, np.array([float(plane.offset) for plane in self.planes])

    @cached_property
    def box(self) -> BoxEnds:
        """The bounds that the planes across the axes give alone."""
        return intersect_boxes(
            [EVERYWHERE, *(half_space_bounds(plane, above=False) for plane in self.planes if _is_axial(plane))]
        )

    def crossing(self, box: BoxEnds) -> tuple[PlaneSurface, ...]:
        """Return the planes that may cut a box: all but those whose half-space surely contains it."""
        if not self.planes:
            return ()
        normals, offsets = self._floats
        ends = np.where(normals > 0, box[1], box[0])
        terms = np.where(normals == 0, 0.0, normals * np.where(normals == 0, 0.0, ends))
        clear = terms.sum(axis=1) + _PLANE_MARGIN * (np.abs(terms).sum(axis=1) + np.abs(offsets)) <= offsets
        return tuple(plane for plane, holds in zip(self.planes, clear, strict=True) if not holds)


NO_CUTS = Cuts()


def cut_bounds(parts: Sequence[Part], cuts: Cuts, share: bool) -> tuple[BoxEnds, Cuts]:
    """Return the bounds of the intersection of `parts` within `cuts`, and the planes around it.

    Parameters
    ----------
    parts : sequence of Part
        The primitives of the intersection.
    cuts : Cuts
        Half-spaces that contain the intersection.
    share : bool
        True if the caller needs the planes, for unions in the intersection; otherwise `NO_CUTS` is returned.
    """
    boxes = [_uncut_box(*part) for part in parts]
    box = intersect_boxes([cuts.box, *boxes])
    if is_empty(box) or (len(parts) < 2 and not cuts.planes and not share):
        return box, cuts
    if not share and not cuts.planes and (found := bound_ball_intersection(parts, boxes)) is not None:
        return (found[:3], found[3:]), NO_CUTS
    faces = _part_surfaces(parts)
    own = [[s for s in surfaces if isinstance(s, PlaneSurface)] for surfaces in faces]
    everything = Cuts((*cuts.planes, *(plane for planes in own for plane in planes)))
    # A source alone has the bounds of its own planes already, and planes across the axes are in the boxes
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


def _uncut_box(solid: BoundedSolid, motion: Motion, inside: bool) -> BoxEnds:
    return solid.bounds_under(motion) if inside else solid.outside_bounds_under(motion)


def _cut_box(quadric: QuadricSurface, plain: BoxEnds, own: list[PlaneSurface], planes: Cuts, box: BoxEnds) -> BoxEnds:
    """Return the bounds of a part's quadric within its own planes and those of other parts that cut its `plain` box.

    `box` is common to all parts: its sides are planes too where it is narrower.
    """
    foreign = [plane for plane in planes.crossing(plain) if not any(plane is mine for mine in own)]
    narrower = (np.where(box[0] > plain[0], box[0], -np.inf), np.where(box[1] < plain[1], box[1], np.inf))
    sides = _sides(narrower, [*own, *foreign])
    if not foreign and not sides:
        return plain
    # With too many planes, the box stands for those of the other parts
    for chosen in ([*own, *foreign, *sides], [*own, *_sides(narrower, own)]):
        if len(chosen) <= MAX_PLANES:
            return cut_quadric_bounds(quadric, chosen)
    return plain


def _sides(box: BoxEnds, planes: Sequence[PlaneSurface]) -> list[PlaneSurface]:
    """Return the finite sides of a box as planes, except sides with the normal of one of `planes`."""
    signs = {tuple(float((c > 0) - (c < 0)) for c in plane.normal) for plane in planes if _is_axial(plane)}
    sides = []
    for i in range(3):
        for sign, end in ((1.0, float(box[1][i])), (-1.0, -float(box[0][i]))):
            x, y, z = (sign if k == i else 0.0 for k in range(3))
            if np.isfinite(end) and (x, y, z) not in signs:
                sides.append(PlaneSurface((x, y, z), end))
    return sides


def _is_axial(plane: PlaneSurface) -> bool:
    return sum(1 for c in plane.normal if c) == 1


def _part_surfaces(parts: Sequence[Part]) -> list[BoundingSurfaces]:
    """Return for each part the surfaces in the world that contain it."""
    many = sum(not inside for _, _, inside in parts) > _MAX_COMPLEMENTS
    return [
        [] if many and not inside and solid.bounds_kind != "half_space" else solid.bounding_surfaces(motion, inside)
        for solid, motion, inside in parts
    ]


def surfaces_around(own: Tree, motion: Motion, inside: bool) -> BoundingSurfaces:
    """Return the surfaces in the world that contain the inside, or the outside, of a tree of cells.

    Parameters
    ----------
    own : Tree
        The cells in the shape's own frame.
    motion : Motion
        The motion from that frame to the world.
    inside : bool
        False for the outside of the tree.
    """
    return [
        orient_surface(face.surface.moved_rows(motion), sense)
        for face, sense in bounding_faces(own, inside)
        if _can_bound(face.surface, sense)
    ]


def _can_bound(surface: Surface, sense: int) -> bool:
    """Return True if a side of a surface can bound anything; the outside of a convex quadric is nearly everywhere."""
    return isinstance(surface, PlaneSurface) or any(sense * s > 0 for s in surface.squares)


def orient_surface(surface: Surface, sense: int) -> Surface:
    """Return the surface oriented so that its inside is where sense · surface <= 0."""
    return surface if sense > 0 else surface.reversed()


# Boolean trees, whose nested intersections count as one


@dataclass(frozen=True)
class _SolidSide:
    """The inside or the outside of a solid under a motion, cut by planes of nodes above it."""

    solid: Any
    motion: Motion
    inside: bool
    cuts: Cuts = NO_CUTS
    depth: int = 0

    @property
    def parts(self) -> list[_SolidSide]:
        """The sides of the operands of a Boolean solid."""
        motion, operands = self.solid.motion.then(self.motion), self.solid.operands
        sides = self.solid._sides(len(operands), self.inside)
        return [_SolidSide(part, motion, side) for part, side in zip(operands, sides, strict=True)]


_CUT_DEPTH_LIMIT = 8
_CUT_WIDTH_LIMIT = 256
"""Planes cut unions at most so many levels below them and so many operands wide: deeper nodes seldom need them."""


def region_bounds(solid: Any, outer: Motion, inside: bool = True) -> BoxEnds:
    """Return the bounds (low, high) of a Boolean tree, or of its outside, after `outer`.

    The box of a union encloses those of its parts, the box of an intersection is common to its parts, and complements
    move down to the primitives (De Morgan). Nested intersections count as one. The planes of an intersection cut its
    quadrics, and those of the unions in it.

    Parameters
    ----------
    solid : Boolean
        The tree. Its primitives are `BoundedSolid`.
    outer : Motion
        A motion of the whole tree.
    inside : bool
        False for the outside of the tree.
    """
    results: list[BoxEnds] = []
    # Nodes to bound, and (function, count) entries: combine the last `count` results
    pending: list[_SolidSide | tuple[Callable[[list[BoxEnds]], BoxEnds], int]] = [_SolidSide(solid, outer, inside)]
    while pending:
        node = pending.pop()
        if not isinstance(node, _SolidSide):
            combined, count = node
            parts = results[-count:]
            del results[-count:]
            results.append(combined(parts))
            continue
        primitives, unions = _split_conjuncts(node)
        box, cuts = cut_bounds([(n.solid, n.motion, n.inside) for n in primitives], node.cuts, bool(unions))
        results.append(box)
        if is_empty(box) or not unions:
            continue
        pending.append((intersect_boxes, 1 + len(unions)))
        for union in unions:
            members = union.parts
            inherited = cuts if node.depth < _CUT_DEPTH_LIMIT and len(members) <= _CUT_WIDTH_LIMIT else NO_CUTS
            pending.append((enclose_boxes, len(members)))
            pending.extend(dataclasses.replace(part, cuts=inherited, depth=node.depth + 1) for part in members)
    return results[0]


def _split_conjuncts(node: _SolidSide) -> tuple[list[_SolidSide], list[_SolidSide]]:
    """Return (primitives, unions) whose intersection the node is."""
    primitives, unions, pending = [], [], [node]
    while pending:
        part = pending.pop()
        if not hasattr(part.solid, "operands"):
            primitives.append(part)
        elif part.solid._is_intersection(part.inside):
            pending.extend(reversed(part.parts))
        else:
            unions.append(part)
    return primitives, unions
