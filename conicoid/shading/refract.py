"""Snell's law."""

from __future__ import annotations

import math

from ..compiler.jit import inline
from ..engine.numbers.vectors import dot


@inline
def refract(
    dx: float, dy: float, dz: float, nx: float, ny: float, nz: float, eta: float
) -> tuple[float, float, float, float]:
    """(tx, ty, tz, cos θ₂) of unit d through unit n, d·n <= 0; cos θ₂ = -1 where reflection is total.

    eta = η₁ / η₂, index where the ray comes from over index beyond. The part of d along the surface
    is scaled by eta (that is Snell's law), the part along -n makes up the length:
    t = eta (d - (d·n) n) - cos θ₂ n, with cos² θ₂ = 1 - eta² sin² θ₁ = (1 - eta²) + (eta cos θ₁)². The same as
    T = -eta L + (eta cos θ₁ - cos θ₂) N of the ray tracing notes with L = -d, without its cancellations.
    """
    along = dot(dx, dy, dz, nx, ny, nz)
    square = (1.0 - eta) * (1.0 + eta) + (eta * along) * (eta * along)
    if square < 0.0:
        return 0.0, 0.0, 0.0, -1.0
    cosine = math.sqrt(square)
    return (
        eta * (dx - along * nx) - cosine * nx,
        eta * (dy - along * ny) - cosine * ny,
        eta * (dz - along * nz) - cosine * nz,
        cosine,
    )
