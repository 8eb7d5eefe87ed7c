"""What cells and Boolean bodies have that are one another moved is in the tables once.

That is how leaves feed gates, the gates, the boxes around leaves, the numbers of faces, and the limits.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..faces import as_bytes, shared
from ..programs import ALIKE
from ..tables import SHIFT_SIZE, Ints
from .apart import empty
from .columns import Columns, ends_of
from .moved_rows import MovedRows
from .pattern import BOX_NUMBERS, Group, Pattern
from .places import Contents, Places
from .surfaces import end_to_end


def columns_of_programs(contents: Contents, programs: Places, cells: Places) -> dict[str, Any]:
    """The columns of programs, their leaves and gates (engine/programs.py).

    programs, cells: where those of each body are.
    """
    alike, leaves, gates = (
        Places.alike(contents, [len(getattr(group.pattern, rows)) for group in contents.groups])
        for rows in ("programs", "leaves", "gates")
    )
    counts, leaf, gate = Columns(alike, "ii"), Columns(leaves, "iibb"), Columns(gates, "iibi")
    shares = any(map(_shares, contents.groups))
    first = Columns(programs, "i")
    for group in contents.groups:
        p, first_cell, first_gate = group.pattern, cells.first[group.bodies], gates.first[group.bodies]
        counts.put(group, p.programs, {})
        leaf.put(group, p.leaves, {0: first_cell, 1: first_gate})
        gate.put(group, p.gates, {0: first_gate})
        if shares:
            first.put(group, _first_cells(p), {0: first_cell})
    row = ends_of(counts.columns[0])
    return dict(
        program_leaf=np.append(first.columns[0], np.int32(cells.count)) if shares else row,
        program_gate=ends_of(counts.columns[1]),
        program_row=row if shares else row[:0],
        leaf_cell=leaf.columns[0][:0] if shares else leaf.columns[0],
        leaf_gate=leaf.columns[1],
        leaf_negated=leaf.columns[2],
        leaf_sense=leaf.columns[3],
        gate_parent=gate.columns[0],
        gate_need=gate.columns[1],
        gate_negated=gate.columns[2],
        gate_start=gate.columns[3],
        **_bounds_of_leaves(contents, programs, leaves, alike),
    )


def _first_cells(pattern: Pattern) -> Ints:
    """(programs, 1) the cell of the first leaf of each, any of one without leaves: the others follow behind it."""
    first = np.cumsum(pattern.programs[:, 0]) - pattern.programs[:, 0]
    cells = np.append(pattern.leaves[:, 0], 0)
    assert (cells[:-1] - np.repeat(cells[first] - first, pattern.programs[:, 0]) == np.arange(len(cells) - 1)).all()
    return cells[first][:, None]


def _bounds_of_leaves(contents: Contents, programs: Places, leaves: Places, alike: Places) -> dict[str, Any]:
    """`Tables.leaf_bounds`, `program_shifts` and `shifts`.

    programs: where those of each body are; leaves, alike: where, in what programs have in common, its leaves are and
    its programs.
    """
    groups = [group for group in contents.groups if len(group.pattern.leaves)]
    rows = empty((leaves.count, BOX_NUMBERS), np.float64)
    program_shifts = empty((programs.count if any(map(_shares, groups)) else 0, SHIFT_SIZE), np.int32)
    shifts, shift = [np.zeros(min(1, len(program_shifts)))], 1
    for group in groups:
        p, begin = group.pattern, programs.first[group.bodies]
        first = leaves.first[group.bodies]
        places: list[Any] = [0, 0, 0, alike.first[group.bodies]]
        if isinstance(group.rows, MovedRows):
            rows[first[0] : first[0] + len(p.leaves)] = group.rows.around_all(p.bounds_at, len(p.leaves))
            for axis, values in enumerate(group.rows.away.values):
                places[axis] = group.rows.away.index[axis] + np.int32(shift)
                shifts.append(values)
                shift += len(values)
        else:
            for k in range(len(p.leaves)):
                at = p.bounds_at + BOX_NUMBERS * k
                rows[first + np.int32(k)] = group.rows[:, at : at + BOX_NUMBERS]
        for k in range(len(p.programs) if len(program_shifts) else 0):
            for column, place in enumerate(places):
                program_shifts[begin + np.int32(k), column] = place + np.int32(k if column == ALIKE else 0)
    return dict(leaf_bounds=rows, program_shifts=program_shifts, shifts=end_to_end(shifts))


def shared_faces(contents: Contents, cells: Places, faces: Ints, planes: Ints) -> dict[str, Ints]:
    """`Tables.cell_likes`, `cell_face` and `plane_face`, from 1 + the numbers of all faces with their sides."""
    if not any(isinstance(group.rows, MovedRows) for group in contents.groups):
        return dict(cell_likes=faces[:0], cell_face=faces, plane_face=planes)
    alike = Places.alike(contents, [len(group.pattern.cells) for group in contents.groups])
    likes = empty(cells.count, np.int32)
    for group in contents.groups:
        for k in range(len(group.pattern.cells)):
            likes[cells.first[group.bodies] + np.int32(k)] = alike.first[group.bodies] + np.int32(k)
    likes, column = shared(likes, faces, alike.count)
    return dict(cell_likes=likes, cell_face=column, plane_face=as_bytes(planes))


def _shares(group: Group) -> bool:
    """Are the bodies of a group one another moved, and have leaves?"""
    return isinstance(group.rows, MovedRows) and len(group.pattern.leaves) > 0
