"""Split solids into the pieces of `pieces.py`: named shapes by rules of their own, all others by their cells.

`BodyBox` bounds the unbounded parts of a body: a box around the body, in the frame of any of its parts.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from functools import lru_cache
from typing import Any, TypeAlias

import numpy as np

from ..._util.arrays import Matrix4, Vector
from ..._util.records import dataclass
from ...geometry.cell import Any_, Cell, Face, Not, Tree
from ...geometry.polyhedron import Extrusion, Mesh, Polyhedron
from ...geometry.primitives import Box, Cone, Cylinder, HalfSpace, Sphere, axis_length
from ...geometry.quadrics import Ellipsoid
from ...geometry.revolution import Revolution
from ...geometry.shape import Boolean, Complement, Difference, Painted, PrimitiveSolid, Solid, Union
from ...geometry.surface import UPRIGHT, PlaneSurface, QuadricSurface
from ...geometry.transform import IDENTITY_MOTION, Motion, Scale, Step, Transform, Translate
from ...numerics import bigfloat as ex
from .exporters import UnsupportedExport, hex_color, shortest_decimal
from .pieces import (
    _AXIS_TURNS,
    BallPiece,
    BoxPiece,
    EllipsoidPiece,
    ExtrusionPiece,
    FrustumPiece,
    PieceBoolean,
    PieceBooleanKind,
    PieceLeaf,
    PieceNode,
    PolyhedronPiece,
    QuadricPiece,
    RevolutionPiece,
    Steps,
    axis_steps,
    clip_box,
    upright_box,
)

# Boxes around bodies.


@dataclass(frozen=True)
class BodyBox:
    """A box around a body in the world, and the motion from a frame to the world."""

    low: Vector
    high: Vector
    motion: Motion = IDENTITY_MOTION

    def in_frame(self, motion: Motion) -> BodyBox:
        """Return the same box in the frame of a part that `motion` moves into this frame."""
        return BodyBox(self.low, self.high, motion.then(self.motion)) if motion.steps else self

    @property
    def box(self) -> BoxPiece:
        """A box of short numbers around the body in the frame, with a margin about as large as the body on each side.

        Raise OverflowError if it leaves the range of float64.
        """
        low, high = np.array(self.low), np.array(self.high)
        if self.motion.steps:
            corners = np.array([[(low, high)[k >> i & 1][i] for i in range(3)] for k in range(8)])
            rows = self.motion.inverse_matrix
            corners = corners @ rows[:3, :3].T + rows[:3, 3]
            low, high = corners.min(axis=0), corners.max(axis=0)
        size = float((high - low).max())
        # A power of two near half the size keeps the numbers short, and two steps of it leave room on each side.
        step = 2.0 ** math.floor(math.log2(size)) / 2 if size > 0 else 1.0
        least, most = (np.floor(low / step) - 2) * step, (np.ceil(high / step) + 2) * step
        if not (np.isfinite(least).all() and np.isfinite(most).all()):
            raise OverflowError
        x, y, z = least.tolist()
        a, b, c = most.tolist()
        return BoxPiece((x, y, z), (a, b, c))


def compute_body_box(solid: Solid) -> BodyBox:
    """Return the box around a body. Raise UnsupportedExport for an unbounded or empty body."""
    low, high = solid.bounds
    if (low > high).any():
        raise UnsupportedExport("there is nothing in it")
    if not (np.isfinite(low).all() and np.isfinite(high).all()):
        raise UnsupportedExport("it has no end on some side: intersect it with a Box that is large enough")
    return BodyBox(tuple(low.tolist()), tuple(high.tolist()))


# Quadric surfaces as pieces, in their own frame: ellipsoids, cylinders, cones, and bowls of revolution.

_CYCLES = {2: (0, 1, 2), 0: (1, 2, 0), 1: (2, 0, 1)}
"""Axis of revolution -> the axes in cyclic order that ends with it."""


def split_quadric(surface: QuadricSurface, room: BodyBox) -> PieceNode:
    """Return the inside of a quadric, as far as the box reaches.

    Raise UnsupportedExport for a quadric that is no ellipsoid, cylinder, cone, paraboloid or hyperboloid of one sheet.
    """
    # Exact numbers throughout: whether a quadric is a cone or a hyperboloid hangs on one coefficient being zero
    steps, is_rounded = _frame_steps(surface)
    squares = [ex.exact(value) for value in surface.squares]
    linear = [ex.exact(value) for value in surface.linear]
    constant = ex.exact(surface.constant)
    for axis, order in _CYCLES.items():
        a, b, c = (squares[i] for i in order)
        p, q, s = (linear[i] for i in order)
        # Round about this axis means equal signs across it and a centre on it
        if not (a > 0 and b > 0) or p or q:
            continue
        # Pieces stand along z, so another axis is turned there
        turn: Steps = () if axis == 2 else (Transform(_AXIS_TURNS[axis]),)
        node = _about_z((a, b, c), s, constant, room.in_frame(Motion((*turn, *steps))))
        if node is None:
            continue
        if isinstance(node, PieceLeaf):
            node = replace(node, is_rounded=node.is_rounded or is_rounded)
        return _move_node(node, (*turn, *steps))
    raise UnsupportedExport("a quadric of it is no ellipsoid, cylinder, cone, paraboloid or hyperboloid of one sheet")


def _frame_steps(surface: QuadricSurface) -> tuple[Steps, bool]:
    """Return the steps from the quadric's own coordinates y = rows (x - anchor) to x, and whether they are rounded."""
    anchor = [ex.exact(value) for value in surface.anchor]
    shift = [ex.rounded(value) for value in anchor]
    is_rounded = any(ex.cancelling_sum((a, -ex.exact(b))) for a, b in zip(anchor, shift, strict=True))
    steps: list[Step] = []
    if surface.rows is not UPRIGHT:
        rows = tuple(ex.exact_row(row) for row in surface.rows)
        back = ex.inverse((rows[0], rows[1], rows[2]))
        numbers = [[ex.rounded(value) for value in row] for row in back]
        for exact_row, row in zip(back, numbers, strict=True):
            is_rounded = is_rounded or any(
                ex.cancelling_sum((a, -ex.exact(b))) for a, b in zip(exact_row, row, strict=True)
            )
        (a, b, c), (d, e, f), (g, h, i) = numbers
        if not any((b, c, d, f, g, h)):
            steps.append(Scale((a, e, i)))
        else:
            matrix: Matrix4 = ((a, b, c, 0.0), (d, e, f, 0.0), (g, h, i, 0.0), (0.0, 0.0, 0.0, 1.0))
            steps.append(Transform(matrix))
    if any(shift):
        steps.append(Translate((shift[0], shift[1], shift[2])))
    return tuple(steps), is_rounded


