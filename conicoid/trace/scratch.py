"""Memory of one thread: events of a region's leaves, crossings of a body, the stack of a walk."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..geometry import tables as table
from ..geometry.tables import Floats, Geometry, Ints, Signs, integer, length
from ..jit import allocator


class Scratch(NamedTuple):
    """Scratch memory, sized for the largest body of a scene. Taken once for each chunk of rays."""

    event_t: Floats  # span ends of a region's leaves
    event_leaf: Ints
    event_slot: Ints  # the face
    event_on: Ints  # 1: the leaf is entered, 0: left
    cross_t: Floats  # crossings of a body
    crossing: Ints  # 4 each: surface, face number, side, 1 if entered
    counts: Ints  # true inputs of every gate; between rays as they are with every leaf outside
    stack: Ints  # what of the scene's tree is still to be visited
    stack_t: Floats  # where the ray enters it
    inner_stack: Ints  # the same for the tree of a body's leaves
    inner_stack_t: Floats
    near: Floats  # (8,) where the ray enters the children of a node
    found: Ints  # entries whose boxes the ray meets
    found_leaves: Ints
    nothing: Signs  # an empty mask: every body counts


@allocator
def new_scratch(geometry: Geometry) -> Scratch:
    """Scratch memory for one thread."""
    leaves = 1
    for program in range(length(geometry, table.PROGRAM_LEAF) - 1):
        its = integer(geometry, table.PROGRAM_LEAF, program + 1) - integer(geometry, table.PROGRAM_LEAF, program)
        leaves = max(leaves, its)
    events, depth = 4 * leaves + 4, integer(geometry, table.TREE_DEPTH, 0)
    gates = np.empty(length(geometry, table.GATE_START), np.int32)
    for gate in range(len(gates)):
        gates[gate] = integer(geometry, table.GATE_START, gate)
    return Scratch(
        np.empty(events),
        np.empty(events, np.int32),
        np.empty(events, np.int32),
        np.empty(events, np.int32),
        np.empty(events),
        np.empty(4 * events, np.int32),
        gates,
        np.empty(depth, np.int32),
        np.empty(depth),
        np.empty(depth, np.int32),
        np.empty(depth),
        np.empty(8),
        np.empty(length(geometry, table.ENTRY_KIND), np.int32),
        np.empty(leaves, np.int32),
        np.empty(0, np.int8),
    )
