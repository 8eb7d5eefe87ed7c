"""Leaf items of the scene's tree: a ball around each entry, its kind and its row; see `kernels/bvh/walk.py`.

Cells get a ball that is tighter than the one around their box, where there is one. A cell that lies inside of  sum s_i
y_i² + 2 b_i y_i - k = 0,  y = W (x - anchor),  and between planes across its axis j has |x - c|² at most as large as
the largest (y_j - m)² / |W_j|² + (k' - s_j y_j² - 2 b_j y_j) / steep, between the planes: c is on the axis, halfway; k'
= k + b_i² / s_i of the other two axes, and steep the lesser of their s_i |W_i|². That is a parabola in y_j, largest at
an end or at its vertex.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from ..._jit.decorators import helper, inline, kernel
from ...kernels import tables as table
from ...kernels.bvh.culling import prefetch_soon
from ...kernels.bvh.culling_constants import (
    BALL_BOX,
    ORIGIN_SLACK,
    PARALLEL,
    ROUND_AWAY,
    ROUND_RAISED,
    ROUND_ROUNDED,
    WALL,
)
from ...kernels.bvh.walk import INDEX, ROUND, ROWS, WHO, leaf_at, leaf_range
from ...kernels.faces import cell_side, plane_side
from ...kernels.numbers.vectors import dot
from ...kernels.surface.quadric import QuadricRecord, SphereRecord
from ...kernels.surface.records import load_plane, load_quadric, load_sphere
from ...kernels.tables import BALL, CELL, SPHERE, SPHERE_SIZE, Floats, Geometry, integer, length
from ...kernels.threads import KernelRange, run_chunks

_LEAST, _MOST = 1e-250, 1e250  # beyond these, products may overflow


@inline
def _no_ball() -> SphereRecord:
    """Return no ball: one of infinite radius."""
    return SphereRecord(0.0, 0.0, 0.0, math.inf)


@inline
def _dot_of_rows(quadric: QuadricRecord, i: int, j: int) -> float:
    """Return W_i · W_j."""
    i, j = 3 + 3 * i, 3 + 3 * j
    return dot(quadric[i], quadric[i + 1], quadric[i + 2], quadric[j], quadric[j + 1], quadric[j + 2])


@inline
def _between(geometry: Geometry, cell: int, quadric: QuadricRecord, j: int, reach: float) -> tuple[float, float]:
    """Return the bounds of y_j by the planes across axis j; the cell's points are at most `reach` from the anchor."""
    low, high, square = -math.inf, math.inf, _dot_of_rows(quadric, j, j)
    for slot in range(integer(geometry, table.CELL_FIRST, cell), integer(geometry, table.CELL_FIRST, cell + 1)):
        row = integer(geometry, table.SURFACE_ROW, integer(geometry, table.PLANE_SURFACE, slot))
        nx, ny, nz, over, ax, ay, az = load_plane(geometry, row)
        across = True
        for i in range(3):
            along = dot(nx, ny, nz, quadric[3 + 3 * i], quadric[4 + 3 * i], quadric[5 + 3 * i])
            across &= i == j or abs(along) <= PARALLEL * math.sqrt(_dot_of_rows(quadric, i, i))
        if not across:
            continue
        along = dot(nx, ny, nz, quadric[3 + 3 * j], quadric[4 + 3 * j], quadric[5 + 3 * j])
        height = dot(nx, ny, nz, quadric.ax - ax, quadric.ay - ay, quadric.az - az) + over
        # `PARALLEL` admits planes that are slightly oblique: the slack covers their slope within `reach`.
        y, slack = -height * square / along, ROUND_AWAY * reach * math.sqrt(square)
        if (along > 0.0) == (plane_side(geometry, slot) > 0):
            high = min(high, y + slack)
        else:
            low = max(low, y - slack)
    return low, high


