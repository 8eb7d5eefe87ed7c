"""Walks of the threads of a GPU through short nodes, and first hits by them.

A thread of a GPU waits for memory more than it computes, and for the other threads of its group. So the walk reads 128
bytes a node in place of 416, and writes eight bytes for each node that waits.

t of a walk are in units of `RayGrid.unit`, so that float32 holds all of them, whatever the size of a scene.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from .._jit.decorators import choose, fma, inline
from . import tables as table
from .body.hit import Hit, cull_limit, no_hit, scale_hit, try_ball, try_cell, try_entry
from .body.scratch import Scratch
from .bvh.culling import (
    SHORT_CHILDREN,
    SHORT_SLACK,
    float_bits,
    float_of_bits,
    lowest_bit,
    put_waiting,
    take_waiting,
    visit_node,
)
from .bvh.culling_constants import BALL_LEAST, BALL_SLACK
from .bvh.walk import leaf_at, leaf_ball, leaf_item, leaf_range, scene_tree
from .ray import DEAD, Ray, scale_ray, span_inverse, start_margin
from .surface.interval import is_open
from .surface.quadric import SphereRecord
from .tables import BALL, CELL, Floats, Geometry, Longs, integer, node_at, real, whole

# Short nodes

_GRID, _STEPS, _SIDES = 0, 3, 4
"""Numbers of a node, before its children: x, y, z where its grid begins; the exponents of the grid's steps, 16 bits
each; low x, y, z and high x, y, z of its boxes, eight bits each."""
_MARGIN = 2.0**-6
"""Share of a step by which a short box is wider than its box on each side, at least: a ray along a wall is inside."""
_LEAST_STEP, _LEAST_SHARE = 2.0**-40, 2.0**-60
"""Least step of a grid as a share of the node's coordinates and of the scene's, so that its margin is no rounding."""
_ALONG = 2.0**124
"""1 / d of a walk for d = 0, where the largest component of d is 1: near the largest float32. A margin times this lies
beyond all t of boxes along other axes, unless the ray begins beyond `_FAR`, or is `_STEEP` along one of these: boxes
may be infinite there, and their t has no limit. Other quotients that exceed float32 become infinite or NaN, and the
walk enters the box."""
_STEEP = 2.0**-56
"""Least component of a direction, unless it is 0, with which boxes along an axis of 0 are tested."""
_LARGEST = 2.0**20
"""Limit of the ends of a walk. It lies beyond all finite boxes, and the walk enters infinite ones up to there."""
_FAR = 2.0**30
"""Share of the scene's coordinates."""


@inline
def _reach(geometry: Geometry) -> float:
    """Return a bound of the coordinates of all boxes."""
    x, y, z = real(geometry, table.EXTENT, 2), real(geometry, table.EXTENT, 3), real(geometry, table.EXTENT, 4)
    return real(geometry, table.EXTENT, 0) + max(abs(x), max(abs(y), abs(z)))


@inline
def _child(geometry: Geometry, node: int, k: int) -> int:
    """Return the code of a child in a walk: nodes count from 1, 0 is none, leaves are negative."""
    code = integer(geometry, table.NODE_CHILDREN, 8 * node + k)
    return code + 1 if code > 0 else code


def shorten_nodes(geometry: Geometry, nodes: Longs, begin: int, step: int) -> None:
    """Write the short nodes begin, begin + step, ..."""
    node = begin
    while node < len(nodes):
        at, exponents, floats = node_at(geometry, node), whole(0), geometry.floats
        for axis in range(3):
            low, high = math.inf, -math.inf
            for k in range(8):
                if _child(geometry, node, k) != 0:
                    low, high = min(low, floats[at + 8 * axis + k]), max(high, floats[at + 24 + 8 * axis + k])
            # A walk enters all boxes of a node that is too wide: NaN, where its grid begins, fails each comparison
            fits = high - low < 1e150
            least = max(_LEAST_SHARE * _reach(geometry), max(_LEAST_STEP * max(abs(low), abs(high)), 1e-250))
            exponent = (float_bits(max(least, (high - low) / 254.0)) >> 52) + 1 if fits else whole(1023)
            size = float_of_bits(exponent << 52)
            exponents |= exponent << (16 * axis)
            nodes[node, _GRID + axis] = float_bits(low - _MARGIN * size if fits else math.nan)
            lows, highs = whole(0), whole(0)
            for k in range(8):
                first, last = whole(255), whole(0)
                if fits and _child(geometry, node, k) != 0:
                    first = whole((floats[at + 8 * axis + k] - low) / size)
                    last = min(whole(255), whole((floats[at + 24 + 8 * axis + k] - low) / size + 0.04) + 1)
                lows |= first << (8 * k)
                highs |= last << (8 * k)
            nodes[node, _SIDES + axis], nodes[node, _SIDES + 3 + axis] = lows, highs
        nodes[node, _STEPS] = exponents
        for k in range(4):
            first, last = _child(geometry, node, 2 * k), _child(geometry, node, 2 * k + 1)
            nodes[node, SHORT_CHILDREN + k] = (first & 0xFFFFFFFF) | (last << 32)
        node += step


