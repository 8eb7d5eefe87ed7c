"""The measures of every body of a scene, and of its materials."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np

from ..scene_parts import numbered
from ..shapes.body import Body
from ..shapes.fixed import fixed
from ..shapes.named_parts import Named
from ..shapes.other_names import hinted
from ..shapes.same import by_value
from ..shapes.suggestion import close_to, known_names
from ..shapes.validate import shown
from ..shapes.vector import FloatArray
from .chords import Progress
from .frames import Unbounded
from .measure import RAYS, Measures, measure_shape, measures_of

if TYPE_CHECKING:
    from ..scene import Scene

_FEWEST = 10_000
_LISTED, _NARROW = 50, 28


@hinted
@fixed
@by_value()
@dataclass(frozen=True, eq=False)
class SceneMeasures(Sequence[Measures]):
    """What `measure` found of a scene: a sequence with the `Measures` of each body by its number.

    names       of the bodies
    materials   the different materials, as `scene.materials`
    places      the place among these of each body's
    by_material the `Measures` of each of these, as of its bodies together

    found["water"] has those of the material, or the body, of that name: of materials that share it, together. A name
    that both a material and a body have, but not of one and the same, is a KeyError. Every body counts whole: where
    bodies overlap, what they have in common counts for each. A body without end has NaN throughout, and so has its
    material.
    """

    bodies: tuple[Measures, ...]
    names: tuple[str | None, ...]
    materials: tuple[Any, ...]
    places: tuple[int, ...]
    """The place among `materials` of each body's."""

    def __len__(self) -> int:
        return len(self.bodies)

    if not TYPE_CHECKING:  # else checkers would let measures be set

        def __setitem__(self, index: Any, value: Any) -> NoReturn:
            raise TypeError("SceneMeasures are read-only: what was found does not change")

    def __iter__(self) -> Iterator[Measures]:
        return iter(self.bodies)

    def __getitem__(self, index: Any) -> Any:
        """Of a body by its number or name, of bodies by a slice, or of materials by their name."""
        if isinstance(index, slice):
            return self.bodies[index]
        if not isinstance(index, str):
            return self.bodies[numbered(np.arange(len(self.bodies) + 1), index, "SceneMeasures: a body's number")[0]]
        numbers = self._named(index)
        return self.bodies[numbers[0]] if len(numbers) == 1 else together([self.bodies[i] for i in numbers])

    def _named(self, name: str) -> list[int]:
        """The numbers of the bodies that a name stands for."""
        called = [place for place, m in enumerate(self.materials) if m is not None and m.name == name]
        made_of = [i for i, place in enumerate(self.places) if place in called]
        own = [i for i, body in enumerate(self.names) if body == name]
        if made_of and own and made_of != own:
            raise KeyError(
                f"both a material and a body are called {shown(name)}: by_material has materials by their places, "
                "and numbers stand for bodies"
            )
        if called or own:
            return made_of or own
        known = [m.name for m in self.materials if m is not None and m.name]
        close = close_to(name, [body for body in dict.fromkeys(self.names) if body][:_LISTED])
        meant = f"; a body is called {shown(close)}" if close else ""
        raise KeyError(f"no material is called {shown(name)}; {known_names(name, 'materials', known)}{meant}")

    @property
    def volume(self) -> FloatArray:
        """(bodies,)"""
        return np.array([body.volume for body in self.bodies])

    @property
    def volume_error(self) -> FloatArray:
        """(bodies,)"""
        return np.array([body.volume_error for body in self.bodies])

    @cached_property
    def by_material(self) -> tuple[Measures, ...]:
        groups: list[list[Measures]] = [[] for _ in self.materials]
        for body, place in zip(self.bodies, self.places, strict=True):
            groups[place].append(body)
        names = [material and material.name for material in self.materials]
        return Named(map(together, groups), "found.by_material", names=names)

    def __repr__(self) -> str:
        volumes = ", ".join(f"{body.volume:.9g}" for body in self.bodies[:8]) + (", ..." if len(self) > 8 else "")
        return f"SceneMeasures(volumes: {volumes})"

    def _repr_pretty_(self, printer: Any, cycle: bool) -> None:
        """In a notebook the table."""
        printer.text(repr(self) if cycle else str(self))

    def __str__(self) -> str:
        rows = [(self._title(place), found) for place, found in enumerate(self.by_material)]
        for number, (name, found) in enumerate(zip(self.names[:_LISTED], self.bodies, strict=False)):
            rows.append((f"body {number}" + (f" {name!r}" if name else ""), found))
        width = max([_NARROW, *(len(title) + 1 for title, _ in rows)])
        more = len(self) - _LISTED
        lines = [f"{'':<{width}}{'volume':>16}", *(_line(title, found, width) for title, found in rows)]
        return "\n".join(lines + ([f"and {more:,} more bodies"] if more > 0 else []))

    def _title(self, place: int) -> str:
        """A material by its name, or, without one of its own, as that of its first body."""
        material = self.materials[place]
        if material is None:
            return "no material"
        of_body = f" of body {self.places.index(place)}"
        if not material.name:
            return f"material{of_body}"
        shared = sum(other is not None and other.name == material.name for other in self.materials) > 1
        return f"material {material.name!r}{of_body if shared else ''}"


