"""Boolean programs as counting gates.

A gate is true when at least `need` of its inputs are: 1 makes it a union, all of them an
intersection. When a leaf turns, only the gates on its path to the root are updated, and only
while they change; a wide union is one gate.
"""

from __future__ import annotations

from ...compiler.jit import inline
from .. import tables as table
from ..tables import Geometry, Ints, integer


@inline
def gate_value(geometry: Geometry, counts: Ints, gate: int) -> bool:
    """Are enough of the inputs of a gate true? Its negation is not applied yet."""
    return counts[gate] >= integer(geometry, table.GATE_NEED, gate)


@inline
def root_value(geometry: Geometry, counts: Ints, program: int) -> bool:
    """The value of a whole program, if counts[gate] is the number of true inputs of each of its gates."""
    root = integer(geometry, table.PROGRAM_GATE, program)
    return gate_value(geometry, counts, root) != (integer(geometry, table.GATE_NEGATED, root) == 1)


@inline
def turn_leaf(geometry: Geometry, counts: Ints, leaf: int, on: bool) -> None:
    """Count a leaf's change from off to on, or back, up to the first gate that keeps its value.

    Keeps counts[gate] the number of true inputs of every gate; relies on the leaf having been the other way before.
    """
    gate = integer(geometry, table.LEAF_GATE, leaf)
    rises = on != (integer(geometry, table.LEAF_NEGATED, leaf) == 1)
    while gate >= 0:
        before = gate_value(geometry, counts, gate)
        counts[gate] += 1 if rises else -1
        after = gate_value(geometry, counts, gate)
        if before == after:
            return
        rises = after != (integer(geometry, table.GATE_NEGATED, gate) == 1)
        gate = integer(geometry, table.GATE_PARENT, gate)
