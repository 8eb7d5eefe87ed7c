"""Edges and corners of a body, tried as nearest walls, and the planes that contain the curve of two quadrics.

Every f - m h of two quadrics f and h vanishes where both do. If one of these is a pair of planes, the curve is two
conics: for two spheres, quadrics of revolution about one axis, parallel cylinders, equal cylinders that cross. Such an
m makes the two forms equal along an axis that both share, so m = (e·A e) / (e·B e) is tried for the principal axes e of
both, and for e across the axes of revolution of both, whose other principal axes are arbitrary. (Levin: A parametric
algorithm for drawing pictures of solid objects composed of quadric surfaces, CACM 19, 1976.) Curves in no plane are
called hard: `try_hard_edges` searches them.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..._jit.decorators import helper, inline
from .. import tables as table
from ..numbers.vectors import dot
from ..programs import leaf_bounds, leaf_high, leaf_low
from ..surface.records import anchor_of, load_quadric
from ..tables import QUADRIC, Geometry, integer, poll_halt, whole
from .form import ROUNDED, Directions, SurfaceForm, bend_between, bend_times, form_at, length_of, principal_axes
from .neighbourhood import (
    BOX,
    LEAF,
    LEAVES,
    LOWER,
    MOST_BOXES,
    MOST_PAIRED,
    PROGRAM,
    SHEET_OF,
    SURFACES,
    UPPER,
    Neighbourhood,
    WallQuery,
    is_flat,
    limit,
)
from .point_sides import sheet_around, sides_around
from .projection import TANGENT, project_point
from .stationary import rounding_share, try_conic
from .walls import CERTAIN_WALL, WallCandidate, candidate, try_point

_ZERO_SHARE = 2.0**-44
"""Size, as a share of its terms, below which a coefficient counts as zero."""
HARD = -1
"""As `PencilPlanes.number`: no plane contains the curve."""


class PencilPlanes(NamedTuple):
    """Up to two planes n·p = h about a point (`origin_of`); their number is HARD if the curve is in no plane."""

    number: int
    x0: float
    y0: float
    z0: float
    h0: float
    x1: float
    y1: float
    z1: float
    h1: float


@inline
def _no_planes(count: int) -> PencilPlanes:
    return PencilPlanes(count, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@inline
def _difference(f: SurfaceForm, h: SurfaceForm, m: float) -> SurfaceForm:
    """Return f - m h; its `off`, `size` and `steep` are the sizes below which values count as zero."""
    return SurfaceForm(
        f.value - m * h.value, 16.0 * (f.off + abs(m) * h.off), f.gx - m * h.gx, f.gy - m * h.gy, f.gz - m * h.gz,
        f.xx - m * h.xx, f.yy - m * h.yy, f.zz - m * h.zz, f.xy - m * h.xy, f.xz - m * h.xz, f.yz - m * h.yz,
        _ZERO_SHARE * (f.size + abs(m) * h.size), _ZERO_SHARE * (f.steep + abs(m) * h.steep),
    )  # fmt: skip


@helper
def _planes_of(f: SurfaceForm) -> PencilPlanes:
    """Return the planes whose product a form is; HARD if it is no such product."""
    a0, a1, a2, (x0, y0, z0, x1, y1, z1, x2, y2, z2) = principal_axes(f.xx, f.yy, f.zz, f.xy, f.xz, f.yz)
    if abs(a0) < abs(a2):  # the largest becomes the first
        a0, a2, x0, y0, z0, x2, y2, z2 = a2, a0, x2, y2, z2, x0, y0, z0
    if abs(a1) < abs(a2):  # and the least the last
        a1, a2, x1, y1, z1, x2, y2, z2 = a2, a1, x2, y2, z2, x1, y1, z1
    g0, g1, g2 = dot(x0, y0, z0, f.gx, f.gy, f.gz), dot(x1, y1, z1, f.gx, f.gy, f.gz), dot(x2, y2, z2, f.gx, f.gy, f.gz)
    if abs(a0) <= f.size:  # no quadratic part: one plane, or no point, or every point
        g = length_of(f.gx, f.gy, f.gz)
        if g <= f.steep:
            return _no_planes(HARD if abs(f.value) <= f.off else 0)
        return PencilPlanes(1, f.gx / g, f.gy / g, f.gz / g, -0.5 * f.value / g, 0.0, 0.0, 0.0, 0.0)
    if abs(a2) > f.size or abs(g2) > f.steep:
        return _no_planes(HARD)
    t0 = -g0 / a0
    if abs(a1) <= f.size:  # one square: two parallel planes
        if abs(g1) > f.steep:
            return _no_planes(HARD)
        # a0 u² + 2 g0 u + value = 0, by the formula for its two roots
        square = (g0 * g0 - a0 * f.value) / (a0 * a0)
        if square < -f.off / abs(a0):
            return _no_planes(0)
        # A square within rounding of 0: one double plane, which both roots give
        root = math.sqrt(max(square, 0.0))
        return PencilPlanes(2, x0, y0, z0, t0 + root, x0, y0, z0, t0 - root)
    t1 = -g1 / a1
    # Two squares: two planes that cross, if their signs differ and f vanishes at the center
    if abs(f.value + g0 * t0 + g1 * t1) > f.off + 4.0 * f.steep * (abs(t0) + abs(t1)) or a0 * a1 > 0.0:
        return _no_planes(HARD)
    u, v = math.sqrt(abs(a0)), math.sqrt(abs(a1))
    # a0 u² - a1 v² = (√a0 u + √a1 v) (√a0 u - √a1 v), then unit normals
    both = math.sqrt(u * u + v * v)
    u, v = u / both, v / both
    return PencilPlanes(
        2, u * x0 + v * x1, u * y0 + v * y1, u * z0 + v * z1, u * t0 + v * t1,
        u * x0 - v * x1, u * y0 - v * y1, u * z0 - v * z1, u * t0 - v * t1,
    )  # fmt: skip


@inline
def _ratio(f: SurfaceForm, h: SurfaceForm, x: float, y: float, z: float) -> float:
    """Return the m for which f and m h are equal along a unit vector; 0 if no m or every m is."""
    ax, ay, az = bend_times(f, x, y, z)
    bx, by, bz = bend_times(h, x, y, z)
    over, under = dot(ax, ay, az, x, y, z), dot(bx, by, bz, x, y, z)
    # A ratio of numbers near rounding would give an arbitrary m
    return over / under if (abs(under) > 2.0**-30 * h.size) & (abs(over) > 2.0**-30 * f.size) else 0.0


@helper
def shared_planes(geometry: Geometry, one: int, other: int) -> PencilPlanes:
    """Return the planes of the curve of two curved surfaces, about the anchor of the first."""
    cx, cy, cz = anchor_of(geometry, one)  # terms are small there, so that zeros are recognised
    f, h = form_at(geometry, one, cx, cy, cz), form_at(geometry, other, cx, cy, cz)
    p = principal_axes(f.xx, f.yy, f.zz, f.xy, f.xz, f.yz).along
    q = principal_axes(h.xx, h.yy, h.zz, h.xy, h.xz, h.yz).along
    # First f alone, which may be a pair of planes itself
    found = _planes_of(_difference(f, h, 0.0))
    for k in range(11):
        if found.number != HARD:
            break
        axes, m = (p if k < 3 else q), 0.0
        if k == 10:
            found = _planes_of(_difference(h, f, 0.0))
        elif k > 5:
            m = _ratio_across(f, h, p, q, k - 6)
        elif k % 3 == 0:
            m = _ratio(f, h, axes.x0, axes.y0, axes.z0)
        elif k % 3 == 1:
            m = _ratio(f, h, axes.x1, axes.y1, axes.z1)
        else:
            m = _ratio(f, h, axes.x2, axes.y2, axes.z2)
        if m != 0.0:
            found = _planes_of(_difference(f, h, m))
    return found


@inline
def _ratio_across(f: SurfaceForm, h: SurfaceForm, p: Directions, q: Directions, which: int) -> float:
    """Return `_ratio` across an outermost axis of each form, which is that of revolution of a form that has one."""
    ax, ay, az = (p.x0, p.y0, p.z0) if which & 1 == 0 else (p.x2, p.y2, p.z2)
    bx, by, bz = (q.x0, q.y0, q.z0) if which & 2 == 0 else (q.x2, q.y2, q.z2)
    nx, ny, nz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    sine = length_of(nx, ny, nz)
    return _ratio(f, h, nx / sine, ny / sine, nz / sine) if sine > 2.0**-20 else 0.0


# Edges and corners: two or three surfaces that meet

_PARALLEL = 2.0**-40  # sine below which planes count as parallel
_LINE_SHARE = 2.0**-44  # size below which a coefficient on a line counts as zero
_MORE = 1.0 + 2.0**-30  # factor to the search radius, for rounding
_ENDED = 2.0**-36
"""Largest error, as a share of its size, of a point on several surfaces for which Newton's method has converged."""
EDGE_ERROR = 2.0**-42
"""Error of a conic of two quadrics as a share of the sizes of points, for every angle of the quadrics."""


