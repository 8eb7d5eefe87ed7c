"""How far points are from the walls of a scene: a certified bound at once, or the nearest wall itself."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from ...shapes.arrays import real_array
from ...shapes.validate import shown
from ...shapes.vector import FloatArray
from ..answers.distances import Distances, Nearest
from ..nearest.kernels import nearest_walls
from ..safety.kernels import bounds_of_points
from ..threads import chunk_size, run_on
from .points import body_at, packets_of, points_of, width_of

if TYPE_CHECKING:
    from ..prepared import Prepared
    from ..tables import Geometry
    from ..threads import Progress

_CHUNK, _EXACT_CHUNK = 64, 256  # packets, points


def reach_of(max_distance: Any, shape: tuple[int, ...]) -> FloatArray:
    """How far walls are looked for from each point, flat; a named ValueError for what is no such distance."""
    expected = f"a positive number or broadcast to {shape}"
    given = real_array("distance", "max_distance", max_distance, expected)
    try:
        reach = np.broadcast_to(given, shape).ravel()
    except ValueError:
        raise ValueError(f"distance: max_distance must be {expected}, got {shown(max_distance)}") from None
    bad = np.flatnonzero(~(reach > 0.0))
    if len(bad):
        raise ValueError(f"distance: max_distance must be positive, got {float(reach[bad[0]])!r}")
    return np.ascontiguousarray(reach)


def distance(
    scene: Prepared, points: Any, max_distance: Any = math.inf, exact: bool = False, progress: Progress | None = None
) -> Distances:
    """Signed distances of points from the nearest walls."""
    flat, shape = points_of("distance", points)
    reach = reach_of(max_distance, shape)
    found = nearest(scene, flat, reach, progress) if exact else bounded(scene, flat, reach, progress, width_of(shape))
    return Distances(scene, flat.reshape((*shape, 3)), found)


def bounded(
    scene: Prepared, flat: FloatArray, reach: FloatArray, progress: Progress | None = None, width: int = 0
) -> Nearest:
    """Certified bounds alone. `width`: of the picture that the points make, or 0."""
    count, bounds = len(flat), np.empty(len(flat))
    packets = packets_of(count, width)

    def work(geometry: Geometry, begin: int, end: int) -> None:
        bounds_of_points(geometry, flat, reach, width, begin, end, bounds)

    run_on(scene.geometry, work, packets, chunk_size(packets, _CHUNK), count, _of_points(progress, packets, count))
    found = Nearest.nothing(count)
    beyond = ~(bounds < math.inf)
    found.distance[:] = _signed(scene, flat, bounds)
    found.lower[:] = np.where(beyond, reach, bounds)
    found.error[:] = np.where(beyond & (reach == math.inf), 0.0, math.inf)
    return found


def _of_points(progress: Progress | None, packets: int, count: int) -> Progress | None:
    """Told of points, where packets are counted."""
    if progress is None:
        return None
    return lambda done, _: progress(count if done == packets else min(count, 64 * done), count)


def nearest(scene: Prepared, flat: FloatArray, reach: FloatArray, progress: Progress | None = None) -> Nearest:
    """The nearest wall of each point."""
    count, found = len(flat), Nearest.nothing(len(flat))
    lower, upper, away = np.empty(count), np.empty(count), np.empty(count)

    def work(geometry: Geometry, begin: int, end: int) -> None:
        nearest_walls(
            geometry, flat, reach, begin, end, found.body, found.entry, found.place, found.turn, away, lower, upper,
            found.point,
        )  # fmt: skip

    run_on(scene.geometry, work, count, chunk_size(count, _EXACT_CHUNK), count, progress)
    beyond = ~((away <= reach) & (away < math.inf))
    for field in (found.body, found.entry, found.place):
        field[beyond] = -1
    found.point[beyond] = math.nan
    away[beyond], upper[beyond] = math.inf, math.inf
    found.lower[:] = np.maximum(0.0, np.where(beyond, np.minimum(lower, reach), np.minimum(lower, away)))
    found.distance[:] = _signed(scene, flat, away)
    with np.errstate(invalid="ignore"):
        error = np.maximum(upper - away, away - found.lower)
    found.error[:] = np.where(beyond, np.where(found.lower == math.inf, 0.0, math.inf), error)
    return found


def _signed(scene: Prepared, flat: FloatArray, away: FloatArray) -> FloatArray:
    """Distances with their signs: negative inside any solid."""
    inside = body_at(scene, flat, "distance") >= 0
    return np.where(inside, -away, away)
