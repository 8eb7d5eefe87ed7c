"""Groups of the planes of cells that have many: trees that rays go down (`kernels/body/cell.py`).

The planes of a cell are sorted by halving, each time along the axis in which their normals differ most, so that those
side by side are alike. Runs of 4, 16, 64, ... planes are the groups. Every group bounds the values of its planes: their
normals by a box, and their values at an anchor, the point that is nearest to all of them. About there the value of each
plane is small, and so is what the box adds.

User: solids of OpenSCAD and meshes; factor: 7 to 10 for rays on a sphere with `$fn = 100`, 70 with `$fn = 400`.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..._jit.decorators import helper, inline, kernel
from ...kernels import tables as table
from ...kernels.body.cell import FIRST_CUTS, FIRST_GROUPS, MANY_PLANES, PLANE_ROUNDING, groups_of
from ...kernels.faces import plane_side
from ...kernels.surface.plane import PlaneRecord
from ...kernels.surface.records import load_plane
from ...kernels.tables import GROUP_SIZE, LINKS, Floats, Geometry, Ints, integer, length

_DAMPING = 1e-6  # so that planes that are nearly parallel have an anchor
_NORMAL = 4  # floats for each plane: its outward unit normal, and its value at the cell's middle


def group_tables(counts: Any) -> dict[str, Any]:
    """Return the columns of the groups of cells with these numbers of planes; bounds and planes as shapes only."""
    first = _first_groups(counts)
    total = int(first[-1]) if len(first) else 0
    return dict(
        cell_groups=first,
        group_bounds=np.broadcast_to(0.0, (total, GROUP_SIZE)),
        group_planes=np.broadcast_to(np.int32(0), (total, LINKS)),
    )


def _first_groups(counts: Any) -> Ints:
    """Return `Tables.cell_groups`."""
    most, size = int(counts.max(initial=0)), 4
    if most < MANY_PLANES:
        return np.zeros(0, np.int32)
    many = counts >= MANY_PLANES
    groups = np.where(many, FIRST_GROUPS, 0)
    while size < most:
        # The last run is no group of its own if a smaller one holds its planes
        runs = counts // size + (counts % size > (0 if size == 4 else size // 4))
        groups += np.where(many & (size < counts), runs, 0)
        size *= 4
    return np.concatenate([np.zeros(1, np.int64), np.cumsum(groups)]).astype(np.int32)


def put_groups(geometry: Geometry, begin: int, end: int) -> None:
    """Fill the tables of the groups of cells begin..end."""
    if length(geometry, table.CELL_GROUPS):
        at, count = int(geometry.places[table.CELL_FIRST]), int(length(geometry, table.CELL_FIRST))
        most = int(np.diff(geometry.integers[at : at + count][begin : end + 1]).max(initial=0))
        _put_groups(geometry, np.empty(_NORMAL * most), np.empty(most, np.int32), begin, end)


@kernel(geometry="out", values="out 4*m", order="out m", begin="0..end")
def _put_groups(geometry: Geometry, values: Floats, order: Ints, begin: int, end: int) -> None:
    """`put_groups`; `values` and `order` have room for the planes of the largest of the cells."""
    for cell in range(begin, min(end, length(geometry, table.CELL_GROUPS) - 1)):
        first, last = groups_of(geometry, cell)
        start = integer(geometry, table.CELL_FIRST, cell)
        count = integer(geometry, table.CELL_FIRST, cell + 1) - start
        if first < last and count <= len(order):
            _put_groups_of(geometry, values, order, start, count, first, last)


@helper
def _put_groups_of(
    geometry: Geometry, values: Floats, order: Ints, start: int, count: int, first: int, last: int
) -> None:
    """Write groups first..last, of the planes start..start + count of a cell."""
    x, y, z = 0.0, 0.0, 0.0
    for k in range(count):
        plane = _plane(geometry, start, k)
        x, y, z = x + plane.ax / count, y + plane.ay / count, z + plane.az / count
    for k in range(count):
        plane, at = _plane(geometry, start, k), _NORMAL * k
        size = math.sqrt(plane.nx * plane.nx + plane.ny * plane.ny + plane.nz * plane.nz)
        size = size if plane_side(geometry, start + k) > 0 else -size
        nx, ny, nz = plane.nx / size, plane.ny / size, plane.nz / size
        values[at], values[at + 1], values[at + 2] = nx, ny, nz
        values[at + 3] = (nx * (x - plane.ax) + ny * (y - plane.ay) + nz * (z - plane.az)) + plane.above / size
        order[k] = k
    _sort_planes(values, order, count)
    _put_first(geometry, values, count, first)
    group, largest = first + FIRST_GROUPS, 4
    while 4 * largest < count:
        largest *= 4
    for begin in range(0, count, 4):
        size = largest
        while size >= 4:
            # A run whose planes a smaller one holds is no group of its own
            if begin % size == 0 and (size == 4 or count - begin > size // 4):
                end = min(count, begin + size)
                if group < last:
                    _put_bounds(geometry, values, order, start, begin, end, (x, y, z), group)
                    links = geometry.places[table.GROUP_PLANES] + LINKS * group
                    for k in range(4):  # of a larger group one plane, which is likely to cut before the others
                        one = order[begin + k] if size == 4 and begin + k < end else -1
                        geometry.integers[links + k] = order[(begin + end) // 2] if size > 4 and k == 0 else one
                    geometry.integers[links + LINKS - 1] = _groups_of_run(end - begin, size)
                group += 1
            size //= 4


@inline
def _plane(geometry: Geometry, start: int, k: int) -> PlaneRecord:
    """Return the record of plane k of a cell whose planes begin at a place."""
    return load_plane(geometry, integer(geometry, table.SURFACE_ROW, integer(geometry, table.PLANE_SURFACE, start + k)))


@helper
def _sort_planes(values: Floats, order: Ints, count: int) -> None:
    """Sort planes so that runs of 4, 8, 16, ... are alike."""
    half = 4
    while 2 * half < count:
        half *= 2
    while half >= 4:
        for begin in range(0, count - half, 2 * half):
            end, axis, widest = min(count, begin + 2 * half), 0, -1.0
            for k in range(3):
                low, high = math.inf, -math.inf
                for i in range(begin, end):
                    value = values[_NORMAL * order[i] + k]
                    low, high = min(low, value), max(high, value)
                if high - low > widest:
                    axis, widest = k, high - low
            _select(values, order, axis, begin, begin + half, end)
        half //= 2


@helper
def _select(values: Floats, order: Ints, axis: int, begin: int, middle: int, end: int) -> None:
    """Move the planes of order[begin:end] whose normals have the least components along an axis before `middle`."""
    low, high = begin, end - 1
    while low < high:
        pivot, i, j = values[_NORMAL * order[(low + high) >> 1] + axis], low, high
        while i <= j:
            while values[_NORMAL * order[i] + axis] < pivot:
                i += 1
            while values[_NORMAL * order[j] + axis] > pivot:
                j -= 1
            if i <= j:
                order[i], order[j] = order[j], order[i]
                i += 1
                j -= 1
        if middle <= j:
            high = j
        elif middle >= i:
            low = i
        else:
            return


@helper
def _put_first(geometry: Geometry, values: Floats, count: int, first: int) -> None:
    """Write the planes that cut first: each has the normal that is farthest from those before it."""
    links = geometry.places[table.GROUP_PLANES] + LINKS * first
    for k in range(FIRST_CUTS):
        chosen, best = 0, -1.0
        for i in range(count if k > 0 else 0):
            least = math.inf
            for other in range(k):
                j = geometry.integers[links + LINKS * (other >> 2) + (other & 3)]
                if i == j:
                    least = -2.0  # each plane once, also where all normals are taken
                square = 0.0
                for axis in range(3):
                    difference = values[_NORMAL * i + axis] - values[_NORMAL * j + axis]
                    square += difference * difference
                least = min(least, square)
            if least > best:
                chosen, best = i, least
        geometry.integers[links + LINKS * (k >> 2) + (k & 3)] = chosen
    for k in range(FIRST_GROUPS):
        geometry.integers[links + LINKS * k + LINKS - 1] = 1
        for i in range(GROUP_SIZE):
            geometry.floats[geometry.places[table.GROUP_BOUNDS] + GROUP_SIZE * (first + k) + i] = 0.0


@helper
def _put_bounds(
    geometry: Geometry, values: Floats, order: Ints, start: int, begin: int, end: int,
    middle: tuple[float, float, float], group: int,
) -> None:  # fmt: skip
    """Write the bounds of the group of planes order[begin:end]."""
    x, y, z = _nearest_point(values, order, begin, end)
    ax, ay, az = middle[0] + x, middle[1] + y, middle[2] + z
    lx = ly = lz = math.inf
    hx = hy = hz = most = -math.inf
    far = 0.0
    for i in range(begin, end):
        at, plane = _NORMAL * order[i], _plane(geometry, start, order[i])
        nx, ny, nz = values[at], values[at + 1], values[at + 2]
        lx, ly, lz, hx, hy, hz = min(lx, nx), min(ly, ny), min(lz, nz), max(hx, nx), max(hy, ny), max(hz, nz)
        size = math.sqrt(plane.nx * plane.nx + plane.ny * plane.ny + plane.nz * plane.nz)
        above = plane.above / size if plane_side(geometry, start + order[i]) > 0 else -plane.above / size
        most = max(most, (nx * (ax - plane.ax) + ny * (ay - plane.ay) + nz * (az - plane.az)) + above)
        far = max(far, (abs(plane.ax) + abs(plane.ay) + abs(plane.az)) + abs(above))
    # What is added is more than all rounding: of these numbers, of the normals and of the values
    at, f = geometry.places[table.GROUP_BOUNDS] + GROUP_SIZE * group, geometry.floats
    f[at], f[at + 1], f[at + 2] = 0.5 * (lx + hx), 0.5 * (ly + hy), 0.5 * (lz + hz)
    f[at + 3], f[at + 4], f[at + 5] = (
        0.5 * (hx - lx) + PLANE_ROUNDING,
        0.5 * (hy - ly) + PLANE_ROUNDING,
        0.5 * (hz - lz) + PLANE_ROUNDING,
    )
    f[at + 6], f[at + 7], f[at + 8] = ax, ay, az
    f[at + 9] = most + 4.0 * PLANE_ROUNDING * ((abs(ax) + abs(ay) + abs(az)) + far)


@inline
def _nearest_point(values: Floats, order: Ints, begin: int, end: int) -> tuple[float, float, float]:
    """Return the point, from the cell's middle, that is nearest to planes order[begin:end], by damped least squares."""
    xx = yy = zz = _DAMPING * (end - begin)
    xy = yz = zx = x = y = z = 0.0
    for i in range(begin, end):
        at = _NORMAL * order[i]
        nx, ny, nz, value = values[at], values[at + 1], values[at + 2], values[at + 3]
        xx, yy, zz = xx + nx * nx, yy + ny * ny, zz + nz * nz
        xy, yz, zx = xy + nx * ny, yz + ny * nz, zx + nz * nx
        x, y, z = x - nx * value, y - ny * value, z - nz * value
    # Cramer's rule
    ax, ay, az = yy * zz - yz * yz, zx * yz - xy * zz, xy * yz - zx * yy
    by, bz, cz = xx * zz - zx * zx, xy * zx - xx * yz, xx * yy - xy * xy
    scale = xx * ax + xy * ay + zx * az
    x, y, z = ax * x + ay * y + az * z, ay * x + by * y + bz * z, az * x + bz * y + cz * z
    return x / scale, y / scale, z / scale


@inline
def _groups_of_run(planes: int, largest: int) -> int:
    """Return how many groups a run of planes has, with runs of up to `largest`."""
    groups, size = 0, 4
    while size <= largest:
        groups += planes // size + (1 if planes % size > (0 if size == 4 else size // 4) else 0)
        size *= 4
    return groups
