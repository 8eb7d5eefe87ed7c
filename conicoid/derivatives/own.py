"""Primitives whose formulas look at their numbers in ways that have no derivatives: here by other formulas.

A general quadric is kept about its principal axes, which eigenvectors give; its derivatives do not need them.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..shapes import exact as ex
from ..shapes.cells import UV, Face, moved_uv
from ..shapes.coefficients import _PLACES as PLACES
from ..shapes.convex_parts import newell
from ..shapes.ellipsoid import Ellipsoid
from ..shapes.mesh import Extrusion, Mesh
from ..shapes.motion import Motion, Translate
from ..shapes.planar import plane_through, plane_uv
from ..shapes.polyhedron import Polyhedron
from ..shapes.quadric import Quadric
from ..shapes.revolution import Revolution
from ..shapes.steps import Frame
from ..shapes.surface import PlaneSurface, Surface
from .forms import PAIRS
from .slope import Slope, slopes_of, value_of


@dataclass(frozen=True)
class General:
    """A surface by its form alone."""

    anchor: tuple[float, ...]
    form: list[Any]


def prepared(shape: Any, slopes: Any) -> Any:
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
        return iter([(0, plane.moved(motion), moved_uv(without(plane_uv(plane), _jumping(normal)), motion))])
    own = tuple(ex.exact(a) for a in surface.anchor)
    anchor = tuple(float(value_of(a)) for a in motion.carried(own))  # type: ignore[arg-type]
    uv = moved_uv(_upright(q, own), motion)
    return iter([(0, General(anchor, _form(q, motion, anchor)), uv)])


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


def _upright(q: list[list[Any]], anchor: tuple[Any, ...]) -> UV:
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
    center = tuple(Slope(ex.exact(c), move) for c, move in zip(anchor, moves, strict=True))
    upright = UV(True, ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0)))
    return moved_uv(upright, Motion((Translate(center),)))  # type: ignore[arg-type]


def _faces_of_polyhedron(shape: Polyhedron, slopes: Any, motion: Motion) -> Iterator[tuple[int, Any, UV]]:
    """The faces of a polyhedron. Its uv are about a point near the solid, whose derivatives are not known."""
    every = {key for offset in slopes.offsets for key in slopes_of(offset)}
    for number, (own, moving) in enumerate(zip(shape.surfaces, slopes.surfaces, strict=True)):
        keys = every.union(*map(slopes_of, slopes.normals[number]))
        yield number, moving.moved(motion), moved_uv(without(plane_uv(own), keys), motion)


def _faces_of_mesh(shape: Mesh | Extrusion, slopes: Any, motion: Motion) -> Iterator[tuple[int, Any, UV]]:
    """The faces of a mesh or an extrusion: planes through their corners, whatever parts they bound.

    Not known is how a plane moves with a corner that bends it: of a mesh's face of more than three corners, and of
    faces that lie in one plane.
    """
    _, _, corners, faces = slopes._said()
    for number, members in shape.planes():
        bends = len(members) > 1 or (isinstance(shape, Mesh) and len(faces[members[0]]) > 3)
        own = [corners[k] for k in faces[members[0]]]
        normal, every = newell(own), [c for face in members for k in faces[face] for c in corners[k]]
        offset = sum((a * b for a, b in zip(normal, own[0], strict=True)), ex.ZERO)
        keys = {key for c in every for key in slopes_of(c)} if bends else set()
        lost = dict.fromkeys(keys, math.nan)
        plane = plane_through(normal, Slope(value_of(offset), {**slopes_of(offset), **lost}), corners[0])
        uv = without(plane_uv(plane), _jumping(normal) | keys)
        yield number, plane.moved(motion), moved_uv(uv, motion)


def of_level_edge(shape: Revolution, face: Face) -> Surface:
    """The plane that an edge of a profile sweeps which is level: a cone, as soon as one of its ends moves alone."""
    ends = shape.profile[face.number], shape.profile[(face.number + 1) % len(shape.profile)]
    if not isinstance(face.surface, PlaneSurface):
        return face.surface
    x, y, sense = face.surface.normal
    lost = {key: math.nan for _, z in ends for key in slopes_of(z)}
    height = value_of(ends[0][1])
    return PlaneSurface((x, y, sense), Slope(height * ex.exact(sense), lost), (0.0, 0.0, height))


def without(uv: UV, keys: Iterable[int]) -> UV:
    """A map of which it is not known how u, and on flat faces v, moves with some parameters."""
    lost = dict.fromkeys(keys, math.nan)
    rows = [(*row[:3], Slope(value_of(row[3]), {**slopes_of(row[3]), **lost})) for row in uv.matrix[:2]]
    return UV(uv.angular, (*rows, uv.matrix[2])) if lost else uv  # type: ignore[arg-type]


def undecided(made: Any) -> set[int]:
    """The parameters by which u jumps: it counts from the coordinate axis least along an axis, where two are so."""
    frames = [step for step in made.placement.steps if isinstance(step, Frame) and step.reference is None]
    axis = frames[0].axis if frames else getattr(made, "normal", None)
    return set() if axis is None else _jumping(axis)


def _jumping(axis: Iterable[Any]) -> set[int]:
    """What moves an axis of which two coordinates are least, so that either may come to be the least."""
    least, second, _ = sorted(abs(float(value_of(c))) for c in axis)
    return {key for c in axis for key in slopes_of(c)} if least == second else set()
