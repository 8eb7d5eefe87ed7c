"""Queries of more rays than memory holds: one part after the other, the parts in order."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..engine.answers.lazy_rays import ArrayRays, LazyRays
from ..engine.answers.rays import Rays
from ..engine.answers.spans import Crossings, Spans
from ..engine.queries.queries import refuse_no_rays
from ..formats.ray_stream import RayStream, TimedRays
from ..shapes.carried import aligned
from ..shapes.suggestion import one_of
from ..shapes.usual import END, START
from ..shapes.validate import path as checked_path
from ..shapes.validate import what
from . import queries
from .course import Course, Piece, closing
from .pace import Pace
from .rays import Asked, Share
from .recipe import Recipe, recipe_of
from .task import prepared_first
from .workers import Workers

if TYPE_CHECKING:
    from ..scene import Scene

QUERIES = ("first_hit", "occluded", "spans", "crossings", "lengths", "line_integral")
_LEAST, _MOST = 4096, 1 << 20
_READ = 1 << 18  # rays that are read from a file at a time
_LIMITS = START, END


@prepared_first
def _part(scene: Scene, query: str, options: dict[str, Any], share: Share) -> Any:
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
        raise TypeError(f"stream: query must be the name of one, got {what(query)}; {told}")
    one_of("stream", "query", query, QUERIES)
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
    answers = _streamed(scene, _sources(rays), query, options, limits, workers)
    if out is None:
        return answers
    from .filed import file_answers

    return file_answers(scene, query, Path(checked_path("stream", out, "out")), shape, home, answers, options)


def _streamed(
    scene: Scene, sources: Iterator[Any], query: str, options: dict[str, Any], limits: tuple[Any, Any],
    workers: Workers,
) -> Iterator[Any]:  # fmt: skip
    pace = Pace(workers.chunk, _LEAST, _MOST, workers.count)

    def pieces() -> Iterator[Piece]:
        for source in sources:
            rays, *own = source if isinstance(source, TimedRays) else (source, None, None)
            ends = (limit if end is None else end for end, limit in zip(own, limits, strict=True))
            asked = Asked(query, rays, None, *ends)
            pace.most = max(1, min(_MOST, workers.most_bytes // asked.bytes_each))
            for a, b in pace.pieces(0, asked.count, max(1, 8 * asked.width)):
                yield Piece(a, b, (asked.share(a, b),))

    recipes = recipe_of(scene), Recipe(query), Recipe(options)
    with closing(Course("stream", workers, _part, recipes).results(pieces(), pace.saw, 0)) as results:
        for _, value in results:
            yield _whole(scene, query, value)


def _whole(scene: Scene, query: str, value: Any) -> Any:
    """An answer as the query gives it, with the scene of the one who asked."""
    if not isinstance(value, tuple):
        return value
    from ..engine.answers.hits import Hits
    from ..engine.arrays.found import Found

    kind, share, *rest = value
    if kind == "hits":
        return Hits(scene.prepared, share.made(), Found(*map(aligned, rest[0])), rest[1])
    offsets, columns = rest
    kept = [aligned(column) for column in columns]
    made = share.made()
    if query == "spans":
        return queries.lists_of(Spans, scene, made, aligned(offsets), kept)
    return queries.lists_of(Crossings, scene, made, aligned(offsets), kept)


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
        raise TypeError(f"stream: rays must be Rays, arrays or an iterable of such, got {what(rays)}")
