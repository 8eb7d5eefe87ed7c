"""Highlights: Phong's and the half-vector's. All vectors are unit; L to the light, E to the eye."""

from __future__ import annotations

from ..compiler.jit import inline
from ..engine.numbers.exponential import power
from ..engine.numbers.vectors import dot, normalized
from .reflect import reflect


@inline
def phong(
    lx: float, ly: float, lz: float, ex: float, ey: float, ez: float, nx: float, ny: float, nz: float, shininess: float
) -> float:
    """(R·E)^n with R = 2 (N·L) N - L; 0 where R points away from the eye."""
    rx, ry, rz = reflect(-lx, -ly, -lz, nx, ny, nz)
    cosine = dot(rx, ry, rz, ex, ey, ez)
    return power(cosine, shininess) if cosine > 0.0 else 0.0


@inline
def half_vector(
    lx: float, ly: float, lz: float, ex: float, ey: float, ez: float, nx: float, ny: float, nz: float, shininess: float
) -> float:
    """(H·N)^n with H = (L + E) / |L + E|; 0 where H points into the surface."""
    hx, hy, hz = normalized(lx + ex, ly + ey, lz + ez)
    cosine = dot(hx, hy, hz, nx, ny, nz)
    return power(cosine, shininess) if cosine > 0.0 else 0.0
