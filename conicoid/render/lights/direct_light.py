"""Direct light: the diffuse light and the highlights of point and parallel lights in Whitted's method, and shadow rays.

The laws come from the kinds of surface (`bsdf.registry`). The colour of a surface is here too, for all integrators.

Opaque bodies block light. In Whitted's pictures light goes straight through transparent bodies (no path follows the
light that refraction bundles): each wall lets through 1 - F for the angle from the rarer side, times the body's
transparency, and the way inside absorbs by Beer's law. In light transport only panes, and walls between equal indices,
let light straight through; paths find the light that is refracted.
"""

from __future__ import annotations

import math
from typing import Any

from ..._jit.decorators import helper, inline
from ...kernels.body.media import find_media
from ...kernels.body.scratch import Scratch
from ...kernels.body.uv import uv_at
from ...kernels.first_hits import is_blocked, resolve_first_crossing
from ...kernels.numbers.vectors import dot
from ...kernels.ray import Ray, with_limits
from ...kernels.surface.records import normal_at
from ...kernels.tables import Floats, Geometry
from ..bsdf.dielectric import wall_reflectance
from ..bsdf.layered import pane_share
from ..bsdf.material_table import (
    CHECKER_UV,
    PLAIN,
    TEXTURED,
    MaterialTable,
    checker_color,
    color_in_space,
    color_on_uv,
    material_row,
)
from ..bsdf.medium import absorb, body_medium, medium_index, medium_transmittance
from ..bsdf.registry import diffuse_cosine, kind_highlight
from ..interaction import (
    ShadingPoint,
    SurfaceInteraction,
    bend_normal,
    face_viewer,
    has_relief,
    is_behind,
    shows_light,
    texture_place,
)
from ..textures import texture_color
from .light_tables import ShadingTables, light_direction, light_share


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
        # All walls but those between two bodies of one glass reflect and absorb
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


# --- Whitted's local light

_FAINT = 1e-5  # a highlight fainter than this gets no shadow ray


@inline
def surface_color(
    geometry: Geometry, materials: MaterialTable, sight: SurfaceInteraction
) -> tuple[float, float, float]:
    """Return the diffuse colour at a point, linear rgb."""
    row = materials.rows[material_row(geometry, materials, sight.body, sight.face)]
    if row.pattern == PLAIN:
        return checker_color(row, True)
    if row.pattern == CHECKER_UV:
        u, v = uv_at(geometry, sight.body, sight.face, sight.surface, sight.x, sight.y, sight.z)
        return color_on_uv(row, u, v)
    if row.pattern == TEXTURED:
        return texture_color(
            geometry, materials.textures, materials.texels, row.texture, texture_place(materials, sight)
        )
    return color_in_space(row, sight.x, sight.y, sight.z, sight.nx, sight.ny, sight.nz)


@inline
def highlight(row: Any, lx: float, ly: float, lz: float, point: ShadingPoint) -> float:
    """Return the material's highlight of light from unit l."""
    return kind_highlight(row, (lx, ly, lz), (point.ex, point.ey, point.ez), (point.nx, point.ny, point.nz))


@inline
def diffuse_light(row: Any, lx: float, ly: float, lz: float, point: ShadingPoint) -> float:
    """Return the factor of the material's diffuse colour for light from unit l: N·L, unless its kind has its own."""
    return diffuse_cosine(row, (lx, ly, lz), (point.ex, point.ey, point.ez), (point.nx, point.ny, point.nz))


@inline
def evaluate_light(light: Any, row: Any, point: ShadingPoint) -> tuple[float, float, float, float, float, float, float]:
    """Return (lx, ly, lz, end, diffuse factor, highlight, share) of a light at a point.

    l is the direction of the ray to the light, not of unit length, which ends at the parameter `end`. The share is that
    of the light's intensity, without shadows; 0 where the light adds nothing.
    """
    return _evaluate_light(light, row, point, True)