def _about_z(squares: ex.Row, s: ex.BigFloat, constant: ex.BigFloat, room: BodyBox) -> PieceNode | None:
    """Return a x² + b y² + c z² + 2 s z <= `constant` with a, b > 0 as a node; None if another axis may fit."""
    a, b, c = squares
    if c > 0:
        # The anchor is the centre of an ellipsoid; with a linear term another axis, or none, fits
        if s or not constant > 0:
            return None
        radii = [_root(constant / square) for square in squares]
        x, y, z = (radius for radius, _ in radii)
        return PieceLeaf(EllipsoidPiece((x, y, z)), (), not all(is_exact for _, is_exact in radii))
    steps: Steps = ()
    is_rounded = False
    if ex.cancelling_sum((a, -b)):  # an elliptic section is a circle, scaled along y
        factor, is_exact = _root(a / b)
        steps, is_rounded = (Scale((1.0, factor, 1.0)),), not is_exact
    g0, g1, g2 = (ex.cancelling_sum((value / a,)) for value in (constant, -2 * s, -c))
    box = room.in_frame(Motion(steps)).box
    low, high = box.low[2], box.high[2]
    # The discriminant of the profile r² = g0 + g1 z + g2 z²: zero at an apex
    square = ex.cancelling_sum((g1 * g1, -4 * g0 * g2))
    if not g1 and not g2:
        if not g0 > 0:
            return None
        radius, is_exact = _root(g0)
        return PieceLeaf(FrustumPiece(radius, radius, low, high), steps, is_rounded or not is_exact)
    if g2 and not square:
        return _double_cone(g1, g2, low, high, steps, is_rounded)
    if g2 and (square > 0 or g0 < 0):
        return None  # two sheets, which no piece holds
    rounded = is_rounded or any(map(ex.is_rounded, (g0, g1, g2)))
    return PieceLeaf(QuadricPiece(ex.fraction(g0), ex.fraction(g1), ex.fraction(g2), low, high), steps, rounded)


