"""The light that a surface sends to the eye by itself: ambient, diffuse and highlights."""

from __future__ import annotations

import math
from typing import Any

from ..compiler.jit import helper, inline
from ..engine.body.scratch import Scratch
from ..engine.body.uv import uv_at
from ..engine.numbers.vectors import dot
from ..engine.tables import Floats, Geometry
from .lights import share, towards
from .look import Look
from .materials import CHECKER_UV, PLAIN, Materials, color_in_space, color_on_uv, material_row, pick
from .phong import half_vector, phong
from .shadow import light_through

_FAINT = 1e-5  # a highlight under this is not worth a shadow ray


@inline
def surface_color(
    geometry: Geometry, materials: Materials, body: int, face: int, surface: int,
    x: float, y: float, z: float, nx: float, ny: float, nz: float,
) -> tuple[float, float, float]:  # fmt: skip
    """The diffuse colour at a point; n is the body's outward normal."""
    row = materials.rows[material_row(geometry, materials, body, face)]
    if row.pattern == PLAIN:
        return pick(row, True)
    if row.pattern == CHECKER_UV:
        u, v = uv_at(geometry, body, face, surface, x, y, z)
        return color_on_uv(row, u, v)
    return color_in_space(row, x, y, z, nx, ny, nz)


@inline
def highlight(
    row: Any, lx: float, ly: float, lz: float, ex: float, ey: float, ez: float, nx: float, ny: float, nz: float
) -> float:
    """The material's highlight: half-vector or Phong."""
    if row.half_vector == 1:
        return half_vector(lx, ly, lz, ex, ey, ez, nx, ny, nz, row.shininess)
    return phong(lx, ly, lz, ex, ey, ez, nx, ny, nz, row.shininess)


@inline
def light_at(
    light: Any, row: Any, x: float, y: float, z: float, nx: float, ny: float, nz: float, ex: float, ey: float, ez: float
) -> tuple[float, float, float, float, float, float, float]:
    """(l, end, N·L, highlight, share): the ray to a light and what its light would do at x; share 0 if nothing."""
    return _light_at(light, row, x, y, z, nx, ny, nz, ex, ey, ez, True)


@inline
def ray_to_light(
    light: Any, row: Any, x: float, y: float, z: float, nx: float, ny: float, nz: float, ex: float, ey: float, ez: float
) -> tuple[float, float, float, float, float]:
    """(l, end, share) of `light_at`; the highlight, a costly power, is worked out only where it decides the share."""
    lx, ly, lz, end, _, _, part = _light_at(light, row, x, y, z, nx, ny, nz, ex, ey, ez, row.diffuse == 0.0)
    return lx, ly, lz, end, part


@inline
def _light_at(
    light: Any, row: Any, x: float, y: float, z: float, nx: float, ny: float, nz: float,
    ex: float, ey: float, ez: float, shines: bool,
) -> tuple[float, float, float, float, float, float, float]:  # fmt: skip
    lx, ly, lz, end = towards(light, x, y, z)
    distance = math.sqrt(dot(lx, ly, lz, lx, ly, lz))
    if distance == 0.0:
        return lx, ly, lz, end, 0.0, 0.0, 0.0
    ux, uy, uz = lx / distance, ly / distance, lz / distance
    cosine = dot(nx, ny, nz, ux, uy, uz)
    if cosine <= 0.0:
        return lx, ly, lz, end, cosine, 0.0, 0.0
    shiny = shines and row.specular[0] + row.specular[1] + row.specular[2] > 0.0
    shine = highlight(row, ux, uy, uz, ex, ey, ez, nx, ny, nz) if shiny else 0.0
    part = share(light, ux, uy, uz, distance)
    if row.diffuse == 0.0 and shine < _FAINT:
        part = 0.0
    return lx, ly, lz, end, cosine, shine, part


@helper
def ask_lights(
    geometry: Geometry, scratch: Scratch, look: Look, row: Any, start: int, inside: int, arrived: Floats,
    x: float, y: float, z: float, nx: float, ny: float, nz: float, ex: float, ey: float, ez: float,
) -> None:  # fmt: skip
    """How much of each light (rgb, into `arrived`) reaches x on surface `start` in medium `inside`."""
    for k in range(len(look.lights)):
        lx, ly, lz, end, part = ray_to_light(look.lights[k], row, x, y, z, nx, ny, nz, ex, ey, ez)
        if part != 0.0:
            arrived[3 * k], arrived[3 * k + 1], arrived[3 * k + 2] = light_through(
                geometry, scratch, look.materials, x, y, z, lx, ly, lz, end, start, inside
            )


@inline
def direct_light(
    look: Look, row: Any, arrived: Floats, at: int,
    x: float, y: float, z: float, nx: float, ny: float, nz: float, ex: float, ey: float, ez: float,
) -> tuple[float, float, float, float, float, float]:  # fmt: skip
    """(Σ I N·L, Σ I h), each rgb, over the lights, of which arrived[at:] reaches x; n on the eye's side."""
    dr, dg, db, hr, hg, hb = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(len(look.lights)):
        light = look.lights[k]
        _, _, _, _, cosine, shine, part = light_at(light, row, x, y, z, nx, ny, nz, ex, ey, ez)
        if part == 0.0:
            continue
        r = arrived[at + 3 * k] * part * light.intensity[0]
        g = arrived[at + 3 * k + 1] * part * light.intensity[1]
        b = arrived[at + 3 * k + 2] * part * light.intensity[2]
        dr, dg, db = dr + r * cosine, dg + g * cosine, db + b * cosine
        hr, hg, hb = hr + r * shine, hg + g * shine, hb + b * shine
    return dr, dg, db, hr, hg, hb
