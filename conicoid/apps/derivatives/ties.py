"""Ties: crossings that lie on more than one wall, where a result has no derivative.

Within a body, the other walls of its cells are evaluated at the point. Across bodies, the scene's tree finds the
entries near the hits, and the crossings of the ray near the hit decide. A possible tie counts as a tie: points closer
than 2^-47 of their coordinates count as one, so a surface's f counts as zero at a point where its size is below what
such a step, plus rounding, can change it by.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..._jit.decorators import helper, inline, kernel
from ..._util.records import FloatArray
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
    leaf_bounds,
    leaf_high,
    leaf_low,
    leaves_of,
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
    SPHERE,
    Floats,
    Geometry,
    Ints,
    Signs,
    integer,
    is_halted,
    whole,
)
from ...kernels.threads import KernelRange, run_on
from ...prepare.prepared_scene import PreparedScene
from ...queries import ray_queries
from ...queries.hits import Hits
from ...queries.rays import Rays, lines_of
from .crossing_derivatives import as_kernel_array, as_kernel_rows
from .quadric_form import SurfaceUsers

NEAR = 2.0**-47
"""Points that are closer than this fraction of their coordinates count as one."""
ROUNDING = 2.0**-50
"""An upper bound on the rounding error of the value of a surface, as a fraction of the sum of its terms."""
TIED = 1
"""Mark of a crossing that lies on another wall too."""


@inline
def largest(x: float, y: float, z: float) -> float:
    """Return the largest absolute value of three coordinates."""
    return max(abs(x), max(abs(y), abs(z)))


@inline
def _along(w: Vector, s: float, b: float, r: Vector) -> tuple[float, float, float, float]:
    """Evaluate s y² + 2 b y, y = w·r, for one axis of a quadric.

    Return (value, sum of the sizes of its terms, bound on its slope by a coordinate of r, bound on its curvature).
    """
    y, steep = dot(w[0], w[1], w[2], r[0], r[1], r[2]), abs(w[0]) + abs(w[1]) + abs(w[2])
    return (
        s * y * y + 2.0 * b * y,
        abs(s) * y * y + 2.0 * abs(b * y),
        2.0 * abs(s * y + b) * steep,
        abs(s) * steep * steep,
    )


@inline
def _quadric_near(quadric: QuadricRecord, r: Vector, step: float) -> tuple[float, float]:
    """Return (value of a quadric at r, the size below which it may be zero) for points known to `step`."""
    _, _, _, w00, w01, w02, w10, w11, w12, w20, w21, w22, s0, s1, s2, b0, b1, b2, k = quadric
    value0, terms0, slope0, bend0 = _along((w00, w01, w02), s0, b0, r)
    value1, terms1, slope1, bend1 = _along((w10, w11, w12), s1, b1, r)
    value2, terms2, slope2, bend2 = _along((w20, w21, w22), s2, b2, r)
    slack = step * (slope0 + slope1 + slope2 + step * (bend0 + bend1 + bend2))
    return value0 + value1 + value2 - k, slack + ROUNDING * (terms0 + terms1 + terms2 + abs(k))


@helper
def near_surface(geometry: Geometry, surface: int, x: float, y: float, z: float, reach: float) -> tuple[float, float]:
    """Return (value of a surface at a point, the size below which it may be zero).

    `reach` is the largest coordinate of the terms whose sum the point is.
    """
    kind, row = integer(geometry, table.SURFACE_KIND, surface), integer(geometry, table.SURFACE_ROW, surface)
    if kind == PLANE:
        nx, ny, nz, over, ax, ay, az = load_plane(geometry, row)
        step = NEAR * max(reach, largest(ax, ay, az))
        # `over` is the value of the plane at its anchor.
        value = dot(nx, ny, nz, x - ax, y - ay, z - az) + over
        return value, step * (abs(nx) + abs(ny) + abs(nz)) + ROUNDING * abs(over)
    if kind == SPHERE:
        cx, cy, cz, radius = load_sphere(geometry, row)
        step, rx, ry, rz = NEAR * max(reach, largest(cx, cy, cz)), x - cx, y - cy, z - cz
        # The value is |r|² - radius²; a step in each coordinate changes |r|² by 2 |r_i| step + step² each.
        square, own = dot(rx, ry, rz, rx, ry, rz), radius * radius
        slack = step * (2.0 * (abs(rx) + abs(ry) + abs(rz)) + 3.0 * step)
        return square - own, slack + ROUNDING * (square + own)
    quadric = load_quadric(geometry, row)
    step = NEAR * max(reach, largest(quadric.ax, quadric.ay, quadric.az))
    return _quadric_near(quadric, (x - quadric.ax, y - quadric.ay, z - quadric.az), step)


@inline
def _wall_of(geometry: Geometry, cell: int, slot: int, last: int) -> tuple[int, int, int]:
    """Return (surface, side, face number) of the wall in a slot of a cell; slot `last` is its quadric."""
    surface, face, side = place_face(geometry, whole(quadric_place(cell)) if slot == last else whole(slot))
    return surface, side, face


@inline
def _slots(geometry: Geometry, cell: int) -> tuple[int, int, int]:
    """Return (first, last, end): planes fill the slots first to last, and a quadric, if any, the slot `last`."""
    last = integer(geometry, table.CELL_FIRST, cell + 1)
    end = last + 1 if integer(geometry, table.CELL_QUADRIC, cell) >= 0 else last
    return integer(geometry, table.CELL_FIRST, cell), last, end


@helper
def _touches(geometry: Geometry, cell: int, face: int, x: float, y: float, z: float, reach: float) -> bool:
    """Return whether a point is on a wall of a cell with another face number, and outside none of the cell's walls."""
    is_on_wall = False
    first, last, end = _slots(geometry, cell)
    for slot in range(first, end):
        surface, side, number = _wall_of(geometry, cell, slot, last)
        value, slack = near_surface(geometry, surface, x, y, z, reach)
        if side * value > slack:
            return False
        # The wall of the crossing itself has the number `face` and does not count.
        is_on_wall |= number != face and abs(value) <= slack
    return is_on_wall


