"""Is a point inside? Leaves are closed, Boolean combinations exact.

A surface's value at a point has a sign: -1 inside, 0 on it, 1 outside, found in floats where they are certain of
it, else in numbers with error bounds; OPEN where those are not.
"""

from __future__ import annotations

import math

from ...compiler.jit import inline, kernel
from .. import tables as table
from ..body.contains import INSIDE, entry_holds, point_ray
from ..body.entry import collect
from ..body.scratch import new_scratch
from ..surface.decide import OPEN, Rest
from ..tables import PLANE, PLANE_SIZE, QUADRIC_SIZE, SPHERE, SPHERE_SIZE, Floats, Geometry, Ints, Signs, integer, whole
from .ranked import find_leaves, forget_leaves
from .ranks import SURFACES, Ranks, Room, forget, list_surfaces


@inline
def _is_point(x: float, y: float, z: float) -> bool:
    """Is a point finite?"""
    return math.isfinite(x) and math.isfinite(y) and math.isfinite(z)


@kernel(points="n 3", begin="0..end", end="0..n", bodies="out n", still="out n")
def locate(geometry: Geometry, rest: Rest, points: Floats, begin: int, end: int, bodies: Ints, still: Signs) -> None:
    """bodies[i] = the lowest-numbered body that contains points[i], or -1; still[i] = 1 where that is not certain."""
    scratch = new_scratch(geometry)
    for i in range(begin, end):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        bodies[i], still[i] = -1, 0
        if not _is_point(x, y, z) or table.halted(geometry):
            continue
        for k in range(collect(geometry, scratch, point_ray(x, y, z))):
            holds = entry_holds(geometry, rest, scratch, scratch.found[k], x, y, z)
            if holds == OPEN:
                still[i] = 1
                break
            if holds == INSIDE:
                bodies[i] = integer(geometry, table.ENTRY_BODY, scratch.found[k])
                break


@kernel(ranks="out")
def surfaces_near(geometry: Geometry, ranks: Ranks, x: float, y: float, z: float) -> int:
    """How many surfaces decide what contains a point, into ranks.surfaces."""
    scratch, ray = new_scratch(geometry), point_ray(x, y, z)
    list_surfaces(geometry, scratch, ranks, ray, collect(geometry, scratch, ray))
    found = ranks.size[SURFACES]
    forget(ranks)
    return found


@inline
def _stand_in(stand: Geometry, surface: int, where: float) -> None:
    """Write a record whose value at the origin is `where`: -1, 0 or 1."""
    f, kind = stand.floats, integer(stand, table.SURFACE_KIND, surface)
    row = integer(stand, table.SURFACE_ROW, surface)
    if kind == PLANE:
        at = stand.places[table.PLANES] + PLANE_SIZE * row
        for k in range(PLANE_SIZE):
            f[at + k] = 0.0
        f[at], f[at + 3] = 1.0, where
    elif kind == SPHERE:
        at = stand.places[table.SPHERES] + SPHERE_SIZE * row
        f[at], f[at + 1], f[at + 2], f[at + 3] = where + 1.0, 0.0, 0.0, 1.0
    else:
        at = stand.places[table.QUADRICS] + QUADRIC_SIZE * row
        for k in range(QUADRIC_SIZE):
            f[at + k] = 0.0
        f[at + 18] = -where


@kernel(room="out")
def locate_ranked(geometry: Geometry, room: Room, x: float, y: float, z: float) -> int:
    """The lowest-numbered body that contains a point, on the sides in ranks.verdict. Relies on room.rest being 0."""
    nothing, stand, ranks = room
    scratch, ray, body = new_scratch(geometry), point_ray(x, y, z), whole(-1)
    count = collect(geometry, scratch, ray)
    list_surfaces(geometry, scratch, ranks, ray, count)
    for k in range(ranks.size[SURFACES]):
        _stand_in(stand, ranks.surfaces[k], float(ranks.verdict[ranks.surfaces[k]]))
    for k in range(count):
        find_leaves(geometry, scratch, scratch.found[k], ray)
        if entry_holds(stand, nothing, scratch, scratch.found[k], 0.0, 0.0, 0.0) == INSIDE:
            body = integer(geometry, table.ENTRY_BODY, scratch.found[k])
            break
    forget_leaves(scratch)
    forget(ranks)
    return body


__all__ = ["locate", "locate_ranked", "surfaces_near"]
