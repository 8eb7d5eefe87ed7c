"""Light inside transparent solids: indices, absorption (Beer) and scattering (Henyey and Greenstein).

The number of a medium is the row of its material; OUTSIDE is vacuum. The ends of a way through a medium are where its
walls are, exactly; within it the transmittance is T = exp(-(σ_a + σ_s) s).
"""

from __future__ import annotations

import math
from typing import Any

from ..._jit.decorators import helper, inline
from ...kernels.numbers.elementary import exp
from ..sampling import Direction, logarithm, to_world, unit_direction

OUTSIDE = -1


@inline
def body_medium(materials: Any, body: int) -> int:
    """Return the medium inside of a body; OUTSIDE for body -1."""
    return int(materials.row_of[body]) if body >= 0 else OUTSIDE


@inline
def medium_index(materials: Any, medium: int) -> float:
    """Return the refractive index of a medium."""
    return materials.rows[medium].index if medium >= 0 else 1.0


@inline
def is_invisible_wall(materials: Any, body: int, before: int, after: int) -> bool:
    """Return whether light passes the wall of a transparent body as if there were none."""
    if before == after:
        return True
    row = materials.rows[materials.row_of[body]]
    if medium_index(materials, before) != medium_index(materials, after):
        return False
    for k in range(3):
        one = materials.rows[before].absorption[k] if before >= 0 else 0.0
        other = materials.rows[after].absorption[k] if after >= 0 else 0.0
        if (before >= 0 and materials.rows[before].scatters == 1) or (
            after >= 0 and materials.rows[after].scatters == 1
        ):
            return False
        if row.transparency[k] != 1.0 or row.specular[k] != 0.0 or one != other:
            return False
    return True


@inline
def absorb(materials: Any, medium: int, length: float, r: float, g: float, b: float) -> tuple[float, float, float]:
    """Return light rgb after a length in a medium: times exp(-absorption · length) for each channel (Beer)."""
    if medium < 0 or length <= 0.0:
        return r, g, b
    row = materials.rows[medium]
    if row.absorption[0] > 0.0:
        r *= exp(-row.absorption[0] * length)
    if row.absorption[1] > 0.0:
        g *= exp(-row.absorption[1] * length)
    if row.absorption[2] > 0.0:
        b *= exp(-row.absorption[2] * length)
    return r, g, b


# Light transport in homogeneous media: free paths, and turns (Henyey and Greenstein 1941)


@inline
def _fades(row: Any, c: int) -> float:
    """Return σ_a + σ_s of a channel."""
    return float(row.absorption[c] + row.scattering[c])


@helper
def medium_transmittance(materials: Any, medium: int, length: float) -> tuple[float, float, float]:
    """Return the transmittance, rgb, of a length in a medium."""
    if medium < 0 or length <= 0.0:
        return 1.0, 1.0, 1.0
    row = materials.rows[medium]
    r, g, b = _fades(row, 0), _fades(row, 1), _fades(row, 2)
    return (
        exp(-r * length) if r > 0.0 else 1.0, exp(-g * length) if g > 0.0 else 1.0, exp(-b * length) if b > 0.0 else 1.0
    )  # fmt: skip


@helper
def sample_free_path(materials: Any, medium: int, longest: float, u: float) -> tuple[float, float, float, float, bool]:
    """Return (length, r, g, b, whether light is scattered at its end) of a free path, drawn by u in [0, 1).

    r, g, b are its weight. One channel, drawn by chance, gives the length; the densities of all three are averaged
    (one-sample balance heuristic, Veach 1997).
    """
    row = materials.rows[medium]
    channel = min(2, int(3.0 * u))
    left = 1.0 - (3.0 * u - channel)
    rate = _fades(row, channel)
    length = -logarithm(left) / rate if rate > 0.0 and left > 0.0 else math.inf
    if length >= longest:
        r, g, b = medium_transmittance(materials, medium, longest)
        mean = (r + g + b) / 3.0
        return (longest, r / mean, g / mean, b / mean, False) if mean > 0.0 else (longest, 0.0, 0.0, 0.0, False)
    r, g, b = medium_transmittance(materials, medium, length)
    mean = (r * _fades(row, 0) + g * _fades(row, 1) + b * _fades(row, 2)) / 3.0
    if not mean > 0.0:
        return length, 0.0, 0.0, 0.0, True
    sr, sg, sb = row.scattering[0], row.scattering[1], row.scattering[2]
    return length, sr * r / mean, sg * g / mean, sb * b / mean, True


@helper
def phase_function(g: float, cosine: float) -> float:
    """Return the density of turning by an angle, per solid angle: (1 - g²) / (4π (1 + g² - 2 g cos)^(3/2))."""
    t = 1.0 + g * g - 2.0 * g * cosine
    return 0.25 / math.pi * (1.0 - g) * (1.0 + g) / (t * math.sqrt(t)) if t > 0.0 else 0.0


@helper
def sample_phase_function(g: float, d: Direction, u: float, v: float) -> tuple[Direction, float]:
    """Return (a direction that light along unit d turns to, its density)."""
    cosine = 1.0 - 2.0 * u
    if abs(g) > 1e-4:  # below, g is too small a divisor, and turning is even to all sides
        part = (1.0 - g) * (1.0 + g) / (1.0 + g - 2.0 * g * u)
        cosine = min(1.0, max(-1.0, (1.0 + g * g - part * part) / (2.0 * g)))
    return to_world(unit_direction(v, cosine), d), phase_function(g, cosine)
