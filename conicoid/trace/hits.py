"""The answer to `first_hit`: what was found, and what is worked out when asked for."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from .array_kernels import DEAD, local_points_of, normals_of, points_along, uvs_of
from .rays import FloatArray, Rays, points_array
from .threads import run_chunks

if TYPE_CHECKING:
    from .queries import Prepared

_CHUNK = 16384


class Hits:
    """First hits of rays, shaped like the rays; one ray gives scalars. All arrays are read-only.

    t         float64 (...), in units of the direction's length; inf for a miss
    body, face, surface   int32 (...), -1 for a miss
    entering  bool (...): normal·direction < 0; False for a miss
    point, local_point, normal   float64 (..., 3); NaN for a miss; the normal is unit and outward
    uv        float64 (..., 2); NaN for a miss
    """

    def __init__(self, scene: Prepared, rays: Rays, t: FloatArray, ids: Any, flags: Any) -> None:
        self._scene, self.rays = scene, rays
        self._t, self._ids, self._flags = t, ids, flags

    def _shaped(self, array: Any, *last: int) -> Any:
        result = array.reshape((*self.rays.shape, *last))
        result.flags.writeable = False
        return result if last else result[()]

    @cached_property
    def t(self) -> Any:
        return self._shaped(self._t)

    @cached_property
    def body(self) -> Any:
        return self._shaped(np.ascontiguousarray(self._ids[:, 0]))

    @cached_property
    def surface(self) -> Any:
        return self._shaped(np.ascontiguousarray(self._ids[:, 1]))

    @cached_property
    def face(self) -> Any:
        return self._shaped(np.ascontiguousarray(self._ids[:, 2]))

    @cached_property
    def entering(self) -> Any:
        return self._shaped(self._flags[:, 1] != 0)

    @cached_property
    def _points(self) -> FloatArray:
        points = np.empty((len(self._t), 3))
        o, d = self.rays.origins.reshape(-1, 3), self.rays.directions.reshape(-1, 3)
        run_chunks(lambda a, b: points_along(o, d, self._t, a, b, points), len(points), _CHUNK)
        return points

    @property
    def point(self) -> FloatArray:
        result: FloatArray = self._shaped(self._points, 3)
        return result

    @cached_property
    def local_point(self) -> FloatArray:
        """The point in the own frame of the body's shape (for a ball of `Spheres`: from its center)."""
        local, lowered = np.empty_like(self._points), self._scene.lowered
        arguments = (self._scene.geometry, lowered.frames, lowered.body_frame, self._ids, self._points)
        run_chunks(lambda a, b: local_points_of(*arguments, a, b, local), len(local), _CHUNK)
        result: FloatArray = self._shaped(local, 3)
        return result

    @cached_property
    def normal(self) -> FloatArray:
        normals, points = np.empty_like(self._points), self._points
        arguments = (self._scene.geometry, self._ids, self._flags, points)
        run_chunks(lambda a, b: normals_of(*arguments, a, b, normals), len(normals), _CHUNK)
        result: FloatArray = self._shaped(normals, 3)
        return result

    @cached_property
    def uv(self) -> FloatArray:
        uv, points = np.empty((len(self._t), 2)), self._points
        run_chunks(lambda a, b: uvs_of(self._scene.geometry, self._ids, points, a, b, uv), len(uv), _CHUNK)
        result: FloatArray = self._shaped(uv, 2)
        return result

    def spawn(self, directions: Any) -> Rays:
        """Rays that start on the hits: no offset, the surface they start on is known and left out.

        `directions` (..., 3) broadcasts to the hits. Misses stay misses, whatever their direction.
        Raises ValueError for a NaN, infinite or zero direction of a hit, with its index.
        """
        shape = (*self.rays.shape, 3)
        try:
            wanted = np.broadcast_to(points_array("spawn", "directions", directions), shape)
        except ValueError:
            raise ValueError(f"spawn: directions must broadcast to {shape}, got {np.shape(directions)}") from None
        d = np.array(wanted, order="C")
        hit = self._ids[:, 0] >= 0
        flat = d.reshape(-1, 3)
        bad = np.flatnonzero(hit & ~(np.isfinite(flat).all(axis=1) & (flat != 0).any(axis=1)))
        if len(bad):
            where = tuple(int(i) for i in np.unravel_index(bad[0], self.rays.shape))
            raise ValueError(
                f"spawn: direction must be finite and not zero, got {tuple(flat[bad[0]].tolist())} at {where}"
            )
        starts = np.where(hit, self._ids[:, 1], DEAD).astype(np.int32)
        return Rays._spawned(self._points.reshape(shape).copy(), d, starts)

    def __len__(self) -> int:
        return len(self.rays)

    def __getitem__(self, index: Any) -> Hits:
        """The hits that an index or mask over the rays' shape selects."""
        rows = np.arange(len(self._t)).reshape(self.rays.shape)[index]
        flat = np.atleast_1d(rows).ravel()
        return Hits(self._scene, self.rays[index], self._t[flat], self._ids[flat], self._flags[flat])

    def __repr__(self) -> str:
        found = int((self._ids[:, 0] >= 0).sum())
        return f"Hits(shape={self.rays.shape}, {found} of {len(self._t)} rays hit)"
