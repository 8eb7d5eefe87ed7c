"""The scene a user holds: bodies, lights, a camera, and the questions it answers."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

from .forks import lock
from .scene_animation import Moving
from .scene_contents import Contents
from .scene_edits import Edits
from .scene_explained import Explained
from .scene_queries import Queries
from .shapes.base import Shape, Solid
from .shapes.body import Body
from .shapes.bounds import Bounds
from .shapes.calls import explained_methods
from .shapes.calm import calm
from .shapes.elsewhere import Told, no_attribute_of_scene
from .shapes.fixed import fixed
from .shapes.validate import callback, flag, positive, what
from .shapes.validate import path as checked_path
from .shapes.vector import Box

if TYPE_CHECKING:
    from .engine.answers.rays import Rays
    from .engine.lowering import Lowered
    from .engine.memory import Memory
    from .engine.prepared import Prepared
    from .film.names import Filter
    from .image import Image
    from .render.camera import AnyCamera, Camera, OrthographicCamera
    from .scene_parts import Bodies
    from .slices.slice import Slice
    from .slices.voxels import Voxels

_PARTS = ("lights", "camera", "background", "domain", "animation")


@explained_methods
class Scene(Contents, Edits, Moving, Queries, Explained, metaclass=Told):
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
        from .scene_parts import (
            as_bodies,
            as_camera,
            as_domain,
            refuse_same_names,
            refuse_second,
            refuse_unknown_tracks,
        )
        from .shapes.animation import as_animation
        from .shapes.background import as_background
        from .shapes.light import as_lights

        refuse_second(lights)
        self._bodies = as_bodies(items)
        refuse_same_names(self._bodies)
        self._lights = as_lights(lights)
        self._camera = as_camera(camera)
        self._background = as_background(background)
        self._domain = as_domain(domain)
        self._animation = as_animation(animation)
        refuse_unknown_tracks(self._bodies, self._animation)
        for part in (*self._lights, self._camera, self._background):
            fixed(type(part))
        self._prepared: Prepared | None = None
        self._before: Prepared | None = None
        """What a scene was that this one was made from, until this one is prepared too."""
        self._lock = lock()

    if not TYPE_CHECKING:  # else checkers would let any name be asked for, and set

        def __getattr__(self, name: str) -> Any:
            raise no_attribute_of_scene(self, name)

        def __setattr__(self, name: str, value: Any) -> None:
            if not name.startswith("_") and (type(self) is Scene or hasattr(Scene, name)):
                hint = f": scene.replace({name}=...) is one with another" if name in _PARTS else ""
                raise AttributeError(f"a Scene is read-only, {name[:80]} cannot be set{hint}")
            object.__setattr__(self, name, value)

    def __reduce__(self) -> tuple[Any, ...]:
        return _again, (type(self), *self._parts), {"_notes": self._notes} if self._notes else None

    def __copy__(self) -> Scene:
        made = _again(type(self), *self._parts)
        made._prepared, made._before, made._notes = self._prepared, self._before, self._notes
        return made

    def _edited(self, bodies: Bodies, *parts: Any, before: Scene | None = None) -> Scene:
        """A scene of other bodies, which takes what is prepared of this one, or of another that was before it.

        parts: those after the bodies, where they are others.
        """
        from .scene_parts import refuse_unknown_tracks
        from .shapes.animation import as_animation

        *given, animation = parts or self._parts[1:]
        made, of = Scene((), *given), before or self
        made._bodies, made._notes, made._animation = bodies, self._notes, as_animation(animation)
        refuse_unknown_tracks(bodies, made._animation)
        if bodies is of._bodies and of._prepared is not None:
            made._prepared = of._prepared
        else:
            made._before = of._prepared or of._before
        return made

    def _still(self) -> Scene:
        return self._edited(self._bodies, *self._parts[1:-1], ()) if self._animation else self

    @cached_property
    @calm
    def extent(self) -> Box:
        """(low, high) around what is bounded, for cameras; axes without an end are cut to the size of the rest."""
        from .render.fit import extent
        from .scene_parts import boxes_of

        return extent(boxes_of(self._bodies, self._prepared))

    def fitting_camera(self, aspect: float = 4 / 3) -> Camera:
        """The camera of pictures `aspect` times as wide as high, where the scene has none: all bodies are in view."""
        from .render.fit import fitting_camera

        return fitting_camera(*self.extent, positive("fitting_camera", "aspect", aspect))

    def rays(self, width: int, height: int) -> Rays:
        """The rays of a picture's pixel centres, (height, width): those of the camera, or of the one that fits."""
        from .render.camera import checked_size

        width, height = checked_size(width, height)
        return (self.camera or self.fitting_camera(width / height)).rays(width, height)

    @property
    @calm
    def bounds(self) -> Bounds:
        """(low, high) around all bodies; ±inf where unbounded, (inf, -inf) for an empty scene."""
        from .scene_parts import boxes_of
        from .shapes.boxes import around_rows

        return Bounds(*around_rows(boxes_of(self._bodies, self._prepared)))

    @property
    @calm
    def prepared(self) -> Prepared:
        """The lowered scene with its tree, built on first use and shared by all threads."""
        return self._ready()

    @calm
    def prepare(self, progress: Callable[[int, int], Any] | None = None) -> None:
        """Build the arrays and the tree now; else the first question does it.

        `progress(done, count)` is called with numbers of entries, to each of which every stage of the work adds. What a
        shape becomes is kept with it, so a scene that shares shapes with one that was prepared takes only what is new.
        """
        callback("prepare", "progress", progress)
        self._ready(progress)

    def _ready(self, *progress: Any) -> Prepared:
        with self._lock:
            if self._prepared is None:
                from .collector import without_collector
                from .engine.prepared import prepare

                before, self._before = [self._before] if self._before else [], None
                with without_collector():
                    self._prepared = prepare(self._bodies, before, *progress)
            return self._prepared

    @property
    def lowered(self) -> Lowered:
        return self.prepared.lowered

    @property
    def geometry(self) -> Any:
        """The arrays that kernels take."""
        return self.prepared.geometry

    @property
    def memory(self) -> Memory:
        """What the prepared scene takes: bytes of its tables and of its tree, and how many primitives there are."""
        from .engine.memory import memory

        return memory(self.geometry)

    @calm
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
        from .scene_pictures import picture_of

        asked = width, height, samples, integrator, seed, depth, camera, filter, noise, shutter, times
        return picture_of(
            self, asked, layers=layers, groups=groups, drawn=dict(axes=axes, labels=labels, normals=normals),
            progress=progress, preview=preview, executor=executor, resume=resume,
        )  # fmt: skip

    @calm
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
        from .image import Image
        from .render.section import section_pixels

        return Image._of_light(
            section_pixels(self.prepared, self._bodies, self.extent, plane, at, width, height, samples)
        )

    @calm
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
        from .slices.slice import slice_of

        return slice_of(self, origin, u, v, pixels, at, progress, executor)

    @calm
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
        from .slices.voxels import voxels_of

        return voxels_of(self, bounds, shape, fractions, samples, axis, path, progress, executor)

    @staticmethod
    def load(
        path: str | os.PathLike[str], *, progress: Callable[[int, int], Any] | None = None, outside: bool = False
    ) -> Scene:
        """The scene in the YAML or JSON file at `path`, as `co.load`, which says more.

        progress: progress(done, count) is called now and then, with shares of the work.
        outside: may pictures of textures lie outside of the file's folder?
        """
        from .formats import scene_file

        callback("load", "progress", progress)
        parts = scene_file.read(checked_path("load", path), progress, flag("load", "outside", outside))
        return Scene(parts.bodies, parts.lights, parts.camera, parts.background, parts.domain, parts.animation)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write a scene file at `path` that `co.load` reads as an equal scene; `co.save` says more."""
        from .formats import scene_file

        scene_file.write(self, checked_path("save", path))

    @calm
    def view(self, height: int = 480) -> Any:
        """A widget to walk around in the scene in a notebook, `height` pixels high.

        Raises ImportError without anywidget (`pip install anywidget`), ValueError for what no browser holds.
        """
        from .viewer.widget import view

        return view(self, height)

    def _repr_mimebundle_(self, **_: Any) -> Any:
        """In a notebook a scene shows itself: the widget, or a picture without anywidget or where it is too large."""
        try:
            return self.view()._repr_mimebundle_()
        except (ImportError, ValueError):
            from base64 import b64encode

            picture = self.render(480, 360, samples=1)._repr_png_()
            return {"image/png": b64encode(picture).decode(), "text/plain": repr(self)}


def _again(kind: type[Scene], *parts: Any) -> Scene:
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
    raise TypeError(f"{owner}: scene must be a Scene, a shape or a Body, got {what(scene)}{hint}")
