"""Boolean programs: where the tables hold their leaves and gates, their value as counting gates, boxes of leaves.

Programs that are translated copies of each other share the rows of their gates and leaves; `program_shifts` holds the
row of each program. In such a scene the number of a leaf is the number of its cell. A scene without copies has no
`program_shifts`: leaves have numbers of their own, `leaf_cell` gives the cell of each, and the rows of programs and
leaves are their numbers.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from .._jit.decorators import allocator, inline
from . import tables as table
from .tables import BOUNDS_SIZE, SHIFT_SIZE, Geometry, Ints, Tables, integer, length, whole

MODEL_ROW = SHIFT_SIZE - 1
"""Column of `program_shifts`: the row of a program in the shared tables."""


@inline
def row_of_program(geometry: Geometry, program: int) -> int:
    """Return the row of a program in `program_gate` and `program_limits`."""
    if length(geometry, table.PROGRAM_SHIFTS) == 0:
        return whole(program)
    return integer(geometry, table.PROGRAM_SHIFTS, SHIFT_SIZE * program + MODEL_ROW)


@inline
def rows_of_leaves(geometry: Geometry, program: int) -> int:
    """Return the number that, added to the number of a leaf of a program, gives its row in `leaf_gate` and the like."""
    if length(geometry, table.PROGRAM_SHIFTS) == 0:
        return whole(0)
    return first_leaf(geometry, program) - integer(geometry, table.PROGRAM_LEAF, program)


@inline
def first_leaf(geometry: Geometry, program: int) -> int:
    """Return the row of the first leaf of a program in `leaf_gate` and the like."""
    if length(geometry, table.PROGRAM_SHIFTS) == 0:
        return integer(geometry, table.PROGRAM_LEAF, program)
    return integer(geometry, table.PROGRAM_ROW, row_of_program(geometry, program))


@inline
def sense_of(geometry: Geometry, program: int, leaf: int) -> int:
    """Return `leaf_sense` of a leaf: -1 if its faces' normals are reversed in the program, else +1."""
    return integer(geometry, table.LEAF_SENSE, leaf + rows_of_leaves(geometry, program))


@inline
def leaves_of(geometry: Geometry, program: int) -> tuple[int, int]:
    """Return (first, end) numbers of the leaves of a program."""
    first = integer(geometry, table.PROGRAM_LEAF, program)
    if length(geometry, table.PROGRAM_SHIFTS) == 0:
        return first, integer(geometry, table.PROGRAM_LEAF, program + 1)
    row = row_of_program(geometry, program)
    count = integer(geometry, table.PROGRAM_ROW, row + 1) - integer(geometry, table.PROGRAM_ROW, row)
    return first, first + count


@inline
def cell_of_leaf(geometry: Geometry, leaf: int) -> int:
    """Return the cell of a leaf."""
    return whole(leaf) if length(geometry, table.PROGRAM_SHIFTS) > 0 else integer(geometry, table.LEAF_CELL, leaf)


@inline
def gates_of(geometry: Geometry, program: int) -> tuple[int, int]:
    """Return (first, end) rows of the gates of a program; the first is its root."""
    row = row_of_program(geometry, program)
    return integer(geometry, table.PROGRAM_GATE, row), integer(geometry, table.PROGRAM_GATE, row + 1)


@inline
def root_of(geometry: Geometry, program: int) -> int:
    """Return the row of the root gate of a program."""
    return integer(geometry, table.PROGRAM_GATE, row_of_program(geometry, program))


def rows_of_programs(tables: Tables) -> Ints:
    """Return (programs,) the row of each program in `program_gate` and `program_limits`."""
    if len(tables.program_shifts):
        return tables.program_shifts[:, MODEL_ROW]
    return np.arange(len(tables.program_leaf) - 1, dtype=np.int32)


def leaves_of_programs(tables: Tables) -> tuple[Ints, Ints]:
    """Return two arrays over the programs: the number of the first leaf, and the count of leaves."""
    first = tables.program_leaf
    count = np.diff(tables.program_row)[rows_of_programs(tables)] if len(tables.program_shifts) else np.diff(first)
    return first[:-1], count


def leaves_of_program(tables: Tables, program: int) -> range:
    """Return the numbers of the leaves of a program."""
    first, end = tables.program_leaf[program : program + 2].tolist()
    if len(tables.program_shifts):
        row = int(tables.program_shifts[program, MODEL_ROW])
        end = first + int(tables.program_row[row + 1] - tables.program_row[row])
    return range(first, end)


def cells_of_leaves(tables: Tables, leaves: Any) -> Any:
    """Return the cells of some leaves."""
    return leaves if len(tables.program_shifts) else tables.leaf_cell[leaves]


def row_of_leaf(tables: Tables, program: Any, leaf: Any) -> Any:
    """Return the rows of some leaves, of one program or of one program each, in `leaf_gate` and the like."""
    if not len(tables.program_shifts):
        return leaf
    return leaf + (tables.program_row[tables.program_shifts[program, MODEL_ROW]] - tables.program_leaf[program])


def gates_of_program(tables: Tables, program: int) -> range:
    """Return the rows of the gates of a program; the first is its root."""
    row = int(tables.program_shifts[program, MODEL_ROW]) if len(tables.program_shifts) else program
    return range(int(tables.program_gate[row]), int(tables.program_gate[row + 1]))


# Counting gates
#
# A gate is true when at least `gate_need` of its inputs are true: 1 makes it a union, all inputs an intersection. When
# a leaf changes, only the gates on its path to the root are updated, and only while they change; a wide union is one
# gate.
#
# `counts` holds the true inputs of all gates if the scene has few gates, or not many more than its largest program.
# Otherwise it holds the gates of one program at a time, so that memory stays of the order of the largest program;
# `hold_program` then writes the start values when the program changes.

