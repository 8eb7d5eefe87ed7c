"""Walls between dielectrics, smooth or rough: how likely their lobes are, and the facets of rough ones."""

from __future__ import annotations

import math
from typing import Any

from ..compiler.jit import inline
from ..engine.numbers.vectors import dot
from ..shading.materials import Materials
from ..shading.refract import refract
from .albedo import INSIDE_OUT, OUTSIDE_IN, Albedos, albedo, mean_albedo
from .fresnel import wall
from .microfacets import between, facets, glint, hidden, mirrored, visible_facet
from .record import Lobes, Touched, is_rough, mean_of
from .warps import Direction

_PER_PI = 1.0 / math.pi


@inline
def is_tabled(row: Any, eta: float) -> bool:
    """Are a refracting wall's tables for what lies on its two sides?"""
    return bool(abs(eta * row.index - 1.0) < 0.1 or abs(eta - row.index) < 0.1 * row.index)


@inline
def _channels(row: Any, eta: float) -> tuple[int, int]:
    """The tables of the side of o, and of that beyond."""
    if abs(eta * row.index - 1.0) <= abs(eta - row.index):
        return OUTSIDE_IN, INSIDE_OUT
    return INSIDE_OUT, OUTSIDE_IN


@inline
def _beyond_share(tables: Albedos, k: int, here: int, there: int, eta: float) -> float:
    """The share of what facets scatter again that ends up beyond: so that light may take every path backwards."""
    near = (1.0 - mean_albedo(tables, k, here)) * eta * eta
    far = 1.0 - mean_albedo(tables, k, there)
    return far / (near + far) if near + far > 0.0 else 0.0


@inline
def wall_lobes(materials: Materials, tables: Albedos, at: Touched, cosine: float) -> Lobes:
    row = materials.rows[at.row]
    if is_rough(row) and at.eta != 1.0:
        if not is_tabled(row, at.eta):
            return Lobes(1.0, 0.0, 0.0, 0.0)
        here, there = _channels(row, at.eta)
        once = albedo(tables, at.row, here, cosine)
        beyond = _beyond_share(tables, at.row, here, there, at.eta)
        return Lobes(once, (1.0 - once) * (1.0 - beyond), 0.0, (1.0 - once) * beyond)
    share = wall(cosine, at.eta)
    clear = mean_of(row.transparency[0], row.transparency[1], row.transparency[2])
    soft = (1.0 - share) * (1.0 - clear) * mean_of(at.r, at.g, at.b) if at.outside else 0.0
    through = (1.0 - share) * clear
    total = share + through + soft
    return Lobes(share / total, soft / total, through / total, 0.0)


@inline
def _wall_facets(row: Any, o: Direction, i: Direction, eta: float) -> tuple[float, float, float, float]:
    """(rgb, density) of i by single facets, reflected or refracted, for radiance that comes from i.

    Walter and others, Microfacet models for refraction through rough surfaces, EGSR 2007, with the change of solid
    angle in refraction: h is along o + i / eta.
    """
    alpha = row.roughness
    if i[2] > 0.0:
        h = between(o, i)
        share = wall(min(1.0, dot(o[0], o[1], o[2], h[0], h[1], h[2])), eta)
        kept, density = glint(o, i, alpha)
        return share * kept, share * kept, share * kept, share * density
    h = between((eta * o[0], eta * o[1], eta * o[2]), i)
    if h[2] < 0.0:
        h = (-h[0], -h[1], -h[2])
    near, far = dot(o[0], o[1], o[2], h[0], h[1], h[2]), dot(i[0], i[1], i[2], h[0], h[1], h[2])
    if near <= 0.0 or far >= 0.0:
        return 0.0, 0.0, 0.0, 0.0
    passes = 1.0 - wall(min(1.0, near), eta)
    root = far + near * eta
    jacobian = -far / (root * root)
    own = hidden(o, alpha)
    once = facets(h, alpha) * passes * near * jacobian / o[2]
    kept = once / (1.0 + own + hidden((i[0], i[1], -i[2]), alpha)) * eta * eta
    return kept * row.transparency[0], kept * row.transparency[1], kept * row.transparency[2], once / (1.0 + own)


@inline
def rough_wall(
    materials: Materials, tables: Albedos, at: Touched, o: Direction, i: Direction
) -> tuple[float, float, float, float]:
    """(f cos, density) of a rough dielectric: single facets, and what meets several."""
    row = materials.rows[at.row]
    r, g, b, density = _wall_facets(row, o, i, at.eta)
    lobes = wall_lobes(materials, tables, at, o[2])
    density *= lobes.mirror
    if not is_tabled(row, at.eta):
        return r, g, b, density
    here, there = _channels(row, at.eta)
    lost = 1.0 - albedo(tables, at.row, here, o[2])
    if i[2] > 0.0:
        again = lost * (1.0 - albedo(tables, at.row, here, i[2])) / (1.0 - mean_albedo(tables, at.row, here))
        again *= (1.0 - _beyond_share(tables, at.row, here, there, at.eta)) * _PER_PI * i[2]
        return r + again, g + again, b + again, density + lobes.matte * _PER_PI * i[2]
    again = lost * (1.0 - albedo(tables, at.row, there, -i[2])) / (1.0 - mean_albedo(tables, at.row, there))
    again *= _beyond_share(tables, at.row, here, there, at.eta) * _PER_PI * -i[2] * at.eta * at.eta
    r, g, b = r + again * row.transparency[0], g + again * row.transparency[1], b + again * row.transparency[2]
    return r, g, b, density - lobes.beyond * _PER_PI * i[2]


@inline
def facet_of_wall(row: Any, at: Touched, o: Direction, choice: float, u: float, v: float) -> Direction:
    """A direction by a facet of a rough wall: mirrored as often as Fresnel says, else refracted."""
    h = visible_facet(o, row.roughness, u, v)
    along = min(1.0, dot(o[0], o[1], o[2], h[0], h[1], h[2]))
    if choice < wall(along, at.eta):
        i = mirrored(o, h)
        return i if i[2] > 0.0 else (0.0, 0.0, 0.0)
    x, y, z, beyond = refract(-o[0], -o[1], -o[2], h[0], h[1], h[2], at.eta)
    return (x, y, z) if beyond >= 0.0 and z < 0.0 else (0.0, 0.0, 0.0)
