"""Light transport by paths: what comes along a ray, followed backwards through one scattering after the other.

At each point one source is asked for light (next-event estimation), and a direction is drawn from the surface; where
both could have found the same light they share it by the power heuristic (Veach, Robust Monte Carlo methods for light
transport simulation, 1997, section 9.2.3). Russian roulette ends paths that carry little. Camera rays, and theirs to
sources, are traced in packets; what was scattered waits in a pool, from which all paths of many samples go on together,
a scattering at a time. Rays start on surfaces by identity, so none needs a distance to keep from them.

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
    lane_hit,
    lane_ray,
    prepare_lanes,
    put_idle,
    put_lane_beam,
    put_ray,
)
from ..engine.packets.packet import Packet, new_lanes, new_rows, with_lanes
from ..engine.packets.square import Square, new_square
from ..engine.ray import with_limits
from ..engine.tables import Floats, Geometry, halted, whole
from ..shading.media import OUTSIDE
from .matte import LEFT, ROWS, add_plain, is_plain, leave_all
from .pool import (
    ASKS,
    BATCH,
    PATHS,
    ROUND,
    Pool,
    ask_in,
    hit_in,
    new_pool,
    path_in,
    put_ask,
    put_hit,
    put_path,
    ray_in,
    trace_rows,
)
from .samples import Samples, Settings, trace_samples
from .sobol import sobol_pair
from .straight import arrives
from .vertex import NONE, Path, at_ray, weighed
from .whitted import medium_at, sight_of

__all__ = ["BATCH", "finish", "gather", "new_memory"]

_ROULETTE = 3  # so many scatterings are followed in any case
_FIRST_PAIR, _PAIRS = 4, 4
"""Numbers of pairs of dimensions: the first, and how many a scattering takes."""


class Walk(NamedTuple):
    """Memory of one thread."""

    shadow: Floats  # the lanes of rays to sources
    pool: Pool
    matte: Floats  # see `matte`
    lit: Square  # of rays to the light of a picture that `is_plain`


@allocator
def new_memory(geometry: Geometry, settings: Settings) -> Walk:
    """Memory for one thread."""
    return Walk(new_lanes(), new_pool(geometry), new_rows(ROWS), new_square())


@inline
def _begin(
    geometry: Geometry, scratch: Scratch, pool: Pool, transport: Transport, samples: Samples, left: Floats
) -> None:
    """Paths of those camera rays that are left (left[LEFT:]), and what they meet, into further rows."""
    materials, place, count = transport.look.materials, LANES * pool.counts[ROUND], pool.counts[PATHS]
    for i in range(samples.size):
        if left[LEFT + np.uint64(i)] == 0.0:
            continue
        ray = lane_ray(samples.packet.lanes, i, math.inf)
        medium = whole(OUTSIDE)
        if materials.any_transparent:
            medium = medium_at(geometry, scratch, materials, ray.ox, ray.oy, ray.oz)
        path = Path(1.0, 1.0, 1.0, NONE, ray.ox, ray.oy, ray.oz, 1.0, medium, whole(0), 0.0, whole(0))
        put_path(pool.paths[count], path, ray, place + i)
        put_hit(pool.hits[count], lane_hit(samples.packet.lanes, i))
        count += 1
    pool.counts[PATHS] = count


@helper
def _round(
    geometry: Geometry, scratch: Scratch, pool: Pool, settings: Settings, samples: Samples, first: int, shift: int
) -> None:
    """One scattering of the paths from row `first` on, which have met something; those that go on close up.

    samples: whose first is the sample of places 0 to 63, where the light of place `shift` is its first row.
    """
    transport, colors = settings.look, samples.colors
    left, asks = first, pool.counts[ASKS]
    for k in range(first, pool.counts[PATHS]):
        path, place = path_in(pool.paths[k])
        ray = ray_in(pool.paths[k])
        sight = sight_of(geometry, scratch, transport.look.materials, ray, hit_in(pool.hits[k]))
        pixel, sample = samples.pixels[place & (LANES - 1)], samples.sample + ((place - shift) >> 6)
        pair = _FIRST_PAIR + _PAIRS * (path.turns + path.passed)
        random = settings.seed, pixel, sample, pair
        found, path, ray, asked = at_ray(geometry, transport, settings.depth, random, path, ray, sight)
        at = place - shift
        colors[at, 0] += found[0]
        colors[at, 1] += found[1]
        colors[at, 2] += found[2]
        if asked.end > 0.0:
            put_ask(pool.asks[asks], asked, sight.surface if asked.on_surface else whole(-1), place)
            asks += 1
        if max(path.r, max(path.g, path.b)) > 0.0:
            path = _roulette(settings.seed, pixel, sample, pair + 3, path)
            if max(path.r, max(path.g, path.b)) > 0.0:
                put_path(pool.paths[left], path, ray, place)
                left += 1
    pool.counts[PATHS], pool.counts[ASKS] = left, asks


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


@inline
def _is_lamp_asked(pool: Pool, first: int) -> bool:
    """Is any ray to a source, from row `first` on, to meet a body?"""
    found = False
    for k in range(first, pool.counts[ASKS]):
        found = found or pool.asks[k, 12] >= 0.0
    return found


@helper
def _trace_asked(
    geometry: Geometry, scratch: Scratch, walk: Walk, transport: Transport, packet: Packet, first: int
) -> None:
    """What rays to sources meet, of one packet together: those of camera rays go to a lamp side by side."""
    lanes, materials, pool = walk.shadow, transport.look.materials, walk.pool
    count = pool.counts[ASKS] - first
    for k in range(count):
        put_ray(lanes, k, ray_in(pool.asks[first + k]))
    for k in range(count, LANES):
        put_idle(lanes, k, 0)
    prepare_lanes(lanes)
    put_lane_beam(lanes, False)
    blocks = materials.opaque if materials.any_transparent else scratch.nothing
    trace_packet(geometry, scratch, with_lanes(packet, lanes), blocks, not _is_lamp_asked(pool, first))
    for k in range(count):
        put_hit(pool.hits[first + k], lane_hit(lanes, k))


@helper
def _add_asked(
    geometry: Geometry, scratch: Scratch, pool: Pool, transport: Transport, samples: Samples, first: int, shift: int
) -> None:
    """Add what arrives along rays to sources, from row `first` on, and forget them."""
    materials, colors = transport.look.materials, samples.colors
    for k in range(first, pool.counts[ASKS]):
        place, r, g, b, body, medium = ask_in(pool.asks[k])
        hit = hit_in(pool.hits[k])
        if hit.body != body:
            continue
        if materials.any_transparent:
            ray = ray_in(pool.asks[k])
            ray = with_limits(ray, ray.t_min, min(ray.t_max, hit.t))
            tr, tg, tb = arrives(geometry, scratch, materials, ray, medium)
            r, g, b = r * tr, g * tg, b * tb
        at = place - shift
        colors[at, 0] += r
        colors[at, 1] += g
        colors[at, 2] += b
    pool.counts[ASKS] = first


@helper
def gather(geometry: Geometry, scratch: Scratch, walk: Walk, settings: Settings, samples: Samples) -> None:
    """Add what camera rays find and are sent from sources straight; `finish` adds the rest."""
    transport, pool = settings.look, walk.pool
    trace_samples(geometry, scratch, samples)
    paths, asks, shift = pool.counts[PATHS], pool.counts[ASKS], LANES * pool.counts[ROUND]
    if is_plain(settings):
        add_plain(geometry, scratch, walk.matte, walk.shadow, walk.lit, transport, samples)
    else:
        leave_all(walk.matte)
    _begin(geometry, scratch, pool, transport, samples, walk.matte)
    _round(geometry, scratch, pool, settings, samples, paths, shift)
    if pool.counts[ASKS] > asks and transport.surroundings.width == 0:
        _trace_asked(geometry, scratch, walk, transport, samples.packet, asks)
        _add_asked(geometry, scratch, pool, transport, samples, asks, shift)
    pool.counts[ROUND] += 1


@helper
def finish(geometry: Geometry, scratch: Scratch, walk: Walk, settings: Settings, samples: Samples) -> None:
    """Add what comes back along the paths of all samples since the last time, after at most `depth` scatterings."""
    transport, pool = settings.look, walk.pool
    materials = transport.look.materials
    blocks = materials.opaque if materials.any_transparent else scratch.nothing
    while pool.counts[PATHS] + pool.counts[ASKS] > 0 and not halted(geometry):
        if pool.counts[ASKS] > 0:
            trace_rows(geometry, scratch, pool, pool.asks, pool.counts[ASKS], blocks, not _is_lamp_asked(pool, 0))
            _add_asked(geometry, scratch, pool, transport, samples, 0, 0)
        trace_rows(geometry, scratch, pool, pool.paths, pool.counts[PATHS], scratch.nothing, False)
        _round(geometry, scratch, pool, settings, samples, 0, 0)
    pool.counts[PATHS], pool.counts[ASKS], pool.counts[ROUND] = 0, 0, 0
