"""Whitted's method for 64 pixels at a time: what their rays meet first, and its shadows, go in packets.

Rays that are mirrored or refracted scatter; they are followed one by one. The formulas are those of
`whitted`, so the colours are the same to the bit. Hits in doubt are taken as they are, here and in `path`: what is in
doubt grazes a surface, or meets two within rounding, and either answer is right for a picture (docs/light.md).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..compiler.jit import allocator, helper, inline
from ..emitters.lamplight import Lamplight
from ..engine.body.scratch import Scratch
from ..engine.packets.first import trace_packet
from ..engine.packets.lanes import (
    BEST,
    DX,
    DY,
    DZ,
    LANES,
    T_MAX,
    lane_hit,
    lane_ray,
    prepare_lanes,
    put_beam_from,
    put_idle,
    put_lane_beam,
    put_ray,
)
from ..engine.packets.load import coherent
from ..engine.packets.packet import new_lanes, with_lanes
from ..engine.ray import with_limits
from ..engine.single.first import first_crossing
from ..engine.tables import Floats, Geometry, whole
from ..shading.local import shadow_ray, shown
from ..shading.look import Look
from ..shading.materials import Materials
from ..shading.media import OUTSIDE
from ..shading.relief import has_relief, is_behind
from ..shading.shadow import light_along
from ..shading.sight import Sight
from .lamps import lamp_count, lamp_ray
from .samples import Samples, Settings, trace_samples
from .stack import Pending, Stack, new_stack
from .whitted import follow, medium_at, shade, sight_of, sky

_MEDIUM, _ASKS, _LAMP = 13, 14, 15
"""Columns behind a sight: the medium that the ray starts in; 1 where a shadow ray is needed, else 0; the body of the
lamp that this is to meet."""
_NUMBERS = 16


class Wave(NamedTuple):
    """What a packet of rays has met. A row a lane."""

    stack: Stack  # rays that are mirrored or refracted
    shadow: Floats  # the lanes of rays from what they meet to a light
    sights: Floats  # (64, _NUMBERS) what they meet, see `Sight`, and more
    arrived: Floats  # (64 · (lights + lamps) · 3) how much of each light and lamp reaches what they meet
    further: Floats  # ((lights + lamps) · 3) how much reaches what a mirrored or refracted ray meets


@allocator
def new_memory(geometry: Geometry, settings: Settings) -> Wave:
    """Memory for one thread."""
    numbers = 3 * max(1, len(settings.look.look.lights) + lamp_count(settings.look.lamps))
    return Wave(
        new_stack(settings.depth), new_lanes(), np.empty((LANES, _NUMBERS)), np.empty(numbers * LANES),
        np.empty(numbers),
    )  # fmt: skip


@inline
def _keep(row: Floats, sight: Sight) -> None:
    """Write a sight into a row."""
    row[0], row[1], row[2], row[3], row[4], row[5], row[6] = (
        sight.t, sight.body, sight.surface, sight.face, sight.side, sight.before, sight.after,
    )  # fmt: skip
    row[7], row[8], row[9], row[10], row[11], row[12] = sight.x, sight.y, sight.z, sight.nx, sight.ny, sight.nz


@inline
def _kept(row: Floats) -> Sight:
    """The sight in a row."""
    return Sight(
        row[0], whole(row[1]), whole(row[2]), whole(row[3]), whole(row[4]), whole(row[5]), whole(row[6]),
        row[7], row[8], row[9], row[10], row[11], row[12],
    )  # fmt: skip


@helper
def _begin(geometry: Geometry, scratch: Scratch, wave: Wave, materials: Materials, samples: Samples) -> None:
    """The media that the rays start in."""
    for i in range(samples.size):
        wave.sights[i, _MEDIUM] = OUTSIDE
        if materials.any_transparent:
            x, y, z, _, _, _, _, _, _ = lane_ray(samples.packet.lanes, i, 0.0)
            wave.sights[i, _MEDIUM] = medium_at(geometry, scratch, materials, x, y, z)


@inline
def _direction(lanes: Floats, i: int) -> tuple[float, float, float]:
    """The direction of the ray in lane i."""
    lane = np.uint64(i)
    return lanes[DX + lane], lanes[DY + lane], lanes[DZ + lane]


@helper
def _see(geometry: Geometry, scratch: Scratch, wave: Wave, look: Look, samples: Samples) -> None:
    """What the rays meet."""
    lanes = samples.packet.lanes
    trace_samples(geometry, scratch, samples)
    for i in range(samples.size):
        sight = sight_of(geometry, scratch, look.materials, lane_ray(lanes, i, math.inf), lane_hit(lanes, i))
        _keep(wave.sights[i], sight)


@helper
def _shadow_rays(geometry: Geometry, wave: Wave, look: Look, k: int, stride: int, samples: Samples) -> int:
    """Shadow rays to light k into the lanes of sights that it may light; returns one of them, or -1 for none."""
    lanes, light, some = wave.shadow, look.lights[k], -1
    for i in range(samples.size):
        sight = _kept(wave.sights[i])
        wave.sights[i, _ASKS] = 0.0
        if sight.body < 0:
            continue
        dx, dy, dz = _direction(samples.packet.lanes, i)
        shows, row, point = shown(geometry, look.materials, sight, dx, dy, dz)
        if not shows:
            continue
        ray, asked = shadow_ray(light, look.materials.rows[row], point, sight.surface)
        if asked and has_relief(look.materials.rows[row]) and is_behind(sight, dx, dy, dz, ray.dx, ray.dy, ray.dz):
            at, asked = 3 * (stride * i + k), False
            wave.arrived[at], wave.arrived[at + 1], wave.arrived[at + 2] = 0.0, 0.0, 0.0
        if asked:
            put_ray(lanes, i, ray)
            wave.sights[i, _ASKS], some = 1.0, i
    return some


@helper
def _ask_light(
    geometry: Geometry, scratch: Scratch, wave: Wave, look: Look, k: int, stride: int, samples: Samples
) -> None:
    """How much of light k reaches what the rays have met; stride: of how many lights and lamps it is one."""
    lanes, materials, light, count = wave.shadow, look.materials, look.lights[k], samples.size
    some = _shadow_rays(geometry, wave, look, k, stride, samples)
    if some < 0:
        return
    for i in range(LANES):
        if i >= count or wave.sights[i, _ASKS] == 0.0:
            put_idle(lanes, i, some)
    prepare_lanes(lanes)
    put_lane_beam(lanes, False)
    if light.parallel == 0:
        put_beam_from(lanes, light.position[0], light.position[1], light.position[2])
    if coherent(geometry, lanes):
        trace_packet(geometry, scratch, with_lanes(samples.packet, lanes), materials.opaque, True)
    else:
        for i in range(count):
            if wave.sights[i, _ASKS] != 0.0:
                lane = np.uint64(i)
                ray = lane_ray(lanes, i, lanes[T_MAX + lane])
                lanes[BEST + lane] = first_crossing(geometry, scratch, ray, materials.opaque, True).t
    for i in range(count):
        if wave.sights[i, _ASKS] == 0.0:
            continue
        at, inside = 3 * (stride * i + k), _kept(wave.sights[i]).before
        ray, covered = lane_ray(lanes, i, lanes[T_MAX + np.uint64(i)]), lanes[BEST + np.uint64(i)] < math.inf
        wave.arrived[at], wave.arrived[at + 1], wave.arrived[at + 2] = light_along(
            geometry, scratch, materials, ray, inside, covered
        )


@helper
def _lamp_rays(geometry: Geometry, wave: Wave, lit: Lamplight, j: int, seed: int, stride: int, samples: Samples) -> int:
    """Rays to the j-th lamp that is asked into the lanes of sights that it may light; one of these, or -1 for none."""
    lanes, look, some = wave.shadow, lit.look, -1
    for i in range(samples.size):
        at, sight = 3 * (stride * i + len(look.lights) + j), _kept(wave.sights[i])
        wave.sights[i, _ASKS] = 0.0
        wave.arrived[at], wave.arrived[at + 1], wave.arrived[at + 2] = 0.0, 0.0, 0.0
        if sight.body < 0:
            continue
        dx, dy, dz = _direction(samples.packet.lanes, i)
        shows, row, point = shown(geometry, look.materials, sight, dx, dy, dz)
        if not shows:
            continue
        random = seed, samples.pixels[i], samples.sample
        ray, body, asked = lamp_ray(lit, j, random, sight, look.materials.rows[row], point, dx, dy, dz)
        if asked:
            put_ray(lanes, i, ray)
            wave.sights[i, _ASKS], wave.sights[i, _LAMP], some = 1.0, body, i
    return some


@helper
def _ask_lamp(
    geometry: Geometry, scratch: Scratch, wave: Wave, lit: Lamplight, j: int, seed: int, stride: int, samples: Samples
) -> None:
    """How much of the j-th lamp that is asked reaches what the rays have met."""
    lanes, materials = wave.shadow, lit.look.materials
    some = _lamp_rays(geometry, wave, lit, j, seed, stride, samples)
    if some < 0:
        return
    for i in range(LANES):
        if i >= samples.size or wave.sights[i, _ASKS] == 0.0:
            put_idle(lanes, i, some)
    prepare_lanes(lanes)
    put_lane_beam(lanes, False)
    together = coherent(geometry, lanes)
    if together:
        trace_packet(geometry, scratch, with_lanes(samples.packet, lanes), materials.opaque, False)
    for i in range(samples.size):
        if wave.sights[i, _ASKS] == 0.0:
            continue
        ray = lane_ray(lanes, i, lanes[T_MAX + np.uint64(i)])
        if together:
            hit = lane_hit(lanes, i)
        else:
            hit = first_crossing(geometry, scratch, ray, materials.opaque, False)
        at, inside = 3 * (stride * i + len(lit.look.lights) + j), _kept(wave.sights[i]).before
        ray = with_limits(ray, 0.0, min(ray.t_max, hit.t))
        wave.arrived[at], wave.arrived[at + 1], wave.arrived[at + 2] = light_along(
            geometry, scratch, materials, ray, inside, hit.body != whole(wave.sights[i, _LAMP])
        )


@helper
def gather(geometry: Geometry, scratch: Scratch, wave: Wave, settings: Settings, samples: Samples) -> None:
    """Add what comes back along the rays, after at most `settings.depth` turns."""
    lit, depth, stack, colors = settings.look, settings.depth, wave.stack, samples.colors
    look = lit.look
    _begin(geometry, scratch, wave, look.materials, samples)
    _see(geometry, scratch, wave, look, samples)
    stride = len(look.lights) + lamp_count(lit.lamps)
    for k in range(len(look.lights)):
        _ask_light(geometry, scratch, wave, look, k, stride, samples)
    for j in range(lamp_count(lit.lamps)):
        _ask_lamp(geometry, scratch, wave, lit, j, settings.seed, stride, samples)
    for i in range(samples.size):
        sight = _kept(wave.sights[i])
        x, y, z, dx, dy, dz, _, _, start = lane_ray(samples.packet.lanes, i, math.inf)
        ray = Pending(x, y, z, dx, dy, dz, 1.0, 1.0, 1.0, start, depth, whole(wave.sights[i, _MEDIUM]))
        if sight.body < 0:
            r, g, b = sky(look, ray.medium, dz, 1.0, 1.0, 1.0)
        else:
            random = settings.seed, samples.pixels[i], samples.sample
            r, g, b, size = shade(geometry, lit, stack, 0, ray, sight, wave.arrived, 3 * stride * i, random)
            if size > 0:
                red, green, blue = follow(geometry, scratch, stack, size, lit, wave.further, random)
                r, g, b = r + red, g + green, b + blue
        colors[i, 0] += r
        colors[i, 1] += g
        colors[i, 2] += b