@inline
def plane_about(form: SurfaceForm) -> tuple[float, float, float, float]:
    """Return a plane as (n, h) of n·v = h with a unit vector n."""
    return 2.0 * form.gx, 2.0 * form.gy, 2.0 * form.gz, -form.value


@helper
def origin_of(
    geometry: Geometry, room: Neighbourhood, at: WallQuery, i: int, j: int, k: int
) -> tuple[float, float, float]:
    """Return the point about which planes of near surfaces are computed: the anchor of the first curved one.

    About a query point far away a plane is known less well than a flat body is high. It serves for planes alone.
    """
    for near in (i, j, k):
        if not is_flat(geometry, room, near):
            return anchor_of(geometry, room.surface[near])
    return at.x, at.y, at.z


@inline
def planes_of_pair(
    geometry: Geometry, room: Neighbourhood, i: int, j: int, cx: float, cy: float, cz: float
) -> PencilPlanes:
    """Return planes that contain the common points of near surfaces i < j: a plane among them, or those of quadrics.

    They are about (cx, cy, cz): of two quadrics that is the anchor of i.
    """
    flat = is_flat(geometry, room, i)
    if flat or is_flat(geometry, room, j):  # a sheet's own quadric stands before the planes
        nx, ny, nz, h = plane_about(form_at(geometry, room.surface[i if flat else j], cx, cy, cz))
        return PencilPlanes(1, nx, ny, nz, h, 0.0, 0.0, 0.0, 0.0)
    return shared_planes(geometry, room.surface[i], room.surface[j])