# The walk


class RayGrid(NamedTuple):
    """A ray for the walk: 1 / d, and its interval as float32, in units of a length that is near the scene's."""

    ix: float
    iy: float
    iz: float
    unit: float  # t of the walk, by t of the ray
    margin: float  # by which balls are larger for the ray: `start_margin`
    first: Any  # float32


@inline
def _inverse(d: float, largest: float, reach: float, limit: float) -> float:
    """Return 1 / d in units of the walk. For d = 0 beyond `limit` it is NaN, so that the walk enters each box."""
    if d != 0.0:
        return largest / (d * reach)
    return _ALONG / reach if reach < limit else math.nan


@inline
def _is_steep(d: float, largest: float) -> bool:
    """True if boxes can have such t along this axis that those along an axis of 0 cannot be tested."""
    return d != 0.0 and abs(d) < _STEEP * largest


@inline
def ray_grid(geometry: Geometry, ray: Ray) -> RayGrid:
    """Return a ray for the walk."""
    scene = max(_reach(geometry), 1e-200)
    reach = scene + max(abs(ray.ox), max(abs(ray.oy), abs(ray.oz)))
    largest = max(abs(ray.dx), max(abs(ray.dy), abs(ray.dz)))
    steep = _is_steep(ray.dx, largest) or _is_steep(ray.dy, largest) or _is_steep(ray.dz, largest)
    limit = 0.0 if steep else _FAR * scene
    x, y = _inverse(ray.dx, largest, reach, limit), _inverse(ray.dy, largest, reach, limit)
    z = _inverse(ray.dz, largest, reach, limit)
    unit = largest / reach
    low = min(ray.t_min * unit, _LARGEST)
    first = np.float32(low * choose(low < 0.0, 1.0 + SHORT_SLACK, 1.0 - SHORT_SLACK))
    return RayGrid(x, y, z, unit, start_margin(float(ray.start), ray.ox, ray.oy, ray.oz), first)


@inline
def walk_end(t: float, unit: float) -> Any:
    """Return t as the end of a walk, rounded up."""
    high = max(t * unit, -_LARGEST)
    return np.float32(high * choose(high < 0.0, 1.0 - SHORT_SLACK, 1.0 + SHORT_SLACK))


@inline
def push_short_roots(geometry: Geometry, way: Floats) -> int:
    """Start a walk with the roots of the scene's tree; return the height of the stack."""
    tree = scene_tree(geometry)
    first, last = integer(geometry, table.TREE_ROOT, tree), integer(geometry, table.TREE_ROOT, tree + 1)
    for k in range(first, last):
        code = integer(geometry, table.ROOTS, k)
        put_waiting(way, k - first, code + 1 if code >= 0 else code)
    return last - first


@inline
def take_next(way: Floats, top: int, last: Any) -> tuple[int, int]:
    """Return (code of the next node or leaf on the stack, 0 for none; height of the stack)."""
    code = whole(0)
    while code == 0 and top > 0:
        top -= 1
        code = take_waiting(way, top, last)
    return code, top


