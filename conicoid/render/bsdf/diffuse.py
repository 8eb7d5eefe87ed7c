"""Matte surfaces, smooth (Lambert) or rough: Oren and Nayar's in the form that loses no energy.

Portsmouth, Kutz and Hill, EON: A practical energy-preserving rough diffuse BRDF, JCGT 14(1), 2025, after Fujii's
form of Oren and Nayar's model. With roughness σ in [0, 1], A = 1 / (1 + (1/2 - 2/(3π)) σ), s = i·o - i_z o_z:
    f = ρ A / π (1 + σ s / t) + ρ_m / π (1 - E(i)) (1 - E(o)) / (1 - E'), t = max(i_z, o_z) where s > 0, else 1,
where E is the first term's albedo for ρ = 1, E' its mean and ρ_m = ρ² E' / (1 - ρ (1 - E')) what is scattered again.
"""

from __future__ import annotations

import math

from ..._jit.decorators import helper, inline
from ...kernels.numbers.elementary import acos
from ...kernels.numbers.vectors import dot
from ..sampling import Direction

_SLOPE = 0.5 - 2.0 / (3.0 * math.pi)
_MEAN = 2.0 / 3.0 - 28.0 / (15.0 * math.pi)
_PER_PI = 1.0 / math.pi


@inline
def _albedo(z: float, sigma: float) -> float:
    """E of the first term, for a cosine z."""
    z = min(1.0, z)
    sine = math.sqrt((1.0 - z) * (1.0 + z))
    g = sine * (acos(z) - sine * z) - 2.0 / 3.0 * sine
    # sin (1 - sin³) / cos, without the quotient of two numbers near 0
    g += 2.0 / 3.0 * sine * z * (1.0 + sine + sine * sine) / (1.0 + sine)
    return (1.0 + sigma * g * _PER_PI) / (1.0 + _SLOPE * sigma)


@helper
def oren_nayar(o: Direction, i: Direction, sigma: float) -> tuple[float, float, float]:
    """(f of the first term, of the second but for ρ_m, E'), for ρ = 1."""
    a = 1.0 / (1.0 + _SLOPE * sigma)
    s = dot(o[0], o[1], o[2], i[0], i[1], i[2]) - o[2] * i[2]
    t = s / max(o[2], i[2]) if s > 0.0 else s
    mean = a * (1.0 + _MEAN * sigma)
    again = (1.0 - _albedo(o[2], sigma)) * (1.0 - _albedo(i[2], sigma)) / (1.0 - mean)
    return _PER_PI * a * (1.0 + sigma * t), _PER_PI * again, mean


@inline
def interreflection_color(color: float, mean: float) -> float:
    """ρ_m of a colour."""
    return color * color * mean / (1.0 - color * (1.0 - mean))
