"""Queries of rays, points and voxels in parts, on workers or in this process, and their whole answers.

Each ray's answer depends neither on the rays beside it nor on the route that it takes. So parts of any size give the
same answer, to the bit.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

import numpy as np

from .._util.arrays import FloatArray
from .._util.defaults import replace_default
from .._util.pickling import freeze_arrays
from .._util.validation import describe_kind, is_dask_array
from ..kernels.entry.first_hits import HitBuffers
from ..queries import distances, line_integrals, ray_queries
from ..queries import points as at_points
from ..queries.distances import Distances, Nearest
from ..queries.hits import Hits
from ..queries.points import BodiesAt
from ..queries.ray_queries import as_rays, limits_of
from ..queries.rays import LazyRays, Rays, lines_of
from ..queries.spans import Crossings, Spans, refuse_large_lengths
from ..queries.voxel_columns import ColumnGrid
from ..queries.voxel_columns import voxel_shares as columns_here
from ..queries.weights import BODY, check_by, weights_of
from .scheduler import ChunkSize, ScheduledTask, Scheduler, cancel_on_exit, prepare_first
from .shared_state import SharedObject, shared_scene
from .workers import Workers, as_workers, inline_workers

if TYPE_CHECKING:
    from ..kernels.threads import Progress
    from ..queries.rays import Rays
    from ..queries.scene_protocol import SceneLike


RAY_BYTES = 48
"""Bytes of a ray that travels as numbers."""


class RayShare(NamedTuple):
    """Some of the flat rays in the form that travels, with their intervals."""

    rays: Rays | LazyRays
    begin: int
    end: int
    shape: tuple[int, ...]
    t_min: Any
    t_max: Any

    def made(self) -> Rays:
        """Return the rays of the share, in its shape."""
        if isinstance(self.rays, Rays):
            return self.rays
        return self.rays.part(self.begin, self.end, self.shape)


class RayRequest:
    """The rays of a query and their intervals, from the user's arguments."""

    def __init__(self, query: str, origins: Any, directions: Any, t_min: Any, t_max: Any) -> None:
        lazy = isinstance(origins, LazyRays) and directions is None
        self.rays: Rays | LazyRays = origins if lazy else as_rays(query, origins, directions)
        first, last = self.rays.interval if isinstance(self.rays, LazyRays) else (t_min, t_max)
        self.t_min: FloatArray = limits_of(query, self.rays, "t_min", replace_default(first, t_min))
        self.t_max: FloatArray = limits_of(query, self.rays, "t_max", replace_default(last, t_max))

    @property
    def shape(self) -> tuple[int, ...]:
        """Leading shape of the rays."""
        return self.rays.shape

    @property
    def count(self) -> int:
        """Number of rays."""
        return math.prod(self.shape)

    @property
    def bytes_each(self) -> int:
        """Bytes that travel for each ray."""
        ends = 8 * ((len(self.t_min) > 1) + (len(self.t_max) > 1))
        return ends + (1 if isinstance(self.rays, LazyRays) else RAY_BYTES)

    @property
    def width(self) -> int:
        """Rays in a row of a picture; 0 if the rays are no picture."""
        return self.shape[-1] if len(self.shape) > 1 else 0

    def share(self, begin: int, end: int) -> RayShare:
        """Return the flat rays `begin` to `end`; whole rows of a picture keep two axes."""
        width, count = self.width, end - begin
        # Whole rows keep the two axes of a picture.
        rows = width > 0 and begin % width == 0 == count % width
        shape = (count // width, width) if rows else (count,)
        limits = (_cut(t, begin, end, shape) for t in (self.t_min, self.t_max))
        if isinstance(self.rays, LazyRays):
            source, first, last = self.rays._share(begin, end)
            return RayShare(source, first, last, shape, *limits)
        origins, directions = (lines[begin:end].reshape((*shape, 3)) for lines in lines_of(self.rays))
        # One start surface stands for all rays if there is only one.
        starts = self.rays._starts
        some = starts[begin:end] if len(starts) > 1 else starts
        return RayShare(Rays._spawned(origins, directions, some, self.rays._home), 0, count, shape, *limits)

    def made(self) -> Rays:
        """Return all rays."""
        return self.rays.made() if isinstance(self.rays, LazyRays) else self.rays


def _cut(limits: FloatArray, begin: int, end: int, shape: tuple[int, ...]) -> Any:
    """Return the interval ends of some rays; one number stands for all."""
    return limits[begin:end].reshape(shape) if len(limits) > 1 else float(limits[0])


# Each query in parts: a function that runs on a worker, and one that assembles the whole answer here.

_LEAST_RAYS = 4096  # rays of a first task: some milliseconds
_MOST_RAYS = 1 << 20  # rays of a task
Lists = TypeVar("Lists", Spans, Crossings)


def workers_of(query: str, executor: Any, progress: Progress | None = None) -> Workers:
    """Return the workers of an `executor=`; for None this process, one piece at a time with all threads."""
    return as_workers(query, inline_workers() if executor is None else executor, progress)


def run_parts(
    query: str,
    scene: SceneLike,
    request: RayRequest,
    workers: Workers,
    call: Callable[..., Any],
    *shared: Any,
    each: int = 32,
) -> Iterator[tuple[int, int, Any]]:
    """Yield (begin, end, call(scene, *shared, share)) for shares of the rays, in order.

    `each` is the number of bytes of a ray's answer. Neither a task nor its answer is larger than workers allow.
    """
    most = min(_MOST_RAYS, workers.most_bytes // max(request.bytes_each, each))
    pace = ChunkSize(workers.chunk, _LEAST_RAYS, most, workers.count)
    recipes = (shared_scene(scene), *map(SharedObject, shared))
    # Pieces of a picture are multiples of eight rows, if they are large enough.
    step = max(1, 8 * request.width)
    pieces = (ScheduledTask(a, b, (request.share(a, b),)) for a, b in pace.pieces(0, request.count, step))
    course = Scheduler(query, workers, call, recipes)
    with cancel_on_exit(course.results(pieces, pace.saw, request.count)) as results:
        for piece, value in results:
            yield piece.begin, piece.end, value


@prepare_first
def _hits_part(scene: SceneLike, share: RayShare) -> tuple[tuple[Any, ...], Any]:
    """Return the columns of hits and the doubtful rays of a share, without the scene."""
    hits = ray_queries.first_hit(scene._prepared, share.made(), share.t_min, share.t_max)
    return tuple(map(np.ascontiguousarray, hits._found)), hits._doubtful


def first_hit(scene: SceneLike, request: RayRequest, executor: Any) -> Hits:
    """Run `scene.first_hit` in parts."""
    workers = workers_of("first_hit", executor)
    found, doubtful = HitBuffers.new(request.count), [np.zeros(0, np.int64)]
    for begin, end, (columns, doubts) in run_parts("first_hit", scene, request, workers, _hits_part):
        for name, part in zip(HitBuffers._fields, columns, strict=True):
            getattr(found, name)[begin:end] = part
        doubtful.append(doubts + begin)
    return Hits(scene._prepared, request.made(), found, np.concatenate(doubtful))


@prepare_first
def _occluded_part(scene: SceneLike, share: RayShare) -> Any:
    """Return the flat answer of a share."""
    return np.asarray(ray_queries.occluded(scene._prepared, share.made(), share.t_min, share.t_max)).ravel()


def occluded(scene: SceneLike, request: RayRequest, executor: Any) -> Any:
    """Run `scene.occluded` in parts."""
    result = np.zeros(request.count, np.bool_)
    for begin, end, part in run_parts(
        "occluded", scene, request, workers_of("occluded", executor), _occluded_part, each=1
    ):
        result[begin:end] = part
    return result.reshape(request.shape)[()]


@prepare_first
def _spans_part(scene: SceneLike, share: RayShare) -> Any:
    """Return the columns of spans of a share."""
    return _columns(ray_queries.spans(scene._prepared, share.made(), share.t_min, share.t_max))


@prepare_first
def _crossings_part(scene: SceneLike, share: RayShare) -> Any:
    """Return the columns of crossings of a share."""
    return _columns(ray_queries.crossings(scene._prepared, share.made(), share.t_min, share.t_max))


def _columns(lists: Spans | Crossings) -> tuple[Any, ...]:
    """Return the number of rows of each ray, and the columns of the rows."""
    return np.diff(lists.offsets), *(getattr(lists, name) for name in lists._columns)


def spans(scene: SceneLike, request: RayRequest, executor: Any) -> Spans:
    """Run `scene.spans` in parts."""
    return _lists("spans", Spans, scene, request, executor, _spans_part)


def crossings(scene: SceneLike, request: RayRequest, executor: Any) -> Crossings:
    """Run `scene.crossings` in parts."""
    return _lists("crossings", Crossings, scene, request, executor, _crossings_part)


def _lists(
    query: str, kind: type[Lists], scene: SceneLike, request: RayRequest, executor: Any, call: Callable[..., Any]
) -> Lists:
    """Join the rows of all parts, in the order of the rays."""
    pieces = [_columns(_empty_lists(kind, scene))]  # their columns have the types, even without any ray
    workers = workers_of(query, executor)
    pieces += [value for _, _, value in run_parts(query, scene, request, workers, call, each=256)]
    counts, *columns = (np.concatenate(column, axis=-1) for column in zip(*pieces, strict=True))
    return lists_of(kind, scene, request.made(), np.concatenate([[0], np.cumsum(counts)]), columns)


def _empty_lists(kind: type[Lists], scene: SceneLike) -> Any:
    """Return the spans or crossings of no rays."""
    query = ray_queries.spans if kind is Spans else ray_queries.crossings
    return query(scene._prepared, ray_queries.as_rays("lists", np.zeros((0, 3)), np.zeros((0, 3))), 0.0, 1.0)


def lists_of(kind: type[Lists], scene: SceneLike, rays: Rays, offsets: Any, columns: Any) -> Lists:
    """Make spans or crossings of a scene from their columns."""
    empty, result = _empty_lists(kind, scene), object.__new__(kind)
    vars(result).update(vars(empty), offsets=offsets.astype(empty.offsets.dtype), _rays=rays)
    vars(result).update(zip(kind._columns, columns, strict=True))
    freeze_arrays(result)
    return result


# Sums along rays.


@prepare_first
def _lengths_part(scene: SceneLike, options: tuple[Any, Any], share: RayShare) -> Any:
    """Return the lengths of a share, (rays, bodies or materials)."""
    by, overlaps = options
    values = line_integrals.lengths(scene._prepared, share.made(), share.t_min, share.t_max, by, None, overlaps)
    return values.reshape(-1, values.shape[-1])


def lengths(
    scene: SceneLike, request: RayRequest, by: Any, overlaps: Any, executor: Any, progress: Progress | None
) -> Any:
    """Run `scene.lengths` in parts."""
    prepared = scene._prepared
    count = prepared.lowered.body_count if check_by("lengths", by) == BODY else len(prepared.labels.distinct)
    # Before any work: the array could be larger than memory.
    refuse_large_lengths(request.count, count, by)
    workers, result = workers_of("lengths", executor, progress), np.zeros((request.count, count))
    for begin, end, part in run_parts(
        "lengths", scene, request, workers, _lengths_part, (by, overlaps), each=8 * count
    ):
        result[begin:end] = part
    return result.reshape((*request.shape, count))


@prepare_first
def _integral_part(scene: SceneLike, options: tuple[Any, Any, Any], share: RayShare) -> Any:
    """Return the line integrals of a share, (rays, ...)."""
    (values, otherwise, overlaps), made = options, share.made()
    found = np.asarray(
        line_integrals.line_integral(scene._prepared, values, made, share.t_min, share.t_max, otherwise, None, overlaps)
    )
    return found.reshape(-1, *found.shape[len(made.shape) :])


def integral_parts(
    scene: SceneLike,
    values: Any,
    request: RayRequest,
    options: tuple[Any, Any],
    executor: Any,
    progress: Progress | None,
) -> tuple[tuple[int, ...], Iterator[tuple[int, int, Any]]]:
    """Return the trailing shape of `scene.line_integral` and its parts; options are `otherwise` and `overlaps`."""
    prepared, otherwise = scene._prepared, options[0]
    trailing = weights_of(values, otherwise, prepared.lowered.body_count, prepared.labels.distinct).shape
    workers = workers_of("line_integral", executor, progress)
    each = 8 * int(np.prod(trailing))
    return trailing, run_parts("line_integral", scene, request, workers, _integral_part, (values, *options), each=each)


def line_integral(
    scene: SceneLike,
    values: Any,
    request: RayRequest,
    options: tuple[Any, Any],
    executor: Any,
    progress: Progress | None,
) -> Any:
    """Run `scene.line_integral` in parts; options as for `integral_parts`."""
    trailing, parts = integral_parts(scene, values, request, options, executor, progress)
    result = np.zeros((request.count, *trailing))
    for begin, end, part in parts:
        result[begin:end] = part
    return result.reshape((*request.shape, *trailing))[()]


# Points.


@prepare_first
def _bodies_part(scene: SceneLike, points: Any, after: Any) -> Any:
    """Return the first body after `after` at each point of a share."""
    return at_points.first_after(scene._prepared, points, after)


def body_at(
    scene: SceneLike, points: Any, executor: Any, owner: str = "body_at", after: Any = at_points.BEFORE_FIRST
) -> Any:
    """Run `scene.body_at` in parts: of each point the first body after a number, or after one number for all points."""
    flat, shape = at_points.points_of(owner, points)
    workers, result = workers_of(owner, executor), np.empty(len(flat), np.int32)
    pace = ChunkSize(workers.chunk, _LEAST_RAYS, min(_MOST_RAYS, workers.most_bytes // 24), workers.count)
    pieces = (
        ScheduledTask(a, b, (flat[a:b], after[a:b] if len(after) > 1 else after)) for a, b in pace.pieces(0, len(flat))
    )
    course = Scheduler(owner, workers, _bodies_part, (shared_scene(scene),))
    with cancel_on_exit(course.results(pieces, pace.saw, len(flat))) as results:
        for piece, value in results:
            result[piece.begin : piece.end] = value
    return result.reshape(shape)[()]


def bodies_at(scene: SceneLike, points: Any, executor: Any) -> BodiesAt:
    """Run `scene.bodies_at` in parts."""
    return at_points.bodies_at(
        scene._prepared, points, lambda some, after: body_at(scene, some, executor, "bodies_at", after)
    )


@prepare_first
def _distances_part(scene: SceneLike, exact: bool, points: Any, reach: Any) -> Any:
    """Return the columns of the nearest surfaces of a share of points."""
    return tuple((distances.exact_distances if exact else distances.distance_bounds)(scene._prepared, points, reach))


def distance(
    scene: SceneLike, points: Any, max_distance: Any, exact: bool, executor: Any, progress: Progress | None
) -> Distances:
    """Run `scene.distance` in parts."""
    flat, shape = at_points.points_of("distance", points)
    reach = distances.reach_of(max_distance, shape)
    workers, nearest = workers_of("distance", executor, progress), Nearest.nothing(len(flat))
    pace = ChunkSize(workers.chunk, _LEAST_RAYS // 16, min(_MOST_RAYS, workers.most_bytes // 96), workers.count)
    pieces = (ScheduledTask(a, b, (flat[a:b], reach[a:b])) for a, b in pace.pieces(0, len(flat)))
    course = Scheduler("distance", workers, _distances_part, (shared_scene(scene), SharedObject(exact)))
    with cancel_on_exit(course.results(pieces, pace.saw, len(flat))) as results:
        for piece, columns in results:
            for name, part in zip(Nearest._fields, columns, strict=True):
                getattr(nearest, name)[piece.begin : piece.end] = part
    return Distances(scene._prepared, flat.reshape((*shape, 3)), nearest)


# Dispatch of queries with an executor, with arrays of Dask, or with lazy rays.


def is_dask(thing: Any) -> bool:
    """Return whether a value is an array of Dask, or one of its lazy collections."""
    return is_dask_array(thing)


def dispatch_rays(
    scene: Any, query: str, executor: Any, origins: Any, directions: Any, t_min: Any, t_max: Any, *more: Any
) -> Any:
    """Answer a query of rays; `more` are its arguments beyond rays and interval."""
    if any(map(is_dask, (origins, directions, t_min, t_max))):
        from . import dask_arrays

        _no_executor(query, executor)
        return dask_arrays.lazy_ray_query(scene, query, origins, directions, t_min, t_max, *more)

    request = RayRequest(query, origins, directions, t_min, t_max)
    if query == "lengths":
        by, overlaps, progress = more
        return lengths(scene, request, by, overlaps, executor, progress)
    if query == "line_integral":
        values, otherwise, overlaps, progress = more
        return line_integral(scene, values, request, (otherwise, overlaps), executor, progress)
    simple: dict[str, Any] = {
        "first_hit": first_hit, "occluded": occluded, "spans": spans,
        "crossings": crossings,
    }  # fmt: skip
    return simple[query](scene, request, executor)


def dispatch_points(scene: Any, query: str, executor: Any, points: Any) -> Any:
    """Answer a query of points."""
    if is_dask(points) and query == "bodies_at":
        raise TypeError(
            f"{query}: points must be an array of NumPy's, got {describe_kind(points)}; body_at takes Dask's"
        )
    if is_dask(points):
        from . import dask_arrays

        _no_executor(query, executor)
        return dask_arrays.lazy_point_query(scene, query, points)
    if hasattr(points, "_share"):
        raise TypeError(f"{query}: points must be an array (..., 3), got {describe_kind(points)}")

    if query == "bodies_at":
        return bodies_at(scene, points, executor)
    bodies = body_at(scene, points, executor, query)
    return bodies if query == "body_at" else (bodies >= 0)


def dispatch_distances(scene: Any, executor: Any, points: Any, max_distance: Any, exact: bool, progress: Any) -> Any:
    """Answer a query of distances."""
    if is_dask(points) or hasattr(points, "_share"):
        raise TypeError(f"distance: points must be an array (..., 3) in memory, got {describe_kind(points)}")

    return distance(scene, points, max_distance, exact, executor, progress)


def _no_executor(query: str, executor: Any) -> None:
    """Raise TypeError if there is an executor beside arrays of Dask."""
    if executor is not None:
        raise TypeError(f"{query}: executor must be left out for Dask's arrays: their own scheduler computes them")


# Shares of voxels in parts: the pieces are columns of voxels.

_LEAST_COLUMNS, _MOST_COLUMNS = 16, 1 << 16  # columns of a task


@prepare_first
def _columns_part(scene: SceneLike, options: tuple[Any, ...], begin: int, end: int) -> Any:
    """Return shares and bounds of some columns of voxels."""
    frame, axis, samples, groups, count, voxels = options
    return columns_here(scene._prepared, ColumnGrid(frame, axis, samples), groups, count, voxels, begin, end)


def column_shares(
    scene: SceneLike, grid: ColumnGrid, groups: Any, count: int, voxels: int, which: tuple[int, int], executor: Any,
    progress: Progress | None,
) -> tuple[FloatArray, FloatArray]:  # fmt: skip
    """Run `voxel_shares` in parts, for the columns of voxels from which[0] to which[1]."""
    first, total = which[0], which[1] - which[0]
    workers = workers_of("voxels", executor, progress)
    pace = ChunkSize(
        workers.chunk,
        _LEAST_COLUMNS,
        min(_MOST_COLUMNS, max(1, workers.most_bytes // (16 * count * voxels))),
        workers.count,
    )
    shared = SharedObject((*grid, groups, count, voxels))
    pieces = (ScheduledTask(a, b, (first + a, first + b)) for a, b in pace.pieces(0, total))
    shares, bounds = np.empty((2, total, count, voxels))
    course = Scheduler("voxels", workers, _columns_part, (shared_scene(scene), shared))
    with cancel_on_exit(course.results(pieces, pace.saw, total)) as results:
        for piece, (share, bound) in results:
            shares[piece.begin : piece.end], bounds[piece.begin : piece.end] = share, bound
    return shares, bounds
