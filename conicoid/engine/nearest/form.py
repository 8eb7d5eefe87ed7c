"""A surface as a polynomial about a point: f(x + v) = value + 2 g·v + v·A v, with what rounding may have changed."""

from __future__ import annotations

import math
from typing import NamedTuple

from ...compiler.jit import inline
from .. import tables as table
from ..numbers.vectors import dot
from ..surface.plane import Plane
from ..surface.quadric import Quadric, Sphere, quadric_gradient, quadric_rounding, quadric_value
from ..surface.records import load_plane, load_quadric, load_sphere
from ..tables import PLANE, SPHERE, Geometry, integer

ROUNDED = 2.0**-48
"""Share of its terms by which rounding may change a value: 32 roundings."""
_ANCHOR = 2.0**-52
"""Share of an anchor's coordinates that its record may be off by."""
_OF_DOUBT = 2.0**-4
"""`quadric_rounding` counts 512 roundings of a value, here 32 are enough."""


class Form(NamedTuple):
    """A surface about a point x. Of a plane A is zero, and g half the unit normal."""

    value: float
    off: float  # by how much the value may be off
    gx: float  # half the gradient
    gy: float
    gz: float
    xx: float  # A
    yy: float
    zz: float
    xy: float
    xz: float
    yz: float
    size: float  # at least |A|, as the sum of what it was summed from
    steep: float  # the same of |g|


@inline
def form_of_plane(plane: Plane, x: float, y: float, z: float) -> Form:
    """A plane about a point."""
    nx, ny, nz, above, ax, ay, az = plane
    unit = 1.0 / math.sqrt(dot(nx, ny, nz, nx, ny, nz))
    nx, ny, nz, above = nx * unit, ny * unit, nz * unit, above * unit
    px, py, pz = x - ax, y - ay, z - az
    value = dot(nx, ny, nz, px, py, pz) + above
    terms = abs(nx * px) + abs(ny * py) + abs(nz * pz) + abs(above)
    off = ROUNDED * terms + _ANCHOR * (abs(ax) + abs(ay) + abs(az))
    return Form(value, off, 0.5 * nx, 0.5 * ny, 0.5 * nz, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.5)


@inline
def form_of_sphere(sphere: Sphere, x: float, y: float, z: float) -> Form:
    """A sphere about a point."""
    cx, cy, cz, r = sphere
    px, py, pz = x - cx, y - cy, z - cz
    length = math.sqrt(dot(px, py, pz, px, py, pz))
    value = (length - r) * (length + r)
    off = ROUNDED * (length * length + r * r) + 2.0 * length * _ANCHOR * (abs(cx) + abs(cy) + abs(cz))
    return Form(value, off, px, py, pz, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, length)


@inline
def form_of_quadric(quadric: Quadric, x: float, y: float, z: float) -> Form:
    """A quadric about a point."""
    ax, ay, az, w00, w01, w02, w10, w11, w12, w20, w21, w22, s0, s1, s2, b0, b1, b2, _ = quadric
    gx, gy, gz = quadric_gradient(quadric, x, y, z)
    n0, n1, n2 = dot(w00, w01, w02, w00, w01, w02), dot(w10, w11, w12, w10, w11, w12), dot(w20, w21, w22, w20, w21, w22)
    size = abs(s0) * n0 + abs(s1) * n1 + abs(s2) * n2
    far = abs(x - ax) + abs(y - ay) + abs(z - az)
    steep = size * far + abs(b0) * math.sqrt(n0) + abs(b1) * math.sqrt(n1) + abs(b2) * math.sqrt(n2)
    off = _OF_DOUBT * quadric_rounding(quadric, x, y, z, 0.0, 0.0, 0.0)
    off += 2.0 * steep * (_ANCHOR * (abs(ax) + abs(ay) + abs(az)))
    return Form(
        quadric_value(quadric, x, y, z), off, gx, gy, gz,
        dot(s0 * w00, s1 * w10, s2 * w20, w00, w10, w20), dot(s0 * w01, s1 * w11, s2 * w21, w01, w11, w21),
        dot(s0 * w02, s1 * w12, s2 * w22, w02, w12, w22), dot(s0 * w00, s1 * w10, s2 * w20, w01, w11, w21),
        dot(s0 * w00, s1 * w10, s2 * w20, w02, w12, w22), dot(s0 * w01, s1 * w11, s2 * w21, w02, w12, w22),
        size, steep,
    )  # fmt: skip


@inline
def form_at(geometry: Geometry, surface: int, x: float, y: float, z: float) -> Form:
    """A surface about a point."""
    kind, row = integer(geometry, table.SURFACE_KIND, surface), integer(geometry, table.SURFACE_ROW, surface)
    if kind == PLANE:
        return form_of_plane(load_plane(geometry, row), x, y, z)
    if kind == SPHERE:
        return form_of_sphere(load_sphere(geometry, row), x, y, z)
    return form_of_quadric(load_quadric(geometry, row), x, y, z)


@inline
def bent(form: Form, x: float, y: float, z: float) -> tuple[float, float, float]:
    """A v"""
    return (
        dot(form.xx, form.xy, form.xz, x, y, z),
        dot(form.xy, form.yy, form.yz, x, y, z),
        dot(form.xz, form.yz, form.zz, x, y, z),
    )


@inline
def value_along(form: Form, x: float, y: float, z: float) -> float:
    """f(x + v)"""
    ax, ay, az = bent(form, x, y, z)
    return form.value + dot(2.0 * form.gx + ax, 2.0 * form.gy + ay, 2.0 * form.gz + az, x, y, z)


@inline
def rounding_within(form: Form, r: float) -> float:
    """By how much rounding may have changed f at any v up to the length r."""
    return form.off + ROUNDED * (2.0 * form.steep + form.size * r) * r


@inline
def length_of(x: float, y: float, z: float) -> float:
    """|v|, for numbers whose squares are numbers."""
    return math.sqrt(dot(x, y, z, x, y, z))
