"""Rows of all crossings or spans of many rays, in pieces as they were traced."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ...shapes.vector import FloatArray
from ..threads import run_chunks

if TYPE_CHECKING:
    pass


@dataclass(frozen=True)
class _Piece:
    """Rows (body/crossing_rows.py) of packets begin..end of rays with counts[i] rows each, ray i from offsets[i] on."""

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

    def put(self, kernel: Callable[..., None], columns: Any) -> None:
        """Write all rows into columns, by `put_spans` or `put_crossings`, and make these read-only."""

        def work(begin: int, end: int) -> None:
            """Write some of the pieces."""
            for p in self.pieces[begin:end]:
                kernel(p.rows, p.counts, p.offsets, p.width, p.begin, p.end, columns)

        run_chunks(work, len(self.pieces), 1)
        for column in (self.offsets, *columns):
            column.flags.writeable = False
