"""Spans and crossings of arrays of rays: traced in chunks, put together in the rays' order."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..geometry.tables import Geometry
from .certain import settled_rows
from .list_kernels import trace_rows
from .rays import Arguments, FloatArray
from .threads import chunk_size, run_chunks, run_on

if TYPE_CHECKING:
    from .queries import Prepared

_PACKETS = 64


@dataclass(frozen=True)
class _Piece:
    """Rows (see lists.py) of packets begin..end of rays that have counts[i] rows each, ray i from offsets[i] on."""

    rows: FloatArray
    counts: Any
    offsets: Any
    width: int
    begin: int
    end: int


@dataclass(frozen=True)
class Listed:
    """The rows of all rays, in pieces; those of ray i are to become offsets[i]:offsets[i + 1]."""

    offsets: Any
    pieces: list[_Piece]

    def put(self, kernel: Callable[..., None], *columns: Any) -> None:
        """Write all rows into columns, by `put_spans` or `put_crossings`, and make these read-only."""

        def work(begin: int, end: int) -> None:
            for p in self.pieces[begin:end]:
                kernel(p.rows, p.counts, p.offsets, p.width, p.begin, p.end, *columns)

        run_chunks(work, len(self.pieces), 1)
        for column in (self.offsets, *columns):
            column.flags.writeable = False


def listed(scene: Prepared, arguments: Arguments, width: int, packets: int, spans: bool) -> Listed:
    """All spans, or crossings, of some packets of rays; `width`: see `bundle.packet_row`."""
    count = len(arguments[0])
    counts, doubts = np.zeros(count, np.int32), np.zeros(count, np.int8)
    offsets, pieces = np.zeros(count + 1, np.int64), []

    def work(geometry: Geometry, begin: int, end: int) -> None:
        rows = trace_rows(geometry, *arguments, width, spans, begin, end, counts, doubts)
        pieces.append(_Piece(rows, counts, offsets, width, begin, end))

    run_on(scene.geometry, work, packets, chunk_size(packets, _PACKETS), count)
    doubtful = np.flatnonzero(doubts)
    if not len(doubtful):
        np.cumsum(counts, out=offsets[1:])
        return Listed(offsets, pieces)
    settled = settled_rows(scene, arguments, doubtful, spans)
    own = np.array([len(rows) for rows in settled], np.int32)
    every = counts.copy()
    every[doubtful] = own
    np.cumsum(every, out=offsets[1:])
    last = _Piece(np.concatenate(settled), own, offsets[doubtful], 0, 0, -(-len(doubtful) // 64))
    return Listed(offsets, [*pieces, last])
