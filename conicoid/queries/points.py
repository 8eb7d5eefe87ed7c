"""Queries at points: the first body, all bodies (`BodiesAt`), and distances from the nearest walls (`Distances`)."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import cached_property
from itertools import chain
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from .._jit.decorators import kernel
from .._util.arrays import FloatArray, ignore_fp_errors
from .._util.text import format_count
from .._util.validation import LARGEST, format_value, real_array, zero_negligible
from ..geometry.labels import Labels
from ..kernels.closest.nearest_walls import nearest_walls
from ..kernels.closest.neighbourhood import MOST_IN_DOUBT
from ..kernels.closest.safety import bounds_of_points
from ..kernels.tables import Floats, Ints, Signs
from ..kernels.threads import KernelRange, Progress, chunk_of_rays, chunk_size, run_on, run_rows
from ..prepare.prepared_scene import PreparedScene, exact_form
from .device_choice import device_of
from .exact.doubtful_rays import resolve_bodies
from .exact.membership import locate_packets
from .hit_fields import faces_of, normals_of
from .rays import packet_progress, packets_of, points_array
from .result import NO_SCENE, QueryResult, ShapedRecord, check_parts, common_scene_state, format_body, format_field

if TYPE_CHECKING:
    from .device import Device


class BodiesAt:
    """The bodies that contain each point, in listing order. Those of point i are body[offsets[i]:offsets[i + 1]].

    `Scene.bodies_at` makes it. It is a sequence over points, numbered in C order: x[i] has the bodies of one point.

    Parameters
    ----------
    offsets : int64 (points + 1,)
        The first row of each point.
    body : int32 (n,)
        Numbers of bodies.
    shape : tuple of int
        The leading shape of the points.
    labels : Labels
        Names and materials of the scene's bodies.
    """

    def __init__(self, offsets: Any, body: npt.NDArray[np.int32], shape: tuple[int, ...], labels: Labels) -> None:
        self.offsets, self.shape, self._labels = offsets, shape, labels
        for array in (offsets, body):
            array.setflags(write=False)
        self.body: Any = body

    @property
    def counts(self) -> Any:
        """int64 (...): the number of bodies that contain each point."""
        return np.diff(self.offsets).reshape(self.shape)[()]

    @property
    def name(self) -> Any:
        """object (n,): the name of each of `body`, or None."""
        return self._labels.names_of(self.body)

    @property
    def material(self) -> Any:
        """object (n,): the material of each of `body`, or None."""
        return self._labels.materials_of(self.body)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, BodiesAt):
            return NotImplemented
        return (
            self.shape == other.shape
            and np.array_equal(self.offsets, other.offsets)
            and np.array_equal(self.body, other.body)
        )

    __hash__ = None  # type: ignore[assignment]

    def __len__(self) -> int:
        return len(self.offsets) - 1

    def __getitem__(self, point: int) -> npt.NDArray[np.int32]:
        number = range(len(self))[point]
        return self.body[self.offsets[number] : self.offsets[number + 1]]

    def __iter__(self) -> Iterator[npt.NDArray[np.int32]]:
        return (self[i] for i in range(len(self)))

    def __repr__(self) -> str:
        return f"BodiesAt(shape={self.shape}, {format_count(len(self.body), 'body', 'bodies')})"


# Queries on arrays of points, in packets of 64

_CHUNK = 64  # packets that a thread takes at a time
_LEAST = 16  # rows and columns of a picture, from which on its squares are packets
BEFORE_FIRST = np.full(1, -1, np.int32)
"""The number before all bodies, so that `first_after` returns the first body."""


def points_of(owner: str, points: npt.ArrayLike) -> tuple[FloatArray, tuple[int, ...]]:
    """Return points as kernels take them, (n, 3), and their leading shape. Raise ValueError for invalid points."""
    array = points_array(owner, "points", points)
    flat = np.ascontiguousarray(array.reshape(-1, 3))
    outside = np.zeros(1, np.int8)
    run_rows(find_outside_domain, (flat,), len(flat), outside)
    if outside[0]:
        bad = np.flatnonzero(~(np.abs(flat) <= LARGEST).all(axis=1))
        where = [int(i) for i in np.unravel_index(bad[0], array.shape[:-1])] if array.ndim > 1 else ""
        found = tuple(flat[bad[0]].tolist())
        raise ValueError(f"{owner}: points{where} must be finite and of magnitude up to {LARGEST:g}, got {found}")
    return flat, array.shape[:-1]


@kernel(points="n 3", begin="0..end", end="0..n", outside="out 1")
def find_outside_domain(points: Floats, begin: int, end: int, outside: Signs) -> None:
    """Set outside[0] if one of the points begin..end is not finite or lies beyond the domain."""
    found = 0
    for i in range(np.uint64(begin), np.uint64(end)):
        for k in range(np.uint64(3)):
            found |= 0 if abs(points[i, k]) <= LARGEST else 1  # NaN is not
    if found != 0:
        outside[0] = 1


def body_at(scene: PreparedScene, points: npt.ArrayLike, owner: str = "body_at", device: str | None = None) -> Any:
    """Return the lowest-numbered body that contains each point, -1 for none; int32 of the points' shape."""
    flat, shape = points_of(owner, points)
    gpu = device_of(owner, device, len(flat) == 1)
    if len(flat) == 1 and scene.lacks_single_calls("body_at"):
        _keep_single_call(scene, "body_at", _body_of_single)
    return first_after(scene, flat, BEFORE_FIRST, width_of(shape), gpu).reshape(shape)[()]


