"""Microfacets, little mirrors that make up rough surfaces: Trowbridge and Reitz's distribution (GGX) of roughness α.

D(h) = 1 / (π α² ((hx² + hy²) / α² + hz²)²), Smith's shadowing with correlated heights
G₂ = 1 / (1 + Λ(o) + Λ(i)), Λ = (sqrt(1 + α² tan² θ) - 1) / 2. Heitz, Understanding the masking-shadowing
function in microfacet-based BRDFs, JCGT 3(2), 2014.
"""

from __future__ import annotations

import math

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
    twice = 2.0 * dot(o[0], o[1], o[2], h[0], h[1], h[2])
    return twice * h[0] - o[0], twice * h[1] - o[1], twice * h[2] - o[2]


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
