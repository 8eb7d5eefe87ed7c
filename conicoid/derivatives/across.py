"""Which hits lie on walls of other bodies as well: a kernel over the hits and the scene's tree.

Hits that follow one another are mostly near one another, on one body. What is near several of them is looked for in the
tree once, by their box; then each is tried on it, as a point. What is no ball and no single cell a point does not
decide: there the ray must cross it, too.
"""

from __future__ import annotations

import math

from ..compiler.jit import helper, inline, kernel
from ..engine import tables as table
from ..engine.body.entry import entry_crossings
from ..engine.body.scratch import Scratch, new_scratch
from ..engine.body.sides import around
from ..engine.numbers.vectors import Vector, dot
from ..engine.ray import RayArrays, load_ray, scaled_ray
from ..engine.surface.records import load_sphere
from ..engine.tables import BALL, CELL, POLYGON, REGION, Floats, Geometry, Ints, Signs, halted, integer, whole
from ..engine.tree.walk import put_box, scene_tree, walk_box
from .touching import NEAR, TIED, largest, near_surface, on_cells

OPEN = 2
"""Of a hit: rounding might change whether a ray crosses what its hit is on; a ray as it is traced tells (`ties`)."""
_RUN, _FEW = 32, 32
"""Hits that are looked at together, and what is near them at most; where more is, each is looked at alone."""


@inline
def _reach(rays: RayArrays, points: Floats, i: int) -> float:
    """What the point of a hit is the sum of."""
    o = largest(rays.origins[i, 0], rays.origins[i, 1], rays.origins[i, 2])
    return max(o, largest(points[i, 0], points[i, 1], points[i, 2]))


@inline
def _run_of(entry: Ints, i: int, end: int) -> int:
    """The end of the hits from i on that are on one entry."""
    last = i + 1
    while last < end and last - i < _RUN and entry[last] == entry[i]:
        last += 1
    return last


@inline
def _kept(geometry: Geometry, found: Ints, count: int, own: int, low: Vector, high: Vector) -> int:
    """Leave out of found[:count] the entry itself, and balls whose walls are farther from a box than its corners."""
    left, size = (
        min(count, 0),
        0.51 * math.sqrt((high[0] - low[0]) ** 2 + (high[1] - low[1]) ** 2 + (high[2] - low[2]) ** 2),
    )
    x, y, z = 0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), 0.5 * (low[2] + high[2])
    for k in range(count):
        one = found[k]
        near = one != own
        if near and integer(geometry, table.ENTRY_KIND, one) == BALL:
            row = integer(geometry, table.SURFACE_ROW, integer(geometry, table.ENTRY_INDEX, one))
            cx, cy, cz, radius = load_sphere(geometry, row)
            away = dot(x - cx, y - cy, z - cz, x - cx, y - cy, z - cz)
            least, loose = max(0.0, radius - size), 2.0**-40 * (away + radius * radius)
            near = least * least - loose <= away <= (radius + size) * (radius + size) + loose
        if near:
            found[left] = one
            left += 1
    return left


@helper
def _gather(
    geometry: Geometry, scratch: Scratch, rays: RayArrays, entry: Ints, points: Floats, first: int, last: int, most: int
) -> int:
    """Put other entries near hits first to last, of one entry, into scratch.found; how many, or -1 for too many."""
    lx, ly, lz = points[first, 0], points[first, 1], points[first, 2]
    hx, hy, hz, reach = lx, ly, lz, 0.0
    for i in range(first, last):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        lx, ly, lz, hx, hy, hz = min(lx, x), min(ly, y), min(lz, z), max(hx, x), max(hy, y), max(hz, z)
        reach = max(reach, _reach(rays, points, i))
    more = 8.0 * NEAR * reach
    low, high = (lx - more, ly - more, lz - more), (hx + more, hy + more, hz + more)
    put_box(scratch.way, low, high)
    count = walk_box(geometry, scratch.way, scene_tree(geometry), scratch.found, most)
    return _kept(geometry, scratch.found, count, whole(entry[first]), low, high)


@inline
def _is_on(geometry: Geometry, entry: int, x: float, y: float, z: float, reach: float) -> bool:
    """Is a point on a wall of an entry, or perhaps, where a ray must tell?"""
    kind, index = integer(geometry, table.ENTRY_KIND, entry), integer(geometry, table.ENTRY_INDEX, entry)
    if CELL <= kind <= REGION:
        return on_cells(geometry, entry, whole(-1), x, y, z, reach)
    if kind == BALL:
        surface = index
    elif kind == POLYGON:
        surface = integer(geometry, table.POLYGON_SURFACE, index)
    else:
        surface = integer(geometry, table.SHEET_SURFACE, index)
    value, slack = near_surface(geometry, surface, x, y, z, reach)
    return abs(value) <= slack


@helper
def _tie_with(
    geometry: Geometry, scratch: Scratch, rays: RayArrays, points: Floats, i: int, t: float, other: int
) -> int:  # fmt: skip
    """0, TIED or OPEN: is hit i on a wall of another entry?"""
    reach = _reach(rays, points, i)
    if not _is_on(geometry, other, points[i, 0], points[i, 1], points[i, 2], reach):
        return 0
    if integer(geometry, table.ENTRY_KIND, other) <= CELL:
        return TIED
    plain = load_ray(rays, i)
    width = max(NEAR * reach / largest(plain.dx, plain.dy, plain.dz), NEAR * abs(t))
    ray, scale = scaled_ray(plain)
    count, _, unsure = entry_crossings(geometry, scratch, other, around(ray, t / scale, width / scale), 1)
    if unsure:
        return OPEN
    return TIED if count > 0 else 0


@inline
def _tie(
    geometry: Geometry, scratch: Scratch, rays: RayArrays, points: Floats, i: int, t: float, count: int
) -> int:  # fmt: skip
    """The strongest of `_tie_with` the entries scratch.found[:count]."""
    found = 0
    for k in range(count):
        one = _tie_with(geometry, scratch, rays, points, i, t, whole(scratch.found[k]))
        if one == TIED:
            return TIED
        found = max(found, one)
    return found


@kernel(entry="n", t="n", points="n 3", begin="0..end", end="0..n", tied="out n")
def ties_across(
    geometry: Geometry, rays: RayArrays, entry: Ints, t: Floats, points: Floats, begin: int, end: int, tied: Signs
) -> None:
    """tied[i] = TIED where a hit is on a wall of another entry, OPEN where that is not certain; what is tied stays."""
    scratch = new_scratch(geometry)
    every, i = len(scratch.found), begin
    while i < end:
        last = _run_of(entry, i, end)
        if entry[i] >= 0 and not halted(geometry):
            count = _gather(geometry, scratch, rays, entry, points, i, last, min(_FEW, every))
            for k in range(i, last):
                near = _gather(geometry, scratch, rays, entry, points, k, k + 1, every) if count < 0 else count
                if tied[k] == 0:
                    tied[k] = _tie(geometry, scratch, rays, points, k, t[k], near)
        i = last
