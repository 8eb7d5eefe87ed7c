"""Whitted's method for 64 pixels at a time: what their rays meet first, and its shadows, go in packets.

Rays that are mirrored or refracted scatter; they are followed one by one. The formulas are those of
`whitted`, so the colours are the same to the bit.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..geometry.tables import Floats, Geometry, Ints, Signs, whole
from ..jit import allocator, helper, inline
from ..shading.local import light_at
from ..shading.look import Look
from ..shading.materials import material_row
from ..shading.shadow import through_glass
from ..trace.lanes import (
    BEST,
    LANES,
    T_MAX,
    lane_hit,
    lane_ray,
    prepare_lanes,
    put_beam_from,
    put_idle,
    put_lane_beam,
    put_ray,
)  # fmt: skip
from ..trace.packet import Packet, trace_packet
from ..trace.scratch import Scratch
from .stack import NO_SURFACE, Stack
from .whitted import Sight, facing, follow, shade, shows_light, sight_of, sky

_NUMBERS = 13


class Wave(NamedTuple):
    """What the packet's rays have met. A row a lane."""

    rays: Floats  # (64, 6) origins and directions
    sights: Floats  # (64, 13) see `Sight`
    arrived: Floats  # (64 · lights · 3) how much of each light reaches them
    medium: Ints  # (64,) what they start in
    asks: Signs  # (64,) 1 where it matters whether a light is seen
    colors: Floats  # (64, 3) what comes back


@allocator
def new_wave(lights: int) -> Wave:
    """Memory for one thread."""
    return Wave(
        np.empty((LANES, 6)), np.empty((LANES, _NUMBERS)), np.empty(3 * max(1, lights) * LANES),
        np.empty(LANES, np.int32), np.empty(LANES, np.int8), np.empty((LANES, 3)),
    )  # fmt: skip


@inline
def _keep(row: Floats, sight: Sight) -> None:
    row[0], row[1], row[2], row[3], row[4], row[5], row[6] = (
        sight[0], sight[1], sight[2], sight[3], sight[4], sight[5], sight[6],
    )  # fmt: skip
    row[7], row[8], row[9], row[10], row[11], row[12] = sight[7], sight[8], sight[9], sight[10], sight[11], sight[12]


@inline
def _kept(row: Floats) -> Sight:
    return (
        row[0], whole(row[1]), whole(row[2]), whole(row[3]), whole(row[4]), whole(row[5]), whole(row[6]),
        row[7], row[8], row[9], row[10], row[11], row[12],
    )  # fmt: skip


@helper
def _look(geometry: Geometry, scratch: Scratch, packet: Packet, wave: Wave, look: Look, count: int) -> None:
    """What the first `count` rays meet."""
    lanes = packet.lanes
    for i in range(LANES):
        ray = wave.rays[min(i, count - 1)]
        put_ray(lanes, i, (ray[0], ray[1], ray[2], ray[3], ray[4], ray[5], 0.0, math.inf, NO_SURFACE))
    for i in range(count, LANES):
        put_idle(lanes, i, 0)
    prepare_lanes(lanes)
    put_lane_beam(lanes)
    trace_packet(geometry, scratch, packet, scratch.nothing, False)
    for i in range(count):
        ray = wave.rays[i]
        hit = lane_hit(lanes, i)
        sight = sight_of(
            geometry, scratch, look.materials, ray[0], ray[1], ray[2], ray[3], ray[4], ray[5], NO_SURFACE, hit
        )
        _keep(wave.sights[i], sight)


@inline
def _material(geometry: Geometry, look: Look, sight: Sight) -> int:
    return material_row(geometry, look.materials, sight[1], sight[3])


@helper
def _shadow_rays(geometry: Geometry, packet: Packet, wave: Wave, look: Look, k: int, count: int) -> int:
    """Rays to light k from where it may be seen into the lanes; returns one of them, or -1 if there is none."""
    lanes, light, some = packet.lanes, look.lights[k], -1
    for i in range(count):
        sight, ray = _kept(wave.sights[i]), wave.rays[i]
        wave.asks[i] = 0
        if sight[1] < 0:
            continue
        dx, dy, dz = ray[3], ray[4], ray[5]
        nx, ny, nz, _, from_inside = facing(sight, dx, dy, dz)
        if not shows_light(look.materials, sight, from_inside):
            continue
        row = look.materials.rows[_material(geometry, look, sight)]
        x, y, z = sight[7], sight[8], sight[9]
        lx, ly, lz, end, _, _, part = light_at(light, row, x, y, z, nx, ny, nz, -dx, -dy, -dz)
        if part != 0.0:
            put_ray(lanes, i, (x, y, z, lx, ly, lz, 0.0, end, sight[2]))
            wave.asks[i], some = 1, i
    return some


@helper
def _ask_light(
    geometry: Geometry, scratch: Scratch, packet: Packet, wave: Wave, look: Look, k: int, count: int
) -> None:
    """How much of light k reaches what the rays have met."""
    lanes, materials = packet.lanes, look.materials
    some = _shadow_rays(geometry, packet, wave, look, k, count)
    if some < 0:
        return
    for i in range(LANES):
        if i >= count or wave.asks[i] == 0:
            put_idle(lanes, i, some)
    prepare_lanes(lanes)
    put_lane_beam(lanes)
    light = look.lights[k]
    if light.parallel == 0:
        put_beam_from(lanes, light.position[0], light.position[1], light.position[2])
    trace_packet(geometry, scratch, packet, materials.opaque, True)
    for i in range(count):
        if wave.asks[i] == 0:
            continue
        at = 3 * (len(look.lights) * i + k)
        open_way = 0.0 if lanes[BEST + np.uint64(i)] < math.inf else 1.0
        wave.arrived[at], wave.arrived[at + 1], wave.arrived[at + 2] = open_way, open_way, open_way
        if open_way == 1.0 and materials.any_transparent:
            x, y, z, lx, ly, lz, _, end, start = lane_ray(lanes, i, lanes[T_MAX + np.uint64(i)])
            wave.arrived[at], wave.arrived[at + 1], wave.arrived[at + 2] = through_glass(
                geometry, scratch, materials, x, y, z, lx, ly, lz, end, start, whole(wave.sights[i, 5])
            )


@helper
def whitted_wave(
    geometry: Geometry, scratch: Scratch, packet: Packet, stack: Stack, wave: Wave, look: Look, depth: int, count: int,
    arrived: Floats,
) -> None:  # fmt: skip
    """Add to the colours of the first `count` rays what comes back along them, after at most `depth` turns.

    arrived: memory for the light on surfaces further on, 3 for each light.
    """
    _look(geometry, scratch, packet, wave, look, count)
    lights = len(look.lights)
    for k in range(lights):
        _ask_light(geometry, scratch, packet, wave, look, k, count)
    for i in range(count):
        sight, dx, dy, dz = _kept(wave.sights[i]), wave.rays[i, 3], wave.rays[i, 4], wave.rays[i, 5]
        if sight[1] < 0:
            r, g, b = sky(look, whole(wave.medium[i]), dz, 1.0, 1.0, 1.0)
        else:
            r, g, b, size = shade(
                geometry, look, stack, 0, depth, 0, sight, wave.arrived, 3 * lights * i, dx, dy, dz, 1.0, 1.0, 1.0
            )
            if size > 0:
                red, green, blue = follow(geometry, scratch, stack, size, look, depth, arrived)
                r, g, b = r + red, g + green, b + blue
        wave.colors[i, 0] += r
        wave.colors[i, 1] += g
        wave.colors[i, 2] += b
