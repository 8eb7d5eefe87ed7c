"""The first crossing that a ray has met so far: what is kept of it, and which of two is the nearer."""

from __future__ import annotations

import math
from typing import Any, TypeAlias

import numpy as np

from ...compiler.jit import inline
from ..tables import Geometry
from .entry import crossed_face

Hit: TypeAlias = tuple[float, Any, Any, Any, Any, Any, float, Any]
"""t, body, entry, place, sense, entered: `crossed_face` makes the middle ones a surface, a face and a side.

Then by how much rounding may have moved t, and whether anything of the answer is doubtful for it."""


@inline
def no_hit() -> Hit:
    nothing = np.int64(-1)
    return math.inf, nothing, nothing, nothing, np.int64(1), False, 0.0, False


@inline
def certain(hit: Hit, off: float, unsure: bool) -> Hit:
    """A hit with what is said of its certainty."""
    return hit[0], hit[1], hit[2], hit[3], hit[4], hit[5], off, unsure


@inline
def within(hit: Hit) -> float:
    """Nothing beyond can be the nearer crossing."""
    return hit[0] + hit[6]


@inline
def nearer(geometry: Geometry, best: Hit, new: Hit) -> Hit:
    """The nearer of two hits; equal t goes to the body listed first.

    Where rounding might have changed which it is, the answer is doubtful; not where both are on the same
    surface: then they are at the same t, whatever it is.
    """
    unsure = best[7] | new[7]
    if abs(new[0] - best[0]) <= new[6] + best[6]:
        unsure |= new[0] != best[0] or resolved_surface(geometry, new) != resolved_surface(geometry, best)
    closer = new[0] < best[0] or (new[0] == best[0] and new[1] < best[1])
    return certain(new, new[6], unsure) if closer else certain(best, best[6], unsure)


@inline
def resolved_surface(geometry: Geometry, hit: Hit) -> int:
    """The surface of a hit."""
    return crossed_face(geometry, hit[2], hit[3], hit[4])[0]


@inline
def _unscaled(best: Hit, scale: float) -> Hit:
    return best[0] * scale, best[1], best[2], best[3], best[4], best[5], best[6] * scale, best[7]


@inline
def resolved(geometry: Geometry, hit: Hit) -> tuple[float, int, int, int, int]:
    """(t, body, surface, face, side) of a hit; ids -1 for a miss."""
    t, body, entry, place, sense, _, _, _ = hit
    if entry < 0:
        return t, body, entry, entry, sense
    surface, face, side = crossed_face(geometry, entry, place, sense)
    return t, body, surface, face, side


DOUBTFUL = 32
"""Added to the turn of a hit, or miss, that rounding might have changed."""


@inline
def turn_of(hit: Hit) -> Any:
    """The sense of a hit's leaf, doubled where the body is entered, raised if doubtful."""
    return (2 * hit[4] if hit[5] else hit[4]) + (DOUBTFUL if hit[7] else 0)
