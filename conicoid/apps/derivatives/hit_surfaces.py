"""Surface data per crossing: the quadric form, the uv map and the parameter Jacobian of each wall, as arrays.

The data are stored once per distinct wall, which many crossings may share.
"""

from __future__ import annotations

from dataclasses import field
from functools import cached_property
from typing import Any

import numpy as np

from ..._jit.decorators import kernel
from ..._util.arrays import FloatArray
from ..._util.records import dataclass
from ...geometry.bulk import Bulk, Spheres
from ...kernels.body.uv import rows_of_maps
from ...kernels.tables import Ints, Longs
from ...prepare.prepared_scene import PreparedScene
from .crossing_derivatives import WallRows, as_kernel_array
from .parameters import Parameters
from .quadric_form import FORM, MAP, forms_of, scale_between, shift_forms
from .wall_jacobians import WallJacobian, walls_of, walls_of_one

_MOST_KEYS = 1 << 22
"""Bodies times faces up to which walls are numbered through a table; beyond, by sorting."""


@dataclass
class HitSurfaces:
    """The distinct walls (w,) of crossings, and for each crossing the row of its wall."""

    place: Any  # (n,) the row of the wall; -1 for a miss
    body: Any  # (w,)
    face: Any  # (w,)
    forms: FloatArray  # (w, 10) as in the tables of the scene
    anchors: FloatArray  # (w, 3)
    maps: FloatArray  # (w, 12)
    angular: Any  # (w,) whether u is an angle

    @cached_property
    def rows(self) -> WallRows:
        """The walls as kernels take them: form, anchor and map, one row each."""
        numbers = np.concatenate([self.forms, self.anchors, self.maps], axis=1)
        return WallRows(as_kernel_array(numbers), as_kernel_array(self.angular.astype(np.int8)))


@dataclass
class SurfaceJacobians:
    """Sparse Jacobian of walls by parameters. The rows of one wall follow one another."""

    wall: Any  # (m,) the wall of each row
    ids: Any  # (m,) the number of its parameter
    forms: FloatArray  # (m, 10) derivatives of the form
    maps: FloatArray  # (m, 12) derivatives of the map
    count: int = field(default=0)  # of walls


def find_hit_surfaces(prepared: PreparedScene, body: Any, face: Any, surface: Any) -> HitSurfaces:
    """Return the distinct walls of crossings (n,) from their body, face and surface numbers."""
    place, first = _distinct(body, face)
    body, face, surface = body[first], face[first], surface[first]
    tables = prepared.lowered.tables
    forms, anchors = forms_of(tables, surface)
    maps, angular = _maps(prepared, body, face, anchors)
    return HitSurfaces(place, body, face, forms, anchors, maps, angular)


def _distinct(body: Any, face: Any) -> tuple[Any, Any]:
    """Return (row of each pair among the distinct pairs, -1 for a miss; an index of each distinct pair)."""
    hit = body >= 0
    width = int(face.max(initial=0)) + 1
    keys = np.where(hit, body.astype(np.int64) * width + face, -1)
    most = int(keys.max(initial=-1)) + 1
    if most > _MOST_KEYS:
        _, first, place = np.unique(keys, return_index=True, return_inverse=True)
        has_miss = int(len(keys) > 0 and not hit.all())
        return place.reshape(keys.shape) - has_miss, first[has_miss:]
    known, place, first = np.zeros(most, np.int32), np.empty(keys.shape, np.int64), np.empty(most, np.int64)
    count = number_walls(as_kernel_array(keys), known, place, first)
    return place, first[:count]


@kernel(keys="n", known="out m", place="out n", first="out m")
def number_walls(keys: Longs, known: Ints, place: Longs, first: Longs) -> int:
    """Number keys in order of appearance and return how many distinct ones appear.

    place[i] is the number of keys[i], -1 for keys below 0. first[k] is the first index with number k. `known` holds a
    zero for each key.
    """
    count = 0
    for i in range(len(keys)):
        key = keys[i]
        place[i] = -1
        if key < 0 or key >= len(known):
            continue
        if known[key] == 0:
            first[count] = i
            count += 1
            known[key] = count
        place[i] = known[key] - 1
    return count


