"""`scene.stream`: queries of more rays than memory holds, one part after the other, in order."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .._util.names import check_choice
from .._util.validation import DEFAULT_T_MAX, DEFAULT_T_MIN, check_integer, describe_kind
from .._util.validation import check_path as checked_path
from ..io.ray_file import RayFile, TimedRays
from ..queries.ray_queries import refuse_no_rays
from ..queries.rays import ArrayRays, LazyRays, Rays
from .queries import RayRequest, answer_part, assemble, ray_chunks, ray_tasks, workers_of
from .scheduler import ScheduledTask, run_tasks
from .shared_state import SharedObject, shared_scene
from .workers import Workers

if TYPE_CHECKING:
    from ..queries.scene_protocol import SceneLike

QUERIES = ("first_hit", "occluded", "spans", "crossings", "lengths", "line_integral")
"""The queries of `scene.stream`."""
_READ = 1 << 18  # rays to read from a file at a time
_LIMITS = DEFAULT_T_MIN, DEFAULT_T_MAX


def stream(
    scene: Any, rays: Any, query: str, chunk: int | None, executor: Any, out: Any, options: dict[str, Any]
) -> Any:
    """Run `scene.stream`."""
    if not isinstance(query, str):
        hint = "rays are one argument: stream(co.Rays(origins, directions)), or (origins, directions) in brackets"
        raise TypeError(f"stream: query must be the name of a query, got {describe_kind(query)}; {hint}")
    check_choice("stream", "query", query, QUERIES)
    refuse_no_rays("stream", rays)
    if query == "line_integral" and "values" not in options:
        raise TypeError("stream: line_integral needs values=")
    limits = options.pop("t_min", _LIMITS[0]), options.pop("t_max", _LIMITS[1])
    base = workers_of("stream", executor)
    # The user's workers keep their own size of tasks
    workers = base if chunk is None else base.changed(chunk=check_integer("stream", "chunk", chunk, 1))
    if isinstance(rays, str | os.PathLike):
        # The file's own interval must not conflict with an explicit one.
        file = RayFile(rays)
        file.check_limits(*(None if limit == usual else limit for limit, usual in zip(limits, _LIMITS, strict=True)))
        rays, shape, home = file.pieces(workers.chunk or _READ), file.shape, file.home
    else:
        shape = rays.shape if isinstance(rays, Rays | LazyRays) else None
        home = rays._home if isinstance(rays, Rays) else None
    answers = _iterate_answers(scene, _sources(rays), query, options, limits, workers)
    if out is None:
        return answers
    from .result_writer import result_writer, write_answers

    writer = result_writer(scene, query, Path(checked_path("stream", out, "out")), options)
    write_answers(writer, answers, shape, home)
    return writer.parts.rays


def _iterate_answers(
    scene: SceneLike, sources: Iterator[Any], query: str, options: dict[str, Any], limits: tuple[Any, Any],
    workers: Workers,
) -> Iterator[Any]:  # fmt: skip
    """Yield the answers to all parts, in order."""
    pace = ray_chunks(workers, 1)

    def pieces() -> Iterator[ScheduledTask]:
        for source in sources:
            rays, *own_limits = source if isinstance(source, TimedRays) else (source, None, None)
            ends = (limit if end is None else end for end, limit in zip(own_limits, limits, strict=True))
            request = RayRequest(query, rays, None, *ends)
            # Rays of each source may have another size.
            pace.most = ray_chunks(workers, request.bytes_each).most
            yield from ray_tasks(query, request, pace)

    shared = shared_scene(scene), SharedObject(options)
    with run_tasks("stream", workers, answer_part, shared, pieces(), pace.saw) as results:
        for task, columns in results:
            yield assemble(scene, query, task.arguments[1].to_rays(), columns)


def _sources(rays: Any) -> Iterator[Rays | LazyRays | TimedRays]:
    """Yield the parts of the user's rays, each with a length."""
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
