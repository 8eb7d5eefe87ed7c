"""What each kind of surface does with light: its BSDF times the cosine, and directions drawn from it.

The kinds are those of `shading.materials`. A surface is a sum of lobes; `evaluate` adds up what has an extent, `draw`
takes one lobe by chance, a direction of it, and weighs it by all lobes that could have given that direction. A lobe of
one direction alone (a mirror, a smooth refraction) is drawn by its own weight.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from ..compiler.jit import helper, inline
from ..engine.numbers.vectors import dot
from ..shading.fresnel import schlick
from ..shading.materials import GLOSSY, LAYERED, MATTE, METAL, Materials
from ..shading.refract import refract
from .albedo import INSIDE_OUT, OUTSIDE_IN, SMOOTH, Albedos, albedo, mean_albedo
from .fresnel import conductor, wall
from .glossy import glossy, glossy_direction
from .matte import rough_matte, scattered_again
from .microfacets import between, facets, glint, hidden, mirrored, visible_facet
from .warps import Direction, cosine_direction

_PER_PI = 1.0 / math.pi

LOST, SPREAD, SHARP, STRAIGHT = -1, 0, 1, 2
"""What became of light: it is absorbed; went into a lobe with an extent; into one direction; went on as if nothing were
there."""


class Touched(NamedTuple):
    """What of a surface its lobes depend on."""

    row: Any  # int64: of its material
    r: float  # its diffuse reflectance
    g: float
    b: float
    refracts: bool  # the wall of a transparent solid
    outside: bool  # seen from outside of the body
    eta: float  # index on the side of o over that beyond; of what refracts


class Drawn(NamedTuple):
    """A direction, and by what light that comes from there is weighed."""

    how: Any  # int64: LOST, SPREAD, SHARP, STRAIGHT
    i: Direction
    r: float
    g: float
    b: float
    density: float  # per solid angle, of SPREAD


class Lobes(NamedTuple):
    """How likely each lobe is to be drawn; they add up to 1 at most, the rest is lost."""

    mirror: float
    matte: float
    through: float
    beyond: float  # scattered on the other side


@inline
def nothing() -> Drawn:
    """Light that is lost."""
    return Drawn(LOST, (0.0, 0.0, 1.0), 0.0, 0.0, 0.0, 0.0)


@inline
def _mean(r: float, g: float, b: float) -> float:
    return (r + g + b) * (1.0 / 3.0)


@inline
def _is_rough(row: Any) -> bool:
    return bool(row.roughness > SMOOTH)


# ---- The shares of layers ----


@inline
def _top_of(row: Any, c: int, cosine: float, thin: bool) -> float:
    """What the top of layers mirrors at an angle: a coat, a thin pane, or what the reflectivity says."""
    if row.coat > 1.0:
        return wall(cosine, 1.0 / row.coat)
    base = row.reflectivity[c]
    if thin and base == 0.0 and row.index != 1.0:
        once = wall(cosine, 1.0 / row.index)
        return 2.0 * once / (1.0 + once)  # to and fro between its walls
    return schlick(base, cosine) if row.fresnel == 1 else float(base)


@inline
def _top(row: Any, cosine: float) -> tuple[float, float, float]:
    thin = row.transparent == 1
    cosine = min(1.0, cosine)
    return _top_of(row, 0, cosine, thin), _top_of(row, 1, cosine, thin), _top_of(row, 2, cosine, thin)


@inline
def _mirrored_share(materials: Materials, tables: Albedos, k: int, cosine: float) -> tuple[float, float, float]:
    """E of the top of layers."""
    if _is_rough(materials.rows[k]):
        return albedo(tables, k, 0, cosine), albedo(tables, k, 1, cosine), albedo(tables, k, 2, cosine)
    return _top(materials.rows[k], cosine)


@inline
def _base(row: Any, color: float, mean: float) -> float:
    """What comes back from under a coat, light that it sends down again included; or the colour itself."""
    if row.coat <= 1.0:
        return color
    inside = 1.0 - (1.0 - mean) / (row.coat * row.coat)  # E' seen from below, by reciprocity
    return float(color * (1.0 - inside) / (1.0 - color * inside))


@inline
def _under(row: Any, c: int, color: float, share_o: float, share_i: float, mean: float) -> float:
    """f of the colour under a top that mirrors these shares: its albedo is what the top lets through."""
    if mean >= 1.0:
        return 0.0
    between_them = (1.0 - share_o) * (1.0 - share_i) / (1.0 - mean)
    return float(_PER_PI * between_them * (1.0 - row.transparency[c]) * _base(row, color, mean))


# ---- How likely lobes are ----


@inline
def _lobes(materials: Materials, tables: Albedos, at: Touched, cosine: float) -> Lobes:
    """Shares of what lobes send on, about."""
    row = materials.rows[at.row]
    if at.refracts:
        return _glass_lobes(materials, tables, at, cosine)
    if row.kind == METAL:
        if not _is_rough(row):
            return Lobes(1.0, 0.0, 0.0, 0.0)
        once = albedo(tables, at.row, 0, cosine)
        return Lobes(once, 1.0 - once, 0.0, 0.0)
    if row.kind == GLOSSY:
        sharp = _mean(row.specular[0], row.specular[1], row.specular[2])
        soft = _mean(at.r, at.g, at.b) * (1.0 - sharp)
        return Lobes(sharp / (sharp + soft), soft / (sharp + soft), 0.0, 0.0)
    if row.kind == LAYERED:
        r, g, b = _mirrored_share(materials, tables, at.row, cosine)
        top = _mean(r, g, b)
        clear = _mean(row.transparency[0], row.transparency[1], row.transparency[2])
        through, soft = (1.0 - top) * clear, (1.0 - top) * (1.0 - clear) * _mean(at.r, at.g, at.b)
        total = top + through + soft
        if total == 0.0:
            return Lobes(0.0, 0.0, 0.0, 0.0)
        return Lobes(top / total, soft / total, through / total, 0.0)
    return Lobes(0.0, 1.0, 0.0, 0.0)


@inline
def _is_tabled(row: Any, eta: float) -> bool:
    """Are a refracting wall's tables for what lies on its two sides?"""
    return bool(abs(eta * row.index - 1.0) < 0.1 or abs(eta - row.index) < 0.1 * row.index)


