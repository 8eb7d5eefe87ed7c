"""Microfacets, little mirrors that make up rough surfaces: Trowbridge and Reitz's distribution (GGX) of roughness α.

D(h) = 1 / (π α² ((hx² + hy²) / α² + hz²)²), Smith's shadowing with correlated heights
G₂ = 1 / (1 + Λ(o) + Λ(i)), Λ = (sqrt(1 + α² tan² θ) - 1) / 2. Heitz, Understanding the masking-shadowing
function in microfacet-based BRDFs, JCGT 3(2), 2014.

Reflection and refraction: Fresnel's formulas, Schlick's, the mirrored direction and Snell's law.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..._jit.decorators import inline
from ...kernels.numbers.elementary import cos_sin_turns
from ...kernels.numbers.vectors import dot, normalize
from ..sampling import Direction


@inline
def ggx_density(h: Direction, alpha: float) -> float:
    """Return D(h), the density of the normals of facets about unit h."""
    x, y, z = h
    square = alpha * alpha
    t = (x * x + y * y) / square + z * z
    return 1.0 / (math.pi * square * t * t)


@inline
def smith_lambda(d: Direction, alpha: float) -> float:
    """Return Smith's Λ of a direction: the hidden part over the visible part of the facets that face it."""
    z2 = d[2] * d[2]
    return 0.5 * (math.sqrt(1.0 + alpha * alpha * max(0.0, 1.0 - z2) / z2) - 1.0) if z2 > 0.0 else math.inf


@inline
def sample_visible_normal(o: Direction, alpha: float, u: float, v: float) -> Direction:
    """Return a normal h of the facets visible from o, of density max(0, o·h) D(h) / (o_z (1 + Λ(o))).

    Dupuy and Benyoub, Sampling visible GGX normals with spherical caps, CGF 42(8), 2023.
    """
    x, y, z = normalize(alpha * o[0], alpha * o[1], o[2])
    c, s = cos_sin_turns(u)
    height = (1.0 - v) * (1.0 + z) - z
    r = math.sqrt(max(0.0, (1.0 - height) * (1.0 + height)))
    return normalize(alpha * (r * c + x), alpha * (r * s + y), max(0.0, height + z))


@inline
def mirror_direction(o: Direction, h: Direction) -> Direction:
    """Return o mirrored at a facet of normal h."""
    factor = 2.0 * dot(o[0], o[1], o[2], h[0], h[1], h[2])
    return factor * h[0] - o[0], factor * h[1] - o[1], factor * h[2] - o[2]


@inline
def half_direction(o: Direction, i: Direction) -> Direction:
    """Return the normal of the mirror that takes o to i."""
    return normalize(o[0] + i[0], o[1] + i[1], o[2] + i[2])


@inline
def evaluate_ggx(o: Direction, i: Direction, alpha: float) -> tuple[float, float]:
    """Return (f cos of rough mirrors without Fresnel's factor, the density of i).

    D G₂ / (4 o_z) and D / (4 o_z (1 + Λ(o))).
    """
    h = half_direction(o, i)
    density, own = ggx_density(h, alpha), smith_lambda(o, alpha)
    once = density / (4.0 * o[2])
    return once / (1.0 + own + smith_lambda(i, alpha)), once / (1.0 + own)


# Reflection and refraction: Fresnel's formulas, Schlick's, the mirrored direction and Snell's law.
#
# The cosines are those of the angles with the normal, in [0, 1]; eta is the index in front over the index behind.


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
