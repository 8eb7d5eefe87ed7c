"""Trees over a scene's entries and over a body's leaves, eight boxes to a node.

Boxes are split in two by the surface area heuristic, recursively, on all threads; nodes of eight are formed from
the binary branches so that the expected cost of a traversal is least. What is unbounded along some axes has a tree of
its own with all that is unbounded along the same; only what is unbounded along all three is kept outside of the trees.
"""

from __future__ import annotations

from collections.abc import Callable

from ...lowering import Lowered
from ...lowering.apart import give_back_of
from ...lowering.around import Around
from ...lowering.limits import limits_of, shapes_of_limits
from ...tables import NODE_BOXES, Floats, Geometry, Tables, pack, put_sizes, room_for
from .leaf_items import put_items
from .woods import COSTS, Woods, extent_of, programs_of


def with_trees(lowered: Lowered, room: Callable[[Tables], Geometry] = room_for) -> tuple[Geometry, Woods]:
    """The geometry of a lowered scene, with limits and the trees over its entries and over the leaves of its bodies.

    It takes the tables of the scene. What is large is made as late as can be, and goes as soon as can be.

    room: gives the room for tables of these shapes.
    """
    tables = lowered.taken()
    count = len(tables.entry_kind)
    give_back_of(count)
    forest = programs_of(tables, lowered.laid is not None)
    give_back_of(count)
    depth = forest.depth
    survey = forest.add(_taken(lowered), 0, COSTS[tables.entry_kind])
    levels = forest.levels
    forest.end_tree()
    give_back_of(count)
    columns = {**tables._asdict(), **forest.columns(), **shapes_of_limits(tables), "extent": extent_of(survey)}
    geometry = room(Tables(**columns))
    put_sizes(geometry, tables)
    forest.put_boxes(geometry.floats, int(geometry.places[NODE_BOXES]))
    place, woods = forest.places[-2], Woods.of(forest, depth, levels, lowered.laid is not None)
    del forest  # what trees were built from
    give_back_of(count)
    columns.update(limits_of(tables, lowered.boxes, lowered.rest))
    del tables
    give_back_of(count)
    pack(geometry, columns, later=("node_boxes", "leaf_items"))
    give_back_of(count)
    put_items(geometry, lowered.boxes, place)
    if isinstance(lowered.around, Around):
        lowered.around.let_go()
    give_back_of(count)
    return geometry, woods


def _taken(lowered: Lowered) -> Floats:
    """The boxes of a scene, which it makes anew when it is asked for them again, if it can."""
    boxes = lowered.boxes
    if isinstance(lowered.around, Around):
        lowered.around.let_go()
    return boxes


__all__ = ["Woods", "with_trees"]
