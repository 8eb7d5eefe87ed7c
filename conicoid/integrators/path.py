"""Light transport by paths: what comes along a ray, followed backwards through one scattering after the other.

At each point one source is asked for light (next-event estimation), and a direction is drawn from the surface; where
both could have found the same light they share it by the power heuristic (Veach, Robust Monte Carlo methods for light
transport simulation, 1997, section 9.2.3). Russian roulette ends paths that carry little. The 64 paths of a packet go
on side by side, a scattering at a time: camera rays, and theirs to sources, are traced together, those that scattered
one by one, which is four times as fast (1,000 balls). Rays start on surfaces by identity, so none needs a distance to
keep from them.

After Pharr, Jakob and Humphreys, Physically Based Rendering, 4th edition, chapters 13 and 14.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..compiler.jit import allocator, helper, inline
from ..emitters.transport import Transport
from ..engine.body.scratch import Scratch
from ..engine.packets.first import trace_packet
from ..engine.packets.lanes import (
    LANES,
    close_lanes,
    lane_hit,
    lane_ray,
    prepare_lanes,
    put_idle,
    put_lane_beam,
    put_ray,
)
from ..engine.packets.packet import Packet, new_lanes, with_lanes
from ..engine.ray import Ray
from ..engine.single.first import first_crossing
from ..engine.tables import Floats, Geometry, halted, whole
from ..shading.media import OUTSIDE
from .samples import Samples, Settings
from .sobol import sobol_pair
from .vertex import NONE, Asked, Path, arrives, at_ray, weighed
from .whitted import medium_at, sight_of

_ROULETTE = 3  # so many scatterings are followed in any case
_FIRST_PAIR, _PAIRS = 4, 4
"""Numbers of pairs of dimensions: the first, and how many a scattering takes."""
_STATE = 14
_ASKS = 7


class Walk(NamedTuple):
    """Memory of 64 paths. Rows go with lanes; the first so many are in use."""

    shadow: Floats  # the lanes of rays to sources
    paths: Floats  # (64, _STATE) see `Path`; then the row of `Samples` that a path belongs to
    asks: Floats  # (64, _ASKS) what a ray to a source brings: row, rgb, the body that it is to meet, its medium, end


@allocator
def new_memory(settings: Settings) -> Walk:
    """Memory for one thread."""
    return Walk(new_lanes(), np.empty((LANES, _STATE)), np.empty((LANES, _ASKS)))


@inline
def _keep(row: Floats, path: Path, place: int) -> None:
    row[0], row[1], row[2], row[3], row[4], row[5], row[6] = (
        path.r, path.g, path.b, path.density, path.x, path.y, path.z,
    )  # fmt: skip
    row[7], row[8], row[9], row[10], row[11] = path.scale, path.medium, path.turns, path.wave, path.passed
    row[12] = place


@inline
def _kept(row: Floats) -> Path:
    return Path(
        row[0], row[1], row[2], row[3], row[4], row[5], row[6], row[7], whole(row[8]), whole(row[9]), row[10],
        whole(row[11]),
    )  # fmt: skip


@helper
def _begin(geometry: Geometry, scratch: Scratch, walk: Walk, transport: Transport, samples: Samples) -> None:
    """Paths of camera rays."""
    materials = transport.look.materials
    for i in range(samples.size):
        x, y, z, _, _, _, _, _, _ = lane_ray(samples.packet.lanes, i, 0.0)
        medium = whole(OUTSIDE)
        if materials.any_transparent:
            medium = medium_at(geometry, scratch, materials, x, y, z)
        _keep(walk.paths[i], Path(1.0, 1.0, 1.0, NONE, x, y, z, 1.0, medium, whole(0), 0.0, whole(0)), i)


@helper
def _round(
    geometry: Geometry, scratch: Scratch, walk: Walk, settings: Settings, samples: Samples, count: int, first: bool
) -> tuple[int, int]:
    """One scattering of `count` paths: (how many go on, how many rays to sources there are)."""
    transport, lanes, colors = settings.look, samples.packet.lanes, samples.colors
    left, asks = 0, 0
    for k in range(count):
        path, place = _kept(walk.paths[k]), int(walk.paths[k, 12])
        ray = lane_ray(lanes, k, math.inf)
        if first:
            hit = lane_hit(lanes, k)
        else:
            hit = first_crossing(geometry, scratch, ray, scratch.nothing, False)
        sight = sight_of(geometry, scratch, transport.look.materials, ray, hit)
        pair = _FIRST_PAIR + _PAIRS * (path.turns + path.passed)
        random = settings.seed, samples.pixels[place], samples.sample, pair
        found, path, ray, asked = at_ray(geometry, transport, settings.depth, random, path, ray, sight)
        colors[place, 0] += found[0]
        colors[place, 1] += found[1]
        colors[place, 2] += found[2]
        if asked.end > 0.0:
            put_ray(walk.shadow, asks, _shadow_ray(asked, sight.surface if asked.on_surface else whole(-1)))
            row = walk.asks[asks]
            row[0], row[1], row[2], row[3], row[4], row[5] = place, asked.r, asked.g, asked.b, asked.body, asked.medium
            row[6] = asked.end
            asks += 1
        if max(path.r, max(path.g, path.b)) > 0.0:
            path = _roulette(settings.seed, samples.pixels[place], samples.sample, pair + 3, path)
            if max(path.r, max(path.g, path.b)) > 0.0:
                put_ray(lanes, left, ray)
                _keep(walk.paths[left], path, place)
                left += 1
    return left, asks


@inline
def _shadow_ray(asked: Asked, start: int) -> Ray:
    return Ray(asked.x, asked.y, asked.z, asked.d[0], asked.d[1], asked.d[2], 0.0, asked.end, start)


@inline
def _roulette(seed: int, pixel: int, sample: int, pair: int, path: Path) -> Path:
    """The path, ended or made stronger by what others lose."""
    if path.turns < _ROULETTE:
        return path
    likely = max(path.r, max(path.g, path.b)) * path.scale
    if likely >= 1.0:
        return path
    likely = max(0.05, likely)
    u, _ = sobol_pair(seed, pixel, sample, pair)
    keep = 1.0 / likely if u < likely else 0.0
    return weighed(path, keep, keep, keep)


@helper
def _trace_asked(
    geometry: Geometry, scratch: Scratch, walk: Walk, transport: Transport, packet: Packet, asks: int
) -> None:
    """What the rays to sources meet, together: those of a camera's rays go to a lamp side by side."""
    lanes, materials, some = walk.shadow, transport.look.materials, False
    for k in range(asks):
        some = some or walk.asks[k, 4] >= 0.0
    for k in range(asks, LANES):
        put_idle(lanes, k, 0)
    prepare_lanes(lanes)
    put_lane_beam(lanes, False)
    blocks = materials.opaque if materials.any_transparent else scratch.nothing
    trace_packet(geometry, scratch, with_lanes(packet, lanes), blocks, not some)


