"""Light transport by paths: light along a ray, followed backwards through one scattering after the other.

At each point the path samples one source of light (next-event estimation), and draws a direction from the surface;
where both could have found the same light they share it by the power heuristic (Veach, Robust Monte Carlo methods for
light transport simulation, 1997, section 9.2.3). Russian roulette ends paths that carry little. Packets trace camera
rays, and the rays from their hits to sources; scattered rays wait in a queue, from which all paths of many samples go
on together, a scattering at a time. Rays start on surfaces by identity, so none needs a distance to keep from them.

After Pharr, Jakob and Humphreys, Physically Based Rendering, 4th edition, chapters 13 and 14.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..._jit.decorators import allocator, choose, helper, inline
from ...kernels.body.hit import Hit, no_hit, resolve_hit
from ...kernels.body.scratch import Scratch
from ...kernels.bvh.culling import extent
from ...kernels.first_hits import first_crossing
from ...kernels.numbers.vectors import dot, quotient, unit_vector
from ...kernels.packet.lanes import (
    ALL,
    BEST,
    DX,
    DY,
    DZ,
    LANES,
    OX,
    OY,
    OZ,
    START,
    T_MAX,
    T_MIN,
    eights,
    lane_hit,
    lane_ray,
    prepare_lanes,
    put_beam_from,
    put_idle,
    put_lane_beam,
    put_ray,
)
from ...kernels.packet.packet import Packet, new_lanes, new_rows, with_lanes
from ...kernels.packet.traversal import PixelSquare, new_square, trace_packet, trace_square
from ...kernels.ray import Ray, scale_ray, with_limits
from ...kernels.stream import Stream, new_stream, octant_of, put_stream_ray, stream_hit, trace_stream
from ...kernels.surface.records import gradient_at
from ...kernels.tables import Floats, Geometry, Longs, Signs, is_halted, whole
from ..bsdf.material_table import MaterialTable, material_row
from ..bsdf.medium import OUTSIDE
from ..lights.direct_light import straight_transmittance
from ..lights.light_tables import DELTA_LIGHT, PathLight
from ..sampling import sobol_pair
from .path_vertex import NO_DENSITY, LightQuery, PathState, extend_path, scale_path
from .samples import Samples, Settings, trace_samples
from .whitted import find_interaction, medium_at

# --- Direct light on matte surfaces, for all rays of a packet in lanes
#
# Where paths end at their first surface and the only light is one light without a cone, Lambert's law is the same
# short formula for each ray, without random numbers or memory of paths. All other surfaces than evenly matte ones are
# left to `path_vertex`. The formulas are those of `path_vertex`, `light_sampling` and `bsdf`, in the same order, so the
# colours are the same to the bit.

X, Y, Z, NX, NY, NZ, SIDE, R, G, B, REMAINING = (np.uint64(row) for row in range(0, 11 * LANES, LANES))
"""Rows of lanes: the point of the hit, the gradient there and its side, the colour, which becomes the light that may
arrive; and 1 where a ray is left to `path_vertex`."""
ROWS = 11 * LANES


@inline
def has_one_light(settings: Settings) -> bool:
    """Return whether all light is of one light without a cone, scattered once."""
    transport = settings.look
    if settings.depth != 1 or transport.shines or len(transport.sources.records) != 1:
        return False
    source = transport.sources.records[0]
    if transport.look.materials.any_transparent or transport.surroundings.width > 0 or source.kind != DELTA_LIGHT:
        return False
    return bool(transport.look.lights[source.index].outer == math.inf)


@inline
def skip_all(rows: Floats) -> None:
    """Leave all rays to `path_vertex`."""
    for i in range(ALL):
        rows[REMAINING + i] = 1.0


@helper
def _find_matte_hits(
    geometry: Geometry, rows: Floats, shadow: Floats, materials: MaterialTable, samples: Samples
) -> tuple[int, int]:  # fmt: skip
    """Write the matte hits of a traced packet into the rows, and mark the rays that are left.

    Return the first and the end of the groups of eight lanes with a matte hit, (0, 0) if no lane has one.
    """
    lanes, some, most = samples.packet.lanes, LANES, 0
    for i in range(ALL):
        rows[REMAINING + i] = 0.0
    if extent(lanes, BEST)[0] == math.inf:
        return 0, 0
    for i in range(ALL):
        t = lanes[BEST + i]
        rows[X + i] = lanes[OX + i] + t * lanes[DX + i]
        rows[Y + i] = lanes[OY + i] + t * lanes[DY + i]
        rows[Z + i] = lanes[OZ + i] + t * lanes[DZ + i]
        rows[R + i], rows[G + i], rows[B + i] = 0.0, 0.0, 0.0
    for k in range(samples.size):
        lane = np.uint64(k)
        _, body, surface, face, side = resolve_hit(geometry, lane_hit(lanes, lane))
        if body < 0:
            continue
        row = materials.rows[material_row(geometry, materials, body, face)]
        if row.even == 0:
            rows[REMAINING + lane] = 1.0
            continue
        nx, ny, nz = gradient_at(geometry, surface, rows[X + lane], rows[Y + lane], rows[Z + lane])
        rows[NX + lane], rows[NY + lane], rows[NZ + lane], rows[SIDE + lane] = nx, ny, nz, side
        kd, color = row.diffuse, row.color
        rows[R + lane], rows[G + lane] = min(1.0, kd * color[0]), min(1.0, kd * color[1])
        rows[B + lane] = min(1.0, kd * color[2])
        shadow[START + lane] = surface
        some, most = min(some, k), k + 1
    return (some & -8, most + 7 & -8) if most > 0 else (0, 0)


@helper
def _shadow_rays_to_light(
    rows: Floats, lanes: Floats, shadow: Floats, parallel: bool, fades: bool, where: tuple[float, float, float],
    intensity: tuple[float, float, float], first: int, last: int,
) -> None:  # fmt: skip
    """Write the light that may arrive into the rows, and shadow rays into `shadow`: empty ones where none may.

    where: the direction to a parallel light, or the position of another. first, last: the range of lanes that count.
    """
    end = math.inf if parallel else 1.0
    first, last = eights(first, last)
    for i in range(ALL):
        shadow[T_MIN + i], shadow[T_MAX + i] = 0.0, -math.inf
    for i in range(first, last):
        x, y, z, side = rows[X + i], rows[Y + i], rows[Z + i], rows[SIDE + i]
        dx, dy, dz = lanes[DX + i], lanes[DY + i], lanes[DZ + i]
        nx, ny, nz = unit_vector(rows[NX + i], rows[NY + i], rows[NZ + i])
        nx, ny, nz = side * nx, side * ny, side * nz
        facing = choose(-dot(nx, ny, nz, dx, dy, dz) < 0.0, -1.0, 1.0)
        nx, ny, nz = facing * nx, facing * ny, facing * nz
        lx = choose(parallel, where[0], where[0] - x)
        ly = choose(parallel, where[1], where[1] - y)
        lz = choose(parallel, where[2], where[2] - z)
        distance = math.sqrt(dot(lx, ly, lz, lx, ly, lz))
        inverse = 1.0 / distance
        part = math.pi * choose(fades, 1.0 / (distance * distance), 1.0)
        cosine = dot(
            quotient(lx, distance, inverse), quotient(ly, distance, inverse), quotient(lz, distance, inverse),
            nx, ny, nz,
        )  # fmt: skip
        both = (dot(-dx, -dy, -dz, nx, ny, nz) > 0.0) & (cosine > 0.0)
        lambert = choose(both, (1.0 / math.pi) * cosine, 0.0)
        r, g, b = rows[R + i] * lambert, rows[G + i] * lambert, rows[B + i] * lambert
        lit = r + g + b > 0.0  # not where there is no hit, whose place and distance may be no numbers
        rows[R + i] = choose(lit, r * (part * intensity[0]), 0.0)
        rows[G + i] = choose(lit, g * (part * intensity[1]), 0.0)
        rows[B + i] = choose(lit, b * (part * intensity[2]), 0.0)
        shadow[OX + i], shadow[OY + i], shadow[OZ + i] = x + 0.0, y + 0.0, z + 0.0
        shadow[DX + i], shadow[DY + i], shadow[DZ + i] = lx, ly, lz
        shadow[T_MAX + i] = choose(lit, end, -math.inf)


@inline
def _put_all_idle(lanes: Floats, like: int) -> None:
    """Copy the ray of lane `like` into all lanes without a ray, so that they do not widen the packet's beam."""
    lane = np.uint64(like)
    for row in (OX, OY, OZ, DX, DY, DZ, START):
        value = lanes[row + lane]
        for i in range(ALL):
            lanes[row + i] = choose(lanes[T_MAX + i] == -math.inf, value, lanes[row + i])