HELD_PROGRAM = -1
"""Index in `counts`: the gate to which the first count belongs; its value is -1 for none."""
_ALL = -2
"""Index in `counts`: 1 if `counts` holds all gates."""
_FEW = 1 << 15
"""Most gates of a scene that are always held together: 128 KB."""
_TIMES = 4
"""Gates are also held together up to this multiple of the largest program's: otherwise rays that alternate between two
large programs would write the start values again each time."""


@allocator
def new_counts(geometry: Geometry) -> Ints:
    """Return counts with every leaf outside, int32."""
    total = length(geometry, table.GATE_START)
    few = total <= max(_FEW, _TIMES * geometry.places[table.GATES])
    counts = np.empty((total if few else geometry.places[table.GATES]) + 2, np.int32)
    counts[HELD_PROGRAM], counts[_ALL] = (0, 1) if few else (-1, 0)
    for gate in range(total if few else 0):
        counts[gate] = integer(geometry, table.GATE_START, gate)
    return counts


@inline
def forget_program(counts: Ints) -> None:
    """Make `counts` hold no program: from now on one at a time."""
    counts[HELD_PROGRAM], counts[_ALL] = -1, 0


@inline
def hold_program(geometry: Geometry, counts: Ints, program: int) -> None:
    """Make `counts` hold the gates of a program, with every leaf outside.

    Relies on every leaf being outside already if the program is the one held.
    """
    first = root_of(geometry, program)
    if counts[_ALL] == 0 and counts[HELD_PROGRAM] != first:
        counts[HELD_PROGRAM] = first
        put_outside(geometry, counts, program)


@inline
def put_outside(geometry: Geometry, counts: Ints, program: int) -> None:
    """Set the counts of the held program to every leaf outside."""
    first, last = gates_of(geometry, program)
    for gate in range(first, last):
        counts[gate - counts[HELD_PROGRAM]] = integer(geometry, table.GATE_START, gate)


@inline
def gate_value(geometry: Geometry, counts: Ints, gate: int) -> bool:
    """True if enough inputs of a gate of the held program are true; its negation is not applied."""
    return counts[gate - counts[HELD_PROGRAM]] >= integer(geometry, table.GATE_NEED, gate)


@inline
def root_count(geometry: Geometry, counts: Ints, program: int) -> int:
    """Return the number of true inputs of the root of the held program."""
    return counts[root_of(geometry, program) - counts[HELD_PROGRAM]]


@inline
def root_value(geometry: Geometry, counts: Ints, program: int) -> bool:
    """Return the value of the held program."""
    root = root_of(geometry, program)
    return gate_value(geometry, counts, root) != (integer(geometry, table.GATE_NEGATED, root) == 1)


@inline
def turn_leaf(geometry: Geometry, counts: Ints, program: int, leaf: int, on: bool) -> None:
    """Count a leaf's change to inside (`on`) or outside, up to the first gate that keeps its value.

    Keeps `counts` equal to the true inputs of every gate of the held program; relies on the leaf having been on the
    other side before.
    """
    row = leaf + rows_of_leaves(geometry, program)
    gate = integer(geometry, table.LEAF_GATE, row)
    rises = on != (integer(geometry, table.LEAF_NEGATED, row) == 1)  # of the gate's input, after the leaf's negation
    while gate >= 0:
        before = gate_value(geometry, counts, gate)
        counts[gate - counts[HELD_PROGRAM]] += 1 if rises else -1
        after = gate_value(geometry, counts, gate)
        if before == after:  # gates above see no change
            return
        rises = after != (integer(geometry, table.GATE_NEGATED, gate) == 1)
        gate = integer(geometry, table.GATE_PARENT, gate)


@inline
def leaf_decides(geometry: Geometry, counts: Ints, program: int, leaf: int, on: bool) -> bool:
    """True if every gate from a leaf to the root has the value that the leaf, inside (`on`) or outside, alone gives.

    A leaf for which this is true on both sides of a crossing, with its own change, turns the body there. Of a body that
    turns, some leaf does: gates do not fall when an input rises.
    """
    row = leaf + rows_of_leaves(geometry, program)
    gate = integer(geometry, table.LEAF_GATE, row)
    rises = on != (integer(geometry, table.LEAF_NEGATED, row) == 1)
    while gate >= 0:
        if gate_value(geometry, counts, gate) != rises:
            return False
        rises = rises != (integer(geometry, table.GATE_NEGATED, gate) == 1)
        gate = integer(geometry, table.GATE_PARENT, gate)
    return True


# Boxes around the leaves of a program. Translated copies share the boxes of the first copy, and add their shift.


class LeafBounds(NamedTuple):
    """The place in the floats where the boxes of a program's leaves begin, and the shift to add to them."""

    at: Any
    x: float
    y: float
    z: float


@inline
def leaf_bounds(geometry: Geometry, program: int) -> LeafBounds:
    """Return the boxes of the leaves of a program."""
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
    """Return the low end of a leaf's box along an axis; leaves of the program count from 0."""
    shift = bounds.x if axis == 0 else (bounds.y if axis == 1 else bounds.z)
    return geometry.floats[bounds.at + BOUNDS_SIZE * number + axis] + shift


@inline
def leaf_high(geometry: Geometry, bounds: LeafBounds, number: int, axis: int) -> float:
    """Return the high end of a leaf's box along an axis; leaves of the program count from 0."""
    shift = bounds.x if axis == 0 else (bounds.y if axis == 1 else bounds.z)
    return geometry.floats[bounds.at + BOUNDS_SIZE * number + axis + 3] + shift
