"""The record of a surface in the scene's tables, and where a ray crosses it."""

from __future__ import annotations

from ...compiler.jit import helper, inline
from .. import tables as table
from ..ray import Ray
from ..tables import QUADRIC, SPHERE, Geometry, integer
from .plane import Limits, Plane, plane_on_ray, unsure_of_plane
from .quadric import Quadric, Roots, Sphere, quadric_roots, sphere_roots


@inline
def load_plane(geometry: Geometry, row: int) -> Plane:
    at = geometry.places[table.PLANES] + 7 * row
    t = geometry.floats
    return t[at], t[at + 1], t[at + 2], t[at + 3], t[at + 4], t[at + 5], t[at + 6]


@inline
def load_sphere(geometry: Geometry, row: int) -> Sphere:
    at = geometry.places[table.SPHERES] + 4 * row
    t = geometry.floats
    return t[at], t[at + 1], t[at + 2], t[at + 3]


@inline
def load_quadric(geometry: Geometry, row: int) -> Quadric:
    at = geometry.places[table.QUADRICS] + 19 * row
    t = geometry.floats
    return (
        t[at], t[at + 1], t[at + 2], t[at + 3], t[at + 4], t[at + 5], t[at + 6], t[at + 7], t[at + 8], t[at + 9],
        t[at + 10], t[at + 11], t[at + 12], t[at + 13], t[at + 14], t[at + 15], t[at + 16], t[at + 17], t[at + 18],
    )  # fmt: skip


@inline
def anchor_of(geometry: Geometry, surface: int) -> tuple[float, float, float]:
    """The anchor of a quadric, the center of a sphere."""
    row = integer(geometry, table.SURFACE_ROW, surface)
    if integer(geometry, table.SURFACE_KIND, surface) == SPHERE:
        x, y, z, _ = load_sphere(geometry, row)
        return x, y, z
    quadric = load_quadric(geometry, row)
    return quadric[0], quadric[1], quadric[2]


@inline
def load_limits(geometry: Geometry, of: int, row: int) -> Limits:
    """The limits of a plane or quadric: row `row` of table `of`."""
    at = geometry.places[of] + 2 * row
    return geometry.floats[at], geometry.floats[at + 1]


@inline
def plane_crossing(geometry: Geometry, surface: int, ray: Ray, inverse: float) -> tuple[float, float, float, bool]:
    """(t, height, rate, unsure): where the ray crosses a plane; t = 0 on the plane it starts on."""
    ox, oy, oz, dx, dy, dz, _, _, start = ray
    row = integer(geometry, table.SURFACE_ROW, surface)
    height, rate, parallel = plane_on_ray(load_plane(geometry, row), ox, oy, oz, dx, dy, dz)
    unsure = unsure_of_plane(height, rate, parallel, inverse, load_limits(geometry, table.PLANE_LIMITS, row))
    height = 0.0 if surface == start else height
    return -height / rate, height, rate, unsure


@helper
def curved_roots(geometry: Geometry, surface: int, ray: Ray, inverse: float) -> Roots:
    """Crossings with a sphere or general quadric."""
    ox, oy, oz, dx, dy, dz, _, _, start = ray
    row = integer(geometry, table.SURFACE_ROW, surface)
    if integer(geometry, table.SURFACE_KIND, surface) == SPHERE:
        return sphere_roots(load_sphere(geometry, row), ox, oy, oz, dx, dy, dz, inverse, surface == start)
    limits = load_limits(geometry, table.QUADRIC_LIMITS, row)
    return quadric_roots(load_quadric(geometry, row), limits, ox, oy, oz, dx, dy, dz, inverse, surface == start)


@inline
def is_curved(geometry: Geometry, surface: int) -> bool:
    return (
        integer(geometry, table.SURFACE_KIND, surface) == SPHERE
        or integer(geometry, table.SURFACE_KIND, surface) == QUADRIC
    )
