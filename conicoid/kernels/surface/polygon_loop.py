"""Test of a ray against a closed loop of points, watertight along shared edges; in floats, and with certainty.

Every vertex is projected along the ray: u = d_z X - d_x Z and v = d_z Y - d_y Z, with (X, Y, Z) the vertex relative to
the origin and z the axis along which the direction is longest. These depend on the ray and the vertex alone, and the
side of an edge on its two ends alone, so two polygons that share an edge get the same side of it: by the even-odd rule
a ray through the edge is inside exactly one of two polygons that lie on opposite sides of it. (After Woop, Benthin,
Wald: Watertight ray/triangle intersection, JCGT 2, 2013; the even-odd rule is that of the ray tracing notes.)
"""

from __future__ import annotations

from ..._jit.decorators import fma, helper, inline
from .. import tables as table
from ..numbers.double_double import (
    BoundedPair,
    difference_of_products,
    minus,
    moment,
    plus,
    remainder,
    sign,
    times_float,
    two_difference,
)
from ..ray import Ray
from ..tables import Geometry, integer, real
from .doubt import LOOP
from .exact_crossing import RoundingRest


@inline
def project_vertex(axis: int, px: float, py: float, pz: float, ray: Ray) -> tuple[float, float, float, float]:
    """Return (u, v, size of u's terms, size of v's terms) of a vertex.

    (u, v) is the vertex's position across the ray times the direction's longest component.
    """
    ox, oy, oz, dx, dy, dz, _, _, _ = ray
    x, ex = two_difference(px, ox)
    y, ey = two_difference(py, oy)
    z, ez = two_difference(pz, oz)
    # A cyclic exchange of axes keeps the sense in which a loop runs
    if axis == 0:
        x, ex, dx, px, y, ey, dy, py, z, ez, dz, pz = y, ey, dy, py, z, ez, dz, pz, x, ex, dx, px
    elif axis == 1:
        x, ex, dx, px, y, ey, dy, py, z, ez, dz, pz = z, ez, dz, pz, x, ex, dx, px, y, ey, dy, py
    # Products with one rounding: u of a vertex on the ray is nearly 0, and its sign decides
    u = difference_of_products(dz, x, dx, z) + fma(dz, ex, -(dx * ez))
    v = difference_of_products(dz, y, dy, z) + fma(dz, ey, -(dy * ez))
    depth = abs(z) + abs(pz)
    # |p| beside |p - o|, since the vertex itself was rounded: by a share of |p|
    return u, v, abs(dz) * (abs(x) + abs(px)) + abs(dx) * depth, abs(dz) * (abs(y) + abs(py)) + abs(dy) * depth


@inline
def project_row_vertex(geometry: Geometry, vertex: int, axis: int, ray: Ray) -> tuple[float, float, float, float]:
    """`project_vertex` for a vertex of the table."""
    at = 3 * vertex
    x, y, z = (
        real(geometry, table.VERTICES, at),
        real(geometry, table.VERTICES, at + 1),
        real(geometry, table.VERTICES, at + 2),
    )
    return project_vertex(axis, x, y, z, ray)


@inline
def inside_loop(geometry: Geometry, first: int, last: int, ray: Ray) -> tuple[bool, bool]:
    """Return (inside by the even-odd rule, doubtful).

    Inside means that a half-line from the ray across the projection meets an odd number of edges. Shared edges are
    watertight because (u, v) of a vertex and the side of an edge do not depend on the polygon.
    """
    dx, dy, dz = abs(ray.dx), abs(ray.dy), abs(ray.dz)
    # Along the longest component of the direction, (u, v) is stretched least; ties may go to any axis, always the same
    axis = 2 if (dz >= dx) & (dz >= dy) else (0 if dx >= dy else 1)
    odd, unsure = False, False
    # The loop is closed by its last corner, which comes before the first
    ua, va, su, sv = project_row_vertex(geometry, last - 1, axis, ray)
    for k in range(first, last):
        ub, vb, tu, tv = project_row_vertex(geometry, k, axis, ray)
        # tv = 0 is an exact zero, which the rule below decides, but for a ray through the corner or an edge with v = 0
        unsure |= (abs(vb) <= LOOP * tv) & (tv > 0.0)
        unsure |= (vb == 0.0) & ((abs(ub) <= LOOP * tu) | ((va == 0.0) & ((ua < 0.0) != (ub < 0.0))))
        # v = 0 counts as positive for every polygon, so a vertex on the half-line counts once
        if (va < 0.0) != (vb < 0.0):
            # u where the edge crosses v = 0, times vb - va: its sign needs no division
            side = difference_of_products(ua, vb, ub, va)
            unsure |= abs(side) <= LOOP * ((su * abs(vb) + tu * abs(va)) + (abs(ua) * tv + abs(ub) * sv))
            if (side > 0.0) if vb > va else (side < 0.0):
                odd = not odd
        ua, va, su, sv = ub, vb, tu, tv
    return odd, unsure


