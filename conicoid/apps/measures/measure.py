"""`measure`: volume, area, centroid and inertia of shapes, and of the bodies and materials of a scene.

Closed forms come first, then chords of rays. Sizes whose powers leave float64 are measured in units of a power of two.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Iterator, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, overload

import numpy as np

from ..._util.arrays import FloatArray, ignore_fp_errors
from ..._util.records import compare_by_value, dataclass
from ..._util.text import NameTuple, describe_names, html_table
from ..._util.validation import check_callback, check_integer, describe_kind, format_value
from ...geometry.body import Body
from ...geometry.bulk import Bulk
from ...geometry.entries import find_body
from ...geometry.instances import InstanceList, instance_origin, transform_offsets
from ...geometry.primitives import Sphere
from ...geometry.shape import Boolean, Complement, Shape, Union
from ...geometry.transform import IDENTITY_MOTION
from ...parallel.workers import as_workers
from ...queries.scene_protocol import is_scene
from .chords import AREA, FIRST, PAIRS, SECOND, VOLUME, ChordSums, Progress, run_on_workers, sample_integrals
from .closed_forms import Moments, closed_area, closed_moments, similarity
from .closed_regions import closed_region
from .flat_solids import box_grid, flat_form
from .hull import FittedBox, UnboundedShapeError, fitted_box, leaning_box

if TYPE_CHECKING:
    from ...parallel.workers import Workers
    from ...queries.scene_protocol import SceneLike


# The measures of one shape.

FEWEST_RAYS, RAYS = 60, 1_000_000
"""The smallest number of rays, and the default."""
_MOST_RAYS = 10**12
_PLAIN, _LARGEST = 64, 332
"""Binary exponents of usual sizes, and of the largest coordinates of rays."""


@compare_by_value()
@dataclass(frozen=True, eq=False)
class Measures:
    """The measures of a shape, each value with its standard error.

    Attributes
    ----------
    volume, area : float
        A solid's area is that of its whole boundary; a sheet's area counts one side.
    centroid : float64 (3,)
        NaN if the volume is 0.
    inertia : float64 (3, 3)
        The tensor about the centroid for density 1: ∫ (|r|² 1 - r rᵀ) dV.
    volume_error, area_error, centroid_error, inertia_error
        Standard errors (one sigma), shaped like the values; 0 for a closed form.
    rays : int
        How many rays were traced.
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
        """Show the table in a notebook."""
        printer.text(repr(self) if cycle else str(self))

    def __str__(self) -> str:
        return "\n".join(
            f"{name:<11}{value:>16.9g}" + (f"  ± {error:.2g}" if error else "") for name, value, error in self._rows()
        )

    def _repr_html_(self) -> str:
        """Return the table that a notebook shows."""
        rows = self._rows()
        return html_table(("measure", "value", "standard error"), rows, len(rows))

    def _rows(self) -> list[tuple[str, float, float]]:
        """Return names, values and standard errors."""
        return [
            ("volume", self.volume, self.volume_error),
            ("area", self.area, self.area_error),
            *((f"centroid {a}", c, e) for a, c, e in zip("xyz", self.centroid, self.centroid_error, strict=True)),
            *((f"inertia {'xyz'[i]}{'xyz'[j]}", self.inertia[i, j], self.inertia_error[i, j]) for i, j in PAIRS),
        ]


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
    """Measure the volume, surface area, centroid and inertia of a bounded shape, or of every body of a scene.

    Primitives have closed forms of the volume, centroid and inertia under any motion, and most of the area; so have
    polyhedra, meshes and extrusions. Boolean combinations have them of boxes along common axes, of planes and circular
    cylinders along an axis, and of solids of revolution about one: pins, pipes, shells, most bodies of imported models.
    All others are measured by the exact chords of about a million rays.

    Parameters
    ----------
    shape : Shape, Body or Scene
        The solids of a `Spheres`, `Boxes` and so on count as their union; the areas of such sheets are added up. The
        bodies of a scene are measured one by one. Copies that a file repeats have the measures of the first of them,
        moved, unless these need rays.
    rays : int, optional
        About how many rays to trace, 60 to 1e12. Default: a million, unless there is a closed form. A given number
        makes Boolean combinations use rays in any case. A scene divides them among its bodies, with at least 10 000
        for each body that needs rays.
    seed : int
        Seed of the random rays; equal seeds give equal results for any number of threads.
    progress : callable, optional
        progress(done, total) is called now and then: in rays, or in bodies of a scene.
    executor : optional
        Where to compute, as for `scene.first_hit`: a task is a body of a scene, or some pieces of the rays of a shape.
        The result is the same to the bit.

    Returns
    -------
    Measures or SceneMeasures
        Values with standard errors. An empty solid measures 0, and a sheet has the volume 0. Values beyond float64 are
        inf, as the inertia of a ball of radius 1e90, and those below it are 0. An unbounded body of a scene has NaN.

    Raises
    ------
    TypeError
        For anything but a shape, a body or a scene.
    ValueError
        For an unbounded shape, naming the axes, and for fewer than 60 rays.
    """
    scene = shape if is_scene(shape) else None
    shape = shape.shape if isinstance(shape, Body) else shape
    if scene is None and not isinstance(shape, Shape):
        raise TypeError(f"measure: shape must be a shape, a Body or a Scene, got {describe_kind(shape)}")
    check_callback("measure", "progress", progress)
    rays = None if rays is None else check_integer("measure", "rays", rays, FEWEST_RAYS, _MOST_RAYS)
    seed = check_integer("measure", "seed", seed, 0)
    if scene is not None:
        return measure_scene(scene, rays, seed, progress, executor)
    workers = None if executor is None else as_workers("measure", executor)
    return measure_shape(shape, RAYS if rays is None else rays, rays is None, seed, progress, workers)


