"""The elliptic cylinder."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from .elliptic import EllipticSolid, Profile
from .validate import interval, positive
from .vector import Interval


@dataclass(frozen=True)
class EllipticCylinder(EllipticSolid):
    """A x² + E y² <= 1, cut by `z_range`: a cylinder about z with the half-axes 1 / sqrt(A) and 1 / sqrt(E).

    Faces: 0 side, 1 the cap at z_range[0], 2 the cap at z_range[1].
    uv: (angle of (x, y) / 360, height scaled from the range to [0, 1]), v = z without one; on the caps
    (x, y) in units of the half-axes.
    Source: the ray tracing notes, canonical quadric 5a.
    """

    A: float
    E: float
    z_range: Interval | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "A", positive("EllipticCylinder", "A", self.A))
        object.__setattr__(self, "E", positive("EllipticCylinder", "E", self.E))
        object.__setattr__(self, "z_range", interval("EllipticCylinder", "z_range", self.z_range))

    @property
    def squares(self) -> tuple[Any, Any]:
        return self.A, self.E

    @property
    def profile(self) -> Profile:
        return 1, 0, 0
