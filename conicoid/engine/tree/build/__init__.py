"""Trees over a scene's entries and over a body's leaves, eight boxes to a node.

Boxes are split in two by the surface area heuristic, recursively, on all threads; nodes of eight are formed from
the binary branches so that the expected cost of a traversal is least. What is unbounded along some axes has a tree of
its own with all that is unbounded along the same; only what is unbounded along all three is kept outside of the trees.
"""

from __future__ import annotations

from collections.abc import Callable

from ...lowering import Lowered
from ...lowering.apart import give_back
from ...tables import NODE_BOXES, Geometry, Tables, pack
from .leaf_items import put_items
from .woods import COSTS, Woods, extent_of, programs_of

_MANY = 1 << 16
"""Entries of which the temporary arrays are worth giving back at once."""


def with_trees(lowered: Lowered, room: Callable[[Tables], Geometry] | None = None) -> tuple[Geometry, Woods]:
    """The geometry of a lowered scene, with the trees over its entries and over the leaves of its bodies.

    It takes the tables of the scene. room: as for `pack`.
    """
    tables = lowered.taken()
    many = len(tables.entry_kind) >= _MANY
    if many:
        give_back()
    forest = programs_of(tables)
    depth = forest.depth
    survey = forest.add(lowered.boxes, 0, COSTS[tables.entry_kind])
    levels = forest.levels
    forest.end_tree()
    columns = {**tables._asdict(), **forest.columns(), "extent": extent_of(survey)}
    del tables
    if many:
        give_back()
    geometry = pack(columns, later=("node_boxes", "leaf_items"), room=room)
    forest.put_boxes(geometry.floats, int(geometry.places[NODE_BOXES]))
    place, woods = forest.places[-2], Woods.of(forest, depth, levels)
    del forest  # what trees were built from is as large as what follows
    if many:
        give_back()
    put_items(geometry, lowered.boxes, place)
    if many:
        give_back()
    return geometry, woods


__all__ = ["Woods", "with_trees"]
