"""What of the light that comes along one direction rough surfaces send on, in tables: what facets lose is put back.

Single scattering by facets loses the light that meets a second facet. Kulla and Conty (Revisiting physically based
shading, SIGGRAPH 2017) add it as a lobe (1 - E(o)) (1 - E(i)) / (π (1 - E')), from the directional albedo E of what is
there and its mean E' = 2 ∫ E μ dμ. The tables are made when a scene's materials are, by quadrature over the visible
normals, for the roughness of each.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np

from ..._jit.decorators import inline, record_shapes
from ...kernels.tables import Floats
from ...numerics.portable_math import sin_cos_degrees
from .fresnel import conductor_reflectances, dielectric_reflectances
from .material_table import LAYERED, METAL, MaterialTable

STEPS = 32
"""Cosines of a table: squares of 0, 1 / 31, ... 1, as E bends near 0."""
_COSINES = np.linspace(0, 1, STEPS) ** 2
_GRID, _FINE = 48, 4096
SMOOTH = 1e-3
"""Less rough than that is smooth."""
CHANNELS, MEANS = 3, 6
OUTSIDE_IN, INSIDE_OUT = 0, 1
"""Channels of what refracts: seen from outside, and from inside."""


@record_shapes(values="*", means="*")
class AlbedoTables(NamedTuple):
    """Tables for each row of materials."""

    values: Floats
    """[rows, CHANNELS, STEPS] E: of a metal without Fresnel's factor; of a coat, rgb; of what refracts, both ways."""
    means: Floats
    """[rows, MEANS] E' of each channel; then of metals, rgb, the mean of Fresnel's factor."""


def lower_albedos(materials: MaterialTable) -> AlbedoTables:
    """The tables of all rows."""
    rows = materials.rows
    values, means = np.ones((len(rows), CHANNELS, STEPS)), np.ones((len(rows), MEANS))
    for k, row in enumerate(rows):
        _fill(row, values[k], means[k])
    return AlbedoTables(values.ravel(), means.ravel())


def _fill(row: Any, values: Any, means: Any) -> None:
    alpha = float(row["roughness"])
    rough = alpha > SMOOTH
    if row["kind"] == METAL:
        for c in range(3):
            index, extinction = float(row["metal_index"][c]), float(row["metal_extinction"][c])
            means[3 + c] = _fresnel_mean(functools.partial(conductor_reflectances, index=index, extinction=extinction))
        if rough:
            values[:] = _reflected(alpha, lambda mu: np.ones_like(mu))
    elif row["transparent"] and rough and row["index"] != 1:
        for channel, eta in ((OUTSIDE_IN, 1 / float(row["index"])), (INSIDE_OUT, float(row["index"]))):
            values[channel] = _refracted(alpha, eta)
    elif row["kind"] == LAYERED:
        for c in range(3):
            share = _top(row, c)
            if rough:
                values[c] = _reflected(alpha, share)
            else:
                values[c], means[c] = share(_COSINES), _fresnel_mean(share)
    if rough:
        means[:3] = [_mean(values[c]) for c in range(3)]


def _top(row: Any, c: int) -> Callable[[Any], Any]:
    """Fresnel's factor of a layered surface by the cosine."""
    if row["coat"] > 1:
        return lambda mu: dielectric_reflectances(mu, 1 / float(row["coat"]))
    base = float(row["reflectivity"][c])
    if row["fresnel"]:
        return lambda mu: base + (1 - base) * _fifth(1 - mu)
    return lambda mu: np.full_like(mu, base)


def _fifth(x: Any) -> Any:
    """x⁵ by products, the same on every machine."""
    return x * x * (x * x) * x


def _fresnel_mean(share: Callable[[Any], Any]) -> float:
    """2 ∫ F μ dμ, by the midpoint rule over the square root of the cosine."""
    s = (np.arange(_FINE) + 0.5) / _FINE
    return float(4 * (share(s * s) * (s * s * s)).sum() / _FINE)


def _mean(values: Any) -> float:
    """2 ∫ E μ dμ of what `albedo` makes of a table: linear between its cosines."""
    a, b, low, high = values[:-1], values[1:], _COSINES[:-1], _COSINES[1:]
    slope = (b - a) / (high - low)
    cubes = high * high * high - low * low * low
    return float(2 * np.sum((a - slope * low) * (high * high - low * low) / 2 + slope * cubes / 3))