@inline
def plane_of(planes: PencilPlanes, k: int) -> tuple[float, float, float, float]:
    """Return (n, h) of plane k."""
    if k == 0:
        return planes.x0, planes.y0, planes.z0, planes.h0
    return planes.x1, planes.y1, planes.z1, planes.h1


@inline
def _choose(room: Neighbourhood, i: int, j: int, k: int) -> None:
    room.chosen[0], room.chosen[1], room.chosen[2] = i, j, k


@inline
def line_of_planes(
    ax: float, ay: float, az: float, g: float, bx: float, by: float, bz: float, h: float
) -> tuple[float, float, float, float, float, float]:
    """Return (foot, unit direction) of the line a·v = g, b·v = h; the direction is zero for parallel planes."""
    # The sine of the angle between unit normals is the length of their cross product
    dx, dy, dz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    square = dot(dx, dy, dz, dx, dy, dz)
    if square <= _PARALLEL * _PARALLEL:
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    # The foot is (g b - h a) × d / |d|², which is perpendicular to d
    mx, my, mz = g * bx - h * ax, g * by - h * ay, g * bz - h * az
    x, y, z = my * dz - mz * dy, mz * dx - mx * dz, mx * dy - my * dx
    root = math.sqrt(square)
    return x / square, y / square, z / square, dx / root, dy / root, dz / root


@helper
def try_edge(geometry: Geometry, room: Neighbourhood, at: WallQuery, i: int, j: int) -> bool:
    """Try the common points of near surfaces i < j; True if their curve is hard: in no plane."""
    if is_flat(geometry, room, i) and is_flat(geometry, room, j):
        ax, ay, az, g = plane_about(form_at(geometry, room.surface[i], at.x, at.y, at.z))
        bx, by, bz, h = plane_about(form_at(geometry, room.surface[j], at.x, at.y, at.z))
        x, y, z, dx, dy, dz = line_of_planes(ax, ay, az, g, bx, by, bz, h)
        if (dx != 0.0) | (dy != 0.0) | (dz != 0.0):
            _choose(room, i, j, j)
            try_point(geometry, room, at, 2, candidate(x, y, z))
        return False
    cx, cy, cz = origin_of(geometry, room, at, i, j, j)
    planes = planes_of_pair(geometry, room, i, j, cx, cy, cz)
    if planes.number == HARD:
        return True
    curved = j if is_flat(geometry, room, i) else i
    error = math.inf if is_flat(geometry, room, i) or is_flat(geometry, room, j) else EDGE_ERROR
    for k in range(planes.number):
        nx, ny, nz, h = plane_of(planes, k)
        if abs(dot(nx, ny, nz, at.x - cx, at.y - cy, at.z - cz) - h) <= limit(room) * _MORE:
            _choose(room, i, j, j)
            try_conic(geometry, room, at, curved, nx, ny, nz, h, error)
    if planes.number == 2:  # where the two conics cross
        _try_line(geometry, room, at, planes, planes, i, j, j)
    return False


