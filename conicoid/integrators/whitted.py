"""Whitted's ray tracing: local light, and on along the mirrored and the refracted ray.

Turner Whitted, An improved illumination model for shaded display, CACM 23 (1980), with Fresnel's
weights. What a wall of transparent solids does is decided on the ray itself: the media before and
after the crossing, all that coincides there taken together. Where they are the same material the wall is
invisible; so nested, abutting and overlapping dielectrics need no gap and no care, and the body
listed first has priority where two overlap.
"""

from __future__ import annotations

import math

import numpy as np

from ..geometry.tables import Geometry
from ..geometry.vectors import dot
from ..jit import helper, inline
from ..shading.background import background_color
from ..shading.fresnel import dielectric, schlick
from ..shading.local import direct_light, surface_color
from ..shading.look import Look
from ..shading.materials import Materials, material_row
from ..shading.media import OUTSIDE, absorbed, index_of, medium_of
from ..shading.reflect import reflect
from ..shading.refract import refract
from ..trace.kernels import first_crossing, media, nearest, normal_at, resolved
from ..trace.scratch import Scratch
from .stack import NO_SURFACE, Stack, push

Visible = tuple[float, int, int, int, int, int, int]


@helper
def first_visible(
    geometry: Geometry, scratch: Scratch, materials: Materials,
    ox: float, oy: float, oz: float, dx: float, dy: float, dz: float, start: int,
) -> Visible:  # fmt: skip
    """(t, body, surface, face, side, medium before, medium after) of the first wall that light notices.

    An opaque surface always is one, also where a transparent wall coincides with it.
    """
    t_min = 0.0
    while True:
        ray = (ox, oy, oz, dx, dy, dz, t_min, math.inf, start)
        t, body, surface, face, side = nearest(geometry, scratch, ray)
        if body < 0 or not materials.any_transparent:
            return t, body, surface, face, side, OUTSIDE, OUTSIDE
        if materials.opaque[body] == 0:
            here = (ox, oy, oz, dx, dy, dz, np.nextafter(t, -math.inf), np.nextafter(t, math.inf), start)
            hit = first_crossing(geometry, scratch, here, materials.opaque, False)
            if hit[1] >= 0:
                _, body, surface, face, side = resolved(geometry, hit)
        in_front, behind = media(geometry, scratch, ray, t, materials.medium)
        before, after = medium_of(materials, in_front), medium_of(materials, behind)
        if materials.medium[body] == 0 or before != after:
            return t, body, surface, face, side, before, after
        t_min = t


@inline
def opaque_reflectance(row: object, cosine: float) -> tuple[float, float, float]:
    """F of a surface that does not refract."""
    r, g, b = row.reflectivity[0], row.reflectivity[1], row.reflectivity[2]  # type: ignore[attr-defined]
    if row.fresnel == 1:  # type: ignore[attr-defined]
        return schlick(r, cosine), schlick(g, cosine), schlick(b, cosine)
    return r, g, b


@helper
def camera_medium(geometry: Geometry, scratch: Scratch, materials: Materials, x: float, y: float, z: float) -> int:
    """The medium that a camera stands in."""
    if not materials.any_transparent:
        return OUTSIDE
    ray = (x, y, z, 0.0, 0.0, 1.0, 0.0, math.inf, NO_SURFACE)
    return medium_of(materials, media(geometry, scratch, ray, 0.0, materials.medium)[1])


@helper
def whitted_radiance(
    geometry: Geometry, scratch: Scratch, stack: Stack, look: Look, depth: int, medium: int,
    ox: float, oy: float, oz: float, dx: float, dy: float, dz: float,
) -> tuple[float, float, float]:  # fmt: skip
    """Linear rgb of what comes back along a unit direction that starts in `medium`, after at most `depth` turns."""
    materials = look.materials
    red, green, blue = 0.0, 0.0, 0.0
    size = push(stack, 0, ox, oy, oz, dx, dy, dz, 1.0, 1.0, 1.0, NO_SURFACE, 0, medium)
    while size > 0:
        # Take a ray and find what it meets
        size -= 1
        floats = stack.floats[size]
        ox, oy, oz, dx, dy, dz = floats[0], floats[1], floats[2], floats[3], floats[4], floats[5]
        wr, wg, wb = floats[6], floats[7], floats[8]
        start, turns, medium = stack.numbers[size, 0], stack.numbers[size, 1], stack.numbers[size, 2]
        t, body, surface, face, side, before, after = first_visible(
            geometry, scratch, materials, ox, oy, oz, dx, dy, dz, start
        )
        if body < 0:
            wr, wg, wb = absorbed(materials, medium, math.inf, wr, wg, wb)
            r, g, b = background_color(look.background, dz)
            red, green, blue = red + wr * r, green + wg * g, blue + wb * b
            continue
        wr, wg, wb = absorbed(materials, before, t, wr, wg, wb)

        # The surface there, its normal turned to the eye
        row = materials.rows[material_row(geometry, materials, body, face)]
        x, y, z = ox + t * dx, oy + t * dy, oz + t * dz
        nx, ny, nz = normal_at(geometry, surface, side, x, y, z)
        cr, cg, cb = surface_color(geometry, materials, body, face, surface, x, y, z, nx, ny, nz)
        cosine = -dot(nx, ny, nz, dx, dy, dz)
        from_inside = cosine < 0.0
        if from_inside:
            nx, ny, nz, cosine = -nx, -ny, -nz, -cosine

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
        if not (refracts and from_inside):
            dr, dg, db, hr, hg, hb = direct_light(
                geometry, scratch, look, row, surface, before, x, y, z, nx, ny, nz, -dx, -dy, -dz
            )
            ka, kd = row.ambient, row.diffuse
            ar, ag, ab = look.ambient
            red += wr * (cr * (ka * ar + kd * dr) * (1.0 - fr) * (1.0 - pr) + row.specular[0] * hr)
            green += wg * (cg * (ka * ag + kd * dg) * (1.0 - fg) * (1.0 - pg) + row.specular[1] * hg)
            blue += wb * (cb * (ka * ab + kd * db) * (1.0 - fb) * (1.0 - pb) + row.specular[2] * hb)

        # On along the refracted and the mirrored ray
        if turns == depth:
            continue
        beyond_medium = after if refracts else before
        size = push(
            stack, size, x, y, z, tx, ty, tz,
            wr * (1.0 - fr) * pr, wg * (1.0 - fg) * pg, wb * (1.0 - fb) * pb, surface, turns + 1, beyond_medium,
        )  # fmt: skip
        mx, my, mz = reflect(dx, dy, dz, nx, ny, nz)
        size = push(stack, size, x, y, z, mx, my, mz, wr * fr, wg * fg, wb * fb, surface, turns + 1, before)
    return red, green, blue
