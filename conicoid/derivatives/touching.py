"""Which walls of a body a point is on, as far as floats can tell: by the cells of the body.

Points nearer to one another than 2^-47 of their coordinates are not told apart, so a surface's f counts as zero at a
point where it is below what such a step, and rounding, change it by.
"""

from __future__ import annotations

from typing import Any

from ..compiler.jit import helper, inline, kernel
from ..engine import tables as table
from ..engine.body.cell import place_face, quadric_place
from ..engine.culling.leaf_bounds import LeafBounds, leaf_bounds, leaf_high, leaf_low
from ..engine.numbers.vectors import Vector, dot
from ..engine.programs import cell_of_leaf, leaves_of
from ..engine.surface.quadric import Quadric
from ..engine.surface.records import load_plane, load_quadric, load_sphere
from ..engine.tables import (
    CELL,
    PLANE,
    REGION,
    SPHERE,
    Floats,
    Geometry,
    Ints,
    Signs,
    halted,
    integer,
    whole,
)

NEAR = 2.0**-47
"""Points nearer to one another than this share of their coordinates are not told apart."""
ROUNDED = 2.0**-50
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
def _quadric_near(quadric: Quadric, r: Vector, step: float) -> tuple[float, float]:
    """(value, below which size it may be zero) of a quadric."""
    _, _, _, w00, w01, w02, w10, w11, w12, w20, w21, w22, s0, s1, s2, b0, b1, b2, k = quadric
    value0, terms0, slope0, bend0 = _along((w00, w01, w02), s0, b0, r)
    value1, terms1, slope1, bend1 = _along((w10, w11, w12), s1, b1, r)
    value2, terms2, slope2, bend2 = _along((w20, w21, w22), s2, b2, r)
    slack = step * (slope0 + slope1 + slope2 + step * (bend0 + bend1 + bend2))
    return value0 + value1 + value2 - k, slack + ROUNDED * (terms0 + terms1 + terms2 + abs(k))


@helper
def near_surface(geometry: Geometry, surface: int, x: float, y: float, z: float, reach: float) -> tuple[float, float]:
    """(value of a surface at a point, below which size it may be zero); reach: of what the point is the sum of."""
    kind, row = integer(geometry, table.SURFACE_KIND, surface), integer(geometry, table.SURFACE_ROW, surface)
    if kind == PLANE:
        nx, ny, nz, over, ax, ay, az = load_plane(geometry, row)
        step = NEAR * max(reach, largest(ax, ay, az))
        value = dot(nx, ny, nz, x - ax, y - ay, z - az) + over
        return value, step * (abs(nx) + abs(ny) + abs(nz)) + ROUNDED * abs(over)
    if kind == SPHERE:
        cx, cy, cz, radius = load_sphere(geometry, row)
        step, rx, ry, rz = NEAR * max(reach, largest(cx, cy, cz)), x - cx, y - cy, z - cz
        square, own = dot(rx, ry, rz, rx, ry, rz), radius * radius
        slack = step * (2.0 * (abs(rx) + abs(ry) + abs(rz)) + 3.0 * step)
        return square - own, slack + ROUNDED * (square + own)
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
def _is_beyond(geometry: Geometry, bounds: LeafBounds, number: int, x: float, y: float, z: float, reach: float) -> bool:
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
        if leaves and _is_beyond(geometry, bounds, k - first, x, y, z, reach):
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
        if entry[i] < 0 or halted(geometry):
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
        if halted(geometry):
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
