"""The trees of an edited scene from those of the scene before.

Entries that are gone are taken out of the leaves of the tree, whose boxes stay as they are. Those that are new are
loose: they go into a small tree beside it, which is built anew each time. When there are more loose ones than the
square root of all entries, or a quarter of the tree has left it, the tree is built anew, and so it is for few entries.
So a ray visits at most one small tree more.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..._util.arrays import is_member_sorted, unique_sorted
from ...kernels.bvh.walk import ROWS
from ...kernels.tables import Floats, Ints, Tables
from ..edits.in_place import InPlaceEdit
from ..edits.scene_edit import SpliceEdit
from ..row_layout import BODIES, LEAVES, PROGRAMS
from .builder import WIDTH, leaf_code, survey_boxes
from .trees import COSTS, Forest, SceneTrees, program_trees, scene_extent

_SMALL = 256
"""So few entries have their tree built anew."""
_NO_ROOT = np.iinfo(np.int32).min
_NO_CHILDREN = np.zeros((0, WIDTH), np.int32)


@dataclass
class _TreeTables:
    """Trees as tables have them: their nodes with boxes, the order of what they hold, and their roots."""

    nodes: Ints  # up to each tree
    places: Ints
    ends: Ints  # the same of roots
    children: Ints
    boxes: Floats
    order: Ints
    roots: Ints

    @classmethod
    def of(cls, tables: Tables, woods: SceneTrees) -> _TreeTables:
        """The trees of bodies, and of entries, of a scene."""
        return cls(
            woods.nodes, woods.places, tables.tree_root, tables.node_children, tables.node_boxes, tables.tree_order,
            tables.roots,
        )  # fmt: skip

    @classmethod
    def of_forest(cls, forest: Forest) -> _TreeTables:
        """Trees that have just been built."""
        boxes = np.empty(6 * WIDTH * sum(len(tree.children) for tree in forest.trees))
        forest.put_boxes(boxes, 0)
        nodes, places, ends = (np.array(part, np.int32) for part in (forest.nodes, forest.places, forest.ends))
        children, order = np.concatenate(forest.children), np.concatenate(forest.order)
        roots = np.array(forest.roots, np.int32)
        return cls(nodes, places, ends, children, boxes.reshape(-1, 6, WIDTH), order, roots)


@dataclass
class _TreeTablesBuilder:
    """Growing tables of trees."""

    children: list[Ints] = field(default_factory=lambda: [_NO_CHILDREN])
    boxes: list[Floats] = field(default_factory=list)
    order: list[Ints] = field(default_factory=lambda: [np.zeros(0, np.int32)])
    roots: list[Ints] = field(default_factory=lambda: [np.zeros(0, np.int32)])
    nodes: int = 0
    places: int = 0
    root_count: int = 0

    def add(self, children: Ints, boxes: Floats, order: Ints, roots: Ints, first_node: int, first_place: int) -> None:
        """Put trees behind these; their nodes and places are numbered from the first ones."""
        node, place = self.nodes - first_node, self.places - first_place
        if node or place:
            children, roots = _renumber_nodes(children, 1, node, place), _renumber_nodes(roots, 0, node, place)
        self.children.append(children)
        self.boxes.append(boxes)
        self.order.append(order)
        self.roots.append(roots)
        self.nodes += len(children)
        self.places += len(order)
        self.root_count += len(roots)


def _renumber_nodes(codes: Ints, least: int, nodes: int, places: int) -> Ints:
    """Children or roots, of which nodes are `least` or more, with other numbers."""
    moved: Ints = np.where(codes < 0, codes - (places << 4), np.where(codes >= least, codes + nodes, codes))
    return moved.astype(np.int32)


@dataclass
class PatchedTrees:
    """The tables of trees of an edited scene; boxes of nodes come in parts."""

    tables: dict[str, Any]
    boxes: list[Floats]
    woods: SceneTrees
    parts: list[tuple[int, int]]

    @property
    def kept(self) -> slice:
        """Of the items of leaves those that are what they were, but for leaves of `parts` of the children of nodes."""
        return slice(0, ROWS * (self.woods.main[1] - int(self.woods.places[-1])) if self.parts else 0)

    def apart(self) -> None:
        """Have boxes that do not change when those of the tree before are written over."""
        self.boxes = [np.concatenate(self.boxes)]

    def keep_items(self, tables: Tables, before: Tables | None) -> None:
        """Copy the items of leaves that are what they were; zeros come to places that no leaf has, whatever was there.

        before: None where those are there already. Of scenes that were edited in the same way so all numbers are equal,
        in whatever memory they are.
        """
        if before is not None:
            tables.leaf_items[self.kept] = before.leaf_items[self.kept]
        tables.leaf_items.reshape(-1, ROWS)[tables.tree_order[int(self.woods.places[-1]) :] < 0] = 0.0

    def put_boxes(self, node_boxes: Floats) -> None:
        """Write the boxes of the nodes."""
        at = 0
        for part in self.boxes:
            node_boxes[at : at + len(part)] = part
            at += len(part)


def patch_trees(old: Tables, woods: SceneTrees, edit: SpliceEdit | InPlaceEdit) -> PatchedTrees:
    """The trees of an edited scene."""
    planted, starts = _TreeTablesBuilder(), [[np.zeros(1, np.int32)] for _ in range(3)]
    new = program_trees(edit.joined.sides[1].tables)
    groves = _TreeTables.of(old, woods), _TreeTables.of_forest(new)
    for source, rows, _, leaf in edit.pieces.moved(PROGRAMS, LEAVES):
        grove = groves[source]
        for begins, part in zip(starts, (grove.nodes, grove.places, grove.ends), strict=True):
            begins.append(part[rows.start + 1 : rows.stop + 1] - part[rows.start] + begins[-1][-1])
        (a, b), (p, q), (r, s) = (
            (int(part[rows.start]), int(part[rows.stop])) for part in (grove.nodes, grove.places, grove.ends)
        )
        planted.add(grove.children[a:b], grove.boxes[a:b], grove.order[p:q] + np.int32(leaf), grove.roots[r:s], a, p)
    depth, (nodes, places, ends) = max(woods.depth, new.depth), map(np.concatenate, starts)
    found, parts = _entries(groves[0], woods, edit, planted)
    found = dataclasses.replace(found, nodes=nodes, places=places, depth=depth)
    roots = np.concatenate(planted.roots)
    stack = len(roots) - ends[-1] + WIDTH * (found.levels + 1)
    tables: dict[str, Any] = dict(
        node_children=np.concatenate(planted.children),
        tree_order=np.concatenate(planted.order),
        tree_root=np.append(ends, np.int32(len(roots))),
        roots=roots,
        tree_depth=np.array([max(depth, int(stack))], np.int32),
        node_boxes=np.broadcast_to(0.0, (planted.nodes, 6, WIDTH)),
        leaf_items=np.broadcast_to(0.0, ROWS * (planted.places - int(places[-1]))),
        extent=scene_extent(survey_boxes(edit.boxes)),
    )
    stays = edit.keeps_items and int(places[-1]) == int(woods.places[-1])
    return PatchedTrees(tables, planted.boxes, found, parts if stays else [])


def _entries(
    old: _TreeTables, woods: SceneTrees, edit: SpliceEdit | InPlaceEdit, planted: _TreeTablesBuilder
) -> tuple[SceneTrees, list[tuple[int, int]]]:
    """Plant the tree over the entries, and that of loose ones; of the woods only what is known of these.

    Then of the children of nodes those that are leaves with others in them than before; none where all may be that.
    """
    count = len(edit.boxes)
    number = np.full(len(edit.joined.sides[0].boxes) + 1, -1, np.int32)  # of each entry before; the last is none
    fresh = []
    for source, rows, at in edit.pieces.on(BODIES):
        if source == 0:
            number[rows] = np.arange(at.start, at.stop, dtype=np.int32)
        else:
            fresh.append(np.arange(at.start, at.stop, dtype=np.int32))
    stay = number[woods.loose]
    loose = np.concatenate([stay[stay >= 0], *fresh])
    main = slice(int(woods.places[-1]), woods.main[1])
    order = number[old.order[main]]
    left = woods.left + int((order < 0).sum() - (old.order[main] < 0).sum())
    if count <= _SMALL or len(loose) > math.sqrt(count) or 4 * left > count:
        forest = Forest()
        forest.add(edit.boxes, 0, COSTS[edit.kinds])
        levels = forest.levels
        forest.end_tree()
        grove = _TreeTables.of_forest(forest)
        planted.add(grove.children, grove.boxes, grove.order, grove.roots, 0, 0)
        made = dataclasses.replace(
            woods, levels=levels, main=(planted.nodes, planted.places, planted.root_count),
            loose=np.zeros(0, np.int32), left=0,
        )  # fmt: skip
        return made, []
    children, boxes, roots, changed = _remove_entries(old, woods, order)
    parts = [(WIDTH * planted.nodes + child, WIDTH * planted.nodes + child + 1) for child in changed]
    planted.add(children, boxes, order, roots, int(woods.nodes[-1]), main.start)
    end = planted.nodes, planted.places, planted.root_count
    forest = Forest()
    forest.add(edit.boxes[loose], 0, COSTS[edit.kinds][loose])
    forest.end_tree()
    grove = _TreeTables.of_forest(forest)
    planted.add(grove.children, grove.boxes, loose[grove.order], grove.roots, 0, 0)
    levels = max(woods.levels, len(forest.trees) and max(tree.levels for tree in forest.trees))
    made = dataclasses.replace(woods, levels=levels, main=end, loose=loose, left=left)
    return made, [*parts, (WIDTH * end[0], WIDTH * planted.nodes)]


def _remove_entries(old: _TreeTables, woods: SceneTrees, order: Ints) -> tuple[Ints, Floats, Ints, list[int]]:
    """(children, boxes, roots) of the tree over the entries without those for which `order` is -1, which is put right.

    Then which of the children are leaves that others have left.

    In a leaf the entries that stay come first; the places behind them belong to no leaf.
    """
    nodes, places = slice(int(woods.nodes[-1]), woods.main[0]), int(woods.places[-1])
    roots = old.roots[int(old.ends[len(woods.nodes) - 1]) : woods.main[2]].copy()
    children, boxes = old.children[nodes].copy(), old.boxes[nodes]
    flat = children.reshape(-1)
    held = np.flatnonzero(flat < 0)
    beside = np.flatnonzero(roots < 0)
    codes = np.concatenate([flat[held], roots[beside]])
    first, count = ((-codes - 1) >> 4) - places, (-codes - 1) & 15
    by_place = np.argsort(first)
    gone = np.flatnonzero(order < 0)
    leaf = by_place[np.searchsorted(first[by_place], gone, side="right") - 1]
    within = gone < first[leaf] + count[leaf]
    found: list[int] = []
    changed: list[int] = []
    for which in unique_sorted(leaf[within]).tolist():
        begin, size = int(first[which]), int(count[which])
        members = order[begin : begin + size]
        stay = members[members >= 0]
        order[begin : begin + size] = -1
        order[begin : begin + len(stay)] = stay
        code = leaf_code(begin + places, len(stay)) if len(stay) else 0
        if which < len(held):
            flat[held[which]] = code
            (changed if code else found).append(int(held[which]))
        else:
            roots[beside[which - len(held)]] = code or _NO_ROOT
    roots = roots[roots != _NO_ROOT]
    node, emptied = nodes.start, np.array(found, np.int64)
    gone_boxes = [emptied]
    while len(emptied):  # nodes of which all children are gone, and so on up
        bare = unique_sorted(emptied // WIDTH)
        bare = bare[~children[bare].any(axis=1)]
        emptied = np.flatnonzero(is_member_sorted(flat, bare + node) & (flat > 0)) if len(bare) else bare
        flat[emptied] = 0
        gone_boxes.append(emptied)
        roots = roots[~is_member_sorted(roots, bare + node)]
    at = np.concatenate(gone_boxes)
    if len(at):
        boxes = boxes.copy()
        boxes[at // WIDTH, :3, at % WIDTH] = np.inf
        boxes[at // WIDTH, 3:, at % WIDTH] = -np.inf
    return children, boxes, roots, changed
