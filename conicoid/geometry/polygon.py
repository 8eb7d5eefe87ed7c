"""Is a ray inside a closed loop of points? Watertight along shared edges.

Every vertex is seen along the ray: u = d_z X - d_x Z and v = d_z Y - d_y Z with (X, Y, Z) the vertex
relative to the origin and z the axis the direction is longest along. These depend on the ray
and the vertex alone, and the side of an edge on its two ends alone, so two polygons that share an
edge see one and the same edge: by even-odd a ray through it is inside exactly one of two that
lie on opposite sides of it. (After Woop, Benthin, Wald: Watertight ray/triangle intersection,
JCGT 2, 2013; the even-odd rule is seed 000's.)
"""

from __future__ import annotations

from ..jit import fma, inline
from . import tables as table
from .errorfree import difference_of_products, two_difference
from .tables import Geometry, Ray, real

_DOUBT = 2.0**-44
"""Share of the terms of u, v and of the side of an edge by which rounding may change them."""


@inline
def seen_along(axis: int, px: float, py: float, pz: float, ray: Ray) -> tuple[float, float, bool]:
    """(u, v, unsure) of a vertex: its place across the ray, times the direction's longest component.

    `unsure`: rounding might change the sign of v, or u by more than a small share of it.
    """
    ox, oy, oz, dx, dy, dz, _, _, _ = ray
    x, ex = two_difference(px, ox)
    y, ey = two_difference(py, oy)
    z, ez = two_difference(pz, oz)
    if axis == 0:
        x, ex, dx, y, ey, dy, z, ez, dz = y, ey, dy, z, ez, dz, x, ex, dx
    elif axis == 1:
        x, ex, dx, y, ey, dy, z, ez, dz = z, ez, dz, x, ex, dx, y, ey, dy
    u = difference_of_products(dz, x, dx, z) + fma(dz, ex, -(dx * ez))
    v = difference_of_products(dz, y, dy, z) + fma(dz, ey, -(dy * ez))
    across, along = abs(dz * x) + abs(dx * z), abs(dz * y) + abs(dy * z)
    unsure = (abs(v) <= _DOUBT * along) & (along > 0.0)
    return u, v, unsure | ((abs(u) <= _DOUBT * _DOUBT * across) & (across > 0.0))


@inline
def seen_vertex(geometry: Geometry, vertex: int, axis: int, ray: Ray) -> tuple[float, float, bool]:
    at = 3 * vertex
    x, y, z = (
        real(geometry, table.VERTICES, at),
        real(geometry, table.VERTICES, at + 1),
        real(geometry, table.VERTICES, at + 2),
    )
    return seen_along(axis, x, y, z, ray)


@inline
def inside_loop(geometry: Geometry, first: int, last: int, ray: Ray) -> tuple[bool, bool]:
    """Even-odd: does a half-line from the ray across the view meet an odd number of edges? And: is that doubtful?"""
    dx, dy, dz = abs(ray[3]), abs(ray[4]), abs(ray[5])
    axis = 2 if (dz >= dx) & (dz >= dy) else (0 if dx >= dy else 1)
    odd = False
    ua, va, unsure = seen_vertex(geometry, last - 1, axis, ray)
    for k in range(first, last):
        ub, vb, doubtful = seen_vertex(geometry, k, axis, ray)
        unsure |= doubtful
        if (va < 0.0) != (vb < 0.0):
            side = difference_of_products(ua, vb, ub, va)
            unsure |= abs(side) <= _DOUBT * (abs(ua * vb) + abs(ub * va))
            if (side > 0.0) if vb > va else (side < 0.0):
                odd = not odd
        ua, va = ub, vb
    return odd, unsure