# The same rule with certainty, in pairs of floats with error bounds

OPEN = 2
EDGE = 4
"""Added by `decide_loop` where the ray passes through an edge."""


@inline
def _corner_offset(geometry: Geometry, rest: RoundingRest, at: int, origin: float) -> BoundedPair:
    """Return a coordinate of a corner relative to the ray's origin, with its rounding rest."""
    high, low = two_difference(real(geometry, table.VERTICES, at), origin)
    offset = BoundedPair(high, low, 0.0)
    return offset if rest.vertices[at] == 0.0 else plus(offset, remainder(rest.vertices[at]))


@inline
def _project_exactly(
    geometry: Geometry, rest: RoundingRest, vertex: int, axis: int, ray: Ray
) -> tuple[BoundedPair, BoundedPair]:
    """Return (u, v) of a vertex, by the formulas of `project_vertex`."""
    first, second = (1, 2) if axis == 0 else ((2, 0) if axis == 1 else (0, 1))
    at, origin, direction = 3 * vertex, (ray.ox, ray.oy, ray.oz), (ray.dx, ray.dy, ray.dz)
    # The same exchange of axes as in `project_vertex`, so that both agree on signs
    x, y = (
        _corner_offset(geometry, rest, at + first, origin[first]),
        _corner_offset(geometry, rest, at + second, origin[second]),
    )
    along, depth = direction[axis], _corner_offset(geometry, rest, at + axis, origin[axis])
    u = minus(times_float(x, along), times_float(depth, direction[first]))
    v = minus(times_float(y, along), times_float(depth, direction[second]))
    return u, v


@helper
def decide_loop(geometry: Geometry, rest: RoundingRest, polygon: int, ray: Ray) -> int:
    """Return 1 if the ray is inside a polygon, 0 if outside, plus EDGE on an edge; OPEN if that is not certain."""
    first, last = (
        integer(geometry, table.POLYGON_FIRST, polygon),
        integer(geometry, table.POLYGON_FIRST, polygon + 1),
    )
    dx, dy, dz = abs(ray.dx), abs(ray.dy), abs(ray.dz)
    # Along the longest component of the direction, (u, v) is stretched least
    axis = 2 if (dz >= dx) & (dz >= dy) else (0 if dx >= dy else 1)
    odd, edge = 0, 0
    ua, va = _project_exactly(geometry, rest, last - 1, axis, ray)
    for vertex in range(first, last):
        ub, vb = _project_exactly(geometry, rest, vertex, axis, ray)
        before, after = sign(va), sign(vb)
        if before == OPEN or after == OPEN:
            return OPEN
        # 0 counts as positive, as in `inside_loop`
        if (before < 0) != (after < 0):
            side = sign(moment(ua, vb, ub, va))
            if side == OPEN:
                return OPEN
            rises = after > before
            edge = EDGE if side == 0 else edge
            odd ^= 1 if (side > 0 if rises else side < 0) else 0
        elif after == 0:
            # Through the corner, or an edge with v = 0: the rule above does not see edges of one side
            left, right = sign(ua), sign(ub)
            if left == OPEN or right == OPEN:
                return OPEN
            edge = EDGE if right == 0 or (before == 0 and left != right) else edge
        ua, va = ub, vb
    return odd + edge
