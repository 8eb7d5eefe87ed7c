"""A square of pixels: packets of many samples, which see about the same, share a frontier.

The first packet goes down the tree from its roots. For the second a frontier is found (`frontier`), of a beam a little
wider than its own; those that follow use it as long as their beams lie within that one, and else widen it. Rays from
what they meet to a light may do the same, with a square of their own: their beam begins at the light.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...compiler.jit import allocator, helper, inline
from ..body.scratch import Scratch
from ..culling import BEAM, FIRST, HIGH_I, HIGH_O, LAST, LOW_I, LOW_O
from ..tables import Floats, Geometry, Signs
from ..tree.walk import reciprocal, scene_tree
from .first import trace_packet
from .frontier import Level, find_frontier, new_frontier, new_level
from .lanes import BEAM_AT, LANES, WAYS_AT, lane_sight
from .packet import Packet, with_items

_MARGIN = 0.25
"""Share of a packet's extent by which the beam is wider at each side: samples lie anywhere in their pixels."""
_MOST = 4
"""So often a frontier is looked for: packets whose beams differ more than that go down the tree each by itself."""

# In `known`: the corners of origins and of directions, whose square it is, how many packets and how many frontiers
# there were, and how far the first packet saw
_LOW_O, _HIGH_O, _LOW_D, _HIGH_D = 0, 3, 6, 9
_NUMBER, _PACKETS, _FOUND, _HORIZON = 12, 13, 14, 15


class Square(NamedTuple):
    """Memory of a square."""

    items: Floats  # a frontier
    known: Floats  # see above
    beam: Floats
    level: Level


@allocator
def new_square() -> Square:
    """Memory for one thread."""
    known = np.zeros(16)
    known[_NUMBER] = -1.0
    return Square(new_frontier(), known, np.empty(BEAM), new_level())


@inline
def _holds(known: Floats, lanes: Floats) -> bool:
    """Does the beam of a packet lie within that of the frontier?"""
    inside = True
    for axis in range(3):
        inside &= known[_LOW_O + axis] <= lanes[BEAM_AT + LOW_O + axis]
        inside &= known[_HIGH_O + axis] >= lanes[BEAM_AT + HIGH_O + axis]
        inside &= known[_LOW_D + axis] <= lanes[WAYS_AT + axis]
        inside &= known[_HIGH_D + axis] >= lanes[WAYS_AT + 3 + axis]
    return inside


@inline
def _widen(known: Floats, at: int, low: float, high: float, is_first: bool) -> None:
    """Let one axis of two corners hold an interval and a margin, beside what they hold already."""
    margin = _MARGIN * (high - low)
    low, high = low - margin, high + margin
    known[at] = low if is_first else min(low, known[at])
    known[at + 3] = high if is_first else max(high, known[at + 3])


@helper
def _find(geometry: Geometry, square: Square, lanes: Floats) -> None:
    """A frontier that holds for a packet, and for those before it."""
    known, beam = square.known, square.beam
    is_first = known[_FOUND] == 0.0
    known[_FOUND] += 1.0
    for axis in range(3):
        low, high = lanes[BEAM_AT + LOW_O + axis], lanes[BEAM_AT + HIGH_O + axis]
        _widen(known, _LOW_O + axis, low, high, is_first)
        _widen(known, _LOW_D + axis, lanes[WAYS_AT + axis], lanes[WAYS_AT + 3 + axis], is_first)
        beam[LOW_O + axis], beam[HIGH_O + axis] = known[_LOW_O + axis], known[_HIGH_O + axis]
        beam[LOW_I + axis], beam[HIGH_I + axis] = reciprocal(known[_LOW_D + axis]), reciprocal(known[_HIGH_D + axis])
    beam[FIRST], beam[LAST] = 0.0, math.inf
    find_frontier(geometry, square.items, square.level, beam, 0, scene_tree(geometry), known[_HORIZON])


@inline
def _follow(geometry: Geometry, square: Square, lanes: Floats, number: int) -> bool:
    """Is there a frontier for a packet of a square that has a number? Finds one, where that may pay."""
    known = square.known
    if known[_NUMBER] != number:
        known[_NUMBER], known[_PACKETS], known[_FOUND] = number, 0.0, 0.0
    known[_PACKETS] += 1.0
    if known[_PACKETS] == 1.0 or lanes[BEAM_AT + FIRST] < 0.0:
        return False
    if known[_FOUND] == 0.0 or not _holds(known, lanes):
        if known[_FOUND] >= _MOST:
            return False
        _find(geometry, square, lanes)
    return True


@inline
def trace_square(
    geometry: Geometry, scratch: Scratch, packet: Packet, square: Square, number: int, blocks: Signs, any_hit: bool
) -> None:
    """`trace_packet` of one packet of a square, which has a number; packets of another begin anew.

    Relies on the packet's beam having corners of directions (`put_lane_beam`, `put_beam_from`).
    """
    items = square.items if _follow(geometry, square, packet.lanes, number) else packet.items
    trace_packet(geometry, scratch, with_items(packet, items), blocks, any_hit)
    if square.known[_PACKETS] == 1.0:
        furthest, hits = lane_sight(packet.lanes)
        square.known[_HORIZON] = furthest if 2.0 * hits > LANES and not any_hit else math.inf
