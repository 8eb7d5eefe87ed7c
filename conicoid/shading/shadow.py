"""How much of a light reaches a point.

Opaque bodies block it. Through transparent ones it goes straight on (bundling by refraction is not
followed): each wall lets through what Fresnel leaves of light that arrives at that angle from the
rarer side, times the body's transparency, and the way inside absorbs by Beer's law.
"""

from __future__ import annotations

import math

from ..compiler.jit import helper, inline
from ..engine.body.media import media
from ..engine.body.scratch import Scratch
from ..engine.numbers.vectors import dot
from ..engine.ray import Ray, with_limits
from ..engine.single.first import resolved_first_crossing
from ..engine.surface.normal import normal_at
from ..engine.tables import Geometry
from .fresnel import dielectric
from .materials import Materials, material_row
from .media import absorbed, index_of, medium_of


@inline
def light_along(
    geometry: Geometry, scratch: Scratch, materials: Materials, ray: Ray, inside: int, covered: bool
) -> tuple[float, float, float]:
    """Share (rgb) of the light at the end of a ray that reaches its origin, which lies in medium `inside`.

    `covered`: something opaque is in the way.
    """
    if covered:
        return 0.0, 0.0, 0.0
    if not materials.any_transparent:
        return 1.0, 1.0, 1.0
    return _through_glass(geometry, scratch, materials, ray, inside)


@helper
def _through_glass(
    geometry: Geometry, scratch: Scratch, materials: Materials, ray: Ray, inside: int
) -> tuple[float, float, float]:
    """`light_along` where nothing opaque is in the way."""
    x, y, z, lx, ly, lz, _, end, _ = ray
    r, g, b = 1.0, 1.0, 1.0
    length = math.sqrt(dot(lx, ly, lz, lx, ly, lz))
    done = 0.0
    while True:
        t, body, surface, face, side = resolved_first_crossing(geometry, scratch, ray)
        if body < 0:
            break
        before, after = media(geometry, scratch, ray, t, materials.medium)
        inside, beyond = medium_of(materials, before), medium_of(materials, after)
        if materials.medium[body] == 0 or inside != beyond:
            r, g, b = absorbed(materials, inside, (t - done) * length, r, g, b)
            nx, ny, nz = normal_at(geometry, surface, side, x + t * lx, y + t * ly, z + t * lz)
            cosine = abs(dot(lx, ly, lz, nx, ny, nz)) / length
            kept = 1.0 - wall_reflectance(cosine, index_of(materials, inside), index_of(materials, beyond))
            row = materials.rows[material_row(geometry, materials, body, face)]
            r, g, b = r * kept * row.transparency[0], g * kept * row.transparency[1], b * kept * row.transparency[2]
            inside, done = beyond, t
        ray = with_limits(ray, t, end)
    return absorbed(materials, inside, (end - done) * length, r, g, b)


@inline
def wall_reflectance(cosine: float, index1: float, index2: float) -> float:
    """Fresnel's reflectance of a wall between two media for light from the rarer one."""
    eta = min(index1, index2) / max(index1, index2)
    beyond = 1.0 - eta * eta * (1.0 - cosine * cosine)
    return dielectric(min(1.0, cosine), math.sqrt(max(0.0, beyond)), eta)
