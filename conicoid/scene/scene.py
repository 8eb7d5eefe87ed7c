"""What a scene holds: bodies by name and number, lights, a camera, a background."""

from __future__ import annotations

import dataclasses
import math
import os
from collections.abc import Callable, Iterable, Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal, NoReturn, overload

import numpy as np

from .._util.arrays import BoxEnds, FloatArray
from .._util.defaults import DEFAULT_T_MAX, DEFAULT_T_MIN
from .._util.errstate import ignore_fp_errors
from .._util.foreign_names import HintingType, scene_attribute_error
from .._util.fork_safe_locks import fork_safe_lock
from .._util.hints import frozen_with_hints, with_method_hints
from .._util.name_tuples import NamedPartTuple, PartTuple
from .._util.validation import (
    check_callback,
    check_flag,
    check_number,
    check_positive,
    describe_kind,
    format_value,
    is_dask_array,
)
from .._util.validation import check_path as checked_path
from ..geometry.body import Body
from ..geometry.bounds.aabb import Bounds
from ..geometry.entries import (
    Bodies,
    apply_motion,
    as_bodies,
    as_index,
    exchange_entry,
    find_body,
    find_entry,
    insert_entries,
    one_entry,
    refuse_same_names,
    remove_entries,
    replace_entry,
    share_equal_bodies,
)
from ..geometry.instances import InstanceList
from ..geometry.labels import count_bodies, distinct_materials, first_numbers, format_count, single_body
from ..geometry.shape import Shape, Solid
from ..geometry.tracks import BodyTrack, CameraTrack, LightTrack
from ..materials.material import Material

if TYPE_CHECKING:
    from ..apps.explain.explanation import Explanation
    from ..apps.explain.scene_surface import SceneSurface
    from ..apps.section.slice import Slice
    from ..apps.section.voxels import Voxels
    from ..geometry.entries import Bodies
    from ..io.images.image import Image
    from ..kernels.threads import Progress
    from ..prepare.lowering import LoweredScene
    from ..prepare.memory import Memory
    from ..prepare.prepared_scene import PreparedScene
    from ..queries.distances import Distances
    from ..queries.hits import Hits
    from ..queries.points import BodiesAt
    from ..queries.rays import Rays
    from ..queries.spans import Crossings, Spans
    from ..render.camera import AnyCamera, Camera, OrthographicCamera
    from ..render.film.options import Filter


_OTHER_MATERIALS = "bodies have materials, scene.replace(which, material=...) is a scene with another"


