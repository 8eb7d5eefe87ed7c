"""Light inside transparent solids. A medium is named by the row of its material; OUTSIDE is vacuum."""

from __future__ import annotations

from typing import Any

from ..compiler.jit import inline
from ..engine.numbers.exponential import exp

OUTSIDE = -1


@inline
def medium_of(materials: Any, body: int) -> int:
    """The medium inside of a body, or outside of all (-1)."""
    return int(materials.row_of[body]) if body >= 0 else OUTSIDE


@inline
def index_of(materials: Any, medium: int) -> float:
    """Refractive index of a medium."""
    return materials.rows[medium].index if medium >= 0 else 1.0


@inline
def unseen(materials: Any, body: int, before: int, after: int) -> bool:
    """Does light pass the wall of a transparent body as if nothing were there?"""
    if before == after:
        return True
    row = materials.rows[materials.row_of[body]]
    if index_of(materials, before) != index_of(materials, after):
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
def absorbed(materials: Any, medium: int, length: float, r: float, g: float, b: float) -> tuple[float, float, float]:
    """Light after a length of way through a medium: exp(-absorption · length) for each channel (Beer)."""
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
