"""A point brought onto surfaces, and how far the exact one may be from it."""

from __future__ import annotations

import math
from typing import NamedTuple

from ...compiler.jit import helper, inline
from .. import tables as table
from ..numbers.vectors import dot
from ..surface.records import load_quadric
from ..tables import QUADRIC, Geometry, integer
from .form import Form, form_at, length_of
from .room import Room

TANGENT = 2.0**-22
"""Sine below which surfaces count as tangent to each other."""
_ROUNDS = 12
_POOR = 2.0**-40
"""Share of its size from which on a point that may be the apex of a cone is taken for it."""


class Touch(NamedTuple):
    """A point on surfaces, by how much it may be off, and the sine of the least angle between the surfaces there."""

    x: float
    y: float
    z: float
    off: float
    sine: float


class _Frame(NamedTuple):
    """A unit vector along what a gradient adds to those before it, and how much of it that is."""

    x: float
    y: float
    z: float
    sine: float


@inline
def _beyond(form: Form, ux: float, uy: float, uz: float, vx: float, vy: float, vz: float) -> _Frame:
    """The part of a gradient that is across two unit vectors, or zeros in their place."""
    g = length_of(form.gx, form.gy, form.gz)
    if g == 0.0:
        return _Frame(0.0, 0.0, 0.0, 0.0)
    x, y, z = form.gx / g, form.gy / g, form.gz / g
    along = dot(x, y, z, ux, uy, uz)
    x, y, z = x - along * ux, y - along * uy, z - along * uz
    along = dot(x, y, z, vx, vy, vz)
    x, y, z = x - along * vx, y - along * vy, z - along * vz
    sine = length_of(x, y, z)
    if sine == 0.0:
        return _Frame(0.0, 0.0, 0.0, 0.0)
    return _Frame(x / sine, y / sine, z / sine, sine)


@inline
def apart(form: Form) -> float:
    """About how far f = 0 is at most, by value and gradient; where it is flat, by its bend."""
    value, g = abs(form.value) + form.off, length_of(form.gx, form.gy, form.gz)
    if g * g > 4.0 * form.size * value:
        return value / (2.0 * g) * 1.25
    return math.sqrt(value / form.size) if form.size > 0.0 else math.inf


@inline
def _step(form: Form, frame: _Frame, done: float) -> float:
    """How far to go along a frame so that the linear f vanishes, after steps that changed f by 2 g `done`."""
    g = length_of(form.gx, form.gy, form.gz)
    if frame.sine < TANGENT or g == 0.0:
        return 0.0
    return (-form.value / (2.0 * g) - done) / frame.sine


@helper
def touch(geometry: Geometry, room: Room, count: int, x: float, y: float, z: float) -> Touch:
    """Bring a point onto the first `count` of room.chosen, 1 to 3 surfaces, by Newton's steps of least length."""
    off, sine = 0.0, 1.0
    for k in range(_ROUNDS):
        one = form_at(geometry, room.surface[room.chosen[0]], x, y, z)
        a = _beyond(one, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        go = _step(one, a, 0.0)
        mx, my, mz = go * a.x, go * a.y, go * a.z
        off, sine = apart(one), 1.0
        if count > 1:
            two = form_at(geometry, room.surface[room.chosen[1]], x, y, z)
            b = _beyond(two, a.x, a.y, a.z, 0.0, 0.0, 0.0)
            go = _step(two, b, _done(two, mx, my, mz))
            mx, my, mz = mx + go * b.x, my + go * b.y, mz + go * b.z
            off, sine = _together(off + apart(two), two, b.sine), min(sine, b.sine)
            if count > 2:
                three = form_at(geometry, room.surface[room.chosen[2]], x, y, z)
                c = _beyond(three, a.x, a.y, a.z, b.x, b.y, b.z)
                go = _step(three, c, _done(three, mx, my, mz))
                mx, my, mz = mx + go * c.x, my + go * c.y, mz + go * c.z
                off, sine = _together(off + apart(three), three, c.sine), min(sine, c.sine)
        if k + 1 == _ROUNDS or (k > 1 and abs(mx) + abs(my) + abs(mz) <= 2.0**-53 * (abs(x) + abs(y) + abs(z))):
            break
        x, y, z = x + mx, y + my, z + mz
    off += 2.0**-51 * (abs(x) + abs(y) + abs(z))
    for k in range(count):
        if off > _POOR * (abs(x) + abs(y) + abs(z)):
            x, y, z, off = _at_apex(geometry, room, count, k, x, y, z, off)
    return Touch(x, y, z, off, sine)


@helper
def _at_apex(
    geometry: Geometry, room: Room, count: int, k: int, x: float, y: float, z: float, off: float
) -> tuple[float, float, float, float]:
    """The apex of chosen cone k, if the point may be it and all others are planes; else the point itself.

    Beside its apex a cone has no gradient that would tell how near it is. A plane as near to the apex as rounding takes
    it cuts the cone about as near, unless it runs along the cone.
    """
    surface = room.surface[room.chosen[k]]
    if integer(geometry, table.SURFACE_KIND, surface) != QUADRIC:
        return x, y, z, off
    quadric = load_quadric(geometry, integer(geometry, table.SURFACE_ROW, surface))
    ax, ay, az, _, _, _, _, _, _, _, _, _, _, _, _, b0, b1, b2, constant = quadric
    is_cone = (b0 == 0.0) & (b1 == 0.0) & (b2 == 0.0) & (constant == 0.0)
    if not is_cone or length_of(ax - x, ay - y, az - z) > 8.0 * off:
        return x, y, z, off
    apex = 2.0**-51 * (abs(ax) + abs(ay) + abs(az))
    for i in range(count):
        if i != k:
            form = form_at(geometry, room.surface[room.chosen[i]], ax, ay, az)
            if form.size > 0.0:
                return x, y, z, off
            apex += 64.0 * apart(form)
    return (ax, ay, az, apex) if apex < off else (x, y, z, off)


@inline
def _done(form: Form, x: float, y: float, z: float) -> float:
    """What a step does to the linear f, over 2 |g|."""
    g = length_of(form.gx, form.gy, form.gz)
    return dot(form.gx, form.gy, form.gz, x, y, z) / g if g > 0.0 else 0.0


@inline
def _together(off: float, form: Form, sine: float) -> float:
    """How far off a point on several surfaces may be: more, the smaller their angle; at most as for touching ones."""
    g = length_of(form.gx, form.gy, form.gz)
    radius = g / form.size if form.size > 0.0 else math.inf
    most = math.sqrt(off * radius) if radius < math.inf else math.inf
    return min(off / sine, max(off, 4.0 * most)) if sine > 0.0 else max(off, 4.0 * most)
