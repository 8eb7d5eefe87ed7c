"""Crowds: many small bodies before one packet, each met by few of its lanes.

Eight lanes take nearly as long as forty to meet a body: what is done once for all of them, and waiting for one result
after the other. So where a packet sees a crowd, Boolean bodies wait in pairs with the lanes that may meet them, until
64 pairs fill the lanes of `alike`, which has another body in each; the formulas are the same, and so are the bits.
They wait in two rounds: first each lane with the bodies whose boxes its ray enters first, then, the nearest hits being
known, with those that are left before these.

Whether there is a crowd is guessed from the packet before, which lies beside: each counts the Boolean bodies that it
sees, and the lanes that may meet them. A wrong guess costs time and changes no bit.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..._jit.decorators import allocator, helper, inline
from ..bvh.culling import FIRST, lowest_bit
from ..bvh.culling_constants import MOST_CHOSEN
from ..tables import Floats, Geometry, whole
from .csg_gather import (
    BodyQueue,
    body_hit,
    count_forms,
    empty_queue,
    form_of,
    meet_bodies,
    new_bodies,
    put_body,
    queue_body,
)
from .lanes import (
    ALL,
    BEAM_AT,
    BEST,
    DOUBT,
    DX,
    DY,
    DZ,
    INVERSE,
    LANES,
    OX,
    OY,
    OZ,
    START,
    T_MAX,
    T_MIN,
    WITHIN,
    keep_nearer,
)

FEW = 24
"""So many lanes of a packet wait in pairs with a body; more meet it side by side."""
_KEPT = 1 << 12
"""Programs whose forms are kept at a time, as memory for those of all would take long to clear for a few rays."""
_LEAST = 16
"""Fewer bodies are no crowd."""
_MANY_LANES = 16.0
"""Bodies that so many lanes may meet in the mean are no crowd: they are large."""

_BODIES, _MET, _CROWDED, _READY, _LEAVES = 0, 1, 2, 3, 4
"""In `known`: how many Boolean bodies the packet has seen, with how many lanes in all; is it a crowd; are its rays
copied; how many leaves the lot has that is met now."""
ITEM, HAS_MET, MET = 0, MOST_CHOSEN, 2 * MOST_CHOSEN
"""In `asked`: the leaves of a lot, the lanes that each has met, and those that it meets in this round."""


class Crowd(NamedTuple):
    """Memory of a crowd."""

    bodies: BodyQueue
    rays: Floats  # eight numbers of each lane, as `meet_bodies` takes them
    more: Floats
    known: Floats
    asked: Any  # int64: see `ITEM`
    entries: Floats  # where groups of lanes enter the boxes that they are paired with, eight numbers each


@allocator
def new_crowd(geometry: Geometry) -> Crowd:
    """Memory for one thread."""
    return Crowd(
        new_bodies(geometry, _KEPT), np.zeros(8 * LANES), np.zeros(8 * LANES), np.zeros(5),
        np.zeros(3 * MOST_CHOSEN, np.int64), np.zeros(LANES * MOST_CHOSEN),
    )  # fmt: skip


@inline
def open_crowd(crowd: Crowd, lanes: Floats, items: int) -> bool:
    """A packet begins, before which there are so many items: does it see a crowd, as the one before did?

    Pairs rely on rays that do not begin before their origins.
    """
    known = crowd.known
    found = known[_BODIES] >= _LEAST and known[_MET] < _MANY_LANES * known[_BODIES] and items > 0
    known[_CROWDED] = 1.0 if found and lanes[BEAM_AT + FIRST] >= 0.0 else 0.0
    known[_BODIES] = known[_MET] = known[_READY] = 0.0
    return is_crowded(crowd)


@inline
def is_crowded(crowd: Crowd) -> bool:
    """Is the packet traced now, or last, taken for one that sees a crowd?"""
    return crowd.known[_CROWDED] != 0.0


@inline
def note_body(crowd: Crowd, met: int) -> None:
    """So many lanes may meet a Boolean body."""
    crowd.known[_BODIES] += 1.0
    crowd.known[_MET] += met


@inline
def put_lot_leaves(crowd: Crowd, count: int) -> None:
    """So many leaves are in the lot that is met now."""
    crowd.known[_LEAVES] = count


@inline
def count_lot_leaves(crowd: Crowd) -> int:
    """How many leaves are in the lot that is met now."""
    return whole(crowd.known[_LEAVES])


@inline
def _put_rays(crowd: Crowd, lanes: Floats) -> None:
    """The lanes as rays of `meet_bodies`."""
    rays, more = crowd.rays, crowd.more
    for i in range(ALL):
        at = np.uint64(8) * i
        rays[at], rays[at + np.uint64(1)], rays[at + np.uint64(2)] = lanes[OX + i], lanes[OY + i], lanes[OZ + i]
        rays[at + np.uint64(6)], more[at + np.uint64(5)] = lanes[T_MIN + i], lanes[T_MAX + i]
        more[at], more[at + np.uint64(1)], more[at + np.uint64(2)] = lanes[DX + i], lanes[DY + i], lanes[DZ + i]
        more[at + np.uint64(3)], more[at + np.uint64(4)] = lanes[INVERSE + i], lanes[START + i]
        rays[at + np.uint64(7)] = lanes[T_MAX + i]
        _put_best(more, lanes, i)
    crowd.known[_READY] = 1.0


@inline
def _put_best(more: Floats, lanes: Floats, i: Any) -> None:
    """How far away what a lane has met is, and how uncertain that is."""
    at, best = np.uint64(8) * i, lanes[BEST + i]
    more[at + np.uint64(6)] = best
    more[at + np.uint64(7)] = lanes[WITHIN + i] - best if best < math.inf else 0.0


@helper
def _settle(geometry: Geometry, crowd: Crowd, lanes: Floats, form: int) -> None:
    """Test the pairs that wait of a form; each lane keeps the nearer hits."""
    bodies, more = crowd.bodies, crowd.more
    count = empty_queue(bodies, form)
    if count == 0:
        return
    for i in range(ALL):
        _put_best(more, lanes, i)
    for n in range(meet_bodies(geometry, bodies, form, crowd.rays, more, count)):
        lane: Any = np.uint64(queue_body(bodies, form, n)[0])
        hit = body_hit(geometry, bodies, form, n)
        if hit.unsure:
            lanes[DOUBT + lane] = 1.0
        elif hit.t < math.inf:
            keep_nearer(lanes, lane, hit)


@helper
def settle_crowd(geometry: Geometry, crowd: Crowd, lanes: Floats) -> None:
    """Test all pairs that wait."""
    for form in range(count_forms(crowd.bodies)):
        _settle(geometry, crowd, lanes, form)


@helper
def put_pairs(geometry: Geometry, crowd: Crowd, lanes: Floats, program: int, entry: int, met: int) -> bool:
    """The lanes of a mask wait for a Boolean body; False if it is of no form that is met in pairs."""
    form = form_of(geometry, crowd.bodies, program)
    if form < 0:
        return False
    if crowd.known[_READY] == 0.0:
        _put_rays(crowd, lanes)
    while met != 0:
        lane = lowest_bit(met)
        met &= met - 1
        if put_body(crowd.bodies, form, lane, entry):
            _settle(geometry, crowd, lanes, form)
    return True
