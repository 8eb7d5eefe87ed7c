"""Crowds: many small Boolean bodies before one packet, each hit by few of its lanes.

Eight lanes take nearly as long as forty to intersect a body: the work that is shared by all lanes, and the latency of
one result after the other, stay the same. So where a packet sees a crowd, Boolean bodies queue in pairs with the lanes
that may meet them, until 64 pairs fill the lanes of csg_gather.py, which has another body in each lane; the formulas
are the same, and so are the bits. They queue in two rounds: first each lane with the bodies whose boxes its ray enters
first, then, once nearest hits are known, with those that remain before these hits.

Whether a packet sees a crowd is predicted from the packet before, which lies beside it: each counts the Boolean bodies
that it sees, and the lanes that may meet them. A wrong prediction costs time and changes no bit.

User: pictures of thousands of small Boolean bodies; factor: 1.4 to 1.9 where a body is one or two pixels wide, 1.0 to
1.2 where it is larger.
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
"""Most lanes of a packet that queue in pairs with a body; more lanes intersect it side by side."""
_KEPT = 1 << 12
"""Programs whose forms are cached at a time; memory for all programs would take long to clear for a few rays."""
_LEAST = 16
"""Least number of bodies of a crowd."""
_MANY_LANES = 16.0
"""Bodies that at least this many lanes may meet on average are no crowd: they are large."""

_BODIES, _LANE_SUM, _CROWDED, _READY, _LEAVES = 0, 1, 2, 3, 4
"""Elements of `known`: number of Boolean bodies that the packet has seen; sum of the lanes that may meet them; 1 for a
crowd; 1 if the packet's rays are copied; number of leaves in the current lot."""
ITEM, TRACED_BITS, LANE_BITS = 0, MOST_CHOSEN, 2 * MOST_CHOSEN
"""Sections of a crowd's integers: leaves of a lot, lanes that have hit each, lanes that hit it in this round."""


class Crowd(NamedTuple):
    """Memory of a crowd."""

    bodies: BodyQueue
    rays: Floats  # eight numbers of each lane, as `meet_bodies` takes them
    more: Floats  # eight more of each lane
    known: Floats  # see `_BODIES`
    queue: Any  # int64: see `ITEM`
    entries: Floats  # t at which a group of lanes enters the box of its pair, eight numbers each


@allocator
def new_crowd(geometry: Geometry) -> Crowd:
    """Return memory of crowds for one thread."""
    return Crowd(
        new_bodies(geometry, _KEPT), np.zeros(8 * LANES), np.zeros(8 * LANES), np.zeros(5),
        np.zeros(3 * MOST_CHOSEN, np.int64), np.zeros(LANES * MOST_CHOSEN),
    )  # fmt: skip


@inline
def open_crowd(crowd: Crowd, lanes: Floats, items: int) -> bool:
    """Start a packet with a frontier of `items` items; return True if it shall be traced as seeing a crowd.

    That is the case if the packet before saw one. Pairs rely on rays that do not begin before their origins.
    """
    counts = crowd.known
    is_crowd = counts[_BODIES] >= _LEAST and counts[_LANE_SUM] < _MANY_LANES * counts[_BODIES] and items > 0
    counts[_CROWDED] = 1.0 if is_crowd and lanes[BEAM_AT + FIRST] >= 0.0 else 0.0
    counts[_BODIES] = counts[_LANE_SUM] = counts[_READY] = 0.0
    return is_crowded(crowd)


@inline
def is_crowded(crowd: Crowd) -> bool:
    """True if the current packet, or else the last one, is traced as seeing a crowd."""
    return crowd.known[_CROWDED] != 0.0


@inline
def note_body(crowd: Crowd, count: int) -> None:
    """Count a Boolean body that `count` lanes may meet."""
    crowd.known[_BODIES] += 1.0
    crowd.known[_LANE_SUM] += count


@inline
def put_lot_leaves(crowd: Crowd, count: int) -> None:
    """Set the number of leaves in the current lot."""
    crowd.known[_LEAVES] = count


@inline
def count_lot_leaves(crowd: Crowd) -> int:
    """Return the number of leaves in the current lot."""
    return whole(crowd.known[_LEAVES])


@inline
def _put_rays(crowd: Crowd, lanes: Floats) -> None:
    """Copy the lanes to rays for `meet_bodies`."""
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
    """Copy the t of a lane's nearest hit, and its error bound."""
    at, best = np.uint64(8) * i, lanes[BEST + i]
    more[at + np.uint64(6)] = best
    more[at + np.uint64(7)] = lanes[WITHIN + i] - best if best < math.inf else 0.0


@helper
def _settle(geometry: Geometry, crowd: Crowd, lanes: Floats, form: int) -> None:
    """Intersect the queued pairs of a form; each lane keeps its nearest hit."""
    bodies, more = crowd.bodies, crowd.more
    count = empty_queue(bodies, form)
    if count == 0:
        return
    for i in range(ALL):  # hits since the rays were copied
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
    """Intersect all queued pairs."""
    for form in range(count_forms(crowd.bodies)):
        _settle(geometry, crowd, lanes, form)


@helper
def put_pairs(geometry: Geometry, crowd: Crowd, lanes: Floats, program: int, entry: int, bits: int) -> bool:
    """Queue the lanes of a mask with a Boolean body; False if its form cannot be intersected in pairs."""
    form = form_of(geometry, crowd.bodies, program)
    if form < 0:
        return False
    if crowd.known[_READY] == 0.0:
        _put_rays(crowd, lanes)
    while bits != 0:
        lane = lowest_bit(bits)
        bits &= bits - 1
        if put_body(crowd.bodies, form, lane, entry):
            _settle(geometry, crowd, lanes, form)
    return True
