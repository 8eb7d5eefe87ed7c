"""The nearest point of a polygon: of its inside, or of one of its sides."""

from __future__ import annotations

import math

from ...compiler.jit import helper, inline
from .. import tables as table
from ..numbers.vectors import dot
from ..tables import Geometry, integer, real
from .form import form_at, length_of


@inline
def corner(geometry: Geometry, vertex: int, x: float, y: float, z: float) -> tuple[float, float, float]:
    """A vertex of the table, about a point."""
    at = 3 * vertex
    return (
        real(geometry, table.VERTICES, at) - x,
        real(geometry, table.VERTICES, at + 1) - y,
        real(geometry, table.VERTICES, at + 2) - z,
    )


@helper
def is_within(geometry: Geometry, polygon: int, x: float, y: float, z: float) -> bool:
    """Is a point of a polygon's plane within its outline, by even-odd?"""
    plane = form_at(geometry, integer(geometry, table.POLYGON_SURFACE, polygon), x, y, z)
    nx, ny, nz = abs(plane.gx), abs(plane.gy), abs(plane.gz)
    drop = 0 if (nx >= ny) & (nx >= nz) else (1 if ny >= nz else 2)
    first, last = integer(geometry, table.POLYGON_FIRST, polygon), integer(geometry, table.POLYGON_FIRST, polygon + 1)
    ax, ay, az = corner(geometry, last - 1, x, y, z)
    au, av = (ay, az) if drop == 0 else ((az, ax) if drop == 1 else (ax, ay))
    odd = False
    for vertex in range(first, last):
        bx, by, bz = corner(geometry, vertex, x, y, z)
        bu, bv = (by, bz) if drop == 0 else ((bz, bx) if drop == 1 else (bx, by))
        if (av < 0.0) != (bv < 0.0):
            side = au * bv - bu * av
            odd ^= (side > 0.0) if bv > av else (side < 0.0)
        au, av = bu, bv
    return odd


@inline
def nearest_of_side(ax: float, ay: float, az: float, bx: float, by: float, bz: float) -> tuple[float, float, float]:
    """The point of a side, from a to b, that is nearest to zero."""
    dx, dy, dz = bx - ax, by - ay, bz - az
    square = dot(dx, dy, dz, dx, dy, dz)
    t = -dot(ax, ay, az, dx, dy, dz) / square if square > 0.0 else 0.0
    if t <= 0.0:
        return ax, ay, az
    if t >= 1.0:
        return bx, by, bz
    return ax + t * dx, ay + t * dy, az + t * dz


@helper
def nearest_of_polygon(geometry: Geometry, polygon: int, x: float, y: float, z: float) -> tuple[float, float, float]:
    """The point of a whole polygon that is nearest to a point, about that."""
    plane = form_at(geometry, integer(geometry, table.POLYGON_SURFACE, polygon), x, y, z)
    h = -2.0 * plane.value
    vx, vy, vz = h * plane.gx, h * plane.gy, h * plane.gz
    if is_within(geometry, polygon, x + vx, y + vy, z + vz):
        return vx, vy, vz
    first, last = integer(geometry, table.POLYGON_FIRST, polygon), integer(geometry, table.POLYGON_FIRST, polygon + 1)
    ax, ay, az = corner(geometry, last - 1, x, y, z)
    best = math.inf
    for vertex in range(first, last):
        bx, by, bz = corner(geometry, vertex, x, y, z)
        px, py, pz = nearest_of_side(ax, ay, az, bx, by, bz)
        distance = length_of(px, py, pz)
        if distance < best:
            best, vx, vy, vz = distance, px, py, pz
        ax, ay, az = bx, by, bz
    return vx, vy, vz
