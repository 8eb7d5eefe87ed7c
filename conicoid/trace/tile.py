"""Tiles: sixteen packets side by side, 32 x 32 pixels of a picture or 1024 rays of a list.

What they have in common is found once: the beam that holds all of their rays, what it sees of the scene, and
whether they have one origin, as those of most cameras do.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..geometry.tables import Floats, Geometry
from ..jit import allocator, helper, inline
from .bundle import packet_row, packets_across
from .frontier import Frontier, find_frontier
from .kernels import scene_tree
from .lanes import LANES, put_origin
from .simd import BEAM, FIRST, HIGH_I, HIGH_O, LAST, LOW_I, LOW_O, prefetch, widen
from .walk import reciprocal

_SIDE = 4
PACKETS = _SIDE * _SIDE
_ORIGINS, _DIRECTIONS = 0, 48


class Tile(NamedTuple):
    """Memory of a tile."""

    extremes: Floats  # see `widen`: of origins, of directions
    beam: Floats


@allocator
def new_tile() -> Tile:
    """Memory for one thread."""
    return Tile(np.empty(2 * 48), np.empty(BEAM))


@inline
def tile_count(width: int, count: int) -> int:
    """How many tiles `count` rays make, of a picture of some width or (0) of a list."""
    if width == 0:
        return -(-count // (PACKETS * LANES))
    across, down = packets_across(width), -(-count // (8 * width))
    return -(-across // _SIDE) * -(-down // _SIDE)


@inline
def tile_packet(tile: int, k: int, width: int, count: int) -> int:
    """Packet k of a tile, -1 if there is none."""
    if width == 0:
        packet = PACKETS * tile + k
        return packet if LANES * packet < count else -1
    across = packets_across(width)
    tiles = -(-across // _SIDE)
    x, y = _SIDE * (tile % tiles) + k % _SIDE, _SIDE * (tile // tiles) + k // _SIDE
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
    low, high = math.inf, -math.inf
    for k in range(axis, 24, 3):
        low, high = min(low, extremes[at + k]), max(high, extremes[at + 24 + k])
    return low, high


@inline
def _put_extremes(tile: Tile, origins: Floats, directions: Floats, number: int, width: int) -> None:
    for k in range(24):
        for at in (_ORIGINS, _DIRECTIONS):
            tile.extremes[at + k], tile.extremes[at + 24 + k] = math.inf, -math.inf
    for k in range(PACKETS):
        packet = tile_packet(number, k, width, len(origins))
        if packet < 0:
            continue
        for row in range(8):
            i, n = packet_row(packet, row, width, len(origins))
            if n == 8:
                widen(origins, i, tile.extremes, _ORIGINS)
                widen(directions, i, tile.extremes, _DIRECTIONS)
            else:
                for j in range(i, i + n):
                    _extend(origins, j, tile.extremes, _ORIGINS)
                    _extend(directions, j, tile.extremes, _DIRECTIONS)


@helper
def open_tile(
    geometry: Geometry, near: Floats, tile: Tile, frontier: Frontier, lanes: Floats,
    origins: Floats, directions: Floats, number: int, width: int,
) -> bool:  # fmt: skip
    """Find what a tile sees (t >= 0). True if all its rays have one origin, which all lanes have got then."""
    _put_extremes(tile, origins, directions, number, width)
    beam, shared = tile.beam, True
    for axis in range(3):
        beam[LOW_O + axis], beam[HIGH_O + axis] = _extent(tile.extremes, _ORIGINS, axis)
        low, high = _extent(tile.extremes, _DIRECTIONS, axis)
        beam[LOW_I + axis], beam[HIGH_I + axis] = reciprocal(low), reciprocal(high)
        shared &= beam[LOW_O + axis] == beam[HIGH_O + axis]
    beam[FIRST], beam[LAST] = 0.0, math.inf
    find_frontier(geometry, frontier, near, beam, scene_tree(geometry))
    if shared:
        put_origin(lanes, beam[LOW_O] + 0.0, beam[LOW_O + 1] + 0.0, beam[LOW_O + 2] + 0.0)
    return shared


@inline
def ask_for_packet(origins: Floats, directions: Floats, packet: int, width: int) -> None:
    """Ask for the memory of a packet's rays, if there is one."""
    for row in range(8 if packet >= 0 else 0):
        i, n = packet_row(packet, row, width, len(origins))
        if n > 0:
            for k in (0, 8, 16):
                prefetch(origins, 3 * i + k)
                prefetch(directions, 3 * i + k)
