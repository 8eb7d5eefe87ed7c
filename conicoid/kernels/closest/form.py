"""A surface as a polynomial about a point, f(x + v) = value + 2 g·v + v·A v, with error bounds; principal axes of A."""

from __future__ import annotations

import math
from typing import NamedTuple

from ..._jit.decorators import helper, inline
from .. import tables as table
from ..numbers.vectors import dot
from ..surface.plane import PlaneRecord
from ..surface.quadric import QuadricRecord, SphereRecord, quadric_gradient, quadric_rounding, quadric_value
from ..surface.records import load_plane, load_quadric, load_sphere
from ..tables import PLANE, SPHERE, Geometry, integer

ROUNDED = 2.0**-48
"""Error of a value as a share of its terms: 32 roundings."""
_ANCHOR = 2.0**-52
"""Error of an anchor's record as a share of its coordinates."""
_OF_DOUBT = 2.0**-4
"""Factor to `quadric_rounding`, which counts 512 roundings of a value; here 32 are enough."""


class SurfaceForm(NamedTuple):
    """A surface about a point x. For a plane A is zero and g is half the unit normal."""

    value: float
    off: float  # error bound of the value
    gx: float  # half the gradient
    gy: float
    gz: float
    xx: float  # A
    yy: float
    zz: float
    xy: float
    xz: float
    yz: float
    size: float  # at least |A|: the sum of the sizes of its terms
    steep: float  # at least |g|, likewise


@inline
def form_of_plane(plane: PlaneRecord, x: float, y: float, z: float) -> SurfaceForm:
    """Return a plane about a point."""
    nx, ny, nz, above, ax, ay, az = plane
    unit = 1.0 / math.sqrt(dot(nx, ny, nz, nx, ny, nz))
    nx, ny, nz, above = nx * unit, ny * unit, nz * unit, above * unit
    px, py, pz = x - ax, y - ay, z - az
    value = dot(nx, ny, nz, px, py, pz) + above
    terms = abs(nx * px) + abs(ny * py) + abs(nz * pz) + abs(above)
    off = ROUNDED * terms + _ANCHOR * (abs(ax) + abs(ay) + abs(az))
    return SurfaceForm(value, off, 0.5 * nx, 0.5 * ny, 0.5 * nz, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.5)


@inline
def form_of_sphere(sphere: SphereRecord, x: float, y: float, z: float) -> SurfaceForm:
    """Return a sphere about a point."""
    cx, cy, cz, r = sphere
    px, py, pz = x - cx, y - cy, z - cz
    length = math.sqrt(dot(px, py, pz, px, py, pz))
    value = (length - r) * (length + r)
    off = ROUNDED * (length * length + r * r) + 2.0 * length * _ANCHOR * (abs(cx) + abs(cy) + abs(cz))
    return SurfaceForm(value, off, px, py, pz, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, length)


@inline
def form_of_quadric(quadric: QuadricRecord, x: float, y: float, z: float) -> SurfaceForm:
    """Return a quadric about a point."""
    ax, ay, az, w00, w01, w02, w10, w11, w12, w20, w21, w22, s0, s1, s2, b0, b1, b2, _ = quadric
    gx, gy, gz = quadric_gradient(quadric, x, y, z)
    n0, n1, n2 = dot(w00, w01, w02, w00, w01, w02), dot(w10, w11, w12, w10, w11, w12), dot(w20, w21, w22, w20, w21, w22)
    size = abs(s0) * n0 + abs(s1) * n1 + abs(s2) * n2
    far = abs(x - ax) + abs(y - ay) + abs(z - az)
    steep = size * far + abs(b0) * math.sqrt(n0) + abs(b1) * math.sqrt(n1) + abs(b2) * math.sqrt(n2)
    off = _OF_DOUBT * quadric_rounding(quadric, x, y, z, 0.0, 0.0, 0.0)
    # By the gradient, far smaller than `steep` beside a thin rod
    moved = _ANCHOR * (abs(ax) + abs(ay) + abs(az))
    off += (2.0 * (length_of(gx, gy, gz) + ROUNDED * steep) + size * moved) * moved
    return SurfaceForm(
        quadric_value(quadric, x, y, z), off, gx, gy, gz,
        dot(s0 * w00, s1 * w10, s2 * w20, w00, w10, w20), dot(s0 * w01, s1 * w11, s2 * w21, w01, w11, w21),
        dot(s0 * w02, s1 * w12, s2 * w22, w02, w12, w22), dot(s0 * w00, s1 * w10, s2 * w20, w01, w11, w21),
        dot(s0 * w00, s1 * w10, s2 * w20, w02, w12, w22), dot(s0 * w01, s1 * w11, s2 * w21, w02, w12, w22),
        size, steep,
    )  # fmt: skip


