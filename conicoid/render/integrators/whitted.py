"""Whitted's method: direct light, lamps with soft shadows, trees of mirrored and refracted rays; 64 pixels at once.

Each sample of a pixel takes the light of a lamp from one point of it. The points are those of the sampler of light
transport, so a picture is the same for any order of work, and shadows become smooth as samples are added. Mirrored and
refracted rays use the same points as the ray of the camera: for each ray by itself, these are as evenly spread. Up to
`MOST_LAMPS` lamps all count; of more, so many are drawn by the light that might arrive from them.

Radiance L in the solid angle dω counts as a light of intensity L dω / π.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..._jit.decorators import allocator, helper, inline, record_shapes
from ...kernels.body.hit import Hit, ResolvedHit, resolve_hit
from ...kernels.body.media import find_media
from ...kernels.body.scratch import Scratch
from ...kernels.first_hits import first_crossing, resolve_first_crossing
from ...kernels.numbers.double_double import next_float_down, next_float_up
from ...kernels.numbers.vectors import dot
from ...kernels.packet.lanes import (
    DX,
    DY,
    DZ,
    LANES,
    T_MAX,
    is_coherent,
    lane_hit,
    lane_ray,
    prepare_lanes,
    put_beam_from,
    put_idle,
    put_lane_beam,
    put_ray,
)
from ...kernels.packet.packet import new_lanes, with_lanes
from ...kernels.packet.traversal import trace_packet
from ...kernels.ray import Ray, with_limits
from ...kernels.surface.records import normal_at
from ...kernels.tables import Floats, Geometry, Longs, is_halted, whole
from ..bsdf.dielectric import split_at_wall
from ..bsdf.material_table import MaterialTable, material_row
from ..bsdf.medium import OUTSIDE, absorb, body_medium, is_invisible_wall, medium_index
from ..bsdf.microfacet import reflect
from ..bsdf.registry import mirror_share
from ..interaction import (
    ShadingPoint,
    SurfaceInteraction,
    bend_normal,
    face_viewer,
    has_relief,
    is_behind,
    mirror_to_side,
    shows_light,
)
from ..lights.direct_light import (
    diffuse_light,
    direct_light,
    highlight,
    shading_point_of,
    shadow_lights,
    shadow_ray,
    shadow_transmittance,
    surface_color,
)
from ..lights.environment import background_color
from ..lights.light_sampling import LightSample, choose_light, sample_lamp
from ..lights.light_tables import LightSources, ShadingTables, WhittedLight
from ..sampling import sobol_pair
from .samples import NO_SURFACE, Samples, Settings, trace_samples

MOST_LAMPS = 8
"""The largest number of lamps that a point takes light from."""
_FIRST_LAMP_PAIR = 8
_PER_PI = 1.0 / math.pi


@inline
def lamp_count(lamps: LightSources) -> int:
    """Return the number of lamps that a point takes light from."""
    return min(MOST_LAMPS, len(lamps.records))


@helper
def light_of_lamp(lit: WhittedLight, j: int, random: tuple[int, int, int], x: float, y: float, z: float) -> LightSample:
    """Return the light of the j-th lamp of a point, if nothing is in between. random: seed, pixel and sample."""
    seed, pixel, sample = random
    u, v = sobol_pair(seed, pixel, sample, _FIRST_LAMP_PAIR + 2 * j)
    k, likely = j, 1.0
    if len(lit.lamps.records) > MOST_LAMPS:
        choice, _ = sobol_pair(seed, pixel, sample, _FIRST_LAMP_PAIR + 2 * j + 1)
        k, likely = choose_light(lit.look, lit.lamps, x, y, z, choice)
        likely *= MOST_LAMPS
    return sample_lamp(lit.lamps, k, likely, x, y, z, u, v)


@helper
def lamp_ray(
    lit: WhittedLight, j: int, random: tuple[int, int, int], sight: SurfaceInteraction, row: Any, point: ShadingPoint,
    dx: float, dy: float, dz: float,
) -> tuple[Ray, int, bool]:  # fmt: skip
    """Return (ray from a point to a lamp, the body that it should hit first, whether it can bring light).

    dx, dy, dz: the unit direction along which the point is seen.
    """
    light = light_of_lamp(lit, j, random, point.x, point.y, point.z)
    lx, ly, lz = light.d
    ray = Ray(point.x, point.y, point.z, lx, ly, lz, 0.0, light.end, sight.surface)
    shows = row.diffuse > 0.0 or row.specular[0] + row.specular[1] + row.specular[2] > 0.0
    is_traced = shows and light.end > 0.0 and dot(point.nx, point.ny, point.nz, lx, ly, lz) > 0.0
    if is_traced and has_relief(row):
        is_traced = not is_behind(sight, dx, dy, dz, lx, ly, lz)
    return ray, light.body, is_traced


@helper
def shadow_lamps(
    geometry: Geometry,
    scratch: Scratch,
    lit: WhittedLight,
    random: tuple[int, int, int],
    arrived: Floats,
    sight: SurfaceInteraction,
    dx: float,
    dy: float,
    dz: float,
) -> None:
    """Compute the light of each lamp that reaches a point seen along unit d.

    It goes into `arrived` as rgb, behind that of the lights.
    """
    materials, first = lit.look.materials, 3 * len(lit.look.lights)
    shows, number, point = shading_point_of(geometry, materials, sight, dx, dy, dz)
    if not shows:
        return
    for j in range(lamp_count(lit.lamps)):
        ray, body, is_traced = lamp_ray(lit, j, random, sight, materials.rows[number], point, dx, dy, dz)
        r, g, b = 0.0, 0.0, 0.0
        if is_traced:
            hit = first_crossing(geometry, scratch, ray, materials.opaque, False)
            ray = with_limits(ray, 0.0, min(ray.t_max, hit.t))
            r, g, b = shadow_transmittance(geometry, scratch, materials, ray, sight.before, hit.body != body)
        arrived[first + 3 * j], arrived[first + 3 * j + 1], arrived[first + 3 * j + 2] = r, g, b


@helper
def lamp_light(
    lit: WhittedLight, random: tuple[int, int, int], row: Any, arrived: Floats, at: int, point: ShadingPoint
) -> tuple[float, float, float, float, float, float]:
    """Return (Σ I N·L, Σ I h), each rgb, over the lamps; arrived[at:] is the share of their light that arrives."""
    dr, dg, db, hr, hg, hb = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(lamp_count(lit.lamps)):
        ar, ag, ab = arrived[at + 3 * j], arrived[at + 3 * j + 1], arrived[at + 3 * j + 2]
        if ar + ag + ab == 0.0:
            continue
        light = light_of_lamp(lit, j, random, point.x, point.y, point.z)
        lx, ly, lz = light.d
        size = math.sqrt(dot(lx, ly, lz, lx, ly, lz))
        lx, ly, lz = lx / size, ly / size, lz / size
        cosine = diffuse_light(row, lx, ly, lz, point)
        shine = highlight(row, lx, ly, lz, point)
        r, g, b = _PER_PI * ar * light.r, _PER_PI * ag * light.g, _PER_PI * ab * light.b
        dr, dg, db = dr + r * cosine, dg + g * cosine, db + b * cosine
        hr, hg, hb = hr + r * shine, hg + g * shine, hb + b * shine
    return dr, dg, db, hr, hg, hb


# --- Rays still to be followed, with their weights: recursion by a stack

FAINT = 2.0**-12
"""A ray that adds less than this share of the light that it finds is not followed."""


class PendingRay(NamedTuple):
    """A ray to be followed."""

    x: float
    y: float
    z: float
    dx: float  # unit
    dy: float
    dz: float
    r: float  # its weight
    g: float
    b: float
    start: Any  # the surface that it lies on
    turns: Any  # how often it may be mirrored or refracted yet
    medium: Any  # that it starts in


class Stack(NamedTuple):
    """One row a ray."""

    floats: Floats  # as `Pending`, the first nine
    numbers: npt.NDArray[np.int64]  # and the others


@allocator
def new_stack(depth: int) -> Stack:
    """Return a stack for rays of at most `depth` turns: each level leaves at most one ray waiting."""
    return Stack(np.empty((depth + 2, 9)), np.empty((depth + 2, 3), np.int64))


@inline
def push(stack: Stack, size: int, ray: PendingRay) -> int:
    """Add a ray unless it is too faint to matter; return the new size."""
    x, y, z, dx, dy, dz, r, g, b, start, turns, medium = ray
    if max(r, max(g, b)) < FAINT:
        return size
    row = stack.floats[size]
    row[0], row[1], row[2], row[3], row[4], row[5] = x, y, z, dx, dy, dz
    row[6], row[7], row[8] = r, g, b
    stack.numbers[size, 0], stack.numbers[size, 1], stack.numbers[size, 2] = start, turns, medium
    return size + 1


@inline
def load_pending(stack: Stack, k: int) -> PendingRay:
    """Return ray k of a stack."""
    row, numbers = stack.floats[k], stack.numbers[k]
    return PendingRay(
        row[0], row[1], row[2], row[3], row[4], row[5], row[6], row[7], row[8], numbers[0], numbers[1], numbers[2]
    )


# --- Local light, the mirrored and the refracted ray
#
# Turner Whitted, An improved illumination model for shaded display, CACM 23 (1980), with Fresnel's
# weights. The effect of a wall of transparent solids is decided on the ray itself, by the media before and
# after the crossing, all walls that coincide there taken together. Where they are the same material the wall is
# invisible; so nested, abutting and overlapping dielectrics need no gap and no care, and the body
# listed first has priority where two overlap.


@inline
def find_interaction(
    geometry: Geometry, scratch: Scratch, materials: MaterialTable, ray: Ray, hit: Hit
) -> SurfaceInteraction:
    """Return the first wall that light notices along a ray whose first crossing is `hit`; body -1 if there is none."""
    crossed = resolve_hit(geometry, hit)
    outside: Any = whole(OUTSIDE)
    before, after = outside, outside
    if crossed.body >= 0 and materials.any_transparent:
        crossed, before, after = first_visible_wall(geometry, scratch, materials, ray, crossed)
    t, body, surface, face, side = crossed
    if body < 0:
        return SurfaceInteraction(t, body, surface, face, side, before, after, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    x, y, z = ray.ox + t * ray.dx, ray.oy + t * ray.dy, ray.oz + t * ray.dz
    nx, ny, nz = normal_at(geometry, surface, side, x, y, z)
    return SurfaceInteraction(t, body, surface, face, side, before, after, x, y, z, nx, ny, nz)


@helper
def first_visible_wall(
    geometry: Geometry, scratch: Scratch, materials: MaterialTable, ray: Ray, crossed: ResolvedHit
) -> tuple[ResolvedHit, int, int]:
    """Return (the first wall that light notices from a crossing of a ray on, the media before and after).

    An opaque surface always is one, also where a transparent wall coincides with it.
    """
    outside: Any = whole(OUTSIDE)
    before, after = outside, outside
    while crossed.body >= 0:
        t = crossed.t
        if materials.opaque[crossed.body] == 0:
            here = with_limits(ray, next_float_down(t), next_float_up(t))
            other = first_crossing(geometry, scratch, here, materials.opaque, False)
            if other.body >= 0:
                _, body, surface, face, side = resolve_hit(geometry, other)
                crossed = ResolvedHit(t, body, surface, face, side)
        in_front, medium_behind = find_media(geometry, scratch, with_limits(ray, 0.0, math.inf), t, materials.medium)
        before, after = body_medium(materials, in_front), body_medium(materials, medium_behind)
        if materials.medium[crossed.body] == 0 or not is_invisible_wall(materials, crossed.body, before, after):
            break
        crossed = resolve_first_crossing(geometry, scratch, with_limits(ray, t, math.inf))
    return crossed, before, after


@helper
def medium_at(geometry: Geometry, scratch: Scratch, materials: MaterialTable, x: float, y: float, z: float) -> int:
    """Return the medium at a point, for a scene with transparent bodies."""
    ray = Ray(x, y, z, 0.0, 0.0, 1.0, 0.0, math.inf, whole(NO_SURFACE))
    return body_medium(materials, find_media(geometry, scratch, ray, 0.0, materials.medium)[1])


@inline
def shade(
    geometry: Geometry,
    lit: WhittedLight,
    stack: Stack,
    size: int,
    ray: PendingRay,
    sight: SurfaceInteraction,
    arrived: Floats,
    at: int,
    random: tuple[int, int, int],
) -> tuple[float, float, float, int]:
    """Return (rgb that a point sends back along a ray, new size of the stack); push the rays that it sends on.

    arrived[at:]: the share of each light and lamp that reaches the point; random: seed, pixel and sample.
    """
    look, materials = lit.look, lit.look.materials
    _, _, _, dx, dy, dz, wr, wg, wb, _, turns, _ = ray
    wr, wg, wb = absorb(materials, sight.before, sight.t, wr, wg, wb)
    number = material_row(geometry, materials, sight.body, sight.face)
    row = materials.rows[number]
    cr, cg, cb = surface_color(geometry, materials, sight)
    point, cosine, from_inside = face_viewer(sight, dx, dy, dz)
    gx, gy, gz, bent = point.nx, point.ny, point.nz, has_relief(row)
    if bent:
        point = bend_normal(geometry, materials, sight, number, point, from_inside)
        cosine = dot(point.nx, point.ny, point.nz, point.ex, point.ey, point.ez)
    x, y, z, nx, ny, nz, _, _, _ = point

    # How light parts there: F is reflected, of the rest a share goes through
    refracts = materials.medium[sight.body] == 1
    fr, fg, fb = mirror_share(row, cosine)
    tx, ty, tz = dx, dy, dz
    if refracts:
        eta = medium_index(materials, sight.before) / medium_index(materials, sight.after)
        tx, ty, tz, fr = split_at_wall((dx, dy, dz), (nx, ny, nz), cosine, eta)
        fg, fb = fr, fr
        if bent:
            tx, ty, tz = mirror_to_side(tx, ty, tz, gx, gy, gz, False)
    pr, pg, pb = row.transparency[0], row.transparency[1], row.transparency[2]

    # Its own light
    red, green, blue = 0.0, 0.0, 0.0
    if shows_light(materials, sight, from_inside):
        dr, dg, db, hr, hg, hb = direct_light(look, row, arrived, at, point)
        if lamp_count(lit.lamps) > 0:
            behind = at + 3 * len(look.lights)
            lr, lg, lb, sr, sg, sb = lamp_light(lit, random, row, arrived, behind, point)
            dr, dg, db, hr, hg, hb = dr + lr, dg + lg, db + lb, hr + sr, hg + sg, hb + sb
        ka, kd = row.ambient, row.diffuse
        ar, ag, ab = look.ambient
        red = wr * (cr * (ka * ar + kd * dr) * (1.0 - fr) * (1.0 - pr) + row.specular[0] * hr)
        green = wg * (cg * (ka * ag + kd * dg) * (1.0 - fg) * (1.0 - pg) + row.specular[1] * hg)
        blue = wb * (cb * (ka * ab + kd * db) * (1.0 - fb) * (1.0 - pb) + row.specular[2] * hb)
    red, green, blue = red + wr * row.emission[0], green + wg * row.emission[1], blue + wb * row.emission[2]

    # On along the refracted and the mirrored ray
    if turns > 0:
        size = push(stack, size, PendingRay(
            x, y, z, tx, ty, tz, wr * (1.0 - fr) * pr, wg * (1.0 - fg) * pg, wb * (1.0 - fb) * pb,
            sight.surface, turns - 1, sight.after if refracts else sight.before,
        ))  # fmt: skip
        mx, my, mz = reflect(dx, dy, dz, nx, ny, nz)
        if bent:
            mx, my, mz = mirror_to_side(mx, my, mz, gx, gy, gz, True)
        size = push(stack, size, PendingRay(
            x, y, z, mx, my, mz, wr * fr, wg * fg, wb * fb, sight.surface, turns - 1, sight.before,
        ))  # fmt: skip
    return red, green, blue, size


@inline
def sky(look: Any, medium: int, dz: float, wr: float, wg: float, wb: float) -> tuple[float, float, float]:
    """Return rgb of the background along a unit direction, seen from a medium."""
    wr, wg, wb = absorb(look.materials, medium, math.inf, wr, wg, wb)
    r, g, b = background_color(look.background, dz)
    return wr * r, wg * g, wb * b


@inline
def _follow(
    geometry: Geometry, scratch: Scratch, stack: Stack, size: int, lit: WhittedLight, arrived: Floats,
    random: tuple[int, int, int],
) -> tuple[float, float, float, int]:  # fmt: skip
    """Return (linear rgb of the light that a ray beside the top of the stack finds, new size of the stack).

    The ray is the one in row `size`; the rays that it sends on take its place.
    """
    look, materials, left = lit.look, lit.look.materials, load_pending(stack, size)
    dx, dy, dz = left.dx, left.dy, left.dz
    ray = Ray(left.x, left.y, left.z, dx, dy, dz, 0.0, math.inf, left.start)
    hit = first_crossing(geometry, scratch, ray, scratch.nothing, False)
    sight = find_interaction(geometry, scratch, materials, ray, hit)
    if sight.body < 0:
        r, g, b = sky(look, left.medium, dz, left.r, left.g, left.b)
        return r, g, b, size
    shadow_lights(geometry, scratch, look, arrived, sight, dx, dy, dz)
    if lamp_count(lit.lamps) > 0:
        shadow_lamps(geometry, scratch, lit, random, arrived, sight, dx, dy, dz)
    return shade(geometry, lit, stack, size, left, sight, arrived, 0, random)


@helper
def trace_secondary(
    geometry: Geometry, scratch: Scratch, stack: Stack, size: int, lit: WhittedLight, arrived: Floats,
    random: tuple[int, int, int],
) -> tuple[float, float, float]:  # fmt: skip
    """Return linear rgb of the light along the rays on the stack."""
    red, green, blue = 0.0, 0.0, 0.0
    while size > 0 and not is_halted(geometry):
        r, g, b, size = _follow(geometry, scratch, stack, size - 1, lit, arrived, random)
        red, green, blue = red + r, green + g, blue + b
    return red, green, blue


# One ray of the camera

MOST_TURNS, MOST_LIGHTS = 30, 64
"""The most turns of a ray, and lights and lamps together, for which `RayMemory` has room."""


@record_shapes(floats=f"{MOST_TURNS + 2} 9", numbers=f"{MOST_TURNS + 2} 3", arrived=str(3 * MOST_LIGHTS))
class RayMemory(NamedTuple):
    """Memory of a fixed size, for a thread of a GPU."""

    floats: Floats  # of a `Stack`
    numbers: Longs
    arrived: Floats  # the share of each light and lamp that reaches a hit

    @classmethod
    def holds(cls, settings: Settings) -> bool:
        """Return whether there is room for the rays of a picture."""
        lights = len(settings.look.look.lights) + lamp_count(settings.look.lamps)
        return settings.depth <= MOST_TURNS and lights <= MOST_LIGHTS


@helper
def radiance(
    geometry: Geometry, scratch: Scratch, memory: RayMemory, settings: Settings, ray: Ray, pixel: int, sample: int
) -> tuple[float, float, float]:
    """`gather` for a single ray: the light of its hit, and the sum of all further light."""
    lit, stack, random = settings.look, Stack(memory.floats, memory.numbers), (settings.seed, pixel, sample)
    materials, medium = lit.look.materials, whole(OUTSIDE)
    if materials.any_transparent:
        medium = medium_at(geometry, scratch, materials, ray.ox, ray.oy, ray.oz)
    turns: Any = whole(settings.depth)
    size = push(stack, 0, PendingRay(
        ray.ox, ray.oy, ray.oz, ray.dx, ray.dy, ray.dz, 1.0, 1.0, 1.0, ray.start, turns, medium,
    ))  # fmt: skip
    red, green, blue, mine, is_first = 0.0, 0.0, 0.0, (0.0, 0.0, 0.0), True
    while size > 0:
        r, g, b, size = _follow(geometry, scratch, stack, size - 1, lit, memory.arrived, random)
        if is_first:
            mine, is_first = (r, g, b), False
        else:
            red, green, blue = red + r, green + g, blue + b
    return mine[0] + red, mine[1] + green, mine[2] + blue


# --- Packets of 64 pixels
#
# The rays of the camera and their shadows go in packets. Rays that are mirrored or refracted scatter; they are followed
# one by one. The formulas are the same, so the colours are the same to the bit. Hits in doubt are taken as they are,
# here and in `path`: such a ray grazes a surface, or hits two within rounding, and either answer is right for a picture
# (docs/lighting.md).

_MEDIUM, _SHADOW_RAYS, _LAMP = 13, 14, 15
"""Columns behind an interaction: the medium that the ray starts in; 1 for a shadow ray, else 0; the body of the lamp
that it should hit."""
_NUMBERS = 16


class PacketMemory(NamedTuple):
    """The hits of a packet of rays, a row a lane, and their shadow rays."""

    stack: Stack  # mirrored and refracted rays
    shadow: Floats  # the lanes of rays from hits to a light
    sights: Floats  # (64, _NUMBERS) hits as `SurfaceInteraction`, and more
    arrived: Floats  # (64 · (lights + lamps) · 3) the share of each light and lamp that reaches a hit
    further: Floats  # ((lights + lamps) · 3) the same for the hit of a mirrored or refracted ray


@allocator
def new_memory(geometry: Geometry, settings: Settings) -> PacketMemory:
    """Return memory for one thread."""
    numbers = 3 * max(1, len(settings.look.look.lights) + lamp_count(settings.look.lamps))
    return PacketMemory(
        new_stack(settings.depth), new_lanes(), np.empty((LANES, _NUMBERS)), np.empty(numbers * LANES),
        np.empty(numbers),
    )  # fmt: skip


@inline
def _store_interaction(row: Floats, sight: SurfaceInteraction) -> None:
    """Write an interaction into a row."""
    row[0], row[1], row[2], row[3], row[4], row[5], row[6] = (
        sight.t, sight.body, sight.surface, sight.face, sight.side, sight.before, sight.after,
    )  # fmt: skip
    row[7], row[8], row[9], row[10], row[11], row[12] = sight.x, sight.y, sight.z, sight.nx, sight.ny, sight.nz


@inline
def _load_interaction(row: Floats) -> SurfaceInteraction:
    """Return the interaction in a row."""
    return SurfaceInteraction(
        row[0], whole(row[1]), whole(row[2]), whole(row[3]), whole(row[4]), whole(row[5]), whole(row[6]),
        row[7], row[8], row[9], row[10], row[11], row[12],
    )  # fmt: skip


@helper
def _start_media(
    geometry: Geometry, scratch: Scratch, wave: PacketMemory, materials: MaterialTable, samples: Samples
) -> None:
    """Find the media that the rays start in."""
    for i in range(samples.size):
        wave.sights[i, _MEDIUM] = OUTSIDE
        if materials.any_transparent:
            x, y, z, _, _, _, _, _, _ = lane_ray(samples.packet.lanes, i, 0.0)
            wave.sights[i, _MEDIUM] = medium_at(geometry, scratch, materials, x, y, z)


@inline
def _direction(lanes: Floats, i: int) -> tuple[float, float, float]:
    """Return the direction of the ray in lane i."""
    lane = np.uint64(i)
    return lanes[DX + lane], lanes[DY + lane], lanes[DZ + lane]


@helper
def _find_interactions(
    geometry: Geometry, scratch: Scratch, wave: PacketMemory, look: ShadingTables, samples: Samples
) -> None:
    """Trace the rays and store their interactions."""
    lanes = samples.packet.lanes
    trace_samples(geometry, scratch, samples)
    for i in range(samples.size):
        sight = find_interaction(geometry, scratch, look.materials, lane_ray(lanes, i, math.inf), lane_hit(lanes, i))
        _store_interaction(wave.sights[i], sight)


@helper
def _shadow_rays(
    geometry: Geometry, wave: PacketMemory, lit: WhittedLight, k: int, seed: int, stride: int, samples: Samples
) -> int:
    """Put rays to light or lamp k into the lanes that it may light; return one of these lanes, or -1 for none."""
    lanes, look, some = wave.shadow, lit.look, -1
    for i in range(samples.size):
        at, sight = 3 * (stride * i + k), _load_interaction(wave.sights[i])
        wave.sights[i, _SHADOW_RAYS] = 0.0
        wave.arrived[at], wave.arrived[at + 1], wave.arrived[at + 2] = 0.0, 0.0, 0.0
        if sight.body < 0:
            continue
        dx, dy, dz = _direction(samples.packet.lanes, i)
        shows, number, point = shading_point_of(geometry, look.materials, sight, dx, dy, dz)
        if not shows:
            continue
        row = look.materials.rows[number]
        if k < len(look.lights):
            ray, is_traced = shadow_ray(look.lights[k], row, point, sight.surface)
            if is_traced and has_relief(row):
                is_traced = not is_behind(sight, dx, dy, dz, ray.dx, ray.dy, ray.dz)
        else:
            random = seed, samples.pixels[i], samples.sample
            ray, body, is_traced = lamp_ray(lit, k - len(look.lights), random, sight, row, point, dx, dy, dz)
            wave.sights[i, _LAMP] = body
        if is_traced:
            put_ray(lanes, i, ray)
            wave.sights[i, _SHADOW_RAYS], some = 1.0, i
    return some


@helper
def _shadow_light(
    geometry: Geometry, scratch: Scratch, wave: PacketMemory, lit: WhittedLight, k: int, seed: int, stride: int,
    samples: Samples,
) -> None:  # fmt: skip
    """Compute how much of light k reaches the hits; lamps follow lights. stride: the number of both.

    Any body covers a light. A lamp is covered unless the first body on the ray is its own.
    """
    lanes, materials, is_lamp = wave.shadow, lit.look.materials, k >= len(lit.look.lights)
    some = _shadow_rays(geometry, wave, lit, k, seed, stride, samples)
    if some < 0:
        return
    for i in range(LANES):
        if i >= samples.size or wave.sights[i, _SHADOW_RAYS] == 0.0:
            put_idle(lanes, i, some)
    prepare_lanes(lanes)
    put_lane_beam(lanes, False)
    if not is_lamp and lit.look.lights[k].parallel == 0:
        position = lit.look.lights[k].position
        put_beam_from(lanes, position[0], position[1], position[2])
    together = is_coherent(geometry, lanes)
    if together:
        trace_packet(geometry, scratch, with_lanes(samples.packet, lanes), materials.opaque, not is_lamp)
    for i in range(samples.size):
        if wave.sights[i, _SHADOW_RAYS] == 0.0:
            continue
        ray = lane_ray(lanes, i, lanes[T_MAX + np.uint64(i)])
        if together:
            hit = lane_hit(lanes, i)
        else:
            hit = first_crossing(geometry, scratch, ray, materials.opaque, not is_lamp)
        at, inside = 3 * (stride * i + k), _load_interaction(wave.sights[i]).before
        covered = hit.t < math.inf
        if is_lamp:
            ray, covered = with_limits(ray, 0.0, min(ray.t_max, hit.t)), hit.body != whole(wave.sights[i, _LAMP])
        wave.arrived[at], wave.arrived[at + 1], wave.arrived[at + 2] = shadow_transmittance(
            geometry, scratch, materials, ray, inside, covered
        )


@helper
def gather(geometry: Geometry, scratch: Scratch, wave: PacketMemory, settings: Settings, samples: Samples) -> None:
    """Add the light along the rays, after at most `settings.depth` turns."""
    lit, depth, stack, colors = settings.look, settings.depth, wave.stack, samples.colors
    look = lit.look
    _start_media(geometry, scratch, wave, look.materials, samples)
    _find_interactions(geometry, scratch, wave, look, samples)
    stride = len(look.lights) + lamp_count(lit.lamps)
    for k in range(stride):
        _shadow_light(geometry, scratch, wave, lit, k, settings.seed, stride, samples)
    for i in range(samples.size):
        sight = _load_interaction(wave.sights[i])
        x, y, z, dx, dy, dz, _, _, start = lane_ray(samples.packet.lanes, i, math.inf)
        ray = PendingRay(x, y, z, dx, dy, dz, 1.0, 1.0, 1.0, start, depth, whole(wave.sights[i, _MEDIUM]))
        if sight.body < 0:
            r, g, b = sky(look, ray.medium, dz, 1.0, 1.0, 1.0)
        else:
            random = settings.seed, samples.pixels[i], samples.sample
            r, g, b, size = shade(geometry, lit, stack, 0, ray, sight, wave.arrived, 3 * stride * i, random)
            if size > 0:
                red, green, blue = trace_secondary(geometry, scratch, stack, size, lit, wave.further, random)
                r, g, b = r + red, g + green, b + blue
        colors[i, 0] += r
        colors[i, 1] += g
        colors[i, 2] += b