@with_method_hints
class SceneContents:
    """The parts of a scene, as they were said, and its bodies as a sequence by their numbers."""

    _bodies: Bodies
    _lights: tuple[Any, ...]
    _camera: Any
    _background: Any
    _domain: Solid | None
    _animation: tuple[Any, ...]
    _notes: tuple[str, ...] = ()

    @property
    def bodies(self) -> Bodies:
        """The entries as listed; those of an imported model are made one by one as they are asked for.

        A `Spheres` or `Boxes` is one entry and many bodies, so body numbers go to `body`, not here. An index below 0 is
        refused, as -1 is the number of a miss; and so is one of an answer (NumPy's integers) where another body has
        that number.
        """
        return self._bodies

    @property
    def lights(self) -> tuple[Any, ...]:
        """The lights as listed; with none, pictures are lit by some that fit."""
        return PartTuple(self._lights, "scene.lights", "scene.replace(lights=[...]) is a scene with other lights")

    @property
    def camera(self) -> Any:
        """The camera, or None: then pictures are taken by `fitting_camera(width / height)`.

        `scene.rays(width, height)` are the rays of either; `scene.camera or scene.fitting_camera()` is one in any case.
        """
        return self._camera

    @property
    def background(self) -> Any:
        """A colour or a `Sky`: what rays see that hit nothing."""
        return self._background

    @property
    def domain(self) -> Solid | None:
        """What the bodies are to fill, as the cells of an imported model are; None for a scene that says nothing."""
        return self._domain

    @property
    def notes(self) -> tuple[str, ...]:
        """What an importer has to say of the scene, one text each: its size, and what is not as the file says.

        Copies, pickles and `replace` keep them, scene files do not; scenes that differ in them are equal.
        """
        return self._notes

    def body(self, number: Any) -> Body:
        """The body of a `number`, as `hits.body` and `body_at` tell it; a ball of a `Spheres` as a `Sphere` of its own.

        So one of `Boxes` is a `Box`. It has its own material, and its entry's name.

        IndexError for numbers that there are not, -1, a miss, among them.
        """
        entry, ball = find_body(self._firsts, number)
        return single_body(self._bodies[entry], ball)

    @overload
    def __getitem__(self, name: str | int | np.integer[Any]) -> Body: ...

    @overload
    def __getitem__(self, name: slice) -> tuple[Body, ...]: ...

    def __getitem__(self, name: Any) -> Any:
        """The entry of a name, the body of a number, or the bodies of a slice of numbers."""
        if isinstance(name, str):
            return self._bodies[find_entry(self._bodies, name)]
        if isinstance(name, slice):
            return tuple(self.body(number) for number in range(*name.indices(self.body_count)))
        if as_index(name) is None:
            raise TypeError(
                f"Scene: index must be a name, a body's number or a slice of numbers, got {format_value(name)}"
            )
        return self.body(name)

    if not TYPE_CHECKING:  # else checkers would let entries be set

        def __setitem__(self, which: Any, item: Any) -> NoReturn:
            raise TypeError("a Scene is read-only: scene.replace(which, shape or Body) is one with another entry")

        def __delitem__(self, which: Any) -> NoReturn:
            raise TypeError("a Scene is read-only: scene.without(which) is one with fewer entries")

    def __len__(self) -> int:
        """How many bodies there are, `body_count`: `scene[i]` and a loop over the scene go through them."""
        return self.body_count

    def __add__(self, other: object) -> Any:
        if isinstance(other, Shape | Body | list | tuple):
            raise TypeError("Scene: a scene does not change, scene.added(items) is one with more entries")
        if not isinstance(other, SceneContents):
            return NotImplemented
        raise TypeError("Scene: scenes are put together by their entries, co.Scene([*a.bodies, *b.bodies], a.lights)")

    __or__ = __add__

    def __array__(self, dtype: Any = None, copy: Any = None) -> Any:
        """An array () of the scene itself, as NumPy's files keep it."""
        from ..queries.result import box_object

        del copy
        return box_object(self, dtype)

    def __contains__(self, item: object) -> bool:
        """Is there an entry of a name, this body, or an entry of this shape? A TypeError for anything else."""
        if isinstance(item, str):
            if isinstance(self._bodies, InstanceList):
                return self._bodies.number(item) is not None
            return any(item == body.name for body in self._bodies)
        if isinstance(item, Shape):
            return any(item == body.shape for body in self._bodies)
        if isinstance(item, Body):
            return item in self._bodies
        hint = "; scene.materials has the materials" if isinstance(item, Material) else ""
        raise TypeError(f"Scene: `in` asks for a name, a shape or a Body, got {describe_kind(item)}{hint}")

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, SceneContents):
            return NotImplemented
        return self._parts == other._parts

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        told = [format_count(self.body_count, "body", "bodies"), format_count(len(self._lights), "light", "lights")]
        if len(self._bodies) != self.body_count:
            told[0] += f" in {format_count(len(self._bodies), 'entry', 'entries')}"
        told += [format_count(len(self._notes), "note", "notes")] if self._notes else []
        return f"Scene({', '.join(told)})"

    @property
    def _parts(self) -> tuple[Any, ...]:
        return self._bodies, self._lights, self._camera, self._background, self._domain, self._animation

    @cached_property
    def _firsts(self) -> Any:
        """The first body number of each entry, and last how many there are."""
        if isinstance(self._bodies, InstanceList):
            return np.arange(len(self._bodies) + 1)
        return first_numbers(self._bodies)

    @property
    def body_count(self) -> int:
        """How many body numbers there are: one for each entry, N for a `Spheres` of N balls."""
        return int(self._firsts[-1])

    @property
    def materials(self) -> tuple[Any, ...]:
        """The different materials, in the order of the first body of each; None is that of bodies without.

        Those are different that differ in anything: two of one name, say, in their colour. `materials["steel"]` is the
        one of a name, and `materials.index("steel")` its place. Numbers of bodies are no places here: such an index of
        an answer (NumPy's int32) is refused where the body has another material, and so is -1.
        """
        bodies = self._bodies
        found = bodies.distinct_materials if isinstance(bodies, InstanceList) else distinct_materials(bodies)
        return NamedPartTuple(
            found, "scene.materials", _OTHER_MATERIALS, material_of=lambda number: self.body(number).material
        )


# Scenes made from scenes: by replacing, moving, adding and removing entries, or with other lights and cameras.

_UNCHANGED: Any = object()


