"""Light within homogeneous media: how far it goes, and how it turns (Henyey and Greenstein 1941).

Ends of a way through a medium are where its walls are, exactly; within it T = exp(-(σ_a + σ_s) s).
"""

from __future__ import annotations

import math
from typing import Any

from ..compiler.jit import helper, inline
from ..engine.numbers.exponential import exp
from .warps import Direction, around, logarithm, to_world


@inline
def _fades(row: Any, c: int) -> float:
    return float(row.absorption[c] + row.scattering[c])


@helper
def transmitted(materials: Any, medium: int, length: float) -> tuple[float, float, float]:
    """Rgb of what a way through a medium lets through."""
    if medium < 0 or length <= 0.0:
        return 1.0, 1.0, 1.0
    row = materials.rows[medium]
    r, g, b = _fades(row, 0), _fades(row, 1), _fades(row, 2)
    return (
        exp(-r * length) if r > 0.0 else 1.0, exp(-g * length) if g > 0.0 else 1.0, exp(-b * length) if b > 0.0 else 1.0
    )  # fmt: skip


@helper
def free_way(materials: Any, medium: int, longest: float, u: float) -> tuple[float, float, float, float, bool]:
    """(length, r, g, b, is it scattered there?) of a way through a medium that scatters; its weight.

    One channel, by chance, says how far; all three that could have said it share the density
    (one-sample balance heuristic, Veach 1997).
    """
    row = materials.rows[medium]
    channel = min(2, int(3.0 * u))
    left = 1.0 - (3.0 * u - channel)
    rate = _fades(row, channel)
    length = -logarithm(left) / rate if rate > 0.0 and left > 0.0 else math.inf
    if length >= longest:
        r, g, b = transmitted(materials, medium, longest)
        mean = (r + g + b) / 3.0
        return (longest, r / mean, g / mean, b / mean, False) if mean > 0.0 else (longest, 0.0, 0.0, 0.0, False)
    r, g, b = transmitted(materials, medium, length)
    mean = (r * _fades(row, 0) + g * _fades(row, 1) + b * _fades(row, 2)) / 3.0
    if not mean > 0.0:
        return length, 0.0, 0.0, 0.0, True
    sr, sg, sb = row.scattering[0], row.scattering[1], row.scattering[2]
    return length, sr * r / mean, sg * g / mean, sb * b / mean, True


@helper
def phase(g: float, cosine: float) -> float:
    """How densely light turns by an angle, per solid angle: (1 - g²) / (4π (1 + g² - 2 g cos)^(3/2))."""
    t = 1.0 + g * g - 2.0 * g * cosine
    return 0.25 / math.pi * (1.0 - g) * (1.0 + g) / (t * math.sqrt(t)) if t > 0.0 else 0.0


@helper
def phase_direction(g: float, d: Direction, u: float, v: float) -> tuple[Direction, float]:
    """(a direction that light along unit d turns to, its density)."""
    cosine = 1.0 - 2.0 * u
    if abs(g) > 1e-4:
        part = (1.0 - g) * (1.0 + g) / (1.0 + g - 2.0 * g * u)
        cosine = min(1.0, max(-1.0, (1.0 + g * g - part * part) / (2.0 * g)))
    return to_world(around(v, cosine), d), phase(g, cosine)
