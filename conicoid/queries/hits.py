"""`Hits`, the result of `first_hit`: the arrays that the kernels filled, and fields computed on demand."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from functools import cached_property
from struct import Struct
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from .._jit.machine_code import empty_array
from .._util.arrays import FloatArray, ignore_fp_errors
from .._util.text import format_count
from .._util.validation import DOMAIN, check_npz_path, is_outside_domain, zero_negligible
from ..kernels.body.media import AFTER, BEFORE
from ..kernels.first_hits import HitBuffers
from ..kernels.ray import DEAD, RayArrays
from ..kernels.threads import run_rows
from ..prepare.prepared_scene import PreparedScene
from .derivatives import HitDerivatives
from .hit_fields import faces_of, hit_points, local_points_of, normals_of, uvs_of
from .rays import Rays, find_invalid_ray, join_rays, lines_of, own_copy, points_array
from .result import (
    NO_SCENE,
    QueryResult,
    ShapedRecord,
    check_parts,
    common_scene_state,
    extension,
    format_body,
    format_field,
)

_NO_RAYS = np.zeros(0, np.int64)


class Hits(ShapedRecord, QueryResult, HitDerivatives):
    """First hits of rays, shaped like the rays; one ray gives scalars. All arrays are read-only.

    Attributes
    ----------
    t : float64 (...)
        In units of the direction's length; inf for a miss.
    body, face, surface : int32 (...)
        Numbers; -1 for a miss.
    hit : bool (...)
        Whether the ray hit anything. `if hits:` tests a single ray.
    entering : bool (...)
        normal·direction < 0; False for a miss.
    doubtful : bool (...)
        Whether the hit hangs on a tie: the least change of the ray would give another.
    t_error : float64 (...)
        A bound on the distance of t from the exact crossing; 0 for a miss.
    point_error : float64 (...)
        A bound on the distance of the point from the exact one, in length; NaN for a miss.
    point, local_point, normal : float64 (..., 3)
        The normal is unit and outward; NaN for a miss.
    uv : float64 (..., 2)
        NaN for a miss.
    before, after : int32 (...)
        The body that the ray is in before and after the wall; -1 outside all bodies and for a miss.
    name, material : object (...)
        Name and material of the body; None for a miss.
    rays : Rays (...)
        The traced rays.
    shape, ndim, size
        Those of `t`.

    Notes
    -----
    Pickled or `detached` hits keep all these fields and drop the scene.
    """

    rays: Rays
    _buffers: HitBuffers
    _doubtful: npt.NDArray[np.int64]
    _single: tuple[Any, ...]  # of one ray, see `_of_single`
    _views = ("t", "body", "surface", "face", "entering", "doubtful", "_single", "_single_fields")

    def __init__(self, scene: PreparedScene, rays: Rays, found: HitBuffers, doubtful: Any = ()) -> None:
        vars(self).update(_scene=scene, rays=rays, _buffers=found, _doubtful=np.asarray(doubtful, np.int64))

    @classmethod
    def _of_single(cls, scene: PreparedScene, found: tuple[Any, ...], ray: Rays | None) -> Hits:
        """Return the hit of one ray as a single call found it: bytes of the ray, t, body, entry, place and turn."""
        hits = object.__new__(cls)
        vars(hits).update(_scene=scene, _single=found, t=np.float64(found[1]), _doubtful=_NO_RAYS)
        if ray is not None:
            vars(hits)["rays"] = ray
        return hits

    if not TYPE_CHECKING:  # the arrays of a single hit are made when a field needs them

        @cached_property
        def rays(self) -> Rays:
            return Rays._of_few(self._single[0], single=True)

        @cached_property
        def _buffers(self) -> HitBuffers:
            t, *places, turn = self._single[1:6]
            return HitBuffers(
                np.array([t]), *(np.array([each], np.int32) for each in places), np.array([turn], np.int8)
            )

    @property
    def shape(self) -> tuple[int, ...]:
        """The leading shape, that of `t`."""
        return self.rays.shape

    @cached_property
    def t(self) -> FloatArray:
        return self._shaped(self._buffers.t)

    @cached_property
    def body(self) -> npt.NDArray[np.int32]:
        if "_single" in vars(self):
            return np.int32(self._single[2])  # type: ignore[return-value]
        return self._shaped(self._buffers.body)

    @property
    def hit(self) -> npt.NDArray[np.bool_]:
        """bool (...): whether the ray hit anything."""
        result = self.body >= 0
        if isinstance(result, np.ndarray):
            result.flags.writeable = False
        return result

    def _compute_single(self, direction: Any = None) -> tuple[Any, ...] | None:
        """Return the result of `hit_alone` for a single hit near its ray; None where arrays are needed.

        direction: that of a ray which is to start there.
        """
        single, scene = vars(self).get("_single"), self._scene
        if single is None or single[2] < 0:
            return None
        if scene.lacks_single_calls("hit"):
            _keep_call_of_hit(scene)
        call = scene.single_calls.get("hit")
        if call is None:
            return None
        x, y, z, *along = _LINE.unpack(single[0])
        found = call(scene, (x, y, z), along if direction is None else direction, along, single[1], *single[3:6])
        return None if found is None or found[-1] else found

    @cached_property
    def _single_fields(self) -> tuple[Any, ...] | None:
        """(_, surface, face, side, point, normal, _) of a single hit near its ray, else None."""
        return self._compute_single()

    @cached_property
    def _faces(self) -> Any:
        """int32 (3, n): surface number, face number, side; -1, -1, 0 for a miss."""
        if self._single_fields is not None:
            return np.array(self._single_fields[1:4], np.int32).reshape(3, 1)
        found = self._buffers
        faces = empty_array((3, len(found.t)), np.int32)
        arguments = (self._scene.geometry, found.entry, found.place, found.turn)
        run_rows(faces_of, arguments, len(found.t), faces)
        return faces

    @cached_property
    def surface(self) -> Any:
        return self._shaped(self._faces[0])

    @cached_property
    def face(self) -> Any:
        return self._shaped(self._faces[1])

    @cached_property
    def _sides(self) -> Any:
        """(3, n): the bodies before and after the wall, and the first opaque body that the ray crosses there."""
        from .exact.hit_sides import HitPlaces, sides_of

        scene, rays = self._scene, self.rays
        limits = np.array([-np.inf]), np.array([np.inf])
        arrays, found = RayArrays(*lines_of(rays), *limits, rays._starts_in(scene)), self._buffers
        places = HitPlaces(found.t, np.ascontiguousarray(self._faces[0]), found.entry, found.turn)
        return sides_of(scene, arrays, places)

    @cached_property
    def before(self) -> Any:
        """int32 (...): the body that the ray is in just before the wall; -1 for none, and for a miss.

        Among overlapping bodies a transparent one takes precedence over an opaque one, then the one listed first; this
        is how pictures show glass in water. Coinciding walls act together: two blocks that abut leave no gap, and where
        a nested body ends, the body around it continues.
        """
        return self._shaped(self._sides[BEFORE])

    @cached_property
    def after(self) -> Any:
        """int32 (...): the body that the ray would be in just after the wall, by the rule of `before`."""
        return self._shaped(self._sides[AFTER])

    @cached_property
    def entering(self) -> Any:
        return self._shaped(abs(self._buffers.turn) == 2)

    @cached_property
    def _points(self) -> FloatArray:
        return self._places[0]

    @cached_property
    def _places(self) -> tuple[FloatArray, FloatArray]:
        """Points, and bounds on the errors of those far from the origins of their rays: NaN for others, or empty."""
        if self._single_fields is not None:
            return np.array([self._single_fields[4:7]]), np.empty(0)
        t = self._buffers.t
        points, far, errors = empty_array((len(t), 3), np.float64), np.zeros(1, np.int8), np.empty(0)
        lines = lines_of(self.rays)
        run_rows(hit_points, (*lines, t), len(points), points, far)
        if far[0]:
            from .exact.error_bounds import refine_points

            scene, errors = self._scene, np.empty(len(t))
            arguments = (scene.geometry, scene.rest, *lines, t, self._buffers.turn, self._faces)
            run_rows(refine_points, arguments, len(points), points, errors)
        return points, errors

    @cached_property
    def doubtful(self) -> Any:
        """bool (...): rays whose hit hangs on a tie, so that the least change of the ray would give another."""
        result = np.zeros(len(self._buffers.t), np.bool_)
        result[self._doubtful] = True
        return self._shaped(result)

    @cached_property
    def _errors(self) -> FloatArray:
        from .exact.error_bounds import bounds_of_t

        scene, found = self._scene, self._buffers
        lines, starts = lines_of(self.rays), self.rays._starts_in(scene)
        return bounds_of_t(scene, lines, starts, np.zeros(0, np.int64), found.t, self._faces[0])

    @property
    def t_error(self) -> Any:
        """A bound on |t - t*|, where t* is the exact crossing of ray and surface as given (docs/exactness.md)."""
        return self._shaped(self._errors)

    @cached_property
    def point_error(self) -> Any:
        """A bound on the distance of `point` from the exact point, in length; NaN for a miss."""
        from .exact.error_bounds import errors_of_points

        errors = np.empty(len(self._errors))
        arguments = (lines_of(self.rays)[1], self._points, self._errors)
        run_rows(errors_of_points, arguments, len(errors), errors)
        own = self._places[1]
        return self._shaped(np.where(np.isnan(own), errors, own) if len(own) else errors)

    @property
    def point(self) -> FloatArray:
        return self._shaped(self._points, 3)

    @cached_property
    def local_point(self) -> FloatArray:
        """The point in the frame of the body's own shape; of a ball of `Spheres` relative to its center."""
        local, lowered = np.empty_like(self._points), self._scene.lowered
        arguments = (
            self._scene.geometry,
            lowered.frames,
            lowered.body_frame,
            self._buffers.body,
            self._faces,
            self._points,
        )
        run_rows(local_points_of, arguments, len(local), local)
        return self._shaped(local, 3)

    @cached_property
    def normal(self) -> FloatArray:
        return self._shaped(self._normals if self._single_fields is None else np.array(self._single_fields[7:10]), 3)

    @property
    @ignore_fp_errors
    def _normals(self) -> FloatArray:
        points = self._points
        normals = empty_array(points.shape, np.float64)
        arguments = (self._scene.geometry, self._faces, points)
        run_rows(normals_of, arguments, len(normals), normals)
        return zero_negligible(normals)

    @cached_property
    def uv(self) -> FloatArray:
        uv = np.empty((len(self._points), 2))
        arguments = (self._scene.geometry, self._buffers.body, self._faces, self._points)
        run_rows(uvs_of, arguments, len(uv), uv)
        return self._shaped(uv, 2)

    def spawn(self, directions: npt.ArrayLike) -> Rays:
        """Return rays that start exactly on the hits. They skip the crossing at their origin, without an offset.

        Parameters
        ----------
        directions : array_like (..., 3)
            Broadcasts to the hits, or has axes before theirs: (many, *hits.shape, 3) starts many rays on each hit.
            Rays from misses miss everything, whatever their direction.

        Raises
        ------
        ValueError
            For a NaN, infinite or zero direction of a hit, with its index.
        """
        found = None if directions is None else self._compute_single(directions)
        if found is None:
            return self._spawn_many(directions)
        start = np.array(found[1:2], np.int32)
        return Rays._of_few(_LINE.pack(*found[4:7], 0, 0, 0)[:24] + found[0][24:48], True, start, self._home)

    @ignore_fp_errors
    def _spawn_many(self, directions: Any) -> Rays:
        """Return `spawn` of hits in arrays."""
        array = points_array("spawn", "directions", directions)
        shape = spawned_shape(self.rays.shape, array.shape)
        # A copy: the rays own their directions, whatever the caller writes later
        d, mine = own_copy(array, (*shape, 3)), self.rays.shape
        hit, surfaces = (
            (part if shape == mine else np.broadcast_to(part.reshape(mine), shape)).ravel()
            for part in (self._buffers.body >= 0, self._faces[0])
        )
        flat = d.reshape(-1, 3)
        if find_invalid_ray(flat, flat) is not None:
            refuse_directions(flat, hit, shape)
        starts = np.where(hit, surfaces, np.int32(DEAD))
        points = own_copy(self._points.reshape((*mine, 3)), (*shape, 3))
        return Rays._spawned(points, d, starts, self._home)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write all fields, without the scene, as a .npz file that `co.Hits.load` reads.

        Parameters
        ----------
        path : path
            Must end with .npz. The complete file appears at once, or none.

        Raises
        ------
        ValueError
            For another suffix.
        OSError
            If the file cannot be written.
        """
        extension("hits.write")(check_npz_path("save", "hits", path), self)

    @staticmethod
    def load(path: str | os.PathLike[str]) -> Hits:
        """Return the hits in a file, detached from their scene. Loading executes nothing that the file contains.

        Parameters
        ----------
        path : path
            A .npz file that `save` wrote.

        Raises
        ------
        ValueError
            If the file has another format; the message names the file.
        OSError
            If the file cannot be read.
        """
        return extension("hits.read")(check_npz_path("load", "hits", path))

    @staticmethod
    def concatenate(parts: Iterable[Hits]) -> Hits:
        """Join hits along the first axis, like `np.concatenate`; a single hit counts as a row of one.

        Parameters
        ----------
        parts : iterable of Hits
            Hits of one scene, detached or not.

        Raises
        ------
        TypeError
            If a part is not a Hits.
        ValueError
            If `parts` is empty, if shapes differ in another axis than the first, or if the hits belong to different
            scenes, in which body numbers have different meanings.
        """
        return _concatenate_hits(parts)

    def __bool__(self) -> bool:
        if self.size != 1:
            count = self.size
            raise ValueError(
                f"Hits: the truth value of {count} hits is ambiguous; use hits.hit.any() or hits.hit.all()"
            )
        return bool(np.ravel(self.body)[0] >= 0)

    def __getitem__(self, index: Any) -> Hits:
        """Return the hits that an index or mask over the rays' shape selects."""
        # NumPy's own indexing of the numbers: any index that arrays take selects hits alike
        rows = np.arange(len(self._buffers.t)).reshape(self.rays.shape)[index]
        flat = np.atleast_1d(rows).ravel()
        doubtful = np.flatnonzero(np.isin(flat, self._doubtful)) if len(self._doubtful) else ()
        picked = Hits(self._scene, self.rays[index], HitBuffers(*(array[flat] for array in self._buffers)), doubtful)
        if self._scene is NO_SCENE:
            self._copy_fields(picked, flat)
        return picked

    def _copy_fields(self, picked: Hits, flat: Any) -> None:
        """Copy rows `flat` of all cached fields, which `picked` could not compute without the scene."""
        rows = {"_points": self._points[flat], "_errors": self._errors[flat], "_faces": self._faces[:, flat]}
        fields = (name for name in vars(self) if not name.startswith("_") and name not in (*self._views, "rays"))
        mine, size = self.rays.ndim, self.size
        shaped = {}
        for name in fields:
            field = np.asarray(getattr(self, name))
            last = field.shape[mine:]  # the axes after those of the rays
            shaped[name] = np.array(field.reshape((size, *last))[flat]).reshape((*picked.rays.shape, *last))[()]
        picked.__setstate__({**rows, **shaped, **vars(picked)})
        vars(picked).update(_home=self._home, _labels=self._labels)

    def __repr__(self) -> str:
        if not self.rays.shape:
            return f"Hits({_format_hit(self)})"
        count = int((self._buffers.body >= 0).sum())
        return f"Hits(shape={self.rays.shape}, {count:,} of {format_count(len(self._buffers.t), 'ray', 'rays')} hit)"

    def _repr_html_(self) -> str:
        """Return the table that a notebook shows: a row for each of the first rays."""
        from itertools import islice

        from .._util.text import MOST_ROWS, html_table

        shape, count = self.rays.shape, self.size
        first = self[np.unravel_index(np.arange(min(count, MOST_ROWS)), shape)] if shape else self[None]
        rays = islice(np.ndindex(*shape), MOST_ROWS)
        names = ("t", "body", "name", "face", "entering", "point", "normal")
        fields = zip(*(getattr(first, name) for name in names), strict=True)
        rows = ((", ".join(map(str, ray)), *row) for ray, row in zip(rays, fields, strict=False))
        return html_table(("ray", *names), rows, count)


