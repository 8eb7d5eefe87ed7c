"""The planes that hold the curve of two quadrics, where there are such.

Every f - m h of two quadrics f and h vanishes where both do. Where one of these is a pair of planes the curve is two
conics: of two spheres, of quadrics of revolution about one axis, of parallel cylinders, of equal cylinders that cross.
Such an m makes the two forms equal along an axis that both share, so m = (e·A e) / (e·B e) of the principal axes e of
both is tried. (Levin: A parametric algorithm for drawing pictures of solid objects composed of quadric surfaces,
CACM 19, 1976.)
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ...compiler.jit import helper, inline
from ..numbers.vectors import dot
from ..surface.records import anchor_of
from ..tables import Geometry
from .axes import principal_axes
from .form import Form, bent, form_at, length_of

_ALIKE = 2.0**-44
"""Share of what it was taken from by which a coefficient counts as zero."""
HARD = -1


class Planes(NamedTuple):
    """The planes n·v = h, none to two of them, about the point that is asked for; HARD where the curve is in none."""

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
def _no_planes(count: int) -> Planes:
    return Planes(count, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@inline
def _difference(f: Form, h: Form, m: float) -> Form:
    """f - m h; its `off`, `size` and `steep` are bounds of what counts as zero."""
    return Form(
        f.value - m * h.value, 16.0 * (f.off + abs(m) * h.off), f.gx - m * h.gx, f.gy - m * h.gy, f.gz - m * h.gz,
        f.xx - m * h.xx, f.yy - m * h.yy, f.zz - m * h.zz, f.xy - m * h.xy, f.xz - m * h.xz, f.yz - m * h.yz,
        _ALIKE * (f.size + abs(m) * h.size), _ALIKE * (f.steep + abs(m) * h.steep),
    )  # fmt: skip


@helper
def _planes_of(f: Form) -> Planes:
    """The planes that a form is the product of; HARD where it is none."""
    a0, a1, a2, (x0, y0, z0, x1, y1, z1, x2, y2, z2) = principal_axes(f.xx, f.yy, f.zz, f.xy, f.xz, f.yz)
    if abs(a0) < abs(a2):  # the largest becomes the first
        a0, a2, x0, y0, z0, x2, y2, z2 = a2, a0, x2, y2, z2, x0, y0, z0
    if abs(a1) < abs(a2):  # and the least the last
        a1, a2, x1, y1, z1, x2, y2, z2 = a2, a1, x2, y2, z2, x1, y1, z1
    g0, g1, g2 = dot(x0, y0, z0, f.gx, f.gy, f.gz), dot(x1, y1, z1, f.gx, f.gy, f.gz), dot(x2, y2, z2, f.gx, f.gy, f.gz)
    if abs(a0) <= f.size:
        g = length_of(f.gx, f.gy, f.gz)
        if g <= f.steep:
            return _no_planes(HARD if abs(f.value) <= f.off else 0)
        return Planes(1, f.gx / g, f.gy / g, f.gz / g, -0.5 * f.value / g, 0.0, 0.0, 0.0, 0.0)
    if abs(a2) > f.size or abs(g2) > f.steep:
        return _no_planes(HARD)
    t0 = -g0 / a0
    if abs(a1) <= f.size:
        if abs(g1) > f.steep:
            return _no_planes(HARD)
        square = (g0 * g0 - a0 * f.value) / (a0 * a0)
        if square < -f.off / abs(a0):
            return _no_planes(0)
        root = math.sqrt(max(square, 0.0))
        return Planes(2, x0, y0, z0, t0 + root, x0, y0, z0, t0 - root)
    t1 = -g1 / a1
    if abs(f.value + g0 * t0 + g1 * t1) > f.off + 4.0 * f.steep * (abs(t0) + abs(t1)) or a0 * a1 > 0.0:
        return _no_planes(HARD)
    u, v = math.sqrt(abs(a0)), math.sqrt(abs(a1))
    both = math.sqrt(u * u + v * v)
    u, v = u / both, v / both
    return Planes(
        2, u * x0 + v * x1, u * y0 + v * y1, u * z0 + v * z1, u * t0 + v * t1,
        u * x0 - v * x1, u * y0 - v * y1, u * z0 - v * z1, u * t0 - v * t1,
    )  # fmt: skip


@inline
def _ratio(f: Form, h: Form, x: float, y: float, z: float) -> float:
    """m that makes f and h equal along a unit vector; 0 where it is nowhere or everywhere."""
    ax, ay, az = bent(f, x, y, z)
    bx, by, bz = bent(h, x, y, z)
    over, under = dot(ax, ay, az, x, y, z), dot(bx, by, bz, x, y, z)
    return over / under if (abs(under) > 2.0**-30 * h.size) & (abs(over) > 2.0**-30 * f.size) else 0.0


@helper
def shared_planes(geometry: Geometry, one: int, other: int, x: float, y: float, z: float) -> Planes:
    """The planes of the curve of two curved surfaces, about a point."""
    cx, cy, cz = anchor_of(geometry, one)
    f, h = form_at(geometry, one, cx, cy, cz), form_at(geometry, other, cx, cy, cz)
    p = principal_axes(f.xx, f.yy, f.zz, f.xy, f.xz, f.yz).along
    q = principal_axes(h.xx, h.yy, h.zz, h.xy, h.xz, h.yz).along
    found = _planes_of(_difference(f, h, 0.0))
    for k in range(7):
        if found.number != HARD:
            break
        axes = p if k < 3 else q
        if k == 6:
            found = _planes_of(_difference(h, f, 0.0))
        else:
            if k % 3 == 0:
                m = _ratio(f, h, axes.x0, axes.y0, axes.z0)
            elif k % 3 == 1:
                m = _ratio(f, h, axes.x1, axes.y1, axes.z1)
            else:
                m = _ratio(f, h, axes.x2, axes.y2, axes.z2)
            if m != 0.0:
                found = _planes_of(_difference(f, h, m))
    dx, dy, dz = x - cx, y - cy, z - cz
    return Planes(
        found.number, found.x0, found.y0, found.z0, found.h0 - dot(found.x0, found.y0, found.z0, dx, dy, dz),
        found.x1, found.y1, found.z1, found.h1 - dot(found.x1, found.y1, found.z1, dx, dy, dz),
    )  # fmt: skip
