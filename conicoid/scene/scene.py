"""`Scene`: bodies by name and number, lights, a camera and a background, with queries, pictures and files.

The class is the facade on top of the packages: a method checks little itself and hands over to the package that does
the work, which it imports on first use, so that a program loads only what it calls. A scene is immutable; edits are new
scenes that share prepared tables with the old one.

The file is longer than others, and stays one class. 430 of its lines are the contracts that `help(Scene)` shows, each
beside the method that it binds. Base classes or mixins would give a reader several places to look for one method.
"""

from __future__ import annotations

import dataclasses
import math
import os
from collections.abc import Callable, Iterable, Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal, SupportsIndex, overload

import numpy as np

from .._util.arrays import BoxEnds, FloatArray, ignore_fp_errors
from .._util.process import fork_safe_lock, pause_gc
from .._util.text import NameTuple, format_count, unknown_attribute
from .._util.validation import (
    DEFAULT_T_MAX,
    DEFAULT_T_MIN,
    check_callback,
    check_flag,
    check_number,
    check_path,
    check_positive,
    describe_kind,
    format_value,
    is_dask_array,
    is_on_card,
)
from ..geometry.body import Body
from ..geometry.bounds.aabb import Bounds, enclose_rows
from ..geometry.entries import (
    Bodies,
    apply_motion,
    as_bodies,
    as_domain,
    as_index,
    as_unit,
    boxes_of,
    common_unit,
    exchange_entry,
    find_body,
    find_entry,
    insert_entries,
    one_entry,
    refuse_same_names,
    refuse_unknown_tracks,
    remove_entries,
    replace_entry,
    share_equal_bodies,
)
from ..geometry.instances import InstanceList
from ..geometry.labels import count_bodies, distinct_materials, first_numbers, single_body
from ..geometry.shape import Shape, Solid
from ..materials.light import Background, Light, as_background, as_lights
from ..queries.result import extension

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ..apps.explain.explanation import Explanation, SceneSurface
    from ..apps.section.slice import Slice
    from ..apps.section.voxels import Voxels
    from ..geometry.tracks import Track
    from ..io.image import Image
    from ..kernels.threads import Progress
    from ..prepare.prepared_scene import Memory, PreparedScene
    from ..queries.hits import Hits
    from ..queries.points import BodiesAt, Distances
    from ..queries.rays import Rays
    from ..queries.spans import Crossings, Spans
    from ..queries.weights import LineValues
    from ..render.camera import AnyCamera, Camera, OrthographicCamera
    from ..render.options import Filter


QUERIES = {
    **dict.fromkeys(("first_hit", "occluded", "spans", "crossings", "lengths"), "origins"),
    **dict.fromkeys(("contains", "body_at", "bodies_at", "distance"), "points"),
    "line_integral": "values",
    "stream": "rays",
}
"""Name of each query -> name of its first argument."""

_UNCHANGED: Any = object()
"""Default of the arguments of `Scene.replace`, where None takes a part away."""

_PARTS = ("lights", "camera", "background", "domain", "animation", "unit")


