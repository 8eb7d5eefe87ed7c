"""Patch the trees of the scene before an edit.

Removed entries leave the leaves of the tree over the entries, whose boxes stay. New ones are loose: they go into a
small second tree, which each edit rebuilds. The tree is rebuilt when the loose entries outnumber the square root of all
entries, when a quarter of the tree has left it, or when entries are few. So a ray visits at most one small tree more.

User: loops that move one body among many; factor over a new tree, up to the next first hit: 1.5 for one of 10,000
balls, boxes or Booleans, which must take 10 ms at most (processor time, one thread, 2026-11-28).
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import field
from typing import Any, Protocol

import numpy as np

from ..._util.arrays import is_member_sorted, unique_sorted
from ..._util.records import dataclass
from ...kernels.bvh.walk import ROUND, ROWS, WHO
from ...kernels.tables import Floats, Geometry, Ints, Tables
from ..edits.buffer_pool import TableRows, UneditableError
from ..edits.scene_splice import SceneSplice, SplicePieces
from ..mmap_arrays import mapped_zeros
from ..row_layout import BODIES, CELLS, LEAVES, PROGRAMS
from .builder import WIDTH, leaf_code, survey_boxes
from .leaf_items import put_items
from .plane_groups import group_tables, put_groups
from .trees import Forest, SceneTrees, program_trees, scene_extent

_SMALL = 256
"""For so few entries the tree is rebuilt."""
_NO_ROOT = np.iinfo(np.int32).min
_NO_CHILDREN = np.zeros((0, WIDTH), np.int32)


class TableEdit(Protocol):
    """An edit of a scene's tables, as its trees see it."""

    @property
    def splice(self) -> SceneSplice:
        """The scene before and the new entries."""

    @property
    def pieces(self) -> SplicePieces:
        """The rows that come from either."""

    @property
    def boxes(self) -> Floats:
        """The boxes of the edited scene's bodies."""

    @property
    def kinds(self) -> Ints:
        """The kinds of its entries, for the costs of trees."""

    @property
    def keeps_items(self) -> bool:
        """Whether leaf items of unchanged entries can be kept."""


@dataclass
class _TreeTables:
    """Trees as tables have them: nodes with boxes, the order of their items, and their roots."""

    nodes: Ints  # ends of the trees
    places: Ints
    ends: Ints  # ends among the roots
    children: Ints
    boxes: Floats
    order: Ints
    roots: Ints

    @classmethod
    def of(cls, tables: Tables, woods: SceneTrees) -> _TreeTables:
        """View the trees of a scene: those of bodies, and that of the entries."""
        return cls(
            woods.nodes, woods.places, tables.tree_root, tables.node_children, tables.node_boxes, tables.tree_order,
            tables.roots,
        )  # fmt: skip

    @classmethod
    def of_forest(cls, forest: Forest) -> _TreeTables:
        """Write out trees that were just built."""
        boxes = np.empty(6 * WIDTH * sum(len(tree.children) for tree in forest.trees))
        forest.put_boxes(boxes, 0)
        nodes, places, ends = (np.array(part, np.int32) for part in (forest.nodes, forest.places, forest.ends))
        children, order = np.concatenate(forest.children), np.concatenate(forest.order)
        roots = np.array(forest.roots, np.int32)
        return cls(nodes, places, ends, children, boxes.reshape(-1, 6, WIDTH), order, roots)


@dataclass
class _TreeTablesBuilder:
    """Tables of trees under construction."""

    children: list[Ints] = field(default_factory=lambda: [_NO_CHILDREN])
    boxes: list[Floats] = field(default_factory=list)
    order: list[Ints] = field(default_factory=lambda: [np.zeros(0, np.int32)])
    roots: list[Ints] = field(default_factory=lambda: [np.zeros(0, np.int32)])
    nodes: int = 0
    places: int = 0
    root_count: int = 0

    def add(self, children: Ints, boxes: Floats, order: Ints, roots: Ints, first_node: int, first_place: int) -> None:
        """Append trees; their nodes and places are numbered from `first_node` and `first_place`."""
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
    """Shift the numbers in children or roots; a code >= `least` is a node, a negative one a leaf."""
    moved: Ints = np.where(codes < 0, codes - (places << 4), np.where(codes >= least, codes + nodes, codes))
    return moved.astype(np.int32)


