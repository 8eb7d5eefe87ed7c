"""Tables of the directional albedo of rough surfaces, from which light lost between facets is given back.

Single scattering by facets loses the light that reaches a second facet. Kulla and Conty (Revisiting physically based
shading, SIGGRAPH 2017) add it as a lobe (1 - E(o)) (1 - E(i)) / (π (1 - E')), from the directional albedo E of single
scattering and its mean E' = 2 ∫ E μ dμ. `lower_albedos` makes the tables when a scene's materials are lowered, by
quadrature over the visible normals, for the roughness of each material.
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
from .microfacet import dielectric_reflectances

STEPS = 32
"""Number of cosines of a table."""
COSINES = np.linspace(0, 1, STEPS) ** 2
"""The cosines of a table: squares of 0, 1 / 31, ... 1, as E bends near 0."""
_GRID, _FINE = 48, 4096
"""Steps of the quadratures: of facets, along both sides of the unit square; of the mean of Fresnel's factor."""
SMOOTH = 1e-3
"""Surfaces of a roughness up to this are smooth."""
CHANNELS, MEANS = 3, 6
OUTSIDE_IN, INSIDE_OUT = 0, 1
"""Channels of walls that refract: seen from outside, and from inside."""


@record_shapes(values="*", means="*")
class AlbedoTables(NamedTuple):
    """Tables for each row of materials, flat."""

    values: Floats
    """[rows, CHANNELS, STEPS] E: of a metal without Fresnel's factor; of a coat, rgb; of a wall, from both sides."""
    means: Floats
    """[rows, MEANS] E' of each channel; then, of metals, the mean of Fresnel's factor, rgb."""


# Quadrature, when materials are lowered. It uses no function of the C library, so tables are the same everywhere.


def fresnel_mean(share: Callable[[Any], Any]) -> float:
    """Return 2 ∫ F μ dμ of a factor F by the cosine μ, by the midpoint rule over the square root of the cosine."""
    s = (np.arange(_FINE) + 0.5) / _FINE
    return float(4 * (share(s * s) * (s * s * s)).sum() / _FINE)


def mean_of_table(values: Any) -> float:
    """Return 2 ∫ E μ dμ of a table (STEPS,) as `albedo` reads it: linear between its cosines."""
    a, b, low, high = values[:-1], values[1:], COSINES[:-1], COSINES[1:]
    slope = (b - a) / (high - low)
    cubes = high * high * high - low * low * low
    return float(2 * np.sum((a - slope * low) * (high * high - low * low) / 2 + slope * cubes / 3))


def _facets(mu: float, alpha: float) -> tuple[Any, Any]:
    """Return (o, normals) of facets visible from a cosine, on a grid of the unit square (`sample_visible_normal`)."""
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
    """Return cosines and sines of the angles of the grid, rounded once."""
    pairs = [sin_cos_degrees(Fraction(360 * (2 * k + 1), 2 * _GRID)) for k in range(_GRID)]
    return np.array([c for _, c in pairs]), np.array([s for s, _ in pairs])


def _masked_share(z: Any, alpha: float) -> Any:
    """Return Smith's Λ for a cosine z."""
    z2 = np.maximum(z * z, 1e-300)
    return (np.sqrt(1 + alpha**2 * np.maximum(0, 1 - z2) / z2) - 1) / 2


def _cosine(mu: float) -> float:
    """Return a cosine that is not quite along the surface, where Λ is infinite."""
    return max(float(mu), 1e-4)


def reflected_albedos(alpha: float, share: Callable[[Any], Any]) -> Any:
    """Return E (STEPS,) of rough mirrors of GGX's roughness alpha, whose Fresnel factor by the cosine is `share`."""
    albedos = []
    for mu in COSINES:
        o, h = _facets(_cosine(mu), alpha)
        along = h[:, 0] * o[0] + h[:, 2] * o[2]
        i = 2 * along * h[:, 2] - o[2]
        visible = (1 + _masked_share(o[2], alpha)) / (1 + _masked_share(o[2], alpha) + _masked_share(i, alpha))
        albedos.append(np.mean(np.where(i > 0, visible * share(np.clip(along, 0, 1)), 0)))
    return np.array(albedos)


def refracted_albedos(alpha: float, eta: float) -> Any:
    """Return E (STEPS,) of rough walls between dielectrics: the light reflected and let through, together.

    eta: the index on the side of o over the index beyond.
    """
    albedos = []
    for mu in COSINES:
        o, h = _facets(_cosine(mu), alpha)
        along = np.clip(h[:, 0] * o[0] + h[:, 2] * o[2], 0, 1)
        share = dielectric_reflectances(along, eta)
        own = 1 + _masked_share(o[2], alpha)
        back = 2 * along * h[:, 2] - o[2]
        beyond = np.sqrt(np.maximum(0, (1 - eta) * (1 + eta) + (eta * along) ** 2))
        through = (eta * along - beyond) * h[:, 2] - eta * o[2]
        mirrored = np.where(back > 0, share * own / (own + _masked_share(back, alpha)), 0)
        passed = np.where(through < 0, (1 - share) * own / (own + _masked_share(through, alpha)), 0)
        albedos.append(np.mean(mirrored + passed))
    return np.array(albedos)


# Reading the tables


@inline
def albedo(tables: AlbedoTables, row: int, channel: int, cosine: float) -> float:
    """Return E of a row of materials for a cosine in [0, 1]."""
    # the inverse of COSINES: a square root, no search
    place = math.sqrt(min(1.0, max(0.0, cosine))) * (STEPS - 1)
    k = min(STEPS - 2, int(place))
    low, high = k / (STEPS - 1.0), (k + 1) / (STEPS - 1.0)
    s = (cosine - low * low) / (high * high - low * low)
    at = (row * CHANNELS + channel) * STEPS + k
    return float(tables.values[at] + s * (tables.values[at + 1] - tables.values[at]))


@inline
def mean_albedo(tables: AlbedoTables, row: int, channel: int) -> float:
    """Return E' of a row; from channel 3 on the mean of a metal's Fresnel factor."""
    return float(tables.means[row * MEANS + channel])