@helper
def _try_line(
    geometry: Geometry,
    room: Neighbourhood,
    at: WallQuery,
    one: PencilPlanes,
    other: PencilPlanes,
    i: int,
    j: int,
    k: int,
) -> None:
    """Try where lines of two planes meet surface k, or the sheet's own surface i if that is curved and k is not.

    The planes are about `origin_of` the surfaces; k = j for two. A line that lies in the surface, as two planes in one
    quadric cross in such a line, meets another one of the three.
    """
    first = i if is_flat(geometry, room, k) and not is_flat(geometry, room, i) else k
    second = j if k != j or first == i else i
    cx, cy, cz = origin_of(geometry, room, at, i, j, k)
    qx, qy, qz = at.x - cx, at.y - cy, at.z - cz
    for p in range(one.number):
        nx, ny, nz, g = plane_of(one, p)
        for q in range(p + 1 if k == j else 0, other.number):
            mx, my, mz, h = plane_of(other, q)
            x, y, z, dx, dy, dz = line_of_planes(nx, ny, nz, g, mx, my, mz, h)
            foot = dot(dx, dy, dz, qx, qy, qz)
            fx, fy, fz = x - qx + foot * dx, y - qy + foot * dy, z - qz + foot * dz
            if not length_of(fx, fy, fz) <= limit(room) * _MORE or not (dx != 0.0) | (dy != 0.0) | (dz != 0.0):
                continue
            along = a = b = c = 0.0
            for own in (first, second):
                # About there the terms of a quadric are smallest
                ax, ay, az = origin_of(geometry, room, at, own, own, own)
                along = dot(dx, dy, dz, ax - cx - x, ay - cy - y, az - cz - z)
                sx, sy, sz = cx + x + along * dx, cy + y + along * dy, cz + z + along * dz
                form = form_at(geometry, room.surface[own], sx, sy, sz)
                a, off = form.size, 0.0  # of a plane and of a sphere
                if integer(geometry, table.SURFACE_KIND, room.surface[own]) == QUADRIC:
                    a, off = bend_between(
                        load_quadric(geometry, integer(geometry, table.SURFACE_ROW, room.surface[own])),
                        dx, dy, dz, dx, dy, dz,
                    )  # fmt: skip
                b, c = dot(form.gx, form.gy, form.gz, dx, dy, dz), form.value
                # A coefficient within rounding counts as zero, also under the root: else the line of two planes, along
                # a third one, would meet that at a point that rounding has made
                a = a if abs(a) > 16.0 * off else 0.0
                b = b if abs(b) > _LINE_SHARE * form.steep else 0.0
                if (a != 0.0) | (b != 0.0) | (abs(c) > form.off):
                    break
            if b * b - a * c < -(2.0**-30) * (b * b + abs(a * c)):
                continue
            root = math.sqrt(max(b * b - a * c, 0.0))
            # As in `roots_of`: b and the root have one sign, so that nothing cancels
            far = -(b + math.copysign(root, b))
            for which in range(2):
                over, under = (far, a) if which == 0 else (c, far)
                t = along + over / under if under != 0.0 else math.inf
                if not abs(t - foot) <= limit(room) * _MORE:
                    continue
                _choose(room, i, j, k)
                px, py, pz = x - qx + t * dx, y - qy + t * dy, z - qz + t * dz
                error = rounding_share(at, EDGE_ERROR, px, py, pz) if k == j else math.inf
                least = length_of(fx, fy, fz) - rounding_share(at, EDGE_ERROR, fx, fy, fz)
                try_point(geometry, room, at, 2 if k == j else 3, WallCandidate(px, py, pz, error, least, 0.0))


@helper
def try_corners(geometry: Geometry, room: Neighbourhood, at: WallQuery, i: int, j: int) -> None:
    """Try the points where near surfaces i < j meet a third one k > j; hard curves are left out."""
    cx, cy, cz = origin_of(geometry, room, at, i, j, j)
    one = planes_of_pair(geometry, room, i, j, cx, cy, cz)
    if one.number <= 0:
        return
    flat = is_flat(geometry, room, i)
    for k in range(j + 1, room.sizes[SURFACES]):
        if not room.bound[k] <= limit(room):
            continue
        if flat and is_flat(geometry, room, j):
            cx, cy, cz = origin_of(geometry, room, at, i, j, k)
            one = planes_of_pair(geometry, room, i, j, cx, cy, cz)
        # The third curve: that of i and k if i is curved, else that of j and k
        other = planes_of_pair(geometry, room, j if flat else i, k, cx, cy, cz)
        if other.number > 0:
            _try_line(geometry, room, at, one, other, i, j, k)


