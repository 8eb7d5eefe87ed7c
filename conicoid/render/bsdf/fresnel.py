"""Reflection and refraction: Fresnel's formulas, Schlick's, the mirrored direction and Snell's law.

The cosines are those of the angles with the normal, in [0, 1]; eta is the index in front over the index behind.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..._jit.decorators import inline
from ...kernels.numbers.vectors import dot


@inline
def dielectric_fresnel(cos1: float, cos2: float, eta: float) -> float:
    """Return Fresnel's reflectance for unpolarised light between two dielectrics.

    cos1, cos2 are the cosines of incidence and refraction, eta = η₁ / η₂.
    R = (r_s² + r_p²) / 2, r_s = (η₁ cos1 - η₂ cos2) / (η₁ cos1 + η₂ cos2),
    r_p = (η₂ cos1 - η₁ cos2) / (η₂ cos1 + η₁ cos2); 1 where reflection is total (cos2 < 0).
    Born and Wolf, Principles of Optics, section 1.5.2.
    """
    if cos2 < 0.0 or (cos1 <= 0.0 and cos2 <= 0.0):
        return 1.0
    s = (eta * cos1 - cos2) / (eta * cos1 + cos2)
    p = (cos1 - eta * cos2) / (cos1 + eta * cos2)
    return 0.5 * (s * s + p * p)


@inline
def schlick(normal_reflectance: float, cosine: float) -> float:
    """Return R = R₀ + (1 - R₀) (1 - cos θ)⁵ (Schlick 1994)."""
    m = 1.0 - cosine
    return normal_reflectance + (1.0 - normal_reflectance) * m * m * m * m * m


@inline
def reflect(dx: float, dy: float, dz: float, nx: float, ny: float, nz: float) -> tuple[float, float, float]:
    """Return d - 2 (d·n) n for a propagating direction d and a unit normal n on either side.

    With L = -d, the direction to the light, it is R = 2 (N·L) N - L (the ray tracing notes).
    """
    twice = 2.0 * dot(dx, dy, dz, nx, ny, nz)
    return dx - twice * nx, dy - twice * ny, dz - twice * nz


@inline
def refract(
    dx: float, dy: float, dz: float, nx: float, ny: float, nz: float, eta: float
) -> tuple[float, float, float, float]:
    """Return (tx, ty, tz, cos θ₂) of unit d refracted at unit n, d·n <= 0; cos θ₂ = -1 where reflection is total.

    eta = η₁ / η₂ is the index in front over the index behind. The part of d along the surface
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


@inline
def conductor_fresnel(cosine: float, index: float, extinction: float) -> float:
    """Return Fresnel's reflectance for unpolarised light of a metal of complex index n + ik, seen from vacuum.

    With a² + b² = |sqrt(η² - sin² θ)|²: R_s = (A - 2 a cos + cos²) / (A + 2 a cos + cos²), A = a² + b²,
    R_p = R_s (A cos² - 2 a cos sin² + sin⁴) / (A cos² + 2 a cos sin² + sin⁴). Born and Wolf, Principles of Optics,
    section 14.2; written out as in Lagarde, Memo on Fresnel equations, 2013.
    """
    c2 = cosine * cosine
    s2 = 1.0 - c2
    t = index * index - extinction * extinction - s2
    both = math.sqrt(t * t + 4.0 * index * index * extinction * extinction)  # a² + b²
    twice = 2.0 * cosine * math.sqrt(max(0.0, 0.5 * (both + t)))  # 2 a cos
    s = (both + c2 - twice) / (both + c2 + twice)
    return 0.5 * s * (1.0 + (c2 * both + s2 * s2 - twice * s2) / (c2 * both + s2 * s2 + twice * s2))


@inline
def dielectric_reflectance(cosine: float, eta: float) -> float:
    """Return Fresnel's reflectance between dielectrics for light at an angle."""
    square = (1.0 - eta) * (1.0 + eta) + (eta * cosine) * (eta * cosine)
    return dielectric_fresnel(cosine, math.sqrt(square), eta) if square >= 0.0 else 1.0


# Arrays of cosines, for tables of albedos. The formulas are those above.


def conductor_reflectances(cosine: Any, index: float, extinction: float) -> Any:
    """Return `conductor_fresnel` of an array of cosines."""
    c2 = cosine * cosine
    s2 = 1 - c2
    t = index**2 - extinction**2 - s2
    both = np.sqrt(t * t + 4 * index**2 * extinction**2)
    twice = 2 * cosine * np.sqrt(np.maximum(0, (both + t) / 2))
    s = (both + c2 - twice) / (both + c2 + twice)
    return s * (1 + (c2 * both + s2 * s2 - twice * s2) / (c2 * both + s2 * s2 + twice * s2)) / 2


def dielectric_reflectances(cosine: Any, eta: float) -> Any:
    """Return `dielectric_reflectance` of an array of cosines."""
    square = (1 - eta) * (1 + eta) + (eta * cosine) ** 2
    beyond = np.sqrt(np.maximum(square, 0))
    s = (eta * cosine - beyond) / np.maximum(eta * cosine + beyond, 1e-300)
    p = (cosine - eta * beyond) / np.maximum(cosine + eta * beyond, 1e-300)
    return np.where((square < 0) | (cosine <= 0), 1.0, (s * s + p * p) / 2)