_LINE = Struct("6d")


def refuse_directions(flat: FloatArray, hit: Any, shape: tuple[int, ...]) -> None:
    """Raise ValueError for the first direction (n, 3) of a hit that cannot be traced."""
    bad = np.flatnonzero(hit & ~(np.isfinite(flat).all(axis=1) & (flat != 0).any(axis=1)))
    if len(bad):
        where = tuple(int(i) for i in np.unravel_index(bad[0], shape))
        raise ValueError(f"spawn: direction must be finite and not zero, got {tuple(flat[bad[0]].tolist())} at {where}")
    bad = np.flatnonzero(hit & is_outside_domain(flat).any(axis=1))
    if len(bad):
        where = tuple(int(i) for i in np.unravel_index(bad[0], shape))
        raise ValueError(
            f"spawn: direction must be {DOMAIN} in every component, got {tuple(flat[bad[0]].tolist())} at {where}"
        )


def spawned_shape(mine: tuple[int, ...], directions: tuple[int, ...]) -> tuple[int, ...]:
    """Return the shape of spawned rays: that of the hits, `mine`, or of directions with axes before theirs."""
    expected = directions[:-1]
    if mine == expected:
        return mine
    try:
        shape = np.broadcast_shapes(mine, expected)
    except ValueError:
        shape = ()
    if shape == mine or (shape == expected and shape):
        return shape
    raise ValueError(f"spawn: directions must broadcast to {(*mine, 3)}, got {directions}")


