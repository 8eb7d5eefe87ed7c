"""Layers: a top that mirrors, by Fresnel's, Schlick's or an even share, over a matte ground; and thin panes.

Whitted's mirror share is here too (`opaque_reflectance`): there the top is the reflectivity for every material.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from ..._jit.decorators import inline
from ...kernels.numbers.vectors import dot
from ..sampling import Direction, cosine_direction
from . import dielectric
from .albedo_tables import COSINES, SMOOTH, AlbedoTables, albedo, fresnel_mean, mean_albedo, reflected_albedos
from .bsdf_sample import (
    SHARP,
    STRAIGHT,
    BsdfSample,
    LobeProbabilities,
    LobeSurface,
    SurfaceKind,
    is_rough,
    lost_sample,
    mean_rgb,
    spread_sample,
)
from .material_table import MaterialTable
from .microfacet import (
    dielectric_reflectance,
    dielectric_reflectances,
    evaluate_ggx,
    half_direction,
    mirror_direction,
    sample_visible_normal,
    schlick,
)

_PER_PI = 1.0 / math.pi


def is_layered(row: Any) -> bool:
    """Return whether a material mirrors, lets light through or has a coat."""
    return bool((row["reflectivity"] > 0).any() or (row["transparency"] > 0).any() or row["coat"] > 1)


def _fill_albedos(row: Any, values: Any, means: Any) -> None:
    """Fill E of the top, rgb; of a rough transparent material E of the wall, both ways."""
    alpha = float(row["roughness"])
    rough = alpha > SMOOTH
    if row["transparent"] and rough and row["index"] != 1:
        dielectric.fill_albedos(row, values)
        return
    for c in range(3):
        share = _top(row, c)
        if rough:
            values[c] = reflected_albedos(alpha, share)
        else:
            values[c], means[c] = share(COSINES), fresnel_mean(share)


def _top(row: Any, c: int) -> Callable[[Any], Any]:
    """Return Fresnel's factor of the top as a function of an array of cosines."""
    if row["coat"] > 1:
        return lambda mu: dielectric_reflectances(mu, 1 / float(row["coat"]))
    base = float(row["reflectivity"][c])
    if row["fresnel"]:
        return lambda mu: base + (1 - base) * _fifth(1 - mu)
    return lambda mu: np.full_like(mu, base)


def _fifth(x: Any) -> Any:
    """Return x⁵ by products, the same on every machine."""
    return x * x * (x * x) * x


# The top


@inline
def opaque_reflectance(row: Any, cosine: float) -> tuple[float, float, float]:
    """Return Whitted's F, rgb, of a surface that does not refract: the reflectivity, by Schlick if it is Fresnel's."""
    r, g, b = row.reflectivity[0], row.reflectivity[1], row.reflectivity[2]
    if row.fresnel == 1:
        return schlick(r, cosine), schlick(g, cosine), schlick(b, cosine)
    return r, g, b


@inline
def _top_channel(row: Any, c: int, cosine: float, thin: bool) -> float:
    """Return the share that the top mirrors at an angle: of a coat, a thin pane, or by the reflectivity."""
    if row.coat > 1.0:
        return dielectric_reflectance(cosine, 1.0 / row.coat)
    base = row.reflectivity[c]
    if thin and base == 0.0 and row.index != 1.0:
        once = dielectric_reflectance(cosine, 1.0 / row.index)
        return 2.0 * once / (1.0 + once)  # to and fro between its walls
    return schlick(base, cosine) if row.fresnel == 1 else float(base)


@inline
def top_reflectance(row: Any, cosine: float) -> tuple[float, float, float]:
    """Return the share that the top mirrors at an angle, rgb."""
    thin = row.transparent == 1
    cosine = min(1.0, cosine)
    return _top_channel(row, 0, cosine, thin), _top_channel(row, 1, cosine, thin), _top_channel(row, 2, cosine, thin)


@inline
def mirrored_share(materials: MaterialTable, tables: AlbedoTables, k: int, cosine: float) -> tuple[float, float, float]:
    """Return E of the top of row k, rgb."""
    if is_rough(materials.rows[k]):
        return albedo(tables, k, 0, cosine), albedo(tables, k, 1, cosine), albedo(tables, k, 2, cosine)
    return top_reflectance(materials.rows[k], cosine)


@inline
def pane_share(row: Any, cosine: float) -> tuple[float, float, float]:
    """Return the share that goes straight through a transparent sheet at an angle, rgb."""
    r, g, b = top_reflectance(row, cosine)
    return (1.0 - r) * row.transparency[0], (1.0 - g) * row.transparency[1], (1.0 - b) * row.transparency[2]


# The ground under it