@inline
def is_hard(room: Neighbourhood, i: int, j: int) -> bool:
    """True if the curve of near surfaces i < j is in no plane; `try_edges` has recorded it."""
    return j >= MOST_PAIRED or room.hard[MOST_PAIRED * i + j] == 1


@inline
def _note(room: Neighbourhood, i: int, j: int, hard: bool) -> bool:
    """Record whether the curve of two near surfaces is in no plane; return it."""
    if j < MOST_PAIRED:
        room.hard[MOST_PAIRED * i + j] = 1 if hard else 0
    return hard


@helper
def _try_from(
    geometry: Geometry, room: Neighbourhood, at: WallQuery, i: int, j: int, k: int, vx: float, vy: float, vz: float
) -> None:
    """Try the point to which Newton's method converges from x + v: a wall there bounds the search radius.

    A point that is not certainly a wall has no effect, nor has one without convergence, as surfaces need not meet.
    """
    before, count = room.best[LOWER], 2 if j == k else 3
    _choose(room, i, j, k)
    # Newton's method on two or three surfaces at once
    touch = project_point(geometry, room, count, at.x + vx, at.y + vy, at.z + vz)
    if touch.off > _ENDED * (abs(touch.x) + abs(touch.y) + abs(touch.z)):
        return
    v = candidate(touch.x - at.x, touch.y - at.y, touch.z - at.z)
    if try_point(geometry, room, at, count, v) != CERTAIN_WALL:
        # A guess must not lower the certain bound
        room.best[LOWER] = before


@helper
def _into_leaves(geometry: Geometry, room: Neighbourhood, x: float, axis: int) -> float:
    """Return the displacement from x to the interval of the near leaves' boxes along an axis."""
    low, high, program = math.inf, -math.inf, whole(room.sizes[PROGRAM])
    if program >= 0:
        bounds, first = leaf_bounds(geometry, program), integer(geometry, table.PROGRAM_LEAF, program)
        for k in range(room.sizes[LEAVES]):
            number = whole(room.leaves[4 * k + LEAF]) - first
            low = min(low, leaf_low(geometry, bounds, number, axis))
            high = max(high, leaf_high(geometry, bounds, number, axis))
    return (low - x if x < low else min(high - x, 0.0)) if low <= high else 0.0


@helper
def _try_hard_from_beside(geometry: Geometry, room: Neighbourhood, at: WallQuery) -> None:
    """Try points of hard curves, and corners on them: a better first guess leaves fewer boxes to `try_hard_edges`.

    Newton's method starts at the nearest point of a box around the body; from far away each step only halves the way.
    """
    vx, vy, vz = (
        _into_leaves(geometry, room, at.x, 0), _into_leaves(geometry, room, at.y, 1),
        _into_leaves(geometry, room, at.z, 2),
    )  # fmt: skip
    count = min(room.sizes[SURFACES], MOST_PAIRED)
    for i in range(count):
        for j in range(i + 1, count):
            if not is_hard(room, i, j):
                continue
            if i == 0 or room.sizes[SHEET_OF] == 0:
                _try_from(geometry, room, at, i, j, j, vx, vy, vz)
            for k in range(count):
                if k != i and k != j and (room.sizes[SHEET_OF] == 0 or i == 0 or k == 0):
                    first, last = min(i, k), max(j, k)
                    _try_from(geometry, room, at, first, max(min(i, j), min(max(i, j), k)), last, vx, vy, vz)


@helper
def try_edges(geometry: Geometry, room: Neighbourhood, at: WallQuery) -> bool:
    """Try all edges, then all corners, of the near surfaces; True if some curve of two quadrics is in no plane."""
    sheet, hard = room.sizes[SHEET_OF] == 1, False
    count = room.sizes[SURFACES]
    last = 1 if sheet else count
    for i in range(count):
        for j in range(i + 1, count):
            _note(room, i, j, False)
            if max(room.bound[i], room.bound[j]) <= limit(room):
                if i < last:
                    hard = _note(room, i, j, try_edge(geometry, room, at, i, j)) or hard
                else:
                    planes = planes_of_pair(geometry, room, i, j, 0.0, 0.0, 0.0)
                    hard = _note(room, i, j, planes.number == HARD) or hard
    for i in range(last):
        for j in range(i + 1, count):
            if max(room.bound[i], room.bound[j]) <= limit(room):
                try_corners(geometry, room, at, i, j)
    if hard:
        _try_hard_from_beside(geometry, room, at)
    return hard