def _double_cone(
    g1: ex.BigFloat, g2: ex.BigFloat, low: float, high: float, steps: Steps, is_rounded: bool
) -> PieceNode:
    """Return x² + y² <= g2 (z - apex)² between two heights: both nappes, or one, as revolutions."""
    apex, slope = ex.cancelling_sum((-g1 / (2 * g2),)), _root(g2)
    at = ex.rounded(apex)
    is_rounded = is_rounded or not slope[1] or bool(ex.cancelling_sum((apex, -ex.exact(at))))
    nappes: list[PieceNode] = []
    for z in (low, high):
        radius = Fraction(slope[0]) * abs(Fraction(z) - Fraction(at))
        # A nappe reaches from the apex to the end of the box on its side, if the apex lies within the box
        if (z < at) == (z == low) and radius:
            wide = float(radius)
            profile = ((0.0, at), (wide, z), (0.0, z))
            nappes.append(PieceLeaf(RevolutionPiece(profile), (), is_rounded or Fraction(wide) != radius))
    if not nappes:
        raise UnsupportedExport("a part of it is empty")
    return _move_node(nappes[0] if len(nappes) == 1 else PieceBoolean("union", tuple(nappes)), steps)


def _root(value: ex.BigFloat) -> tuple[float, bool]:
    """Return the square root as a float, and whether it is exact."""
    root = ex.cancelling_sum((ex.sqrt(value),))
    near = ex.rounded(root)
    return near, not ex.cancelling_sum((root, -ex.exact(near)))


# Booleans.

MAX_TREE_DEPTH = 60
"""Most levels of Booleans within Booleans."""


PieceRule: TypeAlias = Callable[[Solid], "PieceLeaf | None"]
"""Returns the piece that a format has for a solid, without the motion of the solid; None for most solids."""


def split_into_pieces(solid: Solid, rule: PieceRule | None = None) -> PieceNode:
    """Return the pieces of a body; `rule` may return a piece of the format for any part.

    Raise UnsupportedExport for a body that is unbounded, empty, or not of planes and quadrics.
    """
    return _PieceBuilder(rule).node(solid, compute_body_box(solid), 0)


@dataclass(frozen=True)
class _PieceBuilder:
    """Descends a tree of Booleans."""

    rule: PieceRule | None

    def node(self, solid: Solid, room: BodyBox, depth: int) -> PieceNode:
        """Return the node of a solid within a box. Raise UnsupportedExport."""
        # The descent is recursive, and readers of other programs are too
        if depth >= MAX_TREE_DEPTH:
            raise UnsupportedExport(f"it nests Booleans deeper than {MAX_TREE_DEPTH} levels")
        piece = None if self.rule is None else self.rule(solid)
        # The format has an element for this very solid, so that it comes back as it was
        if piece is not None:
            return _move_node(piece, solid.motion.steps)
        if isinstance(solid, Boolean):
            return self._combined(solid, room.in_frame(solid.motion), depth + 1)
        if not isinstance(solid, PrimitiveSolid):
            raise UnsupportedExport(f"{type(solid).__name__} is no solid of planes and quadrics")
        return _primitive(solid, room)

    def _combined(self, solid: Boolean, room: BodyBox, depth: int) -> PieceNode:
        """Return a Boolean. Complements are cut from the other operands, or from the box if there are none."""
        steps = solid.motion.steps
        if isinstance(solid, Painted):
            # No format has colours of single faces
            color = hex_color(solid.material)[0] if solid.faces is None else None
            return PieceBoolean("union", (self.node(solid.operand, room, depth),), steps, color)
        # A complement is unbounded, and no format has endless solids: within the box of the body it is the box less the
        # operand
        if isinstance(solid, Complement):
            return PieceBoolean("difference", (PieceLeaf(room.box), self.node(solid.operand, room, depth)), steps)
        if isinstance(solid, Union):
            return _node("union", [self.node(part, room, depth) for part in solid.operands], [], steps, room)
        inside: list[PieceNode] = []
        cut: list[PieceNode] = []
        for k, operand in enumerate(solid.operands):
            is_out = isinstance(solid, Difference) and k > 0
            # Complements of complements cancel; one that is left is cut rather than built from the box.
            while isinstance(operand, Complement) and operand.motion.is_identity:
                operand, is_out = operand.operand, not is_out
            (cut if is_out else inside).append(self.node(operand, room, depth))
        return _node("intersection", inside, cut, steps, room)


