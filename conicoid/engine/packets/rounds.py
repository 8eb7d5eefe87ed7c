"""The two rounds in which a packet meets the leaves of a crowd (`crowd`).

In the first each lane meets what it enters first, in the second what is left before its nearest hit. Groups of eight
lanes whose beams meet no box are left out; beams end where no lane of the group goes on.
"""

from __future__ import annotations

from ...compiler.jit import helper, inline
from ..body.scratch import Scratch
from ..culling import (
    BOX_OR_BALL,
    CODE,
    ENTERED,
    LAST,
    lanes_entering,
    put_entries,
    put_groups,
)
from ..tables import Floats, Geometry, Signs, whole
from ..tree.leaf import leaf_at, leaf_range
from .crowd import HAS_MET, ITEM, MET, leaves_of, put_leaves, settle_crowd
from .lanes import ALL, BEAM_AT, EARLIEST, GROUPS_AT, T_MAX, WITHIN, end_groups, put_slopes, shorten_beam
from .packet import PAIRS, Packet, meet_in_pairs, retire

_ABOUT = 1e-6  # share of t: boxes that a ray enters this close to each other are entered together
_OFTEN = 8  # after so many leaves the beams of groups are shortened


@inline
def _end_beams(lanes: Floats) -> None:
    """EARLIEST is where lanes end, by their intervals or their nearest hits, and the beams of groups end there."""
    for i in range(ALL):
        lanes[EARLIEST + i] = min(lanes[T_MAX + i], lanes[WITHIN + i])
    end_groups(lanes, EARLIEST)


@inline
def _put_leaf(packet: Packet, number: int, pairs: int) -> int:
    """Pair a leaf of the lot with the groups whose beams meet it, behind so many pairs; returns how many there are."""
    k = packet.crowd.asked[ITEM + number]
    return pairs + put_groups(packet.items, k, number, packet.lanes, GROUPS_AT, packet.asked, PAIRS + pairs)


@inline
def _enter(packet: Packet, first: int, pairs: int) -> None:
    """Find where the groups enter the boxes they are paired with, from pair `first` on; EARLIEST holds the earliest."""
    crowd, lanes = packet.crowd, packet.lanes
    for n in range(first, pairs):
        pair = packet.asked[PAIRS + n]
        put_entries(lanes, EARLIEST, packet.items, crowd.asked[ITEM + (pair >> 3)], crowd.entries, 8 * n, pair & 7)


@inline
def _first_pairs(packet: Packet, chosen: int) -> tuple[int, int, int]:
    """The leaves among the chosen items as a lot, and their pairs: EARLIEST is by when each lane has entered its first.

    Returns how many leaves and pairs there are, and how many other items, which come to be the first of those chosen.
    """
    lanes, items, asked, crowd = packet.lanes, packet.items, packet.asked, packet.crowd
    count, others, pairs, entered = 0, 0, 0, 0
    for j in range(chosen):
        k = asked[j]
        if items[CODE + k] < 0.0 and items[BOX_OR_BALL + k] >= 0.0:
            crowd.asked[ITEM + count], crowd.asked[HAS_MET + count] = k, 0
            pairs = _put_leaf(packet, count, pairs)
            count += 1
            if count % _OFTEN == 0:
                _enter(packet, entered, pairs)
                entered = pairs
                end_groups(lanes, EARLIEST)
        else:
            asked[others] = k
            others += 1
    _enter(packet, entered, pairs)
    for i in range(ALL):
        lanes[EARLIEST + i] += _ABOUT * abs(lanes[EARLIEST + i])
    return count, pairs, others


@inline
def _second_pairs(packet: Packet) -> int:
    """Pairs of what the groups meet before their nearest hits; returns how many."""
    pairs = 0
    for j in range(leaves_of(packet.crowd)):
        if packet.items[ENTERED + packet.crowd.asked[ITEM + j]] > packet.lanes[BEAM_AT + LAST]:
            break
        pairs = _put_leaf(packet, j, pairs)
    _enter(packet, 0, pairs)
    return pairs


@inline
def _find_met(packet: Packet, pairs: int, again: bool) -> None:
    """Which lanes meet the leaves of the lot in this round."""
    crowd = packet.crowd
    for j in range(leaves_of(crowd)):
        crowd.asked[MET + j] = 0
    for n in range(pairs):
        pair = packet.asked[PAIRS + n]
        row = WITHIN if again else EARLIEST
        crowd.asked[MET + (pair >> 3)] |= lanes_entering(packet.lanes, row, crowd.entries, 8 * n, pair & 7)


@helper
def meet_round(
    geometry: Geometry, scratch: Scratch, packet: Packet, blocks: Signs, any_hit: bool, chosen: int, again: bool
) -> int:
    """Intersect the leaves among the chosen items, in one of two rounds; returns how many others there are.

    It is called in two places, so that LLVM does not merge it into the walk of packets that see no crowd.
    """
    lanes, items, crowd, others = packet.lanes, packet.items, packet.crowd, chosen
    put_slopes(lanes)
    _end_beams(lanes)
    if again:
        pairs = _second_pairs(packet)
    else:
        count, pairs, others = _first_pairs(packet, chosen)
        put_leaves(crowd, count)
    _find_met(packet, pairs, again)
    for j in range(leaves_of(crowd)):
        met = crowd.asked[MET + j] & ~crowd.asked[HAS_MET + j]
        if met == 0:
            continue
        crowd.asked[HAS_MET + j] |= met
        begin, end = leaf_range(whole(items[CODE + crowd.asked[ITEM + j]]))
        at, size = leaf_at(geometry, begin), end - begin
        for item in range(size):
            meet_in_pairs(geometry, scratch, packet, blocks, at, size, item, met)
    settle_crowd(geometry, crowd, lanes)
    if any_hit:
        retire(lanes)
    shorten_beam(lanes)
    return others
