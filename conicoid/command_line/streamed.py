"""`conicoid trace --chunk`: files of rays that memory does not hold, and results that are gone on with after a stop."""

from __future__ import annotations

import hashlib
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..cluster.recipe import recipe_of
from ..cluster.task import edition
from ..engine.answers.rays import Rays
from ..engine.answers.spans import Spans
from ..formats.hits_file import ROWS, heads_of, rows_of
from ..formats.ray_file import hit_columns, is_npz, lines_of_columns, span_columns
from ..formats.ray_stream import RayStream
from ..formats.result_parts import ResultParts
from ..shapes.labels import counted
from .ray_tables import HITS, SPANS

if TYPE_CHECKING:
    from ..engine.answers.hits import Hits
    from ..scene import Scene
    from .terminal import Bar

_TEXT = "lines"


def trace(
    scene: Scene, rays: Path, output: Path, spans: bool, chunk: int, resume: bool, executor: Any, bar: Bar
) -> str:
    """Trace a file of rays in chunks; returns one line on what was found."""
    stream = RayStream(rays)
    arrays = is_npz(output)
    if arrays and spans:
        raise ValueError(f"{output}: spans of chunks are written as .csv")
    parts = ResultParts(output, _key(scene, rays, spans, arrays), resume)
    total = None if stream.shape is None else int(np.prod(stream.shape))
    query = "spans" if spans else "first_hit"

    def keep(answer: Hits | Spans) -> None:
        """Add the answers to some rays."""
        found = len(answer.body) if isinstance(answer, Spans) else int((answer.body >= 0).sum())
        rows = {_TEXT: _text(answer, parts.rays)} if isinstance(answer, Spans) or not arrays else _rows(answer)
        parts.add(rows, len(answer), found)
        bar(parts.rays, max(parts.rays, total or 0))

    for answer in scene.stream(stream.pieces(chunk, parts.rays), query, chunk=chunk, executor=executor):
        keep(answer)
    none = Rays(np.zeros((0, 3)), np.zeros((0, 3)))
    if not parts.rays:
        keep(getattr(scene, query)(none))
    told = counted(parts.rays, "ray", "rays")
    if not arrays:
        parts.finish_text(_TEXT)
        return f"{counted(parts.found, 'span', 'spans')} of {told}" if spans else f"{parts.found:,} of {told} hit"
    labels = scene.prepared.labels.of_only(np.unique(parts.column("body")))
    parts.finish_arrays(stream.shape or (parts.rays,), ("starts",), heads_of(none, scene.prepared.key, labels))
    return f"{parts.found:,} of {told} hit"


def _rows(hits: Hits) -> dict[str, Any]:
    """All that `hits.save` writes of each ray."""
    rows = rows_of(hits.detached())
    return {name: np.broadcast_to(rows[name], hits.shape) if name == "starts" else rows[name] for name in ROWS}


def _text(answer: Hits | Spans, first: int) -> bytes:
    """Lines of a .csv file, with its heading where they are the first."""
    spans = isinstance(answer, Spans)
    arrays = {name: getattr(answer, name) for name in (("offsets", *SPANS) if spans else HITS)}
    lines = lines_of_columns(span_columns(arrays, first) if spans else hit_columns(arrays))
    heading = next(lines)
    return ("" if first else heading).encode() + "".join(lines).encode()


def _key(scene: Scene, rays: Path, spans: bool, arrays: bool) -> str:
    """What the results depend on: the scene, the file of rays as it is, the question, and the version."""
    state = os.stat(rays)
    told = f"{state.st_size} {state.st_mtime_ns} {spans} {arrays} {edition()}"
    return hashlib.blake2b(recipe_of(scene).key + told.encode(), digest_size=16).hexdigest()