def _node(
    kind: PieceBooleanKind, inside: list[PieceNode], cut: list[PieceNode], steps: Steps, room: BodyBox
) -> PieceNode:
    """Return the union or intersection (`kind`) of some nodes without others, moved by steps."""
    if not inside:
        inside = [PieceLeaf(room.box)]
    whole = inside[0] if len(inside) == 1 else PieceBoolean(kind, tuple(inside))
    if cut:
        whole = PieceBoolean("difference", (whole, *cut))
    return _move_node(whole, steps)


# Primitives. Each rule returns a piece, or None if the cells of the solid are to be used.


def _primitive(solid: PrimitiveSolid, room: BodyBox) -> PieceNode:
    """Return a primitive by its rule, else by its cells."""
    rule = _PIECE_RULES.get(type(solid))
    node = rule(solid, room.in_frame(solid.motion)) if rule is not None else None
    if node is None:
        own = room.in_frame(solid.motion).in_frame(solid.placement)
        node = _move_node(_tree(solid.tree(), own), solid.placement.steps)
    return _move_node(node, solid.motion.steps)


def _move_node(node: PieceNode, steps: Steps) -> PieceNode:
    """Return a node with further steps."""
    if not steps:
        return node
    if isinstance(node, PieceLeaf):
        return PieceLeaf(node.piece, node.steps + steps, node.is_rounded)
    return PieceBoolean(node.kind, node.parts, node.steps + steps, node.color)


def _shift(offset: Any) -> Steps:
    return (Translate(offset),) if any(offset) else ()


def _ellipsoid(solid: Ellipsoid, _: BodyBox) -> PieceNode | None:
    # Radii would be rounded from coefficients, and a cut has faces of its own
    if solid.coefficients is not None or solid.z_range is not None:
        return None
    return PieceLeaf(EllipsoidPiece(solid.radii), _shift(solid.center))


def _frustum(solid: Cylinder | Cone, first: float, second: float) -> PieceNode:
    """Return a cylinder or cone: exact along an axis of coordinates, else with a rounded length.

    A wedge always has a rounded length.
    """
    length = solid.length
    if solid.end_angle - solid.start_angle != 360:
        # A radius of 0 makes two corners equal, which a profile must not have
        profile = dict.fromkeys(((0.0, 0.0), (first, 0.0), (second, length), (0.0, length)))
        wedge = RevolutionPiece(tuple(profile), solid.start_angle, solid.end_angle)
        return PieceLeaf(wedge, solid.placement.steps, _is_rounded(solid))
    found = axis_steps(solid.start, solid.end)
    if found is not None:
        (low, high), steps = found
        return PieceLeaf(FrustumPiece(first, second, low, high), steps)
    return PieceLeaf(FrustumPiece(first, second, 0.0, length), solid.placement.steps, _is_rounded(solid))


def _is_rounded(solid: Cylinder | Cone) -> bool:
    """Return True if the length of a solid is no float64."""
    length = axis_length(solid.start, solid.end)
    return bool(ex.cancelling_sum((length, -ex.exact(solid.length))))


def _mesh(solid: Mesh, _: BodyBox) -> PieceNode | None:
    if solid._pieces_overlap:  # other programs have rules of their own where faces cross
        return None
    corners = tuple(tuple(map(Fraction, vertex)) for vertex in solid.vertices)
    return PieceLeaf(PolyhedronPiece(corners, solid.faces))  # type: ignore[arg-type]


def _polyhedron(solid: Polyhedron, room: BodyBox) -> PieceNode:
    plain = solid if solid.motion.is_identity else solid._moved(IDENTITY_MOTION)
    if not all(map(math.isfinite, (*plain.bounds[0], *plain.bounds[1]))):
        return _polyhedron_faces(list(zip(solid.normals, solid.offsets, strict=True)), room)
    return _bounded_piece(plain)


@lru_cache(256)
def _bounded_piece(plain: Polyhedron) -> PieceNode:
    """Return the faces of a bounded polyhedron without its motion; cached, as many bodies are one solid moved."""
    return _polyhedron_faces(list(zip(plain.normals, plain.offsets, strict=True)), compute_body_box(plain))


