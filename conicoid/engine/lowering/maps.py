"""Affine maps of bodies: those from the world to uv of each face, and those to a body's own coordinates.

Rows of maps that are one another's are in the table once, of bodies that are one another moved.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..tables import MAP_SIZE, Floats, Ints
from .apart import empty
from .moved import MovedRows
from .pattern import FRAME_NUMBERS, Group
from .places import Contents, Places
from .rows import blocks
from .surfaces import end_to_end


def maps_of_faces(contents: Contents, faces: Places) -> tuple[Ints, Floats]:
    """`Tables.face_maps` and `map_rows`: first the rows of bodies that have their own, in order, then shared ones."""
    groups = contents.groups
    own = Places.of(contents, [0 if isinstance(each.rows, MovedRows) else each.pattern.map_rows for each in groups])
    maps, rows = empty((faces.count, 3), np.int32), np.empty((own.count, MAP_SIZE))
    tables, count = [rows], own.count
    for group in groups:
        p = group.pattern
        first = faces.first[group.bodies]
        if not isinstance(group.rows, MovedRows):
            at = own.rows(group, p.map_rows)
            for some in blocks(len(group.bodies)):
                rows[at[some]] = group.rows[some, p.uv_at : p.bounds_at].reshape(*at[some].shape, MAP_SIZE)
            places = [at[:, k] for k in range(p.map_rows)]
        else:
            places = []
            for column in range(p.uv_at, p.bounds_at, MAP_SIZE):
                table, index = group.rows.maps(column)
                places.append(index + np.int32(count))
                tables.append(table)
                count += len(table)
        for face, (angular, mine) in enumerate(zip(p.angular.tolist(), p.maps.tolist(), strict=True)):
            for k, row in enumerate(mine):
                maps[first + np.int32(face), k] = -1 - places[row] if angular and k == 0 else places[row]
    return maps, end_to_end(tables)


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