@inline
def form_at(geometry: Geometry, surface: int, x: float, y: float, z: float) -> SurfaceForm:
    """Return a surface about a point."""
    kind, row = integer(geometry, table.SURFACE_KIND, surface), integer(geometry, table.SURFACE_ROW, surface)
    if kind == PLANE:
        return form_of_plane(load_plane(geometry, row), x, y, z)
    if kind == SPHERE:
        return form_of_sphere(load_sphere(geometry, row), x, y, z)
    return form_of_quadric(load_quadric(geometry, row), x, y, z)


@inline
def bend_times(form: SurfaceForm, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Return A v."""
    return (
        dot(form.xx, form.xy, form.xz, x, y, z),
        dot(form.xy, form.yy, form.yz, x, y, z),
        dot(form.xz, form.yz, form.zz, x, y, z),
    )


@inline
def bend_between(
    quadric: QuadricRecord, ux: float, uy: float, uz: float, vx: float, vy: float, vz: float
) -> tuple[float, float]:
    """Return (u·A v, its error bound) of unit vectors, from the rows, which keep digits that A may have lost."""
    _, _, _, w00, w01, w02, w10, w11, w12, w20, w21, w22, s0, s1, s2, _, _, _, _ = quadric
    n0, n1, n2 = length_of(w00, w01, w02), length_of(w10, w11, w12), length_of(w20, w21, w22)
    n0, n1, n2 = ROUNDED * n0, ROUNDED * n1, ROUNDED * n2
    u0, u1, u2 = dot(w00, w01, w02, ux, uy, uz), dot(w10, w11, w12, ux, uy, uz), dot(w20, w21, w22, ux, uy, uz)
    v0, v1, v2 = dot(w00, w01, w02, vx, vy, vz), dot(w10, w11, w12, vx, vy, vz), dot(w20, w21, w22, vx, vy, vz)
    t0, t1, t2 = n0 * (abs(u0) + abs(v0) + n0), n1 * (abs(u1) + abs(v1) + n1), n2 * (abs(u2) + abs(v2) + n2)
    return dot(s0 * u0, s1 * u1, s2 * u2, v0, v1, v2), dot(abs(s0), abs(s1), abs(s2), t0, t1, t2)


@inline
def rounding_within(form: SurfaceForm, r: float) -> float:
    """Return the error bound of f(x + v) for every v up to the length r."""
    return form.off + ROUNDED * (2.0 * form.steep + form.size * r) * r


@inline
def length_of(x: float, y: float, z: float) -> float:
    """Return |v|; squares of the components must neither overflow nor underflow."""
    return math.sqrt(dot(x, y, z, x, y, z))


# Principal axes of symmetric 3 × 3 matrices, by Jacobi's rotations (Golub, Van Loan: Matrix Computations, 8.5)
#
# Rotations need sums, products and square roots only, so all systems give the same bits.

_SWEEPS = 12
_NONE = 2.0**-58  # share of the diagonal below which a mixed term counts as zero


class Directions(NamedTuple):
    """Three unit vectors e0, e1, e2 at right angles."""

    x0: float
    y0: float
    z0: float
    x1: float
    y1: float
    z1: float
    x2: float
    y2: float
    z2: float


class Axes(NamedTuple):
    """Eigenvalues a0 <= a1 <= a2, and their eigenvectors."""

    a0: float
    a1: float
    a2: float
    along: Directions


@inline
def parts_along(e: Directions, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Return (e0·v, e1·v, e2·v)."""
    return dot(e.x0, e.y0, e.z0, x, y, z), dot(e.x1, e.y1, e.z1, x, y, z), dot(e.x2, e.y2, e.z2, x, y, z)


@inline
def reverse_axes(e: Directions) -> Directions:
    """Return e2, e1, e0."""
    return Directions(e.x2, e.y2, e.z2, e.x1, e.y1, e.z1, e.x0, e.y0, e.z0)


@inline
def jacobi_rotation(p: float, q: float, mixed: float) -> tuple[float, float, float]:
    """Return (cosine, sine, tangent) of the rotation that removes the mixed term of ((p, mixed), (mixed, q))."""
    if abs(mixed) <= _NONE * (abs(p) + abs(q)):
        return 1.0, 0.0, 0.0
    theta = (q - p) / (2.0 * mixed)
    t = math.copysign(1.0, theta) / (abs(theta) + math.sqrt(theta * theta + 1.0))
    c = 1.0 / math.sqrt(t * t + 1.0)
    return c, t * c, t


@helper
def principal_axes(xx: float, yy: float, zz: float, xy: float, xz: float, yz: float) -> Axes:
    """Return the principal axes of a symmetric matrix."""
    x0, y0, z0, x1, y1, z1, x2, y2, z2 = 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0
    for _ in range(_SWEEPS):
        turned = 0.0
        c, s, t = jacobi_rotation(xx, yy, xy)
        xx, yy, xy = xx - t * xy, yy + t * xy, (0.0 if s != 0.0 else xy)
        xz, yz = c * xz - s * yz, s * xz + c * yz
        x0, y0, z0, x1, y1, z1 = (
            c * x0 - s * x1, c * y0 - s * y1, c * z0 - s * z1, s * x0 + c * x1, s * y0 + c * y1, s * z0 + c * z1,
        )  # fmt: skip
        turned += abs(s)
        c, s, t = jacobi_rotation(xx, zz, xz)
        xx, zz, xz = xx - t * xz, zz + t * xz, (0.0 if s != 0.0 else xz)
        xy, yz = c * xy - s * yz, s * xy + c * yz
        x0, y0, z0, x2, y2, z2 = (
            c * x0 - s * x2, c * y0 - s * y2, c * z0 - s * z2, s * x0 + c * x2, s * y0 + c * y2, s * z0 + c * z2,
        )  # fmt: skip
        turned += abs(s)
        c, s, t = jacobi_rotation(yy, zz, yz)
        yy, zz, yz = yy - t * yz, zz + t * yz, (0.0 if s != 0.0 else yz)
        xy, xz = c * xy - s * xz, s * xy + c * xz
        x1, y1, z1, x2, y2, z2 = (
            c * x1 - s * x2, c * y1 - s * y2, c * z1 - s * z2, s * x1 + c * x2, s * y1 + c * y2, s * z1 + c * z2,
        )  # fmt: skip
        turned += abs(s)
        if turned == 0.0:
            break
    return sort_axes(xx, yy, zz, Directions(x0, y0, z0, x1, y1, z1, x2, y2, z2))


@inline
def sort_axes(xx: float, yy: float, zz: float, along: Directions) -> Axes:
    """Return three eigenvalues and their vectors in rising order."""
    x0, y0, z0, x1, y1, z1, x2, y2, z2 = along
    if yy < xx:
        xx, yy, x0, y0, z0, x1, y1, z1 = yy, xx, x1, y1, z1, x0, y0, z0
    if zz < yy:
        yy, zz, x1, y1, z1, x2, y2, z2 = zz, yy, x2, y2, z2, x1, y1, z1
    if yy < xx:
        xx, yy, x0, y0, z0, x1, y1, z1 = yy, xx, x1, y1, z1, x0, y0, z0
    return Axes(xx, yy, zz, Directions(x0, y0, z0, x1, y1, z1, x2, y2, z2))


@inline
def perpendicular_axes(x: float, y: float, z: float) -> tuple[float, float, float, float, float, float]:
    """Return two unit vectors perpendicular to a unit vector and to each other (Duff and others, JCGT 6(1), 2017)."""
    sign = math.copysign(1.0, z)
    a = -1.0 / (sign + z)
    b = x * y * a
    return 1.0 + sign * x * x * a, sign * b, -sign * x, b, sign + y * y * a, -y
