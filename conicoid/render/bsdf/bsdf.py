"""What each kind of surface does with light: its BSDF times the cosine, and directions drawn from it.

The kinds are those of `shading.materials`. A surface is a sum of lobes; `evaluate` adds up what has an extent, `draw`
takes one lobe by chance, a direction of it, and weighs it by all lobes that could have given that direction. A lobe of
one direction alone (a mirror, a smooth refraction) is drawn by its own weight.
"""

from __future__ import annotations

import math
from typing import Any

from ..._jit.decorators import helper, inline
from ...kernels.numbers.vectors import dot
from ..sampling import Direction, cosine_direction
from .albedo_tables import AlbedoTables, albedo, mean_albedo
from .bsdf_sample import (
    LOST,
    SHARP,
    SPREAD,
    STRAIGHT,
    BsdfSample,
    LobeProbabilities,
    LobeSurface,
    is_rough,
    lost_sample,
    mean_rgb,
)
from .conductor import metal_fresnel, rough_metal
from .dielectric import rough_wall, sample_wall_facet, wall_lobes
from .diffuse import interreflection_color, oren_nayar
from .fresnel import dielectric_reflectance, refract
from .layered import base_under_top, mirrored_share, top_reflectance
from .material_table import GLOSSY, LAYERED, MATTE, METAL, MaterialTable
from .microfacet import evaluate_ggx, half_direction, mirror_direction, sample_visible_normal
from .phong import evaluate_phong, sample_phong

_PER_PI = 1.0 / math.pi


@inline
def _lobes(materials: MaterialTable, tables: AlbedoTables, at: LobeSurface, cosine: float) -> LobeProbabilities:
    """Shares of what lobes send on, about."""
    row = materials.rows[at.row]
    if at.refracts:
        return wall_lobes(materials, tables, at, cosine)
    if row.kind == METAL:
        if not is_rough(row):
            return LobeProbabilities(1.0, 0.0, 0.0, 0.0)
        once = albedo(tables, at.row, 0, cosine)
        return LobeProbabilities(once, 1.0 - once, 0.0, 0.0)
    if row.kind == GLOSSY:
        sharp = mean_rgb(row.specular[0], row.specular[1], row.specular[2])
        soft = mean_rgb(at.r, at.g, at.b) * (1.0 - sharp)
        return LobeProbabilities(sharp / (sharp + soft), soft / (sharp + soft), 0.0, 0.0)
    if row.kind == LAYERED:
        r, g, b = mirrored_share(materials, tables, at.row, cosine)
        top = mean_rgb(r, g, b)
        clear = mean_rgb(row.transparency[0], row.transparency[1], row.transparency[2])
        through, soft = (1.0 - top) * clear, (1.0 - top) * (1.0 - clear) * mean_rgb(at.r, at.g, at.b)
        total = top + through + soft
        if total == 0.0:
            return LobeProbabilities(0.0, 0.0, 0.0, 0.0)
        return LobeProbabilities(top / total, soft / total, through / total, 0.0)
    return LobeProbabilities(0.0, 1.0, 0.0, 0.0)


@inline
def _is_lambert(materials: MaterialTable, at: LobeSurface) -> bool:
    """Has a surface Lambert's law alone? Then nothing is called: a call costs more than that."""
    row = materials.rows[at.row]
    return bool(row.kind == MATTE and not at.refracts and row.roughness == 0.0)


@inline
def evaluate_lobes(
    materials: MaterialTable, tables: AlbedoTables, at: LobeSurface, o: Direction, i: Direction
) -> tuple[float, float, float, float]:
    """(r, g, b, density): f |cos| of light from i that goes to o, and how densely `draw` takes i; 0 of sharp lobes."""
    if _is_lambert(materials, at):
        lambert = _PER_PI * i[2] if o[2] > 0.0 and i[2] > 0.0 else 0.0
        return at.r * lambert, at.g * lambert, at.b * lambert, lambert
    return _evaluate_general(materials, tables, at, o, i)


