"""Metals: Fresnel's factor of a complex index for red, green and blue, and facets that mirror light more than once."""

from __future__ import annotations

import math
from typing import Any

from ..._jit.decorators import inline
from ...kernels.numbers.vectors import dot
from ..sampling import Direction
from .albedo_tables import AlbedoTables, albedo, mean_albedo
from .fresnel import conductor_fresnel
from .material_table import MaterialTable
from .microfacet import half_direction

_PER_PI = 1.0 / math.pi


@inline
def metal_fresnel(row: Any, cosine: float) -> tuple[float, float, float]:
    """Of a metal."""
    n, k, cosine = row.metal_index, row.metal_extinction, min(1.0, cosine)
    return (
        conductor_fresnel(cosine, n[0], k[0]),
        conductor_fresnel(cosine, n[1], k[1]),
        conductor_fresnel(cosine, n[2], k[2]),
    )


@inline
def rough_metal(
    materials: MaterialTable, tables: AlbedoTables, k: int, o: Direction, i: Direction, kept: float
) -> tuple[float, float, float]:
    """f cos of a rough metal. Of light that meets several facets each takes Fresnel's share."""
    if kept == 0.0:
        return 0.0, 0.0, 0.0
    h = half_direction(o, i)
    r, g, b = metal_fresnel(materials.rows[k], dot(o[0], o[1], o[2], h[0], h[1], h[2]))
    mean = mean_albedo(tables, k, 0)
    again = (1.0 - albedo(tables, k, 0, o[2])) * (1.0 - albedo(tables, k, 0, i[2])) / (1.0 - mean) * _PER_PI * i[2]
    return (
        r * kept + again * _multiple_scattering(mean_albedo(tables, k, 3), mean),
        g * kept + again * _multiple_scattering(mean_albedo(tables, k, 4), mean),
        b * kept + again * _multiple_scattering(mean_albedo(tables, k, 5), mean),
    )


@inline
def _multiple_scattering(share: float, mean: float) -> float:
    """The colour of what metal facets reflect twice or more: F² E' / (1 - F (1 - E')), F the mean of Fresnel's."""
    return share * share * mean / (1.0 - share * (1.0 - mean))
