"""All crossings or spans of rays, as rows of a growing table.

A row is a span or a crossing; its columns have names. Both begin with t and the body, by which rows are sorted. OFF is
the error bound of a t. Where the ray carries ranks instead of lengths (queries/exact/ranks.py), t is a rank.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..._jit.decorators import allocator, helper, inline
from ..numbers.shell_sort import first_gap, make_sort, next_gap
from ..ray import Ray
from ..tables import Floats, Geometry, whole
from .boolean import read_crossing
from .entry import crossing_face, entry_crossings, entry_nearness, is_solid
from .hit import may_tie
from .scratch import Scratch

# Columns of a span; where the interval clips it (CLIPPED 1, else 0), the surface is -1
ENTER, BODY, EXIT, ENTER_CLIPPED, EXIT_CLIPPED, ENTER_SURFACE, EXIT_SURFACE, ENTER_OFF, EXIT_OFF = range(9)
SPAN_COLUMNS = 9
# Columns of a crossing; its body is in column BODY, SIDE is that of `crossing_face`, ENTERS is 1 or 0
T, _, FACE, SURFACE, SIDE, ENTERS, OFF = range(7)
CROSSING_COLUMNS = 7
_FEW = 12  # most rows that insertion sort orders


class BodyRows(NamedTuple):
    """The number of a ray's crossings with a body, which are in scratch themselves, and facts about all of them."""

    crossings: int
    inside: bool  # just after t_min
    off: float  # error bound of the t of each
    unsure: bool


@allocator
def grow_rows(rows: Floats, used: int, more: int) -> Floats:
    """Return the table of rows, or a larger copy if it has no room for `more` rows."""
    if used + more <= len(rows):
        return rows
    # Twice as long each time, so that all copies together cost as much as the rows; 64 saves the first steps
    larger = np.empty((2 * len(rows) + more + 64, rows.shape[1]))
    for i in range(used):
        for k in range(rows.shape[1]):
            larger[i, k] = rows[i, k]
    return larger


@inline
def _surface(geometry: Geometry, scratch: Scratch, entry: int, c: int) -> int:
    """Return the surface of crossing c of an entry, from scratch."""
    _, place, sense, _ = read_crossing(scratch, c)
    return crossing_face(geometry, entry, place, sense)[0]


@helper
def _put_spans(
    geometry: Geometry, scratch: Scratch, entry: int, found: BodyRows, ray: Ray, rows: Floats, used: int
) -> int:
    """Append rows of the spans between an entry's crossings, from scratch; return the number of rows now."""
    body = whole(entry)
    # Until the first crossing a span begins at the interval, which is exact: no surface, no error
    enter, surface, before, inside = ray.t_min, whole(-1), 0.0, found.inside
    # One round more than crossings: the last span may end with the interval
    for c in range(found.crossings + 1):
        at_end = c == found.crossings
        t, beyond, after = ray.t_max, whole(-1), 0.0
        if not at_end:
            t, beyond, after = read_crossing(scratch, c)[0], _surface(geometry, scratch, entry, c), found.off
        if inside:
            rows[used, ENTER], rows[used, BODY], rows[used, EXIT] = enter, body, t
            rows[used, ENTER_CLIPPED], rows[used, EXIT_CLIPPED] = 1.0 if surface < 0 else 0.0, 1.0 if at_end else 0.0
            rows[used, ENTER_SURFACE], rows[used, EXIT_SURFACE] = surface, beyond
            rows[used, ENTER_OFF], rows[used, EXIT_OFF] = before, after
            used += 1
        inside = not inside
        enter, surface, before = t, beyond, after
    return used


@helper
def _put_crossings(geometry: Geometry, scratch: Scratch, entry: int, found: BodyRows, rows: Floats, used: int) -> int:
    """Append rows of an entry's crossings, from scratch; return the number of rows now."""
    body = whole(entry)
    for c in range(found.crossings):
        t, place, sense, enters = read_crossing(scratch, c)
        surface, face, side = crossing_face(geometry, whole(entry), place, sense)
        rows[used, T], rows[used, BODY] = t, body
        rows[used, FACE], rows[used, SURFACE], rows[used, SIDE] = face, surface, side
        rows[used, ENTERS], rows[used, OFF] = 1.0 if enters else 0.0, found.off
        used += 1
    return used


@inline
def put_rows(
    geometry: Geometry, scratch: Scratch, entry: int, found: BodyRows, ray: Ray, spans: bool, rows: Floats, used: int
) -> int:
    """Append rows of an entry's spans or crossings; return the number of rows now.

    Relies on room for one row more than the entry has crossings (`grow_rows`).
    """
    if spans:
        return _put_spans(geometry, scratch, entry, found, ray, rows, used)
    return _put_crossings(geometry, scratch, entry, found, rows, used)


@inline
def _order(rows: Floats, i: int, j: int, columns: int) -> int:
    """Return -1, 0 or 1 if row i comes before, with or after row j, by their first columns."""
    for k in range(columns):
        if rows[i, k] != rows[j, k]:
            return 1 if rows[i, k] > rows[j, k] else -1
    return 0


