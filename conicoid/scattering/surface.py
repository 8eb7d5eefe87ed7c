"""What each kind of surface does with light: its BSDF times the cosine, and directions drawn from it.

The kinds are those of `shading.materials`. A surface is a sum of lobes; `evaluate` adds up what has an extent, `draw`
takes one lobe by chance, a direction of it, and weighs it by all lobes that could have given that direction. A lobe of
one direction alone (a mirror, a smooth refraction) is drawn by its own weight.
"""

from __future__ import annotations

import math
from typing import Any

from ..compiler.jit import helper, inline
from ..engine.numbers.vectors import dot
from ..shading.materials import GLOSSY, LAYERED, MATTE, METAL, Materials
from ..shading.refract import refract
from .albedo import Albedos, albedo, mean_albedo
from .fresnel import wall
from .glossy import glossy, glossy_direction
from .layers import mirrored_share, top, under
from .matte import rough_matte, scattered_again
from .metals import metal_fresnel, rough_metal
from .microfacets import between, glint, mirrored, visible_facet
from .record import SHARP, SPREAD, STRAIGHT, Drawn, Lobes, Touched, is_rough, mean_of, nothing
from .walls import facet_of_wall, rough_wall, wall_lobes
from .warps import Direction, cosine_direction

_PER_PI = 1.0 / math.pi


@inline
def _lobes(materials: Materials, tables: Albedos, at: Touched, cosine: float) -> Lobes:
    """Shares of what lobes send on, about."""
    row = materials.rows[at.row]
    if at.refracts:
        return wall_lobes(materials, tables, at, cosine)
    if row.kind == METAL:
        if not is_rough(row):
            return Lobes(1.0, 0.0, 0.0, 0.0)
        once = albedo(tables, at.row, 0, cosine)
        return Lobes(once, 1.0 - once, 0.0, 0.0)
    if row.kind == GLOSSY:
        sharp = mean_of(row.specular[0], row.specular[1], row.specular[2])
        soft = mean_of(at.r, at.g, at.b) * (1.0 - sharp)
        return Lobes(sharp / (sharp + soft), soft / (sharp + soft), 0.0, 0.0)
    if row.kind == LAYERED:
        r, g, b = mirrored_share(materials, tables, at.row, cosine)
        top = mean_of(r, g, b)
        clear = mean_of(row.transparency[0], row.transparency[1], row.transparency[2])
        through, soft = (1.0 - top) * clear, (1.0 - top) * (1.0 - clear) * mean_of(at.r, at.g, at.b)
        total = top + through + soft
        if total == 0.0:
            return Lobes(0.0, 0.0, 0.0, 0.0)
        return Lobes(top / total, soft / total, through / total, 0.0)
    return Lobes(0.0, 1.0, 0.0, 0.0)


@inline
def _is_lambert(materials: Materials, at: Touched) -> bool:
    """Has a surface Lambert's law alone? Then nothing is called: a call costs more than that."""
    row = materials.rows[at.row]
    return bool(row.kind == MATTE and not at.refracts and row.roughness == 0.0)


@inline
def evaluate(
    materials: Materials, tables: Albedos, at: Touched, o: Direction, i: Direction
) -> tuple[float, float, float, float]:
    """(r, g, b, density): f |cos| of light from i that goes to o, and how densely `draw` takes i; 0 of sharp lobes."""
    if _is_lambert(materials, at):
        lambert = _PER_PI * i[2] if o[2] > 0.0 and i[2] > 0.0 else 0.0
        return at.r * lambert, at.g * lambert, at.b * lambert, lambert
    return _evaluate_others(materials, tables, at, o, i)


@helper
def _evaluate_others(
    materials: Materials, tables: Albedos, at: Touched, o: Direction, i: Direction
) -> tuple[float, float, float, float]:
    """`evaluate`, of all but Lambert's law."""
    row = materials.rows[at.row]
    if o[2] <= 0.0 or i[2] == 0.0:
        return 0.0, 0.0, 0.0, 0.0
    if at.refracts and is_rough(row) and at.eta != 1.0:
        return rough_wall(materials, tables, at, o, i)
    if i[2] <= 0.0:
        return 0.0, 0.0, 0.0, 0.0
    lambert = _PER_PI * i[2]
    if row.kind == MATTE and not at.refracts:
        once, again, mean = rough_matte(o, i, row.roughness)
        r = (at.r * once + scattered_again(at.r, mean) * again) * i[2]
        g = (at.g * once + scattered_again(at.g, mean) * again) * i[2]
        b = (at.b * once + scattered_again(at.b, mean) * again) * i[2]
        return r, g, b, lambert
    lobes = _lobes(materials, tables, at, o[2])
    if at.refracts:
        if not at.outside:
            return 0.0, 0.0, 0.0, 0.0
        both = (1.0 - wall(o[2], at.eta)) * (1.0 - wall(i[2], at.eta)) * lambert
        return (
            both * at.r * (1.0 - row.transparency[0]), both * at.g * (1.0 - row.transparency[1]),
            both * at.b * (1.0 - row.transparency[2]), lobes.matte * lambert,
        )  # fmt: skip
    if row.kind == GLOSSY:
        shine, density = glossy(row, o, i)
        sr, sg, sb = row.specular[0], row.specular[1], row.specular[2]
        return (
            at.r * (1.0 - sr) * lambert + sr * shine, at.g * (1.0 - sg) * lambert + sg * shine,
            at.b * (1.0 - sb) * lambert + sb * shine, lobes.mirror * density + lobes.matte * lambert,
        )  # fmt: skip
    kept, density = 0.0, 0.0
    if is_rough(row):
        kept, density = glint(o, i, row.roughness)
        density *= lobes.mirror
    density += lobes.matte * lambert
    if row.kind == METAL:
        r, g, b = rough_metal(materials, tables, at.row, o, i, kept)
        return r, g, b, density
    ar, ag, ab = mirrored_share(materials, tables, at.row, o[2])
    br, bg, bb = mirrored_share(materials, tables, at.row, i[2])
    r = under(row, 0, at.r, ar, br, mean_albedo(tables, at.row, 0)) * i[2]
    g = under(row, 1, at.g, ag, bg, mean_albedo(tables, at.row, 1)) * i[2]
    b = under(row, 2, at.b, ab, bb, mean_albedo(tables, at.row, 2)) * i[2]
    if kept > 0.0:
        h = between(o, i)
        tr, tg, tb = top(row, dot(o[0], o[1], o[2], h[0], h[1], h[2]))
        r, g, b = r + tr * kept, g + tg * kept, b + tb * kept
    return r, g, b, density


