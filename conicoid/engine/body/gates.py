"""Boolean programs as counting gates.

A gate is true when at least `need` of its inputs are: 1 makes it a union, all of them an
intersection. When a leaf turns, only the gates on its path to the root are updated, and only
while they change; a wide union is one gate.

`counts` has the true inputs of all gates of a scene that has few of them, or not many more than its largest program.
Else it has those of one program, so that memory is of the order of the largest program, and what a program begins with
is written where the one before was another.
"""

from __future__ import annotations

import numpy as np

from ...compiler.jit import allocator, inline
from .. import tables as table
from ..programs import gates_of, root_of, rows_of_leaves
from ..tables import Geometry, Ints, integer, length

HELD = -1
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
    counts[HELD], counts[_ALL] = (0, 1) if few else (-1, 0)
    for gate in range(total if few else 0):
        counts[gate] = integer(geometry, table.GATE_START, gate)
    return counts


@inline
def hold(geometry: Geometry, counts: Ints, program: int) -> None:
    """Let `counts` have those of a program, with every leaf outside; so it has, if that was the last that was held."""
    first = root_of(geometry, program)
    if counts[_ALL] == 0 and counts[HELD] != first:
        counts[HELD] = first
        put_outside(geometry, counts, program)


@inline
def put_outside(geometry: Geometry, counts: Ints, program: int) -> None:
    """Put every leaf of a program that is held outside."""
    first, last = gates_of(geometry, program)
    for gate in range(first, last):
        counts[gate - counts[HELD]] = integer(geometry, table.GATE_START, gate)


@inline
def gate_value(geometry: Geometry, counts: Ints, gate: int) -> bool:
    """Are enough of the inputs of a gate of the program that is held true? Its negation is not applied yet."""
    return counts[gate - counts[HELD]] >= integer(geometry, table.GATE_NEED, gate)


@inline
def root_count(geometry: Geometry, counts: Ints, program: int) -> int:
    """How many inputs of the root of a program, which is held, are true."""
    return counts[root_of(geometry, program) - counts[HELD]]


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
        counts[gate - counts[HELD]] += 1 if rises else -1
        after = gate_value(geometry, counts, gate)
        if before == after:
            return
        rises = after != (integer(geometry, table.GATE_NEGATED, gate) == 1)
        gate = integer(geometry, table.GATE_PARENT, gate)
