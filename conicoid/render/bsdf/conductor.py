"""Metals: Fresnel's factor of a complex index for red, green and blue; smooth, or with facets."""

from __future__ import annotations

import functools
import math
from typing import Any

import numpy as np

from ..._jit.decorators import inline
from ...kernels.numbers.vectors import dot
from ..sampling import Direction, cosine_direction
from .albedo_tables import SMOOTH, AlbedoTables, albedo, fresnel_mean, mean_albedo, reflected_albedos
from .bsdf_sample import (
    SHARP,
    BsdfSample,
    LobeProbabilities,
    LobeSurface,
    SurfaceKind,
    is_rough,
    lost_sample,
    spread_sample,
)
from .material_table import MaterialTable
from .microfacet import (
    conductor_fresnel,
    conductor_reflectances,
    evaluate_ggx,
    half_direction,
    mirror_direction,
    sample_visible_normal,
)

_PER_PI = 1.0 / math.pi


def is_metal(row: Any) -> bool:
    """Return whether a material has a complex index."""
    return bool((row["metal_index"] > 0).any())


def _fill_albedos(row: Any, values: Any, means: Any) -> None:
    """Fill E of the facets without Fresnel's factor, and from means[3] on the mean of that factor, rgb."""
    for c in range(3):
        index, extinction = float(row["metal_index"][c]), float(row["metal_extinction"][c])
        means[3 + c] = fresnel_mean(functools.partial(conductor_reflectances, index=index, extinction=extinction))
    alpha = float(row["roughness"])
    if alpha > SMOOTH:
        values[:] = reflected_albedos(alpha, lambda mu: np.ones_like(mu))


@inline
def metal_fresnel(row: Any, cosine: float) -> tuple[float, float, float]:
    """Return Fresnel's factor of a metal, rgb, at an angle."""
    n, k, cosine = row.metal_index, row.metal_extinction, min(1.0, cosine)
    return (
        conductor_fresnel(cosine, n[0], k[0]),
        conductor_fresnel(cosine, n[1], k[1]),
        conductor_fresnel(cosine, n[2], k[2]),
    )


@inline
def rough_metal(
    materials: MaterialTable, tables: AlbedoTables, k: int, o: Direction, i: Direction, once: float
) -> tuple[float, float, float]:
    """Return f cos, rgb, of the rough metal in row k.

    once: the part of single facets without Fresnel's factor (`evaluate_ggx`). Light that reflects off several facets
    takes the factor at each.
    """
    if once == 0.0:
        return 0.0, 0.0, 0.0
    h = half_direction(o, i)
    r, g, b = metal_fresnel(materials.rows[k], dot(o[0], o[1], o[2], h[0], h[1], h[2]))
    mean = mean_albedo(tables, k, 0)
    multiple = (1.0 - albedo(tables, k, 0, o[2])) * (1.0 - albedo(tables, k, 0, i[2])) / (1.0 - mean) * _PER_PI * i[2]
    return (
        r * once + multiple * _multiple_scattering(mean_albedo(tables, k, 3), mean),
        g * once + multiple * _multiple_scattering(mean_albedo(tables, k, 4), mean),
        b * once + multiple * _multiple_scattering(mean_albedo(tables, k, 5), mean),
    )


@inline
def _multiple_scattering(share: float, mean: float) -> float:
    """Return F² E' / (1 - F (1 - E')), the colour of light after two facets or more; F: the mean Fresnel factor."""
    return share * share * mean / (1.0 - share * (1.0 - mean))


@inline
def _lobes(row: Any, tables: AlbedoTables, at: LobeSurface, cosine: float) -> LobeProbabilities:
    """Return the shares of single facets and, by the cosine lobe, of several."""
    if not is_rough(row):
        return LobeProbabilities(1.0, 0.0, 0.0, 0.0)
    once = albedo(tables, at.row, 0, cosine)
    return LobeProbabilities(once, 1.0 - once, 0.0, 0.0)


@inline
def _evaluate(
    materials: MaterialTable, tables: AlbedoTables, at: LobeSurface, o: Direction, i: Direction
) -> tuple[float, float, float, float]:
    if i[2] <= 0.0:
        return 0.0, 0.0, 0.0, 0.0
    row = materials.rows[at.row]
    lobes = _lobes(row, tables, at, o[2])
    once, density = 0.0, 0.0
    if is_rough(row):
        once, density = evaluate_ggx(o, i, row.roughness)
        density *= lobes.mirror
    density += lobes.matte * (_PER_PI * i[2])
    r, g, b = rough_metal(materials, tables, at.row, o, i, once)
    return r, g, b, density


@inline
def _sample(
    materials: MaterialTable, tables: AlbedoTables, at: LobeSurface, o: Direction, choice: float, u: float, v: float
) -> BsdfSample:
    row = materials.rows[at.row]
    lobes = _lobes(row, tables, at, o[2])
    if choice < lobes.mirror:
        if is_rough(row):
            return spread_sample(mirror_direction(o, sample_visible_normal(o, row.roughness, u, v)))
        r, g, b = metal_fresnel(row, o[2])
        return BsdfSample(SHARP, (-o[0], -o[1], o[2]), r / lobes.mirror, g / lobes.mirror, b / lobes.mirror, 0.0)
    if choice - lobes.mirror < lobes.matte:
        return spread_sample(cosine_direction(u, v))
    return lost_sample()


@inline
def _has_extent(materials: MaterialTable, at: LobeSurface) -> bool:
    return is_rough(materials.rows[at.row])


CONDUCTOR = SurfaceKind(is_metal, _evaluate, _sample, _has_extent, _fill_albedos)
