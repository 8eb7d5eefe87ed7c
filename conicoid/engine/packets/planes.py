"""Planes of cells met by the lanes of a packet (see lane_cells.py)."""

from __future__ import annotations

import math

from ...compiler.jit import choose, helper, inline
from ..surface.nearness import Nearness
from ..surface.plane import Limits, Plane, careful_plane, plain_plane, runs_along, unsure_of_plane
from ..tables import Floats
from .lanes import (
    DX,
    DY,
    DZ,
    FLAG,
    INVERSE,
    OX,
    OY,
    OZ,
    PLACE_IN,
    PLACE_OUT,
    SHARED,
    START,
    T_IN,
    T_OUT,
    UNSURE,
    A,
    B,
    eights,
    lane_nearness,
)


@helper
def _cut_lanes(lanes: Floats, lengths: Nearness, surface: int, side: int, place: int, first: int, last: int) -> None:
    """Cut the spans by a plane whose height and rate stand in A and B; FLAG 2: rounding may have changed them too much.

    UNSURE becomes 1 where it may have changed the order of two planes, 2 where it may have changed more.
    """
    first, last = eights(first, last)
    for i in range(first, last):
        rate, before, after = lanes[B + i], lanes[T_IN + i], lanes[T_OUT + i]
        height = 0.0 if lanes[START + i] == surface else lanes[A + i]
        t = -height / rate
        parallel = rate == 0.0
        outside = parallel & ((height <= 0.0) != (side > 0))
        falls = ((rate < 0.0) == (side > 0)) & ~parallel
        rises = ((rate < 0.0) != (side > 0)) & ~parallel
        close = abs(t - choose(falls, before, after)) <= lane_nearness(lanes, i, lengths)[0]
        later = falls & (t > before)
        sooner = rises & (t < after)
        lanes[T_IN + i] = choose(outside, math.inf, choose(later, t, before))
        lanes[T_OUT + i] = choose(outside, -math.inf, choose(sooner, t, after))
        lanes[PLACE_IN + i] = place if later else lanes[PLACE_IN + i]
        lanes[PLACE_OUT + i] = place if sooner else lanes[PLACE_OUT + i]
        unsure = max(lanes[UNSURE + i], choose(close, 1.0, 0.0))
        lanes[UNSURE + i] = choose(lanes[FLAG + i] == 2.0, 2.0, unsure)


@inline
def _plane_of_lane(lanes: Floats, i: int, ox: float, oy: float, oz: float, plane: Plane, limits: Limits) -> int:
    """A lane's height and rate into A and B; returns 1, as FLAG, where they are to be done again with care."""
    height, rate, cancels, parallel = plain_plane(plane, ox, oy, oz, lanes[DX + i], lanes[DY + i], lanes[DZ + i])
    cancels |= unsure_of_plane(height, rate, parallel, lanes[INVERSE + i], limits)
    lanes[A + i], lanes[B + i] = height, rate
    lanes[FLAG + i] = 1.0 if cancels else 0.0
    return 1 if cancels else 0


@inline
def plane_lanes(
    lanes: Floats, plane: Plane, limits: Limits, lengths: Nearness, surface: int, side: int, place: int,
    first: int, last: int,
) -> None:  # fmt: skip
    """Cut the lanes' spans [T_IN, T_OUT] by a plane of a cell."""
    again, x, y, z = 0, lanes[OX], lanes[OY], lanes[OZ]
    if lanes[SHARED] != 0.0:
        for i in range(first, last):
            again += _plane_of_lane(lanes, i, x, y, z, plane, limits)
    else:
        for i in range(first, last):
            again += _plane_of_lane(lanes, i, lanes[OX + i], lanes[OY + i], lanes[OZ + i], plane, limits)
    if again > 0:
        for i in range(first, last):
            if lanes[FLAG + i] == 1.0:
                height, rate = careful_plane(
                    plane, lanes[OX + i], lanes[OY + i], lanes[OZ + i], lanes[DX + i], lanes[DY + i], lanes[DZ + i]
                )
                parallel = runs_along(plane, lanes[DX + i], lanes[DY + i], lanes[DZ + i])
                unsure = unsure_of_plane(height, rate, parallel, lanes[INVERSE + i], limits)
                lanes[A + i], lanes[B + i], lanes[FLAG + i] = height, rate, 2.0 if unsure else 1.0
    _cut_lanes(lanes, lengths, surface, side, place, first, last)
