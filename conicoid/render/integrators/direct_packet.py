"""Direct light on matte surfaces, for all rays of a packet in lanes.

Where paths end at their first surface and the only light is one light without a cone, Lambert's law is the same short
formula for each ray, without random numbers or memory of paths. All other surfaces than evenly matte ones are left to
`path_vertex`. The formulas are those of `path_vertex`, `light_sampling` and `bsdf`, in the same order, so the colours
are the same to the bit.
"""

from __future__ import annotations

import math

import numpy as np

from ..._jit.decorators import choose, helper, inline
from ...kernels.body.hit import resolve_hit
from ...kernels.body.scratch import Scratch
from ...kernels.bvh.culling import extent
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
    prepare_lanes,
    put_beam_from,
    put_lane_beam,
)
from ...kernels.packet.packet import with_lanes
from ...kernels.packet.traversal import PixelSquare, trace_square
from ...kernels.surface.records import gradient_at
from ...kernels.tables import Floats, Geometry
from ..bsdf.material_table import MaterialTable, material_row
from ..lights.light_tables import DELTA_LIGHT, PathLight
from .samples import Samples, Settings

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
