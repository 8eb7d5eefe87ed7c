"""Rays, points and intervals cut into the shares of tasks."""

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
from ..queries.id_arrays import as_id_array, number_fields
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
"""Bytes of a ray that is sent as numbers."""


class RayShare(NamedTuple):
    """Some of the flat rays as they travel, with their intervals."""

    rays: Rays | LazyRays
    begin: int
    end: int
    shape: tuple[int, ...]
    t_min: Any
    t_max: Any

    def made(self) -> Rays:
        """The rays of the share, in its shape."""
        if isinstance(self.rays, Rays):
            return self.rays
        return self.rays.part(self.begin, self.end, self.shape)


class RayRequest:
    """The rays of a question and their intervals, as a user gave them."""

    def __init__(self, query: str, origins: Any, directions: Any, t_min: Any, t_max: Any) -> None:
        lazy = isinstance(origins, LazyRays) and directions is None
        self.rays: Rays | LazyRays = origins if lazy else as_rays(query, origins, directions)
        first, last = self.rays.interval if isinstance(self.rays, LazyRays) else (t_min, t_max)
        self.t_min: FloatArray = limits_of(query, self.rays, "t_min", replace_default(first, t_min))
        self.t_max: FloatArray = limits_of(query, self.rays, "t_max", replace_default(last, t_max))

    @property
    def shape(self) -> tuple[int, ...]:
        return self.rays.shape

    @property
    def count(self) -> int:
        return math.prod(self.shape)

    @property
    def bytes_each(self) -> int:
        """That are sent for a ray."""
        ends = 8 * ((len(self.t_min) > 1) + (len(self.t_max) > 1))
        return ends + (1 if isinstance(self.rays, LazyRays) else RAY_BYTES)

    @property
    def width(self) -> int:
        """Rays in a row, where they make a picture."""
        return self.shape[-1] if len(self.shape) > 1 else 0

    def share(self, begin: int, end: int) -> RayShare:
        """Flat rays `begin` to `end`; whole rows of a picture stay one."""
        width, count = self.width, end - begin
        rows = width > 0 and begin % width == 0 == count % width
        shape = (count // width, width) if rows else (count,)
        limits = (_cut(t, begin, end, shape) for t in (self.t_min, self.t_max))
        if isinstance(self.rays, LazyRays):
            source, first, last = self.rays._share(begin, end)
            return RayShare(source, first, last, shape, *limits)
        origins, directions = (lines[begin:end].reshape((*shape, 3)) for lines in lines_of(self.rays))
        starts = self.rays._starts
        some = starts[begin:end] if len(starts) > 1 else starts
        return RayShare(Rays._spawned(origins, directions, some, self.rays._home), 0, count, shape, *limits)

    def made(self) -> Rays:
        """All rays."""
        return self.rays.made() if isinstance(self.rays, LazyRays) else self.rays


def _cut(limits: FloatArray, begin: int, end: int, shape: tuple[int, ...]) -> Any:
    return limits[begin:end].reshape(shape) if len(limits) > 1 else float(limits[0])


# The queries of a scene in parts, on workers or here, put together to the answers that are given at once.
#
# Each ray's answer is its own: it depends neither on the rays beside it nor on the route it takes, so parts of any size
# make the same answer to the bit.

_LEAST_RAYS = 4096  # rays of a first task: some milliseconds
_MOST_RAYS = 1 << 20  # rays of a task
Lists = TypeVar("Lists", Spans, Crossings)


def workers_of(query: str, executor: Any, progress: Progress | None = None) -> Workers:
    """Those of an `executor=`; for None this process, a piece at a time with all threads."""
    return as_workers(query, inline_workers() if executor is None else executor, progress)


def run_parts(
    query: str,
    scene: SceneLike,
    asked: RayRequest,
    workers: Workers,
    call: Callable[..., Any],
    *shared: Any,
    each: int = 32,
) -> Iterator[tuple[int, int, Any]]:
    """(begin, end, call(scene, *shared, share)) for shares of the rays, in order; `each`: bytes of a ray's answer."""
    most = min(_MOST_RAYS, workers.most_bytes // max(asked.bytes_each, each))
    pace = ChunkSize(workers.chunk, _LEAST_RAYS, most, workers.count)
    recipes = (shared_scene(scene), *map(SharedObject, shared))
    step = max(1, 8 * asked.width)
    pieces = (ScheduledTask(a, b, (asked.share(a, b),)) for a, b in pace.pieces(0, asked.count, step))
    course = Scheduler(query, workers, call, recipes)
    with cancel_on_exit(course.results(pieces, pace.saw, asked.count)) as results:
        for piece, value in results:
            yield piece.begin, piece.end, value


@prepare_first
def _hits_part(scene: SceneLike, share: RayShare) -> tuple[tuple[Any, ...], Any]:
    hits = ray_queries.first_hit(scene.prepared, share.made(), share.t_min, share.t_max)
    return tuple(map(np.ascontiguousarray, hits._found)), hits._doubtful


def first_hit(scene: SceneLike, asked: RayRequest, executor: Any) -> Hits:
    """`scene.first_hit` in parts."""
    workers = workers_of("first_hit", executor)
    found, doubtful = HitBuffers.new(asked.count), [np.zeros(0, np.int64)]
    for begin, end, (columns, doubts) in run_parts("first_hit", scene, asked, workers, _hits_part):
        for name, part in zip(HitBuffers._fields, columns, strict=True):
            getattr(found, name)[begin:end] = part
        doubtful.append(doubts + begin)
    return Hits(scene.prepared, asked.made(), found, np.concatenate(doubtful))


@prepare_first
def _occluded_part(scene: SceneLike, share: RayShare) -> Any:
    return np.asarray(ray_queries.occluded(scene.prepared, share.made(), share.t_min, share.t_max)).ravel()


def occluded(scene: SceneLike, asked: RayRequest, executor: Any) -> Any:
    """`scene.occluded` in parts."""
    result = np.zeros(asked.count, np.bool_)
    for begin, end, part in run_parts(
        "occluded", scene, asked, workers_of("occluded", executor), _occluded_part, each=1
    ):
        result[begin:end] = part
    return result.reshape(asked.shape)[()]


@prepare_first
def _spans_part(scene: SceneLike, share: RayShare) -> Any:
    return _columns(ray_queries.spans(scene.prepared, share.made(), share.t_min, share.t_max))


@prepare_first
def _crossings_part(scene: SceneLike, share: RayShare) -> Any:
    return _columns(ray_queries.crossings(scene.prepared, share.made(), share.t_min, share.t_max))


def _columns(lists: Spans | Crossings) -> tuple[Any, ...]:
    """How many rows each ray has, and their columns."""
    return np.diff(lists.offsets), *(getattr(lists, name) for name in lists._columns)


def spans(scene: SceneLike, asked: RayRequest, executor: Any) -> Spans:
    """`scene.spans` in parts."""
    return _lists("spans", Spans, scene, asked, executor, _spans_part)


def crossings(scene: SceneLike, asked: RayRequest, executor: Any) -> Crossings:
    """`scene.crossings` in parts."""
    return _lists("crossings", Crossings, scene, asked, executor, _crossings_part)


def _lists(
    query: str, kind: type[Lists], scene: SceneLike, asked: RayRequest, executor: Any, call: Callable[..., Any]
) -> Lists:
    """Rows of all rays, one part after the other."""
    pieces = [_columns(_empty_lists(kind, scene))]  # which have the types
    workers = workers_of(query, executor)
    pieces += [value for _, _, value in run_parts(query, scene, asked, workers, call, each=256)]
    counts, *columns = (np.concatenate(column, axis=-1) for column in zip(*pieces, strict=True))
    return lists_of(kind, scene, asked.made(), np.concatenate([[0], np.cumsum(counts)]), columns)


def _empty_lists(kind: type[Lists], scene: SceneLike) -> Any:
    """The rows of no rays."""
    ask = ray_queries.spans if kind is Spans else ray_queries.crossings
    return ask(scene.prepared, ray_queries.as_rays("lists", np.zeros((0, 3)), np.zeros((0, 3))), 0.0, 1.0)


def lists_of(kind: type[Lists], scene: SceneLike, rays: Rays, offsets: Any, columns: Any) -> Lists:
    """Spans or crossings of a scene from their columns."""
    nothing, result = _empty_lists(kind, scene), object.__new__(kind)
    vars(result).update(vars(nothing), offsets=offsets.astype(nothing.offsets.dtype), _rays=rays)
    vars(result).update(zip(kind._columns, columns, strict=True))
    freeze_arrays(result)
    vars(result).update(number_fields(vars(result)))
    return result


@prepare_first
def _lengths_part(scene: SceneLike, options: tuple[Any, Any], share: RayShare) -> Any:
    by, overlaps = options
    found = line_integrals.lengths(scene.prepared, share.made(), share.t_min, share.t_max, by, None, overlaps)
    return found.reshape(-1, found.shape[-1])


def lengths(
    scene: SceneLike, asked: RayRequest, by: Any, overlaps: Any, executor: Any, progress: Progress | None
) -> Any:
    """`scene.lengths` in parts."""
    prepared = scene.prepared
    count = prepared.lowered.body_count if check_by("lengths", by) == BODY else len(prepared.labels.distinct)
    refuse_large_lengths(asked.count, count, by)
    workers, result = workers_of("lengths", executor, progress), np.zeros((asked.count, count))
    for begin, end, part in run_parts("lengths", scene, asked, workers, _lengths_part, (by, overlaps), each=8 * count):
        result[begin:end] = part
    return result.reshape((*asked.shape, count))


@prepare_first
def _integral_part(scene: SceneLike, options: tuple[Any, Any, Any], share: RayShare) -> Any:
    (values, otherwise, overlaps), made = options, share.made()
    found = np.asarray(
        line_integrals.line_integral(scene.prepared, values, made, share.t_min, share.t_max, otherwise, None, overlaps)
    )
    return found.reshape(-1, *found.shape[len(made.shape) :])


def integral_parts(
    scene: SceneLike, values: Any, asked: RayRequest, options: tuple[Any, Any], executor: Any, progress: Progress | None
) -> tuple[tuple[int, ...], Iterator[tuple[int, int, Any]]]:
    """(what follows the rays' shape, parts) of `scene.line_integral`; options are `otherwise` and `overlaps`."""
    prepared, otherwise = scene.prepared, options[0]
    last = weights_of(values, otherwise, prepared.lowered.body_count, prepared.labels.distinct).shape
    workers = workers_of("line_integral", executor, progress)
    each = 8 * int(np.prod(last))
    return last, run_parts("line_integral", scene, asked, workers, _integral_part, (values, *options), each=each)


def line_integral(
    scene: SceneLike, values: Any, asked: RayRequest, options: tuple[Any, Any], executor: Any, progress: Progress | None
) -> Any:
    """`scene.line_integral` in parts; options as for `integral_parts`."""
    last, found = integral_parts(scene, values, asked, options, executor, progress)
    result = np.zeros((asked.count, *last))
    for begin, end, part in found:
        result[begin:end] = part
    return result.reshape((*asked.shape, *last))[()]


@prepare_first
def _bodies_part(scene: SceneLike, points: Any, after: Any) -> Any:
    return at_points.first_after(scene.prepared, points, after)


def body_at(
    scene: SceneLike, points: Any, executor: Any, owner: str = "body_at", after: Any = at_points.BEFORE_FIRST
) -> Any:
    """`scene.body_at` in parts; of each point the first body after a number, or after one number for all."""
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
    return as_id_array("body", result.reshape(shape)[()])


def bodies_at(scene: SceneLike, points: Any, executor: Any) -> BodiesAt:
    """`scene.bodies_at` in parts."""
    return at_points.bodies_at(
        scene.prepared, points, lambda some, after: body_at(scene, some, executor, "bodies_at", after)
    )


@prepare_first
def _distances_part(scene: SceneLike, exact: bool, points: Any, reach: Any) -> Any:
    return tuple((distances.exact_distances if exact else distances.distance_bounds)(scene.prepared, points, reach))


def distance(
    scene: SceneLike, points: Any, max_distance: Any, exact: bool, executor: Any, progress: Progress | None
) -> Distances:
    """`scene.distance` in parts."""
    flat, shape = at_points.points_of("distance", points)
    reach = distances.reach_of(max_distance, shape)
    workers, found = workers_of("distance", executor, progress), Nearest.nothing(len(flat))
    pace = ChunkSize(workers.chunk, _LEAST_RAYS // 16, min(_MOST_RAYS, workers.most_bytes // 96), workers.count)
    pieces = (ScheduledTask(a, b, (flat[a:b], reach[a:b])) for a, b in pace.pieces(0, len(flat)))
    course = Scheduler("distance", workers, _distances_part, (shared_scene(scene), SharedObject(exact)))
    with cancel_on_exit(course.results(pieces, pace.saw, len(flat))) as results:
        for piece, columns in results:
            for name, part in zip(Nearest._fields, columns, strict=True):
                getattr(found, name)[piece.begin : piece.end] = part
    return Distances(scene.prepared, flat.reshape((*shape, 3)), found)


# Where a question goes that is not for this process alone: to workers, to Dask's arrays, or through here in parts.


def is_dask(thing: Any) -> bool:
    """Is it an array of Dask, or one of its lazy collections?"""
    return is_dask_array(thing)


def dispatch_rays(
    scene: Any, query: str, executor: Any, origins: Any, directions: Any, t_min: Any, t_max: Any, *more: Any
) -> Any:
    """The answer to a query of rays; `more` are what it takes beyond rays and interval."""
    if any(map(is_dask, (origins, directions, t_min, t_max))):
        from . import dask_arrays

        _no_executor(query, executor)
        return dask_arrays.lazy_ray_query(scene, query, origins, directions, t_min, t_max, *more)

    asked = RayRequest(query, origins, directions, t_min, t_max)
    if query == "lengths":
        by, overlaps, progress = more
        return lengths(scene, asked, by, overlaps, executor, progress)
    if query == "line_integral":
        values, otherwise, overlaps, progress = more
        return line_integral(scene, values, asked, (otherwise, overlaps), executor, progress)
    simple: dict[str, Any] = {
        "first_hit": first_hit, "occluded": occluded, "spans": spans,
        "crossings": crossings,
    }  # fmt: skip
    return simple[query](scene, asked, executor)


def dispatch_points(scene: Any, query: str, executor: Any, points: Any) -> Any:
    """The answer to a query of points."""
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
    found = body_at(scene, points, executor, query)
    return found if query == "body_at" else (found >= 0)


def dispatch_distances(scene: Any, executor: Any, points: Any, max_distance: Any, exact: bool, progress: Any) -> Any:
    """Distances of points."""
    if is_dask(points) or hasattr(points, "_share"):
        raise TypeError(f"distance: points must be an array (..., 3) that is at hand, got {describe_kind(points)}")

    return distance(scene, points, max_distance, exact, executor, progress)


def _no_executor(query: str, executor: Any) -> None:
    if executor is not None:
        raise TypeError(f"{query}: executor must be left out for Dask's arrays: their own scheduler computes them")


# Shares of voxels in parts, on workers: columns of voxels are the pieces.

_LEAST_COLUMNS, _MOST_COLUMNS = 16, 1 << 16  # columns of a task


@prepare_first
def _columns_part(scene: SceneLike, options: tuple[Any, ...], begin: int, end: int) -> Any:
    frame, axis, samples, groups, count, voxels = options
    return columns_here(scene.prepared, ColumnGrid(frame, axis, samples), groups, count, voxels, begin, end)


def column_shares(
    scene: SceneLike, grid: ColumnGrid, groups: Any, count: int, voxels: int, which: tuple[int, int], executor: Any,
    progress: Progress | None,
) -> tuple[FloatArray, FloatArray]:  # fmt: skip
    """`engine.queries.columns.columns` of the columns from which[0] to which[1], in parts."""
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