@helper
def add_direct_light(
    geometry: Geometry,
    scratch: Scratch,
    rows: Floats,
    shadow: Floats,
    lit: PixelSquare,
    transport: PathLight,
    samples: Samples,
) -> None:
    """Add the light on evenly matte surfaces, where `has_one_light`; rows[REMAINING:] becomes 1 for the other rays."""
    light, colors = transport.look.lights[transport.sources.records[0].index], samples.colors
    first, last = _find_matte_hits(geometry, rows, shadow, transport.look.materials, samples)
    if last == 0:
        return
    parallel, place, axis, sent = light.parallel == 1, light.position, light.axis, light.intensity
    where = (-axis[0], -axis[1], -axis[2]) if parallel else (place[0], place[1], place[2])
    _shadow_rays_to_light(
        rows, samples.packet.lanes, shadow, parallel, light.fades == 1, where, (sent[0], sent[1], sent[2]), first, last
    )
    some = -1
    for k in range(first, last):
        if shadow[T_MAX + np.uint64(k)] > 0.0:
            some = k
    if some < 0:
        return
    _put_all_idle(shadow, some)
    prepare_lanes(shadow)
    put_lane_beam(shadow, False)
    if not parallel:
        put_beam_from(shadow, where[0], where[1], where[2])
    to_light = with_lanes(samples.packet, shadow)
    trace_square(geometry, scratch, to_light, lit, samples.pixels[0], scratch.nothing, True)
    for k in range(first, min(last, samples.size)):
        lane = np.uint64(k)
        if shadow[BEST + lane] == math.inf:
            colors[k, 0] += rows[R + lane]
            colors[k, 1] += rows[G + lane]
            colors[k, 2] += rows[B + lane]


