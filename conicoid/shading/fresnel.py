"""How much light a surface reflects."""

from __future__ import annotations

from ..compiler.jit import inline


@inline
def dielectric(cos1: float, cos2: float, eta: float) -> float:
    """Fresnel's reflectance for unpolarised light between two dielectrics.

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
    """R = R₀ + (1 - R₀) (1 - cos θ)⁵ (Schlick 1994)."""
    m = 1.0 - cosine
    return normal_reflectance + (1.0 - normal_reflectance) * m * m * m * m * m