class Scene:
    """Bodies in listing order (ties go to the first), with lights, a camera and a background.

    The scene is immutable. Its arrays are built on first use and shared by all threads. Every query takes origins and
    directions (..., 3), or a `Rays` alone, and keeps the leading shape.

    Parameters
    ----------
    items : iterable of Shape or Body, Shape or Body
        The entries. One shape or body alone is a scene too.
    lights : iterable of lights, or one light
        None listed: pictures use lights that fit.
    camera : Camera, OrthographicCamera or another camera, optional
        None: pictures use `fitting_camera`.
    background : colour, Sky or Environment, optional
        None is a pale sky, which lights the scene in light transport.
    domain : Solid, optional
        The space that the bodies are to fill. Only `check` reads it, and reports where they do not.
    animation : iterable of BodyTrack, CameraTrack and LightTrack
        The motions for `at`, films and shutters.
    unit : {"angstrom", "nm", "um", "mm", "cm", "m", "km", "in"}, optional
        The unit of its lengths. Importers state it, exporters convert from it to the unit of the other program.

    Raises
    ------
    TypeError
        For an item, light, camera, background, domain or track of another type.
    ValueError
        For two bodies of one name, or an unknown unit.
    KeyError
        For a track of an unknown body.
    """

    # --- Construction

    def __init__(
        self,
        items: Shape | Body | Iterable[Shape | Body] = (),
        lights: Any = (),
        camera: AnyCamera | None = None,
        background: Background | None = None,
        domain: Solid | None = None,
        animation: Iterable[Track] = (),
        unit: str | None = None,
    ) -> None:
        self._bodies: Bodies = as_bodies(items)
        refuse_same_names(self._bodies)
        self._lights: tuple[Light, ...] = as_lights(lights)
        self._camera = _as_camera(camera)
        self._background = as_background(background)
        self._domain = as_domain(domain)
        self._animation: tuple[Track, ...] = _as_tracks(animation)
        self._unit = as_unit(unit)
        refuse_unknown_tracks(self._bodies, self._animation)
        self._cached_prepared: PreparedScene | None = None
        self._previous: PreparedScene | None = None
        """The prepared scene that this one was edited from, until this one is prepared too."""
        self._lock = fork_safe_lock()

    _notes: tuple[str, ...] = ()  # of importers, which set them after construction

    if not TYPE_CHECKING:  # else type checkers would accept any attribute, and entries that are set

        def __getattr__(self, name: str) -> Any:
            raise unknown_attribute(self, name)

        def __setattr__(self, name: str, value: Any) -> None:
            if not name.startswith("_") and (type(self) is Scene or hasattr(Scene, name)):
                raise AttributeError(f"a Scene is read-only, {name[:80]} cannot be set; scene.replace makes another")
            object.__setattr__(self, name, value)

    def __reduce__(self) -> tuple[Any, ...]:
        return _rebuild_scene, (type(self), *self._parts), {"_notes": self._notes} if self._notes else None

    def __copy__(self) -> Scene:
        copied = _rebuild_scene(type(self), *self._parts)  # with a lock of its own
        copied._cached_prepared, copied._previous, copied._notes = self._cached_prepared, self._previous, self._notes
        return copied

    # --- Contents

    @property
    def bodies(self) -> Bodies:
        """The entries as listed; those of an imported model are created on access.

        A `Spheres` or `Boxes` is one entry and many bodies, so body numbers go to `body`, not here. Negative indices
        raise IndexError, since -1 is the number of a miss, and so does an index of a result (a NumPy integer) where the
        body of that number belongs to another entry.
        """
        return self._bodies

    @property
    def lights(self) -> tuple[Light, ...]:
        """The lights as listed; without any, pictures use lights that fit."""
        return self._lights

    @property
    def camera(self) -> AnyCamera | None:
        """The camera, or None: then pictures are taken by `fitting_camera(width / height)`.

        `scene.rays(width, height)` are the rays of either; `scene.camera or scene.fitting_camera()` is one in any case.
        """
        return self._camera

    @property
    def background(self) -> Background | None:
        """The light of rays that hit nothing: a colour, a `Sky` or an `Environment`."""
        return self._background

    @property
    def domain(self) -> Solid | None:
        """The space that the bodies are to fill, as the cells of an imported model do; None if not stated."""
        return self._domain

    @property
    def unit(self) -> str | None:
        """The unit of lengths, such as "mm"; None if not stated. `replace(unit="cm")` changes the word, no number."""
        return self._unit

    @property
    def notes(self) -> tuple[str, ...]:
        """The remarks of an importer: the size of the model, and every difference from its file.

        Copies, pickles and `replace` keep them, scene files do not; scenes that differ in them are equal.
        """
        return self._notes

    @property
    def body_count(self) -> int:
        """The number of bodies: one for each entry, N for a `Spheres` of N balls."""
        return int(self._firsts[-1])

    @property
    def materials(self) -> tuple[Any, ...]:
        """The distinct materials, in the order of the first body of each; None is that of bodies without.

        Two materials are distinct if they differ in anything: two of one name, say, in their colour.
        `materials["steel"]` is the one of a name, and `materials.index("steel")` its index. The indices are not numbers
        of bodies: `hits.material` has the materials of these.
        """
        bodies = self._bodies
        listed = bodies.distinct_materials if isinstance(bodies, InstanceList) else distinct_materials(bodies)
        return NameTuple(listed, "scene.materials")

    @property
    @ignore_fp_errors
    def bounds(self) -> Bounds:
        """(low, high) around all bodies; ±inf where unbounded, (inf, -inf) for an empty scene.

        They hold the bodies, and are rounded outward once; around a Boolean solid they may be wider by 10⁻⁹ of its
        size, where `shape.bounds` of the solid is tight.
        """
        return Bounds(*enclose_rows(self._boxes()))

    @cached_property
    @ignore_fp_errors
    def extent(self) -> BoxEnds:
        """(low, high) around the bounded parts, for cameras; infinite axes are cut to the size of the rest."""
        from ..render.camera import fit_extent

        return fit_extent(self._boxes())

    def body(self, number: SupportsIndex) -> Body:
        """Return the body of a number, as in `hits.body` and from `body_at`.

        A ball of a `Spheres` is a `Sphere` of its own, one of `Boxes` a `Box`, with its own material and the name of
        its entry. Numbers go from 0 to `body_count` - 1; others, -1 (a miss) among them, raise IndexError.
        """
        entry, ball = find_body(self._firsts, number)  # `ball`: the index in a `Spheres` or `Boxes`
        return single_body(self._bodies[entry], ball)

    @overload
    def __getitem__(self, name: str | int | np.integer[Any]) -> Body: ...

    @overload
    def __getitem__(self, name: slice) -> tuple[Body, ...]: ...

    def __getitem__(self, name: Any) -> Any:
        """Return the entry of a name, the body of a number, or the bodies of a slice of numbers."""
        if isinstance(name, str):
            return self._bodies[find_entry(self._bodies, name)]
        if isinstance(name, slice):
            return tuple(self.body(number) for number in range(*name.indices(self.body_count)))
        if as_index(name) is None:
            raise TypeError(
                f"Scene: index must be a name, a body's number or a slice of numbers, got {format_value(name)}"
            )
        return self.body(name)

    def __len__(self) -> int:
        """Return `body_count`: `scene[i]` and a loop over the scene go through the bodies."""
        return self.body_count

    def __contains__(self, item: object) -> bool:
        """Return whether an entry has this name, is this `Body`, or has this shape; TypeError for anything else."""
        if isinstance(item, str):
            if isinstance(self._bodies, InstanceList):  # a look-up, without creating bodies
                return self._bodies.number(item) is not None
            return any(item == body.name for body in self._bodies)
        if isinstance(item, Shape):
            return any(item == body.shape for body in self._bodies)
        if isinstance(item, Body):
            return item in self._bodies
        raise TypeError(f"Scene: `in` asks for a name, a shape or a Body, got {describe_kind(item)}")

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Scene):
            return NotImplemented
        return self._parts == other._parts

    __hash__ = None  # type: ignore[assignment]

    def __add__(self, other: object) -> Any:
        if isinstance(other, Shape | Body | list | tuple):
            raise TypeError("Scene: a scene does not change, scene.added(items) is one with more entries")
        if not isinstance(other, Scene):
            return NotImplemented
        raise TypeError("Scene: scenes are put together by a.added(b), which keeps the lights and the camera of a")

    __or__ = __add__

    def __repr__(self) -> str:
        counts = [format_count(self.body_count, "body", "bodies"), format_count(len(self._lights), "light", "lights")]
        if len(self._bodies) != self.body_count:
            counts[0] += f" in {format_count(len(self._bodies), 'entry', 'entries')}"
        counts += [format_count(len(self._notes), "note", "notes")] if self._notes else []
        return f"Scene({', '.join(counts)})"

    @property
    def _parts(self) -> tuple[Any, ...]:
        """The arguments of `Scene` that give an equal one."""
        lit = self._bodies, self._lights, self._camera, self._background
        return *lit, self._domain, self._animation, self._unit

    @cached_property
    def _firsts(self) -> Any:
        """The first body number of each entry, and at the end the number of bodies."""
        if isinstance(self._bodies, InstanceList):  # each entry is one body, and none need be created
            return np.arange(len(self._bodies) + 1)
        return first_numbers(self._bodies)

    def _first_numbers(self) -> Any:
        """Return `_firsts`, for functions of entries that need it only for some arguments."""
        return self._firsts

    def _boxes(self) -> FloatArray:
        """Return boxes around the bodies."""
        return boxes_of(self._bodies, lambda: self._prepared.lowered.boxes, self._cached_prepared is not None)

    # --- Edits: new scenes, which reuse the prepared tables of the old one and prepare only the difference

    def replace(
        self, which: str | int | None = None, item: Shape | Body | None = None, *,
        material: Any = _UNCHANGED, name: Any = _UNCHANGED, lights: Any = _UNCHANGED, camera: Any = _UNCHANGED,
        background: Any = _UNCHANGED, domain: Any = _UNCHANGED, animation: Any = _UNCHANGED,
        unit: Any = _UNCHANGED,
    ) -> Scene:  # fmt: skip
        """Return a scene with one entry changed, or other lights, camera, background, domain, animation or unit.

        Parameters
        ----------
        which : str or int
            The name of the entry, or the number of its body.
        item : Shape or Body
            A shape replaces the shape of the entry and keeps its material and name. A `Body` replaces the whole entry,
            whose name stays if the `Body` has none.
        material, name : optional
            The new material and name of the entry, with or without an item; None removes them.
        lights, camera, background, domain, animation, unit : optional
            As for `Scene`; None removes them.

        Raises
        ------
        KeyError, IndexError
            For an unknown entry.
        """
        labels = {key: new for key, new in dict(material=material, name=name).items() if new is not _UNCHANGED}
        news = lights, camera, background, domain, animation, unit
        parts = (old if new is _UNCHANGED else new for new, old in zip(news, self._parts[1:], strict=True))
        if which is None and item is None and not labels:  # the bodies stay, and with them all tables
            return self._edited(self._bodies, *parts)
        return self._with_entry(*exchange_entry(self._bodies, self._first_numbers, which, item, labels), *parts)

    def moved(self, which: str | int, motion: ArrayLike | Callable[[Shape], Shape]) -> Scene:
        """Return a scene with one entry moved.

        Parameters
        ----------
        which : str or int
            As for `replace`, with the same errors.
        motion : (3,), (4, 4) or callable
            A translation; a matrix, as for `shape.transform`; or a function of the shape that returns the shape in its
            place: ``lambda shape: shape.rotate("z", 30)``.
        """
        entry = one_entry(self._bodies, self._first_numbers, which, "moved")
        old = self._bodies[entry]
        return self._with_entry(entry, old, dataclasses.replace(old, shape=apply_motion(old.shape, motion)))

    def added(self, items: Shape | Body | Iterable[Shape | Body] | Scene, before: str | int | None = None) -> Scene:
        """Return a scene with more entries.

        Parameters
        ----------
        items : iterable of Shape or Body, Shape or Body, or Scene
            The new entries, or a scene of them; its lights and other parts are left out. ValueError is raised for a
            name that another entry has, and for a scene in another unit. A scene without a unit takes that of the
            other one; bodies alone have none.
        before : str or int, optional
            The entry that follows them, as for `replace`; None puts them at the end.
        """
        place = len(self._bodies)
        if before is not None:
            place = one_entry(self._bodies, self._first_numbers, before, "added", "before")
        unit = self._unit
        if isinstance(items, Scene):
            unit = common_unit(self._unit, items._unit)
            items = items._bodies
        bodies = insert_entries(self._bodies, place, as_bodies(items, "added"))
        refuse_same_names(bodies)
        return self._edited(bodies, *self._parts[1:-1], unit)

    def without(self, which: str | int | Iterable[str | int]) -> Scene:
        """Return a scene without some entries; it prepares nothing anew.

        Parameters
        ----------
        which : str or int, or iterable of these
            As for `replace`, with the same errors.
        """
        each = which if isinstance(which, Iterable) and not isinstance(which, str) else [which]
        # A set: several numbers may be bodies of one entry
        entries = {one_entry(self._bodies, self._first_numbers, one, "without") for one in each}
        return self._edited(remove_entries(self._bodies, entries))

    def _edited(self, bodies: Bodies, *parts: Any, before: Scene | None = None) -> Scene:
        """Return a scene of other bodies, which reuses the prepared tables of this one, or of `before`.

        parts: lights, camera, background, domain, animation and unit, if they differ.
        """
        lights, camera, background, domain, animation, unit = parts or self._parts[1:]
        # An empty scene checks the other parts; the bodies are checked already
        scene, source = Scene((), lights, camera, background, domain, unit=unit), before or self
        scene._bodies, scene._notes, scene._animation = bodies, self._notes, _as_tracks(animation)
        refuse_unknown_tracks(bodies, scene._animation)
        # The same bodies have the same tables; other bodies are prepared from the difference, when needed
        if bodies is source._bodies and source._cached_prepared is not None:
            scene._cached_prepared = source._cached_prepared
        else:
            scene._previous = source._cached_prepared or source._previous
        return scene

    def _with_entry(self, entry: int, old: Body, body: Body, *parts: Any) -> Scene:
        """Return the scene with another body for an entry, which is `old`; parts as for `_edited`."""
        bodies = replace_entry(self._bodies, entry, old, body)
        if body.name is not None and body.name != old.name:
            refuse_same_names(bodies)
        scene = self._edited(bodies, *parts)
        # Body numbers stay if the entry keeps its number of bodies
        if "_firsts" in vars(self) and count_bodies(old) == count_bodies(body):
            scene._firsts = self._firsts
        return scene

    def _reuse(self, before: Scene) -> Scene:
        """Return an equal scene that shares equal bodies, and so their prepared tables, with another scene."""
        return self._edited(share_equal_bodies(before.bodies, self._bodies), *self._parts[1:], before=before)

    # --- Animation

    @property
    def animation(self) -> tuple[Track, ...]:
        """The tracks of bodies, camera and lights; queries and pictures see everything where the scene lists it."""
        return self._animation

    def at(self, time: float) -> Scene:
        """Return the scene at a time, without an animation; it prepares only the bodies that have moved.

        Parameters
        ----------
        time : float
            In seconds, like the keys of the tracks.

        Raises
        ------
        KeyError
            If a track moves an unknown body.
        ValueError
            If a track moves a camera or a light that the scene does not have.
        """
        from ..geometry.tracks import follow_tracks

        return follow_tracks(self, check_number("at", "time", time))

    # --- Preparation

    @property
    def _prepared(self) -> PreparedScene:
        """The lowered scene with its tree, built on first use and shared by all threads."""
        return self._cached_prepared or self._ready()

    def prepare(self, progress: Callable[[int, int], Any] | None = None) -> None:
        """Build the arrays and the tree now, rather than on the first query.

        The tables of a shape are kept with it, so a scene that shares shapes with a prepared one builds only the rest.
        progress(done, count) is called with numbers of entries, to which every stage of the work adds.
        """
        check_callback("prepare", "progress", progress)
        self._ready(progress)

    @ignore_fp_errors
    def _ready(self, *progress: Any) -> PreparedScene:
        """Return the prepared scene, built once under the lock; `progress` is that of `prepare`."""
        with self._lock:
            if self._cached_prepared is None:
                from ..prepare.prepared_scene import prepare

                # Held by this list alone, the old scene can give its memory to the new one
                before, self._previous = [self._previous] if self._previous else [], None
                with pause_gc():
                    edited = None
                    if before:  # most programs edit no scene, and these modules are a tenth of a start
                        from ..prepare.edits.scene_edit import prepare_edit

                        edited = prepare_edit(before, self._bodies, *progress)
                    self._cached_prepared = edited or prepare(self._bodies, *progress)
            return self._cached_prepared

    @ignore_fp_errors
    def _close_gaps(self) -> None:
        """Prepare the scene afresh where edits of an imported model have left unused rows.

        For those that go through all rows of the tables; numbers and answers stay.
        """
        if self._prepared.has_gaps:
            from ..prepare.prepared_scene import prepare

            with self._lock:
                self._cached_prepared = prepare(self._bodies)

    @property
    def memory(self) -> Memory:
        """The size of the prepared scene: bytes of its tables and of its tree, and the number of primitives."""
        from ..prepare.prepared_scene import measure_memory

        return measure_memory(self._prepared)

    # --- Queries along rays

    def first_hit(
        self, origins: ArrayLike | Rays, directions: ArrayLike | None = None, t_min: ArrayLike = DEFAULT_T_MIN,
        t_max: ArrayLike = DEFAULT_T_MAX, *,
        executor: Any = None, device: Literal["cpu", "cuda"] | None = None,
    ) -> Hits:  # fmt: skip
        """Return the nearest crossing of each ray in the open interval (t_min, t_max).

        Parameters
        ----------
        origins, directions : (..., 3)
            They broadcast; or a `Rays` alone. Directions have any length but 0. Dask arrays in place of NumPy's give
            lazy results, Dask arrays too. Arrays on a GPU give arrays there (page "On a GPU").
        t_min, t_max : float or (...)
            The interval, for all rays or for each, in units of the length of the direction. It is empty, and nothing is
            hit, where t_min is not below t_max. Default: 0 and infinity, or the limits of a scan, `co.Rays.from_scan`.
        executor : optional
            An executor, a Dask client or a `co.parallel.Workers` that computes parts, with the same bits. The other
            queries take it as well.
        device : {"cpu", "cuda"}, optional
            What answers, with the same bits: the processor, or a GPU of NVIDIA's (page "On a GPU"). Default: that of
            `co.set_device`. All queries of rays, `contains` and `body_at` take it.

        Returns
        -------
        Hits
            Of the leading shape of the rays; misses have t = inf and body -1. Rays on a GPU give `DeviceHits`, and the
            other queries `DeviceSpans`, `DeviceCrossings`, `DeviceDistances` or arrays there (page "On a GPU").

        Raises
        ------
        ValueError
            For invalid rays, with the index of the first.
        ImportError, RuntimeError, MemoryError
            If a device is missing or too small.
        TypeError
            For a device beside an executor.
        """
        return self._along_rays("first_hit", executor, device, origins, directions, t_min, t_max)

    def occluded(
        self, origins: ArrayLike | Rays, directions: ArrayLike | None = None, t_min: ArrayLike = DEFAULT_T_MIN,
        t_max: ArrayLike = DEFAULT_T_MAX, *,
        executor: Any = None, device: Literal["cpu", "cuda"] | None = None,
    ) -> Any:  # fmt: skip
        """Return whether each ray has any crossing strictly between t_min and t_max: first_hit(...).t < inf.

        Parameters
        ----------
        origins, directions, t_min, t_max, executor, device
            As for `first_hit`. An empty interval, t_min >= t_max, has no crossing.

        Returns
        -------
        bool (...)
        """
        return self._along_rays("occluded", executor, device, origins, directions, t_min, t_max)

    def spans(
        self, origins: ArrayLike | Rays, directions: ArrayLike | None = None, t_min: ArrayLike = DEFAULT_T_MIN,
        t_max: ArrayLike = DEFAULT_T_MAX, *,
        executor: Any = None, device: Literal["cpu", "cuda"] | None = None,
    ) -> Spans:  # fmt: skip
        """Return every stretch of each ray inside each solid, clipped to [t_min, t_max], sorted along the ray.

        Parameters
        ----------
        origins, directions, t_min, t_max, executor, device
            As for `first_hit`. An empty interval, t_min >= t_max, has no spans.
        """
        return self._along_rays("spans", executor, device, origins, directions, t_min, t_max)

    def crossings(
        self, origins: ArrayLike | Rays, directions: ArrayLike | None = None, t_min: ArrayLike = DEFAULT_T_MIN,
        t_max: ArrayLike = DEFAULT_T_MAX, *,
        executor: Any = None, device: Literal["cpu", "cuda"] | None = None,
    ) -> Crossings:  # fmt: skip
        """Return every crossing of each ray with solids and sheets, strictly between t_min and t_max, in order.

        Parameters
        ----------
        origins, directions, t_min, t_max, executor, device
            As for `first_hit`. An empty interval, t_min >= t_max, has no crossings.
        """
        return self._along_rays("crossings", executor, device, origins, directions, t_min, t_max)

    @ignore_fp_errors
    def stream(
        self, rays: Any, query: str = "first_hit", *, chunk: int | None = None, executor: Any = None,
        out: str | os.PathLike[str] | None = None, **options: Any,
    ) -> Any:  # fmt: skip
        """Answer a query for any number of rays, part by part and in order, keeping neither rays nor results.

        Parameters
        ----------
        rays : Rays, array (n, 6), pair of arrays, iterable or path
            `Rays`, also those of `Rays.from_camera` or `from_scan`; (origins, directions), or one array of both, which
            may be an `np.memmap`, a zarr array or another that can be sliced; an iterable of such parts; or a file of
            rays, .npy, .npz, .csv, .parquet or .zarr, which is read part by part.
        query : str
            The name of a query of rays.
        chunk : int, optional
            Rays in a part. Default: as many as take about a second.
        executor : optional
            As for `first_hit`. Parts are sent ahead as its workers become free.
        out : path, optional
            A .npz, .csv, .parquet or .zarr file for the results, as `conicoid trace` writes it; for `occluded`,
            `lengths` and `line_integral` also .npy. It appears whole or not at all.
        **options
            Other arguments of the query, such as `t_max` or `values`, for all rays.

        Returns
        -------
        iterator or int
            The result for each part; with `out` the number of rays.

        Raises
        ------
        ImportError
            For .parquet and .zarr without pyarrow and zarr.
        OSError
            For a file that cannot be read or written. The errors of the query are raised as well.
        """
        from ..parallel.result_writer import stream

        return stream(self, rays, query, chunk, executor, out, options)

    def lengths(
        self, origins: ArrayLike | Rays, directions: ArrayLike | None = None, t_min: ArrayLike = DEFAULT_T_MIN,
        t_max: ArrayLike = DEFAULT_T_MAX, *,
        by: Literal["body", "material"] = "body", overlaps: Literal["both", "error"] | None = None,
        progress: Progress | None = None, executor: Any = None,
        device: Literal["cpu", "cuda"] | None = None,
    ) -> FloatArray:  # fmt: skip
        """Return `spans(...).lengths(by)`, equal to the bit, for any number of rays: their spans are not kept.

        Parameters
        ----------
        origins, directions, t_min, t_max, executor, device
            As for `first_hit`. In an empty interval, t_min >= t_max, lengths are 0.
        by : {"body", "material"}
            The last axis of the result; materials are in the order of `scene.materials`.
        overlaps : {"both", "error"}, optional
            As for `Spans.lengths`.
        progress : callable, optional
            progress(done, count) is called with numbers of rays.

        Returns
        -------
        float64 (..., bodies) or (..., materials)
        """
        return self._along_many_rays(
            "lengths", executor, device, origins, directions, t_min, t_max, progress, by=by, overlaps=overlaps
        )

    def line_integral(
        self, values: LineValues, origins: ArrayLike | Rays, directions: ArrayLike | None = None,
        t_min: ArrayLike = DEFAULT_T_MIN, t_max: ArrayLike = DEFAULT_T_MAX, *, otherwise: ArrayLike | None = None,
        overlaps: Literal["both", "error"] | None = None,
        progress: Progress | None = None, executor: Any = None,
        device: Literal["cpu", "cuda"] | None = None,
    ) -> Any:  # fmt: skip
        """Return `spans(...).line_integral(values)`, equal to the bit, for any number of rays without their spans.

        It is the sum of value × length over everything that a ray passes through.

        Parameters
        ----------
        values : (bodies,), (bodies, energies), mapping or str
            Of each body; or from names of materials to numbers or arrays (energies,), a name standing for all materials
            that have it; or the name of a property of materials.
        origins, directions, t_min, t_max, executor, device
            As for `first_hit`. Over an empty interval, t_min >= t_max, it is 0.
        otherwise : optional
            The value of materials without one. Default: such materials raise ValueError.
        overlaps : {"both", "error"}, optional
            As for `Spans.line_integral`.
        progress : callable, optional
            progress(done, count) is called with numbers of rays.

        Returns
        -------
        float64 (...) or (..., energies)
        """
        options = dict(values=values, otherwise=otherwise, overlaps=overlaps)
        rays = origins, directions, t_min, t_max
        return self._along_many_rays("line_integral", executor, device, *rays, progress, **options)

    def _along_rays(self, query: str, executor: Any, device: str | None, *rays: Any) -> Any:
        """Answer a query of rays: origins, directions, t_min and t_max."""
        answer = self._answer_single(query, executor, rays) if device is None else None
        return self._along_many_rays(query, executor, device, *rays) if answer is None else answer

    def _answer_single(self, query: str, executor: Any, numbers: tuple[Any, ...]) -> Any:
        """Return the answer for one ray or point of plain numbers; None where the query itself must answer."""
        prepared = self._cached_prepared
        if prepared is None or executor is not None:
            return None
        answer = prepared.single_calls.get(query)
        return None if answer is None else answer(prepared, *numbers)

    @ignore_fp_errors
    def _along_many_rays(
        self, query: str, executor: Any, device: str | None, origins: Any, directions: Any, t_min: Any, t_max: Any,
        progress: Progress | None = None, **options: Any,
    ) -> Any:  # fmt: skip
        """Answer a query of rays here, on a device, or by workers; `options` are arguments beyond rays and interval."""
        check_callback(query, "progress", progress)
        if is_on_card(origins) or is_on_card(directions):
            from ..queries import device_results

            given = origins, directions, t_min, t_max
            return device_results.query_rays(self._prepared, query, executor, device, *given, progress, options)
        if _is_remote(executor, origins, directions):
            _refuse_device(query, device)
            from ..parallel.queries import dispatch_rays

            return dispatch_rays(self, query, executor, origins, directions, t_min, t_max, progress, **options)
        if options:  # sums of spans
            from ..queries import line_integrals

            given = origins, directions, t_min, t_max
            return line_integrals.answer(self._prepared, query, *given, progress, options, device)
        from ..queries import ray_queries

        if query == "first_hit" and device is None:
            hits = ray_queries.first_hit_of_arrays(self._prepared, origins, directions, t_min, t_max)
            if hits is not None:
                return hits
        answer, rays = getattr(ray_queries, query), ray_queries.as_rays(query, origins, directions, query != "occluded")
        if device is None:
            return answer(self._prepared, rays, t_min, t_max)
        return answer(self._prepared, rays, t_min, t_max, device)

    # --- Queries at points

    def contains(self, points: ArrayLike, *, executor: Any = None, device: Literal["cpu", "cuda"] | None = None) -> Any:
        """Return whether any solid contains each point. Primitives contain their boundary, Booleans are exact.

        Parameters
        ----------
        points : (..., 3)
            Finite.
        executor, device : optional
            As for `first_hit`.

        Returns
        -------
        bool (...)
        """
        return self._at_points("contains", executor, points, device)

    def body_at(self, points: ArrayLike, *, executor: Any = None, device: Literal["cpu", "cuda"] | None = None) -> Any:
        """Return the number of the first listed body that contains each point, or -1: int32 (...).

        Parameters
        ----------
        points, executor, device
            As for `contains`.
        """
        return self._at_points("body_at", executor, points, device)

    def bodies_at(self, points: ArrayLike, *, executor: Any = None) -> BodiesAt:
        """Return all bodies that contain each point, in listing order, as one list after the other.

        Parameters
        ----------
        points, executor
            As for `contains`.
        """
        return self._at_points("bodies_at", executor, points)

    def _at_points(self, query: str, executor: Any, points: Any, device: str | None = None) -> Any:
        """Answer a query of points."""
        answer = self._answer_single(query, executor, (points,)) if device is None else None
        return self._at_many_points(query, executor, points, device) if answer is None else answer

    @ignore_fp_errors
    def _at_many_points(self, query: str, executor: Any, points: Any, device: str | None) -> Any:
        """Answer a query of points here, on a device, or by workers."""
        if is_on_card(points):
            from ..queries import device_results

            return device_results.query_points(self._prepared, query, executor, device, points)
        if _is_remote(executor, points):
            _refuse_device(query, device)
            from ..parallel.queries import dispatch_points

            return dispatch_points(self, query, executor, points)
        from ..queries import points as point_queries

        answer = getattr(point_queries, query)
        return answer(self._prepared, points) if device is None else answer(self._prepared, points, device=device)

    def distance(
        self, points: ArrayLike, *, exact: bool = False, max_distance: ArrayLike = math.inf,
        progress: Progress | None = None, executor: Any = None,
    ) -> Distances:  # fmt: skip
        """Return the distance of each point to the nearest wall of any body: negative inside a solid, inf without one.

        By default it is a certified bound: no wall is nearer. It equals the distance for one surface, and is less near
        edges and where bodies are combined.

        Parameters
        ----------
        points, executor
            As for `contains`.
        exact : bool
            Find the nearest wall itself: its point, normal, body and face, with an error bound.
        max_distance : float or (...)
            Walls beyond are not searched; such distances are infinite.
        progress : callable, optional
            progress(done, count) is called with numbers of points.

        Raises
        ------
        ValueError
            For points that are not finite, and a max_distance that is not positive.
        """
        if exact is False and progress is None and max_distance is math.inf:
            bound: Distances | None = self._answer_single("distance", executor, (points,))
            if bound is not None:
                return bound
        return self._distance_of_many(points, exact, max_distance, progress, executor)

    @ignore_fp_errors
    def _distance_of_many(
        self, points: Any, exact: bool, max_distance: Any, progress: Progress | None, executor: Any
    ) -> Distances:
        """Answer `distance` here, or by workers."""
        from ..queries import points as distances

        check_callback("distance", "progress", progress)
        exact = check_flag("distance", "exact", exact)
        if is_on_card(points):
            from ..queries import device_results

            given = points, max_distance, exact, progress
            return device_results.query_distances(self._prepared, executor, *given)  # type: ignore[return-value]
        if _is_remote(executor, points):
            from ..parallel.queries import dispatch_distances

            return dispatch_distances(self, executor, points, max_distance, exact, progress)
        return distances.distance(self._prepared, points, max_distance, exact, progress)

    # --- Explanations

    @ignore_fp_errors
    def explain(
        self, origin: ArrayLike | Rays, direction: ArrayLike | None = None, t_min: float = 0.0, t_max: float = math.inf,
        *, body: int | str | None = None,
    ) -> Explanation:  # fmt: skip
        """Explain one ray as on a blackboard: the steps by which every body is hit or missed.

        The numbers are those of the kernels, to the bit; those of the lecture stand beside them, with their source.
        Print the result for the text; a notebook shows it with its figure.

        Parameters
        ----------
        origin, direction : (3,)
            Or a `Rays` of one ray, which may know the surface that it starts on.
        t_min, t_max : float
            The open interval, as for `first_hit`.
        body : int or str, optional
            The number or name of the only body to explain. Default: all.

        Raises
        ------
        ValueError
            For several rays.
        """
        from ..apps.explain.explanation import explain

        return explain(self, origin, direction, t_min, t_max, body)

    @ignore_fp_errors
    def surface(self, number: SupportsIndex) -> SceneSurface:
        """Return the surface of a number, as in `hits.surface`: its equation, its kind, and the faces that it makes.

        Numbers go from 0 to the number of surfaces - 1. TypeError is raised for anything but an integer, IndexError for
        other numbers, -1 (a miss) among them.
        """
        from ..apps.explain.explanation import surface_of

        return surface_of(self, number)

    # --- Pictures

    def fitting_camera(self, aspect: float = 4 / 3) -> Camera:
        """Return the camera of pictures of a scene without one: all bodies are in view.

        aspect: the width of the picture over its height.
        """
        from ..render.camera import fit_camera

        return fit_camera(*self.extent, check_positive("fitting_camera", "aspect", aspect))

    def rays(self, width: int, height: int) -> Rays:
        """Return the rays of pixel centres (height, width), from the camera of the scene or else the one that fits."""
        from ..render.options import check_size

        width, height = check_size(width, height)
        return (self.camera or self.fitting_camera(width / height)).rays(width, height)

    @ignore_fp_errors
    def render(
        self, width: int = 640, height: int = 480, samples: int | None = None, integrator: str = "whitted",
        seed: int = 0, *, depth: int = 10, camera: AnyCamera | None = None,
        filter: Filter = "box",  # noqa: A002
        noise: float | None = None, shutter: tuple[float, float] | None = None, times: int | None = None,
        layers: bool | str | Iterable[str] = (), groups: Mapping[str, Any] | None = None,
        axes: bool = False, labels: bool = False, normals: bool = False,
        progress: Callable[[int, int], Any] | None = None,
        preview: Callable[[Image], Any] | Literal["terminal"] | bool | None = None,
        executor: Any = None, resume: str | os.PathLike[str] | None = None,
        device: Literal["cpu", "cuda"] | None = None,
    ) -> Image:  # fmt: skip
        """Return a picture of `width` x `height` pixels; a camera and lights that fit replace missing ones.

        Parameters
        ----------
        width, height : int
            In pixels.
        samples : int, optional
            Rays for each pixel, by default 4; 1 goes through its centre, more are spread over it.
        integrator : str
            "whitted"; "path" or "direct" for light transport; "occlusion"; "normals" or "albedo" for the normals, or
            the colours, of visible surfaces.
        seed : int
            Of the positions of rays in pixels. Equal seeds give equal pictures.
        depth : int
            The largest number of reflections and refractions of a ray.
        camera : AnyCamera, optional
            In place of the camera of the scene. It needs no preparation.
        filter : str
            Weights of samples: "box", the mean over a pixel, or "tent", "gaussian", "mitchell", "blackman-harris",
            which reach beyond it.
        noise : float, optional
            Of a progressive integrator: the error of displayed brightness (1 is white) at which a square of pixels
            gets no more samples; `samples` then is a limit, by default 16,384.
        shutter : (float, float), optional
            The times of its opening and closing, in seconds of the animation. Motion between them is blurred.
        times : int, optional
            The number of moments of the shutter interval, each with as many of the samples. Default: at most 64.
        layers : bool, str or iterable of str
            Further outputs of each pixel, as `image.layers`; True for all: "albedo", "normal", "depth", "position",
            "body", "samples", "error".
        groups : mapping, optional
            From a name to a list of names of glowing bodies, of lights of the scene, and "background". The light of
            each group alone is the layer "light.name", which takes as many samples again.
        axes, labels, normals : bool
            Draw the axes of the world, names or numbers of bodies, arrows along normals.
        progress : callable, optional
            progress(done, count) is called from time to time.
        preview : callable, bool or "terminal", optional
            preview(image) is called with a progressive picture as it improves, its error being `image.noise`; True
            shows it in a notebook, "terminal" draws it in one.
        executor : optional
            Computes the tiles, as for `first_hit`; the picture is equal to the bit.
        resume : path, optional
            A file of finished tiles, kept up to date. If it has tiles of this picture, the work continues from them,
            also to more samples if the integrator is progressive.
        device : {"cpu", "cuda"}, optional
            Where rays are traced, as for `first_hit`; the picture is equal to the bit.
        """
        from .pictures import render_image

        if executor is not None:
            _refuse_device("render", device)
        options = width, height, samples, integrator, seed, depth, camera, filter, noise, shutter, times
        return render_image(
            self, options, layers=layers, groups=groups, drawn=dict(axes=axes, labels=labels, normals=normals),
            progress=progress, preview=preview, executor=executor, resume=resume, device=device,
        )  # fmt: skip

    @ignore_fp_errors
    def section(
        self, plane: str | OrthographicCamera = "z", at: float | None = None, width: int = 640, height: int = 480,
        samples: int = 4,
    ) -> Image:  # fmt: skip
        """Return a picture of the section by a plane: colours of the bodies there, and lines where materials meet.

        Clear materials are pale blue; nothing and void are white. The pattern of a Checker is not drawn. Warns if the
        plane cuts no solid.

        Parameters
        ----------
        plane : {"x", "y", "z"} or OrthographicCamera
            The axis across which the plane lies, in a window that fits; or a camera, whose plane contains its position
            and lies across its view.
        at : float, optional
            The coordinate of the plane along that axis, by default 0.
        width, height : int
            Of the picture, in pixels.
        samples : int
            For each pixel; they smooth the edges.
        """
        from ..apps.section.section_image import section_pixels
        from ..io.image import Image

        return Image._of_light(
            section_pixels(self._prepared, self._bodies, self.extent, plane, at, width, height, samples)
        )

    @ignore_fp_errors
    def slice(
        self, plane: str | None = None, at: float | None = None, *, origin: ArrayLike | None = None,
        u: ArrayLike | None = None, v: ArrayLike | None = None, pixels: int | tuple[int, int] = 640,
        progress: Callable[[int, int], Any] | None = None, executor: Any = None,
    ) -> Slice:  # fmt: skip
        """Return a plane's bodies and materials by pixel, exact outlines of walls, and pictures with a legend.

        `scene.slice("y", 0.5)` is the plane y = 0.5 in a window that fits, as `scene.section("y", 0.5)` pictures it.

        Parameters
        ----------
        plane : {"x", "y", "z"}, optional
            The axis across which the plane lies; "z" unless there is an origin.
        at : float, optional
            The coordinate of the plane along the axis; 0 by default.
        origin, u, v : (3,), optional
            In place of the axis: a corner of the window, and its two sides, at right angles.
        pixels : int or (int, int)
            (width, height), or the number along the longer side.
        progress : callable, optional
            progress(done, count) is called with numbers of pixels.
        executor : optional
            As for `first_hit`.

        Raises
        ------
        ValueError
            For another axis, and for sides that are zero, oblique or incomplete.
        """
        from ..apps.section.slice import cut_scene

        return cut_scene(self, plane, at, (origin, u, v), pixels, progress, executor)

    @ignore_fp_errors
    def voxels(
        self, bounds: ArrayLike | None = None, shape: int | tuple[int, int, int] = 64, *,
        fractions: Literal["body", "material"] | None = None, samples: int = 4, axis: Literal["x", "y", "z"] = "z",
        path: str | os.PathLike[str] | None = None, progress: Callable[[int, int], Any] | None = None,
        executor: Any = None,
    ) -> Voxels:  # fmt: skip
        """Return the scene in equal boxes: the bodies at their centres, or fractions of their volumes.

        Parameters
        ----------
        bounds : (low, high), optional
            Of all boxes together. Default: of the scene.
        shape : int or (int, int, int)
            (nx, ny, nz), or the number along the longest side.
        fractions : {"body", "material"}, optional
            Compute shares of volumes from exact chords, each with an error bound.
        samples : int
            The square of it is the number of rays through each column of voxels; error bounds shrink with it.
        axis : {"x", "y", "z"}
            The direction of the rays. One along which the cross-section is constant is best.
        path : path, optional
            A .zarr folder or .npy file to write parts to as they come, for more than memory holds. The arrays of the
            result are then those on the disk. The file appears whole, or after Ctrl-C not at all.
        progress : callable, optional
            progress(done, count) is called with numbers of voxels, or of columns for fractions.
        executor : optional
            As for `first_hit`.
        """
        from ..apps.section.voxels import compute_voxels

        return compute_voxels(self, bounds, shape, fractions, samples, axis, path, progress, executor)

    # --- Files and notebooks

    @staticmethod
    def load(
        path: str | os.PathLike[str], *, progress: Callable[[int, int], Any] | None = None, outside: bool = False
    ) -> Scene:
        """Return the scene in a YAML or JSON file; `co.load` documents more, and reads other formats as well.

        Parameters
        ----------
        path : path
            The file.
        progress : callable, optional
            progress(done, count) is called from time to time, with shares of the work.
        outside : bool
            Allow pictures of textures outside of the folder of the file.
        """
        from ..io.scene_file import scene_file

        check_callback("load", "progress", progress)
        parts = scene_file.read_scene(check_path("load", path), progress, check_flag("load", "outside", outside))
        return Scene(
            parts.bodies, parts.lights, parts.camera, parts.background, parts.domain, parts.animation, parts.unit
        )

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write a scene file at `path` that `co.load` reads as an equal scene; `co.save` documents more."""
        from ..io.scene_file import scene_file

        scene_file.write_scene(self, check_path("save", path))

    @ignore_fp_errors
    def view(self, height: int = 480) -> Any:
        """Return a widget, `height` pixels high, to walk around in the scene in a notebook.

        ImportError is raised without anywidget (`pip install 'conicoid[notebook]'`), ValueError for a scene that is too
        large for a browser.
        """
        return extension("view")(self, height)

    def _repr_mimebundle_(self, **_: Any) -> Any:
        """Return the view for a notebook: the widget, or a picture without anywidget or of too large a scene."""
        try:
            return self.view()._repr_mimebundle_()
        except (ImportError, ValueError):
            from base64 import b64encode

            picture = self.render(480, 360, samples=1)._repr_png_()
            return {"image/png": b64encode(picture).decode(), "text/plain": repr(self)}


def as_scene(owner: str, scene: Any) -> Scene:
    """Return a scene, or the scene of one shape or body; raise TypeError for anything else."""
    if isinstance(scene, Scene):
        return scene
    if isinstance(scene, (Shape, Body)):
        return Scene(scene)
    raise TypeError(f"{owner}: scene must be a Scene, a shape or a Body, got {describe_kind(scene)}")


def _rebuild_scene(kind: type[Scene], *parts: Any) -> Scene:
    """Return a scene of the same parts, for pickle and copy, without prepared tables and their lock."""
    scene = kind.__new__(kind)
    Scene.__init__(scene, *parts)
    return scene


def _as_tracks(animation: Any) -> tuple[Track, ...]:
    """Return the checked tracks of an animation."""
    if animation == ():
        return ()
    from ..geometry.tracks import as_tracks

    return as_tracks(animation)


def _as_camera(camera: Any) -> AnyCamera | None:
    """Return a camera, or None; raise TypeError for anything else."""
    if camera is None:
        return None
    from ..render.camera import as_camera

    return as_camera("Scene", camera)


def _refuse_device(query: str, device: str | None) -> None:
    """Raise TypeError for a device beside an executor or lazy arrays."""
    if device is not None:
        raise TypeError(f"{query}: device must be left out where workers compute (docs/gpu.md)")


def _is_remote(executor: Any, *arrays: Any) -> bool:
    """Return whether workers answer a query, or its rays or points are lazy."""
    return executor is not None or any(is_dask_array(a) or hasattr(type(a), "_share") for a in arrays)
