"""What the tile loop hands to an integrator: records, so that a field more changes no integrator."""

from __future__ import annotations

from typing import Any, NamedTuple

from ..geometry.tables import Floats
from ..jit import allocator
from ..trace.packet import Packet


class Settings(NamedTuple):
    """The same for all of a picture. Each integrator has a kernel of its own, which knows the type of `look`."""

    samples: int  # rays per pixel
    seed: int
    depth: int  # reflections and refractions of a ray, at most
    look: Any  # Look; None for integrators that are not `lit`


class Samples(NamedTuple):
    """One camera ray through each of up to 64 pixels, in the first lanes of a packet."""

    packet: Packet
    colors: Floats  # (64, channels of the film) sums, to which the integrator adds
    size: int  # how many rays there are


@allocator
def no_memory(settings: Settings) -> None:
    """For integrators that keep nothing from one packet to the next."""
