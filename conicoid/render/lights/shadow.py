"""Transmittance of shadow rays: the share of a light that reaches a point.

Opaque bodies block light. In Whitted's pictures light goes straight through transparent bodies (no path follows the
light that refraction bundles): each wall lets through 1 - F for the angle from the rarer side, times the body's
transparency, and the way inside absorbs by Beer's law. In light transport only panes, and walls between equal indices,
let light straight through; paths find the light that is refracted.
"""

from __future__ import annotations

import math

from ..._jit.decorators import helper, inline
from ...kernels.body.media import find_media
from ...kernels.body.scratch import Scratch
from ...kernels.entry.first_hits import resolve_first_crossing
from ...kernels.numbers.vectors import dot
from ...kernels.ray import Ray, with_limits
from ...kernels.surface.records import normal_at
from ...kernels.tables import Geometry
from ..bsdf.dielectric import wall_reflectance
from ..bsdf.layered import pane_share
from ..bsdf.material_table import MaterialTable, material_row
from ..bsdf.medium import absorb, body_medium, medium_index, medium_transmittance


@inline
def shadow_transmittance(
    geometry: Geometry, scratch: Scratch, materials: MaterialTable, ray: Ray, inside: int, covered: bool
) -> tuple[float, float, float]:
    """Return the share, rgb, of Whitted's light at the end of a ray that reaches its origin, in medium `inside`.

    `covered`: an opaque body is in the way.
    """
    if covered:
        return 0.0, 0.0, 0.0
    if not materials.any_transparent:
        return 1.0, 1.0, 1.0
    return _through_glass(geometry, scratch, materials, ray, inside)


@helper
def _through_glass(
    geometry: Geometry, scratch: Scratch, materials: MaterialTable, ray: Ray, inside: int
) -> tuple[float, float, float]:
    """Return `shadow_transmittance` where no opaque body is in the way."""
    x, y, z, lx, ly, lz, _, end, _ = ray
    r, g, b = 1.0, 1.0, 1.0
    length = math.sqrt(dot(lx, ly, lz, lx, ly, lz))
    done = 0.0
    while True:
        t, body, surface, face, side = resolve_first_crossing(geometry, scratch, ray)
        if body < 0:
            break
        before, after = find_media(geometry, scratch, ray, t, materials.medium)
        inside, beyond = body_medium(materials, before), body_medium(materials, after)
        if materials.medium[body] == 0 or inside != beyond:
            r, g, b = absorb(materials, inside, (t - done) * length, r, g, b)
            nx, ny, nz = normal_at(geometry, surface, side, x + t * lx, y + t * ly, z + t * lz)
            cosine = abs(dot(lx, ly, lz, nx, ny, nz)) / length
            kept = 1.0 - wall_reflectance(cosine, medium_index(materials, inside), medium_index(materials, beyond))
            row = materials.rows[material_row(geometry, materials, body, face)]
            r, g, b = r * kept * row.transparency[0], g * kept * row.transparency[1], b * kept * row.transparency[2]
            inside, done = beyond, t
        ray = with_limits(ray, t, end)
    return absorb(materials, inside, (end - done) * length, r, g, b)


@helper
def straight_transmittance(
    geometry: Geometry, scratch: Scratch, materials: MaterialTable, ray: Ray, inside: int
) -> tuple[float, float, float]:
    """Return the share, rgb, of light from the end of a ray that comes straight to its origin, in medium `inside`.

    For light transport. No opaque body is in the way. Panes and walls between equal indices let light through; of light
    that other walls bend aside nothing comes straight.
    """
    x, y, z, lx, ly, lz, _, end, _ = ray
    r, g, b, done = 1.0, 1.0, 1.0, 0.0
    length = math.sqrt(dot(lx, ly, lz, lx, ly, lz))
    while True:
        t, body, surface, face, side = resolve_first_crossing(geometry, scratch, ray)
        if body < 0:
            break
        before, after = find_media(geometry, scratch, ray, t, materials.medium)
        before, after = body_medium(materials, before), body_medium(materials, after)
        tr, tg, tb = medium_transmittance(materials, before, (t - done) * length)
        r, g, b, inside, done = r * tr, g * tg, b * tb, after, t
        row = materials.rows[material_row(geometry, materials, body, face)]
        if materials.medium[body] == 0:
            nx, ny, nz = normal_at(geometry, surface, side, x + t * lx, y + t * ly, z + t * lz)
            tr, tg, tb = pane_share(row, abs(dot(lx, ly, lz, nx, ny, nz)) / length)
            r, g, b = r * tr, g * tg, b * tb
        elif before != after:
            if medium_index(materials, before) != medium_index(materials, after):
                return 0.0, 0.0, 0.0
            r, g, b = r * row.transparency[0], g * row.transparency[1], b * row.transparency[2]
        if r + g + b == 0.0:
            return 0.0, 0.0, 0.0
        ray = with_limits(ray, t, end)
    tr, tg, tb = medium_transmittance(materials, inside, (end - done) * length)
    return r * tr, g * tg, b * tb