# Hard edges, where two quadrics meet in a curve that no plane contains: a search by bisection of boxes of space
#
# A box is discarded if it is farther away than the best wall, if no two quadrics with such a curve can both vanish in
# it, or if just two can and the distance is nowhere stationary on their curve; at a stationary point the vector from
# the query point lies in the plane of both gradients, det(v, g, h) = 0. All other points in the box have been tried
# before. A remaining box is halved until the curve in it is nearly straight; then its middle, projected onto the curve,
# is as near as the stationary point to second order.

_SMALL, _LEAST = 2.0**-25, 2.0**-44
"""Sides of a box at which it is tried: as a share of the distance and of the radius of curvature, and at the latest as
a share of its coordinates."""
_MOST_STEPS, _MOST_SIDES = 40000, 5
"""Most boxes of a search; most surfaces of a box whose sides are tried in all combinations."""
_LESS = 1.0 - 2.0**-40
_AS_NEAR = 1.0 - 2.0**-46
"""Share of the best wall's distance from which on a box is discarded, and its distance becomes the lower bound: the
difference is within the error."""


@inline
def _nearest_in(at: WallQuery, x: float, y: float, z: float, half: float) -> float:
    """Return a lower bound of the distance to a box."""
    dx, dy, dz = (
        max(0.0, abs(x - at.x) - half), max(0.0, abs(y - at.y) - half), max(0.0, abs(z - at.z) - half),
    )  # fmt: skip
    return length_of(dx, dy, dz) * _LESS


@helper
def _push(room: Neighbourhood, top: int, at: WallQuery, x: float, y: float, z: float, half: float) -> int:
    """Push a box on the stack, unless it is too far; return the height. A full stack lowers the lower bound instead."""
    near = _nearest_in(at, x, y, z, half)
    if near > limit(room):
        return top
    if top >= MOST_BOXES:
        room.best[LOWER] = min(room.best[LOWER], near)
        return top
    k = BOX * top
    room.boxes[k], room.boxes[k + 1], room.boxes[k + 2] = x, y, z
    room.boxes[k + 3], room.boxes[k + 4] = half, near
    return top + 1


@inline
def _may_vanish(form: SurfaceForm, half: float) -> bool:
    """True if f may be zero in the box of this half side about the form's point."""
    change = 2.0 * (abs(form.gx) + abs(form.gy) + abs(form.gz)) * half
    bend = abs(form.xx) + abs(form.yy) + abs(form.zz) + 2.0 * (abs(form.xy) + abs(form.xz) + abs(form.yz))
    return abs(form.value) <= form.off + (change + bend * half * half) * (1.0 + ROUNDED)


@inline
def _cross(ax: float, ay: float, az: float, bx: float, by: float, bz: float) -> tuple[float, float, float]:
    """Return a × b."""
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


