"""Whitted's ray tracing: local light, and on along the mirrored and the refracted ray.

Turner Whitted, An improved illumination model for shaded display, CACM 23 (1980), with Fresnel's
weights. What a wall of transparent solids does is decided on the ray itself: the media before and
after the crossing, all that coincides there taken together. Where they are the same material the wall is
invisible; so nested, abutting and overlapping dielectrics need no gap and no care, and the body
listed first has priority where two overlap.
"""

from __future__ import annotations

import math
from typing import Any

from ..compiler.jit import helper, inline
from ..emitters.lamplight import Lamplight
from ..engine.body.hit import Crossed, Hit, resolved
from ..engine.body.media import media
from ..engine.body.scratch import Scratch
from ..engine.numbers.bits import next_above, next_below
from ..engine.numbers.vectors import dot
from ..engine.ray import Ray, with_limits
from ..engine.single.first import first_crossing, resolved_first_crossing
from ..engine.surface.normal import normal_at
from ..engine.tables import Floats, Geometry, halted, whole
from ..shading.background import background_color
from ..shading.fresnel import dielectric, schlick
from ..shading.local import ask_lights, direct_light, surface_color
from ..shading.materials import Materials, material_row
from ..shading.media import OUTSIDE, absorbed, index_of, medium_of, unseen
from ..shading.reflect import reflect
from ..shading.refract import refract
from ..shading.relief import bent_point, has_relief, on_side
from ..shading.sight import Sight, facing, shows_light
from .lamps import ask_lamps, lamp_count, lamp_light
from .stack import NO_SURFACE, Pending, Stack, pending, push


