"""Walls between dielectrics, smooth or rough: how likely their lobes are, and the facets of rough ones."""

from __future__ import annotations

import math
from typing import Any

from ..._jit.decorators import helper, inline
from ...kernels.numbers.elementary import exp
from ...kernels.numbers.vectors import dot
from ..sampling import Direction
from .albedo_tables import INSIDE_OUT, OUTSIDE_IN, AlbedoTables, albedo, mean_albedo
from .bsdf_sample import LobeProbabilities, LobeSurface, is_rough, mean_rgb
from .fresnel import dielectric_reflectance, refract
from .material_table import MaterialTable
from .microfacet import evaluate_ggx, ggx_density, half_direction, mirror_direction, sample_visible_normal, smith_lambda

_PER_PI = 1.0 / math.pi


@inline
def has_albedo_table(row: Any, eta: float) -> bool:
    """Are a refracting wall's tables for what lies on its two sides?"""
    return bool(abs(eta * row.index - 1.0) < 0.1 or abs(eta - row.index) < 0.1 * row.index)


@inline
def _channels(row: Any, eta: float) -> tuple[int, int]:
    """The tables of the side of o, and of that beyond."""
    if abs(eta * row.index - 1.0) <= abs(eta - row.index):
        return OUTSIDE_IN, INSIDE_OUT
    return INSIDE_OUT, OUTSIDE_IN


@inline
def _beyond_share(tables: AlbedoTables, k: int, here: int, there: int, eta: float) -> float:
    """The share of what facets scatter again that ends up beyond: so that light may take every path backwards."""
    near = (1.0 - mean_albedo(tables, k, here)) * eta * eta
    far = 1.0 - mean_albedo(tables, k, there)
    return far / (near + far) if near + far > 0.0 else 0.0


@inline
def wall_lobes(materials: MaterialTable, tables: AlbedoTables, at: LobeSurface, cosine: float) -> LobeProbabilities:
    row = materials.rows[at.row]
    if is_rough(row) and at.eta != 1.0:
        if not has_albedo_table(row, at.eta):
            return LobeProbabilities(1.0, 0.0, 0.0, 0.0)
        here, there = _channels(row, at.eta)
        once = albedo(tables, at.row, here, cosine)
        beyond = _beyond_share(tables, at.row, here, there, at.eta)
        return LobeProbabilities(once, (1.0 - once) * (1.0 - beyond), 0.0, (1.0 - once) * beyond)
    share = dielectric_reflectance(cosine, at.eta)
    clear = mean_rgb(row.transparency[0], row.transparency[1], row.transparency[2])
    soft = (1.0 - share) * (1.0 - clear) * mean_rgb(at.r, at.g, at.b) if at.outside else 0.0
    through = (1.0 - share) * clear
    total = share + through + soft
    return LobeProbabilities(share / total, soft / total, through / total, 0.0)


@inline
def _wall_facets(row: Any, o: Direction, i: Direction, eta: float) -> tuple[float, float, float, float]:
    """(rgb, density) of i by single facets, reflected or refracted, for radiance that comes from i.

    Walter and others, Microfacet models for refraction through rough surfaces, EGSR 2007, with the change of solid
    angle in refraction: h is along o + i / eta.
    """
    alpha = row.roughness
    if i[2] > 0.0:
        h = half_direction(o, i)
        share = dielectric_reflectance(min(1.0, dot(o[0], o[1], o[2], h[0], h[1], h[2])), eta)
        kept, density = evaluate_ggx(o, i, alpha)
        return share * kept, share * kept, share * kept, share * density
    h = half_direction((eta * o[0], eta * o[1], eta * o[2]), i)
    if h[2] < 0.0:
        h = (-h[0], -h[1], -h[2])
    near, far = dot(o[0], o[1], o[2], h[0], h[1], h[2]), dot(i[0], i[1], i[2], h[0], h[1], h[2])
    if near <= 0.0 or far >= 0.0:
        return 0.0, 0.0, 0.0, 0.0
    passes = 1.0 - dielectric_reflectance(min(1.0, near), eta)
    root = far + near * eta
    jacobian = -far / (root * root)
    own = smith_lambda(o, alpha)
    once = ggx_density(h, alpha) * passes * near * jacobian / o[2]
    kept = once / (1.0 + own + smith_lambda((i[0], i[1], -i[2]), alpha)) * eta * eta
    return kept * row.transparency[0], kept * row.transparency[1], kept * row.transparency[2], once / (1.0 + own)


