"""Is a ray inside a closed loop of points? Watertight along shared edges.

Every vertex is seen along the ray: u = d_z X - d_x Z and v = d_z Y - d_y Z with (X, Y, Z) the vertex
relative to the origin and z the axis the direction is longest along. These depend on the ray
and the vertex alone, and the side of an edge on its two ends alone, so two polygons that share an
edge see one and the same edge: by even-odd a ray through it is inside exactly one of two that
lie on opposite sides of it. (After Woop, Benthin, Wald: Watertight ray/triangle intersection,
JCGT 2, 2013; the even-odd rule is that of the ray tracing notes.)
"""

from __future__ import annotations

from ...compiler.jit import fma, inline
from .. import tables as table
from ..numbers.errorfree import difference_of_products, two_difference
from ..ray import Ray
from ..tables import Geometry, real
from .doubt import LOOP


@inline
def seen_along(axis: int, px: float, py: float, pz: float, ray: Ray) -> tuple[float, float, float, float]:
    """(u, v) of a vertex, its place across the ray times the direction's longest component; and their terms' size."""
    ox, oy, oz, dx, dy, dz, _, _, _ = ray
    x, ex = two_difference(px, ox)
    y, ey = two_difference(py, oy)
    z, ez = two_difference(pz, oz)
    if axis == 0:
        x, ex, dx, px, y, ey, dy, py, z, ez, dz, pz = y, ey, dy, py, z, ez, dz, pz, x, ex, dx, px
    elif axis == 1:
        x, ex, dx, px, y, ey, dy, py, z, ez, dz, pz = z, ez, dz, pz, x, ex, dx, px, y, ey, dy, py
    u = difference_of_products(dz, x, dx, z) + fma(dz, ex, -(dx * ez))
    v = difference_of_products(dz, y, dy, z) + fma(dz, ey, -(dy * ez))
    depth = abs(z) + abs(pz)
    return u, v, abs(dz) * (abs(x) + abs(px)) + abs(dx) * depth, abs(dz) * (abs(y) + abs(py)) + abs(dy) * depth


@inline
def seen_vertex(geometry: Geometry, vertex: int, axis: int, ray: Ray) -> tuple[float, float, float, float]:
    """`seen_along` for a vertex of the table."""
    at = 3 * vertex
    x, y, z = (
        real(geometry, table.VERTICES, at),
        real(geometry, table.VERTICES, at + 1),
        real(geometry, table.VERTICES, at + 2),
    )
    return seen_along(axis, x, y, z, ray)


@inline
def inside_loop(geometry: Geometry, first: int, last: int, ray: Ray) -> tuple[bool, bool]:
    """(inside by even-odd, doubtful): does a half-line from the ray across the view meet an odd number of edges?

    Relies on u, v of a vertex and the side of an edge not depending on the polygon: that makes shared edges watertight.
    """
    dx, dy, dz = abs(ray.dx), abs(ray.dy), abs(ray.dz)
    axis = 2 if (dz >= dx) & (dz >= dy) else (0 if dx >= dy else 1)
    odd, unsure = False, False
    ua, va, su, sv = seen_vertex(geometry, last - 1, axis, ray)
    for k in range(first, last):
        ub, vb, tu, tv = seen_vertex(geometry, k, axis, ray)
        unsure |= (abs(vb) <= LOOP * tv) & (tv > 0.0)
        if (va < 0.0) != (vb < 0.0):
            side = difference_of_products(ua, vb, ub, va)
            unsure |= abs(side) <= LOOP * ((su * abs(vb) + tu * abs(va)) + (abs(ua) * tv + abs(ub) * sv))
            if (side > 0.0) if vb > va else (side < 0.0):
                odd = not odd
        ua, va, su, sv = ub, vb, tu, tv
    return odd, unsure
