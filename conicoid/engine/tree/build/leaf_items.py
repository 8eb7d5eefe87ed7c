"""The table of the items in the leaves of the scene's tree; see `engine/tree/leaf.py`."""

from __future__ import annotations

import math
from collections.abc import Sequence

from ....compiler.jit import inline, kernel
from ... import tables as table
from ...culling.slack import BALL_BOX, BESIDE, WALL
from ...surface.quadric import Sphere
from ...surface.records import load_sphere
from ...tables import BALL, CELL, Floats, Geometry, integer, length
from ...threads import run_chunks
from ..leaf import INDEX, ROUND, ROWS, WHO, leaf_at, leaf_range
from .round_cells import around_cell

_CHUNK = 1 << 14


def put_items(geometry: Geometry, boxes: Floats, place: int, parts: Sequence[tuple[int, int]] = ()) -> None:
    """Fill the table LEAF_ITEMS, for the scene's own tree, which begins at a place; boxes (n, 6) of the entries.

    parts: the first and last of some children of nodes whose leaves alone are written, beside those of roots.
    """
    geometry.places[table.ITEMS] = geometry.places[table.LEAF_ITEMS] - ROWS * place
    for begin, end in parts:
        _put_leaves(geometry, boxes, place, False, begin, end)
    if not parts:
        run_chunks(lambda a, b: _put_leaves(geometry, boxes, place, False, a, b), _children(geometry), _CHUNK)
    roots = int(length(geometry, table.ROOTS))
    run_chunks(lambda a, b: _put_leaves(geometry, boxes, place, True, a, b), roots, _CHUNK)


def _children(geometry: Geometry) -> int:
    """How many children the nodes of all trees have, empty ones included."""
    return int(length(geometry, table.NODE_CHILDREN))


@kernel(geometry="out", boxes="* 6", begin="0..end")
def _put_leaves(geometry: Geometry, boxes: Floats, place: int, of_roots: bool, begin: int, end: int) -> None:
    """The leaves among begin..end of the roots, or of the children; those of bodies' trees have no items."""
    codes = table.ROOTS if of_roots else table.NODE_CHILDREN
    for k in range(begin, min(end, length(geometry, codes))):
        code = integer(geometry, codes, k)
        if code >= 0:
            continue
        first, last = leaf_range(code)
        if first < place:
            continue
        at, count, rounds = leaf_at(geometry, first), last - first, 0
        for j in range(count):
            rounds += _put_item(geometry, boxes, at + j, count, integer(geometry, table.TREE_ORDER, first + j))
        if rounds == count:
            geometry.floats[at + WHO * count] += ROUND


@inline
def _put_item(geometry: Geometry, boxes: Floats, at: int, count: int, entry: int) -> int:
    """Write an item. Returns 1 if its ball has a smaller projection than its box, in the mean over all directions."""
    f, kind = geometry.floats, integer(geometry, table.ENTRY_KIND, entry)
    ball = _around(geometry, boxes, kind, entry)
    f[at], f[at + count], f[at + 2 * count], f[at + 3 * count] = ball
    f[at + WHO * count] = 8 * entry + kind
    f[at + INDEX * count] = integer(geometry, table.ENTRY_INDEX, entry)
    if kind == BALL:  # whose box need not be read
        return 1
    a, b, c = _width(boxes, entry, 0), _width(boxes, entry, 1), _width(boxes, entry, 2)
    return 1 if math.pi * ball.radius * ball.radius <= 0.5 * (a * b + b * c + c * a) else 0


@inline
def _around(geometry: Geometry, boxes: Floats, kind: int, entry: int) -> Sphere:
    """A ball that holds an entry: itself, if it is one, or that around its box; of infinite radius, if need be."""
    if kind == BALL:
        surface = integer(geometry, table.ENTRY_INDEX, entry)
        return load_sphere(geometry, integer(geometry, table.SURFACE_ROW, surface))
    x, y, z = _middle(boxes, entry, 0), _middle(boxes, entry, 1), _middle(boxes, entry, 2)
    a, b, c = _half(boxes, entry, 0, x), _half(boxes, entry, 1, y), _half(boxes, entry, 2, z)
    reach = math.sqrt(a * a + b * b + c * c) * (1.0 + BALL_BOX) + WALL
    reach += BESIDE * (abs(x) + abs(y) + abs(z) + reach)
    if kind == CELL:
        ball = around_cell(geometry, integer(geometry, table.ENTRY_INDEX, entry), x, y, z, reach)
        if ball.radius < reach:
            return ball
    return Sphere(x, y, z, reach)


@inline
def _width(boxes: Floats, entry: int, k: int) -> float:
    """How wide the box of an entry is along axis k."""
    return boxes[entry, k + 3] - boxes[entry, k]


@inline
def _middle(boxes: Floats, entry: int, k: int) -> float:
    """The middle of the box of an entry along axis k, or 0 where that is not finite."""
    middle = 0.5 * boxes[entry, k] + 0.5 * boxes[entry, k + 3]
    return middle if math.isfinite(middle) else 0.0


@inline
def _half(boxes: Floats, entry: int, k: int, middle: float) -> float:
    """How far the box of an entry reaches from `middle` along axis k."""
    return max(boxes[entry, k + 3] - middle, middle - boxes[entry, k])
