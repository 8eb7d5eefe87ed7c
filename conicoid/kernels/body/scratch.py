"""Scratch memory of one thread: events of a region's leaves, crossings of a body, the stack of a tree walk."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..._jit.decorators import allocator, record_shapes
from .. import tables as table
from ..bvh.culling_constants import MOST_CHOSEN
from ..bvh.walk import way_size
from ..programs import new_counts
from ..tables import Floats, Geometry, Ints, Signs, integer, length

TIME, EVENT = 2, 6
"""Elements of `time` and `event` for one event and the crossing with the same number."""
LEAF, PLACE, ON = 0, 1, 2
"""Elements of an event: a region's leaf, the place of its face, 1 if the ray enters the leaf or 0 if it leaves."""
CROSS_T = 1
CROSS_PLACE, CROSS_SENSE, CROSS_ENTERS = 3, 4, 5
"""Elements of a crossing: the place of its face, the sense of its leaf, 1 if the ray enters the body."""
LEAF_COUNT = -1
"""Last element of `found_leaves`: the number of leaves that it holds, or -1 if the tree must be traversed for them."""


@record_shapes(time="*", event="*", counts="*", way="*", inner_way="*", found="*", found_leaves="*", nothing="*")
class Scratch(NamedTuple):
    """Scratch memory, sized for the largest body of a scene, allocated once for each chunk of rays.

    Between rays `counts` has every leaf outside (`hold_program`) and found_leaves[LEAF_COUNT] is -1; a function that
    changes them restores them.
    """

    time: Floats  # (TIME each) t of a region's events, which are span ends of its leaves; t of a body's crossings
    event: Ints  # (EVENT each) the rest of an event and of a crossing
    counts: Ints  # true inputs of gates, see kernels/programs.py
    way: Floats  # of the walk through the scene's tree, see kernels/bvh/walk.py
    inner_way: Floats  # of the walk through the tree of a body's leaves
    found: Ints  # entries whose boxes the ray meets
    found_leaves: Ints  # leaves of a body, see `LEAF_COUNT`
    nothing: Signs  # an empty mask: every body counts


@allocator
def new_scratch(geometry: Geometry) -> Scratch:
    """Return scratch memory for one thread."""
    # A leaf has at most two spans, so four events
    leaves = geometry.places[table.LEAVES]
    events, depth = 4 * leaves + 4, integer(geometry, table.TREE_DEPTH, 0) + MOST_CHOSEN
    found_leaves = np.empty(leaves + 1, np.int32)
    found_leaves[LEAF_COUNT] = -1
    return Scratch(
        np.empty(TIME * events),
        np.empty(EVENT * events, np.int32),
        new_counts(geometry),
        np.empty(way_size(depth)),
        np.empty(way_size(depth)),
        np.empty(length(geometry, table.ENTRY_KIND), np.int32),
        found_leaves,
        np.empty(0, np.int8),
    )
