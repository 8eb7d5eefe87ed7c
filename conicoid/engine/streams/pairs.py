"""Rays of a stream and balls that they may meet, pair by pair: 64 are tested at once, in lanes.

A pair is a lane, whatever leaf the ball is from. It is tested by the formulas of `meet.try_ball`, to the same bits;
which hit is nearer is decided afterwards, one pair after the other, since two may have the same ray.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ...compiler.jit import allocator, helper, inline
from ..body.ball import ball_event
from ..body.cell import NO_PLACE
from ..body.hit import Hit
from ..culling import records_in_lanes
from ..ray import Line, Ray
from ..surface.nearness import along, lengths_of_ball
from ..surface.quadric import Sphere, sphere_roots
from ..tables import Floats, Geometry, whole
from ..tree.leaf import leaf_ball, leaf_item

MOST = 64

# Rows of 64 lanes: the two records of a ray (`stream`), the ball, what comes out
(
    OX, OY, OZ, _IX, _IY, _IZ, T_MIN, _LAST, DX, DY, DZ, INVERSE, START, T_MAX, _BEST, _OFF,
    X, Y, Z, RADIUS, SURFACE, BODY, ENTRY, T, ERROR, ENTERS, UNSURE,
) = (np.uint64(row) for row in range(0, 27 * MOST, MOST))  # fmt: skip
_SECOND = 8 * MOST


class Pairs(NamedTuple):
    """Pairs that wait to be tested."""

    lanes: Floats
    rays: Any  # (64,) int64: their rays


@allocator
def new_pairs() -> Pairs:
    """Memory for one thread."""
    return Pairs(np.zeros(27 * MOST), np.zeros(MOST, np.int64))


@inline
def put_pair(pairs: Pairs, at: int, ray: int, geometry: Geometry, leaf: int, size: int, place: int) -> None:
    """Pair number `at`: a ray of a stream, and the ball that stands at a place of a leaf of some size."""
    lanes, i = pairs.lanes, np.uint64(at)
    pairs.rays[i] = ray
    ball, item = leaf_ball(geometry, leaf, size, place), leaf_item(geometry, leaf, size, place)
    lanes[X + i], lanes[Y + i], lanes[Z + i], lanes[RADIUS + i] = ball
    lanes[SURFACE + i], lanes[BODY + i], lanes[ENTRY + i] = float(item.index), float(item.body), float(item.entry)


@helper
def meet_pairs(pairs: Pairs, rays: Floats, more: Floats, count: int) -> None:
    """Where the rays of the first `count` pairs meet their balls; `rays` and `more` hold eight numbers of each ray."""
    lanes, numbers = pairs.lanes, pairs.rays
    for k in range(count, (count + 7) & -8):
        numbers[k] = numbers[0]
    for k in range(0, count, 8):
        records_in_lanes(rays, numbers, k, lanes, k)
        records_in_lanes(more, numbers, k, lanes, _SECOND + k)
    for i in range(np.uint64(count + 7) & np.uint64(120)):
        _test_lane(lanes, i)


@inline
def _test_lane(lanes: Floats, i: Any) -> None:
    """Intersect the ray of a pair with its ball, without branches."""
    line = Line(lanes[OX + i], lanes[OY + i], lanes[OZ + i], lanes[DX + i], lanes[DY + i], lanes[DZ + i])
    sphere, inverse = Sphere(lanes[X + i], lanes[Y + i], lanes[Z + i], lanes[RADIUS + i]), lanes[INVERSE + i]
    t_min, t_max, start = lanes[T_MIN + i], lanes[T_MAX + i], lanes[START + i]
    starts = start == lanes[SURFACE + i]
    nearness = along(
        Ray(line.ox, line.oy, line.oz, line.dx, line.dy, line.dz, t_min, t_max, start), inverse, lengths_of_ball(sphere)
    )
    roots = sphere_roots(sphere, line, inverse, starts)
    t, enters, unsure = ball_event(roots, starts, t_min, t_max, nearness)
    lanes[T + i], lanes[ERROR + i] = t, nearness.off
    lanes[ENTERS + i] = 1.0 if enters else 0.0
    lanes[UNSURE + i] = 1.0 if unsure else 0.0


@inline
def pair_hit(pairs: Pairs, at: int) -> Hit:
    """The crossing of pair number `at`; t = inf if the ray does not meet the ball."""
    lanes, i = pairs.lanes, np.uint64(at)
    return Hit(
        lanes[T + i], whole(lanes[BODY + i]), whole(lanes[ENTRY + i]), whole(NO_PLACE), whole(1),
        lanes[ENTERS + i] == 1.0, lanes[ERROR + i], lanes[UNSURE + i] == 1.0,
    )  # fmt: skip
