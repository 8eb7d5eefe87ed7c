"""Boolean programs as counting gates.

A gate is true when at least `need` of its inputs are: 1 makes it a union, all of them an
intersection. When a leaf turns, only the gates on its path to the root are updated, and only
while they change; a wide union is one gate.

`counts` has the true inputs of the gates of one program, and last the first of these (`HELD`): memory is as large as
the largest program, and what a program begins with is written only where the one before it was another.
"""

from __future__ import annotations

from ...compiler.jit import inline
from .. import tables as table
from ..tables import Geometry, Ints, integer

HELD = -1
"""Where in `counts` the first gate of the program is that they are of; -1 for none."""


@inline
def hold(geometry: Geometry, counts: Ints, program: int) -> None:
    """Let `counts` be those of a program, with every leaf outside; so they are, if it was the last that was held."""
    first = integer(geometry, table.PROGRAM_GATE, program)
    if counts[HELD] != first:
        put_outside(geometry, counts, program)
        counts[HELD] = first


@inline
def put_outside(geometry: Geometry, counts: Ints, program: int) -> None:
    """Put every leaf of a program outside."""
    first, last = integer(geometry, table.PROGRAM_GATE, program), integer(geometry, table.PROGRAM_GATE, program + 1)
    for gate in range(first, last):
        counts[gate - first] = integer(geometry, table.GATE_START, gate)


@inline
def gate_value(geometry: Geometry, counts: Ints, gate: int) -> bool:
    """Are enough of the inputs of a gate of the program that is held true? Its negation is not applied yet."""
    return counts[gate - counts[HELD]] >= integer(geometry, table.GATE_NEED, gate)


@inline
def root_value(geometry: Geometry, counts: Ints, program: int) -> bool:
    """The value of a whole program, which is held."""
    root = integer(geometry, table.PROGRAM_GATE, program)
    return gate_value(geometry, counts, root) != (integer(geometry, table.GATE_NEGATED, root) == 1)


@inline
def turn_leaf(geometry: Geometry, counts: Ints, leaf: int, on: bool) -> None:
    """Count a leaf's change from off to on, or back, up to the first gate that keeps its value.

    Keeps `counts` the true inputs of every gate of the program that is held; relies on the leaf having been the other
    way before.
    """
    gate = integer(geometry, table.LEAF_GATE, leaf)
    rises = on != (integer(geometry, table.LEAF_NEGATED, leaf) == 1)
    while gate >= 0:
        before = gate_value(geometry, counts, gate)
        counts[gate - counts[HELD]] += 1 if rises else -1
        after = gate_value(geometry, counts, gate)
        if before == after:
            return
        rises = after != (integer(geometry, table.GATE_NEGATED, gate) == 1)
        gate = integer(geometry, table.GATE_PARENT, gate)
