"""Tables of rays through a scene, in pieces, with progress: what `conicoid trace` does."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from ..engine.answers.rays import Rays, first_wrong, lines_of
from ..shapes.labels import counted

if TYPE_CHECKING:
    from ..formats.ray_file import RayTable
    from ..scene import Scene

PIECE = 1 << 18
HITS = ("t", "point", "normal", "uv", "body", "face", "surface", "entering")
SPANS = ("t_enter", "t_exit", "body", "enter_clipped", "exit_clipped")

Arrays = dict[str, np.ndarray[Any, Any]]
Progress = Callable[[int, int], Any]


def first_hits(scene: Scene, table: RayTable, progress: Progress) -> Arrays:
    """t, point, normal, uv, body, face, surface and entering of each ray, in the rays' leading shape."""
    rays, t_min, t_max = _flat(table)
    pieces: dict[str, list[Any]] = {name: [] for name in HITS}
    for piece in _pieces(len(rays), progress):
        hits = scene.first_hit(rays[piece], None, t_min[piece], t_max[piece])
        for name in HITS:
            pieces[name].append(getattr(hits, name))
    shape = np.broadcast_shapes(table.origins.shape, table.directions.shape)[:-1]
    joined = {name: np.concatenate(parts) for name, parts in pieces.items()}
    return {name: array.reshape(shape + array.shape[1:]) for name, array in joined.items()}


def spans(scene: Scene, table: RayTable, progress: Progress) -> Arrays:
    """offsets (rays + 1), and the rows of all rays, flattened, one after the other."""
    rays, t_min, t_max = _flat(table)
    counts: list[Any] = [np.zeros(1, np.int64)]
    pieces: dict[str, list[Any]] = {name: [] for name in SPANS}
    for piece in _pieces(len(rays), progress):
        found = scene.spans(rays[piece], None, t_min[piece], t_max[piece])
        counts.append(np.diff(found.offsets))
        for name in SPANS:
            pieces[name].append(getattr(found, name))
    joined = {name: np.concatenate(parts) for name, parts in pieces.items()}
    return {"offsets": np.cumsum(np.concatenate(counts))} | joined


def check(table: RayTable) -> None:
    """Raise ValueError for rays that cannot be traced, before a scene is made ready for them."""
    _flat(table)


def summary(arrays: Arrays) -> str:
    """One line on what was found."""
    if "offsets" in arrays:
        spans, rays = len(arrays["t_enter"]), len(arrays["offsets"]) - 1
        return f"{counted(spans, 'span', 'spans')} of {counted(rays, 'ray', 'rays')}"
    return f"{int((arrays['body'] >= 0).sum()):,} of {counted(arrays['body'].size, 'ray', 'rays')} hit"


def _flat(table: RayTable) -> tuple[Rays, Any, Any]:
    """One row of rays (N, 3) with their intervals (N,)."""
    if table.lines:
        wrong = first_wrong(*map(np.ascontiguousarray, (table.origins, table.directions)))
        if wrong is not None:
            raise ValueError(f"{table.source}: {table.lines[wrong[0]]}: {wrong[1]}")
    try:
        rays = Rays(table.origins, table.directions) if table.starts is None else _spawned(table)
    except ValueError as error:
        raise ValueError(f"{table.source}: {error}" if table.source else str(error)) from None
    shape = rays.shape
    try:
        t_min, t_max = (np.broadcast_to(t, shape).reshape(-1) for t in (table.t_min, table.t_max))
    except ValueError:
        found = f"{np.shape(table.t_min)} and {np.shape(table.t_max)}"
        raise ValueError(f"t_min and t_max must broadcast to the rays' shape {shape}, got {found}") from None
    origins, directions = lines_of(rays)
    return Rays._spawned(origins, directions, rays._starts, rays._home), t_min, t_max


def _spawned(table: RayTable) -> Rays:
    """Rays that start on surfaces, as `Rays.save` keeps them."""
    from ..formats.answer_file import RAYS, rays_in

    return rays_in({name: getattr(table, name) for name in RAYS if getattr(table, name) is not None})


def _pieces(count: int, progress: Progress) -> Iterator[slice]:
    """Slices of range(count), at least one; `progress` is called after each."""
    for begin in range(0, max(count, 1), PIECE):
        yield slice(begin, begin + PIECE)
        progress(min(begin + PIECE, count), max(count, 1))