def measure_shape(
    shape: Shape, rays: int, by_form: bool, seed: int, progress: Progress | None, workers: Workers | None = None
) -> Measures:
    """Return the measures of one shape; `by_form` allows closed forms of Boolean combinations."""
    # Sheets cannot be united: they are measured one by one
    if isinstance(shape, Bulk) and shape.is_sheet:
        return _sheet_measures(shape, rays, by_form, seed, progress, workers)
    shape = _single_shape(shape)
    shared = _shared_form(shape) if by_form and isinstance(shape, Boolean) else None
    if shared is not None:
        moments, area = shared
        if moments is not None and area is not None:
            return _closed_measures(moments, area)
        by_form = moments is not None
    # In units of a power of two, so that all powers of the size stay within float64
    box = shape.cache.get("box") or fitted_box(shape)
    exponent = _exponent(box)
    if exponent:
        shape = shape.scale(2.0**-exponent)
        box = fitted_box(shape)
    return _in_units(_measure_primitives(shape, box, rays, by_form, seed, progress, workers), exponent)


_LEAST_FACTOR = 2.0**-60
"""Under smaller and larger scales, powers of the size may leave float64."""


def _shared_form(shape: Boolean) -> tuple[Moments | None, float | None] | None:
    """Return the closed form of a combination, moved from that without its motion, which its copies share.

    (None, None) where there is none; None where it is not known: under motions that do not keep angles, of unbounded
    and of extreme sizes. User: detectors and lattices of thousands of equal parts; factor: 16 for pipes.
    """
    matrix, cache = shape.motion.matrix, shape.own_cache
    factor = similarity(matrix[:3, :3])
    if factor is None or not _LEAST_FACTOR < factor < 1 / _LEAST_FACTOR:
        return None
    if "form" not in cache:
        # A shape without a motion caches what rays need
        own = shape if shape.motion.is_identity else shape._with_motion(IDENTITY_MOTION)
        try:
            box = own.cache["box"] = fitted_box(own)
        except UnboundedShapeError:
            return None
        if box.is_empty or _exponent(box):
            return None
        cache["form"] = box_grid(own) or closed_region(own, box) or (None, None)
    moments, area = cache["form"]
    if moments is None:
        return None, area and area * factor * factor
    moved = moments.moved(matrix)  # whose determinant would lose digits of the volume
    return Moments(moments.volume * factor**3, moved.centroid, moved.spread), area and area * factor * factor


