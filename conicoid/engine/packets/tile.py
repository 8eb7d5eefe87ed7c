"""Tiles: sixteen packets side by side, 32 x 32 pixels of a picture or 1024 rays of a list.

What they have in common is found once: the beam that holds all of their rays, what it sees of the scene, and
whether they have one origin, as those of most cameras do.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...compiler.jit import allocator, helper, inline
from ..culling import BEAM, FIRST, HIGH_I, HIGH_O, LAST, LOW_I, LOW_O, prefetch, widen
from ..ray import RayArrays
from ..tables import Floats, Geometry
from ..tree.walk import reciprocal, scene_tree
from .frontier import Level, find_frontier, narrow_frontier, new_frontier, new_level
from .lanes import LANES, lane_sight, put_origin
from .load import packet_row, packets_across

_SIDE = 4
PACKETS = _SIDE * _SIDE
_ORIGINS, _DIRECTIONS = 0, 48
_QUARTERS = 4
_WHOLE = _QUARTERS * BEAM

_HORIZON, _FURTHEST, _HITS, _RAYS = 0, 1, 2, 3
"""How far a tile is expected to see, its furthest hit so far, how many hits, of how many rays."""


class Tile(NamedTuple):
    """Memory of a tile."""

    extremes: Floats  # see `widen`: of origins, of directions, for each quarter
    beams: Floats  # of the quarters, and of the whole tile
    seen: Floats  # a frontier
    level: Level
    sight: Floats  # see `_HORIZON`


@allocator
def new_tile() -> Tile:
    """Memory for one thread."""
    return Tile(
        np.empty(_QUARTERS * 96),
        np.empty((_QUARTERS + 1) * BEAM),
        new_frontier(),
        new_level(),
        np.array([math.inf, 0.0, 0.0, 0.0]),
    )


@inline
def tile_count(width: int, count: int) -> int:
    """How many tiles `count` rays make, of a picture of some width or (0) of a list."""
    if width == 0:
        return -(-count // (PACKETS * LANES))
    across, down = packets_across(width), -(-count // (8 * width))
    return -(-across // _SIDE) * -(-down // _SIDE)


@inline
def tile_packet(tile: int, k: int, width: int, count: int) -> int:
    """Packet k of a tile, quarter by quarter; -1 if there is none."""
    if width == 0:
        packet = PACKETS * tile + k
        return packet if packet * LANES < count else -1
    across = packets_across(width)
    tiles = -(-across // _SIDE)
    x = _SIDE * (tile % tiles) + (k & 1) + 2 * (k >> 2 & 1)
    y = _SIDE * (tile // tiles) + (k >> 1 & 1) + 2 * (k >> 3)
    return y * across + x if x < across and 8 * y * width < count else -1


@inline
def _extend(points: Floats, i: int, extremes: Floats, at: int) -> None:
    """Point i joins the extremes."""
    for axis in range(3):
        value = points[i, axis]
        if value < extremes[at + axis]:
            extremes[at + axis] = value
        if value > extremes[at + 24 + axis]:
            extremes[at + 24 + axis] = value


@inline
def _extent(extremes: Floats, at: int, axis: int) -> tuple[float, float]:
    """(least, greatest) of an axis, from 24 extremes each."""
    low, high = math.inf, -math.inf
    for k in range(axis, 24, 3):
        low, high = min(low, extremes[at + k]), max(high, extremes[at + 24 + k])
    return low, high


@inline
def _put_extremes(extremes: Floats, at: int, rays: RayArrays, tile: int, quarter: int, width: int) -> None:
    """The extremes of origins and directions of the rays in a quarter of a tile."""
    origins, directions = rays.origins, rays.directions
    for k in range(24):
        for begin in (at + _ORIGINS, at + _DIRECTIONS):
            extremes[begin + k], extremes[begin + 24 + k] = math.inf, -math.inf
    for k in range(4 * quarter, 4 * quarter + 4):
        packet = tile_packet(tile, k, width, len(origins))
        if packet < 0:
            continue
        for row in range(8):
            i, n = packet_row(packet, row, width, len(origins))
            if n == 8:
                widen(origins, i, extremes, at + _ORIGINS)
                widen(directions, i, extremes, at + _DIRECTIONS)
            else:
                for j in range(i, i + n):
                    _extend(origins, j, extremes, at + _ORIGINS)
                    _extend(directions, j, extremes, at + _DIRECTIONS)


@inline
def _put_beam(beams: Floats, at: int, extremes: Floats, first: int, last: int) -> bool:
    """The beam of the rays with their extremes at extremes[first:last:96]. True if they have one origin."""
    shared = True
    for axis in range(3):
        low, high, least, most = math.inf, -math.inf, math.inf, -math.inf
        for begin in range(first, last, 96):
            a, b = _extent(extremes, begin + _ORIGINS, axis)
            c, d = _extent(extremes, begin + _DIRECTIONS, axis)
            low, high, least, most = min(low, a), max(high, b), min(least, c), max(most, d)
        beams[at + LOW_O + axis], beams[at + HIGH_O + axis] = low, high
        beams[at + LOW_I + axis], beams[at + HIGH_I + axis] = reciprocal(least), reciprocal(most)
        shared &= low == high
    beams[at + FIRST], beams[at + LAST] = 0.0, math.inf
    return shared


@helper
def open_tile(geometry: Geometry, tile: Tile, lanes: Floats, rays: RayArrays, number: int, width: int) -> bool:
    """Find the frontier of a tile (t >= 0). True if all its rays share an origin, which is in all lanes then."""
    beams, sight = tile.beams, tile.sight
    sight[_HORIZON] = sight[_FURTHEST] if 2.0 * sight[_HITS] > sight[_RAYS] else math.inf
    sight[_FURTHEST] = sight[_HITS] = sight[_RAYS] = 0.0
    for quarter in range(_QUARTERS):
        _put_extremes(tile.extremes, 96 * quarter, rays, number, quarter, width)
    shared = _put_beam(beams, _WHOLE, tile.extremes, 0, 96 * _QUARTERS)
    find_frontier(geometry, tile.seen, tile.level, beams, _WHOLE, scene_tree(geometry), sight[_HORIZON])
    if shared:
        put_origin(lanes, beams[_WHOLE + LOW_O] + 0.0, beams[_WHOLE + LOW_O + 1] + 0.0, beams[_WHOLE + LOW_O + 2] + 0.0)
    return shared


@inline
def note_sight(tile: Tile, lanes: Floats) -> None:
    """How far a traced packet of the tile has seen: tiles are expected to see as far as the one before."""
    furthest, hits = lane_sight(lanes)
    sight = tile.sight
    sight[_FURTHEST] = max(sight[_FURTHEST], furthest)
    sight[_HITS] += hits
    sight[_RAYS] += LANES


@helper
def open_quarter(tile: Tile, quarter: int, seen: Floats) -> None:
    """Narrow the frontier of an open tile to one of its quarters."""
    _put_beam(tile.beams, BEAM * quarter, tile.extremes, 96 * quarter, 96 * quarter + 96)
    narrow_frontier(tile.seen, tile.beams, BEAM * quarter, seen)


@inline
def ask_for_packet(rays: RayArrays, packet: int, width: int) -> None:
    """Prefetch a packet's rays, if there is one."""
    origins, directions = rays.origins, rays.directions
    for row in range(8 if packet >= 0 else 0):
        i, n = packet_row(packet, row, width, len(origins))
        if n > 0:
            for k in (0, 8, 16):
                prefetch(origins, 3 * i + k)
                prefetch(directions, 3 * i + k)
