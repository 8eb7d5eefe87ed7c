"""Queries of more rays than memory holds: one part after the other, the parts in order."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .._util.defaults import DEFAULT_T_MAX, DEFAULT_T_MIN
from .._util.hints import check_choice
from .._util.pickling import align_array
from .._util.validation import check_path as checked_path
from .._util.validation import describe_kind
from ..io.ray_stream import RayStream, TimedRays
from ..queries.ray_queries import refuse_no_rays
from ..queries.rays import ArrayRays, LazyRays, Rays
from ..queries.spans import Crossings, Spans
from . import queries
from .queries import RayRequest, RayShare
from .scheduler import ChunkSize, ScheduledTask, Scheduler, cancel_on_exit, prepare_first
from .shared_state import SharedObject, shared_scene
from .workers import Workers

if TYPE_CHECKING:
    from ..queries.scene_protocol import SceneLike

QUERIES = ("first_hit", "occluded", "spans", "crossings", "lengths", "line_integral")
_LEAST, _MOST = 4096, 1 << 20
_READ = 1 << 18  # rays that are read from a file at a time
_LIMITS = DEFAULT_T_MIN, DEFAULT_T_MAX


@prepare_first
def _part(scene: SceneLike, query: str, options: dict[str, Any], share: RayShare) -> Any:
    """The answer to one share, as it travels: without the scene, to whose tables the asker adds it again."""
    made = share.made()
    if query == "line_integral":
        options = dict(options)
        return scene.line_integral(options.pop("values"), made, None, share.t_min, share.t_max, **options)
    found = getattr(scene, query)(made, None, share.t_min, share.t_max, **options)
    if query == "first_hit":
        return "hits", share, tuple(map(_compact, found._found)), found._doubtful
    rows = isinstance(found, Spans | Crossings)
    return ("rows", share, found.offsets, queries._columns(found)[1:]) if rows else found


def stream(
    scene: Any, rays: Any, query: str, chunk: int | None, executor: Any, out: Any, options: dict[str, Any]
) -> Any:
    """`scene.stream`."""
    if not isinstance(query, str):
        told = "rays are one argument: stream(co.Rays(origins, directions)), or (origins, directions) in brackets"
        raise TypeError(f"stream: query must be the name of one, got {describe_kind(query)}; {told}")
    check_choice("stream", "query", query, QUERIES)
    refuse_no_rays("stream", rays)
    if query == "line_integral" and "values" not in options:
        raise TypeError("stream: line_integral needs values=")
    limits = options.pop("t_min", _LIMITS[0]), options.pop("t_max", _LIMITS[1])
    given = queries.workers_of("stream", executor)
    workers = object.__new__(Workers)
    vars(workers).update(vars(given), chunk=Workers(given.executor, chunk=chunk).chunk or given.chunk)
    if isinstance(rays, str | os.PathLike):
        file = RayStream(rays)
        file.check_ends(*(None if limit == usual else limit for limit, usual in zip(limits, _LIMITS, strict=True)))
        rays, shape, home = file.pieces(workers.chunk or _READ), file.shape, file.source.home
    else:
        shape = rays.shape if isinstance(rays, Rays | LazyRays) else None
        home = rays._home if isinstance(rays, Rays) else None
    answers = _iterate_answers(scene, _sources(rays), query, options, limits, workers)
    if out is None:
        return answers
    from .result_writer import write_answers

    return write_answers(scene, query, Path(checked_path("stream", out, "out")), shape, home, answers, options)


def _iterate_answers(
    scene: SceneLike, sources: Iterator[Any], query: str, options: dict[str, Any], limits: tuple[Any, Any],
    workers: Workers,
) -> Iterator[Any]:  # fmt: skip
    pace = ChunkSize(workers.chunk, _LEAST, _MOST, workers.count)

    def pieces() -> Iterator[ScheduledTask]:
        for source in sources:
            rays, *own = source if isinstance(source, TimedRays) else (source, None, None)
            ends = (limit if end is None else end for end, limit in zip(own, limits, strict=True))
            asked = RayRequest(query, rays, None, *ends)
            pace.most = max(1, min(_MOST, workers.most_bytes // asked.bytes_each))
            for a, b in pace.pieces(0, asked.count, max(1, 8 * asked.width)):
                yield ScheduledTask(a, b, (asked.share(a, b),))

    recipes = shared_scene(scene), SharedObject(query), SharedObject(options)
    with cancel_on_exit(Scheduler("stream", workers, _part, recipes).results(pieces(), pace.saw, 0)) as results:
        for _, value in results:
            yield _assemble(scene, query, value)


def _assemble(scene: SceneLike, query: str, value: Any) -> Any:
    """An answer as the query gives it, with the scene of the one who asked."""
    if not isinstance(value, tuple):
        return value
    from ..kernels.entry.first_hits import HitBuffers
    from ..queries.hits import Hits

    kind, share, *rest = value
    if kind == "hits":
        return Hits(scene.prepared, share.made(), HitBuffers(*map(align_array, rest[0])), rest[1])
    offsets, columns = rest
    kept = [align_array(column) for column in columns]
    made = share.made()
    if query == "spans":
        return queries.lists_of(Spans, scene, made, align_array(offsets), kept)
    return queries.lists_of(Crossings, scene, made, align_array(offsets), kept)


def _compact(column: Any) -> Any:
    """An array without the room around it."""
    return column.copy()


def _sources(rays: Any) -> Iterator[Rays | LazyRays | TimedRays]:
    """The parts of what a user has for rays, each with a length."""
    if isinstance(rays, Rays | LazyRays | TimedRays):
        yield rays
    elif isinstance(rays, tuple) and len(rays) == 2 and all(hasattr(part, "shape") for part in rays):
        yield ArrayRays(*rays)
    elif hasattr(rays, "shape") and hasattr(rays, "__getitem__"):
        yield ArrayRays(rays)
    elif isinstance(rays, Iterable) and not isinstance(rays, str | bytes):
        for part in rays:
            yield from _sources(part)
    else:
        raise TypeError(f"stream: rays must be Rays, arrays or an iterable of such, got {describe_kind(rays)}")
