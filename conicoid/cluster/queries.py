"""The queries of a scene in parts, on workers or here, put together to the answers that are given at once.

Each ray's answer is its own: it depends neither on the rays beside it nor on the route it takes, so parts of any size
make the same answer to the bit.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from ..engine.answers.bodies_at import BodiesAt
from ..engine.answers.distances import Distances, Nearest
from ..engine.answers.hits import Hits
from ..engine.answers.no_names import numbered, numbers_of
from ..engine.answers.spans import Crossings, Spans, refuse_large
from ..engine.answers.weights import BODY, checked_by, weights_of
from ..engine.arrays.found import Found
from ..engine.queries import distances, integrals, queries
from ..engine.queries import points as at_points
from ..shapes.carried import read_only
from .course import Course, Piece, closing
from .here import here
from .pace import Pace
from .rays import Asked, Share
from .recipe import Recipe, recipe_of
from .task import prepared_first
from .workers import Workers, as_workers

if TYPE_CHECKING:
    from ..engine.answers.rays import Rays
    from ..engine.threads import Progress
    from ..scene import Scene

_LEAST = 4096  # rays of a first task: some milliseconds
_MOST = 1 << 20  # rays of a task
Lists = TypeVar("Lists", Spans, Crossings)


def workers_of(query: str, executor: Any, progress: Progress | None = None) -> Workers:
    """Those of an `executor=`; for None this process, a piece at a time with all threads."""
    return as_workers(query, here() if executor is None else executor, progress)


def parts(
    query: str, scene: Scene, asked: Asked, workers: Workers, call: Callable[..., Any], *shared: Any, each: int = 32
) -> Iterator[tuple[int, int, Any]]:
    """(begin, end, call(scene, *shared, share)) for shares of the rays, in order; `each`: bytes of a ray's answer."""
    most = min(_MOST, workers.most_bytes // max(asked.bytes_each, each))
    pace = Pace(workers.chunk, _LEAST, most, workers.count)
    recipes = (recipe_of(scene), *map(Recipe, shared))
    step = max(1, 8 * asked.width)
    pieces = (Piece(a, b, (asked.share(a, b),)) for a, b in pace.pieces(0, asked.count, step))
    course = Course(query, workers, call, recipes)
    with closing(course.results(pieces, pace.saw, asked.count)) as results:
        for piece, value in results:
            yield piece.begin, piece.end, value


@prepared_first
def _hits_part(scene: Scene, share: Share) -> tuple[tuple[Any, ...], Any]:
    hits = queries.first_hit(scene.prepared, share.made(), share.t_min, share.t_max)
    return tuple(map(np.ascontiguousarray, hits._found)), hits._doubtful


def first_hit(scene: Scene, asked: Asked, executor: Any) -> Hits:
    """`scene.first_hit` in parts."""
    workers = workers_of("first_hit", executor)
    found, doubtful = Found.new(asked.count), [np.zeros(0, np.int64)]
    for begin, end, (columns, doubts) in parts("first_hit", scene, asked, workers, _hits_part):
        for name, part in zip(Found._fields, columns, strict=True):
            getattr(found, name)[begin:end] = part
        doubtful.append(doubts + begin)
    return Hits(scene.prepared, asked.made(), found, np.concatenate(doubtful))


@prepared_first
def _occluded_part(scene: Scene, share: Share) -> Any:
    return np.asarray(queries.occluded(scene.prepared, share.made(), share.t_min, share.t_max)).ravel()


def occluded(scene: Scene, asked: Asked, executor: Any) -> Any:
    """`scene.occluded` in parts."""
    result = np.zeros(asked.count, np.bool_)
    for begin, end, part in parts("occluded", scene, asked, workers_of("occluded", executor), _occluded_part, each=1):
        result[begin:end] = part
    return result.reshape(asked.shape)[()]


@prepared_first
def _spans_part(scene: Scene, share: Share) -> Any:
    return _columns(queries.spans(scene.prepared, share.made(), share.t_min, share.t_max))


@prepared_first
def _crossings_part(scene: Scene, share: Share) -> Any:
    return _columns(queries.crossings(scene.prepared, share.made(), share.t_min, share.t_max))


def _columns(lists: Spans | Crossings) -> tuple[Any, ...]:
    """How many rows each ray has, and their columns."""
    return np.diff(lists.offsets), *(getattr(lists, name) for name in lists._columns)


def spans(scene: Scene, asked: Asked, executor: Any) -> Spans:
    """`scene.spans` in parts."""
    return _lists("spans", Spans, scene, asked, executor, _spans_part)


def crossings(scene: Scene, asked: Asked, executor: Any) -> Crossings:
    """`scene.crossings` in parts."""
    return _lists("crossings", Crossings, scene, asked, executor, _crossings_part)


def _lists(query: str, kind: type[Lists], scene: Scene, asked: Asked, executor: Any, call: Callable[..., Any]) -> Lists:
    """Rows of all rays, one part after the other."""
    pieces = [_columns(_none(kind, scene))]  # which have the types
    workers = workers_of(query, executor)
    pieces += [value for _, _, value in parts(query, scene, asked, workers, call, each=256)]
    counts, *columns = (np.concatenate(column, axis=-1) for column in zip(*pieces, strict=True))
    return lists_of(kind, scene, asked.made(), np.concatenate([[0], np.cumsum(counts)]), columns)


def _none(kind: type[Lists], scene: Scene) -> Any:
    """The rows of no rays."""
    ask = queries.spans if kind is Spans else queries.crossings
    return ask(scene.prepared, queries.as_rays("lists", np.zeros((0, 3)), np.zeros((0, 3))), 0.0, 1.0)


def lists_of(kind: type[Lists], scene: Scene, rays: Rays, offsets: Any, columns: Any) -> Lists:
    """Spans or crossings of a scene from their columns."""
    nothing, result = _none(kind, scene), object.__new__(kind)
    vars(result).update(vars(nothing), offsets=offsets.astype(nothing.offsets.dtype), _rays=rays)
    vars(result).update(zip(kind._columns, columns, strict=True))
    read_only(result)
    vars(result).update(numbered(vars(result)))
    return result


@prepared_first
def _lengths_part(scene: Scene, options: tuple[Any, Any], share: Share) -> Any:
    by, overlaps = options
    found = integrals.lengths(scene.prepared, share.made(), share.t_min, share.t_max, by, None, overlaps)
    return found.reshape(-1, found.shape[-1])


def lengths(scene: Scene, asked: Asked, by: Any, overlaps: Any, executor: Any, progress: Progress | None) -> Any:
    """`scene.lengths` in parts."""
    prepared = scene.prepared
    count = prepared.lowered.body_count if checked_by("lengths", by) == BODY else len(prepared.labels.distinct)
    refuse_large(asked.count, count, by)
    workers, result = workers_of("lengths", executor, progress), np.zeros((asked.count, count))
    for begin, end, part in parts("lengths", scene, asked, workers, _lengths_part, (by, overlaps), each=8 * count):
        result[begin:end] = part
    return result.reshape((*asked.shape, count))


@prepared_first
def _integral_part(scene: Scene, options: tuple[Any, Any, Any], share: Share) -> Any:
    (values, otherwise, overlaps), made = options, share.made()
    found = np.asarray(
        integrals.line_integral(scene.prepared, values, made, share.t_min, share.t_max, otherwise, None, overlaps)
    )
    return found.reshape(-1, *found.shape[len(made.shape) :])


def integral_parts(
    scene: Scene, values: Any, asked: Asked, options: tuple[Any, Any], executor: Any, progress: Progress | None
) -> tuple[tuple[int, ...], Iterator[tuple[int, int, Any]]]:
    """(what follows the rays' shape, parts) of `scene.line_integral`; options are `otherwise` and `overlaps`."""
    prepared, otherwise = scene.prepared, options[0]
    last = weights_of(values, otherwise, prepared.lowered.body_count, prepared.labels.distinct).shape
    workers = workers_of("line_integral", executor, progress)
    each = 8 * int(np.prod(last))
    return last, parts("line_integral", scene, asked, workers, _integral_part, (values, *options), each=each)


def line_integral(
    scene: Scene, values: Any, asked: Asked, options: tuple[Any, Any], executor: Any, progress: Progress | None
) -> Any:
    """`scene.line_integral` in parts; options as for `integral_parts`."""
    last, found = integral_parts(scene, values, asked, options, executor, progress)
    result = np.zeros((asked.count, *last))
    for begin, end, part in found:
        result[begin:end] = part
    return result.reshape((*asked.shape, *last))[()]


@prepared_first
def _bodies_part(scene: Scene, points: Any, after: Any) -> Any:
    return at_points.first_after(scene.prepared, points, after)


def body_at(scene: Scene, points: Any, executor: Any, owner: str = "body_at", after: Any = at_points.FIRST) -> Any:
    """`scene.body_at` in parts; of each point the first body after a number, or after one number for all."""
    flat, shape = at_points.points_of(owner, points)
    workers, result = workers_of(owner, executor), np.empty(len(flat), np.int32)
    pace = Pace(workers.chunk, _LEAST, min(_MOST, workers.most_bytes // 24), workers.count)
    pieces = (Piece(a, b, (flat[a:b], after[a:b] if len(after) > 1 else after)) for a, b in pace.pieces(0, len(flat)))
    course = Course(owner, workers, _bodies_part, (recipe_of(scene),))
    with closing(course.results(pieces, pace.saw, len(flat))) as results:
        for piece, value in results:
            result[piece.begin : piece.end] = value
    return numbers_of("body", result.reshape(shape)[()])


def bodies_at(scene: Scene, points: Any, executor: Any) -> BodiesAt:
    """`scene.bodies_at` in parts."""
    return at_points.bodies_at(
        scene.prepared, points, lambda some, after: body_at(scene, some, executor, "bodies_at", after)
    )


@prepared_first
def _distances_part(scene: Scene, exact: bool, points: Any, reach: Any) -> Any:
    return tuple((distances.nearest if exact else distances.bounded)(scene.prepared, points, reach))


def distance(
    scene: Scene, points: Any, max_distance: Any, exact: bool, executor: Any, progress: Progress | None
) -> Distances:
    """`scene.distance` in parts."""
    flat, shape = at_points.points_of("distance", points)
    reach = distances.reach_of(max_distance, shape)
    workers, found = workers_of("distance", executor, progress), Nearest.nothing(len(flat))
    pace = Pace(workers.chunk, _LEAST // 16, min(_MOST, workers.most_bytes // 96), workers.count)
    pieces = (Piece(a, b, (flat[a:b], reach[a:b])) for a, b in pace.pieces(0, len(flat)))
    course = Course("distance", workers, _distances_part, (recipe_of(scene), Recipe(exact)))
    with closing(course.results(pieces, pace.saw, len(flat))) as results:
        for piece, columns in results:
            for name, part in zip(Nearest._fields, columns, strict=True):
                getattr(found, name)[piece.begin : piece.end] = part
    return Distances(scene.prepared, flat.reshape((*shape, 3)), found)