@inline
def _glass_channels(row: Any, eta: float) -> tuple[int, int]:
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
def _glass_lobes(materials: Materials, tables: Albedos, at: Touched, cosine: float) -> Lobes:
    row = materials.rows[at.row]
    if _is_rough(row) and at.eta != 1.0:
        if not _is_tabled(row, at.eta):
            return Lobes(1.0, 0.0, 0.0, 0.0)
        here, there = _glass_channels(row, at.eta)
        once = albedo(tables, at.row, here, cosine)
        beyond = _beyond_share(tables, at.row, here, there, at.eta)
        return Lobes(once, (1.0 - once) * (1.0 - beyond), 0.0, (1.0 - once) * beyond)
    share = wall(cosine, at.eta)
    clear = _mean(row.transparency[0], row.transparency[1], row.transparency[2])
    soft = (1.0 - share) * (1.0 - clear) * _mean(at.r, at.g, at.b) if at.outside else 0.0
    through = (1.0 - share) * clear
    total = share + through + soft
    return Lobes(share / total, soft / total, through / total, 0.0)


# ---- Rough walls between dielectrics ----


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
def _rough_wall(
    materials: Materials, tables: Albedos, at: Touched, o: Direction, i: Direction
) -> tuple[float, float, float, float]:
    """(f cos, density) of a rough dielectric: single facets, and what meets several."""
    row = materials.rows[at.row]
    r, g, b, density = _wall_facets(row, o, i, at.eta)
    lobes = _glass_lobes(materials, tables, at, o[2])
    density *= lobes.mirror
    if not _is_tabled(row, at.eta):
        return r, g, b, density
    here, there = _glass_channels(row, at.eta)
    lost = 1.0 - albedo(tables, at.row, here, o[2])
    if i[2] > 0.0:
        again = lost * (1.0 - albedo(tables, at.row, here, i[2])) / (1.0 - mean_albedo(tables, at.row, here))
        again *= (1.0 - _beyond_share(tables, at.row, here, there, at.eta)) * _PER_PI * i[2]
        return r + again, g + again, b + again, density + lobes.matte * _PER_PI * i[2]
    again = lost * (1.0 - albedo(tables, at.row, there, -i[2])) / (1.0 - mean_albedo(tables, at.row, there))
    again *= _beyond_share(tables, at.row, here, there, at.eta) * _PER_PI * -i[2] * at.eta * at.eta
    r, g, b = r + again * row.transparency[0], g + again * row.transparency[1], b + again * row.transparency[2]
    return r, g, b, density - lobes.beyond * _PER_PI * i[2]


