"""Primitives whose formulas look at their numbers in ways that have no derivatives: here by other formulas.

A general quadric is kept about its principal axes, which eigenvectors give; its derivatives do not need them.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..._util.arrays import FloatArray
from ...geometry.bounds.support import plane_through, plane_uv
from ...geometry.bulk import Bulk
from ...geometry.cell import UV, Cell, Face, Not, PolygonSheet, Tree, transform_uv
from ...geometry.convex_decomposition import newell_normal
from ...geometry.general_quadric import Quadric
from ...geometry.mesh import Extrusion, Mesh
from ...geometry.polyhedron import Polyhedron
from ...geometry.quadric_coefficients import _PLACES as PLACES
from ...geometry.quadrics import Ellipsoid
from ...geometry.revolution import Revolution, SphereSection
from ...geometry.shape import Boolean, ClippedSheet, PrimitiveSheet, PrimitiveSolid, Shape
from ...geometry.sheets import Wall as OpenWall
from ...geometry.surface import PlaneSurface, QuadricSurface, Surface
from ...geometry.transform import IDENTITY_MOTION, AxisFrame, Motion, Translate
from ...numerics import bigfloat_linalg as ex
from . import parameters
from .dual import Dual, slopes_of, value_of
from .quadric_form import FORM, MAP, PAIRS, form_of


@dataclass(frozen=True)
class FormSurface:
    """A surface by its form alone."""

    anchor: tuple[float, ...]
    form: list[Any]


def complete_primitive(shape: Any, slopes: Any) -> Any:
    """A primitive with slopes, with what its formulas cannot work out of these."""
    if isinstance(shape, Polyhedron):
        vars(slopes)["_own_bounds"] = shape._own_bounds  # about where its planes are anchored, which moves nothing
    elif isinstance(shape, Ellipsoid) and shape.coefficients is not None:
        object.__setattr__(slopes, "radii", tuple(1 / ex.sqrt(c) for c in slopes.coefficients))
    return slopes


def special_faces(shape: Any, slopes: Any, motion: Motion) -> Iterator[tuple[int, Any, UV]] | None:
    """The faces of a primitive with formulas here, with slopes, where a motion takes it; None for other shapes."""
    if isinstance(shape, Polyhedron):
        return _faces_of_polyhedron(shape, slopes, motion)
    if isinstance(shape, Mesh | Extrusion):
        return _faces_of_mesh(shape, slopes, motion)
    if not isinstance(shape, Quadric):
        return None
    q, surface = _symmetric(slopes), shape.surface
    if isinstance(surface, PlaneSurface):
        normal = (2 * q[0][3], 2 * q[1][3], 2 * q[2][3])
        plane = plane_through(normal, -q[3][3])
        return iter(
            [
                (
                    0,
                    plane.moved(motion),
                    transform_uv(without_uv_slopes(plane_uv(plane), _axis_jump_parameters(normal)), motion),
                )
            ]
        )
    own = tuple(ex.exact(a) for a in surface.anchor)
    anchor = tuple(float(value_of(a)) for a in motion.carried(own))  # type: ignore[arg-type]
    uv = transform_uv(_center_uv(q, own), motion)
    return iter([(0, FormSurface(anchor, _form(q, motion, anchor)), uv)])


def _symmetric(slopes: Any) -> list[list[Any]]:
    """Q, symmetric, of numbers with slopes."""
    if slopes.matrix is not None:
        return [[(slopes.matrix[i][j] + slopes.matrix[j][i]) * 0.5 for j in range(4)] for i in range(4)]
    rows: list[list[Any]] = [[ex.ZERO] * 4 for _ in range(4)]
    for name, value in slopes.coefficients.items():
        i, j = PLACES[name]
        rows[i][j] = rows[i][j] + value * 0.5
        rows[j][i] = rows[j][i] + value * 0.5
    return rows


def _form(q: list[list[Any]], motion: Motion, anchor: tuple[float, ...]) -> list[Any]:
    """The form about an anchor in the world: x = back (anchor + r) + shift is put into (x, 1) Q (x, 1)."""
    back, shift = motion.inverse
    at = ex.exact_row(anchor)
    start = [sum((back[i][k] * at[k] for k in range(3)), shift[i]) for i in range(3)]
    slope = [sum((q[i][k] * start[k] for k in range(3)), q[i][3]) for i in range(3)]
    half = [[sum((q[i][k] * back[k][j] for k in range(3)), ex.ZERO) for j in range(3)] for i in range(3)]
    second = [sum((back[k][i] * half[k][j] for k in range(3)), ex.ZERO) for i, j in PAIRS]
    first = [sum((back[k][i] * slope[k] for k in range(3)), ex.ZERO) for i in range(3)]
    return [*second, *first, sum((start[k] * (slope[k] + q[k][3]) for k in range(3)), q[3][3])]


def _center_uv(q: list[list[Any]], anchor: tuple[Any, ...]) -> UV:
    """uv about the center, which moves by -A⁻¹ (dA c + db); what it moves by is not known where there is none."""
    a = np.array([[float(value_of(q[i][k])) for k in range(3)] for i in range(3)])
    keys = sorted({key for row in q for number in row for key in slopes_of(number)})
    moves = [dict.fromkeys(keys, math.nan) for _ in range(3)]
    residue = [sum((q[i][k] * anchor[k] for k in range(3)), q[i][3]) for i in range(3)]
    size = np.abs(a).max() * max(1.0, *(abs(float(value_of(c))) for c in anchor))
    if np.linalg.cond(a) < 1e12 and all(abs(float(value_of(r))) <= 1e-12 * size for r in residue):
        change = np.array([[slopes_of(r).get(key, 0.0) for key in keys] for r in residue])
        moved = -np.linalg.solve(a, change)
        moves = [dict(zip(keys, row, strict=True)) for row in moved.tolist()]
    center = tuple(Dual(ex.exact(c), move) for c, move in zip(anchor, moves, strict=True))
    upright = UV(True, ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0)))
    return transform_uv(upright, Motion((Translate(center),)))  # type: ignore[arg-type]


def _faces_of_polyhedron(shape: Polyhedron, slopes: Any, motion: Motion) -> Iterator[tuple[int, Any, UV]]:
    """The faces of a polyhedron. Its uv are about a point near the solid, whose derivatives are not known."""
    every = {key for offset in slopes.offsets for key in slopes_of(offset)}
    for number, (own, moving) in enumerate(zip(shape.surfaces, slopes.surfaces, strict=True)):
        keys = every.union(*map(slopes_of, slopes.normals[number]))
        yield number, moving.moved(motion), transform_uv(without_uv_slopes(plane_uv(own), keys), motion)


def _faces_of_mesh(shape: Mesh | Extrusion, slopes: Any, motion: Motion) -> Iterator[tuple[int, Any, UV]]:
    """The faces of a mesh or an extrusion: planes through their corners, whatever parts they bound.

    Not known is how a plane moves with a corner that bends it: of a mesh's face of more than three corners, and of
    faces that lie in one plane.
    """
    _, _, corners, faces = slopes._boundary()
    for number, members in shape.planes():
        bends = len(members) > 1 or (isinstance(shape, Mesh) and len(faces[members[0]]) > 3)
        own = [corners[k] for k in faces[members[0]]]
        normal, every = newell_normal(own), [c for face in members for k in faces[face] for c in corners[k]]
        offset = sum((a * b for a, b in zip(normal, own[0], strict=True)), ex.ZERO)
        keys = {key for c in every for key in slopes_of(c)} if bends else set()
        lost = dict.fromkeys(keys, math.nan)
        plane = plane_through(normal, Dual(value_of(offset), {**slopes_of(offset), **lost}), corners[0])
        uv = without_uv_slopes(plane_uv(plane), _axis_jump_parameters(normal) | keys)
        yield number, plane.moved(motion), transform_uv(uv, motion)


def level_edge_plane(shape: Revolution, face: Face) -> Surface:
    """The plane that an edge of a profile sweeps which is level: a cone, as soon as one of its ends moves alone."""
    ends = shape.profile[face.number], shape.profile[(face.number + 1) % len(shape.profile)]
    if not isinstance(face.surface, PlaneSurface):
        return face.surface
    x, y, sense = face.surface.normal
    lost = {key: math.nan for _, z in ends for key in slopes_of(z)}
    height = value_of(ends[0][1])
    return PlaneSurface((x, y, sense), Dual(height * ex.exact(sense), lost), (0.0, 0.0, height))


def without_uv_slopes(uv: UV, keys: Iterable[int]) -> UV:
    """A map of which it is not known how u, and on flat faces v, moves with some parameters."""
    lost = dict.fromkeys(keys, math.nan)
    rows = [(*row[:3], Dual(value_of(row[3]), {**slopes_of(row[3]), **lost})) for row in uv.matrix[:2]]
    return UV(uv.angular, (*rows, uv.matrix[2])) if lost else uv  # type: ignore[arg-type]


def jump_parameters(made: Any) -> set[int]:
    """The parameters by which u jumps: it counts from the coordinate axis least along an axis, where two are so."""
    frames = [step for step in made.placement.steps if isinstance(step, AxisFrame) and step.reference is None]
    axis = frames[0].axis if frames else getattr(made, "normal", None)
    return set() if axis is None else _axis_jump_parameters(axis)


def _axis_jump_parameters(axis: Iterable[Any]) -> set[int]:
    """What moves an axis of which two coordinates are least, so that either may come to be the least."""
    least, second, _ = sorted(abs(float(value_of(c))) for c in axis)
    return {key for c in axis for key in slopes_of(c)} if least == second else set()


# The walls of a shape with their derivatives by its numbers: its own formulas, worked out with `Slope`s.
#
# Kept with the shape, as what it is lowered to is: a scene of which one body changes works out that body's anew.


@dataclasses.dataclass(frozen=True)
class WallJacobian:
    """One face of a shape. Parameters by their numbers among those of the shape."""

    anchor: FloatArray
    form: FloatArray  # (10,) its surface about the anchor
    ids: Any  # (p,) what it moves with
    forms: FloatArray  # (p, 10) the derivatives of the form
    maps: FloatArray  # (p, 12) and of the map to uv, three rows of four, from coordinates of the world


def walls_of(shape: Shape) -> dict[int, WallJacobian]:
    """The walls of a shape by the numbers of their faces. Raises TypeError where its formulas have no derivatives."""
    found: dict[int, WallJacobian] | None = shape.kept.get("walls")
    if found is None:
        counter = itertools.count()
        found = shape.kept["walls"] = _walls(shape, dual_shape(shape, counter))
    return found


def walls_of_one(shape: Bulk, index: int) -> dict[int, WallJacobian]:
    """`walls_of` for one of many bodies; parameters by their numbers among those of all."""
    known: dict[int, dict[int, WallJacobian]] = shape.kept.setdefault("walls of one", {})
    if index not in known:
        single = shape.single(index)
        known[index] = _walls(single, _dual_bulk_item(shape, index, single))
    return known[index]


def _take_duals(counter: Iterator[int]) -> parameters.Take:
    return lambda _, value: Dual(ex.exact(value), {next(counter): 1.0})


def dual_shape(shape: Shape, counter: Iterator[int]) -> Any:
    """The shape with numbers that know how they move."""
    return parameters.map_numbers(shape, _take_duals(counter), parameters.replace_unchecked, None)


def _dual_bulk_item(shape: Bulk, index: int, single: Any) -> Any:
    """One of many bodies with numbers that know how they move, counted as `fields.values_of` counts them."""
    firsts, at = {}, 0
    for name in shape.columns:
        width = getattr(shape, name).size // len(shape)
        firsts[name], at = at + width * index, at + width * len(shape)
    moves = parameters.map_motion(shape.motion, _take_duals(itertools.count(at)), parameters.replace_unchecked, None)
    leaves = single.operands if isinstance(single, Boolean) else (single,)
    made = []
    for leaf, primitive in enumerate(leaves):
        names = [field.name for field in dataclasses.fields(primitive) if field.init and field.name != "motion"]
        changes: dict[str, Any] = {}
        for name, part in zip(names, parameters.columns_of_leaf(shape, leaf), strict=False):
            if isinstance(part, str):
                take = _take_duals(itertools.count(firsts[part]))
                changes[name] = parameters.map_value(getattr(primitive, name), take, parameters.replace_unchecked)
        if primitive is single:
            changes["motion"] = moves
        made.append(parameters.replace_unchecked(primitive, changes))
    return (
        made[0]
        if leaves == (single,)
        else parameters.replace_unchecked(single, {"operands": tuple(made), "motion": moves})
    )


def _walls(shape: Shape, slopes: Any) -> dict[int, WallJacobian]:
    found: dict[int, WallJacobian] = {}
    for leaf, own, outer in _leaves(shape, slopes, IDENTITY_MOTION):
        first = max(found, default=-1) + 1
        try:
            faces = list(_faces(leaf, own, outer))
        except TypeError as error:
            told = "its formulas look at the digits of their numbers (float, Fraction, math), ex.rational does not"
            raise TypeError(f"{type(leaf).__name__}: it has no derivatives, as {told}: {error}") from error
        for number, surface, uv in faces:
            found[first + number] = _wall(surface, uv)
    return dict(sorted(found.items()))


def _leaves(shape: Any, slopes: Any, outer: Motion) -> Iterator[tuple[Any, Any, Motion]]:
    """The primitives from left to right, as said and with slopes, and what moves each after its own motion."""
    waiting = [(shape, slopes, outer)]
    while waiting:
        one, own, after = waiting.pop()
        if isinstance(one, ClippedSheet):
            waiting.append((one.base, own.base, own.motion.then(after)))
        elif isinstance(one, Boolean):
            inner = own.motion.then(after)
            waiting += [(a, b, inner) for a, b in zip(one.operands[::-1], own.operands[::-1], strict=True)]
        else:
            yield one, own, after


def _faces(shape: Any, slopes: Any, outer: Motion) -> Iterator[tuple[int, Surface, UV]]:
    """The faces of a primitive in the world: number, surface, uv."""
    made = complete_primitive(shape, slopes)
    if isinstance(made, OpenWall):  # what cuts it moves no point of it
        for number, surface, uv in _faces(shape.solid, made.solid, made.motion.then(outer)):
            if number == made.face:
                yield 0, surface, uv
        return
    motion, jumping = made.under(outer), jump_parameters(made)
    if isinstance(made, PrimitiveSheet):
        sheet = made.sheet(motion)
        surface = sheet.plane if isinstance(sheet, PolygonSheet) else sheet.surface
        yield 0, surface, without_uv_slopes(sheet.uv, jumping)
        return
    if not isinstance(made, PrimitiveSolid):
        raise TypeError(f"{type(shape).__name__} has no derivatives: it is no primitive")
    special = special_faces(shape, made, motion)
    if special is not None:
        yield from special
        return
    for face in _flat(made.tree()):
        if isinstance(made, Revolution) and face.number < len(made.profile):
            surface = level_edge_plane(made, face)
        else:
            surface = _angle_face_surface(made, face)
        yield face.number, _move_surface(surface, motion), transform_uv(without_uv_slopes(face.uv, jumping), motion)


def _angle_face_surface(made: Any, face: Face) -> Surface:
    """The surface of a face, and no derivative where an angle moves it to another kind, or only a part of it.

    A polar angle of 90 moves its plane to a cone. One plane for both walls of half a turn, and one cone for two polar
    angles, are moved by each in one half.
    """
    surface = face.surface
    if isinstance(made, SphereSection) and face.number in (2, 3):
        if isinstance(surface, PlaneSurface):
            return _without_slopes(surface, slopes_of(made.polar[face.number - 2]))
        return (
            _without_slopes(surface, [key for angle in made.polar for key in slopes_of(angle)])
            if made.has_one_cone
            else surface
        )
    angles = getattr(made, "start_angle", None), getattr(made, "end_angle", None)
    if not isinstance(surface, PlaneSurface) or not all(isinstance(angle, Dual) for angle in angles):
        return surface
    turned = {key for number in surface.normal[:2] for key in slopes_of(number)}
    first, last = (value_of(angle) for angle in angles)
    if not turned & set(slopes_of(angles[0])) or float(last - first) != 180:
        return surface
    return _without_slopes(surface, [key for angle in angles for key in slopes_of(angle)])


def _without_slopes(surface: Surface, keys: Iterable[int]) -> Surface:
    """A surface without derivatives by some parameters."""
    lost = dict.fromkeys(keys, math.nan)
    numbers = surface.normal if isinstance(surface, PlaneSurface) else surface.squares
    x, y, z = (Dual(value_of(c), {**slopes_of(c), **lost}) for c in numbers)
    if isinstance(surface, PlaneSurface):
        return dataclasses.replace(surface, normal=(x, y, z))
    return dataclasses.replace(surface, squares=(x, y, z))


def _flat(tree: Tree) -> Iterator[Face]:
    """All faces of a tree, in the order of their numbers."""
    found: list[Face] = []
    pending = [tree]
    while pending:
        part = pending.pop()
        if isinstance(part, Cell):
            found += part.faces
        else:
            pending.extend((part.part,) if isinstance(part, Not) else part.parts)
    return iter(sorted(found, key=lambda face: face.number))


def _move_surface(surface: Surface, motion: Motion) -> Surface:
    return surface.moved_rows(motion) if isinstance(surface, QuadricSurface) else surface.moved(motion)


def _wall(surface: Surface | Any, uv: UV) -> WallJacobian:
    """The numbers of a face as floats."""
    anchor = [float(value_of(a)) for a in surface.anchor]
    form = form_of(surface, anchor) if isinstance(surface, (PlaneSurface, QuadricSurface)) else surface.form
    numbers = [*form, *(number for row in uv.matrix for number in row)]
    ids = sorted({key for number in numbers for key, slope in slopes_of(number).items() if slope})
    table = np.zeros((len(ids), FORM + MAP))
    place = {key: row for row, key in enumerate(ids)}
    for column, number in enumerate(numbers):
        for key, slope in slopes_of(number).items():
            if key in place:
                table[place[key], column] = slope
    value = np.array([float(value_of(number)) for number in form])
    return WallJacobian(
        np.array(anchor), value, np.array(ids, np.int64), table[:, :FORM].copy(), table[:, FORM:].copy()
    )