@with_method_hints
class SceneEdits:
    """What gives new scenes; each takes what is prepared of the old one, and prepares only what is new."""

    _bodies: Bodies
    _firsts: Any

    @property
    def _parts(self) -> tuple[Any, ...]:
        raise NotImplementedError

    def _edited(self, bodies: Bodies, *parts: Any, before: Scene | None = None) -> Scene:
        raise NotImplementedError

    def replace(
        self,
        which: str | int | None = None,
        item: Shape | Body | None = None,
        *,
        material: Any = _UNCHANGED,
        name: Any = _UNCHANGED,
        lights: Any = _UNCHANGED,
        camera: Any = _UNCHANGED,
        background: Any = _UNCHANGED,
        domain: Any = _UNCHANGED,
        animation: Any = _UNCHANGED,
    ) -> Scene:
        """A scene with one entry changed, or other lights, camera, background, domain or animation.

        It prepares only that.

        which: the name of the entry, or the number of its body.
        item: a shape takes the place of the entry's shape, which keeps its material and name, and a `Body` that of the
            whole entry, whose name stays if the `Body` has none.
        material, name: change these alone, or besides; None takes them away.
        lights, camera, background, domain, animation: as for a `Scene`; None takes them away.

        Raises KeyError and IndexError for an entry that there is not.
        """
        labels = {key: new for key, new in dict(material=material, name=name).items() if new is not _UNCHANGED}
        keeps = which is None and item is None and not labels
        asked = lights, camera, background, domain, animation
        given = (old if new is _UNCHANGED else new for new, old in zip(asked, self._parts[1:], strict=True))
        if keeps:
            return self._edited(self._bodies, *given)
        return self._with_entry(*exchange_entry(self._bodies, self._first_numbers, which, item, labels), *given)

    def moved(self, which: str | int, motion: Any) -> Scene:
        """A scene with one entry moved; it prepares only that.

        which: the name of the entry, or the number of its body.
        motion: three numbers, by which it is translated; or a `matrix` (4, 4), as for `shape.transform`; or a function
            that is handed the shape and returns what takes its place: lambda shape: shape.rotate("z", 30).

        Raises KeyError and IndexError for an entry that there is not.
        """
        entry = one_entry(self._bodies, self._first_numbers, which, "moved")
        old = self._bodies[entry]
        return self._with_entry(entry, old, dataclasses.replace(old, shape=apply_motion(old.shape, motion)))

    def added(self, items: Shape | Body | Iterable[Shape | Body], before: str | int | None = None) -> Scene:
        """A scene with more entries; it prepares only these.

        items: shapes or `Body`s, or one of them.
        before: the name of the entry that they come before, or the number of its body; None puts them at the end.

        Raises KeyError and IndexError for an entry that there is not, ValueError for a name that is taken.
        """
        place = len(self._bodies)
        if before is not None:
            place = one_entry(self._bodies, self._first_numbers, before, "added", "before")
        bodies = insert_entries(self._bodies, place, as_bodies(items, "added"))
        refuse_same_names(bodies)
        return self._edited(bodies)

    def without(self, which: str | int | Iterable[str | int]) -> Scene:
        """A scene without some entries; it prepares nothing anew.

        which: the name of the entry, or the number of its body; or a list of these.

        Raises KeyError and IndexError for an entry that there is not.
        """
        each = which if isinstance(which, Iterable) and not isinstance(which, str) else [which]
        gone = {one_entry(self._bodies, self._first_numbers, one, "without") for one in each}
        return self._edited(remove_entries(self._bodies, gone))

    def _with_entry(self, entry: int, old: Body, body: Body, *parts: Any) -> Scene:
        """The scene with another body for an entry of the list, which is `old`; parts as for `_edited`."""
        bodies = replace_entry(self._bodies, entry, old, body)
        if body.name is not None and body.name != old.name:
            refuse_same_names(bodies)
        made = self._edited(bodies, *parts)
        if "_firsts" in vars(self) and count_bodies(old) == count_bodies(body):
            made._firsts = self._firsts
        return made

    def _taking_from(self, before: Scene) -> Scene:
        """The same scene, with what is equal in one that is prepared taken from there."""
        return self._edited(share_equal_bodies(before.bodies, self._bodies), *self._parts[1:], before=before)

    def _first_numbers(self) -> Any:
        return self._firsts


# The questions that a scene answers: along rays, and at points.


