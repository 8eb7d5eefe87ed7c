"""Affine maps of bodies: those from the world to uv of each face, and those to a body's own coordinates.

Rows of maps that are one another's are in the table once, of bodies that are one another moved.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..tables import MAP_SIZE, PLACE_SIZE, Floats, Ints
from .apart import empty
from .moved import MovedRows
from .pattern import FRAME_NUMBERS, UV_NUMBERS, Group
from .places import Contents, Places
from .rows import blocks
from .surfaces import end_to_end

_ROWS = UV_NUMBERS // MAP_SIZE
_SHIFT = 3
"""Bits of a number of `face_maps` of moved bodies that say what its row depends on (`body/maps.py`)."""


def maps_of_faces(contents: Contents) -> tuple[Ints, Ints, Floats]:
    """`Tables.face_maps`, `body_maps`, `map_rows`: first the rows of bodies that have their own, in order."""
    groups = contents.groups
    own = Places.of(contents, [0 if isinstance(each.rows, MovedRows) else len(each.pattern.angular) for each in groups])
    moved = [(group, group.rows) for group in groups if isinstance(group.rows, MovedRows)]
    maps, rows = empty((own.count, _ROWS), np.int32), np.empty((own.count, UV_NUMBERS))
    for group in groups:
        if isinstance(group.rows, MovedRows):
            continue
        p, each = group.pattern, len(group.pattern.angular)
        at = own.rows(group, each)
        for some in blocks(len(group.bodies)):
            rows[at[some]] = group.rows[some, p.uv_at : p.bounds_at].reshape(len(at[some]), each, UV_NUMBERS)
        maps[at] = (_ROWS * at[:, :, None] + np.arange(_ROWS)) << (_SHIFT if moved else 0)
        for face in np.flatnonzero(p.angular).tolist():
            maps[at[:, face], 0] = -1 - maps[at[:, face], 0]
    if not moved:
        return maps, empty((0, PLACE_SIZE), np.int32), rows.reshape(-1, MAP_SIZE)
    parts, tables, places = [maps], [rows.reshape(-1, MAP_SIZE)], empty((contents.body_count, PLACE_SIZE), np.int32)
    places[:, 0] = own.first
    first, count = own.count, _ROWS * own.count
    for group, numbers in moved:
        p, which = group.pattern, _Which(numbers)
        found = np.empty((len(p.angular), _ROWS), np.int32)
        for k, column in enumerate(range(p.uv_at, p.bounds_at, MAP_SIZE)):
            table, index = numbers.maps(column)
            found[k // _ROWS, k % _ROWS] = count << _SHIFT | which.of(index)
            tables.append(table)
            count += len(table)
        angular = np.flatnonzero(p.angular)
        found[angular, 0] = -1 - found[angular, 0]
        parts.append(found)
        places[group.bodies, 0] = first
        first += len(found)
        for k, index in which.known:
            places[group.bodies, k] = index
    return end_to_end(parts), places, end_to_end(tables)


class _Which:
    """What the rows of maps depend on, by the numbers that `body_maps` has for it."""

    def __init__(self, rows: MovedRows) -> None:
        self.known: list[tuple[int, Ints]] = []
        self._alone = len(rows)

    def of(self, index: Ints) -> int:
        """The number of what the rows depend on by which each body has this one; 0 where all have the first.

        Raises ValueError for more than four: those of three axes, and one that is another for each body.
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