def _sheet_measures(
    shape: Bulk, rays: int, by_form: bool, seed: int, progress: Progress | None, workers: Workers | None
) -> Measures:
    """Return the measures of many sheets: the sum of their areas, and no volume."""
    parts = [
        measure_shape(shape.single(k), rays, by_form, _own_seed(seed, k), progress, workers) for k in range(len(shape))
    ]
    area, error = math.fsum(part.area for part in parts), math.hypot(*(part.area_error for part in parts))
    return _closed_measures(
        Moments(0.0, np.full(3, np.nan), np.zeros((3, 3))), area, error, sum(part.rays for part in parts)
    )


def _exponent(box: FittedBox) -> int:
    """Return the exponent of the unit, a power of two: 0 but for needles and sizes whose tenth powers leave float64.

    Values are sums of fifth powers of the size, and errors come from their squares. The limits are those of the
    coordinates of rays.
    """
    if box.is_empty or not box.half.any():
        return 0
    sizes = [math.frexp(half)[1] for half in box.half.tolist() if half]
    largest, least = max(sizes), min(sizes)
    if abs(largest) < _PLAIN and least > -4 * _PLAIN:
        return 0
    # A needle has its unit nearer to its thickness
    exponent = largest if largest - least < 3 * _PLAIN else largest - _PLAIN
    return max(-_LARGEST, min(exponent, _LARGEST))


def _in_units(measures: Measures, exponent: int) -> Measures:
    """Return measures in units of 2^exponent as measures in units of 1: exact, or inf or 0 beyond float64."""
    if not exponent:
        return measures

    def times(value: Any, power: int) -> Any:
        """Return a value of a power of lengths in units of 1."""
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
    shape: Shape, box: FittedBox, rays: int, by_form: bool, seed: int, progress: Progress | None,
    workers: Workers | None,
) -> Measures:  # fmt: skip
    """Return the measures of a primitive or a combination: closed forms where they are known, and rays for the rest."""
    nothing = Moments(0.0, np.full(3, np.nan), np.zeros((3, 3)))
    if box.is_empty:
        return _closed_measures(nothing, 0.0)
    # A closed form may give the moments alone: rays then give the area
    moments, area = nothing if shape.is_sheet else closed_moments(shape), closed_area(shape)
    if moments is None:
        found_form = flat_form(shape) or ((box_grid(shape) or closed_region(shape, box)) if by_form else None)
        moments, area = found_form if found_form is not None else (None, area)
    if moments is not None and area is not None:
        return _closed_measures(moments, area)
    box = leaning_box(box)
    found = _sampled_measures(sample_integrals(shape, box, rays, seed, progress, workers), box)
    return found if moments is None else _closed_measures(moments, found.area, found.area_error, found.rays)


def _single_shape(shape: Shape) -> Shape:
    """Return many bodies as their union, and the only operand of a combination for that combination."""
    while isinstance(shape, Boolean) and len(shape.operands) == 1 and not isinstance(shape, Complement):
        inner = shape.operands[0]
        shape = dataclasses.replace(inner, motion=inner.motion.then(shape.motion))
    if not isinstance(shape, Bulk):
        return shape
    if len(shape) == 0:
        # An empty solid
        return Sphere() - Sphere()
    singles: Any = (shape.single(index) for index in range(len(shape)))
    return Union(tuple(dataclasses.replace(one, motion=IDENTITY_MOTION) for one in singles), motion=shape.motion)


def _closed_measures(moments: Moments, area: float, area_error: float = 0.0, rays: int = 0) -> Measures:
    """Return measures with exact moments, and an area that may come from rays."""
    inertia = np.trace(moments.second) * np.eye(3) - moments.second
    none = np.zeros(3), np.zeros((3, 3))
    return measures_of(moments.volume, area, moments.centroid, inertia, 0.0, area_error, *none, rays)


