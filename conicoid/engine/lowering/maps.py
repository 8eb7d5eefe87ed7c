"""Affine maps of bodies: those from the world to uv of each face, and those to a body's own coordinates.

Rows of maps that are one another's are in the table once, of bodies that are one another moved.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..tables import MAP_SIZE, PLACE_SIZE, Floats, Ints
from .apart import empty
from .moved_rows import MovedRows
from .pattern import FRAME_NUMBERS, Group
from .places import Contents, Places
from .rows import blocks
from .surfaces import end_to_end

_SHIFT = 3
"""Bits of a number of `face_maps` of moved bodies that say what its row depends on (`body/maps.py`)."""


def maps_of_faces(contents: Contents, faces: Places) -> tuple[Ints, Ints, Floats]:
    """`Tables.face_maps`, `body_maps`, `map_rows`: first the rows of bodies that have their own, in order.

    faces: which are whose.
    """
    groups = contents.groups
    moved = [(group, group.rows) for group in groups if isinstance(group.rows, MovedRows)]
    own = Places.of(contents, [0 if isinstance(each.rows, MovedRows) else each.pattern.map_rows for each in groups])
    if moved:
        alone = [0 if isinstance(each.rows, MovedRows) else len(each.pattern.angular) for each in groups]
        faces = Places.of(contents, alone)
    maps, rows = empty((faces.count, 3), np.int32), np.empty((own.count, MAP_SIZE))
    for group in groups:
        if isinstance(group.rows, MovedRows):
            continue
        p, at = group.pattern, own.rows(group, group.pattern.map_rows)
        for some in blocks(len(group.bodies)):
            rows[at[some]] = group.rows[some, p.uv_at : p.bounds_at].reshape(*at[some].shape, MAP_SIZE)
        for face, mine in enumerate(_numbered(group, (at << _SHIFT if moved else at).T)):
            for k, number in enumerate(mine):
                maps[faces.first[group.bodies] + np.int32(face), k] = number
    if not moved:
        return maps, empty((0, PLACE_SIZE), np.int32), rows
    parts, tables, places = [maps], [rows], empty((contents.body_count, PLACE_SIZE), np.int32)
    places[:, 0] = faces.first
    first, count = faces.count, own.count
    for group, moving in moved:
        p, which = group.pattern, _Which()
        numbers: list[Any] = []
        for table, index in _maps_of(moving, range(p.uv_at, p.bounds_at, MAP_SIZE)):
            numbers.append(count << _SHIFT | which.of(index))
            tables.append(table)
            count += len(table)
        parts.append(np.array(_numbered(group, numbers), np.int32).reshape(-1, 3))
        places[group.bodies, 0] = first
        first += len(p.angular)
        for k, index in which.known:
            places[group.bodies, k] = index
    return end_to_end(parts), places, end_to_end(tables)


def _numbered(group: Group, rows: Any) -> list[list[Any]]:
    """For each face the numbers of its rows, from those of the rows of its body; of angular ones -1 - the first."""
    p = group.pattern
    found = [[rows[row] for row in mine] for mine in p.maps.tolist()]
    for face in np.flatnonzero(p.angular).tolist():
        found[face][0] = -1 - found[face][0]
    return found


def _maps_of(moving: MovedRows, columns: range) -> list[tuple[Floats, Ints]]:
    """`MovedRows.maps` of columns; rows that depend on more than `_Which` has numbers for are written out."""
    found, which = [moving.maps(column) for column in columns], _Which()
    try:
        for _, index in found:
            which.of(index)
    except ValueError:
        own = np.arange(len(moving), dtype=np.int32)
        found = [(table[index], own) if index.any() else (table, index) for table, index in found]
    return found


class _Which:
    """What the rows of maps depend on, by the numbers that `body_maps` has for it."""

    def __init__(self) -> None:
        self.known: list[tuple[int, Ints]] = []

    def of(self, index: Ints) -> int:
        """The number of what the rows depend on by which each body has this one; 0 where all have the first.

        Raises ValueError for more than three.
        """
        if not index.any():
            return 0
        for k, known in self.known:
            if known is index or np.array_equal(known, index):
                return k
        if len(self.known) == PLACE_SIZE - 1:
            raise ValueError("the maps of moved bodies depend on more than their places along three axes")
        self.known.append((len(self.known) + 1, index))
        return len(self.known)


def shares_frame(group: Group) -> bool:
    """Have all bodies of a group the same own coordinates?"""
    p = group.pattern
    return isinstance(group.rows, MovedRows) and all(
        len(group.rows.maps(column)[0]) == 1 for column in range(p.frame_at, p.corners_at, MAP_SIZE)
    )


def frames_of(groups: Sequence[Group], frames: Places) -> tuple[Floats, Ints]:
    """((n, 3, 4) from the world to own coordinates, the row of each body), without those of bulk balls.

    frames: which rows are of bodies with one each; those that groups share come behind.
    """
    rows, which = [np.empty((frames.count, FRAME_NUMBERS))], frames.first.astype(np.int32)
    for group in groups:
        p = group.pattern
        if not p.framed:
            which[group.bodies] = group.ball_frame
        elif shares_frame(group):
            which[group.bodies] = len(rows) - 1 + frames.count
            rows.append(group.rows[:1, p.frame_at : p.corners_at])
        else:
            rows[0][frames.first[group.bodies]] = group.rows[:, p.frame_at : p.corners_at]
    return end_to_end(rows).reshape(-1, 3, 4), which