def _facets(mu: float, alpha: float) -> tuple[Any, Any]:
    """(o, normals) of facets seen from a cosine, on a grid of the unit square (`microfacets.visible_facet`)."""
    o = np.array([np.sqrt(1 - mu * mu), 0.0, mu])
    grid = (np.arange(_GRID) + 0.5) / _GRID
    (cosines, v), (sines, _) = (np.meshgrid(each, grid) for each in _circle())
    s = np.array([alpha * o[0], 0.0, o[2]])
    s /= np.sqrt((s * s).sum())
    z = (1 - v) * (1 + s[2]) - s[2]
    r = np.sqrt(np.maximum(0, 1 - z * z))
    x, y, z = (each.ravel() for each in (alpha * (r * cosines + s[0]), alpha * r * sines, np.maximum(0, z + s[2])))
    return o, np.stack([x, y, z], axis=1) / np.sqrt(x * x + y * y + z * z)[:, None]


@functools.cache
def _circle() -> tuple[Any, Any]:
    """Cosines and sines of the angles of the grid, rounded once."""
    pairs = [sin_cos_degrees(Fraction(360 * (2 * k + 1), 2 * _GRID)) for k in range(_GRID)]
    return np.array([c for _, c in pairs]), np.array([s for s, _ in pairs])


def _masked_share(z: Any, alpha: float) -> Any:
    """Smith's Λ by the cosine."""
    z2 = np.maximum(z * z, 1e-300)
    return (np.sqrt(1 + alpha**2 * np.maximum(0, 1 - z2) / z2) - 1) / 2


def _cosine(mu: float) -> float:
    """Not quite along the surface."""
    return max(float(mu), 1e-4)


def _reflected(alpha: float, share: Callable[[Any], Any]) -> Any:
    """E of rough mirrors with a Fresnel factor, at the cosines of a table."""
    found = []
    for mu in _COSINES:
        o, h = _facets(_cosine(mu), alpha)
        along = h[:, 0] * o[0] + h[:, 2] * o[2]
        i = 2 * along * h[:, 2] - o[2]
        kept = (1 + _masked_share(o[2], alpha)) / (1 + _masked_share(o[2], alpha) + _masked_share(i, alpha))
        found.append(np.mean(np.where(i > 0, kept * share(np.clip(along, 0, 1)), 0)))
    return np.array(found)


def _refracted(alpha: float, eta: float) -> Any:
    """E of what rough walls between dielectrics reflect and let through, together."""
    found = []
    for mu in _COSINES:
        o, h = _facets(_cosine(mu), alpha)
        along = np.clip(h[:, 0] * o[0] + h[:, 2] * o[2], 0, 1)
        share = dielectric_reflectances(along, eta)
        own = 1 + _masked_share(o[2], alpha)
        back = 2 * along * h[:, 2] - o[2]
        beyond = np.sqrt(np.maximum(0, (1 - eta) * (1 + eta) + (eta * along) ** 2))
        through = (eta * along - beyond) * h[:, 2] - eta * o[2]
        mirrored = np.where(back > 0, share * own / (own + _masked_share(back, alpha)), 0)
        passed = np.where(through < 0, (1 - share) * own / (own + _masked_share(through, alpha)), 0)
        found.append(np.mean(mirrored + passed))
    return np.array(found)


@inline
def albedo(tables: AlbedoTables, row: int, channel: int, cosine: float) -> float:
    """E of a row of materials for a cosine in [0, 1]."""
    place = math.sqrt(min(1.0, max(0.0, cosine))) * (STEPS - 1)
    k = min(STEPS - 2, int(place))
    low, high = k / (STEPS - 1.0), (k + 1) / (STEPS - 1.0)
    s = (cosine - low * low) / (high * high - low * low)
    at = (row * CHANNELS + channel) * STEPS + k
    return float(tables.values[at] + s * (tables.values[at + 1] - tables.values[at]))


@inline
def mean_albedo(tables: AlbedoTables, row: int, channel: int) -> float:
    """E' of a row; from channel 3 on the mean of a metal's Fresnel factor."""
    return float(tables.means[row * MEANS + channel])
