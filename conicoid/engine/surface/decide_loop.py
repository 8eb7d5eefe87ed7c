"""Is a ray inside a closed loop of points, with certainty?  (The rule of engine/surface/loop.py)"""

from __future__ import annotations

from ...compiler.jit import helper, inline
from .. import tables as table
from ..numbers.errorfree import two_difference
from ..numbers.sure import Sure, minus, moment, plus, remainder, scaled, sign
from ..ray import Ray
from ..tables import Geometry, integer, real
from .decide import Rest

OPEN = 2


@inline
def _from(geometry: Geometry, rest: Rest, at: int, origin: float) -> Sure:
    """A coordinate of a corner, from the ray's origin."""
    high, low = two_difference(real(geometry, table.VERTICES, at), origin)
    given = Sure(high, low, 0.0)
    return given if rest.vertices[at] == 0.0 else plus(given, remainder(rest.vertices[at]))


@inline
def _seen(geometry: Geometry, rest: Rest, vertex: int, axis: int, ray: Ray) -> tuple[Sure, Sure]:
    """(u, v) of a vertex, as in `loop.seen_along`."""
    first, second = (1, 2) if axis == 0 else ((2, 0) if axis == 1 else (0, 1))
    at, origin, direction = 3 * vertex, (ray.ox, ray.oy, ray.oz), (ray.dx, ray.dy, ray.dz)
    x, y = _from(geometry, rest, at + first, origin[first]), _from(geometry, rest, at + second, origin[second])
    along, depth = direction[axis], _from(geometry, rest, at + axis, origin[axis])
    u = minus(scaled(x, along), scaled(depth, direction[first]))
    v = minus(scaled(y, along), scaled(depth, direction[second]))
    return u, v


@helper
def decide_loop(geometry: Geometry, rest: Rest, polygon: int, ray: Ray) -> int:
    """1 inside, 0 outside, OPEN where that is not certain."""
    first, last = (
        integer(geometry, table.POLYGON_FIRST, polygon),
        integer(geometry, table.POLYGON_FIRST, polygon + 1),
    )
    dx, dy, dz = abs(ray.dx), abs(ray.dy), abs(ray.dz)
    axis = 2 if (dz >= dx) & (dz >= dy) else (0 if dx >= dy else 1)
    odd = 0
    ua, va = _seen(geometry, rest, last - 1, axis, ray)
    for vertex in range(first, last):
        ub, vb = _seen(geometry, rest, vertex, axis, ray)
        before, after = sign(va), sign(vb)
        if before == OPEN or after == OPEN:
            return OPEN
        if (before < 0) != (after < 0):
            side = sign(moment(ua, vb, ub, va))
            if side == OPEN:
                return OPEN
            rises = after > before
            odd ^= 1 if (side > 0 if rises else side < 0) else 0
        ua, va = ub, vb
    return odd
