"""Queries of rays, points and voxels in parts, on workers or in this process, and their whole answers.

Each ray's answer depends neither on the rays beside it nor on the route that it takes. So parts of any size give the
same answer, to the bit.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterator
from typing import Any, NamedTuple, TypeVar

import numpy as np

from .._util.arrays import FloatArray
from .._util.records import align_array, freeze_arrays
from .._util.validation import describe_kind, is_dask_array, replace_default
from ..kernels.first_hits import HitBuffers
from ..kernels.threads import Progress
from ..queries import points as at_points, points as distances, ray_queries
from ..queries.device_choice import device_of
from ..queries.hits import Hits
from ..queries.line_integrals import trailing_axes
from ..queries.points import BodiesAt, Distances, Nearest
from ..queries.ray_queries import as_rays, limits_of
from ..queries.rays import LazyRays, Rays, lines_of
from ..queries.scene_protocol import SceneLike
from ..queries.spans import Crossings, Spans, refuse_large_lengths
from ..queries.voxel_columns import ColumnGrid, voxel_shares as columns_here
from .shared_state import SharedObject, shared_scene
from .workers import ChunkSize, ScheduledTask, Workers, as_workers, inline_workers, prepare_first, run_tasks

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

    def to_rays(self) -> Rays:
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

    def share(self, begin: int, end: int, travels: bool = True) -> RayShare:
        """Return the flat rays `begin` to `end`; whole rows of a picture keep two axes.

        A share that travels to another process takes its part of lazy rays with it.
        """
        width, count = self.width, end - begin
        # Whole rows keep the two axes of a picture.
        rows = width > 0 and begin % width == 0 == count % width
        shape = (count // width, width) if rows else (count,)
        limits = (_cut(t, begin, end, shape) for t in (self.t_min, self.t_max))
        if isinstance(self.rays, LazyRays):
            source, first, last = self.rays._share(begin, end) if travels else (self.rays, begin, end)
            return RayShare(source, first, last, shape, *limits)
        origins, directions = (lines[begin:end].reshape((*shape, 3)) for lines in lines_of(self.rays))
        # One start surface stands for all rays if there is only one.
        starts = self.rays._starts
        some = starts[begin:end] if len(starts) > 1 else starts
        return RayShare(Rays._spawned(origins, directions, some, self.rays._home), 0, count, shape, *limits)

    def to_rays(self) -> Rays:
        """Return all rays."""
        return self.rays.to_rays() if isinstance(self.rays, LazyRays) else self.rays


def _cut(limits: FloatArray, begin: int, end: int, shape: tuple[int, ...]) -> Any:
    """Return the interval ends of some rays; one number stands for all."""
    return limits[begin:end].reshape(shape) if len(limits) > 1 else float(limits[0])


# Queries of rays in parts: one function that runs on a worker, and one that puts an answer together here.

_LEAST_RAYS = 4096  # rays of a first task: some milliseconds
_HERE_RAYS = 1 << 16  # the same in this process, where all threads share it
_MOST_RAYS = 1 << 20  # rays of a task
_LISTS: dict[str, Any] = dict(spans=Spans, crossings=Crossings)
Lists = TypeVar("Lists", Spans, Crossings)


def workers_of(query: str, executor: Any, progress: Progress | None = None) -> Workers:
    """Return the workers of an `executor=`; for None this process, one piece at a time with all threads."""
    return as_workers(query, inline_workers() if executor is None else executor, progress)


def ray_chunks(workers: Workers, bytes_each: int) -> ChunkSize:
    """Return sizes of tasks of rays, if so many bytes of each travel."""
    least = _HERE_RAYS if getattr(workers.executor, "is_here", False) else _LEAST_RAYS
    return ChunkSize(workers.chunk, least, min(_MOST_RAYS, workers.most_bytes // bytes_each), workers.count)


def ray_tasks(query: str, request: RayRequest, pace: ChunkSize, travel: bool = True) -> Iterator[ScheduledTask]:
    """Yield a task of `answer_part` for each share of the rays; of a picture multiples of eight rows, if large."""
    pieces = pace.pieces(0, request.count, max(1, 8 * request.width))
    return (ScheduledTask(a, b, (query, request.share(a, b, travel))) for a, b in pieces)


@prepare_first
def answer_part(scene: SceneLike, options: dict[str, Any], query: str, share: RayShare) -> tuple[Any, ...]:
    """Return the columns of the answer to a share, without scene and rays, which `assemble` adds again."""
    # A copy: the task may run in this process, which uses the options again.
    rays, options = share.to_rays(), dict(options)
    values = (options.pop("values"),) if query == "line_integral" else ()
    answer = getattr(scene, query)(*values, rays, None, share.t_min, share.t_max, **options)
    if query == "first_hit":
        # Copies have no unused memory.
        return *(column.copy() for column in answer._buffers), answer._doubtful
    if query in _LISTS:
        return np.diff(answer.offsets), *(getattr(answer, name) for name in answer._columns)
    return (answer.reshape(-1, *answer.shape[len(rays.shape) :]),)


def assemble(scene: SceneLike, query: str, rays: Rays, columns: tuple[Any, ...]) -> Any:
    """Return an answer in the form of the query, with the scene of this process."""
    aligned = tuple(map(align_array, columns))
    if query == "first_hit":
        *found, doubtful = aligned
        return Hits(scene._prepared, rays, HitBuffers(*found), doubtful)
    if query in _LISTS:
        counts, *rows = aligned
        return _lists_of(_LISTS[query], scene, rays, np.concatenate([[0], np.cumsum(counts)]), rows)
    return aligned[0].reshape(*rays.shape, *aligned[0].shape[1:])


def _lists_of(kind: type[Lists], scene: SceneLike, rays: Rays, offsets: Any, columns: list[Any]) -> Lists:
    """Make spans or crossings of a scene from their columns."""
    empty, result = _empty_lists(kind, scene), object.__new__(kind)
    vars(result).update(vars(empty), offsets=offsets.astype(empty.offsets.dtype), _rays=rays)
    vars(result).update(zip(kind._columns, columns, strict=True))
    freeze_arrays(result)
    return result


def _empty_lists(kind: type[Lists], scene: SceneLike) -> Any:
    """Return the spans or crossings of no rays."""
    query = ray_queries.spans if kind is Spans else ray_queries.crossings
    return query(scene._prepared, ray_queries.as_rays("lists", np.zeros((0, 3)), np.zeros((0, 3))), 0.0, 1.0)


@contextlib.contextmanager
def answer_parts(
    scene: SceneLike, query: str, request: RayRequest, options: dict[str, Any], workers: Workers, bytes_each: int
) -> Iterator[Iterator[tuple[ScheduledTask, tuple[Any, ...]]]]:
    """Yield each task with its columns, in order. `bytes_each` is the number of bytes of a ray's answer."""
    pace = ray_chunks(workers, max(request.bytes_each, bytes_each))
    tasks = ray_tasks(query, request, pace, not getattr(workers.executor, "is_here", False))
    shared = shared_scene(scene), SharedObject(options)
    with run_tasks(query, workers, answer_part, shared, tasks, pace.saw, request.count) as results:
        yield results