@inline
def _is_outside(
    geometry: Geometry, bounds: LeafBounds, number: int, x: float, y: float, z: float, reach: float
) -> bool:
    """Return whether a point is outside the box of a leaf of a body, widened by rounding."""
    step = 4.0 * NEAR
    for axis in range(3):
        low, high = leaf_low(geometry, bounds, number, axis), leaf_high(geometry, bounds, number, axis)
        p = x if axis == 0 else y if axis == 1 else z
        if p < low - step * max(reach, abs(low)) or p > high + step * max(reach, abs(high)):
            return True
    return False


@inline
def _cells_of(geometry: Geometry, entry: int) -> tuple[int, int, bool]:
    """Return (first, end, whether they are leaves) of an entry's cells; balls and sheets, of one wall, have none."""
    kind, index = integer(geometry, table.ENTRY_KIND, entry), integer(geometry, table.ENTRY_INDEX, entry)
    if kind == CELL:
        return index, index + 1, False
    if kind != REGION:
        return whole(0), whole(0), False
    first, end = leaves_of(geometry, index)
    return first, end, True


@helper
def on_cells(geometry: Geometry, entry: int, face: int, x: float, y: float, z: float, reach: float) -> bool:
    """Return whether a point is on a wall of an entry's cells, apart from walls with the face number `face`."""
    first, last, leaves = _cells_of(geometry, entry)
    # A point outside the box of a leaf cannot touch its cell, and the box is the quicker test.
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
    """Set tied[i] to TIED where a point on an entry's face is on another wall of that entry, else to 0.

    origins: of the rays that the points are on. Entries below 0 are misses, without ties.
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
    """Set faces[i] to the face number of a point on a surface of an entry.

    Of cells that share the surface, the first one that holds the point decides.
    """
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
def _face_with(geometry: Geometry, cell: int, target: int) -> Any:
    """Return the face number of the wall of a cell on the surface `target`, or -1."""
    face: Any = whole(-1)
    first, last, end = _slots(geometry, cell)
    for slot in range(first, end):
        surface, _, number = _wall_of(geometry, cell, slot, last)
        if surface == target:
            face = number
    return face


@helper
def _holds(geometry: Geometry, cell: int, x: float, y: float, z: float, reach: float) -> bool:
    """Return whether a point is in a cell or on its walls."""
    first, last, end = _slots(geometry, cell)
    for slot in range(first, end):
        surface, side, _ = _wall_of(geometry, cell, slot, last)
        value, slack = near_surface(geometry, surface, x, y, z, reach)
        if side * value > slack:
            return False
    return True


# --- Ties across bodies: a kernel over the hits and the scene's tree
#
# Consecutive hits are mostly close together on one body. So the tree is searched once for a run of hits, by their box,
# and each hit is then tested against the entries found. For balls and single cells the point decides. For all other
# entries the ray must also cross the entry there.

OPEN = 2
"""Mark of a hit for which rounding could change whether its ray crosses the entry; a traced ray then decides."""
_RUN, _FEW_ENTRIES = 32, 32
"""Hits in one search at most, and entries near them at most; with more entries, each hit is searched alone."""


@inline
def _reach(rays: RayArrays, points: Floats, i: int) -> float:
    """Return the largest coordinate of a hit's point and of its ray's origin."""
    o = largest(rays.origins[i, 0], rays.origins[i, 1], rays.origins[i, 2])
    return max(o, largest(points[i, 0], points[i, 1], points[i, 2]))


@inline
def _run_of(entry: Ints, i: int, end: int) -> int:
    """Return the end of the run of hits on one entry that starts at hit i."""
    last = i + 1
    while last < end and last - i < _RUN and entry[last] == entry[i]:
        last += 1
    return last


@inline
def _drop_far_balls(geometry: Geometry, found: Ints, count: int, own: int, low: Vector, high: Vector) -> int:
    """Drop from found[:count] the entry `own`, and balls whose wall misses the box's sphere; return the count."""
    # A negative count, for too many entries, passes through: no loop runs, and it is returned.
    count_near, size = (
        min(count, 0),
        0.51 * math.sqrt((high[0] - low[0]) ** 2 + (high[1] - low[1]) ** 2 + (high[2] - low[2]) ** 2),
    )
    x, y, z = 0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), 0.5 * (low[2] + high[2])
    for k in range(count):
        entry = found[k]
        near = entry != own
        if near and integer(geometry, table.ENTRY_KIND, entry) == BALL:
            row = integer(geometry, table.SURFACE_ROW, integer(geometry, table.ENTRY_INDEX, entry))
            cx, cy, cz, radius = load_sphere(geometry, row)
            squared = dot(x - cx, y - cy, z - cz, x - cx, y - cy, z - cz)
            # The wall is within `size` of (x, y, z) if the distance to the centre is within radius ± size.
            least, loose = max(0.0, radius - size), 2.0**-40 * (squared + radius * radius)
            near = least * least - loose <= squared <= (radius + size) * (radius + size) + loose
        if near:
            found[count_near] = entry
            count_near += 1
    return count_near


