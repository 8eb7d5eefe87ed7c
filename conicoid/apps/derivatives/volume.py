"""The derivative of a volume by the numbers of a shape: the integral of the normal velocity over the wall.

V_p = ∫ v dA with v = -f_p / |∇f| outward (Reynolds' transport theorem). The wall is met by parallel rays along three
axes, each crossing weighing |n·a|, as `measure` finds areas: a ray along a meets an element dA with density |n·a|, and
Σ (n·a)² = 1. Nothing is divided by a cosine, so there is no term for outlines to be missed, and the variance is
finite.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..._util.arrays import BoxEnds, FloatArray
from ..._util.errstate import ignore_fp_errors
from ..._util.validation import check_integer, describe_kind, format_value
from ...geometry.bulk import Bulk
from ...kernels.entry.crossings import row_owners
from ...queries import spans
from .crossing_derivatives import make_crossing_rows, pull_back, split_forms_maps
from .hit_surfaces import apply_jacobians_transposed, find_hit_surfaces, surface_jacobians
from .parameters import Parameters
from .ties import find_ties_within

if TYPE_CHECKING:
    from ...queries.scene_protocol import SceneLike

_ROUNDS = 16
_FEWEST, _MOST = 3 * _ROUNDS, 10**12
_CHUNK = 1 << 16


@dataclass(frozen=True)
class VolumeGradient:
    """The derivatives of a body's volume by the parameters, and their standard errors, both (parameters,)."""

    gradient: FloatArray
    error: FloatArray
    rays: int


@ignore_fp_errors
def volume_gradient(parameters: Parameters, body: Any, rays: int = 300_000, seed: int = 0) -> VolumeGradient:
    """How the volume of a body changes with the numbers of its shape, by an integral over its wall.

    parameters: those of `co.parameters(scene)`.
    body: the name of an entry, or the number of a body.
    rays: about how many are followed; the error falls with their number.
    seed: equal seeds give equal answers.

    NaN where walls of the body tie over an area, as flush walls of a union do. Raises ValueError for a body that is
    unbounded or a sheet, KeyError and IndexError for one that there is not.
    """
    if not isinstance(parameters, Parameters):
        raise TypeError(
            f"volume_gradient: parameters must be those of co.parameters(scene), got {describe_kind(parameters)}"
        )
    rays = check_integer("volume_gradient", "rays", rays, _FEWEST, _MOST)
    seed = check_integer("volume_gradient", "seed", seed, 0)
    entry, index = _entry(parameters._scene, body)
    alone = parameters._scene.bodies[entry]
    shape = alone.shape.single(index) if isinstance(alone.shape, Bulk) else alone.shape
    if shape.is_sheet:
        raise ValueError(f"volume_gradient: body must be a solid, got the sheet {format_value(body)}")
    box = shape.bounds
    if not np.isfinite(box).all():
        raise ValueError(f"volume_gradient: body must be bounded, got {format_value(body)} with bounds {box}")
    side = max(1, round((rays / (3 * _ROUNDS)) ** 0.5))
    found = np.array(list(_rounds(type(parameters._scene)([alone]), index, box, side, seed)))
    full = np.zeros((2, len(parameters._full)))
    own = slice(int(parameters._firsts[entry]), int(parameters._firsts[entry + 1]))
    full[0, own], full[1, own] = found.mean(axis=0), found.std(axis=0, ddof=1) / _ROUNDS**0.5
    gradient, error = full[:, parameters._chosen]
    return VolumeGradient(gradient, error, 3 * _ROUNDS * side * side)


def _entry(scene: SceneLike, body: Any) -> tuple[int, int]:
    """The entry of a body, and its number among those of the entry."""
    if isinstance(body, str):
        return scene.bodies.index(body), 0
    scene.body(body)
    entry = int(np.searchsorted(scene._firsts, body, side="right")) - 1
    return entry, int(body - scene._firsts[entry])


def _rounds(alone: SceneLike, index: int, box: BoxEnds, side: int, seed: int) -> Iterator[FloatArray]:
    """Independent estimates (numbers of the shape,), each of a ray through every square of the box's three sides."""
    own = Parameters(alone)
    low, size = box[0], np.maximum(box[1] - box[0], 0.0)
    grid = np.stack(np.meshgrid(np.arange(side), np.arange(side), indexing="ij"), axis=-1).reshape(-1, 2)
    for turn in range(_ROUNDS):
        total = np.zeros(len(own._full))
        for axis in range(3):
            random = np.random.default_rng((seed, turn, axis))
            across = [i for i in range(3) if i != axis]
            origins = np.empty((len(grid), 3))
            origins[:, across] = low[across] + size[across] * (grid + random.random(grid.shape)) / side
            origins[:, axis] = low[axis] - 0.5 * size[axis]
            weight = float(size[across].prod()) / len(grid)
            for begin in range(0, len(origins), _CHUNK):
                total += weight * _integral(alone, own, index, origins[begin : begin + _CHUNK], axis)
        yield total


def _integral(alone: SceneLike, own: Parameters, index: int, origins: FloatArray, axis: int) -> FloatArray:
    """Σ |n·a| v over the crossings of some rays along an axis a, by every number of the shape.

    v = |n·a| dt where the body is left and -|n·a| dt where it is entered: so what is asked of t is ±(n·a)².
    """
    direction = np.eye(3)[axis]
    found: spans.Crossings = alone.crossings(origins, direction, t_min=-np.inf)
    mine = np.flatnonzero(found.body == index)
    prepared, origins = alone.prepared, origins[row_owners(found.offsets)[mine]]
    t, directions = found.t[mine], np.tile(direction, (len(mine), 1))
    points = origins + t[:, None] * directions
    body, face = found.body[mine], found.face[mine].astype(np.int32)
    walls, lost = (
        find_hit_surfaces(prepared, body, face, found.surface[mine]),
        find_ties_within(prepared, body.astype(np.int32), face, points, points),
    )
    crossings = make_crossing_rows(walls.place, np.ones(len(mine), np.int32), lost, points, directions, t)
    sense = np.where(found.entering[mine], -1.0, 1.0)
    asked, _ = pull_back(walls.rows, crossings, (sense * found.normal[mine, axis] ** 2, None, None, None), True)
    return apply_jacobians_transposed(
        surface_jacobians(prepared, walls, own), *split_forms_maps(asked.walls), len(own._full)
    )