@dataclass
class PatchedTrees:
    """The tables of trees of an edited scene; boxes of nodes in parts.

    `parts`: ranges of children with changed leaves.
    """

    tables: dict[str, Any]
    boxes: list[Floats]
    woods: SceneTrees
    parts: list[tuple[int, int]]

    @property
    def unchanged_items(self) -> slice:
        """The leaf items that stay as they were, except in leaves of `parts`."""
        return slice(0, ROWS * (self.woods.main[1] - int(self.woods.places[-1])) if self.parts else 0)

    def copy_boxes(self) -> None:
        """Copy the boxes, before the memory of the tree before is overwritten."""
        self.boxes = [np.concatenate(self.boxes)]

    def keep_items(self, tables: Tables, before: Tables | None) -> None:
        """Copy the unchanged leaf items from the tables before; None: they are there already.

        Zeros go to places that no leaf has, whatever the memory held. So scenes that were edited in the same way are
        equal in all numbers.
        """
        if before is not None:
            tables.leaf_items[self.unchanged_items] = before.leaf_items[self.unchanged_items]
        tables.leaf_items.reshape(-1, ROWS)[tables.tree_order[int(self.woods.places[-1]) :] < 0] = 0.0

    def put_boxes(self, node_boxes: Floats) -> None:
        """Write the boxes of the nodes."""
        at = 0
        for part in self.boxes:
            node_boxes[at : at + len(part)] = part
            at += len(part)


def patch_trees(old: Tables, woods: SceneTrees, edit: TableEdit) -> PatchedTrees:
    """Compute the trees of an edited scene.

    Parameters
    ----------
    old, woods : Tables, SceneTrees
        The tables and trees of the scene before.
    edit : TableEdit
        The edited scene, whose tables are not filled yet.

    Returns
    -------
    PatchedTrees
        Their tables; boxes and leaf items are written later, where there is memory for them.
    """
    patched, starts = _TreeTablesBuilder(), [[np.zeros(1, np.int32)] for _ in range(3)]
    new = program_trees(edit.splice.sides[1].tables)
    sources = _TreeTables.of(old, woods), _TreeTables.of_forest(new)
    for source, rows, _, leaf in edit.pieces.moved(PROGRAMS, LEAVES):
        built = sources[source]
        for begins, part in zip(starts, (built.nodes, built.places, built.ends), strict=True):
            begins.append(part[rows.start + 1 : rows.stop + 1] - part[rows.start] + begins[-1][-1])
        (a, b), (p, q), (r, s) = (
            (int(part[rows.start]), int(part[rows.stop])) for part in (built.nodes, built.places, built.ends)
        )
        patched.add(built.children[a:b], built.boxes[a:b], built.order[p:q] + np.int32(leaf), built.roots[r:s], a, p)
    depth, (nodes, places, ends) = max(woods.depth, new.depth), map(np.concatenate, starts)
    found, parts = _entries(sources[0], woods, edit, patched)
    found = dataclasses.replace(found, nodes=nodes, places=places, depth=depth)
    roots = np.concatenate(patched.roots)
    stack = len(roots) - ends[-1] + WIDTH * (found.levels + 1)
    tables: dict[str, Any] = dict(
        node_children=np.concatenate(patched.children),
        tree_order=np.concatenate(patched.order),
        tree_root=np.append(ends, np.int32(len(roots))),
        roots=roots,
        tree_depth=np.array([max(depth, int(stack))], np.int32),
        node_boxes=np.broadcast_to(0.0, (patched.nodes, 6, WIDTH)),
        leaf_items=np.broadcast_to(0.0, ROWS * (patched.places - int(places[-1]))),
        extent=scene_extent(survey_boxes(edit.boxes)),
        **_groups(old, edit),
    )
    stays = edit.keeps_items and int(places[-1]) == int(woods.places[-1])
    return PatchedTrees(tables, patched.boxes, found, parts if stays else [])


def _groups(old: Tables, edit: TableEdit) -> dict[str, Any]:
    """Return the groups of planes: those of cells that stay, and room for those of new ones."""
    sides = [side.tables.cell_first for side in edit.splice.sides]
    if not len(old.cell_groups) and not len(group_tables(np.diff(sides[1]))["cell_groups"]):
        return group_tables(np.zeros(0, np.int64))
    counts = [np.diff(first) for first in sides]
    of_pieces = [counts[source][rows] for source, rows, _ in edit.pieces.on(CELLS)]
    columns = group_tables(np.concatenate([counts[0][:0], *of_pieces]))
    # A plane that stays may take the record of an equal one: it differs by rounding, which the limits of t cover
    first = columns["cell_groups"]
    if len(first):
        for name in ("group_bounds", "group_planes"):
            column = columns[name] = np.zeros(columns[name].shape, columns[name].dtype)
            for source, rows, at in edit.pieces.on(CELLS):
                if source == 0 and len(old.cell_groups):
                    a, b = old.cell_groups[[rows.start, rows.stop]].tolist()
                    column[first[at.start] : first[at.stop]] = getattr(old, name)[a:b]
    return columns