def _line(title: str, found: Measures, width: int) -> str:
    error = f"  ± {found.volume_error:.2g}" if found.volume_error > 0 else ""
    volume = "unbounded" if math.isnan(found.volume) else f"{found.volume:.9g}"
    return f"{title:<{width}}{volume:>16}{error}"


def measure_scene(
    scene: Scene, rays: int | None, seed: int, progress: Progress | None, executor: Any = None
) -> SceneMeasures:
    """Each body by itself. The rays are for all together, but for at least ten thousand for each that needs them."""
    share = max(_FEWEST, (RAYS if rays is None else rays) // max(1, scene.body_count))
    bodies = scene[:]
    asked = share, rays is None, seed
    if executor is not None:
        from .elsewhere import on_workers

        found = on_workers(_measured, [(body, *asked) for body in bodies], executor, progress)
    else:
        found = []
        for body in bodies:
            found.append(_measured(body, *asked))
            if progress is not None:
                progress(len(found), len(bodies))
    materials = Named(scene.materials, "found.materials")
    places = {material: place for place, material in enumerate(materials)}
    return SceneMeasures(
        tuple(found),
        tuple(body.name for body in bodies),
        materials,
        tuple(places[body.material] for body in bodies),
    )


def _measured(body: Body, rays: int, by_form: bool, seed: int) -> Measures:
    try:
        return measure_shape(body.shape, rays, by_form, seed, None)
    except Unbounded:
        volume = 0.0 if body.shape.is_sheet else math.nan
        unknown = np.full(3, np.nan), np.full((3, 3), np.nan)
        return measures_of(volume, math.nan, *unknown, volume, math.nan, *unknown, 0)


def together(parts: Sequence[Measures]) -> Measures:
    """The measures of bodies that do not overlap, as one; errors to first order."""
    volume = math.fsum(part.volume for part in parts)
    area = math.fsum(part.area for part in parts)
    rays = sum(part.rays for part in parts)
    solid = [part for part in parts if part.volume != 0]
    errors = _root(part.volume_error for part in parts), _root(part.area_error for part in parts)
    if not solid:
        nothing = np.full(3, np.nan), np.zeros((3, 3))
        return measures_of(0.0, area, *nothing, *errors, np.full(3, np.nan), np.zeros((3, 3)), rays)
    center = sum(part.volume * part.centroid for part in solid) / volume
    inertia, center_square, inertia_square = np.zeros((3, 3)), np.zeros(3), np.zeros((3, 3))
    for part in solid:
        way = part.centroid - center
        lever = way @ way * np.eye(3) - np.outer(way, way)
        inertia += part.inertia + part.volume * lever
        center_square += (part.volume * part.centroid_error) ** 2 + (part.volume_error * way) ** 2
        slope = 2 * part.volume * np.linalg.norm(way) * np.linalg.norm(part.centroid_error)
        inertia_square += part.inertia_error**2 + (part.volume_error * lever) ** 2 + slope**2
    found = np.sqrt(center_square) / abs(volume), np.sqrt(inertia_square)
    return measures_of(volume, area, np.asarray(center), inertia, *errors, *found, rays)


def _root(errors: Iterable[float]) -> float:
    return math.sqrt(math.fsum(error * error for error in errors))