# --- Paths

BATCH = 32
"""Number of samples of a square of pixels that are traced together."""
QUEUE_CAPACITY = BATCH * LANES
_STATE, _LIGHT_QUERY, _HIT = 21, 14, 8
"""Columns of a row of `PathQueue.paths`, `light_queries` and `hits`."""
_END = 7
"""The column of a ray's end in paths and queries; the data of the path or the query follow."""
_PLACE = 20
"""The column of the row of colours that a path's light goes to."""
_SINGLE, _KINDS = 8, 9
"""Kinds of rays: one of eight octants, or single rays, which are traced one by one."""
_FEW = 4
"""Up to this many rays of an octant are traced one by one."""
PATHS, LIGHT_QUERIES, ROUND = 0, 1, 2
"""Counts: rows of paths and of queries in use, and packets since the queue was emptied."""


# The queue of rays that wait for those of other samples
#
# Scattered rays go anywhere. One by one they cost three times as much as in streams of an octant each, of some hundred
# or more (measured: 1,000 balls, bounces of 32 samples of 64 pixels). How a ray is traced changes no bit of its hit.


class PathQueue(NamedTuple):
    """Memory of one thread. The first rows of tables are in use."""

    paths: Floats  # (QUEUE_CAPACITY, _STATE) a ray, a `PathState`, the place of its light: 64 · sample + pixel
    light_queries: (
        Floats  # (QUEUE_CAPACITY, _LIGHT_QUERY) a ray to a source, its place, rgb, the body to hit, its medium
    )
    hits: Floats  # (QUEUE_CAPACITY, _HIT) the hits of the rays of one of both
    counts: Longs  # (3,)
    order: Longs  # (QUEUE_CAPACITY,) rows by octant
    kinds: Longs  # (QUEUE_CAPACITY,) each row's kind
    begins: Longs  # (_KINDS + 1,) the begin of each kind's rows in the order
    stream: Stream