@inline
def _base(row: Any, color: float, mean: float) -> float:
    """Return the albedo of the ground: the colour, or under a coat with the light that the coat sends down again."""
    if row.coat <= 1.0:
        return color
    inside = 1.0 - (1.0 - mean) / (row.coat * row.coat)  # E' seen from below, by reciprocity
    return float(color * (1.0 - inside) / (1.0 - color * inside))


@inline
def base_under_top(row: Any, c: int, color: float, share_o: float, share_i: float, mean: float) -> float:
    """Return f of the colour under a top that mirrors these shares: its albedo is the share let through."""
    if mean >= 1.0:
        return 0.0
    between_them = (1.0 - share_o) * (1.0 - share_i) / (1.0 - mean)
    return float(_PER_PI * between_them * (1.0 - row.transparency[c]) * _base(row, color, mean))


# Lobes


@inline
def _lobes(materials: MaterialTable, tables: AlbedoTables, at: LobeSurface, cosine: float) -> LobeProbabilities:
    """Return about the shares of light that the top, the ground and the way through send on; all 0 if black."""
    row = materials.rows[at.row]
    r, g, b = mirrored_share(materials, tables, at.row, cosine)
    top = mean_rgb(r, g, b)
    clear = mean_rgb(row.transparency[0], row.transparency[1], row.transparency[2])
    through, soft = (1.0 - top) * clear, (1.0 - top) * (1.0 - clear) * mean_rgb(at.r, at.g, at.b)
    total = top + through + soft
    if total == 0.0:
        return LobeProbabilities(0.0, 0.0, 0.0, 0.0)
    return LobeProbabilities(top / total, soft / total, through / total, 0.0)


@inline
def _evaluate(
    materials: MaterialTable, tables: AlbedoTables, at: LobeSurface, o: Direction, i: Direction
) -> tuple[float, float, float, float]:
    if i[2] <= 0.0:
        return 0.0, 0.0, 0.0, 0.0
    row = materials.rows[at.row]
    lobes = _lobes(materials, tables, at, o[2])
    once, density = 0.0, 0.0
    if is_rough(row):
        once, density = evaluate_ggx(o, i, row.roughness)
        density *= lobes.mirror
    density += lobes.matte * (_PER_PI * i[2])
    ar, ag, ab = mirrored_share(materials, tables, at.row, o[2])
    br, bg, bb = mirrored_share(materials, tables, at.row, i[2])
    r = base_under_top(row, 0, at.r, ar, br, mean_albedo(tables, at.row, 0)) * i[2]
    g = base_under_top(row, 1, at.g, ag, bg, mean_albedo(tables, at.row, 1)) * i[2]
    b = base_under_top(row, 2, at.b, ab, bb, mean_albedo(tables, at.row, 2)) * i[2]
    if once > 0.0:
        h = half_direction(o, i)
        tr, tg, tb = top_reflectance(row, dot(o[0], o[1], o[2], h[0], h[1], h[2]))
        r, g, b = r + tr * once, g + tg * once, b + tb * once
    return r, g, b, density


@inline
def _sample(
    materials: MaterialTable, tables: AlbedoTables, at: LobeSurface, o: Direction, choice: float, u: float, v: float
) -> BsdfSample:
    row = materials.rows[at.row]
    lobes = _lobes(materials, tables, at, o[2])
    if choice < lobes.mirror:
        if is_rough(row):
            return spread_sample(mirror_direction(o, sample_visible_normal(o, row.roughness, u, v)))
        r, g, b = top_reflectance(row, o[2])
        return BsdfSample(SHARP, (-o[0], -o[1], o[2]), r / lobes.mirror, g / lobes.mirror, b / lobes.mirror, 0.0)
    choice -= lobes.mirror
    if choice < lobes.matte:
        return spread_sample(cosine_direction(u, v))
    if choice - lobes.matte < lobes.through:
        return _sample_pane(row, o, lobes.through)
    return lost_sample()


@inline
def _sample_pane(row: Any, o: Direction, share: float) -> BsdfSample:
    """Return the way straight through a pane, which `share` of samples take."""
    tr, tg, tb = row.transparency[0], row.transparency[1], row.transparency[2]
    r, g, b = top_reflectance(row, o[2])
    return BsdfSample(
        STRAIGHT, (-o[0], -o[1], -o[2]),
        (1.0 - r) * tr / share, (1.0 - g) * tg / share, (1.0 - b) * tb / share, 0.0,
    )  # fmt: skip


@inline
def _has_extent(materials: MaterialTable, at: LobeSurface) -> bool:
    return is_rough(materials.rows[at.row]) or at.r + at.g + at.b > 0.0


LAYERED = SurfaceKind(is_layered, _evaluate, _sample, _has_extent, _fill_albedos)
