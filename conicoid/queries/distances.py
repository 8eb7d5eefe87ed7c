"""The answer to `distance`: how far points are from the nearest walls, and whose these are."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from .._util.arrays import FloatArray
from .._util.errstate import ignore_fp_errors
from .._util.hints import with_method_hints
from .._util.validation import format_value, real_array, zero_negligible
from ..geometry.labels import format_count
from ..kernels.closest.nearest_walls import nearest_walls
from ..kernels.closest.safety import bounds_of_points
from ..kernels.threads import chunk_size, run_chunks, run_on
from .hit_fields import faces_of, normals_of
from .id_arrays import as_id_array
from .points import body_at, packets_of, points_of, width_of
from .rays import refuse_name_index
from .result import NO_SCENE, QueryResult, format_body, format_field

if TYPE_CHECKING:
    from ..kernels.tables import Geometry
    from ..kernels.threads import Progress
    from ..prepare.prepared_scene import PreparedScene


_FIELD_CHUNK = 16384


class Nearest(NamedTuple):
    """What was found for each point, flat."""

    distance: FloatArray  # (n,) signed
    lower: FloatArray
    error: FloatArray
    point: FloatArray  # (n, 3)
    body: npt.NDArray[np.int32]
    entry: npt.NDArray[np.int32]
    place: npt.NDArray[np.int32]
    turn: npt.NDArray[np.int8]

    @classmethod
    def nothing(cls, count: int) -> Nearest:
        """Nothing found yet."""
        distance, lower, error = (np.empty(count) for _ in range(3))
        body, entry, place = (np.full(count, -1, np.int32) for _ in range(3))
        return cls(distance, lower, error, np.full((count, 3), np.nan), body, entry, place, np.ones(count, np.int8))


@with_method_hints
class Distances(QueryResult):
    """Distances of points from the nearest walls, shaped like the points; one point gives scalars. Read-only.

    Made by `scene.distance` of what was found in a scene.

    distance  float64 (...): negative inside a solid; -inf or inf where there is no wall, or none within max_distance;
              a bound, with the size of `lower`, unless the nearest points were asked for (exact=True)
    lower     float64 (...): certified: no wall is nearer
    error     float64 (...): the true distance is in [|distance| - error, |distance| + error]; inf for a bound
    point, normal   float64 (..., 3): of the nearest wall, the normal unit and outward; NaN where it was not looked for
    body, face, surface   int32 (...): whose wall it is; -1 where it was not looked for, or there is none
    name, material  objects (...): what that body is called and made of
    points    float64 (..., 3): those that were asked for
    shape, ndim, size   those of `distance`
    """

    instead = "distances.distance, distances.lower and distances.point"
    points: FloatArray
    _found: Nearest
    _views = ("distance", "lower", "error", "point", "body", "face", "surface", "normal")

    def __init__(self, scene: PreparedScene, points: FloatArray, found: Nearest) -> None:
        points.flags.writeable = False
        vars(self).update(_scene=scene, points=points, _found=found)

    @property
    def shape(self) -> tuple[int, ...]:
        """The leading shape, that of `distance`."""
        return self.points.shape[:-1]

    @property
    def ndim(self) -> int:
        """How many axes `distance` has; 0 for a single point."""
        return len(self.shape)

    @property
    def size(self) -> int:
        """How many points there are."""
        return len(self._found.distance)

    def _shaped(self, array: Any, *last: int) -> Any:
        result = array.reshape((*self.shape, *last))
        result.flags.writeable = False
        return result if last else result[()]

    @cached_property
    def distance(self) -> FloatArray:
        result: FloatArray = self._shaped(self._found.distance)
        return result

    @cached_property
    def lower(self) -> FloatArray:
        result: FloatArray = self._shaped(self._found.lower)
        return result

    @cached_property
    def error(self) -> FloatArray:
        result: FloatArray = self._shaped(self._found.error)
        return result

    @cached_property
    def point(self) -> FloatArray:
        result: FloatArray = self._shaped(self._found.point, 3)
        return result

    @cached_property
    def body(self) -> npt.NDArray[np.int32]:
        result: npt.NDArray[np.int32] = as_id_array("body", self._shaped(self._found.body))
        return result

    @cached_property
    def _faces(self) -> Any:
        """(3, n): surface, face number, side."""
        found = self._found
        faces = np.empty((3, len(found.distance)), np.int32)
        arguments = (self._scene.geometry, found.entry, found.place, found.turn)
        run_chunks(lambda a, b: faces_of(*arguments, a, b, faces), len(found.distance), _FIELD_CHUNK)
        return faces

    @cached_property
    def face(self) -> Any:
        return as_id_array("face", self._shaped(self._faces[1]))

    @cached_property
    def surface(self) -> Any:
        return as_id_array("surface", self._shaped(self._faces[0]))

    @cached_property
    @ignore_fp_errors
    def _normals(self) -> FloatArray:
        normals = np.empty_like(self._found.point)
        arguments = (self._scene.geometry, self._faces, self._found.point)
        run_chunks(lambda a, b: normals_of(*arguments, a, b, normals), len(normals), _FIELD_CHUNK)
        return zero_negligible(normals)

    @property
    def normal(self) -> FloatArray:
        result: FloatArray = self._shaped(self._normals, 3)
        return result

    def __len__(self) -> int:
        if not self.shape:
            raise TypeError("Distances: those of a single point have no length")
        return self.shape[0]

    def __iter__(self) -> Iterator[Distances]:
        for i in range(len(self)):
            yield self[i]

    def __getitem__(self, index: Any) -> Distances:
        """Those that an index or mask over the points' shape selects."""
        refuse_name_index(self, index)
        rows = np.arange(self.size).reshape(self.shape)[index]
        flat = np.atleast_1d(rows).ravel()
        picked = Distances(self._scene, self.points[index], Nearest(*(array[flat] for array in self._found)))
        if self._scene is NO_SCENE:  # what only the scene could work out again
            vars(picked).update(_faces=self._faces[:, flat], _normals=self._normals[flat])
            vars(picked).update(_home=self._home, _labels=self._labels)
        return picked

    @staticmethod
    def concatenate(parts: Iterable[Distances]) -> Distances:
        """Distances one after the other along the first axis; single ones count as rows of one.

        parts: of one scene, with it or without. Raises TypeError for what is no Distances, ValueError for none at all,
        for shapes that do not fit and for distances in different scenes.
        """
        from .concatenate import concatenate_distances

        return concatenate_distances(parts)

    def __repr__(self) -> str:
        if self.shape:
            inside = int((self._found.distance < 0.0).sum())
            return f"Distances(shape={self.shape}, {inside:,} of {format_count(self.size, 'point', 'points')} inside)"
        names = ("distance", "error", "point", "normal", "face") if self._found.body[0] >= 0 else ("distance", "lower")
        told = ", ".join(f"{name}={format_field(getattr(self, name))}" for name in names)
        return f"Distances({f'body {format_body(self.body, self.name)}, ' if self._found.body[0] >= 0 else ''}{told})"


