"""Which walls of a body a point is on, as far as floats can tell: by the cells of the body.

Points nearer to one another than 2^-47 of their coordinates are not told apart, so a surface's f counts as zero at a
point where it is below what such a step, and rounding, change it by.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from ..._jit.decorators import helper, inline, kernel
from ..._util.arrays import FloatArray
from ...kernels import tables as table
from ...kernels.body.cell import place_face, quadric_place
from ...kernels.body.entry import entry_crossings
from ...kernels.body.media import ray_about
from ...kernels.body.scratch import Scratch, new_scratch
from ...kernels.bvh.walk import put_box, scene_tree, walk_box
from ...kernels.numbers.vectors import Vector, dot
from ...kernels.programs import (
    LeafBounds,
    cell_of_leaf,
    cells_of_leaves,
    leaf_bounds,
    leaf_high,
    leaf_low,
    leaves_of,
    leaves_of_programs,
)
from ...kernels.ray import RayArrays, load_ray, scale_ray
from ...kernels.surface.quadric import QuadricRecord
from ...kernels.surface.records import load_plane, load_quadric, load_sphere
from ...kernels.tables import (
    BALL,
    CELL,
    PLANE,
    POLYGON,
    REGION,
    SHEET,
    SPHERE,
    Floats,
    Geometry,
    Ints,
    Signs,
    integer,
    is_halted,
    whole,
)
from ...kernels.threads import run_on
from ...queries import ray_queries
from ...queries.rays import Rays, lines_of
from .crossing_derivatives import as_kernel_array, as_kernel_rows

if TYPE_CHECKING:
    from ...prepare.prepared_scene import PreparedScene
    from ...queries.hits import Hits


NEAR = 2.0**-47
"""Points nearer to one another than this share of their coordinates are not told apart."""
ROUNDING = 2.0**-50
"""More than rounding takes from the value of a surface, as a share of its terms."""
TIED = 1
"""Of a crossing: other walls are met there."""


@inline
def largest(x: float, y: float, z: float) -> float:
    """The largest coordinate."""
    return max(abs(x), max(abs(y), abs(z)))


@inline
def _along(w: Vector, s: float, b: float, r: Vector) -> tuple[float, float, float, float]:
    """Along one axis of a quadric: (s y² + 2 b y, its terms, its slope by r's coordinates, its curvature), y = w·r."""
    y, steep = dot(w[0], w[1], w[2], r[0], r[1], r[2]), abs(w[0]) + abs(w[1]) + abs(w[2])
    return (
        s * y * y + 2.0 * b * y,
        abs(s) * y * y + 2.0 * abs(b * y),
        2.0 * abs(s * y + b) * steep,
        abs(s) * steep * steep,
    )


@inline
def _quadric_near(quadric: QuadricRecord, r: Vector, step: float) -> tuple[float, float]:
    """(value, below which size it may be zero) of a quadric."""
    _, _, _, w00, w01, w02, w10, w11, w12, w20, w21, w22, s0, s1, s2, b0, b1, b2, k = quadric
    value0, terms0, slope0, bend0 = _along((w00, w01, w02), s0, b0, r)
    value1, terms1, slope1, bend1 = _along((w10, w11, w12), s1, b1, r)
    value2, terms2, slope2, bend2 = _along((w20, w21, w22), s2, b2, r)
    slack = step * (slope0 + slope1 + slope2 + step * (bend0 + bend1 + bend2))
    return value0 + value1 + value2 - k, slack + ROUNDING * (terms0 + terms1 + terms2 + abs(k))


@helper
def near_surface(geometry: Geometry, surface: int, x: float, y: float, z: float, reach: float) -> tuple[float, float]:
    """(value of a surface at a point, below which size it may be zero); reach: of what the point is the sum of."""
    kind, row = integer(geometry, table.SURFACE_KIND, surface), integer(geometry, table.SURFACE_ROW, surface)
    if kind == PLANE:
        nx, ny, nz, over, ax, ay, az = load_plane(geometry, row)
        step = NEAR * max(reach, largest(ax, ay, az))
        value = dot(nx, ny, nz, x - ax, y - ay, z - az) + over
        return value, step * (abs(nx) + abs(ny) + abs(nz)) + ROUNDING * abs(over)
    if kind == SPHERE:
        cx, cy, cz, radius = load_sphere(geometry, row)
        step, rx, ry, rz = NEAR * max(reach, largest(cx, cy, cz)), x - cx, y - cy, z - cz
        square, own = dot(rx, ry, rz, rx, ry, rz), radius * radius
        slack = step * (2.0 * (abs(rx) + abs(ry) + abs(rz)) + 3.0 * step)
        return square - own, slack + ROUNDING * (square + own)
    quadric = load_quadric(geometry, row)
    step = NEAR * max(reach, largest(quadric.ax, quadric.ay, quadric.az))
    return _quadric_near(quadric, (x - quadric.ax, y - quadric.ay, z - quadric.az), step)


@inline
def _wall_of(geometry: Geometry, cell: int, slot: int, last: int) -> tuple[int, int, int]:
    """(surface, side, face number) of a wall of a cell: its planes, and after the last of them its quadric."""
    surface, face, side = place_face(geometry, whole(quadric_place(cell)) if slot == last else whole(slot))
    return surface, side, face


@inline
def _slots(geometry: Geometry, cell: int) -> tuple[int, int, int]:
    """(first, last, end) of the walls of a cell; at `last` is its quadric, if there is one."""
    last = integer(geometry, table.CELL_FIRST, cell + 1)
    end = last + 1 if integer(geometry, table.CELL_QUADRIC, cell) >= 0 else last
    return integer(geometry, table.CELL_FIRST, cell), last, end


@helper
def _touches(geometry: Geometry, cell: int, face: int, x: float, y: float, z: float, reach: float) -> bool:
    """Is a point on a wall of a cell that has another face number, and that no other wall of the cell cuts off?"""
    touched = False
    first, last, end = _slots(geometry, cell)
    for slot in range(first, end):
        surface, side, number = _wall_of(geometry, cell, slot, last)
        value, slack = near_surface(geometry, surface, x, y, z, reach)
        if side * value > slack:
            return False
        touched |= number != face and abs(value) <= slack
    return touched


@inline
def _is_outside(
    geometry: Geometry, bounds: LeafBounds, number: int, x: float, y: float, z: float, reach: float
) -> bool:
    """Is a point outside of the box of one of the leaves of a body?"""
    step = 4.0 * NEAR
    for axis in range(3):
        low, high = leaf_low(geometry, bounds, number, axis), leaf_high(geometry, bounds, number, axis)
        p = x if axis == 0 else y if axis == 1 else z
        if p < low - step * max(reach, abs(low)) or p > high + step * max(reach, abs(high)):
            return True
    return False


@inline
def _cells_of(geometry: Geometry, entry: int) -> tuple[int, int, bool]:
    """(first, end, are they leaves) of the cells of an entry; none for a ball or a sheet, which have one wall."""
    kind, index = integer(geometry, table.ENTRY_KIND, entry), integer(geometry, table.ENTRY_INDEX, entry)
    if kind == CELL:
        return index, index + 1, False
    if kind != REGION:
        return whole(0), whole(0), False
    first, end = leaves_of(geometry, index)
    return first, end, True


@helper
def on_cells(geometry: Geometry, entry: int, face: int, x: float, y: float, z: float, reach: float) -> bool:
    """Is a point on a wall of a cell of an entry, but for its walls with a face number?"""
    first, last, leaves = _cells_of(geometry, entry)
    bounds = leaf_bounds(geometry, integer(geometry, table.ENTRY_INDEX, entry) if leaves else whole(0))
    for k in range(first, last):
        if leaves and _is_outside(geometry, bounds, k - first, x, y, z, reach):
            continue
        cell = cell_of_leaf(geometry, k) if leaves else k
        if _touches(geometry, cell, face, x, y, z, reach):
            return True
    return False


@kernel(entry="n", face="n", origins="n 3", points="n 3", begin="0..end", end="0..n", tied="out n")
def ties_within(
    geometry: Geometry, entry: Ints, face: Ints, origins: Floats, points: Floats, begin: int, end: int, tied: Signs
) -> None:
    """tied[i] = TIED where a point of an entry's face is on another wall of it as well, else 0. Entries below 0: none.

    origins: where the rays came from that the points are on.
    """
    for i in range(begin, end):
        tied[i] = 0
        if entry[i] < 0 or is_halted(geometry):
            continue
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        reach = max(largest(x, y, z), largest(origins[i, 0], origins[i, 1], origins[i, 2]))
        if on_cells(geometry, whole(entry[i]), whole(face[i]), x, y, z, reach):
            tied[i] = TIED


@kernel(
    entry="n", surface="n", origins="n 3", points="n 3", begin="0..end", end="0..n", faces="out n"
)  # fmt: skip
def faces_on(
    geometry: Geometry, entry: Ints, surface: Ints, origins: Floats, points: Floats, begin: int, end: int, faces: Ints
) -> None:
    """The face numbers of points on surfaces of entries; of cells that share one the first that holds the point."""
    for i in range(begin, end):
        faces[i] = 0
        if is_halted(geometry):
            continue
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        reach = max(largest(x, y, z), largest(origins[i, 0], origins[i, 1], origins[i, 2]))
        first, last, leaves = _cells_of(geometry, whole(entry[i]))
        for k in range(first, last):
            cell = cell_of_leaf(geometry, k) if leaves else k
            face = _face_with(geometry, cell, whole(surface[i]))
            if face >= 0:
                faces[i] = face
                if _holds(geometry, cell, x, y, z, reach):
                    break


@inline
def _face_with(geometry: Geometry, cell: int, wanted: int) -> Any:
    """The face number of the wall of a cell that is a surface, or -1."""
    found: Any = whole(-1)
    first, last, end = _slots(geometry, cell)
    for slot in range(first, end):
        surface, _, number = _wall_of(geometry, cell, slot, last)
        if surface == wanted:
            found = number
    return found


@helper
def _holds(geometry: Geometry, cell: int, x: float, y: float, z: float, reach: float) -> bool:
    """Is a point in a cell, or on its walls?"""
    first, last, end = _slots(geometry, cell)
    for slot in range(first, end):
        surface, side, _ = _wall_of(geometry, cell, slot, last)
        value, slack = near_surface(geometry, surface, x, y, z, reach)
        if side * value > slack:
            return False
    return True


# Which hits lie on walls of other bodies as well: a kernel over the hits and the scene's tree.
#
# Hits that follow one another are mostly near one another, on one body. What is near several of them is looked for in
# the
# tree once, by their box; then each is tried on it, as a point. What is no ball and no single cell a point does not
# decide: there the ray must cross it, too.

OPEN = 2
"""Of a hit: rounding might change whether a ray crosses what its hit is on; a ray as it is traced tells (`ties`)."""
_RUN, _FEW_ENTRIES = 32, 32
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
def _drop_far_balls(geometry: Geometry, found: Ints, count: int, own: int, low: Vector, high: Vector) -> int:
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
    return _drop_far_balls(geometry, scratch.found, count, whole(entry[first]), low, high)


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
    ray, scale = scale_ray(plain)
    count, _, unsure = entry_crossings(geometry, scratch, other, ray_about(ray, t / scale, width / scale), 1)
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
        if entry[i] >= 0 and not is_halted(geometry):
            count = _gather(geometry, scratch, rays, entry, points, i, last, min(_FEW_ENTRIES, every))
            for k in range(i, last):
                near = _gather(geometry, scratch, rays, entry, points, k, k + 1, every) if count < 0 else count
                if tied[k] == 0:
                    tied[k] = _tie(geometry, scratch, rays, points, k, t[k], near)
        i = last


# Where more than one wall is met at once: there the answer has no derivative, as either wall may come to be the one.
#
# Within a body other walls of its cells are evaluated at the point; of other bodies the crossings of the ray about
# there
# are looked for. What cannot be told from a tie in floats counts as one.

_TIE_CHUNK = 4096


def find_ties_within(prepared: PreparedScene, entry: Any, face: Any, origins: FloatArray, points: FloatArray) -> Signs:
    """TIED (n,) where a point (n, 3) of an entry's face is on another wall of that entry as well, else 0.

    entry: -1 for a miss. origins (n, 3): of the rays that the points are on.
    """
    tied = np.zeros(len(entry), np.int8)
    arguments = as_kernel_array(entry), as_kernel_array(face), as_kernel_rows(origins, 3), as_kernel_rows(points, 3)
    count = len(entry)
    run_on(prepared.geometry, lambda g, a, b: ties_within(g, *arguments, a, b, tied), count, _TIE_CHUNK, count)
    return tied


def faces_of_ends(prepared: PreparedScene, entry: Any, surface: Any, origins: FloatArray, points: FloatArray) -> Any:
    """The face numbers (n,) of crossings of entries with surfaces; where cells share one, that of the cell met."""
    faces = np.zeros(len(entry), np.int32)
    arguments = as_kernel_array(entry), as_kernel_array(surface), as_kernel_rows(origins, 3), as_kernel_rows(points, 3)
    count = len(entry)
    run_on(prepared.geometry, lambda g, a, b: faces_on(g, *arguments, a, b, faces), count, _TIE_CHUNK, count)
    return faces


def find_hit_ties(hits: Hits) -> Signs:
    """TIED (n,) where a hit is on more than one wall, of its body or of several, else 0.

    Rays that start on a hit, and know it, meet nothing nearby.
    """
    prepared, found = hits._scene, hits._found
    origins, directions = (as_kernel_rows(part, 3) for part in lines_of(hits.rays))
    points, entry, count = as_kernel_rows(hits._points, 3), as_kernel_array(found.entry), hits.size
    tied = find_ties_within(prepared, entry, hits._faces[1], origins, points)
    if prepared.lowered.body_count < 2:
        return tied
    limits, starts = (np.array([-np.inf]), np.array([np.inf])), hits.rays._starts_in(prepared)
    arrays = RayArrays(origins, directions, *limits, as_kernel_array(starts))
    t = as_kernel_array(found.t)
    run_on(
        prepared.geometry,
        lambda g, a, b: ties_across(g, arrays, entry, t, points, a, b, tied),
        count,
        _TIE_CHUNK,
        count,
    )
    still = np.flatnonzero(tied == OPEN)
    if len(still):
        tied[still] = np.where(_has_crossings_nearby(hits, still), TIED, 0)
    return tied


def _has_crossings_nearby(hits: Hits, which: Any) -> Any:
    """bool: do some of the hits lie on walls of other bodies as well? As rays are traced, with certainty.

    A surface that bodies share is left out where rays start on it, so it is asked for by the rays as they came.
    """
    prepared, surface = hits._scene, hits._faces[0][which]
    origins, directions = (array[which] for array in lines_of(hits.rays))
    points, t = hits._points[which], hits._found.t[which]
    length = np.abs(directions).max(axis=1)
    size = np.maximum(np.abs(points).max(axis=1), np.abs(origins).max(axis=1))
    reach = np.maximum(NEAR * size / length, NEAR * np.abs(t))
    away = Rays._spawned(points, directions, surface.astype(np.int32), hits._home)
    tied = ray_queries.occluded(prepared, away, -reach, reach)
    common = np.flatnonzero(shared_surfaces(prepared)[surface])
    if len(common):
        t, part = t[common], reach[common]
        found = ray_queries.crossings(prepared, Rays(origins[common], directions[common]), t - part, t + part)
        tied[common] |= np.diff(found.offsets) > 1
    return tied


def shared_surfaces(prepared: PreparedScene) -> Any:
    """bool (surfaces,): is a surface of more than one body?"""
    known = vars(prepared).get("_shared_surfaces")
    if known is not None:
        return known
    tables = prepared.lowered.tables
    kind, index, owner = tables.entry_kind, tables.entry_index, np.arange(len(tables.entry_kind))
    of_cells = np.full(len(tables.cell_quadric), -1, np.int64)
    of_cells[index[kind == CELL]] = owner[kind == CELL]
    (first, count), of_programs = leaves_of_programs(tables), np.full(len(tables.program_leaf) - 1, -1, np.int64)
    of_programs[index[kind == REGION]] = owner[kind == REGION]
    of_leaves = np.repeat(of_programs, count)
    leaves = np.repeat(first - (np.cumsum(count) - count), count) + np.arange(len(of_leaves))
    of_cells[cells_of_leaves(tables, leaves[of_leaves >= 0])] = of_leaves[of_leaves >= 0]
    pairs = [
        (tables.cell_quadric, of_cells),
        (tables.plane_surface, np.repeat(of_cells, np.diff(tables.cell_first))),
        (index[kind == BALL], owner[kind == BALL]),
        (tables.sheet_surface[index[kind == SHEET]], owner[kind == SHEET]),
        (tables.polygon_surface[index[kind == POLYGON]], owner[kind == POLYGON]),
    ]
    surfaces, bodies = (np.concatenate(part).astype(np.int64) for part in zip(*pairs, strict=True))
    real = (surfaces >= 0) & (bodies >= 0)
    keys = np.unique(surfaces[real] * (prepared.lowered.body_count + 1) + bodies[real])
    users = np.bincount(keys // (prepared.lowered.body_count + 1), minlength=len(tables.surface_kind))
    found = vars(prepared)["_shared_surfaces"] = users > 1
    return found