@helper
def _ask(
    geometry: Geometry, scratch: Scratch, walk: Walk, transport: Transport, samples: Samples, asks: int, together: bool
) -> None:
    """Trace the rays to sources, and add what arrives. Rays that go anywhere are fastest one by one (measured)."""
    lanes, materials, colors = walk.shadow, transport.look.materials, samples.colors
    blocks = materials.opaque if materials.any_transparent else scratch.nothing
    if together:
        _trace_asked(geometry, scratch, walk, transport, samples.packet, asks)
    for k in range(asks):
        row = walk.asks[k]
        body = whole(row[4])
        if together:
            hit = lane_hit(lanes, k)
        else:
            hit = first_crossing(geometry, scratch, lane_ray(lanes, k, row[6]), blocks, body < 0)
        if hit.body != body:
            continue
        r, g, b, place = row[1], row[2], row[3], int(row[0])
        if materials.any_transparent:
            end = min(row[6], hit.t)
            tr, tg, tb = arrives(geometry, scratch, materials, lane_ray(lanes, k, end), whole(row[5]))
            r, g, b = r * tr, g * tg, b * tb
        colors[place, 0] += r
        colors[place, 1] += g
        colors[place, 2] += b


@helper
def gather(geometry: Geometry, scratch: Scratch, walk: Walk, settings: Settings, samples: Samples) -> None:
    """Add what comes back along the rays after at most `settings.depth` scatterings."""
    transport = settings.look
    _begin(geometry, scratch, walk, transport, samples)
    close_lanes(samples.packet.lanes, samples.size)
    trace_packet(geometry, scratch, samples.packet, scratch.nothing, False)
    count, first = samples.size, True
    while count > 0 and not halted(geometry):
        count, asks = _round(geometry, scratch, walk, settings, samples, count, first)
        if asks > 0:
            together = first and transport.surroundings.width == 0
            _ask(geometry, scratch, walk, transport, samples, asks, together)
        first = False
