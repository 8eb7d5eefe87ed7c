"""Bounds of the volume fraction of a ball or cell in a voxel, from the chord of a ray through the voxel's middle.

In a voxel a surface is q(u) = q0 + q1 u + q2 u² on the ray, u from -1 to 1, and beside the ray it differs from q by at
most `off`. So the share of {f <= 0} in the voxel is at least the chord of {q <= -off} and at most the chord of
{q <= off}. The two bounds agree where a wall is parallel to the ray all around, or does not cut the voxel.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..._jit.decorators import helper, inline
from .. import tables as table
from ..faces import cell_side, plane_side
from ..surface.doubt import POINT_AT_BALL
from ..surface.exact_crossing import RoundingRest, rest_number, rest_of_quadric
from ..surface.quadric import own_coordinates, quadric_rounding, quadric_value
from ..surface.records import load_plane, load_quadric, load_sphere, plane_limits
from ..tables import PLANE, SPHERE, Geometry, integer
from .membership import plane_value

_LOOSE = 4.0
"""Factor from the rounding at the middle of a voxel to a bound for the whole voxel."""


class VoxelSurface(NamedTuple):
    """A surface on a ray through a voxel, <= 0 inside: q0 + q1 u + q2 u², and `off`, its largest change beside it."""

    q0: float
    q1: float
    q2: float
    off: float


class VoxelShares(NamedTuple):
    """Share of a voxel in [0, 1]: lower bound, along the ray, upper bound."""

    least: float
    chord: float
    most: float


class VoxelPrism(NamedTuple):
    """A voxel of a narrow column: its middle and half its sides along the world's axes, and the axis of the ray."""

    x: float
    y: float
    z: float
    hx: float
    hy: float
    hz: float
    axis: int


@inline
def _component(axis: int, x: float, y: float, z: float) -> float:
    """Return the component of (x, y, z) along an axis."""
    return x if axis == 0 else (y if axis == 1 else z)


@inline
def _flat(prism: VoxelPrism, gx: float, gy: float, gz: float) -> tuple[float, float]:
    """Return (change along the ray over half a voxel, largest change across) of a linear function with gradient g."""
    ax, ay, az = gx * prism.hx, gy * prism.hy, gz * prism.hz
    along = _component(prism.axis, ax, ay, az)
    return along, abs(ax) + abs(ay) + abs(az) - abs(along)


@inline
def _plane_along(geometry: Geometry, row: int, prism: VoxelPrism) -> VoxelSurface:
    plane, limits = load_plane(geometry, row), plane_limits(geometry, row)
    value, rounding = plane_value(plane, limits, prism.x, prism.y, prism.z)
    along, across = _flat(prism, plane.nx, plane.ny, plane.nz)
    return VoxelSurface(value, along, 0.0, across + _LOOSE * rounding)


@inline
def _bent(
    prism: VoxelPrism, w0: float, w1: float, w2: float, s: float, y: float, b: float
) -> tuple[float, float, float]:
    """Return (q1, q2, off) of s y² + 2 b y, where y changes by `along` u, and by at most `across` beside the ray."""
    along, across = _flat(prism, w0, w1, w2)
    slope = s * y + b
    # A displacement δ across the ray, |δ| <= across, changes the value at u by 2 (s (y + along u) + b) δ + s δ², with
    # |u| <= 1
    off = (2.0 * (abs(slope) + abs(s * along)) + abs(s) * across) * across
    return 2.0 * slope * along, s * along * along, off


@helper
def _quadric_along(geometry: Geometry, rest: RoundingRest, row: int, prism: VoxelPrism) -> VoxelSurface:
    """Return a quadric on the ray through a voxel; `off` is the sum of three bounds, one a coordinate: a bit large."""
    quadric, at = load_quadric(geometry, row), rest_of_quadric(geometry, row)
    _, _, _, w00, w01, w02, w10, w11, w12, w20, w21, w22, s0, s1, s2, b0, b1, b2, _ = quadric
    y0, y1, y2 = own_coordinates(quadric, prism.x, prism.y, prism.z)
    p1, p2, p = _bent(prism, w00, w01, w02, s0, y0, b0)
    r1, r2, r = _bent(prism, w10, w11, w12, s1, y1, b1)
    t1, t2, t = _bent(prism, w20, w21, w22, s2, y2, b2)
    rounding = quadric_rounding(
        quadric, prism.x, prism.y, prism.z, rest_number(rest, at), rest_number(rest, at + 1), rest_number(rest, at + 2)
    )
    return VoxelSurface(
        quadric_value(quadric, prism.x, prism.y, prism.z), p1 + r1 + t1, p2 + r2 + t2, p + r + t + _LOOSE * rounding
    )


@inline
def _sphere_along(geometry: Geometry, row: int, prism: VoxelPrism) -> VoxelSurface:
    cx, cy, cz, radius = load_sphere(geometry, row)
    px, py, pz = prism.x - cx, prism.y - cy, prism.z - cz
    square = px * px + py * py + pz * pz
    p1, p2, p = _bent(prism, 1.0, 0.0, 0.0, 1.0, px, 0.0)
    r1, r2, r = _bent(prism, 0.0, 1.0, 0.0, 1.0, py, 0.0)
    t1, t2, t = _bent(prism, 0.0, 0.0, 1.0, 1.0, pz, 0.0)
    # As for points in a ball: a sphere's record has no rest of its own
    rounding = POINT_AT_BALL * (square + radius * radius)
    return VoxelSurface(square - radius * radius, p1 + r1 + t1, p2 + r2 + t2, p + r + t + rounding)