@kernel(x="i", y="j", z="k", begin="0..end", end="0..n", points="out n 3")
def put_grid(x: Floats, y: Floats, z: Floats, begin: int, end: int, points: Floats) -> None:
    """Write points begin..end of a grid, in which z varies fastest."""
    row = begin // max(1, len(z))
    at, j, k = row // max(1, len(y)), row % max(1, len(y)), begin % max(1, len(z))
    for i in range(begin, end):
        if at >= len(x) or j >= len(y) or k >= len(z):
            break
        points[i, 0], points[i, 1], points[i, 2] = x[at], y[j], z[k]
        k += 1
        if k == len(z):
            k, j = 0, j + 1
        if j == len(y):
            j, at = 0, at + 1


@kernel(numbers="n", table="m", begin="0..end", end="0..n", copy="out n", found="out n")
def put_voxels(numbers: Ints, table: Ints, begin: int, end: int, copy: Ints, found: Ints) -> None:
    """Write numbers begin..end, and the items of a table at them, -1 for those beyond it."""
    for i in range(begin, end):
        copy[i] = numbers[i]
        found[i] = table[numbers[i]] if 0 <= numbers[i] < len(table) else -1


def contains(scene: PreparedScene, points: npt.ArrayLike, device: str | None = None) -> Any:
    """Return whether any solid contains each point; bool of the points' shape."""
    bodies = body_at(scene, points, "contains", device)
    if np.size(bodies) == 1 and scene.lacks_single_calls("contains"):
        _keep_single_call(scene, "contains", _is_in_solid)
    return np.asarray(bodies >= 0)[()]  # a scalar for one point


def _keep_single_call(scene: PreparedScene, query: str, answer: Callable[..., Any]) -> None:
    """Let `answer` answer the query of one point from now on, `PreparedScene.keep_single_calls`."""
    point, body, doubts = np.zeros((1, 3)), np.zeros(1, np.int32), np.zeros(1, np.int8)
    arguments = scene.geometry, scene.rest, point, BEFORE_FIRST, 0, 0, 1, body, doubts
    scene.keep_single_calls(query, answer, ("locate_packets", arguments, (point,), (body, doubts)))


def _body_of_single(calls: Sequence[Callable[..., Any]], scene: PreparedScene, point: Any) -> Any:
    """Return the first body that contains a point, -1 for none; None where `body_at` must answer."""
    found = calls[0](point)
    return None if found is None or found[2] else np.int32(found[1])


def _is_in_solid(calls: Sequence[Callable[..., Any]], scene: PreparedScene, point: Any) -> Any:
    """Return whether any solid contains a point; None where `contains` must answer."""
    body = _body_of_single(calls, scene, point)
    return None if body is None else body >= 0


def width_of(shape: tuple[int, ...]) -> int:
    """Return the width of the picture that points of a shape make, or 0."""
    return shape[-1] if len(shape) > 1 and min(shape[-2:]) >= _LEAST else 0