def _maps(prepared: PreparedScene, body: Any, face: Any, anchors: FloatArray) -> tuple[FloatArray, Any]:
    """Return (maps to uv (w, 12), whether u is an angle) of walls. Maps of `Spheres` are built from their frames."""
    tables = prepared.lowered.tables
    row = tables.body_face[body].astype(np.int64)
    plain = row >= 0
    maps, angular = np.zeros((len(body), MAP)), np.ones(len(body), np.bool_)
    # A first row below 0 marks an angular map; the row itself is -1 minus it.
    rows: Any = rows_of_maps(tables, body[plain], face[plain]).copy()
    angular[plain] = rows[:, 0] < 0
    rows[:, 0] = np.where(rows[:, 0] < 0, -1 - rows[:, 0], rows[:, 0])
    plain_maps = tables.map_rows[rows]
    plain_maps[~angular[plain], 2] = 0.0  # a flat map has two rows
    maps[plain] = plain_maps.reshape(-1, MAP)
    balls = np.flatnonzero(~plain)
    if len(balls):
        frames = tables.ball_frames.reshape(-1, 3, 3)[-1 - row[balls]]
        center, radius = anchors[balls], _own_radii(prepared, body[balls])
        own = -np.einsum("nij,nj->ni", frames, center)
        rows = np.concatenate([frames, own[:, :, None]], axis=2)
        rows[:, 2] /= 2 * radius[:, None]
        rows[:, 2, 3] += 0.5
        maps[balls] = rows.reshape(-1, MAP)
    return maps, angular


def _own_radii(prepared: PreparedScene, body: Any) -> FloatArray:
    """Return the radii of balls of `Spheres`, as the user gave them."""
    items = prepared.lowered.body_item[body]
    radii = np.ones(len(body))
    for item in np.unique(items).tolist():
        mine = items == item
        radii[mine] = prepared.entries[item].shape.radii[body[mine] - _first_body(prepared, item)]
    return radii


def _first_body(prepared: PreparedScene, item: int) -> int:
    """Return the number of the first body of an entry."""
    return int(np.searchsorted(prepared.lowered.body_item, item))


def surface_jacobians(prepared: PreparedScene, walls: HitSurfaces, parameters: Parameters) -> SurfaceJacobians:
    """Return the Jacobian of walls by all numbers of the scene's shapes, selected as parameters or not."""
    parts: list[_JacobianRows] = []
    single: list[tuple[int, int, WallJacobian]] = []  # place, first parameter, wall
    if not len(parameters._full):
        return _concatenate_jacobians(parts, walls)
    items = prepared.lowered.body_item[walls.body]
    for item in np.unique(items).tolist():
        mine = np.flatnonzero(items == item)
        shape, bodies = prepared.entries[item].shape, walls.body[mine] - _first_body(prepared, item)
        first = int(parameters._firsts[item])
        # Balls that are not moved have closed formulas, evaluated for all at once.
        if isinstance(shape, Spheres) and not shape.motion.steps:
            parts.append(_ball_rows(shape, bodies, mine, first))
            continue
        for place, index, face in zip(mine.tolist(), bodies.tolist(), walls.face[mine].tolist(), strict=True):
            jacobian = (walls_of_one(shape, index) if isinstance(shape, Bulk) else walls_of(shape))[face]
            single.append((place, first, jacobian))
    return _concatenate_jacobians([*parts, _single_wall_rows(single)] if single else parts, walls)


@dataclass
class _JacobianRows:
    """Rows of `SurfaceJacobians` about the anchors and in the scale of their own forms, not of the tables."""

    wall: Any
    ids: Any
    of: WallJacobian


def _single_wall_rows(walls: list[tuple[int, int, WallJacobian]]) -> _JacobianRows:
    """Join (row, first parameter of the shape, Jacobian) of walls that were each evaluated alone."""
    counts = [len(wall.ids) for _, _, wall in walls]
    place, first = (np.repeat([part[k] for part in walls], counts) for k in (0, 1))
    anchor, form = (
        np.repeat([getattr(wall, name) for *_, wall in walls], counts, axis=0) for name in ("anchor", "form")
    )
    ids, forms, maps = (
        np.concatenate([getattr(wall, name) for *_, wall in walls]) for name in ("ids", "forms", "maps")
    )
    return _JacobianRows(place, ids + first, WallJacobian(anchor, form, ids, forms, maps))