@helper
def _is_stationary(f: SurfaceForm, h: SurfaceForm, vx: float, vy: float, vz: float, half: float) -> bool:
    """True if D = det(v, g, h) may vanish on the curve in the box about the forms' point, v from the query point.

    On the curve D equals D + m f + n h. With m and n that leave only the gradient along the curve, the range of this
    sum over the box is as narrow as the change of D along the curve, however steep D is across it.
    """
    nx, ny, nz = _cross(f.gx, f.gy, f.gz, h.gx, h.gy, h.gz)
    px, py, pz = _cross(h.gx, h.gy, h.gz, vx, vy, vz)
    qx, qy, qz = _cross(vx, vy, vz, f.gx, f.gy, f.gz)
    ax, ay, az = bend_times(f, px, py, pz)
    bx, by, bz = bend_times(h, qx, qy, qz)
    dx, dy, dz = nx + ax + bx, ny + ay + by, nz + az + bz
    ff, fh = dot(f.gx, f.gy, f.gz, f.gx, f.gy, f.gz), dot(f.gx, f.gy, f.gz, h.gx, h.gy, h.gz)
    hh, square = dot(h.gx, h.gy, h.gz, h.gx, h.gy, h.gz), dot(nx, ny, nz, nx, ny, nz)
    # Nearly parallel gradients: m and n would be quotients by almost 0
    if not square > 1e-12 * (ff * hh):
        return True
    df, dh = dot(dx, dy, dz, f.gx, f.gy, f.gz), dot(dx, dy, dz, h.gx, h.gy, h.gz)
    m, n = (dh * fh - df * hh) / square, (df * fh - dh * ff) / square
    ex, ey, ez = dx + m * f.gx + n * h.gx, dy + m * f.gy + n * h.gy, dz + m * f.gz + n * h.gz
    # A bound of the sum's change over the box: by its gradient, by terms of second and third order, by rounding
    r, g, k = half * 1.7321, math.sqrt(ff), math.sqrt(hh)
    size = length_of(vx, vy, vz)
    most = (abs(ex) + abs(ey) + abs(ez)) * half
    most += (f.size * k + h.size * g + size * f.size * h.size + abs(m) * f.size + abs(n) * h.size) * (r * r)
    most += f.size * h.size * (r * r * r)
    most += 16.0 * ROUNDED * (f.steep * h.steep) * size + abs(m) * f.off + abs(n) * h.off
    return abs(dot(nx, ny, nz, vx, vy, vz) + 0.5 * (m * f.value + n * h.value)) <= most


@inline
def _any_hard(geometry: Geometry, room: Neighbourhood, count: int) -> bool:
    """True if two of the first `count` of room.chosen, which are in rising order, have a hard curve."""
    for i in range(count):
        for j in range(i + 1, count):
            one, other = room.chosen[i], room.chosen[j]
            curved = not is_flat(geometry, room, one) and not is_flat(geometry, room, other)
            if curved and is_hard(room, one, other):
                return True
    return False


@helper
def _near_surfaces(geometry: Geometry, room: Neighbourhood, x: float, y: float, z: float, half: float) -> int:
    """Write the near surfaces that may meet a box to room.chosen; return how many, 0 if the own one of a sheet may not.

    room.sign gets the side of the others on which the whole box lies.
    """
    count = 0
    for k in range(room.sizes[SURFACES]):
        form = form_at(geometry, room.surface[k], x, y, z)
        room.sign[k] = 1 if form.value > 0.0 else -1
        if _may_vanish(form, half):
            room.sign[k] = 0
            room.chosen[count] = k
            count += 1
        elif k == 0 and room.sizes[SHEET_OF] == 1:
            return 0
    return count


@inline
def _may_have_walls(geometry: Geometry, room: Neighbourhood, count: int) -> bool:
    """True if the body is there for some sides of the chosen surfaces, not for others; relies on `_near_surfaces`."""
    if count > _MOST_SIDES:
        return True
    if room.sizes[SHEET_OF] == 1:
        return sheet_around(geometry, room, count)
    values = sides_around(geometry, room, count)
    return values != 0 and values != (whole(1) << (1 << count)) - 1


@inline
def _radius(form: SurfaceForm) -> float:
    """Return about a lower bound of the radii of curvature of a surface."""
    return length_of(form.gx, form.gy, form.gz) / form.size


@helper
def _try_box(
    geometry: Geometry, room: Neighbourhood, at: WallQuery, count: int, x: float, y: float, z: float, half: float
) -> bool:
    """Try the middle of a small box; True if that decides the box."""
    if not 2 <= count <= 3:
        return False
    touch = project_point(geometry, room, count, x, y, z)
    if touch.sine < TANGENT or length_of(touch.x - x, touch.y - y, touch.z - z) > 16.0 * half / touch.sine:
        return False
    size, before = length_of(touch.x - at.x, touch.y - at.y, touch.z - at.z), room.best[LOWER]
    radius = size
    for i in range(count):
        form = form_at(geometry, room.surface[room.chosen[i]], touch.x, touch.y, touch.z)
        if form.size > 0.0:
            radius = min(radius, _radius(form) * touch.sine)
    if half > _SMALL * radius * touch.sine:
        return False
    try_point(geometry, room, at, count, candidate(touch.x - at.x, touch.y - at.y, touch.z - at.z))
    if count == 2 and room.best[LOWER] < before:  # the stationary point lies beside this one
        offset = 8.0 * half / touch.sine
        room.best[LOWER] -= 2.0 * offset * offset / radius
    return True