def first_after(scene: PreparedScene, points: FloatArray, after: Any, width: int = 0, gpu: Device | None = None) -> Any:
    """Return the first body with a number above `after` that contains each of the points (n, 3), -1 for none.

    after: (n,), or (1,) for all points. width: of the picture that the points make, or 0.
    """
    count = len(points)
    bodies, doubts = np.empty(count, np.int32), np.empty(count, np.int8)
    if gpu is None or not gpu.run(scene, "first_bodies", (points, after), (bodies, doubts)):
        packets = packets_of(count, width)
        run_on(
            scene.geometry,
            KernelRange(locate_packets, (scene.rest, points, after, width), (bodies, doubts)),
            packets,
            chunk_of_rays(scene.geometry, packets, _CHUNK, count),
            count,
        )
    resolve_bodies(scene, points, after, np.flatnonzero(doubts), bodies)
    return bodies


def bodies_at(
    scene: PreparedScene, points: npt.ArrayLike, query: Callable[[FloatArray, Any], Any] | None = None
) -> BodiesAt:
    """Return all bodies that contain each point.

    query: a function (points, after) with the result of `first_after`, as on workers. Each round finds the next body of
    the points that had one in the round before.
    """
    flat, shape = points_of("bodies_at", points)
    width = width_of(shape)
    first = query or (lambda some, after: first_after(scene, some, after, width if len(some) == len(flat) else 0))
    # Most points lie in few bodies, so that each round has fewer points than the one before
    which, after = np.arange(len(flat)), BEFORE_FIRST
    owners, bodies = [np.zeros(0, np.int64)], [np.zeros(0, np.int32)]
    while len(which):
        found = first(flat[which], after)
        has = found >= 0
        which, after = which[has], np.ascontiguousarray(found[has])
        owners.append(which)
        bodies.append(after)
    owner = np.concatenate(owners)
    # Stable: the bodies of a point were found in rising order
    order = np.argsort(owner, kind="stable")
    offsets = np.concatenate([[0], np.cumsum(np.bincount(owner, minlength=len(flat)))]).astype(np.int64)
    return BodiesAt(offsets, np.concatenate(bodies)[order], shape, scene.labels)


# Distances of points from the nearest walls: the query `distance` and its result `Distances`.


class Nearest(NamedTuple):
    """The nearest wall of each point, as flat arrays that kernels fill."""

    distance: FloatArray  # (n,) signed
    lower: FloatArray
    error: FloatArray
    point: FloatArray  # (n, 3)
    body: npt.NDArray[np.int32]
    entry: npt.NDArray[np.int32]
    place: npt.NDArray[np.int32]
    turn: npt.NDArray[np.int8]

    @classmethod
    def nothing(cls, count: int) -> Nearest:
        """Return arrays without walls: all numbers -1, all points NaN, the distances undefined."""
        distance, lower, error = (np.empty(count) for _ in range(3))
        body, entry, place = (np.full(count, -1, np.int32) for _ in range(3))
        return cls(distance, lower, error, np.full((count, 3), np.nan), body, entry, place, np.ones(count, np.int8))


