"""Mirror reflection."""

from __future__ import annotations

from ..compiler.jit import inline
from ..engine.numbers.vectors import dot


@inline
def reflect(dx: float, dy: float, dz: float, nx: float, ny: float, nz: float) -> tuple[float, float, float]:
    """d - 2 (d·n) n for a propagating direction d and a unit normal n on either side.

    With L = -d, the direction to the light, it is R = 2 (N·L) N - L (the ray tracing notes).
    """
    twice = 2.0 * dot(dx, dy, dz, nx, ny, nz)
    return dx - twice * nx, dy - twice * ny, dz - twice * nz
