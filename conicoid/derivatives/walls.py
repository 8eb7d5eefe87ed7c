"""The walls of a shape with their derivatives by its numbers: its own formulas, worked out with `Slope`s.

Kept with the shape, as what it is lowered to is: a scene of which one body changes works out that body's anew.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from ..shapes import exact as ex
from ..shapes.base import PrimitiveSheet, PrimitiveSolid, Shape
from ..shapes.bulk import Bulk
from ..shapes.cells import UV, Cell, Face, Not, PolygonSheet, Tree, moved_uv
from ..shapes.motion import STILL, Motion
from ..shapes.region import Boolean, ClippedSheet
from ..shapes.revolution import Revolution
from ..shapes.sphere_section import SphereSection
from ..shapes.surface import PlaneSurface, QuadricSurface, Surface
from ..shapes.vector import FloatArray
from ..shapes.wall import Wall as OpenWall
from . import fields
from .forms import FORM, MAP, form_of
from .own import of_level_edge, prepared, special_faces, undecided, without
from .slope import Slope, slopes_of, value_of


@dataclasses.dataclass(frozen=True)
class Wall:
    """One face of a shape. Parameters by their numbers among those of the shape."""

    anchor: FloatArray
    form: FloatArray  # (10,) its surface about the anchor
    ids: Any  # (p,) what it moves with
    forms: FloatArray  # (p, 10) the derivatives of the form
    maps: FloatArray  # (p, 12) and of the map to uv, three rows of four, from coordinates of the world


def walls_of(shape: Shape) -> dict[int, Wall]:
    """The walls of a shape by the numbers of their faces. Raises TypeError where its formulas have no derivatives."""
    found: dict[int, Wall] | None = shape.kept.get("walls")
    if found is None:
        counter = itertools.count()
        found = shape.kept["walls"] = _walls(shape, told(shape, counter))
    return found


def walls_of_one(shape: Bulk, index: int) -> dict[int, Wall]:
    """`walls_of` for one of many bodies; parameters by their numbers among those of all."""
    known: dict[int, dict[int, Wall]] = shape.kept.setdefault("walls of one", {})
    if index not in known:
        single = shape.single(index)
        known[index] = _walls(single, _told_of_many(shape, index, single))
    return known[index]


def _take(counter: Iterator[int]) -> fields.Take:
    return lambda _, value: Slope(ex.exact(value), {next(counter): 1.0})


def told(shape: Shape, counter: Iterator[int]) -> Any:
    """The shape with numbers that know how they move."""
    return fields.retold(shape, _take(counter), fields.unchecked, None)


def _told_of_many(shape: Bulk, index: int, single: Any) -> Any:
    """One of many bodies with numbers that know how they move, counted as `fields.values_of` counts them."""
    firsts, at = {}, 0
    for name in shape.columns:
        width = getattr(shape, name).size // len(shape)
        firsts[name], at = at + width * index, at + width * len(shape)
    moves = fields.retold_motion(shape.motion, _take(itertools.count(at)), fields.unchecked, None)
    leaves = single.operands if isinstance(single, Boolean) else (single,)
    made = []
    for leaf, primitive in enumerate(leaves):
        names = [field.name for field in dataclasses.fields(primitive) if field.init and field.name != "motion"]
        changes: dict[str, Any] = {}
        for name, part in zip(names, fields.columns_of_leaf(shape, leaf), strict=False):
            if isinstance(part, str):
                take = _take(itertools.count(firsts[part]))
                changes[name] = fields.value_retold(getattr(primitive, name), take, fields.unchecked)
        if primitive is single:
            changes["motion"] = moves
        made.append(fields.unchecked(primitive, changes))
    return made[0] if leaves == (single,) else fields.unchecked(single, {"operands": tuple(made), "motion": moves})


def _walls(shape: Shape, slopes: Any) -> dict[int, Wall]:
    found: dict[int, Wall] = {}
    for leaf, own, outer in _leaves(shape, slopes, STILL):
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
    made = prepared(shape, slopes)
    if isinstance(made, OpenWall):  # what cuts it moves no point of it
        for number, surface, uv in _faces(shape.solid, made.solid, made.motion.then(outer)):
            if number == made.face:
                yield 0, surface, uv
        return
    motion, jumping = made.under(outer), undecided(made)
    if isinstance(made, PrimitiveSheet):
        sheet = made.sheet(motion)
        surface = sheet.plane if isinstance(sheet, PolygonSheet) else sheet.surface
        yield 0, surface, without(sheet.uv, jumping)
        return
    if not isinstance(made, PrimitiveSolid):
        raise TypeError(f"{type(shape).__name__} has no derivatives: it is no primitive")
    special = special_faces(shape, made, motion)
    if special is not None:
        yield from special
        return
    for face in _flat(made.tree()):
        if isinstance(made, Revolution) and face.number < len(made.profile):
            surface = of_level_edge(made, face)
        else:
            surface = _turned(made, face)
        yield face.number, _moved(surface, motion), moved_uv(without(face.uv, jumping), motion)


def _turned(made: Any, face: Face) -> Surface:
    """The surface of a face, and no derivative where an angle moves it to another kind, or only a part of it.

    A polar angle of 90 moves its plane to a cone. One plane for both walls of half a turn, and one cone for two polar
    angles, are moved by each in one half.
    """
    surface = face.surface
    if isinstance(made, SphereSection) and face.number in (2, 3):
        if isinstance(surface, PlaneSurface):
            return _lost(surface, slopes_of(made.polar[face.number - 2]))
        return (
            _lost(surface, [key for angle in made.polar for key in slopes_of(angle)]) if made.has_one_cone else surface
        )
    angles = getattr(made, "start_angle", None), getattr(made, "end_angle", None)
    if not isinstance(surface, PlaneSurface) or not all(isinstance(angle, Slope) for angle in angles):
        return surface
    turned = {key for number in surface.normal[:2] for key in slopes_of(number)}
    first, last = (value_of(angle) for angle in angles)
    if not turned & set(slopes_of(angles[0])) or float(last - first) != 180:
        return surface
    return _lost(surface, [key for angle in angles for key in slopes_of(angle)])


def _lost(surface: Surface, keys: Iterable[int]) -> Surface:
    """A surface without derivatives by some parameters."""
    lost = dict.fromkeys(keys, math.nan)
    numbers = surface.normal if isinstance(surface, PlaneSurface) else surface.squares
    x, y, z = (Slope(value_of(c), {**slopes_of(c), **lost}) for c in numbers)
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


def _moved(surface: Surface, motion: Motion) -> Surface:
    return surface.moved_rows(motion) if isinstance(surface, QuadricSurface) else surface.moved(motion)


def _wall(surface: Surface | Any, uv: UV) -> Wall:
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
    return Wall(np.array(anchor), value, np.array(ids, np.int64), table[:, :FORM].copy(), table[:, FORM:].copy())