def _concatenate_jacobians(parts: list[_JacobianRows], walls: HitSurfaces) -> SurfaceJacobians:
    """Join all rows, shifted to the anchors and scaled to the forms in the tables of the scene."""
    if not parts:
        none = np.zeros(0, np.int64)
        return SurfaceJacobians(none, none, np.zeros((0, FORM)), np.zeros((0, MAP)), len(walls.body))
    wall, ids = (np.concatenate([getattr(part, name) for part in parts]) for name in ("wall", "ids"))
    forms, maps = (np.concatenate([getattr(part.of, name) for part in parts]) for name in ("forms", "maps"))
    own, anchors = (np.concatenate([getattr(part.of, name) for part in parts]) for name in ("form", "anchor"))
    # The form of a shape and that in the tables describe one surface, but may differ by a factor.
    by = walls.anchors[wall] - anchors
    scale = scale_between(shift_forms(own, by), walls.forms[wall])
    return SurfaceJacobians(wall, ids, shift_forms(forms, by) / scale[:, None], maps, len(walls.body))


def _ball_rows(shape: Spheres, index: Any, place: Any, first: int) -> _JacobianRows:
    """Return the rows of balls without motion: f = |x - c|² - r², with the derivatives -2 (x - c) and -2 r."""
    radius, center, count = shape.radii[index], shape.centers[index], len(index)
    form, forms, maps = np.zeros((count, 4, FORM)), np.zeros((count, 4, FORM)), np.zeros((count, 4, MAP))
    form[:, :, :3], form[:, :, 9] = 1.0, -(radius**2)[:, None]
    forms[:, :3, 6:9], forms[:, 3, 9] = -np.eye(3), -2 * radius
    # The map of a ball is (x - cx, y - cy, (z - cz) / 2r + 1/2).
    maps[:, 0, 3] = maps[:, 1, 7] = -1.0
    maps[:, 2, 11] = maps[:, 3, 10] = -0.5 / radius
    maps[:, 3, 10] /= radius
    maps[:, 3, 11] = 0.5 * center[:, 2] / radius**2
    ids = np.concatenate([3 * index[:, None] + np.arange(3), 3 * len(shape) + index[:, None]], axis=1) + first
    wall = WallJacobian(
        np.repeat(center, 4, axis=0),
        form.reshape(-1, FORM),
        ids.ravel(),
        forms.reshape(-1, FORM),
        maps.reshape(-1, MAP),
    )
    return _JacobianRows(np.repeat(place, 4), ids.ravel(), wall)


def apply_jacobians(moves: SurfaceJacobians, tangent: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the tangents of walls, (forms (w, 10), maps (w, 12)), for a tangent of the parameters.

    A parameter that does not change counts nothing, even if its derivative is NaN.
    """
    weight = tangent[moves.ids]
    constant = weight == 0
    forms, maps = np.zeros((moves.count, FORM)), np.zeros((moves.count, MAP))
    for out, rows in ((forms, moves.forms), (maps, moves.maps)):
        for k in range(rows.shape[1]):
            column = np.where(constant, 0.0, rows[:, k]) * weight
            out[:, k] = np.bincount(moves.wall, column, moves.count)
    return forms, maps


def apply_jacobians_transposed(moves: SurfaceJacobians, forms: FloatArray, maps: FloatArray, count: int) -> FloatArray:
    """Return the cotangents (count,) of the parameters from those of forms (w, 10) and maps (w, 12) of walls.

    This is the transpose of `apply_jacobians`.
    """
    cotangents = _weighted_sums(moves.forms, forms[moves.wall]) + _weighted_sums(moves.maps, maps[moves.wall])
    return np.bincount(moves.ids, cotangents, count).astype(np.float64)


def _weighted_sums(rows: FloatArray, weights: FloatArray) -> FloatArray:
    """Return row sums of products. A zero factor makes a product 0, even if the other factor is NaN."""
    products = np.where((rows == 0) | (weights == 0), 0.0, rows * weights)
    return products.sum(axis=1)
