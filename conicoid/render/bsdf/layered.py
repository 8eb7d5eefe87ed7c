"""Layers: a top that mirrors, of Fresnel's, Schlick's or an even share, over a matte ground; and panes."""

from __future__ import annotations

import math
from typing import Any

from ..._jit.decorators import inline
from .albedo_tables import AlbedoTables, albedo
from .bsdf_sample import is_rough
from .fresnel import dielectric_reflectance, schlick
from .material_table import MaterialTable

_PER_PI = 1.0 / math.pi


@inline
def _top_channel(row: Any, c: int, cosine: float, thin: bool) -> float:
    """What the top of layers mirrors at an angle: a coat, a thin pane, or what the reflectivity says."""
    if row.coat > 1.0:
        return dielectric_reflectance(cosine, 1.0 / row.coat)
    base = row.reflectivity[c]
    if thin and base == 0.0 and row.index != 1.0:
        once = dielectric_reflectance(cosine, 1.0 / row.index)
        return 2.0 * once / (1.0 + once)  # to and fro between its walls
    return schlick(base, cosine) if row.fresnel == 1 else float(base)


@inline
def top_reflectance(row: Any, cosine: float) -> tuple[float, float, float]:
    thin = row.transparent == 1
    cosine = min(1.0, cosine)
    return _top_channel(row, 0, cosine, thin), _top_channel(row, 1, cosine, thin), _top_channel(row, 2, cosine, thin)


@inline
def mirrored_share(materials: MaterialTable, tables: AlbedoTables, k: int, cosine: float) -> tuple[float, float, float]:
    """E of the top of layers."""
    if is_rough(materials.rows[k]):
        return albedo(tables, k, 0, cosine), albedo(tables, k, 1, cosine), albedo(tables, k, 2, cosine)
    return top_reflectance(materials.rows[k], cosine)


@inline
def _base(row: Any, color: float, mean: float) -> float:
    """What comes back from under a coat, light that it sends down again included; or the colour itself."""
    if row.coat <= 1.0:
        return color
    inside = 1.0 - (1.0 - mean) / (row.coat * row.coat)  # E' seen from below, by reciprocity
    return float(color * (1.0 - inside) / (1.0 - color * inside))


@inline
def base_under_top(row: Any, c: int, color: float, share_o: float, share_i: float, mean: float) -> float:
    """f of the colour under a top that mirrors these shares: its albedo is what the top lets through."""
    if mean >= 1.0:
        return 0.0
    between_them = (1.0 - share_o) * (1.0 - share_i) / (1.0 - mean)
    return float(_PER_PI * between_them * (1.0 - row.transparency[c]) * _base(row, color, mean))


@inline
def pane_share(row: Any, cosine: float) -> tuple[float, float, float]:
    """What goes straight through a transparent sheet at an angle."""
    r, g, b = top_reflectance(row, cosine)
    return (1.0 - r) * row.transparency[0], (1.0 - g) * row.transparency[1], (1.0 - b) * row.transparency[2]