@helper
def _gather(
    geometry: Geometry, scratch: Scratch, rays: RayArrays, entry: Ints, points: Floats, first: int, last: int, most: int
) -> int:
    """Put other entries near the hits first to last into scratch.found; return their count, or -1 if too many.

    The hits are on one entry.
    """
    lx, ly, lz = points[first, 0], points[first, 1], points[first, 2]
    hx, hy, hz, reach = lx, ly, lz, 0.0
    for i in range(first, last):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        lx, ly, lz, hx, hy, hz = min(lx, x), min(ly, y), min(lz, z), max(hx, x), max(hy, y), max(hz, z)
        reach = max(reach, _reach(rays, points, i))
    # The box grows by more than the step within which walls count as touched.
    more = 8.0 * NEAR * reach
    low, high = (lx - more, ly - more, lz - more), (hx + more, hy + more, hz + more)
    put_box(scratch.way, low, high)
    count = walk_box(geometry, scratch.way, scene_tree(geometry), scratch.found, most)
    return _drop_far_balls(geometry, scratch.found, count, whole(entry[first]), low, high)


@inline
def _is_on(geometry: Geometry, entry: int, x: float, y: float, z: float, reach: float) -> bool:
    """Return whether a point is, or may be, on a wall of an entry; where it may be, the ray decides."""
    kind, index = integer(geometry, table.ENTRY_KIND, entry), integer(geometry, table.ENTRY_INDEX, entry)
    # Cells and Boolean programs have several walls, balls and sheets one.
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
    """Return TIED if hit i is on a wall of the entry `other`, OPEN if that is not certain, else 0."""
    reach = _reach(rays, points, i)
    if not _is_on(geometry, other, points[i, 0], points[i, 1], points[i, 2], reach):
        return 0
    if integer(geometry, table.ENTRY_KIND, other) <= CELL:
        return TIED
    plain = load_ray(rays, i)
    # Only crossings of the ray within this distance in t of the hit count.
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
    """Return the strongest mark of hit i among the entries scratch.found[:count]: TIED, then OPEN, then 0."""
    strongest = 0
    for k in range(count):
        one = _tie_with(geometry, scratch, rays, points, i, t, whole(scratch.found[k]))
        if one == TIED:
            return TIED
        strongest = max(strongest, one)
    return strongest


@kernel(entry="n", t="n", points="n 3", begin="0..end", end="0..n", tied="out n")
def ties_across(
    geometry: Geometry, rays: RayArrays, entry: Ints, t: Floats, points: Floats, begin: int, end: int, tied: Signs
) -> None:
    """Set tied[i] to TIED where a hit is on a wall of another entry, to OPEN where that is not certain.

    Hits that are tied already are not tested.
    """
    # A count below 0 means too many entries near the run: then each hit searches the tree alone.
    scratch = new_scratch(geometry)
    every, i = len(scratch.found), begin
    while i < end:
        last = _run_of(entry, i, end)
        if entry[i] >= 0 and not is_halted(geometry):
            count = _gather(geometry, scratch, rays, entry, points, i, last, min(_FEW_ENTRIES, every))
            for k in range(i, last):
                near = _gather(geometry, scratch, rays, entry, points, k, k + 1, every) if count < 0 else count
                # A hit that ties within its own body needs no search.
                if tied[k] == 0:
                    tied[k] = _tie(geometry, scratch, rays, points, k, t[k], near)
        i = last