def value_parts(
    scene: SceneLike, query: str, request: RayRequest, options: dict[str, Any], workers: Workers
) -> Iterator[tuple[int, int, Any]]:
    """Yield (begin, end, values) of shares of the flat rays, in order."""
    each = max(1, 8 * math.prod(trailing_axes(scene._prepared, query, options))) if query != "occluded" else 1
    with answer_parts(scene, query, request, options, workers, each) as results:
        for task, (values,) in results:
            yield task.begin, task.end, values


def _values(scene: SceneLike, query: str, request: RayRequest, options: dict[str, Any], workers: Workers) -> Any:
    """Return values of all rays, (...) or (..., columns)."""
    trailing = trailing_axes(scene._prepared, query, options)
    if query == "lengths":
        # Before any work: the array could be larger than memory.
        refuse_large_lengths(request.count, trailing[0], options["by"])
    result: Any = np.zeros((request.count, *trailing), np.bool_ if query == "occluded" else np.float64)
    for begin, end, values in value_parts(scene, query, request, options, workers):
        result[begin:end] = values
    return result.reshape((*request.shape, *trailing))[()]


def _hits(scene: SceneLike, request: RayRequest, workers: Workers) -> Hits:
    """Return the first hits of all rays."""
    found, doubtful = HitBuffers.new(request.count), [np.zeros(0, np.int64)]
    with answer_parts(scene, "first_hit", request, {}, workers, 32) as results:
        for task, (*columns, doubts) in results:
            for name, column in zip(HitBuffers._fields, columns, strict=True):
                getattr(found, name)[task.begin : task.end] = column
            doubtful.append(doubts + task.begin)
    return Hits(scene._prepared, request.to_rays(), found, np.concatenate(doubtful))


