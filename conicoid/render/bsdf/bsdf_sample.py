"""What of a surface its lobes depend on, and what comes of light there."""

from __future__ import annotations

from typing import Any, NamedTuple

from ..._jit.decorators import inline
from ..sampling import Direction
from .albedo_tables import SMOOTH

LOST, SPREAD, SHARP, STRAIGHT = -1, 0, 1, 2
"""What became of light: it is absorbed; went into a lobe with an extent; into one direction; went on as if nothing were
there."""


class LobeSurface(NamedTuple):
    """What of a surface its lobes depend on."""

    row: Any  # int64: of its material
    r: float  # its diffuse reflectance
    g: float
    b: float
    refracts: bool  # the wall of a transparent solid
    outside: bool  # seen from outside of the body
    eta: float  # index on the side of o over that beyond; of what refracts


class BsdfSample(NamedTuple):
    """A direction, and by what light that comes from there is weighed."""

    how: Any  # int64: LOST, SPREAD, SHARP, STRAIGHT
    i: Direction
    r: float
    g: float
    b: float
    density: float  # per solid angle, of SPREAD


class LobeProbabilities(NamedTuple):
    """How likely each lobe is to be drawn; they add up to 1 at most, the rest is lost."""

    mirror: float
    matte: float
    through: float
    beyond: float  # scattered on the other side


@inline
def lost_sample() -> BsdfSample:
    """Light that is lost."""
    return BsdfSample(LOST, (0.0, 0.0, 1.0), 0.0, 0.0, 0.0, 0.0)


@inline
def mean_rgb(r: float, g: float, b: float) -> float:
    return (r + g + b) * (1.0 / 3.0)


@inline
def is_rough(row: Any) -> bool:
    return bool(row.roughness > SMOOTH)