# ---- All lobes ----


@helper
def evaluate(
    materials: Materials, tables: Albedos, at: Touched, o: Direction, i: Direction
) -> tuple[float, float, float, float]:
    """(r, g, b, density): f |cos| of light from i that goes to o, and how densely `draw` takes i; 0 of sharp lobes."""
    row = materials.rows[at.row]
    if o[2] <= 0.0 or i[2] == 0.0:
        return 0.0, 0.0, 0.0, 0.0
    if at.refracts and _is_rough(row) and at.eta != 1.0:
        return _rough_wall(materials, tables, at, o, i)
    if i[2] <= 0.0:
        return 0.0, 0.0, 0.0, 0.0
    lambert = _PER_PI * i[2]
    if row.kind == MATTE and not at.refracts:
        if row.roughness == 0.0:
            return at.r * lambert, at.g * lambert, at.b * lambert, lambert
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
    if _is_rough(row):
        kept, density = glint(o, i, row.roughness)
        density *= lobes.mirror
    density += lobes.matte * lambert
    if row.kind == METAL:
        r, g, b = _metal(materials, tables, at.row, o, i, kept)
        return r, g, b, density
    ar, ag, ab = _mirrored_share(materials, tables, at.row, o[2])
    br, bg, bb = _mirrored_share(materials, tables, at.row, i[2])
    r = _under(row, 0, at.r, ar, br, mean_albedo(tables, at.row, 0)) * i[2]
    g = _under(row, 1, at.g, ag, bg, mean_albedo(tables, at.row, 1)) * i[2]
    b = _under(row, 2, at.b, ab, bb, mean_albedo(tables, at.row, 2)) * i[2]
    if kept > 0.0:
        h = between(o, i)
        tr, tg, tb = _top(row, dot(o[0], o[1], o[2], h[0], h[1], h[2]))
        r, g, b = r + tr * kept, g + tg * kept, b + tb * kept
    return r, g, b, density


@inline
def _fresnel(row: Any, cosine: float) -> tuple[float, float, float]:
    """Of a metal."""
    n, k, cosine = row.metal_index, row.metal_extinction, min(1.0, cosine)
    return conductor(cosine, n[0], k[0]), conductor(cosine, n[1], k[1]), conductor(cosine, n[2], k[2])


@inline
def _metal(
    materials: Materials, tables: Albedos, k: int, o: Direction, i: Direction, kept: float
) -> tuple[float, float, float]:
    """f cos of a rough metal. Of light that meets several facets each takes Fresnel's share."""
    if kept == 0.0:
        return 0.0, 0.0, 0.0
    h = between(o, i)
    r, g, b = _fresnel(materials.rows[k], dot(o[0], o[1], o[2], h[0], h[1], h[2]))
    mean = mean_albedo(tables, k, 0)
    again = (1.0 - albedo(tables, k, 0, o[2])) * (1.0 - albedo(tables, k, 0, i[2])) / (1.0 - mean) * _PER_PI * i[2]
    return (
        r * kept + again * _again(mean_albedo(tables, k, 3), mean),
        g * kept + again * _again(mean_albedo(tables, k, 4), mean),
        b * kept + again * _again(mean_albedo(tables, k, 5), mean),
    )


