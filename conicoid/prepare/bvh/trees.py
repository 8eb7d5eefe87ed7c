"""The trees of a scene in common tables: one over the leaves of each large body, then one over the entries."""

from __future__ import annotations

import math
from array import array
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ..._util.arrays import row_lengths
from ..._util.records import dataclass
from ...geometry.instances import InstanceBlock
from ...kernels.bvh.walk import FEW, ROWS
from ...kernels.programs import leaves_of_programs
from ...kernels.tables import (
    NODE_BOXES,
    Floats,
    Geometry,
    Ints,
    Signs,
    Tables,
    put_sizes,
    room_for,
    unpack_tables,
)
from ...numerics.portable_math import odd_root
from ..coincidence import concatenate
from ..error_limits import LimitMaxima, compute_limits, limit_shapes
from ..lowering import LazyBounds, LoweredScene
from ..mmap_arrays import concatenate_mapped, copy_rows, trim_heap
from .builder import (
    ENDLESS,
    WIDTH,
    BlockTree,
    BoxSurvey,
    BoxTree,
    box_records,
    build_block_tree,
    build_tree,
    finite_limits,
    leaf_code,
    survey_boxes,
)
from .leaf_items import put_items
from .plane_groups import group_tables, put_groups

MOST = 8  # entries in a leaf of a tree
_ROOT_LEAF = 15  # items without a box in a leaf among the roots; a code has four bits for it
_NONE = np.zeros(0, np.int32)
_NO_KINDS = np.zeros(0, np.int8)


class Forest:
    """Collects trees; `put_boxes` writes the boxes of their nodes, once there is memory for them."""

    def __init__(self, nodes: int = 0, places: int = 0) -> None:
        """Start a forest that is appended to `nodes` nodes and `places` places of other trees."""
        self.trees: list[BoxTree | BlockTree] = []
        self.children: list[Ints] = [np.zeros((0, WIDTH), np.int32)]
        self.order: list[Ints] = [_NONE]
        self.roots = array("i")
        self.ends = array("i", [0])
        self.nodes = array("i", [nodes])  # end of each tree
        self.places = array("i", [places])
        self.node_count = nodes
        self.placed = places
        self.depth = 1
        self.levels = 0

    def add(
        self, boxes: Floats, first_item: int, kinds: Signs | Ints = _NO_KINDS, blocks: Sequence[InstanceBlock] = ()
    ) -> BoxSurvey:
        """Add a tree over items first_item, ... with boxes (n, 6), and `kinds` (n,), or none, for the costs of tests.

        Empty boxes are left out. Boxes that are unbounded along the same axes have a tree of their own; items that are
        unbounded along all axes become roots. The boxes are released before the tree is built, but for `blocks`, whose
        trees are alike (`InstanceList.blocks`); these need kinds, and the first item is 0.
        """
        boxes, kinds = np.ascontiguousarray(boxes), np.ascontiguousarray(kinds, np.int8)
        found = survey_boxes(boxes)
        limits = finite_limits(found.ends)
        records: list[Floats] = []
        commonest = int(found.counts[:ENDLESS].argmax())
        blocks = [each for each in blocks if (found.patterns[each.first : each.first + each.size] == commonest).all()]
        for pattern in np.flatnonzero(found.counts[:ENDLESS]).tolist():
            if blocks and pattern == commonest:
                unblocked = found.patterns == commonest
                for each in blocks:
                    unblocked[each.first : each.first + each.size] = False
                self._append(build_block_tree(boxes, kinds, limits, MOST, blocks, np.flatnonzero(unblocked)))
                continue
            every = found.counts[pattern] == len(boxes)
            rows = _NONE if every else np.flatnonzero(found.patterns == pattern).astype(np.int32)
            records.append(box_records(boxes, rows, first_item, kinds, limits))
        del boxes
        for some in records:
            self._append(build_tree(some, limits, MOST))
        self.add_beside(np.flatnonzero(found.patterns == ENDLESS).astype(np.int32) + np.int32(first_item))
        return found

    def _append(self, tree: BoxTree | BlockTree) -> None:
        """Append a tree, whose numbers begin at 0."""
        items, children = tree.items(), tree.children
        if self.node_count or self.placed:
            leaves = np.where(children < 0, children - (self.placed << 4), 0)
            children = np.where(children > 0, children + self.node_count, leaves)
        self.roots.append(self.node_count)
        self.trees.append(tree)
        self.children.append(children)
        self.order.append(items)
        self.node_count += len(children)
        self.placed += len(items)
        self.levels = max(self.levels, tree.levels)

    def add_beside(self, items: Ints) -> None:
        """Add unbounded items as leaves among the roots."""
        for first in range(0, len(items), _ROOT_LEAF):
            self.roots.append(leaf_code(self.placed + first, min(_ROOT_LEAF, len(items) - first)))
        self.order.append(items)
        self.placed += len(items)

    def end_tree(self) -> None:
        """Close the current tree: what follows belongs to the next one."""
        # A node that is popped from the stack is replaced by at most eight, at every level.
        self.depth = max(self.depth, len(self.roots) - self.ends[-1] + WIDTH * (self.levels + 1))
        self.levels = 0
        self.ends.append(len(self.roots))
        self.nodes.append(self.node_count)
        self.places.append(self.placed)

    def add_none(self, count: int) -> None:
        """Add empty trees."""
        for numbers, number in (
            (self.ends, len(self.roots)),
            (self.nodes, self.node_count),
            (self.places, self.placed),
        ):
            numbers.extend(array("i", [number]) * count)

    def columns(self) -> dict[str, Any]:
        """Return the columns of the trees; boxes and items as shapes only. Only the last tree has items."""
        return dict(
            node_boxes=np.broadcast_to(0.0, (self.node_count, 6, WIDTH)),
            node_children=concatenate(self.children),
            tree_order=concatenate_mapped(self.order),
            tree_root=np.frombuffer(self.ends, np.int32),
            roots=np.frombuffer(self.roots, np.int32) if self.roots else _NONE,
            tree_depth=np.array([self.depth], dtype=np.int32),
            leaf_items=np.broadcast_to(0.0, ROWS * (self.placed - self.places[-2])),
        )

    def put_boxes(self, floats: Floats, at: int) -> None:
        """Write the boxes of all nodes to floats[at:]."""
        for tree in self.trees:
            tree.put_boxes(floats, at)
            at += 6 * WIDTH * len(tree.children)


