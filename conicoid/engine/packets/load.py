"""Rays out of a user's arrays: one by one, or 64 into the lanes of a packet.

Where the rays make a picture a packet is a square of 8 x 8 of its pixels, else 64 in a row.
"""

from __future__ import annotations

import math

import numpy as np

from ...compiler.jit import helper, inline
from .. import tables as table
from ..culling import FIRST, HIGH_O, LOW_O, extent, load_eight
from ..ray import DEAD, RayArrays
from ..tables import Floats, Geometry
from .lanes import (
    BEAM_AT,
    DX,
    INVERSE,
    LANES,
    LEAST_START,
    OX,
    OY,
    OZ,
    SOME_START,
    SPREAD,
    START,
    T_MAX,
    T_MIN,
    prepare_lanes,
    put_idle,
    put_lane_beam,
    put_limits,
    put_line,
)

_SEVERAL = 4.0


@inline
def packets_across(width: int) -> int:
    """How many packets lie side by side in a picture."""
    return (width + 7) >> 3


@inline
def packet_row(packet: int, row: int, width: int, count: int) -> tuple[int, int]:
    """(first ray, how many) of one of the eight rows of a packet, of a picture of some width or (0) of a list."""
    if width == 0:
        i = LANES * packet + 8 * row
        return i, max(0, min(8, count - i))
    across = packets_across(width)
    x, y = 8 * (packet % across), 8 * (packet // across) + row
    return y * width + x, min(8, width - x) if y * width < count else 0


@inline
def fill_lanes(lanes: Floats, rays: RayArrays, packet: int, width: int, shared: bool) -> None:
    """The rays of a packet into its lanes; those beyond the end are idle. `shared`: all have their origin already."""
    origins, directions, t_min, t_max, starts = rays
    one_min, one_max, one_start = len(t_min) == 1, len(t_max) == 1, len(starts) == 1
    put_limits(lanes, t_min[0], t_max[0], starts[0])
    for row in range(8):
        i, n = packet_row(packet, row, width, len(origins))
        if n == 8:
            if not shared:
                load_eight(origins, i, lanes, OX + np.uint64(8 * row))
            load_eight(directions, i, lanes, DX + np.uint64(8 * row))
        else:
            for k in range(n):
                put_line(lanes, 8 * row + k, origins, directions, i + k)
        if not (one_min and one_max and one_start):
            for k in range(n):
                lane = np.uint64(8 * row + k)
                lanes[T_MIN + lane] = t_min[0 if one_min else i + k]
                lanes[T_MAX + lane] = t_max[0 if one_max else i + k]
                lanes[START + lane] = starts[0 if one_start else i + k]
        for k in range(n, 8):
            put_idle(lanes, 8 * row + k, 0)
    prepare_lanes(lanes)
    put_lane_beam(lanes, shared)


@inline
def ordinary(lanes: Floats) -> bool:
    """May the rays be traced as a packet?

    Not if one is far from unit length, or begins before its origin; except for lines that are parallel and do not
    start on a surface.
    """
    shortest, longest = extent(lanes, INVERSE)
    usual = shortest > 1e-60 and longest < 1e60 and lanes[LEAST_START] != DEAD
    if lanes[BEAM_AT + FIRST] < 0.0:
        usual &= lanes[SOME_START] == 0.0 and lanes[SPREAD] == 0.0
    return usual


@helper
def coherent(geometry: Geometry, lanes: Floats) -> bool:
    """Are the rays of a packet coherent: do they see about the same part of the scene?

    Their origins and, at the far end of the scene, their points must lie within a few times the
    size that a body has when the scene's box is shared out among all.
    """
    if not ordinary(lanes):
        return False
    at, floats = geometry.places[table.EXTENT], geometry.floats
    diagonal, cell = floats[at], floats[at + 1]
    ox, oy, oz = lanes[OX] - floats[at + 2], lanes[OY] - floats[at + 3], lanes[OZ] - floats[at + 4]
    reach = math.sqrt(ox * ox + oy * oy + oz * oz) + 0.5 * diagonal
    apart = 0.0
    for axis in range(3):
        apart += lanes[BEAM_AT + HIGH_O + axis] - lanes[BEAM_AT + LOW_O + axis]
    return lanes[SPREAD] * math.sqrt(lanes[INVERSE]) * reach + apart <= _SEVERAL * cell
