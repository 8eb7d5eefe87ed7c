"""All crossings and spans of one ray, as rows of a growing table.

A span:      t_enter, body, t_exit, enter clipped, exit clipped, surfaces of both ends (-1: none), off, off
A crossing:  t, body, face, surface, side, entered, off

`off` is by how much rounding may have moved an end. Where the ray is one of ranks (see ranks.py), its crossings
are traced in `stand`, and t is a rank.
"""

from __future__ import annotations

import numpy as np

from ..geometry import tables as table
from ..geometry.tables import Floats, Geometry, Ray, integer, whole
from ..jit import allocator, helper, inline
from .entries import crossed_face, entry_crossings, entry_nearness, is_solid
from .ranks import find_leaves
from .scratch import Scratch

SPAN_COLUMNS, SPAN_OFF = 9, 7
CROSSING_COLUMNS, CROSSING_OFF = 7, 6


@allocator
def _with_room(rows: Floats, used: int) -> Floats:
    if used < len(rows):
        return rows
    larger = np.empty((2 * len(rows) + 64, rows.shape[1]))
    larger[: len(rows)] = rows
    return larger


@allocator
def _sort_rows(rows: Floats, first: int, last: int, columns: int) -> None:
    """Order rows by their first columns (few rows: by insertion)."""
    for i in range(first + 1, last):
        row = rows[i].copy()
        j = i
        while j > first:
            later = False
            for k in range(columns):
                if rows[j - 1, k] != row[k]:
                    later = rows[j - 1, k] > row[k]
                    break
            if not later:
                break
            rows[j] = rows[j - 1]
            j -= 1
        rows[j] = row


@helper
def _unsettled(rows: Floats, first: int, last: int, surface: int, off: int) -> bool:
    """Might rounding have changed the order of two rows? Not of two on the same surface, at the same t."""
    for i in range(first + 1, last):
        near = abs(rows[i, 0] - rows[i - 1, 0]) <= rows[i, off] + rows[i - 1, off]
        if near and (rows[i, 0] != rows[i - 1, 0] or rows[i, surface] != rows[i - 1, surface]):
            return True
    return False


@helper
def scale_crossings(rows: Floats, first: int, last: int, scale: float) -> None:
    """Back to the length that the ray's direction had."""
    if scale == 1.0:
        return
    for i in range(first, last):
        rows[i, 0] *= scale
        rows[i, CROSSING_OFF] *= scale


@helper
def scale_spans(rows: Floats, first: int, last: int, scale: float, t_min: float, t_max: float) -> None:
    """Back to the length that the ray's direction had; clipped ends are those of the interval, to the bit."""
    if scale == 1.0:
        return
    for i in range(first, last):
        rows[i, 0] = rows[i, 0] * scale if rows[i, 3] == 0.0 else t_min
        rows[i, 2] = rows[i, 2] * scale if rows[i, 4] == 0.0 else t_max
        rows[i, SPAN_OFF] *= scale
        rows[i, SPAN_OFF + 1] *= scale


@inline
def _surface(geometry: Geometry, scratch: Scratch, entry: int, c: int) -> int:
    return crossed_face(geometry, entry, whole(scratch.crossing[3 * c]), whole(scratch.crossing[3 * c + 1]))[0]


@allocator
def ray_spans(
    geometry: Geometry, stand: Geometry, scratch: Scratch, truth: Ray, ray: Ray, count: int, rows: Floats, used: int
) -> tuple[Floats, int, bool]:
    """The spans of entries scratch.found[:count] from rows[used] on: (rows, how many now, doubtful)."""
    first, doubtful = used, False
    for k in range(count):
        entry = scratch.found[k]
        if not is_solid(geometry, entry):
            continue
        find_leaves(geometry, scratch, entry, truth)
        crossings, inside, unsure = entry_crossings(stand, scratch, entry, ray, 1 << 30)
        nearness = entry_nearness(geometry, entry, truth)
        doubtful |= unsure
        enter, surface, off = ray[6], whole(-1), 0.0
        for c in range(crossings + 1):
            at_end = c == crossings
            if inside:
                rows = _with_room(rows, used)
                t = ray[7] if at_end else scratch.cross_t[c]
                rows[used, 0], rows[used, 1], rows[used, 2] = enter, integer(geometry, table.ENTRY_BODY, entry), t
                rows[used, 3], rows[used, 4] = 1.0 if surface < 0 else 0.0, 1.0 if at_end else 0.0
                rows[used, 5] = surface
                rows[used, 6] = whole(-1) if at_end else _surface(geometry, scratch, entry, c)
                rows[used, 7], rows[used, 8] = off, 0.0 if at_end else nearness[0]
                used += 1
            if not at_end:
                inside = not inside
                enter, surface = scratch.cross_t[c], _surface(geometry, scratch, entry, c)
                off = nearness[0]
    scratch.known[0] = -1
    _sort_rows(rows, first, used, 2)
    return rows, used, doubtful | _unsettled(rows, first, used, 5, SPAN_OFF)


@allocator
def ray_crossings(
    geometry: Geometry, stand: Geometry, scratch: Scratch, truth: Ray, ray: Ray, count: int, rows: Floats, used: int
) -> tuple[Floats, int, bool]:
    """The crossings of entries scratch.found[:count] from rows[used] on: (rows, how many now, doubtful)."""
    first, doubtful = used, False
    for k in range(count):
        entry = scratch.found[k]
        find_leaves(geometry, scratch, entry, truth)
        crossings, _, unsure = entry_crossings(stand, scratch, entry, ray, 1 << 30)
        nearness = entry_nearness(geometry, entry, truth)
        doubtful |= unsure
        for c in range(crossings):
            rows = _with_room(rows, used)
            place, sense = whole(scratch.crossing[3 * c]), whole(scratch.crossing[3 * c + 1])
            surface, face, side = crossed_face(geometry, whole(entry), place, sense)
            rows[used, 0], rows[used, 1] = scratch.cross_t[c], integer(geometry, table.ENTRY_BODY, entry)
            rows[used, 2], rows[used, 3], rows[used, 4] = face, surface, side
            rows[used, 5], rows[used, 6] = scratch.crossing[3 * c + 2], nearness[0]
            used += 1
    scratch.known[0] = -1
    _sort_rows(rows, first, used, 3)
    return rows, used, doubtful | _unsettled(rows, first, used, 3, CROSSING_OFF)