class Distances(ShapedRecord, QueryResult):
    """Distances of points from the nearest walls, shaped like the points; one point gives scalars. Read-only.

    `scene.distance` makes it. Without `exact=True` it holds bounds, and no nearest walls.

    Attributes
    ----------
    distance : float64 (...)
        Negative inside a solid; -inf or inf if there is no wall, or none within max_distance. A bound, of the size of
        `lower`, unless the query had exact=True.
    lower : float64 (...)
        A certified bound: no wall is nearer.
    error : float64 (...)
        The true distance is in [|distance| - error, |distance| + error]; inf for a bound.
    point, normal : float64 (..., 3)
        The nearest point of a wall, and its unit outward normal; NaN where no wall was searched for or found.
    body, face, surface : int32 (...)
        Numbers of that wall; -1 where no wall was searched for or found.
    name, material : object (...)
        Name and material of that body.
    points : float64 (..., 3)
        The points of the query.
    shape, ndim, size
        Those of `distance`.
    """

    points: FloatArray
    _nearest: Nearest
    _single: bytes  # of one point, see `_of_single`
    _views = ("distance", "lower", "error", "point", "body", "face", "surface", "normal", "_single")

    def __init__(self, scene: PreparedScene, points: FloatArray, found: Nearest) -> None:
        points.flags.writeable = False
        vars(self).update(_scene=scene, points=points, _nearest=found)

    @classmethod
    def _of_single(cls, scene: PreparedScene, point: bytes, bound: float, inside: bool) -> Distances:
        """Return the bound of one point, whose arrays are made when a field needs them."""
        distances = object.__new__(cls)
        distance, lower = np.float64(-bound if inside else bound), np.float64(bound)
        vars(distances).update(_scene=scene, _single=point, distance=distance, lower=lower)
        return distances

    if not TYPE_CHECKING:  # the arrays of a single point are made when a field needs them

        @cached_property
        def points(self) -> FloatArray:
            return np.frombuffer(self._single)

        @cached_property
        def _nearest(self) -> Nearest:
            found = Nearest.nothing(1)
            found.distance[:], found.lower[:] = self.distance, self.lower
            found.error[:] = 0.0 if self.lower == math.inf else math.inf
            return found

    @property
    def shape(self) -> tuple[int, ...]:
        """The leading shape, that of `distance`."""
        return self.points.shape[:-1]

    @cached_property
    def distance(self) -> FloatArray:
        return self._shaped(self._nearest.distance)

    @cached_property
    def lower(self) -> FloatArray:
        return self._shaped(self._nearest.lower)

    @cached_property
    def error(self) -> FloatArray:
        return self._shaped(self._nearest.error)

    @cached_property
    def point(self) -> FloatArray:
        return self._shaped(self._nearest.point, 3)

    @cached_property
    def body(self) -> npt.NDArray[np.int32]:
        return self._shaped(self._nearest.body)

    @cached_property
    def _faces(self) -> Any:
        """int32 (3, n): surface number, face number, side; -1, -1, 0 without a wall."""
        found = self._nearest
        faces = np.empty((3, len(found.distance)), np.int32)
        arguments = (self._scene.geometry, found.entry, found.place, found.turn)
        run_rows(faces_of, arguments, len(found.distance), faces)
        return faces

    @cached_property
    def face(self) -> Any:
        return self._shaped(self._faces[1])

    @cached_property
    def surface(self) -> Any:
        return self._shaped(self._faces[0])

    @cached_property
    @ignore_fp_errors
    def _normals(self) -> FloatArray:
        normals = np.empty_like(self._nearest.point)
        arguments = (self._scene.geometry, self._faces, self._nearest.point)
        run_rows(normals_of, arguments, len(normals), normals)
        return zero_negligible(normals)

    @property
    def normal(self) -> FloatArray:
        return self._shaped(self._normals, 3)

    def __getitem__(self, index: Any) -> Distances:
        """Return the distances that an index or mask over the points' shape selects."""
        rows = np.arange(self.size).reshape(self.shape)[index]
        flat = np.atleast_1d(rows).ravel()
        picked = Distances(self._scene, self.points[index], Nearest(*(array[flat] for array in self._nearest)))
        if self._scene is NO_SCENE:  # `picked` could not compute these again
            vars(picked).update(_faces=self._faces[:, flat], _normals=self._normals[flat])
            vars(picked).update(_home=self._home, _labels=self._labels)
        return picked

    @staticmethod
    def concatenate(parts: Iterable[Distances]) -> Distances:
        """Join distances along the first axis; a single point counts as a row of one.

        Parameters
        ----------
        parts : iterable of Distances
            Distances of one scene, detached or not.

        Raises
        ------
        TypeError
            If a part is not a Distances.
        ValueError
            If `parts` is empty, if shapes differ in another axis than the first, or for different scenes.
        """
        return _concatenate_distances(parts)

    def __repr__(self) -> str:
        if self.shape:
            inside = int((self._nearest.distance < 0.0).sum())
            return f"Distances(shape={self.shape}, {inside:,} of {format_count(self.size, 'point', 'points')} inside)"
        names = (
            ("distance", "error", "point", "normal", "face") if self._nearest.body[0] >= 0 else ("distance", "lower")
        )
        fields = ", ".join(f"{name}={format_field(getattr(self, name))}" for name in names)
        return (
            f"Distances({f'body {format_body(self.body, self.name)}, ' if self._nearest.body[0] >= 0 else ''}{fields})"
        )