@inline
def ray_of_place(k: int, width: int, count: int) -> int:
    """Return the number of the k-th ray of a list, or -1 for none: a picture `width` wide in squares of 8 x 4 pixels.

    The 32 threads of a group trace one square, so they read the same nodes.
    """
    if width == 0:
        return k
    square, across = k >> 5, (width + 7) >> 3
    row, column = 4 * (square // across) + (k >> 3 & 3), 8 * (square % across) + (k & 7)
    i = row * width + column
    return i if column < width and i < count else whole(-1)


@inline
def place_count(width: int, count: int) -> int:
    """Return the number of places that `ray_of_place` goes through."""
    return count if width == 0 else ((width + 7) >> 3) * ((count + 4 * width - 1) // (4 * width)) << 5


@inline
def may_meet_ball(ball: SphereRecord, ray: Ray, grid: RayGrid, inverse: float, last: float) -> bool:
    """Return False if a ray certainly misses a ball between its t_min and `last`, as `hit_balls` decides."""
    x, y, z, r = ball.x - ray.ox, ball.y - ray.oy, ball.z - ray.oz, ball.radius + grid.margin
    foot = fma(x, ray.dx, fma(y, ray.dy, z * ray.dz)) * inverse
    off_x, off_y, off_z = fma(-foot, ray.dx, x), fma(-foot, ray.dy, y), fma(-foot, ray.dz, z)
    far, squared = fma(x, x, fma(y, y, z * z)), r * r
    off = fma(off_x, off_x, fma(off_y, off_y, off_z * off_z))
    inside = squared - off + fma(far + squared, BALL_SLACK, BALL_LEAST)
    if inside < 0.0:
        return False
    half = math.sqrt(inside * inverse)
    return not (foot - half > last or foot + half < ray.t_min)  # NaN counts as a hit


@inline
def next_items(
    geometry: Geometry, nodes: Longs, way: Floats, ray: Ray, grid: RayGrid, inverse: float, last: Any, end: float,
    code: int, top: int,
) -> tuple[int, int, int]:  # fmt: skip
    """Walk on, from `code`, to the next leaf with items whose balls a ray may meet before `end`.

    Return (its code, its items as bits, height of the stack); code 0 if no leaf is left. All threads of a group look
    for items before any of them intersects one, which takes longer: so more of them do it at the same time.
    """
    bits = whole(0)
    while code != 0 and bits == 0:
        if code > 0:
            code, top = visit_node(
                nodes, code - 1, ray.ox, ray.oy, ray.oz, grid.ix, grid.iy, grid.iz, grid.first, last, way, top
            )
            if code == 0:
                code, top = take_next(way, top, last)
        if code < 0:
            first, after = leaf_range(code)
            at, size = leaf_at(geometry, first), after - first
            for k in range(size):
                if may_meet_ball(leaf_ball(geometry, at, size, k), ray, grid, inverse, end):
                    bits |= 1 << k
            if bits == 0:
                code, top = take_next(way, top, last)
    return code, bits, top


@inline
def _try_item(
    geometry: Geometry, scratch: Scratch, kinds: int, at: int, count: int, k: int, ray: Ray, inverse: float, best: Hit
) -> Hit:
    """Return the better of `best` and the first crossing of item k of a leaf, whose kind is at most `kinds`."""
    item = leaf_item(geometry, at, count, k)
    if kinds == BALL or item.kind == BALL:
        return try_ball(geometry, item, leaf_ball(geometry, at, count, k), ray, inverse, best)
    if kinds == CELL or item.kind == CELL:
        return try_cell(geometry, item, ray, inverse, best)
    return try_entry(geometry, scratch, item.entry, ray, best)


@inline
def first_on_card(geometry: Geometry, nodes: Longs, kinds: int, scratch: Scratch, ray: Ray, any_hit: bool) -> Hit:
    """`first_crossing` of all bodies, for a thread of a GPU; `kinds` is the largest kind of an entry."""
    best = no_hit()
    if ray.start == DEAD or not is_open(ray.t_min, ray.t_max):
        return best
    ray, scale = scale_ray(ray)
    way, inverse, grid = scratch.way, span_inverse(ray), ray_grid(geometry, ray)
    end = ray.t_max
    last = walk_end(end, grid.unit)
    code, top = take_next(way, push_short_roots(geometry, way), last)
    while True:
        code, bits, top = next_items(geometry, nodes, way, ray, grid, inverse, last, end, code, top)
        if code == 0:
            break
        first, after = leaf_range(code)
        at, size = leaf_at(geometry, first), after - first
        while bits != 0:
            best = _try_item(geometry, scratch, kinds, at, size, lowest_bit(bits), ray, inverse, best)
            bits &= bits - 1
            if any_hit and best.body >= 0:  # also in doubt: exact methods trace such a ray again
                return scale_hit(best, scale)
        end = min(ray.t_max, cull_limit(best))
        last = walk_end(end, grid.unit)  # boxes beyond the hit are culled from now on
        code, top = take_next(way, top, last)
    return scale_hit(best, scale)