class SceneQueries:
    """What can be asked of `prepared`, the lowered scene with its tree; `_prepared` is None before it is."""

    _prepared: PreparedScene | None

    @property
    def prepared(self) -> PreparedScene:
        """Built on first use."""
        raise NotImplementedError

    @ignore_fp_errors
    def first_hit(
        self, origins: Any, directions: Any = None, t_min: Any = DEFAULT_T_MIN, t_max: Any = DEFAULT_T_MAX, *,
        executor: Any = None,
    ) -> Hits:  # fmt: skip
        """The nearest crossing of each ray in the open interval (t_min, t_max).

        origins, directions: (..., 3), which broadcast; or a `Rays` alone. Directions are of any length but 0.
        t_min, t_max: the interval, one for all rays or one for each, in units of the direction's length; where t_min
            is not below t_max it is empty, and nothing is hit. If not given, 0 and infinity; of the rays of a scan,
            `co.Rays.from_scan`, what the scan says.

        executor: an executor, a Dask client or a `co.parallel.Workers` that does it in parts, to the same bits; the
            other queries take it as well.

        Arrays of Dask instead of NumPy's have lazy answers, arrays of Dask too.
        Raises ValueError for rays that cannot be traced, with the index of the first.
        """
        if _is_remote(executor, origins, directions):
            from ..parallel.queries import dispatch_rays

            found: Hits = dispatch_rays(self, "first_hit", executor, origins, directions, t_min, t_max)
            return found
        from ..queries import ray_queries

        return ray_queries.first_hit(self.prepared, ray_queries.as_rays("first_hit", origins, directions), t_min, t_max)

    @ignore_fp_errors
    def occluded(
        self, origins: Any, directions: Any = None, t_min: Any = DEFAULT_T_MIN, t_max: Any = DEFAULT_T_MAX, *,
        executor: Any = None,
    ) -> Any:  # fmt: skip
        """bool (...): is there any crossing strictly between t_min and t_max?  Equals first_hit(...).t < inf.

        origins, directions, t_min, t_max: as for `first_hit`; in an empty interval, t_min >= t_max, there is none.
        executor: as for `first_hit`.
        """
        if _is_remote(executor, origins, directions):
            from ..parallel.queries import dispatch_rays

            return dispatch_rays(self, "occluded", executor, origins, directions, t_min, t_max)
        from ..queries import ray_queries

        return ray_queries.occluded(self.prepared, ray_queries.as_rays("occluded", origins, directions), t_min, t_max)

    @ignore_fp_errors
    def spans(
        self, origins: Any, directions: Any = None, t_min: Any = DEFAULT_T_MIN, t_max: Any = DEFAULT_T_MAX, *,
        executor: Any = None,
    ) -> Spans:  # fmt: skip
        """Every stretch of each ray inside each solid, clipped to [t_min, t_max], sorted along the ray.

        origins, directions, t_min, t_max: as for `first_hit`; an empty interval, t_min >= t_max, has no spans.
        executor: as for `first_hit`.
        """
        if _is_remote(executor, origins, directions):
            from ..parallel.queries import dispatch_rays

            found: Spans = dispatch_rays(self, "spans", executor, origins, directions, t_min, t_max)
            return found
        from ..queries import ray_queries

        return ray_queries.spans(self.prepared, ray_queries.as_rays("spans", origins, directions), t_min, t_max)

    @ignore_fp_errors
    def crossings(
        self, origins: Any, directions: Any = None, t_min: Any = DEFAULT_T_MIN, t_max: Any = DEFAULT_T_MAX, *,
        executor: Any = None,
    ) -> Crossings:  # fmt: skip
        """Every crossing of each ray with solids and sheets, strictly between t_min and t_max, sorted along the ray.

        origins, directions, t_min, t_max: as for `first_hit`; an empty interval, t_min >= t_max, has no crossings.
        executor: as for `first_hit`.
        """
        if _is_remote(executor, origins, directions):
            from ..parallel.queries import dispatch_rays

            found: Crossings = dispatch_rays(self, "crossings", executor, origins, directions, t_min, t_max)
            return found
        from ..queries import ray_queries

        return ray_queries.crossings(self.prepared, ray_queries.as_rays("crossings", origins, directions), t_min, t_max)

    @ignore_fp_errors
    def stream(
        self, rays: Any, query: str = "first_hit", *, chunk: int | None = None, executor: Any = None,
        out: str | os.PathLike[str] | None = None, **options: Any,
    ) -> Any:  # fmt: skip
        """The answers to any number of rays, part by part and in order: neither rays nor answers are kept.

        rays: `Rays`, those of `Rays.from_camera` or `from_scan`; (origins, directions), or one array (n, 6) of both,
            which may be of `np.memmap`, zarr or what else is sliced; an iterable of such, one part after the other; or
            the name of a file of rays, .npy, .npz, .csv, .parquet or .zarr, that is read part by part.
        query: the name of a query of rays; options: its other arguments, such as `t_max` or `values`, for all rays.
        chunk: rays of a part; by default about a second's.
        executor: as for `first_hit`; parts are sent ahead as its workers have time for them.
        out: a .npz, .csv, .parquet or .zarr that is to hold the answers, as `conicoid trace` writes them; for
            `occluded`, `lengths` and `line_integral` also .npy. It appears whole or not at all.

        Yields the query's answer for each part; with `out` it returns how many rays there were. Raises what the query
        raises, ImportError for .parquet and .zarr without pyarrow and zarr, OSError for what cannot be read or written.
        """
        from ..parallel.stream import stream

        return stream(self, rays, query, chunk, executor, out, options)

    @ignore_fp_errors
    def lengths(
        self, origins: Any, directions: Any = None, t_min: Any = DEFAULT_T_MIN, t_max: Any = DEFAULT_T_MAX, *,
        by: Literal["body", "material"] = "body", overlaps: Literal["both", "error"] | None = None,
        progress: Progress | None = None, executor: Any = None,
    ) -> FloatArray:  # fmt: skip
        """`spans(...).lengths(by)`, the same to the bit, for any number of rays: their spans are not kept.

        origins, directions, t_min, t_max: as for `first_hit`; in an empty interval, t_min >= t_max, lengths are 0.
        by: "body" for the shape (..., bodies), or "material" for (..., materials), in the order of `scene.materials`.
        overlaps: "both", "error" or None, as for `Spans.lengths`.
        progress: progress(done, count) is called with numbers of rays.
        executor: as for `first_hit`.
        """
        from ..queries import line_integrals, ray_queries

        check_callback("lengths", "progress", progress)
        if _is_remote(executor, origins, directions):
            from ..parallel.queries import dispatch_rays

            found: FloatArray = dispatch_rays(
                self, "lengths", executor, origins, directions, t_min, t_max, by, overlaps, progress
            )
            return found
        rays = ray_queries.as_rays("lengths", origins, directions)
        return line_integrals.lengths(self.prepared, rays, t_min, t_max, by, progress, overlaps)

    @ignore_fp_errors
    def line_integral(
        self,
        values: Any,
        origins: Any,
        directions: Any = None,
        t_min: Any = DEFAULT_T_MIN,
        t_max: Any = DEFAULT_T_MAX,
        *,
        otherwise: Any = None,
        overlaps: Literal["both", "error"] | None = None,
        progress: Progress | None = None,
        executor: Any = None,
    ) -> Any:
        """`spans(...).line_integral(values)`, the same to the bit, for any number of rays: their spans are not kept.

        It is the sum over what each ray goes through of value × length: (...), or (..., energies).

        values: (bodies,) or (bodies, energies); or a mapping from names of materials to numbers or arrays (energies,),
            a name standing for all materials that have it; or the name of a property that materials have.
        origins, directions, t_min, t_max: as for `first_hit`; over an empty interval, t_min >= t_max, it is 0.
        otherwise: stands for materials without such a value, which are a ValueError if it is not given.
        overlaps: "both", "error" or None, as for `Spans.line_integral`.
        progress: progress(done, count) is called with numbers of rays.
        executor: as for `first_hit`.
        """
        from ..queries import line_integrals, ray_queries

        check_callback("line_integral", "progress", progress)
        if _is_remote(executor, origins, directions):
            from ..parallel.queries import dispatch_rays

            more = values, otherwise, overlaps, progress
            return dispatch_rays(self, "line_integral", executor, origins, directions, t_min, t_max, *more)
        rays = ray_queries.rays_after_values(values, origins, directions)
        return line_integrals.line_integral(self.prepared, values, rays, t_min, t_max, otherwise, progress, overlaps)

    @ignore_fp_errors
    def contains(self, points: Any, *, executor: Any = None) -> Any:
        """bool (...): does any solid contain the point? Primitives hold their boundary, Booleans are exact.

        points: (..., 3), finite.
        executor: as for `first_hit`.
        """
        if _is_remote(executor, points):
            from ..parallel.queries import dispatch_points

            return dispatch_points(self, "contains", executor, points)
        from ..queries.points import body_at

        return np.asarray(body_at(self.prepared, points, "contains") >= 0)[()]

    @ignore_fp_errors
    def body_at(self, points: Any, *, executor: Any = None) -> Any:
        """int32 (...): the number of the first listed body that contains the point, or -1.

        points: (..., 3), finite.
        executor: as for `first_hit`.
        """
        if _is_remote(executor, points):
            from ..parallel.queries import dispatch_points

            return dispatch_points(self, "body_at", executor, points)
        from ..queries.points import body_at

        return body_at(self.prepared, points)

    @ignore_fp_errors
    def bodies_at(self, points: Any, *, executor: Any = None) -> BodiesAt:
        """All bodies that contain each point, in their order, as lists one after the other.

        points: (..., 3), finite.
        executor: as for `first_hit`.
        """
        if _is_remote(executor, points):
            from ..parallel.queries import dispatch_points

            found: BodiesAt = dispatch_points(self, "bodies_at", executor, points)
            return found
        from ..queries.points import bodies_at

        return bodies_at(self.prepared, points)

    @ignore_fp_errors
    def distance(
        self, points: Any, *, exact: bool = False, max_distance: Any = math.inf, progress: Progress | None = None,
        executor: Any = None,
    ) -> Distances:  # fmt: skip
        """How far each point is from the nearest wall of any body: negative inside a solid, inf where there is none.

        By default a certified bound: no wall is nearer than that. It is the distance itself for one surface, less
        near edges and where bodies are combined.

        points: (..., 3), finite.
        exact: whether to find the nearest wall itself: its point, normal, body and face, with an error bound.
        max_distance: walls beyond are not looked for, one for all points or one for each; such distances are infinite.
        progress: progress(done, count) is called with numbers of points.
        executor: as for `first_hit`.

        Raises ValueError for points that are not finite and a max_distance that is not positive.
        """
        from ..queries import distances

        check_callback("distance", "progress", progress)
        exact = check_flag("distance", "exact", exact)
        if _is_remote(executor, points):
            from ..parallel.queries import dispatch_distances

            found: Distances = dispatch_distances(self, executor, points, max_distance, exact, progress)
            return found
        return distances.distance(self.prepared, points, max_distance, exact, progress)


