"""Programs in the tables: where their leaves and gates are.

What leaves feed, and the gates, are alike in programs that are one another moved: these are in the tables once, and
`program_shifts` says of each program where. The leaves of such a scene have the numbers of their cells. A scene without
such bodies has no `program_shifts`: its leaves are numbered by themselves, `leaf_cell` says which cell each is, and the
rows of its programs, and of their leaves, are those of their numbers.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from .._jit.decorators import allocator, inline
from . import tables as table
from .tables import BOUNDS_SIZE, SHIFT_SIZE, Geometry, Ints, Tables, integer, length, whole

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


# Boolean programs as counting gates.
#
# A gate is true when at least `need` of its inputs are: 1 makes it a union, all of them an
# intersection. When a leaf turns, only the gates on its path to the root are updated, and only
# while they change; a wide union is one gate.
#
# `counts` has the true inputs of all gates of a scene that has few of them, or not many more than its largest program.
# Else it has those of one program, so that memory is of the order of the largest program, and what a program begins
# with
# is written where the one before was another.

HELD_PROGRAM = -1
"""Where in `counts` the gate is that the first count is of; -1 for none."""
_ALL = -2
"""Where in `counts` 1 stands for those of all gates."""
_FEW = 1 << 15
"""Gates of a scene whose counts are held together: 128 KB."""
_TIMES = 4
"""And so many times those of the largest program: else two large ones behind one another would begin anew in turn."""


@allocator
def new_counts(geometry: Geometry) -> Ints:
    """Counts with every leaf outside."""
    total = length(geometry, table.GATE_START)
    few = total <= max(_FEW, _TIMES * geometry.places[table.GATES])
    counts = np.empty((total if few else geometry.places[table.GATES]) + 2, np.int32)
    counts[HELD_PROGRAM], counts[_ALL] = (0, 1) if few else (-1, 0)
    for gate in range(total if few else 0):
        counts[gate] = integer(geometry, table.GATE_START, gate)
    return counts


@inline
def hold_program(geometry: Geometry, counts: Ints, program: int) -> None:
    """Let `counts` have those of a program, with every leaf outside; so it has, if that was the last that was held."""
    first = root_of(geometry, program)
    if counts[_ALL] == 0 and counts[HELD_PROGRAM] != first:
        counts[HELD_PROGRAM] = first
        put_outside(geometry, counts, program)


@inline
def put_outside(geometry: Geometry, counts: Ints, program: int) -> None:
    """Put every leaf of a program that is held outside."""
    first, last = gates_of(geometry, program)
    for gate in range(first, last):
        counts[gate - counts[HELD_PROGRAM]] = integer(geometry, table.GATE_START, gate)


@inline
def gate_value(geometry: Geometry, counts: Ints, gate: int) -> bool:
    """Are enough of the inputs of a gate of the program that is held true? Its negation is not applied yet."""
    return counts[gate - counts[HELD_PROGRAM]] >= integer(geometry, table.GATE_NEED, gate)


@inline
def root_count(geometry: Geometry, counts: Ints, program: int) -> int:
    """How many inputs of the root of a program, which is held, are true."""
    return counts[root_of(geometry, program) - counts[HELD_PROGRAM]]


@inline
def root_value(geometry: Geometry, counts: Ints, program: int) -> bool:
    """The value of a whole program, which is held."""
    root = root_of(geometry, program)
    return gate_value(geometry, counts, root) != (integer(geometry, table.GATE_NEGATED, root) == 1)


@inline
def turn_leaf(geometry: Geometry, counts: Ints, program: int, leaf: int, on: bool) -> None:
    """Count a leaf's change from off to on, or back, up to the first gate that keeps its value.

    Keeps `counts` the true inputs of every gate of the program, which is held; relies on the leaf having been the other
    way before.
    """
    row = leaf + rows_of_leaves(geometry, program)
    gate = integer(geometry, table.LEAF_GATE, row)
    rises = on != (integer(geometry, table.LEAF_NEGATED, row) == 1)
    while gate >= 0:
        before = gate_value(geometry, counts, gate)
        counts[gate - counts[HELD_PROGRAM]] += 1 if rises else -1
        after = gate_value(geometry, counts, gate)
        if before == after:
            return
        rises = after != (integer(geometry, table.GATE_NEGATED, gate) == 1)
        gate = integer(geometry, table.GATE_PARENT, gate)


# Boxes around the leaves of a program: programs that are one another moved have those of the first.


class LeafBounds(NamedTuple):
    """Where in the floats the boxes of a program's leaves begin, and what is to be added to them."""

    at: Any
    x: float
    y: float
    z: float


@inline
def leaf_bounds(geometry: Geometry, program: int) -> LeafBounds:
    """The boxes of the leaves of a program."""
    f, places, first = geometry.floats, geometry.places, first_leaf(geometry, program)
    x, y, z = 0.0, 0.0, 0.0
    if length(geometry, table.PROGRAM_SHIFTS) > 0:
        shifts, at = places[table.SHIFTS], SHIFT_SIZE * program
        x = f[shifts + integer(geometry, table.PROGRAM_SHIFTS, at)]
        y = f[shifts + integer(geometry, table.PROGRAM_SHIFTS, at + 1)]
        z = f[shifts + integer(geometry, table.PROGRAM_SHIFTS, at + 2)]
    return LeafBounds(places[table.LEAF_BOUNDS] + BOUNDS_SIZE * first, x, y, z)


@inline
def leaf_low(geometry: Geometry, bounds: LeafBounds, number: int, axis: int) -> float:
    """Where along an axis the box of one of the leaves begins; numbers count from 0."""
    shift = bounds.x if axis == 0 else (bounds.y if axis == 1 else bounds.z)
    return geometry.floats[bounds.at + BOUNDS_SIZE * number + axis] + shift


@inline
def leaf_high(geometry: Geometry, bounds: LeafBounds, number: int, axis: int) -> float:
    """Where it ends."""
    shift = bounds.x if axis == 0 else (bounds.y if axis == 1 else bounds.z)
    return geometry.floats[bounds.at + BOUNDS_SIZE * number + axis + 3] + shift
