"""The rows of a picture in a flat list of rays, found by looking at the rays.

In the order in which a camera scans, rays move away from the first one until a row ends, and then
jump back to next to it. Where the list is made of rows like that, squares of neighbours can be traced together
instead of stretches of a row. A wrong guess costs time, never a hit.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ...shapes.row_vectors import dot_rows
from ...shapes.vector import FloatArray
from ..answers.rays import Rays

FEW = 1 << 14
"""Shorter lists are not examined: it would take longer than it saves."""
_LEAST = 32  # rays in a row: a few idle lanes at its end do not matter
_SIDE = 8  # of a square
_LOOKS = (1 << 10, 1 << 14)  # how far the end of the first row is searched
_STEEP = 4.0  # the next row is at most so many neighbours away: of 64 rays in a square none is further than in a row


def row_length(rays: Rays) -> int:
    """How many rays each row of a flat list has, 0 if it has none.

    Rows are looked for in the directions (a camera of perspective), then in the origins (an orthographic one).
    """
    if len(rays.shape) != 1 or len(rays) < FEW:
        return 0
    for lines in (rays.directions, rays.origins):
        length = _first_return(lines)
        if length >= _LEAST and len(lines) % length == 0 and _is_picture(lines.reshape(-1, length, 3)):
            return length
    return 0


def _squared(vectors: FloatArray) -> Any:
    """Squared lengths of vectors."""
    return dot_rows(vectors, vectors)


def _first_return(lines: FloatArray) -> int:
    """The first place where lines (n, 3) jump back to near the first of them, 0 if there is none."""
    for look in _LOOKS:
        away = _squared(lines[: min(look, len(lines) // _SIDE) + 1] - lines[0])
        back = np.flatnonzero(16.0 * away[_SIDE:] < away[_SIDE - 1 : -1])
        if len(back):
            return int(back[0]) + _SIDE
    return 0


def _is_picture(rows: FloatArray) -> bool:
    """Do a few rows (height, width, 3) begin, pass and end beside those before them?"""
    height, width, _ = rows.shape
    some = np.linspace(1, height - 1, _SIDE).astype(np.int64)
    columns = np.array([0, width // 2, width - 1])
    here, before = rows[some][:, columns], rows[some - 1][:, columns]
    across = np.sqrt(_squared(here[:, 1:] - here[:, :-1])).sum(axis=1) / (width - 1)
    down = np.sqrt(_squared(here - before)).max(axis=1)
    return bool((down <= _STEEP * across).all())
