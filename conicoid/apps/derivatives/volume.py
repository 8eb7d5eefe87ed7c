"""The derivative of a volume by the numbers of a shape: the integral of the normal velocity over the wall.

V_p = ∫ v dA with the outward velocity v = -f_p / |∇f| (Reynolds' transport theorem). Parallel rays along the three axes
sample the wall, as `measure` finds areas. A ray along a crosses an element dA with density |n·a|, and Σ (n·a)² = 1 over
the axes, so each crossing has weight |n·a|. No division by a cosine occurs: no boundary term at outlines is missed, and
the variance is finite.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..._util.arrays import BoxEnds, FloatArray, ignore_fp_errors
from ..._util.validation import check_integer, describe_kind, format_value
from ...geometry.bulk import Bulk
from ...kernels.crossings import row_owners
from ...queries import spans
from .crossing_derivatives import make_crossing_rows, pull_back, split_forms_maps
from .hit_surfaces import apply_jacobians_transposed, find_hit_surfaces, surface_jacobians
from .parameters import Parameters
from .ties import find_ties_within

if TYPE_CHECKING:
    from ...queries.scene_protocol import SceneLike

_ROUNDS = 16
"""Independent estimates, whose scatter gives the standard error."""
_FEWEST, _MOST = 3 * _ROUNDS, 10**12
"""Limits of `rays`: at least one ray per axis and round."""
_CHUNK = 1 << 16
"""Rays that are traced at a time."""


@dataclass(frozen=True)
class VolumeGradient:
    """The gradient of a body's volume, by `volume_gradient`.

    Attributes
    ----------
    gradient : float64 (parameters,)
        The derivatives of the volume by the parameters.
    error : float64 (parameters,)
        Their standard errors.
    rays : int
        Number of rays traced.
    """

    gradient: FloatArray
    error: FloatArray
    rays: int


@ignore_fp_errors
def volume_gradient(parameters: Parameters, body: str | int, rays: int = 300_000, seed: int = 0) -> VolumeGradient:
    """Return the gradient of the volume of a body by the parameters, by an integral over its wall.

    Parameters
    ----------
    parameters : Parameters
        Those of `co.parameters(scene)`.
    body : str or int
        The name of an entry, or the number of a body.
    rays : int
        About how many rays are traced; the error falls with their number.
    seed : int
        Equal seeds give equal results.

    Returns
    -------
    VolumeGradient
        NaN where walls of the body tie over an area, as flush walls of a union do.

    Raises
    ------
    TypeError
        For `parameters` of another type.
    ValueError
        For a body that is unbounded or a sheet.
    KeyError
        For an unknown name.
    IndexError
        For an unknown number.
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
    # Each round has side x side rays along each of the three axes.
    side = max(1, round((rays / (3 * _ROUNDS)) ** 0.5))
    # The entry alone: crossings of other bodies do not matter.
    estimates = np.array(list(_rounds(type(parameters._scene)([alone]), index, box, side, seed)))
    full = np.zeros((2, len(parameters._full)))
    # The other parameters do not change the volume: their derivatives stay 0.
    own = slice(int(parameters._firsts[entry]), int(parameters._firsts[entry + 1]))
    full[0, own], full[1, own] = estimates.mean(axis=0), estimates.std(axis=0, ddof=1) / _ROUNDS**0.5
    gradient, error = full[:, parameters._chosen]
    return VolumeGradient(gradient, error, 3 * _ROUNDS * side * side)


def _entry(scene: SceneLike, body: Any) -> tuple[int, int]:
    """Return the entry of a body, and the number of the body within the entry."""
    if isinstance(body, str):
        return scene.bodies.index(body), 0
    scene.body(body)  # it raises for a number that does not exist
    entry = int(np.searchsorted(scene._firsts, body, side="right")) - 1
    return entry, int(body - scene._firsts[entry])


def _rounds(single_body: SceneLike, index: int, box: BoxEnds, side: int, seed: int) -> Iterator[FloatArray]:
    """Yield independent estimates (numbers of the shape,).

    Each is stratified: one random ray through every square of a grid on three sides of the box.
    """
    own = Parameters(single_body)
    low, size = box[0], np.maximum(box[1] - box[0], 0.0)
    grid = np.stack(np.meshgrid(np.arange(side), np.arange(side), indexing="ij"), axis=-1).reshape(-1, 2)
    for turn in range(_ROUNDS):
        total = np.zeros(len(own._full))
        for axis in range(3):
            random = np.random.default_rng((seed, turn, axis))
            across = [i for i in range(3) if i != axis]
            origins = np.empty((len(grid), 3))
            # One random point in each square of the grid.
            origins[:, across] = low[across] + size[across] * (grid + random.random(grid.shape)) / side
            origins[:, axis] = low[axis] - 0.5 * size[axis]
            weight = float(size[across].prod()) / len(grid)
            for begin in range(0, len(origins), _CHUNK):
                # The weight is the area of a square.
                total += weight * _integral(single_body, own, index, origins[begin : begin + _CHUNK], axis)
        yield total


def _integral(single_body: SceneLike, own: Parameters, index: int, origins: FloatArray, axis: int) -> FloatArray:
    """Return Σ |n·a| v over the crossings of rays along an axis a, for every number of the shape.

    v = |n·a| dt where the ray leaves the body, and -|n·a| dt where it enters. So the cotangent of t is ±(n·a)².
    """
    direction = np.eye(3)[axis]
    lists: spans.Crossings = single_body.crossings(origins, direction, t_min=-np.inf)
    # Other bodies of the entry do not count.
    mine = np.flatnonzero(lists.body == index)
    prepared, origins = single_body._prepared, origins[row_owners(lists.offsets)[mine]]
    t, directions = lists.t[mine], np.tile(direction, (len(mine), 1))
    points = origins + t[:, None] * directions
    body, face = lists.body[mine], lists.face[mine].astype(np.int32)
    walls, ties = (
        find_hit_surfaces(prepared, body, face, lists.surface[mine]),
        find_ties_within(prepared, body.astype(np.int32), face, points, points),
    )
    # The side does not matter: no normals are differentiated.
    crossings = make_crossing_rows(walls.place, np.ones(len(mine), np.int32), ties, points, directions, t)
    sense = np.where(lists.entering[mine], -1.0, 1.0)
    cotangents, _ = pull_back(walls.rows, crossings, (sense * lists.normal[mine, axis] ** 2, None, None, None), True)
    return apply_jacobians_transposed(
        surface_jacobians(prepared, walls, own), *split_forms_maps(cotangents.walls), len(own._full)
    )
