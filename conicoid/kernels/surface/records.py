"""Surfaces in the scene's tables: their records, their crossings with a ray, and their normals.

Every route evaluates a surface by its number through these functions, so that coincident walls get the same t to the
bit.
"""

from __future__ import annotations

from ..._jit.decorators import helper, inline
from .. import tables as table
from ..numbers.vectors import normalize
from ..ray import Ray, line_of
from ..tables import ANCHOR_SIZE, FORM_SIZE, PLANE, PLANE_SIZE, QUADRIC, SPHERE, SPHERE_SIZE, Geometry, integer, whole
from .plane import PlaneLimits, PlaneRecord, plane_on_ray, unsure_of_plane
from .quadric import (
    QuadricLimits,
    QuadricRecord,
    QuadricRoots,
    SphereRecord,
    quadric_gradient,
    quadric_roots,
    sphere_roots,
)


@inline
def load_plane(geometry: Geometry, row: int) -> PlaneRecord:
    """Return the record of a plane."""
    at = geometry.places[table.PLANES] + PLANE_SIZE * row
    t = geometry.floats
    return PlaneRecord(t[at], t[at + 1], t[at + 2], t[at + 3], t[at + 4], t[at + 5], t[at + 6])


@inline
def load_sphere(geometry: Geometry, row: int) -> SphereRecord:
    """Return the record of a sphere."""
    at = geometry.places[table.SPHERES] + SPHERE_SIZE * row
    t = geometry.floats
    return SphereRecord(t[at], t[at + 1], t[at + 2], t[at + 3])


@inline
def form_row(geometry: Geometry, row: int) -> int:
    """Return the row of a quadric's form, which is also the row of its rounding rest."""
    # A quadric is an anchor and the row of a form, since most quadrics of a scene are one form at many places
    return whole(geometry.floats[geometry.places[table.QUADRICS] + ANCHOR_SIZE * row + 3])


@inline
def load_quadric(geometry: Geometry, row: int) -> QuadricRecord:
    """Return the record of a quadric."""
    at = geometry.places[table.QUADRICS] + ANCHOR_SIZE * row
    t, form = geometry.floats, geometry.places[table.QUADRIC_FORMS] + FORM_SIZE * form_row(geometry, row)
    return QuadricRecord(
        t[at], t[at + 1], t[at + 2], t[form], t[form + 1], t[form + 2], t[form + 3], t[form + 4], t[form + 5],
        t[form + 6], t[form + 7], t[form + 8], t[form + 9], t[form + 10], t[form + 11], t[form + 12], t[form + 13],
        t[form + 14], t[form + 15],
    )  # fmt: skip


@inline
def anchor_of(geometry: Geometry, surface: int) -> tuple[float, float, float]:
    """Return the anchor of a quadric, or the center of a sphere."""
    row = integer(geometry, table.SURFACE_ROW, surface)
    if integer(geometry, table.SURFACE_KIND, surface) == SPHERE:
        sphere = load_sphere(geometry, row)
        return sphere.x, sphere.y, sphere.z
    quadric = load_quadric(geometry, row)
    return quadric.ax, quadric.ay, quadric.az


@inline
def plane_limits(geometry: Geometry, row: int) -> PlaneLimits:
    """Return the limits of a plane."""
    at = geometry.places[table.PLANE_LIMITS] + 2 * row
    return PlaneLimits(geometry.floats[at], geometry.floats[at + 1])


@inline
def quadric_limits(geometry: Geometry, row: int) -> QuadricLimits:
    """Return the limits of a quadric, which belong to its form."""
    at = geometry.places[table.QUADRIC_LIMITS] + 2 * form_row(geometry, row)
    return QuadricLimits(geometry.floats[at], geometry.floats[at + 1])


@inline
def plane_values(geometry: Geometry, surface: int, ray: Ray, inverse: float) -> tuple[float, float, bool]:
    """Return (height, rate, unsure) of a plane on a ray: its value is height + rate t, with height 0 at a start."""
    row = integer(geometry, table.SURFACE_ROW, surface)
    height, rate, parallel = plane_on_ray(load_plane(geometry, row), line_of(ray))
    unsure = unsure_of_plane(height, rate, parallel, inverse, plane_limits(geometry, row))
    # The height at a start is rounding alone: on paper the ray begins on the plane
    return 0.0 if surface == ray.start else height, rate, unsure


@inline
def plane_crossing(geometry: Geometry, surface: int, ray: Ray, inverse: float) -> tuple[float, float, bool]:
    """Return (t, rate, unsure) of a ray's crossing with a plane."""
    height, rate, unsure = plane_values(geometry, surface, ray, inverse)
    return -height / rate, rate, unsure


@helper
def curved_roots(geometry: Geometry, surface: int, ray: Ray, inverse: float) -> QuadricRoots:
    """Return the crossings with a sphere or general quadric; relies on `inverse` = 1 / d·d."""
    row, starts = integer(geometry, table.SURFACE_ROW, surface), surface == ray.start
    if integer(geometry, table.SURFACE_KIND, surface) == SPHERE:
        return sphere_roots(load_sphere(geometry, row), line_of(ray), inverse, starts)
    return quadric_roots(load_quadric(geometry, row), quadric_limits(geometry, row), line_of(ray), inverse, starts)


@inline
def is_curved(geometry: Geometry, surface: int) -> bool:
    """True if a surface is a sphere or a quadric."""
    return (
        integer(geometry, table.SURFACE_KIND, surface) == SPHERE
        or integer(geometry, table.SURFACE_KIND, surface) == QUADRIC
    )


# Normals


@inline
def gradient_at(geometry: Geometry, surface: int, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Return a vector, not normalised, along a surface's normal at a point; at the apex of a cone along its axis."""
    kind, row = integer(geometry, table.SURFACE_KIND, surface), integer(geometry, table.SURFACE_ROW, surface)
    if kind == PLANE:
        plane = load_plane(geometry, row)
        return plane.nx, plane.ny, plane.nz
    if kind == SPHERE:
        cx, cy, cz, _ = load_sphere(geometry, row)
        return x - cx, y - cy, z - cz
    quadric = load_quadric(geometry, row)
    nx, ny, nz = quadric_gradient(quadric, x, y, z)
    # Only at an apex: the third row of W is the axis of a cone there
    if nx == 0.0 and ny == 0.0 and nz == 0.0:
        nx, ny, nz = quadric.w20, quadric.w21, quadric.w22
    return nx, ny, nz


@inline
def normal_at(geometry: Geometry, surface: int, side: int, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Return the unit normal of a surface at a point, times `side`; at the apex of a cone its axis."""
    nx, ny, nz = gradient_at(geometry, surface, x, y, z)
    nx, ny, nz = normalize(nx, ny, nz)
    return side * nx, side * ny, side * nz
