"""Highlights: Phong's and the half-vector's. All vectors are unit: `light` to the light, `eye` to the eye."""

from __future__ import annotations

import math
from typing import Any

from ..._jit.decorators import helper, inline
from ...kernels.numbers.elementary import power
from ...kernels.numbers.vectors import Vector, dot, normalize
from ..sampling import Direction, to_world, unit_direction
from .fresnel import reflect
from .microfacet import half_direction, mirror_direction


@inline
def phong(light: Vector, eye: Vector, normal: Vector, shininess: float) -> float:
    """(R·E)^n with R = 2 (N·L) N - L; 0 where R points away from the eye."""
    (lx, ly, lz), (ex, ey, ez), (nx, ny, nz) = light, eye, normal
    rx, ry, rz = reflect(-lx, -ly, -lz, nx, ny, nz)
    cosine = dot(rx, ry, rz, ex, ey, ez)
    return power(cosine, shininess) if cosine > 0.0 else 0.0


@inline
def half_vector(light: Vector, eye: Vector, normal: Vector, shininess: float) -> float:
    """(H·N)^n with H = (L + E) / |L + E|; 0 where H points into the surface."""
    (lx, ly, lz), (ex, ey, ez), (nx, ny, nz) = light, eye, normal
    hx, hy, hz = normalize(lx + ex, ly + ey, lz + ez)
    cosine = dot(hx, hy, hz, nx, ny, nz)
    return power(cosine, shininess) if cosine > 0.0 else 0.0


# Highlights with an extent, by the exponents of Phong and Blinn, so that they send on no more than arrives.
#
# Phong's: f = (n + 2) / (2π) cos^n of the angle to the mirrored direction (Lafortune and Willems 1994).
# Blinn's: f = (n + 8) / (8π) ... is too much along the surface; here it is D / (4 max(o_z, i_z)),
# D = (n + 2) / (2π) cos^n of the half-vector (Neumann, Neumann and Szirmay-Kalos, Compact metallic reflectance
# models, 1999).

_PER_TURN = 0.5 / math.pi


@helper
def evaluate_phong(row: Any, o: Direction, i: Direction) -> tuple[float, float]:
    """(f cos for a highlight of strength 1, density of i by `glossy_direction`)."""
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
    """A direction of a highlight; under the surface where nothing is sent on."""
    axis = unit_direction(v, power(1.0 - u, 1.0 / (row.shininess + 1.0)))
    if row.half_vector == 1:
        return mirror_direction(o, axis)
    return to_world(axis, (-o[0], -o[1], o[2]))
