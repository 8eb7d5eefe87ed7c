"""Whitted's ray tracing: local light, and on along the mirrored and the refracted ray.

Turner Whitted, An improved illumination model for shaded display, CACM 23 (1980), with Fresnel's
weights. What a wall of transparent solids does is decided on the ray itself: the media before and
after the crossing, all that coincides there taken together. Where they are the same material the wall is
invisible; so nested, abutting and overlapping dielectrics need no gap and no care, and the body
listed first has priority where two overlap.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from ..compiler.jit import helper, inline
from ..engine.body.hit import Hit, resolved
from ..engine.body.media import media
from ..engine.body.scratch import Scratch
from ..engine.numbers.bits import next_above, next_below
from ..engine.numbers.vectors import dot
from ..engine.ray import Ray
from ..engine.single.first import first_crossing, nearest
from ..engine.surface.normal import normal_at
from ..engine.tables import Floats, Geometry, halted, whole
from ..shading.background import background_color
from ..shading.fresnel import dielectric, schlick
from ..shading.local import ask_lights, direct_light, surface_color
from ..shading.look import Look
from ..shading.materials import Materials, material_row
from ..shading.media import OUTSIDE, absorbed, index_of, medium_of, unseen
from ..shading.reflect import reflect
from ..shading.refract import refract
from .stack import NO_SURFACE, Stack, push


class Sight(NamedTuple):
    """The first wall that light notices along a ray; body -1 if there is none."""

    t: float
    body: Any  # int64, as those that follow
    surface: Any
    face: Any
    side: Any
    before: Any  # the medium in front of it
    after: Any  # and behind it
    x: float
    y: float
    z: float
    nx: float  # outward
    ny: float
    nz: float


@inline
def sight_of(
    geometry: Geometry, scratch: Scratch, materials: Materials,
    ox: float, oy: float, oz: float, dx: float, dy: float, dz: float, start: int, hit: Hit,
) -> Sight:  # fmt: skip
    """The first wall that light notices along a ray whose first crossing is `hit`; body -1 if there is none."""
    t, body, surface, face, side = resolved(geometry, hit)
    outside: Any = whole(OUTSIDE)
    before, after = outside, outside
    if body >= 0 and materials.any_transparent:
        t, body, surface, face, side, before, after = first_noticed(
            geometry, scratch, materials, ox, oy, oz, dx, dy, dz, start, t, body, surface, face, side
        )
    if body < 0:
        return Sight(t, body, surface, face, side, before, after, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    x, y, z = ox + t * dx, oy + t * dy, oz + t * dz
    nx, ny, nz = normal_at(geometry, surface, side, x, y, z)
    return Sight(t, body, surface, face, side, before, after, x, y, z, nx, ny, nz)


@helper
def first_noticed(
    geometry: Geometry, scratch: Scratch, materials: Materials,
    ox: float, oy: float, oz: float, dx: float, dy: float, dz: float, start: int,
    t: float, body: int, surface: int, face: int, side: int,
) -> tuple[float, int, int, int, int, int, int]:  # fmt: skip
    """(t, body, surface, face, side, medium before, after) of the first wall that light notices, from a crossing on.

    An opaque surface always is one, also where a transparent wall coincides with it.
    """
    outside: Any = whole(OUTSIDE)
    before, after = outside, outside
    while body >= 0:
        ray = Ray(ox, oy, oz, dx, dy, dz, 0.0, math.inf, start)
        if materials.opaque[body] == 0:
            here = Ray(ox, oy, oz, dx, dy, dz, next_below(t), next_above(t), start)
            other = first_crossing(geometry, scratch, here, materials.opaque, False)
            if other.body >= 0:
                _, body, surface, face, side = resolved(geometry, other)
        in_front, behind = media(geometry, scratch, ray, t, materials.medium)
        before, after = medium_of(materials, in_front), medium_of(materials, behind)
        if materials.medium[body] == 0 or not unseen(materials, body, before, after):
            break
        t, body, surface, face, side = nearest(geometry, scratch, Ray(ox, oy, oz, dx, dy, dz, t, math.inf, start))
    return t, body, surface, face, side, before, after


@inline
def facing(sight: Sight, dx: float, dy: float, dz: float) -> tuple[float, float, float, float, bool]:
    """(normal turned to the eye, its cosine with the way back, seen from inside?)"""
    nx, ny, nz = sight.nx, sight.ny, sight.nz
    cosine = -dot(nx, ny, nz, dx, dy, dz)
    if cosine < 0.0:
        return -nx, -ny, -nz, -cosine, True
    return nx, ny, nz, cosine, False


@inline
def shows_light(materials: Materials, sight: Sight, from_inside: bool) -> bool:
    """Does a surface show what lights fall on it? The inner side of glass does not."""
    return not (from_inside and materials.medium[sight.body] == 1)


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
    geometry: Geometry, look: Look, stack: Stack, size: int, depth: int, turns: int, sight: Sight,
    arrived: Floats, at: int, dx: float, dy: float, dz: float, wr: float, wg: float, wb: float,
) -> tuple[float, float, float, int]:  # fmt: skip
    """(rgb that a surface sends back by itself, new size of the stack): the rays it sends on are pushed.

    arrived[at:]: how much of each light reaches it.
    """
    materials = look.materials
    t, body, surface, face, _, before, after, x, y, z, _, _, _ = sight
    wr, wg, wb = absorbed(materials, before, t, wr, wg, wb)
    row = materials.rows[material_row(geometry, materials, body, face)]
    cr, cg, cb = surface_color(geometry, materials, body, face, surface, x, y, z, sight.nx, sight.ny, sight.nz)
    nx, ny, nz, cosine, from_inside = facing(sight, dx, dy, dz)

    # How light parts there: F is reflected, of the rest a share goes through
    refracts = materials.medium[body] == 1
    fr, fg, fb = opaque_reflectance(row, cosine)
    tx, ty, tz = dx, dy, dz
    if refracts:
        eta = index_of(materials, before) / index_of(materials, after)
        tx, ty, tz, beyond = refract(dx, dy, dz, nx, ny, nz, eta)
        fr = dielectric(cosine, beyond, eta)
        fg, fb = fr, fr
    pr, pg, pb = row.transparency[0], row.transparency[1], row.transparency[2]

    # Its own light
    red, green, blue = 0.0, 0.0, 0.0
    if shows_light(materials, sight, from_inside):
        dr, dg, db, hr, hg, hb = direct_light(look, row, arrived, at, x, y, z, nx, ny, nz, -dx, -dy, -dz)
        ka, kd = row.ambient, row.diffuse
        ar, ag, ab = look.ambient
        red = wr * (cr * (ka * ar + kd * dr) * (1.0 - fr) * (1.0 - pr) + row.specular[0] * hr)
        green = wg * (cg * (ka * ag + kd * dg) * (1.0 - fg) * (1.0 - pg) + row.specular[1] * hg)
        blue = wb * (cb * (ka * ab + kd * db) * (1.0 - fb) * (1.0 - pb) + row.specular[2] * hb)

    # On along the refracted and the mirrored ray
    if turns < depth:
        size = push(
            stack, size, x, y, z, tx, ty, tz, wr * (1.0 - fr) * pr, wg * (1.0 - fg) * pg, wb * (1.0 - fb) * pb,
            surface, turns + 1, after if refracts else before,
        )  # fmt: skip
        mx, my, mz = reflect(dx, dy, dz, nx, ny, nz)
        size = push(stack, size, x, y, z, mx, my, mz, wr * fr, wg * fg, wb * fb, surface, turns + 1, before)
    return red, green, blue, size


@inline
def sky(look: Look, medium: int, dz: float, wr: float, wg: float, wb: float) -> tuple[float, float, float]:
    """Rgb of the background along a unit direction, seen from a medium."""
    wr, wg, wb = absorbed(look.materials, medium, math.inf, wr, wg, wb)
    r, g, b = background_color(look.background, dz)
    return wr * r, wg * g, wb * b


@helper
def follow(
    geometry: Geometry, scratch: Scratch, stack: Stack, size: int, look: Look, depth: int, arrived: Floats
) -> tuple[float, float, float]:
    """Linear rgb of what comes back along the rays on the stack, after at most `depth` turns."""
    materials = look.materials
    red, green, blue = 0.0, 0.0, 0.0
    while size > 0 and not halted(geometry):
        size -= 1
        floats = stack.floats[size]
        ox, oy, oz, dx, dy, dz = floats[0], floats[1], floats[2], floats[3], floats[4], floats[5]
        wr, wg, wb = floats[6], floats[7], floats[8]
        start, turns, medium = stack.numbers[size, 0], stack.numbers[size, 1], stack.numbers[size, 2]
        ray = Ray(ox, oy, oz, dx, dy, dz, 0.0, math.inf, start)
        hit = first_crossing(geometry, scratch, ray, scratch.nothing, False)
        sight = sight_of(geometry, scratch, materials, ox, oy, oz, dx, dy, dz, start, hit)
        if sight.body < 0:
            r, g, b = sky(look, medium, dz, wr, wg, wb)
        else:
            nx, ny, nz, _, from_inside = facing(sight, dx, dy, dz)
            if shows_light(materials, sight, from_inside):
                row = materials.rows[material_row(geometry, materials, sight.body, sight.face)]
                ask_lights(
                    geometry, scratch, look, row, sight.surface, sight.before, arrived,
                    sight.x, sight.y, sight.z, nx, ny, nz, -dx, -dy, -dz,
                )  # fmt: skip
            r, g, b, size = shade(geometry, look, stack, size, depth, turns, sight, arrived, 0, dx, dy, dz, wr, wg, wb)
        red, green, blue = red + r, green + g, blue + b
    return red, green, blue