def _is_remote(executor: Any, *arrays: Any) -> bool:
    """Is a question for workers, or of rays that are not at hand as a whole?"""
    return executor is not None or any(is_dask_array(a) or hasattr(a, "_share") for a in arrays)


QUERIES: dict[str, str] = {}
"""The name of each query, and of its first argument: "origins", "points" or others."""

for _name, _query in vars(SceneQueries).items():
    if hasattr(_query, "__wrapped__"):
        _query.__wrapped__.__qualname__ = f"Scene.{_name}"  # as Python calls it where an argument is missing
        QUERIES[_name] = _query.__wrapped__.__code__.co_varnames[1]


# Scenes that move: what they are at a time.


@with_method_hints
class SceneAnimation:
    """What scenes with an animation can say."""

    _animation: tuple[Any, ...]
    _bodies: Any

    @property
    def animation(self) -> tuple[Any, ...]:
        """By which tracks bodies, the camera and lights move; queries and pictures see all where the scene has it."""
        return self._animation

    def at(self, time: float) -> Scene:
        """The scene as it stands at a time, without an animation; of bodies it prepares only those that have moved.

        time: in seconds, as the keys of the tracks say.

        Raises KeyError where a track moves a body that there is not, ValueError where it moves a camera or a light
        that the scene has not.
        """
        time, made = check_number("at", "time", time), self._still()
        for track in self._animation:
            if isinstance(track, BodyTrack):
                shape = self._bodies[find_entry(self._bodies, track.body)].shape
                if track.moved(shape, time) is not shape:
                    made = made.moved(track.body, lambda old, track=track: track.moved(old, time))
            elif isinstance(track, CameraTrack):
                if made.camera is None:
                    raise ValueError("at: the scene must have a camera for a CameraTrack to move")
                made = made.replace(camera=track.moved(made.camera, time))
            elif isinstance(track, LightTrack):
                made = made.replace(lights=_lights(made.lights, track, time))
        return made

    def _still(self) -> Scene:
        raise NotImplementedError


def _lights(lights: Any, track: LightTrack, time: float) -> list[Any]:
    """The lights of a scene, one of them where a track has it."""
    if track.light >= len(lights):
        there = format_count(len(lights), "light", "lights")
        raise ValueError(f"at: the scene has {there}, from 0 on; a LightTrack moves light {track.light}")
    return [track.moved(light, time) if k == track.light else light for k, light in enumerate(lights)]


# One ray worked out, and what a surface is: the questions of a scene that are answered in words.


