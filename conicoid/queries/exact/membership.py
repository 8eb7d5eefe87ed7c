"""Containment of points: the first body that contains each point. Leaves are closed sets, Booleans of them are exact.

The sign of a surface's value at a point is -1 inside, 0 on the surface, 1 outside. Floats decide it where their error
bounds allow, then numbers with error bounds; where these do not decide either, it is OPEN, and exact arithmetic follows
(`resolve_bodies` in doubtful_rays.py).
"""

from __future__ import annotations

import math

from ..._jit.decorators import helper, inline, kernel
from ...kernels import tables as table
from ...kernels.body.entry import collect_entries
from ...kernels.body.membership import INSIDE, entry_holds, point_ray
from ...kernels.body.scratch import Scratch, new_scratch
from ...kernels.packet.lanes import packet_row
from ...kernels.packet.points import locate_packet, new_point_memory, put_points
from ...kernels.surface.exact_crossing import OPEN, RoundingRest
from ...kernels.tables import (
    FORM_SIZE,
    PLANE,
    PLANE_SIZE,
    SPHERE,
    SPHERE_SIZE,
    Floats,
    Geometry,
    Ints,
    Signs,
    integer,
    whole,
)
from .ranks import (
    SURFACES,
    Ranks,
    RankScratch,
    blank_quadric,
    clear_ranks,
    clear_stand,
    find_leaves,
    forget_leaves,
    list_surfaces,
)

_PATIENCE = 31
"""The largest number of packets that are located point by point before the next attempt with a whole packet."""


@inline
def _is_point(x: float, y: float, z: float) -> bool:
    """Return True if a point is finite."""
    return math.isfinite(x) and math.isfinite(y) and math.isfinite(z)


@helper
def _locate_one(
    geometry: Geometry, rest: RoundingRest, scratch: Scratch, point: tuple[float, float, float], after: int
) -> tuple[int, int]:
    """Return the first body after a number that contains a point, or -1, and 1 if that is not certain."""
    x, y, z = point
    if not _is_point(x, y, z):
        return whole(-1), 0
    for k in range(collect_entries(geometry, scratch, point_ray(x, y, z))):
        body = whole(scratch.found[k])
        if body <= after:
            continue
        holds = entry_holds(geometry, rest, scratch, scratch.found[k], x, y, z)
        if holds == OPEN:
            return whole(-1), 1
        if holds == INSIDE:
            return body, 0
    return whole(-1), 0


@kernel(points="n 3", after="n|1", width="picture n", begin="0..end", end="0..n", bodies="out n", undecided="out n")
def locate_packets(
    geometry: Geometry, rest: RoundingRest, points: Floats, after: Ints, width: int, begin: int, end: int, bodies: Ints,
    undecided: Signs,
) -> None:  # fmt: skip
    """Write bodies[i], the first body after after[i] that contains points[i], or -1; still[i] = 1 if it is not certain.

    The kernel locates packets begin to end as a whole where few bodies reach the box around a packet. After a packet
    with many bodies it locates the points of the next packets one by one, for a number of packets that doubles with
    each failure.
    """
    scratch, memory, count = new_scratch(geometry), new_point_memory(), len(points)
    skipped, patience = 0, 0
    for packet in range(begin, end):
        if table.is_halted(geometry):
            return
        for row in range(8):
            first, n = packet_row(packet, row, width, count)
            for i in range(first, first + n):
                bodies[i], undecided[i] = -1, 0
        if skipped == 0 and put_points(memory, points, after, packet, width):
            if locate_packet(geometry, rest, scratch, memory, bodies, undecided):
                patience = 0
                continue
            patience = min(2 * patience + 1, _PATIENCE)
            skipped = patience + 1
        skipped = max(0, skipped - 1)
        for row in range(8):
            first, n = packet_row(packet, row, width, count)
            for i in range(first, first + n):
                if table.is_halted(geometry):
                    return
                place = points[i, 0], points[i, 1], points[i, 2]
                bodies[i], undecided[i] = _locate_one(
                    geometry, rest, scratch, place, integer_of(after, i if len(after) > 1 else 0)
                )


@inline
def integer_of(numbers: Ints, i: int) -> int:
    """Return an item of an array of integers as int64."""
    return whole(numbers[i])


@kernel(ranks="out")
def surfaces_near(geometry: Geometry, ranks: Ranks, x: float, y: float, z: float) -> int:
    """Write the surfaces that decide which bodies contain a point to ranks.surfaces, and return their number."""
    scratch, ray = new_scratch(geometry), point_ray(x, y, z)
    list_surfaces(geometry, scratch, ranks, ray, collect_entries(geometry, scratch, ray), True)
    found = ranks.size[SURFACES]
    clear_ranks(ranks)
    return found


@inline
def _put_constant(stand: Geometry, surface: int, where: float) -> None:
    """Write a record of a surface whose value at the origin is `where`: -1, 0 or 1."""
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
        _, form = blank_quadric(stand, row)
        f[form + FORM_SIZE - 1] = -where


@kernel(room="out")
def located_by_ranks(geometry: Geometry, room: RankScratch, x: float, y: float, z: float, after: int) -> int:
    """Return the first body after a number that contains a point, by the signs in ranks.verdict, or -1.

    room.rest must be 0, since the constants that stand for surfaces have no rounding errors.
    """
    no_rest, stand, ranks = room
    scratch, ray, body = new_scratch(geometry), point_ray(x, y, z), whole(-1)
    count = collect_entries(geometry, scratch, ray)
    list_surfaces(geometry, scratch, ranks, ray, count, True)
    for k in range(ranks.size[SURFACES]):
        _put_constant(stand, ranks.surfaces[k], float(ranks.verdict[ranks.surfaces[k]]))
    for k in range(count):
        if whole(scratch.found[k]) <= after:
            continue
        find_leaves(geometry, scratch, scratch.found[k], ray)
        if entry_holds(stand, no_rest, scratch, scratch.found[k], 0.0, 0.0, 0.0) == INSIDE:
            body = whole(scratch.found[k])
            break
    forget_leaves(scratch)
    clear_stand(stand, ranks)
    return body


__all__ = ["locate_packets", "located_by_ranks", "surfaces_near"]