# The trees of a scene, with what its edits need to know


@dataclass(frozen=True)
class SceneTrees:
    """Where trees end in the tables, and how edits have changed the tree over the entries since it was built."""

    nodes: Ints  # (programs + 1,) first node of each body's tree, last of the tree over the entries
    places: Ints  # the same for places in `tree_order`
    depth: int  # depth of the walk's stack in the tree of a body
    levels: int  # levels of the tree over the entries
    main: tuple[int, int, int]  # its ends (node, place, root); the tree of loose entries follows
    loose: Ints  # the entries of that tree
    removals: int = 0  # entries removed from the tree since it was built

    @classmethod
    def of(cls, forest: Forest, depth: int, levels: int, all_of_them: bool = True) -> SceneTrees:
        """Describe a forest whose last tree is that of the entries.

        With `all_of_them` the ends of bodies' trees are stored, not of the last one alone; only edits read them.
        """
        main = forest.nodes[-1], forest.places[-1], forest.ends[-1]
        first = 0 if all_of_them else -2
        nodes, places = (np.array(part[first:-1], np.int32) for part in (forest.nodes, forest.places))
        return cls(nodes, places, depth, levels, main, np.zeros(0, np.int32))


def program_trees(tables: Tables, edited: bool = True) -> Forest:
    """Build the trees over the leaves of each body; bodies with few leaves have an empty tree.

    Where the scene may be edited, each body has a tree; else there is no tree where all bodies have few leaves.
    """
    forest, (first, count) = Forest(), leaves_of_programs(tables)
    large = np.flatnonzero(count > FEW).tolist()
    if not (large or edited):
        return forest
    for begin, end in zip([0, *(program + 1 for program in large)], [*large, len(first)], strict=True):
        if end > begin:
            forest.add_none(end - begin)
        if end < len(first):
            forest.add(tables.bounds_of_leaves(end), int(first[end]))
            forest.end_tree()
    return forest