@inline
def draw(materials: Materials, tables: Albedos, at: Touched, o: Direction, choice: float, u: float, v: float) -> Drawn:
    """A direction for light that goes to o; all three numbers are in [0, 1)."""
    if o[2] <= 0.0:
        return nothing()
    if _is_lambert(materials, at):
        i = cosine_direction(u, v)
        return Drawn(SPREAD, i, at.r, at.g, at.b, _PER_PI * i[2]) if i[2] > 0.0 else nothing()
    return _draw_others(materials, tables, at, o, choice, u, v)


@helper
def _draw_others(
    materials: Materials, tables: Albedos, at: Touched, o: Direction, choice: float, u: float, v: float
) -> Drawn:
    """`draw`, of all but Lambert's law."""
    row = materials.rows[at.row]
    lobes = _lobes(materials, tables, at, o[2])
    if choice < lobes.mirror:
        if at.refracts and is_rough(row) and at.eta != 1.0:
            return _weighed(materials, tables, at, o, facet_of_wall(row, at, o, choice / lobes.mirror, u, v))
        if row.kind == GLOSSY and not at.refracts:
            return _weighed(materials, tables, at, o, glossy_direction(row, o, u, v))
        if is_rough(row) and not at.refracts:
            return _weighed(materials, tables, at, o, mirrored(o, visible_facet(o, row.roughness, u, v)))
        r, g, b = 1.0, 1.0, 1.0
        if at.refracts:
            r = wall(o[2], at.eta)
            g, b = r, r
        elif row.kind == METAL:
            r, g, b = metal_fresnel(row, o[2])
        else:
            r, g, b = top(row, o[2])
        return Drawn(SHARP, (-o[0], -o[1], o[2]), r / lobes.mirror, g / lobes.mirror, b / lobes.mirror, 0.0)
    choice -= lobes.mirror
    if choice < lobes.matte:
        return _weighed(materials, tables, at, o, cosine_direction(u, v))
    choice -= lobes.matte
    if choice < lobes.through:
        return _through(row, at, o, lobes.through)
    if choice - lobes.through < lobes.beyond:
        x, y, z = cosine_direction(u, v)
        return _weighed(materials, tables, at, o, (x, y, -z))
    return nothing()


@inline
def _through(row: Any, at: Touched, o: Direction, share: float) -> Drawn:
    """On through a pane or a smooth wall."""
    tr, tg, tb = row.transparency[0], row.transparency[1], row.transparency[2]
    if not at.refracts:
        r, g, b = top(row, o[2])
        return Drawn(
            STRAIGHT, (-o[0], -o[1], -o[2]),
            (1.0 - r) * tr / share, (1.0 - g) * tg / share, (1.0 - b) * tb / share, 0.0,
        )  # fmt: skip
    if at.eta == 1.0:
        return Drawn(STRAIGHT, (-o[0], -o[1], -o[2]), tr / share, tg / share, tb / share, 0.0)
    x, y, z, beyond = refract(-o[0], -o[1], -o[2], 0.0, 0.0, 1.0, at.eta)
    if beyond < 0.0:
        return nothing()
    kept = (1.0 - wall(o[2], at.eta)) * at.eta * at.eta / share
    return Drawn(SHARP, (x, y, z), kept * tr, kept * tg, kept * tb, 0.0)


@inline
def _weighed(materials: Materials, tables: Albedos, at: Touched, o: Direction, i: Direction) -> Drawn:
    """A direction with the weight that all lobes give it."""
    r, g, b, density = _evaluate_others(materials, tables, at, o, i)
    if not density > 0.0:
        return nothing()
    return Drawn(SPREAD, i, r / density, g / density, b / density, density)


@inline
def has_extent(materials: Materials, at: Touched) -> bool:
    """Has a surface lobes that light from a lamp may fall into?"""
    row = materials.rows[at.row]
    if at.refracts:
        if is_rough(row) and at.eta != 1.0:
            return True
        return at.outside and row.transparency[0] + row.transparency[1] + row.transparency[2] < 3.0
    if row.kind == METAL:
        return is_rough(row)
    return row.kind != LAYERED or is_rough(row) or at.r + at.g + at.b > 0.0