@inline
def _along_axis(geometry: Geometry, cell: int, quadric: QuadricRecord, j: int, reach: float) -> SphereRecord:
    """Return a ball about a point on axis j; of infinite radius if there is none."""
    a, b = (j + 1) % 3, (j + 2) % 3
    sa, sb, sj, bj, square = (
        quadric[12 + a],
        quadric[12 + b],
        quadric[12 + j],
        quadric[15 + j],
        _dot_of_rows(quadric, j, j),
    )
    # Else the section across the axis is no ellipse, and its cell may reach anywhere
    if not (sa > 0.0 and sb > 0.0):
        return _no_ball()
    # s y² is (s |W|²) times a squared length: the flatter of the two axes across bounds the radius
    steep = min(sa * _dot_of_rows(quadric, a, a), sb * _dot_of_rows(quadric, b, b))
    if not (_LEAST < steep < _MOST and _LEAST < square < _MOST):
        return _no_ball()
    ya, yb = -quadric[15 + a] / sa, -quadric[15 + b] / sb
    level, least = quadric.k + (ya * ya * sa + yb * yb * sb), abs(quadric.k) + (ya * ya * sa + yb * yb * sb)
    low, high = _between(geometry, cell, quadric, j, reach)
    if sj > 0.0:
        half = math.sqrt(max(0.0, level + bj * bj / sj + ROUND_ROUNDED * (least + bj * bj / sj)) / sj)
        low, high = max(low, -bj / sj - half), min(high, -bj / sj + half)
    elif sj == 0.0 and bj != 0.0:
        end = (level + ROUND_ROUNDED * least) / (2.0 * bj)  # the vertex of a paraboloid
        low, high = (low, min(high, end)) if bj > 0.0 else (max(low, end), high)
    if not (math.isfinite(low) and math.isfinite(high) and low <= high):
        return _no_ball()
    middle, largest = 0.5 * (low + high), 0.0
    # The squared distance from the axis point is quadratic in y: its largest value is at an end, or at the vertex if it
    # bends down
    bend = 1.0 / square - sj / steep
    vertex = (middle / square + bj / steep) / bend if bend < 0.0 else low
    # Clamped: a vertex outside the interval stands for the nearer end, which is tried anyway
    for y in (low, high, min(max(vertex, low), high)):
        across = level - sj * y * y - 2.0 * bj * y + ROUND_ROUNDED * (least + abs(sj) * y * y + 2.0 * abs(bj * y))
        if not abs(across) < _MOST:
            return _no_ball()
        largest = max(largest, (y - middle) * (y - middle) / square + max(across, 0.0) / steep)
    center = (0.0, 0.0, 0.0)
    for i in range(3):
        y = (middle if i == j else (ya if i == a else yb)) / _dot_of_rows(quadric, i, i)
        k = 3 + 3 * i
        center = (center[0] + y * quadric[k], center[1] + y * quadric[k + 1], center[2] + y * quadric[k + 2])
    x, y, z = center[0] + quadric.ax, center[1] + quadric.ay, center[2] + quadric.az
    # Raised by a share of the radius for rounding, and of the position for rays that start beside the surface
    raised = math.sqrt(largest) * (1.0 + ROUND_RAISED) + ORIGIN_SLACK * (abs(x) + abs(y) + abs(z) + reach)
    return SphereRecord(x, y, z, raised)


@helper
def cell_ball(geometry: Geometry, cell: int, x: float, y: float, z: float, reach: float) -> SphereRecord:
    """Return a ball around a cell whose points are at most `reach` from (x, y, z).

    Of infinite radius if none is known.
    """
    surface, best = integer(geometry, table.CELL_QUADRIC, cell), _no_ball()
    # Outside of a quadric, or without one, the quadric bounds nothing
    if surface < 0 or cell_side(geometry, cell) < 0 or not math.isfinite(reach):
        return best
    row = integer(geometry, table.SURFACE_ROW, surface)
    if integer(geometry, table.SURFACE_KIND, surface) == SPHERE:
        return load_sphere(geometry, row)
    quadric = load_quadric(geometry, row)
    for i in range(3):
        for j in range(i):
            # Two roots: the product of the squares overflows for solids below 1e-77, and all rows would pass
            one, other = math.sqrt(_dot_of_rows(quadric, i, i)), math.sqrt(_dot_of_rows(quadric, j, j))
            if abs(_dot_of_rows(quadric, i, j)) > PARALLEL * one * other:
                return best
    size = reach + abs(x - quadric.ax) + abs(y - quadric.ay) + abs(z - quadric.az)
    for j in range(3):
        # Any axis gives a valid ball, so the least one counts
        ball = _along_axis(geometry, cell, quadric, j, size)
        best = ball if ball.radius < best.radius else best
    return best


# The table of the items in the leaves of the scene's tree

_CHUNK = 1 << 14
_AHEAD = 64  # children whose entries are prefetched together: they lie anywhere in the tables


def put_items(geometry: Geometry, boxes: Floats, place: int, parts: Sequence[tuple[int, int]] = ()) -> None:
    """Fill the table LEAF_ITEMS for the scene's own tree.

    Parameters
    ----------
    geometry : Geometry
        The packed tables, written in place.
    boxes : Floats
        (n, 6) bounding boxes of the entries.
    place : int
        Where the scene's tree begins in `tree_order`.
    parts : Sequence[tuple[int, int]]
        Ranges of children of nodes: their leaves alone are written, and those among the roots. Empty: all leaves.
    """
    geometry.places[table.ITEMS] = geometry.places[table.LEAF_ITEMS] - ROWS * place
    for begin, end in parts:
        _put_leaves(geometry, boxes, place, False, begin, end)
    for of_roots, count in ((False, table.NODE_CHILDREN), (True, table.ROOTS)):
        if of_roots or not parts:
            run_chunks(
                KernelRange(_put_leaves, (geometry, boxes, place, of_roots), ()), int(length(geometry, count)), _CHUNK
            )


