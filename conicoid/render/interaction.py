"""The end of a ray: the wall that it meets, and the point of that wall as an eye sees it, with its shading normal."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from .._jit.decorators import helper, inline
from ..kernels.closest.form import perpendicular_axes
from ..kernels.numbers.vectors import dot, normalize
from ..kernels.tables import Geometry
from .bsdf.material_table import MaterialTable
from .textures import BOX, Texels, TexturePlace, coordinates, texture_color


class SurfaceInteraction(NamedTuple):
    """The first visible wall along a ray; body -1 if there is none."""

    t: float
    body: Any  # int64, as those that follow
    surface: Any
    face: Any
    side: Any
    before: Any  # the medium in front of it
    after: Any  # and behind it
    x: float
    y: float
    z: float
    nx: float  # outward
    ny: float
    nz: float


class ShadingPoint(NamedTuple):
    """A point of a surface as an eye sees it; both vectors are of unit length."""

    x: float
    y: float
    z: float
    nx: float  # the normal on the eye's side
    ny: float
    nz: float
    ex: float  # to the eye
    ey: float
    ez: float


@inline
def face_viewer(sight: SurfaceInteraction, dx: float, dy: float, dz: float) -> tuple[ShadingPoint, float, bool]:
    """Return (the point seen along unit d, the cosine of its normal and -d, whether the body is seen from inside)."""
    x, y, z, nx, ny, nz = sight.x, sight.y, sight.z, sight.nx, sight.ny, sight.nz
    cosine = -dot(nx, ny, nz, dx, dy, dz)
    if cosine < 0.0:
        return ShadingPoint(x, y, z, -nx, -ny, -nz, -dx, -dy, -dz), -cosine, True
    return ShadingPoint(x, y, z, nx, ny, nz, -dx, -dy, -dz), cosine, False


@inline
def shows_light(materials: MaterialTable, sight: SurfaceInteraction, from_inside: bool) -> bool:
    """Return whether a surface shows the light of lights. The inner side of glass does not."""
    return not (from_inside and materials.medium[sight.body] == 1)


# Shading normals: bumps by the height that a texture gives, and maps of normals
#
# A surface raised by h along its unit normal N has, for low h, the normal along N - grad h, with the gradient of h
# across the surface (Blinn, Simulation of wrinkled surfaces, 1978). Central differences give the gradient, with half a
# pixel to each side, or 2⁻²⁰ of the distance from the origin if that is more. A map's red and green are the components
# 2 c - 1 along growing u and across it, towards growing v; its blue is the component along N.
#
# The hit and its place are always the true surface's. Light that would go through to the wrong side of the true surface
# is mirrored on it, so no light is lost or gained.

_LEAST = 2.0**-20  # of the distance from the origin: below, differences are rounding


@inline
def _step(at: TexturePlace) -> float:
    """Return the length of a difference to one side, in the world."""
    return max(0.5 * at.reach, _LEAST * max(abs(at.x), max(abs(at.y), abs(at.z))))


@inline
def _offset_place(at: TexturePlace, x: float, y: float, z: float) -> TexturePlace:
    """Return the place moved by (x, y, z)."""
    return TexturePlace(at.body, at.face, at.surface, at.x + x, at.y + y, at.z + z, at.nx, at.ny, at.nz, at.reach)


@inline
def _height(geometry: Geometry, textures: Any, texels: Texels, number: int, at: TexturePlace) -> float:
    """Return the brightness of a texture at a place, which is the height of a bump."""
    r, g, b = texture_color(geometry, textures, texels, number, at)
    return (r + g + b) * (1.0 / 3.0)


@inline
def _slope(
    geometry: Geometry, textures: Any, texels: Texels, number: int, at: TexturePlace, x: float, y: float, z: float
) -> float:
    """Return the difference of the height at (x, y, z) from the place and at (-x, -y, -z) from it."""
    above = _height(geometry, textures, texels, number, _offset_place(at, x, y, z))
    return above - _height(geometry, textures, texels, number, _offset_place(at, -x, -y, -z))


@helper
def bump_normal(
    geometry: Geometry, textures: Any, texels: Texels, number: int, height: float, at: TexturePlace
) -> tuple[float, float, float]:
    """Return the vector that bumps, `height` high where the texture is white, add to the unit normal of a place."""
    step = _step(at)
    if not step > 0.0:
        return 0.0, 0.0, 0.0
    sx, sy, sz, tx, ty, tz = perpendicular_axes(at.nx, at.ny, at.nz)
    per = -0.5 * height / step
    s = per * _slope(geometry, textures, texels, number, at, step * sx, step * sy, step * sz)
    t = per * _slope(geometry, textures, texels, number, at, step * tx, step * ty, step * tz)
    return s * sx + t * tx, s * sy + t * ty, s * sz + t * tz


@inline
def _change(geometry: Geometry, mapping: int, at: TexturePlace, x: float, y: float, z: float) -> tuple[float, float]:
    """Return the growth of both texture coordinates from (-x, -y, -z) to (x, y, z) about a place, across a seam too."""
    u, v = coordinates(geometry, mapping, at, at.x + x, at.y + y, at.z + z)
    p, q = coordinates(geometry, mapping, at, at.x - x, at.y - y, at.z - z)
    u, v = u - p, v - q
    if mapping != BOX:
        u -= np.floor(u + 0.5)
    return u, v


@helper
def map_normal(
    geometry: Geometry, textures: Any, texels: Texels, number: int, at: TexturePlace
) -> tuple[float, float, float]:
    """Return the unit normal of a place by a map of normals."""
    step = _step(at)
    sx, sy, sz, tx, ty, tz = perpendicular_axes(at.nx, at.ny, at.nz)
    mapping = textures[number].mapping
    us, vs = _change(geometry, mapping, at, step * sx, step * sy, step * sz)
    ut, vt = _change(geometry, mapping, at, step * tx, step * ty, step * tz)
    size = math.sqrt(us * us + ut * ut)
    if not size > 0.0:
        return at.nx, at.ny, at.nz
    us, ut = us / size, ut / size  # towards growing u; across it is (-ut, us), or the other way
    side = 1.0 if us * vt - ut * vs >= 0.0 else -1.0
    r, g, b = texture_color(geometry, textures, texels, number, at)
    p, q, w = 2.0 * r - 1.0, side * (2.0 * g - 1.0), max(2.0 * b - 1.0, 0.0)
    s, t = p * us - q * ut, p * ut + q * us
    if not (s * s + t * t + w * w > 0.0):
        return at.nx, at.ny, at.nz
    return normalize(s * sx + t * tx + w * at.nx, s * sy + t * ty + w * at.ny, s * sz + t * tz + w * at.nz)


@inline
def turn_to_eye(nx: float, ny: float, nz: float, ex: float, ey: float, ez: float) -> tuple[float, float, float]:
    """Return a unit normal, bent until it faces unit e with a cosine of about 1 / 64 at least."""
    cosine = dot(nx, ny, nz, ex, ey, ez)
    if cosine >= 1.0 / 64.0:
        return nx, ny, nz
    more = 1.0 / 64.0 - cosine
    return normalize(nx + more * ex, ny + more * ey, nz + more * ez)


@inline
def has_relief(row: Any) -> bool:
    """Return whether textures bend the normals of a material."""
    return bool(row.bump >= 0 or row.normal_map >= 0)


@inline
def texture_place(materials: MaterialTable, sight: SurfaceInteraction) -> TexturePlace:
    """Return the place of an interaction for texture functions."""
    reach = materials.pixel[0] + materials.pixel[1] * sight.t
    return TexturePlace(
        sight.body, sight.face, sight.surface, sight.x, sight.y, sight.z, sight.nx, sight.ny, sight.nz, reach
    )


@helper
def bend_normal(
    geometry: Geometry,
    materials: MaterialTable,
    sight: SurfaceInteraction,
    number: int,
    point: ShadingPoint,
    from_inside: bool,
) -> ShadingPoint:
    """Return the point with its shading normal, on the eye's side; number: the row of its material."""
    row, at = materials.rows[number], texture_place(materials, sight)
    nx, ny, nz = sight.nx, sight.ny, sight.nz
    if row.normal_map >= 0:
        nx, ny, nz = map_normal(geometry, materials.textures, materials.texels, row.normal_map, at)
    if row.bump >= 0:
        bx, by, bz = bump_normal(geometry, materials.textures, materials.texels, row.bump, row.bump_height, at)
        nx, ny, nz = normalize(nx + bx, ny + by, nz + bz)
    if from_inside:
        nx, ny, nz = -nx, -ny, -nz
    nx, ny, nz = turn_to_eye(nx, ny, nz, point.ex, point.ey, point.ez)
    return ShadingPoint(point.x, point.y, point.z, nx, ny, nz, point.ex, point.ey, point.ez)


@inline
def mirror_to_side(
    dx: float, dy: float, dz: float, nx: float, ny: float, nz: float, above: bool
) -> tuple[float, float, float]:
    """Return a direction on the wanted side of the plane across unit n, mirrored on the plane if need be."""
    along = dot(dx, dy, dz, nx, ny, nz)
    if (along > 0.0) == above:
        return dx, dy, dz
    return dx - 2.0 * along * nx, dy - 2.0 * along * ny, dz - 2.0 * along * nz


@inline
def is_behind(sight: SurfaceInteraction, dx: float, dy: float, dz: float, lx: float, ly: float, lz: float) -> bool:
    """Return whether l points to the other side of the true surface than d comes from."""
    return dot(sight.nx, sight.ny, sight.nz, dx, dy, dz) * dot(sight.nx, sight.ny, sight.nz, lx, ly, lz) >= 0.0