def _keep_call_of_hit(scene: PreparedScene) -> None:
    """Let a call of `hit_alone` answer for single hits from now on."""
    lines, numbers = [np.ones((1, 3)) for _ in range(3)], [np.ones(1), *(np.zeros(1, np.int32) for _ in range(3))]
    fields = [*(np.zeros(1, np.int32) for _ in range(3)), *(np.zeros(1) for _ in range(6))]
    arguments = (scene.geometry, *lines, *numbers, *fields)
    scene.keep_single_calls("hit", _first_call, ("hit_alone", arguments, (*lines, *numbers), tuple(fields)))


def _first_call(calls: Sequence[Callable[..., Any]], scene: PreparedScene, *numbers: Any) -> Any:
    """Return the result of the first call."""
    return calls[0](*numbers)


def _format_hit(hits: Hits) -> str:
    """Return the main fields of one hit as text."""
    if not hits.hit:
        return "a miss, t=inf"
    fields = [f"{name}={format_field(getattr(hits, name))}" for name in ("t", "point", "normal", "face", "entering")]
    return f"body {format_body(hits.body, hits.name)}, " + ", ".join(fields)


# Hits of several queries joined into one

_HIT_ROWS = ("point_error", "local_point", "normal", "uv", "before", "after")
"""Computed fields of detached hits, each an array shaped like the rays."""


