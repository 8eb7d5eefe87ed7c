"""Boolean programs as counting gates.

A gate is true when at least `need` of its inputs are: 1 makes it a union, all of them an
intersection. When a leaf turns, only the gates on its way to the root are counted again, and only
while they change; a wide union is one gate.
"""

from __future__ import annotations

from ..jit import inline
from .tables import Geometry, Ints


@inline
def gate_value(geometry: Geometry, counts: Ints, gate: int) -> bool:
    return counts[gate] >= geometry.gate_need[gate]


@inline
def root_value(geometry: Geometry, counts: Ints, program: int) -> bool:
    """The truth of a whole program for the leaves turned on so far."""
    root = geometry.program_gate[program]
    return gate_value(geometry, counts, root) != (geometry.gate_negated[root] == 1)


@inline
def turn_leaf(geometry: Geometry, counts: Ints, leaf: int, on: bool) -> None:
    """Count a leaf's change from off to on, or back, up to the first gate that keeps its value."""
    gate = geometry.leaf_gate[leaf]
    rises = on != (geometry.leaf_negated[leaf] == 1)
    while gate >= 0:
        before = gate_value(geometry, counts, gate)
        counts[gate] += 1 if rises else -1
        after = gate_value(geometry, counts, gate)
        if before == after:
            return
        rises = after != (geometry.gate_negated[gate] == 1)
        gate = geometry.gate_parent[gate]
