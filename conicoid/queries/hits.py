"""The answer to `first_hit`: what was found, and fields that are computed on demand."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from .._util.arrays import FloatArray
from .._util.errstate import ignore_fp_errors
from .._util.foreign_names import with_attribute_hints
from .._util.hints import with_method_hints
from .._util.validation import DOMAIN, check_npz_path, is_outside_domain, zero_negligible
from ..geometry.labels import format_count
from ..kernels.body.media import AFTER, BEFORE
from ..kernels.entry.first_hits import HitBuffers
from ..kernels.ray import DEAD, RayArrays
from ..kernels.threads import run_chunks
from .derivative_methods import HitDerivatives
from .hit_fields import faces_of, local_points_of, normals_of, points_along, uvs_of
from .id_arrays import as_id_array
from .rays import Rays, lines_of, points_array, refuse_name_index, refuse_pairs
from .result import NO_SCENE, QueryResult, format_hit

if TYPE_CHECKING:
    from ..prepare.prepared_scene import PreparedScene

_FIELD_CHUNK = 16384


@with_attribute_hints
@with_method_hints
class Hits(QueryResult, HitDerivatives):
    """First hits of rays, shaped like the rays; one ray gives scalars. All arrays are read-only.

    t         float64 (...), in units of the direction's length; inf for a miss
    body, face, surface   int32 (...), -1 for a miss
    hit       bool (...): whether the ray hit anything; of a single ray also `if hits:`
    entering  bool (...): normal·direction < 0; False for a miss
    doubtful  bool (...): the ray took more than the fast formulas
    t_error   float64 (...): t is at most so far from the exact crossing; 0 for a miss
    point_error   float64 (...): so is the point, in length; NaN for a miss
    point, local_point, normal   float64 (..., 3); NaN for a miss; the normal is unit and outward
    uv        float64 (..., 2); NaN for a miss
    before, after   int32 (...): the body that the ray is in before the wall and after it; -1 outside and for a miss
    name, material   objects (...): what the body is called and made of; None for a miss
    rays      Rays (...): those that were asked; of one hit, its own ray
    shape, ndim, size   those of `t`

    Pickled, or `detached`, hits keep all these fields and do not keep the scene.
    """

    rays: Rays
    instead = "hits.t, hits.point, hits.normal and hits.body"
    _found: HitBuffers
    _doubtful: npt.NDArray[np.int64]
    _views = ("t", "body", "surface", "face", "entering", "doubtful")

    def __init__(self, scene: PreparedScene, rays: Rays, found: HitBuffers, doubtful: Any = ()) -> None:
        vars(self).update(_scene=scene, rays=rays, _found=found, _doubtful=np.asarray(doubtful, np.int64))

    @property
    def shape(self) -> tuple[int, ...]:
        """The leading shape, that of `t`."""
        return self.rays.shape

    @property
    def ndim(self) -> int:
        """How many axes `t` has; 0 for a single ray."""
        return len(self.rays.shape)

    @property
    def size(self) -> int:
        """How many hits there are, misses among them."""
        return len(self._found.t)

    def _shaped(self, array: Any, *last: int) -> Any:
        result = array.reshape((*self.rays.shape, *last))
        result.flags.writeable = False
        return result if last else result[()]

    @cached_property
    def t(self) -> FloatArray:
        result: FloatArray = self._shaped(self._found.t)
        return result

    @cached_property
    def body(self) -> npt.NDArray[np.int32]:
        result: npt.NDArray[np.int32] = as_id_array("body", self._shaped(self._found.body))
        return result

    @property
    def hit(self) -> npt.NDArray[np.bool_]:
        """bool (...): did the ray hit anything?"""
        result: npt.NDArray[np.bool_] = self._shaped(self._found.body >= 0)
        return result

    @cached_property
    def _faces(self) -> Any:
        """(3, n): surface, face number, side."""
        found = self._found
        faces = np.empty((3, len(found.t)), np.int32)
        arguments = (self._scene.geometry, found.entry, found.place, found.turn)
        run_chunks(lambda a, b: faces_of(*arguments, a, b, faces), len(found.t), _FIELD_CHUNK)
        return faces

    @cached_property
    def surface(self) -> Any:
        return as_id_array("surface", self._shaped(self._faces[0]))

    @cached_property
    def face(self) -> Any:
        return as_id_array("face", self._shaped(self._faces[1]))

    @cached_property
    def _sides(self) -> Any:
        """(3, n): bodies before and after the wall, and the first opaque one that is crossed there."""
        from .exact.hit_sides import HitPlaces, sides_of

        scene, rays = self._scene, self.rays
        limits = np.array([-np.inf]), np.array([np.inf])
        arrays, found = RayArrays(*lines_of(rays), *limits, rays._starts_in(scene)), self._found
        places = HitPlaces(found.t, np.ascontiguousarray(self._faces[0]), found.entry, found.turn)
        return sides_of(scene, arrays, places)

    @cached_property
    def before(self) -> Any:
        """int32 (...): the body that the ray is in just before the wall; -1 for none, and for a miss.

        Of bodies that overlap a transparent one counts before an opaque one, among equals the one listed first, as
        where pictures show glass in water. What coincides at the wall is taken together: between two blocks that abut
        there is no gap, and where a nested body ends the one around it goes on.
        """
        return as_id_array("before", self._shaped(self._sides[BEFORE]))

    @cached_property
    def after(self) -> Any:
        """int32 (...): the body that the ray would be in just after the wall, by the rule of `before`."""
        return as_id_array("after", self._shaped(self._sides[AFTER]))

    @cached_property
    def entering(self) -> Any:
        return self._shaped(abs(self._found.turn) == 2)

    @cached_property
    def _points(self) -> FloatArray:
        t = self._found.t
        points = np.empty((len(t), 3))
        o, d = lines_of(self.rays)
        run_chunks(lambda a, b: points_along(o, d, t, a, b, points), len(points), _FIELD_CHUNK)
        return points

    @cached_property
    def doubtful(self) -> Any:
        """bool (...): rays that rounding might have got wrong, and that were decided again with certainty."""
        result = np.zeros(len(self._found.t), np.bool_)
        result[self._doubtful] = True
        return self._shaped(result)

    @cached_property
    def _errors(self) -> FloatArray:
        from .exact.error_bounds import bounds_of_t

        scene, found = self._scene, self._found
        lines, starts = lines_of(self.rays), self.rays._starts_in(scene)
        return bounds_of_t(scene, lines, starts, np.zeros(0, np.int64), found.t, self._faces[0])

    @property
    def t_error(self) -> Any:
        """A bound on |t - t*|, t* being where the ray as given crosses the surface as given (docs/exactness.md)."""
        return self._shaped(self._errors)

    @cached_property
    def point_error(self) -> Any:
        """A bound on the distance of `point` from the exact one, in length."""
        from .exact.error_bounds import errors_of_points

        errors = np.empty(len(self._errors))
        arguments = (lines_of(self.rays)[1], self._points, self._errors)
        run_chunks(lambda a, b: errors_of_points(*arguments, a, b, errors), len(errors), _FIELD_CHUNK)
        return self._shaped(errors)

    @property
    def point(self) -> FloatArray:
        result: FloatArray = self._shaped(self._points, 3)
        return result

    @cached_property
    def local_point(self) -> FloatArray:
        """The point in the own frame of the body's shape (for a ball of `Spheres`: from its center)."""
        local, lowered = np.empty_like(self._points), self._scene.lowered
        arguments = (
            self._scene.geometry,
            lowered.frames,
            lowered.body_frame,
            self._found.body,
            self._faces,
            self._points,
        )
        run_chunks(lambda a, b: local_points_of(*arguments, a, b, local), len(local), _FIELD_CHUNK)
        result: FloatArray = self._shaped(local, 3)
        return result

    @cached_property
    @ignore_fp_errors
    def normal(self) -> FloatArray:
        normals, points = np.empty_like(self._points), self._points
        arguments = (self._scene.geometry, self._faces, points)
        run_chunks(lambda a, b: normals_of(*arguments, a, b, normals), len(normals), _FIELD_CHUNK)
        result: FloatArray = self._shaped(zero_negligible(normals), 3)
        return result

    @cached_property
    def uv(self) -> FloatArray:
        uv = np.empty((len(self._points), 2))
        arguments = (self._scene.geometry, self._found.body, self._faces, self._points)
        run_chunks(lambda a, b: uvs_of(*arguments, a, b, uv), len(uv), _FIELD_CHUNK)
        result: FloatArray = self._shaped(uv, 2)
        return result

    @ignore_fp_errors
    def spawn(self, directions: Any) -> Rays:
        """Rays that start on the hits: no offset, the surface they start on is known and left out.

        `directions` (..., 3) broadcasts to the hits, or has axes before theirs: (many, *hits.shape, 3) starts many rays
        on each. Misses stay misses, whatever their direction.
        Raises ValueError for a NaN, infinite or zero direction of a hit, with its index.
        """
        given = points_array("spawn", "directions", directions)
        shape = self._grown(given)
        d = np.array(np.broadcast_to(given, (*shape, 3)), order="C")
        mine = self.rays.shape
        hit = np.broadcast_to((self._found.body >= 0).reshape(mine), shape).ravel()
        flat = d.reshape(-1, 3)
        bad = np.flatnonzero(hit & ~(np.isfinite(flat).all(axis=1) & (flat != 0).any(axis=1)))
        if len(bad):
            where = tuple(int(i) for i in np.unravel_index(bad[0], shape))
            raise ValueError(
                f"spawn: direction must be finite and not zero, got {tuple(flat[bad[0]].tolist())} at {where}"
            )
        bad = np.flatnonzero(hit & is_outside_domain(flat).any(axis=1))
        if len(bad):
            where = tuple(int(i) for i in np.unravel_index(bad[0], shape))
            raise ValueError(
                f"spawn: direction must be {DOMAIN} in every component, got {tuple(flat[bad[0]].tolist())} at {where}"
            )
        surfaces = np.broadcast_to(self._faces[0].reshape(mine), shape).ravel()
        starts = np.where(hit, surfaces, DEAD).astype(np.int32)
        points = np.array(np.broadcast_to(self._points.reshape((*mine, 3)), (*shape, 3)), order="C")
        return Rays._spawned(points, d, starts, self._home)

    def _grown(self, directions: FloatArray) -> tuple[int, ...]:
        """The shape of spawned rays: that of the hits, or of directions with axes before theirs."""
        mine, given = self.rays.shape, directions.shape[:-1]
        try:
            shape = np.broadcast_shapes(mine, given)
        except ValueError:
            shape = ()
        if shape == mine or (shape == given and shape):
            return shape
        many = f"; for several of each hit, (many, {', '.join(map(str, (*mine, 3)))})"
        hint = f"{many}, or hits[..., None].spawn(directions)" if len(given) > len(mine) else ""
        raise ValueError(f"spawn: directions must broadcast to {(*mine, 3)}, got {directions.shape}{hint}")

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write all fields as a .npz file at `path`, which `co.Hits.load` reads; the scene stays behind.

        The file appears whole or not at all. Raises ValueError for another suffix, OSError where it cannot be written.
        """
        from ..io.result_file import write_hits_file

        write_hits_file(check_npz_path("save", "hits", path), self)

    @staticmethod
    def load(path: str | os.PathLike[str]) -> Hits:
        """The hits in the file at `path` that `save` wrote, detached from their scene. Nothing in a file is executed.

        Raises ValueError for what is no such file, naming it, and OSError where it cannot be read.
        """
        from ..io.result_file import read_hits_file

        return read_hits_file(check_npz_path("load", "hits", path))

    @staticmethod
    def concatenate(parts: Iterable[Hits]) -> Hits:
        """Hits one after the other along the first axis, like `np.concatenate`; single ones count as rows of one.

        `parts` are of one scene, with it or without. Raises TypeError for what is no Hits, ValueError for none at all,
        for shapes that do not fit and for hits of different scenes, whose body numbers mean different things.
        """
        from .concatenate import concatenate_hits

        return concatenate_hits(parts)

    def __len__(self) -> int:
        return len(self.rays)

    def __bool__(self) -> bool:
        count = len(self._found.body)
        if count != 1:
            raise ValueError(
                f"Hits: the truth value of {count} hits is ambiguous; use hits.hit.any() or hits.hit.all()"
            )
        return bool(self._found.body[0] >= 0)

    def __iter__(self) -> Iterator[Hits]:
        for i in range(len(self)):
            refuse_pairs("Hits")
            yield self[i]

    def __getitem__(self, index: Any) -> Hits:
        """The hits that an index or mask over the rays' shape selects."""
        refuse_name_index(self, index)
        rows = np.arange(len(self._found.t)).reshape(self.rays.shape)[index]
        flat = np.atleast_1d(rows).ravel()
        doubtful = np.flatnonzero(np.isin(flat, self._doubtful)) if len(self._doubtful) else ()
        picked = Hits(self._scene, self.rays[index], HitBuffers(*(array[flat] for array in self._found)), doubtful)
        if self._scene is NO_SCENE:
            self._hand_on(picked, flat)
        return picked

    def _hand_on(self, picked: Hits, flat: Any) -> None:
        """What only the scene could work out again."""
        rows = {"_points": self._points[flat], "_errors": self._errors[flat], "_faces": self._faces[:, flat]}
        fields = (name for name in vars(self) if not name.startswith("_") and name not in (*self._views, "rays"))
        mine, size = self.rays.ndim, self.size
        shaped = {}
        for name in fields:
            field = np.asarray(getattr(self, name))
            last = field.shape[mine:]
            shaped[name] = np.array(field.reshape((size, *last))[flat]).reshape((*picked.rays.shape, *last))[()]
        picked.__setstate__({**rows, **shaped, **vars(picked)})
        vars(picked).update(_home=self._home, _labels=self._labels)

    def __repr__(self) -> str:
        if not self.rays.shape:
            return f"Hits({format_hit(self)})"
        found = int((self._found.body >= 0).sum())
        return f"Hits(shape={self.rays.shape}, {found:,} of {format_count(len(self._found.t), 'ray', 'rays')} hit)"
