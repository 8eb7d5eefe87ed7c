"""The unit normal of a surface at a point."""

from __future__ import annotations

from ...compiler.jit import inline
from .. import tables as table
from ..numbers.vectors import normalized
from ..tables import PLANE, SPHERE, Geometry, integer
from .quadric import quadric_gradient
from .records import load_plane, load_quadric, load_sphere


@inline
def gradient_at(geometry: Geometry, surface: int, x: float, y: float, z: float) -> tuple[float, float, float]:
    """A vector of some length along the normal of a surface at a point; at the apex of a cone along its axis."""
    kind, row = integer(geometry, table.SURFACE_KIND, surface), integer(geometry, table.SURFACE_ROW, surface)
    if kind == PLANE:
        plane = load_plane(geometry, row)
        return plane.nx, plane.ny, plane.nz
    if kind == SPHERE:
        cx, cy, cz, _ = load_sphere(geometry, row)
        return x - cx, y - cy, z - cz
    quadric = load_quadric(geometry, row)
    nx, ny, nz = quadric_gradient(quadric, x, y, z)
    if nx == 0.0 and ny == 0.0 and nz == 0.0:
        nx, ny, nz = quadric.w20, quadric.w21, quadric.w22
    return nx, ny, nz


@inline
def normal_at(geometry: Geometry, surface: int, side: int, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Unit normal of a surface at a point, times `side`; at the apex of a cone its axis."""
    nx, ny, nz = gradient_at(geometry, surface, x, y, z)
    nx, ny, nz = normalized(nx, ny, nz)
    return side * nx, side * ny, side * nz