@allocator
def new_path_queue(geometry: Geometry) -> PathQueue:
    """Return an empty queue for one thread."""
    return PathQueue(
        np.empty((QUEUE_CAPACITY, _STATE)),
        np.empty((QUEUE_CAPACITY, _LIGHT_QUERY)),
        np.empty((QUEUE_CAPACITY, _HIT)),
        np.zeros(3, np.int64),
        np.empty(QUEUE_CAPACITY, np.int64),
        np.empty(QUEUE_CAPACITY, np.int64),
        np.empty(_KINDS + 1, np.int64),
        new_stream(geometry, QUEUE_CAPACITY),
    )


@inline
def load_ray(row: Floats) -> Ray:
    """Return the ray in a row."""
    return Ray(row[0], row[1], row[2], row[3], row[4], row[5], 0.0, row[_END], whole(row[6]))


@inline
def _put_ray(row: Floats, ray: Ray) -> None:
    """Write a ray into a row."""
    row[0], row[1], row[2], row[3], row[4], row[5], row[6], row[_END] = (
        ray.ox, ray.oy, ray.oz, ray.dx, ray.dy, ray.dz, ray.start, ray.t_max,
    )  # fmt: skip


@inline
def put_path(row: Floats, path: PathState, ray: Ray, place: int) -> None:
    """Write a path and its ray into a row."""
    _put_ray(row, ray)
    row[8], row[9], row[10], row[11], row[12], row[13], row[14] = (
        path.r, path.g, path.b, path.density, path.x, path.y, path.z,
    )  # fmt: skip
    row[15], row[16], row[17], row[18], row[19] = path.scale, path.medium, path.turns, path.wave, path.passed
    row[_PLACE] = place


@inline
def load_path(row: Floats) -> tuple[PathState, int]:
    """Return (the path in a row, its place)."""
    path = PathState(
        row[8], row[9], row[10], row[11], row[12], row[13], row[14], row[15], whole(row[16]), whole(row[17]), row[18],
        whole(row[19]),
    )  # fmt: skip
    return path, whole(row[_PLACE])


@inline
def put_light_query(row: Floats, query: LightQuery, start: int, place: int) -> None:
    """Write a ray to a source, from the surface `start`, and its light into a row."""
    _put_ray(row, Ray(query.x, query.y, query.z, query.d[0], query.d[1], query.d[2], 0.0, query.end, start))
    row[8], row[9], row[10], row[11], row[12], row[13] = place, query.r, query.g, query.b, query.body, query.medium


@inline
def load_light_query(row: Floats) -> tuple[int, float, float, float, int, int]:
    """Return (place, r, g, b, the body that the ray has to hit first, the medium that it starts in) of a row."""
    return whole(row[8]), row[9], row[10], row[11], whole(row[12]), whole(row[13])


@inline
def put_hit(row: Floats, hit: Hit) -> None:
    """Write a hit into a row."""
    row[0], row[1], row[2], row[3], row[4], row[5], row[6] = (
        hit.t, hit.body, hit.entry, hit.place, hit.sense, 1.0 if hit.enters else 0.0, hit.off,
    )  # fmt: skip


@inline
def load_hit(row: Floats) -> Hit:
    """Return the hit in a row."""
    return Hit(row[0], whole(row[1]), whole(row[2]), whole(row[3]), whole(row[4]), row[5] != 0.0, row[6], False)


@helper
def _sort(pool: PathQueue, rows: Floats, count: int) -> None:
    """Sort rows by the octants of their rays (a counting sort): rows of one octant keep their order."""
    begins = pool.begins
    for kind in range(_KINDS + 1):
        begins[kind] = 0
    for k in range(count):
        ray = load_ray(rows[k])
        kind = octant_of(ray.dx, ray.dy, ray.dz) if scale_ray(ray)[1] == 1.0 else _SINGLE
        pool.kinds[k] = kind
        begins[kind + 1] += 1
    for kind in range(_KINDS):
        begins[kind + 1] += begins[kind]
    for k in range(count):
        kind = pool.kinds[k]
        pool.order[begins[kind]] = k
        begins[kind] += 1


