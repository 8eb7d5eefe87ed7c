"""Lamps in Whitted's pictures: their light, with soft shadows, from one point of each for each sample of a pixel.

The points are those of light transport's sampler, so a picture is the same for any order of work, and its shadows
become smooth as samples are added. What a ray meets after it was mirrored or refracted asks at the same places as the
camera's ray: each by itself, these are as evenly spread. Up to `ASKED` lamps are all asked; of more, so many are drawn
by what might arrive from them.

Radiance L in the solid angle dω gives what a light of intensity L dω / π would.
"""

from __future__ import annotations

import math
from typing import Any

from ..compiler.jit import helper, inline
from ..emitters.draw import Lit, chosen, lamp_lit
from ..emitters.lamplight import Lamplight
from ..emitters.sources import Sources
from ..engine.body.scratch import Scratch
from ..engine.numbers.vectors import dot
from ..engine.ray import Ray, with_limits
from ..engine.single.first import first_crossing
from ..engine.tables import Floats, Geometry
from ..shading.local import highlight, shown
from ..shading.relief import has_relief, is_behind
from ..shading.shadow import light_along
from ..shading.sight import ShadingPoint, Sight
from .sobol import sobol_pair

ASKED = 8
_FIRST_PAIR = 8
_PER_PI = 1.0 / math.pi


@inline
def lamp_count(lamps: Sources) -> int:
    """How many lamps a point asks."""
    return min(ASKED, len(lamps.records))


@helper
def light_of_lamp(lit: Lamplight, j: int, random: tuple[int, int, int], x: float, y: float, z: float) -> Lit:
    """What comes from the j-th lamp that a point asks, if nothing is in between. random: seed, pixel and sample."""
    seed, pixel, sample = random
    u, v = sobol_pair(seed, pixel, sample, _FIRST_PAIR + 2 * j)
    k, likely = j, 1.0
    if len(lit.lamps.records) > ASKED:
        choice, _ = sobol_pair(seed, pixel, sample, _FIRST_PAIR + 2 * j + 1)
        k, likely = chosen(lit.look, lit.lamps, x, y, z, choice)
        likely *= ASKED
    return lamp_lit(lit.lamps, k, likely, x, y, z, u, v)


@helper
def lamp_ray(
    lit: Lamplight, j: int, random: tuple[int, int, int], sight: Sight, row: Any, point: ShadingPoint,
    dx: float, dy: float, dz: float,
) -> tuple[Ray, int, bool]:  # fmt: skip
    """(the ray from what is seen along unit d to a lamp, the body that it is to meet first, is it worth tracing?)"""
    found = light_of_lamp(lit, j, random, point.x, point.y, point.z)
    lx, ly, lz = found.d
    ray = Ray(point.x, point.y, point.z, lx, ly, lz, 0.0, found.end, sight.surface)
    shows = row.diffuse > 0.0 or row.specular[0] + row.specular[1] + row.specular[2] > 0.0
    asked = shows and found.end > 0.0 and dot(point.nx, point.ny, point.nz, lx, ly, lz) > 0.0
    if asked and has_relief(row):
        asked = not is_behind(sight, dx, dy, dz, lx, ly, lz)
    return ray, found.body, asked


@helper
def ask_lamps(
    geometry: Geometry, scratch: Scratch, lit: Lamplight, random: tuple[int, int, int], arrived: Floats, sight: Sight,
    dx: float, dy: float, dz: float,
) -> None:  # fmt: skip
    """How much of each lamp's light (rgb, into `arrived`, behind that of lights) reaches what is seen along unit d."""
    materials, first = lit.look.materials, 3 * len(lit.look.lights)
    shows, number, point = shown(geometry, materials, sight, dx, dy, dz)
    if not shows:
        return
    for j in range(lamp_count(lit.lamps)):
        ray, body, asked = lamp_ray(lit, j, random, sight, materials.rows[number], point, dx, dy, dz)
        r, g, b = 0.0, 0.0, 0.0
        if asked:
            hit = first_crossing(geometry, scratch, ray, materials.opaque, False)
            ray = with_limits(ray, 0.0, min(ray.t_max, hit.t))
            r, g, b = light_along(geometry, scratch, materials, ray, sight.before, hit.body != body)
        arrived[first + 3 * j], arrived[first + 3 * j + 1], arrived[first + 3 * j + 2] = r, g, b


@helper
def lamp_light(
    lit: Lamplight, random: tuple[int, int, int], row: Any, arrived: Floats, at: int, point: ShadingPoint
) -> tuple[float, float, float, float, float, float]:
    """(Σ I N·L, Σ I h), each rgb, over the lamps, of whose light arrived[at:] reaches the point."""
    dr, dg, db, hr, hg, hb = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(lamp_count(lit.lamps)):
        ar, ag, ab = arrived[at + 3 * j], arrived[at + 3 * j + 1], arrived[at + 3 * j + 2]
        if ar + ag + ab == 0.0:
            continue
        found = light_of_lamp(lit, j, random, point.x, point.y, point.z)
        lx, ly, lz = found.d
        size = math.sqrt(dot(lx, ly, lz, lx, ly, lz))
        lx, ly, lz = lx / size, ly / size, lz / size
        cosine = dot(point.nx, point.ny, point.nz, lx, ly, lz)
        shine = highlight(row, lx, ly, lz, point)
        r, g, b = _PER_PI * ar * found.r, _PER_PI * ag * found.g, _PER_PI * ab * found.b
        dr, dg, db = dr + r * cosine, dg + g * cosine, db + b * cosine
        hr, hg, hb = hr + r * shine, hg + g * shine, hb + b * shine
    return dr, dg, db, hr, hg, hb
