"""How large, where and how heavy: `measure` and its answer."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, NoReturn, overload

import numpy as np

from ..._util.arrays import FloatArray
from ..._util.equality import compare_by_value
from ..._util.errstate import ignore_fp_errors
from ..._util.foreign_names import with_attribute_hints
from ..._util.hints import closest_name, describe_names, frozen_with_hints
from ..._util.name_tuples import NamedPartTuple
from ..._util.validation import check_callback, check_integer, describe_kind, format_value
from ...geometry.body import Body
from ...geometry.bulk import Bulk
from ...geometry.entries import find_body
from ...geometry.primitives import Sphere
from ...geometry.shape import Boolean, Complement, Shape, Union
from ...geometry.transform import IDENTITY_MOTION
from ...parallel.workers import as_workers
from ...queries.scene_protocol import is_scene
from . import closed_forms as _prismatoids  # noqa: F401 (it registers closed forms, as the next does)
from . import closed_forms as _turned  # noqa: F401
from .chords import AREA, FIRST, PAIRS, SECOND, VOLUME, ChordSums, Progress, sample_integrals
from .closed_forms import Moments, closed_area, closed_moments
from .closed_regions import closed_region
from .hull import FittedBox, UnboundedShapeError, fitted_box

if TYPE_CHECKING:
    from ...parallel.workers import Workers
    from ...queries.scene_protocol import SceneLike


FEWEST_RAYS, RAYS = 60, 1_000_000
_MOST_RAYS = 10**12
_PLAIN, _LARGEST = 64, 332
"""Binary places of usual sizes, and of the domain."""


@with_attribute_hints
@frozen_with_hints
@compare_by_value()
@dataclass(frozen=True, eq=False)
class Measures:
    """What `measure` found, each value with its standard error (one sigma; 0 where a closed form was used).

    volume_error, area_error, centroid_error and inertia_error are those, shaped like the values:

    volume, area   floats; a solid's area is that of its whole boundary, a sheet's counts one side
    centroid       (3,), NaN where the volume is 0
    inertia        (3, 3) tensor about the centroid for density 1: ∫ (|r|² 1 - r rᵀ) dV
    rays           how many rays were followed
    """

    volume: float
    area: float
    centroid: FloatArray
    inertia: FloatArray
    volume_error: float
    area_error: float
    centroid_error: FloatArray
    inertia_error: FloatArray
    rays: int

    def __repr__(self) -> str:
        return f"Measures(volume={self.volume:.9g}, area={self.area:.9g}, rays={self.rays})"

    def _repr_pretty_(self, printer: Any, cycle: bool) -> None:
        """In a notebook the table."""
        printer.text(repr(self) if cycle else str(self))

    def __str__(self) -> str:
        rows = [
            ("volume", self.volume, self.volume_error),
            ("area", self.area, self.area_error),
            *((f"centroid {a}", c, e) for a, c, e in zip("xyz", self.centroid, self.centroid_error, strict=True)),
            *((f"inertia {'xyz'[i]}{'xyz'[j]}", self.inertia[i, j], self.inertia_error[i, j]) for i, j in PAIRS),
        ]
        return "\n".join(
            f"{name:<11}{value:>16.9g}" + (f"  ± {error:.2g}" if error else "") for name, value, error in rows
        )


@overload
def measure(
    shape: Shape | Body,
    rays: int | None = None,
    seed: int = 0,
    progress: Progress | None = None,
    *,
    executor: Any = None,
) -> Measures: ...


@overload
def measure(
    shape: SceneLike, rays: int | None = None, seed: int = 0, progress: Progress | None = None, *, executor: Any = None
) -> SceneMeasures: ...


@ignore_fp_errors
def measure(
    shape: Any, rays: int | None = None, seed: int = 0, progress: Progress | None = None, *, executor: Any = None
) -> Any:
    """Volume, surface area, centroid and inertia of a bounded shape, with standard errors; of a scene, of every body.

    shape: a shape or a `Body`; or a `Scene`, of which every body is measured by itself, and `SceneMeasures` adds them
        up by material.
    rays: about how many are followed; where that is given, combinations are followed by rays in any case.
    seed: equal seeds give equal answers, for any number of threads.
    progress: progress(done, total) is called now and then.
    executor: where it is done, as for `scene.first_hit`: of a scene a body a task, of one shape pieces of its rays; the
        same to the bit.

    Primitives have closed forms for the volume, centroid and inertia under any motion, and some for the
    area. So have prisms between planes and circular cylinders, and solids of revolution, in any Boolean
    combination: pins, pipes, boxes, shells, most bodies of imported models. Everything else comes from the exact
    chords of about a million rays. The solids of a `Spheres`, `Boxes` and so on count as their union, and of many
    sheets the areas are added up. An empty solid measures zero, and so does the volume of a sheet.

    What is larger than float64 holds is inf, as the inertia of a ball of radius 1e90, and what is smaller 0.

    Raises ValueError for an unbounded shape, naming the axes, and for fewer than 60 rays.
    """
    scene = shape if is_scene(shape) else None
    shape = shape.shape if isinstance(shape, Body) else shape
    if scene is None and not isinstance(shape, Shape):
        hint = "; co.load(path) reads a scene file" if isinstance(shape, str) else ""
        raise TypeError(
            f"measure: shape must be a shape or a Body, got {describe_kind(shape)}; "
            f"of a Scene every body is measured{hint}"
        )
    check_callback("measure", "progress", progress)
    if isinstance(rays, str) and scene is not None:
        told = f"got {rays!r}; of one body it is measure(scene)[{rays!r}]"
        raise ValueError(f"measure: rays must be an integer >= {FEWEST_RAYS}, {told}")
    rays = None if rays is None else check_integer("measure", "rays", rays, FEWEST_RAYS, _MOST_RAYS)
    seed = check_integer("measure", "seed", seed, 0)
    if scene is not None:
        return measure_scene(scene, rays, seed, progress, executor)
    workers = None if executor is None else as_workers("measure", executor)
    return measure_shape(shape, RAYS if rays is None else rays, rays is None, seed, progress, workers)


def measure_shape(
    shape: Shape, rays: int, by_form: bool, seed: int, progress: Progress | None, workers: Workers | None = None
) -> Measures:
    """Of one shape; with `by_form`, combinations by their closed forms where these are known."""
    if isinstance(shape, Bulk) and shape.is_sheet:
        return _sheets(shape, rays, by_form, seed, progress, workers)
    shape = _plain(shape)
    exponent = _exponent(fitted_box(shape))
    if exponent:
        shape = shape.scale(2.0**-exponent)
    return _in_units(_measure_primitives(shape, rays, by_form, seed, progress, workers), exponent)


def _sheets(
    shape: Bulk, rays: int, by_form: bool, seed: int, progress: Progress | None, workers: Workers | None
) -> Measures:
    """Of many sheets: what their areas add up to. They have no volume."""
    parts = [measure_shape(shape.single(index), rays, by_form, seed, progress, workers) for index in range(len(shape))]
    area, error = math.fsum(part.area for part in parts), math.hypot(*(part.area_error for part in parts))
    return _closed(Moments(0.0, np.full(3, np.nan), np.zeros((3, 3))), area, error, sum(part.rays for part in parts))


def _exponent(box: FittedBox) -> int:
    """The power of two to measure a shape in: 0, but for sizes whose tenth powers leave float64, and needles.

    Values are sums of fifth powers of the size, and errors come from their squares. Rays start in the domain.
    """
    if box.is_empty or not box.half.any():
        return 0
    sizes = [math.frexp(half)[1] for half in box.half.tolist() if half]
    largest, least = max(sizes), min(sizes)
    if abs(largest) < _PLAIN and least > -4 * _PLAIN:
        return 0
    exponent = largest if largest - least < 3 * _PLAIN else largest - _PLAIN
    return max(-_LARGEST, min(exponent, _LARGEST))


def _in_units(measures: Measures, exponent: int) -> Measures:
    """From powers of two to units: exact, but for what is beyond float64, which is inf or 0."""
    if not exponent:
        return measures

    def times(value: Any, power: int) -> Any:
        # In steps that float64 holds: a zero stays zero
        for _ in range(power):
            value = np.ldexp(value, exponent)
        return value

    m = measures
    return measures_of(
        times(m.volume, 3), times(m.area, 2), times(m.centroid, 1), times(m.inertia, 5), times(m.volume_error, 3),
        times(m.area_error, 2), times(m.centroid_error, 1), times(m.inertia_error, 5), m.rays,
    )  # fmt: skip


def _measure_primitives(
    shape: Shape, rays: int, by_form: bool, seed: int, progress: Progress | None, workers: Workers | None
) -> Measures:
    box = fitted_box(shape)
    nothing = Moments(0.0, np.full(3, np.nan), np.zeros((3, 3)))
    if box.is_empty:
        return _closed(nothing, 0.0)
    moments, area = nothing if shape.is_sheet else closed_moments(shape), closed_area(shape)
    if moments is None and by_form and (found_form := closed_region(shape, box)) is not None:
        moments, area = found_form
    if moments is not None and area is not None:
        return _closed(moments, area)
    found = _sampled(sample_integrals(shape, box, rays, seed, progress, workers), box)
    return found if moments is None else _closed(moments, found.area, found.area_error, found.rays)


def _plain(shape: Shape) -> Shape:
    """Many bodies as their union; what is only painted, or alone in a combination, as it is."""
    while isinstance(shape, Boolean) and len(shape.operands) == 1 and not isinstance(shape, Complement):
        inner = shape.operands[0]
        shape = dataclasses.replace(inner, motion=inner.motion.then(shape.motion))
    if not isinstance(shape, Bulk):
        return shape
    if len(shape) == 0:
        return Sphere() - Sphere()
    singles: Any = (shape.single(index) for index in range(len(shape)))
    return Union(tuple(dataclasses.replace(one, motion=IDENTITY_MOTION) for one in singles), motion=shape.motion)


def _closed(moments: Moments, area: float, area_error: float = 0.0, rays: int = 0) -> Measures:
    inertia = np.trace(moments.second) * np.eye(3) - moments.second
    none = np.zeros(3), np.zeros((3, 3))
    return measures_of(moments.volume, area, moments.centroid, inertia, 0.0, area_error, *none, rays)


def _sampled(sums: ChordSums, box: FittedBox) -> Measures:
    """From integrals about the center of the box to values in the world, errors to first order."""
    values, covariance = sums.values, sums.covariance
    volume, errors = float(values[VOLUME]), np.sqrt(covariance.diagonal())
    if volume <= 0:
        unknown = np.full(3, np.nan), np.zeros((3, 3))
        return measures_of(0.0, values[AREA], *unknown, errors[VOLUME], errors[AREA], *unknown, sums.rays)
    offset = values[FIRST] / volume
    slopes = [_about(unit, offset, box.axes) for unit in np.eye(len(values))]
    centroid_slopes = np.array([box.axes @ (unit[FIRST] - unit[VOLUME] * offset) for unit in np.eye(len(values))])
    return measures_of(
        volume,
        values[AREA],
        box.center + box.axes @ offset,
        _about(values, offset, box.axes),
        errors[VOLUME],
        errors[AREA],
        _propagated(centroid_slopes / volume, covariance),
        _propagated(np.array(slopes), covariance),
        sums.rays,
    )


def _about(values: FloatArray, offset: FloatArray, axes: FloatArray) -> FloatArray:
    """The inertia tensor in the world about a fixed point, linear in the integrals."""
    second = np.empty((3, 3))
    for value, (i, j) in zip(values[SECOND], PAIRS, strict=True):
        second[i, j] = second[j, i] = value
    first = values[FIRST]
    second += values[VOLUME] * np.outer(offset, offset) - np.outer(first, offset) - np.outer(offset, first)
    turned: FloatArray = axes @ (np.trace(second) * np.eye(3) - second) @ axes.T
    return (turned + turned.T) / 2


def _propagated(slopes: FloatArray, covariance: FloatArray) -> FloatArray:
    """Standard errors of linear functions with slopes (11, ...)."""
    variance = np.einsum("i...,ij,j...->...", slopes, covariance, slopes)
    result: FloatArray = np.sqrt(np.maximum(variance, 0.0))
    return result


def measures_of(
    volume: float, area: float, centroid: FloatArray, inertia: FloatArray,
    volume_error: float, area_error: float, centroid_error: FloatArray, inertia_error: FloatArray, rays: int,
) -> Measures:  # fmt: skip
    for array in (centroid, inertia, centroid_error, inertia_error):
        array.flags.writeable = False
    scalars = float(volume), float(area), float(volume_error), float(area_error)
    return Measures(
        scalars[0], scalars[1], centroid, inertia, scalars[2], scalars[3], centroid_error, inertia_error, rays
    )


# The measures of every body of a scene, and of its materials.

_FEWEST = 10_000
_LISTED, _NARROW = 50, 28


@with_attribute_hints
@frozen_with_hints
@compare_by_value()
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
            return self.bodies[find_body(np.arange(len(self.bodies) + 1), index, "SceneMeasures: a body's number")[0]]
        numbers = self._named(index)
        return self.bodies[numbers[0]] if len(numbers) == 1 else combine_measures([self.bodies[i] for i in numbers])

    def _named(self, name: str) -> list[int]:
        """The numbers of the bodies that a name stands for."""
        called = [place for place, m in enumerate(self.materials) if m is not None and m.name == name]
        made_of = [i for i, place in enumerate(self.places) if place in called]
        own = [i for i, body in enumerate(self.names) if body == name]
        if made_of and own and made_of != own:
            raise KeyError(
                f"both a material and a body are called {format_value(name)}: "
                "by_material has materials by their places, "
                "and numbers stand for bodies"
            )
        if called or own:
            return made_of or own
        known = [m.name for m in self.materials if m is not None and m.name]
        close = closest_name(name, [body for body in dict.fromkeys(self.names) if body][:_LISTED])
        meant = f"; a body is called {format_value(close)}" if close else ""
        raise KeyError(f"no material is called {format_value(name)}; {describe_names(name, 'materials', known)}{meant}")

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
        return NamedPartTuple(map(combine_measures, groups), "found.by_material", names=names)

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
    scene: SceneLike, rays: int | None, seed: int, progress: Progress | None, executor: Any = None
) -> SceneMeasures:
    """Each body by itself. The rays are for all together, but for at least ten thousand for each that needs them."""
    share = max(_FEWEST, (RAYS if rays is None else rays) // max(1, scene.body_count))
    bodies = scene[:]
    asked = share, rays is None, seed
    if executor is not None:
        from .parallel import run_on_workers

        found = run_on_workers(_measure_bodies, [(body, *asked) for body in bodies], executor, progress)
    else:
        found = []
        for body in bodies:
            found.append(_measure_bodies(body, *asked))
            if progress is not None:
                progress(len(found), len(bodies))
    materials = NamedPartTuple(scene.materials, "found.materials")
    places = {material: place for place, material in enumerate(materials)}
    return SceneMeasures(
        tuple(found),
        tuple(body.name for body in bodies),
        materials,
        tuple(places[body.material] for body in bodies),
    )


def _measure_bodies(body: Body, rays: int, by_form: bool, seed: int) -> Measures:
    try:
        return measure_shape(body.shape, rays, by_form, seed, None)
    except UnboundedShapeError:
        volume = 0.0 if body.shape.is_sheet else math.nan
        unknown = np.full(3, np.nan), np.full((3, 3), np.nan)
        return measures_of(volume, math.nan, *unknown, volume, math.nan, *unknown, 0)


def combine_measures(parts: Sequence[Measures]) -> Measures:
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