@inline
def _again(share: float, mean: float) -> float:
    """The colour of what metal facets reflect twice or more: F² E' / (1 - F (1 - E')), F the mean of Fresnel's."""
    return share * share * mean / (1.0 - share * (1.0 - mean))


# ---- Draw ----


@helper
def draw(materials: Materials, tables: Albedos, at: Touched, o: Direction, choice: float, u: float, v: float) -> Drawn:
    """A direction for light that goes to o; all three numbers are in [0, 1)."""
    row = materials.rows[at.row]
    if o[2] <= 0.0:
        return nothing()
    if row.kind == MATTE and not at.refracts and row.roughness == 0.0:
        i = cosine_direction(u, v)
        return Drawn(SPREAD, i, at.r, at.g, at.b, _PER_PI * i[2]) if i[2] > 0.0 else nothing()
    lobes = _lobes(materials, tables, at, o[2])
    if choice < lobes.mirror:
        if at.refracts and _is_rough(row) and at.eta != 1.0:
            return _weighed(materials, tables, at, o, _facet_of_wall(row, at, o, choice / lobes.mirror, u, v))
        if row.kind == GLOSSY and not at.refracts:
            return _weighed(materials, tables, at, o, glossy_direction(row, o, u, v))
        if _is_rough(row) and not at.refracts:
            return _weighed(materials, tables, at, o, mirrored(o, visible_facet(o, row.roughness, u, v)))
        r, g, b = 1.0, 1.0, 1.0
        if at.refracts:
            r = wall(o[2], at.eta)
            g, b = r, r
        elif row.kind == METAL:
            r, g, b = _fresnel(row, o[2])
        else:
            r, g, b = _top(row, o[2])
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
        r, g, b = _top(row, o[2])
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
def _facet_of_wall(row: Any, at: Touched, o: Direction, choice: float, u: float, v: float) -> Direction:
    """A direction by a facet of a rough wall: mirrored as often as Fresnel says, else refracted."""
    h = visible_facet(o, row.roughness, u, v)
    along = min(1.0, dot(o[0], o[1], o[2], h[0], h[1], h[2]))
    if choice < wall(along, at.eta):
        i = mirrored(o, h)
        return i if i[2] > 0.0 else (0.0, 0.0, 0.0)
    x, y, z, beyond = refract(-o[0], -o[1], -o[2], h[0], h[1], h[2], at.eta)
    return (x, y, z) if beyond >= 0.0 and z < 0.0 else (0.0, 0.0, 0.0)


@inline
def _weighed(materials: Materials, tables: Albedos, at: Touched, o: Direction, i: Direction) -> Drawn:
    """A direction with the weight that all lobes give it."""
    r, g, b, density = evaluate(materials, tables, at, o, i)
    if not density > 0.0:
        return nothing()
    return Drawn(SPREAD, i, r / density, g / density, b / density, density)


@inline
def has_extent(materials: Materials, at: Touched) -> bool:
    """Has a surface lobes that light from a lamp may fall into?"""
    row = materials.rows[at.row]
    if at.refracts:
        if _is_rough(row) and at.eta != 1.0:
            return True
        return at.outside and row.transparency[0] + row.transparency[1] + row.transparency[2] < 3.0
    if row.kind == METAL:
        return _is_rough(row)
    return row.kind != LAYERED or _is_rough(row) or at.r + at.g + at.b > 0.0


@inline
def pane_share(row: Any, cosine: float) -> tuple[float, float, float]:
    """What goes straight through a transparent sheet at an angle."""
    r, g, b = _top(row, cosine)
    return (1.0 - r) * row.transparency[0], (1.0 - g) * row.transparency[1], (1.0 - b) * row.transparency[2]
