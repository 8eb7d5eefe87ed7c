"""Highlights: Phong's and the half-vector's. All vectors are unit: `light` to the light, `eye` to the eye."""

from __future__ import annotations

from ..compiler.jit import inline
from ..engine.numbers.exponential import power
from ..engine.numbers.vectors import Vector, dot, normalized
from .reflect import reflect


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
    hx, hy, hz = normalized(lx + ex, ly + ey, lz + ez)
    cosine = dot(hx, hy, hz, nx, ny, nz)
    return power(cosine, shininess) if cosine > 0.0 else 0.0