@inline
def _evaluate_light(
    light: Any, row: Any, point: ShadingPoint, shines: bool
) -> tuple[float, float, float, float, float, float, float]:
    """Return `evaluate_light`; the highlight is left 0 if not `shines`."""
    lx, ly, lz, end = light_direction(light, point.x, point.y, point.z)
    distance = math.sqrt(dot(lx, ly, lz, lx, ly, lz))
    # A lamp at the very point has no direction
    if distance == 0.0:
        return lx, ly, lz, end, 0.0, 0.0, 0.0
    ux, uy, uz = lx / distance, ly / distance, lz / distance
    cosine = dot(point.nx, point.ny, point.nz, ux, uy, uz)
    # Lights behind the surface add nothing, not even a highlight
    if cosine <= 0.0:
        return lx, ly, lz, end, cosine, 0.0, 0.0
    shiny = shines and row.specular[0] + row.specular[1] + row.specular[2] > 0.0
    shine = highlight(row, ux, uy, uz, point) if shiny else 0.0
    part = light_share(light, ux, uy, uz, distance)
    # A shadow ray costs more than a highlight that nobody sees
    if row.diffuse == 0.0 and shine < _FAINT:
        part = 0.0
    return lx, ly, lz, end, diffuse_light(row, ux, uy, uz, point), shine, part


@inline
def shading_point_of(
    geometry: Geometry, materials: MaterialTable, sight: SurfaceInteraction, dx: float, dy: float, dz: float
) -> tuple[bool, int, ShadingPoint]:
    """Return (whether lights show on the hit of a ray along d, the row of its material, the point with its normal)."""
    point, _, from_inside = face_viewer(sight, dx, dy, dz)
    row = material_row(geometry, materials, sight.body, sight.face)
    if has_relief(materials.rows[row]):
        point = bend_normal(geometry, materials, sight, row, point, from_inside)
    return shows_light(materials, sight, from_inside), row, point


@inline
def shadow_ray(light: Any, row: Any, point: ShadingPoint, surface: int) -> tuple[Ray, bool]:
    """Return (the ray from a point of a surface to a light, whether it is worth tracing).

    Only this function decides which lights get shadow rays. It computes the highlight, a costly power, only where the
    decision depends on it: without a diffuse part.
    """
    lx, ly, lz, end, _, _, part = _evaluate_light(light, row, point, row.diffuse == 0.0)
    return Ray(point.x, point.y, point.z, lx, ly, lz, 0.0, end, surface), part != 0.0


@helper
def shadow_lights(
    geometry: Geometry,
    scratch: Scratch,
    look: ShadingTables,
    arrived: Floats,
    sight: SurfaceInteraction,
    dx: float,
    dy: float,
    dz: float,
) -> None:
    """Write the share of each light, rgb, that reaches the hit of a ray along unit d, into `arrived` (3 lights).

    `whitted` does the same for the rays of a packet. Nothing is written where lights do not show, or for lights that
    get no ray.
    """
    materials = look.materials
    shows, number, point = shading_point_of(geometry, materials, sight, dx, dy, dz)
    if not shows:
        return
    row = materials.rows[number]
    for k in range(len(look.lights)):
        ray, traced = shadow_ray(look.lights[k], row, point, sight.surface)
        if traced and has_relief(row) and is_behind(sight, dx, dy, dz, ray.dx, ray.dy, ray.dz):
            arrived[3 * k], arrived[3 * k + 1], arrived[3 * k + 2] = 0.0, 0.0, 0.0
        elif traced:
            covered = is_blocked(geometry, scratch, ray, materials.opaque)
            arrived[3 * k], arrived[3 * k + 1], arrived[3 * k + 2] = shadow_transmittance(
                geometry, scratch, materials, ray, sight.before, covered
            )


@inline
def direct_light(
    look: ShadingTables, row: Any, arrived: Floats, at: int, point: ShadingPoint
) -> tuple[float, float, float, float, float, float]:
    """Return (Σ I N·L, Σ I h), each rgb, over the lights; arrived[at:] are their shares that reach the point."""
    dr, dg, db, hr, hg, hb = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(len(look.lights)):
        light = look.lights[k]
        _, _, _, _, cosine, shine, part = evaluate_light(light, row, point)
        if part == 0.0:
            continue
        r = arrived[at + 3 * k] * part * light.intensity[0]
        g = arrived[at + 3 * k + 1] * part * light.intensity[1]
        b = arrived[at + 3 * k + 2] * part * light.intensity[2]
        dr, dg, db = dr + r * cosine, dg + g * cosine, db + b * cosine
        hr, hg, hb = hr + r * shine, hg + g * shine, hb + b * shine
    return dr, dg, db, hr, hg, hb
