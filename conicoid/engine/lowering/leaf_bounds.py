"""Boxes around the leaves of Boolean bodies: those that are one another moved share the first one's."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..tables import SHIFT_SIZE, Floats
from .apart import empty
from .moved import MovedRows
from .pattern import BOX_NUMBERS, Group
from .places import Contents, Places
from .surfaces import end_to_end


def bounds_of_leaves(contents: Contents, programs: Places) -> tuple[Floats, Floats]:
    """`Tables.leaf_bounds` and `program_shifts`: first the rows of bodies with their own."""
    groups = [group for group in contents.groups if len(group.pattern.leaves)]
    own = Places.of(contents, [0 if _shares(group) else len(group.pattern.leaves) for group in contents.groups])
    rows = empty((own.count, BOX_NUMBERS), np.float64)
    parts, count = [rows], own.count
    shifts = empty((programs.count if any(map(_shares, groups)) else 0, SHIFT_SIZE), np.float64)
    for group in groups:
        p = group.pattern
        first: Any
        if isinstance(group.rows, MovedRows):
            parts.append(group.rows.around_all(p.bounds_at, len(p.leaves)))
            away, first = group.rows.away, count
            count += len(p.leaves)
        else:
            away, first = None, own.first[group.bodies]
            for k in range(len(p.leaves)):
                at = p.bounds_at + BOX_NUMBERS * k
                rows[first + np.int32(k)] = group.rows[:, at : at + BOX_NUMBERS]
        if len(shifts):
            begin, leaf = programs.first[group.bodies], 0
            for k, (leaves, _) in enumerate(p.programs.tolist()):
                shifts[begin + np.int32(k), :3] = 0.0 if away is None else away
                shifts[begin + np.int32(k), 3] = first + leaf
                leaf += leaves
    return end_to_end(parts), shifts


def _shares(group: Group) -> bool:
    """Are the bodies of a group one another moved, and have leaves?"""
    return isinstance(group.rows, MovedRows) and len(group.pattern.leaves) > 0
