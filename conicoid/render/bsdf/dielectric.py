"""Walls between dielectrics, smooth or rough: their lobes, Whitted's refraction there, and dispersion.

A wall is not a kind of material: the solid that is transparent decides (`LobeSurface.refracts`), whatever the kind of
the row, so the dispatch asks for walls first.
"""

from __future__ import annotations

import math
from typing import Any

from ..._jit.decorators import helper, inline
from ...kernels.numbers.elementary import exp
from ...kernels.numbers.vectors import Vector, dot
from ..sampling import Direction, cosine_direction
from .albedo_tables import INSIDE_OUT, OUTSIDE_IN, AlbedoTables, albedo, mean_albedo, refracted_albedos
from .bsdf_sample import (
    SHARP,
    STRAIGHT,
    BsdfSample,
    LobeProbabilities,
    LobeSurface,
    is_rough,
    lost_sample,
    mean_rgb,
    spread_sample,
)
from .material_table import MaterialTable
from .microfacet import (
    dielectric_fresnel,
    dielectric_reflectance,
    evaluate_ggx,
    ggx_density,
    half_direction,
    mirror_direction,
    refract,
    sample_visible_normal,
    smith_lambda,
)

_PER_PI = 1.0 / math.pi


def fill_albedos(row: Any, values: Any) -> None:
    """Fill E of a rough wall, seen from outside and from inside."""
    alpha = float(row["roughness"])
    for channel, eta in ((OUTSIDE_IN, 1 / float(row["index"])), (INSIDE_OUT, float(row["index"]))):
        values[channel] = refracted_albedos(alpha, eta)


# Whitted's walls


@inline
def split_at_wall(d: Vector, n: Vector, cosine: float, eta: float) -> tuple[float, float, float, float]:
    """Return (the refracted direction, F) of unit d at a wall of unit normal n, d·n = -cosine <= 0.

    eta: the index in front over the index behind. Where reflection is total the direction is 0 and F is 1.
    """
    tx, ty, tz, beyond = refract(d[0], d[1], d[2], n[0], n[1], n[2], eta)
    return tx, ty, tz, dielectric_fresnel(cosine, beyond, eta)


@inline
def wall_reflectance(cosine: float, index1: float, index2: float) -> float:
    """Return Fresnel's reflectance of a wall between two media for light from the rarer one."""
    eta = min(index1, index2) / max(index1, index2)
    beyond = 1.0 - eta * eta * (1.0 - cosine * cosine)
    return dielectric_fresnel(min(1.0, cosine), math.sqrt(max(0.0, beyond)), eta)


# Lobes of light transport


@inline
def has_albedo_table(row: Any, eta: float) -> bool:
    """Return whether the tables of a wall are for the two media that it separates: they know vacuum outside alone."""
    return bool(abs(eta * row.index - 1.0) < 0.1 or abs(eta - row.index) < 0.1 * row.index)


@inline
def _channels(row: Any, eta: float) -> tuple[int, int]:
    """Return the channels of the tables of the side of o, and of the side beyond."""
    if abs(eta * row.index - 1.0) <= abs(eta - row.index):
        return OUTSIDE_IN, INSIDE_OUT
    return INSIDE_OUT, OUTSIDE_IN


@inline
def _beyond_share(tables: AlbedoTables, k: int, here: int, there: int, eta: float) -> float:
    """Return the share of light after several facets that ends up beyond, such that f is reciprocal."""
    near = (1.0 - mean_albedo(tables, k, here)) * eta * eta
    far = 1.0 - mean_albedo(tables, k, there)
    return far / (near + far) if near + far > 0.0 else 0.0


