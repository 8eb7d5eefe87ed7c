"""How much light a metal reflects, and means of reflectances over all directions."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..compiler.jit import inline
from ..shading.fresnel import dielectric


@inline
def conductor(cosine: float, index: float, extinction: float) -> float:
    """Fresnel's reflectance for unpolarised light of a metal of complex index n + ik, seen from vacuum.

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
def wall(cosine: float, eta: float) -> float:
    """Fresnel's reflectance between dielectrics for light at an angle; eta: index it comes from over index beyond."""
    square = (1.0 - eta) * (1.0 + eta) + (eta * cosine) * (eta * cosine)
    return dielectric(cosine, math.sqrt(square), eta) if square >= 0.0 else 1.0


def conductors(cosine: Any, index: float, extinction: float) -> Any:
    """`conductor` of an array of cosines."""
    c2 = cosine * cosine
    s2 = 1 - c2
    t = index**2 - extinction**2 - s2
    both = np.sqrt(t * t + 4 * index**2 * extinction**2)
    twice = 2 * cosine * np.sqrt(np.maximum(0, (both + t) / 2))
    s = (both + c2 - twice) / (both + c2 + twice)
    return s * (1 + (c2 * both + s2 * s2 - twice * s2) / (c2 * both + s2 * s2 + twice * s2)) / 2


def walls(cosine: Any, eta: float) -> Any:
    """`wall` of an array of cosines."""
    square = (1 - eta) * (1 + eta) + (eta * cosine) ** 2
    beyond = np.sqrt(np.maximum(square, 0))
    s = (eta * cosine - beyond) / np.maximum(eta * cosine + beyond, 1e-300)
    p = (cosine - eta * beyond) / np.maximum(cosine + eta * beyond, 1e-300)
    return np.where((square < 0) | (cosine <= 0), 1.0, (s * s + p * p) / 2)