@helper
def trace_rows(
    geometry: Geometry, scratch: Scratch, pool: PathQueue, rows: Floats, count: int, blocks: Signs, any_hit: bool
) -> None:
    """Write the first hits, or any hits, of the rays of the first `count` rows into `hits`.

    Only bodies with blocks[body] != 0 count, or all if `blocks` is empty.
    """
    _sort(pool, rows, count)
    first, stream = whole(0), pool.stream
    for kind in range(_KINDS):
        end = pool.begins[kind]  # sorting has moved the begin to the end
        together = kind != _SINGLE and end - first > _FEW
        if together:
            for j in range(first, end):
                put_stream_ray(stream, j - first, load_ray(rows[pool.order[j]]))
            trace_stream(geometry, scratch, stream, end - first, blocks, any_hit)
        for j in range(first, end):
            k = pool.order[j]
            hit = stream_hit(stream, j - first) if together else no_hit()
            if not together or hit.unsure:  # the code for single rays is in doubt less often
                hit = first_crossing(geometry, scratch, load_ray(rows[k]), blocks, any_hit)
            put_hit(pool.hits[k], hit)
        first = end


# The integrator: `gather` for a packet of camera rays, `finish` for the paths of a batch of samples

_ROULETTE = 3  # roulette begins after this many scatterings
_FIRST_PAIR, _PAIRS = 4, 4
"""Pairs of dimensions of the random numbers: the first pair, and the number of pairs of a scattering."""


class PathMemory(NamedTuple):
    """Memory of one thread."""

    shadow: Floats  # the lanes of rays to sources
    pool: PathQueue
    matte: Floats  # rows of lanes, see `X`
    lit: PixelSquare  # of rays to the light of a picture that `has_one_light`


@allocator
def new_memory(geometry: Geometry, settings: Settings) -> PathMemory:
    """Return memory for one thread."""
    return PathMemory(new_lanes(), new_path_queue(geometry), new_rows(ROWS), new_square())


@inline
def _first_path(geometry: Geometry, scratch: Scratch, materials: MaterialTable, ray: Ray) -> PathState:
    """Return the path of a camera ray."""
    medium = whole(OUTSIDE)
    if materials.any_transparent:
        medium = medium_at(geometry, scratch, materials, ray.ox, ray.oy, ray.oz)
    return PathState(1.0, 1.0, 1.0, NO_DENSITY, ray.ox, ray.oy, ray.oz, 1.0, medium, whole(0), 0.0, whole(0))


@inline
def _begin(
    geometry: Geometry, scratch: Scratch, pool: PathQueue, transport: PathLight, samples: Samples, left: Floats
) -> None:
    """Write the paths of the camera rays that are left (left[REMAINING:]), and their hits, into further rows."""
    materials, place, count = transport.look.materials, LANES * pool.counts[ROUND], pool.counts[PATHS]
    for i in range(samples.size):
        if left[REMAINING + np.uint64(i)] == 0.0:
            continue
        ray = lane_ray(samples.packet.lanes, i, math.inf)
        put_path(pool.paths[count], _first_path(geometry, scratch, materials, ray), ray, place + i)
        put_hit(pool.hits[count], lane_hit(samples.packet.lanes, i))
        count += 1
    pool.counts[PATHS] = count


