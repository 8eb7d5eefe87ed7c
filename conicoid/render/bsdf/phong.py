"""Glossy surfaces: a matte colour with a highlight, Phong's or the half-vector's, and Whitted's highlights.

For light transport a highlight has the exponent of Phong or Blinn, scaled so that it sends on no more than arrives.
Phong's: f = (n + 2) / (2π) cos^n of the angle to the mirrored direction (Lafortune and Willems 1994).
Blinn's: f = (n + 8) / (8π) ... is too much along the surface; here it is D / (4 max(o_z, i_z)),
D = (n + 2) / (2π) cos^n of the half-vector (Neumann, Neumann and Szirmay-Kalos, Compact metallic reflectance
models, 1999).
"""

from __future__ import annotations

import math
from typing import Any

from ..._jit.decorators import helper, inline
from ...kernels.numbers.elementary import power
from ...kernels.numbers.vectors import Vector, dot, normalize
from ..sampling import Direction, cosine_direction, to_world, unit_direction
from .albedo_tables import AlbedoTables
from .bsdf_sample import BsdfSample, LobeProbabilities, LobeSurface, SurfaceKind, lost_sample, mean_rgb, spread_sample
from .material_table import MaterialTable
from .microfacet import half_direction, mirror_direction, reflect

_PER_PI = 1.0 / math.pi
_PER_TURN = 0.5 / math.pi


def is_glossy(row: Any) -> bool:
    """Return whether a material has highlights."""
    return bool((row["specular"] > 0).any())


# Whitted's highlights. All vectors are unit: `light` to the light, `eye` to the eye.


@inline
def phong(light: Vector, eye: Vector, normal: Vector, shininess: float) -> float:
    """Return (R·E)^n with R = 2 (N·L) N - L; 0 where R points away from the eye."""
    (lx, ly, lz), (ex, ey, ez), (nx, ny, nz) = light, eye, normal
    rx, ry, rz = reflect(-lx, -ly, -lz, nx, ny, nz)
    cosine = dot(rx, ry, rz, ex, ey, ez)
    return power(cosine, shininess) if cosine > 0.0 else 0.0


@inline
def half_vector(light: Vector, eye: Vector, normal: Vector, shininess: float) -> float:
    """Return (H·N)^n with H = (L + E) / |L + E|; 0 where H points into the surface."""
    (lx, ly, lz), (ex, ey, ez), (nx, ny, nz) = light, eye, normal
    hx, hy, hz = normalize(lx + ex, ly + ey, lz + ez)
    cosine = dot(hx, hy, hz, nx, ny, nz)
    return power(cosine, shininess) if cosine > 0.0 else 0.0


@inline
def material_highlight(row: Any, light: Vector, eye: Vector, normal: Vector) -> float:
    """Return a material's highlight, by the one of both formulas that it names."""
    if row.half_vector == 1:
        return half_vector(light, eye, normal, row.shininess)
    return phong(light, eye, normal, row.shininess)


# Lobes of light transport


@helper
def evaluate_phong(row: Any, o: Direction, i: Direction) -> tuple[float, float]:
    """Return (f cos for a highlight of strength 1, density of i by `sample_phong`)."""
    n = row.shininess
    if row.half_vector == 1:
        h = half_direction(o, i)
        falls = power(max(0.0, h[2]), n) * _PER_TURN
        along = dot(o[0], o[1], o[2], h[0], h[1], h[2])
        if along <= 0.0:
            return 0.0, 0.0
        return (n + 2.0) * falls / (4.0 * max(o[2], i[2])) * i[2], (n + 1.0) * falls / (4.0 * along)
    cosine = o[2] * i[2] - o[0] * i[0] - o[1] * i[1]
    if cosine <= 0.0:
        return 0.0, 0.0
    falls = power(cosine, n) * _PER_TURN
    return (n + 2.0) * falls * i[2], (n + 1.0) * falls


@inline
def sample_phong(row: Any, o: Direction, u: float, v: float) -> Direction:
    """Return a direction of a highlight. It may point under the surface, where `evaluate` gives 0."""
    axis = unit_direction(v, power(1.0 - u, 1.0 / (row.shininess + 1.0)))
    if row.half_vector == 1:
        return mirror_direction(o, axis)
    return to_world(axis, (-o[0], -o[1], o[2]))


@inline
def _lobes(row: Any, at: LobeSurface) -> LobeProbabilities:
    """Return about the shares of light that the highlight and the colour send on."""
    sharp = mean_rgb(row.specular[0], row.specular[1], row.specular[2])
    soft = mean_rgb(at.r, at.g, at.b) * (1.0 - sharp)
    return LobeProbabilities(sharp / (sharp + soft), soft / (sharp + soft), 0.0, 0.0)


@inline
def _evaluate(
    materials: MaterialTable, tables: AlbedoTables, at: LobeSurface, o: Direction, i: Direction
) -> tuple[float, float, float, float]:
    if i[2] <= 0.0:
        return 0.0, 0.0, 0.0, 0.0
    row, lambert = materials.rows[at.row], _PER_PI * i[2]
    lobes = _lobes(row, at)
    shine, density = evaluate_phong(row, o, i)
    sr, sg, sb = row.specular[0], row.specular[1], row.specular[2]
    return (
        at.r * (1.0 - sr) * lambert + sr * shine, at.g * (1.0 - sg) * lambert + sg * shine,
        at.b * (1.0 - sb) * lambert + sb * shine, lobes.mirror * density + lobes.matte * lambert,
    )  # fmt: skip


@inline
def _sample(
    materials: MaterialTable, tables: AlbedoTables, at: LobeSurface, o: Direction, choice: float, u: float, v: float
) -> BsdfSample:
    row = materials.rows[at.row]
    lobes = _lobes(row, at)
    if choice < lobes.mirror:
        return spread_sample(sample_phong(row, o, u, v))
    if choice - lobes.mirror < lobes.matte:
        return spread_sample(cosine_direction(u, v))
    return lost_sample()


@inline
def _has_extent(materials: MaterialTable, at: LobeSurface) -> bool:
    return True


PHONG = SurfaceKind(is_glossy, _evaluate, _sample, _has_extent)
