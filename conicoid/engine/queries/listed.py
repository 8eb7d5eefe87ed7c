"""Spans and crossings of arrays of rays: traced in chunks, put together in the rays' order."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..arrays.crossing_arrays import trace_rows
from ..arrays.listed import Listed, _Piece
from ..certified.settle import settled_rows
from ..ray import RayArrays
from ..tables import Geometry
from ..threads import chunk_of_rays, run_on

if TYPE_CHECKING:
    from ..prepared import Prepared

_PACKETS = 64


def listed(scene: Prepared, rays: RayArrays, width: int, packets: int, spans: bool) -> Listed:
    """All spans, or crossings, of some packets of rays; `width`: see `packet_row` of packets/load.py."""
    count = len(rays.origins)
    counts, doubts = np.zeros(count, np.int32), np.zeros(count, np.int8)
    offsets, pieces = np.zeros(count + 1, np.int64), []

    def work(geometry: Geometry, begin: int, end: int) -> None:
        """Trace some packets, and keep their rows as a piece."""
        rows = trace_rows(geometry, rays, width, spans, begin, end, counts, doubts)
        pieces.append(_Piece(rows, counts, offsets[:-1], width, begin, end))

    run_on(scene.geometry, work, packets, chunk_of_rays(scene.geometry, packets, _PACKETS, count), count)
    doubtful = np.flatnonzero(doubts)
    if not len(doubtful):
        np.cumsum(counts, out=offsets[1:])
        return Listed(offsets, pieces)
    settled = settled_rows(scene, rays, doubtful, spans)
    own = np.array([len(rows) for rows in settled], np.int32)
    every = counts.copy()
    every[doubtful] = own
    np.cumsum(every, out=offsets[1:])
    last = _Piece(np.concatenate(settled), own, offsets[doubtful], 0, 0, -(-len(doubtful) // 64))
    return Listed(offsets, [*pieces, last])
