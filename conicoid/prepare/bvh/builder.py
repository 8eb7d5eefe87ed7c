"""Build one tree: a binary tree by the surface area heuristic, then the nodes of eight that cost least.

A subtree may become one node, or several slots of the node above it; the cheapest choice follows from the cheapest
choices for its halves (Ylitie, Karras, Laine: Efficient incoherent ray traversal on GPUs through compressed wide BVHs,
HPG 2017). The cost of a tree is the sum over its nodes of their area, plus for each leaf its area times the cost of
visiting it and testing its entries; visiting a node costs one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ..._jit.decorators import helper, inline, kernel, record_shapes
from ..._util.arrays import row_lengths
from ..._util.records import dataclass
from ...geometry.instances import InstanceBlock
from ...kernels.bvh.culling_constants import ORIGIN_SLACK, WALL
from ...kernels.bvh.walk import leaf_range
from ...kernels.tables import BALL, CELL, POLYGON, REGION, SHEET, Floats, Ints, Longs, Signs
from ...kernels.threads import KernelRange, run_calls, run_chunks
from ..mmap_arrays import mapped_zeros
from .sah_binning import (
    BINS,
    BOXES,
    COST,
    HIGH,
    ITEM,
    NEGATED_LOW,
    SIZE,
    boxes_in,
    clear_box,
    copy_box,
    cut_group,
    half_area,
    join_box,
    partition_large,
)

WIDTH = 8
ROW = 8  # numbers for each branch: at j = 1..7 the cost of j slots, and how many of them the left half takes
LEAF_COST = 0.3  # of visiting a leaf, without testing its entries
# Places in `choice`: the count of entries if a leaf is best, else 0; slots of the left half in a node of its own
LEAF, NODE = 1, 0


@record_shapes(left="branches", first="branches", last="branches", choice="8*branches")
class Branches(NamedTuple):
    """A binary tree. Branches within records [begin, end) have numbers from 2 begin on, the first ones from 2 n on."""

    left: Ints  # its left half; the right half has the next number; -1: one entry
    first: Ints  # its first record
    last: Ints
    choice: Signs  # (8 branches,) see `LEAF`, `NODE`


def new_branches(count: int) -> Branches:
    """Allocate `count` branches."""
    return Branches(
        np.empty(count, np.int32), np.empty(count, np.int32), np.empty(count, np.int32), np.zeros(ROW * count, np.int8)
    )


@inline
def _put(branches: Branches, branch: int, left: int, first: int, last: int) -> None:
    """Write a branch over records first..last."""
    branches.left[branch], branches.first[branch], branches.last[branch] = left, first, last


@inline
def _cost_of_one(records: Floats, branches: Branches, branch: int, costs: Floats, at: int) -> None:
    """Write the costs of a single entry: it takes one slot, however many are available."""
    first = SIZE * branches.first[branch]
    cost = half_area(records, first) * (LEAF_COST + records[first + COST])
    for j in range(1, ROW):
        costs[at + j] = cost
    branches.choice[ROW * branch + LEAF] = 1


@helper
def weigh(branches: Branches, branch: int, area: float, as_leaf: float, costs: Floats, at: int, half: int) -> None:
    """Compute the costs of a branch from those of its halves, costs[half:] and costs[half + 8:]."""
    choice, size = branches.choice, branches.last[branch] - branches.first[branch]
    left = branches.left[branch]
    other, is_one = half + ROW, branches.last[left] - branches.first[left] == 1
    for slots in range(2, WIDTH + 1):
        best, taken = costs[half + 1] + costs[other + slots - 1], 1
        if not is_one:
            # A half takes one to seven slots, and a single entry one: eight would be a node of its own
            for k in range(max(2, slots - 7), min(slots, WIDTH)):
                cost = costs[half + k] + costs[other + slots - k]
                if cost < best:
                    best, taken = cost, k
        if slots == WIDTH:
            choice[ROW * branch + NODE] = taken
            as_node = best + area
        else:
            choice[ROW * branch + slots] = taken
            costs[at + slots] = best
    costs[at + 1] = min(as_node, as_leaf)
    choice[ROW * branch + LEAF] = size if as_leaf < as_node else 0
    for slots in range(2, WIDTH):
        # Fewer slots may cost less.
        if costs[at + slots - 1] <= costs[at + slots]:
            costs[at + slots] = costs[at + slots - 1]
            choice[ROW * branch + slots] = 0


@inline
def _cost_as_leaf(records: Floats, first: int, last: int, area: float, most: int) -> float:
    """Return the cost of a branch as one leaf; infinite for more than `most` entries."""
    if last - first > most:
        return math.inf
    cost = 0.0
    for i in range(first, last):
        cost += records[SIZE * i + COST]
    return area * (LEAF_COST + cost)


@inline
def _load_cell(source: Floats, cells: Floats, cell: int, records: Floats, first: int, last: int) -> None:
    """Copy the records of a cell to records first..last."""
    place = np.int64(cells[SIZE * cell + ITEM])
    for k in range(last - first):
        if 0 <= place + k < len(source) // SIZE:
            copy_box(records, SIZE * (first + k), source, SIZE * (place + k))


@kernel(
    records="out 8*n", source="8*s", cells="out 8*c", branches="out", root="0..branches-1", root_costs="out m",
    row="0..m-8",
)  # fmt: skip
def grow(
    records: Floats, source: Floats, cells: Floats, branches: Branches, root: int, area: float, most: int,
    root_costs: Floats, row: int,
) -> None:  # fmt: skip
    """Build a branch down to its entries, and weigh it: its costs go to root_costs[row:]. Leaves hold `most`.

    Where there are cells, the records come from `source`.
    """
    begin, end = branches.first[root], branches.last[root]
    is_whole = 0 <= begin < end <= len(records) // SIZE and 2 * end <= len(branches.first)
    if not is_whole or len(cells) > SIZE * (end - begin):
        return
    base, used = 2 * begin, 2 * begin
    boxes, counts = np.empty(BOXES), np.empty(3 * BINS, np.int64)
    areas, costs = np.empty(2 * (end - begin)), np.empty(ROW * 2 * (end - begin))
    # 64 levels: with the smaller half first the stack holds the logarithm of the number of entries
    stack, top = np.empty((64, 3), np.int64), 1
    stack[0, 0], stack[0, 1], stack[0, 2] = root, 0, len(cells) // SIZE
    while top > 0:
        top -= 1
        branch, cell, border, last_cell = stack[top, 0], stack[top, 1], stack[top, 1], stack[top, 2]
        first, last = branches.first[branch], branches.last[branch]
        if last_cell - cell == 1:
            _load_cell(source, cells, cell, records, first, last)
            last_cell = cell
        if last - first == 1:
            branches.left[branch] = -1
            continue
        if last_cell > cell:
            border, left_area, right_area = cut_group(cells, cell, last_cell, True, boxes, counts)
            # Clipped: a wrong cell may count more records than there are
            middle = first + max(border - cell, boxes_in(cells, cell, border))
            middle = min(middle, last - (last_cell - border))
        else:
            middle, left_area, right_area = cut_group(records, first, last, False, boxes, counts)
        branches.left[branch] = used
        _put(branches, used, -1, first, middle)
        _put(branches, used + 1, -1, middle, last)
        areas[used - base], areas[used + 1 - base] = left_area, right_area
        # The smaller half comes first: so the stack stays below the logarithm of the size.
        after = 1 if middle - first > last - middle else 0
        stack[top + after, 0], stack[top + after, 1], stack[top + after, 2] = used + 1, border, last_cell
        stack[top + 1 - after, 0], stack[top + 1 - after, 1], stack[top + 1 - after, 2] = used, cell, border
        used += 2
        top += 2
    # Children have larger numbers than their parents, so that backwards is from the leaves up
    for branch in range(used - 1, base - 1, -1):
        at, left = ROW * (branch - base), branches.left[branch]
        if left < 0:
            _cost_of_one(records, branches, branch, costs, at)
        else:
            here = areas[branch - base]
            as_leaf = _cost_as_leaf(records, branches.first[branch], branches.last[branch], here, most)
            weigh(branches, branch, here, as_leaf, costs, at, ROW * (left - base))
    # The halves of the root are the first two rows of costs; the last row is free.
    at = len(costs) - ROW
    if branches.left[root] < 0:
        _cost_of_one(records, branches, root, costs, at)
    else:
        weigh(branches, root, area, _cost_as_leaf(records, begin, end, area, most), costs, at, 0)
    for j in range(1, ROW):
        root_costs[row + j] = costs[at + j]


@kernel(branches="out", first="0..branches-groups", areas="groups", costs="out 8*groups")
def weigh_first(branches: Branches, first: int, areas: Floats, costs: Floats) -> None:
    """Weigh the branches from number `first` on whose halves are known: the groups that were split."""
    for k in range(len(areas) - 1, -1, -1):
        left = branches.left[first + k]
        if first <= left < first + len(areas) - 1:
            weigh(branches, first + k, areas[k], math.inf, costs, ROW * k, ROW * (left - first))


# The records that a tree is built from: boxes that are moved about, without empty ones and without infinities
#
# An unbounded side of a box gets an end a little beyond everything finite, which `restore_limit` turns back in the
# nodes. Boxes are widened, so that neither the rounding of a slab test nor that of the origin of a ray that starts on a
# surface ever loses what they hold (`kernels/bvh/culling_constants.py`).

EMPTY, ENDLESS = 8, 7
CHUNK = 1 << 16
COSTS = np.ones(5)
"""Cost of testing an entry of each kind, where visiting a node costs one."""
COSTS[[BALL, CELL, REGION, SHEET, POLYGON]] = 0.1, 0.8, 4.0, 1.0, 1.0


class BoxSurvey(NamedTuple):
    """The boxes (n, 6) of a tree, sorted by the axes along which they are unbounded."""

    patterns: Signs  # (n,) bit k: unbounded along axis k; EMPTY: nothing in it
    counts: Ints  # (9,) count of boxes of each pattern
    bounded: Floats  # (6,) around the bounded boxes
    ends: Floats  # (6,) around all finite ends


def survey_boxes(boxes: Floats) -> BoxSurvey:
    """Sort boxes by the axes along which they are unbounded."""
    chunks = max(1, -(-len(boxes) // CHUNK))
    patterns = np.empty(len(boxes), np.int8)
    counts, extents = np.zeros((chunks, 9), np.int64), np.full((chunks, 2, 6), np.inf)
    extents[:, :, 3:] = -np.inf
    ends = [min(len(boxes), k * CHUNK) for k in range(chunks + 1)]
    run_calls(_survey, [(boxes, ends[k], ends[k + 1], patterns, counts[k], extents[k]) for k in range(chunks)])
    low, high = extents[:, :, :3].min(axis=0), extents[:, :, 3:].max(axis=0)
    bounded, finite = np.concatenate([low, high], axis=1)
    return BoxSurvey(patterns, counts.sum(axis=0).astype(np.int32), bounded, finite)


@kernel(boxes="n 6", begin="0..end", end="0..n", patterns="out n", counts="out 9", around="out 2 6")
def _survey(boxes: Floats, begin: int, end: int, patterns: Signs, counts: Longs, around: Floats) -> None:
    """Write the patterns of boxes begin..end, their counts, and the boxes around them."""
    ax = ay = az = math.inf
    bx = by = bz = -math.inf
    count = 0
    for i in range(begin, end):
        pattern, empty = 0, False
        if _is_bounded(boxes, i):
            patterns[i], count = 0, count + 1
            ax, ay, az = min(ax, boxes[i, 0]), min(ay, boxes[i, 1]), min(az, boxes[i, 2])
            bx, by, bz = max(bx, boxes[i, 3]), max(by, boxes[i, 4]), max(bz, boxes[i, 5])
            continue
        for k in range(3):
            low, high = boxes[i, k], boxes[i, k + 3]
            empty = empty or not low <= high
            if not (low > -math.inf and high < math.inf):
                # A side without an end, or of NaN, counts as unbounded along the axis
                pattern |= 1 << k
        if empty:
            pattern = EMPTY
        patterns[i] = pattern
        counts[pattern] += 1
        if empty:
            continue
        for k in range(3):
            low, high = boxes[i, k], boxes[i, k + 3]
            if low > -math.inf:
                around[1, k] = low if low < around[1, k] else around[1, k]
                around[1, k + 3] = low if low > around[1, k + 3] else around[1, k + 3]
            if high < math.inf:
                around[1, k] = high if high < around[1, k] else around[1, k]
                around[1, k + 3] = high if high > around[1, k + 3] else around[1, k + 3]
    counts[0] += count
    least, most = (ax, ay, az), (bx, by, bz)
    for part in range(2):
        for k in range(3):
            around[part, k], around[part, k + 3] = min(around[part, k], least[k]), max(around[part, k + 3], most[k])


@inline
def _is_bounded(boxes: Floats, i: int) -> bool:
    """Return whether a box holds something, and has a finite end on each side."""
    found = True
    for k in range(3):
        low, high = boxes[i, k], boxes[i, k + 3]
        found &= (low > -math.inf) & (low <= high) & (high < math.inf)
    return found


def finite_limits(ends: Floats) -> Floats:
    """Return (6,) finite numbers beyond all finite ends, which replace -inf and inf."""
    low, high = np.where(ends[:3] <= ends[3:], ends[:3], 0.0), np.where(ends[:3] <= ends[3:], ends[3:], 0.0)
    # As far beyond as the scene is wide; a thousandth of the coordinates where it is thin
    beyond = max(float(row_lengths(high - low)), 1e-3 * float(np.abs([low, high]).max())) or 1.0
    return np.concatenate([low - beyond, high + beyond])


def box_records(boxes: Floats, rows: Ints, first_item: int, kinds: Signs, limits: Floats) -> Floats:
    """Build records (8 n,): a vector for each of `rows` (empty: all boxes), of item first_item + row.

    `kinds` are those of the boxes, whose costs are COSTS; empty: each costs 1.
    """
    count = len(rows) or len(boxes)
    records = np.empty(SIZE * count)
    run_chunks(KernelRange(_load, (boxes, rows), (first_item, kinds, COSTS, limits, records)), count, CHUNK)
    return records


@kernel(boxes="b 6", rows="n|0", begin="0..end", end="0..n", kinds="b|0", costs="5", limits="6", records="out 8*n")
def _load(
    boxes: Floats, rows: Ints, begin: int, end: int, first_item: int, kinds: Signs, costs: Floats, limits: Floats,
    records: Floats,
) -> None:  # fmt: skip
    """Write records begin..end, widened by their slack."""
    for i in range(begin, end if len(rows) > 0 else min(end, len(boxes))):
        row = rows[i] if len(rows) > 0 else i
        margin = ORIGIN_SLACK * _size(boxes, row, limits) + WALL
        for k in range(3):
            low, high = boxes[row, k], boxes[row, k + 3]
            records[SIZE * i + NEGATED_LOW + k] = margin - low if low > -math.inf else -limits[k]
            records[SIZE * i + HIGH + k] = high + margin if high < math.inf else limits[k + 3]
        kind = kinds[row] if len(kinds) > 0 else -1
        records[SIZE * i + COST] = costs[kind] if 0 <= kind < len(costs) else 1.0
        records[SIZE * i + ITEM] = first_item + row


@inline
def _size(boxes: Floats, row: int, limits: Floats) -> float:
    """Return a bound on |x| + |y| + |z| over a box; where it is unbounded, over its part within the limits."""
    size = 0.0
    for k in range(3):
        low, high = boxes[row, k], boxes[row, k + 3]
        size += max(abs(low if low > -math.inf else limits[k]), abs(high if high < math.inf else limits[k + 3]))
    return size


@inline
def restore_limit(limits: Floats, k: int, value: float) -> float:
    """Turn a stand-in for infinity back: k in 0..2 low, 3..5 high."""
    if k < 3:
        return -math.inf if value <= limits[k] else value
    return math.inf if value >= limits[k] else value


# From branches to nodes of eight, as the tables hold them


def leaf_code(first: int, count: int) -> int:
    """Encode a leaf of entries first, first + 1, ... of `tree_order` as a number < 0; count is at most 15."""
    return -((first << 4) | count) - 1


_leaf_code = inline(leaf_code)


@kernel(roots="u", begin="0..end", end="0..u", starts="u+1", children="out n 8", found="out u 3", lower="out l 3")
def take_nodes(
    branches: Branches, upper: int, roots: Longs, begin: int, end: int, starts: Longs, children: Ints, found: Longs,
    lower: Longs,
) -> int:  # fmt: skip
    """Write the nodes of the trees of eight below the branches roots[begin:end].

    They go to children[starts[begin]:starts[end]] without gaps, each before those below it, and are numbered from 0 for
    each root; found[u] is (nodes, levels, place of the first), no nodes where the branches are no tree. Branches from
    `upper` on whose halves are such branches are descended to alone: others become rows of `lower` (branch, place in
    `children`, level). Return how many.
    """
    base, limit, count = starts[begin], starts[end], 0
    if not 0 <= base <= limit <= len(children):
        return 0
    most = 0
    for u in range(begin, end):
        most = max(most, starts[u + 1] - starts[u])
    most = min(most, len(children))
    stack = np.empty((most + WIDTH, 3), np.int32)
    pending = np.empty((2 * WIDTH, 2), np.int64)
    for u in range(begin, end):
        found[u, 0], found[u, 1], found[u, 2] = 0, 0, base
        if not 0 <= roots[u] < len(branches.left):
            continue
        room = min(most, limit - base)
        stack[0, 0], stack[0, 1], stack[0, 2] = 0, roots[u], 1
        top, used, levels = 1, min(1, room), 0
        while top > 0 and used > 0:
            top -= 1
            node, branch, level = base + stack[top, 0], stack[top, 1], stack[top, 2]
            levels = max(levels, level)
            for k in range(WIDTH):
                children[node, k] = 0
            pending[0, 0], pending[0, 1] = branch, 1
            waiting, slot = 1, 0
            if branches.choice[ROW * branch + LEAF] == 0:
                waiting = _open(branches, branch, NODE, WIDTH, pending, 0)
            while waiting > 0:
                waiting -= 1
                branch, slots = pending[waiting, 0], pending[waiting, 1]
                at = ROW * branch
                # 0 at a number of slots says that fewer cost no more
                while slots > 1 and branches.choice[at + slots] == 0:
                    slots -= 1
                size = branches.choice[at + LEAF]
                is_open = slots > 1 and branches.left[branch] >= 0
                is_lower = upper > 0 and (branch < upper or branches.left[branch] < upper)
                # Impossible in a tree; the kernel is also called with arrays from outside
                if waiting + 2 > len(pending) or slot == WIDTH:
                    waiting, used = 0, 0
                elif is_open:
                    waiting = _open(branches, branch, slots, slots, pending, waiting)
                elif size > 0:
                    children[node, slot] = _leaf_code(branches.first[branch], size)
                elif is_lower and count < len(lower):
                    lower[count, 0], lower[count, 1], lower[count, 2] = branch, WIDTH * node + slot, level + 1
                    count += 1
                elif is_lower or used == room:
                    waiting, used = 0, 0
                else:
                    children[node, slot] = used
                    stack[top, 0], stack[top, 1], stack[top, 2] = used, branch, level + 1
                    used += 1
                    top += 1
                slot += 0 if is_open else 1
        found[u, 0], found[u, 1] = used, levels
        base += used
    return count


@kernel(begin="0..end", end="0..u", found="u 3", places="u", source="n 8", children="out m 8")
def gather_nodes(begin: int, end: int, found: Longs, places: Longs, source: Ints, children: Ints) -> None:
    """Copy the nodes of roots begin..end to children[places[u]:]: there their numbers begin at places[u]."""
    for u in range(begin, end):
        count, first, place = found[u, 0], found[u, 2], places[u]
        if not (0 <= first <= len(source) - count and 0 <= place <= len(children) - count):
            continue
        for i in range(count):
            for k in range(WIDTH):
                code = source[first + i, k]
                children[place + i, k] = code + place if code > 0 else code


@inline
def _open(branches: Branches, branch: int, place: int, slots: int, pending: Any, waiting: int) -> int:
    """Push a branch's halves with their slots. The clipped numbers are within these limits in any tree."""
    left = min(max(0, branches.left[branch]), len(branches.left) - 2)
    taken = min(max(1, branches.choice[ROW * branch + place]), slots - 1)
    pending[waiting, 0], pending[waiting, 1] = left + 1, slots - taken
    pending[waiting + 1, 0], pending[waiting + 1, 1] = left, taken
    return waiting + 2


