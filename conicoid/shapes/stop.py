"""The stop: a flat ring with a round opening."""

from __future__ import annotations

from dataclasses import dataclass

from .base import PrimitiveSheet
from .cells import SurfaceSheet, flat, moved_uv
from .conic import ring_between
from .conic_wall import plane
from .motion import Motion
from .rounded import hypot
from .validate import positive
from .vector import Vector


@dataclass(frozen=True)
class Stop(PrimitiveSheet):
    """z = 0, aperture / 2 <= r <= diameter / 2: a thin screen with an opening of the diameter `aperture`.

    The normal is that of `ConicSheet`, towards negative z. Light is stopped by whatever opaque material the body has.
    Face 0. uv: (x, y) / (diameter / 2).
    """

    aperture: float
    diameter: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "aperture", positive("Stop", "aperture", self.aperture))
        object.__setattr__(self, "diameter", positive("Stop", "diameter", self.diameter))
        if not self.aperture < self.diameter:
            raise ValueError(f"Stop: aperture must be below diameter = {self.diameter:g}, got {self.aperture:g}")

    def sheet(self, motion: Motion) -> SurfaceSheet:
        r = self.diameter / 2
        uv = moved_uv(flat((r, 0, 0), (0, r, 0)), motion)
        return SurfaceSheet(plane(1, 0.0).moved(motion), ring_between(self.aperture / 2, r, motion), -1, uv=uv)

    def support(self, direction: Vector) -> float:
        return self.diameter / 2 * hypot(direction[0], direction[1])
