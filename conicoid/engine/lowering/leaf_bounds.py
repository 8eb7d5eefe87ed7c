"""What cells and Boolean bodies have that are one another moved is in the tables once.

That is the boxes around leaves, and the limits.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..tables import SHIFT_SIZE, Floats, Ints
from .apart import empty
from .moved_rows import MovedRows
from .pattern import BOX_NUMBERS, Group
from .places import Contents, Places
from .surfaces import end_to_end


def bounds_of_leaves(contents: Contents, programs: Places) -> tuple[Floats, Ints, Floats]:
    """`Tables.leaf_bounds`, `program_shifts` and `shifts`: first the rows of bodies with their own."""
    groups = [group for group in contents.groups if len(group.pattern.leaves)]
    own = Places.of(contents, [0 if _shares(group) else len(group.pattern.leaves) for group in contents.groups])
    limits = Places.of(contents, [0 if _shares(group) else len(group.pattern.programs) for group in contents.groups])
    rows = empty((own.count, BOX_NUMBERS), np.float64)
    parts, count, limit = [rows], own.count, limits.count
    program_shifts = empty((programs.count if any(map(_shares, groups)) else 0, SHIFT_SIZE), np.int32)
    shifts, shift = [np.zeros(min(1, len(program_shifts)))], 1
    for group in groups:
        p, begin = group.pattern, programs.first[group.bodies]
        places: list[Any] = [0, 0, 0, own.first[group.bodies], limits.first[group.bodies]]
        if isinstance(group.rows, MovedRows):
            parts.append(group.rows.around_all(p.bounds_at, len(p.leaves)))
            places[3:] = count, limit
            for axis, values in enumerate(group.rows.away.values):
                places[axis] = group.rows.away.index[axis] + np.int32(shift)
                shifts.append(values)
                shift += len(values)
            count += len(p.leaves)
            limit += len(p.programs)
        else:
            for k in range(len(p.leaves)):
                at = p.bounds_at + BOX_NUMBERS * k
                rows[own.first[group.bodies] + np.int32(k)] = group.rows[:, at : at + BOX_NUMBERS]
        leaf = 0
        for k, (leaves, _) in enumerate(p.programs.tolist() if len(program_shifts) else ()):
            for column, (place, more) in enumerate(zip(places, (0, 0, 0, leaf, k), strict=True)):
                program_shifts[begin + np.int32(k), column] = place + np.int32(more)
            leaf += leaves
    return end_to_end(parts), program_shifts, end_to_end(shifts)


def likes_of_cells(contents: Contents, cells: Places) -> Ints:
    """`Tables.cell_likes`: first the rows of bodies with their own."""
    moved = [isinstance(group.rows, MovedRows) for group in contents.groups]
    sizes = [len(group.pattern.cells) for group in contents.groups]
    likes = empty(cells.count if any(moved) else 0, np.int32)
    own = Places.of(contents, [0 if shares else size for shares, size in zip(moved, sizes, strict=True)])
    count = own.count
    for group, shares, size in zip(contents.groups, moved, sizes, strict=True):
        for k in range(size if len(likes) else 0):
            row: Any = np.int32(count) if shares else own.first[group.bodies]
            likes[cells.first[group.bodies] + np.int32(k)] = row + np.int32(k)
        count += size if shares else 0
    return likes


def _shares(group: Group) -> bool:
    """Are the bodies of a group one another moved, and have leaves?"""
    return isinstance(group.rows, MovedRows) and len(group.pattern.leaves) > 0