@kernel(
    records="8*r", children="n 8", limits="6", parts="p", begin="0..end", end="0..p-1", boxes="out b", at="0..b-48*n"
)
def box_nodes(
    records: Floats, children: Ints, limits: Floats, parts: Longs, begin: int, end: int, boxes: Floats, at: int
) -> None:
    """Write the boxes of nodes, six sides of eight each, to boxes[at:].

    Part u has the nodes parts[u] to parts[u + 1]. Nodes below a node have larger numbers, and those in later parts have
    their boxes already. A child that does not exist gets an empty box.
    """
    box = np.empty(SIZE)
    for part in range(begin, end):
        first = max(0, parts[part])
        for node in range(min(parts[part + 1], len(children)) - 1, first - 1, -1):
            for k in range(WIDTH):
                code, place = children[node, k], at + 6 * WIDTH * node + k
                clear_box(box, 0)
                if node < code < len(children):
                    _join_children(boxes, at + 6 * WIDTH * code, box)
                elif code < 0:
                    begins, ends = leaf_range(code)
                    for i in range(begins, min(ends, len(records) // SIZE)):
                        join_box(box, 0, records, SIZE * i)
                    for axis in range(3):
                        box[axis] = -restore_limit(limits, axis, -box[axis])
                        box[axis + 4] = restore_limit(limits, axis + 3, box[axis + 4])
                for axis in range(3):
                    boxes[place + WIDTH * axis], boxes[place + WIDTH * (axis + 3)] = -box[axis], box[axis + 4]


@inline
def _join_children(boxes: Floats, at: int, box: Floats) -> None:
    """Write the box around the children of the node whose boxes are boxes[at:]."""
    for axis in range(3):
        low, high = math.inf, -math.inf
        for k in range(WIDTH):
            a, b = boxes[at + WIDTH * axis + k], boxes[at + WIDTH * (axis + 3) + k]
            low, high = a if a < low else low, b if b > high else high
        box[axis], box[axis + 4] = -low, high


@kernel(records="8*n", begin="0..end", end="0..n", items="out i", at="0..i-end")
def items_of(records: Floats, begin: int, end: int, items: Ints, at: int) -> None:
    """Write the items of records, in order, to items[at + begin:]."""
    for i in range(begin, end):
        items[at + i] = np.int32(records[SIZE * i + ITEM])


# A tree over boxes: branches on all threads, then nodes of eight from them

_PARTS = 16  # parts of a tree that a thread takes at a time
_ITEMS = 1 << 16


@dataclass(frozen=True)
class BoxTree:
    """Nodes of eight over records; nodes and the entries of leaves are numbered from 0."""

    records: Floats  # (8 n,) in the order of the leaves
    children: Ints  # (nodes, 8)
    parts: Longs  # (parts + 1,) part k has the nodes parts[k] to parts[k + 1]; the upper nodes are part 0
    limits: Floats  # (6,) stand-ins for infinity in the records
    levels: int

    def put_boxes(self, floats: Floats, at: int) -> None:
        """Write the boxes of the nodes, (nodes, 6, 8) flat, to floats[at:]."""
        put_node_boxes(self.records, self, floats, at)

    def items(self) -> Ints:
        """Return the items in the order of the leaves."""
        items = mapped_zeros(len(self.records) // SIZE, np.int32)
        run_chunks(KernelRange(items_of, (self.records,), (items, 0)), len(items), _ITEMS)
        return items


def build_tree(records: Floats, limits: Floats, most: int) -> BoxTree:
    """Build a tree over at least one record.

    Parameters
    ----------
    records : Floats
        (8 n,) boxes from `box_records`; they are sorted in place.
    limits : Floats
        (6,) stand-ins for infinity in the records.
    most : int
        Most entries of a leaf.

    Returns
    -------
    BoxTree
        Nodes of eight, their boxes on demand.
    """
    count = len(records) // SIZE
    groups, source = partition_large(records)
    # Branches of groups have the numbers from 2 n on: first the root's, then two for each group that was split.
    branches, costs = new_branches(2 * count + len(groups)), np.zeros(ROW * len(groups))
    areas = np.array([group.area for group in groups])
    number = 1
    for k, group in enumerate(groups):
        branches.first[2 * count + k], branches.last[2 * count + k] = group.first, group.last
        if group.halves:
            branches.left[2 * count + k] = 2 * count + number
            number += 2
    # The area of a lone root is not known, and an infinite one never makes it a leaf
    areas[0] = math.inf
    run_calls(grow, [
        (records, source, group.cells, branches, 2 * count + k, areas[k], most, costs, ROW * k)
        for k, group in enumerate(groups) if not group.halves
    ])  # fmt: skip
    # The root is a node in any case, so that its area decides nothing
    areas[0] = 0.0
    weigh_first(branches, 2 * count, areas, costs)
    upper, lower = np.empty((len(groups), WIDTH), np.int32), np.array([[2 * count, 0, 1]])
    found, none = np.zeros((1, 3), np.int64), np.zeros((0, 3), np.int64)
    if groups[0].halves:
        lower, ends = np.empty((WIDTH * len(groups), 3), np.int64), np.array([0, len(groups)])
        number = take_nodes(branches, 2 * count, np.array([2 * count]), 0, 1, ends, upper, found, lower)
        lower = lower[:number]
    roots, holders, levels = (lower[:, k].copy() for k in range(3))
    starts = np.zeros(len(roots) + 1, np.int64)
    np.cumsum(branches.last[roots] - branches.first[roots], out=starts[1:])
    rows, below = mapped_zeros((count, WIDTH), np.int32, sparse=True), np.zeros((len(roots), 3), np.int64)
    run_chunks(KernelRange(take_nodes, (branches, 0, roots), (starts, rows, below, none)), len(roots), _PARTS)
    # Upper nodes first, then those below them, root by root
    parts = np.cumsum(np.concatenate([[0], found[:, 0], below[:, 0]]))
    children = np.empty((int(parts[-1]), WIDTH), np.int32)
    children[: parts[1]] = upper[: parts[1]]
    if groups[0].halves:
        children.ravel()[holders] = parts[1:-1]
    run_chunks(KernelRange(gather_nodes, (), (below, parts[1:-1], rows, children)), len(roots), _PARTS)
    return BoxTree(records, children, parts, limits, int((levels + below[:, 1]).max()) - 1)


def put_node_boxes(records: Floats, tree: BoxTree, floats: Floats, at: int) -> None:
    """Write the boxes of the nodes of a tree, over these records in the order of its own, to floats[at:]."""
    work = KernelRange(box_nodes, (records, tree.children, tree.limits, tree.parts), (floats, at), first=1)
    run_chunks(work, len(tree.parts) - 2, _PARTS)
    box_nodes(records, tree.children, tree.limits, tree.parts, 0, 1, floats, at)


# Trees over blocks of instances: the tree over the first block of a form serves all
#
# Only the order of items and the children of nodes are copied. Boxes of nodes are those of what is in them, so the tree
# is right however the items of a block lie. A tree over the blocks is above.


@dataclass(frozen=True)
class BlockTree:
    """The tree of `build_block_tree`, with the methods of a `BoxTree`."""

    boxes: Floats
    kinds: Signs
    upper: BoxTree
    blocks: list[tuple[int, int, BoxTree]]  # first item in the order, first node, and tree of each block
    order: Ints
    children: Ints
    levels: int

    def put_boxes(self, floats: Floats, at: int) -> None:
        """`BoxTree.put_boxes`"""
        self.upper.put_boxes(floats, at)
        limits = self.upper.limits

        def put(begin: int, end: int) -> None:
            for start, node, tree in self.blocks[begin:end]:
                records = np.empty_like(tree.records)
                rows = self.order[start : start + len(records) // SIZE]
                _load(self.boxes, rows, 0, len(rows), 0, self.kinds, COSTS, limits, records)
                put_node_boxes(records, tree, floats, at + 6 * WIDTH * node)

        run_chunks(put, len(self.blocks), 16)

    def items(self) -> Ints:
        """`BoxTree.items`"""
        return self.order


@kernel(boxes="b 6", first="n", size="n", around="out n 6")
def put_unions(boxes: Floats, first: Longs, size: Longs, around: Floats) -> None:
    """Write the box around each run of boxes."""
    for k in range(len(first)):
        for axis in range(3):
            around[k, axis], around[k, axis + 3] = math.inf, -math.inf
        for i in range(max(0, first[k]), min(first[k] + size[k], len(boxes))):
            for axis in range(3):
                low, high = boxes[i, axis], boxes[i, axis + 3]
                around[k, axis] = low if low < around[k, axis] else around[k, axis]
                around[k, axis + 3] = high if high > around[k, axis + 3] else around[k, axis + 3]


def build_block_tree(
    boxes: Floats, kinds: Signs, limits: Floats, most: int, blocks: Sequence[InstanceBlock], alone: Longs
) -> BlockTree:
    """Build a tree over items with boxes (n, 6), as `build_tree` does, without sorting those of each block.

    There is a block. `alone` are the numbers of items in no block.
    """
    lower: dict[int, BoxTree] = {}
    for first, size, form in blocks:
        if form not in lower:
            own = slice(first, first + size)
            lower[form] = build_tree(box_records(boxes[own], _EVERY, 0, kinds[own], limits), limits, most)
    trees, number = list(lower.values()), {form: k for k, form in enumerate(lower)}
    # The last form is that of items in no block
    counts = np.array([*(len(tree.children) for tree in trees), 0])
    single = np.ones(len(alone), np.int64)
    firsts, lengths = (np.array([block[k] for block in blocks], np.int64) for k in range(2))
    begins, sizes = np.append(firsts, alone), np.append(lengths, single)
    forms = np.append(np.array([number[block.form] for block in blocks]), len(trees) * single)
    around = np.empty((len(blocks), 6))
    put_unions(boxes, firsts, lengths, around)
    around = np.concatenate([around, boxes[alone]])
    upper = build_tree(box_records(around, _EVERY, 0, np.zeros(0, np.int8), limits), limits, 1)
    which = upper.items()
    begins, sizes, forms = begins[which], sizes[which], forms[which]
    starts, firsts = np.cumsum(sizes) - sizes, np.cumsum(counts[forms]) - counts[forms] + len(upper.children)
    children = np.empty((len(upper.children) + int(counts[forms].sum()), WIDTH), np.int32)
    # A leaf of the upper tree is one block or one item; for a block stands its first node
    place = np.maximum(-upper.children - 1, 0) >> 4
    leaf = np.where(counts[forms][place] > 0, firsts[place], -((starts[place] << 4) | 1) - 1)
    children[: len(upper.children)] = np.where(upper.children < 0, leaf, upper.children)
    order = np.repeat(begins - starts, sizes).astype(np.int32) + np.arange(sizes.sum(), dtype=np.int32)
    placed: list[tuple[int, int, BoxTree]] = []
    for form, tree in enumerate(trees):
        places = np.flatnonzero(forms == form)
        start, node = starts[places][:, None], firsts[places][:, None]
        codes, items = tree.children.ravel(), tree.items()
        moved = np.where(codes < 0, codes - (start << 4), np.where(codes > 0, codes + node, 0))
        children[node + np.arange(len(tree.children))] = moved.reshape(len(places), -1, WIDTH)
        order[start + np.arange(len(items))] = begins[places][:, None] + items
        placed += [(int(a), int(b), tree) for a, b in zip(starts[places], firsts[places], strict=True)]
    levels = upper.levels + max(tree.levels for tree in trees)
    return BlockTree(boxes, kinds, upper, placed, order, children, levels)


_EVERY = np.zeros(0, np.int32)
