"""Plans of Boolean bodies: how each is built of its primitives, the forms in which these are lowered, and its box."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Hashable, Sequence
from functools import cache
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from .._util.arrays import cross_rows, dot_rows, row_lengths, unit_rows
from .._util.records import dataclass
from ..geometry.bounds.intersection import BoundsKind, are_balls_or_boxes, bound_ball_intersections
from ..geometry.cell import Tree, bounding_faces
from ..geometry.shape import Boolean, Complement, Difference, Intersection, Painted, PrimitiveSolid, Shape, Union
from ..geometry.transform import Step
from ..kernels.tables import PLANE, PLANE_SIZE, QUADRIC_SIZE, SPHERE, Floats, Signs
from .pattern import BOX_NUMBERS, FRAME_NUMBERS, BodyPattern, RowTable, row_blocks
from .region_extent import FLOAT_ERROR, MAX_PLANES, SIDES, bound_by_corners, narrow_csg_boxes


@dataclasses.dataclass(slots=True)
class CsgPlan:
    """The structure of a Boolean body, and its primitives from left to right with the steps that move each."""

    key: tuple[Hashable, ...]
    leaves: list[tuple[Shape, tuple[Step, ...]]]
    painted: list[tuple[int, int, Painted]]  # (first leaf, last leaf, paint), from the innermost paint outward


@cache
def is_subclass(kind: Any, of: Any) -> bool:
    """Cached `issubclass`: it is called for every node."""
    return issubclass(kind, of)


def csg_plan(solid: Boolean, still: bool = False) -> CsgPlan | None:
    """Build the plan of a solid; None where it holds more than primitives and Boolean nodes.

    With `still` the solid's own motion, which comes last among the steps of every leaf, is left out.
    """
    key: list[Hashable] = []
    leaves: list[tuple[Shape, tuple[Step, ...]]] = []
    painted: list[tuple[int, int, Painted]] = []
    pending: list[tuple[Any, tuple[Step, ...], int]] = [(solid, (), -1)]
    while pending:
        node, steps, first = pending.pop()
        if first >= 0:
            painted.append((first, len(leaves), node))
            continue
        mine = () if still and node is solid else node.motion.steps
        inner = mine + steps if mine else steps
        kind: Any = type(node)
        if is_subclass(kind, Boolean):
            operands = node.operands
            key.append((kind, len(operands)))
            if kind is Painted:
                pending.append((node, steps, len(leaves)))
            pending.extend((part, inner, -1) for part in reversed(operands))
        elif is_subclass(kind, PrimitiveSolid):
            key.append(kind)
            leaves.append((node, inner))
        else:
            return None
    return CsgPlan(tuple(key), leaves, painted)


def placed_primitives(shape: Shape) -> list[tuple[Shape, tuple[Step, ...]]]:
    """List the primitives of a shape with the steps that move each; the shape itself where it has no plan."""
    plan = csg_plan(shape) if isinstance(shape, Boolean) else None
    return [(shape, shape.motion.steps)] if plan is None else plan.leaves


def fold_plan(key: Sequence[Hashable], leaves: Sequence[Any], combined: Callable[[Any, list[Any]], Any]) -> Any:
    """Fold a plan over one value for each leaf, from the leaves up: `combined(node type, operands)`."""
    results: list[Any] = []
    rest = list(leaves)
    for entry in reversed(key):  # nodes come before their operands
        if not isinstance(entry, tuple):
            results.append(rest.pop())
            continue
        kind, count = entry
        parts = results[-count:][::-1]
        del results[-count:]
        results.append(combined(kind, parts))
    return results[0]


@dataclass(frozen=True, eq=False)
class PrimitiveForm:
    """The lowered structure of primitives of one kind. There is one object of each (`PrimitiveForms`)."""

    pattern: BodyPattern
    tree: Tree | None


class PrimitiveForms:
    """A registry of forms: equal pattern and tree give the same object."""

    def __init__(self) -> None:
        self._cache: dict[Hashable, PrimitiveForm] = {}

    def of(self, pattern: BodyPattern, tree: Tree | None) -> PrimitiveForm:
        """Return the form of a pattern and a tree."""
        return self._cache.setdefault((pattern, tree), PrimitiveForm(pattern, tree))


FORMS = PrimitiveForms()


# Boxes around Boolean bodies of one plan, from the rows of their primitives.

Mask: TypeAlias = npt.NDArray[np.bool_]
EMPTY_BOX = np.array([np.inf] * 3 + [-np.inf] * 3)
UNBOUNDED_BOX = -EMPTY_BOX


def bound_bodies(
    key: Sequence[Hashable], shapes: Sequence[Shape], forms: Sequence[PrimitiveForm], rows: Sequence[RowTable]
) -> tuple[Floats, Mask]:
    """Return boxes (n, 6) around Boolean bodies of one plan, and which of them are certain (n,).

    Parameters
    ----------
    key : sequence
        The plan, as `CsgPlan.key`.
    shapes, forms, rows : sequences
        The primitives of one of the bodies; the forms and rows of the primitives of all.
    """
    boxes, certain = np.empty((len(rows[0]), BOX_NUMBERS)), np.empty(len(rows[0]), bool)
    holes = [shape.has_unbounded_outside(form.tree) for shape, form in zip(shapes, forms, strict=True)]  # type: ignore[attr-defined]
    for some in row_blocks(len(boxes)):
        boxes[some], certain[some] = _simple_boxes(key, shapes, holes, [part[some] for part in rows])
    others = np.flatnonzero(~certain)
    if len(others):
        boxes[others], certain[others] = _narrow_boxes(key, shapes, forms, [part[others] for part in rows])
    return boxes, certain


# Bounds of Boolean bodies of one plan from the boxes of their primitives, where these suffice
#
# They are the bounds that `region_bounds` computes with more work: a union surrounds its parts, and the
# parts of an intersection narrow one another. Where only one part of an intersection has a bound, and the others are
# complements of shapes with an unbounded outside, the box is that part's. Where several parts have bounds, and these
# are balls and axis-aligned boxes, it is that of `geometry.bounds.intersection`.


def box_columns(rows: RowTable) -> Floats:
    """Return the boxes in rows of primitives without polygons: these rows end with box and frame."""
    return rows[:, -BOX_NUMBERS - FRAME_NUMBERS : -FRAME_NUMBERS]


@dataclass
class _BoundPart:
    """One primitive of each body: its boxes, its type, and its rows."""

    boxes: Floats
    kind: BoundsKind
    rows: RowTable

    @property
    def is_ball(self) -> bool:
        """Is it a ball, where `simple` holds?"""
        return self.kind == "ball"

    def simple(self) -> Mask:
        """Return for which bodies it is a ball, or an axis-aligned box."""
        return are_balls_or_boxes(self.kind, self.rows[:, -FRAME_NUMBERS:].reshape(-1, 3, 4)[:, :, :3])


@dataclass
class _BoundNode:
    """A node of a plan: its boxes (None for all of space), and for which bodies they are right.

    `hole`: nothing bounds the outside of the node. `parts`: the primitives whose intersection holds the node; None for
    a union. `is_common`: an intersection or difference, whose outside is a union.
    """

    boxes: Floats | None
    known: Mask
    hole: bool = False
    parts: tuple[_BoundPart, ...] | None = ()
    is_common: bool = False


def _simple_boxes(
    key: Sequence[Hashable], leaves: Sequence[Shape], holes: Sequence[bool], rows: Sequence[RowTable]
) -> tuple[Floats, Mask]:
    """Compute the boxes (n, 6) of bodies from rows of their primitives; `holes` says whose outside is unbounded.

    Return also for which of them they are known.
    """
    primitives = [_primitive_bounds(*each) for each in zip(leaves, holes, rows, strict=True)]
    whole: _BoundNode = fold_plan(key, primitives, _combine_bounds)
    found = whole.boxes
    if found is None:
        return np.tile(UNBOUNDED_BOX, (len(rows[0]), 1)), whole.known
    return np.where(np.asarray((found[:, :3] > found[:, 3:]).any(axis=1))[:, None], EMPTY_BOX, found), whole.known


def _primitive_bounds(shape: Shape, hole: bool, rows: RowTable) -> _BoundNode:
    boxes = box_columns(rows)
    part = _BoundPart(boxes, shape.bounds_kind, rows)
    return _BoundNode(boxes, np.ones(len(rows), bool), hole, (part,))


def _combine_bounds(kind: Hashable, parts: Sequence[_BoundNode]) -> _BoundNode:
    """Combine operands to a node of a type."""
    if kind is Painted or (len(parts) == 1 and kind is not Complement):
        return parts[0]
    holes, every = [part.hole for part in parts], np.ones(len(parts[0].known), bool)
    if kind is Union:
        known = np.asarray(np.logical_and.reduce([part.known for part in parts]))
        boxes = [part.boxes for part in parts if part.boxes is not None]
        return _BoundNode(_union_boxes(boxes) if len(boxes) == len(parts) else None, known, all(holes), None)
    is_common = kind is Intersection
    inside, outside = (parts, ()) if is_common else ((), parts) if kind is Complement else (parts[:1], parts[1:])
    # The outside of an intersection is a union: where one of its parts is unbounded, so is all of it
    hole, is_both = any(part.hole for part in inside), kind is not Complement
    nowhere = _BoundNode(None, ~every, hole, None, is_both)
    if not (is_common or kind in (Difference, Complement)) or not all(part.hole for part in outside):
        return nowhere
    known = np.asarray(np.logical_and.reduce([every, *(part.known for part in inside)]))
    bounded = [part for part in inside if part.boxes is not None]
    # `region_bounds` passes planes on to the parts of a union
    is_cut = any(part.parts is None for part in (*inside, *outside)) or any(part.is_common for part in outside)
    if len(bounded) < 2:
        one = bounded[0] if bounded else _BoundNode(None, known)
        if is_cut and len(one.parts or ()) > 1:
            return nowhere
        return _BoundNode(one.boxes, known, hole, None if is_cut else one.parts, is_both)
    if is_cut:
        return nowhere
    common = tuple(each for part in bounded for each in part.parts or ())
    boxes_in_common, good = _intersect_boxes(common)
    return _BoundNode(boxes_in_common, known & good, hole, common, is_both)


def _union_boxes(boxes: Sequence[Floats]) -> Floats:
    """Compute boxes around boxes, row by row; empty ones do not count."""
    low = np.full((len(boxes[0]), 3), np.inf)
    high = -low
    for box in boxes:
        is_box = np.asarray((box[:, :3] <= box[:, 3:]).all(axis=1))[:, None]
        low = np.where(is_box, np.minimum(low, box[:, :3]), low)
        high = np.where(is_box, np.maximum(high, box[:, 3:]), high)
    return np.concatenate([low, high], axis=1)


def _intersect_boxes(parts: Sequence[_BoundPart]) -> tuple[Floats, Mask]:
    """Return (boxes around the intersection of primitives, for which bodies these are known)."""
    boxes, good = bound_ball_intersections([part.boxes for part in parts], [part.is_ball for part in parts])
    return boxes, np.asarray(np.logical_and.reduce([good, *(part.simple() for part in parts)]))


# Plans: which planes and quadrics contain each part of a body
#
# As in `geometry.bounds.intersection.region_bounds`: complements move down to the primitives, nested intersections are
# one, and the planes of an intersection cut the unions in it.

_DEEPEST, _WIDEST = 8, 256
"""Unions are followed so many levels deep; planes cut those that are at most so many operands wide."""
_MAX_COMPLEMENTS = 32
"""With more complements than this, only half-spaces among them count: holes seldom narrow a body."""


@dataclass(frozen=True)
class _Leaf:
    """A primitive of all bodies: its class, its form, and its rows."""

    shape: Shape
    form: PrimitiveForm
    rows: RowTable


@dataclass(frozen=True)
class _Gate:
    """A Boolean node."""

    kind: Any
    parts: Sequence[_Node]


_Node: TypeAlias = _Leaf | _Gate


def _narrow_boxes(
    key: Sequence[Hashable], shapes: Sequence[Shape], forms: Sequence[PrimitiveForm], rows: Sequence[RowTable]
) -> tuple[Floats, Mask]:
    """Return `bound_bodies` of bodies whose parts may narrow one another in any way."""
    leaves = [_Leaf(*each) for each in zip(shapes, forms, rows, strict=True)]
    tree: _Node = fold_plan(key, leaves, _Gate)
    everywhere = np.tile(UNBOUNDED_BOX, (len(rows[0]), 1))
    return _bound(tree, True, everywhere, np.zeros((len(everywhere), 0)), 0)


def _bound(node: _Node, inside: bool, box: Floats, cuts: Floats, depth: int) -> tuple[Floats, Mask]:
    """Return `_narrow_boxes` of a node, or of its outside, within boxes and planes (n, 7 p) around it."""
    leaves, unions = _conjuncts(node, inside)
    low, high = box[:, :3], box[:, 3:]
    for leaf, inner in leaves:
        if inner:
            own = box_columns(leaf.rows)
            low, high = np.maximum(low, own[:, :3]), np.minimum(high, own[:, 3:])
    is_alone = len(leaves) == 1 and inner and not (unions or cuts.shape[1] or np.isfinite(box).any())
    box = np.ascontiguousarray(np.concatenate([low, high], axis=1))
    if is_alone:
        return box, np.ones(len(box), bool)
    common = box.copy()
    planes, quadrics, senses = _surfaces(leaves, len(box))
    planes = np.concatenate([cuts, planes], axis=1)
    for _ in range(2):  # what bounds the height of a cone bounds its width
        endless = np.flatnonzero(~np.isfinite(box).all(axis=1))
        if not len(endless):
            break
        some = box[endless]
        _bound_cut_quadrics(planes[endless], quadrics[endless], senses[endless], some)
        sides = np.concatenate([planes[endless], *_slabs(quadrics[endless], senses[endless], some)], axis=1)
        _cut_by_upright_planes(some, sides.reshape(len(some), -1, PLANE_SIZE))
        bound_by_corners(sides, some, np.empty((sides.shape[1] // PLANE_SIZE, 2)))
        box[endless] = some
    boundless = ~np.isfinite(box).all(axis=1)
    known = _narrow(planes, quadrics, senses, box)
    if planes.shape[1] and not unions and not known.all():
        endless = boundless & (box == common).all(axis=1) & ~_can_bound(quadrics, senses)
        known[endless] = _are_open(planes[endless], box[endless])
    if unions and depth == _DEEPEST:
        # What these unions cut away is left; where nothing else bounds them, they are not known
        return box, known & np.isfinite(box).all(axis=1)
    for parts in unions:
        shared = planes if len(parts) <= _WIDEST else planes[:, :0]
        each: list[Floats] = []
        for part, inner in parts:
            own, sure = _bound(part, inner, box, shared, depth + 1)
            known &= sure
            each.append(own)
        outer = _union_boxes(each)
        box = np.concatenate([np.maximum(box[:, :3], outer[:, :3]), np.minimum(box[:, 3:], outer[:, 3:])], axis=1)
    empty = np.asarray((box[:, :3] > box[:, 3:]).any(axis=1))
    box = np.where(empty[:, None], EMPTY_BOX, box)
    again = ~known & boundless & np.isfinite(box).all(axis=1)
    if again.any():  # a union bounds what others and the quadrics left endless
        own, sure = _bound(node, inside, box, cuts, depth)
        box, known = np.where(again[:, None], own, box), np.where(again, sure, known)
    return box, known | empty


def _narrow(planes: Floats, quadrics: Floats, senses: Signs, box: Floats) -> Mask:
    """Narrow boxes by planes and quadrics around bodies; return for which bodies they are certain."""
    certain = np.ones(len(box), np.int8)
    if planes.shape[1] > PLANE_SIZE * MAX_PLANES:
        certain[:] = 0
    elif planes.shape[1] or quadrics.shape[1]:
        work = np.empty((planes.shape[1] // PLANE_SIZE + SIDES, 4))
        narrow_csg_boxes(
            planes, quadrics, senses, box, certain, work, np.empty(12), np.empty(10), np.empty(12)
        )  # fmt: skip
    return certain.astype(bool)


_LEVEL, _RISING = 2.0**-40, 2.0**-20
"""Cosines of two ways below which they count as across one another, and above which they do not."""


def _are_open(planes: Floats, box: Floats) -> Mask:
    """Return whether regions between planes (n, 7 p) are endless wherever boxes (n, 6) are; False if it is not sure.

    A region is endless along each way that leaves it through no plane. Those tried are the ways away from a plane, the
    axes along it, and the lines common to two planes: the edges of the cone of all such ways are among these. A region
    is not empty if a way leads away from all planes, or from all but those of a slab.
    """
    records = planes.reshape(len(box), planes.shape[1] // PLANE_SIZE, PLANE_SIZE)
    normals, sizes = unit_rows(records[:, :, :3])
    along = np.eye(3) - normals[..., None] * normals[..., None, :]
    first, second = np.triu_indices(normals.shape[1], 1)
    lines = [along.reshape(len(box), 3 * normals.shape[1], 3), cross_rows(normals[:, first], normals[:, second])]
    ways = unit_rows(np.concatenate([*lines, *(-line for line in lines), -normals], axis=1))[0]
    stays = np.asarray((dot_rows(ways[:, :, None], normals[:, None]) <= _LEVEL).all(axis=2))
    ends = (np.concatenate([-ways, ways], axis=2) > _RISING) & stays[..., None]
    inward = np.where(stays[..., None], ways, 0.0).sum(axis=1)
    holds = np.asarray(dot_rows(inward[:, None], normals) > -_RISING)
    slab = normals[np.arange(len(box)), holds.argmax(axis=1)][:, None]
    is_level = row_lengths(cross_rows(normals, slab)) <= _LEVEL
    heights = dot_rows(normals, records[:, :, 4:]) - records[:, :, 3] / sizes
    is_upper = dot_rows(normals, slab) > 0
    top = np.where(holds & is_upper, heights, np.inf).min(axis=1)
    bottom = np.where(holds & ~is_upper, -heights, -np.inf).max(axis=1)
    has_room = top - bottom > _LEVEL * (np.abs(top) + np.abs(bottom))
    is_filled = ~holds.any(axis=1) | ((is_level | ~holds).all(axis=1) & has_room)
    return np.asarray((np.isfinite(box) | ends.any(axis=1)).all(axis=1) & is_filled)


def _can_bound(quadrics: Floats, senses: Signs) -> Mask:
    """Return for which bodies one of the quadrics may bound anything (`geometry.bounds.intersection`)."""
    squares = quadrics.reshape(len(senses), senses.shape[1], QUADRIC_SIZE)[:, :, 12:15]
    return np.asarray((senses[:, :, None] * squares > 0).any(axis=(1, 2)))


def _conjuncts(node: _Node, inside: bool) -> tuple[list[tuple[_Leaf, bool]], list[list[tuple[_Node, bool]]]]:
    """Return the primitives, and the operands of the unions, whose intersection a node or its outside is."""
    leaves: list[tuple[_Leaf, bool]] = []
    unions: list[list[tuple[_Node, bool]]] = []
    pending = [(node, inside)]
    while pending:
        part, inner = pending.pop()
        if isinstance(part, _Leaf):
            leaves.append((part, inner))
            continue
        operands = list(zip(part.parts, part.kind._sides(len(part.parts), inner), strict=True))
        if len(operands) == 1 or part.kind._is_intersection(inner):
            pending.extend(reversed(operands))
        else:
            unions.append(operands)
    return leaves, unions


def _surfaces(leaves: Sequence[tuple[_Leaf, bool]], count: int) -> tuple[Floats, Floats, Signs]:
    """Return the records of planes and quadrics around an intersection of primitives, and the senses of quadrics."""
    planes, quadrics, senses = [np.zeros((count, 0))], [np.zeros((count, 0))], [np.zeros((count, 0), np.int8)]
    many = sum(not inner for _, inner in leaves) > _MAX_COMPLEMENTS
    for leaf, inner in leaves:
        if many and not inner and leaf.shape.bounds_kind != "half_space":
            continue
        assert leaf.form.tree is not None
        for face, sense in bounding_faces(leaf.form.tree, inner):
            kind, at, sense_at = leaf.form.pattern.records[int(face.surface)]  # type: ignore[call-overload]
            signs = sense * leaf.rows[:, sense_at]
            if kind == PLANE:
                record = np.array(leaf.rows[:, at : at + PLANE_SIZE])
                record[:, :4] *= signs[:, None]
                planes.append(record)
                continue
            quadrics.append(_as_quadric(leaf.rows, at) if kind == SPHERE else leaf.rows[:, at : at + QUADRIC_SIZE])
            senses.append(signs.astype(np.int8)[:, None])
    return np.concatenate(planes, axis=1), np.concatenate(quadrics, axis=1), np.concatenate(senses, axis=1)


def _as_quadric(rows: RowTable, at: int) -> Floats:
    """Return spheres as records of quadrics."""
    found = np.zeros((len(rows), QUADRIC_SIZE))
    found[:, :3] = rows[:, at : at + 3]
    found[:, [3, 7, 11, 12, 13, 14]] = 1.0
    found[:, 18] = rows[:, at + 3] ** 2
    return found


def _slabs(quadrics: Floats, senses: Signs, box: Floats) -> list[Floats]:
    """Return records of planes around quadrics in boxes; a normal of zeros stands for none.

    With u = y + slope / square, a quadric is the sum of square u² over its rows of positive squares, at most a constant
    and what the other rows add. Their y is between the ends that the box gives, and what they add is largest at one.
    """
    found: list[Floats] = []
    for k in range(senses.shape[1]):
        record = quadrics[:, QUADRIC_SIZE * k : QUADRIC_SIZE * (k + 1)]
        sense = senses[:, k, None]
        squares, slopes, anchor = sense * record[:, 12:15], sense * record[:, 15:18], record[:, :3]
        rows, ends = record[:, 3:12].reshape(-1, 3, 3), np.stack([box[:, :3], box[:, 3:]], axis=1)[:, :, None]
        with np.errstate(all="ignore"):
            terms = np.where(rows[:, None] == 0, 0.0, rows[:, None] * (ends - anchor[:, None, None]))
            blur = np.where(rows == 0, 0.0, np.abs(rows) * (np.abs(ends).max(axis=1) + np.abs(anchor)[:, None]))
            blur = 8 * FLOAT_ERROR * blur.sum(axis=2)
            y = np.stack([terms.min(axis=1).sum(axis=2) - blur, terms.max(axis=1).sum(axis=2) + blur], axis=1)
            more = np.where(squares[:, None] == 0, 0.0, -squares[:, None] * y * y)
            more = (more - np.where(slopes[:, None] == 0, 0.0, 2 * slopes[:, None] * y)).max(axis=1)
            middle = np.where(squares > 0, slopes / squares, 0.0)
            more = np.where(squares > 0, slopes * middle, more)
            limit = sense[:, 0] * record[:, 18] + more.sum(axis=1)
            limit += 8 * FLOAT_ERROR * (np.abs(record[:, 18]) + np.abs(more).sum(axis=1))
            reach = np.sqrt(np.maximum(limit, 0.0)[:, None] / squares) * (1.0 + 8 * FLOAT_ERROR)
        closed = (squares > 0) & np.isfinite(reach)
        for row in np.flatnonzero(closed.any(axis=0)).tolist():
            some = closed[:, row]
            for sign in (1.0, -1.0):
                planes = np.zeros((len(record), PLANE_SIZE))
                planes[some, :3] = sign * rows[some, row]
                planes[some, 3] = sign * middle[some, row] - reach[some, row]
                planes[:, 4:] = anchor
                found.append(planes)
    return found


_BLUR, _PAD = 2.0**-40, 2.0**-30
"""More than the relative rounding of a sum of records' numbers, and of a bound."""
_STEEP = 2.0**-8
"""By this share a plane must be steeper than the quadric that it cuts off."""