def _concatenate_distances(parts: Any) -> Distances:
    """Join distances (see `Distances.concatenate`). They keep their scene if all parts have the same one."""
    given = check_parts(Distances, parts)
    shapes = [part.points.shape if part.shape else (1, 3) for part in given]
    if len({shape[1:] for shape in shapes}) > 1:
        raise ValueError(f"Distances: parts must have one shape but for the first axis, got {shapes[:4]}")
    points = np.concatenate([part.points.reshape(shape) for part, shape in zip(given, shapes, strict=True)])
    found = Nearest(*(np.concatenate(columns) for columns in zip(*(part._nearest for part in given), strict=True)))
    scene = given[0]._scene
    if scene is not NO_SCENE and all(part._scene is scene for part in given):
        return Distances(scene, points, found)
    rows = [part.detached() for part in given]
    state: dict[str, Any] = {"points": points, "_nearest": found, "_home": rows[0]._home}
    state |= common_scene_state(rows, "Distances")
    state["_faces"] = np.concatenate([part._faces for part in rows], axis=1)
    state["_normals"] = np.concatenate([part._normals for part in rows])
    result = object.__new__(Distances)
    result.__setstate__(state)
    return result


# The query: certified bounds for packets of points, or the nearest wall of each point

_NO_SIDES = np.zeros(1, np.int32)
_BOUND_CHUNK, _EXACT_CHUNK = 64, 256  # packets, points


def reach_of(max_distance: npt.ArrayLike, shape: tuple[int, ...]) -> FloatArray:
    """Return `max_distance` for each point, flat. Raise ValueError if it is not positive or does not broadcast."""
    expected = f"a positive number or broadcast to {shape}"
    array = real_array("distance", "max_distance", max_distance, expected)
    try:
        reach = np.broadcast_to(array, shape).ravel()
    except ValueError:
        raise ValueError(f"distance: max_distance must be {expected}, got {format_value(max_distance)}") from None
    bad = np.flatnonzero(~(reach > 0.0))
    if len(bad):
        raise ValueError(f"distance: max_distance must be positive, got {float(reach[bad[0]])!r}")
    return np.ascontiguousarray(reach)


def distance(
    scene: PreparedScene,
    points: npt.ArrayLike,
    max_distance: npt.ArrayLike = math.inf,
    exact: bool = False,
    progress: Progress | None = None,
) -> Distances:
    """Return signed distances of points from the nearest walls; see `Scene.distance` for the arguments."""
    flat, shape = points_of("distance", points)
    reach = reach_of(max_distance, shape)
    found = (
        exact_distances(scene, flat, reach, progress)
        if exact
        else distance_bounds(scene, flat, reach, progress, width_of(shape))
    )
    # After the signs, for which `body_at` keeps a call too
    if len(flat) == 1 and not exact and scene.lacks_single_calls("distance"):
        point, bound = np.zeros((1, 3)), np.zeros(1)
        arguments = scene.geometry, point, np.full(1, math.inf), 0, 0, 1, bound
        scene.keep_single_calls("distance", _bound_of_single, ("bounds_of_points", arguments, (point,), (bound,)))
    return Distances(scene, flat.reshape((*shape, 3)), found)


def _bound_of_single(calls: Sequence[Callable[..., Any]], scene: PreparedScene, point: Any) -> Distances | None:
    """Return the certified bound for a point of plain numbers; None where `distance` must answer."""
    found, body = calls[0](point), scene.single_calls["body_at"](scene, point)
    return None if found is None or body is None else Distances._of_single(scene, found[0], found[1], body >= 0)


def distance_bounds(
    scene: PreparedScene, flat: FloatArray, reach: FloatArray, progress: Progress | None = None, width: int = 0
) -> Nearest:
    """Return certified bounds without walls. width: of the picture that the points make, or 0."""
    count, bounds, gpu = len(flat), np.empty(len(flat)), device_of("distance", None, len(flat) == 1)
    packets = packets_of(count, width)
    if gpu is None or not gpu.run(scene, "wall_bounds", (flat, reach), (bounds,)):
        run_on(
            scene.geometry,
            KernelRange(bounds_of_points, (flat, reach, width), (bounds,)),
            packets,
            chunk_size(packets, _BOUND_CHUNK),
            count,
            progress and packet_progress(progress, packets, count),
        )
    elif progress is not None:
        progress(count, count)
    found = Nearest.nothing(count)
    beyond = ~(bounds < math.inf)
    found.distance[:] = _sign_distances(scene, flat, bounds)
    found.lower[:] = np.where(beyond, reach, bounds)
    # No wall at any distance is exact; a bound says nothing about how far the wall may be
    found.error[:] = np.where(beyond & (reach == math.inf), 0.0, math.inf)
    return found