@inline
def _on_two(room: Neighbourhood, count: int) -> float:
    """Return a lower bound of the distance to points on two of the chosen surfaces: the second smallest of theirs."""
    least, second = math.inf, math.inf
    for i in range(count):
        bound = room.bound[room.chosen[i]]
        least, second = min(least, bound), min(second, max(least, bound))
    return second


@helper
def _search(geometry: Geometry, room: Neighbourhood, at: WallQuery, x: float, y: float, z: float, half: float) -> None:
    """Search a cube."""
    top, steps, whole_cube = _push(room, 0, at, x, y, z, half), 0, half
    while top > 0 and not poll_halt(geometry, steps):
        top, steps = top - 1, steps + 1
        k = BOX * top
        x, y, z, half, near = (
            room.boxes[k], room.boxes[k + 1], room.boxes[k + 2], room.boxes[k + 3], room.boxes[k + 4],
        )  # fmt: skip
        if near > limit(room):
            continue
        count = _near_surfaces(geometry, room, x, y, z, half)
        if count < 2 or not _any_hard(geometry, room, count) or not _may_have_walls(geometry, room, count):
            continue
        # A point of the curve is at least as far as the second nearest of its surfaces
        near = max(near, _on_two(room, count))
        if near >= limit(room) * _AS_NEAR:  # a whole curve may be equally near, as from the center of a ball
            room.best[LOWER] = min(room.best[LOWER], near)
            continue
        if count == 2:
            one = form_at(geometry, room.surface[room.chosen[0]], x, y, z)
            other = form_at(geometry, room.surface[room.chosen[1]], x, y, z)
            if not _is_stationary(one, other, x - at.x, y - at.y, z - at.z, half):
                continue
        if half <= _SMALL * near and _try_box(geometry, room, at, count, x, y, z, half):
            continue
        if half <= _LEAST * (abs(x) + abs(y) + abs(z) + whole_cube) or steps > _MOST_STEPS:
            try_point(geometry, room, at, min(count, 3), candidate(x - at.x, y - at.y, z - at.z))
            room.best[LOWER] = min(room.best[LOWER], near)
            continue
        half *= 0.5
        # `away`: the corner of the box that is farthest from the query point, a bit for each axis
        away = (1 if at.x < x else 0) | (2 if at.y < y else 0) | (4 if at.z < z else 0)
        for i in range(8):  # from the corner opposite to `away` to `away` itself, which lies on top
            side = (i ^ away) ^ 7
            dx = half if side & 1 else -half
            dy = half if side & 2 else -half
            dz = half if side & 4 else -half
            top = _push(room, top, at, x + dx, y + dy, z + dz, half)


@helper
def reach_of_leaves(geometry: Geometry, room: Neighbourhood, at: WallQuery) -> float:
    """Return the largest distance along an axis to which the boxes of the near leaves reach; inf without a program."""
    most, program = 0.0, whole(room.sizes[PROGRAM])
    if program < 0:
        return math.inf
    bounds, first = leaf_bounds(geometry, program), integer(geometry, table.PROGRAM_LEAF, program)
    for k in range(room.sizes[LEAVES]):
        number = whole(room.leaves[4 * k + LEAF]) - first
        for axis in range(3):
            low, high = leaf_low(geometry, bounds, number, axis), leaf_high(geometry, bounds, number, axis)
            mine = at.x if axis == 0 else (at.y if axis == 1 else at.z)
            most = max(most, max(mine - low, high - mine))
    return most


@helper
def try_hard_edges(geometry: Geometry, room: Neighbourhood, at: WallQuery) -> None:
    """Try all hard edges, and the corners on them; without a bound of the distance, in growing cubes."""
    half = min(limit(room), reach_of_leaves(geometry, room, at))
    if half < math.inf:
        _search(geometry, room, at, at.x, at.y, at.z, half * (1.0 + 2.0**-20))
        return
    half = 1.0
    for k in range(room.sizes[SURFACES]):
        if integer(geometry, table.SURFACE_KIND, room.surface[k]) != table.PLANE:
            cx, cy, cz = anchor_of(geometry, room.surface[k])
            half = max(half, 4.0 * length_of(cx - at.x, cy - at.y, cz - at.z))
        if room.bound[k] < math.inf:
            half = max(half, 4.0 * room.bound[k])
    for _ in range(12):
        _search(geometry, room, at, at.x, at.y, at.z, half)
        if room.best[UPPER] <= half:  # the nearest wall lies within the cube
            return
        # Few cubes, since each searches the one before again
        half *= 16.0
    room.best[LOWER] = min(room.best[LOWER], half)
