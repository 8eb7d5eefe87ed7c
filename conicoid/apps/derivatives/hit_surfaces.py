"""The walls that crossings are on, as tables: of each wall its form, its map to uv, and what moves it."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ..._jit.decorators import kernel
from ..._util.arrays import FloatArray
from ...geometry.bulk import Bulk, Spheres
from ...kernels.body.uv import rows_of_maps
from ...kernels.tables import Ints, Longs
from .crossing_derivatives import WallRows, as_kernel_array
from .quadric_form import FORM, MAP, forms_of, scale_between, shift_forms
from .wall_jacobians import WallJacobian, walls_of, walls_of_one

if TYPE_CHECKING:
    from ...prepare.prepared_scene import PreparedScene
    from .parameters import Parameters

_MOST_KEYS = 1 << 22
"""Of bodies times faces, beyond which those that are there are found by sorting."""


@dataclass
class HitSurfaces:
    """Different walls (w,), and for each crossing its place among them; -1 for a miss."""

    place: Any
    body: Any
    face: Any
    forms: FloatArray  # (w, 10) as the scene's tables have them
    anchors: FloatArray  # (w, 3)
    maps: FloatArray  # (w, 12)
    angular: Any  # (w,) is u an angle?

    @cached_property
    def rows(self) -> WallRows:
        """The walls as kernels take them: form, anchor and map of each."""
        numbers = np.concatenate([self.forms, self.anchors, self.maps], axis=1)
        return WallRows(as_kernel_array(numbers), as_kernel_array(self.angular.astype(np.int8)))


@dataclass
class SurfaceJacobians:
    """What moves some walls: rows of one wall follow one another."""

    wall: Any  # (m,) the wall of each row
    ids: Any  # (m,) the parameter
    forms: FloatArray  # (m, 10)
    maps: FloatArray  # (m, 12)
    count: int = field(default=0)


def find_hit_surfaces(prepared: PreparedScene, body: Any, face: Any, surface: Any) -> HitSurfaces:
    """The walls of crossings (n,) by their bodies, numbers of faces and surfaces."""
    place, first = _distinct(body, face)
    body, face, surface = body[first], face[first], surface[first]
    tables = prepared.lowered.tables
    forms, anchors = forms_of(tables, surface)
    maps, angular = _maps(prepared, body, face, anchors, forms)
    return HitSurfaces(place, body, face, forms, anchors, maps, angular)


def _distinct(body: Any, face: Any) -> tuple[Any, Any]:
    """(place of each pair among the different ones, -1 for none; an index of each of these)."""
    hit = body >= 0
    width = int(face.max(initial=0)) + 1
    keys = np.where(hit, body.astype(np.int64) * width + face, -1)
    most = int(keys.max(initial=-1)) + 1
    if most > _MOST_KEYS:
        _, first, place = np.unique(keys, return_index=True, return_inverse=True)
        missed = int(len(keys) > 0 and not hit.all())
        return place.reshape(keys.shape) - missed, first[missed:]
    known, place, first = np.zeros(most, np.int32), np.empty(keys.shape, np.int64), np.empty(most, np.int64)
    count = number_walls(as_kernel_array(keys), known, place, first)
    return place, first[:count]


@kernel(keys="n", known="out m", place="out n", first="out m")
def number_walls(keys: Longs, known: Ints, place: Longs, first: Longs) -> int:
    """Number walls by their keys as they come: place[i] for each, -1 for keys below 0, and first[k] of each number.

    known: zeros, one for each key. Returns how many numbers there are.
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


def _maps(
    prepared: PreparedScene, body: Any, face: Any, anchors: FloatArray, forms: FloatArray
) -> tuple[FloatArray, Any]:
    """(maps to uv (w, 12), is u an angle) of walls; those of many balls are worked out from their frames."""
    tables = prepared.lowered.tables
    row = tables.body_face[body].astype(np.int64)
    plain = row >= 0
    maps, angular = np.zeros((len(body), MAP)), np.ones(len(body), np.bool_)
    rows: Any = rows_of_maps(tables, body[plain], face[plain]).copy()
    angular[plain] = rows[:, 0] < 0
    rows[:, 0] = np.where(rows[:, 0] < 0, -1 - rows[:, 0], rows[:, 0])
    found = tables.map_rows[rows]
    found[~angular[plain], 2] = 0.0  # a flat map has two rows
    maps[plain] = found.reshape(-1, MAP)
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
    """The radii of balls of `Spheres`, as they were said."""
    items = prepared.lowered.body_item[body]
    radii = np.ones(len(body))
    for item in np.unique(items).tolist():
        mine = items == item
        radii[mine] = prepared.entries[item].shape.radii[body[mine] - _first_body(prepared, item)]
    return radii


