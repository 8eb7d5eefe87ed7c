"""Membership of points in bodies, from the signs of surfaces at the point.

Leaves are closed, and Boolean combinations of them are exact.
"""

from __future__ import annotations

from ..._jit.decorators import helper, inline
from .. import tables as table
from ..faces import cell_side, plane_side
from ..numbers.double_double import sign, two_difference
from ..numbers.vectors import dot
from ..programs import cell_of_leaf, hold_program, root_value, turn_leaf
from ..ray import Ray
from ..surface.doubt import POINT, POINT_AT_BALL
from ..surface.exact_crossing import OPEN, RoundingRest, curved_terms, plane_terms, rest_number, rest_of_quadric
from ..surface.plane import PlaneLimits, PlaneRecord
from ..surface.quadric import SphereRecord, quadric_rounding, quadric_value
from ..surface.records import load_plane, load_quadric, load_sphere, plane_limits
from ..tables import BALL, CELL, PLANE, REGION, SPHERE, Geometry, integer, whole
from .boolean import collect_leaves
from .scratch import EVENT, LEAF, Scratch

INSIDE = 1
"""Answer of the tests below; 0 means outside, and OPEN (2) not certain."""


@inline
def point_ray(x: float, y: float, z: float) -> Ray:
    """Return a ray whose interval is a single point."""
    return Ray(x, y, z, 1.0, 1.0, 1.0, 0.0, 0.0, whole(-1))


@inline
def plane_value(plane: PlaneRecord, limits: PlaneLimits, x: float, y: float, z: float) -> tuple[float, float]:
    """Return (value of a plane at a point, its error bound)."""
    nx, ny, nz, over, ax, ay, az = plane
    (px, ex), (py, ey), (pz, ez) = two_difference(x, ax), two_difference(y, ay), two_difference(z, az)
    height = dot(nx, ny, nz, px, py, pz) + (dot(nx, ny, nz, ex, ey, ez) + over)
    terms = abs(nx * px) + abs(ny * py) + abs(nz * pz) + abs(over)
    return height, POINT * terms + limits.height


@inline
def sphere_value(sphere: SphereRecord, x: float, y: float, z: float) -> tuple[float, float]:
    """Return (value of a sphere at a point, its error bound)."""
    cx, cy, cz, r = sphere
    px, py, pz = x - cx, y - cy, z - cz
    square = px * px + py * py + pz * pz
    return square - r * r, POINT_AT_BALL * (square + r * r)


@helper
def surface_side(geometry: Geometry, rest: RoundingRest, surface: int, x: float, y: float, z: float) -> int:
    """Return the sign of a surface's value at a point, or OPEN.

    Floats decide where their error bound allows it, else pairs of floats with a bound (surface/exact_crossing.py).
    """
    row, kind = integer(geometry, table.SURFACE_ROW, surface), integer(geometry, table.SURFACE_KIND, surface)
    if kind == PLANE:
        value, off = plane_value(load_plane(geometry, row), plane_limits(geometry, row), x, y, z)
    elif kind == SPHERE:
        value, off = sphere_value(load_sphere(geometry, row), x, y, z)
    else:
        quadric = load_quadric(geometry, row)
        at = rest_of_quadric(geometry, row)
        value = quadric_value(quadric, x, y, z)
        off = quadric_rounding(
            quadric, x, y, z, rest_number(rest, at), rest_number(rest, at + 1), rest_number(rest, at + 2)
        )
    # Floats decide nearly all points; only those within the bound of rounding go on to pairs of floats
    if abs(value) > off:
        return 1 if value > 0.0 else -1
    if kind == PLANE:
        return sign(plane_terms(geometry, rest, surface, point_ray(x, y, z), 0.0)[0])
    return sign(curved_terms(geometry, rest, surface, point_ray(x, y, z), 0.0)[2])


@helper
def cell_holds(geometry: Geometry, rest: RoundingRest, cell: int, x: float, y: float, z: float) -> int:
    """Return INSIDE if the point is on the inner side of every face, or on a face; 0 outside; OPEN if not certain."""
    holds, quadric = INSIDE, integer(geometry, table.CELL_QUADRIC, cell)
    first, last = integer(geometry, table.CELL_FIRST, cell), integer(geometry, table.CELL_FIRST, cell + 1)
    for slot in range(first, last + 1 if quadric >= 0 else last):
        if slot == last:
            where, inner = surface_side(geometry, rest, quadric, x, y, z), cell_side(geometry, cell)
        else:
            where = surface_side(geometry, rest, integer(geometry, table.PLANE_SURFACE, slot), x, y, z)
            inner = plane_side(geometry, slot)
        # A later face may still prove that the point is outside
        if where == OPEN:
            holds = OPEN
        elif where * inner > 0:
            return 0
    return holds


@helper
def entry_holds(
    geometry: Geometry, rest: RoundingRest, scratch: Scratch, entry: int, x: float, y: float, z: float
) -> int:
    """Return INSIDE if an entry's body contains the point, 0 if not, OPEN if not certain.

    Sheets and polygons contain no point. `scratch.counts` is unchanged on return.
    """
    kind, index = integer(geometry, table.ENTRY_KIND, entry), integer(geometry, table.ENTRY_INDEX, entry)
    if kind == BALL:
        where = surface_side(geometry, rest, index, x, y, z)
        return OPEN if where == OPEN else (INSIDE if where <= 0 else 0)
    if kind == CELL:
        return cell_holds(geometry, rest, index, x, y, z)
    if kind != REGION:
        return 0
    count, certain = 0, True  # leaves that hold the point are listed in scratch.event, to be turned back
    hold_program(geometry, scratch.counts, index)
    for k in range(collect_leaves(geometry, scratch, index, point_ray(x, y, z))):
        if table.poll_halt(geometry, k):
            break
        leaf = scratch.found_leaves[k]
        holds = cell_holds(geometry, rest, cell_of_leaf(geometry, leaf), x, y, z)
        certain &= holds != OPEN
        if holds == INSIDE:
            turn_leaf(geometry, scratch.counts, index, leaf, True)
            scratch.event[EVENT * count + LEAF] = leaf
            count += 1
    inside = root_value(geometry, scratch.counts, index)
    for k in range(count):
        if table.poll_halt(geometry, k):
            break
        turn_leaf(geometry, scratch.counts, index, scratch.event[EVENT * k + LEAF], False)
    return (INSIDE if inside else 0) if certain else OPEN