def _sampled_measures(sums: ChordSums, box: FittedBox) -> Measures:
    """Return measures in the world from integrals about the center of the box, errors to first order."""
    values, covariance = sums.values, sums.covariance
    # A volume of 0 has no centroid
    volume, errors = float(values[VOLUME]), np.sqrt(covariance.diagonal())
    if volume <= 0:
        unknown = np.full(3, np.nan), np.zeros((3, 3))
        return measures_of(0.0, values[AREA], *unknown, errors[VOLUME], errors[AREA], *unknown, sums.rays)
    offset = values[FIRST] / volume
    # Derivatives by each integral; the inertia about the centroid does not change with the centroid to first order
    slopes = [_inertia_about(unit, offset, box.axes) for unit in np.eye(len(values))]
    centroid_slopes = np.array([box.axes @ (unit[FIRST] - unit[VOLUME] * offset) for unit in np.eye(len(values))])
    return measures_of(
        volume,
        values[AREA],
        box.center + box.axes @ offset,
        _inertia_about(values, offset, box.axes),
        errors[VOLUME],
        errors[AREA],
        _propagated_errors(centroid_slopes / volume, covariance),
        _propagated_errors(np.array(slopes), covariance),
        sums.rays,
    )


def _inertia_about(values: FloatArray, offset: FloatArray, axes: FloatArray) -> FloatArray:
    """Return the inertia tensor in the world about a fixed point of the box, linear in the integrals."""
    second = np.empty((3, 3))
    for value, (i, j) in zip(values[SECOND], PAIRS, strict=True):
        second[i, j] = second[j, i] = value
    first = values[FIRST]
    # From the box's center to the fixed point, without assuming that this is the centroid
    second += values[VOLUME] * np.outer(offset, offset) - np.outer(first, offset) - np.outer(offset, first)
    turned: FloatArray = axes @ (np.trace(second) * np.eye(3) - second) @ axes.T
    return (turned + turned.T) / 2


def _propagated_errors(slopes: FloatArray, covariance: FloatArray) -> FloatArray:
    """Return the standard errors (...) of linear functions with slopes (11, ...)."""
    variance = np.einsum("i...,ij,j...->...", slopes, covariance, slopes)
    return np.sqrt(np.maximum(variance, 0.0))


def measures_of(
    volume: float, area: float, centroid: FloatArray, inertia: FloatArray,
    volume_error: float, area_error: float, centroid_error: FloatArray, inertia_error: FloatArray, rays: int,
) -> Measures:  # fmt: skip
    """Return measures of Python floats and read-only arrays."""
    for array in (centroid, inertia, centroid_error, inertia_error):
        array.flags.writeable = False
    scalars = float(volume), float(area), float(volume_error), float(area_error)
    return Measures(
        scalars[0], scalars[1], centroid, inertia, scalars[2], scalars[3], centroid_error, inertia_error, rays
    )


# The measures of every body of a scene, and of its materials.

_FEWEST = 10_000
"""Rays at least for each body."""
_LISTED, _NARROW = 50, 28
"""Bodies in the table, and characters of its first column at least."""


