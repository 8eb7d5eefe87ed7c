"""The scene a user holds: bodies, lights, a camera, and the questions it answers."""

from __future__ import annotations

import math
import operator
import os
from collections.abc import Callable, Iterable
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal, overload

import numpy as np

from .forks import lock
from .shapes.base import Shape, Solid
from .shapes.body import Body
from .shapes.calm import calm
from .shapes.labels import counted, first_numbers, one_ball
from .shapes.validate import callback, shown, what
from .shapes.validate import path as checked_path
from .shapes.vector import Box, FloatArray

if TYPE_CHECKING:
    from .geometry.memory import Memory
    from .image import Image
    from .lowering import Lowered
    from .trace.hits import Hits
    from .trace.queries import Prepared
    from .trace.spans import Crossings, Spans
    from .trace.threads import Progress


class Scene:
    """Bodies in listing order (ties go to the first), with lights, a camera and a background.

    `items` are shapes or `Body`s; one of these alone is a scene too, and one light is `lights`. `domain` is a solid
    that the bodies are to fill: `check` tells where they do not, and nothing else asks for it.
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
    ) -> None:
        from .scene_parts import as_bodies, as_camera, as_domain
        from .shapes.background import as_background
        from .shapes.light import as_lights

        self._bodies = as_bodies(items)
        names: dict[str, int] = {}
        for i, body in enumerate(self._bodies):
            if body.name is not None and names.setdefault(body.name, i) != i:
                raise ValueError(f"Scene: bodies[{names[body.name]}] and bodies[{i}] are both named {body.name!r}")
        self._lights = as_lights(lights)
        self._camera = as_camera(camera)
        self._background = as_background(background)
        self._domain = as_domain(domain)
        self._prepared: Prepared | None = None
        self._lock = lock()

    @property
    def bodies(self) -> tuple[Body, ...]:
        """The entries as listed. A `Spheres` is one entry and many bodies, so body numbers go to `body`, not here."""
        return self._bodies

    @property
    def lights(self) -> tuple[Any, ...]:
        return self._lights

    @property
    def camera(self) -> Any:
        return self._camera

    @property
    def background(self) -> Any:
        return self._background

    @property
    def domain(self) -> Solid | None:
        """What the bodies are to fill, as the cells of an imported model are; None for a scene that says nothing."""
        return self._domain

    def body(self, number: Any) -> Body:
        """The body of a number, as `hits.body` and `body_at` tell it; a ball of a `Spheres` as a `Sphere` of its own.

        It has its entry's material and name. Raises IndexError for numbers that there are not, -1, a miss, among them,
        and TypeError for what is no integer.
        """
        try:
            index = None if isinstance(number, bool) else operator.index(number)
        except TypeError:
            index = None
        if index is None:
            raise TypeError(
                f"body: number must be one integer, got {shown(number)}; hits.name and hits.material take all at once"
            )
        if not 0 <= index < self.body_count:
            miss = "; -1 stands for a miss" if index == -1 else ""
            raise IndexError(f"body: number must be at least 0 and below {self.body_count}, got {index}{miss}")
        entry = int(np.searchsorted(self._firsts, index, side="right")) - 1
        return one_ball(self._bodies[entry], index - int(self._firsts[entry]))

    @overload
    def __getitem__(self, name: str | int | np.integer[Any]) -> Body: ...

    @overload
    def __getitem__(self, name: slice) -> tuple[Body, ...]: ...

    def __getitem__(self, name: Any) -> Any:
        """The entry of a name, the body of a number, or the bodies of a slice of numbers."""
        if isinstance(name, str):
            for body in self._bodies:
                if body.name == name:
                    return body
            known = ", ".join(repr(body.name) for body in self._bodies if body.name) or "none has a name"
            raise KeyError(f"no body named {name!r}; named bodies: {known}")
        if isinstance(name, slice):
            return tuple(self.body(number) for number in range(*name.indices(self.body_count)))
        return self.body(name)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Scene):
            return NotImplemented
        return self._parts == other._parts

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        bodies, lights = counted(self.body_count, "body", "bodies"), counted(len(self._lights), "light", "lights")
        entries = (
            "" if len(self._bodies) == self.body_count else f" in {counted(len(self._bodies), 'entry', 'entries')}"
        )
        return f"Scene({bodies}{entries}, {lights})"

    def __reduce__(self) -> tuple[Any, ...]:
        return _again, (type(self), *self._parts)

    @property
    def _parts(self) -> tuple[Any, ...]:
        return self._bodies, self._lights, self._camera, self._background, self._domain

    def __copy__(self) -> Scene:
        made = _again(type(self), *self._parts)
        made._prepared = self._prepared
        return made

    @cached_property
    def _firsts(self) -> Any:
        """The first body number of each entry, and last how many there are."""
        return first_numbers(self._bodies)

    @property
    def body_count(self) -> int:
        """How many body ids there are: one for each entry, N for a `Spheres` of N balls."""
        return int(self._firsts[-1])

    @property
    @calm
    def bounds(self) -> Box:
        """(low, high) around all bodies; ±inf where unbounded, (inf, -inf) for an empty scene."""
        from .shapes.boxes import around

        return around([body.shape.bounds for body in self._bodies])

    @property
    @calm
    def prepared(self) -> Prepared:
        """The lowered scene with its tree, built on first use and shared by all threads."""
        with self._lock:
            if self._prepared is None:
                from .lowering import lower
                from .trace.queries import Prepared

                self._prepared = Prepared.of(lower(self._bodies), self._bodies)
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
        """What the prepared scene takes: how many cells it has, and the bytes of its tables and of its tree."""
        from .geometry.memory import memory

        return memory(self.geometry)

    @property
    def materials(self) -> tuple[Any, ...]:
        """The different materials, in the order of the first body of each; None is that of bodies without."""
        return tuple(dict.fromkeys(body.material for body in self._bodies))

    @property
    def body_materials(self) -> list[Any]:
        """The material of each body id (None: the default)."""
        return [self._bodies[item].material for item in self.lowered.body_item.tolist()]

    @calm
    def first_hit(self, origins: Any, directions: Any = None, t_min: Any = 0.0, t_max: Any = math.inf) -> Hits:
        """The nearest crossing of each ray in the open interval ]t_min, t_max[.

        Raises ValueError for rays that cannot be traced, with the index of the first.
        """
        from .trace import queries

        if self._prepared is None:
            from .ahead import expect

            expect("rays", "streams", "points")
        return queries.first_hit(self.prepared, queries.as_rays(origins, directions), t_min, t_max)

    @calm
    def occluded(self, origins: Any, directions: Any = None, t_min: Any = 0.0, t_max: Any = math.inf) -> Any:
        """bool (...): is there any crossing in ]t_min, t_max[?  Equals first_hit(...).t < inf."""
        from .trace import queries

        return queries.occluded(self.prepared, queries.as_rays(origins, directions), t_min, t_max)

    @calm
    def spans(self, origins: Any, directions: Any = None, t_min: Any = 0.0, t_max: Any = math.inf) -> Spans:
        """Every stretch of each ray inside each solid, clipped to [t_min, t_max], sorted along the ray."""
        from .trace import queries

        return queries.spans(self.prepared, queries.as_rays(origins, directions), t_min, t_max)

    @calm
    def crossings(self, origins: Any, directions: Any = None, t_min: Any = 0.0, t_max: Any = math.inf) -> Crossings:
        """Every crossing of each ray with every body in ]t_min, t_max[, solids and sheets, sorted along the ray."""
        from .trace import queries

        return queries.crossings(self.prepared, queries.as_rays(origins, directions), t_min, t_max)

    @calm
    def lengths(
        self, origins: Any, directions: Any = None, t_min: Any = 0.0, t_max: Any = math.inf, *,
        by: Literal["body", "material"] = "body", progress: Progress | None = None,
    ) -> FloatArray:  # fmt: skip
        """`spans(...).lengths(by)`, the same to the bit, for any number of rays: their spans are not kept.

        `progress(done, count)` is called with numbers of rays.
        """
        from .trace import integrals, queries

        callback("lengths", "progress", progress)
        return integrals.lengths(self.prepared, queries.as_rays(origins, directions), t_min, t_max, by, progress)

    @calm
    def line_integral(
        self, values: Any, origins: Any, directions: Any = None, t_min: Any = 0.0, t_max: Any = math.inf, *,
        otherwise: Any = None, progress: Progress | None = None,
    ) -> Any:  # fmt: skip
        """`spans(...).line_integral(values)`, the same to the bit, for any number of rays: their spans are not kept.

        `values`: (bodies,) or (bodies, energies), a mapping from names of materials, or the name of a property.
        """
        from .trace import integrals, queries

        callback("line_integral", "progress", progress)
        rays = queries.as_rays(origins, directions)
        return integrals.line_integral(self.prepared, values, rays, t_min, t_max, otherwise, progress)

    @calm
    def contains(self, points: Any) -> Any:
        """bool (...): does any solid contain the point (..., 3)?  Leaves are closed, Booleans exact."""
        return np.asarray(self.body_at(points) >= 0)[()]

    @calm
    def body_at(self, points: Any) -> Any:
        """int32 (...): the first listed body that contains the point (..., 3), or -1."""
        from .trace import queries

        return queries.body_at(self.prepared, points)

    @calm
    def render(
        self,
        width: int = 640,
        height: int = 480,
        samples: int = 4,
        integrator: str = "whitted",
        seed: int = 0,
        *,
        depth: int = 10,
        progress: Callable[[int, int], Any] | None = None,
    ) -> Image:
        """A picture. `samples` per pixel (1: pixel centers); a camera and light that fit, where none is given.

        `depth`: how often a ray is reflected or refracted at most. `progress(done, count)` is called now and then.
        """
        from .ahead import expect
        from .image import Image
        from .render import render

        expect("picture", "rays", "streams", "points")
        return Image(render(self, width, height, samples, integrator, seed, depth, progress))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write a scene file that `co.load` reads as an equal scene; `co.save` says more."""
        from .formats import scene_file

        scene_file.write(self, checked_path("save", path))

    @calm
    def view(self, height: int = 480) -> Any:
        """A widget to walk around in the scene in a notebook, `height` pixels high.

        Raises ImportError without anywidget (`pip install conicoid[notebook]`), ValueError for what no browser holds.
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
    raise TypeError(f"{owner}: scene must be a Scene, a shape or a Body, got {what(scene)}")
