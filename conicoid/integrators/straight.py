"""Light that comes straight through clear things: panes, and walls between equal indices.

Whitted's shadows (`shading.shadow`) let light straight through all that is transparent instead, less what Fresnel's
formulas mirror: there no path finds what is refracted.
"""

from __future__ import annotations

import math

from ..compiler.jit import helper
from ..engine.body.media import media
from ..engine.body.scratch import Scratch
from ..engine.numbers.vectors import dot
from ..engine.ray import Ray, with_limits
from ..engine.single.first import resolved_first_crossing
from ..engine.surface.normal import normal_at
from ..engine.tables import Geometry
from ..scattering.layers import pane_share
from ..scattering.medium import transmitted
from ..shading.materials import Materials, material_row
from ..shading.media import index_of, medium_of


@helper
def arrives(
    geometry: Geometry, scratch: Scratch, materials: Materials, ray: Ray, inside: int
) -> tuple[float, float, float]:
    """Share (rgb) of light from the end of a ray that comes straight to its origin, in medium `inside`.

    Nothing opaque is in the way. Panes and walls between equal indices let light through; what refracts sends it
    elsewhere, and paths find it there.
    """
    x, y, z, lx, ly, lz, _, end, _ = ray
    r, g, b, done = 1.0, 1.0, 1.0, 0.0
    length = math.sqrt(dot(lx, ly, lz, lx, ly, lz))
    while True:
        t, body, surface, face, side = resolved_first_crossing(geometry, scratch, ray)
        if body < 0:
            break
        before, after = media(geometry, scratch, ray, t, materials.medium)
        before, after = medium_of(materials, before), medium_of(materials, after)
        tr, tg, tb = transmitted(materials, before, (t - done) * length)
        r, g, b, inside, done = r * tr, g * tg, b * tb, after, t
        row = materials.rows[material_row(geometry, materials, body, face)]
        if materials.medium[body] == 0:
            nx, ny, nz = normal_at(geometry, surface, side, x + t * lx, y + t * ly, z + t * lz)
            tr, tg, tb = pane_share(row, abs(dot(lx, ly, lz, nx, ny, nz)) / length)
            r, g, b = r * tr, g * tg, b * tb
        elif before != after:
            if index_of(materials, before) != index_of(materials, after):
                return 0.0, 0.0, 0.0
            r, g, b = r * row.transparency[0], g * row.transparency[1], b * row.transparency[2]
        if r + g + b == 0.0:
            return 0.0, 0.0, 0.0
        ray = with_limits(ray, t, end)
    tr, tg, tb = transmitted(materials, inside, (end - done) * length)
    return r * tr, g * tg, b * tb