@helper
def _round(
    geometry: Geometry, scratch: Scratch, pool: PathQueue, settings: Settings, samples: Samples, first: int, shift: int
) -> None:
    """Scatter the paths from row `first` on once, after their hits; those that go on close up the gaps.

    samples: the first of them is the sample of places 0 to 63; the light of place `shift` is the first row of colours.
    """
    transport, colors = settings.look, samples.colors
    left, asks = first, pool.counts[LIGHT_QUERIES]
    for k in range(first, pool.counts[PATHS]):
        path, place = load_path(pool.paths[k])
        ray = load_ray(pool.paths[k])
        sight = find_interaction(geometry, scratch, transport.look.materials, ray, load_hit(pool.hits[k]))
        pixel, sample = samples.pixels[place & (LANES - 1)], samples.sample + ((place - shift) >> 6)
        pair = _FIRST_PAIR + _PAIRS * (path.turns + path.passed)
        random = settings.seed, pixel, sample, pair
        found, path, ray, query = extend_path(geometry, transport, settings.depth, random, path, ray, sight)
        at = place - shift
        colors[at, 0] += found[0]
        colors[at, 1] += found[1]
        colors[at, 2] += found[2]
        if query.end > 0.0:
            put_light_query(pool.light_queries[asks], query, sight.surface if query.on_surface else whole(-1), place)
            asks += 1
        if max(path.r, max(path.g, path.b)) > 0.0:
            path = _roulette(settings.seed, pixel, sample, pair + 3, path)
            if max(path.r, max(path.g, path.b)) > 0.0:
                put_path(pool.paths[left], path, ray, place)
                left += 1
    pool.counts[PATHS], pool.counts[LIGHT_QUERIES] = left, asks


@inline
def _roulette(seed: int, pixel: int, sample: int, pair: int, path: PathState) -> PathState:
    """Return the path, ended by chance or weighed up for those that end (Russian roulette)."""
    if path.turns < _ROULETTE:
        return path
    likely = max(path.r, max(path.g, path.b)) * path.scale
    if likely >= 1.0:
        return path
    likely = max(0.05, likely)
    u, _ = sobol_pair(seed, pixel, sample, pair)
    keep = 1.0 / likely if u < likely else 0.0
    return scale_path(path, keep, keep, keep)


@helper
def radiance(
    geometry: Geometry, scratch: Scratch, memory: None, settings: Settings, ray: Ray, pixel: int, sample: int
) -> tuple[float, float, float]:
    """Return the sum of `gather` and `finish`, in the same order, for a single ray."""
    transport, seed, red, green, blue = settings.look, settings.seed, 0.0, 0.0, 0.0
    materials = transport.look.materials
    blocks = materials.opaque if materials.any_transparent else scratch.nothing
    path = _first_path(geometry, scratch, materials, ray)
    while max(path.r, max(path.g, path.b)) > 0.0:
        hit = first_crossing(geometry, scratch, ray, scratch.nothing, False)
        sight = find_interaction(geometry, scratch, materials, ray, hit)
        pair = _FIRST_PAIR + _PAIRS * (path.turns + path.passed)
        random = seed, pixel, sample, pair
        found, path, ray, query = extend_path(geometry, transport, settings.depth, random, path, ray, sight)
        red, green, blue = red + found[0], green + found[1], blue + found[2]
        if query.end > 0.0:
            start = sight.surface if query.on_surface else whole(-1)
            beam = Ray(query.x, query.y, query.z, query.d[0], query.d[1], query.d[2], 0.0, query.end, start)
            hit = first_crossing(geometry, scratch, beam, blocks, query.body < 0)
            r, g, b = _light_of_query(
                geometry, scratch, materials, beam, hit, query.body, query.medium, query.r, query.g, query.b
            )
            red, green, blue = red + r, green + g, blue + b
        if max(path.r, max(path.g, path.b)) > 0.0:
            path = _roulette(seed, pixel, sample, pair + 3, path)
    return red, green, blue


@inline
def _light_of_query(
    geometry: Geometry, scratch: Scratch, materials: MaterialTable, ray: Ray, hit: Hit, body: int, medium: int,
    r: float, g: float, b: float,
) -> tuple[float, float, float]:  # fmt: skip
    """Return the light that arrives along a ray to a source, whose first hit should be with a body, or none."""
    if hit.body != body:
        return 0.0, 0.0, 0.0
    if materials.any_transparent:
        ray = with_limits(ray, ray.t_min, min(ray.t_max, hit.t))
        tr, tg, tb = straight_transmittance(geometry, scratch, materials, ray, medium)
        r, g, b = r * tr, g * tg, b * tb
    return r, g, b


@inline
def _reaches_lamp(pool: PathQueue, first: int) -> bool:
    """Return whether any ray to a source, from row `first` on, has to hit a body."""
    found = False
    for k in range(first, pool.counts[LIGHT_QUERIES]):
        found = found or pool.light_queries[k, 12] >= 0.0
    return found