def scene_extent(survey: BoxSurvey) -> Floats:
    """Return (diagonal, an entry's share of it, middle) of the bounded entries; of all ends where none is bounded."""
    bounded = int(survey.counts[0])
    ends = survey.bounded if bounded else survey.ends
    count = bounded or int(survey.counts[1:7].sum())
    is_box = ends[:3] <= ends[3:]
    if count == 0 or not is_box.any():
        return np.array([0.0, math.inf, 0.0, 0.0, 0.0])
    low, high = np.where(is_box, ends[:3], 0.0), np.where(is_box, ends[3:], 0.0)
    diagonal = float(row_lengths(high - low))
    along_an_axis = (float(count), math.sqrt(count), float(odd_root(count, 3)))[int(is_box.sum()) - 1]
    return np.array([diagonal, diagonal / along_an_axis, *(0.5 * low + 0.5 * high)])


# Building
#
# Boxes are split in two by the surface area heuristic, recursively, on all threads; nodes of eight are formed from the
# binary branches so that the expected cost of a traversal is least. Boxes that are unbounded along some axes have a
# tree of their own with all that are unbounded along the same axes; items that are unbounded along all three stay
# outside of the trees.


def build_scene_trees(
    lowered: LoweredScene, room: Callable[[Tables], Geometry] = room_for
) -> tuple[Geometry, SceneTrees, LimitMaxima]:
    """Pack a lowered scene, with limits and the trees over its entries and over the leaves of its bodies.

    The tables of the scene are taken over. Large arrays are made as late, and released as early, as possible.

    Parameters
    ----------
    lowered : LoweredScene
        The scene; afterwards it holds only the shapes of its tables.
    room : Callable[[Tables], Geometry]
        Allocates memory for tables of these shapes.

    Returns
    -------
    tuple[Geometry, SceneTrees, LimitMaxima]
        The tables packed for kernels, where the trees end in them, and what the limits of surfaces follow from.
    """
    tables = lowered.take_tables()
    count, cells = len(tables.entry_kind), len(tables.cell_quadric)
    trim_heap(count)
    forest = program_trees(tables, lowered.layout is not None)
    trim_heap(count)
    depth = forest.depth
    blocks = _blocks(lowered)
    survey = forest.add(lowered.boxes if blocks else _take_boxes(lowered), 0, tables.entry_kind, blocks)
    levels = forest.levels
    forest.end_tree()
    trim_heap(count)
    columns = {**tables._asdict(), **forest.columns(), **limit_shapes(tables), "extent": scene_extent(survey)}
    columns.update(group_tables(np.diff(tables.cell_first)))
    geometry = room(Tables(**columns))
    put_sizes(geometry, tables)
    forest.put_boxes(geometry.floats, int(geometry.places[NODE_BOXES]))
    place, woods = forest.places[-2], SceneTrees.of(forest, depth, levels, lowered.layout is not None)
    del forest  # releases what the trees were built from
    trim_heap(count)
    limits, maxima = compute_limits(tables, lowered.boxes, lowered.rest, bool(survey.counts[0] == count))
    columns.update(limits)
    del tables
    trim_heap(count)
    _pack(geometry, columns, later=("node_boxes", "leaf_items", "group_bounds", "group_planes"))
    trim_heap(count)
    put_groups(geometry, 0, cells)
    put_items(geometry, lowered.boxes, place)
    if isinstance(lowered.bounds, LazyBounds):
        lowered.bounds.release()
    trim_heap(count)
    return geometry, woods, maxima


def _pack(geometry: Geometry, columns: dict[str, Any], later: tuple[str, ...]) -> None:
    """Copy the columns of tables, but for those that come later, to where kernels read them; empty `columns`.

    A column leaves as soon as it is copied, so that a large scene is never in memory twice.
    """
    rooms = unpack_tables(Tables(**columns), geometry)._asdict()
    # The largest first: while one is copied it exists twice, and at the beginning least has been copied
    for name in sorted(columns, key=lambda name: -columns[name].nbytes):
        table = columns.pop(name)
        if name not in later:
            copy_rows(rooms[name], table)


def _blocks(lowered: LoweredScene) -> Sequence[InstanceBlock]:
    """Return the blocks of a scene with instances; none where they hold few of its bodies, or most differ."""
    blocks = lowered.bounds.bodies.blocks() if isinstance(lowered.bounds, LazyBounds) else ()
    inside, forms = sum(block.size for block in blocks), {block.form for block in blocks}
    return blocks if 2 * inside > lowered.body_count and 2 * len(forms) <= len(blocks) else ()


def _take_boxes(lowered: LoweredScene) -> Floats:
    """Return the boxes of a scene and make it release them, where it can compute them again."""
    boxes = lowered.boxes
    if isinstance(lowered.bounds, LazyBounds):
        lowered.bounds.release()
    return boxes