def put_new_groups(geometry: Geometry, edit: TableEdit) -> None:
    """Fill the groups of planes of new cells."""
    for source, _, at in edit.pieces.on(CELLS):
        if source == 1:
            put_groups(geometry, at.start, at.stop)


def _entries(
    old: _TreeTables, woods: SceneTrees, edit: TableEdit, patched: _TreeTablesBuilder
) -> tuple[SceneTrees, list[tuple[int, int]]]:
    """Add the tree over the entries, and that of loose ones; return what edits need to know about these.

    Return also the ranges of children of nodes that are leaves with other entries than before; none where all may be.
    """
    count = len(edit.boxes)
    # New number of each old entry; the last stands for no entry
    number = np.full(len(edit.splice.sides[0].boxes) + 1, -1, np.int32)
    fresh = []
    for source, rows, at in edit.pieces.on(BODIES):
        if source == 0:
            number[rows] = np.arange(at.start, at.stop, dtype=np.int32)
        else:
            fresh.append(np.arange(at.start, at.stop, dtype=np.int32))
    stay = number[woods.loose]
    # New entries go to a small tree of their own, so that the large one only loses entries and its boxes stay valid
    loose = np.concatenate([stay[stay >= 0], *fresh])
    main = slice(int(woods.places[-1]), woods.main[1])
    order = number[old.order[main]]
    left = woods.removals + int((order < 0).sum() - (old.order[main] < 0).sum())
    # Each query walks both trees, and empty places cost a test: beyond these shares a new tree pays
    if count <= _SMALL or len(loose) > math.sqrt(count) or 4 * left > count:
        forest = Forest()
        forest.add(edit.boxes, 0, edit.kinds)
        levels = forest.levels
        forest.end_tree()
        built = _TreeTables.of_forest(forest)
        patched.add(built.children, built.boxes, built.order, built.roots, 0, 0)
        described = dataclasses.replace(
            woods, levels=levels, main=(patched.nodes, patched.places, patched.root_count),
            loose=np.zeros(0, np.int32), removals=0,
        )  # fmt: skip
        return described, []
    children, boxes, roots, changed = _remove_entries(old, woods, order)
    parts = [(WIDTH * patched.nodes + child, WIDTH * patched.nodes + child + 1) for child in changed]
    patched.add(children, boxes, order, roots, int(woods.nodes[-1]), main.start)
    end = patched.nodes, patched.places, patched.root_count
    forest = Forest()
    forest.add(edit.boxes[loose], 0, edit.kinds[loose])
    forest.end_tree()
    built = _TreeTables.of_forest(forest)
    patched.add(built.children, built.boxes, loose[built.order], built.roots, 0, 0)
    levels = max(woods.levels, len(forest.trees) and max(tree.levels for tree in forest.trees))
    described = dataclasses.replace(woods, levels=levels, main=end, loose=loose, removals=left)
    return described, [*parts, (WIDTH * end[0], WIDTH * patched.nodes)]


def _remove_entries(old: _TreeTables, woods: SceneTrees, order: Ints) -> tuple[Ints, Floats, Ints, list[int]]:
    """Remove the entries for which `order` is -1 from the tree over the entries; `order` is corrected in place.

    Return (children, boxes, roots, positions of the children that are leaves with fewer entries). In a leaf the
    remaining entries come first; the places behind them belong to no leaf.
    """
    nodes, places = slice(int(woods.nodes[-1]), woods.main[0]), int(woods.places[-1])
    roots = old.roots[int(old.ends[len(woods.nodes) - 1]) : woods.main[2]].copy()
    children, boxes = old.children[nodes].copy(), old.boxes[nodes]
    flat = children.reshape(-1)
    leaves = np.flatnonzero(flat < 0)
    root_leaves = np.flatnonzero(roots < 0)
    codes = np.concatenate([flat[leaves], roots[root_leaves]])
    first, count = ((-codes - 1) >> 4) - places, (-codes - 1) & 15
    # Leaves are runs of `order`: the one that holds a place begins at the last start at or before it
    by_place = np.argsort(first)
    removed = np.flatnonzero(order < 0)
    leaf = by_place[np.searchsorted(first[by_place], removed, side="right") - 1]
    within = removed < first[leaf] + count[leaf]
    found: list[int] = []
    changed: list[int] = []
    for which in unique_sorted(leaf[within]).tolist():
        begin, size = int(first[which]), int(count[which])
        members = order[begin : begin + size]
        stay = members[members >= 0]
        order[begin : begin + size] = -1
        order[begin : begin + len(stay)] = stay
        code = leaf_code(begin + places, len(stay)) if len(stay) else 0
        if which < len(leaves):
            flat[leaves[which]] = code
            (changed if code else found).append(int(leaves[which]))
        else:
            roots[root_leaves[which - len(leaves)]] = code or _NO_ROOT
    roots = roots[roots != _NO_ROOT]
    node, emptied = nodes.start, np.array(found, np.int64)
    gone_boxes = [emptied]
    while len(emptied):  # nodes whose children are all gone, and their parents in turn
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


