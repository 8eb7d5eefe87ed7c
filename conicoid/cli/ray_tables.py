"""Trace tables of rays through a scene, in pieces, with progress, as `conicoid trace` and `lengths` do."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from .._util.text import format_count
from ..io.ray_file import HIT_ARRAYS, HIT_ERROR_ARRAYS, SPAN_ARRAYS, SPAN_ERROR_ARRAYS
from ..queries.rays import Rays, find_invalid_ray, lines_of

if TYPE_CHECKING:
    from ..io.ray_file import RayTable
    from ..scene.scene import Scene

PIECE = 1 << 18
"""The number of rays in a piece."""

Arrays = dict[str, np.ndarray[Any, Any]]
Progress = Callable[[int, int], Any]


def first_hits(
    scene: Scene, table: RayTable, progress: Progress, all_fields: bool = False, errors: bool = False
) -> Arrays:
    """Return t, point, normal, uv, body, face, surface and entering of each ray, in the leading shape of the rays.

    all_fields: return all that `hits.save` writes. errors: return `t_error` as well.
    """
    from ..io.result_file import HIT_ROW_FIELDS, hit_head_arrays, hit_row_arrays

    rays, t_min, t_max = _flat(table)
    names = HIT_ROW_FIELDS if all_fields else (*HIT_ARRAYS, *(HIT_ERROR_ARRAYS if errors else ()))
    pieces: dict[str, list[Any]] = {name: [] for name in names}
    for piece in _pieces(len(rays), progress):
        hits = scene.first_hit(rays[piece], None, t_min[piece], t_max[piece])
        rows = hit_row_arrays(hits.detached()) if all_fields else {name: getattr(hits, name) for name in names}
        if "starts" in rows:
            # One start may stand for all rays; pieces are joined row by row
            rows["starts"] = np.broadcast_to(rows["starts"], hits.shape)
        for name, row in rows.items():
            pieces[name].append(row)
    shape = table.shape
    joined = {name: np.concatenate(pieces.pop(name)) for name in names}
    shaped = {name: row if name == "starts" else row.reshape(shape + row.shape[1:]) for name, row in joined.items()}
    prepared = scene._prepared
    return shaped | (hit_head_arrays(rays, prepared.key, prepared.labels.of_only(shaped["body"])) if all_fields else {})


def spans(scene: Scene, table: RayTable, progress: Progress, all_fields: bool = False, errors: bool = False) -> Arrays:
    """Return offsets (rays + 1), and the rows of all rays, flattened, one after the other.

    all_fields: return all that `spans.save` writes. errors: return error bounds of both ends as well.
    """
    rays, t_min, t_max = _flat(table)
    names = (*SPAN_ARRAYS, *(SPAN_ERROR_ARRAYS if errors else ()))
    counts: list[Any] = [np.zeros(1, np.int64)]
    pieces: list[Any] = []
    for piece in _pieces(len(rays), progress):
        part = scene.spans(rays[piece], None, t_min[piece], t_max[piece])
        counts.append(np.diff(part.offsets))
        pieces.append(part.detached() if all_fields else {name: getattr(part, name) for name in names})
    if all_fields:
        from ..io.result_file import encode_lists
        from ..queries.spans import Spans

        return encode_lists(pieces[0] if len(pieces) == 1 else Spans.concatenate(pieces))
    joined = {name: np.concatenate([rows[name] for rows in pieces]) for name in names}
    return {"offsets": np.cumsum(np.concatenate(counts))} | joined


def lengths(scene: Scene, table: RayTable, by: Any, overlaps: Any, progress: Progress) -> Any:
    """Return the length of each ray inside each body or material, (..., columns), in the leading shape of the rays."""
    rays, t_min, t_max = _flat(table)
    result = scene.lengths(rays, None, t_min, t_max, by=by, overlaps=overlaps, progress=progress)
    return result.reshape((*table.shape, *result.shape[1:]))


def line_integrals(
    scene: Scene, table: RayTable, values: Any, otherwise: Any, overlaps: Any, progress: Progress
) -> Any:
    """Return the line integral of each ray, (...) or (..., energies), in the leading shape of the rays."""
    rays, t_min, t_max = _flat(table)
    options = dict(otherwise=otherwise, overlaps=overlaps, progress=progress)
    result = np.asarray(scene.line_integral(values, rays, None, t_min, t_max, **options))
    return result.reshape((*table.shape, *result.shape[1:]))


def check(table: RayTable) -> None:
    """Raise ValueError for rays that cannot be traced, before a scene is prepared for them."""
    _flat(table)


def summary(arrays: Arrays) -> str:
    """Return one line on the results."""
    if "offsets" in arrays:
        spans, rays = len(arrays["t_enter"]), len(arrays["offsets"]) - 1
        return f"{format_count(spans, 'span', 'spans')} of {format_count(rays, 'ray', 'rays')}"
    return f"{int((arrays['body'] >= 0).sum()):,} of {format_count(arrays['body'].size, 'ray', 'rays')} hit"


def _flat(table: RayTable) -> tuple[Rays, Any, Any]:
    """Return one row of rays (N, 3) with their intervals (N,)."""
    if table.lines:  # of a text file: the message names the line
        invalid = find_invalid_ray(*map(np.ascontiguousarray, (table.origins, table.directions)))
        if invalid is not None:
            raise ValueError(f"{table.source}: {table.lines[invalid[0]]}: {invalid[1]}")
    try:
        rays = Rays(table.origins, table.directions) if table.starts is None else _spawned(table)
    except ValueError as error:
        raise ValueError(f"{table.source}: {error}" if table.source else str(error)) from None
    shape = rays.shape
    try:
        t_min, t_max = (np.broadcast_to(t, shape).reshape(-1) for t in (table.t_min, table.t_max))
    except ValueError:
        shapes = f"{np.shape(table.t_min)} and {np.shape(table.t_max)}"
        raise ValueError(f"t_min and t_max must broadcast to the rays' shape {shape}, got {shapes}") from None
    origins, directions = lines_of(rays)
    return Rays._spawned(origins, directions, rays._starts, rays._home), t_min, t_max


def _spawned(table: RayTable) -> Rays:
    """Return rays that start on surfaces, as `Rays.save` writes them."""
    from ..io.result_file import RAY_FIELDS, decode_rays

    return decode_rays({name: getattr(table, name) for name in RAY_FIELDS if getattr(table, name) is not None})


def _pieces(count: int, progress: Progress) -> Iterator[slice]:
    """Yield slices of range(count), at least one; `progress` is called after each."""
    # A piece without rays still gives arrays of the right types and shapes
    for begin in range(0, max(count, 1), PIECE):
        yield slice(begin, begin + PIECE)
        progress(min(begin + PIECE, count), max(count, 1))