@compare_by_value()
@dataclass(frozen=True, eq=False)
class SceneMeasures(Sequence[Measures]):
    """The measures of a scene: a sequence of the `Measures` of each body by its number.

    `found["water"]` has the measures of the material or the body of that name; materials of one name count together. A
    name of a material and of a body that are not the same is a KeyError. Every body counts whole: where bodies overlap,
    the common part counts for each. An unbounded body has NaN throughout, and so has its material.

    Attributes
    ----------
    bodies : tuple of Measures
        By number.
    names : tuple of str or None
        Names of the bodies.
    materials : tuple
        The different materials, as `scene.materials`.
    places : tuple of int
        The place of each body's material in `materials`.
    volume, volume_error : float64 (bodies,)
        Volumes of the bodies and their standard errors.
    by_material : tuple of Measures
        The measures of each material: of all its bodies together.
    """

    bodies: tuple[Measures, ...]
    names: tuple[str | None, ...]
    materials: tuple[Any, ...]
    places: tuple[int, ...]

    def __len__(self) -> int:
        return len(self.bodies)

    def __iter__(self) -> Iterator[Measures]:
        return iter(self.bodies)

    def __getitem__(self, index: Any) -> Any:
        """Return the measures of a body by its number or name, of bodies by a slice, or of materials by their name."""
        if isinstance(index, slice):
            return self.bodies[index]
        if not isinstance(index, str):
            return self.bodies[find_body(np.arange(len(self.bodies) + 1), index, "SceneMeasures: a body's number")[0]]
        # Several bodies of one material count together
        numbers = self._body_numbers(index)
        return self.bodies[numbers[0]] if len(numbers) == 1 else combine_measures([self.bodies[i] for i in numbers])

    def _body_numbers(self, name: str) -> list[int]:
        """Return the numbers of the bodies of a name: that of their material, or their own."""
        places = [place for place, m in enumerate(self.materials) if m is not None and m.name == name]
        of_material = [i for i, place in enumerate(self.places) if place in places]
        own = [i for i, body in enumerate(self.names) if body == name]
        # A name is clear if the material and the body are of the same bodies
        if of_material and own and of_material != own:
            raise KeyError(
                f"both a material and a body are called {format_value(name)}: "
                "by_material has materials by their places, "
                "and numbers stand for bodies"
            )
        if places or own:
            return of_material or own
        known = dict.fromkeys([*(m.name for m in self.materials if m is not None), *self.names])
        names = describe_names(name, "names", [one for one in known if one])
        raise KeyError(f"no material and no body is called {format_value(name)}; {names}")

    @property
    def volume(self) -> FloatArray:
        """(bodies,) volumes."""
        return np.array([body.volume for body in self.bodies])

    @property
    def volume_error(self) -> FloatArray:
        """(bodies,) standard errors of the volumes."""
        return np.array([body.volume_error for body in self.bodies])

    @cached_property
    def by_material(self) -> tuple[Measures, ...]:
        """The measures of each material: of all its bodies together."""
        groups: list[list[Measures]] = [[] for _ in self.materials]
        for body, place in zip(self.bodies, self.places, strict=True):
            groups[place].append(body)
        names = [material and material.name for material in self.materials]
        return NameTuple(map(combine_measures, groups), "found.by_material", names=names)

    def __repr__(self) -> str:
        volumes = ", ".join(f"{body.volume:.9g}" for body in self.bodies[:8]) + (", ..." if len(self) > 8 else "")
        return f"SceneMeasures(volumes: {volumes})"

    def _repr_pretty_(self, printer: Any, cycle: bool) -> None:
        """Show the table in a notebook."""
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
        """Return a material in words: its name, and its first body if the name is missing or shared."""
        material = self.materials[place]
        if material is None:
            return "no material"
        of_body = f" of body {self.places.index(place)}"
        if not material.name:
            return f"material{of_body}"
        shared = sum(other is not None and other.name == material.name for other in self.materials) > 1
        return f"material {material.name!r}{of_body if shared else ''}"


def _line(title: str, found: Measures, width: int) -> str:
    """Return a line of the table."""
    error = f"  ± {found.volume_error:.2g}" if found.volume_error > 0 else ""
    volume = "unbounded" if math.isnan(found.volume) else f"{found.volume:.9g}"
    return f"{title:<{width}}{volume:>16}{error}"