def _polyhedron_faces(planes: list[tuple[Any, float]], room: BodyBox) -> PieceNode:
    """Return the faces of a convex polyhedron within a box.

    Offsets are taken as the shortest decimals that are read as them, so that corners are those that people mean.
    """
    faces = clip_box(room.box, [(_fractions(normal), shortest_decimal(offset)) for normal, offset in planes])
    if faces is None:
        raise UnsupportedExport("a part of it is empty")
    return PieceLeaf(replace(faces, planes=tuple(planes)))


def _plane_number(value: ex.BigFloat) -> Fraction:
    """Return a number of a plane exactly, or the nearest float if `value` itself is rounded."""
    return Fraction(ex.rounded(value)) if ex.is_rounded(value) else ex.fraction(value)


def _fractions(normal: Vector) -> tuple[Fraction, Fraction, Fraction]:
    x, y, z = map(Fraction, normal)
    return x, y, z


_PIECE_RULES: dict[type[PrimitiveSolid], Callable[[Any, BodyBox], PieceNode | None]] = {
    Sphere: lambda solid, _: PieceLeaf(BallPiece(solid.radius), _shift(solid.center)),
    Box: lambda solid, _: PieceLeaf(BoxPiece(solid.low, solid.high)),
    Ellipsoid: _ellipsoid,
    Cylinder: lambda solid, _: _frustum(solid, solid.radius, solid.radius),
    Cone: lambda solid, _: _frustum(solid, solid.start_radius, solid.end_radius),
    Revolution: lambda solid, _: PieceLeaf(RevolutionPiece(solid.profile, solid.start_angle, solid.end_angle)),
    Extrusion: lambda solid, _: PieceLeaf(
        ExtrusionPiece(solid.outline, solid.z_range[0], solid.z_range[1], solid.scale_at_top)
    ),
    Mesh: _mesh,
    HalfSpace: lambda solid, room: _polyhedron_faces([(solid.normal, solid.offset)], room),
    Polyhedron: _polyhedron,
}


# Any primitive, by its cells.


def _tree(tree: Tree, room: BodyBox) -> PieceNode:
    """Return a tree of cells within a box."""
    if isinstance(tree, Cell):
        return _cell(tree.faces, room)
    if isinstance(tree, Not):
        return PieceBoolean("difference", (PieceLeaf(room.box), _tree(tree.part, room)))
    if isinstance(tree, Any_):
        if not tree.parts:
            raise UnsupportedExport("there is nothing in it")
        return _node("union", [_tree(part, room) for part in tree.parts], [], (), room)
    inside: list[PieceNode] = []
    cut: list[PieceNode] = []
    for part in tree.parts:
        # Outside of a quadric is unbounded; cut from the others it needs no box
        outer = _outside_face(part)
        if outer is None:
            inside.append(_tree(part, room))
        else:
            cut.append(curved_inside(outer, room))
    return _node("intersection", inside, cut, (), room)


def _outside_face(tree: Tree) -> Face | None:
    """Return the curved face if a tree is one cell outside of it; else None."""
    if isinstance(tree, Cell) and len(tree.faces) == 1:
        face = tree.faces[0]
        if face.inside < 0 and isinstance(face.surface, QuadricSurface):
            return face
    return None


def curved_inside(face: Face, room: BodyBox) -> PieceNode:
    """Return the inside of a curved face within a box."""
    assert isinstance(face.surface, QuadricSurface)
    return split_quadric(face.surface, room)


def _cell(faces: tuple[Face, ...], room: BodyBox) -> PieceNode:
    """Return an intersection of half-spaces and quadrics: the planes together clip the box."""
    inside: list[PieceNode] = []
    cut: list[PieceNode] = []
    planes, is_rounded = [], False
    for face in faces:
        if isinstance(face.surface, PlaneSurface):
            normal, offset = ex.exact_row(face.surface.normal), ex.exact(face.surface.offset)
            is_rounded = is_rounded or any(map(ex.is_rounded, (*normal, offset)))
            x, y, z = (face.inside * _plane_number(value) for value in normal)
            planes.append(((x, y, z), face.inside * _plane_number(offset)))
        else:
            (inside if face.inside > 0 else cut).append(split_quadric(face.surface, room))
    if planes:
        within = clip_box(room.box, planes)
        if within is None:
            raise UnsupportedExport("a part of it is empty")
        # A box is shorter to write and to read than six faces
        slab = upright_box(within)
        inside.append(PieceLeaf(slab or within, (), is_rounded))
    return _node("intersection", inside, cut, (), room)