@helper
def _trace_light_queries(
    geometry: Geometry, scratch: Scratch, walk: PathMemory, transport: PathLight, packet: Packet, first: int
) -> None:
    """Trace the rays to sources of one packet as a packet: from hits of camera rays they go to a lamp side by side."""
    lanes, materials, pool = walk.shadow, transport.look.materials, walk.pool
    count = pool.counts[LIGHT_QUERIES] - first
    for k in range(count):
        put_ray(lanes, k, load_ray(pool.light_queries[first + k]))
    for k in range(count, LANES):
        put_idle(lanes, k, 0)
    prepare_lanes(lanes)
    put_lane_beam(lanes, False)
    blocks = materials.opaque if materials.any_transparent else scratch.nothing
    trace_packet(geometry, scratch, with_lanes(packet, lanes), blocks, not _reaches_lamp(pool, first))
    for k in range(count):
        put_hit(pool.hits[first + k], lane_hit(lanes, k))


@helper
def _add_light_queries(
    geometry: Geometry,
    scratch: Scratch,
    pool: PathQueue,
    transport: PathLight,
    samples: Samples,
    first: int,
    shift: int,
) -> None:
    """Add the light that arrives along rays to sources, from row `first` on, and empty these rows."""
    materials, colors = transport.look.materials, samples.colors
    for k in range(first, pool.counts[LIGHT_QUERIES]):
        place, r, g, b, body, medium = load_light_query(pool.light_queries[k])
        ray, hit = load_ray(pool.light_queries[k]), load_hit(pool.hits[k])
        r, g, b = _light_of_query(geometry, scratch, materials, ray, hit, body, medium, r, g, b)
        at = place - shift
        colors[at, 0] += r
        colors[at, 1] += g
        colors[at, 2] += b
    pool.counts[LIGHT_QUERIES] = first


@helper
def gather(geometry: Geometry, scratch: Scratch, walk: PathMemory, settings: Settings, samples: Samples) -> None:
    """Add the light at the hits of camera rays, and the light of sources there; `finish` adds the rest."""
    transport, pool = settings.look, walk.pool
    trace_samples(geometry, scratch, samples)
    paths, asks, shift = pool.counts[PATHS], pool.counts[LIGHT_QUERIES], LANES * pool.counts[ROUND]
    if has_one_light(settings):
        add_direct_light(geometry, scratch, walk.matte, walk.shadow, walk.lit, transport, samples)
    else:
        skip_all(walk.matte)
    _begin(geometry, scratch, pool, transport, samples, walk.matte)
    _round(geometry, scratch, pool, settings, samples, paths, shift)
    if pool.counts[LIGHT_QUERIES] > asks and transport.surroundings.width == 0:
        _trace_light_queries(geometry, scratch, walk, transport, samples.packet, asks)
        _add_light_queries(geometry, scratch, pool, transport, samples, asks, shift)
    pool.counts[ROUND] += 1


@helper
def finish(geometry: Geometry, scratch: Scratch, walk: PathMemory, settings: Settings, samples: Samples) -> None:
    """Add the light along the paths of all samples since the last call, after at most `depth` scatterings."""
    transport, pool = settings.look, walk.pool
    materials = transport.look.materials
    blocks = materials.opaque if materials.any_transparent else scratch.nothing
    while pool.counts[PATHS] + pool.counts[LIGHT_QUERIES] > 0 and not is_halted(geometry):
        if pool.counts[LIGHT_QUERIES] > 0:
            trace_rows(
                geometry,
                scratch,
                pool,
                pool.light_queries,
                pool.counts[LIGHT_QUERIES],
                blocks,
                not _reaches_lamp(pool, 0),
            )
            _add_light_queries(geometry, scratch, pool, transport, samples, 0, 0)
        trace_rows(geometry, scratch, pool, pool.paths, pool.counts[PATHS], scratch.nothing, False)
        _round(geometry, scratch, pool, settings, samples, 0, 0)
    pool.counts[PATHS], pool.counts[LIGHT_QUERIES], pool.counts[ROUND] = 0, 0, 0
