"""Memory of one thread: events of a region's leaves, crossings of a body, the stack of a walk."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..geometry import tables as table
from ..geometry.tables import Floats, Geometry, Ints, Signs, integer, length
from ..jit import allocator
from .frontier import MOST_CHOSEN
from .simd import BEAM
from .walk import Stack


class Scratch(NamedTuple):
    """Scratch memory, sized for the largest body of a scene. Taken once for each chunk of rays."""

    event_t: Floats  # span ends of a region's leaves
    event_leaf: Ints
    event_place: Ints  # the face
    event_on: Ints  # 1: the leaf is entered, 0: left
    cross_t: Floats  # crossings of a body
    crossing: Ints  # 3 each: place of the face, sense of its leaf, 1 if entered
    counts: Ints  # true inputs of every gate; between rays as they are with every leaf outside
    stack: Stack  # of the walk through the scene's tree
    inner_stack: Stack  # of the walk through the tree of a body's leaves
    near: Floats  # (8,) where the ray enters the children of a node
    beam: Floats  # the ray, as the boxes of the scene's tree are tested with
    inner_beam: Floats
    found: Ints  # entries whose boxes the ray meets
    found_leaves: Ints
    known: Ints  # (1,) how many leaves stand in found_leaves already, or -1: they are to be looked for
    nothing: Signs  # an empty mask: every body counts


@allocator
def new_scratch(geometry: Geometry) -> Scratch:
    """Scratch memory for one thread."""
    leaves = 1
    for program in range(length(geometry, table.PROGRAM_LEAF) - 1):
        its = integer(geometry, table.PROGRAM_LEAF, program + 1) - integer(geometry, table.PROGRAM_LEAF, program)
        leaves = max(leaves, its)
    events, depth = 4 * leaves + 4, integer(geometry, table.TREE_DEPTH, 0) + MOST_CHOSEN
    gates = np.empty(length(geometry, table.GATE_START), np.int32)
    for gate in range(len(gates)):
        gates[gate] = integer(geometry, table.GATE_START, gate)
    return Scratch(
        np.empty(events),
        np.empty(events, np.int32),
        np.empty(events, np.int32),
        np.empty(events, np.int32),
        np.empty(events),
        np.empty(3 * events, np.int32),
        gates,
        Stack(np.empty(depth, np.int32), np.empty(depth, np.int32), np.empty(depth)),
        Stack(np.empty(depth, np.int32), np.empty(depth, np.int32), np.empty(depth)),
        np.empty(8),
        np.empty(BEAM),
        np.empty(BEAM),
        np.empty(length(geometry, table.ENTRY_KIND), np.int32),
        np.empty(leaves, np.int32),
        np.full(1, -1, np.int32),
        np.empty(0, np.int8),
    )