class SceneExplanations:
    """What can be asked about `lowered`, the scene as arrays."""

    @property
    def lowered(self) -> LoweredScene:
        """Built on first use."""
        raise NotImplementedError

    @ignore_fp_errors
    def explain(
        self, origin: Any, direction: Any = None, t_min: float = 0.0, t_max: float = math.inf, *, body: Any = None
    ) -> Explanation:
        """One ray worked out as on a blackboard: what every body does with it, and why.

        origin, direction: (3,) each; or a `Rays` of one ray, which may know the surface that it starts on.
        t_min, t_max: the open interval, as for `first_hit`.
        body: the number or name of the only one to work out; by default all are.

        The numbers are the kernels' own, to the bit; those of the lecture stand beside them, with their source. Print
        it for the text; a notebook shows it with its figure. Raises ValueError for several rays.
        """
        from ..apps.explain.explanation import explain

        return explain(self, origin, direction, t_min, t_max, body)  # type: ignore[arg-type]

    @ignore_fp_errors
    def surface(self, number: Any) -> SceneSurface:
        """The surface of a `number`, as `hits.surface` tells it: its equation, its kind, and whose faces it makes.

        Raises TypeError for what is no integer, IndexError for -1, a miss, and other numbers that there are not.
        """
        from ..apps.explain.scene_surface import surface_of

        index, count = as_index(number), len(self.lowered.tables.surface_kind)
        if index is None:
            raise TypeError(
                f"surface: number must be one integer, got {format_value(number)}; scene.surface(int(k)) for each"
            )
        if not 0 <= index < count:
            miss = "; -1 stands for a miss" if index == -1 else ""
            raise IndexError(f"surface: number must be at least 0 and below {count}, got {index}{miss}")
        return surface_of(self, index)  # type: ignore[arg-type]


# The scene a user holds: bodies, lights, a camera, and the questions it answers.

_PARTS = ("lights", "camera", "background", "domain", "animation")


