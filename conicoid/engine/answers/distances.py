"""The answer to `distance`: how far points are from the nearest walls, and whose these are."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ...shapes.arrays import without_traces
from ...shapes.calls import explained_methods
from ...shapes.calm import calm
from ...shapes.labels import counted
from ...shapes.vector import FloatArray
from ..threads import run_chunks
from .answer import NO_SCENE, Answer
from .fields import faces_of, normals_of
from .no_names import numbers_of
from .rays import refuse_name
from .told import _body, _plain

if TYPE_CHECKING:
    from ..prepared import Prepared

_CHUNK = 16384


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


@explained_methods
class Distances(Answer):
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

    def __init__(self, scene: Prepared, points: FloatArray, found: Nearest) -> None:
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
        result: npt.NDArray[np.int32] = numbers_of("body", self._shaped(self._found.body))
        return result

    @cached_property
    def _faces(self) -> Any:
        """(3, n): surface, face number, side."""
        found = self._found
        faces = np.empty((3, len(found.distance)), np.int32)
        arguments = (self._scene.geometry, found.entry, found.place, found.turn)
        run_chunks(lambda a, b: faces_of(*arguments, a, b, faces), len(found.distance), _CHUNK)
        return faces

    @cached_property
    def face(self) -> Any:
        return numbers_of("face", self._shaped(self._faces[1]))

    @cached_property
    def surface(self) -> Any:
        return numbers_of("surface", self._shaped(self._faces[0]))

    @cached_property
    @calm
    def _normals(self) -> FloatArray:
        normals = np.empty_like(self._found.point)
        arguments = (self._scene.geometry, self._faces, self._found.point)
        run_chunks(lambda a, b: normals_of(*arguments, a, b, normals), len(normals), _CHUNK)
        return without_traces(normals)

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
        refuse_name(self, index)
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
        from .joined import joined_distances

        return joined_distances(parts)

    def __repr__(self) -> str:
        if self.shape:
            inside = int((self._found.distance < 0.0).sum())
            return f"Distances(shape={self.shape}, {inside:,} of {counted(self.size, 'point', 'points')} inside)"
        names = ("distance", "error", "point", "normal", "face") if self._found.body[0] >= 0 else ("distance", "lower")
        told = ", ".join(f"{name}={_plain(getattr(self, name))}" for name in names)
        return f"Distances({f'body {_body(self.body, self.name)}, ' if self._found.body[0] >= 0 else ''}{told})"
