"""The first crossing that a ray has met so far: what is kept of it, and which of two is the nearer."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ...compiler.jit import inline
from ..tables import Geometry
from .entry import crossed_face

DOUBTFUL = 32
"""Added to the turn (`turn_of`) of a hit, or miss, that rounding might have changed."""


class Hit(NamedTuple):
    """A crossing with a body, or a miss: t = inf and ids -1. `crossed_face` makes a surface, face and side of it."""

    t: float
    body: Any  # int64, as the three that follow
    entry: Any
    place: Any  # of the face, see body/cell.py
    sense: Any  # of the leaf that the face belongs to: -1 where its complement counts
    enters: Any  # bool: against the body's outward normal
    off: float  # by how much rounding may have moved t
    unsure: Any  # bool: might rounding have changed anything of the answer?


class Crossed(NamedTuple):
    """A crossing as it is reported; t = inf and ids -1 for a miss."""

    t: float
    body: Any  # int64, as those that follow
    surface: Any
    face: Any
    side: Any  # -1 where the surface's own normal points into the body, else 1


@inline
def no_hit() -> Hit:
    """A miss."""
    nothing = np.int64(-1)
    return Hit(math.inf, nothing, nothing, nothing, np.int64(1), False, 0.0, False)


@inline
def doubted(hit: Hit, unsure: bool) -> Hit:
    """The same hit, doubtful also where `unsure`. A hit never becomes certain again."""
    return Hit(hit.t, hit.body, hit.entry, hit.place, hit.sense, hit.enters, hit.off, hit.unsure | unsure)


@inline
def scaled_hit(hit: Hit, scale: float) -> Hit:
    """A hit of a ray whose direction is to be `scale` times as short."""
    return Hit(hit.t * scale, hit.body, hit.entry, hit.place, hit.sense, hit.enters, hit.off * scale, hit.unsure)


@inline
def within(hit: Hit) -> float:
    """The t beyond which no crossing can be nearer, whatever rounding did: where culling may cut the ray off."""
    return hit.t + hit.off


@inline
def comes_first(t: float, body: int, other_t: float, other_body: int) -> bool:
    """The rule of ties: the nearer of two crossings; at equal t that of the body listed first.

    A miss is at t = inf with a body of any number: against another (body -1) it never comes first.
    """
    return (t < other_t) | ((t == other_t) & (body < other_body))


@inline
def too_close(t: float, off: float, other_t: float, other_off: float) -> bool:
    """Might rounding have changed which of two crossings is the nearer?"""
    return abs(t - other_t) <= off + other_off


@inline
def nearer(geometry: Geometry, best: Hit, new: Hit) -> Hit:
    """The nearer of two hits, by `comes_first`.

    Where rounding might have changed which it is, the answer is doubtful; not where both are on the same
    surface: then they are at the same t, whatever it is. Which hit is kept does not depend on the order of
    comparisons, so that routes that traverse differently agree.
    """
    unsure = best.unsure | new.unsure
    if too_close(new.t, new.off, best.t, best.off):
        unsure |= new.t != best.t or resolved_surface(geometry, new) != resolved_surface(geometry, best)
    if comes_first(new.t, new.body, best.t, best.body):
        return doubted(new, unsure)
    return doubted(best, unsure)


@inline
def resolved_surface(geometry: Geometry, hit: Hit) -> int:
    """The surface of a hit."""
    return crossed_face(geometry, hit.entry, hit.place, hit.sense)[0]


@inline
def resolved(geometry: Geometry, hit: Hit) -> Crossed:
    """A hit as it is reported."""
    if hit.entry < 0:
        return Crossed(hit.t, hit.body, hit.entry, hit.entry, hit.sense)
    surface, face, side = crossed_face(geometry, hit.entry, hit.place, hit.sense)
    return Crossed(hit.t, hit.body, surface, face, side)


@inline
def is_doubtful(turn: Any) -> Any:
    """Is a hit of this turn (or an array of them) one that rounding might have changed?"""
    return turn > DOUBTFUL // 2


@inline
def turn_of(hit: Hit) -> Any:
    """Sense, entering and doubt of a hit in one small integer: the sense, doubled where entered, + DOUBTFUL."""
    return (2 * hit.sense if hit.enters else hit.sense) + (DOUBTFUL if hit.unsure else 0)
