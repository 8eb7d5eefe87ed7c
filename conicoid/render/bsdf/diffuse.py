"""Matte surfaces: Lambert's law, or Oren and Nayar's where the material is rough.

The rough law is the form that loses no energy: Portsmouth, Kutz and Hill, EON: A practical energy-preserving rough
diffuse BRDF, JCGT 14(1), 2025, after Fujii's form of Oren and Nayar's model. With roughness σ in [0, 1],
A = 1 / (1 + (1/2 - 2/(3π)) σ), s = i·o - i_z o_z:
    f = ρ A / π (1 + σ s / t) + ρ_m / π (1 - E(i)) (1 - E(o)) / (1 - E'), t = max(i_z, o_z) where s > 0, else 1,
where E is the first term's albedo for ρ = 1, E' its mean and ρ_m = ρ² E' / (1 - ρ (1 - E')) the colour of light that
is scattered again.
"""

from __future__ import annotations

import math
from typing import Any

from ..._jit.decorators import helper, inline
from ...kernels.numbers.elementary import acos
from ...kernels.numbers.vectors import Vector, dot
from ..sampling import Direction, cosine_direction
from .albedo_tables import AlbedoTables
from .bsdf_sample import SPREAD, BsdfSample, LobeSurface, SurfaceKind, lost_sample, spread_sample
from .material_table import MaterialTable

_SLOPE = 0.5 - 2.0 / (3.0 * math.pi)
_MEAN = 2.0 / 3.0 - 28.0 / (15.0 * math.pi)
_PER_PI = 1.0 / math.pi


def is_diffuse(row: Any) -> bool:
    """Return True: a row that no other kind claims is matte."""
    return True


# Lambert's law


@inline
def is_lambert(row: Any) -> bool:
    """Return whether a matte row is smooth. Its formulas are so short that a call would cost more than they do."""
    return bool(row.roughness == 0.0)


@inline
def evaluate_lambert(at: LobeSurface, o: Direction, i: Direction) -> tuple[float, float, float, float]:
    """Return (r, g, b, density) of Lambert's law for any o and i."""
    lambert = _PER_PI * i[2] if o[2] > 0.0 and i[2] > 0.0 else 0.0
    return at.r * lambert, at.g * lambert, at.b * lambert, lambert


@inline
def sample_lambert(at: LobeSurface, u: float, v: float) -> BsdfSample:
    """Return a weighed direction of Lambert's law: the weight is the reflectance."""
    i = cosine_direction(u, v)
    return BsdfSample(SPREAD, i, at.r, at.g, at.b, _PER_PI * i[2]) if i[2] > 0.0 else lost_sample()


@inline
def lambert_cosine(row: Any, light: Vector, eye: Vector, normal: Vector) -> float:
    """Return Whitted's N·L."""
    return dot(normal[0], normal[1], normal[2], light[0], light[1], light[2])


# Oren and Nayar's law


@inline
def _albedo(z: float, sigma: float) -> float:
    """Return E of the first term for a cosine z."""
    z = min(1.0, z)
    sine = math.sqrt((1.0 - z) * (1.0 + z))
    g = sine * (acos(z) - sine * z) - 2.0 / 3.0 * sine
    # sin (1 - sin³) / cos, without the quotient of two numbers near 0
    g += 2.0 / 3.0 * sine * z * (1.0 + sine + sine * sine) / (1.0 + sine)
    return (1.0 + sigma * g * _PER_PI) / (1.0 + _SLOPE * sigma)


@helper
def oren_nayar(o: Direction, i: Direction, sigma: float) -> tuple[float, float, float]:
    """Return (f of the first term, f of the second without ρ_m, E'), for ρ = 1."""
    a = 1.0 / (1.0 + _SLOPE * sigma)
    s = dot(o[0], o[1], o[2], i[0], i[1], i[2]) - o[2] * i[2]
    t = s / max(o[2], i[2]) if s > 0.0 else s
    mean = a * (1.0 + _MEAN * sigma)
    multiple = (1.0 - _albedo(o[2], sigma)) * (1.0 - _albedo(i[2], sigma)) / (1.0 - mean)
    return _PER_PI * a * (1.0 + sigma * t), _PER_PI * multiple, mean


@inline
def interreflection_color(color: float, mean: float) -> float:
    """Return ρ_m of a colour."""
    return color * color * mean / (1.0 - color * (1.0 - mean))


@inline
def _evaluate(
    materials: MaterialTable, tables: AlbedoTables, at: LobeSurface, o: Direction, i: Direction
) -> tuple[float, float, float, float]:
    if i[2] <= 0.0:
        return 0.0, 0.0, 0.0, 0.0
    once, multiple, mean = oren_nayar(o, i, materials.rows[at.row].roughness)
    r = (at.r * once + interreflection_color(at.r, mean) * multiple) * i[2]
    g = (at.g * once + interreflection_color(at.g, mean) * multiple) * i[2]
    b = (at.b * once + interreflection_color(at.b, mean) * multiple) * i[2]
    return r, g, b, _PER_PI * i[2]


@inline
def _sample(
    materials: MaterialTable, tables: AlbedoTables, at: LobeSurface, o: Direction, choice: float, u: float, v: float
) -> BsdfSample:
    return spread_sample(cosine_direction(u, v))


@inline
def _has_extent(materials: MaterialTable, at: LobeSurface) -> bool:
    return True


DIFFUSE = SurfaceKind(is_diffuse, _evaluate, _sample, _has_extent)