# --- Arrays of ties: at a tie there is no derivative, since a small change may make either wall the one that is hit

_TIE_CHUNK = 4096
"""Crossings that a thread takes at a time."""


def find_ties_within(prepared: PreparedScene, entry: Any, face: Any, origins: FloatArray, points: FloatArray) -> Signs:
    """Return TIED (n,) where a point (n, 3) on an entry's face is on another wall of that entry, else 0.

    entry: (n,), -1 for a miss. origins: (n, 3), of the rays that the points are on.
    """
    return _run_on_points(ties_within, prepared, entry, face, origins, points, np.int8)


def faces_of_ends(prepared: PreparedScene, entry: Any, surface: Any, origins: FloatArray, points: FloatArray) -> Any:
    """Return the face numbers (n,) of crossings from their entries and surfaces.

    Where cells share a surface, the number is that of the first cell that holds the point.
    """
    return _run_on_points(faces_on, prepared, entry, surface, origins, points, np.int32)


def _run_on_points(
    kernel: Any, prepared: PreparedScene, entry: Any, wall: Any, origins: FloatArray, points: FloatArray, kind: Any
) -> Any:
    """Return the numbers (n,) that a kernel writes for points on walls of entries."""
    count, found = len(entry), np.zeros(len(entry), kind)
    arguments = as_kernel_array(entry), as_kernel_array(wall), as_kernel_rows(origins, 3), as_kernel_rows(points, 3)
    run_on(prepared.geometry, KernelRange(kernel, arguments, (found,)), count, _TIE_CHUNK, count)
    return found


def find_hit_ties(hits: Hits) -> Signs:
    """Return TIED (n,) where a hit is on more than one wall, of its own body or of others, else 0.

    Undecided hits are traced again by rays spawned on them, which cross nothing near the hit unless there is a tie.
    """
    prepared, buffers = hits._scene, hits._buffers
    origins, directions = (as_kernel_rows(part, 3) for part in lines_of(hits.rays))
    points, entry, count = as_kernel_rows(hits._points, 3), as_kernel_array(buffers.entry), hits.size
    # First within the bodies, then across bodies for the hits that are left.
    tied = find_ties_within(prepared, entry, hits._faces[1], origins, points)
    if prepared.lowered.body_count < 2:
        return tied
    limits, starts = (np.array([-np.inf]), np.array([np.inf])), hits.rays._starts_in(prepared)
    arrays = RayArrays(origins, directions, *limits, as_kernel_array(starts))
    t = as_kernel_array(buffers.t)
    run_on(
        prepared.geometry,
        KernelRange(ties_across, (arrays, entry, t, points), (tied,)),
        count,
        _TIE_CHUNK,
        count,
    )
    undecided = np.flatnonzero(tied == OPEN)
    if len(undecided):
        tied[undecided] = np.where(_has_crossings_nearby(hits, undecided), TIED, 0)
    return tied


def _has_crossings_nearby(hits: Hits, which: Any) -> Any:
    """Return bool (n,): whether the hits `which` lie on walls of other bodies, decided by tracing rays.

    A ray spawned on a surface ignores that surface. So a surface of several bodies is tested with the original ray.
    """
    prepared, surface = hits._scene, hits._faces[0][which]
    origins, directions = (array[which] for array in lines_of(hits.rays))
    points, t = hits._points[which], hits._buffers.t[which]
    # `reach` in units of t: the step of the coordinates over the direction, and the same fraction of t.
    length = np.abs(directions).max(axis=1)
    size = np.maximum(np.abs(points).max(axis=1), np.abs(origins).max(axis=1))
    reach = np.maximum(NEAR * size / length, NEAR * np.abs(t))
    rays = Rays._spawned(points, directions, surface.astype(np.int32), hits._home)
    tied = ray_queries.occluded(prepared, rays, -reach, reach)
    common = np.flatnonzero(shared_surfaces(prepared)[surface])
    if len(common):
        t, part = t[common], reach[common]
        crossings = ray_queries.crossings(prepared, Rays(origins[common], directions[common]), t - part, t + part)
        # The original ray crosses its own wall, so a second crossing is a tie.
        tied[common] |= np.diff(crossings.offsets) > 1
    return tied


def shared_surfaces(prepared: PreparedScene) -> Any:
    """Return bool (surfaces,): whether several bodies share a surface. The result is cached on the prepared scene."""
    cached = vars(prepared).get("_shared_surfaces")
    if cached is not None:
        return cached
    tables = prepared.lowered.tables
    users = np.bincount(SurfaceUsers.of(tables).surface, minlength=len(tables.surface_kind))
    is_shared = vars(prepared)["_shared_surfaces"] = users > 1
    return is_shared
