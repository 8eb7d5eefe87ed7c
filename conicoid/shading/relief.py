"""The normal by which a surface is shaded, where textures bend it. What is hit, and where, is always the true surface.

Light that would go through to the wrong side of the true surface is mirrored on it, so none is lost or found.
"""

from __future__ import annotations

from typing import Any

from ..compiler.jit import helper, inline
from ..engine.numbers.vectors import dot, normalized
from ..engine.tables import Geometry
from ..textures.patterns import Place
from ..textures.relief import bumped, mapped, towards_eye
from .materials import Materials
from .sight import ShadingPoint, Sight


@inline
def has_relief(row: Any) -> bool:
    """Do textures bend the normals of a material?"""
    return bool(row.bump >= 0 or row.normal_map >= 0)


@inline
def place_of(materials: Materials, sight: Sight) -> Place:
    """What is seen, as textures take it."""
    reach = materials.pixel[0] + materials.pixel[1] * sight.t
    return Place(sight.body, sight.face, sight.surface, sight.x, sight.y, sight.z, sight.nx, sight.ny, sight.nz, reach)


@helper
def bent_point(
    geometry: Geometry, materials: Materials, sight: Sight, number: int, point: ShadingPoint, from_inside: bool
) -> ShadingPoint:
    """The point with the normal by which it is shaded, on the eye's side; number: the row of its material."""
    row, at = materials.rows[number], place_of(materials, sight)
    nx, ny, nz = sight.nx, sight.ny, sight.nz
    if row.normal_map >= 0:
        nx, ny, nz = mapped(geometry, materials.textures, materials.texels, row.normal_map, at)
    if row.bump >= 0:
        bx, by, bz = bumped(geometry, materials.textures, materials.texels, row.bump, row.bump_height, at)
        nx, ny, nz = normalized(nx + bx, ny + by, nz + bz)
    if from_inside:
        nx, ny, nz = -nx, -ny, -nz
    nx, ny, nz = towards_eye(nx, ny, nz, point.ex, point.ey, point.ez)
    return ShadingPoint(point.x, point.y, point.z, nx, ny, nz, point.ex, point.ey, point.ez)


@inline
def on_side(
    dx: float, dy: float, dz: float, nx: float, ny: float, nz: float, above: bool
) -> tuple[float, float, float]:
    """A direction, mirrored on the plane across unit n where it is not on that side of it."""
    along = dot(dx, dy, dz, nx, ny, nz)
    if (along > 0.0) == above:
        return dx, dy, dz
    return dx - 2.0 * along * nx, dy - 2.0 * along * ny, dz - 2.0 * along * nz


@inline
def is_behind(sight: Sight, dx: float, dy: float, dz: float, lx: float, ly: float, lz: float) -> bool:
    """Does l, from what is seen along d, point to the other side of the true surface?"""
    return dot(sight.nx, sight.ny, sight.nz, dx, dy, dz) * dot(sight.nx, sight.ny, sight.nz, lx, ly, lz) >= 0.0