@helper
def _along(geometry: Geometry, rest: RoundingRest, surface: int, side: int, prism: VoxelPrism) -> VoxelSurface:
    """Return a surface on the ray through a voxel, <= 0 on the side `side`."""
    row, kind = integer(geometry, table.SURFACE_ROW, surface), integer(geometry, table.SURFACE_KIND, surface)
    if kind == PLANE:
        found = _plane_along(geometry, row, prism)
    elif kind == SPHERE:
        found = _sphere_along(geometry, row, prism)
    else:
        found = _quadric_along(geometry, rest, row, prism)
    inner = 1.0 if side > 0 else -1.0
    return VoxelSurface(found.q0 * inner, found.q1 * inner, found.q2 * inner, found.off)


@inline
def overlap_length(low: float, high: float, begin: float, end: float) -> float:
    """Return the length of the part of [low, high] in [begin, end]."""
    return max(0.0, min(high, end) - max(low, begin))


@helper
def _measure(at: VoxelSurface, level: float, low: float, high: float) -> float:
    """Return the length of the part of [low, high] where q <= level."""
    size, a, b, c = max(0.0, high - low), at.q2, 0.5 * at.q1, at.q0 - level
    if a == 0.0:
        if b == 0.0:
            return size if c <= 0.0 else 0.0
        root = -0.5 * c / b
        return overlap_length(low, high, -math.inf, root) if b > 0.0 else overlap_length(low, high, root, math.inf)
    square = b * b - a * c
    # Without roots q has the sign of its leading coefficient everywhere
    if square <= 0.0:
        return size if a < 0.0 else 0.0
    # Each root by the formula that does not cancel, as `roots_of`
    q = -(b + math.copysign(math.sqrt(square), b))
    first, second = q / a, c / q
    between = overlap_length(low, high, min(first, second), max(first, second))
    return between if a > 0.0 else size - between


@inline
def _cut(at: VoxelSurface, level: float, low: float, high: float) -> tuple[float, float]:
    """Return the part of [low, high] where q of a plane is <= level."""
    if at.q1 == 0.0:
        return (low, high) if at.q0 <= level else (low, low)
    root = (level - at.q0) / at.q1
    return (low, min(high, root)) if at.q1 > 0.0 else (max(low, root), high)


@helper
def ball_shares(geometry: Geometry, rest: RoundingRest, surface: int, prism: VoxelPrism) -> VoxelShares:
    """Return the shares of a ball in a voxel."""
    # Where q <= -off on the ray, the whole cross-section of the voxel is inside; where q > off, none of it. Half of a
    # length in u is a share, because u goes from -1 to 1
    at = _along(geometry, rest, surface, 1, prism)
    return VoxelShares(
        0.5 * _measure(at, -at.off, -1.0, 1.0),
        0.5 * _measure(at, 0.0, -1.0, 1.0),
        0.5 * _measure(at, at.off, -1.0, 1.0),
    )


@inline
def _divide_shares(found: VoxelShares, inside: bool, share: float) -> VoxelShares:
    """Correct shares for planes along the ray that divide the voxel.

    `inside` is True if the ray is inside all of these planes; at most `share` of the voxel lies on their other side.
    """
    if not inside:
        return VoxelShares(0.0, 0.0, found.most * min(1.0, share))
    return VoxelShares(max(0.0, found.least - found.most * share), found.chord, found.most)


@helper
def cell_shares(geometry: Geometry, rest: RoundingRest, cell: int, prism: VoxelPrism) -> VoxelShares:
    """Return the shares of a cell in a voxel.

    A plane along the ray that divides the voxel leaves at most (1 - |q0| / off) / 2 of it on the other side: values
    over a rectangle are symmetric about q0, and the nearer to q0 the more frequent.
    """
    # Spans of u for the levels -off, 0 and off
    low0, high0, low1, high1, low2, high2 = -1.0, 1.0, -1.0, 1.0, -1.0, 1.0
    inside, share = True, 0.0
    first, last = integer(geometry, table.CELL_FIRST, cell), integer(geometry, table.CELL_FIRST, cell + 1)
    for slot in range(first, last):
        surface, side = integer(geometry, table.PLANE_SURFACE, slot), plane_side(geometry, slot)
        at = _along(geometry, rest, surface, side, prism)
        # Parallel to the ray: no end of a span, but a part of the cross-section all along
        if at.q1 == 0.0 and abs(at.q0) <= at.off:
            inside = inside and at.q0 <= 0.0
            share += 0.5 * (1.0 - abs(at.q0) / at.off) if at.off > 0.0 else 0.0
            continue
        low0, high0 = _cut(at, -at.off, low0, high0)
        low1, high1 = _cut(at, 0.0, low1, high1)
        low2, high2 = _cut(at, at.off, low2, high2)
        # Even the loosest level leaves nothing: no point of the voxel is in the cell
        if low2 >= high2:
            return VoxelShares(0.0, 0.0, 0.0)
    quadric = integer(geometry, table.CELL_QUADRIC, cell)
    if quadric < 0:
        found = VoxelShares(0.5 * max(0.0, high0 - low0), 0.5 * max(0.0, high1 - low1), 0.5 * (high2 - low2))
        return _divide_shares(found, inside, share)
    at = _along(geometry, rest, quadric, cell_side(geometry, cell), prism)
    found = VoxelShares(
        0.5 * _measure(at, -at.off, low0, high0),
        0.5 * _measure(at, 0.0, low1, high1),
        0.5 * _measure(at, at.off, low2, high2),
    )
    return _divide_shares(found, inside, share)