def _concatenate_hits(parts: Any) -> Hits:
    """Join hits (see `Hits.concatenate`). They keep their scene if all parts have the same one."""
    results = check_parts(Hits, parts)
    rays = join_rays("Hits", [part.rays for part in results])
    found = HitBuffers(*(np.concatenate(columns) for columns in zip(*(part._buffers for part in results), strict=True)))
    firsts = np.cumsum([0, *(len(part._buffers.t) for part in results)])
    doubtful = np.concatenate([first + part._doubtful for first, part in zip(firsts, results, strict=False)])
    scene = results[0]._scene
    if scene is not NO_SCENE and all(part._scene is scene for part in results):
        return Hits(scene, rays, found, doubtful)
    return _concatenate_detached_hits([part.detached() for part in results], rays, found, doubtful)


def _concatenate_detached_hits(parts: Sequence[Hits], rays: Rays, found: HitBuffers, doubtful: Any) -> Hits:
    """Join detached hits. Raise ValueError if they belong to different scenes."""
    state: dict[str, Any] = {"rays": rays, "_buffers": found, "_doubtful": doubtful, "_home": parts[0]._home}
    state |= common_scene_state(parts, "Hits")
    state["_faces"] = np.concatenate([part._faces for part in parts], axis=1)
    state["_points"] = np.concatenate([part._points for part in parts])
    state["_errors"] = np.concatenate([part._errors for part in parts])
    for name in _HIT_ROWS:
        arrays = [np.asarray(getattr(part, name)) for part in parts]
        rows = [array if part.rays.shape else array[None] for part, array in zip(parts, arrays, strict=True)]
        state[name] = np.concatenate(rows)
    result = object.__new__(Hits)
    result.__setstate__(state)
    return result