def _first_body(prepared: PreparedScene, item: int) -> int:
    return int(np.searchsorted(prepared.lowered.body_item, item))


def surface_jacobians(prepared: PreparedScene, walls: HitSurfaces, parameters: Parameters) -> SurfaceJacobians:
    """What moves the walls, by the parameters' numbers among all of the scene."""
    parts: list[_JacobianRows] = []
    single: list[tuple[int, int, WallJacobian]] = []  # place, first parameter, wall
    if not len(parameters._full):
        return _concatenate_jacobians(parts, walls)
    items = prepared.lowered.body_item[walls.body]
    for item in np.unique(items).tolist():
        mine = np.flatnonzero(items == item)
        shape, bodies = prepared.entries[item].shape, walls.body[mine] - _first_body(prepared, item)
        first = int(parameters._firsts[item])
        if isinstance(shape, Spheres) and not shape.motion.steps:
            parts.append(_ball_rows(shape, bodies, mine, first))
            continue
        for place, index, face in zip(mine.tolist(), bodies.tolist(), walls.face[mine].tolist(), strict=True):
            found = (walls_of_one(shape, index) if isinstance(shape, Bulk) else walls_of(shape))[face]
            single.append((place, first, found))
    return _concatenate_jacobians([*parts, _single_wall_rows(single)] if single else parts, walls)


@dataclass
class _JacobianRows:
    """Some rows of `Moving`, the forms about an anchor of their own and by the own form of the wall."""

    wall: Any
    ids: Any
    of: WallJacobian


def _single_wall_rows(walls: list[tuple[int, int, WallJacobian]]) -> _JacobianRows:
    """Walls that were each worked out alone, by their places and the first parameters of their shapes."""
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
    """All rows, about the anchors of the scene's tables and in the scale of their forms."""
    if not parts:
        none = np.zeros(0, np.int64)
        return SurfaceJacobians(none, none, np.zeros((0, FORM)), np.zeros((0, MAP)), len(walls.body))
    wall, ids = (np.concatenate([getattr(part, name) for part in parts]) for name in ("wall", "ids"))
    forms, maps = (np.concatenate([getattr(part.of, name) for part in parts]) for name in ("forms", "maps"))
    own, anchors = (np.concatenate([getattr(part.of, name) for part in parts]) for name in ("form", "anchor"))
    by = walls.anchors[wall] - anchors
    scale = scale_between(shift_forms(own, by), walls.forms[wall])
    return SurfaceJacobians(wall, ids, shift_forms(forms, by) / scale[:, None], maps, len(walls.body))


def _ball_rows(shape: Spheres, index: Any, place: Any, first: int) -> _JacobianRows:
    """Many balls where they were said: |x - c|² - r² and its derivatives, -2 (x - c) and -2 r."""
    radius, center, count = shape.radii[index], shape.centers[index], len(index)
    form, forms, maps = np.zeros((count, 4, FORM)), np.zeros((count, 4, FORM)), np.zeros((count, 4, MAP))
    form[:, :, :3], form[:, :, 9] = 1.0, -(radius**2)[:, None]
    forms[:, :3, 6:9], forms[:, 3, 9] = -np.eye(3), -2 * radius
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
    """(forms (w, 10), maps (w, 12)): how walls change where the parameters change by a tangent.

    What a parameter that stays does counts nothing, known or not.
    """
    weight = tangent[moves.ids]
    still = weight == 0
    forms, maps = np.zeros((moves.count, FORM)), np.zeros((moves.count, MAP))
    for out, rows in ((forms, moves.forms), (maps, moves.maps)):
        for k in range(rows.shape[1]):
            column = np.where(still, 0.0, rows[:, k]) * weight
            out[:, k] = np.bincount(moves.wall, column, moves.count)
    return forms, maps


def apply_jacobians_transposed(moves: SurfaceJacobians, forms: FloatArray, maps: FloatArray, count: int) -> FloatArray:
    """The transpose of `combined`: (count,) of what is asked of forms (w, 10) and maps (w, 12) of walls."""
    asked = _weighted_sums(moves.forms, forms[moves.wall]) + _weighted_sums(moves.maps, maps[moves.wall])
    found: FloatArray = np.bincount(moves.ids, asked, count).astype(np.float64)
    return found


def _weighted_sums(rows: FloatArray, weights: FloatArray) -> FloatArray:
    """Sums of products; what is not known counts nothing where it does not matter."""
    products = np.where((rows == 0) | (weights == 0), 0.0, rows * weights)
    found: FloatArray = products.sum(axis=1)
    return found