@kernel(geometry="out", boxes="* 6", begin="0..end")
def _put_leaves(geometry: Geometry, boxes: Floats, place: int, of_roots: bool, begin: int, end: int) -> None:
    """Write the leaves among begin..end of the roots, or of the children; leaves of bodies' trees have no items."""
    codes = table.ROOTS if of_roots else table.NODE_CHILDREN
    end = min(end, length(geometry, codes))
    for k in range(begin, end):
        if (k - begin) % _AHEAD == 0:
            _prefetch_leaves(geometry, boxes, place, codes, k, min(k + _AHEAD, end))
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
            # In the number of the first item: entries are integers below 2^53, so that the half is exact
            geometry.floats[at + WHO * count] += ROUND


@inline
def _prefetch_leaves(geometry: Geometry, boxes: Floats, place: int, codes: int, begin: int, end: int) -> None:
    """Prefetch what the entries of leaves begin..end are read from."""
    for child in range(begin, end):
        code = integer(geometry, codes, child)
        first, last = leaf_range(code) if code < 0 else (0, 0)
        for k in range(first, last if first >= place else first):
            entry = integer(geometry, table.TREE_ORDER, k)
            if integer(geometry, table.ENTRY_KIND, entry) == BALL:
                row = integer(geometry, table.SURFACE_ROW, integer(geometry, table.ENTRY_INDEX, entry))
                prefetch_soon(geometry.floats, geometry.places[table.SPHERES] + SPHERE_SIZE * row)
            else:
                prefetch_soon(boxes, 6 * entry)


@inline
def _put_item(geometry: Geometry, boxes: Floats, at: int, count: int, entry: int) -> int:
    """Write an item. Return 1 if its ball has a smaller projection than its box, in the mean over all directions."""
    f, kind = geometry.floats, integer(geometry, table.ENTRY_KIND, entry)
    ball = _entry_ball(geometry, boxes, kind, entry)
    f[at], f[at + count], f[at + 2 * count], f[at + 3 * count] = ball
    f[at + WHO * count] = 8 * entry + kind
    f[at + INDEX * count] = integer(geometry, table.ENTRY_INDEX, entry)
    if kind == BALL:  # the box of a ball is not read
        return 1
    a, b, c = _width(boxes, entry, 0), _width(boxes, entry, 1), _width(boxes, entry, 2)
    # The mean projection of a convex body is a quarter of its surface (Cauchy): pi r² and (ab + bc + ca) / 2.
    return 1 if math.pi * ball.radius * ball.radius <= 0.5 * (a * b + b * c + c * a) else 0


@inline
def _entry_ball(geometry: Geometry, boxes: Floats, kind: int, entry: int) -> SphereRecord:
    """Return a ball that holds an entry: itself, its cell's, or the one around its box; the radius may be infinite."""
    if kind == BALL:
        surface = integer(geometry, table.ENTRY_INDEX, entry)
        return load_sphere(geometry, integer(geometry, table.SURFACE_ROW, surface))
    x, y, z = _middle(boxes, entry, 0), _middle(boxes, entry, 1), _middle(boxes, entry, 2)
    a, b, c = _half(boxes, entry, 0, x), _half(boxes, entry, 1, y), _half(boxes, entry, 2, z)
    # Half the diagonal of the box
    reach = math.sqrt(a * a + b * b + c * c) * (1.0 + BALL_BOX) + WALL
    reach += ORIGIN_SLACK * (abs(x) + abs(y) + abs(z) + reach)
    if kind == CELL:
        ball = cell_ball(geometry, integer(geometry, table.ENTRY_INDEX, entry), x, y, z, reach)
        # The ball around the box is always there; the cell's may be wider for a thin slice
        if ball.radius < reach:
            return ball
    return SphereRecord(x, y, z, reach)


@inline
def _width(boxes: Floats, entry: int, k: int) -> float:
    """Return the width of the box of an entry along axis k."""
    return boxes[entry, k + 3] - boxes[entry, k]


@inline
def _middle(boxes: Floats, entry: int, k: int) -> float:
    """Return the middle of the box of an entry along axis k, or 0 where that is not finite."""
    middle = 0.5 * boxes[entry, k] + 0.5 * boxes[entry, k + 3]
    return middle if math.isfinite(middle) else 0.0


@inline
def _half(boxes: Floats, entry: int, k: int, middle: float) -> float:
    """Return how far the box of an entry reaches from `middle` along axis k."""
    return max(boxes[entry, k + 3] - middle, middle - boxes[entry, k])