@with_method_hints
class Scene(SceneContents, SceneEdits, SceneAnimation, SceneQueries, SceneExplanations, metaclass=HintingType):
    """Bodies in listing order (ties go to the first), with lights, a camera and a background.

    items: shapes or `Body`s; one of these alone is a scene too.
    lights: a list of lights, or one; with none, pictures are lit by some that fit.
    camera: a `Camera`, an `OrthographicCamera` or another one; None for one that fits.
    background: a colour, a `Sky` or an `Environment`; None for a pale sky, which lights the scene in light transport.
    domain: a solid that the bodies are to fill: `check` tells where they do not, and nothing else asks for it.
    animation: a list of `BodyTrack`, `CameraTrack` and `LightTrack`, by which `at`, films and shutters go.

    The scene is immutable; its arrays are built when first asked for.
    Every query takes origins and directions (..., 3), or a `Rays` alone, and keeps the leading shape.
    """

    def __init__(
        self,
        items: Shape | Body | Iterable[Shape | Body] = (),
        lights: Any = (),
        camera: Any = None,
        background: Any = None,
        domain: Solid | None = None,
        animation: Any = (),
    ) -> None:
        from ..geometry.entries import (
            as_bodies,
            as_camera,
            as_domain,
            refuse_same_names,
            refuse_second,
            refuse_unknown_tracks,
        )
        from ..geometry.tracks import as_tracks
        from ..materials.background import as_background
        from ..materials.light import as_lights

        refuse_second(lights)
        self._bodies = as_bodies(items)
        refuse_same_names(self._bodies)
        self._lights = as_lights(lights)
        self._camera = as_camera(camera)
        self._background = as_background(background)
        self._domain = as_domain(domain)
        self._animation = as_tracks(animation)
        refuse_unknown_tracks(self._bodies, self._animation)
        for part in (*self._lights, self._camera, self._background):
            frozen_with_hints(type(part))
        self._prepared: PreparedScene | None = None
        self._before: PreparedScene | None = None
        """What a scene was that this one was made from, until this one is prepared too."""
        self._lock = fork_safe_lock()

    if not TYPE_CHECKING:  # else checkers would let any name be asked for, and set

        def __getattr__(self, name: str) -> Any:
            raise scene_attribute_error(self, name)

        def __setattr__(self, name: str, value: Any) -> None:
            if not name.startswith("_") and (type(self) is Scene or hasattr(Scene, name)):
                hint = f": scene.replace({name}=...) is one with another" if name in _PARTS else ""
                raise AttributeError(f"a Scene is read-only, {name[:80]} cannot be set{hint}")
            object.__setattr__(self, name, value)

    def __reduce__(self) -> tuple[Any, ...]:
        return _rebuild_scene, (type(self), *self._parts), {"_notes": self._notes} if self._notes else None

    def __copy__(self) -> Scene:
        made = _rebuild_scene(type(self), *self._parts)
        made._prepared, made._before, made._notes = self._prepared, self._before, self._notes
        return made

    def _edited(self, bodies: Bodies, *parts: Any, before: Scene | None = None) -> Scene:
        """A scene of other bodies, which takes what is prepared of this one, or of another that was before it.

        parts: those after the bodies, where they are others.
        """
        from ..geometry.entries import refuse_unknown_tracks
        from ..geometry.tracks import as_tracks

        *given, animation = parts or self._parts[1:]
        made, of = Scene((), *given), before or self
        made._bodies, made._notes, made._animation = bodies, self._notes, as_tracks(animation)
        refuse_unknown_tracks(bodies, made._animation)
        if bodies is of._bodies and of._prepared is not None:
            made._prepared = of._prepared
        else:
            made._before = of._prepared or of._before
        return made

    def _still(self) -> Scene:
        return self._edited(self._bodies, *self._parts[1:-1], ()) if self._animation else self

    @cached_property
    @ignore_fp_errors
    def extent(self) -> BoxEnds:
        """(low, high) around what is bounded, for cameras; axes without an end are cut to the size of the rest."""
        from ..geometry.entries import boxes_of
        from ..render.auto_camera import fit_extent

        return fit_extent(boxes_of(self._bodies, self._prepared))

    def fitting_camera(self, aspect: float = 4 / 3) -> Camera:
        """The camera of pictures `aspect` times as wide as high, where the scene has none: all bodies are in view."""
        from ..render.auto_camera import fit_camera

        return fit_camera(*self.extent, check_positive("fitting_camera", "aspect", aspect))

    def rays(self, width: int, height: int) -> Rays:
        """The rays of a picture's pixel centres, (height, width): those of the camera, or of the one that fits."""
        from ..render.camera import check_size

        width, height = check_size(width, height)
        return (self.camera or self.fitting_camera(width / height)).rays(width, height)

    @property
    @ignore_fp_errors
    def bounds(self) -> Bounds:
        """(low, high) around all bodies; ±inf where unbounded, (inf, -inf) for an empty scene."""
        from ..geometry.bounds.aabb import enclose_rows
        from ..geometry.entries import boxes_of

        return Bounds(*enclose_rows(boxes_of(self._bodies, self._prepared)))

    @property
    @ignore_fp_errors
    def prepared(self) -> PreparedScene:
        """The lowered scene with its tree, built on first use and shared by all threads."""
        return self._ready()

    @ignore_fp_errors
    def prepare(self, progress: Callable[[int, int], Any] | None = None) -> None:
        """Build the arrays and the tree now; else the first question does it.

        `progress(done, count)` is called with numbers of entries, to each of which every stage of the work adds. What a
        shape becomes is kept with it, so a scene that shares shapes with one that was prepared takes only what is new.
        """
        check_callback("prepare", "progress", progress)
        self._ready(progress)

    def _ready(self, *progress: Any) -> PreparedScene:
        with self._lock:
            if self._prepared is None:
                from .._util.gc_pause import pause_gc
                from ..prepare.prepared_scene import prepare

                before, self._before = [self._before] if self._before else [], None
                with pause_gc():
                    self._prepared = prepare(self._bodies, before, *progress)
            return self._prepared

    @property
    def lowered(self) -> LoweredScene:
        return self.prepared.lowered

    @property
    def geometry(self) -> Any:
        """The arrays that kernels take."""
        return self.prepared.geometry

    @property
    def memory(self) -> Memory:
        """What the prepared scene takes: bytes of its tables and of its tree, and how many primitives there are."""
        from ..prepare.memory import measure_memory

        return measure_memory(self.geometry)

    @ignore_fp_errors
    def render(
        self,
        width: int = 640,
        height: int = 480,
        samples: int | None = None,
        integrator: str = "whitted",
        seed: int = 0,
        *,
        depth: int = 10,
        camera: AnyCamera | None = None,
        filter: Filter = "box",  # noqa: A002
        noise: float | None = None,
        shutter: tuple[float, float] | None = None,
        times: int | None = None,
        layers: bool | str | Iterable[str] = (),
        groups: Mapping[str, Any] | None = None,
        axes: bool = False,
        labels: bool = False,
        normals: bool = False,
        progress: Callable[[int, int], Any] | None = None,
        preview: Callable[[Image], Any] | Literal["terminal"] | bool | None = None,
        executor: Any = None,
        resume: str | os.PathLike[str] | None = None,
    ) -> Image:
        """A picture `width` x `height` pixels large; with a camera and light that fit, where none is given.

        samples: rays for each pixel, 4 if not given; 1 goes through its centre, more are spread over it.
        integrator: "whitted"; "path" or "direct" for light as it travels; "occlusion"; "normals" or "albedo" for the
            normals, or the colours, of what is seen.
        seed: of where in the pixels the rays go; equal seeds give equal pictures.
        depth: how often a ray is reflected or refracted at most.
        camera: in place of the scene's; nothing is prepared anew for it.
        filter: how samples make a pixel: "box", the mean over its square, or "tent", "gaussian", "mitchell",
            "blackman-harris", which reach beyond it.
        noise: of a progressive integrator, the error of brightness at which a square of pixels is done, as it is
            displayed, where 1 is white; `samples` then is a limit, 16,384 if not given.
        shutter: when it opens and closes, in the seconds of the scene's animation: what moves meanwhile is blurred.
        times: in how many moments of that time it is seen, each by as many of the samples; 64 at most if not given.
        layers: names of what else is wanted of each pixel, as `image.layers`, or True for all: "albedo", "normal",
            "depth", "position", "body", "samples", "error".
        groups: name -> a list of bodies that glow, by name, of lights of the scene, and "background": the light of each
            group alone is the layer "light.name", as many samples more.
        axes, labels, normals: drawn over it: the world's axes, names of bodies or numbers, arrows along normals.
        progress: progress(done, count) is called now and then.
        preview: preview(image) is called with a progressive picture as it becomes better, with its error as
            `image.noise`; True shows it in a notebook, "terminal" draws it in one.
        executor: where its tiles are made, as for `first_hit`; the picture is the same to the bit.
        resume: a file of finished tiles, kept up to date: where there are some of this picture, it goes on from them,
            also to more samples where the integrator is progressive.
        """
        from .pictures import render_image

        asked = width, height, samples, integrator, seed, depth, camera, filter, noise, shutter, times
        return render_image(
            self, asked, layers=layers, groups=groups, drawn=dict(axes=axes, labels=labels, normals=normals),
            progress=progress, preview=preview, executor=executor, resume=resume,
        )  # fmt: skip

    @ignore_fp_errors
    def section(
        self, plane: str | OrthographicCamera = "z", at: float | None = None, width: int = 640, height: int = 480,
        samples: int = 4,
    ) -> Image:  # fmt: skip
        """A picture of the section by a plane: the colour of what is there, and lines where materials meet.

        plane: "x", "y" or "z", across which it lies at `at` (0 if not given), in a window that fits; or an
            `OrthographicCamera`, through whose position it goes, across the view.
        width, height: of the picture, in pixels. `samples` for each pixel smooth the edges.

        Clear materials are pale blue, and white is nothing or void. The pattern of a Checker is not drawn. Warns where
        no solid is cut at all.
        """
        from ..apps.section.section_image import section_pixels
        from ..io.images.image import Image

        return Image._of_light(
            section_pixels(self.prepared, self._bodies, self.extent, plane, at, width, height, samples)
        )

    @ignore_fp_errors
    def slice(
        self, origin: Any = "z", u: Any = None, v: Any = None, pixels: Any = 640, *, at: float | None = None,
        progress: Callable[[int, int], Any] | None = None, executor: Any = None,
    ) -> Slice:  # fmt: skip
        """What a plane meets: bodies and materials by pixel, exact outlines of walls, and pictures with a legend.

        origin: a corner of the window, (3,), with u and v; or "x", "y" or "z", across which the plane lies at `at` (0
            if not given), in a window that fits.
        u, v: from that corner, over the whole width and height, at right angles.
        pixels: (width, height), or how many along the longer side.
        progress: progress(done, count) is called with numbers of pixels.
        executor: as for `first_hit`.
        """
        from ..apps.section.slice import cut_scene

        return cut_scene(self, origin, u, v, pixels, at, progress, executor)

    @ignore_fp_errors
    def voxels(
        self, bounds: Any = None, shape: Any = 64, *, fractions: Literal["body", "material"] | None = None,
        samples: int = 4, axis: Literal["x", "y", "z"] = "z", path: str | os.PathLike[str] | None = None,
        progress: Callable[[int, int], Any] | None = None, executor: Any = None,
    ) -> Voxels:  # fmt: skip
        """The scene in equal boxes: what is at their centres, or with `fractions` how much of each is what.

        bounds: (low, high) of all of them; the scene's if not given.
        shape: (nx, ny, nz), or how many along the longest side.
        fractions: "body" or "material": shares of volumes from exact chords, each with a bound on its error.
        samples: so many rays squared go through each column of voxels; the bounds shrink with them.
        axis: along which the rays go: what has the same cross-section all along it is best.
        path: a .zarr folder or .npy file that they are written to as they come, for more than memory holds. The
            arrays of the answer are then those on the disk. It appears whole, or after Ctrl-C not at all.
        progress: progress(done, count) is called with numbers of voxels, or of columns for fractions.
        executor: as for `first_hit`.
        """
        from ..apps.section.voxels import compute_voxels

        return compute_voxels(self, bounds, shape, fractions, samples, axis, path, progress, executor)

    @staticmethod
    def load(
        path: str | os.PathLike[str], *, progress: Callable[[int, int], Any] | None = None, outside: bool = False
    ) -> Scene:
        """The scene in the YAML or JSON file at `path`, as `co.load`, which says more.

        progress: progress(done, count) is called now and then, with shares of the work.
        outside: may pictures of textures lie outside of the file's folder?
        """
        from ..io.scene_file import scene_file

        check_callback("load", "progress", progress)
        parts = scene_file.read_scene(checked_path("load", path), progress, check_flag("load", "outside", outside))
        return Scene(parts.bodies, parts.lights, parts.camera, parts.background, parts.domain, parts.animation)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write a scene file at `path` that `co.load` reads as an equal scene; `co.save` says more."""
        from ..io.scene_file import scene_file

        scene_file.write_scene(self, checked_path("save", path))

    @ignore_fp_errors
    def view(self, height: int = 480) -> Any:
        """A widget to walk around in the scene in a notebook, `height` pixels high.

        Raises ImportError without anywidget (`pip install anywidget`), ValueError for what no browser holds.
        """
        from ..viewer.widget import view

        return view(self, height)

    def _repr_mimebundle_(self, **_: Any) -> Any:
        """In a notebook a scene shows itself: the widget, or a picture without anywidget or where it is too large."""
        try:
            return self.view()._repr_mimebundle_()
        except (ImportError, ValueError):
            from base64 import b64encode

            picture = self.render(480, 360, samples=1)._repr_png_()
            return {"image/png": b64encode(picture).decode(), "text/plain": repr(self)}


def _rebuild_scene(kind: type[Scene], *parts: Any) -> Scene:
    """A scene of the same parts, for pickle and copy: what is prepared, and the lock of that, stay behind."""
    made = kind.__new__(kind)
    Scene.__init__(made, *parts)
    return made


def as_scene(owner: str, scene: Any) -> Scene:
    """A scene, or that of one shape or body; a TypeError otherwise."""
    if isinstance(scene, Scene):
        return scene
    if isinstance(scene, (Shape, Body)):
        return Scene(scene)
    hint = "; co.load(path) reads a scene file" if isinstance(scene, str | os.PathLike) else ""
    hint = "; co.Scene([...]) is one of several" if isinstance(scene, list | tuple) else hint
    raise TypeError(f"{owner}: scene must be a Scene, a shape or a Body, got {describe_kind(scene)}{hint}")