@inline
def wall_lobes(materials: MaterialTable, tables: AlbedoTables, at: LobeSurface, cosine: float) -> LobeProbabilities:
    """Return about the shares of light that the lobes of a wall send on."""
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
    """Return (r, g, b, density) of i by single facets, reflected or refracted, for radiance from i.

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
    """Return (r, g, b, density), f |cos| of a rough wall: by single facets and by several."""
    row = materials.rows[at.row]
    r, g, b, density = _wall_facets(row, o, i, at.eta)
    lobes = wall_lobes(materials, tables, at, o[2])
    density *= lobes.mirror
    if not has_albedo_table(row, at.eta):
        return r, g, b, density
    here, there = _channels(row, at.eta)
    lost = 1.0 - albedo(tables, at.row, here, o[2])
    if i[2] > 0.0:
        multiple = lost * (1.0 - albedo(tables, at.row, here, i[2])) / (1.0 - mean_albedo(tables, at.row, here))
        multiple *= (1.0 - _beyond_share(tables, at.row, here, there, at.eta)) * _PER_PI * i[2]
        return r + multiple, g + multiple, b + multiple, density + lobes.matte * _PER_PI * i[2]
    multiple = lost * (1.0 - albedo(tables, at.row, there, -i[2])) / (1.0 - mean_albedo(tables, at.row, there))
    multiple *= _beyond_share(tables, at.row, here, there, at.eta) * _PER_PI * -i[2] * at.eta * at.eta
    r, g, b = r + multiple * row.transparency[0], g + multiple * row.transparency[1], b + multiple * row.transparency[2]
    return r, g, b, density - lobes.beyond * _PER_PI * i[2]


@inline
def sample_wall_facet(row: Any, at: LobeSurface, o: Direction, choice: float, u: float, v: float) -> Direction:
    """Return a direction by a facet of a rough wall: mirrored with the probability of Fresnel's factor, else refracted.

    It is 0, which `evaluate` weighs with 0, where the facet sends light to the wrong side.
    """
    h = sample_visible_normal(o, row.roughness, u, v)
    along = min(1.0, dot(o[0], o[1], o[2], h[0], h[1], h[2]))
    if choice < dielectric_reflectance(along, at.eta):
        i = mirror_direction(o, h)
        return i if i[2] > 0.0 else (0.0, 0.0, 0.0)
    x, y, z, beyond = refract(-o[0], -o[1], -o[2], h[0], h[1], h[2], at.eta)
    return (x, y, z) if beyond >= 0.0 and z < 0.0 else (0.0, 0.0, 0.0)


@inline
def evaluate_wall(
    materials: MaterialTable, tables: AlbedoTables, at: LobeSurface, o: Direction, i: Direction
) -> tuple[float, float, float, float]:
    """Return (r, g, b, density) of a wall, as `SurfaceKind.evaluate`."""
    row = materials.rows[at.row]
    if is_rough(row) and at.eta != 1.0:
        return rough_wall(materials, tables, at, o, i)
    if i[2] <= 0.0 or not at.outside:
        return 0.0, 0.0, 0.0, 0.0
    lambert, lobes = _PER_PI * i[2], wall_lobes(materials, tables, at, o[2])
    both = (1.0 - dielectric_reflectance(o[2], at.eta)) * (1.0 - dielectric_reflectance(i[2], at.eta)) * lambert
    return (
        both * at.r * (1.0 - row.transparency[0]), both * at.g * (1.0 - row.transparency[1]),
        both * at.b * (1.0 - row.transparency[2]), lobes.matte * lambert,
    )  # fmt: skip


@inline
def sample_wall(
    materials: MaterialTable, tables: AlbedoTables, at: LobeSurface, o: Direction, choice: float, u: float, v: float
) -> BsdfSample:
    """Return a direction from a wall, as `SurfaceKind.sample`."""
    row = materials.rows[at.row]
    lobes = wall_lobes(materials, tables, at, o[2])
    if choice < lobes.mirror:
        if is_rough(row) and at.eta != 1.0:
            return spread_sample(sample_wall_facet(row, at, o, choice / lobes.mirror, u, v))
        share = dielectric_reflectance(o[2], at.eta) / lobes.mirror
        return BsdfSample(SHARP, (-o[0], -o[1], o[2]), share, share, share, 0.0)
    choice -= lobes.mirror
    if choice < lobes.matte:
        return spread_sample(cosine_direction(u, v))
    choice -= lobes.matte
    if choice < lobes.through:
        return _sample_refraction(row, at, o, lobes.through)
    if choice - lobes.through < lobes.beyond:
        x, y, z = cosine_direction(u, v)
        return spread_sample((x, y, -z))
    return lost_sample()


@inline
def _sample_refraction(row: Any, at: LobeSurface, o: Direction, share: float) -> BsdfSample:
    """Return the way through a smooth wall, which `share` of samples take."""
    tr, tg, tb = row.transparency[0], row.transparency[1], row.transparency[2]
    if at.eta == 1.0:
        return BsdfSample(STRAIGHT, (-o[0], -o[1], -o[2]), tr / share, tg / share, tb / share, 0.0)
    x, y, z, beyond = refract(-o[0], -o[1], -o[2], 0.0, 0.0, 1.0, at.eta)
    if beyond < 0.0:
        return lost_sample()
    passes = (1.0 - dielectric_reflectance(o[2], at.eta)) * at.eta * at.eta / share
    return BsdfSample(SHARP, (x, y, z), passes * tr, passes * tg, passes * tb, 0.0)


@inline
def wall_has_extent(materials: MaterialTable, at: LobeSurface) -> bool:
    """Return whether any lobe of a wall has an extent, as `SurfaceKind.has_extent`."""
    row = materials.rows[at.row]
    if is_rough(row) and at.eta != 1.0:
        return True
    return at.outside and row.transparency[0] + row.transparency[1] + row.transparency[2] < 3.0


# Dispersion: glass that bends blue more than red. A path takes one wavelength when it first reaches such glass.
#
# The index is Cauchy's, n(λ) = n + B (1 / λ² - 1 / λ_d²), λ in μm. A wavelength is drawn evenly from 0.38 to 0.73 μm,
# and its light has the colour of the eye's matching functions (Wyman, Sloan and Shirley, Simple analytic approximations
# to the CIE XYZ color matching functions, JCGT 2(2), 2013) in linear sRGB, scaled so that all together are white.
# Saturated colours lie outside of sRGB: such light has a negative channel.

FIRST_WAVELENGTH, LAST_WAVELENGTH = 0.38, 0.73
_SODIUM = 0.5876  # λ_d


@inline
def sample_wavelength(u: float) -> float:
    """Return the wavelength in μm for a number u in [0, 1)."""
    return FIRST_WAVELENGTH + u * (LAST_WAVELENGTH - FIRST_WAVELENGTH)


@inline
def index_at_wavelength(index: float, dispersion: float, wave: float) -> float:
    """Return the refractive index at a wavelength in μm; a wave of 0 means all, with the index itself."""
    if wave == 0.0 or dispersion == 0.0:
        return index
    return max(1e-3, index + dispersion * (1.0 / (wave * wave) - 1.0 / (_SODIUM * _SODIUM)))


WHITE = (0.366748209, 0.290096498, 0.277329495)
"""The mean of each channel over all wavelengths, by which colours are divided."""


@inline
def _bell(wave: float, height: float, middle: float, below: float, above: float) -> float:
    """Return a Gaussian whose widths below and above its middle differ; all in nm but the wave, in μm."""
    t = 1000.0 * (wave - middle) / (below if wave < middle else above)
    return height * exp(-0.5 * t * t)


@helper
def wavelength_color(wave: float) -> tuple[float, float, float]:
    """Return the linear rgb of one wavelength; the mean over all is 1."""
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