@inline
def rough_wall(
    materials: MaterialTable, tables: AlbedoTables, at: LobeSurface, o: Direction, i: Direction
) -> tuple[float, float, float, float]:
    """(f cos, density) of a rough dielectric: single facets, and what meets several."""
    row = materials.rows[at.row]
    r, g, b, density = _wall_facets(row, o, i, at.eta)
    lobes = wall_lobes(materials, tables, at, o[2])
    density *= lobes.mirror
    if not has_albedo_table(row, at.eta):
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
def sample_wall_facet(row: Any, at: LobeSurface, o: Direction, choice: float, u: float, v: float) -> Direction:
    """A direction by a facet of a rough wall: mirrored as often as Fresnel says, else refracted."""
    h = sample_visible_normal(o, row.roughness, u, v)
    along = min(1.0, dot(o[0], o[1], o[2], h[0], h[1], h[2]))
    if choice < dielectric_reflectance(along, at.eta):
        i = mirror_direction(o, h)
        return i if i[2] > 0.0 else (0.0, 0.0, 0.0)
    x, y, z, beyond = refract(-o[0], -o[1], -o[2], h[0], h[1], h[2], at.eta)
    return (x, y, z) if beyond >= 0.0 and z < 0.0 else (0.0, 0.0, 0.0)


# Glass that bends blue more than red: a path takes one wavelength when it first meets such glass.
#
# The index is Cauchy's, n(λ) = n + B (1 / λ² - 1 / λ_d²), λ in μm. A wavelength is drawn evenly from 0.38 to 0.73 μm,
# and
# its light has the colour of the eye's matching functions (Wyman, Sloan and Shirley, Simple analytic approximations to
# the CIE XYZ color matching functions, JCGT 2(2), 2013) in linear sRGB, scaled so that all together are white.
# Saturated colours lie outside of sRGB: such light has a negative channel.

FIRST_WAVELENGTH, LAST_WAVELENGTH = 0.38, 0.73
_SODIUM = 0.5876


@inline
def sample_wavelength(u: float) -> float:
    """Of [0, 1)."""
    return FIRST_WAVELENGTH + u * (LAST_WAVELENGTH - FIRST_WAVELENGTH)


@inline
def index_at_wavelength(index: float, dispersion: float, wave: float) -> float:
    """The refractive index at a wavelength; 0 is none in particular."""
    if wave == 0.0 or dispersion == 0.0:
        return index
    return max(1e-3, index + dispersion * (1.0 / (wave * wave) - 1.0 / (_SODIUM * _SODIUM)))


WHITE = (0.366748209, 0.290096498, 0.277329495)
"""What each channel is in the mean of all wavelengths, but for this factor."""


@inline
def _bell(wave: float, height: float, middle: float, below: float, above: float) -> float:
    t = 1000.0 * (wave - middle) / (below if wave < middle else above)
    return height * exp(-0.5 * t * t)


@helper
def wavelength_color(wave: float) -> tuple[float, float, float]:
    """The colour of one wavelength, 1 in the mean of all."""
    x = (
        _bell(wave, 1.056, 0.5998, 37.9, 31.0) + _bell(wave, 0.362, 0.442, 16.0, 26.7)
        + _bell(wave, -0.065, 0.5011, 20.4, 26.2)
    )  # fmt: skip
    y = _bell(wave, 0.821, 0.5688, 46.9, 40.5) + _bell(wave, 0.286, 0.5309, 16.3, 31.1)
    z = _bell(wave, 1.217, 0.437, 11.8, 36.0) + _bell(wave, 0.681, 0.459, 26.0, 13.8)
    r = (3.2404542 * x - 1.5371385 * y - 0.4985314 * z) / WHITE[0]
    g = (-0.969266 * x + 1.8760108 * y + 0.041556 * z) / WHITE[1]
    b = (0.0556434 * x - 0.2040259 * y + 1.0572252 * z) / WHITE[2]
    return r, g, b