def _lists(scene: SceneLike, query: str, request: RayRequest, workers: Workers) -> Any:
    """Return the spans or crossings of all rays: the rows of all parts, in the order of the rays."""
    empty = _empty_lists(_LISTS[query], scene)  # its columns have the types, even without any ray
    pieces = [(np.zeros(0, np.int64), *(getattr(empty, name) for name in empty._columns))]
    with answer_parts(scene, query, request, {}, workers, 256) as results:
        pieces += [columns for _, columns in results]
    columns = tuple(np.concatenate(column, axis=-1) for column in zip(*pieces, strict=True))
    return assemble(scene, query, request.to_rays(), columns)


# Points.


@prepare_first
def _bodies_part(scene: SceneLike, points: Any, after: Any) -> Any:
    """Return the first body after `after` at each point of a share."""
    gpu = device_of("body_at", None, len(points) == 1)  # as CONICOID_DEVICE of the worker says
    return at_points.first_after(scene._prepared, points, after, gpu=gpu)


def body_at(
    scene: SceneLike, points: Any, executor: Any, owner: str = "body_at", after: Any = at_points.BEFORE_FIRST
) -> Any:
    """Run `scene.body_at` in parts: of each point the first body after a number, or after one number for all points."""
    flat, shape = at_points.points_of(owner, points)
    workers, result = workers_of(owner, executor), np.empty(len(flat), np.int32)
    pace = ray_chunks(workers, 24)
    tasks = (
        ScheduledTask(a, b, (flat[a:b], after[a:b] if len(after) > 1 else after)) for a, b in pace.pieces(0, len(flat))
    )
    with run_tasks(owner, workers, _bodies_part, (shared_scene(scene),), tasks, pace.saw, len(flat)) as results:
        for task, value in results:
            result[task.begin : task.end] = value
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
    tasks = (ScheduledTask(a, b, (flat[a:b], reach[a:b])) for a, b in pace.pieces(0, len(flat)))
    shared = shared_scene(scene), SharedObject(exact)
    with run_tasks("distance", workers, _distances_part, shared, tasks, pace.saw, len(flat)) as results:
        for task, columns in results:
            for name, part in zip(Nearest._fields, columns, strict=True):
                getattr(nearest, name)[task.begin : task.end] = part
    return Distances(scene._prepared, flat.reshape((*shape, 3)), nearest)


# Dispatch of queries with an executor, with arrays of Dask, or with lazy rays.


def dispatch_rays(
    scene: Any, query: str, executor: Any, origins: Any, directions: Any, t_min: Any, t_max: Any,
    progress: Progress | None = None, **options: Any,
) -> Any:  # fmt: skip
    """Answer a query of rays; `options` are its arguments beyond rays and interval."""
    if any(map(is_dask_array, (origins, directions, t_min, t_max))):
        from . import dask_arrays

        _no_executor(query, executor)
        return dask_arrays.lazy_ray_query(scene, query, origins, directions, t_min, t_max, options)
    request = RayRequest(query, origins, directions, t_min, t_max)
    workers = workers_of(query, executor, progress)
    if query == "first_hit":
        return _hits(scene, request, workers)
    if query in _LISTS:
        return _lists(scene, query, request, workers)
    return _values(scene, query, request, options, workers)


def dispatch_points(scene: Any, query: str, executor: Any, points: Any) -> Any:
    """Answer a query of points."""
    if is_dask_array(points) and query == "bodies_at":
        raise TypeError(
            f"{query}: points must be an array of NumPy's, got {describe_kind(points)}; body_at takes Dask's"
        )
    if is_dask_array(points):
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
    if is_dask_array(points) or hasattr(points, "_share"):
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
    most = min(_MOST_COLUMNS, max(1, workers.most_bytes // (16 * count * voxels)))
    pace = ChunkSize(workers.chunk, _LEAST_COLUMNS, most, workers.count)
    shared = shared_scene(scene), SharedObject((*grid, groups, count, voxels))
    tasks = (ScheduledTask(a, b, (first + a, first + b)) for a, b in pace.pieces(0, total))
    shares, bounds = np.empty((2, total, count, voxels))
    with run_tasks("voxels", workers, _columns_part, shared, tasks, pace.saw, total) as results:
        for task, (share, bound) in results:
            shares[task.begin : task.end], bounds[task.begin : task.end] = share, bound
    return shares, bounds
