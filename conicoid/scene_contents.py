"""What a scene holds: bodies by name and number, lights, a camera, a background."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any, NoReturn, overload

import numpy as np

from .scene_parts import Bodies, as_index, named, numbered
from .shapes.base import Shape, Solid
from .shapes.body import Body
from .shapes.calls import explained_methods
from .shapes.labels import counted, distinct_materials, first_numbers, one_body
from .shapes.material import Material
from .shapes.named_parts import Named, Parts
from .shapes.repeated import Repeated
from .shapes.validate import shown, what

_OTHER_MATERIALS = "bodies have materials, scene.replace(which, material=...) is a scene with another"


@explained_methods
class Contents:
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
        return Parts(self._lights, "scene.lights", "scene.replace(lights=[...]) is a scene with other lights")

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
        entry, ball = numbered(self._firsts, number)
        return one_body(self._bodies[entry], ball)

    @overload
    def __getitem__(self, name: str | int | np.integer[Any]) -> Body: ...

    @overload
    def __getitem__(self, name: slice) -> tuple[Body, ...]: ...

    def __getitem__(self, name: Any) -> Any:
        """The entry of a name, the body of a number, or the bodies of a slice of numbers."""
        if isinstance(name, str):
            return self._bodies[named(self._bodies, name)]
        if isinstance(name, slice):
            return tuple(self.body(number) for number in range(*name.indices(self.body_count)))
        if as_index(name) is None:
            raise TypeError(f"Scene: index must be a name, a body's number or a slice of numbers, got {shown(name)}")
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
        if not isinstance(other, Contents):
            return NotImplemented
        raise TypeError("Scene: scenes are put together by their entries, co.Scene([*a.bodies, *b.bodies], a.lights)")

    __or__ = __add__

    def __array__(self, dtype: Any = None, copy: Any = None) -> Any:
        """An array () of the scene itself, as NumPy's files keep it."""
        from .engine.answers.no_array import boxed

        del copy
        return boxed(self, dtype)

    def __contains__(self, item: object) -> bool:
        """Is there an entry of a name, this body, or an entry of this shape? A TypeError for anything else."""
        if isinstance(item, str):
            if isinstance(self._bodies, Repeated):
                return self._bodies.number(item) is not None
            return any(item == body.name for body in self._bodies)
        if isinstance(item, Shape):
            return any(item == body.shape for body in self._bodies)
        if isinstance(item, Body):
            return item in self._bodies
        hint = "; scene.materials has the materials" if isinstance(item, Material) else ""
        raise TypeError(f"Scene: `in` asks for a name, a shape or a Body, got {what(item)}{hint}")

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Contents):
            return NotImplemented
        return self._parts == other._parts

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        told = [counted(self.body_count, "body", "bodies"), counted(len(self._lights), "light", "lights")]
        if len(self._bodies) != self.body_count:
            told[0] += f" in {counted(len(self._bodies), 'entry', 'entries')}"
        told += [counted(len(self._notes), "note", "notes")] if self._notes else []
        return f"Scene({', '.join(told)})"

    @property
    def _parts(self) -> tuple[Any, ...]:
        return self._bodies, self._lights, self._camera, self._background, self._domain, self._animation

    @cached_property
    def _firsts(self) -> Any:
        """The first body number of each entry, and last how many there are."""
        if isinstance(self._bodies, Repeated):
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
        found = bodies.distinct_materials if isinstance(bodies, Repeated) else distinct_materials(bodies)
        return Named(found, "scene.materials", _OTHER_MATERIALS, material_of=lambda number: self.body(number).material)