def exact_distances(
    scene: PreparedScene, flat: FloatArray, reach: FloatArray, progress: Progress | None = None
) -> Nearest:
    """Return the nearest wall of each point, with an error bound."""
    count, found = len(flat), Nearest.nothing(len(flat))
    lower, upper, away = np.empty(count), np.empty(count), np.empty(count)
    doubts = np.empty((count, 1 + MOST_IN_DOUBT), np.int32)
    after: tuple[npt.NDArray[Any], ...] = (found.body, found.entry, found.place, found.turn)
    after = (*after, away, lower, upper, found.point, doubts)
    known = known_sides(scene)
    work = KernelRange(nearest_walls, (flat, reach, known), after)
    run_on(scene.geometry, work, count, chunk_size(count, _EXACT_CHUNK), count, progress)
    while doubts[:, 0].any():
        which = np.flatnonzero(doubts[:, 0])
        learn_sides(scene, doubts[which])
        before, known = known, known_sides(scene)
        if len(known) == len(before):  # it only grows, also by other threads
            break
        again = tuple(array[which] for array in after)
        work = KernelRange(nearest_walls, (flat[which], reach[which], known), again)
        run_on(scene.geometry, work, len(which), chunk_size(len(which), _EXACT_CHUNK), len(which))
        for array, part in zip(after, again, strict=True):
            array[which] = part
    beyond = ~((away <= reach) & (away < math.inf))
    for field in (found.body, found.entry, found.place):
        field[beyond] = -1
    found.point[beyond] = math.nan
    away[beyond], upper[beyond] = math.inf, math.inf
    # A point of a wall that is known less well than the bound may be nearer than that
    near = away.copy()
    away[:] = np.maximum(away, np.minimum(lower, upper))
    found.lower[:] = np.maximum(0.0, np.where(beyond, np.minimum(lower, reach), np.minimum(lower, away)))
    found.distance[:] = _sign_distances(scene, flat, away)
    with np.errstate(invalid="ignore"):
        error = np.maximum(np.maximum(upper - away, away - found.lower), away - near)
        # A difference of numbers that differ by less than half is exact
        error = np.where(error > 0.5 * away, np.nextafter(error, math.inf), error)
    found.error[:] = np.where(beyond, np.where(found.lower == math.inf, 0.0, math.inf), error)
    return found


def known_sides(scene: PreparedScene) -> Ints:
    """Return what is known of sides that occur, as a `Neighbourhood` has it."""
    count, kept = len(scene.sides), vars(scene).get("known_sides", (0, _NO_SIDES))
    if kept[0] != count:
        rows = [  # a copy, since other threads add
            (len(key), len(sides), rank, *key, *sides) for key, (rank, sides) in tuple(scene.sides.items())
        ]
        kept = vars(scene)["known_sides"] = count, np.array([*chain.from_iterable(rows), 0], np.int32)
    found: Ints = kept[1]
    return found


def learn_sides(scene: PreparedScene, doubts: Ints) -> None:
    """Find which sides occur of the surfaces of some rows of doubts, in exact arithmetic, unless they are known."""
    from ..geometry.exact_crossings import common_rank, occurring_sides

    for count, *surfaces in np.unique(doubts, axis=0).tolist():
        key = tuple(sorted(surfaces[:count]))
        if key not in scene.sides:
            forms = [exact_form(scene, surface) for surface in key]
            scene.sides[key] = common_rank(forms), occurring_sides(forms)


def _sign_distances(scene: PreparedScene, flat: FloatArray, distances: FloatArray) -> FloatArray:
    """Return distances with their signs: negative inside any solid."""
    inside = body_at(scene, flat, "distance") >= 0
    return np.where(inside, -distances, distances)