@helper
def _evaluate_general(
    materials: MaterialTable, tables: AlbedoTables, at: LobeSurface, o: Direction, i: Direction
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
        once, again, mean = oren_nayar(o, i, row.roughness)
        r = (at.r * once + interreflection_color(at.r, mean) * again) * i[2]
        g = (at.g * once + interreflection_color(at.g, mean) * again) * i[2]
        b = (at.b * once + interreflection_color(at.b, mean) * again) * i[2]
        return r, g, b, lambert
    lobes = _lobes(materials, tables, at, o[2])
    if at.refracts:
        if not at.outside:
            return 0.0, 0.0, 0.0, 0.0
        both = (1.0 - dielectric_reflectance(o[2], at.eta)) * (1.0 - dielectric_reflectance(i[2], at.eta)) * lambert
        return (
            both * at.r * (1.0 - row.transparency[0]), both * at.g * (1.0 - row.transparency[1]),
            both * at.b * (1.0 - row.transparency[2]), lobes.matte * lambert,
        )  # fmt: skip
    if row.kind == GLOSSY:
        shine, density = evaluate_phong(row, o, i)
        sr, sg, sb = row.specular[0], row.specular[1], row.specular[2]
        return (
            at.r * (1.0 - sr) * lambert + sr * shine, at.g * (1.0 - sg) * lambert + sg * shine,
            at.b * (1.0 - sb) * lambert + sb * shine, lobes.mirror * density + lobes.matte * lambert,
        )  # fmt: skip
    kept, density = 0.0, 0.0
    if is_rough(row):
        kept, density = evaluate_ggx(o, i, row.roughness)
        density *= lobes.mirror
    density += lobes.matte * lambert
    if row.kind == METAL:
        r, g, b = rough_metal(materials, tables, at.row, o, i, kept)
        return r, g, b, density
    ar, ag, ab = mirrored_share(materials, tables, at.row, o[2])
    br, bg, bb = mirrored_share(materials, tables, at.row, i[2])
    r = base_under_top(row, 0, at.r, ar, br, mean_albedo(tables, at.row, 0)) * i[2]
    g = base_under_top(row, 1, at.g, ag, bg, mean_albedo(tables, at.row, 1)) * i[2]
    b = base_under_top(row, 2, at.b, ab, bb, mean_albedo(tables, at.row, 2)) * i[2]
    if kept > 0.0:
        h = half_direction(o, i)
        tr, tg, tb = top_reflectance(row, dot(o[0], o[1], o[2], h[0], h[1], h[2]))
        r, g, b = r + tr * kept, g + tg * kept, b + tb * kept
    return r, g, b, density


@inline
def sample_lobes(
    materials: MaterialTable, tables: AlbedoTables, at: LobeSurface, o: Direction, choice: float, u: float, v: float
) -> BsdfSample:
    """A direction for light that goes to o; all three numbers are in [0, 1)."""
    if o[2] <= 0.0:
        return lost_sample()
    if _is_lambert(materials, at):
        i = cosine_direction(u, v)
        return BsdfSample(SPREAD, i, at.r, at.g, at.b, _PER_PI * i[2]) if i[2] > 0.0 else lost_sample()
    return _sample_general(materials, tables, at, o, choice, u, v)


@helper
def _sample_general(
    materials: MaterialTable, tables: AlbedoTables, at: LobeSurface, o: Direction, choice: float, u: float, v: float
) -> BsdfSample:
    """`draw`, of all but Lambert's law."""
    row = materials.rows[at.row]
    lobes = _lobes(materials, tables, at, o[2])
    if choice < lobes.mirror:
        if at.refracts and is_rough(row) and at.eta != 1.0:
            return _weigh_sample(materials, tables, at, o, sample_wall_facet(row, at, o, choice / lobes.mirror, u, v))
        if row.kind == GLOSSY and not at.refracts:
            return _weigh_sample(materials, tables, at, o, sample_phong(row, o, u, v))
        if is_rough(row) and not at.refracts:
            return _weigh_sample(
                materials, tables, at, o, mirror_direction(o, sample_visible_normal(o, row.roughness, u, v))
            )
        r, g, b = 1.0, 1.0, 1.0
        if at.refracts:
            r = dielectric_reflectance(o[2], at.eta)
            g, b = r, r
        elif row.kind == METAL:
            r, g, b = metal_fresnel(row, o[2])
        else:
            r, g, b = top_reflectance(row, o[2])
        return BsdfSample(SHARP, (-o[0], -o[1], o[2]), r / lobes.mirror, g / lobes.mirror, b / lobes.mirror, 0.0)
    choice -= lobes.mirror
    if choice < lobes.matte:
        return _weigh_sample(materials, tables, at, o, cosine_direction(u, v))
    choice -= lobes.matte
    if choice < lobes.through:
        return _sample_transmission(row, at, o, lobes.through)
    if choice - lobes.through < lobes.beyond:
        x, y, z = cosine_direction(u, v)
        return _weigh_sample(materials, tables, at, o, (x, y, -z))
    return lost_sample()


@inline
def _sample_transmission(row: Any, at: LobeSurface, o: Direction, share: float) -> BsdfSample:
    """On through a pane or a smooth wall."""
    tr, tg, tb = row.transparency[0], row.transparency[1], row.transparency[2]
    if not at.refracts:
        r, g, b = top_reflectance(row, o[2])
        return BsdfSample(
            STRAIGHT, (-o[0], -o[1], -o[2]),
            (1.0 - r) * tr / share, (1.0 - g) * tg / share, (1.0 - b) * tb / share, 0.0,
        )  # fmt: skip
    if at.eta == 1.0:
        return BsdfSample(STRAIGHT, (-o[0], -o[1], -o[2]), tr / share, tg / share, tb / share, 0.0)
    x, y, z, beyond = refract(-o[0], -o[1], -o[2], 0.0, 0.0, 1.0, at.eta)
    if beyond < 0.0:
        return lost_sample()
    kept = (1.0 - dielectric_reflectance(o[2], at.eta)) * at.eta * at.eta / share
    return BsdfSample(SHARP, (x, y, z), kept * tr, kept * tg, kept * tb, 0.0)


@inline
def _weigh_sample(
    materials: MaterialTable, tables: AlbedoTables, at: LobeSurface, o: Direction, i: Direction
) -> BsdfSample:
    """A direction with the weight that all lobes give it."""
    r, g, b, density = _evaluate_general(materials, tables, at, o, i)
    if not density > 0.0:
        return lost_sample()
    return BsdfSample(SPREAD, i, r / density, g / density, b / density, density)


@inline
def has_extent(materials: MaterialTable, at: LobeSurface) -> bool:
    """Has a surface lobes that light from a lamp may fall into?"""
    row = materials.rows[at.row]
    if at.refracts:
        if is_rough(row) and at.eta != 1.0:
            return True
        return at.outside and row.transparency[0] + row.transparency[1] + row.transparency[2] < 3.0
    if row.kind == METAL:
        return is_rough(row)
    return row.kind != LAYERED or is_rough(row) or at.r + at.g + at.b > 0.0


# Scattering about a normal that a texture has bent, over a true surface of normal g in the frame of the bent one.
#
# What a lobe sends to the wrong side of the true surface is mirrored on that (as by the second facet of Schüssler and
# others, Microfacet-based normal mapping for robust Monte Carlo path tracing, 2017, if it were a mirror): so a surface
# that absorbs nothing is as white in a furnace as without its bumps.

FLAT_NORMAL = (0.0, 0.0, 1.0)
"""Where nothing is bent."""


@inline
def _mirror_at_surface(i: Direction, g: Direction) -> Direction:
    twice = 2.0 * dot(i[0], i[1], i[2], g[0], g[1], g[2])
    return i[0] - twice * g[0], i[1] - twice * g[1], i[2] - twice * g[2]


@inline
def evaluate_bsdf(
    materials: MaterialTable, tables: AlbedoTables, at: LobeSurface, o: Direction, i: Direction, g: Direction
) -> tuple[float, float, float, float]:
    """`evaluate`, of what comes from i itself and of what is mirrored into it."""
    if g[2] == 1.0:
        return evaluate_lobes(materials, tables, at, o, i)
    return _evaluate_about_normal(materials, tables, at, o, i, g)


@helper
def _evaluate_about_normal(
    materials: MaterialTable, tables: AlbedoTables, at: LobeSurface, o: Direction, i: Direction, g: Direction
) -> tuple[float, float, float, float]:
    """`evaluate_over` where something is bent."""
    above, other = dot(i[0], i[1], i[2], g[0], g[1], g[2]) > 0.0, _mirror_at_surface(i, g)
    r, g_, b, density = 0.0, 0.0, 0.0, 0.0
    if (i[2] > 0.0) == above:
        r, g_, b, density = evaluate_lobes(materials, tables, at, o, i)
    if (other[2] > 0.0) == above:
        sr, sg, sb, more = evaluate_lobes(materials, tables, at, o, other)
        r, g_, b, density = r + sr, g_ + sg, b + sb, density + more
    return r, g_, b, density


@inline
def sample_bsdf(
    materials: MaterialTable,
    tables: AlbedoTables,
    at: LobeSurface,
    o: Direction,
    g: Direction,
    choice: float,
    u: float,
    v: float,
) -> BsdfSample:
    """`draw`, on the right side of the true surface."""
    drawn = sample_lobes(materials, tables, at, o, choice, u, v)
    if g[2] == 1.0 or drawn.how == LOST or drawn.how == STRAIGHT:
        return drawn
    return _sample_about_normal(materials, tables, at, o, g, drawn)


@helper
def _sample_about_normal(
    materials: MaterialTable, tables: AlbedoTables, at: LobeSurface, o: Direction, g: Direction, drawn: BsdfSample
) -> BsdfSample:
    """`draw_over` where something is bent and a direction was drawn."""
    i = drawn.i
    if (i[2] > 0.0) != (dot(i[0], i[1], i[2], g[0], g[1], g[2]) > 0.0):
        i = _mirror_at_surface(i, g)
    if drawn.how == SHARP:
        return BsdfSample(SHARP, i, drawn.r, drawn.g, drawn.b, 0.0)
    r, green, b, density = evaluate_bsdf(materials, tables, at, o, i, g)
    if not density > 0.0:
        return lost_sample()
    return BsdfSample(SPREAD, i, r / density, green / density, b / density, density)
