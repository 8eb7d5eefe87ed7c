"""Solids in the words of `pieces`: named shapes by rules of their own, all others by their cells."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache
from typing import Any, TypeAlias

from ...shapes import exact as ex
from ...shapes.axis import exact_length
from ...shapes.base import PrimitiveSolid, Solid
from ...shapes.box import Box
from ...shapes.cells import Any_, Cell, Face, Not, Tree
from ...shapes.cone import Cone
from ...shapes.cylinder import Cylinder
from ...shapes.ellipsoid import Ellipsoid
from ...shapes.half_space import HalfSpace
from ...shapes.mesh import Extrusion, Mesh
from ...shapes.motion import STILL
from ...shapes.polyhedron import Polyhedron
from ...shapes.region import Boolean, Complement, Difference, Painted, Union
from ...shapes.revolution import Revolution
from ...shapes.sphere import Sphere
from ...shapes.steps import Translate
from ...shapes.surface import PlaneSurface, QuadricSurface
from ...shapes.vector import Vector
from .axes import along_axis, upright
from .bodies import color_of
from .clipping import clipped
from .exported import Unsayable
from .numbers import decimal
from .pieces import Ball, Combined, Cuboid, Drawn, Egg, Faces, Frustum, Kind, Leaf, Node, Steps, Turned
from .quadrics import curved
from .rooms import Room, room_of

DEEPEST = 60
"""Booleans within Booleans."""


Rule: TypeAlias = Callable[[Solid], "Leaf | None"]
"""What a format has for a solid, its motion aside; None for most."""


def lowered(solid: Solid, rule: Rule | None = None) -> Node:
    """A body, by the rule of a format where it has one. Raises Unsayable for what is unbounded, or no such solid."""
    return _Lowering(rule).node(solid, room_of(solid), 0)


@dataclass(frozen=True)
class _Lowering:
    """Goes down a tree of Booleans."""

    rule: Rule | None

    def node(self, solid: Solid, room: Room, depth: int) -> Node:
        """A solid in a room."""
        if depth >= DEEPEST:
            raise Unsayable(f"it nests Booleans deeper than {DEEPEST} levels")
        found = None if self.rule is None else self.rule(solid)
        if found is not None:
            return _moved(found, solid.motion.steps)
        if isinstance(solid, Boolean):
            return self._combined(solid, room.within(solid.motion), depth + 1)
        if not isinstance(solid, PrimitiveSolid):
            raise Unsayable(f"{type(solid).__name__} is no solid of planes and quadrics")
        return _primitive(solid, room)

    def _combined(self, solid: Boolean, room: Room, depth: int) -> Node:
        """Complements become what is cut, from the room where nothing else is there."""
        steps = solid.motion.steps
        if isinstance(solid, Painted):
            return Combined("union", (self.node(solid.operand, room, depth),), steps, color_of(solid.material)[0])
        if isinstance(solid, Complement):
            return Combined("difference", (Leaf(room.box), self.node(solid.operand, room, depth)), steps)
        if isinstance(solid, Union):
            return _node("union", [self.node(part, room, depth) for part in solid.operands], [], steps, room)
        inside: list[Node] = []
        cut: list[Node] = []
        for k, operand in enumerate(solid.operands):
            is_out = isinstance(solid, Difference) and k > 0
            while isinstance(operand, Complement) and operand.motion.is_identity:
                operand, is_out = operand.operand, not is_out
            (cut if is_out else inside).append(self.node(operand, room, depth))
        return _node("intersection", inside, cut, steps, room)


def _node(kind: Kind, inside: list[Node], cut: list[Node], steps: Steps, room: Room) -> Node:
    """What is in all or any of some, and in none of others."""
    if not inside:
        inside = [Leaf(room.box)]
    whole = inside[0] if len(inside) == 1 else Combined(kind, tuple(inside))
    if cut:
        whole = Combined("difference", (whole, *cut))
    if not steps:
        return whole
    if isinstance(whole, Leaf):
        return Leaf(whole.piece, whole.steps + steps, whole.is_rounded)
    return Combined(whole.kind, whole.parts, whole.steps + steps, whole.color)


# ---- Primitives ----


def _primitive(solid: PrimitiveSolid, room: Room) -> Node:
    rule = _RULES.get(type(solid))
    found = rule(solid, room.within(solid.motion)) if rule is not None else None
    if found is None:
        own = room.within(solid.motion).within(solid.placement)
        found = _moved(_tree(solid.tree(), own), solid.placement.steps)
    return _moved(found, solid.motion.steps)


def _moved(node: Node, steps: Steps) -> Node:
    if not steps:
        return node
    if isinstance(node, Leaf):
        return Leaf(node.piece, node.steps + steps, node.is_rounded)
    return Combined(node.kind, node.parts, node.steps + steps, node.color)


def _sphere(solid: Sphere, room: Room) -> Node:
    del room
    return Leaf(Ball(solid.radius), _shift(solid.center))


def _shift(offset: Any) -> Steps:
    return (Translate(offset),) if any(offset) else ()


def _box(solid: Box, room: Room) -> Node:
    del room
    return Leaf(Cuboid(solid.low, solid.high))


def _ellipsoid(solid: Ellipsoid, room: Room) -> Node | None:
    if solid.coefficients is not None or solid.z_range is not None:
        return None
    del room
    return Leaf(Egg(solid.radii), _shift(solid.center))


def _cylinder(solid: Cylinder, room: Room) -> Node:
    del room
    return _frustum(solid, solid.radius, solid.radius)


def _cone(solid: Cone, room: Room) -> Node:
    del room
    return _frustum(solid, solid.start_radius, solid.end_radius)


def _frustum(solid: Cylinder | Cone, first: float, second: float) -> Node:
    """Along an axis of coordinates exactly, else of a length that is rounded; a part of a turn always so."""
    length = solid.length
    if solid.end_angle - solid.start_angle != 360:
        profile = dict.fromkeys(((0.0, 0.0), (first, 0.0), (second, length), (0.0, length)))
        wedge = Turned(tuple(profile), solid.start_angle, solid.end_angle)
        return Leaf(wedge, solid.placement.steps, _is_rounded(solid))
    found = along_axis(solid.start, solid.end)
    if found is not None:
        (low, high), steps = found
        return Leaf(Frustum(first, second, low, high), steps)
    return Leaf(Frustum(first, second, 0.0, length), solid.placement.steps, _is_rounded(solid))


def _is_rounded(solid: Cylinder | Cone) -> bool:
    length = exact_length(solid.start, solid.end)
    return bool(ex.cancelling_sum((length, -ex.exact(solid.length))))


def _turned(solid: Revolution, room: Room) -> Node:
    del room
    return Leaf(Turned(solid.profile, solid.start_angle, solid.end_angle))


def _drawn(solid: Extrusion, room: Room) -> Node:
    del room
    return Leaf(Drawn(solid.outline, *solid.z_range, solid.scale_at_top))


def _mesh(solid: Mesh, room: Room) -> Node:
    del room
    corners = tuple(tuple(map(Fraction, vertex)) for vertex in solid.vertices)
    return Leaf(Faces(corners, solid.faces))  # type: ignore[arg-type]


def _half_space(solid: HalfSpace, room: Room) -> Node:
    return _flat([(solid.normal, solid.offset)], room)


def _polyhedron(solid: Polyhedron, room: Room) -> Node:
    plain = solid if solid.motion.is_identity else solid._moved(STILL)
    if not all(map(math.isfinite, (*plain.bounds[0], *plain.bounds[1]))):
        return _flat(list(zip(solid.normals, solid.offsets, strict=True)), room)
    return _bounded(plain)


@lru_cache(256)
def _bounded(plain: Polyhedron) -> Node:
    """One that needs no room; many bodies are one such solid moved."""
    return _flat(list(zip(plain.normals, plain.offsets, strict=True)), room_of(plain))


def _flat(planes: list[tuple[Any, float]], room: Room) -> Node:
    """Offsets are taken as the decimals that are read as them, so that corners are those that were meant."""
    faces = clipped(room.box, [(_fractions(normal), decimal(offset)) for normal, offset in planes])
    if faces is None:
        raise Unsayable("a part of it is empty")
    return Leaf(replace(faces, planes=tuple(planes)))


def _short(value: ex.Exact) -> Fraction:
    """A number of a plane; the nearest float of one without an end."""
    return Fraction(ex.rounded(value)) if ex.is_rounded(value) else ex.fraction(value)


def _fractions(normal: Vector) -> tuple[Fraction, Fraction, Fraction]:
    x, y, z = map(Fraction, normal)
    return x, y, z


_RULES: dict[type[PrimitiveSolid], Callable[[Any, Room], Node | None]] = {
    Sphere: _sphere, Box: _box, Ellipsoid: _ellipsoid, Cylinder: _cylinder, Cone: _cone, Revolution: _turned,
    Extrusion: _drawn, Mesh: _mesh, HalfSpace: _half_space, Polyhedron: _polyhedron,
}  # fmt: skip


# ---- Any primitive, by its cells ----


def _tree(tree: Tree, room: Room) -> Node:
    if isinstance(tree, Cell):
        return _cell(tree.faces, room)
    if isinstance(tree, Not):
        return Combined("difference", (Leaf(room.box), _tree(tree.part, room)))
    if isinstance(tree, Any_):
        if not tree.parts:
            raise Unsayable("there is nothing in it")
        return _node("union", [_tree(part, room) for part in tree.parts], [], (), room)
    inside: list[Node] = []
    cut: list[Node] = []
    for part in tree.parts:
        outer = _outside(part)
        if outer is None:
            inside.append(_tree(part, room))
        else:
            cut.append(outer_of(outer, room))
    return _node("intersection", inside, cut, (), room)


def _outside(tree: Tree) -> Face | None:
    """The curved face that a cell is the outside of."""
    if isinstance(tree, Cell) and len(tree.faces) == 1:
        face = tree.faces[0]
        if face.inside < 0 and isinstance(face.surface, QuadricSurface):
            return face
    return None


def outer_of(face: Face, room: Room) -> Node:
    """The inside of a curved face."""
    assert isinstance(face.surface, QuadricSurface)
    return curved(face.surface, room)


def _cell(faces: tuple[Face, ...], room: Room) -> Node:
    inside: list[Node] = []
    cut: list[Node] = []
    planes, is_rounded = [], False
    for face in faces:
        if isinstance(face.surface, PlaneSurface):
            normal, offset = ex.exact_row(face.surface.normal), ex.exact(face.surface.offset)
            is_rounded = is_rounded or any(map(ex.is_rounded, (*normal, offset)))
            x, y, z = (face.inside * _short(value) for value in normal)
            planes.append(((x, y, z), face.inside * _short(offset)))
        else:
            (inside if face.inside > 0 else cut).append(curved(face.surface, room))
    if planes:
        within = clipped(room.box, planes)
        if within is None:
            raise Unsayable("a part of it is empty")
        slab = upright(within)
        inside.append(Leaf(slab or within, (), is_rounded))
    return _node("intersection", inside, cut, (), room)


__all__ = ["lowered"]