# How far points are from the walls of a scene: a certified bound at once, or the nearest wall itself.

_BOUND_CHUNK, _EXACT_CHUNK = 64, 256  # packets, points


def reach_of(max_distance: Any, shape: tuple[int, ...]) -> FloatArray:
    """How far walls are looked for from each point, flat; a named ValueError for what is no such distance."""
    expected = f"a positive number or broadcast to {shape}"
    given = real_array("distance", "max_distance", max_distance, expected)
    try:
        reach = np.broadcast_to(given, shape).ravel()
    except ValueError:
        raise ValueError(f"distance: max_distance must be {expected}, got {format_value(max_distance)}") from None
    bad = np.flatnonzero(~(reach > 0.0))
    if len(bad):
        raise ValueError(f"distance: max_distance must be positive, got {float(reach[bad[0]])!r}")
    return np.ascontiguousarray(reach)


def distance(
    scene: PreparedScene,
    points: Any,
    max_distance: Any = math.inf,
    exact: bool = False,
    progress: Progress | None = None,
) -> Distances:
    """Signed distances of points from the nearest walls."""
    flat, shape = points_of("distance", points)
    reach = reach_of(max_distance, shape)
    found = (
        exact_distances(scene, flat, reach, progress)
        if exact
        else distance_bounds(scene, flat, reach, progress, width_of(shape))
    )
    return Distances(scene, flat.reshape((*shape, 3)), found)


def distance_bounds(
    scene: PreparedScene, flat: FloatArray, reach: FloatArray, progress: Progress | None = None, width: int = 0
) -> Nearest:
    """Certified bounds alone. `width`: of the picture that the points make, or 0."""
    count, bounds = len(flat), np.empty(len(flat))
    packets = packets_of(count, width)

    def work(geometry: Geometry, begin: int, end: int) -> None:
        bounds_of_points(geometry, flat, reach, width, begin, end, bounds)

    run_on(
        scene.geometry,
        work,
        packets,
        chunk_size(packets, _BOUND_CHUNK),
        count,
        _progress_in_points(progress, packets, count),
    )
    found = Nearest.nothing(count)
    beyond = ~(bounds < math.inf)
    found.distance[:] = _sign_distances(scene, flat, bounds)
    found.lower[:] = np.where(beyond, reach, bounds)
    found.error[:] = np.where(beyond & (reach == math.inf), 0.0, math.inf)
    return found


def _progress_in_points(progress: Progress | None, packets: int, count: int) -> Progress | None:
    """Told of points, where packets are counted."""
    if progress is None:
        return None
    return lambda done, _: progress(count if done == packets else min(count, 64 * done), count)


def exact_distances(
    scene: PreparedScene, flat: FloatArray, reach: FloatArray, progress: Progress | None = None
) -> Nearest:
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
    found.distance[:] = _sign_distances(scene, flat, away)
    with np.errstate(invalid="ignore"):
        error = np.maximum(upper - away, away - found.lower)
    found.error[:] = np.where(beyond, np.where(found.lower == math.inf, 0.0, math.inf), error)
    return found


def _sign_distances(scene: PreparedScene, flat: FloatArray, away: FloatArray) -> FloatArray:
    """Distances with their signs: negative inside any solid."""
    inside = body_at(scene, flat, "distance") >= 0
    return np.where(inside, -away, away)