@inline
def sight_of(geometry: Geometry, scratch: Scratch, materials: Materials, ray: Ray, hit: Hit) -> Sight:
    """The first wall that light notices along a ray whose first crossing is `hit`; body -1 if there is none."""
    crossed = resolved(geometry, hit)
    outside: Any = whole(OUTSIDE)
    before, after = outside, outside
    if crossed.body >= 0 and materials.any_transparent:
        crossed, before, after = first_noticed(geometry, scratch, materials, ray, crossed)
    t, body, surface, face, side = crossed
    if body < 0:
        return Sight(t, body, surface, face, side, before, after, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    x, y, z = ray.ox + t * ray.dx, ray.oy + t * ray.dy, ray.oz + t * ray.dz
    nx, ny, nz = normal_at(geometry, surface, side, x, y, z)
    return Sight(t, body, surface, face, side, before, after, x, y, z, nx, ny, nz)


@helper
def first_noticed(
    geometry: Geometry, scratch: Scratch, materials: Materials, ray: Ray, crossed: Crossed
) -> tuple[Crossed, int, int]:
    """(the first wall that light notices from a crossing of a ray on, the media before and after).

    An opaque surface always is one, also where a transparent wall coincides with it.
    """
    outside: Any = whole(OUTSIDE)
    before, after = outside, outside
    while crossed.body >= 0:
        t = crossed.t
        if materials.opaque[crossed.body] == 0:
            here = with_limits(ray, next_below(t), next_above(t))
            other = first_crossing(geometry, scratch, here, materials.opaque, False)
            if other.body >= 0:
                _, body, surface, face, side = resolved(geometry, other)
                crossed = Crossed(t, body, surface, face, side)
        in_front, behind = media(geometry, scratch, with_limits(ray, 0.0, math.inf), t, materials.medium)
        before, after = medium_of(materials, in_front), medium_of(materials, behind)
        if materials.medium[crossed.body] == 0 or not unseen(materials, crossed.body, before, after):
            break
        crossed = resolved_first_crossing(geometry, scratch, with_limits(ray, t, math.inf))
    return crossed, before, after


@inline
def opaque_reflectance(row: object, cosine: float) -> tuple[float, float, float]:
    """F of a surface that does not refract."""
    r, g, b = row.reflectivity[0], row.reflectivity[1], row.reflectivity[2]  # type: ignore[attr-defined]
    if row.fresnel == 1:  # type: ignore[attr-defined]
        return schlick(r, cosine), schlick(g, cosine), schlick(b, cosine)
    return r, g, b


@helper
def medium_at(geometry: Geometry, scratch: Scratch, materials: Materials, x: float, y: float, z: float) -> int:
    """The medium at a point, of a scene that has transparent bodies."""
    ray = Ray(x, y, z, 0.0, 0.0, 1.0, 0.0, math.inf, whole(NO_SURFACE))
    return medium_of(materials, media(geometry, scratch, ray, 0.0, materials.medium)[1])


@inline
def shade(
    geometry: Geometry, lit: Lamplight, stack: Stack, size: int, ray: Pending, sight: Sight, arrived: Floats, at: int,
    random: tuple[int, int, int],
) -> tuple[float, float, float, int]:  # fmt: skip
    """(rgb that what a ray sees sends back by itself, new size of the stack): the rays it sends on are pushed.

    arrived[at:]: how much of each light and lamp reaches it; random: seed, pixel and sample.
    """
    look, materials = lit.look, lit.look.materials
    _, _, _, dx, dy, dz, wr, wg, wb, _, turns, _ = ray
    wr, wg, wb = absorbed(materials, sight.before, sight.t, wr, wg, wb)
    number = material_row(geometry, materials, sight.body, sight.face)
    row = materials.rows[number]
    cr, cg, cb = surface_color(geometry, materials, sight)
    point, cosine, from_inside = facing(sight, dx, dy, dz)
    gx, gy, gz, bent = point.nx, point.ny, point.nz, has_relief(row)
    if bent:
        point = bent_point(geometry, materials, sight, number, point, from_inside)
        cosine = dot(point.nx, point.ny, point.nz, point.ex, point.ey, point.ez)
    x, y, z, nx, ny, nz, _, _, _ = point

    # How light parts there: F is reflected, of the rest a share goes through
    refracts = materials.medium[sight.body] == 1
    fr, fg, fb = opaque_reflectance(row, cosine)
    tx, ty, tz = dx, dy, dz
    if refracts:
        eta = index_of(materials, sight.before) / index_of(materials, sight.after)
        tx, ty, tz, beyond = refract(dx, dy, dz, nx, ny, nz, eta)
        fr = dielectric(cosine, beyond, eta)
        fg, fb = fr, fr
        if bent:
            tx, ty, tz = on_side(tx, ty, tz, gx, gy, gz, False)
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
        size = push(stack, size, Pending(
            x, y, z, tx, ty, tz, wr * (1.0 - fr) * pr, wg * (1.0 - fg) * pg, wb * (1.0 - fb) * pb,
            sight.surface, turns - 1, sight.after if refracts else sight.before,
        ))  # fmt: skip
        mx, my, mz = reflect(dx, dy, dz, nx, ny, nz)
        if bent:
            mx, my, mz = on_side(mx, my, mz, gx, gy, gz, True)
        size = push(stack, size, Pending(
            x, y, z, mx, my, mz, wr * fr, wg * fg, wb * fb, sight.surface, turns - 1, sight.before,
        ))  # fmt: skip
    return red, green, blue, size


@inline
def sky(look: Any, medium: int, dz: float, wr: float, wg: float, wb: float) -> tuple[float, float, float]:
    """Rgb of the background along a unit direction, seen from a medium."""
    wr, wg, wb = absorbed(look.materials, medium, math.inf, wr, wg, wb)
    r, g, b = background_color(look.background, dz)
    return wr * r, wg * g, wb * b


@helper
def follow(
    geometry: Geometry, scratch: Scratch, stack: Stack, size: int, lit: Lamplight, arrived: Floats,
    random: tuple[int, int, int],
) -> tuple[float, float, float]:  # fmt: skip
    """Linear rgb of what comes back along the rays on the stack."""
    look, materials = lit.look, lit.look.materials
    red, green, blue = 0.0, 0.0, 0.0
    while size > 0 and not halted(geometry):
        size -= 1
        left = pending(stack, size)
        dx, dy, dz = left.dx, left.dy, left.dz
        ray = Ray(left.x, left.y, left.z, dx, dy, dz, 0.0, math.inf, left.start)
        hit = first_crossing(geometry, scratch, ray, scratch.nothing, False)
        sight = sight_of(geometry, scratch, materials, ray, hit)
        if sight.body < 0:
            r, g, b = sky(look, left.medium, dz, left.r, left.g, left.b)
        else:
            ask_lights(geometry, scratch, look, arrived, sight, dx, dy, dz)
            if lamp_count(lit.lamps) > 0:
                ask_lamps(geometry, scratch, lit, random, arrived, sight, dx, dy, dz)
            r, g, b, size = shade(geometry, lit, stack, size, left, sight, arrived, 0, random)
        red, green, blue = red + r, green + g, blue + b
    return red, green, blue