def measure_scene(
    scene: SceneLike, rays: int | None, seed: int, progress: Progress | None, executor: Any = None
) -> SceneMeasures:
    """Return the measures of each body. They share the rays, with at least ten thousand for each that needs them."""
    # Every body gets the same number of rays, if it needs any
    share = max(_FEWEST, (RAYS if rays is None else rays) // max(1, scene.body_count))
    bodies = scene[:]
    copies = _rigid_copies(bodies) if rays is None else {}
    found: dict[int, Measures] = {}

    def report(done: int) -> None:
        if progress is not None:
            progress(done, len(bodies))

    def measure_some(numbers: Sequence[int]) -> None:
        """Measure some of the bodies."""
        if not numbers:
            return
        items = [(bodies[number], share, rays is None, _own_seed(seed, number)) for number in numbers]
        if executor is not None:
            before = len(found)
            results = run_on_workers(_measure_bodies, items, executor, lambda done, _: report(before + done))
            found.update(zip(numbers, results, strict=True))
            return
        for number, item in zip(numbers, items, strict=True):
            found[number] = _measure_bodies(*item)
            report(len(found))

    measure_some([number for number in range(len(bodies)) if number not in copies])
    found.update({
        number: _shifted_measures(found[first], offset)
        for number, (first, offset) in copies.items() if not found[first].rays
    })  # fmt: skip
    if len(found) == len(bodies) and copies:
        report(len(found))
    # Copies of what was measured by rays have rays of their own
    measure_some([number for number in copies if number not in found])
    materials = NameTuple(scene.materials, "found.materials")
    places = {material: place for place, material in enumerate(materials)}
    return SceneMeasures(
        tuple(found[number] for number in range(len(bodies))),
        tuple(body.name for body in bodies),
        materials,
        tuple(places[body.material] for body in bodies),
    )


def _rigid_copies(bodies: Sequence[Body]) -> dict[int, tuple[int, FloatArray]]:
    """Return for later copies of a body that a file repeats the number of the first, and the offset from it."""
    kinds: dict[tuple[int, int], tuple[InstanceList, list[tuple[int, int]]]] = {}
    for number, body in enumerate(bodies):
        origin = instance_origin(body)
        if origin is not None:
            instances, place = origin
            key = id(instances), int(instances.kinds[place])
            kinds.setdefault(key, (instances, []))[1].append((number, place))
    copies: dict[int, tuple[int, FloatArray]] = {}
    for (_, kind), (instances, members) in kinds.items():
        if len(members) > 1 and instances.is_rigid(kind):
            shifts = instances.shifts.select(np.array([place for _, place in members]))
            offsets = transform_offsets(shifts.offsets_from(0), instances.motion(kind))
            copies.update({k: (members[0][0], offset) for (k, _), offset in zip(members[1:], offsets[1:], strict=True)})
    return copies


def _shifted_measures(measures: Measures, offset: FloatArray) -> Measures:
    """Return the measures of a copy at an offset."""
    m = measures
    return measures_of(
        m.volume, m.area, m.centroid + offset, m.inertia, m.volume_error, m.area_error, m.centroid_error,
        m.inertia_error, m.rays,
    )  # fmt: skip


def _own_seed(seed: int, number: int) -> int:
    """Return the seed of a body: with rays in common, errors of equal bodies would add up where they cancel."""
    return seed + (number << 64)


def _measure_bodies(body: Body, rays: int, by_form: bool, seed: int) -> Measures:
    """Return the measures of one body; NaN for an unbounded one."""
    try:
        return measure_shape(body.shape, rays, by_form, seed, None)
    except UnboundedShapeError:
        # An unbounded sheet still has no volume
        volume = 0.0 if body.shape.is_sheet else math.nan
        unknown = np.full(3, np.nan), np.full((3, 3), np.nan)
        return measures_of(volume, math.nan, *unknown, volume, math.nan, *unknown, 0)


def combine_measures(parts: Sequence[Measures]) -> Measures:
    """Return the measures of bodies that do not overlap as one body; errors to first order."""
    volume = math.fsum(part.volume for part in parts)
    area = math.fsum(part.area for part in parts)
    rays = sum(part.rays for part in parts)
    # Bodies without volume have no centroid, and do not move the common one
    solid = [part for part in parts if part.volume != 0]
    errors = _root_sum_square(part.volume_error for part in parts), _root_sum_square(part.area_error for part in parts)
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
        # The derivative of volume · way² by the centroid
        slope = 2 * part.volume * np.linalg.norm(way) * np.linalg.norm(part.centroid_error)
        inertia_square += part.inertia_error**2 + (part.volume_error * lever) ** 2 + slope**2
    found = np.sqrt(center_square) / abs(volume), np.sqrt(inertia_square)
    return measures_of(volume, area, np.asarray(center), inertia, *errors, *found, rays)


def _root_sum_square(errors: Iterable[float]) -> float:
    """Return the root of a sum of squares."""
    return math.sqrt(math.fsum(error * error for error in errors))
