"""Programs in the tables: where their leaves and gates are.

What leaves feed, and the gates, are alike in programs that are one another moved: these are in the tables once, and
`program_shifts` says of each program where. The leaves of such a scene have the numbers of their cells. A scene without
such bodies has no `program_shifts`: its leaves are numbered by themselves, `leaf_cell` says which cell each is, and the
rows of its programs, and of their leaves, are those of their numbers.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..compiler.jit import inline
from . import tables as table
from .tables import SHIFT_SIZE, Geometry, Ints, Tables, integer, length, whole

ALIKE = SHIFT_SIZE - 1
"""In a row of `program_shifts`: the row of a program in what programs have in common."""


@inline
def row_of_program(geometry: Geometry, program: int) -> int:
    """The row of a program in `program_gate` and `program_limits`."""
    if length(geometry, table.PROGRAM_SHIFTS) == 0:
        return whole(program)
    return integer(geometry, table.PROGRAM_SHIFTS, SHIFT_SIZE * program + ALIKE)


@inline
def rows_of_leaves(geometry: Geometry, program: int) -> int:
    """What is to be added to the number of a leaf of a program for its row in `leaf_gate` and the like."""
    if length(geometry, table.PROGRAM_SHIFTS) == 0:
        return whole(0)
    return first_leaf(geometry, program) - integer(geometry, table.PROGRAM_LEAF, program)


@inline
def first_leaf(geometry: Geometry, program: int) -> int:
    """The row of the first leaf of a program in `leaf_gate` and the like."""
    if length(geometry, table.PROGRAM_SHIFTS) == 0:
        return integer(geometry, table.PROGRAM_LEAF, program)
    return integer(geometry, table.PROGRAM_ROW, row_of_program(geometry, program))


@inline
def sense_of(geometry: Geometry, program: int, leaf: int) -> int:
    """Which way the faces of a leaf of a program look (`leaf_sense`)."""
    return integer(geometry, table.LEAF_SENSE, leaf + rows_of_leaves(geometry, program))


@inline
def leaves_of(geometry: Geometry, program: int) -> tuple[int, int]:
    """(first, end) numbers of the leaves of a program."""
    first = integer(geometry, table.PROGRAM_LEAF, program)
    if length(geometry, table.PROGRAM_SHIFTS) == 0:
        return first, integer(geometry, table.PROGRAM_LEAF, program + 1)
    row = row_of_program(geometry, program)
    count = integer(geometry, table.PROGRAM_ROW, row + 1) - integer(geometry, table.PROGRAM_ROW, row)
    return first, first + count


@inline
def cell_of_leaf(geometry: Geometry, leaf: int) -> int:
    """The cell that a leaf is."""
    return whole(leaf) if length(geometry, table.PROGRAM_SHIFTS) > 0 else integer(geometry, table.LEAF_CELL, leaf)


@inline
def gates_of(geometry: Geometry, program: int) -> tuple[int, int]:
    """(first, end) rows of the gates of a program; the first is its root."""
    row = row_of_program(geometry, program)
    return integer(geometry, table.PROGRAM_GATE, row), integer(geometry, table.PROGRAM_GATE, row + 1)


@inline
def root_of(geometry: Geometry, program: int) -> int:
    """The row of the root of a program."""
    return integer(geometry, table.PROGRAM_GATE, row_of_program(geometry, program))


def rows_of_programs(tables: Tables) -> Ints:
    """(programs,) the row of each in `program_gate` and `program_limits`."""
    if len(tables.program_shifts):
        rows: Ints = tables.program_shifts[:, ALIKE]
        return rows
    return np.arange(len(tables.program_leaf) - 1, dtype=np.int32)


def leaves_of_programs(tables: Tables) -> tuple[Ints, Ints]:
    """(the first leaf, how many) of each program."""
    first = tables.program_leaf
    count = np.diff(tables.program_row)[rows_of_programs(tables)] if len(tables.program_shifts) else np.diff(first)
    return first[:-1], count


def leaves_of_program(tables: Tables, program: int) -> range:
    """The leaves of a program."""
    first, end = tables.program_leaf[program : program + 2].tolist()
    if len(tables.program_shifts):
        row = int(tables.program_shifts[program, ALIKE])
        end = first + int(tables.program_row[row + 1] - tables.program_row[row])
    return range(first, end)


def cells_of_leaves(tables: Tables, leaves: Any) -> Any:
    """The cells that some leaves are."""
    return leaves if len(tables.program_shifts) else tables.leaf_cell[leaves]


def row_of_leaf(tables: Tables, program: Any, leaf: Any) -> Any:
    """The rows of some leaves of a program, or of several, in `leaf_gate` and the like."""
    if not len(tables.program_shifts):
        return leaf
    return leaf + (tables.program_row[tables.program_shifts[program, ALIKE]] - tables.program_leaf[program])


def gates_of_program(tables: Tables, program: int) -> range:
    """The rows of the gates of a program; the first is its root."""
    row = int(tables.program_shifts[program, ALIKE]) if len(tables.program_shifts) else program
    return range(int(tables.program_gate[row]), int(tables.program_gate[row + 1]))