@helper
def _insert_rows(rows: Floats, first: int, last: int, columns: int) -> None:
    """Sort a few rows by their first columns: insertion sort, stable."""
    for i in range(first + 1, last):
        j = i
        while j > first and _order(rows, j - 1, j, columns) > 0:
            for k in range(rows.shape[1]):
                rows[j - 1, k], rows[j, k] = rows[j, k], rows[j - 1, k]
            j -= 1


@inline
def _stands_after(rows: tuple[Floats, int, int], a: int, b: int) -> bool:
    """True if row a, counted from the first one, comes after row b, by first columns; equal rows keep their order."""
    table, first, columns = rows
    order = _order(table, first + a, first + b, columns)
    return order > 0 or (order == 0 and a > b)


_sort_places = make_sort(_stands_after)


@allocator
def _sort_many_rows(rows: Floats, first: int, last: int, columns: int) -> None:
    """Sort many rows by their first columns, stable."""
    # Numbers are sorted first, so that each row moves once
    order = np.empty(last - first, np.int32)
    for i in range(last - first):
        order[i] = i
    _sort_places(order, len(order), (rows, first, columns))
    before = rows[first:last].copy()
    for i in range(last - first):
        for k in range(rows.shape[1]):
            rows[first + i, k] = before[order[i], k]


@helper
def _unsettled(rows: Floats, first: int, last: int, surface: int, off: int) -> bool:
    """True if rounding might have changed the order of two rows; not of two on the same surface at the same t."""
    for i in range(first + 1, last):
        near = may_tie(rows[i, T], rows[i, off], rows[i - 1, T], rows[i - 1, off])
        # One surface at one t is exact: a wall that two bodies share, for which the list's order decides
        if near and (rows[i, T] != rows[i - 1, T] or rows[i, surface] != rows[i - 1, surface]):
            return True
    return False


@inline
def sort_rows(rows: Floats, first: int, last: int, spans: bool) -> bool:
    """Sort the rows of a ray by t and body, crossings also by face; True if rounding might have changed the order."""
    if last - first < 2:
        return False
    # Insertion moves whole rows, which is cheaper than a sort of numbers for so few
    if last - first <= _FEW:
        _insert_rows(rows, first, last, 2 if spans else 3)
    else:
        _sort_many_rows(rows, first, last, 2 if spans else 3)
    return _unsettled(rows, first, last, ENTER_SURFACE if spans else SURFACE, ENTER_OFF if spans else OFF)


@helper
def sort_rows_in_place(rows: Floats, first: int, last: int, spans: bool) -> bool:
    """`sort_rows` without memory: the last column, beyond those of a row, is for the order of equal rows."""
    columns, extra, gap = 2 if spans else 3, rows.shape[1] - 1, first_gap(last - first)
    for i in range(first, last):
        rows[i, extra] = i
    while gap > 0:
        for i in range(first + gap, last):
            j = i
            while j >= first + gap:
                order = _order(rows, j - gap, j, columns)
                if order < 0 or (order == 0 and rows[j - gap, extra] < rows[j, extra]):
                    break
                for k in range(rows.shape[1]):
                    rows[j - gap, k], rows[j, k] = rows[j, k], rows[j - gap, k]
                j -= gap
        gap = next_gap(gap)
    return _unsettled(rows, first, last, ENTER_SURFACE if spans else SURFACE, ENTER_OFF if spans else OFF)


@helper
def scale_rows(rows: Floats, first: int, last: int, scale: float, unscaled: Ray, spans: bool) -> None:
    """Convert t to the length of the unscaled ray's direction; clipped ends equal its interval's ends to the bit."""
    if scale == 1.0:
        return
    for i in range(first, last):
        # t_min / scale * scale may differ from t_min by its rounding
        rows[i, T] = unscaled.t_min if spans and rows[i, ENTER_CLIPPED] != 0.0 else rows[i, T] * scale
        if spans:
            rows[i, EXIT] = unscaled.t_max if rows[i, EXIT_CLIPPED] != 0.0 else rows[i, EXIT] * scale


@allocator
def ray_rows(
    geometry: Geometry, scratch: Scratch, ray: Ray, count: int, spans: bool, rows: Floats, used: int
) -> tuple[Floats, int, bool]:
    """Append sorted spans or crossings of entries scratch.found[:count] at rows[used]: (rows, number now, doubtful)."""
    first, doubtful = used, False
    for k in range(count):
        entry = scratch.found[k]
        # Sheets have crossings, but no inside
        if spans and not is_solid(geometry, entry):
            continue
        crossings, inside, unsure = entry_crossings(geometry, scratch, entry, ray, 1 << 30)
        doubtful |= unsure
        if crossings > 0 or inside:
            off = entry_nearness(geometry, entry, ray).off
            rows = grow_rows(rows, used, crossings + 1)
            body_rows = BodyRows(crossings, inside, off, unsure)
            used = put_rows(geometry, scratch, entry, body_rows, ray, spans, rows, used)
    return rows, used, sort_rows(rows, first, used, spans) | doubtful