# Scenes with instances: their trees are patched in place, behind which there is room


def remove_from_leaf(rows: TableRows, woods: SceneTrees, entry: int) -> SceneTrees:
    """Take an entry of a scene with instances out of its leaf; boxes of nodes stay."""
    base, order = int(woods.places[-1]), rows["tree_order"]
    place = base + int(np.flatnonzero(order[base : woods.main[1]] == entry)[0])
    children = rows["node_children"][: woods.main[0]].reshape(-1)
    # A leaf with this place begins at most 15 before
    near = np.flatnonzero((children >= leaf_code(place, 15)) & (children <= leaf_code(max(place - 15, 0), 0)))
    codes = -children[near] - 1
    near = near[(codes >> 4 <= place) & (place < (codes >> 4) + (codes & 15))]
    if len(near) != 1 or 4 * (woods.removals + 1) > len(order):
        raise UneditableError
    child = int(near[0])
    begin, count = (-int(children[child]) - 1) >> 4, (-int(children[child]) - 1) & 15
    at = ROWS * (begin - base)
    block = rows["leaf_items"][at : at + ROWS * count]
    items = block.reshape(ROWS, count).copy()
    mark = items[WHO, 0] % 1.0
    assert mark in (0.0, ROUND)
    items[WHO, 0] -= mark
    items = np.delete(items, place - begin, axis=1)
    items[WHO, :1] += mark
    block[:] = np.append(items.ravel(), np.zeros(ROWS))
    order[begin : begin + count] = np.append(np.delete(order[begin : begin + count], place - begin), -1)
    children[child] = leaf_code(begin, count - 1) if count > 1 else 0
    if count == 1:
        box = rows["node_boxes"][child // WIDTH, :, child % WIDTH]
        box[:3], box[3:] = np.inf, -np.inf
    return dataclasses.replace(woods, removals=woods.removals + 1)


def plant_entries(rows: TableRows, woods: SceneTrees, loose: dict[int, Floats], bodies: int) -> SceneTrees:
    """Build the small tree over some entries of so many bodies behind the large one; `loose` has their boxes."""
    (nodes, places, roots), base = woods.main, int(woods.places[-1])
    entries = np.array(sorted(loose), np.int32)
    if len(entries) > max(16.0, math.sqrt(bodies)):
        raise UneditableError
    # Only the boxes of these entries are read
    boxes = mapped_zeros((bodies, 6), np.float64, sparse=True)
    forest, order = Forest(nodes, places), rows["tree_order"]
    if len(entries):
        boxes[entries] = [loose[entry] for entry in entries.tolist()]
        if not np.isfinite(boxes[entries]).any(axis=1).all():
            raise UneditableError
        forest.add(boxes[entries], 0, rows["entry_kind"][entries])
    main = int(rows["tree_root"][-2])
    for code in rows["roots"][main:roots].tolist():
        if code < 0:  # entries without an end: their leaves are written again
            begin = (-code - 1) >> 4
            boxes[order[begin : begin + ((-code - 1) & 15)]] = [-np.inf] * 3 + [np.inf] * 3
    rows.resize("tree_order", places + len(entries))[places:] = entries[np.concatenate(forest.order)]
    rows.resize("leaf_items", ROWS * (places - base + len(entries)))
    children = np.concatenate(forest.children)
    rows.resize("node_children", nodes + len(children))[nodes:] = children
    rows.resize("node_boxes", nodes + len(children))
    forest.put_boxes(rows["node_boxes"][nodes:].reshape(-1), 0)
    rows.resize("roots", roots + len(forest.roots))[roots:] = forest.roots
    rows["tree_root"][-1] = roots + len(forest.roots)
    levels = max(woods.levels, forest.levels)
    stack = len(rows["roots"]) - main + WIDTH * (levels + 1)
    rows["tree_depth"][0] = max(woods.depth, stack)
    put_items(rows.geometry, boxes, base, [(WIDTH * nodes, WIDTH * (nodes + len(children)))])
    return dataclasses.replace(woods, loose=entries)
