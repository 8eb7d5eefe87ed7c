"""The sides of a polygon that is clipped, tried as nearest walls."""

from __future__ import annotations

import math

from ...compiler.jit import helper, inline
from .. import tables as table
from ..numbers.vectors import dot
from ..tables import Geometry, integer
from .form import bent, form_at
from .outline import corner, nearest_of_side
from .room import SURFACES, WITHIN, Room
from .walls import Query, try_point


@inline
def _try(geometry: Geometry, room: Room, at: Query, x: float, y: float, z: float) -> None:
    room.chosen[0] = 0
    try_point(geometry, room, at, 1, x, y, z, math.inf, 0.0)


@helper
def _try_crossings(
    geometry: Geometry, room: Room, at: Query, ax: float, ay: float, az: float, bx: float, by: float, bz: float
) -> None:
    """Try where a side, from a to b, meets what clips its polygon."""
    dx, dy, dz = bx - ax, by - ay, bz - az
    for k in range(1, room.sizes[SURFACES]):
        form = form_at(geometry, room.surface[k], at.x + ax, at.y + ay, at.z + az)
        ux, uy, uz = bent(form, dx, dy, dz)
        a, b = dot(ux, uy, uz, dx, dy, dz), dot(form.gx, form.gy, form.gz, dx, dy, dz)
        square = b * b - a * form.value
        if square < 0.0:
            continue
        far = -(b + math.copysign(math.sqrt(square), b))
        for which in range(2):
            over, under = (far, a) if which == 0 else (form.value, far)
            t = over / under if under != 0.0 else -1.0
            if 0.0 <= t <= 1.0:
                _try(geometry, room, at, ax + t * dx, ay + t * dy, az + t * dz)


@helper
def try_sides(geometry: Geometry, room: Room, at: Query, polygon: int) -> None:
    """Try the sides of a polygon, their ends, and where they meet what clips it."""
    room.sizes[WITHIN] = 0
    first, last = integer(geometry, table.POLYGON_FIRST, polygon), integer(geometry, table.POLYGON_FIRST, polygon + 1)
    ax, ay, az = corner(geometry, last - 1, at.x, at.y, at.z)
    for vertex in range(first, last):
        bx, by, bz = corner(geometry, vertex, at.x, at.y, at.z)
        x, y, z = nearest_of_side(ax, ay, az, bx, by, bz)
        _try(geometry, room, at, x, y, z)
        _try(geometry, room, at, bx, by, bz)
        _try_crossings(geometry, room, at, ax, ay, az, bx, by, bz)
        ax, ay, az = bx, by, bz