def _bound_cut_quadrics(planes: Floats, quadrics: Floats, senses: Signs, box: Floats) -> None:
    """Narrow boxes, which may be infinite, around quadrics without end that planes cut off.

    With u = y + slope / square, and v that of the one row whose square is not positive: Q, the sum of square u² over
    the other rows, is at most c - square v², or c - 2 slope v where that square is 0. A plane m·u <= d then bounds v:
    m·u is at least m_v v - spread √Q, with spread² the sum of m² / square. The box is made twice as wide as found, so
    that rounding does not matter.
    """
    records = planes.reshape(len(senses), planes.shape[1] // PLANE_SIZE, PLANE_SIZE)
    normals, anchors, above = records[:, :, :3], records[:, :, 4:], records[:, :, 3]
    for record, sense in zip(np.split(quadrics, senses.shape[1] or 1, axis=1), senses.T[:, :, None], strict=False):
        squares, slopes, anchor = sense * record[:, 12:15], sense * record[:, 15:18], record[:, None, :3]
        rows = record[:, 3:12].reshape(-1, 3, 3)
        for row in np.flatnonzero(((squares <= 0).sum(axis=1) == 1) @ (squares <= 0)).tolist():
            others = [k for k in range(3) if k != row]
            with np.errstate(all="ignore"):
                middle = np.where(squares != 0, slopes / squares, 0.0)
                inverse = cross_rows(rows[:, [1, 2, 0]], rows[:, [2, 0, 1]])
                inverse /= dot_rows(rows[:, :1], inverse[:, :1])[:, :, None]
                m = dot_rows(normals[:, :, None], inverse[:, None])
                d = dot_rows(normals, anchors - anchor) - above + dot_rows(m, middle[:, None])
                blur = dot_rows(np.abs(normals), np.abs(anchors) + np.abs(anchor)) + np.abs(above)
                d += _BLUR * (blur + dot_rows(np.abs(m), np.abs(middle)[:, None]))
                c = sense[:, 0] * record[:, 18] + dot_rows(slopes, middle)
                c += _BLUR * (np.abs(record[:, 18]) + dot_rows(np.abs(slopes), np.abs(middle)))
                sizes = dot_rows(np.abs(normals)[:, :, None], np.abs(inverse)[:, None])
                m_most = np.abs(m[:, :, others]) + _BLUR * sizes[:, :, others]
                spread = np.sqrt((m_most**2 / squares[:, None, others]).sum(axis=2))
                bend = -squares[:, row, None]
                slope = np.where(bend > 0, 0.0, slopes[:, row, None])
                high, low = (
                    sign * _end_of_row(sign * m[:, :, row], sign * slope, spread, bend, d, c, sizes[:, :, row])
                    for sign in (1.0, -1.0)
                )
                most = np.maximum(*(c + bend[:, 0] * v * v - 2.0 * slope[:, 0] * v for v in (low, high)))
                reach = np.sqrt(np.maximum(most, 0.0)[:, None] / squares)
                center, reach[:, row] = -middle, 0.5 * np.abs(high - low)
                center[:, row] += 0.5 * (high + low)
                reach = 2.0 * reach + _PAD * (np.abs(center) + reach)
                at = anchor[:, 0] + dot_rows(inverse.swapaxes(1, 2), center[:, None])
                far = dot_rows(np.abs(inverse).swapaxes(1, 2), reach[:, None])
                far += _PAD * (np.abs(at) + np.abs(anchor[:, 0]))
            closed = ((squares[:, others] > 0).all(axis=1) & np.isfinite(far).all(axis=1))[:, None]
            box[:, :3] = np.where(closed, np.maximum(box[:, :3], at - far), box[:, :3])
            box[:, 3:] = np.where(closed, np.minimum(box[:, 3:], at + far), box[:, 3:])


def _end_of_row(
    rise: Floats, slope: Floats, spread: Floats, bend: Floats, d: Floats, c: Floats, size: Floats
) -> Floats:
    """Return the largest v with Q <= c + bend v² - 2 slope v and rise v - spread √Q <= d, the least over all planes.

    Infinity if no plane of them is steep enough; `size` bounds the terms of `rise`.
    """
    growth, loss, root = -2.0 * slope, spread * np.sqrt(bend), np.sqrt(np.maximum(c, 0.0))[:, None]
    straight = (d + spread * root) / (rise - loss)
    straight = np.where(bend > 0, np.maximum(straight, 0.0), straight)
    slant = rise / growth
    width = spread + np.sqrt(spread * spread + 4.0 * slant * (d + slant * c[:, None]))
    end = np.where(growth > 0, ((width / (2.0 * slant)) ** 2 - c[:, None]) / growth, straight)
    is_steep = rise - loss > _STEEP * (rise + loss + _STEEP * size)
    end = np.where(is_steep & np.isfinite(end), end, np.inf).min(axis=1, initial=np.inf)
    # Q is not negative: this bounds a paraboloid towards its vertex
    return np.where(growth[:, 0] < 0, -c / growth[:, 0], end)


def _cut_by_upright_planes(box: Floats, planes: Floats) -> None:
    """Narrow boxes, which may be infinite, by those of some planes (n, planes, 7) that are across an axis."""
    normals, anchors = planes[:, :, :3], planes[:, :, 4:]
    alone = (normals != 0).sum(axis=2, keepdims=True) == 1
    with np.errstate(all="ignore"):
        over = planes[:, :, 3, None] / normals
        blur = FLOAT_ERROR * (np.abs(anchors) + np.abs(over))
        high = np.where(alone & (normals > 0), anchors - over + blur, np.inf)
        low = np.where(alone & (normals < 0), anchors - over - blur, -np.inf)
    box[:, :3] = np.maximum(box[:, :3], low.max(axis=1, initial=-np.inf))
    box[:, 3:] = np.minimum(box[:, 3:], high.min(axis=1, initial=np.inf))
