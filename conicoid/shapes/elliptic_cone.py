"""The elliptic cone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from .elliptic import EllipticSolid, Profile
from .validate import interval, positive
from .vector import Interval


@dataclass(frozen=True)
class EllipticCone(EllipticSolid):
    """A x² + E y² - H z² <= 0, cut by `z_range`: both nappes about z, the apex at the origin.

    At z = h the section has the half-axes |h| sqrt(H / A) and |h| sqrt(H / E).
    Faces: 0 both nappes, 1 the cap at z_range[0], 2 the cap at z_range[1]. The apex has the axis for its normal.
    uv: (angle of (x, y) / 360, height scaled from the range to [0, 1]), v = z without one; on the caps
    (x, y) in units of the half-axes.
    Source: the ray tracing notes, canonical quadric 4.
    """

    A: float
    E: float
    H: float
    z_range: Interval | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "A", positive("EllipticCone", "A", self.A))
        object.__setattr__(self, "E", positive("EllipticCone", "E", self.E))
        object.__setattr__(self, "H", positive("EllipticCone", "H", self.H))
        object.__setattr__(self, "z_range", interval("EllipticCone", "z_range", self.z_range))

    @property
    def squares(self) -> tuple[Any, Any]:
        return self.A, self.E

    @property
    def profile(self) -> Profile:
        return 0, 0, self.H
